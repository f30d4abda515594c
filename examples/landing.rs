//! Dispersion of shots with drag, a wind that grows with height, and tolerances of the launch.
//!
//! A shell of half a kilogram is shot at 45° with 120 m/s. Speed, elevation, azimuth, mass, drag, the density of the
//! air and the wind along and across the range are drawn by their tolerances, which are standard deviations of
//! independent normal variables. Each shot runs to `Shell::GROUND`, an event of the system. Of all of them: the
//! ellipse of the normal distribution with the same covariance, the map of where the densest half, 90 % and 99 % of
//! the shots land, quantiles of the miss distance with their confidence, and a table of which tolerance decides.
//!
//! That table has the first-order index of each tolerance Xᵢ, `Sᵢ = Var(E[Y | Xᵢ]) / Var(Y)` (Sobol', *Math. Comput.
//! Simul.* 55, 2001), the part by which the variance of Y would shrink on average if Xᵢ were known. It is found from
//! the same samples, by the means of Y in bins of Xᵢ of equal probability (Plischke, Borgonovo and Smith, *Eur. J.
//! Oper. Res.* 226, 2013: indices "from given data"), less the part that bins have by chance, and beside it what a
//! straight line explains, the square of the correlation. (A tolerance varies within its bins, too, so that a
//! hundredth of each index is missing.) Where the two agree, the influence is linear; indices that sum to 1 leave
//! nothing to interactions.
//!
//! The confidence of a quantile is that of its rank: of n shots, those of a part p have n p ± z √(n p (1 − p)) before
//! them, whatever the distribution is (David and Nagaraja, *Order Statistics*, 2003, section 7.1).
//!
//! `cargo run --release --example landing` makes a million shots. `-- --samples 10000` makes fewer, `-- --help` lists
//! what can be chosen.

#[path = "support/mod.rs"]
mod support;

use clap::{Parser, value_parser};
use comfy_table::{Table, presets};
use indicatif::{ProgressBar, ProgressStyle};
use lagrange_runtime::Occurrence;
use lagrange_runtime::chart::{Axis, Chart, Panels, Series};
use lagrange_runtime::ensemble::rand_distr::{Distribution, StandardNormal};
use lagrange_runtime::ensemble::{
    Covariance, Covariances, Ensemble, Moment, Moments, Quantiles, Random, Sketch, Source, Statistic,
    normal_quantile, of,
};
use lagrange_runtime::lanes::{Fused, Occurrences};
use lagrange_runtime::prelude::*;
use std::error::Error;
use std::f64::consts::{SQRT_2, TAU};
use std::path::PathBuf;

lagrangian! {
    /// A shell: x along the range, y across it, z upward. Quadratic drag in air that thins with height, and a wind
    /// that grows with it.
    pub system Shell {
        /// Mass, and drag ½ ρ c_d A at the ground.
        param m, drag;
        /// Wind far above the ground, along the range and across it.
        param along, across;
        param g = 9.81;
        coord x: length, y: length, z: length;
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2));
        V = m * g * z;
        let profile = 1 - exp(-z / 50);
        let u = dot(x) - along * profile;
        let v = dot(y) - across * profile;
        let k = drag * exp(-z / 8000) * (u * u + v * v + dot(z).powi(2)).sqrt();
        force [-k * u, -k * v, -k * dot(z)] at [x, y, z];
        /// It lands.
        event ground: z, falling, terminal;
        event apex: dot(z), falling;
    }
}

/// Tolerances: name, unit, nominal value, standard deviation.
const TOLERANCES: [(&str, &str, f64, f64); 8] = [
    ("speed", "m/s", 120.0, 0.6),
    ("elevation", "rad", 0.785, 0.008),
    ("azimuth", "rad", 0.0, 0.004),
    ("mass", "kg", 0.5, 0.004),
    ("drag coefficient", "", 1.0, 0.02),
    ("density of air", "", 1.0, 0.01),
    ("wind along", "m/s", 3.0, 1.0),
    ("wind across", "m/s", 0.0, 1.0),
];
const COUNT: usize = TOLERANCES.len();

