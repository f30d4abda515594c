//! Counts in equal bins.

use super::Statistic;
use crate::ensemble::record::record_fields;

/// Counts of a real output in equal bins from `low` to `high`, and of what lies below, above, or is not a number.
/// Exact, in whatever order samples come.
///
/// ```
/// use lagrange_runtime::ensemble::{Histogram, Statistic};
/// let histogram = Histogram::new(0.0, 1.0, 4);
/// let mut state = histogram.empty();
/// for (index, x) in [0.1, 0.2, 0.6, 1.0].iter().enumerate() {
///     histogram.add(&mut state, index as u64, x);
/// }
/// assert_eq!((state.bins, state.above), (vec![2, 0, 1, 0], 1));
/// assert_eq!(histogram.middle(2), 0.625);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Histogram {
    low: f64,
    high: f64,
    bins: u32,
}

/// Result of a [`Histogram`].
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Outputs in each bin; the lower end belongs to it, the upper end does not.
    pub bins: Vec<u64>,
    /// Outputs below the first bin.
    pub below: u64,
    /// Outputs at or above the end of the last bin.
    pub above: u64,
    /// Outputs that are not numbers.
    pub not_a_number: u64,
}

record_fields!(Counts { bins, below, above, not_a_number });

impl Histogram {
    /// `bins` bins of equal width from `low` to `high`, in the unit of the output.
    pub const fn new(low: f64, high: f64, bins: u32) -> Self {
        Histogram { low, high, bins }
    }

    /// The width of a bin.
    pub fn width(&self) -> f64 {
        (self.high - self.low) / f64::from(self.bins)
    }

    /// The middle of bin `k`.
    pub fn middle(&self, k: u32) -> f64 {
        self.low + (f64::from(k) + 0.5) * self.width()
    }
}

impl Statistic<f64> for Histogram {
    type State = Counts;

    fn empty(&self) -> Counts {
        Counts { bins: vec![0; self.bins as usize], ..Counts::default() }
    }

    #[inline]
    fn add(&self, state: &mut Counts, _index: u64, &output: &f64) {
        if output.is_nan() {
            state.not_a_number += 1;
        } else if output < self.low {
            state.below += 1;
        } else if output >= self.high {
            state.above += 1;
        } else {
            // Rounding may lead from just below the upper end to the bin after the last one.
            let place = (output - self.low) / (self.high - self.low) * f64::from(self.bins);
            let last = state.bins.len().saturating_sub(1);
            if let Some(count) = state.bins.get_mut((place as usize).min(last)) {
                *count += 1;
            }
        }
    }

    fn merge(&self, state: &mut Counts, later: Counts) {
        for (count, more) in state.bins.iter_mut().zip(later.bins) {
            *count += more;
        }
        state.below += later.below;
        state.above += later.above;
        state.not_a_number += later.not_a_number;
    }

    fn describe(&self) -> String {
        format!("histogram of {} bins from {:?} to {:?}", self.bins, self.low, self.high)
    }

    fn check(&self) -> Result<(), String> {
        let Histogram { low, high, bins } = self;
        let width = high - low;
        if !(width > 0.0 && width.is_finite()) {
            return Err(format!(
                "a histogram needs finite ends, the lower one first, not {low:?} and {high:?}"
            ));
        }
        if *bins == 0 { Err("a histogram needs a bin".into()) } else { Ok(()) }
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::{merged, normal};
    use super::*;

    #[test]
    fn counts_are_those_of_comparisons() {
        let histogram = Histogram::new(-2.0, 2.0, 16);
        let mut outputs = normal(5000);
        outputs.extend([-2.0, 2.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY]);
        let found = merged(&histogram, &outputs);
        let within = |a: f64, b: f64| outputs.iter().filter(|&&x| a <= x && x < b).count() as u64;
        for (k, &count) in found.bins.iter().enumerate() {
            // The ends of these bins are exact in binary.
            let low = -2.0 + 0.25 * k as f64;
            assert_eq!(count, within(low, low + 0.25));
        }
        assert_eq!(found.below, within(f64::NEG_INFINITY, -2.0));
        assert_eq!(found.above, within(2.0, f64::INFINITY) + 1);
        assert_eq!(found.not_a_number, 1);
    }

    #[test]
    fn the_number_below_the_upper_end_is_in_the_last_bin() {
        let histogram = Histogram::new(0.0, 0.3, 3);
        let found = merged(&histogram, &[0.3f64.next_down(), 0.0]);
        assert_eq!(found.bins, [1, 0, 1]);
    }

    #[test]
    fn histograms_without_bins_or_width_are_refused() {
        for bad in [
            Histogram::new(f64::NAN, 1.0, 4),
            Histogram::new(1.0, 1.0, 4),
            Histogram::new(0.0, f64::INFINITY, 4),
            Histogram::new(0.0, 1.0, 0),
        ] {
            assert!(bad.check().is_err());
        }
    }
}
