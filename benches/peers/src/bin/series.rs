//! Points of work and precision of [`Taylor`], for `compare.py --series`, which sets them against heyoka's:
//! system, tolerance, error, seconds, steps, of them rejected. The error is the largest one at several ends of the run.

use lagrange_runtime::prelude::*;
use lagrange_runtime::testing::distance;
use std::hint::black_box;
use std::time::Instant;

#[path = "../problems.rs"]
mod problems;

/// Rounds of timing, of which the shortest counts.
const ROUNDS: usize = 15;
/// A timed run is repeated until it takes this many seconds.
const LEAST: f64 = 2e-4;
/// At how many ends errors are measured.
const ENDS: u32 = 16;

fn points<Sys: Analytic<N, Scalar = f64>, const N: usize>(
    name: &str,
    system: &Sys,
    exact: impl Fn(f64) -> State<f64, N>,
    end: f64,
) {
    let start = exact(0.0);
    let exact: Vec<_> = (1..=ENDS).map(|k| exact(end * f64::from(k) / f64::from(ENDS))).collect();
    for State { t, q, qd } in std::iter::once(&start).chain(&exact) {
        let y: Vec<_> = q.iter().chain(qd).map(|x| format!("{x:e}")).collect();
        println!("{name}\tstate\t{t:e}\t{}", y.join("\t"));
    }
    for tolerance in (18..=31).map(|k| 10f64.powf(-0.5 * f64::from(k))) {
        let run = |end: f64| {
            let (method, control) = (Taylor::for_tolerance(tolerance), Decay::tolerance(tolerance));
            integrate(black_box(system), method, control, start).until(end)
        };
        let errors = exact.iter().map(|at| distance(&run(at.t).finish().expect("a regular motion"), at));
        let error = errors.fold(0.0, f64::max);
        let mut counted = run(end);
        counted.run_out().expect("a regular motion");
        let steps = counted.statistics().accepted + counted.statistics().rejected;
        let seconds = |repeat: u32| {
            let clock = Instant::now();
            for _ in 0..repeat {
                black_box(run(end).finish().expect("a regular motion"));
            }
            clock.elapsed().as_secs_f64() / f64::from(repeat)
        };
        let repeat = (LEAST / seconds(3)).ceil().max(1.0) as u32;
        let shortest = (0..ROUNDS).map(|_| seconds(repeat)).fold(f64::INFINITY, f64::min);
        println!(
            "{name}\tpoint\t{tolerance:e}\t{error:e}\t{shortest:e}\t{steps}\t{}",
            counted.statistics().rejected
        );
    }
}

fn main() {
    let only = std::env::args().nth(1);
    let wanted = |name: &str| only.as_deref().is_none_or(|only| only == name);
    if wanted("Pendulum") {
        let (pendulum, exact) = problems::pendulum();
        points("Pendulum", &pendulum, exact, 20.0);
    }
    if wanted("Kepler") {
        let (kepler, exact) = problems::kepler();
        points("Kepler", &kepler, exact, 30.0);
    }
    if wanted("Double pendulum") {
        let (double, exact) = problems::double_pendulum();
        points("Double pendulum", &double, exact, 5.0);
    }
    if wanted("Top") {
        let (top, exact) = problems::top();
        points("Top", &top, exact, 20.0);
    }
}
