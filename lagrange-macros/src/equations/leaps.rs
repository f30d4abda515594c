//! Momenta that jump with the position or with time: an impulse acts there, which the equations of motion do not have.

use super::check::{TRIALS, sample};
use super::common::switches;
use super::formed::Formed;
use crate::diagnostics::Errors;
use crate::graph::{Graph, Symbol, Value};
use crate::model::Model;

/// Coordinates and times among which the place of a switch is looked for.
const RANGE: f64 = 4.0;
const PARTS: u32 = 64;

/// Warns of a momentum ∂L/∂q̇ that jumps at a switch. Tried with numbers: a jump is one that is as large 1e-9 beside
/// the switch as 1e-6 beside it.
pub fn leaps(g: &Graph, model: &Model, formed: &Formed, errors: &mut Errors) {
    let derived = model.origin.is_some() || model.reduction.is_some();
    let Some(keyword) = model.keywords.kinetic.as_ref().filter(|_| !derived) else { return };
    for (i, p) in formed.momenta.iter().enumerate().take(model.mechanical()) {
        if switches(g, &[*p]).into_iter().any(|switch| jumps(g, *p, switch)) {
            let x = model.coordinates[i].label();
            let message = format!(
                "the momentum of `{x}` jumps where a condition changes: an impulse acts there, which the equations of motion do not have\nhelp: end the run at an event there and go on from the state after the impact (`jump`), or smooth the jump"
            );
            errors.warn(keyword.span(), "a_momentum_that_jumps", message);
            return;
        }
    }
}

/// Does the value jump where both sides of this condition are equal, at some coordinate or time?
fn jumps(g: &Graph, value: Value, sides: [Value; 2]) -> bool {
    let moving = g.symbols(&sides).into_iter().filter(|s| matches!(s, Symbol::Coordinate(_) | Symbol::Time));
    moving.into_iter().any(|symbol| {
        (0..TRIALS).any(|trial| {
            let at = |values: &[Value], x: f64| {
                g.evaluate(values, |s| if s == symbol { x } else { sample(s, trial, 0) })
            };
            let difference = |x: f64| {
                let [a, b] = at(&sides, x)[..] else { unreachable!("two values") };
                a - b
            };
            let place = |k: u32| RANGE * (2.0 * f64::from(k) / f64::from(PARTS) - 1.0) + 1e-3;
            (0..PARTS).any(|k| {
                let (mut low, mut high) = (place(k), place(k + 1));
                let below = difference(low) < 0.0;
                if below == (difference(high) < 0.0) {
                    return false;
                }
                for _ in 0..60 {
                    let middle = 0.5 * (low + high);
                    let end = if (difference(middle) < 0.0) == below { &mut low } else { &mut high };
                    *end = middle;
                }
                let change = |d: f64| at(&[value], high + d)[0] - at(&[value], low - d)[0];
                let (near, far) = (change(1e-9).abs(), change(1e-6).abs());
                near > 1e-4 * at(&[value], low - 1e-9)[0].abs().max(1e-3) && near > 0.5 * far
            })
        })
    })
}
