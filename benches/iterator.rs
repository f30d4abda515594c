//! Cost of the abstractions: `cargo bench --bench iterator`.
//!
//! 1. RK4 on the emitted Kepler system through `integrate(…).until(…)` against a loop and a right-hand side written by
//!    hand, as ratios of times in one run: with a `for` loop over the steps, and with `final_state`.
//! 2. The same evaluations of the right-hand side, made by DOP853 and made one after another by Euler's rule in a bare
//!    loop: the difference is what the method's own arithmetic, its controller and the time loop cost per evaluation.
//! 3. The time per evaluation of each method on accelerations that are nearly free, where nothing else remains.

#![allow(missing_docs)]

mod support;

use lagrange_runtime::prelude::*;
use lagrange_runtime::{Controller, Statistics};
use std::hint::black_box;
use support::systems::{DoublePendulum, Kepler, Pendulum};
use support::{consume, ratio};

/// N uncoupled oscillators: one multiplication per acceleration.
struct Oscillators<const N: usize>;

impl<const N: usize> System<N> for Oscillators<N> {
    type Scalar = f64;
    #[inline]
    fn accel(&self, q: &SVector<f64, N>, _: &SVector<f64, N>, _: f64) -> SVector<f64, N> {
        q * -1.0
    }
}

/// An ellipse of eccentricity 0.6 about μ = 1, from its pericentre.
const START: [f64; 4] = [0.4, 0.0, 0.0, 5.0];

/// RK4 and Kepler's equations, as one writes them for this one purpose.
fn by_hand(mu: f64, steps: u32, h: f64) -> [f64; 4] {
    let f = |[r, _, rd, phid]: [f64; 4]| {
        let u = 1.0 / r;
        [rd, phid, r * phid * phid - mu * u * u, -2.0 * rd * phid * u]
    };
    let add = |y: [f64; 4], c: f64, k: [f64; 4]| {
        [y[0] + c * k[0], y[1] + c * k[1], y[2] + c * k[2], y[3] + c * k[3]]
    };
    let mut y = START;
    for _ in 0..steps {
        let k1 = f(y);
        let k2 = f(add(y, 0.5 * h, k1));
        let k3 = f(add(y, 0.5 * h, k2));
        let k4 = f(add(y, h, k3));
        for i in 0..4 {
            y[i] += h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]);
        }
    }
    y
}

/// The same through the iterator.
fn by_iterator(system: &Kepler, steps: u32, h: f64) -> State<f64, 2> {
    let start = State::new(0.0, [START[0], START[1]], [START[2], START[3]]);
    let mut last = start;
    for step in integrate(system, Rk4, FixedStep::new(h), start).until(f64::from(steps) * h) {
        match step {
            Ok(step) => last = step.to,
            Err(failure) => panic!("{failure}"),
        }
    }
    last
}

/// The same when only the end is asked for.
fn by_finish(system: &Kepler, steps: u32, h: f64) -> State<f64, 2> {
    let start = State::new(0.0, [START[0], START[1]], [START[2], START[3]]);
    let run = integrate(system, Rk4, FixedStep::new(h), start).until(f64::from(steps) * h);
    run.final_state().unwrap_or_else(|failed| panic!("{failed}"))
}

