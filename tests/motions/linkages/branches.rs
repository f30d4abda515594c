//! Positions in which nothing tells how a motion goes on: they are named, with the tangents of both branches.

use crate::systems::*;
use lagrange_runtime::prelude::*;
use lagrange_runtime::testing::reference::SimplePendulum;
use lagrange_runtime::traits::branches;
use lagrange_runtime::{Controller, Method};
use std::f64::consts::{FRAC_PI_2, PI};

const LINE: [f64; 3] = [0.0; 3];

fn near(a: &SVector<f64, 3>, b: [f64; 3]) -> bool {
    (a - SVector::from(b)).amax() < 1e-9
}

/// In the line a parallelogram begins to move as one, or its coupler begins to turn with one crank about the pivot
/// of the other.
#[test]
fn tangents_of_a_parallelogram() {
    let rhombus = Rhombus::new();
    for q in [LINE, [0.1, 0.1, 0.0], [0.0, 0.2, 0.2], [0.03, 0.02, -0.02]] {
        let found = branches(&rhombus, &State::new(0.0, q, LINE)).unwrap();
        assert!(near(&found.q, LINE), "{}", found.q);
        let [a, b] = &found.directions;
        assert!(near(a, [1.0, 1.0, 0.0]) && near(b, [0.0, 1.0, 1.0]), "{a} {b}");
    }
    // Far from the line there is none near.
    assert_eq!(branches(&rhombus, &State::new(0.0, [1.3, 1.3, 0.0], LINE)), None);
}

/// A start in the line at rest, or with a velocity that is admissible to first order alone, has two motions, or none.
#[test]
fn starts_in_the_line() {
    let rhombus = Rhombus::new();
    let run = |qd| {
        let start = State::new(0.0, LINE, qd);
        integrate(&rhombus, Dop853, PiController::tolerance(1e-9), start)
            .until(1.0)
            .final_state()
            .unwrap_err()
    };
    for qd in [LINE, [1.0, 1.5, 0.5]] {
        let failed = run(qd);
        let Failure::Bifurcation { t: 0.0, coordinates } = failed.failure else { panic!("{failed}") };
        assert_eq!(coordinates.map(|c| c.name), ["a[1]", "b"]);
        let found = branches(&rhombus, &State::new(0.0, LINE, qd)).unwrap();
        let directions = found.directions.map(|along| coordinates.map(|c| along[c.index]));
        assert!((directions[0][0] - 1.0).abs() < 1e-9 && directions[0][1].abs() < 1e-9, "{directions:?}");
        assert!(
            (directions[1][0] - 1.0).abs() < 1e-9 && (directions[1][1] - 1.0).abs() < 1e-9,
            "{directions:?}"
        );
        assert!(failed.to_string().contains("coordinates `a[1]` and `b` move in different"), "{failed}");
    }
}

/// Angle after the time t of a pendulum, from the level, with ä = −square · cos a.
fn pendulum(square: f64, start: [f64; 2], t: f64) -> f64 {
    SimplePendulum::new(square, 1.0, FRAC_PI_2 + start[0], start[1]).state(t).0 - FRAC_PI_2
}

/// The three angles after the time t of the branch on which all of the parallelogram turns, or the coupler with one
/// crank: with equal angles (5/6) ȧ² + 2 g sin a is its energy, or (1/3) ȧ² + g sin a.
fn on_branch(branch: usize, start: [f64; 2], t: f64) -> [f64; 3] {
    match branch {
        0 => [pendulum(1.2 * 9.81, start, t), pendulum(1.2 * 9.81, start, t), 0.0],
        _ => [0.0, pendulum(1.5 * 9.81, start, t), pendulum(1.5 * 9.81, start, t)],
    }
}

/// The largest error at ten times of a run of `Rhombus` from a position on a branch.
fn error_on_branch<M, C>(method: M, controller: C, branch: usize, at: f64, rate: f64) -> Result<f64, Failure>
where
    M: Method<Rhombus, 3>,
    C: Controller<f64, 3, M::Error>,
{
    let along = if branch == 0 { [1.0, 1.0, 0.0] } else { [0.0, 1.0, 1.0] };
    let start = State::new(0.0, along.map(|x| x * at), along.map(|x| x * rate));
    let rhombus = Rhombus::new();
    let run = integrate(&rhombus, method, controller, start).until(2.0);
    let mut worst = 0.0f64;
    for state in run.sample((0..=10).map(|k| 0.2 * f64::from(k))) {
        let state = state?;
        let exact = on_branch(branch, [at, rate], state.t);
        worst = worst.max((state.q - SVector::from(exact)).amax());
    }
    Ok(worst)
}

