//! Measurements as charts and CSV.

use crate::long::Drift;
use crate::measure::{Record, WRONG};
use crate::methods::Family;
use crate::problems::{ERROR, Long, Problem};
use lagrange_runtime::chart::{Axis, Chart, ChartError, Panels, Series};
use lagrange_runtime::testing::work_precision::{Cost, Decade, MeasuredRun, Reading, chart, ranking};
use std::fmt::Write as _;
use std::io::ErrorKind;
use std::path::Path;

/// Errors below this are drawn at it: an invariant kept exactly has no logarithm.
const LEAST_DRAWN: f64 = 1e-17;

/// A picture of the page.
pub struct Picture {
    pub heading: String,
    /// SVG.
    pub svg: String,
}

/// Removes the files of a picture that an earlier call has drawn.
fn removed(folder: &Path, stem: &str) -> Result<(), ChartError> {
    for ending in ["svg", "png", "csv"] {
        let path = folder.join(stem).with_extension(ending);
        match std::fs::remove_file(&path) {
            Err(source) if source.kind() != ErrorKind::NotFound => {
                return Err(ChartError::Write { path, source });
            }
            _ => {}
        }
    }
    Ok(())
}

/// Writes the files of a picture.
fn picture(panels: &Panels, heading: String, folder: &Path, stem: &str) -> Result<Picture, ChartError> {
    panels.write(folder, stem)?;
    Ok(Picture { heading, svg: panels.svg_with_text()? })
}

/// Writes error against time and error against evaluations, unless there is nothing to draw: those of an earlier call
/// are removed.
pub fn charts<Sys, const N: usize>(
    problem: &Problem<Sys, N>,
    records: &[Record],
    folder: &Path,
) -> Result<Vec<Picture>, ChartError> {
    let stem = |name: &str| format!("work-precision-{}-{name}", problem.stem);
    if drawn(records).is_empty() {
        for name in ["time", "evaluations"] {
            removed(folder, &stem(name))?;
        }
        return Ok(Vec::new());
    }
    let draw = |cost, name: &str, what: &str| {
        let title = format!("{}: error at the end against {what}", problem.name);
        let panels = Panels::new(title, panels(records, cost))
            .subtitle(format!("{}; reference: {}", problem.motion, problem.reference));
        picture(&panels, format!("Error against {what}"), folder, &stem(name))
    };
    Ok(vec![
        draw(Cost::Seconds, "time", "time")?,
        draw(Cost::Evaluations, "evaluations", "evaluations of the right-hand side")?,
    ])
}

/// Methods that one picture can tell apart.
const ONE_PICTURE: usize = 16;

/// A few methods in one picture; of many, the best of each family, then family by family, each before all others.
fn panels(records: &[Record], cost: Cost) -> Vec<Chart> {
    let drawn = drawn(records);
    let curves = |title: &str, of: &dyn Fn(Family) -> bool| {
        let runs: Vec<MeasuredRun> =
            drawn.iter().filter(|(family, _)| of(*family)).map(|(_, run)| run.clone()).collect();
        chart(title, Axis::log(ERROR, ""), &runs, cost)
    };
    let all = curves("", &|_| true);
    if all.series.len() <= ONE_PICTURE {
        return vec![all];
    }
    let context: Vec<Series> = all.series.into_iter().map(|series| Series::context(series.points)).collect();
    let best = |family| {
        let series = curves("", &|other| other == family).series;
        let points = series.into_iter().flat_map(|series| series.points).collect();
        Series::line(family.name(), front(points))
    };
    let families = || Family::ALL.into_iter().filter(|family| drawn.iter().any(|(other, _)| other == family));
    let mut first = curves("The best of each family", &|_| false);
    first.series = families().map(best).collect();
    let others = families().map(|family| curves(family.name(), &|other| other == family));
    std::iter::once(first).chain(others).map(|panel| before(panel, &context)).collect()
}

/// A panel with all curves behind its own.
fn before(mut panel: Chart, context: &[Series]) -> Chart {
    panel.series.splice(0..0, context.iter().cloned());
    panel
}

/// The points that no other one betters in both cost and error.
fn front(mut points: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut best = f64::INFINITY;
    points.retain(|&(_, error)| {
        let better = error < best;
        best = best.min(error);
        better
    });
    points
}

