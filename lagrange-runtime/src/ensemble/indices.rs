//! Sobol' indices: which input decides.

use super::distribution::student_quantile;
use super::drive::{Compute, Part, Through, parts, samples};
use super::model::{Model, evaluated};
use super::multifidelity::FailedEvaluation;
use super::precision::merged;
use super::record::record_fields;
use super::settings::{Settings, set_settings};
use super::sobol::Points;
use super::statistic::interval::two_sided;
use super::statistic::{ConfidenceInterval, Covariance, Covariances, Moment, Moments};
use super::{EnsembleError, LEAF, Statistic};
use core::fmt;
use core::ops::Range;

/// Sobol' indices of an output: the parts of its variance that its inputs answer for, each by itself and together
/// with others.
///
/// The inputs are `D` independent numbers u, uniform in (0, 1), from which the model makes what it wants:
/// `a + (b − a) u`, or [`normal_quantile(u)`](super::normal_quantile). Of input i there are
///
/// - the first-order index Sᵢ = Var(E[Y | uᵢ]) / Var(Y), by how much the variance would fall if uᵢ were known. All
///   together they are 1 at most;
/// - the total-effect index Tᵢ = E[Var(Y | all but uᵢ)] / Var(Y), the part of the variance that would remain if all
///   others were known (Homma and Saltelli 1996). It is no less than Sᵢ, and 0 if the input does nothing.
///
/// A Sobol sequence in 2 D dimensions gives the points A and B; with their D mixtures, in which input i of A is
/// replaced by input i of B, these are (D + 2) evaluations per point. Sᵢ is estimated by B · (ABᵢ − A) (Saltelli et
/// al., *Comput. Phys. Commun.* 181, 2010, table 2 (b)), as a covariance, and Tᵢ by ½ (A − ABᵢ)² (Jansen, *Comput.
/// Phys. Commun.* 117, 1999). Replicates, each with a scrambling of its own, are independent of each other: the scatter
/// of the estimates among them is their error, by Student's t. An index near 0 may come out negative, by its error.
///
/// ```
/// use lagrange_runtime::ensemble::{ClosedForm, ConfidenceInterval, SobolIndices};
/// // The range of a shot, v² sin(2 a)/g, with 1 % of v and 2 % of the angle: which tolerance decides?
/// let range = ClosedForm::new(|[v, a]: [f64; 2]| {
///     let (v, a) = (50.0 * (1.0 + 0.02 * (v - 0.5)), 0.6 * (1.0 + 0.04 * (a - 0.5)));
///     v * v * (2.0 * a).sin() / 9.81
/// });
/// let indices = SobolIndices::new(7, range).run()?;
/// let [speed, angle] = indices.total;
/// assert!(speed.value() > 0.8 && angle.value() < 0.2 && speed.half_width(0.95) < 0.02);
/// # Ok::<(), lagrange_runtime::ensemble::EnsembleError>(())
/// ```
///
/// # Hypotheses
/// - The inputs are independent of each other.
/// - There are 1 to 32 of them. The compiler rejects others.
pub struct SobolIndices<'p, F, const D: usize> {
    model: F,
    seed: u64,
    rows: u64,
    replicates: u64,
    settings: Settings<'p>,
}

impl<F: fmt::Debug, const D: usize> fmt::Debug for SobolIndices<'_, F, D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let SobolIndices { model, seed, rows, replicates, .. } = self;
        f.debug_struct("SobolIndices")
            .field("model", model)
            .field("seed", seed)
            .field("rows", rows)
            .field("replicates", replicates)
            .finish_non_exhaustive()
    }
}

/// An index, with the error of its estimate; [`ConfidenceInterval`] gives its interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Index {
    value: f64,
    error: f64,
    freedom: f64,
}

impl Index {
    /// The estimate.
    pub fn value(&self) -> f64 {
        self.value
    }

    /// Its standard error.
    pub fn standard_error(&self) -> f64 {
        self.error
    }
}

