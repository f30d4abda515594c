//! The loop over lanes.

use super::course::{Apart, Course, Inside, Looked, Own, Which};
use super::job::{Alone, Bounds, ErrorOf, Jobs, LANES, MemoryOf, Packed};
use super::pack::{Entry, Occupant, Pace, Pack};
use crate::controller::{Controller, FirstStep, Verdicts};
use crate::event::landing::{Landing, Outlook, Progress};
use crate::event::outline::Outline;
use crate::failed::{Failed, Statistics};
use crate::failure::Failure;
use crate::integrate::engine::{Engine, restart_shorter, restore, tolerated};
use crate::integrate::integrate;
use crate::integrate::rules;
use crate::integrate::switches::{Approach, Interpolated, Passage, needs_impulse, not_held};
use crate::lanes::{
    LaneController, Lanes, Lanewise, Observer, Policy, Processor, Rescale, SingleLane, Work, disordered,
};
use crate::method::{Method, Step};
use crate::scalar::{Real, Scalar};
use crate::state::{State, Tangent};
use crate::system::System;

type EntryOf<Sys, M, C, P, A, T, const N: usize> =
    Entry<Sys, T, C, SingleLane<P, A>, <MemoryOf<M, Sys, P, A, N> as Lanewise<LANES>>::Element, N>;
type PackOf<Sys, M, C, P, A, T, const N: usize> = Pack<Sys, P, A, C, MemoryOf<M, Sys, P, A, N>, T, N>;
type StepOf<Sys, M, P, A, const N: usize> = Step<Packed<Sys, P, A, N>, M, N>;
type ElementOf<M, Sys, P, A, const N: usize> = <ErrorOf<M, Sys, P, A, N> as Lanewise<LANES>>::Element;

/// All that is to be done.
pub struct Convoy<'a, Sys, M, C, P, A, W, J, const N: usize>
where
    Sys: Rescale<N, Scalar = f64>,
    P: Policy,
    A: Processor,
    M: Method<Packed<Sys, P, A, N>, N, MethodState: Lanewise<LANES>>,
    W: Observer<Sys, N>,
{
    method: &'a M,
    controller: &'a C,
    end: f64,
    max_steps: Option<u64>,
    watch: &'a W,
    jobs: &'a mut J,
    /// Runs before a step in which there may be events, and those that have been through one and go on.
    waiting: Vec<EntryOf<Sys, M, C, P, A, W::Accumulator, N>>,
    resumed: Vec<EntryOf<Sys, M, C, P, A, W::Accumulator, N>>,
    /// Runs on their way to the event that their step has alone.
    landing: Vec<(EntryOf<Sys, M, C, P, A, W::Accumulator, N>, Approached<N>)>,
}

/// The step in which a run has one event alone, the way there, the cost of the run with that step, and the evaluations
/// on the way.
struct Approached<const N: usize> {
    outline: Outline<f64, N>,
    landing: Landing,
    cost: Statistics,
    evaluations: u64,
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

/// States or failures with which runs of lanes end, the first one of a lane.
type Ends<const N: usize> = Vec<(usize, Result<State<f64, N>, Failure>)>;

/// Steps that lanes had to make alone.
struct Made<D> {
    which: [bool; LANES],
    sizes: [f64; LANES],
    own: Vec<Own<D>>,
    failed: Vec<(usize, Failure)>,
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
    fn fixed(&self) -> bool {
        matches!(self.controller.alone().first_step(), FirstStep::Fixed(_))
    }

