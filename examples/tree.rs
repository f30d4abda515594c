//! A mobile of 31 links in five tiers: a binary tree, whose accelerations cost a number of operations proportional to
//! the number of links, as those of a chain do; more, since a link carries others at both ends of its crossbar.
//! Pulled aside and let go, it comes to rest by the friction in its hinges, which turns into heat what energy it
//! loses.
//!
//! `cargo run --release --example tree` draws the motion, and where the energy goes.

#[path = "support/checks.rs"]
mod checks;
#[path = "support/mod.rs"]
mod support;

use checks::{Checks, table};
use lagrange_runtime::chart::{Animation, Axis, Chart, Part, Series};
use lagrange_runtime::prelude::*;
use std::error::Error;

lagrangian! {
    /// Link i is a T upside down: it hangs from an end of the crossbar of link (i − 1)/2 and carries a mass where its
    /// own crossbar begins. θ from the vertical.
    pub system Mobile {
        const N = 31;
        const FORKS = 15;
        /// Masses, lengths of the links, friction in their hinges.
        param m: [N], l: [N], c: [N];
        /// Half the length of the crossbars.
        param w: [FORKS];
        param g = 9.81;
        coord theta: [angle; N];
        let x: [N] = |i| l[i] * theta[i].sin() + if i == 0 { 0 } else {
            let side = if i % 2 == 1 { -1 } else { 1 };
            x[(i - 1) / 2] + side * w[(i - 1) / 2] * theta[(i - 1) / 2].cos()
        };
        let y: [N] = |i| -l[i] * theta[i].cos() + if i == 0 { 0 } else {
            let side = if i % 2 == 1 { -1 } else { 1 };
            y[(i - 1) / 2] + side * w[(i - 1) / 2] * theta[(i - 1) / 2].sin()
        };
        T = (0..N).map(|i| 0.5 * m[i] * (dot(x[i]).powi(2) + dot(y[i]).powi(2))).sum();
        V = (0..N).map(|i| m[i] * g * y[i]).sum();
        D = (0..N).map(|i| {
            let bend = if i == 0 { theta[0] } else { theta[i] - theta[(i - 1) / 2] };
            0.5 * c[i] * dot(bend).powi(2)
        }).sum();
        observe across = x;
        observe up = y;
    }
}

const N: usize = 31;
const FORKS: usize = 15;
/// Seconds.
const END: f64 = 16.0;

/// Tiers have 1, 2, 4, 8 and 16 links.
fn tier(i: usize) -> usize {
    (i + 1).ilog2() as usize
}

fn mobile() -> Mobile {
    let mass = |i| [0.4, 0.2, 0.1, 0.1, 0.1][tier(i)];
    let length = |i| [0.5, 0.42, 0.36, 0.3, 0.24][tier(i)];
    let friction = |i| [3.0, 0.5, 0.1, 0.02, 4e-3][tier(i)];
    let half = |i| [0.64, 0.32, 0.16, 0.08][tier(i)];
    use std::array::from_fn;
    Mobile::new(from_fn(mass), from_fn(length), from_fn(friction), from_fn(half))
}

/// Every link by itself: its hinge, its mass, and its crossbar if it has one, with gaps between the links.
fn bars(mobile: &Mobile, at: &State<f64, N>) -> Vec<(f64, f64)> {
    const GAP: (f64, f64) = (f64::NAN, f64::NAN);
    let mut points = Vec::new();
    for (i, (x, y)) in masses(mobile, at).into_iter().enumerate() {
        let (sin, cos) = at.q[i].sin_cos();
        points.extend([(x - mobile.l[i] * sin, y + mobile.l[i] * cos), (x, y), GAP]);
        if let Some(w) = mobile.w.get(i) {
            points.extend([(x - w * cos, y - w * sin), (x + w * cos, y + w * sin), GAP]);
        }
    }
    points
}

fn masses(mobile: &Mobile, at: &State<f64, N>) -> Vec<(f64, f64)> {
    let (x, y) = (mobile.across_at(at), mobile.up_at(at));
    x.iter().copied().zip(y.iter().copied()).collect()
}

/// Power of the friction, hinge by hinge.
fn heating(mobile: &Mobile, at: &State<f64, N>) -> f64 {
    let rate = |i: usize| if i == 0 { at.qd[0] } else { at.qd[i] - at.qd[(i - 1) / 2] };
    (0..N).map(|i| mobile.c[i] * rate(i).powi(2)).sum()
}

