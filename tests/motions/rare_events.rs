//! Subset simulation against tails in closed form.

use lagrange_runtime::ensemble::{
    ClosedForm, ConfidenceInterval, EnsembleError, RareEvent, Simulation, SubsetSimulation,
};
use lagrange_runtime::lanes::{FinalState, Fused};
use lagrange_runtime::prelude::*;
use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::Duration;

/// Estimates of 400 seeds: how many intervals of 95 % cover the exact probability, mean of the estimates and their
/// coefficient of variation, both relative, and the one that is claimed.
fn repeated(exact: f64, run: &dyn Fn(u64) -> Result<RareEvent, EnsembleError>) -> (usize, f64, f64, f64) {
    let events: Vec<RareEvent> = (0..400).map(|seed| run(seed).expect("a sound study")).collect();
    let mean = |of: &dyn Fn(&RareEvent) -> f64| events.iter().map(of).sum::<f64>() / 400.0;
    let covered = events.iter().filter(|event| {
        let [low, high] = event.confidence_interval(0.95);
        (low..=high).contains(&exact)
    });
    let average = mean(&|event| event.probability / exact);
    let scatter = mean(&|event| (event.probability / exact - average).powi(2)).sqrt();
    let claimed = mean(&|event| event.coefficient_of_variation);
    let evaluations = mean(&|event| event.evaluations as f64);
    let found = (covered.count(), average, scatter, claimed);
    println!("{exact:.2e}: {found:.3?}, {evaluations:.0} evaluations");
    found
}

fn sum<const D: usize>(seed: u64, beta: f64, n: u64) -> Result<RareEvent, EnsembleError> {
    let sum = ClosedForm::new(|x: [f64; D]| x.iter().sum::<f64>() / (D as f64).sqrt());
    SubsetSimulation::new(seed, n, beta, sum).threads(1).run()
}

/// The mean of the estimates is the exact probability, their scatter what is claimed, and 95 % ± 3 % of the intervals
/// cover it.
fn check(exact: f64, run: &dyn Fn(u64) -> Result<RareEvent, EnsembleError>) {
    let (covered, average, scatter, claimed) = repeated(exact, run);
    assert!((368..=392).contains(&covered), "{exact}: {covered}");
    assert!((average - 1.0).abs() < 4.0 * scatter / 20.0, "{exact}: {average}");
    assert!((0.8..1.2).contains(&(claimed / scatter)), "{exact}: {claimed} {scatter}");
}

/// The table of docs/lab/reliability.md.
#[test]
#[ignore = "a measurement, of a minute"]
fn coverage_of_rare_events() {
    for n in [500, 1000] {
        repeated(1e-6, &|seed| sum::<1>(seed, 4.753424308822899, n));
        repeated(1e-6, &|seed| sum::<2>(seed, 4.753424308822899, n));
        repeated(1e-6, &|seed| sum::<4>(seed, 4.753424308822899, n));
        repeated(1e-6, &|seed| sum::<20>(seed, 4.753424308822899, n));
        repeated(1e-4, &|seed| sum::<10>(seed, 3.7190164854556804, n));
    }
}

/// Half-spaces: a sum of D normal numbers beyond β √D, whose probability is that of one beyond β. Digits by mpmath.
#[test]
fn tails_of_normal_numbers() {
    check(1e-4, &|seed| sum::<10>(seed, 3.7190164854556804, 1000));
    check(1e-6, &|seed| sum::<2>(seed, 4.753424308822899, 1000));
}

/// Beyond a circle, e^(−r²/2), where the event lies on all sides.
#[test]
fn tails_on_all_sides() {
    let run = |seed| {
        let square = ClosedForm::new(|[x, y]: [f64; 2]| x * x + y * y);
        SubsetSimulation::new(seed, 1000, 2.0 * 1e5f64.ln(), square).threads(1).run()
    };
    check(1e-5, &run);
}

