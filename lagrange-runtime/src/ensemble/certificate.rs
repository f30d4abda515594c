//! A certificate of a simplified model: its error over a scene, and how much a sample of it can promise.

use super::distribution::binomial_tail;
use super::drive::{Compute, Part, Through, larger, parts, samples};
use super::model::{Evaluated, Model, evaluated};
use super::multifidelity::FailedEvaluation;
use super::precision::merged;
use super::record::record_fields;
use super::settings::{Settings, set_settings};
use super::{EnsembleError, LEAF, Source, Statistic};
use crate::failure::debug_is_text;
use core::fmt;
use core::ops::Range;

/// Certification of a simplified model: both models run over the samples of a scene, and the error of each of `K`
/// outputs is ranked.
///
/// What ranks promise holds for any distribution (Wilks, *Ann. Math. Statist.* 12, 1941): of n independent samples
/// the largest error exceeds the q-quantile of the error with probability 1 − qⁿ, and the r-th smallest one with
/// P(Bin(n, q) < r). So [`Certificate::holds`] says that a part q of all draws of the scene, 0.999 say, have errors
/// within what is allowed, and is wrong with a probability of 1 − 0.95 at most. It refuses where n is too small for
/// that.
///
/// A sample that one of the models fails, or of which an output is not finite, counts as an infinite error: put the
/// simplified model into an [`InRange`](crate::lanes::InRange), and a draw that leads out of its range is one.
///
/// ```
/// use lagrange_runtime::ensemble::{Certification, Random, Simulation, rand_distr::{Distribution, Uniform}};
/// use lagrange_runtime::lanes::{FinalState, InRange};
/// use lagrange_runtime::prelude::*;
/// lagrangian! {
///     pub system Pendulum {
///         coord theta;
///         T = 0.5 * dot(theta).powi(2);
///         V = -cos(theta);
///     }
/// }
/// lagrangian! {
///     /// The same for small angles.
///     pub system Small {
///         coord theta;
///         T = 0.5 * dot(theta).powi(2);
///         V = 0.5 * theta.powi(2);
///     }
/// }
/// let release = Uniform::new(-0.2, 0.2)?;
/// let start = |mut rng| State::new(0.0, [release.sample(&mut rng)], [0.0]);
/// let angle = FinalState(|_: &Pendulum, end: &State<f64, 1>| [end.q[0]]);
/// let linear = InRange::new([-0.25..=0.25], FinalState(|_: &Small, end: &State<f64, 1>| [end.q[0]]));
/// let (method, tolerance) = (Dop853, PiController::tolerance(1e-9));
/// let full = Simulation::new(|rng| (Pendulum::new(), start(rng)), method, tolerance, 6.0, angle);
/// let small = Simulation::new(|rng| (Small::new(), start(rng)), method, tolerance, 6.0, linear);
/// // The last line of a `#[test]`: of all such releases, 99 % have an error below 0.005.
/// Certification::new(Random::seed(1), 500, [0.005], full, small).run()?.holds(0.99, 0.95)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Certification<'p, Src, F, G, const K: usize> {
    source: Src,
    samples: u64,
    allowed: [f64; K],
    full: F,
    simplified: G,
    settings: Settings<'p>,
}

impl<Src: fmt::Debug, F: fmt::Debug, G: fmt::Debug, const K: usize> fmt::Debug
    for Certification<'_, Src, F, G, K>
{
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Certification { source, samples, allowed, full, simplified, .. } = self;
        f.debug_struct("Certification")
            .field("source", source)
            .field("samples", samples)
            .field("allowed", allowed)
            .field("full", full)
            .field("simplified", simplified)
            .finish_non_exhaustive()
    }
}

/// The sample with the largest error of an output.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Worst {
    /// Its index, by which [`Certification::draw`] gives its draw.
    pub index: u64,
    /// The error, |simplified − full| in the unit of the output; infinite if a model failed.
    pub error: f64,
    /// The output of the full model; NaN if it failed.
    pub full: f64,
    /// The output of the simplified one; NaN if it failed.
    pub simplified: f64,
}

record_fields!(Worst { index, error, full, simplified });

/// Result of a [`Certification`].
#[derive(Clone, Debug, PartialEq)]
pub struct Certificate<const K: usize> {
    /// The sample with the largest error of each output, the first of equal ones.
    pub worst: [Worst; K],
    /// The number of samples that a model failed.
    pub failed: u64,
    /// The first of them.
    pub failures: Vec<FailedEvaluation>,
    /// Cost of all samples, of the full model and the simplified one.
    pub cost: [f64; 2],
    allowed: [f64; K],
    /// Errors of each output, the smallest first.
    errors: [Vec<f64>; K],
}

