//! Rigid bodies by their frames: against closed forms, reference digits, other formulations of the same mechanism, and
//! the conservation laws. Systems of the chapter are in `tests/golden`; what frames cost is counted in
//! `lagrange-macros/src/expansion_tests/frames.rs`.

use approx::assert_relative_eq;
use lagrange_runtime::prelude::*;
use lagrange_runtime::testing::reference::jacobi_elliptic;
use lagrange_runtime::traits::rotation;
use nalgebra::{SVector, Vector3};

/// Reproducible numbers in [−1, 1).
fn numbers<const N: usize>(seed: u64) -> SVector<f64, N> {
    let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15);
    SVector::from_fn(|_, _| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    })
}

fn assert_close<const N: usize>(a: &SVector<f64, N>, b: &SVector<f64, N>, relative: f64) {
    let scale = a.amax().max(b.amax());
    assert!((a - b).amax() <= relative * scale, "{a} {b} differ by {:e}", (a - b).amax() / scale);
}

lagrangian! {
    /// A free rigid body: Cartesian place, Euler's angles z-x-z.
    pub system FreeBody {
        param m, A, B, C;
        coord x, y, z, psi, theta, phi;
        let stone = frame(world, [x, y, z], rotation_z(psi) * rotation_x(theta) * rotation_z(phi));
        T = body(m, [A, B, C], stone);
        V = 0;
        observe omega = angular_velocity(stone);
        observe spin = stone.vector([A * angular_velocity(stone)[0], B * angular_velocity(stone)[1], C * angular_velocity(stone)[2]]);
    }
}

/// Euler's equations have the solution ω₁ ~ cn, ω₂ ~ sn, ω₃ ~ dn (Landau and Lifshitz, *Mechanics*, §37, for M² > 2EB).
#[test]
fn a_free_body_turns_by_elliptic_functions() {
    let (a, b, c) = (0.7, 1.1, 1.6);
    let stone = FreeBody::new(2.0, a, b, c);
    let (w1, w3) = (0.6, 1.3);
    let (twice_energy, square) = (a * w1 * w1 + c * w3 * w3, (a * w1) * (a * w1) + (c * w3) * (c * w3));
    assert!(square > twice_energy * b);
    let start = State::new(0.0, [0.1, -0.2, 0.3, 0.0, 1.3, 0.0], [0.5, 0.25, -0.1, 0.0, w1, w3]);
    let spin = stone.spin(&start.q, &start.qd, 0.0);
    for end in [0.7, 2.0, 9.0] {
        let last = integrate(&stone, Dop853, PiController::tolerance(1e-13), start)
            .until(end)
            .final_state()
            .unwrap();
        let rate = ((c - b) * (square - twice_energy * a) / (a * b * c)).sqrt();
        let k = ((b - a) * (twice_energy * c - square) / ((c - b) * (square - twice_energy * a))).sqrt();
        let (sn, cn, dn) = jacobi_elliptic(rate * end, k);
        let size = |x: f64, y: f64, z: f64| (x / (y * z)).sqrt();
        let expected = Vector3::new(
            size(twice_energy * c - square, a, c - a) * cn,
            size(twice_energy * c - square, b, c - b) * sn,
            size(square - twice_energy * a, c, c - a) * dn,
        );
        assert_close(&stone.omega(&last.q, &last.qd, end), &expected, 1e-10);
        // The mass centre goes straight on, and the angular momentum stays in the world.
        assert_relative_eq!(last.q[0], 0.1 + 0.5 * end, max_relative = 1e-12);
        let after = stone.spin(&last.q, &last.qd, end);
        assert_close(&after, &spin, 1e-10);
    }
}

