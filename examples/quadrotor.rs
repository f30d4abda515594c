//! A quadrotor that is thrown upside down rights itself and takes the load below it along a figure of eight.
//!
//! Its attitude is a rotation and the rod to the load a direction, so that no attitude is special to either. Two
//! hundred times a second a controller sets the thrusts of the four rotors, which only push. It has three loops, each
//! inside the next (Sreenath, Lee and Kumar, *CDC* 2013; Lee, Leok and McClamroch, *CDC* 2010):
//!
//! - the load is to have the acceleration `a = a* − k_p e − k_d ė`, for which the rod has to point along `−(a + g)`;
//! - the rod turns there by the force across it: `n̈ = −F/(m l)`, and the force along it lifts load and quadrotor;
//! - the attitude turns the thrust into the direction of F, by moments from the rotation vector between the two.
//!
//! `cargo run --release --example quadrotor` draws path, error, tilt and tension, and an animation.

#[path = "support/checks.rs"]
mod checks;
#[path = "support/mod.rs"]
mod support;

use checks::Checks;
use lagrange_runtime::Stepper;
use lagrange_runtime::analysis::StateSpace;
use lagrange_runtime::chart::{Animation, Axis, Chart, Panels, Part, Series, Style};
use lagrange_runtime::prelude::*;
use std::error::Error;
use std::f64::consts::TAU;

lagrangian! {
    /// A quadrotor with a load on a rod.
    pub system Quadrotor {
        /// Masses of quadrotor and load, in kg.
        param m = 1.5, load = 0.5;
        /// Length of the rod and distance of the rotors from the mass centre, in m.
        param l = 0.75, arm = 0.2;
        /// Principal moments of inertia, and moment of a rotor for a thrust of 1 N.
        param J: [3] = [0.02, 0.02, 0.035], drag = 0.02;
        param g = 9.81;
        /// Thrusts of the rotors, in N.
        input f: [4];
        coord x: [3], R: rotation, n: direction;

        let hull = frame(world, x, R);
        let place = hull.origin() + l * n;
        T = body(m, J, hull) + 0.5 * load * dot(place).norm_squared();
        V = m * g * x[2] + load * g * place[2];
        force [0, 0, f[0]] at frame(hull, [arm, 0, 0]);
        force [0, 0, f[1]] at frame(hull, [0, arm, 0]);
        force [0, 0, f[2]] at frame(hull, [-arm, 0, 0]);
        force [0, 0, f[3]] at frame(hull, [0, -arm, 0]);
        couple [0, 0, drag * (f[1] + f[3] - f[0] - f[2])] on hull;

        observe bob = place;
        observe bob_velocity = dot(place);
        /// Tension of the rod.
        observe tension = -reaction(n) / l;
    }
}

type Vec3 = Vector3<f64>;
type At = State<f64, 9>;

/// Sample time, in s.
const PERIOD: f64 = 0.005;
const END: f64 = 14.0;
/// Largest thrust of a rotor, in N.
const STRONGEST: f64 = 12.0;
/// Time of one figure of eight, in s.
const TURN: f64 = 6.0;

/// Position, velocity and acceleration that the load is to have.
fn wanted(t: f64) -> [Vec3; 3] {
    let (rate, size, turns) = (TAU / TURN, Vec3::new(1.6, 0.8, 0.3), Vec3::new(1.0, 2.0, 2.0));
    let phase = Vec3::new(0.0, 0.0, 1.2);
    let (angle, rate) = (turns * (rate * t) + phase, turns * rate);
    let swing = size.component_mul(&rate);
    [
        size.component_mul(&angle.map(f64::sin)),
        swing.component_mul(&angle.map(f64::cos)),
        -swing.component_mul(&rate).component_mul(&angle.map(f64::sin)),
    ]
}

/// First and second derivative, by differences, of the direction of the rod where the load is where it is to be.
fn pointing(t: f64, g: f64) -> [Vec3; 2] {
    const H: f64 = 1e-3;
    let at = |t: f64| -(wanted(t)[2] + Vec3::z() * g).normalize();
    let [before, now, after] = [at(t - H), at(t), at(t + H)];
    [(after - before) / (2.0 * H), (after - now * 2.0 + before) / (H * H)]
}

/// No longer than this.
fn limited(v: Vec3, most: f64) -> Vec3 {
    v * (most / v.norm()).min(1.0)
}

/// Memory of the controller: the attitude that it wanted at the last sampling instant.
struct Controller {
    plant: Quadrotor,
    last: Option<UnitQuaternion<f64>>,
}

