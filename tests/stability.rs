//! The steps at which methods blow up, theory from their coefficients against the steps that they make; and what every
//! method makes of hard scenes.

#![allow(dead_code)]

#[path = "../examples/stability/limits.rs"]
mod limits;
#[path = "../examples/stability/scenes.rs"]
mod scenes;
#[path = "../examples/stability/systems.rs"]
mod systems;

use lagrange_runtime::Failure;
use scenes::{Outcome, Row};

#[test]
fn limits_of_theory_are_met_within_one_per_cent() {
    for limit in limits::limits() {
        assert!(
            limit.agrees(),
            "{} on the {} oscillator: {:?}, should be {:?}",
            limit.method,
            limit.axis,
            limit.measured,
            limit.theory
        );
    }
}

#[test]
fn dump() {
    let mut now = std::time::Instant::now();
    for row in scenes::rows(true) {
        println!("== {} (bound {:e}) {:?}", row.name, row.bound, now.elapsed());
        for (method, outcome) in &row.cells {
            match outcome {
                Outcome::Failed { failure, late } => println!("   {method}: {failure:?} {late:?}"),
                o => println!("   {method}: {o:?}"),
            }
        }
        now = std::time::Instant::now();
    }
}
