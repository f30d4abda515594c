//! Studies that stop by themselves: once a confidence interval is short enough.

use super::drive::{Compute, Course};
use super::statistic::ConfidenceInterval;
use super::tree::Tree;
use super::{EnsembleError, FailedSample, LEAF, LaneStudy, Lost, Outcome, Source, Statistic, Study};
use crate::controller::Controller;
use crate::ensemble::checkpoint::Reached;
use crate::integrate::Run;
use crate::integrate::lanes::InLanes;
use crate::lanes::{Observer, Policy, Rescale};
use crate::method::Method;
use crate::scalar::Real;
use crate::state::State;
use crate::system::System;
use core::fmt;
use core::marker::PhantomData;

/// Stopping rule: the half-width that a confidence interval is to have (Chow and Robbins, *Ann. Math. Statist.* 36,
/// 1965).
///
/// The rule looks after a first batch of samples and each time that their number has doubled, so that the samples of
/// a study that stops by itself are the first ones of the whole study, and its statistic has the bits of a study of
/// so many.
///
/// A study that stops as soon as its interval happens to be short stops too early more often than too late. Looking
/// at few instants, and at none before 256 samples, keeps the coverage near what the interval promises:
/// docs/lab/reliability.md has the measurement. A statistic whose interval is empty, since all outputs were equal so
/// far, does not stop a study.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HalfWidth {
    half_width: f64,
    confidence: f64,
    first: u64,
}

impl HalfWidth {
    /// Half the length of the interval, in the unit of the output, at a confidence of 0.95.
    pub const fn of(half_width: f64) -> Self {
        HalfWidth { half_width, confidence: 0.95, first: 256 }
    }

    /// Sets the confidence.
    #[must_use]
    pub const fn confidence(self, confidence: f64) -> Self {
        HalfWidth { confidence, ..self }
    }

    /// Sets the size of the first batch, instead of 256. It is rounded up to a power of two, and to 32 at least.
    #[must_use]
    pub const fn first(self, samples: u64) -> Self {
        HalfWidth { first: samples, ..self }
    }

    pub(super) fn check(&self) -> Result<(), EnsembleError> {
        let HalfWidth { half_width, confidence, .. } = *self;
        if half_width.is_nan() || half_width <= 0.0 {
            let what = format!("a half-width has to be positive, but it is {half_width:?}");
            return Err(EnsembleError::Refused(what));
        }
        if !(confidence > 0.0 && confidence < 1.0) {
            let what = format!("a confidence has to be between 0 and 1, as 0.95, but it is {confidence:?}");
            return Err(EnsembleError::Refused(what));
        }
        Ok(())
    }

    fn is_met(&self, state: &impl ConfidenceInterval) -> bool {
        let half_width = state.half_width(self.confidence);
        half_width > 0.0 && half_width <= self.half_width
    }
}

/// The course of a study that looks at its statistic when the number of its samples has doubled.
struct Doubling<'a, O, T> {
    statistic: &'a T,
    rule: HalfWidth,
    output: PhantomData<fn() -> O>,
}

/// All parts so far.
pub(super) fn merged<O, T: Statistic<O>>(statistic: &T, tree: Tree<T::State>) -> T::State {
    tree.merged(|earlier, later| statistic.merge(earlier, later)).unwrap_or_else(|| statistic.empty())
}

impl<O, T> Course<T::State> for Doubling<'_, O, T>
where
    T: Statistic<O, State: ConfidenceInterval + Clone>,
{
    fn next(&mut self, reached: &Reached<T::State>) -> Result<Option<u64>, EnsembleError> {
        let Doubling { statistic, rule, .. } = *self;
        let first = rule.first.div_ceil(LEAF).max(1).checked_next_power_of_two().unwrap_or(u64::MAX);
        let looks = reached.next >= first && reached.next.is_power_of_two();
        if reached.next >= reached.end || looks && rule.is_met(&merged(statistic, reached.tree.clone())) {
            return Ok(None);
        }
        let doubled = (reached.next + 1).checked_next_power_of_two().unwrap_or(u64::MAX);
        Ok(Some(doubled.max(first).min(reached.end)))
    }
}

