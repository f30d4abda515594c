//! Angular momenta that the compiler finds constant, along runs, and those that it does not, which change.

use lagrange_runtime::prelude::*;
use lagrange_runtime::traits::Symmetry;

type Vec3 = Vector3<f64>;

lagrangian! {
    /// A brick that is thrown: its weight has no moment.
    pub system Brick {
        param m, A, B, C, g;
        coord x: [3], R: rotation;
        let brick = frame(world, x, R);
        T = body(m, [A, B, C], brick);
        V = m * g * x[2];
    }
}

lagrangian! {
    /// A heavy top on its point.
    pub system Top {
        param m, A, C, l, g;
        coord R: rotation;
        let top = frame(world, [0, 0, 0], R);
        T = body(m, [A, A, C], frame(top, [0, 0, l]));
        V = m * g * top.point([0, 0, l])[2];
    }
}

lagrangian! {
    /// The same with friction in the joint about the axis, and a field along x.
    pub system Braked {
        param A, C, w, d;
        coord R: rotation;
        let top = frame(world, [0, 0, 0], R);
        T = body(0, [A, A, C], top);
        V = w * top.vector([0, 0, 1])[0];
        D = 0.5 * d * dot(R)[2].powi(2);
    }
}

lagrangian! {
    /// Two bodies on ball joints.
    pub system Double {
        param g;
        coord R: [rotation; 2];
        let one = frame(world, [0, 0, 0], R[0]);
        let two = frame(one, [0, 0, -1], R[1]);
        T = body(1, [1, 1.2, 0.3], frame(one, [0.1, 0, -0.5])) + body(0.7, [0.6, 0.6, 0.2], frame(two, [0, 0, -0.4]));
        V = g * (one.point([0.1, 0, -0.5])[2] + 0.7 * two.point([0, 0, -0.4])[2]);
    }
}

lagrangian! {
    /// A motor in the joint turns a symmetric body about its axis, against the parent; a couple of the outside acts
    /// along y.
    pub system Driven {
        param A, C, k;
        coord R: rotation;
        let hull = frame(world, [0, 0, 0], R);
        T = body(0, [A, A, C], hull);
        V = 0;
        Q[R] = [0, 0, k];
        force [0, k, 0] at hull.point([1, 0, 0]);
    }
}

lagrangian! {
    /// A narrow well for the axis of a body, which a few states do not show.
    system Narrow {
        param A, B, C, k;
        coord R: rotation;
        let b = frame(world, [0, 0, 0], R);
        T = body(1.0, [A, B, C], b);
        V = k * exp(-1e7 * (b.vector([0, 0, 1])[2] - 0.9).powi(2));
    }
}

lagrangian! {
    /// A nanoparticle in SI units, of which a potential is small beside T.
    system Nano {
        param A, B, C;
        coord R: rotation;
        let b = frame(world, [0, 0, 0], R);
        T = body(1.0, [A, B, C], b);
        V = 1e-14 * b.vector([0, 0, 1])[0];
    }
}

fn resting<const N: usize>() -> State<f64, N> {
    State::new(0.0, [0.0; N], [0.0; N])
}

fn named(all: &[Symmetry]) -> Vec<(&str, usize, bool)> {
    all.iter().map(|s| (s.rotation, s.axis, s.own)).collect()
}

#[test]
fn the_compiler_finds_constant_angular_momenta() {
    let attitude = UnitQuaternion::from_euler_angles(0.4, 1.0, 2.0);
    let omega = Vec3::new(2.0, -3.0, 4.0);
    let control = || PiController::tolerance(1e-12);
    // All three components of the spin, though the brick falls.
    let brick = Brick::new(0.5, 1.0, 2.0, 2.5, 9.81);
    assert_eq!(named(Brick::<f64>::SYMMETRIES), [("R", 0, false), ("R", 1, false), ("R", 2, false)]);
    let mut start = brick.with_attitude_R(resting(), &attitude, &omega);
    start.qd[0] = 3.0;
    let end = integrate(&brick, Dop853, control(), start).until(10.0).final_state().unwrap();
    let momentum = |s: &State<f64, 6>| brick.angular_momentum_R(&s.q, &s.qd, s.t);
    let known = attitude * Vec3::new(2.0, -6.0, 10.0);
    assert!((momentum(&start) - known).norm() < 1e-13, "{}", momentum(&start));
    assert!((momentum(&end) - known).norm() < 1e-9);
    assert_eq!(<lagrange_runtime::traits::Precomputed<Brick, 6> as Lagrangian<6>>::SYMMETRIES.len(), 3);

    // The vertical one, and that about the axis of the top.
    let top = Top::new(0.7, 0.3, 0.2, 0.5, 9.81);
    assert_eq!(named(Top::<f64>::SYMMETRIES), [("R", 2, false), ("R", 2, true)]);
    let start = top.with_attitude_R(resting(), &attitude, &omega);
    let end = integrate(&top, Dop853, control(), start).until(10.0).final_state().unwrap();
    let [before, after] =
        [&start, &end].map(|s| (top.angular_momentum_R(&s.q, &s.qd, s.t), top.attitude_R(s)));
    assert!((before.0.z - after.0.z).abs() < 1e-9 && (before.0.x - after.0.x).abs() > 1e-2);
    let own =
        |(momentum, attitude): (SVector<f64, 3>, UnitQuaternion<f64>)| (attitude.inverse() * momentum).z;
    assert!((own(before) - 0.2 * 4.0).abs() < 1e-13 && (own(after) - 0.2 * 4.0).abs() < 1e-9);

    // Symmetries are proved, and not looked for at states.
    assert_eq!(named(Narrow::<f64>::SYMMETRIES), [("R", 2, false)]);
    assert_eq!(named(Nano::<f64>::SYMMETRIES), [("R", 0, false)]);

    // The component along the field, and none about the axis that friction acts on.
    assert_eq!(named(Braked::<f64>::SYMMETRIES), []);
    // Friction that acts on the hull turns with it, and takes from the momentum in space.
    let braked = Braked::new(0.3, 0.2, 0.5, 0.1);
    let start = braked.with_attitude_R(resting(), &attitude, &omega);
    let end = integrate(&braked, Dop853, control(), start).until(3.0).final_state().unwrap();
    let along = |s: &State<f64, 3>| {
        let w = braked.angular_velocity_R(s);
        (braked.attitude_R(s) * Vec3::new(0.3 * w.x, 0.3 * w.y, 0.2 * w.z)).x
    };
    assert!((along(&end) - along(&start)).abs() > 1e-3);

    // Of a chain the rotation of the first body turns all.
    let double = Double::new(9.81);
    assert_eq!(named(Double::<f64>::SYMMETRIES), [("R[0]", 2, false), ("R[1]", 2, true)]);
    let mut start = double.with_attitude_R(0, resting(), &attitude, &omega);
    start = double.with_attitude_R(1, start, &attitude.inverse(), &-omega);
    let end = integrate(&double, Dop853, control(), start).until(5.0).final_state().unwrap();
    let vertical = |s: &State<f64, 6>| double.angular_momentum_R(&s.q, &s.qd, s.t)[2];
    let own = |s: &State<f64, 6>| {
        let all = double.angular_momentum_R(&s.q, &s.qd, s.t);
        (double.attitude_R(1, s).inverse() * Vec3::new(all[3], all[4], all[5])).z
    };
    assert!((vertical(&end) - vertical(&start)).abs() < 1e-8 && (own(&end) - own(&start)).abs() < 1e-8);

    assert_eq!(named(Driven::<f64>::SYMMETRIES), []);
}
