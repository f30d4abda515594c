//! Two equal masses between walls, joined by equal springs: the masses share both modes, the normal coordinates have
//! one each.
//!
//! `cargo run --release --example normal_modes`

#[path = "support/mod.rs"]
mod support;

use lagrange_runtime::chart::{Axis, Chart, Series};
use lagrange_runtime::prelude::*;
use std::error::Error;

lagrangian! {
    /// Displacements from rest.
    pub system Chain {
        param m, k;
        coord x1, x2;
        T = 0.5 * m * (dot(x1).powi(2) + dot(x2).powi(2));
        V = 0.5 * k * (x1.powi(2) + (x2 - x1).powi(2) + x2.powi(2));
        observe modes = [(x1 + x2) / 2, (x1 - x2) / 2];
    }
}

/// Two quantities, by name.
type Names<'a> = [(&'a str, &'a dyn Fn(&State<f64, 2>) -> f64); 2];

fn main() -> Result<(), Box<dyn Error>> {
    let chain = Chain::new(1.3, 2.7);
    let start = State::new(0.0, [0.1, 0.0], [0.0, 0.0]);
    let end = 16.0;

    // Each normal coordinate falls through 0 after a quarter of its period.
    for (mode, square) in [(0, 1.0), (1, 3.0)] {
        let run = integrate(&chain, Dop853, PiController::tolerance(1e-12), start).until(end);
        let zero = Event::falling(|s: &State<f64, 2>| chain.modes_at(s)[mode]).terminal();
        let quarter = run.events(zero).next().ok_or("it does not oscillate")??.state.t;
        let found = std::f64::consts::FRAC_PI_2 / quarter;
        println!(
            "mode {}: ω = {found:.10}, √({square} k/m) = {:.10}",
            mode + 1,
            (square * chain.k / chain.m).sqrt()
        );
    }

    let run = integrate(&chain, Dop853, PiController::tolerance(1e-12), start).until(end);
    let frames = run.sample((0..=800).map(|k| end * f64::from(k) / 800.0)).collect::<Result<Vec<_>, _>>()?;
    let modes = |at: &State<f64, 2>| chain.modes_at(at);
    let masses: Names = [("x₁", &|at| at.q[0]), ("x₂", &|at| at.q[1])];
    let coordinates: Names = [("(x₁ + x₂)/2", &|at| modes(at)[0]), ("(x₁ − x₂)/2", &|at| modes(at)[1])];
    let folder = support::charts()?;
    for (what, series, stem) in [
        ("what the masses do", masses, "normal-modes-masses"),
        ("what the modes do", coordinates, "normal-modes"),
    ] {
        let mut chart = Chart::new(
            format!("Two masses between walls: {what}"),
            Axis::linear("time", "s"),
            Axis::linear("displacement", "cm"),
        )
        .subtitle(
            "m = 1.3 kg, three springs k = 2.7 N/m; the left mass is let go at 10 cm, the right one at rest",
        );
        for (name, value) in series {
            chart = chart.with(Series::line(name, frames.iter().map(|at| (at.t, 100.0 * value(at)))));
        }
        chart.write(&folder, stem)?;
        println!("{}", folder.join(format!("{stem}.svg")).display());
    }
    Ok(())
}
