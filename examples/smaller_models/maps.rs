//! Breakdown maps: an amplitude by a parameter, and at each place the smallest model that holds.

use super::checks::Checks;
use super::motion::{Motion, Scene};
use super::systems::{
    Arm, Bending, Crank, Driven, Duffing, Elastic, Foucault, Gyroscopic, HangingChain, Kapitza, Linear,
    LongRod, Mean, Moving, Oscillator, Planar, Quartic, Resting, Rigid, RigidRod, Rod, Slow, SmallFoucault,
    SmallResting, SmallRod, Spatial, Still, Top,
};
use lagrange_runtime::analysis::ModalModel;
use lagrange_runtime::chart::{Axis, Breakdown};
use lagrange_runtime::prelude::*;
use lagrange_runtime::testing::reference::SimplePendulum;
use nalgebra::Complex;
use std::error::Error;
use std::f64::consts::TAU;

type Drawn = Result<Breakdown, Box<dyn Error>>;

/// Places of an axis, in equal ratios.
struct Range(f64, f64);

impl Range {
    fn places(&self, count: u32) -> Vec<f64> {
        let Range(from, to) = *self;
        (0..count).map(|i| from * (to / from).powf(f64::from(i) / f64::from(count - 1))).collect()
    }
}

/// A map with the errors of all models at each place of a lattice, of which the whole system has none.
fn filled<const K: usize>(
    mut map: Breakdown,
    ranges: [Range; 2],
    count: u32,
    errors: impl Fn(f64, f64) -> Result<[f64; K], Failure<f64>>,
) -> Drawn {
    let [across, up] = ranges.map(|range| range.places(count));
    for &x in &across {
        for &y in &up {
            map = map.with((x, y), errors(x, y)?.into_iter().chain([0.0]));
        }
    }
    Ok(map)
}

/// The largest difference of what a motion shows from a closed form, which is given the time.
fn from_closed_form(motion: &Motion, end: f64, form: impl Fn(f64) -> [f64; 2]) -> f64 {
    let count = motion.outputs.len() as f64 - 1.0;
    let times = (0..motion.outputs.len()).map(|i| end * i as f64 / count);
    let errors = times.zip(&motion.outputs).map(|(t, found)| {
        let [x, y] = form(t);
        (found[0] - x).hypot(found[1] - y)
    });
    errors.fold(0.0, f64::max)
}

/// All maps, of so many places along each axis.
pub fn maps(count: u32, checks: &mut Checks) -> Result<Vec<Breakdown>, Box<dyn Error>> {
    Ok(vec![
        double_pendulum(count, checks)?,
        spring_pendulum(count, checks)?,
        kapitza(count, checks)?,
        top(count, checks)?,
        slider_crank(count, checks)?,
        foucault(count, checks)?,
        car(count, checks)?,
        driven(count, checks)?,
        arm(count, checks)?,
    ])
}

fn double_pendulum(count: u32, checks: &mut Checks) -> Drawn {
    let axes = [Axis::log("start out of the plane", "rad"), Axis::log("amplitude", "rad")];
    let models = ["small oscillations in the plane", "order 4 in the plane", "in the plane", "in space"];
    let map = Breakdown::new("Double pendulum", axes, models, 0.01).subtitle("tip to 1 % of its length, 5 s");
    let system = Spatial::new(1.0, 1.0, 0.5, 0.5);
    let errors = |tilt: f64, amplitude: f64| {
        let start = State::new(0.0, [amplitude / 2.0, 0.0, amplitude, tilt], [0.0; 4]);
        let scene = Scene { whole: &system, start, end: 5.0, output: |system, s| system.tip_at(s) };
        let whole = scene.reference()?;
        Ok([
            scene.error::<Linear, 2, 2>(&whole),
            scene.error::<Quartic, 2, 2>(&whole),
            scene.error::<Planar, 2, 2>(&whole),
        ])
    };
    let map = filled(map, [Range(1e-3, 0.1), Range(0.02, 2.0)], count, errors)?;
    let in_plane = map.limit(2, 1e-3).unwrap_or(0.0);
    let limits = [map.limit(0, 1e-3), map.limit(1, 1e-3)].map(|limit| limit.unwrap_or(0.0));
    checks.holds(
        "double pendulum: each model holds further",
        0.0 < limits[0] && limits[0] < limits[1] && limits[1] < in_plane,
    );
    Ok(map)
}

