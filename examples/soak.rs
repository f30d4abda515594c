//! Long use: the energy of a pendulum over 10⁸ steps of several methods, that of three motions over 10⁶ periods of
//! Taylor series, and 10⁷ samples of an ensemble, some of which fail.
//!
//! ```text
//! cargo run --release --example soak -- steps 100000000      # all methods, or those named after the number
//! cargo run --release --example soak -- periods 1000000
//! cargo run --release --example soak -- samples 10000000
//! ```
//!
//! What is measured: how far the energy strays from that of the start, in units of it, by numbers of steps; how far
//! it and the momenta of ignorable coordinates stray in so many periods; and the peak of the memory that the process
//! has used, by numbers of samples.

#[path = "support/mod.rs"]
mod support;

use indicatif::ProgressBar;
use lagrange_runtime::chart::{Axis, Chart, Series};
use lagrange_runtime::ensemble::{
    Ensemble, Moments, Random,
    rand_distr::{Distribution, Uniform},
};
use lagrange_runtime::prelude::*;
use lagrange_runtime::traits::Analytic;
use lagrange_runtime::{Nystrom12, method::nystrom::Nystrom8};
use std::collections::{BTreeMap, BTreeSet};
use std::error::Error;

lagrangian! {
    /// A bob on a light rod.
    pub system Pendulum {
        param m, l, g = 1.0;
        coord theta: angle;
        T = 0.5 * m * (l * dot(theta)).powi(2);
        V = m * g * l * (1 - cos(theta));
    }
}

lagrangian! {
    /// A particle about a fixed centre.
    pub system Kepler {
        param mu;
        coord r, phi: angle;
        T = 0.5 * (dot(r).powi(2) + (r * dot(phi)).powi(2));
        V = -mu / r;
    }
}

lagrangian! {
    /// The heavy symmetric top by Euler's angles.
    pub system Top {
        param a, c, mgl;
        coord theta: angle, phi: angle, psi: angle;
        T = 0.5 * a * (dot(theta).powi(2) + (dot(phi) * sin(theta)).powi(2))
            + 0.5 * c * (dot(psi) + dot(phi) * cos(theta)).powi(2);
        V = mgl * cos(theta);
    }
}

/// Steps between two looks at the energy.
const LOOK: u64 = 50;

fn main() -> Result<(), Box<dyn Error>> {
    let mut words = std::env::args().skip(1);
    let (what, count) = (words.next(), words.next().map(|n| n.parse::<u64>()).transpose()?);
    let names: Vec<String> = words.collect();
    match (what.as_deref(), count) {
        (Some("steps"), Some(count)) => steps(count, &names),
        (Some("periods"), Some(count)) => periods(count, &names),
        (Some("samples"), Some(count)) => samples(count),
        _ => Err("say `steps`, `periods` or `samples`, and how many".into()),
    }
}

/// The largest deviation of the energy so far, by steps; a point four times a decade.
fn drift<M>(method: M, h: f64, count: u64) -> Result<Vec<(f64, f64)>, Failure>
where
    M: Method<Pendulum, 1>,
{
    let system = Pendulum::new(1.0, 1.0);
    let start = State::new(0.0, [2.0], [0.0]);
    let energy = |at: &State<f64, 1>| system.energy_at(at);
    let first = energy(&start);
    let bar = ProgressBar::new(count);
    let (mut largest, mut points, mut next) = (0.0f64, Vec::new(), 1000.0f64);
    let run = integrate(&system, method, FixedStep::new(h), start).max_steps(count + 1);
    for (step, k) in run.until(h * count as f64).zip(1u64..) {
        let to = step?.to;
        if k.is_multiple_of(LOOK) {
            largest = largest.max(((energy(&to) - first) / first).abs());
            if k as f64 >= next {
                points.push((k as f64, largest));
                next *= 10f64.powf(0.25);
            }
        }
        if k.is_multiple_of(1 << 20) {
            bar.set_position(k);
        }
    }
    bar.finish_and_clear();
    Ok(points)
}

fn steps(count: u64, names: &[String]) -> Result<(), Box<dyn Error>> {
    type Drift = fn(f64, u64) -> Result<Vec<(f64, f64)>, Failure>;
    // Steps at which the local error is small, and the methods can show what they keep: a period is about 8.4.
    let methods: [(&str, f64, Drift); 8] = [
        ("RK4", 0.02, |h, n| drift(Rk4, h, n)),
        ("DOP853", 0.2, |h, n| drift(Dop853, h, n)),
        ("Störmer–Verlet", 0.02, |h, n| drift(Verlet, h, n)),
        ("Gauss 4", 0.1, |h, n| drift(Gauss4, h, n)),
        ("Nyström 8", 0.1, |h, n| drift(Nystrom8, h, n)),
        ("Nyström 12", 0.2, |h, n| drift(Nystrom12, h, n)),
        ("variational midpoint", 0.02, |h, n| drift(VariationalMidpoint, h, n)),
        ("Taylor, order 20", 0.2, |h, n| drift(Taylor::of_order(20), h, n)),
    ];
    let folder = support::charts()?;
    let mut chart = Chart::new(
        "Energy over many steps",
        Axis::log("steps", ""),
        Axis::log("largest relative error of the energy so far", ""),
    )
    .subtitle("pendulum released at 2 rad, unit length and weight; steps of one size");
    for (name, h, drift) in methods {
        if !names.is_empty() && !names.iter().any(|wanted| wanted == name) {
            continue;
        }
        let points = drift(h, count)?;
        println!("{name}, h = {h}: {}", decades(&points));
        chart = chart.with(Series::new(format!("{name}, h = {h}"), points));
    }
    chart.write(&folder, "soak")?;
    println!("{}", folder.join("soak.svg").display());
    Ok(())
}

