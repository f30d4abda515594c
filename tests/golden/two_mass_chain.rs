//! Two masses in a row between two walls, with springs k₁, k₂, k₁. Example 11.6(i), Section 11.10.3.

use super::harness::{Row, list, number, with_reference};
use lagrange_runtime::Lagrangian;
use lagrange_runtime::prelude::{SVector, lagrangian};
use lagrange_runtime::traits::{Conservative, Linear, Separable};

lagrangian! {
    /// Displacements from rest, the masses by name.
    pub system TwoMassChain {
        param m1, m2, k1, k2;
        coord x1, x2;
        T = 0.5 * (m1 * dot(x1).powi(2) + m2 * dot(x2).powi(2));
        V = 0.5 * (k1 * x1.powi(2) + k2 * (x2 - x1).powi(2) + k1 * x2.powi(2));
    }
}

golden!(TwoMassChain<2>, "ex-11.6i-two-mass-chain", |p| TwoMassChain {
    m1: p("m1"),
    m2: p("m2"),
    k1: p("k1"),
    k2: p("k2")
});

lagrangian! {
    /// The same, the masses by number.
    pub system Chain {
        const N = 2;
        param m: [N], k: [N];
        coord x: [N];
        T = 0.5 * (0..N).map(|i| m[i] * dot(x[i]).powi(2)).sum();
        V = 0.5 * k[0] * (x[0].powi(2) + x[N - 1].powi(2))
            + 0.5 * (1..N).map(|i| k[i] * (x[i] - x[i - 1]).powi(2)).sum();
    }
}

golden!(Chain<2>, "ex-11.6i-two-mass-chain", |p| Chain { m: [p("m1"), p("m2")], k: [p("k1"), p("k2")] });

lagrangian! {
    /// Equal masses and equal springs, Example 11.6(ii).
    pub system SymmetricChain {
        param m, k;
        coord x1, x2;
        T = 0.5 * m * (dot(x1).powi(2) + dot(x2).powi(2));
        V = 0.5 * k * (x1.powi(2) + (x2 - x1).powi(2) + x2.powi(2));
    }
}

golden!(SymmetricChain<2>, "ex-11.6ii-two-mass-symmetric", |p| SymmetricChain { m: p("m"), k: p("k") });

const FACTS: &str = "scleronomic, conservative, separable, constant inertia, quadratic, linear";

pub fn rows() -> Vec<Row> {
    vec![general(), symmetric()]
}

/// (11.87b): det K = k₁² + 2 k₁ k₂ is positive, so the rest is stable.
fn general() -> Row {
    let row = Row::of::<TwoMassChain, 2>(FACTS, [-2.0..2.0, -2.0..2.0]).also::<Chain, 2>(FACTS);
    let chain = with_reference::<TwoMassChain, 2>();
    let rest = SVector::from([0.0, 0.0]);
    let k = -chain.inertia(&rest, &rest, 0.0) * chain.jacobian(&rest, &rest, 0.0).q;
    let terms =
        [k[(0, 0)] * k[(1, 1)], -k[(0, 1)] * k[(1, 0)], -chain.k1 * chain.k1, -2.0 * chain.k1 * chain.k2];

    // The facts are traits, too: this compiles.
    fn propagates(_: &(impl Linear<2> + Separable<2> + Conservative<2>)) {}
    propagates(&chain);
    row.balance("(11.87b)", &terms)
}

/// The modes (11.40q,r): released from x₁ = ±x₂ the masses keep that ratio.
fn symmetric() -> Row {
    let mut row = Row::of::<SymmetricChain, 2>(FACTS, [-2.0..2.0, -2.0..2.0]);
    let reference = row.subject().reference.clone();
    for (mode, start, signs) in
        [("mode1_11_40q", "x1(0)=x2(0)", [1.0, 1.0]), ("mode2_11_40r", "-x1(0)=x2(0)", [-1.0, 1.0])]
    {
        let mode = reference.special(mode);
        let [start, t, x1, x2] = [start, "t", "x1", "x2"].map(|name| number(&mode[name]));
        row = row.motion("mode", (&signs.map(|sign| sign * start), &[0.0, 0.0]), t, &[(0, x1), (1, x2)]);
    }
    let frequencies = list(reference.special("frequencies_11_40k"));
    row.number("ω₂/ω₁ = √3", number(&frequencies[1]), 3.0f64.sqrt() * number(&frequencies[0]))
}
