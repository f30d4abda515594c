//! Sensitivities, periodic orbits, Lyapunov exponents and steady motions of systems with constraints.

use crate::systems::*;
use lagrange_runtime::Gradient;
use lagrange_runtime::analysis::*;
use lagrange_runtime::method::variational::ConstrainedMidpoint;
use lagrange_runtime::prelude::*;
use lagrange_runtime::testing::reference::SimplePendulum;

lagrangian! {
    /// A pendulum by the place of its bob.
    pub system Bob {
        param l, g = 9.81;
        coord x, y;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = g * y;
        constraint rod: x.powi(2) + y.powi(2) == l.powi(2);
    }
}

lagrangian! {
    /// The same about a vertical axis, in which nothing turns it.
    pub system Conical {
        param l, g = 9.81;
        coord r, z, phi: angle;
        T = 0.5 * (dot(r).powi(2) + dot(z).powi(2) + (r * dot(phi)).powi(2));
        V = g * z;
        constraint rod: r.powi(2) + z.powi(2) == l.powi(2);
    }
}

/// The constraint moves with the parameter: θ stays where it is to first order, since the smallest change is along
/// the rod.
#[test]
fn sensitivity_to_the_length_of_a_rod() {
    let (l, angle, t) = (0.7f64, 0.6f64, 1.3);
    let start = State::new(0.0, [l * angle.sin(), -l * angle.cos()], [0.0; 2]);
    let family = |[l]: [Gradient<f64, 1>; 1]| Bob { l, g: Gradient::constant(9.81) };
    let (method, control) = (Dop853, PiController::tolerance(1e-13));
    let found = sensitivity(family, [l], method, control, &start, t).unwrap();
    let end = |l: f64| {
        let angle = SimplePendulum::new(9.81, l, angle, 0.0).state(t).0;
        [l * angle.sin(), -l * angle.cos()]
    };
    let h = 1e-3;
    let [a, b, c, d] = [2.0, 1.0, -1.0, -2.0].map(|k| end(l + k * h));
    for i in 0..2 {
        assert!((found.end.q[i] - end(l)[i]).abs() < 1e-11);
        let quotient = (8.0 * (b[i] - c[i]) - (a[i] - d[i])) / (12.0 * h);
        assert!((found.slopes[0].q[i] - quotient).abs() < 1e-9, "{} {quotient}", found.slopes[0].q[i]);
    }
}

/// The orbit has as many multipliers as admitted deviations: both are 1 for a pendulum.
#[test]
fn an_orbit_of_a_bob_has_two_multipliers() {
    let bob = Bob::new(0.7);
    let guess = State::new(0.0, [0.3, -0.6], [0.1, 0.05]);
    let by_equations = ByVariationalEquations::<_, 10>::new(&bob, 1e-13);
    let by_gradients = ByGradients::new(bob.map(Gradient::<_, 4>::constant), 1e-14);
    for orbit in [
        periodic_orbit(&by_equations, &guess, Period::About(1.7), 1e-10).unwrap(),
        periodic_orbit(&by_gradients, &guess, Period::About(1.7), 1e-10).unwrap(),
    ] {
        let State { q, qd, .. } = orbit.start;
        assert!((q.norm() - 0.7).abs() < 1e-12 && q.dot(&qd).abs() < 1e-12);
        let angle = q[0].atan2(-q[1]);
        let rate = (q[0] * qd[1] - q[1] * qd[0]) / 0.49;
        let exact = SimplePendulum::new(9.81, 0.7, angle, rate).period();
        assert!((orbit.period - exact).abs() < 1e-11, "{} {exact}", orbit.period);
        assert_eq!(orbit.multipliers.len(), 2);
        assert!(orbit.multipliers.iter().all(|mu| (mu - 1.0).norm() < 1e-5), "{:?}", orbit.multipliers);
    }
}

/// The flow of admitted deviations is that by angles, also after many turns.
#[test]
fn deviations_stay_admitted() {
    let bobs = Bobs::new(0.7, 0.4, 0.8, 0.6, 0.0);
    let angles = Angles::new(0.7, 0.4, 0.8, 0.6, 0.0);
    let place = |a: f64, b: f64, da: f64, db: f64| {
        let [x, y] = [0.8 * a.sin(), -0.8 * a.cos()];
        let [u, v] = [0.8 * a.cos() * da, 0.8 * a.sin() * da];
        let q = [x, y, x + 0.6 * b.sin(), y - 0.6 * b.cos()];
        State::new(0.0, q, [u, v, u + 0.6 * b.cos() * db, v + 0.6 * b.sin() * db])
    };
    let (own, start) = (State::new(0.0, [1.0, 1.5], [0.3, -0.2]), place(1.0, 1.5, 0.3, -0.2));
    // ∂(places)/∂(angles), by duals of the same formulas.
    let tangent = |at: &State<f64, 2>| {
        let over = |k: usize| {
            let d = |i: usize, x: f64| Dual { value: x, slope: f64::from(u8::from(i == k)) };
            let (a, b, da, db) = (d(0, at.q[0]), d(1, at.q[1]), d(2, at.qd[0]), d(3, at.qd[1]));
            let [l, m] = [0.8, 0.6].map(Dual::constant);
            let [x, y] = [l * a.sin(), -l * a.cos()];
            let [u, v] = [l * a.cos() * da, l * a.sin() * da];
            let all =
                [x, y, x + m * b.sin(), y - m * b.cos(), u, v, u + m * b.cos() * db, v + m * b.sin() * db];
            DVector::from_iterator(8, all.into_iter().map(|x| x.slope))
        };
        DMatrix::from_columns(&[0, 1, 2, 3].map(over))
    };
    let by_angles = ByVariationalEquations::<_, 10>::new(&angles, 1e-13);
    let (end, exact) = fundamental_matrix(&by_angles, &own, 3.0).unwrap();
    let by_places = ByVariationalEquations::<_, 36>::new(&bobs, 1e-13);
    let (at, found) = fundamental_matrix(&by_places, &start, 3.0).unwrap();
    let apart = &found * tangent(&own) - tangent(&end) * &exact;
    assert!(apart.amax() < 1e-9 * exact.amax(), "{apart}");
    assert!((at.q[0] - 0.8 * end.q[0].sin()).abs() < 1e-10);
    // Four exponents, in pairs.
    let how = Measurement { transient: 1.0, interval: 0.5, intervals: 40 };
    let by_places = ByVariationalEquations::<_, 36>::new(&bobs, 1e-10);
    let all = lyapunov_spectrum(&by_places, &start, &how).unwrap();
    let same = lyapunov_spectrum(&ByVariationalEquations::<_, 10>::new(&angles, 1e-10), &own, &how).unwrap();
    assert_eq!((all.len(), same.len()), (4, 4));
    let sum: f64 = all.iter().map(|x| x.value).sum();
    // Nothing but the metric of the first and of the last interval differs.
    assert!(sum.abs() < 0.1, "{sum}");
}

