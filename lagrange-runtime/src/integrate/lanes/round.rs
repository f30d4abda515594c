//! One step of all lanes, and what becomes of it.

use super::convoy::{Approached, Convoy, ElementOf, Made, PackOf, StepOf};
use super::course::{Apart, Course, Inside, Looked, Own, Which};
use super::job::{Alone, ErrorOf, Jobs, LANES, MemoryOf, Packed};
use super::pack::{Occupant, Paces};
use crate::controller::{Controller, Verdicts};
use crate::event::landing::{Outlook, Progress};
use crate::event::outline::Outline;
use crate::failure::Failure;
use crate::integrate::rules;
use crate::integrate::switches::{Approach, Interpolated, Passage, needs_impulse, not_held};
use crate::lanes::{
    LaneController, Lanes, Lanewise, Observer, Policy, Processor, Rescale, SingleLane, disordered,
};
use crate::method::Method;
use crate::scalar::Scalar;
use crate::state::State;
use crate::system::System;

/// The interpolant of a lane alone.
type Alones<M, Sys, P, A, const N: usize> = <M as Method<Alone<Sys, P, A, N>, N>>::Interpolant;

/// States or failures with which runs of lanes end, the first one of a lane. (A list, since arrays of them are written
/// in each step.)
struct Ends<const N: usize>(Vec<(usize, Result<State<f64, N>, Failure>)>);

impl<const N: usize> Ends<N> {
    fn of(&self, lane: usize) -> Option<Result<State<f64, N>, Failure>> {
        self.0.iter().find(|(of, _)| *of == lane).map(|(_, end)| *end)
    }

    /// The last state of a lane's step, which leads to `to`.
    fn last<P: Policy, A: Processor>(&self, lane: usize, to: &State<Lanes<LANES, P, A>, N>) -> State<f64, N> {
        match self.of(lane) {
            Some(Ok(end)) => end,
            _ => to.lane(lane).map(SingleLane::value),
        }
    }
}

/// The steps of the lanes: what was tried, and what became of it. (Each stage of a round is compiled into it, so that
/// these are numbers in registers. What looks up one of them by a lane's number in a call takes copies.)
struct Fates {
    /// Sizes that were tried; of steps that ended at a switch of theirs, the sizes that they have.
    tried: [f64; LANES],
    /// Steps that land on the end of the run, aim at an event, end earlier, and have an end at all.
    lands: [bool; LANES],
    aims: [bool; LANES],
    early: [bool; LANES],
    finite: [bool; LANES],
    /// Steps that the controller accepts, and the next steps over these.
    good: [bool; LANES],
    factor: [f64; LANES],
    /// Lanes on their way to a switch, and those that try a shorter step to it although the controller accepts
    /// this one.
    near: [bool; LANES],
    again: [bool; LANES],
    /// Steps that lead on, and those that lead to the end of the run.
    accepted: [bool; LANES],
    arrived: [bool; LANES],
    /// Some lanes made their steps alone, or could not.
    missing: bool,
    /// Some runs may end, or are taken out of their lanes.
    any: bool,
}

/// Lanes that make their step again to look for events in it, those of them that aim at the only one, and those that
/// look for events in this step.
struct Outlooks<const N: usize> {
    aside: [bool; LANES],
    landings: Vec<(usize, Approached<N>)>,
    looks: [bool; LANES],
}

