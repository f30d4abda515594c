//! Variational equations, periodic orbits, Lyapunov exponents, sensitivities.

use crate::systems::{DoublePendulum, Mathieu, Oscillator, Pendulum, Resonant, VanDerPol};
use lagrange_runtime::analysis::*;
use lagrange_runtime::prelude::*;
use lagrange_runtime::{DoubleDouble, Gradient};

/// The derivative of a motion by its start, by the variational equations and by series of gradients.
#[test]
fn variational_equations_and_gradients_agree() {
    let pendulum = DoublePendulum::new(0.7, 0.4, 0.8, 0.6, 9.81);
    let start = State::new(0.0, [2.0, 1.0], [0.1, -0.4]);
    let by_equations = ByVariationalEquations::<_, 10>::new(&pendulum, 1e-13);
    let by_gradients = ByGradients::new(pendulum.map(Gradient::<_, 4>::constant), 1e-15);
    let (end, matrix) = fundamental_matrix(&by_equations, &start, 2.0).unwrap();
    let (other_end, other) = fundamental_matrix(&by_gradients, &start, 2.0).unwrap();
    assert!((other_end.q - end.q).amax() < 1e-11 && (other_end.qd - end.qd).amax() < 1e-10);
    assert!((&other - &matrix).amax() < 1e-11 * matrix.amax());
    // The flow is symplectic: Φᵀ Ω(end) Φ = Ω(start), where Ω is dq ∧ dp in coordinates and velocities.
    let form = |at: &State<f64, 2>| {
        let [a, b, ad, bd] = Gradient::variables([at.q[0], at.q[1], at.qd[0], at.qd[1]]);
        let system = pendulum.map(Gradient::constant);
        let p = system.momenta(&[a, b].into(), &[ad, bd].into(), Gradient::constant(at.t));
        let q = |k: usize, i: usize| f64::from(u8::from(k == i));
        DMatrix::from_fn(4, 4, |i, j| {
            (0..2).map(|k| q(k, i) * p[k].slopes[j] - q(k, j) * p[k].slopes[i]).sum::<f64>()
        })
    };
    for (at, matrix, bound) in [(end, matrix, 1e-10), (other_end, other, 2e-13)] {
        let kept = matrix.transpose() * form(&at) * &matrix;
        let defect = (kept - form(&start)).amax() / matrix.amax();
        assert!(defect < bound, "{defect:e}");
    }
}

/// After a period T(θ₀) from rest at θ₀ the matrix is `(1, 0; −θ̈₀ dT/dθ₀, 1)`: a neighbour's period differs, and a
/// neighbour's velocity is a shift in time alone. `T = 2π √(l/g)/agm(1, cos(θ₀/2))` (Gauss), differentiated in
/// double-double.
#[test]
fn the_monodromy_matrix_of_the_pendulum() {
    let (l, g, angle) = (0.85, 9.81, 2.0);
    let [theta] = Gradient::variables([DoubleDouble::from(angle)]);
    let constant = |x: f64| Gradient::<_, 1>::constant(DoubleDouble::from(x));
    let (mut a, mut b) = (constant(1.0), (theta * constant(0.5)).cos());
    for _ in 0..8 {
        (a, b) = ((a + b) * constant(0.5), (a * b).sqrt());
    }
    let root = DoubleDouble::from(l) / g;
    let period = Gradient::constant(DoubleDouble::PI * 2.0 * root.sqrt()) / a;
    let (period, slope) = (period.value.value(), period.slopes[0].value());
    let pendulum = Pendulum::new(l, g);
    let start = State::new(0.0, [angle], [0.0]);
    let expected = DMatrix::from_row_slice(2, 2, &[1.0, 0.0, g / l * angle.sin() * slope, 1.0]);
    let by_equations = ByVariationalEquations::<_, 3>::new(&pendulum, 1e-13);
    let by_gradients = ByGradients::new(pendulum.map(Gradient::<_, 2>::constant), 1e-16);
    let matrices = [
        (fundamental_matrix(&by_equations, &start, period).unwrap().1, 1e-11),
        (fundamental_matrix(&by_gradients, &start, period).unwrap().1, 2e-14),
    ];
    for (matrix, bound) in matrices {
        let error = (matrix - &expected).amax() / expected.amax();
        assert!(error < bound, "{error:e}");
    }
}

