//! Responses from the solution and its derivatives: momenta solved for velocities, Jacobians, switches.

use super::common::{in_time, inner, symbols};
use super::elimination::Solver;
use super::formed::Formed;
use super::quantities::Quantities;
use super::series::switches::{Switch, choices, cut};
use super::solve::entry;
use super::solved::Solved;
use super::structure::Facts;
use crate::graph::{Graph, Symbol, Value};
use crate::model::Model;
use crate::program::count::operations;

/// Derivatives of longer expressions, counted in operations times columns, are formed at run time by duals: emitted,
/// they would cost more to compile than they save.
const MAX_DERIVATIVE_OPERATIONS: usize = 1000;

/// Quantities from the solution and its derivatives.
pub struct Responses {
    /// Solution of M x − Aᵀ Λ = P, A x = r for any P and r: x, then Λ. None without constraints.
    pub response: Option<Vec<Value>>,
    pub legendre: Option<Legendre>,
    /// ∂q̈/∂(q, q̇, t), by columns.
    pub jacobian: Option<Vec<Vec<Value>>>,
    /// ∂(b − f)/∂(q, q̇), by columns, from which the equations of small motions are made.
    pub linearization: Option<Vec<Vec<Value>>>,
    /// Switching functions at which impulses act, then those of the accelerations, each with its rate in terms of q,
    /// q̇, t and given accelerations, and the function that is negative where it decides anything, if there is one.
    pub switches: Vec<([Value; 2], Option<Value>)>,
    /// ∂q̈/∂u, by columns.
    pub by_inputs: Option<Vec<Vec<Value>>>,
}

/// q̇ of given p, if L is quadratic in q̇ and the coordinates are independent: M q̇ = p − ∂L/∂q̇ at rest.
pub struct Legendre {
    pub velocities: Vec<Value>,
    pub right: Vec<Value>,
}

pub fn responses(
    g: &mut Graph,
    model: &Model,
    formed: &Formed,
    solved: &Solved,
    quantities: &Quantities,
    facts: &Facts,
    impulses: &[Switch],
) -> Option<Responses> {
    let Quantities { momenta, bias, force, .. } = quantities;
    let free = formed.rows.is_empty();
    let response = match solved.solver {
        _ if free => None,
        Solver::AtRunTime => None,
        _ => Some(response(g, formed, solved)?),
    };
    let without_states = formed.mechanical == solved.accel.len();
    let legendre =
        if free && facts.quadratic && without_states { legendre(g, momenta, &solved.solver) } else { None };
    let by_state: Vec<Symbol> = state(solved.accel.len()).chain([Symbol::Time]).collect();
    let jacobian = jacobian(g, formed, solved, &by_state);
    let linearization = linearization(g, bias, force);
    let equations: Vec<Value> = match solved.solver {
        Solver::AtRunTime => {
            let rows = &formed.rows;
            let inertia = solved.inertia.iter().flatten().chain(&solved.right);
            inertia.chain(rows.jacobian.iter().flatten()).chain(&rows.drift).copied().collect()
        }
        _ => solved.accel.clone(),
    };
    let switches = switches(g, impulses, &equations, solved.accel.len());
    let inputs: Vec<Symbol> = model.inputs().map(Symbol::Parameter).collect();
    let by_inputs = if inputs.is_empty() { None } else { self::jacobian(g, formed, solved, &inputs) };
    Some(Responses { response, legendre, jacobian, linearization, switches, by_inputs })
}

/// The bordered system for any right-hand side.
fn response(g: &mut Graph, formed: &Formed, solved: &Solved) -> Option<Vec<Value>> {
    let n = solved.accel.len();
    let given = symbols(g, Symbol::Given, n + formed.rows.len());
    let mut solution = solved.solver.solve(g, &[given])?.pop()?;
    solution[n..].iter_mut().for_each(|x| *x = -*x);
    Some(g.share_angles(&solution))
}

/// p = M q̇ + p₀ solved for q̇, with p₀ = ∂L/∂q̇ at rest.
fn legendre(g: &mut Graph, momenta: &[Value], solver: &Solver) -> Option<Legendre> {
    let at_rest = |s| matches!(s, Symbol::Velocity(_)).then_some(Value::ZERO);
    let rest = g.substitute(momenta, at_rest);
    let right = rest.into_iter().enumerate().map(|(i, rest)| {
        let p = g.symbol(Symbol::Momentum(i));
        g.sub(p, rest)
    });
    let right: Vec<Value> = right.collect();
    let solution = solver.solve(g, std::slice::from_ref(&right))?.pop()?;
    // The inertia may still name velocities that are proved to drop out.
    Some(Legendre { velocities: g.substitute(&solution, at_rest), right })
}

