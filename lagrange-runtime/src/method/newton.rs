//! Newton's method of the implicit methods: linear equations with the emitted Jacobian, reduced to N unknowns,
//! velocities from momenta, and when an iteration has converged.

use crate::diagnosis::{beside, why_not_finite};
use crate::failure::{Coordinate, Failure};
use crate::iteration::{Iteration, Progress, chosen, some_finite};
use crate::lanes::Work;
use crate::linear::{Entry, Lu, Singular, factored, ldlt, lu};
use crate::scalar::{Comparison, Real, Scalar, SimdScalar};
use crate::state::{State, Tangent, constant};
use crate::system::{Jacobian, Lagrangian, System};
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
    reduced: Lu<S, T, N>,
}

impl<S: SimdScalar, T: Entry<S>, const N: usize> Resolvent<S, T, N> {
    #[inline(always)]
    pub fn new(lambda: T, jacobian: &Jacobian<S, N>) -> Result<Self, Singular> {
        let reduced = SMatrix::from_fn(|i, j| {
            let rest = T::real(jacobian.qd[(i, j)]) + T::real(jacobian.q[(i, j)]) / lambda;
            if i == j { lambda - rest } else { T::real(S::zero()) - rest }
        });
        Ok(Resolvent { lambda, k: jacobian.q, reduced: lu(&reduced)? })
    }

    /// The `(x, y)` with `(λ − J)(x, y) = (r, s)`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn solve(&self, r: &SVector<T, N>, s: &SVector<T, N>) -> (SVector<T, N>, SVector<T, N>) {
        let (mut right, mut x) = (*s, *r);
        for j in 0..N {
            let r = r[j] / self.lambda;
            for i in 0..N {
                right[i] = right[i] + T::real(self.k[(i, j)]) * r;
            }
        }
        let y = self.reduced.solve(&right);
        for i in 0..N {
            x[i] = (r[i] + y[i]) / self.lambda;
        }
        (x, y)
    }
}

impl<S: SimdScalar, const N: usize> Resolvent<S, S, N> {
    /// `(λ − J)⁻¹ right`.
    #[inline(always)]
    pub fn apply(&self, right: &Tangent<S, N>) -> Tangent<S, N> {
        let (q, qd) = self.solve(&right.q, &right.qd);
        Tangent { q, qd }
    }
}

/// The Jacobian at a state.
pub(super) struct Linearized<'a, Sys: System<N>, const N: usize> {
    pub system: &'a Sys,
    pub at: &'a State<Sys::Scalar, N>,
}

impl<Sys: Lagrangian<N>, const N: usize> Work for Linearized<'_, Sys, N> {
    type Output = Jacobian<Sys::Scalar, N>;

    #[inline(always)]
    fn run(self) -> Self::Output {
        self.system.jacobian(&self.at.q, &self.at.qd, self.at.t)
    }
}

/// Reason why the linear equations of a step cannot be solved: accelerations or a Jacobian that are not finite, or a
/// singular matrix.
pub(super) fn unsolvable<Sys: Lagrangian<N>, const N: usize>(
    system: &Sys,
    from: &State<Sys::Scalar, N>,
    h: Sys::Scalar,
    jacobian: &Jacobian<Sys::Scalar, N>,
    singular: Singular,
) -> Failure<Sys::Scalar>
where
    Sys::Scalar: SimdScalar,
{
    let is_finite = |x: Sys::Scalar| x * Scalar::zero() == Scalar::zero();
    let undefined =
        |i: &usize| !(0..N).all(|j| is_finite(jacobian.q[(*i, j)]) && is_finite(jacobian.qd[(*i, j)]));
    // Solving for nothing gives 0, and what is not a number where M is not regular: then that is the cause.
    let regular = || {
        let nothing = factored(&system.inertia(&from.q, &from.qd, from.t)).solve(&constant(Scalar::zero()));
        let accelerations = system.accel(&from.q, &from.qd, from.t);
        nothing.iter().chain(accelerations.iter()).all(|&x| is_finite(x))
    };
    // A derivative that is missing at one state is there beside it; numbers that overflow do so there, too.
    let isolated = || {
        let at = beside(from, 1.0);
        let jacobian = system.jacobian(&at.q, &at.qd, at.t);
        jacobian.q.iter().chain(jacobian.qd.iter()).all(|&x| is_finite(x))
    };
    match (0..N).find(undefined) {
        None => Failure::SingularStep { t: from.t, h, coordinate: Coordinate::of::<Sys, N>(singular.pivot) },
        Some(i) if regular() && isolated() => {
            Failure::NoDerivative { t: from.t, coordinate: Coordinate::of::<Sys, N>(i) }
        }
        Some(_) => why_not_finite(system, from, h),
    }
}

