//! How equilibria move, meet and branch when a parameter changes.
//!
//! Solutions z = (q, μ) of `F(q, μ) = bias − force = 0` form curves, which are followed by pseudo-arclength: a step along the
//! tangent, then Newton's method in the plane across it (Keller 1977; Govaerts, *Numerical Methods for Bifurcations of Dynamical
//! Equilibria*, 2000, ch. 4). A curve may turn back (fold), or others may cross it (branch points); both are located to
//! rounding.

use super::AnalysisError;
use super::equilibrium::smallest_solution;
use super::small::unconstrained;
use crate::event::first_zero;
use crate::scalar::Dual;
use crate::system::Linearize;
use nalgebra::{DMatrix, DVector, SVector};

/// How far and how finely a curve is followed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Path {
    /// The parameter's range, in which the curve is followed.
    pub range: (f64, f64),
    /// Longest step, as a length in (q, μ).
    pub step: f64,
    /// Most steps.
    pub steps: usize,
}

/// A point of a curve.
#[derive(Clone, Debug, PartialEq)]
pub struct BranchPoint {
    /// The parameter.
    pub parameter: f64,
    /// Coordinates.
    pub q: DVector<f64>,
    /// How many directions of falling energy the equilibrium has, the negative eigenvalues of K; 0: stable.
    pub negative: usize,
}

/// Where a curve does something special.
#[derive(Clone, Debug, PartialEq)]
pub struct Bifurcation {
    /// What.
    pub kind: BifurcationKind,
    /// The parameter.
    pub parameter: f64,
    /// Coordinates.
    pub q: DVector<f64>,
    /// Direction in (q, μ) of the curve, at a fold, or of the one that crosses it.
    pub direction: DVector<f64>,
}

/// What a curve of equilibria does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BifurcationKind {
    /// It turns back: two equilibria meet and vanish (saddle-node).
    Fold,
    /// Another curve crosses it and lies on one side of the critical parameter: of a symmetric system.
    Pitchfork,
    /// Another curve crosses it from one side to the other.
    Transcritical,
}

/// A curve of equilibria.
#[derive(Clone, Debug, PartialEq)]
pub struct Branch {
    /// Its points.
    pub points: Vec<BranchPoint>,
    /// Folds and branch points, in their order on the curve.
    pub bifurcations: Vec<Bifurcation>,
}

/// A direction at the start of a curve.
#[derive(Clone, Debug, PartialEq)]
pub enum Heading {
    /// The parameter grows at first.
    Up,
    /// The parameter falls at first.
    Down,
    /// Along this direction in (q, μ): [`Bifurcation::direction`] leads to the other curve, its negative to the other half.
    Along(DVector<f64>),
}

