//! Multifidelity Monte Carlo: a mean of an expensive model with the help of a cheap one.

use super::checkpoint::Reached;
use super::distribution::student_quantile;
use super::drive::{Compute, Course, Indexed, Part, larger, parts, samples};
use super::model::{Model, evaluated};
use super::precision::{HalfWidth, merged};
use super::record::record_fields;
use super::settings::{Settings, set_settings};
use super::statistic::interval::two_sided;
use super::statistic::{ConfidenceInterval, Covariance, Covariances, Moment, Moments};
use super::{EnsembleError, LEAF, Source, Statistic};
use crate::failure::Failure;
use core::fmt;
use core::ops::Range;
use std::sync::OnceLock;

mod quantile;

pub use quantile::QuantileEstimate;

/// Mean, or quantile, of a model's output with a cheap model as control variate: multifidelity Monte Carlo
/// (Peherstorfer, Willcox and Gunzburger, *SIAM J. Sci. Comput.* 38, 2016, section 3).
///
/// The full model f is run for n samples, the cheap one g for these and for more, m in all. The estimator
///
/// ```text
/// ŝ = f̄ₙ + α (ḡₘ − ḡₙ)
/// ```
///
/// is unbiased, whatever g is: a simplified system, the same one at a loose tolerance, a
/// [`ClosedForm`](super::ClosedForm). At a correlation ρ of the outputs, with standard deviations σ, and a ratio w of
/// the costs of a sample, the best choice is α = ρ σ_f/σ_g and m/n = √(ρ²/(w (1 − ρ²))) (their Theorem 3.4). The cost
/// of a given variance is that of plain Monte Carlo times (√(1 − ρ²) + √(w ρ²))² (Corollary 3.5): 0.021 at ρ = 0.999
/// and w = 1/100, and no less than w at any ρ.
///
/// A pilot of both models measures ρ, σ and w, by the *work* that models count and never by a clock. If it finds no
/// gain, the full model runs alone: where trajectories are chaotic, a cheap model that follows them for a while only
/// is no help, and [`Pilot::gain`] says so.
///
/// # Coverage
/// The outputs of the pilot are not used again. So α, n and m are independent of the samples from which ŝ is made, ŝ
/// is unbiased, and its variance comes from two independent means, f − β g with β = α (m − n)/m over n samples and β
/// g over the m − n others: the interval is that of Welch (1947) with Student's t. The price is the cost of the
/// pilot, which is counted in [`MultifidelityEstimate::cost`].
///
/// To reach a half-width, the study takes as many samples as the pilot predicts, looks, and adds a quarter each time
/// that this does not suffice.
///
/// # What the answer depends on
/// The study alone, as that of an [`Ensemble`](super::Ensemble): not on threads, lanes or interruptions. Sample by
/// sample both models are given the same draw of the source, whose draws have to be independent:
/// [`Random`](super::Random), or a [`Table`](super::Table) of such, and no Sobol points.
///
/// The mean, or quantile, is that over samples that the full model can run, with a finite output; others are counted.
/// The cheap model says nothing of that mean where one model has an output and the other has none: there is no gain if
/// the pilot meets such a sample, and if one comes later the estimate is made of the full model's samples alone.
///
/// Differences of the models that are rarer than one in the samples of the full model are not seen, and an interval
/// does not know of them.
///
/// ```
/// use lagrange_runtime::ensemble::{ConfidenceInterval, Multifidelity, Random, Simulation, rand_distr::{Distribution, Normal}};
/// use lagrange_runtime::lanes::FinalState;
/// use lagrange_runtime::prelude::*;
/// lagrangian! {
///     pub system Pendulum {
///         param m, l, g = 9.81;
///         coord theta;
///         T = 0.5 * m * (l * dot(theta)).powi(2);
///         V = -m * g * l * cos(theta);
///     }
/// }
/// lagrangian! {
///     /// The same for small angles.
///     pub system Linear {
///         param m, l, g = 9.81;
///         coord theta;
///         T = 0.5 * m * (l * dot(theta)).powi(2);
///         V = 0.5 * m * g * l * theta.powi(2);
///     }
/// }
/// let release = Normal::new(0.3, 0.05)?;
/// let start = |mut rng| State::new(0.0, [release.sample(&mut rng)], [0.0]);
/// let full = Simulation::new(
///     |rng| (Pendulum::new(1.0, 0.85), start(rng)),
///     Dop853,
///     PiController::tolerance(1e-9),
///     2.0,
///     FinalState(|_: &Pendulum, end: &State<f64, 1>| end.q[0]),
/// );
/// let cheap = Simulation::new(
///     |rng| (Linear::new(1.0, 0.85), start(rng)),
///     Dop853,
///     PiController::tolerance(1e-4),
///     2.0,
///     FinalState(|_: &Linear, end: &State<f64, 1>| end.q[0]),
/// );
/// let study = Multifidelity::new(Random::seed(1), 1_000_000, full, cheap);
/// let angle = study.to_half_width(1e-3)?;
/// println!("θ = {:.4} ± {:.4}, at {:.2} of the cost", angle.mean(), angle.half_width(0.95), angle.cost_ratio());
/// # assert!(angle.half_width(0.95) <= 1e-3 && angle.cost_ratio() < 0.6 && angle.pilot.gain.is_some());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Multifidelity<'p, Src, F, G> {
    source: Src,
    samples: u64,
    full: F,
    cheap: G,
    /// Samples of the pilot, if they are given.
    pilot: Option<u64>,
    confidence: f64,
    settings: Settings<'p>,
}

