//! Functions of events with their derivatives along a motion, from which runs see that an event is in no part of a
//! step.

use super::common::{in_time, symbols};
use super::formed::Formed;
use super::quantities::{by_motion, observed};
use super::solved::Solved;
use crate::graph::{Graph, Symbol, Value};
use crate::model::Model;
use crate::program::count::operations;

/// Derivatives of longer functions, counted in operations, are differences at run time.
const MAX_DERIVED_OPERATIONS: usize = 200;

/// g, ġ and g̈ of one event in terms of q, q̇, t and given accelerations.
pub struct EventFunction {
    pub value: Value,
    /// The value by accelerations and multipliers, under constraints, if it depends on these.
    pub by_motion: Option<Value>,
    pub rates: [Option<Value>; 2],
}

/// The functions of each event, by elements.
pub fn events(g: &mut Graph, model: &Model, formed: &Formed, solved: &Solved) -> Vec<Vec<EventFunction>> {
    let n = model.coordinates.len();
    let each = model.events.iter().map(|event| {
        let values = observed(g, formed, solved, &event.values);
        let by_motion = by_motion(g, formed, solved, &event.values);
        let by_motion = |k: usize| by_motion.as_ref().map(|values| values[k]);
        let functions = values.into_iter().enumerate();
        functions
            .map(|(k, value)| EventFunction { by_motion: by_motion(k), ..function(g, n, value) })
            .collect()
    });
    each.collect()
}

fn function(g: &mut Graph, n: usize, value: Value) -> EventFunction {
    let value = g.share_angles(&[value])[0];
    // Reactions that a function of the runtime solves for have no derivatives here.
    let unsolved = |s| matches!(s, Symbol::Acceleration(_) | Symbol::Multiplier(_) | Symbol::Reaction(_));
    if operations(g, &[value]).arithmetic() > MAX_DERIVED_OPERATIONS || g.depends(&[value], unsolved) {
        return EventFunction { value, by_motion: None, rates: [None; 2] };
    }
    let [velocities, accelerations] = [Symbol::Velocity, Symbol::Given].map(|symbol| symbols(g, symbol, n));
    let along = in_time(&velocities);
    let seed = |symbol| match symbol {
        Symbol::Velocity(i) => Some(accelerations[i]),
        other => along(other),
    };
    let first = g.forward(&[value], seed)[0];
    let is_of_positions = !g.depends(&[value], |s| matches!(s, Symbol::Velocity(_)));
    let second = is_of_positions.then(|| g.forward(&[first], seed)[0]);
    EventFunction { value, by_motion: None, rates: [Some(first), second] }
}
