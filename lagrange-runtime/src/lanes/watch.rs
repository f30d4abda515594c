//! Observers of trajectories, alone or in lanes.

use crate::event::landing::{Judge, Landing, Outlook, Progress};
use crate::event::locate::landing;
use crate::event::outline::Outline;
use crate::event::search::Search;
use crate::event::within::Within;
use crate::event::{EventKind, EventSet, Occurrence, On};
use crate::failure::Failure;
use crate::state::State;
use crate::system::System;
use core::fmt;

/// Observer of a trajectory, which runs alone ([`Run::observe`](crate::Run::observe)) or in a lane among others. Each
/// trajectory has an accumulator of its own; the observer has to be a pure function of what it is shown.
///
/// [`FinalState`] wants the last state, [`Sampled`] the states at given times, [`FoldSteps`] the ends of all steps,
/// [`Occurrences`] its events. A pair of watches is one, too.
pub trait Observer<Sys: System<N, Scalar = f64>, const N: usize> {
    /// Accumulator of a trajectory.
    type Accumulator;
    /// Output of a trajectory.
    type Output;

    /// True if [`step`](Self::step) is to be called.
    const STEPS: bool = false;

    /// The memory of a trajectory that begins at `start`.
    fn start(&self, system: &Sys, start: &State<f64, N>) -> Self::Accumulator;

    /// An accepted step.
    fn step(&self, memory: &mut Self::Accumulator, system: &Sys, from: &State<f64, N>, to: &State<f64, N>) {
        let _ = (memory, system, from, to);
    }

    /// The next time at which the state is recorded: the first of them, or the next one after that which was shown
    /// last.
    fn wanted(&self, memory: &Self::Accumulator) -> Option<f64> {
        let _ = memory;
        None
    }

    /// The state at the time that was wanted.
    fn sample(&self, memory: &mut Self::Accumulator, system: &Sys, at: &State<f64, N>) {
        let _ = (memory, system, at);
    }

    /// True if [`within`](Self::within) is to be called.
    const WITHIN: bool = false;

    /// An accepted step with the motion within it, before [`sample`](Self::sample). The state with which the run is
    /// to end there, if it is.
    ///
    /// # Errors
    /// If the run is to end as a failed one.
    fn within(
        &self,
        memory: &mut Self::Accumulator,
        system: &Sys,
        step: &dyn Motion<N>,
    ) -> Result<Option<State<f64, N>>, Failure> {
        let _ = (memory, system, step);
        Ok(None)
    }

    /// Events of an accepted step, as far as its ends show them; the size of the next one is `next`. If there are none,
    /// [`within`](Self::within) is not called, and no interpolant made. If it is one event, which ends the trajectory,
    /// steps are made towards it and shown to [`approach`](Self::approach).
    #[doc(hidden)]
    fn outlook(
        &self,
        memory: &mut Self::Accumulator,
        system: &Sys,
        step: &Outline<f64, N>,
        next: f64,
    ) -> Outlook {
        let _ = (memory, system, step, next);
        Outlook::Unclear
    }

    /// A step towards an event, `reached` from the start of `step`, with a judge of its errors. If its end is not the
    /// event and no more steps are to be made, `within` is called.
    #[doc(hidden)]
    fn approach(
        &self,
        memory: &mut Self::Accumulator,
        system: &Sys,
        step: &Outline<f64, N>,
        landing: &mut Landing,
        reached: &Outline<f64, N>,
        judge: &dyn Judge<f64, N>,
    ) -> Progress<f64, N> {
        let _ = (memory, system, step, landing, reached, judge);
        Progress::Lost
    }

    /// The output, at the end of the trajectory.
    fn finish(&self, memory: Self::Accumulator, system: &Sys, end: &State<f64, N>) -> Self::Output;
}

/// [`Failure::SampleOrder`] if a wanted time is not after the previous one, in the direction of h.
pub(crate) fn disordered(previous: f64, h: f64, wanted: Option<f64>) -> Option<Failure> {
    let t = wanted?;
    let after = if h < 0.0 { t < previous } else { t > previous };
    (!after).then_some(Failure::SampleOrder { t, previous })
}

/// The motion within a step, of a run or of one lane, in fractions of the step: its interpolant, and what steps lead
/// to.
pub trait Motion<const N: usize>: Within<f64, N> {
    /// The state that a step of this part of the size makes, from the same start.
    ///
    /// # Errors
    /// If it is not finite.
    fn stepped(&self, x: f64) -> Result<State<f64, N>, Failure>;
}

