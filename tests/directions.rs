//! Directions that are coordinates, against closed forms, angles, and rotations.

use lagrange_runtime::prelude::*;

type Vec3 = Vector3<f64>;

lagrangian! {
    /// A spherical pendulum.
    pub system Pendulum {
        param m, l, g = 9.81;
        coord n: direction;
        let bob = l * n;
        T = 0.5 * m * dot(bob).norm_squared();
        V = m * g * bob[2];
        observe place = bob;
        /// The force in the rod, outward positive.
        observe thrust = reaction(n) / l;
        event level: n[2];
    }
}

lagrangian! {
    /// The same by angles, with poles at the top and the bottom.
    pub system ByAngles {
        param m, l, g = 9.81;
        coord theta, phi;
        T = 0.5 * m * l.powi(2) * (dot(theta).powi(2) + (dot(phi) * theta.sin()).powi(2));
        V = m * g * l * theta.cos();
    }
}

fn resting<const N: usize>() -> State<f64, N> {
    State::new(0.0, [0.0; N], [0.0; N])
}

#[test]
fn a_spherical_pendulum_is_that_of_angles() {
    let (pendulum, by_angles) = (Pendulum::new(0.7, 1.3), ByAngles::new(0.7, 1.3));
    let (theta, phi, dtheta, dphi) = (2.0f64, 0.4f64, 1.0, 1.7);
    let n = |theta: f64, phi: f64| Vec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos());
    let across = Vec3::new(-phi.sin(), phi.cos(), 0.0) * theta.sin() * dphi;
    let down = Vec3::new(theta.cos() * phi.cos(), theta.cos() * phi.sin(), -theta.sin()) * dtheta;
    // Of any length, and with a velocity along it that is left out.
    let start =
        pendulum.with_direction_n(resting(), &(n(theta, phi) * 3.0), &(across + down + n(theta, phi) * 5.0));
    assert!((pendulum.direction_n(&start) - n(theta, phi)).norm() < 1e-15);
    let control = || PiController::tolerance(1e-13);
    let known = integrate(&by_angles, Dop853, control(), State::new(0.0, [theta, phi], [dtheta, dphi]));
    let known = known.until(20.0).final_state().unwrap();
    let taylor = (Taylor, TaylorController::tolerance(1e-14));
    let found = [
        integrate(&pendulum, Dop853, control(), start).until(20.0).final_state().unwrap(),
        integrate(&pendulum, taylor.0, taylor.1, start).until(20.0).final_state().unwrap(),
    ];
    for found in found {
        let missed = (pendulum.direction_n(&found) - n(known.q[0], known.q[1])).norm();
        assert!(missed < 1e-9, "{missed:e}");
        assert!((pendulum.direction_n(&found).norm() - 1.0).abs() < 1e-15);
        // m (a·n + g n₃) with a·n = −l ṅ².
        let speed = found.qd.norm_squared();
        let thrust = pendulum.m * (9.81 * found.q[2] - pendulum.l * speed);
        let observed = pendulum.thrust(&found.q, &found.qd, found.t);
        assert!((observed - thrust).abs() < 1e-9, "{observed} {thrust}");
    }
    assert_eq!(Pendulum::<f64>::FACTS.constraints.len(), 1);
    assert_eq!(<Pendulum as Lagrangian<3>>::FACTS.kinds, [CoordinateKind::Direction; 3]);
}

/// Through both poles, where angles end: in the plane the motion is that of a pendulum.
#[test]
fn no_direction_is_special() {
    use lagrange_runtime::testing::reference::SimplePendulum;
    let pendulum = Pendulum::new(1.0, 0.5);
    for heading in [0.0f64, 0.7, 1.6] {
        let (outward, omega) = (Vec3::new(heading.cos(), heading.sin(), 0.0), 10.0);
        let known = SimplePendulum::new(9.81, 0.5, 0.0, omega);
        let start = pendulum.with_direction_n(resting(), &-Vec3::z(), &(outward * omega));
        let run = || integrate(&pendulum, Dop853, PiController::tolerance(1e-13), start).until(10.0);
        let mut turns = 0;
        for sample in run().sample((1..200).map(|k| 0.05 * f64::from(k))) {
            let sample = sample.unwrap();
            let (theta, _) = known.state(sample.t);
            turns = turns.max((theta / core::f64::consts::TAU) as i32);
            let n = outward * theta.sin() - Vec3::z() * theta.cos();
            assert!((pendulum.direction_n(&sample) - n).norm() < 2e-10, "{}", sample.t);
        }
        // It is level twice in each turn.
        let met = run().events(Pendulum::LEVEL).count() as i32;
        assert!(turns > 8 && (met - 2 * turns).abs() <= 2, "{turns} {met}");
    }
}

