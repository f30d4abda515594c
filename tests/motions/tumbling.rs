//! Rotations that are coordinates together with all else that a system can have: against an integrator of quaternions
//! that is written by hand, and against closed forms.

use lagrange_runtime::prelude::*;
use lagrange_runtime::traits::InputJacobian;
use lagrange_runtime::{Impulsive, Inputs, Stepper};

type Vec3 = Vector3<f64>;

/// y at `end` by Gragg's midpoint rule with extrapolation to the order 16.
fn by_hand<const K: usize>(
    rate: &dyn Fn(f64, &SVector<f64, K>) -> SVector<f64, K>,
    mut y: SVector<f64, K>,
    [from, end]: [f64; 2],
) -> SVector<f64, K> {
    let count = ((end - from).abs() / 0.05).ceil().max(1.0);
    let whole = (end - from) / count;
    for step in 0..count as u32 {
        let t = from + whole * f64::from(step);
        let mut row: Vec<SVector<f64, K>> = Vec::new();
        for i in 1..=8 {
            let h = whole / f64::from(2 * i);
            let (mut before, mut now) = (y, y + rate(t, &y) * h);
            for k in 1..2 * i {
                (before, now) = (now, before + rate(t + h * f64::from(k), &now) * (2.0 * h));
            }
            let mut next = vec![(before + now + rate(t + whole, &now) * h) * 0.5];
            for (k, above) in (1..i).zip(&row) {
                let ratio = f64::from(i) / f64::from(i - k);
                let last = next[next.len() - 1];
                next.push(last + (last - above) / (ratio * ratio - 1.0));
            }
            row = next;
        }
        y = row[row.len() - 1];
    }
    y
}

/// The vector that a quaternion w, x, y, z takes v to.
fn turned(q: [f64; 4], v: Vec3) -> Vec3 {
    let [w, u] = [Vec3::repeat(q[0]), Vec3::new(q[1], q[2], q[3])];
    let t = u.cross(&v) * 2.0;
    v + w.component_mul(&t) + u.cross(&t)
}

/// The quaternion that turns back.
fn back([w, x, y, z]: [f64; 4]) -> [f64; 4] {
    [w, -x, -y, -z]
}

/// ½ q ω
fn quaternion_rate([w, x, y, z]: [f64; 4], omega: Vec3) -> [f64; 4] {
    let [a, b, c] = [omega.x, omega.y, omega.z].map(|x| x / 2.0);
    [-x * a - y * b - z * c, w * a + y * c - z * b, w * b + z * a - x * c, w * c + x * b - y * a]
}

/// The angle between an attitude and a quaternion.
fn apart(a: &UnitQuaternion<f64>, b: [f64; 4]) -> f64 {
    let b = UnitQuaternion::new_normalize(nalgebra::Quaternion::new(b[0], b[1], b[2], b[3]));
    2.0 * (a.inverse() * b).imag().norm().min(1.0).asin()
}

/// w, x, y and z.
fn parts(q: &UnitQuaternion<f64>) -> [f64; 4] {
    let [x, y, z, w] = q.as_ref().coords.into();
    [w, x, y, z]
}

fn resting<const N: usize>() -> State<f64, N> {
    State::new(0.0, [0.0; N], [0.0; N])
}

lagrangian! {
    /// A body on a ball joint with thrusters, a fluid that brakes it, a force at a point and a wheel whose current
    /// obeys an equation of its own.
    pub system Craft {
        param m, A, B, C, g, c, k, tau;
        input u: [3];
        coord R: rotation;
        state i = 0.1;
        let hull = frame(world, [0, 0, 0], R);
        T = body(m, [A, B, C], frame(hull, [0.1, 0.2, 0.3]));
        V = m * g * hull.point([0.1, 0.2, 0.3])[2];
        D = 0.5 * c * dot(R)[0].powi(2) + 0.1 * c * dot(R)[1] * dot(R)[2] + 0.3 * c * (dot(R)[1].powi(2) + dot(R)[2].powi(2));
        Q[R] = [u[0], u[1] * cos(u[2]), u[2] + k * i];
        couple [0, k * sin(t), 0] on hull;
        force [0.3 * i, u[0], k] at hull.point([0, 0.5, -0.2]);
        rate(i) = (dot(R)[0] - i) / tau + (R * [0, 0, 1])[0];
        observe up = R * [0, 0, 1];
        observe work_rate = dot(R).dot([u[0], u[1] * cos(u[2]), u[2] + k * i]);
        event level: (R * [1, 2, -0.5])[2];
    }
}

const CENTRE: Vec3 = Vec3::new(0.1, 0.2, 0.3);

fn craft() -> Craft {
    Craft { u: [0.4, -0.3, 0.8], ..Craft::new(1.2, 0.9, 1.5, 0.7, 2.0, 0.05, 0.6, 0.5) }
}

/// The inertia about the joint.
fn inertia(craft: &Craft) -> nalgebra::Matrix3<f64> {
    let parallel = nalgebra::Matrix3::identity() * CENTRE.norm_squared() - CENTRE * CENTRE.transpose();
    nalgebra::Matrix3::from_diagonal(&Vec3::new(craft.A, craft.B, craft.C)) + parallel * craft.m
}

/// Rates of the quaternion, ω and i.
fn craft_rate(craft: &Craft, t: f64, y: &SVector<f64, 8>) -> SVector<f64, 8> {
    let (q, omega, i) = ([y[0], y[1], y[2], y[3]], Vec3::new(y[4], y[5], y[6]), y[7]);
    let Craft { m, g, c, k, tau, u, .. } = *craft;
    let weight = turned(back(q), Vec3::new(0.0, 0.0, -m * g));
    let force = turned(back(q), Vec3::new(0.3 * i, u[0], k));
    let brake =
        Vec3::new(c * omega.x, 0.6 * c * omega.y + 0.1 * c * omega.z, 0.6 * c * omega.z + 0.1 * c * omega.y);
    let moment = Vec3::new(u[0], u[1] * u[2].cos() + k * t.sin(), u[2] + k * i)
        + CENTRE.cross(&weight)
        + Vec3::new(0.0, 0.5, -0.2).cross(&force)
        - brake;
    let inertia = inertia(craft);
    let a = inertia.lu().solve(&(moment - omega.cross(&(inertia * omega)))).unwrap();
    let rate = quaternion_rate(q, omega);
    let current = (omega.x - i) / tau + turned(q, Vec3::z()).x;
    SVector::from([rate[0], rate[1], rate[2], rate[3], a.x, a.y, a.z, current])
}

