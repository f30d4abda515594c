//! A segment of a cylinder that rocks on a floor without slipping: the wider it rocks, the longer it takes.
//!
//! `cargo run --release --example rocking_segment`

#[path = "support/mod.rs"]
mod support;

use lagrange_runtime::chart::{Axis, Chart, Series};
use lagrange_runtime::prelude::*;
use std::error::Error;

lagrangian! {
    /// Radius R; the centre of mass lies at r from the axis of the cylinder; IC about it; θ, tilt.
    pub system Segment {
        param m, R, r, IC, g = 9.81;
        coord theta;
        let x = R * theta - r * sin(theta);
        let y = R - r * cos(theta);
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2)) + 0.5 * IC * dot(theta).powi(2);
        V = m * g * y;
    }
}

lagrangian! {
    /// A simple pendulum of the same period at small angles, to compare with.
    pub system Pendulum {
        param l, g = 9.81;
        coord theta;
        T = 0.5 * (l * dot(theta)).powi(2);
        V = -g * l * cos(theta);
    }
}

/// The period of a swing from rest: four times the way to θ = 0.
fn period<Sys>(system: &Sys, theta: f64) -> Result<f64, Box<dyn Error>>
where
    Sys: System<1, Scalar = f64>,
{
    let run = integrate(system, Dop853, PiController::tolerance(1e-11), State::new(0.0, [theta], [0.0]))
        .until(100.0);
    Ok(4.0 * run.events(Event::falling(|s| s.q[0]).terminal()).next().ok_or("it does not rock")??.state.t)
}

fn main() -> Result<(), Box<dyn Error>> {
    // Half a cylinder: its centre of mass lies at 4R/3π, its moment of inertia about the axis is mR²/2.
    let (m, radius) = (1.3, 0.5);
    let r = 4.0 * radius / (3.0 * std::f64::consts::PI);
    let segment = Segment::new(m, radius, r, 0.5 * m * radius * radius - m * r * r);

    let rest = SVector::from([0.0]);
    let small = std::f64::consts::TAU / (-segment.jacobian(&rest, &rest, 0.0).q[0]).sqrt();
    let pendulum = Pendulum::new(segment.g * (small / std::f64::consts::TAU).powi(2));
    println!("small rocking: {small:.9} s; from 0.001 rad {:.9} s", period(&segment, 0.001)?);

    let tilts: Vec<f64> = (1..=75).map(|k| 0.02 * f64::from(k)).collect();
    let (mut rocking, mut swinging) = (Vec::new(), Vec::new());
    for &tilt in &tilts {
        rocking.push((tilt, period(&segment, tilt)?));
        swinging.push((tilt, period(&pendulum, tilt)?));
    }
    let folder = support::charts()?;
    Chart::new("Rocking half-cylinder", Axis::linear("largest tilt", "rad"), Axis::linear("period", "s"))
        .subtitle(format!("radius {radius} m, rolling without slip; small rocking takes {small:.4} s"))
        .with(Series::line("half-cylinder", rocking))
        .with(Series::line("simple pendulum, the same at small angles", swinging))
        .write(&folder, "rocking-segment")?;
    println!("{}", folder.join("rocking-segment.svg").display());
    Ok(())
}
