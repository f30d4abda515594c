//! Two ways to drive the time loop: `Run`, an iterator of accepted steps, which borrows its system, and `Stepper`,
//! which owns it.

use crate::controller::Controller;
pub use crate::failed::{Failed, Statistics};
use crate::failure::Failure;
use crate::method::{Method, Step};
use crate::scalar::{Real, Scalar};
use crate::state::State;
use crate::system::System;
use core::fmt;
pub use drive::{Drive, Number};
pub(crate) use engine::Engine;
use engine::Status;
#[cfg(feature = "std")]
pub use sampled::ControlLaw;
pub use sampled::{Control, Every};
#[cfg(feature = "std")]
pub use stepper::SampledStepper;
pub use stepper::{Advance, Stepper, Stretch};
pub(crate) use switches::crossed;

/// Integrates `system` from `start`. The result is an iterator of accepted steps, and lazy: a step is made when it is
/// requested.
///
/// ```
/// use lagrange_runtime::prelude::*;
/// struct Oscillator;
/// impl System<1> for Oscillator {
///     type Scalar = f64;
///     fn accel(&self, q: &SVector<f64, 1>, _: &SVector<f64, 1>, _: f64) -> SVector<f64, 1> {
///         -q
///     }
/// }
/// let start = State::new(0.0, [1.0], [0.0]);
/// for step in integrate(&Oscillator, Dop853, PiController::tolerance(1e-12), start).until(1.0) {
///     let step = step?;
///     assert!((step.to.q[0] - step.to.t.cos()).abs() < 1e-11);
/// }
/// # Ok::<(), Failure>(())
/// ```
pub fn integrate<Sys, M, C, const N: usize>(
    system: &Sys,
    method: M,
    controller: C,
    start: State<Sys::Scalar, N>,
) -> Run<'_, Sys, M, C, N>
where
    Sys: System<N>,
    Sys::Scalar: Real,
    M: Method<Sys, N>,
    C: Controller<Sys::Scalar, N, M::Error>,
{
    Run { system, engine: Engine::new(method, controller, start), witness: Witness(None) }
}

/// A run: an iterator of accepted steps, without end unless [`until`](Self::until) gives one. After a failure it
/// yields the failure once and ends.
#[must_use = "it makes no step unless it is iterated over, or run to its end"]
#[derive(Clone, Debug)]
pub struct Run<'a, Sys: System<N>, M: Method<Sys, N>, C, const N: usize> {
    system: &'a Sys,
    engine: Engine<Sys, M, C, N>,
    witness: Witness<'a, Sys::Scalar, N>,
}

/// Receiver of the failure of a run, whatever becomes of the value that says so.
#[derive(Clone, Copy)]
struct Witness<'a, S, const N: usize>(Option<&'a (dyn Fn(Failed<S, N>) + Sync)>);

impl<S, const N: usize> fmt::Debug for Witness<'_, S, N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Witness").field(&self.0.is_some()).finish()
    }
}

