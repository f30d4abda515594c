//! Spherical pendulum, θ from the downward vertical: in its angles and by the position of the bob. Problem 11.3.

use crate::golden;
use crate::harness::{
    Reference, State, assert_balance, assert_facts, assert_number, check, check_equal, check_trajectory,
    number,
};
use crate::harness::{random_states, with_reference};
use lagrange_runtime::prelude::*;
use nalgebra::SVector;

lagrangian! {
    /// In its angles.
    pub system SphericalPendulum {
        param m, l, g = 9.81;
        coord theta, phi;
        T = 0.5 * m * l.powi(2) * (dot(theta).powi(2) + (theta.sin() * dot(phi)).powi(2));
        V = -m * g * l * theta.cos();
    }
}

golden!(SphericalPendulum<2>, "prob-11.3-spherical-pendulum", |p| SphericalPendulum {
    m: p("m"),
    l: p("l"),
    g: p("g")
});

lagrangian! {
    /// By the position of the bob.
    pub system BobOnASphere {
        param m, l, g = 9.81;
        coord theta, phi;
        let rho = l * theta.sin();
        let x = rho * phi.cos();
        let y = rho * phi.sin();
        let z = -l * theta.cos();
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2));
        V = m * g * z;
        observe bob = [x, y, z];
    }
}

golden!(BobOnASphere<2>, "prob-11.3-spherical-pendulum", |p| BobOnASphere {
    m: p("m"),
    l: p("l"),
    g: p("g")
});

#[test]
fn reference() {
    check::<SphericalPendulum, 2>();
    check::<BobOnASphere, 2>();
}

#[test]
fn trajectory() {
    check_trajectory::<SphericalPendulum, 2>();
    check_trajectory::<BobOnASphere, 2>();
}

#[test]
fn writings_agree() {
    check_equal::<SphericalPendulum, BobOnASphere, 2>([0.3..2.8, -3.0..3.0]);
}

/// θ̈ − φ̇² sin θ cos θ + (g/l) sin θ = 0 and d(sin² θ φ̇)/dt = 0, derived by hand.
#[test]
fn equations_of_motion() {
    let (m, l) = (0.9, 1.1);
    let pendulum = SphericalPendulum::new(m, l);
    for State { q, qd, t } in random_states([0.3..2.8, -3.0..3.0]) {
        let a = pendulum.accel(&q, &qd, t);
        let (sin, cos) = q[0].sin_cos();
        assert_balance("θ", &[a[0], -qd[1] * qd[1] * sin * cos, pendulum.g / l * sin]);
        assert_balance("φ", &[sin * a[1], 2.0 * qd[0] * qd[1] * cos]);
        assert_number("p_φ", pendulum.momenta(&q, &qd, t)[1], m * l * l * sin * sin * qd[1]);
        assert_eq!(pendulum.force(&q, &qd, t)[1], 0.0, "p_φ is conserved");
        let kinetic = 0.5 * m * l * l * (qd[0] * qd[0] + sin * sin * qd[1] * qd[1]);
        assert_balance("energy", &[pendulum.energy(&q, &qd, t), -kinetic, m * pendulum.g * l * cos]);
    }
}

/// Conical motion, φ̇² = g/(l cos θ), and the frequency of its disturbances at constant p_φ.
#[test]
fn conical_motion() {
    let reference = Reference::read("prob-11.3-spherical-pendulum");
    let pendulum = with_reference::<SphericalPendulum, 2>();
    for case in reference.special("conical").as_array().expect("a list") {
        let (theta, phid) = (number(&case["theta"]), number(&case["phidot"]));
        let (q, qd) = (SVector::from([theta, 0.0]), SVector::from([0.0, phid]));
        let weight = pendulum.g / pendulum.l * theta.sin();
        assert_balance("θ̈", &[pendulum.accel(&q, &qd, 0.0)[0] + weight, -weight]);

        // At constant p_φ the rate φ̇ changes by −2 φ̇ cot θ per unit of θ.
        let jacobian = pendulum.jacobian(&q, &qd, 0.0);
        let frequency = number(&case["small_disturbance_frequency"]);
        let slope = -2.0 * phid / theta.tan();
        assert_balance(
            "disturbance",
            &[jacobian.q[(0, 0)], jacobian.qd[(0, 1)] * slope, frequency * frequency],
        );
    }
}

#[test]
fn facts_of_the_spherical_pendulum() {
    let holding = ["scleronomic", "conservative", "quadratic"];
    assert_facts::<SphericalPendulum, 2>(&holding, &[1], &[&[0, 1]]);
}

/// φ is ignorable although x and y depend on it.
#[test]
fn facts_do_not_depend_on_the_writing() {
    let holding = ["scleronomic", "conservative", "quadratic"];
    assert_facts::<BobOnASphere, 2>(&holding, &[1], &[&[0, 1]]);
}