lagrangian! {
    /// A gyroscope in gimbals: an outer ring about the vertical, an inner ring about a horizontal axis, and the rotor.
    pub system Gyroscope {
        param J, a: [3], A, C, mu;
        coord psi, theta, phi;
        let outer = frame(world, [0, 0, 0], rotation_z(psi));
        let inner = frame(outer, [0, 0, 0], rotation_x(theta));
        let rotor = frame(inner, [0, 0, 0], rotation_z(phi));
        T = body(1, [0.1, 0.2, J], outer) + body(2, a, inner) + body(3, [A, A, C], rotor);
        V = 0;
        couple [0, 0, mu] on rotor;
        couple [0, 0, -mu] on inner;
    }
}

lagrangian! {
    /// The same by its angular velocities.
    pub system GyroscopeByAngles {
        param J, a: [3], A, C, mu;
        coord psi, theta, phi;
        T = 0.5 * J * dot(psi).powi(2)
            + 0.5 * (a[0] + A) * dot(theta).powi(2)
            + 0.5 * (a[1] + A) * (dot(psi) * sin(theta)).powi(2)
            + 0.5 * a[2] * (dot(psi) * cos(theta)).powi(2)
            + 0.5 * C * (dot(phi) + dot(psi) * cos(theta)).powi(2);
        V = 0;
        Q[phi] = mu;
    }
}

#[test]
fn a_gyroscope_in_gimbals_is_that_of_its_angles() {
    let (frames, angles) = (
        Gyroscope::new(0.4, [0.1, 0.15, 0.2], 0.3, 0.5, 0.7),
        GyroscopeByAngles::new(0.4, [0.1, 0.15, 0.2], 0.3, 0.5, 0.7),
    );
    for seed in 0..20 {
        let (q, qd) = (3.0 * numbers::<3>(seed), 4.0 * numbers::<3>(seed + 100));
        assert_close(&frames.accel(&q, &qd, 0.0), &angles.accel(&q, &qd, 0.0), 1e-13);
        assert_close(&frames.momenta(&q, &qd, 0.0), &angles.momenta(&q, &qd, 0.0), 1e-14);
        assert_relative_eq!(frames.energy(&q, &qd, 0.0), angles.energy(&q, &qd, 0.0), max_relative = 1e-14);
    }
    let [a, b] = [Gyroscope::<f64>::FACTS.ignorable, GyroscopeByAngles::<f64>::FACTS.ignorable];
    assert_eq!(a, b);
}

lagrangian! {
    /// Two masses on light rods, each by its inclination and azimuth; the second frame stands at a point of the first.
    pub system DoubleSpherical {
        param m: [2], l: [2], g = 9.81;
        coord th: [2], ph: [2];
        let upper = frame(world, [0, 0, 0], rotation_z(ph[0]) * rotation_y(-th[0]));
        let knee = frame(upper, [0, 0, -l[0]]);
        let lower = frame(world, knee.origin(), rotation_z(ph[1]) * rotation_y(-th[1]));
        let tip = frame(lower, [0, 0, -l[1]]);
        T = particle(m[0], knee) + particle(m[1], tip);
        V = m[0] * g * knee.origin()[2] + m[1] * g * tip.origin()[2];
        impulse blow at tip.origin();
    }
}

lagrangian! {
    /// The same by the positions of the masses.
    pub system DoubleSphericalByPositions {
        param m: [2], l: [2], g = 9.81;
        coord th: [2], ph: [2];
        let x: [2] = |i| (0..i + 1).map(|j| l[j] * th[j].sin() * ph[j].cos()).sum();
        let y: [2] = |i| (0..i + 1).map(|j| l[j] * th[j].sin() * ph[j].sin()).sum();
        let z: [2] = |i| (0..i + 1).map(|j| -l[j] * th[j].cos()).sum();
        T = (0..2).map(|i| 0.5 * m[i] * (dot(x[i]).powi(2) + dot(y[i]).powi(2) + dot(z[i]).powi(2))).sum();
        V = (0..2).map(|i| m[i] * g * z[i]).sum();
        impulse blow at [x[1], y[1], z[1]];
    }
}

