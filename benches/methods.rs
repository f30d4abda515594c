//! Choice among methods, for systems larger than those of the atlas: time to an error by Taylor series, Verner 9(8)
//! and DOP853, as ratios to Verner's: `cargo bench --bench methods`.
//!
//! Errors are those of the end, against `SeriesMotion`, to which Gauss 6 comes within 1e-11 beforehand: it shares
//! nothing with series.

#![allow(missing_docs)]

mod support;

use lagrange_runtime::prelude::*;
use lagrange_runtime::testing::distance;
use lagrange_runtime::testing::reference::SeriesMotion;
use lagrange_runtime::testing::work_precision::{MeasuredRun, Reading, ranking};
use lagrange_runtime::{
    DoubleDouble,
    traits::{Analytic, LegendreTransform},
};
use support::{consume, shortest, times_to};

#[macro_use]
#[path = "peers/src/chain.rs"]
mod chain;

chain!(Chain4, 4);
chain!(Chain8, 8);
chain!(Chain20, 20);

lagrangian! {
    /// Rods in space, each turning about the one before, along it and across it in turn.
    pub system Arm {
        const N = 7;
        coord q: [angle; N];
        let link: [N] = |i| frame(
            if i == 0 { world } else { link[i - 1] },
            [0, 0, 0.2],
            if i % 2 == 0 { rotation_z(q[i]) } else { rotation_y(q[i]) }
        );
        let centre: [N] = |i| frame(link[i], [0, if i % 2 == 0 { -0.03 } else { 0.03 }, 0.1]);
        T = (0..N).map(|i| body(4.0 - 0.5 * i, [0.015, 0.015, 0.004], centre[i])).sum();
        V = (0..N).map(|i| 9.81 * (4.0 - 0.5 * i) * centre[i].origin()[2]).sum();
    }
}

/// The first is what the others are compared with.
const METHODS: [&str; 3] = ["Verner9", "Taylor", "Dop853"];

fn measure<Sys, const N: usize>(
    name: &str,
    system: &Sys,
    over_double_double: impl Analytic<N, Scalar = DoubleDouble>,
    q: impl Fn(f64) -> f64,
    end: f64,
) where
    Sys: LegendreTransform<N, Scalar = f64> + Analytic<N>,
{
    let start = State::new(0.0, std::array::from_fn(|i| q(i as f64)), [0.0; N]);
    let exact = SeriesMotion::new(over_double_double, start).state(end).expect("a regular motion");
    let other = integrate(system, Gauss6, FixedStep::new(2e-4), start).until(end).final_state();
    let apart = distance(&other.expect("a regular motion"), &exact);
    assert!(apart < 1e-11, "Gauss 6 is {apart:e} from the reference of the {name}");

    let mut runs = Vec::new();
    for tolerance in (6..=30).map(|k| 10f64.powf(-0.5 * f64::from(k))) {
        for method in METHODS {
            let pi = PiController::tolerance(tolerance);
            let run = || match method {
                "Verner9" => integrate(system, Verner9, pi, start).until(end).final_state(),
                "Taylor" => {
                    let decay = TaylorController::tolerance(tolerance);
                    integrate(system, Taylor::of_order(20), decay, start).until(end).final_state()
                }
                _ => integrate(system, Dop853, pi, start).until(end).final_state(),
            };
            // Tolerances at the limit of rounding are not for every method.
            let Ok(state) = run() else { continue };
            let seconds = shortest(|| consume(run()));
            let error = distance(&state, &exact);
            runs.push(MeasuredRun { method: method.into(), error, seconds, evaluations: 0 });
        }
    }
    let table = ranking(&runs, Reading::Interpolated);
    for method in &METHODS[1..] {
        let times = times_to(&table, &[4, 6, 8, 9, 10, 11, 12, 13], method, METHODS[0]);
        println!("| {name}, {method} | {times} |");
    }
}

fn main() {
    println!("| against {} | 1e-4 | 1e-6 | 1e-8 | 1e-9 | 1e-10 | 1e-11 | 1e-12 | 1e-13 |", METHODS[0]);
    println!("|---|---|---|---|---|---|---|---|---|");
    measure("4 links", &Chain4::new(), Chain4::default(), |i| 0.5 + 0.1 * i, 3.0);
    measure("8 links", &Chain8::new(), Chain8::default(), |i| 0.5 + 0.1 * i, 3.0);
    measure("20 links", &Chain20::new(), Chain20::default(), |i| 0.5 + 0.05 * i, 3.0);
    measure("arm in space", &Arm::new(), Arm::default(), |i| 0.3 + 0.1 * i, 1.0);
}
