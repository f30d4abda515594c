//! The loop over lanes.

use super::course::{Apart, Own};
use super::job::{Alone, Bounds, ErrorOf, Jobs, LANES, MemoryOf, Packed};
use super::pack::{Entry, Occupant, Pace, Pack};
use crate::controller::{Controller, FirstStep};
use crate::event::landing::{Judge, Landing, Progress};
use crate::event::outline::Outline;
use crate::failed::{Failed, Statistics};
use crate::failure::Failure;
use crate::integrate::engine::{Engine, restart_shorter, restore, tolerated};
use crate::integrate::integrate;
use crate::integrate::rules;
use crate::lanes::{
    LaneController, Lanes, Lanewise, Observer, Policy, Processor, Rescale, SingleLane, Work, disordered,
};
use crate::method::{Method, Step};
use crate::scalar::Real;
use crate::state::{State, Tangent};
use crate::system::System;
use nalgebra::SVector;

type EntryOf<Sys, M, C, P, A, T, const N: usize> =
    Entry<Sys, T, C, SingleLane<P, A>, <MemoryOf<M, Sys, P, A, N> as Lanewise<LANES>>::Element, N>;
pub type PackOf<Sys, M, C, P, A, T, const N: usize> = Pack<Sys, P, A, C, MemoryOf<M, Sys, P, A, N>, T, N>;
pub type StepOf<Sys, M, P, A, const N: usize> = Step<Packed<Sys, P, A, N>, M, N>;
pub type ElementOf<M, Sys, P, A, const N: usize> = <ErrorOf<M, Sys, P, A, N> as Lanewise<LANES>>::Element;

/// All that is to be done.
pub struct Convoy<'a, Sys, M, C, P, A, W, J, const N: usize>
where
    Sys: Rescale<N, Scalar = f64>,
    P: Policy,
    A: Processor,
    M: Method<Packed<Sys, P, A, N>, N, MethodState: Lanewise<LANES>>,
    W: Observer<Sys, N>,
{
    pub method: &'a M,
    pub controller: &'a C,
    pub end: f64,
    max_steps: Option<u64>,
    pub watch: &'a W,
    pub jobs: &'a mut J,
    /// Runs before a step in which there may be events, and those that have been through one and go on.
    pub waiting: Vec<EntryOf<Sys, M, C, P, A, W::Accumulator, N>>,
    resumed: Vec<EntryOf<Sys, M, C, P, A, W::Accumulator, N>>,
    /// Runs on their way to the event that their step has alone.
    pub landing: Vec<(EntryOf<Sys, M, C, P, A, W::Accumulator, N>, Approached<N>)>,
}

/// The step in which a run has one event alone, the way there, the cost of the run with that step, and the evaluations
/// on the way.
pub struct Approached<const N: usize> {
    pub outline: Outline<f64, N>,
    pub landing: Landing,
    pub cost: Statistics,
    pub evaluations: u64,
}

/// Start of a run of a lane alone, its constants of time and its memory: `None` if it begins at its end.
fn ready<Sys, M, C, const N: usize>(
    system: &Sys,
    method: M,
    controller: C,
    start: State<Sys::Scalar, N>,
    end: Sys::Scalar,
) -> Result<Option<(State<Sys::Scalar, N>, M::MethodState, Pace)>, Failure<Sys::Scalar>>
where
    Sys: System<N>,
    Sys::Scalar: Real,
    M: Method<Sys, N>,
    C: Controller<Sys::Scalar, N, M::Error>,
{
    let mut run = integrate(system, method, controller, start).until(end);
    run.engine.begin(system)?;
    let Engine { state, memory, h, origin, total, bound, controller, statistics, .. } = run.engine;
    let fixed = matches!(controller.first_step(), FirstStep::Fixed(_));
    let over = if fixed { total == 0.0 } else { state.t == end };
    let (h, origin) = (h.to_f64(), origin.to_f64());
    let pace = Pace { h, origin, total, bound, evaluations: statistics.evaluations, ..Pace::NONE };
    Ok(memory.filter(|_| !over).map(|memory| (state, memory.now().clone(), pace)))
}

/// Steps that lanes had to make alone.
pub struct Made<D> {
    pub which: [bool; LANES],
    pub sizes: [f64; LANES],
    pub own: Vec<Own<D>>,
    pub failed: Vec<(usize, Failure)>,
}

