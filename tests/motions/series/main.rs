//! Motions by Taylor series.

use lagrange_runtime::prelude::*;
use lagrange_runtime::testing::reference::SimplePendulum;
use lagrange_runtime::traits::Analytic;
use lagrange_runtime::traits::TaylorSeries;
use lagrange_runtime::{DoubleDouble, Gradient, method::taylor::LongTaylor};

mod roots;
mod switches;
#[path = "../../../lagrange-runtime/tests/systems/mod.rs"]
mod systems;

lagrangian! {
    system Pendulum {
        param l, g = 9.81;
        coord theta;
        T = 0.5 * (l * dot(theta)).powi(2);
        V = -g * l * cos(theta);
    }
}

lagrangian! {
    system Kepler {
        param mu;
        coord x, y;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = -mu / (x * x + y * y).sqrt();
    }
}

lagrangian! {
    system DoublePendulum {
        param m: [2], l: [2], g = 9.81;
        coord th: [2];
        let x: [2] = |i| (0..i + 1).map(|j| l[j] * th[j].sin()).sum();
        let y: [2] = |i| -(0..i + 1).map(|j| l[j] * th[j].cos()).sum();
        T = (0..2).map(|i| 0.5 * m[i] * (dot(x[i]).powi(2) + dot(y[i]).powi(2))).sum();
        V = (0..2).map(|i| m[i] * g * y[i]).sum();
    }
}

lagrangian! {
    /// Four links: cheaper by the matrix than by an expanded inverse.
    system Chain {
        const N = 4;
        param l, g = 9.81;
        coord th: [N];
        let x: [N] = |i| (if i == 0 { 0 } else { x[i - 1] }) + l * th[i].sin();
        let y: [N] = |i| (if i == 0 { 0 } else { y[i - 1] }) - l * th[i].cos();
        T = (0..N).map(|i| 0.5 * (dot(x[i]).powi(2) + dot(y[i]).powi(2))).sum();
        V = (0..N).map(|i| g * y[i]).sum();
    }
}

lagrangian! {
    /// A driven, damped motion on which every smooth function of the table acts.
    system Menagerie {
        param k, omega;
        coord x, y;
        coord wall = 0.1 * sin(omega * t);
        let s = x * x + 0.5 * y * y + 1.5;
        T = 0.5 * (2 + sin(x)) * dot(x).powi(2) + 0.5 * s * dot(y).powi(2) + 0.2 * dot(x) * dot(y);
        V = k * (x.tan().exp() + s.ln() + s.ln_1p() + s.log2() + s.log10() + s.sqrt() + s.cbrt() + s.powf(1.7))
            + (0.1 * x).asin() + (0.1 * y).acos() + x.atan() + y.atan2(s) + x.sinh() + y.cosh() + x.tanh() + x.asinh()
            + s.acosh() + (0.1 * y).atanh() + y.exp_m1() + x.exp2() + x.hypot(s) + 1 / (s * s)
            + (x - wall).powi(2) + s.powi(-3) + 2 * y.powi(4);
        D = 0.05 * dot(x).powi(2);
        Q[y] = -0.1 * dot(y).powi(3) + 0.3 * (omega * t).cos();
    }
}

lagrangian! {
    /// Momenta that are no linear functions of the velocities, by every rule.
    system Relativistic {
        const N = 5;
        param c;
        coord x: [N];
        let squares = (0..N).map(|i| dot(x[i]).powi(2)).sum();
        let gamma = (1 - squares / (c * c)).sqrt();
        L = -c * c * gamma + 0.1 * (dot(x[0]) + 0.5 * dot(x[1])).cosh() / (1 + 0.1 * squares)
            + 0.2 * (2 + squares).powf(1.3) - (0..N).map(|i| (1 + i) * x[i].powi(2)).sum()
            + x[2].sin() * dot(x[3]) * (dot(x[4]) * x[0]).sin();
    }
}

lagrangian! {
    system Cartesian {
        param l, g = 9.81;
        coord x, y;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = g * y;
        constraint rod: x * x + y * y == l * l;
    }
}

fn end<Sys: Analytic<N, Scalar = f64>, const N: usize>(
    system: &Sys,
    start: State<f64, N>,
    tolerance: f64,
    until: f64,
) -> State<f64, N> {
    let run = integrate(system, Taylor, TaylorController::tolerance(tolerance), start);
    run.until(until).final_state().unwrap()
}

