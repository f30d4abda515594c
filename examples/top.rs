//! Three motions of a top's axis, seen from above: it undulates, comes to cusps, or loops, depending on how it is let
//! go.
//!
//! `cargo run --release --example top`

#[path = "support/mod.rs"]
mod support;

use lagrange_runtime::chart::{Axis, Chart, Series};
use lagrange_runtime::prelude::*;
use std::error::Error;
use std::f64::consts::TAU;

lagrangian! {
    /// φ precession, θ inclination from the upward vertical, ψ spin; I1 about the fixed point.
    pub system Top {
        param m, l, I1, I3, g = 9.81;
        coord phi, theta, psi;
        let spin = dot(psi) + dot(phi) * cos(theta);
        T = 0.5 * I1 * (dot(theta).powi(2) + (dot(phi) * sin(theta)).powi(2)) + 0.5 * I3 * spin.powi(2);
        V = m * g * l * cos(theta);
        observe axis = [sin(theta) * cos(phi), sin(theta) * sin(phi), cos(theta)];
    }
}

/// A circle of equal inclination, from above.
fn parallel(theta: f64) -> impl Iterator<Item = (f64, f64)> {
    (0..=180)
        .map(|k| TAU * f64::from(k) / 180.0)
        .map(move |phi| (theta.sin() * phi.cos(), theta.sin() * phi.sin()))
}

fn main() -> Result<(), Box<dyn Error>> {
    let top = Top::new(0.5, 0.12, 0.008, 0.0011);
    let (theta, spin, end) = (0.6, 180.0, 2.0);
    let folder = support::charts()?;
    for (name, phid) in [("undulates", 1.0), ("comes to cusps", 0.0), ("loops", -1.5)] {
        let start = State::new(0.0, [0.0, theta, 0.0], [phid, 0.0, spin - phid * theta.cos()]);
        let run = || integrate(&top, Dop853, PiController::tolerance(1e-11), start);

        // The axis turns back where θ̇ = 0, which it is at the start, too.
        let turns = run().until(end).events(Event::either(|s: &State<f64, 3>| s.qd[1]));
        let turns = turns.collect::<Result<Vec<_>, _>>()?;
        let turn = turns.iter().map(|turn| turn.state).find(|turn| turn.t > 1e-3).ok_or("no turn")?;
        println!("{name}: θ from {theta} to {:.6} rad, nutation period {:.9} s", turn.q[1], 2.0 * turn.t);

        let frames = run().until(end).sample((0..=2000).map(|k| end * f64::from(k) / 2000.0));
        let frames = frames.collect::<Result<Vec<_>, _>>()?;
        let stem = format!("top-{}", name.split_whitespace().last().unwrap_or(name));
        Chart::new(
            format!("The axis of a top {name}"),
            Axis::linear("x of the centre of mass, from above", "l"),
            Axis::linear("y", "l"),
        )
        .subtitle(format!("let go at θ = {theta} rad with φ̇ = {phid} rad/s; spin {spin} rad/s; {end} s"))
        .equal_aspect()
        .with(Series::line("path", frames.iter().map(|at| top.axis_at(at)).map(|axis| (axis[0], axis[1]))))
        .with(Series::line(
            "turning circles",
            parallel(theta).chain([(f64::NAN, f64::NAN)]).chain(parallel(turn.q[1])),
        ))
        .write(&folder, &stem)?;
        println!("{}", folder.join(format!("{stem}.svg")).display());
    }
    Ok(())
}
