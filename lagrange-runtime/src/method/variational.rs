//! Variational integrators: the discrete Hamilton's principle `δ Σ L_d(qₖ, qₖ₊₁) = 0` instead of a discretized
//! equation.
//!
//! In position–momentum form (Marsden and West, *Discrete mechanics and variational integrators*, Acta Numerica 10,
//! 2001, 1.5 and 3.2.1),
//!
//! `p₀ = −D₁L_d(q₀, q₁) − f⁻`, `p₁ = D₂L_d(q₀, q₁) + f⁺`,
//!
//! where D and Q enter by the discrete forces f± of the Lagrange–d'Alembert principle. With the mean velocity
//! `v = (q₁ − q₀)/h`, momenta `P = ∂L/∂q̇` and force `F = ∂L/∂q − ∂D/∂q̇ + Q`, both rules here are expressed by P and
//! F:
//!
//! | `L_d` | `p₀ =` | `p₁ =` |
//! |---|---|---|
//! | `h L((q₀ + q₁)/2, v)` | `P(q̄, v) − h/2 F(q̄, v)` | `P(q̄, v) + h/2 F(q̄, v)` |
//! | `h/2 (L(q₀, v) + L(q₁, v))` | `P̄ − h/2 F(q₀, v)`, `P̄ = ½(P(q₀, v) + P(q₁, v))` | `P̄ + h/2 F(q₁, v)` |
//!
//! Both are symplectic and time-symmetric, hence of order 2, and conserve the momenta of ignorable coordinates
//! exactly (discrete Noether theorem; here without any rounding, since nothing is ever added to them). v is found to
//! rounding by a simplified Newton iteration with `M (1 − h/2 C − κ h² K)`, where `K = ∂q̈/∂q`, `C = ∂q̈/∂q̇` and κ
//! is 1/4 or 0, whose error is `O(h²)`; it solves linear systems at once, so steps may be longer than stiff
//! oscillations. The sums over steps lose nothing to rounding.

use super::compensated::{Sum, forgetful};
use super::hermite::Hermite;
use super::newton::{
    Linearized, ROUNDING, Stagnation, at_rounding, diverged, larger, largest, momenta, over, unsolvable,
    velocities,
};
use super::{Method, Step};
use crate::controller::NoEstimate;
use crate::diagnosis::why_not_finite;
use crate::failure::Failure;
use crate::iteration::{Iteration, Progress, chosen};
use crate::lanes::{Work, lanewise};
use crate::linear::{Ldlt, Lu, ldlt, lu};
use crate::scalar::{Real, Scalar, SimdScalar};
use crate::state::{State, constant};
use crate::system::{Independent, Lagrangian, System};
use core::marker::PhantomData;
use nalgebra::{SMatrix, SVector};

/// Iterations after which a step fails; those worth waiting for need 2 to 10.
const MOST_ITERATIONS: u32 = 50;

/// A discrete Lagrangian.
trait Discrete {
    /// κ: how much `−∂F/∂q` there is in the derivative of `−D₁L_d` by v, over h².
    const STIFFNESS: f64;
    /// Evaluations of momenta and forces.
    const COST: u32;

    /// The momentum in the middle, `P(q̄, v)` or P̄; of the force that which leads from the start there, and their
    /// mean: `p₀ = P − h/2 F⁻`, `p₁ = p₀ + h F`.
    fn momenta<Sys: Lagrangian<N>, const N: usize>(
        system: &Sys,
        q: &Sum<Sys::Scalar, N>,
        t: Sys::Scalar,
        v: &SVector<Sys::Scalar, N>,
        h: Sys::Scalar,
    ) -> [SVector<Sys::Scalar, N>; 3]
    where
        Sys::Scalar: SimdScalar;
}