fn spring_pendulum(count: u32, checks: &mut Checks) -> Drawn {
    let axes = [Axis::log("stiffness k l / (m g)", ""), Axis::log("amplitude", "rad")];
    let models = ["small oscillations on a rod", "on a rod", "on a spring"];
    let map =
        Breakdown::new("Pendulum on a spring", axes, models, 0.02).subtitle("bob to 2 % of its length, 5 s");
    let at = |amplitude: f64| State::new(0.0, [amplitude, 1.0], [0.0; 2]);
    let errors = |stiffness: f64, amplitude: f64| {
        let system = Elastic::new(1.0, 1.0, 9.81 * stiffness);
        let scene =
            Scene { whole: &system, start: at(amplitude), end: 5.0, output: |system, s| system.bob_at(s) };
        let whole = scene.reference()?;
        Ok([scene.error::<SmallRod, 1, 1>(&whole), scene.error::<Rod, 1, 1>(&whole)])
    };
    let map = filled(map, [Range(10.0, 1e4), Range(0.03, 2.5)], count, errors)?;

    let system = Elastic::new(1.0, 1.0, 1e3);
    let scene = Scene { whole: &system, start: at(2.0), end: 5.0, output: |_, s| [s.q[0], 0.0, 0.0].into() };
    let rod = scene.model::<Rod, 1, 1, _, _>(Dop853, PiController::tolerance(1e-10))?;
    let elliptic = SimplePendulum::new(9.81, 1.0, 2.0, 0.0);
    checks.at_most(
        "rod against elliptic functions (rad)",
        from_closed_form(&rod, 5.0, |t| [elliptic.state(t).0, 0.0]),
        1e-8,
    );
    Ok(map)
}

fn kapitza(count: u32, checks: &mut Checks) -> Drawn {
    let axes =
        [Axis::log("rate of the pivot by that of the pendulum", ""), Axis::log("amplitude by length", "")];
    let models = ["pivot at rest", "mean of the motion", "shaken pivot"];
    let map = Breakdown::new("Kapitza's pendulum", axes, models, 0.1)
        .subtitle("angle to 0.1 rad, from 1 rad, three periods of the pendulum");
    // The pendulum at rest has the rate 1.
    let scene = |start: f64, end: f64| {
        (State::new(0.0, [start], [0.0]), end, |system: &Kapitza, s: &State<f64, 1>| system.angle_at(s))
    };
    let system = |rate: f64, a: f64| Kapitza { g: 1.0, ..Kapitza::new(1.0, a, rate) };
    let errors = |rate: f64, a: f64| {
        let (system, (start, end, output)) = (system(rate, a), scene(1.0, 3.0 * TAU));
        let scene = Scene { whole: &system, start, end, output };
        let whole = scene.reference()?;
        Ok([scene.error::<Still, 1, 0>(&whole), scene.error::<Mean, 1, 0>(&whole)])
    };
    let map = filled(map, [Range(1.5, 100.0), Range(1e-3, 0.3)], count, errors)?;

    // The effective potential about the lowest point: 1 + a² ω² / 2 for the square of the frequency.
    let (system, (start, end, output)) = (system(40.0, 0.05), scene(1e-5, 10.0));
    let scene = Scene { whole: &system, start, end, output };
    let mean = scene.model::<Mean, 1, 0, _, _>(Dop853, PiController::tolerance(1e-12))?;
    checks.at_most(
        "mean motion against its frequency, of its amplitude",
        from_closed_form(&mean, end, |t| [1e-5 * (3f64.sqrt() * t).cos(), 0.0]) / 1e-5,
        1e-6,
    );
    Ok(map)
}

