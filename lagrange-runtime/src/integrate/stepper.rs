//! `Stepper`: system, method, step-size controller and state in one value.

use super::Statistics;
use super::drive::Drive;
use super::engine::{Engine, Status, StepEnd, admitted};
#[cfg(feature = "std")]
use super::sampled::ControlLaw;
use super::sampled::{Control, Every, coincide, reached};
use crate::controller::{Controller, FirstStep};
use crate::event::sides::{KEPT, Sides};
use crate::event::{EventSet, Events};
use crate::failure::{Failure, Requirement};
use crate::input::Inputs;
use crate::method::{Method, Step};
use crate::quadrature::Integrals;
use crate::sample::Samples;
use crate::scalar::{Real, Scalar};
use crate::state::State;
use crate::system::System;
use nalgebra::SVector;

/// System, method, step-size controller and state in one value without lifetimes, which advances by the calls of its
/// owner. It is [`Send`], can be kept in a field, a `Vec` or a map, and a clone of it is a snapshot. It takes the
/// steps of a [`Run`](super::Run), bit for bit, and checks what a run checks.
///
/// The system may change between steps: its inputs by [`set_inputs`](Self::set_inputs) or by a digital controller with
/// its sample time, [`every`](Self::every), all of it by [`system_mut`](Self::system_mut). The memory of the method is
/// computed anew before the next step, which has the order of the method; the step size is kept.
///
/// The type of a stepper with a digital controller, in a field of a struct, is `SampledStepper`.
///
/// ```
/// use lagrange_runtime::prelude::*;
/// use lagrange_runtime::Stepper;
/// lagrangian! {
///     pub system Pendulum {
///         param l, g = 9.81;
///         coord theta: angle;
///         T = 0.5 * (l * dot(theta)).powi(2);
///         V = -g * l * cos(theta);
///     }
/// }
/// let start = State::new(0.0, [1.0], [0.0]);
/// let mut pendulum = Stepper::new(Pendulum::new(1.0), Dop853, PiController::tolerance(1e-9), start);
/// pendulum.advance_to(2.0)?;
/// pendulum.system_mut().l = 0.5;
/// let snapshot = pendulum.clone();
/// pendulum.advance_to(3.0)?;
/// assert_eq!((snapshot.state().t, pendulum.state().t), (2.0, 3.0));
/// # Ok::<(), Failure>(())
/// ```
///
/// # Failures
/// A call that fails leaves the stepper at its last good state. The next call continues from there, with a newly chosen
/// step size.
///
/// # Direction
/// Time goes forward, but where [`FixedStep`](crate::FixedStep) has a negative step.
#[derive(Clone, Debug)]
pub struct Stepper<Sys: System<N>, M: Method<Sys, N>, C, const N: usize, U = ()> {
    system: Sys,
    engine: Engine<Sys, M, C, N>,
    control: U,
    max_steps: Option<u64>,
    sides: Sides,
    /// The time at which the state was made, and the one within rounding of it that a call asked for.
    asked: Option<[Sys::Scalar; 2]>,
}

/// Stepper with one sampled controller, whose control law is in a box: the type of
/// [`Stepper::every`] of a [`ControlLaw`], to be written in a field of a struct. `N` is the
/// number of coordinates (and states of first order), `K` that of inputs.
///
/// ```
/// use lagrange_runtime::prelude::*;
/// lagrangian! {
///     pub system Cart {
///         param m = 2.0;
///         input force;
///         coord x: length;
///         T = 0.5 * m * dot(x).powi(2);
///         V = 0;
///         Q[x] = force;
///     }
/// }
/// struct Rig {
///     plant: SampledStepper<Cart, Dop853, PiController, 1, 1>,
/// }
/// let start = State::new(0.0, [1.0], [0.0]);
/// let control_law: ControlLaw<1, 1> = Box::new(|at, u| u[0] = -8.0 * at.q[0] - 8.0 * at.qd[0]);
/// let plant = Stepper::new(Cart::default(), Dop853, PiController::tolerance(1e-9), start).every(0.01, control_law);
/// let mut rig = Rig { plant };
/// rig.plant.advance_to(10.0)?;
/// assert!(rig.plant.state().q[0].abs() < 1e-6);
/// # Ok::<(), Failure>(())
/// ```
///
/// A box cannot be cloned, nor can a stepper that has one. A control law that captures nothing is a function and needs
/// no box: [`Every`]`<f64, fn(&State<f64, N>, &mut SVector<f64, K>), K>` can be cloned.
#[cfg(feature = "std")]
pub type SampledStepper<Sys, M, C, const N: usize, const K: usize> =
    Stepper<Sys, M, C, N, Every<<Sys as System<N>>::Scalar, ControlLaw<N, K, <Sys as System<N>>::Scalar>, K>>;

