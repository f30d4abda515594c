//! Does the top sleep? A tolerance analysis.
//!
//! A top that spins fast stands upright: it sleeps while `(C ω)² > 4 A m g l` (Lagrange's threshold; Beatty, *Principles of
//! Engineering Mechanics* 2, 2006, section 11.12.4.4). Friction at its tip takes the spin away, and it wakes. The maker
//! promises eighteen seconds. Which part of the tops keeps the promise, and which tolerance is the one to tighten?
//!
//! Masses, sizes, friction, spin and tilt of each top are drawn by their tolerances. Of each trajectory the tilt at
//! given times is kept and the moment at which it first exceeds five degrees; of all of them quantiles, a histogram,
//! and the correlation of that moment with each dimension.
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
use comfy_table::{Table, presets};
use indicatif::{ProgressBar, ProgressStyle};
use lagrange_runtime::Occurrence;
use lagrange_runtime::chart::{Axis, Chart, Panels, Series};
use lagrange_runtime::ensemble::rand_distr::{Distribution, StandardNormal};
use lagrange_runtime::ensemble::{
    Collect, Collected, Counts, Covariance, Covariances, Each, Ensemble, Histogram, Moments, Present,
    Quantiles, Random, Sketch, Source, Statistic, of,
};
use lagrange_runtime::lanes::{Fused, Occurrences, Sampled};
use lagrange_runtime::prelude::*;
use std::cell::Cell;
use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

lagrangian! {
    /// A symmetric top on its tip. Its axis is turned about x and then about y, which is regular where it stands upright.
    pub system Top {
        /// Mass; height of its centre above the tip; moments of inertia about the centre, across the axis and about it.
        param m, l, across, along;
        /// Torque of the friction at the tip, by the spin.
        param c;
        param g = 9.81;
        coord alpha, beta, psi;
        let first = frame(world, [0, 0, 0], rotation_x(alpha));
        let second = frame(first, [0, 0, 0], rotation_y(beta));
        let top = frame(second, [0, 0, l], rotation_z(psi));
        T = body(m, [across, across, along], top);
        V = m * g * l * cos(alpha) * cos(beta);
        D = 0.5 * c * top.angular_velocity()[2].powi(2);
    }
}

/// What is drawn: name, unit, nominal value, and tolerance, which is one standard deviation.
const DIMENSIONS: [(&str, &str, f64, f64); 7] = [
    ("mass", "kg", 0.1, 0.001),
    ("height of the centre", "m", 0.04, 0.0004),
    ("inertia across", "kg m²", 5e-5, 5e-7),
    ("inertia along", "kg m²", 8e-5, 8e-7),
    ("friction", "N m s", 2e-6, 1e-7),
    ("spin at release", "rad/s", 120.0, 2.0),
    ("tilt at release", "rad", 0.01, 0.003),
];

/// Times at which tilts are kept: every half second.
const TIMES: usize = 61;
/// The end, in seconds.
const END: f64 = 30.0;
/// The promise, in seconds.
const PROMISED: f64 = 18.0;
/// It is awake from this tilt on.
const AWAKE: f64 = 5.0;
/// And at this one its rim touches the table.
const FALLEN: f64 = 60.0;
const PROBABILITIES: [(f64, &str); 5] =
    [(0.05, "5 %"), (0.25, "25 %"), (0.5, "50 %"), (0.75, "75 %"), (0.95, "95 %")];
const QUANTILES: Quantiles = Quantiles::to(0.002);
/// Bins of 0.2 s for the moment of waking.
const WAKING: Histogram = Histogram::new(0.0, END, 150);

/// The height of a point of the axis, 1 from the tip.
fn height(at: &State<f64, 3>) -> f64 {
    at.q[0].cos() * at.q[1].cos()
}

/// The angle between the axis and the vertical, in degrees.
fn tilt(at: &State<f64, 3>) -> f64 {
    height(at).clamp(-1.0, 1.0).acos().to_degrees()
}

/// A top by its tolerances.
fn draw(mut rng: <Random as Source>::Draw) -> (Top, State<f64, 3>) {
    let [m, l, across, along, c, spin, tilt] = DIMENSIONS.map(|(_, _, nominal, tolerance)| {
        let error: f64 = StandardNormal.sample(&mut rng);
        nominal + tolerance * error
    });
    (Top::new(m, l, across, along, c), State::new(0.0, [tilt, 0.0, 0.0], [0.0, 0.0, spin]))
}

/// Dimensions, and when it woke.
type Drawn = ([f64; DIMENSIONS.len()], Option<f64>);
/// Tilts in degrees at the times, and the rest.
type Output = ([f64; TIMES], Drawn);

