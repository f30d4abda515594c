//! A chain of five pendulums joined by springs: its normal modes, and how it answers when the first is driven.
//!
//! `cargo run --release --example small_vibrations`

#[path = "support/mod.rs"]
mod support;

use lagrange_runtime::analysis::{Complex, DVector, small_vibrations};
use lagrange_runtime::chart::{Axis, Chart, Series};
use lagrange_runtime::prelude::*;
use std::error::Error;

lagrangian! {
    /// Pendulums in a row, each joined to the next by a spring at its bob.
    pub system Row {
        const N = 5;
        param m, l, k, c, g = 9.81;
        coord theta: [N];
        T = (0..N).map(|i| 0.5 * m * (l * dot(theta[i])).powi(2)).sum();
        V = (0..N).map(|i| -m * g * l * theta[i].cos()).sum()
            + (1..N).map(|i| 0.5 * k * (l * (theta[i].sin() - theta[i - 1].sin())).powi(2)).sum();
        D = (0..N).map(|i| 0.5 * c * (l * dot(theta[i])).powi(2)).sum();
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let row = Row::new(0.4, 0.6, 3.0, 0.04);
    let small = small_vibrations(&row, &[0.0; 5])?;
    let modes = small.modes()?;
    println!("{modes}");
    let spectrum = small.spectrum()?;
    for k in (0..10).step_by(2) {
        println!(
            "natural {:.6}/s, damped {:.6}/s, damping ratio {:.5}",
            spectrum.natural_frequency(k),
            spectrum.damped_frequency(k),
            spectrum.damping_ratio(k)
        );
    }
    let folder = support::charts()?;

    let mut shapes = Chart::new(
        "Normal modes of five coupled pendulums",
        Axis::linear("pendulum", ""),
        Axis::linear("mode, its shape drawn about its number", ""),
    )
    .subtitle("m = 0.4 kg, l = 0.6 m, springs of 3 N/m between the bobs");
    for k in 0..modes.len() {
        let shape = modes.shape(k);
        let points = shape.iter().enumerate().map(|(i, x)| (i as f64 + 1.0, k as f64 + 1.0 + 0.4 * x));
        shapes = shapes.with(Series::new(format!("{}: ω = {:.3} rad/s", k + 1, modes.frequency(k)), points));
    }
    shapes.write(&folder, "mode-shapes")?;

    let mut response = Chart::new(
        "Frequency response: the first of five coupled pendulums is driven",
        Axis::linear("driving frequency", "rad/s"),
        Axis::log("amplitude", "rad"),
    )
    .subtitle("moment of 0.01 N m at the first; damping 0.04 kg/s");
    let moment = DVector::from_fn(5, |i, _| Complex::new(if i == 0 { 0.01 } else { 0.0 }, 0.0));
    for i in [0, 2, 4] {
        let points = (0..=1200)
            .map(|j| {
                let omega = 3.0 + 5.5 * f64::from(j) / 1200.0;
                small.frequency_response(omega, &moment).map(|x| (omega, x[i].norm()))
            })
            .collect::<Result<Vec<_>, _>>()?;
        response = response.with(Series::line(format!("pendulum {}", i + 1), points));
    }
    response.write(&folder, "frequency-response")?;
    println!("{}", folder.display());
    Ok(())
}
