//! Drives of a motion from step to step: a run, or a stretch of the way of a stepper. Samples, events and integrals
//! are made from it.

use super::Statistics;
use super::engine::Engine;
use super::memories::DoubleBuffer;
use crate::controller::Controller;
use crate::event::sides::Sides;
use crate::failed::Failed;
use crate::failure::Failure;
use crate::method::{Method, Step};
use crate::scalar::{Real, Scalar};
use crate::state::State;
use crate::system::System;

/// The scalar of a drive.
pub type Number<D, const N: usize> = <<D as Drive<N>>::System as System<N>>::Scalar;

/// A motion that advances step by step to an end: a [`Run`](crate::Run), or a [`Stretch`](crate::integrate::Stretch) of
/// the way of a stepper. Implemented by these alone.
pub trait Drive<const N: usize> {
    /// The system that moves.
    type System: System<N, Scalar: Real>;
    /// The method of integration.
    type Method: Method<Self::System, N>;
    /// The controller of the step size.
    type Controller: Controller<Number<Self, N>, N, <Self::Method as Method<Self::System, N>>::Error>;

    #[doc(hidden)]
    fn system(&self) -> &Self::System;

    #[doc(hidden)]
    fn engine(&self) -> &Engine<Self::System, Self::Method, Self::Controller, N>;

    #[doc(hidden)]
    fn parts(&mut self) -> (&Self::System, &mut Engine<Self::System, Self::Method, Self::Controller, N>);

    /// Prepares for the next step, unless it is done.
    #[doc(hidden)]
    fn begin(&mut self) -> Result<(), Failure<Number<Self, N>>>;

    /// Takes the next step, if there is one left.
    #[doc(hidden)]
    fn advance(&mut self) -> Option<Result<Step<Self::System, Self::Method, N>, Failure<Number<Self, N>>>> {
        self.advance_towards(None)
    }

    /// The same; an adaptive step beyond the time `aim` is shortened to it.
    #[doc(hidden)]
    fn advance_towards(
        &mut self,
        aim: Option<f64>,
    ) -> Option<Result<Step<Self::System, Self::Method, N>, Failure<Number<Self, N>>>>;

    /// Ends the motion with a failure of its own or of what consumes its steps.
    #[doc(hidden)]
    fn fail(&mut self, failure: Failure<Number<Self, N>>) -> Failure<Number<Self, N>>;

    /// The failure that ended the motion.
    #[doc(hidden)]
    fn failure(&self) -> Option<Failure<Number<Self, N>>>;

    /// The motion may be left, and goes on then.
    #[doc(hidden)]
    const IS_LEFT: bool = false;

    /// Sides of events, kept by a motion that goes on after it is left.
    #[doc(hidden)]
    fn sides(&mut self) -> Option<&mut Sides> {
        None
    }

    /// Goes on from elsewhere.
    #[doc(hidden)]
    fn restart(&mut self, state: State<Number<Self, N>, N>) {
        self.parts().1.restart(state);
    }

    /// Goes back to a state within the last step, where the motion may be left.
    #[doc(hidden)]
    fn back_to(&mut self, _: State<Number<Self, N>, N>) {}

    /// Returns to the end of that step.
    #[doc(hidden)]
    fn return_to_end(&mut self) {}

    /// The end, if there is one.
    #[doc(hidden)]
    fn end(&self) -> Option<Number<Self, N>>;

    #[doc(hidden)]
    fn state(&self) -> &State<Number<Self, N>, N> {
        &self.engine().state
    }

    #[doc(hidden)]
    fn statistics(&self) -> Statistics {
        self.engine().statistics
    }

    /// Returns whether time grows.
    #[doc(hidden)]
    fn forward(&mut self) -> Result<bool, Failure<Number<Self, N>>> {
        self.begin()?;
        Ok(self.engine().h >= Scalar::zero())
    }

    /// The interpolant of the last step, its evaluations counted.
    #[doc(hidden)]
    fn interpolant(
        &mut self,
        step: &Step<Self::System, Self::Method, N>,
    ) -> <Self::Method as Method<Self::System, N>>::Interpolant {
        let (system, engine) = self.parts();
        engine.interpolant(system, step)
    }

    /// The state on the constraints of the system near `state`, if it has any.
    #[doc(hidden)]
    fn on_constraints(
        &self,
        state: State<Number<Self, N>, N>,
    ) -> Result<State<Number<Self, N>, N>, Failure<Number<Self, N>>> {
        self.engine().on_constraints(self.system(), state)
    }

    /// State and memory with which the next step will begin.
    #[doc(hidden)]
    fn memory(
        &mut self,
    ) -> Result<&<Self::Method as Method<Self::System, N>>::MethodState, Failure<Number<Self, N>>> {
        self.begin()?;
        let Engine { memory, state, h, .. } = self.engine();
        memory.as_ref().map(DoubleBuffer::now).ok_or(Failure::NonFinite { t: state.t, h: *h })
    }

    /// That `failure` ended this motion where it is.
    #[doc(hidden)]
    fn failed(&self, failure: Failure<Number<Self, N>>) -> Failed<Number<Self, N>, N> {
        self.engine().failed(failure)
    }

    /// Returns whether a motion of which all steps were taken has reached its end.
    #[doc(hidden)]
    #[inline(always)]
    fn outcome(&self) -> Result<(), Failed<Number<Self, N>, N>> {
        let failure = if self.end().is_none() { Some(Failure::BadEnd { end: None }) } else { self.failure() };
        match failure {
            Some(failure) => Err(self.failed(failure)),
            None => Ok(()),
        }
    }
}
