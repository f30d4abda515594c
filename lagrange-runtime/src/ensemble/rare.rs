//! Rare events: subset simulation.

use super::checkpoint::{Checkpoint, Reached};
use super::distribution::student_quantile;
use super::model::{Evaluated, Model, evaluated_by};
use super::record::record_fields;
use super::settings::{Settings, set_settings};
use super::source::{Random, Source};
use super::statistic::interval::two_sided;
use super::statistic::{ConfidenceInterval, Moment};
use super::stopwatch::Stopwatch;
use super::tree::Tree;
use super::{EnsembleError, LEAF, Progress};
use core::fmt;
use rand_distr::{Distribution, StandardNormal, StandardUniform};

/// Levels after which a study gives up: a probability of 10⁻⁵⁰.
const MOST_LEVELS: usize = 50;

/// Acceptance at which chains forget where they began the fastest, and by how much steps are made longer or shorter
/// where the level before had another one (Roberts, Gelman and Gilks 1997). Within a level steps have one length, so
/// that chains keep their distribution.
const BEST_ACCEPTANCE: f64 = 0.44;
const ADAPTATION: f64 = 2.0;

/// Part of the samples of a level that lies beyond the next one.
const PART: f64 = 0.1;

/// Probability of a rare event by subset simulation (Au and Beck, *Probabilistic Engineering Mechanics* 16, 2001):
/// that the output of a model exceeds a threshold, where its inputs are `D` independent standard normal numbers.
/// (Other distributions are functions of these.)
///
/// The event is reached in levels. Of the samples of a level the tenth with the largest outputs are the starts of
/// Markov chains, all of whose members have outputs above the rest: they are distributed as normal numbers on the
/// condition that they do. The probability is the product of the conditional ones, each of about 1/10, so that 10⁻⁶
/// takes six levels and not 10⁸ samples. Chains go by the modified Metropolis algorithm, component by component,
/// which does not stall in many dimensions.
///
/// Levels are correlated with each other, since a chain's start is a member of an earlier one. So the error is
/// measured, by runs that are independent of each other, 10 by default: the estimate is their mean, and its coefficient
/// of variation δ comes from their scatter. (Correlation within chains alone, Au and Beck's eq. 29, tells half of it.)
/// The interval is that of the mean of lognormal numbers. In a single dimension chains forget a lucky sample slowly:
/// estimates have a long tail there, and intervals cover less than they say; docs/lab/reliability.md has the
/// measurement.
///
/// The output has to lead to the event: the larger, the nearer. An output that is true or false has no levels, and is
/// an error. A sample whose run fails, or whose output is not a number, counts as one without the event, and is
/// counted.
///
/// ```
/// use lagrange_runtime::ensemble::{ClosedForm, ConfidenceInterval, SubsetSimulation};
/// // A sum of two normal numbers beyond 6.72: 1.0e-6.
/// let sum = ClosedForm::new(|[a, b]: [f64; 2]| a + b);
/// let event = SubsetSimulation::new(1, 1000, 6.722, sum).run()?;
/// println!("{:.1e} ± {:.0} %, by {} runs", event.probability, 100.0 * event.coefficient_of_variation, event.evaluations);
/// let [low, high] = event.confidence_interval(0.95);
/// assert!(low < 1e-6 && 1e-6 < high && event.evaluations < 60_000);
/// # Ok::<(), lagrange_runtime::ensemble::EnsembleError>(())
/// ```
pub struct SubsetSimulation<'p, F, const D: usize> {
    seed: u64,
    samples: u64,
    threshold: f64,
    runs: u64,
    model: F,
    settings: Settings<'p>,
}

impl<F: fmt::Debug, const D: usize> fmt::Debug for SubsetSimulation<'_, F, D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let SubsetSimulation { seed, samples, threshold, runs, model, .. } = self;
        f.debug_struct("SubsetSimulation")
            .field("seed", seed)
            .field("samples", samples)
            .field("threshold", threshold)
            .field("runs", runs)
            .field("model", model)
            .finish_non_exhaustive()
    }
}

/// A level of a [`SubsetSimulation`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SubsetLevel {
    /// The output beyond which the samples of the next level lie; of the last level, the threshold of the event.
    pub beyond: f64,
    /// The part of the samples that lies beyond it.
    pub probability: f64,
    /// Correlation within chains, γ: 0 if the samples are independent, as those of the first level.
    pub correlation: f64,
    /// The part of the chains' steps that led to another sample; 1 at the first level.
    pub acceptance: f64,
}

record_fields!(SubsetLevel { beyond, probability, correlation, acceptance });

/// One of the independent runs of a [`SubsetSimulation`].
#[derive(Clone, Debug, PartialEq)]
pub struct SubsetRun {
    /// Its estimate of the probability.
    pub probability: f64,
    /// The levels that led to the event.
    pub levels: Vec<SubsetLevel>,
}

