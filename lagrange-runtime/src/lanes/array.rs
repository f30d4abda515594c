//! Sines and cosines of several `f64` at once.

use super::pack::Pack;
use super::policy::Native;
use super::processor::{Level, Work};
use super::registers;

/// Numbers in a pack.
const WIDTH: usize = 8;

/// Up to this many numbers the kernel is inlined, with the instructions of the build; of more it is called, with the
/// best that the processor has. A call waits for the way through one pack and for numbers to pass through memory.
const INLINED: usize = if cfg!(target_feature = "fma") { registers::MOST } else { 16 };

/// Sines and cosines of all `x`. Their bits are those of the policy [`Native`], whatever the processor is.
#[inline(always)]
pub(crate) fn sin_cos<const K: usize>(x: [f64; K]) -> ([f64; K], [f64; K]) {
    if K <= INLINED {
        return registers::sin_cos::<Native, K>(x, large);
    }
    let (mut sin, mut cos) = ([0.0; K], [0.0; K]);
    sin_cos_of_slice(&x, &mut sin, &mut cos);
    (sin, cos)
}

/// Sines and cosines with arguments beyond the kernel's limit.
#[cold]
#[inline(never)]
fn large<const K: usize>(x: [f64; K]) -> ([f64; K], [f64; K]) {
    let (sin, cos) = Pack(x).large_sin_cos::<Native>();
    (sin.0, cos.0)
}

/// Sines and cosines of at least [`WIDTH`] numbers. Never inlined: its callers are compiled without these instructions.
#[inline(never)]
fn sin_cos_of_slice(x: &[f64], sin: &mut [f64], cos: &mut [f64]) {
    Level::best().call(SinCos { x, sin, cos });
}

struct SinCos<'a> {
    x: &'a [f64],
    sin: &'a mut [f64],
    cos: &'a mut [f64],
}

impl Work for SinCos<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let SinCos { x, sin, cos } = self;
        let last = x.len().saturating_sub(WIDTH);
        for first in (0..x.len()).step_by(WIDTH) {
            // The last pack overlaps the one before it, where their number is no multiple of its width.
            let first = first.min(last);
            let (Some(x), Some(sin), Some(cos)) = (
                x[first..].first_chunk::<WIDTH>(),
                sin[first..].first_chunk_mut::<WIDTH>(),
                cos[first..].first_chunk_mut::<WIDTH>(),
            ) else {
                return;
            };
            let (s, c) = Pack(*x).sin_cos::<Native>();
            (*sin, *cos) = (s.0, c.0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_processor_gives_the_same_bits() {
        let mut x = -2e6;
        while x < 2e6 {
            let numbers: [f64; 19] = core::array::from_fn(|i| x + i as f64 * 0.7);
            let at = |level: Level| {
                let (mut sin, mut cos) = ([0.0; 19], [0.0; 19]);
                level.call(SinCos { x: &numbers, sin: &mut sin, cos: &mut cos });
                (sin, cos)
            };
            for level in Level::available() {
                assert_eq!(at(level), at(Level::Baseline), "{level:?} {x}");
            }
            x += 997.3;
        }
    }

    fn agrees<const K: usize>() {
        let x: [f64; K] = core::array::from_fn(|i| 1.3 * i as f64 - 4.0);
        let (sin, cos) = sin_cos(x);
        for i in 0..K {
            let (s, c) = crate::Scalar::sin_cos(x[i]);
            assert!((sin[i] - s).abs() <= f64::EPSILON * 0.5, "{K} {i}");
            assert!((cos[i] - c).abs() <= f64::EPSILON * 0.5, "{K} {i}");
        }
    }

    #[test]
    fn any_number_of_numbers() {
        agrees::<0>();
        agrees::<1>();
        agrees::<2>();
        agrees::<3>();
        agrees::<7>();
        agrees::<8>();
        agrees::<9>();
        agrees::<16>();
        agrees::<29>();
    }

    #[test]
    fn what_is_not_in_range_does_not_harm_its_neighbours() {
        let bad = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300, 1e7, -3e9, f64::MAX];
        for bad in bad {
            for place in 0..8 {
                let mut x = [0.0, -0.0, 1e-310, -1e-5, 0.5, 1e5, 3.0, -9.0];
                let clean = sin_cos(x);
                x[place] = bad;
                let (sin, cos) = sin_cos(x);
                for i in 0..8 {
                    if i == place {
                        assert_eq!((sin[i].is_nan(), cos[i].is_nan()), (!bad.is_finite(), !bad.is_finite()));
                        assert!(!bad.is_finite() || (sin[i].hypot(cos[i]) - 1.0).abs() < 1e-15);
                    } else {
                        assert_eq!(
                            (sin[i].to_bits(), cos[i].to_bits()),
                            (clean.0[i].to_bits(), clean.1[i].to_bits())
                        );
                    }
                }
            }
        }
        assert!(sin_cos([-0.0; 8]).0.iter().all(|s| *s == 0.0 && s.is_sign_negative()));
        assert!(sin_cos([1e-310; 8]).0.iter().all(|s| *s == 1e-310));
    }
}