#[test]
fn a_double_pendulum_in_space_is_that_of_its_positions() {
    let frames = DoubleSpherical::new([1.3, 0.7], [0.6, 0.9]);
    let positions = DoubleSphericalByPositions::new([1.3, 0.7], [0.6, 0.9]);
    for seed in 0..20 {
        let mut q = numbers::<4>(seed);
        // Away from the poles, where the azimuth has no inertia.
        q[0] = 1.2 + 0.7 * q[0];
        q[1] = 1.4 + 0.7 * q[1];
        let qd = 2.0 * numbers::<4>(seed + 100);
        assert_close(&frames.accel(&q, &qd, 0.0), &positions.accel(&q, &qd, 0.0), 1e-12);
        assert_close(&frames.momenta(&q, &qd, 0.0), &positions.momenta(&q, &qd, 0.0), 1e-14);
        let blow = Vector3::new(0.3, -0.1, 0.2);
        assert_close(&frames.blow(&q, 0.0, &blow), &positions.blow(&q, 0.0, &blow), 1e-14);
    }
}

lagrangian! {
    /// Six hinges about y and x in turn, with bodies off the axes. The digits are those of `hinges.json`.
    pub system Hinges {
        const N = 6;
        param m: [N], g = 9.81;
        coord theta: [N];
        let link: [N] = |i| frame(
            if i == 0 { world } else { link[i - 1] },
            if i == 0 { [0, 0, 0] } else { [0.3, 0.2, -1] },
            if i % 2 == 0 { rotation_y(theta[i]) } else { rotation_x(theta[i]) }
        );
        let centre: [N] = |i| frame(link[i], [0.1 + 0.05 * i, -0.2 + 0.03 * i, -0.5 + 0.02 * i]);
        T = (0..N).map(|i| body(m[i], [0.3 + 0.1 * i, 0.4, 0.35 + 0.04 * i], centre[i])).sum();
        V = (0..N).map(|i| m[i] * g * centre[i].origin()[2]).sum();
    }
}

#[test]
fn hinges_agree_with_fifty_digits_and_with_pinocchio() {
    let chain = Hinges::new([1.0, 1.25, 1.5, 1.75, 2.0, 2.25]);
    let digits: serde_json::Value = serde_json::from_str(include_str!("frames/hinges.json")).unwrap();
    for state in digits["states"].as_array().unwrap() {
        let vector = |name: &str| -> SVector<f64, 6> {
            SVector::from_iterator(state[name].as_array().unwrap().iter().map(|x| x.as_f64().unwrap()))
        };
        let qdd = chain.accel(&vector("q"), &vector("qd"), 0.0);
        assert_close(&qdd, &vector("qdd"), 1e-13);
        assert_close(&qdd, &vector("pinocchio"), 1e-13);
    }
}

/// E = T + V along a tumbling motion, in which the chain turns over.
#[test]
fn hinges_keep_their_energy() {
    let chain = Hinges::new([1.0, 1.25, 1.5, 1.75, 2.0, 2.25]);
    let start = State::new(0.0, [2.0, -1.0, 0.5, 1.0, -0.7, 0.3], [0.5, 0.0, -1.0, 0.0, 2.0, 0.0]);
    let energy = |s: &State<f64, 6>| chain.energy(&s.q, &s.qd, s.t);
    let end =
        integrate(&chain, Dop853, PiController::tolerance(1e-12), start).until(5.0).final_state().unwrap();
    let scale = chain.kinetic(&end.q, &end.qd, 5.0).abs().max(chain.potential(&end.q, 5.0).abs());
    assert!((energy(&end) - energy(&start)).abs() < 1e-9 * scale, "{}", energy(&end) - energy(&start));
}

lagrangian! {
    /// A lever on a turntable whose motion is given, and the moment that this takes.
    pub system Turntable {
        param m, a, b, w, g = 9.81;
        coord th;
        coord phi = w * t + 0.2 * sin(t);
        let table = frame(world, [0, 0, 0], rotation_z(phi));
        let lever = frame(table, [a, 0, 0], rotation_y(th));
        let end = frame(lever, [0, 0.1, -b]);
        T = body(m, [0.1, 0.2, 0.15], end) + body(1, [0.3, 0.3, 0.5], table);
        V = m * g * end.origin()[2];
        D = 0.05 * dot(th).powi(2);
        observe moment = reaction(phi);
        observe second = dot(phi);
    }
}

