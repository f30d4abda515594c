//! Compares emitted systems with reference digits and with themselves, and keeps what it finds as values.
//!
//! | file | the question it answers |
//! |---|---|
//! | `subject.rs` | Which functions has a system, whatever its type? |
//! | `compare.rs` | Does it agree with its digits, and with what holds for every Lagrangian? |
//! | `formula.rs` | Does it satisfy the equations that the source prints? |
//! | `small.rs` | Are its small vibrations right? |
//! | `trajectory.rs` | Does it move as it should, and conserve what it should? |
//! | `reduced.rs` | Does what the compiler reduces move as the whole? |
//! | `row.rs` | What is said about one row of the catalogue? |
//! | `reference.rs`, `random.rs` | The files of digits; random states that are the same in every run |
//!
//! Tolerances. A vector or matrix is compared entry by entry against `1e-14` of its largest entry, plus what a change
//! of each input by four rounding units would do to it, `4ε Σ |xᵢ ∂f/∂xᵢ|`: the condition of the function itself,
//! whatever the formula that evaluates it (Higham, *Accuracy and Stability of Numerical Algorithms*, 2002, §1.6).

mod compare;
mod formula;
mod random;
mod reduced;
mod reference;
mod row;
mod small;
#[macro_use]
mod subject;
mod trajectory;

pub use compare::{jacobi_balance, split};
pub use formula::evaluate;
pub use random::random_states;
pub use reduced::recovered;
pub use reference::{Reference, list, number};
#[cfg(test)]
pub use row::assert_rows;
pub use row::{Finding, Kind, Row, required};
pub use subject::{Golden, Quantity, ROOM, State, Subject, with_reference};
pub use trajectory::states;

/// Error allowed, relative to the largest entry: some ninety roundings.
const TOLERANCE: f64 = 1e-14;

/// Error of every input: four roundings.
const INPUT: f64 = 4.0 * f64::EPSILON;

/// Error of a printed equation, relative to its terms: at a random state the accelerations carry the condition of the
/// inertia matrix, below 100 for the ranges in use, on top of a few roundings.
const BALANCE: f64 = 1e-13;

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |largest, value| largest.max(value.abs()))
}
