//! Table on two tangential springs, which measures moments of inertia. Section 11.12.1.

use super::harness::{Row, number, with_reference};
use lagrange_runtime::Lagrangian;
use lagrange_runtime::prelude::{SVector, lagrangian};

lagrangian! {
    /// IS, moment of inertia of table and body; a, distance of the springs from the axis.
    pub system InertiaTable {
        param IS, k, a;
        coord theta;
        T = 0.5 * IS * dot(theta).powi(2);
        V = k * (a * theta).powi(2);
    }
}

golden!(InertiaTable<1>, "sec-11.12.1-inertia-table", |p| InertiaTable { IS: p("IS"), k: p("k"), a: p("a") });

/// (11.76d): the frequencies with and without the body give its moment of inertia.
pub fn rows() -> Vec<Row> {
    let row = Row::of::<InertiaTable, 1>(
        "scleronomic, conservative, separable, constant inertia, quadratic, linear",
        [-2.0..2.0],
    );
    let reference = row.subject().reference.clone();
    let [by_stiffness, by_ratio] =
        ["inversion_11_76d", "inversion_11_76e"].map(|name| reference.special(name));
    let frequency = |inertia: f64| {
        let table = InertiaTable { IS: inertia, ..with_reference::<InertiaTable, 1>() };
        let rest = SVector::from([0.0]);
        (-table.jacobian(&rest, &rest, 0.0).q[0]).sqrt() / std::f64::consts::TAU
    };
    let bare = number(&by_stiffness["I_T"]);
    let (f_s, f_t) = (frequency(reference.parameter("IS")), frequency(bare));
    let ratio = (f_t / f_s).powi(2);
    let found = bare * (ratio - 1.0);
    let expected = number(&by_ratio["I_B"]);
    vec![
        row.number("f_S", f_s, number(&by_ratio["f_S"]))
            .number("f_T", f_t, number(&by_ratio["f_T"]))
            .number("(11.76d)", number(&by_stiffness["I_B"]), number(&by_stiffness["expected"]))
            .within("(11.76e)", found, expected, 1e-13 * bare * ratio)
            .show("I of the body", found, expected),
    ]
}