lagrangian! {
    /// The same with the turntable free under a couple.
    pub system FreeTurntable {
        param m, a, b, M, g = 9.81;
        coord th, phi;
        let table = frame(world, [0, 0, 0], rotation_z(phi));
        let lever = frame(table, [a, 0, 0], rotation_y(th));
        let end = frame(lever, [0, 0.1, -b]);
        T = body(m, [0.1, 0.2, 0.15], end) + body(1, [0.3, 0.3, 0.5], table);
        V = m * g * end.origin()[2];
        D = 0.05 * dot(th).powi(2);
        couple [0, 0, M] on table;
    }
}

/// The reaction at a prescribed angle is the couple that gives a free turntable the same motion.
#[test]
fn a_prescribed_frame_needs_the_couple_that_moves_it() {
    let (m, a, b, w) = (1.4, 0.3, 0.8, 2.0);
    let given = Turntable::new(m, a, b, w);
    for seed in 0..10 {
        let (q, qd) = (numbers::<1>(seed), 3.0 * numbers::<1>(seed + 50));
        let t = 0.3 * seed as f64;
        let free = FreeTurntable::new(m, a, b, given.moment(&q, &qd, t));
        let (phi, rate) = (w * t + 0.2 * t.sin(), w + 0.2 * t.cos());
        let (both, rates) = (SVector::from([q[0], phi]), SVector::from([qd[0], rate]));
        let expected = SVector::from([given.accel(&q, &qd, t)[0], -0.2 * t.sin()]);
        assert_close(&free.accel(&both, &rates, t), &expected, 1e-12);
    }
}

lagrangian! {
    /// A closed loop in space (RSSR): crank and rocker with perpendicular axes, and a coupler on ball joints as a
    /// body of its own with six coordinates, of which the spin about its line is free.
    pub system SpatialFourBar {
        param g = 9.81;
        coord a, b, x, y, z, psi, theta, phi;
        let crank = frame(world, [0, 0, 0], rotation_z(a));
        let rocker = frame(world, [1.2, 0.9, 0], rotation_x(b));
        let coupler = frame(world, [x, y, z], rotation_z(psi) * rotation_x(theta) * rotation_y(phi));
        let pin = crank.point([0.3, 0, 0.1]);
        let ball = rocker.point([0, 0, 0.8]);
        T = body(0.5, [0.02, 0.03, 0.04], frame(crank, [0.15, 0, 0.05])) + body(1, [0.1, 0.02, 0.1], coupler)
            + body(0.7, [0.05, 0.05, 0.01], frame(rocker, [0, 0, 0.4]));
        V = g * (z + 0.7 * rocker.point([0, 0, 0.4])[2]);
        constraint first: coupler.point([0, -0.6, 0]) == pin;
        constraint second: coupler.point([0, 0.6, 0]) == ball;
        observe gap = ball - pin;
    }
}

lagrangian! {
    /// The same without a coupler of its own: its length is the one constraint, and its kinetic energy that of the
    /// velocities of its ends, as it is slender and does not spin: T = ½ m |(u + v)/2|² + ½ I |(v − u)/l|².
    pub system FourBarByItsLength {
        param g = 9.81;
        coord a, b;
        let p = [0.3 * cos(a), 0.3 * sin(a), 0.1];
        let r = [1.2, 0.9 - 0.8 * sin(b), 0.8 * cos(b)];
        let c = [p[0] + r[0], p[1] + r[1], p[2] + r[2]];
        let d = [r[0] - p[0], r[1] - p[1], r[2] - p[2]];
        T = 0.5 * (0.04 + 0.5 * 0.15 * 0.15) * dot(a).powi(2) + 0.5 * (0.05 + 0.7 * 0.16) * dot(b).powi(2)
            + 0.125 * (dot(a).powi(2) * 0.09 + 2 * (-0.3 * sin(a) * dot(a) * 0 + 0.3 * cos(a) * dot(a) * (-0.8 * cos(b) * dot(b)))
                + 0.64 * dot(b).powi(2))
            + 0.5 * 0.1 / 1.44 * (0.09 * dot(a).powi(2) + 0.64 * dot(b).powi(2)
                - 2 * (0.3 * cos(a) * dot(a) * (-0.8 * cos(b) * dot(b))));
        V = g * (0.5 * c[2] + 0.7 * 0.4 * cos(b));
        constraint length: d[0] * d[0] + d[1] * d[1] + d[2] * d[2] == 1.44;
    }
}