/// The accelerations at the start of methods on (q, q̇): fails unless they are finite, in one of the lanes at least.
pub(super) fn accelerations<Sys: Lagrangian<N>, const N: usize>(
    system: &Sys,
    at: &State<Sys::Scalar, N>,
) -> Result<SVector<Sys::Scalar, N>, Failure<Sys::Scalar>>
where
    Sys::Scalar: SimdScalar,
{
    known(system, at, system.accel(&at.q, &at.qd, at.t))
}

/// The momenta at the start of methods on (q, p): fails unless they are finite and the inertia matrix is regular, in
/// one of the lanes at least. In the others they are not numbers.
pub(super) fn momenta<Sys: Lagrangian<N>, const N: usize>(
    system: &Sys,
    at: &State<Sys::Scalar, N>,
) -> Result<SVector<Sys::Scalar, N>, Failure<Sys::Scalar>>
where
    Sys::Scalar: SimdScalar,
{
    // Solving for nothing gives 0, and where a pivot vanishes what is not a number.
    let nothing = factored(&system.inertia(&at.q, &at.qd, at.t)).solve(&constant(Sys::Scalar::zero()));
    known(system, at, system.momenta(&at.q, &at.qd, at.t) + nothing)
}

/// Values computed at a start, or the reason why they are not finite.
fn known<Sys: Lagrangian<N>, const N: usize>(
    system: &Sys,
    at: &State<Sys::Scalar, N>,
    x: SVector<Sys::Scalar, N>,
) -> Result<SVector<Sys::Scalar, N>, Failure<Sys::Scalar>>
where
    Sys::Scalar: SimdScalar,
{
    if some_finite(&State { t: at.t, q: at.q, qd: x }) {
        Ok(x)
    } else {
        Err(why_not_finite(system, at, Sys::Scalar::zero()))
    }
}

/// Reason why an iteration met numbers that are not finite: the accelerations at the start of the step are not, or
/// else the iteration diverged.
pub(super) fn diverged<Sys: Lagrangian<N>, const N: usize>(
    system: &Sys,
    from: &State<Sys::Scalar, N>,
    h: Sys::Scalar,
    iterations: u32,
) -> Failure<Sys::Scalar>
where
    Sys::Scalar: SimdScalar,
{
    match accelerations(system, from) {
        Ok(_) => Failure::NotConverged { t: from.t, h, iterations },
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

    /// Returns whether, after one more `change`, there is nothing left to do. Changes above `rounding` are not made
    /// of rounding.
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
            let decades = libm::log10(self.first / self.least);
            self.first <= rounding || decades * missing >= f64::from(self.at - 1)
        };
        self.least <= rounding && (missing >= 8.0 || (missing >= 2.0 && overdue()))
    }
}

/// The larger one of two sizes.
#[inline(always)]
pub(super) fn larger<R: Scalar>(a: R, b: R) -> R {
    R::select(Comparison::Less, a, b, b, a)
}

/// The largest magnitude of a component; NaN where one is not finite.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn largest<S: SimdScalar, const N: usize>(x: &SVector<S, N>) -> S::Sizes {
    let (mut most, mut sum) = (S::Sizes::zero(), S::Sizes::zero());
    for i in 0..N {
        let size = x[i].magnitudes();
        (most, sum) = (larger(most, size), sum + size);
    }
    // A comparison passes over a NaN; a sum keeps it.
    most + sum * S::Sizes::zero()
}

/// Size below which numbers are near underflow and have no relative accuracy; it is rounding of all numbers 16 digits
/// above.
const NEAR_UNDERFLOW: f64 = 1e-290;

/// A change over the size of what changes: 0 where there is none, and next to nothing among subnormal numbers.
#[inline(always)]
pub(super) fn over<R: Scalar>(change: R, size: R) -> R {
    R::select(Comparison::Equal, change, R::zero(), change, change / (size + R::from_f64(NEAR_UNDERFLOW)))
}