/// An event that is not rare is a matter of one level, with the error of independent samples.
#[test]
fn an_event_that_is_not_rare_takes_one_level() {
    let event =
        SubsetSimulation::new(3, 1000, 0.0, ClosedForm::new(|[x]: [f64; 1]| x)).run().expect("a sound study");
    let p = event.probability;
    let levels = &event.runs[3].levels;
    assert_eq!(
        (event.runs.len(), event.evaluations, levels.len(), levels[0].correlation),
        (10, 10_000, 1, 0.0)
    );
    assert!((p - 0.5).abs() < 0.02);
    // Of 10 runs, the relative standard deviation of a standard deviation is 1/√18.
    let claimed = event.coefficient_of_variation / ((1.0 - p) / (10_000.0 * p)).sqrt();
    assert!((0.3..1.9).contains(&claimed), "{claimed}");
}

lagrangian! {
    pub system Pendulum {
        param l;
        coord theta;
        T = 0.5 * (l * dot(theta)).powi(2);
        V = -9.81 * l * cos(theta);
    }
}

/// A pendulum that is released with an uncertain speed: how far is it after a quarter of a second? Some starts are
/// not finite.
macro_rules! pendulums {
    ($($lanes:ident)?) => {{
        let draw = |[a, b]: [f64; 2]| {
            let speed = if b < -2.5 { f64::NAN } else { 0.5 + 0.1 * a };
            (Pendulum::new(1.0 + 0.01 * b), State::new(0.0, [0.0], [speed]))
        };
        let angle = FinalState(|_: &Pendulum, end: &State<f64, 1>| end.q[0]);
        let model = Simulation::new(draw, Dop853, PiController::tolerance(1e-9), 0.25, angle);
        $(let model = model.in_lanes($lanes);)?
        SubsetSimulation::new(2, 300, 0.21, model).runs(4)
    }};
}

#[test]
fn threads_lanes_and_interruptions_do_not_change_a_bit() {
    let one = pendulums!().threads(1).run().expect("a sound study");
    println!("{one:#?}");
    assert!(one.failed > 0 && one.runs.len() == 4 && one.probability < 1e-3);
    assert!(one.runs[0].levels.windows(2).all(|pair| pair[0].beyond < pair[1].beyond));
    assert_eq!(pendulums!().threads(3).run().expect("a sound study"), one);
    let lanes = pendulums!(Fused).threads(1).run().expect("a sound study");
    assert_eq!(pendulums!(Fused).threads(2).run().expect("a sound study"), lanes);

    let path = std::env::temp_dir().join(format!("lagrange-rare-{}", std::process::id()));
    let mut stops = 0;
    let done = loop {
        let levels = Cell::new(0);
        let study = pendulums!().threads(1 + stops % 2).checkpoint(&path, Duration::ZERO).progress(|_| {
            levels.set(levels.get() + 1);
            assert!(levels.get() < 4, "stop");
        });
        match catch_unwind(AssertUnwindSafe(|| study.run())) {
            Ok(event) => break event.expect("a sound study"),
            Err(_) => stops += 1,
        }
    };
    assert!(stops > 1, "{stops}");
    assert_eq!(done, one);
    let _ = std::fs::remove_file(path);
}

#[test]
fn bad_input_is_refused_with_the_reason() {
    let refused = |result: Result<RareEvent, EnsembleError>, words: &str| match result {
        Err(error) => assert!(error.to_string().contains(words), "{words}: {error}"),
        Ok(event) => panic!("{words}: {event:?}"),
    };
    let study = |n, threshold, output: fn([f64; 1]) -> f64| {
        SubsetSimulation::new(1, n, threshold, ClosedForm::new(output))
    };
    refused(study(1000, 0.5, |[x]| f64::from(x > 4.0)).run(), "instead of `true`");
    refused(study(1000, 2.0, |[x]| x.tanh()).run(), "look whether it can come there");
    refused(study(1000, 2.0, |_| 1.0).run(), "the same largest value 1.0");
    refused(study(1000, 2.0, |_| f64::NAN).run(), "1000 of 1000 outputs are not numbers");
    refused(study(10, 2.0, |[x]| x).run(), "100 to 2³² samples");
    refused(study(1000, 2.0, |[x]| x).runs(1).run(), "scatter of 2 to 32768 runs");
    refused(study(1000, f64::INFINITY, |[x]| x).run(), "finite threshold");
    refused(SubsetSimulation::new(1, 1000, 2.0, ClosedForm::new(|[]: [f64; 0]| 1.0)).run(), "has inputs");
}