impl<Sys, M, C, P, A, W, J, const N: usize> Convoy<'_, Sys, M, C, P, A, W, J, N>
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
    /// One step of all lanes, and what becomes of it.
    #[inline(always)]
    pub fn round(
        &mut self,
        pack: &mut PackOf<Sys, M, C, P, A, W::Accumulator, N>,
        looked: &mut [Looked<P, A, N>; 2],
    ) {
        if const { !<Alone<Sys, P, A, N> as System<N>>::ATTITUDES.is_empty() } {
            self.shorten(pack);
        }
        let Some((tried, lands, aims)) = self.aim(pack) else { return };
        let before = pack.paces.h;
        // For lanes that make this step again, to look for events in it.
        let again_from = (W::WITHIN && !pack.searches).then(|| (pack.paces, pack.controllers.clone()));
        let (memory, next) = pack.memories.of_step(&mut pack.variable);
        let mut attempted = self.method.step_into(&pack.system, memory, &pack.state, Lanes::new(tried), next);
        // It stays where it is: steps are large.
        let Ok(step) = &mut attempted else { return self.none_made(pack, &tried) };
        pack.evaluations += u64::from(step.evaluations);
        self.restored(pack, step);

        let (mut fates, own, failed) = self.judged(pack, step, tried, (lands, aims));
        let mut ends = Ends(vec![]);
        if self.switching() {
            self.switched(pack, step, &own, looked, &mut fates, &mut ends);
        }
        if self.fixed() {
            self.advanced_equally(pack, step, &own, &mut fates, &mut ends);
        } else {
            self.advanced(pack, step, &before, &mut fates);
        }
        if pack.caused {
            for i in 0..LANES {
                pack.paces.cause[i] = if fates.finite[i] { None } else { pack.paces.cause[i] };
            }
        }
        for (i, failure) in failed {
            pack.paces.evaluations[i] = pack.paces.evaluations[i].wrapping_add(u64::from(step.evaluations));
            match self.refused(pack, i, fates.tried[i], before[i], failure) {
                Ok(next) => pack.paces.h[i] = next,
                Err(failure) => ends.0.push((i, Err(failure))),
            }
        }
        let mut outlooks = Outlooks { aside: [false; LANES], landings: vec![], looks: fates.accepted };
        if W::WITHIN && !pack.searches {
            self.outlooks(pack, step, &own, &mut fates, &mut ends, &mut outlooks);
        }
        self.observed(pack, step, &own, looked, &outlooks.looks, &mut fates, &mut ends);

        pack.state.take(&fates.accepted, &step.to);
        pack.memories.turn_lanes(&fates.accepted, &pack.variable);
        if fates.any {
            self.settled(pack, step, again_from, &fates, &ends, &mut outlooks);
        }
    }

    /// Verdicts of the controller on steps. Lanes without an end make theirs alone.
    #[expect(clippy::type_complexity)]
    #[inline(always)]
    fn judged(
        &self,
        pack: &mut PackOf<Sys, M, C, P, A, W::Accumulator, N>,
        step: &mut StepOf<Sys, M, P, A, N>,
        mut tried: [f64; LANES],
        (mut lands, aims): ([bool; LANES], [bool; LANES]),
    ) -> (Fates, Vec<Own<Alones<M, Sys, P, A, N>>>, Vec<(usize, Failure)>) {
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
            let made: Made<Alones<M, Sys, P, A, N>> = self.make_alone(pack, step, tried, finite);
            for i in 0..LANES {
                finite[i] |= made.which[i];
                early[i] = made.sizes[i] != tried[i];
                lands[i] &= !early[i];
                tried[i] = made.sizes[i];
            }
            (own, failed) = (made.own, made.failed);
        }
        let measures = self.controller.measures(&pack.state, &step.to, &step.error);
        let order = <M as Method<Packed<Sys, P, A, N>, N>>::order(self.method);
        let Verdicts { accepted: good, factor } = C::decide(&mut pack.controllers, &measures, &finite, order);
        let none = [false; LANES];
        let (near, again, accepted, arrived, any) = (none, none, none, none, false);
        let fates = Fates {
            tried,
            lands,
            aims,
            early,
            finite,
            good,
            factor,
            near,
            again,
            accepted,
            arrived,
            missing,
            any,
        };
        (fates, own, failed)
    }

    /// Switches in adaptive steps, by the rules of runs.
    #[inline(always)]
    fn switched(
        &self,
        pack: &mut PackOf<Sys, M, C, P, A, W::Accumulator, N>,
        step: &StepOf<Sys, M, P, A, N>,
        own: &[Own<Alones<M, Sys, P, A, N>>],
        looked: &mut [Looked<P, A, N>; 2],
        fates: &mut Fates,
        ends: &mut Ends<N>,
    ) {
        let memory = pack.memories.now();
        let mut course = Course::<Sys, M, P, A, N>::new(self.method, &pack.system, memory, step, own, looked);
        for i in 0..LANES {
            let Some(Occupant { job, .. }) = &pack.occupants[i] else { continue };
            let approach = &mut pack.paces.approach[i];
            fates.near[i] = approach.is_near();
            if !fates.finite[i] {
                continue;
            }
            let system = job.system.over(SingleLane::<P, A>::new);
            let mut ends_of = [pack.state.lane(i), step.to.lane(i)];
            if fates.lands[i] {
                ends_of[1].t = SingleLane::new(self.end);
            }
            let alone = pack.controllers[i].alone();
            let norm = |difference: &_, a: &_, b: &_| {
                Controller::<_, N, ElementOf<M, Sys, P, A, N>>::norm(&alone, difference, a, b)
            };
            let (course, size) = (&mut course, SingleLane::new(step.h.as_array()[i]));
            let within = move || {
                let course = course;
                let (which, parts) = (course.look(Which::Coarse), course.parts(i));
                let course = &*course;
                let between = move |x: f64| course.between(which, i, x);
                Interpolated { ends: ends_of, h: size, parts, between }
            };
            let verdict = (fates.good[i], fates.factor[i]);
            match rules::across(approach, &system, [&ends_of[0], &ends_of[1]], verdict, within, norm) {
                Ok(Passage::Free) if fates.good[i] => fates.near[i] &= approach.is_near(),
                Ok(Passage::Free) => *approach = Approach::NONE,
                Ok(Passage::Again) => (fates.again[i], fates.good[i]) = (fates.good[i], false),
                // (These numbers have no slopes.)
                Ok(Passage::Across { .. }) => (fates.good[i], fates.factor[i]) = (true, 1.0),
                Err(failure) => {
                    ends.0.push((i, Err(failure.map(SingleLane::value))));
                    fates.good[i] = false;
                    // No step of a run that ends here was rejected.
                    pack.paces.rejected[i] = pack.paces.rejected[i].wrapping_sub(1);
                }
            }
        }
    }

    /// Times of adaptive steps, and the next ones. (One loop over numbers, which the optimiser makes vectors of; it
    /// takes several apart into single flags.)
    #[inline(always)]
    fn advanced(
        &self,
        pack: &mut PackOf<Sys, M, C, P, A, W::Accumulator, N>,
        step: &mut StepOf<Sys, M, P, A, N>,
        before: &[f64; LANES],
        fates: &mut Fates,
    ) {
        let (end, to, paces) = (self.end, step.to.t.as_mut(), &mut pack.paces);
        for i in 0..LANES {
            let good = pack.live[i] & fates.finite[i] & fates.good[i];
            let at = if fates.lands[i] { end } else { to[i] };
            let short = fates.lands[i] | fates.aims[i] | fates.early[i] | fates.near[i];
            let next = rules::next_step(paces.h[i], fates.tried[i], fates.factor[i], good, short);
            paces.h[i] = if pack.live[i] { next } else { 0.0 };
            to[i] = at;
            let size = if good { step.h.as_array()[i].abs() } else { 0.0 };
            paces.longest[i] = if size > paces.longest[i] { size } else { paces.longest[i] };
            paces.accepted[i] += u64::from(good);
            paces.rejected[i] += u64::from(fates.finite[i] & !good);
            fates.accepted[i] = good;
            fates.arrived[i] = good & (at == end);
            fates.any |= good & (at == end);
        }
        if self.switching() {
            for i in 0..LANES {
                paces.h[i] = if fates.again[i] { before[i] } else { paces.h[i] };
            }
        }
    }

    /// Times of equal steps.
    #[inline(always)]
    fn advanced_equally(
        &self,
        pack: &mut PackOf<Sys, M, C, P, A, W::Accumulator, N>,
        step: &mut StepOf<Sys, M, P, A, N>,
        own: &[Own<Alones<M, Sys, P, A, N>>],
        fates: &mut Fates,
        ends: &mut Ends<N>,
    ) {
        let (to, paces) = (step.to.t.as_mut(), &mut pack.paces);
        // (As they are in memory: what has just been written flag by flag is waited for when it is read as a whole.)
        fates.accepted = pack.live;
        if fates.missing {
            for i in 0..LANES {
                fates.accepted[i] &= fates.finite[i];
            }
        }
        for i in 0..LANES {
            let (count, total) = (paces.count[i], paces.total[i]);
            let [h, origin, end] = [paces.h[i], paces.origin[i], self.end].map(SingleLane::<P, A>::new);
            to[i] = rules::next_time(count, total, h, origin, Some(end)).value();
            paces.count[i] = count + 1.0;
            fates.arrived[i] = fates.accepted[i] & (paces.count[i] >= total);
            fates.any |= fates.arrived[i];
        }
        // A step that ends at a switch is followed by what is left of it.
        if fates.missing || pack.interrupted {
            (paces.stopped, pack.interrupted) = (fates.early, fates.early.contains(&true));
            for own in own.iter().filter(|own| fates.early[own.lane]) {
                paces.count[own.lane] -= 1.0;
                paces.accepted[own.lane] += 1;
                (to[own.lane], fates.arrived[own.lane]) = (own.t, false);
            }
            fates.any = fates.arrived.contains(&true);
        }
        if const { !<Packed<Sys, P, A, N> as System<N>>::HOLDS }
            || <M as Method<Packed<Sys, P, A, N>, N>>::ends_at_switches(self.method)
        {
            return;
        }
        for i in 0..LANES {
            let Some(Occupant { job, .. }) = &pack.occupants[i] else { continue };
            if !fates.accepted[i] {
                continue;
            }
            let system = job.system.over(SingleLane::<P, A>::new);
            let (from, to) = (pack.state.lane(i), step.to.lane(i));
            let (h, paces) = (SingleLane::new(fates.tried[i]), &mut pack.paces);
            if let Err(failure) = not_held(&system, [&from, &to], h, paces.count[i] as u64 - 1) {
                ends.0.push((i, Err(failure.map(SingleLane::value))));
                (fates.accepted[i], fates.arrived[i]) = (false, false);
                paces.count[i] -= 1.0;
            }
        }
    }

    /// Lanes in whose steps events may be wait until there are as many as lanes, and the others go on.
    #[inline(always)]
    fn outlooks(
        &self,
        pack: &mut PackOf<Sys, M, C, P, A, W::Accumulator, N>,
        step: &StepOf<Sys, M, P, A, N>,
        own: &[Own<Alones<M, Sys, P, A, N>>],
        fates: &mut Fates,
        ends: &mut Ends<N>,
        outlooks: &mut Outlooks<N>,
    ) {
        let accelerations = <M as Method<Packed<Sys, P, A, N>, N>>::end_accelerations(self.method, step);
        let Some(accelerations) = accelerations else { return };
        for i in 0..LANES {
            let Some(Occupant { job, watched }) = &mut pack.occupants[i] else { continue };
            if !fates.accepted[i] {
                continue;
            }
            // (No `map` of arrays, which is a call.)
            let [from, to] = &accelerations;
            let outline = Outline {
                ends: [pack.state.lane(i).map(SingleLane::value), step.to.lane(i).map(SingleLane::value)],
                accelerations: [from.map(|x| x.as_array()[i]), to.map(|x| x.as_array()[i])],
                h: step.h.as_array()[i],
            };
            // (A step that was made alone has left no accelerations here.)
            let outlook = match own.iter().any(|own| own.lane == i) {
                true => Outlook::Unclear,
                false => self.watch.outlook(watched, &job.system, &outline, pack.paces.h[i]),
            };
            pack.paces.aim[i] = f64::INFINITY;
            let lands = const { <Packed<Sys, P, A, N> as System<N>>::SWITCHES == 0 }
                && self.watch.wanted(watched).is_none();
            match outlook {
                Outlook::Clear { aim } => {
                    pack.paces.aim[i] = aim;
                    continue;
                }
                Outlook::Crossing(landing) if lands => {
                    let aims = const { rules::aims::<Packed<Sys, P, A, N>, N>() } && !self.fixed();
                    let mut evaluations = 0;
                    if let Some(mut landing) = landing.at_end().filter(|_| aims) {
                        let alone = outline.ends.map(|at| at.map(SingleLane::new));
                        let judge = self.judge(&job.system, &alone);
                        let (watch, system) = (self.watch, &job.system);
                        let progress =
                            watch.approach(watched, system, &outline, &mut landing, &outline, &judge);
                        evaluations = 1;
                        if let Progress::Landed(state) = progress {
                            // (Those of the pack less those of the lane.)
                            pack.paces.evaluations[i] = pack.paces.evaluations[i].wrapping_sub(evaluations);
                            ends.0.push((i, Ok(state)));
                            continue;
                        }
                    }
                    let cost = pack.statistics(i);
                    outlooks.landings.push((i, Approached { outline, landing, cost, evaluations }));
                }
                _ => {}
            }
            outlooks.aside[i] = true;
            (fates.accepted[i], fates.arrived[i], fates.any) = (false, false, true);
        }
        outlooks.looks = [false; LANES];
    }

    /// Events within steps, impulses, steps and samples, as the observer wants them.
    #[expect(clippy::too_many_arguments)]
    #[inline(always)]
    fn observed(
        &self,
        pack: &mut PackOf<Sys, M, C, P, A, W::Accumulator, N>,
        step: &StepOf<Sys, M, P, A, N>,
        own: &[Own<Alones<M, Sys, P, A, N>>],
        looked: &mut [Looked<P, A, N>; 2],
        looks: &[bool; LANES],
        fates: &mut Fates,
        ends: &mut Ends<N>,
    ) {
        let memory = pack.memories.now();
        let mut course = Course::<Sys, M, P, A, N>::new(self.method, &pack.system, memory, step, own, looked);
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
                            method: self.method,
                            controller: self.controller.alone(),
                            system: job.system.over(SingleLane::<P, A>::new),
                            memory: memory.lane(i),
                            from: pack.state.lane(i),
                            h: SingleLane::new(step.h.as_array()[i]) * SingleLane::new(x),
                        });
                        made.map(|(one, _)| one.to.map(SingleLane::value))
                            .map_err(|failure| failure.map(SingleLane::value))
                    };
                    let inside = Inside {
                        ends: [pack.state.lane(i), step.to.lane(i)].map(|at| at.map(SingleLane::value)),
                        h: step.h.as_array()[i],
                        parts: course.parts(i),
                        between: &|x| course.between(Which::Dense, i, x).map(SingleLane::value),
                        stepped: &stepped,
                    };
                    let end = self.watch.within(watched, &job.system, &inside).transpose();
                    pack.paces.aim[i] = f64::INFINITY;
                    ends.0.extend(end.map(|end| (i, end)));
                }
            }
        }
        if const { <Packed<Sys, P, A, N> as System<N>>::IMPULSES > 0 } {
            for i in 0..LANES {
                let Some(Occupant { job, .. }) = &pack.occupants[i] else { continue };
                let (from, to) = (pack.state.lane(i), step.to.lane(i));
                let system = job.system.over(SingleLane::<P, A>::new);
                if fates.accepted[i] && ends.of(i).is_none() && needs_impulse(&system, &from, &to) {
                    ends.0.push((i, Err(Failure::UnknownImpulse { t: to.t.value() })));
                }
            }
        }
        fates.any |= !ends.0.is_empty();
        // (Asked for each lane: arrays that are copied after a lane of them was written wait for it.)
        let until = |ends: &Ends<N>, lane: usize| match ends.of(lane) {
            Some(Ok(end)) => end.t,
            _ => step.to.t.as_array()[lane],
        };
        if W::STEPS {
            for i in 0..LANES {
                if fates.accepted[i]
                    && let Some(Occupant { job, watched }) = &mut pack.occupants[i]
                {
                    let from = pack.state.lane(i).map(SingleLane::value);
                    self.watch.step(watched, &job.system, &from, &ends.last(i, &step.to));
                }
            }
        }
        loop {
            let (mut times, mut wanted) = (step.to.t, [false; LANES]);
            for i in 0..LANES {
                if fates.accepted[i]
                    && let Some(Occupant { watched, .. }) = &pack.occupants[i]
                    && let Some(time) = self.watch.wanted(watched)
                {
                    let until = until(ends, i);
                    let ahead = if fates.tried[i] < 0.0 { until - time } else { time - until };
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
                        _ if time == until(ends, i) => None,
                        (Some(own), _) => course.own_at(own, which, time),
                        (None, between) => between.as_ref().map(|at| at.lane(i)),
                    };
                    let at = at.map_or_else(|| ends.last(i, &step.to), |at| at.map(SingleLane::value));
                    self.watch.sample(watched, &job.system, &at);
                    if let Some(failure) = disordered(at.t, fates.tried[i], self.watch.wanted(watched)) {
                        ends.0.insert(0, (i, Err(failure)));
                        (fates.accepted[i], fates.any) = (false, true);
                    }
                }
            }
        }
    }

    /// Runs that end, and those that leave their lanes to look for events.
    #[inline(always)]
    fn settled(
        &mut self,
        pack: &mut PackOf<Sys, M, C, P, A, W::Accumulator, N>,
        step: &StepOf<Sys, M, P, A, N>,
        again_from: Option<(Paces, [C; LANES])>,
        fates: &Fates,
        ends: &Ends<N>,
        outlooks: &mut Outlooks<N>,
    ) {
        for i in 0..LANES {
            if let Some((paces, controllers)) = again_from.as_ref().filter(|_| outlooks.aside[i]) {
                let once = (1, u64::from(step.evaluations));
                pack.restore(i, paces, controllers[i].clone(), once);
                match outlooks.landings.iter().position(|(lane, _)| *lane == i) {
                    Some(at) => {
                        let (_, approached) = outlooks.landings.swap_remove(at);
                        self.landing.extend(pack.take(i).map(|entry| (entry, approached)));
                    }
                    None => self.waiting.extend(pack.take(i)),
                }
                self.fill(pack, i);
                continue;
            }
            let end = ends.of(i);
            if let Some(Err(failure)) = end {
                self.fail(pack, i, failure);
            } else if fates.arrived[i] || end.is_some() {
                if let Some(Occupant { job, watched }) = pack.occupants[i].take() {
                    let output = self.watch.finish(watched, &job.system, &ends.last(i, &step.to));
                    self.jobs.done(job.index, pack.statistics(i), Ok(output));
                }
                self.fill(pack, i);
            }
        }
    }
}