/// The motion of a craft by hand.
fn craft_by_hand(craft: &Craft, y: SVector<f64, 8>, times: [f64; 2]) -> SVector<f64, 8> {
    by_hand(&|t, y| craft_rate(craft, t, y), y, times)
}

fn craft_start() -> (State<f64, 4>, SVector<f64, 8>) {
    let (attitude, omega) = (UnitQuaternion::from_euler_angles(2.1, 0.4, -1.3), Vec3::new(2.0, -3.0, 1.0));
    let mut at = craft().with_attitude_R(resting(), &attitude, &omega);
    at.qd[3] = 0.1;
    let q = attitude.as_ref();
    (at, SVector::from([q.w, q.i, q.j, q.k, omega.x, omega.y, omega.z, 0.1]))
}

/// Distance of attitude, angular velocity and current of a state from those by hand.
fn missed(at: &State<f64, 4>, y: &SVector<f64, 8>) -> f64 {
    let omega = craft().angular_velocity_R(at) - Vec3::new(y[4], y[5], y[6]);
    apart(&craft().attitude_R(at), [y[0], y[1], y[2], y[3]]).max(omega.amax()).max((at.qd[3] - y[7]).abs())
}

/// Changes of parameters on the way of a motion.
fn changes<const N: usize>(steps: impl Iterator<Item = [State<f64, N>; 2]>) -> u32 {
    let (mut count, mut before) = (0, None);
    for [from, to] in steps {
        count += u32::from(before.is_some_and(|before| before != from.q));
        before = Some(to.q);
    }
    count
}

/// Inputs, a state of first order, dissipation, moments, couples, forces, outputs and events.
#[test]
fn a_driven_body_moves_as_by_hand() {
    let (start, y) = craft_start();
    let craft = craft();
    let end = 6.0;
    let run = || integrate(&craft, Dop853, PiController::tolerance(1e-13), start);
    let known = craft_by_hand(&craft, y, [0.0, end]);
    let to = run().until(end).final_state().unwrap();
    assert!(missed(&to, &known) < 3e-11, "{:e}", missed(&to, &known));
    let steps = run().until(end).map(|step| step.unwrap()).map(|step| [step.from, step.to]);
    assert!(changes(steps) >= 4);
    // Backward; the current decays by e⁴ in this time, so that errors grow by as much.
    let back = integrate(&craft, Dop853, PiController::tolerance(1e-13), to).until(end - 2.0);
    let before = craft_by_hand(&craft, y, [0.0, end - 2.0]);
    let missed_back = missed(&back.final_state().unwrap(), &before);
    assert!(missed_back < 2e-9, "{missed_back:e}");
    // Outputs at samples, and the event.
    for sample in run().until(end).sample((0..60).map(|k| 0.1 * f64::from(k))) {
        let sample = sample.unwrap();
        let y = craft_by_hand(&craft, y, [0.0, sample.t]);
        assert!(missed(&sample, &y) < 3e-10, "{:e} at {}", missed(&sample, &y), sample.t);
        let up = craft.up(&sample.q, &sample.qd, sample.t);
        assert!((up - turned([y[0], y[1], y[2], y[3]], Vec3::z())).amax() < 3e-10);
        let moments = [craft.u[0], craft.u[1] * craft.u[2].cos(), craft.u[2] + craft.k * y[7]];
        let power: f64 = (0..3).map(|k| y[4 + k] * moments[k]).sum();
        assert!((craft.work_rate(&sample.q, &sample.qd, sample.t) - power).abs() < 1e-8);
    }
    let height = |t: f64| {
        let y = craft_by_hand(&craft, y, [0.0, t]);
        turned([y[0], y[1], y[2], y[3]], Vec3::new(1.0, 2.0, -0.5)).z
    };
    let met: Vec<f64> = run().until(end).events(Craft::LEVEL).map(|event| event.unwrap().state.t).collect();
    assert!(met.iter().all(|t| height(*t).abs() < 1e-9));
    let signs: Vec<bool> = (0..600).map(|k| height(0.01 * f64::from(k)) > 0.0).collect();
    assert_eq!(met.len(), signs.windows(2).filter(|pair| pair[0] != pair[1]).count(), "{met:?}");
    // By other families of methods.
    let by = |end: State<f64, 4>, bound: f64, name: &str| {
        println!("{name}: {:e}", missed(&end, &known));
        assert!(missed(&end, &known) < bound, "{name}: {:e}", missed(&end, &known));
    };
    let taylor = (Taylor, TaylorController::tolerance(1e-14));
    by(integrate(&craft, taylor.0, taylor.1, start).until(end).final_state().unwrap(), 1e-11, "Taylor");
    let radau = integrate(&craft, Radau5, PiController::tolerance(1e-10), start);
    by(radau.until(end).final_state().unwrap(), 1e-7, "Radau5");
    let rosenbrock = integrate(&craft, Rodas5P, PiController::tolerance(1e-9), start);
    by(rosenbrock.until(end).final_state().unwrap(), 1e-5, "Rodas5P");
}

