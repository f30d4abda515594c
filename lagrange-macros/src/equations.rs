//! Lagrange's equations of a model, solved for the accelerations, and everything else that follows from L, D and Q:
//! each quantity an expression in q, q̇, t and the parameters.

pub mod assemble;
pub mod augmented;
pub mod check;
pub mod constraints;
pub mod elimination;
pub mod linearization;
pub mod routhian;
pub mod series;
pub mod solve;
pub mod structure;

use crate::diagnostics::Errors;
use crate::graph::normal::{EXPANSIONS, Expansion};
use crate::graph::{Graph, Symbol, Value};
use crate::model::Model;
use crate::model::frames::Frames;
use crate::schedule::count::{Operations, operations};
use assemble::{Form, exert, flatten, flattened, pulled_back, unreduced};
use constraints::{Rows, rows};
use elimination::{Solved, Solver, eliminated};
use linearization::{Linearization, linearization};
use series::Series;
use solve::{Symmetric, entry};
use structure::Facts;

/// Accelerations longer than this, times the columns of their Jacobian, are differentiated at run time by duals:
/// the emitted Jacobian would cost more to compile than it saves.
const JACOBIAN_BUDGET: usize = 1000;
/// Systems of more coordinates are not tried with their bindings expanded.
const EXPANDED: usize = 6;

pub struct Equations {
    pub model: Model,
    pub lagrangian: Value,
    pub energies: Option<[Value; 2]>,
    pub dissipation: Value,
    /// p = ∂L/∂q̇
    pub momenta: Vec<Value>,
    /// M = ∂²L/∂q̇²
    pub inertia: Symmetric,
    /// (∂p/∂q) q̇ + ∂p/∂t
    pub bias: Vec<Value>,
    /// ∂L/∂q − ∂D/∂q̇ + Q
    pub force: Vec<Value>,
    /// Q − ∂D/∂q̇
    pub nonconservative: Vec<Value>,
    /// force − bias, as it was assembled for the accelerations
    pub right: Vec<Value>,
    /// h = p·q̇ − L
    pub jacobi: Value,
    /// (Q − ∂D/∂q̇)·q̇
    pub power: Value,
    pub accel: Vec<Value>,
    pub rows: Rows,
    /// λ
    pub multipliers: Vec<Value>,
    /// What M x − Aᵀ Λ = P, A x = r gives for any P and r: x, then Λ.
    pub response: Vec<Value>,
    /// Generalized forces at the prescribed coordinates.
    pub reactions: Vec<Value>,
    /// The same in terms of q̈ and λ, as the equations of the relaxed coordinates have them.
    pub relaxed: Vec<Value>,
    /// Generalized impulses of those that act at points, by points.
    pub impulses: Vec<Vec<Value>>,
    /// q̇ of given p, if L is quadratic in q̇ and the coordinates are independent,
    pub velocities: Option<Vec<Value>>,
    /// by M q̇ = this.
    pub driven: Vec<Value>,
    pub jacobian: Option<Jacobian>,
    pub linearization: Option<Linearization>,
    /// Switching functions of the accelerations, each with its rate in terms of q, q̇, t and given accelerations.
    pub switches: Vec<[Value; 2]>,
    /// Recurrences of the Taylor coefficients.
    pub series: Option<Series>,
    pub observed: Vec<Vec<Value>>,
    /// Values of the user's bindings and their rates, in terms of q, q̇ and t.
    pub flat: Vec<[Value; 2]>,
    pub facts: Facts,
    pub operations: Operations,
}

/// Derivatives of the accelerations, by columns.
pub struct Jacobian {
    pub q: Vec<Vec<Value>>,
    pub qd: Vec<Vec<Value>>,
    pub t: Vec<Value>,
}

impl Equations {
    /// Has the motion Taylor series everywhere, on no side of anything?
    pub fn analytic(&self) -> bool {
        self.series.as_ref().is_some_and(|series| series.switches.is_empty())
    }
}

