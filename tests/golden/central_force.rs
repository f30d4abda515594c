//! Plane motion under an inverse-square central force, in polar coordinates and by Cartesian positions in terms of
//! them. Example 11.3, Section 11.10.1.

use crate::golden;
use crate::harness::random_states;
use crate::harness::{
    Reference, State, assert_balance, assert_facts, assert_number, check, check_equal, check_trajectory,
    number,
};
use lagrange_runtime::prelude::*;
use nalgebra::SVector;

lagrangian! {
    /// A particle attracted by a fixed centre with the force μm/r².
    pub system CentralForce {
        param m, mu;
        coord r, phi;
        T = 0.5 * m * (dot(r).powi(2) + (r * dot(phi)).powi(2));
        V = -mu * m / r;
    }
}

golden!(CentralForce<2>, "ex-11.3-central-force", |p| CentralForce { m: p("m"), mu: p("mu") });

lagrangian! {
    /// The same, by its position in the plane.
    pub system CentralForceInThePlane {
        param m, mu;
        coord r, phi;
        let x = r * cos(phi);
        let y = r * sin(phi);
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
        V = -mu * m / r;
    }
}

golden!(CentralForceInThePlane<2>, "ex-11.3-central-force", |p| CentralForceInThePlane {
    m: p("m"),
    mu: p("mu")
});

#[test]
fn reference() {
    check::<CentralForce, 2>();
    check::<CentralForceInThePlane, 2>();
}

#[test]
fn trajectory() {
    check_trajectory::<CentralForce, 2>();
    check_trajectory::<CentralForceInThePlane, 2>();
}

#[test]
fn writings_agree() {
    check_equal::<CentralForce, CentralForceInThePlane, 2>([0.4..3.0, -3.0..3.0]);
}

/// (11.37e): r̈ − r φ̇² + μ/r² = 0 and d(r² φ̇)/dt = 0.
#[test]
fn equations_of_motion() {
    let (m, mu) = (0.9, 1.7);
    let particle = CentralForce::new(m, mu);
    for State { q, qd, t } in random_states([0.4..3.0, -3.0..3.0]) {
        let a = particle.accel(&q, &qd, t);
        let r = q[0];
        assert_balance("(11.37e), r", &[a[0], -r * qd[1] * qd[1], mu / (r * r)]);
        assert_balance("(11.37e), φ", &[2.0 * r * qd[0] * qd[1], r * r * a[1]]);
        assert_number("p_φ = m r² φ̇", particle.momenta(&q, &qd, t)[1], m * r * r * qd[1]);
        assert_eq!(particle.force(&q, &qd, t)[1], 0.0, "p_φ is conserved");
        let speed = qd[0] * qd[0] + r * r * qd[1] * qd[1];
        assert_balance("energy", &[particle.energy(&q, &qd, t), -0.5 * m * speed, mu * m / r]);
    }
}

/// The circle r = γ²/μ: no radial acceleration, and the radial frequency μ²/γ³ from the reduced equation (11.42b).
#[test]
fn circular_orbit() {
    let reference = Reference::read("ex-11.3-central-force");
    let orbit = &reference.special("circular_orbit");
    let gamma = number(reference.special("gamma"));
    let r = number(&orbit["r"]);
    let particle = CentralForce::new(reference.parameter("m"), reference.parameter("mu"));
    let (q, qd) = (SVector::from([r, 0.3]), SVector::from([0.0, gamma / (r * r)]));
    let radial = r * qd[1] * qd[1];
    assert_balance("centripetal", &[particle.accel(&q, &qd, 0.0)[0] + radial, -radial]);

    // At constant γ = r² φ̇ the angular speed changes by −2 φ̇/r per unit of r.
    let jacobian = particle.jacobian(&q, &qd, 0.0);
    let frequency = number(&orbit["radial_frequency"]);
    assert_balance(
        "radial frequency",
        &[jacobian.q[(0, 0)], jacobian.qd[(0, 1)] * (-2.0 * qd[1] / r), frequency * frequency],
    );
}

#[test]
fn facts_of_the_central_force() {
    assert_facts::<CentralForce, 2>(&["scleronomic", "conservative", "quadratic"], &[1], &[&[0, 1]]);
}

/// φ is ignorable although x and y depend on it: sin² φ + cos² φ = 1 has to be found in T.
#[test]
fn facts_do_not_depend_on_the_writing() {
    assert_facts::<CentralForceInThePlane, 2>(
        &["scleronomic", "conservative", "quadratic"],
        &[1],
        &[&[0, 1]],
    );
}
