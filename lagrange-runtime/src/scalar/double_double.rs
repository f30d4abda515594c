//! Numbers of about 32 digits as unevaluated sums of two `f64`.
//!
//! Dekker, Numer. Math. 18 (1971) 224; Hida, Li and Bailey, *Library for double-double and quad-double arithmetic*
//! (2007). The product is split (Dekker, Veltkamp) rather than fused: it has to work without `std`.

use super::{Comparison, Functions, Real, Scalar, real_case};
use core::cmp::Ordering;
use core::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};

pub(crate) mod digits;
mod functions;
mod quarters;

/// A number of about 32 digits, `hi + lo` with `lo` at most half a unit in the last place of `hi`: for reference
/// solutions, and to see what rounding does to a run in `f64`. Its range is that of `f64`; below 1e-290 digits of
/// `lo` underflow.
///
/// The relative error of each elementary function is at most 1e-30 times its condition over the whole range, beside
/// underflow (60 digits of mpmath at 1086 arguments: 3.9e-32). Outside of its domain a function is what that of `f64`
/// is: NaN or infinite.
///
/// # Hypotheses
/// - `lo` is at most half a unit in the last place of `hi`, as in all results. [`Scalar::from_sum`] makes such a
///   number of any two.
///
/// A system of these is made of its fields, or of one in `f64` by its `map`. Constants that were written in the
/// definition have all digits, and so has π; a parameter has those of the number that it is given, so that 9.81 is
/// `DoubleDouble::from(981.0) / 100.0`.
///
/// ```
/// use lagrange_runtime::{DoubleDouble, Functions};
/// let two = DoubleDouble::from(2.0);
/// let defect = two.sqrt() * two.sqrt() - two;
/// assert!(defect.value().abs() < 1e-30);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct DoubleDouble {
    /// The nearest `f64`.
    #[cfg_attr(feature = "serde", serde(with = "crate::saved::number"))]
    pub hi: f64,
    /// The rest.
    #[cfg_attr(feature = "serde", serde(with = "crate::saved::number"))]
    pub lo: f64,
}

use DoubleDouble as Double;

pub(crate) const PI: Double = Double { hi: core::f64::consts::PI, lo: 1.2246467991473532e-16 };

/// `a + b` exactly, where `|a| ≥ |b|`.
const fn quick_two_sum(a: f64, b: f64) -> Double {
    let hi = a + b;
    Double { hi, lo: b - (hi - a) }
}

/// `a + b` exactly (Knuth).
const fn two_sum(a: f64, b: f64) -> Double {
    let hi = a + b;
    let b_part = hi - a;
    Double { hi, lo: (a - (hi - b_part)) + (b - b_part) }
}

/// The upper half of the digits, and the lower one; NaN from 2⁹⁹⁶ on.
const fn split(x: f64) -> (f64, f64) {
    let y = 134_217_729.0 * x; // 2²⁷ + 1
    let high = y - (y - x);
    (high, x - high)
}

/// `a × b` exactly, barring under- and overflow.
const fn two_product(a: f64, b: f64) -> Double {
    let ((ah, al), (bh, bl)) = (split(a), split(b));
    let hi = a * b;
    Double { hi, lo: ((ah * bh - hi) + ah * bl + al * bh) + al * bl }
}

