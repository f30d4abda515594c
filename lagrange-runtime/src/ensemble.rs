//! Ensembles: what many trajectories have in common, when their starts and parameters are uncertain.
//!
//! Four plain pieces, each of which can be exchanged:
//!
//! - a [`Source`], from which each sample is drawn by its index alone: [`Random`] numbers for any distribution, points
//!   of a scrambled [`Sobol`] sequence, or a [`Table`];
//! - a function from such a draw to a system and its start;
//! - a function that watches the [`Run`] of a sample and returns its output: the last state,
//!   [samples](Run::sample), times of [events](Run::events), a maximum over the steps;
//! - a [`Statistic`] that keeps what the study needs of these outputs, and no more: [`Moments`], [`Covariance`],
//!   [`Histogram`], [`Quantiles`], [`Extrema`], tuples of them, or all outputs by [`Collect`].
//!
//! How far a pendulum has swung after ten seconds, if its release is known to a tenth of a radian only:
//!
//! ```
//! use lagrange_runtime::ensemble::{Ensemble, Moments, Random, rand_distr::{Distribution, Normal}};
//! use lagrange_runtime::prelude::*;
//!
//! lagrangian! {
//!     pub system Pendulum {
//!         param m, l, g = 9.81;
//!         coord theta;
//!         T = 0.5 * m * (l * dot(theta)).powi(2);
//!         V = -m * g * l * cos(theta);
//!     }
//! }
//!
//! let release = Normal::new(1.0, 0.1)?;
//! let study = Ensemble::new(Random::seed(1), 500, |mut rng| {
//!     (Pendulum::new(1.0, 0.85), State::new(0.0, [release.sample(&mut rng)], [0.0]))
//! })
//! .integrate(Dop853, PiController::tolerance(1e-9), 10.0);
//!
//! let outcome = study.reduce(|_, run| Ok(run.final_state()?.q[0]), Moments)?;
//! let angle = outcome.statistic;
//! println!("θ = {:.3} ± {:.3}", angle.mean(), angle.standard_deviation());
//! # assert_eq!((angle.count(), outcome.failures.count), (500, 0));
//! # assert!(angle.mean().abs() < 1.0 && (0.1..1.0).contains(&angle.standard_deviation()));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Further studies
//!
//! | wanted | study |
//! |---|---|
//! | a mean to a given accuracy | [`Study::observe_until`] with [`HalfWidth`] |
//! | the same, with the help of a cheap model | [`Multifidelity`] |
//! | which input decides | [`SobolIndices`] |
//! | the probability of a rare event | [`SubsetSimulation`] |
//! | which terms a scene needs | [`Proper`] |
//! | whether a simplified model is good enough | [`Certification`] |
//!
//! These take [`Model`]s: a [`Simulation`], alone or in lanes, or a [`ClosedForm`].
//!
//! # What the answer depends on
//!
//! On the study, and on nothing else: not on the number of threads, on what they were given when, or on
//! interruptions. The answer has the same bits on one thread and on many. A sample depends on the source and its
//! index. Samples are fed to the statistic in *leaves* of [`LEAF`] neighbours, in their order; leaves are merged in
//! theirs, two and two, as the digits of a binary counter are carried. That tree is part of the definition of the
//! answer; it follows from the number of samples. (Another processor, compiler or standard library may differ in the
//! last bits of sines and cosines, and so may the answer.)
//!
//! # Failures
//!
//! A sample that fails takes no other down. It is counted, and the first ones are kept with their start, last state
//! and [`Failure`](crate::Failure); the statistics are those of the others. A start that is not finite is such a
//! failure. A run that failed is one even if the function that watches it returns an output, as
//! `run.flatten().last()` does, unless it says [`Run::failure_as_outcome`]. [`Study::replay`] runs any sample again
//! alone, all its steps.
//!
//! # Long runs
//!
//! [`Study::checkpoint`] keeps how far the study has come in a file. If the program is killed, at whatever moment, and
//! started again, the study resumes there, and its result has the same bits as without the interruption.

use crate::controller::Controller;
use crate::failed::Failed;
use crate::integrate::{Run, integrate};
use crate::method::Method;
use crate::scalar::Real;
use crate::state::State;
use crate::system::System;
use checkpoint::{Checkpoint, Reached};
use core::fmt;
use core::marker::PhantomData;
use core::ops::Range;
use drive::{Compute, Course, Driver, Part, Tell, Through, samples};
use std::path::PathBuf;
use std::sync::OnceLock;
use std::time::Duration;

