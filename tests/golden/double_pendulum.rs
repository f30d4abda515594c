//! Double pendulum with general masses and lengths, angles from the downward vertical: by its angles, and by the
//! positions of the bobs, an indexed family. Problem 11.35; reconstructed, since the problem refers to another chapter.

use crate::golden;
use crate::harness::{
    Reference, State, assert_balance, assert_facts, assert_number, check, check_equal, check_trajectory,
};
use crate::harness::{random_states, with_reference};
use lagrange_runtime::prelude::*;
use nalgebra::SVector;

lagrangian! {
    /// By its angles.
    pub system DoublePendulum {
        param m1, m2, l1, l2, g = 9.81;
        coord th1, th2;
        T = 0.5 * (m1 + m2) * (l1 * dot(th1)).powi(2)
            + 0.5 * m2 * (l2 * dot(th2)).powi(2)
            + m2 * l1 * l2 * dot(th1) * dot(th2) * (th1 - th2).cos();
        V = -(m1 + m2) * g * l1 * th1.cos() - m2 * g * l2 * th2.cos();
    }
}

golden!(DoublePendulum<2>, "prob-11.35-double-pendulum", |p| DoublePendulum {
    m1: p("m1"),
    m2: p("m2"),
    l1: p("l1"),
    l2: p("l2"),
    g: p("g")
});

lagrangian! {
    /// By the bobs: bob i hangs from bob i − 1.
    pub system PendulumOfBobs {
        const N = 2;
        param m: [N], l: [N], g = 9.81;
        coord th: [N];
        let x: [N] = |i| (0..i + 1).map(|j| l[j] * th[j].sin()).sum();
        let y: [N] = |i| -(0..i + 1).map(|j| l[j] * th[j].cos()).sum();
        T = (0..N).map(|i| 0.5 * m[i] * (dot(x[i]).powi(2) + dot(y[i]).powi(2))).sum();
        V = (0..N).map(|i| m[i] * g * y[i]).sum();
        observe tip = [x[N - 1], y[N - 1]];
    }
}

golden!(PendulumOfBobs<2>, "prob-11.35-double-pendulum", |p| PendulumOfBobs {
    m: [p("m1"), p("m2")],
    l: [p("l1"), p("l2")],
    g: p("g")
});

#[test]
fn reference() {
    check::<DoublePendulum, 2>();
    check::<PendulumOfBobs, 2>();
}

#[test]
fn trajectory() {
    check_trajectory::<DoublePendulum, 2>();
    check_trajectory::<PendulumOfBobs, 2>();
}

#[test]
fn writings_agree() {
    check_equal::<DoublePendulum, PendulumOfBobs, 2>([-3.1..3.1, -3.1..3.1]);
}

/// The two equations, derived by hand: (m₁ + m₂) l₁ θ̈₁ + m₂ l₂ (θ̈₂ cos δ + θ̇₂² sin δ) + (m₁ + m₂) g sin θ₁ = 0 and
/// l₂ θ̈₂ + l₁ (θ̈₁ cos δ − θ̇₁² sin δ) + g sin θ₂ = 0, with δ = θ₁ − θ₂.
#[test]
fn equations_of_motion() {
    let (m1, m2, l1, l2) = (0.7, 0.4, 0.8, 0.6);
    let pendulum = DoublePendulum::new(m1, m2, l1, l2);
    let g = pendulum.g;
    for State { q, qd, t } in random_states([-3.1..3.1, -3.1..3.1]) {
        let a = pendulum.accel(&q, &qd, t);
        let (sin, cos) = (q[0] - q[1]).sin_cos();
        assert_balance(
            "θ₁",
            &[
                (m1 + m2) * l1 * a[0],
                m2 * l2 * a[1] * cos,
                m2 * l2 * qd[1] * qd[1] * sin,
                (m1 + m2) * g * q[0].sin(),
            ],
        );
        assert_balance("θ₂", &[l2 * a[1], l1 * a[0] * cos, -l1 * qd[0] * qd[0] * sin, g * q[1].sin()]);
    }
}

/// Equal masses and lengths: ω² = (g/l)(2 ∓ √2) with θ₂/θ₁ = ±√2.
#[test]
fn modes_of_the_equal_pendulum() {
    let reference = Reference::read("prob-11.35-double-pendulum");
    let squares = &reference.special("equal_case")["p2_over_g_l"];
    let pendulum = DoublePendulum::new(0.5, 0.5, 0.8, 0.8);
    let origin = SVector::from([0.0, 0.0]);
    let jacobian = pendulum.jacobian(&origin, &origin, 0.0).q;
    for (index, ratio) in [2.0f64.sqrt(), -(2.0f64.sqrt())].into_iter().enumerate() {
        let square = squares[index].as_f64().expect("a number") * pendulum.g / 0.8;
        let mode = SVector::from([1.0, ratio]);
        for (got, expected) in (-jacobian * mode).iter().zip(&(mode * square)) {
            assert!((got - expected).abs() <= 1e-13 * jacobian.amax(), "{got} ≠ {expected}");
        }
    }
}

/// Only the hanging one of the four equilibria is stable: there alone is the stiffness positive definite.
#[test]
fn equilibria() {
    let pendulum = with_reference::<DoublePendulum, 2>();
    let pi = std::f64::consts::PI;
    let rest = SVector::from([0.0, 0.0]);
    for q in [[0.0, 0.0], [pi, 0.0], [0.0, pi], [pi, pi]].map(SVector::from) {
        let stiffness = -pendulum.inertia(&q, &rest, 0.0) * pendulum.jacobian(&q, &rest, 0.0).q;
        let upper = (pendulum.m1 + pendulum.m2) * pendulum.g * pendulum.l1 * q[0].cos();
        assert_number("∂²V/∂θ₁²", stiffness[(0, 0)], upper);
        assert_number("∂²V/∂θ₂²", stiffness[(1, 1)], pendulum.m2 * pendulum.g * pendulum.l2 * q[1].cos());
        let stable = stiffness[(0, 0)] > 0.0 && stiffness[(1, 1)] > 0.0;
        assert_eq!(stable, q == rest);
    }
}

#[test]
fn facts_of_the_double_pendulum() {
    let holding = ["scleronomic", "conservative", "quadratic"];
    assert_facts::<DoublePendulum, 2>(&holding, &[], &[&[0, 1]]);
    assert_facts::<PendulumOfBobs, 2>(&holding, &[], &[&[0, 1]]);
}