/// Inputs that are set from outside, and by a controller with a period; saved and restored on the way.
#[test]
fn a_controlled_body_moves_as_by_hand() {
    let (start, mut y) = craft_start();
    let stepper = Stepper::new(craft(), Dop853, PiController::tolerance(1e-13), start);
    let law = |craft: &Craft, at: &State<f64, 4>| {
        let (omega, up) = (craft.angular_velocity_R(at), craft.attitude_R(at).inverse() * Vec3::z());
        [-0.5 * omega.x + up.y, 0.3 - 0.5 * omega.y - up.x, -0.2 * omega.z]
    };
    let sampled = craft();
    let mut stepper = stepper.every(0.25, move |at, u| {
        *u = law(&sampled, at).into();
    });
    let mut by_hand = craft();
    for k in 0..24 {
        let at = State { t: 0.25 * f64::from(k), ..*stepper.state() };
        by_hand.u = law(&by_hand, &at);
        let times = [at.t, at.t + 0.25];
        y = craft_by_hand(&by_hand, y, times);
        stepper.advance_to(times[1]).unwrap();
        // (The law of the hand has the state of the run, which is checked.)
        assert!(missed(stepper.state(), &y) < 3e-11, "{:e} at {}", missed(stepper.state(), &y), times[1]);
    }
    // Derivatives by the inputs, by the shorter and by the longer parameters of an attitude.
    let mut prepared = craft();
    prepared.set_inputs(&SVector::from([0.1, 0.2, 0.3]));
    let near = *stepper.state();
    let far = near.q.fixed_rows::<3>(0).norm_squared();
    let mut other = near;
    let radial = near.q.fixed_rows::<3>(0).dot(&near.qd.fixed_rows::<3>(0)) / far;
    for i in 0..3 {
        other.q[i] = -near.q[i] / far;
        other.qd[i] = (2.0 * radial * near.q[i] - near.qd[i]) / far;
    }
    assert!(apart(&craft().attitude_R(&other), parts(&craft().attitude_R(&near))) < 1e-14);
    for at in [near, other] {
        let inverse = inertia(&craft()).try_inverse().unwrap();
        // ∂ω̇/∂u, through the change of ω by a velocity σ̇.
        let by_inputs = prepared.input_jacobian(&at.q, &at.qd, at.t);
        for k in 0..3 {
            let mut moved = at;
            for i in 0..4 {
                moved.qd[i] += by_inputs[(i, k)];
            }
            let found = craft().angular_velocity_R(&moved) - craft().angular_velocity_R(&at);
            let u = &prepared.u;
            let force =
                craft().attitude_R(&at).inverse() * Vec3::new(0.0, if k == 0 { 1.0 } else { 0.0 }, 0.0);
            let moment = [Vec3::x(), Vec3::y() * u[2].cos(), Vec3::new(0.0, -u[1] * u[2].sin(), 1.0)][k];
            let known = inverse * (moment + Vec3::new(0.0, 0.5, -0.2).cross(&force));
            assert!((found - known).amax() < 1e-13, "{k}: {found} {known}");
        }
    }
}

lagrangian! {
    /// A body on a ball joint that is struck at a point.
    pub system Struck {
        param m, A, B, C, g;
        coord R: rotation;
        let hull = frame(world, [0, 0, 0], R);
        T = body(m, [A, B, C], frame(hull, [0.1, 0.2, 0.3]));
        V = m * g * hull.point([0.1, 0.2, 0.3])[2];
        impulse blow at hull.point([0.3, -0.4, 0.1]);
    }
}

/// A body held by a constraint at the joint, which takes its part of the blow.
#[test]
fn blows_change_angular_velocities_by_their_moments() {
    let craft = craft();
    let body = Struck::new(craft.m, craft.A, craft.B, craft.C, craft.g);
    let attitude = UnitQuaternion::from_euler_angles(2.1, 1.4, -1.3);
    for near in [0.2, 1.0, 5.0] {
        let mut at = body.with_attitude_R(resting(), &attitude, &Vec3::zeros());
        // Parameters of other lengths are those of other attitudes.
        (at.q, at.qd) = (at.q * near, SVector::from([0.3, -0.2, 0.5]));
        let blow = Vec3::new(0.3, -0.7, 0.2);
        let impulse = body.blow(&at.q, at.t, &blow);
        let after = State { qd: body.jump(&at, &impulse).after.qd, ..at };
        let found = body.angular_velocity_R(&after) - body.angular_velocity_R(&at);
        let moment = Vec3::new(0.3, -0.4, 0.1).cross(&(body.attitude_R(&at).inverse() * blow));
        let known = inertia(&craft).try_inverse().unwrap() * moment;
        assert!((found - known).amax() < 1e-13, "{found} {known}");
    }
}

lagrangian! {
    /// A heavy bar on two ball joints: a hinge, one of whose six constraints follows from the others.
    pub system Hinged {
        param m, g;
        coord x: [3], R: rotation;
        let bar = frame(world, x, R);
        T = body(m, [0.3, 0.5, 0.4], bar);
        V = m * g * x[2];
        redundant constraint left: bar.point([-0.6, 0.4, 0]) == [-0.6, 0, 0];
        redundant constraint right: bar.point([0.8, 0.4, 0]) == [0.8, 0, 0];
        observe left_force = [reaction(left[0]), reaction(left[1]), reaction(left[2])];
        observe right_force = [reaction(right[0]), reaction(right[1]), reaction(right[2])];
    }
}

