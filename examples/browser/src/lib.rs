//! Three scenes that run in a page: a double pendulum, a top, and a Monte Carlo of shots with drag.
//!
//! The page calls functions over `f64` and draws. It says how far time goes on, since a page has no clock of the
//! standard library. The state of the scenes belongs to the thread; a page has one.

use lagrange_runtime::Stepper;
use lagrange_runtime::ensemble::rand_distr::{Distribution, StandardNormal};
use lagrange_runtime::ensemble::{Collect, Ensemble, Random};
use lagrange_runtime::prelude::*;
use std::cell::RefCell;

lagrangian! {
    /// Two masses on light rods, the second hanging from the first. Angles from the downward vertical, in radians;
    /// lengths in metres.
    pub system DoublePendulum {
        param m1 = 1.0, m2 = 1.0, l1 = 1.0, l2 = 1.0, g = 9.81;
        coord a: angle, b: angle;
        let x1 = l1 * sin(a);
        let y1 = -l1 * cos(a);
        let x2 = x1 + l2 * sin(b);
        let y2 = y1 - l2 * cos(b);
        T = 0.5 * m1 * (dot(x1).powi(2) + dot(y1).powi(2)) + 0.5 * m2 * (dot(x2).powi(2) + dot(y2).powi(2));
        V = m1 * g * y1 + m2 * g * y2;
        observe bobs = [x1, y1, x2, y2];
    }
}

lagrangian! {
    /// A heavy symmetric top on its tip: precession φ, inclination θ from the upward vertical, rotation ψ. Kilograms,
    /// metres, radians.
    pub system Top {
        param m = 0.5, l = 0.12, across = 0.008, along = 0.0011, g = 9.81;
        coord phi: angle, theta: angle, psi: angle;
        T = 0.5 * across * (dot(theta).powi(2) + (dot(phi) * sin(theta)).powi(2))
            + 0.5 * along * (dot(psi) + dot(phi) * cos(theta)).powi(2);
        V = m * g * l * cos(theta);
        observe axis = [sin(theta) * cos(phi), sin(theta) * sin(phi), cos(theta)];
    }
}

lagrangian! {
    /// A shot with quadratic drag: mass in kg, drag in kg/m.
    pub system Shot {
        param m, drag, g = 9.81;
        coord x: length, y: length;
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
        V = m * g * y;
        let v = hypot(dot(x), dot(y));
        force [-drag * v * dot(x), -drag * v * dot(y)] at [x, y];
    }
}

type Pendulum = Stepper<DoublePendulum, Dop853, PiController, 2>;
type Spinning = Stepper<Top, Dop853, PiController, 3>;

thread_local! {
    static PENDULUM: RefCell<Option<(Pendulum, f64)>> = const { RefCell::new(None) };
    static TOP: RefCell<Option<(Spinning, f64)>> = const { RefCell::new(None) };
    static SHOTS: RefCell<Vec<f64>> = const { RefCell::new(Vec::new()) };
}

/// Lets the double pendulum go at rest, with its rods at these angles in radians.
#[unsafe(no_mangle)]
pub extern "C" fn pendulum_start(a: f64, b: f64) {
    let start = State::new(0.0, [a, b], [0.0; 2]);
    let system = DoublePendulum::default();
    let energy = system.energy_at(&start);
    let stepper = Stepper::new(system, Dop853, PiController::tolerance(1e-10), start);
    PENDULUM.with_borrow_mut(|pendulum| *pendulum = Some((stepper, energy)));
}

/// Moves the double pendulum on to the time t in seconds. NaN if it has not been let go or the run fails, and
/// otherwise its time.
#[unsafe(no_mangle)]
pub extern "C" fn pendulum_advance(t: f64) -> f64 {
    PENDULUM.with_borrow_mut(|pendulum| {
        let moved = pendulum.as_mut().map(|(stepper, _)| stepper.advance_to(t).map(|_| stepper.state().t));
        moved.and_then(Result::ok).unwrap_or(f64::NAN)
    })
}

