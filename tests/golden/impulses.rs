//! Bodies that are struck. An impulse changes the momenta by its generalized impulse, p⁺ − p⁻ = Q̂ (11.58), at a fixed
//! configuration; the velocities follow from the momenta. Example 11.8, Problems 11.16 and 11.29.

use super::harness::{Row, list, number, with_reference};
use lagrange_runtime::prelude::{Impulsive, SVector, State, lagrangian};

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
        impulse blow at [x1, y1];
    }
}

golden!(Dumbbell<3>, "ex-11.8-impulse-dumbbell", |p| Dumbbell { m: p("m"), l: p("l") });

lagrangian! {
    /// A free rod of length 2l on a smooth plane, struck at the distance b from its centre. Problem 11.16.
    pub system FreeRod {
        param m, l, b;
        coord x, y, theta;
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2)) + 0.5 * (m * l.powi(2) / 3) * dot(theta).powi(2);
        V = 0;
        impulse blow at [x + b * theta.cos(), y + b * theta.sin()];
    }
}

// Where it is struck has no part in its motion.
golden!(FreeRod<3>, "prob-11.16-rod-brought-to-rest", |p| FreeRod { m: p("m"), l: p("l"), b: S::zero() });

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
        impulse blow at [x + 2 * l * th1.sin(), y - 2 * l * th1.cos()];
    }
}

golden!(HingedRods<4>, "prob-11.29-two-hinged-rods-impulse", |p| HingedRods { m: p("m"), l: p("l") });

pub fn rows() -> Vec<Row> {
    vec![dumbbell(), rod(), hinged_rods()]
}

/// Afterwards it moves uniformly. By hand: ẋ = P/2m, θ̇ = P/(m l), ΔT = P²/2m.
fn dumbbell() -> Row {
    let facts = "scleronomic, conservative, separable, constant inertia, quadratic, linear, ignorable x y theta, blocks x | y | theta";
    let row = Row::of::<Dumbbell, 3>(facts, [-2.0..2.0, -2.0..2.0, -3.0..3.0]);
    let system = with_reference::<Dumbbell, 3>();
    let reference = row.subject().reference.clone();
    let after = reference.special("afterwards");
    let blow = number(&reference.special("impulse")["P"]);
    struck(row, &system, |q| system.blow(q, 0.0, &SVector::from([blow, 0.0])))
        .number("P/2m", number(&after["v_star"]), 0.5 * blow / system.m)
        .number("P/(m l)", number(&after["omega"]), blow / (system.m * system.l))
}

/// The impulse that stops a point: what the velocity of the point gains per unit of impulse, solved for the impulse.
fn rod() -> Row {
    let facts = "scleronomic, conservative, separable, constant inertia, quadratic, linear, ignorable x y theta, blocks x | y | theta";
    let row = Row::of::<FreeRod, 3>(facts, [-2.0..2.0, -2.0..2.0, -3.0..3.0]);
    let impulse = row.subject().reference.special("impulse").clone();
    let expected = vector::<2>(&impulse["P"]);
    let system = FreeRod { b: number(&impulse["b"]), ..with_reference::<FreeRod, 3>() };
    // At θ = 0 the point moves with (ẋ, ẏ + b θ̇).
    let point = |qd: &SVector<f64, 3>| [qd[0], qd[1] + system.b * qd[2]];
    let rest = State { t: 0.0, q: vector(&impulse["q"]), qd: SVector::from([0.0; 3]) };
    let gained = |blow| point(&system.jump(&rest, &system.blow(&rest.q, 0.0, &SVector::from(blow))).after.qd);
    let before = point(&vector(&impulse["qd_before"]));
    let (along, across) = (-before[0] / gained([1.0, 0.0])[0], -before[1] / gained([0.0, 1.0])[1]);
    struck(row, &system, |q| system.blow(q, 0.0, &expected)).number("P_x", along, expected[0]).special(
        "P_y",
        across,
        expected[1],
    )
}

/// Jumps by hand: ẋ = −P/m, θ̇₁ = 9P/(4 m l), θ̇₂ = −3P/(4 m l), ΔT = 7P²/(4m).
fn hinged_rods() -> Row {
    let ranges = [-2.0..2.0, -2.0..2.0, -1.2..1.2, -1.2..1.2];
    let row = Row::of::<HingedRods, 4>("scleronomic, conservative, quadratic, ignorable x y", ranges);
    let system = with_reference::<HingedRods, 4>();
    let reference = row.subject().reference.clone();
    let blow = number(&reference.special("impulse")["P"]);
    let gain = number(&reference.special("impulse")["dT"]);
    struck(row, &system, |q| system.blow(q, 0.0, &SVector::from([blow, 0.0]))).number(
        "7P²/(4m)",
        gain,
        1.75 * blow * blow / system.m,
    )
}

/// The generalized impulse, the velocities after the blow, and the gain of kinetic energy.
fn struck<Sys: Impulsive<N, Scalar = f64>, const N: usize>(
    mut row: Row,
    system: &Sys,
    blow: impl Fn(&SVector<f64, N>) -> SVector<f64, N>,
) -> Row {
    let impulse = row.subject().reference.special("impulse").clone();
    let before = State { t: 0.0, q: vector(&impulse["q"]), qd: vector(&impulse["qd_before"]) };
    let blow = blow(&before.q);
    let jump = system.jump(&before, &blow);
    let [expected, after]: [SVector<f64, N>; 2] = ["Q_hat", "qd_after"].map(|name| vector(&impulse[name]));
    for k in 0..N {
        row = row.within("Q̂", blow[k], expected[k], 1e-15 * expected.amax()).within(
            "velocity after the blow",
            jump.after.qd[k],
            after[k],
            1e-14 * after.amax(),
        );
    }
    // The energy of the blow is a sum of products of impulses and mean velocities.
    let size = expected.amax() * (before.qd.amax() + after.amax());
    let gain = number(&impulse["dT"]);
    row.within("ΔT", jump.energy, gain, 1e-14 * size).show("ΔT", jump.energy, gain)
}

fn vector<const N: usize>(value: &serde_json::Value) -> SVector<f64, N> {
    SVector::from_iterator(list(value).iter().map(number))
}
