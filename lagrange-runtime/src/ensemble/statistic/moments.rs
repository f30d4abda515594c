//! Mean and variance.

use super::Statistic;
use crate::ensemble::record::record_fields;

/// Number, mean and variance of a real output, the mean in the unit of the output.
///
/// Fed by Welford's recurrence and merged by the formula of Chan, Golub and LeVeque (1983), which do not cancel: the
/// mean and the standard deviation are off by some rounding errors of the largest deviation, growing with the
/// logarithm of the number of samples. Outputs that are infinite or not numbers are counted and left out.
///
/// ```
/// use lagrange_runtime::ensemble::{Moments, Statistic};
/// let mut state = Moments.empty();
/// for (index, x) in [2.0, 4.0, 9.0].iter().enumerate() {
///     Moments.add(&mut state, index as u64, x);
/// }
/// assert_eq!((state.mean(), state.variance()), (5.0, 13.0));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Moments;

/// Result of [`Moments`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moment {
    count: u64,
    mean: f64,
    squares: f64,
    not_finite: u64,
}

record_fields!(Moment { count, mean, squares, not_finite });

impl Moment {
    /// The moments of these numbers.
    pub(crate) fn of(numbers: impl Iterator<Item = f64>) -> Self {
        numbers.fold(Moment::default(), |mut moments, number| {
            Moments.add(&mut moments, 0, &number);
            moments
        })
    }

    /// The number of finite outputs.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// The number of outputs that were left out since they are infinite or not numbers.
    pub fn not_finite(&self) -> u64 {
        self.not_finite
    }

    /// The mean; NaN without outputs.
    pub fn mean(&self) -> f64 {
        if self.count == 0 { f64::NAN } else { self.mean }
    }

    /// The unbiased variance, in the square of the output's unit, with the divisor n − 1; NaN for fewer than two
    /// outputs.
    pub fn variance(&self) -> f64 {
        if self.count < 2 { f64::NAN } else { self.squares / (self.count - 1) as f64 }
    }

    /// The standard deviation: the root of the variance.
    pub fn standard_deviation(&self) -> f64 {
        self.variance().sqrt()
    }

    /// The standard error of the mean of independent samples. It does not hold for Sobol points, whose mean is better.
    pub fn standard_error(&self) -> f64 {
        (self.variance() / self.count as f64).sqrt()
    }
}

impl Statistic<f64> for Moments {
    type State = Moment;

    fn empty(&self) -> Moment {
        Moment::default()
    }

    #[inline]
    fn add(&self, state: &mut Moment, _index: u64, output: &f64) {
        if !output.is_finite() {
            state.not_finite += 1;
            return;
        }
        state.count += 1;
        let before = output - state.mean;
        state.mean += before / state.count as f64;
        state.squares += before * (output - state.mean);
    }

    fn merge(&self, state: &mut Moment, later: Moment) {
        state.not_finite += later.not_finite;
        let count = state.count + later.count;
        if later.count > 0 {
            let apart = later.mean - state.mean;
            let share = later.count as f64 / count as f64;
            state.squares += later.squares + apart * apart * (state.count as f64 * share);
            state.mean += apart * share;
            state.count = count;
        }
    }

    fn describe(&self) -> String {
        "mean and variance".into()
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::{merged, normal};
    use super::*;

    /// Against sums in two passes, of numbers whose mean is a million times their spread.
    #[test]
    fn two_passes_give_the_same() {
        let outputs: Vec<f64> = normal(10_000).iter().map(|x| 1e6 + x).collect();
        let found = merged(&Moments, &outputs);
        let n = outputs.len() as f64;
        let shifted: Vec<f64> = outputs.iter().map(|x| x - 1e6).collect();
        let mean = shifted.iter().sum::<f64>() / n;
        let variance = shifted.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1.0);
        assert!((found.mean() - 1e6 - mean).abs() < 1e-9);
        assert!((found.variance() / variance - 1.0).abs() < 1e-9);
        assert!((found.standard_error() - (variance / n).sqrt()).abs() < 1e-9);
        assert_eq!(found.count(), 10_000);
    }

    #[test]
    fn what_is_not_finite_is_counted_and_left_out() {
        let found = merged(&Moments, &[1.0, f64::NAN, 3.0, f64::INFINITY]);
        assert_eq!((found.count(), found.not_finite(), found.mean()), (2, 2, 2.0));
        let none = merged(&Moments, &[f64::NAN]);
        assert!(none.mean().is_nan() && none.variance().is_nan());
    }
}
