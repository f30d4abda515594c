//! Angular momenta that the compiler finds constant, along runs, and those that it does not, which change.

use lagrange_runtime::prelude::*;
use lagrange_runtime::traits::{CommonSymmetry, Symmetry};

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

lagrangian! {
    /// Two satellites on a spring between points of both, in the field of a centre.
    pub system Tethered {
        param m, A: [3], B: [3], k, w;
        coord x: [3], R: [rotation; 2], y: [3];
        let one = frame(world, x, R[0]);
        let two = frame(world, y, R[1]);
        T = body(m, A, one) + body(2 * m, B, two);
        let string = one.point([0.1, 0.2, 0.1]) - two.point([-0.1, 0, 0.3]);
        V = 0.5 * k * (string.norm_squared().sqrt() - 1).powi(2) - w * m / x.norm_squared().sqrt();
    }
}

lagrangian! {
    /// A body on a rod on a body that flies, with friction in the joint of the rod.
    pub system Slung {
        param m, A: [3], l, g, c;
        coord x: [3], R: rotation, n: direction;
        let hull = frame(world, x, R);
        let bob = hull.point([0, 0.1, 0.2]) + l * n;
        T = body(m, A, hull) + 0.5 * dot(bob).norm_squared();
        V = g * (m * x[2] + bob[2]);
        D = 0.5 * c * dot(hull.vector([1, 0, 0]).dot(n)).powi(2);
    }
}

lagrangian! {
    /// An arm on a body that floats, without weight, and a stone that nothing else knows of.
    pub system Arm {
        param m, A: [3];
        input tau;
        coord stone: [3], x: [3], R: rotation, P: rotation, q: angle;
        let hull = frame(world, x, R);
        let first = frame(hull, [0.3, 0, 0.1], P);
        let second = frame(first, [0, 0, 1], rotation_y(q));
        T = 0.5 * dot(stone).norm_squared() + body(m, A, hull) + body(1, [0.1, 0.2, 0.15], frame(first, [0, 0.1, 0.5]))
            + body(1, [0.1, 0.2, 0.15], frame(second, [0.1, 0, 0.5]));
        V = 0.5 * stone[0].powi(2);
        Q[q] = tau;
    }
}

lagrangian! {
    /// The same kind of body in a wind and at a wall, which know directions of space.
    pub system Blown {
        param m, A: [3], w;
        coord x: [3], R: rotation;
        let hull = frame(world, x, R);
        T = body(m, A, hull);
        V = 0.5 * hull.point([0.3, 0, 0])[2].powi(2);
        D = 0.5 * w * dot(hull.point([0, 0, 0.2])).norm_squared();
        Q[x] = [0, 0, w * hull.vector([1, 0, 0])[2]];
        force [0, w, 0] at hull.point([0, 0.1, 0]);
    }
}

fn together(all: &[CommonSymmetry]) -> Vec<(&[&str], usize)> {
    all.iter().map(|s| (s.turned, s.axis)).collect()
}

fn drawn<const N: usize>() -> State<f64, N> {
    let number = |i: usize| (1.7 * i as f64 + 0.4).sin();
    State { t: 0.0, q: SVector::from_fn(|i, _| number(i)), qd: SVector::from_fn(|i, _| number(i + N)) }
}

