//! Constants: exact rationals in machine words, falling over to some 32 digits when a numerator or denominator
//! outgrows them. So numbers of twice the digits of `f64` have all of them, and whatever is emitted of a system is of
//! the same one.

use std::cmp::Ordering;

/// A rational number in lowest terms with a positive denominator, or a float where that did not fit.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Number {
    Ratio(i64, i64),
    /// The nearest `f64`, and the rest; bits, so that equal constants are equal nodes.
    Float(u64, u64),
}

impl Number {
    pub const ZERO: Number = Number::Ratio(0, 1);
    pub const ONE: Number = Number::Ratio(1, 1);
    pub const MINUS_ONE: Number = Number::Ratio(-1, 1);

    pub fn float(x: f64) -> Number {
        Number::of(Digits { hi: x, lo: 0.0 })
    }

    fn of(Digits { hi, lo }: Digits) -> Number {
        // Whole numbers stay exact, so that 2.0 computed as a float still folds.
        if hi.fract() == 0.0 && hi.abs() < 9e15 && lo == 0.0 {
            Number::Ratio(hi as i64, 1)
        } else {
            Number::Float(hi.to_bits(), lo.to_bits())
        }
    }

    fn digits(self) -> Digits {
        match self {
            Number::Ratio(n, d) => Digits::whole(n.into()).over(Digits::whole(d.into())),
            Number::Float(hi, lo) => Digits { hi: f64::from_bits(hi), lo: f64::from_bits(lo) },
        }
    }

    fn reduced(n: i128, d: i128) -> Number {
        let g = gcd(n.unsigned_abs(), d.unsigned_abs()) as i128 * d.signum();
        match (i64::try_from(n / g), i64::try_from(d / g)) {
            (Ok(n), Ok(d)) => Number::Ratio(n, d),
            _ => Number::of(Digits::whole(n).over(Digits::whole(d))),
        }
    }

    /// Reads a decimal literal exactly: `0.1` is 1/10. `None` if it overflows even `f64`.
    pub fn parse(text: &str) -> Option<Number> {
        let text: String = text.chars().filter(|c| *c != '_').collect();
        let nearest: f64 = text.parse().ok().filter(|x: &f64| x.is_finite())?;
        Some(match Self::decimal(&text) {
            Some(float @ Number::Float(..)) => Number::of(Digits { hi: nearest, lo: float.beyond(nearest) }),
            Some(ratio) => ratio,
            None => Number::float(nearest),
        })
    }

    fn decimal(text: &str) -> Option<Number> {
        let (mantissa, exponent) = match text.split_once(['e', 'E']) {
            Some((m, e)) => (m, e.parse::<i32>().ok()?),
            None => (text, 0),
        };
        let (whole, fraction) = mantissa.split_once('.').unwrap_or((mantissa, ""));
        let fraction = fraction.trim_end_matches('0');
        let digits: i128 = format!("{whole}{fraction}").parse().ok()?;
        let exponent = exponent - i32::try_from(fraction.len()).ok()?;
        let power = 10i128.checked_pow(exponent.unsigned_abs())?;
        let (n, d) = if exponent < 0 { (digits, power) } else { (digits.checked_mul(power)?, 1) };
        Some(Self::reduced(n, d))
    }

    pub fn to_f64(self) -> f64 {
        match self {
            // Both exact below 2^53, hence correctly rounded; above, one rounding more.
            Number::Ratio(n, d) => n as f64 / d as f64,
            Number::Float(hi, _) => f64::from_bits(hi),
        }
    }

    /// Difference between the constant and its [`to_f64`](Self::to_f64).
    pub fn rest(self) -> f64 {
        self.beyond(self.to_f64())
    }

    fn beyond(self, x: f64) -> f64 {
        let Digits { hi, lo } = self.digits();
        let rest = (hi - x) + lo;
        if rest.is_finite() { rest } else { 0.0 }
    }

