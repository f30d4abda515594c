//! An arm with seven axes, such as stands beside people in workshops, under three controllers.
//!
//! The arm is to follow a path of its joints; every millisecond the controller reads positions and velocities and
//! sets the torques, which are inputs of the system. *Computed torque*, τ = M (q̈* + K_d ė + K_p e) + b − f, takes M,
//! bias and force from a model that is the emitted system itself (Luh, Walker and Paul 1980; Siciliano et
//! al., *Robotics*, 2009, 8.5.2); it is run with the load in the hand known and unknown. *Gravity compensation* knows
//! the weight alone, τ = ∂V/∂q + K_p e + K_d ė with diagonal gains.
//!
//! `cargo run --release --example seven_axis_arm` draws the poses and the errors, and an animation.

#[path = "support/checks.rs"]
mod checks;
#[path = "support/mod.rs"]
mod support;

use checks::{Checks, table};
use lagrange_runtime::Stepper;
use lagrange_runtime::chart::{Animation, Axis, Chart, Panels, Part, Series, Style};
use lagrange_runtime::prelude::*;
use std::error::Error;
use std::f64::consts::TAU;
use std::ops::Range;

lagrangian! {
    /// Seven axes, along the links and across them in turn; upright where all angles are 0.
    pub system Arm {
        const N = 7;
        /// Masses of the links.
        param m: [N] = [4.1, 4.0, 3.0, 2.7, 1.7, 1.8, 0.3];
        /// Mass in the hand.
        param load = 0.0;
        /// Friction in the joints.
        param c = 0.5;
        param g = 9.81;
        /// Torques of the drives.
        input tau: [N];
        coord q: [angle; N];

        let up = [0.16, 0.2, 0.2, 0.22, 0.18, 0.22, 0.08, 0.12];
        let link: [N] = |i| frame(
            if i == 0 { world } else { link[i - 1] },
            [0, 0, up[i]],
            if i % 2 == 0 { rotation_z(q[i]) } else { rotation_y(q[i]) }
        );
        // Slender links: mass centres half way up, a little off the axes.
        let centre: [N] = |i| frame(link[i], [0, if i % 2 == 0 { -0.03 } else { 0.03 }, 0.5 * up[i + 1]]);
        let across: [N] = |i| m[i] * (up[i + 1] * up[i + 1] + 3 * 0.06 * 0.06) / 12;
        let hand = frame(link[6], [0, 0, up[7]]);

        T = (0..N).map(|i| body(m[i], [across[i], across[i], 0.5 * m[i] * 0.06 * 0.06], centre[i])).sum()
            + particle(load, hand);
        V = g * ((0..N).map(|i| m[i] * centre[i].origin()[2]).sum() + load * hand.origin()[2]);
        D = 0.5 * c * (0..N).map(|i| dot(q[i]).powi(2)).sum();
        Q[q] = tau;

        observe shoulder = link[1].origin();
        observe elbow = link[3].origin();
        observe wrist = link[5].origin();
        observe tip = hand.origin();
    }
}

type Joints = SVector<f64, 7>;

/// Position, velocity and acceleration that the joints are to have: one turn of a closed path in eight seconds.
fn wanted(t: f64) -> [Joints; 3] {
    let mean = Joints::from([0.3, 0.4, 0.0, 1.1, 0.2, 0.6, 0.0]);
    let swing = Joints::from([0.9, 0.3, 0.4, 0.4, 0.6, 0.4, 1.0]);
    let turns = Joints::from([1.0, 2.0, 1.0, 1.0, 2.0, 3.0, 1.0]);
    let phase = Joints::from([0.0, 1.2, 0.5, 0.3, 0.0, 1.9, 0.7]);
    let rate = turns * (TAU / 8.0);
    let angle = rate * t + phase;
    [
        mean + swing.component_mul(&angle.map(f64::sin)),
        swing.component_mul(&rate).component_mul(&angle.map(f64::cos)),
        -swing.component_mul(&rate).component_mul(&rate).component_mul(&angle.map(f64::sin)),
    ]
}

