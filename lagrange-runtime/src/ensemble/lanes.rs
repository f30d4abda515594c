//! Ensembles in lanes: eight trajectories side by side on each thread.

use super::drive::{Compute, Part, samples};
use super::{FailedSample, LEAF, Outcome, Recipe, Record, Replay, Source, Statistic, Study};
use crate::controller::Controller;
use crate::ensemble::EnsembleError;
use crate::failed::{Failed, Statistics};
use crate::failure::Failure;
use crate::integrate::integrate;
use crate::integrate::lanes::{Bounds, InLanes, Job, Jobs};
use crate::lanes::{LaneController, Lanewise, Level, Observer, Policy, Rescale, SingleLane};
use crate::method::Method;
use crate::state::State;
use crate::system::System;
use core::fmt;
use core::marker::PhantomData;
use core::ops::Range;
use std::path::PathBuf;

/// A [`Study`] whose samples are computed in lanes, under an arithmetic policy, made by [`Study::in_lanes`].
/// Everything said there about threads, checkpoints, shards and failures holds.
///
/// Each lane is on its own: it has its own time, steps and parameters, accepts and rejects for itself, and takes the
/// next sample when it is done. So a sample has the same bits in whatever company it is computed, or alone. One that
/// meets a position in which constraints are dependent has those of its ordinary run, which goes through it.
pub struct LaneStudy<'p, Src, D, Sys: System<N>, M, C, P, const N: usize> {
    pub(super) study: Study<'p, Src, D, Sys, M, C, N>,
    level: Level,
    policy: PhantomData<fn() -> P>,
}

impl<Src, D, Sys, M, C, const N: usize> Study<'_, Src, D, Sys, M, C, N>
where
    Src: Source,
    Sys: System<N, Scalar = f64>,
    M: Method<Sys, N> + Clone + Sync + fmt::Debug,
    C: Controller<f64, N, M::Error> + Sync + fmt::Debug,
    D: Fn(Src::Draw) -> (Sys, State<f64, N>) + Sync,
{
    /// Runs all samples, and returns the `statistic` of the outputs of the observer `watch`: as
    /// [`reduce`](Self::reduce) by `|_, run| Ok(run.observe(watch)?)`. The same call serves a study [in
    /// lanes](Self::in_lanes).
    ///
    /// # Errors
    /// As [`reduce`](Self::reduce).
    pub fn observe<W, T>(&self, watch: &W, statistic: T) -> Result<Outcome<T::State, f64, N>, EnsembleError>
    where
        W: Observer<Sys, N> + Sync,
        T: Statistic<W::Output>,
    {
        self.reduce(|_, run| Ok(run.observe(watch)?), statistic)
    }
}

impl<'p, Src, D, Sys, M, C, const N: usize> Study<'p, Src, D, Sys, M, C, N>
where
    Src: Source,
    Sys: Rescale<N, Scalar = f64>,
    M: Method<Sys, N> + Clone + Sync + fmt::Debug,
    C: Controller<f64, N, M::Error> + Sync + fmt::Debug,
    D: Fn(Src::Draw) -> (Sys, State<f64, N>) + Sync,
{
    /// The same study, computed in lanes with the vector instructions that the processor has.
    ///
    /// The policy says how `a b + c` is rounded, and with that fixes every bit of the answer:
    /// [`Fused`](crate::lanes::Fused) and [`Plain`](crate::lanes::Plain) give different last bits, and each gives the
    /// same ones on every machine. Where all processors are from 2013 or later, `Fused` is the faster one.
    ///
    /// ```
    /// use lagrange_runtime::ensemble::{Ensemble, Moments, Random, rand_distr::{Distribution, Normal}};
    /// use lagrange_runtime::lanes::{FinalState, Fused};
    /// use lagrange_runtime::prelude::*;
    /// lagrangian! {
    ///     pub system Pendulum {
    ///         param m, l, g = 9.81;
    ///         coord theta;
    ///         T = 0.5 * m * (l * dot(theta)).powi(2);
    ///         V = -m * g * l * cos(theta);
    ///     }
    /// }
    /// let release = Normal::new(1.0, 0.1)?;
    /// let study = Ensemble::new(Random::seed(1), 500, |mut rng| {
    ///     (Pendulum::new(1.0, 0.85), State::new(0.0, [release.sample(&mut rng)], [0.0]))
    /// })
    /// .integrate(Dop853, PiController::tolerance(1e-9), 10.0)
    /// .in_lanes(Fused);
    /// let outcome = study.observe(&FinalState(|_: &Pendulum, end: &State<f64, 1>| end.q[0]), Moments)?;
    /// assert_eq!(outcome.statistic.count(), 500);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn in_lanes<P: Policy>(self, policy: P) -> LaneStudy<'p, Src, D, Sys, M, C, P, N>
    where
        M: InLanes<Sys, C, P, N>,
    {
        let _ = policy;
        LaneStudy { study: self, level: Level::best(), policy: PhantomData }
    }
}

