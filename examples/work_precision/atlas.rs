//! The atlas: every method that fits, on ten motions. `cargo run --release --example work_precision -- --all` builds
//! and runs it; `main.rs` says what it does, and with which options.
//!
//! Taylor series in double-double have to end where the references do, or the program fails. By themselves they would
//! do for all methods but the Taylor series in `f64`, whose recurrences they share.

mod book;
mod digits;
mod every;
mod further;
mod known;
mod long;
mod measure;
mod methods;
mod options;
mod page;
mod problems;
mod report;
#[path = "../support/mod.rs"]
mod support;

use book::{Motion, motion};
#[allow(unused_imports)]
use every::Unmarked;
use lagrange_runtime::DoubleDouble;
use options::Options;
use std::error::Error;

/// A motion with its methods. A macro, since the methods are chosen where the system is known by name.
macro_rules! every {
    ($problem:expr) => {{
        let problem = $problem;
        let precise = problem.system.map(DoubleDouble::from);
        motion(problem.checked(precise)?, |problem| {
            let groups = [problem.general(), problem.separable(), problem.conservative(), problem.linear()];
            groups.into_iter().flatten().collect()
        })
    }};
}

fn main() -> Result<(), Box<dyn Error>> {
    let motions: [Box<dyn Motion>; 10] = [
        every!(known::pendulum()),
        every!(known::kepler()?),
        every!(further::eccentric()?),
        every!(further::polar_kepler()?),
        every!(further::henon_heiles()?),
        every!(known::double_pendulum()?),
        every!(known::top()?),
        every!(further::spring_pendulum()?),
        every!(further::driven_pendulum()?),
        every!(further::chain()),
    ];
    let known = motions.each_ref().map(|motion| motion.known());
    assert_eq!(known.each_ref().map(|(name, _)| *name), options::ATLAS, "names that `--all` knows");
    let options = Options::of(&known, false);
    book::write(&motions, &options)
}
