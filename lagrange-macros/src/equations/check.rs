//! Mistakes that only the derivation can see.

use super::solve::{Symmetric, entry};
use crate::diagnostics::Errors;
use crate::graph::modular::{INCREMENT, mixed};
use crate::graph::{Function, Graph, Id, Node, Symbol, Value};
use crate::model::{Coordinate, Keywords, Model};
use crate::syntax::Kind;
use std::cell::Cell;

/// Points at which an identity is tried; it is refused only where it fails at none or holds at none.
pub const TRIALS: u64 = 3;

/// A reproducible number in [0.4, 1.4) for each symbol and trial.
pub fn sample(symbol: Symbol, trial: u64, salt: u64) -> f64 {
    let (kind, index) = match symbol {
        Symbol::Time => (0, 0),
        Symbol::Coordinate(i) => (1, i),
        Symbol::Velocity(i) => (2, i),
        Symbol::Parameter(i) => (3, i),
        Symbol::Acceleration(i) | Symbol::Momentum(i) | Symbol::Binding(i) | Symbol::Rate(i) => (4, i),
        Symbol::Multiplier(i) | Symbol::Reaction(i) | Symbol::Given(i) | Symbol::Side(i) => (5, i),
        Symbol::Conserved(i) | Symbol::Quaternion(i) => (6, i),
        Symbol::Order(_) => (7, 0),
    };
    let place = kind * 1_000_003 + index as u64 * 7919 + trial * 104_729 + salt * 15_485_863;
    let z = mixed((place + 1).wrapping_mul(INCREMENT));
    0.4 + (z >> 11) as f64 / (1u64 << 53) as f64
}

/// D is a quadratic form in q̇ if and only if D(v + w) + D(v − w) = 2 D(v) + 2 D(w) (Jordan and von Neumann 1935); it
/// is one with linear and constant terms if D(v + w) + D(v − w) = 2 D(v) + D(w) + D(−w) − 2 D(0).
pub fn dissipation(g: &mut Graph, d: Value, model: &Model, errors: &mut Errors) {
    let Some(keyword) = &model.keywords.dissipation else { return };
    let states = model.mechanical();
    let at = |trial: u64, v: f64, w: f64| {
        g.evaluate(&[d], |s| match s {
            Symbol::Velocity(i) if i < states => v * sample(s, trial, 0) + w * sample(s, trial, 1),
            _ => sample(s, trial, 0),
        })[0]
    };
    // Is the sum of these terms 0, in one of the trials at least not?
    let fails = |terms: &[(f64, f64, f64)]| {
        (0..TRIALS).any(|trial| {
            let terms: Vec<f64> = terms.iter().map(|&(k, v, w)| k * at(trial, v, w)).collect();
            terms.iter().sum::<f64>().abs() > 1e-9 * terms.iter().map(|x| x.abs()).sum::<f64>()
        })
    };
    let sides = [(1.0, 1.0, 1.0), (1.0, 1.0, -1.0), (-2.0, 1.0, 0.0)];
    let form = [&sides[..], &[(-2.0, 0.0, 1.0)]].concat();
    let polynomial = [&sides[..], &[(-1.0, 0.0, 1.0), (-1.0, 0.0, -1.0), (2.0, 0.0, 0.0)]].concat();
    if fails(&form) {
        let (wrong, help) = if fails(&polynomial) {
            (
                "is not a quadratic form in the velocities",
                "friction of another form is a generalized force, such as `Q[x] = -c * dot(x).powi(3);`",
            )
        } else {
            (
                "has terms that are not of second degree in the velocities of this system",
                "a damper whose other end moves in a given way, or a constant friction, is a generalized force, such as `Q[x] = -f * dot(x).signum();`",
            )
        };
        let message = format!("the dissipation function {wrong}\nhelp: {help}");
        errors.push(keyword, message);
    }
}

