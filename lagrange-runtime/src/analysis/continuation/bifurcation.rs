//! Bifurcations between two neighbouring points of a curve: located, and verified where they are.
//!
//! A sign that changes between two points says that something happened if both are on one curve. Each candidate is
//! therefore solved for by equations of its own, and accepted if it fulfils them to rounding and lies on the curve;
//! otherwise the step is made anew, shorter. Branch points fulfil (Moore 1980; Govaerts 2000, 8.2)
//!
//! `F(z) + β ψ = 0, J(z)ᵀψ = 0, |ψ| = 1` with β = 0.
//!
//! Near an imperfect one the same equations have a solution whose β is the imperfection.

use super::branch::{Bifurcation, BifurcationKind};
use super::curve::{Curve, Place, cubic, flat, generic};
use crate::analysis::balance::smallest_solution;
use crate::event::first_zero;
use nalgebra::{DMatrix, DVector, SVD};

/// Singular values at a branch point that is located to half the digits, relative to the largest.
const SINGULAR: f64 = 1e-7;

/// Singular values at a point, relative to those at its neighbours, above which they do not vanish there.
const REGULAR: f64 = 1e-2;

/// Singular values at a point, relative to those at its neighbours, below which they vanish there.
const VANISHED: f64 = 1e-8;

/// Angles between two curves, relative to how fast they bend, below which their directions are not known.
const INDISTINCT: f64 = 1e-12;

/// Parts of unit vectors that are taken as zero.
const NO_PART: f64 = 1e-6;

/// A solution of the equations of a branch point.
#[derive(Clone)]
struct Crossing {
    z: DVector<f64>,
    psi: DVector<f64>,
    /// Imperfection, relative to rounding errors of F.
    imperfection: f64,
    /// Bound of the error of z.
    blur: f64,
}

