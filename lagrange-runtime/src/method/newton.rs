//! What the implicit methods share: linear equations with the emitted Jacobian, reduced to N unknowns, velocities from
//! momenta, and when an iteration has converged.

use crate::failure::{Coordinate, Failure, why_not_finite};
use crate::linear::{Entry, Lu, Singular, ldlt, lu};
use crate::scalar::{Functions, Real, Scalar};
use crate::state::{State, Tangent};
use crate::system::{Jacobian, Lagrangian};
use nalgebra::{SMatrix, SVector};

/// Once changes are below this many ε, they may stop decreasing: the iteration has reached rounding.
pub(super) const ROUNDING: f64 = 65536.0;

/// `(λ − J)⁻¹` for `J = (0, 1; K, C)`, the Jacobian of `(q, q̇) ↦ (q̇, q̈)` with `K = ∂q̈/∂q` and `C = ∂q̈/∂q̇`.
///
/// Of `λ x − y = r` and `λ y − K x − C y = s` the first gives `x = (r + y)/λ`, so that N equations are left:
/// `(λ − C − K/λ) y = s + K r/λ` (Hairer, Nørsett, Wanner 1993, II.14; Hairer, Wanner 1996, IV.8, "second-order
/// equations"). That is an eighth of the work of 2N equations.
#[derive(Clone, Copy, Debug)]
pub(super) struct Resolvent<S, T, const N: usize> {
    lambda: T,
    k: SMatrix<S, N, N>,
    reduced: Lu<T, N>,
}

impl<S: Real, T: Entry<S>, const N: usize> Resolvent<S, T, N> {
    pub fn new(lambda: T, jacobian: &Jacobian<S, N>) -> Result<Self, Singular> {
        let reduced = SMatrix::from_fn(|i, j| {
            let rest = T::real(jacobian.qd[(i, j)]) + T::real(jacobian.q[(i, j)]) / lambda;
            if i == j { lambda - rest } else { T::real(S::zero()) - rest }
        });
        Ok(Resolvent { lambda, k: jacobian.q, reduced: lu(&reduced)? })
    }

    /// The `(x, y)` with `(λ − J)(x, y) = (r, s)`.
    pub fn solve(&self, r: &SVector<T, N>, s: &SVector<T, N>) -> (SVector<T, N>, SVector<T, N>) {
        let right = SVector::from_fn(|i, _| {
            (0..N).fold(s[i], |sum, j| sum + T::real(self.k[(i, j)]) * (r[j] / self.lambda))
        });
        let y = self.reduced.solve(&right);
        (SVector::from_fn(|i, _| (r[i] + y[i]) / self.lambda), y)
    }
}

impl<S: Real, const N: usize> Resolvent<S, S, N> {
    /// `(λ − J)⁻¹ right`.
    pub fn apply(&self, right: &Tangent<S, N>) -> Tangent<S, N> {
        let (q, qd) = self.solve(&right.q, &right.qd);
        Tangent { q, qd }
    }
}

/// Why the linear equations of a step cannot be solved: a Jacobian that is not finite, or a singular matrix.
pub(super) fn unsolvable<Sys: Lagrangian<N>, const N: usize>(
    system: &Sys,
    from: &State<Sys::Scalar, N>,
    h: Sys::Scalar,
    jacobian: &Jacobian<Sys::Scalar, N>,
    singular: Singular,
) -> Failure<Sys::Scalar>
where
    Sys::Scalar: Real,
{
    let finite = jacobian.q.iter().chain(jacobian.qd.iter()).all(|x| x.to_f64().is_finite());
    if finite {
        Failure::SingularStep { t: from.t, h, coordinate: Coordinate::of::<Sys, N>(singular.pivot) }
    } else {
        why_not_finite(system, from, h)
    }
}

/// A start for methods on (q, q̇): fails unless the accelerations there are finite.
pub(super) fn regular<Sys: Lagrangian<N>, const N: usize>(
    system: &Sys,
    at: &State<Sys::Scalar, N>,
) -> Result<(), Failure<Sys::Scalar>>
where
    Sys::Scalar: Real,
{
    let qd = system.accel(&at.q, &at.qd, at.t);
    if (State { t: at.t, q: at.q, qd }).is_finite() {
        Ok(())
    } else {
        Err(why_not_finite(system, at, Sys::Scalar::zero()))
    }
}

/// Why an iteration met numbers that are not finite: there are none at the start of the step already, or else it is the
/// iteration that diverged.
pub(super) fn diverged<Sys: Lagrangian<N>, const N: usize>(
    system: &Sys,
    from: &State<Sys::Scalar, N>,
    h: Sys::Scalar,
    iterations: u32,
) -> Failure<Sys::Scalar>
where
    Sys::Scalar: Real,
{
    match regular(system, from) {
        Ok(()) => Failure::NotConverged { t: from.t, h, iterations },
        Err(Failure::NonFinite { t, .. }) => Failure::NonFinite { t, h },
        Err(failure) => failure,
    }
}