impl<'a, Sys, M, C, P, A, W, J, const N: usize> Convoy<'a, Sys, M, C, P, A, W, J, N>
where
    Sys: Rescale<N, Scalar = f64>,
    P: Policy,
    A: Processor,
    M: Clone,
    M: Method<Packed<Sys, P, A, N>, N, Error: Lanewise<LANES>, MethodState: Lanewise<LANES>>,
    M: Method<
            Alone<Sys, P, A, N>,
            N,
            Error = ElementOf<M, Sys, P, A, N>,
            MethodState = <MemoryOf<M, Sys, P, A, N> as Lanewise<LANES>>::Element,
        >,
    C: LaneController<LANES, P, A, ErrorOf<M, Sys, P, A, N>, N>,
    W: Observer<Sys, N>,
    J: Jobs<Sys, W::Output, N>,
{
    pub fn new(method: &'a M, controller: &'a C, bounds: Bounds, watch: &'a W, jobs: &'a mut J) -> Self {
        let Bounds { end, max_steps } = bounds;
        Convoy {
            method,
            controller,
            end,
            max_steps,
            watch,
            jobs,
            waiting: vec![],
            resumed: vec![],
            landing: vec![],
        }
    }

    /// Steps are equal.
    #[inline(always)]
    pub fn fixed(&self) -> bool {
        matches!(self.controller.alone().first_step(), FirstStep::Fixed(_))
    }

    /// Steps end at switches, by the rules of runs. (What follows a constant is not compiled where it is false.)
    #[inline(always)]
    pub fn switching(&self) -> bool {
        let switches = const { <Packed<Sys, P, A, N> as System<N>>::SWITCHES > 0 };
        switches && !self.fixed() && !<M as Method<Packed<Sys, P, A, N>, N>>::ends_at_switches(self.method)
    }

    /// The next run that has a way to go; those that have none, or cannot begin, are done at once.
    #[inline(never)]
    fn next(&mut self) -> Option<EntryOf<Sys, M, C, P, A, W::Accumulator, N>> {
        let Convoy { method, controller, end, watch, jobs, .. } = self;
        let end = *end;
        while let Some(job) = jobs.next() {
            let system = job.system.over(SingleLane::<P, A>::new);
            let start = job.start.map(SingleLane::new);
            let mut watched = watch.start(&job.system, &job.start);
            let t = job.start.t;
            if watch.wanted(&watched) == Some(t) {
                watch.sample(&mut watched, &job.system, &job.start);
            }
            let begun = match disordered(t, end - t, watch.wanted(&watched)) {
                Some(failure) => Err(failure),
                None => ready(&system, (*method).clone(), controller.alone(), start, SingleLane::new(end))
                    .map_err(|failure| failure.map(SingleLane::value)),
            };
            match begun {
                Ok(Some((state, memory, pace))) => {
                    let (occupant, controller) = (Occupant { job, watched }, (*controller).clone());
                    return Some(Entry { occupant, state, memory, controller, pace });
                }
                Ok(None) => {
                    let output = watch.finish(watched, &job.system, &job.start);
                    jobs.done(job.index, Statistics::default(), Ok(output));
                }
                Err(failure) => {
                    let (start, statistics) = (job.start, Statistics::default());
                    jobs.done(job.index, statistics, Err(Failed { failure, start, last: start, statistics }));
                }
            }
        }
        None
    }

    /// Fills a lane whose run has ended.
    pub fn fill(&mut self, pack: &mut PackOf<Sys, M, C, P, A, W::Accumulator, N>, lane: usize) {
        (pack.occupants[lane], pack.live[lane], pack.paces.h[lane]) = (None, false, 0.0);
        if pack.searches {
            return;
        }
        match self.resumed.pop().or_else(|| self.next()) {
            Some(entry) => pack.enter(lane, entry),
            None => pack.idle(lane),
        }
    }

    /// Ends the run of a lane by a failure.
    #[cold]
    #[inline(never)]
    pub fn fail(
        &mut self,
        pack: &mut PackOf<Sys, M, C, P, A, W::Accumulator, N>,
        lane: usize,
        failure: Failure,
    ) {
        if let Some(Occupant { job, .. }) = pack.occupants[lane].take() {
            let (system, last) = (job.system.over(SingleLane::<P, A>::new), pack.state.lane(lane));
            let (start, failure) = (job.start.map(SingleLane::new), failure.map(SingleLane::new));
            let failure = system.explained(&start, &last, failure).map(SingleLane::value);
            let (last, statistics) = (last.map(SingleLane::value), pack.statistics(lane));
            self.jobs.done(
                job.index,
                statistics,
                Err(Failed { failure, start: job.start, last, statistics }),
            );
        }
        self.fill(pack, lane);
    }

    /// Begins the next steps from the shorter parameters of attitudes, where there are any.
    #[cold]
    #[inline(never)]
    pub fn shorten(&mut self, pack: &mut PackOf<Sys, M, C, P, A, W::Accumulator, N>) {
        for i in 0..LANES {
            let Some(Occupant { job, .. }) = &pack.occupants[i] else { continue };
            let alone = || job.system.over(SingleLane::<P, A>::new);
            let at = pack.state.lane(i);
            let memory = || Some(pack.memories.now().lane(i));
            let equal = self.fixed().then(|| SingleLane::new(pack.paces.h[i]));
            let (restarted, evaluations) =
                restart_shorter::<Alone<Sys, P, A, N>, M, _, _, N>(alone, self.method, memory, &at, equal);
            pack.paces.evaluations[i] = pack.paces.evaluations[i].wrapping_sub(evaluations);
            match restarted {
                None => {}
                Some(Ok((shorter, memory))) => {
                    pack.state.put(i, &shorter);
                    pack.memories.now_mut().put(i, &memory);
                }
                Some(Err(failure)) => self.fail(pack, i, failure.map(SingleLane::value)),
            }
        }
    }

    /// The steps that are tried, whether they land on the end, and whether they aim at an event; `None` if some lanes
    /// cannot try one, whose runs are over.
    #[inline(always)]
    pub fn aim(
        &mut self,
        pack: &mut PackOf<Sys, M, C, P, A, W::Accumulator, N>,
    ) -> Option<([f64; LANES], [bool; LANES], [bool; LANES])> {
        let (end, fixed, switching) = (self.end, self.fixed(), self.switching());
        let budget = rules::budget(self.max_steps, fixed);
        let t = *pack.state.t.as_array();
        let (mut stuck, mut tiny) = (false, false);
        // Attempts at the start of runs are those of the pack less theirs.
        let all = pack.attempts;
        if !fixed || budget < u64::MAX {
            for i in 0..LANES {
                stuck |= pack.live[i] & (all.wrapping_sub(pack.paces.attempts[i]) >= budget);
            }
        }
        // (Not before a run ends by its budget: it is not asked again whether it coasts.)
        if !fixed
            && !stuck
            && (0..LANES).any(|i| pack.live[i] & (pack.paces.h[i].abs() > pack.paces.bound[i]))
        {
            self.limit(pack);
        }
        let (mut tried, mut lands, mut aims) = (pack.paces.h, [false; LANES], [false; LANES]);
        if fixed && pack.interrupted {
            let ([origin, total], count) = ([pack.paces.origin, pack.paces.total], pack.paces.count);
            for i in 0..LANES {
                if pack.paces.stopped[i] {
                    let [h, origin, end] = [tried[i], origin[i], end].map(SingleLane::<P, A>::new);
                    let next = rules::next_time(count[i], total[i], h, origin, Some(end));
                    tried[i] = next.value() - t[i];
                }
            }
        }
        if !fixed {
            for i in 0..LANES {
                let h = pack.paces.h[i];
                let approach = &pack.paces.approach[i];
                let to_switch = (switching && approach.is_near()).then_some(approach.h);
                (tried[i], lands[i]) = rules::towards_end(h, to_switch, Some(end - t[i]));
                if const { W::WITHIN && rules::aims::<Packed<Sys, P, A, N>, N>() } {
                    let aimed = rules::towards_event(tried[i], pack.paces.aim[i], Some(end - t[i]));
                    aims[i] = aimed.is_some();
                    (tried[i], lands[i]) = aimed.map_or((tried[i], lands[i]), |size| (size, false));
                }
                stuck |= pack.live[i] & !lands[i] & rules::underflows(t[i], h);
                tiny |= pack.live[i] & rules::is_tiny(h, pack.paces.longest[i]);
            }
        }
        if stuck {
            self.stuck(pack, &lands, budget);
            return None;
        }
        if tiny && self.cancelled(pack) {
            return None;
        }
        pack.attempts += 1;
        Some((tried, lands, aims))
    }

    /// Shortens steps of lanes beyond their bounds.
    #[cold]
    #[inline(never)]
    fn limit(&self, pack: &mut PackOf<Sys, M, C, P, A, W::Accumulator, N>) {
        for i in 0..LANES {
            let Some(Occupant { job, .. }) = &pack.occupants[i] else { continue };
            let (controller, at) = (pack.controllers[i].alone(), pack.state.lane(i));
            let (h, bound) = (pack.paces.h[i], pack.paces.bound[i]);
            let longest = Controller::<_, N, ElementOf<M, Sys, P, A, N>>::max_step(&controller);
            let coasts = || {
                pack.paces.evaluations[i] = pack.paces.evaluations[i].wrapping_sub(1);
                let system = job.system.over(SingleLane::<P, A>::new);
                rules::coasts::<_, ElementOf<M, Sys, P, A, N>, _, N>(&system, controller.clone(), at, bound)
            };
            pack.paces.h[i] = rules::limited(h, longest, bound, coasts);
        }
    }

    /// Ends the runs that have no step left: by their budget, or since it would not change their time.
    #[cold]
    #[inline(never)]
    fn stuck(
        &mut self,
        pack: &mut PackOf<Sys, M, C, P, A, W::Accumulator, N>,
        lands: &[bool; LANES],
        budget: u64,
    ) {
        let implicit = <M as Method<Packed<Sys, P, A, N>, N>>::implicit(self.method);
        for i in (0..LANES).filter(|i| pack.live[*i]).collect::<Vec<_>>() {
            let Pace { h, cause, attempts, .. } = pack.pace(i);
            let t = pack.state.t.as_array()[i];
            if attempts >= budget {
                self.fail(pack, i, Failure::BudgetUsedUp { t, h, max_steps: budget, implicit });
            } else if !self.fixed() && !lands[i] && rules::underflows(t, h) {
                let Some(Occupant { job, .. }) = &pack.occupants[i] else { continue };
                let (system, at) = (job.system.over(SingleLane::<P, A>::new), pack.state.lane(i));
                let failure = rules::underflowed(&system, &at, SingleLane::new(h), cause);
                self.fail(pack, i, failure.map(SingleLane::value));
            }
        }
    }

    /// Ends the runs whose velocities cancel before a very short step. Returns whether there were any.
    #[cold]
    #[inline(never)]
    fn cancelled(&mut self, pack: &mut PackOf<Sys, M, C, P, A, W::Accumulator, N>) -> bool {
        let mut any = false;
        for i in 0..LANES {
            if rules::is_tiny(pack.paces.h[i], pack.paces.longest[i])
                && let Some(Occupant { job, .. }) = &pack.occupants[i]
            {
                let (system, start) =
                    (job.system.over(SingleLane::<P, A>::new), job.start.map(SingleLane::new));
                if let Err(failure) = system.resolved(&start, &pack.state.lane(i)) {
                    self.fail(pack, i, failure.map(SingleLane::value));
                    any = true;
                }
            }
        }
        any
    }

    /// A step of a lane alone, of size h.
    fn apart(
        &self,
        pack: &PackOf<Sys, M, C, P, A, W::Accumulator, N>,
        system: &Sys,
        lane: usize,
        h: f64,
    ) -> Result<
        (Step<Alone<Sys, P, A, N>, M, N>, <MemoryOf<M, Sys, P, A, N> as Lanewise<LANES>>::Element),
        Failure,
    > {
        let made = A::call(Apart {
            method: self.method,
            controller: self.controller.alone(),
            system: system.over(SingleLane::<P, A>::new),
            memory: pack.memories.now().lane(lane),
            from: pack.state.lane(lane),
            h: SingleLane::new(h),
        });
        made.map_err(|failure| failure.map(SingleLane::value))
    }

    /// The next step of a lane whose step of size `tried` could not be made, by the rules of runs.
    #[cold]
    #[inline(never)]
    pub fn refused(
        &self,
        pack: &mut PackOf<Sys, M, C, P, A, W::Accumulator, N>,
        lane: usize,
        tried: f64,
        h: f64,
        failure: Failure,
    ) -> Result<f64, Failure> {
        let Some(Occupant { job, .. }) = &pack.occupants[lane] else { return Ok(0.0) };
        let (system, at) = (job.system.over(SingleLane::<P, A>::new), pack.state.lane(lane));
        let approach = if self.switching() { Some(&mut pack.paces.approach[lane]) } else { None };
        let shorter = || pack.controllers[lane].after_failure();
        let alone = failure.map(SingleLane::<P, A>::new);
        let factor = rules::retried(alone, approach, &system, &at, tried, shorter)
            .map_err(|failure| failure.map(SingleLane::value))?;
        pack.paces.rejected[lane] += 1;
        let Some(factor) = factor else { return Ok(h) };
        (pack.paces.cause[lane], pack.caused) = (failure.cause(), true);
        Ok(rules::next_step(h, tried, factor, false, false))
    }

    /// Makes steps of runs towards the events that theirs have alone, side by side. Runs that do not get there look for
    /// events as others do.
    #[inline(never)]
    fn land(&mut self, pack: &mut PackOf<Sys, M, C, P, A, W::Accumulator, N>) {
        let mut ways: [Option<Approached<N>>; LANES] = [const { None }; LANES];
        let runs = self.landing.split_off(self.landing.len().saturating_sub(LANES));
        for (lane, (entry, approached)) in runs.into_iter().enumerate() {
            pack.enter(lane, entry);
            ways[lane] = Some(approached);
        }
        while ways.iter().any(Option::is_some) {
            let mut sizes = [0.0; LANES];
            for (size, way) in sizes.iter_mut().zip(&ways) {
                *size = way.as_ref().map_or(0.0, |way| way.outline.h * way.landing.x);
            }
            let step = A::call(Together { convoy: &*self, pack: &mut *pack, sizes });
            let accelerations = step.as_ref().and_then(|step| {
                <M as Method<Packed<Sys, P, A, N>, N>>::end_accelerations(self.method, step)
            });
            for lane in 0..LANES {
                let (Some(way), Some(Occupant { job, watched })) =
                    (&mut ways[lane], &mut pack.occupants[lane])
                else {
                    continue;
                };
                let reached =
                    step.as_ref().zip(accelerations.as_ref()).map(|(step, accelerations)| Outline {
                        ends: [way.outline.ends[0], step.to.lane(lane).map(SingleLane::value)],
                        accelerations: accelerations.map(|a| a.map(|x| x.as_array()[lane])),
                        h: step.h.as_array()[lane],
                    });
                let progress = match &reached {
                    Some(reached) if reached.ends[1].is_finite() => {
                        way.evaluations += step.as_ref().map_or(0, |step| u64::from(step.evaluations));
                        let Approached { outline, landing, .. } = way;
                        let ends = reached.ends.map(|at| at.map(SingleLane::new));
                        let judge = self.judge(&job.system, &ends);
                        self.watch.approach(watched, &job.system, outline, landing, reached, &judge)
                    }
                    _ => Progress::Lost,
                };
                match progress {
                    Progress::Again => continue,
                    Progress::Landed(state) => {
                        if let Some(Occupant { job, mut watched }) = pack.occupants[lane].take() {
                            if W::STEPS {
                                self.watch.step(&mut watched, &job.system, &way.outline.ends[0], &state);
                            }
                            way.cost.evaluations += way.evaluations;
                            let output = self.watch.finish(watched, &job.system, &state);
                            self.jobs.done(job.index, way.cost, Ok(output));
                        }
                        pack.live[lane] = false;
                    }
                    Progress::Lost => {
                        let evaluations = &mut pack.paces.evaluations[lane];
                        *evaluations = evaluations.wrapping_sub(way.evaluations);
                        self.waiting.extend(pack.take(lane));
                    }
                }
                ways[lane] = None;
            }
        }
    }

    /// The judge of the way to an event in a step of a lane.
    pub fn judge<'b>(
        &'b self,
        system: &'b Sys,
        ends: &'b [State<SingleLane<P, A>, N>; 2],
    ) -> impl Judge<f64, N> + 'b {
        let tolerates = |error: &Tangent<f64, N>| {
            let error = Tangent { q: error.q.map(SingleLane::new), qd: error.qd.map(SingleLane::new) };
            !self.fixed() && self.controller.alone().norm(&error, &ends[0], &ends[1]) <= 1.0
        };
        let accelerations = |at: &State<f64, N>| {
            let system = system.over(SingleLane::<P, A>::new);
            A::call(Accelerate { system: &system, at: at.map(SingleLane::new) }).map(SingleLane::value)
        };
        (tolerates, accelerations)
    }

    /// Looks for the reasons why lanes cannot make their steps: the same step of each lane alone tells.
    #[cold]
    #[inline(never)]
    pub fn none_made(&mut self, pack: &mut PackOf<Sys, M, C, P, A, W::Accumulator, N>, tried: &[f64; LANES]) {
        for i in 0..LANES {
            if let Some(Occupant { job, .. }) = &pack.occupants[i] {
                let Err(failure) = self.apart(pack, &job.system, i, tried[i]) else {
                    unreachable!("a step that lanes cannot make is none that one of them can make alone")
                };
                match self.refused(pack, i, tried[i], pack.paces.h[i], failure) {
                    Ok(next) => pack.paces.h[i] = next,
                    Err(failure) => self.fail(pack, i, failure),
                }
            }
        }
    }

    /// Restores the constraints at the ends of steps. A lane that was moved too far has no end, and makes its step
    /// alone, which says so.
    #[inline(always)]
    pub fn restored(
        &self,
        pack: &mut PackOf<Sys, M, C, P, A, W::Accumulator, N>,
        step: &mut StepOf<Sys, M, P, A, N>,
    ) {
        match restore(&pack.system, self.method, step, Some(pack.memories.of_step(&mut pack.variable).1)) {
            Ok(None) => {}
            Ok(Some((correction, _))) => {
                let alone = self.controller.alone();
                for i in 0..LANES {
                    let [from, to] = [pack.state.lane(i), step.to.lane(i)];
                    if !tolerated(&alone, &correction.lane(i), &from, &to) {
                        step.to.q[0].put(i, &SingleLane::new(f64::NAN));
                    }
                }
            }
            Err(_) => step.to.q[0] = Lanes::splat(f64::NAN),
        }
    }

    /// Makes the steps of those lanes alone whose ends are not finite: up to a switch of their own, or until it is
    /// known what is wrong. (It takes copies: what is looked up by a lane's number is in memory, also in all steps
    /// where nothing is missing.)
    #[cold]
    #[inline(never)]
    pub fn make_alone(
        &self,
        pack: &mut PackOf<Sys, M, C, P, A, W::Accumulator, N>,
        step: &mut StepOf<Sys, M, P, A, N>,
        tried: [f64; LANES],
        finite: [bool; LANES],
    ) -> Made<<M as Method<Alone<Sys, P, A, N>, N>>::Interpolant> {
        let mut made = Made { which: [false; LANES], sizes: tried, own: vec![], failed: vec![] };
        for i in 0..LANES {
            let Some(Occupant { job, .. }) = &pack.occupants[i] else { continue };
            if finite[i] {
                continue;
            }
            match self.apart(pack, &job.system, i, tried[i]) {
                Ok((one, after)) => {
                    made.which[i] = true;
                    step.to.put(i, &one.to);
                    pack.memories.of_step(&mut pack.variable).1.put(i, &after);
                    step.error.put(i, &one.error);
                    step.h.put(i, &one.h);
                    if rules::ends_early(&one, SingleLane::new(tried[i])) {
                        made.sizes[i] = one.h.value();
                    }
                    let system = job.system.over(SingleLane::<P, A>::new);
                    made.own.push(Own::new(i, self.method, &system, &one, self.switching()));
                }
                Err(failure) => made.failed.push((i, failure)),
            }
        }
        made
    }
}

