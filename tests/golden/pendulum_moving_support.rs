//! Pendulum whose support is driven horizontally, the drive being the user's own function of time. Problem 11.10; a
//! stand-in, since the problem refers to an example of another chapter.

use crate::golden;
use crate::harness::{State, assert_balance, check, check_trajectory, facts, random_states};
use lagrange_runtime::prelude::*;

/// Position of the support.
fn drive<S: Scalar>(t: S, a: S, om: S) -> S {
    a * (om * t).sin()
}

lagrangian! {
    /// θ from the downward vertical.
    pub system PendulumOnDrive {
        param m, l, a, om, g = 9.81;
        coord theta;
        extern fn drive(t, a, om);
        coord support = drive(t, a, om);
        let x = support + l * theta.sin();
        let y = -l * theta.cos();
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
        V = m * g * y;
        observe bob = [x, y];
    }
}

golden!(PendulumOnDrive<1>, "prob-11.10-pendulum-moving-support", |p| PendulumOnDrive {
    m: p("m"),
    l: p("l"),
    a: p("A"),
    om: p("Om"),
    g: p("g")
});

#[test]
fn reference() {
    check::<PendulumOnDrive, 1>();
}

#[test]
fn trajectory() {
    check_trajectory::<PendulumOnDrive, 1>();
}

/// l θ̈ + g sin θ + ẍₛ cos θ = 0, derived by hand.
#[test]
fn equation_of_motion() {
    let (m, l, a, om) = (0.6, 0.9, 0.15, 2.3);
    let pendulum = PendulumOnDrive::new(m, l, a, om);
    for State { q, qd, t } in random_states([-3.1..3.1]) {
        let acceleration = pendulum.accel(&q, &qd, t)[0];
        let (sin, cos) = q[0].sin_cos();
        let drive = -a * om * om * (om * t).sin();
        assert_balance("θ", &[l * acceleration, pendulum.g * sin, drive * cos]);
    }
}

/// Whether `separable` holds is left open: θ̈ = a(θ, t), but p = m l² θ̇ + m l ẋₛ cos θ depends on θ.
#[test]
fn facts_of_the_driven_pendulum() {
    let facts = facts::<PendulumOnDrive, 1>();
    assert!(!facts.scleronomic && !facts.conservative && !facts.linear);
    assert!(facts.constant_inertia && facts.quadratic);
    assert_eq!((facts.ignorable.len(), facts.blocks), (0, &[&[0][..]][..]));
    assert_eq!(facts.coordinates, ["theta"]);
}