impl<'a, Sys, M, C, const N: usize> Run<'a, Sys, M, C, N>
where
    Sys: System<N>,
    Sys::Scalar: Real,
    M: Method<Sys, N>,
    C: Controller<Sys::Scalar, N, M::Error>,
{
    /// Ends the run exactly at `t = end`, before or after the start. A run that has reached its end may be given
    /// another one and goes on.
    ///
    /// Fixed steps are all equal: their number n is the smallest for which `(end − t₀)/n` is not longer than the step
    /// asked for (but for rounding), and `tₖ = t₀ + k (end − t₀)/n` is computed anew for each k, so that rounding
    /// errors of time do not add up. An adaptive run shortens its last step, or stretches it by up to 1 %.
    ///
    /// Checks what was given, and computes what the first step begins with; a failure comes in place of that step.
    // Here and inlined, so that a loop over the steps need not ask in each of them whether it is the first: the
    // optimiser lets the two ways to a step meet in registers, and pairs numbers there that do not belong together.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn until(mut self, end: Sys::Scalar) -> Self {
        self.engine.until(self.system, end);
        self
    }

    /// Fails with [`Failure::BudgetUsedUp`] when `max_steps` steps, accepted or not, did not suffice. The default is
    /// 1 000 000 for adaptive steps and no limit for fixed ones.
    pub fn max_steps(mut self, max_steps: u64) -> Self {
        self.engine.max_steps = Some(max_steps);
        self
    }

    /// Tells `witness` of a failure.
    #[cfg(feature = "ensemble")]
    pub(crate) fn witnessed(mut self, witness: &'a (dyn Fn(Failed<Sys::Scalar, N>) + Sync)) -> Self {
        self.witness = Witness(Some(witness));
        self
    }

    /// The state at which the run began.
    pub fn start(&self) -> &State<Sys::Scalar, N> {
        &self.engine.start
    }

    /// The state reached so far.
    pub fn state(&self) -> &State<Sys::Scalar, N> {
        &self.engine.state
    }

    /// The cost so far.
    pub fn statistics(&self) -> Statistics {
        self.engine.statistics
    }

    /// The failure that ended the run, if one did.
    pub fn failure(&self) -> Option<Failure<Sys::Scalar>> {
        if let Status::Failed(failure) = self.engine.status { Some(failure) } else { None }
    }

    /// The end given by [`until`](Self::until), in units of t.
    pub fn end(&self) -> Option<Sys::Scalar> {
        self.engine.end
    }

    /// The interpolant of a step of this run, its evaluations counted.
    pub fn interpolant(&mut self, step: &Step<Sys, M, N>) -> M::Interpolant {
        self.engine.interpolant(self.system, step)
    }

    /// Takes a failure of this run for an outcome: in a study of an ensemble a sample whose run fails counts as
    /// failed even if the function that watches it returns an output, unless it has called this.
    ///
    /// ```
    /// use lagrange_runtime::ensemble::{Ensemble, Moments, Table};
    /// use lagrange_runtime::prelude::*;
    /// lagrangian! {
    ///     system Falling {
    ///         coord x;
    ///         T = 0.5 * dot(x).powi(2);
    ///         V = -1 / x;
    ///     }
    /// }
    /// // Particles that fall into the centre at different times.
    /// let fall = |[x]: [f64; 1]| (Falling::new(), State::new(0.0, [x], [0.0]));
    /// let study = Ensemble::new(Table::new([[1.0], [2.0]]), 2, fall).integrate(Dop853, PiController::tolerance(1e-9), 10.0);
    /// let time = |_: &Falling, run: lagrange_runtime::Run<'_, Falling, Dop853, PiController, 1>| match run.failure_as_outcome().final_state() {
    ///     Ok(end) => Ok(end.t),
    ///     Err(failed) => Ok(failed.last.t),
    /// };
    /// let outcome = study.reduce(time, Moments)?;
    /// assert_eq!((outcome.statistic.count(), outcome.failures.count), (2, 0));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[cfg(feature = "ensemble")]
    pub fn failure_as_outcome(mut self) -> Self {
        self.witness = Witness(None);
        self
    }

    /// Continues from `state` instead of the state reached, at the same time or at another one: after an impact, say.
    /// The end, and what the run has cost, stay. A step size that is not given is chosen anew, since a jump makes a new
    /// motion. A run that has failed continues, too.
    ///
    /// ```
    /// use lagrange_runtime::prelude::*;
    /// # struct Free;
    /// # impl System<1> for Free {
    /// #     type Scalar = f64;
    /// #     fn accel(&self, q: &SVector<f64, 1>, _: &SVector<f64, 1>, _: f64) -> SVector<f64, 1> {
    /// #         q * 0.0
    /// #     }
    /// # }
    /// let mut run = integrate(&Free, Dop853, PiController::tolerance(1e-9), State::new(0.0, [0.0], [1.0])).until(1.0);
    /// run.run_to_end()?;
    /// // A blow that doubles the velocity.
    /// let mut state = *run.state();
    /// state.qd *= 2.0;
    /// run.restart(state);
    /// assert!((run.until(2.0).final_state()?.q[0] - 3.0).abs() < 1e-14);
    /// # Ok::<(), Failure>(())
    /// ```
    ///
    /// A state beyond the end is [`Failure::TimeGoesBack`] of the next step, unless [`until`](Self::until) gives a
    /// later one.
    pub fn restart(&mut self, state: State<Sys::Scalar, N>) {
        let (h, zero) = (self.engine.h, Sys::Scalar::zero());
        let behind = |end: &Sys::Scalar| h != zero && *end != state.t && (*end < state.t) != (h < zero);
        self.engine.restart(state);
        if let Some(end) = self.engine.end.filter(behind) {
            self.engine.status = Status::Refused(Failure::TimeGoesBack { t: state.t, end });
        }
    }

    /// The system of the run.
    pub(crate) fn system(&self) -> &'a Sys {
        self.system
    }

    /// Takes the next step, if there is one left. An adaptive one beyond the time `aim` is shortened to it.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn step(&mut self, aim: Option<f64>) -> Option<Result<Step<Sys, M, N>, Failure<Sys::Scalar>>> {
        if let Status::Failed(_) = self.engine.status {
            return None;
        }
        // (No closure, which would not be inlined: a step of many coordinates would be copied.)
        let stepped = match self.engine.begin(self.system) {
            Ok(()) => self.engine.step::<false>(self.system, aim),
            Err(failure) => Err(failure),
        };
        match stepped {
            Ok(step) => step.map(Ok),
            Err(failure) => {
                let failure = self.engine.explained(self.system, failure);
                Some(Err(self.fail(failure)))
            }
        }
    }
}

