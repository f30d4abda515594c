//! That the table chooses well, that what it says is what it does, and that an enum over methods is as good as they are.

use super::*;
use crate::constraint::{Constraint, ConstraintKind};
use crate::failure::Requirement;
use crate::prelude::*;
use crate::testing::bank::{DOUBLE, DoublePendulum, ELLIPSE, Pendulum, Plane, ellipse};
use crate::testing::emitted::{Bob, Relativistic, Repelled, Swing, TwoPendulums, Wedge};
use crate::{BlanesMoan4, Nystrom12};

lagrangian! {
    system Overdamped {
        param c;
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = 0.5 * c * x.powi(2);
        D = 0.5 * c * dot(x).powi(2);
    }
}

use crate::testing::{distance, energy_drift};

const KINDS: [Facts; 5] = [
    Facts {
        linear: true,
        conservative: true,
        separable: true,
        quadratic: true,
        analytic: true,
        ..Facts::UNKNOWN
    },
    Facts { separable: true, quadratic: true, ..Facts::UNKNOWN },
    Facts { quadratic: true, ..Facts::UNKNOWN },
    Facts {
        analytic: true,
        quadratic: true,
        constraints: &[Constraint { name: "rod", kind: ConstraintKind::Holonomic }],
        ..Facts::UNKNOWN
    },
    Facts::UNKNOWN,
];

#[test]
fn the_front_page_shows_the_table() {
    let page = include_str!("../lib.rs");
    let shown: Vec<_> = page.lines().filter(|line| line.starts_with("//! | `")).collect();
    let rows: Vec<_> = ROWS.iter().map(|row| format!("//! {row}")).collect();
    assert_eq!(shown, rows, "the table of lib.rs has to read:\n{}\n", rows.join("\n"));
}

#[test]
fn the_table_chooses_what_fits() {
    let methods = |aim: Aim| KINDS.map(|facts| choose(&facts, aim).method);
    use AnyMethod::*;
    assert_eq!(methods(Aim::Accuracy(1e-9)), [Nystrom12, Nystrom12, Verner9, Verner9, Verner9]);
    assert_eq!(methods(Aim::Accuracy(1e-10)), [Taylor, Nystrom12, Verner9, Verner9, Verner9]);
    assert_eq!(methods(Aim::Accuracy(1e-13)), [Taylor, Nystrom12, Verner9, Taylor, Verner9]);
    assert_eq!(methods(Aim::Accuracy(1e-4)), [DormandPrince5; 5]);
    assert_eq!(methods(Aim::LongTime(0.1)), [Modal, BlanesMoan4, Gauss4, Dop853, Dop853]);
    assert_eq!(methods(Aim::Stiff(1e-4)), [Rodas5P; 5]);
    assert_eq!(methods(Aim::Stiff(1e-9)), [Radau5; 5]);
    // What the compiler found: with a choice in them, equations have series on either side of it only.
    let fine = Aim::Accuracy(1e-13);
    assert_eq!(method_for(&TwoPendulums::new(1.0), fine).method, Taylor);
    assert_eq!(method_for(&Wedge::new(1.0), fine).method, Nystrom12);
    assert_eq!(method_for(&DoublePendulum::default(), fine).method, Verner9);
    // Nonsense is chosen for, too, and told by the run.
    let system = Pendulum::default();
    for aim in [Aim::Accuracy(f64::NAN), Aim::LongTime(0.0), Aim::Stiff(-1.0)] {
        let run = method_for(&system, aim).integrate(&system, State::new(0.0, [1.0], [0.0]));
        assert!(run.until(1.0).finish().is_err());
    }
}

/// Every aim ends in a row for any system, every row can be reached, and a method without an estimate of its error is
/// never paired with adaptive steps.
#[test]
fn the_table_is_complete() {
    let tolerances = [1e-3, 1e-9, 1e-13].map(Aim::Accuracy);
    let aims = [&tolerances[..], &[Aim::LongTime(0.1), Aim::Stiff(1e-6), Aim::Stiff(1e-9)]].concat();
    for aim in &aims {
        assert!(ROWS.iter().any(|row| (row.aim)(aim) && (row.fits)(&Facts::UNKNOWN)), "{aim:?}");
    }
    let first = |aim: &Aim, facts: &Facts| ROWS.iter().position(|row| (row.aim)(aim) && (row.fits)(facts));
    for n in 0..ROWS.len() {
        assert!(aims.iter().any(|aim| KINDS.iter().any(|facts| first(aim, facts) == Some(n))), "row {n}");
    }
    // Everything is true of an oscillator.
    let (system, start) = (Repelled::new(-1.0), State::new(0.0, [1.0], [0.0]));
    for aim in aims {
        for facts in KINDS {
            let end = choose(&facts, aim).integrate(&system, start).until(1.0).finish();
            let error = (end.unwrap().q[0] - 1f64.cos()).abs();
            let tolerated = if let Aim::Accuracy(tolerance) = aim { 10.0 * tolerance } else { 1e-2 };
            assert!(error < tolerated, "{aim:?} {facts:?} {error}");
        }
    }
}

