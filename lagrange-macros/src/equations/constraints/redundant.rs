//! Constraints that follow from others wherever all of them hold, as those of a parallelogram with a third crank do.
//! At most other states their rows are independent: they are looked at on the manifold, at states that Newton's
//! method finds.

use super::{Rows, dependent};
use crate::diagnostics::{Errors, Reported};
use crate::equations::check::sample;
use crate::graph::{Graph, Symbol, Value};
use crate::model::Model;

/// States on the constraints that are looked at, and starts from which they are looked for: where constraints are
/// few, and where they may be too many.
const PLACES: usize = 3;
const STARTS: u64 = 6;
const MORE_STARTS: u64 = 40;
/// Steps towards such a state.
const STEPS: usize = 60;
/// Length of the step along a mechanism, after which constraints that follow from others still hold.
const STEP: f64 = 1e-2;
/// Violation of a constraint, relative to its gradient, that rounding explains.
const HELD: f64 = 1e-12;
/// Sine of the angle between a row and others, below which it depends on them, and above which it does not.
const DEPENDENT: f64 = 1e-8;
const INDEPENDENT: f64 = 1e-4;
/// Sets of constraints that are tried, and that are named.
const MAX_TRIED_SETS: usize = 2000;
const MAX_NAMED_SETS: usize = 6;

/// Dependence of constraints on others.
pub struct Redundancy {
    /// Number of independent ones, the same for all parameters and in all positions but singular ones; None if only
    /// numbers tell.
    pub rank: Option<usize>,
    /// Constraints without which the others have the same rank: their multipliers are not determined.
    pub undetermined: Vec<usize>,
    /// Sets of these that may be left out together, as many as there are too many; not all of many.
    pub superfluous: Vec<Vec<usize>>,
}

/// The rows at a state that satisfies the constraints, normalized.
type Place = Vec<Vec<f64>>;

/// Finds out whether constraints follow from others. Contradictions, and constraints that leave no motion, are
/// reported.
pub fn examined(
    g: &Graph,
    model: &Model,
    rows: &Rows,
    errors: &mut Errors,
) -> Result<Option<Redundancy>, Reported> {
    // States of first order are no freedoms.
    let (constraints, n, m) = (&model.constraints, model.mechanical(), rows.len());
    let declared = constraints.iter().any(|c| c.redundant);
    if m == 0 {
        return Ok(None);
    }
    if !dependent::check(g, constraints, rows, n, declared, errors) {
        return Err(Reported);
    }
    if m == 1 && n > 1 {
        return Ok(None);
    }
    let starts = if declared || m >= n { MORE_STARTS } else { STARTS };
    // A mechanism with a drive for each freedom, by its place or by its speed, moves by its constraints alone.
    let rest = || {
        g.evaluate(&rows.rates, |s| match s {
            Symbol::Velocity(_) => 0.0,
            other => sample(other, 0, 0),
        })
    };
    let kinematic = m == n
        && (g.depends(&[&rows.values[..], &rows.rates].concat(), |s| s == Symbol::Time)
            || rest().iter().any(|rate| rate.abs() > 1e-12));
    let mut places: Vec<(Place, usize)> = Vec::new();
    for trial in 0..MORE_STARTS {
        // Other assemblies are looked for once constraints seem to follow from others: both bars of a stage of a lift
        // may lie on each other, and then fewer conditions are independent than in the lift.
        let independent = places.iter().all(|(_, rank)| *rank == m);
        if independent && (places.len() >= PLACES || trial >= starts) {
            break;
        }
        let Some(place) = (Search { g, model, rows, trial }).place() else { continue };
        let Some(rank) = rank(place.iter()) else { continue };
        // An assembly that cannot move is none of a mechanism.
        if rank < n || kinematic {
            places.push((place, rank));
        }
    }
    if !kinematic {
        keep_movable(&mut places);
    }
    // The assembly with fewest freedoms is meant: in those of other ranks parts lie on each other.
    let ranks = places.iter().map(|(_, rank)| *rank);
    let (least, most) = (ranks.clone().min(), ranks.max());
    let rank = match most {
        Some(most) if most < m => Some(most),
        Some(_) if !declared => return Ok(None),
        Some(_) if least < most => most,
        None if m >= n && !declared && !kinematic => {
            let message = format!(
                "{m} constraints on {n} coordinates leave no motion to find\nhelp: use fewer constraints, or more coordinates; a drive is a function of time, `coord a = w * t;`; of a mechanism that moves for special values of its parameters, write `redundant constraint {}: …`",
                constraints[n - 1].name
            );
            return Err(errors.push(&constraints[n - 1].name, message));
        }
        None if !declared => return Ok(None),
        _ => None,
    };
    let meant = places.into_iter().filter(|(_, rank)| Some(*rank) == most).map(|(place, _)| place);
    let places: Vec<Place> = meant.take(PLACES).collect();
    let most = most.unwrap_or(m);
    let undetermined: Vec<usize> = (0..m).filter(|j| most < m && spans(&places, &[*j], most)).collect();
    let superfluous = if rank.is_some_and(|rank| rank < m) {
        superfluous(&places, &undetermined, most)
    } else {
        Vec::new()
    };
    let redundancy = Redundancy { rank, undetermined, superfluous };
    if !declared {
        let at = &constraints[*redundancy.undetermined.last().unwrap_or(&(m - 1))].name;
        errors.warn(at.span(), "redundant_constraint", redundancy.note(model));
    }
    Ok(Some(redundancy))
}

