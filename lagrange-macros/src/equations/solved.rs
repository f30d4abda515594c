//! The accelerations, and the forces of constraints that follow with them.

use super::assemble::reactions;
use super::augmented::Factors;
use super::check;
use super::common::{shortest, symbols};
use super::elimination::{Candidate, Eliminated, Solver, eliminated};
use super::formed::{Formed, System};
use super::solve::Symmetric;
use crate::diagnostics::Errors;
use crate::graph::{Graph, Symbol, Value};
use crate::model::Model;
use crate::program::count::{Operations, operations};
use std::rc::Rc;

/// M q̈ = right in the form that costs least, and its solution.
pub struct Solved {
    /// M = ∂²L/∂q̇²
    pub inertia: Symmetric,
    /// f − b
    pub right: Vec<Value>,
    pub accel: Vec<Value>,
    /// λ
    pub multipliers: Vec<Value>,
    /// Generalized forces at the prescribed coordinates.
    pub reactions: Vec<Value>,
    /// The same in terms of q̈ and λ, as the equations of the relaxed coordinates have them.
    pub relaxed: Vec<Value>,
    pub operations: Operations,
    /// Solver of the bordered system for any right-hand side.
    pub solver: Solver,
    /// All orders of elimination that have pivots, of the equations where they were written.
    pub orders: Vec<Rc<Factors>>,
    /// All ways of solving that were tried.
    pub tried: Vec<Candidate>,
}

pub fn solved(g: &mut Graph, model: &Model, formed: &Formed, errors: &mut Errors) -> Option<Solved> {
    let (n, at) = (model.coordinates.len(), &formed.unreduced);
    if formed.rows.redundancy.is_some() {
        return if errors.is_empty() { Some(at_run_time(g, model, formed)) } else { None };
    }
    let Some(best) = eliminated(g, at, &formed.systems, n) else {
        check::unsolvable(&model.coordinates, &model.keywords, errors);
        return None;
    };
    if !errors.is_empty() {
        return None;
    }
    let Eliminated { mut matrix, mut right, solver, accel, multipliers, operations, orders, tried } = best;
    matrix.truncate(n);
    right.truncate(n);
    let prescribed: Vec<usize> = model.prescribed.iter().map(|p| p.binding).collect();
    let (mut known, mut relaxed) = (Vec::new(), Vec::new());
    if !prescribed.is_empty() {
        known = reactions(g, at, &prescribed, &multipliers, &accel);
        let lambda = symbols(g, Symbol::Multiplier, formed.rows.len());
        let qdd = symbols(g, Symbol::Acceleration, n);
        relaxed = reactions(g, at, &prescribed, &lambda, &qdd);
    }
    let reactions = shortest(g, n, &known);
    let multipliers = shortest(g, n, &multipliers);
    Some(Solved {
        inertia: matrix,
        right,
        accel,
        multipliers,
        reactions,
        relaxed,
        operations,
        solver,
        orders,
        tried,
    })
}

/// The accelerations and multipliers as symbols: where constraints follow from others, a function of the runtime
/// finds them.
fn at_run_time(g: &mut Graph, model: &Model, formed: &Formed) -> Solved {
    let (n, m) = (model.coordinates.len(), formed.rows.len());
    let needed = |system: &System| -> Vec<Value> {
        let rows = formed.rows.jacobian.iter().flatten().chain(&formed.rows.drift);
        system.matrix[..n].iter().flatten().chain(&system.right[..n]).chain(rows).copied().collect()
    };
    let counted = formed.systems.iter().map(|system| (operations(g, &needed(system)), system));
    let (operations, best) =
        counted.min_by_key(|(operations, _)| operations.cost()).expect("the equations as they were written");
    let (inertia, right) = (best.matrix[..n].to_vec(), best.right[..n].to_vec());
    let (accel, multipliers) = (symbols(g, Symbol::Acceleration, n), symbols(g, Symbol::Multiplier, m));
    let prescribed: Vec<usize> = model.prescribed.iter().map(|p| p.binding).collect();
    let reactions = if prescribed.is_empty() {
        Vec::new()
    } else {
        reactions(g, &formed.unreduced, &prescribed, &multipliers, &accel)
    };
    Solved {
        inertia,
        right,
        accel,
        multipliers,
        relaxed: reactions.clone(),
        reactions,
        operations,
        solver: Solver::AtRunTime,
        orders: Vec::new(),
        tried: Vec::new(),
    }
}
