//! Certificates of simplified models, and the range of coordinates in which they hold.

use lagrange_runtime::ensemble::rand_distr::{Distribution, Exp1, Uniform};
use lagrange_runtime::ensemble::{
    Certificate, Certification, ClosedForm, EnsembleError, NotCertified, Random, Simulation, Source, Table,
    samples_for,
};
use lagrange_runtime::lanes::{Extremes, FinalState, Fused, InRange, Occurrences};
use lagrange_runtime::prelude::*;
use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::Duration;

type Generator = <Random as Source>::Draw;

/// Errors that are exponential numbers, whose q-quantile is −ln(1 − q), and others of a tenth.
fn exponential(seed: u64, n: u64, allowed: f64) -> Certificate<2> {
    let full = ClosedForm::new(|_: Generator| [1.0, 2.0]);
    let simplified = ClosedForm::new(|mut rng: Generator| {
        let x: f64 = Exp1.sample(&mut rng);
        [1.0 - x, 2.0 + 0.1 * x]
    });
    let scene =
        Certification::new(Random::seed(seed), n, [allowed, 0.1 * allowed], full, simplified.cost(0.5));
    scene.threads(1).run().expect("a sound scene")
}

#[test]
fn ranks_are_those_of_the_errors() {
    let errors = [0.3, 0.1, 0.5, 0.2, 0.4, 0.5, 0.0, 0.25, 0.35, 0.45];
    let scene = Certification::new(
        Table::new(errors),
        10,
        [1.0],
        ClosedForm::new(|_: f64| [7.0]),
        ClosedForm::new(|x: f64| [7.0 - x]),
    );
    let certificate = scene.run().expect("a sound scene");
    assert_eq!((certificate.samples(), certificate.failed, certificate.cost), (10, 0, [10.0, 10.0]));
    assert_eq!((certificate.worst[0].index, certificate.worst[0].simplified), (2, 6.5));
    assert_eq!(scene.draw(certificate.worst[0].index).expect("a draw"), 0.5);
    assert!(
        (certificate.quantile(0, 0.5) - 0.3).abs() < 1e-12 && (certificate.maximum(0) - 0.5).abs() < 1e-12
    );
    assert!((certificate.quantile(0, 0.7) - 0.4).abs() < 1e-12);
    assert!(certificate.maximum(1).is_nan() && certificate.quantile(1, 0.5).is_nan());
    assert_eq!(certificate.confidence_of_maximum(0.5), 1.0 - 0.5f64.powi(10));
    assert!(certificate.to_string().contains("10 samples, of which 0 failed"), "{certificate}");
}

/// Tables of Wilks: 59 samples for 95 %/95 %, 299 for 99 %/95 %, 2995 for 99.9 %/95 %; and 93 where the second
/// largest is taken, at 95 %/95 %.
#[test]
fn numbers_of_samples_are_those_of_wilks() {
    for (quantile, confidence, n) in [
        (0.95, 0.95, 59),
        (0.99, 0.95, 299),
        (0.999, 0.95, 2995),
        (0.9, 0.9, 22),
        (0.5, 0.5, 1),
        (0.75, 0.9375, 10),
    ] {
        assert_eq!(samples_for(quantile, confidence), Some(n), "{quantile} {confidence}");
    }
    assert_eq!([samples_for(1.0, 0.5), samples_for(0.5, 0.0), samples_for(f64::NAN, 0.5)], [None; 3]);
    for (n, rank) in [(59, 59), (92, 92), (93, 92), (123, 122), (124, 122)] {
        let errors = Table::new((0..n).map(|k| k as f64));
        let identity = ClosedForm::new(|x: f64| [x + 1.0]);
        let scene = Certification::new(errors, n, [0.0], ClosedForm::new(|_: f64| [0.0]), identity);
        let bound = scene.run().expect("a sound scene").bound(0, 0.95, 0.95);
        assert_eq!(bound, Ok(f64::from(rank)), "{n}");
    }
}