fn rk4() {
    let (steps, h) = (20_000, 1e-3);
    let system = Kepler::new(1.0, 1.0);
    let hand = by_hand(1.0, 1000, h);
    for run in [by_iterator, by_finish] {
        let end = run(&system, 1000, h);
        let difference = hand.iter().zip(end.q.iter().chain(&end.qd)).map(|(a, b)| (a - b).abs());
        assert!(difference.fold(0.0, f64::max) < 1e-10, "the two loops compute different things");
    }
    println!("| RK4, Kepler | emitted / hand | quartiles | ns per step | by hand |");
    println!("|---|---|---|---|---|");
    type Runs = [(&'static str, fn(&Kepler, u32, f64) -> State<f64, 2>); 2];
    let runs: Runs = [("for", by_iterator), ("finish", by_finish)];
    for (name, run) in runs {
        let r = ratio(
            steps as usize,
            || consume(run(black_box(&system), black_box(steps), black_box(h))),
            || consume(by_hand(black_box(1.0), black_box(steps), black_box(h))),
        );
        let ([low, high], [ours, theirs]) = (r.quartiles, r.nanoseconds);
        println!("| `{name}` | {:.3} | {low:.3} – {high:.3} | {ours:.1} | {theirs:.1} |", r.median);
    }
}

/// A whole run.
fn run<Sys, M, C, const N: usize>(
    system: &Sys,
    method: M,
    controller: C,
    start: State<f64, N>,
    end: f64,
) -> Statistics
where
    Sys: System<N, Scalar = f64>,
    M: Method<Sys, N>,
    C: Controller<f64, N, M::Error>,
{
    let mut run = integrate(system, method, controller, start).until(end);
    run.run_to_end().unwrap_or_else(|failed| panic!("{failed}"));
    consume(*run.state());
    run.statistics()
}

/// Makes as many evaluations, each waiting for the one before.
fn chain<Sys: System<N, Scalar = f64>, const N: usize>(
    system: &Sys,
    start: &State<f64, N>,
    evaluations: u64,
) {
    let (mut q, mut qd) = (start.q, start.qd);
    for _ in 0..evaluations {
        qd += system.accel(&q, &qd, start.t) * 1e-9;
        q += qd * 1e-9;
    }
    consume((q, qd));
}

/// One row: DOP853 against the evaluations alone.
fn dop853<Sys: System<N, Scalar = f64>, const N: usize>(
    name: &str,
    system: Sys,
    start: State<f64, N>,
    end: f64,
) {
    let evaluations = run(&system, Dop853, PiController::tolerance(1e-9), start, end).evaluations;
    let r = ratio(
        evaluations as usize,
        || consume(run(black_box(&system), Dop853, PiController::tolerance(1e-9), start, black_box(end))),
        || chain(black_box(&system), &start, black_box(evaluations)),
    );
    let [ours, theirs] = r.nanoseconds;
    println!("| {name} | {ours:.1} | {theirs:.1} | {:.1} | {:.2} |", ours - theirs, r.median);
}

/// One row: a method on nearly nothing.
fn method<M, C, const N: usize>(name: &str, method: M, controller: C)
where
    M: Method<Oscillators<N>, N> + Copy,
    C: Controller<f64, N, M::Error>,
{
    let (start, end) = (State::new(0.0, [1.0; N], [0.0; N]), 2000.0);
    let evaluations = run(&Oscillators, method, controller.clone(), start, end).evaluations;
    let r = ratio(
        evaluations as usize,
        || consume(run(&Oscillators, method, controller.clone(), start, black_box(end))),
        || chain(&Oscillators, &start, black_box(evaluations)),
    );
    println!("| {name} | {N} | {:.2} |", r.nanoseconds[0]);
}

fn main() {
    rk4();

    println!("\n| DOP853, tolerance 1e-9 | ns per evaluation | of them `accel` | of them the rest | ratio |");
    println!("|---|---|---|---|---|");
    let pendulum = Pendulum::new(1.3, 0.85, 9.81);
    dop853("pendulum", pendulum, State::new(0.0, [2.0], [0.0]), 20.0);
    let start = State::new(0.0, [START[0], START[1]], [START[2], START[3]]);
    dop853("Kepler", Kepler::new(1.0, 1.0), start, 30.0);
    let double = DoublePendulum::new(0.7, 0.4, 0.8, 0.6, 9.81);
    dop853("double pendulum", double, State::new(0.0, [1.2, -0.4], [0.0, 0.5]), 10.0);

    println!("\n| method, on oscillators | coordinates | ns per evaluation |");
    println!("|---|---|---|");
    method::<_, _, 1>("RK4, fixed steps", Rk4, FixedStep::new(0.1));
    method::<_, _, 2>("RK4, fixed steps", Rk4, FixedStep::new(0.1));
    method::<_, _, 4>("RK4, fixed steps", Rk4, FixedStep::new(0.1));
    method::<_, _, 2>("DOP853, fixed steps", Dop853, FixedStep::new(0.5));
    method::<_, _, 8>("DOP853, fixed steps", Dop853, FixedStep::new(0.5));
    method::<_, _, 1>("DOP853, tolerance 1e-9", Dop853, PiController::tolerance(1e-9));
    method::<_, _, 2>("DOP853, tolerance 1e-9", Dop853, PiController::tolerance(1e-9));
    method::<_, _, 4>("DOP853, tolerance 1e-9", Dop853, PiController::tolerance(1e-9));
    method::<_, _, 8>("DOP853, tolerance 1e-9", Dop853, PiController::tolerance(1e-9));
    method::<_, _, 2>("Dormand–Prince 5(4), tolerance 1e-6", DormandPrince5, PiController::tolerance(1e-6));
}