/// Writes a chart for each invariant, unless there is nothing to draw: those of an earlier call are removed.
pub fn long_charts<Sys, const N: usize>(
    problem: &Problem<Sys, N>,
    long: &Long<Sys, N>,
    drifts: &[Drift],
    folder: &Path,
) -> Result<Vec<Picture>, ChartError> {
    let (drifts, impossible): (Vec<&Drift>, Vec<&Drift>) = drifts
        .iter()
        .partition(|drift| drift.points.iter().any(|(_, errors)| errors.iter().all(|e| *e <= WRONG)));
    let stem = |invariant: &str| format!("long-run-{}-{invariant}", problem.stem);
    if drifts.is_empty() {
        for invariant in &long.invariants {
            removed(folder, &stem(&invariant.stem))?;
        }
        return Ok(Vec::new());
    }
    let impossible: Vec<&str> = impossible.iter().map(|drift| drift.method).collect();
    let draw = |(k, name, invariant): (usize, &str, &str)| {
        let axes =
            || (Axis::log("time", "periods"), Axis::log(format!("largest |Δ| / |{name}| in a period"), ""));
        let curve = |drift: &Drift| {
            let error =
                |errors: &[f64]| if errors[k] > WRONG { f64::NAN } else { errors[k].max(LEAST_DRAWN) };
            drift.points.iter().map(move |(t, errors)| (*t, error(errors))).collect::<Vec<_>>()
        };
        let context: Vec<Series> = drifts.iter().map(|drift| Series::context(curve(drift))).collect();
        let panel = |title: &str, of: &dyn Fn(Family) -> bool| {
            let mut panel = Chart::new(title, axes().0, axes().1);
            let members = drifts.iter().filter(|drift| of(drift.family));
            panel.series = members.map(|drift| Series::new(drift.method, curve(drift))).collect();
            panel
        };
        let family = |family: Family| {
            let panel = panel(family.name(), &|other| other == family);
            (!panel.series.is_empty()).then(|| before(panel, &context))
        };
        let charts: Vec<Chart> = match drifts.len() {
            0..=ONE_PICTURE => vec![panel("", &|_| true)],
            _ => Family::ALL.into_iter().filter_map(family).collect(),
        };
        let title = format!("{}: error of {name} over many periods, at equal cost", problem.name);
        let (evaluations, period, clock) = (long.evaluations, long.period, long.clock);
        let mut subtitle = format!(
            "at most {evaluations} evaluations of the right-hand side per period; one period: {period:.4} ({clock}); errors \
             of {LEAST_DRAWN:e} and less are drawn there, and curves end at {WRONG}"
        );
        if !impossible.is_empty() {
            let _ =
                write!(subtitle, "; lost at once, or not to be had at this cost: {}", impossible.join(" · "));
        }
        let panels = Panels::new(title, charts).subtitle(subtitle);
        picture(&panels, format!("Error of {name} over many periods"), folder, &stem(invariant))
    };
    let invariants = long.invariants.iter().enumerate();
    invariants.map(|(k, invariant)| draw((k, &invariant.name, &invariant.stem))).collect()
}

/// For each digit of accuracy the methods in order of time.
pub fn winners(records: &[Record]) -> Vec<Decade> {
    let runs: Vec<MeasuredRun> = records.iter().map(run).collect();
    ranking(&runs, Reading::Interpolated)
}

/// All runs as comma-separated values.
pub fn csv(records: &[Record]) -> String {
    let mut csv = String::from(
        "system,family,method,parameter,value,error,seconds,evaluations,accepted,rejected,failure\n",
    );
    for record in records {
        let Record { system, method, value, error, seconds, statistics, failure, .. } = record;
        let number = |x: &f64| if x.is_nan() { String::new() } else { format!("{x:e}") };
        let (error, seconds) = (number(error), number(seconds));
        let failure = failure.as_ref().map_or(String::new(), |text| quoted(text));
        let (system, family, method) = (quoted(system), quoted(record.family.name()), quoted(method));
        let (accepted, rejected) = (statistics.accepted, statistics.rejected);
        let (evaluations, parameter) = (statistics.evaluations, record.parameter.name());
        let _ = writeln!(
            csv,
            "{system},{family},{method},{parameter},{value:e},{error},{seconds},{evaluations},{accepted},{rejected},{failure}"
        );
    }
    csv
}

fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('"', "\"\""))
}

/// The long runs of one system as comma-separated values.
pub fn long_csv<Sys, const N: usize>(long: &Long<Sys, N>, drifts: &[Drift]) -> String {
    let names = long.invariants.iter().map(|invariant| quoted(&invariant.name)).collect::<Vec<_>>().join(",");
    let mut csv = format!("method,parameter,value,evaluations per period,period,{names}\n");
    for Drift { method, parameter, value, cost, points, .. } in drifts {
        for (period, errors) in points {
            let errors = errors.iter().map(|error| format!("{error:e}")).collect::<Vec<_>>().join(",");
            let (method, parameter) = (quoted(method), parameter.name());
            let _ = writeln!(csv, "{method},{parameter},{value:e},{cost:.1},{period:e},{errors}");
        }
    }
    csv
}

/// The record as the library wants it.
fn run(record: &Record) -> MeasuredRun {
    MeasuredRun {
        method: record.method.into(),
        error: record.error,
        seconds: record.seconds,
        evaluations: record.statistics.evaluations,
    }
}

/// The runs of each method after its last one that failed or was wrong, but for those at the fine end, which are too
/// much for it.
fn drawn(records: &[Record]) -> Vec<(Family, MeasuredRun)> {
    let sweeps = records.chunk_by(|a, b| a.method == b.method);
    let good = |sweep: &[Record]| {
        let is_wrong = |record: &Record| record.error.is_nan() || record.error > WRONG;
        let end = sweep.iter().rposition(|record| !is_wrong(record)).map_or(0, |last| last + 1);
        let start = sweep[..end].iter().rposition(is_wrong).map_or(0, |last| last + 1);
        sweep[start..end].iter().map(|record| (record.family, run(record))).collect::<Vec<_>>()
    };
    sweeps.flat_map(good).collect()
}
