//! A pendulum: its motion as a chart. The first chapter of the guide.
//!
//! `cargo run --release --example pendulum`

use lagrange_runtime::chart::{Axis, Chart, Series};
use lagrange_runtime::prelude::*;

lagrangian! {
    /// A mass on a light rod.
    pub system Pendulum {
        param m, l, g = 9.81;
        coord theta: angle;
        T = 0.5 * m * (l * dot(theta)).powi(2);
        V = -m * g * l * cos(theta);
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let pendulum = Pendulum::new(1.3, 0.85); // m, l; g has a default
    let start = State::new(0.0, [2.0], [0.0]); // t, q, q̇

    // The motion over ten seconds, at 500 equal intervals: 501 states, with both ends.
    let run = integrate(&pendulum, Dop853, PiController::tolerance(1e-10), start).until(10.0);
    let states = run.sample_evenly(500).collect::<Result<Vec<_>, _>>()?;

    let energy = |at: &State<f64, 1>| pendulum.energy_at(at);
    let end = &states[500];
    println!("after {} s: θ = {:.6} rad, θ̇ = {:.6} rad/s", end.t, end.q[0], end.qd[0]);
    println!("energy {:.6} J, changed by {:.0e} J", energy(end), energy(end) - energy(&start));

    Chart::new("Pendulum", Axis::linear("time", "s"), Axis::linear("angle", "rad"))
        .subtitle("released at 2 rad")
        .with(Series::line("", states.iter().map(|at| (at.t, at.q[0]))))
        .write(std::env::temp_dir(), "pendulum")?;
    println!("{}", std::env::temp_dir().join("pendulum.svg").display());
    Ok(())
}