impl<Src: fmt::Debug, F: fmt::Debug, G: fmt::Debug> fmt::Debug for Multifidelity<'_, Src, F, G> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Multifidelity { source, samples, full, cheap, .. } = self;
        f.debug_struct("Multifidelity")
            .field("source", source)
            .field("samples", samples)
            .field("full", full)
            .field("cheap", cheap)
            .finish_non_exhaustive()
    }
}

/// Correlation and costs of two models, measured by a pilot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pilot {
    /// The number of samples.
    pub samples: u64,
    /// The coefficient of correlation ρ of the outputs; NaN if those of the cheap model are all equal.
    pub correlation: f64,
    /// Standard deviations of the outputs, of the full model and the cheap one, in their units.
    pub standard_deviation: [f64; 2],
    /// Mean costs of a sample of either.
    pub cost: [f64; 2],
    /// Division of the samples, if it is cheaper than the full model alone; `None`: there is no gain.
    pub gain: Option<Allocation>,
}

/// Division of samples among a full and a cheap model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Allocation {
    /// The coefficient α of the control variate.
    pub coefficient: f64,
    /// Samples of the cheap model for each sample of the full one, m/n.
    pub ratio: f64,
    /// Predicted cost, as a part of that of plain Monte Carlo: (√(1 − ρ²) + √(w ρ²))².
    pub cost_ratio: f64,
}

/// Smallest standard deviation whose square has all digits, after a division by many samples.
const SMALLEST: f64 = 1e-140;

/// Largest ratio of samples that is used, however well the models agree.
const MAX_RATIO: f64 = 1e6;

/// Fewest samples of the full model, from which a variance can be estimated.
const LEAST: f64 = 2.0 * LEAF as f64;

/// Fewest samples with different outputs, where others agree exactly, as outputs that are 0 or 1 do. The variance of
/// rare differences is not known from fewer: a study would stop the sooner, the fewer it has met.
const FEWEST_DIFFERENCES: u64 = 32;

/// The part of the cost of plain Monte Carlo at a correlation and a ratio of costs.
fn cost_ratio(correlation: f64, w: f64) -> f64 {
    let square = correlation * correlation;
    ((1.0 - square).max(0.0).sqrt() + (w * square).sqrt()).powi(2)
}

/// Returns whether differences of outputs are met often enough for their variance to be known.
fn are_frequent(samples: u64, agreeing: u64) -> bool {
    agreeing == 0 || samples - agreeing >= FEWEST_DIFFERENCES
}

impl Pilot {
    /// The correlation and costs of the pilot, and what follows from them.
    ///
    /// There is a gain if there is one at the lower end of the 95 % interval of |ρ| as well (Fisher's z, 1921): a
    /// chance agreement of few samples is none. Nor is there one that is known where outputs agree but for fewer than
    /// 32 samples.
    fn new(outputs: &Covariances<2>, agreeing: u64, cost: [f64; 2]) -> Self {
        let [[a, b], [_, c]] = outputs.covariance();
        let (samples, correlation) = (outputs.count(), outputs.correlation(0, 1).clamp(-1.0, 1.0));
        let standard_deviation = [a.sqrt(), c.sqrt()];
        let w = cost[1] / cost[0];
        let z = correlation.abs().min(1.0 - 1e-15).atanh();
        let low = (z - 1.96 / (samples as f64 - 3.0).sqrt()).max(0.0).tanh();
        let ratio = (correlation.powi(2) / (w * (1.0 - correlation.powi(2)))).sqrt().min(MAX_RATIO);
        // Of a constant output the correlation is not a number.
        let coefficient = b / c;
        let gains = !correlation.is_nan()
            && coefficient.is_finite()
            && cost_ratio(low, w) < 1.0
            && ratio > 1.0
            && are_frequent(samples, agreeing);
        let allocation = Allocation { coefficient, ratio, cost_ratio: cost_ratio(correlation, w) };
        Pilot { samples, correlation, standard_deviation, cost, gain: gains.then_some(allocation) }
    }

    /// Variance of the estimator times the number of full samples.
    fn variance(&self) -> f64 {
        let square = self.correlation * self.correlation;
        let part = self.gain.map_or(1.0, |gain| 1.0 - square + square / gain.ratio);
        self.standard_deviation[0].powi(2) * part
    }

