//! Plane motion under an inverse-square central force, in polar coordinates and by Cartesian positions in terms of
//! them. Example 11.3, Section 11.10.1.

use super::harness::{Row, number, recovered, with_reference};
use lagrange_runtime::prelude::{SVector, lagrangian};
use lagrange_runtime::{Lagrangian, System};

lagrangian! {
    /// A particle attracted by a fixed centre with the force μm/r².
    pub system CentralForce {
        param m, mu;
        coord r, phi;
        T = 0.5 * m * (dot(r).powi(2) + (r * dot(phi)).powi(2));
        V = -mu * m / r;
    }
}

golden!(CentralForce<2>, "ex-11.3-central-force", |p| CentralForce { m: p("m"), mu: p("mu") });

lagrangian! {
    /// The same, by its position in the plane.
    pub system CentralForceInThePlane {
        param m, mu;
        coord r, phi;
        let x = r * cos(phi);
        let y = r * sin(phi);
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
        V = -mu * m / r;
        pub routhian Radial;
    }
}

golden!(CentralForceInThePlane<2>, "ex-11.3-central-force", |p| CentralForceInThePlane {
    m: p("m"),
    mu: p("mu")
});

lagrangian! {
    /// With the angle eliminated: the radial motion in the apparent potential, (11.42b).
    pub system RadialMotion {
        param m, mu, gamma;
        coord r;
        T = 0.5 * m * dot(r).powi(2);
        V = -mu * m / r + 0.5 * m * (gamma / r).powi(2);
    }
}

golden!(RadialMotion<1>, "sec-11.10.1-central-force-reduced", |p| RadialMotion {
    m: p("m"),
    mu: p("mu"),
    gamma: p("gamma")
});

// The compiler's reduction.
golden!(Radial<1>, "sec-11.10.1-central-force-reduced", |p| Radial {
    m: p("m"),
    mu: p("mu"),
    p_phi: p("m") * p("gamma")
});

pub fn rows() -> Vec<Row> {
    vec![orbit(), reduced()]
}

/// φ is ignorable in both writings, although x and y depend on it: sin² φ + cos² φ = 1 has to be found in T.
fn orbit() -> Row {
    let facts = "scleronomic, conservative, quadratic, ignorable phi";
    let row =
        Row::of::<CentralForce, 2>(facts, [0.4..3.0, -3.0..3.0]).also::<CentralForceInThePlane, 2>(facts);
    let reference = row.subject().reference.clone();

    // From the perihelion, once round: r and ṙ return, φ has advanced by 2π.
    let [near, far, period] =
        ["perihelion", "aphelion", "period"].map(|name| number(reference.special(name)));
    let gamma = number(reference.special("gamma"));
    let start = (&[near, 0.0][..], &[0.0, gamma / (near * near)][..]);
    let turn = std::f64::consts::TAU;
    let row = row
        .number("semi-major axis", 0.5 * (near + far), number(reference.special("semi_major_axis")))
        .within("eccentricity", (far - near) / (far + near), number(reference.special("eccentricity")), 1e-13)
        .number("areal rate", 0.5 * gamma, number(reference.special("areal_rate")));
    let row = row.motion("one period", start, period, &[(0, near), (2, 0.0), (1, turn)]).motion(
        "half a period",
        start,
        0.5 * period,
        &[(0, far), (2, 0.0), (1, 0.5 * turn)],
    );

    // The circle r = γ²/μ: no radial acceleration, and the radial frequency μ²/γ³ from (11.42b).
    let orbit = reference.special("circular_orbit");
    let r = number(&orbit["r"]);
    let particle = with_reference::<CentralForce, 2>();
    let (q, qd) = (SVector::from([r, 0.3]), SVector::from([0.0, gamma / (r * r)]));
    let radial = r * qd[1] * qd[1];
    let row = row.balance("circle", &[particle.accel(&q, &qd, 0.0)[0] + radial, -radial]);

    // At constant γ = r² φ̇ the angular speed changes by −2 φ̇/r per unit of r.
    let jacobian = particle.jacobian(&q, &qd, 0.0);
    let frequency = number(&orbit["radial_frequency"]);
    let terms = [jacobian.q[(0, 0)], jacobian.qd[(0, 1)] * (-2.0 * qd[1] / r)];
    row.balance("radial frequency", &[terms[0], terms[1], frequency * frequency]).show(
        "ω of the circle",
        (-terms[0] - terms[1]).sqrt(),
        frequency,
    )
}

/// The reduced motion is that of the full system.
fn reduced() -> Row {
    let facts = "scleronomic, conservative, separable, constant inertia, quadratic";
    let row = Row::of::<RadialMotion, 1>(facts, [0.5..3.0]).also::<Radial, 1>(facts);
    let row = recovered(row, &with_reference::<CentralForceInThePlane, 2>(), CentralForceInThePlane::reduce);
    let system = with_reference::<RadialMotion, 1>();
    let full = with_reference::<CentralForce, 2>();
    let row = row.balances("r̈ of the full system", |state| {
        let (r, rd) = (state.q[0], state.qd[0]);
        let (q, qd) = (SVector::from([r, 0.0]), SVector::from([rd, system.gamma / (r * r)]));
        let terms = [system.mu / (r * r), system.gamma.powi(2) / r.powi(3)];
        let difference = full.accel(&q, &qd, 0.0)[0] - row_acceleration(&system, r, rd);
        vec![difference, terms[0], -terms[0], terms[1], -terms[1]]
    });
    let radius = SVector::from([number(row.subject().reference.special("circular_radius"))]);
    let frequency = number(row.subject().reference.special("radial_frequency"));
    let stiffness = -system.jacobian(&radius, &SVector::from([0.0]), 0.0).q[0];
    let terms = [2.0 * system.mu / radius[0].powi(3), 3.0 * system.gamma.powi(2) / radius[0].powi(4)];
    row.balance("ω²", &[stiffness - frequency * frequency, terms[0], -terms[0], terms[1], -terms[1]]).show(
        "ω of the circle",
        stiffness.sqrt(),
        frequency,
    )
}

fn row_acceleration(system: &RadialMotion, r: f64, rate: f64) -> f64 {
    system.accel(&SVector::from([r]), &SVector::from([rate]), 0.0)[0]
}
