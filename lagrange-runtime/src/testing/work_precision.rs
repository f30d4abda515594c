//! Work and precision: which method reaches an accuracy at the least cost.

#[cfg(feature = "chart")]
use crate::chart::{Axis, Chart, Series};
use std::fmt::Write as _;

/// One run of one method: what it cost and how far it was off.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredRun {
    /// Name of the method.
    pub method: String,
    /// Error against a reference solution.
    pub error: f64,
    /// Time taken, in seconds.
    pub seconds: f64,
    /// Evaluations of the right-hand side.
    pub evaluations: u64,
}

/// Measure of cost of a chart.
#[cfg(feature = "chart")]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cost {
    /// Time taken.
    Seconds,
    /// Evaluations of the right-hand side, the same on every machine.
    Evaluations,
}

/// Way of reading the cost of an accuracy off the runs of a method.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Reading {
    /// The cheapest run with `error ≤ 10⁻ᵏ`: nothing but what was measured.
    #[default]
    Measured,
    /// Also the straight line through neighbouring runs of the method (by time) in logarithms of error, time and
    /// evaluations, where the error falls through 10⁻ᵏ between them. It removes the luck of where the runs happen to
    /// lie.
    Interpolated,
}

/// Cost of one method for an accuracy.
#[derive(Clone, Debug, PartialEq)]
pub struct Standing {
    /// Name of the method.
    pub method: String,
    /// Time taken, in seconds.
    pub seconds: f64,
    /// Evaluations of the right-hand side (a fraction where interpolated).
    pub evaluations: f64,
}

/// The methods that reach `error ≤ 10^(−digits)`, the fastest first.
#[derive(Clone, Debug, PartialEq)]
pub struct Decade {
    /// k of 10⁻ᵏ.
    pub digits: u32,
    /// Never empty.
    pub ranking: Vec<Standing>,
}

/// For each accuracy 10⁻¹ … 10⁻¹⁴ that some method reaches, the methods in order of time. Of equally fast ones the
/// first in `runs` comes first. Runs whose error is no number, or whose time is not positive, do not count.
///
/// ```
/// use lagrange_runtime::testing::work_precision::{Reading, MeasuredRun, ranking};
/// let run = |method: &str, error, seconds| MeasuredRun { method: method.into(), error, seconds, evaluations: 100 };
/// let runs = [run("Euler", 1e-2, 1e-5), run("RK4", 1e-6, 2e-5), run("RK4", 1e-2, 3e-6)];
/// let table = ranking(&runs, Reading::Measured);
/// assert_eq!((table[1].digits, &*table[1].ranking[0].method), (2, "RK4"));
/// assert_eq!(table.last().unwrap().digits, 6);
/// ```
pub fn ranking(runs: &[MeasuredRun], reading: Reading) -> Vec<Decade> {
    let curves = curves(runs);
    let decade = |digits: u32| {
        let target = 10_f64.powi(-(digits as i32));
        let mut ranking: Vec<_> =
            curves.iter().filter_map(|curve| standing(curve, target, reading)).collect();
        ranking.sort_by(|a, b| a.seconds.total_cmp(&b.seconds));
        (!ranking.is_empty()).then_some(Decade { digits, ranking })
    };
    (1..=14).filter_map(decade).collect()
}

/// The usable runs of each method in order of time; methods in order of appearance.
fn curves(runs: &[MeasuredRun]) -> Vec<Vec<&MeasuredRun>> {
    let mut curves: Vec<Vec<&MeasuredRun>> = Vec::new();
    let usable = |run: &&MeasuredRun| run.error >= 0.0 && run.seconds > 0.0 && run.seconds.is_finite();
    for run in runs.iter().filter(usable) {
        match curves.iter_mut().find(|curve| curve[0].method == run.method) {
            Some(curve) => curve.push(run),
            None => curves.push(vec![run]),
        }
    }
    for curve in &mut curves {
        curve.sort_by(|a, b| a.seconds.total_cmp(&b.seconds));
    }
    curves
}

fn standing(curve: &[&MeasuredRun], target: f64, reading: Reading) -> Option<Standing> {
    let first = curve.iter().position(|run| run.error <= target)?;
    let good = curve[first];
    let (mut seconds, mut evaluations) = (good.seconds, good.evaluations as f64);
    // An exact result (error 0) and a failed one (error ∞) have no logarithm to interpolate in.
    if let (Reading::Interpolated, Some(bad)) = (reading, first.checked_sub(1).map(|i| curve[i]))
        && good.error > 0.0
        && bad.error.is_finite()
    {
        let part = (target / bad.error).ln() / (good.error / bad.error).ln();
        let between = |a: f64, b: f64| a * (b / a).powf(part);
        seconds = between(bad.seconds, good.seconds);
        evaluations = between((bad.evaluations as f64).max(1.0), evaluations.max(1.0));
    }
    Some(Standing { method: good.method.clone(), seconds, evaluations })
}