/// A velocity along one of the branches tells which one is meant, in the position itself: every method goes there.
#[test]
fn starts_in_the_line_go_along_their_branch() {
    for (branch, rate) in [(0, 1.0), (1, 1.0), (0, -0.3), (1, 5.0), (0, 0.3), (1, 0.1)] {
        for tolerance in [1e-6, 1e-9, 1e-12] {
            let pi = PiController::tolerance(tolerance);
            let series = Taylor;
            let errors = [
                error_on_branch(DormandPrince5, pi, branch, 0.0, rate),
                error_on_branch(Dop853, pi, branch, 0.0, rate),
                error_on_branch(Verner9, pi, branch, 0.0, rate),
                error_on_branch(Rodas5P, pi, branch, 0.0, rate),
                error_on_branch(Radau5, pi, branch, 0.0, rate),
                error_on_branch(series, TaylorController::tolerance(tolerance), branch, 0.0, rate),
            ];
            for error in errors {
                assert!(error.unwrap() < 100.0 * tolerance, "{branch} {rate} {tolerance:e}: {errors:?}");
            }
        }
        let error = error_on_branch(Rk4, FixedStep::new(1e-3), branch, 0.0, rate).unwrap();
        assert!(error < 1e-9, "{branch} {rate}: {error:e}");
    }
}

/// Beside the line, too, where constraints have no digits.
#[test]
fn starts_beside_the_line_go_along_their_branch() {
    for branch in [0, 1] {
        for at in [1e-12, -1e-9, 1e-7, -1e-5, 1e-4, -1e-3, 1e-2] {
            for tolerance in [1e-6, 1e-9, 1e-12] {
                let pi = PiController::tolerance(tolerance);
                let errors = [
                    error_on_branch(DormandPrince5, pi, branch, at, 1.3),
                    error_on_branch(Dop853, pi, branch, at, 1.3),
                    error_on_branch(Verner9, pi, branch, at, 1.3),
                ];
                for error in errors {
                    assert!(error.unwrap() < 30.0 * tolerance, "{branch} {at} {tolerance:e}: {errors:?}");
                }
            }
        }
    }
}

/// A velocity is along a branch to the digits that a start has, and not to fewer.
#[test]
fn starts_in_the_line_beside_a_branch() {
    let rhombus = Rhombus::new();
    let end = |off: f64| {
        let start = State::new(0.0, LINE, [1.0, 1.0 + off, off]);
        integrate(&rhombus, Dop853, PiController::tolerance(1e-9), start).until(1.0).final_state()
    };
    let exact = on_branch(0, [0.0, 1.0], 1.0);
    for off in [1e-12, 1e-9, -1e-7] {
        let off_branch = (end(off).unwrap().q - SVector::from(exact)).amax();
        assert!(off_branch < 1e-8 + 10.0 * f64::abs(off), "{off:e}: {off_branch:e}");
    }
    for off in [1e-4, -1e-2, 0.3] {
        let failed = end(off).unwrap_err();
        assert!(matches!(failed.failure, Failure::Bifurcation { t: 0.0, .. }), "{off:e}: {failed}");
    }
}

/// Two loops in line: a branch is one of four, whose tangents are known.
#[test]
fn chains_begin_in_the_line() {
    let chain = TwoLoops::default();
    let start = State::new(0.0, [0.0; 5], [1.0, 1.0, 1.0, 0.0, 0.0]);
    let end =
        integrate(&chain, Dop853, PiController::tolerance(1e-10), start).until(2.0).final_state().unwrap();
    let exact = pendulum(3.5 / 3.0 * 9.81, [0.0, 1.0], 2.0);
    assert!((end.q - SVector::from([exact, exact, exact, 0.0, 0.0])).amax() < 1e-8, "{} {exact}", end.q);
    // At rest, or with a turn of both couplers beside that of all cranks, it is not known, and not followed.
    for qd in [[0.0; 5], [1.0, 1.5, 2.0, 0.5, 0.5]] {
        let start = State::new(0.0, [0.0; 5], qd);
        let failed = integrate(&chain, Dop853, PiController::tolerance(1e-10), start)
            .until(2.0)
            .final_state()
            .unwrap_err();
        assert!(matches!(failed.failure, Failure::DependentConstraints { t: 0.0, .. }), "{failed}");
    }
}