    /// Cost of a sample of the full model, with its part of those of the cheap one.
    fn cost_of_sample(&self) -> f64 {
        self.cost[0] + self.gain.map_or(0.0, |gain| gain.ratio * self.cost[1])
    }
}

/// Says whether it pays: "correlation 0.9990, cost 1/100: 0.021 of the cost" or "no gain".
impl fmt::Display for Pilot {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Pilot { samples, correlation, cost, .. } = self;
        write!(f, "correlation {correlation:.4} of {samples} samples, cost 1/{:.1}: ", cost[0] / cost[1])?;
        match self.gain {
            Some(Allocation { ratio, cost_ratio, .. }) => {
                write!(f, "{cost_ratio:.3} of the cost, with {ratio:.1} cheap samples for each full one")
            }
            None => write!(f, "no gain"),
        }
    }
}

/// A sample that a model failed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FailedEvaluation {
    /// Its index.
    pub index: u64,
    /// The model of its study: 0 is the full or only one, 1 the cheap or simplified one.
    pub model: usize,
    /// The failure.
    pub failure: Failure,
}

impl fmt::Display for FailedEvaluation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "sample {} of model {}: {}", self.index, self.model, self.failure)
    }
}

impl Indexed for FailedEvaluation {
    fn index(&self) -> u64 {
        self.index
    }
}

/// Result of [`Multifidelity`]: an estimate of a mean, whose interval [`ConfidenceInterval`] gives.
#[derive(Clone, Debug, PartialEq)]
pub struct MultifidelityEstimate {
    /// The pilot.
    pub pilot: Pilot,
    /// Samples of either model from which the estimate is made, without those of the pilot.
    pub samples: [u64; 2],
    /// Cost of all samples, those of the pilot included.
    pub cost: f64,
    /// True unless the samples were used up before the half-width was reached, or the budget spent.
    pub reached: bool,
    /// The number of samples that a model failed.
    pub failed: u64,
    /// Samples that are left out since an output is infinite or not a number.
    pub not_finite: u64,
    /// The first of those that failed.
    pub failures: Vec<FailedEvaluation>,
    mean: f64,
    variance: f64,
    freedom: f64,
    /// Cost without the pilot.
    own_cost: f64,
    /// Variance of the full model's output, and the mean cost of a sample of it.
    plain: [f64; 2],
}

impl MultifidelityEstimate {
    /// The estimate of the mean.
    pub fn mean(&self) -> f64 {
        self.mean
    }

    /// Its standard error.
    pub fn standard_error(&self) -> f64 {
        self.variance.sqrt()
    }

    /// The number of samples of the full model that would have had the same standard error without the cheap one, as
    /// nearly as the variance is known.
    pub fn plain_samples(&self) -> f64 {
        self.plain[0] / self.variance
    }

    /// Cost as a part of what plain Monte Carlo would have cost for the same standard error. The pilot is not in it:
    /// a more accurate study needs none that is longer.
    pub fn cost_ratio(&self) -> f64 {
        self.own_cost * self.variance / (self.plain[0] * self.plain[1])
    }
}

impl ConfidenceInterval for MultifidelityEstimate {
    fn confidence_interval(&self, confidence: f64) -> [f64; 2] {
        let half = student_quantile(two_sided(confidence), self.freedom) * self.standard_error();
        [self.mean - half, self.mean + half]
    }
}

/// Part of a study to which a leaf belongs.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Pilot,
    Pair,
    Cheap,
    Full,
}

/// Outputs of a sample, and the work of either model.
struct Paired {
    kind: Kind,
    /// The outputs; not a number where a model failed.
    outputs: [f64; 2],
    failed: bool,
    work: [u64; 2],
}

impl Paired {
    /// Returns whether one model alone has an output.
    fn is_unlike(&self) -> bool {
        let [full, cheap] = self.outputs.map(f64::is_finite);
        matches!(self.kind, Kind::Pilot | Kind::Pair) && full != cheap
    }

    /// Is an output infinite or not a number, that no failure explains?
    fn is_not_finite(&self) -> bool {
        !self.failed && self.outputs.iter().any(|output| !output.is_finite())
    }
}

/// Statistics of all parts of a study, in one state: the pilot's are recognized when a study is resumed.
#[derive(Clone, Copy, Debug)]
struct Sums {
    pilot: Covariances<2>,
    pairs: Covariances<2>,
    cheap: Moment,
    full: Moment,
    pilot_work: [u64; 2],
    work: [u64; 2],
    /// Samples of the pilot, and pairs after it, whose outputs are equal.
    agreeing: [u64; 2],
    /// Samples of the pilot, and pairs after it, in which one model alone has an output.
    unlike: [u64; 2],
    not_finite: u64,
}

record_fields!(Sums { pilot, pairs, cheap, full, pilot_work, work, agreeing, unlike, not_finite });