/// 400 scenes: the bound of the 0.9-quantile with confidence 0.9 is above it in no fewer than what is promised,
/// 0.9424 of them by the binomial distribution.
#[test]
fn bounds_hold_as_often_as_they_promise() {
    let exact = 10.0f64.ln();
    let held = (0..400).filter(|&seed| {
        let certificate = exponential(seed, 100, f64::INFINITY);
        let bound = certificate.bound(0, 0.9, 0.9).expect("enough samples");
        assert!((certificate.bound(1, 0.9, 0.9).expect("enough samples") - 0.1 * bound).abs() < 1e-12);
        bound >= exact
    });
    let held = held.count();
    println!("{held} of 400");
    // Three standard deviations: 14.
    assert!((363..=391).contains(&held), "{held}");
}

/// 10⁴ fresh draws of a certificate that holds have as many errors beyond what is allowed as it says.
#[test]
fn a_certificate_holds_on_fresh_draws() {
    let allowed = 10.0;
    let certificate = exponential(1, 5000, allowed);
    println!("{certificate}");
    certificate.holds(0.999, 0.95).expect("P(x > 10) = 4.5e-5");
    let beyond = (0..10_000).filter(|&index| {
        let x: f64 = Exp1.sample(&mut Random::seed(99).draw(index));
        x > allowed
    });
    assert!(beyond.count() <= 10);
    // P(x > 6) = 2.5e-3.
    match exponential(1, 5000, 6.0).holds(0.999, 0.95) {
        Err(error @ NotCertified::TooLarge { output: 0, allowed: 6.0, worst, .. }) => {
            assert!(
                worst.error > 6.0 && error.to_string().contains("more than the 6.000e0 allowed"),
                "{error}"
            );
        }
        other => panic!("{other:?}"),
    }
    let few = exponential(1, 2994, allowed).holds(0.999, 0.95);
    assert_eq!(few, Err(NotCertified::TooFewSamples { samples: 2994, needed: 2995 }));
    assert!(few.unwrap_err().to_string().contains("take 2995 samples"));
    assert_eq!(certificate.holds(99.9, 0.95), Err(NotCertified::NoProbability { given: 99.9 }));
}

lagrangian! {
    system Pendulum {
        coord theta;
        T = 0.5 * dot(theta).powi(2);
        V = -cos(theta);
    }
}

lagrangian! {
    /// The same for small angles.
    system Small {
        coord theta;
        T = 0.5 * dot(theta).powi(2);
        V = 0.5 * theta.powi(2);
    }
}

lagrangian! {
    /// A pendulum on a stiff spring.
    system Elastic {
        param k, g = 9.81;
        coord theta: angle, r: length;
        T = 0.5 * (dot(r).powi(2) + (r * dot(theta)).powi(2));
        V = 0.5 * k * (r - 1 - g / k).powi(2) - g * r * cos(theta);
        simplified Rigid: lock r = 1;
        simplified Linear: lock r = 1, expand theta to 2 about 0;
    }
}

lagrangian! {
    /// Two springs across each other.
    system Plane {
        coord x, y;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = 0.5 * (x * x + 4 * y * y);
    }
}

const END: f64 = 6.0;

/// Pendulums with speeds up to 0.5, by both models; the small one holds up to 0.45.
macro_rules! pendulums {
    ($n:expr $(, $lanes:ident)?) => {{
        let speed = Uniform::new(-0.5, 0.5).expect("finite ends");
        let start = move |mut rng: Generator| State::new(0.0, [0.0], [speed.sample(&mut rng)]);
        let angle = FinalState(|_: &Pendulum, end: &State<f64, 1>| [end.q[0], end.qd[0]]);
        let linear = FinalState(|_: &Small, end: &State<f64, 1>| [end.q[0], end.qd[0]]);
        let full =
            Simulation::new(move |rng| (Pendulum::new(), start(rng)), Dop853, PiController::tolerance(1e-9), END, angle);
        let small = Simulation::new(
            move |rng| (Small::new(), start(rng)),
            Dop853,
            PiController::tolerance(1e-9),
            END,
            InRange::new([-0.45..=0.45], linear),
        );
        $(let (full, small) = (full.in_lanes($lanes), small.in_lanes($lanes));)?
        Certification::new(Random::seed(4), $n, [0.1, 0.1], full, small)
    }};
}

