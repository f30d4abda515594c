//! Free particle in cylindrical coordinates under a force whose components along the polar unit vectors are given
//! functions of time; as generalized forces, and as a force on a point. Example 11.1, Exercise 11.2. The histories of
//! the force are a choice.

use super::harness::Row;
use lagrange_runtime::Scalar;
use lagrange_runtime::prelude::lagrangian;

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
}, with an extern fn);

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
}, with an extern fn);

/// Exercise 11.2: both definitions of the generalized force say the same. φ and z are missing from L, but their momenta
/// change: p_φ by r F_φ, p_z by F_z.
pub fn rows() -> Vec<Row> {
    let facts = "scleronomic, quadratic, blocks r phi | z";
    let row = Row::of::<CylindricalParticle, 3>(facts, [0.4..2.0, -3.0..3.0, -2.0..2.0]);
    vec![row.also::<ParticleUnderForce, 3>(facts)]
}
