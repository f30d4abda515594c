//! Confidence intervals of what statistics estimate.

use super::moments::Moment;
use crate::ensemble::distribution::student_quantile;

/// Confidence interval of what a statistic of independent samples estimates. Of a tuple it is that of the first
/// statistic.
pub trait ConfidenceInterval {
    /// Ends of the interval that covers the true value with this probability, such as 0.95. They are not finite if
    /// there are too few samples for an interval.
    fn confidence_interval(&self, confidence: f64) -> [f64; 2];

    /// Half the length of the interval.
    fn half_width(&self, confidence: f64) -> f64 {
        let [low, high] = self.confidence_interval(confidence);
        0.5 * (high - low)
    }
}

/// The probability below the upper end of a two-sided interval.
pub(in crate::ensemble) fn two_sided(confidence: f64) -> f64 {
    0.5 + 0.5 * confidence
}

/// The interval of the mean by Student's t (1908). It does not hold for Sobol points, whose mean is better.
impl ConfidenceInterval for Moment {
    fn confidence_interval(&self, confidence: f64) -> [f64; 2] {
        let half = student_quantile(two_sided(confidence), self.count() as f64 - 1.0) * self.standard_error();
        [self.mean() - half, self.mean() + half]
    }
}

macro_rules! tuples {
    ($(($($name:ident),*))*) => {$(
        impl<First: ConfidenceInterval, $($name),*> ConfidenceInterval for (First, $($name),*) {
            fn confidence_interval(&self, confidence: f64) -> [f64; 2] {
                self.0.confidence_interval(confidence)
            }
        }
    )*};
}

tuples! { (B) (B, C) (B, C, D) (B, C, D, E) (B, C, D, E, F) }
