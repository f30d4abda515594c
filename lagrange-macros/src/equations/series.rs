//! The Taylor series of a motion, order by order, from the same graph that `accel` comes from.
//!
//! Coefficients of order k are expressions in those of order 0 and in a few inputs of each order (`series/orders.rs`): a recurrence is a
//! program like any other, which is counted, evaluated and printed as `accel` is.
//!
//! There are several forms of the equations, a file each, and the one whose program has the fewest operations is taken:
//!
//! - [`Accelerations`]: their expressions;
//! - [`Matrix`]: M q̈ = right as a series, also bordered by constraints;
//! - [`Momenta`](momenta::Momenta): ṗ = f, as long as what was written;
//! - [`Bindings`](bindings::Bindings): the equations where they were written, with the accelerations of the bindings and the forces that
//!   hold them among the unknowns. Of chains and trees that has the fewest products;
//! - [`Conserved`](conserved::Conserved): velocities of ignorable coordinates from their momenta, accelerations of the others.
//!
//! What is solved for an order is solved as it is for the accelerations, with what cancels in the pivots of M_0 cancelled by symbols: by numbers a body near
//! a pole of its angles, at an inclination of θ, has coefficients that are wrong by ε/θ².
//!
//! Convolutions dominate: so all forms but the equations at the bindings are also tried with as few products
//! as common factors and common parts leave of them (`graph/gather.rs`).

mod accelerations;
mod bindings;
mod conserved;
mod matrix;
mod momenta;
mod orders;
mod substitution;
pub mod switches;

pub use orders::is_number;

use super::elimination::MAX_DENSE_COORDINATES;
use super::formed::Formed;
use super::outputs::Quantities;
use super::solve::Symmetric;
use super::solved::Solved;
use super::structure::Facts;
use super::{MAX_EXPANDED_COORDINATES, check, symbols};
use crate::graph::{Graph, Symbol, Value, stable_map::IdMap};
use crate::model::Model;
use crate::schedule::count::{operations, operations_without};
use crate::schedule::{Program, below, schedule_from};
use accelerations::Accelerations;
use matrix::Matrix;
use orders::Orders;
use std::rc::Rc;
use substitution::Substitution;

/// Systems of more convolutions have no series emitted: it would cost more to compile than it saves.
const MAX_CONVOLUTIONS: usize = 20_000;
/// Order of the series whose operations are counted: the highest that `Taylor` chooses by itself.
const COUNTED_ORDER: usize = 20;
/// Convolutions whose inner sums are formed together, as the elements of a vector.
pub const SIDE: usize = 4;
/// Systems of at most this many convolutions have their orders written out one by one by the optimiser, which makes
/// of sums straight lines; others loop.
pub const STRAIGHT: usize = 32;

/// The series of a motion.
pub struct Series {
    pub recurrence: Recurrence,
    /// What an order computes: [`Recurrence::next`].
    pub program: Program,
    /// The constants of the program and then [`Recurrence::first`], of the first state.
    pub start: Vec<Value>,
    /// Functions whose signs are the sides that the recurrences name.
    pub switches: Vec<Value>,
    /// Are there states with finite accelerations at which there is no series?
    pub has_roots: bool,
}

/// How the coefficients of an order follow from those before it.
pub struct Recurrence {
    /// Coefficients 0 and k of the factors of convolutions.
    pub factors: Vec<[Value; 2]>,
    /// The factors of each convolution.
    pub convolutions: Vec<[usize; 2]>,
    /// Coefficients 0 and k of what the next order is given.
    pub memory: Vec<[Value; 2]>,
    /// Coefficients 0 and k of the switching functions.
    pub switching: Vec<[Value; 2]>,
    /// Coefficients 0 and k of the accelerations, and those of order k of the velocities that are found instead.
    pub accelerations: Vec<(usize, [Value; 2])>,
    pub velocities: Vec<(usize, Value)>,
}

/// What is known of a system.
struct Known<'a> {
    model: &'a Model,
    formed: &'a Formed,
    solved: &'a Solved,
    quantities: &'a Quantities,
    facts: &'a Facts,
}

