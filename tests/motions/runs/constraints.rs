//! Constraints: motions, reactions, impulses.

use lagrange_runtime::prelude::*;

lagrangian! {
    /// A double pendulum of particles in Cartesian coordinates.
    system Cartesian {
        param m: [2], l: [2], g = 9.81;
        coord x: [2], y: [2];
        T = 0.5 * (0..2).map(|i| m[i] * (dot(x[i]).powi(2) + dot(y[i]).powi(2))).sum();
        V = (0..2).map(|i| m[i] * g * y[i]).sum();
        constraint upper: x[0].powi(2) + y[0].powi(2) == l[0].powi(2);
        constraint lower: (x[1] - x[0]).powi(2) + (y[1] - y[0]).powi(2) == l[1].powi(2);
        impulse blow at [x[1], y[1]];
    }
}

lagrangian! {
    /// The same in angles from the downward vertical.
    system Angles {
        param m: [2], l: [2], g = 9.81;
        coord theta: [2];
        let x: [2] = |i| if i == 0 { l[0] * theta[0].sin() } else { x[0] + l[1] * theta[1].sin() };
        let y: [2] = |i| if i == 0 { -l[0] * theta[0].cos() } else { y[0] - l[1] * theta[1].cos() };
        T = 0.5 * (0..2).map(|i| m[i] * (dot(x[i]).powi(2) + dot(y[i]).powi(2))).sum();
        V = (0..2).map(|i| m[i] * g * y[i]).sum();
        observe positions = [x[0], x[1], y[0], y[1]];
        observe velocities_of_positions = [dot(x[0]), dot(x[1]), dot(y[0]), dot(y[1])];
        impulse blow at [x[1], y[1]];
    }
}

lagrangian! {
    /// A disk that rolls upright on a plane: φ is its heading, θ its spin.
    system Disk {
        param m, a, along, across;
        coord x, y, phi, theta;
        T = 0.5 * (m * (dot(x).powi(2) + dot(y).powi(2)) + along * dot(theta).powi(2) + across * dot(phi).powi(2));
        V = 0;
        constraint rolling: [dot(x), dot(y)] == [a * cos(phi) * dot(theta), a * sin(phi) * dot(theta)];
    }
}

lagrangian! {
    /// A particle on a plane inclined at α that is moved sideways.
    system Incline {
        param m, alpha, a, omega, g = 9.81;
        coord x, y;
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
        V = m * g * y;
        constraint plane: (x - a * sin(omega * t)) * sin(alpha) == y * cos(alpha);
    }
}

fn pendula() -> (Cartesian, Angles) {
    let (m, l) = ([0.7, 0.4], [0.8, 0.6]);
    (Cartesian::new(m, l), Angles::new(m, l))
}

fn cartesian(angles: &Angles, at: &State<f64, 2>) -> State<f64, 4> {
    State {
        t: at.t,
        q: angles.positions(&at.q, &at.qd, at.t),
        qd: angles.velocities_of_positions(&at.q, &at.qd, at.t),
    }
}

/// Positions and velocities violate the constraints by no more than this.
const HELD: f64 = 1e-12;

fn assert_held<Sys: Constrained<N, M, Scalar = f64>, const N: usize, const M: usize>(
    system: &Sys,
    at: &State<f64, N>,
) {
    let position = system.constraints(&at.q, at.t).amax();
    let velocity = system.constraint_rates(&at.q, &at.qd, at.t).amax();
    assert!(position <= HELD && velocity <= HELD, "at t = {}: {position:e} and {velocity:e}", at.t);
}

