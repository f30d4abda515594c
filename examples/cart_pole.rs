//! A pole on a cart is swung up and balanced by a controller that sees encoders and sets a force a hundred times a
//! second.
//!
//! The world goes on in steps of a millisecond. Every ten of them the controller reads the two encoders, whose counts
//! are whole numbers, and sets the force that it computed one period before: it takes that long to think. It swings
//! the pole up by its energy (Åström and Furuta, *Automatica* 36, 2000), `a = k E θ̇ cos θ` with
//! `E = ½ m l² θ̇² + m g l (cos θ − 1)`, and catches it by a linear regulator. The gains of this one minimize
//! `Σ xᵀQ x + R u²` for the linear model at the top, from the exact derivatives of the emitted equations, with the
//! force held for a period and late by another.
//!
//! `cargo run --release --example cart_pole` draws angle, place and force, and an animation.

#[path = "support/checks.rs"]
mod checks;
#[path = "support/mod.rs"]
mod support;

use checks::Checks;
use lagrange_runtime::Stepper;
use lagrange_runtime::analysis::{DMatrix, StateSpace};
use lagrange_runtime::chart::{Animation, Axis, Chart, Panels, Part, Series};
use lagrange_runtime::prelude::*;
use std::error::Error;
use std::f64::consts::{PI, TAU};

lagrangian! {
    /// A pole on a cart; upright where theta is 0.
    pub system CartPole {
        /// Mass of the cart and of the bob of the pole, and the length of the pole.
        param cart = 1.0, bob = 0.2, l = 0.6, g = 9.81;
        /// Friction of the rails.
        param c = 0.1;
        /// Force of the drive.
        input force;
        coord x: length, theta: angle;
        let px = x + l * sin(theta);
        let py = l * cos(theta);
        T = 0.5 * cart * dot(x).powi(2) + 0.5 * bob * (dot(px).powi(2) + dot(py).powi(2));
        V = bob * g * py;
        D = 0.5 * c * dot(x).powi(2);
        Q[x] = force;
        observe tip = [px, py];
    }
}

/// Milliseconds.
const MILLI: f64 = 1e-3;
/// Period of the controller, in s.
const PERIOD: f64 = 0.01;
const END: f64 = 12.0;
/// Counts of the encoders: of the cart in m, of the pole in rad.
const COUNTS: [f64; 2] = [1e-4, TAU / 4096.0];
/// Largest force of the drive, in N.
const STRONGEST: f64 = 15.0;

/// Gains of `u = −K z` for the state z = (x, θ, ẋ, θ̇) and the force that is under way.
struct Regulator {
    gains: DMatrix<f64>,
    /// Magnitude of the slowest mode of the closed loop, over one period.
    slowest: f64,
}

impl Regulator {
    /// The gain, by iteration of the discrete Riccati equation `P = Q + Aᵀ P (A − B K)`, `K = (R + Bᵀ P B)⁻¹ Bᵀ P A`.
    fn of(system: &CartPole) -> Option<Self> {
        let model =
            StateSpace::about(system, &State::new(0.0, [0.0; 2], [0.0; 2])).ok()?.sampled(PERIOD).ok()?;
        // The force that is computed now is held in the next period.
        let mut a = DMatrix::zeros(5, 5);
        a.view_mut((0, 0), (4, 4)).copy_from(&model.a);
        a.view_mut((0, 4), (4, 1)).copy_from(&model.b);
        let b = DMatrix::from_fn(5, 1, |i, _| f64::from(i == 4));
        let weight = DMatrix::from_diagonal(&[20.0, 20.0, 1.0, 1.0, 0.0].to_vec().into());
        let (mut p, mut gains) = (weight.clone(), DMatrix::zeros(1, 5));
        for _ in 0..5000 {
            let inverse = (b.transpose() * &p * &b).add_scalar(0.1).try_inverse()?;
            let next = inverse * b.transpose() * &p * &a;
            p = &weight + a.transpose() * &p * (&a - &b * &next);
            let change = (&next - &gains).amax();
            gains = next;
            if change < 1e-12 * gains.amax() {
                break;
            }
        }
        let closed = a - b * &gains;
        let slowest = closed.complex_eigenvalues().iter().fold(0.0, |most: f64, z| most.max(z.norm()));
        Some(Regulator { gains, slowest })
    }
}

