//! Events: what happens where a function g(t, q, q̇) vanishes along a run, such as an impact, a turning point or the
//! passage through a surface of section. The iterators of samples and integrals along a run are here too.
//!
//! [`Run::events`] turns a run into an iterator of [`Occurrence`]s. Each root is located to rounding on the interpolant
//! of its step. At a *terminal* event the run ends where g vanishes on the trajectory itself, by steps of its own
//! method: the state there is as good as the ends of steps are, and after [`Events::restart`] the run continues from
//! there, or from the state after an impact.
//!
//! ```
//! use lagrange_runtime::prelude::*;
//!
//! lagrangian! {
//!     /// A ball above the ground.
//!     pub system Ball {
//!         param m, g = 9.81;
//!         coord y;
//!         T = 0.5 * m * dot(y).powi(2);
//!         V = m * g * y;
//!     }
//! }
//!
//! let ball = Ball::new(0.1);
//! let start = State::new(0.0, [1.0], [0.0]);
//! let run = integrate(&ball, Dop853, PiController::tolerance(1e-12), start).until(10.0);
//! let mut bounces = run.events(Event::falling(|s| s.q[0]).terminal());
//! let mut times = vec![];
//! while let Some(bounce) = bounces.next() {
//!     let mut state = bounce?.state;
//!     times.push(state.t);
//!     if times.len() == 5 {
//!         break;
//!     }
//!     // The impact: restitution 0.8.
//!     state.qd[0] *= -0.8;
//!     bounces.restart(state);
//! }
//! // Each flight takes 0.8 of the time of the one before.
//! let fall = (2.0 / ball.g).sqrt();
//! assert!((times[0] - fall).abs() < 1e-14 && (times[4] - times[3] - 2.0 * fall * 0.8f64.powi(4)).abs() < 1e-12);
//! # Ok::<(), Failure>(())
//! ```
//!
//! An event may also be written in the system, `event ground: y, falling, terminal;` (see
//! [`lagrangian!`](crate::lagrangian!#events)): the constant `Ball::GROUND` is an [`Event`] like one of a closure,
//! whose function reads the parameters of the system that moves.
//!
//! # What is found and what can be missed
//!
//! The search begins with the ends of a step: g and its rate there, and g at two places between (0.38 and 0.73 of the
//! step) on the quintic Hermite interpolant, for which methods with accelerations at both ends (explicit Runge–Kutta
//! and Nyström methods) need no evaluation. The step has no event, and its own interpolant is not made, if the cubic
//! through the ends keeps its sign by more than a bound D of what g deviates from it. The assumption: D is at most
//! eight times the deviation at the two places, scaled as `x² (1 − x)²`, and a sixteenth of the change of g over the
//! step is added. It holds for a g that varies within a step by up to a whole wave. The rates of a closure are
//! differences within a thousandth of the step. Of an event that is written in the system, ġ is exact, and g̈ at both
//! ends, where it is known, has to fit as well: D is also at least eight times what it shows. An excursion of g that
//! both places and both ends miss is not seen: a window `if 10.0 < t && t < 10.1 { −1 } else { 1 }` in a step of 1,
//! say. Bound the steps by `max_step` where g has such windows.
//!
//! An adaptive step aims a little beyond a terminal event that is expected within it: it has that size, unless the size
//! that it was to have, the end of the run or an instant of a control law is less. The ends of the step before let
//! expect the event, by the parabola through g, its rate and its second derivative and then by the quintic interpolant,
//! if g crosses zero there and does not only graze it. After three steps that have aimed and met nothing, no step of a
//! run aims. None does in systems with switches or constraints, nor for numbers with slopes.
//!
//! A terminal event that the ends show to be alone in its step is landed on at once. That is so if the cubic goes from
//! one side to the other, and each of its Bernstein coefficients is beyond the one before by more than 16/15 D and a
//! sixteenth of the change of g; the other events keep their signs. From the end of a step that has aimed at it the
//! quintic interpolant leads to the event, if its acceleration there is that of the system: their difference, four
//! times as large, may not change the state by more than the tolerance. Otherwise steps from the start of this one do,
//! two as a rule, by Newton's method from the root on the quintic interpolant.
//!
//! In all other steps g is evaluated at the ends of equal parts, as many as the order of the method (at least 8), and
//! close to both ends of the step. Between two neighbours of opposite sign there is a root. Where |g| is smaller than
//! at both neighbours, its minimum is sought, which finds two crossings within one part, and a zero that is touched and
//! not crossed. Two crossings in the part before or after another one show themselves by |g| that grows towards that
//! one. What can be missed: an even number of crossings within one part of a step without either sign, and the second
//! of two pairs of crossings in one part, i.e. a g that varies much faster than the motion, or that has a kink there.
//! Shorter steps find it, for instance [`Run::until`] in pieces, or a smaller tolerance.
//!
//! After a restart g is sampled densely from the start on, at powers of 1/4 of the first step, for the next impact may
//! follow soon: down to 1e-8 of the step, and from a start at which g vanishes down to 16 roundings of time. Bounces
//! that accumulate (each flight a fraction of the one before) end in [`Failure::EventsAccumulate`] where rounding hides
//! the flight: at a terminal event that the motion leaves to the side it came from, and beyond which it is found. Hold
//! the ball at rest before that.
//!
//! A touch is a touch only to rounding of g: integration errors make a near miss of it, or two crossings. It is
//! reported to events of either direction only. [`Event::touching`] widens what counts as one. A zero that is touched
//! at a kink, as by `abs(x)`, is seen with it alone: `touching(1e-9)`.
//!
//! A run that ends within rounding of a root has met it, at its end: a run that continues from there does not find the
//! root again, so that a motion that is integrated in pieces meets each event once. A [`Stepper`](crate::Stepper) keeps
//! on which side of zero its last events were, for another search for the same ones from the same time: two stops that
//! are met at one time are both met, although the state is set at the first one. It is left at the event that was met
//! last, unless the search ran to the end, so that `stepper.until(t).events(…).next()` in a loop meets each of them.
//! Events are compared by their name, direction and end, and by g; without g if an input has changed. A stepper
//! searches for up to 16 events at once.
//!
//! An input that changes and takes g across zero is an event at that time (g is right-continuous, as inputs are),
//! also between two searches for the same events by a stepper. Another state or system, by `set_state` or
//! `system_mut`, is none, and hides what an input has changed before it. Of several events at the end of
//! `stepper.until(t)`, met one by one, those after the first may be met at the start of the next search.
//!
//! The start of a run is no occurrence, even where g vanishes at it, and neither is the state with which a run is
//! restarted at an event. A start counts as one where g vanishes if |g| is there at most its change within rounding:
//! a few units in the last place of time, along the motion, and of each coordinate and velocity. So a new run from
//! the state at which an event ended the last one does not find the same event again, and a root 1e-9 s after the
//! start is found. A stretch on which g is exactly 0 is one occurrence, at its first point. Jumps and poles of g
//! through which its sign changes count as roots. A g that is infinite or not a number is a
//! [`Failure::EventNotFinite`], unless a terminal event comes before it.

