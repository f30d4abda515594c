//! M x = b on the graph, M symmetric with zeros known at compile time: split into blocks, and LDLᵀ in each
//! (Golub and Van Loan, *Matrix Computations*, 4th ed. 2013, 4.1.2), in the elimination order that costs least.

use crate::graph::{Graph, Value};
use crate::schedule::count::operations;

/// A symmetric matrix; `[i][j]` for j ≤ i.
pub type Symmetric = Vec<Vec<Value>>;

pub fn entry(m: &Symmetric, i: usize, j: usize) -> Value {
    if i >= j { m[i][j] } else { m[j][i] }
}

/// Above this size only one elimination order is tried.
const TRIED: usize = 8;

/// A pivot that is identically zero.
#[derive(Debug)]
pub struct Singular {
    pub index: usize,
}

/// Sets of indices that M does not couple, each in ascending order.
pub fn blocks(n: usize, coupled: impl Fn(usize, usize) -> bool) -> Vec<Vec<usize>> {
    let mut block: Vec<usize> = (0..n).collect();
    for i in 0..n {
        for j in 0..i {
            if coupled(i, j) && block[i] != block[j] {
                let (keep, drop) = (block[i].min(block[j]), block[i].max(block[j]));
                block.iter_mut().filter(|b| **b == drop).for_each(|b| *b = keep);
            }
        }
    }
    let names: Vec<usize> = (0..n).filter(|i| block[*i] == *i).collect();
    names.into_iter().map(|name| (0..n).filter(|i| block[*i] == name).collect()).collect()
}

/// How a block is solved.
#[derive(Clone, Debug)]
pub enum Plan {
    /// LDLᵀ in this order of pivots.
    Eliminate(Vec<usize>),
    /// Cramer's rule for two unknowns: one division instead of two dependent ones.
    Cramer([usize; 2]),
}

/// The cheapest plan for each block, found by trying.
pub fn plan(g: &mut Graph, m: &Symmetric, b: &[Value]) -> Result<Vec<Plan>, Singular> {
    let mut plans = Vec::new();
    for block in blocks(b.len(), |i, j| !entry(m, i, j).is_zero()) {
        let mut candidates = vec![Plan::Eliminate(minimum_degree(m, &block))];
        if block.len() <= TRIED {
            candidates.push(Plan::Eliminate(block.clone()));
            candidates.push(Plan::Eliminate(block.iter().rev().copied().collect()));
        }
        if let [i, j] = block[..] {
            candidates.push(Plan::Cramer([i, j]));
        }
        let mut best = None;
        let mut singular = None;
        let only = candidates.len() == 1;
        for candidate in candidates {
            if only {
                best = Some(((0, 0), candidate));
                break;
            }
            match solve(g, m, &[b.to_vec()], std::slice::from_ref(&candidate)) {
                Ok(solutions) => {
                    let outputs: Vec<Value> = block.iter().map(|&i| solutions[0][i]).collect();
                    let count = operations(g, &outputs);
                    let cost = (count.cost(), count.path);
                    if best.as_ref().is_none_or(|(least, _)| cost < *least) {
                        best = Some((cost, candidate));
                    }
                }
                Err(error) => singular = singular.or(Some(error)),
            }
        }
        match (best, singular) {
            (Some((_, plan)), _) => plans.push(plan),
            (None, Some(error)) => return Err(error),
            (None, None) => unreachable!("there is at least one candidate"),
        }
    }
    Ok(plans)
}

/// Solutions for several right-hand sides; the factors are shared nodes.
pub fn solve(
    g: &mut Graph,
    m: &Symmetric,
    right: &[Vec<Value>],
    plans: &[Plan],
) -> Result<Vec<Vec<Value>>, Singular> {
    let mut solutions: Vec<Vec<Value>> = right.iter().map(|b| vec![Value::ZERO; b.len()]).collect();
    for plan in plans {
        match plan {
            Plan::Eliminate(order) => eliminate(g, m, order, right, &mut solutions)?,
            Plan::Cramer([i, j]) => cramer(g, m, [*i, *j], right, &mut solutions)?,
        }
    }
    Ok(solutions)
}

