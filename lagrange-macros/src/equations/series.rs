//! The Taylor series of a motion, order by order, from the same graph that `accel` comes from.
//!
//! Coefficients of order k are expressions in those of order 0 and in a few inputs of each order
//! (`series/orders.rs`): a recurrence is a program like any other, which is counted, evaluated and printed as `accel`
//! is.
//!
//! There are several forms of the equations, a file each, and the one whose program has the fewest operations is taken:
//!
//! - [`Accelerations`]: their expressions;
//! - [`Matrix`]: M q̈ = right as a series, also bordered by constraints;
//! - [`Momenta`](momenta::Momenta): ṗ = f, as long as what was written;
//! - [`Bindings`](bindings::Bindings): the equations where they were written, with the accelerations of the bindings
//!   and the forces that hold them among the unknowns. Of chains and trees that has the fewest products;
//! - [`Conserved`](conserved::Conserved): velocities of ignorable coordinates from their momenta, accelerations of
//!   the others.
//!
//! What is solved for an order is solved as it is for the accelerations, with what cancels in the pivots of M_0
//! cancelled by symbols: by numbers a body near a pole of its angles, at an inclination of θ, has coefficients that
//! are wrong by ε/θ².
//!
//! Convolutions dominate: so all forms but the equations at the bindings are also tried with as few products
//! as common factors and common parts leave of them (`graph/gather.rs`).

mod accelerations;
mod attitudes;
mod bindings;
mod conserved;
mod form;
mod matrix;
mod momenta;
mod orders;
mod recurrence;
mod substitution;
pub mod switches;

pub use recurrence::{CONVOLUTIONS_PER_VECTOR, MAX_UNROLLED_CONVOLUTIONS, Recurrence};

use super::check;
use super::common::{MAX_EXPANDED_COORDINATES, symbols};
use super::elimination::MAX_DENSE_COORDINATES;
use super::formed::Formed;
use super::quantities::Quantities;
use super::solve::Symmetric;
use super::solved::Solved;
use super::structure::Facts;
use crate::graph::{Graph, Symbol, Value};
use crate::model::Model;
use crate::program::Program;
use accelerations::Accelerations;
use attitudes::Attitudes;
use form::{Form, Known};
use matrix::Matrix;
use orders::Orders;
use std::rc::Rc;
use substitution::Substitution;

/// Systems of more convolutions have no series emitted: it would cost more to compile than it saves.
const MAX_CONVOLUTIONS: usize = 20_000;
/// Orders of at most this many operations are compiled for each kind of processor.
const MAX_OPERATIONS_COMPILED_TWICE: usize = 1000;
/// The series of a motion.
pub struct Series {
    pub recurrence: Recurrence,
    /// Program of an order: [`Recurrence::next`].
    pub program: Program,
    /// The constants of the program and then [`Recurrence::first`], of the first state.
    pub start: Vec<Value>,
    /// All forms that were tried.
    pub tried: Vec<Tried>,
    /// Functions whose signs are the sides that the recurrences name.
    pub switches: Vec<Value>,
    /// Are there states with finite accelerations at which there is no series?
    pub has_roots: bool,
}

impl Series {
    /// Is an order so long that it is compiled once, and only its sums over orders for better processors?
    pub fn is_long(&self) -> bool {
        !self.recurrence.straight() && self.program.operations().arithmetic() > MAX_OPERATIONS_COMPILED_TWICE
    }
}

/// A form of the equations, and what its series cost.
pub struct Tried {
    pub way: String,
    /// A lower bound, where that is enough to know that another form costs less.
    pub cost: usize,
    pub is_bound: bool,
}

/// The recurrences with the fewest operations; none for systems with functions of the user's or powers whose
/// exponents move.
pub fn series(
    g: &mut Graph,
    model: &Model,
    formed: &Formed,
    solved: &Solved,
    quantities: &Quantities,
    facts: &Facts,
    impulses: &[Value],
) -> Option<Series> {
    let known = Known { model, formed, solved, quantities, facts, impulses };
    let (forms, switches) = forms(g, &known);
    let (mut tried, mut recurrences) = (Vec::new(), Vec::new());
    for (way, form, values) in forms {
        let Some(mut orders) = Orders::new(g, &[&values[..], &switches].concat()) else { continue };
        let motion = form.advance(&values, &mut orders);
        let recurrence = orders.finish(motion, &switches);
        tried.push(Tried { way, cost: 0, is_bound: true });
        recurrences.push((recurrence, values));
    }
    let (best, program) = cheapest(g, &recurrences, &mut tried)?;
    let (recurrence, values) = recurrences.swap_remove(best);
    if recurrence.convolutions.len() > MAX_CONVOLUTIONS {
        return None;
    }
    let first = [program.constants.clone(), recurrence.first()].concat();
    let has_roots = g.has_roots(&values);
    // Momenta that are conserved are numbers that the first state gives.
    let start = g.substitute(&first, |s| match s {
        Symbol::Conserved(i) => Some(quantities.momenta[i]),
        _ => Attitudes::at_start(&known, s),
    });
    Some(Series { recurrence, program, start, tried, switches, has_roots })
}

