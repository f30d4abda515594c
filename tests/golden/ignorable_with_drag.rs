//! A Lagrangian of two coordinates with terms of degree 2, 1 and 0 in the velocities, one coordinate ignorable, drag
//! on the other. Example 11.7; its L is given whole, the split into T and V is a choice that the equations do not see.
//!
//! Errata of the source: since T is not homogeneous of degree 2, Euler's identity (11.26) fails and T + V is not the
//! integral of the energy; (11.52) does not apply, ḣ = −m b² ν q̇₁² does. Putting the conserved p₂ into L before
//! differentiating gives a wrong equation for q₁; the Routhian gives (11.48d).

use crate::golden;
use crate::harness::{
    Reference, State, assert_balance, assert_facts, assert_number, check, check_equal, check_trajectory,
    number,
};
use crate::harness::{random_states, with_reference};
use lagrange_runtime::prelude::*;
use nalgebra::SVector;

lagrangian! {
    /// By L, with the drag as a generalized force.
    pub system IgnorableWithDrag {
        param m, a, b, c, nu;
        coord q1, q2;
        L = m * (b * dot(q2) + a * q1.cos()).powi(2)
            + 0.5 * m * b.powi(2) * (dot(q1) + c).powi(2)
            + 0.5 * m * (a * q1.sin()).powi(2);
        Q[q1] = -m * b.powi(2) * nu * dot(q1);
    }
}

golden!(
    IgnorableWithDrag<2>,
    "ex-11.7-ignorable-nonconservative",
    |p| IgnorableWithDrag { m: p("m"), a: p("a"), b: p("b"), c: p("c"), nu: p("nu") },
    given L
);

lagrangian! {
    /// By T and V.
    pub system IgnorableSplit {
        param m, a, b, c, nu;
        coord q1, q2;
        T = m * b * b * (dot(q2) + a / b * cos(q1)).powi(2) + 0.5 * m * b * b * (dot(q1) + c).powi(2);
        V = -0.5 * m * a * a * sin(q1) * sin(q1);
        Q[q1] = -m * b * b * nu * dot(q1);
    }
}

golden!(IgnorableSplit<2>, "ex-11.7-ignorable-nonconservative", |p| IgnorableSplit {
    m: p("m"),
    a: p("a"),
    b: p("b"),
    c: p("c"),
    nu: p("nu")
});

#[test]
fn reference() {
    check::<IgnorableWithDrag, 2>();
    check::<IgnorableSplit, 2>();
}

#[test]
fn trajectory() {
    check_trajectory::<IgnorableWithDrag, 2>();
    check_trajectory::<IgnorableSplit, 2>();
}

#[test]
fn writings_agree() {
    check_equal::<IgnorableWithDrag, IgnorableSplit, 2>([-3.0..3.0, -3.0..3.0]);
}

/// (11.48c) for q₁, and p₂ of (11.48b) is conserved.
#[test]
fn equations_of_motion() {
    let (m, a, b, c, nu) = (0.9, 0.8, 0.6, 0.35, 0.25);
    let system = IgnorableWithDrag::new(m, a, b, c, nu);
    for State { q, qd, t } in random_states([-3.0..3.0, -3.0..3.0]) {
        let acceleration = system.accel(&q, &qd, t);
        let (sin, cos) = q[0].sin_cos();
        let rate = 2.0 * m * a * b * sin;
        assert_balance(
            "(11.48c)",
            &[
                m * b * b * acceleration[0],
                rate * qd[1],
                rate * a / b * cos,
                -m * a * a * sin * cos,
                m * b * b * nu * qd[0],
            ],
        );
        let momentum = system.momenta(&q, &qd, t)[1];
        assert_balance("(11.48b)", &[momentum, -2.0 * m * b * b * qd[1], -2.0 * m * b * a * cos]);
        assert_eq!(system.force(&q, &qd, t)[1], 0.0, "p₂ is conserved");
        assert_number("ḣ", system.power(&q, &qd, t), -m * b * b * nu * qd[0] * qd[0]);
    }
}

/// c stands in L as c q̇₁, the derivative of c q₁: no motion depends on it.
#[test]
fn total_derivative_drops_out() {
    let system = IgnorableWithDrag::new(0.9, 0.8, 0.6, 0.35, 0.25);
    let other = IgnorableWithDrag { c: -7.0, ..system };
    for State { q, qd, t } in random_states([-3.0..3.0, -3.0..3.0]) {
        let (mine, others) = (system.accel(&q, &qd, t), other.accel(&q, &qd, t));
        assert_number("q̈₁", mine[0], others[0]);
        assert_number("q̈₂", mine[1], others[1]);
    }
}

/// The reduced equation (11.48d), with γ₂ from (11.48b).
#[test]
fn reduced_equation() {
    let reference = Reference::read("ex-11.7-ignorable-nonconservative");
    let system = with_reference::<IgnorableWithDrag, 2>();
    for case in reference.special("reduced_equation").as_array().expect("a list") {
        let q = SVector::from([number(&case["q1"]), 0.0]);
        let qd = SVector::from([number(&case["q1dot"]), number(&case["q2dot"])]);
        assert_number("(11.48d)", system.accel(&q, &qd, 0.0)[0], number(&case["q1ddot_11_48d"]));
        assert_number("ḣ", system.power(&q, &qd, 0.0), number(&case["dh_dt"]));
    }
}

#[test]
fn facts_of_the_system() {
    let holding = ["scleronomic", "constant inertia", "quadratic"];
    assert_facts::<IgnorableWithDrag, 2>(&holding, &[1], &[&[0, 1]]);
    assert_facts::<IgnorableSplit, 2>(&holding, &[1], &[&[0, 1]]);
}
