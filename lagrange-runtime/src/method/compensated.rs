//! Sums over many steps that lose nothing to rounding: a value, and the rest that no longer fits into it.
//!
//! Kahan's compensated summation keeps the rounding error of the sum, but not that of the increment `h x`, nor of the
//! points inside of a step, `y + h Σ aᵢⱼ kⱼ`. Both errors are small and look random, but are not quite: increments
//! lie on a grid that is only a few times finer than that of y, so that halves are frequent and always go to even.
//! The energy then drifts in proportion to time, by 1e-19 a step, where it should grow as the root of it (Brouwer's
//! law; Hairer, McLachlan, Razakarivony, *Achieving Brouwer's law with implicit Runge–Kutta methods*, BIT 48, 2008).
//! Here products are exact (Dekker, Numer. Math. 18, 1971), and points are rounded once.
//!
//! What is left is a bias of implicit equations themselves. In numbers of finite length an iteration has several fixed
//! points, one unit apart, and which of them is found depends on where it came from, which is the same wherever the
//! motion is. [`forgetful`] makes it come from anywhere.

use crate::scalar::{Real, Scalar, SimdScalar};
use nalgebra::SVector;

/// `value + rest`, where `rest` is below the last digit of `value`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sum<S, const N: usize> {
    pub value: SVector<S, N>,
    pub rest: SVector<S, N>,
}

impl<S: SimdScalar, const N: usize> Sum<S, N> {
    /// `value + rest + h x`, the product of which is rounded, too: near enough until an iteration has converged.
    #[inline(always)]
    pub fn near(&self, h: S, x: &SVector<S, N>) -> SVector<S, N> {
        let mut near = self.value;
        for i in 0..N {
            near[i] += h.mul_add(x[i], self.rest[i]);
        }
        near
    }

    /// `value + rest + h x`, rounded once.
    #[inline(always)]
    pub fn at(&self, h: S, x: &SVector<S, N>) -> SVector<S, N> {
        let mut sum = *self;
        sum.add_product(h, x);
        sum.value
    }

    /// Adds `h x`.
    #[inline(always)]
    pub fn add_product(&mut self, h: S, x: &SVector<S, N>) {
        for i in 0..N {
            let (product, product_error) = two_product(h, x[i]);
            let (sum, error) = two_sum(self.value[i], product);
            (self.value[i], self.rest[i]) = two_sum(sum, error + (product_error + self.rest[i]));
        }
    }
}

/// `x` without its last five binary digits, to nearest (Veltkamp's splitting): where an iteration that has converged is
/// to begin once more, so that two iterations later its result does not remember from which side it came.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn forgetful<S: Scalar, const N: usize>(x: &SVector<S, N>) -> SVector<S, N> {
    let mut rounded = *x;
    for i in 0..N {
        let y = S::from_f64(33.0) * x[i];
        rounded[i] = y - (y - x[i]);
    }
    rounded
}

/// `a + b`, and its rounding error, exactly (Knuth).
#[inline(always)]
fn two_sum<S: Scalar>(a: S, b: S) -> (S, S) {
    let sum = a + b;
    let b_part = sum - a;
    (sum, (a - (sum - b_part)) + (b - b_part))
}

/// `a b`, and its rounding error, exactly, barring overflow. Split and not fused: not every target can fuse.
#[inline(always)]
fn two_product<S: SimdScalar>(a: S, b: S) -> (S, S) {
    let ((a_high, a_low), (b_high, b_low)) = (split(a), split(b));
    let product = a * b;
    (product, ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low)
}

/// The upper half of the digits, and the lower one.
#[inline(always)]
fn split<S: SimdScalar>(x: S) -> (S, S) {
    // 2²⁷ + 1 of 53 digits, 2¹² + 1 of 24.
    let y = S::from_f64(if S::Element::EPSILON < 1e-10 { 134_217_729.0 } else { 4097.0 }) * x;
    let high = y - (y - x);
    (high, x - high)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// In integers: 0.1 as f64 is this over 2⁵⁵.
    const TENTH: i128 = 3602879701896397;

    #[test]
    fn a_million_tenths_are_what_integers_make_of_them() {
        let mut sum = Sum { value: SVector::from([0.0]), rest: SVector::from([0.0]) };
        for _ in 0..1_000_000 {
            sum.add_product(0.1, &SVector::from([0.1]));
        }
        // 10⁶ · TENTH² / 2¹¹⁰
        let exact = 1_000_000 * TENTH * TENTH;
        let high = sum.value[0];
        let left = exact - ((high * 2f64.powi(50)) as i128) * (1i128 << 60);
        assert_eq!(high * 2f64.powi(50) % 1.0, 0.0, "the value is a multiple of 2⁻⁵⁰");
        let rest = left as f64 * 2f64.powi(-110);
        // A plain sum of these products is off by 1e-8, a compensated one of rounded products by 1e-14.
        assert!(rest != 0.0 && (sum.rest[0] - rest).abs() < 1e-22, "{} {rest}", sum.rest[0]);
    }

    #[test]
    fn products_are_exact_in_both_precisions() {
        let (product, error) = two_product(0.1f64, 0.1);
        assert_eq!(error, (TENTH * TENTH - (product * 2f64.powi(110)) as i128) as f64 * 2f64.powi(-110));
        let (product, error) = two_product(0.1f32, 0.7f32);
        assert_eq!(f64::from(product) + f64::from(error), f64::from(0.1f32) * f64::from(0.7f32));
    }

    #[test]
    fn forgetting_rounds_to_nearest() {
        let unit = f64::EPSILON;
        for (x, rounded) in [(1.0 + 15.0 * unit, 1.0), (1.0 + 17.0 * unit, 1.0 + 32.0 * unit), (-3.0, -3.0)] {
            assert_eq!(forgetful(&SVector::from([x]))[0], rounded);
        }
    }

    /// Halves are decided by the rest, not by evenness.
    #[test]
    fn points_are_rounded_once() {
        let at = |rest: f64| Sum { value: SVector::from([1.0]), rest: SVector::from([rest]) };
        let half = SVector::from([f64::EPSILON]);
        assert_eq!(at(1e-20).at(0.5, &half)[0], 1.0 + f64::EPSILON);
        assert_eq!(at(-1e-20).at(0.5, &half)[0], 1.0);
    }
}