/// Does the top sleep? Tolerance analysis of a spinning top
#[derive(Parser)]
#[command(version)]
struct Arguments {
    /// Number of tops
    #[arg(long, value_name = "N", default_value_t = 20_000, value_parser = value_parser!(u64).range(2..))]
    samples: u64,
    /// Which random numbers
    #[arg(long, value_name = "SEED", default_value_t = 1)]
    seed: u64,
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
    /// Write the dimensions and moments of waking of all tops as a table, too; shards have to be told, too
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
    type State = Collected<Drawn>;

    fn empty(&self) -> Collected<Drawn> {
        Statistic::<Drawn>::empty(&Collect)
    }

    fn add(&self, state: &mut Collected<Drawn>, index: u64, (_, drawn): &Output) {
        if index < self.0 {
            Collect.add(state, index, drawn);
        }
    }

    fn merge(&self, state: &mut Collected<Drawn>, later: Collected<Drawn>) {
        Statistic::<Drawn>::merge(&Collect, state, later);
    }

    fn describe(&self) -> String {
        format!("the first {} outputs", self.0)
    }
}

fn main() -> ExitCode {
    match run(Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: Arguments) -> Result<(), Box<dyn Error>> {
    let Arguments { samples, seed, tolerance, threads, .. } = arguments;
    if !(tolerance > 0.0 && tolerance.is_finite()) {
        return Err("the tolerance has to be a positive number".into());
    }
    if arguments.command.is_some() && arguments.shard.is_some() {
        return Err("`merge` puts all shards together: leave out --shard".into());
    }
    let folder = match arguments.folder {
        Some(folder) => folder,
        None => support::charts()?,
    };
    std::fs::create_dir_all(&folder)?;
    let file = |part: Option<(u64, u64)>| {
        let part = part.map_or(String::new(), |(k, n)| format!("-{k}-of-{n}"));
        folder.join(format!("monte-carlo-{seed}{part}.checkpoint"))
    };

    let bar = ProgressBar::new(samples)
        .with_style(ProgressStyle::with_template("{bar:40} {percent} %, {msg}, {eta} left")?);
    let (computed, seconds) = (Cell::new(0), Cell::new(0.0));
    let mut study = Ensemble::new(Random::seed(seed), samples, draw)
        .integrate(Dop853, PiController::tolerance(tolerance), END)
        .named("does the top sleep")
        .threads(threads)
        .progress(|progress| {
            computed.set(progress.done - progress.resumed);
            seconds.set(progress.elapsed.as_secs_f64());
            bar.set_length(progress.samples);
            bar.set_position(progress.done);
            bar.set_message(format!("{:.0} tops a second", progress.rate().unwrap_or(0.0)));
        });
    if let Some((k, n)) = arguments.shard {
        study = study.shard(k - 1, n);
    }
    let shards = arguments
        .command
        .map(|Command::Merge { shards }| (1..=shards).map(|k| file(Some((k, shards)))).collect::<Vec<_>>());
    let checkpoints: Vec<PathBuf> = shards.clone().unwrap_or_else(|| vec![file(arguments.shard)]);
    if shards.is_none() {
        study = study.checkpoint(&checkpoints[0], Duration::from_secs(1));
    }
    let study = study.in_lanes(Fused);

    let times = (0..TIMES).map(time);
    let [awake, fallen] = [AWAKE, FALLEN].map(|degrees| degrees.to_radians().cos());
    let wakes = Event::falling(|at: &State<f64, 3>| height(at) - awake).named("wakes");
    let falls = Event::falling(|at: &State<f64, 3>| height(at) - fallen).named("falls").terminal();
    let watch = (
        Sampled::new(times, |top: &Top, states: &[State<f64, 3>]| {
            // A top that has fallen lies at that angle.
            let tilts: [f64; TIMES] = core::array::from_fn(|k| states.get(k).map_or(FALLEN, tilt));
            let [spin, tilt] = states.first().map_or([f64::NAN; 2], |start| [start.qd[2], start.q[0]]);
            (tilts, [top.m, top.l, top.across, top.along, top.c, spin, tilt])
        }),
        Occurrences::new((wakes, falls), |_: &Top, met: &[Occurrence<f64, 3>], _: &State<f64, 3>| {
            met.iter().find(|occurrence| occurrence.name == "wakes").map(|occurrence| occurrence.state.t)
        }),
    );
    // Moments of waking, and dimensions, of those that woke.
    let woken = |(_, (dimensions, woke)): &Output| {
        let all = |woke| core::array::from_fn(|k| if k == 0 { woke } else { dimensions[k - 1] });
        woke.map(all)
    };
    let statistics = (
        of(|(tilts, _): &Output| *tilts, Each(QUANTILES)),
        of(|(_, (_, woke)): &Output| woke.unwrap_or(f64::INFINITY), WAKING),
        of(|(_, (_, woke)): &Output| f64::from(u8::from(woke.is_none_or(|woke| woke > PROMISED))), Moments),
        of(woken, Present(Covariance::<{ DIMENSIONS.len() + 1 }>)),
        First(if arguments.csv.is_some() { samples } else { 0 }),
    );
    // A pair of observers gives a pair.
    let statistic = of(
        |((tilts, dimensions), woke): &(([f64; TIMES], [f64; DIMENSIONS.len()]), Option<f64>)| {
            (*tilts, (*dimensions, *woke))
        },
        statistics,
    );
    let outcome = match shards {
        Some(files) => study.merge(files, &watch, statistic)?,
        None => study.observe(&watch, statistic)?,
    };
    for failed in &outcome.failures.kept {
        bar.println(failed.to_string());
    }
    bar.finish_and_clear();
    match computed.get() {
        0 => println!("{} tops", outcome.samples),
        n => println!("{} tops, {:.0} a second", outcome.samples, n as f64 / seconds.get()),
    }
    if let Some((k, n)) = arguments.shard {
        println!("shard {k} of {n} is in {}; when all are there: `merge {n}`", folder.display());
        return Ok(());
    }

    let (tilts, waking, kept, woken, rows) = outcome.statistic;
    println!(
        "{:.2} % ± {:.2} % sleep for {PROMISED} s; {} of {} wake within {END} s, after {:.2} s ± {:.2} s",
        100.0 * kept.mean(),
        100.0 * kept.standard_error(),
        woken.count(),
        outcome.samples,
        woken.mean()[0],
        woken.covariance()[0][0].sqrt(),
    );
    println!("the nominal one comes to Lagrange's threshold after {:.2} s", threshold());
    println!("{}", table(&woken));
    if let Some(path) = &arguments.csv {
        let names: Vec<String> = DIMENSIONS.iter().map(|(name, ..)| name.replace(' ', "_")).collect();
        let names: Vec<&str> = names.iter().map(String::as_str).chain(["woke"]).collect();
        rows.write_csv(path, &names)?;
        println!("{}", path.display());
    }
    charts(&tilts, &waking, outcome.samples).write(&folder, "monte-carlo")?;
    println!("{}", folder.join("monte-carlo.png").display());
    // All is said: the next run begins anew.
    checkpoints.iter().try_for_each(std::fs::remove_file)?;
    Ok(())
}

/// When the nominal spin, `ω e^(−c t/C)`, is down to `C ω = 2 √(A m g l)`.
fn threshold() -> f64 {
    let [m, l, across, along, c, spin, _] = DIMENSIONS.map(|(_, _, nominal, _)| nominal);
    let about_tip = across + m * l * l;
    along / c * (along * spin / (2.0 * (about_tip * m * 9.81 * l).sqrt())).ln()
}

/// When tilts are kept.
fn time(k: usize) -> f64 {
    END * k as f64 / (TIMES - 1) as f64
}

/// How the moment of waking goes with each dimension.
fn table(woken: &Covariances<{ DIMENSIONS.len() + 1 }>) -> Table {
    let mut table = Table::new();
    table.load_style(presets::ASCII_MARKDOWN);
    table.set_header(["dimension", "nominal", "tolerance", "s per tolerance", "part of the variance"]);
    let covariance = woken.covariance();
    for (k, (name, unit, nominal, tolerance)) in (1..).zip(DIMENSIONS) {
        // Dimensions are drawn independently of each other, so that the slope of the regression is that of each alone.
        let slope = covariance[0][k] / covariance[k][k];
        let part = woken.correlation(0, k).powi(2);
        table.add_row([
            name.into(),
            format!("{nominal:?} {unit}"),
            format!("{:.1} %", 100.0 * tolerance / nominal),
            format!("{:+.2}", slope * tolerance),
            format!("{:.1} %", 100.0 * part),
        ]);
    }
    table
}

/// Quantiles of the tilt over time, and the density of the moment of waking.
fn charts(tilts: &[Sketch; TIMES], waking: &Counts, samples: u64) -> Panels {
    let bands = PROBABILITIES.map(|(p, name)| {
        let points = tilts.iter().enumerate().filter_map(|(k, sketch)| Some((time(k), sketch.quantile(p)?)));
        Series::line(name, points)
    });
    let tilt = bands.into_iter().fold(
        Chart::new(
            "Tilt below which this part of the tops is",
            Axis::linear("time", "s"),
            Axis::linear("tilt", "°"),
        ),
        Chart::with,
    );
    let density = waking
        .bins
        .iter()
        .zip(0..)
        .map(|(&count, k)| (WAKING.middle(k), count as f64 / (samples as f64 * WAKING.width())));
    let moment = Chart::new("When they wake", Axis::linear("time", "s"), Axis::linear("density", "1/s"))
        .with(Series::line("", density))
        .with(Series::context([(PROMISED, 0.0), (PROMISED, 0.3)]));
    Panels::new("Does the top sleep?", [tilt, moment])
        .subtitle(format!("{samples} tops by their tolerances; awake from {AWAKE}° on, fallen at {FALLEN}°"))
}