#[test]
fn the_sensitivity_to_a_parameter_is_the_derivative() {
    let pendulum = DoublePendulum::new(0.7, 0.4, 0.8, 0.6, 9.81);
    let start = State::new(0.0, [2.0, 1.0], [0.1, -0.4]);
    let with = |[m2]: [_; 1]| DoublePendulum { m2, ..pendulum.map(Gradient::constant) };
    let found = sensitivity(with, [0.4], Dop853, PiController::tolerance(1e-13), &start, 2.0).unwrap();
    let Sensitivity { end, slopes: [slope] } = found;
    let at = |m2: f64| {
        let system = DoublePendulum { m2, ..pendulum };
        integrate(&system, Dop853, PiController::tolerance(1e-13), start).until(2.0).final_state().unwrap()
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
    let flow = ByVariationalEquations::<_, 3>::new(&damped, 1e-13);
    let orbit = periodic_orbit(&flow, &rest, Period::Given(2.5), 1e-10).unwrap();
    let rate = Complex::new(-0.15, (4.0f64 - 0.15 * 0.15).sqrt());
    let exact = (rate * 2.5).exp();
    assert!(
        orbit.multipliers.iter().all(|mu| (mu.re - exact.re).hypot(mu.im.abs() - exact.im.abs()) < 1e-12)
    );
    assert!(orbit.is_stable(1e-9));
    // The first tongue of Mathieu's equation lies, to second order, between 1/4 − ε/2 − ε²/8 and 1/4 + ε/2 − ε²/8.
    let tau = std::f64::consts::TAU;
    for (delta, stable) in [(0.19, true), (0.21, false), (0.29, false), (0.31, true)] {
        let mathieu = Mathieu::new(delta, 0.1);
        let flow = ByVariationalEquations::<_, 3>::new(&mathieu, 1e-12);
        let orbit = periodic_orbit(&flow, &rest, Period::Given(tau), 1e-9).unwrap();
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
    let flow = ByVariationalEquations::<_, 3>::new(&oscillator, 1e-13);
    let orbit = periodic_orbit(&flow, &guess, Period::About(6.5), 1e-10).unwrap();
    assert!((orbit.period - 6.663286859323).abs() < 1e-9, "{}", orbit.period);
    assert!((orbit.multipliers[1] - 1.0).norm() < 1e-9 && orbit.is_stable(1e-8));
    // Liouville's formula for the other one, by Simpson's rule over the orbit.
    let run = integrate(&oscillator, Dop853, PiController::tolerance(1e-13), orbit.start).until(orbit.period);
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
    let flow = ByGradients::new(pendulum.map(Gradient::<_, 4>::constant), 1e-15);
    let orbit = periodic_orbit(&flow, &guess, Period::About(period), 1e-12).unwrap();
    assert!(orbit.residual < 1e-13 && orbit.period > period && orbit.period < 1.02 * period);
    assert_eq!(orbit.multipliers.iter().filter(|mu| (*mu - 1.0).norm() < 1e-4).count(), 2);
    assert!(orbit.is_stable(1e-4));
}

/// Undamped and driven at its own frequency, no motion repeats.
#[test]
fn where_there_is_no_periodic_orbit_none_is_found() {
    let rest = State::new(0.0, [0.0], [0.0]);
    let resonant = Resonant::new(1.0);
    let flow = ByVariationalEquations::<_, 3>::new(&resonant, 1e-10);
    let found = periodic_orbit(&flow, &rest, Period::Given(std::f64::consts::TAU), 1e-7);
    assert!(
        matches!(found, Err(AnalysisError::NotConverged { residual, .. }) if residual > 1.0),
        "{found:?}"
    );
    let nowhere = State::new(0.0, [f64::NAN], [0.0]);
    let oscillator = VanDerPol::new(1.0);
    let flow = ByVariationalEquations::<_, 3>::new(&oscillator, 1e-10);
    let found = periodic_orbit(&flow, &nowhere, Period::About(6.0), 1e-7);
    assert!(matches!(found, Err(AnalysisError::Run(_))), "{found:?}");
}

/// Linear damping: both exponents are the real part of the eigenvalues.
#[test]
fn lyapunov_exponents_of_a_damped_oscillator() {
    let damped = Oscillator::new(1.0, 0.3, 4.0);
    let start = State::new(0.0, [1.0], [0.0]);
    let how = Measurement { transient: 10.0, interval: 1.0, intervals: 400 };
    let flow = ByGradients::new(damped.map(Gradient::<_, 2>::constant), 1e-11);
    let both = lyapunov_spectrum(&flow, &start, &how).unwrap();
    assert!((both[0].value + both[1].value + 0.3).abs() < 1e-9, "the sum is the divergence");
    for exponent in both {
        assert!((exponent.value + 0.15).abs() < 5e-3 && exponent.error < 5e-3, "{exponent:?}");
    }
}

/// The same number, within the errors that both methods state.
#[test]
#[cfg_attr(not(feature = "long"), ignore = "long")]
fn two_methods_agree_about_the_chaos_of_the_double_pendulum() {
    let pendulum = DoublePendulum::new(0.7, 0.4, 0.8, 0.6, 9.81);
    let start = State::new(0.0, [2.0, 2.4], [0.0; 2]);
    let how = Measurement { transient: 20.0, interval: 0.5, intervals: 4000 };
    let flow = ByVariationalEquations::<_, 10>::new(&pendulum, 1e-9);
    let spectrum = lyapunov_spectrum(&flow, &start, &how).unwrap();
    let control = PiController::tolerance(1e-9);
    let second = lyapunov_by_two_trajectories(&pendulum, Dop853, control, &start, 1e-7, &how).unwrap();
    println!("variational {spectrum:?}\ntwo trajectories {second:?}");
    let first = spectrum[0];
    // The error is itself an estimate from one chaotic trajectory, which another rounding of a sine makes another
    // one: with two such roundings it was 0.028 and 0.061, since a trajectory may stay near a regular island for
    // long.
    assert!(first.value > 10.0 * first.error, "chaotic beyond doubt: {first:?}");
    assert!((first.value - second.value).abs() < 3.0 * first.error.hypot(second.error));
    // In pairs, and two are zero.
    let rounding = 5.0 * first.error;
    assert!((spectrum[0].value + spectrum[3].value).abs() < rounding);
    assert!((spectrum[1].value + spectrum[2].value).abs() < rounding && spectrum[1].value.abs() < rounding);
}

lagrangian! {
    /// A damped oscillator, and beside it Hénon and Heiles' particle, whose exponent at E = 1/6 is some 0.12.
    system BesideChaos {
        coord z, x, y;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2));
        V = 0.5 * (x * x + y * y + z * z) + x * x * y - y.powi(3) / 3;
        D = 0.1 * dot(z).powi(2);
    }
}