impl Controller {
    /// The thrusts for the period that begins.
    fn thrusts(&mut self, at: &At) -> [f64; 4] {
        let Quadrotor { arm, drag, J, .. } = self.plant;
        let (attitude, omega) = (self.plant.attitude_R(at), self.plant.angular_velocity_R(at));
        let force = self.force(at);
        // The third axis along the force, the first one in the plane of x.
        let third = force.normalize();
        let second = third.cross(&Vec3::x()).normalize();
        let axes = nalgebra::Matrix3::from_columns(&[second.cross(&third), second, third]);
        let target = UnitQuaternion::from_matrix(&axes);
        let since = |last: UnitQuaternion<f64>| (last.inverse() * target).scaled_axis() / PERIOD;
        let rate = self.last.replace(target).map_or(Vec3::zeros(), since);
        let turn = (attitude.inverse() * target).scaled_axis();
        let rate = limited((attitude.inverse() * target) * rate, 4.0);
        let inertia = Vec3::from(J);
        let moment = inertia.component_mul(&(turn * 400.0 + (rate - omega) * 36.0))
            + omega.cross(&inertia.component_mul(&omega));
        let thrust = force.dot(&(attitude * Vec3::z())).max(0.0);
        // Turning about the third axis takes much thrust for little moment, and comes last.
        let (roll, pitch) = (0.5 * moment.x / arm, 0.5 * moment.y / arm);
        let yaw = (0.25 * moment.z / drag).clamp(-0.5, 0.5);
        let quarter = (0.25 * thrust).min(0.75 * STRONGEST);
        [quarter - pitch - yaw, quarter + roll + yaw, quarter + pitch - yaw, quarter - roll + yaw]
            .map(|f| f.clamp(0.0, STRONGEST))
    }

    /// The force on the quadrotor that brings the load to its place and lifts both.
    fn force(&self, at: &At) -> Vec3 {
        let Quadrotor { m, load, l, g, .. } = self.plant;
        let (n, rate) = (self.plant.direction_n(at), at.qd.fixed_rows::<3>(6).into_owned());
        let [place, velocity, acceleration] = wanted(at.t);
        let (error, error_rate) = (place - self.plant.bob_at(at), velocity - self.plant.bob_velocity_at(at));
        let needed = acceleration + limited(error * 4.0 + error_rate * 3.6, 5.0) + Vec3::z() * g;
        let [rod_rate, rod_acceleration] = pointing(at.t, g);
        let aside = |v: Vec3| v - n * n.dot(&v);
        let turning =
            aside(-needed.normalize()) * 40.0 + (aside(rod_rate) - rate) * 10.0 + aside(rod_acceleration);
        let along = (m + load) * needed.dot(&n) + m * l * rate.norm_squared();
        n * along - turning * (m * l)
    }
}

/// States at each sampling instant, with the thrusts up to there.
fn flown(quadrotor: Quadrotor, start: At) -> Result<Vec<(At, [f64; 4])>, Failure> {
    let mut controller = Controller { plant: quadrotor, last: None };
    let mut stepper = Stepper::new(quadrotor, Dop853, PiController::tolerance(1e-9), start)
        .every(PERIOD, |at, f| *f = controller.thrusts(at).into());
    let mut motion = vec![(start, [0.0; 4])];
    for k in 1..=(END / PERIOD).round() as u32 {
        stepper.advance_to(f64::from(k) * PERIOD)?;
        motion.push((*stepper.state(), stepper.inputs().into()));
    }
    Ok(motion)
}

/// The place in a picture as seen from the front, from a little above.
fn seen(at: Vec3) -> (f64, f64) {
    let (turn, tilt) = (0.35_f64, 0.45_f64);
    let across = at.x * turn.cos() + at.y * turn.sin();
    let away = at.y * turn.cos() - at.x * turn.sin();
    (across, at.z * tilt.cos() + away * tilt.sin())
}

