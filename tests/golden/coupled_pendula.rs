//! Two equal pendula coupled by a spring at the distance a below their pivots. Problem 11.34; reconstructed, since its
//! figure is missing: equal masses and lengths, and a spring that is stretched by the horizontal distance alone.

use crate::golden;
use crate::harness::{
    Reference, State, assert_balance, assert_facts, check, check_trajectory, number, random_states,
    with_reference,
};
use lagrange_runtime::prelude::*;
use nalgebra::SVector;

lagrangian! {
    /// Angles from the downward vertical.
    pub system CoupledPendula {
        param m, l, a, k, g = 9.81;
        coord th1, th2;
        T = 0.5 * m * l.powi(2) * (dot(th1).powi(2) + dot(th2).powi(2));
        V = m * g * l * (2 - th1.cos() - th2.cos()) + 0.5 * k * (a * th1.sin() - a * th2.sin()).powi(2);
    }
}

golden!(CoupledPendula<2>, "prob-11.34-coupled-pendula", |p| CoupledPendula {
    m: p("m"),
    l: p("l"),
    a: p("a"),
    k: p("k"),
    g: p("g")
});

#[test]
fn reference() {
    check::<CoupledPendula, 2>();
}

#[test]
fn trajectory() {
    check_trajectory::<CoupledPendula, 2>();
}

/// m l² θ̈₁ + m g l sin θ₁ + k a² (sin θ₁ − sin θ₂) cos θ₁ = 0 and its mirror image, derived by hand.
#[test]
fn equations_of_motion() {
    let (m, l, a, k) = (0.5, 0.9, 0.4, 3.0);
    let pendula = CoupledPendula::new(m, l, a, k);
    for State { q, qd, t } in random_states([-3.1..3.1, -3.1..3.1]) {
        let acceleration = pendula.accel(&q, &qd, t);
        for (mine, other) in [(0, 1), (1, 0)] {
            let (sin, cos) = q[mine].sin_cos();
            assert_balance(
                "θ",
                &[
                    m * l * l * acceleration[mine],
                    m * pendula.g * l * sin,
                    k * a * a * sin * cos,
                    -k * a * a * q[other].sin() * cos,
                ],
            );
        }
    }
}

/// In phase the spring idles, ω² = g/l; out of phase ω² = g/l + 2 k a²/(m l²).
#[test]
fn small_vibrations() {
    let reference = Reference::read("prob-11.34-coupled-pendula");
    let pendula = with_reference::<CoupledPendula, 2>();
    let origin = SVector::from([0.0, 0.0]);
    let jacobian = pendula.jacobian(&origin, &origin, 0.0).q;
    let frequencies = reference.special("frequencies");
    for (index, mode) in [[1.0, 1.0], [1.0, -1.0]].into_iter().enumerate() {
        let frequency = number(&frequencies[index]["value"]);
        for row in 0..2 {
            let pull = [jacobian[(row, 0)] * mode[0], jacobian[(row, 1)] * mode[1]];
            assert_balance("mode", &[pull[0], pull[1], frequency * frequency * mode[row]]);
        }
    }
}

#[test]
fn facts_of_the_pendula() {
    let holding = ["scleronomic", "conservative", "separable", "constant inertia", "quadratic"];
    assert_facts::<CoupledPendula, 2>(&holding, &[], &[&[0, 1]]);
}
