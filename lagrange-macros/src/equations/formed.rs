//! The equations of motion before they are solved: M, the forces and the constraints, in every form that elimination
//! tries.

use super::assemble::{Form, Unreduced, exert, flatten, flattened, pulled_back, unreduced};
use super::check;
use super::common::{
    MAX_EXPANDED_COORDINATES, MAX_EXPANDED_TERMS, frictions, in_time, inner, momenta_of_states, symbols,
};
use super::constraints::{Rows, rows};
use super::solve::Symmetric;
use crate::diagnostics::Errors;
use crate::graph::normal::{EXPANSIONS, Expansion};
use crate::graph::{Graph, Symbol, Value};
use crate::model::Model;

/// Terms of L, D, Q and the constraints in q, q̇ and t.
pub struct Formed {
    /// Values of the user's bindings and their rates.
    pub flat: Vec<[Value; 2]>,
    pub lagrangian: Value,
    pub energies: Option<[Value; 2]>,
    pub dissipation: Value,
    /// p = ∂L/∂q̇
    pub momenta: Vec<Value>,
    /// (∂p/∂q) q̇ + ∂p/∂t
    pub bias: Vec<Value>,
    /// ∂L/∂q − ∂D/∂q̇ + Q
    pub force: Vec<Value>,
    /// Q − ∂D/∂q̇
    pub nonconservative: Vec<Value>,
    /// h = p·q̇ − L
    pub energy_function: Value,
    /// (Q − ∂D/∂q̇)·q̇
    pub power: Value,
    pub rows: Rows,
    /// The equations where they were written.
    pub unreduced: Unreduced,
    /// M q̈ = f − b, bordered by the constraints: as it follows from the bindings, from L without them, and
    /// multiplied out.
    pub systems: Vec<System>,
    /// Number of the coordinates before those of the states.
    pub mechanical: usize,
    /// The inertia matrix of the coordinates is positive definite wherever it was tried.
    pub is_definite: bool,
}

/// A symmetric system of linear equations.
pub struct System {
    /// Origin, in words.
    pub form: &'static str,
    pub matrix: Symmetric,
    pub right: Vec<Value>,
}

/// Forms the equations; none if they cannot determine a motion.
pub fn formed(g: &mut Graph, model: &Model, errors: &mut Errors) -> Option<Formed> {
    let n = model.coordinates.len();
    let velocities: Vec<Symbol> = (0..n).map(Symbol::Velocity).collect();
    let coordinates: Vec<Symbol> = (0..n).map(Symbol::Coordinate).collect();
    let qd = symbols(g, Symbol::Velocity, n);
    let mut written = Form::of(model);
    let flat = flatten(g, &written.bindings);
    let expanded = written.expanded(g, &flat);
    let Form { lagrangian, dissipation, .. } = expanded;
    let energies = model.energies.map(|pair| flattened(g, &flat, &pair)).map(|pair| [pair[0], pair[1]]);
    // A potential of states is none of positions and time, as that of `Energies` is.
    let energies = energies.filter(|[_, v]| !g.depends(&[*v], |s| matches!(s, Symbol::Velocity(_))));
    let values: Vec<Value> = model.constraints.iter().map(|c| c.value).collect();
    let values = flattened(g, &flat, &values);
    let rows = rows(g, model, &values, errors)?;
    check::dissipation(g, dissipation, model, errors);

    let mechanical = model.mechanical();
    let mut gradient = g.gradient(lagrangian, &[velocities.clone(), coordinates.clone()].concat());
    momenta_of_states(g, mechanical, &mut gradient[..n]);
    let (momenta, slopes) = gradient.split_at(n);
    check::momenta(g, &momenta[..mechanical], model, errors);
    let friction = frictions(g, dissipation, &velocities, mechanical);
    let mut nonconservative: Vec<Value> = (0..n).map(|i| g.sub(expanded.applied[i], friction[i])).collect();
    exert(g, &expanded.forces, &coordinates, &mut nonconservative);
    exert(g, &expanded.frame_forces, &velocities, &mut nonconservative);
    let force: Vec<Value> = (0..n).map(|i| g.add(slopes[i], nonconservative[i])).collect();
    let bias = g.forward(momenta, in_time(&qd));
    let power = inner(g, &nonconservative[..mechanical], &qd[..mechanical]);
    let pv = inner(g, &momenta[..mechanical], &qd[..mechanical]);
    let energy_function = g.sub(pv, lagrangian);

    written.constraints = rows.written(&model.constraints);
    let unreduced = unreduced(g, &written, &flat);
    let systems = systems(g, &unreduced, (!written.bindings.is_empty()).then_some(&expanded), &rows);
    let damping =
        (0..n).map(|i| g.forward(&[friction[i]], |s| (s == velocities[i]).then_some(Value::ONE))[0]);
    let damping: Vec<Value> = damping.collect();
    check::signs(g, &systems[0].matrix, &damping, &model.coordinates, &model.keywords, errors);
    let is_definite = check::is_definite(g, &systems[0].matrix[..mechanical], model, errors);
    // The bordered matrix is singular where constraints follow from others.
    let sound = match rows.redundancy {
        None => {
            systems.iter().all(|system| check::inertia(g, &system.matrix, momenta, model, errors))
                && check::own_inertia(g, &systems[0].matrix[..n], model, errors)
        }
        Some(_) => check::definite_inertia(g, &systems[0].matrix[..n], momenta, model, errors),
    };
    let momenta = momenta.to_vec();
    sound.then_some(Formed {
        flat,
        lagrangian,
        energies,
        dissipation,
        momenta,
        bias,
        force,
        nonconservative,
        energy_function,
        power,
        rows,
        unreduced,
        systems,
        mechanical,
        is_definite,
    })
}

/// M and f − b in all forms, of which the first is that of the equations as they were written.
fn systems(g: &mut Graph, written: &Unreduced, expanded: Option<&Form>, rows: &Rows) -> Vec<System> {
    let few = written.coordinates <= MAX_EXPANDED_COORDINATES;
    let expanded = expanded.filter(|_| few).map(|form| unreduced(g, form, &[]));
    let mut systems = Vec::new();
    for (at, form) in [written].into_iter().chain(&expanded).zip(["as written", "bindings expanded"]) {
        let (inertia, right) = pulled_back(g, at);
        let (matrix, right) = rows.border(&inertia, &right);
        systems.push(System { form, matrix, right });
    }
    for how in EXPANSIONS.into_iter().filter(|_| few) {
        systems.extend(multiplied_out(g, &systems[0], how));
    }
    systems
}

/// The equations multiplied out, if that is not too long.
fn multiplied_out(g: &mut Graph, system: &System, how: Expansion) -> Option<System> {
    let mut expanded = |row: &Vec<Value>| g.expanded(row, MAX_EXPANDED_TERMS, how);
    let matrix = system.matrix.iter().map(&mut expanded).collect::<Option<_>>()?;
    Some(System { form: how.name(), matrix, right: expanded(&system.right)? })
}
