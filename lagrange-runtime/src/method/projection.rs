//! Projection on invariants: any method, made to keep the energy function and the momenta of ignorable coordinates.
//!
//! Standard projection (Hairer, Lubich, Wanner, *Geometric Numerical Integration*, 2006, IV.4): after each step of the
//! base method the state goes to the manifold on which the invariants have their values of the start, by the smallest
//! change in a norm. Since the change is of the size of the local error, the order stays.
//!
//! It is made in (q, p), where an ignorable momentum is an invariant itself and just set. The momenta that are left,
//! `π = M̃ q̇` with M̃ the inertia matrix M without the ignorable coordinates, are those of the motion beside them:
//! `H = ½ q̇ᵀ M̃ q̇ + V*(q)`, with `∂V*/∂q = −F*` the generalized force F where only ignorable coordinates move. In the
//! norm `‖(δq, δπ)‖² = δqᵀM δq/τ² + δπᵀM⁻¹δπ`, τ the time scale of the motion, the smallest change that restores H is
//! along `(−τ² M⁻¹F*, M̃ q̇)`, where π is taken along with q so that its kinetic energy stays, as that of a free motion
//! does: half by itself, and half as M̃ q̇ of the same q̇. (With p as it is, forces of inertia would be among F, which
//! are large for a body that is light in one direction and turns in it.) For τ² the ratio of the largest `q̇ᵀM q̇` to
//! the largest `F*ᵀM⁻¹F*` seen in the run is taken, so neither units nor turning points (q̇ = 0) nor places without
//! force matter; but τ is no more than 32 times the time since the start: a force that has hardly acted is no way to
//! restore H. The whole of M, and not only its diagonal, makes the choice of coordinates not matter either: near a
//! singular M a change along the diagonal would be large in the light direction.

use super::newton::{largest, velocities};
use super::{Interpolant, Method, Step};
use crate::failure::Failure;
use crate::iteration::{Iteration, Progress, chosen, some_finite};
use crate::lanes::lanewise;
use crate::linear::{dot, factored, product};
use crate::scalar::{Comparison, Real, Scalar, SimdScalar};
use crate::state::{State, Tangent};
use crate::system::{Conservative, System};
use nalgebra::{SMatrix, SVector};

/// Iterations of the correction; two to four are needed.
const MOST_ITERATIONS: u32 = 20;

/// Bound, in ε of its terms, below which an energy error that no longer shrinks is taken for rounding.
const ROUNDING: f64 = 1024.0;

/// Time scale of the motion in units of the time since the start, at most.
const LONGEST: f64 = 32.0;

/// A method that keeps the energy function `h = p·q̇ − L` and the momenta of ignorable coordinates at their values of
/// the start, to rounding, by projection after each step of the method inside. Order and error estimate are those of
/// that method, and the interpolant is its interpolant plus the correction in proportion to time.
///
/// The momenta of the projected state cost a new start of the inner method in each step. For long runs of systems that
/// are more than these invariants, symplectic methods are better; this is for adaptive steps, and for what must not
/// drift in energy at all.
///
/// ```
/// use lagrange_runtime::prelude::*;
/// lagrangian! {
///     system Pendulum {
///         param l, g = 9.81;
///         coord theta;
///         T = 0.5 * (l * dot(theta)).powi(2);
///         V = -g * l * cos(theta);
///     }
/// }
/// let (system, start) = (Pendulum::new(1.0), State::new(0.0, [2.0], [0.0]));
/// let run = integrate(&system, Projection(DormandPrince5), PiController::tolerance(1e-6), start).until(100.0);
/// let end = run.final_state()?;
/// let energy = |at: &State<f64, 1>| system.energy_function(&at.q, &at.qd, at.t);
/// assert!((energy(&end) - energy(&start)).abs() < 1e-14);
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
///
/// # Hypotheses
/// - Those of the inner method.
/// - Energy is conserved: time does not appear in L, and there are no other forces. rustc rejects other systems.
/// - The energy surface is regular: where its gradient vanishes, at equilibria, a step that has left it fails with
///   [`Failure::InvariantLost`].
/// - No direction is much lighter than the others while forces act on the body: a displacement changes a small momentum
///   by as much as a large one. The spin about an axis whose moment of inertia is 10⁻⁶ of the others is lost, without a
///   failure, where weight turns the body; at 10⁻² its error is 25 to 140 times that of the method inside.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Projection<M>(pub M);

