//! Steps through, to and past states at which constraints are dependent.

use super::{Engine, tolerated};
use crate::constraint::{CLOSE, NEARLY_DEPENDENT};
use crate::controller::Controller;
use crate::failure::Failure;
use crate::integrate::memories::DoubleBuffer;
use crate::method::{Across, Interpolant, Method, Step};
use crate::scalar::{Real, Scalar};
use crate::state::{Begun, Restored, State};
use crate::system::System;

/// Size of a step across, in units of the first one, below which constraints count as independent if it fails.
const SHORTEST_ACROSS: f64 = 1e-5;

impl<Sys, M, C, const N: usize> Engine<Sys, M, C, N>
where
    Sys: System<N>,
    Sys::Scalar: Real,
    M: Method<Sys, N>,
    C: Controller<Sys::Scalar, N, M::Error>,
{
    /// The interpolant of a step past a state at which constraints are dependent: that of a step across, which ends
    /// where this one does. Stages of an interpolant may be so near to such a state that their accelerations mean
    /// nothing, though those of the step are not.
    #[cold]
    #[inline(never)]
    pub(super) fn interpolant_past(
        &mut self,
        system: &Sys,
        step: &Step<Sys, M, N>,
    ) -> Option<M::Interpolant> {
        if !self.passes_near(system, &step.from, step.h) {
            return None;
        }
        let across = self.across(system, step.h);
        let memory = self.method.start_across(&across, &step.from).ok()?;
        let again =
            self.method.step_across(&across, &memory, &step.from, step.h, &mut memory.clone()).ok()?;
        self.statistics.evaluations += u64::from(self.method.start_evaluations() + again.evaluations);
        let is_same = tolerated(&self.controller, &again.to.minus(&step.to), &step.from, &step.to);
        is_same.then(|| self.method.interpolant_across(&across, &again))
    }

    /// The state of a step that is nearest to one at which constraints are dependent, if it comes near.
    #[cold]
    #[inline(never)]
    pub fn nearest_dependence(
        &mut self,
        system: &Sys,
        step: &Step<Sys, M, N>,
    ) -> Option<State<Sys::Scalar, N>> {
        if !Self::DEPENDENT || !(self.across[0] || self.passes_near(system, &step.from, step.h)) {
            return None;
        }
        let dense = self.interpolant(system, step);
        let at = |x: f64| dense.at(step.h.mul_add(Sys::Scalar::from_f64(x), step.from.t));
        let independence = |x: f64| system.independence(&self.reference, &at(x));
        let (mut x, mut apart) = (0.5, 0.5);
        // (A state beside it does as well: a reaction that grows is no number some way around.)
        while apart > 1e-3 {
            let places = [x - apart, x - 0.5 * apart, x, x + 0.5 * apart, x + apart];
            let within = places.into_iter().filter(|x| (0.0..=1.0).contains(x));
            x = within.min_by(|a, b| independence(*a).total_cmp(&independence(*b))).unwrap_or(x);
            apart *= 0.5;
        }
        Some(at(x))
    }

    /// Returns whether a motion comes near a state at which constraints are dependent within a step.
    pub(super) fn passes_near(&self, system: &Sys, from: &State<Sys::Scalar, N>, h: Sys::Scalar) -> bool {
        let dependent = |part: f64| {
            let q = from.q + from.qd * (h * Sys::Scalar::from_f64(part));
            system.independence(&self.reference, &State { q, ..*from }) < NEARLY_DEPENDENT
        };
        [0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0].into_iter().any(dependent)
    }

    /// Returns whether a state is so near to one at which constraints are dependent that a projection loses its digits.
    #[cold]
    #[inline(never)]
    pub(super) fn is_close(&self, system: &Sys, at: &State<Sys::Scalar, N>) -> bool {
        system.independence(&self.reference, at) < CLOSE
    }

    /// Steps are made as those through a state at which constraints are dependent if the motion begins near one, on a
    /// branch that its velocity tells.
    #[cold]
    #[inline(never)]
    pub(super) fn begin_across(&mut self, system: &Sys) {
        if self.across[1] || !(self.state.is_finite() && self.state.t.to_f64().is_finite()) {
            return;
        }
        let Some(Begun { state, reference }) = system.begun_across(&self.state) else { return };
        self.reference = reference;
        let starts = |state: &State<Sys::Scalar, N>| {
            let accel = system.accel_across(&reference, state, Sys::Scalar::zero(), false);
            accel.iter().all(|x| x.to_f64().is_finite())
        };
        if let Some(state) = state.filter(starts) {
            (self.state, self.across[1]) = (state, true);
        }
    }

    /// [`attempt_from`](Self::attempt_from) through, or to, a state at which constraints are dependent.
    #[cold]
    #[inline(never)]
    pub(super) fn attempt_across_from(
        &self,
        system: &Sys,
        from: &State<Sys::Scalar, N>,
        h: Sys::Scalar,
    ) -> Result<(Step<Sys, M, N>, M::MethodState), Failure<Sys::Scalar>> {
        let across = Across { last: true, ..self.across(system, h) };
        let memory = self.method.start_across(&across, from)?;
        let mut next = memory.clone();
        let step =
            Self::attempt_across(&across, &self.method, &self.controller, &memory, from, h, &mut next)?;
        Ok((step, next))
    }

    /// The system as a step of size `h` sees it that goes through a state at which constraints are dependent.
    pub(super) fn across<'a>(&self, system: &'a Sys, h: Sys::Scalar) -> Across<'a, Sys, N> {
        Across { system, reference: self.reference, h, last: false }
    }

    /// Returns whether the step after a rejected one of size `h` is made through a state at which constraints are
    /// dependent, where that one was not.
    ///
    /// # Errors
    /// [`Failure::Bifurcation`].
    #[cold]
    #[inline(never)]
    pub(super) fn sets_out_across(
        &mut self,
        system: &Sys,
        h: Sys::Scalar,
    ) -> Result<bool, Failure<Sys::Scalar>> {
        let turned_back =
            || self.set_out < 0.0 && system.independence(&self.reference, &self.state) < NEARLY_DEPENDENT;
        if self.across[1] || turned_back() || !self.passes_near(system, &self.state, h) {
            return Ok(false);
        }
        system.determined(&self.start, &self.state)?;
        let Ok(memory) = self.method.start_across(&self.across(system, h), &self.state) else {
            return Ok(false);
        };
        self.statistics.evaluations += u64::from(self.method.start_evaluations());
        self.memory = Some(DoubleBuffer::new(memory));
        (self.across[1], self.set_out) = (true, h.to_f64().abs());
        Ok(true)
    }

    /// Goes on as if constraints were independent, where steps across fail however short they are: they are independent
    /// where two bodies of very different masses are in line, or a gradient is short for some time and does not vanish.
    ///
    /// # Errors
    /// Those of [`Method::start`].
    #[cold]
    #[inline(never)]
    pub(super) fn turns_back(&mut self, system: &Sys) -> Result<bool, Failure<Sys::Scalar>> {
        if !self.across[1] || self.h.to_f64().abs() >= SHORTEST_ACROSS * self.set_out {
            return Ok(false);
        }
        self.memory = Some(DoubleBuffer::new(self.method.start(system, &self.state)?));
        self.statistics.evaluations += u64::from(self.method.start_evaluations());
        (self.across[1], self.set_out) = (false, -1.0);
        Ok(true)
    }

    /// Decides after a step whether the next one is made across, too. Slopes may not go through such a state.
    #[cold]
    #[inline(never)]
    pub(super) fn gets_across(
        &mut self,
        system: &Sys,
        step: &Step<Sys, M, N>,
    ) -> Result<(), Failure<Sys::Scalar>> {
        if Sys::Scalar::SLOPES > 0 {
            system.differentiable(&step.from, &step.to)?;
        }
        self.across[0] = self.across[1];
        self.across[1] = self.across[1] && system.independence(&self.reference, &step.to) < NEARLY_DEPENDENT;
        Ok(())
    }

    /// A step through a state at which constraints are dependent, on these if it can be. A projection moves a step that
    /// is e beside the constraints by e/δ at the distance δ: it is left where it is where that is more than its error.
    /// The caller names the constraint of a failure.
    #[cold]
    #[inline(never)]
    pub(super) fn attempt_across(
        across: &Across<'_, Sys, N>,
        method: &M,
        controller: &C,
        memory: &M::MethodState,
        from: &State<Sys::Scalar, N>,
        h: Sys::Scalar,
        next: &mut M::MethodState,
    ) -> Result<Step<Sys, M, N>, Failure<Sys::Scalar>> {
        let mut step = method.step_across(across, memory, from, h, next)?;
        if !step.to.is_finite() {
            return Err(Failure::NonFinite { t: from.t, h });
        }
        let independence = across.system.independence(&across.reference, &step.to);
        // (Errors of the steps since it was on them add up.)
        let is_tolerated = |state: &State<Sys::Scalar, N>, independence: f64| {
            let part = Sys::Scalar::from_f64(0.25 * independence);
            tolerated(controller, &state.minus(&step.to).scaled(part), &step.from, &step.to)
        };
        let is_near = independence < NEARLY_DEPENDENT;
        let drift = Err(Failure::ConstraintDrift { t: from.t, h, constraint: "" });
        step.to = match across.system.restored_across(&across.reference, &step.to, h) {
            Some(state) if is_tolerated(&state, NEARLY_DEPENDENT) => state,
            Some(_) => return drift,
            None => match across.system.restored(&step.to) {
                Ok(Some(Restored { state, .. })) if is_tolerated(&state, independence) => state,
                Ok(Some(_)) | Err(_) if !is_near => return drift,
                Ok(_) | Err(_) => step.to,
            },
        };
        *next = method.start_across(across, &step.to)?;
        step.evaluations += method.start_evaluations();
        Ok(step)
    }
}
