//! Constraints that restrict only what others restrict already: they follow from these, or contradict them.
//!
//! Rows of A that depend on each other are seen at random states, as everything that only numbers tell. Whether the
//! last of such constraints follows from the others is seen at a state that satisfies these: its f vanishes there, or
//! not.

use super::{ConstraintKind, Rows};
use crate::diagnostics::Errors;
use crate::equations::check::{TRIALS, sample};
use crate::graph::{Graph, Symbol, Value};
use crate::model::Constraint;

/// Largest remainder of a row, relative to its length, that rounding explains.
const ROUNDING: f64 = 1e-10;
/// Steps towards a state that satisfies constraints.
const STEPS: usize = 50;

/// A row with what it is made of.
struct Reduced {
    row: Vec<f64>,
    /// Column of the largest entry of the row.
    pivot: usize,
    /// Multiples of the constraints whose sum the row is.
    parts: Vec<f64>,
}

/// Are the constraints independent? If not, the first one that depends on those before it is reported, unless one
/// that follows from others is `allowed`.
pub fn check(
    g: &Graph,
    constraints: &[Constraint],
    rows: &Rows,
    n: usize,
    allowed: bool,
    errors: &mut Errors,
) -> bool {
    if rows.len() < 2 {
        return true;
    }
    let mut found = (0..TRIALS).filter_map(|trial| Some((trial, first_dependent(g, rows, trial)?)));
    // One regular sample is enough.
    let Some((trial, Some((last, others)))) = found.next() else { return true };
    if found.any(|(_, dependent)| dependent.is_none()) || others.len() >= n || others.is_empty() {
        return true;
    }
    let named = |k: &usize| match &constraints[*k] {
        // A direction, whose constraint nobody wrote.
        c if c.name == c.written.to_string() => {
            format!("the direction `{}`, whose length is 1", c.label())
        }
        c => format!("`{}`", c.label()),
    };
    let labels: Vec<String> = others.iter().map(named).collect();
    let (others_named, last_label) = (labels.join(", "), constraints[last].label());
    let all: Vec<Value> = others.iter().chain([&last]).map(|k| constraints[*k].value).collect();
    let parametric = g.depends(&all, |s| matches!(s, Symbol::Parameter(_)));
    let message = match holds(g, rows, &others, last, trial) {
        Some(true) | None if allowed => return true,
        Some(true) => format!(
            "the constraint `{last_label}` is redundant: it follows from {others_named}\nhelp: remove it, or write `redundant constraint {}: …` to share its load with theirs",
            constraints[last].name
        ),
        Some(false) => {
            let unless = if parametric { ", but for special values of the parameters" } else { "" };
            format!(
                "the constraint `{last_label}` contradicts {others_named}: they restrict the same motion, and cannot hold together{unless}\nhelp: keep one of them, or correct the one that is wrong"
            )
        }
        None => format!(
            "the constraint `{last_label}` restricts only what {others_named} restricts already: it follows, or contradicts\nhelp: remove it"
        ),
    };
    errors.push(&constraints[last].name, message);
    false
}

/// The first constraint that depends on those before it at a sample, and on which; outer `None` where there are no
/// values.
fn first_dependent(g: &Graph, rows: &Rows, trial: u64) -> Option<Option<(usize, Vec<usize>)>> {
    let entries: Vec<Value> = rows.jacobian.iter().flatten().copied().collect();
    let values = g.evaluate(&entries, |s| sample(s, trial, 0));
    if values.iter().any(|x| !x.is_finite()) {
        return None;
    }
    let m = rows.len();
    let mut basis: Vec<Reduced> = Vec::new();
    for (j, row) in values.chunks(values.len() / m).enumerate() {
        let size = row.iter().fold(0.0, |largest: f64, x| largest.max(x.abs()));
        let mut row: Vec<f64> = row.iter().map(|x| x / size).collect();
        let mut parts = vec![0.0; m];
        parts[j] = 1.0;
        for other in &basis {
            let factor = row[other.pivot] / other.row[other.pivot];
            if factor != 0.0 {
                row.iter_mut().zip(&other.row).for_each(|(x, y)| *x -= factor * y);
                parts.iter_mut().zip(&other.parts).for_each(|(x, y)| *x -= factor * y);
                row[other.pivot] = 0.0;
            }
        }
        let pivot = (0..row.len()).max_by(|a, b| row[*a].abs().total_cmp(&row[*b].abs()))?;
        if row[pivot].abs() <= ROUNDING * parts.iter().fold(1.0, |largest: f64, x| largest.max(x.abs())) {
            let others = (0..j).filter(|k| parts[*k].abs() > 1e-6).collect();
            return Some(Some((j, others)));
        }
        basis.push(Reduced { row, pivot, parts });
    }
    Some(None)
}