/// Reason why a certificate does not hold.
#[non_exhaustive]
#[derive(Clone, Copy, PartialEq)]
pub enum NotCertified {
    /// The samples are too few to promise anything of this quantile.
    TooFewSamples {
        /// The number of samples.
        samples: u64,
        /// The number that is needed.
        needed: u64,
    },
    /// The bound of the quantile is larger than the error allowed.
    TooLarge {
        /// The output.
        output: usize,
        /// The bound of the quantile of its error.
        bound: f64,
        /// The error allowed.
        allowed: f64,
        /// The sample with the largest error.
        worst: Worst,
    },
    /// A probability is not between 0 and 1.
    NoProbability {
        /// The number.
        given: f64,
    },
}

impl fmt::Display for NotCertified {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooFewSamples { samples, needed } => write!(
                f,
                "{samples} samples cannot bound that quantile with that confidence; help: take {needed} samples, or a smaller quantile"
            ),
            Self::TooLarge { output, bound, allowed, worst } => write!(
                f,
                "the quantile of the error of output {output} is below {bound:.3e}, which is more than the {allowed:.3e} allowed; the worst sample is \
                 {}, where the simplified model has {:?} instead of {:?}",
                worst.index, worst.simplified, worst.full
            ),
            Self::NoProbability { given } => {
                write!(f, "quantiles and confidences are between 0 and 1, as 0.999, but here is {given:?}")
            }
        }
    }
}

debug_is_text! { [] NotCertified }

impl std::error::Error for NotCertified {}

/// Returns the least number of samples whose largest error bounds the q-quantile with this confidence: 1 − qⁿ ≥
/// confidence. It is 2995 for 0.999 and 0.95. `None` unless both are between 0 and 1.
pub fn samples_for(quantile: f64, confidence: f64) -> Option<u64> {
    let is_probability = |p: f64| p > 0.0 && p < 1.0;
    if !is_probability(quantile) || !is_probability(confidence) {
        return None;
    }
    let promised = |n: u64| -(quantile.ln() * n as f64).exp_m1() >= confidence;
    // The logarithms have errors of rounding: the neighbours decide.
    let near = ((-confidence).ln_1p() / quantile.ln()).ceil() as u64;
    (near.saturating_sub(2)..).find(|&n| promised(n))
}

impl<const K: usize> Certificate<K> {
    /// The number of samples, failed ones included.
    pub fn samples(&self) -> u64 {
        self.errors.first().map_or(0, |errors| errors.len() as u64)
    }

    /// The largest error of an output, in its unit; NaN if there is no such output.
    pub fn maximum(&self, output: usize) -> f64 {
        self.errors.get(output).and_then(|errors| errors.last()).copied().unwrap_or(f64::NAN)
    }

    /// The q-quantile of the error of an output among the samples, the ⌈q n⌉-th smallest; NaN if there is no such
    /// output.
    pub fn quantile(&self, output: usize, q: f64) -> f64 {
        let rank = |errors: &Vec<f64>| ((q * errors.len() as f64).ceil() as usize).clamp(1, errors.len());
        let Some(errors) = self.errors.get(output).filter(|errors| !errors.is_empty()) else {
            return f64::NAN;
        };
        errors[rank(errors) - 1]
    }

    /// Confidence that the q-quantile of the error of the whole scene, of each output, lies at or below the largest
    /// error of the samples: 1 − qⁿ.
    pub fn confidence_of_maximum(&self, q: f64) -> f64 {
        1.0 - q.powf(self.samples() as f64)
    }

    /// Upper bound of the q-quantile of the error of an output over the scene, with this confidence: the least r-th
    /// smallest error with P(Bin(n, q) < r) ≥ confidence.
    ///
    /// # Errors
    /// If even the largest error is no such bound: there are too few samples.
    pub fn bound(&self, output: usize, q: f64, confidence: f64) -> Result<f64, NotCertified> {
        for given in [q, confidence] {
            if !(given > 0.0 && given < 1.0) {
                return Err(NotCertified::NoProbability { given });
            }
        }
        let n = self.samples();
        let needed = samples_for(q, confidence).unwrap_or(u64::MAX);
        if n < needed {
            return Err(NotCertified::TooFewSamples { samples: n, needed });
        }
        let promised = |rank: u64| 1.0 - binomial_tail(rank, n, q) >= confidence;
        // The probability grows with the rank.
        let (mut low, mut high) = (0, n);
        while high - low > 1 {
            let middle = low + (high - low) / 2;
            if promised(middle) {
                high = middle;
            } else {
                low = middle;
            }
        }
        let error = |errors: &Vec<f64>| errors.get(high as usize - 1).copied();
        Ok(self.errors.get(output).and_then(error).unwrap_or(f64::NAN))
    }