impl ConfidenceInterval for Index {
    fn confidence_interval(&self, confidence: f64) -> [f64; 2] {
        let half = student_quantile(two_sided(confidence), self.freedom) * self.error;
        [self.value - half, self.value + half]
    }
}

/// Result of [`SobolIndices`].
#[derive(Clone, Debug, PartialEq)]
pub struct Indices<const D: usize> {
    /// First-order indices, of each input by itself.
    pub first: [Index; D],
    /// Total-effect indices, of each input with all others.
    pub total: [Index; D],
    /// Mean of the output.
    pub mean: f64,
    /// Variance of the output, in the square of its unit.
    pub variance: f64,
    /// The number of evaluations.
    pub evaluations: u64,
    /// The cost of all evaluations: work times that of a unit of work, see [`Model`](super::Model).
    pub cost: f64,
    /// The number of rows that are left out, since an evaluation failed or its output is infinite or not a number.
    pub lost: u64,
    /// The first failures.
    pub failures: Vec<FailedEvaluation>,
}

impl<const D: usize> Indices<D> {
    /// The inputs in the order of their total-effect indices, the one that decides first.
    pub fn ranked(&self) -> [usize; D] {
        let mut order = core::array::from_fn(|input| input);
        order.sort_by(|&i: &usize, &j| self.total[j].value.total_cmp(&self.total[i].value));
        order
    }
}

/// The outputs of a row: at A, B, and the mixtures. None of a row that failed.
struct Row<const D: usize> {
    replicate: u64,
    outputs: Option<(f64, f64, [f64; D])>,
    work: u64,
}

/// Sums of a replicate.
#[derive(Clone, Copy, Debug)]
struct Sums<const D: usize> {
    /// Outputs at A and B.
    outputs: Moment,
    /// Co-moments of B and ABᵢ − A.
    first: [Covariances<2>; D],
    /// Moments of ½ (A − ABᵢ)².
    total: [Moment; D],
}

record_fields!(Sums<; D> { outputs, first, total });

/// Sums of all replicates, by their numbers.
#[derive(Clone, Debug, Default)]
struct Replicates<const D: usize> {
    sums: Vec<(u64, Sums<D>)>,
    lost: u64,
    work: u64,
}

record_fields!(Replicates<; D> { sums, lost, work });

struct ByReplicate;

const PAIRS: Covariance<2> = Covariance;

impl<const D: usize> Statistic<Row<D>> for ByReplicate {
    type State = Replicates<D>;

    fn empty(&self) -> Replicates<D> {
        Replicates::default()
    }

    fn add(&self, state: &mut Replicates<D>, index: u64, row: &Row<D>) {
        state.work += row.work;
        let Some((a, b, mixed)) = &row.outputs else {
            state.lost += 1;
            return;
        };
        if state.sums.last().is_none_or(|(replicate, _)| *replicate != row.replicate) {
            let (outputs, pairs) = (Moments.empty(), PAIRS.empty());
            state.sums.push((row.replicate, Sums { outputs, first: [pairs; D], total: [outputs; D] }));
        }
        let Some((_, sums)) = state.sums.last_mut() else { return };
        Moments.add(&mut sums.outputs, index, a);
        Moments.add(&mut sums.outputs, index, b);
        for (i, mixed) in mixed.iter().enumerate() {
            PAIRS.add(&mut sums.first[i], index, &[*b, mixed - a]);
            Moments.add(&mut sums.total[i], index, &(0.5 * (a - mixed).powi(2)));
        }
    }

    fn merge(&self, state: &mut Replicates<D>, later: Replicates<D>) {
        state.work += later.work;
        state.lost += later.lost;
        for (replicate, later) in later.sums {
            match state.sums.last_mut().filter(|(last, _)| *last == replicate) {
                Some((_, sums)) => {
                    Moments.merge(&mut sums.outputs, later.outputs);
                    for i in 0..D {
                        PAIRS.merge(&mut sums.first[i], later.first[i]);
                        Moments.merge(&mut sums.total[i], later.total[i]);
                    }
                }
                None => state.sums.push((replicate, later)),
            }
        }
    }

