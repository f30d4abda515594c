//! That the table chooses well, that what it says is what it does, and that an enum over methods is as good as they are.

use super::*;
use crate::method::explicit_rk::{Dop853, DormandPrince5};
use crate::method::gauss::Gauss4;
use crate::method::splitting::Verlet;
use crate::method::{Dense, Method};
use crate::testing::bank::*;
use crate::testing::{distance, energy_drift};

const KINDS: [Facts; 3] = [
    Facts { separable: true, quadratic: true, ..Facts::UNKNOWN },
    Facts { quadratic: true, ..Facts::UNKNOWN },
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
    assert_eq!(methods(Aim::Accuracy(1e-9)), [AnyMethod::Dop853; 3]);
    assert_eq!(methods(Aim::Accuracy(1e-4)), [AnyMethod::DormandPrince5; 3]);
    assert_eq!(methods(Aim::LongTime(0.1)), [AnyMethod::Verlet, AnyMethod::Gauss4, AnyMethod::Dop853]);
    assert_eq!(methods(Aim::Stiff(1e-4)), [AnyMethod::DormandPrince5; 3]);
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
    let aims = [Aim::Accuracy(1e-3), Aim::Accuracy(1e-9), Aim::LongTime(0.1), Aim::Stiff(1e-6)];
    for aim in aims {
        assert!(ROWS.iter().any(|row| (row.aim)(&aim) && (row.fits)(&Facts::UNKNOWN)), "{aim:?}");
    }
    let first = |aim: &Aim, facts: &Facts| ROWS.iter().position(|row| (row.aim)(aim) && (row.fits)(facts));
    for n in 0..ROWS.len() {
        assert!(aims.iter().any(|aim| KINDS.iter().any(|facts| first(aim, facts) == Some(n))), "row {n}");
    }
    let (system, start) = (Pendulum::default(), State::new(0.0, [1.0], [0.0]));
    for aim in aims {
        for facts in KINDS {
            let end = choose(&facts, aim).integrate(&system, start).until(1.0).finish();
            assert!(end.is_ok(), "{aim:?} {facts:?} {end:?}");
        }
    }
}

/// Steps and interpolants of the chosen method are those of the method itself; of Gauss methods but for rounding, since
/// velocities are found in another way.
#[test]
fn a_chosen_method_is_the_method() {
    fn compare<M: Method<DoublePendulum, 2> + Copy>(any: AnyMethod, method: M, tolerance: f64) {
        let system = DoublePendulum::default();
        let [a, b] = [0.02, 0.05];
        let memory = method.start(&system, &DOUBLE).unwrap();
        let step = method.step(&system, &memory, &DOUBLE, b).unwrap();
        let any_memory = any.start(&system, &DOUBLE).unwrap();
        let any_step = any.step(&system, &any_memory, &DOUBLE, b).unwrap();
        assert!(distance(&step.to, &any_step.to) <= tolerance);
        assert_eq!(step.evaluations, any_step.evaluations);
        let [dense, any_dense] = [method.dense(&system, &step).at(a), any.dense(&system, &any_step).at(a)];
        assert!(distance(&dense, &any_dense) <= tolerance);
        assert_eq!(
            (Method::<DoublePendulum, 2>::order(&any), Method::<DoublePendulum, 2>::dense_evaluations(&any)),
            (method.order(), method.dense_evaluations())
        );
    }
    compare(AnyMethod::Dop853, Dop853, 0.0);
    compare(AnyMethod::DormandPrince5, DormandPrince5, 0.0);
    compare(AnyMethod::Gauss4, Gauss4, 1e-15);
    let system = Pendulum::default();
    let start = State::new(0.0, [1.0], [0.0]);
    let by_name = integrate(&system, Verlet, Fixed::new(0.01), start).until(10.0).finish();
    let chosen = Choice {
        method: AnyMethod::Verlet,
        controller: AnyController::Fixed(Fixed::new(0.01)),
        aim: Aim::LongTime(0.01),
        why: "",
    };
    assert_eq!(chosen.integrate(&system, start).until(10.0).finish(), by_name);
    let samples = chosen.integrate(&system, start).until(10.0).sample_evenly(33);
    assert!(samples.map(Result::unwrap).all(|state| state.is_finite()));
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