impl<Sys: Conservative<N>, M: Method<Sys, N>, const N: usize> Method<Sys, N> for Projection<M>
where
    Sys::Scalar: SimdScalar,
{
    /// The memory of the inner method, and the invariants.
    type MethodState = (M::MethodState, Invariants<Sys::Scalar, N>);
    /// The step of the inner method.
    type InterpolantData = Step<Sys, M, N>;
    type Error = M::Error;
    type Interpolant = Corrected<M::Interpolant, Sys::Scalar, N>;

    fn order(&self) -> u32 {
        self.0.order()
    }

    fn implicit(&self) -> bool {
        self.0.implicit()
    }

    fn start(
        &self,
        system: &Sys,
        at: &State<Sys::Scalar, N>,
    ) -> Result<Self::MethodState, Failure<Sys::Scalar>> {
        Ok((self.0.start(system, at)?, Invariants::new(system, at)))
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn step_into(
        &self,
        system: &Sys,
        memory: &Self::MethodState,
        from: &State<Sys::Scalar, N>,
        h: Sys::Scalar,
        next: &mut Self::MethodState,
    ) -> Result<Step<Sys, Self, N>, Failure<Sys::Scalar>> {
        let (next, invariants) = (&mut next.0, &mut next.1);
        let inner = self.0.step_into(system, &memory.0, from, h, next)?;
        *invariants = memory.1;
        // What is not finite stays so: the run rejects it.
        let (to, iterations) =
            if some_finite(&inner.to) { invariants.project(system, &inner.to, h)? } else { (inner.to, 0) };
        if some_finite(&to) {
            *next = self.0.start(system, &to)?;
        }
        let evaluations = inner.evaluations + self.0.start_evaluations() + iterations;
        let error = inner.error.clone();
        Ok(Step { from: *from, to, h, error, stages: inner, evaluations })
    }

    #[inline(always)]
    fn interpolant(&self, system: &Sys, step: &Step<Sys, Self, N>) -> Self::Interpolant {
        Corrected::new(self.0.interpolant(system, &step.stages), step)
    }

    #[inline(always)]
    fn coarse_interpolant(&self, system: &Sys, step: &Step<Sys, Self, N>) -> Option<Self::Interpolant> {
        Some(Corrected::new(self.0.coarse_interpolant(system, &step.stages)?, step))
    }

    fn interpolant_evaluations(&self, dense: &Self::Interpolant) -> u32 {
        self.0.interpolant_evaluations(&dense.inner)
    }

    fn ends_at_switches(&self) -> bool {
        self.0.ends_at_switches()
    }

    fn start_evaluations(&self) -> u32 {
        self.0.start_evaluations()
    }
}

lanewise! { Invariants<N> { start, energy, momenta, kinetic, dynamic } }

/// The values of the invariants, and the sizes by which changes of q and p are weighed.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(bound(
        serialize = "S: crate::Scalar + serde::Serialize",
        deserialize = "S: crate::Scalar + serde::Deserialize<'de>"
    ))
)]
pub struct Invariants<S, const N: usize> {
    /// The time at which they were taken.
    start: S,
    energy: S,
    /// Momenta, of which those of the ignorable coordinates are kept.
    momenta: SVector<S, N>,
    /// The largest `q̇ᵀM q̇` and `FᵀM⁻¹F` so far.
    kinetic: S,
    dynamic: S,
}