    fn describe(&self) -> String {
        format!("Sobol' indices of {D} inputs")
    }
}

/// The way rows are computed.
struct Rows<'a, F, const D: usize> {
    model: &'a F,
    /// The halves of the points of each replicate.
    points: Vec<[Points<D>; 2]>,
    rows: u64,
    samples: u64,
}

impl<F: Model<[f64; D], Output = f64>, const D: usize> Rows<'_, F, D> {
    fn outputs(&self, range: Range<u64>) -> Vec<(u64, Row<D>, Option<FailedEvaluation>)> {
        let mut draws = vec![];
        for index in range.clone() {
            let (replicate, row) = (index / self.rows, index % self.rows);
            let Some(halves) = self.points.get(replicate as usize) else { continue };
            let [a, b] = [halves[0].point(row), halves[1].point(row)];
            draws.extend([a, b]);
            draws.extend((0..D).map(|i| core::array::from_fn(|j| if j == i { b[j] } else { a[j] })));
        }
        let mut evaluated = evaluated(self.model, draws).into_iter();
        let row = |index: u64| {
            let row: Vec<_> = evaluated.by_ref().take(D + 2).collect();
            let work = row.iter().map(|evaluated| evaluated.work).sum();
            let failed = row.iter().find_map(|evaluated| {
                let failure = evaluated.output.err()?;
                Some(FailedEvaluation { index, model: 0, failure })
            });
            let output =
                |k: usize| row.get(k).and_then(|evaluated| evaluated.output.ok()).unwrap_or(f64::NAN);
            let outputs = (output(0), output(1), core::array::from_fn(|i| output(i + 2)));
            let is_finite = (0..D + 2).all(|k| output(k).is_finite());
            let row = Row { replicate: index / self.rows, outputs: is_finite.then_some(outputs), work };
            (index, row, failed)
        };
        range.map(row).collect()
    }
}