/// It turns over and over as a pendulum does, with the reactions that Newton's and Euler's laws ask for.
#[test]
fn a_closed_loop_turns_as_a_pendulum() {
    use lagrange_runtime::testing::reference::SimplePendulum;
    let (m, g, l) = (1.3, 9.81, 0.4);
    let bar = Hinged::new(m, g);
    let [about, omega] = [0.3 + m * l * l, 9.0];
    // θ from below: at θ the bar is turned by θ + 90° about x, against the hinge at +y of it.
    let at = |theta: f64, omega: f64| {
        let attitude = UnitQuaternion::from_axis_angle(&Vec3::x_axis(), theta + core::f64::consts::FRAC_PI_2);
        let mut at = bar.with_attitude_R(resting(), &attitude, &Vec3::new(omega, 0.0, 0.0));
        let centre = attitude * Vec3::new(0.0, -l, 0.0);
        let velocity = Vec3::new(omega, 0.0, 0.0).cross(&centre);
        for i in 0..3 {
            (at.q[i], at.qd[i]) = (centre[i], velocity[i]);
        }
        at
    };
    let pendulum = SimplePendulum::new(g, about / (m * l), 0.4, omega);
    let run = integrate(&bar, Dop853, PiController::tolerance(1e-13), at(0.4, omega)).until(8.0);
    for sample in run.sample((1..40).map(|k| 0.2 * f64::from(k))) {
        let sample = sample.unwrap();
        let (theta, omega) = pendulum.state(sample.t);
        let known = at(theta, omega);
        let missed = apart(&bar.attitude_R(&sample), parts(&bar.attitude_R(&known)));
        assert!(missed < 1e-9, "{missed:e} at {}", sample.t);
        // F = m (a − g), and the couple of both about the mass centre.
        let alpha = -m * g * l * theta.sin() / about;
        let a = Vec3::new(
            0.0,
            l * (alpha * theta.cos() - omega * omega * theta.sin()),
            l * (alpha * theta.sin() + omega * omega * theta.cos()),
        );
        let [left, right] = [
            bar.left_force(&sample.q, &sample.qd, sample.t),
            bar.right_force(&sample.q, &sample.qd, sample.t),
        ];
        let force = left + right;
        assert!((force - (a + Vec3::z() * g) * m).amax() < 1e-7, "{force}");
        let turning = bar.angular_acceleration_R(&sample) - Vec3::new(alpha, 0.0, 0.0);
        assert!(turning.amax() < 1e-7, "{turning}");
        let [from_left, from_right] = [Vec3::new(-0.6, 0.4, 0.0), Vec3::new(0.8, 0.4, 0.0)];
        let attitude = bar.attitude_R(&sample);
        let couple = (attitude * from_left).cross(&left) + (attitude * from_right).cross(&right);
        assert!((couple - Vec3::new(0.3 * alpha, 0.0, 0.0)).amax() < 1e-7, "{couple}");
    }
}

lagrangian! {
    /// A wheel under a torque whose sign is that of the height of a mark on it.
    pub system Switched {
        param a;
        coord R: rotation;
        let wheel = frame(world, [0, 0, 0], R);
        T = body(0, [2, 2, 2], wheel);
        V = 0;
        let torque = if (R * [0, 1, 0])[2] > 0 { a } else { -0.5 * a };
        Q[R] = [2 * torque, 0, 0];
    }
}

/// Forces that jump: the torque is constant between the switches, which the motion passes at known times. Neighbours
/// get the saltation.
#[test]
fn a_body_whose_torque_jumps_moves_by_arcs() {
    let a = 3.0;
    // θ and ω of a turn about x after a time: each half turn is at a constant acceleration.
    let exact = |mut theta: f64, mut omega: f64, mut left: f64| {
        for half_turn in 0.. {
            let alpha = if half_turn % 2 == 0 { a } else { -0.5 * a };
            let edge = core::f64::consts::PI * f64::from(half_turn + 1);
            let time = 2.0 * (edge - theta) / (omega + (omega * omega + 2.0 * alpha * (edge - theta)).sqrt());
            if time >= left {
                return [theta + omega * left + 0.5 * alpha * left * left, omega + alpha * left];
            }
            (theta, omega, left) = (edge, omega + alpha * time, left - time);
        }
        [f64::NAN; 2]
    };
    let wheel = Switched::new(a);
    let tilt = UnitQuaternion::from_axis_angle(&Vec3::x_axis(), 0.5);
    let start = wheel.with_attitude_R(resting(), &tilt, &Vec3::new(2.5, 0.0, 0.0));
    let missed = |end: &State<f64, 3>| {
        let [theta, omega] = exact(0.5, 2.5, end.t);
        let q = [(theta / 2.0).cos(), (theta / 2.0).sin(), 0.0, 0.0];
        apart(&wheel.attitude_R(end), q).max((wheel.angular_velocity_R(end) - Vec3::x() * omega).amax())
    };
    let end = 10.0;
    let run =
        integrate(&wheel, Dop853, PiController::tolerance(1e-12), start).until(end).final_state().unwrap();
    assert!(missed(&run) < 1e-9, "{:e}", missed(&run));
    let series =
        integrate(&wheel, Taylor::of_order(20), TaylorController::tolerance(1e-14), start).until(end);
    let series = series.final_state().unwrap();
    assert!(missed(&series) < 1e-11, "{:e}", missed(&series));
    // The derivative by the first angular velocity, by dual numbers.
    let dual = wheel.map(Dual::constant);
    let constant = Dual::constant;
    let mut start = start.map(constant);
    let (tilt, mut omega) = (lifted(&tilt), Vector3::new(2.5, 0.0, 0.0).map(constant));
    omega[0].slope = 1.0;
    start = dual.with_attitude_R(start, &tilt, &omega);
    let last = integrate(&dual, Dop853, PiController::tolerance(1e-12), start).until(constant(end));
    let last = last.final_state().unwrap();
    let aside = 1e-6;
    let [more, less] = [2.5 + aside, 2.5 - aside].map(|omega| exact(0.5, omega, end));
    let known = [0, 1].map(|i| (more[i] - less[i]) / (2.0 * aside));
    let [x, _, _, w] = dual.attitude_R(&last).as_ref().coords.into();
    let found = [2.0 * (x.slope * w.value - w.slope * x.value), dual.angular_velocity_R(&last)[0].slope];
    assert!((0..2).all(|i| (found[i] - known[i]).abs() < 1e-7 * known[i].abs()), "{found:?} {known:?}");
}

fn lifted(attitude: &UnitQuaternion<f64>) -> UnitQuaternion<Dual<f64>> {
    let parts: [f64; 4] = attitude.as_ref().coords.into();
    let [x, y, z, w] = parts.map(Dual::constant);
    UnitQuaternion::new_unchecked(nalgebra::Quaternion::new(w, x, y, z))
}