/// The largest exponent is the first one, whichever block of coordinates it belongs to.
#[test]
#[cfg_attr(not(feature = "long"), ignore = "long")]
fn lyapunov_exponents_of_blocks_are_sorted() {
    let system = BesideChaos::new();
    let rate = (1.0f64 / 3.0).sqrt();
    let start = State::new(0.0, [0.3, 0.0, 0.0], [0.0, rate * 0.8, rate * 0.6]);
    let how = Measurement { transient: 50.0, interval: 2.0, intervals: 1500 };
    let one = ByVariationalEquations::<_, 6>::new(&system, 1e-9);
    let found = lyapunov_spectrum(&one, &start, &how).unwrap();
    assert!(found.len() == 1 && found[0].value > 0.06, "{found:?}");
    let all = ByVariationalEquations::<_, 21>::new(&system, 1e-9);
    let found = lyapunov_spectrum(&all, &start, &how).unwrap();
    assert!(found.windows(2).all(|pair| pair[0].value >= pair[1].value), "{found:?}");
    assert!(found.len() == 6 && found[0].value > 0.06, "{found:?}");
    let damped = found.iter().filter(|exponent| (exponent.value + 0.1).abs() < 5e-3).count();
    assert!(damped >= 2, "{found:?}");
}

#[test]
fn senseless_measurements_are_refused() {
    let oscillator = Oscillator::new(1.0, 0.3, 4.0);
    let start = State::new(0.0, [1.0], [0.0]);
    let how = Measurement { transient: 0.0, interval: 0.0, intervals: 4 };
    let flow = ByVariationalEquations::<_, 3>::new(&oscillator, 1e-9);
    let found = lyapunov_spectrum(&flow, &start, &how);
    assert!(matches!(found, Err(AnalysisError::NotApplicable { .. })));
    let how = Measurement { interval: 1.0, ..how };
    let apart =
        lyapunov_by_two_trajectories(&oscillator, Dop853, PiController::tolerance(1e-9), &start, 0.0, &how);
    assert!(matches!(apart, Err(AnalysisError::NotApplicable { .. })));
}
