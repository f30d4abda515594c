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
//!
//! The definition of an ω is one of these, too, in frames in space with attitudes, which are written in quaternions and
//! angular velocities (`attitudes.rs`). Accelerations of points and of axes are no derivatives of rates; theirs is
//!
//! ```text
//!   ü_{k−1} − S_0 ẍ_{k−1} = γ_{k−1} + Σ_{j≥1} S_j ẍ_{k−1−j}.
//! ```

use super::attitudes::Attitudes;
use super::form::{Form, Known};
use super::orders::{Factor, Orders};
use super::{recurrence::Motion, substitution::Substitution};
use crate::equations::assemble::{self, Unreduced, flattened, unreduced};
use crate::equations::augmented::{Arithmetic, Factors};
use crate::equations::common::is_number;
use crate::graph::{Coefficient, Graph, Symbol, Value};
use crate::model::Model;
use crate::model::frames::Motion as Moves;
use crate::program::lower::program_from;

/// A right-hand side of the equations.
enum Right {
    /// One that is known, e or γ, and unknowns times nodes that move.
    Known { value: Value, tails: Vec<(Value, usize)> },
    /// Right-hand side of the definition of a binding: φ_t, and the slopes that move with the velocities they belong
    /// to.
    Definition { explicit: Value, terms: Vec<[Value; 2]> },
}

/// The equations of one order.
pub struct Bindings {
    coordinates: usize,
    /// Right-hand sides that are `Given` to the solution.
    rights: Vec<Right>,
    /// Accelerations of the coordinates and of the frames that turn, and then the other unknowns that are convolved.
    solution: Substitution,
    /// Velocities times slopes: the derivatives of sines and cosines are among them.
    rates: Vec<Value>,
    attitudes: Attitudes,
    /// Rates of the quaternions.
    turning: Vec<Value>,
}

/// Has a system equations at its bindings? Not with constraints, and with frames in space where these have attitudes.
pub fn are_offered(known: &Known) -> bool {
    let Known { model, formed, solved, .. } = known;
    let attitudes = &formed.unreduced.attitudes;
    let positions = model.bindings.iter().all(|b| matches!(b.motion, Moves::Position));
    let attached = !attitudes.is_empty() && attitudes.len() == model.attitudes.len();
    (positions || attached) && formed.rows.is_empty() && !solved.orders.is_empty()
}

pub fn form(g: &mut Graph, known: &Known) -> Option<Bindings> {
    if !are_offered(known) {
        return None;
    }
    let mut attitudes = Attitudes::new(known);
    let turned = (!attitudes.is_empty()).then(|| turned(g, known.model, &mut attitudes));
    let (flat, at) = match &turned {
        Some((flat, at)) => (flat, at),
        None => (&known.formed.flat, &known.formed.unreduced),
    };
    let (bound, n) = (at.bound, at.coordinates);
    let mut wanted: Vec<usize> = (bound..bound + n).chain(attitudes.spins.iter().copied()).collect();
    let written = Written { model: known.model, flat, at, attitudes: &attitudes };
    let (rows, rights) = written.rights(g, &mut wanted).into_iter().unzip::<_, _, Vec<usize>, Vec<Right>>();
    let mut given = vec![Value::ZERO; 2 * bound + n];
    for (place, row) in rows.into_iter().enumerate() {
        given[row] = g.symbol(Symbol::Given(place));
    }
    let rates = written.rates(g);
    let factors = cheapest(g, known, &wanted, (&given, rights.len()))?;
    let all = factors.eliminated(g, given);
    let wanted: Vec<Value> = wanted.iter().map(|x| all[*x]).collect();
    let solution = Substitution::new(g, &wanted)?;
    let turning = attitudes.values(g);
    let form = Bindings { coordinates: n, rights, solution, rates, attitudes, turning };
    let values = form.values();
    (!g.depends(&values, |s| form.attitudes.is_parameter(s))).then_some(form)
}