/// To the rounding of the state at every tolerance.
#[test]
fn pendulum_against_elliptic_functions() {
    let pendulum = Pendulum::new(0.85);
    let exact = SimplePendulum::new(pendulum.g, pendulum.l, 2.9, 0.3);
    for tolerance in [1e-6, 1e-9, 1e-12, 1e-15] {
        let end = end(&pendulum, State::new(0.0, [2.9], [0.3]), tolerance, 30.0);
        let (theta, thetad) = exact.state(30.0);
        let error = (end.q[0] - theta).abs().max((end.qd[0] - thetad).abs());
        assert!(error < 2e3 * tolerance, "{tolerance:e}: {error:e}");
    }
}

/// Released from rest at 90° the coefficients vanish in pairs; at 1e-6 beside it they nearly do.
#[test]
fn lacunary_series_do_not_fool_the_step() {
    let pendulum = Pendulum::new(1.0);
    let right = core::f64::consts::FRAC_PI_2;
    for angle in [right, right + 1e-6, right + 1e-3, -right] {
        for tolerance in [1e-3, 1e-6, 1e-9, 1e-12, 1e-15, f64::EPSILON] {
            let exact = SimplePendulum::new(pendulum.g, pendulum.l, angle, 0.0);
            let end = end(&pendulum, State::new(0.0, [angle], [0.0]), tolerance, 10.0);
            let error = (end.q[0] - exact.state(10.0).0).abs();
            assert!(error < 1e3 * tolerance, "{angle} at {tolerance:e}: {error:e}");
        }
    }
    let double = DoublePendulum::new([1.0, 1.0], [1.0, 1.0]);
    for angles in [[right, right], [right, 0.0], [right, -right], [0.0, right]] {
        let start = State::new(0.0, angles, [0.0; 2]);
        let reference = integrate(&double, Verner9, PiController::tolerance(1e-14), start)
            .until(4.0)
            .final_state()
            .unwrap();
        for tolerance in [1e-6, 1e-9, 1e-12, 1e-15] {
            let error = (end(&double, start, tolerance, 4.0).q - reference.q).amax();
            assert!(error < 1e4 * tolerance + 1e-10, "{angles:?} at {tolerance:e}: {error:e}");
        }
    }
}

#[test]
fn kepler_to_the_last_digits() {
    let kepler = Kepler::new(1.0);
    let start = State::new(0.0, [0.4, 0.0], [0.0, 2.0]);
    let end = end(&kepler, start, f64::EPSILON, 10.0 * core::f64::consts::TAU);
    // At the perihelion two halves of the energy cancel to a fifth, and a change of it by one rounding unit moves the
    // return by 3π · 10 of these.
    assert!((end.q - start.q).amax() < 50.0 * 94.0 * f64::EPSILON, "{end:?}");
}

/// Two expressions of the same motion: series and Runge–Kutta.
fn agrees<Sys: Analytic<N, Scalar = f64>, const N: usize>(
    system: &Sys,
    start: State<f64, N>,
    until: f64,
    bound: f64,
) {
    let series = end(system, start, 1e-15, until);
    let steps =
        integrate(system, Verner9, PiController::tolerance(1e-14), start).until(until).final_state().unwrap();
    assert!((series.q - steps.q).amax() < bound, "{series:?} {steps:?}");
    assert!((series.qd - steps.qd).amax() < bound, "{series:?} {steps:?}");
}

#[test]
fn every_rule_agrees_with_runge_kutta() {
    agrees(&Menagerie::new(0.3, 2.0), State::new(0.0, [0.3, -0.2], [0.5, 0.4]), 3.0, 1e-11);
    let start = State::new(0.0, [0.4, 0.9, -0.3, 0.2, 0.5], [0.1, 0.3, -0.2, 0.1, 0.2]);
    agrees(&Relativistic::new(2.0), start, 3.0, 1e-11);
    agrees(&Chain::new(0.5), State::new(0.0, [0.4, 0.9, -0.3, 0.2], [0.0, 1.0, 0.0, -1.0]), 2.0, 1e-11);
}

