//! The time loop of lanes: many runs side by side, each with its own time, step and end, with the same bits as alone.
//!
//! What happens once in a run (checks, first step) is done by a [`Run`](super::Run) of the lane alone. What happens in each step is done for
//! all lanes at once, in the words of its own loop. A lane whose run ends, well or not, takes the next one.

use super::engine::{
    Engine, LOOKOUTS, MAX_STEPS, TINY, attempt_beside, coasts, ends_early, restart_shorter, restore,
    shortened, tolerated,
};
use super::integrate;
use super::memories::DoubleBuffer;
use super::switches::{Approach, Interpolated, Passage, differ, passage};
use crate::controller::{Controller, FirstStep, Verdicts};
use crate::event::scan::Grid;
use crate::event::search::MOST_PARTS;
use crate::failure::{Cause, Failure};
use crate::lanes::{
    LaneController, Lanes, Lanewise, Level, Observer, Plain, Policy, Processor, Rescale, SingleLane, Work,
    disordered,
};
use crate::method::{Interpolant, Method, Step};
use crate::scalar::{Real, Scalar};
use crate::state::State;
use crate::system::System;
use core::marker::PhantomData;
use inside::Inside;

mod inside;

/// Lanes of a pack. Measured: with 16 values do not stay in registers, and with 4 half of a long register is idle.
pub(crate) const LANES: usize = 8;

/// A run that is to be made.
pub struct Job<Sys, const N: usize> {
    /// Index that tells it from others.
    pub index: u64,
    /// The system.
    pub system: Sys,
    /// State at which it begins.
    pub start: State<f64, N>,
}

/// A run that did not reach its end.
pub struct Ended<const N: usize> {
    /// State at which it began.
    pub start: State<f64, N>,
    /// Its last good state.
    pub last: State<f64, N>,
    /// Cause of the failure.
    pub failure: Failure,
}

/// End of runs, and the number of attempted steps in which each has to reach it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// The time at which runs end.
    pub end: f64,
    /// As [`Run::max_steps`](crate::Run::max_steps).
    pub max_steps: Option<u64>,
}

/// Source of runs, and sink of their outputs.
pub trait Jobs<Sys, O, const N: usize> {
    /// The next run.
    fn next(&mut self) -> Option<Job<Sys, N>>;

    /// Receives the output of one.
    fn done(&mut self, index: u64, output: Result<O, Ended<N>>);
}

/// Methods that run in lanes. In those that iterate until a condition holds (Gauss, variational, Radau, projection; and constraints do)
/// a lane waits for its neighbours.
#[diagnostic::on_unimplemented(
    message = "`{Self}` does not run in lanes for `{Sys}` under `{C}`",
    label = "not a method that makes steps of many trajectories at once",
    note = "methods do with `FixedStep`, with `PiController` or `PidController` where they estimate their error, and Taylor series with `TaylorController`; systems are those made by `lagrangian! {{ … }}`; other methods, such as those chosen at run time, run one by one, by `Study::reduce`"
)]
pub trait InLanes<Sys, C, P, const N: usize>: Sync
where
    Sys: Rescale<N, Scalar = f64>,
    P: Policy,
{
    /// Makes all runs, each within these bounds.
    #[doc(hidden)]
    fn runs<W: Observer<Sys, N>, J: Jobs<Sys, W::Output, N>>(
        &self,
        level: Level,
        controller: &C,
        bounds: Bounds,
        watch: &W,
        jobs: &mut J,
    );
}

/// As [`InLanes`], for one kind of processor.
pub trait OnProcessor<Sys, C, P, A, const N: usize>
where
    Sys: Rescale<N, Scalar = f64>,
{
    /// Makes all runs, each within these bounds.
    fn runs_on<W: Observer<Sys, N>, J: Jobs<Sys, W::Output, N>>(
        &self,
        controller: &C,
        bounds: Bounds,
        watch: &W,
        jobs: &mut J,
    );
}

// Each loop is compiled for each kind of processor. Builds for debugging, in which nothing is fast, compile it once.
#[cfg(all(target_arch = "x86_64", feature = "std", not(debug_assertions)))]
impl<Sys, M, C, P, const N: usize> InLanes<Sys, C, P, N> for M
where
    Sys: Rescale<N, Scalar = f64>,
    P: Policy,
    M: OnProcessor<Sys, C, P, crate::lanes::Baseline, N>
        + OnProcessor<Sys, C, P, crate::lanes::Avx2, N>
        + OnProcessor<Sys, C, P, crate::lanes::Avx512, N>
        + Sync,
{
    fn runs<W: Observer<Sys, N>, J: Jobs<Sys, W::Output, N>>(
        &self,
        level: Level,
        controller: &C,
        bounds: Bounds,
        watch: &W,
        jobs: &mut J,
    ) {
        use crate::lanes::{Avx2, Avx512, Baseline};
        match level {
            Level::Avx512 => {
                OnProcessor::<_, _, _, Avx512, N>::runs_on(self, controller, bounds, watch, jobs)
            }
            Level::Avx2 => OnProcessor::<_, _, _, Avx2, N>::runs_on(self, controller, bounds, watch, jobs),
            Level::Baseline => {
                OnProcessor::<_, _, _, Baseline, N>::runs_on(self, controller, bounds, watch, jobs);
            }
        }
    }
}

