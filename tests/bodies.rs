//! Bodies that tumble against digits of their own (`benches/references/bodies.py`), against NASA's simulators, and by
//! their integrals of the motion.
#![allow(clippy::excessive_precision)]

#[path = "bodies/floating_arm.rs"]
mod floating_arm;

use lagrange_runtime::prelude::*;

type Vec3 = Vector3<f64>;

fn quaternion([w, x, y, z]: [f64; 4]) -> UnitQuaternion<f64> {
    UnitQuaternion::new_normalize(nalgebra::Quaternion::new(w, x, y, z))
}

/// The angle between two attitudes.
fn apart(a: &UnitQuaternion<f64>, b: &UnitQuaternion<f64>) -> f64 {
    2.0 * (a.inverse() * b).imag().norm().min(1.0).asin()
}

fn resting<const N: usize>() -> State<f64, N> {
    State::new(0.0, [0.0; N], [0.0; N])
}

lagrangian! {
    /// NASA's brick, 8 by 4 by 2.25 inches, which falls and tumbles. Units are foot, slug and second. `height` above
    /// the surface of the Earth, in the standard atmosphere of 1976 (troposphere), which is denser by 8e-4 in the
    /// table of the simulator.
    pub system Brick {
        param m = 0.155404754, A = 0.00189422, B = 0.006211019, C = 0.007194665;
        /// The damping moments −½ ρ V S b² ω/2, or none.
        param damping, S = 0.22222, b = 0.33333, c = 0.66667;
        param radius = 20925646.3, gm, earth = 7.292115e-5, density = 0.0023788, T0 = 518.67, lapse = 0.00356616;
        coord height, R: rotation;
        let hull = frame(world, [0, 0, 0], R);
        T = 0.5 * m * dot(height).powi(2) + body(0, [A, B, C], hull);
        V = -m * gm / (radius + height) - 0.5 * m * (earth * (radius + height)).powi(2);
        let altitude = height * 20855531.5 / (20855531.5 + height);
        let rho = density * (1 - lapse * altitude / T0).powf(4.2558797);
        let k = damping * 0.25 * rho * (-dot(height)) * S;
        Q[R] = [-k * b * b * dot(R)[0], -k * c * c * dot(R)[1], -k * b * b * dot(R)[2]];
    }
}

/// NESC check cases 2 and 3 (NASA/TM-2015-218675): 30 s from rest at 30 000 ft with 10, 20 and 30 °/s about the axes.
#[test]
fn a_brick_tumbles_as_nasas() {
    let radius = 20_925_646.3;
    let gm = 32.1065364063 * (radius + 30_000.0f64).powi(2);
    let brick = |damping| Brick::new(damping, gm);
    let rates = Vec3::new(10.0, 20.0, 30.0).map(f64::to_radians);
    let free = brick(0.0);
    let start = State { q: SVector::from([3e4, 0.0, 0.0, 0.0]), ..resting() };
    let start = free.with_attitude_R(start, &UnitQuaternion::identity(), &rates);
    let run = |brick: &Brick| {
        integrate(brick, Dop853, PiController::tolerance(1e-12), start).until(30.0).final_state().unwrap()
    };
    let end = run(&free);
    let known = quaternion([
        -0.881147185310423750591,
        0.4701825277666920889806,
        0.01172825232487132353164,
        0.04868753947208382057598,
    ]);
    assert!(apart(&free.attitude_R(&end), &known) < 1e-10, "{:e}", apart(&free.attitude_R(&end), &known));
    let omega = free.angular_velocity_R(&end);
    let known = Vec3::new(0.2202324653429856642203, -0.3036432161227337779276, 0.5431392879442164817684);
    assert!((omega - known).norm() < 1e-11, "{omega}");
    // `Atmos_02_sim_01.csv`: degrees a second, against the axes at rest.
    let simulated = Vec3::new(12.61839077566776, -17.3974747618308, 31.11958888682995);
    assert!((omega.map(f64::to_degrees) - simulated).norm() < 1e-8);
    // `Atmos_03_sim_01.csv`: the altitude, and the rate that is damped least. (Here the axes turn with the Earth and
    // the air, without the force of Coriolis, which is 1e-5 of the weight.)
    let damped = brick(1.0);
    let end = run(&damped);
    assert!((end.q[0] - 15_598.9).abs() < 2.0, "{}", end.q[0]);
    let omega = damped.angular_velocity_R(&end).map(f64::to_degrees);
    assert!(omega.x.abs() < 1e-12 && omega.y.abs() < 1e-12, "{omega}");
    assert!((omega.z / 1.7355824190446156e-5 - 1.0).abs() < 3e-3, "{}", omega.z);
}

