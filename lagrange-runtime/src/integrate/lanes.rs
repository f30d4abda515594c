//! The time loop of lanes: many runs side by side, each with its own time, step and end, with the same bits as alone.
//!
//! What happens once in a run (checks, first step) is done by a [`Run`] of the lane alone. What happens in each step is done for
//! all lanes at once, in the words of [`Run`]'s own loop. A lane whose run ends, well or not, takes the next one.

use super::{MAX_STEPS, Run, integrate};
use crate::controller::{Controller, FirstStep, Verdict};
use crate::failure::{Cause, Failure};
#[cfg(all(target_arch = "x86_64", feature = "std"))]
use crate::lanes::{Avx2, Avx512};
use crate::lanes::{
    Baseline, Lane, LaneController, Lanes, Lanewise, Level, Plain, Policy, Processor, Rescale, Watch, Work,
};
use crate::method::{Dense, Method};
use crate::scalar::{Real, Scalar};
use crate::state::State;
use crate::system::System;
use core::marker::PhantomData;

/// A run that is to be made.
pub struct Job<Sys, const N: usize> {
    /// What tells it from others.
    pub index: u64,
    /// The system.
    pub system: Sys,
    /// Where it begins.
    pub start: State<f64, N>,
}

/// A run that did not reach its end.
pub struct Ended<const N: usize> {
    /// Where it began.
    pub start: State<f64, N>,
    /// Its last good state.
    pub last: State<f64, N>,
    /// What went wrong.
    pub failure: Failure,
}

/// Where runs come from, and what becomes of their outputs.
pub trait Jobs<Sys, O, const N: usize> {
    /// The next run.
    fn next(&mut self) -> Option<Job<Sys, N>>;

    /// What came of one.
    fn done(&mut self, index: u64, output: Result<O, Ended<N>>);
}

/// Methods that run in lanes: explicit ones, whose steps are the same operations for every state.
///
/// Those that iterate until a condition holds (Gauss, variational, Radau) do not: a lane would wait for its neighbours. Their
/// trajectories are computed one by one.
#[diagnostic::on_unimplemented(
    message = "`{Self}` does not run in lanes for `{Sys}` under `{C}`",
    label = "not a method that makes steps of many trajectories at once",
    note = "explicit Runge–Kutta, Nyström, splitting methods and their compositions do, with `Fixed`, and with `Pi` or `Pid` where they estimate their error; systems are those made by `lagrangian! {{ … }}`, without constraints; other methods run one by one, by `Study::reduce`"
)]
pub trait InLanes<Sys, C, P, const N: usize>: Sync
where
    Sys: Rescale<N, Scalar = f64>,
    P: Policy,
{
    /// Makes all runs, each to `t = end`.
    #[doc(hidden)]
    fn runs<W: Watch<Sys, N>, J: Jobs<Sys, W::Output, N>>(
        &self,
        level: Level,
        controller: &C,
        end: f64,
        watch: &W,
        jobs: &mut J,
    );
}

/// The system over `L` lanes, and over one of them.
type Packed<Sys, P, A, const L: usize, const N: usize> = <Sys as Rescale<N>>::Over<Lanes<L, P, A>>;
type Alone<Sys, P, A, const N: usize> = <Sys as Rescale<N>>::Over<Lane<P, A>>;

/// Another name for: makes steps of `L` lanes of the system, and of one lane alone, with the same memory and error estimate.
pub trait SideBySide<Sys: Rescale<N>, P: Policy, A: Processor, const L: usize, const N: usize>:
    Method<
        Packed<Sys, P, A, L, N>,
        N,
        Error = <Self as SideBySide<Sys, P, A, L, N>>::Errors,
        Memory = <Self as SideBySide<Sys, P, A, L, N>>::Memories,
    > + Method<
        Alone<Sys, P, A, N>,
        N,
        Error = <<Self as SideBySide<Sys, P, A, L, N>>::Errors as Lanewise<L>>::One,
        Memory = <<Self as SideBySide<Sys, P, A, L, N>>::Memories as Lanewise<L>>::One,
    > + Clone
    + Sync
{
    /// Error estimates of the lanes.
    type Errors: Lanewise<L>;
    /// What the lanes hand from step to step.
    type Memories: Lanewise<L>;
}

