//! Rod whose ends slide on a smooth circle in a vertical plane, over a chord of 120°; and the same in a hoop that turns
//! about its vertical diameter. Problems 11.21 and 11.22.

use super::harness::{Quantity, Row, State, Subject, list, number, with_reference};
use lagrange_runtime::prelude::{SVector, lagrangian};

lagrangian! {
    /// θ, angle of the centre of the rod from the downward vertical; it is r/2 from the centre of the circle.
    pub system RodInCircle {
        param m, r, g = 9.81;
        coord theta;
        let x = 0.5 * r * theta.sin();
        let y = -0.5 * r * theta.cos();
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2)) + 0.5 * (m * r.powi(2) / 4) * dot(theta).powi(2);
        V = m * g * y;
    }
}

golden!(RodInCircle<1>, "prob-11.21-rod-in-circle", |p| RodInCircle { m: p("m"), r: p("r"), g: p("g") });

lagrangian! {
    /// The hoop turns as Ωt. The rod has the moment of inertia m r²/4 about its centre, across its direction.
    pub system RodInHoop {
        param m, r, om, g = 9.81;
        coord theta;
        coord phi = om * t;
        let rho = 0.5 * r * theta.sin();
        let x = rho * phi.cos();
        let y = rho * phi.sin();
        let z = -0.5 * r * theta.cos();
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2))
            + 0.5 * (m * r.powi(2) / 4) * (dot(theta).powi(2) + (dot(phi) * theta.cos()).powi(2));
        V = m * g * z;
        observe torque = reaction(phi);
    }
}

golden!(RodInHoop<1>, "prob-11.22-rod-in-rotating-hoop", |p| RodInHoop {
    m: p("m"),
    r: p("r"),
    om: p("Om"),
    g: p("g")
});

lagrangian! {
    /// The rod free of the circle: its centre at ρ and θ in the plane of the hoop, which is at φ, and at w across it;
    /// its own angle ψ.
    pub system FreeRodInHoop {
        param m, r, g = 9.81;
        coord rho, theta, psi, phi, w;
        let u = rho * theta.sin();
        let x = u * phi.cos() - w * phi.sin();
        let y = u * phi.sin() + w * phi.cos();
        let z = -rho * theta.cos();
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2))
            + 0.5 * (m * r.powi(2) / 4) * (dot(psi).powi(2) + (dot(phi) * psi.cos()).powi(2));
        V = m * g * z;
    }
}

golden!(FreeRodInHoop<5>, "prob-11.22-rod-in-rotating-hoop", |p| FreeRodInHoop {
    m: p("m"),
    r: p("r"),
    g: p("g")
});

pub fn rows() -> Vec<Row> {
    vec![circle(), hoop()]
}

/// The forces on the ends point to the centre of the circle. N₁ at the leading end, N₂ at the trailing one, at ±60°
/// from the radius of the centre of the rod: `−Q_ρ = (N₁ + N₂) cos 60°`, and their moment about the centre of the
/// rod, which lies r/2 from that of the circle, is `Q_ψ = (N₁ − N₂) (r/2) sin 60°` against θ. The forces have no
/// moment about the centre of the circle.
fn circle() -> Row {
    let mut row = Row::of::<RodInCircle, 1>(
        "scleronomic, conservative, separable, constant inertia, quadratic",
        [-3.0..3.0],
    );
    let reference = row.subject().reference.clone();
    let r = reference.parameter("r");
    for case in list(reference.special("period")) {
        row = row.period("period", &[number(&case["theta0"])], 0, number(&case["tau"]));
    }
    let small = row.subject().at("", &State::new(&[0.0], &[0.0], 0.0)).value(Quantity::JacobianQ)[0];
    let equivalent = number(reference.special("equivalent_pendulum_length"));
    row = row.number("equivalent pendulum", -reference.parameter("g") / small, equivalent);
    let mass = reference.parameter("m");
    let free =
        Subject::of::<FreeRodInHoop, 5>().with(&[("m", mass), ("r", r), ("g", reference.parameter("g"))]);
    for case in list(reference.special("contact_forces")) {
        let [theta, square, sum, difference] =
            ["theta", "thetadot2", "N_sum", "N_trailing_minus_leading"].map(|name| number(&case[name]));
        let rate = square.sqrt();
        let bend = row.subject().accelerations(&State::new(&[theta], &[rate], 0.0))[0];
        let state = State::new(&[0.5 * r, theta, theta, 0.0, 0.0], &[0.0, rate, rate, 0.0, 0.0], 0.0);
        let accelerations = [0.0, bend, bend, 0.0, 0.0];
        let moment = 0.25 * 3.0f64.sqrt() * r * difference;
        row = row
            .reaction("N₁ + N₂", &free, (&state, &accelerations), 0, -0.5 * sum)
            .reaction("N₂ − N₁", &free, (&state, &accelerations), 2, -moment)
            .reaction("moment about the centre", &free, (&state, &accelerations), 1, moment);
    }
    row
}

/// The moment of inertia of the rod about the axis is m r²/4 at every angle, so Ω drops out and no torque is needed.
/// Forces in the plane as above; those across it, Y₁ + Y₂, accelerate the centre of the rod, and turn the hoop at their
/// arms r sin(θ ± 60°).
fn hoop() -> Row {
    let mut row =
        Row::of::<RodInHoop, 1>("conservative, separable, constant inertia, quadratic", [-3.0..3.0]);
    let reference = row.subject().reference.clone();
    let [r, om] = ["r", "Om"].map(|name| reference.parameter(name));
    let free = Subject::of::<FreeRodInHoop, 5>();
    for case in list(reference.special("bearing_reactions")) {
        let [theta, rate, sum, difference] =
            ["theta", "thetadot", "inplane_sum", "inplane_trailing_minus_leading"]
                .map(|name| number(&case[name]));
        let [across, unequal] =
            ["lateral_sum", "lateral_trailing_minus_leading"].map(|name| number(&case[name]));
        let bend = row.subject().accelerations(&State::new(&[theta], &[rate], 0.0))[0];
        let state = State::new(&[0.5 * r, theta, theta, 0.0, 0.0], &[0.0, rate, rate, om, 0.0], 0.0);
        let accelerations = [0.0, bend, bend, 0.0, 0.0];
        let emitted =
            with_reference::<RodInHoop, 1>().torque(&SVector::from([theta]), &SVector::from([rate]), 0.0);
        let torque = number(reference.special("driving_torque"));
        row = row.within("emitted torque", emitted, torque, 1e-13 * om * rate.abs());
        let about_axis = free.at("", &state).inertia()[(3, 3)];
        row = row.number("I about the axis", about_axis, number(reference.special("I_zz")));
        let (sin, cos) = theta.sin_cos();
        let moment = 0.25 * 3.0f64.sqrt() * r * difference;
        let turning = 0.5 * r * (sin * across - 3.0f64.sqrt() * cos * unequal);
        row = row
            .reaction("in the plane, sum", &free, (&state, &accelerations), 0, -0.5 * sum)
            .reaction("in the plane, difference", &free, (&state, &accelerations), 2, -moment)
            .reaction("across the plane, sum", &free, (&state, &accelerations), 4, across)
            // Ω dI/dt, where the parts of I that change cancel.
            .reaction_of_terms(
                "torque on the hoop",
                &free,
                (&state, &accelerations),
                3,
                torque,
                about_axis * (om * rate).abs(),
            )
            .within(
                "moment of the forces across",
                turning,
                torque,
                1e-13 * r * (across.abs() + unequal.abs()),
            );
    }
    row
}