#[test]
fn constrained_and_independent_coordinates_agree() {
    let (free, angles) = pendula();
    let start = State::new(0.0, [0.9, 1.4], [0.3, -0.5]);
    let start_free = cartesian(&angles, &start);
    let times = || (1..=20).map(|k| 0.25 * f64::from(k));
    let by_angles = integrate(&angles, Dop853, PiController::tolerance(1e-13), start).sample(times());
    let free_run = integrate(&free, Dop853, PiController::tolerance(1e-13), start_free).sample(times());
    for (expected, got) in by_angles.zip(free_run) {
        let (expected, got) = (cartesian(&angles, &expected.unwrap()), got.unwrap());
        assert_held(&free, &got);
        assert!((expected.q - got.q).amax() < 1e-9 && (expected.qd - got.qd).amax() < 1e-8, "{got:?}");
    }
}

lagrangian! {
    /// A particle on a surface and in a plane: of four coordinates that are coupled in pairs.
    system Surface {
        param m;
        coord x, y, z, w;
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2) + dot(w).powi(2)) + 0.3 * m * dot(z) * dot(w);
        V = m * (z + 0.5 * w * w);
        constraint bowl: z == x * x + 0.5 * y * y;
        constraint slope: w * y == x;
    }
}

/// No pivot may vanish where a single entry of A does: coefficients of a constraint pass through zero along a motion.
#[test]
fn entries_of_the_constraints_may_vanish() {
    let (free, angles) = pendula();
    let quarter = core::f64::consts::FRAC_PI_2;
    for theta in [[0.0, 0.0], [0.0, quarter], [quarter, 0.0], [quarter, quarter], [-quarter, 0.3], [0.4, 0.0]]
    {
        let mut at = cartesian(&angles, &State::new(0.0, theta, [0.3, -0.5]));
        // sin π and cos π/2 are zeros here, not roundings of them.
        at.q.iter_mut().for_each(|x| *x = if x.abs() < 1e-15 { 0.0 } else { *x });
        let accelerations = angles.accel(&SVector::from(theta), &SVector::from([0.3, -0.5]), 0.0);
        let lambda = free.multipliers(&at.q, &at.qd, 0.0);
        let got = free.accel(&at.q, &at.qd, 0.0);
        assert!(lambda.iter().all(|x| x.is_finite()), "{theta:?}: {lambda}");
        // ẍ₀ = l (θ̈ cos θ − θ̇² sin θ)
        let expected = 0.8 * (accelerations[0] * theta[0].cos() - 0.09 * theta[0].sin());
        assert!((got[0] - expected).abs() < 1e-13, "{theta:?}: {} {expected}", got[0]);
    }
    let surface = Surface::new(1.2);
    for q in [[0.0, 0.0, 0.0, 0.7], [0.0, 0.5, 0.125, 0.0], [0.0, 0.0, 0.0, 0.0]] {
        let a = surface.accel(&SVector::from(q), &SVector::from([0.0; 4]), 0.0);
        assert!(a.iter().all(|x| x.is_finite()), "{q:?}: {a}");
        assert!(surface.constraint_jacobian(&SVector::from(q), 0.0).row(1).dot(&a.transpose()).abs() < 1e-14);
    }
}

#[test]
fn jumps_agree() {
    let (free, angles) = pendula();
    let at = State::new(0.0, [0.9, 1.4], [0.3, -0.5]);
    let at_free = cartesian(&angles, &at);
    let blow = SVector::from([0.7, -0.2]);
    let expected = angles.jump(&at, &angles.blow(&at.q, 0.0, &blow));
    let got = free.jump(&at_free, &free.blow(&at_free.q, 0.0, &blow));
    assert!((cartesian(&angles, &expected.after).qd - got.after.qd).amax() < 1e-14);
    assert!((expected.energy - got.energy).abs() < 1e-14);
    let added = angles.energy(&at.q, &expected.after.qd, 0.0) - angles.energy(&at.q, &at.qd, 0.0);
    assert!((expected.energy - added).abs() < 1e-14);
    assert_held(&free, &got.after);
}