fn top(count: u32, checks: &mut Checks) -> Drawn {
    let axes = [Axis::log("spin p² / (4 A m g h)", ""), Axis::log("tilt at the start", "rad")];
    let models = ["sleeping top", "small tilts, gyroscopic", "whole top"];
    let map = Breakdown::new("Top", axes, models, 0.05)
        .subtitle("axis to 0.05; its own time √(A / (m g h)), of which the scene has 8");
    let start = |tilt: f64| State::new(0.0, [(0.5 * tilt).tan(), 0.0], [0.0; 2]);
    let errors = |spin: f64, tilt: f64| {
        let system = Top::new(1.0, (4.0 * spin).sqrt(), 1.0);
        let scene =
            Scene { whole: &system, start: start(tilt), end: 8.0, output: |system, s| system.axis_at(s) };
        let whole = scene.reference()?;
        let upright = SVector::from([0.0, 0.0, 1.0]);
        let sleeping = whole.outputs.iter().map(|axis| (axis - upright).norm()).fold(0.0, f64::max);
        Ok([sleeping, scene.error::<Gyroscopic, 2, 0>(&whole)])
    };
    let map = filled(map, [Range(0.1, 30.0), Range(1e-3, 1.5)], count, errors)?;

    // ζ = u + i v turns by two rates λ, the roots of A λ² − p λ + m g h.
    let (system, tilt) = (Top::new(1.0, 3.0, 1.0), 0.02);
    let scene =
        Scene { whole: &system, start: start(tilt), end: 8.0, output: |_, s| [s.q[0], s.q[1], 0.0].into() };
    let small = scene.model::<Gyroscopic, 2, 0, _, _>(Dop853, PiController::tolerance(1e-11))?;
    let [fast, slow] = [1.0, -1.0].map(|sign| 0.5 * (3.0 + sign * 5f64.sqrt()));
    let turned = |t: f64| {
        let [a, b] = [fast, slow].map(|rate| Complex::new(0.0, rate * t).exp());
        let z = (0.5 * tilt).tan() * (b * fast - a * slow) / (fast - slow);
        [z.re, z.im]
    };
    checks.at_most(
        "small tilts against their two precessions, of the tilt",
        from_closed_form(&small, 8.0, turned) / tilt,
        1e-8,
    );
    Ok(map)
}

fn slider_crank(count: u32, checks: &mut Checks) -> Drawn {
    let axes = [Axis::log("rate by that of the piston on its rod", ""), Axis::log("crank by rod", "")];
    let models = ["endless rigid rod", "rigid rod", "elastic rod"];
    let map = Breakdown::new("Slider-crank", axes, models, 0.02)
        .subtitle("piston to 2 % of its stroke, five turns");
    let errors = |rate: f64, radius: f64| {
        // Lengths in those of the rod, and times in those of the piston on it.
        let system = Crank::new(5.0 * radius * radius, radius, 1.0, 1.0, 1.0, 0.1);
        let start = State::new(0.0, [0.0; 2], [rate, 0.0]);
        let scene =
            Scene { whole: &system, start, end: 5.0 * TAU / rate, output: |system, s| system.place_at(s) };
        let whole = scene.reference()?;
        let stroke = 2.0 * radius;
        Ok([scene.error::<LongRod, 1, 1>(&whole) / stroke, scene.error::<RigidRod, 1, 1>(&whole) / stroke])
    };
    let map = filled(map, [Range(0.01, 0.3), Range(0.01, 0.6)], count, errors)?;
    let slow = |model| map.limit(model, 0.01).unwrap_or(0.0);
    checks.holds("slider-crank: a slow rigid rod may lean", slow(0) < 0.5 && slow(1) > 0.5);
    // The rod stretches by m ẍ / k, to twice that at a start from s = 0: by the square of the ratio of the rates.
    let fast = map.places.iter().filter(|((rate, _), _)| *rate > 0.15);
    let least = fast.map(|(_, errors)| errors[1]).fold(f64::INFINITY, f64::min);
    checks.holds("slider-crank: fast rods stretch", least > 0.15f64.powi(2));
    Ok(map)
}

