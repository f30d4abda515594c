//! Block on the smooth face of a wedge that slides on a smooth floor. Problem 11.14; a stand-in, since the problem
//! refers to another chapter.

use super::harness::{Row, number, with_reference};
use lagrange_runtime::System;
use lagrange_runtime::prelude::{SVector, lagrangian};

lagrangian! {
    /// X, place of the wedge; s, way of the block down the face, which is inclined at al.
    pub system BlockOnWedge {
        param M, m, al, g = 9.81;
        coord X, s;
        let x = X + s * al.cos();
        let y = -s * al.sin();
        T = 0.5 * M * dot(X).powi(2) + 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
        V = m * g * y;
    }
}

golden!(BlockOnWedge<2>, "prob-11.14-block-on-wedge", |p| BlockOnWedge {
    M: p("M"),
    m: p("m"),
    al: p("al"),
    g: p("g")
});

/// Linear with constant coefficients: the constant term does not change that. Both accelerations are constant.
pub fn rows() -> Vec<Row> {
    let facts = "scleronomic, conservative, separable, constant inertia, quadratic, linear, ignorable X";
    let row = Row::of::<BlockOnWedge, 2>(facts, [-2.0..2.0, -2.0..2.0]);
    let system = with_reference::<BlockOnWedge, 2>();
    let a = system.accel(&SVector::from([0.3, -0.2]), &SVector::from([1.0, 2.0]), 0.0);
    let expected = row.subject().reference.special("accelerations").clone();
    let row = row.number("Ẍ", a[0], number(&expected["X"]));
    vec![row.special("s̈", a[1], number(&expected["s"]))]
}
