//! Path of a spherical pendulum, seen from above: an ellipse that turns, between two circles.
//!
//! `cargo run --release --example spherical_pendulum`

#[path = "support/mod.rs"]
mod support;

use lagrange_runtime::chart::{Axis, Chart, Series};
use lagrange_runtime::prelude::*;
use std::error::Error;
use std::f64::consts::TAU;

lagrangian! {
    /// θ from the downward vertical.
    pub system SphericalPendulum {
        param m, l, g = 9.81;
        coord theta, phi;
        let x = l * sin(theta) * cos(phi);
        let y = l * sin(theta) * sin(phi);
        let z = -l * cos(theta);
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2));
        V = m * g * z;
        observe bob = [x, y];
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let pendulum = SphericalPendulum::new(0.9, 1.1);
    let start = State::new(0.0, [1.0, 0.0], [0.0, 1.2]);
    let run = || integrate(&pendulum, Dop853, PiController::tolerance(1e-12), start);

    // The bob comes in, and goes out again where θ̇ rises through 0.
    let inner = run().until(10.0).events(Event::rising(|s| s.qd[0]).terminal()).next();
    let inner = inner.ok_or("it does not turn back")??.state;
    let advance = 4.0 * inner.q[1] - TAU;
    println!(
        "θ between {:.6} and {} rad; the ellipse turns by {advance:.6} rad each time round",
        inner.q[0], start.q[0]
    );

    let end = 16.0;
    let frames = run()
        .until(end)
        .sample((0..=3000).map(|k| end * f64::from(k) / 3000.0))
        .collect::<Result<Vec<_>, _>>()?;
    let circle = |theta: f64| {
        let rho = pendulum.l * theta.sin();
        (0..=180).map(move |k| TAU * f64::from(k) / 180.0).map(move |phi| (rho * phi.cos(), rho * phi.sin()))
    };
    let gap = [(f64::NAN, f64::NAN)];
    let folder = support::charts()?;
    Chart::new("Spherical pendulum from above", Axis::linear("x", "m"), Axis::linear("y", "m"))
        .subtitle(format!("length {} m, let go at θ = 1 rad with φ̇ = 1.2 rad/s, {end} s", pendulum.l))
        .equal_aspect()
        .with(Series::line(
            "bob",
            frames.iter().map(|at| pendulum.bob(&at.q, &at.qd, at.t)).map(|bob| (bob[0], bob[1])),
        ))
        .with(Series::line("turning circles", circle(start.q[0]).chain(gap).chain(circle(inner.q[0]))))
        .write(&folder, "spherical-pendulum")?;
    println!("{}", folder.join("spherical-pendulum.svg").display());
    Ok(())
}
