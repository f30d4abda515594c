//! Variational equations, periodic orbits, Lyapunov exponents, sensitivities.

use crate::systems::{DoublePendulum, Oscillator};
use lagrange_runtime::analysis::*;
use lagrange_runtime::prelude::*;

lagrangian! {
    /// Mathieu's equation.
    pub system Mathieu {
        param delta, epsilon;
        coord x;
        T = 0.5 * dot(x).powi(2);
        Q[x] = -(delta + epsilon * cos(t)) * x;
        V = 0;
    }
}

lagrangian! {
    /// Van der Pol's oscillator.
    pub system VanDerPol {
        param mu;
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = 0.5 * x.powi(2);
        Q[x] = mu * (1 - x.powi(2)) * dot(x);
    }
}

lagrangian! {
    /// Driven at its natural frequency.
    pub system Resonant {
        param f;
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = 0.5 * x.powi(2);
        Q[x] = f * cos(t);
    }
}

/// The derivative of a motion by its start, by the variational equations and by duals.
#[test]
fn variational_equations_and_duals_agree() {
    let pendulum = DoublePendulum::new(0.7, 0.4, 0.8, 0.6, 9.81);
    let start = State::new(0.0, [2.0, 1.0], [0.1, -0.4]);
    let (end, matrix) = fundamental_matrix::<10, _, _>(&pendulum, &start, 2.0, 1e-13).unwrap();
    let dual = pendulum.map(Dual::constant);
    for k in 0..4 {
        let mut from = State {
            t: Dual::constant(0.0),
            q: start.q.map(Dual::constant),
            qd: start.qd.map(Dual::constant),
        };
        if k < 2 {
            from.q[k].slope = 1.0
        } else {
            from.qd[k - 2].slope = 1.0
        }
        let run = integrate(&dual, Dop853, Pi::tolerance(1e-13), from).until(Dual::constant(2.0));
        let by_duals = run.finish().unwrap();
        for i in 0..2 {
            assert!((by_duals.q[i].value - end.q[i]).abs() < 1e-11);
            assert!((by_duals.q[i].slope - matrix[(i, k)]).abs() < 1e-10 * matrix.amax());
            assert!((by_duals.qd[i].slope - matrix[(2 + i, k)]).abs() < 1e-10 * matrix.amax());
        }
    }
    // Liouville, in momenta: det = det M(start) / det M(end) in velocities.
    let det = |at: &State<f64, 2>| pendulum.inertia(&at.q, &at.qd, 0.0).determinant();
    assert!((matrix.determinant() * det(&end) / det(&start) - 1.0).abs() < 1e-10);
}

#[test]
fn the_sensitivity_to_a_parameter_is_the_derivative() {
    let pendulum = DoublePendulum::new(0.7, 0.4, 0.8, 0.6, 9.81);
    let start = State::new(0.0, [2.0, 1.0], [0.1, -0.4]);
    let with = |m2: Dual<f64>| DoublePendulum { m2, ..pendulum.map(Dual::constant) };
    let Sensitivity { end, slope } = sensitivity(with, 0.4, &start, 2.0, 1e-13).unwrap();
    let at = |m2: f64| {
        let system = DoublePendulum { m2, ..pendulum };
        integrate(&system, Dop853, Pi::tolerance(1e-13), start).until(2.0).finish().unwrap()
    };
    assert!((at(0.4).q - end.q).amax() < 1e-11);
    // A central difference of fourth order, which is good for ten digits.
    let h = 1e-3;
    let quotient =
        ((at(0.4 + h).q - at(0.4 - h).q) * 8.0 - (at(0.4 + 2.0 * h).q - at(0.4 - 2.0 * h).q)) / (12.0 * h);
    assert!((quotient - slope.q).amax() < 1e-7 * slope.q.amax(), "{quotient} {}", slope.q);
}

