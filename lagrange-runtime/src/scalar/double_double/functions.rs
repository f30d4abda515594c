//! The elementary functions, with an error of a few units of rounding times their condition, over the whole range of
//! `f64`.
//!
//! They come from three series (sine and cosine, exponential) and from Newton's method, by identities (Abramowitz and
//! Stegun 1964, ch. 4). An argument close to a zero, a pole or the end of the range is brought away from it by an
//! exact operation first: a difference to 1, a factor of a power of 2, a number of quarter turns.

use super::quarters::reduced;
use super::{Double, PI};
use crate::scalar::Functions;

const LN_2: Double = Double { hi: core::f64::consts::LN_2, lo: 2.3190468138462996e-17 };
const LN_10: Double = Double { hi: core::f64::consts::LN_10, lo: -2.1707562233822494e-16 };

/// Below this size x and each of the odd functions that begin with x are the same to all digits, since x² is below
/// 2⁻¹⁰⁷.
const TINY: f64 = 5e-17;

/// Size from which on `e⁻²ˣ`, and `1/x²`, are below the rounding of 1.
const HUGE_EXPONENT: f64 = 40.0;
const HUGE: f64 = 1e17;

/// Sine and cosine: reduction by quarter turns, then the power series on [−π/4, π/4].
pub(super) fn sin_cos(x: Double) -> (Double, Double) {
    if !x.hi.is_finite() {
        return (Double::from(f64::NAN), Double::from(f64::NAN));
    }
    let (quarters, x) = reduced(x);
    if x.hi == 0.0 {
        return (x, Double::ONE);
    }
    let (mut term, mut series) = (Double::ONE, [Double::ONE, Double::ZERO]);
    // (π/4)³⁰/30! < 3e-36
    for n in 1..30_u8 {
        term = term * x / f64::from(n);
        let signed = if n % 4 < 2 { term } else { -term };
        series[usize::from(n % 2)] += signed;
    }
    let [c, s] = series;
    match quarters {
        1 => (c, -s),
        2 => (-s, -c),
        3 => (-c, s),
        _ => (s, c),
    }
}

impl Double {
    /// Is it one of 0, an infinity and NaN, whose functions are those of `f64`?
    fn is_special(self) -> bool {
        self.hi == 0.0 || !self.hi.is_finite()
    }

    fn is_tiny(self) -> bool {
        Functions::abs(self.hi) < TINY
    }

    /// `self` with the sign of `x`.
    fn with_sign_of(self, x: Double) -> Double {
        if self.hi.is_sign_negative() == x.hi.is_sign_negative() { self } else { -self }
    }

    /// `eˣ = 2ᵏ (1 + y)`: k and y, by the power series of a 512th of the rest. |x| < 2⁴⁰.
    fn exponential(self) -> (i32, Double) {
        let k = super::round(self.hi / core::f64::consts::LN_2);
        let x = (self - LN_2 * k) * (1.0 / 512.0);
        let (mut term, mut y) = (x, x);
        // (ln 2/1024)¹¹/11! < 1e-42
        for n in 2..11_u8 {
            term = term * x / f64::from(n);
            y += term;
        }
        for _ in 0..9 {
            y = y * 2.0 + y.square();
        }
        (k as i32, y)
    }

    /// `2ˢ eˣ`, in the range of `f64` or not.
    fn exponential_times(self, s: i32) -> Double {
        if self.hi.is_nan() || Functions::abs(self.hi) > 800.0 {
            return Double::from(Functions::exp(self.hi));
        }
        let (k, y) = self.exponential();
        (y + Double::ONE).scaled(k + s)
    }

    /// `x = 2ᵏ (1 + y)` with y from √½ − 1 to √2 − 1, exactly: k and y. x is positive and finite.
    fn binary(self) -> (i32, Double) {
        let k = self.exponent();
        let mantissa = self.scaled(-k);
        let above = mantissa.hi > core::f64::consts::SQRT_2;
        let (k, mantissa) = if above { (k + 1, mantissa.scaled(-1)) } else { (k, mantissa) };
        (k, mantissa - Double::ONE)
    }