lagrangian! {
    /// The axis of a symmetric top, whose spin has the angular momentum p: a charge on a sphere in the field of a
    /// monopole, in Lagrange's form.
    pub system Axis {
        param A, p, w, c;
        coord n: direction;
        T = 0.5 * A * dot(n).norm_squared();
        V = w * n[2];
        D = 0.5 * c * dot(n).norm_squared();
        let moment = n.cross(dot(n));
        Q[n] = [p * moment[0], p * moment[1], p * moment[2]];
    }
}

lagrangian! {
    /// The top itself.
    pub system Top {
        param A, C, w;
        coord R: rotation;
        T = body(0, [A, A, C], frame(world, [0, 0, 0], R));
        V = w * (R * [0, 0, 1])[2];
    }
}

/// The axis of a top by a direction is that of the top by a rotation, also through the vertical.
#[test]
fn the_axis_of_a_top_is_a_direction() {
    let (a, c, w, spin) = (0.5, 0.3, 2.0, 9.0);
    let (axis, top) = (Axis::new(a, c * spin, w, 0.0), Top::new(a, c, w));
    for tilt in [0.0, 0.3, 2.5] {
        let attitude = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), tilt);
        let omega = Vec3::new(2.0, -1.0, spin);
        let start = top.with_attitude_R(resting(), &attitude, &omega);
        let n = attitude * Vec3::z();
        let begin = axis.with_direction_n(resting(), &n, &(attitude * omega).cross(&n));
        let control = || PiController::tolerance(1e-13);
        let whole = integrate(&top, Dop853, control(), start).until(8.0).final_state().unwrap();
        let alone = integrate(&axis, Dop853, control(), begin).until(8.0).final_state().unwrap();
        let missed = (axis.direction_n(&alone) - top.attitude_R(&whole) * Vec3::z()).norm();
        assert!(missed < 1e-9, "{missed:e} from {tilt}");
    }
}

lagrangian! {
    /// A chain of rods with masses at their ends.
    pub system Chain {
        const N = 3;
        param m, l, g = 9.81;
        coord n: [direction; N];
        let x: [N] = |i| l * n[i] + if i == 0 { [0, 0, 0] } else { x[i - 1] };
        T = (0..N).map(|i| 0.5 * m * dot(x[i]).norm_squared()).sum();
        V = (0..N).map(|i| m * g * x[i][2]).sum();
        observe thrusts = reaction(n);
    }
}

/// In a plane it is the chain of pendula; the rods carry what hangs on them.
#[test]
fn arrays_of_directions_make_chains() {
    let chain = Chain::new(0.4, 0.6);
    let mut start = resting::<9>();
    for i in 0..3 {
        start = chain.with_direction_n(i, start, &-Vec3::z(), &Vec3::zeros());
        assert_eq!(chain.direction_n(i, &start), -Vec3::z());
    }
    // At rest: λ n = force, so that λ/l = −weight below.
    let thrusts = chain.thrusts(&start.q, &start.qd, 0.0);
    for i in 0..3 {
        let weight = 0.4 * 9.81 * f64::from(3 - i as u8);
        assert!((thrusts[i] / 0.6 + weight).abs() < 1e-12, "{thrusts}");
    }
    for i in 0..3 {
        start = chain.with_direction_n(
            i,
            start,
            &Vec3::new(1.0, 0.5 * i as f64, -0.3),
            &Vec3::new(0.0, 1.0, 3.0),
        );
    }
    let energy = chain.energy_at(&start);
    let moment = |s: &State<f64, 9>| {
        // Of the momenta about the vertical, which nothing changes.
        let (mut x, mut v, mut sum) = (Vec3::zeros(), Vec3::zeros(), 0.0);
        for i in 0..3 {
            x += s.q.fixed_rows::<3>(3 * i) * 0.6;
            v += s.qd.fixed_rows::<3>(3 * i) * 0.6;
            sum += 0.4 * x.cross(&v).z;
        }
        sum
    };
    let before = moment(&start);
    let end =
        integrate(&chain, Dop853, PiController::tolerance(1e-12), start).until(5.0).final_state().unwrap();
    assert!((chain.energy_at(&end) - energy).abs() < 1e-8 && (moment(&end) - before).abs() < 1e-9);
}