/// Memory of the controller: the counts of the last sampling instant, velocities from their differences, and the
/// force under way.
struct Controller {
    system: CartPole,
    regulator: Regulator,
    last: Option<[f64; 2]>,
    velocities: [f64; 2],
    pending: f64,
    /// Since when it has balanced the pole.
    caught: Option<f64>,
}

impl Controller {
    /// The force for the period that begins.
    fn force(&mut self, state: &State<f64, 2>) -> f64 {
        let counted: [f64; 2] = std::array::from_fn(|i| (state.q[i] / COUNTS[i]).round() * COUNTS[i]);
        let last = self.last.replace(counted).unwrap_or(counted);
        for i in 0..2 {
            self.velocities[i] += 0.6 * ((counted[i] - last[i]) / PERIOD - self.velocities[i]);
        }
        let force = self.pending;
        let wanted = self.control_law(state.t, counted, self.velocities, force);
        self.pending = wanted.clamp(-STRONGEST, STRONGEST);
        force
    }

    fn control_law(&mut self, t: f64, [x, theta]: [f64; 2], [v, w]: [f64; 2], force: f64) -> f64 {
        let CartPole { cart, bob: m, l, g, c, .. } = self.system;
        let theta = lagrange_runtime::wrapped_angle(theta);
        if theta.abs() < 0.3 && w.abs() < 3.0 {
            self.caught.get_or_insert(t);
            let z = DMatrix::from_column_slice(5, 1, &[x, theta, v, w, force]);
            return -(&self.regulator.gains * z)[(0, 0)];
        }
        self.caught = None;
        let (sin, cos) = theta.sin_cos();
        let energy = 0.5 * m * (l * w).powi(2) + m * g * l * (cos - 1.0);
        // A pole that hangs still is pushed.
        let push = if t < 0.3 && w.abs() < 0.05 { 4.0 } else { (12.0 * energy * w * cos).clamp(-4.0, 4.0) };
        let a = push - 2.0 * x - 1.5 * v;
        // The force that gives the cart this acceleration.
        (cart + m * sin * sin) * a + m * g * sin * cos - m * l * w * w * sin + c * v
    }
}

