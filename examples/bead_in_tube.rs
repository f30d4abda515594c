//! Bead in a spinning circular tube: its phase portrait below and above the speed at which the bottom loses its
//! stability to two places beside it.
//!
//! `cargo run --release --example bead_in_tube`

#[path = "support/mod.rs"]
mod support;

use lagrange_runtime::chart::{Axis, Chart, Series};
use lagrange_runtime::prelude::*;
use std::error::Error;

lagrangian! {
    /// θ from the downward vertical, about which the tube turns.
    pub system Bead {
        param m, a, omega, g = 9.81;
        coord theta;
        coord phi = omega * t;
        let x = a * sin(theta) * cos(phi);
        let y = a * sin(theta) * sin(phi);
        let z = -a * cos(theta);
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2));
        V = m * g * z;
    }
}

/// One motion, with a gap after it, as points of the phase plane.
fn orbit(bead: &Bead, q: f64, qd: f64) -> Result<Vec<(f64, f64)>, Box<dyn Error>> {
    let mut points = Vec::new();
    // Forwards and backwards: the equations do not change with the sign of time.
    for sign in [1.0, -1.0] {
        let run = integrate(bead, Dop853, PiController::tolerance(1e-10), State::new(0.0, [q], [sign * qd]))
            .until(6.0);
        for at in run.sample((0..=1200).map(|k| 0.005 * f64::from(k))) {
            let at = at?;
            let inside = at.q[0].abs() <= 3.2;
            points.push(if inside { (at.q[0], sign * at.qd[0]) } else { (f64::NAN, f64::NAN) });
        }
        points.push((f64::NAN, f64::NAN));
    }
    Ok(points)
}

fn main() -> Result<(), Box<dyn Error>> {
    let (m, a, g) = (0.4, 0.5, 9.81f64);
    let critical = (g / a).sqrt();
    let folder = support::charts()?;
    for (name, ratio) in [("below", 0.8), ("above", 1.5)] {
        let bead = Bead::new(m, a, ratio * critical);
        let rest = (1.0 / (ratio * ratio)).min(1.0).acos();
        let (mut swings, mut separatrices) = (Vec::new(), Vec::new());
        for k in 1..=7 {
            swings.extend(orbit(&bead, rest + 0.13 * f64::from(k) * (3.1 - rest), 0.0)?);
            if rest > 0.0 {
                swings.extend(orbit(&bead, -rest - 0.13 * f64::from(k) * (3.1 - rest), 0.0)?);
            }
        }
        for qd in [14.5, 17.0, 20.0] {
            swings.extend(orbit(&bead, 0.0, qd)?);
            swings.extend(orbit(&bead, 0.0, -qd)?);
        }
        // Beside the unstable places: the top always, the bottom above the critical speed.
        separatrices.extend(orbit(&bead, std::f64::consts::PI - 1e-6, 0.0)?);
        separatrices.extend(orbit(&bead, 1e-6 - std::f64::consts::PI, 0.0)?);
        if rest > 0.0 {
            separatrices.extend(orbit(&bead, 1e-5, 0.0)?);
            separatrices.extend(orbit(&bead, -1e-5, 0.0)?);
        }
        let stable = if rest > 0.0 { vec![(-rest, 0.0), (rest, 0.0)] } else { vec![(0.0, 0.0)] };
        println!("ω = {ratio} √(g/a): rests at θ = ±{rest:.4} rad");
        Chart::new(
            format!("Bead in a spinning tube, {name} the critical speed"),
            Axis::linear("θ", "rad"),
            Axis::linear("θ̇", "rad/s"),
        )
        .subtitle(format!("ω = {ratio} √(g/a), radius a = {a} m"))
        .with(Series::line("motions", swings))
        .with(Series::line("separatrix", separatrices))
        .with(Series::markers("stable rest", stable))
        .write(&folder, &format!("bead-in-tube-{name}"))?;
        println!("{}", folder.join(format!("bead-in-tube-{name}.svg")).display());
    }
    Ok(())
}
