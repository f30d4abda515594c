//! Orbits about a centre of attraction, and the apparent potential of the radial motion that they share: one angular
//! momentum, four energies.
//!
//! `cargo run --release --example central_force`

#[path = "support/mod.rs"]
mod support;

use lagrange_runtime::chart::{Axis, Chart, Series};
use lagrange_runtime::prelude::*;
use std::error::Error;

lagrangian! {
    /// The force is μm/r².
    pub system Orbit {
        param m, mu;
        coord r, phi;
        T = 0.5 * m * (dot(r).powi(2) + (r * dot(phi)).powi(2));
        V = -mu * m / r;
        observe place = [r * cos(phi), r * sin(phi)];
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let orbit = Orbit::new(1.0, 1.0);
    let gamma: f64 = 1.0;
    let folder = support::charts()?;

    // With φ ignorable, p_φ = mγ is conserved, and the radial motion sees V(r) + mγ²/2r².
    let apparent = |r: f64| -orbit.mu * orbit.m / r + 0.5 * orbit.m * (gamma / r).powi(2);
    let mut orbits =
        Chart::new("Orbits of one angular momentum", Axis::linear("x", "m"), Axis::linear("y", "m"))
            .subtitle("attraction μ/r² with μ = 1 m³/s², r²φ̇ = 1 m²/s")
            .equal_aspect()
            .with(Series::markers("centre", [(0.0, 0.0)]));
    let mut levels = Chart::new("Apparent potential", Axis::linear("r", "m"), Axis::linear("energy", "J"))
        .subtitle("−μm/r + mγ²/2r², with the energies of the orbits between their turning points")
        .with(Series::line(
            "apparent potential",
            (0..=460).map(|k| 0.4 + 0.01 * f64::from(k)).map(|r| (r, apparent(r))),
        ));
    for (name, near) in [("circle", 1.0), ("ellipse", 0.75), ("long ellipse", 0.6), ("hyperbola", 0.47)] {
        let start = State::new(0.0, [near, 0.0], [0.0, gamma / (near * near)]);
        let energy = orbit.energy_at(&start);
        // Once round, or out of the picture.
        let mut points = Vec::new();
        let mut far = near;
        let run = integrate(&orbit, Dop853, PiController::tolerance(1e-12), start).until(40.0);
        for at in run.sample((0..=8000).map(|k| 0.005 * f64::from(k))) {
            let at = at?;
            if at.q[1] > std::f64::consts::TAU || at.q[0] > 5.0 {
                break;
            }
            far = f64::max(far, at.q[0]);
            let [x, y] = orbit.place_at(&at).into();
            points.push((x, y));
        }
        if energy > 0.0 {
            // It came from where it goes to.
            let before: Vec<(f64, f64)> = points.iter().rev().map(|(x, y)| (*x, -y)).collect();
            points = [before, points].concat();
        }
        println!("{name}: energy {energy:.4} J, from r = {near} to {far:.3} m");
        orbits = orbits.with(Series::line(name, points));
        levels = levels.with(Series::new(name, [(near, energy), (far, energy)]));
    }
    for (chart, stem) in [(orbits, "central-force"), (levels, "central-force-potential")] {
        chart.write(&folder, stem)?;
        println!("{}", folder.join(format!("{stem}.svg")).display());
    }
    Ok(())
}