/// A function of the system and the last state.
#[derive(Clone, Copy)]
pub struct FinalState<F>(pub F);

impl<Sys, O, F, const N: usize> Observer<Sys, N> for FinalState<F>
where
    Sys: System<N, Scalar = f64>,
    F: Fn(&Sys, &State<f64, N>) -> O,
{
    type Accumulator = ();
    type Output = O;

    fn start(&self, _: &Sys, _: &State<f64, N>) {}

    fn finish(&self, (): (), system: &Sys, end: &State<f64, N>) -> O {
        self.0(system, end)
    }
}

/// A function of the states at given times, which lie in the direction of the run, from its start to its end. States
/// are interpolated and do not influence the steps; the start, the end and the ends of steps are exact. At times that
/// a run does not come to there are none. Where one is not after the one before, or before the start, the sample
/// fails with [`Failure::SampleOrder`].
#[derive(Clone)]
pub struct Sampled<F> {
    times: Vec<f64>,
    function: F,
}

impl<F> Sampled<F> {
    /// A function of the states at these times.
    pub fn new(times: impl IntoIterator<Item = f64>, function: F) -> Self {
        Sampled { times: times.into_iter().collect(), function }
    }
}

impl<Sys, O, F, const N: usize> Observer<Sys, N> for Sampled<F>
where
    Sys: System<N, Scalar = f64>,
    F: Fn(&Sys, &[State<f64, N>]) -> O,
{
    type Accumulator = Vec<State<f64, N>>;
    type Output = O;

    fn start(&self, _: &Sys, _: &State<f64, N>) -> Self::Accumulator {
        Vec::with_capacity(self.times.len())
    }

    fn wanted(&self, states: &Self::Accumulator) -> Option<f64> {
        self.times.get(states.len()).copied()
    }

    fn sample(&self, states: &mut Self::Accumulator, _: &Sys, at: &State<f64, N>) {
        states.push(*at);
    }

    fn finish(&self, states: Self::Accumulator, system: &Sys, _: &State<f64, N>) -> O {
        (self.function)(system, &states)
    }
}

/// A fold over the accepted steps: `start` makes the first value of the start, `step` changes it by the end of a
/// step, and `finish` makes the output of it. A maximum, say, or the time of the last turn.
#[derive(Clone, Copy)]
pub struct FoldSteps<I, F, E> {
    /// The first value.
    pub start: I,
    /// Changes it by a step from one state to another.
    pub step: F,
    /// The output.
    pub finish: E,
}

impl<Sys, T, O, I, F, E, const N: usize> Observer<Sys, N> for FoldSteps<I, F, E>
where
    Sys: System<N, Scalar = f64>,
    I: Fn(&Sys, &State<f64, N>) -> T,
    F: Fn(&mut T, &Sys, &State<f64, N>, &State<f64, N>),
    E: Fn(T, &Sys, &State<f64, N>) -> O,
{
    type Accumulator = T;
    type Output = O;
    const STEPS: bool = true;

    fn start(&self, system: &Sys, start: &State<f64, N>) -> T {
        (self.start)(system, start)
    }

    fn step(&self, value: &mut T, system: &Sys, from: &State<f64, N>, to: &State<f64, N>) {
        (self.step)(value, system, from, to);
    }

    fn finish(&self, value: T, system: &Sys, end: &State<f64, N>) -> O {
        (self.finish)(value, system, end)
    }
}

/// A function of the [events](crate::event) of a trajectory, of which the first terminal one ends it: those that
/// [`Run::events`](crate::Run::events) finds when the trajectory is run alone.
///
/// ```
/// use lagrange_runtime::lanes::Occurrences;
/// use lagrange_runtime::prelude::*;
/// lagrangian! {
///     /// A ball above the ground.
///     pub system Ball {
///         param m, g = 9.81;
///         coord y;
///         T = 0.5 * m * dot(y).powi(2);
///         V = m * g * y;
///     }
/// }
/// let ground = Event::falling(|s: &State<f64, 1>| s.q[0]).terminal();
/// let landed = Occurrences::new(ground, |_: &Ball, met, _: &State<f64, 1>| met[0].state.t);
/// let (ball, start) = (Ball::new(0.1), State::new(0.0, [1.0], [0.0]));
/// let time = integrate(&ball, Dop853, PiController::tolerance(1e-9), start).until(10.0).observe(&landed)?;
/// assert!((time - (2.0f64 / 9.81).sqrt()).abs() < 1e-12);
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
///
/// In a study of an `Ensemble` it is given to `Study::observe`, alone or in lanes.
#[derive(Clone, Copy)]
pub struct Occurrences<E, F, const K: usize> {
    events: E,
    function: F,
}