impl<S: SimdScalar, const N: usize> Invariants<S, N> {
    fn new<Sys: Conservative<N, Scalar = S>>(system: &Sys, at: &State<S, N>) -> Self {
        Invariants {
            start: at.t,
            energy: system.energy_function(&at.q, &at.qd, at.t),
            momenta: system.momenta(&at.q, &at.qd, at.t),
            kinetic: S::zero(),
            dynamic: S::zero(),
        }
    }

    /// The state near `at` with these invariants, and the number of iterations.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn project<Sys: Conservative<N, Scalar = S>>(
        &mut self,
        system: &Sys,
        at: &State<S, N>,
        h: S,
    ) -> Result<(State<S, N>, u32), Failure<S>> {
        let t = at.t;
        let lost = Failure::InvariantLost { t: t - h, h };
        let momenta = self.momenta;
        let kept = |q: &_, qd: &_| {
            let mut p = system.momenta(q, qd, t);
            for &i in Sys::FACTS.ignorable {
                p[i] = momenta[i];
            }
            p
        };
        let (mut q, mut near) = (at.q, at.qd);
        // The nearest so far, its error, and that which may be rounding.
        let (mut best, mut least, mut rounding) = (*at, S::each(|_| f64::INFINITY), S::each(|_| 0.0));
        let mut iteration = Iteration::<S>::new();
        let mut iterations = 0;
        while iteration.goes_on() {
            iterations += 1;
            let p = kept(&q, &near);
            let qd = velocities(system, &q, &p, t, &near, h)?;
            let excess = system.energy_function(&q, &qd, t) - self.energy;
            let size = excess.magnitudes();
            // The terms whose difference the energy function is.
            let scale = dot(&p, &qd).magnitudes() + system.lagrangian(&q, &qd, t).magnitudes();
            let [sizes, scales] = [size.apart(), scale.apart()];
            let mut nearer = S::each(|_| false);
            iteration.decide(|i| {
                let [size, scale] = [&sizes, &scales].map(|x| x.as_ref()[i].to_f64());
                let (least, rounding) = (&mut least.as_mut()[i], &mut rounding.as_mut()[i]);
                if size < *least {
                    (*least, *rounding) = (size, ROUNDING * S::Element::EPSILON * scale);
                    nearer.as_mut()[i] = true;
                    if size <= 0.5 * S::Element::EPSILON * scale {
                        return Progress::Done;
                    } else if iterations < MOST_ITERATIONS {
                        return Progress::On;
                    }
                }
                if *least <= *rounding { Progress::Done } else { Progress::Failed }
            });
            best = State { t, q: chosen(&nearer, &q, &best.q), qd: chosen(&nearer, &qd, &best.qd) };
            if !iteration.goes_on() {
                break;
            }
            let (Change { fall, kick, far, less }, regular) =
                self.direction(system, &State { t, q, qd }, excess, iteration.on());
            iteration.decide(|i| if regular.as_ref()[i] { Progress::On } else { Progress::Failed });
            let there = q + fall * far;
            let inertia = system.inertia(&there, &qd, t);
            let free = without(Sys::FACTS.ignorable, inertia);
            // With the momenta as they are.
            let held = velocities(system, &there, &p, t, &qd, h)?;
            let moved = (kick + product(&free, &qd)) * S::from_f64(0.5) - product(&free, &held) - kick * less;
            // (As a change of velocities: where the body is light, the momenta's rounding would be a large one.)
            let next = held + factored(&inertia).solve(&moved);
            q = chosen(iteration.on(), &there, &q);
            near = chosen(iteration.on(), &next, &near);
        }
        if iteration.failed() {
            return Err(lost);
        }
        Ok((State { t, q: best.q, qd: iteration.result(&best.qd) }, iterations))
    }

    /// The smallest change that takes `excess` off the energy, to first order, in these places; and where there is one,
    /// for there is none where its gradient vanishes.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn direction<Sys: Conservative<N, Scalar = S>>(
        &mut self,
        system: &Sys,
        at: &State<S, N>,
        excess: S,
        places: &S::PerLane<bool>,
    ) -> (Change<S, N>, S::PerLane<bool>) {
        let State { t, q, qd } = at;
        let inertia = system.inertia(q, qd, *t);
        let factors = factored(&inertia);
        let kick = product(&without(Sys::FACTS.ignorable, inertia), qd);
        let force = system.momentum_rate(q, &(qd - factors.solve(&kick)), *t);
        let fall = factors.solve(&force);
        let [kinetic, dynamic, free] = [dot(&product(&inertia, qd), qd), dot(&force, &fall), dot(&kick, qd)];
        let most = |a: S, b: S| {
            let [old, new] = [a.magnitudes().apart(), b.magnitudes().apart()];
            let larger =
                S::each(|i| places.as_ref()[i] && new.as_ref()[i].to_f64() > old.as_ref()[i].to_f64());
            S::chosen(&larger, b, a)
        };
        (self.kinetic, self.dynamic) = (most(self.kinetic, kinetic), most(self.dynamic, dynamic));
        // τ² = a/b; without any force so far, or any velocity, one of them is 0 and the other any number.
        let seen = (*t - self.start) * S::from_f64(LONGEST);
        let limit = self.dynamic * seen * seen;
        let a = S::select(Comparison::Less, limit, self.kinetic, limit, self.kinetic);
        let b = S::select(Comparison::Equal, self.dynamic, S::zero(), S::one(), self.dynamic);
        let slope = a * dynamic + b * free;
        let factor = excess / slope;
        let change = Change { fall, kick, far: a * factor, less: b * factor };
        let sizes = (largest(&(fall * change.far)) + largest(&(kick * change.less))).apart();
        let [slope, factor] = [slope.apart(), factor.apart()];
        let regular = S::each(|i| {
            let [slope, factor] = [&slope, &factor].map(|x| x.as_ref()[i].to_f64());
            slope != 0.0 && factor.is_finite() && sizes.as_ref()[i].to_f64().is_finite()
        });
        (change, regular)
    }
}

