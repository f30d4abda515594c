//! Spherical pendulum, θ from the downward vertical: in its angles and by the position of the bob. Problem 11.3.

use super::harness::{Row, list, number, with_reference};
use lagrange_runtime::prelude::{SVector, lagrangian};
use lagrange_runtime::{Lagrangian, System};

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
    /// The pendulum by the position of its bob.
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

/// φ is ignorable, although x and y depend on it.
pub fn rows() -> Vec<Row> {
    let facts = "scleronomic, conservative, quadratic, ignorable phi";
    let mut row =
        Row::of::<SphericalPendulum, 2>(facts, [0.3..2.8, -3.0..3.0]).also::<BobOnASphere, 2>(facts);
    let pendulum = with_reference::<SphericalPendulum, 2>();
    // Conical motion, φ̇² = g/(l cos θ), and the frequency of its disturbances at constant p_φ.
    for case in list(&row.subject().reference.special("conical").clone()) {
        let (theta, phid) = (number(&case["theta"]), number(&case["phidot"]));
        let (q, qd) = (SVector::from([theta, 0.0]), SVector::from([0.0, phid]));
        let weight = pendulum.g / pendulum.l * theta.sin();
        row = row.balance("conical motion", &[pendulum.accel(&q, &qd, 0.0)[0] + weight, -weight]);

        // At constant p_φ the rate φ̇ changes by −2 φ̇ cot θ per unit of θ.
        let jacobian = pendulum.jacobian(&q, &qd, 0.0);
        let frequency = number(&case["small_disturbance_frequency"]);
        let terms = [jacobian.q[(0, 0)], jacobian.qd[(0, 1)] * -2.0 * phid / theta.tan()];
        row = row.balance("disturbance", &[terms[0], terms[1], frequency * frequency]).show(
            "ω of the cone",
            (-terms[0] - terms[1]).sqrt(),
            frequency,
        );
    }
    vec![row]
}