/// Six-coordinate coupler on ball joints against the scalar constraint on its length, and conservation along a run.
#[test]
fn a_spatial_four_bar_is_that_of_its_length() {
    let (loose, short) = (SpatialFourBar::new(), FourBarByItsLength::new());
    // The rocker where the crank stands at 0.4, by the length of the coupler.
    let crank: f64 = 0.4;
    let length = |b: f64| {
        let d = Vector3::new(
            1.2 - 0.3 * crank.cos(),
            0.9 - 0.8 * b.sin() - 0.3 * crank.sin(),
            0.8 * b.cos() - 0.1,
        );
        d.norm_squared() - 1.44
    };
    let (mut low, mut high) = (-0.5, 1.2);
    assert!(length(low) * length(high) < 0.0);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if length(low) * length(middle) <= 0.0 { high = middle } else { low = middle }
    }
    let guess = State::new(0.0, [crank, low], [1.5, 0.0]);
    let short_start = consistent(&short, &guess).unwrap();
    let (q, qd) = (short_start.q, short_start.qd);
    // Mass centre and direction of the coupler.
    let p = Vector3::new(0.3 * q[0].cos(), 0.3 * q[0].sin(), 0.1);
    let r = Vector3::new(1.2, 0.9 - 0.8 * q[1].sin(), 0.8 * q[1].cos());
    let u = Vector3::new(-0.3 * q[0].sin(), 0.3 * q[0].cos(), 0.0) * qd[0];
    let v = Vector3::new(0.0, -0.8 * q[1].cos(), -0.8 * q[1].sin()) * qd[1];
    let (centre, along) = (0.5 * (p + r), (r - p) / 1.2);
    // y' = Rz Rx e_y = (−sψ cθ, cψ cθ, sθ).
    let theta = along[2].asin();
    let psi = (-along[0]).atan2(along[1]);
    // Angular velocity without spin, ω = d × ḋ: components in Euler's rates of z-x-y at φ = 0.
    let omega = along.cross(&((v - u) / 1.2));
    let x_axis = Vector3::new(psi.cos(), psi.sin(), 0.0);
    let theta_dot = omega.dot(&x_axis);
    // ψ̇ cos θ is the component along z' = Rz Rx e_z.
    let z_axis = x_axis.cross(&along);
    let psi_dot = omega.dot(&z_axis) / theta.cos();
    let phi_dot = -psi_dot * theta.sin();
    let w = 0.5 * (u + v);
    let start = State::new(
        0.0,
        [q[0], q[1], centre[0], centre[1], centre[2], psi, theta, 0.0],
        [qd[0], qd[1], w[0], w[1], w[2], psi_dot, theta_dot, phi_dot],
    );
    let (many, few) = (loose.accel(&start.q, &start.qd, 0.0), short.accel(&q, &qd, 0.0));
    assert_close(&SVector::from([many[0], many[1]]), &few, 1e-12);

    let end =
        integrate(&loose, Dop853, PiController::tolerance(1e-11), start).until(3.0).final_state().unwrap();
    let same = integrate(&short, Dop853, PiController::tolerance(1e-11), short_start)
        .until(3.0)
        .final_state()
        .unwrap();
    assert_close(&SVector::from([end.q[0], end.q[1]]), &same.q, 1e-8);
    let energy = |s: &State<f64, 8>| loose.energy(&s.q, &s.qd, s.t);
    assert!((energy(&end) - energy(&start)).abs() < 1e-8, "{}", energy(&end) - energy(&start));
    let gap: Vector3<f64> = loose.gap(&end.q, &end.qd, 3.0);
    assert_relative_eq!(gap.norm(), 1.2, max_relative = 1e-12);
}