/// Drag ½ ρ c_d A with the nominal coefficients, in kg/m.
const DRAG: f64 = 4e-4;
/// The longest flight.
const END: f64 = 120.0;
/// Bins of a tolerance, of equal probability.
const BINS: usize = 24;
/// Cells of the map along each side, and their number.
const CELLS: usize = 80;
/// Half the side of the map, in standard deviations of the wider direction.
const REACH: f64 = 4.0;
const PROBABILITIES: [f64; 5] = [0.25, 0.5, 0.75, 0.9, 0.99];

/// A shell with these errors, each in standard deviations.
fn shell(errors: [f64; COUNT]) -> (Shell, State<f64, 3>) {
    let values: [f64; COUNT] = core::array::from_fn(|k| TOLERANCES[k].2 + TOLERANCES[k].3 * errors[k]);
    let [v, elevation, azimuth, m, coefficient, density, along, across] = values;
    let (up, flat) = (v * elevation.sin(), v * elevation.cos());
    let start = State::new(0.0, [0.0; 3], [flat * azimuth.cos(), flat * azimuth.sin(), up]);
    (Shell::new(m, DRAG * coefficient * density, along, across), start)
}

/// The errors of one sample, which its index gives again.
fn errors(mut rng: <Random as Source>::Draw) -> [f64; COUNT] {
    core::array::from_fn(|_| StandardNormal.sample(&mut rng))
}

/// Place of landing, along and across the range, and greatest height.
#[derive(Clone, Copy)]
struct Landed {
    place: [f64; 2],
    height: f64,
}

/// A statistic of the errors of a sample and of where it landed.
#[derive(Clone)]
struct WithErrors<T>(Random, T);

impl<T: Statistic<([f64; COUNT], Landed)>> Statistic<Landed> for WithErrors<T> {
    type State = T::State;

    fn empty(&self) -> T::State {
        self.1.empty()
    }

    fn add(&self, state: &mut T::State, index: u64, output: &Landed) {
        self.1.add(state, index, &(errors(self.0.draw(index)), *output));
    }

    fn merge(&self, state: &mut T::State, later: T::State) {
        self.1.merge(state, later);
    }

    fn describe(&self) -> String {
        format!("with the errors of {}: {}", self.0.describe(), self.1.describe())
    }
}

/// Mean of the place in bins of each error, of equal probability, between these edges.
#[derive(Clone)]
struct Binned([f64; BINS - 1]);

type Bins = [[[Moment; BINS]; COUNT]; 2];

impl Statistic<([f64; COUNT], Landed)> for Binned {
    type State = Bins;

    fn empty(&self) -> Bins {
        [[[Moment::default(); BINS]; COUNT]; 2]
    }

    fn add(&self, state: &mut Bins, index: u64, (errors, landed): &([f64; COUNT], Landed)) {
        for (k, error) in errors.iter().enumerate() {
            let bin = self.0.partition_point(|edge| edge < error);
            for (direction, place) in state.iter_mut().zip(&landed.place) {
                Moments.add(&mut direction[k][bin], index, place);
            }
        }
    }

    fn merge(&self, state: &mut Bins, later: Bins) {
        for (moment, later) in state.iter_mut().flatten().flatten().zip(later.into_iter().flatten().flatten())
        {
            Moments.merge(moment, later);
        }
    }

    fn describe(&self) -> String {
        format!("places in {BINS} bins of each error")
    }
}

/// First-order index from bins: the part of the variance between their means, less the part that is there by chance.
fn index_of(bins: &[Moment; BINS]) -> f64 {
    let filled = || bins.iter().filter(|bin| bin.count() > 1);
    let n: f64 = filled().map(|bin| bin.count() as f64).sum();
    let mean = filled().map(|bin| bin.count() as f64 * bin.mean()).sum::<f64>() / n;
    let between: f64 = filled().map(|bin| bin.count() as f64 * (bin.mean() - mean).powi(2)).sum();
    let within: f64 = filled().map(|bin| (bin.count() - 1) as f64 * bin.variance()).sum();
    1.0 - within / (between + within) * (n - 1.0) / (n - filled().count() as f64)
}

