//! The cost of the ways to drive a motion, in instructions: `valgrind --tool=callgrind <bench> run rk4 3000` less the
//! same with 1000. `arm stepper`, `arm set` and `arm loop` are an arm of seven axes under computed torques at 1 kHz: a
//! stepper with a controller, one whose owner sets the inputs, and RK4 by hand.

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

lagrangian! {
    /// Seven axes, along the links and across them in turn.
    system Arm {
        const N = 7;
        param m: [N] = [4.1, 4.0, 3.0, 2.7, 1.7, 1.8, 0.3];
        param g = 9.81;
        input tau: [N];
        coord q: [angle; N];
        let up = [0.16, 0.2, 0.2, 0.22, 0.18, 0.22, 0.08, 0.12];
        let link: [N] = |i| frame(
            if i == 0 { world } else { link[i - 1] },
            [0, 0, up[i]],
            if i % 2 == 0 { rotation_z(q[i]) } else { rotation_y(q[i]) }
        );
        let centre: [N] = |i| frame(link[i], [0, 0.03, 0.5 * up[i + 1]]);
        let across: [N] = |i| m[i] * (up[i + 1] * up[i + 1] + 3 * 0.06 * 0.06) / 12;
        T = (0..N).map(|i| body(m[i], [across[i], across[i], 0.5 * m[i] * 0.06 * 0.06], centre[i])).sum();
        V = g * (0..N).map(|i| m[i] * centre[i].origin()[2]).sum();
        Q[q] = tau;
    }
}

type Joints = SVector<f64, 7>;

/// Computed torques about the upright place. (Not inlined, so that all ways call the same.)
#[inline(never)]
fn torques(arm: &Arm, at: &State<f64, 7>) -> Joints {
    let a = -at.q * 1600.0 - at.qd * 80.0;
    arm.inertia(&at.q, &at.qd, at.t) * a + arm.convective_momentum_rate(&at.q, &at.qd, at.t)
}

/// Steps of classical RK4 with the torques held in each.
fn arm_loop(mut arm: Arm, start: State<f64, 7>, h: f64, steps: usize) -> State<f64, 7> {
    let model = arm;
    let State { q, qd, t } = start;
    let (mut q, mut qd) = (q, qd);
    for k in 0..steps {
        let t = t + h * k as f64;
        arm.tau = torques(&model, &State { t, q, qd }).into();
        let a1 = arm.accel(&q, &qd, t);
        let v2 = qd + a1 * (0.5 * h);
        let a2 = arm.accel(&(q + qd * (0.5 * h)), &v2, t + 0.5 * h);
        let v3 = qd + a2 * (0.5 * h);
        let a3 = arm.accel(&(q + v2 * (0.5 * h)), &v3, t + 0.5 * h);
        let v4 = qd + a3 * h;
        let a4 = arm.accel(&(q + v3 * h), &v4, t + h);
        q += (qd + v2 * 2.0 + v3 * 2.0 + v4) * (h / 6.0);
        qd += (a1 + a2 * 2.0 + a3 * 2.0 + a4) * (h / 6.0);
    }
    State { t: t + h * steps as f64, q, qd }
}

fn arm_stepper(arm: Arm, start: State<f64, 7>, h: f64, steps: usize) -> Result<State<f64, 7>, Failure> {
    let mut stepper =
        Stepper::new(arm, Rk4, FixedStep::new(h), start).every(h, |state, tau| *tau = torques(&arm, state));
    stepper.advance_to(h * steps as f64)?;
    println!("{:?}", stepper.statistics());
    Ok(*stepper.state())
}

fn arm_set(arm: Arm, start: State<f64, 7>, h: f64, steps: usize) -> Result<State<f64, 7>, Failure> {
    let mut stepper = Stepper::new(arm, Rk4, FixedStep::new(h), start);
    for k in 1..=steps {
        stepper.set_inputs(torques(&arm, stepper.state()))?;
        stepper.advance_to(h * k as f64)?;
    }
    println!("{:?}", stepper.statistics());
    Ok(*stepper.state())
}

/// The arm by each of the ways.
fn arm(way: &str, steps: usize) {
    let start = State::new(0.0, black_box([0.3, 0.2, -0.1, 0.4, 0.2, -0.3, 0.1]), [0.1; 7]);
    let (arm, h) = (black_box(Arm::default()), black_box(1e-3));
    let end = match way {
        "stepper" => arm_stepper(arm, start, h, steps),
        "set" => arm_set(arm, start, h, steps),
        _ => Ok(arm_loop(arm, start, h, steps)),
    };
    println!("{:?}", end.unwrap_or_else(|failure| panic!("{failure}")).q);
}

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).filter(|word| *word != "--bench").collect();
    let system = black_box(DoublePendulum::new(1.0, 0.7, 1.0, 0.8, 9.81));
    let steps = words.get(3).map_or(1000, |steps| steps.parse().expect("a number of steps"));
    let (fixed, pi) = (FixedStep::new(black_box(1e-3)), PiController::tolerance(black_box(1e-9)));
    let statistics = match words.get(1..3) {
        Some(["arm", way]) => return arm(way, steps),
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
