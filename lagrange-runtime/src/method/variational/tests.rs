//! Claims: order, symplecticity, symmetry, momenta, what the methods reduce to, forces, long steps, failures.

use super::*;
use crate::controller::FixedStep;
use crate::integrate::integrate;
use crate::prelude::*;
use crate::testing::bank::{DOUBLE, ELLIPSE, Plane, coordinate, ellipse, polar};
use crate::testing::emitted::*;
use crate::testing::{distance, energy_drift, order_of, slope, symplecticity_defect};

#[test]
fn both_are_of_order_two() {
    let (system, start, exact) = (Kepler::new(1.0), polar(0.0), polar(4.0));
    let midpoint = order_of(&system, &VariationalMidpoint, &start, &exact, &[400, 800, 1600]).unwrap();
    let trapezoid = order_of(&system, &VariationalTrapezoid, &start, &exact, &[400, 800, 1600]).unwrap();
    assert!((midpoint - 2.0).abs() < 0.1 && (trapezoid - 2.0).abs() < 0.1, "{midpoint} {trapezoid}");
}

/// The discrete Lagrange–d'Alembert principle, with damping and a force of time.
#[test]
fn the_order_holds_with_forces() {
    let system = Forced::new(0.2, 0.7);
    let (start, exact) = (forced(0.2, 0.7, 0.0), forced(0.2, 0.7, 6.0));
    let midpoint = order_of(&system, &VariationalMidpoint, &start, &exact, &[100, 200, 400]).unwrap();
    let trapezoid = order_of(&system, &VariationalTrapezoid, &start, &exact, &[100, 200, 400]).unwrap();
    assert!((midpoint - 2.0).abs() < 0.1 && (trapezoid - 2.0).abs() < 0.1, "{midpoint} {trapezoid}");
}

#[test]
fn both_are_symplectic_where_the_inertia_depends_on_q() {
    let system = TwoPendulums { g: Dual::constant(1.0) };
    for h in [0.01, 0.1, 0.3] {
        let midpoint = symplecticity_defect(&system, &VariationalMidpoint, &DOUBLE, h).unwrap();
        let trapezoid = symplecticity_defect(&system, &VariationalTrapezoid, &DOUBLE, h).unwrap();
        assert!(midpoint < 1e-13 && trapezoid < 1e-13, "{midpoint} {trapezoid}");
    }
}

fn returns(method: impl Method<TwoPendulums, 2> + Copy) {
    let system = TwoPendulums::new(1.0);
    let there = integrate(&system, method, FixedStep::new(0.05), DOUBLE).until(5.0).final_state().unwrap();
    let back = integrate(&system, method, FixedStep::new(-0.05), there).until(0.0).final_state().unwrap();
    assert!(distance(&DOUBLE, &back) < 1e-12, "{back:?}");
}

#[test]
fn both_are_time_symmetric() {
    returns(VariationalMidpoint);
    returns(VariationalTrapezoid);
}

/// Nothing is ever added to the momentum of a coordinate on which L does not depend; what is left is the rounding of
/// momenta → velocities → momenta.
fn keeps<Sys: Lagrangian<N, Scalar = f64>, const N: usize>(
    system: &Sys,
    method: impl Method<Sys, N, Error = NoEstimate>,
    start: State<f64, N>,
    h: f64,
    bound: f64,
) {
    let momenta = |at: &State<f64, N>| system.momenta(&at.q, &at.qd, at.t);
    let before = momenta(&start);
    for step in integrate(system, method, FixedStep::new(h), start)
        .until(if crate::long() { 10_000.0 } else { 3000.0 } * h)
    {
        let after = momenta(&step.unwrap().to);
        for &i in Sys::FACTS.ignorable {
            assert!((after[i] - before[i]).abs() <= bound * before[i].abs(), "{i}: {before} {after}");
        }
    }
}

#[test]
fn momenta_of_ignorable_coordinates_are_kept_to_rounding() {
    let (kepler, top) = (Kepler::new(1.0), Top::new(1.0, 0.5, 0.3));
    assert_eq!((Kepler::<f64>::FACTS.ignorable, Top::<f64>::FACTS.ignorable), (&[1][..], &[0, 2][..]));
    keeps(&kepler, VariationalMidpoint, polar(0.0), 0.05, 1e-15);
    keeps(&kepler, VariationalTrapezoid, polar(0.0), 0.05, 1e-15);
    // The inertia of a top in Euler angles has the condition 1/sin²θ, about 20 at its smallest inclination.
    keeps(&top, VariationalMidpoint, TOP, 0.01, 2e-14);
    keeps(&top, VariationalTrapezoid, TOP, 0.01, 2e-14);
}

#[test]
fn energy_does_not_drift() {
    let system = Kepler::new(1.0);
    let drift = |turns: f64| {
        let end = turns * core::f64::consts::TAU;
        let run = integrate(&system, VariationalTrapezoid, FixedStep::new(0.05), polar(0.0)).until(end);
        energy_drift(&system, run).unwrap()
    };
    let (short, long) = (drift(1.0), drift(200.0));
    assert!(short < 3e-3 && long < 1.05 * short, "{short} {long}");
}

