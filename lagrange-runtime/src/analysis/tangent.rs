//! Minimal coordinates of the displacements and velocities that constraints admit, and equations of small motions in
//! them.

use super::{AnalysisError, SmallMotion};
use crate::facts::{Constraint, ConstraintKind};
use crate::scalar::Real;
use crate::state::{ConstraintTerms, State};
use crate::system::{Lagrangian, System};
use nalgebra::{DMatrix, DVector, SMatrix, SVector};

/// Largest violation of a constraint by a state that is taken to fulfil it, relative to what a displacement by
/// `1 + |q|` changes.
const VIOLATED: f64 = 1e-10;

/// Part of a gradient of a constraint beside the gradients of the others, below which they are dependent: half of the
/// digits.
const DEPENDENT: f64 = 1e-8;

/// The hypothesis of small motions with constant coefficients.
pub(super) const STEADY: &str = "a steady motion: a coordinate that moves acts on the small motions, whose coefficients change; `SmallMotion::about` has them at that moment";

/// Changes of directions along a motion that are rounding.
const SAME: f64 = 1e-9;

/// A pivot among coordinates that do not matter is taken if it is at least this part of the largest one.
const PREFERRED: f64 = 1e-3;

/// Relative error of entries that are sums of products of emitted ones.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

/// Error, in units of [`ROUNDING`], up to which an entry counts as zero where the theory needs it to vanish.
const VANISHING: f64 = 1e4;

/// The same relative to the largest element, in units in which the diagonal of M is 1.
const CANCELLED: f64 = 1e-12;

/// The terms of a constraint on numbers of a length that is known at run time.
pub(super) struct Held {
    pub of: Constraint,
    pub spare: usize,
    pub value: f64,
    pub rate: f64,
    pub multiplier: f64,
    /// Its row of A.
    pub row: DVector<f64>,
    /// Derivatives of the row by the coordinates.
    pub row_by_coordinates: DMatrix<f64>,
    /// Derivatives of the constraint's rate by the coordinates.
    pub rate_by_coordinates: DVector<f64>,
}

impl Held {
    fn new<S: Real, const N: usize>(terms: &ConstraintTerms<S, N>) -> Self {
        let vector = |x: &SVector<S, N>| DVector::from_fn(N, |i, _| x[i].to_f64());
        Held {
            of: terms.of,
            spare: terms.spare,
            value: terms.value.to_f64(),
            rate: terms.rate.to_f64(),
            multiplier: terms.multiplier.to_f64(),
            row: vector(&terms.row),
            row_by_coordinates: DMatrix::from_fn(N, N, |i, k| terms.row_by_coordinates[(i, k)].to_f64()),
            rate_by_coordinates: vector(&terms.rate_by_coordinates),
        }
    }

    /// The constraints of a system at a state. A type that has some and does not say which is refused.
    pub fn all<Sys: Lagrangian<N, Scalar: Real>, const N: usize>(
        system: &Sys,
        at: &State<Sys::Scalar, N>,
    ) -> Result<Vec<Self>, AnalysisError> {
        let all = Self::known(system, at);
        match Sys::FACTS.constraints.get(all.len()) {
            Some(constraint) => Err(AnalysisError::DependentCoordinates { constraint: constraint.name }),
            None => Ok(all),
        }
    }

    /// The constraints that a system tells.
    pub fn known<Sys: System<N, Scalar: Real>, const N: usize>(
        system: &Sys,
        at: &State<Sys::Scalar, N>,
    ) -> Vec<Self> {
        let mut all = Vec::new();
        system.constraint_terms(at, |terms| all.push(Held::new(&terms)));
        all
    }

    /// Without the coordinates that are not among these.
    pub fn kept(&self, kept: &[usize]) -> Self {
        let part = |x: &DVector<f64>| DVector::from_fn(kept.len(), |i, _| x[kept[i]]);
        let square = |i, k| self.row_by_coordinates[(kept[i], kept[k])];
        Held {
            row: part(&self.row),
            row_by_coordinates: DMatrix::from_fn(kept.len(), kept.len(), square),
            rate_by_coordinates: part(&self.rate_by_coordinates),
            ..*self
        }
    }

    pub fn on_positions(&self) -> bool {
        self.of.kind == ConstraintKind::Holonomic
    }
}

