//! A Lagrangian of two coordinates with terms of degree 2, 1 and 0 in the velocities, one coordinate ignorable, drag
//! on the other. Example 11.7; its L is given whole, the split into T and V is a choice that the equations do not see.
//!
//! Errata of the source: since T is not homogeneous of degree 2, Euler's identity (11.26) fails and T + V is not the
//! integral of the energy; (11.52) does not apply, ḣ = −m b² ν q̇₁² does. Putting the conserved p₂ into L before
//! differentiating gives a wrong equation for q₁; the Routhian gives (11.48d).

use super::harness::{Row, list, number, recovered, with_reference};
use lagrange_runtime::prelude::{SVector, State, lagrangian};
use lagrange_runtime::{Lagrangian, System};

lagrangian! {
    /// The system by L, with the drag as a generalized force.
    pub system IgnorableWithDrag {
        param m, a, b, c, nu;
        coord q1, q2;
        L = m * (b * dot(q2) + a * q1.cos()).powi(2)
            + 0.5 * m * b.powi(2) * (dot(q1) + c).powi(2)
            + 0.5 * m * (a * q1.sin()).powi(2);
        Q[q1] = -m * b.powi(2) * nu * dot(q1);
        pub routhian Reduced;
    }
}

golden!(
    IgnorableWithDrag<2>,
    "ex-11.7-ignorable-nonconservative",
    |p| IgnorableWithDrag { m: p("m"), a: p("a"), b: p("b"), c: p("c"), nu: p("nu") },
    given L
);

lagrangian! {
    /// The system by T and V.
    pub system IgnorableSplit {
        param m, a, b, c, nu;
        coord q1, q2;
        T = m * b * b * (dot(q2) + a / b * cos(q1)).powi(2) + 0.5 * m * b * b * (dot(q1) + c).powi(2);
        V = -0.5 * m * a * a * sin(q1) * sin(q1);
        Q[q1] = -m * b * b * nu * dot(q1);
    }
}

golden!(IgnorableSplit<2>, "ex-11.7-ignorable-nonconservative", |p| IgnorableSplit {
    m: p("m"),
    a: p("a"),
    b: p("b"),
    c: p("c"),
    nu: p("nu")
});

pub fn rows() -> Vec<Row> {
    let facts = "scleronomic, constant inertia, quadratic, ignorable q2";
    let mut row =
        Row::of::<IgnorableWithDrag, 2>(facts, [-3.0..3.0, -3.0..3.0]).also::<IgnorableSplit, 2>(facts);
    let reference = row.subject().reference.clone();
    let system = with_reference::<IgnorableWithDrag, 2>();

    // c stands in L as c q̇₁, the derivative of c q₁: no motion depends on it.
    let other = IgnorableWithDrag { c: -7.0, ..system };
    for k in 0..2 {
        row = row.balances("c drops out", |at| {
            let (q, qd) = (SVector::from_column_slice(&at.q), SVector::from_column_slice(&at.qd));
            vec![system.accel(&q, &qd, at.t)[k], -other.accel(&q, &qd, at.t)[k]]
        });
    }

    // The compiler's reduction: the same motion, and R by its definition.
    row = recovered(row, &system, IgnorableWithDrag::reduce)
        .balances("q̈₁ of the Routhian", |at| {
            let state = State::new(at.t, [at.q[0], at.q[1]], [at.qd[0], at.qd[1]]);
            let (reduced, left) = system.reduce(&state);
            let terms = [
                (system.a / system.b).powi(2) * at.q[0].sin() * at.q[0].cos(),
                system.a / system.b.powi(3) * reduced.p_q2 / system.m * at.q[0].sin(),
                system.nu * at.qd[0],
            ];
            let size: f64 = terms.iter().map(|term| term.abs()).sum();
            let alone = reduced.accel(&left.q, &left.qd, at.t)[0];
            vec![alone, -system.accel(&state.q, &state.qd, at.t)[0], size, -size]
        })
        .balances("R = L − p₂ q̇₂", |at| {
            let state = State::new(at.t, [at.q[0], at.q[1]], [at.qd[0], at.qd[1]]);
            let (reduced, left) = system.reduce(&state);
            let routhian = reduced.lagrangian(&left.q, &left.qd, at.t);
            vec![routhian, -system.lagrangian(&state.q, &state.qd, at.t), reduced.p_q2 * at.qd[1]]
        });

    // The reduced equation (11.48d), with γ₂ from (11.48b), and the loss of h.
    for case in list(reference.special("reduced_equation")) {
        let q = SVector::from([number(&case["q1"]), 0.0]);
        let qd = SVector::from([number(&case["q1dot"]), number(&case["q2dot"])]);
        row = row
            .number("γ₂", system.momenta(&q, &qd, 0.0)[1], number(&case["gamma2"]))
            .number("ḣ", system.power(&q, &qd, 0.0), number(&case["dh_dt"]))
            .special("q̈₁ (11.48d)", system.accel(&q, &qd, 0.0)[0], number(&case["q1ddot_11_48d"]));
    }
    vec![row]
}
