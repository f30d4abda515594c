//! Exact constants: rationals in machine words, falling over to `f64` when a numerator or denominator outgrows them.

use std::cmp::Ordering;

/// A rational number in lowest terms with a positive denominator, or a finite float where that did not fit.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Number {
    Ratio(i64, i64),
    /// The bits of a finite `f64`; bits, so that equal constants are equal nodes.
    Float(u64),
}

impl Number {
    pub const ZERO: Number = Number::Ratio(0, 1);
    pub const ONE: Number = Number::Ratio(1, 1);
    pub const MINUS_ONE: Number = Number::Ratio(-1, 1);

    pub fn float(x: f64) -> Number {
        // Whole numbers stay exact, so that 2.0 computed as a float still folds.
        if x.fract() == 0.0 && x.abs() < 9e15 {
            Number::Ratio(x as i64, 1)
        } else {
            Number::Float(x.to_bits())
        }
    }

    fn reduced(n: i128, d: i128) -> Number {
        let g = gcd(n.unsigned_abs(), d.unsigned_abs()) as i128 * d.signum();
        match (i64::try_from(n / g), i64::try_from(d / g)) {
            (Ok(n), Ok(d)) => Number::Ratio(n, d),
            _ => Number::float(n as f64 / d as f64),
        }
    }

    /// Reads a decimal literal exactly: `0.1` is 1/10. `None` if it overflows even `f64`.
    pub fn parse(text: &str) -> Option<Number> {
        let text: String = text.chars().filter(|c| *c != '_').collect();
        let nearest: f64 = text.parse().ok().filter(|x: &f64| x.is_finite())?;
        Some(Self::decimal(&text).unwrap_or(Number::float(nearest)))
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
        match Self::reduced(n, d) {
            ratio @ Number::Ratio(..) => Some(ratio),
            Number::Float(_) => None,
        }
    }

    pub fn to_f64(self) -> f64 {
        match self {
            // Both exact below 2^53, hence correctly rounded; above, one rounding more.
            Number::Ratio(n, d) => n as f64 / d as f64,
            Number::Float(bits) => f64::from_bits(bits),
        }
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
            Number::Float(bits) => f64::from_bits(bits) < 0.0,
        }
    }

    pub fn abs(self) -> Number {
        if self.is_negative() { self.neg() } else { self }
    }

    pub fn neg(self) -> Number {
        match self {
            Number::Ratio(n, d) => {
                n.checked_neg().map_or(Number::float(-(n as f64) / d as f64), |n| Number::Ratio(n, d))
            }
            Number::Float(bits) => Number::Float((-f64::from_bits(bits)).to_bits()),
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
                    None => Number::float(self.to_f64() + other.to_f64()),
                }
            }
            _ => Number::float(self.to_f64() + other.to_f64()),
        }
    }

    pub fn mul(self, other: Number) -> Number {
        match (self, other) {
            (Number::Ratio(1, 1), x) | (x, Number::Ratio(1, 1)) => x,
            (Number::Ratio(a, b), Number::Ratio(c, d)) => {
                Number::reduced(a as i128 * c as i128, b as i128 * d as i128)
            }
            _ => Number::float(self.to_f64() * other.to_f64()),
        }
    }

    /// 1/x; x is not 0.
    pub fn recip(self) -> Number {
        match self {
            Number::Ratio(n, d) => Number::reduced(d as i128, n as i128),
            Number::Float(bits) => Number::float(1.0 / f64::from_bits(bits)),
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
            _ => self.to_f64().total_cmp(&other.to_f64()),
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
    fn overflow_falls_over_to_floats() {
        let big = Number::Ratio(i64::MAX, 1);
        assert_eq!(big.mul(big).to_f64(), (i64::MAX as f64).powi(2));
        assert_eq!(Number::Ratio(i64::MIN, 1).neg().to_f64(), -(i64::MIN as f64));
        assert!(big.add(big).to_f64() > 1e19);
    }
}