    /// Succeeds if a part q of the draws of the scene have errors within those allowed, each output for itself, with
    /// this confidence.
    ///
    /// # Errors
    /// If an output's bound is larger than the error allowed, with the worst sample; if there are too few samples,
    /// with the number that is needed.
    pub fn holds(&self, q: f64, confidence: f64) -> Result<(), NotCertified> {
        for output in 0..K {
            let (bound, allowed) = (self.bound(output, q, confidence)?, self.allowed[output]);
            if bound.is_nan() || bound > allowed {
                return Err(NotCertified::TooLarge { output, bound, allowed, worst: self.worst[output] });
            }
        }
        Ok(())
    }
}

/// A table: of each output the median, the quantiles of 0.9, 0.99 and 0.999, the maximum, and where that is.
impl<const K: usize> fmt::Display for Certificate<K> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{} samples, of which {} failed", self.samples(), self.failed)?;
        writeln!(
            f,
            "output     allowed         0.5         0.9        0.99       0.999     maximum  at sample"
        )?;
        for (output, worst) in self.worst.iter().enumerate() {
            write!(f, "{output:6}  {:10.3e}", self.allowed[output])?;
            for q in [0.5, 0.9, 0.99, 0.999] {
                write!(f, "  {:10.3e}", self.quantile(output, q))?;
            }
            writeln!(f, "  {:10.3e}  {}", worst.error, worst.index)?;
        }
        Ok(())
    }
}

/// Outputs of both models at a sample, NaN where one failed, and their work.
struct Both<const K: usize> {
    outputs: [[f64; K]; 2],
    work: [u64; 2],
}

#[derive(Clone, Debug)]
struct Errors<const K: usize> {
    errors: [Vec<f64>; K],
    worst: [Worst; K],
    work: [u64; 2],
}

record_fields!(Errors<; K> { errors, worst, work });

struct Ranked;

impl<const K: usize> Statistic<Both<K>> for Ranked {
    type State = Errors<K>;

    fn empty(&self) -> Errors<K> {
        // Any error is larger.
        let worst = Worst { index: u64::MAX, error: -1.0, full: f64::NAN, simplified: f64::NAN };
        Errors { errors: core::array::from_fn(|_| vec![]), worst: [worst; K], work: [0; 2] }
    }

    fn add(&self, state: &mut Errors<K>, index: u64, both: &Both<K>) {
        for (k, (errors, worst)) in state.errors.iter_mut().zip(&mut state.worst).enumerate() {
            let [full, simplified] = both.outputs.map(|outputs| outputs[k]);
            let difference = (simplified - full).abs();
            let error = if difference.is_finite() { difference } else { f64::INFINITY };
            errors.push(error);
            if error > worst.error {
                *worst = Worst { index, error, full, simplified };
            }
        }
        (0..2).for_each(|model| state.work[model] += both.work[model]);
    }

    fn merge(&self, state: &mut Errors<K>, later: Errors<K>) {
        for (errors, mut later) in state.errors.iter_mut().zip(later.errors) {
            errors.append(&mut later);
        }
        for (worst, later) in state.worst.iter_mut().zip(later.worst) {
            if later.error > worst.error {
                *worst = later;
            }
        }
        (0..2).for_each(|model| state.work[model] += later.work[model]);
    }

    fn describe(&self) -> String {
        format!("errors of {K} outputs")
    }
}

/// The way samples are computed: by both models.
struct SideBySide<'a, Src, F, G> {
    source: &'a Src,
    samples: u64,
    full: &'a F,
    simplified: &'a G,
}

