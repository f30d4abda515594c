//! The chapter, checked: one line, and a place in a chart of errors, for each of its 95 systems and statements.
//!
//! ```text
//! cargo run --release --example chapter11
//! ```
//!
//! The systems, their reference digits and all comparisons are those of `tests/golden`. The program fails if a
//! comparison fails or a row of the catalogue is missing.

#[path = "../../tests/golden/main.rs"]
mod golden;
#[path = "../support/mod.rs"]
mod support;

use comfy_table::{CellAlignment, Table, presets};
use golden::{CATALOGUE, FILES, Kind, Row};
use lagrange_runtime::chart::{Axis, Chart, Series};
use std::error::Error;
use std::process::ExitCode;

const LEGEND: &str = "\
states, motion  largest error against the reference digits, at given states and along motions, in proportion to the terms
equations       largest residue of printed equations, equations derived by hand and identities, likewise
of bound        largest error of all comparisons of the row, as a part of what is allowed
facts           s scleronomic  c conservative  p separable  m constant inertia  q quadratic  l linear; ignorable";

/// Errors of one kind by the number of the row.
type Errors = Vec<(f64, f64)>;

const SORTS: [(&str, &[Kind]); 4] = [
    ("equations and identities", &[Kind::Equation, Kind::Identity]),
    ("accelerations at given states", &[Kind::Digits]),
    ("motions", &[Kind::Motion]),
    ("conserved quantities, other results", &[Kind::Conserved, Kind::Special]),
];

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let mut rows: Vec<Row> = FILES.iter().flat_map(|rows| rows()).collect();
    let mut table = Table::new();
    table.load_style(presets::NOTHING);
    table.set_header([
        "",
        "row",
        "dof",
        "facts",
        "states",
        "motion",
        "equations",
        "of bound",
        "result",
        "found",
        "reference",
        "",
    ]);
    let (mut failed, mut missing) = (Vec::new(), Vec::new());
    let mut errors: [Errors; 4] = Default::default();
    for (index, id) in CATALOGUE.iter().enumerate() {
        let number = (index + 1).to_string();
        let Some(position) = rows.iter().position(|row| row.id == *id) else {
            let mut line: [String; 12] = Default::default();
            [line[0], line[1], line[11]] = [number, (*id).to_owned(), "missing".to_owned()];
            table.add_row(line);
            missing.push(*id);
            continue;
        };
        let row = rows.swap_remove(position);
        table.add_row(line(number, &row));
        for (errors, (_, kinds)) in errors.iter_mut().zip(SORTS) {
            errors.extend(row.error(kinds).map(|error| ((index + 1) as f64, error)));
        }
        if !row.ok() {
            failed.push(row);
        }
    }
    for column in [0, 2, 4, 5, 6, 7, 9, 10] {
        if let Some(column) = table.column_mut(column) {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    println!("{table}\n\n{LEGEND}\n");

    let right = CATALOGUE.len() - failed.len() - missing.len();
    println!(
        "{right} of {} rows hold, {} fail, {} are missing",
        CATALOGUE.len(),
        failed.len(),
        missing.len()
    );
    for row in &failed {
        for finding in row.findings.iter().filter(|finding| !finding.ok()) {
            println!(
                "{}: {}: off by {:.1e}, allowed {:.1e}",
                row.id, finding.what, finding.error, finding.allowed
            );
        }
    }
    // A row that the catalogue does not know is a slip of its name.
    for row in &rows {
        println!("{}: not in the catalogue, or twice in the files", row.id);
    }
    let folder = support::charts()?;
    chart(errors).write(&folder, "chapter11")?;
    println!("{}", folder.join("chapter11.svg").display());
    Ok(if right == CATALOGUE.len() && rows.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Largest errors of all rows. Those that are 0 have a place below all others.
fn chart(errors: [Errors; 4]) -> Chart {
    const NONE: f64 = 1e-18;
    let last = CATALOGUE.len() as f64;
    let chart = Chart::new(
        "A chapter of mechanics, checked",
        Axis::linear("row of the catalogue", ""),
        Axis::log("largest error in proportion to the terms", ""),
    )
    .subtitle("95 systems and statements against reference digits and equations by hand; an error of 0 is drawn at 1e-18")
    .with(Series::line("rounding, 2⁻⁵³", [(1.0, 0.5 * f64::EPSILON), (last, 0.5 * f64::EPSILON)]));
    SORTS.into_iter().zip(errors).fold(chart, |chart, ((name, _), errors)| {
        chart.with(Series::markers(name, errors.into_iter().map(|(row, error)| (row, error.max(NONE)))))
    })
}

/// One row as the cells of the table.
fn line(number: String, row: &Row) -> [String; 12] {
    let error = |kinds: &[Kind]| row.error(kinds).map_or(String::new(), |error| format!("{error:.0e}"));
    let special = row.special.as_ref();
    let digits = |value: f64| format!("{value:.10}");
    [
        number,
        row.id.to_owned(),
        row.facts.map_or(String::new(), |facts| facts.degrees_of_freedom().to_string()),
        row.facts.map_or(String::new(), facts),
        error(&[Kind::Digits]),
        error(&[Kind::Motion]),
        error(&[Kind::Equation, Kind::Identity]),
        format!("{:.0}%", 100.0 * row.share()),
        special.map_or(String::new(), |special| special.name.clone()),
        special.map_or(String::new(), |special| digits(special.value)),
        special.map_or(String::new(), |special| digits(special.reference)),
        if row.ok() { "ok" } else { "FAILS" }.to_owned(),
    ]
}

/// The facts that hold by their letters, and the ignorable coordinates.
fn facts(facts: lagrange_runtime::Facts) -> String {
    let letters = [
        ('s', facts.scleronomic),
        ('c', facts.conservative),
        ('p', facts.separable),
        ('m', facts.constant_inertia),
        ('q', facts.quadratic),
        ('l', facts.linear),
    ];
    let letters: String = letters.iter().map(|(letter, holds)| if *holds { *letter } else { '·' }).collect();
    facts.ignorable.iter().fold(letters, |line, &k| format!("{line} {}", facts.coordinates[k]))
}
