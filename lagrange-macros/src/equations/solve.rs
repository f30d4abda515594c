//! M x = b on the graph, M symmetric with zeros known at compile time: split into blocks, and LDLᵀ in each
//! (Golub and Van Loan, *Matrix Computations*, 4th ed. 2013, 4.1.2), in the elimination order that costs least.

use crate::graph::build::common;
use crate::graph::{Graph, Id, Value};
use crate::program::count::operations;

/// A symmetric matrix; `[i][j]` for j ≤ i.
pub type Symmetric = Vec<Vec<Value>>;

pub fn entry(m: &Symmetric, i: usize, j: usize) -> Value {
    if i >= j { m[i][j] } else { m[j][i] }
}

/// Factorizes `A = L D Lᵀ`: puts the columns of L D in place of A, and `L⁻¹ y` in place of y; none if a pivot vanishes.
pub fn swept(g: &mut Graph, a: &mut Symmetric, y: &mut [Value]) -> Option<()> {
    for k in 0..y.len() {
        if g.vanishes(a[k][k]) {
            return None;
        }
        for i in k + 1..y.len() {
            let l = g.quotient(a[i][k], a[k][k]);
            for j in k + 1..=i {
                let product = g.mul(l, a[j][k]);
                a[i][j] = g.sub(a[i][j], product);
            }
            let product = g.mul(l, y[k]);
            y[i] = g.sub(y[i], product);
        }
    }
    Some(())
}

/// Above this size only one elimination order is tried.
const MAX_TRIED_COORDINATES: usize = 8;

/// A pivot is identically zero.
#[derive(Debug)]
pub struct Singular;

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

/// Plan of the elimination of a block.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Its indices, in the order of pivots.
    order: Vec<usize>,
    /// Cramer's rule for two unknowns: one division instead of two dependent ones.
    cramer: bool,
    scale: Scale,
}

/// M = K D M′ D with monomials K and D = diag(dᵢ): lengths and masses that all entries share are taken out before
/// anything is eliminated, x = D⁻¹ M′⁻¹ D⁻¹ b / K.
#[derive(Clone, Debug, Default)]
struct Scale {
    common: Vec<(Id, i32)>,
    /// dᵢ in the order of pivots.
    rows: Vec<Vec<(Id, i32)>>,
}

/// The cheapest plan for each block, found by trying.
pub fn plan(g: &mut Graph, m: &Symmetric, b: &[Value]) -> Result<Vec<Plan>, Singular> {
    let mut plans = Vec::new();
    for block in blocks(b.len(), |i, j| !entry(m, i, j).is_zero()) {
        let mut orders = vec![minimum_degree(m, &block)];
        if block.len() <= MAX_TRIED_COORDINATES {
            orders.extend([block.clone(), block.iter().rev().copied().collect()]);
        }
        let mut candidates = Vec::new();
        for order in orders {
            let unscaled = Scale { common: Vec::new(), rows: vec![Vec::new(); order.len()] };
            let scale = scale(g, m, &order);
            let scaled = !scale.common.is_empty() || scale.rows.iter().any(|d| !d.is_empty());
            for scale in if scaled { vec![scale, unscaled] } else { vec![unscaled] } {
                if order.len() == 2 {
                    candidates.push(Plan { order: order.clone(), cramer: true, scale: scale.clone() });
                }
                candidates.push(Plan { order: order.clone(), cramer: false, scale });
            }
        }
        if block.len() > MAX_TRIED_COORDINATES {
            plans.push(candidates.swap_remove(0));
            continue;
        }
        let mut best = None;
        for candidate in candidates {
            let Ok(solutions) = solve(g, m, &[b.to_vec()], std::slice::from_ref(&candidate)) else {
                continue;
            };
            let outputs: Vec<Value> = block.iter().map(|&i| solutions[0][i]).collect();
            let count = operations(g, &outputs);
            let cost = (count.cost(), count.path);
            if best.as_ref().is_none_or(|(least, _)| cost < *least) {
                best = Some((cost, candidate));
            }
        }
        plans.push(best.ok_or(Singular)?.1);
    }
    Ok(plans)
}

