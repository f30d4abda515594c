//! Rigid body about a fixed horizontal axis, driven by a torque μ(t). Example 11.10; the history of the torque is a
//! choice.
//!
//! Erratum of the source: Euler's law in part (iii) has the angular velocity in place of the angular acceleration;
//! I ψ̈ = μ − W l sin ψ is what all three derivations give.

use crate::golden;
use crate::harness::{
    State, assert_balance, assert_facts, assert_number, check, check_trajectory, random_states,
};
use lagrange_runtime::prelude::*;

/// The driving torque.
fn torque<S: Scalar>(t: S, mu0: S, om: S) -> S {
    mu0 * (om * t).cos()
}

lagrangian! {
    /// Centre of mass at the distance l from the axis; I is the moment of inertia about the axis.
    pub system DrivenRigidPendulum {
        param m, l, I, mu0, om, g = 9.81;
        coord psi;
        extern fn torque(t, mu0, om);
        T = 0.5 * I * dot(psi).powi(2);
        V = m * g * l * (1 - cos(psi));
        Q[psi] = torque(t, mu0, om);
    }
}

golden!(DrivenRigidPendulum<1>, "ex-11.10-driven-rigid-pendulum", |p| DrivenRigidPendulum {
    m: p("m"),
    l: p("l"),
    I: p("I"),
    mu0: p("mu0"),
    om: p("Om"),
    g: p("g")
});

#[test]
fn reference() {
    check::<DrivenRigidPendulum, 1>();
}

#[test]
fn trajectory() {
    check_trajectory::<DrivenRigidPendulum, 1>();
}

/// (11.74d): I ψ̈ + m g l sin ψ = μ(t); the torque does the work μ ψ̇.
#[test]
fn equation_of_motion() {
    let (m, l, inertia, mu0, om) = (2.0, 0.4, 0.45, 1.5, 2.2);
    let body = DrivenRigidPendulum::new(m, l, inertia, mu0, om);
    for State { q, qd, t } in random_states([-3.1..3.1]) {
        let acceleration = body.accel(&q, &qd, t)[0];
        let weight = m * body.g * l * q[0].sin();
        assert_balance("(11.74d)", &[inertia * acceleration, weight, -mu0 * (om * t).cos()]);
        assert_number("power", body.power(&q, &qd, t), mu0 * (om * t).cos() * qd[0]);
    }
}

/// The force of time leaves ψ̈ = a(ψ, t).
#[test]
fn facts_of_the_body() {
    let holding = ["scleronomic", "separable", "constant inertia", "quadratic"];
    assert_facts::<DrivenRigidPendulum, 1>(&holding, &[], &[&[0]]);
}