    pub fn is_zero(self) -> bool {
        matches!(self, Number::Ratio(0, _))
    }

    pub fn is_one(self) -> bool {
        self == Number::ONE
    }

    /// 1 or −1: the factors that cost nothing.
    pub fn is_unit(self) -> bool {
        matches!(self, Number::Ratio(1 | -1, 1))
    }

    pub fn is_negative(self) -> bool {
        match self {
            Number::Ratio(n, _) => n < 0,
            Number::Float(hi, _) => f64::from_bits(hi) < 0.0,
        }
    }

    pub fn abs(self) -> Number {
        if self.is_negative() { self.neg() } else { self }
    }

    pub fn neg(self) -> Number {
        match self {
            Number::Ratio(n, d) => {
                n.checked_neg().map_or(Number::reduced(-i128::from(n), d.into()), |n| Number::Ratio(n, d))
            }
            Number::Float(..) => {
                let Digits { hi, lo } = self.digits();
                Number::of(Digits { hi: -hi, lo: -lo })
            }
        }
    }

    pub fn add(self, other: Number) -> Number {
        match (self, other) {
            (Number::Ratio(a, 1), Number::Ratio(b, 1)) if a.checked_add(b).is_some() => {
                Number::Ratio(a + b, 1)
            }
            (Number::Ratio(a, b), Number::Ratio(c, d)) => {
                let (a, b, c, d) = (a as i128, b as i128, c as i128, d as i128);
                match a.checked_mul(d).zip(c.checked_mul(b)).and_then(|(x, y)| x.checked_add(y)) {
                    Some(n) => Number::reduced(n, b * d),
                    None => Number::of(self.digits().plus(other.digits())),
                }
            }
            _ => Number::of(self.digits().plus(other.digits())),
        }
    }

    pub fn mul(self, other: Number) -> Number {
        match (self, other) {
            (Number::Ratio(1, 1), x) | (x, Number::Ratio(1, 1)) => x,
            (Number::Ratio(a, b), Number::Ratio(c, d)) => {
                Number::reduced(a as i128 * c as i128, b as i128 * d as i128)
            }
            _ => Number::of(self.digits().times(other.digits())),
        }
    }

    /// A constant of `f64::consts`, with the digits that numbers of twice its precision have.
    pub fn named(name: &str) -> Option<Number> {
        let digits = match name {
            "PI" => "3.14159265358979323846264338327950288",
            "TAU" => "6.28318530717958647692528676655900577",
            "E" => "2.71828182845904523536028747135266250",
            "SQRT_2" => "1.41421356237309504880168872420969808",
            "LN_2" => "0.693147180559945309417232121458176568",
            "LN_10" => "2.30258509299404568401799145468436421",
            "FRAC_PI_2" => "1.57079632679489661923132169163975144",
            "FRAC_PI_3" => "1.04719755119659774615421446109316763",
            "FRAC_PI_4" => "0.785398163397448309615660845819875721",
            "FRAC_PI_6" => "0.523598775598298873077107230546583814",
            "FRAC_PI_8" => "0.392699081698724154807830422909937861",
            "FRAC_1_PI" => "0.318309886183790671537767526745028724",
            "FRAC_2_PI" => "0.636619772367581343075535053490057448",
            "FRAC_1_SQRT_2" => "0.707106781186547524400844362104849039",
            _ => return None,
        };
        Number::parse(digits)
    }

    /// n, where the number is n π/2 to all its digits: `PI`, and not `3.14159`.
    pub fn right_angles(self) -> Option<i64> {
        let (Number::Float(..), Some(right)) = (self, Number::named("FRAC_PI_2")) else { return None };
        let n = (self.to_f64() / right.to_f64()).round();
        let n = Some(n as i64).filter(|n| n.abs() < 1 << 20)?;
        let rest = self.add(right.mul(n.into()).neg());
        (rest.to_f64().abs() < 1e-29 * self.to_f64().abs()).then_some(n)
    }

