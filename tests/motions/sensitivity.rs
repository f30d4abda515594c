//! Sobol' indices against closed forms.

use lagrange_runtime::ensemble::{
    ClosedForm, ConfidenceInterval, EnsembleError, Index, Indices, Simulation, SobolIndices, normal_quantile,
};
use lagrange_runtime::lanes::{FinalState, Fused};
use lagrange_runtime::prelude::*;
use std::cell::Cell;
use std::f64::consts::PI;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::Duration;

/// Indices against exact ones: within five standard errors, which are to be at most `error`.
fn check<const D: usize>(found: &Indices<D>, first: [f64; D], total: [f64; D], error: f64) {
    for (name, found, exact) in [("first", found.first, first), ("total", found.total, total)] {
        for i in 0..D {
            let (value, by) = (found[i].value(), found[i].standard_error());
            println!("{name} {i}: {value:.5} ± {by:.5}, exactly {:.5}", exact[i]);
            assert!((value - exact[i]).abs() < 5.0 * by + 1e-12 && by < error, "{name} {i}");
        }
    }
}

/// sin x₁ + a sin² x₂ + b x₃⁴ sin x₁ over (−π, π)³ with a = 7 and b = 0.1 (Ishigami and Homma 1990).
fn ishigami(u: [f64; 3]) -> f64 {
    let [x, y, z] = u.map(|u| PI * (2.0 * u - 1.0));
    x.sin() + 7.0 * y.sin().powi(2) + 0.1 * z.powi(4) * x.sin()
}

/// First-order and total-effect indices, and the variance.
fn exact_ishigami() -> ([f64; 3], [f64; 3], f64) {
    let (a, b) = (7.0f64, 0.1f64);
    let (v1, v2) = (0.5 * (1.0 + b * PI.powi(4) / 5.0).powi(2), a * a / 8.0);
    let v13 = 8.0 * b * b * PI.powi(8) / 225.0;
    let all = v1 + v2 + v13;
    ([v1 / all, v2 / all, 0.0], [(v1 + v13) / all, v2 / all, v13 / all], all)
}

#[test]
fn indices_of_ishigami() {
    let found = SobolIndices::new(1, ClosedForm::new(ishigami)).rows(1024).run().expect("a sound study");
    let (first, total, variance) = exact_ishigami();
    check(&found, first, total, 0.005);
    assert!((found.variance / variance - 1.0).abs() < 0.01 && (found.mean - 3.5).abs() < 0.02);
    assert_eq!((found.evaluations, found.lost, found.ranked()), (16 * 1024 * 5, 0, [0, 1, 2]));
}

/// Π (|4 u − 2| + aᵢ)/(1 + aᵢ) (Saltelli and Sobol' 1995).
#[test]
fn indices_of_the_g_function() {
    const A: [f64; 6] = [0.0, 0.5, 3.0, 9.0, 99.0, 99.0];
    let g = |u: [f64; 6]| (0..6).map(|i| ((4.0 * u[i] - 2.0).abs() + A[i]) / (1.0 + A[i])).product::<f64>();
    let v = A.map(|a| 1.0 / (3.0 * (1.0 + a) * (1.0 + a)));
    let product = v.iter().map(|v| 1.0 + v).product::<f64>();
    let all = product - 1.0;
    let found = SobolIndices::new(2, ClosedForm::new(g)).rows(1024).run().expect("a sound study");
    check(&found, v.map(|v| v / all), v.map(|v| v * product / (1.0 + v) / all), 0.01);
    assert!((found.variance / all - 1.0).abs() < 0.02 && (found.mean - 1.0).abs() < 0.01);
}

/// A sum of normal numbers: both indices are the parts of its variance. A large mean does not cancel.
#[test]
fn indices_of_a_linear_output() {
    let c = [1.0, 2.0, 0.0, 4.0];
    let linear = move |u: [f64; 4]| 1e6 + (0..4).map(|i| c[i] * normal_quantile(u[i])).sum::<f64>();
    let found = SobolIndices::new(3, ClosedForm::new(linear)).run().expect("a sound study");
    let exact = c.map(|c| c * c / 21.0);
    check(&found, exact, exact, 0.02);
    assert_eq!(found.total[2].value(), 0.0);
}

/// Intervals of 95 % over 400 seeds cover the indices in 95 % ± 3 % of them.
#[test]
fn intervals_cover_the_indices() {
    let (first, total, _) = exact_ishigami();
    let mut covered = [0; 6];
    for seed in 0..400 {
        let study = SobolIndices::new(seed, ClosedForm::new(ishigami)).rows(64).threads(1);
        let found = study.run().expect("a sound study");
        let all = found.first.iter().zip(first).chain(found.total.iter().zip(total));
        for (covered, (index, exact)) in covered.iter_mut().zip(all) {
            let [low, high] = Index::confidence_interval(index, 0.95);
            *covered += usize::from((low..=high).contains(&exact));
        }
    }
    println!("{covered:?} of 400");
    assert!(covered.iter().all(|covered| (368..=392).contains(covered)), "{covered:?}");
}

