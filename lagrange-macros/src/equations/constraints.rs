//! Constraints between coordinates that are not independent, and what they add to the equations of motion.
//!
//! A constraint on positions is f(q, t) = 0, one on velocities g = Σ aᵢ(q, t) q̇ᵢ + b(q, t) = 0. Either way its rate is
//! ġ = A q̈ + γ with A = ∂f/∂q or a, and with one multiplier λ for each constraint (Lagrange–d'Alembert; Beatty 2006,
//! footnote to 11.11.1, whose sign of λ is used)
//!
//!   ⎡ M  Aᵀ ⎤ ⎡  q̈ ⎤   ⎡ f − b ⎤
//!   ⎣ A  0  ⎦ ⎣ −λ ⎦ = ⎣      −γ      ⎦ ,
//!
//! a symmetric system for (q̈, −λ), solved like that for q̈ alone.

mod dependent;
mod redundant;
mod squared;

pub use redundant::Redundancy;

use super::check::{TRIALS, sample};
use super::common::{in_time, independent};
use super::solve::Symmetric;
use crate::diagnostics::Errors;
use crate::graph::{Graph, Symbol, Value};
use crate::model::{Constraint, Model};
use std::collections::BTreeSet;

/// Kind of a restriction of a motion.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum ConstraintKind {
    /// f(q, t) = 0.
    Holonomic,
    /// On velocities, but it follows from a relation between positions, known up to a constant.
    Integrable,
    /// On velocities, and on nothing else.
    Nonholonomic,
}

/// All constraints of a system in terms of q, q̇ and t.
#[derive(Default)]
pub struct Rows {
    pub kinds: Vec<ConstraintKind>,
    /// f of those on positions, 0 for the others.
    pub values: Vec<Value>,
    /// g = A q̇ + b
    pub rates: Vec<Value>,
    /// A, one row for each constraint.
    pub jacobian: Vec<Vec<Value>>,
    /// γ
    pub drift: Vec<Value>,
    /// The dependence of some on others, if there is one.
    pub redundancy: Option<Redundancy>,
}

impl Rows {
    pub fn len(&self) -> usize {
        self.kinds.len()
    }

    pub fn is_empty(&self) -> bool {
        self.kinds.is_empty()
    }

    /// The constraints as they were written, and whether they are relations between velocities.
    pub fn written(&self, constraints: &[Constraint]) -> Vec<(Value, bool)> {
        constraints
            .iter()
            .zip(&self.kinds)
            .map(|(c, kind)| (c.value, *kind != ConstraintKind::Holonomic))
            .collect()
    }

    /// M and f − b, bordered.
    pub fn border(&self, inertia: &Symmetric, right: &[Value]) -> (Symmetric, Vec<Value>) {
        let (mut matrix, mut right) = (inertia.clone(), right.to_vec());
        for (j, (row, drift)) in self.jacobian.iter().zip(&self.drift).enumerate() {
            matrix.push(row.iter().copied().chain(std::iter::repeat_n(Value::ZERO, j + 1)).collect());
            right.push(-*drift);
        }
        (matrix, right)
    }

    /// b = g at rest: what is prescribed of the velocities.
    pub fn at_rest(&self, g: &mut Graph) -> Vec<Value> {
        g.substitute(&self.rates, |s| matches!(s, Symbol::Velocity(_)).then_some(Value::ZERO))
    }
}