/// The integer nearest to `x`, and NaN from 2⁵¹ on.
pub(crate) fn round(x: f64) -> f64 {
    let shift = 1.5 / f64::EPSILON;
    if Functions::abs(x) < 0.5 / f64::EPSILON { (x + shift) - shift } else { f64::NAN }
}

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

    /// The nearest number of a scalar.
    #[inline(always)]
    pub(crate) fn to<S: Scalar>(self) -> S {
        S::from_sum(self.hi, self.lo)
    }

    pub(crate) fn square(self) -> Double {
        self * self
    }

    /// Square root.
    pub fn sqrt(self) -> Double {
        Functions::sqrt(self)
    }

    /// Sine and cosine.
    pub fn sin_cos(self) -> (Double, Double) {
        functions::sin_cos(self)
    }

    /// Angle of the point `(x, self)` in [−π, π].
    pub fn atan2(self, x: Double) -> Double {
        Functions::atan2(self, x)
    }

    /// `From<f64>`, in constants too.
    const fn single(hi: f64) -> Double {
        Double { hi, lo: 0.0 }
    }

    /// `2ᵏ self`, rounded where it is subnormal.
    const fn scaled(self, k: i32) -> Double {
        let (half, rest) = (power_of_two(k / 2), power_of_two(k - k / 2));
        let hi = self.hi * half * rest;
        Double { hi, lo: if hi.is_finite() { self.lo * half * rest } else { 0.0 } }
    }

    const fn negative(self) -> Double {
        Double { hi: -self.hi, lo: -self.lo }
    }

    pub(crate) const fn plus(self, b: Double) -> Double {
        let (high, low) = (two_sum(self.hi, b.hi), two_sum(self.lo, b.lo));
        if !high.hi.is_finite() {
            return Double::single(high.hi);
        }
        let sum = quick_two_sum(high.hi, high.lo + low.hi);
        quick_two_sum(sum.hi, sum.lo + low.lo)
    }

    const fn times(self, b: Double) -> Double {
        let p = two_product(self.hi, b.hi);
        let lo = p.lo + (self.hi * b.lo + self.lo * b.hi);
        if lo.is_finite() { quick_two_sum(p.hi, lo) } else { self.times_at_the_limit(b) }
    }

    /// The product where it overflows, or the larger factor is too large to be split.
    #[cold]
    const fn times_at_the_limit(self, b: Double) -> Double {
        let (large, small) = if self.hi.abs() < b.hi.abs() { (b, self) } else { (self, b) };
        let hi = large.hi * small.hi;
        if !hi.is_finite() || !large.hi.is_finite() {
            return Double::single(hi);
        }
        large.scaled(-64).times(small.scaled(-64)).scaled(128)
    }

    pub(crate) const fn over(self, b: Double) -> Double {
        if !(is_ordinary(self.hi) && is_ordinary(b.hi)) {
            return self.over_at_the_limit(b);
        }
        let first = self.hi / b.hi;
        let rest = self.plus(b.times(Double::single(first)).negative());
        let second = rest.hi / b.hi;
        let third = rest.plus(b.times(Double::single(second)).negative()).hi / b.hi;
        let quotient = quick_two_sum(first, second);
        quick_two_sum(quotient.hi, quotient.lo + third)
    }

    /// The quotient where parts of it might over- or underflow.
    #[cold]
    const fn over_at_the_limit(self, b: Double) -> Double {
        let first = self.hi / b.hi;
        if first == 0.0 || !first.is_finite() || !b.hi.is_finite() {
            return Double::single(first);
        }
        let [k, l] = [self.exponent(), b.exponent()];
        self.scaled(-k).over(b.scaled(-l)).scaled(k - l)
    }

    /// The k with `2ᵏ ≤ |hi| < 2ᵏ⁺¹`.
    const fn exponent(self) -> i32 {
        let exponent = (self.hi.to_bits() >> 52 & 0x7ff) as i32 - 1023;
        if exponent > -1023 { exponent } else { -1023 - (self.hi.to_bits() << 12).leading_zeros() as i32 }
    }
}

/// Is it of a size whose products and quotients neither over- nor underflow?
const fn is_ordinary(x: f64) -> bool {
    x.abs() < 1e120 && x.abs() > 1e-120
}

/// 2ᵏ for −1023 < k < 1024.
const fn power_of_two(k: i32) -> f64 {
    f64::from_bits(((1023 + k) as u64) << 52)
}

impl From<f64> for Double {
    fn from(x: f64) -> Double {
        Double { hi: x, lo: 0.0 }
    }
}

impl Neg for Double {
    type Output = Double;
    fn neg(self) -> Double {
        self.negative()
    }
}

impl Add for Double {
    type Output = Double;
    fn add(self, b: Double) -> Double {
        self.plus(b)
    }
}

impl Sub for Double {
    type Output = Double;
    fn sub(self, b: Double) -> Double {
        self.plus(b.negative())
    }
}

impl Mul for Double {
    type Output = Double;
    fn mul(self, b: Double) -> Double {
        self.times(b)
    }
}

impl Mul<f64> for Double {
    type Output = Double;
    fn mul(self, b: f64) -> Double {
        self.times(Double::single(b))
    }
}

impl Div for Double {
    type Output = Double;
    fn div(self, b: Double) -> Double {
        self.over(b)
    }
}

impl Div<f64> for Double {
    type Output = Double;
    fn div(self, b: f64) -> Double {
        self.over(Double::single(b))
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

    real_case! {}

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
        functions::sin_cos(self)
    }

    fn lookup<const A: usize, const K: usize>(
        x: [Self; A],
        mut f: impl FnMut(usize, [f64; A]) -> [f64; K],
    ) -> [Self; K] {
        f(0, x.map(Real::to_f64)).map(Double::from)
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

#[cfg(test)]
mod tests;