mod certificate;
mod checkpoint;
mod distribution;
mod drive;
mod error;
mod failures;
mod file;
mod indices;
mod integration;
mod lanes;
mod model;
mod multifidelity;
mod normal;
#[cfg(feature = "parquet")]
mod parquet;
mod precision;
mod progress;
mod proper;
#[cfg(feature = "mpi")]
mod ranks;
mod rare;
mod record;
mod settings;
mod sobol;
mod source;
mod statistic;
mod stopwatch;
mod tree;

pub use certificate::{Certificate, Certification, NotCertified, Worst, samples_for};
pub use error::EnsembleError;
pub use failures::{FailedSample, Failures, Lost};
pub use indices::{Index, Indices, SobolIndices};
pub use integration::{Candidate, Integration, Integrations};
pub use lanes::LaneStudy;
pub use model::{ClosedForm, Evaluated, LaneSimulation, Mapped, Model, Simulation};
pub use multifidelity::{
    Allocation, FailedEvaluation, Multifidelity, MultifidelityEstimate, Pilot, QuantileEstimate,
};
pub use normal::normal_quantile;
#[cfg(feature = "parquet")]
pub use parquet::Parquet;
pub use precision::HalfWidth;
pub use progress::Progress;
pub use proper::{Move, Proper, ProperModel};
pub use rand_distr;
pub use rare::{RareEvent, SubsetLevel, SubsetRun, SubsetSimulation};
pub use record::Record;
pub use source::{Random, Sobol, Source, Table};
pub use statistic::{
    Collect, Collected, Columns, ConfidenceInterval, Counts, Covariance, Covariances, Each, Extrema, Extreme,
    Extremes, Frequency, Histogram, Lifetime, Lifetimes, Moment, Moments, Of, Present, Probability,
    Quantiles, Sketch, Statistic, Survival, Surviving, of,
};
pub use tree::LEAF;

/// Samples that fail and are kept unless told otherwise.
const KEPT: usize = 1000;

/// Samples of a study: their source, their number, and the function that turns each draw into a system and its start.
#[derive(Clone, Debug)]
pub struct Ensemble<Src, D> {
    source: Src,
    samples: u64,
    draw: D,
}

impl<Src: Source, D> Ensemble<Src, D> {
    /// `samples` samples; `draw` turns each draw of the source into a system and its start. It has to be a pure
    /// function.
    pub fn new<Sys, const N: usize>(source: Src, samples: u64, draw: D) -> Self
    where
        Sys: System<N>,
        D: Fn(Src::Draw) -> (Sys, State<Sys::Scalar, N>) + Sync,
    {
        Ensemble { source, samples, draw }
    }

    /// Each sample is integrated by this method to the time `t = end`.
    pub fn integrate<'p, Sys, M, C, const N: usize>(
        self,
        method: M,
        controller: C,
        end: Sys::Scalar,
    ) -> Study<'p, Src, D, Sys, M, C, N>
    where
        Sys: System<N>,
        Sys::Scalar: Real,
        M: Method<Sys, N>,
        C: Controller<Sys::Scalar, N, M::Error>,
        D: Fn(Src::Draw) -> (Sys, State<Sys::Scalar, N>) + Sync,
    {
        Study {
            recipe: Recipe { ensemble: self, method, controller, end, max_steps: None, system: PhantomData },
            name: String::new(),
            threads: None,
            checkpoint: None,
            progress: None,
            keep_failures: KEPT,
            shard: None,
        }
    }
}

/// Recipe that makes a run of an index.
struct Recipe<Src, D, Sys: System<N>, M, C, const N: usize> {
    ensemble: Ensemble<Src, D>,
    method: M,
    controller: C,
    end: Sys::Scalar,
    max_steps: Option<u64>,
    system: PhantomData<fn() -> Sys>,
}

/// An ensemble with a method: it can be [reduced](Self::reduce) to statistics, or [replayed](Self::replay) one by one.
pub struct Study<'p, Src, D, Sys: System<N>, M, C, const N: usize> {
    recipe: Recipe<Src, D, Sys, M, C, N>,
    name: String,
    threads: Option<usize>,
    checkpoint: Option<Checkpoint>,
    progress: Option<Tell<'p>>,
    keep_failures: usize,
    /// Index of the shard, and number of shards.
    shard: Option<(u64, u64)>,
}

