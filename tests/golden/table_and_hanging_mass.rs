//! Mass on a smooth table, tied by a string through a hole to a hanging mass. Problem 11.13; a stand-in, since the
//! problem refers to another chapter.

use crate::golden;
use crate::harness::with_reference;
use crate::harness::{
    Reference, State, assert_balance, assert_facts, assert_number, check, check_trajectory, number,
    random_states,
};
use lagrange_runtime::prelude::*;
use nalgebra::SVector;

lagrangian! {
    /// r, θ: polar coordinates on the table; the hanging mass rises with r.
    pub system TableAndHangingMass {
        param m1, m2, g = 9.81;
        coord r, theta;
        T = 0.5 * m1 * (dot(r).powi(2) + (r * dot(theta)).powi(2)) + 0.5 * m2 * dot(r).powi(2);
        V = m2 * g * r;
    }
}

golden!(TableAndHangingMass<2>, "prob-11.13-table-and-hanging-mass", |p| TableAndHangingMass {
    m1: p("m1"),
    m2: p("m2"),
    g: p("g")
});

#[test]
fn reference() {
    check::<TableAndHangingMass, 2>();
}

#[test]
fn trajectory() {
    check_trajectory::<TableAndHangingMass, 2>();
}

/// (m₁ + m₂) r̈ − m₁ r θ̇² + m₂ g = 0 and d(m₁ r² θ̇)/dt = 0, derived by hand.
#[test]
fn equations_of_motion() {
    let (m1, m2) = (0.5, 0.8);
    let system = TableAndHangingMass::new(m1, m2);
    for State { q, qd, t } in random_states([0.3..2.0, -3.0..3.0]) {
        let a = system.accel(&q, &qd, t);
        let r = q[0];
        assert_balance("r", &[(m1 + m2) * a[0], -m1 * r * qd[1] * qd[1], m2 * system.g]);
        assert_balance("θ", &[r * a[1], 2.0 * qd[0] * qd[1]]);
        assert_number("p_θ", system.momenta(&q, &qd, t)[1], m1 * r * r * qd[1]);
        assert_eq!(system.force(&q, &qd, t)[1], 0.0, "p_θ is conserved");
    }
}

/// The circle m₁ r θ̇² = m₂ g, and the radial frequency of its disturbances at constant p_θ.
#[test]
fn circular_motion() {
    let reference = Reference::read("prob-11.13-table-and-hanging-mass");
    let system = with_reference::<TableAndHangingMass, 2>();
    let circle = reference.special("circular");
    let (r, rate) = (number(&circle["r"]), number(&circle["thetadot"]));
    let (q, qd) = (SVector::from([r, 0.0]), SVector::from([0.0, rate]));
    let weight = system.m2 * system.g / (system.m1 + system.m2);
    assert_balance("r̈", &[system.accel(&q, &qd, 0.0)[0] + weight, -weight]);

    // At constant p_θ the rate θ̇ changes by −2 θ̇/r per unit of r.
    let jacobian = system.jacobian(&q, &qd, 0.0);
    let frequency = number(&circle["radial_frequency"]);
    let slope = -2.0 * rate / r;
    assert_balance("radial", &[jacobian.q[(0, 0)], jacobian.qd[(0, 1)] * slope, frequency * frequency]);
}

#[test]
fn facts_of_the_system() {
    let holding = ["scleronomic", "conservative", "quadratic"];
    assert_facts::<TableAndHangingMass, 2>(&holding, &[1], &[&[0, 1]]);
}
