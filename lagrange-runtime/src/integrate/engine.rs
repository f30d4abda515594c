//! The time loop of runs and steppers: what both are made of besides their system. (That of lanes is
//! `integrate/lanes.rs`; both decide by the same `integrate/rules.rs`.)

use super::memories::DoubleBuffer;
use super::rules::{self, ends_early};
use super::switches::{Approach, Interpolated, Passage, beyond_impulses, landed_on, needs_impulse, not_held};
use crate::attitude::steps::may_change;
use crate::constraint::NEARLY_DEPENDENT;
use crate::controller::{Controller, FirstStep, Verdict};
use crate::failed::{Failed, Statistics};
use crate::failure::{Failure, Requirement};
use crate::method::{Across, Interpolant, Method, Step};
use crate::scalar::{Real, Scalar, SimdScalar};
use crate::state::{Restored, State, Tangent};
use crate::system::System;
pub use admitted::admitted;
use admitted::{CONSISTENT, STILL_CONSISTENT, admitted_within};

mod across;
mod admitted;

/// Round-off in ulps: of corrections by the projection onto constraints, whatever the tolerance, and of time in the
/// first step.
const ROUNDING: f64 = 64.0;

/// Steps of one size are looked at again if so many times the correction is not tolerated, a hundredth of the step:
/// over a crossing velocities change by a fifth with corrections of a fiftieth.
const DOUBT: f64 = 10.0;

/// The next step after one that could not be made so: it shall not land before that state, where it began.
const BESIDE: f64 = 0.7;

#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Status<S> {
    /// Checks and the choice of the step are still to be made: without an end, and after a restart.
    Unprepared,
    /// The same after an input has changed: the coordinates are as good as they were.
    Driven,
    Running,
    /// Failure of the arguments, which the first step returns.
    #[cfg_attr(feature = "serde", serde(skip))]
    Refused(Failure<S>),
    #[cfg_attr(feature = "serde", serde(skip))]
    Failed(Failure<S>),
}

/// The end of the last step, of a motion that is at a state before it.
#[derive(Debug)]
pub struct StepEnd<Sys: System<N>, M: Method<Sys, N>, const N: usize> {
    state: State<Sys::Scalar, N>,
    memory: Option<DoubleBuffer<M::MethodState>>,
    status: Status<Sys::Scalar>,
    across: bool,
    approach: Approach,
    leapt: bool,
}

/// Method, controller and state of a motion. The system is given to each function: it is borrowed by a run, and owned
/// by a stepper. Runs are inlined by force, so that they live in registers.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(bound(
        serialize = "Sys::Scalar: serde::Serialize, M: serde::Serialize, M::MethodState: serde::Serialize, C: serde::Serialize",
        deserialize = "Sys::Scalar: serde::Deserialize<'de>, M: serde::Deserialize<'de>, M::MethodState: serde::Deserialize<'de>, C: serde::Deserialize<'de>"
    ))
)]
pub struct Engine<Sys: System<N>, M: Method<Sys, N>, C, const N: usize> {
    pub(crate) method: M,
    pub(crate) controller: C,
    pub(crate) start: State<Sys::Scalar, N>,
    pub(crate) state: State<Sys::Scalar, N>,
    pub(super) memory: Option<DoubleBuffer<M::MethodState>>,
    pub(crate) status: Status<Sys::Scalar>,
    pub(crate) end: Option<Sys::Scalar>,
    /// The next step.
    #[cfg_attr(feature = "serde", serde(with = "crate::saved::number"))]
    pub(crate) h: Sys::Scalar,
    /// Origin of fixed steps, the number that have been made, and the number that there are to be.
    #[cfg_attr(feature = "serde", serde(with = "crate::saved::number"))]
    pub(crate) origin: Sys::Scalar,
    count: f64,
    #[cfg_attr(feature = "serde", serde(with = "crate::saved::number"))]
    pub(crate) total: f64,
    /// A fixed step was ended by a switch.
    stopped: bool,
    /// The longest adaptive step so far.
    longest: f64,
    /// The longest adaptive step that needs no second look: the longest one of the controller, or that of a state
    /// that does not accelerate.
    #[cfg_attr(feature = "serde", serde(with = "crate::saved::number"))]
    pub(crate) bound: f64,
    /// Steps go through a state at which constraints are dependent: was the last one made so, and is the next one?
    across: [bool; 2],
    /// Size of the step with which steps across began; negative once they have failed and the motion is near there.
    #[cfg_attr(feature = "serde", serde(with = "crate::saved::number"))]
    set_out: f64,
    /// State that shows how long the gradients of constraints are elsewhere: the start, if they are independent there.
    reference: State<Sys::Scalar, N>,
    /// Approach of adaptive steps to a switch.
    pub(super) approach: Approach,
    /// The motion is yet to begin, beyond the switches at which impulses act; its last step crossed one of them.
    begins: bool,
    leapt: bool,
    pub(crate) attempts: u64,
    pub(crate) max_steps: Option<u64>,
    pub(crate) statistics: Statistics,
}

