//! Bodies that drift to rest in a Stokes medium: a particle, and a lineal rigid body that spins. Section 11.14.
//!
//! Erratum of the source: one sentence on the particle has D = −νT; D = +νT, so that Ṫ = −2νT.

use super::harness::{Quantity, Row, State, list, number};
use lagrange_runtime::prelude::lagrangian;

lagrangian! {
    /// A particle under drag alone.
    pub system DriftingParticle {
        param m, c;
        coord x, y, z;
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2));
        V = 0;
        D = 0.5 * c * (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2));
    }
}

golden!(DriftingParticle<3>, "sec-11.14-stokes-particle-energy", |p| DriftingParticle {
    m: p("m"),
    c: p("c")
});

lagrangian! {
    /// A body about a fixed axis.
    pub system SpinningBody {
        param I, be;
        coord theta;
        T = 0.5 * I * dot(theta).powi(2);
        V = 0;
        D = 0.5 * be * I * dot(theta).powi(2);
    }
}

golden!(SpinningBody<1>, "sec-11.14-lineal-rigid-body", |p| SpinningBody { I: p("I"), be: p("be") });

pub fn rows() -> Vec<Row> {
    vec![particle(), body()]
}

/// D = νT at every state, and the velocity falls by e^{−νt}.
fn particle() -> Row {
    let row = Row::of::<DriftingParticle, 3>(
        "scleronomic, constant inertia, quadratic, linear, blocks x | y | z",
        [-2.0..2.0, -2.0..2.0, -2.0..2.0],
    );
    let reference = row.subject().reference.clone();
    let start = reference.trajectory().remove(0);
    let [initial, nu] = ["T0", "nu"].map(|name| number(reference.special(name)));
    let point = row.subject().at("", &start);
    let (kinetic, dissipation) = (point.number(Quantity::Kinetic), point.number(Quantity::Dissipation));
    let mut row = row.number("T₀", kinetic, initial).number("D = νT", dissipation, nu * kinetic);
    for case in list(reference.special("decay")) {
        let [t, energy] = ["t", "T"].map(|name| number(&case[name]));
        let slower = (energy / initial).sqrt();
        let expected: Vec<_> = start.qd.iter().enumerate().map(|(k, rate)| (3 + k, rate * slower)).collect();
        row = row
            .number("e^{−2νt}", (-2.0 * nu * t).exp(), energy / initial)
            .number("D = νT", nu * energy, number(&case["D"]))
            .motion("ẋ at the end", (&start.q, &start.qd), t, &expected);
    }
    row
}

/// T falls by e^{−2βt}, and the angle tends to θ₀ + ω₀/β.
fn body() -> Row {
    let mut row = Row::of::<SpinningBody, 1>("scleronomic, constant inertia, quadratic, linear", [-3.0..3.0]);
    let reference = row.subject().reference.clone();
    let State { q, qd, .. } = reference.trajectory().remove(0);
    let be = reference.parameter("be");
    for case in list(reference.special("T(t)/T0")) {
        let [t, ratio] = ["t", "ratio"].map(|name| number(&case[name]));
        let rate = qd[0] * ratio.sqrt();
        let turned = (qd[0] - rate) / be;
        row = row.number("e^{−2βt}", (-2.0 * be * t).exp(), ratio).motion(
            "ω at the end",
            (&q, &qd),
            t,
            &[(1, rate), (0, q[0] + turned)],
        );
    }
    row
}
