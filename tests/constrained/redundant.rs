//! Equilibria where conditions follow from others: multipliers of least norm, guesses beside the constraints,
//! searches over a box.

use lagrange_runtime::analysis::*;
use lagrange_runtime::prelude::*;
use lagrange_runtime::traits::Linearize;
use std::f64::consts::FRAC_PI_2 as RIGHT;
use std::f64::consts::PI;

lagrangian! {
    /// A point on `z = x²`, said twice, with gradients that are parallel everywhere on it; V is `1.5 x² + y² + 0.1 y`
    /// there.
    system Factor {
        coord x, y, z;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2));
        V = 0.5 * x * x + y * y + z + 0.1 * y;
        redundant constraint a: z - x * x == 0;
        redundant constraint b: (2 + x) * (z - x * x) == 0;
    }
}

lagrangian! {
    /// The same, parallel on the constraint alone.
    system Exponent {
        coord x, y, z;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2));
        V = 0.5 * x * x + y * y + z + 0.1 * y;
        redundant constraint a: z - x * x == 0;
        redundant constraint b: exp(z) - exp(x * x) == 0;
    }
}

lagrangian! {
    /// A bob on a rod whose length is held, and its square.
    system Twice {
        coord x, y;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = 9.81 * y;
        redundant constraint rod: x.powi(2) + y.powi(2) == 1;
        redundant constraint same: 2 * hypot(x, y) == 2;
    }
}

lagrangian! {
    /// A rhombus of three links on the ground: three branches that meet where it is flat.
    system Rhombus {
        param g = 9.81;
        coord a, b, c;
        T = dot(a).powi(2) + dot(b).powi(2) + dot(c).powi(2);
        V = g * (sin(a) + sin(c)) + 0.2 * g * sin(b);
        constraint close: [cos(a) + cos(b), sin(a) + sin(b)] == [1 + cos(c), sin(c)];
    }
}

lagrangian! {
    /// Chaplygin's sleigh on a spring; y appears nowhere.
    system Sleigh {
        param m = 1, inertia = 0.2, a = 0.1, k = 1;
        coord x, y, p;
        T = 0.5 * m * ((dot(x) - a * sin(p) * dot(p)).powi(2) + (dot(y) + a * cos(p) * dot(p)).powi(2))
            + 0.5 * inertia * dot(p).powi(2);
        V = 0.5 * k * x * x;
        constraint edge: dot(x) * sin(p) == dot(y) * cos(p);
    }
}

lagrangian! {
    /// A mass on a straight line in space, by three planes.
    system Planes {
        coord x, y, z;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2));
        V = 0.5 * (x - 1).powi(2);
        redundant constraint level: y == 0;
        redundant constraint tilted: x + y == z;
        redundant constraint across: x == z;
    }
}

lagrangian! {
    /// A parallelogram whose coupler is led, too.
    system Led {
        param l = 0.5;
        coord a: angle, b: angle, c: angle;
        T = 0.5 * (dot(a).powi(2) + dot(b).powi(2) + dot(c).powi(2));
        V = 0.5 * (a - 1).powi(2);
        redundant constraint close: [l * cos(a) + cos(b), l * sin(a) + sin(b)] == [1 + l * cos(c), l * sin(c)];
        redundant constraint level: b == 0;
    }
}

/// The equilibria from all guesses have these coordinates and multipliers.
#[track_caller]
fn reached<Sys: Linearize<N, Scalar = f64>, const N: usize, const M: usize>(
    system: &Sys,
    guesses: &[[f64; N]],
    q: [f64; N],
    multipliers: [f64; M],
) {
    for guess in guesses {
        let found = equilibrium(system, guess).unwrap_or_else(|error| panic!("{guess:?}: {error}"));
        assert!((found.q - SVector::from(q)).amax() < 1e-10, "{guess:?}: {}", found.q);
        let off = (found.multipliers.clone() - DVector::from_row_slice(&multipliers)).amax();
        assert!(off < 1e-8, "{guess:?}: {}", found.multipliers);
    }
}

/// `2 ẍ = 1 − x`. What is left of conditions that depend on each other is shared between them, and falls by a part with
/// each correction, down to where it has no digits.
#[test]
fn conditions_that_rounding_contradicts_are_run() {
    let rate = 0.5f64.sqrt();
    let exact = |t: f64| 1.0 - 0.5 * (rate * t).cos() + (rate * t).sin() / rate;
    let start = State::new(0.0, [0.5, 0.0, 0.5], [1.0, 0.0, 1.0]);
    macro_rules! run {
        ($($system:expr)+) => {$(
            for tolerance in [1e-4, 1e-6, 1e-8, 1e-10, 1e-12] {
                let pi = PiController::tolerance(tolerance);
                for end in [
                    integrate(&$system, Dop853, pi, start).until(3.0).final_state().unwrap(),
                    integrate(&$system, Verner9, pi, start).until(3.0).final_state().unwrap(),
                    integrate(&$system, Radau5, pi, start).until(3.0).final_state().unwrap(),
                ] {
                    let off = (end.q - SVector::from([exact(3.0), 0.0, exact(3.0)])).amax();
                    assert!(off < 20.0 * tolerance, "{tolerance:e}: {off:e}");
                }
            }
            let end = integrate(&$system, Rk4, FixedStep::new(0.01), start).until(3.0).final_state().unwrap();
            assert!((end.q[0] - exact(3.0)).abs() < 1e-9);
        )+};
    }
    run! { Planes::new() Led::default() }
}