use crate::controller::Controller;
use crate::failed::Failed;
use crate::failure::Failure;
use crate::integrate::{Drive, Number, Run, Statistics};
use crate::method::{Method, Step};
use crate::scalar::{Real, Scalar};
use crate::state::State;
use crate::system::System;
use landing::{Judge, Landing, Outlook, Progress};
use locate::{Stepped, approached, land, on_interpolant, outline};
use outline::Outline;
use search::Search;
use sides::{Left, Side, Sides};

pub(crate) mod definition;
pub(crate) mod landing;
pub(crate) mod locate;
pub(crate) mod outline;
pub(crate) mod root;
pub(crate) mod scan;
pub(crate) mod search;
pub(crate) mod sides;
pub(crate) mod within;

pub use crate::quadrature::{Integrals, Total};
pub use crate::sample::{Evenly, Samples};
pub(crate) use definition::On;
pub use definition::{Compiled, CompiledEvents, Direction, Event, EventFunction, EventKind, EventSet};
#[cfg(feature = "analysis")]
pub(crate) use root::first_zero;
pub use within::Within;

/// One occurrence of an event.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Occurrence<S, const N: usize> {
    /// Index of the event in the array or tuple given.
    pub event: usize,
    /// Name of the event, empty unless given.
    pub name: &'static str,
    /// The state there: of a terminal event as accurate as the ends of steps, otherwise as the interpolant.
    pub state: State<S, N>,
    /// Direction in which g passed through zero; [`Direction::Either`] if g touched zero.
    pub direction: Direction,
    /// True if the run has ended here, see [`Event::terminal`].
    pub terminal: bool,
}

