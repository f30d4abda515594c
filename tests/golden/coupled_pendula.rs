//! Two equal pendula coupled by a spring at the distance a below their pivots. Problem 11.34; reconstructed, since its
//! figure is missing: equal masses and lengths, and a spring that is stretched by the horizontal distance alone.

use super::harness::{Quantity, Row, State, list, number};
use lagrange_runtime::prelude::lagrangian;

lagrangian! {
    /// Angles from the downward vertical.
    pub system CoupledPendula {
        param m, l, a, k, g = 9.81;
        coord th1, th2;
        T = 0.5 * m * l.powi(2) * (dot(th1).powi(2) + dot(th2).powi(2));
        V = m * g * l * (2 - th1.cos() - th2.cos()) + 0.5 * k * (a * th1.sin() - a * th2.sin()).powi(2);
    }
}

golden!(CoupledPendula<2>, "prob-11.34-coupled-pendula", |p| CoupledPendula {
    m: p("m"),
    l: p("l"),
    a: p("a"),
    k: p("k"),
    g: p("g")
});

lagrangian! {
    /// In a Stokes medium that drags each bob, Problem 11.37.
    pub system DampedPendula {
        param m, l, a, k, c, g = 9.81;
        coord th1, th2;
        T = 0.5 * m * l.powi(2) * (dot(th1).powi(2) + dot(th2).powi(2));
        V = m * g * l * (2 - th1.cos() - th2.cos()) + 0.5 * k * (a * th1.sin() - a * th2.sin()).powi(2);
        D = 0.5 * c * ((l * dot(th1)).powi(2) + (l * dot(th2)).powi(2));
    }
}

golden!(DampedPendula<2>, "prob-11.37-coupled-pendula-stokes", |p| DampedPendula {
    m: p("m"),
    l: p("l"),
    a: p("a"),
    k: p("k"),
    c: p("c"),
    g: p("g")
});

/// In phase the spring idles, ω² = g/l; out of phase ω² = g/l + 2 k a²/(m l²). Both modes decay alike, by c/2m.
pub fn rows() -> Vec<Row> {
    let facts = "scleronomic, conservative, separable, constant inertia, quadratic";
    let free = Row::of::<CoupledPendula, 2>(facts, [-3.1..3.1, -3.1..3.1]);
    let reference = free.subject().reference.clone();
    let [slow, fast] = [0, 1].map(|k| number(&list(reference.special("frequencies"))[k]));
    let [g, l, a, k, m] = ["g", "l", "a", "k", "m"].map(|name| reference.parameter(name));
    let free = free.number("in phase", slow, (g / l).sqrt()).number(
        "out of phase",
        fast,
        (g / l + 2.0 * k * a * a / (m * l * l)).sqrt(),
    );

    // Beats in the linear theory: the modes share the start.
    let beats = reference.special("beats_linear");
    let [start, t, first, second] = ["theta1(0)", "t", "theta1", "theta2"].map(|name| number(&beats[name]));
    let modes = [slow, fast].map(|frequency| 0.5 * start * (frequency * t).cos());
    let free = free.within("θ₁ of the beats", modes[0] + modes[1], first, 1e-13 * start).within(
        "θ₂ of the beats",
        modes[0] - modes[1],
        second,
        1e-13 * start,
    );

    let damped =
        Row::of::<DampedPendula, 2>("scleronomic, constant inertia, quadratic", [-3.1..3.1, -3.1..3.1]);
    let reference = damped.subject().reference.clone();
    // M and C are proportional, C = 2δM.
    let rest = damped.subject().at("rest", &State::new(&[0.0, 0.0], &[0.0, 0.0], 0.0));
    let rate = -0.5 * rest.value(Quantity::JacobianQd)[0];
    let decay = number(reference.special("decay_rate"));
    let expected: Vec<f64> = list(reference.special("damped_frequencies")).iter().map(number).collect();
    let squares = reference.small().remove(0).numbers("omega2");
    let mut damped = damped;
    for (square, expected) in squares.iter().zip(expected) {
        damped = damped.number("damped frequency", (square - rate * rate).sqrt(), expected);
    }
    let damped = damped.special("decay rate", rate, decay);
    vec![free, damped]
}
