//! Systems kept with their constraints and multipliers λ: the force of a constraint f is λ ∂f/∂q. A pendulum in
//! Cartesian coordinates, a spherical pendulum in cylindrical ones, a moving incline, a disk that is guided and disks
//! that roll, a rod on a turning table. Sections 11.2, 11.10.2, Problem 11.18.
//!
//! The path, the forces and the torques of the disks, the motion of the incline and the direction of gravity are
//! choices.
//!
//! Erratum of the source: Section 11.10.2 prints L of the spherical pendulum without its constraint r² + z² = l²,
//! without which r and z would be free.

use super::harness::{Quantity, Row, State, Subject, list, number};
use super::{moving_incline, rotating_pendulum, simple_pendulum, spherical_pendulum};
use lagrange_runtime::prelude::lagrangian;

lagrangian! {
    /// One point P of the disk is guided on y = k x²; the centre of mass lies at d from it.
    pub system GuidedDisk {
        param m, I, d, k, g = 9.81;
        coord xP, yP, th;
        let x = xP + d * th.cos();
        let y = yP + d * th.sin();
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2)) + 0.5 * I * dot(th).powi(2);
        V = m * g * y;
        constraint path: yP == k * xP.powi(2);
    }
}

golden!(
    GuidedDisk<3>,
    "sec-11.2-disk-point-on-path",
    |p| GuidedDisk { m: p("m"), I: p("I"), d: p("d"), k: p("k"), g: p("g") },
    constrained
);

lagrangian! {
    /// x points downwards.
    pub system CartesianPendulum {
        param m, l, g = 9.81;
        coord x, y, z;
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2));
        V = -m * g * x;
        constraint plane: z == 0;
        constraint rod: x.powi(2) + y.powi(2) == l.powi(2);
    }
}

golden!(
    CartesianPendulum<3>,
    "sec-11.2.1-pendulum-cartesian",
    |p| CartesianPendulum { m: p("m"), l: p("l"), g: p("g") },
    constrained
);

lagrangian! {
    /// The incline stands at s(t).
    pub system InclineWithMultiplier {
        param m, b, a, om, g = 9.81;
        coord X, Y;
        coord s = a * sin(om * t);
        T = 0.5 * m * (dot(X).powi(2) + dot(Y).powi(2));
        V = m * g * Y;
        constraint incline: Y == b * (X - s);
    }
}

golden!(
    InclineWithMultiplier<2>,
    "sec-11.2.1-moving-incline-multiplier",
    |p| InclineWithMultiplier { m: p("m"), b: p("b"), a: p("A"), om: p("Om"), g: p("g") },
    constrained
);

lagrangian! {
    /// φ, heading; θ, spin; driven by constant torques about both axes.
    pub system RollingDisk {
        param m, a, It, Ip, tau, taup;
        coord x, y, phi, theta;
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2)) + 0.5 * It * dot(theta).powi(2) + 0.5 * Ip * dot(phi).powi(2);
        V = 0;
        Q[theta] = tau;
        Q[phi] = taup;
        constraint along: dot(x) == a * phi.cos() * dot(theta);
        constraint across: dot(y) == a * phi.sin() * dot(theta);
    }
}

golden!(
    RollingDisk<4>,
    "sec-11.2.2-rolling-disk",
    |p| RollingDisk { m: p("m"), a: p("a"), It: p("It"), Ip: p("Ip"), tau: p("tau"), taup: p("taup") },
    constrained
);

lagrangian! {
    /// Along the line φ = π/2.
    pub system DiskOnALine {
        param m, a, It, tau;
        coord x, y, theta;
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2)) + 0.5 * It * dot(theta).powi(2);
        V = 0;
        Q[theta] = tau;
        constraint line: x == 0;
        constraint rolling: y == a * theta;
    }
}

golden!(
    DiskOnALine<3>,
    "sec-11.2.2-rolling-disk-straight",
    |p| DiskOnALine { m: p("m"), a: p("a"), It: p("It"), tau: p("tau") },
    constrained
);

lagrangian! {
    /// The same with its constraints on velocities, as the source has them.
    pub system DiskOnALineByVelocities {
        param m, a, It, tau;
        coord x, y, theta;
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2)) + 0.5 * It * dot(theta).powi(2);
        V = 0;
        Q[theta] = tau;
        constraint line: dot(x) == 0;
        constraint rolling: dot(y) == a * dot(theta);
    }
}

