//! Damped free vibration in the plane, coupled by the dissipation alone. Example 11.14.
//!
//! Remark on the source: D is positive definite, and every motion damped, only where c₁ c₂ > c₁₂².

use crate::golden;
use crate::harness::{
    State, assert_balance, assert_facts, assert_number, check, check_trajectory, random_states,
};
use lagrange_runtime::prelude::*;

lagrangian! {
    /// Two masses on springs of their own, and dampers that couple them.
    pub system DampedTwoDof {
        param m1, m2, k1, k2, c1, c12, c2;
        coord x, y;
        T = 0.5 * m1 * dot(x).powi(2) + 0.5 * m2 * dot(y).powi(2);
        V = 0.5 * k1 * x.powi(2) + 0.5 * k2 * y.powi(2);
        D = 0.5 * (c1 * dot(x).powi(2) + 2 * c12 * dot(x) * dot(y) + c2 * dot(y).powi(2));
    }
}

golden!(DampedTwoDof<2>, "ex-11.14-damped-two-dof", |p| DampedTwoDof {
    m1: p("m1"),
    m2: p("m2"),
    k1: p("k1"),
    k2: p("k2"),
    c1: p("c1"),
    c12: p("c12"),
    c2: p("c2")
});

#[test]
fn reference() {
    check::<DampedTwoDof, 2>();
}

#[test]
fn trajectory() {
    check_trajectory::<DampedTwoDof, 2>();
}

/// (11.100): m₁ ẍ + c₁ ẋ + c₁₂ ẏ + k₁ x = 0, m₂ ÿ + c₁₂ ẋ + c₂ ẏ + k₂ y = 0; the energy falls at the rate 2 D > 0.
#[test]
fn equations_of_motion() {
    let (m1, m2, k1, k2, c1, c12, c2) = (0.8, 1.3, 4.0, 6.5, 0.5, 0.2, 0.4);
    let system = DampedTwoDof::new(m1, m2, k1, k2, c1, c12, c2);
    for State { q, qd, t } in random_states([-2.0..2.0, -2.0..2.0]) {
        let a = system.accel(&q, &qd, t);
        assert_balance("(11.100), x", &[m1 * a[0], c1 * qd[0], c12 * qd[1], k1 * q[0]]);
        assert_balance("(11.100), y", &[m2 * a[1], c12 * qd[0], c2 * qd[1], k2 * q[1]]);
        let dissipation = system.dissipation(&q, &qd, t);
        assert_number("dE/dt", system.power(&q, &qd, t), -2.0 * dissipation);
        assert!(dissipation > 0.0);
    }
}

/// With c₁ c₂ < c₁₂² there are velocities at which the dampers would drive.
#[test]
fn dissipation_that_is_not_positive_definite() {
    let system = DampedTwoDof { c12: 0.6, ..DampedTwoDof::new(0.8, 1.3, 4.0, 6.5, 0.5, 0.2, 0.4) };
    let drives = |State { q, qd, t }: &State<2>| system.dissipation(q, qd, *t) < 0.0;
    assert!(random_states([-2.0..2.0, -2.0..2.0]).iter().any(drives));
}

#[test]
fn facts_of_the_system() {
    let holding = ["scleronomic", "constant inertia", "quadratic", "linear"];
    assert_facts::<DampedTwoDof, 2>(&holding, &[], &[&[0, 1]]);
}