/// Accelerations of a lane alone.
struct Accelerate<'a, Sys: System<N>, const N: usize> {
    system: &'a Sys,
    at: State<Sys::Scalar, N>,
}

impl<Sys: System<N>, const N: usize> Work for Accelerate<'_, Sys, N> {
    type Output = SVector<Sys::Scalar, N>;

    #[inline(always)]
    fn run(self) -> Self::Output {
        self.system.accel(&self.at.q, &self.at.qd, self.at.t)
    }
}

/// Steps of the runs of a pack from where they are.
struct Together<'a, Convoy, Pack> {
    convoy: &'a Convoy,
    pack: &'a mut Pack,
    sizes: [f64; LANES],
}

impl<Sys, M, C, P, A, W, J, const N: usize> Work
    for Together<'_, Convoy<'_, Sys, M, C, P, A, W, J, N>, PackOf<Sys, M, C, P, A, W::Accumulator, N>>
where
    Sys: Rescale<N, Scalar = f64>,
    P: Policy,
    A: Processor,
    M: Clone,
    M: Method<Packed<Sys, P, A, N>, N, Error: Lanewise<LANES>, MethodState: Lanewise<LANES>>,
    M: Method<
            Alone<Sys, P, A, N>,
            N,
            Error = ElementOf<M, Sys, P, A, N>,
            MethodState = <MemoryOf<M, Sys, P, A, N> as Lanewise<LANES>>::Element,
        >,
    C: LaneController<LANES, P, A, ErrorOf<M, Sys, P, A, N>, N>,
    W: Observer<Sys, N>,
    J: Jobs<Sys, W::Output, N>,
{
    /// None where a lane cannot make its step.
    type Output = Option<StepOf<Sys, M, P, A, N>>;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn run(self) -> Self::Output {
        let Together { convoy, pack, sizes } = self;
        let (memory, next) = pack.memories.of_step(&mut pack.variable);
        let mut step =
            convoy.method.step_into(&pack.system, memory, &pack.state, Lanes::new(sizes), next).ok()?;
        convoy.restored(pack, &mut step);
        Some(step)
    }
}

