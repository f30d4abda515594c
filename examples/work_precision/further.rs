//! The further motions of the atlas: each system as a user writes it, and where its motion starts and exactly ends.

use crate::digits::Digits;
use crate::known::{KEPLER, Kepler, ellipse};
use crate::problems::Problem;
use lagrange_runtime::prelude::*;
use lagrange_runtime::testing::reference::{KeplerOrbit, LinearChain};
use std::error::Error;
use std::f64::consts::{PI, TAU};

lagrangian! {
    /// The same in polar coordinates. The inertia r² of φ depends on r, so it is not separable, but φ is ignorable.
    pub system PolarKepler {
        param mu;
        coord r, phi;
        T = 0.5 * (dot(r).powi(2) + (r * dot(phi)).powi(2));
        V = -mu / r;
    }
}

lagrangian! {
    /// A star in a galaxy's meridian plane (Hénon and Heiles, Astronomical Journal 69, 1964, 73).
    pub system HenonHeiles {
        param lambda;
        coord x, y;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = 0.5 * (x.powi(2) + y.powi(2)) + lambda * (x.powi(2) * y - y.powi(3) / 3);
    }
}

lagrangian! {
    /// A bob on a spring.
    pub system SpringPendulum {
        param m, k, l, g;
        coord x, y;
        let r = (x.powi(2) + y.powi(2)).sqrt();
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
        V = 0.5 * k * (r - l).powi(2) + m * g * y;
    }
}

lagrangian! {
    /// A pendulum with friction in its pivot, and a torque on it.
    pub system DrivenPendulum {
        param m, l, g, c, a, omega;
        coord theta;
        T = 0.5 * m * (l * dot(theta)).powi(2);
        V = -m * g * l * cos(theta);
        D = 0.5 * c * dot(theta).powi(2);
        Q[theta] = a * cos(omega * t);
    }
}

/// Masses of the chain.
pub const LINKS: usize = 8;

lagrangian! {
    /// Equal masses in a row between two walls, joined by equal springs.
    pub system Chain {
        const N = 8;
        param m, k;
        coord x: [N];
        T = (0..N).map(|i| 0.5 * m * dot(x[i]).powi(2)).sum();
        V = 0.5 * k * (x[0].powi(2) + x[N - 1].powi(2) + (1..N).map(|i| (x[i] - x[i - 1]).powi(2)).sum());
    }
}

/// The source of the digits of this example: `benches/references/atlas.py` computed them.
const ATLAS: &str =
    "30 digits, by Taylor series of order 44 and by extrapolation (benches/references/atlas.py)";

/// Variant of [`kepler`] on a long ellipse: the speed at the pericentre is 39 times that at the apocentre.
pub fn eccentric() -> Result<Problem<Kepler, 2>, Box<dyn Error>> {
    let (q, qd) = ([0.05, 0.0], [0.0, 39f64.sqrt()]);
    let orbit = KeplerOrbit::from_cartesian(1.0, q, qd).ok_or("not an ellipse")?;
    Ok(ellipse("Kepler problem, e = 0.95", "kepler-eccentric", &orbit, (q, qd), 20.0))
}

/// The motion of [`kepler`], in coordinates of which one is ignorable.
pub fn polar_kepler() -> Result<Problem<PolarKepler, 2>, Box<dyn Error>> {
    let system = PolarKepler::new(1.0);
    let (q, qd) = ([0.4, 0.0], [0.0, 5.0]);
    let orbit = KeplerOrbit::new(system.mu, q, qd).ok_or("not an ellipse")?;
    let t = 30.0;
    let (q_end, qd_end) = orbit.state(t);
    let problem = Problem::new(
        "Kepler problem, e = 0.6, polar",
        "kepler-polar",
        format!("polar coordinates, from the pericentre, {:.1} revolutions", t / orbit.period()),
        system,
        [State::new(0.0, q, qd), State::new(t, q_end, qd_end)],
        KEPLER,
    );
    Ok(problem.long("one revolution", orbit.period(), 960.0, 3))
}

pub fn henon_heiles() -> Result<Problem<HenonHeiles, 2>, Box<dyn Error>> {
    let digits = Digits::of(include_str!("reference/henon-heiles.json"))?;
    let system = HenonHeiles { lambda: digits.parameter("lambda")? };
    let [start, end] = digits.ends()?;
    let energy = system.energy_function_at(&start);
    let motion = format!("energy {energy:.3}, {:.1} small oscillations", end.t / TAU);
    let problem = Problem::new("Hénon–Heiles", "henon-heiles", motion, system, [start, end], ATLAS);
    Ok(problem.long("a small oscillation", TAU, 480.0, 3))
}

/// Stiff: the spring could vibrate a thousand times as fast as the bob swings, but does not.
pub fn spring_pendulum() -> Result<Problem<SpringPendulum, 2>, Box<dyn Error>> {
    let digits = Digits::of(include_str!("reference/spring-pendulum.json"))?;
    let p = |name| digits.parameter(name);
    let system = SpringPendulum { m: p("m")?, k: p("k")?, l: p("l")?, g: p("g")? };
    let [start, end] = digits.ends()?;
    let vibrations = end.t * (system.k / system.m).sqrt() / TAU;
    let motion = format!(
        "kl/mg = {:.0e}, from 1 rad at rest with the spring in balance, {} s or {vibrations:.0} periods of the spring",
        system.k * system.l / (system.m * system.g),
        end.t
    );
    Ok(Problem::new("Stiff spring pendulum", "spring-pendulum", motion, system, [start, end], ATLAS))
}

pub fn driven_pendulum() -> Result<Problem<DrivenPendulum, 1>, Box<dyn Error>> {
    let digits = Digits::of(include_str!("reference/driven-pendulum.json"))?;
    let p = |name| digits.parameter(name);
    let system =
        DrivenPendulum { m: p("m")?, l: p("l")?, g: p("g")?, c: p("c")?, a: p("a")?, omega: p("omega")? };
    let [start, end] = digits.ends()?;
    let motion = format!(
        "c = {}, torque {} cos(2t/3), from {} rad at rest, {:.1} periods of the torque",
        system.c,
        system.a,
        start.q[0],
        end.t * system.omega / TAU
    );
    Ok(Problem::new("Driven damped pendulum", "driven-pendulum", motion, system, [start, end], ATLAS))
}

/// In closed form, by normal modes.
pub fn chain() -> Problem<Chain, LINKS> {
    let system = Chain::new(1.0, 1.0);
    let (mut q, qd) = ([0.0; LINKS], [0.0; LINKS]);
    (q[0], q[1]) = (1.0, 0.5);
    let t = 60.0;
    let (q_end, qd_end) = LinearChain::new(system.m, system.k, q, qd).state(t);
    let period = PI / (system.k / system.m).sqrt() / (0.5 * PI / (LINKS as f64 + 1.0)).sin();
    let problem = Problem::new(
        "Linear chain",
        "chain",
        format!(
            "{LINKS} masses between walls, two of them let go, {:.1} periods of the slowest mode",
            t / period
        ),
        system,
        [State::new(0.0, q, qd), State::new(t, q_end, qd_end)],
        "closed form by normal modes",
    );
    problem.long("the slowest mode", period, 960.0, 3)
}