/// 10⁴ periods of small oscillations, at each step.
#[test]
#[cfg_attr(not(feature = "long"), ignore = "long")]
fn constraints_hold_for_long() {
    let (free, angles) = pendula();
    let start = cartesian(&angles, &State::new(0.0, [0.2, 0.3], [0.0, 0.0]));
    let period = core::f64::consts::TAU * (angles.l[0] / angles.g).sqrt();
    let run = integrate(&free, DormandPrince5, PiController::tolerance(1e-4), start).until(1e4 * period);
    for step in run {
        assert_held(&free, &step.unwrap().to);
    }
}

/// With constant rates of heading and spin the contact goes round a circle.
#[test]
fn a_disk_rolls_round_a_circle() {
    let disk = Disk::new(1.3, 0.3, 0.06, 0.04);
    let (heading, spin) = (0.7, 2.0);
    let guess = State::new(0.0, [0.0, 0.0, 0.0, 0.0], [0.0, 0.0, heading, spin]);
    // The guess slips; what is nearest does not.
    let start = consistent(&disk, &guess).unwrap();
    assert_held(&disk, &start);
    let (heading, spin) = (start.qd[2], start.qd[3]);
    let radius = disk.a * spin / heading;
    let end =
        integrate(&disk, Dop853, PiController::tolerance(1e-12), start).until(50.0).final_state().unwrap();
    let phi = heading * 50.0;
    let exact = SVector::from([radius * phi.sin(), radius * (1.0 - phi.cos()), phi, spin * 50.0]);
    assert!((end.q - exact).amax() < 1e-9, "{end:?}");
    // The friction turns the momentum: m v φ̇ across the heading.
    let friction = disk.multipliers(&end.q, &end.qd, end.t);
    let across = disk.m * disk.a * spin * heading;
    assert!((friction - SVector::from([-across * phi.sin(), across * phi.cos()])).amax() < 1e-10);
    let kinds = Disk::<f64>::FACTS.constraints.iter().map(|c| c.kind);
    assert!(kinds.eq([ConstraintKind::Nonholonomic; 2]));
    assert_eq!(Disk::<f64>::FACTS.degrees_of_freedom(), 2);
}

/// A constraint that moves does work: the particle slides as by the equation along the plane.
#[test]
fn a_moving_constraint() {
    let incline = Incline::new(0.8, 0.5, 0.2, 3.0);
    let (sin, cos) = incline.alpha.sin_cos();
    let start = consistent(&incline, &State::new(0.0, [0.0; 2], [0.0; 2])).unwrap();
    // Of the carried plane, u = x − a sin ωt = s cos α, with s̈ = −g sin α + a ω² sin ωt cos α.
    let slip = (start.qd[0] - incline.a * incline.omega) / cos;
    let end =
        integrate(&incline, Dop853, PiController::tolerance(1e-12), start).until(2.0).final_state().unwrap();
    let s = slip * 2.0 - incline.g * sin * 2.0
        + incline.a * cos * (incline.omega * 2.0 - (incline.omega * 2.0).sin());
    let x = s * cos + incline.a * (incline.omega * 2.0).sin();
    assert!((end.q[0] - x).abs() < 1e-10 && (end.q[1] - s * sin).abs() < 1e-10, "{end:?} {x} {}", s * sin);
    let facts = Incline::<f64>::FACTS;
    assert_eq!([facts.conservative, facts.scleronomic], [false, false]);
}

#[test]
fn a_start_off_the_constraints_is_refused() {
    let (free, _) = pendula();
    let start = State::new(0.0, [0.1, 0.2, -0.8, -1.4], [0.0; 4]);
    let failed =
        integrate(&free, Dop853, PiController::tolerance(1e-9), start).until(1.0).final_state().unwrap_err();
    assert!(
        matches!(failed.failure, Failure::ConstraintViolated { t: 0.0, constraint: "upper", .. }),
        "{failed}"
    );
    assert!(failed.to_string().contains("the constraint `upper` is violated by"), "{failed}");
    let near = consistent(&free, &start).unwrap();
    assert!(integrate(&free, Dop853, PiController::tolerance(1e-9), near).until(1.0).final_state().is_ok());
}

