//! Damped free vibration in the plane, coupled by the dissipation alone. Example 11.14.
//!
//! Remark on the source: D is positive definite, and every motion damped, only where c₁ c₂ > c₁₂².

use super::harness::{Row, with_reference};
use lagrange_runtime::Lagrangian;
use lagrange_runtime::prelude::{SVector, lagrangian};

lagrangian! {
    /// Two masses on springs of their own, and dampers that couple them.
    pub system DampedTwoDof {
        param m1, m2, k1, k2, c1, c12, c2;
        coord x, y;
        T = 0.5 * m1 * dot(x).powi(2) + 0.5 * m2 * dot(y).powi(2);
        V = 0.5 * k1 * x.powi(2) + 0.5 * k2 * y.powi(2);
        D = 0.5 * (c1 * dot(x).powi(2) + 2 * c12 * dot(x) * dot(y) + c2 * dot(y).powi(2));
    }
}

golden!(DampedTwoDof<2>, "ex-11.14-damped-two-dof", |p| DampedTwoDof {
    m1: p("m1"),
    m2: p("m2"),
    k1: p("k1"),
    k2: p("k2"),
    c1: p("c1"),
    c12: p("c12"),
    c2: p("c2")
});

/// With c₁ c₂ < c₁₂² there are velocities at which the dampers would drive.
pub fn rows() -> Vec<Row> {
    let facts = "scleronomic, constant inertia, quadratic, linear";
    let row = Row::of::<DampedTwoDof, 2>(facts, [-2.0..2.0, -2.0..2.0]);
    let system = with_reference::<DampedTwoDof, 2>();
    let along = |c12: f64, ratio: f64| {
        let (q, qd) = (SVector::from([0.0, 0.0]), SVector::from([1.0, ratio]));
        DampedTwoDof { c12, ..system }.dissipation(&q, &qd, 0.0)
    };
    // D is least along ẏ/ẋ = −c₁₂/c₂, where it is (c₁ − c₁₂²/c₂)ẋ²/2.
    let least = |c12: f64| along(c12, -c12 / system.c2);
    let expected = 0.5 * (system.c1 - system.c12.powi(2) / system.c2);
    let row = row.holds("D > 0", least(system.c12) > 0.0).holds("D < 0 where c₁ c₂ < c₁₂²", least(0.6) < 0.0);
    vec![row.special("least D", least(system.c12), expected)]
}
