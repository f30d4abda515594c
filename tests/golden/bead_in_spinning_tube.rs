//! Bead in a smooth circular tube that spins at constant speed about a vertical diameter: by a prescribed azimuth and
//! the position of the bead, and reduced by hand. Example 11.5(a).
//!
//! Erratum of the source: the reaction at the end of Example 11.5(b) lacks the dot on θ; R = 2 m a ω θ̇ cos θ, as in
//! (11.39g).

use crate::golden;
use crate::harness::{
    Reference, State, assert_balance, assert_facts, check, check_equal, check_trajectory, number,
};
use crate::harness::{random_states, with_reference};
use lagrange_runtime::prelude::*;
use nalgebra::SVector;

lagrangian! {
    /// θ from the downward vertical; the tube turns as φ = ωt.
    pub system BeadInTube {
        param m, a, om, g = 9.81;
        coord theta;
        coord phi = om * t;
        let x = a * theta.sin() * phi.cos();
        let y = a * theta.sin() * phi.sin();
        let z = a * (1 - theta.cos());
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2));
        V = m * g * z;
        observe bead = [x, y, z];
    }
}

golden!(BeadInTube<1>, "ex-11.5a-bead-in-spinning-tube", |p| BeadInTube {
    m: p("m"),
    a: p("a"),
    om: p("om"),
    g: p("g")
});

lagrangian! {
    /// With the speed of the tube put into T.
    pub system BeadReduced {
        param m, a, om, g = 9.81;
        coord theta;
        T = 0.5 * m * a.powi(2) * (dot(theta).powi(2) + (om * theta.sin()).powi(2));
        V = m * g * a * (1 - theta.cos());
    }
}

golden!(BeadReduced<1>, "ex-11.5a-bead-in-spinning-tube", |p| BeadReduced {
    m: p("m"),
    a: p("a"),
    om: p("om"),
    g: p("g")
});

#[test]
fn reference() {
    check::<BeadInTube, 1>();
    check::<BeadReduced, 1>();
}

#[test]
fn trajectory() {
    check_trajectory::<BeadInTube, 1>();
    check_trajectory::<BeadReduced, 1>();
}

#[test]
fn writings_agree() {
    check_equal::<BeadInTube, BeadReduced, 1>([-3.1..3.1]);
}

/// (11.39e): θ̈ + sin θ (g/a − ω² cos θ) = 0, and the integral (11.39f), which is 2h/(m a²) but for a constant.
#[test]
fn equation_of_motion() {
    let (m, a, om) = (0.4, 0.5, 5.3);
    let bead = BeadInTube::new(m, a, om);
    let g = bead.g;
    for State { q, qd, t } in random_states([-3.1..3.1]) {
        let (sin, cos) = q[0].sin_cos();
        let acceleration = bead.accel(&q, &qd, t)[0];
        assert_balance("(11.39e)", &[acceleration, g / a * sin, -om * om * sin * cos]);
        assert_balance(
            "(11.39f)",
            &[
                2.0 * bead.jacobi(&q, &qd, t) / (m * a * a),
                -qd[0] * qd[0],
                om * om * sin * sin,
                2.0 * g / a * cos,
                -2.0 * g / a,
            ],
        );
    }
}

/// The bead rests in the tube at the bottom, at the top, and at cos θ = g/(aω²); stable where θ̈ falls with θ.
#[test]
fn relative_equilibria() {
    let reference = Reference::read("ex-11.5a-bead-in-spinning-tube");
    let bead = with_reference::<BeadReduced, 1>();
    let rest = SVector::from([0.0]);
    for place in reference.special("relative_equilibria").as_array().expect("a list") {
        let q = SVector::from([number(&place["theta"])]);
        let (sin, cos) = q[0].sin_cos();
        let weight = bead.g / bead.a * sin;
        // π is not a double, so the top is missed by 1e-16.
        let missed = f64::EPSILON * (bead.g / bead.a + bead.om * bead.om);
        assert!(bead.accel(&q, &rest, 0.0)[0].abs() <= 1e-13 * weight.abs() + missed, "θ = {}", q[0]);
        let stiffness = -bead.jacobian(&q, &rest, 0.0).q[0];
        let terms = [bead.g / bead.a * cos, bead.om * bead.om * (sin * sin - cos * cos)];
        assert_balance("stiffness", &[stiffness - terms[0] - terms[1], terms[0], -terms[0]]);
        assert!((stiffness - number(&place["omega2"])).abs() <= 1e-13 * (terms[0].abs() + terms[1].abs()));
    }
}

/// h is conserved, T + V is not. In the reduced writing nothing says any more that the constraint moves.
#[test]
fn facts_of_the_reduced_bead() {
    let holding = ["scleronomic", "conservative", "separable", "constant inertia", "quadratic"];
    assert_facts::<BeadReduced, 1>(&holding, &[], &[&[0]]);
}

/// t leaves L with sin² φ + cos² φ = 1; the system stays rheonomic.
#[test]
fn facts_do_not_depend_on_the_writing() {
    let holding = ["conservative", "separable", "constant inertia", "quadratic"];
    assert_facts::<BeadInTube, 1>(&holding, &[], &[&[0]]);
}