/// How the motion goes on, by coordinates.
struct Motion {
    accelerations: Vec<(usize, [Value; 2])>,
    velocities: Vec<(usize, Value)>,
}

/// A form of the equations of motion.
trait Form {
    /// Expressions whose series it needs.
    fn values(&self) -> Vec<Value>;

    /// The motion of an order, by these expressions in place of its own.
    fn advance(&self, values: &[Value], orders: &mut Orders) -> Motion;
}

/// The recurrences with the fewest operations; none for systems with functions of the user's or powers whose exponents move.
pub fn series(
    g: &mut Graph,
    model: &Model,
    formed: &Formed,
    solved: &Solved,
    quantities: &Quantities,
    facts: &Facts,
) -> Option<Series> {
    let (forms, switches) = forms(g, &Known { model, formed, solved, quantities, facts });
    let n = solved.accel.len();
    let mut best: Option<(usize, Recurrence, Vec<Value>)> = None;
    for (form, values) in forms {
        let Some(mut orders) = Orders::new(g, n, &[&values[..], &switches].concat()) else { continue };
        let motion = form.advance(&values, &mut orders);
        let recurrence = orders.finish(motion, &switches);
        let cost = recurrence.cost(g);
        if best.as_ref().is_none_or(|(least, ..)| cost < *least) {
            best = Some((cost, recurrence, values));
        }
    }
    let (_, recurrence, values) = best.filter(|(_, best, _)| best.convolutions.len() <= MAX_CONVOLUTIONS)?;
    let next = recurrence.next();
    let moved = moved(g, &next);
    let program = schedule_from(g, &next, |v| is_known(&moved, v));
    let first = [program.constants.clone(), recurrence.first()].concat();
    let has_roots = g.has_roots(&values);
    // Momenta that are conserved are numbers that the first state gives.
    let momentum = |s| if let Symbol::Conserved(i) = s { Some(quantities.momenta[i]) } else { None };
    let start = g.substitute(&first, momentum);
    Some(Series { recurrence, program, start, switches, has_roots })
}

type Candidate = (Rc<dyn Form>, Vec<Value>);

/// All forms that the equations have, and what their sides are those of.
fn forms(g: &mut Graph, known: &Known) -> (Vec<Candidate>, Vec<Value>) {
    let Known { formed, solved: Solved { inertia, right, accel, .. }, .. } = known;
    let n = accel.len();
    let solution = solution(g, known);
    let (matrix, right) = formed.rows.border(inertia, right);
    let entries: Vec<Value> = matrix.iter().flatten().copied().collect();
    let written = [&accel[..], &entries, &right, solution.as_deref().unwrap_or_default()].concat();
    let (sided, switches) = match switches::switching(g, accel)[..] {
        [] => (written, Vec::new()),
        _ => switches::sided(g, &written),
    };
    let (accel, rest) = sided.split_at(n);
    let (entries, rest) = rest.split_at(entries.len());
    let (right, unknowns) = rest.split_at(right.len());
    let mut entries = entries.iter().copied();
    let matrix: Symmetric = matrix.iter().map(|row| entries.by_ref().take(row.len()).collect()).collect();

    let free = formed.rows.is_empty() && switches.is_empty();
    let solution = solution.and_then(|_| {
        // No inverse of what may be nearly singular, nor of what constraints border.
        let explicit = free && check::is_regular(g, inertia, &known.model.coordinates);
        if explicit { Some(Substitution::explicit(g, unknowns)) } else { Substitution::new(g, unknowns) }
    });
    let solution = solution.map(Rc::new);
    let mut forms: Vec<Rc<dyn Form>> = Vec::new();
    if let Some(solution) = solution.clone().filter(|_| n > 1) {
        forms.push(Rc::new(Matrix { coordinates: n, matrix, right: right.to_vec(), solution }));
    }
    forms.push(Rc::new(Accelerations(accel.to_vec())));
    let mut bindings = None;
    if switches.is_empty() {
        if let Some(solution) = solution.filter(|_| free) {
            forms.extend(momenta::forms(g, formed, &solution).map(|form| -> Rc<dyn Form> { Rc::new(form) }));
        }
        bindings = bindings::form(g, known);
        if n <= MAX_EXPANDED_COORDINATES {
            forms
                .extend(conserved::forms(g, known).into_iter().map(|form| -> Rc<dyn Form> { Rc::new(form) }));
        }
    }
    let mut all: Vec<Candidate> = Vec::new();
    if switches.is_empty() && n <= MAX_EXPANDED_COORDINATES {
        all.extend(forms.iter().map(|form| (Rc::clone(form), g.gathered(&form.values()))));
    }
    forms.extend(bindings.map(|form| -> Rc<dyn Form> { Rc::new(form) }));
    let written = forms.into_iter().map(|form| (Rc::clone(&form), form.values()));
    (written.chain(all).collect(), switches)
}