struct Summed;

const PAIRS: Covariance<2> = Covariance;

impl Statistic<Paired> for Summed {
    type State = Sums;

    fn empty(&self) -> Sums {
        let (pairs, alone) = (PAIRS.empty(), Moments.empty());
        Sums {
            pilot: pairs,
            pairs,
            cheap: alone,
            full: alone,
            pilot_work: [0; 2],
            work: [0; 2],
            agreeing: [0; 2],
            unlike: [0; 2],
            not_finite: 0,
        }
    }

    fn add(&self, state: &mut Sums, index: u64, sample: &Paired) {
        let work = if sample.kind == Kind::Pilot { &mut state.pilot_work } else { &mut state.work };
        (0..2).for_each(|model| work[model] += sample.work[model]);
        let outputs = &sample.outputs;
        let part = usize::from(sample.kind != Kind::Pilot);
        if matches!(sample.kind, Kind::Pilot | Kind::Pair) {
            state.agreeing[part] += u64::from(outputs[0] == outputs[1]);
            state.unlike[part] += u64::from(sample.is_unlike());
        }
        state.not_finite += u64::from(sample.is_not_finite());
        match sample.kind {
            Kind::Pilot => PAIRS.add(&mut state.pilot, index, outputs),
            Kind::Pair => {
                PAIRS.add(&mut state.pairs, index, outputs);
                Moments.add(&mut state.full, index, &outputs[0]);
            }
            Kind::Cheap => Moments.add(&mut state.cheap, index, &outputs[1]),
            Kind::Full => Moments.add(&mut state.full, index, &outputs[0]),
        }
    }

    fn merge(&self, state: &mut Sums, later: Sums) {
        PAIRS.merge(&mut state.pilot, later.pilot);
        PAIRS.merge(&mut state.pairs, later.pairs);
        Moments.merge(&mut state.cheap, later.cheap);
        Moments.merge(&mut state.full, later.full);
        (0..2).for_each(|model| state.pilot_work[model] += later.pilot_work[model]);
        (0..2).for_each(|model| state.work[model] += later.work[model]);
        (0..2).for_each(|part| state.agreeing[part] += later.agreeing[part]);
        (0..2).for_each(|part| state.unlike[part] += later.unlike[part]);
        state.not_finite += later.not_finite;
    }

    fn describe(&self) -> String {
        "multifidelity".into()
    }
}

/// Accuracy or cost that a study is to have.
#[derive(Clone, Copy, Debug)]
enum Goal {
    Pilot,
    HalfWidth(f64),
    Budget(f64),
}

/// The way samples are computed: by which models, the plan says, which is made of the pilot.
struct ByModels<'a, Src, F, G> {
    source: &'a Src,
    samples: u64,
    full: &'a F,
    cheap: &'a G,
    /// Leaves of the pilot.
    pilot: u64,
    plan: &'a OnceLock<Pilot>,
}

/// The number of leaves with both models among the first `leaves` after the pilot.
fn pairs_among(leaves: u64, ratio: f64) -> u64 {
    (leaves as f64 / ratio).ceil() as u64
}

impl<Src, F, G> ByModels<'_, Src, F, G> {
    fn kind(&self, leaf: u64) -> Kind {
        let Some(main) = leaf.checked_sub(self.pilot) else { return Kind::Pilot };
        match self.plan.get().and_then(|pilot| pilot.gain) {
            None => Kind::Full,
            Some(Allocation { ratio, .. }) if pairs_among(main + 1, ratio) > pairs_among(main, ratio) => {
                Kind::Pair
            }
            Some(_) => Kind::Cheap,
        }
    }
}

impl<Src, F, G> ByModels<'_, Src, F, G>
where
    Src: Source,
    F: Model<Src::Draw, Output = f64>,
    G: Model<Src::Draw, Output = f64>,
{
    /// The samples of these leaves, in their order: outputs of both models, and failures.
    fn outputs(&self, leaves: Range<u64>) -> Vec<(u64, Paired, Option<FailedEvaluation>)> {
        let of = |leaf: u64| samples(leaf..leaf + 1, self.samples);
        let all: Vec<(u64, Kind)> =
            leaves.flat_map(|leaf| of(leaf).map(move |index| (index, self.kind(leaf)))).collect();
        let draws = |not: Kind| {
            let wanted = all.iter().filter(move |(_, kind)| *kind != not);
            wanted.map(|(index, _)| self.source.draw(*index)).collect::<Vec<_>>()
        };
        let mut full = evaluated(self.full, draws(Kind::Cheap)).into_iter();
        let mut cheap = evaluated(self.cheap, draws(Kind::Full)).into_iter();
        let paired = |(index, kind): (u64, Kind)| {
            let of_full = if kind == Kind::Cheap { None } else { full.next() };
            let of_cheap = if kind == Kind::Full { None } else { cheap.next() };
            let both = [of_full, of_cheap];
            let work = both.map(|evaluated| evaluated.map_or(0, |evaluated| evaluated.work));
            let outputs = both.map(|evaluated| evaluated.map_or(Ok(0.0), |evaluated| evaluated.output));
            let failed = outputs.iter().enumerate().find_map(|(model, output)| {
                output.err().map(|failure| FailedEvaluation { index, model, failure })
            });
            let outputs = outputs.map(|output| output.unwrap_or(f64::NAN));
            (index, Paired { kind, outputs, failed: failed.is_some(), work }, failed)
        };
        all.into_iter().map(paired).collect()
    }
}