/// At the pivot the constraint has no gradient, and nothing says where to go.
#[test]
fn no_state_near_a_singular_position() {
    let (free, _) = pendula();
    let nowhere = State::new(0.0, [0.0; 4], [0.0; 4]);
    assert!(matches!(consistent(&free, &nowhere), Err(Failure::ConstraintViolated { .. })));
}

#[test]
fn derivatives_pass_through_the_projection() {
    let (_, angles) = pendula();
    let guess = cartesian(&angles, &State::new(0.0, [0.9, 1.4], [0.3, -0.5]));
    // How the start moves with the length of the upper rod, against a difference quotient.
    let started = |l: Dual<f64>| {
        let free = Cartesian {
            m: [0.7, 0.4].map(Dual::constant),
            l: [l, Dual::constant(0.6)],
            g: Dual::constant(9.81),
        };
        let guess = State {
            t: Dual::constant(0.0),
            q: guess.q.map(Dual::constant),
            qd: guess.qd.map(Dual::constant),
        };
        consistent(&free, &guess).unwrap()
    };
    let slope = started(Dual::variable(0.8)).q.map(|x| x.slope);
    let step = 1e-5;
    let by = |l: f64| started(Dual::constant(l)).q.map(|x| x.value);
    let quotient = (by(0.8 + step) - by(0.8 - step)) / (2.0 * step);
    assert!((slope - quotient).amax() < 1e-8, "{slope} {quotient}");
}

lagrangian! {
    /// A parallelogram of uniform bars: two cranks, and the coupler between them.
    system Parallelogram {
        param g = 9.81;
        coord a0, a1, b;
        let x = cos(a0) + 0.5 * cos(b);
        let y = sin(a0) + 0.5 * sin(b);
        T = (dot(a0).powi(2) + dot(a1).powi(2)) / 6 + 0.5 * (dot(x).powi(2) + dot(y).powi(2)) + dot(b).powi(2) / 24;
        V = g * (0.5 * sin(a0) + 0.5 * sin(a1) + y);
        constraint horizontal: cos(a0) + cos(b) == cos(a1) + 1;
        constraint vertical: sin(a0) + sin(b) == sin(a1);
    }
}

/// From the upright position the parallelogram turns over, and with it passes the two positions in which all bars lie
/// in one line: there its constraints are dependent, and the other branch of their solutions, a0 = 0, begins.
fn turning(rate: f64) -> (Parallelogram, State<f64, 3>) {
    let up = core::f64::consts::FRAC_PI_2;
    (Parallelogram::new(), State::new(0.0, [up, up, 0.0], [rate, rate, 0.0]))
}

/// The angle after the time t: with a0 = a1 and b = 0 it is a pendulum, (5/6) ȧ² + 2 g sin a.
fn turned(rate: f64, t: f64) -> f64 {
    let up = core::f64::consts::FRAC_PI_2;
    lagrange_runtime::testing::reference::SimplePendulum::new(1.2 * 9.81, 1.0, core::f64::consts::PI, rate)
        .state(t)
        .0
        - up
}

/// A run that succeeds is right, at every step; one that fails says that the constraints depend on each other. (What
/// the projection did to a step was without a bound: it lost up to 14 of 20 J with success.)
fn right_or_dependent<M, C>(method: M, controller: C, error: f64)
where
    M: Method<Parallelogram, 3> + core::fmt::Debug,
    C: lagrange_runtime::Controller<f64, 3, M::Error>,
{
    let (system, start) = turning(-1.0);
    let told = format!("{method:?}, {error:e}");
    let mut run = integrate(&system, method, controller, start).until(10.0);
    for step in run.by_ref().map_while(Result::ok) {
        let gained = (system.energy_at(&step.to) - system.energy_at(&start)).abs();
        let off = (step.to.q[0] - turned(-1.0, step.to.t)).abs();
        assert!(gained < error && off < 10.0 * error, "{told}: {gained:e} J and {off:e} at {}", step.to.t);
    }
    match run.final_state() {
        Ok(end) => assert!((end.q[1] - end.q[0]).abs() + end.q[2].abs() < error, "{told}: {end:?}"),
        Err(failed) => {
            let Failure::DependentConstraints { dependence, .. } = failed.failure else {
                panic!("{told}: {failed}")
            };
            assert_eq!(
                (dependence.constraint, dependence.rank, dependence.of),
                ("horizontal", 1, 2),
                "{told}"
            );
            assert!(failed.last.q[0].sin().abs() < 0.03, "{told}: {failed:?}");
        }
    }
}