impl<Sys, M, C, const N: usize> Engine<Sys, M, C, N>
where
    Sys: System<N>,
    Sys::Scalar: Real,
    M: Method<Sys, N>,
    C: Controller<Sys::Scalar, N, M::Error>,
{
    /// True if the equations switch, and whether steps may be equal or adaptive. (Constants of their own: rustc does
    /// not compile what follows one of them where it is false.)
    const SWITCHES: bool = Sys::SWITCHES > 0;
    /// Steps aim at events.
    pub const AIMS: bool = rules::aims::<Sys, N>() && Sys::Scalar::SLOPES == 0;
    const IMPULSES: bool = Sys::IMPULSES > 0;
    const ATTITUDES: bool = !Sys::ATTITUDES.is_empty();
    /// Constraints may become dependent. (In lanes steps are not made across such states, so not in those that are
    /// compared with them.)
    const DEPENDENT: bool = Sys::CONSTRAINTS > 0 && !Sys::Scalar::IN_LANES;
    const EQUAL: bool = !matches!(C::EQUAL_STEPS, Some(false));
    const ADAPTIVE: bool = !matches!(C::EQUAL_STEPS, Some(true));

    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn new(method: M, controller: C, start: State<Sys::Scalar, N>) -> Self {
        Engine {
            method: method.for_tolerance(controller.relative_tolerance()),
            controller,
            start,
            state: start,
            memory: None,
            status: Status::Unprepared,
            end: None,
            h: Sys::Scalar::zero(),
            origin: start.t,
            count: 0.0,
            total: f64::INFINITY,
            stopped: false,
            longest: 0.0,
            bound: f64::INFINITY,
            across: [false; 2],
            set_out: 0.0,
            reference: start,
            approach: Approach::NONE,
            begins: true,
            leapt: false,
            attempts: 0,
            max_steps: None,
            statistics: Statistics::default(),
        }
    }

    /// Goes to another end.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn until(&mut self, system: &Sys, end: Sys::Scalar) {
        self.end = Some(end);
        if self.attempts == 0 {
            // What may have been chosen for another end.
            self.h = Sys::Scalar::zero();
        }
        if !matches!(self.status, Status::Failed(_)) {
            self.status = match self.prepare(system, self.state.t) {
                Ok(()) => Status::Running,
                Err(failure) => Status::Refused(failure),
            };
        }
    }

    /// The failure of a run that went no further.
    pub fn failed(&self, failure: Failure<Sys::Scalar>) -> Failed<Sys::Scalar, N> {
        Failed { failure, start: self.start, last: self.state, statistics: self.statistics }
    }

    /// The interpolant of a step, its evaluations counted.
    pub fn interpolant(&mut self, system: &Sys, step: &Step<Sys, M, N>) -> M::Interpolant {
        let dense = if Self::DEPENDENT && self.across[0] {
            self.method.interpolant_across(&self.across(system, step.h), step)
        } else if Self::DEPENDENT
            && let Some(dense) = self.interpolant_past(system, step)
        {
            dense
        } else {
            self.method.interpolant(system, step)
        };
        self.statistics.evaluations += u64::from(self.method.interpolant_evaluations(&dense));
        dense
    }

    /// The state on the constraints near one within a step. Near a state at which they are dependent it is on the
    /// branch of the motion, or left where it is: a projection, which divides its error by δ, leads anywhere.
    pub fn on_constraints(
        &self,
        system: &Sys,
        at: State<Sys::Scalar, N>,
    ) -> Result<State<Sys::Scalar, N>, Failure<Sys::Scalar>> {
        // (A tolerance alone does not tell: steps of one size have none.)
        if Self::DEPENDENT
            && let Some(state) = system.restored_across(&self.reference, &at, Sys::Scalar::zero())
        {
            return Ok(state);
        }
        let found = match system.restored(&at) {
            Ok(None) => return Ok(at),
            Ok(Some(Restored { state, .. })) => Ok(state),
            Err(failure) => Err(failure),
        };
        let is_near = |found: &State<_, N>| tolerated(&self.controller, &found.minus(&at), &at, found);
        if !Self::DEPENDENT || found.as_ref().is_ok_and(is_near) {
            return found;
        }
        let left = || (system.independence(&self.reference, &at) < NEARLY_DEPENDENT).then_some(at).ok_or(());
        left().or(found)
    }

    /// Returns whether the run goes forward in time.
    pub fn forward(&mut self, system: &Sys) -> Result<bool, Failure<Sys::Scalar>> {
        self.begin(system)?;
        Ok(self.h >= Sys::Scalar::zero())
    }

    /// Does what comes before the first step, unless it is done.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn begin(&mut self, system: &Sys) -> Result<(), Failure<Sys::Scalar>> {
        let begun = match self.status {
            Status::Running if !Self::ATTITUDES => return Ok(()),
            Status::Running => self.shorten(system),
            Status::Unprepared | Status::Driven => self.prepare(system, self.state.t),
            Status::Refused(failure) | Status::Failed(failure) => Err(failure),
        };
        begun.map_err(|failure| self.explained(system, failure))
    }

    /// Checks what the user gave, and chooses the first step. The time to the end from `since` on bounds steps while
    /// velocities do not change. Inlined although it runs only once: a call would need the address of the run, which
    /// would then live in memory and not in registers throughout the loop.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn prepare(&mut self, system: &Sys, since: Sys::Scalar) -> Result<(), Failure<Sys::Scalar>> {
        self.controller.check()?;
        if let Some(end) = self.end.filter(|end| !end.to_f64().is_finite()) {
            return Err(Failure::BadEnd { end: Some(end) });
        }
        if let Some(chosen) = system.kinked() {
            return Err(Failure::Unsuitable { chosen, requirement: Requirement::ContinuousSlope });
        }
        if Self::DEPENDENT && self.memory.is_none() && self.status != Status::Driven {
            self.begin_across(system);
        }
        // (Where constraints are dependent, a projection leads anywhere.)
        if !(Self::DEPENDENT && self.across[1]) {
            let given = self.state;
            let bound = if self.status == Status::Driven { STILL_CONSISTENT } else { CONSISTENT };
            self.state = admitted_within(system, &given, bound)?;
            if Self::ADAPTIVE && Sys::CONSTRAINTS > 0 {
                self.begins(system, &given)?;
            }
        }
        if Self::IMPULSES && core::mem::take(&mut self.begins) {
            let backward = match self.controller.first_step() {
                FirstStep::Fixed(h) => h < Sys::Scalar::zero(),
                _ => self.end.is_some_and(|end| end < self.state.t),
            };
            self.state = beyond_impulses(system, &self.state, backward);
        }
        if Self::ATTITUDES && self.end != Some(self.state.t) {
            if Self::EQUAL
                && let FirstStep::Fixed(h) = self.controller.first_step()
            {
                self.divide(h)?;
            }
            let equal = self.equal();
            if may_change(Sys::ATTITUDES, &self.state, equal) {
                self.statistics.evaluations += u64::from(equal.is_some());
                if let Some(shorter) = system.shortened(&self.state, equal) {
                    (self.state, self.memory) = (shorter, None);
                }
            }
        }
        if self.memory.is_none() {
            let memory = if Self::DEPENDENT && self.across[1] {
                self.method.start_across(&self.across(system, self.h), &self.state)
            } else {
                if self.status != Status::Driven {
                    system.resolved(&self.state, &self.state)?;
                }
                self.method.start(system, &self.state)
            };
            self.memory = Some(DoubleBuffer::new(memory?));
            self.statistics.evaluations += u64::from(self.method.start_evaluations());
        }
        self.head(system, since)?;
        self.status = Status::Running;
        Ok(())
    }

    /// Refuses a start that is farther from the constraints than the tolerance of the run.
    #[cold]
    #[inline(never)]
    fn begins(&self, system: &Sys, given: &State<Sys::Scalar, N>) -> Result<(), Failure<Sys::Scalar>> {
        if tolerated(&self.controller, &self.state.minus(given), given, &self.state) {
            return Ok(());
        }
        let Some(Restored { constraint, violation, .. }) = system.restored(given)? else { return Ok(()) };
        Err(Failure::ConstraintViolated { t: given.t, constraint, violation })
    }

    /// Chooses the next step towards the end.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn head(&mut self, system: &Sys, since: Sys::Scalar) -> Result<(), Failure<Sys::Scalar>> {
        match self.controller.first_step() {
            FirstStep::Fixed(h) if Self::EQUAL => self.divide(h)?,
            FirstStep::Given(h) if self.h == Sys::Scalar::zero() => self.h = self.directed(h),
            FirstStep::Automatic if Self::ADAPTIVE && self.h == Sys::Scalar::zero() => {
                self.h = self.choose(system)
            }
            _ => self.h = self.directed(self.h),
        }
        let rest = self.end.filter(|_| !Sys::AUTONOMOUS).map(|end| end - since);
        self.bound = rules::longest_unseen(self.controller.max_step(), rest);
        Ok(())
    }

    /// The size of steps, if all of them are equal.
    #[inline(always)]
    fn equal(&self) -> Option<Sys::Scalar> {
        (Self::EQUAL && matches!(self.controller.first_step(), FirstStep::Fixed(_))).then_some(self.h)
    }

    /// Begins the next step, if there is one, from the shorter parameters of attitudes. What the method remembers
    /// starts anew.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn shorten(&mut self, system: &Sys) -> Result<(), Failure<Sys::Scalar>> {
        if Self::ATTITUDES && self.end != Some(self.state.t) {
            let (restarted, evaluations) = restart_shorter::<Sys, M, _, _, N>(
                || system,
                &self.method,
                || self.memory.as_ref().map(|memory| memory.now().clone()),
                &self.state,
                self.equal(),
            );
            self.statistics.evaluations += evaluations;
            if let Some(restarted) = restarted {
                let (state, memory) = restarted?;
                (self.state, self.memory) = (state, Some(DoubleBuffer::new(memory)));
            }
        }
        Ok(())
    }

    /// Prepares for the next step of a stepper towards `end`: checks what has changed since the last one.
    #[inline(always)]
    pub fn towards(&mut self, system: &Sys, end: Option<Sys::Scalar>) -> Result<(), Failure<Sys::Scalar>> {
        if self.status == Status::Running && self.end == end {
            // (A step that is not to be made needs no other parameters: the next call takes them.)
            if Self::ATTITUDES && self.is_used_up(self.equal().is_some()) {
                Ok(())
            } else {
                self.shorten(system)
            }
        } else {
            self.turn(system, end)
        }
    }

    #[inline(never)]
    fn turn(&mut self, system: &Sys, end: Option<Sys::Scalar>) -> Result<(), Failure<Sys::Scalar>> {
        self.end = end;
        let since = self.start.t;
        if self.status == Status::Running {
            self.shorten(system)?;
            self.head(system, since)
        } else {
            self.prepare(system, since)
        }
    }

    /// Forgets what followed from the system, which has changed, and keeps state and step size.
    pub fn change(&mut self, status: Status<Sys::Scalar>) {
        // (A system whose equations are not finite from now on is told as at a start.)
        if status == Status::Unprepared && Sys::CONSTRAINTS == 0 {
            self.reference = self.state;
        }
        self.memory = None;
        self.across[0] = false;
        self.approach = Approach::NONE;
        if self.status != Status::Unprepared {
            self.status = status;
        }
    }

    /// Goes on from elsewhere.
    pub fn restart(&mut self, state: State<Sys::Scalar, N>) {
        self.state = state;
        self.memory = None;
        self.h = Sys::Scalar::zero();
        (self.across, self.set_out) = ([false; 2], 0.0);
        self.approach = Approach::NONE;
        (self.begins, self.leapt) = (true, false);
        self.status = Status::Unprepared;
    }

    /// Goes on from `state`, which lies on the trajectory, with the step size that it has. If the last step crossed a
    /// switch at which an impulse acts, it is still to be given, unless `state` lies before the switch.
    pub fn land(&mut self, system: &Sys, state: State<Sys::Scalar, N>) {
        self.leapt = Self::IMPULSES && self.leapt && !needs_impulse(system, &state, &self.state);
        self.state = state;
        self.memory = None;
        self.across[0] = false;
        self.approach = Approach::NONE;
        self.begins = false;
        self.status = Status::Unprepared;
    }

    /// Goes back to `state`, which lies within the last step. [`return_to`](Self::return_to) the end of it goes on as
    /// if that had not been.
    pub fn back_to(&mut self, system: &Sys, state: State<Sys::Scalar, N>) -> StepEnd<Sys, M, N> {
        let end = StepEnd {
            state: self.state,
            memory: self.memory.take(),
            status: self.status,
            across: self.across[0],
            approach: self.approach,
            leapt: self.leapt,
        };
        self.land(system, state);
        end
    }

    pub fn return_to(&mut self, end: StepEnd<Sys, M, N>) {
        (self.state, self.memory, self.status) = (end.state, end.memory, end.status);
        (self.across[0], self.approach, self.leapt) = (end.across, end.approach, end.leapt);
    }

    /// The next step, if there is one left. If it is `UNSEEN`, nobody asks for its interpolant. (A constant, by which
    /// rustc compiles one of two steps.) An adaptive step beyond the time `aim` is shortened to it.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn step<const UNSEEN: bool>(
        &mut self,
        system: &Sys,
        aim: Option<f64>,
    ) -> Result<Option<Step<Sys, M, N>>, Failure<Sys::Scalar>> {
        self.without_impulse()?;
        let equal = matches!(self.controller.first_step(), FirstStep::Fixed(_));
        if Self::EQUAL && (!Self::ADAPTIVE || equal) {
            self.fixed_step::<UNSEEN>(system)
        } else {
            self.adaptive_step(system, aim)
        }
    }

    /// Fails if the last step crossed a switch at which an impulse acts, unless the motion was left there.
    #[inline(always)]
    pub fn without_impulse(&self) -> Result<(), Failure<Sys::Scalar>> {
        if Self::IMPULSES && self.leapt {
            return Err(Failure::UnknownImpulse { t: self.state.t });
        }
        Ok(())
    }

    /// Fails if a state within the last step, which began in `from`, lies beyond a switch at which an impulse acts.
    #[inline(always)]
    pub fn known(
        &self,
        system: &Sys,
        from: &State<Sys::Scalar, N>,
        state: &State<Sys::Scalar, N>,
    ) -> Result<(), Failure<Sys::Scalar>> {
        if Self::IMPULSES && self.leapt && needs_impulse(system, from, state) {
            return Err(Failure::UnknownImpulse { t: state.t });
        }
        Ok(())
    }

    /// A step of size `h` from anywhere, its evaluations counted, and what the next one begins with.
    pub fn attempt_from(
        &mut self,
        system: &Sys,
        memory: &M::MethodState,
        from: &State<Sys::Scalar, N>,
        h: Sys::Scalar,
    ) -> Result<(Step<Sys, M, N>, M::MethodState), Failure<Sys::Scalar>> {
        let mut beside = attempt_beside(system, &self.method, &self.controller, memory, from, h);
        if Self::DEPENDENT && beside.as_ref().map_or(true, |(step, _)| self.is_close(system, &step.to)) {
            beside = self.attempt_across_from(system, from, h).or(beside);
        }
        let beside = beside?;
        if Self::DEPENDENT && Sys::Scalar::SLOPES > 0 {
            system.differentiable(from, &beside.0.to)?;
        }
        self.statistics.evaluations += u64::from(beside.0.evaluations);
        Ok(beside)
    }

    /// `h` with the sign of the run.
    #[inline(always)]
    fn directed(&self, h: Sys::Scalar) -> Sys::Scalar {
        let backward = self.end.is_some_and(|end| end < self.state.t);
        if backward == (h < Sys::Scalar::zero()) { h } else { -h }
    }

    /// Divides the time to the end into equal steps not longer than `h`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn divide(&mut self, h: Sys::Scalar) -> Result<(), Failure<Sys::Scalar>> {
        let t = self.state.t;
        (self.origin, self.count, self.total, self.h) = (t, 0.0, f64::INFINITY, h);
        self.stopped = false;
        if let Some(end) = self.end {
            (self.total, self.h) = rules::divided(self.start.t, t, h, end)?;
        }
        if t + self.h == t && self.total != 0.0 {
            return Err(Failure::StepSizeUnderflow { t, h: self.h, cause: None });
        }
        Ok(())
    }

    /// A first step whose Euler error is about a hundredth of the tolerated one (Hairer, Nørsett, Wanner 1993, II.4).
    fn choose(&mut self, system: &Sys) -> Sys::Scalar {
        let Engine { controller, state, .. } = &*self;
        let derivative = |at: &State<Sys::Scalar, N>| {
            let qd = if Self::DEPENDENT && self.across[1] {
                system.accel_across(&self.reference, at, Sys::Scalar::zero(), false)
            } else {
                system.accel(&at.q, &at.qd, at.t)
            };
            Tangent { q: at.qd, qd }
        };
        let norm = |difference: &Tangent<_, N>| controller.norm(difference, state, state);
        let f0 = derivative(state);
        let (d0, d1) = (norm(&Tangent { q: state.q, qd: state.qd }), norm(&f0));
        let limit = self.end.map_or(f64::INFINITY, |end| (end - state.t).to_f64().abs());
        let h0 = if d0 < 1e-5 || d1 < 1e-5 { 1e-6 } else { 0.01 * d0 / d1 };
        // State and tolerance may be those of a motion much shorter than time can tell.
        let least = ROUNDING * Sys::Scalar::EPSILON * state.t.to_f64().abs();
        // (Which leaves a size that is not a number as it is.)
        let h0 = if h0 < least { least } else { h0 };
        let h0 = self.directed(Sys::Scalar::from_f64(h0.min(limit)));
        let f1 = derivative(&state.moved(state.t + h0, h0, &f0));
        let change = Tangent { q: f1.q - f0.q, qd: f1.qd - f0.qd };
        let h0 = h0.to_f64().abs();
        let d2 = norm(&change) / h0;
        let largest = d1.max(d2);
        let h1 = if largest <= 1e-15 {
            (h0 * 1e-3).max(1e-6).max(least)
        } else {
            // Not the standard library's, which differs from machine to machine, and with it the bits of all that
            // follows.
            libm::pow(0.01 / largest, 1.0 / (f64::from(self.method.order()) + 1.0))
        };
        self.statistics.evaluations += 2;
        // A norm that is not a number is left to the first step, which will be rejected.
        self.directed(Sys::Scalar::from_f64(h1.min(100.0 * h0).min(limit)))
    }

    #[inline(always)]
    fn budget(&self, equal: bool) -> u64 {
        rules::budget(self.max_steps, equal)
    }

    #[inline(always)]
    fn is_used_up(&self, equal: bool) -> bool {
        self.attempts >= self.budget(equal)
    }

    /// The failure of a step that is not within the budget.
    #[inline(always)]
    fn used_up(&self, equal: bool) -> Failure<Sys::Scalar> {
        let (max_steps, implicit) = (self.budget(equal), self.method.implicit());
        Failure::BudgetUsedUp { t: self.state.t, h: self.h, max_steps, implicit }
    }

    /// Fails where no step is left to prepare for, if to prepare twice takes evaluations: to choose the parameters of
    /// attitudes does.
    #[inline(always)]
    pub fn may_prepare(&self) -> Result<(), Failure<Sys::Scalar>> {
        let equal = matches!(self.controller.first_step(), FirstStep::Fixed(_));
        if Self::ATTITUDES && self.is_used_up(equal) { Err(self.used_up(equal)) } else { Ok(()) }
    }

    /// The next attempted step is within the budget.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn within_budget(&mut self, equal: bool) -> Result<(), Failure<Sys::Scalar>> {
        if self.is_used_up(equal) {
            return Err(self.used_up(equal));
        }
        self.attempts += 1;
        Ok(())
    }

    /// The cause of a failure of the run. It takes copies of the states: their addresses would keep the run in memory.
    #[inline(always)]
    pub fn explained(&self, system: &Sys, failure: Failure<Sys::Scalar>) -> Failure<Sys::Scalar> {
        let (start, last) = (self.reference, self.state);
        system.explained(&start, &last, failure)
    }

    /// One step of size `h`, or the failure that it met: a correction by the projection counts as `doubt` times as
    /// long. `next` is the variable for what it hands on, unless it is the `last` one.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn attempt<const UNSEEN: bool>(
        &mut self,
        system: &Sys,
        h: Sys::Scalar,
        doubt: f64,
        last: bool,
        next: &mut Option<M::MethodState>,
    ) -> Result<Step<Sys, M, N>, Failure<Sys::Scalar>> {
        let (Some(memory), Some(next)) = (&mut self.memory, next) else {
            return Err(Failure::NonFinite { t: self.state.t, h });
        };
        let (memory, next) = memory.of_step(next);
        let from = &self.state;
        // (A branch by a constant alone is not compiled where it is false, nor is what it calls.)
        if Self::DEPENDENT && self.across[1] {
            let across = Across { system, reference: self.reference, h, last: false };
            // (Failures of any kind say that there are no states on both sides.)
            let step = Self::attempt_across(&across, &self.method, &self.controller, memory, from, h, next);
            return step.map_err(|failure| match system.restored(from) {
                Ok(Some(Restored { constraint, .. })) => {
                    Failure::ConstraintDrift { t: from.t, h, constraint }
                }
                _ => failure,
            });
        }
        let controller = &self.controller;
        let tolerates = |correction: &Tangent<_, N>, from: &_, to: &_| {
            tolerated(controller, &correction.scaled(Scalar::from_f64(doubt)), from, to)
        };
        attempt::<_, _, UNSEEN, N>(system, &self.method, memory, from, h, (next, last), tolerates)
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn commit(
        &mut self,
        system: &Sys,
        step: Step<Sys, M, N>,
        next: Option<M::MethodState>,
    ) -> Step<Sys, M, N> {
        if Self::IMPULSES {
            self.leapt = needs_impulse(system, &step.from, &step.to);
        }
        self.state = step.to;
        self.statistics.accepted += 1;
        self.statistics.evaluations += u64::from(step.evaluations);
        if let (Some(memory), Some(next)) = (&mut self.memory, next) {
            memory.turn(next);
        }
        step
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn fixed_step<const UNSEEN: bool>(
        &mut self,
        system: &Sys,
    ) -> Result<Option<Step<Sys, M, N>>, Failure<Sys::Scalar>> {
        if self.count >= self.total {
            return Ok(None);
        }
        self.within_budget(true)?;
        let next = rules::next_time(self.count, self.total, self.h, self.origin, self.end);
        let h = if self.stopped { next - self.state.t } else { self.h };
        let mut next_memory = self.memory.as_ref().map(DoubleBuffer::variable);
        // At the end inputs mostly change, so that what the step would hand on is not good for the next one.
        let last = UNSEEN && M::HAS_LAST_STEP && self.count + 1.0 >= self.total && self.across == [false; 2];
        // Without a tolerance the projection alone tells of a step over a position with dependent constraints.
        let mut doubt = if Self::DEPENDENT { DOUBT } else { 1.0 };
        let mut step = loop {
            match self.attempt::<UNSEEN>(system, h, doubt, last, &mut next_memory) {
                Ok(step) => break step,
                Err(failure) if Self::DEPENDENT && !self.across[1] => {
                    if !self.sets_out_across(system, h)? {
                        match failure {
                            Failure::ConstraintDrift { .. } if doubt > 1.0 => doubt = 1.0,
                            _ => return Err(failure),
                        }
                    }
                }
                Err(failure) => return Err(failure),
            }
        };
        // A step that ends at a switch is followed by what is left of it.
        self.stopped = ends_early(&step, h);
        if !self.stopped {
            self.count += 1.0;
            step.to.t = next;
        }
        let last = last && !self.across[1];
        if Self::DEPENDENT && (self.across != [false; 2] || Sys::Scalar::SLOPES > 0) {
            self.gets_across(system, &step)?;
        }
        if !self.method.ends_at_switches() {
            not_held(system, [&step.from, &step.to], h, self.statistics.accepted)?;
        }
        let step = self.commit(system, step, next_memory);
        if last {
            self.change(Status::Driven);
        }
        Ok(Some(step))
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn adaptive_step(
        &mut self,
        system: &Sys,
        aim: Option<f64>,
    ) -> Result<Option<Step<Sys, M, N>>, Failure<Sys::Scalar>> {
        let t = self.state.t;
        if self.end == Some(t) {
            return Ok(None);
        }
        let mut cause = None;
        let mut next_memory = self.memory.as_ref().map(DoubleBuffer::variable);
        loop {
            self.within_budget(false)?;
            if self.h.to_f64().abs() > self.bound {
                let coasts = || {
                    self.statistics.evaluations += 1;
                    let controller = self.controller.clone();
                    rules::coasts::<_, M::Error, _, N>(system, controller, self.state, self.bound)
                };
                self.h = rules::limited(self.h, self.controller.max_step(), self.bound, coasts);
            }
            let to_switch = (Self::SWITCHES && self.approach.is_near()).then_some(self.approach.h);
            let rest = self.end.map(|end| end - t);
            let (mut h, mut lands) = rules::towards_end(self.h, to_switch, rest);
            let aimed = aim.filter(|_| Self::AIMS).and_then(|aim| rules::towards_event(h, aim, rest));
            if let Some(size) = aimed {
                (h, lands) = (size, false);
            }
            if !lands && rules::underflows(t, self.h) {
                return Err(rules::underflowed(system, &self.state, self.h, cause));
            }
            // (Before a step, not after it: it would be moved for the call.)
            if rules::is_tiny(self.h, self.longest) {
                system.resolved(&self.start, &self.state)?;
            }
            let mut attempted = self.attempt::<false>(system, h, 1.0, false, &mut next_memory);
            let step = match &mut attempted {
                Ok(step) => step,
                Err(failure) => {
                    if Self::DEPENDENT && (self.turns_back(system)? || self.sets_out_across(system, h)?) {
                        self.statistics.rejected += 1;
                        continue;
                    }
                    let switches = Self::SWITCHES && !self.method.ends_at_switches();
                    let approach = if switches { Some(&mut self.approach) } else { None };
                    let across = Self::DEPENDENT && self.across[1];
                    let shorter =
                        || self.controller.after_failure().map(|factor| if across { BESIDE } else { factor });
                    let factor =
                        rules::retried(*failure, approach, system, &self.state, h.to_f64(), shorter)?;
                    if let Some(factor) = factor {
                        cause = failure.cause();
                        self.h = rules::next_step(self.h, h, factor, false, false);
                    }
                    self.statistics.rejected += 1;
                    continue;
                }
            };
            // At a switch it has its own end.
            let stopped = ends_early(step, h);
            (h, lands) = if stopped { (step.h, false) } else { (h, lands) };
            step.to.t = self.end.filter(|_| lands).unwrap_or(step.to.t);
            let mut verdict = self.controller.judge(&step.from, &step.to, &step.error, self.method.order());
            let (mut near, mut again) = (Self::SWITCHES && self.approach.is_near(), false);
            if Self::SWITCHES && !self.method.ends_at_switches() {
                match self.passage(system, step, verdict)? {
                    // A switch that is not met after all was seen by a step that was too long.
                    Passage::Free => near &= self.approach.is_near(),
                    Passage::Again => again = true,
                    Passage::Across { switch } => {
                        verdict = Verdict::Accept { factor: 1.0 };
                        self.saltate(system, switch, step, &mut next_memory)?;
                    }
                }
            }
            match verdict {
                Verdict::Accept { factor } if !again => {
                    let cut = lands || stopped || near || aimed.is_some();
                    self.h = rules::next_step(self.h, h, factor, true, cut);
                    self.longest = self.longest.max(step.h.to_f64().abs());
                    if Self::DEPENDENT && (self.across != [false; 2] || Sys::Scalar::SLOPES > 0) {
                        self.gets_across(system, step)?;
                    }
                    return Ok(Some(self.commit(system, attempted?, next_memory)));
                }
                Verdict::Accept { .. } => {}
                Verdict::Reject { factor } => {
                    if !(Self::DEPENDENT && self.sets_out_across(system, h)?) {
                        self.h = rules::next_step(self.h, h, factor, false, false);
                    }
                    if Self::SWITCHES && !again {
                        self.approach = Approach::NONE;
                    }
                }
            }
            cause = None;
            self.statistics.evaluations += u64::from(step.evaluations);
            self.statistics.rejected += 1;
        }
    }

    /// Returns whether steps across switches are those of [`Passage::Across`].
    pub fn crosses_shortly(&self) -> bool {
        let equal = !Self::ADAPTIVE || matches!(self.controller.first_step(), FirstStep::Fixed(_));
        Self::SWITCHES && !equal && !self.method.ends_at_switches()
    }

    /// Gives the slopes of velocities what a jump of the accelerations gives them.
    #[cold]
    #[inline(never)]
    fn saltate(
        &mut self,
        system: &Sys,
        switch: usize,
        step: &mut Step<Sys, M, N>,
        next: &mut Option<M::MethodState>,
    ) -> Result<(), Failure<Sys::Scalar>> {
        let Some(qd) = system.saltated(switch, &step.from, &step.to) else { return Ok(()) };
        step.to.qd = qd;
        if let (Some(memory), Some(next)) = (&mut self.memory, next) {
            *memory.of_step(next).1 = self.method.start(system, &step.to)?;
            step.evaluations += self.method.start_evaluations();
        }
        Ok(())
    }

    /// Decides on a step with regard to the switches of the system.
    #[inline(never)]
    fn passage(
        &mut self,
        system: &Sys,
        step: &Step<Sys, M, N>,
        verdict: Verdict,
    ) -> Result<Passage, Failure<Sys::Scalar>> {
        let judged = match verdict {
            Verdict::Accept { factor } => (true, factor),
            Verdict::Reject { factor } => (false, factor),
        };
        if judged.0
            && self.approach.is_near()
            && let Some(switch) = landed_on(system, &step.from, &step.to)
            && system.saltated(switch, &step.from, &step.to).is_some()
            && let Some(again) = self.approach.beside(step.h.to_f64())
        {
            return Ok(again);
        }
        let Engine { method, controller, memory, approach, statistics, .. } = self;
        let within = || {
            let coarse = method.coarse_interpolant(system, step);
            let dense = coarse.unwrap_or_else(|| method.interpolant(system, step));
            statistics.evaluations += u64::from(method.interpolant_evaluations(&dense));
            let between = move |x: f64| dense.at(step.h.mul_add(Sys::Scalar::from_f64(x), step.from.t));
            let parts = memory.as_ref().map_or(1, |memory| method.parts(memory.now(), step.h));
            Interpolated { ends: [step.from, step.to], h: step.h, parts, between }
        };
        let norm = |difference: &Tangent<_, N>, a: &_, b: &_| controller.norm(difference, a, b);
        rules::across(approach, system, [&step.from, &step.to], judged, within, norm)
    }
}

/// The other parameters of attitudes from which the next step is to begin, if it is, and what it begins with; and the
/// evaluations that it took.
#[inline(always)]
pub(super) fn restart_shorter<Sys, M, B, F, const N: usize>(
    system: impl FnOnce() -> B,
    method: &M,
    memory: F,
    at: &State<Sys::Scalar, N>,
    equal: Option<Sys::Scalar>,
) -> (Option<Result<(State<Sys::Scalar, N>, M::MethodState), Failure<Sys::Scalar>>>, u64)
where
    Sys: System<N, Scalar: Real>,
    M: Method<Sys, N>,
    B: core::borrow::Borrow<Sys>,
    F: FnOnce() -> Option<M::MethodState>,
{
    if !may_change(Sys::ATTITUDES, at, equal) {
        return (None, 0);
    }
    let (system, looked) = (system(), u64::from(equal.is_some()));
    let Some(shorter) = system.borrow().shortened(at, equal) else { return (None, looked) };
    let started = match memory() {
        Some(memory) => method.turned(system.borrow(), &memory, at, &shorter),
        None => method.start(system.borrow(), &shorter),
    };
    let evaluations = looked + u64::from(method.start_evaluations());
    (Some(started.map(|memory| (shorter, memory))), evaluations)
}

/// A step beside those of a run, and what the next one after it begins with.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn attempt_beside<Sys, M, C, const N: usize>(
    system: &Sys,
    method: &M,
    controller: &C,
    memory: &M::MethodState,
    from: &State<Sys::Scalar, N>,
    h: Sys::Scalar,
) -> Result<(Step<Sys, M, N>, M::MethodState), Failure<Sys::Scalar>>
where
    Sys: System<N>,
    Sys::Scalar: Real,
    M: Method<Sys, N>,
    C: Controller<Sys::Scalar, N, M::Error>,
{
    let mut next = memory.clone();
    let tolerates = |correction: &_, from: &_, to: &_| tolerated(controller, correction, from, to);
    let step = attempt::<_, _, false, N>(system, method, memory, from, h, (&mut next, false), tolerates)?;
    Ok((step, next))
}

/// A step whose end is finite, and on the constraints of the system, if there are any, by a correction that is
/// tolerated. (Steps are large: it is looked at where it is.) What it hands on goes to `next`, unless it is `UNSEEN`
/// and the `last` one.
#[cfg_attr(not(debug_assertions), inline(always))]
fn attempt<Sys, M, const UNSEEN: bool, const N: usize>(
    system: &Sys,
    method: &M,
    memory: &M::MethodState,
    from: &State<Sys::Scalar, N>,
    h: Sys::Scalar,
    (next, last): (&mut M::MethodState, bool),
    tolerates: impl Fn(&Tangent<Sys::Scalar, N>, &State<Sys::Scalar, N>, &State<Sys::Scalar, N>) -> bool,
) -> Result<Step<Sys, M, N>, Failure<Sys::Scalar>>
where
    Sys: System<N>,
    Sys::Scalar: Real,
    M: Method<Sys, N>,
{
    // (Constants come first, and in the condition itself: rustc does not compile the step that they exclude.)
    let mut attempted = if UNSEEN && M::HAS_LAST_STEP && last {
        method.last_step(system, memory, from, h)
    } else {
        method.step_into(system, memory, from, h, next)
    };
    if let Ok(step) = &mut attempted {
        let sound = if step.to.is_finite() {
            let next = (!(UNSEEN && last)).then_some(next);
            restore(system, method, step, next).and_then(|moved| match moved {
                Some((correction, constraint)) if !tolerates(&correction, &step.from, &step.to) => {
                    Err(Failure::ConstraintDrift { t: from.t, h, constraint })
                }
                _ => Ok(()),
            })
        } else {
            Err(Failure::NonFinite { t: from.t, h })
        };
        if let Err(failure) = sound {
            attempted = Err(failure);
        }
    }
    attempted
}

/// Returns whether a controller, or rounding, allows for a correction of the end of a step.
pub(super) fn tolerated<S: Real, C: Controller<S, N, E>, E, const N: usize>(
    controller: &C,
    correction: &Tangent<S, N>,
    from: &State<S, N>,
    to: &State<S, N>,
) -> bool {
    let rounding = |x: S, of: S| x.to_f64().abs() <= ROUNDING * S::EPSILON * (1.0 + of.to_f64().abs());
    let rounded = |i: usize| rounding(correction.q[i], to.q[i]) && rounding(correction.qd[i], to.qd[i]);
    (0..N).all(rounded) || controller.tolerates(correction, from, to)
}

/// Projects the end of a step onto the constraints of the system, if there are any, in place, since steps are large.
/// In `next` is what the next one begins with.
/// Returns the correction and the name of the constraint that was violated most.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn restore<Sys, M, const N: usize>(
    system: &Sys,
    method: &M,
    step: &mut Step<Sys, M, N>,
    next: Option<&mut M::MethodState>,
) -> Result<Option<(Tangent<Sys::Scalar, N>, &'static str)>, Failure<Sys::Scalar>>
where
    Sys: System<N>,
    Sys::Scalar: SimdScalar,
    M: Method<Sys, N>,
{
    let Some(Restored { state, constraint, .. }) = system.restored(&step.to)? else { return Ok(None) };
    let correction = state.minus(&step.to);
    step.to = state;
    if let Some(next) = next {
        *next = method.start(system, &step.to)?;
        step.evaluations += method.start_evaluations();
    }
    Ok(Some((correction, constraint)))
}
