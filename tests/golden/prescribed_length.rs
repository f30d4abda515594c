//! Pendulum whose length is a given function of time. Problem 11.4, which can be read in two ways: with the force on
//! the string given it has two degrees of freedom, with the length given, as here, one. The history is a choice.

use super::harness::{Row, State, Subject, list, number, required, with_reference};
use lagrange_runtime::Scalar;
use lagrange_runtime::prelude::{SVector, lagrangian};

lagrangian! {
    /// The pendulum by its length as a prescribed coordinate.
    pub system PrescribedLength {
        param m, l0, l1, om, g = 9.81;
        coord theta;
        coord l = l0 + l1 * sin(om * t);
        T = 0.5 * m * (dot(l).powi(2) + (l * dot(theta)).powi(2));
        V = -m * g * l * cos(theta);
        observe pull = reaction(l);
    }
}

golden!(PrescribedLength<1>, "prob-11.4-prescribed-length", |p| PrescribedLength {
    m: p("m"),
    l0: p("l0"),
    l1: p("l1"),
    om: p("Om"),
    g: p("g")
});

lagrangian! {
    /// The pendulum by the position of the bob, the length being a function of the system.
    pub system BobOnAVaryingString {
        param m, l0, l1, om, g = 9.81;
        coord theta;
        fn length(s) = l0 + l1 * (om * s).sin();
        let x = length(t) * theta.sin();
        let y = -length(t) * theta.cos();
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
        V = m * g * y;
        observe bob = [x, y];
    }
}

golden!(BobOnAVaryingString<1>, "prob-11.4-prescribed-length", |p| BobOnAVaryingString {
    m: p("m"),
    l0: p("l0"),
    l1: p("l1"),
    om: p("Om"),
    g: p("g")
});

/// The pull on the string.
fn pull<S: Scalar>(t: S, p0: S, p1: S, om: S) -> S {
    p0 + p1 * (om * t).cos()
}

lagrangian! {
    /// The other reading: the string is pulled through the hole by a given force.
    pub system StringThroughHole {
        param m, P0, P1, om, g = 9.81;
        coord l, theta;
        extern fn pull(t, p0, p1, om);
        let x = l * theta.sin();
        let y = -l * theta.cos();
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
        V = m * g * y;
        Q[l] = -pull(t, P0, P1, om);
        observe bob = [x, y];
    }
}

golden!(StringThroughHole<2>, "prob-11.4-string-through-hole", |p| StringThroughHole {
    m: p("m"),
    P0: p("P0"),
    P1: p("P1"),
    om: p("Om"),
    g: p("g")
}, with an extern fn);

pub fn rows() -> Vec<Row> {
    vec![given_length(), given_force()]
}

/// M = m l(t)² does not depend on the state, but it is not constant. With the length free, the force that keeps it as
/// given is the pull P = m (l θ̇² + g cos θ − l̈).
fn given_length() -> Row {
    let mut row =
        Row::of::<PrescribedLength, 1>("quadratic", [-3.1..3.1]).also::<BobOnAVaryingString, 1>("quadratic");
    let reference = row.subject().reference.clone();
    let [l0, l1, om] = ["l0", "l1", "Om"].map(|name| reference.parameter(name));
    let relaxed = Subject::of::<StringThroughHole, 2>().with(&[("P0", 0.0), ("P1", 0.0)]);
    for case in list(&reference.special("string_force")["cases"]) {
        let [t, theta, rate, force] = ["t", "theta", "thetadot", "P"].map(|name| number(&case[name]));
        let (sin, cos) = (om * t).sin_cos();
        let bend = row.subject().accelerations(&State::new(&[theta], &[rate], t))[0];
        let emitted =
            with_reference::<PrescribedLength, 1>().pull(&SVector::from([theta]), &SVector::from([rate]), t);
        row = row.number("emitted pull", emitted, -force);
        let state = State::new(&[l0 + l1 * sin, theta], &[l1 * om * cos, rate], t);
        let accelerations = [-l1 * om * om * sin, bend];
        row = row.reaction("P", &relaxed, (&state, &accelerations), 0, -force).show(
            "P",
            -required(&relaxed, &state, &accelerations)[0].0,
            force,
        );
    }
    row
}

/// The moment of momentum about the hole changes by the moment of the weight alone, whatever the pull.
fn given_force() -> Row {
    let row = Row::of::<StringThroughHole, 2>("scleronomic, quadratic", [0.5..2.0, -3.0..3.0]);
    let subject = row.subject().clone();
    let [m, g] = ["m", "g"].map(|name| subject.reference.parameter(name));
    row.balances("moment of momentum", |at| {
        let a = subject.accelerations(at);
        let (l, theta) = (at.q[0], at.q[1]);
        vec![m * l * l * a[1], 2.0 * m * l * at.qd[0] * at.qd[1], m * g * l * theta.sin()]
    })
}