#[cfg(not(all(target_arch = "x86_64", feature = "std", not(debug_assertions))))]
impl<Sys, M, C, P, const N: usize> InLanes<Sys, C, P, N> for M
where
    Sys: Rescale<N, Scalar = f64>,
    P: Policy,
    M: OnProcessor<Sys, C, P, crate::lanes::Baseline, N> + Sync,
{
    fn runs<W: Observer<Sys, N>, J: Jobs<Sys, W::Output, N>>(
        &self,
        _: Level,
        controller: &C,
        bounds: Bounds,
        watch: &W,
        jobs: &mut J,
    ) {
        self.runs_on(controller, bounds, watch, jobs);
    }
}

/// The system over lanes, and over one of them.
type Packed<Sys, P, A, const N: usize> = <Sys as Rescale<N>>::Over<Lanes<LANES, P, A>>;
type Alone<Sys, P, A, const N: usize> = <Sys as Rescale<N>>::Over<SingleLane<P, A>>;

impl<Sys, M, C, P, A, const N: usize> OnProcessor<Sys, C, P, A, N> for M
where
    Sys: Rescale<N, Scalar = f64>,
    P: Policy,
    A: Processor,
    M: Clone,
    M: Method<Packed<Sys, P, A, N>, N, Error: Lanewise<LANES>, MethodState: Lanewise<LANES>>,
    M: Method<
            Alone<Sys, P, A, N>,
            N,
            Error = <<M as Method<Packed<Sys, P, A, N>, N>>::Error as Lanewise<LANES>>::Element,
            MethodState = <<M as Method<Packed<Sys, P, A, N>, N>>::MethodState as Lanewise<LANES>>::Element,
        >,
    C: LaneController<LANES, P, A, <M as Method<Packed<Sys, P, A, N>, N>>::Error, N>,
{
    fn runs_on<W: Observer<Sys, N>, J: Jobs<Sys, W::Output, N>>(
        &self,
        controller: &C,
        bounds: Bounds,
        watch: &W,
        jobs: &mut J,
    ) {
        A::call(Convoy {
            method: self,
            controller,
            bounds,
            watch,
            jobs,
            of: PhantomData::<fn() -> (Sys, P, A)>,
        });
    }
}

/// All that is to be done.
struct Convoy<'a, Sys, M, C, P, A, W, J, const N: usize> {
    method: &'a M,
    controller: &'a C,
    bounds: Bounds,
    watch: &'a W,
    jobs: &'a mut J,
    of: PhantomData<fn() -> (Sys, P, A)>,
}

/// A run that is about to enter a lane, or was found to be done.
struct Ready<S, MethodState, const N: usize> {
    state: State<S, N>,
    memory: MethodState,
    h: S,
    origin: S,
    total: f64,
}

/// Start of a run of a lane alone: `None` if it begins at its end.
fn ready<Sys, M, C, const N: usize>(
    system: &Sys,
    method: M,
    controller: C,
    start: State<Sys::Scalar, N>,
    end: Sys::Scalar,
) -> Result<Option<Ready<Sys::Scalar, M::MethodState, N>>, Failure<Sys::Scalar>>
where
    Sys: System<N>,
    Sys::Scalar: Real,
    M: Method<Sys, N>,
    C: Controller<Sys::Scalar, N, M::Error>,
{
    let mut run = integrate(system, method, controller, start).until(end);
    run.engine.begin(system)?;
    let Engine { state, memory, h, origin, total, controller, .. } = run.engine;
    let fixed = matches!(controller.first_step(), FirstStep::Fixed(_));
    let over = if fixed { total == 0.0 } else { state.t == end };
    Ok(memory.filter(|_| !over).map(|memory| Ready { state, memory: memory.now().clone(), h, origin, total }))
}

/// A lane with a run in it.
struct Occupant<Sys, W, const N: usize> {
    job: Job<Sys, N>,
    watched: W,
}

/// The interpolant of a step.
struct Interpolate<'a, Sys: System<N>, M: Method<Sys, N>, const N: usize> {
    method: &'a M,
    system: &'a Sys,
    step: &'a Step<Sys, M, N>,
}

impl<Sys: System<N>, M: Method<Sys, N>, const N: usize> Work for Interpolate<'_, Sys, M, N> {
    type Output = M::Interpolant;

    #[inline(always)]
    fn run(self) -> M::Interpolant {
        self.method.interpolant(self.system, self.step)
    }
}

/// The cheaper interpolant of a step, if there is one.
struct Coarse<'a, Sys: System<N>, M: Method<Sys, N>, const N: usize>(Interpolate<'a, Sys, M, N>);