/// Equilibria, small motions, neighbours, orbits and exponents.
mod analysis {
    use super::*;
    use lagrange_runtime::analysis::{
        BifurcationKind, ByGradients, ByVariationalEquations, Heading, Measurement, Path, Period, equilibria,
        equilibrium, follow, fundamental_matrix, lyapunov_by_two_trajectories, lyapunov_spectrum,
        periodic_orbit, small_vibrations,
    };
    use lagrange_runtime::{Gradient, analysis::Stability};

    lagrangian! {
        /// A body that three springs of torsion turn to an attitude.
        pub system Compass {
            param A, B, C, k: [3], e: [3], f: [3], g: [3], c;
            coord R: rotation;
            T = body(0, [A, B, C], frame(world, [0, 0, 0], R));
            V = -k[0] * (R * [1, 0, 0]).dot(e) - k[1] * (R * [0, 1, 0]).dot(f) - k[2] * (R * [0, 0, 1]).dot(g);
            D = 0.5 * c * dot(R).norm_squared();
        }
    }

    const K: [f64; 3] = [3.0, 2.0, 0.5];
    const MOMENTS: [f64; 3] = [1.0, 2.0, 1.5];

    fn compass(rest: &UnitQuaternion<f64>, c: f64) -> Compass {
        let [e, f, g] = [Vec3::x(), Vec3::y(), Vec3::z()].map(|v| (rest * v).into());
        let [a, b, third] = MOMENTS;
        Compass::new(a, b, third, K, e, f, g, c)
    }

    /// V = −tr K R₀ᵀR is least at R₀, with ω₁² = (k₂ + k₃)/A, …, and stationary half a turn from it about each axis.
    #[test]
    fn equilibria_are_those_of_any_attitude() {
        let axis = nalgebra::Unit::new_normalize(Vec3::new(0.3, -0.5, 0.8));
        let stiffness = |signs: [f64; 3]| {
            let k: [f64; 3] = std::array::from_fn(|i| K[i] * signs[i]);
            let mut all: [f64; 3] = std::array::from_fn(|i| (k[(i + 1) % 3] + k[(i + 2) % 3]) / MOMENTS[i]);
            all.sort_by(f64::total_cmp);
            all
        };
        for degrees in [0.0f64, 90.0, 179.999_999, 180.0, 200.0, 203.0, 206.0, 300.0, 359.0] {
            let rest = UnitQuaternion::from_axis_angle(&axis, degrees.to_radians());
            let compass = compass(&rest, 0.1);
            let shorter = compass.with_attitude_R(resting(), &rest, &Vec3::zeros()).q;
            // The longer ones of a turn by next to nothing are too long.
            let square = shorter.norm_squared();
            let longer = (square > 0.1).then(|| shorter / -square);
            for q in [Some(shorter), longer].into_iter().flatten() {
                let small = small_vibrations(&compass, &q.into()).unwrap();
                for (found, known) in small.modes().unwrap().squares().iter().zip(stiffness([1.0; 3])) {
                    assert!((found - known).abs() < 1e-12, "{degrees}: {found} {known}");
                }
                assert!(small.spectrum().unwrap().eigenvalues.iter().all(|e| e.re < 0.0));
            }
            // All four, each once.
            let all = equilibria(&compass, &[-1.0; 3], &[1.0; 3], 200).unwrap();
            assert_eq!(all.len(), 4, "{degrees}: {:?}", all.iter().map(|e| e.q).collect::<Vec<_>>());
            for half in [None, Some(Vec3::x_axis()), Some(Vec3::y_axis()), Some(Vec3::z_axis())] {
                let half_turn = |axis| UnitQuaternion::from_axis_angle(&axis, core::f64::consts::PI);
                let known = rest * half.map_or_else(UnitQuaternion::identity, half_turn);
                let is = |e: &&lagrange_runtime::analysis::Equilibrium<3>| {
                    apart(&compass.attitude_R(&State { q: e.q, ..resting() }), parts(&known)) < 1e-7
                };
                let found: Vec<_> = all.iter().filter(is).collect();
                assert_eq!(found.len(), 1, "{degrees} {half:?}");
                match half {
                    None => assert!(found[0].stability.is_stable()),
                    _ => assert!(matches!(found[0].stability, Stability::Unstable { .. })),
                }
            }
        }
        // From anywhere Newton's method comes to an attitude and not to infinity.
        let compass = compass(&UnitQuaternion::from_axis_angle(&axis, 2.0), 0.1);
        let mut reached = 0;
        for k in 0..200 {
            let angle = 0.7 * f64::from(k);
            let guess =
                Vec3::new(angle.sin(), (1.7 * angle).cos(), (2.3 * angle).sin()) * (0.02 * f64::from(k));
            let Ok(found) = equilibrium(&compass, &guess.into()) else { continue };
            assert!(found.q.norm() < 100.0 && found.residual < 1e-13, "{found:?}");
            reached += 1;
        }
        println!("{reached} of 200");
        assert!(reached >= 150, "{reached} of 200");
    }

    lagrangian! {
        /// A body that is held at a point by a constraint, with a spring of torsion about the vertical.
        pub system Pinned {
            param m, g, k, c;
            coord x: [3], R: rotation;
            let hull = frame(world, x, R);
            T = body(m, [0.3, 0.5, 0.4], hull);
            V = m * g * x[2] - k * (R * [1, 0, 0])[0];
            D = 0.5 * c * angular_velocity(hull).norm_squared();
            constraint pin: hull.point([0.1, 0.4, -0.2]) == [0, 0, 0];
        }
    }

    lagrangian! {
        /// A body that is held at a point by a ball joint, with the same spring.
        pub system Jointed {
            param m, g, k, c;
            coord R: rotation;
            let hull = frame(frame(world, [0, 0, 0], R), [-0.1, -0.4, 0.2]);
            T = body(m, [0.3, 0.5, 0.4], hull);
            V = m * g * hull.origin()[2] - k * (R * [1, 0, 0])[0];
            D = 0.5 * c * angular_velocity(hull).norm_squared();
        }
    }

