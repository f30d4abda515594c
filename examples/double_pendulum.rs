//! A double pendulum over the top: energy drift, and the path of its tip as a picture.
//!
//! `cargo run --release --example double_pendulum`

#[path = "support/mod.rs"]
mod support;

use lagrange_runtime::chart::{Axis, Chart, Series};
use lagrange_runtime::prelude::*;
use std::error::Error;

lagrangian! {
    /// Two masses on light rods, the second hanging from the first; angles from the downward vertical.
    pub system DoublePendulum {
        param m1, m2, l1, l2, g = 9.81;
        coord a, b;
        let x1 = l1 * sin(a);
        let y1 = -l1 * cos(a);
        let x2 = x1 + l2 * sin(b);
        let y2 = y1 - l2 * cos(b);
        T = 0.5 * m1 * (dot(x1).powi(2) + dot(y1).powi(2)) + 0.5 * m2 * (dot(x2).powi(2) + dot(y2).powi(2));
        V = m1 * g * y1 + m2 * g * y2;
        observe tip = [x2, y2];
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let pendulum = DoublePendulum::new(0.7, 0.4, 0.8, 0.6);
    let energy = |at: &State<f64, 2>| pendulum.energy_at(at);
    let start = State::new(0.0, [2.0, 2.4], [0.0, 0.0]);
    let end = 20.0;

    let run = integrate(&pendulum, Dop853, PiController::tolerance(1e-12), start).until(end);
    let frames: Vec<State<f64, 2>> =
        run.sample((0..=4000).map(|k| end * f64::from(k) / 4000.0)).collect::<Result<_, _>>()?;
    let drift = frames.iter().map(|at| (energy(at) - energy(&start)).abs()).fold(0.0, f64::max);
    println!("energy {:.6} J; over {end} s it is off by {drift:.1e} J at most", energy(&start));

    let path = frames.iter().map(|at| pendulum.tip_at(at)).map(|tip| (tip[0], tip[1]));
    let folder = support::charts()?;
    Chart::new("Path of the tip of a double pendulum", Axis::linear("x", "m"), Axis::linear("y", "m"))
        .subtitle(format!("let go at rest at {} and {} rad, {end} s", start.q[0], start.q[1]))
        .equal_aspect()
        .with(Series::line("", path))
        .write(&folder, "double-pendulum")?;
    println!("{}", folder.join("double-pendulum.svg").display());
    Ok(())
}