impl<Sys: System<N>, M: Method<Sys, N>, const N: usize> Work for Coarse<'_, Sys, M, N> {
    type Output = Option<M::Interpolant>;

    #[inline(always)]
    fn run(self) -> Option<M::Interpolant> {
        self.0.method.coarse_interpolant(self.0.system, self.0.step)
    }
}

/// The interpolant of a step at a time of each lane.
struct At<'a, D, T, const N: usize> {
    dense: &'a D,
    t: T,
}

impl<D: Interpolant<T, N>, T: Scalar, const N: usize> Work for At<'_, D, T, N> {
    type Output = State<T, N>;

    #[inline(always)]
    fn run(self) -> State<T, N> {
        self.dense.at(self.t)
    }
}

/// A step of a lane alone, and what its next one begins with.
struct Apart<'a, Sys: System<N>, M, C, MethodState, const N: usize> {
    method: &'a M,
    controller: C,
    system: Sys,
    memory: MethodState,
    from: State<Sys::Scalar, N>,
    h: Sys::Scalar,
}

impl<Sys, M, C, const N: usize> Work for Apart<'_, Sys, M, C, M::MethodState, N>
where
    Sys: System<N>,
    Sys::Scalar: Real,
    M: Method<Sys, N>,
    C: Controller<Sys::Scalar, N, M::Error>,
{
    type Output = Result<(Step<Sys, M, N>, M::MethodState), Failure<Sys::Scalar>>;

    #[inline(always)]
    fn run(self) -> Self::Output {
        attempt_beside(&self.system, self.method, &self.controller, &self.memory, &self.from, self.h)
    }
}

/// The parameters of the systems in the lanes, in the order of [`Rescale::over`].
struct Parameters(Vec<[f64; LANES]>);

impl Parameters {
    /// Those of `system` in all lanes.
    fn of<Sys: Rescale<N, Scalar = f64>, const N: usize>(system: &Sys) -> Self {
        let mut values = vec![];
        let _ = system.over(|x| {
            values.push([x; LANES]);
            SingleLane::<Plain>::new(x)
        });
        Parameters(values)
    }