/// The rows of constraints whose values are these.
pub fn rows(g: &mut Graph, model: &Model, values: &[Value], errors: &mut Errors) -> Option<Rows> {
    let (constraints, n) = (&model.constraints, model.coordinates.len());
    let is_velocity = |s: Symbol| matches!(s, Symbol::Velocity(_));
    let velocities: Vec<Symbol> = (0..n).map(Symbol::Velocity).collect();
    let coordinates: Vec<Symbol> = (0..n).map(Symbol::Coordinate).collect();
    let qd: Vec<Value> = velocities.iter().map(|v| g.symbol(*v)).collect();
    let mut rows = Rows::default();
    let mut sound = true;
    for (constraint, &value) in constraints.iter().zip(values) {
        let mut refused = |cause: &str| {
            errors.push(&constraint.written, cause.replace("{}", &constraint.label()));
            sound = false;
        };
        let slopes = g.gradient(value, &velocities);
        let on_velocities = !independent(g, &[value], is_velocity);
        let unsloped = slopes.iter().all(|v| g.vanishes(*v));
        if on_velocities && (unsloped || !independent(g, &slopes, is_velocity)) {
            refused(
                "the constraint `{}` is not linear in the velocities\nhelp: a constraint on velocities is of the form `a * dot(x) + b * dot(y) + c == 0`, with coefficients of positions and time",
            );
            continue;
        }
        let still =
            |g: &mut Graph, values: &[Value]| g.substitute(values, |s| is_velocity(s).then_some(Value::ZERO));
        let (kind, value, rate, row) = if on_velocities {
            (ConstraintKind::Nonholonomic, Value::ZERO, value, still(g, &slopes))
        } else {
            let value = still(g, &[value])[0];
            let rate = g.forward(&[value], in_time(&qd))[0];
            (ConstraintKind::Holonomic, value, rate, g.gradient(value, &coordinates))
        };
        if row.iter().all(|a| g.vanishes(*a)) {
            refused(
                "the constraint `{}` does not depend on any coordinate\nhelp: a relation between parameters is `let`; a given motion is `coord name = f(t);`",
            );
            continue;
        }
        if kind == ConstraintKind::Holonomic && squared::is_of_one_sign(g, value) {
            refused(
                "the constraint `{}` holds nowhere: a sum of squares is not negative\nhelp: check its signs; a length is set as in `x * x + y * y == l * l`",
            );
            continue;
        }
        if kind == ConstraintKind::Holonomic && squared::check(g, value, &row) {
            let help = match constraint.index {
                None => "write what is squared, `… == 0`, and for a sum of squares a constraint for each",
                Some(_) => {
                    "of the components of two unit vectors that agree two are enough, `a[0] == b[0]` and `a[1] == b[1]`; and what is squared is written by itself, `… == 0`"
                }
            };
            refused(&format!(
                "the gradient of the constraint `{{}}` vanishes wherever it holds, as that of a square does: it exerts no force\nhelp: {help}"
            ));
            continue;
        }
        let drift = g.forward(&[rate], in_time(&qd))[0];
        rows.kinds.push(kind);
        rows.values.push(value);
        rows.rates.push(rate);
        rows.jacobian.push(row);
        rows.drift.push(drift);
    }
    if !sound {
        return None;
    }
    rows.redundancy = redundant::examined(g, model, &rows, errors).ok()?;
    integrate(g, &mut rows, n);
    Some(rows)
}

/// Finds the constraints on velocities that follow from relations between positions: by Frobenius' theorem those forms
/// ω of a set whose dω vanishes on all directions that the set admits (Frobenius 1877; Beatty 2006, Problem 11.1, is
/// the case of one form in three variables). The largest such set is found by dropping forms that fail.
///
/// dω is an exact expression; that it vanishes is tried at random states, where an analytic function that is not zero
/// does not vanish but by accident (Schwartz 1980).
fn integrate(g: &mut Graph, rows: &mut Rows, n: usize) {
    if !rows.kinds.contains(&ConstraintKind::Nonholonomic) {
        return;
    }
    let m = rows.len();
    let variables: Vec<Symbol> = (0..n).map(Symbol::Coordinate).chain([Symbol::Time]).collect();
    let size = variables.len();
    let rest = rows.at_rest(g);
    // Entries (j, b) of the forms, and slopes (a, j, b) of them, that are not zero: few of all in a large system.
    let mut forms: Vec<((usize, usize), Value)> = Vec::new();
    for (j, (row, rest)) in rows.jacobian.iter().zip(&rest).enumerate() {
        let entries = row.iter().chain([rest]).enumerate().map(|(b, value)| ((j, b), *value));
        forms.extend(entries.filter(|(_, value)| !value.is_zero()));
    }
    let flat: Vec<Value> = forms.iter().map(|(_, value)| *value).collect();
    let mut slopes: Vec<((usize, usize, usize), Value)> = Vec::new();
    for (a, x) in variables.iter().enumerate() {
        let column = g.forward(&flat, |s| (s == *x).then_some(Value::ONE));
        let entries = forms.iter().zip(column).map(|(&((j, b), _), slope)| ((a, j, b), slope));
        slopes.extend(entries.filter(|(_, slope)| !slope.is_zero()));
    }
    let all: Vec<Value> = flat.iter().copied().chain(slopes.iter().map(|(_, slope)| *slope)).collect();
    let states: Vec<Vec<f64>> = (0..TRIALS)
        .map(|trial| g.evaluate(&all, |s| sample(s, trial, 0)))
        .filter(|values| values.iter().all(|x| x.is_finite()))
        .collect();
    let mut integrable: Vec<usize> = (0..m).collect();
    loop {
        let mut kept = integrable.clone();
        for values in &states {
            let (form, slope) = values.split_at(forms.len());
            let mut set = vec![vec![0.0; size]; m];
            for (&((j, b), _), value) in forms.iter().zip(form) {
                set[j][b] = *value;
            }
            let free = kernel(integrable.iter().map(|&j| set[j].clone()).collect(), size);
            kept.retain(|&j| {
                let of_form = slopes.iter().zip(slope).filter(|(((_, form, _), _), _)| *form == j);
                let terms: Vec<(usize, usize, f64)> =
                    of_form.map(|(&((a, _, b), _), value)| (a, b, *value)).collect();
                closed_on(&terms, &free, size)
            });
        }
        if kept.len() == integrable.len() {
            break;
        }
        integrable = kept;
    }
    for j in integrable {
        if rows.kinds[j] == ConstraintKind::Nonholonomic {
            rows.kinds[j] = ConstraintKind::Integrable;
        }
    }
}

