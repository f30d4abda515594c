//! The table chooses well, says what it does, and its runs are those of the methods by name.

use super::*;
use crate::prelude::*;
use crate::testing::bank::{ELLIPSE, Pendulum, ellipse};
use crate::testing::distance;
use crate::testing::emitted::{Bob, Kepler, Relativistic, Repelled, Swing, TwoPendulums, Wedge};

lagrangian! {
    system Overdamped {
        param c;
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = 0.5 * c * x.powi(2);
        D = 0.5 * c * dot(x).powi(2);
    }
}

lagrangian! {
    system Plane {
        coord x, y;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = -1 / hypot(x, y);
    }
}

/// What a user writes for a system of their own.
impl Choices<1> for Pendulum {
    type Accurate = Accurate<true>;
    type Fine = Fine<false, true>;
    type FineControl = FineControl<false>;
    type Geometric = Geometric<false, true, true>;
}

const DOUBLE: State<f64, 2> = crate::testing::bank::DOUBLE;

#[test]
fn the_front_page_shows_the_table() {
    let page = include_str!("../lib.rs");
    let shown: Vec<_> = page.lines().filter(|line| line.starts_with("//! | `")).collect();
    let rows: Vec<_> = ROWS.iter().map(|row| format!("//! {row}")).collect();
    assert_eq!(shown, rows, "the table of lib.rs has to read:\n{}\n", rows.join("\n"));
}

#[test]
fn the_table_chooses_what_fits_and_every_row_is_reached() {
    let mut reached = vec![];
    let mut check = |chosen: [&'static str; 7], expected: [&str; 5]| {
        let [coarse, middle @ .., stiff_coarse, stiff] = chosen;
        assert_eq!([coarse, stiff_coarse, stiff], ["DormandPrince5", "Rodas5P", "Radau5"]);
        assert_eq!(middle, expected[1..], "{}", expected[0]);
        reached.extend(chosen);
    };
    macro_rules! rows {
        ($system:expr => $($expected:literal)*) => {
            let system = $system;
            let rows = [1e-4, 1e-9, 1e-10, 1e-13].map(|tolerance| method_for(&system, aim::Accuracy(tolerance)).row);
            let [coarse, stiff] = [1e-4, 1e-9].map(|tolerance| method_for(&system, aim::Stiff(tolerance)).row);
            let [a, b, c, d] = rows;
            let rows = [a, b, c, d, method_for(&system, aim::LongTime(0.1)).row, coarse, stiff];
            check(rows.map(|row| row.method), [stringify!($system), $($expected),*]);
        };
    }
    rows!(Repelled::new(-1.0) => "Nystrom12" "Taylor" "Taylor" "Modal");
    rows!(Swing::new() => "Nystrom12" "Taylor" "Taylor" "BlanesMoan4");
    rows!(TwoPendulums::new(1.0) => "Verner9" "Taylor" "Taylor" "Gauss4");
    rows!(TwoPendulums::new(1.0).prepared() => "Verner9" "Taylor" "Taylor" "Gauss4");
    rows!(Kepler::new(1.0) => "Verner9" "Taylor" "Taylor" "Gauss4");
    rows!(Bob::new() => "Verner9" "Verner9" "Taylor" "Dop853");
    rows!(Relativistic::new(1.0, 1.0) => "Verner9" "Taylor" "Taylor" "Dop853");
    // With a choice in them, equations have series on either side of it only.
    rows!(Wedge::new(1.0) => "Nystrom12" "Nystrom12" "Nystrom12" "BlanesMoan4");
    rows!(Pendulum::default() => "Nystrom12" "Nystrom12" "Nystrom12" "BlanesMoan4");
    for row in ROWS {
        assert!(reached.contains(&row.method), "{row}");
    }
}

/// A choice is made for senseless aims, too, and the run says so.
#[test]
fn senseless_aims_do_not_begin() {
    fn begins<A: Aim<Pendulum, 1>>(aim: A) -> Row {
        method_for(&Pendulum::default(), aim).row
    }
    let (system, start) = (Pendulum::default(), State::new(0.0, [1.0], [0.0]));
    assert_eq!(begins(aim::Accuracy(f64::NAN)), Nystrom12::ROW);
    assert!(method_for(&system, aim::Accuracy(f64::NAN)).integrate(start).until(1.0).finish().is_err());
    assert!(method_for(&system, aim::LongTime(0.0)).integrate(start).until(1.0).finish().is_err());
    assert!(method_for(&system, aim::Stiff(-1.0)).integrate(start).until(1.0).finish().is_err());
}