impl<Src, D, Sys, M, C, P, const N: usize> LaneStudy<'_, Src, D, Sys, M, C, P, N>
where
    Src: Source,
    Sys: Rescale<N, Scalar = f64>,
    M: Method<Sys, N> + Clone + Sync + fmt::Debug + InLanes<Sys, C, P, N>,
    C: Controller<f64, N, M::Error> + Sync + fmt::Debug,
    D: Fn(Src::Draw) -> (Sys, State<f64, N>) + Sync,
    P: Policy,
{
    /// Uses the instructions of processors of this kind, instead of the best that this one has. The answer does not
    /// depend on it. Builds with debug assertions have those of the least processor only, which makes them compile
    /// three times as fast.
    ///
    /// # Panics
    /// When the study is run, if the processor is not of that kind.
    #[must_use]
    pub fn level(self, level: Level) -> Self {
        LaneStudy { level, ..self }
    }

    /// Runs all samples, and returns the `statistic` of the outputs of the observer `watch`, as [`Study::observe`].
    ///
    /// # Errors
    /// As [`Study::reduce`].
    pub fn observe<W, T>(&self, watch: &W, statistic: T) -> Result<Outcome<T::State, f64, N>, EnsembleError>
    where
        W: Observer<Sys, N> + Sync,
        T: Statistic<W::Output>,
    {
        self.study.by(&self.side_by_side(watch), &statistic)
    }

    /// Reduces as [`observe`](Self::observe), and hands each output to `sink`, as [`Study::stream`].
    ///
    /// # Errors
    /// As [`Study::stream`].
    pub fn stream<W, T>(
        &self,
        watch: &W,
        statistic: T,
        sink: impl FnMut(u64, &W::Output) -> Result<(), EnsembleError>,
    ) -> Result<Outcome<T::State, f64, N>, EnsembleError>
    where
        W: Observer<Sys, N, Output: Record + Clone + Send> + Sync,
        T: Statistic<W::Output>,
    {
        self.study.streamed(&self.side_by_side(watch), statistic, sink)
    }

    /// Reduces as [`observe`](Self::observe), on all ranks of MPI, as [`Study::reduce_on_ranks`].
    ///
    /// # Errors
    /// As [`Study::reduce_on_ranks`].
    #[cfg(feature = "mpi")]
    pub fn reduce_on_ranks<W, T>(
        &self,
        world: &impl ::mpi::traits::Communicator,
        watch: &W,
        statistic: T,
    ) -> Result<Option<Outcome<T::State, f64, N>>, EnsembleError>
    where
        W: Observer<Sys, N> + Sync,
        T: Statistic<W::Output>,
    {
        self.study.on_ranks(world, &self.side_by_side(watch), &statistic)
    }

    /// Puts shards together, as [`Study::merge`].
    ///
    /// # Errors
    /// As [`Study::merge`].
    pub fn merge<W, T>(
        &self,
        shards: impl IntoIterator<Item = impl Into<PathBuf>>,
        watch: &W,
        statistic: T,
    ) -> Result<Outcome<T::State, f64, N>, EnsembleError>
    where
        W: Observer<Sys, N> + Sync,
        T: Statistic<W::Output>,
    {
        self.study.merged(&self.side_by_side(watch), shards, &statistic)
    }

    /// One sample alone, as [`Study::replay`]: all steps of its run, with the bits it has in its lane.
    ///
    /// # Errors
    /// If there is no such sample.
    #[allow(clippy::type_complexity)]
    pub fn replay<E>(
        &self,
        index: u64,
    ) -> Result<
        Replay<
            Sys::Over<SingleLane<P>>,
            M,
            <C as LaneController<8, P, crate::lanes::Baseline, E, N>>::Alone,
            N,
        >,
        EnsembleError,
    >
    where
        E: Lanewise<8>,
        C: LaneController<8, P, crate::lanes::Baseline, E, N>,
        M: Method<Sys::Over<SingleLane<P>>, N, Error = E::Element>,
        M: Method<Sys::Over<crate::lanes::Lanes<8, P>>, N, Error = E>,
    {
        let Replay { system, start, method, controller, end, max_steps, .. } = self.study.replay(index)?;
        Ok(Replay {
            index,
            system: system.over(SingleLane::new),
            start: start.map(SingleLane::new),
            method,
            controller: controller.alone(),
            end: SingleLane::new(end),
            max_steps,
        })
    }

    pub(super) fn side_by_side<'a, W>(&'a self, watch: &'a W) -> SideBySide<'a, Src, D, Sys, M, C, P, W, N> {
        SideBySide { recipe: &self.study.recipe, level: self.level, watch, policy: PhantomData }
    }
}

