//! Our adaptive methods against those of other crates, at equal achieved error:
//! `cargo run --release --manifest-path benches/peers/Cargo.toml`. With `-- --points` the raw points, for `compare.py`.
//!
//! All contestants are given the same emitted accelerations, so that only the integrators differ, and their cheapest
//! output: the last state. Each runs over a ladder of tolerances. Its error at a tolerance is the largest one at
//! several ends of the run; its time and its evaluations at a given error are interpolated between neighbouring
//! tolerances, logarithm over logarithm. In every round all contestants are timed in turn, and the medians over the
//! rounds of the ratios of times are printed, so that a machine that slows down slows everyone.

mod contestants;
mod curve;
#[allow(dead_code, reason = "what series need")]
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

/// Lower quartile, median and upper quartile.
fn quartiles(mut values: Vec<f64>) -> [f64; 3] {
    values.sort_by(f64::total_cmp);
    [0.25, 0.5, 0.75].map(|share| values[(share * (values.len() - 1) as f64).round() as usize])
}

/// The largest error; a failure that shows as NaN is one without bounds.
fn largest(errors: impl Iterator<Item = f64>) -> f64 {
    errors.fold(0.0, |most, error| if error.is_nan() { f64::INFINITY } else { most.max(error) })
}

/// A contestant at one tolerance.
struct Point {
    tolerance: f64,
    error: f64,
    evaluations: f64,
    /// Seconds of a run, one entry a round.
    seconds: Vec<f64>,
}

/// Runs all contestants over all tolerances, and times them. `D` is 2N.
fn measure<Sys, const N: usize, const D: usize>(
    system: &Sys,
    start: State<f64, N>,
    exact: &[State<f64, N>],
) -> Vec<Vec<Point>>
where
    Sys: System<N, Scalar = f64>,
{
    let end = exact.last().expect("an end").t;
    let timed = contestants::<Sys, N, D>();
    let seconds = |run: contestants::Run<Sys, N>, tolerance: f64, repeat: u32| {
        let clock = Instant::now();
        for _ in 0..repeat {
            black_box(run(black_box(system), start, end, tolerance));
        }
        clock.elapsed().as_secs_f64() / f64::from(repeat)
    };

    let mut repeats = Vec::new();
    let mut points = Vec::new();
    for (Contestant { run, .. }, counting) in timed.iter().zip(contestants::<Counted<'_, Sys>, N, D>()) {
        let point = |tolerance| {
            let errors = exact.iter().map(|exact| distance(&run(system, start, exact.t, tolerance), exact));
            let counted = Counted(system, Cell::new(0));
            (counting.run)(&counted, start, end, tolerance);
            let evaluations = counted.1.get() as f64;
            Point { tolerance, error: largest(errors), evaluations, seconds: Vec::new() }
        };
        points.push(tolerances().map(point).collect::<Vec<_>>());
        let repeat = |tolerance| (LEAST / seconds(*run, tolerance, 3)).ceil().max(1.0) as u32;
        repeats.push(tolerances().map(repeat).collect::<Vec<_>>());
    }
    for round in 0..ROUNDS {
        for rung in 0..tolerances().count() {
            for i in 0..timed.len() {
                // Who goes first changes.
                let i = (i + round) % timed.len();
                let point = &mut points[i][rung];
                point.seconds.push(seconds(timed[i].run, point.tolerance, repeats[i][rung]));
            }
        }
    }
    points
}

/// Ours against the best peer, at each error.
fn table<Sys, const N: usize>(contestants: &[Contestant<Sys, N>], points: &[Vec<Point>]) {
    let curve =
        |i: usize, cost: &dyn Fn(&Point) -> f64| Curve::new(points[i].iter().map(|p| (p.error, cost(p))));
    let evaluations = |i: usize, error: f64| curve(i, &|p| p.evaluations).at(error);
    let times = |i: usize, error: f64| {
        (0..ROUNDS).map(|round| curve(i, &|p| p.seconds[round]).at(error)).collect::<Option<Vec<_>>>()
    };
    println!(
        "| error | ours | evaluations | ns each | best peer | its time / ours | quartiles | its evaluations / ours |"
    );
    println!("|---|---|---|---|---|---|---|---|");
    for error in ERRORS {
        for (i, us) in contestants.iter().enumerate().filter(|(_, c)| c.ours) {
            let (Some(own), Some(needed)) = (times(i, error), evaluations(i, error)) else { continue };
            let rival = |&j: &usize| !contestants[j].ours && contestants[j].class == us.class;
            let ratios = (0..contestants.len()).filter(rival).filter_map(|j| {
                let ratios = times(j, error)?.iter().zip(&own).map(|(theirs, ours)| theirs / ours).collect();
                Some((contestants[j].name, quartiles(ratios), evaluations(j, error)? / needed))
            });
            let best = ratios.min_by(|a, b| a.1[1].total_cmp(&b.1[1]));
            let Some((peer, [low, median, high], more)) = best else { continue };
            let each = quartiles(own)[1] / needed * 1e9;
            println!(
                "| {error:.0e} | {} | {needed:.0} | {each:.1} | {peer} | {median:.2} | {low:.2} – {high:.2} | {more:.2} |",
                us.name
            );
        }
    }
}

/// One system, whose true state at any time is `exact`.
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
    let contestants = contestants::<Sys, N, D>();
    let points = measure::<Sys, N, D>(system, start, &exact);
    if std::env::args().any(|argument| argument == "--points") {
        for State { t, q, qd } in std::iter::once(&start).chain(&exact) {
            let y: Vec<_> = q.iter().chain(qd).map(|x| format!("{x:e}")).collect();
            println!("{name}\tstate\t{t:e}\t{}", y.join("\t"));
        }
        for (contestant, points) in contestants.iter().zip(points) {
            for Point { tolerance, error, evaluations, seconds } in points {
                let [_, median, _] = quartiles(seconds);
                let name = [name, "point", contestant.name].join("\t");
                println!("{name}\t{tolerance:e}\t{error:e}\t{evaluations}\t{median:e}");
            }
        }
    } else {
        println!("\n## {name}, t = {end}\n");
        table(&contestants, &points);
    }
}

fn main() {
    let (pendulum, exact) = problems::pendulum();
    compare::<Pendulum, 1, 2>("Pendulum", &pendulum, exact, 20.0);
    let (kepler, exact) = problems::kepler();
    compare::<Kepler, 2, 4>("Kepler", &kepler, exact, 30.0);
    let (double, exact) = problems::double_pendulum();
    compare::<DoublePendulum, 2, 4>("Double pendulum", &double, exact, 5.0);
}
