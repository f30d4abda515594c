//! Which way of solving the equations for the accelerations costs least? All are tried, and counted.

use super::assemble::Unreduced;
use super::augmented::{Factors, ORDERS, factors};
use super::check;
use super::solve::{Plan, Symmetric, plan, solve};
use crate::graph::{Graph, Symbol, Value};
use crate::schedule::count::{Operations, operations};
use std::rc::Rc;

/// M of more coordinates is not eliminated as a whole if the bindings offer an order.
pub const DENSE: usize = 12;

/// Sums that are factors of at most so many products have numbers of the parameters taken out: both are tried, and none.
const FACTORS: [usize; 2] = [1, usize::MAX];

/// The bordered system M x − Aᵀ λ = right as it was solved.
pub struct Eliminated {
    pub matrix: Symmetric,
    pub right: Vec<Value>,
    pub solver: Solver,
    pub accel: Vec<Value>,
    pub multipliers: Vec<Value>,
    pub operations: Operations,
    /// All orders of elimination that have pivots, of the system that has the bindings among its unknowns.
    pub orders: Vec<Rc<Factors>>,
}

/// How it is solved for any right-hand side.
#[derive(Clone)]
pub enum Solver {
    /// By the pivots of the matrix itself,
    Dense(Symmetric, Vec<Plan>),
    /// or of the larger one that has the bindings among its unknowns.
    Sparse(Rc<Factors>),
}

impl Solver {
    pub fn solve(&self, g: &mut Graph, columns: &[Vec<Value>]) -> Option<Vec<Vec<Value>>> {
        match self {
            Solver::Dense(matrix, plans) => solve(g, matrix, columns, plans).ok(),
            Solver::Sparse(factors) => {
                Some(columns.iter().map(|column| factors.response(g, column)).collect())
            }
        }
    }
}

/// The cheapest solution of the equations: `at` as they were written, `systems` as they are when they are pulled back to n
/// coordinates and bordered, in one or more forms. None where no pivots are found.
pub fn eliminated(
    g: &mut Graph,
    at: &Unreduced,
    systems: &[(Symmetric, Vec<Value>)],
    n: usize,
) -> Option<Eliminated> {
    let mut best: Option<Eliminated> = None;
    // Where M is positive definite, no pivot vanishes. Elsewhere one may do so without being written as 0.
    let sure = check::is_positive(g, &systems[0].0[..n]);
    type System = (Symmetric, Vec<Value>);
    let offer = |g: &mut Graph,
                 best: &mut Option<Eliminated>,
                 system: &System,
                 solution: &[Value],
                 solver: Solver| {
        if !sure && !is_solved(g, system, solution, &solver) {
            return;
        }
        let accel = g.share_angles(&solution[..n]);
        let factored = FACTORS.map(|products| g.factored(&accel, products));
        for accel in [accel].into_iter().chain(factored.into_iter().flatten()) {
            let operations = operations(g, &accel);
            let cost = |o: &Operations| (o.cost(), o.path);
            if best.as_ref().is_none_or(|b| cost(&operations) < cost(&b.operations)) {
                let multipliers = solution[n..].iter().map(|x| -*x).collect();
                let (matrix, right) = system.clone();
                let (solver, orders) = (solver.clone(), Vec::new());
                *best = Some(Eliminated { matrix, right, solver, accel, multipliers, operations, orders });
            }
        }
    };
    let mut orders: Vec<Rc<Factors>> = Vec::new();
    for order in ORDERS.into_iter().filter(|_| at.bound > 0) {
        let Some(factors) = factors(g, at, order).map(Rc::new) else { continue };
        if !is_dearer(g, &best, &factors.values()) {
            let solution = factors.motion(g, at);
            offer(g, &mut best, &systems[0], &solution, Solver::Sparse(Rc::clone(&factors)));
        }
        orders.push(factors);
    }
    for system in systems.iter().filter(|_| n <= DENSE || orders.is_empty()) {
        let (matrix, right) = system;
        let first: Vec<Value> = matrix.iter().flatten().chain(right).copied().collect();
        if is_dearer(g, &best, &first) {
            continue;
        }
        let Ok(plans) = plan(g, matrix, right) else { continue };
        let Ok(solution) = solve(g, matrix, std::slice::from_ref(right), &plans) else { continue };
        offer(g, &mut best, system, &solution[0], Solver::Dense(matrix.clone(), plans));
    }
    best.map(|best| Eliminated { orders, ..best })
}

/// Does what has to be computed first cost as much as the best solution already?
fn is_dearer(g: &Graph, best: &Option<Eliminated>, first: &[Value]) -> bool {
    best.as_ref().is_some_and(|best| operations(g, first).cost() >= best.operations.cost())
}

/// Is this a solution for what is on the right, and for anything else?
fn is_solved(
    g: &mut Graph,
    (matrix, right): &(Symmetric, Vec<Value>),
    solution: &[Value],
    solver: &Solver,
) -> bool {
    let given: Vec<Value> = (0..right.len()).map(|i| g.symbol(Symbol::Given(i))).collect();
    let Some(other) = solver.solve(g, std::slice::from_ref(&given)).and_then(|mut all| all.pop()) else {
        return false;
    };
    check::is_solution(g, matrix, right, solution)
        && check::is_solution(g, matrix, &given, &other)
        && !check::divides_by_nothing(g, &[solution, &other[..]].concat())
}