/// The outcome of [`Stepper::advance_within`].
#[must_use = "the stepper may not have arrived"]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Advance {
    /// The time is reached.
    Arrived,
    /// The work was used up before: the same call continues.
    NotYet,
}

impl<Sys, M, C, const N: usize> Stepper<Sys, M, C, N>
where
    Sys: System<N>,
    Sys::Scalar: Real,
    M: Method<Sys, N>,
    C: Controller<Sys::Scalar, N, M::Error>,
{
    /// A stepper at `start`. What is given is checked by the first step.
    pub fn new(system: Sys, method: M, controller: C, start: State<Sys::Scalar, N>) -> Self {
        Stepper {
            system,
            engine: Engine::new(method, controller, start),
            control: (),
            max_steps: None,
            sides: Sides::default(),
            asked: None,
        }
    }
}

impl<Sys, M, C, const N: usize, U> Stepper<Sys, M, C, N, U>
where
    Sys: System<N>,
    Sys::Scalar: Real,
    M: Method<Sys, N>,
    C: Controller<Sys::Scalar, N, M::Error>,
    U: Control<Sys, N>,
{
    /// Adds a digital controller with the sample time `period`: the control law sets the inputs at the sampling
    /// instants `t₀ + k period`, k = 0, 1, …, where t₀ is the present time. It is given the state and the inputs that
    /// were held up to then. In a struct the control law is in a box: see `SampledStepper`.
    ///
    /// Steps end on the sampling instants exactly, and the inputs are held in between (zero-order hold). They are
    /// right-continuous: at a sampling instant they are what the control law sets there. It is called once per
    /// sampling instant. [`advance_to`](Self::advance_to) a sampling instant ends with the call. If
    /// [`until`](Self::until) or a [`step`](Self::step) ends there, the next step makes the call, so that the
    /// interpolant of a step has the inputs that were held in it. Sampling instants that differ by rounding are one.
    /// Inputs that do not change cost no evaluation.
    ///
    /// Several controllers may have sample times of their own; those that share a sampling instant act in the order in
    /// which they were given. Sampling instants keep their origin t₀ when the state is set to another time.
    ///
    /// # Errors
    /// The next step fails with [`Failure::BadPeriod`] unless the period is positive, finite and at least 64
    /// roundings of the time long, with [`Failure::InputNotFinite`] where the control law sets an input that is not
    /// finite (the system then keeps its inputs), and with [`Failure::Unsuitable`] if steps go back in time. A period
    /// that becomes too short as time grows fails at the sampling instant where it does.
    pub fn every<F, const K: usize>(
        self,
        period: Sys::Scalar,
        control_law: F,
    ) -> Stepper<Sys, M, C, N, Every<Sys::Scalar, F, K, U>>
    where
        Sys: Inputs<N, K>,
        F: FnMut(&State<Sys::Scalar, N>, &mut SVector<Sys::Scalar, K>),
    {
        self.controlled(|t, others| Every::new(t, period, control_law, others))
    }

    /// Adds a digital controller as [`every`](Self::every) does, with the sampling instants `t₀ + k period` of an
    /// earlier one, where t₀ is `origin`: for a stepper that was saved, or whose controllers start at times of their
    /// own. Instants before the present time count as past, and so does the present one, unless it is t₀: a stepper
    /// that was saved after [`advance_to`](Self::advance_to) an instant has made its call there.
    ///
    /// # Errors
    /// Those of `every`; [`Failure::BadPeriod`] also for an origin that is not finite.
    pub fn every_from<F, const K: usize>(
        self,
        origin: Sys::Scalar,
        period: Sys::Scalar,
        control_law: F,
    ) -> Stepper<Sys, M, C, N, Every<Sys::Scalar, F, K, U>>
    where
        Sys: Inputs<N, K>,
        F: FnMut(&State<Sys::Scalar, N>, &mut SVector<Sys::Scalar, K>),
    {
        self.controlled(|t, others| Every::new(origin, period, control_law, others).after(t))
    }

    /// The same stepper with the control that is made of the present time and of the one that it has.
    fn controlled<V>(self, add: impl FnOnce(Sys::Scalar, U) -> V) -> Stepper<Sys, M, C, N, V> {
        let Stepper { system, mut engine, control, max_steps, sides, asked } = self;
        engine.status = Status::Unprepared;
        let control = add(engine.state.t, control);
        Stepper { system, engine, control, max_steps, sides, asked }
    }

    /// Fails a call with [`Failure::BudgetUsedUp`] when `max_steps` steps, accepted or not, did not suffice for it; the
    /// next call continues. The default is no limit for fixed steps, and 1 000 000 for adaptive ones, counted anew from
    /// each sampling instant of [`every`](Self::every).
    pub fn max_steps(self, max_steps: u64) -> Self {
        Stepper { max_steps: Some(max_steps), ..self }
    }

    /// The state reached.
    #[inline]
    pub fn state(&self) -> &State<Sys::Scalar, N> {
        &self.engine.state
    }

    /// Continues from another state, at the same time or at another one, with a newly chosen step size. Sampling
    /// instants stay where they are. A control law that was called at the present time is not called there again. At
    /// another time, it is called at the first sampling instant that is not before that time, be it for the second
    /// time.
    ///
    /// # Errors
    /// [`Failure::StateNotFinite`], or [`Failure::ConstraintViolated`] if the state is not on the constraints of the
    /// system, but for rounding (see [`consistent`](crate::consistent)). The stepper is where it was then.
    pub fn set_state(&mut self, state: State<Sys::Scalar, N>) -> Result<(), Failure<Sys::Scalar>> {
        let state = self.begun(state)?;
        self.sides.changed();
        self.goes_on_from(state);
        self.engine.start = state;
        Ok(())
    }

    /// The system.
    #[inline]
    pub fn system(&self) -> &Sys {
        &self.system
    }

    /// The system, to be changed. (A [`Precomputed`](crate::traits::Precomputed) one by
    /// [`update`](crate::traits::Precomputed::update).)
    pub fn system_mut(&mut self) -> &mut Sys {
        self.sides.changed();
        self.engine.change(Status::Unprepared);
        &mut self.system
    }

    /// The inputs that are held, K of them in the order of the definition, each in its unit.
    pub fn inputs<const K: usize>(&self) -> SVector<Sys::Scalar, K>
    where
        Sys: Inputs<N, K>,
    {
        self.system.inputs()
    }

    /// Holds other inputs from now on.
    ///
    /// Position and velocities stay what they are. If the input moves a constraint, as the height of a floor or the
    /// speed of a belt does, they violate it afterwards, and the next step fails with
    /// [`Failure::ConstraintViolated`]. The state on the moved constraint is given by
    /// [`consistent`](crate::consistent):
    ///
    /// ```
    /// use lagrange_runtime::prelude::*;
    /// use lagrange_runtime::Stepper;
    /// lagrangian! {
    ///     pub system Parcel {
    ///         input belt;
    ///         coord x, y;
    ///         T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
    ///         V = 0;
    ///         constraint carried: dot(x) == belt;
    ///     }
    /// }
    /// let start = State::new(0.0, [0.0, 0.0], [0.0, 1.0]);
    /// let mut parcel = Stepper::new(Parcel::new(), Dop853, PiController::tolerance(1e-9), start);
    /// parcel.set_inputs([2.0])?;
    /// assert!(matches!(parcel.advance_to(1.0), Err(Failure::ConstraintViolated { .. })));
    /// parcel.set_state(consistent(parcel.system(), parcel.state())?)?;
    /// parcel.advance_to(1.0)?;
    /// assert!((parcel.state().q[0] - 2.0).abs() < 1e-12);
    /// # Ok::<(), Failure>(())
    /// ```
    ///
    /// # Errors
    /// [`Failure::InputNotFinite`], and the inputs are what they were.
    pub fn set_inputs<const K: usize>(
        &mut self,
        inputs: impl Into<SVector<Sys::Scalar, K>>,
    ) -> Result<(), Failure<Sys::Scalar>>
    where
        Sys: Inputs<N, K>,
    {
        let changed = super::sampled::set(&mut self.system, &inputs.into(), self.engine.state.t)?;
        self.driven(changed);
        Ok(())
    }

    /// The cost so far.
    pub fn statistics(&self) -> Statistics {
        self.engine.statistics
    }

    /// The method.
    pub fn method(&self) -> &M {
        &self.engine.method
    }

    /// Takes the system out.
    pub fn into_system(self) -> Sys {
        self.system
    }

    /// Takes one step, of the length that the step-size controller wants, or up to the next sampling instant of
    /// [`every`](Self::every). It searches for no events, as [`advance_to`](Self::advance_to).
    #[inline]
    pub fn step(&mut self) -> Result<Step<Sys, M, N>, Failure<Sys::Scalar>> {
        self.allow(self.max_steps);
        self.go::<false>(None, None)
    }

    /// Goes forward to the time t exactly: afterwards `state().t == t`. Control laws with a sampling instant at t are
    /// called there. Fixed steps up to there are equal, as those of [`Run::until`](super::Run::until). An adaptive
    /// step is shortened, or longer by up to 1 %, and the step after it has the length that it would have had.
    ///
    /// It searches for no events, not even the terminal ones of the system: the motion continues through them to t.
    /// `until(t).events(CartPole::STOP).next()` stops at the event `stop` of the system, and gives `None` if t comes
    /// first.
    ///
    /// # Errors
    /// Those of steps; [`Failure::TimeGoesBack`] if t lies behind.
    #[inline]
    pub fn advance_to(&mut self, t: Sys::Scalar) -> Result<(), Failure<Sys::Scalar>> {
        self.allow(self.max_steps);
        self.arrive(t)
    }

    /// Goes towards the time t with `attempts` steps at most, accepted or not, for programs with a deadline. The
    /// steps are those of [`advance_to`](Self::advance_to), bit for bit and at the same cost, however often they are
    /// interrupted.
    ///
    /// # Errors
    /// Those of [`advance_to`](Self::advance_to). That the attempts were used up is none.
    pub fn advance_within(&mut self, t: Sys::Scalar, attempts: u64) -> Result<Advance, Failure<Sys::Scalar>> {
        self.allow(Some(attempts));
        match self.arrive(t) {
            Ok(()) => Ok(Advance::Arrived),
            Err(Failure::BudgetUsedUp { .. }) => Ok(Advance::NotYet),
            Err(failure) => Err(failure),
        }
    }

    /// The interpolant of the last step; none of an earlier one, or where the state or the system has changed since.
    /// Some methods evaluate the equations for it.
    pub fn interpolant(&mut self, step: &Step<Sys, M, N>) -> Option<M::Interpolant> {
        let is_last = self.engine.status == Status::Running && self.engine.state == step.to;
        is_last.then(|| self.engine.interpolant(&self.system, step))
    }

    /// The motion up to the time t: an iterator of its steps, and the source of events, samples and integrals. It may
    /// be left anywhere: the stepper is at the end of the last step, or at the event met last. Control laws with a
    /// sampling instant at t are called by the next step, not at t.
    ///
    /// Functions of events and integrands are given the state alone. The inputs are those of [`inputs`](Self::inputs)
    /// between two steps; where a function needs them, let it share a `Cell` with the control law.
    ///
    /// ```
    /// use lagrange_runtime::prelude::*;
    /// use lagrange_runtime::Stepper;
    /// lagrangian! {
    ///     pub system Ball {
    ///         param g = 9.81;
    ///         coord y;
    ///         T = 0.5 * dot(y).powi(2);
    ///         V = g * y;
    ///     }
    /// }
    /// let start = State::new(0.0, [1.0], [0.0]);
    /// let mut ball = Stepper::new(Ball::new(), Dop853, PiController::tolerance(1e-12), start);
    /// let ground = Event::falling(|s: &State<f64, 1>| s.q[0]).terminal();
    /// let mut bounces = 0;
    /// while ball.state().t < 2.0 {
    ///     if let Some(bounce) = ball.until(2.0).events(ground).next() {
    ///         let mut state = bounce?.state;
    ///         state.qd[0] *= -0.8;
    ///         ball.set_state(state)?;
    ///         bounces += 1;
    ///     }
    /// }
    /// assert_eq!(bounces, 3);
    /// # Ok::<(), Failure>(())
    /// ```
    pub fn until(&mut self, t: Sys::Scalar) -> Stretch<'_, Sys, M, C, N, U> {
        self.allow(self.max_steps);
        Stretch { stepper: self, end: t, is_bounded: false, failure: None, step_end: None }
    }

    fn allow(&mut self, attempts: Option<u64>) {
        self.engine.attempts = 0;
        self.engine.max_steps = attempts;
    }

    /// The inputs are others.
    fn driven(&mut self, changed: bool) {
        if changed {
            self.sides.driven();
            self.engine.change(Status::Driven);
        }
    }

    /// The state at which a motion from the given one begins.
    fn begun(&self, state: State<Sys::Scalar, N>) -> Result<State<Sys::Scalar, N>, Failure<Sys::Scalar>> {
        // (Where constraints are dependent, a projection leads anywhere: a run begins on a branch there.)
        let is_finite = state.is_finite() && state.t.to_f64().is_finite();
        let begun = if Sys::CONSTRAINTS > 0 && is_finite { self.system.begun_across(&state) } else { None };
        match begun.and_then(|begun| begun.state) {
            Some(state) => Ok(state),
            None => admitted(&self.system, &state)
                .map_err(|failure| self.system.explained(&state, &state, failure)),
        }
    }

    /// Another state, with the sampling instants after its time.
    fn goes_on_from(&mut self, state: State<Sys::Scalar, N>) {
        if !coincide(state.t, self.engine.state.t, self.control.scale()) {
            self.control.seek(state.t);
        }
        self.engine.restart(state);
        self.asked = None;
    }

    /// Do steps go back in time? Fails if there are digital controllers.
    fn goes_back(&self) -> Result<bool, Failure<Sys::Scalar>> {
        let back = matches!(self.engine.controller.first_step(), FirstStep::Fixed(h) if h < Scalar::zero());
        if back && self.control.instant().is_some() {
            return Err(Failure::Unsuitable { chosen: "every", requirement: Requirement::Forward });
        }
        Ok(back)
    }

    /// The time at which the state was made. Many calls for times within rounding of the last one would move time
    /// without a motion otherwise.
    #[inline(always)]
    fn made_at(&self) -> Sys::Scalar {
        let now = self.engine.state.t;
        self.asked.filter(|[_, asked]| *asked == now).map_or(now, |[made, _]| made)
    }

    /// Is the time t reached, up to rounding? Then it is the time of the state. Fails where it lies behind.
    fn has_reached(&mut self, t: Sys::Scalar) -> Result<bool, Failure<Sys::Scalar>> {
        let now = self.made_at();
        if !t.to_f64().is_finite() {
            return Err(Failure::BadEnd { end: Some(t) });
        }
        let behind = if self.goes_back()? { t > now } else { t < now };
        if coincide(t, now, self.control.scale()) {
            self.engine.without_impulse().map_err(|failure| self.recovered(failure))?;
            self.engine.state.t = t;
            self.asked = (t != now).then_some([now, t]);
            Ok(true)
        } else if behind {
            Err(Failure::TimeGoesBack { t: now, end: t })
        } else {
            Ok(false)
        }
    }

    fn arrive(&mut self, t: Sys::Scalar) -> Result<(), Failure<Sys::Scalar>> {
        while !self.has_reached(t)? {
            self.go::<true>(Some(t), None)?;
        }
        self.act()
    }

    /// Calls the control laws whose sampling instant has come.
    #[inline(always)]
    fn act(&mut self) -> Result<(), Failure<Sys::Scalar>> {
        let scale = self.control.scale();
        let due = self.control.instant().is_some_and(|instant| reached(instant, self.engine.state.t, scale));
        if due {
            // A million samples are no sign of stiffness.
            if self.engine.max_steps.is_none() {
                self.engine.attempts = 0;
            }
            let changed = self.control.act(&self.engine.state, scale, &mut self.system);
            // (Of several controllers some may have acted before one failed.)
            self.driven(changed != Ok(false));
            changed?;
        }
        Ok(())
    }

    /// The end towards which the next step goes. Control laws whose sampling instant has come are called.
    #[inline(always)]
    fn aim(&mut self, target: Option<Sys::Scalar>) -> Result<Option<Sys::Scalar>, Failure<Sys::Scalar>> {
        if self.engine.status == Status::Unprepared {
            self.goes_back()?;
            self.control.check(self.engine.state.t)?;
            target.map_or(Ok(()), |target| self.control.counts(target))?;
        }
        self.act()?;
        // (An instant that differs from the target by rounding is the target.)
        Ok(match (target, self.control.instant()) {
            (Some(target), Some(instant)) if reached(target, instant, self.control.scale()) => Some(target),
            (target, None) => target,
            (_, instant) => instant,
        })
    }

    /// Prepares for the next step.
    #[inline(always)]
    fn begin(&mut self, target: Option<Sys::Scalar>) -> Result<(), Failure<Sys::Scalar>> {
        let end = self.aim(target)?;
        self.engine.towards(&self.system, end)
    }

    /// Takes a step towards the target, an adaptive one of the time `aim` at most. If it is `UNSEEN`, nobody asks for
    /// its interpolant.
    #[inline(always)]
    fn go<const UNSEEN: bool>(
        &mut self,
        target: Option<Sys::Scalar>,
        aim: Option<f64>,
    ) -> Result<Step<Sys, M, N>, Failure<Sys::Scalar>> {
        self.engine.state.t = self.made_at();
        self.asked = None;
        let step = self.aim(target).and_then(|end| {
            self.engine.may_prepare()?;
            self.engine.towards(&self.system, end)?;
            self.engine.step::<UNSEEN>(&self.system, aim)
        });
        match step {
            Ok(Some(step)) => Ok(step),
            Ok(None) => Err(Failure::BadEnd { end: self.engine.end }),
            Err(failure) => Err(self.recovered(failure)),
        }
    }

    /// The cause of a failure, after which the next call begins anew.
    #[cold]
    fn recovered(&mut self, failure: Failure<Sys::Scalar>) -> Failure<Sys::Scalar> {
        // (An impulse is still to be given.)
        if let Failure::BudgetUsedUp { .. } | Failure::UnknownImpulse { .. } = failure {
            return failure;
        }
        let failure = self.engine.explained(&self.system, failure);
        self.engine.restart(self.engine.state);
        failure
    }
}