/// Momenta do not depend on states of first order, whose rates would be part of the equations. (A `T` has been
/// refused before.)
pub fn momenta(g: &Graph, momenta: &[Value], model: &Model, errors: &mut Errors) {
    let states = momenta.len();
    if g.depends(momenta, |s| matches!(s, Symbol::Velocity(i) if i >= states))
        && let Some(keyword) = &model.keywords.kinetic
    {
        let message = "the momenta ∂L/∂q̇ depend on a state of first order, whose rate would be part of the equations of motion\nhelp: the terms of `L` without velocities, `D`, forces, rates and outputs may depend on states";
        errors.push(keyword, message);
    }
}

/// The sign that an expression has for positive parameters wherever it is not zero, if that can be read off.
fn sign(g: &Graph, v: Value) -> Option<i8> {
    let of_node = |id: Id| match g.node(id) {
        Node::Symbol(Symbol::Parameter(_)) => Some(1),
        Node::Sum(a, b) => sign(g, *a).filter(|s| Some(*s) == sign(g, *b)),
        Node::Product(..) => {
            let mut factors = Vec::new();
            collect_factors(g, id, &mut factors);
            factors.sort_unstable();
            let equal = factors.chunk_by(|a, b| a == b);
            // A factor that occurs an even number of times is a square.
            equal.filter(|same| same.len() % 2 == 1).try_fold(1, |s, same| Some(s * sign(g, same[0].into())?))
        }
        Node::Inverse(a) => sign(g, (*a).into()),
        Node::Call(Function::sqrt | Function::exp | Function::exp2 | Function::cosh | Function::abs, ..) => {
            Some(1)
        }
        _ => None,
    };
    let k = match v.k {
        k if k.is_zero() => return None,
        k if k.is_negative() => -1,
        _ => 1,
    };
    Some(k * v.node.map_or(Some(1), of_node)?)
}

fn collect_factors(g: &Graph, id: Id, factors: &mut Vec<Id>) {
    match g.node(id) {
        Node::Product(a, b) => [a, b].into_iter().for_each(|factor| collect_factors(g, *factor, factors)),
        _ => factors.push(id),
    }
}

/// Refuses a kinetic energy that is negative for positive parameters. In a whole L it may be negative for some
/// coordinates, as in an indefinite metric, but not for all.
pub fn signs(
    g: &Graph,
    m: &Symmetric,
    d: &[Value],
    coordinates: &[Coordinate],
    keywords: &Keywords,
    errors: &mut Errors,
) {
    let negative = |i: usize| sign(g, entry(m, i, i)) == Some(-1);
    let found = (0..coordinates.len()).find(|i| negative(*i));
    if let (Some(i), Some(keyword)) = (found, &keywords.kinetic) {
        let label = coordinates[i].label();
        let whole = keyword == "L";
        if !whole || (0..coordinates.len()).all(negative) {
            let help = if whole { "L is T − V" } else { "check its sign" };
            let message = format!(
                "the kinetic energy of `{label}` is negative\nhelp: {help}; a kinetic energy is, for example, `0.5 * m * dot({label}).powi(2)`"
            );
            errors.push(keyword, message);
        }
    }
    let driving = (0..coordinates.len()).find(|i| sign(g, d[*i]) == Some(-1));
    if let (Some(i), Some(keyword)) = (driving, &keywords.dissipation) {
        let label = coordinates[i].label();
        let message = format!(
            "the dissipation function is negative: this friction would drive `{label}`\nhelp: check its sign; D is, for example, `0.5 * c * dot({label}).powi(2)`, and a force that drives is `Q[{label}] = c * dot({label});`"
        );
        errors.push(keyword, message);
    }
}

