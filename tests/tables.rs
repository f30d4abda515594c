//! Tables as arrays of parameters: data that are given with the system's value, against closed forms.

use lagrange_runtime::prelude::*;
use lagrange_runtime::traits::InputJacobian;

lagrangian! {
    /// A body in a measured wind, whose values are a second apart or so, linear in between and constant beyond the
    /// ends.
    system Gust {
        const N = 5;
        param m, c, dt, wind: [N];
        coord x;
        let now = wind[0] + (0..N - 1).map(|k| (wind[k + 1] - wind[k]) * ((t - k * dt) / dt).clamp(0, 1)).sum();
        T = 0.5 * m * dot(x).powi(2);
        V = 0;
        Q[x] = c * (now - dot(x));
        observe wind_now = now;
    }
}

lagrangian! {
    /// A potential by its values and slopes at knots: cubic Hermite pieces.
    system Well {
        const N = 5;
        param h, left, v: [N], slope: [N];
        coord x;
        fn piece(s, from, to, a, b) = (to - from) * s * s * (3 - 2 * s) + h * s * (1 - s) * (a * (1 - s) - b * s);
        T = 0.5 * dot(x).powi(2);
        V = v[0]
            + (0..N - 1).map(|k| piece(((x - left) / h - k).clamp(0, 1), v[k], v[k + 1], slope[k], slope[k + 1])).sum();
    }
}

lagrangian! {
    /// A motor map, torque by speed and throttle, bilinear between its knots.
    system Mapped {
        const N = 4;
        const M = 3;
        param inertia, speeds, throttles, map: [N * M];
        input throttle;
        coord phi;
        fn hat(s) = max(0, 1 - abs(s));
        T = 0.5 * inertia * dot(phi).powi(2);
        V = 0;
        Q[phi] = (0..N).map(|i| (0..M).map(|j| map[i * M + j] * hat(dot(phi) / speeds - i) * hat(throttle / throttles - j)).sum()).sum();
    }
}

const WIND: [f64; 5] = [1.0, 4.0, 2.5, -3.0, 0.5];

/// Speed of the body after `t`, from rest: m v̇ = c (w − v) solved on each piece of w.
fn speed(t: f64, m: f64, c: f64, dt: f64) -> f64 {
    let (mut v, rate) = (0.0, c / m);
    for k in 0.. {
        let from = k as f64 * dt;
        let length = if k < 4 { (t - from).min(dt) } else { t - from };
        if length <= 0.0 {
            return v;
        }
        let (a, b) = if k < 4 { (WIND[k], (WIND[k + 1] - WIND[k]) / dt) } else { (WIND[4], 0.0) };
        v = (v - a + b / rate) * (-rate * length).exp() + a + b * length - b / rate;
        if k == 4 {
            return v;
        }
    }
    v
}

/// Adaptive steps end at the knots, where the slope jumps, and keep the order of the method; series begin anew there.
#[test]
fn measured_wind() {
    let gust = Gust::new(2.0, 0.7, 0.8, WIND);
    let start = State::new(0.0, [0.0], [0.0]);
    for t in [0.5, 0.8, 2.9, 6.0] {
        let exact = speed(t, 2.0, 0.7, 0.8);
        let end =
            integrate(&gust, Dop853, PiController::tolerance(1e-12), start).until(t).final_state().unwrap();
        assert!((end.qd[0] - exact).abs() < 1e-12, "{t}: {} {exact}", end.qd[0]);
        let taylor = integrate(&gust, Taylor::of_order(18), TaylorController::tolerance(1e-14), start);
        assert!((taylor.until(t).final_state().unwrap().qd[0] - exact).abs() < 4e-15);
    }
    let now = |t: f64| gust.wind_now(&start.q, &start.qd, t);
    assert_eq!([now(-1.0), now(0.0), now(9.0)], [1.0, 1.0, 0.5]);
    assert!((now(1.2) - 3.25).abs() < 1e-15);
}

/// The derivative of a trajectory by one value of the table, against the closed form, which is linear in the values.
#[test]
fn derivatives_by_values_of_the_table() {
    let mut gust = Gust::new(2.0, 0.7, 0.8, WIND).map(Dual::constant);
    gust.wind[2].slope = 1.0;
    let start = State::new(0.0, [0.0], [0.0]).map(Dual::constant);
    let run = integrate(&gust, Dop853, PiController::tolerance(1e-12), start);
    let end = run.until(Dual::constant(2.4)).final_state().unwrap();
    // Response to a hat of height 1 at 1.6, half a width of 0.8: slopes 1/0.8 and −1/0.8.
    let rate = 0.35f64;
    let b = 1.0 / 0.8;
    let decay = (-rate * 0.8).exp();
    let at_top = b / rate * decay + b * 0.8 - b / rate;
    let exact = (at_top - 1.0 - b / rate) * decay + 1.0 - b * 0.8 + b / rate;
    assert!((end.qd[0].slope - exact).abs() < 1e-12, "{} {exact}", end.qd[0].slope);
}