macro_rules! variational {
    ($($(#[$doc:meta])* $name:ident;)*) => {$(
        $(#[$doc])*
        ///
        /// For every Independent, Lagrangian, also one that is not quadratic in the velocities. Forces of D and Q are
        /// admitted. A step fails with [`Failure::NotConverged`] where no mean velocity is found.
        ///
        /// # Hypotheses
        /// - Coordinates are independent: rustc rejects other systems.
        /// - Steps are of one size: rustc rejects [`PiController`](crate::PiController), since there is no estimate
        ///   of the error.
        /// - Accelerations are smooth within a step. Adaptive runs end steps at the switches that the compiler knows;
        ///   steps of one size go over them, with an error of order h where forces jump and h² where they have a
        ///   kink.
        /// - Forces act for a step at least, see [forces that set in later](crate::method#forces-that-set-in-later).
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
        #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct $name;

        impl<Sys: Independent<N>, const N: usize> Method<Sys, N> for $name
        where
            Sys::Scalar: SimdScalar,
        {
            type MethodState = MethodState<Sys::Scalar, N>;
            type InterpolantData = ();
            type Error = NoEstimate;
            type Interpolant = Hermite<Sys::Scalar, N>;

            fn order(&self) -> u32 {
                2
            }

            fn implicit(&self) -> bool {
                true
            }

            fn start(
                &self,
                system: &Sys,
                at: &State<Sys::Scalar, N>,
            ) -> Result<Self::MethodState, Failure<Sys::Scalar>> {
                MethodState::new(system, at)
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
                let (to, evaluations);
                (to, *next, evaluations) = step::<$name, Sys, N>(system, memory, from, h)?;
                Ok(Step { from: *from, to, h, error: NoEstimate, stages: (), evaluations })
            }

            #[inline(always)]
            fn interpolant(&self, system: &Sys, step: &Step<Sys, Self, N>) -> Self::Interpolant {
                let [from, to] = [&step.from, &step.to].map(|end| system.accel(&end.q, &end.qd, end.t));
                Hermite::new(&step.from, &step.to, step.h, &from, &to)
            }

            fn interpolant_evaluations(&self, _: &Self::Interpolant) -> u32 {
                2
            }
        }
    )*};
}

variational! {
    /// The variational integrator of the midpoint discrete Lagrangian: order 2, symplectic, time-symmetric, stable for
    /// every linear oscillation (Marsden and West 2001, 2.6.3, α = ½).
    ///
    /// It is the same map as [`ImplicitMidpoint`](super::gauss::ImplicitMidpoint) where that exists, solved by Newton's
    /// method with the Jacobian instead of a fixed-point iteration: steps may be longer than the fastest oscillation.
    VariationalMidpoint;

    /// The variational integrator of the trapezoidal discrete Lagrangian: order 2, symplectic, time-symmetric
    /// (Marsden and West 2001, 2.6.4; MacKay 1992). For `T(q̇) + V(q)` it is [`Verlet`](super::splitting::Verlet), of
    /// which it is the generalization, with its limit of stability: h times the highest frequency below 2.
    VariationalTrapezoid;
}

impl Discrete for VariationalMidpoint {
    const STIFFNESS: f64 = 0.25;
    const COST: u32 = 1;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn momenta<Sys: Lagrangian<N>, const N: usize>(
        system: &Sys,
        q: &Sum<Sys::Scalar, N>,
        t: Sys::Scalar,
        v: &SVector<Sys::Scalar, N>,
        h: Sys::Scalar,
    ) -> [SVector<Sys::Scalar, N>; 3]
    where
        Sys::Scalar: SimdScalar,
    {
        let half = h * Sys::Scalar::from_f64(0.5);
        let (q, t) = (q.at(half, v), t + half);
        let force = system.momentum_rate(&q, v, t);
        [system.momenta(&q, v, t), force, force]
    }
}

impl Discrete for VariationalTrapezoid {
    const STIFFNESS: f64 = 0.0;
    const COST: u32 = 2;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn momenta<Sys: Lagrangian<N>, const N: usize>(
        system: &Sys,
        q: &Sum<Sys::Scalar, N>,
        t: Sys::Scalar,
        v: &SVector<Sys::Scalar, N>,
        h: Sys::Scalar,
    ) -> [SVector<Sys::Scalar, N>; 3]
    where
        Sys::Scalar: SimdScalar,
    {
        let half = Sys::Scalar::from_f64(0.5);
        let (start, end) = (q.value, q.at(h, v));
        let momentum = (system.momenta(&start, v, t) + system.momenta(&end, v, t + h)) * half;
        let before = system.momentum_rate(&start, v, t);
        let after = system.momentum_rate(&end, v, t + h);
        [momentum, before, (before + after) * half]
    }
}

/// Memory of a variational integrator: the momenta, and what rounding took from q and p so far.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(bound(
        serialize = "S: crate::Scalar + serde::Serialize",
        deserialize = "S: crate::Scalar + serde::Deserialize<'de>"
    ))
)]
pub struct MethodState<S, const N: usize> {
    p: SVector<S, N>,
    rest_q: SVector<S, N>,
    rest_p: SVector<S, N>,
}

lanewise! { MethodState<N> { p, rest_q, rest_p } }

impl<S: SimdScalar, const N: usize> MethodState<S, N> {
    fn new<Sys: Lagrangian<N, Scalar = S>>(system: &Sys, at: &State<S, N>) -> Result<Self, Failure<S>> {
        let p = momenta(system, at)?;
        Ok(MethodState { p, rest_q: constant(S::zero()), rest_p: constant(S::zero()) })
    }
}

/// M, and the two factors of `M (1 − h/2 C − κ h² K)`, themselves factored.
type Factors<S, const N: usize> = (SMatrix<S, N, N>, Ldlt<S, N>, Lu<S, S, N>);

