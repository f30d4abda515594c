//! Integrals along motions.

use crate::systems::bank::Law;
use lagrange_runtime::controller::Controller;
use lagrange_runtime::method::explicit_rk::{Euler, Tsitouras5};
use lagrange_runtime::prelude::*;
use lagrange_runtime::testing::slope;
use lagrange_runtime::{
    BlanesMoan4, DoubleDouble, KahanLi8, Nystrom12,
    method::nystrom::{Nystrom6, Nystrom8},
};

lagrangian! {
    system Oscillator {
        param k;
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = 0.5 * k * x.powi(2);
    }
}

/// ∫x² of x = cos t over steps of 20 radians, of which the state is exact.
#[test]
fn long_exact_steps() {
    let oscillator = Oscillator::new(1.0);
    for end in [20.0, 200.0, if cfg!(feature = "long") { 2000.0 } else { 400.0 }] {
        let run =
            integrate(&oscillator, MatrixExponential, FixedStep::new(20.0), State::new(0.0, [1.0], [0.0]));
        let integral = run.until(end).integrals([0.0], |s| [s.q[0].powi(2)]).total().unwrap().integrals[0];
        let exact = 0.5 * end + 0.25 * (2.0 * end).sin();
        // The amplitude is uncertain by rounding in proportion to time.
        assert!((integral - exact).abs() < f64::EPSILON * end * end, "{integral} for {exact}");
    }
}

lagrangian! {
    /// With the momentum 0 of y the reduced system is a free particle, whose steps grow without bound, and ẏ = −cos
    /// 10x.
    system Rippled {
        coord x, y;
        T = 0.5 * dot(x).powi(2) + 0.5 * (dot(y) + cos(10 * x)).powi(2);
        V = 0;
        routhian Free;
    }
}

/// y = −sin(10 x)/10 at x = t.
#[test]
fn integrands_that_change_faster_than_the_state() {
    let start = State::new(0.0, [0.0, 0.0], [1.0, -1.0]);
    let (free, state) = Rippled::new().reduce(&start);
    for tolerance in [1e-3, 1e-6, 1e-9, 1e-12] {
        let run = integrate(&free, Dop853, PiController::tolerance(tolerance), state).until(20.0);
        let end: State<f64, 2> = run.recover([0.0]).last().unwrap().unwrap();
        assert!((end.q[1] + 200f64.sin() / 10.0).abs() < 1e-13, "{tolerance}: {}", end.q[1]);
    }
}

lagrangian! {
    /// ẏ = p − x beside an oscillator.
    system Carried {
        coord x, y;
        T = 0.5 * dot(x).powi(2) + 0.5 * (dot(y) + x).powi(2);
        V = 0.5 * x.powi(2);
        routhian Carrier;
    }
}

/// With the momentum 1 of y the oscillator is x = 1 + a cos t, and y = −a sin t.
#[test]
fn ignorable_coordinates_over_long_exact_steps() {
    let (carrier, state) = Carried::new().reduce(&State::new(0.0, [3.0, 0.0], [0.0, -2.0]));
    for end in [40.0, 400.0] {
        let run = integrate(&carrier, MatrixExponential, FixedStep::new(40.0), state).until(end);
        let end: State<f64, 2> = run.recover([0.0]).last().unwrap().unwrap();
        assert!((end.q[1] + 2.0 * end.t.sin()).abs() < 1e-14 * end.t, "{}", end.q[1]);
    }
}

/// ∫|ẋ| over ten periods has kinks, ∫ of the sign of x jumps.
#[test]
fn integrands_with_kinks_and_jumps() {
    let start = State::new(0.0, [1.0], [0.0]);
    let end = 20.0 * core::f64::consts::PI;
    let oscillator = Oscillator::new(1.0);
    let run = integrate(&oscillator, MatrixExponential, FixedStep::new(7.3), start).until(end);
    let integrals = run.integrals([0.0; 2], |s| [s.qd[0].abs(), s.q[0].signum()]).total().unwrap().integrals;
    // Halves that agree to 2⁶ ulps of the integral, at each of 20 kinks.
    let bound = 20.0 * 64.0 * f64::EPSILON * 40.0;
    assert!((integrals[0] - 40.0).abs() < bound, "{integrals:?}");
    assert!(integrals[1].abs() < bound, "{integrals:?}");
}