impl Curve<'_> {
    /// The bifurcations between two places; none is certain, `None`, where the step has to be shorter. `length` is
    /// the longest step.
    pub fn bifurcations(&self, a: &Place, b: &Place, length: f64) -> Option<Vec<Bifurcation>> {
        let idle = a.nullity().min(b.nullity());
        let turned =
            (a.turn() < 0.0) != (b.turn() < 0.0) && a.turn().abs().max(b.turn().abs()) > NO_PART * NO_PART;
        let crossed = (a.volume(idle) < 0.0) != (b.volume(idle) < 0.0);
        let jump = a.negative.abs_diff(b.negative);
        match (turned, crossed) {
            (false, false) if jump == 0 => Some(Vec::new()),
            (true, false) => self.fold(a, b, idle).map(|fold| vec![fold]),
            (_, true) => {
                let zero = self.located(a, b, |place| place.volume(idle))?;
                self.branch_point(a, b, zero, [idle, jump], turned, length).map(|found| vec![found])
            }
            // An even number of eigenvalues changed sign, or those of K that are not real passed the imaginary axis.
            (false, false) => {
                let counted = |place: &Place| if place.negative == a.negative { -1.0 } else { 1.0 };
                let step = self.located(a, b, counted)?;
                let at = self.between(a, b, step).ok()?;
                let singular = at.volume(idle).abs() <= SINGULAR.sqrt() * at.size();
                match singular {
                    true => {
                        self.branch_point(a, b, step, [idle, jump], turned, length).map(|found| vec![found])
                    }
                    false if self.conservative(&at) => None,
                    false => Some(Vec::new()),
                }
            }
        }
    }

    /// Fraction of the way between two places at which a function of places changes its sign.
    fn located(&self, a: &Place, b: &Place, g: impl Fn(&Place) -> f64) -> Option<f64> {
        let mut value = |x: f64| self.between(a, b, x).map_or(f64::NAN, |place| g(&place));
        let x = first_zero(&mut value, (0.0, g(a)), (1.0, g(b)), f64::EPSILON);
        x.is_finite().then_some(x)
    }

    /// Is K symmetric there?
    fn conservative(&self, at: &Place) -> bool {
        self.equations.small(&at.z).is_ok_and(|small| small.circulatory().amax() == 0.0)
    }

    /// The fold between two places: the parameter's part of the tangent vanishes, and one eigenvalue of K.
    fn fold(&self, a: &Place, b: &Place, idle: usize) -> Option<Bifurcation> {
        let x = self.located(a, b, Place::turn)?;
        let at = self.between(a, b, x).ok()?;
        let regular = at.volume(idle).abs() > REGULAR * a.volume(idle).abs().min(b.volume(idle).abs());
        // The parameter turns at a pitchfork on its own curve, too.
        let unmoved = generic(a, b).unmoved();
        let crossed = |crossing: Crossing| {
            crossing.imperfection <= 1.0 && (crossing.z - &at.z).norm() < REGULAR * (&b.z - &a.z).norm()
        };
        let one = a.negative.abs_diff(b.negative) == 1;
        match at.turn().abs() < NO_PART
            && regular
            && one
            && !self.crossing(&at.z, &unmoved).is_some_and(crossed)
        {
            true => Some(bifurcation(BifurcationKind::Fold, &at.z, at.tangent, Vec::new())),
            false => None,
        }
    }

    /// The branch point near the part x of the way between two places.
    fn branch_point(
        &self,
        a: &Place,
        b: &Place,
        x: f64,
        [idle, jump]: [usize; 2],
        turned: bool,
        length: f64,
    ) -> Option<Bifurcation> {
        let h = (&b.z - &a.z).norm();
        let (guess, _) = cubic(a, b, x);
        let (beside, unmoved) = (generic(a, b).idle(), generic(a, b).unmoved());
        let crossing = self.crossing(&guess, &unmoved)?;
        if crossing.imperfection > 1.0 || (&crossing.z - &guess).norm() > h {
            return None;
        }
        // It lies on this curve, and not on one beside it.
        let chord = (&b.z - &a.z) / (h * h);
        let x = (&crossing.z - &a.z).dot(&chord);
        let (near, direction) = cubic(a, b, x);
        if !(-1e-3..=1.001).contains(&x) || (&crossing.z - near).norm() > 1e-2 * h {
            return None;
        }
        let (z, mut kernel) = self.kernel(&crossing.z, [a, b], &unmoved)?;
        let crossing = Crossing { z, ..crossing };
        if idle > 0 {
            let rest = &kernel - &beside * (beside.transpose() * &kernel);
            let svd = SVD::try_new(rest, true, false, f64::EPSILON, 10_000)?;
            kernel = svd.u?.columns(0, kernel.ncols().saturating_sub(idle)).into_owned();
        }
        // The curve's own direction first, and what is across it.
        let own = (&kernel * (kernel.transpose() * &direction)).normalize();
        let across = orthonormal(&kernel, &own);
        let multiplicity = across.len();
        if multiplicity == 0 || own.dot(&direction) < 0.9 {
            return None;
        }
        if multiplicity > 1 {
            // Several curves cross, of which nothing but their common plane is known.
            return match turned || multiplicity == jump {
                true => Some(bifurcation(BifurcationKind::Multiple, &crossing.z, across[0].clone(), across)),
                false => None,
            };
        }
        // The parameter's part of both directions, and what it is by the error of the point.
        let moved =
            Crossing { z: &crossing.z + (&own + &across[0]) * (4.0 * crossing.blur), ..crossing.clone() };
        let [(own, aside), (own_beside, aside_beside)] =
            [&crossing, &moved].map(|crossing| self.directions(crossing, own.clone(), &across[0]));
        let n = own.len() - 1;
        let noise = |a: &DVector<f64>, b: &DVector<f64>| 4.0 * (a[n] - b[n]).abs() + flat(n + 1);
        let vanishes = [noise(&own, &own_beside), noise(&aside, &aside_beside)];
        let turns = own[n].abs() <= vanishes[0];
        if turned != turns || !turned && jump != 1 {
            return None;
        }
        let (curved, vanishes) = if turns { (&own, vanishes[0]) } else { (&aside, vanishes[1]) };
        let kind = match curved[n].abs() <= vanishes {
            true => self.side(&crossing.z, curved, &beside, 1e-3 * length),
            false => BifurcationKind::Transcritical,
        };
        Some(bifurcation(kind, &crossing.z, aside, across))
    }

    /// The solution of the equations of a branch point near a guess, by Newton's method; ψ is none of the forces that
    /// no displacement changes anywhere.
    fn crossing(&self, guess: &DVector<f64>, unmoved: &DMatrix<f64>) -> Option<Crossing> {
        let n = guess.len() - 1;
        let (mut z, mut beta) = (guess.clone(), 0.0);
        let jacobian = self.equations.look(&z).1;
        let moved = &jacobian - unmoved * (unmoved.transpose() * &jacobian);
        let svd = SVD::try_new(moved, true, false, f64::EPSILON, 10_000)?;
        let mut psi = svd.u?.column((n - 1).checked_sub(unmoved.ncols())?).into_owned();
        let mut last = f64::INFINITY;
        for _ in 0..40 {
            let (rest, jacobian) = self.equations.look(&z);
            let curvature = self.equations.curvature(&z, &psi);
            let mut whole = DMatrix::zeros(2 * n + 2, 2 * n + 2);
            whole.view_mut((0, 0), (n, n + 1)).copy_from(&jacobian);
            whole.view_mut((0, n + 1), (n, n)).fill_diagonal(beta);
            whole.view_mut((0, 2 * n + 1), (n, 1)).copy_from(&psi);
            whole.view_mut((n, 0), (n + 1, n + 1)).copy_from(&curvature);
            whole.view_mut((n, n + 1), (n + 1, n)).copy_from(&jacobian.transpose());
            whole.view_mut((2 * n + 1, n + 1), (1, n)).copy_from(&psi.transpose());
            let mut right = DVector::zeros(2 * n + 2);
            right.rows_mut(0, n).copy_from(&-(&rest + &psi * beta));
            right.rows_mut(n, n + 1).copy_from(&-(jacobian.transpose() * &psi));
            right[2 * n + 1] = 0.5 * (1.0 - psi.norm_squared());
            let whole_size = whole.norm();
            let step = smallest_solution(whole, &right, flat(2 * n + 2) * whole_size).ok()?;
            let size = step.rows(0, 2 * n + 1).amax() / (1.0 + z.amax());
            z += step.rows(0, n + 1);
            psi += step.rows(n + 1, n);
            beta += step[2 * n + 1];
            if size <= f64::EPSILON || size >= last && last < 1e-8 {
                let terms =
                    |i: usize| (0..=n).map(|j| jacobian[(i, j)].abs() * (1.0 + z[j].abs())).sum::<f64>();
                let rounding = 4.0 * flat(n) * (0..n).map(terms).fold(0.0, f64::max);
                // Where there is no solution, steps vanish at the least that is left.
                let solved = right.rows(n, n + 1).amax() <= SINGULAR * whole_size;
                let blur = size.max(f64::EPSILON) * (1.0 + z.amax());
                return solved.then(|| Crossing { z, psi, imperfection: beta.abs() / rounding, blur });
            }
            last = size;
        }
        None
    }

    /// Orthonormal null vectors of J at the branch point near z, the columns, and that point. Several singular values
    /// that are small there, compared with those at its neighbours, vanish together if there is a z at which they all
    /// do: it is sought by Gauss and Newton's method for `F = 0, Jᵀψ = 0` for all their left vectors ψ.
    fn kernel(
        &self,
        z: &DVector<f64>,
        [a, b]: [&Place; 2],
        unmoved: &DMatrix<f64>,
    ) -> Option<(DVector<f64>, DMatrix<f64>)> {
        let (n, idle) = (z.len() - 1, unmoved.ncols());
        let (before, after) = (self.singular(&a.z)?.0, self.singular(&b.z)?.0);
        let vanishing = |values: &DVector<f64>, part: f64| {
            let rounding = 16.0 * flat(n) * before[0];
            let small = |k: &usize| values[*k] <= (part * before[*k].min(after[*k])).max(rounding);
            (0..n - idle).filter(small).count()
        };
        let few = |z: DVector<f64>, many: usize| -> Option<(DVector<f64>, DMatrix<f64>)> {
            let right = self.singular(&z)?.2;
            Some((z, right.rows(n - many - idle, 1 + many + idle).transpose()))
        };
        let many = vanishing(&self.singular(z)?.0, REGULAR).max(1);
        // Those that vanish along the curve are in one plane with the others at the apex of a surface of equilibria.
        let all = many + idle;
        if all < 2 {
            return few(z.clone(), 1);
        }
        let mut at = z.clone();
        for _ in 0..6 {
            let (rest, jacobian) = self.equations.look(&at);
            let left = self.singular(&at)?.1;
            let mut whole = DMatrix::zeros(n + all * (n + 1), n + 1);
            let mut right = DVector::zeros(whole.nrows());
            whole.rows_mut(0, n).copy_from(&jacobian);
            right.rows_mut(0, n).copy_from(&-rest);
            for k in 0..all {
                let psi = left.column(n - 1 - k).into_owned();
                let row = n + k * (n + 1);
                whole.rows_mut(row, n + 1).copy_from(&self.equations.curvature(&at, &psi));
                right.rows_mut(row, n + 1).copy_from(&-(jacobian.transpose() * &psi));
            }
            let cut = flat(n + 1) * whole.norm();
            at += smallest_solution(whole, &right, cut).ok()?;
        }
        match vanishing(&self.singular(&at)?.0, VANISHED) {
            exact if exact == many && (&at - z).norm() < REGULAR * (&b.z - &a.z).norm() => few(at, many),
            _ if idle > 0 => None,
            _ => few(z.clone(), 1),
        }
    }

    /// The direction of the curve itself at a simple branch point, and that of the one which crosses it: the zeros of
    /// the quadratic form `ψᵀ∂²F/∂z²` on the plane of the null vectors (the algebraic bifurcation equation; Keller
    /// 1977).
    fn directions(
        &self,
        crossing: &Crossing,
        own: DVector<f64>,
        across: &DVector<f64>,
    ) -> (DVector<f64>, DVector<f64>) {
        let curvature = self.equations.curvature(&crossing.z, &crossing.psi);
        let form = |a: &DVector<f64>, b: &DVector<f64>| a.dot(&(&curvature * b));
        let [a, b, c] = [form(&own, &own), form(&own, across), form(across, across)];
        let discriminant = b * b - a * c;
        if discriminant.is_nan() || discriminant <= (INDISTINCT * curvature.norm()).powi(2) {
            return (own, oriented(across.clone()));
        }
        let q = -(b + discriminant.sqrt().copysign(b));
        let one = (&own * q + across * a).normalize();
        let other = (&own * c + across * q).normalize();
        let (mine, aside) =
            if one.dot(across).abs() < other.dot(across).abs() { (one, other) } else { (other, one) };
        (if mine.dot(&own) < 0.0 { -mine } else { mine }, oriented(aside))
    }

    /// The kind of a branch point, from the curve through it along which the parameter does not change in first
    /// order: on which sides of the critical parameter it lies.
    fn side(
        &self,
        at: &DVector<f64>,
        along: &DVector<f64>,
        beside: &DMatrix<f64>,
        h: f64,
    ) -> BifurcationKind {
        let n = at.len() - 1;
        let side = |s: f64| self.corrected(at + along * s, along, beside).map(|aside| aside[n] - at[n]);
        let (Ok(a), Ok(b)) = (side(h), side(-h)) else { return BifurcationKind::Degenerate };
        let (even, odd) = ((a + b).abs(), (a - b).abs());
        match even.max(odd) <= 1e-13 * (1.0 + at[n].abs()) {
            true => BifurcationKind::Degenerate,
            false if even > odd => BifurcationKind::Pitchfork,
            false => BifurcationKind::Transcritical,
        }
    }
}

pub(super) fn bifurcation(
    kind: BifurcationKind,
    z: &DVector<f64>,
    direction: DVector<f64>,
    kernel: Vec<DVector<f64>>,
) -> Bifurcation {
    let n = z.len() - 1;
    Bifurcation { kind, parameter: z[n], q: z.rows(0, n).into_owned(), direction, kernel }
}

/// Its largest entry is positive.
fn oriented(direction: DVector<f64>) -> DVector<f64> {
    if direction[direction.iamax()] < 0.0 { -direction } else { direction }
}

/// An orthonormal basis of what the columns of `space` span across `own`.
fn orthonormal(space: &DMatrix<f64>, own: &DVector<f64>) -> Vec<DVector<f64>> {
    let mut found: Vec<DVector<f64>> = Vec::new();
    let across = space - own * (own.transpose() * space);
    let mut left = across;
    while found.len() + 1 < space.ncols() {
        let Some(longest) =
            left.column_iter().map(|c| c.into_owned()).max_by(|a, b| a.norm().total_cmp(&b.norm()))
        else {
            break;
        };
        let next = oriented(longest.normalize());
        left -= &next * (next.transpose() * &left);
        found.push(next);
    }
    found
}
