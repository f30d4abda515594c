//! An arm of seven axes on a body that floats, against digits (`benches/references/floating_arm.py`), and by its
//! momenta in free fall.

use super::{Vec3, apart, quaternion, resting};
use lagrange_runtime::prelude::*;
use serde_json::Value;

lagrangian! {
    /// The arm of the example `seven_axis_arm` on a body that nothing holds. Torques of the drives are inputs.
    pub system FloatingArm {
        const N = 7;
        param m: [N] = [4.1, 4.0, 3.0, 2.7, 1.7, 1.8, 0.3];
        param M = 30.0, J: [3] = [1.2, 1.5, 1.8], g = 9.81;
        input tau: [N];
        coord x: [3], R: rotation, q: [angle; N];

        let base = frame(world, x, R);
        let up = [0.16, 0.2, 0.2, 0.22, 0.18, 0.22, 0.08, 0.12];
        let link: [N] = |i| frame(
            if i == 0 { base } else { link[i - 1] },
            if i == 0 { [0.1, 0.05, 0.3] } else { [0, 0, up[i]] },
            if i % 2 == 0 { rotation_z(q[i]) } else { rotation_y(q[i]) }
        );
        let centre: [N] = |i| frame(link[i], [0, if i % 2 == 0 { -0.03 } else { 0.03 }, 0.5 * up[i + 1]]);
        let across: [N] = |i| m[i] * (up[i + 1] * up[i + 1] + 3 * 0.06 * 0.06) / 12;
        let along: [N] = |i| 0.5 * m[i] * 0.06 * 0.06;

        T = body(M, J, base) + (0..N).map(|i| body(m[i], [across[i], across[i], along[i]], centre[i])).sum();
        V = g * (M * x[2] + (0..N).map(|i| m[i] * centre[i].origin()[2]).sum());
        Q[q] = tau;

        // Momentum, and angular momentum about the mass centre.
        let whole = M + (0..N).map(|i| m[i]).sum();
        let middle = (M * x + (0..N).map(|i| m[i] * centre[i].origin()).sum()) / whole;
        let aside = x - middle;
        let lever: [N] = |i| centre[i].origin() - middle;
        let w: [N] = |i| angular_velocity(centre[i]);
        observe linear = whole * dot(middle);
        observe angular = M * aside.cross(dot(x)) + base.vector([J[0] * dot(R)[0], J[1] * dot(R)[1], J[2] * dot(R)[2]])
            + (0..N).map(|i| m[i] * lever[i].cross(dot(centre[i].origin()))
                + centre[i].vector([across[i] * w[i][0], across[i] * w[i][1], along[i] * w[i][2]])).sum();
    }
}

/// Numbers of a state of the digits.
fn numbers<const K: usize>(of: &Value, name: &str) -> SVector<f64, K> {
    SVector::from_iterator(of[name].as_array().unwrap().iter().map(|x| x.as_f64().unwrap()))
}

#[test]
fn a_floating_arm_agrees_with_forty_digits() {
    let operations = FloatingArm::<f64>::FACTS.operations;
    assert_eq!([operations.arithmetic(), operations.divisions, operations.sin_cos], [2935, 13, 7]);
    let digits: Value = serde_json::from_str(include_str!("floating_arm.json")).unwrap();
    for of in digits["states"].as_array().unwrap() {
        let arm = FloatingArm { tau: numbers::<7>(of, "tau").into(), ..FloatingArm::new() };
        let attitude = quaternion(numbers::<4>(of, "attitude").into());
        let mut at = arm.with_attitude_R(resting(), &attitude, &numbers(of, "omega"));
        at.q.fixed_rows_mut::<3>(0).copy_from(&numbers::<3>(of, "x"));
        at.q.fixed_rows_mut::<7>(6).copy_from(&numbers::<7>(of, "q"));
        at.qd.fixed_rows_mut::<3>(0).copy_from(&numbers::<3>(of, "v"));
        at.qd.fixed_rows_mut::<7>(6).copy_from(&numbers::<7>(of, "qd"));
        let mut found = arm.accel(&at.q, &at.qd, 0.0);
        // The derivative of ω along the motion.
        let along = |x: &SVector<f64, 13>, rate: &SVector<f64, 13>| {
            SVector::<_, 13>::from_fn(|i, _| Dual { value: x[i], slope: rate[i] })
        };
        let moving: State<Dual<f64>, 13> =
            State { t: Dual::variable(0.0), q: along(&at.q, &at.qd), qd: along(&at.qd, &found) };
        let spin = moving.angular_velocity(3);
        found.fixed_rows_mut::<3>(3).copy_from(&spin.map(|x| x.slope));
        let known = numbers::<13>(of, "accelerations");
        // Those of the base are a hundredth or less of those of the wrist.
        for (first, count) in [(0, 3), (3, 3), (6, 7)] {
            let [found, known] = [&found, &known].map(|all| all.rows(first, count).clone_owned());
            let missed = (&found - &known).amax() / known.amax();
            println!("{missed:e}");
            assert!(missed < 1e-12, "{missed:e}");
        }
    }
}

/// A fall with the drives on: the mass centre falls as a stone, and no drive changes the angular momentum about it.
#[test]
fn a_floating_arm_keeps_its_momenta() {
    let arm = FloatingArm { tau: [0.8, -0.5, 0.4, 0.3, -0.1, 0.05, 0.004], ..FloatingArm::new() };
    let tumbling = UnitQuaternion::from_euler_angles(0.4, 1.0, 2.0);
    let mut start = arm.with_attitude_R(resting(), &tumbling, &Vec3::new(1.5, -2.0, 1.0));
    start.q.fixed_rows_mut::<7>(6).copy_from(&SVector::from([0.3, 0.4, 0.0, 1.1, 0.2, 0.6, 0.0]));
    start.qd[0] = 1.0;
    let mut run = integrate(&arm, Dop853, PiController::tolerance(1e-12), start).until(5.0);
    let (mut missed, mut turned) = ([0.0f64; 2], 0.0f64);
    let (linear, angular) = (arm.linear_at(&start), arm.angular_at(&start));
    let mass = 30.0 + 17.6;
    for step in &mut run {
        let at = step.unwrap().to;
        let fallen = Vec3::new(0.0, 0.0, -mass * 9.81 * at.t);
        missed[0] = missed[0].max((arm.linear_at(&at) - linear - fallen).norm());
        missed[1] = missed[1].max((arm.angular_at(&at) - angular).norm());
        turned = turned.max(apart(&arm.attitude_R(&at), &tumbling));
    }
    println!("{missed:?} of {linear} and {angular}");
    assert!(turned > 3.0, "{turned}");
    assert!(missed[0] < 1e-9 * mass * 9.81 * 5.0 && missed[1] < 1e-9, "{missed:?}");
}
