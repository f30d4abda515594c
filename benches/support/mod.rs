//! Ratios of running times, taken in one run: two functions alternate, and the median of the ratios of their times is
//! what counts. A machine that slows down slows both.

#![allow(dead_code, reason = "a benchmark needs a part of it")]

pub mod systems;

use lagrange_runtime::testing::work_precision::Decade;
use std::hint::black_box;
use std::time::Instant;

/// Rounds of alternation.
const ROUNDS: usize = 41;

/// Seconds that `repeat` calls take.
fn seconds(repeat: usize, call: &mut dyn FnMut()) -> f64 {
    let start = Instant::now();
    for _ in 0..repeat {
        call();
    }
    start.elapsed().as_secs_f64()
}

/// Median of time(ours) / time(theirs), with its quartiles, and the nanoseconds of one inner call of each.
pub struct Ratio {
    pub median: f64,
    pub quartiles: [f64; 2],
    pub nanoseconds: [f64; 2],
}

/// Compares two functions that each make `calls` inner calls.
pub fn ratio(calls: usize, mut ours: impl FnMut(), mut theirs: impl FnMut()) -> Ratio {
    let mut repeat = 1;
    while seconds(repeat, &mut theirs) < 2e-3 {
        repeat *= 2;
    }
    let mut ratios = Vec::new();
    let mut best = [f64::INFINITY; 2];
    for round in 0..ROUNDS {
        // Who goes first alternates too.
        let (a, b) = if round % 2 == 0 {
            let a = seconds(repeat, &mut ours);
            (a, seconds(repeat, &mut theirs))
        } else {
            let b = seconds(repeat, &mut theirs);
            (seconds(repeat, &mut ours), b)
        };
        ratios.push(a / b);
        best = [best[0].min(a), best[1].min(b)];
    }
    ratios.sort_by(f64::total_cmp);
    let at = |share: f64| ratios[(share * (ROUNDS - 1) as f64).round() as usize];
    let per_call = 1e9 / (repeat * calls) as f64;
    Ratio { median: at(0.5), quartiles: [at(0.25), at(0.75)], nanoseconds: best.map(|t| t * per_call) }
}

/// Seconds of a run that is repeated until it takes a millisecond, the shortest of 15 rounds.
pub fn shortest(mut run: impl FnMut()) -> f64 {
    let repeat = (1e-3 / (seconds(2, &mut run) / 2.0)).ceil().max(1.0) as usize;
    (0..15).map(|_| seconds(repeat, &mut run)).fold(f64::INFINITY, f64::min) / repeat as f64
}

/// Cells of a table, one for each of these accuracies: a method's time to it as a ratio to that of another one, which
/// it may reach alone.
pub fn times_to(table: &[Decade], digits: &[u32], method: &str, other: &str) -> String {
    let cells: Vec<String> = digits
        .iter()
        .map(|digits| {
            let decade = table.iter().find(|decade| decade.digits == *digits);
            let of = |name: &str| Some(decade?.ranking.iter().find(|s| s.method == name)?.seconds);
            match (of(method), of(other)) {
                (Some(own), Some(other)) => format!("{:.2}", own / other),
                (Some(own), None) => format!("{:.1} µs", 1e6 * own),
                _ => "–".into(),
            }
        })
        .collect();
    cells.join(" | ")
}

/// Reproducible numbers in [-1, 1).
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> f64 {
        // SplitMix64 (Steele, Lea and Flood 2014).
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

/// Keeps a result from being optimised away.
pub fn consume<T>(x: T) {
    black_box(x);
}
