//! Coordinates that follow the others as in statics: their inertia and damping are left out of their own equations,
//!
//!   ∂V/∂x = Q at rest,   hence x = X(q, t) where this is linear in x.
//!
//! With ẋ = Ẋ in T and D this is static condensation (Guyan 1965): the system on the set x = X, which keeps its
//! structure.

use super::Derived;
use super::common::{independent, shortest};
use super::simplified::Parts;
use super::solve::swept;
use crate::graph::{Function, Graph, Node, Symbol, Value};
use crate::model::Model;
use crate::model::submodel::Hold;

/// Values at which these coordinates of the whole system follow, in its symbols.
pub fn statics(
    (graph, model): &(Graph, Model),
    whole: &Derived,
    following: &[usize],
) -> Result<(Graph, Vec<Hold>), String> {
    let origin = model.origin.as_ref().expect("a derived system");
    let place = |i: usize| origin.kept.iter().position(|k| *k == i).expect("it is not held");
    let x: Vec<usize> = following.iter().map(|i| place(*i)).collect();
    let label = |k: usize| model.coordinates[x[k]].label();
    let acts = |row: &[Value]| following.iter().any(|i| !row[*i].is_zero());
    if let Some(j) = whole.equations.formed.rows.jacobian.iter().position(|row| acts(row)) {
        return Err(format!(
            "the multiplier of the constraint `{}` acts in statics, too, and is not known here",
            whole.model.constraints[j].label()
        ));
    }
    let g = &mut graph.clone();
    let parts = Parts::of(g, model);
    let mechanical = model.mechanical();
    let rest = |g: &mut Graph, values: &[Value]| {
        g.substitute(values, |s| matches!(s, Symbol::Velocity(i) if i < mechanical).then_some(Value::ZERO))
    };
    let at_rest = rest(g, &[parts.lagrangian])[0];
    let symbols: Vec<Symbol> = x.iter().map(|i| Symbol::Coordinate(*i)).collect();
    let forces: Vec<Value> = x.iter().map(|i| parts.forces[*i]).collect();
    for (k, force) in forces.iter().enumerate() {
        if switches(g, *force, mechanical) {
            return Err(format!(
                "the force on `{}` switches with velocities, as dry friction does, and has no value at rest",
                label(k)
            ));
        }
    }
    let forces = rest(g, &forces);
    // −∂L/∂x − Q, which vanishes.
    let slopes = g.gradient(at_rest, &symbols);
    let sums: Vec<Value> = slopes.iter().zip(forces).map(|(slope, force)| -g.add(*slope, force)).collect();
    let solution = solved(g, &sums, &symbols, label)?;
    for (k, value) in solution.iter().enumerate() {
        may_follow(g, model, *value, &label(k))?;
    }
    let solution = shortest(g, model.coordinates.len(), &solution);
    let (all, solution) = in_whole(g, model, whole, &solution);
    let holds = following.iter().zip(solution).map(|(&index, value)| Hold { index, value });
    Ok((all, holds.collect()))
}

/// The coordinates x at which these sums vanish, which are linear in them.
fn solved(
    g: &mut Graph,
    sums: &[Value],
    x: &[Symbol],
    label: impl Fn(usize) -> String,
) -> Result<Vec<Value>, String> {
    let mut matrix: Vec<Vec<Value>> = Vec::new();
    for (k, sum) in sums.iter().enumerate() {
        let row = g.gradient(*sum, x);
        if !row.iter().all(|v| independent(g, &[*v], |s| x.contains(&s))) {
            return Err(format!("the equation ∂V/∂q = Q of `{}` is not linear in what follows", label(k)));
        }
        for l in 0..k {
            let difference = g.sub(row[l], matrix[l][k]);
            if !g.vanishes(difference) {
                return Err(format!("the forces on `{}` and `{}` have no potential", label(l), label(k)));
            }
        }
        matrix.push(row);
    }
    let right = g.substitute(sums, |s| x.contains(&s).then_some(Value::ZERO));
    let mut lower: Vec<Vec<Value>> = (0..x.len()).map(|k| matrix[k][..=k].to_vec()).collect();
    let mut y: Vec<Value> = right.iter().map(|v| -*v).collect();
    if swept(g, &mut lower, &mut y).is_none() {
        return Err(format!("statics do not determine `{}`: ∂²V/∂q² vanishes", label(0)));
    }
    let mut solution = vec![Value::ZERO; x.len()];
    for k in (0..x.len()).rev() {
        let mut rest = y[k];
        for i in k + 1..x.len() {
            let product = g.mul(lower[i][k], solution[i]);
            rest = g.sub(rest, product);
        }
        solution[k] = g.quotient(rest, lower[k][k]);
    }
    Ok(solution)
}

/// Refuses what a coordinate of this name cannot follow: states and inputs, which jump, and rotations.
fn may_follow(g: &Graph, model: &Model, value: Value, label: &str) -> Result<(), String> {
    let what = g.symbols(&[value]).into_iter().find_map(|s| match s {
        Symbol::Velocity(_) => Some("a state of first order"),
        Symbol::Parameter(i) if g.inputs.contains(&i) => Some("an input, which may change between steps"),
        _ => None,
    });
    if let Some(what) = what {
        return Err(format!("`{label}` would follow {what}, and jump with it"));
    }
    let of_attitude = |i: usize| model.attitudes.iter().any(|a| (a.first..a.first + 3).contains(&i));
    match g.depends(&[value], |s| matches!(s, Symbol::Coordinate(i) if of_attitude(i))) {
        // (Equations of bodies are those of angular velocities, which parameters of their own have no part in.)
        true => Err(format!(
            "`{label}` would follow a rotation, which equations of bodies know by its angular velocity alone: write another system, with `let {label} = …;` in the place of the coordinate"
        )),
        false => Ok(()),
    }
}

/// Values of a derived system in the symbols of the whole one, beside its graph.
fn in_whole(g: &Graph, model: &Model, whole: &Derived, values: &[Value]) -> (Graph, Vec<Value>) {
    let kept = &model.origin.as_ref().expect("a derived system").kept;
    let mut all = whole.graph.clone();
    let numbers: Vec<usize> = model
        .parameters
        .iter()
        .flat_map(|p| {
            let of = whole.model.parameters.iter().find(|other| other.name == p.name);
            let first = of.expect("a parameter of the whole system").first;
            p.numbers().map(move |i| first + i - p.first)
        })
        .collect();
    let values = all.import(g, values, |g, symbol| match symbol {
        Symbol::Coordinate(i) => g.symbol(Symbol::Coordinate(kept[i])),
        Symbol::Parameter(i) => g.symbol(Symbol::Parameter(numbers[i])),
        other => g.symbol(other),
    });
    (all, values)
}

/// Does a force switch with velocities, as dry friction does? Then what it is at rest is not what it does.
fn switches(g: &Graph, force: Value, mechanical: usize) -> bool {
    let is_velocity = |s: Symbol| matches!(s, Symbol::Velocity(i) if i < mechanical);
    g.live(&[force]).into_iter().any(|id| match g.node(id) {
        Node::Call(Function::signum, at, _) => g.depends(&[*at], is_velocity),
        Node::Select(_, values) => g.depends(&values[..2], is_velocity),
        _ => false,
    })
}
