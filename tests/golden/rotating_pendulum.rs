//! Pendulum hinged on a table that turns at constant speed about a vertical axis, without gravity in its plane: a bob
//! on a wire, and a rod. Sections 11.12.2.1–3, Problem 11.18.
//!
//! Erratum of the source: for release from rest at β₀ at t = 0, (11.77n) has to be read with sn(pt + K) in place of
//! sn(pt), which belongs to the passage through β = 0. Remark: the table drives, so T + V is not conserved; the Jacobi
//! integral (11.77k) is.

use super::harness::{Row, State, Subject, list, number, with_reference};
use lagrange_runtime::prelude::{SVector, lagrangian};

lagrangian! {
    /// β, angle of the wire from the outward radius.
    pub system RotatingPendulum {
        param m, l, r, om;
        coord beta;
        coord theta = om * t;
        let x = r * theta.cos() + l * (theta + beta).cos();
        let y = r * theta.sin() + l * (theta + beta).sin();
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
        V = 0;
        observe bob = [x, y];
        observe torque = reaction(theta);
    }
}

golden!(RotatingPendulum<1>, "sec-11.12.2.1-rotating-pendulum", |p| RotatingPendulum {
    m: p("m"),
    l: p("l"),
    r: p("r"),
    om: p("om")
});

lagrangian! {
    /// With the angle of the table free and the wire replaced by its pull on the hinge, which here is given.
    pub system PendulumOnFreeTable {
        param m, l, r, P0;
        coord beta, theta;
        let x = r * theta.cos() + l * (theta + beta).cos();
        let y = r * theta.sin() + l * (theta + beta).sin();
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
        V = 0;
        Q[theta] = -P0 * r * beta.sin();
    }
}

golden!(PendulumOnFreeTable<2>, "sec-11.12.2.2-rotating-pendulum-relaxed", |p| PendulumOnFreeTable {
    m: p("m"),
    l: p("l"),
    r: p("r"),
    P0: p("P0")
});

lagrangian! {
    /// A thin rod in place of the bob.
    pub system RotatingRod {
        param m, l, r, om;
        coord beta;
        coord theta = om * t;
        let x = r * theta.cos() + 0.5 * l * (theta + beta).cos();
        let y = r * theta.sin() + 0.5 * l * (theta + beta).sin();
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2))
            + 0.5 * (m * l.powi(2) / 12) * (dot(theta) + dot(beta)).powi(2);
        V = 0;
        observe centre = [x, y];
        observe torque = reaction(theta);
    }
}

golden!(RotatingRod<1>, "prob-11.18-rod-on-spinning-table", |p| RotatingRod {
    m: p("m"),
    l: p("l"),
    r: p("r"),
    om: p("om")
});

lagrangian! {
    /// The rod without its hinge: place of its end in axes that lie along it, and its angle.
    pub system FreeEnd {
        param m, l;
        coord x, y, alpha;
        let u = x + 0.5 * l * alpha.cos();
        let v = y + 0.5 * l * alpha.sin();
        T = 0.5 * m * (dot(u).powi(2) + dot(v).powi(2)) + 0.5 * (m * l.powi(2) / 12) * dot(alpha).powi(2);
        V = 0;
    }
}

golden!(FreeEnd<3>, "prob-11.18-rod-on-spinning-table", |p| FreeEnd { m: p("m"), l: p("l") });

const FACTS: &str = "conservative, separable, constant inertia, quadratic";

pub fn rows() -> Vec<Row> {
    vec![steady(), relaxed(), rod()]
}