#[test]
fn the_compiler_finds_what_turns_together() {
    let control = || PiController::tolerance(1e-12);
    // Both satellites, and not one alone.
    let tethered = Tethered::new(1.5, [1.0, 2.0, 2.5], [0.4, 0.5, 0.3], 2.0, 3.0);
    let all: &[&str] = &["x", "R[0]", "R[1]", "y"];
    assert_eq!(together(Tethered::<f64>::COMMON_SYMMETRIES), [(all, 0), (all, 1), (all, 2)]);
    let momenta = |s: &State<f64, 12>| tethered.common_angular_momenta_at(s);
    let start = drawn::<12>();
    let end = integrate(&tethered, Dop853, control(), start).until(3.0).final_state().unwrap();
    // r × m v and R I ω of both.
    let known = |s: &State<f64, 12>| {
        let part = |v: &SVector<f64, 12>, first: usize| v.fixed_rows::<3>(first).into_owned();
        let own = |i: usize, moments: [f64; 3]| {
            tethered.attitude_R(i, s) * Vec3::from(moments).component_mul(&tethered.angular_velocity_R(i, s))
        };
        part(&s.q, 0).cross(&part(&s.qd, 0)) * 1.5
            + part(&s.q, 9).cross(&part(&s.qd, 9)) * 3.0
            + own(0, tethered.A)
            + own(1, tethered.B)
    };
    assert!((momenta(&start) - known(&start)).norm() < 1e-13);
    assert!((momenta(&end) - momenta(&start)).norm() < 1e-9, "{}", momenta(&end) - momenta(&start));
    assert!((known(&end) - known(&start)).norm() < 1e-9);

    // About the vertical, with the friction between both.
    let slung = Slung::new(1.5, [0.2, 0.3, 0.4], 0.7, 9.81, 0.3);
    assert_eq!(together(Slung::<f64>::COMMON_SYMMETRIES), [(&["x", "R", "n"][..], 2)]);
    let start = slung.with_direction_n(drawn(), &Vec3::new(0.1, 0.5, -0.8), &Vec3::new(1.0, 0.3, 0.0));
    let end = integrate(&slung, Dop853, control(), start).until(2.0).final_state().unwrap();
    let [before, after] = [&start, &end].map(|s| slung.common_angular_momenta_at(s)[0]);
    assert!((after - before).abs() < 1e-9 && before.abs() > 0.1, "{before} {after}");

    // A joint's rotation turns with its parent by itself. A spring leaves the stone one axis.
    let arm = Arm { tau: 0.3, ..Arm::new(2.0, [0.3, 0.5, 0.4]) };
    let hull: &[&str] = &["x", "R"];
    let found = together(Arm::<f64>::COMMON_SYMMETRIES);
    assert_eq!(found, [(&["stone"][..], 0), (hull, 0), (hull, 1), (hull, 2)]);
    let start = drawn::<13>();
    let end = integrate(&arm, Dop853, control(), start).until(2.0).final_state().unwrap();
    let [before, after] = [&start, &end].map(|s| arm.common_angular_momenta_at(s));
    assert!((after - before).norm() < 1e-9, "{before} {after}");

    assert_eq!(together(Blown::<f64>::COMMON_SYMMETRIES), []);
    assert_eq!(
        <lagrange_runtime::traits::Precomputed<Arm, 13> as Lagrangian<13>>::COMMON_SYMMETRIES.len(),
        4
    );
}

lagrangian! {
    /// A symmetric top by the attitude of a frame that spins about its axis: time drops out of the equations.
    system Spun {
        param A, C, w, s;
        coord R: rotation;
        let body_frame = frame(world, [0, 0, 0], R * rotation_z(s * t));
        T = body(1, [A, A, C], body_frame);
        V = w * body_frame.vector([0, 0, 1])[2];
    }
}

lagrangian! {
    /// A satellite with a wheel on a skew mount, aside from its centre of mass.
    system Skew {
        param A, B, C, J, tilt;
        coord R: rotation, spin: angle;
        let hull = frame(world, [0, 0, 0], R);
        let wheel = frame(hull, [0.1, 0.2, 0], rotation([1, 2, 2], tilt) * rotation_z(spin));
        T = body(1, [A, B, C], hull) + body(0.3, [0.5 * J, 0.5 * J, J], wheel);
        V = hull.vector([0, 0, 1])[2];
        pub routhian Gyrostat;
    }
}

/// An angle stands behind a rotation, and its sine and cosine are on a circle. The spin's equation is that of a wheel
/// without a motor, J (ω·a + ṡ) = p about its axis a.
#[test]
fn time_and_spin_drop_out_behind_rotations() {
    let facts = Spun::<f64>::FACTS;
    assert!(facts.autonomous && facts.conservative);
    assert_eq!(Skew::<f64>::FACTS.ignorable, [3]);
    let skew = Skew::new(2.0, 3.0, 4.0, 0.5, 0.4);
    let rest = State::new(0.0, [0.0; 4], [0.0, 0.0, 0.0, 7.0]);
    let turn = UnitQuaternion::new(Vector3::new(0.3, -0.4, 0.9));
    let start = skew.with_attitude_R(rest, &turn, &Vector3::new(0.5, -0.2, 0.3));
    let (gyrostat, reduced) = skew.reduce(&start);
    let controller = || PiController::tolerance(1e-12);
    let whole = integrate(&skew, Dop853, controller(), start).until(3.0).final_state().unwrap();
    let less = integrate(&gyrostat, Dop853, controller(), reduced).until(3.0).final_state().unwrap();
    assert!(skew.attitude_R(&whole).angle_to(&gyrostat.attitude_R(&less)) < 1e-10);
}
