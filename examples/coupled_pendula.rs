//! Two equal pendula with a weak spring between them hand their swing over to each other and back: beats.
//!
//! `cargo run --release --example coupled_pendula`

#[path = "support/mod.rs"]
mod support;

use lagrange_runtime::chart::{Axis, Chart, Series};
use lagrange_runtime::prelude::*;
use std::error::Error;

lagrangian! {
    /// The spring joins the rods at the distance d below their pivots.
    pub system CoupledPendula {
        param m, l, d, k, g = 9.81;
        coord a, b;
        let stretch = d * (sin(a) - sin(b));
        T = 0.5 * m * l.powi(2) * (dot(a).powi(2) + dot(b).powi(2));
        V = -m * g * l * (cos(a) + cos(b)) + 0.5 * k * stretch.powi(2);
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let pendula = CoupledPendula::new(0.5, 0.9, 0.4, 1.2);
    let start = State::new(0.0, [0.1, 0.0], [0.0, 0.0]);

    // In phase the spring idles; out of phase it is stretched twice.
    let slow = (pendula.g / pendula.l).sqrt();
    let fast = (slow * slow + 2.0 * pendula.k * pendula.d.powi(2) / (pendula.m * pendula.l.powi(2))).sqrt();
    let handover = std::f64::consts::PI / (fast - slow);
    println!("frequencies {slow:.6} and {fast:.6} rad/s; the swing changes over in {handover:.3} s");

    let end = 50.0;
    let run = integrate(&pendula, Dop853, PiController::tolerance(1e-10), start).until(end);
    let frames =
        run.sample((0..=2000).map(|k| end * f64::from(k) / 2000.0)).collect::<Result<Vec<_>, _>>()?;
    let swing = |k: usize, shift: f64| frames.iter().map(move |at| (at.t, at.q[k].to_degrees() + shift));
    let folder = support::charts()?;
    Chart::new(
        "Beats of two coupled pendula",
        Axis::linear("time", "s"),
        Axis::linear("angle, of the second less 15°", "°"),
    )
    .subtitle(format!("the first is let go at 0.1 rad; theory: over to the second in {handover:.1} s"))
    .with(Series::line("first", swing(0, 0.0)))
    .with(Series::line("second", swing(1, -15.0)))
    .write(&folder, "coupled-pendula")?;
    println!("{}", folder.join("coupled-pendula.svg").display());
    Ok(())
}