/// Is the inertia matrix of a kinetic energy positive definite wherever it is tried, with the default values of
/// parameters that have some? Warns of a kinetic energy that is negative for some velocities wherever it is tried.
pub fn is_definite(g: &Graph, m: &[Vec<Value>], model: &Model, errors: &mut Errors) -> bool {
    let Some(keyword) = model.keywords.kinetic.as_ref().filter(|keyword| *keyword == "T") else {
        return false;
    };
    // The least pivot, in parts of the largest inertia.
    let least = |trial: u64| {
        let a = numbers_of(g, m, |s| match s {
            Symbol::Parameter(i) => model.default_of(i).unwrap_or_else(|| sample(s, trial, 0)),
            _ => sample(s, trial, 0),
        });
        let scale = (0..a.len()).map(|i| a[i][i].abs()).fold(0.0, f64::max);
        // (Those after one of 0 are no numbers.)
        pivots(a).into_iter().fold(f64::INFINITY, |least, pivot| if pivot >= least { least } else { pivot })
            / scale
    };
    let parts: Vec<f64> = (0..TRIALS).map(least).collect();
    if errors.is_empty() && model.origin.is_none() && parts.iter().all(|part| *part < -1e-9) {
        let message = "the kinetic energy is negative for some velocities: the inertia matrix is not positive definite where parameters have their default values, or positive ones\nhelp: check signs and factors of products of velocities, and that masses are positive";
        errors.warn(keyword.span(), "a_negative_kinetic_energy", message.into());
    }
    parts.iter().all(|part| *part > 1e-9)
}

/// No coordinate without inertia: neither a zero row, nor a matrix that is singular wherever it is tried. With
/// constraints the matrix is the bordered one, and the constraints are independent.
pub fn inertia(g: &Graph, m: &Symmetric, momenta: &[Value], model: &Model, errors: &mut Errors) -> bool {
    let Model { coordinates, constraints, keywords, .. } = model;
    let n = coordinates.len();
    let energy = keywords.kinetic.as_ref().map_or("T".into(), ToString::to_string);
    let mut sound = true;
    for (i, coordinate) in coordinates.iter().enumerate() {
        if (0..m.len()).all(|j| entry(m, i, j).is_zero()) {
            // (Once for the three of a rotation or a direction.)
            if !sound && coordinate.part.is_some_and(|part| part > 0) && keywords.kinetic.is_some() {
                continue;
            }
            sound = false;
            let label = match keywords.kinetic {
                Some(_) => coordinate.whole(),
                None => coordinate.label(),
            };
            let example = format!("`0.5 * m * dot({label}).powi(2)`");
            let linear = format!(
                "`{energy}` is linear in `dot({label})`, so the acceleration of `{label}` is not determined\nhelp: a kinetic energy is of second degree in the velocities, such as {example}"
            );
            let whole = format!(
                "`L` is degenerate: it has no term of second degree in `dot({label})`, so the acceleration of `{label}` is not determined\nhelp: add such a term, or remove the coordinate; what obeys an equation of first order is a state, `state {label}; rate({label}) = …;`"
            );
            match &keywords.kinetic {
                Some(keyword) if keyword == "L" => errors.push(keyword, whole),
                Some(keyword) if !momenta[i].is_zero() => errors.push(keyword, linear),
                _ => {
                    let (kind, example) = match coordinate.kind {
                        Kind::Rotation => {
                            ("rotation", format!("`body(m, [A, B, C], frame(world, [0, 0, 0], {label}))`"))
                        }
                        Kind::Direction => ("direction", format!("`0.5 * m * dot({label}).norm_squared()`")),
                        _ => ("coordinate", example),
                    };
                    let message = format!(
                        "the {kind} `{label}` has no kinetic energy, so its acceleration is not determined\nhelp: let `{energy}` depend on `dot({label})`, as in {example}, or remove the {kind}"
                    );
                    errors.push(&coordinate.name, message)
                }
            };
        }
    }
    if !sound {
        return false;
    }
    // One regular sample is enough.
    let mut samples = (0..TRIALS).filter_map(|trial| singular_at(g, m, trial));
    if let Some(Some(i)) = samples.next()
        && samples.all(|pivot| pivot.is_some())
    {
        if let Some(constraint) = i.checked_sub(n).map(|j| &constraints[j]) {
            let message = format!(
                "the constraint `{}` leaves no acceleration that it could act on\nhelp: remove it, or give mass to what it holds",
                constraint.label()
            );
            errors.push(&constraint.name, message);
            return false;
        }
        let (label, name) = (coordinates[i].label(), &coordinates[i].name);
        if let Some(keyword) = keywords.kinetic.as_ref().filter(|keyword| *keyword == "L") {
            let message = format!(
                "`L` is degenerate: the inertia matrix is singular, ∂²L/∂q̇² does not determine the acceleration of `{label}` beside those of the other coordinates\nhelp: let `L` be of second degree in every combination of velocities, or use fewer coordinates; what obeys an equation of first order is a state, `state {label}; rate({label}) = …;`"
            );
            errors.push(keyword, message);
            return false;
        }
        let message = format!(
            "the inertia matrix is singular: `{energy}` does not determine the acceleration of `{label}` beside those of the other coordinates\nhelp: some combination of velocities has no kinetic energy; give it mass, or use fewer coordinates"
        );
        errors.push(name, message);
        return false;
    }
    true
}