golden!(
    DiskOnALineByVelocities<3>,
    "sec-11.2.2-rolling-disk-straight",
    |p| DiskOnALineByVelocities { m: p("m"), a: p("a"), It: p("It"), tau: p("tau") },
    constrained
);

lagrangian! {
    /// z points downwards.
    pub system CylindricalPendulum {
        param m, l, g = 9.81;
        coord r, phi, z;
        T = 0.5 * m * (dot(r).powi(2) + (r * dot(phi)).powi(2) + dot(z).powi(2));
        V = -m * g * z;
        constraint sphere: r.powi(2) + z.powi(2) == l.powi(2);
    }
}

golden!(
    CylindricalPendulum<3>,
    "sec-11.10.2-spherical-pendulum-cylindrical",
    |p| CylindricalPendulum { m: p("m"), l: p("l"), g: p("g") },
    constrained
);

lagrangian! {
    /// Place of the end of the rod, which the hinge moves, and its angle.
    pub system HingedRod {
        param m, l, r, om;
        coord x, y, alpha;
        let u = x + 0.5 * l * alpha.cos();
        let v = y + 0.5 * l * alpha.sin();
        T = 0.5 * m * (dot(u).powi(2) + dot(v).powi(2)) + 0.5 * (m * l.powi(2) / 12) * dot(alpha).powi(2);
        V = 0;
        constraint hinge: [x, y] == [r * (om * t).cos(), r * (om * t).sin()];
    }
}

golden!(
    HingedRod<3>,
    "prob-11.18-rod-multiplier",
    |p| HingedRod { m: p("m"), l: p("l"), r: p("r"), om: p("om") },
    constrained
);

pub fn rows() -> Vec<Row> {
    vec![
        guided_disk(),
        cartesian_pendulum(),
        incline(),
        rolling_disk(),
        disk_on_a_line(),
        cylindrical_pendulum(),
        hinged_rod(),
    ]
}

/// Some numbers of one system against those of another, each with the size of their terms.
fn same(row: Row, what: &str, pairs: &[(f64, f64)], size: f64) -> Row {
    pairs.iter().fold(row, |row, (mine, other)| row.within(what, *mine, *other, 1e-13 * size))
}

/// Three coordinates less one constraint.
fn guided_disk() -> Row {
    let row = Row::constrained::<GuidedDisk, 3>("scleronomic, conservative, quadratic, path holonomic");
    let free = row.subject().facts.coordinates.len();
    let guided = row.subject().facts.degrees_of_freedom();
    row.holds("three degrees of freedom free, two guided", (free, guided) == (3, 2))
}

/// The multiplier is −T/2l, and the motion that of the pendulum by its angle.
fn cartesian_pendulum() -> Row {
    let mut row = Row::constrained::<CartesianPendulum, 3>(
        "scleronomic, conservative, constant inertia, quadratic, plane holonomic, rod holonomic, blocks x y | z",
    );
    let reference = row.subject().reference.clone();
    let [l, g] = ["l", "g"].map(|name| reference.parameter(name));
    let by_angle = Subject::of::<simple_pendulum::SimplePendulum, 1>();
    for case in list(&reference.special("multiplier_from_tension")["cases"]) {
        let [theta, rate, tension, multiplier] =
            ["theta", "thetadot", "tension", "lambda_f2"].map(|name| number(&case[name]));
        let (sin, cos) = theta.sin_cos();
        let state = State::new(&[l * cos, l * sin, 0.0], &[-l * sin * rate, l * cos * rate, 0.0], 0.0);
        let point = row.subject().at("", &state);
        let (found, a) = (point.value(Quantity::Multipliers), point.value(Quantity::Acceleration));
        let bend = by_angle.accelerations(&State::new(&[theta], &[rate], 0.0))[0];
        let expected = [-l * (sin * bend + cos * rate * rate), l * (cos * bend - sin * rate * rate)];
        let size = g + l * rate * rate;
        row = same(row, "ẍ, ÿ by the angle", &[(a[0], expected[0]), (a[1], expected[1])], size);
        let scale = reference.parameter("m") * size / l;
        row =
            same(row, "λ", &[(found[0], 0.0), (found[1], multiplier), (-2.0 * l * found[1], tension)], scale)
                .show("λ of the rod", found[1], multiplier);
    }
    row
}