impl<Src, F, G> Compute<Paired> for ByModels<'_, Src, F, G>
where
    Src: Source,
    F: Model<Src::Draw, Output = f64>,
    G: Model<Src::Draw, Output = f64>,
{
    const GROUP: u64 = larger(F::GROUP, G::GROUP);

    type Failed = FailedEvaluation;

    fn leaves<T: Statistic<Paired>>(
        &self,
        leaves: Range<u64>,
        statistic: &T,
    ) -> Vec<Part<T::State, FailedEvaluation>> {
        parts(leaves.clone(), statistic, self.outputs(leaves))
    }

    fn failure(&self, index: u64) -> Option<FailedEvaluation> {
        let leaf = index / LEAF;
        self.outputs(leaf..leaf + 1).into_iter().find_map(|(at, _, failed)| failed.filter(|_| at == index))
    }
}

/// The course of a study: a pilot, and samples until the goal is reached.
struct ToGoal<'a> {
    goal: Goal,
    confidence: f64,
    /// Leaves of the pilot, and those after it.
    pilot: u64,
    leaves: u64,
    /// Looks are taken before the predicted end, too.
    looks_early: bool,
    unit_cost: [f64; 2],
    plan: &'a OnceLock<Pilot>,
}

impl ToGoal<'_> {
    /// The pilot by its outputs, of which so many agree and so many are of one model alone, and its work.
    fn pilot_of(
        &self,
        outputs: &Covariances<2>,
        [agreeing, unlike]: [u64; 2],
        work: [u64; 2],
    ) -> Result<Pilot, EnsembleError> {
        let count = outputs.count();
        let work = work.map(|work| work as f64 / (self.pilot * LEAF) as f64);
        let cost = [work[0] * self.unit_cost[0], work[1] * self.unit_cost[1]];
        let mut pilot = Pilot::new(outputs, agreeing, cost);
        pilot.gain = pilot.gain.filter(|_| unlike == 0);
        let [deviation, _] = pilot.standard_deviation;
        if count < 8 {
            let what = format!(
                "the pilot has {count} samples that both models can run and whose outputs are finite, too few to plan by; help: run a few \
                 of its draws alone to see why, or give it more samples, as `.pilot_samples(1024)`"
            );
            return Err(EnsembleError::Refused(what));
        }
        if !deviation.is_finite() {
            let what = "the squares of the full model's outputs are beyond the largest number; help: give the output in larger units";
            return Err(EnsembleError::Refused(what.into()));
        }
        if deviation < SMALLEST {
            let what = format!(
                "the output of the full model is the same for all {count} samples of the pilot, or differs by less than {SMALLEST:e}; help: give \
                 the pilot more samples, as `.pilot_samples(4096)`, or an output that depends on the draw, or smaller units"
            );
            return Err(EnsembleError::Refused(what));
        }
        Ok(Pilot { gain: pilot.gain.map(|gain| self.at_least(&pilot, gain)), ..pilot })
    }

    /// An allocation with fewer cheap samples, where the best one would need fewer than the least number of full ones
    /// (Gruber, Gunzburger, Ju and Wang, *J. Sci. Comput.* 94, 2023), or more cheap ones than the study has: the
    /// samples that are left are worth no more than what they cost.
    fn at_least(&self, pilot: &Pilot, gain: Allocation) -> Allocation {
        let [deviation, square] = [pilot.standard_deviation[0], pilot.correlation.powi(2)];
        let samples = (self.leaves * LEAF) as f64;
        let (cheap, of_all) = match self.goal {
            Goal::Pilot => return gain,
            Goal::HalfWidth(half_width) => {
                let wanted = (half_width / self.quantile(pilot) / deviation).powi(2);
                // (Infinite or negative where the least number of full samples does not suffice. A half of the
                // samples is for what the pilot does not know.)
                let of_all = (0.5 * samples * wanted - square) / (1.0 - square);
                (square / (wanted - (1.0 - square) / LEAST), of_all)
            }
            Goal::Budget(budget) => {
                let rest = budget - self.cost_of_pilot(pilot);
                let full = (rest - samples * pilot.cost[1]).max(0.0) / pilot.cost[0];
                ((rest - LEAST * pilot.cost[0]) / pilot.cost[1], samples / full)
            }
        };
        let least = cheap / LEAST;
        let ratio = if least > 0.0 { gain.ratio.min(least.max(1.0)) } else { gain.ratio };
        Allocation { ratio: ratio.min(of_all.max(1.0)), ..gain }
    }

    fn quantile(&self, pilot: &Pilot) -> f64 {
        student_quantile(two_sided(self.confidence), pilot.samples as f64)
    }

    fn cost_of_pilot(&self, pilot: &Pilot) -> f64 {
        (self.pilot * LEAF) as f64 * (pilot.cost[0] + pilot.cost[1])
    }

    /// Leaves after the pilot at which to look for the first time, and whether that is the last one.
    fn first_look(&self, pilot: &Pilot) -> Result<(u64, bool), EnsembleError> {
        let ratio = pilot.gain.map_or(1.0, |gain| gain.ratio);
        // Two leaves with the full model, from which a variance can be estimated.
        let least = ratio.ceil() as u64 + 1;
        match self.goal {
            Goal::Pilot => Ok((0, true)),
            Goal::HalfWidth(half_width) => {
                let full = pilot.variance() * (self.quantile(pilot) / half_width).powi(2);
                let leaves = (ratio * full / LEAF as f64).ceil();
                Ok((least.max(leaves as u64), false))
            }
            Goal::Budget(budget) => {
                let of_pilot = self.cost_of_pilot(pilot);
                let cost = |leaves: u64| {
                    let full = pairs_among(leaves, ratio) as f64 * pilot.cost[0];
                    let cheap = if pilot.gain.is_some() { leaves as f64 * pilot.cost[1] } else { 0.0 };
                    of_pilot + LEAF as f64 * (full + cheap)
                };
                if budget.is_nan() || budget < cost(least) {
                    let what = format!(
                        "a budget of {budget:?} does not suffice: the pilot has a cost of {of_pilot:.4e}; help: give {:.4e} at least",
                        1.001 * cost(least)
                    );
                    return Err(EnsembleError::Refused(what));
                }
                let leaves = ratio * (budget - of_pilot) / (LEAF as f64 * pilot.cost_of_sample());
                // (One more than there are says that the budget is not spent.)
                let mut leaves = (leaves as u64).min(self.leaves + 1);
                while cost(leaves) > budget {
                    leaves -= 1;
                }
                Ok((least.max(leaves), true))
            }
        }
    }
}