/// A work–precision chart: error against cost on logarithmic axes, a curve for each method through its runs in the
/// order given.
///
/// ```
/// use lagrange_runtime::chart::Axis;
/// use lagrange_runtime::testing::work_precision::{Cost, MeasuredRun, chart};
/// let run = |error, evaluations| MeasuredRun { method: "RK4".into(), error, seconds: 1e-6, evaluations };
/// let runs = [run(1e-3, 40), run(6e-5, 80), run(4e-6, 160)];
/// let svg = chart("Simple pendulum", Axis::log("error in θ", "rad"), &runs, Cost::Evaluations).svg()?;
/// # assert!(svg.starts_with("<svg"));
/// # Ok::<(), lagrange_runtime::chart::ChartError>(())
/// ```
#[cfg(feature = "chart")]
pub fn chart(title: &str, error: Axis, runs: &[MeasuredRun], cost: Cost) -> Chart {
    let axis = match cost {
        Cost::Seconds => Axis::log("time", "s"),
        Cost::Evaluations => Axis::log("evaluations of the right-hand side", ""),
    };
    let mut chart = Chart::new(title, axis, error);
    for run in runs {
        let x = match cost {
            Cost::Seconds => run.seconds,
            Cost::Evaluations => run.evaluations as f64,
        };
        let point = (x, run.error);
        match chart.series.iter_mut().find(|series| series.name == run.method) {
            Some(series) => series.points.push(point),
            None => chart.series.push(Series::new(&run.method, [point])),
        }
    }
    chart
}

/// The ranking as a Markdown table: the fastest method of each decade, its cost, and how far behind the next one is.
pub fn markdown(decades: &[Decade]) -> String {
    let mut table =
        String::from("| error ≤ | fastest | time (s) | evaluations | next |\n|---|---|---|---|---|\n");
    for decade in decades {
        let best = &decade.ranking[0];
        let next = decade.ranking.get(1).map_or("–".into(), |next| {
            format!("{}, {:.2}× the time", next.method, next.seconds / best.seconds)
        });
        let (digits, method) = (decade.digits, &best.method);
        let _ = writeln!(
            table,
            "| 1e-{digits} | {method} | {:.2e} | {:.0} | {next} |",
            best.seconds, best.evaluations
        );
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(method: &str, error: f64, seconds: f64, evaluations: u64) -> MeasuredRun {
        MeasuredRun { method: method.into(), error, seconds, evaluations }
    }

    fn winners(table: &[Decade]) -> Vec<(u32, &str)> {
        table.iter().map(|decade| (decade.digits, decade.ranking[0].method.as_str())).collect()
    }

    #[test]
    fn the_cheapest_run_that_is_good_enough_wins_its_decade() {
        let runs = [
            run("low", 1e-1, 1e-5, 10),
            run("low", 1e-3, 1e-3, 1000),
            run("high", 1e-4, 1e-4, 80),
            run("high", 5e-6, 2e-4, 160),
        ];
        let table = ranking(&runs, Reading::Measured);
        assert_eq!(winners(&table), [(1, "low"), (2, "high"), (3, "high"), (4, "high"), (5, "high")]);
        assert_eq!(
            table[2].ranking[1],
            Standing { method: "low".into(), seconds: 1e-3, evaluations: 1000.0 }
        );
    }

    #[test]
    fn interpolation_is_linear_in_the_logarithms() {
        let runs = [run("m", 1e-2, 1e-4, 100), run("m", 1e-6, 1e-2, 10_000)];
        let at = |reading, digits: usize| ranking(&runs, reading)[digits - 1].ranking[0].clone();
        assert!((at(Reading::Interpolated, 4).seconds / 1e-3 - 1.0).abs() < 1e-12);
        assert!((at(Reading::Interpolated, 4).evaluations / 1000.0 - 1.0).abs() < 1e-12);
        assert_eq!(at(Reading::Measured, 4).seconds, 1e-2);
        // Nothing is extrapolated.
        assert_eq!(at(Reading::Interpolated, 1).seconds, 1e-4);
        assert_eq!(ranking(&runs, Reading::Interpolated).len(), 6);
    }

    #[test]
    fn failed_runs_do_not_count_and_exact_ones_reach_everything() {
        let runs = [
            run("failed", f64::NAN, 1e-9, 1),
            run("failed", f64::INFINITY, 1e-9, 1),
            run("untimed", 1e-15, 0.0, 1),
            run("exact", f64::INFINITY, 1e-6, 1),
            run("exact", 0.0, 1e-5, 7),
        ];
        let table = ranking(&runs, Reading::Interpolated);
        assert_eq!(table.len(), 14);
        assert!(table.iter().all(|d| d.ranking.len() == 1 && d.ranking[0].seconds == 1e-5));
        assert!(ranking(&[], Reading::Measured).is_empty());
    }

    #[cfg(feature = "chart")]
    #[test]
    fn a_chart_has_a_curve_for_each_method() {
        let runs = [run("a", 0.5, 1e-5, 3), run("b", 0.1, 2e-5, 4), run("a", f64::NAN, 1e-4, 30)];
        let csv = chart("", Axis::log("error", ""), &runs, Cost::Seconds).csv();
        assert_eq!(csv, "series,time (s),error\na,1e-5,0.5\na,0.0001,NaN\nb,2e-5,0.1\n");
        let csv = chart("", Axis::log("error", ""), &runs, Cost::Evaluations).csv();
        assert!(csv.contains("\nb,4.0,0.1\n"));
    }

    #[test]
    fn markdown_names_the_next_best() {
        let runs = [run("a", 0.5, 1e-5, 3), run("a", 0.05, 1e-4, 30), run("b", 0.09, 2.5e-4, 60)];
        let table = markdown(&ranking(&runs, Reading::Measured));
        assert_eq!(table.lines().nth(2), Some("| 1e-1 | a | 1.00e-4 | 30 | b, 2.50× the time |"));
        assert_eq!(table.lines().count(), 3);
    }
}