/// The errors at powers of ten.
fn decades(points: &[(f64, f64)]) -> String {
    let told = points.iter().filter(|(k, _)| (k.log10().round() - k.log10()).abs() < 0.01);
    told.map(|(k, e)| format!("{k:.0e}: {e:.1e}")).collect::<Vec<_>>().join(", ")
}

/// Starts of each motion.
const STARTS: u32 = 32;

/// Names of what is conserved, and by numbers of periods the root mean square of what it changes by in so many, in
/// units of that of its values.
type Errors = Vec<(String, Vec<(f64, f64)>)>;

/// Errors of the energy and of the momenta of ignorable coordinates, over all starts, and in each over the first ten
/// spans of a length, one after the other: single walks scatter too much to tell a drift from.
fn walk<Sys: Analytic<N, Scalar = f64> + Energies<N> + Lagrangian<N> + Sync, const N: usize>(
    system: &Sys,
    start: impl Fn(f64) -> State<f64, N> + Sync,
    period: f64,
    count: u64,
) -> Result<Errors, Failure> {
    // What is left out of the series at a step adds up in proportion to time: at 1e-18 it is what counts after 10⁵
    // periods.
    const TOLERANCE: f64 = 1e-21;
    let spans: Vec<u64> = (1..).map(|d| 10u64.pow(d)).take_while(|n| *n <= count).collect();
    let times: BTreeSet<u64> =
        spans.iter().flat_map(|n| (0..=10).map(move |k| k * n)).filter(|n| *n <= count).collect();
    let momenta = Sys::FACTS.ignorable;
    let conserved = |at: &State<f64, N>| {
        let p = system.momenta_at(at);
        let energy = system.energy_at(at);
        std::iter::once(energy).chain(momenta.iter().map(|i| p[*i])).collect::<Vec<_>>()
    };
    let bar = ProgressBar::new(u64::from(STARTS) * count);
    let alone = |n: u32| -> Result<BTreeMap<u64, Vec<f64>>, Failure> {
        let start = start(f64::from(n) / f64::from(STARTS));
        let (method, control) = (Taylor, TaylorController::tolerance(TOLERANCE));
        let mut run = integrate(system, method, control, start).max_steps(u64::MAX);
        let mut walk = BTreeMap::new();
        for n in &times {
            let before = walk.last_key_value().map_or(0, |(n, _)| *n);
            run = run.until(*n as f64 * period);
            run.run_to_end()?;
            walk.insert(*n, conserved(run.state()));
            bar.inc(n - before);
        }
        Ok(walk)
    };
    let threads = std::thread::available_parallelism().map_or(1, |n| n.get() as u32);
    let walks = std::thread::scope(|scope| {
        let share = |r| (r..STARTS).step_by(threads as usize).map(alone).collect::<Result<Vec<_>, _>>();
        let all: Vec<_> = (0..threads).map(|r| scope.spawn(move || share(r))).collect();
        let joined = all.into_iter().map(|one| one.join().expect("no thread panics"));
        joined.collect::<Result<Vec<_>, _>>().map(|all| all.concat())
    })?;
    bar.finish_and_clear();
    let momenta = momenta.iter().map(|i| format!("momentum of {}", Sys::FACTS.coordinates[*i]));
    let points = |c: usize| {
        let value = root_mean_square(walks.iter().map(|walk| walk[&0][c]));
        let change = |span: u64| {
            let ends = |walk: &BTreeMap<u64, Vec<f64>>| {
                (0..10)
                    .filter_map(|k| Some(walk.get(&((k + 1) * span))?[c] - walk[&(k * span)][c]))
                    .collect::<Vec<_>>()
            };
            (span as f64, root_mean_square(walks.iter().flat_map(ends)) / value)
        };
        spans.iter().copied().map(change).collect()
    };
    Ok(std::iter::once("energy".into())
        .chain(momenta)
        .enumerate()
        .map(|(c, name)| (name, points(c)))
        .collect())
}

fn root_mean_square(all: impl Iterator<Item = f64>) -> f64 {
    let (count, sum) = all.fold((0u32, 0.0), |(count, sum), x| (count + 1, sum + x * x));
    (sum / f64::from(count)).sqrt()
}

