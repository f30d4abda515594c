//! Free particle in cylindrical coordinates under a force whose components along the polar unit vectors are given
//! functions of time; as generalized forces, and as a force on a point. Example 11.1, Exercise 11.2. The histories of
//! the force are a choice.

use crate::golden;
use crate::harness::{
    State, assert_balance, assert_facts, check, check_equal, check_trajectory, random_states,
};
use lagrange_runtime::prelude::*;

/// F_r.
fn radial<S: Scalar>(t: S, f1: S, om: S) -> S {
    f1 * (om * t).cos()
}

/// F_φ.
fn circumferential<S: Scalar>(t: S, f2: S, om: S) -> S {
    f2 * (om * t).sin()
}

/// F_z.
fn axial<S: Scalar>(t: S, f3: S) -> S {
    f3 + S::from_f64(0.1) * t
}

lagrangian! {
    /// The generalized forces (11.19f): F_r, r F_φ, F_z.
    pub system CylindricalParticle {
        param m, f1, f2, f3, om;
        coord r, phi, z;
        extern fn radial(t, f1, om);
        extern fn circumferential(t, f2, om);
        extern fn axial(t, f3);
        T = 0.5 * m * (dot(r).powi(2) + (r * dot(phi)).powi(2) + dot(z).powi(2));
        V = 0;
        Q[r] = radial(t, f1, om);
        Q[phi] = r * circumferential(t, f2, om);
        Q[z] = axial(t, f3);
    }
}

golden!(CylindricalParticle<3>, "ex-11.1-cylindrical-particle", |p| CylindricalParticle {
    m: p("m"),
    f1: p("f1"),
    f2: p("f2"),
    f3: p("f3"),
    om: p("Om")
});

lagrangian! {
    /// The force at the particle; its virtual work gives the generalized forces (11.14).
    pub system ParticleUnderForce {
        param m, f1, f2, f3, om;
        coord r, phi, z;
        extern fn radial(t, f1, om);
        extern fn circumferential(t, f2, om);
        extern fn axial(t, f3);
        let x = r * cos(phi);
        let y = r * sin(phi);
        let f_r = radial(t, f1, om);
        let f_phi = circumferential(t, f2, om);
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2));
        V = 0;
        force [
            f_r * cos(phi) - f_phi * sin(phi),
            f_r * sin(phi) + f_phi * cos(phi),
            axial(t, f3),
        ] at [x, y, z];
    }
}

golden!(ParticleUnderForce<3>, "ex-11.1-cylindrical-particle", |p| ParticleUnderForce {
    m: p("m"),
    f1: p("f1"),
    f2: p("f2"),
    f3: p("f3"),
    om: p("Om")
});

#[test]
fn reference() {
    check::<CylindricalParticle, 3>();
    check::<ParticleUnderForce, 3>();
}

#[test]
fn trajectory() {
    check_trajectory::<CylindricalParticle, 3>();
    check_trajectory::<ParticleUnderForce, 3>();
}

/// Exercise 11.2: both definitions of the generalized force say the same.
#[test]
fn writings_agree() {
    check_equal::<CylindricalParticle, ParticleUnderForce, 3>([0.4..2.0, -3.0..3.0, -2.0..2.0]);
}

/// (11.19g): m (r̈ − r φ̇²) = F_r, (m/r) d(r² φ̇)/dt = F_φ, m z̈ = F_z.
#[test]
fn equations_of_motion() {
    let (m, f1, f2, f3, om) = (0.8, 0.9, -0.4, 0.25, 1.3);
    let particle = CylindricalParticle::new(m, f1, f2, f3, om);
    for State { q, qd, t } in random_states([0.4..2.0, -3.0..3.0, -2.0..2.0]) {
        let a = particle.accel(&q, &qd, t);
        let r = q[0];
        assert_balance("(11.19g), r", &[m * a[0], -m * r * qd[1] * qd[1], -f1 * (om * t).cos()]);
        let spin = [m / r * r * r * a[1], m / r * 2.0 * r * qd[0] * qd[1]];
        assert_balance("(11.19g), φ", &[spin[0], spin[1], -f2 * (om * t).sin()]);
        assert_balance("(11.19g), z", &[m * a[2], -f3, -0.1 * t]);
    }
}

/// φ and z are missing from L, but their momenta change: p_φ by r F_φ, p_z by F_z.
#[test]
fn facts_of_the_particle() {
    assert_facts::<CylindricalParticle, 3>(&["scleronomic", "quadratic"], &[], &[&[0, 1], &[2]]);
    assert_facts::<ParticleUnderForce, 3>(&["scleronomic", "quadratic"], &[], &[&[0, 1], &[2]]);
}