/// The size of `change` in q over that of `scale` in q, and the same in q̇; the larger of both, NaN where one is not
/// finite.
#[inline(always)]
pub(super) fn relative<S: SimdScalar, const N: usize>(
    change: &Tangent<S, N>,
    scale: [S::Sizes; 2],
) -> S::Sizes {
    let (q, qd) = (over(largest(&change.q), scale[0]), over(largest(&change.qd), scale[1]));
    larger(q, qd) + (q + qd) * S::Sizes::zero()
}

/// Tests whether the residual of the momenta `p = M q̇` is rounding. That of the velocities may still be large, where
/// the inertia is nearly singular, but they cannot be known any better.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn at_rounding<S: SimdScalar, const N: usize>(
    defect: &SVector<S, N>,
    p: &SVector<S, N>,
    inertia: &SMatrix<S, N, N>,
    qd: &SVector<S, N>,
) -> S::PerLane<bool> {
    let rounding = S::Sizes::from_f64(4.0 * N as f64 * S::Element::EPSILON);
    // The largest part of it that is no rounding.
    let mut most = S::Sizes::zero();
    for i in 0..N {
        let mut size = p[i].magnitudes();
        for j in 0..N {
            size += (inertia[(i, j)] * qd[j]).magnitudes();
        }
        let defect = defect[i].magnitudes();
        let beyond = S::Sizes::select(
            Comparison::LessEqual,
            defect,
            rounding * size,
            S::Sizes::zero(),
            S::Sizes::one(),
        );
        most = larger(most, beyond);
    }
    let most = most.apart();
    S::each(|i| most.as_ref()[i].to_f64() == 0.0)
}

/// The `q̇` with `∂L/∂q̇ = p`, by Newton's method with the inertia matrix from `guess` on: in one iteration (and one
/// that finds nothing left to do but rounding) where L is quadratic in q̇. `t` is the end of a step of size `h`,
/// which is for the failure only.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn velocities<Sys: Lagrangian<N>, const N: usize>(
    system: &Sys,
    q: &SVector<Sys::Scalar, N>,
    p: &SVector<Sys::Scalar, N>,
    t: Sys::Scalar,
    guess: &SVector<Sys::Scalar, N>,
    h: Sys::Scalar,
) -> Result<SVector<Sys::Scalar, N>, Failure<Sys::Scalar>>
where
    Sys::Scalar: SimdScalar,
{
    const MOST: u32 = 50;
    let began = t - h;
    let mut qd = *guess;
    let mut stagnation = Sys::Scalar::each(|_| Stagnation::new());
    let mut iteration = Iteration::<Sys::Scalar>::new();
    let mut iterations = 0;
    while iteration.goes_on() {
        iterations += 1;
        let inertia = system.inertia(q, &qd, t);
        let factors = factored(&inertia);
        let defect = p - system.momenta(q, &qd, t);
        let missing = factors.solve(&defect);
        let next = qd + missing;
        let before = qd;
        qd = chosen(iteration.on(), &next, &before);
        let (sizes, rounded) = (largest(&qd).apart(), at_rounding(&defect, p, &inertia, &before));
        let changes = over(largest(&missing), largest(&qd)).apart();
        iteration.decide(|i| {
            let rounding = ROUNDING * <Sys::Scalar as SimdScalar>::Element::EPSILON;
            if !sizes.as_ref()[i].to_f64().is_finite() {
                Progress::Failed
            } else if rounded.as_ref()[i]
                // A momentum that is small by cancellation within its own formula has a larger rounding than its size
                // tells.
                || stagnation.as_mut()[i].reached(changes.as_ref()[i].to_f64(), rounding)
            {
                Progress::Done
            } else {
                Progress::On
            }
        });
        if iteration.failed() {
            return Err(match (ldlt(&inertia), iterations) {
                (Err(_), _) => why_not_finite(system, &State { t, q: *q, qd: before }, h),
                (Ok(_), 1) => Failure::NonFinite { t: began, h },
                (Ok(_), _) => Failure::NotConverged { t: began, h, iterations },
            });
        }
        if iterations == MOST {
            iteration.give_up();
        }
    }
    if iteration.failed() {
        return Err(Failure::NotConverged { t: began, h, iterations: MOST });
    }
    Ok(iteration.result(&qd))
}

#[cfg(test)]
mod tests;
