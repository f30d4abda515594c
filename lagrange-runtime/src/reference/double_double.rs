//! Numbers of about 32 digits as unevaluated sums of two `f64`, so that a reference is exact to the last bit of the
//! result after many periods and near separatrices, where plain `f64` loses digits to the phase.
//!
//! Dekker, Numer. Math. 18 (1971) 224; Hida, Li and Bailey, *Library for double-double and quad-double arithmetic*
//! (2007). The product is split (Dekker, Veltkamp) rather than fused: it has to work without `std`.

use crate::scalar::Functions;
use core::ops::{Add, Div, Mul, Neg, Sub};

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Double {
    pub hi: f64,
    pub lo: f64,
}

pub(super) const PI: Double = Double { hi: core::f64::consts::PI, lo: 1.2246467991473532e-16 };

/// `a + b` exactly, where `|a| ≥ |b|`.
fn quick_two_sum(a: f64, b: f64) -> Double {
    let hi = a + b;
    Double { hi, lo: b - (hi - a) }
}

/// `a + b` exactly (Knuth).
fn two_sum(a: f64, b: f64) -> Double {
    let hi = a + b;
    let b_part = hi - a;
    Double { hi, lo: (a - (hi - b_part)) + (b - b_part) }
}

/// `a × b` exactly, barring overflow.
fn two_product(a: f64, b: f64) -> Double {
    let split = |x: f64| {
        let y = 134_217_729.0 * x; // 2²⁷ + 1
        let high = y - (y - x);
        (high, x - high)
    };
    let ((ah, al), (bh, bl)) = (split(a), split(b));
    let hi = a * b;
    Double { hi, lo: ((ah * bh - hi) + ah * bl + al * bh) + al * bl }
}

/// The integer nearest to `x`, and NaN from 2⁵¹ on, where there is no phase left to speak of.
pub(super) fn round(x: f64) -> f64 {
    let shift = 1.5 / f64::EPSILON;
    if Functions::abs(x) < 0.5 / f64::EPSILON { (x + shift) - shift } else { f64::NAN }
}

impl Double {
    pub const ZERO: Double = Double { hi: 0.0, lo: 0.0 };
    pub const ONE: Double = Double { hi: 1.0, lo: 0.0 };

    pub fn value(self) -> f64 {
        self.hi + self.lo
    }

    pub fn square(self) -> Double {
        self * self
    }

    /// One Newton step from the `f64` root doubles its digits.
    pub fn sqrt(self) -> Double {
        if self.hi == 0.0 {
            return self;
        }
        let x = Double::from(Functions::sqrt(self.hi));
        x + (self - x.square()) / (x * 2.0)
    }

    /// Sine and cosine: reduction by quarter turns, then the power series on [−π/4, π/4].
    pub fn sin_cos(self) -> (Double, Double) {
        let quarters = round(self.hi / core::f64::consts::FRAC_PI_2);
        let x = self - PI * 0.5 * quarters;
        let (mut term, mut series) = (Double::ONE, [Double::ONE, Double::ZERO]);
        // (π/4)³⁰/30! < 3e-36
        for n in 1..30_u8 {
            term = term * x / f64::from(n);
            let signed = if n % 4 < 2 { term } else { -term };
            series[usize::from(n % 2)] = series[usize::from(n % 2)] + signed;
        }
        let [c, s] = series;
        match (quarters % 4.0 + 4.0) % 4.0 {
            1.0 => (c, -s),
            2.0 => (-s, -c),
            3.0 => (-c, s),
            _ => (s, c),
        }
    }

    /// Angle of the point `(x, self)` in [−π, π]: the `f64` angle, turned by what is left over.
    pub fn atan2(self, x: Double) -> Double {
        let angle = Double::from(Functions::atan2(self.hi, x.hi));
        let (sin, cos) = angle.sin_cos();
        let length = (self.square() + x.square()).sqrt();
        if length.hi > 0.0 { angle + (self * cos - x * sin) / length } else { angle }
    }
}

impl From<f64> for Double {
    fn from(x: f64) -> Double {
        Double { hi: x, lo: 0.0 }
    }
}

impl Neg for Double {
    type Output = Double;
    fn neg(self) -> Double {
        Double { hi: -self.hi, lo: -self.lo }
    }
}

impl Add for Double {
    type Output = Double;
    fn add(self, b: Double) -> Double {
        let (high, low) = (two_sum(self.hi, b.hi), two_sum(self.lo, b.lo));
        let sum = quick_two_sum(high.hi, high.lo + low.hi);
        quick_two_sum(sum.hi, sum.lo + low.lo)
    }
}

impl Sub for Double {
    type Output = Double;
    fn sub(self, b: Double) -> Double {
        self + -b
    }
}

impl Mul for Double {
    type Output = Double;
    fn mul(self, b: Double) -> Double {
        let p = two_product(self.hi, b.hi);
        quick_two_sum(p.hi, p.lo + (self.hi * b.lo + self.lo * b.hi))
    }
}

impl Mul<f64> for Double {
    type Output = Double;
    fn mul(self, b: f64) -> Double {
        self * Double::from(b)
    }
}

impl Div for Double {
    type Output = Double;
    fn div(self, b: Double) -> Double {
        let first = self.hi / b.hi;
        let rest = self - b * first;
        let second = rest.hi / b.hi;
        let third = (rest - b * second).hi / b.hi;
        let quotient = quick_two_sum(first, second);
        quick_two_sum(quotient.hi, quotient.lo + third)
    }
}

impl Div<f64> for Double {
    type Output = Double;
    fn div(self, b: f64) -> Double {
        self / Double::from(b)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: Double, b: Double, scale: f64) -> bool {
        ((a - b).hi / scale).abs() < 1e-30
    }

    #[test]
    fn arithmetic_has_thirty_digits() {
        let third = Double::ONE / 3.0;
        assert!(close(third * 3.0, Double::ONE, 1.0));
        assert!(close(Double::from(2.0).sqrt().square(), Double::from(2.0), 2.0));
    }

    #[test]
    fn circular_functions_have_thirty_digits_in_every_quadrant() {
        // sin 1 = 0.8414709848078965066525023216302989996…, in two parts
        let (sin, cos) = Double::ONE.sin_cos();
        let expected = Double { hi: 0.841_470_984_807_896_5, lo: 1.776845092935536e-18 };
        assert!(close(sin, expected, 1.0), "{sin:?}");
        assert!(close(sin.square() + cos.square(), Double::ONE, 1.0));
        for i in -12_i32..=12 {
            let angle = PI / 12.0 * f64::from(i);
            let (sin, cos) = angle.sin_cos();
            assert!(i.abs() == 12 || close(sin.atan2(cos), angle, 1.0), "{i}");
            let (sin_3, _) = (angle * 3.0).sin_cos();
            assert!(close(sin_3, sin * 3.0 - sin * sin.square() * 4.0, 1.0), "{i}");
        }
    }
}