pub(crate) fn main() -> Result<(), Box<dyn Error>> {
    let quadrotor = Quadrotor::new();
    let mut checks = Checks::default();

    // Hovering, the load swings against the quadrotor, whose thrust keeps its direction: ω² = g (m + load)/(m l).
    let at_rest = State::new(0.0, [0.0; 9], [0.0; 9]);
    let hang = quadrotor.with_direction_n(at_rest, &-Vec3::z(), &Vec3::zeros());
    let Quadrotor { m, load, l, g, .. } = quadrotor;
    let hovering = Quadrotor { f: [0.25 * (m + load) * g; 4], ..quadrotor };
    let swing = (g * (m + load) / (m * l)).sqrt();
    let poles = StateSpace::about(&hovering, &hang)?.poles()?;
    let quickest = poles.iter().map(|pole| pole.im).fold(0.0, f64::max);
    checks.at_most(
        "swing of the load about hovering against its closed form",
        (quickest / swing - 1.0).abs(),
        1e-12,
    );

    // Thrown upside down, all but a degree, the load below it.
    let inverted = UnitQuaternion::from_axis_angle(&Vec3::x_axis(), 179_f64.to_radians());
    let mut start = quadrotor.with_attitude_R(hang, &inverted, &Vec3::new(0.0, 0.0, 1.0));
    start.q.fixed_rows_mut::<3>(0).copy_from(&Vec3::new(-1.5, 1.0, 2.0));
    start.qd.fixed_rows_mut::<3>(0).copy_from(&Vec3::new(1.0, 0.0, 3.0));
    let motion = flown(quadrotor, start)?;

    let tilt = |at: &At| (quadrotor.attitude_R(at) * Vec3::z()).z.clamp(-1.0, 1.0).acos().to_degrees();
    let error = |at: &At| (quadrotor.bob_at(at) - wanted(at.t)[0]).norm();
    let tension = |(at, f): &(At, [f64; 4])| Quadrotor { f: *f, ..quadrotor }.tension(&at.q, &at.qd, at.t);
    let after = |t: f64| motion.iter().filter(move |(at, _)| at.t > t);
    let upright = motion.iter().rposition(|(at, _)| tilt(at) > 70.0).map_or(0.0, |k| motion[k].0.t);
    checks.at_most("tilted by less than 70° after (s)", upright, 1.5);
    let late = after(END - TURN).map(|(at, _)| error(at)).fold(0.0, f64::max);
    checks.at_most("distance of the load from its place in the last turn (m)", late, 0.01);
    let slack = after(END - TURN).map(tension).fold(f64::INFINITY, f64::min);
    checks.holds("the rod pulls in the last turn: a cable would do", slack > 1.0);
    let thrusts = || motion.iter().flat_map(|(_, f)| f);
    checks.holds("rotors push, and no more than they can", thrusts().all(|f| (0.0..=STRONGEST).contains(f)));
    let length = |(at, _): &(At, [f64; 4])| (quadrotor.direction_n(at).norm() - 1.0).abs();
    checks.at_most("length of the direction", motion.iter().map(length).fold(0.0, f64::max), 1e-15);

    let time = || Axis::linear("time", "s");
    let every = || motion.iter().step_by(4);
    let path = |of: &dyn Fn(&At) -> Vec3| every().map(|(at, _)| seen(of(at))).collect::<Vec<_>>();
    let mut view = Chart::new("Path", Axis::linear("across", "m"), Axis::linear("up", "m")).equal_aspect();
    view = view.with(Series::line("load", path(&|at| quadrotor.bob_at(at))));
    view = view.with(Series::line("wanted", path(&|at| wanted(at.t)[0])));
    for (at, _) in motion.iter().step_by(24).take(8) {
        for line in lines(&quadrotor, at) {
            view = view.with(Series { style: Style::Context, ..Series::line("", line) });
        }
    }
    let errors = Chart::new("Load", time(), Axis::log("distance from its place", "m"))
        .with(Series::line("distance", every().map(|(at, _)| (at.t, error(at)))));
    let turned = Chart::new("Attitude", time(), Axis::linear("tilt", "°"))
        .with(Series::line("tilt", every().map(|(at, _)| (at.t, tilt(at)))));
    let rod = Chart::new("Rod", time(), Axis::linear("tension", "N"))
        .with(Series::line("tension", every().map(|both| (both.0.t, tension(both)))));
    let folder = support::charts()?;
    let subtitle = "thrown at a tilt of 179°; four thrusts set every 5 ms";
    Panels::new("A quadrotor takes a load along a figure of eight", [view, errors, turned, rod])
        .subtitle(subtitle)
        .write(&folder, "quadrotor")?;
    animation(&quadrotor, &motion).subtitle(subtitle).write(&folder, "quadrotor-moving")?;
    println!("{}", folder.join("quadrotor.svg").display());
    println!("{}", folder.join("quadrotor-moving.svg").display());
    Ok(checks.report()?)
}

/// Both arms and the rod.
fn lines(quadrotor: &Quadrotor, at: &At) -> [Vec<(f64, f64)>; 3] {
    let (centre, attitude) = (at.q.fixed_rows::<3>(0).into_owned(), quadrotor.attitude_R(at));
    let rotor = |x: f64, y: f64| centre + attitude * (Vec3::new(x, y, 0.0) * quadrotor.arm);
    [[rotor(1.0, 0.0), rotor(-1.0, 0.0)], [rotor(0.0, 1.0), rotor(0.0, -1.0)], [centre, quadrotor.bob_at(at)]]
        .map(|line| line.map(seen).to_vec())
}

/// The quadrotor and its load.
fn animation(quadrotor: &Quadrotor, motion: &[(At, [f64; 4])]) -> Animation {
    let frames: Vec<_> = motion.iter().step_by(12).map(|(at, _)| lines(quadrotor, at)).collect();
    let line = |name: &str, k: usize| Part::bars(name, frames.iter().map(move |all| all[k].clone()));
    let eight = (0..=200).map(|k| seen(wanted(TURN * f64::from(k) / 200.0)[0]));
    Animation::new("A quadrotor takes a load along a figure of eight", END)
        .with(Part::path("wanted", eight).colour(7))
        .with(
            Part::path(
                "path of the load",
                motion.iter().step_by(6).map(|(at, _)| seen(quadrotor.bob_at(at))),
            )
            .colour(6),
        )
        .with(line("rod", 2).width(1.5).colour(7))
        .with(line("arm", 0).width(5.0).colour(0))
        .with(line("other arm", 1).width(5.0).colour(2))
        .with(Part::joints("load", frames.iter().map(|all| vec![all[2][1]])).width(13.0).colour(1))
}
