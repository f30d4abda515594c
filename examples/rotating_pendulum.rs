//! Pendulum hinged on a turning table: the tension of its wire against its angle. Its length is kept by a
//! constraint, whose multiplier is the force.
//!
//! `cargo run --release --example rotating_pendulum`

#[path = "support/mod.rs"]
mod support;

use lagrange_runtime::chart::{Axis, Chart, Series};
use lagrange_runtime::prelude::*;
use std::error::Error;

lagrangian! {
    /// β, angle of the wire from the outward radius; the hinge is at the distance r from the axis of the table. s is
    /// the length of the wire, which the constraint keeps.
    pub system Pendulum {
        param m, l, r, omega;
        coord beta, s;
        coord theta = omega * t;
        let x = r * cos(theta) + s * cos(theta + beta);
        let y = r * sin(theta) + s * sin(theta + beta);
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
        V = 0;
        constraint wire: s == l;
        observe push = reaction(wire);
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let pendulum = Pendulum::new(0.5, 0.7, 0.4, 3.1);
    let tension = |at: &State<f64, 2>| -pendulum.push_at(at);

    let folder = support::charts()?;
    let mut chart = Chart::new(
        "Tension of the wire of a pendulum on a turning table",
        Axis::linear("angle β of the wire from the radius", "rad"),
        Axis::linear("tension", "N"),
    )
    .subtitle("let go at rest on the table; upper branch: swinging with the table, lower: against it; below 0 a wire is slack");
    for start in [0.4, 1.1, 1.8, 2.5] {
        let run = integrate(
            &pendulum,
            Dop853,
            PiController::tolerance(1e-11),
            State::new(0.0, [start, pendulum.l], [0.0, 0.0]),
        );
        // A period: down through β = 0 and up again, twice.
        let quarter = run.until(20.0).events(Event::falling(|s| s.q[0]).terminal()).next();
        let period = 4.0 * quarter.ok_or("it does not swing back")??.state.t;
        let run = integrate(
            &pendulum,
            Dop853,
            PiController::tolerance(1e-11),
            State::new(0.0, [start, pendulum.l], [0.0, 0.0]),
        )
        .until(period);
        let frames =
            run.sample((0..=600).map(|k| period * f64::from(k) / 600.0)).collect::<Result<Vec<_>, _>>()?;
        let least = frames.iter().map(tension).fold(f64::INFINITY, f64::min);
        println!("let go at {start} rad: period {period:.6} s, least tension {least:.4} N");
        chart = chart
            .with(Series::line(format!("from {start} rad"), frames.iter().map(|at| (at.q[0], tension(at)))));
    }
    chart.write(&folder, "rotating-pendulum")?;
    println!("{}", folder.join("rotating-pendulum.svg").display());
    Ok(())
}