/// The motion of a stepper up to a time, made by [`Stepper::until`]: an iterator of accepted steps. After a failure it
/// yields the failure once and ends.
#[must_use = "it makes no step unless it is iterated over, or run to its end"]
#[derive(Debug)]
pub struct Stretch<'a, Sys: System<N>, M: Method<Sys, N>, C, const N: usize, U = ()> {
    stepper: &'a mut Stepper<Sys, M, C, N, U>,
    end: Sys::Scalar,
    /// Is it no failure that the attempts are used up?
    is_bounded: bool,
    failure: Option<Failure<Sys::Scalar>>,
    /// The end of the step in which the stepper is at an event that others may follow.
    step_end: Option<StepEnd<Sys, M, N>>,
}

impl<Sys, M, C, const N: usize, U> Stretch<'_, Sys, M, C, N, U>
where
    Sys: System<N>,
    Sys::Scalar: Real,
    M: Method<Sys, N>,
    C: Controller<Sys::Scalar, N, M::Error>,
    U: Control<Sys, N>,
{
    fn is_over(&self) -> bool {
        coincide(self.end, self.stepper.made_at(), self.stepper.control.scale())
    }

    /// Makes at most `attempts` steps, accepted or not, for programs with a deadline. It ends early without a failure:
    /// the time of the stepper's state says how far it came, and the same call continues. It meets each event once,
    /// where one call would have met it, to rounding.
    ///
    /// ```
    /// use lagrange_runtime::prelude::*;
    /// lagrangian! {
    ///     pub system Ball {
    ///         param g = 9.81;
    ///         coord y;
    ///         T = 0.5 * dot(y).powi(2);
    ///         V = g * y;
    ///         event ground: y, falling, terminal;
    ///     }
    /// }
    /// let start = State::new(0.0, [1.0], [0.0]);
    /// let mut ball = Stepper::new(Ball::new(), Rk4, FixedStep::new(1e-3), start);
    /// let mut calls = 0;
    /// let landing = loop {
    ///     calls += 1;
    ///     match ball.until(1.0).within(100).events(Ball::GROUND).next() {
    ///         Some(event) => break Some(event?),
    ///         None if ball.state().t < 1.0 => continue,
    ///         None => break None,
    ///     }
    /// };
    /// assert_eq!(calls, 5);
    /// assert!((landing.expect("a fall").state.t - (2.0f64 / 9.81).sqrt()).abs() < 1e-12);
    /// # Ok::<(), Failure>(())
    /// ```
    pub fn within(mut self, attempts: u64) -> Self {
        self.stepper.allow(Some(attempts));
        self.is_bounded = true;
        self
    }

    /// The states at the given times, as [`Run::sample`](super::Run::sample). The stepper is left at the end of the
    /// step of the last one.
    pub fn sample<T>(self, times: T) -> Samples<Self, T::IntoIter, N>
    where
        T: IntoIterator<Item = Sys::Scalar>,
    {
        Samples::new(self, times)
    }

    /// The events up to the time, as [`Run::events`](super::Run::events), at most 16 in a set. The stepper is left at
    /// the event met last, on the interpolant of its step if it is not terminal, or at the end if there is no other
    /// one.
    pub fn events<E, const K: usize>(self, events: E) -> Events<Self, E, K, N>
    where
        E: EventSet<Sys, N, K>,
    {
        const { assert!(K <= KEPT, "a stepper looks for at most 16 events at once") };
        Events::new(self, events)
    }

    /// `∫ f dt` along the motion, as [`Run::integrals`](super::Run::integrals).
    pub fn integrals<F, const I: usize>(
        self,
        start: [Sys::Scalar; I],
        integrand: F,
    ) -> Integrals<Self, F, N, I>
    where
        F: FnMut(&State<Sys::Scalar, N>) -> [Sys::Scalar; I],
    {
        Integrals::new(self, start, integrand)
    }
}