record_fields!(SubsetRun { probability, levels });

/// Result of a [`SubsetSimulation`], whose interval [`ConfidenceInterval`] gives.
#[derive(Clone, Debug, PartialEq)]
pub struct RareEvent {
    /// The probability of the event.
    pub probability: f64,
    /// The coefficient of variation of that estimate, δ = √(s²/R + s⁴/(2 (R − 1))), by the variance s² of the
    /// logarithms of R runs.
    pub coefficient_of_variation: f64,
    /// The runs, of which the estimate is the mean.
    pub runs: Vec<SubsetRun>,
    /// The number of evaluations of the model.
    pub evaluations: u64,
    /// Their cost: work times that of a unit of work, see [`Model`](super::Model).
    pub cost: f64,
    /// The number of evaluations that failed, or whose output is not a number: they count as samples without the event.
    pub failed: u64,
}

/// The interval of Cox for the mean of lognormal numbers, by Student's t (Olsson, *J. Statist. Educ.* 13, 2005):
/// exp(ȳ + s²/2 ± t √(s²/R + s⁴/(2 (R − 1)))), with the mean ȳ and variance s² of the logarithms of the R runs.
impl ConfidenceInterval for RareEvent {
    fn confidence_interval(&self, confidence: f64) -> [f64; 2] {
        let logarithms = Moment::of(self.runs.iter().map(|run| run.probability.ln()));
        let middle = logarithms.mean() + 0.5 * logarithms.variance();
        let freedom = self.runs.len() as f64 - 1.0;
        let half = student_quantile(two_sided(confidence), freedom) * self.coefficient_of_variation;
        [(middle - half).exp(), (middle + half).exp().min(1.0)]
    }
}

/// The model at many inputs, by all threads.
type Evaluate<'a, const D: usize> = dyn Fn(Vec<[f64; D]>) -> Vec<Evaluated<f64>> + 'a;

/// A sample: its input, its output, and the chain of its level to which it belongs.
#[derive(Clone, Copy, Debug)]
struct Sample<const D: usize> {
    input: [f64; D],
    output: f64,
    chain: u64,
}

record_fields!(Sample<; D> { input, output, chain });

/// Progress of a study: the runs that are done, and of the next one its levels and the samples of the one that is
/// reached.
#[derive(Clone, Debug, Default)]
struct State<const D: usize> {
    runs: Vec<SubsetRun>,
    levels: Vec<SubsetLevel>,
    samples: Vec<Sample<D>>,
    acceptance: f64,
    /// Standard deviation of a step of the chains.
    step: f64,
    work: u64,
    evaluations: u64,
    failed: u64,
}

record_fields!(State<; D> { runs, levels, samples, acceptance, step, work, evaluations, failed });

/// Correlation γ of the indicator of `beyond` within chains of samples that stand in the order of steps, and in each
/// step in that of chains.
fn correlation<const D: usize>(samples: &[Sample<D>], beyond: f64, p: f64) -> f64 {
    let chains = samples.iter().map(|sample| sample.chain).max().map_or(0, |last| last as usize + 1);
    let indicator = |sample: &Sample<D>| f64::from(u8::from(sample.output > beyond));
    let n = samples.len() as f64;
    let length = samples.len().div_ceil(chains.max(1));
    let variance = p * (1.0 - p);
    if chains == samples.len() || variance == 0.0 {
        return 0.0;
    }
    let of_lag = |lag: usize| {
        let pairs = samples.iter().zip(samples.iter().skip(lag * chains));
        let (sum, count) =
            pairs.fold((0.0, 0.0), |(sum, count), (a, b)| (sum + indicator(a) * indicator(b), count + 1.0));
        // The number of pairs is the weight (1 − k chains/n).
        (sum / count - p * p) / variance * (count / n)
    };
    2.0 * (1..length).map(of_lag).sum::<f64>()
}

impl<'p, F: Model<[f64; D], Output = f64>, const D: usize> SubsetSimulation<'p, F, D> {
    /// The probability that the output of a model exceeds a threshold, by so many samples a level.
    pub fn new(seed: u64, samples: u64, threshold: f64, model: F) -> Self {
        SubsetSimulation { seed, samples, threshold, runs: 10, model, settings: Settings::default() }
    }

    /// Sets the number of independent runs, instead of 10: their scatter is the error.
    #[must_use]
    pub fn runs(self, runs: u64) -> Self {
        SubsetSimulation { runs, ..self }
    }

    set_settings!();

