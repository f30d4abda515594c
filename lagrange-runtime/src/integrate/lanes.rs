//! The time loop of lanes: many runs side by side, each with its own time, step and end, with the same bits as alone.
//!
//! What happens once in a run (checks, first step) is done by a [`Run`](super::Run) of the lane alone. What happens
//! in each step is done for all lanes at once, and decided by the rules of runs (`integrate/rules.rs`). A lane whose
//! run ends, well or not, takes the next one.
//!
//! `lanes/job.rs` has what is to be done, `lanes/pack.rs` the lanes and the runs in them, `lanes/convoy.rs` their
//! loop, `lanes/round.rs` one step of all of them, `lanes/course.rs` the motion within their steps.

use crate::controller::Controller;
use crate::lanes::{LaneController, Lanewise, Level, Observer, Policy, Processor, Rescale};
use crate::method::Method;
use convoy::Convoy;
use job::{Alone, ErrorOf, LANES, MemoryOf, Packed};
pub use job::{Bounds, Job, Jobs};

mod convoy;
mod course;
mod job;
mod pack;
mod round;

/// Methods that run in lanes. In those that iterate until a condition holds (Gauss, variational, Radau, projection;
/// and constraints do) a lane waits for its neighbours.
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

/// Variant of [`InLanes`] for one kind of processor.
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
            Error = <ErrorOf<M, Sys, P, A, N> as Lanewise<LANES>>::Element,
            MethodState = <MemoryOf<M, Sys, P, A, N> as Lanewise<LANES>>::Element,
        >,
    C: LaneController<LANES, P, A, ErrorOf<M, Sys, P, A, N>, N>,
{
    fn runs_on<W: Observer<Sys, N>, J: Jobs<Sys, W::Output, N>>(
        &self,
        controller: &C,
        bounds: Bounds,
        watch: &W,
        jobs: &mut J,
    ) {
        let alone = controller.alone();
        let tolerance =
            Controller::<_, N, <ErrorOf<M, Sys, P, A, N> as Lanewise<LANES>>::Element>::relative_tolerance(
                &alone,
            );
        let method = Method::<Alone<Sys, P, A, N>, N>::for_tolerance(self.clone(), tolerance);
        A::call(Convoy::<Sys, M, C, P, A, W, J, N>::new(&method, controller, bounds, watch, jobs));
    }
}