/// Samples that are computed in lanes.
pub(super) struct SideBySide<'a, Src, D, Sys: System<N>, M, C, P, W, const N: usize> {
    recipe: &'a Recipe<Src, D, Sys, M, C, N>,
    level: Level,
    watch: &'a W,
    policy: PhantomData<fn() -> P>,
}

/// Samples of a range, and what came of them.
struct Samples<'a, Src, D, Sys: System<N, Scalar = f64>, M, C, W: Observer<Sys, N>, const N: usize> {
    recipe: &'a Recipe<Src, D, Sys, M, C, N>,
    watch: &'a W,
    first: u64,
    next: Range<u64>,
    outputs: Vec<Option<Result<W::Output, FailedSample<f64, N>>>>,
}

impl<Src, D, Sys, M, C, W, const N: usize> Samples<'_, Src, D, Sys, M, C, W, N>
where
    Src: Source,
    Sys: System<N, Scalar = f64>,
    M: Method<Sys, N> + Clone,
    C: Controller<f64, N, M::Error>,
    D: Fn(Src::Draw) -> (Sys, State<f64, N>) + Sync,
    W: Observer<Sys, N>,
{
    /// A sample by its ordinary run.
    #[cold]
    #[inline(never)]
    fn alone(&self, index: u64) -> Result<W::Output, Failed<f64, N>> {
        let Recipe { ensemble, method, controller, end, max_steps, .. } = self.recipe;
        let (system, start) = (ensemble.draw)(ensemble.source.draw(index));
        let run = integrate(&system, method.clone(), controller.clone(), start).until(*end);
        let run = match *max_steps {
            Some(max_steps) => run.max_steps(max_steps),
            None => run,
        };
        run.observe(self.watch)
    }
}