/// Refuses a state beside the constraints.
pub(super) fn fulfilled(all: &[Held], q: &[f64], qd: &[f64]) -> Result<(), AnalysisError> {
    let size = |x: f64| 1.0 + x.abs();
    for held in all {
        let units: f64 = held.row.iter().zip(q).map(|(a, x)| a.abs() * size(*x)).sum();
        let speeds: f64 = held.row.iter().zip(qd).map(|(a, x)| a.abs() * size(*x)).sum();
        let ratio = |rest: f64, units: f64| if rest == 0.0 { 0.0 } else { rest.abs() / units };
        let violations = [ratio(held.value, units), ratio(held.rate, speeds)];
        // (NaN, of which `max` knows nothing, is worse than any number.)
        let violation =
            violations.into_iter().find(|x| x.is_nan()).unwrap_or(violations[0].max(violations[1]));
        if violation > VIOLATED || violation.is_nan() {
            return Err(AnalysisError::OffConstraints { constraint: held.of.name, violation });
        }
    }
    Ok(())
}

/// `Σ λ ∂A/∂q`, the stiffness of the constraint forces.
pub(super) fn stiffness_of_forces(all: &[Held], n: usize) -> DMatrix<f64> {
    all.iter().fold(DMatrix::zeros(n, n), |sum, held| sum + &held.row_by_coordinates * held.multiplier)
}

/// Deviations `δq = H z` and `δq̇ = V u + W z` that satisfy linearized constraints `A δq = 0` (of those on positions)
/// and `A δq̇ + ∂(A q̇ + b)/∂q δq = 0` (of all): z are deviations of some of the coordinates, and u of velocities of
/// some of these (Neimark and Fufaev, *Dynamics of Nonholonomic Systems*, 1972, ch. III and V).
pub(super) struct TangentSpace {
    /// Indices of the coordinates z, and of those among them whose velocities are u.
    pub positions: Vec<usize>,
    pub velocities: Vec<usize>,
    /// Indices of constraints from which all others follow.
    pub rows: Vec<usize>,
    pub h: DMatrix<f64>,
    pub v: DMatrix<f64>,
    pub w: DMatrix<f64>,
    /// Units of all coordinates.
    units: Vec<f64>,
}

impl TangentSpace {
    /// In units of the coordinates. Where there is a choice, coordinates of the lowest class (see [`classes`]) depend
    /// on others.
    pub fn new(all: &[Held], units: &[f64], classes: &[u8]) -> Result<Self, AnalysisError> {
        let (m, n) = (all.len(), units.len());
        // A beside the derivatives of the rates, both reduced by the same operations.
        let entry = |j: usize, i: usize| match i.checked_sub(n) {
            None => all[j].row[i],
            Some(i) => all[j].rate_by_coordinates[i],
        };
        let mut a = DMatrix::from_fn(m, 2 * n, entry);
        if a.iter().any(|x| !x.is_finite()) {
            return Err(AnalysisError::NotFinite);
        }
        let size = |a: &DMatrix<f64>, j: usize, i: usize| a[(j, i)].abs() * units[i];
        let before: Vec<f64> = (0..m).map(|j| (0..n).map(|i| size(&a, j, i)).fold(0.0, f64::max)).collect();
        let mut pivots: Vec<Option<usize>> = vec![None; m];
        let (mut h, mut followed) = (None, 0);
        for on_positions in [true, false] {
            let mut left: Vec<usize> = (0..m).filter(|&j| all[j].on_positions() == on_positions).collect();
            while !left.is_empty() {
                let free = (0..n).filter(|i| !pivots.contains(&Some(*i)));
                let part =
                    |j: usize, i: usize| if before[j] > 0.0 { size(&a, j, i) / before[j] } else { 0.0 };
                let candidates: Vec<(f64, usize, usize)> = free
                    .flat_map(|i| left.iter().map(move |&j| (j, i)))
                    .map(|(j, i)| (part(j, i), j, i))
                    .collect();
                let most = |class: u8| {
                    let of_class = candidates.iter().filter(|(_, _, i)| on_positions || classes[*i] <= class);
                    of_class.copied().max_by(|x, y| x.0.total_cmp(&y.0)).unwrap_or((0.0, left[0], 0))
                };
                let best = most(u8::MAX);
                // Constraints that follow from the others in all positions admit what these do.
                if best.0 <= DEPENDENT && followed + left.len() <= all[left[0]].spare {
                    followed += left.len();
                    break;
                }
                if best.0 <= DEPENDENT {
                    return Err(AnalysisError::DependentConstraints {
                        constraint: all[left[0]].of.name,
                        left: best.0,
                    });
                }
                let lowest = (0..=ACTS).map(most).find(|x| x.0 >= PREFERRED * best.0);
                let (_, row, column) = lowest.unwrap_or(best);
                let pivot = a[(row, column)];
                for i in 0..2 * n {
                    a[(row, i)] /= pivot;
                }
                for j in (0..m).filter(|&j| j != row) {
                    let factor = a[(j, column)];
                    if factor != 0.0 {
                        for i in 0..2 * n {
                            a[(j, i)] -= factor * a[(row, i)];
                        }
                        a[(j, column)] = 0.0;
                    }
                }
                pivots[row] = Some(column);
                left.retain(|&j| j != row);
            }
            h.get_or_insert_with(|| basis(&a, &pivots, n));
        }
        let (velocities, v) = basis(&a, &pivots, n);
        let (positions, h) = h.unwrap_or_else(|| (velocities.clone(), v.clone()));
        let mut w = DMatrix::zeros(n, positions.len());
        for (j, column) in pivots.iter().enumerate() {
            if let Some(i) = column {
                w.view_mut((*i, 0), (1, h.ncols())).copy_from(&-(a.view((j, n), (1, n)) * &h));
            }
        }
        let rows = (0..m).filter(|&j| pivots[j].is_some()).collect();
        Ok(TangentSpace { positions, velocities, rows, h, v, w, units: units.to_vec() })
    }