/// The curve of equilibria through the one near `q` at `parameter`. `family` makes the system from its parameter, over duals, so
/// that the derivatives by the parameter are exact.
///
/// ```
/// use lagrange_runtime::analysis::{BifurcationKind, Heading, Path, follow};
/// use lagrange_runtime::prelude::*;
///
/// lagrangian! {
///     /// A bead in a tube bent to a circle that spins about its vertical diameter.
///     system Bead {
///         param a, omega, g = 9.81;
///         coord theta;
///         T = 0.5 * a.powi(2) * (dot(theta).powi(2) + (omega * sin(theta)).powi(2));
///         V = -g * a * cos(theta);
///     }
/// }
/// let bead = |omega: Dual<f64>| Bead { omega, ..Bead::new(0.5, 0.0).map(Dual::constant) };
/// let path = Path { range: (0.0, 8.0), step: 0.1, steps: 1000 };
/// let bottom = follow(&bead, &[0.0], 1.0, &Heading::Up, &path)?;
/// let pitchfork = &bottom.bifurcations[0];
/// assert_eq!(pitchfork.kind, BifurcationKind::Pitchfork);
/// assert!((pitchfork.parameter - (9.81f64 / 0.5).sqrt()).abs() < 1e-12, "ω² = g/a");
/// let aside = Heading::Along(pitchfork.direction.clone());
/// let up = follow(&bead, &[0.0], pitchfork.parameter, &aside, &path)?;
/// assert!(up.points.iter().skip(1).all(|p| p.negative == 0), "the bead rides stably aside");
/// # Ok::<(), lagrange_runtime::analysis::AnalysisError>(())
/// ```
///
/// # Errors
/// [`AnalysisError::NotConverged`] where there is no equilibrium near the start, or the curve is lost;
/// [`AnalysisError::DependentCoordinates`]; [`AnalysisError::NotApplicable`] for a path without length.
pub fn follow<Sys: Linearize<N, Scalar = Dual<f64>>, const N: usize>(
    family: &impl Fn(Dual<f64>) -> Sys,
    q: &[f64; N],
    parameter: f64,
    heading: &Heading,
    path: &Path,
) -> Result<Branch, AnalysisError> {
    unconstrained::<Sys, N>()?;
    if !(path.step > 0.0 && path.step.is_finite() && path.range.0 < path.range.1) {
        return Err(AnalysisError::NotApplicable { needs: "a positive step and an increasing range" });
    }
    let curve = Curve { look: &|z| look(family, z) };
    let guess = DVector::from_fn(N + 1, |i, _| if i < N { q[i] } else { parameter });
    let upward = DVector::from_fn(N + 1, |i, _| f64::from(i == N));
    let (start, tangent) = match heading {
        Heading::Along(direction) if direction.len() == N + 1 => (guess, direction.normalize()),
        Heading::Along(direction) => {
            return Err(AnalysisError::Dimension { expected: N + 1, found: direction.len() });
        }
        _ => {
            let start = curve.corrected(guess, &upward)?;
            let tangent = curve.tangent(&start, &upward)?;
            let down = matches!(heading, Heading::Down) == (tangent[N] >= 0.0);
            (start, if down { -tangent } else { tangent })
        }
    };
    // A curve that begins at a branch point shall not find it again.
    let before = match heading {
        Heading::Along(_) => None,
        _ => Some(curve.signs(&start, &tangent)),
    };
    curve.followed(start, tangent, before, path)
}

/// `F` and `(∂F/∂q, ∂F/∂μ)` at z = (q, μ).
fn look<Sys: Linearize<N, Scalar = Dual<f64>>, const N: usize>(
    family: &impl Fn(Dual<f64>) -> Sys,
    z: &DVector<f64>,
) -> (DVector<f64>, DMatrix<f64>) {
    let system = family(Dual::variable(z[N]));
    let q = SVector::<Dual<f64>, N>::from_fn(|i, _| Dual::constant(z[i]));
    let (still, t) = (q.map(|_| Dual::constant(0.0)), Dual::constant(0.0));
    let rest = system.bias(&q, &still, t) - system.force(&q, &still, t);
    let stiffness = system.linearize(&q, &still, t).stiffness;
    let jacobian =
        DMatrix::from_fn(N, N + 1, |i, j| if j < N { stiffness[(i, j)].value } else { rest[i].slope });
    (DVector::from_fn(N, |i, _| rest[i].value), jacobian)
}

/// `F` at z, and how it changes.
type Look<'a> = dyn Fn(&DVector<f64>) -> (DVector<f64>, DMatrix<f64>) + 'a;

struct Curve<'a> {
    look: &'a Look<'a>,
}

