//! Bodies that are struck. An impulse changes the momenta by its generalized impulse, p⁺ − p⁻ = Q̂ (11.58), at a fixed
//! configuration; the velocities follow from the momenta. Example 11.8, Problems 11.16 and 11.29.

use super::harness::{Quantity, Row, State, list, number};
use lagrange_runtime::prelude::lagrangian;

lagrangian! {
    /// Two particles on a light rod of length l: centre and angle from the downward direction. Example 11.8.
    pub system Dumbbell {
        param m, l;
        coord x, y, theta;
        let x1 = x + 0.5 * l * theta.sin();
        let y1 = y - 0.5 * l * theta.cos();
        let x2 = x - 0.5 * l * theta.sin();
        let y2 = y + 0.5 * l * theta.cos();
        T = 0.5 * m * (dot(x1).powi(2) + dot(y1).powi(2) + dot(x2).powi(2) + dot(y2).powi(2));
        V = 0;
        observe struck = [x1, y1];
    }
}

golden!(Dumbbell<3>, "ex-11.8-impulse-dumbbell", |p| Dumbbell { m: p("m"), l: p("l") });

lagrangian! {
    /// A free rod of length 2l on a smooth plane. Problem 11.16.
    pub system FreeRod {
        param m, l;
        coord x, y, theta;
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2)) + 0.5 * (m * l.powi(2) / 3) * dot(theta).powi(2);
        V = 0;
    }
}

golden!(FreeRod<3>, "prob-11.16-rod-brought-to-rest", |p| FreeRod { m: p("m"), l: p("l") });

lagrangian! {
    /// Two equal rods of length 2l, hinged at x, y; th1 and th2 from the direction of −y and y. Problem 11.29.
    pub system HingedRods {
        param m, l;
        coord x, y, th1, th2;
        let x1 = x + l * th1.sin();
        let y1 = y - l * th1.cos();
        let x2 = x - l * th2.sin();
        let y2 = y + l * th2.cos();
        T = 0.5 * m * (dot(x1).powi(2) + dot(y1).powi(2) + dot(x2).powi(2) + dot(y2).powi(2))
            + 0.5 * (m * l.powi(2) / 3) * (dot(th1).powi(2) + dot(th2).powi(2));
        V = 0;
    }
}

golden!(HingedRods<4>, "prob-11.29-two-hinged-rods-impulse", |p| HingedRods { m: p("m"), l: p("l") });

pub fn rows() -> Vec<Row> {
    vec![dumbbell(), rod(), hinged_rods()]
}

/// Afterwards it moves uniformly. By hand: ẋ = P/2m, θ̇ = P/(m l), ΔT = P²/2m.
fn dumbbell() -> Row {
    let row = struck(Row::of::<Dumbbell, 3>(
        "scleronomic, conservative, separable, constant inertia, quadratic, linear, ignorable x y theta, blocks x | y | theta",
        [-2.0..2.0, -2.0..2.0, -3.0..3.0],
    ));
    let reference = row.subject().reference.clone();
    let after = reference.special("afterwards");
    let blow = number(&reference.special("impulse")["P"]);
    let [m, l] = ["m", "l"].map(|name| reference.parameter(name));
    row.number("P/2m", number(&after["v_star"]), 0.5 * blow / m).number(
        "P/(m l)",
        number(&after["omega"]),
        blow / (m * l),
    )
}

/// The impulse that stops the point at the distance b from the centre: what its velocity is per unit of impulse, solved
/// for the impulse.
fn rod() -> Row {
    let row = struck(Row::of::<FreeRod, 3>(
        "scleronomic, conservative, separable, constant inertia, quadratic, linear, ignorable x y theta, blocks x | y | theta",
        [-2.0..2.0, -2.0..2.0, -3.0..3.0],
    ));
    let impulse = row.subject().reference.special("impulse").clone();
    let before = numbers(&impulse["qd_before"]);
    let b = number(&impulse["b"]);
    let point = row.subject().at("", &State::new(&numbers(&impulse["q"]), &before, 0.0));
    // At θ = 0 the point moves with (ẋ, ẏ + b θ̇), and an impulse on it is (P_x, P_y, b P_y).
    let gained = |blow: [f64; 2]| {
        let qd = point.moving(&[blow[0], blow[1], b * blow[1]]).value(Quantity::Velocities);
        [qd[0], qd[1] + b * qd[2]]
    };
    let (along, across) =
        (-before[0] / gained([1.0, 0.0])[0], -(before[1] + b * before[2]) / gained([0.0, 1.0])[1]);
    let expected = numbers(&impulse["P"]);
    row.number("P_x", along, expected[0]).special("P_y", across, expected[1])
}

/// By hand: ẋ = −P/m, θ̇₁ = 9P/(4 m l), θ̇₂ = −3P/(4 m l), ΔT = 7P²/(4m).
fn hinged_rods() -> Row {
    let ranges = [-2.0..2.0, -2.0..2.0, -1.2..1.2, -1.2..1.2];
    let row = struck(Row::of::<HingedRods, 4>("scleronomic, conservative, quadratic, ignorable x y", ranges));
    let reference = &row.subject().reference;
    let blow = number(&reference.special("impulse")["P"]);
    let gain = number(&reference.special("impulse")["dT"]);
    let m = reference.parameter("m");
    row.number("7P²/(4m)", gain, 1.75 * blow * blow / m)
}

/// The velocities after the blow, and the gain of kinetic energy.
fn struck(mut row: Row) -> Row {
    let impulse = row.subject().reference.special("impulse").clone();
    let [q, before, blow, after] =
        ["q", "qd_before", "Q_hat", "qd_after"].map(|name| numbers(&impulse[name]));
    let point = row.subject().at("", &State::new(&q, &before, 0.0));
    let momenta: Vec<f64> =
        point.value(Quantity::Momenta).iter().zip(&blow).map(|(momentum, blow)| momentum + blow).collect();
    let velocities = point.moving(&momenta).value(Quantity::Velocities);
    let (kinetic, gained) =
        (point.number(Quantity::Kinetic), point.moving(&velocities).number(Quantity::Kinetic));
    let expected = number(&impulse["dT"]);
    let largest = after.iter().fold(0.0f64, |largest, speed| largest.max(speed.abs()));
    for (velocity, after) in velocities.iter().zip(&after) {
        row = row.within("velocity after the blow", *velocity, *after, 1e-13 * largest);
    }
    row.within("ΔT", gained - kinetic, expected, 1e-13 * (gained + kinetic)).show(
        "ΔT",
        gained - kinetic,
        expected,
    )
}

fn numbers(value: &serde_json::Value) -> Vec<f64> {
    list(value).iter().map(number).collect()
}