/// A conical pendulum by (r, z, φ) on its rod: steady lean and frequency in closed form.
#[test]
fn a_steady_motion_on_a_rod() {
    let (l, g, angle) = (0.7f64, 9.81, 0.8f64);
    let pendulum = Conical::new(l);
    let rate = (g / (l * angle.cos())).sqrt();
    let momentum = (l * angle.sin()).powi(2) * rate;
    let reduced = Reduced::new(&pendulum, &[momentum]).unwrap();
    let steady = reduced.steady(&[0.4, -0.5, 0.0]).unwrap();
    let exact = [l * angle.sin(), -l * angle.cos()];
    assert!((steady.at.q[0] - exact[0]).abs() < 1e-14 && (steady.at.q[1] - exact[1]).abs() < 1e-14);
    assert!((steady.at.qd[2] / rate - 1.0).abs() < 1e-14);
    // ω² = (g/l) (1 + 3 cos²θ)/cos θ
    let square = g / l * (1.0 + 3.0 * angle.cos().powi(2)) / angle.cos();
    let modes = steady.small.modes().unwrap();
    assert_eq!(modes.len(), 1);
    assert!((modes.squares()[0] / square - 1.0).abs() < 1e-13, "{} {square}", modes.squares()[0]);
    assert!(reduced.potential(&steady.at.q.into()).is_ok());
    let error = reduced.turning_points(0.0, 0.1, 0.6).unwrap_err();
    assert_eq!(error, AnalysisError::DependentCoordinates { constraint: "rod" });
    // The same as a steady motion of all coordinates, with the zeros of φ.
    let all = SmallMotion::steady(&pendulum, &steady.at).unwrap();
    let spectrum = all.spectrum().unwrap();
    assert_eq!(spectrum.frequencies().len(), 1);
    assert!((spectrum.frequencies()[0] - square.sqrt()).abs() < 1e-13);
}

lagrangian! {
    /// A chain of rods in space with masses at their ends.
    system Rods {
        param m, l, g = 9.81;
        coord n: [direction; 3];
        let x: [3] = |i| l * n[i] + if i == 0 { [0, 0, 0] } else { x[i - 1] };
        T = (0..3).map(|i| 0.5 * m * dot(x[i]).norm_squared()).sum();
        V = (0..3).map(|i| m * g * x[i][2]).sum();
    }
}

/// Over 15,000 steps of a chain in space the energy error has its size of the beginning, the angular momentum about the
/// vertical is constant to rounding, and so are the lengths.
#[test]
#[cfg_attr(not(feature = "long"), ignore = "long")]
fn the_midpoint_rule_on_constraints_keeps_energy_and_momentum() {
    let chain = Rods::new(1.0, 1.0);
    let mut start = State::new(0.0, [0.0; 9], [0.0; 9]);
    for (i, (n, velocity)) in [
        ([0.3, 0.2, -1.0], [0.5, 1.0, 0.0]),
        ([-0.4, 0.1, -1.0], [0.0, -0.7, 0.3]),
        ([0.1, -0.3, -1.0], [0.4, 0.0, 0.2]),
    ]
    .into_iter()
    .enumerate()
    {
        start = chain.with_direction_n(i, start, &n.into(), &velocity.into());
    }
    let mut stepper = Stepper::new(chain, ConstrainedMidpoint, FixedStep::new(0.01), start);
    let about = |at: &State<f64, 9>| {
        let (mut place, mut velocity, mut sum) = (Vector3::<f64>::zeros(), Vector3::<f64>::zeros(), 0.0);
        for i in 0..3 {
            place += chain.direction_n(i, at);
            velocity += Vector3::<f64>::new(at.qd[3 * i], at.qd[3 * i + 1], at.qd[3 * i + 2]);
            sum += place.cross(&velocity)[2];
        }
        sum
    };
    let energy = |at: &State<f64, 9>| chain.energy_at(at) - chain.energy_at(&start);
    let mut worst = [0.0f64; 10];
    for (k, most) in worst.iter_mut().enumerate() {
        for i in 1..=100 {
            stepper.advance_to(15.0 * k as f64 + 0.15 * i as f64).unwrap();
            *most = most.max(energy(stepper.state()).abs());
        }
    }
    let end = *stepper.state();
    assert!((about(&end) - about(&start)).abs() < 1e-11, "{:e}", about(&end) - about(&start));
    assert!((chain.direction_n(0, &end).norm() - 1.0).abs() < 1e-15);
    assert!(worst[9] < 1.5 * worst[0].max(worst[1]) && worst[0] > 1e-6, "{worst:?}");
}
