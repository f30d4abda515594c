//! Rigid body about a fixed horizontal axis, driven by a torque μ(t). Example 11.10; the history of the torque is a
//! choice.
//!
//! Erratum of the source: Euler's law in part (iii) has the angular velocity in place of the angular acceleration;
//! I ψ̈ = μ − W l sin ψ is what all three derivations give.

use super::harness::Row;
use lagrange_runtime::Scalar;
use lagrange_runtime::prelude::lagrangian;

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
}, with an extern fn);

/// The force of time leaves ψ̈ = a(ψ, t).
pub fn rows() -> Vec<Row> {
    let facts = "scleronomic, separable, constant inertia, quadratic";
    vec![Row::of::<DrivenRigidPendulum, 1>(facts, [-3.1..3.1])]
}