/// What M x = given is solved by, M bordered, as it is for the accelerations; none of a matrix so large that it would be long.
fn solution(g: &mut Graph, known: &Known) -> Option<Vec<Value>> {
    let size = known.solved.accel.len() + known.formed.rows.len();
    if size > MAX_DENSE_COORDINATES {
        return None;
    }
    let given = symbols(g, Symbol::Given, size);
    let solution = known.solved.solver.solve(g, &[given])?.pop()?;
    Some(g.share_angles(&solution))
}

impl Recurrence {
    fn pairs(&self) -> impl Iterator<Item = &[Value; 2]> {
        let pairs = self.factors.iter().chain(&self.memory).chain(&self.switching);
        pairs.chain(self.accelerations.iter().map(|a| &a.1))
    }

    /// All that an order computes.
    pub fn next(&self) -> Vec<Value> {
        self.pairs().map(|pair| pair[1]).chain(self.velocities.iter().map(|v| v.1)).collect()
    }

    /// The same of order 0, but for the velocities.
    pub fn first(&self) -> Vec<Value> {
        self.pairs().map(|pair| pair[0]).collect()
    }

    /// The coordinates whose accelerations are found.
    pub fn kept(&self) -> Vec<usize> {
        self.accelerations.iter().map(|(i, _)| *i).collect()
    }

    /// Are its orders written out one by one?
    pub fn straight(&self) -> bool {
        self.convolutions.len() <= STRAIGHT
    }

    /// The convolutions of two factors, and those of one, by their places. A square takes half the operations of a product, but no more time where
    /// a vector of products has room for it.
    pub fn layout(&self) -> [Vec<usize>; 2] {
        let is_square = |i: &usize| self.convolutions[*i][0] == self.convolutions[*i][1];
        let (squares, mut products): (Vec<usize>, Vec<usize>) =
            (0..self.convolutions.len()).partition(is_square);
        let room = products.len().next_multiple_of(SIDE) - products.len();
        if self.straight() && products.len() > SIDE / 2 && squares.len() <= room {
            products.extend(squares);
            return [products, Vec::new()];
        }
        [products, squares]
    }

    /// Operations of a series, those of a vector of convolutions counted once.
    fn cost(&self, g: &Graph) -> usize {
        let next = self.next();
        let moved = moved(g, &next);
        let order = operations_without(g, &next, |v| is_known(&moved, v)).cost();
        let once = operations(g, &self.first()).cost();
        let [products, squares] = self.layout();
        // An inner sum of order k has k − 3 products; that of a square half of them.
        let inner: usize = (4..=COUNTED_ORDER).map(|k| k - 3).sum();
        let rows = 2 * products.len().div_ceil(SIDE) + squares.len().div_ceil(SIDE);
        // Coordinates, and velocities where they come from accelerations, are divided by the order.
        let divisions = 2 * self.accelerations.len() + self.velocities.len();
        // What velocities are found of has no coefficient more than they have.
        let orders = COUNTED_ORDER + usize::from(!self.velocities.is_empty());
        once + orders * (order + 4 * divisions) + inner * rows
    }
}

/// The nodes that an order computes.
fn moved(g: &Graph, next: &[Value]) -> IdMap<()> {
    below(g, next, |s| matches!(s, Symbol::Order(_)))
}

/// Is it known before the order begins, and no literal?
fn is_known(moved: &IdMap<()>, v: Value) -> bool {
    v.node.is_some_and(|id| moved.get(&id).is_none())
}