/// The powers of the number of steps by which errors grow from one decade to the next.
fn growth(points: &[(f64, f64)]) -> String {
    let power =
        |pair: &[(f64, f64)]| format!("{:.2}", (pair[1].1 / pair[0].1).ln() / (pair[1].0 / pair[0].0).ln());
    points.windows(2).map(power).collect::<Vec<_>>().join(", ")
}

fn periods(count: u64, names: &[String]) -> Result<(), Box<dyn Error>> {
    type Walk = fn(u64) -> Result<Errors, Failure>;
    let motions: [(&str, Walk); 3] = [
        ("pendulum", |count| {
            // In about a period of small vibrations; it matters for the scale of time only.
            walk(&Pendulum::new(1.0, 1.0), |x| State::new(0.0, [1.0 + x], [0.1]), 7.0, count)
        }),
        ("Kepler, polar", |count| {
            // At the pericentres of ellipses with the major axis 2.
            let start = |x: f64| {
                let e = 0.55 + 0.1 * x;
                let v = ((1.0 + e) / (1.0 - e)).sqrt();
                State::new(0.0, [1.0 - e, 0.0], [0.0, v / (1.0 - e)])
            };
            walk(&Kepler::new(1.0), start, std::f64::consts::TAU, count)
        }),
        ("top", |count| {
            let start = |x| State::new(0.0, [0.6 + x, 0.0, 0.0], [0.1, 0.4, 3.0]);
            walk(&Top::new(1.0, 0.7, 1.3), start, 3.0, count)
        }),
    ];
    let folder = support::charts()?;
    let mut chart = Chart::new(
        "Rounding errors over many periods",
        Axis::log("periods", ""),
        Axis::log("relative error of the energy", ""),
    )
    .subtitle(format!("Taylor series, order 20; root mean square of {STARTS} starts"));
    for (name, walk) in motions {
        if !names.is_empty() && !names.iter().any(|wanted| name.starts_with(wanted.as_str())) {
            continue;
        }
        for (conserved, points) in walk(count)? {
            println!("{name}, {conserved}: {}; powers of time {}", decades(&points), growth(&points));
            if conserved == "energy" {
                chart = chart.with(Series::new(name, points));
            }
        }
    }
    let root = [10.0, count as f64].map(|n| (n, 1e-16 * n.sqrt()));
    chart = chart.with(Series::new("1e-16 √n", root.to_vec()));
    chart.write(&folder, "soak-periods")?;
    println!("{}", folder.join("soak-periods.svg").display());
    Ok(())
}

/// Mistake by which a sample is made to fail.
#[derive(Clone, Copy, PartialEq, Debug)]
enum Injected {
    Nothing,
    NoLength,
    NoNumber,
    Runaway,
}

fn samples(count: u64) -> Result<(), Box<dyn Error>> {
    let one = Uniform::new(0.0, 1.0)?;
    println!("samples, failed, mean angle, peak of memory");
    let mut size = 10_000;
    while size <= count {
        let injected = |u: f64| match u {
            u if u < 0.001 => Injected::NoLength,
            u if u < 0.002 => Injected::NoNumber,
            u if u < 0.003 => Injected::Runaway,
            _ => Injected::Nothing,
        };
        let bar = ProgressBar::new(size);
        let outcome = Ensemble::new(Random::seed(5), size, |mut rng| {
            let mut draw = || one.sample(&mut rng);
            let (kind, angle) = (injected(draw()), 2.0 * draw());
            let (length, angle, gravity) = match kind {
                Injected::Nothing => (1.0, angle, 1.0),
                Injected::NoLength => (0.0, angle, 1.0),
                Injected::NoNumber => (1.0, f64::NAN, 1.0),
                Injected::Runaway => (1.0, angle, f64::MAX),
            };
            (Pendulum { m: 1.0, l: length, g: gravity }, State::new(0.0, [angle], [0.0]))
        })
        .integrate(DormandPrince5, PiController::tolerance(1e-6), 1.0)
        .progress(|progress| bar.set_position(progress.done))
        .reduce(|_, run| Ok(run.final_state()?.q[0]), Moments)?;
        bar.finish_and_clear();
        let mut kinds: BTreeMap<&str, u64> = BTreeMap::new();
        for failed in &outcome.failures.kept {
            *kinds.entry(failed.failure.name()).or_default() += 1;
        }
        let (failures, moment) = (&outcome.failures, &outcome.statistic);
        assert_eq!(failures.count + moment.count(), size, "every sample is counted once");
        println!(
            "{size:e}, {} (of the first {}: {kinds:?}), {:.6}, {}",
            failures.count,
            failures.kept.len(),
            moment.mean(),
            peak().unwrap_or("unknown".into())
        );
        size *= 10;
    }
    Ok(())
}

/// `VmHWM`, where the system tells.
fn peak() -> Option<String> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    Some(status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?.trim().into())
}