/// No inertia matrix under constraints that is singular by itself wherever it is tried: accelerations would be found by
/// pivots that are rounding.
pub fn own_inertia(g: &Graph, m: &[Vec<Value>], model: &Model, errors: &mut Errors) -> bool {
    let own = m.to_vec();
    let mut samples = (0..TRIALS).filter_map(|trial| singular_at(g, &own, trial));
    let Some(Some(i)) = samples.next().filter(|_| !model.constraints.is_empty()) else { return true };
    if !samples.all(|pivot| pivot.is_some()) {
        return true;
    }
    let Model { coordinates, keywords, .. } = model;
    let energy = keywords.kinetic.as_ref().map_or("T".into(), ToString::to_string);
    let (name, whole) = (&coordinates[i].name, coordinates[i].whole());
    let direction = coordinates.iter().find(|c| c.kind == Kind::Direction).map(Coordinate::whole);
    let help = match direction {
        Some(n) => format!(
            "the energy of a length times a direction, `r * {n}`, is `0.5 * m * (dot(r).powi(2) + r.powi(2) * dot({n}).norm_squared())`: `{n}` and `dot({n})` are at right angles, which `{energy}` does not say"
        ),
        None => {
            "give mass to every coordinate, also to those that constraints lead, or use fewer coordinates"
                .into()
        }
    };
    let message = format!(
        "the inertia matrix is singular: without its constraint `{energy}` does not determine the acceleration of `{whole}` beside those of the other coordinates\nhelp: {help}"
    );
    errors.push(name, message);
    false
}

/// [`inertia`] without constraints, which must be positive definite.
pub fn definite_inertia(
    g: &Graph,
    m: &[Vec<Value>],
    momenta: &[Value],
    model: &Model,
    errors: &mut Errors,
) -> bool {
    if !inertia(g, &m.to_vec(), momenta, model, errors) {
        return false;
    }
    let definite =
        is_positive_definite(g, m, |_| None) || is_positive_definite(g, m, |i| model.default_of(i));
    if !definite {
        let message = "constraints that follow from others need a positive definite inertia matrix\nhelp: give mass to every coordinate, or leave out the constraints that follow from others";
        errors.push(&model.constraints[0].name, message);
    }
    definite
}

/// The first pivot of LDLᵀ that rounding explains, at one sample; outer `None` where the matrix has no value there.
fn singular_at(g: &Graph, m: &Symmetric, trial: u64) -> Option<Option<usize>> {
    let n = m.len();
    let mut a = numbers_of(g, m, |s| sample(s, trial, 0));
    if a.iter().flatten().any(|x| !x.is_finite()) {
        return None;
    }
    // In units in which inertia is about 1, and so are the rows of constraints.
    let mut units: Vec<f64> = (0..n).map(|i| a[i][i].abs().sqrt()).collect();
    for i in 0..n {
        if units[i] == 0.0 {
            let of = |j: usize| if units[j] > 0.0 { a[i.max(j)][i.min(j)].abs() / units[j] } else { 0.0 };
            let largest = (0..n).map(of).fold(0.0, f64::max);
            units[i] = if largest > 0.0 { largest } else { 1.0 };
        }
    }
    for i in 0..n {
        (0..=i).for_each(|j| a[i][j] = a[i][j] / units[i] / units[j]);
    }
    let scale: Vec<f64> =
        (0..n).map(|i| (0..n).map(|j| a[i.max(j)][i.min(j)].abs()).fold(0.0, f64::max)).collect();
    for j in 0..n {
        if a[j][j].abs() <= 1e-12 * scale[j] {
            let empty = (j + 1..n).all(|i| a[i][j].abs() <= 1e-12 * scale[i].max(scale[j]));
            // Otherwise the zero may be an accident of the order.
            return Some(if empty { Some(j) } else { undetermined(&a, j) });
        }
        eliminate(&mut a, j);
    }
    Some(None)
}

