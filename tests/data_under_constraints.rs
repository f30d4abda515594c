//! Functions with data under constraints, and beside rotations and directions: systems with a cubic as a table against
//! the same with its formula, and a bead against its closed form.

use lagrange_runtime::ensemble::{Collect, Ensemble, Table};
use lagrange_runtime::lanes::{FinalState, Fused};
use lagrange_runtime::prelude::*;

/// A system with `h` as a table, and with its formula.
macro_rules! pair {
    ($(#[$text:meta])* $measured:ident $known:ident { $($statements:tt)* }) => {
        lagrangian! {
            $(#[$text])*
            system $measured {
                extern h: Curve(s);
                $($statements)*
            }
        }
        lagrangian! {
            $(#[$text])*
            system $known {
                fn h(s) = s.powi(3) / 3 - 0.4 * s + 0.2;
                $($statements)*
            }
        }
    };
}

pair! {
    /// A bead on a curve.
    Bead BeadByFormula {
        coord x, y;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = 9.81 * y;
        constraint road: y == h(x);
        observe push = reaction(road);
    }
}

pair! {
    /// A point whose velocity is in a plane that turns with y.
    Skate SkateByFormula {
        coord x, y, z;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2));
        V = 9.81 * z;
        constraint edge: dot(z) == h(y) * dot(x);
        observe push = reaction(edge);
    }
}

pair! {
    /// A bead on a curve that is said twice.
    Led LedByFormula {
        coord x, y;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = 9.81 * y;
        redundant constraint road: y == h(x);
        redundant constraint again: (2 + x) * (y - h(x)) == 0;
        observe push = reaction(road);
    }
}

pair! {
    /// A top under a couple that depends on time and on how far it leans.
    Top TopByFormula {
        coord R: rotation;
        let top = frame(world, [0, 0, 0], R);
        T = body(1, [0.3, 0.3, 0.5], top);
        V = h(top.vector([0, 0, 1])[2]);
        couple [0, 0, h(t)] on top;
        observe push = h(t);
    }
}

pair! {
    /// A point on a sphere.
    Pointer PointerByFormula {
        coord n: direction;
        T = 0.5 * dot(n).norm_squared();
        V = h(n[0]);
        observe push = reaction(n);
    }
}

/// The cubic by its values at knots, which the spline meets exactly.
fn table() -> Curve {
    let knots: [f64; 7] = std::array::from_fn(|k| k as f64 - 3.0);
    Curve::cubic(&knots, &knots.map(|s| s.powi(3) / 3.0 - 0.4 * s + 0.2), Beyond::Refused).unwrap()
}

#[track_caller]
fn assert_same<const R: usize, const C: usize>(found: SMatrix<f64, R, C>, expected: SMatrix<f64, R, C>) {
    let off = (found - expected).amax();
    assert!(off < 1e-12 * (1.0 + expected.amax()), "{off:e}: {found} {expected}");
}

/// Accelerations, reactions and derivatives at a state, and a run from there.
macro_rules! assert_both_move_alike {
    ($measured:ident $known:ident $at:expr) => {{
        let (measured, known, at) = ($measured::new(table()), $known::new(), $at);
        assert_same(measured.accel_at(&at), known.accel_at(&at));
        assert_same(measured.accel(&at.q, &at.qd, at.t), known.accel(&at.q, &at.qd, at.t));
        assert!((measured.push_at(&at) - known.push_at(&at)).abs() < 1e-12);
        let jacobians = (measured.jacobian(&at.q, &at.qd, at.t), known.jacobian(&at.q, &at.qd, at.t));
        assert_same(jacobians.0.q, jacobians.1.q);
        assert_same(jacobians.0.qd, jacobians.1.qd);
        let control = || PiController::tolerance(1e-10);
        let end = integrate(&measured, Dop853, control(), at).until(at.t + 0.3).final_state().unwrap();
        let exact = integrate(&known, Dop853, control(), at).until(at.t + 0.3).final_state().unwrap();
        assert!((end.q - exact.q).amax() < 1e-9 && (end.qd - exact.qd).amax() < 1e-9);
    }};
}

fn h(s: f64) -> [f64; 3] {
    [s.powi(3) / 3.0 - 0.4 * s + 0.2, s * s - 0.4, 2.0 * s]
}

/// `(1 + h'²) ẍ = −h' (g + h'' ẋ²)`, and the reaction in y.
#[test]
fn a_bead_on_a_measured_curve() {
    let bead = Bead::new(table());
    for (x, v) in [(-1.7, 0.3), (0.2, -1.1), (0.9, 2.0), (1.0, 0.0)] {
        let [y, slope, curvature] = h(x);
        let at = State::new(0.0, [x, y], [v, slope * v]);
        let along = -slope * (9.81 + curvature * v * v) / (1.0 + slope * slope);
        let up = slope * along + curvature * v * v;
        assert_same(bead.accel_at(&at), SVector::from([along, up]));
        assert!((bead.push_at(&at) - (up + 9.81)).abs() < 1e-12);
        assert_both_move_alike!(Bead BeadByFormula at);
        assert_both_move_alike!(Led LedByFormula at);
    }
}

#[test]
fn a_velocity_in_a_measured_direction() {
    for y in [-0.7, 0.4] {
        assert_both_move_alike!(Skate SkateByFormula State::new(0.1, [0.3, y, 0.2], [0.8, 0.5, 0.8 * h(y)[0]]));
    }
}

#[test]
fn measured_loads_on_rotations_and_directions() {
    let turned = UnitQuaternion::from_euler_angles(0.3, -0.5, 0.9);
    let still = State::new(0.4, [0.0; 3], [0.0; 3]);
    let start = still.with_attitude(0, &turned, &[0.5, -0.3, 2.0].into());
    assert_both_move_alike!(Top TopByFormula start);
    let place = Vector3::new(0.5, -0.4, 0.3).normalize();
    let start = Pointer::new(table()).with_direction_n(still, &place, &Vector3::new(0.2, 0.7, -0.1));
    assert_both_move_alike!(Pointer PointerByFormula start);
}

/// Samples side by side stay on curves of their own.
#[test]
fn beads_in_lanes_have_curves_of_their_own() {
    let bead = |[number]: [u64; 1]| {
        let knots: [f64; 7] = std::array::from_fn(|k| k as f64 - 3.0);
        let steep = 0.2 + 0.1 * number as f64;
        let curve = Curve::cubic(&knots, &knots.map(|s| steep * s * s), Beyond::Refused).unwrap();
        (Bead::new(curve), State::new(0.0, [1.0, steep], [0.0, 0.0]))
    };
    let samples = Table::new((0..11).map(|number: u64| [number]));
    let study = Ensemble::new(samples, 11, bead).integrate(Dop853, PiController::tolerance(1e-9), 2.0);
    let end = FinalState(|_: &Bead, end: &State<f64, 2>| end.q);
    let outcome = study.in_lanes(Fused).observe(&end, Collect).unwrap();
    assert_eq!((outcome.failures.count, outcome.statistic.rows.len()), (0, 11));
    for (index, found) in outcome.statistic.rows {
        let (bead, start) = bead([index]);
        let alone = integrate(&bead, Dop853, PiController::tolerance(1e-11), start).until(2.0);
        assert!((found - alone.final_state().unwrap().q).amax() < 1e-7, "{index}");
        let steep = 0.2 + 0.1 * index as f64;
        assert!((found[1] - steep * found[0] * found[0]).abs() < 1e-12, "{index}");
    }
}