impl ToGoal<'_> {
    /// The leaf at which to look again after those up to `next`, or `None` at the end: of `end` leaves, of a budget, or
    /// where the goal `is_met`.
    fn look_after(
        &self,
        next: u64,
        end: u64,
        pilot: &Pilot,
        is_met: &dyn Fn() -> bool,
    ) -> Result<Option<u64>, EnsembleError> {
        let (predicted, is_last) = self.first_look(pilot)?;
        // A prediction by a density that few samples tell may be far too large. (Intervals that are looked at often
        // cover less than they say.)
        let ratio = pilot.gain.map_or(1.0, |gain| gain.ratio);
        let early = (4.0 * self.pilot as f64 * ratio).ceil() as u64;
        let mut look = if self.looks_early && predicted / 16 > early { early } else { predicted };
        let done = next - self.pilot;
        if next >= end || is_last && done >= look {
            return Ok(None);
        }
        let later = |look: u64| match look < predicted {
            true => look.saturating_mul(4).min(predicted),
            false => (look + 1).max((1.25 * look as f64).ceil() as u64),
        };
        while look < done {
            look = later(look);
        }
        if look == done {
            if is_met() {
                return Ok(None);
            }
            look = later(look);
        }
        Ok(Some(self.pilot.saturating_add(look).min(end)))
    }
}

impl Course<Sums> for ToGoal<'_> {
    fn next(&mut self, reached: &Reached<Sums>) -> Result<Option<u64>, EnsembleError> {
        if reached.next < self.pilot {
            return Ok(Some(self.pilot));
        }
        let sums = merged(&Summed, reached.tree.clone());
        let pilot = match self.plan.get() {
            Some(pilot) => *pilot,
            None => {
                let pilot =
                    self.pilot_of(&sums.pilot, [sums.agreeing[0], sums.unlike[0]], sums.pilot_work)?;
                *self.plan.get_or_init(|| pilot)
            }
        };
        self.look_after(reached.next, reached.end, &pilot, &|| {
            matches!(self.goal, Goal::HalfWidth(half_width)
                if (pilot.gain.is_none() || are_frequent(sums.pairs.count(), sums.agreeing[1]))
                    && (0.0..=half_width).contains(&mean_of(&sums, &pilot).half_width(self.confidence)))
        })
    }
}

/// An estimate of the mean, its variance and degrees of freedom.
struct Mean {
    mean: f64,
    variance: f64,
    freedom: f64,
}

