//! Bodies that roll without slip, so that their rolling constraint can be integrated: cylinder in a trough, segment
//! and hoop that rock, nonhomogeneous cylinder, pulley on a belt. Problems 11.19, 11.20, 11.23, 11.24 and 11.25. The
//! trough, the pulley and the fixing of the rod in the hoop are stand-ins, the reference line of the nonhomogeneous
//! cylinder is reconstructed.

use super::harness::{Row, State, Subject, list, number};
use lagrange_runtime::prelude::lagrangian;

lagrangian! {
    /// Uniform cylinder of radius a in a trough of radius R; θ, angle of the line of centres from the downward
    /// vertical. Problem 11.19.
    pub system CylinderInTrough {
        param m, a, R, g = 9.81;
        coord theta;
        let x = (R - a) * theta.sin();
        let y = -(R - a) * theta.cos();
        let turn = (R - a) / a * theta;
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2)) + 0.5 * (0.5 * m * a.powi(2)) * dot(turn).powi(2);
        V = m * g * y;
    }
}

golden!(CylinderInTrough<1>, "prob-11.19-cylinder-in-trough", |p| CylinderInTrough {
    m: p("m"),
    a: p("a"),
    R: p("R"),
    g: p("g")
});

lagrangian! {
    /// Segment of a cylinder of radius R whose centre of mass lies at r from the axis of the cylinder; θ, tilt.
    /// Problem 11.20.
    pub system RockingSegment {
        param m, R, r, IC, g = 9.81;
        coord theta;
        let x = R * theta - r * theta.sin();
        let y = R - r * theta.cos();
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2)) + 0.5 * IC * dot(theta).powi(2);
        V = m * g * (y - R);
        observe centre = [x, y];
    }
}

golden!(RockingSegment<1>, "prob-11.20-rocking-segment", |p| RockingSegment {
    m: p("m"),
    R: p("R"),
    r: p("r"),
    IC: p("IC"),
    g: p("g")
});

lagrangian! {
    /// Cylinder whose centre of mass lies at a from its axis, beside it at θ = 0. Problem 11.23.
    pub system EccentricCylinder {
        param m, R, a, IC, g = 9.81;
        coord theta;
        let x = R * theta + a * theta.cos();
        let y = -a * theta.sin();
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2)) + 0.5 * IC * dot(theta).powi(2);
        V = m * g * y;
    }
}

golden!(EccentricCylinder<1>, "prob-11.23-eccentric-cylinder", |p| EccentricCylinder {
    m: p("m"),
    R: p("R"),
    a: p("a"),
    IC: p("IC"),
    g: p("g")
});

lagrangian! {
    /// The same with its axis free to move to (X, Y), to find the forces of the floor.
    pub system LiftedCylinder {
        param m, a, IC, g = 9.81;
        coord theta, X, Y;
        let x = X + a * theta.cos();
        let y = Y - a * theta.sin();
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2)) + 0.5 * IC * dot(theta).powi(2);
        V = m * g * y;
    }
}

golden!(LiftedCylinder<3>, "prob-11.23-eccentric-cylinder", |p| LiftedCylinder {
    m: p("m"),
    a: p("a"),
    IC: p("IC"),
    g: p("g")
});

lagrangian! {
    /// Thin hoop with a thin rod of the same mass along a radius. Problem 11.25.
    pub system HoopWithRod {
        param m, r, g = 9.81;
        coord theta;
        let x = r * theta;
        let u = x - 0.5 * r * theta.sin();
        let v = r - 0.5 * r * theta.cos();
        T = 0.5 * m * dot(x).powi(2)
            + 0.5 * m * (r * dot(theta)).powi(2)
            + 0.5 * m * (dot(u).powi(2) + dot(v).powi(2))
            + 0.5 * (m * r.powi(2) / 12) * dot(theta).powi(2);
        V = m * g * (v - r);
    }
}

golden!(HoopWithRod<1>, "prob-11.25-hoop-with-rod", |p| HoopWithRod { m: p("m"), r: p("r"), g: p("g") });