/// Model of the arm that the controller has.
enum Controller {
    Torque(Arm),
    Weight(Arm),
}

impl Controller {
    fn torques(&self, state: &State<f64, 7>) -> Joints {
        let State { q, qd, t } = state;
        let [place, velocity, acceleration] = wanted(*t);
        let (e, ed) = (place - q, velocity - qd);
        match self {
            Controller::Torque(arm) => {
                let a = acceleration + ed * 80.0 + e * 1600.0;
                arm.inertia(q, qd, *t) * a + arm.convective_momentum_rate(q, qd, *t)
                    - arm.momentum_rate(q, qd, *t)
            }
            Controller::Weight(arm) => {
                let gain = Joints::from([300.0, 300.0, 150.0, 150.0, 40.0, 40.0, 10.0]);
                -arm.momentum_rate(q, &Joints::zeros(), *t) + gain.component_mul(&(e + ed * 0.1))
            }
        }
    }
}

const STEP: f64 = 1e-3;
const END: f64 = 8.0;

/// States at each millisecond.
fn controlled(arm: Arm, controller: &Controller) -> Result<Vec<State<f64, 7>>, Failure> {
    let [place, velocity, _] = wanted(0.0);
    // It starts a little off its path.
    let start = State::new(0.0, place.add_scalar(0.02).into(), velocity.into());
    let mut stepper = Stepper::new(arm, Dop853, PiController::tolerance(1e-9), start)
        .every(STEP, |state, tau| *tau = controller.torques(state));
    let mut states = vec![start];
    for k in 1..=(END / STEP).round() as usize {
        stepper.advance_to(k as f64 * STEP)?;
        states.push(*stepper.state());
    }
    Ok(states)
}

/// The points of the arm: base, shoulder, elbow, wrist, hand.
fn points(arm: &Arm, s: &State<f64, 7>) -> [[f64; 3]; 5] {
    [
        [0.0; 3],
        arm.shoulder_at(s).into(),
        arm.elbow_at(s).into(),
        arm.wrist_at(s).into(),
        arm.tip_at(s).into(),
    ]
}

/// The place in a picture as seen from the front right, from a little above.
fn seen([x, y, z]: [f64; 3]) -> (f64, f64) {
    let (turn, tilt) = (0.6_f64, 0.35_f64);
    let across = -x * turn.sin() + y * turn.cos();
    let away = x * turn.cos() + y * turn.sin();
    (across, z * tilt.cos() - away * tilt.sin())
}

