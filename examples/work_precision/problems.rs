//! Where each motion starts, and where it ends to the last digit.

use crate::digits::Digits;
use crate::systems::{
    Chain, DoublePendulum, DrivenPendulum, HenonHeiles, Kepler, LINKS, Pendulum, PolarKepler, SpringPendulum,
    Top,
};
use lagrange_runtime::DoubleDouble;
use lagrange_runtime::prelude::*;
use lagrange_runtime::reference::{KeplerOrbit, LinearChain, SeriesMotion, SimplePendulum};
use std::error::Error;
use std::f64::consts::{PI, TAU};

/// What [`Problem::error`] is, for the axes of charts.
pub const ERROR: &str = "error: largest |Δq|/max|q|, |Δq̇|/max|q̇|";

/// A motion with a known end.
pub struct Problem<Sys, const N: usize> {
    pub name: &'static str,
    /// Name of its files, and on the command line.
    pub stem: &'static str,
    /// In words.
    pub motion: String,
    pub system: Sys,
    pub start: State<f64, N>,
    /// The exact state at the end, rounded.
    pub end: State<f64, N>,
    /// Where `end` is from.
    pub reference: &'static str,
    /// For long runs, if there is something to keep.
    pub long: Option<Long<Sys, N>>,
    /// The largest |qₖ| and |q̇ₖ| along the motion: units for the error. A few digits of them are enough.
    size: State<f64, N>,
}

/// A motion to be followed for many periods, with what it keeps.
pub struct Long<Sys, const N: usize> {
    /// The time that is called one period.
    pub period: f64,
    /// What that time is, in words.
    pub clock: &'static str,
    /// The evaluations of the right-hand side that each method may have in a period.
    pub evaluations: f64,
    /// Decades of periods, unless more are asked for.
    pub decades: u32,
    pub invariants: Vec<Invariant<Sys, N>>,
}

/// A function of the state that the motion keeps.
pub struct Invariant<Sys, const N: usize> {
    pub name: String,
    /// Part of a file name.
    pub stem: String,
    pub value: Value<Sys, N>,
}

type Value<Sys, const N: usize> = Box<dyn Fn(&Sys, &State<f64, N>) -> f64>;

/// A system, and the same over [`DoubleDouble`].
macro_rules! twice {
    ($system:expr) => {
        ($system, $system.map(DoubleDouble::from))
    };
}

/// How far an end may be from that by Taylor series in double-double, as [`Problem::error`]: both are rounded.
const ROUNDING: f64 = f64::EPSILON;

impl<Sys: System<N, Scalar = f64>, const N: usize> Problem<Sys, N> {
    /// A motion from its start to its exact end, which is known by what `reference` says. Taylor series in double-double have to lead
    /// there as well.
    fn new(
        name: &'static str,
        stem: &'static str,
        motion: String,
        (system, over_double_double): (Sys, impl Analytic<N, Scalar = DoubleDouble>),
        [start, end]: [State<f64, N>; 2],
        reference: &'static str,
    ) -> Result<Self, Box<dyn Error>> {
        let mut size = State { t: 0.0, q: start.q.abs(), qd: start.qd.abs() };
        for step in integrate(&system, Dop853, Pi::tolerance(1e-6), start).until(end.t).flatten() {
            size.q = size.q.sup(&step.to.q.abs());
            size.qd = size.qd.sup(&step.to.qd.abs());
        }
        let problem = Problem { name, stem, motion, system, start, end, reference, long: None, size };
        let apart = problem.error(&SeriesMotion::new(over_double_double, start).state(end.t)?);
        if apart <= ROUNDING {
            Ok(problem)
        } else {
            Err(format!("{name}: {reference}, and Taylor series in double-double, are {apart:e} apart")
                .into())
        }
    }
}

