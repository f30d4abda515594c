//! Atwood's machine with a massive pulley. Problem 11.28; a stand-in, since the problem refers to another chapter.

use super::harness::{Row, State, number};
use lagrange_runtime::prelude::lagrangian;

lagrangian! {
    /// x, way of the first mass downwards.
    pub system Atwood {
        param m1, m2, I, a, g = 9.81;
        coord x;
        let turn = x / a;
        T = 0.5 * (m1 + m2) * dot(x).powi(2) + 0.5 * I * dot(turn).powi(2);
        V = -m1 * g * x + m2 * g * x;
    }
}

golden!(Atwood<1>, "prob-11.28-atwood", |p| Atwood {
    m1: p("m1"),
    m2: p("m2"),
    I: p("I"),
    a: p("a"),
    g: p("g")
});

/// The acceleration is constant.
pub fn rows() -> Vec<Row> {
    let row = Row::of::<Atwood, 1>(
        "scleronomic, conservative, separable, constant inertia, quadratic, linear",
        [-2.0..2.0],
    );
    let found = row.subject().accelerations(&State::new(&[0.3], &[-1.2], 0.0))[0];
    let expected = number(row.subject().reference.special("acceleration"));
    vec![row.special("ẍ", found, expected)]
}