/// A gradient that falls from e²⁰ to 40 on the way to the constraint does not vanish on it, as that of a square does.
/// A condition is the same in whatever unit.
#[test]
fn constraints_have_any_scale() {
    lagrangian! {
        system Scaled {
            coord x, y;
            T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
            V = 9.81 * y;
            constraint rod: 1e-20 * (x * x + y * y) == 1e-20;
        }
    }
    let at = State::new(0.0, [0.6, -0.8], [0.8, 0.6]);
    // λ n + g with n the normal: q̈ = −9.81 y n·… along the tangent (0.8, 0.6), and −1 along (0.6, −0.8).
    let along = -9.81 * 0.6;
    let exact = [along * 0.8 - 0.6, along * 0.6 + 0.8];
    let found = Scaled::new().accel_at(&at);
    assert!((found[0] - exact[0]).abs().max((found[1] - exact[1]).abs()) < 1e-13, "{found} {exact:?}");
}

/// They hold together at x = 0, and not at every place at which one of them does.
#[test]
fn conditions_that_hold_together_in_some_places_are_run() {
    lagrangian! {
        system Walls {
            coord x, y;
            T = 0.5 * (dot(x).powi(2) + dot(y).powi(2) + dot(x) * dot(y));
            V = 2 * y * y;
            redundant constraint a: sin(x) == 0;
            redundant constraint b: x == 0;
        }
    }
    let start = State::new(0.0, [0.0, 1.0], [0.0, 0.0]);
    let end = integrate(&Walls::new(), Dop853, PiController::tolerance(1e-12), start)
        .until(1.0)
        .final_state()
        .unwrap();
    assert!(end.q[0].abs() < 1e-12 && (end.q[1] - 2f64.cos()).abs() < 1e-10, "{end:?}");
}

#[test]
fn a_steep_constraint_is_none_that_vanishes() {
    lagrangian! {
        system Steep {
            param g = 2;
            coord x, y;
            T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
            V = 2 * g * y;
            constraint steep: exp(40 * (x - y)) == 1;
        }
    }
    let start = State::new(0.0, [0.5, 0.5], [0.0; 2]);
    let steep = Steep::default();
    let run = integrate(&steep, Dop853, PiController::tolerance(1e-10), start);
    assert!((run.until(1.0).final_state().unwrap().q - SVector::from([-0.5, -0.5])).amax() < 1e-10);
}

/// `λ₁ + 2 λ₂ = 1` and `λ₁ + λ₂ = 1` with the least squares; half of the weight each.
#[test]
fn multipliers_are_those_of_least_norm_from_every_guess() {
    let on =
        [[0.1, 0.1, 0.01], [0.05, -0.05, 0.0025], [1e-3, -0.05, 1e-6], [0.0, -0.05, 0.0], [0.3, -0.2, 0.09]];
    let beside = [[0.1, 0.1, 0.0], [0.3, -0.2, 0.2], [1.0, 1.0, 0.0]];
    for guesses in [&on[..], &beside] {
        reached(&Factor::new(), guesses, [0.0, -0.05, 0.0], [0.2, 0.4]);
        reached(&Exponent::new(), guesses, [0.0, -0.05, 0.0], [0.5, 0.5]);
    }
    // Both gradients are 2 (x, y).
    let quarter = -9.81 / 4.0;
    reached(&Twice::new(), &[[0.6, -0.8], [0.1, -1.1], [-0.2, -0.7]], [0.0, -1.0], [quarter, quarter]);
    let found = equilibria(&Exponent::new(), &[-1.0; 3], &[1.0; 3], 30).unwrap();
    assert!(found.len() == 1 && (found[0].q[1] + 0.05).abs() < 1e-10, "{found:?}");
}

/// On `c = a, b = 0` V is `2 g sin a`, on `a = 0, b = c` 1.2 g sin c, and on `c = π, b = a ± π` 0.8 g sin a. Some
/// starts end where it is flat.
#[test]
fn a_search_over_a_box_goes_on_from_starts_that_fail() {
    let all = equilibria(&Rhombus::default(), &[-3.2; 3], &[3.2; 3], 400).unwrap();
    let mut exact = Vec::new();
    for up in [-RIGHT, RIGHT] {
        exact.extend([[up, 0.0, up], [0.0, up, up], [up, -up, PI], [up, -up, -PI]]);
    }
    exact.sort_by(|a, b| a.partial_cmp(b).unwrap());
    for found in &all {
        let nearest =
            exact.iter().map(|exact| (found.q - SVector::from(*exact)).amax()).fold(f64::MAX, f64::min);
        assert!(nearest < 1e-9, "{}", found.q);
    }
    assert_eq!(all.len(), exact.len());
}

#[test]
fn numbers_that_are_none_do_not_pass() {
    let sleigh = Sleigh::default();
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for i in 0..3 {
            let mut at = State::new(0.0, [0.0, 0.0, 0.3], [0.3f64.cos(), 0.3f64.sin(), 0.5]);
            assert!(consistent(&sleigh, &at).is_ok());
            let mut guess = [0.0, 0.0, 0.3];
            guess[i] = bad;
            assert_eq!(equilibrium(&sleigh, &guess).unwrap_err(), AnalysisError::NotFinite);
            assert_eq!(small_vibrations(&sleigh, &guess).unwrap_err(), AnalysisError::NotFinite);
            at.q[i] = bad;
            assert!(matches!(consistent(&sleigh, &at), Err(Failure::NonFinite { .. })), "q {i} {bad}");
            at.q[i] = 0.0;
            at.qd[i] = bad;
            assert!(matches!(consistent(&sleigh, &at), Err(Failure::NonFinite { .. })), "qd {i} {bad}");
        }
    }
}
