//! Constraints whose gradient vanishes wherever they hold, as that of a square does: they exert no force.

use crate::equations::check::sample;
use crate::graph::{Graph, Symbol, Value};

/// Starts from which positions are looked for on which the constraint holds, and Newton's steps towards them.
const STARTS: u64 = 3;
const STEPS: usize = 40;
/// Violation, relative to the gradient and `1 + |q|`, at which a position is one of the constraint.
const HELD: f64 = 1e-10;
/// Length of a gradient, relative to that at the start, that vanishes: towards a double root it halves at each step.
const VANISHED: f64 = 1e-5;

/// Does the gradient vanish at all positions on the constraint that are found?
pub fn check(g: &Graph, value: Value, row: &[Value]) -> bool {
    let all: Vec<Value> = std::iter::once(value).chain(row.iter().copied()).collect();
    let mut found = (0..STARTS).filter_map(|trial| vanishes(g, &all, trial));
    // (One regular position is enough.)
    found.next() == Some(true) && found.next() == Some(true) && found.next() != Some(false)
}

/// That of the position to which Newton's method leads from a start, if it leads to one.
fn vanishes(g: &Graph, all: &[Value], trial: u64) -> Option<bool> {
    let n = all.len() - 1;
    let mut q: Vec<f64> = (0..n).map(|i| sample(Symbol::Coordinate(i), trial, 0) - 0.4).collect();
    let mut first = None;
    for _ in 0..STEPS {
        let values = g.evaluate(all, |s| match s {
            Symbol::Coordinate(i) => q[i],
            other => sample(other, trial, 0),
        });
        let (f, a) = (values[0], &values[1..]);
        let square: f64 = a.iter().map(|a| a * a).sum();
        let size = square.sqrt();
        if !(f.is_finite() && size.is_finite()) {
            return None;
        }
        let start = *first.get_or_insert(size);
        if size <= VANISHED * start {
            return Some(true);
        }
        let length = q.iter().map(|q| q * q).sum::<f64>().sqrt();
        if f.abs() <= HELD * size * size / start * (1.0 + length) {
            return Some(false);
        }
        q.iter_mut().zip(a).for_each(|(q, a)| *q -= f * a / square);
    }
    None
}
