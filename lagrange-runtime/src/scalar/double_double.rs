//! Numbers of about 32 digits as unevaluated sums of two `f64`.
//!
//! Dekker, Numer. Math. 18 (1971) 224; Hida, Li and Bailey, *Library for double-double and quad-double arithmetic*
//! (2007). The product is split (Dekker, Veltkamp) rather than fused: it has to work without `std`.

use super::{Comparison, Functions, Real, Scalar};
use core::cmp::Ordering;
use core::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};

/// A number of about 32 digits, `hi + lo` with `lo` at most half a unit in the last place of `hi`: for reference solutions, and to see
/// what rounding does to a run in `f64`. Products overflow from 1e300 on, since factors are split.
///
/// A system of these is made of its fields, or of one in `f64` by its `map`. Constants that were written in the definition have all
/// digits, and so has π; a parameter has those of the number that it is given, so that 9.81 is `DoubleDouble::from(981.0) / 100.0`.
///
/// ```
/// use lagrange_runtime::{DoubleDouble, Functions};
/// let two = DoubleDouble::from(2.0);
/// let defect = two.sqrt() * two.sqrt() - two;
/// assert!(defect.value().abs() < 1e-30);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DoubleDouble {
    /// The nearest `f64`.
    pub hi: f64,
    /// The rest.
    pub lo: f64,
}

use DoubleDouble as Double;

pub(crate) const PI: Double = Double { hi: core::f64::consts::PI, lo: 1.2246467991473532e-16 };

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
pub(crate) fn round(x: f64) -> f64 {
    let shift = 1.5 / f64::EPSILON;
    if Functions::abs(x) < 0.5 / f64::EPSILON { (x + shift) - shift } else { f64::NAN }
}

const LN_2: Double = Double { hi: core::f64::consts::LN_2, lo: 2.3190468138462996e-17 };
const LN_10: Double = Double { hi: core::f64::consts::LN_10, lo: -2.1707562233822494e-16 };

impl Double {
    /// 0.
    pub const ZERO: Double = Double { hi: 0.0, lo: 0.0 };
    /// 1.
    pub const ONE: Double = Double { hi: 1.0, lo: 0.0 };
    /// π.
    pub const PI: Double = PI;

    /// The nearest `f64`.
    pub fn value(self) -> f64 {
        self.hi + self.lo
    }

    pub(crate) fn square(self) -> Double {
        self * self
    }

    /// Is it one of 0, an infinity and NaN, whose functions are those of `f64`?
    fn is_special(self) -> bool {
        self.hi == 0.0 || !self.hi.is_finite()
    }

