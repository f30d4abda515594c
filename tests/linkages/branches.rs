//! Positions in which nothing tells how a motion goes on: they are named, with the tangents of both branches.

use crate::systems::*;
use lagrange_runtime::prelude::*;
use lagrange_runtime::traits::branches;
use std::f64::consts::FRAC_PI_2;

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
        let Failure::Bifurcation { t: 0.0, coordinates, directions } = failed.failure else {
            panic!("{failed}")
        };
        assert_eq!(coordinates.map(|c| c.name), ["a[1]", "b"]);
        assert!((directions[0][0] - 1.0).abs() < 1e-9 && directions[0][1].abs() < 1e-9, "{directions:?}");
        assert!(
            (directions[1][0] - 1.0).abs() < 1e-9 && (directions[1][1] - 1.0).abs() < 1e-9,
            "{directions:?}"
        );
        assert!(failed.to_string().contains("coordinates `a[1]` and `b` move as 1.000 to "), "{failed}");
    }
    // A velocity along one of them tells which is meant, but a run cannot begin there.
    for qd in [[1.0, 1.0, 0.0], [0.0, 1.0, 1.0]] {
        let failed = run(qd);
        assert!(matches!(failed.failure, Failure::DependentConstraints { t: 0.0, .. }), "{failed}");
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

/// Masses that are no numbers, and negative ones, of which the accelerations of a rod do not know.
#[test]
fn rods_without_a_metric() {
    let guess = State::new(0.0, [0.4, -0.4], [0.3, 0.0]);
    for m in [f64::NAN, f64::INFINITY] {
        let rod = Rod::new(m, 0.5);
        let failure = consistent(&rod, &guess).unwrap_err();
        assert!(matches!(failure, Failure::NonFinite { t: 0.0, h: 0.0 }), "{failure}");
        assert!(failure.to_string().contains("a parameter, is not finite"), "{failure}");
    }
    let ends = [1.0, -1.0].map(|m| {
        let rod = Rod::new(m, 0.5);
        let start = consistent(&rod, &guess).unwrap();
        integrate(&rod, Dop853, PiController::tolerance(1e-9), start).until(1.0).final_state().unwrap()
    });
    assert!((ends[0].q - ends[1].q).amax() < 1e-12, "{} {}", ends[0].q, ends[1].q);
}
