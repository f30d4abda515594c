//! Sobol points with Owen's scrambling.

use directions::{ROWS, Row};

mod directions;

/// The dimensions that there are.
pub const DIMENSIONS: usize = ROWS.len() + 1;

/// Bits of a coordinate: those of the mantissa of an `f64`, one left for the middle of an interval.
const BITS: u32 = 52;

/// Direction numbers of one dimension, as binary fractions of `BITS` bits.
type Directions = [u64; BITS as usize];

/// Points of a Sobol sequence in `[0, 1)^D`, each from its index alone.
#[derive(Clone, Debug)]
pub struct Points<const D: usize> {
    directions: Vec<Directions>,
    seed: u64,
    /// Number of dimensions of the sequence before those of the points.
    before: usize,
}

impl<const D: usize> Points<D> {
    /// A sequence in 1 to [`DIMENSIONS`] dimensions.
    pub fn new(seed: u64) -> Self {
        const { assert!(D > 0 && D <= DIMENSIONS, "a Sobol sequence has 1 to 64 dimensions") }
        Points { directions: (0..D).map(directions).collect(), seed, before: 0 }
    }

    /// Two halves of the points of a sequence in 2 D dimensions.
    pub fn halves(seed: u64) -> [Self; 2] {
        const { assert!(D > 0 && 2 * D <= DIMENSIONS, "Sobol' indices are of 1 to 32 inputs") }
        [0, D].map(|before| Points {
            directions: (before..before + D).map(directions).collect(),
            seed,
            before,
        })
    }

    /// The point of this index, below 2⁵². Each coordinate is the middle of one of 2⁵² intervals: it is neither 0 nor
    /// 1, where quantile functions are infinite.
    pub fn point(&self, index: u64) -> [f64; D] {
        let mut point = [0.5; D];
        for (dimension, (x, directions)) in point.iter_mut().zip(&self.directions).enumerate() {
            let plain = bits_of(index).fold(0, |sum, bit| sum ^ directions[bit]);
            let scrambled = owen(plain, mix(self.seed ^ mix((self.before + dimension) as u64 + 1)));
            *x = (scrambled as f64 + 0.5) / (1u64 << BITS) as f64;
        }
        point
    }
}

/// The places of the ones of an index.
fn bits_of(index: u64) -> impl Iterator<Item = usize> {
    let mut rest = index % (1 << BITS);
    core::iter::from_fn(move || {
        let lowest = rest.trailing_zeros() as usize;
        rest &= rest.checked_sub(1)?;
        Some(lowest)
    })
}

/// The recurrence of Bratley and Fox (1988, ACM TOMS 14:88) from the initial numbers of a row.
fn directions(dimension: usize) -> Directions {
    let fraction = |m: u64, k: usize| m << (BITS as usize - 1 - k);
    let Some(&Row { a, m }) = dimension.checked_sub(1).and_then(|row| ROWS.get(row)) else {
        return core::array::from_fn(|k| fraction(1, k));
    };
    let degree = m.len();
    let mut v = [0; BITS as usize];
    for k in 0..BITS as usize {
        v[k] = match m.get(k) {
            Some(&m) => fraction(m, k),
            None => {
                let middle =
                    (1..degree).filter(|i| a >> (degree - 1 - i) & 1 == 1).fold(0, |sum, i| sum ^ v[k - i]);
                v[k - degree] ^ v[k - degree] >> degree ^ middle
            }
        };
    }
    v
}

/// Owen's nested uniform scrambling (1995): each binary digit is flipped or not by a coin of its own for each value
/// of the digits before it. The coin is a hash of these digits, so that nothing has to be stored.
fn owen(x: u64, key: u64) -> u64 {
    (0..BITS).fold(x, |scrambled, place| {
        let shift = BITS - 1 - place;
        // The digits before this one with a one in front of them, which tells their number.
        let prefix = x >> (shift + 1) | 1 << place;
        scrambled ^ (mix(key ^ prefix.wrapping_mul(0x9e37_79b9_7f4a_7c15)) >> 63) << shift
    })
}