impl ConfidenceInterval for Mean {
    fn confidence_interval(&self, confidence: f64) -> [f64; 2] {
        let half = student_quantile(two_sided(confidence), self.freedom) * self.variance.sqrt();
        [self.mean - half, self.mean + half]
    }
}

/// The mean of the samples after the pilot. f̄ₙ + α (ḡₘ − ḡₙ) is the mean of f − β g over the n pairs plus β times
/// that of g over the m − n others, with β = α (m − n)/m: two independent means.
fn mean_of(sums: &Sums, pilot: &Pilot) -> Mean {
    let Some(Allocation { coefficient, .. }) = pilot.gain.filter(|_| sums.unlike[1] == 0) else {
        let full = sums.full;
        return Mean {
            mean: full.mean(),
            variance: full.standard_error().powi(2),
            freedom: full.count() as f64 - 1.0,
        };
    };
    // (One sample has no variance.)
    let others = if sums.cheap.count() > 1 { sums.cheap.count() as f64 } else { 0.0 };
    let n = sums.pairs.count() as f64;
    let beta = if others > 0.0 { coefficient * others / (n + others) } else { 0.0 };
    let ([f, g], ff) = (sums.pairs.mean(), sums.pairs.covariance()[0][0]);
    // The difference cancels where the models agree: it is known to roundings of the variance. Where it is rare, few
    // pairs may have met less of it than the pilot has.
    let of_difference = |[[ff, fg], [_, gg]]: [[f64; 2]; 2]| ff - 2.0 * beta * fg + beta * beta * gg;
    let differing = of_difference(sums.pairs.covariance()).max(of_difference(sums.pilot.covariance()));
    let of_pairs = differing.max(4.0 * f64::EPSILON * ff) / n;
    let (control, of_others) = match others {
        0.0 => (0.0, 0.0),
        _ => (sums.cheap.mean() - g, beta * beta * sums.cheap.variance() / others),
    };
    let variance = of_pairs + of_others;
    // Welch (1947), by parts of the variance, whose squares may be beyond the numbers.
    let part = of_pairs / variance;
    let parts = part.powi(2) / (n - 1.0) + (1.0 - part).powi(2) / (others - 1.0).max(1.0);
    Mean { mean: f + beta * control, variance, freedom: 1.0 / parts }
}