pub(crate) fn main() -> Result<(), Box<dyn Error>> {
    let mobile = mobile();
    let mut checks = Checks::default();
    let operations = Mobile::<f64>::FACTS.operations;
    let each = operations.arithmetic() as f64 / N as f64;
    println!(
        "{N} links: {} operations and {} sine-cosine pairs, {each:.1} operations a link",
        operations.arithmetic(),
        operations.sin_cos
    );
    checks.at_most("operations a link", each, 93.0);
    checks.holds("the compiler knows that energy is lost", !Mobile::<f64>::FACTS.conservative);

    // It is balanced: each crossbar carries as much on both sides.
    let hanging = State::new(0.0, [0.0; N], [0.0; N]);
    checks.at_most("acceleration at rest", mobile.accel(&hanging.q, &hanging.qd, 0.0).amax(), 1e-12);

    let start = State::new(0.0, [1.1; N], [0.0; N]);
    let lowest = mobile.energy_at(&hanging);
    let height = |at: &State<f64, N>| mobile.energy_at(at) - lowest;
    let mut run = integrate(&mobile, Dop853, PiController::tolerance(1e-11), start)
        .until(END)
        .integrals([0.0; 2], |at| [-mobile.power_at(at), heating(&mobile, at)]);
    let mut balance = vec![(0.0, height(&start), 0.0)];
    let (mut worst, mut apart) = (0.0_f64, 0.0_f64);
    for total in &mut run {
        let total = total?;
        let [heat, by_hinges] = total.integrals;
        balance.push((total.state.t, height(&total.state), heat));
        worst = worst.max((height(&total.state) + heat - height(&start)).abs());
        apart = apart.max((heat - by_hinges).abs());
    }
    let cost = run.statistics();
    println!("{} steps, {} evaluations", cost.accepted, cost.evaluations);
    let times = [0.0, 1.0, 2.0, 4.0, 8.0, END];
    let rows = times.map(|time| balance.iter().rev().find(|row| row.0 <= time).copied().unwrap_or_default());
    println!(
        "{}",
        table(
            ["time (s)", "energy (J)", "heat (J)", "together (J)"],
            rows.into_iter().map(|(t, energy, heat)| [
                format!("{t:.2}"),
                format!("{energy:.6}"),
                format!("{heat:.6}"),
                format!("{:.6}", energy + heat)
            ])
        )
    );
    checks.at_most("energy and heat against the energy at the start (J)", worst, 1e-8);
    checks.at_most("heat by the power of D against the hinges' (J)", apart, 1e-8);
    let left = balance.last().map_or(f64::NAN, |row| row.1) / height(&start);
    checks.at_most("part of the energy that is left", left.abs(), 1e-2);

    let folder = support::charts()?;
    let line = |name, value: fn(&(f64, f64, f64)) -> f64| {
        Series::line(name, balance.iter().map(|row| (row.0, value(row))))
    };
    Chart::new("Energy of a mobile", Axis::linear("time", "s"), Axis::linear("energy", "J"))
        .subtitle("31 links in five tiers, let go at 1.1 rad; energy above that at rest")
        .with(line("kinetic and potential", |row| row.1))
        .with(line("heat in the hinges", |row| row.2))
        .with(line("together", |row| row.1 + row.2))
        .write(&folder, "tree-energy")?;

    let run = integrate(&mobile, Dop853, PiController::tolerance(1e-9), start).until(END);
    let states = run.sample_evenly(256).collect::<Result<Vec<_>, _>>()?;
    let leaves = |at: &State<f64, N>| masses(&mobile, at)[FORKS..].to_vec();
    let forks = |at: &State<f64, N>| masses(&mobile, at)[..FORKS].to_vec();
    Animation::new("A mobile of 31 links", END)
        .subtitle("let go at 1.1 rad; friction in the hinges brings it to rest")
        .with(Part::path("ceiling", [(-0.3, 0.0), (0.3, 0.0)]).width(5.0).colour(7))
        .with(Part::bars("links", states.iter().map(|at| bars(&mobile, at))).width(2.0).colour(4))
        .with(Part::joints("masses of the forks", states.iter().map(forks)).width(7.0))
        .with(Part::joints("leaves", states.iter().map(leaves)).width(13.0).colour(1))
        .write(&folder, "tree")?;
    for name in ["tree.svg", "tree-energy.svg"] {
        println!("{}", folder.join(name).display());
    }
    Ok(checks.report()?)
}