/// Result of a study.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome<T, S, const N: usize> {
    /// The statistic of the outputs.
    pub statistic: T,
    /// The number of samples, failed ones included.
    pub samples: u64,
    /// The samples that failed.
    pub failures: Failures<S, N>,
}

/// One sample of a study, alone.
#[derive(Clone, Debug)]
pub struct Replay<Sys: System<N>, M, C, const N: usize> {
    /// Its index.
    pub index: u64,
    /// Its system.
    pub system: Sys,
    /// Its start.
    pub start: State<Sys::Scalar, N>,
    method: M,
    controller: C,
    end: Sys::Scalar,
    max_steps: Option<u64>,
}

impl<Sys, M, C, const N: usize> Replay<Sys, M, C, N>
where
    Sys: System<N>,
    Sys::Scalar: Real,
    M: Method<Sys, N> + Clone,
    C: Controller<Sys::Scalar, N, M::Error>,
{
    /// The run of the sample, with all its steps: the same bits as in the study.
    pub fn run(&self) -> Run<'_, Sys, M, C, N> {
        let run =
            integrate(&self.system, self.method.clone(), self.controller.clone(), self.start).until(self.end);
        match self.max_steps {
            Some(max_steps) => run.max_steps(max_steps),
            None => run,
        }
    }
}

impl<Src, D, Sys, M, C, const N: usize> Recipe<Src, D, Sys, M, C, N>
where
    Src: Source,
    Sys: System<N>,
    Sys::Scalar: Real,
    M: Method<Sys, N> + Clone,
    C: Controller<Sys::Scalar, N, M::Error>,
    D: Fn(Src::Draw) -> (Sys, State<Sys::Scalar, N>) + Sync,
{
    fn replay(&self, index: u64) -> Replay<Sys, M, C, N> {
        let (system, start) = (self.ensemble.draw)(self.ensemble.source.draw(index));
        let (method, controller) = (self.method.clone(), self.controller.clone());
        Replay { index, system, start, method, controller, end: self.end, max_steps: self.max_steps }
    }

    fn check(&self) -> Result<(), EnsembleError> {
        if self.ensemble.samples == 0 {
            return Err(EnsembleError::NoSamples);
        }
        self.ensemble.source.check(self.ensemble.samples)
    }
}

/// A course that hands each leaf on.
struct Handing<F>(F);

impl<T, F: FnMut(&mut T) -> Result<(), EnsembleError>> Course<T> for Handing<F> {
    fn each(&mut self, leaf: &mut T) -> Result<(), EnsembleError> {
        (self.0)(leaf)
    }
}

/// Samples that are computed one by one, each by a [`Run`].
struct OneByOne<'a, Src, D, Sys: System<N>, M, C, K, const N: usize> {
    recipe: &'a Recipe<Src, D, Sys, M, C, N>,
    watch: &'a K,
}