/// Coefficients of order 2 and 3 of the velocities, from derivatives of the accelerations by duals.
#[test]
fn coefficients_are_derivatives() {
    let system = Menagerie::new(0.3, 2.0);
    let at = State::new(0.7, [0.3, -0.2], [0.5, 0.4]);
    let series: TaylorSeries<f64, 2, 8> = system.series(&at, 6);
    let a = system.accel(&at.q, &at.qd, at.t);
    let j = system.jacobian(&at.q, &at.qd, at.t);
    let jerk = j.q * at.qd + j.qd * a + j.t;
    for i in 0..2 {
        assert!((series.velocities(1)[i] - a[i]).abs() < 1e-14 * (1.0 + a[i].abs()));
        assert!((series.q[2][i] - a[i] / 2.0).abs() < 1e-14 * (1.0 + a[i].abs()));
        assert!((series.velocities(2)[i] - jerk[i] / 2.0).abs() < 1e-13 * (1.0 + jerk[i].abs()));
    }
}

#[test]
fn constraints_are_kept() {
    let system = Cartesian::new(0.85);
    let exact = SimplePendulum::new(system.g, system.l, 0.0, 3.0);
    let start = State::new(0.0, [0.0, -0.85], [3.0 * 0.85, 0.0]);
    let end = end(&system, start, 1e-14, 20.0);
    let (theta, _) = exact.state(20.0);
    let error = (end.q - SVector::from([0.85 * theta.sin(), -0.85 * theta.cos()])).amax();
    assert!(error < 1e-11, "{error:e}");
}

#[test]
fn the_interpolant_is_the_series() {
    let pendulum = Pendulum::new(0.85);
    let exact = SimplePendulum::new(pendulum.g, pendulum.l, 1.0, 0.0);
    let run = integrate(&pendulum, Taylor, TaylorController::tolerance(1e-14), State::new(0.0, [1.0], [0.0]));
    for state in run.sample((1..200).map(|k| 0.037 * f64::from(k))) {
        let state = state.unwrap();
        assert!((state.q[0] - exact.state(state.t).0).abs() < 1e-12, "{state:?}");
    }
}

lagrangian! {
    system Ball {
        param g = 9.81;
        coord y;
        T = 0.5 * dot(y).powi(2);
        V = g * y;
    }
}

lagrangian! {
    /// A spherical pendulum on a cart that is moved, with friction.
    system Spherical {
        param l, g = 9.81;
        coord theta, phi;
        coord cart = 0.2 * sin(1.7 * t);
        let x = cart + l * theta.sin() * phi.cos();
        let y = l * theta.sin() * phi.sin();
        let z = -l * theta.cos();
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2));
        V = g * z;
        D = 0.05 * dot(theta).powi(2);
        Q[phi] = -0.1 * dot(phi);
    }
}

lagrangian! {
    system Top {
        param a, c, mgl;
        coord theta, phi, psi;
        T = 0.5 * a * (dot(theta).powi(2) + (dot(phi) * sin(theta)).powi(2))
            + 0.5 * c * (dot(psi) + dot(phi) * cos(theta)).powi(2);
        V = mgl * cos(theta);
        routhian Nutation;
    }
}

