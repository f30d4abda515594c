//! Simple pendulum, in three writings: by its angle, by the Cartesian position of the bob, and by a Lagrangian given
//! whole. Example 11.2.

use crate::golden;
use crate::harness::{
    Reference, State, assert_balance, assert_facts, assert_number, check, check_equal, check_trajectory,
    number,
};
use crate::harness::{facts, random_states};
use lagrange_runtime::prelude::*;
use nalgebra::SVector;

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

#[test]
fn reference() {
    check::<SimplePendulum, 1>();
    check::<PendulumOfBob, 1>();
    check::<PendulumOfLagrangian, 1>();
}

#[test]
fn trajectory() {
    check_trajectory::<SimplePendulum, 1>();
    check_trajectory::<PendulumOfBob, 1>();
    check_trajectory::<PendulumOfLagrangian, 1>();
}

#[test]
fn writings_agree() {
    check_equal::<SimplePendulum, PendulumOfBob, 1>([-3.1..3.1]);
    check_equal::<SimplePendulum, PendulumOfLagrangian, 1>([-3.1..3.1]);
}

/// (11.36c): m l² θ̈ + m g l sin θ = 0.
#[test]
fn equation_of_motion() {
    let (m, l) = (1.3, 0.85);
    let pendulum = SimplePendulum::new(m, l);
    for State { q, qd, t } in random_states([-3.1..3.1]) {
        let acceleration = pendulum.accel(&q, &qd, t)[0];
        let weight = m * pendulum.g * l * q[0].sin();
        assert_balance("(11.36c)", &[m * l * l * acceleration, weight]);
    }
}

/// The tangent of the motion at the two equilibria: θ̈ = ∓(g/l) δθ.
#[test]
fn small_vibrations() {
    let reference = Reference::read("ex-11.2-simple-pendulum");
    let pendulum = SimplePendulum::new(reference.parameter("m"), reference.parameter("l"));
    let rest = SVector::from([0.0]);
    let hanging = pendulum.jacobian(&SVector::from([0.0]), &rest, 0.0).q[0];
    let standing = pendulum.jacobian(&SVector::from([std::f64::consts::PI]), &rest, 0.0).q[0];
    let frequency = number(&reference.special("small_frequency")["value"]);
    assert_number("hanging", -hanging, frequency * frequency);
    assert_number("standing", standing, frequency * frequency);
}

#[test]
fn facts_of_the_pendulum() {
    let holding = ["scleronomic", "conservative", "separable", "constant inertia", "quadratic"];
    assert_facts::<SimplePendulum, 1>(&holding, &[], &[&[0]]);
    assert_facts::<PendulumOfLagrangian, 1>(&holding, &[], &[&[0]]);
    assert_eq!(facts::<SimplePendulum, 1>().name, "SimplePendulum");
    assert_eq!(facts::<SimplePendulum, 1>().coordinates, ["theta"]);
}

/// sin² θ + cos² θ = 1 has to be found in T.
#[test]
fn facts_do_not_depend_on_the_writing() {
    let holding = ["scleronomic", "conservative", "separable", "constant inertia", "quadratic"];
    assert_facts::<PendulumOfBob, 1>(&holding, &[], &[&[0]]);
}

/// The facts are traits, too: this compiles.
#[test]
fn marker_traits() {
    fn splits(_: &(impl Separable<1> + ConstantInertia<1> + Conservative<1>)) {}
    splits(&SimplePendulum::new(1.3, 0.85));
}