fn foucault(count: u32, checks: &mut Checks) -> Drawn {
    let axes = [Axis::log("turns of the table by oscillations", ""), Axis::log("amplitude by length", "")];
    let models = ["small, table at rest", "small, table turns", "table at rest", "whole"];
    let map = Breakdown::new("Foucault's pendulum", axes, models, 0.05)
        .subtitle("place to 5 % of the amplitude, ten oscillations");
    let rate = 9.81f64.sqrt();
    let end = 10.0 * TAU / rate;
    let at = |x: f64| State::new(0.0, [x, 0.0], [0.0; 2]);
    let errors = |turn: f64, x: f64| {
        let system = Foucault::new(1.0, turn * rate);
        let scene = Scene { whole: &system, start: at(x), end, output: |system, s| system.place_at(s) };
        let whole = scene.reference()?;
        Ok([
            scene.error::<SmallResting, 2, 0>(&whole) / x,
            scene.error::<SmallFoucault, 2, 0>(&whole) / x,
            scene.error::<Resting, 2, 0>(&whole) / x,
        ])
    };
    let map = filled(map, [Range(1e-5, 0.1), Range(0.01, 0.9)], count, errors)?;

    // An ellipse in the room, as seen from the table.
    let turn = 0.02;
    let system = Foucault::new(1.0, turn * rate);
    let scene = Scene { whole: &system, start: at(0.1), end, output: |system, s| system.place_at(s) };
    let small = scene.model::<SmallFoucault, 2, 0, _, _>(Dop853, PiController::tolerance(1e-11))?;
    let turned = |t: f64| {
        let ellipse = Complex::new((rate * t).cos(), turn * (rate * t).sin());
        let z = 0.1 * ellipse * Complex::new(0.0, -turn * rate * t).exp();
        [z.re, z.im]
    };
    checks.at_most(
        "small oscillations against an ellipse that turns, of the amplitude",
        from_closed_form(&small, end, turned) / 0.1,
        1e-8,
    );
    Ok(map)
}

fn car(count: u32, checks: &mut Checks) -> Drawn {
    let axes = [
        Axis::log("stiffness of the tyre by that of the spring", ""),
        Axis::log("rate of the bumps", "rad/s"),
    ];
    let models = ["rigid tyre", "tyre in statics", "elastic tyre"];
    let map =
        Breakdown::new("Quarter of a car", axes, models, 0.01).subtitle("body to 1 % of the bumps, 5 s");
    let errors = |stiffness: f64, omega: f64| {
        let system = super::car(stiffness, omega);
        let start = State::new(0.0, [0.0; 2], [0.0; 2]);
        let scene = Scene { whole: &system, start, end: 5.0, output: |system, s| system.height_at(s) };
        let whole = scene.reference()?;
        Ok([scene.error::<Rigid, 1, 1>(&whole) / system.a, scene.error::<Slow, 1, 1>(&whole) / system.a])
    };
    let map = filled(map, [Range(10.0, 1e3), Range(0.5, 200.0)], count, errors)?;
    let limits = [map.limit(0, 10.0), map.limit(1, 10.0)].map(|limit| limit.unwrap_or(0.0));
    checks.holds("quarter of a car: statics hold further than a rigid tyre", limits[1] > limits[0]);
    Ok(map)
}

fn driven(count: u32, checks: &mut Checks) -> Drawn {
    let axes = [
        Axis::log("rate of the drive by that of the pendulum", ""),
        Axis::log("torque by that of the weight", ""),
    ];
    let models = ["small oscillations", "order 4 (Duffing)", "pendulum"];
    let map = Breakdown::new("Damped and driven pendulum", axes, models, 0.05)
        .subtitle("angle to 0.05 rad, from rest, ten of its own periods");
    let end = 10.0 * TAU;
    let start = State::new(0.0, [0.0], [0.0]);
    let errors = |omega: f64, gamma: f64| {
        let system = Driven::new(0.1, gamma, omega);
        let scene = Scene { whole: &system, start, end, output: |system, s| system.angle_at(s) };
        let whole = scene.reference()?;
        Ok([scene.error::<Oscillator, 1, 0>(&whole), scene.error::<Duffing, 1, 0>(&whole)])
    };
    let map = filled(map, [Range(0.1, 10.0), Range(0.01, 2.0)], count, errors)?;

    // x = Re(X e^{iωt}) less the free motion with the same start, ẍ + 0.2 ẋ + x = γ cos ω t.
    let (gamma, omega) = (0.3, 0.8);
    let system = Driven::new(0.1, gamma, omega);
    let scene = Scene { whole: &system, start, end, output: |system, s| system.angle_at(s) };
    let linear = scene.model::<Oscillator, 1, 0, _, _>(Dop853, PiController::tolerance(1e-11))?;
    let steady = gamma / Complex::new(1.0 - omega * omega, 0.2 * omega);
    let root = Complex::new(-0.1, 0.99f64.sqrt());
    let [x, v] = [steady.re, (Complex::new(0.0, omega) * steady).re];
    let forced = |t: f64| {
        let b = (-v - 0.1 * x) / root.im;
        let free = (root.re * t).exp() * (-x * (root.im * t).cos() + b * (root.im * t).sin());
        [(steady * Complex::new(0.0, omega * t).exp()).re + free, 0.0]
    };
    checks.at_most(
        "small oscillations against their closed form (rad)",
        from_closed_form(&linear, end, forced),
        1e-8,
    );
    Ok(map)
}