fn main() -> Result<(), Box<dyn Error>> {
    let operations = Arm::<f64>::FACTS.operations;
    println!(
        "accelerations: {} additions, {} multiplications, {} divisions and {} sine-cosine pairs (nothing depends on the first angle)",
        operations.additions, operations.multiplications, operations.divisions, operations.sin_cos
    );
    let mut checks = Checks::default();
    checks.at_most("operations an axis", operations.arithmetic() as f64 / 7.0, 244.0);
    let arm = Arm { load: 2.0, ..Arm::new() };
    let cases = [
        ("computed torque, load known", Controller::Torque(arm)),
        ("computed torque, load unknown", Controller::Torque(Arm { load: 0.0, ..arm })),
        ("gravity compensation", Controller::Weight(arm)),
    ];
    let mut errors =
        Chart::new("Error of the joints", Axis::linear("time", "s"), Axis::log("largest error", "rad"));
    let (mut motion, mut late) = (Vec::new(), Vec::new());
    for (name, controller) in &cases {
        let states = controlled(arm, controller)?;
        let error = |s: &State<f64, 7>| (wanted(s.t)[0] - s.q).amax();
        late.push(states.iter().filter(|s| s.t > END / 2.0).map(error).fold(0.0, f64::max));
        errors = errors.with(Series::line(*name, states.iter().step_by(20).map(|s| (s.t, error(s)))));
        if motion.is_empty() {
            motion = states;
        }
    }

    let rows = cases.iter().zip(&late).map(|((name, _), late)| [(*name).to_string(), format!("{late:.5}")]);
    println!("{}", table(["controller", "largest error in the second half (rad)"], rows));
    checks.at_most("error by computed torque, load known (rad)", late[0], 1e-3);
    checks.at_most("error by gravity compensation (rad)", late[2], 0.1);
    checks.holds("a load that is not known costs more than knowing the weight alone", late[1] > late[2]);

    // Without torques it falls; with those of its weight alone it stays where it is.
    let rest = State::new(0.0, wanted(0.0)[0].into(), [0.0; 7]);
    let weight = -arm.momentum_rate(&rest.q, &rest.qd, 0.0);
    let (mut moved, mut lost) = ([0.0; 2], 0.0_f64);
    for (i, tau) in [weight, Joints::zeros()].into_iter().enumerate() {
        let held = Arm { tau: tau.into(), ..arm };
        let mut run = integrate(&held, Dop853, PiController::tolerance(1e-11), rest)
            .until(0.5)
            .integrals([0.0], |at| [held.power_at(at)]);
        for step in &mut run {
            let step = step?;
            let energy = held.energy_at(&step.state) - held.energy_at(&rest);
            lost = lost.max((energy - step.integrals[0]).abs());
            moved[i] = (step.state.q - rest.q).amax();
        }
    }
    checks.at_most("moved under torques of its weight, in half a second (rad)", moved[0], 1e-9);
    checks.holds("moved without torques", moved[1] > 1.0);
    checks.at_most("energy against the work of friction and drives (J)", lost, 1e-8);

    let mut poses = Chart::new("Poses", Axis::linear("across", "m"), Axis::linear("up", "m")).equal_aspect();
    let path = motion.iter().step_by(10).map(|s| seen(points(&arm, s)[4]));
    poses = poses.with(Series::line("path of the hand", path));
    for k in 0..8 {
        let at = points(&arm, &motion[k * 1000]).map(seen);
        let series = Series { style: Style::Context, ..Series::line("", at) };
        poses = poses.with(series);
    }
    let folder = support::charts()?;
    Panels::new("An arm with seven axes on its path", [poses, errors])
        .subtitle("load of 2 kg; torques set every millisecond; a start 0.02 rad off the path")
        .write(&folder, "seven-axis-arm")?;
    animation(&arm, &motion).write(&folder, "seven-axis-arm-moving")?;
    println!("{}", folder.join("seven-axis-arm.svg").display());
    println!("{}", folder.join("seven-axis-arm-moving.svg").display());
    Ok(checks.report()?)
}

/// One turn of the path as a moving picture.
fn animation(arm: &Arm, motion: &[State<f64, 7>]) -> Animation {
    let frames: Vec<[(f64, f64); 5]> = motion.iter().step_by(80).map(|s| points(arm, s).map(seen)).collect();
    let part =
        |name: &str, of: Range<usize>| Part::bars(name, frames.iter().map(move |at| at[of.clone()].to_vec()));
    let floor = (0..48).map(|k| (TAU * f64::from(k) / 48.0).sin_cos());
    let floor = floor.map(|(sin, cos)| seen([0.35 * cos, 0.35 * sin, 0.0])).collect();
    Animation::new("An arm with seven axes on its path", END)
        .subtitle("load of 2 kg; torques set every millisecond")
        .with(Part { colour: None, ..Part::body("floor", [floor]) })
        .with(
            Part::path("path of the hand", motion.iter().step_by(20).map(|s| seen(points(arm, s)[4])))
                .width(2.5)
                .colour(6),
        )
        .with(part("shoulder", 0..3).width(26.0).colour(7))
        .with(part("elbow", 2..4).width(20.0).colour(0))
        .with(part("wrist", 3..5).width(13.0).colour(1))
}