/// The monomials that can be taken out of a block.
fn scale(g: &mut Graph, m: &Symmetric, order: &[usize]) -> Scale {
    let n = order.len();
    // Half of what the diagonal has, less what a coupling lacks.
    let mut rows: Vec<Vec<(Id, i32)>> = order
        .iter()
        .map(|&i| g.content(entry(m, i, i)).iter().map(|f| (f.0, f.1 / 2)).filter(|f| f.1 > 0).collect())
        .collect();
    for i in 0..n {
        for j in 0..i {
            let coupling = entry(m, order[i], order[j]);
            if coupling.is_zero() {
                continue;
            }
            let content = g.content(coupling);
            let has = |base| content.iter().find(|f| f.0 == base).map_or(0, |f| f.1);
            let both: Vec<Id> = rows[i].iter().chain(&rows[j]).map(|f| f.0).collect();
            for base in both {
                let of = |row: &[(Id, i32)]| row.iter().find(|f| f.0 == base).map_or(0, |f| f.1);
                if of(&rows[i]) + of(&rows[j]) > has(base) {
                    rows[i].retain(|f| f.0 != base);
                    rows[j].retain(|f| f.0 != base);
                }
            }
        }
    }
    // Dropping a factor from one row may have left it in another that a coupling no longer supports; entries are
    // divided with `over`, which is right for any monomials, so this costs operations at worst.
    let entries: Vec<Value> = (0..n)
        .flat_map(|i| (0..=i).map(move |j| (i, j)))
        .map(|(i, j)| {
            let entry = entry(m, order[i], order[j]);
            let partly = g.over(entry, &rows[i]);
            g.over(partly, &rows[j])
        })
        .filter(|entry| !entry.is_zero())
        .collect();
    let mut shared = entries.first().map_or(Vec::new(), |first| g.content(*first).to_vec());
    for entry in entries {
        shared = common(&shared, &g.content(entry));
    }
    shared.retain(|f| f.1 > 0);
    Scale { common: shared, rows }
}

/// Solutions for several right-hand sides; the factors are shared nodes.
pub fn solve(
    g: &mut Graph,
    m: &Symmetric,
    right: &[Vec<Value>],
    plans: &[Plan],
) -> Result<Vec<Vec<Value>>, Singular> {
    let mut solutions: Vec<Vec<Value>> = right.iter().map(|b| vec![Value::ZERO; b.len()]).collect();
    for Plan { order, cramer, scale } in plans {
        let n = order.len();
        let mut inner: Symmetric = Vec::new();
        for i in 0..n {
            let mut row = Vec::new();
            for j in 0..=i {
                let common = g.over(entry(m, order[i], order[j]), &scale.common);
                let partly = g.over(common, &scale.rows[i]);
                row.push(g.over(partly, &scale.rows[j]));
            }
            inner.push(row);
        }
        let scaled: Vec<Vec<Value>> = right
            .iter()
            .map(|b| {
                (0..n)
                    .map(|i| {
                        let common = g.over(b[order[i]], &scale.common);
                        g.over(common, &scale.rows[i])
                    })
                    .collect()
            })
            .collect();
        let inner = if *cramer { by_cramer(g, &inner, &scaled)? } else { eliminate(g, inner, &scaled)? };
        for (x, inner) in solutions.iter_mut().zip(inner) {
            for i in 0..n {
                x[order[i]] = g.over(inner[i], &scale.rows[i]);
            }
        }
    }
    Ok(solutions)
}