/// ∂q̈/∂x = −M⁻¹ ∂(M a − right)/∂x at a = q̈, with M bordered and λ beside q̈ where there are constraints.
fn jacobian(g: &mut Graph, formed: &Formed, solved: &Solved, by: &[Symbol]) -> Option<Vec<Vec<Value>>> {
    let n = solved.accel.len();
    if let Solver::AtRunTime = solved.solver {
        return None;
    }
    if by.len() * solved.operations.arithmetic() > MAX_DERIVATIVE_OPERATIONS {
        return None;
    }
    let (matrix, right) = formed.rows.border(&solved.inertia, &solved.right);
    let mut x = symbols(g, Symbol::Acceleration, n);
    x.extend(symbols(g, Symbol::Multiplier, right.len() - n).into_iter().map(|lambda| -lambda));
    let residual: Vec<Value> = (0..right.len())
        .map(|i| {
            let row: Vec<Value> = (0..right.len()).map(|j| entry(&matrix, i, j)).collect();
            let inertial = inner(g, &row, &x);
            g.sub(right[i], inertial)
        })
        .collect();
    let columns: Vec<Vec<Value>> =
        by.iter().map(|x| g.forward_with_limits(&residual, |s| (s == *x).then_some(Value::ONE))).collect();
    let columns = solved.solver.solve(g, &columns)?;
    let all: Vec<Value> = columns.into_iter().flat_map(|column| column[..n].to_vec()).collect();
    let all = g.substitute(&all, |s| match s {
        Symbol::Acceleration(i) => Some(solved.accel[i]),
        Symbol::Multiplier(j) => Some(solved.multipliers[j]),
        _ => None,
    });
    Some(g.share_angles(&all).chunks(n).map(<[Value]>::to_vec).collect())
}

/// None where duals do it at run time for less than the expressions would cost to compile.
fn linearization(g: &mut Graph, bias: &[Value], force: &[Value]) -> Option<Vec<Vec<Value>>> {
    let n = bias.len();
    let residual: Vec<Value> = bias.iter().zip(force).map(|(b, f)| g.sub(*b, *f)).collect();
    if 2 * n * operations(g, &residual).arithmetic() > MAX_DERIVATIVE_OPERATIONS {
        return None;
    }
    let all = state(n).flat_map(|x| g.forward_with_limits(&residual, |s| (s == x).then_some(Value::ONE)));
    let all: Vec<Value> = all.collect();
    Some(g.share_angles(&all).chunks(n).map(<[Value]>::to_vec).collect())
}

/// q, then q̇.
fn state(n: usize) -> impl Iterator<Item = Symbol> {
    (0..n).map(Symbol::Coordinate).chain((0..n).map(Symbol::Velocity))
}

/// Switching functions at which impulses act, then those of the equations of motion or of the accelerations, and their
/// rates under accelerations that are given.
fn switches(
    g: &mut Graph,
    impulses: &[Switch],
    equations: &[Value],
    n: usize,
) -> Vec<([Value; 2], Option<Value>)> {
    let mut all: Vec<(Value, Option<Value>)> = impulses.iter().map(|of| (of.value, of.cut)).collect();
    for (value, decided) in choices(g, equations) {
        let cut = cut(g, &decided);
        // (The forces may have a kink where the momenta have none.)
        if !all.iter().any(|of| of.0 == value && (of.1.is_none() || of.1 == cut)) {
            all.push((value, cut));
        }
    }
    if all.is_empty() {
        return Vec::new();
    }
    let values: Vec<Value> = all.iter().map(|of| of.0).collect();
    let [velocities, accelerations] = [Symbol::Velocity, Symbol::Given].map(|symbol| symbols(g, symbol, n));
    let along = in_time(&velocities);
    let rates = g.forward(&values, |symbol| match symbol {
        Symbol::Velocity(i) => Some(accelerations[i]),
        other => along(other),
    });
    all.into_iter().zip(rates).map(|((value, cut), rate)| ([value, rate], cut)).collect()
}