/// The multipliers of a damped oscillator are e^{λτ}; those of Mathieu's equation without modulation e^{±iω 2π}.
#[test]
fn floquet_multipliers_of_linear_systems() {
    let damped = Oscillator::new(1.0, 0.3, 4.0);
    let rest = State::new(0.0, [0.0], [0.0]);
    let orbit = periodic_orbit::<3, _, _>(&damped, &rest, Period::Given(2.5), 1e-13).unwrap();
    let rate = Complex::new(-0.15, (4.0f64 - 0.15 * 0.15).sqrt());
    let exact = (rate * 2.5).exp();
    assert!(
        orbit.multipliers.iter().all(|mu| (mu.re - exact.re).hypot(mu.im.abs() - exact.im.abs()) < 1e-12)
    );
    assert!(orbit.is_stable(1e-9));
    // The first tongue of Mathieu's equation lies, to second order, between 1/4 − ε/2 − ε²/8 and 1/4 + ε/2 − ε²/8.
    let tau = std::f64::consts::TAU;
    for (delta, stable) in [(0.19, true), (0.21, false), (0.29, false), (0.31, true)] {
        let orbit =
            periodic_orbit::<3, _, _>(&Mathieu::new(delta, 0.1), &rest, Period::Given(tau), 1e-12).unwrap();
        assert_eq!(orbit.is_stable(1e-6), stable, "δ = {delta}: {:?}", orbit.multipliers);
        let product = orbit.multipliers[0] * orbit.multipliers[1];
        assert!((product - 1.0).norm() < 1e-10, "in pairs μ, 1/μ");
    }
}

/// Period 6.663286859323… at μ = 1 (published to 13 digits), and the multipliers 1 and exp ∮ μ(1 − x²) dt.
#[test]
fn the_limit_cycle_of_van_der_pol() {
    let oscillator = VanDerPol::new(1.0);
    let guess = State::new(0.0, [2.0], [0.1]);
    let orbit = periodic_orbit::<3, _, _>(&oscillator, &guess, Period::About(6.5), 1e-13).unwrap();
    assert!((orbit.period - 6.663286859323).abs() < 1e-9, "{}", orbit.period);
    assert!((orbit.multipliers[1] - 1.0).norm() < 1e-9 && orbit.is_stable(1e-8));
    // Liouville's formula for the other one, by Simpson's rule over the orbit.
    let run = integrate(&oscillator, Dop853, Pi::tolerance(1e-13), orbit.start).until(orbit.period);
    let states: Vec<_> = run.sample_evenly(2000).collect::<Result<_, _>>().unwrap();
    let trace = |s: &State<f64, 1>| 1.0 - s.q[0] * s.q[0];
    let h = orbit.period / 2000.0;
    let sum: f64 =
        states.windows(3).step_by(2).map(|w| trace(&w[0]) + 4.0 * trace(&w[1]) + trace(&w[2])).sum();
    let exact = (sum * h / 3.0).exp();
    assert!(
        (orbit.multipliers[0].re - exact).abs() < 1e-9 * exact.max(1e-3),
        "{} {exact}",
        orbit.multipliers[0]
    );
}

/// A normal mode of the double pendulum, grown to a finite amplitude.
#[test]
fn a_nonlinear_normal_mode_of_the_double_pendulum() {
    let pendulum = DoublePendulum::new(0.7, 0.4, 0.8, 0.6, 9.81);
    let small = small_vibrations(&pendulum, &[0.0; 2]).unwrap();
    let modes = small.modes().unwrap();
    let shape = modes.shape(0) * 0.3;
    let period = std::f64::consts::TAU / modes.frequency(0);
    let guess = State::new(0.0, [shape[0], shape[1]], [0.0; 2]);
    let orbit = periodic_orbit::<10, _, _>(&pendulum, &guess, Period::About(period), 1e-12).unwrap();
    assert!(orbit.residual < 1e-10 && orbit.period > period && orbit.period < 1.02 * period);
    assert_eq!(orbit.multipliers.iter().filter(|mu| (*mu - 1.0).norm() < 1e-4).count(), 2);
    assert!(orbit.is_stable(1e-4));
}