lagrangian! {
    /// Forces on a body in its own axes and in those of the world, and a couple.
    pub system Pushed {
        param f: [3], M: [3];
        coord x, y, z, psi, theta, phi;
        let ship = frame(world, [x, y, z], rotation_z(psi) * rotation_y(theta) * rotation_x(phi));
        T = body(2, [0.5, 0.7, 0.9], ship);
        V = 0;
        force f at frame(ship, [0.3, -0.2, 0.1]);
        couple M on ship;
    }
}

lagrangian! {
    /// The same force in the axes of the world at the same point; the couple as two forces of a pair for each axis.
    pub system PushedInTheWorld {
        param f: [3], M: [3];
        coord x, y, z, psi, theta, phi;
        let ship = frame(world, [x, y, z], rotation_z(psi) * rotation_y(theta) * rotation_x(phi));
        T = body(2, [0.5, 0.7, 0.9], ship);
        V = 0;
        force ship.vector(f) at ship.point([0.3, -0.2, 0.1]);
        force ship.vector([0, 0, 0.5 * M[0]]) at ship.point([0, 1, 0]);
        force ship.vector([0, 0, -0.5 * M[0]]) at ship.point([0, -1, 0]);
        force ship.vector([0.5 * M[1], 0, 0]) at ship.point([0, 0, 1]);
        force ship.vector([-0.5 * M[1], 0, 0]) at ship.point([0, 0, -1]);
        force ship.vector([0, 0.5 * M[2], 0]) at ship.point([1, 0, 0]);
        force ship.vector([0, -0.5 * M[2], 0]) at ship.point([-1, 0, 0]);
    }
}

#[test]
fn forces_are_the_same_in_all_axes() {
    let (own, world) = (
        Pushed::new([0.4, -0.7, 1.1], [0.2, 0.5, -0.3]),
        PushedInTheWorld::new([0.4, -0.7, 1.1], [0.2, 0.5, -0.3]),
    );
    for seed in 0..10 {
        let (q, qd) = (numbers::<6>(seed), 2.0 * numbers::<6>(seed + 10));
        assert_close(&own.accel(&q, &qd, 0.0), &world.accel(&q, &qd, 0.0), 1e-13);
        assert_close(&own.momentum_rate(&q, &qd, 0.0), &world.momentum_rate(&q, &qd, 0.0), 1e-13);
        assert_relative_eq!(own.power(&q, &qd, 0.0), world.power(&q, &qd, 0.0), max_relative = 1e-12);
    }
}

lagrangian! {
    /// A skate on an inclined plane, whose blade does not slip across: a constraint on a velocity in own axes.
    pub system Skate {
        param m, I, alpha, g = 9.81;
        coord x, y, phi;
        let skate = frame(world, [x, y, 0], rotation_z(phi));
        T = body(m, [I, I, I], skate) + particle(m, frame(skate, [0, 0, 0.5]));
        V = -2 * m * g * sin(alpha) * skate.point([0, 0, 0.5])[0];
        constraint blade: velocity(skate)[1] == 0;
        observe grip = reaction(blade);
    }
}

/// x = g sin α sin² φ/(2 φ̇²) from a start at rest in x and y (see `lagrangian!`), and the force across that keeps it
/// turning: 2 m (v φ̇ + g sin α sin φ).
#[test]
fn a_skate_glides_along_its_axis() {
    let (m, alpha, rate) = (1.0, 0.3, 2.0);
    let skate = Skate::new(m, 0.2, alpha);
    let start = State::new(0.0, [0.0; 3], [0.0, 0.0, rate]);
    let end =
        integrate(&skate, Dop853, PiController::tolerance(1e-12), start).until(3.0).final_state().unwrap();
    let phi: f64 = rate * 3.0;
    let pull = 9.81 * alpha.sin();
    assert_relative_eq!(end.q[0], pull * phi.sin().powi(2) / (2.0 * rate * rate), max_relative = 1e-9);
    let speed = pull * phi.sin() / rate;
    let grip = 2.0 * m * (speed * rate + pull * phi.sin());
    assert_relative_eq!(skate.grip(&end.q, &end.qd, 3.0), grip, max_relative = 1e-9);
}

