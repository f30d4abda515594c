//! The table chooses well, says what it does, and its runs are those of the methods by name.

use crate::systems::bank::{ELLIPSE, Pendulum, ellipse};
use crate::systems::emitted::{Bob, Kepler, Relativistic, Repelled, Swing, TwoPendulums, Wedge};
use lagrange_runtime::method::choice::{
    Accurate, Fine, FineControl, Geometric, Goal, RECOMMENDATIONS, Recommendation, RecommendedMethods,
};
use lagrange_runtime::prelude::*;
use lagrange_runtime::testing::distance;

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

/// The implementation that a user writes for a system of their own.
impl RecommendedMethods<1> for Pendulum {
    type Accurate = Accurate<true>;
    type Fine = Fine<false, true>;
    type FineControl = FineControl<false>;
    type Geometric = Geometric<false, true, true>;
}

const DOUBLE: State<f64, 2> = crate::systems::bank::DOUBLE;

#[test]
fn the_front_page_shows_the_table() {
    let page = include_str!("../../../lagrange-runtime/src/lib.rs");
    let shown: Vec<_> = page.lines().filter(|line| line.starts_with("//! | `")).collect();
    let rows: Vec<_> = RECOMMENDATIONS.iter().map(|row| format!("//! {row}")).collect();
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
            let rows = [1e-4, 1e-9, 1e-10, 1e-13].map(|tolerance| method_for(&system, goal::Accuracy(tolerance)).row);
            let [coarse, stiff] = [1e-4, 1e-9].map(|tolerance| method_for(&system, goal::Stiff(tolerance)).row);
            let [a, b, c, d] = rows;
            let rows = [a, b, c, d, method_for(&system, goal::LongTime(0.1)).row, coarse, stiff];
            check(rows.map(|row| row.method), [stringify!($system), $($expected),*]);
        };
    }
    rows!(Repelled::new(-1.0) => "Nystrom12" "Taylor" "Taylor" "MatrixExponential");
    rows!(Swing::new() => "Nystrom12" "Taylor" "Taylor" "BlanesMoan4");
    rows!(TwoPendulums::new(1.0) => "Verner9" "Taylor" "Taylor" "Gauss4");
    rows!(TwoPendulums::new(1.0).precomputed() => "Verner9" "Taylor" "Taylor" "Gauss4");
    rows!(Kepler::new(1.0) => "Verner9" "Taylor" "Taylor" "Gauss4");
    rows!(Bob::new() => "Verner9" "Verner9" "Taylor" "Dop853");
    rows!(Relativistic::new(1.0, 1.0) => "Verner9" "Taylor" "Taylor" "Dop853");
    // With a choice in them, equations have series on either side of it only.
    rows!(Wedge::new(1.0) => "Nystrom12" "Nystrom12" "Nystrom12" "BlanesMoan4");
    rows!(Pendulum::default() => "Nystrom12" "Nystrom12" "Nystrom12" "BlanesMoan4");
    for row in RECOMMENDATIONS {
        assert!(reached.contains(&row.method), "{row}");
    }
}

/// A choice is made for senseless aims, too, and the run says so.
#[test]
fn senseless_aims_do_not_begin() {
    fn begins<A: Goal<Pendulum, 1>>(goal: A) -> Recommendation {
        method_for(&Pendulum::default(), goal).row
    }
    let (system, start) = (Pendulum::default(), State::new(0.0, [1.0], [0.0]));
    let row = RECOMMENDATIONS.iter().find(|row| row.method == "Nystrom12");
    assert_eq!(Some(&begins(goal::Accuracy(f64::NAN))), row);
    assert!(method_for(&system, goal::Accuracy(f64::NAN)).integrate(start).until(1.0).final_state().is_err());
    assert!(method_for(&system, goal::LongTime(0.0)).integrate(start).until(1.0).final_state().is_err());
    assert!(method_for(&system, goal::Stiff(-1.0)).integrate(start).until(1.0).final_state().is_err());
}

