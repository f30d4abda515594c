//! The general linear system of two degrees of freedom. Example 11.11.
//!
//! Erratum of the source: (11.86) has a first derivative in its inertia term; M q̈ + K q = 0 is meant, as in (11.87a).

use super::harness::Row;
use lagrange_runtime::prelude::lagrangian;

lagrangian! {
    /// Inertial and elastic coupling.
    pub system GenericTwoDof {
        param M11, M12, M22, K11, K12, K22;
        coord q1, q2;
        T = 0.5 * (M11 * dot(q1).powi(2) + 2 * M12 * dot(q1) * dot(q2) + M22 * dot(q2).powi(2));
        V = 0.5 * (K11 * q1.powi(2) + 2 * K12 * q1 * q2 + K22 * q2.powi(2));
    }
}

golden!(GenericTwoDof<2>, "ex-11.11-generic-two-dof", |p| GenericTwoDof {
    M11: p("M11"),
    M12: p("M12"),
    M22: p("M22"),
    K11: p("K11"),
    K12: p("K12"),
    K22: p("K22")
});

/// (11.89): the squares of the frequencies have the product det K/det M.
pub fn rows() -> Vec<Row> {
    let row = Row::of::<GenericTwoDof, 2>(
        "scleronomic, conservative, separable, constant inertia, quadratic, linear",
        [-2.0..2.0, -2.0..2.0],
    );
    let reference = row.subject().reference.clone();
    let [m11, m12, m22, k11, k12, k22] =
        ["M11", "M12", "M22", "K11", "K12", "K22"].map(|name| reference.parameter(name));
    let squares = reference.small()[0].numbers("omega2");
    let product = squares[0] * squares[1] * (m11 * m22 - m12 * m12);
    vec![row.balance("(11.89)", &[product, -k11 * k22, k12 * k12])]
}