    /// `ln(1 + x)` for x from √½ − 1 to √2 − 1: one Newton step from the logarithm in `f64`.
    fn ln_near_one(self) -> Double {
        if self.is_tiny() {
            return self - self.square() * 0.5;
        }
        let near = Double::from(Functions::ln_1p(self.hi));
        let reached = Functions::exp_m1(near);
        near + (self - reached) / (reached + Double::ONE)
    }

    /// Is its logarithm that of `f64`?
    fn has_no_logarithm(self) -> bool {
        self.is_special() || self.hi < 0.0
    }
}

/// `(y, x)` over a power of 2 that brings the larger one near 1, and the exponent of this power.
fn near_one(y: Double, x: Double) -> (Double, Double, i32) {
    let k = y.exponent().max(x.exponent());
    (y.scaled(-k), x.scaled(-k), k)
}

/// Returns whether an integer is odd.
fn parity(x: f64) -> Option<bool> {
    if Functions::abs(x) >= 1.0 / f64::EPSILON * 2.0 {
        return x.is_finite().then_some(false);
    }
    (x as i64 as f64 == x).then_some(x as i64 & 1 == 1)
}

impl Functions for Double {
    fn sin(self) -> Self {
        sin_cos(self).0
    }
    fn cos(self) -> Self {
        sin_cos(self).1
    }
    fn tan(self) -> Self {
        let (sin, cos) = sin_cos(self);
        sin / cos
    }
    fn asin(self) -> Self {
        Functions::atan2(self, Functions::sqrt((Double::ONE - self) * (Double::ONE + self)))
    }
    fn acos(self) -> Self {
        Functions::atan2(Functions::sqrt((Double::ONE - self) * (Double::ONE + self)), self)
    }
    fn atan(self) -> Self {
        Functions::atan2(self, Double::ONE)
    }
    /// The `f64` angle, turned by what is left over.
    fn atan2(self, x: Self) -> Self {
        let unit = |part: f64| {
            if part.is_infinite() { Functions::signum(part) } else { Functions::signum(part) * 0.0 }
        };
        if self.hi.is_infinite() || x.hi.is_infinite() {
            if self.hi.is_nan() || x.hi.is_nan() {
                return Double::from(f64::NAN);
            }
            return Functions::atan2(Double::from(unit(self.hi)), Double::from(unit(x.hi)));
        }
        let angle = Double::from(Functions::atan2(self.hi, x.hi));
        if self.hi == 0.0 && !x.hi.is_sign_negative() || angle.hi.is_nan() {
            return angle;
        }
        if angle.is_tiny() {
            return self / x;
        }
        let (y, x, _) = near_one(self, x);
        let (sin, cos) = sin_cos(angle);
        let length = Functions::sqrt(y.square() + x.square());
        if length.hi > 0.0 { angle + (y * cos - x * sin) / length } else { angle * PI / PI.hi }
    }
    fn sinh(self) -> Self {
        let x = Functions::abs(self);
        if self.is_tiny() || self.hi.is_nan() {
            self
        } else if x.hi > HUGE_EXPONENT {
            x.exponential_times(-1).with_sign_of(self)
        } else {
            let y = Functions::exp_m1(x);
            ((y + y / (y + Double::ONE)) * 0.5).with_sign_of(self)
        }
    }
    fn cosh(self) -> Self {
        let half = Functions::abs(self).exponential_times(-1);
        if half.hi > HUGE { half } else { half + Double::from(0.25) / half }
    }
    fn tanh(self) -> Self {
        if self.is_tiny() || Functions::abs(self.hi) > HUGE_EXPONENT {
            return if self.is_tiny() { self } else { Double::from(Functions::tanh(self.hi)) };
        }
        let y = Functions::exp_m1(self * 2.0);
        y / (y + Double::from(2.0))
    }
    fn asinh(self) -> Self {
        let x = Functions::abs(self);
        let size = if self.is_tiny() || self.hi.is_nan() {
            x
        } else if x.hi > HUGE {
            Functions::ln(x) + LN_2
        } else {
            Functions::ln_1p(x + x.square() / (Double::ONE + Functions::sqrt(Double::ONE + x.square())))
        };
        size.with_sign_of(self)
    }
    fn acosh(self) -> Self {
        let above = self - Double::ONE;
        if above.hi < 0.0 {
            Double::from(f64::NAN)
        } else if self.hi > HUGE {
            Functions::ln(self) + LN_2
        } else {
            Functions::ln_1p(above + Functions::sqrt(above * (self + Double::ONE)))
        }
    }
    fn atanh(self) -> Self {
        let x = Functions::abs(self);
        if self.is_tiny() {
            return self;
        }
        (Functions::ln_1p(x * 2.0 / (Double::ONE - x)) * 0.5).with_sign_of(self)
    }
    fn exp(self) -> Self {
        self.exponential_times(0)
    }
    fn exp_m1(self) -> Self {
        if self.is_special() || Functions::abs(self.hi) > 800.0 {
            return Double::from(Functions::exp_m1(self.hi));
        }
        if self.is_tiny() {
            return self + self.square() * 0.5;
        }
        let (k, y) = self.exponential();
        if k == 0 { y } else { (y + Double::ONE).scaled(k) - Double::ONE }
    }
    fn exp2(self) -> Self {
        if self.is_special() || Functions::abs(self.hi) > 1100.0 {
            return Double::from(Functions::exp2(self.hi));
        }
        let k = super::round(self.hi);
        ((self - Double::from(k)) * LN_2).exponential_times(k as i32)
    }
    fn ln(self) -> Self {
        if self.has_no_logarithm() {
            return Double::from(Functions::ln(self.hi));
        }
        let (k, y) = self.binary();
        LN_2 * f64::from(k) + y.ln_near_one()
    }
    fn ln_1p(self) -> Self {
        if self.hi > -0.29 && self.hi < 0.41 { self.ln_near_one() } else { Functions::ln(Double::ONE + self) }
    }
    fn log2(self) -> Self {
        if self.has_no_logarithm() {
            return Double::from(Functions::log2(self.hi));
        }
        let (k, y) = self.binary();
        y.ln_near_one() / LN_2 + Double::from(f64::from(k))
    }
    fn log10(self) -> Self {
        Functions::ln(self) / LN_10
    }
    /// One Newton step from the `f64` root doubles its digits.
    fn sqrt(self) -> Self {
        if self.has_no_logarithm() {
            return Double::from(Functions::sqrt(self.hi));
        }
        let k = self.exponent().div_euclid(2);
        let mantissa = self.scaled(-2 * k);
        let x = Double::from(Functions::sqrt(mantissa.hi));
        (x + (mantissa - x.square()) / (x * 2.0)).scaled(k)
    }
    /// Cube root by one Newton step, as the square root.
    fn cbrt(self) -> Self {
        if self.is_special() {
            return Double::from(Functions::cbrt(self.hi));
        }
        let k = self.exponent().div_euclid(3);
        let mantissa = self.scaled(-3 * k);
        let near = Double::from(Functions::cbrt(mantissa.hi));
        (near + (mantissa - near * near.square()) / (near.square() * 3.0)).scaled(k)
    }
    fn abs(self) -> Self {
        if self.hi.is_sign_negative() { -self } else { self }
    }
    fn signum(self) -> Self {
        Double::from(Functions::signum(self.hi))
    }
    fn hypot(self, y: Self) -> Self {
        let near = Functions::hypot(self.hi, y.hi);
        if near == 0.0 || !self.hi.is_finite() || !y.hi.is_finite() {
            return Double::from(near);
        }
        let (x, y, k) = near_one(self, y);
        Functions::sqrt(x.square() + y.square()).scaled(k)
    }
    fn powf(self, y: Self) -> Self {
        let odd = match (parity(y.hi), parity(y.lo)) {
            (Some(high), Some(low)) => Some(high != low),
            _ => None,
        };
        if self.is_special() || y.is_special() || self.hi < 0.0 && odd.is_none() {
            let size = Functions::abs(self);
            return if y.hi.is_infinite() && !self.is_special() && size != Double::ONE {
                Functions::exp(Functions::ln(size) * y)
            } else {
                Double::from(Functions::powf(self.hi, y.hi))
            };
        }
        let size = Functions::exp(Functions::ln(Functions::abs(self)) * y);
        if self.hi < 0.0 && odd == Some(true) { -size } else { size }
    }
}
