//! Where each motion starts, and where it ends to the last digit.

use crate::systems::{DoublePendulum, Kepler, Pendulum, Top};
use lagrange_runtime::prelude::*;
use lagrange_runtime::reference::{KeplerOrbit, SimplePendulum};
use serde_json::Value;
use std::error::Error;

/// What [`Problem::error`] is, for the axes of charts.
pub const ERROR: &str = "error: largest |Δq|/max|q|, |Δq̇|/max|q̇|";

/// A motion with a known end.
pub struct Problem<Sys, const N: usize> {
    pub name: &'static str,
    /// Name of its files.
    pub stem: &'static str,
    /// In words.
    pub motion: String,
    pub system: Sys,
    pub start: State<f64, N>,
    /// The exact state at the end, rounded.
    pub end: State<f64, N>,
    /// Where `end` is from.
    pub reference: &'static str,
    /// The largest |qₖ| and |q̇ₖ| along the motion: units for the error. A few digits of them are enough.
    size: State<f64, N>,
}

impl<Sys: System<N, Scalar = f64>, const N: usize> Problem<Sys, N> {
    fn new(
        name: &'static str,
        stem: &'static str,
        motion: String,
        system: Sys,
        [start, end]: [State<f64, N>; 2],
        reference: &'static str,
    ) -> Self {
        let mut size = State { t: 0.0, q: start.q.abs(), qd: start.qd.abs() };
        for step in integrate(&system, Dop853, Pi::tolerance(1e-6), start).until(end.t).flatten() {
            size.q = size.q.sup(&step.to.q.abs());
            size.qd = size.qd.sup(&step.to.qd.abs());
        }
        Problem { name, stem, motion, system, start, end, reference, size }
    }
}

impl<Sys, const N: usize> Problem<Sys, N> {
    /// How far a final state is off: the largest difference in any coordinate or velocity, each in units of its largest
    /// magnitude along the motion.
    pub fn error(&self, end: &State<f64, N>) -> f64 {
        let off = end.minus(&self.end);
        off.q.component_div(&self.size.q).amax().max(off.qd.component_div(&self.size.qd).amax())
    }
}

/// In closed form, by Jacobi's elliptic functions.
pub fn pendulum() -> Problem<Pendulum, 1> {
    let system = Pendulum::new(1.0, 0.85);
    let (angle, t) = (2.0, 20.0);
    let exact = SimplePendulum::new(system.g, system.l, angle, 0.0);
    let (theta, thetad) = exact.state(t);
    Problem::new(
        "Simple pendulum",
        "pendulum",
        format!("from {angle} rad at rest, {:.1} periods", t / exact.period()),
        system,
        [State::new(0.0, [angle], [0.0]), State::new(t, [theta], [thetad])],
        "closed form by Jacobi's elliptic functions",
    )
}

/// In closed form, by Kepler's equation.
pub fn kepler() -> Result<Problem<Kepler, 2>, Box<dyn Error>> {
    let system = Kepler::new(1.0);
    // From the pericentre of an ellipse with semi-major axis 1: r = 1 − e, r φ̇ = √((1 + e)/(1 − e)).
    let (q, qd) = ([0.4, 0.0], [0.0, 5.0]);
    let orbit = KeplerOrbit::new(system.mu, q, qd).ok_or("not an ellipse")?;
    let t = 30.0;
    let (q_end, qd_end) = orbit.state(t);
    Ok(Problem::new(
        "Kepler problem",
        "kepler",
        format!("polar coordinates, e = {:.2}, {:.1} revolutions", orbit.eccentricity(), t / orbit.period()),
        system,
        [State::new(0.0, q, qd), State::new(t, q_end, qd_end)],
        "closed form by Kepler's equation",
    ))
}

/// Chaotic, without a closed form: 30 digits from elsewhere.
pub fn double_pendulum() -> Result<Problem<DoublePendulum, 2>, Box<dyn Error>> {
    let digits = Digits::of(include_str!("../../tests/golden/reference/prob-11.35-double-pendulum.json"))?;
    let p = |name| digits.parameter(name);
    let system = DoublePendulum { m1: p("m1")?, m2: p("m2")?, l1: p("l1")?, l2: p("l2")?, g: p("g")? };
    let [start, end] = digits.ends()?;
    let motion = format!("from ({}, {}) rad, {} s", start.q[0], start.q[1], end.t).replace('-', "−");
    Ok(Problem::new("Double pendulum", "double-pendulum", motion, system, [start, end], DIGITS))
}

/// Precession and nutation of a fast top: 30 digits from elsewhere.
pub fn top() -> Result<Problem<Top, 3>, Box<dyn Error>> {
    let digits = Digits::of(include_str!("../../tests/golden/reference/sec-11.12.4-symmetric-top.json"))?;
    let p = |name| digits.parameter(name);
    let system = Top { m: p("m")?, l: p("l")?, I1: p("I1")?, I3: p("I3")?, g: p("g")? };
    let [start, end] = digits.ends()?;
    let motion = format!("let go at {} rad with a spin of {} rad/s, {} s", start.q[1], start.qd[2], end.t);
    Ok(Problem::new("Heavy symmetric top", "top", motion, system, [start, end], DIGITS))
}

/// How the reference digits were computed; the README beside them says more.
const DIGITS: &str = "30 digits, by mpmath and a Taylor series of order 40";

/// A file of reference digits.
struct Digits(Value);

impl Digits {
    fn of(json: &str) -> Result<Self, Box<dyn Error>> {
        Ok(Digits(serde_json::from_str(json)?))
    }

    fn parameter(&self, name: &str) -> Result<f64, Box<dyn Error>> {
        self.0["params"][name].as_f64().ok_or_else(|| format!("no parameter {name}").into())
    }

    /// The start of its trajectory, and the end from 30 digits.
    fn ends<const N: usize>(&self) -> Result<[State<f64, N>; 2], Box<dyn Error>> {
        let motion = &self.0["trajectory"];
        let number = |value: &Value| match value {
            Value::String(digits) => digits.parse().ok(),
            other => other.as_f64(),
        };
        let state = |t: &str, q: &str, qd: &str| {
            let vector = |field: &str| -> Option<[f64; N]> {
                let entries: Option<Vec<f64>> = motion[field].as_array()?.iter().map(number).collect();
                entries?.try_into().ok()
            };
            Some(State::new(number(&motion[t])?, vector(q)?, vector(qd)?))
        };
        let start = state("t0", "q0", "qd0").ok_or("no start in the reference")?;
        let end = state("t_end", "q_end_str", "qd_end_str").ok_or("no end in the reference")?;
        Ok([start, end])
    }
}
