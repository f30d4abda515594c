//! Quantiles of an expensive model with the help of a cheap one.

use super::{
    ByModels, FailedEvaluation, Goal, Kind, Multifidelity, PAIRS, Paired, Pilot, ToGoal, are_frequent,
};
use crate::ensemble::checkpoint::Reached;
use crate::ensemble::distribution::student_quantile;
use crate::ensemble::drive::Course;
use crate::ensemble::model::Model;
use crate::ensemble::precision::{HalfWidth, merged};
use crate::ensemble::record::record_fields;
use crate::ensemble::statistic::interval::two_sided;
use crate::ensemble::{ConfidenceInterval, EnsembleError, Source, Statistic};
use std::sync::OnceLock;

/// Result of [`Multifidelity::quantile_to_half_width`] and [`Multifidelity::quantile_within_budget`]: an estimate of a
/// quantile, whose interval [`ConfidenceInterval`] gives.
#[derive(Clone, Debug, PartialEq)]
pub struct QuantileEstimate {
    /// The pilot: correlation and standard deviations are those of the indicators `f ≤ y` and `g ≤ c`, where y and c
    /// are the quantiles that the pilot has found.
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
    p: f64,
    weighed: Weighed,
}

impl QuantileEstimate {
    /// The probability of which this is the quantile.
    pub fn probability(&self) -> f64 {
        self.p
    }

    /// The estimate of the quantile, `inf {y: F̂(y) ≥ p}`.
    pub fn quantile(&self) -> f64 {
        self.weighed.inverse(self.p)
    }

    /// The number of samples of the full model that would have had the same standard error of F without the cheap one.
    pub fn plain_samples(&self) -> f64 {
        self.p * (1.0 - self.p) / self.weighed.variance(self.p)
    }
}

/// Test inversion (Woodruff, *J. Amer. Statist. Assoc.* 47, 1952): all y at which F̂(y) is within Student's t times its
/// standard error of p. An end is infinite where the samples are too few to bound it.
impl ConfidenceInterval for QuantileEstimate {
    fn confidence_interval(&self, confidence: f64) -> [f64; 2] {
        self.weighed.interval(self.p, confidence)
    }
}

/// Outputs of the full model in increasing order, of the samples in which the cheap one is up to its quantile and
/// beyond it, and the probabilities of both: F̂ is the sum of their distributions with these weights.
#[derive(Clone, Debug, PartialEq)]
struct Weighed {
    strata: [Vec<f64>; 2],
    weights: [f64; 2],
    /// Samples of the cheap model.
    all: f64,
}

impl Weighed {
    fn new(state: &Strata, pilot: &Pilot) -> Self {
        // (Where one model alone has an output, the cheap one says nothing of the other's.)
        let mut strata = match pilot.gain.filter(|_| state.unlike[1] == 0) {
            Some(_) => state.pairs.clone(),
            None => [[&state.full[..], &state.pairs[0], &state.pairs[1]].concat(), vec![]],
        };
        strata.iter_mut().for_each(|outputs| outputs.sort_by(f64::total_cmp));
        let pairs = [0, 1].map(|h| strata[h].len() as f64);
        let own = pairs[0] + pairs[1];
        // (Without samples on one side there is nothing to weigh.)
        let others = if pairs.contains(&0.0) { [0.0; 2] } else { state.cheap.map(|count| count as f64) };
        let all = own + others[0] + others[1];
        Weighed { weights: [0, 1].map(|h| (pairs[h] + others[h]) / all), strata, all }
    }

    /// F̂ of both strata at y.
    fn parts(&self, y: f64) -> [f64; 2] {
        [0, 1].map(|h| {
            let outputs = &self.strata[h];
            outputs.partition_point(|x| *x <= y) as f64 / (outputs.len() as f64).max(1.0)
        })
    }

    fn distribution(&self, y: f64) -> f64 {
        let parts = self.parts(y);
        self.weights[0] * parts[0] + self.weights[1] * parts[1]
    }

    /// The least output at which F̂ is p at least, infinite beyond them.
    fn inverse(&self, p: f64) -> f64 {
        if p.is_nan() {
            return f64::NAN;
        }
        if p <= 0.0 {
            return f64::NEG_INFINITY;
        }
        // (By rounding the sum of weights may be below 1.)
        let reaches = |y: &f64| self.distribution(*y) >= p - 4.0 * f64::EPSILON;
        let least = |outputs: &Vec<f64>| outputs.get(outputs.partition_point(|y| !reaches(y))).copied();
        let found = self.strata.iter().filter_map(least).fold(f64::INFINITY, f64::min);
        if p > 1.0 { f64::INFINITY } else { found }
    }

