//! Two hinged rods on a smooth table, in one line, struck at one end: an impulse changes the momenta, the momenta give
//! the velocities, and the rods fold.
//!
//! `cargo run --release --example impulse`

#[path = "support/mod.rs"]
mod support;

use lagrange_runtime::chart::{Axis, Chart, Series};
use lagrange_runtime::prelude::*;
use std::error::Error;

lagrangian! {
    /// Rods of length 2l; x, y is their hinge, a the angle of the struck rod from −y, b that of the other from y.
    pub system HingedRods {
        param m, l;
        coord x, y, a, b;
        let x1 = x + l * sin(a);
        let y1 = y - l * cos(a);
        let x2 = x - l * sin(b);
        let y2 = y + l * cos(b);
        T = 0.5 * m * (dot(x1).powi(2) + dot(y1).powi(2) + dot(x2).powi(2) + dot(y2).powi(2))
            + 0.5 * (m * l.powi(2) / 3) * (dot(a).powi(2) + dot(b).powi(2));
        V = 0;
        impulse blow at [x + 2 * l * sin(a), y - 2 * l * cos(a)];
        observe rods = [x + 2 * l * sin(a), y - 2 * l * cos(a), x, y, x - 2 * l * sin(b), y + 2 * l * cos(b)];
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let rods = HingedRods::new(0.7, 0.4);
    let rest = State::new(0.0, [0.0; 4], [0.0; 4]);
    let blow = 0.9;
    let struck = rods.jump(&rest, &rods.blow(&rest.q, rest.t, &SVector::from([blow, 0.0])));
    let start = struck.after;
    println!("hinge {:.6} m/s, rods {:.6} and {:.6} rad/s", start.qd[0], start.qd[2], start.qd[3]);
    println!("energy gained {:.6} J, 7P²/4m = {:.6} J", struck.energy, 1.75 * blow * blow / rods.m);

    let folder = support::charts()?;
    let gap = 0.9;
    let (mut first, mut second, mut hinges) = (Vec::new(), Vec::new(), Vec::new());
    let run = integrate(&rods, Dop853, PiController::tolerance(1e-10), start).until(0.5);
    for (picture, at) in run.sample([0.0, 0.1, 0.2, 0.3, 0.4, 0.5]).enumerate() {
        let at = at?;
        let [x1, y1, x, y, x2, y2] = rods.rods_at(&at).into();
        let shift = gap * picture as f64;
        first.extend([(x1 + shift, y1), (x + shift, y), (f64::NAN, f64::NAN)]);
        second.extend([(x + shift, y), (x2 + shift, y2), (f64::NAN, f64::NAN)]);
        hinges.push((x + shift, y));
    }
    Chart::new("Two hinged rods, struck at one end", Axis::linear("x", "m"), Axis::linear("y", "m"))
        .subtitle(format!(
            "struck along x at the lower end, P = {blow} N s; each picture {gap} m to the right, 0.1 s later"
        ))
        .equal_aspect()
        .with(Series::line("struck rod", first))
        .with(Series::line("other rod", second))
        .with(Series::markers("hinge", hinges))
        .write(&folder, "impulse")?;
    println!("{}", folder.join("impulse.svg").display());
    Ok(())
}