    /// Steps end at switches, by the rules of runs. (What follows a constant is not compiled where it is false.)
    #[inline(always)]
    fn switching(&self) -> bool {
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
    fn fill(&mut self, pack: &mut PackOf<Sys, M, C, P, A, W::Accumulator, N>, lane: usize) {
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
    fn fail(&mut self, pack: &mut PackOf<Sys, M, C, P, A, W::Accumulator, N>, lane: usize, failure: Failure) {
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
    fn shorten(&mut self, pack: &mut PackOf<Sys, M, C, P, A, W::Accumulator, N>) {
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

    /// The steps that are tried, and whether they land on the end; `None` if some lanes cannot try one, whose runs
    /// are over.
    #[inline(always)]
    fn aim(
        &mut self,
        pack: &mut PackOf<Sys, M, C, P, A, W::Accumulator, N>,
    ) -> Option<([f64; LANES], [bool; LANES])> {
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
        let (mut tried, mut lands) = (pack.paces.h, [false; LANES]);
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
        Some((tried, lands))
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
    fn refused(
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

    /// One step of all lanes, and what becomes of it.
    #[inline(always)]
    fn round(
        &mut self,
        pack: &mut PackOf<Sys, M, C, P, A, W::Accumulator, N>,
        looked: &mut [Looked<P, A, N>; 2],
    ) {
        let (method, end, fixed, switching) = (self.method, self.end, self.fixed(), self.switching());
        if const { !<Alone<Sys, P, A, N> as System<N>>::ATTITUDES.is_empty() } {
            self.shorten(pack);
        }
        let Some((mut tried, mut lands)) = self.aim(pack) else { return };
        let before = pack.paces.h;
        // For lanes that make this step again, to look for events in it.
        let again_from = (W::WITHIN && !pack.searches).then(|| (pack.paces, pack.controllers.clone()));
        let (memory, next) = pack.memories.of_step(&mut pack.variable);
        let mut attempted = method.step(&pack.system, memory, &pack.state, Lanes::new(tried), next);
        // It stays where it is: steps are large.
        let Ok(step) = &mut attempted else { return self.none_made(pack, &tried) };
        pack.evaluations += u64::from(step.evaluations);
        self.restored(pack, step);

        // What becomes of it, lane by lane.
        let mut sum = Lanes::<LANES, P, A>::zero();
        for i in 0..N {
            sum += step.to.q[i] + step.to.qd[i];
        }
        let (mut finite, mut missing) = ([false; LANES], false);
        for i in 0..LANES {
            finite[i] = sum.as_array()[i] * 0.0 == 0.0;
            missing |= pack.live[i] & !finite[i];
        }
        let (mut own, mut failed, mut early) = (vec![], vec![], [false; LANES]);
        if missing {
            let made = self.make_alone(pack, step, tried, finite);
            for i in 0..LANES {
                finite[i] |= made.which[i];
                early[i] = made.sizes[i] != tried[i];
                lands[i] &= !early[i];
                tried[i] = made.sizes[i];
            }
            (own, failed) = (made.own, made.failed);
        }
        let measures = self.controller.measures(&pack.state, &step.to, &step.error);
        let order = <M as Method<Packed<Sys, P, A, N>, N>>::order(method);
        let Verdicts { accepted: mut good, mut factor } =
            C::decide(&mut pack.controllers, &measures, &finite, order);
        // A method may have changed the size of its step, so that it is the difference of its times.
        let sizes = *step.h.as_array();
        // Runs that end within the step, or because of it. (A list, since arrays of them are written in each step.)
        let mut ends: Ends<N> = vec![];
        // Lanes on their way to a switch, and those that try a shorter step to it although the controller accepts
        // this one.
        let (mut near, mut again) = ([false; LANES], [false; LANES]);
        if const { <Packed<Sys, P, A, N> as System<N>>::SWITCHES > 0 } && switching {
            let memory = pack.memories.now();
            let mut course = Course::<Sys, M, P, A, N>::new(method, &pack.system, memory, step, &own, looked);
            for i in 0..LANES {
                let Some(Occupant { job, .. }) = &pack.occupants[i] else { continue };
                let approach = &mut pack.paces.approach[i];
                near[i] = approach.is_near();
                if !finite[i] {
                    continue;
                }
                let system = job.system.over(SingleLane::<P, A>::new);
                let mut ends_of = [pack.state.lane(i), step.to.lane(i)];
                if lands[i] {
                    ends_of[1].t = SingleLane::new(end);
                }
                let alone = pack.controllers[i].alone();
                let norm = |difference: &_, a: &_, b: &_| {
                    Controller::<_, N, ElementOf<M, Sys, P, A, N>>::norm(&alone, difference, a, b)
                };
                let (course, size) = (&mut course, SingleLane::new(sizes[i]));
                let within = move || {
                    let course = course;
                    let (which, parts) = (course.look(Which::Coarse), course.parts(i));
                    let course = &*course;
                    let between = move |x: f64| course.between(which, i, x);
                    Interpolated { ends: ends_of, h: size, parts, between }
                };
                let judged = (good[i], factor[i]);
                match rules::across(approach, &system, [&ends_of[0], &ends_of[1]], judged, within, norm) {
                    Ok(Passage::Free) if good[i] => near[i] &= approach.is_near(),
                    Ok(Passage::Free) => *approach = Approach::NONE,
                    Ok(Passage::Again) => (again[i], good[i]) = (good[i], false),
                    // (These numbers have no slopes.)
                    Ok(Passage::Across { .. }) => (good[i], factor[i]) = (true, 1.0),
                    Err(failure) => {
                        ends.push((i, Err(failure.map(SingleLane::value))));
                        good[i] = false;
                        // Of a run that ends here no step was rejected.
                        pack.paces.rejected[i] = pack.paces.rejected[i].wrapping_sub(1);
                    }
                }
            }
        }
        // Time, and the next step. One loop over numbers, which the optimiser makes vectors of; it takes several
        // apart into single flags.
        let (mut accepted, mut arrived) = ([false; LANES], [false; LANES]);
        let mut any = false;
        let (to, paces) = (step.to.t.as_mut(), &mut pack.paces);
        if fixed {
            for i in 0..LANES {
                accepted[i] = pack.live[i] & finite[i];
                let (count, total) = (paces.count[i], paces.total[i]);
                let [h, origin, end] = [paces.h[i], paces.origin[i], end].map(SingleLane::<P, A>::new);
                to[i] = rules::next_time(count, total, h, origin, Some(end)).value();
                paces.count[i] = count + 1.0;
                arrived[i] = accepted[i] & (paces.count[i] >= total);
                any |= arrived[i];
            }
            // A step that ends at a switch is followed by what is left of it.
            if missing || pack.interrupted {
                (paces.stopped, pack.interrupted) = (early, early.contains(&true));
                for own in own.iter().filter(|own| early[own.lane]) {
                    paces.count[own.lane] -= 1.0;
                    paces.accepted[own.lane] += 1;
                    (to[own.lane], arrived[own.lane]) = (own.t, false);
                }
                any = arrived.contains(&true);
            }
            if const { <Packed<Sys, P, A, N> as System<N>>::HOLDS }
                && !<M as Method<Packed<Sys, P, A, N>, N>>::ends_at_switches(method)
            {
                for i in 0..LANES {
                    let Some(Occupant { job, .. }) = &pack.occupants[i] else { continue };
                    if !accepted[i] {
                        continue;
                    }
                    let system = job.system.over(SingleLane::<P, A>::new);
                    let (from, to) = (pack.state.lane(i), step.to.lane(i));
                    let h = SingleLane::new(tried[i]);
                    if let Err(failure) = not_held(&system, [&from, &to], h, paces.count[i] as u64 - 1) {
                        ends.push((i, Err(failure.map(SingleLane::value))));
                        (accepted[i], arrived[i]) = (false, false);
                        paces.count[i] -= 1.0;
                    }
                }
            }
        } else {
            for i in 0..LANES {
                let good = pack.live[i] & finite[i] & good[i];
                let at = if lands[i] { end } else { to[i] };
                let next =
                    rules::next_step(paces.h[i], tried[i], factor[i], good, lands[i] | early[i] | near[i]);
                paces.h[i] = if pack.live[i] { next } else { 0.0 };
                to[i] = at;
                let size = if good { sizes[i].abs() } else { 0.0 };
                paces.longest[i] = if size > paces.longest[i] { size } else { paces.longest[i] };
                paces.accepted[i] += u64::from(good);
                paces.rejected[i] += u64::from(finite[i] & !good);
                accepted[i] = good;
                arrived[i] = good & (at == end);
                any |= good & (at == end);
            }
            if switching {
                for i in 0..LANES {
                    paces.h[i] = if again[i] { before[i] } else { paces.h[i] };
                }
            }
        }
        if pack.caused {
            for i in 0..LANES {
                paces.cause[i] = if finite[i] { None } else { paces.cause[i] };
            }
        }
        for (i, failure) in failed {
            pack.paces.evaluations[i] = pack.paces.evaluations[i].wrapping_add(u64::from(step.evaluations));
            match self.refused(pack, i, tried[i], before[i], failure) {
                Ok(next) => pack.paces.h[i] = next,
                Err(failure) => ends.push((i, Err(failure))),
            }
        }

        // Lanes in whose steps events may be wait until there are as many as lanes, and the others go on.
        let (mut aside, mut landings) = ([false; LANES], vec![]);
        let mut looks = accepted;
        if W::WITHIN && !pack.searches {
            let ends = <M as Method<Packed<Sys, P, A, N>, N>>::end_accelerations(method, step);
            if let Some(accelerations) = ends {
                for i in 0..LANES {
                    let Some(Occupant { job, watched }) = &mut pack.occupants[i] else { continue };
                    if !accepted[i] {
                        continue;
                    }
                    // (No `map` of arrays, which is a call.)
                    let [from, to] = &accelerations;
                    let outline = Outline {
                        ends: [
                            pack.state.lane(i).map(SingleLane::value),
                            step.to.lane(i).map(SingleLane::value),
                        ],
                        accelerations: [from.map(|x| x.as_array()[i]), to.map(|x| x.as_array()[i])],
                        h: sizes[i],
                    };
                    // (A step that was made alone has left no accelerations here.)
                    let outlook = match own.iter().any(|own| own.lane == i) {
                        true => Outlook::Unclear,
                        false => self.watch.outlook(watched, &job.system, &outline),
                    };
                    let lands = const { <Packed<Sys, P, A, N> as System<N>>::SWITCHES == 0 }
                        && self.watch.wanted(watched).is_none();
                    aside[i] = outlook != Outlook::Clear;
                    if let Outlook::Crossing(landing) = outlook
                        && lands
                    {
                        let (cost, evaluations) = (pack.statistics(i), 0);
                        landings.push((i, Approached { outline, landing, cost, evaluations }));
                    }
                    accepted[i] &= !aside[i];
                    arrived[i] &= !aside[i];
                    any |= aside[i];
                }
                looks = [false; LANES];
            }
        }

        // What is wanted of it.
        let memory = pack.memories.now();
        let mut course = Course::<Sys, M, P, A, N>::new(method, &pack.system, memory, step, &own, looked);
        if W::WITHIN {
            if looks.contains(&true) {
                course.look(Which::Dense);
            }
            for i in 0..LANES {
                if looks[i]
                    && let Some(Occupant { job, watched }) = &mut pack.occupants[i]
                {
                    let stepped = |x: f64| {
                        let made = A::call(Apart {
                            method,
                            controller: self.controller.alone(),
                            system: job.system.over(SingleLane::<P, A>::new),
                            memory: memory.lane(i),
                            from: pack.state.lane(i),
                            h: SingleLane::new(sizes[i]) * SingleLane::new(x),
                        });
                        made.map(|(one, _)| one.to.map(SingleLane::value))
                            .map_err(|failure| failure.map(SingleLane::value))
                    };
                    let inside = Inside {
                        ends: [pack.state.lane(i), step.to.lane(i)].map(|at| at.map(SingleLane::value)),
                        h: sizes[i],
                        parts: course.parts(i),
                        between: &|x| course.between(Which::Dense, i, x).map(SingleLane::value),
                        stepped: &stepped,
                    };
                    let end = self.watch.within(watched, &job.system, &inside).transpose();
                    ends.extend(end.map(|end| (i, end)));
                }
            }
        }
        if const { <Packed<Sys, P, A, N> as System<N>>::IMPULSES > 0 } {
            for i in 0..LANES {
                let Some(Occupant { job, .. }) = &pack.occupants[i] else { continue };
                let ended = ends.iter().any(|(of, _)| *of == i);
                let (from, to) = (pack.state.lane(i), step.to.lane(i));
                let system = job.system.over(SingleLane::<P, A>::new);
                if accepted[i] && !ended && needs_impulse(&system, &from, &to) {
                    ends.push((i, Err(Failure::UnknownImpulse { t: to.t.value() })));
                }
            }
        }
        // The last state of a lane's step.
        let last = |ends: &Ends<N>, lane: usize| match ends.iter().find(|(of, _)| *of == lane) {
            Some((_, Ok(end))) => *end,
            _ => step.to.lane(lane).map(SingleLane::value),
        };
        let mut until = *step.to.t.as_array();
        for (i, end) in &ends {
            until[*i] = end.as_ref().map_or(until[*i], |end| end.t);
            any = true;
        }
        if W::STEPS {
            for i in 0..LANES {
                if accepted[i]
                    && let Some(Occupant { job, watched }) = &mut pack.occupants[i]
                {
                    let from = pack.state.lane(i).map(SingleLane::value);
                    self.watch.step(watched, &job.system, &from, &last(&ends, i));
                }
            }
        }
        loop {
            let (mut times, mut wanted) = (step.to.t, [false; LANES]);
            for i in 0..LANES {
                if accepted[i]
                    && let Some(Occupant { watched, .. }) = &pack.occupants[i]
                    && let Some(time) = self.watch.wanted(watched)
                {
                    let ahead = if tried[i] < 0.0 { until[i] - time } else { time - until[i] };
                    if ahead <= 0.0 {
                        (times.as_mut()[i], wanted[i]) = (time, true);
                    }
                }
            }
            if !wanted.contains(&true) {
                break;
            }
            let which = course.make(Which::Dense);
            let between = course.at(which, times);
            for i in 0..LANES {
                if wanted[i]
                    && let Some(Occupant { job, watched }) = &mut pack.occupants[i]
                {
                    let time = times.as_array()[i];
                    let at = match (course.own(i), &between) {
                        _ if time == until[i] => None,
                        (Some(own), _) => course.own_at(own, which, time),
                        (None, between) => between.as_ref().map(|at| at.lane(i)),
                    };
                    let at = at.map_or_else(|| last(&ends, i), |at| at.map(SingleLane::value));
                    self.watch.sample(watched, &job.system, &at);
                    if let Some(failure) = disordered(at.t, tried[i], self.watch.wanted(watched)) {
                        ends.insert(0, (i, Err(failure)));
                        (accepted[i], any) = (false, true);
                    }
                }
            }
        }

        pack.state.take(&accepted, &step.to);
        pack.memories.turn_lanes(&accepted, &pack.variable);
        if any {
            for i in 0..LANES {
                if let Some((paces, controllers)) = again_from.as_ref().filter(|_| aside[i]) {
                    let once = (1, u64::from(step.evaluations));
                    pack.restore(i, paces, controllers[i].clone(), once);
                    match landings.iter().position(|(lane, _)| *lane == i) {
                        Some(at) => {
                            let (_, approached) = landings.swap_remove(at);
                            self.landing.extend(pack.take(i).map(|entry| (entry, approached)));
                        }
                        None => self.waiting.extend(pack.take(i)),
                    }
                    self.fill(pack, i);
                    continue;
                }
                let end = ends.iter().find(|(of, _)| *of == i).map(|(_, end)| *end);
                if let Some(Err(failure)) = end {
                    self.fail(pack, i, failure);
                } else if arrived[i] || end.is_some() {
                    if let Some(Occupant { job, watched }) = pack.occupants[i].take() {
                        let output = self.watch.finish(watched, &job.system, &last(&ends, i));
                        self.jobs.done(job.index, pack.statistics(i), Ok(output));
                    }
                    self.fill(pack, i);
                }
            }
        }
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
                        let tolerates = |error: &Tangent<f64, N>| {
                            let error = Tangent {
                                q: error.q.map(SingleLane::new),
                                qd: error.qd.map(SingleLane::new),
                            };
                            !self.fixed() && self.controller.alone().norm(&error, &ends[0], &ends[1]) <= 1.0
                        };
                        self.watch.approach(watched, &job.system, outline, landing, reached, &tolerates)
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

    /// Looks for the reasons why lanes cannot make their steps: the same step of each lane alone tells.
    #[cold]
    #[inline(never)]
    fn none_made(&mut self, pack: &mut PackOf<Sys, M, C, P, A, W::Accumulator, N>, tried: &[f64; LANES]) {
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
    fn restored(
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
    fn make_alone(
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
        let mut step = convoy.method.step(&pack.system, memory, &pack.state, Lanes::new(sizes), next).ok()?;
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
