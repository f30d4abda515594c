//! Constraints whose gradient vanishes wherever they hold, as that of a square does: they exert no force. And sums of
//! squares that hold nowhere.

use crate::equations::check::sample;
use crate::graph::{Graph, Symbol, Value};

/// Starts from which positions are looked for on which the constraint holds, and Newton's steps towards them.
const STARTS: u64 = 3;
const STEPS: usize = 100;
/// Violation, relative to the gradient and `1 + |q|`, at which a position is one of the constraint: towards a double
/// root it halves with each step.
const HELD: f64 = 1e-10;
/// Length of a gradient that vanishes, relative to that at this distance, relative to `1 + |q|`.
const VANISHED: f64 = 1e-5;
const ASIDE: f64 = 1e-3;

/// Is this a sum of squares and a positive number, or a negative one less squares?
pub fn is_of_one_sign(g: &Graph, value: Value) -> bool {
    let terms = g.terms(value);
    let is_square = |term: &Value| term.node.is_none_or(|id| g.factors(id).iter().all(|f| f.1 % 2 == 0));
    let signs = terms.iter().map(|term| term.k.is_negative());
    let same = signs.clone().all(|sign| sign) || !signs.clone().any(|sign| sign);
    same && terms.iter().all(is_square) && terms.iter().any(|term| term.node.is_none())
}

/// Does the gradient vanish at all positions on the constraint that are found?
pub fn check(g: &Graph, value: Value, row: &[Value]) -> bool {
    let all: Vec<Value> = std::iter::once(value).chain(row.iter().copied()).collect();
    let mut found = (0..STARTS).filter_map(|trial| vanishes(g, &all, trial));
    // (One regular position is enough.)
    found.next() == Some(true) && found.next() == Some(true) && found.next() != Some(false)
}

/// Returns whether the gradient vanishes at the position to which Newton's method leads from a start, if to one.
fn vanishes(g: &Graph, all: &[Value], trial: u64) -> Option<bool> {
    let n = all.len() - 1;
    let at = |q: &[f64]| {
        let values = g.evaluate(all, |s| match s {
            Symbol::Coordinate(i) => q[i],
            other => sample(other, trial, 0),
        });
        let square = values[1..].iter().map(|a| a * a).sum::<f64>();
        (square.is_finite() && values[0].is_finite()).then_some((values, square))
    };
    let mut q: Vec<f64> = (0..n).map(|i| sample(Symbol::Coordinate(i), trial, 0) - 0.4).collect();
    for _ in 0..STEPS {
        let (values, square) = at(&q)?;
        let (f, a, size) = (values[0], &values[1..], square.sqrt());
        let length = 1.0 + q.iter().map(|q| q * q).sum::<f64>().sqrt();
        let moved = |by: f64| -> Vec<f64> { q.iter().zip(a).map(|(q, a)| q + by * a).collect() };
        if f.abs() <= HELD * size * length {
            let aside = at(&moved(ASIDE * length / size))?.1.sqrt();
            return Some(size <= VANISHED * aside);
        }
        q = moved(-f / square);
    }
    None
}