    /// Makes the runs, level by level.
    ///
    /// # Errors
    /// If there are fewer than 100 samples a level or 2 runs, the threshold is not finite, the output does not lead
    /// to the event (too many equal ones, or no progress in 50 levels), or is nowhere a number; those of checkpoints.
    pub fn run(&self) -> Result<RareEvent, EnsembleError> {
        let SubsetSimulation { seed, samples, threshold, runs, model, settings } = self;
        let refused = |what: String| Err(EnsembleError::Refused(what));
        model.check().map_err(EnsembleError::Refused)?;
        if !(100..=1 << 32).contains(samples) {
            return refused(format!(
                "a level has 100 to 2³² samples, but {samples} were asked for; help: take 1000, and more for a smaller error"
            ));
        }
        if !(2..=1 << 15).contains(runs) {
            return refused(format!(
                "the error is the scatter of 2 to 32768 runs, but {runs} were asked for; help: take 10, as `.runs(10)`"
            ));
        }
        if !threshold.is_finite() || D == 0 {
            return refused(format!(
                "a rare event has inputs and a finite threshold, but {D} inputs and {threshold:?} were given"
            ));
        }
        let source = Random::seed(*seed);
        let pool = settings.driver(*samples).pool()?;
        let began = Stopwatch::start();
        let description = [
            format!("name: {}", settings.name),
            format!("source: {}, {D} standard normal numbers", source.describe()),
            format!("samples: {runs} runs of {samples} a level"),
            format!("model: {}", model.describe([0.0; D])),
            format!("subset simulation: beyond {threshold:?}"),
        ];
        let evaluate = |inputs: Vec<[f64; D]>| {
            evaluated_by(pool.as_ref(), model, inputs.len() as u64, &|k| inputs[k as usize])
        };
        let mut state: State<D> = match &settings.checkpoint {
            Some(checkpoint) => resumed(checkpoint, &description)?.unwrap_or_default(),
            None => State::default(),
        };
        let resumed = state.evaluations;
        while (state.runs.len() as u64) < *runs {
            if state.samples.is_empty() {
                self.first_level(&mut state, &source, &evaluate);
            } else {
                self.level(&mut state, &source, &evaluate)?;
            }
            if let Some(checkpoint) = &settings.checkpoint {
                checkpoint.write(&description, &reached(&state))?;
            }
            if let Some(tell) = &settings.progress {
                // How many levels are left is not known.
                let done = state.evaluations;
                let samples = done + samples * (runs - state.runs.len() as u64);
                tell(&Progress { done, samples, failed: state.failed, resumed, elapsed: began.elapsed() });
            }
        }
        let State { runs, work, evaluations, failed, .. } = state;
        let estimates = Moment::of(runs.iter().map(|run| run.probability));
        let (variance, count) =
            (Moment::of(runs.iter().map(|run| run.probability.ln())).variance(), runs.len() as f64);
        let square = variance / count + 0.5 * variance * variance / (count - 1.0);
        Ok(RareEvent {
            probability: estimates.mean(),
            coefficient_of_variation: square.sqrt(),
            cost: work as f64 * model.unit_cost(),
            runs,
            evaluations,
            failed,
        })
    }

    /// Fills the first level of a run by independent samples.
    fn first_level(&self, state: &mut State<D>, source: &Random, evaluate: &Evaluate<'_, D>) {
        let run = state.runs.len() as u64;
        let input = |index: u64| {
            let mut rng = source.draw(run << 48 | index);
            core::array::from_fn(|_| StandardNormal.sample(&mut rng))
        };
        let inputs: Vec<[f64; D]> = (0..self.samples).map(input).collect();
        let outputs = evaluate(inputs.clone());
        for (chain, (input, evaluated)) in (0..).zip(inputs.into_iter().zip(outputs)) {
            let output = state.count(evaluated.output.ok(), evaluated.work);
            state.samples.push(Sample { input, output, chain });
        }
        (state.acceptance, state.step) = (1.0, 1.0);
    }

