//! Bead in a smooth circular tube that spins at constant speed about a vertical diameter: by a prescribed azimuth and
//! the position of the bead, and reduced by hand. Example 11.5(a).
//!
//! Erratum of the source: the reaction at the end of Example 11.5(b) lacks the dot on θ; R = 2 m a ω θ̇ cos θ, as in
//! (11.39g).

use super::harness::{Row, State, Subject, list, number, required, with_reference};
use lagrange_runtime::prelude::{SVector, lagrangian};
use lagrange_runtime::{Lagrangian, System};

lagrangian! {
    /// θ from the downward vertical; the tube turns as φ = ωt.
    pub system BeadInTube {
        param m, a, om, g = 9.81;
        coord theta;
        coord phi = om * t;
        let x = a * theta.sin() * phi.cos();
        let y = a * theta.sin() * phi.sin();
        let z = a * (1 - theta.cos());
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2));
        V = m * g * z;
        observe bead = [x, y, z];
        observe torque = reaction(phi);
    }
}

golden!(BeadInTube<1>, "ex-11.5a-bead-in-spinning-tube", |p| BeadInTube {
    m: p("m"),
    a: p("a"),
    om: p("om"),
    g: p("g")
});

lagrangian! {
    /// The tube as a frame that turns at the given rate, the radius to the bead as a frame in it.
    pub system BeadOfFrames {
        param m, a, om, g = 9.81;
        coord theta;
        coord phi = om * t;
        let tube = frame(world, [0, 0, a], rotation_z(phi));
        let bead = frame(frame(tube, [0, 0, 0], rotation_y(-theta)), [0, 0, -a]);
        T = particle(m, bead);
        V = m * g * bead.origin()[2];
        observe place = bead.origin();
        observe torque = reaction(phi);
    }
}

golden!(BeadOfFrames<1>, "ex-11.5a-bead-in-spinning-tube", |p| BeadOfFrames {
    m: p("m"),
    a: p("a"),
    om: p("om"),
    g: p("g")
});

lagrangian! {
    /// With the speed of the tube put into T.
    pub system BeadReduced {
        param m, a, om, g = 9.81;
        coord theta;
        T = 0.5 * m * a.powi(2) * (dot(theta).powi(2) + (om * theta.sin()).powi(2));
        V = m * g * a * (1 - theta.cos());
    }
}

golden!(BeadReduced<1>, "ex-11.5a-bead-in-spinning-tube", |p| BeadReduced {
    m: p("m"),
    a: p("a"),
    om: p("om"),
    g: p("g")
});

lagrangian! {
    /// With the tube free to turn under a force R across it, Example 11.5(b). The force is a choice.
    pub system BeadInFreeTube {
        param m, a, R0, g = 9.81;
        coord theta, phi;
        let x = a * theta.sin() * phi.cos();
        let y = a * theta.sin() * phi.sin();
        let z = a * (1 - theta.cos());
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2));
        V = m * g * z;
        force [-R0 * phi.sin(), R0 * phi.cos(), 0] at [x, y, z];
    }
}

golden!(BeadInFreeTube<2>, "ex-11.5b-bead-relaxed", |p| BeadInFreeTube {
    m: p("m"),
    a: p("a"),
    R0: p("R0"),
    g: p("g")
});

pub fn rows() -> Vec<Row> {
    vec![steady(), relaxed()]
}

