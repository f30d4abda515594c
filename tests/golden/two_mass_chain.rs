//! Two masses in a row between two walls, with springs k₁, k₂, k₁. Example 11.6(i), Section 11.10.3.

use crate::golden;
use crate::harness::{
    State, assert_balance, assert_facts, check, check_equal, check_trajectory, random_states,
};
use lagrange_runtime::prelude::*;

lagrangian! {
    /// Displacements from rest, the masses by name.
    pub system TwoMassChain {
        param m1, m2, k1, k2;
        coord x1, x2;
        T = 0.5 * (m1 * dot(x1).powi(2) + m2 * dot(x2).powi(2));
        V = 0.5 * (k1 * x1.powi(2) + k2 * (x2 - x1).powi(2) + k1 * x2.powi(2));
    }
}

golden!(TwoMassChain<2>, "ex-11.6i-two-mass-chain", |p| TwoMassChain {
    m1: p("m1"),
    m2: p("m2"),
    k1: p("k1"),
    k2: p("k2")
});

lagrangian! {
    /// The same, the masses by number.
    pub system Chain {
        const N = 2;
        param m: [N], k: [N];
        coord x: [N];
        T = 0.5 * (0..N).map(|i| m[i] * dot(x[i]).powi(2)).sum();
        V = 0.5 * k[0] * (x[0].powi(2) + x[N - 1].powi(2))
            + 0.5 * (1..N).map(|i| k[i] * (x[i] - x[i - 1]).powi(2)).sum();
    }
}

golden!(Chain<2>, "ex-11.6i-two-mass-chain", |p| Chain { m: [p("m1"), p("m2")], k: [p("k1"), p("k2")] });

#[test]
fn reference() {
    check::<TwoMassChain, 2>();
    check::<Chain, 2>();
}

#[test]
fn trajectory() {
    check_trajectory::<TwoMassChain, 2>();
    check_trajectory::<Chain, 2>();
}

#[test]
fn writings_agree() {
    check_equal::<TwoMassChain, Chain, 2>([-2.0..2.0, -2.0..2.0]);
}

/// (11.40f): m₁ ẍ₁ + (k₁ + k₂) x₁ − k₂ x₂ = 0, m₂ ẍ₂ + (k₁ + k₂) x₂ − k₂ x₁ = 0.
#[test]
fn equations_of_motion() {
    let (m1, m2, k1, k2) = (1.2, 0.7, 3.0, 1.9);
    let chain = TwoMassChain::new(m1, m2, k1, k2);
    for State { q, qd, t } in random_states([-2.0..2.0, -2.0..2.0]) {
        let a = chain.accel(&q, &qd, t);
        assert_balance("(11.40f), 1", &[m1 * a[0], (k1 + k2) * q[0], -k2 * q[1]]);
        assert_balance("(11.40f), 2", &[m2 * a[1], (k1 + k2) * q[1], -k2 * q[0]]);
        let kinetic = 0.5 * (m1 * qd[0] * qd[0] + m2 * qd[1] * qd[1]);
        let walls = 0.5 * k1 * (q[0] * q[0] + q[1] * q[1]);
        let middle = 0.5 * k2 * (q[1] - q[0]).powi(2);
        assert_balance("energy", &[chain.energy(&q, &qd, t), -kinetic, -walls, -middle]);
    }
}

/// −M ∂q̈/∂q is the stiffness (11.87b), whose determinant is k₁² + 2 k₁ k₂ > 0.
#[test]
fn stiffness() {
    let (m1, m2, k1, k2) = (1.2, 0.7, 3.0, 1.9);
    let chain = TwoMassChain::new(m1, m2, k1, k2);
    for State { q, qd, t } in random_states([-2.0..2.0, -2.0..2.0]) {
        let k = -chain.inertia(&q, &qd, t) * chain.jacobian(&q, &qd, t).q;
        let [diagonal, coupling] = [k[(0, 0)] * k[(1, 1)], k[(0, 1)] * k[(1, 0)]];
        assert_balance("(11.87b)", &[diagonal, -coupling, -k1 * k1, -2.0 * k1 * k2]);
    }
}

#[test]
fn facts_of_the_chain() {
    let holding = ["scleronomic", "conservative", "separable", "constant inertia", "quadratic", "linear"];
    assert_facts::<TwoMassChain, 2>(&holding, &[], &[&[0, 1]]);
    assert_facts::<Chain, 2>(&holding, &[], &[&[0, 1]]);
}

/// The facts are traits, too: this compiles.
#[test]
fn marker_traits() {
    fn propagates(_: &(impl Linear<2> + Separable<2> + Conservative<2>)) {}
    propagates(&TwoMassChain::new(1.2, 0.7, 3.0, 1.9));
}