/// Certificates of models that the compiler simplified: of 10⁴ fresh draws no more err by more than is certified than
/// the quantile says, and none leaves the range that is watched, which is that of the angles of the scene.
#[test]
#[cfg_attr(not(feature = "long"), ignore = "long")]
fn certified_errors_and_ranges_hold_on_fresh_draws() {
    const RELEASE: f64 = 0.4;
    let release = Uniform::new(-RELEASE, RELEASE).expect("finite ends");
    let stiffness = Uniform::new(8e3, 1.2e4).expect("finite ends");
    let draw = move |mut rng: Generator| {
        let k = stiffness.sample(&mut rng);
        (Elastic::new(k), release.sample(&mut rng))
    };
    macro_rules! certified {
        ($model:ident, $allowed:expr) => {{
            let certificate = |seed: u64, n: u64| {
                let control = PiController::tolerance(1e-9);
                let full = move |rng| {
                    let (system, theta) = draw(rng);
                    (system, State::new(0.0, [theta, 1.0], [0.0, 0.0]))
                };
                let small = move |rng| {
                    let (system, theta) = draw(rng);
                    ($model::new(system.k), State::new(0.0, [theta], [0.0]))
                };
                let angle = FinalState(|_: &Elastic, end: &State<f64, 2>| [end.q[0], end.qd[0]]);
                let one = FinalState(|_: &$model, end: &State<f64, 1>| [end.q[0], end.qd[0]]);
                let full = Simulation::new(full, Dop853, control, 2.0, angle).in_lanes(Fused);
                let range = InRange::new([-RELEASE * (1.0 + 1e-8)..=RELEASE * (1.0 + 1e-8)], one);
                let small = Simulation::new(small, Dop853, control, 2.0, range).in_lanes(Fused);
                let scene = Certification::new(Random::seed(seed), n, $allowed, full, small);
                scene.run().expect("a sound scene")
            };
            let (found, fresh) = (certificate(5, 2995), certificate(6, 10_000));
            found.holds(0.999, 0.95).expect("a certificate");
            assert_eq!((found.failed, fresh.failed), (0, 0), "the range was left");
            for output in 0..2 {
                let bound = found.bound(output, 0.999, 0.95).expect("enough samples");
                println!("{}: {bound:e}, fresh {:e}", stringify!($model), fresh.quantile(output, 0.999));
                assert!(fresh.quantile(output, 0.999) <= bound && bound < $allowed[output]);
            }
        }};
    }
    certified!(Rigid, [0.02, 0.06]);
    certified!(Linear, [0.1, 0.3]);
}

#[test]
fn threads_lanes_and_interruptions_do_not_change_a_bit() {
    let one = pendulums!(2000).threads(1).run().expect("a sound scene");
    println!("{one}");
    // A tenth of the speeds leads beyond the range, within the quarter of a period.
    assert!((150..250).contains(&one.failed) && one.maximum(0) == f64::INFINITY);
    assert!(one.failures.iter().all(|failed| {
        let beyond = matches!(failed.failure, Failure::OutsideModel { t, coordinate, bound }
            if coordinate.name == "theta" && bound.abs() == 0.45 && t < 1.6);
        beyond && failed.model == 1
    }));
    // (Outputs of failed samples are not numbers, which differ from themselves.)
    let told = |certificate: &Certificate<2>| format!("{certificate:?}");
    assert!(told(&pendulums!(2000).threads(3).run().expect("a sound scene")) == told(&one));
    let lanes = pendulums!(2000, Fused).threads(1).run().expect("a sound scene");
    assert!(told(&pendulums!(2000, Fused).threads(2).run().expect("a sound scene")) == told(&lanes));
    assert_eq!((lanes.failed, lanes.worst[0].index), (one.failed, one.worst[0].index));
    assert!((lanes.quantile(0, 0.5) - one.quantile(0, 0.5)).abs() < 1e-9);
    assert!(one.holds(0.95, 0.9).is_err() && one.holds(0.8, 0.9).is_ok());

    let path = std::env::temp_dir().join(format!("lagrange-certificate-{}", std::process::id()));
    let mut stops = 0;
    let done = loop {
        let rounds = Cell::new(0);
        let scene = pendulums!(2000).threads(1).checkpoint(&path, Duration::ZERO).progress(|progress| {
            rounds.set(rounds.get() + 1);
            assert!(rounds.get() < 2 || progress.done == progress.samples, "stop");
        });
        match catch_unwind(AssertUnwindSafe(|| scene.run())) {
            Ok(certificate) => break certificate.expect("a sound scene"),
            Err(_) => stops += 1,
        }
    };
    assert!(stops > 2, "{stops}");
    assert!(told(&done) == told(&one));
    let _ = std::fs::remove_file(path);
}

