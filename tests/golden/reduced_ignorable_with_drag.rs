//! Example 11.7 reduced: a Lagrangian with terms of degree 2, 1 and 0 in the velocities, drag on the coordinate that is
//! left. Putting the conserved momentum into L itself, the trap of that example, gives another equation.

use crate::harness::{Reference, State, assert_balance, assert_number, random_states};
use lagrange_runtime::prelude::*;
use nalgebra::SVector;

lagrangian! {
    pub system Whole {
        param m, a, b, c, nu;
        coord q1, q2;
        L = m * (b * dot(q2) + a * q1.cos()).powi(2)
            + 0.5 * m * b.powi(2) * (dot(q1) + c).powi(2)
            + 0.5 * m * (a * q1.sin()).powi(2);
        Q[q1] = -m * b.powi(2) * nu * dot(q1);
        routhian Reduced;
    }
}

/// (11.48d), and the two momenta.
#[test]
fn equations_of_motion() {
    let reference = Reference::read("ex-11.7-ignorable-nonconservative");
    let [m, a, b, c, nu] = ["m", "a", "b", "c", "nu"].map(|name| reference.parameter(name));
    let whole = Whole::new(m, a, b, c, nu);
    for State { q, qd, t } in random_states([-3.0..3.0, -3.0..3.0]) {
        let state = lagrange_runtime::State { t, q, qd };
        let (reduced, left) = whole.reduce(&state);
        assert_number("p₂", reduced.p_q2, 2.0 * m * b * (b * qd[1] + a * q[0].cos()));
        // The drag is all that is left of Q.
        assert_number("power", reduced.power(&left.q, &left.qd, t), -m * b * b * nu * qd[0] * qd[0]);
        let accel = reduced.accel(&left.q, &left.qd, t)[0];
        let full = whole.accel(&q, &qd, t);
        let terms = [
            a * a / (b * b) * q[0].sin() * q[0].cos(),
            a / b * reduced.p_q2 / (m * b * b) * q[0].sin(),
            nu * qd[0],
        ];
        assert_balance(
            "q̈₁",
            &[accel, -full[0], terms[0], -terms[0], terms[1], -terms[1], terms[2], -terms[2]],
        );
        let back = reduced.expand(&left, &SVector::from([q[1]]));
        assert_eq!(back.q, q);
        assert_balance("q̇₂", &[back.qd[1], -qd[1], a / b, -a / b]);
    }
}

/// L was given whole, so R is, too: there is no kinetic and no apparent potential energy.
#[test]
fn routhian_by_its_definition() {
    let whole = Whole::new(0.8, 0.6, 1.1, 0.4, 0.3);
    for State { q, qd, t } in random_states([-3.0..3.0, -3.0..3.0]) {
        let (reduced, left) = whole.reduce(&lagrange_runtime::State { t, q, qd });
        let (l, work) = (whole.lagrangian(&q, &qd, t), reduced.p_q2 * qd[1]);
        assert_balance("R = L − p₂ q̇₂", &[reduced.lagrangian(&left.q, &left.qd, t), -l, work]);
    }
}