fn arm(count: u32, checks: &mut Checks) -> Drawn {
    let axes =
        [Axis::log("stiffness of the drives", "N m/rad"), Axis::log("swing of shoulder and elbow", "rad")];
    let models = ["two axes", "three axes, across the links", "seven axes"];
    let map = Breakdown::new("Arm with seven axes", axes, models, 0.01).subtitle("hand to 1 cm, 1 s");
    let errors = |stiffness: f64, amplitude: f64| {
        let system = Arm::new(stiffness, amplitude);
        let start = State::new(0.0, [0.0; 7], [0.0; 7]);
        let scene = Scene { whole: &system, start, end: 1.0, output: |system, s| system.tip_at(s) };
        let whole = scene.reference()?;
        Ok([scene.error::<Moving, 2, 5>(&whole), scene.error::<Bending, 3, 4>(&whole)])
    };
    let map = filled(map, [Range(3e3, 3e5), Range(0.02, 1.0)], count, errors)?;
    let stiffest = map.places.iter().map(|((x, _), _)| *x).fold(0.0, f64::max);
    checks.holds("arm: stiff drives move two axes alone", map.limit(0, stiffest).is_some());
    Ok(map)
}

/// The map of a hanging chain: the number of modes that is enough, at so many places along each axis.
pub fn chain(count: u32, checks: &mut Checks) -> Drawn {
    const LINKS: usize = 32;
    let axes = [Axis::log("part of the chain that is bent", ""), Axis::log("angle of the bend", "rad")];
    let models = ["2 modes", "4 modes", "6 modes", "32 links"];
    let map = Breakdown::new("Modes of a hanging chain", axes, models, 0.1)
        .subtitle("free end to 10 % of its displacement, 5 s");
    let (system, hanging) = (HangingChain::default(), [0.0; LINKS]);
    let two = ModalModel::<_, LINKS, 2>::about(&system, &hanging)?;
    let four = ModalModel::<_, LINKS, 4>::about(&system, &hanging)?;
    let six = ModalModel::<_, LINKS, 6>::about(&system, &hanging)?;
    let errors = |part: f64, angle: f64| {
        let straight = LINKS as f64 * (1.0 - part);
        let bent = std::array::from_fn(|i| angle * (i as f64 + 1.0 - straight).clamp(0.0, 1.0));
        let start = State::new(0.0, bent, [0.0; LINKS]);
        let scene = Scene { whole: &system, start, end: 5.0, output: |system, s| system.tip_at(s) };
        let (whole, displaced) = (scene.reference()?, part * angle);
        Ok([
            scene.error_of_modes(&two, &whole)? / displaced,
            scene.error_of_modes(&four, &whole)? / displaced,
            scene.error_of_modes(&six, &whole)? / displaced,
        ])
    };
    let map = filled(map, [Range(1.0 / LINKS as f64, 1.0), Range(0.01, 1.5)], count, errors)?;

    // s = ω² l / g are the roots of Laguerre's polynomial of degree 32.
    let off = six.frequencies().map(|omega| {
        let s = omega * omega * system.l / system.g;
        let (mut before, mut value) = (1.0, 1.0 - s);
        for k in 1..LINKS {
            let k = k as f64;
            (before, value) = (value, ((2.0 * k + 1.0 - s) * value - k * before) / (k + 1.0));
        }
        // s L′ₙ = n (Lₙ − Lₙ₋₁)
        (value / (LINKS as f64 * (value - before))).abs()
    });
    checks.at_most("chain: squares of six frequencies, relative", off.into_iter().fold(0.0, f64::max), 1e-11);
    let sharpest = 1.0 / LINKS as f64;
    checks.holds(
        "chain: sharp bends need more modes",
        map.limit(0, 1.0) > map.limit(0, sharpest) && map.limit(2, sharpest) > map.limit(1, sharpest),
    );
    Ok(map)
}