#[test]
fn a_start_that_is_no_direction_is_refused() {
    let pendulum = Pendulum::new(1.0, 1.0);
    let bad = State::new(0.0, [0.0, 0.0, 1.1], [0.0; 3]);
    let failed = integrate(&pendulum, Dop853, PiController::tolerance(1e-9), bad).until(1.0).final_state();
    let failure = failed.unwrap_err().failure;
    assert!(matches!(failure, Failure::ConstraintViolated { constraint: "n", .. }), "{failure}");
}

/// Two degrees of freedom: equilibria, their stability and frequencies.
#[test]
fn equilibria_of_directions_have_two_degrees_of_freedom() {
    use lagrange_runtime::analysis::equilibrium;
    let axis = Axis::new(0.5, 0.0, 2.0, 0.1);
    let hanging = equilibrium(&axis, &[0.3, -0.2, -0.9]).unwrap();
    assert!((hanging.q + Vec3::z()).norm() < 1e-12 && hanging.stability.is_stable(), "{hanging:?}");
    let spectrum = hanging.small.spectrum().unwrap();
    assert_eq!(spectrum.eigenvalues.len(), 4);
    // A ζ̈ + c ζ̇ + w ζ = 0, twice.
    let (real, imaginary) = (-0.1, (4.0f64 - 0.01).sqrt());
    for root in spectrum.eigenvalues.iter() {
        assert!((root.re - real).abs() < 1e-9 && (root.im.abs() - imaginary).abs() < 1e-9, "{root}");
    }
    let upright = equilibrium(&axis, &[0.1, 0.05, 0.99]).unwrap();
    assert!((upright.q - Vec3::z()).norm() < 1e-12 && !upright.stability.is_stable());
}

#[test]
fn directions_along_vectors_of_any_length() {
    let start = State::new(0.0, [0.0; 3], [0.0; 3]);
    for length in [1e-300, 1e-200, 1.0, 1e200, 1e300] {
        let along = Vec3::new(2.0, -1.0, 2.0) * length;
        let at = start.with_direction(0, &along, &Vec3::new(1.0, 0.0, 0.0));
        let unit = Vec3::new(2.0, -1.0, 2.0) / 3.0;
        assert!((at.q - unit).norm() < 1e-15, "{length:e} {}", at.q);
        assert!(
            at.qd.dot(&unit).abs() < 1e-15 && (at.qd.norm() - 5f64.sqrt() / 3.0).abs() < 1e-15,
            "{length:e}"
        );
    }
    let none = start.with_direction(0, &Vec3::zeros(), &Vec3::zeros());
    assert!(!none.is_finite());
}

/// A simple pendulum by a direction that stays in the plane y = 0, as its angle from below and the rate of it.
fn in_its_plane<S: Real>([theta, omega]: [S; 2]) -> State<S, 3> {
    let (sine, cosine) = theta.sin_cos();
    let zero = S::zero();
    State { t: zero, q: [sine, zero, -cosine].into(), qd: [omega * cosine, zero, omega * sine].into() }
}

fn angle_and_rate<S: Real>(at: &State<S, 3>) -> [S; 2] {
    let ([x, _, z], [vx, _, vz]): ([S; 3], [S; 3]) = (at.q.into(), at.qd.into());
    [x.atan2(-z), x * vz - z * vx]
}