impl<Src, D, Sys, M, C, K, const N: usize> OneByOne<'_, Src, D, Sys, M, C, K, N>
where
    Src: Source,
    Sys: System<N>,
    Sys::Scalar: Real,
    M: Method<Sys, N> + Clone,
    C: Controller<Sys::Scalar, N, M::Error>,
    D: Fn(Src::Draw) -> (Sys, State<Sys::Scalar, N>) + Sync,
{
    fn output<O>(&self, index: u64) -> Result<O, FailedSample<Sys::Scalar, N>>
    where
        K: Fn(&Sys, Run<'_, Sys, M, C, N>) -> Result<O, Lost<Sys::Scalar, N>>,
    {
        let sample = self.recipe.replay(index);
        let failed = OnceLock::new();
        let witness = |failure: Failed<Sys::Scalar, N>| _ = failed.set(failure);
        let output = (self.watch)(&sample.system, sample.run().witnessed(&witness));
        let output = match failed.get() {
            // An output of a run that failed is what `run.flatten()` makes of it.
            Some(failed) if output.is_ok() => Err(Lost::from(*failed)),
            _ => output,
        };
        let start = sample.start;
        output.map_err(|Lost { failure, last, statistics }| FailedSample {
            index,
            start,
            last,
            statistics,
            failure,
        })
    }
}

impl<O, Src, D, Sys, M, C, K, const N: usize> Compute<O> for OneByOne<'_, Src, D, Sys, M, C, K, N>
where
    Src: Source,
    Sys: System<N>,
    Sys::Scalar: Real + Send,
    M: Method<Sys, N> + Clone + Sync,
    C: Controller<Sys::Scalar, N, M::Error> + Sync,
    D: Fn(Src::Draw) -> (Sys, State<Sys::Scalar, N>) + Sync,
    K: Fn(&Sys, Run<'_, Sys, M, C, N>) -> Result<O, Lost<Sys::Scalar, N>> + Sync,
{
    const GROUP: u64 = 1;

    type Failed = FailedSample<Sys::Scalar, N>;

    fn leaves<T: Statistic<O>>(
        &self,
        leaves: Range<u64>,
        statistic: &T,
    ) -> Vec<Part<T::State, Self::Failed>> {
        leaves
            .map(|leaf| {
                let (mut state, mut failed) = (statistic.empty(), vec![]);
                for index in samples(leaf..leaf + 1, self.recipe.ensemble.samples) {
                    match self.output(index) {
                        Ok(output) => statistic.add(&mut state, index, &output),
                        Err(failure) => failed.push(failure),
                    }
                }
                (state, failed)
            })
            .collect()
    }

    fn failure(&self, index: u64) -> Option<FailedSample<Sys::Scalar, N>> {
        self.output(index).err()
    }
}

impl<'p, Src, D, Sys, M, C, const N: usize> Study<'p, Src, D, Sys, M, C, N>
where
    Src: Source,
    Sys: System<N>,
    Sys::Scalar: Real + Send + Sync,
    M: Method<Sys, N> + Clone + Sync + fmt::Debug,
    C: Controller<Sys::Scalar, N, M::Error> + Sync + fmt::Debug,
    D: Fn(Src::Draw) -> (Sys, State<Sys::Scalar, N>) + Sync,
{
    /// Sets the number of threads, by default that of processors, for which 0 stands too. The answer does not depend
    /// on it.
    #[must_use]
    pub fn threads(self, threads: usize) -> Self {
        Study { threads: Some(threads), ..self }
    }

    /// Fails a sample by [`Failure::BudgetUsedUp`](crate::Failure::BudgetUsedUp) if `max_steps` steps, accepted or
    /// not, do not suffice, alone and in lanes, as [`Run::max_steps`].
    #[must_use]
    pub fn max_steps(mut self, max_steps: u64) -> Self {
        self.recipe.max_steps = Some(max_steps);
        self
    }

    /// Begins all samples with a step that the sample of this index has reached.
    ///
    /// An automatic first step is a cautious guess, and the steps after it grow by at most a factor each: a short run
    /// spends a third of its steps on that. Here one run tells how long they become: the first of its steps after which
    /// they grow by less than a half. Errors are controlled as before, and a sample for which the step is too long
    /// shortens it. The answer depends on the index, and neither on threads nor on lanes. (A step that is known may be
    /// given to the controller instead, [`PiController::first_step`](crate::PiController::first_step).)
    ///
    /// # Errors
    /// If there is no such sample, its run fails before or makes no step, or the controller has no first step: steps
    /// are equal, or do not follow from those before.
    pub fn first_step_of(mut self, index: u64) -> Result<Self, EnsembleError> {
        let sample = self.replay(index)?;
        let mut reached = 0.0;
        for step in sample.run() {
            let step = step.map_err(|failure| {
                EnsembleError::Refused(format!(
                    "sample {index} has no step for others to begin with: {failure}"
                ))
            })?;
            let size = step.h.to_f64().abs();
            if size < 1.5 * reached {
                break;
            }
            reached = size;
        }
        if reached == 0.0 {
            let message = format!("sample {index} makes no step: it begins at its end");
            return Err(EnsembleError::Refused(message));
        }
        self.recipe.controller = self.recipe.controller.with_first_step(reached).ok_or_else(|| {
            EnsembleError::Refused("the controller has no first step that another sample could tell".into())
        })?;
        Ok(self)
    }

    /// Saves the progress of the study in a file, and resumes from this file if it exists.
    ///
    /// It is written at the start, so that a path that cannot be written is known at once, then about `every` so
    /// often, and at the end. It is replaced as a whole: whenever the program is killed, the file is a good one. If
    /// it cannot be written, the study ends with an error and the last one stays.
    ///
    /// A checkpoint of another study is an error. Studies are compared by their [name](Self::named), source, number of
    /// samples, method, controller, end, statistic, and the start and accelerations of sample 0, which show most
    /// changes of the system. No comparison sees the rest of what the functions do: give the study another name or
    /// path if they change.
    #[must_use]
    pub fn checkpoint(self, path: impl Into<PathBuf>, every: Duration) -> Self {
        Study { checkpoint: Some(Checkpoint { path: path.into(), every }), ..self }
    }

    /// Gives the study a name, by which its checkpoints are distinguished from those of other studies.
    #[must_use]
    pub fn named(self, name: impl Into<String>) -> Self {
        Study { name: name.into(), ..self }
    }

    /// Calls `tell` with the progress of the study several times per second, unless samples take longer, and at the
    /// end.
    #[must_use]
    pub fn progress(self, tell: impl Fn(&Progress) + 'p) -> Self {
        Study { progress: Some(Box::new(tell)), ..self }
    }

    /// Keeps the first `n` failed samples, instead of the first 1000. All are counted.
    #[must_use]
    pub fn keep_failures(self, n: usize) -> Self {
        Study { keep_failures: n, ..self }
    }

    /// Only a part of the samples: shard number `shard`, from 0, of `of` equal ones. Its checkpoint is its result:
    /// shards are run anywhere and in any order, on many machines, and [`merge`](Self::merge) makes the outcome of
    /// their checkpoints, with the bits of a single process. The outcome of a shard is that of its samples.
    #[must_use]
    pub fn shard(self, shard: u64, of: u64) -> Self {
        Study { shard: Some((shard, of)), ..self }
    }

    /// One sample alone: its system, start, and all steps of its run.
    ///
    /// # Errors
    /// If there is no such sample.
    pub fn replay(&self, index: u64) -> Result<Replay<Sys, M, C, N>, EnsembleError> {
        self.recipe.check()?;
        let samples = self.recipe.ensemble.samples;
        if index < samples {
            Ok(self.recipe.replay(index))
        } else {
            Err(EnsembleError::NoSuchSample { index, samples })
        }
    }

    /// Runs all samples, and returns the `statistic` of the outputs that `watch` returns for each run. Both have to be
    /// pure functions.
    ///
    /// # Errors
    /// If the study makes no sense, or its checkpoint cannot be written, or is not one of this study.
    pub fn reduce<O, T, K>(
        &self,
        watch: K,
        statistic: T,
    ) -> Result<Outcome<T::State, Sys::Scalar, N>, EnsembleError>
    where
        T: Statistic<O>,
        K: Fn(&Sys, Run<'_, Sys, M, C, N>) -> Result<O, Lost<Sys::Scalar, N>> + Sync,
    {
        self.by(&self.one_by_one(&watch), &statistic)
    }

    /// Reduces as [`reduce`](Self::reduce), and hands each output to `sink` as soon as it is there: in the order of
    /// the samples, whatever the threads do, failed ones left out. Nothing is kept of them, so that files of any
    /// length are written in constant memory; `Parquet` (feature `parquet`) writes one that data frames read.
    ///
    /// # Errors
    /// As [`reduce`](Self::reduce); those of the sink; and if the study has a checkpoint, since the records that a sink
    /// has received cannot be withdrawn when the study resumes from the checkpoint. (Shards do for long runs.)
    pub fn stream<O, T, K>(
        &self,
        watch: K,
        statistic: T,
        sink: impl FnMut(u64, &O) -> Result<(), EnsembleError>,
    ) -> Result<Outcome<T::State, Sys::Scalar, N>, EnsembleError>
    where
        O: Record + Clone + Send,
        T: Statistic<O>,
        K: Fn(&Sys, Run<'_, Sys, M, C, N>) -> Result<O, Lost<Sys::Scalar, N>> + Sync,
    {
        self.streamed(&self.one_by_one(&watch), statistic, sink)
    }

    fn by<O, T, H>(&self, how: &H, statistic: &T) -> Result<Outcome<T::State, Sys::Scalar, N>, EnsembleError>
    where
        T: Statistic<O>,
        H: Compute<O, Failed = FailedSample<Sys::Scalar, N>>,
    {
        self.along(how, statistic, &mut Through)
    }

    fn one_by_one<'a, K>(&'a self, watch: &'a K) -> OneByOne<'a, Src, D, Sys, M, C, K, N> {
        OneByOne { recipe: &self.recipe, watch }
    }

    /// Reduces along a course, which may end it early.
    fn along<O, T, H>(
        &self,
        how: &H,
        statistic: &T,
        course: &mut impl Course<T::State>,
    ) -> Result<Outcome<T::State, Sys::Scalar, N>, EnsembleError>
    where
        T: Statistic<O>,
        H: Compute<O, Failed = FailedSample<Sys::Scalar, N>>,
    {
        let leaves = self.own_leaves()?;
        let (reached, kept) = self.drive(how, statistic, leaves, self.checkpoint.as_ref(), course)?;
        Ok(self.outcome(reached, kept, statistic))
    }

    fn streamed<O, T, H>(
        &self,
        how: &H,
        statistic: T,
        mut sink: impl FnMut(u64, &O) -> Result<(), EnsembleError>,
    ) -> Result<Outcome<T::State, Sys::Scalar, N>, EnsembleError>
    where
        O: Record + Clone + Send,
        T: Statistic<O>,
        H: Compute<O, Failed = FailedSample<Sys::Scalar, N>>,
    {
        if self.checkpoint.is_some() {
            return Err(EnsembleError::StreamWithCheckpoint);
        }
        let both = (statistic, Collect);
        // What is handed on is taken out of the statistic's state before it is merged with others.
        let hand_on = |(_, collected): &mut (T::State, Collected<O>)| {
            std::mem::take(&mut collected.rows).iter().try_for_each(|(index, output)| sink(*index, output))
        };
        let leaves = self.own_leaves()?;
        let (reached, kept) = self.drive(how, &both, leaves, None, &mut Handing(hand_on))?;
        let Outcome { statistic: (statistic, _), samples, failures } = self.outcome(reached, kept, &both);
        Ok(Outcome { statistic, samples, failures })
    }

    /// Puts together what shards have left in their checkpoints: the bits are those of the whole study made by one
    /// process. `watch` and `statistic` are those of the shards.
    ///
    /// # Errors
    /// If a checkpoint cannot be read, is not one of this study, or the shards are not all there and done.
    pub fn merge<O, T, K>(
        &self,
        shards: impl IntoIterator<Item = impl Into<PathBuf>>,
        watch: K,
        statistic: T,
    ) -> Result<Outcome<T::State, Sys::Scalar, N>, EnsembleError>
    where
        T: Statistic<O>,
        K: Fn(&Sys, Run<'_, Sys, M, C, N>) -> Result<O, Lost<Sys::Scalar, N>> + Sync,
    {
        let how = self.one_by_one(&watch);
        self.merged(&how, shards, &statistic)
    }

    fn merged<O, T, H>(
        &self,
        how: &H,
        shards: impl IntoIterator<Item = impl Into<PathBuf>>,
        statistic: &T,
    ) -> Result<Outcome<T::State, Sys::Scalar, N>, EnsembleError>
    where
        T: Statistic<O>,
        H: Compute<O, Failed = FailedSample<Sys::Scalar, N>>,
    {
        self.recipe.check()?;
        let samples = self.recipe.ensemble.samples;
        let description = self.description(statistic, how);
        let mut parts = vec![];
        for path in shards {
            let checkpoint = Checkpoint { path: path.into(), every: Duration::MAX };
            let Some(reached) = checkpoint.read(&description, samples)? else {
                let what = format!("{} is not there", checkpoint.path.display());
                return Err(EnsembleError::Shards(what));
            };
            parts.push((checkpoint, reached));
        }
        self.whole(how, parts, statistic)
    }

    /// The outcome of all shards.
    fn whole<O, T, H>(
        &self,
        how: &H,
        mut parts: Vec<(Checkpoint, Reached<T::State>)>,
        statistic: &T,
    ) -> Result<Outcome<T::State, Sys::Scalar, N>, EnsembleError>
    where
        T: Statistic<O>,
        H: Compute<O, Failed = FailedSample<Sys::Scalar, N>>,
    {
        let leaves = self.recipe.ensemble.samples.div_ceil(LEAF);
        parts.sort_by_key(|(_, reached)| (reached.first, reached.end));
        let (mut whole, mut kept) = (Reached::nothing(0..leaves), vec![]);
        for (checkpoint, part) in parts {
            let path = checkpoint.path.display();
            if part.next != part.end {
                let left = part.samples(u64::MAX) - part.done(u64::MAX);
                let what = format!("{path} is not done, about {left} of its samples are missing");
                return Err(EnsembleError::Shards(what));
            }
            if part.first != whole.next {
                let what = if part.first < whole.next {
                    "begins with samples that another has"
                } else {
                    "does not follow on any other"
                };
                return Err(EnsembleError::Shards(format!("{path} {what}")));
            }
            kept.extend(self.driver(None).again(how, &checkpoint, &part.kept, kept.len())?);
            whole.failed += part.failed;
            whole.next = part.end;
            whole.tree.append(part.tree, |earlier, later| statistic.merge(earlier, later));
        }
        if whole.next != leaves {
            let what = format!("those after sample {} are missing", whole.next * LEAF);
            return Err(EnsembleError::Shards(what));
        }
        Ok(self.outcome(whole, kept, statistic))
    }

    /// Computes these leaves, or as many of them as the course wants.
    fn drive<O, T, H>(
        &self,
        how: &H,
        statistic: &T,
        leaves: Range<u64>,
        checkpoint: Option<&Checkpoint>,
        course: &mut impl Course<T::State>,
    ) -> Result<Part<Reached<T::State>, FailedSample<Sys::Scalar, N>>, EnsembleError>
    where
        T: Statistic<O>,
        H: Compute<O, Failed = FailedSample<Sys::Scalar, N>>,
    {
        self.recipe.check()?;
        let description = self.description(statistic, how);
        self.driver(checkpoint).drive(how, statistic, &description, leaves, course)
    }

    fn driver<'a>(&'a self, checkpoint: Option<&'a Checkpoint>) -> Driver<'a, 'p> {
        Driver {
            samples: self.recipe.ensemble.samples,
            threads: self.threads,
            checkpoint,
            progress: self.progress.as_ref(),
            keep_failures: self.keep_failures,
        }
    }

    /// Statistics of the leaves that are done.
    fn outcome<O, T: Statistic<O>>(
        &self,
        reached: Reached<T::State>,
        kept: Vec<FailedSample<Sys::Scalar, N>>,
        statistic: &T,
    ) -> Outcome<T::State, Sys::Scalar, N> {
        let samples = reached.done(self.recipe.ensemble.samples);
        let count = reached.failed;
        let statistic = reached
            .tree
            .merged(|earlier, later| statistic.merge(earlier, later))
            .unwrap_or_else(|| statistic.empty());
        Outcome { statistic, samples, failures: Failures { count, kept } }
    }

    /// The leaves of the study, or of its shard.
    fn own_leaves(&self) -> Result<Range<u64>, EnsembleError> {
        match self.shard {
            None => Ok(self.leaves_of(0, 1)),
            Some((shard, of)) if shard < of => Ok(self.leaves_of(shard, of)),
            Some((shard, of)) => Err(EnsembleError::NoSuchShard { shard, of }),
        }
    }

    /// The leaves of one of equal shards.
    fn leaves_of(&self, shard: u64, of: u64) -> Range<u64> {
        let leaves = u128::from(self.recipe.ensemble.samples.div_ceil(LEAF));
        let border = |shard: u64| (leaves * u128::from(shard) / u128::from(of)) as u64;
        border(shard)..border(shard + 1)
    }

    /// Description that tells this study from others.
    fn description<O, T: Statistic<O>, H: Compute<O, Failed = FailedSample<Sys::Scalar, N>>>(
        &self,
        statistic: &T,
        how: &H,
    ) -> Vec<String> {
        let Recipe { ensemble, method, controller, end, max_steps, .. } = &self.recipe;
        let Replay { system, start, .. } = self.recipe.replay(0);
        let statistic = statistic.describe();
        let mut lines = vec![
            format!("name: {}", self.name),
            format!("source: {}", ensemble.source.describe()),
            format!("samples: {}, in leaves of {LEAF}", ensemble.samples),
            format!("method: {method:?}, {controller:?}, to t = {end:?}"),
            format!("statistic: {statistic}"),
            format!("failures kept: {}", self.keep_failures),
            format!("sample 0 at t = {:?}: {:?}, {:?}", start.t, start.q.as_slice(), start.qd.as_slice()),
            format!("its accelerations: {:?}", system.accel(&start.q, &start.qd, start.t).as_slice()),
        ];
        lines.extend(max_steps.map(|max_steps| format!("at most {max_steps} steps a sample")));
        lines.extend(how.describe());
        lines
    }
}

#[cfg(test)]
mod tests;