/// A stepper that is stopped, and goes on, in the line and near it.
#[test]
fn steppers_rest_near_the_line() {
    let up = State::new(0.0, [FRAC_PI_2, FRAC_PI_2, 0.0], [-1.0, -1.0, 0.0]);
    let angle = |t: f64| SimplePendulum::new(1.2 * 9.81, 1.0, PI, -1.0).state(t).0 - FRAC_PI_2;
    let (mut before, mut after) = (0.0, 1.0);
    while after - before > 1e-15 {
        let middle = 0.5 * (before + after);
        *(if angle(middle) > 0.0 { &mut before } else { &mut after }) = middle;
    }
    for tolerance in [1e-6, 1e-9, 1e-11] {
        let mut stepper = Stepper::new(Rhombus::new(), Dop853, PiController::tolerance(tolerance), up);
        for beside in [-0.02, -1e-4, -1e-8, 0.0, 1e-9, 1e-6, 1e-3, 2.0] {
            stepper.advance_to(before + beside).unwrap();
            let state = stepper.state();
            let off = state.q - SVector::from([angle(state.t), angle(state.t), 0.0]);
            assert!(off.amax() < 1e3 * tolerance, "{tolerance:e} {beside:e}: {off}");
        }
    }
}

/// A swing that ends in the line with no velocity returns, as smooth motions do, or is named.
#[test]
fn a_swing_that_ends_in_the_line() {
    let rhombus = Rhombus::new();
    let rate = (2.4f64 * 9.81).sqrt();
    let start = State::new(0.0, [-FRAC_PI_2, -FRAC_PI_2, 0.0], [rate, rate, 0.0]);
    for k in 0..14 {
        let tolerance = 1e-6 * 0.3f64.powi(k);
        let end =
            integrate(&rhombus, Dop853, PiController::tolerance(tolerance), start).until(3.0).final_state();
        match end {
            Ok(end) => {
                assert!((end.q[0] + 0.5182853698).abs() < 20.0 * tolerance + 1e-9, "{tolerance:e} {}", end.q)
            }
            Err(failed) => {
                assert!(matches!(failed.failure, Failure::Bifurcation { .. }), "{tolerance:e} {failed}");
            }
        }
    }
}

/// Positions and velocities fit both of two branches that touch.
#[test]
fn branches_that_touch() {
    let bead = Touching::new();
    let start = State::new(0.0, [-1.0, 1.0], [1.5, -3.0]);
    let found = branches(&bead, &State::new(0.0, [-0.1, 0.01], [0.0; 2])).unwrap();
    assert!(found.q.amax() < 1e-8, "{}", found.q);
    for direction in &found.directions {
        assert!((direction - SVector::from([1.0, 0.0])).amax() < 1e-6, "{direction}");
    }
    for k in 0..12 {
        let tolerance = 1e-6 * 0.4f64.powi(k);
        let run = integrate(&bead, Dop853, PiController::tolerance(tolerance), start).until(1.5);
        let failed = run.final_state().unwrap_err();
        assert!(matches!(failed.failure, Failure::Bifurcation { .. }), "{tolerance:e} {failed}");
    }
}

/// Masses that are no numbers, and negative ones, although the accelerations of a rod do not know of them.
#[test]
fn rods_without_a_metric() {
    let guess = State::new(0.0, [0.4, -0.4], [0.3, 0.0]);
    for m in [f64::NAN, f64::INFINITY] {
        let rod = Rod::new(m, 0.5);
        let failure = consistent(&rod, &guess).unwrap_err();
        assert!(matches!(failure, Failure::NonFinite { t: 0.0, h: 0.0 }), "{failure}");
        assert!(failure.to_string().contains("a parameter is not finite"), "{failure}");
    }
    let run = |m: f64| {
        let rod = Rod::new(m, 0.5);
        let start = consistent(&rod, &guess).unwrap();
        integrate(&rod, Dop853, PiController::tolerance(1e-9), start).until(1.0).final_state()
    };
    assert!(run(1.0).is_ok());
    let failed = run(-1.0).unwrap_err();
    assert!(matches!(failed.failure, Failure::NegativeInertia { t: 0.0, .. }), "{failed}");
}