impl<M, Sys, P, A, E, R, const L: usize, const N: usize> SideBySide<Sys, P, A, L, N> for M
where
    Sys: Rescale<N>,
    P: Policy,
    A: Processor,
    E: Lanewise<L>,
    R: Lanewise<L>,
    M: Method<Packed<Sys, P, A, L, N>, N, Error = E, Memory = R>
        + Method<Alone<Sys, P, A, N>, N, Error = E::One, Memory = R::One>
        + Clone
        + Sync,
{
    type Errors = E;
    type Memories = R;
}

/// For each kind of processor, how many lanes there are.
macro_rules! in_lanes {
    ($($(#[$only:meta])* $processor:ident: $lanes:literal),*) => {
        #[allow(unused_doc_comments)]
        impl<Sys, M, C, P, const N: usize> InLanes<Sys, C, P, N> for M
        where
            Sys: Rescale<N, Scalar = f64>,
            P: Policy,
            M: Sync $(+ SideBySide<Sys, P, $processor, $lanes, N>)*,
            $(C: LaneController<$lanes, P, $processor, <M as SideBySide<Sys, P, $processor, $lanes, N>>::Errors, N>,)*
        {
            fn runs<W: Watch<Sys, N>, J: Jobs<Sys, W::Output, N>>(
                &self,
                level: Level,
                controller: &C,
                end: f64,
                watch: &W,
                jobs: &mut J,
            ) {
                match level {
                    $(Level::$processor => $processor::call(Convoy::<Sys, M, C, P, $processor, W, J, $lanes, N> {
                        method: self,
                        controller,
                        end,
                        watch,
                        jobs,
                        of: PhantomData,
                    }),)*
                    #[allow(unreachable_patterns)]
                    _ => unreachable!("a level that this build does not have"),
                }
            }
        }
    };
}

// Two registers of each value: while one result is on its way, the processor works at the other. (Measured: more do not stay in
// registers.)
#[cfg(all(target_arch = "x86_64", feature = "std"))]
in_lanes!(Baseline: 4, Avx2: 8, Avx512: 16);
#[cfg(not(all(target_arch = "x86_64", feature = "std")))]
in_lanes!(Baseline: 4);

/// All that is to be done.
struct Convoy<'a, Sys, M, C, P, A, W, J, const L: usize, const N: usize> {
    method: &'a M,
    controller: &'a C,
    end: f64,
    watch: &'a W,
    jobs: &'a mut J,
    of: PhantomData<fn() -> (Sys, P, A)>,
}

/// A run that is about to enter a lane, or was found to be done.
struct Ready<S, Memory, const N: usize> {
    state: State<S, N>,
    memory: Memory,
    h: S,
    origin: S,
    total: f64,
}

/// What a run of a lane alone begins with: `None` if it begins at its end.
fn ready<Sys, M, C, const N: usize>(
    system: &Sys,
    method: M,
    controller: C,
    start: State<Sys::Scalar, N>,
    end: Sys::Scalar,
) -> Result<Option<Ready<Sys::Scalar, M::Memory, N>>, Failure<Sys::Scalar>>
where
    Sys: System<N>,
    Sys::Scalar: Real,
    M: Method<Sys, N>,
    C: Controller<Sys::Scalar, N, M::Error>,
{
    let mut run = integrate(system, method, controller, start).until(end);
    run.prepare()?;
    let Run { state, memory, h, origin, total, .. } = run;
    let fixed = matches!(run.controller.first_step(), FirstStep::Fixed(_));
    let over = if fixed { total == 0.0 } else { state.t == end };
    Ok(memory.filter(|_| !over).map(|memory| Ready { state, memory, h, origin, total }))
}

/// A lane with a run in it.
struct Occupant<Sys, W, const N: usize> {
    job: Job<Sys, N>,
    watched: W,
}

/// The parameters of the systems in the lanes, in the order of [`Rescale::over`].
struct Parameters<const L: usize>(Vec<[f64; L]>);

impl<const L: usize> Parameters<L> {
    /// Those of `system` in all lanes.
    fn of<Sys: Rescale<N, Scalar = f64>, const N: usize>(system: &Sys) -> Self {
        let mut values = vec![];
        let _ = system.over(|x| {
            values.push([x; L]);
            Lane::<Plain>::new(x)
        });
        Parameters(values)
    }

    /// Gives a lane those of `system`, and what comes of it all: the systems side by side.
    fn put<Sys, P, A, const N: usize>(&mut self, lane: usize, system: &Sys) -> Packed<Sys, P, A, L, N>
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
            Lanes::new(all.unwrap_or([x; L]))
        })
    }
}

