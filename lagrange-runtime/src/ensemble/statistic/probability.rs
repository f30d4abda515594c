//! The probability of an event.

use super::Statistic;
use super::interval::{ConfidenceInterval, two_sided};
use crate::ensemble::normal_quantile;
use crate::ensemble::record::record_fields;

/// Relative frequency of outputs that are true: the estimate of a probability.
///
/// ```
/// use lagrange_runtime::ensemble::{ConfidenceInterval, Probability, Statistic};
/// let mut state = Probability.empty();
/// for index in 0..100 {
///     Probability.add(&mut state, index, &(index % 10 == 0));
/// }
/// assert_eq!((state.count(), state.probability()), (100, 0.1));
/// let [low, high] = state.confidence_interval(0.95);
/// assert!((low - 0.0552).abs() < 1e-4 && (high - 0.1744).abs() < 1e-4);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Probability;

/// Result of [`Probability`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Frequency {
    count: u64,
    happened: u64,
}

record_fields!(Frequency { count, happened });

impl Frequency {
    /// The number of outputs.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// The number of outputs that are true.
    pub fn happened(&self) -> u64 {
        self.happened
    }

    /// The relative frequency; NaN without outputs.
    pub fn probability(&self) -> f64 {
        self.happened as f64 / self.count as f64
    }
}

/// The score interval of Wilson (*J. Amer. Statist. Assoc.* 22, 1927), which holds for few events too: with none of n
/// it is not empty.
impl ConfidenceInterval for Frequency {
    fn confidence_interval(&self, confidence: f64) -> [f64; 2] {
        let (n, p) = (self.count as f64, self.probability());
        let z = normal_quantile(two_sided(confidence));
        let z2 = z * z / n;
        let middle = (p + 0.5 * z2) / (1.0 + z2);
        let half = z / (1.0 + z2) * ((p * (1.0 - p) + 0.25 * z2) / n).sqrt();
        [(middle - half).max(0.0), (middle + half).min(1.0)]
    }
}

impl Statistic<bool> for Probability {
    type State = Frequency;

    fn empty(&self) -> Frequency {
        Frequency::default()
    }

    fn add(&self, state: &mut Frequency, _index: u64, output: &bool) {
        state.count += 1;
        state.happened += u64::from(*output);
    }

    fn merge(&self, state: &mut Frequency, later: Frequency) {
        state.count += later.count;
        state.happened += later.happened;
    }

    fn describe(&self) -> String {
        "probability".into()
    }
}