/// A watched range: where and when the closed forms say, with each kind of observer inside, by each end, within steps
/// and at the start.
#[test]
fn leaving_the_range_names_the_coordinate_and_the_time() {
    let start = |x: f64, y: f64, v: f64, w: f64| State::new(0.0, [x, y], [v, w]);
    let end = || FinalState(|_: &Plane, end: &State<f64, 2>| end.q[0]);
    let run = |start, range: &InRange<_, 2>| {
        integrate(&Plane::new(), Dop853, PiController::tolerance(1e-10), start).until(10.0).observe(range)
    };
    let any = InRange::<(), 2>::ANY;
    let left =
        |start, range: [std::ops::RangeInclusive<f64>; 2]| match run(start, &InRange::new(range, end())) {
            Ok(_) => None,
            Err(failed) => match failed.failure {
                Failure::OutsideModel { t, coordinate, bound } => Some((coordinate.name, bound, t)),
                other => panic!("{other}"),
            },
        };
    let near = |found: Option<(&'static str, f64, f64)>, name: &str, bound: f64, t: f64| {
        assert!(
            found.is_some_and(|(n, b, at)| n == name && b == bound && (at - t).abs() < 1e-7),
            "{found:?} {name} {t}"
        );
    };
    // x = sin t, y = 0.5 sin 2t.
    let both = start(0.0, 0.0, 1.0, 1.0);
    assert_eq!(left(both, [-1.01..=1.01, -0.51..=0.51]), None);
    assert_eq!(left(both, [any.clone(), any.clone()]), None);
    near(left(both, [-1.0..=0.6, any.clone()]), "x", 0.6, 0.6f64.asin());
    near(left(both, [-1.01..=1.01, -0.3..=1.0]), "y", -0.3, 0.5 * (std::f64::consts::PI + 0.6f64.asin()));
    near(left(both, [f64::NEG_INFINITY..=0.6, -0.6..=f64::INFINITY]), "x", 0.6, 0.6f64.asin());
    // Just over a maximum and back within a step: the event search finds it.
    near(left(both, [any.clone(), -0.51..=0.4999]), "y", 0.4999, 0.5 * 0.9998f64.asin());
    // From outside, from a range that has none, and from its end.
    near(left(start(2.0, 0.0, 0.0, 0.0), [-1.0..=1.0, any.clone()]), "x", 1.0, 0.0);
    #[allow(clippy::reversed_empty_ranges)]
    let empty = 1.0..=-1.0;
    near(left(start(0.0, 0.0, 0.1, 0.0), [empty, any.clone()]), "x", 1.0, 0.0);
    assert!(left(start(1.0, 0.0, 1.0, 0.0), [-1.0..=1.0, any.clone()]).is_some_and(|(_, _, t)| t < 1.0));

    // A terminal event inside that comes first ends the run well, and one that comes later does not.
    let met = |level: f64| {
        let event = Event::rising(move |at: &State<f64, 2>| at.q[0] - level).terminal();
        let inner = Occurrences::new(
            event,
            |_: &Plane, met: &[lagrange_runtime::Occurrence<f64, 2>], _: &State<f64, 2>| met.len(),
        );
        let range = InRange::new([-1.0..=0.6, any.clone()], inner);
        integrate(&Plane::new(), Dop853, PiController::tolerance(1e-10), both).until(10.0).observe(&range)
    };
    assert_eq!(met(0.59).ok(), Some(1));
    assert!(met(0.61).is_err());
    // Extremes inside.
    let extremes = Extremes::new(|_: &Plane, at: &State<f64, 2>| [at.q[1]], end());
    let range = InRange::new([-1.01..=1.01, any.clone()], extremes);
    let run =
        integrate(&Plane::new(), Dop853, PiController::tolerance(1e-10), both).until(10.0).observe(&range);
    assert!((run.expect("inside").1[0].greatest - 0.5).abs() < 1e-9);
}