#[test]
#[cfg_attr(not(feature = "long"), ignore = "long")]
fn integrands_that_are_not_finite_or_too_rough() {
    let start = State::new(0.0, [1.0], [0.0]);
    let oscillator = Oscillator::new(1.0);
    let run = || integrate(&oscillator, Dop853, PiController::tolerance(1e-9), start).until(10.0);
    let failed = run().integrals([0.0], |s| [s.q[0].ln()]).total().unwrap_err();
    assert!(matches!(failed.failure, Failure::Quadrature { .. }), "{failed}");
    // A pole of second order within a step.
    let failed = run().integrals([0.0], |s| [s.q[0].powi(-2)]).total().unwrap_err();
    assert!(matches!(failed.failure, Failure::Quadrature { .. }), "{failed}");
    // One that the nodes of a step lie evenly about.
    let still = integrate(&oscillator, MatrixExponential, FixedStep::new(1.0), start).until(1.0);
    let failed = still.integrals([0.0], |s| [1.0 / (s.t - 0.5)]).total().unwrap_err();
    assert!(matches!(failed.failure, Failure::Quadrature { .. }), "{failed}");
    let mut seed = 1u64;
    let noise = |_: &State<f64, 1>| {
        seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        [(seed >> 11) as f64]
    };
    let failed = run().integrals([0.0], noise).total().unwrap_err();
    assert!(matches!(failed.failure, Failure::Quadrature { .. }), "{failed}");
    // After a failure there is nothing.
    let mut integrals = run().integrals([0.0], |_| [f64::NAN]);
    assert!(matches!(integrals.next(), Some(Err(Failure::Quadrature { .. }))));
    assert!(integrals.next().is_none());
}

/// x = cos t: ∫x = sin t in the digits of the scalar.
#[test]
fn integrals_have_the_digits_of_the_scalar() {
    let digits = |x: f64| DoubleDouble::from_f64(x);
    let system = Oscillator { k: digits(1.0) };
    let start = State::new(digits(0.0), [digits(1.0)], [digits(0.0)]);
    let run = integrate(&system, Taylor::with_order(30), TaylorController::tolerance(1e-29), start)
        .until(digits(10.0));
    let total = run.integrals([digits(0.0)], |s| [s.q[0]]).total().unwrap();
    let error = (total.integrals[0] - digits(10.0).sin()).magnitude();
    assert!(error < 1e-28, "{error}");
}

lagrangian! {
    /// An orbit, whose angle is to be recovered.
    system Orbit {
        coord r: length, phi: angle;
        T = 0.5 * (dot(r).powi(2) + (r * dot(phi)).powi(2));
        V = -1 / r;
        routhian Radial;
    }
}

/// The angle by quadrature against the angle integrated as a coordinate, by the number of steps.
fn errors_of<M>(method: &M, steps: [u32; 3]) -> Vec<(f64, f64)>
where
    M: Method<Radial, 1> + Clone,
    FixedStep<f64>: Controller<f64, 1, M::Error>,
{
    let start = State::new(0.0, [1.0, 0.0], [0.3, 1.1]);
    let end = 6.0;
    let (radial, state) = Orbit::new().reduce(&start);
    let exact = integrate(&Orbit::new(), Verner9, PiController::tolerance(1e-15), start)
        .until(end)
        .final_state()
        .unwrap();
    let error = |n: u32| {
        let h = end / f64::from(n);
        let run = integrate(&radial, method.clone(), FixedStep::new(h), state).until(end);
        let recovered: State<f64, 2> = run.recover([0.0]).last().unwrap().unwrap();
        (h, (recovered.q[1] - exact.q[1]).abs())
    };
    steps.into_iter().map(error).collect()
}

#[test]
fn integrals_are_as_accurate_as_said() {
    macro_rules! check {
        ($($method:expr, $steps:expr, $order:expr;)*) => {$(
            let errors = errors_of(&$method, $steps);
            let order = slope(errors.iter().copied(), 1e-13);
            assert!(order > $order - 0.3, "{}: order {order} of {errors:?}", stringify!($method));
        )*};
    }
    check! {
        Euler, [400, 800, 1600], 1.0;
        Verlet, [60, 120, 240], 2.0;
        ImplicitMidpoint, [60, 120, 240], 2.0;
        Rk4, [60, 120, 240], 4.0;
        Gauss4, [60, 120, 240], 4.0;
        BlanesMoan4, [40, 80, 160], 4.0;
        DormandPrince5, [40, 80, 160], 5.0;
        Tsitouras5, [40, 80, 160], 5.0;
        Rodas5P, [40, 80, 160], 5.0;
        Radau5, [40, 80, 160], 5.0;
        Gauss6, [40, 80, 160], 6.0;
        Nystrom6, [12, 18, 27], 6.0;
        Nystrom8, [8, 12, 16], 8.0;
        Compose(Verlet, KahanLi8), [40, 60, 80], 8.0;
        Dop853, [20, 30, 40], 8.0;
        Verner9, [12, 16, 20], 8.0;
        Nystrom12, [6, 8, 10], 10.0;
    }
}