/// The bindings and the equations in terms of quaternions and angular velocities, without bindings that nothing is
/// inert at or made of: their forces are known, and act where these have theirs from.
fn turned(g: &mut Graph, model: &Model, attitudes: &mut Attitudes) -> (Vec<[Value; 2]>, Unreduced) {
    let mut form = assemble::Form::of(model);
    attitudes.write(g, &mut form);
    let flat = attitudes.flat(g, &form);
    let mut at = unreduced(g, &form, &flat);
    for k in (0..at.bound).rev() {
        let is_turn = attitudes.is_turn(k);
        if is_turn {
            // Its acceleration is that of the coordinate.
            at.tangents[k].clear();
        }
        let named = at.tangents.iter().flatten().any(|(x, _)| *x == k);
        if is_turn || named || !at.hessian[k].is_empty() || attitudes.spins.contains(&k) {
            continue;
        }
        let force = std::mem::replace(&mut at.e[k], Value::ZERO);
        for (x, slope) in std::mem::take(&mut at.tangents[k]) {
            let part = g.mul(slope, force);
            at.e[x] = g.add(at.e[x], part);
        }
        at.gamma[k] = Value::ZERO;
    }
    (flat, at)
}

/// The order of elimination in which the required unknowns have the fewest operations.
fn cheapest<'a>(
    g: &mut Graph,
    known: &'a Known,
    wanted: &[usize],
    (given, rights): (&[Value], usize),
) -> Option<&'a Factors> {
    let mut best: Option<(usize, &Factors)> = None;
    for factors in &known.solved.orders {
        let all = factors.eliminated(&mut Literal(g), given.to_vec());
        let wanted: Vec<Value> = wanted.iter().map(|x| all[*x]).collect();
        let moved = g.dependent(&wanted, |s| matches!(s, Symbol::Given(_)));
        // An operation for each node at least.
        if best.is_some_and(|(least, _)| moved.len() >= least + rights) {
            continue;
        }
        let known = |v: Value| v.node.is_some_and(|id| moved.get(&id).is_none());
        let cost = program_from(g, &wanted, known).operations().cost();
        if best.is_none_or(|(least, _)| cost < least) {
            best = Some((cost, factors));
        }
    }
    best.map(|(_, factors)| factors)
}

/// The equations at the bindings, and what they are written in.
struct Written<'a> {
    model: &'a Model,
    flat: &'a [[Value; 2]],
    at: &'a Unreduced,
    attitudes: &'a Attitudes,
}