/// The finalizer of SplitMix64 (Steele, Lea and Flood 2014), a bijection in which each bit depends on all.
fn mix(mut z: u64) -> u64 {
    z = z.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ z >> 31
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The unscrambled sequence, as published: Joe and Kuo's first ten points in three dimensions, in the order of the
    /// index and not of its Gray code.
    #[test]
    fn the_plain_sequence_is_that_of_joe_and_kuo() {
        let plain = |index: u64, dimension: usize| {
            let directions = directions(dimension);
            bits_of(index).fold(0, |sum, bit| sum ^ directions[bit]) as f64 / (1u64 << BITS) as f64
        };
        // The sixth point in the order of Gray's code is that of index 5 ^ 2 = 7.
        let gray = |n: u64| [0, 1, 2].map(|dimension| plain(n ^ n >> 1, dimension));
        assert_eq!(gray(0), [0.0, 0.0, 0.0]);
        assert_eq!(gray(1), [0.5, 0.5, 0.5]);
        assert_eq!(gray(2), [0.75, 0.25, 0.25]);
        assert_eq!(gray(3), [0.25, 0.75, 0.75]);
        assert_eq!(gray(4), [0.375, 0.375, 0.625]);
        assert_eq!(gray(5), [0.875, 0.875, 0.125]);
        assert_eq!(gray(6), [0.625, 0.125, 0.875]);
        assert_eq!(gray(7), [0.125, 0.625, 0.375]);
        assert_eq!(gray(8), [0.1875, 0.3125, 0.9375]);
        assert_eq!(gray(9), [0.6875, 0.8125, 0.4375]);
    }

    /// Each of 2ᵏ intervals has one of 2ᵏ points, in every dimension; and in the first two dimensions, a (0,
    /// 2)-sequence, each of 2ᵏ boxes of every shape. Scrambling keeps both.
    #[test]
    fn scrambled_points_are_stratified() {
        let points = Points::<DIMENSIONS>::new(42);
        let drawn: Vec<_> = (0..1024).map(|index| points.point(index)).collect();
        for dimension in 0..DIMENSIONS {
            let mut hit = [0; 1024];
            drawn.iter().for_each(|point| hit[(point[dimension] * 1024.0) as usize] += 1);
            assert!(hit.iter().all(|&n| n == 1), "dimension {dimension}");
        }
        for wide in 0..=10 {
            let mut hit = [0; 1024];
            for point in &drawn {
                let column = (point[0] * f64::from(1 << wide)) as usize;
                let row = (point[1] * f64::from(1 << (10 - wide))) as usize;
                hit[(column << (10 - wide)) + row] += 1;
            }
            assert!(hit.iter().all(|&n| n == 1), "{wide}");
        }
    }

    /// Over seeds a coordinate is uniform, and two coordinates of one point are not correlated.
    #[test]
    fn scrambling_is_uniform_over_seeds() {
        let n = 20_000;
        let drawn: Vec<_> = (0..n).map(|seed| Points::<2>::new(seed).point(0)).collect();
        let mean = |f: &dyn Fn(&[f64; 2]) -> f64| drawn.iter().map(f).sum::<f64>() / n as f64;
        // Five standard deviations of the mean of n uniform numbers, of their squares, of products of two of them.
        let five = 5.0 / (n as f64).sqrt();
        for k in 0..2 {
            assert!((mean(&|x| x[k]) - 0.5).abs() < five / 12f64.sqrt());
            assert!((mean(&|x| x[k] * x[k]) - 1.0 / 3.0).abs() < five * (4.0f64 / 45.0).sqrt());
        }
        assert!((mean(&|x| (x[0] - 0.5) * (x[1] - 0.5))).abs() < five / 12.0);
    }

    /// The mean of a smooth function: an error far below that of as many random points (its standard deviation is
    /// 0.07 here; scrambled nets fall as n^(-3/2)).
    #[test]
    fn integrals_of_smooth_functions_are_far_better_than_by_random_points() {
        let f = |x: &[f64; 4]| x.iter().map(|x| (x - 0.5).sin() + x * x).product::<f64>();
        let exact = (1.0f64 / 3.0).powi(4);
        let points = Points::<4>::new(3);
        let n = 4096;
        let values: Vec<f64> = (0..n).map(|index| f(&points.point(index))).collect();
        let mean = values.iter().sum::<f64>() / n as f64;
        let deviation = (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n as f64).sqrt();
        assert!((mean - exact).abs() < 0.02 * deviation / (n as f64).sqrt() * 5.0);
    }
}
