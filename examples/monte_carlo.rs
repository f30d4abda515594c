//! Which double pendulums turn over, and when? Their release is uniform over all pairs of angles.
//!
//! Energy forbids it near the bottom: with equal rods and bobs no arm can reach the top where 2 cos a + cos b > 1. Outside
//! of that lens, what happens is a matter of chaos. The picture has a point for each sample that turns over; the share is
//! given with its error, from sixteen independent scramblings of a Sobol sequence.
//!
//! `cargo run --release --example monte_carlo`; stop it, start it again, and it goes on where it was. `-- --help` lists what can be
//! chosen. On a batch system without MPI the study is divided, and put together at the end, with the same bits:
//!
//! ```console
//! $ monte_carlo --samples 1000000 --shard 1/3        # on one machine
//! $ monte_carlo --samples 1000000 --shard 2/3        # on another, and so on
//! $ monte_carlo --samples 1000000 merge 3            # where all their files are in one folder
//! ```

#[path = "support/mod.rs"]
mod support;

use clap::{Parser, Subcommand, value_parser};
use indicatif::{ProgressBar, ProgressStyle};
use lagrange_runtime::Run;
use lagrange_runtime::chart::{Axis, Chart, Series, Style};
use lagrange_runtime::ensemble::{
    Collect, Collected, Ensemble, Lost, Moments, Outcome, Present, Quantiles, Sobol, Statistic, of,
};
use lagrange_runtime::prelude::*;
use std::cell::Cell;
use std::error::Error;
use std::f64::consts::{PI, TAU};
use std::path::PathBuf;
use std::time::Duration;

lagrangian! {
    /// Two equal bobs on equal light rods; angles from the downward vertical.
    pub system DoublePendulum {
        param m, l, g = 9.81;
        coord a, b;
        let x1 = l * sin(a);
        let y1 = -l * cos(a);
        let x2 = x1 + l * sin(b);
        let y2 = y1 - l * cos(b);
        T = 0.5 * m * (dot(x1).powi(2) + dot(y1).powi(2) + dot(x2).powi(2) + dot(y2).powi(2));
        V = m * g * (y1 + y2);
    }
}

/// The angles of release, and the time at which an arm first passes through the top.
type Output = ([f64; 2], Option<f64>);

const TIMES: Quantiles = Quantiles::to(0.01);
/// Samples of each scrambling that the picture shows.
const SHOWN: u64 = 2048;

/// Which double pendulums turn over, and when? Their release is uniform over all pairs of angles.
#[derive(Parser)]
#[command(version)]
struct Arguments {
    /// Number of samples, divided evenly among the scramblings of the Sobol sequence
    #[arg(long, value_name = "N", default_value_t = 32768, value_parser = value_parser!(u64).range(2..))]
    samples: u64,
    /// Number of independent scramblings, whose scatter gives the error
    #[arg(long, value_name = "N", default_value_t = 16, value_parser = value_parser!(u64).range(2..))]
    scramblings: u64,
    /// Time to which the pendulums are followed, in seconds
    #[arg(long, value_name = "SECONDS", default_value_t = 20.0)]
    end: f64,
    /// Tolerance of a step, absolute and relative
    #[arg(long, value_name = "ERROR", default_value_t = 1e-9)]
    tolerance: f64,
    /// Number of threads; 0 for as many as there are processors
    #[arg(long, value_name = "N", default_value_t = 0)]
    threads: usize,
    /// Compute one part of the study only, and leave it in the folder
    #[arg(long, value_name = "K/N", value_parser = shard)]
    shard: Option<(u64, u64)>,
    /// Folder of checkpoints and charts [default: charts, in cargo's target folder]
    #[arg(long, value_name = "FOLDER")]
    folder: Option<PathBuf>,
    /// Write the releases and times of the picture as a table, too
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Subcommand)]
enum Command {
    /// Put together what the shards of a study left in the folder. Give the options that they had before this word
    Merge {
        /// Number of shards
        #[arg(value_parser = value_parser!(u64).range(1..))]
        shards: u64,
    },
}

/// K/N with 1 ≤ K ≤ N.
fn shard(text: &str) -> Result<(u64, u64), String> {
    let parts = text.split_once('/').and_then(|(k, n)| Some((k.parse().ok()?, n.parse().ok()?)));
    match parts {
        Some((k, n)) if 1 <= k && k <= n => Ok((k, n)),
        Some((k, n)) => Err(format!("there is no shard {k} of {n}: the first is 1, the last {n}")),
        None => Err("two whole numbers are wanted, as in 2/3".into()),
    }
}

