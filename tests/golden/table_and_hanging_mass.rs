//! Mass on a smooth table, tied by a string through a hole to a hanging mass. Problem 11.13; a stand-in, since the
//! problem refers to another chapter.

use super::harness::{Row, number, with_reference};
use lagrange_runtime::prelude::{SVector, lagrangian};
use lagrange_runtime::{Lagrangian, System};

lagrangian! {
    /// r, θ: polar coordinates on the table; the hanging mass rises with r.
    pub system TableAndHangingMass {
        param m1, m2, g = 9.81;
        coord r, theta;
        T = 0.5 * m1 * (dot(r).powi(2) + (r * dot(theta)).powi(2)) + 0.5 * m2 * dot(r).powi(2);
        V = m2 * g * r;
    }
}

golden!(TableAndHangingMass<2>, "prob-11.13-table-and-hanging-mass", |p| TableAndHangingMass {
    m1: p("m1"),
    m2: p("m2"),
    g: p("g")
});

/// The circle m₁ r θ̇² = m₂ g, and the radial frequency of its disturbances at constant p_θ.
pub fn rows() -> Vec<Row> {
    let facts = "scleronomic, conservative, quadratic, ignorable theta";
    let row = Row::of::<TableAndHangingMass, 2>(facts, [0.3..2.0, -3.0..3.0]);
    let system = with_reference::<TableAndHangingMass, 2>();
    let circle = row.subject().reference.special("circular").clone();
    let (r, rate) = (number(&circle["r"]), number(&circle["thetadot"]));
    let (q, qd) = (SVector::from([r, 0.0]), SVector::from([0.0, rate]));
    let weight = system.m2 * system.g / (system.m1 + system.m2);
    let row = row.balance("circle", &[system.accel(&q, &qd, 0.0)[0] + weight, -weight]);

    // At constant p_θ the rate θ̇ changes by −2 θ̇/r per unit of r.
    let jacobian = system.jacobian(&q, &qd, 0.0);
    let frequency = number(&circle["radial_frequency"]);
    let terms = [jacobian.q[(0, 0)], jacobian.qd[(0, 1)] * -2.0 * rate / r];
    let row = row.balance("radial frequency", &[terms[0], terms[1], frequency * frequency]);
    vec![row.show("ω of the circle", (-terms[0] - terms[1]).sqrt(), frequency)]
}