/// M = L D Lᵀ; L y = b; x = L⁻ᵀ D⁻¹ y.
fn eliminate(g: &mut Graph, mut a: Symmetric, right: &[Vec<Value>]) -> Result<Vec<Vec<Value>>, Singular> {
    let n = a.len();
    // In a small system a factor that a pivot and its column share is worth cancelling; in a large one the divided
    // column would be a second set of nodes beside the column.
    let quotient =
        |g: &mut Graph, x: Value, pivot: Value| if n <= 4 { g.quotient(x, pivot) } else { g.div(x, pivot) };
    let mut l = vec![vec![Value::ZERO; n]; n];
    for j in 0..n {
        let pivot = a[j][j];
        if pivot.is_zero() {
            return Err(Singular);
        }
        for i in j + 1..n {
            l[i][j] = quotient(g, a[i][j], pivot);
        }
        // Most entries of a large system are zero.
        for i in (j + 1..n).filter(|&i| !l[i][j].is_zero()) {
            for k in (j + 1..=i).filter(|&k| !l[k][j].is_zero()) {
                let product = g.mul(l[i][j], a[k][j]);
                a[i][k] = g.sub(a[i][k], product);
            }
        }
    }
    let mut solutions = Vec::new();
    for b in right {
        let mut y = b.clone();
        for j in 0..n {
            for i in (j + 1..n).filter(|&i| !l[i][j].is_zero()) {
                let product = g.mul(l[i][j], y[j]);
                y[i] = g.sub(y[i], product);
            }
        }
        let mut x = vec![Value::ZERO; n];
        for i in (0..n).rev() {
            let mut sum = quotient(g, y[i], a[i][i]);
            for k in (i + 1..n).filter(|&k| !l[k][i].is_zero()) {
                let product = g.mul(l[k][i], x[k]);
                sum = g.sub(sum, product);
            }
            x[i] = sum;
        }
        solutions.push(x);
    }
    Ok(solutions)
}

/// x₁ = (M₂₂ b₁ − M₁₂ b₂) / (M₁₁ M₂₂ − M₁₂²), x₂ likewise.
fn by_cramer(g: &mut Graph, m: &Symmetric, right: &[Vec<Value>]) -> Result<Vec<Vec<Value>>, Singular> {
    let (a, c, d) = (m[0][0], m[1][0], m[1][1]);
    let (ad, cc) = (g.mul(a, d), g.mul(c, c));
    let determinant = g.sub(ad, cc);
    if determinant.is_zero() {
        return Err(Singular);
    }
    let solutions = right.iter().map(|b| {
        let mut minor = |p, q, r, s| {
            let (p, q) = (g.mul(p, q), g.mul(r, s));
            let numerator = g.sub(p, q);
            g.quotient(numerator, determinant)
        };
        vec![minor(d, b[0], c, b[1]), minor(a, b[1], c, b[0])]
    });
    Ok(solutions.collect())
}