/// M = L D Lᵀ; L y = b; x = L⁻ᵀ D⁻¹ y.
fn eliminate(
    g: &mut Graph,
    m: &Symmetric,
    order: &[usize],
    right: &[Vec<Value>],
    solutions: &mut [Vec<Value>],
) -> Result<(), Singular> {
    let n = order.len();
    let mut a: Vec<Vec<Value>> =
        (0..n).map(|i| (0..=i).map(|j| entry(m, order[i], order[j])).collect()).collect();
    let mut l = vec![vec![Value::ZERO; n]; n];
    for j in 0..n {
        let pivot = a[j][j];
        if pivot.is_zero() {
            return Err(Singular { index: order[j] });
        }
        for i in j + 1..n {
            l[i][j] = g.quotient(a[i][j], pivot);
        }
        for i in j + 1..n {
            for k in j + 1..=i {
                let product = g.mul(l[i][j], a[k][j]);
                a[i][k] = g.sub(a[i][k], product);
            }
        }
    }
    for (b, x) in right.iter().zip(solutions) {
        let mut y: Vec<Value> = order.iter().map(|&i| b[i]).collect();
        for j in 0..n {
            for i in j + 1..n {
                let product = g.mul(l[i][j], y[j]);
                y[i] = g.sub(y[i], product);
            }
        }
        for i in (0..n).rev() {
            let mut sum = g.quotient(y[i], a[i][i]);
            for k in i + 1..n {
                let product = g.mul(l[k][i], x[order[k]]);
                sum = g.sub(sum, product);
            }
            x[order[i]] = sum;
        }
    }
    Ok(())
}

fn cramer(
    g: &mut Graph,
    m: &Symmetric,
    [i, j]: [usize; 2],
    right: &[Vec<Value>],
    solutions: &mut [Vec<Value>],
) -> Result<(), Singular> {
    let (a, c, d) = (entry(m, i, i), entry(m, i, j), entry(m, j, j));
    let (ad, cc) = (g.mul(a, d), g.mul(c, c));
    let determinant = g.sub(ad, cc);
    if determinant.is_zero() {
        return Err(Singular { index: j });
    }
    for (b, x) in right.iter().zip(solutions) {
        let mut minor = |p, q, r, s| {
            let (p, q) = (g.mul(p, q), g.mul(r, s));
            let numerator = g.sub(p, q);
            g.quotient(numerator, determinant)
        };
        (x[i], x[j]) = (minor(d, b[i], c, b[j]), minor(a, b[j], c, b[i]));
    }
    Ok(())
}

/// The order in which each pivot couples to the fewest others (Markowitz 1957; Tinney and Walker 1967), the later
/// index first among equals: in chains the outermost body is eliminated first.
fn minimum_degree(m: &Symmetric, block: &[usize]) -> Vec<usize> {
    let mut neighbours: Vec<Vec<usize>> = block
        .iter()
        .map(|&i| block.iter().copied().filter(|&j| j != i && !entry(m, i, j).is_zero()).collect())
        .collect();
    let mut left: Vec<usize> = (0..block.len()).collect();
    let mut order = Vec::new();
    while let Some(at) = (0..left.len()).rev().min_by_key(|&at| neighbours[left[at]].len()) {
        let p = left.remove(at);
        order.push(block[p]);
        let front = std::mem::take(&mut neighbours[p]);
        for &i in &left {
            if front.contains(&block[i]) {
                let own = block[i];
                neighbours[i].retain(|&j| j != block[p]);
                for &j in front.iter().filter(|&&j| j != own) {
                    if !neighbours[i].contains(&j) {
                        neighbours[i].push(j);
                    }
                }
            }
        }
    }
    order
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::Symbol;

    #[test]
    fn every_plan_solves() {
        let g = &mut Graph::default();
        let s: Vec<Value> = (0..8).map(|i| g.symbol(Symbol::Parameter(i))).collect();
        let z = Value::ZERO;
        // Rows 0 and 1 are coupled, 2 stands alone.
        let m = vec![vec![s[0]], vec![s[1], s[2]], vec![z, z, s[3]]];
        let b = vec![s[4], s[5], s[6]];
        let value = |s: Symbol| match s {
            Symbol::Parameter(i) => [3.0, 0.5, 2.0, 4.0, 1.0, -2.0, 7.0, 0.0][i],
            _ => f64::NAN,
        };
        let determinant = 3.0 * 2.0 - 0.25;
        let exact =
            [(2.0 * 1.0 - 0.5 * -2.0) / determinant, (3.0 * -2.0 - 0.5 * 1.0) / determinant, 7.0 / 4.0];
        let alone = Plan::Eliminate(vec![2]);
        for first in [Plan::Eliminate(vec![0, 1]), Plan::Eliminate(vec![1, 0]), Plan::Cramer([0, 1])] {
            let x = solve(g, &m, std::slice::from_ref(&b), &[first, alone.clone()]).unwrap();
            for (x, exact) in g.evaluate(&x[0], value).into_iter().zip(exact) {
                assert!((x - exact).abs() < 1e-15);
            }
        }
        assert_eq!(plan(g, &m, &b).unwrap().len(), 2);
    }

    #[test]
    fn a_structural_zero_is_singular() {
        let g = &mut Graph::default();
        let m = g.symbol(Symbol::Parameter(0));
        // T = m (q̇₁ + q̇₂)²/2
        let matrix = vec![vec![m], vec![m, m]];
        assert!(plan(g, &matrix, &[m, m]).is_err());
    }
}