    /// Returns whether the admissible deviations are those of another state.
    pub fn is_like(&self, other: &Self) -> bool {
        let near = |a: &DMatrix<f64>, b: &DMatrix<f64>| {
            a.shape() == b.shape() && (a - b).amax() <= SAME * a.amax().max(1.0)
        };
        self.positions == other.positions
            && self.velocities == other.velocities
            && [(&self.h, &other.h), (&self.v, &other.v), (&self.w, &other.w)]
                .into_iter()
                .all(|(a, b)| near(a, b))
    }

    /// Indices among z of the coordinates whose velocities depend on others.
    fn led(&self) -> Vec<usize> {
        (0..self.positions.len()).filter(|k| !self.velocities.contains(&self.positions[*k])).collect()
    }

    /// Equations of small motions from `M δq̈ + C δq̇ + K δq = Aᵀ δλ`, K with the stiffness of the constraint forces,
    /// about a motion along which V and W are constant.
    pub fn projected(&self, [m, c, k]: [&DMatrix<f64>; 3]) -> Matrices {
        let TangentSpace { h, v, w, .. } = self;
        let [by_u, by_z] = [v, w].map(|x| x.select_rows(&self.positions));
        let of = |[m, c, k, h, v, w, by_u, by_z]: [&DMatrix<f64>; 8]| {
            let vt = v.transpose();
            [&vt * m * v, &vt * (m * (w * by_u) + c * v), &vt * (m * (w * by_z) + c * w + k * h)]
        };
        let exact = [m, c, k, h, v, w, &by_u, &by_z];
        let sizes = exact.map(|x| x.abs());
        Matrices { terms: of(exact), sizes: of(sizes.each_ref()) }
    }

    /// Equations of small motions from derivatives of the accelerations, `δq̈ = J δq + J' δq̇`, about any motion, as
    /// they begin.
    pub fn accelerated(&self, m: &DMatrix<f64>, [by_q, by_qd]: [&DMatrix<f64>; 2]) -> Matrices {
        let TangentSpace { h, v, w, .. } = self;
        let [by_q, by_qd] = [by_q, by_qd].map(|x| x.select_rows(&self.velocities));
        let of = |[m, by_q, by_qd, h, v, w]: [&DMatrix<f64>; 6]| {
            let inertia = v.transpose() * m * v;
            [inertia.clone(), &inertia * (by_qd * v), inertia * (by_q * h + by_qd * w)]
        };
        let exact = [m, &by_q, &by_qd, h, v, w];
        let sizes = exact.map(|x| x.abs());
        let [m, c, k] = of(exact);
        Matrices { terms: [m, -c, -k], sizes: of(sizes.each_ref()) }
    }

