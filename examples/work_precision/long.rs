//! Energy and momenta over many periods, of each method at the most that all may cost.

use crate::measure::bar_style;
use crate::methods::{Family, Parameter, Sweep};
use crate::problems::{Long, Problem};
use indicatif::ProgressBar;

/// Periods over which the cost of a method is found.
const TRIAL: f64 = 20.0;

/// States looked at in each of the periods that are looked at, where steps are equal.
const SAMPLES: u32 = 32;

/// Number of those periods in each decade.
const PER_DECADE: u32 = 5;

/// An invariant that is this far off, relative to itself, is lost.
const LOST: f64 = 1.0;

/// One method over many periods.
pub struct Drift {
    pub method: &'static str,
    pub family: Family,
    pub parameter: Parameter,
    pub value: f64,
    /// Evaluations of the right-hand side in a period.
    pub cost: f64,
    /// The number of the period, and for each invariant its largest relative error in that period. Empty if the method
    /// cannot run at the given cost.
    pub points: Vec<(f64, Vec<f64>)>,
}

/// Follows every method over `decades` decades of periods.
pub fn drifts<Sys, const N: usize>(
    problem: &Problem<Sys, N>,
    long: &Long<Sys, N>,
    sweeps: &[Sweep<'_, N>],
    decades: u32,
) -> Vec<Drift> {
    let bar = ProgressBar::new(sweeps.len() as u64).with_message(format!("{}, long", problem.name));
    bar.set_style(bar_style());
    let follow = |sweep| {
        let found = calibrate(long, sweep);
        bar.inc(1);
        let (value, cost) = found.unwrap_or((f64::NAN, f64::NAN));
        let points = found.map_or_else(Vec::new, |_| follow(problem, long, sweep, value, decades));
        Drift { method: sweep.method, family: sweep.family, parameter: sweep.parameter, value, cost, points }
    };
    let drifts = sweeps.iter().map(follow).collect();
    bar.finish_and_clear();
    drifts
}

/// The finest value of the method's parameter with no more evaluations in a period than are allowed, and what it
/// costs. It is sought from the fine end: the cost of implicit methods rises again with long steps, which take many
/// iterations.
fn calibrate<Sys, const N: usize>(long: &Long<Sys, N>, sweep: &Sweep<'_, N>) -> Option<(f64, f64)> {
    let cost = |value: f64| {
        let most = (TRIAL * 2.0 * long.evaluations) as u64;
        let (_, statistics) = (sweep.start)(value, most)(TRIAL * long.period).ok()?;
        Some(statistics.evaluations as f64 / TRIAL).filter(|&cost| cost <= 1.01 * long.evaluations)
    };
    let (finest, coarsest, factor) = match sweep.parameter {
        Parameter::Step => (0.5 * long.period / long.evaluations, long.period, 1.5),
        Parameter::Tolerance => (1e-16, 1.0, 10.0),
    };
    let mut values = std::iter::successors(Some(finest), |value| Some(value * factor));
    let mut found = values.find_map(|value| match cost(value) {
        None if value < coarsest => None,
        cost => Some(cost.map(|cost| (value, cost))),
    })??;
    let mut fine = found.0 / factor;
    for _ in 0..12 {
        let middle = (fine * found.0).sqrt();
        match cost(middle) {
            Some(cost) => found = (middle, cost),
            None => fine = middle,
        }
    }
    Some(found)
}

fn follow<Sys, const N: usize>(
    problem: &Problem<Sys, N>,
    long: &Long<Sys, N>,
    sweep: &Sweep<'_, N>,
    value: f64,
    decades: u32,
) -> Vec<(f64, Vec<f64>)> {
    // Looking must not change the steps. Equal ones are looked at after whole numbers of them; adaptive ones, whose
    // energy drifts more than it swings, once in a period.
    let unit = match sweep.parameter {
        Parameter::Step => value * (long.period / f64::from(SAMPLES) / value).round().max(1.0),
        Parameter::Tolerance => long.period,
    };
    let origin: Vec<f64> =
        long.invariants.iter().map(|i| (i.value)(&problem.system, &problem.start)).collect();
    let mut run = (sweep.start)(value, u64::MAX);
    let (mut points, mut done) = (Vec::new(), 0);
    for k in 0..=decades * PER_DECADE {
        let periods = 10_f64.powf(f64::from(k) / f64::from(PER_DECADE));
        let last = (periods * long.period / unit).round();
        let first = (last - (long.period / unit).ceil()).max(0.0) as u64;
        let mut worst = vec![0.0_f64; origin.len()];
        // Early periods overlap, and a run cannot go back.
        for n in first.max(done) + 1..=last as u64 {
            let Ok((state, _)) = run(problem.start.t + n as f64 * unit) else { return points };
            for ((worst, invariant), origin) in worst.iter_mut().zip(&long.invariants).zip(&origin) {
                let error = ((invariant.value)(&problem.system, &state) - origin).abs() / origin.abs();
                *worst = if error.is_nan() { f64::INFINITY } else { worst.max(error) };
            }
        }
        done = last as u64;
        let lost = worst.iter().any(|&error| error > LOST);
        points.push((periods, worst));
        if lost {
            break;
        }
    }
    points
}