    /// 1/x; x is not 0.
    pub fn recip(self) -> Number {
        match self {
            Number::Ratio(n, d) => Number::reduced(d as i128, n as i128),
            Number::Float(..) => Number::of(Digits::whole(1).over(self.digits())),
        }
    }

    /// The square root, where it is rational.
    pub fn sqrt(self) -> Option<Number> {
        let root = |n: i64| {
            let r = (n as f64).sqrt().round() as i64;
            (r.checked_mul(r) == Some(n)).then_some(r)
        };
        match self {
            Number::Ratio(n, d) if n >= 0 => Some(Number::Ratio(root(n)?, root(d)?)),
            _ => None,
        }
    }

    /// The value as a whole number.
    pub fn integer(self) -> Option<i64> {
        match self {
            Number::Ratio(n, 1) => Some(n),
            _ => None,
        }
    }

    pub fn compare(self, other: Number) -> Ordering {
        match (self, other) {
            (Number::Ratio(a, b), Number::Ratio(c, d)) => {
                (a as i128 * d as i128).cmp(&(c as i128 * b as i128))
            }
            _ => self.to_f64().total_cmp(&other.to_f64()).then(self.rest().total_cmp(&other.rest())),
        }
    }

    pub fn is_finite(self) -> bool {
        self.to_f64().is_finite()
    }
}

impl From<i64> for Number {
    fn from(n: i64) -> Number {
        Number::Ratio(n, 1)
    }
}

/// `hi + lo`, where `hi` is the nearest `f64` (Dekker, Numer. Math. 18 (1971) 224). Sums and products have errors of
/// some 1e-32.
#[derive(Clone, Copy)]
struct Digits {
    hi: f64,
    lo: f64,
}

impl Digits {
    fn whole(n: i128) -> Digits {
        let hi = n as f64;
        // What is nearest to n may be beyond all of them.
        Digits { hi, lo: n.saturating_sub(hi as i128) as f64 }
    }

    /// `a + b` exactly, where `|a| ≥ |b|`. What has overflowed has no rest.
    fn ordered(a: f64, b: f64) -> Digits {
        if !a.is_finite() {
            return Digits { hi: a, lo: 0.0 };
        }
        let hi = a + b;
        Digits { hi, lo: b - (hi - a) }
    }

    /// `a + b` exactly (Knuth).
    fn sum(a: f64, b: f64) -> Digits {
        let hi = a + b;
        let of_b = hi - a;
        Digits { hi, lo: (a - (hi - of_b)) + (b - of_b) }
    }

    fn plus(self, other: Digits) -> Digits {
        let (high, low) = (Digits::sum(self.hi, other.hi), Digits::sum(self.lo, other.lo));
        let sum = Digits::ordered(high.hi, high.lo + low.hi);
        Digits::ordered(sum.hi, sum.lo + low.lo)
    }

    fn times(self, other: Digits) -> Digits {
        let hi = self.hi * other.hi;
        let rounding = self.hi.mul_add(other.hi, -hi);
        Digits::ordered(hi, rounding + (self.hi * other.lo + self.lo * other.hi))
    }

    /// Division by hand: a quotient, that of what is left, and that of what is left then.
    fn over(self, other: Digits) -> Digits {
        let first = self.hi / other.hi;
        if !first.is_finite() || !other.hi.is_finite() {
            return Digits { hi: first, lo: 0.0 };
        }
        let left = |from: Digits, quotient: f64| from.plus(other.times(Digits { hi: -quotient, lo: 0.0 }));
        let rest = left(self, first);
        let second = rest.hi / other.hi;
        let third = left(rest, second).hi / other.hi;
        let sum = Digits::ordered(first, second);
        sum.plus(Digits { hi: third, lo: 0.0 })
    }
}

