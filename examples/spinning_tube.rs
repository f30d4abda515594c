//! A bead in a tube bent to a circle that spins about its vertical diameter: where it can ride, as the spin grows.
//!
//! `cargo run --release --example spinning_tube`

#[path = "support/mod.rs"]
mod support;

use lagrange_runtime::analysis::{Branch, Heading, Path, follow};
use lagrange_runtime::chart::{Axis, Chart, Series};
use lagrange_runtime::prelude::*;
use std::error::Error;

lagrangian! {
    /// θ from the lowest point.
    pub system Bead {
        param a, omega, g = 9.81;
        coord theta;
        T = 0.5 * a.powi(2) * (dot(theta).powi(2) + (omega * sin(theta)).powi(2));
        V = -g * a * cos(theta);
    }
}

/// The parts of a branch that are stable, or those that are not.
fn part(branch: &Branch, stable: bool) -> impl Iterator<Item = (f64, f64)> + '_ {
    let fits = move |negative: usize| (negative == 0) == stable;
    branch.points.iter().map(move |p| (p.parameter, if fits(p.negative) { p.q[0] } else { f64::NAN }))
}

fn main() -> Result<(), Box<dyn Error>> {
    let bead = Bead::new(0.5, 0.0);
    let family = |omega: Dual<f64>| Bead { omega, ..bead.map(Dual::constant) };
    let path = Path { range: (0.0, 10.0), step: 0.05, steps: 2000 };
    let bottom = follow(&family, &[0.0], 0.01, &Heading::Up, &path)?;
    let top = follow(&family, &[std::f64::consts::PI], 0.01, &Heading::Up, &path)?;
    let pitchfork = bottom.bifurcations.first().ok_or("no bifurcation found")?;
    println!(
        "{:?} at ω = {:.15}, √(g/a) = {:.15}",
        pitchfork.kind,
        pitchfork.parameter,
        (bead.g / bead.a).sqrt()
    );
    let mut chart = Chart::new(
        "Relative equilibria of a bead in a spinning tube",
        Axis::linear("spin ω", "rad/s"),
        Axis::linear("angle θ from the lowest point", "rad"),
    )
    .subtitle(format!("a = 0.5 m; pitchfork at ω = √(g/a) = {:.4} rad/s", pitchfork.parameter))
    .with(Series::line("bottom, stable", part(&bottom, true)))
    .with(Series::line("bottom, unstable", part(&bottom, false)))
    .with(Series::line("top, unstable", part(&top, false)));
    for (name, sign) in [("aside, stable", 1.0), ("aside on the other side, stable", -1.0)] {
        let heading = Heading::Along(&pitchfork.direction * sign);
        let aside = follow(&family, &[0.0], pitchfork.parameter, &heading, &path)?;
        chart = chart.with(Series::line(name, part(&aside, true)));
    }
    let folder = support::charts()?;
    chart.write(&folder, "bifurcation-spinning-tube")?;
    println!("{}", folder.join("bifurcation-spinning-tube.png").display());
    Ok(())
}