/// Counts of landings in the cells of a square.
#[derive(Clone)]
struct Cells {
    centre: [f64; 2],
    half: f64,
}

impl Cells {
    /// The centre of a cell.
    fn middle(&self, cell: usize) -> (f64, f64) {
        let part = |i: usize| 2.0 * (i as f64 + 0.5) / CELLS as f64 - 1.0;
        (self.centre[0] + self.half * part(cell % CELLS), self.centre[1] + self.half * part(cell / CELLS))
    }
}

impl Statistic<Landed> for Cells {
    type State = Vec<u64>;

    fn empty(&self) -> Vec<u64> {
        vec![0; CELLS * CELLS]
    }

    fn add(&self, state: &mut Vec<u64>, _: u64, landed: &Landed) {
        let place = |i: usize| {
            let part = 0.5 * (landed.place[i] - self.centre[i]) / self.half + 0.5;
            (0.0..1.0).contains(&part).then_some((part * CELLS as f64) as usize)
        };
        if let (Some(x), Some(y)) = (place(0), place(1)) {
            state[y * CELLS + x] += 1;
        }
    }

    fn merge(&self, state: &mut Vec<u64>, later: Vec<u64>) {
        state.iter_mut().zip(later).for_each(|(count, more)| *count += more);
    }

    fn describe(&self) -> String {
        format!("{CELLS} by {CELLS} cells about {:?}, half {:?}", self.centre, self.half)
    }
}

/// Dispersion of shots with drag, wind and tolerances of the launch.
#[derive(Parser)]
#[command(version)]
struct Arguments {
    /// Number of shots.
    #[arg(long, value_name = "N", default_value_t = 1_000_000, value_parser = value_parser!(u64).range(1000..))]
    samples: u64,
    /// Seed of the random numbers.
    #[arg(long, value_name = "SEED", default_value_t = 1)]
    seed: u64,
    /// Tolerance of a step, absolute and relative.
    #[arg(long, value_name = "ERROR", default_value_t = 1e-8)]
    tolerance: f64,
    /// Number of threads; 0 for as many as there are processors.
    #[arg(long, value_name = "N", default_value_t = 0)]
    threads: usize,
    /// Folder of the chart (default: charts, in cargo's target folder).
    #[arg(long, value_name = "FOLDER")]
    folder: Option<PathBuf>,
}