impl<Src, D, Sys, M, C, const N: usize> Study<'_, Src, D, Sys, M, C, N>
where
    Src: Source,
    Sys: System<N>,
    Sys::Scalar: Real + Send + Sync,
    M: Method<Sys, N> + Clone + Sync + fmt::Debug,
    C: Controller<Sys::Scalar, N, M::Error> + Sync + fmt::Debug,
    D: Fn(Src::Draw) -> (Sys, State<Sys::Scalar, N>) + Sync,
{
    /// Reduces as [`reduce`](Self::reduce), until the confidence interval of the statistic is short enough; the
    /// samples of the study are the most that are run. [`Outcome::samples`] says how many were.
    ///
    /// ```
    /// use lagrange_runtime::ensemble::{ConfidenceInterval, Ensemble, HalfWidth, Moments, Random, rand_distr::{Distribution, Normal}};
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
    /// let study = Ensemble::new(Random::seed(1), 1_000_000, |mut rng| {
    ///     (Pendulum::new(1.0, 0.85), State::new(0.0, [release.sample(&mut rng)], [0.0]))
    /// })
    /// .integrate(Dop853, PiController::tolerance(1e-6), 2.0);
    /// let outcome = study.reduce_until(|_, run| Ok(run.final_state()?.q[0]), Moments, HalfWidth::of(0.005))?;
    /// assert!(outcome.statistic.half_width(0.95) <= 0.005 && outcome.samples < 10_000);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As [`reduce`](Self::reduce); if the half-width or confidence makes no sense; and for a shard, which cannot
    /// know when the others stop.
    pub fn reduce_until<O, T, K>(
        &self,
        watch: K,
        statistic: T,
        rule: HalfWidth,
    ) -> Result<Outcome<T::State, Sys::Scalar, N>, EnsembleError>
    where
        T: Statistic<O, State: ConfidenceInterval + Clone>,
        K: Fn(&Sys, Run<'_, Sys, M, C, N>) -> Result<O, Lost<Sys::Scalar, N>> + Sync,
    {
        self.until(&self.one_by_one(&watch), &statistic, rule)
    }

    fn until<O, T, H>(
        &self,
        how: &H,
        statistic: &T,
        rule: HalfWidth,
    ) -> Result<Outcome<T::State, Sys::Scalar, N>, EnsembleError>
    where
        T: Statistic<O, State: ConfidenceInterval + Clone>,
        H: Compute<O, Failed = FailedSample<Sys::Scalar, N>>,
    {
        rule.check()?;
        if self.shard.is_some() {
            return Err(EnsembleError::SequentialShard);
        }
        self.along(how, statistic, &mut Doubling { statistic, rule, output: PhantomData::<fn() -> O> })
    }
}

impl<Src, D, Sys, M, C, const N: usize> Study<'_, Src, D, Sys, M, C, N>
where
    Src: Source,
    Sys: System<N, Scalar = f64>,
    M: Method<Sys, N> + Clone + Sync + fmt::Debug,
    C: Controller<f64, N, M::Error> + Sync + fmt::Debug,
    D: Fn(Src::Draw) -> (Sys, State<f64, N>) + Sync,
{
    /// Observes as [`observe`](Self::observe), until the confidence interval of the statistic is short enough, as
    /// [`reduce_until`](Self::reduce_until).
    ///
    /// # Errors
    /// As [`reduce_until`](Self::reduce_until).
    pub fn observe_until<W, T>(
        &self,
        watch: &W,
        statistic: T,
        rule: HalfWidth,
    ) -> Result<Outcome<T::State, f64, N>, EnsembleError>
    where
        W: Observer<Sys, N> + Sync,
        T: Statistic<W::Output, State: ConfidenceInterval + Clone>,
    {
        self.reduce_until(|_, run| Ok(run.observe(watch)?), statistic, rule)
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
    /// Observes as [`observe`](Self::observe), until the confidence interval of the statistic is short enough, as
    /// [`Study::reduce_until`].
    ///
    /// # Errors
    /// As [`Study::reduce_until`].
    pub fn observe_until<W, T>(
        &self,
        watch: &W,
        statistic: T,
        rule: HalfWidth,
    ) -> Result<Outcome<T::State, f64, N>, EnsembleError>
    where
        W: Observer<Sys, N> + Sync,
        T: Statistic<W::Output, State: ConfidenceInterval + Clone>,
    {
        self.study.until(&self.side_by_side(watch), &statistic, rule)
    }
}