/// Numbers between 0 and 1, always the same ones.
fn random() -> impl FnMut() -> f64 {
    let mut seed = 1u64;
    move || {
        seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (seed >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// Angles that are multiples of 45°, at rest or not: their symmetries make coefficients vanish.
#[test]
fn symmetric_starts() {
    let eighth = core::f64::consts::FRAC_PI_4;
    let mut random = random();
    let mut angle = |n: f64| ((random() * n) as i32 - (n / 2.0) as i32) as f64 * eighth;
    let double = DoublePendulum::new([1.0, 1.0], [1.0, 1.0]);
    let spherical = Spherical::new(1.0);
    for _ in 0..40 {
        let (q, qd) = ([angle(8.0), angle(8.0)], [angle(3.0), angle(3.0)]);
        for tolerance in [1e-3, 1e-6, 1e-9, 1e-12, 1e-15] {
            let close = |name: &str, q: SVector<f64, 2>, reference: SVector<f64, 2>| {
                let error = (q - reference).amax();
                assert!(error < 1e4 * tolerance + 1e-10, "{name} {q} {qd:?} at {tolerance:e}: {error:e}");
            };
            let start = State::new(0.0, q, qd);
            let reference = integrate(&double, Verner9, PiController::tolerance(1e-14), start)
                .until(1.0)
                .final_state()
                .unwrap();
            close("double", end(&double, start, tolerance, 1.0).q, reference.q);
            // Away from the poles.
            let start = State::new(0.0, [1.5 * eighth + 0.25 * q[0].abs(), q[1]], [qd[0], 2.0]);
            let reference = integrate(&spherical, Verner9, PiController::tolerance(1e-14), start)
                .until(1.0)
                .final_state()
                .unwrap();
            close("spherical", end(&spherical, start, tolerance, 1.0).q, reference.q);
        }
    }
}

/// Prescribed coordinates, dissipation, forces; and a system without its ignorable coordinates.
#[test]
fn driven_and_reduced_systems_agree_with_runge_kutta() {
    agrees(&Spherical::new(0.7), State::new(0.2, [0.9, 0.3], [0.1, 2.0]), 1.5, 1e-11);
    let top = Top::new(1.0, 0.7, 1.3);
    let start = State::new(0.0, [0.6, 0.0, 0.0], [0.1, 0.4, 3.0]);
    agrees(&top, start, 10.0, 1e-11);
    let (reduced, nutation) = top.reduce(&start);
    let whole = end(&top, start, 1e-15, 10.0);
    let alone = end(&reduced, nutation, 1e-15, 10.0);
    assert!((whole.q[0] - alone.q[0]).abs() < 1e-12, "{whole:?} {alone:?}");
}

/// Three pairs of angles, each passed within a moment, in the same long steps as hardly anything else.
#[test]
fn all_pairs_of_roots_in_long_steps_are_found() {
    let mut random = random();
    let pendulum = Pendulum::new(0.85);
    let mut longest: f64 = 0.0;
    for trial in 0..300 {
        let pairs = [0.25, 0.55, 0.85]
            .map(|t| (t + 0.2 * random() - 0.1, Functions::powf(10.0, -1.3 - 5.0 * random())));
        let roots = pairs.map(|(middle, half)| [middle - half, middle + half]).concat();
        // Of time and of the motion.
        let g =
            |s: &State<f64, 1>| roots.iter().map(|root| s.t - root).product::<f64>() * (2.0 + s.q[0].cos());
        let control = TaylorController::tolerance(1e-9);
        let run = || integrate(&pendulum, Taylor, control, State::new(0.0, [1e-3], [0.0])).until(1.2);
        longest = run().map(|step| step.unwrap().h).fold(longest, f64::max);
        let seen: Vec<_> = run().events(Event::either(g)).map(|event| event.unwrap().state.t).collect();
        assert_eq!(seen.len(), 6, "{trial}: {seen:?} of {roots:?}");
        for (seen, root) in seen.iter().zip(&roots) {
            assert!((seen - root).abs() < 1e-12, "{trial}: {seen} {root}");
        }
    }
    // More than one pair in a step.
    assert!(longest > 0.3, "{longest}");
}

/// Free flights are polynomials; the bounces between them restart the series.
#[test]
fn bounces_restart_the_series() {
    let ball = Ball::new();
    let run = integrate(&ball, Taylor, TaylorController::tolerance(1e-12), State::new(0.0, [1.0], [0.0]));
    let mut bounces = run.until(10.0).events(Event::falling(|s| s.q[0]).terminal());
    let fall = Functions::sqrt(2.0 / ball.g);
    for k in 0..8 {
        let hit = bounces.next().unwrap().unwrap().state;
        assert!((hit.t - f64::from(2 * k + 1) * fall).abs() < 1e-13, "{k}: {hit:?}");
        bounces.restart(State { qd: -hit.qd, ..hit });
    }
}

/// Periods that are known to 32 digits: Kepler's third law, and the arithmetic–geometric mean (Gauss) for the pendulum.
#[test]
fn thirty_digits_after_ten_periods() {
    let of = DoubleDouble::from;
    let tolerance = 1e-30;
    fn after<Sys: Analytic<N, Scalar = DoubleDouble>, const N: usize>(
        system: &Sys,
        start: State<DoubleDouble, N>,
        time: DoubleDouble,
    ) -> State<DoubleDouble, N> {
        let control = TaylorController::tolerance(1e-30);
        integrate(system, LongTaylor, control, start).until(time).final_state().unwrap()
    }
    let missed = |end: DoubleDouble, start: DoubleDouble| (end - start).value().abs();

    // Semi-major axis 1: from the perihelion of an ellipse of e = 0.6.
    let kepler = Kepler { mu: of(1.0) };
    let two_fifths = of(2.0) / 5.0;
    let start = State::new(of(0.0), [two_fifths, of(0.0)], [of(0.0), of(2.0)]);
    let end = after(&kepler, start, DoubleDouble::PI * 20.0);
    for i in 0..2 {
        assert!(missed(end.q[i], start.q[i]) < 3e3 * tolerance, "{end:?}");
    }

    let pendulum = Pendulum { l: of(0.85), g: of(9.81) };
    let start = State::new(of(0.0), [of(2.0)], [of(0.0)]);
    let (mut a, mut b) = (of(1.0), of(1.0).cos());
    for _ in 0..8 {
        (a, b) = ((a + b) * 0.5, (a * b).sqrt());
    }
    let period = DoubleDouble::PI * 2.0 / ((pendulum.g / pendulum.l).sqrt() * a);
    let end = after(&pendulum, start, period * 10.0);
    assert!(missed(end.q[0], start.q[0]) < 1e3 * tolerance, "{end:?}");
    assert!(missed(end.qd[0], start.qd[0]) < 1e4 * tolerance, "{end:?}");
}

lagrangian! {
    /// Numbers that are no sums of few powers of 2 in all places.
    system Decimals {
        coord x, y;
        T = 0.85 * dot(x).powi(2) + dot(y).powi(2) / 6;
        V = 0.3 * x.powi(3) / 7 + PI * y + 0.123456789 * 0.987654321 * 0.192837465 * y.powi(2) + x.log10() + y.exp2();
    }
}

/// Constants have all digits that the scalar has, however they were multiplied.
#[test]
fn constants_have_thirty_digits() {
    let of = DoubleDouble::from;
    let [x, y] = [of(1.0) / 3.0, of(1.0) / 7.0];
    let accel = Decimals::<DoubleDouble>::default().accel(&[x, y].into(), &[of(0.0); 2].into(), of(0.0));
    let ln = |number: f64| of(number).ln();
    let by_x = x * x * 9.0 / 70.0 + of(1.0) / (x * ln(10.0));
    let product = of(123_456_789.0) * 987_654_321.0 * 192_837_465.0 / 1e9 / 1e9 / 1e9;
    let by_y = DoubleDouble::PI + product * y * 2.0 + ln(2.0) * y.exp2();
    for (accel, exact) in [(accel[0], -by_x * 10.0 / 17.0), (accel[1], -by_y * 3.0)] {
        assert!((accel / exact - of(1.0)).value().abs() < 1e-30, "{accel:?} {exact:?}");
    }
}

lagrangian! {
    /// A chain whose numbers are multiplied otherwise in its series than in its accelerations.
    system Crane {
        const N = 3;
        coord th: [N];
        let m = [0.7, 1.3, 0.4];
        let l = [0.85, 0.6, 1.1];
        let x: [N] = |i| (if i == 0 { 0 } else { x[i - 1] }) + l[i] * th[i].sin();
        let y: [N] = |i| (if i == 0 { 0 } else { y[i - 1] }) - l[i] * th[i].cos();
        T = (0..N).map(|i| 0.5 * m[i] * (dot(x[i]).powi(2) + dot(y[i]).powi(2))).sum();
        V = (0..N).map(|i| 9.81 * m[i] * y[i]).sum();
    }
}

/// If series and accelerations differed in the 17th digit of a constant, the check of a step would shorten it without
/// end.
#[test]
fn series_and_accelerations_have_the_same_constants() {
    let of = DoubleDouble::from;
    let crane = Crane::<DoubleDouble>::default();
    let start = State::new(of(0.0), [of(0.5), of(-0.3), of(0.9)], [of(0.0); 3]);
    let control = TaylorController::tolerance(1e-30);
    let run = integrate(&crane, LongTaylor, control, start).until(of(1.0));
    let end = run.max_steps(100).final_state().unwrap();
    let strayed = crane.energy_at(&end) / crane.energy_at(&start) - of(1.0);
    assert!(strayed.value().abs() < 1e-28, "{strayed:?}");
}

/// The end of a motion and all its derivatives by the start and by a parameter, from one run.
#[test]
fn gradients_are_those_of_closed_forms() {
    // After a period T of Kepler's motion all comes back, but for the period, T = 2π a^(3/2)/√μ: a start x on another
    // orbit is at its place T(x) later, so that ∂(q, q̇)(T)/∂x = 1 − (q̇, q̈) ∂T/∂x, with 1/a = 2/r − v²/μ.
    let (q, qd) = ([0.4, 0.0], [0.0, 2.0]);
    let [x, y, xd, yd, mu] = Gradient::variables([q[0], q[1], qd[0], qd[1], 1.0]);
    let start = State::new(Gradient::constant(0.0), [x, y], [xd, yd]);
    let kepler = Kepler { mu };
    let run = integrate(&kepler, Taylor, TaylorController::tolerance(1e-16), start);
    let end = run.until(Gradient::constant(core::f64::consts::TAU)).final_state().unwrap();
    let force = [-1.0 / (q[0] * q[0]), 0.0];
    // ∂T/∂(x, y, ẋ, ẏ, μ) = 2π (3/2 ∂a − 1/2 ∂μ) at a = μ = 1, ∂a = −a² ∂(1/a).
    let by_a = 3.0 * core::f64::consts::PI;
    let period = [
        by_a * 2.0 / (q[0] * q[0]),
        0.0,
        0.0,
        by_a * 2.0 * qd[1],
        -by_a * qd[1] * qd[1] - core::f64::consts::PI,
    ];
    for (d, period) in period.into_iter().enumerate() {
        for i in 0..2 {
            let unit = |at: usize| f64::from(u8::from(d == at));
            let error = end.q[i].slopes[d] - (unit(i) - qd[i] * period);
            assert!(error.abs() < 2e-11, "q{i} by {d}: {error:e}");
            let error = end.qd[i].slopes[d] - (unit(2 + i) - force[i] * period);
            assert!(error.abs() < 2e-11, "q̇{i} by {d}: {error:e}");
        }
    }
}

#[test]
fn gradients_are_those_of_the_variational_equations() {
    let double = DoublePendulum::new([1.0, 0.5], [1.0, 0.7]);
    let start = State::new(0.0, [1.2, -0.4], [0.3, 0.5]);
    let flow = lagrange_runtime::analysis::ByVariationalEquations::<_, 10>::new(&double, 1e-13);
    let (_, matrix) = lagrange_runtime::analysis::fundamental_matrix(&flow, &start, 3.0).unwrap();
    let [a, b, ad, bd] = Gradient::variables([1.2, -0.4, 0.3, 0.5]);
    let start = State::new(Gradient::constant(0.0), [a, b], [ad, bd]);
    let system = double.map(Gradient::constant);
    let run = integrate(&system, Taylor, TaylorController::tolerance(1e-15), start);
    let end = run.until(Gradient::constant(3.0)).final_state().unwrap();
    for d in 0..4 {
        for i in 0..2 {
            for (row, slope) in [(i, end.q[i].slopes[d]), (2 + i, end.qd[i].slopes[d])] {
                let error = (slope - matrix[(row, d)]).abs() / matrix.amax();
                assert!(error < 1e-11, "{row} {d}: {error:e}");
            }
        }
    }
}

/// With sizes that follow the state smoothly this pendulum meets a few dozen states from then on, turn by turn.
#[test]
fn steps_do_not_fall_into_step_with_a_period() {
    let pendulum = Pendulum { l: 1.0, g: 1.0 };
    let start = State::new(0.0, [1.0 + 25.0 / 32.0], [0.1]);
    let run = integrate(&pendulum, Taylor::of_order(20), TaylorController::tolerance(1e-21), start);
    let (mut steps, mut states) = (0, std::collections::BTreeSet::new());
    for step in run.until(14_000.0).filter(|step| step.as_ref().is_ok_and(|step| step.to.t > 10_000.0)) {
        steps += 1;
        states.insert((step.unwrap().to.q[0] * 1e8) as i64);
    }
    assert!(steps > 5000 && 10 * states.len() > 9 * steps, "{} of {steps}", states.len());
}

/// An estimate below rounding is rounding, and no reason to repeat the step.
#[test]
fn tolerances_below_rounding_reject_nothing() {
    for tolerance in [1e-16, 1e-18, 1e-21] {
        let (system, start) = (Top::new(1.0, 0.7, 1.3), State::new(0.0, [0.6, 0.0, 0.0], [0.1, 0.4, 3.0]));
        let control = TaylorController::tolerance(tolerance);
        let mut run = integrate(&system, Taylor, control, start).until(300.0);
        run.run_to_end().unwrap();
        let statistics = run.statistics();
        assert!(50 * statistics.rejected < statistics.accepted, "{tolerance:e}: {statistics:?}");
        let energy = |at: &State<f64, 3>| system.energy(&at.q, &at.qd, at.t);
        assert!((energy(run.state()) / energy(&start) - 1.0).abs() < 1e-14, "{tolerance:e}");
    }
}

/// Energy errors over n periods of several starts, with truncation far below rounding: their root mean square grows
/// like √n, as that of a random walk, not like n.
#[test]
#[ignore = "takes half a minute in release"]
fn energy_errors_grow_like_a_random_walk() {
    // Far below rounding, so that truncation plays no part.
    const TOLERANCE: f64 = 1e-21;
    fn walk<Sys: Analytic<N, Scalar = f64> + lagrange_runtime::Energies<N>, const N: usize>(
        name: &str,
        system: &Sys,
        starts: impl Fn(f64) -> State<f64, N>,
        period: f64,
    ) {
        let periods = [1e2, 1e3, 1e4, 1e5];
        let mut squares = [0.0; 4];
        let all = 4;
        for n in 0..all {
            let start = starts(f64::from(n) / f64::from(all));
            let energy = |s: &State<f64, N>| system.energy(&s.q, &s.qd, s.t);
            let control = TaylorController::tolerance(TOLERANCE);
            let mut run = integrate(system, Taylor, control, start).max_steps(u64::MAX);
            for (square, n) in squares.iter_mut().zip(periods) {
                run = run.until(n * period);
                run.run_to_end().unwrap();
                let error = energy(run.state()) / energy(&start) - 1.0;
                *square += error * error / f64::from(all);
            }
        }
        let errors = squares.map(f64::sqrt);
        println!("{name}: {errors:?}");
        let points = periods.into_iter().zip(errors).map(|(n, error)| (1.0 / n, error));
        let exponent = -lagrange_runtime::testing::slope(points, 0.0);
        assert!(exponent < 0.75, "{name}: {exponent} {errors:?}");
    }
    walk("pendulum", &Pendulum::new(0.85), |x| State::new(0.0, [1.0 + x], [0.1]), 2.2);
    walk("Kepler", &Kepler::new(1.0), |x| State::new(0.0, [0.4 + 0.1 * x, 0.0], [0.0, 1.9]), 6.3);
    walk("top", &Top::new(1.0, 0.7, 1.3), |x| State::new(0.0, [0.6 + x, 0.0, 0.0], [0.1, 0.4, 3.0]), 3.0);
}

lagrangian! {
    /// A heavy body with three different moments, by Euler's angles: a series of its matrix, or of its momenta.
    system Body {
        param mgl, a, b, c;
        coord phi, theta, psi;
        let w1 = dot(phi) * sin(theta) * sin(psi) + dot(theta) * cos(psi);
        let w2 = dot(phi) * sin(theta) * cos(psi) - dot(theta) * sin(psi);
        let w3 = dot(psi) + dot(phi) * cos(theta);
        T = 0.5 * (a * w1.powi(2) + b * w2.powi(2) + c * w3.powi(2));
        V = mgl * cos(theta);
    }
}

/// Near the pole M is nearly singular: its pivots are small differences of large terms, and so is
/// the sum of φ̈ and ψ̈. Explicit
/// methods have energies within 1.1e-9 here; with pivots by numbers series are off by 7e-6, in six times as many
/// steps.
#[test]
fn series_near_a_pole_are_as_good_as_accelerations() {
    let body = Body::new(1.0, 1.0, 1.5, 0.7);
    for k in 1..=6 {
        let theta = 1.37 * 10f64.powi(-k);
        let at = State::new(0.0, [0.3, theta, 0.2], [0.4, 0.9, 1.23456789 - 0.4 * theta.cos()]);
        let exact = {
            let (body, at) = (body.map(DoubleDouble::from), at.map(DoubleDouble::from));
            body.accel(&at.q, &at.qd, at.t)
        };
        let first = body.series::<3>(&at, 3).velocities(1);
        let error = |i: usize| ((first[i] - exact[i].value()) / exact[i].value()).abs();
        assert!([0, 1, 2].into_iter().all(|i| error(i) < 1e-15 / theta), "{k}");
        let spin = |a: [DoubleDouble; 3]| (a[0] * DoubleDouble::from(theta).cos() + a[2]).value();
        let (found, spin) = (spin(first.map(DoubleDouble::from)), spin(exact.into()));
        // The rounding of φ̈.
        assert!((found - spin).abs() < 4e-16 * (1.0 + first[0].abs()), "{k}: {found} {spin}");

        // φ̇ sin θ = 1 at the smallest θ.
        let phid = 1.0 / theta.sin();
        let nearest = State::new(0.0, [0.3, theta, 0.2], [phid, 0.0, 1.23456789 - phid * theta.cos()]);
        let back = integrate(&body, Verner9, PiController::tolerance(1e-13), nearest)
            .until(-0.5)
            .final_state()
            .unwrap();
        let mut run = integrate(&body, Taylor, TaylorController::tolerance(1e-9), back).until(0.5);
        run.run_to_end().unwrap();
        let drift = (body.energy_at(run.state()) - body.energy_at(&back)).abs();
        assert!(drift < 2e-9, "{k}: {drift:e}");
        assert!(run.statistics().accepted < 100, "{k}: {:?}", run.statistics());
    }
}

/// A top that passes its pole at a distance of θ, by momenta which are small differences of large numbers there.
#[test]
fn momenta_are_kept_near_a_pole() {
    let top = Top::new(1.0, 0.7, 1.3);
    for k in 1..=6 {
        let theta = 10f64.powi(-k);
        let nearest = State::new(0.0, [theta, 0.2, 0.1], [0.0, 1.0 / theta, 3.0 - theta.cos() / theta]);
        let run = integrate(&top, Taylor::of_order(20), TaylorController::tolerance(1e-9), nearest);
        let end = run.until(5.0).final_state().unwrap();
        let drift = (top.energy_at(&end) / top.energy_at(&nearest) - 1.0).abs();
        assert!(drift < 5e-10, "{k}: {drift:e}");
        let momenta = |at: &State<f64, 3>| top.momenta(&at.q, &at.qd, at.t);
        let drift = (momenta(&end) - momenta(&nearest)).rows(1, 2).amax();
        assert!(drift < 1e-9, "{k}: {drift:e}");
    }
}

/// The order is that of the controller's tolerance, in every run, and the highest where there is none.
#[test]
fn the_tolerance_chooses_the_order() {
    let (pendulum, start) = (Pendulum::new(1.0), State::new(0.0, [2.0], [0.0]));
    for (tolerance, order) in [(1e-4, 12), (1e-8, 17), (1e-12, 20), (1e-15, 20)] {
        let control = TaylorController::tolerance(tolerance);
        let end =
            |method: Taylor| integrate(&pendulum, method, control, start).until(5.0).final_state().unwrap();
        assert_eq!(end(Taylor), end(Taylor::of_order(order)), "{tolerance:e}");
        let mut stepper = Stepper::new(pendulum, Taylor, control, start);
        stepper.advance_to(5.0).unwrap();
        assert_eq!(*stepper.state(), end(Taylor::of_order(order)), "{tolerance:e}");
    }
    // An absolute tolerance alone, and steps of one size.
    let absolute = TaylorController::tolerance(1e-8).rtol(0.0);
    let end =
        |method: Taylor| integrate(&pendulum, method, absolute, start).until(5.0).final_state().unwrap();
    assert_eq!(end(Taylor), end(Taylor::of_order(20)));
    let end = |method: Taylor| {
        integrate(&pendulum, method, FixedStep::new(0.1), start).until(5.0).final_state().unwrap()
    };
    assert_eq!(end(Taylor), end(Taylor::of_order(20)));
    // A step by hand.
    let memory = Taylor.start(&pendulum, &start).unwrap();
    let (step, _) = Taylor.step(&pendulum, &memory, &start, 0.1).unwrap();
    assert!((step.to.q[0] - end(Taylor).q[0]).abs() > 1e-3 && step.to.q[0] < 2.0);
}
