//! Trajectories in lanes against the same one by one, on one thread: `cargo bench --bench lanes`.
//!
//! A double pendulum whose parameters and start are drawn at random. Ratios are times of the scalar code over times in lanes: the
//! median of alternating rounds, with its quartiles.
//!
//! `cargo bench --bench lanes -- rk4 avx512 1000` makes 1000 trajectories by one method on one kind of processor and nothing else,
//! to be counted or profiled; `scalar` stands for the scalar code.

#![allow(missing_docs)]

#[allow(dead_code, reason = "what other benchmarks need")]
mod support;

use core::fmt::Debug;
use lagrange_runtime::Controller;
use lagrange_runtime::ensemble::{Ensemble, Moments, Random, rand_distr::Distribution, rand_distr::Uniform};
use lagrange_runtime::lanes::{Fused, InLanes, Last, Level, Plain, Policy};
use lagrange_runtime::method::Method;
use lagrange_runtime::prelude::*;
use std::hint::black_box;
use support::ratio;
use support::systems::DoublePendulum;

const END: f64 = 10.0;

fn ensemble(
    samples: u64,
) -> Ensemble<
    Random,
    impl Fn(<Random as lagrange_runtime::ensemble::Source>::Draw) -> (DoublePendulum, State<f64, 2>),
> {
    let unit = Uniform::new(0.0, 1.0).expect("finite ends");
    Ensemble::new(Random::seed(1), samples, move |mut rng| {
        let [a, b, m, n, k, l]: [f64; 6] = core::array::from_fn(|_| unit.sample(&mut rng));
        let system = DoublePendulum::new(0.5 + m, 0.5 + n, 0.5 + k, 0.5 + l, 9.81);
        (system, State::new(0.0, [0.5 + 2.0 * a, 2.0 * b - 1.0], [0.0, 0.0]))
    })
}

fn lanes<M, C, P>(samples: u64, method: M, controller: C, policy: P, level: Level) -> f64
where
    M: Method<DoublePendulum, 2> + InLanes<DoublePendulum, C, P, 2> + Clone + Debug,
    C: Controller<f64, 2, M::Error> + Sync + Debug,
    P: Policy,
{
    let study = ensemble(samples).integrate(method, controller, END).threads(1).in_lanes(policy).level(level);
    let last = Last(|_: &DoublePendulum, end: &State<f64, 2>| end.q[0]);
    study.reduce(&last, Moments).expect("a sound study").statistic.mean()
}

fn scalar<M, C>(samples: u64, method: M, controller: C) -> f64
where
    M: Method<DoublePendulum, 2> + Clone + Sync + Debug,
    C: Controller<f64, 2, M::Error> + Sync + Debug,
{
    let study = ensemble(samples).integrate(method, controller, END).threads(1);
    study.reduce(|_, run| Ok(run.finish()?.q[0]), Moments).expect("a sound study").statistic.mean()
}

/// Every kind of processor and policy that is worth while.
fn cases() -> Vec<(Level, bool)> {
    let fused = Level::available().filter(|&level| level > Level::Baseline).map(|level| (level, true));
    fused.chain(Level::available().map(|level| (level, false))).collect()
}

fn compare<M, C>(name: &str, samples: u64, method: M, controller: C)
where
    M: Method<DoublePendulum, 2> + Clone + Copy + Debug,
    M: InLanes<DoublePendulum, C, Fused, 2> + InLanes<DoublePendulum, C, Plain, 2>,
    C: Controller<f64, 2, M::Error> + Copy + Sync + Debug,
{
    for (level, fused) in cases() {
        let found = ratio(
            samples as usize,
            || _ = black_box(scalar(samples, method, controller)),
            || {
                _ = black_box(if fused {
                    lanes(samples, method, controller, Fused, level)
                } else {
                    lanes(samples, method, controller, Plain, level)
                })
            },
        );
        let [alone, beside] = found.nanoseconds;
        let [low, high] = found.quartiles;
        let policy = if fused { "fused" } else { "rounded" };
        println!(
            "{name}, {level:?}, {policy}: {:.2} ({low:.2} – {high:.2}), best {:.2}; {alone:.0} ns, {beside:.0} ns",
            found.median,
            alone / beside
        );
    }
}

fn main() {
    let arguments: Vec<String> =
        std::env::args().skip(1).filter(|argument| !argument.starts_with('-')).collect();
    let (rk4, dop853) = (Fixed::new(1e-3), Pi::tolerance(1e-9));
    if let [method, level, samples] = &arguments[..] {
        let samples = samples.parse().expect("a number of samples");
        let level = match level.as_str() {
            "scalar" => None,
            "baseline" => Some(Level::Baseline),
            "avx2" => Some(Level::Avx2),
            "avx512" => Some(Level::Avx512),
            other => panic!("{other}: scalar, baseline, avx2 or avx512"),
        };
        let mean = match (method.as_str(), level) {
            ("rk4", None) => scalar(samples, Rk4, rk4),
            ("dop853", None) => scalar(samples, Dop853, dop853),
            ("rk4", Some(Level::Baseline)) => lanes(samples, Rk4, rk4, Plain, Level::Baseline),
            ("dop853", Some(Level::Baseline)) => lanes(samples, Dop853, dop853, Plain, Level::Baseline),
            ("rk4", Some(level)) => lanes(samples, Rk4, rk4, Fused, level),
            ("dop853", Some(level)) => lanes(samples, Dop853, dop853, Fused, level),
            (other, _) => panic!("{other}: rk4 or dop853"),
        };
        println!("{mean}");
        return;
    }
    compare("RK4, h = 1e-3", 32, Rk4, rk4);
    compare("DOP853 at 1e-9", 256, Dop853, dop853);
}
