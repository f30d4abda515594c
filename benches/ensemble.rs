//! Cost of an ensemble beside its trajectories: `cargo bench --bench ensemble`.
//!
//! 1. A study on one thread against a bare loop of the same draws, `integrate(…).final_state()` and a sum, for
//!    trajectories from very short to ordinary: ratio of times, and the difference for a sample.
//! 2. The same study on two threads against one.
//! 3. What a draw and each statistic cost.

#![allow(missing_docs)]

mod support;

use lagrange_runtime::ensemble::rand_distr::{Distribution, StandardNormal};
use lagrange_runtime::ensemble::{
    Covariance, Ensemble, Extrema, Histogram, Moments, Quantiles, Random, Sobol, Source, Statistic,
};
use lagrange_runtime::prelude::*;
use std::hint::black_box;
use std::time::Instant;
use support::ratio;
use support::systems::DoublePendulum;

fn sample(mut rng: <Random as Source>::Draw) -> (DoublePendulum, State<f64, 2>) {
    let angle: f64 = StandardNormal.sample(&mut rng);
    (DoublePendulum::new(0.7, 0.4, 0.8, 0.6, 9.81), State::new(0.0, [1.0 + 0.1 * angle, 0.5], [0.0, 0.0]))
}

/// The mean of an angle by a study.
fn study(samples: u64, end: f64, threads: usize) -> f64 {
    let study = Ensemble::new(Random::seed(1), samples, sample)
        .integrate(Dop853, PiController::tolerance(1e-9), end)
        .threads(threads);
    study.reduce(|_, run| Ok(run.final_state()?.q[0]), Moments).expect("a sound study").statistic.mean()
}

/// The same by a loop.
fn bare(samples: u64, end: f64) -> f64 {
    let source = Random::seed(1);
    let mut sum = 0.0;
    for index in 0..samples {
        let (system, start) = sample(source.draw(index));
        let end = integrate(&system, Dop853, PiController::tolerance(1e-9), start).until(end).final_state();
        sum += end.expect("a smooth motion").q[0];
    }
    sum / samples as f64
}

/// Nanoseconds of one call of `f`, which is given numbers from 0 on: the least of ten rounds.
fn nanoseconds(calls: u64, mut f: impl FnMut(u64)) -> f64 {
    let round = |_| {
        let start = Instant::now();
        (0..calls).for_each(&mut f);
        start.elapsed().as_secs_f64()
    };
    (0..10).map(round).fold(f64::INFINITY, f64::min) * 1e9 / calls as f64
}

fn statistic<T: Statistic<f64>>(name: &str, statistic: T, outputs: &[f64]) {
    let mut state = statistic.empty();
    let feed = nanoseconds(outputs.len() as u64, |k| {
        statistic.add(black_box(&mut state), k, &outputs[k as usize]);
    });
    println!("{name}: {feed:.1} ns");
}

fn main() {
    println!("study on one thread / bare loop");
    for (end, samples) in [(0.01, 20_000), (0.1, 4000), (1.0, 1000), (10.0, 100)] {
        let found = ratio(
            samples as usize,
            || _ = black_box(study(samples, end, 1)),
            || _ = black_box(bare(samples, end)),
        );
        let [ours, theirs] = found.nanoseconds;
        let [low, high] = found.quartiles;
        println!(
            "to t = {end}: {:.3} ({low:.3} – {high:.3}), {ours:.0} ns, {theirs:.0} ns a sample",
            found.median
        );
    }

    println!("two threads / one thread");
    for (end, samples) in [(0.1, 40_000), (10.0, 1000)] {
        let found = ratio(
            samples as usize,
            || _ = black_box(study(samples, end, 2)),
            || _ = black_box(study(samples, end, 1)),
        );
        let [low, high] = found.quartiles;
        println!("to t = {end}: {:.3} ({low:.3} – {high:.3})", found.median);
    }

    let (random, sobol) = (Random::seed(1), Sobol::<2>::seed(1));
    let normal = |k| -> f64 { StandardNormal.sample(&mut random.draw(k)) };
    println!(
        "a generator and one normal number: {:.0} ns",
        nanoseconds(100_000, |k| _ = black_box(normal(k)))
    );
    println!(
        "a Sobol point in two dimensions: {:.0} ns",
        nanoseconds(100_000, |k| _ = black_box(sobol.draw(k)))
    );
    let outputs: Vec<f64> = (0..100_000).map(normal).collect();
    statistic("moments", Moments, &outputs);
    statistic("extrema", Extrema, &outputs);
    statistic("histogram", Histogram::new(-3.0, 3.0, 100), &outputs);
    statistic("quantiles to 1 %", Quantiles::to(0.01), &outputs);
    let pair = lagrange_runtime::ensemble::of(|x: &f64| [*x, x * x], Covariance::<2>);
    statistic("covariance of two", pair, &outputs);
}
