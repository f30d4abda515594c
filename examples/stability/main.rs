//! Limits of methods: the largest step of each, and the outcome of each in hard scenes.
//!
//! ```text
//! cargo run --release --example stability
//! ```
//!
//! Every scene has a truth that no method had a part in. Under `target/charts`: a map of method by scene
//! (`stability-map`: SVG, PNG, CSV), and all cells with the words of their failures (`stability-cells.csv`).
//!
//! | file | concern |
//! |---|---|
//! | `systems.rs` | the systems, as their energies |
//! | `limits.rs` | the largest steps, by theory and as measured |
//! | `scenes.rs` | hard scenes, their truths, and what comes of them |
//! | `linkages.rs` | those of linkages with redundant constraints or dead centres |

mod limits;
mod scenes;
#[path = "../support/mod.rs"]
mod support;
mod systems;
#[cfg(test)]
mod tests;

use comfy_table::{Table, presets};
use lagrange_runtime::chart::{Cell, Map};
use lagrange_runtime::prelude::*;
use limits::{Limit, Measured};
use scenes::{METHODS, Outcome, Row};
use std::error::Error;
use std::fmt::Write as _;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = support::charts()?;
    println!("The largest steps, as hω on an oscillator and h|λ| on an overdamped one\n");
    println!("{}\n", table_of_limits(&limits::limits()));
    let rows = scenes::rows(false);
    println!("{}\n", table_of_scenes(&rows));
    map(&rows).write(&folder, "stability-map")?;
    let cells = folder.join("stability-cells.csv");
    support::write(&cells, csv(&rows))?;
    println!("Map (.svg, .png, .csv): {}", folder.join("stability-map").display());
    println!("All cells: {}", cells.display());
    Ok(())
}

fn table_of_limits(limits: &[Limit]) -> Table {
    let mut table = Table::new();
    table.load_style(presets::ASCII_MARKDOWN);
    table.set_header(["method", "axis", "theory", "measured", "agree"]);
    for limit in limits {
        let number = |x: f64| if x.is_finite() { format!("{x:.4}") } else { "none".into() };
        let measured = match limit.measured {
            Measured::Grows(h) => number(h),
            Measured::Never => "none".into(),
            Measured::Fails(h, failure) => format!("{} from {h:.2}", name(&failure)),
        };
        let theory = limit.theory.map_or("—".into(), number);
        let agree = if limit.agrees() { "yes" } else { "NO" };
        table.add_row([limit.method, limit.axis, &theory, &measured, agree]);
    }
    table
}

/// The scenes down, what came of them in counts across.
fn table_of_scenes(rows: &[Row]) -> Table {
    let mut table = Table::new();
    table.load_style(presets::ASCII_MARKDOWN);
    table.set_header([
        "scene",
        "truth",
        "correct",
        "step too long",
        "failure",
        "unexpected failure",
        "silently wrong",
    ]);
    for row in rows {
        let names = |pick: fn(&Outcome) -> bool| {
            let picked = row.cells.iter().filter(|(_, outcome)| pick(outcome));
            picked.map(|(method, _)| *method).collect::<Vec<_>>()
        };
        table.add_row([
            row.name.clone(),
            row.truth.to_owned(),
            names(|o| matches!(o, Outcome::Correct(_))).len().to_string(),
            names(|o| matches!(o, Outcome::StepTooLong(_))).len().to_string(),
            names(|o| matches!(o, Outcome::Failed { .. })).len().to_string(),
            unexpected(row).join(", "),
            names(|o| matches!(o, Outcome::SilentlyWrong(_))).join(", "),
        ]);
    }
    table
}

/// Methods that fail in another way than the scene allows, or that do not notice that there is no solution.
fn unexpected(row: &Row) -> Vec<&'static str> {
    let wrong = row.cells.iter().filter(|(_, outcome)| match outcome {
        Outcome::Failed { failure, .. } => !(row.expected)(failure),
        Outcome::Correct(_) => row.singular,
        _ => false,
    });
    wrong.map(|(method, _)| *method).collect()
}

fn map(rows: &[Row]) -> Map {
    let mut map = Map::new("What methods make of hard scenes", METHODS)
        .subtitle("Error of each run against an independent truth, or the failure that ended it")
        .legend(
            "Columns with “h” have equal steps. Such a method promises an order of convergence and, if it is symplectic, \
             bounded energy errors for steps short enough; it cannot know that its step is too long, and a large error \
             there is not announced. The others estimate their error: where theirs is beyond the bound of the scene \
             without a failure, the cell is black.",
        )
        .legend(
            "∞: the run went on through a singularity beyond which there is no solution. Kapitza pendulum: 0e0 is the \
             right verdict, 1e0 the wrong one. Runs may attempt 100 000 steps (BudgetUsedUp). Twelve parallelograms and \
             the scissors lifts are run by four methods.",
        );
    for row in rows {
        let cells = METHODS.map(|method| {
            match row.cells.iter().find(|(name, _)| *name == method).map(|(_, outcome)| outcome) {
                None => Cell::Empty,
                Some(Outcome::Correct(error) | Outcome::StepTooLong(error)) => Cell::Error(*error),
                Some(Outcome::SilentlyWrong(error)) => Cell::Alarm(*error),
                Some(Outcome::Failed { failure, .. }) => Cell::Failure(name(failure)),
            }
        });
        map = map.with(&row.name, cells);
    }
    map
}

/// The variant alone.
fn name(failure: &Failure) -> String {
    failure.name().to_owned()
}

fn csv(rows: &[Row]) -> String {
    let mut csv = String::from("scene,truth,bound,method,outcome,error,message\n");
    let quoted = |text: &str| format!("\"{}\"", text.replace('"', "\"\""));
    for row in rows {
        for (method, outcome) in &row.cells {
            let (kind, error, message) = match outcome {
                Outcome::Correct(error) => ("correct", Some(*error), String::new()),
                Outcome::StepTooLong(error) => ("step too long", Some(*error), String::new()),
                Outcome::SilentlyWrong(error) => ("silently wrong", Some(*error), String::new()),
                Outcome::Failed { failure, late } => ("failure", *late, failure.to_string()),
            };
            let error = error.map_or(String::new(), |error| format!("{error:e}"));
            let (scene, truth, message) = (quoted(&row.name), quoted(row.truth), quoted(&message));
            let (bound, method) = (row.bound, quoted(method));
            let _ = writeln!(csv, "{scene},{truth},{bound:e},{method},{kind},{error},{message}");
        }
    }
    csv
}
