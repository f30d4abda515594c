//! Pendulum whose length is a given function of time. Problem 11.4, which can be read in two ways: with the force on
//! the string given it has two degrees of freedom, with the length given, as here, one. The history is a choice.

use crate::golden;
use crate::harness::{
    State, assert_balance, assert_facts, check, check_equal, check_trajectory, random_states,
};
use lagrange_runtime::prelude::*;

lagrangian! {
    /// By the length as a prescribed coordinate.
    pub system PrescribedLength {
        param m, l0, l1, om, g = 9.81;
        coord theta;
        coord l = l0 + l1 * sin(om * t);
        T = 0.5 * m * (dot(l).powi(2) + (l * dot(theta)).powi(2));
        V = -m * g * l * cos(theta);
    }
}

golden!(PrescribedLength<1>, "prob-11.4-prescribed-length", |p| PrescribedLength {
    m: p("m"),
    l0: p("l0"),
    l1: p("l1"),
    om: p("Om"),
    g: p("g")
});

lagrangian! {
    /// By the position of the bob, the length being a function of the system.
    pub system BobOnAVaryingString {
        param m, l0, l1, om, g = 9.81;
        coord theta;
        fn length(s) = l0 + l1 * (om * s).sin();
        let x = length(t) * theta.sin();
        let y = -length(t) * theta.cos();
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
        V = m * g * y;
        observe bob = [x, y];
    }
}

golden!(BobOnAVaryingString<1>, "prob-11.4-prescribed-length", |p| BobOnAVaryingString {
    m: p("m"),
    l0: p("l0"),
    l1: p("l1"),
    om: p("Om"),
    g: p("g")
});

#[test]
fn reference() {
    check::<PrescribedLength, 1>();
    check::<BobOnAVaryingString, 1>();
}

#[test]
fn trajectory() {
    check_trajectory::<PrescribedLength, 1>();
    check_trajectory::<BobOnAVaryingString, 1>();
}

#[test]
fn writings_agree() {
    check_equal::<PrescribedLength, BobOnAVaryingString, 1>([-3.1..3.1]);
}

/// l θ̈ + 2 l̇ θ̇ + g sin θ = 0, derived by hand.
#[test]
fn equation_of_motion() {
    let (m, l0, l1, om) = (0.5, 1.0, 0.2, 2.0);
    let pendulum = PrescribedLength::new(m, l0, l1, om);
    for State { q, qd, t } in random_states([-3.1..3.1]) {
        let acceleration = pendulum.accel(&q, &qd, t)[0];
        let (sin, cos) = (om * t).sin_cos();
        let (length, rate) = (l0 + l1 * sin, l1 * om * cos);
        assert_balance("θ", &[length * acceleration, 2.0 * rate * qd[0], pendulum.g * q[0].sin()]);
    }
}

/// M = m l(t)² does not depend on the state, but it is not constant.
#[test]
fn facts_of_the_pendulum() {
    assert_facts::<PrescribedLength, 1>(&["quadratic"], &[], &[&[0]]);
    assert_facts::<BobOnAVaryingString, 1>(&["quadratic"], &[], &[&[0]]);
}
