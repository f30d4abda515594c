//! A DC motor with a gear lifts a pendulum under a PI controller of its angle: the current of the armature and the
//! integral of the error are states of first order, and the poles are those of the whole loop.
//!
//! `cargo run --release --example motor`

#[path = "support/mod.rs"]
mod support;

use lagrange_runtime::analysis::operating_point;
use lagrange_runtime::chart::{Axis, Chart, Series};
use lagrange_runtime::prelude::*;
use std::error::Error;

lagrangian! {
    /// θ from the lowest point; the rotor turns `gear` times as fast.
    pub system Motor {
        param m = 0.8, l = 0.35, rotor = 2e-5, gear = 20.0, c = 0.02, g = 9.81;
        param R = 1.2, L = 0.004, k = 0.03, kp = 15.0, kd = 1.5;
        /// Gain of the integrator.
        param ki;
        input target = 2.0;
        coord theta: angle;
        /// Current of the armature.
        state i;
        /// Integral of the error.
        state e;
        T = 0.5 * (m * l.powi(2) + rotor * gear.powi(2)) * dot(theta).powi(2);
        V = -m * g * l * cos(theta);
        D = 0.5 * c * dot(theta).powi(2);
        Q[theta] = gear * k * i;
        let u = kp * (target - theta) - kd * dot(theta) + ki * e;
        rate(i) = (u - R * i - k * gear * dot(theta)) / L;
        rate(e) = target - theta;
    }
}

/// Draws the motions.
pub fn main() -> Result<(), Box<dyn Error>> {
    let mut chart = Chart::new(
        "A motor lifts a pendulum to an angle of 2 rad",
        Axis::linear("time t", "s"),
        Axis::linear("angle θ (rad), current i (A)", ""),
    )
    .subtitle("without an integrator an error remains, which the weight makes; with one none");
    for ki in [0.0, 15.0] {
        let motor = Motor::new(ki);
        let start = motor.start(0.0, [0.0], [0.0]);
        // The armature has a time constant of 3 ms.
        let run = integrate(&motor, Radau5, PiController::tolerance(1e-8), start).until(4.0);
        let states = run.sample_evenly(800).collect::<Result<Vec<_>, _>>()?;
        let end = states.last().ok_or("no samples")?;
        // At rest the weight m g l sin θ takes the current R i = kp (θ₀ − θ) + ki e.
        let load = motor.m * motor.g * motor.l * end.q[0].sin() / (motor.gear * motor.k);
        let [current, _] = motor.states(end).into();
        println!("ki = {ki}: θ = {:.6} rad, i = {current:.6} A, of the weight {load:.6} A", end.q[0]);
        if ki > 0.0 {
            // (Without a gain the integral of the error rests nowhere.)
            let point = operating_point(&motor, end)?;
            println!("poles of the loop, in 1/s: {:.4?}", point.poles);
            assert!(point.poles.len() == 4 && point.poles.iter().all(|pole| pole.re < 0.0));
            assert!((point.state.q[0] - 2.0).abs() < 1e-12 && (end.q[0] - 2.0).abs() < 0.02);
        } else {
            assert!((current - load).abs() < 1e-3 && (end.q[0] - 2.0).abs() > 0.1);
        }
        let angle = states.iter().map(|s| (s.t, s.q[0]));
        let currents = states.iter().map(|s| (s.t, s.qd[1]));
        chart = chart
            .with(Series::line(format!("angle, ki = {ki}"), angle))
            .with(Series::line(format!("current, ki = {ki}"), currents));
    }
    let folder = support::charts()?;
    chart.write(&folder, "motor")?;
    println!("{}", folder.join("motor.png").display());
    Ok(())
}