/// Periods and the motion by elliptic functions, and the pull of the wire as a function of the angle (11.77l).
fn steady() -> Row {
    let mut row = Row::of::<RotatingPendulum, 1>(FACTS, [-3.0..3.0]);
    let reference = row.subject().reference.clone();
    let [om, r] = ["om", "r"].map(|name| reference.parameter(name));
    for case in list(reference.special("elliptic_motion_11_77n")) {
        let [start, t, end] =
            ["beta0", "t_from_rest_at_beta0", "beta_from_rest"].map(|name| number(&case[name]));
        row = row.motion("from rest", (&[start], &[0.0]), t, &[(0, end)]);
    }
    for case in list(reference.special("periods_11_77n")) {
        row = row.period("period", &[number(&case["beta0"])], 0, number(&case["tau"]));
    }
    let relaxed = Subject::of::<PendulumOnFreeTable, 2>().with(&[("P0", 0.0)]);
    let pendulum = with_reference::<RotatingPendulum, 1>();
    for case in list(reference.special("tension_11_77l")) {
        let [beta, rate, pull] = ["beta", "betadot", "P"].map(|name| number(&case[name]));
        let bend = row.subject().accelerations(&State::new(&[beta], &[rate], 0.0))[0];
        let state = State::new(&[beta, 0.0], &[rate, om], 0.0);
        let emitted = pendulum.torque(&SVector::from([beta]), &SVector::from([rate]), 0.0);
        // The torque is the difference of the moments that P and the inertia along the radius have.
        let allowed = 1e-13 * r * (pull.abs() + pendulum.m * r * om * om);
        row = row.within("emitted torque", emitted, -pull * r * beta.sin(), allowed);
        row = row.reaction("P", &relaxed, (&state, &[bend, 0.0]), 1, -pull * r * beta.sin());
    }
    row
}

/// The pull of (11.77l) keeps the table at constant speed. M is singular at β = 0, since the table has no inertia.
fn relaxed() -> Row {
    let mut row = Row::of::<PendulumOnFreeTable, 2>("scleronomic, quadratic", [0.5..2.6, -3.0..3.0]);
    let free = row.subject().clone().with(&[("P0", 0.0)]);
    for case in list(&row.subject().reference.special("tension_from_11_77j").clone()) {
        let [beta, rate, om, bend, torque] =
            ["beta", "betadot", "omega", "betaddot", "Q_theta"].map(|name| number(&case[name]));
        let state = State::new(&[beta, 0.0], &[rate, om], 0.0);
        let driven = row.subject().clone().with(&[("P0", number(&case["P"]))]);
        let found = driven.accelerations(&state);
        let size = om * om + rate * rate + bend.abs();
        row = row
            .reaction("Q_θ", &free, (&state, &[bend, 0.0]), 1, torque)
            .reaction("Q_β", &free, (&state, &[bend, 0.0]), 0, 0.0)
            // M is worst near β = 0.
            .within("θ̈ under P", found[1], 0.0, 1e-13 * size / beta.sin().powi(2))
            .within("β̈ under P", found[0], bend, 1e-13 * size / beta.sin().powi(2))
            .show("β̈ under P", found[0], bend);
    }
    row
}

/// Periods by elliptic integrals, and the components of the force of the hinge along and across the rod.
fn rod() -> Row {
    let mut row = Row::of::<RotatingRod, 1>(FACTS, [-3.0..3.0]);
    let reference = row.subject().reference.clone();
    let [om, r] = ["om", "r"].map(|name| reference.parameter(name));
    for case in list(reference.special("period")) {
        row = row.period("period", &[number(&case["beta0"])], 0, number(&case["tau"]));
    }
    let free = Subject::of::<FreeEnd, 3>();
    let rod = with_reference::<RotatingRod, 1>();
    for case in list(reference.special("hinge_reaction")) {
        let [beta, rate, along, across] =
            ["beta", "betadot", "F_along_rod", "F_across_rod"].map(|name| number(&case[name]));
        let bend = row.subject().accelerations(&State::new(&[beta], &[rate], 0.0))[0];
        let emitted = rod.torque(&SVector::from([beta]), &SVector::from([rate]), 0.0);
        let torque = number(&case["Q_theta"]);
        // Axes along and across the rod at this instant: the radius of the hinge lies at −β.
        let (sin, cos) = (-beta).sin_cos();
        let hinge = [r * cos, r * sin];
        let state = State::new(&[hinge[0], hinge[1], 0.0], &[-om * hinge[1], om * hinge[0], om + rate], 0.0);
        let accelerations = [-om * om * hinge[0], -om * om * hinge[1], bend];
        row = row
            .within("emitted torque", emitted, torque, 1e-13 * r * (along.abs() + across.abs()))
            .reaction("force along the rod", &free, (&state, &accelerations), 0, along)
            .reaction("force across the rod", &free, (&state, &accelerations), 1, across)
            .reaction("moment about the hinge", &free, (&state, &accelerations), 2, 0.0);
    }
    row
}