impl<Sys: Conservative<N, Scalar = f64>, const N: usize> Problem<Sys, N> {
    /// With long runs, in which energy and the momenta of ignorable coordinates are watched.
    fn long(mut self, clock: &'static str, period: f64, evaluations: f64, decades: u32) -> Self {
        let energy: Value<Sys, N> = Box::new(|system, at| system.jacobi(&at.q, &at.qd, at.t));
        let energy = Invariant { name: "energy".into(), stem: "energy".into(), value: energy };
        let momenta = Sys::FACTS.ignorable.iter().map(|&k| {
            let coordinate = Sys::FACTS.coordinates[k];
            let value: Value<Sys, N> = Box::new(move |system, at| system.momenta(&at.q, &at.qd, at.t)[k]);
            Invariant { name: format!("momentum p_{coordinate}"), stem: format!("p-{coordinate}"), value }
        });
        let invariants = std::iter::once(energy).chain(momenta).collect();
        self.long = Some(Long { period, clock, evaluations, decades, invariants });
        self
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
pub fn pendulum() -> Result<Problem<Pendulum, 1>, Box<dyn Error>> {
    let system = Pendulum::new(1.0, 0.85);
    let (angle, t) = (2.0, 20.0);
    let exact = SimplePendulum::new(system.g, system.l, angle, 0.0);
    let (theta, thetad) = exact.state(t);
    let problem = Problem::new(
        "Simple pendulum",
        "pendulum",
        format!("from {angle} rad at rest, {:.1} periods", t / exact.period()),
        twice!(system),
        [State::new(0.0, [angle], [0.0]), State::new(t, [theta], [thetad])],
        "closed form by Jacobi's elliptic functions",
    )?;
    Ok(problem.long("its own", exact.period(), 480.0, 5))
}

const KEPLER: &str = "closed form by Kepler's equation";

/// In closed form, by Kepler's equation.
pub fn kepler() -> Result<Problem<Kepler, 2>, Box<dyn Error>> {
    // From the pericentre of an ellipse with semi-major axis 1: x = 1 − e, ẏ = √((1 + e)/(1 − e)).
    let (q, qd) = ([0.4, 0.0], [0.0, 2.0]);
    let orbit = KeplerOrbit::from_cartesian(1.0, q, qd).ok_or("not an ellipse")?;
    let mut problem = ellipse("Kepler problem, e = 0.6", "kepler", &orbit, (q, qd), 30.0)?.long(
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

/// As [`kepler`], on a long ellipse: the speed at the pericentre is 39 times that at the apocentre.
pub fn eccentric() -> Result<Problem<Kepler, 2>, Box<dyn Error>> {
    let (q, qd) = ([0.05, 0.0], [0.0, 39f64.sqrt()]);
    let orbit = KeplerOrbit::from_cartesian(1.0, q, qd).ok_or("not an ellipse")?;
    ellipse("Kepler problem, e = 0.95", "kepler-eccentric", &orbit, (q, qd), 20.0)
}

fn ellipse(
    name: &'static str,
    stem: &'static str,
    orbit: &KeplerOrbit,
    (q, qd): ([f64; 2], [f64; 2]),
    t: f64,
) -> Result<Problem<Kepler, 2>, Box<dyn Error>> {
    let (q_end, qd_end) = orbit.cartesian(t);
    Problem::new(
        name,
        stem,
        format!("Cartesian coordinates, from the pericentre, {:.1} revolutions", t / orbit.period()),
        twice!(Kepler::new(1.0)),
        [State::new(0.0, q, qd), State::new(t, q_end, qd_end)],
        KEPLER,
    )
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
        twice!(system),
        [State::new(0.0, q, qd), State::new(t, q_end, qd_end)],
        KEPLER,
    )?;
    Ok(problem.long("one revolution", orbit.period(), 960.0, 3))
}

/// How the digits beside the golden tests were computed; the README there says more.
const GOLDEN: &str = "30 digits, by Taylor series of order 40 (tests/golden/reference)";

/// How the digits of this example were computed: `benches/references/atlas.py`.
const ATLAS: &str =
    "30 digits, by Taylor series of order 44 and by extrapolation (benches/references/atlas.py)";

/// Chaotic, without a closed form.
pub fn double_pendulum() -> Result<Problem<DoublePendulum, 2>, Box<dyn Error>> {
    let digits = Digits::of(include_str!("../../tests/golden/reference/prob-11.35-double-pendulum.json"))?;
    let p = |name| digits.parameter(name);
    let system = DoublePendulum { m1: p("m1")?, m2: p("m2")?, l1: p("l1")?, l2: p("l2")?, g: p("g")? };
    let [start, end] = digits.ends()?;
    let motion = format!("from ({}, {}) rad, {} s", start.q[0], start.q[1], end.t).replace('-', "−");
    let swing = TAU * (system.l1 / system.g).sqrt();
    let problem =
        Problem::new("Double pendulum", "double-pendulum", motion, twice!(system), [start, end], GOLDEN)?;
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
    let problem = Problem::new("Heavy symmetric top", "top", motion, twice!(system), [start, end], GOLDEN)?;
    Ok(problem.long("nutation of a fast top, 2πI₁/(I₃ψ̇)", nutation, 480.0, 3))
}

pub fn henon_heiles() -> Result<Problem<HenonHeiles, 2>, Box<dyn Error>> {
    let digits = Digits::of(include_str!("reference/henon-heiles.json"))?;
    let system = HenonHeiles { lambda: digits.parameter("lambda")? };
    let [start, end] = digits.ends()?;
    let energy = system.jacobi(&start.q, &start.qd, start.t);
    let motion = format!("energy {energy:.3}, {:.1} small oscillations", end.t / TAU);
    let problem = Problem::new("Hénon–Heiles", "henon-heiles", motion, twice!(system), [start, end], ATLAS)?;
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
    Problem::new("Stiff spring pendulum", "spring-pendulum", motion, twice!(system), [start, end], ATLAS)
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
    Problem::new("Driven damped pendulum", "driven-pendulum", motion, twice!(system), [start, end], ATLAS)
}

/// In closed form, by normal modes.
pub fn chain() -> Result<Problem<Chain, LINKS>, Box<dyn Error>> {
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
        twice!(system),
        [State::new(0.0, q, qd), State::new(t, q_end, qd_end)],
        "closed form by normal modes",
    )?;
    Ok(problem.long("the slowest mode", period, 960.0, 3))
}
