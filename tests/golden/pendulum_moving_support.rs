//! Pendulum whose support is driven horizontally, the drive being the user's own function of time. Problem 11.10; a
//! stand-in, since the problem refers to an example of another chapter.

use super::harness::{Row, State, Subject, list, number, required};
use lagrange_runtime::Scalar;
use lagrange_runtime::prelude::lagrangian;

/// Position of the support.
fn drive<S: Scalar>(t: S, a: S, om: S) -> S {
    a * (om * t).sin()
}

lagrangian! {
    /// θ from the downward vertical.
    pub system PendulumOnDrive {
        param m, l, a, om, g = 9.81;
        coord theta;
        extern fn drive(t, a, om);
        coord support = drive(t, a, om);
        let x = support + l * theta.sin();
        let y = -l * theta.cos();
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
        V = m * g * y;
        observe bob = [x, y];
    }
}

golden!(PendulumOnDrive<1>, "prob-11.10-pendulum-moving-support", |p| PendulumOnDrive {
    m: p("m"),
    l: p("l"),
    a: p("A"),
    om: p("Om"),
    g: p("g")
}, with an extern fn);

lagrangian! {
    /// With the length free, to find the force in the string.
    pub system FreeBobOnDrive {
        param m, a, om, g = 9.81;
        coord theta, l;
        coord support = a * sin(om * t);
        let x = support + l * theta.sin();
        let y = -l * theta.cos();
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
        V = m * g * y;
    }
}

golden!(FreeBobOnDrive<2>, "prob-11.10-pendulum-moving-support", |p| FreeBobOnDrive {
    m: p("m"),
    a: p("A"),
    om: p("Om"),
    g: p("g")
});

/// θ̈ = a(θ, t), although p = m l² θ̇ + m l ẋₛ cos θ depends on θ. The force −Q_l keeps the length, which is what the
/// string does.
pub fn rows() -> Vec<Row> {
    let mut row = Row::of::<PendulumOnDrive, 1>("separable, constant inertia, quadratic", [-3.1..3.1]);
    let relaxed = Subject::of::<FreeBobOnDrive, 2>();
    let length = row.subject().reference.parameter("l");
    let force = row.subject().reference.special("constraining_force").clone();
    for case in list(&force["cases"]) {
        let [t, theta, rate, tension] = ["t", "theta", "thetadot", "tension"].map(|name| number(&case[name]));
        let bend = row.subject().accelerations(&State::new(&[theta], &[rate], t))[0];
        let state = State::new(&[theta, length], &[rate, 0.0], t);
        row = row.reaction("tension", &relaxed, (&state, &[bend, 0.0]), 1, -tension).show(
            "tension",
            -required(&relaxed, &state, &[bend, 0.0])[1].0,
            tension,
        );
    }
    vec![row]
}
