//! Constants with more digits than an `f64` has, as they are written.

use super::{Double, quick_two_sum};

/// A decimal number, a quotient of two, or a difference or sum of such, with all its digits: `exact!(0.1)`,
/// `exact!(-56.0 / 15.0)`, `exact!(0.5 - 3.0 / 136.0)`. Its `hi` is what the same tokens are as an `f64`, or another
/// `f64` near to it that is written before it: `exact!(1.0 / THIRD => 3.0)`.
macro_rules! exact {
    ($number:expr) => {
        $crate::scalar::double_double::digits::exact!($number => $number)
    };
    // An item and no block of constants, which would be evaluated for every scalar.
    ($nearest:expr => $number:expr) => {{
        const EXACT: $crate::scalar::DoubleDouble =
            $crate::scalar::double_double::digits::of($nearest, stringify!($number));
        EXACT
    }};
}

/// [`exact!`] of each number.
macro_rules! exact_row {
    ($($number:expr $(=> $digits:expr)?),* $(,)?) => {
        [$($crate::scalar::double_double::digits::exact!($number $(=> $digits)?)),*]
    };
}

pub(crate) use {exact, exact_row};

/// The number that `text` says, to 32 digits, as an `f64` and what that lacks. Evaluated by the compiler, which a
/// text that says another number stops.
pub(crate) const fn of(nearest: f64, text: &str) -> Double {
    let text = text.as_bytes();
    let (mut at, mut sum) = (0, Double::ZERO);
    while at < text.len() {
        let (term, end) = quotient(text, at);
        (sum, at) = (sum.plus(term), end);
    }
    let lo = (sum.hi - nearest) + sum.lo;
    assert!(lo.abs() <= 1e-12 * nearest.abs(), "not the number that is written");
    Double { hi: nearest, lo }
}

/// The term that begins at a place of the text, with its sign, and where the next one begins.
const fn quotient(text: &[u8], begin: usize) -> (Double, usize) {
    let (mut at, mut part) = (begin, 0);
    // Of numerator and denominator: all digits, and how many of them are decimals.
    let (mut digits, mut decimals) = ([0u128, 1], [0u32; 2]);
    let (mut negative, mut fraction, mut begun) = (false, false, false);
    while at < text.len() && !(begun && matches!(text[at], b'+' | b'-')) {
        match text[at] {
            b'-' => negative = true,
            b'.' => fraction = true,
            b'/' => (part, fraction, digits[1]) = (part + 1, false, 0),
            digit @ b'0'..=b'9' => {
                digits[part] = 10 * digits[part] + (digit - b'0') as u128;
                decimals[part] += fraction as u32;
                begun = true;
            }
            b'+' | b' ' => (),
            _ => panic!("no decimal number, quotient, sum or difference"),
        }
        at += 1;
    }
    let numerator = integer(digits[0]).times(integer(10u128.pow(decimals[1])));
    let denominator = integer(digits[1]).times(integer(10u128.pow(decimals[0])));
    let size = numerator.over(denominator);
    (if negative { size.negative() } else { size }, at)
}

/// 106 bits of an integer.
const fn integer(x: u128) -> Double {
    let hi = x as f64;
    let nearest = hi as u128;
    let lo = if nearest > x { -((nearest - x) as f64) } else { (x - nearest) as f64 };
    quick_two_sum(hi, lo)
}