    /// The equations `M ü + C u̇ + K z = 0` in the coordinates w whose velocities are u. The others follow by
    /// `ṡ = F ẇ + G z`, so that `c = s − F w` changes by `ċ = G (w, F w) + Gₛ c`. Each of them is a root 0 of its own
    /// where Gₛ has no roots but 0 and c does not act on w, or is constant.
    pub fn small(&self, of: &Matrices, names: &[String]) -> Result<SmallMotion, AnalysisError> {
        let Matrices { terms: [m, c, k], sizes: [m_size, c_size, k_size] } = of;
        let by_u = self.v.select_rows(&self.positions);
        let led = self.led();
        if !led.is_empty() {
            let rates = self.w.select_rows(led.iter().map(|&k| &self.positions[k]));
            let driven = &rates * &by_u;
            let own = rates.select_columns(&led);
            let acts = k.select_columns(&led);
            let slack = self.slack(k_size, &self.positions).select_columns(&led);
            let constant = driven.amax() <= VANISHING * ROUNDING * rates.amax().max(1.0) && own.amax() == 0.0;
            if !constant && acts.iter().zip(&slack).any(|(x, slack)| x.abs() > *slack) {
                let needs = "dependent velocities whose coordinates do not act on the independent ones: these small motions are of an odd order; take `StateSpace::about` and its A";
                return Err(AnalysisError::NotApplicable { needs });
            }
            let unit = |k: usize| self.units[self.positions[led[k]]];
            let scaled = DMatrix::from_fn(led.len(), led.len(), |i, k| own[(i, k)] * unit(k) / unit(i));
            let largest = scaled.amax();
            let scaled = scaled.map(|x| if x.abs() > CANCELLED * largest { x } else { 0.0 });
            let power = (1..led.len()).fold(scaled.clone(), |power, _| power * &scaled);
            if power.amax() > 0.0 {
                let needs =
                    "dependent velocities that do not grow by themselves; take `StateSpace::about` and its A";
                return Err(AnalysisError::NotApplicable { needs });
            }
        }
        let (k, k_size) = (k * &by_u, k_size * by_u.abs());
        let blur = [m_size, c_size, &k_size].map(|size| size * ROUNDING);
        let drifting = self.drifting([c, &k], [c_size, &k_size]);
        let own = |indices: &[usize]| indices.iter().map(|&i| names[i].clone()).collect::<Vec<_>>();
        let constants: Vec<usize> = led.iter().map(|&k| self.positions[k]).collect();
        let small = SmallMotion::named(
            0.5 * (m + m.transpose()),
            separated(c, &blur[1]),
            separated(&k, &blur[2]),
            own(&self.velocities),
        )?;
        Ok(SmallMotion { blur, basis: self.v.clone(), constants: own(&constants), drifting, ..small })
    }

    /// Coordinates without elements of K, nor of C among each other.
    fn drifting(&self, [c, k]: [&DMatrix<f64>; 2], sizes: [&DMatrix<f64>; 2]) -> Vec<usize> {
        let [c_slack, k_slack] = sizes.map(|size| self.slack(size, &self.velocities));
        let zero = |a: &DMatrix<f64>, slack: &DMatrix<f64>, i: usize, j: usize| {
            a[(i, j)].abs() <= slack[(i, j)] && a[(j, i)].abs() <= slack[(j, i)]
        };
        let n = self.velocities.len();
        let mut all: Vec<usize> = (0..n).filter(|&j| (0..n).all(|i| zero(k, &k_slack, i, j))).collect();
        while let Some(place) = all.iter().position(|&i| all.iter().any(|&j| !zero(c, &c_slack, i, j))) {
            all.remove(place);
        }
        all
    }

    /// Magnitude up to which elements of a matrix count as zero: they are sums that cancel, or remainders of elements
    /// that the projection cancels.
    fn slack(&self, size: &DMatrix<f64>, columns: &[usize]) -> DMatrix<f64> {
        let unit = |i: usize, k: usize| self.units[self.velocities[i]] * self.units[columns[k]];
        let scaled = DMatrix::from_fn(size.nrows(), size.ncols(), |i, k| size[(i, k)] * unit(i, k));
        let largest = scaled.amax();
        DMatrix::from_fn(size.nrows(), size.ncols(), |i, k| {
            VANISHING * ROUNDING * size[(i, k)] + CANCELLED * largest / unit(i, k)
        })
    }

    /// Refuses a motion whose small motions have no constant coefficients, since a coordinate that moves acts on them.
    pub fn steady(&self, of: &Matrices, qd: &[f64]) -> Result<(), AnalysisError> {
        let slack = self.slack(&of.sizes[2], &self.positions);
        let acts =
            |k: usize| of.terms[2].column(k).iter().zip(&slack.column(k)).any(|(x, slack)| x.abs() > *slack);
        match (0..self.positions.len()).any(|k| qd[self.positions[k]] != 0.0 && acts(k)) {
            true => Err(AnalysisError::NotApplicable { needs: STEADY }),
            false => Ok(()),
        }
    }

