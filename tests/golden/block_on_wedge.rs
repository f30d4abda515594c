//! Block on the smooth face of a wedge that slides on a smooth floor. Problem 11.14; a stand-in, since the problem
//! refers to another chapter.

use crate::golden;
use crate::harness::with_reference;
use crate::harness::{
    Reference, State, assert_balance, assert_facts, assert_number, check, check_trajectory, number,
    random_states,
};
use lagrange_runtime::prelude::*;
use nalgebra::SVector;

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

#[test]
fn reference() {
    check::<BlockOnWedge, 2>();
}

#[test]
fn trajectory() {
    check_trajectory::<BlockOnWedge, 2>();
}

/// (M + m) Ẍ + m s̈ cos α = 0 and s̈ + Ẍ cos α = g sin α, derived by hand; p_X is conserved.
#[test]
fn equations_of_motion() {
    let (wedge, m, al) = (1.5, 0.5, 0.5f64);
    let system = BlockOnWedge::new(wedge, m, al);
    for State { q, qd, t } in random_states([-2.0..2.0, -2.0..2.0]) {
        let a = system.accel(&q, &qd, t);
        assert_balance("X", &[(wedge + m) * a[0], m * a[1] * al.cos()]);
        assert_balance("s", &[a[1], a[0] * al.cos(), -system.g * al.sin()]);
        let p = system.momenta(&q, &qd, t);
        assert_balance("p_X", &[p[0], -(wedge + m) * qd[0], -m * qd[1] * al.cos()]);
        assert_eq!(system.force(&q, &qd, t)[0], 0.0, "p_X is conserved");
    }
}

/// Both accelerations are constant.
#[test]
fn accelerations() {
    let reference = Reference::read("prob-11.14-block-on-wedge");
    let system = with_reference::<BlockOnWedge, 2>();
    let a = system.accel(&SVector::from([0.3, -0.2]), &SVector::from([1.0, 2.0]), 0.0);
    let expected = reference.special("accelerations");
    assert_number("Ẍ", a[0], number(&expected["X"]));
    assert_number("s̈", a[1], number(&expected["s"]));
}

/// Linear with constant coefficients: the constant term does not change that.
#[test]
fn facts_of_the_wedge() {
    let holding = ["scleronomic", "conservative", "separable", "constant inertia", "quadratic", "linear"];
    assert_facts::<BlockOnWedge, 2>(&holding, &[0], &[&[0, 1]]);
}