/// Derives the equations. What only derivation finds (singular inertia, a D that is no quadratic form) is recorded.
pub fn equations(mut model: Model, errors: &mut Errors) -> Option<Equations> {
    let n = model.coordinates.len();
    let bindings: Vec<[Value; 2]> = model.bindings.iter().map(|b| [b.value, b.rate]).collect();
    let g = &mut model.graph;
    let velocities: Vec<Symbol> = (0..n).map(Symbol::Velocity).collect();
    let coordinates: Vec<Symbol> = (0..n).map(Symbol::Coordinate).collect();
    let qd: Vec<Value> = velocities.iter().map(|v| g.symbol(*v)).collect();

    let flat = flatten(g, &bindings);
    let lagrangian = flattened(g, &flat, &[model.lagrangian])[0];
    let dissipation = flattened(g, &flat, &[model.dissipation])[0];
    let energies = model.energies.map(|pair| flattened(g, &flat, &pair)).map(|pair| [pair[0], pair[1]]);
    let applied = flattened(g, &flat, &model.applied);
    let pairs = |g: &mut Graph, pairs: &[(Value, Value)]| -> Vec<(Value, Value)> {
        let both = pairs.iter().map(|&(force, x)| flattened(g, &flat, &[force, x]));
        both.map(|pair| (pair[0], pair[1])).collect()
    };
    let (forces, driven) = (pairs(g, &model.forces), pairs(g, &model.driven));
    let values: Vec<Value> = model.constraints.iter().map(|c| c.value).collect();
    let values = flattened(g, &flat, &values);
    let rows = rows(g, &model.constraints, &values, n, errors)?;
    check::dissipation(g, dissipation, n, &model.places, errors);

    let gradient = g.gradient(lagrangian, &[velocities.clone(), coordinates.clone()].concat());
    let (momenta, slopes) = gradient.split_at(n);
    let friction = g.gradient(dissipation, &velocities);
    let mut nonconservative: Vec<Value> = (0..n).map(|i| g.sub(applied[i], friction[i])).collect();
    exert(g, &forces, &coordinates, &mut nonconservative);
    exert(g, &driven, &velocities, &mut nonconservative);
    let force: Vec<Value> = (0..n).map(|i| g.add(slopes[i], nonconservative[i])).collect();
    let bias = g.forward(momenta, in_time(&qd));
    let power = inner(g, &nonconservative, &qd);
    let pv = inner(g, momenta, &qd);
    let jacobi = g.sub(pv, lagrangian);

    let relaxed: Vec<usize> = model.prescribed.iter().map(|p| p.binding).collect();
    let kept = Form::of(&model, rows.written(&model.constraints));
    let g = &mut model.graph;
    let expanded = Form {
        coordinates: n,
        bindings: Vec::new(),
        motions: Vec::new(),
        frames: Frames::default(),
        lagrangian,
        dissipation,
        forces,
        driven,
        applied,
        constraints: Vec::new(),
    };
    let mut forms = vec![unreduced(g, &kept)];
    if !kept.bindings.is_empty() && n <= EXPANDED {
        forms.push(unreduced(g, &expanded));
    }
    let mut systems: Vec<(Symmetric, Vec<Value>)> = Vec::new();
    for at in &forms {
        let (inertia, right) = pulled_back(g, at);
        systems.push(rows.border(&inertia, &right));
    }
    if n <= EXPANDED {
        for how in EXPANSIONS {
            systems.extend(multiplied_out(g, &systems[0], how));
        }
    }
    let damping: Vec<Value> = (0..n)
        .map(|i| g.forward(&[friction[i]], |s| (s == velocities[i]).then_some(Value::ONE))[0])
        .collect();
    check::signs(g, &systems[0].0, &damping, &model.coordinates, &model.places, errors);
    for (matrix, _) in &systems {
        let (coordinates, constraints) = (&model.coordinates, &model.constraints);
        if !check::inertia(g, matrix, momenta, coordinates, constraints, &model.places, errors) {
            return None;
        }
    }
    let Some(solved) = eliminated(g, &forms[0], &systems, n) else {
        check::unsolvable(&model.coordinates, &model.places, errors);
        return None;
    };
    let Solved { matrix, right, solver, accel, multipliers, operations, orders } = solved;
    if !errors.is_empty() {
        return None;
    }
    let g = &mut model.graph;
    let (mut reactions, mut relaxed_equations) = (Vec::new(), Vec::new());
    if !relaxed.is_empty() {
        reactions = assemble::reactions(g, &forms[0], &relaxed, &multipliers, &accel);
        let symbols = |g: &mut Graph, symbol: fn(usize) -> Symbol, n: usize| -> Vec<Value> {
            (0..n).map(|i| g.symbol(symbol(i))).collect()
        };
        let lambda = symbols(g, Symbol::Multiplier, rows.len());
        let qdd = symbols(g, Symbol::Acceleration, n);
        relaxed_equations = assemble::reactions(g, &forms[0], &relaxed, &lambda, &qdd);
    }
    let reactions = shortest(g, n, &reactions);
    let multipliers = shortest(g, n, &multipliers);
    let mut observed = Vec::new();
    for o in &model.observed {
        let known = g.substitute(&o.values, |s| match s {
            Symbol::Multiplier(j) => Some(multipliers[j]),
            Symbol::Reaction(k) => Some(reactions[k]),
            _ => None,
        });
        observed.push(flattened(g, &flat, &known));
    }
    let mut impulses = Vec::new();
    for point in &model.struck {
        let position = flattened(g, &flat, &point.position);
        impulses.push(generalized(g, &position, &coordinates));
    }

    let momenta = shortest(g, n, momenta);
    let bias = shortest(g, n, &bias);
    let force = shortest(g, n, &force);
    let [lagrangian, jacobi, power, dissipation] =
        [lagrangian, jacobi, power, dissipation].map(|v| shortest(g, n, &[v])[0]);
    let mut e = Equations {
        lagrangian,
        energies,
        dissipation,
        momenta,
        inertia: matrix[..n].to_vec(),
        bias,
        force,
        nonconservative,
        right: right[..n].to_vec(),
        jacobi,
        power,
        accel,
        rows,
        multipliers,
        response: Vec::new(),
        reactions,
        relaxed: relaxed_equations,
        impulses,
        velocities: None,
        driven: Vec::new(),
        jacobian: None,
        linearization: None,
        switches: Vec::new(),
        series: None,
        observed,
        flat,
        facts: Facts::default(),
        operations,
        model,
    };
    e.facts = structure::facts(&mut e);
    if !e.rows.is_empty() {
        e.response = response(&mut e, &solver)?;
    } else if e.facts.quadratic {
        e.velocities = legendre(&mut e, &solver);
    }
    if (2 * n + 1) * e.operations.arithmetic() <= JACOBIAN_BUDGET {
        e.jacobian = jacobian(&mut e, &solver);
    }
    e.linearization = linearization(&mut e);
    e.switches = switches(&mut e);
    e.series = series::series(&mut e, &forms[0], &orders, &solver);
    Some(e)
}

