//! A chain of 32 links on a cart that runs without friction, let go from a bent shape: the cost of a link, and two
//! families of methods on a motion that keeps energy and horizontal momentum.
//!
//! Written link by link, the accelerations cost a number of operations proportional to the number of links. The small
//! vibrations are known in closed form: with equal beads m at equal distances l the amplitudes are Laguerre
//! polynomials, and with a cart μ m the frequencies ω² = s g/l are the roots of s (L′ₙ(s) − μ Lₙ(s)).
//!
//! The chain cracks like a whip, when its end turns over, and what is lost is lost there. DOP853 shortens its steps
//! for that and comes off best here, although Gauss methods are symplectic: equal steps would have to be as short
//! everywhere.
//!
//! `cargo run --release --example chain_on_a_cart` draws the motion, and the error of energy against time.

#[path = "support/checks.rs"]
mod checks;
#[path = "support/mod.rs"]
mod support;

use checks::{Checks, table};
use lagrange_runtime::analysis::small_vibrations;
use lagrange_runtime::chart::{Animation, Axis, Chart, Part, Series};
use lagrange_runtime::prelude::*;
use lagrange_runtime::{Controller, Statistics};
use std::error::Error;

lagrangian! {
    /// A cart on a level rail, and N links hanging from it with a bead at the end of each; θ from the vertical.
    pub system Chain {
        const N = 32;
        /// Mass of the cart.
        param M;
        /// Masses of the beads and lengths of the links, from the cart on.
        param m: [N], l: [N];
        param g = 9.81;
        coord s: length, theta: [angle; N];
        let x: [N] = |i| (if i == 0 { s } else { x[i - 1] }) + l[i] * theta[i].sin();
        let y: [N] = |i| (if i == 0 { 0 } else { y[i - 1] }) - l[i] * theta[i].cos();
        T = 0.5 * M * dot(s).powi(2) + (0..N).map(|i| 0.5 * m[i] * (dot(x[i]).powi(2) + dot(y[i]).powi(2))).sum();
        V = (0..N).map(|i| m[i] * g * y[i]).sum();
        observe across = x;
        observe up = y;
        observe centre = (M * s + (0..N).map(|i| m[i] * x[i]).sum()) / (M + (0..N).map(|i| m[i]).sum());
    }
}

const LINKS: usize = 32;
/// Coordinates.
const DIM: usize = LINKS + 1;
/// Seconds.
const END: f64 = 5.0;
/// Frames of the animation.
const FRAMES: u32 = 150;

/// Outcome of a run: the largest errors, by steps and on the whole.
struct Outcome {
    method: &'static str,
    cost: Statistics,
    /// (time, error of energy) in parts of the energy that the chain can lose.
    energy: Vec<(f64, f64)>,
    momentum: f64,
    centre: f64,
}

impl Outcome {
    fn of<M: Method<Chain, DIM>, C: Controller<f64, DIM, M::Error>>(
        name: &'static str,
        chain: &Chain,
        method: M,
        controller: C,
    ) -> Result<Self, Failure> {
        let start = start();
        let energy = |at: &State<f64, DIM>| chain.energy_at(at);
        let hanging = State::new(0.0, [0.0; DIM], [0.0; DIM]);
        let (first, fall) = (energy(&start), energy(&start) - energy(&hanging));
        let mut run = integrate(chain, method, controller, start).until(END);
        let mut outcome =
            Outcome { method: name, cost: run.statistics(), energy: Vec::new(), momentum: 0.0, centre: 0.0 };
        for step in &mut run {
            let State { t, q, qd } = step?.to;
            let error = (chain.energy(&q, &qd, t) - first).abs() / fall;
            outcome.energy.push((t, error));
            outcome.momentum = outcome.momentum.max(chain.momenta(&q, &qd, t)[0].abs());
            outcome.centre = outcome.centre.max((centre(chain, &q) - centre(chain, &start.q)).abs());
        }
        outcome.cost = run.statistics();
        Ok(outcome)
    }

    fn worst(&self) -> f64 {
        self.energy.iter().map(|(_, error)| *error).fold(0.0, f64::max)
    }
}

fn centre(chain: &Chain, q: &SVector<f64, DIM>) -> f64 {
    chain.centre(q, &SVector::zeros(), 0.0)
}

/// At rest, curled up to one side.
fn start() -> State<f64, DIM> {
    let mut q = [0.0; DIM];
    for i in 0..LINKS {
        q[1 + i] = 0.5 + 2.6 * i as f64 / (LINKS - 1) as f64;
    }
    State::new(0.0, q, [0.0; DIM])
}

/// Cart, then the beads.
fn points(chain: &Chain, at: &State<f64, DIM>) -> Vec<(f64, f64)> {
    let (x, y) = (chain.across_at(at), chain.up_at(at));
    std::iter::once((at.q[0], 0.0)).chain(x.iter().copied().zip(y.iter().copied())).collect()
}

/// Relative distance of s from a root of L′ₙ(s) − μ Lₙ(s), by one step of Newton's iteration. The derivatives
/// follow from s L′ₙ = n (Lₙ − Lₙ₋₁) and s L″ₙ = (s − 1) L′ₙ − n Lₙ (Abramowitz and Stegun 1964, 22.8.6, 22.6.15).
fn off(s: f64, mu: f64) -> f64 {
    let n = LINKS as f64;
    let (mut before, mut value) = (1.0, 1.0 - s);
    for k in 1..LINKS {
        let k = k as f64;
        (before, value) = (value, ((2.0 * k + 1.0 - s) * value - k * before) / (k + 1.0));
    }
    let slope = n * (value - before) / s;
    let bend = ((s - 1.0) * slope - n * value) / s;
    ((slope - mu * value) / (s * (bend - mu * slope))).abs()
}