    lagrangian! {
        /// A needle in a field that turns by `angle` in the plane, with its keel held down ever less.
        pub system Needle {
            param angle, keel;
            coord R: rotation;
            let needle = frame(world, [0, 0, 0], R);
            T = body(0, [1, 2, 2.5], needle);
            let pointing = needle.vector([1, 0, 0]);
            let down = needle.vector([0, 0, 1])[2];
            V = -(cos(angle) * pointing[0] + sin(angle) * pointing[1]) - (keel - angle) * down + 0.25 * down.powi(2);
        }
    }

    lagrangian! {
        /// The same with the pointer in a plane by a constraint.
        pub system Levelled {
            param angle, keel;
            coord R: rotation;
            let needle = frame(world, [0, 0, 0], R);
            T = body(0, [1, 2, 2.5], needle);
            let pointing = needle.vector([1, 0, 0]);
            let down = needle.vector([0, 0, 1])[2];
            V = -(cos(angle) * pointing[0] + sin(angle) * pointing[1]) - (keel - angle) * down + 0.25 * down.powi(2);
            constraint level: pointing[2] == 0;
        }
    }

    /// The needle turns with the field, once and a half, upright until V'' is 0: keel − angle − 1/2 about its axis, 1
    /// more across it.
    #[test]
    fn curves_of_equilibria_turn_over() {
        let path = Path { range: (-10.0, 10.0), step: 0.1, steps: 2000 };
        for (keel, heading) in [(7.5, Heading::Up), (7.5, Heading::Down), (2.5, Heading::Up)] {
            let constant = Dual::constant;
            let needle = |angle| Needle { angle, keel: constant(keel) };
            let levelled = |angle| Levelled { angle, keel: constant(keel) };
            let critical = [keel - 0.5, keel + 0.5];
            for (branch, critical) in [
                (follow(&needle, &[0.0; 3], 0.0, &heading, &path).unwrap(), &critical[..]),
                (follow(&levelled, &[0.0; 3], 0.0, &heading, &path).unwrap(), &critical[..1]),
            ] {
                assert!(branch.complete);
                for point in &branch.points {
                    let at = State { q: SVector::from_fn(|i, _| point.q[i]), ..resting::<3>() };
                    let known = UnitQuaternion::from_axis_angle(&Vec3::z_axis(), point.parameter);
                    assert!(apart(&at.attitude(0), parts(&known)) < 1e-12, "{point:?}");
                    assert!(at.q.norm_squared() < 2.0, "{point:?}");
                    let falling = critical.iter().filter(|critical| point.parameter > **critical).count();
                    assert_eq!(point.negative, falling, "{point:?}");
                }
                let known = if matches!(heading, Heading::Up) { critical } else { &[] };
                assert_eq!(branch.bifurcations.len(), known.len());
                for (found, known) in branch.bifurcations.iter().zip(known) {
                    assert_eq!(found.kind, BifurcationKind::Pitchfork);
                    assert!((found.parameter - known).abs() < 1e-10, "{}", found.parameter);
                }
            }
        }
    }

    /// A constraint on a rotation leaves the equilibria and the eigenvalues of the joint, wherever the search begins.
    #[test]
    fn a_constraint_has_the_small_motions_of_a_joint() {
        let (pinned, jointed) = (Pinned::new(1.2, 9.81, 0.7, 0.2), Jointed::new(1.2, 9.81, 0.7, 0.2));
        let mut stable = 0;
        for k in 0..12 {
            let sigma =
                Vec3::new(f64::from(k).sin(), (2.0 * f64::from(k)).cos(), 0.3) * (0.4 + 0.1 * f64::from(k));
            let joint = equilibrium(&jointed, &sigma.into()).unwrap();
            let place = State::new(0.0, sigma.into(), [0.0; 3]).attitude(0) * Vec3::new(-0.1, -0.4, 0.2);
            let guess = [place.x, place.y, place.z, sigma.x, sigma.y, sigma.z];
            let held = equilibrium(&pinned, &guess).unwrap();
            let known = jointed.attitude_R(&State { q: joint.q, ..resting() });
            let found = pinned.attitude_R(&State { q: held.q, ..resting() });
            // Both searches need not end at the same one.
            if apart(&found, parts(&known)) > 1e-6 {
                continue;
            }
            stable += u32::from(joint.stability.is_stable());
            assert_eq!(joint.stability.is_stable(), held.stability.is_stable());
            let [joint, held] = [joint.small, held.small].map(|small| small.spectrum().unwrap().eigenvalues);
            assert_eq!(joint.len(), held.len());
            for value in &joint {
                let near = held.iter().map(|other| (other - value).norm()).fold(f64::INFINITY, f64::min);
                assert!(near < 1e-9, "{joint:?} {held:?}");
            }
        }
        assert!(stable >= 3, "{stable}");
    }

    lagrangian! {
        pub system Free {
            param A, B, C;
            coord R: rotation;
            T = body(0, [A, B, C], frame(world, [0, 0, 0], R));
            V = 0;
        }
    }

