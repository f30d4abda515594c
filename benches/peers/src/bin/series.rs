//! Points of work and precision of [`Taylor`], for `compare.py --series`, which sets them against heyoka's: system,
//! tolerance, error, seconds, steps, of them rejected. The error is the largest one at several ends of the run. With
//! `chain` for its argument: links, steps, seconds a step, error of the energy, seconds. With `lanes`: tolerance, and
//! seconds for 10,000 double pendulums from t = 0 to 10 on one thread, side by side in lanes and one after the other.

use lagrange_runtime::ensemble::{Ensemble, Moments, Table};
use lagrange_runtime::lanes::{Fused, FinalState};
use lagrange_runtime::prelude::*;
use lagrange_runtime::traits::Analytic;
use std::hint::black_box;
use std::time::Instant;

#[macro_use]
#[path = "../chain.rs"]
mod chain;
#[path = "../problems.rs"]
mod problems;

/// Rounds of timing, of which the shortest counts.
const ROUNDS: usize = 15;
/// A timed run is repeated until it takes this many seconds.
const LEAST: f64 = 2e-4;
/// At how many ends errors are measured.
const ENDS: u32 = 16;

/// Numbers of a state that are compared: of a free body the matrix of its attitude and its angular velocity, of others
/// coordinates and velocities.
fn compared<const N: usize>(attitudes: &[usize], at: &State<f64, N>) -> Vec<f64> {
    match attitudes {
        [] => at.q.iter().chain(&at.qd).copied().collect(),
        [first, ..] => {
            let (attitude, omega) = (at.attitude(*first).to_rotation_matrix(), at.angular_velocity(*first));
            attitude.matrix().transpose().iter().chain(&omega).copied().collect()
        }
    }
}

fn points<Sys: Analytic<N, Scalar = f64>, const N: usize>(
    name: &str,
    system: &Sys,
    exact: impl Fn(f64) -> State<f64, N>,
    end: f64,
) {
    let compared = |at: &State<f64, N>| compared(Sys::ATTITUDES, at);
    let distance = |a: &State<f64, N>, b: &State<f64, N>| {
        let apart = compared(a).into_iter().zip(compared(b)).map(|(a, b)| (a - b).abs());
        apart.fold(0.0, f64::max)
    };
    let start = exact(0.0);
    let exact: Vec<_> = (1..=ENDS).map(|k| exact(end * f64::from(k) / f64::from(ENDS))).collect();
    for at in std::iter::once(&start).chain(&exact) {
        let y: Vec<_> = compared(at).iter().map(|x| format!("{x:e}")).collect();
        println!("{name}\tstate\t{:e}\t{}", at.t, y.join("\t"));
    }
    for tolerance in (10..=31).map(|k| 10f64.powf(-0.5 * f64::from(k))) {
        let run = |end: f64| {
            let (method, control) = (Taylor, TaylorController::tolerance(tolerance));
            integrate(black_box(system), method, control, start).until(end)
        };
        let errors = exact.iter().map(|at| distance(&run(at.t).final_state().expect("a regular motion"), at));
        let error = errors.fold(0.0, f64::max);
        let mut counted = run(end);
        counted.run_to_end().expect("a regular motion");
        let steps = counted.statistics().accepted + counted.statistics().rejected;
        let seconds = |repeat: u32| {
            let clock = Instant::now();
            for _ in 0..repeat {
                black_box(run(end).final_state().expect("a regular motion"));
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

chain!(Chain2, 2);
chain!(Chain4, 4);
chain!(Chain8, 8);
chain!(Chain20, 20);

/// Nanoseconds a step at 1e-15, from `theta_i = 0.5 + 0.1 i` at rest to t = 10, and the relative error of the energy.
fn steps<Sys: Analytic<N, Scalar = f64> + lagrange_runtime::Energies<N>, const N: usize>(system: &Sys) {
    let start = State::new(0.0, std::array::from_fn(|i| 0.5 + 0.1 * i as f64), [0.0; N]);
    let run = || {
        let run = integrate(black_box(system), Taylor, TaylorController::tolerance(1e-15), start);
        let mut run = run.until(10.0);
        run.run_to_end().expect("a regular motion");
        let statistics = run.statistics();
        (*run.state(), statistics.accepted + statistics.rejected)
    };
    let (end, steps) = run();
    let energy = |at: &State<f64, N>| system.energy(&at.q, &at.qd, at.t);
    let defect = (energy(&end) / energy(&start) - 1.0).abs();
    let timed = |_| {
        let clock = Instant::now();
        black_box(run());
        clock.elapsed().as_secs_f64()
    };
    let shortest = (0..ROUNDS).map(timed).fold(f64::INFINITY, f64::min);
    println!("chain\tpoint\t{N}\t{steps}\t{:e}\t{defect:e}\t{shortest:e}", shortest / steps as f64);
}

/// Double pendulums from rest, at angles that fill a square evenly; as in compare.py.
const SAMPLES: u64 = 10_000;

fn lanes() {
    let starts = (0..SAMPLES).map(|i| {
        let share = |x: f64| 3.0 * (x * i as f64).fract() - 1.5;
        [share(0.618_033_988_749_894_9), share(0.414_213_562_373_095_03)]
    });
    let starts: Vec<[f64; 2]> = starts.collect();
    for tolerance in [1e-9, 1e-15] {
        let (method, control) = (Taylor, TaylorController::tolerance(tolerance));
        let study = || {
            let draw = |q: [f64; 2]| {
                (problems::DoublePendulum::new(0.7, 0.4, 0.8, 0.6, 9.81), State::new(0.0, q, [0.0; 2]))
            };
            Ensemble::new(Table::new(starts.iter().copied()), SAMPLES, draw).integrate(method, control, 10.0).threads(1)
        };
        let seconds = |run: &dyn Fn() -> u64| {
            let timed = |_| {
                let clock = Instant::now();
                assert_eq!(run(), SAMPLES);
                clock.elapsed().as_secs_f64()
            };
            (0..3).map(timed).fold(f64::INFINITY, f64::min)
        };
        let beside = seconds(&|| {
            let watch = FinalState(|_: &problems::DoublePendulum, end: &State<f64, 2>| end.q[0]);
            study().in_lanes(Fused).observe(&watch, Moments).expect("a sound study").statistic.count()
        });
        let alone = seconds(&|| {
            let ends = starts.iter().map(|q| {
                let (system, start) =
                    (problems::DoublePendulum::new(0.7, 0.4, 0.8, 0.6, 9.81), State::new(0.0, *q, [0.0; 2]));
                integrate(&system, method, control, start).until(10.0).final_state().expect("a regular motion").q[0]
            });
            black_box(ends.sum::<f64>());
            SAMPLES
        });
        println!("lanes\tpoint\t{tolerance:e}\t{beside:e}\t{alone:e}");
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
    // Only when asked for: it is no part of the comparison at equal error.
    if only.as_deref() == Some("chain") {
        steps(&Chain2::default());
        steps(&Chain4::default());
        steps(&Chain8::default());
        steps(&Chain20::default());
    }
    if only.as_deref() == Some("lanes") {
        lanes();
    }
    if wanted("Top") {
        let (top, exact) = problems::top();
        points("Top", &top, exact, 20.0);
    }
    if wanted("Free body") {
        let (body, exact) = problems::free_body();
        points("Free body", &body, exact, 20.0);
    }
}