impl Redundancy {
    /// The constraints that are enough, in words.
    pub fn sentence(&self, model: &Model) -> String {
        let m = model.constraints.len();
        let label = |j: &usize| format!("`{}`", model.constraints[*j].label());
        let all = |set: &[usize]| set.iter().map(label).collect::<Vec<_>>().join(" and ");
        let Some(rank) = self.rank else {
            return format!(
                "some of the {m} constraints may follow from others: their rank is found at run time, by pivots"
            );
        };
        if rank == m {
            return format!(
                "all {m} constraints are independent, but for assemblies in which parts lie on each other"
            );
        }
        let some: Vec<String> = self.superfluous.iter().take(MAX_NAMED_SETS).map(|set| all(set)).collect();
        let others = if self.superfluous.len() > MAX_NAMED_SETS { ", or others" } else { "" };
        format!("{rank} of the {m} constraints are enough: {} may be left out{others}", some.join(", or "))
    }

    fn note(&self, model: &Model) -> String {
        format!(
            "{}; multipliers of least norm are given, and single reactions are not determined\nhelp: leave it out, or write `redundant constraint` if it is meant",
            self.sentence(model)
        )
    }
}

/// Leaves out assemblies of which a part cannot move that moves in others: those are none of a mechanism. A part has
/// the coordinates that constraints tie to each other.
fn keep_movable(places: &mut Vec<(Place, usize)>) {
    let n = places.first().and_then(|(place, _)| place.first()).map_or(0, Vec::len);
    let mut part_of: Vec<usize> = (0..n).collect();
    for row in places.iter().flat_map(|(place, _)| place) {
        let tied: Vec<usize> = (0..n).filter(|i| row[*i] != 0.0).map(|i| part_of[i]).collect();
        let Some(&part) = tied.first() else { continue };
        part_of.iter_mut().filter(|of| tied.contains(of)).for_each(|of| *of = part);
    }
    let of_part = |place: &Place, part: usize| {
        let is_own = |row: &&Vec<f64>| (0..n).any(|i| row[i] != 0.0 && part_of[i] == part);
        rank(place.iter().filter(is_own)).unwrap_or(0)
    };
    for part in 0..n {
        let size = part_of.iter().filter(|of| **of == part).count();
        let ranks: Vec<usize> = places.iter().map(|(place, _)| of_part(place, part)).collect();
        if ranks.iter().any(|rank| *rank < size) {
            let mut ranks = ranks.into_iter();
            places.retain(|_| ranks.next().is_some_and(|rank| rank < size));
        }
    }
}