impl<E, F, const K: usize> Occurrences<E, F, K> {
    /// A function of the system, of what happened, in the order of time, and of the last state.
    pub fn new<Sys, O, const N: usize>(events: E, function: F) -> Self
    where
        Sys: System<N, Scalar = f64>,
        E: EventSet<Sys, N, K>,
        F: Fn(&Sys, &[Occurrence<f64, N>], &State<f64, N>) -> O,
    {
        Occurrences { events, function }
    }
}

/// Accumulator of the [`Occurrences`] of a trajectory.
#[derive(Clone, Debug)]
pub struct Happened<const K: usize, const N: usize> {
    search: Search<K>,
    occurrences: Vec<Occurrence<f64, N>>,
    /// The occurrences that count if the trajectory ends with the last step.
    at_end: Vec<Occurrence<f64, N>>,
}

impl<Sys, O, E, F, const K: usize, const N: usize> Observer<Sys, N> for Occurrences<E, F, K>
where
    Sys: System<N, Scalar = f64>,
    E: EventSet<Sys, N, K>,
    F: Fn(&Sys, &[Occurrence<f64, N>], &State<f64, N>) -> O,
{
    type Accumulator = Happened<K, N>;
    type Output = O;
    const WITHIN: bool = true;

    fn start(&self, _: &Sys, _: &State<f64, N>) -> Self::Accumulator {
        Happened { search: Search::NEW, occurrences: vec![], at_end: vec![] }
    }

    fn within(
        &self,
        Happened { search, occurrences, at_end }: &mut Self::Accumulator,
        system: &Sys,
        step: &dyn Motion<N>,
    ) -> Result<Option<State<f64, N>>, Failure> {
        at_end.clear();
        let events = On(&self.events, system);
        search.begin(&events, &step.at(0.0))?;
        search.enter(&events, step)?;
        while let Some((event, x, direction)) = search.next(&events, step)? {
            let kind = self.events.kind(event);
            let terminal = kind.terminal;
            let state = if terminal {
                let g = |at: &State<f64, N>| self.events.value(system, event, at);
                landing(step, kind.at(event), x, direction, g, |x| step.stepped(x))?.1
            } else {
                step.at(x)
            };
            search.met(&events, step, event, x, &state);
            let mut add = |event: usize, direction| {
                let name = self.events.kind(event).name;
                occurrences.push(Occurrence { event, name, state, direction, terminal });
            };
            add(event, direction);
            if terminal {
                while let Some((event, direction)) = search.together(x, step.resolution()) {
                    add(event, direction);
                }
                return Ok(Some(state));
            }
        }
        // Of a copy: if the trajectory goes on, the roots are found in the next step.
        let mut search = *search;
        while let Some((event, direction)) = search.at_end(&events, step) {
            let EventKind { name, terminal, .. } = self.events.kind(event);
            at_end.push(Occurrence { event, name, state: step.at(1.0), direction, terminal });
        }
        Ok(None)
    }

    #[inline(always)]
    fn outlook(
        &self,
        Happened { search, at_end, .. }: &mut Self::Accumulator,
        system: &Sys,
        step: &Outline<f64, N>,
        next: f64,
    ) -> Outlook {
        at_end.clear();
        let events = On(&self.events, system);
        match search.begin(&events, &step.ends[0]) {
            Ok(()) => search.outlook(&events, step, next),
            Err(_) => Outlook::Unclear,
        }
    }

    fn approach(
        &self,
        Happened { search, occurrences, .. }: &mut Self::Accumulator,
        system: &Sys,
        step: &Outline<f64, N>,
        landing: &mut Landing,
        reached: &Outline<f64, N>,
        judge: &dyn Judge<f64, N>,
    ) -> Progress<f64, N> {
        let event = landing.event;
        let g = |at: &State<f64, N>| self.events.value(system, event, at);
        let progress = landing.step(reached, (step.h, step.resolution()), g, judge);
        if let Progress::Landed(state) = progress {
            let direction = search.direction(event);
            let name = self.events.kind(event).name;
            occurrences.push(Occurrence { event, name, state, direction, terminal: true });
        }
        progress
    }

    fn finish(&self, mut happened: Self::Accumulator, system: &Sys, end: &State<f64, N>) -> O {
        happened.occurrences.append(&mut happened.at_end);
        (self.function)(system, &happened.occurrences, end)
    }
}