impl<Sys, M, C, P, A, W, J, const N: usize> Work for Convoy<'_, Sys, M, C, P, A, W, J, N>
where
    Sys: Rescale<N, Scalar = f64>,
    P: Policy,
    A: Processor,
    M: Clone,
    M: Method<Packed<Sys, P, A, N>, N, Error: Lanewise<LANES>, MethodState: Lanewise<LANES>>,
    M: Method<
            Alone<Sys, P, A, N>,
            N,
            Error = ElementOf<M, Sys, P, A, N>,
            MethodState = <MemoryOf<M, Sys, P, A, N> as Lanewise<LANES>>::Element,
        >,
    C: LaneController<LANES, P, A, ErrorOf<M, Sys, P, A, N>, N>,
    W: Observer<Sys, N>,
    J: Jobs<Sys, W::Output, N>,
{
    type Output = ();

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn run(mut self) {
        let Some(first) = self.next() else { return };
        let (mut pack, mut searching) = (Pack::like(&first, false), Pack::like(&first, true));
        pack.enter(0, first);
        for lane in 1..LANES {
            let Some(entry) = self.next() else { break };
            pack.enter(lane, entry);
        }
        let mut looked = [vec![], vec![]];
        // (Not one loop for both: a choice among packs would keep all of their numbers in memory.)
        if !W::WITHIN {
            while pack.live.contains(&true) {
                self.round(&mut pack, &mut looked);
            }
            return;
        }
        loop {
            let live = pack.live.contains(&true);
            if self.landing.len() >= LANES || !live && !self.landing.is_empty() {
                self.land(&mut searching);
                continue;
            }
            let together = !self.waiting.is_empty() && (self.waiting.len() >= LANES || !live);
            if !together && !live {
                return;
            }
            if together {
                for (lane, entry) in
                    (0..LANES).zip(self.waiting.split_off(self.waiting.len().saturating_sub(LANES)))
                {
                    searching.enter(lane, entry);
                }
            }
            // (One call, so that the loop is compiled once.)
            self.round(if together { &mut searching } else { &mut pack }, &mut looked);
            if together {
                self.resumed.extend((0..LANES).filter_map(|lane| searching.take(lane)));
                for lane in 0..LANES {
                    if !pack.live[lane] && !self.resumed.is_empty() {
                        self.fill(&mut pack, lane);
                    }
                }
            }
        }
    }
}