/// Sets of rows that may be left out together.
fn superfluous(places: &[Place], undetermined: &[usize], rank: usize) -> Vec<Vec<usize>> {
    let size = places.first().map_or(0, |place| place.len() - rank);
    let (mut found, mut tried) = (Vec::new(), 0);
    let mut open: Vec<Vec<usize>> = vec![Vec::new()];
    while let Some(set) = open.pop() {
        tried += 1;
        if tried > MAX_TRIED_SETS {
            break;
        }
        if !spans(places, &set, rank) {
            continue;
        }
        if set.len() == size {
            found.push(set);
            continue;
        }
        let next = undetermined.iter().filter(|j| set.last().is_none_or(|last| *j > last));
        let next: Vec<Vec<usize>> = next.map(|j| [&set[..], &[*j]].concat()).collect();
        open.extend(next.into_iter().rev());
    }
    found
}

/// Have the rows without these the whole rank, everywhere?
fn spans(places: &[Place], without: &[usize], of: usize) -> bool {
    places.iter().all(|place| {
        let kept = place.iter().enumerate().filter(|(j, _)| !without.contains(j)).map(|(_, row)| row);
        rank(kept) == Some(of)
    })
}

/// Number of independent rows, by Gram–Schmidt with pivots; None between dependence and independence.
fn rank<'a>(rows: impl Iterator<Item = &'a Vec<f64>>) -> Option<usize> {
    let mut rows: Vec<Vec<f64>> = rows.cloned().collect();
    let mut rank = 0;
    loop {
        let next = (0..rows.len()).max_by(|a, b| length(&rows[*a]).total_cmp(&length(&rows[*b])));
        let Some(next) = next else { return Some(rank) };
        let size = length(&rows[next]);
        if size < DEPENDENT {
            return Some(rank);
        }
        if size < INDEPENDENT {
            return None;
        }
        let mut pivot = rows.swap_remove(next);
        pivot.iter_mut().for_each(|x| *x /= size);
        for row in &mut rows {
            let part = inner(row, &pivot);
            row.iter_mut().zip(&pivot).for_each(|(x, p)| *x -= part * p);
        }
        rank += 1;
    }
}

/// A search for states that satisfy constraints.
struct Search<'a> {
    g: &'a Graph,
    model: &'a Model,
    rows: &'a Rows,
    trial: u64,
}

/// A state with the constraints there.
struct Found {
    q: Vec<f64>,
    /// f, in units of the gradients: of those at the start, where one vanishes.
    violations: Vec<f64>,
    rows: Place,
}