/// Values and slopes of a cubic give the cubic.
#[test]
fn a_table_of_a_cubic_is_the_cubic() {
    let p = |x: f64| x.powi(3) / 3.0 - 0.5 * x * x - x + 2.0;
    let slope = |x: f64| x * x - x - 1.0;
    let knots: [f64; 5] = std::array::from_fn(|k| -1.5 + k as f64);
    let well = Well::new(1.0, -1.5, knots.map(p), knots.map(slope));
    for k in 0..40 {
        let x = -1.45 + 0.09 * k as f64;
        let (q, still) = (SVector::from([x]), SVector::from([0.0]));
        assert!((well.potential(&q, 0.0) - p(x)).abs() < 4e-14, "{x}");
        assert!((well.accel(&q, &still, 0.0)[0] + slope(x)).abs() < 4e-14, "{x}");
        assert!((well.jacobian(&q, &still, 0.0).q[(0, 0)] + 2.0 * x - 1.0).abs() < 1e-13, "{x}");
    }
    // Across knots the energy is kept.
    let start = State::new(0.0, [1.618], [0.9]);
    let end =
        integrate(&well, Dop853, PiController::tolerance(1e-12), start).until(20.0).final_state().unwrap();
    assert!((well.energy_at(&end) - well.energy_at(&start)).abs() < 1e-10);
}

/// A bilinear map reproduces a + b ω + c u + d ω u, with its derivatives.
#[test]
fn a_motor_map_in_two_variables() {
    let torque = |w: f64, u: f64| 3.0 - 0.02 * w + 5.0 * u - 0.03 * w * u;
    let map = std::array::from_fn(|k| torque(50.0 * (k / 3) as f64, 0.5 * (k % 3) as f64));
    let mut motor = Mapped::new(0.1, 50.0, 0.5, map);
    for (w, u) in [(10.0, 0.2), (75.0, 0.9), (149.0, 0.5), (120.0, 0.01)] {
        motor.throttle = u;
        let (q, qd) = (SVector::from([0.3]), SVector::from([w]));
        assert!((motor.accel(&q, &qd, 0.0)[0] - 10.0 * torque(w, u)).abs() < 1e-12, "{w} {u}");
    }
    let at = SVector::from([75.0]);
    motor.throttle = 0.3;
    assert!((motor.jacobian(&at, &at, 0.0).qd[(0, 0)] - 10.0 * (-0.02 - 0.03 * 0.3)).abs() < 1e-13);
    assert!((motor.input_jacobian(&at, &at, 0.0)[(0, 0)] - 10.0 * (5.0 - 0.03 * 75.0)).abs() < 1e-11);
}

#[test]
fn tables_are_saved_with_the_system() {
    let gust = Gust::new(2.0, 0.7, 0.8, WIND);
    let again: Gust = serde_json::from_str(&serde_json::to_string(&gust).unwrap()).unwrap();
    assert_eq!(gust, again);
}

/// Knots and values in any units have the curve of other units, or an error that says so.
#[test]
fn tables_in_extreme_units() {
    use lagrange_runtime::traits::{ExternFunction, InvalidTable};
    let (x, y) = ([0.0, 1.0, 2.5, 3.0, 4.0, 6.0], [1.0, -2.0, 0.5, 3.0, 2.0, 2.5]);
    let mut refused = 0;
    for (e, f) in (-30..=30).flat_map(|e| (-30..=30).map(move |f| (e, f))) {
        let [long, high] = [e, f].map(|e| 2f64.powi(32 * e));
        for of in [Curve::linear, Curve::monotone, Curve::cubic] {
            let usual = of(&x, &y, Beyond::Line).unwrap();
            let [scaled, raised] = [x.map(|x| long * x), y.map(|y| high * y)];
            match of(&scaled, &raised, Beyond::Line) {
                Ok(curve) => (-10..70).for_each(|k| {
                    let at = 0.1 * f64::from(k);
                    let [found, expected] = [curve.value([long * at]), high * usual.value([at])];
                    assert!(
                        (found - expected).abs() <= 1e-8 * 3.0 * high,
                        "{e} {f} {at}: {found:e} {expected:e}"
                    );
                }),
                Err(InvalidTable::Units { .. }) if e.abs() > 7 || f.abs() > 7 => refused += 1,
                Err(other) => panic!("{e} {f}: {other}"),
            }
        }
    }
    assert!(refused > 0);
}