    /// One Newton step from the `f64` root doubles its digits.
    pub fn sqrt(self) -> Double {
        if self.is_special() || self.hi < 0.0 {
            return Double::from(Functions::sqrt(self.hi));
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

    /// `eˣ = 2ᵏ (1 + y)`: k and y, by the power series of a 512th of the rest.
    fn exponential(self) -> (i32, Double) {
        let k = round(self.hi / core::f64::consts::LN_2);
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

    /// One Newton step from the `f64` logarithm of 1 + x.
    fn logarithm_of_one_and(self) -> Double {
        let near = Functions::ln_1p(self.hi);
        if self.is_special() || !near.is_finite() {
            return Double::from(near);
        }
        let near = Double::from(near);
        let reached = near.exp_m1();
        near + (self - reached) / (reached + Double::ONE)
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

macro_rules! assign {
    ($($trait:ident $method:ident $op:tt)*) => {$(
        impl $trait for Double {
            fn $method(&mut self, o: Self) {
                *self = *self $op o;
            }
        }
    )*};
}

assign! { AddAssign add_assign +  SubAssign sub_assign -  MulAssign mul_assign *  DivAssign div_assign / }

impl PartialOrd for Double {
    fn partial_cmp(&self, o: &Self) -> Option<Ordering> {
        match self.hi.partial_cmp(&o.hi) {
            Some(Ordering::Equal) => self.lo.partial_cmp(&o.lo),
            decided => decided,
        }
    }
}

impl Scalar for Double {
    type Pair = [Self; 2];

    fn from_f64(x: f64) -> Self {
        Double::from(x)
    }

    fn from_sum(x: f64, rest: f64) -> Self {
        quick_two_sum(x, rest)
    }

    fn mul_add(self, a: Self, b: Self) -> Self {
        self * a + b
    }

    fn sin_cos(self) -> (Self, Self) {
        Double::sin_cos(self)
    }

    fn select(comparison: Comparison, a: Self, b: Self, yes: Self, no: Self) -> Self {
        let holds = match comparison {
            Comparison::Less => a < b,
            Comparison::LessEqual => a <= b,
            Comparison::Equal => a == b,
        };
        if holds { yes } else { no }
    }
}

impl Real for Double {
    /// 2⁻¹⁰⁴, which the sums of products here keep to within a few units.
    const EPSILON: f64 = f64::EPSILON * f64::EPSILON;

    fn to_f64(self) -> f64 {
        self.value()
    }
}

/// From those that series and Newton's method give, by identities (Abramowitz and Stegun 1964, ch. 4).
impl Functions for Double {
    fn sin(self) -> Self {
        Double::sin_cos(self).0
    }
    fn cos(self) -> Self {
        Double::sin_cos(self).1
    }
    fn tan(self) -> Self {
        let (sin, cos) = Double::sin_cos(self);
        sin / cos
    }
    fn asin(self) -> Self {
        Double::atan2(self, ((Double::ONE - self) * (Double::ONE + self)).sqrt())
    }
    fn acos(self) -> Self {
        Double::atan2(((Double::ONE - self) * (Double::ONE + self)).sqrt(), self)
    }
    fn atan(self) -> Self {
        if self.is_special() {
            Double::from(Functions::atan(self.hi))
        } else {
            Double::atan2(self, Double::ONE)
        }
    }
    fn atan2(self, x: Self) -> Self {
        Double::atan2(self, x)
    }
    fn sinh(self) -> Self {
        let y = Functions::exp_m1(Functions::abs(self));
        let size = (y + y / (y + Double::ONE)) * 0.5;
        if self.hi < 0.0 { -size } else { size }
    }
    fn cosh(self) -> Self {
        let y = Functions::exp(Functions::abs(self));
        (y + Double::ONE / y) * 0.5
    }
    fn tanh(self) -> Self {
        // From here on it is 1 to all digits.
        if Functions::abs(self.hi) > 40.0 {
            return Double::from(Functions::tanh(self.hi));
        }
        let y = Functions::exp_m1(self * 2.0);
        y / (y + Double::from(2.0))
    }
    fn asinh(self) -> Self {
        let x = Functions::abs(self);
        let size = Functions::ln_1p(x + x.square() / (Double::ONE + (Double::ONE + x.square()).sqrt()));
        if self.hi < 0.0 { -size } else { size }
    }
    fn acosh(self) -> Self {
        let above = self - Double::ONE;
        Functions::ln_1p(above + (above * (self + Double::ONE)).sqrt())
    }
    fn atanh(self) -> Self {
        Functions::ln_1p(self * 2.0 / (Double::ONE - self)) * 0.5
    }
    fn exp(self) -> Self {
        // Where f64 has no room, or no digits left for the second part.
        if self.is_special() || Functions::abs(self.hi) > 650.0 {
            return Double::from(Functions::exp(self.hi));
        }
        let (k, y) = self.exponential();
        (y + Double::ONE) * power_of_two(k)
    }
    fn exp_m1(self) -> Self {
        if self.is_special() || Functions::abs(self.hi) > 650.0 {
            return Double::from(Functions::exp_m1(self.hi));
        }
        let (k, y) = self.exponential();
        if k == 0 { y } else { (y + Double::ONE) * power_of_two(k) - Double::ONE }
    }
    fn exp2(self) -> Self {
        Functions::exp(self * LN_2)
    }
    fn ln(self) -> Self {
        let near = Functions::ln(self.hi);
        if self.is_special() || self.hi < 0.0 {
            return Double::from(near);
        }
        // One Newton step.
        let near = Double::from(near);
        near + (self / Functions::exp(near) - Double::ONE)
    }
    fn ln_1p(self) -> Self {
        self.logarithm_of_one_and()
    }
    fn log2(self) -> Self {
        Functions::ln(self) / LN_2
    }
    fn log10(self) -> Self {
        Functions::ln(self) / LN_10
    }
    fn sqrt(self) -> Self {
        Double::sqrt(self)
    }
    fn cbrt(self) -> Self {
        let near = Double::from(Functions::cbrt(self.hi));
        if self.is_special() {
            return near;
        }
        near + (self - near * near.square()) / (near.square() * 3.0)
    }
    fn abs(self) -> Self {
        if self.hi < 0.0 { -self } else { self }
    }
    fn signum(self) -> Self {
        Double::from(Functions::signum(self.hi))
    }
    fn hypot(self, y: Self) -> Self {
        (self.square() + y.square()).sqrt()
    }
    fn powf(self, y: Self) -> Self {
        let whole = y.lo == 0.0 && round(y.hi) == y.hi;
        if self.is_special() || self.hi < 0.0 && !whole {
            return Double::from(Functions::powf(self.hi, y.hi));
        }
        let size = Functions::exp(Functions::ln(Functions::abs(self)) * y);
        if self.hi < 0.0 && round(y.hi * 0.5) * 2.0 != y.hi { -size } else { size }
    }
}

/// 2ᵏ for |k| < 1000.
fn power_of_two(k: i32) -> f64 {
    f64::from_bits(((1023 + k) as u64) << 52)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Inverse pairs and addition theorems, at points that have no special place.
    #[test]
    fn functions_have_thirty_digits() {
        let one = Double::ONE;
        for i in 1..40_i32 {
            let x = one * f64::from(i) / 7.0;
            let small = x / 41.0;
            let relative = |what: &str, a: Double, b: Double| {
                assert!(((a - b) / b).value().abs() < 3e-30, "{what} {i}: {a:?} {b:?}");
            };
            relative("exp", Functions::exp(x) * Functions::exp(-x), one);
            relative("exp of a sum", Functions::exp(x + small), Functions::exp(x) * Functions::exp(small));
            relative("ln", Functions::ln(Functions::exp(x)), x);
            relative("ln_1p", Functions::ln_1p(Functions::exp_m1(small)), small);
            relative("log2", Functions::log2(Functions::exp2(x)), x);
            relative("log10", Functions::log10(Functions::powf(one * 10.0, x)), x);
            relative("asinh", Functions::asinh(Functions::sinh(x)), x);
            relative(
                "sinh of a half",
                Functions::sinh(x),
                Functions::sinh(x / 2.0) * Functions::cosh(x / 2.0) * 2.0,
            );
            relative("cosh", Functions::cosh(x).square(), one + Functions::sinh(x).square());
            relative("tanh", Functions::tanh(x) * Functions::cosh(x), Functions::sinh(x));
            relative("acosh", Functions::cosh(Functions::acosh(one + x)), one + x);
            relative("atanh", Functions::atanh(Functions::tanh(small)), small);
            relative("asin", Functions::asin(Functions::sin(small)), small);
            relative("acos", Functions::cos(Functions::acos(small)), small);
            relative("atan", Functions::tan(Functions::atan(x)), x);
            relative("cbrt", Functions::cbrt(x) * Functions::cbrt(x).square(), x);
            relative("hypot", Functions::hypot(x * 3.0, x * 4.0), x * 5.0);
            relative("powf", Functions::powf(x, one * 3.0), x * x.square());
            relative("powf of negative numbers", Functions::powf(-x, one * 3.0), -(x * x.square()));
        }
        // e = 2.71828182845904523536028747135266249775…, in two parts.
        let e = Double { hi: core::f64::consts::E, lo: 1.4456468917292502e-16 };
        assert!((Functions::exp(one) - e).value().abs() < 1e-31);
    }

    #[test]
    fn limits_are_those_of_f64() {
        let of = Double::from;
        assert_eq!(Functions::exp(of(-1e4)).value(), 0.0);
        assert_eq!(Functions::exp(of(1e4)).value(), f64::INFINITY);
        assert_eq!(Functions::ln(of(0.0)).value(), f64::NEG_INFINITY);
        assert!(Functions::ln(of(-1.0)).value().is_nan() && Functions::sqrt(of(-1.0)).value().is_nan());
        assert_eq!(Functions::powf(of(0.0), of(2.0)).value(), 0.0);
        assert_eq!(Functions::tanh(of(100.0)).value(), 1.0);
        assert!(of(1.0) < Double { hi: 1.0, lo: 1e-20 } && of(-1.0) < of(1.0));
    }

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
