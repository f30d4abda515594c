//! Free particle in spherical coordinates (θ from the polar axis) under a force whose components along the spherical
//! unit vectors are given functions of time. Exercise 11.3. The histories of the force are a choice.

use crate::golden;
use crate::harness::{
    State, assert_balance, assert_facts, check, check_equal, check_trajectory, random_states,
};
use lagrange_runtime::prelude::*;

/// F_r.
fn outward<S: Scalar>(t: S, f1: S, om: S) -> S {
    f1 * (om * t).cos()
}

/// F_θ.
fn southward<S: Scalar>(t: S, f2: S, om: S) -> S {
    f2 * (om * t).sin()
}

/// F_φ.
fn eastward<S: Scalar>(t: S, f3: S) -> S {
    f3 + S::from_f64(0.1) * t
}

lagrangian! {
    /// By kinetic energy and generalized forces in spherical coordinates.
    pub system SphericalParticle {
        param m, f1, f2, f3, om;
        coord r, theta, phi;
        extern fn outward(t, f1, om);
        extern fn southward(t, f2, om);
        extern fn eastward(t, f3);
        T = 0.5 * m * (dot(r).powi(2) + (r * dot(theta)).powi(2) + (r * theta.sin() * dot(phi)).powi(2));
        V = 0;
        Q[r] = outward(t, f1, om);
        Q[theta] = r * southward(t, f2, om);
        Q[phi] = r * theta.sin() * eastward(t, f3);
    }
}

golden!(SphericalParticle<3>, "exer-11.3-spherical-particle", |p| SphericalParticle {
    m: p("m"),
    f1: p("f1"),
    f2: p("f2"),
    f3: p("f3"),
    om: p("Om")
});

lagrangian! {
    /// By the Cartesian position of the particle and the force on it.
    pub system ParticleInSpace {
        param m, f1, f2, f3, om;
        coord r, theta, phi;
        extern fn outward(t, f1, om);
        extern fn southward(t, f2, om);
        extern fn eastward(t, f3);
        let rho = r * theta.sin();
        let x = rho * phi.cos();
        let y = rho * phi.sin();
        let z = r * theta.cos();
        let f_r = outward(t, f1, om);
        let f_theta = southward(t, f2, om);
        let f_phi = eastward(t, f3);
        let f_rho = f_r * theta.sin() + f_theta * theta.cos();
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2));
        V = 0;
        force [
            f_rho * phi.cos() - f_phi * phi.sin(),
            f_rho * phi.sin() + f_phi * phi.cos(),
            f_r * theta.cos() - f_theta * theta.sin(),
        ] at [x, y, z];
    }
}

golden!(ParticleInSpace<3>, "exer-11.3-spherical-particle", |p| ParticleInSpace {
    m: p("m"),
    f1: p("f1"),
    f2: p("f2"),
    f3: p("f3"),
    om: p("Om")
});

#[test]
fn reference() {
    check::<SphericalParticle, 3>();
    check::<ParticleInSpace, 3>();
}

#[test]
fn trajectory() {
    check_trajectory::<SphericalParticle, 3>();
    check_trajectory::<ParticleInSpace, 3>();
}

#[test]
fn writings_agree() {
    check_equal::<SphericalParticle, ParticleInSpace, 3>([0.5..2.0, 0.4..2.7, -3.0..3.0]);
}

/// The components of m ẍ = F along the spherical unit vectors, derived by hand.
#[test]
fn equations_of_motion() {
    let (m, f1, f2, f3, om) = (0.8, 0.9, -0.4, 0.25, 1.3);
    let particle = SphericalParticle::new(m, f1, f2, f3, om);
    for State { q, qd, t } in random_states([0.5..2.0, 0.4..2.7, -3.0..3.0]) {
        let a = particle.accel(&q, &qd, t);
        let (r, (sin, cos)) = (q[0], q[1].sin_cos());
        let (rd, thetad, phid) = (qd[0], qd[1], qd[2]);
        assert_balance(
            "r",
            &[m * a[0], -m * r * thetad * thetad, -m * r * sin * sin * phid * phid, -f1 * (om * t).cos()],
        );
        assert_balance(
            "θ",
            &[m * r * a[1], 2.0 * m * rd * thetad, -m * r * sin * cos * phid * phid, -f2 * (om * t).sin()],
        );
        assert_balance(
            "φ",
            &[
                m * r * sin * a[2],
                2.0 * m * rd * phid * sin,
                2.0 * m * r * thetad * phid * cos,
                -f3,
                -0.1 * t,
            ],
        );
    }
}

/// φ is missing from L, but Q_φ is not 0.
#[test]
fn facts_of_the_particle() {
    assert_facts::<SphericalParticle, 3>(&["scleronomic", "quadratic"], &[], &[&[0, 1, 2]]);
}
