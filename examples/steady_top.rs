//! A symmetric top: the effective potential of its nutation with turning points, both steady precessions, and its
//! frequencies upright, as the spin grows.
//!
//! `cargo run --release --example steady_top`

#[path = "support/mod.rs"]
mod support;

use lagrange_runtime::analysis::{AnalysisError, Reduced, stability_threshold};
use lagrange_runtime::chart::{Axis, Chart, Series};
use lagrange_runtime::prelude::*;
use std::error::Error;

lagrangian! {
    /// The top by Euler's angles.
    pub system Top {
        param m, g, l, I1, I3;
        coord phi, theta, psi;
        T = 0.5 * I1 * (dot(theta).powi(2) + (dot(phi) * theta.sin()).powi(2))
            + 0.5 * I3 * (dot(psi) + dot(phi) * theta.cos()).powi(2);
        V = m * g * l * theta.cos();
    }
}

lagrangian! {
    /// The top by angles that are regular upright: turned by a about x, then by b about the new y, then by its spin.
    pub system Upright {
        param m, g, l, I1, I3;
        coord a, b, psi;
        T = 0.5 * I1 * (dot(b).powi(2) + (dot(a) * b.cos()).powi(2)) + 0.5 * I3 * (dot(psi) + dot(a) * b.sin()).powi(2);
        V = m * g * l * a.cos() * b.cos();
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let top = Top::new(0.5, 9.81, 0.12, 0.008, 0.0011);
    let folder = support::charts()?;

    // Let go at θ = 0.6 while its axis rests: it falls, and rises again.
    let spin = 180.0;
    let start = State::new(0.0, [0.0, 0.6, 0.0], [0.0, 0.0, spin]);
    let p = top.momenta(&start.q, &start.qd, 0.0);
    let reduced = Reduced::new(&top, &[p[0], p[2]])?;
    let energy = top.energy(&start.q, &start.qd, 0.0);
    let turning = reduced.turning_points(energy, 0.1, 3.0)?;
    let steady = reduced.steady(&[0.0, 0.7, 0.0])?;
    println!(
        "turning points {turning:?}; steady at θ = {:.6}, nutation {:.6} rad/s",
        steady.at.q[1],
        steady.small.modes()?.frequency(0)
    );
    let (low, high) = (0.5, 0.95);
    let curve = (0..=300)
        .map(|i| low + (high - low) * f64::from(i) / 300.0)
        .map(|theta| reduced.potential(&[0.0, theta, 0.0]).map(|v| (theta, v)))
        .collect::<Result<Vec<_>, _>>()?;
    Chart::new(
        "Effective potential of a top that is let go",
        Axis::linear("inclination θ", "rad"),
        Axis::linear("energy", "J"),
    )
    .subtitle(format!(
        "spin {spin} rad/s, from θ = 0.6 at rest: it nods between {:.4} and {:.4} rad",
        turning[0], turning[1]
    ))
    .with(Series::line("effective potential", curve))
    .with(Series::line("energy", [(low, energy), (high, energy)]))
    .with(Series::markers("turning points", turning.iter().map(|&theta| (theta, energy))))
    .with(Series::markers(
        "steady precession",
        [(steady.at.q[1], reduced.potential(&[0.0, steady.at.q[1], 0.0])?)],
    ))
    .write(&folder, "effective-potential")?;

    let critical = reduced.thresholds(&[0.0, 0.6, 0.0], 0, 2)?[1] / top.I3;
    println!("steady precession at θ = 0.6 from {critical:.6} rad/s of spin on");

    // Upright: frequencies against spin, a Campbell diagram.
    let upright = Upright::new(top.m, top.g, top.l, top.I1, top.I3);
    let small = |omega: f64| {
        Ok::<_, AnalysisError>(Reduced::new(&upright, &[top.I3 * omega])?.steady(&[0.0; 3])?.small)
    };
    let limit = stability_threshold(small, 50.0, 200.0)?;
    println!("it sleeps upright from {limit:.9} rad/s on");
    let (mut slow, mut fast, mut growth) = (Vec::new(), Vec::new(), Vec::new());
    for i in -300..=300 {
        // Densest at the limit, where the curves are steepest.
        let x = f64::from(i) / 300.0;
        let omega = limit + x * x.abs() * if i < 0 { limit } else { 300.0 - limit };
        let spectrum = small(omega)?.spectrum()?;
        let frequencies = spectrum.frequencies();
        match spectrum.is_stable() {
            true => {
                slow.push((omega, frequencies[0]));
                fast.push((omega, frequencies[1]));
            }
            false => growth.push((omega, spectrum.growth())),
        }
    }
    Chart::new(
        "Campbell diagram of a top that stands upright",
        Axis::linear("spin ω₃", "rad/s"),
        Axis::linear("frequency or rate of growth", "rad/s"),
    )
    .subtitle(format!("it sleeps from ω₃ = 2 √(I₁ m g l) / I₃ = {limit:.3} rad/s on"))
    .with(Series::line("fast precession", fast))
    .with(Series::line("slow precession", slow))
    .with(Series::line("rate of growth, unstable", growth))
    .write(&folder, "campbell-top")?;
    println!("{}", folder.display());
    Ok(())
}