lagrangian! {
    /// A ball that rolls on a plane: velocity-level constraints by the velocity of the lowest point.
    pub system RollingBall {
        param m, a, f;
        coord x, y, psi, theta, phi;
        let ball = frame(world, [x, y, a], rotation_z(psi) * rotation_x(theta) * rotation_z(phi));
        let spin = ball.vector(angular_velocity(ball));
        T = body(m, [0.4 * m * a * a, 0.4 * m * a * a, 0.4 * m * a * a], ball);
        V = 0;
        force [f, 0, 0] at ball.origin();
        constraint rolling: [dot(x), dot(y)] == [a * spin[1], -a * spin[0]];
    }
}

/// A homogeneous ball accelerates as if it were heavier by two fifths: ẍ = 5 f/7 m.
#[test]
fn a_ball_rolls() {
    let (m, a, f) = (1.3, 0.4, 0.9);
    let ball = RollingBall::new(m, a, f);
    assert_eq!(RollingBall::<f64>::FACTS.constraints[0].kind, ConstraintKind::Nonholonomic);
    let start = State::new(0.0, [0.0, 0.0, 0.2, 1.1, -0.3], [0.0, 0.0, 0.7, -0.4, 0.5]);
    let start = consistent(&ball, &start).unwrap();
    let qdd = ball.accel(&start.q, &start.qd, 0.0);
    assert_relative_eq!(qdd[0], 5.0 * f / (7.0 * m), max_relative = 1e-13);
    assert!(qdd[1].abs() < 1e-13);
}

/// In lanes each of the samples has the bits of its run alone, whatever their number and whichever of them fail.
#[test]
fn hinges_in_lanes_are_hinges_alone() {
    use lagrange_runtime::ensemble::{Collect, Ensemble, Table};
    use lagrange_runtime::lanes::{FinalState, Fused, Level};
    const END: f64 = 0.3;
    let draw = |[number, fails]: [u64; 2]| {
        let masses = [0.0, 0.25, 0.5, 0.75, 1.0, 1.25].map(|m| 1.0 + m + 0.01 * number as f64);
        let g = if fails == 1 { f64::NAN } else { 9.81 };
        // One begins at the end.
        let t = if number % 5 == 3 { END } else { 0.0 };
        (Hinges { g, ..Hinges::new(masses) }, State { t, q: numbers(number), qd: numbers(number + 100) })
    };
    for n in 1..=19u64 {
        for pattern in [0, 1 << (n - 1), 0b1001_1010_0110_1011_0101] {
            let table = Table::new((0..n).map(|number| [number, pattern >> number & 1]));
            let study =
                || Ensemble::new(table.clone(), n, draw).integrate(Rk4, FixedStep::new(0.03), END).threads(1);
            for level in Level::compiled() {
                let lanes = study().in_lanes(Fused).level(level);
                let last = FinalState(|_: &Hinges, end: &State<f64, 6>| (end.q[0], end.qd[5]));
                let outcome = lanes.observe(&last, Collect).expect("a sound study");
                let mut good = outcome.statistic.rows.iter();
                let mut failed = outcome.failures.kept.iter();
                for index in 0..n {
                    match lanes.replay(index).expect("a sample").run().final_state() {
                        Ok(end) => {
                            let end = (end.q[0].value(), end.qd[5].value());
                            assert_eq!(good.next(), Some(&(index, end)), "{n} samples, {level:?}");
                        }
                        Err(_) => {
                            assert_eq!(failed.next().map(|f| f.index), Some(index), "{n} samples, {level:?}")
                        }
                    }
                }
                assert!(good.next().is_none() && failed.next().is_none());
                // One that begins at its end needs no accelerations.
                let short = |number: u64| number % 5 == 3;
                let fails = (0..n).filter(|number| pattern >> number & 1 == 1 && !short(*number)).count();
                assert_eq!(outcome.failures.count, fails as u64);
            }
        }
    }
}

