//! Quantities of the system and of the user, as they are emitted: in the shortest form that is tried.

use super::assemble::{exert, flattened};
use super::common::{in_time, shortest, symbols};
use super::formed::Formed;
use super::solved::Solved;
use crate::graph::{Graph, Symbol, Value};
use crate::model::Model;

/// Quantities of the system and of the user, as they are emitted.
pub struct Quantities {
    pub lagrangian: Value,
    pub dissipation: Value,
    pub momenta: Vec<Value>,
    pub bias: Vec<Value>,
    pub force: Vec<Value>,
    pub energy_function: Value,
    pub power: Value,
    /// The user's, in their order.
    pub observed: Vec<Vec<Value>>,
    /// The user's under constraints, by accelerations and multipliers, if they depend on these.
    pub by_motion: Vec<Option<Vec<Value>>>,
    /// Generalized impulses of those that act at points, by points.
    pub impulses: Vec<Vec<Value>>,
    /// Values and velocities of the coordinates that are held.
    pub held: [Vec<Value>; 2],
    /// Velocities that an average has taken away.
    pub fast: Vec<Value>,
}

pub fn quantities(g: &mut Graph, model: &Model, formed: &Formed, solved: &Solved) -> Quantities {
    let n = model.coordinates.len();
    let observed = model.observed.iter().map(|o| observed(g, formed, solved, &o.values)).collect();
    let written = model.observed.iter().map(|o| &o.values);
    let by_motion = written.map(|values| by_motion(g, formed, solved, values)).collect();
    let impulses = model.struck.iter().map(|point| generalized(g, formed, n, &point.position)).collect();
    let [momenta, bias, force] =
        [&formed.momenta, &formed.bias, &formed.force].map(|values| shortest(g, n, values));
    let [lagrangian, energy_function, power, dissipation] =
        [formed.lagrangian, formed.energy_function, formed.power, formed.dissipation]
            .map(|v| shortest(g, n, &[v])[0]);
    let held = held(g, model, formed);
    let fast = model.origin.iter().flat_map(|origin| origin.fast.clone()).collect::<Vec<_>>();
    let fast = shortest(g, n, &fast);
    Quantities {
        held,
        fast,
        lagrangian,
        dissipation,
        momenta,
        bias,
        force,
        energy_function,
        power,
        observed,
        by_motion,
        impulses,
    }
}

/// Values and velocities of the coordinates that are held.
fn held(g: &mut Graph, model: &Model, formed: &Formed) -> [Vec<Value>; 2] {
    let held = model.origin.iter().flat_map(|origin| &origin.held);
    let values: Vec<Value> = held.map(|held| held.value).collect();
    let values = flattened(g, &formed.flat, &values);
    let qd = symbols(g, Symbol::Velocity, model.coordinates.len());
    let rates = g.forward(&values, in_time(&qd));
    [values, rates]
}

pub fn observed(g: &mut Graph, formed: &Formed, solved: &Solved, values: &[Value]) -> Vec<Value> {
    let known = g.substitute(values, |s| match s {
        Symbol::Multiplier(j) => Some(solved.multipliers[j]),
        Symbol::Reaction(k) => Some(solved.reactions[k]),
        _ => None,
    });
    flattened(g, &formed.flat, &known)
}

/// Values under constraints by accelerations and multipliers, if they depend on these.
pub fn by_motion(g: &mut Graph, formed: &Formed, solved: &Solved, values: &[Value]) -> Option<Vec<Value>> {
    let reacts = |s| matches!(s, Symbol::Multiplier(_) | Symbol::Reaction(_));
    if formed.rows.values.is_empty() || !g.depends(values, reacts) {
        return None;
    }
    let known = g.substitute(values, |s| match s {
        Symbol::Reaction(k) => Some(solved.relaxed[k]),
        _ => None,
    });
    Some(flattened(g, &formed.flat, &known))
}

/// The generalized impulse Σ P ∂x/∂q of an impulse P, given, at the position x (Beatty 2006, (11.58)).
fn generalized(g: &mut Graph, formed: &Formed, n: usize, position: &[Value]) -> Vec<Value> {
    let x = flattened(g, &formed.flat, position);
    let coordinates: Vec<Symbol> = (0..n).map(Symbol::Coordinate).collect();
    let blow: Vec<(Value, Value)> = symbols(g, Symbol::Given, x.len()).into_iter().zip(x).collect();
    let mut sum = vec![Value::ZERO; n];
    exert(g, &blow, &coordinates, &mut sum);
    sum
}