/// Coordinates x₁, y₁, x₂, y₂ of the bobs in metres, by 0 to 3; 4 is the change of the energy in joules.
#[unsafe(no_mangle)]
pub extern "C" fn pendulum(which: u32) -> f64 {
    PENDULUM.with_borrow(|pendulum| {
        let Some((stepper, energy)) = pendulum else { return f64::NAN };
        let (system, at) = (stepper.system(), stepper.state());
        match which {
            0..4 => system.bobs_at(at)[which as usize],
            4 => system.energy_at(at) - energy,
            _ => f64::NAN,
        }
    })
}

/// Lets the top go with its axis inclined by θ, in radians, a precession φ̇ and a spin ψ̇ + φ̇ cos θ, in rad/s.
#[unsafe(no_mangle)]
pub extern "C" fn top_start(theta: f64, precession: f64, spin: f64) {
    let start = State::new(0.0, [0.0, theta, 0.0], [precession, 0.0, spin - precession * theta.cos()]);
    let system = Top::default();
    let energy = system.energy_at(&start);
    let stepper = Stepper::new(system, Dop853, PiController::tolerance(1e-10), start);
    TOP.with_borrow_mut(|top| *top = Some((stepper, energy)));
}

/// Moves the top on to the time t in seconds. NaN if it has not been let go or the run fails, and otherwise its time.
#[unsafe(no_mangle)]
pub extern "C" fn top_advance(t: f64) -> f64 {
    TOP.with_borrow_mut(|top| {
        let moved = top.as_mut().map(|(stepper, _)| stepper.advance_to(t).map(|_| stepper.state().t));
        moved.and_then(Result::ok).unwrap_or(f64::NAN)
    })
}

/// Components x, y, z of the unit vector along the axis, by 0 to 2; 3 is ψ in radians, 4 the change of the energy in
/// joules.
#[unsafe(no_mangle)]
pub extern "C" fn top(which: u32) -> f64 {
    TOP.with_borrow(|top| {
        let Some((stepper, energy)) = top else { return f64::NAN };
        let (system, at) = (stepper.system(), stepper.state());
        match which {
            0..3 => system.axis_at(at)[which as usize],
            3 => at.q[2],
            4 => system.energy_at(at) - energy,
            _ => f64::NAN,
        }
    })
}

/// Fires so many shots at 50 m/s and 53°, whose speed and drag have these standard deviations, relative, and keeps
/// their ranges. Gives how many came down. The same seed gives the same ranges.
#[unsafe(no_mangle)]
pub extern "C" fn shots_fire(seed: u32, count: u32, speed: f64, drag: f64) -> u32 {
    let study = Ensemble::new(Random::seed(u64::from(seed)), u64::from(count), |mut rng| {
        let mut draw = |mean: f64, deviation: f64| {
            let error: f64 = StandardNormal.sample(&mut rng);
            mean * (1.0 + deviation * error)
        };
        let (v, c) = (draw(50.0, speed), draw(1e-3, drag));
        (Shot::new(0.5, c), State::new(0.0, [0.0; 2], [0.6 * v, 0.8 * v]))
    })
    .integrate(Dop853, PiController::tolerance(1e-8), 60.0)
    .threads(1);
    let ground = || Event::falling(|at: &State<f64, 2>| at.q[1]).terminal();
    let landed = study.reduce(
        |_, run| Ok(run.events(ground()).next().transpose()?.map_or(f64::NAN, |landing| landing.state.q[0])),
        Collect,
    );
    let ranges = landed.map_or_else(|_| Vec::new(), |landed| landed.statistic.rows);
    SHOTS.with_borrow_mut(|shots| {
        *shots = ranges.into_iter().map(|(_, range)| range).filter(|range| range.is_finite()).collect();
        shots.len() as u32
    })
}

/// Range of a shot in metres; NaN beyond the last.
#[unsafe(no_mangle)]
pub extern "C" fn shot(index: u32) -> f64 {
    SHOTS.with_borrow(|shots| shots.get(index as usize).copied().unwrap_or(f64::NAN))
}
