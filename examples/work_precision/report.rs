//! What was measured, as charts, tables and CSV.

use crate::measure::Record;
use crate::problems::{ERROR, Problem};
use comfy_table::{CellAlignment, Table, presets};
use lagrange_runtime::chart::{Axis, ChartError};
use lagrange_runtime::work_precision::{Cost, Reading, Run, Standing, chart, ranking};
use std::fmt::Write as _;
use std::path::Path;

/// Larger errors say nothing but "wrong". A curve is drawn from where a method's errors stay below this.
const LARGEST_DRAWN: f64 = 0.3;

/// Writes error against time and error against evaluations, and gives their names.
pub fn charts<Sys, const N: usize>(
    problem: &Problem<Sys, N>,
    records: &[Record],
    folder: &Path,
) -> Result<[String; 2], ChartError> {
    let drawn = drawn(records);
    let title = format!("{}: error at the end against cost", problem.name);
    let subtitle = format!("{}; reference: {}", problem.motion, problem.reference);
    let draw = |cost, name: &str| {
        let stem = format!("work-precision-{}-{name}", problem.stem);
        let chart = chart(&title, Axis::log(ERROR, ""), &drawn, cost).subtitle(&subtitle);
        chart.write(folder, &stem).map(|()| stem)
    };
    Ok([draw(Cost::Seconds, "time")?, draw(Cost::Evaluations, "evaluations")?])
}

/// For each digit of accuracy the methods in order of time, and the one with the fewest evaluations.
pub fn table(records: &[Record]) -> Table {
    let mut table = Table::new();
    table.load_style(presets::ASCII_MARKDOWN);
    table.set_header(["error ≤", "fastest", "time", "second", "third", "fewest evaluations"]);
    for decade in ranking(&records.iter().map(run).collect::<Vec<_>>(), Reading::Interpolated) {
        let first = &decade.ranking[0];
        let behind = |place: usize| {
            decade.ranking.get(place).map_or_else(String::new, |next| {
                format!("{}, {:.1}×", next.method, next.seconds / first.seconds)
            })
        };
        let evaluations = |standing: &&Standing| standing.evaluations;
        let fewest =
            decade.ranking.iter().min_by(|a, b| evaluations(a).total_cmp(&evaluations(b))).unwrap_or(first);
        table.add_row([
            format!("1e-{}", decade.digits),
            first.method.clone(),
            format!("{:.3} ms", 1e3 * first.seconds),
            behind(1),
            behind(2),
            format!("{}, {:.0}", fewest.method, fewest.evaluations),
        ]);
    }
    if let Some(times) = table.column_mut(2) {
        times.set_cell_alignment(CellAlignment::Right);
    }
    table
}

/// All runs as comma-separated values.
pub fn csv(records: &[Record]) -> String {
    let mut csv =
        String::from("system,method,parameter,value,error,seconds,evaluations,accepted,rejected,failure\n");
    for record in records {
        let Record { system, method, parameter, value, error, seconds, statistics, failure } = record;
        let number = |x: &f64| if x.is_nan() { String::new() } else { format!("{x:e}") };
        let (error, seconds) = (number(error), number(seconds));
        let failure =
            failure.as_ref().map_or(String::new(), |text| format!("\"{}\"", text.replace('"', "\"\"")));
        let (accepted, rejected) = (statistics.accepted, statistics.rejected);
        let evaluations = statistics.evaluations;
        let _ = writeln!(
            csv,
            "{system},{method},{parameter},{value:e},{error},{seconds},{evaluations},{accepted},{rejected},{failure}"
        );
    }
    csv
}

/// As the library wants it.
fn run(record: &Record) -> Run {
    Run {
        method: record.method.into(),
        error: record.error,
        seconds: record.seconds,
        evaluations: record.statistics.evaluations,
    }
}

/// The runs of each method after its last one that failed or was wrong.
fn drawn(records: &[Record]) -> Vec<Run> {
    let sweeps = records.chunk_by(|a, b| a.method == b.method);
    let good = |sweep: &[Record]| {
        let wrong = sweep.iter().rposition(|record| record.error.is_nan() || record.error > LARGEST_DRAWN);
        sweep.iter().skip(wrong.map_or(0, |last| last + 1)).map(run).collect::<Vec<_>>()
    };
    sweeps.flat_map(good).collect()
}