impl<F: Model<[f64; D], Output = f64>, const D: usize> Compute<Row<D>> for Rows<'_, F, D> {
    /// A leaf has 32 (D + 2) evaluations, enough for lanes to be full.
    const GROUP: u64 = 1;

    type Failed = FailedEvaluation;

    fn leaves<T: Statistic<Row<D>>>(
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

impl<'p, F: Model<[f64; D], Output = f64>, const D: usize> SobolIndices<'p, F, D> {
    /// The indices of a model's output, by points that are scrambled by this seed: 16 replicates of 256 rows each.
    pub fn new(seed: u64, model: F) -> Self {
        SobolIndices { model, seed, rows: 256, replicates: 16, settings: Settings::default() }
    }

    /// Sets the number of rows of each replicate, rounded up to a power of two and to 32 at least. A row has D + 2
    /// evaluations.
    #[must_use]
    pub fn rows(self, rows: u64) -> Self {
        SobolIndices { rows, ..self }
    }

    /// Sets the number of replicates, whose scatter is the error of the indices: from 2 on, and better from 8 on.
    #[must_use]
    pub fn replicates(self, replicates: u64) -> Self {
        SobolIndices { replicates, ..self }
    }

    set_settings!();

    /// Evaluates the model and estimates the indices.
    ///
    /// # Errors
    /// If the output is constant, or finite at too few points; if there are not 2 to 1024 replicates; those of
    /// checkpoints.
    pub fn run(&self) -> Result<Indices<D>, EnsembleError> {
        let SobolIndices { model, seed, rows, replicates, settings } = self;
        model.check().map_err(EnsembleError::Refused)?;
        let refused = |what: String| Err(EnsembleError::Refused(what));
        if !(2..=1024).contains(replicates) {
            return refused(format!(
                "the error of Sobol' indices is the scatter among replicates, 2 to 1024 of them, but there are {replicates}; help: \
                 `.replicates(16)`, and more `.rows(…)` for a smaller error"
            ));
        }
        let rows = rows.max(&LEAF).checked_next_power_of_two().unwrap_or(1 << 52);
        let Some(samples) = rows.checked_mul(*replicates).filter(|samples| *samples <= 1 << 52) else {
            return refused(format!(
                "{replicates} replicates of {rows} rows are more points than a Sobol sequence has"
            ));
        };
        let points: Vec<[Points<D>; 2]> = (0..*replicates)
            .map(|replicate| Points::halves(seed.wrapping_mul(*replicates).wrapping_add(replicate)))
            .collect();
        let description = [
            format!("name: {}", settings.name),
            format!("source: Sobol in 2 × {D} dimensions, Owen scrambling, seed {seed}"),
            format!("samples: {replicates} replicates of {rows} rows, in leaves of {LEAF}"),
            format!(
                "model: {}",
                model.describe(points.first().map_or([0.5; D], |halves| halves[0].point(0)))
            ),
            Statistic::<Row<D>>::describe(&ByReplicate),
        ];
        let how = Rows { model, points, rows, samples };
        let leaves = 0..samples.div_ceil(LEAF);
        let (reached, failures) =
            settings.driver(samples).drive(&how, &ByReplicate, &description, leaves, &mut Through)?;
        let Replicates { sums, lost, work } = merged(&ByReplicate, reached.tree);
        let sums: Vec<Sums<D>> =
            sums.into_iter().map(|(_, sums)| sums).filter(|sums| sums.outputs.count() >= 4).collect();
        if sums.len() < 2 {
            let first =
                failures.first().map_or(String::new(), |failed| format!(", as by this failure: {failed}"));
            return refused(format!(
                "{lost} of {samples} rows have an output that is infinite or not a number{first}"
            ));
        }
        let all = sums.iter().fold(Moments.empty(), |mut all, sums| {
            Moments.merge(&mut all, sums.outputs);
            all
        });
        if !all.variance().is_finite() {
            return refused(format!(
                "the squares of the outputs, whose mean is {:?}, are beyond the largest number; help: give the output in larger units",
                all.mean()
            ));
        }
        if all.variance() == 0.0 {
            return refused(format!(
                "the output is {:?} at all {} points: no input decides; help: look whether the model uses its inputs, and whether its range is wide enough (squares of what is below 1e-154 are 0: give it in smaller units)",
                all.mean(),
                all.count()
            ));
        }
        // With the divisor n everywhere: points of a Sobol sequence have no freedom to lose, and n − 1 here and 2n − 1
        // there would be an error of 1/2n that all replicates have, and their scatter does not show.
        let part = |count: u64| 1.0 - 1.0 / count as f64;
        let variance = |sums: &Sums<D>| part(sums.outputs.count()) * sums.outputs.variance();
        Ok(Indices {
            first: core::array::from_fn(|i| {
                let covariance =
                    |sums: &Sums<D>| part(sums.first[i].count()) * sums.first[i].covariance()[0][1];
                ratio(&sums, &covariance, &variance)
            }),
            total: core::array::from_fn(|i| ratio(&sums, &|sums| sums.total[i].mean(), &variance)),
            mean: all.mean(),
            variance: all.variance(),
            evaluations: (samples - lost) * (D as u64 + 2),
            cost: work as f64 * model.unit_cost(),
            lost,
            failures,
        })
    }
}

/// A ratio of means over replicates, with its error to first order: that of the mean of the residuals.
fn ratio<const D: usize>(
    sums: &[Sums<D>],
    numerator: &dyn Fn(&Sums<D>) -> f64,
    denominator: &dyn Fn(&Sums<D>) -> f64,
) -> Index {
    let mean = |of: &dyn Fn(&Sums<D>) -> f64| sums.iter().map(of).sum::<f64>() / sums.len() as f64;
    let below = mean(denominator);
    let value = mean(numerator) / below;
    let residuals = Moment::of(sums.iter().map(|sums| (numerator(sums) - value * denominator(sums)) / below));
    Index { value, error: residuals.standard_error(), freedom: sums.len() as f64 - 1.0 }
}