#[test]
fn they_are_what_theory_says_they_are() {
    // The midpoint rule is the implicit midpoint rule on (q, p).
    let system = TwoPendulums::new(1.0);
    let run =
        |method| integrate(&system, method, FixedStep::new(0.05), DOUBLE).until(2.0).final_state().unwrap();
    let newton = run(VariationalMidpoint);
    let fixed_point =
        integrate(&system, ImplicitMidpoint, FixedStep::new(0.05), DOUBLE).until(2.0).final_state().unwrap();
    assert!(distance(&newton, &fixed_point) < 1e-13);
    // The trapezoidal rule is Verlet's method for a separable system.
    let system = Plain::new(1.0);
    let trapezoid = integrate(&system, VariationalTrapezoid, FixedStep::new(0.05), ELLIPSE)
        .until(2.0)
        .final_state()
        .unwrap();
    let verlet =
        integrate(&Plane::default(), Verlet, FixedStep::new(0.05), ELLIPSE).until(2.0).final_state().unwrap();
    assert!(distance(&trapezoid, &verlet) < 1e-13);
    assert!(distance(&trapezoid, &ellipse(2.0)) < 1e-2);
}

lagrangian! {
    /// Kepler's problem in Cartesian coordinates.
    system Plain {
        param mu;
        coord x, y;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = -mu / sqrt(x.powi(2) + y.powi(2));
    }
}

/// A Lagrangian that is not quadratic in the velocity, at speeds up to 0.9 c.
#[test]
fn a_relativistic_oscillator_keeps_its_energy() {
    let system = Relativistic::new(1.0, 1.0);
    let start = State::new(0.0, [0.0], [0.9]);
    let drift = |h: f64| {
        let run = integrate(&system, VariationalMidpoint, FixedStep::new(h), start).until(500.0);
        energy_drift(&system, run).unwrap()
    };
    let (coarse, fine) = (drift(0.05), drift(0.025));
    assert!(coarse < 2e-3 && (coarse / fine - 4.0).abs() < 0.2, "{coarse} {fine}");
}

/// Steps of 16 radians of the fast oscillation, where a fixed-point iteration cannot converge.
#[test]
fn the_midpoint_rule_takes_steps_longer_than_stiff_oscillations() {
    let system = Repelled::new(-1e8);
    let start = State::new(0.0, [1e-4], [0.0]);
    let run = integrate(&system, VariationalMidpoint, FixedStep::new(1.6e-3), start).until(1.6);
    let energy = system.energy_function(&start.q, &start.qd, 0.0);
    assert!(energy_drift(&system, run).unwrap() < 1e-12 * energy);
    let failed = integrate(&system, ImplicitMidpoint, FixedStep::new(1.6e-3), start).until(1.6).final_state();
    assert!(failed.is_err());
}

#[test]
fn failures_say_what_happened() {
    let start = State::new(0.0, [0.0, 0.0], [0.0, 0.0]);
    assert_eq!(
        VariationalMidpoint.start(&Kepler::new(1.0), &start),
        Err(Failure::SingularInertia { t: 0.0, coordinate: coordinate(1, "phi"), with: None })
    );
    // Beyond the speed of light the inertia is no number.
    let system = Relativistic::new(1.0, 1.0);
    let failure = VariationalMidpoint.start(&system, &State::new(0.0, [0.0], [2.0])).unwrap_err();
    assert_eq!(failure, Failure::NonFinite { t: 0.0, h: 0.0 });
    // 1 − h²k/4 = 0.
    let start = State::new(0.5, [1.0], [0.0]);
    let system = Repelled::new(16.0);
    let memory = VariationalMidpoint.start(&system, &start).unwrap();
    let failure = VariationalMidpoint.step(&system, &memory, &start, 0.5).unwrap_err();
    assert_eq!(failure, Failure::SingularStep { t: 0.5, h: 0.5, coordinate: coordinate(0, "q") });
}

/// Yoshida's triple jump of steps γh, (1 − 2γ)h, γh with γ = 1/(2 − ∛2) makes order 4 of a symmetric method of order 2.
#[test]
fn compositions_are_of_order_four() {
    let gamma = 1.0 / (2.0 - 2f64.cbrt());
    fn error(method: impl Method<Kepler, 2>, gamma: f64, n: u32) -> (f64, f64) {
        let (system, mut state) = (Kepler::new(1.0), polar(0.0));
        let mut memory = method.start(&system, &state).unwrap();
        let h = 3.0 / f64::from(n);
        for _ in 0..n {
            for part in [gamma, 1.0 - 2.0 * gamma, gamma] {
                let (step, next) = method.step(&system, &memory, &state, part * h).unwrap();
                (state, memory) = (step.to, next);
            }
        }
        (h, distance(&state, &polar(3.0)))
    }
    let steps = [200, 400, 800];
    let midpoint = slope(steps.map(|n| error(VariationalMidpoint, gamma, n)), 1e-12);
    let trapezoid = slope(steps.map(|n| error(VariationalTrapezoid, gamma, n)), 1e-12);
    assert!((midpoint - 4.0).abs() < 0.1 && (trapezoid - 4.0).abs() < 0.1, "{midpoint} {trapezoid}");
}