fn gcd(mut a: u128, mut b: u128) -> u128 {
    while b != 0 {
        (a, b) = (b, a % b);
    }
    a
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn right_angles_are_those_of_all_digits() {
        let pi = Number::named("PI").expect("a constant");
        let angles = [pi, pi.mul(3.into()).neg(), pi.mul(Number::Ratio(5, 2))].map(Number::right_angles);
        assert_eq!(angles, [Some(2), Some(-6), Some(5)]);
        let third = Number::named("FRAC_PI_3").expect("a constant");
        let others = [third, Number::float(std::f64::consts::PI), 3.into(), Number::ZERO];
        assert!(others.iter().all(|x| x.right_angles().is_none()));
    }

    #[test]
    fn literals_are_exact() {
        assert_eq!(Number::parse("0.1"), Some(Number::Ratio(1, 10)));
        assert_eq!(Number::parse("9.810"), Some(Number::Ratio(981, 100)));
        assert_eq!(Number::parse("1_000"), Some(Number::Ratio(1000, 1)));
        assert_eq!(Number::parse("2.5e-3"), Some(Number::Ratio(1, 400)));
        assert_eq!(Number::parse("6.02e23").map(Number::to_f64), Some(6.02e23));
        assert_eq!(Number::parse("1e400"), None);
    }

    #[test]
    fn arithmetic() {
        let (a, b) = (Number::Ratio(1, 6), Number::Ratio(1, 3));
        assert_eq!(a.add(b), Number::Ratio(1, 2));
        assert_eq!(a.mul(b), Number::Ratio(1, 18));
        assert_eq!(a.neg().recip(), Number::Ratio(-6, 1));
        assert_eq!(Number::Ratio(9, 4).sqrt(), Some(Number::Ratio(3, 2)));
        assert_eq!(Number::Ratio(2, 1).sqrt(), None);
    }

    #[test]
    fn digits_beyond_those_of_f64() {
        // 1/3 and 0.1 less the nearest f64, and so for π, e and numbers that outgrow machine words.
        assert_eq!(Number::Ratio(1, 3).rest(), 2.0f64.powi(-54) / 3.0);
        assert_eq!(Number::parse("0.1").map(Number::rest), Some(-(2.0f64.powi(-55)) * 0.2));
        assert_eq!(Number::Ratio(7, 64).rest(), 0.0);
        let pi = Number::parse("3.14159265358979323846264338327950288").unwrap();
        assert_eq!((pi.to_f64(), pi.rest()), (std::f64::consts::PI, 1.2246467991473532e-16));
        let third = pi.mul(Number::Ratio(1, 3));
        assert_eq!(third.to_f64(), std::f64::consts::FRAC_PI_3);
        assert!((third.mul(Number::from(3)).add(pi.neg())).to_f64().abs() < 1e-31);
        assert!((pi.recip().mul(pi).add(Number::MINUS_ONE)).to_f64().abs() < 1e-31);
        let small = Number::parse("0.123456789012345678").unwrap();
        let square = small.mul(small);
        assert!(matches!(square, Number::Float(..)));
        // 0.123456789012345678² = 0.015241578753238836527968299765279684
        let expected = Number::parse("0.015241578753238836527968299765279684").unwrap();
        assert!((square.add(expected.neg())).to_f64().abs() < 1e-33);
    }

    #[test]
    fn overflow_falls_over_to_floats() {
        let big = Number::Ratio(i64::MAX, 1);
        assert_eq!(big.mul(big).to_f64(), (i64::MAX as f64).powi(2));
        assert_eq!(Number::Ratio(i64::MIN, 1).neg().to_f64(), -(i64::MIN as f64));
        assert!(big.add(big).to_f64() > 1e19);
        let huge = Number::parse("1e308").unwrap().mul(Number::from(10));
        assert_eq!(
            (huge.to_f64(), huge.rest(), huge.add(huge).to_f64()),
            (f64::INFINITY, 0.0, f64::INFINITY)
        );
        assert!(huge.recip().is_zero());
    }
}