/// Ends, states, samples and events of a chosen run are those of the run by name, bit for bit.
#[test]
fn a_chosen_run_is_the_run_by_name() {
    macro_rules! compare {
        ($system:expr, $start:expr, $aim:expr, $method:expr, $controller:expr) => {
            let (system, start) = (&$system, $start);
            let run = || integrate(system, $method, $controller, start).until(2.0);
            let chosen = || method_for(system, $aim).integrate(start).until(2.0);
            assert_eq!(chosen().finish(), run().finish());
            let (mut by_name, mut by_aim) = (run(), chosen());
            assert_eq!(by_name.run_out(), by_aim.run_out());
            assert_eq!((by_name.statistics(), by_name.state()), (by_aim.statistics(), by_aim.state()));
            assert!(run().map(|step| step.map(|step| step.to)).eq(chosen().states()));
            assert!(run().sample_evenly(33).eq(chosen().sample_evenly(33)));
            assert!(run().sample([0.5, 1.0]).eq(chosen().sample([0.5, 1.0])));
            let event = || Event::either(|at| at.q[0] - 0.5);
            assert!(run().events(event()).eq(chosen().events(event())));
            assert_eq!(chosen().max_steps(1).finish(), run().max_steps(1).finish());
        };
    }
    let (double, oscillator) = (TwoPendulums::new(1.0), Repelled::new(-1.0));
    let start = State::new(0.0, [1.0], [0.0]);
    let pi = Pi::tolerance;
    compare!(double, DOUBLE, aim::Accuracy(1e-5), DormandPrince5, pi(1e-5));
    compare!(double, DOUBLE, aim::Accuracy(1e-9), Verner9, pi(1e-9));
    compare!(double, DOUBLE, aim::Stiff(1e-6), Rodas5P, pi(1e-6));
    compare!(double, DOUBLE, aim::Stiff(1e-9), Radau5, pi(1e-9));
    compare!(oscillator, start, aim::Accuracy(1e-9), Nystrom12, pi(1e-9));
    compare!(oscillator, start, aim::Accuracy(1e-15), Taylor::of_order(20), Decay::tolerance(1e-15));
    let long = method_for(&oscillator, aim::LongTime(0.05)).integrate(start).until(2.0).finish();
    assert_eq!(long, integrate(&oscillator, Modal, Fixed::new(0.05), start).until(2.0).finish());
}

/// Everything is true of an oscillator, and all aims are reached.
#[test]
fn every_aim_is_met() {
    let (system, start) = (Repelled::new(-1.0), State::new(0.0, [1.0], [0.0]));
    let error = |end: State<f64, 1>| (end.q[0] - 1f64.cos()).abs();
    for tolerance in [1e-4, 1e-7, 1e-9, 1e-11, 1e-13] {
        let end = method_for(&system, aim::Accuracy(tolerance)).integrate(start).until(1.0).finish().unwrap();
        assert!(error(end) < 10.0 * tolerance, "{tolerance}");
        assert_eq!(simulate(&system, start, 1.0, tolerance), Ok(end));
    }
    let long = method_for(&system, aim::LongTime(0.1)).integrate(start).until(1.0).finish().unwrap();
    assert!(error(long) < 1e-13);
    for tolerance in [1e-6, 1e-9] {
        let end = method_for(&system, aim::Stiff(tolerance)).integrate(start).until(1.0).finish().unwrap();
        assert!(error(end) < 10.0 * tolerance, "{tolerance}");
    }
}

/// A spring beside a damper that is 1e8 times faster: as it says, the one aim does it, the other says what to do.
#[test]
fn stiffness_has_to_be_told() {
    let (system, start) = (Overdamped::new(1e8), State::new(0.0, [1.0], [0.0]));
    for tolerance in [1e-6, 1e-9] {
        let stiff =
            method_for(&system, aim::Stiff(tolerance)).integrate(start).until(1.0).max_steps(1000).finish();
        let error = (stiff.unwrap().q[0] - (-1f64).exp()).abs();
        assert!(error < 10.0 * tolerance + 2e-8, "{error}");
        let plain = method_for(&system, aim::Accuracy(tolerance))
            .integrate(start)
            .until(1.0)
            .max_steps(1000)
            .finish();
        let failure = plain.unwrap_err().failure;
        assert!(matches!(failure, Failure::BudgetUsedUp { implicit: false, .. }), "{failure}");
        assert!(failure.to_string().contains("a method for stiff systems"));
    }
}

#[test]
fn long_runs_keep_energy_and_accurate_ones_the_tolerance() {
    let system = TwoPendulums::new(1.0);
    let energy = system.jacobi_at(&DOUBLE);
    for step in method_for(&system, aim::LongTime(0.05)).integrate(DOUBLE).until(2000.0) {
        assert!((system.jacobi_at(&step.unwrap().to) / energy - 1.0).abs() < 1e-4);
    }
    let end = simulate(&Plane::new(), ELLIPSE, 10.0, 1e-9).unwrap();
    assert!(distance(&end, &ellipse(10.0)) < 1e-7);
}