/// The same acceleration as without the multiplier; the force of the incline is λ √(1 + b²).
fn incline() -> Row {
    let mut row =
        Row::constrained::<InclineWithMultiplier, 2>("constant inertia, quadratic, incline holonomic");
    let reduced = Subject::of::<moving_incline::MovingIncline, 1>();
    let g = row.subject().reference.parameter("g");
    for state in row.subject().reference.clone().states {
        let state = state.state();
        let mine = row.subject().accelerations(&state)[0];
        let other = reduced.accelerations(&State::new(&state.q[..1], &state.qd[..1], state.t))[0];
        row = same(row, "Ẍ", &[(mine, other)], g);
    }
    row
}

/// Without torques it rolls along a circle of radius a θ̇/φ̇. Neither constraint can be integrated.
fn rolling_disk() -> Row {
    let row = Row::constrained::<RollingDisk, 4>(
        "scleronomic, constant inertia, quadratic, along nonholonomic, across nonholonomic, cascade phi > x y theta",
    );
    let reference = row.subject().reference.clone();
    let circle = reference.special("free_rolling_closed_form");
    let [radius, x, y, phi, theta] = ["radius", "x", "y", "phi", "theta"].map(|name| number(&circle[name]));
    // φ and θ grow evenly.
    let time = 3.0;
    let (turn, spin) = (phi / time, theta / time);
    let a = reference.parameter("a");
    let start = (&[0.0; 4][..], &[a * spin, 0.0, turn, spin][..]);
    let accelerations = row.subject().accelerations(&reference.trajectory().remove(0));
    row.number("radius", a * spin / turn, radius)
        .number("driven spin", accelerations[3], number(reference.special("driven_spin_acceleration")))
        .number("driven heading", accelerations[2], number(reference.special("driven_heading_acceleration")))
        .motion_with(
            &[("tau", 0.0), ("taup", 0.0)],
            "x on the circle",
            start,
            time,
            &[(0, x), (1, y), (2, phi), (3, theta)],
        )
}

/// Constraints that are integrable, and their integrals.
fn disk_on_a_line() -> Row {
    Row::constrained::<DiskOnALine, 3>(
        "scleronomic, constant inertia, quadratic, line holonomic, rolling holonomic, blocks x | y theta",
    )
    .also::<DiskOnALineByVelocities, 3>(
        "scleronomic, constant inertia, quadratic, line integrable, rolling integrable, blocks x | y theta",
    )
}

/// The same motion as in spherical coordinates; the tension is −2λl.
fn cylindrical_pendulum() -> Row {
    let mut row = Row::constrained::<CylindricalPendulum, 3>(
        "scleronomic, conservative, quadratic, sphere holonomic, ignorable phi",
    );
    let reference = row.subject().reference.clone();
    let [m, l, g] = ["m", "l", "g"].map(|name| reference.parameter(name));
    let spherical = Subject::of::<spherical_pendulum::SphericalPendulum, 2>();
    for state in &reference.states {
        let state = state.state();
        let theta = state.q[0].atan2(state.q[2]);
        let (sin, cos) = theta.sin_cos();
        let rate = (state.qd[0] * cos - state.qd[2] * sin) / l;
        let point = row.subject().at("", &state);
        let (a, found) = (point.value(Quantity::Acceleration), point.value(Quantity::Multipliers)[0]);
        let other = spherical.accelerations(&State::new(&[theta, state.q[1]], &[rate, state.qd[1]], 0.0));
        let speed = l * l * (rate * rate + (sin * state.qd[1]).powi(2));
        let size = (g + speed / l) / sin;
        let tension = m * (g * cos + speed / l);
        row = same(row, "r̈, φ̈", &[(a[0], l * (cos * other[0] - sin * rate * rate)), (a[1], other[1])], size);
        row = same(row, "tension", &[(-2.0 * found * l, tension)], m * size).show(
            "tension",
            -2.0 * found * l,
            tension,
        );
    }
    row
}

/// The multipliers are the force of the hinge, and the rod turns as it does without them.
fn hinged_rod() -> Row {
    let mut row = Row::constrained::<HingedRod, 3>("quadratic, hinge[0] holonomic, hinge[1] holonomic");
    let reduced = Subject::of::<rotating_pendulum::RotatingRod, 1>();
    let om = row.subject().reference.parameter("om");
    for state in row.subject().reference.clone().states {
        let state = state.state();
        let mine = row.subject().accelerations(&state)[2];
        let (beta, rate) = (state.q[2] - om * state.t, state.qd[2] - om);
        let other = reduced.accelerations(&State::new(&[beta], &[rate], state.t))[0];
        row = same(row, "α̈", &[(mine, other)], om * om * (1.0 + om * state.t)).show("α̈", mine, other);
    }
    row
}
