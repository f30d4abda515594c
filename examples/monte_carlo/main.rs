//! Does the top sleep? A tolerance analysis.
//!
//! A top that spins fast stands upright: it sleeps while `(C ω)² > 4 A m g l` (Lagrange's threshold;
//! Beatty, *Principles of Engineering Mechanics* 2, 2006, section 11.12.4.4). Friction at its tip takes the spin
//! away, and it wakes. The maker promises eighteen seconds. Which part of the tops keeps the promise, and which
//! tolerance is the one to tighten?
//!
//! Masses, sizes, friction, spin and tilt of each top are drawn by their tolerances. Of each trajectory the tilt at
//! given times is kept and the moment at which it first exceeds five degrees; of all of them quantiles, a histogram,
//! and the correlation of that moment with each dimension.
//!
//! `--confidence 0.02` stops once the mean moment of waking is known to 0.02 s, and `--multifidelity` comes there
//! with a tenth of the simulations or less: the moment at which the spin is down to Lagrange's threshold is a closed
//! form, and its control variate.
//!
//! `cargo run --release --example monte_carlo`; stop it, start it again, and it goes on where it was. `-- --help`
//! lists what can be chosen. On a batch system without MPI the study is divided, and put together at the end, with
//! the same bits:
//!
//! ```console
//! $ monte_carlo --samples 1000000 --shard 1/3        # on one machine
//! $ monte_carlo --samples 1000000 --shard 2/3        # on another, and so on
//! $ monte_carlo --samples 1000000 merge 3            # where all their files are in one folder
//! ```

mod options;
#[path = "../support/mod.rs"]
mod support;

use comfy_table::{Table, presets};
use indicatif::{ProgressBar, ProgressStyle};
use lagrange_runtime::Occurrence;
use lagrange_runtime::chart::{Axis, Chart, Panels, Series};
use lagrange_runtime::ensemble::rand_distr::{Distribution, StandardNormal};
use lagrange_runtime::ensemble::{
    ClosedForm, Collect, Collected, ConfidenceInterval, Counts, Covariance, Covariances, Each, Ensemble,
    HalfWidth, Histogram, Model, Moments, Multifidelity, Present, Quantiles, Random, Simulation, Sketch,
    Source, Statistic, of,
};
use lagrange_runtime::lanes::{Fused, Occurrences, Sampled};
use lagrange_runtime::prelude::*;
use options::{Arguments, Command};
use std::cell::Cell;
use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