/// Row of the lower triangle `a` from the first on that depends on the others: the last that complete pivoting leaves.
fn undetermined(a: &[Vec<f64>], first: usize) -> Option<usize> {
    let mut rest: Vec<usize> = (first..a.len()).collect();
    let mut b: Vec<Vec<f64>> =
        rest.iter().map(|&i| rest.iter().map(|&j| a[i.max(j)][i.min(j)]).collect()).collect();
    for k in 0..rest.len() {
        let places = (k..rest.len()).flat_map(|i| (k..rest.len()).map(move |j| (i, j)));
        let (i, j) = places.max_by(|p, q| b[p.0][p.1].abs().total_cmp(&b[q.0][q.1].abs()))?;
        if b[i][j].abs() <= 1e-12 {
            return rest[k..].iter().copied().max();
        }
        b.swap(k, i);
        b.iter_mut().for_each(|row| row.swap(k, j));
        rest.swap(k, j);
        for i in k + 1..rest.len() {
            let l = b[i][k] / b[k][k];
            for j in k + 1..rest.len() {
                b[i][j] -= l * b[k][j];
            }
        }
    }
    None
}

/// Is this matrix positive definite wherever it is tried and has a value, with these values of parameters?
pub fn is_positive_definite(g: &Graph, m: &[Vec<Value>], given: impl Fn(usize) -> Option<f64>) -> bool {
    (0..TRIALS).all(|trial| {
        pivots_exceed(1e-12, g, m, |s| match s {
            Symbol::Parameter(i) => given(i).unwrap_or_else(|| sample(s, trial, 0)),
            _ => sample(s, trial, 0),
        })
    })
}

/// Are the pivots of this matrix more than a millionth of its diagonal near the places at which coordinates are
/// singular: of each coordinate, and of all? Angles are so at quarters of a turn, where axes of rotations meet,
/// lengths at 0; a coordinate of no declared kind may be an angle.
pub fn is_regular(g: &Graph, m: &[Vec<Value>], coordinates: &[Coordinate]) -> bool {
    const DISTANCE: f64 = 1e-4;
    let near = |i: usize, quarters: u8| match coordinates[i].kind {
        Kind::Length | Kind::Rotation | Kind::Direction => DISTANCE,
        Kind::Angle | Kind::Plain | Kind::State => {
            f64::from(quarters) * std::f64::consts::FRAC_PI_2 + DISTANCE
        }
    };
    (0..=m.len()).all(|moved| {
        (0..4).all(|quarters| {
            pivots_exceed(1e-6, g, m, |s| match s {
                Symbol::Coordinate(i) if i == moved || moved == m.len() => near(i, quarters),
                _ => sample(s, 0, 0),
            })
        })
    })
}

/// Are all pivots of a symmetric matrix larger than this part of the diagonal, if it has a value?
fn pivots_exceed(part: f64, g: &Graph, m: &[Vec<Value>], at: impl Fn(Symbol) -> f64) -> bool {
    let a = numbers_of(g, m, at);
    if a.iter().flatten().any(|x| !x.is_finite()) {
        return true;
    }
    let diagonal: Vec<f64> = (0..a.len()).map(|i| a[i][i]).collect();
    pivots(a).into_iter().zip(diagonal).all(|(pivot, entry)| pivot > part * entry)
}

/// The rows of a matrix as numbers.
pub fn numbers_of(g: &Graph, m: &[Vec<Value>], at: impl Fn(Symbol) -> f64) -> Vec<Vec<f64>> {
    let entries: Vec<Value> = m.iter().flatten().copied().collect();
    let mut values = g.evaluate(&entries, at).into_iter();
    m.iter().map(|row| values.by_ref().take(row.len()).collect()).collect()
}