/// The midpoint rule on constraints: of order 2, and in compositions of order 8; its own inverse; it keeps areas, and
/// with them the energy over any time.
#[test]
fn the_midpoint_rule_on_constraints_is_symplectic() {
    use lagrange_runtime::method::variational::ConstrainedMidpoint;
    use lagrange_runtime::testing::reference::SimplePendulum;
    let (l, g) = (1.0, 9.81);
    let pendulum = Pendulum::new(1.3, l);
    let exact = SimplePendulum::new(g, l, 2.5, 1.0);
    let start = in_its_plane([2.5, 1.0]);
    // Through the lowest point, where angles from the vertical have a pole.
    let missed = |at: State<f64, 3>| {
        let (theta, omega) = exact.state(3.0);
        let [found, rate] = angle_and_rate(&at);
        (found - theta).sin().abs().max((rate - omega).abs())
    };
    let plain = |h: f64| {
        missed(
            integrate(&pendulum, ConstrainedMidpoint, FixedStep::new(h), start)
                .until(3.0)
                .final_state()
                .unwrap(),
        )
    };
    let composed = |h: f64| {
        let method = Compose(ConstrainedMidpoint, KahanLi8);
        missed(integrate(&pendulum, method, FixedStep::new(h), start).until(3.0).final_state().unwrap())
    };
    let (two, eight) = ((plain(4e-3) / plain(2e-3)).log2(), (composed(0.06) / composed(0.03)).log2());
    assert!((two - 2.0).abs() < 0.05 && (eight - 8.0).abs() < 0.6, "{two} {eight}");

    // A step of a sixth of a radian changes areas of angle and rate by rounding.
    let duals = pendulum.map(Dual::constant);
    let slopes = |slope: [f64; 2]| {
        let [theta, omega] = [Dual { value: 2.5, slope: slope[0] }, Dual { value: 1.0, slope: slope[1] }];
        let from = in_its_plane([theta, omega]);
        let memory = ConstrainedMidpoint.start(&duals, &from).unwrap();
        let (step, _) = ConstrainedMidpoint.step(&duals, &memory, &from, Dual::constant(0.1)).unwrap();
        angle_and_rate(&step.to).map(|x| x.slope)
    };
    let [[a, b], [c, d]] = [slopes([1.0, 0.0]), slopes([0.0, 1.0])];
    assert!((a * d - b * c - 1.0).abs() < 1e-13 && (b - c).abs() > 0.1, "{a} {b} {c} {d}");

    // There and back.
    let memory = ConstrainedMidpoint.start(&pendulum, &start).unwrap();
    let (there, memory) = ConstrainedMidpoint.step(&pendulum, &memory, &start, 0.1).unwrap();
    let (back, _) = ConstrainedMidpoint.step(&pendulum, &memory, &there.to, -0.1).unwrap();
    assert!((back.to.q - start.q).amax() < 1e-15 && (back.to.qd - start.qd).amax() < 1e-14);
}

/// A step that is too long has no end, and says so.
#[test]
fn the_midpoint_rule_on_constraints_fails_where_no_end_is_found() {
    use lagrange_runtime::method::variational::ConstrainedMidpoint;
    let pendulum = Pendulum::new(1.3, 1.0);
    let start = in_its_plane([2.5, 40.0]);
    let run = integrate(&pendulum, ConstrainedMidpoint, FixedStep::new(0.5), start).until(10.0);
    let failed = run.final_state().unwrap_err().failure;
    assert!(matches!(failed, Failure::NotConverged { .. }), "{failed:?}");
}

/// In lanes each run has the bits that it has alone, also beside one that fails.
#[test]
fn the_midpoint_rule_on_constraints_runs_in_lanes() {
    use lagrange_runtime::ensemble::{Collect, Ensemble, Table};
    use lagrange_runtime::lanes::{FinalState, Fused};
    use lagrange_runtime::method::variational::ConstrainedMidpoint;
    let draw = |[number]: [u64; 1]| {
        let rate = if number == 4 { 400.0 } else { 0.3 * number as f64 };
        (Pendulum::new(1.3, 1.0), in_its_plane([2.5, rate]))
    };
    let table = Table::new((0..11).map(|number| [number]));
    let study =
        Ensemble::new(table, 11, draw).integrate(ConstrainedMidpoint, FixedStep::new(0.02), 2.0).threads(1);
    let lanes = study.in_lanes(Fused);
    let outcome = lanes.observe(&FinalState(|_: &Pendulum, end: &State<f64, 3>| *end), Collect).unwrap();
    for (index, end) in &outcome.statistic.rows {
        let alone = lanes.replay(*index).unwrap().run().final_state().unwrap();
        assert_eq!(*end, alone.map(|x| x.value()), "sample {index}");
    }
    assert_eq!((outcome.statistic.rows.len(), outcome.failures.count), (10, 1));
}
