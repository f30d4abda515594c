//! A double pendulum over the top: energy drift, the path of its tip as a picture, and how far the tip is moved by a
//! small change of the start.
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
    sensitivity(pendulum, start)?.write(&folder, "sensitivity")?;
    for name in ["double-pendulum.svg", "sensitivity.svg"] {
        println!("{}", folder.join(name).display());
    }
    Ok(())
}

/// The derivative of the tip by the first angle at the start: by dual numbers, and by differences of two motions.
fn sensitivity(pendulum: DoublePendulum, start: State<f64, 2>) -> Result<Chart, Box<dyn Error>> {
    let (end, count) = (8.0, 800u32);
    let times = || (0..=count).map(|k| end * f64::from(k) / f64::from(count));
    let mut duals = start.map(Dual::constant);
    duals.q[0] = Dual::variable(start.q[0]);
    let system = pendulum.map(Dual::constant);
    let control = PiController::tolerance(1e-12);
    let exact = integrate(&system, Dop853, control, duals)
        .sample(times().map(Dual::constant))
        .map(|at| at.map(|at| (at.t.value, system.tip_at(&at))))
        .map(|at| at.map(|(t, tip)| (t, tip[0].slope.hypot(tip[1].slope))))
        .collect::<Result<Vec<_>, _>>()?;
    let tips = |first: f64| {
        let start = State::new(0.0, [first, start.q[1]], [0.0, 0.0]);
        let run = integrate(&pendulum, Dop853, control, start).sample(times());
        run.map(|at| at.map(|at| pendulum.tip_at(&at))).collect::<Result<Vec<_>, _>>()
    };
    let own = tips(start.q[0])?;
    let quotients = |change: f64| -> Result<Vec<(f64, f64)>, Failure> {
        let other = tips(start.q[0] + change)?;
        Ok(times().zip(own.iter().zip(&other)).map(|(t, (a, b))| (t, (b - a).norm() / change)).collect())
    };
    // Differences of motions that are close, while they are close.
    let near = quotients(1e-7)?;
    let apart = exact.iter().zip(&near).map(|(a, b)| (a.1 - b.1).abs() / a.1).take(count as usize / 4);
    let apart = apart.fold(0.0, f64::max);
    println!("over {} s the derivative and a quotient of differences agree to {apart:.0e}", end / 4.0);
    if apart > 1e-4 {
        return Err("the derivative is not that of the motion".into());
    }
    let drawn = |points: Vec<(f64, f64)>| points.into_iter().filter(|point| point.1 > 0.0);
    Ok(Chart::new(
        "How far a change of the start moves the tip",
        Axis::linear("time", "s"),
        Axis::log("tip by the first angle at the start", "m/rad"),
    )
    .subtitle("a double pendulum, let go at rest at 2 and 2.4 rad; by dual numbers, and by differences of two motions")
    .with(Series::line("exact derivative", drawn(exact)))
    .with(Series::line("two motions, 0.1 rad apart", drawn(quotients(0.1)?)))
    .with(Series::line("two motions, 1e-3 rad apart", drawn(quotients(1e-3)?))))
}