impl Written<'_> {
    fn rate(&self, g: &mut Graph, x: usize) -> Value {
        if x < self.at.bound { self.flat[x][1] } else { g.symbol(Symbol::Velocity(x - self.at.bound)) }
    }

    /// Is the acceleration of this binding the derivative of its rate? Otherwise γ is part of it.
    fn is_derivative(&self, k: usize) -> bool {
        let motion = self.model.bindings[k].motion;
        let of_frame = |k| self.model.frames.spins.iter().flatten().any(|spin| *spin == Some(k));
        matches!(motion, Moves::Position) || of_frame(k)
    }

    /// Slopes of a binding that move, with the velocities they belong to.
    fn moving(&self, g: &mut Graph, k: usize) -> Vec<[Value; 2]> {
        let moving =
            self.at.tangents[k].iter().filter(|(_, s)| !is_number(g, *s)).copied().collect::<Vec<_>>();
        let moving = moving.into_iter().map(|(x, s)| [s, self.rate(g, x)]);
        moving.filter(|[_, rate]| !rate.is_zero()).collect()
    }

    /// Products of series that sines have anyway.
    fn rates(&self, g: &mut Graph) -> Vec<Value> {
        let bindings = self.model.bindings.iter().enumerate();
        let positions = bindings.filter(|(_, b)| matches!(b.motion, Moves::Position));
        let moving: Vec<_> = positions.flat_map(|(k, _)| self.moving(g, k)).collect();
        moving.into_iter().map(|[s, r]| g.mul(s, r)).collect()
    }

    /// Right-hand sides by their rows. Unknowns that are convolved are wanted: forces that act along slopes that move,
    /// accelerations that inertia or slopes that move belong to.
    fn rights(&self, g: &mut Graph, wanted: &mut Vec<usize>) -> Vec<(usize, Right)> {
        let Unreduced { bound, coordinates: n, ref hessian, ref tangents, .. } = *self.at;
        let mut place = |unknown: usize| {
            wanted.iter().position(|w| *w == unknown).unwrap_or_else(|| {
                wanted.push(unknown);
                wanted.len() - 1
            })
        };
        let mut tails: Vec<Vec<(Value, usize)>> = vec![Vec::new(); 2 * bound + n];
        for (i, row) in hessian.iter().enumerate() {
            for &(j, h) in row.iter().filter(|(_, h)| !is_number(g, *h)) {
                tails[i].push((-h, place(j)));
            }
        }
        for (k, row) in tangents.iter().enumerate() {
            for &(i, s) in row.iter().filter(|(_, s)| !is_number(g, *s)) {
                tails[i].push((s, place(bound + n + k)));
                if !self.is_derivative(k) {
                    tails[bound + n + k].push((s, place(i)));
                }
            }
        }
        let explicit = self.explicit(g);
        let mut rights = Vec::new();
        for (row, tails) in tails.into_iter().enumerate() {
            let binding = row.checked_sub(bound + n);
            let value = binding.map_or_else(|| self.at.e[row], |k| self.at.gamma[k]);
            match binding.filter(|k| self.is_derivative(*k)) {
                Some(k) if self.attitudes.is_turn(k) => {}
                Some(k) => {
                    let (explicit, terms) = (explicit[k], self.moving(g, k));
                    if !terms.is_empty() || !is_number(g, explicit) {
                        rights.push((row, Right::Definition { explicit, terms }));
                    }
                }
                None if value.is_zero() && tails.is_empty() => {}
                None => rights.push((row, Right::Known { value, tails })),
            }
        }
        rights
    }

    /// Rates of the bindings while all others are at rest.
    fn explicit(&self, g: &mut Graph) -> Vec<Value> {
        let values: Vec<Value> = self.model.bindings.iter().map(|b| b.value).collect();
        let mut explicit = g.forward(&values, |s| (s == Symbol::Time).then_some(Value::ONE));
        for (explicit, binding) in explicit.iter_mut().zip(&self.model.bindings) {
            if let Moves::Quasi(_) = binding.motion {
                let at_rest = |s| matches!(s, Symbol::Rate(_) | Symbol::Velocity(_)).then_some(Value::ZERO);
                *explicit = g.substitute(&[binding.rate], at_rest)[0];
            }
        }
        flattened(g, self.flat, &explicit)
    }
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
        let rights = self.rights.iter().flat_map(Right::values);
        self.rates.iter().chain(&self.turning).copied().chain(rights).collect()
    }

    fn advance(&self, values: &[Value], orders: &mut Orders) -> Motion {
        let (turning, values) = values[self.rates.len()..].split_at(self.turning.len());
        self.attitudes.turn(turning, orders);
        let mut values = values.iter().copied();
        let rights: Vec<Value> =
            self.rights.iter().map(|right| right.with(&mut values).coefficient(orders)).collect();
        let found = self.solution.solve(orders.g, &rights);
        orders.unknowns = found.iter().map(|x| [Value::ZERO, *x]).collect();
        let mut velocities = Vec::new();
        for (i, x) in found[..self.coordinates].iter().enumerate() {
            let velocity = orders.over(*x);
            if let Some(omega) = self.attitudes.turned_by(i) {
                orders.set(omega, velocity);
                continue;
            }
            orders.set(Symbol::Velocity(i), velocity);
            velocities.push((i, velocity));
        }
        for (k, x) in self.attitudes.spins.iter().zip(&found[self.coordinates..]) {
            let omega = orders.over(*x);
            orders.set(Symbol::Rate(*k), omega);
        }
        let coordinates = self.attitudes.parameters(orders);
        Motion { velocities, coordinates, ..Motion::default() }
    }
}

impl Right {
    /// Expressions whose series it needs.
    fn values(&self) -> Vec<Value> {
        match self {
            Right::Known { value, tails } => {
                [*value].into_iter().chain(tails.iter().map(|(v, _)| *v)).collect()
            }
            Right::Definition { explicit, terms } => {
                [*explicit].into_iter().chain(terms.iter().flatten().copied()).collect()
            }
        }
    }

    /// The same with these values in place of its own.
    fn with(&self, values: &mut impl Iterator<Item = Value>) -> Right {
        let mut next = |_: Value| values.next().expect("a value in place of each");
        match self {
            Right::Known { value, tails } => Right::Known {
                value: next(*value),
                tails: tails.iter().map(|(v, x)| (next(*v), *x)).collect(),
            },
            Right::Definition { explicit, terms } => Right::Definition {
                explicit: next(*explicit),
                terms: terms.iter().map(|pair| pair.map(&mut next)).collect(),
            },
        }
    }

    fn coefficient(&self, orders: &mut Orders) -> Value {
        match self {
            Right::Known { value, tails } => {
                let mut sum = orders.before(*value);
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
                let mut sum = next.pop().expect("the explicit part behind the slopes");
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