    /// Gives a lane those of `system`, and what comes of it all: the systems side by side.
    fn put<Sys, P, A, const N: usize>(&mut self, lane: usize, system: &Sys) -> Packed<Sys, P, A, N>
    where
        Sys: Rescale<N, Scalar = f64>,
        P: Policy,
        A: Processor,
    {
        let mut values = self.0.iter_mut();
        system.over(|x| {
            let all = values.next().map(|all| {
                all[lane] = x;
                *all
            });
            Lanes::new(all.unwrap_or([x; LANES]))
        })
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
            Error = <<M as Method<Packed<Sys, P, A, N>, N>>::Error as Lanewise<LANES>>::Element,
            MethodState = <<M as Method<Packed<Sys, P, A, N>, N>>::MethodState as Lanewise<LANES>>::Element,
        >,
    C: LaneController<LANES, P, A, <M as Method<Packed<Sys, P, A, N>, N>>::Error, N>,
    W: Observer<Sys, N>,
    J: Jobs<Sys, W::Output, N>,
{
    type Output = ();

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn run(self) {
        let Convoy { method, controller, bounds, watch, jobs, .. } = self;
        let Bounds { end, max_steps } = bounds;
        let order = <M as Method<Packed<Sys, P, A, N>, N>>::order(method);
        let implicit = <M as Method<Packed<Sys, P, A, N>, N>>::implicit(method);
        let fixed = matches!(controller.alone().first_step(), FirstStep::Fixed(_));
        let budget = max_steps.unwrap_or(if fixed { u64::MAX } else { MAX_STEPS });
        // (What follows a constant is not compiled where it is false.)
        let switching = const { <Packed<Sys, P, A, N> as System<N>>::SWITCHES > 0 }
            && !fixed
            && !<M as Method<Packed<Sys, P, A, N>, N>>::ends_at_switches(method);

        // The next run that has a way to go; those that have none, or cannot begin, are done at once.
        let next = |jobs: &mut J| {
            while let Some(job) = jobs.next() {
                let system = job.system.over(SingleLane::<P, A>::new);
                let start = job.start.map(SingleLane::new);
                let mut watched = watch.start(&job.system, &job.start);
                let t = job.start.t;
                if watch.wanted(&watched) == Some(t) {
                    watch.sample(&mut watched, &job.system, &job.start);
                }
                if let Some(failure) = disordered(t, end - t, watch.wanted(&watched)) {
                    jobs.done(job.index, Err(Ended { start: job.start, last: job.start, failure }));
                    continue;
                }
                match ready(&system, method.clone(), controller.alone(), start, SingleLane::new(end)) {
                    Ok(Some(ready)) => return Some((Occupant { job, watched }, ready)),
                    Ok(None) => {
                        let output = watch.finish(watched, &job.system, &job.start);
                        jobs.done(job.index, Ok(output));
                    }
                    Err(failure) => {
                        let failure = failure.map(SingleLane::value);
                        jobs.done(job.index, Err(Ended { start: job.start, last: job.start, failure }));
                    }
                }
            }
            None
        };

        let Some((occupant, entry)) = next(jobs) else { return };
        // Lanes that wait for a run compute on a copy of another one's, by steps of size 0.
        let mut parameters = Parameters::of(&occupant.job.system);
        let mut system: Packed<Sys, P, A, N> = parameters.put(0, &occupant.job.system);
        let mut state = <State<Lanes<LANES, P, A>, N> as Lanewise<LANES>>::splat(&entry.state);
        let memory: <M as Method<Packed<Sys, P, A, N>, N>>::MethodState = Lanewise::splat(&entry.memory);
        let mut variable = memory.clone();
        let mut memories = DoubleBuffer::new(memory);
        let mut controllers: [C; LANES] = core::array::from_fn(|_| controller.clone());
        let mut occupants: [Option<Occupant<Sys, W::Accumulator, N>>; LANES] = [const { None }; LANES];
        let mut live = [false; LANES];
        // As the fields of `Run`.
        let (mut h, mut origin, mut count, mut total) =
            ([0.0; LANES], [0.0; LANES], [0.0; LANES], [f64::INFINITY; LANES]);
        let mut longest = [0.0f64; LANES];
        let max_step = controller.alone().max_step();
        let mut bound = [max_step; LANES];
        let mut approach = [Approach::NONE; LANES];
        let (mut attempts, mut cause, mut caused) = ([0u64; LANES], [None::<Cause>; LANES], false);
        // Lanes whose last step ended at a switch, and whether there are any: looking at single flags in each step takes a fifth of RK4's time.
        let (mut stopped, mut interrupted) = ([false; LANES], false);

        // Puts a run into a lane.
        macro_rules! enter {
            ($lane:expr, $occupant:expr, $entry:expr) => {{
                let (lane, occupant, entry) = ($lane, $occupant, $entry);
                system = parameters.put(lane, &occupant.job.system);
                state.put(lane, &entry.state);
                memories.now_mut().put(lane, &entry.memory);
                controllers[lane] = controller.clone();
                (h[lane], origin[lane]) = (entry.h.value(), entry.origin.value());
                (count[lane], total[lane], longest[lane]) = (0.0, entry.total, 0.0);
                if !<Packed<Sys, P, A, N> as System<N>>::AUTONOMOUS {
                    bound[lane] = max_step.min((end - occupant.job.start.t).abs() / LOOKOUTS);
                }
                (attempts[lane], cause[lane], stopped[lane]) = (0, None, false);
                approach[lane] = Approach::NONE;
                (occupants[lane], live[lane]) = (Some(occupant), true);
            }};
        }

        // Fills a lane whose run has ended.
        macro_rules! refill {
            ($lane:expr) => {{
                let lane = $lane;
                (occupants[lane], live[lane], h[lane]) = (None, false, 0.0);
                if let Some((occupant, entry)) = next(jobs) {
                    enter!(lane, occupant, entry);
                } else if let Some((other, Some(occupant))) =
                    occupants.iter().enumerate().find(|(_, occupant)| occupant.is_some())
                {
                    system = parameters.put(lane, &occupant.job.system);
                    let (copied, remembered) = (state.lane(other), memories.now().lane(other));
                    state.put(lane, &copied);
                    memories.now_mut().put(lane, &remembered);
                }
            }};
        }

        // Ends the run of a lane by a failure.
        macro_rules! fail {
            ($lane:expr, $failure:expr) => {{
                let lane = $lane;
                if let Some(Occupant { job, .. }) = occupants[lane].take() {
                    let (failure, last): (Failure, _) = ($failure, state.lane(lane));
                    let system = job.system.over(SingleLane::<P, A>::new);
                    let failure = system.explained(
                        &job.start.map(SingleLane::new),
                        &last,
                        failure.map(SingleLane::new),
                    );
                    let (failure, last) = (failure.map(SingleLane::value), last.map(SingleLane::value));
                    jobs.done(job.index, Err(Ended { start: job.start, last, failure }));
                }
                refill!(lane);
            }};
        }

        // States at places of a step at which events look.
        let mut looked: [Vec<(f64, State<Lanes<LANES, P, A>, N>)>; 2] = [vec![], vec![]];

        let mut first = Some((occupant, entry));
        for lane in 0..LANES {
            let Some((occupant, entry)) = first.take().or_else(|| next(jobs)) else { break };
            enter!(lane, occupant, entry);
        }

        while live.contains(&true) {
            if const { !<Alone<Sys, P, A, N> as System<N>>::ATTITUDES.is_empty() } {
                for i in 0..LANES {
                    let Some(Occupant { job, .. }) = &occupants[i] else { continue };
                    let alone = || job.system.over(SingleLane::<P, A>::new);
                    match restart_shorter::<Alone<Sys, P, A, N>, M, _, N>(alone, method, &state.lane(i)) {
                        None => {}
                        Some(Ok((shorter, memory))) => {
                            state.put(i, &shorter);
                            memories.now_mut().put(i, &memory);
                        }
                        Some(Err(failure)) => fail!(i, failure.map(SingleLane::value)),
                    }
                }
            }
            let t = *state.t.as_array();
            // The step that is tried, and whether it lands on the end.
            let (mut tried, mut lands) = (h, [false; LANES]);
            if interrupted {
                for i in 0..LANES {
                    if stopped[i] {
                        let last = count[i] + 1.0 == total[i];
                        let next = if last { end } else { P::mul_add(count[i] + 1.0, h[i], origin[i]) };
                        tried[i] = next - t[i];
                    }
                }
            }
            if fixed && budget < u64::MAX {
                if (0..LANES).any(|i| live[i] && attempts[i] >= budget) {
                    for i in 0..LANES {
                        if live[i] && attempts[i] >= budget {
                            let (t, h) = (t[i], h[i]);
                            fail!(i, Failure::BudgetUsedUp { t, h, max_steps: budget, implicit });
                        }
                    }
                    continue;
                }
                for i in 0..LANES {
                    attempts[i] += 1;
                }
            }
            if !fixed {
                if (0..LANES).any(|i| live[i] & (h[i].abs() > bound[i])) {
                    for i in 0..LANES {
                        h[i] = shortened(h[i], max_step);
                        if h[i].abs() > bound[i]
                            && let Some(Occupant { job, .. }) = &occupants[i]
                        {
                            let system = job.system.over(SingleLane::<P, A>::new);
                            let (alone, at) = (controllers[i].alone(), state.lane(i));
                            if coasts::<
                                _,
                                <<M as Method<Packed<Sys, P, A, N>, N>>::Error as Lanewise<LANES>>::Element,
                                _,
                                N,
                            >(&system, alone, at, bound[i])
                            {
                                h[i] = shortened(h[i], bound[i]);
                            }
                        }
                    }
                }
                let (mut stuck, mut tiny) = (false, false);
                for i in 0..LANES {
                    let rest = end - t[i];
                    lands[i] = (h[i] * 1.01).abs() >= rest.abs();
                    tried[i] = if lands[i] { rest } else { h[i] };
                    if switching && approach[i].is_near() {
                        lands[i] = approach[i].h.abs() >= rest.abs();
                        tried[i] = if lands[i] { rest } else { approach[i].h };
                    }
                    stuck |= live[i] & ((!lands[i] & (t[i] + h[i] * 0.1 == t[i])) | (attempts[i] >= budget));
                    tiny |= live[i] & (h[i].abs() < TINY * longest[i]);
                }
                if stuck {
                    for i in 0..LANES {
                        if live[i] && attempts[i] >= budget {
                            let (t, h) = (t[i], h[i]);
                            fail!(i, Failure::BudgetUsedUp { t, h, max_steps: budget, implicit });
                        } else if live[i] && !lands[i] && t[i] + h[i] * 0.1 == t[i] {
                            fail!(i, Failure::StepSizeUnderflow { t: t[i], h: h[i], cause: cause[i] });
                        }
                    }
                    continue;
                }
                if tiny {
                    let mut cancelled = false;
                    for i in 0..LANES {
                        if h[i].abs() < TINY * longest[i]
                            && let Some(Occupant { job, .. }) = &occupants[i]
                        {
                            let system = job.system.over(SingleLane::<P, A>::new);
                            if let Err(failure) =
                                system.resolved(&job.start.map(SingleLane::new), &state.lane(i))
                            {
                                fail!(i, failure.map(SingleLane::value));
                                cancelled = true;
                            }
                        }
                    }
                    if cancelled {
                        continue;
                    }
                }
                for i in 0..LANES {
                    attempts[i] += 1;
                }
            }

            // The step of a lane alone.
            macro_rules! apart {
                ($lane:expr, $job:expr) => {{
                    let (system, from) = ($job.system.over(SingleLane::<P, A>::new), state.lane($lane));
                    let h = SingleLane::new(tried[$lane]);
                    let (memory, controller) = (memories.now().lane($lane), controller.alone());
                    A::call(Apart { method, controller, system, memory, from, h })
                }};
            }
            // A lane whose step could not be made takes the next one or fails, as `Run` does.
            let before = h;
            macro_rules! refused {
                ($lane:expr, $failure:expr) => {{
                    let (i, failure): (usize, Failure) = ($lane, $failure);
                    let over = matches!(failure, Failure::Sliding { .. } | Failure::NoDerivative { .. });
                    let again = match &occupants[i] {
                        Some(Occupant { job, .. })
                            if const { <Packed<Sys, P, A, N> as System<N>>::SWITCHES > 0 }
                                && switching
                                && !over =>
                        {
                            let system = job.system.over(SingleLane::<P, A>::new);
                            approach[i].after_failure(&system, &state.lane(i), tried[i])
                        }
                        _ => Ok(false),
                    };
                    match again {
                        Ok(true) => Ok(before[i]),
                        Ok(false) => {
                            (cause[i], caused, approach[i]) = (failure.cause(), true, Approach::NONE);
                            let next = if over { None } else { controllers[i].after_failure() };
                            next.map(|factor| tried[i] * factor).ok_or(failure)
                        }
                        Err(sliding) => Err(sliding.map(SingleLane::value)),
                    }
                }};
            }

            let (memory, next) = memories.of_step(&mut variable);
            let mut attempted = method.step(&system, memory, &state, Lanes::new(tried), next);
            // It stays where it is: steps are large.
            let Ok(step) = &mut attempted else {
                // Why they could not make it, the same step of each lane alone tells.
                for i in 0..LANES {
                    if let Some(Occupant { job, .. }) = &occupants[i] {
                        let Err(failure) = apart!(i, job) else {
                            unreachable!(
                                "a step that lanes cannot make is none that one of them can make alone"
                            )
                        };
                        match refused!(i, failure.map(SingleLane::value)) {
                            Ok(next) => h[i] = next,
                            Err(failure) => fail!(i, failure),
                        }
                    }
                }
                continue;
            };
            match restore(&system, method, step, memories.of_step(&mut variable).1) {
                Ok(None) => {}
                // A lane that was moved too far makes its step alone, which says so.
                Ok(Some((correction, _))) => {
                    let alone = controller.alone();
                    for i in 0..LANES {
                        let [from, to] = [state.lane(i), step.to.lane(i)];
                        if !tolerated(&alone, &correction.lane(i), &from, &to) {
                            step.to.q[0].put(i, &SingleLane::new(f64::NAN));
                        }
                    }
                }
                Err(_) => step.to.q[0] = Lanes::splat(f64::NAN),
            }

            // What becomes of it, lane by lane.
            let mut sum = Lanes::<LANES, P, A>::zero();
            for i in 0..N {
                sum += step.to.q[i] + step.to.qd[i];
            }
            let (mut finite, mut missing) = ([false; LANES], false);
            for i in 0..LANES {
                finite[i] = sum.as_array()[i] * 0.0 == 0.0;
                missing |= live[i] & !finite[i];
            }
            // Lanes whose step has no end make it alone: up to a switch of their own, or until it is known what is wrong.
            let (mut alone, mut failed) = (vec![], vec![]);
            let mut early = [false; LANES];
            if missing {
                // Of its own: what is looked up by a lane's number is in memory from then on, also in all steps where nothing is missing.
                let (mut made, mut sizes, before) = ([false; LANES], tried, finite);
                for i in 0..LANES {
                    if let Some(Occupant { job, .. }) = &occupants[i]
                        && !before[i]
                    {
                        match apart!(i, job) {
                            Ok((one, after)) => {
                                made[i] = true;
                                step.to.put(i, &one.to);
                                memories.of_step(&mut variable).1.put(i, &after);
                                step.error.put(i, &one.error);
                                step.h.put(i, &one.h);
                                if ends_early(&one, SingleLane::new(tried[i])) {
                                    sizes[i] = one.h.value();
                                }
                                let system = job.system.over(SingleLane::<P, A>::new);
                                let interpolate = || Interpolate { method, system: &system, step: &one };
                                let coarse = if switching { A::call(Coarse(interpolate())) } else { None };
                                alone.push((i, one.to.t.value(), A::call(interpolate()), coarse));
                            }
                            Err(failure) => failed.push((i, failure.map(SingleLane::value))),
                        }
                    }
                }
                for i in 0..LANES {
                    finite[i] |= made[i];
                    early[i] = sizes[i] != tried[i];
                    lands[i] &= !early[i];
                    tried[i] = sizes[i];
                }
            }
            let interpolant_of = |i: usize| alone.iter().find(|(lane, ..)| *lane == i);
            let measures = controller.measures(&state, &step.to, &step.error);
            let Verdicts { accepted: mut good, mut factor } =
                C::decide(&mut controllers, &measures, &finite, order);
            let mut dense = None;
            macro_rules! interpolant {
                () => {
                    &*dense.get_or_insert_with(|| A::call(Interpolate { method, system: &system, step }))
                };
            }
            // Events and switches are looked for at these parts of the step of each lane, at the finest of them for all lanes at once. (Those
            // that depend on the step are powers of two, and each lane's are among the finest.)
            let parts: [u32; LANES] = core::array::from_fn(|i| {
                let h = SingleLane::new(step.h.as_array()[i]);
                <M as Method<Alone<Sys, P, A, N>, N>>::parts(method, &memories.now().lane(i), h)
            });
            looked.iter_mut().for_each(Vec::clear);
            let coarse =
                if switching { A::call(Coarse(Interpolate { method, system: &system, step })) } else { None };
            let for_switches = usize::from(coarse.is_some());
            macro_rules! look {
                ($which:expr) => {
                    if looked[$which].is_empty() {
                        let dense = if $which == 0 { Some(interpolant!()) } else { coarse.as_ref() };
                        let finest =
                            parts.into_iter().filter(|parts| *parts <= MOST_PARTS).max().unwrap_or(1);
                        for x in Grid::new(finest, false, f64::EPSILON).places() {
                            let t = step.h.mul_add(Lanes::splat(x), state.t);
                            let at = dense.map(|dense| A::call(At::<_, _, N> { dense, t }));
                            looked[$which].extend(at.map(|at| (x, at)));
                        }
                    }
                };
            }
            // A method may have changed the size of its step, so that it is the difference of its times.
            let sizes = *step.h.as_array();
            // The state of a lane at a part of the step, after `look`.
            macro_rules! between {
                ($which:expr, $lane:expr, $x:expr) => {{
                    let (i, x) = ($lane, $x);
                    let t = || Lanes::splat(P::mul_add(sizes[i], x, t[i]));
                    let dense = if $which == 0 { &dense } else { &coarse };
                    match (interpolant_of(i), looked[$which].iter().find(|(place, _)| *place == x), dense) {
                        (Some((.., dense, coarse)), ..) => {
                            let dense = coarse.as_ref().filter(|_| $which == 1).unwrap_or(dense);
                            A::call(At::<_, _, N> { dense, t: t().lane(i) })
                        }
                        (_, Some((_, at)), _) => at.lane(i),
                        (_, None, Some(dense)) => A::call(At::<_, _, N> { dense, t: t() }).lane(i),
                        _ => unreachable!("`look` made the interpolant"),
                    }
                }};
            }
            // Runs that end within the step, or because of it.
            let mut ends: [Option<Result<State<f64, N>, Failure>>; LANES] = [const { None }; LANES];
            // Lanes on their way to a switch, and those that try a shorter step to it although the controller accepts this one.
            let (mut near, mut again) = ([false; LANES], [false; LANES]);
            if const { <Packed<Sys, P, A, N> as System<N>>::SWITCHES > 0 } && switching {
                for i in 0..LANES {
                    let Some(Occupant { job, .. }) = &occupants[i] else { continue };
                    near[i] = approach[i].is_near();
                    if !finite[i] {
                        continue;
                    }
                    let system = job.system.over(SingleLane::<P, A>::new);
                    let step_ends = [
                        state.lane(i),
                        State {
                            t: SingleLane::new(if lands[i] { end } else { step.to.t.as_array()[i] }),
                            ..step.to.lane(i)
                        },
                    ];
                    let rejected = if good[i] {
                        None
                    } else if differ(&system, &step_ends[0], &step_ends[1]) {
                        Some(factor[i])
                    } else {
                        approach[i] = Approach::NONE;
                        continue;
                    };
                    look!(for_switches);
                    let within = Interpolated {
                        ends: step_ends,
                        h: SingleLane::new(sizes[i]),
                        parts: parts[i],
                        between: |x: f64| between!(for_switches, i, x),
                    };
                    let alone = controllers[i].alone();
                    let norm = |difference: &_, a: &_, b: &_| {
                        Controller::<
                            _,
                            N,
                            <<M as Method<Packed<Sys, P, A, N>, N>>::Error as Lanewise<LANES>>::Element,
                        >::norm(&alone, difference, a, b)
                    };
                    match passage(&mut approach[i], &system, &within, rejected, norm) {
                        Ok(Passage::Free) if good[i] => near[i] &= approach[i].is_near(),
                        Ok(Passage::Free) => approach[i] = Approach::NONE,
                        Ok(Passage::Again) => (again[i], good[i]) = (good[i], false),
                        // (These numbers have no slopes.)
                        Ok(Passage::Across { .. }) => (good[i], factor[i]) = (true, 1.0),
                        Err(failure) => {
                            (ends[i], good[i]) = (Some(Err(failure.map(SingleLane::value))), false)
                        }
                    }
                }
            }
            // Time, and the next step. One loop over numbers, which the optimiser makes vectors of; it takes several apart into single flags.
            let (mut accepted, mut arrived) = ([false; LANES], [false; LANES]);
            let mut any = false;
            let to = step.to.t.as_mut();
            if fixed {
                for i in 0..LANES {
                    accepted[i] = live[i] & finite[i];
                    count[i] += 1.0;
                    arrived[i] = accepted[i] & (count[i] >= total[i]);
                    to[i] = if count[i] == total[i] { end } else { P::mul_add(count[i], h[i], origin[i]) };
                    any |= arrived[i];
                }
                // A step that ends at a switch is followed by what is left of it.
                if missing || interrupted {
                    (stopped, interrupted) = (early, early.contains(&true));
                    for &(i, t, ..) in &alone {
                        if early[i] {
                            count[i] -= 1.0;
                            (to[i], arrived[i]) = (t, false);
                        }
                    }
                    any = arrived.contains(&true);
                }
            } else {
                for i in 0..LANES {
                    let good = live[i] & finite[i] & good[i];
                    let at = if lands[i] { end } else { to[i] };
                    let next = tried[i] * factor[i];
                    // A step cut short by the end or a switch says little about the one after it.
                    let longer = next.abs() > h[i].abs();
                    let next = if good & (lands[i] | early[i] | near[i]) & !longer { h[i] } else { next };
                    h[i] = if live[i] { next } else { 0.0 };
                    to[i] = at;
                    let size = if good { sizes[i].abs() } else { 0.0 };
                    longest[i] = if size > longest[i] { size } else { longest[i] };
                    accepted[i] = good;
                    arrived[i] = good & (at == end);
                    any |= good & (at == end);
                }
                if switching {
                    for i in 0..LANES {
                        h[i] = if again[i] { before[i] } else { h[i] };
                    }
                }
            }
            if caused {
                for i in 0..LANES {
                    cause[i] = if finite[i] { None } else { cause[i] };
                }
            }
            if missing {
                for (i, failure) in failed {
                    match refused!(i, failure) {
                        Ok(next) => h[i] = next,
                        Err(failure) => ends[i] = Some(Err(failure)),
                    }
                }
            }

            // What is wanted of it.
            if W::WITHIN {
                look!(0);
                for i in 0..LANES {
                    if accepted[i]
                        && let Some(Occupant { job, watched }) = &mut occupants[i]
                    {
                        let inside = Inside {
                            ends: [state.lane(i), step.to.lane(i)].map(|at| at.map(SingleLane::value)),
                            h: sizes[i],
                            parts: parts[i],
                            between: &|x| between!(0, i, x).map(SingleLane::value),
                            stepped: &|x| {
                                let system = job.system.over(SingleLane::<P, A>::new);
                                let (memory, from) = (memories.now().lane(i), state.lane(i));
                                let h = SingleLane::new(sizes[i]) * SingleLane::new(x);
                                let step = A::call(Apart {
                                    method,
                                    controller: controller.alone(),
                                    system,
                                    memory,
                                    from,
                                    h,
                                });
                                step.map(|(one, _)| one.to.map(SingleLane::value))
                                    .map_err(|failure| failure.map(SingleLane::value))
                            },
                        };
                        ends[i] = watch.within(watched, &job.system, &inside).transpose();
                    }
                }
            }
            // The last state of a lane's step.
            macro_rules! last {
                ($lane:expr) => {
                    match ends[$lane] {
                        Some(Ok(end)) => end,
                        _ => step.to.lane($lane).map(SingleLane::value),
                    }
                };
            }
            let mut until = *step.to.t.as_array();
            if W::WITHIN || missing || switching {
                for i in 0..LANES {
                    if let Some(Ok(end)) = &ends[i] {
                        until[i] = end.t;
                    }
                    any |= ends[i].is_some();
                }
            }
            if W::STEPS {
                for i in 0..LANES {
                    if accepted[i]
                        && let Some(Occupant { job, watched }) = &mut occupants[i]
                    {
                        let from = state.lane(i).map(SingleLane::value);
                        watch.step(watched, &job.system, &from, &last!(i));
                    }
                }
            }
            loop {
                let (mut times, mut wanted) = (step.to.t, [false; LANES]);
                for i in 0..LANES {
                    if accepted[i]
                        && let Some(Occupant { watched, .. }) = &occupants[i]
                        && let Some(time) = watch.wanted(watched)
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
                let between = interpolant!();
                let between = A::call(At::<_, _, N> { dense: between, t: times });
                for i in 0..LANES {
                    if wanted[i]
                        && let Some(Occupant { job, watched }) = &mut occupants[i]
                    {
                        let at = match interpolant_of(i) {
                            _ if times.as_array()[i] == until[i] => last!(i),
                            Some((.., dense, _)) => {
                                A::call(At::<_, _, N> { dense, t: times.lane(i) }).map(SingleLane::value)
                            }
                            None => between.lane(i).map(SingleLane::value),
                        };
                        watch.sample(watched, &job.system, &at);
                        if let Some(failure) = disordered(at.t, tried[i], watch.wanted(watched)) {
                            (ends[i], accepted[i], any) = (Some(Err(failure)), false, true);
                        }
                    }
                }
            }

            state.take(&accepted, &step.to);
            memories.turn_lanes(&accepted, &variable);
            if any {
                for i in 0..LANES {
                    if let Some(Err(failure)) = ends[i] {
                        fail!(i, failure);
                    } else if arrived[i] || ends[i].is_some() {
                        if let Some(Occupant { job, watched }) = occupants[i].take() {
                            jobs.done(job.index, Ok(watch.finish(watched, &job.system, &last!(i))));
                        }
                        refill!(i);
                    }
                }
            }
        }
    }
}
