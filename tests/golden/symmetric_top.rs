//! Heavy symmetric top about a fixed point, in Euler angles. Section 11.12.4.
//!
//! Erratum of the source: the frequency of the elliptic solution for the nutation, in footnote (C), is printed with I₃
//! under the root; p² = m g l (x₃ − x₁)/(2 I₁) is right.

use crate::golden;
use crate::harness::with_reference;
use crate::harness::{
    Reference, State, assert_balance, assert_facts, assert_number, check, check_trajectory, number,
    random_states,
};
use lagrange_runtime::prelude::*;
use nalgebra::SVector;

lagrangian! {
    /// φ precession, θ inclination from the upward vertical, ψ spin.
    pub system SymmetricTop {
        param m, l, I1, I3, g = 9.81;
        coord phi, theta, psi;
        let spin = dot(psi) + dot(phi) * cos(theta);
        T = 0.5 * I1 * (dot(theta).powi(2) + (dot(phi) * sin(theta)).powi(2)) + 0.5 * I3 * spin.powi(2);
        V = m * g * l * cos(theta);
    }
}

golden!(SymmetricTop<3>, "sec-11.12.4-symmetric-top", |p| SymmetricTop {
    m: p("m"),
    l: p("l"),
    I1: p("I1"),
    I3: p("I3"),
    g: p("g")
});

#[test]
fn reference() {
    check::<SymmetricTop, 3>();
}

#[test]
fn trajectory() {
    check_trajectory::<SymmetricTop, 3>();
}

/// (11.79h), and the momenta α and β of (11.79e,f), which are conserved.
#[test]
fn equations_of_motion() {
    let (m, l, i1, i3) = (0.5, 0.12, 0.008, 0.0011);
    let top = SymmetricTop::new(m, l, i1, i3);
    for State { q, qd, t } in random_states([-3.0..3.0, 0.3..2.8, -3.0..3.0]) {
        let (sin, cos) = q[1].sin_cos();
        let (phid, psid) = (qd[0], qd[2]);
        let a = top.accel(&q, &qd, t);
        assert_balance(
            "(11.79h)",
            &[
                i1 * a[1],
                i3 * phid * phid * sin * cos,
                -i1 * phid * phid * sin * cos,
                i3 * psid * phid * sin,
                -m * top.g * l * sin,
            ],
        );
        let alpha = [i3 * psid, i3 * phid * cos];
        let p = top.momenta(&q, &qd, t);
        assert_balance("(11.79e)", &[p[2], -alpha[0], -alpha[1]]);
        assert_balance("(11.79f)", &[p[0], -i1 * phid * sin * sin, -alpha[0] * cos, -alpha[1] * cos]);
        let force = top.force(&q, &qd, t);
        assert_eq!((force[0], force[2]), (0.0, 0.0), "α and β are conserved");
    }
}

/// On both branches of (11.79s) the inclination stays and the rates are steady.
#[test]
fn steady_precession() {
    let reference = Reference::read("sec-11.12.4-symmetric-top");
    let top = with_reference::<SymmetricTop, 3>();
    let steady = reference.special("steady_precession");
    let theta = number(&steady["theta0"]);
    for case in steady["cases"].as_array().expect("a list") {
        let q = SVector::from([0.4, theta, -0.2]);
        let qd = SVector::from([number(&case["phidot0"]), 0.0, number(&case["psidot0"])]);
        let a = top.accel(&q, &qd, 0.0);
        // Each moment about the line of nodes, as an angular acceleration.
        let spin = number(&case["omega3"]);
        let terms = [
            top.m * top.g * top.l / top.I1 * theta.sin(),
            qd[0] * qd[0] * theta.sin() * theta.cos(),
            -top.I3 / top.I1 * spin * qd[0] * theta.sin(),
        ];
        assert_balance("(11.79s)", &terms);
        assert_balance("θ̈", &[a[1] + terms[0], -terms[0], terms[1], -terms[1], terms[2], -terms[2]]);
        assert_eq!((a[0], a[2]), (0.0, 0.0), "{case}");
        assert_number("β", top.momenta(&q, &qd, 0.0)[0], number(&case["beta"]));
    }
}

/// The turning points of three nutations are zeros of the cubic (11.79, footnote B): from θ̇ = 0 to θ̇ = 0 with the
/// same α, β and E₀ = E − α²/2I₃.
#[test]
fn turning_points_of_nutation() {
    let reference = Reference::read("sec-11.12.4-symmetric-top");
    let top = with_reference::<SymmetricTop, 3>();
    for case in reference.special("nutation").as_array().expect("a list") {
        let (alpha, beta) = (number(&case["alpha"]), number(&case["beta"]));
        for theta in case["turning_points"].as_array().expect("a list").iter().map(number) {
            let q = SVector::from([0.0, theta, 0.0]);
            let qd = top.velocities(&q, &SVector::from([beta, 0.0, alpha]), 0.0);
            assert_eq!(qd[1], 0.0);
            let spin = 0.5 * alpha * alpha / top.I3;
            assert_balance("E", &[top.energy(&q, &qd, 0.0), -spin, -number(&case["E0"])]);
        }
    }
}

#[test]
fn facts_of_the_top() {
    assert_facts::<SymmetricTop, 3>(&["scleronomic", "conservative", "quadratic"], &[0, 2], &[&[0, 1, 2]]);
}
