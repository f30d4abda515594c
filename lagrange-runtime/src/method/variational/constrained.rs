//! The variational midpoint rule on constraints.

use super::{Discrete, MOST_ITERATIONS, MethodState, Outcome, Sum, VariationalMidpoint};
use crate::constraint::{Constrained, transposed};
use crate::controller::NoEstimate;
use crate::facts::ConstraintKind;
use crate::failure::Failure;
use crate::iteration::{Iteration, Progress, chosen};
use crate::method::hermite::Hermite;
use crate::method::newton::{ROUNDING, Stagnation, larger, largest, over};
use crate::method::{Method, Step};
use crate::scalar::{Real, Scalar, SimdScalar};
use crate::state::{State, constant};
use crate::system::Lagrangian;
use nalgebra::SVector;

/// The variational integrator of the midpoint discrete Lagrangian for systems with constraints on positions: order 2,
/// symplectic on the constraints, time-symmetric (Marsden and West, Acta Numerica 10, 2001, 3.5; the discrete form of
/// Wendlandt and Marsden, *Physica D* 106, 1997).
///
/// With the mean velocity `v = (q₁ − q₀)/h`, the momenta `P = ∂L/∂q̇` and the force F in the middle, and the Jacobian A
/// of the constraints f, a step solves
///
/// `p₀ + A(q₀)ᵀ λ = P − h/2 F`, `f(q₁, t₁) = 0`, `p₁ = P + h/2 F + A(q₁)ᵀ μ`, `∂f/∂t + A(q₁) q̇₁ = 0`,
///
/// which is RATTLE (Andersen, *J. Comput. Phys.* 52, 1983) with the midpoint rule for Verlet's. Energy stays bounded
/// over any time (less well where rotations are coordinates and the motion is chaotic: docs/limits.md), and momenta of
/// symmetries that the constraints share are kept. The number M of constraints is inferred. States of first order are
/// taken along; their time constants bound the step.
///
/// ```
/// use lagrange_runtime::prelude::*;
/// use lagrange_runtime::method::variational::ConstrainedMidpoint;
///
/// lagrangian! {
///     /// A spherical pendulum.
///     system Pendulum {
///         param l = 1.0, g = 9.81;
///         coord n: direction;
///         T = 0.5 * l.powi(2) * dot(n).norm_squared();
///         V = g * l * n[2];
///     }
/// }
/// let pendulum = Pendulum::default();
/// let start = State::new(0.0, [1.0, 0.0, 0.0], [0.0, 1.0, 0.5]);
/// let end = integrate(&pendulum, ConstrainedMidpoint, FixedStep::new(0.01), start).until(100.0).final_state()?;
/// assert!((pendulum.energy_at(&end) - pendulum.energy_at(&start)).abs() < 1e-2);
/// let about_z = |at: &State<f64, 3>| at.q[0] * at.qd[1] - at.q[1] * at.qd[0];
/// assert!((about_z(&end) - about_z(&start)).abs() < 1e-12);
/// # Ok::<(), Failure>(())
/// ```
///
/// # Hypotheses
/// - Constraints are on positions. A system with constraints on velocities does not compile:
///
/// ```compile_fail
/// use lagrange_runtime::prelude::*;
/// use lagrange_runtime::method::variational::ConstrainedMidpoint;
///
/// lagrangian! {
///     /// A skate.
///     system Skate {
///         coord x, y, theta;
///         T = 0.5 * (dot(x).powi(2) + dot(y).powi(2) + dot(theta).powi(2));
///         V = x;
///         constraint blade: dot(x) * theta.sin() == dot(y) * theta.cos();
///     }
/// }
/// let start = State::new(0.0, [0.0; 3], [1.0, 0.0, 0.5]);
/// integrate(&Skate::default(), ConstrainedMidpoint, FixedStep::new(0.01), start).until(1.0).final_state().unwrap();
/// ```
///
/// - Steps are of one size, and so short that an iteration with the Jacobian of the start converges: else
///   [`Failure::NotConverged`].
/// - Accelerations are smooth within a step, as for [`VariationalMidpoint`].
/// - Redundant constraints are met by multipliers of least norm.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ConstrainedMidpoint<const M: usize>;

/// Are all constraints of a system on positions?
const fn is_holonomic<Sys: Lagrangian<N>, const N: usize>() -> bool {
    let constraints = Sys::FACTS.constraints;
    let mut i = 0;
    while i < constraints.len() {
        if !matches!(constraints[i].kind, ConstraintKind::Holonomic) {
            return false;
        }
        i += 1;
    }
    true
}

/// Iterations until changes are made of rounding, in each lane.
struct Changes<S: SimdScalar> {
    stagnation: S::PerLane<Stagnation>,
    iteration: Iteration<S>,
    count: u32,
}

impl<S: SimdScalar> Changes<S> {
    fn new() -> Self {
        Changes { stagnation: S::each(|_| Stagnation::new()), iteration: Iteration::new(), count: 0 }
    }