impl Curve<'_> {
    /// The Jacobian with a row across it.
    fn bordered(&self, jacobian: &DMatrix<f64>, across: &DVector<f64>) -> DMatrix<f64> {
        let n = jacobian.nrows();
        DMatrix::from_fn(n + 1, n + 1, |i, j| if i < n { jacobian[(i, j)] } else { across[j] })
    }

    /// The point of the curve in the plane through `z` across `direction`.
    fn corrected(&self, z: DVector<f64>, direction: &DVector<f64>) -> Result<DVector<f64>, AnalysisError> {
        let (n, mut at) = (z.len() - 1, z);
        let (mut last, mut best) = (f64::INFINITY, at.clone());
        for _ in 0..30 {
            let (rest, jacobian) = (self.look)(&at);
            let right = DVector::from_fn(n + 1, |i, _| if i < n { -rest[i] } else { 0.0 });
            let step = smallest_solution(self.bordered(&jacobian, direction), &right, 0.0)?;
            let size = step.amax() / (1.0 + at.amax());
            if size >= last && last < 1e-9 || size == 0.0 {
                return Ok(best);
            }
            last = size;
            at += step;
            best.clone_from(&at);
        }
        match last < 1e-9 {
            true => Ok(best),
            false => Err(AnalysisError::NotConverged { what: "the curve of equilibria", residual: last }),
        }
    }

    /// The unit tangent at a point, on the same side as `before`.
    fn tangent(&self, z: &DVector<f64>, before: &DVector<f64>) -> Result<DVector<f64>, AnalysisError> {
        let n = z.len() - 1;
        let right = DVector::from_fn(n + 1, |i, _| f64::from(i == n));
        let bordered = self.bordered(&(self.look)(z).1, before);
        let tangent = smallest_solution(bordered, &right, 0.0)?.normalize();
        Ok(if tangent.dot(before) < 0.0 { -tangent } else { tangent })
    }

    /// What changes sign at a fold: the parameter's part of the tangent. And at a branch point: the determinant of the Jacobian
    /// with the tangent below.
    fn signs(&self, z: &DVector<f64>, tangent: &DVector<f64>) -> [f64; 2] {
        let bordered = self.bordered(&(self.look)(z).1, tangent);
        [tangent[tangent.len() - 1], bordered.determinant()]
    }

    fn point(&self, z: &DVector<f64>) -> Result<BranchPoint, AnalysisError> {
        let n = z.len() - 1;
        let stiffness = (self.look)(z).1.columns(0, n).into_owned();
        if stiffness.iter().any(|x| !x.is_finite()) {
            return Err(AnalysisError::NotFinite);
        }
        let energy = 0.5 * (&stiffness + stiffness.transpose());
        let rounding = n as f64 * f64::EPSILON * energy.amax();
        let negative = energy.symmetric_eigenvalues().iter().filter(|x| **x < -rounding).count();
        Ok(BranchPoint { parameter: z[n], q: z.rows(0, n).into_owned(), negative })
    }

    fn followed(
        &self,
        start: DVector<f64>,
        tangent: DVector<f64>,
        mut signs: Option<[f64; 2]>,
        path: &Path,
    ) -> Result<Branch, AnalysisError> {
        let n = start.len() - 1;
        let mut branch = Branch { points: vec![self.point(&start)?], bifurcations: Vec::new() };
        let (mut z, mut tangent) = (start, tangent);
        let mut h = path.step;
        for _ in 0..path.steps {
            let next = loop {
                // Where the curve bends by more than the cosine of this angle, the step was too long.
                let next = self
                    .corrected(&z + &tangent * h, &tangent)
                    .and_then(|to| self.tangent(&to, &tangent).map(|along| (to, along)))
                    .ok()
                    .filter(|(to, along)| along.dot(&tangent) > 0.9 && (to - &z).norm() < 2.0 * h);
                match next {
                    Some(next) => break next,
                    None if h > 1e-9 * path.step => h *= 0.5,
                    None => {
                        let what = "the continuation of the curve";
                        return Err(AnalysisError::NotConverged { what, residual: h });
                    }
                }
            };
            let (to, along) = next;
            let now = self.signs(&to, &along);
            if let Some(before) = signs {
                branch.bifurcations.extend(self.between([(&z, &tangent, before), (&to, &along, now)]));
            }
            signs = Some(now);
            let inside = to[n] >= path.range.0 && to[n] <= path.range.1;
            (z, tangent) = (to, along);
            branch.points.push(self.point(&z)?);
            if !inside {
                break;
            }
            h = (1.5 * h).min(path.step);
        }
        Ok(branch)
    }

    /// The bifurcations between two neighbouring points, from the signs at both.
    fn between(
        &self,
        [(z0, tangent0, before), (z1, tangent1, now)]: [(&DVector<f64>, &DVector<f64>, [f64; 2]); 2],
    ) -> Vec<Bifurcation> {
        let n = z0.len() - 1;
        let h = (z1 - z0).norm();
        // From the cubic through both, and across it: close to a crossing a guess further off would reach the other curve.
        let place = |s: f64| {
            let (x, y) = (s / h, 1.0 - s / h);
            let guess =
                z0 * (y * y * (1.0 + 2.0 * x)) + z1 * (x * x * (1.0 + 2.0 * y)) + tangent0 * (h * x * y * y)
                    - tangent1 * (h * x * x * y);
            let direction = (z1 - z0) * (6.0 * x * y / h)
                + tangent0 * (y * (y - 2.0 * x))
                + tangent1 * (x * (x - 2.0 * y));
            let direction = direction.normalize();
            let at = self.corrected(guess, &direction)?;
            self.tangent(&at, &direction).map(|along| (at, along))
        };
        let locate = |which: usize| {
            if (before[which] < 0.0) == (now[which] < 0.0) {
                return None;
            }
            let sign = |s: f64| place(s).map_or(f64::NAN, |(at, along)| self.signs(&at, &along)[which]);
            let s = first_zero(sign, (0.0, before[which]), (h, now[which]), f64::EPSILON * h);
            place(s).ok().map(|(at, along)| (s, at, along))
        };
        let (fold, crossing) = (locate(0), locate(1));
        let mut found = Vec::new();
        let mut add = |kind, at: &DVector<f64>, direction| {
            found.push(Bifurcation { kind, parameter: at[n], q: at.rows(0, n).into_owned(), direction });
        };
        match (fold, crossing) {
            // On the branch of a pitchfork the parameter turns back where the other curve crosses it: that is no fold, and better
            // located by the turn than by the determinant, which vanishes along the other curve too.
            (Some((s, at, along)), Some((other, ..))) if (s - other).abs() < 1e-3 * h => {
                add(BifurcationKind::Pitchfork, &at, self.across(&at, &along));
            }
            (fold, crossing) => {
                if let Some((_, at, along)) = fold {
                    add(BifurcationKind::Fold, &at, along);
                }
                if let Some((_, at, along)) = crossing {
                    let across = self.across(&at, &along);
                    let kind = match self.on_one_side(&at, &across, h) {
                        true => BifurcationKind::Pitchfork,
                        false => BifurcationKind::Transcritical,
                    };
                    add(kind, &at, across);
                }
            }
        }
        found
    }

    /// The direction at a branch point that leads to the other curve: the null space of the Jacobian is a plane there, and this
    /// is what is across the tangent in it. Its largest entry is positive.
    fn across(&self, at: &DVector<f64>, along: &DVector<f64>) -> DVector<f64> {
        let svd = self.bordered(&(self.look)(at).1, along).svd(false, true);
        let Some(v) = svd.v_t else { return along.clone() };
        let across = v.row(svd.singular_values.argmin().0).transpose();
        let across = (&across - along * along.dot(&across)).normalize();
        if across[across.iamax()] < 0.0 { -across } else { across }
    }

    /// Whether the curve through `at` along `across` keeps to one side of the parameter there.
    fn on_one_side(&self, at: &DVector<f64>, across: &DVector<f64>, h: f64) -> bool {
        let n = at.len() - 1;
        let side = |s: f64| self.corrected(at + across * s, across).map(|aside| aside[n] - at[n]);
        // Of a curve that crosses, the first orders cancel in the sum.
        matches!((side(h), side(-h)), (Ok(a), Ok(b)) if (a + b).abs() >= 0.5 * (a - b).abs())
    }
}