lagrangian! {
    /// A heavy body on its point.
    pub system Top {
        param A, B, C, a, b, c;
        coord R: rotation;
        let hull = frame(world, [0, 0, 0], R);
        T = body(0, [A, B, C], hull);
        V = hull.vector([a, b, c])[2];
        observe momentum = hull.vector([A * dot(R)[0], B * dot(R)[1], C * dot(R)[2]]);
        observe down = R.inverse() * [0, 0, 1];
    }
}

/// Quaternion and ω at the end.
const LAGRANGE: ([f64; 4], [f64; 3]) = (
    [
        -0.6487438239719924628545,
        0.6977933041840460405974,
        0.1799534326662814924428,
        -0.2446072721031203213951,
    ],
    [-0.8415021053227748586062, -0.471098367749524184503, 16.0],
);
const KOVALEVSKAYA: ([f64; 4], [f64; 3]) = (
    [0.9398992233784259954704, 0.05712388141645238520232, -0.272707314897012825137, 0.1973753593187666507136],
    [-3.267684061080936024482, 0.06847647382378679402866, -0.5946661730377419470523],
);
/// Also the angular momenta of the wheels.
const SATELLITE: ([f64; 4], [f64; 3], [f64; 3]) = (
    [0.6123266079198726856474, -0.1236860995569546985289, 0.4819167145258238574932, 0.6144218048461213201419],
    [0.6674365847667095747008, -0.6724697397208789531605, 0.6906676700840137211581],
    [-0.8, 0.6, -0.5],
);

#[test]
fn lagranges_top_keeps_its_integrals() {
    let top = Top::new(0.5, 0.5, 0.25, 0.0, 0.0, 4.0);
    integrals_are_kept(top, [0.5, 0.5, -0.5, 0.5], [0.25, 0.5, 16.0], 4.0, LAGRANGE);
}

#[test]
fn kovalevskayas_top_keeps_its_integrals() {
    let top = Top::new(1.0, 1.0, 0.5, 2.0, 0.0, 0.0);
    integrals_are_kept(top, [0.5, 0.5, 0.5, 0.5], [1.0, -2.0, 4.0], 10.0, KOVALEVSKAYA);
}

/// Digits of a motion, and its integrals by a symplectic method over many turns.
fn integrals_are_kept(
    top: Top,
    q: [f64; 4],
    omega: [f64; 3],
    end: f64,
    (attitude, rates): ([f64; 4], [f64; 3]),
) {
    let start = top.with_attitude_R(resting(), &quaternion(q), &omega.into());
    // Energy, the vertical angular momentum, and the third integral.
    let integrals = |at: &State<f64, 3>| {
        let omega = top.angular_velocity_R(at);
        let third = match top.a == 0.0 {
            true => omega.z,
            false => {
                // |(ω₁ + i ω₂)² − (a/C) (γ₁ + i γ₂)|², with the mass centre on the first axis.
                let gamma = top.attitude_R(at).inverse() * Vec3::z();
                let ratio = top.a / top.C;
                let real = omega.x * omega.x - omega.y * omega.y - ratio * gamma.x;
                let imaginary = 2.0 * omega.x * omega.y - ratio * gamma.y;
                real * real + imaginary * imaginary
            }
        };
        [top.energy_at(at), top.momentum(&at.q, &at.qd, at.t)[2], third]
    };
    let last =
        integrate(&top, Dop853, PiController::tolerance(1e-13), start).until(end).final_state().unwrap();
    let missed = apart(&top.attitude_R(&last), &quaternion(attitude));
    assert!(missed < 1e-9, "{missed:e}");
    assert!((top.angular_velocity_R(&last) - Vec3::from(rates)).norm() < 1e-9);
    let known = integrals(&start);
    let mut worst = [0.0f64; 3];
    for step in integrate(&top, lagrange_runtime::Gauss6, FixedStep::new(0.01), start).until(50.0) {
        let found = integrals(&step.unwrap().to);
        for i in 0..3 {
            worst[i] = worst[i].max((found[i] - known[i]).abs() / known[i].abs());
        }
    }
    println!("{worst:?}");
    assert!(worst.iter().all(|x| *x < 1e-6), "{worst:?}");
}