    /// Looks at a change of `from` by `by`, beside the size `scale` of what it is made of.
    fn look<const N: usize>(
        &mut self,
        (from, by): (&SVector<S, N>, &SVector<S, N>),
        scale: S::Sizes,
        failure: impl Fn(u32) -> Failure<S>,
    ) -> Result<(), Failure<S>> {
        self.count += 1;
        let change = largest(by);
        let changes = over(change, larger(largest(from), scale) + change).apart();
        let stagnation = self.stagnation.as_mut();
        self.iteration.decide(|i| {
            let change = changes.as_ref()[i].to_f64();
            if change.is_nan() {
                return Progress::Failed;
            }
            // (By powers of two: at rounding changes may become smaller by less and less for ever.)
            let change = f64::from_bits(change.to_bits() & (u64::MAX << 52));
            let is_over = stagnation[i].reached(change, ROUNDING * S::Element::EPSILON);
            if is_over { Progress::Done } else { Progress::On }
        });
        if self.count == MOST_ITERATIONS {
            self.iteration.give_up();
        }
        if self.iteration.failed() { Err(failure(self.count)) } else { Ok(()) }
    }
}

fn step<Sys, const N: usize, const M: usize>(
    system: &Sys,
    memory: &MethodState<Sys::Scalar, N>,
    from: &State<Sys::Scalar, N>,
    h: Sys::Scalar,
) -> Outcome<Sys::Scalar, N>
where
    Sys: Constrained<N, M>,
    Sys::Scalar: SimdScalar,
{
    let (one, half) = (Sys::Scalar::one(), h * Sys::Scalar::from_f64(0.5));
    let failed = |iterations| Failure::NotConverged { t: from.t, h, iterations };
    let (mut q, t) = (Sum { value: from.q, rest: memory.rest_q }, from.t + h);
    let begun = Sum { value: memory.p, rest: memory.rest_p };
    // Rounding of lengths makes changes of this size in mean velocities.
    let scale = largest(&from.q) / h.magnitudes();

    let jacobian = system.constraint_jacobian(&from.q, from.t);
    let (mut v, mut multipliers) = (from.qd, SVector::<Sys::Scalar, M>::from([Sys::Scalar::zero(); M]));
    let mut changes = Changes::<Sys::Scalar>::new();
    while changes.iteration.goes_on() {
        let [momentum, _, force] = VariationalMidpoint::momenta(system, &q, from.t, &v, h);
        let mut defect = Sum { value: begun.value - momentum, rest: begun.rest };
        defect.add_product(half, &force);
        defect.add_product(one, &transposed(&jacobian, &multipliers));
        let missing = system.constraints(&q.at(h, &v), t).map(|f| -f / h);
        let (change, pushed) = system.response(&from.q, &from.qd, from.t, &defect.value, &missing);
        let on = changes.iteration.on();
        multipliers = chosen(on, &(multipliers + pushed), &multipliers);
        let next = chosen(on, &(v + change), &v);
        changes.look((&v, &change), scale, failed)?;
        v = next;
    }
    v = changes.iteration.result(&v);
    let [_, _, force] = VariationalMidpoint::momenta(system, &q, from.t, &v, h);
    let mut p = begun;
    p.add_product(h, &force);
    p.add_product(one, &transposed(&jacobian, &multipliers));
    q.add_product(h, &v);

    let jacobian = system.constraint_jacobian(&q.value, t);
    // (Where a motion turns around, velocities are small and momenta have the rounding of those before.)
    let scale = larger(largest(&from.qd), largest(&v));
    let mut qd = v;
    let mut ends = Changes::<Sys::Scalar>::new();
    while ends.iteration.goes_on() {
        let defect = Sum { value: p.value - system.momenta(&q.value, &qd, t), rest: p.rest };
        let rates = system.constraint_rates(&q.value, &qd, t).map(|rate| -rate);
        let (change, pushed) = system.response(&q.value, &qd, t, &(defect.value + defect.rest), &rates);
        let (on, zero) = (ends.iteration.on(), constant(Sys::Scalar::zero()));
        p.add_product(one, &chosen(on, &transposed(&jacobian, &pushed), &zero));
        let next = chosen(on, &(qd + change), &qd);
        ends.look((&qd, &change), scale, failed)?;
        qd = next;
    }
    qd = ends.iteration.result(&qd);
    let memory = MethodState { p: p.value, rest_q: q.rest, rest_p: p.rest };
    Ok((State { t, q: q.value, qd }, memory, changes.count + ends.count))
}

impl<Sys, const N: usize, const M: usize> Method<Sys, N> for ConstrainedMidpoint<M>
where
    Sys: Constrained<N, M>,
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
        const { assert!(is_holonomic::<Sys, N>(), "`ConstrainedMidpoint` needs constraints on positions") };
        MethodState::new(system, at)
    }

    fn step_into(
        &self,
        system: &Sys,
        memory: &Self::MethodState,
        from: &State<Sys::Scalar, N>,
        h: Sys::Scalar,
        next: &mut Self::MethodState,
    ) -> Result<Step<Sys, Self, N>, Failure<Sys::Scalar>> {
        let (to, evaluations);
        (to, *next, evaluations) = step(system, memory, from, h)?;
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
