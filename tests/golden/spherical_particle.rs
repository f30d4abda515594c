//! Free particle in spherical coordinates (θ from the polar axis) under a force whose components along the spherical
//! unit vectors are given functions of time. Exercise 11.3. The histories of the force are a choice.

use super::harness::Row;
use lagrange_runtime::Scalar;
use lagrange_runtime::prelude::lagrangian;

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
    /// The particle by kinetic energy and generalized forces in spherical coordinates.
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
}, with an extern fn);

lagrangian! {
    /// The particle by its Cartesian position and the force on it.
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
}, with an extern fn);

/// φ is missing from L, but Q_φ is not 0.
pub fn rows() -> Vec<Row> {
    let facts = "scleronomic, quadratic";
    let row = Row::of::<SphericalParticle, 3>(facts, [0.5..2.0, 0.4..2.7, -3.0..3.0]);
    vec![row.also::<ParticleInSpace, 3>(facts)]
}