impl<Src, D, Sys, M, C, W, const N: usize> Jobs<Sys, W::Output, N> for Samples<'_, Src, D, Sys, M, C, W, N>
where
    Src: Source,
    Sys: System<N, Scalar = f64>,
    M: Method<Sys, N> + Clone,
    C: Controller<f64, N, M::Error>,
    D: Fn(Src::Draw) -> (Sys, State<f64, N>) + Sync,
    W: Observer<Sys, N>,
{
    fn next(&mut self) -> Option<Job<Sys, N>> {
        let index = self.next.next()?;
        let ensemble = &self.recipe.ensemble;
        let (system, start) = (ensemble.draw)(ensemble.source.draw(index));
        Some(Job { index, system, start })
    }

    fn done(&mut self, index: u64, _: Statistics, mut output: Result<W::Output, Failed<f64, N>>) {
        // Lanes do not go through states at which constraints are dependent.
        if const { Sys::CONSTRAINTS > 0 }
            && let Err(Failed { failure, .. }) = &output
            && matches!(failure, Failure::DependentConstraints { .. } | Failure::Bifurcation { .. })
        {
            output = self.alone(index);
        }
        let failed = |Failed { start, last, statistics, failure }| FailedSample {
            index,
            start,
            last: Some(last),
            statistics: Some(statistics),
            failure,
        };
        if let Some(place) = self.outputs.get_mut((index - self.first) as usize) {
            *place = Some(output.map_err(failed));
        }
    }
}

impl<Src, D, Sys, M, C, P, W, const N: usize> SideBySide<'_, Src, D, Sys, M, C, P, W, N>
where
    Src: Source,
    Sys: Rescale<N, Scalar = f64>,
    M: Method<Sys, N> + Clone + InLanes<Sys, C, P, N>,
    C: Controller<f64, N, M::Error>,
    D: Fn(Src::Draw) -> (Sys, State<f64, N>) + Sync,
    P: Policy,
    W: Observer<Sys, N>,
{
    /// Outputs or failures of these samples.
    fn outputs(&self, range: Range<u64>) -> Vec<Option<Result<W::Output, FailedSample<f64, N>>>> {
        let outputs = range.clone().map(|_| None).collect();
        let Recipe { method, controller, end, max_steps, .. } = self.recipe;
        let bounds = Bounds { end: *end, max_steps: *max_steps };
        let mut jobs =
            Samples { recipe: self.recipe, watch: self.watch, first: range.start, next: range, outputs };
        method.runs(self.level, controller, bounds, self.watch, &mut jobs);
        jobs.outputs
    }
}

impl<Src, D, Sys, M, C, P, W, const N: usize> Compute<W::Output>
    for SideBySide<'_, Src, D, Sys, M, C, P, W, N>
where
    Src: Source,
    Sys: Rescale<N, Scalar = f64>,
    M: Method<Sys, N> + Clone + InLanes<Sys, C, P, N> + Sync,
    C: Controller<f64, N, M::Error> + Sync,
    D: Fn(Src::Draw) -> (Sys, State<f64, N>) + Sync,
    P: Policy,
    W: Observer<Sys, N> + Sync,
{
    /// Number of leaves in a group. At its end lanes run empty, for about half a trajectory: of 512 samples, 64 per
    /// lane, this costs a hundredth.
    const GROUP: u64 = 16;

    type Failed = FailedSample<f64, N>;

    fn leaves<T: Statistic<W::Output>>(
        &self,
        leaves: Range<u64>,
        statistic: &T,
    ) -> Vec<Part<T::State, Self::Failed>> {
        let range = samples(leaves.clone(), self.recipe.ensemble.samples);
        let mut outputs = (range.start..).zip(self.outputs(range));
        leaves
            .map(|_| {
                let (mut state, mut failed) = (statistic.empty(), vec![]);
                for (index, output) in outputs.by_ref().take(LEAF as usize) {
                    match output {
                        Some(Ok(output)) => statistic.add(&mut state, index, &output),
                        Some(Err(failure)) => failed.push(failure),
                        None => unreachable!("sample {index} has entered a lane and not left it"),
                    }
                }
                (state, failed)
            })
            .collect()
    }

    fn failure(&self, index: u64) -> Option<FailedSample<f64, N>> {
        self.outputs(index..index + 1).pop().flatten()?.err()
    }

    fn describe(&self) -> Option<String> {
        Some(format!("in lanes, {} multiply-adds", if P::FUSED { "fused" } else { "rounded" }))
    }
}
