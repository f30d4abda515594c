//! A ball that bounces, comes to rest and is lifted again: impacts are events at which the run is restarted, and rest
//! is a second system with one constraint more.
//!
//! `cargo run --release --example bounces`

#[path = "support/checks.rs"]
mod checks;
#[path = "support/mod.rs"]
mod support;

use checks::Checks;
use lagrange_runtime::chart::{Axis, Chart, Series};
use lagrange_runtime::prelude::*;
use std::error::Error;

lagrangian! {
    /// A ball that is drawn upward ever more strongly.
    pub system Ball {
        param m = 0.1, rate = 0.3, g = 9.81;
        coord x: length, z: length;
        T = 0.5 * m * (dot(x).powi(2) + dot(z).powi(2));
        V = m * g * z;
        Q[z] = rate * t;
        event ground: z, falling, terminal;
    }
}

lagrangian! {
    /// The same on the ground.
    pub system Resting {
        param m = 0.1, rate = 0.3, g = 9.81;
        coord x: length, z: length;
        T = 0.5 * m * (dot(x).powi(2) + dot(z).powi(2));
        V = m * g * z;
        Q[z] = rate * t;
        constraint ground: z == 0;
        event lift_off: reaction(ground), falling, terminal;
    }
}

/// Coefficient of restitution.
const RESTITUTION: f64 = 0.7;
/// Rebounds slower than this, in m/s, end the bounces.
const SLOW: f64 = 1e-3;

fn main() -> Result<(), Box<dyn Error>> {
    let (ball, resting) = (Ball::default(), Resting::default());
    let control = PiController::tolerance(1e-11);
    let mut at = State::new(0.0, [0.0, 0.5], [0.3, 0.0]);
    let flight = |from: State<f64, 2>, until: f64| -> Result<Vec<(f64, f64)>, Failure> {
        let samples = integrate(&ball, Dop853, control, from).until(until).sample_evenly(60);
        samples.map(|at| at.map(|at| (at.t, at.q[1]))).collect()
    };
    let (mut height, mut impacts) = (Vec::new(), Vec::new());
    loop {
        let impact = integrate(&ball, Dop853, control, at).until(20.0).events(Ball::GROUND).final_state()?;
        height.extend(flight(at, impact.t)?);
        impacts.push((impact.t, 0.0));
        at = impact;
        (at.q[1], at.qd[1]) = (0.0, -RESTITUTION * impact.qd[1]);
        if at.qd[1] < SLOW {
            break;
        }
    }
    // At rest, until the ground would have to pull.
    at.qd[1] = 0.0;
    let lift =
        integrate(&resting, Dop853, control, at).until(20.0).events(Resting::LIFT_OFF).final_state()?;
    let rest = vec![(at.t, 0.0), (lift.t, 0.0)];
    let end = lift.t + 0.9;
    let lifted = flight(lift, end)?;
    println!("{} impacts until {:.3} s, lifted off at {:.3} s", impacts.len(), at.t, lift.t);

    let folder = support::charts()?;
    Chart::new("A ball bounces, rests and is lifted", Axis::linear("time", "s"), Axis::linear("height", "m"))
        .subtitle(format!(
            "restitution {RESTITUTION}; an upward force of {} N/s times t; the ground lets go where its reaction is 0",
            ball.rate
        ))
        .with(Series::line("flights", height))
        .with(Series::line("at rest", rest))
        .with(Series::line("lifted", lifted.iter().copied()))
        .with(Series::markers("impacts", impacts.iter().copied()))
        .with(Series::markers("lift-off", [(lift.t, 0.0)]))
        .write(&folder, "bounces")?;
    println!("{}", folder.join("bounces.svg").display());

    let mut checks = Checks::default();
    let first = impacts.first().map_or(f64::NAN, |impact| impact.0);
    // z = h − g t²/2 + (rate/m) t³/6 at the first impact.
    let fallen = 0.5 - 0.5 * ball.g * first.powi(2) + ball.rate / ball.m * first.powi(3) / 6.0;
    checks.at_most("height at the first impact (m)", fallen.abs(), 1e-11);
    checks.at_most("lift-off against m g/rate (s)", (lift.t - ball.m * ball.g / ball.rate).abs(), 1e-9);
    checks.holds("it rests before it is lifted", at.t < lift.t);
    let last = lifted.last().map_or(f64::NAN, |at| at.1);
    let exact = ball.rate / ball.m * 0.9f64.powi(3) / 6.0;
    checks.at_most("height at the end against (rate/m) τ³/6 (m)", (last - exact).abs(), 1e-9);
    Ok(checks.report()?)
}