impl Search<'_> {
    /// The rows at a state that satisfies the constraints; none if one of them holds there alone, as `y == 0` does
    /// beside `y == x * x`, and does not follow from others.
    fn place(&self) -> Option<Place> {
        let (n, m) = (self.model.coordinates.len(), self.rows.len());
        // Near each other at first, where assemblies are those that are drawn, and then all around.
        let wide = if self.trial < STARTS - 2 { 1.0 } else { 4.0 };
        let start = |i: usize| wide * (sample(Symbol::Coordinate(i), self.trial, 0) - 0.9) + 0.5;
        let all: Vec<usize> = (0..m).collect();
        let found = self.held(&all, (0..n).map(start).collect())?;
        let Some(rank) = rank(found.rows.iter()).filter(|rank| *rank < m.min(n)) else {
            return Some(found.rows);
        };
        let mut enough = Vec::new();
        for j in 0..m {
            enough.push(j);
            if self::rank(enough.iter().map(|j| &found.rows[*j])) != Some(enough.len()) {
                enough.pop();
            }
        }
        if enough.len() != rank {
            return None;
        }
        // A step along those that are enough, after which the others hold as well.
        let mut along: Vec<f64> = (0..n).map(|i| sample(Symbol::Velocity(i), self.trial, 1) - 0.9).collect();
        let mut basis: Vec<Vec<f64>> = Vec::new();
        for row in enough.iter().map(|j| &found.rows[*j]) {
            let mut row = row.clone();
            for other in &basis {
                let part = inner(&row, other);
                row.iter_mut().zip(other).for_each(|(x, o)| *x -= part * o);
            }
            let size = length(&row);
            row.iter_mut().for_each(|x| *x /= size);
            basis.push(row);
        }
        for row in &basis {
            let part = inner(&along, row);
            along.iter_mut().zip(row).for_each(|(x, r)| *x -= part * r);
        }
        let size = length(&along);
        let beside = found.q.iter().zip(&along).map(|(q, x)| q + STEP * x / size).collect();
        let beside = self.held(&enough, beside)?;
        beside.violations.iter().all(|f| f.abs() <= 1e-4 * STEP * STEP).then_some(found.rows)
    }

    /// A state that satisfies these constraints, by the Levenberg–Marquardt method, which needs no independent rows
    /// and converges quadratically where its damping goes with the square of the violation (Yamashita and Fukushima
    /// 2001).
    fn held(&self, of: &[usize], mut q: Vec<f64>) -> Option<Found> {
        let Search { g, model, rows, trial } = *self;
        let (n, m) = (model.coordinates.len(), rows.len());
        let parameter = |i: usize| {
            let default = model.default_of(i);
            default.filter(|_| trial % 2 == 1).unwrap_or_else(|| sample(Symbol::Parameter(i), trial, 0))
        };
        let all: Vec<Value> = rows.values.iter().chain(rows.jacobian.iter().flatten()).copied().collect();
        let mut first: Option<Vec<f64>> = None;
        for _ in 0..STEPS {
            let values = g.evaluate(&all, |s| match s {
                Symbol::Coordinate(i) => q[i],
                Symbol::Parameter(i) => parameter(i),
                other => sample(other, trial, 0),
            });
            if values.iter().any(|x| !x.is_finite()) {
                return None;
            }
            let (f, a) = values.split_at(m);
            let a: Vec<&[f64]> = a.chunks(n).collect();
            let sizes: Vec<f64> = a.iter().map(|row| length(row)).collect();
            let before = first.get_or_insert_with(|| sizes.clone());
            let units: Vec<f64> =
                (0..m).map(|j| sizes[j].max(1e-3 * before[j]).max(f64::MIN_POSITIVE)).collect();
            let violations: Vec<f64> = (0..m).map(|j| f[j] / units[j]).collect();
            if of.iter().all(|j| violations[*j].abs() <= HELD * (1.0 + length(&q))) {
                let rows = (0..m).map(|j| a[j].iter().map(|x| x / units[j]).collect()).collect();
                return Some(Found { q, violations, rows });
            }
            // (A Aᵀ + μ) y = f, with rows of unit length.
            let mut y: Vec<f64> = of.iter().map(|j| violations[*j]).collect();
            let damping = inner(&y, &y).min(1.0) + 1e-13;
            let product = |i: usize, j: usize| inner(a[i], a[j]) / (units[i] * units[j]);
            let mut square: Vec<Vec<f64>> =
                of.iter().map(|i| of.iter().map(|j| product(*i, *j)).collect()).collect();
            (0..of.len()).for_each(|k| square[k][k] += damping);
            for k in 0..of.len() {
                for i in k + 1..of.len() {
                    let factor = square[i][k] / square[k][k];
                    for j in k..of.len() {
                        square[i][j] -= factor * square[k][j];
                    }
                    y[i] -= factor * y[k];
                }
            }
            for k in (0..of.len()).rev() {
                for j in k + 1..of.len() {
                    y[k] -= square[k][j] * y[j];
                }
                y[k] /= square[k][k];
            }
            for (&j, y) in of.iter().zip(&y) {
                q.iter_mut().zip(a[j]).for_each(|(q, a)| *q -= y * a / units[j]);
            }
        }
        None
    }
}

fn inner(x: &[f64], y: &[f64]) -> f64 {
    x.iter().zip(y).map(|(x, y)| x * y).sum()
}

fn length(x: &[f64]) -> f64 {
    inner(x, x).sqrt()
}