/// Ends, states, samples and events of a chosen run are those of the run by name, bit for bit.
#[test]
fn a_chosen_run_is_the_run_by_name() {
    macro_rules! compare {
        ($system:expr, $start:expr, $goal:expr, $method:expr, $controller:expr) => {
            let (system, start) = (&$system, $start);
            let run = || integrate(system, $method, $controller, start).until(2.0);
            let chosen = || method_for(system, $goal).integrate(start).until(2.0);
            assert_eq!(chosen().final_state(), run().final_state());
            let (mut by_name, mut by_aim) = (run(), chosen());
            assert_eq!(by_name.run_to_end(), by_aim.run_to_end());
            assert_eq!((by_name.statistics(), by_name.state()), (by_aim.statistics(), by_aim.state()));
            assert!(run().map(|step| step.map(|step| step.to)).eq(chosen().states()));
            assert!(run().sample_evenly(33).eq(chosen().sample_evenly(33)));
            assert!(run().sample([0.5, 1.0]).eq(chosen().sample([0.5, 1.0])));
            let event = || Event::either(|at| at.q[0] - 0.5);
            assert!(run().events(event()).eq(chosen().events(event())));
            assert_eq!(chosen().max_steps(1).final_state(), run().max_steps(1).final_state());
        };
    }
    let (double, oscillator) = (TwoPendulums::new(1.0), Repelled::new(-1.0));
    let start = State::new(0.0, [1.0], [0.0]);
    let pi = PiController::tolerance;
    compare!(double, DOUBLE, goal::Accuracy(1e-5), DormandPrince5, pi(1e-5));
    compare!(double, DOUBLE, goal::Accuracy(1e-9), Verner9, pi(1e-9));
    compare!(double, DOUBLE, goal::Stiff(1e-6), Rodas5P, pi(1e-6));
    compare!(double, DOUBLE, goal::Stiff(1e-9), Radau5, pi(1e-9));
    compare!(oscillator, start, goal::Accuracy(1e-9), Nystrom12, pi(1e-9));
    compare!(
        oscillator,
        start,
        goal::Accuracy(1e-15),
        Taylor::of_order(20),
        TaylorController::tolerance(1e-15)
    );
    let long = method_for(&oscillator, goal::LongTime(0.05)).integrate(start).until(2.0).final_state();
    assert_eq!(
        long,
        integrate(&oscillator, MatrixExponential, FixedStep::new(0.05), start).until(2.0).final_state()
    );
}

/// Everything is true of an oscillator, and all aims are reached.
#[test]
fn every_aim_is_met() {
    let (system, start) = (Repelled::new(-1.0), State::new(0.0, [1.0], [0.0]));
    let error = |end: State<f64, 1>| (end.q[0] - 1f64.cos()).abs();
    for tolerance in [1e-4, 1e-7, 1e-9, 1e-11, 1e-13] {
        let end =
            method_for(&system, goal::Accuracy(tolerance)).integrate(start).until(1.0).final_state().unwrap();
        assert!(error(end) < 10.0 * tolerance, "{tolerance}");
        assert_eq!(simulate(&system, start, 1.0, tolerance), Ok(end));
    }
    let long = method_for(&system, goal::LongTime(0.1)).integrate(start).until(1.0).final_state().unwrap();
    assert!(error(long) < 1e-13);
    for tolerance in [1e-6, 1e-9] {
        let end =
            method_for(&system, goal::Stiff(tolerance)).integrate(start).until(1.0).final_state().unwrap();
        assert!(error(end) < 10.0 * tolerance, "{tolerance}");
    }
}

/// A spring beside a damper that is 1e8 times faster: as it says, the one goal does it, the other says what to do.
#[test]
fn stiffness_has_to_be_told() {
    let (system, start) = (Overdamped::new(1e8), State::new(0.0, [1.0], [0.0]));
    for tolerance in [1e-6, 1e-9] {
        let stiff = method_for(&system, goal::Stiff(tolerance))
            .integrate(start)
            .until(1.0)
            .max_steps(1000)
            .final_state();
        let error = (stiff.unwrap().q[0] - (-1f64).exp()).abs();
        assert!(error < 10.0 * tolerance + 2e-8, "{error}");
        let plain = method_for(&system, goal::Accuracy(tolerance))
            .integrate(start)
            .until(1.0)
            .max_steps(1000)
            .final_state();
        let failure = plain.unwrap_err().failure;
        assert!(matches!(failure, Failure::BudgetUsedUp { implicit: false, .. }), "{failure}");
        assert!(failure.to_string().contains("a method for stiff systems"));
    }
}

#[test]
#[cfg_attr(not(feature = "long"), ignore = "long")]
fn long_runs_keep_energy_and_accurate_ones_the_tolerance() {
    let system = TwoPendulums::new(1.0);
    let energy = system.energy_function_at(&DOUBLE);
    for step in method_for(&system, goal::LongTime(0.05)).integrate(DOUBLE).until(2000.0) {
        assert!((system.energy_function_at(&step.unwrap().to) / energy - 1.0).abs() < 1e-4);
    }
    let end = simulate(&Plane::new(), ELLIPSE, 10.0, 1e-9).unwrap();
    assert!(distance(&end, &ellipse(10.0)) < 1e-7);
}