    /// Variance of F̂ at the quantile of p: within the strata over the pairs, and between them over all samples (double
    /// sampling for stratification: Cochran, *Sampling Techniques*, 1977, 12.2; 5A.42 for strata of random sizes).
    fn variance(&self, p: f64) -> f64 {
        let parts = self.parts(self.inverse(p));
        let n = self.strata.iter().map(|outputs| outputs.len() as f64).sum::<f64>();
        let of = |h: usize| {
            let [size, part, weight] = [self.strata[h].len() as f64, parts[h], self.weights[h]];
            // (Where all of few outputs are on one side, half of one is taken for the other.)
            let part = part.clamp(0.5 / (size + 1.0), 1.0 - 0.5 / (size + 1.0));
            let within = part * (1.0 - part) * size / (size - 1.0).max(1.0);
            (weight + (1.0 - weight) / n) * within / n + weight * (part - p).powi(2) / self.all
        };
        [0, 1].into_iter().filter(|&h| !self.strata[h].is_empty()).map(of).sum()
    }

    fn interval(&self, p: f64, confidence: f64) -> [f64; 2] {
        let n = self.strata.iter().map(Vec::len).sum::<usize>();
        let half = student_quantile(two_sided(confidence), n as f64 - 1.0) * self.variance(p).sqrt();
        [self.inverse(p - half), self.inverse(p + half)]
    }
}

/// Outputs and counts of all parts of a study.
#[derive(Clone, Debug)]
struct Strata {
    pilot: Vec<[f64; 2]>,
    /// Outputs of the full model where the cheap one is up to its quantile, and beyond.
    pairs: [Vec<f64>; 2],
    full: Vec<f64>,
    cheap: [u64; 2],
    pilot_work: [u64; 2],
    work: [u64; 2],
    not_finite: u64,
    /// Samples of the pilot, and pairs after it, in which one model alone has an output.
    unlike: [u64; 2],
}

record_fields!(Strata { pilot, pairs, full, cheap, pilot_work, work, not_finite, unlike });

/// Sorts samples by the quantile of the cheap model, which the pilot has found.
struct Stratified<'a> {
    threshold: &'a OnceLock<f64>,
}

impl Statistic<Paired> for Stratified<'_> {
    type State = Strata;

    fn empty(&self) -> Strata {
        Strata {
            pilot: vec![],
            pairs: [vec![], vec![]],
            full: vec![],
            cheap: [0; 2],
            pilot_work: [0; 2],
            work: [0; 2],
            not_finite: 0,
            unlike: [0; 2],
        }
    }

    fn add(&self, state: &mut Strata, _: u64, sample: &Paired) {
        let work = if sample.kind == Kind::Pilot { &mut state.pilot_work } else { &mut state.work };
        (0..2).for_each(|model| work[model] += sample.work[model]);
        let [full, cheap] = sample.outputs;
        state.not_finite += u64::from(sample.is_not_finite());
        if sample.is_unlike() {
            state.unlike[usize::from(sample.kind != Kind::Pilot)] += 1;
            if full.is_finite() {
                match sample.kind {
                    Kind::Pilot => state.pilot.push([full, f64::NAN]),
                    _ => state.full.push(full),
                }
            }
        }
        if !(full.is_finite() && cheap.is_finite()) {
            return;
        }
        let beyond = usize::from(self.threshold.get().is_some_and(|threshold| cheap > *threshold));
        match sample.kind {
            Kind::Pilot => state.pilot.push([full, cheap]),
            Kind::Pair => state.pairs[beyond].push(full),
            Kind::Cheap => state.cheap[beyond] += 1,
            Kind::Full => state.full.push(full),
        }
    }

    fn merge(&self, state: &mut Strata, later: Strata) {
        state.pilot.extend(later.pilot);
        state.full.extend(later.full);
        for (pairs, later) in state.pairs.iter_mut().zip(later.pairs) {
            pairs.extend(later);
        }
        for h in 0..2 {
            state.cheap[h] += later.cheap[h];
            state.pilot_work[h] += later.pilot_work[h];
            state.work[h] += later.work[h];
        }
        state.not_finite += later.not_finite;
        (0..2).for_each(|part| state.unlike[part] += later.unlike[part]);
    }

    fn describe(&self) -> String {
        "multifidelity quantile".into()
    }
}

/// The course of a study: that of the mean of the indicator `f ≤ y`, until the interval of the quantile is as wanted.
struct ToQuantile<'a> {
    p: f64,
    /// The half-width of the quantile that is wanted, if one is.
    half_width: Option<f64>,
    /// The goal for the indicator, in which a half-width is set by the pilot.
    mean: ToGoal<'a>,
    threshold: &'a OnceLock<f64>,
}