/// Steps and interpolants of the chosen method are those of the method itself; of Gauss methods but for rounding, since
/// velocities are found in another way.
#[test]
fn a_chosen_method_is_the_method() {
    fn compare<M: Method<TwoPendulums, 2> + Copy>(any: AnyMethod, method: M, tolerance: f64) {
        let system = TwoPendulums::new(1.0);
        let [a, b] = [0.02, 0.05];
        let memory = method.start(&system, &DOUBLE).unwrap();
        let step = method.step(&system, &memory, &DOUBLE, b, &mut memory.clone()).unwrap();
        let any_memory = any.start(&system, &DOUBLE).unwrap();
        let any_step = any.step(&system, &any_memory, &DOUBLE, b, &mut any_memory.clone()).unwrap();
        assert!(distance(&step.to, &any_step.to) <= tolerance);
        // Where velocities differ by rounding, an iteration may end one sweep earlier.
        assert!(tolerance > 0.0 || step.evaluations == any_step.evaluations);
        let [dense, any_dense] = [method.dense(&system, &step).at(a), any.dense(&system, &any_step).at(a)];
        assert!(distance(&dense, &any_dense) <= tolerance);
        assert_eq!(
            (Method::<TwoPendulums, 2>::order(&any), Method::<TwoPendulums, 2>::dense_evaluations(&any)),
            (method.order(), method.dense_evaluations())
        );
    }
    compare(AnyMethod::Dop853, Dop853, 0.0);
    compare(AnyMethod::DormandPrince5, DormandPrince5, 0.0);
    compare(AnyMethod::Verner9, Verner9, 0.0);
    compare(AnyMethod::Gauss4, Gauss4, 1e-15);
    compare(AnyMethod::Rodas5P, Rodas5P, 0.0);
    compare(AnyMethod::Radau5, Radau5, 0.0);
    let (system, start) = (Repelled::new(-1.0), State::new(0.0, [1.0], [0.0]));
    let fixed = Fixed::new(0.01);
    let choice = |method, controller| Choice { method, controller, aim: Aim::LongTime(0.01), why: "" };
    let by_name = integrate(&system, BlanesMoan4, fixed, start).until(10.0).finish();
    let chosen = choice(AnyMethod::BlanesMoan4, AnyController::Fixed(fixed));
    assert_eq!(chosen.integrate(&system, start).until(10.0).finish(), by_name);
    let samples = chosen.integrate(&system, start).until(10.0).sample_evenly(33);
    assert!(samples.map(Result::unwrap).all(|state| state.is_finite()));
    let by_name = integrate(&system, Modal, fixed, start).until(10.0).finish();
    let chosen = choice(AnyMethod::Modal, AnyController::Fixed(fixed));
    assert_eq!(chosen.integrate(&system, start).until(10.0).finish(), by_name);
    let decay = Decay::tolerance(1e-15);
    let by_name = integrate(&system, Taylor::for_tolerance(1e-15), decay, start).until(10.0).finish();
    let chosen = choice(AnyMethod::Taylor, AnyController::Decay(decay));
    assert_eq!(chosen.integrate(&system, start).until(10.0).finish(), by_name);
    assert!((by_name.unwrap().q[0] - 10f64.cos()).abs() < 1e-14);
    // One that is written by hand has none; and no other method passes under that control.
    let hand = Pendulum::default();
    let failure = |choice: Choice| {
        let come = choice.integrate(&hand, State::new(0.0, [1.0], [0.0])).until(1.0).finish();
        come.unwrap_err().failure
    };
    let none = failure(chosen);
    assert!(matches!(none, Failure::NoSeries { t: 0.0 }) && none.to_string().contains("extern fn"), "{none}");
    let unsuitable = failure(choice(AnyMethod::Dop853, AnyController::Decay(decay)));
    assert_eq!(unsuitable, Failure::Unsuitable { chosen: "Decay", requirement: Requirement::Series });
    let pi = Pi::tolerance(1e-9);
    let by_name = integrate(&system, Nystrom12, pi, start).until(10.0).finish();
    let chosen = choice(AnyMethod::Nystrom12, AnyController::Pi(pi));
    assert_eq!(chosen.integrate(&system, start).until(10.0).finish(), by_name);
}