/// The order in which each pivot couples to the fewest others (Markowitz 1957; Tinney and Walker 1967), the later
/// index first among equals: in chains the outermost body is eliminated first.
///
/// The row of a constraint, whose diagonal is zero, waits for all coordinates that it restricts. Then its pivot is
/// that of −A M⁻¹ Aᵀ over them, which is negative wherever the constraints are independent. After some of them alone
/// it would be made of some entries of A, and vanish wherever these do.
fn minimum_degree(m: &Symmetric, block: &[usize]) -> Vec<usize> {
    let mut neighbours: Vec<Vec<usize>> = block
        .iter()
        .map(|&i| block.iter().copied().filter(|&j| j != i && !entry(m, i, j).is_zero()).collect())
        .collect();
    let restricted = |i: usize| -> Vec<usize> {
        let coordinates = block.iter().copied().filter(|&j| !entry(m, j, j).is_zero());
        coordinates.filter(|&j| !entry(m, i, j).is_zero()).collect()
    };
    let mut awaited: Vec<Vec<usize>> =
        block.iter().map(|&i| if entry(m, i, i).is_zero() { restricted(i) } else { Vec::new() }).collect();
    let mut left: Vec<usize> = (0..block.len()).collect();
    let mut order = Vec::new();
    while let Some(at) =
        (0..left.len()).rev().min_by_key(|&at| (!awaited[left[at]].is_empty(), neighbours[left[at]].len()))
    {
        let p = left.remove(at);
        order.push(block[p]);
        awaited.iter_mut().for_each(|waits| waits.retain(|j| *j != block[p]));
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
    use crate::equations::check::sample;
    use crate::graph::Symbol;

    /// The first constraint couples to one coordinate alone once the other is eliminated, and still has to wait for it.
    #[test]
    fn constraints_wait_for_all_their_coordinates() {
        let g = &mut Graph::default();
        let s: Vec<Value> = (0..9).map(|i| g.symbol(Symbol::Parameter(i))).collect();
        let z = Value::ZERO;
        // Coordinates 0 to 3 without couplings, constraints 4 on {0, 1} and 5 on {1, 2, 3}.
        let matrix = vec![
            vec![s[0]],
            vec![z, s[1]],
            vec![z, z, s[2]],
            vec![z, z, z, s[3]],
            vec![s[4], s[5], z, z, z],
            vec![z, s[6], s[7], s[8], z, z],
        ];
        let order = minimum_degree(&matrix, &[0, 1, 2, 3, 4, 5]);
        let place = |i: usize| order.iter().position(|j| *j == i).unwrap();
        for (constraint, coordinates) in [(4, &[0, 1][..]), (5, &[1, 2, 3])] {
            assert!(coordinates.iter().all(|&i| place(i) < place(constraint)), "{order:?}");
        }
    }

    /// Two constraints on the first two of many coordinates: once one of the two is eliminated, one constraint has a
    /// pivot, and the other one has none, although all its entries are filled.
    #[test]
    fn constraints_wait_for_their_pivots() {
        let g = &mut Graph::default();
        let (n, m) = (MAX_TRIED_COORDINATES, 2);
        let s: Vec<Value> = (0..2 * n + 4).map(|i| g.symbol(Symbol::Parameter(i))).collect();
        let mut matrix: Symmetric = Vec::new();
        for i in 0..n + m {
            let row = (0..=i).map(|j| match (i, j) {
                (i, j) if i < n && i == j => g.add(s[i], s[i]),
                (2, 0) => s[n],
                (i, j) if i < n && i > 2 && i == j + 1 => s[n + i],
                (i, 0 | 1) if i >= n => s[2 * (i + j) - n],
                _ => Value::ZERO,
            });
            matrix.push(row.collect());
        }
        let right: Vec<Value> = (0..n + m).map(|i| s[i % 7]).collect();
        let plans = plan(g, &matrix, &right).unwrap();
        let x = solve(g, &matrix, std::slice::from_ref(&right), &plans).unwrap().remove(0);
        let residual: Vec<Value> = (0..n + m)
            .map(|i| {
                let product = (0..n + m).fold(Value::ZERO, |sum, j| {
                    let term = g.mul(entry(&matrix, i, j), x[j]);
                    g.add(sum, term)
                });
                g.sub(product, right[i])
            })
            .collect();
        for (i, residual) in g.evaluate(&residual, |s| sample(s, 1, 0)).into_iter().enumerate() {
            assert!(residual.abs() < 1e-11, "row {i}: {residual:e}");
        }
    }

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
        let as_planned = |order: Vec<usize>, cramer| {
            let scale = Scale { common: Vec::new(), rows: vec![Vec::new(); order.len()] };
            Plan { order, cramer, scale }
        };
        for (order, cramer) in [(vec![0, 1], false), (vec![1, 0], false), (vec![0, 1], true)] {
            let plans = [as_planned(order, cramer), as_planned(vec![2], false)];
            let x = solve(g, &m, std::slice::from_ref(&b), &plans).unwrap();
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