impl<Sys, M, C, P, A, W, J, const L: usize, const N: usize> Work for Convoy<'_, Sys, M, C, P, A, W, J, L, N>
where
    Sys: Rescale<N, Scalar = f64>,
    P: Policy,
    A: Processor,
    M: SideBySide<Sys, P, A, L, N>,
    C: LaneController<L, P, A, M::Errors, N>,
    W: Watch<Sys, N>,
    J: Jobs<Sys, W::Output, N>,
{
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Convoy { method, controller, end, watch, jobs, .. } = self;
        let order = <M as Method<Packed<Sys, P, A, L, N>, N>>::order(method);
        let implicit = <M as Method<Packed<Sys, P, A, L, N>, N>>::implicit(method);
        let fixed = matches!(controller.alone().first_step(), FirstStep::Fixed(_));

        // The next run that has a way to go; those that have none, or cannot begin, are done at once.
        let next = |jobs: &mut J| {
            while let Some(job) = jobs.next() {
                let system = job.system.over(Lane::<P, A>::new);
                let start = job.start.map(Lane::new);
                let mut watched = watch.start(&job.system, &job.start);
                if watch.wanted(&watched) == Some(job.start.t) {
                    watch.sample(&mut watched, &job.system, &job.start);
                }
                match ready(&system, method.clone(), controller.alone(), start, Lane::new(end)) {
                    Ok(Some(ready)) => return Some((Occupant { job, watched }, ready)),
                    Ok(None) => {
                        let output = watch.finish(watched, &job.system, &job.start);
                        jobs.done(job.index, Ok(output));
                    }
                    Err(failure) => {
                        let failure = failure.map(Lane::value);
                        jobs.done(job.index, Err(Ended { start: job.start, last: job.start, failure }));
                    }
                }
            }
            None
        };

        let Some((occupant, entry)) = next(jobs) else { return };
        // Lanes that wait for a run compute on a copy of another one's, by steps of size 0.
        let mut parameters = Parameters::of(&occupant.job.system);
        let mut system: Packed<Sys, P, A, L, N> = parameters.put(0, &occupant.job.system);
        let mut state = <State<Lanes<L, P, A>, N> as Lanewise<L>>::splat(&entry.state);
        let mut memory: M::Memories = Lanewise::splat(&entry.memory);
        let mut controllers: [C; L] = core::array::from_fn(|_| controller.clone());
        let mut occupants: [Option<Occupant<Sys, W::Memory, N>>; L] = [const { None }; L];
        let mut live = [false; L];
        // As the fields of `Run`.
        let (mut h, mut origin, mut count, mut total) = ([0.0; L], [0.0; L], [0.0; L], [f64::INFINITY; L]);
        let (mut attempts, mut cause) = ([0u64; L], [None::<Cause>; L]);

        // Puts a run into a lane.
        macro_rules! enter {
            ($lane:expr, $occupant:expr, $entry:expr) => {{
                let (lane, occupant, entry) = ($lane, $occupant, $entry);
                system = parameters.put(lane, &occupant.job.system);
                state.put(lane, &entry.state);
                memory.put(lane, &entry.memory);
                controllers[lane] = controller.clone();
                (h[lane], origin[lane]) = (entry.h.value(), entry.origin.value());
                (count[lane], total[lane]) = (0.0, entry.total);
                (attempts[lane], cause[lane]) = (0, None);
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
                    let (copied, remembered) = (state.lane(other), memory.lane(other));
                    state.put(lane, &copied);
                    memory.put(lane, &remembered);
                }
            }};
        }

        // Ends the run of a lane by a failure.
        macro_rules! fail {
            ($lane:expr, $failure:expr) => {{
                let lane = $lane;
                if let Some(Occupant { job, .. }) = occupants[lane].take() {
                    let last = state.lane(lane).map(Lane::value);
                    jobs.done(job.index, Err(Ended { start: job.start, last, failure: $failure }));
                }
                refill!(lane);
            }};
        }

        let mut first = Some((occupant, entry));
        for lane in 0..L {
            let Some((occupant, entry)) = first.take().or_else(|| next(jobs)) else { break };
            enter!(lane, occupant, entry);
        }

        while live.contains(&true) {
            // Steps of one size in which nothing can happen but motion: no run ends, and nothing is wanted of any. They need no
            // look at each lane; the step in which something does is made below.
            if fixed && !W::STEPS {
                let (mut left, mut due) = (f64::INFINITY, [f64::NAN; L]);
                for i in 0..L {
                    if live[i]
                        && let Some(Occupant { watched, .. }) = &occupants[i]
                    {
                        left = left.min(total[i] - count[i] - 1.0);
                        due[i] = watch.wanted(watched).unwrap_or(f64::NAN);
                    }
                }
                let (steps, origins, due) = (Lanes::new(h), Lanes::new(origin), Lanes::new(due));
                let mut counts = Lanes::<L, P, A>::new(count);
                let mut made = 0.0;
                while made < left {
                    let next = counts + Lanes::one();
                    let t = next.mul_add(steps, origins);
                    if !((t - due) * steps).nowhere_positive_or_zero() {
                        break;
                    }
                    let Ok(step) = method.step(&system, &memory, &state, steps) else { break };
                    let mut sum = Lanes::<L, P, A>::zero();
                    for i in 0..N {
                        sum += step.to.q[i] + step.to.qd[i];
                    }
                    if !sum.all_finite() {
                        break;
                    }
                    state = State { t, q: step.to.q, qd: step.to.qd };
                    memory = step.memory;
                    counts = next;
                    made += 1.0;
                }
                count = counts.to_array();
            }

            let t = *state.t.as_array();
            // The step that is tried, and whether it lands on the end.
            let (mut tried, mut lands) = (h, [false; L]);
            if !fixed {
                let mut stuck = false;
                for i in 0..L {
                    let rest = end - t[i];
                    lands[i] = h[i] * 1.01 / rest >= 1.0;
                    tried[i] = if lands[i] { rest } else { h[i] };
                    stuck |=
                        live[i] & ((!lands[i] & (t[i] + h[i] * 0.1 == t[i])) | (attempts[i] >= MAX_STEPS));
                }
                if stuck {
                    for i in 0..L {
                        if live[i] && attempts[i] >= MAX_STEPS {
                            let (t, h) = (t[i], h[i]);
                            fail!(i, Failure::BudgetUsedUp { t, h, max_steps: MAX_STEPS, implicit });
                        } else if live[i] && !lands[i] && t[i] + h[i] * 0.1 == t[i] {
                            fail!(i, Failure::StepSizeUnderflow { t: t[i], h: h[i], cause: cause[i] });
                        }
                    }
                    continue;
                }
                for i in 0..L {
                    attempts[i] += 1;
                }
            }

            let Ok(mut step) = method.step(&system, &memory, &state, Lanes::new(tried)) else {
                // No explicit method has anything to fail at.
                for i in 0..L {
                    if live[i] {
                        fail!(i, Failure::NonFinite { t: t[i], h: tried[i] });
                    }
                }
                continue;
            };

            // What becomes of it, lane by lane.
            let mut sum = Lanes::<L, P, A>::zero();
            for i in 0..N {
                sum += step.to.q[i] + step.to.qd[i];
            }
            let squares = controller.squares(&state, &step.to, &step.error);
            let (mut accepted, mut factor) = (live, [1.0; L]);
            let mut broken = false;
            for i in 0..L {
                let finite = sum.as_array()[i] * 0.0 == 0.0;
                broken |= live[i] & !finite;
                if finite {
                    match controllers[i].decide(squares[i], order) {
                        Verdict::Accept { factor: next } => factor[i] = next,
                        Verdict::Reject { factor: next } => (factor[i], accepted[i]) = (next, false),
                    }
                } else {
                    accepted[i] = false;
                }
                if live[i] && finite && !accepted[i] {
                    cause[i] = None;
                }
            }
            let mut failed = [false; L];
            if broken {
                for i in 0..L {
                    if live[i] && sum.as_array()[i] * 0.0 != 0.0 {
                        cause[i] = Some(Cause::NonFinite);
                        match controllers[i].after_failure() {
                            Some(next) => factor[i] = next,
                            None => failed[i] = true,
                        }
                    }
                }
            }

            // Time, and the next step.
            let mut arrived = [false; L];
            let mut any = false;
            for i in 0..L {
                let to = step.to.t.as_mut();
                if fixed {
                    count[i] += 1.0;
                    arrived[i] = accepted[i] & (count[i] >= total[i]);
                    to[i] = if count[i] == total[i] { end } else { P::mul_add(count[i], h[i], origin[i]) };
                } else {
                    to[i] = if lands[i] { end } else { to[i] };
                    arrived[i] = accepted[i] & (to[i] == end);
                    let next = tried[i] * factor[i];
                    // A step cut short by the end says little about the one after it.
                    let longer = next.abs() > h[i].abs();
                    let next = if accepted[i] & lands[i] & !longer { h[i] } else { next };
                    h[i] = if live[i] { next } else { 0.0 };
                }
                any |= arrived[i] | failed[i];
            }

            // What is wanted of it.
            if W::STEPS {
                for i in 0..L {
                    if accepted[i]
                        && let Some(Occupant { job, watched }) = &mut occupants[i]
                    {
                        let (from, to) = (state.lane(i).map(Lane::value), step.to.lane(i).map(Lane::value));
                        watch.step(watched, &job.system, &from, &to);
                    }
                }
            }
            let mut dense = None;
            loop {
                let (mut times, mut wanted) = (step.to.t, [false; L]);
                for i in 0..L {
                    if accepted[i]
                        && let Some(Occupant { watched, .. }) = &occupants[i]
                        && let Some(time) = watch.wanted(watched)
                    {
                        let ahead = if tried[i] < 0.0 {
                            step.to.t.as_array()[i] - time
                        } else {
                            time - step.to.t.as_array()[i]
                        };
                        if ahead <= 0.0 {
                            (times.as_mut()[i], wanted[i]) = (time, true);
                        }
                    }
                }
                if !wanted.contains(&true) {
                    break;
                }
                let between = dense.get_or_insert_with(|| method.dense(&system, &step)).at(times);
                for i in 0..L {
                    if wanted[i]
                        && let Some(Occupant { job, watched }) = &mut occupants[i]
                    {
                        let ends = times.as_array()[i] == step.to.t.as_array()[i];
                        let at = if ends { step.to.lane(i) } else { between.lane(i) };
                        watch.sample(watched, &job.system, &at.map(Lane::value));
                    }
                }
            }

            for i in 0..L {
                cause[i] = if accepted[i] { None } else { cause[i] };
            }
            state.take(&accepted, &step.to);
            memory.take(&accepted, &step.memory);
            if any {
                for i in 0..L {
                    if failed[i] {
                        fail!(i, Failure::NonFinite { t: t[i], h: tried[i] });
                    } else if arrived[i] {
                        if let Some(Occupant { job, watched }) = occupants[i].take() {
                            let last = state.lane(i).map(Lane::value);
                            jobs.done(job.index, Ok(watch.finish(watched, &job.system, &last)));
                        }
                        refill!(i);
                    }
                }
            }
        }
    }
}
