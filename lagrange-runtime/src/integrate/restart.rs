//! A run that goes on from elsewhere, and steps apart from it, by which events are landed on.

use super::memories::Memories;
use super::switches::Approach;
use super::{Run, Status, attempt_beside};
use crate::controller::Controller;
use crate::failure::Failure;
use crate::method::{Method, Step};
use crate::scalar::{Real, Scalar};
use crate::state::State;
use crate::system::System;

impl<'a, Sys, M, C, const N: usize> Run<'a, Sys, M, C, N>
where
    Sys: System<N>,
    Sys::Scalar: Real,
    M: Method<Sys, N>,
    C: Controller<Sys::Scalar, N, M::Error>,
{
    /// Goes on from `state` instead of the state reached, at the same time or at another one: after an impact, say. The
    /// end, and what the run has cost, stay. A step size that is not given is chosen anew, since a jump makes a new
    /// motion. A run that has failed goes on, too.
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
    /// let mut run = integrate(&Free, Dop853, Pi::tolerance(1e-9), State::new(0.0, [0.0], [1.0])).until(1.0);
    /// run.run_out()?;
    /// // A blow that doubles the velocity.
    /// let mut state = *run.state();
    /// state.qd *= 2.0;
    /// run.restart(state);
    /// assert!((run.until(2.0).finish()?.q[0] - 3.0).abs() < 1e-14);
    /// # Ok::<(), Failure>(())
    /// ```
    pub fn restart(&mut self, state: State<Sys::Scalar, N>) {
        self.state = state;
        self.memory = None;
        self.h = Sys::Scalar::zero();
        self.approach = Approach::NONE;
        self.status = Status::Unprepared;
    }

    /// Goes on from `state`, at which a step with the given memory ended.
    pub(crate) fn land(&mut self, state: State<Sys::Scalar, N>, memory: M::Memory) {
        self.state = state;
        self.memory = Some(Memories::new(memory));
        self.approach = Approach::NONE;
        self.status = Status::Unprepared;
    }

    /// The method of the run.
    pub(crate) fn method(&self) -> &M {
        &self.method
    }

    /// The system of the run.
    pub(crate) fn system(&self) -> &'a Sys {
        self.system
    }

    /// The state on the constraints of the system near `state`, if it has any.
    pub(crate) fn on_constraints(
        &self,
        state: State<Sys::Scalar, N>,
    ) -> Result<State<Sys::Scalar, N>, Failure<Sys::Scalar>> {
        Ok(self.system.restored(&state)?.map_or(state, |restored| restored.state))
    }

    /// What the next step will begin with.
    pub(crate) fn memory(&mut self) -> Result<&M::Memory, Failure<Sys::Scalar>> {
        self.begin()?;
        self.memory.as_ref().map(Memories::now).ok_or(Failure::NonFinite { t: self.state.t, h: self.h })
    }

    /// A step of size `h` from anywhere, its evaluations counted, and what the next one begins with.
    pub(crate) fn attempt_from(
        &mut self,
        memory: &M::Memory,
        from: &State<Sys::Scalar, N>,
        h: Sys::Scalar,
    ) -> Result<(Step<Sys, M, N>, M::Memory), Failure<Sys::Scalar>> {
        let beside = attempt_beside(self.system, &self.method, &self.controller, memory, from, h)?;
        self.statistics.evaluations += u64::from(beside.0.evaluations);
        Ok(beside)
    }
}