/// Does the last constraint hold where the others do? `None` where no such state is found, or it holds at some of them:
/// x = 0 beside sin x = 0.
fn holds(g: &Graph, rows: &Rows, others: &[usize], last: usize, trial: u64) -> Option<bool> {
    let n = rows.jacobian[last].len();
    let near = Samples { g, rows, trial };
    let start =
        |symbol: fn(usize) -> Symbol| (0..n).map(|i| sample(symbol(i), trial, 0)).collect::<Vec<f64>>();
    let (q, qd) = (start(Symbol::Coordinate), start(Symbol::Velocity));
    let anywhere = near.holds(others, last, q.clone(), qd.clone())?;
    if anywhere {
        return Some(true);
    }
    // Where it holds itself, and near there.
    let of_last = near.placed(&[last], q).and_then(|q| near.holds(others, last, q, qd));
    if of_last == Some(true) { None } else { Some(false) }
}

/// Constraints at numbers for parameters and time.
struct Samples<'a> {
    g: &'a Graph,
    rows: &'a Rows,
    trial: u64,
}

impl Samples<'_> {
    /// Residuals of some constraints, with their rows.
    fn left(&self, values: &[Value], of: &[usize], q: &[f64], qd: &[f64]) -> (Vec<f64>, Vec<Vec<f64>>) {
        let at = |values: &[Value], qd: &[f64]| {
            self.g.evaluate(values, |s| match s {
                Symbol::Coordinate(i) => q[i],
                Symbol::Velocity(i) => qd[i],
                other => sample(other, self.trial, 0),
            })
        };
        let still = vec![0.0; q.len()];
        let values: Vec<Value> = of.iter().map(|k| values[*k]).collect();
        (at(&values, qd), of.iter().map(|k| at(&self.rows.jacobian[*k], &still)).collect())
    }

    fn on_positions(&self, k: usize) -> bool {
        self.rows.kinds[k] == ConstraintKind::Holonomic
    }

    /// Coordinates near `q` at which those of some constraints vanish that are on positions.
    fn placed(&self, of: &[usize], mut q: Vec<f64>) -> Option<Vec<f64>> {
        let places: Vec<usize> = of.iter().copied().filter(|k| self.on_positions(*k)).collect();
        let still = vec![0.0; q.len()];
        for _ in 0..=STEPS {
            let (values, matrix) = self.left(&self.rows.values, &places, &q, &still);
            let change = shortest(&matrix, &values)?;
            q.iter_mut().zip(&change).for_each(|(q, change)| *q -= change);
            if length(&change) <= 1e-12 * (1.0 + length(&q)) {
                return Some(q);
            }
        }
        None
    }

    /// Does the last constraint hold where the others do, near a state? `None` where no such state is found.
    fn holds(&self, others: &[usize], last: usize, q: Vec<f64>, mut qd: Vec<f64>) -> Option<bool> {
        let vanishes = |values: &[Value], q: &[f64], qd: &[f64]| {
            let (value, matrix) = self.left(values, &[last], q, qd);
            let size = length(&matrix[0]) * (1.0 + length(q) + length(qd));
            value[0].abs() <= 1e-6 * size
        };
        let q = self.placed(others, q)?;
        let all_on_positions = others.iter().chain([&last]).all(|k| self.on_positions(*k));
        if all_on_positions && !vanishes(&self.rows.values, &q, &vec![0.0; q.len()]) {
            return Some(false);
        }
        let (rates, matrix) = self.left(&self.rows.rates, others, &q, &qd);
        let change = shortest(&matrix, &rates)?;
        qd.iter_mut().zip(&change).for_each(|(qd, change)| *qd -= change);
        Some(vanishes(&self.rows.rates, &q, &qd))
    }
}

fn length(x: &[f64]) -> f64 {
    x.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// The shortest x with A x = b, `Aᵀ (A Aᵀ)⁻¹ b`.
fn shortest(a: &[Vec<f64>], b: &[f64]) -> Option<Vec<f64>> {
    let inner = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(x, y)| x * y).sum::<f64>();
    let mut square: Vec<Vec<f64>> = a.iter().map(|x| a.iter().map(|y| inner(x, y)).collect()).collect();
    let mut y = b.to_vec();
    // A Aᵀ is positive definite, since the rows are independent.
    for k in 0..y.len() {
        if square[k][k].is_nan() || square[k][k] <= 0.0 {
            return None;
        }
        for i in 0..y.len() {
            if i != k {
                let factor = square[i][k] / square[k][k];
                for j in k..y.len() {
                    square[i][j] -= factor * square[k][j];
                }
                y[i] -= factor * y[k];
            }
        }
    }
    let columns = a.first().map_or(0, Vec::len);
    let weights: Vec<f64> = y.iter().enumerate().map(|(k, y)| y / square[k][k]).collect();
    let x = (0..columns).map(|j| weights.iter().zip(a).map(|(w, row)| w * row[j]).sum::<f64>());
    let x: Vec<f64> = x.collect();
    x.iter().all(|x| x.is_finite()).then_some(x)
}