/// After five periods `2π a^(3/2)` r is what it was, and φ has grown by 10π.
#[test]
fn recovered_angles_err_as_the_state_does() {
    let start = State::new(0.0, [1.0, 0.0], [0.3, 1.1]);
    let (radial, state) = Orbit::new().reduce(&start);
    let axis = 1.0 / (2.0 - 0.3f64.powi(2) - 1.1f64.powi(2));
    let turns = 10.0 * core::f64::consts::PI;
    let end = turns * axis.powf(1.5);
    macro_rules! check {
        ($tolerance:expr; $($method:expr, $controller:ident;)*) => {$(
            let run = integrate(&radial, $method, $controller::tolerance($tolerance), state).until(end);
            let last: State<f64, 2> = run.recover([0.0]).last().unwrap().unwrap();
            let errors = [last.q[0] - 1.0, last.qd[0] - 0.3, last.q[1] - turns].map(f64::abs);
            assert!(errors[2] < 10.0 * errors[0].max(errors[1]), "{} {}: {errors:?}", stringify!($method), $tolerance);
        )*};
    }
    for &tolerance in if cfg!(feature = "long") { &[1e-6, 1e-9, 1e-11][..] } else { &[1e-6, 1e-9] } {
        check! {
                tolerance;
            Tsitouras5, PiController;
            DormandPrince5, PiController;
            Dop853, PiController;
            Verner9, PiController;
            Nystrom6, PiController;
            Nystrom8, PiController;
            Rodas5P, PiController;
            Radau5, PiController;
            Nystrom12, PiController;
            Taylor::of_order(20), TaylorController;
        }
    }
}

/// A jump or a kink wherever it lies in a step, beside the nodes of the rule, too: time spent below 0 and depth of a
/// fall from z to −∞.
#[test]
fn jumps_and_kinks_are_met_wherever_they_lie() {
    let free = Law(&|_, _, _| -9.81);
    for k in 0..200 {
        let height = 0.05 + 0.1 * f64::from(k);
        let crossed = (2.0 * height / 9.81).sqrt();
        let (end, depth) =
            (crossed + 1.3, |t: f64| 9.81 / 6.0 * (t * t * t - crossed.powi(3)) - height * (t - crossed));
        let start = State::new(0.0, [height], [0.0]);
        let run = integrate(&free, Dop853, PiController::tolerance(1e-12), start).until(end);
        let below = |s: &State<f64, 1>| [if s.q[0] < 0.0 { 1.0 } else { 0.0 }, (-s.q[0]).max(0.0)];
        let [time, area] = run.integrals([0.0; 2], below).total().unwrap().integrals;
        assert!((time - 1.3).abs() < 1e-13 * end, "{height}: {:e}", time - 1.3);
        assert!((area - depth(end)).abs() < 1e-10 * depth(end), "{height}: {:e}", area / depth(end) - 1.0);
    }
}

lagrangian! {
    /// A ball on a damped spring that only pushes.
    system Contact {
        coord z;
        T = 0.5 * dot(z).powi(2);
        V = 9.81 * z;
        Q[z] = if z < 0 { -1e4 * z - 3 * dot(z) } else { 0 };
    }
}

/// Work in a contact, from 0 on: the run has steps of some roundings of time at each of its switches.
#[test]
fn work_through_a_contact() {
    let ball = Contact::new();
    for k in 0..20 {
        let start = State::new(0.0, [0.3 + 0.037 * f64::from(k)], [0.0]);
        let run = integrate(&ball, Dop853, PiController::tolerance(1e-12), start).until(2.0);
        let end = run.integrals([0.0], |s| [ball.power(&s.q, &s.qd, s.t)]).total().unwrap();
        let change = ball.energy_at(&end.state) - ball.energy_at(&start);
        assert!((end.integrals[0] - change).abs() < 1e-9, "{k}: {:e}", end.integrals[0] - change);
    }
}
