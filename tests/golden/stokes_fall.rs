//! Fall in a Stokes medium, the drag −cẏ once as a generalized force (Example 11.4) and once from a Rayleigh function
//! (Example 11.13). y points downwards.

use super::harness::{Row, State, list, number, with_reference};
use lagrange_runtime::Energies;
use lagrange_runtime::Lagrangian;
use lagrange_runtime::prelude::{SVector, lagrangian};

lagrangian! {
    /// Example 11.4.
    pub system StokesFall {
        param m, c, g = 9.81;
        coord y;
        T = 0.5 * m * dot(y).powi(2);
        V = -m * g * y;
        Q[y] = -c * dot(y);
    }
}

golden!(StokesFall<1>, "ex-11.4-stokes-fall-QN", |p| StokesFall { m: p("m"), c: p("c"), g: p("g") });

lagrangian! {
    /// Example 11.13.
    pub system StokesFallOfRayleigh {
        param m, c, g = 9.81;
        coord y;
        T = 0.5 * m * dot(y).powi(2);
        V = -m * g * y;
        D = 0.5 * c * dot(y).powi(2);
    }
}

golden!(StokesFallOfRayleigh<1>, "ex-11.13-stokes-fall-rayleigh", |p| StokesFallOfRayleigh {
    m: p("m"),
    c: p("c"),
    g: p("g")
});

/// The energy falls at the rate c ẏ² = 2 D. Linear with constant coefficients: the constant term g does not change
/// that. The text on the special case after (11.95) has D = −νT once, which is an erratum: D = +νT with ν = c/m.
pub fn rows() -> Vec<Row> {
    let facts = "scleronomic, constant inertia, quadratic, linear";
    let force = from_rest(Row::of::<StokesFall, 1>(facts, [-2.0..2.0]));
    let rayleigh =
        from_rest(Row::of::<StokesFallOfRayleigh, 1>(facts, [-2.0..2.0]).also::<StokesFall, 1>(facts));
    let damped = with_reference::<StokesFallOfRayleigh, 1>();
    let rayleigh = rayleigh.balances("D = νT", |at| {
        let (q, qd) = (SVector::from([at.q[0]]), SVector::from([at.qd[0]]));
        vec![damped.dissipation(&q, &qd, at.t), -damped.c / damped.m * damped.kinetic(&q, &qd, at.t)]
    });
    vec![force, rayleigh]
}

/// v = (g/ν)(1 − e^{−νt}) and its integral; the speed tends to g/ν.
fn from_rest(mut row: Row) -> Row {
    let reference = row.subject().reference.clone();
    for case in list(reference.special("from_rest")) {
        let [t, y, v] = ["t", "y", "v"].map(|name| number(&case[name]));
        row = row.motion("fall from rest", (&[0.0], &[0.0]), t, &[(0, y), (1, v)]);
    }
    // The acceleration is linear in the speed.
    let fall = |speed: f64| row.subject().accelerations(&State::new(&[0.0], &[speed], 0.0))[0];
    let terminal = fall(0.0) / (fall(0.0) - fall(1.0));
    row.special("terminal speed", terminal, number(reference.special("terminal_speed")))
}
