//! Motions without a closed form: Taylor series in double-double arithmetic.

use crate::failure::Failure;
use crate::integrate::integrate;
use crate::method::taylor::{LongTaylor, TaylorController};
use crate::scalar::DoubleDouble;
use crate::series::Analytic;
use crate::state::State;

/// Tolerance of every step, absolute and relative.
const TOLERANCE: f64 = 1e-30;

/// The motion of any system that has Taylor series, by [`const@LongTaylor`] in [`DoubleDouble`] with a tolerance of
/// 1e-30 in every step: `q(t + h) = Σ qₖ hᵏ`, k up to 46, from the emitted recurrences (Jorba and Zou, *Exper. Math.*
/// 14, 2005, 99).
///
/// It is no closed form: the error at the end is 1e-30 times the growth of the distance to a neighbouring motion. Where
/// independent computations of 30 digits are at hand it agrees with all of them (`tests/golden/thirty_digits.rs`).
/// Every method in `f64` may be measured against it but one: [`Taylor`](const@crate::Taylor) evaluates the same
/// recurrences, so that a wrong one would be wrong in both. For that one take a closed form, or digits from elsewhere.
///
/// ```
/// use lagrange_runtime::prelude::*;
/// use lagrange_runtime::DoubleDouble;
/// use lagrange_runtime::testing::reference::{SeriesMotion, SimplePendulum};
///
/// lagrangian! {
///     system Pendulum {
///         param l, g;
///         coord theta;
///         T = 0.5 * (l * dot(theta)).powi(2);
///         V = -g * l * cos(theta);
///     }
/// }
/// // The same system over other numbers: its parameters are the exact doubles that they are.
/// let pendulum = Pendulum { l: 0.85, g: 9.81 };
/// let exact = SeriesMotion::new(pendulum.map(DoubleDouble::from), State::new(0.0, [1.0], [0.0]));
/// let end = exact.state(18.5)?;
/// let (theta, thetad) = SimplePendulum::new(9.81, 0.85, 1.0, 0.0).state(18.5);
/// assert!((end.q[0] - theta).abs() < 1e-15 && (end.qd[0] - thetad).abs() < 1e-15);
/// # Ok::<(), Failure>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeriesMotion<Sys, const N: usize> {
    system: Sys,
    start: State<DoubleDouble, N>,
}

impl<Sys: Analytic<N, Scalar = DoubleDouble>, const N: usize> SeriesMotion<Sys, N> {
    /// The motion of `system` from `start`. Constants of the definition have all digits as they were written, where
    /// those of the system in `f64` are the nearest doubles: a number that is to be the same in both is a parameter.
    pub fn new(system: Sys, start: State<f64, N>) -> Self {
        SeriesMotion { system, start: start.map(DoubleDouble::from) }
    }

    /// The state at time `t` with all its digits. Integrated from the start each time.
    ///
    /// # Errors
    /// That of the run.
    pub fn digits(&self, t: f64) -> Result<State<DoubleDouble, N>, Failure> {
        let (method, control) = (LongTaylor, TaylorController::tolerance(TOLERANCE));
        let run = integrate(&self.system, method, control, self.start);
        run.until(DoubleDouble::from(t))
            .final_state()
            .map_err(|failed| failed.failure.map(DoubleDouble::value))
    }

    /// The state at time `t`, rounded once.
    ///
    /// # Errors
    /// That of the run.
    pub fn state(&self, t: f64) -> Result<State<f64, N>, Failure> {
        Ok(self.digits(t)?.map(DoubleDouble::value))
    }
}