    /// Ends a level, and fills the next one or ends the run.
    fn level(
        &self,
        state: &mut State<D>,
        source: &Random,
        evaluate: &Evaluate<'_, D>,
    ) -> Result<(), EnsembleError> {
        let threshold = self.threshold;
        let (n, level) = (state.samples.len(), state.levels.len());
        // The outputs from the largest on.
        let mut ranked: Vec<f64> = state.samples.iter().map(|sample| sample.output).collect();
        ranked.sort_by(|a, b| b.total_cmp(a));
        let wanted = (PART * n as f64).ceil() as usize;
        let beyond = ranked.get(wanted).copied().unwrap_or(f64::NEG_INFINITY).min(threshold);
        let count = state.samples.iter().filter(|sample| sample.output > beyond).count();
        let refused = |what: String| Err(EnsembleError::Refused(what));
        if beyond == f64::NEG_INFINITY {
            return refused(format!(
                "{} of {} outputs are not numbers, so that no level leads to the event",
                state.failed, state.evaluations
            ));
        }
        if count == 0 {
            return refused(format!(
                "the output has the same largest value {beyond:?} in more than a tenth of the samples of level {level}, so that no level leads to the \
                 event; help: give an output that grows towards the event, as a height instead of `true`"
            ));
        }
        let probability = count as f64 / n as f64;
        let correlation = correlation(&state.samples, beyond, probability);
        let acceptance = state.acceptance;
        state.levels.push(SubsetLevel { beyond, probability, correlation, acceptance });
        if beyond >= threshold {
            let levels = core::mem::take(&mut state.levels);
            let probability = levels.iter().map(|level| level.probability).product();
            state.runs.push(SubsetRun { probability, levels });
            state.samples.clear();
        } else if state.levels.len() == MOST_LEVELS {
            return refused(format!(
                "after {MOST_LEVELS} levels the output is beyond {beyond:?} and not beyond {threshold:?}; help: look whether it can come there at all"
            ));
        } else {
            self.next_level(state, beyond, source, evaluate);
        }
        Ok(())
    }

    /// Fills the next level by chains from the samples beyond the last one.
    fn next_level(&self, state: &mut State<D>, beyond: f64, source: &Random, evaluate: &Evaluate<'_, D>) {
        let mut chains: Vec<Sample<D>> =
            state.samples.iter().filter(|sample| sample.output > beyond).copied().collect();
        chains.iter_mut().zip(0..).for_each(|(start, chain)| start.chain = chain);
        let mut samples = chains.clone();
        let (mut steps, mut moves) = (0u64, 0u64);
        while (samples.len() as u64) < self.samples {
            let left = self.samples as usize - samples.len();
            let first = samples.len() as u64;
            let stream = (state.runs.len() as u64) << 48 | (state.levels.len() as u64) << 40;
            let candidates: Vec<[f64; D]> = (chains.iter().take(left))
                .zip(first..)
                .map(|(at, index)| candidate(&at.input, state.step, &mut source.draw(stream | index)))
                .collect();
            // Those that are where they were need no evaluation.
            let moved: Vec<[f64; D]> = (candidates.iter().zip(&chains))
                .filter(|(candidate, at)| **candidate != at.input)
                .map(|(candidate, _)| *candidate)
                .collect();
            let mut evaluated = evaluate(moved).into_iter();
            for (candidate, at) in candidates.into_iter().zip(&mut chains) {
                steps += 1;
                if candidate != at.input
                    && let Some(evaluated) = evaluated.next()
                {
                    let output = state.count(evaluated.output.ok(), evaluated.work);
                    if output > beyond {
                        (at.input, at.output) = (candidate, output);
                        moves += 1;
                    }
                }
                samples.push(*at);
            }
        }
        state.acceptance = moves as f64 / steps.max(1) as f64;
        state.step *= (ADAPTATION * (state.acceptance - BEST_ACCEPTANCE)).exp();
        state.samples = samples;
    }
}

impl<const D: usize> State<D> {
    /// Counts an evaluation. Its output, below all others where there is none.
    fn count(&mut self, output: Option<f64>, work: u64) -> f64 {
        self.evaluations += 1;
        self.work += work;
        match output.filter(|output| !output.is_nan()) {
            Some(output) => output,
            None => {
                self.failed += 1;
                f64::NEG_INFINITY
            }
        }
    }
}

/// A step of the modified Metropolis algorithm: each component is moved by a normal number of this standard
/// deviation, and stays where it was with the probability that the ratio of the normal densities says.
fn candidate<const D: usize>(at: &[f64; D], deviation: f64, rng: &mut <Random as Source>::Draw) -> [f64; D] {
    at.map(|x| {
        let step: f64 = StandardNormal.sample(rng);
        let u: f64 = StandardUniform.sample(rng);
        let to = x + deviation * step;
        if u < (0.5 * (x * x - to * to)).exp() { to } else { x }
    })
}

/// A state in the form of checkpoints: one node of one leaf.
fn reached<const D: usize>(state: &State<D>) -> Reached<State<D>> {
    let tree = Tree { nodes: vec![(0, 0, state.clone())] };
    Reached { first: 0, end: 1, next: 1, tree, failed: state.failed, kept: vec![] }
}

/// The state in a checkpoint, if there is one.
fn resumed<const D: usize>(
    checkpoint: &Checkpoint,
    description: &[String],
) -> Result<Option<State<D>>, EnsembleError> {
    let reached: Option<Reached<State<D>>> = checkpoint.read(description, LEAF)?;
    Ok(reached.and_then(|mut reached| Some(reached.tree.nodes.pop()?.2)))
}