/// Expressions of more terms are not multiplied out for emission.
const LONGEST: usize = 24;

/// The equations multiplied out, if that is not too long.
fn multiplied_out(
    g: &mut Graph,
    (inertia, right): &(Symmetric, Vec<Value>),
    how: Expansion,
) -> Option<(Symmetric, Vec<Value>)> {
    let inertia = inertia.iter().map(|row| g.expanded(row, LONGEST, how)).collect::<Option<_>>()?;
    Some((inertia, g.expanded(right, LONGEST, how)?))
}

/// The values as they are or, in a system of few coordinates, multiplied out, whichever costs least.
fn shortest(g: &mut Graph, coordinates: usize, values: &[Value]) -> Vec<Value> {
    let mut best = g.share_angles(values);
    if coordinates > EXPANDED {
        return best;
    }
    for how in EXPANSIONS {
        let Some(expanded) = g.expanded(values, LONGEST, how) else { continue };
        let expanded = g.share_angles(&expanded);
        if operations(g, &expanded).cost() < operations(g, &best).cost() {
            best = expanded;
        }
    }
    best
}

/// Everything moves at its rate.
pub fn in_time(qd: &[Value]) -> impl Fn(Symbol) -> Option<Value> {
    |symbol| match symbol {
        Symbol::Coordinate(i) => Some(qd[i]),
        Symbol::Time => Some(Value::ONE),
        _ => None,
    }
}

fn inner(g: &mut Graph, a: &[Value], b: &[Value]) -> Value {
    a.iter().zip(b).fold(Value::ZERO, |sum, (a, b)| {
        let term = g.mul(*a, *b);
        g.add(sum, term)
    })
}