/// Undamped and driven at its own frequency, no motion repeats.
#[test]
fn where_there_is_no_periodic_orbit_none_is_found() {
    let rest = State::new(0.0, [0.0], [0.0]);
    let found =
        periodic_orbit::<3, _, _>(&Resonant::new(1.0), &rest, Period::Given(std::f64::consts::TAU), 1e-10);
    assert!(
        matches!(found, Err(AnalysisError::NotConverged { residual, .. }) if residual > 1.0),
        "{found:?}"
    );
    let nowhere = State::new(0.0, [f64::NAN], [0.0]);
    let found = periodic_orbit::<3, _, _>(&VanDerPol::new(1.0), &nowhere, Period::About(6.0), 1e-10);
    assert!(matches!(found, Err(AnalysisError::Run(_))), "{found:?}");
}

/// Linear damping: both exponents are the real part of the eigenvalues.
#[test]
fn lyapunov_exponents_of_a_damped_oscillator() {
    let damped = Oscillator::new(1.0, 0.3, 4.0);
    let start = State::new(0.0, [1.0], [0.0]);
    let how = Measurement { transient: 10.0, interval: 1.0, intervals: 400, tolerance: 1e-11 };
    let both = lyapunov_spectrum::<3, _, _>(&damped, &start, &how).unwrap();
    assert!((both[0].value + both[1].value + 0.3).abs() < 1e-9, "the sum is the divergence");
    for exponent in both {
        assert!((exponent.value + 0.15).abs() < 5e-3 && exponent.error < 5e-3, "{exponent:?}");
    }
}

/// The same number, within the errors that both methods state.
#[test]
fn two_methods_agree_about_the_chaos_of_the_double_pendulum() {
    let pendulum = DoublePendulum::new(0.7, 0.4, 0.8, 0.6, 9.81);
    let start = State::new(0.0, [2.0, 2.4], [0.0; 2]);
    let how = Measurement { transient: 20.0, interval: 0.5, intervals: 4000, tolerance: 1e-9 };
    let spectrum = lyapunov_spectrum::<10, _, _>(&pendulum, &start, &how).unwrap();
    let second = lyapunov_by_two_trajectories(&pendulum, &start, 1e-7, &how).unwrap();
    println!("variational {spectrum:?}\ntwo trajectories {second:?}");
    let first = spectrum[0];
    // The error is itself an estimate from one chaotic trajectory, which another rounding of a sine makes another one: with two such
    // roundings it was 0.028 and 0.061, since a trajectory may stay near a regular island for long.
    assert!(first.value > 10.0 * first.error, "chaotic beyond doubt: {first:?}");
    assert!((first.value - second.value).abs() < 3.0 * first.error.hypot(second.error));
    // In pairs, and two are zero.
    let rounding = 5.0 * first.error;
    assert!((spectrum[0].value + spectrum[3].value).abs() < rounding);
    assert!((spectrum[1].value + spectrum[2].value).abs() < rounding && spectrum[1].value.abs() < rounding);
}

#[test]
fn senseless_measurements_are_refused() {
    let oscillator = Oscillator::new(1.0, 0.3, 4.0);
    let start = State::new(0.0, [1.0], [0.0]);
    let how = Measurement { transient: 0.0, interval: 0.0, intervals: 4, tolerance: 1e-9 };
    assert!(matches!(
        lyapunov_spectrum::<3, _, _>(&oscillator, &start, &how),
        Err(AnalysisError::NotApplicable { .. })
    ));
    let how = Measurement { interval: 1.0, ..how };
    let apart = lyapunov_by_two_trajectories(&oscillator, &start, 0.0, &how);
    assert!(matches!(apart, Err(AnalysisError::NotApplicable { .. })));
}