impl<'p, Src, F, G> Multifidelity<'p, Src, F, G>
where
    Src: Source,
    F: Model<Src::Draw, Output = f64>,
    G: Model<Src::Draw, Output = f64>,
{
    /// A study of at most so many samples, pilot included, by a full model and a cheap one. Both are given the draws
    /// of the source.
    pub fn new(source: Src, samples: u64, full: F, cheap: G) -> Self {
        Multifidelity {
            source,
            samples,
            full,
            cheap,
            pilot: None,
            confidence: 0.95,
            settings: Settings::default(),
        }
    }

    /// Sets the number of samples of the pilot, rounded up to a multiple of 32. Otherwise it is 128 for a mean, and
    /// for a quantile 1024, or as many as have 64 on either side of it.
    #[must_use]
    pub fn pilot_samples(self, samples: u64) -> Self {
        Multifidelity { pilot: Some(samples), ..self }
    }

    /// Sets the confidence of the interval whose half-width is to be reached, instead of 0.95.
    #[must_use]
    pub fn confidence(self, confidence: f64) -> Self {
        Multifidelity { confidence, ..self }
    }

    set_settings!();

    /// Runs the pilot alone: does the cheap model pay?
    ///
    /// # Errors
    /// If the study makes no sense: no samples, outputs of the full model that are all equal, models without a cost.
    pub fn pilot(&self) -> Result<Pilot, EnsembleError> {
        Ok(self.run(Goal::Pilot)?.pilot)
    }

    /// The mean, with a confidence interval of this half-width at most, in the unit of the output.
    ///
    /// # Errors
    /// As [`pilot`](Self::pilot); and if the half-width or confidence makes no sense.
    pub fn to_half_width(&self, half_width: f64) -> Result<MultifidelityEstimate, EnsembleError> {
        HalfWidth::of(half_width).confidence(self.confidence).check()?;
        self.run(Goal::HalfWidth(half_width))
    }

    /// The mean as well as it can be had at this cost, pilot included, in the unit of the models' costs. The pilot
    /// predicts the cost of a sample: what the study has cost, [`MultifidelityEstimate::cost`], may differ by its
    /// scatter.
    ///
    /// # Errors
    /// As [`pilot`](Self::pilot); and if the budget does not suffice for more than the pilot.
    pub fn within_budget(&self, cost: f64) -> Result<MultifidelityEstimate, EnsembleError> {
        HalfWidth::of(1.0).confidence(self.confidence).check()?;
        self.run(Goal::Budget(cost))
    }

    /// Checks the study, and gives the numbers of its leaves and of those of the pilot, which has so many samples
    /// unless they are given.
    fn checked(&self, goal: Goal, usual: u64) -> Result<[u64; 2], EnsembleError> {
        let Multifidelity { source, samples, full, cheap, .. } = self;
        if *samples == 0 {
            return Err(EnsembleError::NoSamples);
        }
        source.check(*samples)?;
        full.check().map_err(EnsembleError::Refused)?;
        cheap.check().map_err(EnsembleError::Refused)?;
        let (leaves, pilot) = (samples.div_ceil(LEAF), self.pilot.unwrap_or(usual).div_ceil(LEAF).max(1));
        let wanted = (pilot + 2).saturating_mul(2 * LEAF).max(1_000_000);
        // Two leaves more, unless the pilot is all that is wanted.
        let least = if matches!(goal, Goal::Pilot) { pilot } else { pilot.saturating_add(2) };
        if samples / LEAF < least {
            let what = format!(
                "a study of {samples} samples has no room for a pilot of {}; help: give the study more samples, as `Multifidelity::new(source, \
                 {wanted}, …)`: they are the most that it takes",
                pilot.saturating_mul(LEAF)
            );
            return Err(EnsembleError::Refused(what));
        }
        Ok([leaves, pilot])
    }

    /// The lines by which the checkpoint of a study is known.
    fn description(&self, pilot: u64, goal: String) -> [String; 6] {
        let Multifidelity { source, samples, full, cheap, settings, .. } = self;
        [
            format!("name: {}", settings.name),
            format!("source: {}", source.describe()),
            format!("samples: {samples}, in leaves of {LEAF}, {} in the pilot", pilot * LEAF),
            format!("full model: {}", full.describe(source.draw(0))),
            format!("cheap model: {}", cheap.describe(source.draw(0))),
            goal,
        ]
    }

    fn run(&self, goal: Goal) -> Result<MultifidelityEstimate, EnsembleError> {
        let Multifidelity { source, samples, full, cheap, confidence, settings, .. } = self;
        let [leaves, pilot] = self.checked(goal, 128)?;
        let plan = OnceLock::new();
        let how = ByModels { source, samples: *samples, full, cheap, pilot, plan: &plan };
        let unit_cost = [full.unit_cost(), cheap.unit_cost()];
        let rest = leaves - pilot;
        let mut course = ToGoal {
            goal,
            confidence: *confidence,
            pilot,
            leaves: rest,
            looks_early: false,
            unit_cost,
            plan: &plan,
        };
        let description =
            self.description(pilot, format!("multifidelity: {goal:?}, confidence {confidence:?}"));
        let (reached, failures) =
            settings.driver(*samples).drive(&how, &Summed, &description, 0..leaves, &mut course)?;
        let sums = merged(&Summed, reached.tree);
        let pilot = match plan.get() {
            Some(pilot) => *pilot,
            None => course.pilot_of(&sums.pilot, [sums.agreeing[0], sums.unlike[0]], sums.pilot_work)?,
        };
        let (look, _) = course.first_look(&pilot)?;
        let used_up = reached.next == leaves && leaves - course.pilot < look;
        Ok(estimate(&sums, pilot, unit_cost, goal, *confidence, used_up, (reached.failed, failures)))
    }
}

fn estimate(
    sums: &Sums,
    pilot: Pilot,
    unit_cost: [f64; 2],
    goal: Goal,
    confidence: f64,
    used_up: bool,
    failures: (u64, Vec<FailedEvaluation>),
) -> MultifidelityEstimate {
    let (failed, failures) = failures;
    let estimate = mean_of(sums, &pilot);
    let cost = |work: [u64; 2]| work[0] as f64 * unit_cost[0] + work[1] as f64 * unit_cost[1];
    let half_width = estimate.half_width(confidence);
    let reached = match goal {
        Goal::HalfWidth(wanted) => half_width <= wanted,
        Goal::Pilot => true,
        Goal::Budget(_) => !used_up,
    };
    let Mean { mean, variance, freedom } = estimate;
    let pairs = sums.pairs.count();
    let samples = match pilot.gain {
        Some(_) => [pairs, pairs + sums.cheap.count()],
        None => [sums.full.count(), 0],
    };
    let plain = match pilot.gain.filter(|_| sums.unlike[1] == 0) {
        Some(_) => sums.pairs.covariance()[0][0],
        None => sums.full.variance(),
    };
    // (Of few pairs all outputs may be equal, which the pilot has seen not to be so.)
    let plain = if plain > 0.0 { plain } else { pilot.standard_deviation[0].powi(2) };
    MultifidelityEstimate {
        pilot,
        samples,
        cost: cost(sums.pilot_work) + cost(sums.work),
        reached,
        failed,
        not_finite: sums.not_finite,
        failures,
        mean,
        variance,
        freedom,
        own_cost: cost(sums.work),
        plain: [plain, sums.work[0] as f64 * unit_cost[0] / samples[0] as f64],
    }
}