/// p = M q̇ + p₀ solved for q̇, with p₀ = ∂L/∂q̇ at rest.
fn legendre(e: &mut Equations, solver: &Solver) -> Option<Vec<Value>> {
    let g = &mut e.model.graph;
    let at_rest = g.substitute(&e.momenta, |s| matches!(s, Symbol::Velocity(_)).then_some(Value::ZERO));
    let right = at_rest.into_iter().enumerate().map(|(i, rest)| {
        let p = g.symbol(Symbol::Momentum(i));
        g.sub(p, rest)
    });
    let right: Vec<Value> = right.collect();
    e.driven = right.clone();
    let solution = solver.solve(g, &[right])?.pop()?;
    // The inertia may still name velocities that are proved to drop out.
    Some(g.substitute(&solution, |s| matches!(s, Symbol::Velocity(_)).then_some(Value::ZERO)))
}

/// Switching functions of the accelerations, and their rates under accelerations that are given.
fn switches(e: &mut Equations) -> Vec<[Value; 2]> {
    let g = &mut e.model.graph;
    let values = series::switches::switching(g, &e.accel);
    if values.is_empty() {
        return Vec::new();
    }
    let n = e.accel.len();
    let [velocities, accelerations] = [Symbol::Velocity, Symbol::Given]
        .map(|symbol| (0..n).map(|i| g.symbol(symbol(i))).collect::<Vec<_>>());
    let along = in_time(&velocities);
    let rates = g.forward(&values, |symbol| match symbol {
        Symbol::Velocity(i) => Some(accelerations[i]),
        other => along(other),
    });
    values.into_iter().zip(rates).map(|(value, rate)| [value, rate]).collect()
}

/// The generalized impulse Σ P ∂x/∂q of an impulse P, given, at the position x (Beatty 2006, (11.58)).
fn generalized(g: &mut Graph, x: &[Value], coordinates: &[Symbol]) -> Vec<Value> {
    let blow: Vec<(Value, Value)> =
        x.iter().enumerate().map(|(i, x)| (g.symbol(Symbol::Given(i)), *x)).collect();
    let mut sum = vec![Value::ZERO; coordinates.len()];
    exert(g, &blow, coordinates, &mut sum);
    sum
}

/// The bordered system for any right-hand side.
fn response(e: &mut Equations, solver: &Solver) -> Option<Vec<Value>> {
    let (n, g) = (e.accel.len(), &mut e.model.graph);
    let given: Vec<Value> = (0..n + e.rows.len()).map(|i| g.symbol(Symbol::Given(i))).collect();
    let mut solution = solver.solve(g, &[given])?.pop()?;
    solution[n..].iter_mut().for_each(|x| *x = -*x);
    Some(g.share_angles(&solution))
}

/// ∂q̈/∂x = −M⁻¹ ∂(M a − right)/∂x at a = q̈, with M bordered and λ beside q̈ where there are constraints.
fn jacobian(e: &mut Equations, solver: &Solver) -> Option<Jacobian> {
    let n = e.accel.len();
    let (matrix, right) = e.rows.border(&e.inertia, &e.right);
    let g = &mut e.model.graph;
    let unknown = |i: usize| if i < n { Symbol::Acceleration(i) } else { Symbol::Multiplier(i - n) };
    let x: Vec<Value> = (0..right.len())
        .map(|i| {
            let symbol = g.symbol(unknown(i));
            if i < n { symbol } else { -symbol }
        })
        .collect();
    let residual: Vec<Value> = (0..right.len())
        .map(|i| {
            let row: Vec<Value> = (0..right.len()).map(|j| entry(&matrix, i, j)).collect();
            let inertial = inner(g, &row, &x);
            g.sub(right[i], inertial)
        })
        .collect();
    let by: Vec<Symbol> =
        (0..n).map(Symbol::Coordinate).chain((0..n).map(Symbol::Velocity)).chain([Symbol::Time]).collect();
    let columns: Vec<Vec<Value>> =
        by.iter().map(|x| g.forward_with_limits(&residual, |s| (s == *x).then_some(Value::ONE))).collect();
    let solved = solver.solve(g, &columns)?;
    let all: Vec<Value> = solved.into_iter().flat_map(|column| column[..n].to_vec()).collect();
    let (accel, multipliers) = (e.accel.clone(), e.multipliers.clone());
    let all = g.substitute(&all, |s| match s {
        Symbol::Acceleration(i) => Some(accel[i]),
        Symbol::Multiplier(j) => Some(multipliers[j]),
        _ => None,
    });
    let mut columns: Vec<Vec<Value>> = g.share_angles(&all).chunks(n).map(<[Value]>::to_vec).collect();
    let t = columns.pop()?;
    let qd = columns.split_off(n);
    Some(Jacobian { q: columns, qd, t })
}