/// h is conserved, T + V is not. In the reduced writing nothing says any more that the constraint moves; in the other
/// one t leaves L with sin² φ + cos² φ = 1, and the system stays rheonomic.
fn steady() -> Row {
    let row = Row::of::<BeadInTube, 1>("conservative, separable, constant inertia, quadratic", [-3.1..3.1])
        .also::<BeadReduced, 1>("scleronomic, conservative, separable, constant inertia, quadratic")
        .also::<BeadOfFrames, 1>("conservative, separable, constant inertia, quadratic");
    let row = reactions(relative_equilibria(row));
    let bead = with_reference::<BeadReduced, 1>();
    let integral = row.subject().reference.special("first_integral_11_39f").clone();
    let [start, rate, end, square] =
        ["theta0", "thetadot0", "theta", "thetadot_squared"].map(|name| number(&integral[name]));
    let energies = [(start, rate), (end, square.sqrt())]
        .map(|(theta, rate)| bead.energy_function(&SVector::from([theta]), &SVector::from([rate]), 0.0));
    let row = row.within("(11.39f)", energies[1], energies[0], 1e-13 * bead.m * bead.g * bead.a);
    let expected = number(row.subject().reference.special("critical_speed"));
    // The bottom is stable up to the speed at which ∂θ̈/∂θ changes its sign, which it does linearly in ω².
    let bottom = |om: f64| {
        let bead = BeadReduced { om, ..bead };
        bead.jacobian(&SVector::from([0.0]), &SVector::from([0.0]), 0.0).q[0]
    };
    let critical = (-bottom(0.0) / (bottom(1.0) - bottom(0.0))).sqrt();
    row.special("critical ω", critical, expected)
}

/// The bead rests in the tube at the bottom, at the top, and at cos θ = g/(aω²); stable where θ̈ falls with θ.
fn relative_equilibria(mut row: Row) -> Row {
    let bead = with_reference::<BeadReduced, 1>();
    let rest = SVector::from([0.0]);
    for place in list(&row.subject().reference.special("relative_equilibria").clone()) {
        let q = SVector::from([number(&place["theta"])]);
        let (sin, cos) = q[0].sin_cos();
        // π is not a double, so the top is missed by 1e-16.
        let missed = f64::EPSILON * (bead.g / bead.a + bead.om * bead.om);
        let allowed = 1e-13 * (bead.g / bead.a * sin).abs() + missed;
        let stiffness = -bead.jacobian(&q, &rest, 0.0).q[0];
        let terms = (bead.g / bead.a * cos).abs() + bead.om * bead.om;
        row = row
            .within("rest in the tube", bead.accel(&q, &rest, 0.0)[0], 0.0, allowed)
            .within("∂θ̈/∂θ", stiffness, number(&place["omega2"]), 1e-13 * terms)
            .holds("stability", (stiffness > 0.0) == (place["stable"] == true));
    }
    row
}

/// (11.39g), R = 2 m a ω θ̇ cos θ: the force that keeps the relaxed tube at constant speed.
fn reactions(mut row: Row) -> Row {
    let bead = with_reference::<BeadInTube, 1>();
    let relaxed = Subject::of::<BeadInFreeTube, 2>().with(&[("R0", 0.0)]);
    for case in list(&row.subject().reference.special("reaction_R_11_39g").clone()) {
        let [theta, rate] = ["theta", "thetadot"].map(|name| number(&case[name]));
        let bend = row.subject().accelerations(&State::new(&[theta], &[rate], 0.0))[0];
        let state = State::new(&[theta, 0.0], &[rate, bead.om], 0.0);
        let torque = number(&case["driving_torque"]);
        let arm = bead.a * theta.sin();
        let emitted = bead.torque(&SVector::from([theta]), &SVector::from([rate]), 0.0);
        row = row.number("emitted torque", emitted, torque);
        row = row.reaction("torque on the tube", &relaxed, (&state, &[bend, 0.0]), 1, torque).reaction(
            "(11.39g)",
            &relaxed,
            (&state, &[bend, 0.0]),
            1,
            number(&case["R"]) * arm,
        );
    }
    row
}

/// φ is missing from L, but the force turns the tube.
fn relaxed() -> Row {
    let row = Row::of::<BeadInFreeTube, 2>("scleronomic, quadratic", [0.4..2.7, -3.0..3.0]);
    let case = &list(row.subject().reference.special("recovered_reaction"))[0];
    let [theta, rate, om, force] = ["theta", "thetadot", "omega", "R"].map(|name| number(&case[name]));
    let free = row.subject().clone().with(&[("R0", 0.0)]);
    let state = State::new(&[theta, 0.0], &[rate, om], 0.0);
    let bend = free.accelerations(&state)[0];
    let arm = row.subject().reference.parameter("a") * theta.sin();
    let found = required(&free, &state, &[bend, 0.0])[1].0 / arm;
    // With the force that it needs the tube keeps its speed.
    row.special("R", found, force)
}
