//! Fall in a Stokes medium, the drag −cẏ once as a generalized force (Example 11.4) and once from a Rayleigh function
//! (Example 11.13). y points downwards.

use crate::golden;
use crate::harness::{
    State, assert_balance, assert_facts, assert_number, check, check_equal, check_trajectory, random_states,
};
use lagrange_runtime::prelude::*;
use nalgebra::SVector;

lagrangian! {
    /// Example 11.4.
    pub system StokesFall {
        param m, c, g = 9.81;
        coord y;
        T = 0.5 * m * dot(y).powi(2);
        V = -m * g * y;
        Q[y] = -c * dot(y);
    }
}

golden!(StokesFall<1>, "ex-11.4-stokes-fall-QN", |p| StokesFall { m: p("m"), c: p("c"), g: p("g") });

lagrangian! {
    /// Example 11.13.
    pub system StokesFallOfRayleigh {
        param m, c, g = 9.81;
        coord y;
        T = 0.5 * m * dot(y).powi(2);
        V = -m * g * y;
        D = 0.5 * c * dot(y).powi(2);
    }
}

golden!(StokesFallOfRayleigh<1>, "ex-11.13-stokes-fall-rayleigh", |p| StokesFallOfRayleigh {
    m: p("m"),
    c: p("c"),
    g: p("g")
});

#[test]
fn reference() {
    check::<StokesFall, 1>();
    check::<StokesFallOfRayleigh, 1>();
}

#[test]
fn trajectory() {
    check_trajectory::<StokesFall, 1>();
    check_trajectory::<StokesFallOfRayleigh, 1>();
}

#[test]
fn drag_of_both_kinds_is_the_same() {
    check_equal::<StokesFall, StokesFallOfRayleigh, 1>([-2.0..2.0]);
}

/// m ÿ − m g + c ẏ = 0. The energy falls at the rate c ẏ² = 2 D. The text on the special case after (11.95) has
/// D = −νT once, which is an erratum: D = +νT with ν = c/m.
#[test]
fn equation_of_motion() {
    let (m, c) = (0.6, 0.9);
    let falling = StokesFall::new(m, c);
    let damped = StokesFallOfRayleigh::new(m, c);
    for State { q, qd, t } in random_states([-2.0..2.0]) {
        for acceleration in [falling.accel(&q, &qd, t)[0], damped.accel(&q, &qd, t)[0]] {
            assert_balance("m ÿ − m g + c ẏ", &[m * acceleration, -m * falling.g, c * qd[0]]);
        }
        assert_number("power of Q", falling.power(&q, &qd, t), -c * qd[0] * qd[0]);
        assert_number("power of D", damped.power(&q, &qd, t), -2.0 * damped.dissipation(&q, &qd, t));
        assert_number("D = ν T", damped.dissipation(&q, &qd, t), c / m * damped.kinetic(&q, &qd, t));
    }
}

/// At the speed g m/c nothing accelerates.
#[test]
fn terminal_speed() {
    let falling = StokesFall::new(0.6, 0.9);
    let speed = falling.g * falling.m / falling.c;
    let acceleration = falling.accel(&SVector::from([0.0]), &SVector::from([speed]), 0.0)[0];
    assert_balance("terminal speed", &[acceleration, falling.g, -falling.g]);
}

/// Linear with constant coefficients: the constant term g does not change that.
#[test]
fn facts_of_the_fall() {
    let holding = ["scleronomic", "constant inertia", "quadratic", "linear"];
    assert_facts::<StokesFall, 1>(&holding, &[], &[&[0]]);
    assert_facts::<StokesFallOfRayleigh, 1>(&holding, &[], &[&[0]]);
}
