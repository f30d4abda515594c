//! Terms of the derivation that several stages name: symbols of a kind, rates along a motion, inner products, what
//! values are proved not to depend on, and the shortest form of a list of values.

use crate::graph::normal::EXPANSIONS;
use crate::graph::{Function, Graph, Node, Symbol, Value};
use crate::program::count::operations;

/// Systems of more coordinates are not tried with their bindings expanded or their equations multiplied out.
pub const MAX_EXPANDED_COORDINATES: usize = 6;
/// Expressions of more terms are not multiplied out for emission.
pub const MAX_EXPANDED_TERMS: usize = 24;

/// Everything moves at its rate.
pub fn in_time(qd: &[Value]) -> impl Fn(Symbol) -> Option<Value> {
    |symbol| match symbol {
        Symbol::Coordinate(i) => Some(qd[i]),
        Symbol::Time => Some(Value::ONE),
        _ => None,
    }
}

pub fn symbols(g: &mut Graph, symbol: fn(usize) -> Symbol, n: usize) -> Vec<Value> {
    (0..n).map(|i| g.symbol(symbol(i))).collect()
}

/// Momenta of the states of first order, which take the places from `first` on: the states themselves, as if ½ z²
/// were part of L (docs/decisions/0018). What L says of them as velocities is nothing.
pub fn momenta_of_states(g: &mut Graph, first: usize, momenta: &mut [Value]) {
    for (i, p) in momenta.iter_mut().enumerate().skip(first) {
        *p = g.symbol(Symbol::Velocity(i));
    }
}

/// ∂D/∂q̇, in which the states of first order, the velocities from `first` on, are none.
pub fn frictions(g: &mut Graph, d: Value, velocities: &[Symbol], first: usize) -> Vec<Value> {
    let mut frictions = g.gradient(d, velocities);
    frictions[first..].fill(Value::ZERO);
    frictions
}

pub fn inner(g: &mut Graph, a: &[Value], b: &[Value]) -> Value {
    a.iter().zip(b).fold(Value::ZERO, |sum, (a, b)| {
        let term = g.mul(*a, *b);
        g.add(sum, term)
    })
}

/// Does it depend on nothing but parameters?
pub fn is_number(g: &Graph, v: Value) -> bool {
    v.node.is_none_or(|id| g.is_fixed(id))
}

/// Are the values proved not to depend on any symbol of this kind? Derivatives alone do not prove it: those of a
/// choice and of a sign vanish, though values jump.
pub fn independent(g: &mut Graph, values: &[Value], kind: impl Fn(Symbol) -> bool) -> bool {
    if !g.depends(values, &kind) {
        return true;
    }
    !jumps(g, values).into_iter().any(&kind)
        && values.iter().all(|v| {
            let symbols = g.symbols(&[*v]).into_iter().filter(|s| kind(*s)).collect::<Vec<_>>();
            g.gradient(*v, &symbols).into_iter().all(|slope| g.vanishes(slope))
        })
}

/// Symbols that decide where the values jump.
pub fn jumps(g: &Graph, values: &[Value]) -> Vec<Symbol> {
    let mut jumps = Vec::new();
    for id in g.live(values) {
        match g.node(id) {
            Node::Select(_, parts) => jumps.extend(&parts[..2]),
            Node::Call(Function::signum, x, _) => jumps.push(*x),
            _ => {}
        }
    }
    g.symbols(&jumps)
}

/// The values as they are or, in a system of few coordinates, multiplied out, whichever costs least.
pub fn shortest(g: &mut Graph, coordinates: usize, values: &[Value]) -> Vec<Value> {
    let mut best = g.share_angles(values);
    for how in EXPANSIONS.into_iter().filter(|_| coordinates <= MAX_EXPANDED_COORDINATES) {
        let Some(expanded) = g.expanded(values, MAX_EXPANDED_TERMS, how) else { continue };
        let expanded = g.share_angles(&expanded);
        if operations(g, &expanded).cost() < operations(g, &best).cost() {
            best = expanded;
        }
    }
    best
}