/// Two watches of one trajectory, of which one looks within steps at most. Where it ends the trajectory, it ends for
/// both.
impl<Sys, A, B, const N: usize> Observer<Sys, N> for (A, B)
where
    Sys: System<N, Scalar = f64>,
    A: Observer<Sys, N>,
    B: Observer<Sys, N>,
{
    /// Theirs, and the time at which the trajectory begins.
    type Accumulator = (A::Accumulator, B::Accumulator, f64);
    type Output = (A::Output, B::Output);
    const STEPS: bool = A::STEPS || B::STEPS;
    const WITHIN: bool = {
        assert!(!(A::WITHIN && B::WITHIN), "give all events of a trajectory to one `Occurrences`");
        A::WITHIN || B::WITHIN
    };

    fn start(&self, system: &Sys, start: &State<f64, N>) -> Self::Accumulator {
        (self.0.start(system, start), self.1.start(system, start), start.t)
    }

    fn step(&self, memory: &mut Self::Accumulator, system: &Sys, from: &State<f64, N>, to: &State<f64, N>) {
        self.0.step(&mut memory.0, system, from, to);
        self.1.step(&mut memory.1, system, from, to);
    }

    /// The nearer one to the start, since the run may be one backward in time.
    fn wanted(&self, memory: &Self::Accumulator) -> Option<f64> {
        let away = |time: &f64| (time - memory.2).abs();
        let both = [self.0.wanted(&memory.0), self.1.wanted(&memory.1)];
        both.into_iter().flatten().min_by(|a, b| away(a).total_cmp(&away(b)))
    }

    fn sample(&self, memory: &mut Self::Accumulator, system: &Sys, at: &State<f64, N>) {
        if self.0.wanted(&memory.0) == Some(at.t) {
            self.0.sample(&mut memory.0, system, at);
        }
        if self.1.wanted(&memory.1) == Some(at.t) {
            self.1.sample(&mut memory.1, system, at);
        }
    }

    fn within(
        &self,
        memory: &mut Self::Accumulator,
        system: &Sys,
        step: &dyn Motion<N>,
    ) -> Result<Option<State<f64, N>>, Failure> {
        if A::WITHIN {
            self.0.within(&mut memory.0, system, step)
        } else {
            self.1.within(&mut memory.1, system, step)
        }
    }

    #[inline(always)]
    fn outlook(
        &self,
        memory: &mut Self::Accumulator,
        system: &Sys,
        step: &Outline<f64, N>,
        next: f64,
    ) -> Outlook {
        if A::WITHIN {
            self.0.outlook(&mut memory.0, system, step, next)
        } else {
            self.1.outlook(&mut memory.1, system, step, next)
        }
    }

    fn approach(
        &self,
        memory: &mut Self::Accumulator,
        system: &Sys,
        step: &Outline<f64, N>,
        landing: &mut Landing,
        reached: &Outline<f64, N>,
        judge: &dyn Judge<f64, N>,
    ) -> Progress<f64, N> {
        if A::WITHIN {
            self.0.approach(&mut memory.0, system, step, landing, reached, judge)
        } else {
            self.1.approach(&mut memory.1, system, step, landing, reached, judge)
        }
    }

    fn finish(&self, memory: Self::Accumulator, system: &Sys, end: &State<f64, N>) -> Self::Output {
        (self.0.finish(memory.0, system, end), self.1.finish(memory.1, system, end))
    }
}

macro_rules! debug {
    ($($name:ident<$($parameter:ident),*>)*) => {$(
        impl<$($parameter),*> fmt::Debug for $name<$($parameter),*> {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.debug_struct(stringify!($name)).finish_non_exhaustive()
            }
        }
    )*};
}

debug! { FinalState<F> Sampled<F> FoldSteps<I, F, E> }

impl<E: fmt::Debug, F, const K: usize> fmt::Debug for Occurrences<E, F, K> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Occurrences").field("events", &self.events).finish_non_exhaustive()
    }
}