lagrangian! {
    /// Uniform disk in the loop of a belt, one end of which is fixed and the other held by a spring. Problem 11.24.
    pub system PulleyOnBelt {
        param m, a, k;
        coord x;
        let turn = x / a;
        let stretch = 2 * x;
        T = 0.5 * m * dot(x).powi(2) + 0.5 * (0.5 * m * a.powi(2)) * dot(turn).powi(2);
        V = 0.5 * k * stretch.powi(2);
    }
}

golden!(PulleyOnBelt<1>, "prob-11.24-spring-pulley", |p| PulleyOnBelt { m: p("m"), a: p("a"), k: p("k") });

pub fn rows() -> Vec<Row> {
    vec![
        with_frequency(
            Row::of::<CylinderInTrough, 1>(
                "scleronomic, conservative, separable, constant inertia, quadratic",
                [-3.0..3.0],
            ),
            "frequency",
        ),
        rocking(
            Row::of::<RockingSegment, 1>("scleronomic, conservative, quadratic", [-1.5..1.5]),
            "small_frequency",
        ),
        eccentric(),
        with_frequency(
            Row::of::<PulleyOnBelt, 1>(
                "scleronomic, conservative, separable, constant inertia, quadratic, linear",
                [-2.0..2.0],
            ),
            "frequency",
        ),
        rocking(Row::of::<HoopWithRod, 1>("scleronomic, conservative, quadratic", [-3.0..3.0]), "frequency"),
    ]
}

/// The frequency near rest, in closed form.
fn with_frequency(row: Row, name: &str) -> Row {
    let found = row.special.as_ref().expect("a frequency").value;
    let expected = number(row.subject().reference.special(name));
    row.special("ω₁", found, expected)
}

/// Periods of finite amplitude, by quadrature of the first integral.
fn rocking(row: Row, frequency: &str) -> Row {
    let mut row = with_frequency(row, frequency);
    let reference = row.subject().reference.clone();
    if let Some(length) = reference.special("equivalent_pendulum_length").as_f64() {
        let found =
            row.special.as_ref().map_or(f64::NAN, |shown| reference.parameter("g") / shown.value.powi(2));
        row = row.number("equivalent pendulum", found, length);
    }
    // The centroid of a segment of half-angle α is at 4R sin³ α/(3(2α − sin 2α)) from the centre of its circle.
    if let Some(angle) = reference.special("geometry")["half_angle"].as_f64() {
        let found = 4.0 * reference.parameter("R") * angle.sin().powi(3)
            / (3.0 * (2.0 * angle - (2.0 * angle).sin()));
        row = row.number("r of the segment", reference.parameter("r"), found);
    }
    for case in list(&row.subject().reference.special("periods").clone()) {
        row = row.period("period", &[number(&case["theta0"])], 0, number(&case["tau"]));
    }
    row
}

/// Let go at rest at θ = 0: speed, acceleration, and the forces N and f of the floor, which act on the axis that is
/// kept at its height and at Rθ.
fn eccentric() -> Row {
    let mut row = Row::of::<EccentricCylinder, 1>("scleronomic, conservative, quadratic", [-3.0..3.0]);
    let reference = row.subject().reference.clone();
    let [m, radius, a, g] = ["m", "R", "a", "g"].map(|name| reference.parameter(name));
    let free = Subject::of::<LiftedCylinder, 3>();
    for case in list(reference.special("released_from_rest_at_theta_0")) {
        let [theta, rate, bend, normal, friction] =
            ["theta", "omega", "omega_dot", "N", "friction"].map(|name| number(&case[name]));
        let state = State::new(&[theta], &[rate], 0.0);
        let lifted = State::new(&[theta, radius * theta, 0.0], &[rate, radius * rate, 0.0], 0.0);
        let accelerations = [bend, radius * bend, 0.0];
        // E = 0 all the time.
        let energy = row.subject().at("", &state).value(super::harness::Quantity::Energy)[0];
        let found = row.subject().accelerations(&state)[0];
        row = row
            .within("E", energy, 0.0, 1e-13 * m * g * a)
            .within("θ̈", found, bend, 1e-13 * (bend.abs() + rate * rate))
            .reaction("N", &free, (&lifted, &accelerations), 2, normal)
            .reaction("friction", &free, (&lifted, &accelerations), 1, friction)
            .show("θ̈", found, bend);
    }
    row
}
