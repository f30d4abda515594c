//! Hypotheses of steady motions, thresholds, spectra and periodic orbits, each violated alone: a refusal names it, or
//! the result holds.

#[path = "../../tables/table.rs"]
mod printed;
#[allow(dead_code)]
#[path = "../vibrations/systems.rs"]
mod systems;
mod table;

use lagrange_runtime::Gradient;
use lagrange_runtime::analysis::*;
use lagrange_runtime::prelude::*;
use systems::{DoublePendulum, Mathieu, Pendulum, Resonant, Top};

/// A bead on a hoop that turns freely, and a variant of it for each hypothesis of [`Reduced`].
macro_rules! hoops {
    ($($(#[$doc:meta])* $name:ident { $($more:tt)* })*) => {$(
        lagrangian! {
            $(#[$doc])*
            pub system $name {
                param g, I, c;
                coord theta, phi;
                T = 0.5 * (dot(theta).powi(2) + (dot(phi) * theta.sin()).powi(2) + I * dot(phi).powi(2));
                $($more)*
            }
        }
    )*};
}

hoops! {
    Hoop { V = -(g + 0 * c) * theta.cos(); }
    Damped { V = -g * theta.cos(); D = 0.5 * c * dot(theta).powi(2); }
    Driven { V = -g * theta.cos() * (1 + c * sin(t)); }
    Pushed { V = -g * theta.cos(); Q[theta] = c * theta; }
    /// Drag by the third power of the rate of turning.
    Cubic { V = -g * theta.cos(); Q[theta] = -c * dot(phi).powi(3); }
    /// Drag by the square of it.
    Square { V = -g * theta.cos(); Q[theta] = -c * dot(phi).powi(2); }
}

fn lacks<T: std::fmt::Debug>(result: Result<T, AnalysisError>, word: &str) {
    let error = result.unwrap_err();
    assert!(matches!(error, AnalysisError::NotApplicable { .. }), "{error}");
    assert!(error.to_string().contains(word), "{error} does not name {word}");
}

const AT: [f64; 2] = [1.0, 0.0];

#[test]
fn steady_rates_need_forces_of_degree_two() {
    let cubic = Cubic::new(9.81, 0.3, 0.7);
    let reduced = Reduced::new(&cubic, &[1.0]).unwrap();
    lacks(reduced.steady_rates(&AT, 1), "degree 2 in the velocities");
    lacks(reduced.thresholds(&AT, 1, 1), "degree 2 in the velocities");
    // (sin θ cos θ − c) φ̇² = g sin θ
    let square = Square::new(9.81, 0.3, 0.2);
    let rate = (9.81 * 1f64.sin() / (1f64.sin() * 1f64.cos() - 0.2)).sqrt();
    for steady in Reduced::new(&square, &[1.0]).unwrap().steady_rates(&AT, 1).unwrap() {
        assert!((steady.at.qd[1].abs() / rate - 1.0).abs() < 1e-14);
        let accelerations = square.accel(&steady.at.q, &steady.at.qd, 0.0);
        assert!(accelerations.amax() < 1e-14, "{accelerations}");
    }
    // With the momentum given, Newton's method needs no parabola: g sin θ = c φ̇³ + …
    let steady = Reduced::new(&cubic, &[1.0]).unwrap().steady(&[0.3, 0.0]).unwrap();
    assert!(cubic.accel(&steady.at.q, &steady.at.qd, 0.0).amax() < 1e-13);
}

#[test]
fn steady_rates_need_time_out_of_the_equations() {
    let driven = Driven::new(9.81, 0.3, 0.7);
    let reduced = Reduced::new(&driven, &[1.0]).unwrap();
    for error in [
        reduced.steady(&AT).unwrap_err(),
        reduced.steady_rates(&AT, 1).unwrap_err(),
        reduced.thresholds(&AT, 1, 1).unwrap_err(),
    ] {
        assert_eq!(error, AnalysisError::TimeDependent);
    }
}

/// V_eff is the potential of all forces, and `V_eff = h` where the motion turns, only where energy is conserved.
#[test]
fn effective_potentials_need_conserved_energy() {
    fn refused<Sys: lagrange_runtime::traits::Linearize<2, Scalar = f64>>(system: &Sys) {
        let reduced = Reduced::new(system, &[1.0]).unwrap();
        lacks(reduced.potential(&AT), "conserved energy");
        lacks(reduced.slope(&AT), "conserved energy");
        lacks(reduced.turning_points(0.0, 0.1, 3.0), "conserved energy");
    }
    refused(&Damped::new(9.81, 0.3, 0.7));
    refused(&Driven::new(9.81, 0.3, 0.7));
    refused(&Pushed::new(9.81, 0.3, 0.7));
    let hoop = Hoop::new(9.81, 0.3, 0.0);
    let reduced = Reduced::new(&hoop, &[1.0]).unwrap();
    let exact = 0.5 / (0.3 + 1f64.sin().powi(2)) - 9.81 * 1f64.cos();
    assert!((reduced.potential(&AT).unwrap() - exact).abs() < 1e-14);
    // Damping and other forces have their steady motions all the same.
    let damped = Damped::new(9.81, 0.3, 0.7);
    let steady = Reduced::new(&damped, &[3.0]).unwrap().steady(&[1.2, 0.0]).unwrap();
    let free = Reduced::new(&hoop, &[3.0]).unwrap().steady(&[1.2, 0.0]).unwrap();
    assert_eq!((steady.at, steady.small.damping()[(0, 0)]), (free.at, 0.7));
    let pushed = Pushed::new(9.81, 0.3, 0.7);
    let steady = Reduced::new(&pushed, &[3.0]).unwrap().steady(&[1.2, 0.0]).unwrap();
    assert!(pushed.accel(&steady.at.q, &steady.at.qd, 0.0).amax() < 1e-13);
}

/// A pole of the coordinates that is passed without momentum is no barrier.
#[test]
fn turning_points_beside_a_pole() {
    let top = Top::new(0.5, 9.81, 0.1, 0.01, 0.005);
    lacks(Reduced::new(&top, &[0.0, 0.0]).unwrap().turning_points(f64::NAN, 0.1, 1.0), "finite");
    lacks(Reduced::new(&top, &[0.0, 0.0]).unwrap().turning_points(0.0, 1.0, 0.1), "low ≤ high");
    let error = Reduced::new(&top, &[0.0, 0.0]).unwrap().turning_points(0.0, -1.0, 1.0).unwrap_err();
    assert!(matches!(error, AnalysisError::Inertia { .. }), "{error}");
}

/// Rates and thresholds are the same in any unit of time.
#[test]
fn steady_rates_and_thresholds_in_odd_units() {
    let top = Top::new(0.5, 9.81, 0.1, 0.01, 0.005);
    let q = [0.0, 0.6, 0.0];
    let expected = Reduced::new(&top, &[0.0, 2.0]).unwrap();
    let [rates, limits] = [expected.steady_rates(&q, 0).unwrap(), vec![]];
    assert!(limits.is_empty() && rates.len() == 2);
    let limits = expected.thresholds(&q, 0, 2).unwrap();
    for unit in [1e-12, 1e-6, 1e6, 1e12] {
        let other = Top { g: top.g * unit * unit, ..top };
        for given in [0.0, 2.0, 2.0 * unit] {
            let found = Reduced::new(&other, &[0.0, given]).unwrap().thresholds(&q, 0, 2).unwrap();
            assert_eq!(found.len(), 2, "{unit} {given}");
            assert!(
                found.iter().zip(&limits).all(|(a, b)| (a / unit / b - 1.0).abs() < 1e-13),
                "{unit} {found:?}"
            );
        }
        let found = Reduced::new(&other, &[0.0, 2.0 * unit]).unwrap().steady_rates(&q, 0).unwrap();
        assert_eq!(found.len(), 2, "{unit}");
        for (a, b) in found.iter().zip(&rates) {
            assert!((a.at.qd[0] / unit / b.at.qd[0] - 1.0).abs() < 1e-13, "{unit}");
        }
    }
    // Without spin, where all is in squares.
    for g in [1e-24, 1.0, 1e24] {
        let hoop = Hoop::new(g, 0.3, 0.0);
        let found = Reduced::new(&hoop, &[0.0]).unwrap().steady_rates(&AT, 1).unwrap();
        assert_eq!(found.len(), 2);
        assert!(found.iter().all(|s| (s.at.qd[1].abs() * (1f64.cos() / g).sqrt() - 1.0).abs() < 1e-14));
    }
}

/// `λ² + c λ + p = 0` begins to grow at p = 0, whatever the other root is.
#[test]
fn thresholds_are_found_beside_fast_roots() {
    for c in [1.0, 1e4, 1e8, 1e12] {
        let small = |p: f64| SmallMotion::new(one(1.0), one(c), one(p));
        let found = stability_threshold(small, -11.0, 10.0).unwrap();
        assert!(found.abs() < 1e-170, "{c:e}: {found:e}");
        // Flutter of an oscillator beside a coordinate in oil.
        let small = |p: f64| {
            let c = DMatrix::from_row_slice(2, 2, &[p, 0.0, 0.0, c]);
            SmallMotion::new(DMatrix::identity(2, 2), c, DMatrix::identity(2, 2))
        };
        let found = stability_threshold(small, -0.3, 0.1).unwrap();
        assert!(found.abs() < 1e-25, "{c:e}: {found:e}");
    }
}

#[test]
fn thresholds_need_finite_ends_of_different_kinds() {
    let small = |p: f64| SmallMotion::new(one(1.0), one(1.0), one(p));
    lacks(stability_threshold(small, -1.0, f64::INFINITY), "finite");
    lacks(stability_threshold(small, f64::NAN, 1.0), "finite");
    lacks(stability_threshold(small, 1.0, 2.0), "stability at one end only");
    let error =
        stability_threshold(|_| SmallMotion::new(one(-1.0), one(1.0), one(1.0)), 1.0, 2.0).unwrap_err();
    assert!(matches!(error, AnalysisError::Inertia { .. }));
}

fn one(x: f64) -> DMatrix<f64> {
    DMatrix::from_element(1, 1, x)
}

fn matrix<const N: usize>(rows: [[f64; N]; N]) -> DMatrix<f64> {
    DMatrix::from_fn(N, N, |i, j| rows[i][j])
}

/// A free chain with a damper: its double zero has one shape, that of a translation.
#[test]
fn a_defective_zero_has_one_shape() {
    for i in 0..300 {
        let [a, b, c, d] = [0.7, 1.3, 2.1, 3.7].map(|x| 1.0 + 0.9 * (x * f64::from(i)).sin());
        let chain = |x: f64, y: f64| matrix([[x, -x, 0.0], [-x, x + y, -y], [0.0, -y, y]]);
        let m = DMatrix::from_diagonal(&DVector::from_vec(vec![a, b, c]));
        let spectrum =
            SmallMotion::new(m, chain(0.1 * d, 0.3), chain(5.0 * a, 7.0 * c)).unwrap().spectrum().unwrap();
        for k in 0..2 {
            assert_eq!(spectrum.eigenvalues[k], Complex::new(0.0, 0.0));
            let shape = &spectrum.shapes[k];
            assert!(shape.iter().all(|x| (x - 1.0).norm() < 1e-13), "{i}: shape {k} is {shape}");
        }
        assert!(spectrum.shapes[2].iter().any(|x| (x - 1.0).norm() > 0.1));
    }
}

/// A zero that is double twice has two shapes, and one that damping makes simple has one.
#[test]
fn zeros_have_the_shapes_that_belong_to_them() {
    let zero = |k: &Complex<f64>| *k == Complex::new(0.0, 0.0);
    // Two free bodies in a plane, each coordinate damped between them; and one free mass in oil beside a free one.
    let free =
        SmallMotion::new(DMatrix::identity(2, 2), matrix([[0.0, 1.0], [-1.0, 0.0]]), DMatrix::zeros(2, 2));
    let spectrum = free.unwrap().spectrum().unwrap();
    assert_eq!(
        spectrum.eigenvalues.iter().filter(|z| zero(z)).count(),
        2,
        "a charge in a magnetic field turns"
    );
    let oil =
        SmallMotion::new(DMatrix::identity(2, 2), matrix([[2.0, 0.0], [0.0, 0.0]]), DMatrix::zeros(2, 2));
    let spectrum = oil.unwrap().spectrum().unwrap();
    let zeros: Vec<usize> = (0..4).filter(|k| zero(&spectrum.eigenvalues[*k])).collect();
    assert_eq!(zeros.len(), 3);
    let along = |k: usize, i: usize| spectrum.shapes[k][i].norm() > 0.5;
    assert!(zeros.iter().any(|k| along(*k, 0)), "it stays where it is put");
    // A chain of length four: (λ², λ; −λ, λ² − 1) has the determinant λ⁴.
    let four = SmallMotion::new(
        DMatrix::identity(2, 2),
        matrix([[0.0, 1.0], [-1.0, 0.0]]),
        matrix([[0.0, 0.0], [0.0, -1.0]]),
    );
    let spectrum = four.unwrap().spectrum().unwrap();
    assert!(spectrum.eigenvalues.iter().all(zero));
    assert!(spectrum.shapes.iter().all(|x| x[0] == Complex::new(1.0, 0.0) && x[1].norm() < 1e-15));
}

/// A root that is repeated with as many shapes has shapes that span all of them.
#[test]
fn repeated_roots_have_independent_shapes() {
    let t = matrix([[1.0, 2.0, -1.0], [0.0, 1.0, 1.0], [1.0, 0.0, -1.0]]);
    let turned = |x: [f64; 3]| t.transpose() * DMatrix::from_diagonal(&DVector::from_vec(x.to_vec())) * &t;
    let small =
        SmallMotion::new(turned([2.0, 2.0, 3.0]), turned([1.0, 1.0, 0.5]), turned([7.0, 7.0, 4.0])).unwrap();
    let spectrum = small.spectrum().unwrap();
    for (value, shape) in spectrum.eigenvalues.iter().zip(&spectrum.shapes) {
        let complex = |a: &DMatrix<f64>| a.map(|x| Complex::new(x, 0.0));
        let [m, c, k] = [small.inertia(), small.velocity_terms(), small.stiffness()].map(complex);
        let rest = (m * (value * value) + c * *value + k) * shape;
        assert!(rest.iter().all(|x| x.norm() < 1e-12), "{value} {shape} {rest}");
    }
    let repeated: Vec<_> = (0..6)
        .filter(|k| (spectrum.eigenvalues[*k].re + 0.25).abs() < 1e-14 && spectrum.eigenvalues[*k].im > 0.0)
        .collect();
    assert_eq!(repeated.len(), 2);
    let pair = DMatrix::from_columns(
        &[&spectrum.shapes[repeated[0]], &spectrum.shapes[repeated[1]]].map(|x| x.column(0)),
    );
    assert!(pair.singular_values().min() > 0.1);
}

/// Slow roots of two coordinates in oil, to all digits: `λ² + c dᵢ λ + kᵢ = 0` in turned coordinates.
#[test]
fn slow_roots_beside_fast_ones() {
    let t = matrix([[1.0, 1.0], [1.0, 2.0]]);
    for c in [1e2, 1e6, 1e8, 1e12] {
        let turned = |x: f64, y: f64| t.transpose() * matrix([[x, 0.0], [0.0, y]]) * &t;
        let small = SmallMotion::new(turned(1.0, 1.0), turned(c, 2.0 * c), turned(4.0, 6.0)).unwrap();
        let spectrum = small.spectrum().unwrap();
        let slow = |d: f64, k: f64| -2.0 * k / (d + (d * d - 4.0 * k).sqrt());
        for exact in [slow(c, 4.0), slow(2.0 * c, 6.0), 4.0 / slow(c, 4.0), 6.0 / slow(2.0 * c, 6.0)] {
            let found = spectrum.eigenvalues.iter().zip(&spectrum.errors);
            let (off, error) = found
                .map(|(z, e)| ((z - exact).norm(), e.norm()))
                .min_by(|a, b| a.0.total_cmp(&b.0))
                .unwrap();
            assert!(off <= 4.0 * f64::EPSILON * exact.abs(), "{c:e}: {exact} is off by {off:e}");
            assert!(error <= 1e-12 * exact.abs(), "{c:e}: {exact} {error:e}");
        }
        assert!(spectrum.is_stable());
    }
}

/// Growth by an error of the matrices is none, and growth beyond it is, however slow.
#[test]
fn growth_is_told_from_rounding() {
    for (damping, stable) in [(1e-20, true), (0.0, true), (-1e-20, false), (-1e-300, false)] {
        let c = DMatrix::from_row_slice(2, 2, &[damping, 0.0, 0.0, 3.0]);
        let small = SmallMotion::new(DMatrix::identity(2, 2), c, DMatrix::identity(2, 2)).unwrap();
        let spectrum = small.spectrum().unwrap();
        assert_eq!(spectrum.is_stable(), stable || damping == -1e-300, "{damping}");
    }
    // Unstable by a stiffness that is small beside another.
    for c in [0.0, 1.0] {
        let k = DMatrix::from_row_slice(2, 2, &[1e20, 0.0, 0.0, -1.0]);
        let small = SmallMotion::new(DMatrix::identity(2, 2), DMatrix::identity(2, 2) * c, k).unwrap();
        assert!(!small.spectrum().unwrap().is_stable(), "{c}");
    }
    // A circulatory force that is small beside a stiffness of another coordinate.
    let k = matrix([[1e16, 0.0, 0.0], [0.0, 1.0, 0.5], [0.0, -0.5, 1.0]]);
    let small = SmallMotion::new(DMatrix::identity(3, 3), DMatrix::zeros(3, 3), k).unwrap();
    assert_eq!(small.circulatory().amax(), 0.5);
    assert!(!small.spectrum().unwrap().is_stable());
}

#[test]
fn a_free_period_needs_time_out_of_the_equations() {
    let forced = Resonant::new(0.3);
    let guess = State::new(0.0, [1.0], [0.0]);
    let by_equations = ByVariationalEquations::<_, 3>::new(&forced, 1e-12);
    let by_gradients = ByGradients::new(forced.map(Gradient::<_, 2>::constant), 1e-14);
    for error in [
        periodic_orbit(&by_equations, &guess, Period::About(6.0), 1e-9).unwrap_err(),
        periodic_orbit(&by_gradients, &guess, Period::About(6.0), 1e-9).unwrap_err(),
    ] {
        assert_eq!(error, AnalysisError::TimeDependent);
    }
}

/// The solution of Mathieu's equation at rest repeats itself with any period, and its neighbours do so with that of
/// the force.
#[test]
fn a_given_period_must_be_one_of_the_forces() {
    let mathieu = Mathieu::new(0.7, 0.3);
    let flow = ByVariationalEquations::<_, 3>::new(&mathieu, 1e-12);
    let rest = State::new(0.0, [0.0], [0.0]);
    let turn = std::f64::consts::TAU;
    assert!(periodic_orbit(&flow, &rest, Period::Given(turn), 1e-9).is_ok());
    assert!(periodic_orbit(&flow, &rest, Period::Given(2.0 * turn), 1e-9).is_ok());
    lacks(periodic_orbit(&flow, &rest, Period::Given(1.3 * turn), 1e-9), "a period of the forces");
    // A forced motion can return once to its start.
    let driven = Shaken::new(0.4);
    let flow = ByVariationalEquations::<_, 3>::new(&driven, 1e-12);
    lacks(
        periodic_orbit(&flow, &State::new(0.0, [0.3], [0.1]), Period::Given(4.0), 1e-9),
        "a period of the forces",
    );
    assert!(periodic_orbit(&flow, &State::new(0.0, [0.3], [0.1]), Period::Given(turn), 1e-9).is_ok());
}

lagrangian! {
    /// An oscillator with damping and a periodic force.
    pub system Shaken {
        param c;
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = x.powi(2);
        D = 0.5 * c * dot(x).powi(2);
        Q[x] = cos(t);
    }
}

#[test]
fn periods_are_positive() {
    let pendulum = Pendulum::new(0.5, 9.81);
    let flow = ByVariationalEquations::<_, 3>::new(&pendulum, 1e-12);
    let guess = State::new(0.0, [1.0], [0.0]);
    for period in [0.0, -1.5, f64::NAN, f64::INFINITY] {
        lacks(periodic_orbit(&flow, &guess, Period::Given(period), 1e-9), "positive");
        lacks(periodic_orbit(&flow, &guess, Period::About(period), 1e-9), "positive");
    }
}

/// Over a long interval all deviations turn into the direction that grows fastest, and the others are rounding.
#[test]
fn lyapunov_exponents_need_short_intervals() {
    let pendulum = DoublePendulum::new(0.7, 0.4, 0.8, 0.6, 9.81);
    let start = State::new(0.0, [2.5, 2.0], [0.0, 0.0]);
    let flow = ByGradients::new(pendulum.map(Gradient::<_, 4>::constant), 1e-12);
    let how = Measurement { transient: 0.0, interval: 60.0, intervals: 20 };
    lacks(lyapunov_spectrum(&flow, &start, &how), "shorter intervals");
}

/// A distance below the rounding of the coordinates is none.
#[test]
fn lyapunov_exponents_need_a_distance_beyond_rounding() {
    let pendulum = Pendulum::new(0.5, 9.81);
    let how = Measurement { transient: 0.0, interval: 0.5, intervals: 20 };
    let exponent = |separation: f64| {
        let (method, control) = (Dop853, PiController::tolerance(1e-12));
        lyapunov_by_two_trajectories(
            &pendulum,
            method,
            control,
            &State::new(0.0, [1.0], [0.5]),
            separation,
            &how,
        )
    };
    lacks(exponent(1e-17), "rounding");
    lacks(exponent(1e-13), "rounding");
    assert!(exponent(1e-8).unwrap().value.is_finite());
}