    /// A steady turn about the middle axis: deviations of ω grow as cosh λt and sinh λt, those about the axis turn
    /// the body further.
    #[test]
    fn neighbours_of_a_steady_turn_part_as_their_equations_say() {
        let (free, turning) = (Free::new(1.0, 1.2, 1.4), 1.5f64);
        let lambda = turning * (0.2f64 * 0.2 / 1.4).sqrt();
        let first = UnitQuaternion::from_euler_angles(0.3, 1.2, 0.1);
        let start = free.with_attitude_R(resting(), &first, &Vec3::new(0.0, turning, 0.0));
        let equations = ByVariationalEquations::<_, 21>::new(&free, 1e-12);
        let gradients =
            ByGradients::with(free.map(Gradient::<_, 6>::constant), Dop853, PiController::tolerance(1e-12));
        // The deviation of ω and of the attitude (in the turned axes) of a deviation of (q, q̇), by dual numbers.
        let meaning = |at: &State<f64, 3>, along: &[f64]| {
            let with = |x: &SVector<f64, 3>, first: usize| {
                SVector::<_, 3>::from_fn(|i, _| Dual { value: x[i], slope: along[first + i] })
            };
            let dual = State { t: Dual::constant(at.t), q: with(&at.q, 0), qd: with(&at.qd, 3) };
            let turned = dual.attitude(0).as_ref().coords;
            let [x, y, z, w]: [f64; 4] = turned.map(|x| x.slope).into();
            let back = free.attitude_R(at).inverse().into_inner();
            let turn = (back * nalgebra::Quaternion::new(w, x, y, z)).imag() * 2.0;
            [dual.angular_velocity(0).map(|x| x.slope), turn]
        };
        for end in [4.0, 20.0] {
            let by_equations = fundamental_matrix(&equations, &start, end).unwrap();
            let by_gradients = fundamental_matrix(&gradients, &start, end).unwrap();
            for (at, matrix) in [by_equations, by_gradients] {
                for k in 0..6 {
                    let unit: Vec<f64> = (0..6).map(|i| f64::from(u8::from(i == k))).collect();
                    let [before, turn] = meaning(&start, &unit);
                    let column: Vec<f64> = matrix.column(k).iter().copied().collect();
                    let [found, further] = meaning(&at, &column);
                    // δω̇₁ = (B − C)/A Ω δω₃, δω̇₃ = (A − B)/C Ω δω₁, and the turn with them: φ̇ = δω − Ω × φ.
                    let rate = |_: f64, y: &SVector<f64, 6>| {
                        let omega = Vec3::new(0.0, turning, 0.0);
                        let phi = Vec3::new(y[3], y[4], y[5]);
                        let turn = Vec3::new(y[0], y[1], y[2]) - omega.cross(&phi);
                        let [a, c] = [-0.2 * turning * y[2], -0.2 / 1.4 * turning * y[0]];
                        SVector::from([a, 0.0, c, turn.x, turn.y, turn.z])
                    };
                    let y = SVector::from([before.x, before.y, before.z, turn.x, turn.y, turn.z]);
                    let known = by_hand(&rate, y, [0.0, end]);
                    let size = (lambda * end).exp();
                    for i in 0..3 {
                        let missed = (found[i] - known[i]).abs().max((further[i] - known[3 + i]).abs());
                        assert!(missed < 1e-9 * size, "{k} {i} at {end}: {missed:e}");
                    }
                }
            }
        }
        // The closed orbit of one turn, whose multipliers are e^{±λτ}, and 1 for the rest.
        let period = core::f64::consts::TAU / turning;
        let orbit = periodic_orbit(&equations, &start, Period::Given(period), 1e-9).unwrap();
        let sizes: Vec<f64> = orbit.multipliers.iter().map(|mu| mu.norm()).collect();
        assert!((sizes[0] - (-lambda * period).exp()).abs() < 1e-6, "{sizes:?}");
        assert!((sizes[5] - (lambda * period).exp()).abs() < 1e-6, "{sizes:?}");
        assert!(sizes[1..5].iter().all(|mu| (mu - 1.0).abs() < 1e-4), "{sizes:?}");
        // Exponents, over whole turns.
        let how = Measurement { transient: 5.0 * period, interval: period, intervals: 20 };
        let spectrum = lyapunov_spectrum(&equations, &start, &how).unwrap();
        assert!((spectrum[0].value - lambda).abs() < 5e-3, "{spectrum:?} {lambda}");
        // Volume in (q, q̇) depends on the state alone; the turn, which is unstable, has grown to 1e-4 of another
        // motion.
        let sum: f64 = spectrum.iter().map(|e| e.value).sum();
        assert!(sum.abs() < 1e-4, "{sum:e}");
        let control = PiController::tolerance(1e-12);
        let by_two = lyapunov_by_two_trajectories(&free, Dop853, control, &start, 1e-7, &how).unwrap();
        assert!((by_two.value - lambda).abs() < 5e-3, "{by_two:?} {lambda}");
    }
}

/// Steps in lanes: methods with memories of all kinds, samples within steps, events, and lanes that fail.
mod lanes {
    use super::*;
    use lagrange_runtime::ensemble::{Collect, Ensemble, Table};
    use lagrange_runtime::lanes::{FinalState, Fused, Occurrences, Sampled};

    fn draw([number]: [u64; 1]) -> (Struck, State<f64, 3>) {
        let craft = craft();
        let body = Struck::new(craft.m, craft.A, craft.B, craft.C, 0.1 * number as f64);
        let attitude = UnitQuaternion::from_euler_angles(0.7 * number as f64, 0.3, -0.2);
        // The start of some is not finite, and that of others is a turn by 359°.
        let omega = Vec3::new(2.0, 0.1 * number as f64, if number % 5 == 3 { f64::NAN } else { 0.3 });
        let mut at = body.with_attitude_R(resting(), &attitude, &omega);
        if number % 4 == 1 {
            (at.q, at.qd) = (at.q * 100.0, at.qd * 1000.0);
        }
        (body, at)
    }

    macro_rules! alone {
        ($method:expr, $controller:expr) => {{
            let numbers = (0..13).map(|number| [number]);
            let study = Ensemble::new(Table::new(numbers), 13, draw).integrate($method, $controller, 6.0);
            let lanes = study.threads(1).in_lanes(Fused);
            let outcome =
                lanes.observe(&FinalState(|_: &Struck, end: &State<f64, 3>| *end), Collect).unwrap();
            assert_eq!((outcome.statistic.rows.len(), outcome.failures.count), (11, 2));
            for (index, end) in &outcome.statistic.rows {
                let alone = lanes.replay(*index).unwrap().run().final_state().unwrap();
                assert_eq!(*end, alone.map(|x| x.value()), "sample {index}");
            }
            lanes
        }};
    }

