//! Means and covariances of several outputs.

use super::Statistic;
use crate::ensemble::record::record_fields;

/// Means and covariance matrix of `D` real outputs, `[f64; D]`.
///
/// As [`Moments`](super::Moments), for pairs: co-moments are fed and merged by formulas that do not cancel. A sample
/// with an output that is infinite or not a number is counted and left out.
///
/// ```
/// use lagrange_runtime::ensemble::{Covariance, Statistic};
/// let mut state = Covariance::<2>.empty();
/// for (index, x) in [[0.0, 1.0], [1.0, 3.0], [2.0, 5.0]].iter().enumerate() {
///     Covariance::<2>.add(&mut state, index as u64, x);
/// }
/// assert_eq!(state.mean(), [1.0, 3.0]);
/// assert!((state.covariance()[0][1] - 2.0).abs() < 1e-15);
/// assert!((state.correlation(0, 1) - 1.0).abs() < 1e-15);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Covariance<const D: usize>;

/// Result of [`Covariance`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Covariances<const D: usize> {
    count: u64,
    mean: [f64; D],
    products: [[f64; D]; D],
    not_finite: u64,
}

record_fields!(Covariances<; D> { count, mean, products, not_finite });

impl<const D: usize> Covariances<D> {
    /// The number of samples whose outputs are all finite.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// The number of samples that were left out.
    pub fn not_finite(&self) -> u64 {
        self.not_finite
    }

    /// The means; NaN without samples.
    pub fn mean(&self) -> [f64; D] {
        if self.count == 0 { [f64::NAN; D] } else { self.mean }
    }

    /// The unbiased covariance matrix, with the divisor n − 1; NaN for fewer than two samples.
    pub fn covariance(&self) -> [[f64; D]; D] {
        let divisor = if self.count < 2 { f64::NAN } else { (self.count - 1) as f64 };
        self.products.map(|row| row.map(|product| product / divisor))
    }

    /// The coefficient of correlation of the outputs `i` and `j`; NaN if there are no such outputs.
    pub fn correlation(&self, i: usize, j: usize) -> f64 {
        let product =
            |i: usize, j: usize| self.products.get(i).and_then(|row| row.get(j)).copied().unwrap_or(f64::NAN);
        product(i, j) / (product(i, i).sqrt() * product(j, j).sqrt())
    }
}

impl<const D: usize> Statistic<[f64; D]> for Covariance<D> {
    type State = Covariances<D>;

    fn empty(&self) -> Covariances<D> {
        Covariances { count: 0, mean: [0.0; D], products: [[0.0; D]; D], not_finite: 0 }
    }

    fn add(&self, state: &mut Covariances<D>, _index: u64, output: &[f64; D]) {
        if !output.iter().all(|x| x.is_finite()) {
            state.not_finite += 1;
            return;
        }
        state.count += 1;
        let n = state.count as f64;
        let before: [f64; D] = core::array::from_fn(|i| output[i] - state.mean[i]);
        for i in 0..D {
            state.mean[i] += before[i] / n;
        }
        // (x − old mean)(y − new mean) is (n − 1)/n of the product of the old deviations, the same for both orders.
        for i in 0..D {
            for j in 0..D {
                state.products[i][j] += before[i] * before[j] * ((n - 1.0) / n);
            }
        }
    }

    fn merge(&self, state: &mut Covariances<D>, later: Covariances<D>) {
        state.not_finite += later.not_finite;
        if later.count == 0 {
            return;
        }
        let count = state.count + later.count;
        let share = later.count as f64 / count as f64;
        let weight = state.count as f64 * share;
        let apart: [f64; D] = core::array::from_fn(|i| later.mean[i] - state.mean[i]);
        for i in 0..D {
            for j in 0..D {
                state.products[i][j] += later.products[i][j] + apart[i] * apart[j] * weight;
            }
            state.mean[i] += apart[i] * share;
        }
        state.count = count;
    }

    fn describe(&self) -> String {
        format!("covariance of {D}")
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::{merged, normal};
    use super::*;

    #[test]
    fn two_passes_give_the_same() {
        let drawn = normal(6000);
        let outputs: Vec<[f64; 2]> = drawn.chunks(2).map(|x| [x[0], 1e3 + 0.6 * x[0] + 0.8 * x[1]]).collect();
        let found = merged(&Covariance::<2>, &outputs);
        let n = outputs.len() as f64;
        let mean = [0, 1].map(|k| outputs.iter().map(|x| x[k]).sum::<f64>() / n);
        for i in 0..2 {
            assert!((found.mean()[i] - mean[i]).abs() < 1e-11 * 1e3);
            for j in 0..2 {
                let product = |x: &[f64; 2]| (x[i] - mean[i]) * (x[j] - mean[j]);
                let covariance = outputs.iter().map(product).sum::<f64>() / (n - 1.0);
                assert!((found.covariance()[i][j] - covariance).abs() < 1e-10);
            }
        }
        // Of 3000 pairs with correlation 0.6: four standard deviations, (1 − ρ²)/√n.
        assert!((found.correlation(0, 1) - 0.6).abs() < 4.0 * 0.64 / n.sqrt());
        assert!(found.correlation(0, 2).is_nan());
    }

    #[test]
    fn samples_with_a_bad_output_are_left_out() {
        let found = merged(&Covariance::<2>, &[[1.0, 2.0], [f64::NAN, 0.0], [3.0, 6.0]]);
        assert_eq!((found.count(), found.not_finite(), found.mean()), (2, 1, [2.0, 4.0]));
    }
}
