//! Taylor coefficients from the equations where they were written, before anything is eliminated.
//!
//! With u̇ = S ẋ + φ_t for the rates of the bindings, x = (u, q), and a force σ that holds each binding to its
//! definition,
//!
//! ```text
//!   H ẍ − (S, 0)ᵀ σ + σ = e        ü − S ẍ = d/dt (S, φ_t) (ẋ, 1) at ẍ = 0
//! ```
//!
//! of which order k − 1 is, with what is known already on the right,
//!
//! ```text
//!   H_0 ẍ_{k−1} − S_0ᵀ σ_{k−1} + σ_{k−1} = e_{k−1} − Σ_{j≥1} H_j ẍ_{k−1−j} + Σ_{j≥1} S_jᵀ σ_{k−1−j}
//!   ü_{k−1} − S_0 ẍ_{k−1} = k ((φ_t)_k + Σ_{j≥1} S_j ẋ_{k−j}).
//! ```
//!
//! The matrix is the same at all orders. It is factored once a step, sparsely and at compile time (`augmented.rs`),
//! so an order costs one sweep over the bindings there and one back. Products of series are what was written and no
//! more: four for each link of a chain. Unknowns are counted one order later than they belong, so that all that is
//! convolved has the order k.

use super::form::{Form, Known};
use super::orders::{Factor, Orders};
use super::{recurrence::Motion, substitution::Substitution};
use crate::equations::assemble::flattened;
use crate::equations::augmented::{Arithmetic, Factors};
use crate::equations::common::is_number;
use crate::equations::formed::Formed;
use crate::graph::{Coefficient, Graph, Symbol, Value};
use crate::model::frames;
use crate::program::lower::program_from;

/// A right-hand side of the equations.
enum Right {
    /// Right-hand side of a position: e, and unknowns times nodes that move.
    Forces { force: Value, tails: Vec<(Value, usize)> },
    /// Right-hand side of the definition of a binding: φ_t, and the slopes that move with the velocities they belong
    /// to.
    Definition { explicit: Value, terms: Vec<[Value; 2]> },
}

/// The equations of one order.
pub struct Bindings {
    coordinates: usize,
    /// Right-hand sides that are `Given` to the solution.
    rights: Vec<Right>,
    /// Accelerations of the coordinates, and then the other unknowns that are convolved.
    solution: Substitution,
    /// Velocities times slopes: the derivatives of sines and cosines are among them.
    rates: Vec<Value>,
}

/// Has a system equations at its bindings? Not with constraints or frames in space.
pub fn are_offered(known: &Known) -> bool {
    let positions = known.model.bindings.iter().all(|b| matches!(b.motion, frames::Motion::Position));
    positions && known.formed.rows.is_empty() && !known.solved.orders.is_empty()
}

pub fn form(g: &mut Graph, known: &Known) -> Option<Bindings> {
    if !are_offered(known) {
        return None;
    }
    let (Formed { flat, unreduced: at, .. }, model) = (known.formed, known.model);
    let (bound, n) = (at.bound, at.coordinates);
    let values: Vec<Value> = model.bindings.iter().map(|b| b.value).collect();
    let explicit = g.forward(&values, |s| (s == Symbol::Time).then_some(Value::ONE));
    let explicit = flattened(g, flat, &explicit);
    let velocity: Vec<Value> = (0..n).map(|i| g.symbol(Symbol::Velocity(i))).collect();
    let rate = |x: usize| if x < bound { flat[x][1] } else { velocity[x - bound] };

    // Unknowns that are convolved: forces that act along slopes that move, accelerations that inertia that moves
    // belongs to.
    let mut wanted: Vec<usize> = (bound..bound + n).collect();
    let mut place = |unknown: usize| {
        wanted.iter().position(|w| *w == unknown).unwrap_or_else(|| {
            wanted.push(unknown);
            wanted.len() - 1
        })
    };
    let mut tails: Vec<Vec<(Value, usize)>> = vec![Vec::new(); bound + n];
    for (i, row) in at.hessian.iter().enumerate() {
        for &(j, h) in row.iter().filter(|(_, h)| !is_number(g, *h)) {
            tails[i].push((-h, place(j)));
        }
    }
    for (k, row) in at.tangents.iter().enumerate() {
        for &(i, s) in row.iter().filter(|(_, s)| !is_number(g, *s)) {
            tails[i].push((s, place(bound + n + k)));
        }
    }

    let mut rights = Vec::new();
    let mut given = vec![Value::ZERO; 2 * bound + n];
    let mut add = |g: &mut Graph, row: usize, right: Right| {
        given[row] = g.symbol(Symbol::Given(rights.len()));
        rights.push(right);
    };
    for (i, tails) in tails.into_iter().enumerate() {
        let force = at.e[i];
        if !force.is_zero() || !tails.is_empty() {
            add(g, i, Right::Forces { force, tails });
        }
    }
    let mut rates = Vec::new();
    for k in 0..bound {
        let moving = at.tangents[k].iter().filter(|(x, s)| !is_number(g, *s) && !rate(*x).is_zero());
        let moving: Vec<[Value; 2]> = moving.map(|&(x, s)| [s, rate(x)]).collect();
        rates.extend(moving.iter().map(|[s, r]| g.mul(*s, *r)));
        if !moving.is_empty() || !is_number(g, explicit[k]) {
            add(g, bound + n + k, Right::Definition { explicit: explicit[k], terms: moving });
        }
    }

    let mut best: Option<(usize, &Factors)> = None;
    for factors in &known.solved.orders {
        let all = factors.unknowns(&mut Literal(g), given.clone());
        let wanted: Vec<Value> = wanted.iter().map(|x| all[*x]).collect();
        let moved = g.dependent(&wanted, |s| matches!(s, Symbol::Given(_)));
        // An operation for each node at least.
        if best.is_some_and(|(least, _)| moved.len() >= least + rights.len()) {
            continue;
        }
        let known = |v: Value| v.node.is_some_and(|id| moved.get(&id).is_none());
        let cost = program_from(g, &wanted, known).operations().cost();
        if best.is_none_or(|(least, _)| cost < least) {
            best = Some((cost, factors));
        }
    }
    let (_, factors) = best?;
    let all = factors.unknowns(g, given);
    let wanted: Vec<Value> = wanted.iter().map(|x| all[*x]).collect();
    let solution = Substitution::new(g, &wanted)?;
    Some(Bindings { coordinates: n, rights, solution, rates })
}