pub(crate) fn main() -> Result<(), Box<dyn Error>> {
    let (mass, length) = (0.05, 0.1);
    let chain = Chain::new(1.0, [mass; LINKS], [length; LINKS]);
    let mut checks = Checks::default();

    let facts = Chain::<f64>::FACTS;
    let operations = facts.operations.arithmetic();
    println!(
        "{LINKS} links on a cart: {operations} operations and {} sine-cosine pairs, {:.1} operations a link",
        facts.operations.sin_cos,
        operations as f64 / LINKS as f64
    );
    checks.at_most("operations a link", operations as f64 / LINKS as f64, 25.5);
    checks.holds("the compiler knows that the momentum along the rail is kept", facts.ignorable == [0]);

    let modes = small_vibrations(&chain, &[0.0; DIM])?.modes()?;
    let roots = modes.squares()[1..].iter().map(|omega2| off(omega2 * length / chain.g, chain.M / mass));
    checks.at_most("small vibrations: s against roots of L′ₙ − μ Lₙ", roots.fold(0.0, f64::max), 1e-11);

    let outcomes = [
        Outcome::of("DOP853, tolerance 1e-6", &chain, Dop853, PiController::tolerance(1e-6))?,
        Outcome::of("DOP853, tolerance 1e-9", &chain, Dop853, PiController::tolerance(1e-9))?,
        Outcome::of("DOP853, tolerance 1e-12", &chain, Dop853, PiController::tolerance(1e-12))?,
        Outcome::of("implicit midpoint, 2 ms", &chain, ImplicitMidpoint, FixedStep::new(2e-3))?,
        Outcome::of("Gauss 4, 2 ms", &chain, Gauss4, FixedStep::new(2e-3))?,
        Outcome::of("Gauss 6, 2 ms", &chain, Gauss6, FixedStep::new(2e-3))?,
    ];
    println!(
        "{}",
        table(
            ["method", "steps", "evaluations", "energy", "momentum (N s)", "centre (m)"],
            outcomes.iter().map(|o| [
                o.method.to_owned(),
                o.cost.accepted.to_string(),
                o.cost.evaluations.to_string(),
                format!("{:.1e}", o.worst()),
                format!("{:.1e}", o.momentum),
                format!("{:.1e}", o.centre),
            ])
        )
    );

    let folder = support::charts()?;
    let mut errors = Chart::new(
        "A chain of 32 links on a cart",
        Axis::linear("time", "s"),
        Axis::log("error of energy", ""),
    )
    .subtitle("in parts of the energy that the chain has to lose; released from rest, curled up");
    for outcome in &outcomes {
        errors = errors.with(Series::line(outcome.method, outcome.energy.iter().copied()));
    }
    errors.write(&folder, "chain-on-a-cart-energy")?;

    let run = integrate(&chain, Dop853, PiController::tolerance(1e-10), start()).until(END);
    let fine = run.sample_evenly(8 * FRAMES).collect::<Result<Vec<_>, _>>()?;
    let path = fine.iter().map(|at| points(&chain, at)[LINKS]);
    let states: Vec<_> = fine.iter().step_by(8).collect();
    let beads: Vec<Vec<(f64, f64)>> = states.iter().map(|at| points(&chain, at)).collect();
    let cart = states.iter().map(|at| {
        let corner = |(x, y)| (at.q[0] + 0.16 * x, 0.07 * y);
        [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(corner).to_vec()
    });
    let wheels = states.iter().map(|at| vec![(at.q[0] - 0.1, -0.1), (at.q[0] + 0.1, -0.1)]);
    let span = |pick: fn(f64, f64) -> f64| states.iter().map(|at| at.q[0]).fold(0.0, pick);
    let rail = [(span(f64::min) - 0.4, -0.13), (span(f64::max) + 0.4, -0.13)];
    Animation::new("A chain of 32 links on a cart", END)
        .subtitle("released from rest; cart 1 kg, beads 50 g, links 10 cm, no friction; grey: the path of the last bead")
        .with(Part::path("path of the last bead", path))
        .with(Part::path("rail", rail).width(2.0).colour(7))
        .with(Part::joints("wheels", wheels).width(13.0).colour(7))
        .with(Part::body("cart", cart).width(2.0).colour(7))
        .with(Part::bars("links", beads.clone()).width(2.5))
        .with(Part::joints("beads", beads.iter().map(|at| at[1..].to_vec())).width(7.0).colour(1))
        .write(&folder, "chain-on-a-cart")?;
    for name in ["chain-on-a-cart.svg", "chain-on-a-cart-energy.svg"] {
        println!("{}", folder.join(name).display());
    }

    let [_, _, tight, symplectic @ ..] = &outcomes;
    checks.at_most("energy by DOP853 at 1e-12", tight.worst(), 1e-11);
    checks.at_most("momentum by DOP853 at 1e-12 (N s)", tight.momentum, 1e-11);
    checks.at_most("centre of mass by DOP853 at 1e-12 (m)", tight.centre, 1e-11);
    // Symplectic methods keep a momentum to rounding at any step.
    let momentum = symplectic.iter().map(|outcome| outcome.momentum).fold(0.0, f64::max);
    checks.at_most("momentum by the symplectic methods (N s)", momentum, 5e-12);
    checks.at_most("energy by Gauss 6", symplectic[2].worst(), 1e-5);
    Ok(checks.report()?)
}
