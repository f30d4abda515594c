//! Particle on a smooth incline of slope b that moves sideways as s(t). Section 11.2.1; gravity and the history of s
//! are a choice, the source gives the constraint alone.

use super::harness::{Row, number};
use lagrange_runtime::prelude::lagrangian;

lagrangian! {
    /// X, place of the particle; its height follows from the constraint.
    pub system MovingIncline {
        param m, b, a, om, g = 9.81;
        coord X;
        coord s = a * sin(om * t);
        let Y = b * (X - s);
        T = 0.5 * m * (dot(X).powi(2) + dot(Y).powi(2));
        V = m * g * Y;
        observe particle = [X, Y];
    }
}

golden!(MovingIncline<1>, "sec-11.2.1-moving-incline", |p| MovingIncline {
    m: p("m"),
    b: p("b"),
    a: p("A"),
    om: p("Om"),
    g: p("g")
});

/// Ẍ depends on time alone, so the end is known in closed form.
pub fn rows() -> Vec<Row> {
    let row = Row::of::<MovingIncline, 1>("separable, constant inertia, quadratic, linear", [-2.0..2.0]);
    let reference = &row.subject().reference;
    let end = reference.special("closed_form_end");
    let [time, place] = ["t", "X"].map(|name| number(&end[name]));
    let start = reference.trajectory().remove(0);

    // X(t) = X₀ + Ẋ₀ t + (b² (s − ṡ₀ t) − g b t²/2)/(1 + b²)
    let [b, a, om, g] = ["b", "A", "Om", "g"].map(|name| row.subject().reference.parameter(name));
    let slid = b * b * (a * (om * time).sin() - a * om * time) - 0.5 * g * b * time * time;
    let found = start.q[0] + start.qd[0] * time + slid / (1.0 + b * b);
    vec![row.number("closed form", found, place).motion(
        "X at the end",
        (&start.q, &start.qd),
        time,
        &[(0, place)],
    )]
}