/// A spring beside a damper that is 1e8 times faster: as it says, the one aim does it, the other says what to do.
#[test]
fn stiffness_has_to_be_told() {
    let (system, start) = (Overdamped::new(1e8), State::new(0.0, [1.0], [0.0]));
    let run = |aim| {
        let run = method_for(&system, aim).integrate(&system, start).until(1.0).max_steps(1000);
        run.finish().map_err(|failed| failed.failure)
    };
    for tolerance in [1e-6, 1e-9] {
        let error = (run(Aim::Stiff(tolerance)).unwrap().q[0] - (-1f64).exp()).abs();
        assert!(error < 10.0 * tolerance + 2e-8, "{error}");
        let failure = run(Aim::Accuracy(tolerance)).unwrap_err();
        assert!(matches!(failure, Failure::BudgetUsedUp { implicit: false, .. }), "{failure}");
        assert!(failure.to_string().contains("a method for stiff systems"));
    }
}

#[test]
fn long_runs_keep_energy_and_accurate_ones_the_tolerance() {
    let system = DoublePendulum::default();
    let run = method_for(&system, Aim::LongTime(0.05)).integrate(&system, DOUBLE).until(2000.0);
    assert!(energy_drift(&system, run).unwrap() < 1e-4);
    let system = Plane::default();
    let end = simulate(&system, ELLIPSE, 10.0).unwrap();
    assert!(distance(&end, &ellipse(10.0)) < 1e-7);
}

/// A method whose proof a system lacks does not begin, whatever is run through it. The double pendulum by `Nystrom12` was wrong by 8e-4, and
/// by `BlanesMoan4` by 5e-3, with success.
#[test]
fn a_method_without_its_proof_does_not_begin() {
    use Requirement::*;
    fn refused<Sys: Lagrangian<N, Scalar = f64>, const N: usize>(
        system: &Sys,
        start: State<f64, N>,
        cases: &[(AnyMethod, Requirement)],
    ) {
        for &(method, requirement) in cases {
            let expected = Failure::Unsuitable { chosen: method.name(), requirement };
            let fixed = integrate(system, method, AnyController::Fixed(Fixed::new(0.01)), start);
            assert_eq!(fixed.until(1.0).finish().unwrap_err().failure, expected);
            assert_eq!(method.start(system, &start).unwrap_err(), expected);
            let text = expected.to_string();
            assert!(text.starts_with(&format!("`{method:?}` needs ")) && text.contains("; "), "{text}");
        }
    }
    let (splits, linear) = ([AnyMethod::Nystrom12, AnyMethod::BlanesMoan4], (AnyMethod::Modal, Linear));
    let [first, second] = splits.map(|method| (method, Separable));
    refused(&TwoPendulums::new(1.0), DOUBLE, &[first, second, linear]);
    refused(&Swing::new(), State::new(0.0, [1.0], [0.0]), &[linear]);
    let hangs = State::new(0.0, [0.6, -0.8], [0.0; 2]);
    refused(&Bob::new(), hangs, &[first, second, linear, (AnyMethod::Gauss4, Independent)]);
    let fast = State::new(0.0, [0.1], [0.5]);
    refused(&Relativistic::new(1.0, 1.0), fast, &[first, second, linear, (AnyMethod::Gauss4, Quadratic)]);
}

/// Adaptive controllers on a method without an estimate, in all ways to write them.
#[test]
fn a_controller_without_its_estimate_does_not_begin() {
    let (system, start) = (Repelled::new(-1.0), State::new(0.0, [1.0], [0.0]));
    let pi = Pi::tolerance(1e-9);
    for method in [AnyMethod::BlanesMoan4, AnyMethod::Gauss4, AnyMethod::Modal] {
        let expected = Failure::Unsuitable { chosen: method.name(), requirement: Requirement::ErrorEstimate };
        let failures = [
            integrate(&system, method, AnyController::Pi(pi), start).until(1.0).finish(),
            integrate(&system, method, pi, start).until(1.0).finish(),
            integrate(&system, method, Pid::pi42(pi), start).until(1.0).finish(),
            integrate(&system, Projection(method), pi, start).until(1.0).finish(),
        ]
        .map(|end| end.unwrap_err().failure);
        assert_eq!(failures, [expected; 4]);
        assert!(expected.to_string().contains("`Fixed::new(h)`"), "{expected}");
    }
}
