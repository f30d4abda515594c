//! Outputs of an ensemble as tables: the same 5000 rows as Parquet and as comma-separated values, in the folder given
//! (or the current one). `tests/tables/read.py` of the workspace opens both by pandas and polars, and compares them
//! with the motion known in closed form.
//!
//! `cargo run -p lagrange-runtime --features parquet --example tables -- FOLDER`

use lagrange_runtime::ensemble::{Collect, Ensemble, Moments, Parquet, Sobol, of};
use lagrange_runtime::prelude::*;
use std::error::Error;
use std::path::PathBuf;

lagrangian! {
    /// A mass on a spring.
    system Oscillator {
        param omega;
        coord x: length;
        T = 0.5 * dot(x).powi(2);
        V = 0.5 * (omega * x).powi(2);
    }
}

/// Of each oscillator its ω, its position at t = 1, and when it first passes through 0.
const NAMES: [&str; 3] = ["omega", "x", "first_zero"];

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args_os().nth(1).map_or_else(|| PathBuf::from("."), PathBuf::from);
    let study = Ensemble::new(Sobol::<1>::seed(1), 5000, |[u]| {
        (Oscillator::new(0.5 + 3.0 * u), State::new(0.0, [1.0], [0.0]))
    })
    .integrate(Dop853, PiController::tolerance(1e-12), 1.0);

    let mut file = Parquet::create(folder.join("oscillators.parquet"), &NAMES)?;
    let outcome = study.stream(
        |oscillator, run| {
            let zero = run.clone().events(Event::falling(|s| s.q[0])).next().transpose()?;
            Ok((oscillator.omega, run.final_state()?.q[0], zero.map(|zero| zero.state.t)))
        },
        (of(|output: &(f64, f64, Option<f64>)| output.1, Moments), Collect),
        |index, output| file.row(index, output),
    )?;
    file.finish()?;
    outcome.statistic.1.write_csv(folder.join("oscillators.csv"), &NAMES)?;
    println!("mean position {}", outcome.statistic.0.mean());
    Ok(())
}