macro_rules! mounted {
    ($name:ident, $($mount:tt)*) => {
        lagrangian! {
            /// A bent link on a hinge, on a mount that is set up at an angle.
            pub system $name {
                param m, g = 9.81;
                $($mount)*
                coord a: angle, b: angle;
                let link = frame(world, [0.1, -0.2, 0.3], mount * rotation_z(a));
                let end = frame(link, [0.4, 0, 0], mount.inverse() * rotation_x(b));
                T = body(m, [0.1, 0.2, 0.25], link) + body(0.5 * m, [0.03, 0.02, 0.01], frame(end, [0, 0.2, 0.1]));
                V = m * g * (0.5 * end.point([0, 0.2, 0.1])[2] + link.point([0.1, 0, 0.1])[2]);
            }
        }
    };
}

mounted!(ByParameter, param mount: rotation;);
mounted!(
    ByNumbers,
    let mount = rotation([
        [0.6, -4.0 / 13.0, 9.6 / 13.0],
        [0.8, 3.0 / 13.0, -7.2 / 13.0],
        [0, 12.0 / 13.0, 5.0 / 13.0],
    ]);
);

/// Rows of the mount, turned by an angle about the first of its axes.
fn mount<S: Real>(angle: S) -> [[S; 3]; 3] {
    let number = S::from_f64;
    let rows =
        [[0.6, -4.0 / 13.0, 9.6 / 13.0], [0.8, 3.0 / 13.0, -7.2 / 13.0], [0.0, 12.0 / 13.0, 5.0 / 13.0]];
    let (s, c) = (angle.sin(), angle.cos());
    rows.map(|[x, y, z]| [number(x), number(y) * c + number(z) * s, number(z) * c - number(y) * s])
}

/// A rotation that is a parameter is the same as by numbers, and has derivatives.
#[test]
fn a_mount_by_a_matrix_of_parameters() {
    let one = ByParameter::new(1.3, rotation::by_matrix(&mount(0.0)).unwrap());
    let other = ByNumbers::new(1.3);
    for seed in 0..50 {
        let at = numbers::<4>(seed);
        let (q, qd) = (SVector::from([at[0], at[1]]), SVector::from([at[2], at[3]]));
        assert_close(&one.accel(&q, &qd, 0.0), &other.accel(&q, &qd, 0.0), 1e-13);
        let [a, b] = [one.energy(&q, &qd, 0.0), other.energy(&q, &qd, 0.0)];
        assert!((a - b).abs() < 1e-13 * (1.0 + b.abs()), "{a} {b}");
    }
    let (q, qd) = (SVector::from([0.4, -0.9]), SVector::from([1.1, 0.7]));
    let at =
        |angle: f64| ByParameter::new(1.3, rotation::by_matrix(&mount(angle)).unwrap()).accel(&q, &qd, 0.0);
    let turned = rotation::by_matrix(&mount(Dual::variable(0.2))).unwrap();
    let dual = ByParameter { m: Dual::constant(1.3), g: Dual::constant(9.81), mount: turned };
    let slope = dual.accel(&q.map(Dual::constant), &qd.map(Dual::constant), Dual::constant(0.0));
    let quotient = (at(0.2 + 1e-5) - at(0.2 - 1e-5)) / 2e-5;
    assert_close(&slope.map(|x| x.slope), &quotient, 1e-8);
    let mut rows = mount(0.0);
    rows[0][0] += 1e-9;
    assert!(matches!(rotation::by_matrix(&rows), Err(rotation::NotARotation::NotOrthonormal { .. })));
}
