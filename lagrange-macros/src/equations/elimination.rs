//! Choice of the cheapest way of solving the equations for the accelerations. All are tried, and counted.

use super::assemble::Unreduced;
use super::augmented::{Factors, ORDERS, factors};
use super::check;
use super::formed::System;
use super::solve::{Plan, Symmetric, plan, solve};
use crate::graph::{Graph, Symbol, Value};
use crate::program::count::{Operations, operations};
use std::rc::Rc;

/// M of more coordinates is not eliminated as a whole if the bindings offer an order.
pub const MAX_DENSE_COORDINATES: usize = 12;

/// Sums that are factors of at most so many products have numbers of the parameters taken out: both are tried, and
/// none.
const MAX_FACTORED_PRODUCTS: [usize; 2] = [1, usize::MAX];

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
    /// All ways that were tried.
    pub tried: Vec<Candidate>,
}

/// Solver of the bordered system for any right-hand side.
#[derive(Clone)]
pub enum Solver {
    /// Elimination by the pivots of the matrix itself.
    Dense(Symmetric, Vec<Plan>),
    /// Elimination by the pivots of the larger matrix that has the bindings among its unknowns.
    Sparse(Rc<Factors>),
    /// Pivots are found by numbers, where constraints follow from others.
    AtRunTime,
}

impl Solver {
    pub fn solve(&self, g: &mut Graph, columns: &[Vec<Value>]) -> Option<Vec<Vec<Value>>> {
        match self {
            Solver::Dense(matrix, plans) => solve(g, matrix, columns, plans).ok(),
            Solver::AtRunTime => None,
            Solver::Sparse(factors) => {
                Some(columns.iter().map(|column| factors.response(g, column)).collect())
            }
        }
    }
}

/// A way of solving the equations that was tried.
pub struct Candidate {
    pub way: String,
    /// None where what has to be computed first costs more than the best way before it, or where pivots may vanish.
    pub cost: Option<Operations>,
}

/// The best way that was found so far.
struct Search {
    best: Option<Eliminated>,
    tried: Vec<Candidate>,
    /// Number of coordinates.
    n: usize,
    /// M is positive definite, so that no pivot vanishes. Elsewhere one may do so without being written as 0.
    sure: bool,
}

/// The cheapest solution of the equations: `at` as they were written, `systems` as they are when they are pulled back
/// to n coordinates and bordered, in one or more forms. None where no pivots are found.
pub fn eliminated(g: &mut Graph, at: &Unreduced, systems: &[System], n: usize) -> Option<Eliminated> {
    let sure = check::is_positive_definite(g, &systems[0].matrix[..n], |_| None);
    let mut search = Search { best: None, tried: Vec::new(), n, sure };
    let mut orders: Vec<Rc<Factors>> = Vec::new();
    for order in ORDERS.into_iter().filter(|_| at.bound > 0) {
        let Some(factors) = factors(g, at, order).map(Rc::new) else { continue };
        let way = format!("bindings among the unknowns, {order:?}");
        if search.is_worth(g, &way, &factors.values()) {
            let solution = factors.motion(g, at);
            search.offer(g, &way, &systems[0], &solution, Solver::Sparse(Rc::clone(&factors)));
        }
        orders.push(factors);
    }
    for system in systems.iter().filter(|_| n <= MAX_DENSE_COORDINATES || orders.is_empty()) {
        let System { form, matrix, right } = system;
        let way = format!("M as a whole, {form}");
        let first: Vec<Value> = matrix.iter().flatten().chain(right).copied().collect();
        if !search.is_worth(g, &way, &first) {
            continue;
        }
        let Ok(plans) = plan(g, matrix, right) else { continue };
        let Ok(solution) = solve(g, matrix, std::slice::from_ref(right), &plans) else { continue };
        search.offer(g, &way, system, &solution[0], Solver::Dense(matrix.clone(), plans));
    }
    let Search { best, tried, .. } = search;
    best.map(|best| Eliminated { orders, tried, ..best })
}

impl Search {
    /// Does what has to be computed first cost less than the best solution?
    fn is_worth(&mut self, g: &Graph, way: &str, first: &[Value]) -> bool {
        let worth =
            self.best.as_ref().is_none_or(|best| operations(g, first).cost() < best.operations.cost());
        if !worth {
            self.tried.push(Candidate { way: way.into(), cost: None });
        }
        worth
    }

    /// Takes a solution if it costs less than the best one, as it is or with numbers of the parameters taken out of
    /// sums.
    fn offer(&mut self, g: &mut Graph, way: &str, system: &System, solution: &[Value], solver: Solver) {
        if !self.sure && !is_solved(g, system, solution, &solver) {
            self.tried.push(Candidate { way: way.into(), cost: None });
            return;
        }
        let accel = g.share_angles(&solution[..self.n]);
        let factored = MAX_FACTORED_PRODUCTS.map(|products| g.factored(&accel, products));
        for (accel, factored) in [Some(accel)].into_iter().chain(factored).zip([
            "",
            ", factors of sums, in few products",
            ", factors of sums, in all products",
        ]) {
            let Some(accel) = accel else { continue };
            let operations = operations(g, &accel);
            self.tried.push(Candidate { way: format!("{way}{factored}"), cost: Some(operations) });
            let cost = |o: &Operations| (o.cost(), o.path);
            if self.best.as_ref().is_none_or(|b| cost(&operations) < cost(&b.operations)) {
                let multipliers = solution[self.n..].iter().map(|x| -*x).collect();
                let (matrix, right) = (system.matrix.clone(), system.right.clone());
                let (solver, orders, tried) = (solver.clone(), Vec::new(), Vec::new());
                self.best =
                    Some(Eliminated { matrix, right, solver, accel, multipliers, operations, orders, tried });
            }
        }
    }
}

/// Is this a solution for what is on the right, and for anything else?
fn is_solved(
    g: &mut Graph,
    System { matrix, right, .. }: &System,
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