impl<Sys, M, C, const N: usize, U> Drive<N> for Stretch<'_, Sys, M, C, N, U>
where
    Sys: System<N>,
    Sys::Scalar: Real,
    M: Method<Sys, N>,
    C: Controller<Sys::Scalar, N, M::Error>,
    U: Control<Sys, N>,
{
    type System = Sys;
    type Method = M;
    type Controller = C;

    fn system(&self) -> &Sys {
        &self.stepper.system
    }

    fn engine(&self) -> &Engine<Sys, M, C, N> {
        &self.stepper.engine
    }

    const IS_LEFT: bool = true;

    fn sides(&mut self) -> Option<&mut Sides> {
        Some(&mut self.stepper.sides)
    }

    /// A state from which no motion begins is told by the next step, and the stepper keeps its own.
    fn restart(&mut self, state: State<Sys::Scalar, N>) {
        let begun = self.stepper.begun(state);
        self.step_end = None;
        self.failure = begun.err();
        if let Ok(state) = begun {
            self.stepper.goes_on_from(state);
        }
    }

    fn back_to(&mut self, state: State<Sys::Scalar, N>) {
        self.step_end = Some(self.stepper.engine.back_to(&self.stepper.system, state));
    }

    fn return_to_end(&mut self) {
        if let Some(end) = self.step_end.take() {
            self.stepper.engine.return_to(end);
        }
    }

    fn parts(&mut self) -> (&Sys, &mut Engine<Sys, M, C, N>) {
        (&self.stepper.system, &mut self.stepper.engine)
    }

    fn begin(&mut self) -> Result<(), Failure<Sys::Scalar>> {
        match self.failure {
            Some(failure) => Err(failure),
            // (Control laws with a sampling instant at the end are called by the next step.)
            None if self.is_over() => self.stepper.engine.towards(&self.stepper.system, Some(self.end)),
            None => self.stepper.begin(Some(self.end)),
        }
    }

    fn advance_towards(&mut self, aim: Option<f64>) -> Option<Result<Step<Sys, M, N>, Failure<Sys::Scalar>>> {
        if self.failure.is_some() {
            return None;
        }
        self.step_end = None;
        let step = match self.stepper.has_reached(self.end) {
            Ok(true) => return None,
            Ok(false) => self.stepper.go::<false>(Some(self.end), aim),
            Err(failure) => Err(failure),
        };
        if let Err(Failure::BudgetUsedUp { .. }) = step
            && self.is_bounded
        {
            return None;
        }
        self.failure = step.as_ref().err().copied();
        Some(step)
    }

    fn fail(&mut self, failure: Failure<Sys::Scalar>) -> Failure<Sys::Scalar> {
        self.failure = Some(failure);
        failure
    }

    fn failure(&self) -> Option<Failure<Sys::Scalar>> {
        self.failure
    }

    fn end(&self) -> Option<Sys::Scalar> {
        Some(self.end)
    }

    fn forward(&mut self) -> Result<bool, Failure<Sys::Scalar>> {
        Ok(!self.stepper.goes_back()?)
    }
}