#[test]
#[cfg_attr(not(feature = "long"), ignore = "long")]
fn constraints_that_become_dependent_are_passed_or_named() {
    // The third was wrong by Verner9.
    for tolerance in [1e-6, 1.234e-7, 7.073332279644438e-9, 3.556480306223121e-9, 1e-10] {
        let (pi, error) = (PiController::tolerance(tolerance), 2e4 * tolerance);
        right_or_dependent(DormandPrince5, pi, error);
        right_or_dependent(Dop853, pi, error);
        right_or_dependent(Verner9, pi, error);
        right_or_dependent(Rodas5P, pi, error);
        right_or_dependent(Taylor, TaylorController::tolerance(tolerance), error);
    }
    for h in [0.01, 0.0073, 0.004] {
        right_or_dependent(Rk4, FixedStep::new(h), 1e4 * f64::powi(h, 4));
    }
}

/// A start in such a position has accelerations along a branch, and none without a velocity: either crank or both may
/// move on.
#[test]
fn a_start_with_dependent_constraints_is_passed_or_named() {
    let system = Parallelogram::new();
    for angle in [0.0, core::f64::consts::PI] {
        let ends = |qd: [f64; 3]| {
            let start = State::new(0.0, [angle, angle, 0.0], qd);
            [
                integrate(&system, Dop853, PiController::tolerance(1e-9), start).until(1.0).final_state(),
                integrate(&system, Radau5, PiController::tolerance(1e-9), start).until(1.0).final_state(),
                integrate(&system, Rk4, FixedStep::new(0.001), start).until(1.0).final_state(),
            ]
        };
        let up = core::f64::consts::FRAC_PI_2;
        let exact =
            lagrange_runtime::testing::reference::SimplePendulum::new(1.2 * 9.81, 1.0, up + angle, 1.0)
                .state(1.0);
        for end in ends([1.0, 1.0, 0.0]).map(Result::unwrap) {
            let off = end.q - SVector::from([exact.0 - up, exact.0 - up, 0.0]);
            assert!(off.amax() < 1e-8, "{off}");
        }
        for failed in ends([0.0; 3]).map(Result::unwrap_err) {
            assert!(matches!(failed.failure, Failure::Bifurcation { t: 0.0, .. }), "{failed}");
        }
    }
}

lagrangian! {
    /// Points on two lines that turn into each other.
    system Lines {
        param m;
        coord x, y, a, free;
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2)) + 0.5 * (dot(a).powi(2) + dot(free).powi(2));
        V = 0;
        constraint level: y == 0;
        constraint slope: y * cos(a) == x * sin(a);
    }
}

/// Neither gradient vanishes, and one follows from the other.
#[test]
fn a_dependence_names_both_constraints() {
    let start = State::new(0.0, [0.0; 4], [0.0, 0.0, 0.0, 1.0]);
    let failed =
        integrate(&Lines::new(1.0), Dop853, PiController::tolerance(1e-9), start).until(1.0).final_state();
    let text = failed.unwrap_err().to_string();
    let [level, slope] = ["`level`", "`slope`"].map(|name| text.contains(name));
    assert!(level && slope && text.contains(" depends on ") && text.contains("rank 1 of 2"), "{text}");
}