impl ToQuantile<'_> {
    /// The pilot of the indicators, and the density at the quantile.
    fn planned(&mut self, state: &Strata) -> Result<Pilot, EnsembleError> {
        let quantile_of = |model: usize, p: f64| {
            let mut outputs: Vec<f64> = state.pilot.iter().map(|pair| pair[model]).collect();
            outputs.sort_by(f64::total_cmp);
            let rank = (p * outputs.len() as f64).ceil() as usize;
            outputs.get(rank.clamp(1, outputs.len().max(1)) - 1).copied().unwrap_or(f64::NAN)
        };
        let [y, c] = [0, 1].map(|model| quantile_of(model, self.p));
        let threshold = *self.threshold.get_or_init(|| c);
        let mut indicators = PAIRS.empty();
        let mut agreeing = 0;
        // (All outputs are up to a quantile that is the largest of them.)
        let strictly = state.pilot.iter().all(|[full, _]| *full <= y);
        for (index, [full, cheap]) in state.pilot.iter().enumerate() {
            let pair = [if strictly { *full < y } else { *full <= y }, *cheap <= threshold];
            agreeing += u64::from(pair[0] == pair[1]);
            PAIRS.add(&mut indicators, index as u64, &pair.map(|holds| f64::from(u8::from(holds))));
        }
        if let Some(half_width) = self.half_width {
            // The slope of the distribution, over the scatter of the pilot's.
            let n = state.pilot.len() as f64;
            let apart = (2.0 * (self.p * (1.0 - self.p) / n).sqrt()).min(self.p).min(1.0 - self.p);
            let wide = quantile_of(0, self.p + apart) - quantile_of(0, self.p - apart);
            // (Few samples suffice for a quantile that many outputs share: the loop adds what is missing. The first
            // look is to suffice as a rule: an interval is narrow where it is too low, and a study that ends with the
            // first narrow one covers less.)
            let density = if wide > 0.0 { 2.0 * apart / wide } else { f64::INFINITY };
            let of_indicator = 0.9 * half_width * density;
            self.mean.goal = Goal::HalfWidth(of_indicator.clamp(1e-6, 0.25));
        }
        self.mean.pilot_of(&indicators, [agreeing, state.unlike[0]], state.pilot_work)
    }

    /// True if the interval is as narrow as wanted.
    fn is_met(&self, state: &Strata, pilot: &Pilot) -> bool {
        self.half_width.is_some_and(|wanted| {
            let weighed = Weighed::new(state, pilot);
            let [low, high] = weighed.interval(self.p, self.mean.confidence);
            // (Rare differences of the models have no variance that is known: at least 32 on either side.)
            let known = pilot.gain.is_none() || {
                let y = weighed.inverse(self.p);
                let [below, beyond] = &weighed.strata;
                let differing =
                    below.iter().filter(|x| **x > y).count() + beyond.iter().filter(|x| **x <= y).count();
                let pairs = (below.len() + beyond.len()) as u64;
                are_frequent(pairs, pairs - differing as u64)
            };
            known && 0.5 * (high - low) <= wanted
        })
    }
}

impl Course<Strata> for ToQuantile<'_> {
    fn next(&mut self, reached: &Reached<Strata>) -> Result<Option<u64>, EnsembleError> {
        if reached.next < self.mean.pilot {
            return Ok(Some(self.mean.pilot));
        }
        let threshold = self.threshold;
        let state = merged(&Stratified { threshold }, reached.tree.clone());
        let planned = self.planned(&state)?;
        let pilot = *self.mean.plan.get_or_init(|| planned);
        self.mean.look_after(reached.next, reached.end, &pilot, &|| self.is_met(&state, &pilot))
    }
}

