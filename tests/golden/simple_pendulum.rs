//! Simple pendulum, in three writings: by its angle, by the Cartesian position of the bob, and by a Lagrangian given
//! whole. Example 11.2.

use super::harness::{Row, State, Subject, list, number, with_reference};
use lagrange_runtime::Lagrangian;
use lagrange_runtime::prelude::{SVector, lagrangian};
use lagrange_runtime::traits::{Conservative, ConstantInertia, Separable};

lagrangian! {
    /// A mass on a light rod, by its angle from the downward vertical.
    pub system SimplePendulum {
        param m, l, g = 9.81;
        coord theta;
        T = 0.5 * m * (l * dot(theta)).powi(2);
        V = m * g * l * (1 - cos(theta));
    }
}

golden!(SimplePendulum<1>, "ex-11.2-simple-pendulum", |p| SimplePendulum { m: p("m"), l: p("l"), g: p("g") });

lagrangian! {
    /// The same, by the position of the bob below its support.
    pub system PendulumOfBob {
        param m, l, g = 9.81;
        coord theta;
        let x = l * theta.sin();
        let y = -l * theta.cos();
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
        V = m * g * (y + l);
        observe bob = [x, y];
    }
}

golden!(PendulumOfBob<1>, "ex-11.2-simple-pendulum", |p| PendulumOfBob { m: p("m"), l: p("l"), g: p("g") });

lagrangian! {
    /// The same, by its Lagrangian.
    pub system PendulumOfLagrangian {
        param m, l, g = 9.81;
        coord theta;
        L = 0.5 * m * l.powi(2) * dot(theta).powi(2) - m * g * l * (1.0 - theta.cos());
    }
}

golden!(
    PendulumOfLagrangian<1>,
    "ex-11.2-simple-pendulum",
    |p| PendulumOfLagrangian { m: p("m"), l: p("l"), g: p("g") },
    given L
);

lagrangian! {
    /// With the length free, to find the tension.
    pub system FreeBob {
        param m, g = 9.81;
        coord theta, r;
        T = 0.5 * m * (dot(r).powi(2) + (r * dot(theta)).powi(2));
        V = -m * g * r * cos(theta);
    }
}

golden!(FreeBob<2>, "ex-11.2-simple-pendulum", |p| FreeBob { m: p("m"), g: p("g") });

lagrangian! {
    /// Small oscillations, Section 11.13.1.
    pub system SmallPendulum {
        param m, l, g = 9.81;
        coord theta;
        T = 0.5 * m * (l * dot(theta)).powi(2);
        V = 0.5 * m * g * l * theta.powi(2);
    }
}

golden!(SmallPendulum<1>, "sec-11.13.1-small-pendulum", |p| SmallPendulum {
    m: p("m"),
    l: p("l"),
    g: p("g")
});

pub fn rows() -> Vec<Row> {
    vec![finite(), small()]
}

/// sin² θ + cos² θ = 1 has to be found in the T of the bob.
fn finite() -> Row {
    let facts = "scleronomic, conservative, separable, constant inertia, quadratic";
    let row = Row::of::<SimplePendulum, 1>(facts, [-3.1..3.1])
        .also::<PendulumOfBob, 1>(facts)
        .also::<PendulumOfLagrangian, 1>(facts);
    let reference = row.subject().reference.clone();
    let length = reference.parameter("l");

    let elliptic = reference.special("elliptic_solution");
    let [theta, time, end] = ["theta0", "t", "theta"].map(|name| number(&elliptic[name]));
    let mut row = row.motion("elliptic solution", (&[theta], &[0.0]), time, &[(0, end)]);
    for case in list(reference.special("periods")) {
        row = row.period("period", &[number(&case["theta0"])], 0, number(&case["tau"]));
    }

    // Let go at θ₀, m l θ̇² = 2 m g (cos θ − cos θ₀); the force −Q_r keeps the length.
    let relaxed = Subject::of::<FreeBob, 2>();
    let g = reference.parameter("g");
    for case in list(reference.special("tension")) {
        let [start, theta] = ["theta0", "theta"].map(|name| number(&case[name]));
        let rate = (2.0 * g / length * (theta.cos() - start.cos())).sqrt();
        let bend = row.subject().accelerations(&State::new(&[theta], &[rate], 0.0))[0];
        let state = State::new(&[theta, length], &[rate, 0.0], 0.0);
        row = row.reaction("tension", &relaxed, (&state, &[bend, 0.0]), 1, -number(&case["tension"]));
    }

    // The facts are traits, too: this compiles.
    fn splits(_: &(impl Separable<1> + ConstantInertia<1> + Conservative<1>)) {}
    splits(&with_reference::<SimplePendulum, 1>());
    row
}

/// Small oscillations of the finite pendulum: the same M and K.
fn small() -> Row {
    let facts = "scleronomic, conservative, separable, constant inertia, quadratic, linear";
    let row = Row::of::<SmallPendulum, 1>(facts, [-2.0..2.0]);
    let (small, finite) = (with_reference::<SmallPendulum, 1>(), with_reference::<SimplePendulum, 1>());
    let rest = SVector::from([0.0]);
    row.number("M", small.inertia(&rest, &rest, 0.0)[0], finite.inertia(&rest, &rest, 0.0)[0]).number(
        "K/M",
        small.jacobian(&rest, &rest, 0.0).q[0],
        finite.jacobian(&rest, &rest, 0.0).q[0],
    )
}