/// Right-hand sides as they are written.
struct Literal<'a>(&'a mut Graph);

impl Arithmetic for Literal<'_> {
    type Number = Value;

    fn scale(&mut self, k: Value, x: Value) -> Value {
        self.0.times(k, x)
    }

    fn add(&mut self, x: Value, y: Value) -> Value {
        self.0.plus(x, y)
    }

    fn sub(&mut self, x: Value, y: Value) -> Value {
        self.0.minus(x, y)
    }
}

impl Form for Bindings {
    fn name(&self) -> &'static str {
        "bindings"
    }

    fn values(&self) -> Vec<Value> {
        let mut values = self.rates.clone();
        for right in &self.rights {
            match right {
                Right::Forces { force, tails } => {
                    values.push(*force);
                    values.extend(tails.iter().map(|(v, _)| *v));
                }
                Right::Definition { explicit, terms } => {
                    values.push(*explicit);
                    values.extend(terms.iter().flatten());
                }
            }
        }
        values
    }

    fn advance(&self, _: &[Value], orders: &mut Orders) -> Motion {
        let rights: Vec<Value> = self.rights.iter().map(|right| right.coefficient(orders)).collect();
        let found = self.solution.solve(orders.g, &rights);
        orders.unknowns = found.iter().map(|x| [Value::ZERO, *x]).collect();
        let mut velocities = Vec::new();
        for (i, x) in found[..self.coordinates].iter().enumerate() {
            let velocity = orders.over(*x);
            orders.set_velocity(i, velocity);
            velocities.push((i, velocity));
        }
        Motion { accelerations: Vec::new(), velocities }
    }
}

impl Right {
    fn coefficient(&self, orders: &mut Orders) -> Value {
        match self {
            Right::Forces { force, tails } => {
                let mut sum = orders.before(*force);
                for &(v, x) in tails {
                    if let Some(id) = v.node {
                        let middle = orders.middle([Factor::Of(id), Factor::Unknown(x)]);
                        sum = orders.g.plus(sum, middle.scaled(v.k));
                    }
                }
                sum
            }
            Right::Definition { explicit, terms } => {
                let slopes: Vec<Value> = terms.iter().map(|[slope, _]| *slope).chain([*explicit]).collect();
                let mut next = orders.of(&slopes);
                let mut sum = next.pop().unwrap_or(Value::ZERO);
                for (&[slope, rate], next) in terms.iter().zip(next) {
                    let (Some(of), Some(id)) = (slope.node, rate.node.filter(|_| !is_number(orders.g, rate)))
                    else {
                        sum = orders.g.plus_product(sum, next, rate);
                        continue;
                    };
                    let middle = orders.middle([Factor::Of(of), Factor::Of(id)]);
                    let next = next.scaled(slope.k.recip());
                    let term = orders.g.plus_product(middle, next, id.into());
                    sum = orders.g.plus(sum, term.scaled(slope.k.mul(rate.k)));
                }
                let level = orders.input(Coefficient::Level);
                orders.g.times(level, sum)
            }
        }
    }
}