lagrangian! {
    pub system Pendulum {
        param m, l, g = 9.81;
        coord theta;
        T = 0.5 * m * (l * dot(theta)).powi(2);
        V = -m * g * l * cos(theta);
    }
}

/// Length, release and mass of a pendulum, of which the mass does not matter. Some starts are not finite.
macro_rules! pendulums {
    ($($lanes:ident)?) => {{
        let draw = |[m, l, theta]: [f64; 3]| {
            let speed = if theta > 0.999 { f64::NAN } else { 0.0 };
            (Pendulum::new(m, 0.8 + 0.05 * l), State::new(0.0, [1.0 + 0.1 * theta], [speed]))
        };
        let angle = FinalState(|_: &Pendulum, end: &State<f64, 1>| end.q[0]);
        let model = Simulation::new(draw, Dop853, PiController::tolerance(1e-9), 2.0, angle);
        $(let model = model.in_lanes($lanes);)?
        SobolIndices::new(5, model).rows(64).replicates(8)
    }};
}

#[test]
fn threads_lanes_and_interruptions_do_not_change_a_bit() {
    let one = pendulums!().threads(1).run().expect("a sound study");
    println!("{one:#?}");
    assert!(one.lost > 0 && one.failures.len() == one.lost as usize);
    assert_eq!(one.total[0].value(), 0.0, "the mass");
    assert_eq!(pendulums!().threads(3).run().expect("a sound study"), one);
    let lanes = pendulums!(Fused).threads(1).run().expect("a sound study");
    assert_eq!(pendulums!(Fused).threads(2).run().expect("a sound study"), lanes);
    assert!((lanes.total[1].value() - one.total[1].value()).abs() < 1e-6 && lanes.lost == one.lost);

    let path = std::env::temp_dir().join(format!("lagrange-indices-{}", std::process::id()));
    let mut stops = 0;
    let done = loop {
        let rounds = Cell::new(0);
        let study = pendulums!().threads(1).checkpoint(&path, Duration::ZERO).progress(|progress| {
            rounds.set(rounds.get() + 1);
            assert!(rounds.get() < 2 || progress.done == progress.samples, "stop");
        });
        match catch_unwind(AssertUnwindSafe(|| study.run())) {
            Ok(indices) => break indices.expect("a sound study"),
            Err(_) => stops += 1,
        }
    };
    assert!(stops > 2, "{stops}");
    assert_eq!(done, one);
    let other = pendulums!().rows(128).checkpoint(&path, Duration::ZERO).run();
    assert!(matches!(other, Err(EnsembleError::OtherStudy { .. })));
    let _ = std::fs::remove_file(path);
}

#[test]
fn bad_input_is_refused_with_the_reason() {
    let refused = |result: Result<Indices<2>, EnsembleError>, words: &str| match result {
        Err(error) => assert!(error.to_string().contains(words), "{words}: {error}"),
        Ok(indices) => panic!("{words}: {indices:?}"),
    };
    refused(SobolIndices::new(1, ClosedForm::new(|_: [f64; 2]| 2.5)).run(), "2.5 at all 8192 points");
    refused(SobolIndices::new(1, ClosedForm::new(|_: [f64; 2]| f64::NAN)).run(), "4096 of 4096 rows");
    refused(SobolIndices::new(1, ClosedForm::new(|[a, _]: [f64; 2]| 1e200 * a)).run(), "larger units");
    refused(
        SobolIndices::new(1, ClosedForm::new(|[a, _]: [f64; 2]| a)).replicates(1).run(),
        "scatter among replicates",
    );
    refused(
        SobolIndices::new(1, ClosedForm::new(|[a, _]: [f64; 2]| a)).rows(1 << 50).run(),
        "more points than",
    );
    refused(
        SobolIndices::new(1, ClosedForm::new(|[a, _]: [f64; 2]| a).cost(f64::NAN)).run(),
        "positive and finite",
    );
}

/// Smooth outputs, of which indices are known in closed form, at the rows that there are by default: intervals cover
/// them, which they would not if all replicates had an error in common.
#[test]
fn intervals_of_smooth_outputs_cover() {
    let known = [0.2, 0.8];
    let mut covered = [[0; 2]; 2];
    for seed in 0..200 {
        let indices =
            SobolIndices::new(seed, ClosedForm::new(|u: [f64; 2]| u[0] + 2.0 * u[1])).run().unwrap();
        for i in 0..2 {
            for (k, index) in [indices.first[i], indices.total[i]].iter().enumerate() {
                let [low, high] = index.confidence_interval(0.95);
                covered[k][i] += u32::from((low..=high).contains(&known[i]));
            }
        }
    }
    println!("{covered:?} of 200");
    assert!(covered.iter().flatten().all(|c| (178..=200).contains(c)), "{covered:?}");
}