/// Pivots of LDLᵀ without pivoting, by the lower triangle. They are not finite after one that is 0.
pub fn pivots(mut a: Vec<Vec<f64>>) -> Vec<f64> {
    (0..a.len()).for_each(|j| eliminate(&mut a, j));
    (0..a.len()).map(|j| a[j][j]).collect()
}

/// Subtracts multiples of column `j` of the lower triangle `a` from those after it.
fn eliminate(a: &mut [Vec<f64>], j: usize) {
    for i in j + 1..a.len() {
        let l = a[i][j] / a[j][j];
        for k in j + 1..=i {
            a[i][k] -= l * a[k][j];
        }
    }
}

/// Does K x = right hold wherever it is tried and both sides have values?
pub fn is_solution(g: &Graph, matrix: &Symmetric, right: &[Value], x: &[Value]) -> bool {
    let n = matrix.len();
    let all: Vec<Value> = matrix.iter().flatten().chain(right).chain(x).copied().collect();
    (0..TRIALS).all(|trial| {
        let values = g.evaluate(&all, |s| sample(s, trial, 0));
        let (known, x) = values.split_at(all.len() - n);
        let (entries, right) = known.split_at(known.len() - n);
        let entry = |i: usize, j: usize| entries[i.max(j) * (i.max(j) + 1) / 2 + i.min(j)];
        let holds = |i: usize| {
            let terms = (0..n).map(|j| entry(i, j) * x[j]);
            let size = right[i].abs() + terms.clone().map(f64::abs).sum::<f64>();
            (terms.sum::<f64>() - right[i]).abs() <= 1e-6 * size
        };
        known.iter().any(|v| !v.is_finite()) || (0..n).all(holds)
    })
}

/// Is anything divided by what vanishes identically without being written as 0? The value of such a divisor is what
/// rounding leaves, and grows with rounding errors that are made larger.
pub fn divides_by_nothing(g: &Graph, values: &[Value]) -> bool {
    const COARSE: f64 = 1e-8;
    let divisor =
        |id: Id| if let Node::Inverse(under) = g.node(id) { Some(Value::from(*under)) } else { None };
    let divisors: Vec<Value> = g.live(values).into_iter().filter_map(divisor).collect();
    let coarse = |trial: u64| {
        let count = Cell::new(trial);
        let rounded = move |x: f64| {
            count.set(count.get() + 1);
            // Between −1 and 1, without a period.
            let u = 2.0 * (count.get() as f64 * 0.618_033_988_749_894_9).fract() - 1.0;
            x * (1.0 + COARSE * u)
        };
        g.evaluate_rounded(&divisors, |s| sample(s, trial, 0), rounded)
    };
    let all: Vec<[Vec<f64>; 2]> =
        (0..TRIALS).map(|trial| [g.evaluate(&divisors, |s| sample(s, trial, 0)), coarse(trial)]).collect();
    (0..divisors.len()).any(|i| all.iter().all(|[exact, coarse]| exact[i].abs() <= 1e-4 * coarse[i].abs()))
}

/// No elimination order avoids a pivot that is identically zero.
pub fn unsolvable(coordinates: &[Coordinate], keywords: &Keywords, errors: &mut Errors) {
    let moved = coordinates.iter().filter(|c| c.kind != Kind::State);
    let labels: Vec<String> = moved.map(|c| format!("`{}`", c.label())).collect();
    let message = format!(
        "the inertia matrix of {} has a vanishing diagonal: the kinetic energy is not positive definite\nhelp: check the signs and the products of velocities; what moves without inertia is given a mass, or fewer coordinates, also where constraints lead it",
        labels.join(", ")
    );
    match &keywords.kinetic {
        Some(keyword) if keyword == "L" => {
            let message = format!(
                "`L` may be degenerate: the inertia matrix ∂²L/∂q̇² of {} has a vanishing diagonal in every order of elimination\nhelp: check the signs and the products of velocities; let `L` be of second degree in every velocity",
                labels.join(", ")
            );
            errors.push(keyword, message)
        }
        Some(keyword) => errors.push(keyword, message),
        None => errors.push(&coordinates[0].name, message),
    };
}