impl<Src, F, G> Multifidelity<'_, Src, F, G>
where
    Src: Source,
    F: Model<Src::Draw, Output = f64>,
    G: Model<Src::Draw, Output = f64>,
{
    /// The quantile of a probability p of the full model's output, with a confidence interval of this half-width at
    /// most, in the unit of the output.
    ///
    /// The indicator `g ≤ c` is the control variate of `f ≤ y` for all y at once, c being the quantile of g in the
    /// pilot. With an indicator the best coefficient sorts the samples of f into two strata, whose probabilities the
    /// cheap model estimates (Hesterberg and Nelson, *Management Science* 44, 1998): F̂ is a distribution, and is
    /// inverted. The correlation of the indicators decides what it gains, which is less than that of the outputs.
    ///
    /// The outputs of the full model are kept in memory, and in checkpoints.
    ///
    /// ```
    /// use lagrange_runtime::ensemble::{ClosedForm, ConfidenceInterval, Multifidelity, Random, rand_distr::{Distribution, Normal}};
    /// let normal = Normal::new(0.0, 1.0)?;
    /// let full = ClosedForm::new(move |mut rng| { let x: f64 = normal.sample(&mut rng); x + 0.3 * normal.sample(&mut rng) });
    /// let cheap = ClosedForm::new(move |mut rng| -> f64 { normal.sample(&mut rng) }).cost(0.01);
    /// let study = Multifidelity::new(Random::seed(1), 10_000_000, full, cheap).pilot_samples(2048);
    /// let far = study.quantile_to_half_width(0.95, 0.08)?;
    /// println!("95 % are below {:.2} ± {:.2}, by {} full runs", far.quantile(), far.half_width(0.95), far.samples[0]);
    /// # assert!(far.reached && (far.quantile() - 1.717).abs() < 0.2);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As [`pilot`](Self::pilot); if p is not between 0 and 1, or the pilot has fewer than 8 samples on either side
    /// of the quantile; and if the half-width or confidence makes no sense.
    pub fn quantile_to_half_width(&self, p: f64, half_width: f64) -> Result<QuantileEstimate, EnsembleError> {
        HalfWidth::of(half_width).confidence(self.confidence).check()?;
        self.quantile(p, Goal::HalfWidth(half_width))
    }

    /// The quantile of a probability p as well as it can be had at this cost, pilot included, in the unit of the
    /// models' costs: see [`quantile_to_half_width`](Self::quantile_to_half_width).
    ///
    /// # Errors
    /// Those of [`quantile_to_half_width`](Self::quantile_to_half_width); and if the budget does not suffice for more
    /// than the pilot.
    pub fn quantile_within_budget(&self, p: f64, cost: f64) -> Result<QuantileEstimate, EnsembleError> {
        HalfWidth::of(1.0).confidence(self.confidence).check()?;
        self.quantile(p, Goal::Budget(cost))
    }

    fn quantile(&self, p: f64, goal: Goal) -> Result<QuantileEstimate, EnsembleError> {
        let Multifidelity { source, samples, full, cheap, confidence, settings, .. } = self;
        let tail = p.min(1.0 - p);
        if tail <= 0.0 || tail.is_nan() {
            return Err(EnsembleError::Refused(format!(
                "a quantile is of a probability between 0 and 1, not {p:?}"
            )));
        }
        let usual = (8.0 * FEWEST_BEYOND / tail).ceil() as u64;
        let [leaves, pilot] = self.checked(goal, usual.clamp(1024, (samples / 4).max(1024)))?;
        if ((pilot * super::LEAF) as f64) * tail < FEWEST_BEYOND {
            let wanted = (FEWEST_BEYOND / tail).ceil();
            let help = match wanted < *samples as f64 {
                true => format!("give it more, as `.pilot_samples({wanted})`"),
                false => format!("a study of {samples} samples does not tell such a quantile"),
            };
            let pilot = pilot * super::LEAF;
            let what =
                format!("a pilot of {pilot} samples has too few beyond the quantile of {p:?}; help: {help}");
            return Err(EnsembleError::Refused(what));
        }
        let (plan, threshold) = (OnceLock::new(), OnceLock::new());
        let how = ByModels { source, samples: *samples, full, cheap, pilot, plan: &plan };
        let unit_cost = [full.unit_cost(), cheap.unit_cost()];
        let rest = leaves - pilot;
        let mean = ToGoal {
            goal,
            confidence: *confidence,
            pilot,
            leaves: rest,
            looks_early: true,
            unit_cost,
            plan: &plan,
        };
        let half_width = if let Goal::HalfWidth(half_width) = goal { Some(half_width) } else { None };
        let mut course = ToQuantile { p, half_width, mean, threshold: &threshold };
        let description = self.description(
            pilot,
            format!("multifidelity: quantile of {p:?}, {goal:?}, confidence {confidence:?}"),
        );
        let statistic = Stratified { threshold: &threshold };
        let (reached, failures) =
            settings.driver(*samples).drive(&how, &statistic, &description, 0..leaves, &mut course)?;
        let state = merged(&statistic, reached.tree);
        let found = course.planned(&state)?;
        let pilot = plan.get().copied().unwrap_or(found);
        let weighed = Weighed::new(&state, &pilot);
        let own = weighed.strata.iter().map(|outputs| outputs.len() as u64).sum();
        let all = if pilot.gain.is_some() { own + state.cheap[0] + state.cheap[1] } else { 0 };
        let cost = |work: [u64; 2]| work[0] as f64 * unit_cost[0] + work[1] as f64 * unit_cost[1];
        let (look, _) = course.mean.first_look(&pilot)?;
        Ok(QuantileEstimate {
            samples: [own, all],
            cost: cost(state.pilot_work) + cost(state.work),
            reached: match half_width {
                Some(_) => course.is_met(&state, &pilot),
                None => reached.next < leaves || leaves - course.mean.pilot >= look,
            },
            failed: reached.failed,
            not_finite: state.not_finite,
            failures,
            p,
            weighed,
            pilot,
        })
    }
}

/// Fewest samples of the pilot on either side of the quantile.
const FEWEST_BEYOND: f64 = 8.0;