impl<Sys, M, C, const N: usize> Run<'_, Sys, M, C, N>
where
    Sys: System<N>,
    Sys::Scalar: Real,
    M: Method<Sys, N>,
    C: Controller<Sys::Scalar, N, M::Error>,
{
    /// The events of this run in their order in time; those at one time (but for rounding) in the order given. Without
    /// an end the run continues until a terminal event.
    ///
    /// The period of a pendulum, from its passages through the vertical:
    ///
    /// ```
    /// use lagrange_runtime::prelude::*;
    ///
    /// lagrangian! {
    ///     system Pendulum {
    ///         param m, l, g = 9.81;
    ///         coord theta;
    ///         T = 0.5 * m * (l * dot(theta)).powi(2);
    ///         V = -m * g * l * cos(theta);
    ///     }
    /// }
    /// let start = State::new(0.0, [2.0], [0.0]);
    /// let pendulum = Pendulum::new(1.0, 0.85);
    /// let run = integrate(&pendulum, Dop853, PiController::tolerance(1e-13), start).until(10.0);
    /// let passages: Vec<_> = run.events(Event::rising(|s| s.q[0])).collect::<Result<_, _>>()?;
    /// let period = passages[1].state.t - passages[0].state.t;
    /// // 4 √(l/g) K(sin 1), by the complete elliptic integral of the first kind.
    /// assert!((period - 2.4578115674871897).abs() < 1e-10);
    /// # Ok::<(), Failure>(())
    /// ```
    ///
    /// Several events at once: `run.events((Event::falling(…).terminal(), Event::either(…).named("turning")))`.
    pub fn events<E, const K: usize>(self, events: E) -> Events<Self, E, K, N>
    where
        E: EventSet<Sys, N, K>,
    {
        Events::new(self, events)
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Stage<S, const N: usize> {
    /// No step is being looked at.
    Between,
    /// Some events of the step may be left.
    Within,
    /// A terminal event was yielded, at this fraction of the step; those at the same time are left.
    Landed(f64, State<S, N>),
    Ended,
}

/// The events of a run, or of a stepper, made by [`Run::events`]. It ends with the run, after a terminal event, or
/// after a failure, and continues after [`restart`](Self::restart).
#[must_use = "it makes no step unless it is iterated over, or run to its end"]
pub struct Events<D: Drive<N>, E, const K: usize, const N: usize> {
    run: D,
    events: E,
    step: Option<Stepped<D::System, D::Method, N>>,
    search: Search<K>,
    stage: Stage<Number<D, N>, N>,
    /// The step, and its only event, on which the run has landed, of which the search is still to be told.
    alone: Option<(Outline<Number<D, N>, N>, usize)>,
}

/// An event where a motion is left.
fn left<Sys: System<N, Scalar: Real>, E: EventSet<Sys, N, K>, const K: usize, const N: usize>(
    events: &E,
    system: &Sys,
    event: usize,
    at: &State<Sys::Scalar, N>,
) -> Left {
    Left { event: events.kind(event).hash(), g: events.value(system, event, at).to_f64() }
}

/// Outcome of the search for the next step with events.
enum Next<S, const N: usize> {
    /// No step is left.
    End,
    /// A step in which there may be events.
    Step,
    /// The event that ended the run.
    Landed(Occurrence<S, N>),
}

type Outcome<S, const N: usize> = Result<Option<Occurrence<S, N>>, Failure<S>>;

impl<D: Drive<N>, E: EventSet<D::System, N, K>, const K: usize, const N: usize> Events<D, E, K, N> {
    pub(crate) fn new(mut run: D, events: E) -> Self {
        let mut search = Search::NEW;
        if D::IS_LEFT {
            let (state, sides) = (*run.state(), run.sides().copied().unwrap_or_default());
            search.comes_from(sides.of(state.t.to_f64(), |event| left(&events, run.system(), event, &state)));
        }
        Events { run, events, step: None, search, stage: Stage::Between, alone: None }
    }

    /// Keeps the sides of the events where the motion may be left, `landed` before.
    fn keep_sides(&mut self, landed: bool) {
        self.tell_landed();
        let state = *self.run.state();
        match self.stage {
            Stage::Landed(..) => self.keep(&state, true, self.search.sides_landed()),
            Stage::Between | Stage::Ended if !landed => self.keep(&state, false, self.search.sides()),
            _ => {}
        }
    }

    /// Tells the search of the event on which the run has landed. (A run that ends there has no need for it.)
    fn tell_landed(&mut self) {
        if let Some((outline, event)) = self.alone.take()
            && let Stage::Landed(x, state) = self.stage
        {
            self.search.landed(&On(&self.events, self.run.system()), &outline, (event, x), &state);
        }
    }

    fn keep(&mut self, at: &State<Number<D, N>, N>, landed: bool, sides: [Side; K]) {
        let (events, system) = (&self.events, self.run.system());
        let sides = sides.into_iter().enumerate();
        let kept = sides.map(|(event, side)| (left(events, system, event, at), side));
        let kept = Sides::left(at.t.to_f64(), landed, kept);
        if let Some(sides) = self.run.sides() {
            *sides = kept;
        }
    }

    /// The state reached: the end of the last step, or the terminal event.
    pub fn state(&self) -> &State<Number<D, N>, N> {
        self.run.state()
    }

    /// The cost so far, that of landing on terminal events included.
    pub fn statistics(&self) -> Statistics {
        self.run.statistics()
    }

    /// Continues from `state`, which may differ from the one reached: an impact changes velocities. Events that were
    /// reported there, and that `state` lies on but for rounding, are not met there again. Those of the same time that
    /// were not reported yet are reported after the restart, if the motion from `state` still crosses them. A state
    /// from which no motion begins is the failure of the next step; a stepper keeps the state that it had.
    pub fn restart(&mut self, state: State<Number<D, N>, N>) {
        self.tell_landed();
        self.run.restart(state);
        self.step = None;
        self.stage = Stage::Between;
        self.search.restart();
    }

    /// Runs to the first terminal event, or to the end if there is none, and gives the state there.
    pub fn final_state(mut self) -> Result<State<Number<D, N>, N>, Failed<Number<D, N>, N>> {
        match self.by_ref().find_map(Result::err) {
            Some(failure) => Err(self.run.failed(failure)),
            None => Ok(*self.run.state()),
        }
    }

    /// The run itself, at the state reached.
    pub fn into_run(self) -> D {
        self.run
    }

    /// The next occurrence, step after step.
    fn advance(&mut self) -> Outcome<Number<D, N>, N> {
        loop {
            match self.stage {
                Stage::Ended => return Ok(None),
                Stage::Between => match self.next_step()? {
                    Next::End => return Ok(self.at_end()),
                    Next::Landed(occurrence) => return Ok(Some(occurrence)),
                    Next::Step => self.stage = Stage::Within,
                },
                Stage::Within => match self.within_step()? {
                    Some(occurrence) => return Ok(Some(occurrence)),
                    None => self.stage = Stage::Between,
                },
                Stage::Landed(x, state) => {
                    let resolution = self.step.as_ref().map_or(0.0, Within::resolution);
                    let Some((event, direction)) = self.search.together(x, resolution) else {
                        self.stage = Stage::Ended;
                        return Ok(None);
                    };
                    return Ok(Some(self.occurrence(event, direction, state)));
                }
            }
        }
    }

    /// The next occurrence at the end of the run, within rounding of a root.
    fn at_end(&mut self) -> Option<Occurrence<Number<D, N>, N>> {
        let (event, direction) =
            self.search.at_end(&On(&self.events, self.run.system()), self.step.as_ref()?)?;
        let state = *self.run.state();
        if self.events.kind(event).terminal {
            self.stage = Stage::Landed(1.0, state);
        }
        Some(self.occurrence(event, direction, state))
    }

    /// Makes steps to the next one in which there may be events, and lands on the only one there, or begins to look at
    /// the step.
    fn next_step(&mut self) -> Result<Next<Number<D, N>, N>, Failure<Number<D, N>>> {
        let mut aimed = f64::INFINITY;
        loop {
            let memory = self.run.memory()?.clone();
            self.search.begin(&On(&self.events, self.run.system()), self.run.state())?;
            // (It stays where it is: steps are large.)
            let advanced = self.run.advance_towards(Some(aimed));
            let step = match &advanced {
                Some(Ok(step)) => step,
                Some(Err(failure)) => return Err(*failure),
                None => return Ok(Next::End),
            };
            if D::System::CONSTRAINTS > 0 {
                self.look_at_dependence(step)?;
            }
            if let Some(outline) = outline(&self.run.engine().method, step) {
                let next = self.run.engine().h;
                match self.search.outlook(&On(&self.events, self.run.system()), &outline, next) {
                    Outlook::Clear { aim } => {
                        (self.step, aimed) = (None, aim);
                        continue;
                    }
                    Outlook::Crossing(landing) if D::System::SWITCHES == 0 => {
                        if let Some(occurrence) = self.land(&memory, step, outline, landing) {
                            return Ok(Next::Landed(occurrence));
                        }
                    }
                    _ => {}
                }
            }
            let dense = self.run.interpolant(step);
            let parts = self.run.engine().method.parts(&memory, step.h);
            let crosses_shortly = self.run.engine().crosses_shortly();
            let step = step.clone();
            let stepped = self.step.insert(Stepped { step, dense, memory, parts, crosses_shortly });
            if let Err(failure) = self.search.enter(&On(&self.events, self.run.system()), stepped) {
                // The motion is known up to there.
                let (system, engine) = self.run.parts();
                engine.land(system, stepped.step.from);
                self.stage = Stage::Within;
                return Err(failure);
            }
            return Ok(Next::Step);
        }
    }

    /// Looks at events in the state of a step that is nearest to one at which constraints are dependent. Reactions may
    /// grow without bound there, and be finite at the ends of the step.
    #[cold]
    #[inline(never)]
    fn look_at_dependence(
        &mut self,
        step: &Step<D::System, D::Method, N>,
    ) -> Result<(), Failure<Number<D, N>>> {
        let (system, engine) = self.run.parts();
        let Some(at) = engine.nearest_dependence(system, step) else { return Ok(()) };
        for event in 0..K {
            if self.events.value(system, event, &at).to_f64().is_nan() {
                return Err(Failure::EventNotFinite { t: at.t, event: self.events.kind(event).at(event) });
            }
        }
        Ok(())
    }

    /// Lands on the event that a step has alone, unless its place has derivatives, which are that of a whole step.
    fn land(
        &mut self,
        memory: &<D::Method as Method<D::System, N>>::MethodState,
        step: &Step<D::System, D::Method, N>,
        outline: Outline<Number<D, N>, N>,
        landing: Landing,
    ) -> Option<Occurrence<Number<D, N>, N>> {
        let Events { run, events, search, .. } = self;
        let (system, engine) = run.parts();
        let (event, mut x) = (landing.event, landing.x);
        let g = |at: &State<Number<D, N>, N>| events.value(system, event, at);
        let approach = |landing: &mut Landing, reached: &Outline<_, N>, judge: &dyn Judge<_, N>| {
            let value = g(&reached.ends[1]);
            if (value - Number::<D, N>::from_f64(value.to_f64())).magnitude() > 0.0 {
                return Progress::Lost;
            }
            let progress = landing.step(reached, (step.h, outline.resolution()), g, judge);
            x = landing.x;
            progress
        };
        let state = approached(engine, system, memory, (step, &outline), landing, approach)?;
        engine.land(system, state);
        let direction = search.direction(event);
        (self.step, self.stage) = (None, Stage::Landed(x, state));
        self.alone = Some((outline, event));
        Some(self.occurrence(event, direction, state))
    }

    /// The next occurrence of the step.
    fn within_step(&mut self) -> Outcome<Number<D, N>, N> {
        let Some(stepped) = &self.step else { return Ok(None) };
        let Some((event, x, direction)) = self.search.next(&On(&self.events, self.run.system()), stepped)?
        else {
            return Ok(None);
        };
        let g = |system: &D::System, at: &State<Number<D, N>, N>| self.events.value(system, event, at);
        let terminal = self.events.kind(event).terminal;
        let state = match terminal {
            true => land(&mut self.run, stepped, self.events.kind(event).at(event), x, direction, g)?,
            false => {
                let system = self.run.system();
                on_interpolant(system, stepped, x, |at: &State<Number<D, N>, N>| g(system, at))
            }
        };
        let on = On(&self.events, self.run.system());
        let left = if D::IS_LEFT && !terminal {
            Some(self.search.left_at(&on, stepped, (event, x), &state))
        } else {
            None
        };
        self.search.met(&on, stepped, event, x, &state);
        if terminal {
            self.stage = Stage::Landed(x, state);
        }
        if let Some(left) = left {
            self.keep(&state, true, left.sides_landed());
            self.run.back_to(state);
        }
        Ok(Some(self.occurrence(event, direction, state)))
    }

    fn occurrence(
        &self,
        event: usize,
        direction: Direction,
        state: State<Number<D, N>, N>,
    ) -> Occurrence<Number<D, N>, N> {
        let terminal = matches!(self.stage, Stage::Landed(..));
        Occurrence { event, name: self.events.kind(event).name, state, direction, terminal }
    }
}

impl<D: Drive<N>, E: EventSet<D::System, N, K>, const K: usize, const N: usize> Iterator
    for Events<D, E, K, N>
{
    type Item = Result<Occurrence<Number<D, N>, N>, Failure<Number<D, N>>>;

    fn next(&mut self) -> Option<Self::Item> {
        self.run.return_to_end();
        let landed = matches!(self.stage, Stage::Landed(..));
        let outcome = self.advance();
        if D::IS_LEFT {
            self.keep_sides(landed);
        }
        if let Err(failure) = outcome {
            self.stage = Stage::Ended;
            if self.run.failure().is_none() {
                self.run.fail(failure);
            }
        }
        outcome.transpose()
    }
}
