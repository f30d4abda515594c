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

/// `2 ẍ = 1 − x`. Dependent conditions share their residual, and each correction reduces it by a part, down to
/// rounding.
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
#[cfg_attr(not(feature = "long"), ignore = "long")]
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

macro_rules! scissors_lift {
    ($name:ident, $stages:literal, $last:ident, $other:ident) => {
        lagrangian! {
            /// A scissors lift: bars a and b of each stage are pinned in the middle, x is the foot that slides.
            pub system $name {
                const N = $stages;
                param L, m, I, W, foot, g = 9.81;
                coord a: [N], b: [N], x;
                let px: [N] = |i| if i == 0 { 0 } else { px[i - 1] + L * cos(if i % 2 == 1 { a[i - 1] } else { b[i - 1] }) };
                let py: [N] = |i| if i == 0 { 0 } else { py[i - 1] + L * sin(if i % 2 == 1 { a[i - 1] } else { b[i - 1] }) };
                let qx: [N] = |i| if i == 0 { x } else { qx[i - 1] + L * cos(if i % 2 == 1 { b[i - 1] } else { a[i - 1] }) };
                let qy: [N] = |i| if i == 0 { 0 } else { qy[i - 1] + L * sin(if i % 2 == 1 { b[i - 1] } else { a[i - 1] }) };
                let pin_px: [N] = |i| px[i] + 0.5 * L * cos(if i % 2 == 0 { a[i] } else { b[i] });
                let pin_py: [N] = |i| py[i] + 0.5 * L * sin(if i % 2 == 0 { a[i] } else { b[i] });
                let pin_qx: [N] = |i| qx[i] + 0.5 * L * cos(if i % 2 == 0 { b[i] } else { a[i] });
                let pin_qy: [N] = |i| qy[i] + 0.5 * L * sin(if i % 2 == 0 { b[i] } else { a[i] });
                let top = py[N - 1] + L * sin($last[N - 1]);
                T = 0.5 * m * (0..N).map(|i| dot(pin_px[i]).powi(2) + dot(pin_py[i]).powi(2) + dot(pin_qx[i]).powi(2) + dot(pin_qy[i]).powi(2)).sum()
                    + 0.5 * I * (0..N).map(|i| dot(a[i]).powi(2) + dot(b[i]).powi(2)).sum()
                    + 0.5 * W * dot(top).powi(2) + 0.5 * foot * dot(x).powi(2);
                V = g * m * (0..N).map(|i| pin_py[i] + pin_qy[i]).sum() + g * W * top;
                redundant constraint across: [N] = |i| pin_px[i] == pin_qx[i];
                redundant constraint along: [N] = |i| pin_py[i] == pin_qy[i];
                redundant constraint level: top == qy[N - 1] + L * sin($other[N - 1]);
            }
        }
    };
}
scissors_lift!(ThreeStages, 3, a, b);
scissors_lift!(SixStages, 6, b, a);

lagrangian! {
    /// Two stages by four conditions, none of which follows from the others.
    pub system TwoStages {
        param L, m, I, g = 9.81;
        coord a: [2], b: [2], x;
        let feet = [[0, 0], [x, 0], [x + L * cos(b[0]), L * sin(b[0])], [L * cos(a[0]), L * sin(a[0])]];
        let angles = [a[0], b[0], a[1], b[1]];
        let pins: [4] = |i| [feet[i][0] + 0.5 * L * cos(angles[i]), feet[i][1] + 0.5 * L * sin(angles[i])];
        T = 0.5 * m * pins.map(|p| dot(p).norm_squared()).sum() + 0.5 * I * angles.map(|a| dot(a).powi(2)).sum();
        V = m * g * pins.map(|p| p[1]).sum();
        constraint lower: pins[0] == pins[1];
        constraint upper: pins[2] == pins[3];
    }
}

/// Angular acceleration of a lift by its one angle φ, with `x = L cos φ` and L = 1, by Lagrange's equation.
fn lifted([m, i, load, foot]: [f64; 4], stages: usize, [angle, rate]: [f64; 2]) -> f64 {
    let (s, c) = angle.sin_cos();
    let n = stages as f64;
    let (mut across, mut up, mut weight) = (foot, load * n * n, n * load);
    for k in 0..stages {
        let height = k as f64 + 0.5;
        (across, up, weight) = (across + 0.5 * m, up + 2.0 * m * height * height, weight + 2.0 * m * height);
    }
    let inertia = 2.0 * n * i + across * s * s + up * c * c;
    -((across - up) * s * c * rate * rate + 9.81 * weight * c) / inertia
}

