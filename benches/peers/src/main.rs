//! Our adaptive methods against those of other crates, at equal achieved error:
//! `cargo run --release --manifest-path benches/peers/Cargo.toml`.
//!
//! All contestants are given the same emitted accelerations, so that only the integrators differ, and their cheapest
//! output: the last state. Each runs over a ladder of tolerances. Its error at a tolerance is the largest one at several
//! ends of the run; its time and its evaluations at a given error are interpolated between neighbouring tolerances,
//! logarithm over logarithm. In every round all contestants are timed in turn, and the medians over the rounds of the
//! ratios of times are printed, so that a machine that slows down slows everyone.

mod contestants;
mod curve;
mod problems;

use contestants::{Contestant, contestants};
use curve::Curve;
use lagrange_runtime::testing::distance;
use lagrange_runtime::{SVector, State, System};
use problems::{DoublePendulum, Kepler, Pendulum};
use std::cell::Cell;
use std::hint::black_box;
use std::time::Instant;

/// Rounds of timing.
const ROUNDS: usize = 25;
/// A timed run is repeated until it takes this many seconds.
const LEAST: f64 = 2e-4;
/// The errors at which contestants are compared.
const ERRORS: [f64; 7] = [1e-3, 1e-4, 1e-6, 1e-8, 1e-10, 1e-11, 1e-12];
/// At how many ends errors are measured.
const ENDS: u32 = 16;

/// A system that counts its evaluations.
struct Counted<'a, Sys>(&'a Sys, Cell<u64>);

impl<Sys: System<N, Scalar = f64>, const N: usize> System<N> for Counted<'_, Sys> {
    type Scalar = f64;
    fn accel(&self, q: &SVector<f64, N>, qd: &SVector<f64, N>, t: f64) -> SVector<f64, N> {
        self.1.set(self.1.get() + 1);
        self.0.accel(q, qd, t)
    }
}

fn tolerances() -> impl Iterator<Item = f64> {
    (4..=29).map(|k| 10f64.powf(-0.5 * f64::from(k)))
}

/// Seconds of one call.
fn seconds(repeat: u32, call: impl Fn()) -> f64 {
    let start = Instant::now();
    for _ in 0..repeat {
        call();
    }
    start.elapsed().as_secs_f64() / f64::from(repeat)
}

/// A contestant at one tolerance.
struct Point {
    tolerance: f64,
    error: f64,
    evaluations: f64,
    /// How often it is to be run when timed.
    repeat: u32,
}

/// Lower quartile, median and upper quartile.
fn quartiles(mut values: Vec<f64>) -> [f64; 3] {
    values.sort_by(f64::total_cmp);
    [0.25, 0.5, 0.75].map(|share| values[(share * (values.len() - 1) as f64).round() as usize])
}

/// The tables of one system, whose true state at any time is `exact`. `D` is 2N.
fn compare<Sys, const N: usize, const D: usize>(
    name: &str,
    system: &Sys,
    exact: impl Fn(f64) -> State<f64, N>,
    end: f64,
) where
    Sys: System<N, Scalar = f64>,
{
    let start = exact(0.0);
    let exact: Vec<_> = (1..=ENDS).map(|k| exact(end * f64::from(k) / f64::from(ENDS))).collect();
    let timed = contestants::<Sys, N, D>();
    let counting = contestants::<Counted<'_, Sys>, N, D>();

    let point = |i: usize, tolerance: f64| {
        let solve: &Contestant<Sys, N> = &timed[i];
        let error = exact
            .iter()
            .map(|exact| distance(&(solve.run)(system, start, exact.t, tolerance), exact))
            .fold(0.0, f64::max);
        let counted = Counted(system, Cell::new(0));
        (counting[i].run)(&counted, start, end, tolerance);
        let once = seconds(3, || drop(black_box((solve.run)(system, start, end, tolerance))));
        let repeat = (LEAST / once).ceil().max(1.0) as u32;
        Point { tolerance, error, evaluations: counted.1.get() as f64, repeat }
    };
    let points: Vec<Vec<Point>> =
        (0..timed.len()).map(|i| tolerances().map(|tolerance| point(i, tolerance)).collect()).collect();

    // times[contestant][round] is a curve of times over errors.
    let mut times: Vec<Vec<Curve>> = timed.iter().map(|_| Vec::new()).collect();
    for round in 0..ROUNDS {
        let mut seconds_of: Vec<Vec<f64>> = timed.iter().map(|_| Vec::new()).collect();
        for rung in 0..tolerances().count() {
            for i in 0..timed.len() {
                // Who goes first changes.
                let i = (i + round) % timed.len();
                let Point { tolerance, repeat, .. } = points[i][rung];
                let run = || drop(black_box((timed[i].run)(black_box(system), start, end, tolerance)));
                seconds_of[i].push(seconds(repeat, run));
            }
        }
        for (i, seconds) in seconds_of.iter().enumerate() {
            times[i].push(Curve::new(points[i].iter().map(|p| p.error).zip(seconds.iter().copied())));
        }
    }
    let evaluations: Vec<Curve> =
        points.iter().map(|points| Curve::new(points.iter().map(|p| (p.error, p.evaluations)))).collect();

    println!("\n## {name}\n");
    println!("| error | ours | evaluations | ns each | best peer | its time / ours | quartiles | its evaluations / ours |");
    println!("|---|---|---|---|---|---|---|---|");
    for error in ERRORS {
        for (ours, us) in timed.iter().enumerate().filter(|(_, c)| c.peer_of.is_none()) {
            let Some(own) = evaluations[ours].at(error) else { continue };
            let ratio = |theirs: usize| {
                let rounds = times[theirs].iter().zip(&times[ours]);
                rounds.map(|(t, o)| Some(t.at(error)? / o.at(error)?)).collect::<Option<Vec<f64>>>().map(quartiles)
            };
            let rivals = (0..timed.len()).filter(|&i| timed[i].peer_of == Some(us.name));
            let best = rivals.filter_map(|i| Some((i, ratio(i)?))).min_by(|a, b| a.1[1].total_cmp(&b.1[1]));
            let Some((i, [low, median, high])) = best else { continue };
            let each = quartiles(times[ours].iter().filter_map(|t| t.at(error)).collect())[1] / own * 1e9;
            let more = evaluations[i].at(error).map_or(f64::NAN, |theirs| theirs / own);
            println!(
                "| {error:.0e} | {} | {own:.0} | {each:.1} | {} | {median:.2} | {low:.2} – {high:.2} | {more:.2} |",
                us.name, timed[i].name
            );
        }
    }
}

fn main() {
    let (pendulum, exact) = problems::pendulum();
    compare::<Pendulum, 1, 2>("Pendulum, amplitude 2 rad, t = 20", &pendulum, exact, 20.0);
    let (kepler, exact) = problems::kepler();
    compare::<Kepler, 2, 4>("Kepler, eccentricity 0.6, t = 30", &kepler, exact, 30.0);
    let (double, exact) = problems::double_pendulum();
    compare::<DoublePendulum, 2, 4>("Double pendulum, t = 5", &double, exact, 5.0);
}