/// A parallelogram that turns over passes the line four times in ten seconds, at any tolerance.
#[test]
fn every_tolerance_goes_through_the_line() {
    let rhombus = Rhombus::new();
    let start = State::new(0.0, [FRAC_PI_2, FRAC_PI_2, 0.0], [-1.0, -1.0, 0.0]);
    let exact = pendulum(1.2 * 9.81, [FRAC_PI_2, -1.0], 10.0);
    let right = |tolerance: f64, end: State<f64, 3>| {
        let off = (end.q - SVector::from([exact, exact, 0.0])).amax();
        assert!(off < 3e3 * tolerance, "{tolerance:e}: {off:e}");
    };
    for k in 0..=40 {
        let tolerance = 1e-6 * 10f64.powf(-0.15 * f64::from(k));
        let pi = PiController::tolerance(tolerance);
        let (series, control) = (Taylor, TaylorController::tolerance(tolerance));
        right(tolerance, integrate(&rhombus, Dop853, pi, start).until(10.0).final_state().unwrap());
        right(tolerance, integrate(&rhombus, Verner9, pi, start).until(10.0).final_state().unwrap());
        right(tolerance, integrate(&rhombus, series, control, start).until(10.0).final_state().unwrap());
    }
}

/// At rest where branches cross, which numbers hit but for rounding, a force or a blow leads to either.
#[test]
fn rest_where_branches_cross_has_no_accelerations() {
    use std::f64::consts::{FRAC_PI_2, PI};
    let rhombus = Rhombus::new();
    for q in [[0.0; 3], [PI, 0.0, PI], [2.0 * PI, 0.0, 2.0 * PI], [0.0, PI, PI]] {
        let at = State::new(0.0, q, [0.0; 3]);
        let [accel, after] = [rhombus.accel_at(&at), rhombus.jump(&at, &[0.3, -0.8, 0.45].into()).after.qd];
        assert!(accel[0].is_nan() && after[0].is_nan(), "{q:?}: {accel} {after}");
    }
    let crank = SliderCrank { r: 0.6, l: 0.6, ..SliderCrank::new() };
    for side in [1.0, -1.0] {
        let at = State::new(0.0, [side * FRAC_PI_2; 2], [0.0; 2]);
        let [accel, after] = [crank.accel_at(&at), crank.jump(&at, &[0.3, -0.8].into()).after.qd];
        assert!(accel[0].is_nan() && after[0].is_nan(), "{side}: {accel} {after}");
    }
}

lagrangian! {
    /// A bead on a lying eight, which crosses itself at the origin.
    system Eight {
        coord x, y;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = 0;
        constraint eight: y.powi(2) == x.powi(2) - x.powi(4);
    }
}

/// Steps of one size, whose ends fall anywhere beside the crossing, go through it: nothing changes the speed.
#[test]
fn equal_steps_keep_the_speed_over_a_crossing() {
    let (eight, speed) = (Eight::new(), 3.0);
    let mut worst = 0.0f64;
    for k in 0..200 {
        let x = 0.3 + 7e-4 * f64::from(k);
        let y = -(x * x - x.powi(4)).sqrt();
        let along = SVector::from([2.0 * y, 2.0 * x - 4.0 * x.powi(3)]);
        let start = State { t: 0.0, q: [x, y].into(), qd: along * (speed / along.norm()) };
        for h in [0.005, 0.01, 0.02] {
            let end = integrate(&eight, Dop853, FixedStep::new(h), start).until(0.4).final_state().unwrap();
            worst = worst.max((end.qd.norm() / speed - 1.0).abs());
            let end = integrate(&eight, Rk4, FixedStep::new(h), start).until(0.4).final_state().unwrap();
            worst = worst.max((end.qd.norm() / speed - 1.0).abs());
        }
    }
    assert!(worst < 1e-4, "{worst:e}");
}