    #[test]
    fn every_lane_is_its_run() {
        alone!(Gauss4, FixedStep::new(0.05));
        alone!(Taylor::of_order(14), TaylorController::tolerance(1e-10));
        let lanes = alone!(Dop853, PiController::tolerance(1e-9));
        // Samples in steps before and after changes of parameters, against the motion by hand.
        let times: Vec<f64> = (1..60).map(|k| 0.1 * f64::from(k)).collect();
        let ups = |body: &Struck, states: &[State<f64, 3>]| -> Vec<f64> {
            states.iter().flat_map(|at| <[f64; 3]>::from(body.attitude_R(at) * Vec3::z())).collect()
        };
        let outcome = lanes.observe(&Sampled::new(times.clone(), ups), Collect).unwrap();
        for (index, ups) in &outcome.statistic.rows {
            let (body, at) = draw([*index]);
            let still = Craft { u: [0.0; 3], c: 0.0, k: 0.0, g: body.g, ..craft() };
            let (q, omega) = (parts(&body.attitude_R(&at)), body.angular_velocity_R(&at));
            let y = SVector::from([q[0], q[1], q[2], q[3], omega.x, omega.y, omega.z, 0.0]);
            let rate = |t: f64, y: &SVector<f64, 8>| {
                // No current, which would act.
                let mut rate = craft_rate(&still, t, y);
                rate[7] = 0.0;
                rate
            };
            for k in [7, 58] {
                let y = by_hand(&rate, y, [0.0, times[k]]);
                let up = turned([y[0], y[1], y[2], y[3]], Vec3::z());
                assert!((0..3).all(|i| (ups[3 * k + i] - up[i]).abs() < 1e-6), "sample {index}");
            }
        }
        // Events, which are those of the run alone.
        let level = || {
            Event::new(lagrange_runtime::Direction::Either, |at: &State<f64, 3>| {
                (at.attitude(0) * Vec3::new(1.0, 2.0, -0.5))[2]
            })
        };
        let times = |_: &Struck,
                     met: &[lagrange_runtime::Occurrence<f64, 3>],
                     _: &State<f64, 3>|
         -> Vec<f64> { met.iter().map(|met| met.state.t).collect() };
        let outcome = lanes.observe(&Occurrences::new(level(), times), Collect).unwrap();
        for (index, times) in &outcome.statistic.rows {
            let (body, at) = draw([*index]);
            let run = integrate(&body, Dop853, PiController::tolerance(1e-9), at).until(6.0);
            let alone: Vec<f64> = run.events(level()).map(|met| met.unwrap().state.t).collect();
            assert_eq!(times.len(), alone.len(), "sample {index}");
            assert!(times.iter().zip(alone).all(|(a, b)| (a - b).abs() < 1e-6), "sample {index}");
        }
        assert!(outcome.statistic.rows.iter().map(|(_, times)| times.len()).sum::<usize>() > 11);
    }
}

/// Saved in the middle of its way, a motion arrives where it would have, bit for bit, and where the motion by hand
/// does.
#[test]
fn a_saved_body_goes_on_bit_for_bit() {
    let (start, y) = craft_start();
    let known = craft_by_hand(&craft(), y, [0.0, 6.0]);
    macro_rules! goes_on {
        ($method:expr, $controller:expr, $bound:expr) => {{
            let mut stepper = Stepper::new(craft(), $method, $controller, start);
            let mut all = vec![];
            // After so many steps, some of which end beyond the parameters that the next one begins with.
            for _ in 0..40 {
                let _ = stepper.advance_within(6.0, 3).unwrap();
                let saved = serde_json::to_string(&stepper).unwrap();
                all.push(serde_json::from_str::<Stepper<Craft, _, _, 4>>(&saved).unwrap());
                *all.last_mut().unwrap() = {
                    let mut same = stepper.clone();
                    same.clone_from(all.last().unwrap());
                    same
                };
            }
            stepper.advance_to(6.0).unwrap();
            assert!(missed(stepper.state(), &known) < $bound);
            for mut saved in all {
                saved.advance_to(6.0).unwrap();
                assert_eq!(saved.state(), stepper.state());
                assert_eq!(saved.statistics(), stepper.statistics());
            }
            let whole = integrate(&craft(), $method, $controller, start).until(6.0).final_state().unwrap();
            assert_eq!(*stepper.state(), whole);
        }};
    }
    goes_on!(Dop853, PiController::tolerance(1e-9), 1e-6);
    goes_on!(Rk4, FixedStep::new(0.01), 1e-5);
    goes_on!(Taylor::of_order(14), TaylorController::tolerance(1e-10), 1e-7);
    goes_on!(Radau5, PiController::tolerance(1e-7), 1e-4);
}

/// Energy and, without weight, the angular momentum in space by methods that keep their structure, over many changes
/// of parameters.
#[test]
fn methods_keep_their_promises_across_changes() {
    let craft = craft();
    let body = Struck::new(craft.m, craft.A, craft.B, craft.C, craft.g);
    let start = body.with_attitude_R(
        resting(),
        &UnitQuaternion::from_euler_angles(2.1, 0.4, -1.3),
        &Vec3::new(2.0, -3.0, 1.0),
    );
    let energy = body.energy_at(&start);
    macro_rules! worst {
        ($method:expr, $controller:expr, $end:expr) => {{
            let (mut worst, mut changes, mut before) = (0.0f64, 0, start.q);
            for step in integrate(&body, $method, $controller, start).until($end) {
                let step = step.unwrap();
                changes += u32::from(step.from.q != before);
                before = step.to.q;
                worst = worst.max((body.energy_at(&step.to) - energy).abs());
            }
            assert!(changes > 100, "{changes}");
            worst
        }};
    }
    let found = [
        (
            "Projection(DormandPrince5)",
            worst!(Projection(DormandPrince5), PiController::tolerance(1e-7), 400.0),
            1e-11,
        ),
        ("VariationalMidpoint", worst!(VariationalMidpoint, FixedStep::new(0.02), 400.0), 0.2),
        ("Gauss4", worst!(Gauss4, FixedStep::new(0.02), 400.0), 1e-3),
        ("Gauss6", worst!(lagrange_runtime::Gauss6, FixedStep::new(0.02), 400.0), 1e-5),
    ];
    for (name, worst, _) in &found {
        println!("{name}: {worst:e}");
    }
    for (name, worst, bound) in found {
        assert!(worst < bound, "{name}: {worst:e}");
    }
}