/// Both bars of each stage may lie on each other, too: x = 0, and all stages turn freely. There fewer conditions are
/// independent, and a search of the compiler from arbitrary places finds that assembly first, or that alone.
#[test]
fn a_lift_is_not_the_assembly_in_which_its_bars_lie_on_each_other() {
    let masses = [0.5, 0.04, 2.0, 0.3];
    macro_rules! lift {
        ($lift:expr, $stages:literal, $masses:expr) => {
            let lift = $lift;
            const SIZE: usize = 2 * $stages + 1;
            let place = |[angle, rate]: [f64; 2]| {
                let (mut q, mut qd) = ([0.0; SIZE], [0.0; SIZE]);
                for i in 0..$stages {
                    (q[i], q[$stages + i], qd[i], qd[$stages + i]) = (angle, PI - angle, rate, -rate);
                }
                (q[SIZE - 1], qd[SIZE - 1]) = (angle.cos(), -angle.sin() * rate);
                State::new(0.0, q, qd)
            };
            for at in [[1.0, 0.3], [0.5, 4.0], [1.4, -2.0], [1.5, 1.0]] {
                let (found, exact) = (lift.accel_at(&place(at)), lifted($masses, $stages, at));
                let off = (0..2 * $stages).map(|i| (found[i].abs() - exact.abs()).abs()).fold(0.0, f64::max);
                assert!(off < 1e-9, "{} {at:?}: {} for {exact}", $stages, found[0]);
            }
            // By the classical method in one coordinate.
            let (mut at, h) = ([1.0, 0.5], 1e-4);
            for _ in 0..4000 {
                let rates = |at: [f64; 2]| [at[1], lifted($masses, $stages, at)];
                let after = |k: [f64; 2], h: f64| [at[0] + h * k[0], at[1] + h * k[1]];
                let a = rates(at);
                let b = rates(after(a, 0.5 * h));
                let c = rates(after(b, 0.5 * h));
                let d = rates(after(c, h));
                at = [0, 1].map(|i| at[i] + h / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]));
            }
            let run = integrate(&lift, Dop853, PiController::tolerance(1e-10), place([1.0, 0.5]));
            let end = run.until(0.4).final_state().unwrap();
            assert!((end.q - place(at).q).amax() < 1e-8, "{}: {} for {at:?}", $stages, end.q);
        };
    }
    {
        assert_eq!(TwoStages::<f64>::FACTS.redundancy, None);
        lift!(TwoStages::new(1.0, 0.5, 0.04), 2, [0.5, 0.04, 0.0, 0.0]);
    }
    {
        assert_eq!(ThreeStages::<f64>::FACTS.redundancy.and_then(|redundancy| redundancy.rank), Some(6));
        lift!(ThreeStages::new(1.0, 0.5, 0.04, 2.0, 0.3), 3, masses);
    }
    {
        lift!(SixStages::new(1.0, 0.5, 0.04, 2.0, 0.3), 6, masses);
    }
}

lagrangian! {
    /// Peaucellier's linkage by the ends of its seven rods, which leave one motion: D is on a straight line. Where A
    /// and B are one, they leave two.
    pub system Peaucellier {
        param L = 1.3, s = 0.5, q = 0.45, m = 1, g = 9.81;
        coord A: [2], B: [2], C: [2], D: [2];
        T = 0.5 * m * (dot(A).norm_squared() + dot(B).norm_squared() + dot(C).norm_squared() + 2 * dot(D).norm_squared());
        V = m * g * (A[0] + B[0] + C[0] + 2 * D[0] + 0.3 * D[1]);
        constraint crank: (C[0] - q).powi(2) + C[1].powi(2) == q * q;
        constraint long: [A.norm_squared(), B.norm_squared()] == [L * L, L * L];
        constraint to_a: [(A - C).norm_squared(), (A - D).norm_squared()] == [s * s, s * s];
        constraint to_b: [(B - C).norm_squared(), (B - D).norm_squared()] == [s * s, s * s];
    }
}

/// `|OC| |OD| = L² − s²`: D is at `x = (L² − s²)/2q` always.
#[test]
fn a_straight_line_by_rods() {
    assert_eq!(Peaucellier::<f64>::FACTS.redundancy, None);
    let linkage = Peaucellier::new();
    let place = |angle: f64| {
        let c = [0.45 + 0.45 * angle.cos(), 0.45 * angle.sin()];
        let square = c[0] * c[0] + c[1] * c[1];
        let (far, distance) = ((1.69 - 0.25) / square, square.sqrt());
        let middle = 0.5 * (1.0 + far);
        let aside = (1.69 - middle * middle * square).sqrt() / distance;
        let [along, across] = [[c[0] * middle, c[1] * middle], [-c[1] * aside, c[0] * aside]];
        let [a, b] = [1.0, -1.0].map(|side| [0, 1].map(|i| along[i] + side * across[i]));
        [a[0], a[1], b[0], b[1], c[0], c[1], c[0] * far, c[1] * far]
    };
    for angle in [0.4, 0.8, -0.6] {
        let h = 1e-4;
        let [low, high] = [-h, h].map(|h| place(angle + h));
        let rates = std::array::from_fn(|i| (high[i] - low[i]) / (2.0 * h));
        let at = consistent(&linkage, &State::new(0.0, place(angle), rates)).unwrap();
        let found = linkage.accel_at(&at);
        assert!(found[6].abs() < 1e-6 && found.amax() > 0.01, "{angle}: {found}");
        let end = integrate(&linkage, Dop853, PiController::tolerance(1e-9), at).until(0.05).final_state();
        let end = end.unwrap();
        assert!((end.q[6] - 1.44 / 0.9).abs() < 1e-9 && (end.q[7] - at.q[7]).abs() > 1e-3, "{}", end.q);
    }
}

lagrangian! {
    /// A line and a plane that cross: on the line two conditions are independent, on the plane one, at the crossing
    /// none.
    pub system Cross {
        coord x, y, z;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2));
        V = 0.5 * x * x + y * y + 1.5 * z * z;
        redundant constraint c: [x * y, x * z] == [0, 0];
    }
}

#[test]
fn small_motions_at_a_crossing_of_branches_are_refused() {
    let found = small_vibrations(&Cross::new(), &[0.0; 3]);
    assert!(matches!(found, Err(AnalysisError::DependentConstraints { .. })), "{found:?}");
}