    /// `(δq, δq̇)` by the states (z, u), and the indices of these in (q, q̇). Coordinates from `mechanical` on, time
    /// integrals of states of first order, are left out.
    pub fn states(&self, mechanical: usize) -> (DMatrix<f64>, Vec<usize>) {
        let n = self.h.nrows();
        let (z, u) = (self.positions.len(), self.velocities.len());
        let mut all = DMatrix::zeros(2 * n, z + u);
        all.view_mut((0, 0), (n, z)).copy_from(&self.h);
        all.view_mut((n, 0), (n, z)).copy_from(&self.w);
        all.view_mut((n, z), (n, u)).copy_from(&self.v);
        let indices = self.positions.iter().copied().chain(self.velocities.iter().map(|i| n + i));
        let kept: Vec<(usize, usize)> =
            indices.enumerate().filter(|(_, i)| *i < mechanical || *i >= n).collect();
        let (columns, indices): (Vec<usize>, Vec<usize>) = kept.into_iter().unzip();
        (all.select_columns(&columns), indices)
    }
}

/// M, C and K, the last one by z, and sums of the absolute values of their terms.
pub(super) struct Matrices {
    pub terms: [DMatrix<f64>; 3],
    pub sizes: [DMatrix<f64>; 3],
}

/// Free coordinates of reduced rows, and the null space of these.
fn basis(a: &DMatrix<f64>, pivots: &[Option<usize>], n: usize) -> (Vec<usize>, DMatrix<f64>) {
    let free: Vec<usize> = (0..n).filter(|i| !pivots.contains(&Some(*i))).collect();
    let mut basis = DMatrix::zeros(n, free.len());
    for (k, &i) in free.iter().enumerate() {
        basis[(i, k)] = 1.0;
        for (j, pivot) in pivots.iter().enumerate() {
            if let Some(row) = pivot {
                basis[(*row, k)] = -a[(j, i)];
            }
        }
    }
    (free, basis)
}

/// Without symmetric or antisymmetric parts that are rounding errors of projected entries.
fn separated(a: &DMatrix<f64>, blur: &DMatrix<f64>) -> DMatrix<f64> {
    DMatrix::from_fn(a.nrows(), a.ncols(), |i, j| {
        let (x, y, slack) = (a[(i, j)], a[(j, i)], blur[(i, j)] + blur[(j, i)]);
        match ((x + y).abs() <= slack, (x - y).abs() <= slack) {
            (false, true) => 0.5 * (x + y),
            (true, false) if i != j => 0.5 * (x - y),
            _ => x,
        }
    })
}

/// Units of the coordinates in which the diagonal of M is 1.
pub(super) fn units(m: &DMatrix<f64>) -> Vec<f64> {
    m.diagonal().iter().map(|&m| if m > 0.0 && m.is_finite() { 1.0 / m.sqrt() } else { 1.0 }).collect()
}

/// The largest class of coordinates that act on nothing.
pub(super) const IDLE_CLASS: u8 = 1;

/// The class of coordinates that act on accelerations.
pub(super) const ACTS: u8 = 3;

/// Classes of the coordinates by their influence on the accelerations and on the velocities of others: 0, none, and
/// their own velocities are not steady; 1, none; 2, on velocities; [`ACTS`].
pub(super) fn classes(
    all: &[Held],
    k: &DMatrix<f64>,
    units: &[f64],
    unsteady: &dyn Fn(usize) -> bool,
) -> Vec<u8> {
    let size = |i: usize, j: usize| k[(i, j)].abs() * units[i] * units[j];
    let n = units.len();
    let column = |j: usize| (0..n).map(|i| size(i, j)).fold(0.0, f64::max);
    let largest = (0..n).map(column).fold(0.0, f64::max);
    let leads = |j: usize| all.iter().any(|held| held.rate_by_coordinates[j] != 0.0);
    let class = |j: usize| match (column(j) > 1e-12 * largest, leads(j)) {
        (true, _) => ACTS,
        (false, true) => 2,
        (false, false) => u8::from(!unsteady(j)),
    };
    (0..n).map(class).collect()
}

/// An orthonormal basis of the deviations (δq, δq̇) from a state that constraints admit, but for the time integrals
/// of states of first order, 2N × n; none where there are no constraints.
pub(super) fn deviations<Sys: System<N, Scalar: Real>, const N: usize>(
    system: &Sys,
    at: &State<Sys::Scalar, N>,
) -> Result<Option<DMatrix<f64>>, AnalysisError> {
    let all = Held::known(system, at);
    if all.is_empty() {
        return Ok(None);
    }
    let space = TangentSpace::new(&all, &[1.0; N], &[ACTS; N])?;
    Ok(Some(space.states(N - Sys::FIRST_ORDER).0.qr().q()))
}

/// A matrix of a length that is known at run time.
pub(super) fn dynamic<S: Real, const N: usize>(a: &SMatrix<S, N, N>) -> DMatrix<f64> {
    DMatrix::from_fn(N, N, |i, j| a[(i, j)].to_f64())
}
