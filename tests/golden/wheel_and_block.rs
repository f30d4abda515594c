//! Block on a spring that is joined to a cable round a wheel, which a second spring holds. Example 11.9.

use super::harness::{Row, list, number};
use lagrange_runtime::prelude::lagrangian;

lagrangian! {
    /// x, way of the block; phi, turn of the wheel, which pulls out its spring by a phi.
    pub system WheelAndBlock {
        param m, I, a, k1, k2;
        coord x, phi;
        let s = a * phi;
        T = 0.5 * m * dot(x).powi(2) + 0.5 * I * dot(phi).powi(2);
        V = 0.5 * k1 * s.powi(2) + 0.5 * k2 * (x - s).powi(2);
    }
}

golden!(WheelAndBlock<2>, "ex-11.9-wheel-cable-block", |p| WheelAndBlock {
    m: p("m"),
    I: p("I"),
    a: p("a"),
    k1: p("k1"),
    k2: p("k2")
});

/// Both roots of the characteristic equation, by their sum and their product.
pub fn rows() -> Vec<Row> {
    let row = Row::of::<WheelAndBlock, 2>(
        "scleronomic, conservative, separable, constant inertia, quadratic, linear",
        [-2.0..2.0, -2.0..2.0],
    );
    let reference = row.subject().reference.clone();
    let [m, i, a, k1, k2] = ["m", "I", "a", "k1", "k2"].map(|name| reference.parameter(name));
    let roots: Vec<f64> = list(reference.special("p2_roots")).iter().map(number).collect();
    let row = row.balance("sum of the roots", &[roots[0], roots[1], -(k1 + k2) * a * a / i, -k2 / m]).number(
        "product of the roots",
        roots[0] * roots[1],
        k1 * k2 * a * a / (m * i),
    );
    vec![row]
}
