//! Random states that are the same in every run.

use super::State;
use std::ops::Range;

/// Sixty-four states with coordinates in the given ranges, velocities in ±2 and times in 0…5.
pub fn random_states(q: &[Range<f64>]) -> Vec<State> {
    let mut seed = 0;
    (0..64)
        .map(|_| State {
            q: q.iter().map(|range| uniform(&mut seed, range)).collect(),
            qd: q.iter().map(|_| uniform(&mut seed, &(-2.0..2.0))).collect(),
            t: uniform(&mut seed, &(0.0..5.0)),
        })
        .collect()
}

/// SplitMix64 (Steele, Lea and Flood 2014), upper 53 bits.
fn uniform(seed: &mut u64, range: &Range<f64>) -> f64 {
    *seed = seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *seed;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    let unit = ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64;
    range.start + (range.end - range.start) * unit
}