/// In lanes each run leaves the range where it does alone.
#[test]
fn lanes_leave_the_range_as_alone() {
    use lagrange_runtime::ensemble::Model;
    let draw = |k: u64| (Small::new(), State::new(0.0, [0.0], [0.02 * k as f64]));
    let angle = FinalState(|_: &Small, end: &State<f64, 1>| end.q[0]);
    let model =
        Simulation::new(draw, Dop853, PiController::tolerance(1e-8), END, InRange::new([-0.5..=0.4], angle))
            .in_lanes(Fused);
    let together = model.evaluate((0..50).collect());
    for (k, beside) in together.iter().enumerate() {
        assert_eq!(&model.evaluate(vec![k as u64])[0], beside, "{k}");
        let speed = 0.02 * k as f64;
        match beside.output {
            // It touches the bound.
            _ if k == 20 => {}
            Ok(_) => assert!(speed <= 0.4 + 1e-12),
            Err(Failure::OutsideModel { t, bound, .. }) => {
                assert!(speed > 0.4 - 1e-12 && (t - (bound / speed).asin()).abs() < 1e-5, "{k}: {t}");
            }
            Err(other) => panic!("{other}"),
        }
    }
}

#[test]
fn bad_input_is_refused_with_the_reason() {
    let form = || ClosedForm::new(|x: f64| [x]);
    let refused = |result: Result<Certificate<1>, EnsembleError>, words: &str| match result {
        Err(error) => assert!(error.to_string().contains(words), "{words}: {error}"),
        Ok(certificate) => panic!("{words}: {certificate:?}"),
    };
    refused(Certification::new(Table::new([1.0]), 0, [1.0], form(), form()).run(), "at least one sample");
    refused(Certification::new(Table::new([1.0]), 2, [1.0], form(), form()).run(), "the source has 1");
    refused(Certification::new(Table::new([1.0]), 1, [-1.0], form(), form()).run(), "positive or zero");
    refused(Certification::new(Table::new([1.0]), 1, [f64::NAN], form(), form()).run(), "positive or zero");
    refused(
        Certification::new(Table::new([1.0]), 1, [1.0], form(), form().cost(-1.0)).run(),
        "positive and finite",
    );
    let none = Certification::new(
        Table::new([1.0]),
        1,
        [],
        ClosedForm::new(|_: f64| []),
        ClosedForm::new(|_: f64| []),
    );
    assert!(none.run().is_err_and(|error| error.to_string().contains("an output at least")));
    // A model that is not a number anywhere is certified nowhere.
    let bad = ClosedForm::new(|_: f64| [f64::NAN]);
    let certificate =
        Certification::new(Table::new([1.0; 100]), 100, [1e300], form(), bad).run().expect("a scene");
    assert!(certificate.holds(0.5, 0.9).is_err() && certificate.maximum(0) == f64::INFINITY);
}

/// A model written by hand that returns fewer evaluations than it was given draws: those that are missing count as
/// failed, and none moves to another draw.
#[test]
fn evaluations_that_are_missing_have_failed() {
    struct Short;
    impl lagrange_runtime::ensemble::Model<f64> for Short {
        type Output = [f64; 1];
        fn evaluate(&self, draws: Vec<f64>) -> Vec<lagrange_runtime::ensemble::Evaluated<[f64; 1]>> {
            let one = |x| lagrange_runtime::ensemble::Evaluated { output: Ok([x]), work: 1 };
            draws.into_iter().skip(1).map(one).collect()
        }
        fn unit_cost(&self) -> f64 {
            1.0
        }
        fn describe(&self, _: f64) -> String {
            "short".into()
        }
    }
    let rows = Table::new((0..64).map(f64::from));
    let scene = Certification::new(rows, 64, [1.0], ClosedForm::new(|x: f64| [x]), Short);
    let certificate = scene.threads(1).run().expect("a scene");
    // One of each leaf; the others are of the next draw.
    assert_eq!((certificate.samples(), certificate.failed, certificate.maximum(0)), (64, 2, f64::INFINITY));
}