impl<Src, F, G> SideBySide<'_, Src, F, G> {
    fn outputs<const K: usize>(&self, range: Range<u64>) -> Vec<(u64, Both<K>, Option<FailedEvaluation>)>
    where
        Src: Source,
        F: Model<Src::Draw, Output = [f64; K]>,
        G: Model<Src::Draw, Output = [f64; K]>,
    {
        let draws = || range.clone().map(|index| self.source.draw(index)).collect();
        let both = evaluated(self.full, draws()).into_iter().zip(evaluated(self.simplified, draws()));
        let one = |(index, (full, simplified)): (u64, (Evaluated<[f64; K]>, Evaluated<[f64; K]>))| {
            let both = [full, simplified];
            let failed = both.iter().enumerate().find_map(|(model, evaluated)| {
                Some(FailedEvaluation { index, model, failure: evaluated.output.err()? })
            });
            let outputs = both.map(|evaluated| evaluated.output.unwrap_or([f64::NAN; K]));
            (index, Both { outputs, work: both.map(|evaluated| evaluated.work) }, failed)
        };
        range.clone().zip(both).map(one).collect()
    }
}

impl<Src, F, G, const K: usize> Compute<Both<K>> for SideBySide<'_, Src, F, G>
where
    Src: Source,
    F: Model<Src::Draw, Output = [f64; K]>,
    G: Model<Src::Draw, Output = [f64; K]>,
{
    const GROUP: u64 = larger(F::GROUP, G::GROUP);

    type Failed = FailedEvaluation;

    fn leaves<T: Statistic<Both<K>>>(
        &self,
        leaves: Range<u64>,
        statistic: &T,
    ) -> Vec<Part<T::State, FailedEvaluation>> {
        parts(leaves.clone(), statistic, self.outputs(samples(leaves, self.samples)))
    }

    fn failure(&self, index: u64) -> Option<FailedEvaluation> {
        self.outputs(index..index + 1).into_iter().find_map(|(.., failed)| failed)
    }
}

impl<'p, Src, F, G, const K: usize> Certification<'p, Src, F, G, K>
where
    Src: Source,
    F: Model<Src::Draw, Output = [f64; K]>,
    G: Model<Src::Draw, Output = [f64; K]>,
{
    /// A scene: a source of independent draws and a number of samples, the error allowed in each output, in its unit,
    /// the full model and the simplified one.
    pub fn new(source: Src, samples: u64, allowed: [f64; K], full: F, simplified: G) -> Self {
        Certification { source, samples, allowed, full, simplified, settings: Settings::default() }
    }

    set_settings!();

    /// The draw of a sample, as of the worst one.
    ///
    /// # Errors
    /// If there is no such sample.
    pub fn draw(&self, index: u64) -> Result<Src::Draw, EnsembleError> {
        let samples = self.samples;
        if index >= samples {
            return Err(EnsembleError::NoSuchSample { index, samples });
        }
        self.source.check(samples)?;
        Ok(self.source.draw(index))
    }

    /// Runs both models over all samples.
    ///
    /// # Errors
    /// If the study makes no sense: no samples or outputs, an error allowed that is negative or not a number, models
    /// without a cost.
    pub fn run(&self) -> Result<Certificate<K>, EnsembleError> {
        let Certification { source, samples, allowed, full, simplified, settings } = self;
        if *samples == 0 {
            return Err(EnsembleError::NoSamples);
        }
        source.check(*samples)?;
        full.check().map_err(EnsembleError::Refused)?;
        simplified.check().map_err(EnsembleError::Refused)?;
        if K == 0 {
            return Err(EnsembleError::Refused(
                "a certificate needs an output at least; help: `|_, end| [end.q[0]]`".into(),
            ));
        }
        if let Some(bad) = allowed.iter().find(|allowed| allowed.is_nan() || **allowed < 0.0) {
            return Err(EnsembleError::Refused(format!(
                "the error allowed has to be positive or zero, but it is {bad:?}; help: give one for each output, in its unit"
            )));
        }
        let how = SideBySide { source, samples: *samples, full, simplified };
        let description = [
            format!("name: {}", settings.name),
            format!("source: {}", source.describe()),
            format!("samples: {samples}, in leaves of {LEAF}"),
            format!("full model: {}", full.describe(source.draw(0))),
            format!("simplified model: {}", simplified.describe(source.draw(0))),
            Statistic::<Both<K>>::describe(&Ranked),
        ];
        let leaves = 0..samples.div_ceil(LEAF);
        let (reached, failures) =
            settings.driver(*samples).drive(&how, &Ranked, &description, leaves, &mut Through)?;
        let failed = reached.failed;
        let Errors { mut errors, worst, work } = merged(&Ranked, reached.tree);
        errors.iter_mut().for_each(|errors| errors.sort_by(f64::total_cmp));
        let cost = [work[0] as f64 * full.unit_cost(), work[1] as f64 * simplified.unit_cost()];
        Ok(Certificate { worst, failed, failures, cost, allowed: *allowed, errors })
    }
}
