//! Projectile without drag. Section 11.10.2.

use super::harness::{Row, number};
use lagrange_runtime::prelude::lagrangian;

lagrangian! {
    /// y points upwards.
    pub system Projectile {
        param m, g = 9.81;
        coord x, y;
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
        V = m * g * y;
    }
}

golden!(Projectile<2>, "sec-11.10.2-projectile", |p| Projectile { m: p("m"), g: p("g") });

/// p_x is conserved, and the path is a parabola.
pub fn rows() -> Vec<Row> {
    let row = Row::of::<Projectile, 2>(
        "scleronomic, conservative, separable, constant inertia, quadratic, linear, ignorable x, blocks x | y",
        [-2.0..2.0, -2.0..2.0],
    );
    let reference = row.subject().reference.clone();
    let [t, x, y] = ["t", "x", "y"].map(|name| number(&reference.special("closed_form")[name]));
    let start = reference.trajectory().remove(0);
    let height = start.q[1] + start.qd[1] * t - 0.5 * reference.parameter("g") * t * t;
    let row = row.number("parabola", height, y);
    vec![row.motion("y at the end", (&start.q, &start.qd), t, &[(1, y), (0, x)])]
}