/// Does dω(x, y) = Σ ∂ω_b/∂x_a (x_a y_b − x_b y_a) vanish, but for rounding, on these directions?
fn closed_on(slopes: &[(usize, usize, f64)], free: &[Vec<f64>], size: usize) -> bool {
    let moved: BTreeSet<usize> = slopes.iter().flat_map(|&(a, b, _)| [a, b]).collect();
    free.iter().enumerate().all(|(k, y)| {
        // dω(·, y), and the sizes of its terms.
        let (mut row, mut sizes) = (vec![0.0; size], vec![0.0; size]);
        for &(a, b, slope) in slopes {
            row[a] += slope * y[b];
            row[b] -= slope * y[a];
            sizes[a] += (slope * y[b]).abs();
            sizes[b] += (slope * y[a]).abs();
        }
        free[..k].iter().all(|x| {
            let sum: f64 = moved.iter().map(|&c| x[c] * row[c]).sum();
            let terms: f64 = moved.iter().map(|&c| x[c].abs() * sizes[c]).sum();
            sum.abs() <= 1e-9 * terms
        })
    })
}

/// A basis of the vectors that all rows annihilate, by Gauss–Jordan elimination with full pivoting.
fn kernel(mut rows: Vec<Vec<f64>>, size: usize) -> Vec<Vec<f64>> {
    let mut pivots: Vec<usize> = Vec::new();
    let scale = rows.iter().flatten().fold(0.0, |m: f64, x| m.max(x.abs()));
    for i in 0..rows.len() {
        let candidates = (i..rows.len()).flat_map(|r| (0..size).map(move |c| (r, c)));
        let Some((r, c)) = candidates.max_by(|a, b| rows[a.0][a.1].abs().total_cmp(&rows[b.0][b.1].abs()))
        else {
            break;
        };
        if rows[r][c].abs() <= 1e-12 * scale {
            break;
        }
        rows.swap(i, r);
        let pivot = rows[i][c];
        rows[i].iter_mut().for_each(|x| *x /= pivot);
        let row = rows[i].clone();
        for (k, other) in rows.iter_mut().enumerate() {
            if k != i {
                let factor = other[c];
                other.iter_mut().zip(&row).for_each(|(x, y)| *x -= factor * y);
            }
        }
        pivots.push(c);
    }
    let free = (0..size).filter(|c| !pivots.contains(c));
    free.map(|f| {
        let mut v = vec![0.0; size];
        v[f] = 1.0;
        for (i, &c) in pivots.iter().enumerate() {
            v[c] = -rows[i][f];
        }
        v
    })
    .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kernel_is_annihilated() {
        let rows = vec![vec![1.0, 2.0, 3.0, -1.0], vec![2.0, 4.0, 1.0, 0.5]];
        let basis = kernel(rows.clone(), 4);
        assert_eq!(basis.len(), 2);
        for v in &basis {
            for row in &rows {
                let product: f64 = row.iter().zip(v).map(|(a, b)| a * b).sum();
                assert!(product.abs() < 1e-14);
            }
        }
        assert_eq!(kernel(vec![vec![1.0, 1.0], vec![2.0, 2.0]], 2).len(), 1, "dependent rows count once");
    }
}