lagrangian! {
    /// A symmetric top on its tip. Its axis is turned about x and then about y, which is regular where it stands
    /// upright.
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

/// Dimensions that are drawn: name, unit, nominal value, and tolerance, which is one standard deviation.
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
    let arguments = Arguments::checked(std::env::args_os()).unwrap_or_else(|error| error.exit());
    let done = match arguments.confidence {
        Some(half_width) if arguments.multifidelity => with_a_closed_form(&arguments, half_width),
        _ => run(arguments),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: Arguments) -> Result<(), Box<dyn Error>> {
    let Arguments { samples, seed, tolerance, threads, .. } = arguments;
    let folder = folder(&arguments)?;
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
        of(|(_, (_, woke)): &Output| woke.unwrap_or(END), Moments),
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
    let outcome = match (shards, arguments.confidence) {
        (Some(files), _) => study.merge(files, &watch, statistic)?,
        (None, Some(half_width)) => study.observe_until(&watch, statistic, HalfWidth::of(half_width))?,
        (None, None) => study.observe(&watch, statistic)?,
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

    let (moment, tilts, waking, kept, woken, rows) = outcome.statistic;
    println!(
        "{:.2} % ± {:.2} % sleep for {PROMISED} s; {} of {} wake within {END} s, after {:.2} s ± {:.2} s",
        100.0 * kept.mean(),
        100.0 * kept.standard_error(),
        woken.count(),
        outcome.samples,
        woken.mean()[0],
        woken.covariance()[0][0].sqrt(),
    );
    println!(
        "mean moment of waking, {END} s for those that do not: {:.3} s ± {:.3} s (95 %)",
        moment.mean(),
        moment.half_width(0.95)
    );
    println!(
        "the nominal one comes to Lagrange's threshold after {:.2} s",
        threshold(DIMENSIONS.map(|(.., nominal, _)| nominal))
    );
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

/// The folder of charts.
fn folder(arguments: &Arguments) -> std::io::Result<PathBuf> {
    arguments.folder.clone().map_or_else(support::charts, support::made)
}

/// The moment at which the spin, `ω e^(−c t/C)`, is down to `C ω = 2 √(A m g l)`, by the [`DIMENSIONS`] of a top.
fn threshold([m, l, across, along, c, spin, _]: [f64; DIMENSIONS.len()]) -> f64 {
    let about_tip = across + m * l * l;
    along / c * (along * spin / (2.0 * (about_tip * m * 9.81 * l).sqrt())).ln()
}

/// The mean moment of waking by few simulations, and many closed forms as their control variate.
fn with_a_closed_form(arguments: &Arguments, half_width: f64) -> Result<(), Box<dyn Error>> {
    let folder = folder(arguments)?;
    let awake = AWAKE.to_radians().cos();
    let wakes = Event::falling(move |at: &State<f64, 3>| height(at) - awake).terminal();
    let moment = Occurrences::new(wakes, |_: &Top, met: &[Occurrence<f64, 3>], _: &State<f64, 3>| {
        met.first().map_or(END, |woke| woke.state.t)
    });
    let tolerance = PiController::tolerance(arguments.tolerance);
    let full = Simulation::new(draw, Dop853, tolerance, END, moment).in_lanes(Fused);
    let closed = ClosedForm::new(|rng| {
        let (top, start) = draw(rng);
        threshold([top.m, top.l, top.across, top.along, top.c, start.qd[2], start.q[0]])
    });
    // Of the same tops, how near is one to the other?
    let source = Random::seed(arguments.seed);
    let some = || (0..400).map(|index| source.draw(index)).collect();
    let pairs: Vec<(f64, f64)> = (closed.evaluate(some()).into_iter().zip(full.evaluate(some())))
        .filter_map(|(closed, full)| Some((closed.output.ok()?, full.output.ok()?)))
        .collect();

    let study = Multifidelity::new(source, 1 << 40, full, closed)
        .named("does the top sleep, with a closed form")
        .threads(arguments.threads)
        .pilot_samples(256);
    let estimate = study.to_half_width(half_width)?;
    println!("{}", estimate.pilot);
    println!(
        "mean moment of waking, {END} s for those that do not: {:.3} s ± {:.3} s (95 %)",
        estimate.mean(),
        estimate.half_width(0.95)
    );
    let [full, closed] = estimate.samples;
    println!(
        "{full} simulations and {closed} closed forms after a pilot of {}; simulations alone would have been about {:.0}",
        estimate.pilot.samples,
        estimate.plain_samples()
    );

    // The half-width that costs lead to.
    let [cost, _] = estimate.pilot.cost;
    let deviation = estimate.pilot.standard_deviation[0];
    let budgets: Vec<f64> = (0..5).map(|k| cost * 600.0 * 2f64.powi(k)).collect();
    let alone = budgets.iter().map(|budget| (budget / cost, 1.96 * deviation / (budget / cost).sqrt()));
    let measured: Vec<(f64, f64)> = (budgets.iter())
        .map(|budget| Ok((budget / cost, study.within_budget(*budget)?.half_width(0.95))))
        .collect::<Result<_, Box<dyn Error>>>()?;
    let scatter = Chart::new(
        "400 tops, by closed form and by simulation",
        Axis::linear("Lagrange's threshold", "s"),
        Axis::linear("moment of waking", "s"),
    )
    .with(Series::markers("", pairs));
    let costs = Chart::new(
        "Half-width of the mean, 95 %",
        Axis::log("cost, in simulations", ""),
        Axis::log("half-width", "s"),
    )
    .with(Series::line("simulations alone", alone))
    .with(Series::markers("with the closed form, pilot included", measured));
    Panels::new("A closed form beside the simulation", [scatter, costs])
        .subtitle(format!("{}", estimate.pilot))
        .write(&folder, "multifidelity")?;
    println!("{}", folder.join("multifidelity.png").display());
    Ok(())
}

/// Time at which tilts are kept.
fn time(k: usize) -> f64 {
    END * k as f64 / (TIMES - 1) as f64
}

/// Table of the dependence of the moment of waking on each dimension.
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