/// A top that is spun upright: above the critical rate ω₃² = 4 A m g l/C² it stays there, below it only if it is
/// exactly upright.
#[test]
fn a_top_sleeps_above_its_critical_rate() {
    let top = Top::new(0.5, 0.5, 0.25, 0.0, 0.0, 4.0);
    let critical = (4.0 * 0.5 * 4.0f64).sqrt() / 0.25;
    for (rate, sleeps) in [(1.2 * critical, true), (0.8 * critical, false)] {
        for aside in [0.0, 1e-12] {
            let tilt = UnitQuaternion::from_axis_angle(&Vec3::x_axis(), aside);
            let start = top.with_attitude_R(resting(), &tilt, &Vec3::new(0.0, 0.0, rate));
            // Small motions: the axis ζ = x + i y obeys A ζ̈ − i C ω₃ ζ̇ − m g l ζ = 0.
            let (half, square) = (0.5 * 0.25 * rate / 0.5, 4.0 / 0.5);
            let discriminant: f64 = half * half - square;
            let size = |t: f64| match sleeps {
                true => {
                    let root = discriminant.sqrt();
                    let (c, s) = ((root * t).cos(), (root * t).sin());
                    aside * (c * c + (half / root * s).powi(2)).sqrt()
                }
                false => {
                    let root = (-discriminant).sqrt();
                    let (c, s) = ((root * t).cosh(), (root * t).sinh());
                    aside * (c * c + (half / root * s).powi(2)).sqrt()
                }
            };
            let end = if sleeps { 50.0 } else { 5.0 };
            let check = |last: State<f64, 3>, name: &str| {
                let axis = top.attitude_R(&last) * Vec3::z();
                let found = axis.x.hypot(axis.y);
                println!("{name} at {rate:.2}, {aside:e} aside: {found:e}, {:e}", size(end));
                assert!(
                    (found - size(end)).abs() < 1e-2 * size(end) + 1e-17,
                    "{name}: {found:e} {:e}",
                    size(end)
                );
                let omega = top.angular_velocity_R(&last);
                assert!((omega.z - rate).abs() < 1e-10 * rate, "{name}: {omega}");
            };
            let run = integrate(&top, Dop853, PiController::tolerance(1e-12).atol(1e-22), start).until(end);
            check(run.final_state().unwrap(), "Dop853");
            let series = (Taylor::of_order(20), TaylorController::tolerance(1e-14));
            check(integrate(&top, series.0, series.1, start).until(end).final_state().unwrap(), "Taylor");
        }
    }
}

lagrangian! {
    /// A satellite in a field of gravity along the vertical, with a reaction wheel on each axis, of which the motors
    /// are inputs. A wheel has its own angular velocity against the hull.
    pub system Satellite {
        param J: [3], I, rate;
        input u: [3];
        coord R: rotation, spin: [3];
        let hull = frame(world, [0, 0, 0], R);
        let w = dot(R);
        // Hull and wheels, each of which turns about its axis by what the hull does, and more.
        T = body(0, J, hull) + 0.5 * I * ((w[0] + dot(spin[0])).powi(2) + (w[1] + dot(spin[1])).powi(2) + (w[2] + dot(spin[2])).powi(2));
        let n = R.inverse() * [0, 0, 1];
        V = 1.5 * rate.powi(2) * (J[0] * n[0].powi(2) + J[1] * n[1].powi(2) + J[2] * n[2].powi(2));
        Q[spin] = [-u[0], -u[1], -u[2]];
    }
}

#[test]
fn a_satellite_turns_by_its_wheels() {
    let inertia = 0.1;
    let satellite = Satellite { u: [0.1, -0.05, 0.02], ..Satellite::new([3.0, 2.0, 1.5], inertia, 0.5) };
    let omega = Vec3::new(0.25, -0.5, 0.75);
    let mut start = satellite.with_attitude_R(resting(), &quaternion([0.5, -0.5, 0.5, 0.5]), &omega);
    // h = I (ω + spin′)
    let h = [0.2, 0.1, -0.3];
    for i in 0..3 {
        start.qd[3 + i] = h[i] / inertia - omega[i];
    }
    let end = integrate(&satellite, Dop853, PiController::tolerance(1e-13), start)
        .until(10.0)
        .final_state()
        .unwrap();
    let (attitude, rates, wheels) = SATELLITE;
    let missed = apart(&satellite.attitude_R(&end), &quaternion(attitude));
    assert!(missed < 1e-11, "{missed:e}");
    let omega = satellite.angular_velocity_R(&end);
    assert!((omega - Vec3::from(rates)).norm() < 1e-11, "{omega}");
    let h = Vec3::from(std::array::from_fn(|i| inertia * (omega[i] + end.qd[3 + i])));
    assert!((h - Vec3::from(wheels)).norm() < 1e-11, "{h}");
}

lagrangian! {
    /// A multicopter that lifts a load on a rod: thrust along its third axis and moments are inputs.
    pub system Lifter {
        param m, load, l, J: [3], g = 9.81;
        input thrust, u: [3];
        coord x: [3], R: rotation, n: direction;
        let hull = frame(world, x, R);
        let place = hull.origin() + l * n;
        T = body(m, J, hull) + 0.5 * load * dot(place).norm_squared();
        V = m * g * x[2] + load * g * place[2];
        force [0, 0, thrust] at hull;
        couple u on hull;
    }
}