/// The outputs of the first samples.
struct First(u64);

impl Statistic<Output> for First {
    type State = Collected<Output>;

    fn empty(&self) -> Collected<Output> {
        Statistic::<Output>::empty(&Collect)
    }

    fn add(&self, state: &mut Collected<Output>, index: u64, output: &Output) {
        if index < self.0 {
            Collect.add(state, index, output);
        }
    }

    fn merge(&self, state: &mut Collected<Output>, later: Collected<Output>) {
        Statistic::<Output>::merge(&Collect, state, later);
    }

    fn describe(&self) -> String {
        format!("the first {} outputs", self.0)
    }
}

/// The release and the time of the first passage of an arm through the top.
fn turn<M, C>(_: &DoublePendulum, run: Run<'_, DoublePendulum, M, C, 2>) -> Result<Output, Lost<f64, 2>>
where
    M: lagrange_runtime::Method<DoublePendulum, 2>,
    C: lagrange_runtime::Controller<f64, 2, M::Error>,
{
    let release = [run.start().q[0], run.start().q[1]];
    let over = |k: usize| Event::falling(move |s: &State<f64, 2>| (0.5 * s.q[k]).cos()).terminal();
    let first = run.events((over(0), over(1))).next().transpose()?;
    Ok((release, first.map(|first| first.state.t)))
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments = Arguments::parse();
    let Arguments { samples, scramblings, end, tolerance, threads, .. } = arguments;
    if !(end > 0.0 && end.is_finite() && tolerance > 0.0 && tolerance.is_finite()) {
        return Err("the end and the tolerance have to be positive numbers".into());
    }
    let each = samples.div_ceil(scramblings);
    let folder = match arguments.folder {
        Some(folder) => folder,
        None => support::charts()?,
    };
    std::fs::create_dir_all(&folder)?;
    let file = |seed: u64, part: Option<(u64, u64)>| {
        let part = part.map_or(String::new(), |(k, n)| format!("-{k}-of-{n}"));
        folder.join(format!("monte-carlo-{seed}{part}.checkpoint"))
    };
    let merged = match arguments.command {
        Some(Command::Merge { .. }) if arguments.shard.is_some() => {
            return Err("`merge` puts all shards together: leave out --shard".into());
        }
        Some(Command::Merge { shards }) => Some(shards),
        None => None,
    };

    let bar = ProgressBar::new(scramblings * each)
        .with_style(ProgressStyle::with_template("{bar:40} {percent} %, {msg}")?);
    let (computed, seconds) = (Cell::new(0), Cell::new(0.0));
    let mut checkpoints = Vec::new();
    let mut outcomes = Vec::new();
    for seed in 0..scramblings {
        let (before, seconds_before) = (computed.get(), seconds.get());
        let before_bar = bar.position();
        let study = Ensemble::new(Sobol::<2>::seed(seed), each, |[u, v]| {
            (DoublePendulum::new(0.5, 1.0), State::new(0.0, [TAU * u - PI, TAU * v - PI], [0.0, 0.0]))
        })
        .integrate(Dop853, Pi::tolerance(tolerance), end)
        .named("turns over")
        .threads(threads)
        .progress(|progress| {
            if seed == 0 {
                bar.set_length(scramblings * progress.samples);
            }
            computed.set(before + progress.done - progress.resumed);
            seconds.set(seconds_before + progress.elapsed.as_secs_f64());
            bar.set_position(before_bar + progress.done);
            bar.set_message(format!("{:.0} samples/s", progress.rate().unwrap_or(0.0)));
        });
        let statistic = (
            of(|output: &Output| f64::from(u8::from(output.1.is_some())), Moments),
            of(|output: &Output| output.1, Present(TIMES)),
            First(SHOWN),
        );
        let outcome: Outcome<_, _, 2> = if let Some(shards) = merged {
            let files: Vec<_> = (1..=shards).map(|k| file(seed, Some((k, shards)))).collect();
            let outcome = study.merge(&files, turn, statistic)?;
            checkpoints.extend(files);
            outcome
        } else {
            let checkpoint = file(seed, arguments.shard);
            checkpoints.push(checkpoint.clone());
            let study = study.checkpoint(checkpoint, Duration::from_secs(1));
            match arguments.shard {
                Some((k, n)) => study.shard(k - 1, n).reduce(turn, statistic)?,
                None => study.reduce(turn, statistic)?,
            }
        };
        for failed in &outcome.failures.kept {
            bar.println(format!("seed {seed}, {failed}"));
        }
        outcomes.push(outcome);
    }
    bar.finish_and_clear();

    let done: u64 = outcomes.iter().map(|outcome| outcome.samples).sum();
    if computed.get() > 0 {
        println!("{done} samples, {:.0} samples/s", computed.get() as f64 / seconds.get());
    } else {
        println!("{done} samples");
    }
    if let Some((k, n)) = arguments.shard {
        println!(
            "shard {k} of {n} is in {}; when all are there, put them together by `merge {n}`",
            folder.display()
        );
        return Ok(());
    }

    let mut shares = Vec::new();
    let mut times = TIMES.empty();
    let mut outputs = Collected { rows: vec![] };
    for (seed, outcome) in (0..).zip(outcomes) {
        let (share, sketch, collected) = outcome.statistic;
        shares.push(share.mean());
        TIMES.merge(&mut times, sketch);
        outputs.rows.extend(collected.rows.into_iter().map(|(index, output)| (seed * each + index, output)));
    }
    if let Some(path) = &arguments.csv {
        outputs.write_csv(path, &["first_angle", "second_angle", "time"])?;
        println!("{}", path.display());
    }
    let outputs: Vec<Output> = outputs.rows.into_iter().map(|(_, output)| output).collect();
    let mut share = Moments.empty();
    shares.iter().zip(0..).for_each(|(mean, seed)| Moments.add(&mut share, seed, mean));
    println!(
        "{:.2} % ± {:.2} % turn over within {end} s; of independent samples the error would be {:.2} %",
        100.0 * share.mean(),
        100.0 * share.standard_error(),
        100.0 * (share.mean() * (1.0 - share.mean()) / done as f64).sqrt(),
    );
    for (name, p) in [("a tenth", 0.1), ("half", 0.5), ("nine tenths", 0.9)] {
        if let Some(time) = times.quantile(p) {
            println!("{name} of these by {time:.2} s (to 1 %)");
        }
    }
    let forbidden = |[a, b]: [f64; 2]| 2.0 * a.cos() + b.cos() > 1.0;
    let against = outputs.iter().filter(|(release, time)| time.is_some() && forbidden(*release)).count();
    println!("{against} of them against the law of energy");

    chart(&outputs, end).write(&folder, "monte-carlo")?;
    println!("{}", folder.join("monte-carlo.png").display());
    // All is said: the next run begins anew.
    checkpoints.iter().try_for_each(std::fs::remove_file)?;
    Ok(())
}

/// A point for each release that turns over, by its time; and the border of what energy allows.
fn chart(outputs: &[Output], end: f64) -> Chart {
    let between = |low: f64, high: f64| {
        let points = outputs.iter().filter(|(_, time)| time.is_some_and(|time| low <= time && time < high));
        Series::markers(format!("{low} to {high} s"), points.map(|([a, b], _)| (*a, *b)))
    };
    // 2 cos a + cos b = 1, above and back below.
    let border = |sign: f64| {
        (-400..=400).map(move |k| {
            let a = sign * 0.5 * PI * f64::from(k) / 400.0;
            (a, sign * (1.0 - 2.0 * a.cos()).clamp(-1.0, 1.0).acos())
        })
    };
    let lens = Series { style: Style::Context, ..Series::new("", border(1.0).chain(border(-1.0))) };
    let chart = Chart::new(
        "Double pendulums that turn over",
        Axis::linear("first angle at release", "rad"),
        Axis::linear("second angle at release", "rad"),
    )
    .subtitle(format!(
        "by the time of it; {} Sobol points; inside the grey line energy forbids it",
        outputs.len()
    ))
    .equal_aspect()
    .with(lens);
    [(0.0, 1.0), (1.0, 2.0), (2.0, 5.0), (5.0, f64::INFINITY)]
        .into_iter()
        .filter(|(low, _)| *low < end)
        .map(|(low, high)| (low, high.min(end)))
        .fold(chart, |chart, (low, high)| chart.with(between(low, high)))
}