/// The place of the cheapest recurrence, the first among equals, and its program. Those with the lowest bounds are
/// counted first, and only as long as bounds leave room for something better.
fn cheapest(
    g: &Graph,
    recurrences: &[(Recurrence, Vec<Value>)],
    tried: &mut [Tried],
) -> Option<(usize, Program)> {
    if tried.len() > 1 {
        recurrences
            .iter()
            .zip(&mut *tried)
            .for_each(|((recurrence, _), form)| form.cost = recurrence.least_cost(g));
    }
    let mut order: Vec<(usize, usize)> = tried.iter().enumerate().map(|(i, form)| (form.cost, i)).collect();
    order.sort_unstable();
    let mut best: Option<((usize, usize), Program)> = None;
    for bound in order {
        if best.as_ref().is_some_and(|(least, _)| *least < bound) {
            break;
        }
        let (recurrence, form) = (&recurrences[bound.1].0, &mut tried[bound.1]);
        let program = recurrence.program(g);
        (form.cost, form.is_bound) = (recurrence.cost(g, &program), false);
        let cost = (form.cost, bound.1);
        debug_assert!(bound <= cost, "a bound of what a series costs is too high");
        if best.as_ref().is_none_or(|(least, _)| cost < *least) {
            best = Some((cost, program));
        }
    }
    best.map(|((_, place), program)| (place, program))
}

type Candidate = (String, Rc<dyn Form>, Vec<Value>);

/// All forms that the equations have, and what their sides are those of.
fn forms(g: &mut Graph, known: &Known) -> (Vec<Candidate>, Vec<Value>) {
    let Known { formed, solved: Solved { inertia, right, accel, .. }, impulses, .. } = known;
    let n = accel.len();
    // The equations at the bindings were the shortest in every system of so many coordinates that was counted.
    let at_bindings = n > MAX_EXPANDED_COORDINATES
        && bindings::are_offered(known)
        && switches::switching(g, accel).is_empty();
    let solution = if at_bindings { None } else { solution(g, known) };
    let (matrix, right) = formed.rows.border(inertia, right);
    let entries: Vec<Value> = matrix.iter().flatten().copied().collect();
    let written = [&accel[..], &entries, &right, solution.as_deref().unwrap_or_default()].concat();
    let (sided, switches) = match switches::switching(g, accel)[..] {
        [] if impulses.is_empty() => (written, Vec::new()),
        _ => switches::sided(g, &written, impulses),
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
    let (place, mut bindings) = (forms.len(), None);
    if switches.is_empty() {
        if let Some(solution) = solution.filter(|_| free) {
            let momenta = momenta::forms(g, formed, &solution).into_iter();
            forms.extend(momenta.map(|form| -> Rc<dyn Form> { Rc::new(form) }));
        }
        bindings = bindings::form(g, known).map(|form| -> Rc<dyn Form> { Rc::new(form) });
        if n <= MAX_EXPANDED_COORDINATES {
            forms
                .extend(conserved::forms(g, known).into_iter().map(|form| -> Rc<dyn Form> { Rc::new(form) }));
        }
    }
    if bindings.is_none() || !at_bindings {
        forms.insert(place, Rc::new(Accelerations(accel.to_vec())));
    }
    // With attitudes these have common factors as well.
    if !formed.unreduced.attitudes.is_empty() {
        forms.extend(bindings.take());
    }
    let mut all: Vec<Candidate> = Vec::new();
    if switches.is_empty() && n <= MAX_EXPANDED_COORDINATES {
        for form in &forms {
            let (written, name) = (form.values(), format!("{}, few products", form.name()));
            let gathered = g.gathered(&written);
            if gathered != written {
                all.push((name, Rc::clone(form), gathered));
            }
        }
    }
    forms.extend(bindings);
    let written = forms.into_iter().map(|form| (form.name().into(), Rc::clone(&form), form.values()));
    (written.chain(all).collect(), switches)
}

/// Solution of M x = given, M bordered, as for the accelerations; none of a matrix so large that it would be long.
fn solution(g: &mut Graph, known: &Known) -> Option<Vec<Value>> {
    let size = known.solved.accel.len() + known.formed.rows.len();
    if size > MAX_DENSE_COORDINATES {
        return None;
    }
    let given = symbols(g, Symbol::Given, size);
    let solution = known.solved.solver.solve(g, &[given])?.pop()?;
    Some(g.share_angles(&solution))
}