/// A rotation beside a direction.
#[test]
fn a_load_swings_below_what_lifts_it() {
    let lifter =
        Lifter { thrust: 20.0, u: [0.001, -0.002, 0.003], ..Lifter::new(1.5, 0.5, 0.75, [0.02, 0.03, 0.04]) };
    let start = lifter.with_attitude_R(resting(), &UnitQuaternion::identity(), &Vec3::new(0.5, -0.25, 1.0));
    let start = lifter.with_direction_n(start, &Vec3::new(0.0, 0.6, -0.8), &Vec3::x());
    let end =
        integrate(&lifter, Dop853, PiController::tolerance(1e-12), start).until(3.0).final_state().unwrap();
    let known = quaternion([
        -0.2692499565429549440672,
        0.1285436718422481109431,
        0.09860399023415613637543,
        0.9493462163198585927857,
    ]);
    assert!(apart(&lifter.attitude_R(&end), &known) < 1e-10);
    let omega = Vec3::new(0.2364220755434430793578, 0.6532138005292515513353, 1.149591202030882068331);
    assert!((lifter.angular_velocity_R(&end) - omega).norm() < 1e-10);
    let place = Vec3::new(9.90026210990857248977, -11.45646658671746618435, -3.97557196679611632326);
    assert!((end.q.fixed_rows::<3>(0) - place).norm() < 1e-9);
    let n = Vec3::new(-0.3158905509717057856479, 0.3215036928679866535559, -0.8926637302361060449161);
    assert!((lifter.direction_n(&end) - n).norm() < 1e-10, "{}", lifter.direction_n(&end));
    let rate = Vec3::new(1.398753289480176437616, 0.2446664695898810478387, -0.4068629221635299405901);
    assert!((end.qd.fixed_rows::<3>(6) - rate).norm() < 1e-10);
}

lagrangian! {
    /// A chain of bodies on ball joints.
    pub system Chain {
        const N = 8;
        param g;
        coord R: [rotation; N];
        let link: [N] = |i| frame(
            if i == 0 { world } else { link[i - 1] },
            if i == 0 { [0, 0, 0] } else { [0, 0, -1] },
            R[i]
        );
        let bob: [N] = |i| frame(link[i], [0.01, 0.02, -0.5]);
        T = (0..N).map(|i| body(1, [0.1, 0.11, 0.01], bob[i])).sum();
        V = (0..N).map(|i| g * bob[i].origin()[2]).sum();
    }
}

/// Against Newton's and Euler's laws with the forces in the joints as unknowns (`benches/references/ball_joints.py`,
/// in double precision).
#[test]
fn eight_bodies_hang_on_ball_joints() {
    let chain = Chain::new(9.81);
    let turned = |i: usize| UnitQuaternion::from_axis_angle(&Vector3::x_axis(), 0.3 + 0.2 * i as f64);
    let omega = |i: usize| Vec3::new(0.5, -0.25 * i as f64, 1.0);
    let mut start = resting();
    start = chain.with_attitude_R(0, start, &turned(0), &omega(0));
    for i in 1..8 {
        let relative = turned(i - 1).inverse() * turned(i);
        start = chain.with_attitude_R(i, start, &relative, &(omega(i) - relative.inverse() * omega(i - 1)));
    }
    let end =
        integrate(&chain, Dop853, PiController::tolerance(1e-11), start).until(0.5).final_state().unwrap();
    let (mut attitude, mut rates) = (UnitQuaternion::identity(), Vec3::zeros());
    for i in 0..8 {
        let relative = chain.attitude_R(i, &end);
        attitude *= relative;
        rates = relative.inverse() * rates + chain.angular_velocity_R(i, &end);
        let known = match i {
            0 => (
                [0.9357843628864876, 0.3295311021014181, -0.09513970056433457, 0.0816413884096051],
                [0.13108091428650445, -0.5362667635601659, 0.2702804507172072],
            ),
            7 => (
                [0.7435525209248931, 0.5523971273439915, -0.34533804505872423, -0.15076039587167062],
                [-1.4996897746615852, -0.6963051461303581, 0.6385243200732637],
            ),
            _ => continue,
        };
        assert!(
            apart(&attitude, &quaternion(known.0)) < 1e-9,
            "{i}: {:e}",
            apart(&attitude, &quaternion(known.0))
        );
        assert!((rates - Vec3::from(known.1)).norm() < 1e-8, "{i}: {rates}");
    }
}
