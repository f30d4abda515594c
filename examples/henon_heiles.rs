//! Hénon and Heiles' system: a Poincaré section, and Lyapunov exponents by two methods.
//!
//! `cargo run --release --example henon_heiles`

#[path = "support/mod.rs"]
mod support;

use lagrange_runtime::Gradient;
use lagrange_runtime::analysis::{ByGradients, Measurement, lyapunov_by_two_trajectories, lyapunov_spectrum};
use lagrange_runtime::chart::{Axis, Chart, Series};
use lagrange_runtime::prelude::*;
use std::error::Error;

lagrangian! {
    /// A star in the field of a galaxy (Hénon and Heiles 1964).
    pub system HenonHeiles {
        coord x, y;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = 0.5 * (x.powi(2) + y.powi(2)) + x.powi(2) * y - y.powi(3) / 3.0;
    }
}

/// The start on the section x = 0 with this energy.
fn start(energy: f64, y: f64, yd: f64) -> Option<State<f64, 2>> {
    let rest = 2.0 * energy - yd * yd - y * y + 2.0 / 3.0 * y.powi(3);
    (rest > 0.0).then(|| State::new(0.0, [0.0, y], [rest.sqrt(), yd]))
}

fn main() -> Result<(), Box<dyn Error>> {
    let system = HenonHeiles::<f64>::default();
    let energy = 0.125;
    let mut chart = Chart::new(
        "Poincaré section of Hénon and Heiles' system",
        Axis::linear("y", ""),
        Axis::linear("ẏ", ""),
    )
    .subtitle("energy 1/8, passages through x = 0 with ẋ > 0; islands, and a sea between them")
    .equal_aspect();
    let starts = [
        (-0.15, 0.0),
        (0.05, 0.0),
        (0.2, 0.0),
        (0.29, 0.0),
        (0.5, 0.0),
        (0.0, 0.35),
        (0.0, -0.35),
        (0.0, 0.12),
    ];
    for (y, yd) in starts {
        let from = start(energy, y, yd).ok_or("the start has more energy than there is")?;
        let run = integrate(&system, Dop853, PiController::tolerance(1e-10), from).until(6000.0);
        let section = run
            .events(Event::rising(|s: &State<f64, 2>| s.q[0]))
            .map(|passage| passage.map(|p| (p.state.q[1], p.state.qd[1])))
            .collect::<Result<Vec<_>, _>>()?;
        chart = chart.with(Series::markers("", section));
    }
    let folder = support::charts()?;
    chart.write(&folder, "poincare-henon-heiles")?;

    let how = Measurement { transient: 100.0, interval: 5.0, intervals: 4000 };
    let flow = ByGradients::new(system.map(Gradient::<f64, 4>::constant), 1e-10);
    let (method, control) = (Taylor, TaylorController::tolerance(1e-10));
    for (name, y) in [("sea", -0.15), ("island", 0.29)] {
        let from = start(energy, y, 0.0).ok_or("the start has more energy than there is")?;
        let all = lyapunov_spectrum(&flow, &from, &how)?;
        let two = lyapunov_by_two_trajectories(&system, method, control, &from, 1e-8, &how)?;
        println!(
            "{name}: {:.5} ± {:.5} by the variational equations, {:.5} ± {:.5} by two trajectories",
            all[0].value, all[0].error, two.value, two.error
        );
    }
    println!("{}", folder.join("poincare-henon-heiles.png").display());
    Ok(())
}