impl<Sys, M, C, const N: usize> Drive<N> for Run<'_, Sys, M, C, N>
where
    Sys: System<N>,
    Sys::Scalar: Real,
    M: Method<Sys, N>,
    C: Controller<Sys::Scalar, N, M::Error>,
{
    type System = Sys;
    type Method = M;
    type Controller = C;

    fn system(&self) -> &Sys {
        self.system
    }

    fn engine(&self) -> &Engine<Sys, M, C, N> {
        &self.engine
    }

    fn parts(&mut self) -> (&Sys, &mut Engine<Sys, M, C, N>) {
        (self.system, &mut self.engine)
    }

    fn restart(&mut self, state: State<Sys::Scalar, N>) {
        Run::restart(self, state);
    }

    fn begin(&mut self) -> Result<(), Failure<Sys::Scalar>> {
        self.engine.begin(self.system)
    }

    #[inline]
    fn advance_towards(&mut self, aim: Option<f64>) -> Option<Result<Step<Sys, M, N>, Failure<Sys::Scalar>>> {
        self.step(aim)
    }

    #[cold]
    fn fail(&mut self, failure: Failure<Sys::Scalar>) -> Failure<Sys::Scalar> {
        self.engine.status = Status::Failed(failure);
        if let Witness(Some(tell)) = self.witness {
            tell(self.engine.failed(failure));
        }
        failure
    }

    fn failure(&self) -> Option<Failure<Sys::Scalar>> {
        Run::failure(self)
    }

    fn end(&self) -> Option<Sys::Scalar> {
        self.engine.end
    }
}

impl<Sys, M, C, const N: usize> Iterator for Run<'_, Sys, M, C, N>
where
    Sys: System<N>,
    Sys::Scalar: Real,
    M: Method<Sys, N>,
    C: Controller<Sys::Scalar, N, M::Error>,
{
    type Item = Result<Step<Sys, M, N>, Failure<Sys::Scalar>>;

    #[inline]
    fn next(&mut self) -> Option<Self::Item> {
        self.step(None)
    }
}

mod drive;
mod engine;
#[cfg(feature = "std")]
pub(crate) mod lanes;
mod memories;
mod rules;
mod sampled;
mod stepper;
mod switches;
#[cfg(test)]
mod tests;