fn main() -> Result<(), Box<dyn Error>> {
    let Arguments { samples, seed, tolerance, threads, folder } = Arguments::parse();
    if !(tolerance > 0.0 && tolerance.is_finite()) {
        return Err("the tolerance has to be a positive number".into());
    }
    let folder = folder.map_or_else(support::charts, support::made)?;
    let source = Random::seed(seed);
    let control = || PiController::tolerance(tolerance);

    let (nominal, start) = shell([0.0; COUNT]);
    let aimed =
        integrate(&nominal, Dop853, control(), start).until(END).events(Shell::GROUND).final_state()?;
    let target = [aimed.q[0], aimed.q[1]];

    let watch = Occurrences::new(
        (Shell::GROUND, Shell::APEX),
        |_: &Shell, met: &[Occurrence<f64, 3>], end: &State<f64, 3>| {
            let apex = met.iter().find(|occurrence| occurrence.name == "apex");
            Landed { place: [end.q[0], end.q[1]], height: apex.map_or(0.0, |apex| apex.state.q[2]) }
        },
    );
    let study = |samples: u64| {
        Ensemble::new(source.clone(), samples, |rng| shell(errors(rng)))
            .integrate(Dop853, control(), END)
            .threads(threads)
    };
    // A first look says how large the map has to be.
    let place = |landed: &Landed| landed.place;
    let first = study(1000).in_lanes(Fused).observe(&watch, of(place, Covariance::<2>))?.statistic;
    let cells = Cells {
        centre: [first.mean()[0], first.mean()[1]],
        half: REACH * first.covariance()[0][0].max(first.covariance()[1][1]).sqrt(),
    };

    let bar = ProgressBar::new(samples)
        .with_style(ProgressStyle::with_template("{bar:40} {percent} %, {msg}, {eta} left")?);
    let statistic = (
        WithErrors(source.clone(), of(together, Covariance::<{ COUNT + 2 }>)),
        WithErrors(
            source.clone(),
            Binned(core::array::from_fn(|k| normal_quantile((k + 1) as f64 / BINS as f64))),
        ),
        cells.clone(),
        of(|l: &Landed| (l.place[0] - target[0]).hypot(l.place[1] - target[1]), Quantiles::to(0.001)),
        of(|landed: &Landed| landed.height, Moments),
    );
    let begun = std::time::Instant::now();
    let outcome = study(samples)
        .progress(|progress| {
            bar.set_position(progress.done);
            bar.set_message(format!("{:.0} shots a second", progress.rate().unwrap_or(0.0)));
        })
        .in_lanes(Fused)
        .observe(&watch, statistic)?;
    bar.finish_and_clear();
    println!("{samples} shots in {:.1} s, {} failed", begun.elapsed().as_secs_f64(), outcome.failures.count);

    let (all, bins, map, miss, height) = outcome.statistic;
    println!("aimed at {:.1} m, {:.1} m across; nominal flight {:.2} s", target[0], target[1], aimed.t);
    println!(
        "landed at {:.2} m ± {:.2} m, {:.2} m ± {:.2} m across; greatest height {:.2} m ± {:.2} m",
        all.mean()[0],
        all.covariance()[0][0].sqrt(),
        all.mean()[1],
        all.covariance()[1][1].sqrt(),
        height.mean(),
        height.standard_deviation(),
    );
    println!("{}", quantiles(&miss));
    println!("{}", table(&all, &bins));
    chart(&all, &bins, &cells, &map, target, samples).write(&folder, "landing")?;
    println!("{}", folder.join("landing.png").display());
    Ok(())
}

/// Place of landing and errors in one.
fn together((errors, landed): &([f64; COUNT], Landed)) -> [f64; COUNT + 2] {
    core::array::from_fn(|k| if k < 2 { landed.place[k] } else { errors[k - 2] })
}

/// Quantiles of the distance from where was aimed, each with the quantiles of the ranks that enclose it with a
/// probability of 95 %.
fn quantiles(miss: &Sketch) -> Table {
    let mut table = Table::new();
    table.load_style(presets::ASCII_MARKDOWN);
    table.set_header(["of the shots", "land within", "with 95 % confidence"]);
    for p in PROBABILITIES {
        let half = normal_quantile(0.975) * (p * (1.0 - p) / miss.count() as f64).sqrt();
        let [low, at, high] =
            [-half, 0.0, half].map(|by| miss.quantile((p + by).clamp(0.0, 1.0)).unwrap_or(f64::NAN));
        table.add_row([
            format!("{} %", 100.0 * p),
            format!("{at:.2} m"),
            format!("{low:.2} m to {high:.2} m"),
        ]);
    }
    table
}

