//! Quantiles with a stated relative error.

use super::Statistic;
use crate::ensemble::record::{Record, record_fields};
use std::collections::BTreeMap;

/// Quantiles of a real output to a relative error: a sketch with logarithmic bins (DDSketch: Masson, Rim and
/// Lee, *PVLDB* 12, 2019), of either sign and of zero.
///
/// Counts are integers and no bin is ever given up, so merging is exact, and the error is that of one bin, however
/// many samples there are. Memory follows the range of the outputs, not their number: one bin for each factor (1 +
/// e)/(1 − e), where e is the error, which is 115 bins a decade at 1 %. Sizes below 1e-300 count as 0; outputs that
/// are not finite are counted and left out.
///
/// ```
/// use lagrange_runtime::ensemble::{Quantiles, Statistic};
/// let quantiles = Quantiles::to(0.01);
/// let mut state = quantiles.empty();
/// for index in 0..=1000 {
///     quantiles.add(&mut state, index, &(index as f64));
/// }
/// let median = state.quantile(0.5).unwrap();
/// assert!((median - 500.0).abs() <= 0.01 * 500.0);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quantiles {
    error: f64,
}

/// Sizes that are told from 0.
const SMALLEST: f64 = 1e-300;

/// Result of [`Quantiles`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sketch {
    error: f64,
    /// Counts by the number of the bin, of sizes.
    negative: Bins,
    zero: u64,
    positive: Bins,
    not_finite: u64,
}

record_fields!(Sketch { error, negative, zero, positive, not_finite });

type Bins = BTreeMap<i32, u64>;

impl Record for Bins {
    fn write(&self, bytes: &mut Vec<u8>) {
        self.iter().map(|(&bin, &count)| (bin, count)).collect::<Vec<_>>().write(bytes);
    }

    fn read(bytes: &mut &[u8]) -> Option<Self> {
        Some(Vec::<(i32, u64)>::read(bytes)?.into_iter().collect())
    }
}

impl Quantiles {
    /// Quantiles to this relative error, such as 0.01: each is within that part of an output which has that rank.
    pub const fn to(error: f64) -> Self {
        Quantiles { error }
    }
}

/// The logarithm of the ratio of the ends of a bin.
fn log_ratio(error: f64) -> f64 {
    2.0 * error.atanh()
}

impl Sketch {
    /// The number of finite outputs.
    pub fn count(&self) -> u64 {
        self.negative.values().sum::<u64>() + self.zero + self.positive.values().sum::<u64>()
    }

    /// The number of outputs that are infinite or not numbers.
    pub fn not_finite(&self) -> u64 {
        self.not_finite
    }

    /// The output of rank `p (n − 1)`, rounded down, to the relative error; `None` without outputs, or if `p` is not
    /// between 0 and 1.
    pub fn quantile(&self, p: f64) -> Option<f64> {
        let count = self.count();
        if count == 0 || !(0.0..=1.0).contains(&p) {
            return None;
        }
        let rank = (p * (count - 1) as f64) as u64;
        let log_ratio = log_ratio(self.error);
        // The number from which both ends of its bin, up to γᵏ, are equally far in proportion: 2γᵏ/(γ + 1).
        let size = |bin: i32| (f64::from(bin) * log_ratio).exp() * (1.0 - self.error);
        let negative = self.negative.iter().rev().map(|(&bin, &count)| (-size(bin), count));
        let positive = self.positive.iter().map(|(&bin, &count)| (size(bin), count));
        let mut passed = 0;
        negative.chain([(0.0, self.zero)]).chain(positive).find_map(|(value, count)| {
            passed += count;
            (passed > rank).then_some(value)
        })
    }
}

impl Statistic<f64> for Quantiles {
    type State = Sketch;

    fn empty(&self) -> Sketch {
        Sketch { error: self.error, ..Sketch::default() }
    }

    fn add(&self, state: &mut Sketch, _index: u64, &output: &f64) {
        let bin = || (output.abs().ln() / log_ratio(self.error)).ceil() as i32;
        if !output.is_finite() {
            state.not_finite += 1;
        } else if output.abs() < SMALLEST {
            state.zero += 1;
        } else if output > 0.0 {
            *state.positive.entry(bin()).or_default() += 1;
        } else {
            *state.negative.entry(bin()).or_default() += 1;
        }
    }

    fn merge(&self, state: &mut Sketch, later: Sketch) {
        for (bin, count) in later.negative {
            *state.negative.entry(bin).or_default() += count;
        }
        for (bin, count) in later.positive {
            *state.positive.entry(bin).or_default() += count;
        }
        state.zero += later.zero;
        state.not_finite += later.not_finite;
    }

    fn describe(&self) -> String {
        format!("quantiles to {:?}", self.error)
    }

    fn check(&self) -> Result<(), String> {
        // Below that bins would not fit their numbers, and memory would follow the number of samples.
        if (1e-6..1.0).contains(&self.error) {
            Ok(())
        } else {
            Err(format!("the relative error of quantiles lies between 1e-6 and 1, but is {:?}", self.error))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::{merged, normal};
    use super::*;

    #[test]
    fn quantiles_are_within_their_error_of_the_sorted_outputs() {
        for error in [0.05, 0.01, 1e-3, 1e-6] {
            let mut outputs: Vec<f64> = normal(5000).iter().map(|x| x.powi(3) * 1e3).collect();
            outputs.extend([0.0, -0.0, 1e-310, 1e300, -1e300, 1e-300]);
            let found = merged(&Quantiles::to(error), &outputs);
            outputs.sort_by(f64::total_cmp);
            for k in 0..=1000 {
                let p = f64::from(k) / 1000.0;
                let exact = outputs[(p * (outputs.len() - 1) as f64) as usize];
                let quantile = found.quantile(p).expect("there are outputs");
                // Rounding of the logarithm counts too, where the bin is as narrow as 1e-6.
                let allowed = error * exact.abs() * (1.0 + 1e-6) + SMALLEST;
                assert!((quantile - exact).abs() <= allowed, "{p}: {quantile}, {exact}");
            }
        }
    }

    #[test]
    fn merging_is_exact() {
        let outputs = normal(3000);
        let quantiles = Quantiles::to(0.01);
        let mut whole = quantiles.empty();
        outputs.iter().for_each(|x| quantiles.add(&mut whole, 0, x));
        assert_eq!(merged(&quantiles, &outputs), whole);
    }

    #[test]
    fn what_cannot_be_is_refused_or_none() {
        for bad in [0.0, 1.0, -0.1, f64::NAN, 1e-9] {
            assert!(Quantiles::to(bad).check().is_err());
        }
        let found = merged(&Quantiles::to(0.1), &[f64::NAN, f64::INFINITY]);
        assert_eq!((found.quantile(0.5), found.not_finite()), (None, 2));
        assert_eq!(merged(&Quantiles::to(0.1), &[1.0]).quantile(f64::NAN), None);
    }
}
