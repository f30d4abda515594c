//! Conditions on which an impulse acts: across them a momentum ∂L/∂q̇ jumps, or L along a coordinate, or a position.
//!
//! Between two forms of L the momenta have the jump λ ∂σ/∂q, where σ is the switching function, and the equations of
//! motion, which hold on either side, do not say how large λ is: a mass that is picked up for good has λ = 0 and loses
//! energy; the corner of a stationary action keeps the energy p·q̇ − L (Weierstrass and Erdmann; Gelfand and Fomin,
//! *Calculus of Variations*, 1963, §15).

use super::assemble::flattened;
use super::check::{TRIALS, sample};
use super::formed::Formed;
use super::series::switches::switching;
use crate::diagnostics::Errors;
use crate::graph::{Graph, Node, Symbol, Value};
use crate::model::Model;
use proc_macro2::Ident;

/// Coordinates and times among which the place of a switch is looked for.
const RANGE: f64 = 4.0;
const PARTS: u32 = 64;

/// Places at which impulses act.
pub struct Impulses {
    /// The switching functions that vanish there.
    pub switches: Vec<Value>,
    /// Functions with data, by their places, on whose slopes momenta depend: there, where these have kinks.
    pub slopes: Vec<usize>,
    /// Positions of which velocities are taken, in terms of q and t, if they have choices.
    pub positions: Vec<Value>,
}

/// A jump, by which an impulse acts.
enum Jump {
    /// The momentum of this coordinate.
    Momentum(usize),
    /// A position of which a velocity is taken.
    Position,
    /// L, along a coordinate.
    Lagrangian,
}

/// The places at which impulses act. Switches are found by numbers, and told in a warning.
pub fn impulses(g: &mut Graph, model: &Model, formed: &Formed, errors: &mut Errors) -> Impulses {
    let mut values = formed.momenta[..model.mechanical()].to_vec();
    let positions = positions(g, model, formed);
    values.extend(&positions);
    values.push(formed.lagrangian);
    let found = switching(g, &values).into_iter().filter_map(|switch| {
        let jump = jump(g, &values, switch, model.mechanical())?;
        Some((switch, jump))
    });
    let found: Vec<(Value, Jump)> = found.collect();
    let derived = model.origin.is_some() || model.reduction.is_some();
    let mut told: Vec<&Ident> = Vec::new();
    for (_, jump) in found.iter().filter(|_| !derived) {
        let (keyword, what) = match jump {
            Jump::Momentum(i) => {
                (&model.keywords.kinetic, format!("the momentum of `{}`", model.coordinates[*i].label()))
            }
            Jump::Position => {
                let keywords = &model.keywords;
                let keyword =
                    if keywords.kinetic.is_some() { &keywords.kinetic } else { &keywords.potential };
                (keyword, "a position whose velocity is taken".into())
            }
            Jump::Lagrangian if model.energies.is_none() => {
                (&model.keywords.potential, "the Lagrangian".into())
            }
            Jump::Lagrangian => (&model.keywords.potential, "the potential energy".into()),
        };
        if let Some(keyword) = keyword.as_ref().filter(|keyword| !told.contains(keyword)) {
            told.push(keyword);
            let message = format!(
                "{what} jumps where a condition changes: an impulse acts there, which the equations of motion do not have, and runs across it end in `UnknownImpulse`\nhelp: end the run at an event there and go on from the state after the impact (`jump`), or smooth the jump"
            );
            errors.warn(keyword.span(), "an_energy_that_jumps", message);
        }
    }
    let switches = found.into_iter().map(|(switch, _)| switch).collect();
    Impulses { switches, slopes: slopes(g, model, &values[..model.mechanical()]), positions }
}

fn positions(g: &mut Graph, model: &Model, formed: &Formed) -> Vec<Value> {
    let mut moved = flattened(g, &formed.flat, &model.moved);
    moved.sort_by_key(|value| value.node);
    moved.dedup_by_key(|value| value.node);
    moved.retain(|value| !switching(g, &[*value]).is_empty());
    moved
}

/// Functions with data on whose slopes momenta depend, at arguments that move.
fn slopes(g: &Graph, model: &Model, momenta: &[Value]) -> Vec<usize> {
    let moves = |s: &Symbol| matches!(s, Symbol::Coordinate(_) | Symbol::Time);
    let slope = |id| match g.node(id) {
        Node::Extern(f, orders, arguments) => {
            let is_slope = model.externals[*f].data.is_some() && orders.iter().any(|order| *order > 0);
            (is_slope && g.symbols(arguments).iter().any(moves)).then_some(*f)
        }
        _ => None,
    };
    let mut slopes: Vec<usize> = g.live(momenta).into_iter().filter_map(slope).collect();
    slopes.sort_unstable();
    slopes.dedup();
    slopes
}

/// The first of the momenta, the positions, and then L, that jumps where this switching function vanishes. A jump is
/// one that is as large 1e-9 beside the switch as 1e-6 beside it.
fn jump(g: &Graph, values: &[Value], switch: Value, mechanical: usize) -> Option<Jump> {
    let all = values.len();
    let moving = g.symbols(&[switch]).into_iter();
    moving.filter(|s| matches!(s, Symbol::Coordinate(_) | Symbol::Time)).find_map(|symbol| {
        // (L may change with time, and with a state that is no position.)
        let is_position = matches!(symbol, Symbol::Coordinate(i) if i < mechanical);
        let values = if is_position { values } else { &values[..values.len() - 1] };
        (0..TRIALS).find_map(|trial| {
            let at = |values: &[Value], x: f64| {
                g.evaluate(values, |s| if s == symbol { x } else { sample(s, trial, 0) })
            };
            let root = root(|x| at(&[switch], x)[0])?;
            let [near, far] = [1e-9, 1e-6].map(|d| [at(values, root - d), at(values, root + d)]);
            let change = |[below, above]: &[Vec<f64>; 2], i: usize| (above[i] - below[i]).abs();
            let jumps = |i: &usize| {
                let size = near[0][*i].abs().max(1e-3);
                change(&near, *i) > 1e-6 * size && change(&near, *i) > 0.5 * change(&far, *i)
            };
            let which = (0..values.len()).find(jumps)?;
            Some(match which {
                which if which < mechanical => Jump::Momentum(which),
                which if which < all - 1 => Jump::Position,
                _ => Jump::Lagrangian,
            })
        })
    })
}

/// A place at which a function changes its sign: that of a straight line, or the first one in the range.
fn root(f: impl Fn(f64) -> f64) -> Option<f64> {
    let [start, next] = [0.0, 1.0].map(&f);
    let straight = start / (start - next);
    let beside = 1e-6 * straight.abs().max(1.0);
    if (f(straight - beside) < 0.0) != (f(straight + beside) < 0.0)
        && f(straight).abs() <= 1e-12 * start.abs()
    {
        return Some(straight);
    }
    let place = |k: u32| RANGE * (2.0 * f64::from(k) / f64::from(PARTS) - 1.0) + 1e-3;
    let signs: Vec<bool> = (0..=PARTS).map(|k| f(place(k)) < 0.0).collect();
    let part = signs.windows(2).position(|ends| ends[0] != ends[1])?;
    let (mut low, mut high) = (place(part as u32), place(part as u32 + 1));
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        let end = if (f(middle) < 0.0) == signs[part] { &mut low } else { &mut high };
        *end = middle;
    }
    Some(high)
}
