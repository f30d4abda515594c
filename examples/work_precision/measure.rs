//! Runs every sweep until its error no longer falls, and times what it ran.

use crate::methods::{Family, Outcome, Parameter, Sweep};
use crate::problems::Problem;
use indicatif::{ProgressBar, ProgressStyle};
use lagrange_runtime::Statistics;
use std::hint::black_box;
use std::time::Instant;

/// Rounds of timing: each takes all runs in turn, so that a change of clock speed meets all methods. Of a run's times
/// the shortest counts, since other programs only ever make it longer.
const ROUNDS: u32 = 21;

/// Runs that take long get fewer rounds, but never fewer than this.
const FEWEST_ROUNDS: u32 = 4;

/// All rounds of a run together last about so long, if that lies within these numbers of rounds.
const SECONDS: f64 = 0.02;

/// A timing lasts at least so long: shorter runs are repeated.
const SHORTEST: f64 = 2e-4;

/// A sweep ends with the first good run that costs more evaluations.
const MOST_EVALUATIONS: u64 = 1_000_000;

/// A run is given up after so many steps.
const MOST_STEPS: u64 = 4 * MOST_EVALUATIONS;

/// Below this error, a sweep ends after two runs in succession that are no better than those before.
const CONVERGED: f64 = 1e-9;

/// Larger errors say nothing but "wrong": such runs are neither timed nor drawn.
pub const WRONG: f64 = 0.3;

/// One run of one method.
pub struct Record {
    pub system: &'static str,
    pub method: &'static str,
    pub family: Family,
    pub parameter: Parameter,
    pub value: f64,
    /// Against the reference; NaN if the run failed.
    pub error: f64,
    /// Time of the run; NaN if it failed or was wrong.
    pub seconds: f64,
    pub statistics: Statistics,
    pub failure: Option<String>,
}

/// A run that is to be timed: its record and sweep, how often it is repeated in each of its rounds, and its time.
struct Timing {
    record: usize,
    sweep: usize,
    repeat: u32,
    rounds: u32,
    /// About how long one round takes, in microseconds.
    microseconds: u64,
    /// The shortest so far.
    seconds: f64,
}

pub fn measure<Sys, const N: usize>(problem: &Problem<Sys, N>, sweeps: &[Sweep<'_, N>]) -> Vec<Record> {
    let bar = ProgressBar::new(0).with_message(problem.name);
    bar.set_style(bar_style());
    let (mut records, mut timings) = (Vec::new(), Vec::new());
    for (index, sweep) in sweeps.iter().enumerate() {
        explore(problem, sweep, |record, seconds| {
            if record.error <= WRONG {
                let repeat = (SHORTEST / seconds).ceil().max(1.0) as u32;
                let rounds = ((SECONDS / seconds) as u32).clamp(FEWEST_ROUNDS, ROUNDS);
                let record = records.len();
                let microseconds = (1e6 * seconds * f64::from(repeat)) as u64;
                let seconds = f64::INFINITY;
                timings.push(Timing { record, sweep: index, repeat, rounds, microseconds, seconds });
            }
            records.push(record);
        });
    }
    bar.set_length(timings.iter().map(|timing| u64::from(timing.rounds) * timing.microseconds).sum());
    bar.reset_eta();
    for round in 0..ROUNDS {
        for timing in timings.iter_mut().filter(|timing| round < timing.rounds) {
            let (sweep, value) = (&sweeps[timing.sweep], records[timing.record].value);
            let seconds = seconds(timing.repeat, || run(problem, sweep, black_box(value)));
            timing.seconds = timing.seconds.min(seconds);
            bar.inc(timing.microseconds);
        }
    }
    for timing in timings {
        records[timing.record].seconds = timing.seconds;
    }
    bar.finish_and_clear();
    records
}

/// From start to end.
fn run<Sys, const N: usize>(problem: &Problem<Sys, N>, sweep: &Sweep<'_, N>, value: f64) -> Outcome<N> {
    (sweep.start)(value, MOST_STEPS)(problem.end.t)
}

/// Runs a sweep, and hands over each record with a first guess of its time.
fn explore<Sys, const N: usize>(
    problem: &Problem<Sys, N>,
    sweep: &Sweep<'_, N>,
    mut found: impl FnMut(Record, f64),
) {
    let (mut best, mut no_better) = (f64::INFINITY, 0);
    for &value in &sweep.values {
        let clock = Instant::now();
        let outcome = run(problem, sweep, value);
        let seconds = clock.elapsed().as_secs_f64();
        let (error, statistics, failure) = match outcome {
            Ok((end, statistics)) => (problem.error(&end), statistics, None),
            Err(failed) => (f64::NAN, failed.statistics, Some(failed.to_string())),
        };
        no_better = if error < 0.7 * best { 0 } else { no_better + 1 };
        best = best.min(error);
        let dear = failure.is_none() && statistics.evaluations > MOST_EVALUATIONS;
        found(
            Record {
                system: problem.name,
                method: sweep.method,
                family: sweep.family,
                parameter: sweep.parameter,
                value,
                error,
                seconds: f64::NAN,
                statistics,
                failure,
            },
            seconds,
        );
        if dear || (best < CONVERGED && no_better == 2) {
            break;
        }
    }
}

/// Seconds of one of `repeat` runs in succession.
fn seconds<T>(repeat: u32, mut run: impl FnMut() -> T) -> f64 {
    let clock = Instant::now();
    for _ in 0..repeat {
        black_box(run());
    }
    clock.elapsed().as_secs_f64() / f64::from(repeat)
}

pub fn bar_style() -> ProgressStyle {
    let style = ProgressStyle::with_template("{msg:36} {wide_bar} {percent:>3} %, {eta} left");
    style.unwrap_or_else(|_| ProgressStyle::default_bar())
}