/// Displacement `far` times the direction in which coordinates fall, and `less` of the momenta that they have beside
/// those that are ignorable.
struct Change<S, const N: usize> {
    fall: SVector<S, N>,
    kick: SVector<S, N>,
    far: S,
    less: S,
}

/// The inertia that is left when coordinates are eliminated whose momenta stay: the Schur complement, with zeros in
/// their rows and columns. It is that of the Routhian.
#[cfg_attr(not(debug_assertions), inline(always))]
fn without<S: SimdScalar, const N: usize>(
    ignorable: &[usize],
    mut inertia: SMatrix<S, N, N>,
) -> SMatrix<S, N, N> {
    for &k in ignorable {
        let (row, pivot) = (inertia.column(k).into_owned(), inertia[(k, k)]);
        inertia = SMatrix::from_fn(|i, j| {
            if i == k || j == k { S::zero() } else { inertia[(i, j)] - row[i] * row[j] / pivot }
        });
    }
    inertia
}

/// The interpolant of the inner method plus the part `(t − t₀)/h` of the correction, so that it meets both ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Corrected<D, S, const N: usize> {
    inner: D,
    t: S,
    h: S,
    change: Tangent<S, N>,
}

impl<D, S: Scalar, const N: usize> Corrected<D, S, N> {
    /// Interpolant of the step that was projected.
    #[inline(always)]
    fn new<Sys, M>(inner: D, step: &Step<Sys, Projection<M>, N>) -> Self
    where
        Sys: Conservative<N> + System<N, Scalar = S>,
        M: Method<Sys, N, Interpolant = D>,
        S: SimdScalar,
    {
        Corrected { inner, t: step.from.t, h: step.h, change: step.to.minus(&step.stages.to) }
    }
}

impl<D: Interpolant<S, N>, S: Scalar, const N: usize> Interpolant<S, N> for Corrected<D, S, N> {
    fn at(&self, t: S) -> State<S, N> {
        self.inner.at(t).moved(t, (t - self.t) / self.h, &self.change)
    }
}

#[cfg(test)]
mod tests;