/// `M (1 − h/2 C − κ h² K)`, factored.
#[cfg_attr(not(debug_assertions), inline(always))]
fn factors<D: Discrete, Sys: Lagrangian<N>, const N: usize>(
    system: &Sys,
    from: &State<Sys::Scalar, N>,
    h: Sys::Scalar,
) -> Result<Factors<Sys::Scalar, N>, Failure<Sys::Scalar>>
where
    Sys::Scalar: SimdScalar,
{
    let inertia = system.inertia(&from.q, &from.qd, from.t);
    let factors = ldlt(&inertia).map_err(|_| why_not_finite(system, from, h))?;
    let jacobian = Sys::Scalar::evaluate(Linearized { system, at: from });
    let (c, k) = (-h * Sys::Scalar::from_f64(0.5), -h * h * Sys::Scalar::from_f64(D::STIFFNESS));
    let matrix = SMatrix::from_fn(|i, j| {
        let rest = c * jacobian.qd[(i, j)] + k * jacobian.q[(i, j)];
        if i == j { Sys::Scalar::one() + rest } else { rest }
    });
    let matrix = lu(&matrix).map_err(|singular| unsolvable(system, from, h, &jacobian, singular))?;
    Ok((inertia, factors, matrix))
}

type Outcome<S, const N: usize> = Result<(State<S, N>, MethodState<S, N>, u32), Failure<S>>;

/// Step by a trial mean velocity.
struct Attempt<'a, D, Sys: System<N>, const N: usize> {
    system: &'a Sys,
    t: Sys::Scalar,
    h: Sys::Scalar,
    q: Sum<Sys::Scalar, N>,
    p: Sum<Sys::Scalar, N>,
    v: SVector<Sys::Scalar, N>,
    of: PhantomData<fn() -> D>,
}

impl<D: Discrete, Sys: Lagrangian<N>, const N: usize> Work for Attempt<'_, D, Sys, N>
where
    Sys::Scalar: SimdScalar,
{
    /// The force, and what the momentum lacks.
    type Output = [SVector<Sys::Scalar, N>; 2];

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn run(self) -> Self::Output {
        let Attempt { system, t, h, q, p, v, .. } = self;
        let [momentum, before, force] = D::momenta(system, &q, t, &v, h);
        // The large terms first, which cancel without rounding.
        let mut defect = Sum { value: p.value - momentum, rest: p.rest };
        defect.add_product(h * Sys::Scalar::from_f64(0.5), &before);
        [force, defect.value]
    }
}

#[cfg_attr(not(debug_assertions), inline(always))]
fn step<D: Discrete, Sys: Lagrangian<N>, const N: usize>(
    system: &Sys,
    memory: &MethodState<Sys::Scalar, N>,
    from: &State<Sys::Scalar, N>,
    h: Sys::Scalar,
) -> Outcome<Sys::Scalar, N>
where
    Sys::Scalar: SimdScalar,
{
    let (inertia, factors, matrix) = factors::<D, Sys, N>(system, from, h)?;
    let mut q = Sum { value: from.q, rest: memory.rest_q };
    let mut p = Sum { value: memory.p, rest: memory.rest_p };
    let mut v = from.qd;
    // The force, what the momentum lacks, and what v lacks. (No closure, which would not be inlined.)
    macro_rules! attempt {
        () => {{
            let attempt = Attempt::<D, _, N> { system, t: from.t, h, q, p, v, of: PhantomData };
            let [force, defect] = Sys::Scalar::evaluate(attempt);
            (force, defect, matrix.solve(&factors.solve(&defect)))
        }};
    }
    let mut stagnation = Sys::Scalar::each(|_| Stagnation::new());
    let mut iteration = Iteration::<Sys::Scalar>::new();
    let mut iterations = 0;
    while iteration.goes_on() {
        let (_, defect, missing) = attempt!();
        iterations += 1;
        let size = largest(&missing);
        let scale = larger(largest(&v), size) + largest(&from.q) / h.magnitudes();
        let change = over(size, scale) + size * <Sys::Scalar as SimdScalar>::Sizes::zero();
        let changes = change.apart();
        let rounded = at_rounding(&defect, &p.value, &inertia, &v);
        iteration.decide(|i| {
            let change = changes.as_ref()[i].to_f64();
            let rounding = ROUNDING * <Sys::Scalar as SimdScalar>::Element::EPSILON;
            if change.is_nan() {
                return Progress::Failed;
            }
            let stagnant = stagnation.as_mut()[i].reached(change, rounding);
            if stagnant || rounded.as_ref()[i] { Progress::Done } else { Progress::On }
        });
        if iteration.failed() {
            return Err(diverged(system, from, h, iterations));
        }
        if iterations == MOST_ITERATIONS {
            iteration.give_up();
            if iteration.failed() {
                return Err(Failure::NotConverged { t: from.t, h, iterations });
            }
        }
        v = chosen(iteration.on(), &(v + missing), &v);
    }
    v = forgetful(&v);
    v += attempt!().2;
    let (force, _, rest) = attempt!();
    iterations += 2;
    // The last change is too small for v, but not for q.
    q.add_product(h, &v);
    q.add_product(h, &rest);
    p.add_product(h, &force);
    let t = from.t + h;
    let qd = iteration.result(&velocities(system, &q.value, &p.value, t, &v, h)?);
    let memory = MethodState { p: p.value, rest_q: q.rest, rest_p: p.rest };
    Ok((State { t, q: q.value, qd }, memory, 1 + D::COST * iterations))
}

mod constrained;
#[cfg(test)]
mod tests;

pub use constrained::ConstrainedMidpoint;