impl<Sys, M, C, const N: usize, U> Iterator for Stretch<'_, Sys, M, C, N, U>
where
    Sys: System<N>,
    Sys::Scalar: Real,
    M: Method<Sys, N>,
    C: Controller<Sys::Scalar, N, M::Error>,
    U: Control<Sys, N>,
{
    type Item = Result<Step<Sys, M, N>, Failure<Sys::Scalar>>;

    fn next(&mut self) -> Option<Self::Item> {
        self.advance()
    }
}

#[cfg(feature = "serde")]
mod saved {
    use super::*;
    use crate::saved::Named;
    use serde::de::Error;
    use serde::ser::SerializeStruct;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    impl<Sys, M, C, const N: usize, U> Serialize for Stepper<Sys, M, C, N, U>
    where
        Sys: System<N> + Serialize,
        Sys::Scalar: Serialize,
        M: Method<Sys, N> + Serialize,
        M::MethodState: Serialize,
        C: Serialize,
    {
        fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
            let mut all = to.serialize_struct("Stepper", 6)?;
            all.serialize_field("method", &Named::<M>::NEW)?;
            all.serialize_field("system", &self.system)?;
            all.serialize_field("engine", &self.engine)?;
            all.serialize_field("max_steps", &self.max_steps)?;
            all.serialize_field("sides", &self.sides)?;
            all.serialize_field("asked", &self.asked)?;
            all.end()
        }
    }

    #[derive(Deserialize)]
    #[serde(
        rename = "Stepper",
        bound(deserialize = "Sys: Deserialize<'de>, Sys::Scalar: Deserialize<'de>, M: Deserialize<'de>, \
             M::MethodState: Deserialize<'de>, C: Deserialize<'de>")
    )]
    struct Saved<Sys: System<N>, M: Method<Sys, N>, C, const N: usize> {
        #[serde(rename = "method")]
        _method: Named<M>,
        system: Sys,
        engine: Engine<Sys, M, C, N>,
        max_steps: Option<u64>,
        sides: Sides,
        asked: Option<[Sys::Scalar; 2]>,
    }

    impl<'de, Sys, M, C, const N: usize> Deserialize<'de> for Stepper<Sys, M, C, N>
    where
        Sys: System<N> + Deserialize<'de>,
        Sys::Scalar: Real + Deserialize<'de>,
        M: Method<Sys, N> + Deserialize<'de>,
        M::MethodState: Deserialize<'de>,
        C: Deserialize<'de>,
    {
        fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
            let Saved { system, engine, max_steps, sides, asked, .. } =
                Saved::<Sys, M, C, N>::deserialize(from)?;
            admitted(&system, &engine.state).map_err(D::Error::custom)?;
            Ok(Stepper { system, engine, control: (), max_steps, sides, asked })
        }
    }
}