pub(crate) fn main() -> Result<(), Box<dyn Error>> {
    let system = CartPole::new();
    let mut checks = Checks::default();

    // The linear model at the top, against its closed form.
    let top = State::new(0.0, [0.0; 2], [0.0; 2]);
    let model = StateSpace::about(&system, &top)?;
    let CartPole { cart, bob, l, g, c, .. } = system;
    let fall = (cart + bob) * g / (cart * l);
    let exact = [[0.0, -bob * g / cart, -c / cart, 0.0], [0.0, fall, c / (cart * l), 0.0]];
    let rows = (0..2).flat_map(|i| (0..4).map(move |j| (i, j)));
    let error = rows.map(|(i, j)| (model.a[(2 + i, j)] - exact[i][j]).abs()).fold(0.0, f64::max);
    let drive = (model.b[(2, 0)] - 1.0 / cart).abs().max((model.b[(3, 0)] + 1.0 / (cart * l)).abs());
    checks.at_most("A and B at the top against their closed form", error.max(drive), 1e-14);
    let regulator = Regulator::of(&system).ok_or("the Riccati equation has no solution")?;
    checks.at_most("slowest mode of the closed loop, per period", regulator.slowest, 0.99);

    let mut controller =
        Controller { system, regulator, last: None, velocities: [0.0; 2], pending: 0.0, caught: None };
    let start = State::new(0.0, [0.0, PI], [0.0; 2]);
    let mut calls = 0;
    let mut stepper =
        Stepper::new(system, Dop853, PiController::tolerance(1e-9), start).every(PERIOD, |state, u| {
            calls += 1;
            u[0] = controller.force(state);
        });
    let mut motion = vec![(start, 0.0)];
    for k in 1..=(END / MILLI).round() as u32 {
        stepper.advance_to(f64::from(k) * MILLI)?;
        motion.push((*stepper.state(), stepper.inputs()[0]));
    }
    let statistics = stepper.statistics();
    println!("{} steps, {} evaluations", statistics.accepted, statistics.evaluations);

    checks.holds("one call of the controller each period", calls == 1201);
    checks.at_most("steps a millisecond", statistics.accepted as f64 / 12_000.0, 1.001);
    checks.at_most("caught after (s)", controller.caught.unwrap_or(f64::NAN), 6.0);
    let late = || motion.iter().filter(|(s, _)| s.t > END - 2.0);
    let most = |of: fn(&State<f64, 2>) -> f64| late().map(|(s, _)| of(s).abs()).fold(0.0, f64::max);
    checks.at_most("angle in the last two seconds (counts)", most(|s| s.q[1].sin()) / COUNTS[1], 3.0);
    checks.at_most("place in the last two seconds (m)", most(|s| s.q[0]), 5e-3);
    checks.at_most("length of rail (m)", motion.iter().map(|(s, _)| s.q[0].abs()).fold(0.0, f64::max), 1.0);
    checks.at_most("force (N)", motion.iter().map(|(_, u)| u.abs()).fold(0.0, f64::max), STRONGEST);
    let held = motion.chunks(10).all(|period| period.iter().all(|(_, u)| *u == period[0].1));
    checks.holds("the force is held for ten milliseconds", held);

    let time = || Axis::linear("time", "s");
    let every = || motion.iter().step_by(10);
    let angle = Chart::new("Angle of the pole", time(), Axis::linear("from the top", "rad"))
        .with(Series::line("angle", every().map(|(s, _)| (s.t, s.q[1]))));
    let place = Chart::new("Cart", time(), Axis::linear("place", "m"))
        .with(Series::line("place", every().map(|(s, _)| (s.t, s.q[0]))));
    let force = Chart::new("Drive", time(), Axis::linear("force", "N"))
        .with(Series::line("force", every().map(|(s, u)| (s.t, *u))));
    let folder = support::charts()?;
    Panels::new("A pole is swung up and balanced", [angle, place, force])
        .subtitle("encoders of 4096 counts; a force set every 10 ms, one period late")
        .write(&folder, "cart-pole")?;
    animation(&system, &motion).write(&folder, "cart-pole-moving")?;
    println!("{}", folder.join("cart-pole.svg").display());
    println!("{}", folder.join("cart-pole-moving.svg").display());
    Ok(checks.report()?)
}

/// The cart and its pole.
fn animation(system: &CartPole, motion: &[(State<f64, 2>, f64)]) -> Animation {
    let frames: Vec<[(f64, f64); 2]> = motion
        .iter()
        .step_by(40)
        .map(|(s, _)| {
            let tip = system.tip_at(s);
            [(s.q[0], 0.0), (tip[0], tip[1])]
        })
        .collect();
    let cart = frames.iter().map(|[(x, _), _]| {
        [(-0.12, -0.06), (0.12, -0.06), (0.12, 0.06), (-0.12, 0.06)].map(|(dx, y)| (x + dx, y)).to_vec()
    });
    let path = motion.iter().step_by(20).map(|(s, _)| {
        let tip = system.tip_at(s);
        (tip[0], tip[1])
    });
    Animation::new("A pole is swung up and balanced", END)
        .subtitle("a force set every 10 ms, from encoders of 4096 counts")
        .with(Part::path("path of the bob", path).colour(6))
        .with(Part::path("rail", [(-1.0, -0.06), (1.0, -0.06)]).width(2.0).colour(7))
        .with(Part::body("cart", cart).width(2.0).colour(7))
        .with(Part::bars("pole", frames.iter().map(|at| at.to_vec())).width(3.0).colour(0))
        .with(Part::joints("bob", frames.iter().map(|at| vec![at[1]])).width(13.0).colour(1))
}