/// Table of the effect of each tolerance, along and across the range.
fn table(all: &Covariances<{ COUNT + 2 }>, bins: &Bins) -> Table {
    let mut table = Table::new();
    table.load_style(presets::ASCII_MARKDOWN);
    table.set_header([
        "tolerance",
        "1 σ",
        "range, m per σ",
        "part of its variance",
        "linear",
        "across, m per σ",
        "part",
        "linear",
    ]);
    let mut sums = [0.0; 2];
    for (k, (name, unit, _, deviation)) in TOLERANCES.into_iter().enumerate() {
        let mut row = vec![name.to_string(), format!("{deviation} {unit}")];
        for direction in 0..2 {
            let index = index_of(&bins[direction][k]);
            sums[direction] += index;
            let slope = all.covariance()[direction][k + 2] / all.covariance()[k + 2][k + 2];
            let linear = all.correlation(direction, k + 2).powi(2);
            row.extend([format!("{slope:+.2}"), percent(index), percent(linear)]);
        }
        table.add_row(row);
    }
    let blank = String::new;
    table.add_row([
        "all".to_string(),
        blank(),
        blank(),
        percent(sums[0]),
        blank(),
        blank(),
        percent(sums[1]),
        blank(),
    ]);
    table
}

fn percent(part: f64) -> String {
    format!("{:.1} %", 100.0 * part.max(0.0))
}

/// The map with the ellipse, and how the range goes with each tolerance.
fn chart(
    all: &Covariances<{ COUNT + 2 }>,
    bins: &Bins,
    cells: &Cells,
    map: &[u64],
    target: [f64; 2],
    samples: u64,
) -> Panels {
    let mut order: Vec<usize> = (0..map.len()).filter(|cell| map[*cell] > 0).collect();
    order.sort_by_key(|cell| (std::cmp::Reverse(map[*cell]), *cell));
    let mut passed = 0;
    let parts: Vec<(f64, usize)> = order
        .into_iter()
        .map(|cell| {
            let before = passed as f64 / samples as f64;
            passed += map[cell];
            (before, cell)
        })
        .collect();
    let ground = Chart::new(
        "Where the densest parts of the shots land, and the ellipses of 50 % and 95 %",
        Axis::linear("along the range", "m"),
        Axis::linear("across", "m"),
    )
    .equal_aspect();
    let classes = [("densest 50 %", 0.0, 0.5), ("to 90 %", 0.5, 0.9), ("to 99 %", 0.9, 0.99)];
    let ground = classes.into_iter().fold(ground, |chart, (name, from, to)| {
        let inside = parts.iter().filter(|(before, _)| (from..to).contains(before));
        chart.with(Series::markers(name, inside.map(|(_, cell)| cells.middle(*cell))))
    });
    // x = mean + r L (cos, sin), with the covariance L Lᵀ and r² = −2 ln(1 − p).
    let c = all.covariance();
    let l = [c[0][0].sqrt(), c[0][1] / c[0][0].sqrt(), (c[1][1] - c[0][1] * c[0][1] / c[0][0]).sqrt()];
    let ground = [0.5, 0.95].into_iter().fold(ground, |chart, p: f64| {
        let r = SQRT_2 * (-(1.0 - p).ln()).sqrt();
        let around = (0..=180).map(|k| (TAU * f64::from(k) / 180.0).sin_cos());
        let points = around.map(|(sin, cos)| {
            (all.mean()[0] + r * l[0] * cos, all.mean()[1] + r * (l[1] * cos + l[2] * sin))
        });
        chart.with(Series::context(points))
    });
    let ground = ground.with(Series::markers("aimed at", [(target[0], target[1])]));
    let ranges = Chart::new(
        "Mean range of the shots with this error",
        Axis::linear("error of one tolerance", "σ"),
        Axis::linear("mean range", "m"),
    );
    // The mean of a normal variable within a bin of equal probability is near its middle by rank.
    let middle = |bin: usize| normal_quantile((bin as f64 + 0.5) / BINS as f64);
    let mut by_part: Vec<usize> = (0..COUNT).collect();
    by_part.sort_by(|a, b| index_of(&bins[0][*b]).total_cmp(&index_of(&bins[0][*a])));
    let ranges = by_part.into_iter().take(5).fold(ranges, |chart, k| {
        chart.with(Series::line(TOLERANCES[k].0, (0..BINS).map(|bin| (middle(bin), bins[0][k][bin].mean()))))
    });
    Panels::new("Where does it land?", [ground, ranges])
        .subtitle(format!("{samples} shells with drag and wind, by their tolerances"))
}