/// Watches the sizes of the changes that an iteration makes for the point from which on they are made of rounding.
///
/// Changes need not decrease at each iteration: those of q and of p take turns in some systems, and complex eigenvalues
/// turn them. So what is asked for is a new least one, for as many iterations (at least 2, at most 8) as should, at the
/// mean rate so far, have brought a tenth of the least. An iteration that converges slowly is waited for that way.
pub(super) struct Stagnation {
    first: f64,
    least: f64,
    /// The iteration that had the least change, and the number of iterations so far.
    at: u32,
    count: u32,
}

impl Stagnation {
    pub fn new() -> Self {
        Stagnation { first: f64::INFINITY, least: f64::INFINITY, at: 0, count: 0 }
    }

    /// Whether, after one more `change`, there is nothing left to do. Changes above `rounding` are not made of rounding.
    pub fn reached(&mut self, change: f64, rounding: f64) -> bool {
        self.count += 1;
        if self.count == 1 {
            self.first = change;
        }
        if change < self.least {
            (self.least, self.at) = (change, self.count);
            return change == 0.0;
        }
        let missing = f64::from(self.count - self.at);
        let overdue = || {
            // Of an iteration that began at rounding no rate is known.
            let decades = Functions::ln(self.first / self.least) / core::f64::consts::LN_10;
            self.first <= rounding || decades * missing >= f64::from(self.at - 1)
        };
        self.least <= rounding && (missing >= 8.0 || (missing >= 2.0 && overdue()))
    }
}

/// The largest magnitude of a component; NaN where one is not a number.
pub(super) fn largest<S: Real, const N: usize>(x: &SVector<S, N>) -> f64 {
    x.iter().fold(0.0, |most, x| {
        let size = x.magnitude();
        // `f64::max` would pass over a NaN.
        if size > most || size.is_nan() { size } else { most }
    })
}

/// The size of `change` in q over that of `scale` in q, and the same in q̇; the larger of both.
pub(super) fn relative<S: Real, const N: usize>(change: &Tangent<S, N>, scale: [f64; 2]) -> f64 {
    let [q, qd] = [largest(&change.q), largest(&change.qd)];
    let over = |x: f64, scale: f64| if x == 0.0 { 0.0 } else { x / scale };
    let (q, qd) = (over(q, scale[0]), over(qd, scale[1]));
    if q > qd || q.is_nan() { q } else { qd }
}

/// Whether what is missing of the momenta `p = M q̇` is rounding. Of the velocities it may still be much, where the inertia
/// is nearly singular, but they cannot be known any better.
pub(super) fn at_rounding<S: Real, const N: usize>(
    defect: &SVector<S, N>,
    p: &SVector<S, N>,
    inertia: &SMatrix<S, N, N>,
    qd: &SVector<S, N>,
) -> bool {
    (0..N).all(|i| {
        let size = (0..N).fold(p[i].magnitude(), |sum, j| sum + (inertia[(i, j)] * qd[j]).magnitude());
        defect[i].magnitude() <= 4.0 * N as f64 * S::EPSILON * size
    })
}

/// The `q̇` with `∂L/∂q̇ = p`, by Newton's method with the inertia matrix from `guess` on: in one iteration (and one
/// that finds nothing left to do but rounding) where L is quadratic in q̇. `t` is the end of a step of size `h`, which is for
/// the failure only.
pub(super) fn velocities<Sys: Lagrangian<N>, const N: usize>(
    system: &Sys,
    q: &SVector<Sys::Scalar, N>,
    p: &SVector<Sys::Scalar, N>,
    t: Sys::Scalar,
    guess: &SVector<Sys::Scalar, N>,
    h: Sys::Scalar,
) -> Result<SVector<Sys::Scalar, N>, Failure<Sys::Scalar>>
where
    Sys::Scalar: Real,
{
    const MOST: u32 = 50;
    let began = t - h;
    let mut qd = *guess;
    for iterations in 1..=MOST {
        let at = State { t, q: *q, qd };
        let inertia = system.inertia(q, &qd, t);
        let Ok(factors) = ldlt(&inertia) else {
            return Err(why_not_finite(system, &at, h));
        };
        let defect = p - system.momenta(q, &qd, t);
        let converged = at_rounding(&defect, p, &inertia, &qd);
        let change = factors.solve(&defect);
        if !largest(&change).is_finite() {
            return Err(match iterations {
                1 => Failure::NonFinite { t: began, h },
                _ => Failure::NotConverged { t: began, h, iterations },
            });
        }
        qd += change;
        if converged {
            return Ok(qd);
        }
    }
    Err(Failure::NotConverged { t: began, h, iterations: MOST })
}

#[cfg(test)]
mod tests;
