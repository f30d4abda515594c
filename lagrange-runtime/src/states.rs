//! States of first order: currents, filters, integrators of controllers, temperatures.

use crate::scalar::Scalar;
use crate::state::State;
use crate::system::System;
use nalgebra::SVector;

/// A system of `M` coordinates with `K` states of first order, ż = r(q, q̇, z, t), N = M + K. Emitted for every
/// system with `state`.
///
/// Methods know coordinates and velocities alone. A state is therefore the velocity of a coordinate, its own time
/// integral (of a current, the charge), on which nothing depends: `qd` of a [`State`] has the velocities and then the
/// states, `q` the coordinates and then the integrals, and the last elements of [`accel`](System::accel) are the
/// rates r. Every state is an output under its name as well.
///
/// ```
/// use lagrange_runtime::prelude::*;
/// lagrangian! {
///     /// A motor with the armature current `i` on a fly wheel.
///     pub system Motor {
///         param inertia, resistance, inductance, k;
///         input voltage;
///         coord theta: angle;
///         state i;
///         T = 0.5 * inertia * dot(theta).powi(2);
///         V = 0;
///         Q[theta] = k * i;
///         rate(i) = (voltage - resistance * i - k * dot(theta)) / inductance;
///     }
/// }
/// let mut motor = Motor::new(0.01, 1.0, 0.5, 0.1);
/// motor.voltage = 12.0;
/// let start = motor.start(0.0, [0.0], [0.0]);
/// let end = integrate(&motor, Dop853, PiController::tolerance(1e-10), start).until(50.0).final_state()?;
/// // At full speed the voltage k ω balances the input, and no current flows.
/// assert!((end.qd[0] - 120.0).abs() < 1e-6 && motor.i(&end.q, &end.qd, end.t).abs() < 1e-6);
/// assert_eq!((Motor::<f64>::STATES, motor.states(&end)[0]), (["i"], end.qd[1]));
/// # Ok::<(), Failure>(())
/// ```
#[diagnostic::on_unimplemented(
    message = "`{Self}` does not have these states of first order",
    note = "they are declared by `state z; rate(z) = …;` in `lagrangian! {{ … }}`"
)]
pub trait States<const N: usize, const M: usize, const K: usize>: System<N> {
    /// Names of the states, in the order of every vector of them.
    const STATES: [&'static str; K];

    /// Values of the K states at a start, each in its own unit, as the definition says; 0 where it says nothing.
    fn initial_states(&self) -> SVector<Self::Scalar, K>;

    /// The K states, each in its own unit.
    #[inline]
    fn states(&self, at: &State<Self::Scalar, N>) -> SVector<Self::Scalar, K> {
        SVector::from_fn(|k, _| at.qd[M + k])
    }

    /// Sets the K states, each in its own unit.
    #[inline]
    fn set_states(&self, at: &mut State<Self::Scalar, N>, states: &SVector<Self::Scalar, K>) {
        (0..K).for_each(|k| at.qd[M + k] = states[k]);
    }

    /// The state at time t, in s, with these M coordinates and their velocities, the states of first order at their
    /// initial values, and their integrals 0. Each coordinate is in its own unit, and its velocity in this unit per
    /// second.
    fn start(&self, t: Self::Scalar, q: [Self::Scalar; M], qd: [Self::Scalar; M]) -> State<Self::Scalar, N> {
        let (zero, states) = (Self::Scalar::zero(), self.initial_states());
        State {
            t,
            q: SVector::from_fn(|i, _| if i < M { q[i] } else { zero }),
            qd: SVector::from_fn(|i, _| if i < M { qd[i] } else { states[i - M] }),
        }
    }
}
