//! The cost of the ways to drive a motion, in instructions: `valgrind --tool=callgrind <bench> run rk4 3000` less the
//! same with 1000.

#![allow(missing_docs)]

mod support;

use lagrange_runtime::prelude::*;
use lagrange_runtime::{Controller, Statistics, Stepper};
use std::hint::black_box;
use support::consume;
use support::systems::{DoublePendulum, Kepler};

const START: State<f64, 2> =
    State { t: 0.0, q: SVector::<f64, 2>::new(1.5, 2.0), qd: SVector::<f64, 2>::new(0.0, 0.3) };

/// A loop over the steps of a run.
fn run<M, C>(system: &DoublePendulum, method: M, controller: C, steps: usize) -> Statistics
where
    M: Method<DoublePendulum, 2>,
    C: Controller<f64, 2, M::Error>,
{
    let mut run = integrate(system, method, controller, START);
    let mut sum = 0.0;
    for step in run.by_ref().take(steps) {
        match step {
            Ok(step) => sum += step.to.q[0],
            Err(failure) => panic!("{failure}"),
        }
    }
    consume(sum);
    run.statistics()
}

/// Kepler's problem, to an end.
fn finish<M, C>(method: M, controller: C, end: f64) -> Statistics
where
    M: Method<Kepler, 2>,
    C: Controller<f64, 2, M::Error>,
{
    let system = black_box(Kepler::new(1.0, 1.0));
    let mut run = integrate(&system, method, controller, State::new(0.0, [0.4, 0.0], [0.0, 5.0])).until(end);
    run.run_to_end().unwrap_or_else(|failed| panic!("{failed}"));
    consume(*run.state());
    run.statistics()
}

/// The same by a stepper.
fn stepper<M, C>(system: DoublePendulum, method: M, controller: C, steps: usize) -> Statistics
where
    M: Method<DoublePendulum, 2>,
    C: Controller<f64, 2, M::Error>,
{
    let mut stepper = Stepper::new(system, method, controller, START);
    let mut sum = 0.0;
    for _ in 0..steps {
        match stepper.step() {
            Ok(step) => sum += step.to.q[0],
            Err(failure) => panic!("{failure}"),
        }
    }
    consume(sum);
    stepper.statistics()
}

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).filter(|word| *word != "--bench").collect();
    let system = black_box(DoublePendulum::new(1.0, 0.7, 1.0, 0.8, 9.81));
    let steps = words.get(3).map_or(1000, |steps| steps.parse().expect("a number of steps"));
    let (fixed, pi) = (FixedStep::new(black_box(1e-3)), PiController::tolerance(black_box(1e-9)));
    let statistics = match words.get(1..3) {
        Some(["run", "rk4"]) => run(&system, Rk4, fixed, steps),
        Some(["run", "dop853"]) => run(&system, Dop853, pi, steps),
        Some(["finish", "rk4"]) => finish(Rk4, fixed, 1e-3 * steps as f64),
        Some(["finish", "dop853"]) => finish(Dop853, pi, 1e-1 * steps as f64),
        Some(["stepper", "rk4"]) => stepper(system, Rk4, fixed, steps),
        Some(["stepper", "dop853"]) => stepper(system, Dop853, pi, steps),
        _ => return,
    };
    println!("{statistics:?}");
}
