//! Three motions of a top's axis, seen on a sphere about its fixed point: it undulates, loops, or comes to cusps,
//! depending on how it is let go.
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

/// From the front and 50° above the horizon: right and up in the picture.
fn seen([x, y, z]: [f64; 3]) -> (f64, f64) {
    let (sin, cos) = 50f64.to_radians().sin_cos();
    (y, z * cos - x * sin)
}

/// A circle of equal inclination.
fn parallel(theta: f64) -> impl Iterator<Item = (f64, f64)> {
    (0..=120).map(move |k| {
        let (sin, cos) = (TAU * f64::from(k) / 120.0).sin_cos();
        seen([theta.sin() * cos, theta.sin() * sin, theta.cos()])
    })
}

fn main() -> Result<(), Box<dyn Error>> {
    let top = Top::new(0.5, 0.12, 0.008, 0.0011);
    let (theta, spin) = (0.6, 180.0);
    let gap = (f64::NAN, f64::NAN);
    let (mut outlines, mut turnings, mut paths) = (Vec::new(), Vec::new(), Vec::new());

    for (place, (name, phid)) in
        [("undulating", 4.0), ("cuspidal", 0.0), ("looping", -1.5)].into_iter().enumerate()
    {
        let start = State::new(0.0, [0.0, theta, 0.0], [phid, 0.0, spin - phid * theta.cos()]);
        let run = integrate(&top, Dop853, Pi::tolerance(1e-11), start);

        // The axis turns back where θ̇ = 0: after half a nutation for the first time.
        let turn = run.until(10.0).events(Event::new(|s: &State<f64, 3>| s.qd[1]).terminal()).find(|found| {
            match found {
                Ok(found) => found.state.t > 1e-6,
                Err(_) => true,
            }
        });
        let turn = turn.ok_or("the axis does not turn back")??.state;
        println!("{name}: θ from {theta} to {:.6}, nutation period {:.9} s", turn.q[1], 2.0 * turn.t);

        let run = integrate(&top, Dop853, Pi::tolerance(1e-11), start).until(2.2);
        let frames =
            run.sample((0..=1500).map(|k| 2.2 * f64::from(k) / 1500.0)).collect::<Result<Vec<_>, _>>()?;
        let shift = |(right, up): (f64, f64)| (right + 1.9 * place as f64, up);
        paths.extend(frames.iter().map(|at| shift(seen(top.axis(&at.q, &at.qd, at.t).into()))).chain([gap]));
        for inclination in [theta, turn.q[1]] {
            turnings.extend(parallel(inclination).map(shift).chain([gap]));
        }
        outlines.extend(parallel(0.95).map(shift).chain([gap]));
    }

    let folder = support::charts()?;
    Chart::new(
        "Axis of a top: undulating, cuspidal, looping",
        Axis::linear("across", "l"),
        Axis::linear("up", "l"),
    )
    .subtitle(format!("let go at θ = {theta} rad with φ̇ = 4, 0, −1.5 rad/s; spin {spin} rad/s, 2.2 s"))
    .equal_aspect()
    .with(Series::line("path of the axis", paths))
    .with(Series::line("turning circles", turnings))
    .with(Series::line("θ = 0.95 rad", outlines))
    .write(&folder, "top")?;
    println!("{}", folder.join("top.svg").display());
    Ok(())
}
