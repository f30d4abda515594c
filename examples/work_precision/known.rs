//! The four best known motions: each system as a user writes it, and where its motion starts and exactly ends.

use crate::digits::Digits;
use crate::problems::{Invariant, Problem, Value};
use lagrange_runtime::prelude::*;
use lagrange_runtime::testing::reference::{KeplerOrbit, SimplePendulum};
use std::error::Error;
use std::f64::consts::TAU;

lagrangian! {
    /// A mass on a light rod. Separable: constant inertia, and a force of position alone.
    pub system Pendulum {
        param m, l, g = 9.81;
        coord theta;
        T = 0.5 * m * (l * dot(theta)).powi(2);
        V = -m * g * l * cos(theta);
    }
}

lagrangian! {
    /// A planet of unit mass.
    pub system Kepler {
        param mu;
        coord x, y;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = -mu / (x.powi(2) + y.powi(2)).sqrt();
    }
}

lagrangian! {
    /// A double pendulum, by the positions of its bobs.
    pub system DoublePendulum {
        param m1, m2, l1, l2, g = 9.81;
        coord a, b;
        let x1 = l1 * sin(a);
        let y1 = -l1 * cos(a);
        let x2 = x1 + l2 * sin(b);
        let y2 = y1 - l2 * cos(b);
        T = 0.5 * m1 * (dot(x1).powi(2) + dot(y1).powi(2)) + 0.5 * m2 * (dot(x2).powi(2) + dot(y2).powi(2));
        V = m1 * g * y1 + m2 * g * y2;
    }
}

lagrangian! {
    /// A heavy symmetric top on its tip, by Euler's angles: precession, inclination, spin.
    pub system Top {
        param m, l, I1, I3, g = 9.81;
        coord phi, theta, psi;
        let spin = dot(psi) + dot(phi) * cos(theta);
        T = 0.5 * I1 * (dot(theta).powi(2) + (dot(phi) * sin(theta)).powi(2)) + 0.5 * I3 * spin.powi(2);
        V = m * g * l * cos(theta);
    }
}

/// The source of the ends of ellipses.
pub const KEPLER: &str = "closed form by Kepler's equation";

/// The source of the digits beside the golden tests; the README there says more.
const GOLDEN: &str = "30 digits, by Taylor series of order 40 (tests/golden/reference)";

/// In closed form, by Jacobi's elliptic functions.
pub fn pendulum() -> Problem<Pendulum, 1> {
    let system = Pendulum::new(1.0, 0.85);
    let (angle, t) = (2.0, 20.0);
    let exact = SimplePendulum::new(system.g, system.l, angle, 0.0);
    let (theta, thetad) = exact.state(t);
    let problem = Problem::new(
        "Simple pendulum",
        "pendulum",
        format!("from {angle} rad at rest, {:.1} periods", t / exact.period()),
        system,
        [State::new(0.0, [angle], [0.0]), State::new(t, [theta], [thetad])],
        "closed form by Jacobi's elliptic functions",
    );
    problem.long("its own", exact.period(), 480.0, 5)
}

/// In closed form, by Kepler's equation.
pub fn kepler() -> Result<Problem<Kepler, 2>, Box<dyn Error>> {
    // From the pericentre of an ellipse with semi-major axis 1: x = 1 − e, ẏ = √((1 + e)/(1 − e)).
    let (q, qd) = ([0.4, 0.0], [0.0, 2.0]);
    let orbit = KeplerOrbit::from_cartesian(1.0, q, qd).ok_or("not an ellipse")?;
    let mut problem = ellipse("Kepler problem, e = 0.6", "kepler", &orbit, (q, qd), 30.0).long(
        "one revolution",
        TAU,
        480.0,
        5,
    );
    // The compiler does not see it in these coordinates.
    let value: Value<Kepler, 2> = Box::new(|_, at| at.q[0] * at.qd[1] - at.q[1] * at.qd[0]);
    let momentum = Invariant { name: "angular momentum".into(), stem: "angular-momentum".into(), value };
    if let Some(long) = &mut problem.long {
        long.invariants.push(momentum);
    }
    Ok(problem)
}

/// From a state of an ellipse to a time.
pub fn ellipse(
    name: &'static str,
    stem: &'static str,
    orbit: &KeplerOrbit,
    (q, qd): ([f64; 2], [f64; 2]),
    t: f64,
) -> Problem<Kepler, 2> {
    let (q_end, qd_end) = orbit.cartesian(t);
    Problem::new(
        name,
        stem,
        format!("Cartesian coordinates, from the pericentre, {:.1} revolutions", t / orbit.period()),
        Kepler::new(1.0),
        [State::new(0.0, q, qd), State::new(t, q_end, qd_end)],
        KEPLER,
    )
}

/// Chaotic, without a closed form.
pub fn double_pendulum() -> Result<Problem<DoublePendulum, 2>, Box<dyn Error>> {
    let digits = Digits::of(include_str!("../../tests/golden/reference/prob-11.35-double-pendulum.json"))?;
    let p = |name| digits.parameter(name);
    let system = DoublePendulum { m1: p("m1")?, m2: p("m2")?, l1: p("l1")?, l2: p("l2")?, g: p("g")? };
    let [start, end] = digits.ends()?;
    let ([a, b], [va, vb]) = ([start.q[0], start.q[1]], [start.qd[0], start.qd[1]]);
    let motion = format!("from ({a}, {b}) rad with ({va}, {vb}) rad/s, {} s", end.t).replace('-', "−");
    let swing = TAU * (system.l1 / system.g).sqrt();
    let problem = Problem::new("Double pendulum", "double-pendulum", motion, system, [start, end], GOLDEN);
    Ok(problem.long("2π√(l₁/g)", swing, 960.0, 3))
}

/// Precession and nutation of a fast top.
pub fn top() -> Result<Problem<Top, 3>, Box<dyn Error>> {
    let digits = Digits::of(include_str!("../../tests/golden/reference/sec-11.12.4-symmetric-top.json"))?;
    let p = |name| digits.parameter(name);
    let system = Top { m: p("m")?, l: p("l")?, I1: p("I1")?, I3: p("I3")?, g: p("g")? };
    let [start, end] = digits.ends()?;
    let motion = format!("let go at {} rad with a spin of {} rad/s, {} s", start.q[1], start.qd[2], end.t);
    let nutation = TAU * system.I1 / (system.I3 * start.qd[2]);
    let problem = Problem::new("Heavy symmetric top", "top", motion, system, [start, end], GOLDEN);
    Ok(problem.long("nutation of a fast top, 2πI₁/(I₃ψ̇)", nutation, 480.0, 3))
}
