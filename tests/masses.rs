//! Masses and moments of inertia of the wrong sign: a run says so at its start, by every way to make one.

use lagrange_runtime::Stepper;
use lagrange_runtime::ensemble::{Collect, Ensemble, Table};
use lagrange_runtime::failure::Coordinate;
use lagrange_runtime::lanes::{FinalState, Fused};
use lagrange_runtime::prelude::*;

lagrangian! {
    /// A mass on a spring.
    system Spring {
        param m, k;
        coord x;
        T = 0.5 * m * dot(x).powi(2);
        V = 0.5 * k * x.powi(2);
    }
}

lagrangian! {
    /// A cart with a pendulum: the inertia of the cart may be negative, and that of both together is not.
    system Cart {
        param cart, bob, l, g = 9.81;
        coord x, theta: angle;
        let px = x + l * sin(theta);
        let py = -l * cos(theta);
        T = 0.5 * cart * dot(x).powi(2) + 0.5 * bob * (dot(px).powi(2) + dot(py).powi(2));
        V = bob * g * py;
    }
}

lagrangian! {
    /// A bob on a rod, by places.
    system Bob {
        param m, l, g = 9.81;
        coord x, y;
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
        V = m * g * y;
        constraint rod: x.powi(2) + y.powi(2) == l.powi(2);
    }
}

lagrangian! {
    /// A damped oscillator and its image that gains energy, whose L has no sign (Bateman, *Phys. Rev.* 38, 1931).
    system Bateman {
        param m, c, k;
        coord x, y;
        L = m * dot(x) * dot(y) + 0.5 * c * (x * dot(y) - dot(x) * y) - k * x * y;
    }
}

fn assert_negative(failure: Failure, name: &'static str, index: usize) {
    let Failure::NegativeInertia { t: 0.0, coordinate } = failure else { panic!("{failure}") };
    assert_eq!(coordinate, Coordinate { index, name });
}

#[test]
fn runs_with_a_negative_mass_fail_at_their_start() {
    macro_rules! fails {
        ($method:expr, $control:expr) => {
            let start = State::new(0.0, [0.1], [0.0]);
            let end = integrate(&Spring::new(-1.0, 1.0), $method, $control, start).until(10.0).final_state();
            assert_negative(end.unwrap_err().failure, "x", 0);
            let end = integrate(&Spring::new(1.0, 1.0), $method, $control, start).until(1.0).final_state();
            assert!((end.unwrap().q[0] - 0.1 * 1.0_f64.cos()).abs() < 1e-4);
        };
    }
    fails!(Dop853, PiController::tolerance(1e-9));
    fails!(Radau5, PiController::tolerance(1e-9));
    fails!(Taylor, TaylorController::tolerance(1e-12));
    fails!(Rk4, FixedStep::new(0.01));
    fails!(Verlet, FixedStep::new(0.01));
    fails!(Gauss4, FixedStep::new(0.01));
    let (control, start) = (PiController::tolerance(1e-9), State::new(0.0, [0.1, 0.3], [0.0, 0.0]));
    let run = |cart: Cart| integrate(&cart, Dop853, control, start).until(0.1).final_state().map(|_| ());
    assert!(run(Cart::new(1.0, 0.5, 0.8)).is_ok());
    assert_negative(run(Cart::new(1.0, -0.5, 0.8)).unwrap_err().failure, "theta", 1);
    assert_negative(run(Cart::new(-1.0, 0.5, 0.8)).unwrap_err().failure, "x", 0);
    // Small masses are masses.
    for m in [1e-300, 1e-12, 1e12] {
        let spring = Spring::new(m, m);
        let end = integrate(&spring, Dop853, control, State::new(0.0, [0.1], [0.0])).until(1.0);
        assert!((end.final_state().unwrap().q[0] - 0.1 * 1.0_f64.cos()).abs() < 1e-8, "{m}");
    }
    let bob = Bob::new(-1.0, 0.5);
    let end = integrate(&bob, Dop853, control, State::new(0.0, [0.3, -0.4], [0.0, 0.0])).until(1.0);
    assert_negative(end.final_state().unwrap_err().failure, "x", 0);
}

#[test]
fn steppers_notice_a_mass_that_becomes_negative() {
    let start = State::new(0.0, [0.1], [0.0]);
    let mut spring = Stepper::new(Spring::new(1.0, 1.0), Rk4, FixedStep::new(0.01), start);
    spring.advance_to(0.5).unwrap();
    spring.system_mut().m = -1.0;
    assert!(matches!(spring.advance_to(1.0), Err(Failure::NegativeInertia { .. })));
}

/// Draws from a wide distribution contain masses below 0: they count as failures, alone and in lanes.
#[test]
fn draws_of_negative_masses_are_counted() {
    let draw =
        |[number]: [u64; 1]| (Spring::new(0.5 * number as f64 - 1.75, 1.0), State::new(0.0, [0.1], [0.0]));
    let samples = Table::new((0..16).map(|number: u64| [number]));
    let study = || Ensemble::new(samples.clone(), 16, draw).integrate(Rk4, FixedStep::new(0.01), 1.0);
    let end = FinalState(|_: &Spring, end: &State<f64, 1>| end.q[0]);
    let failed = |failures: Vec<u64>| assert_eq!(failures, [0, 1, 2, 3]);
    let lanes = study().in_lanes(Fused).observe(&end, Collect).unwrap();
    failed(lanes.failures.kept.iter().map(|failed| failed.index).collect());
    let dop = Ensemble::new(samples.clone(), 16, draw).integrate(Dop853, PiController::tolerance(1e-9), 1.0);
    let lanes = dop.in_lanes(Fused).observe(&end, Collect).unwrap();
    failed(lanes.failures.kept.iter().map(|failed| failed.index).collect());
    for (index, q) in lanes.statistic.rows {
        let omega = (0.5 * index as f64 - 1.75).sqrt().recip();
        assert!((q - 0.1 * omega.cos()).abs() < 1e-7, "{index}");
    }
}

#[test]
fn indefinite_lagrangians_run() {
    let (m, c, k) = (1.0, 0.2, 4.0);
    let start = State::new(0.0, [0.3, 0.0], [0.0, 0.0]);
    let bateman = Bateman::new(m, c, k);
    let end = integrate(&bateman, Dop853, PiController::tolerance(1e-11), start).until(2.0);
    let (decay, omega) = (c / (2.0 * m), (k / m - (c / (2.0 * m)).powi(2)).sqrt());
    let right = 0.3 * (-decay * 2.0_f64).exp() * ((omega * 2.0).cos() + decay / omega * (omega * 2.0).sin());
    assert!((end.final_state().unwrap().q[0] - right).abs() < 1e-9);
}
