//! Speed against accuracy: every method that fits, on four systems whose motion is known to the last digit.
//!
//! ```text
//! cargo run --release --example work_precision
//! ```
//!
//! Each method runs over a range of step sizes or tolerances until its error no longer falls. The error is that of the
//! final state, against a reference that no method here had a part in: closed forms, or digits computed elsewhere. What
//! comes out, under `target/charts`: for each system a chart of error against time and one of error against evaluations
//! of the right-hand side (SVG, PNG, CSV), one CSV file with all numbers, and on the screen the fastest method for each
//! digit of accuracy.
//!
//! | file | concern |
//! |---|---|
//! | `systems.rs` | the four systems, as their energies |
//! | `problems.rs` | where each starts and where exactly it ends; what an error is |
//! | `methods.rs` | which methods fit a system (the compiler decides), with which steps and tolerances |
//! | `measure.rs` | runs and times |
//! | `report.rs` | charts, tables, CSV |

mod measure;
mod methods;
mod problems;
mod report;
#[path = "../support/mod.rs"]
mod support;
mod systems;

use measure::{Record, measure};
use problems::{Problem, double_pendulum, kepler, pendulum, top};
use std::error::Error;
use std::path::Path;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = support::charts()?;
    let mut files = Vec::new();
    let mut all = Vec::new();

    let problem = pendulum();
    let sweeps = [problem.general(), problem.splitting()].into_iter().flatten();
    all.extend(report(&problem, measure(&problem, sweeps.collect()), &folder, &mut files)?);
    let problem = kepler()?;
    all.extend(report(&problem, measure(&problem, problem.general()), &folder, &mut files)?);
    let problem = double_pendulum()?;
    all.extend(report(&problem, measure(&problem, problem.general()), &folder, &mut files)?);
    let problem = top()?;
    all.extend(report(&problem, measure(&problem, problem.general()), &folder, &mut files)?);

    let raw = folder.join("work-precision.csv");
    std::fs::write(&raw, report::csv(&all))?;
    println!("All numbers: {}", raw.display());
    println!("Charts (.svg, .png, .csv):");
    for file in files {
        println!("  {}", folder.join(file).display());
    }
    Ok(())
}

/// Draws the charts of one problem, whose names it adds to `files`, and prints its table.
fn report<Sys, const N: usize>(
    problem: &Problem<Sys, N>,
    records: Vec<Record>,
    folder: &Path,
    files: &mut Vec<String>,
) -> Result<Vec<Record>, Box<dyn Error>> {
    println!("{}: {}", problem.name, problem.motion);
    println!("Reference: {}", problem.reference);
    println!("{}\n", report::table(&records));
    files.extend(report::charts(problem, &records, folder)?);
    Ok(records)
}
