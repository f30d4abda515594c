//! Gyrocompass: a spinning rotor whose axis is held level turns to the north, the quicker the better it is damped.
//!
//! `cargo run --release --example gyrocompass`

#[path = "support/mod.rs"]
mod support;

use lagrange_runtime::chart::{Axis, Chart, Series};
use lagrange_runtime::prelude::*;
use std::error::Error;

lagrangian! {
    /// θ, turn of the rotor; α, drift of its axis from north; earth, the angular speed of the Earth; lam, latitude.
    pub system Gyrocompass {
        param I11, I22, lam, nu, earth = 7.292e-5;
        coord theta, alpha;
        let north = earth * cos(lam);
        let spin = dot(theta) + north * cos(alpha);
        let drift = dot(alpha) + earth * sin(lam);
        T = 0.5 * I11 * (north * sin(alpha)).powi(2) + 0.5 * I22 * spin.powi(2) + 0.5 * I11 * drift.powi(2);
        V = 0;
        D = I11 * nu * dot(alpha).powi(2);
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let (i11, i22, latitude, rate) = (0.02, 0.028, 48f64.to_radians(), 2000.0);
    let undamped = Gyrocompass::new(i11, i22, latitude, 0.0);
    // p² of small drift, I₂₂ ω₀ Ω cos λ/I₁₁.
    let p = (i22 / i11 * rate * undamped.earth * latitude.cos()).sqrt();
    println!("period of small undamped drift {:.2} s", std::f64::consts::TAU / p);

    let end = 120.0;
    let folder = support::charts()?;
    let mut chart = Chart::new(
        "A gyrocompass finds north",
        Axis::linear("time", "s"),
        Axis::linear("drift from north", "°"),
    )
    .subtitle("latitude 48°, rotor at 2000 rad/s, let go 60° off; ν: rate of damping, p: frequency without");
    for (name, ratio) in [("no damping", 0.0), ("ν = 0.1 p", 0.1), ("ν = 0.3 p", 0.3), ("ν = p", 1.0)] {
        let compass = Gyrocompass { nu: ratio * p, ..undamped };
        let start = State::new(0.0, [0.0, 60f64.to_radians()], [rate, 0.0]);
        let run = integrate(&compass, Dop853, PiController::tolerance(1e-10), start).until(end);
        let frames =
            run.sample((0..=800).map(|k| end * f64::from(k) / 800.0)).collect::<Result<Vec<_>, _>>()?;
        let last = frames.last().map_or(f64::NAN, |at| at.q[1].to_degrees());
        println!("{name}: {last:.4}° after {end} s");
        chart = chart.with(Series::line(name, frames.iter().map(|at| (at.t, at.q[1].to_degrees()))));
    }
    chart.write(&folder, "gyrocompass")?;
    println!("{}", folder.join("gyrocompass.svg").display());
    Ok(())
}
