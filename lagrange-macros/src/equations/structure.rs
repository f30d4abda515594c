//! Facts read off the equations. A fact is stated only if it is proved: by absence from the graph, or by
//! multiplying out (`graph/normal.rs`).

use super::common::{independent, jumps};
use super::formed::Formed;
use super::quantities::Quantities;
use super::solve::{Symmetric, blocks, entry};
use super::solved::Solved;
use crate::graph::{Graph, Symbol, Value};
use crate::model::frames::Motion;
use crate::model::{Binding, Model};

/// Facts about a system; the runtime's `Facts` explains each.
#[derive(Default, Debug)]
pub struct Facts {
    pub scleronomic: bool,
    pub autonomous: bool,
    pub conservative: bool,
    pub linear_damping: bool,
    pub ignorable: Vec<usize>,
    pub separable: bool,
    pub constant_inertia: bool,
    pub quadratic: bool,
    pub quadratic_forces: bool,
    pub linear: bool,
    pub blocks: Vec<Vec<usize>>,
}

fn is_velocity(s: Symbol) -> bool {
    matches!(s, Symbol::Velocity(_))
}

fn is_state(s: Symbol) -> bool {
    matches!(s, Symbol::Velocity(_) | Symbol::Coordinate(_) | Symbol::Time)
}

/// Does time enter an expression as it was written? Time in the kinematics makes a system rheonomic, even where it
/// drops out of L. It enters a velocity of a frame also where that does not vanish at rest, as at the angle ω t.
fn written_with_time(g: &mut Graph, v: Value, bindings: &[Binding]) -> bool {
    let mut seen = vec![false; bindings.len()];
    let mut left = vec![v];
    while let Some(v) = left.pop() {
        for symbol in g.symbols(&[v]) {
            match symbol {
                Symbol::Time => return true,
                Symbol::Binding(k) | Symbol::Rate(k) if !std::mem::replace(&mut seen[k], true) => {
                    let &Binding { value, rate, motion, .. } = &bindings[k];
                    left.extend([value, rate]);
                    let at_rest =
                        |s| matches!(s, Symbol::Velocity(_) | Symbol::Rate(_)).then_some(Value::ZERO);
                    let quasi = matches!(motion, Motion::Quasi(_));
                    if quasi && !g.substitute(&[rate], at_rest)[0].is_zero() {
                        return true;
                    }
                }
                _ => {}
            }
        }
    }
    false
}

pub fn facts(
    g: &mut Graph,
    model: &Model,
    formed: &Formed,
    solved: &Solved,
    quantities: &Quantities,
) -> Facts {
    let (n, mechanical) = (model.coordinates.len(), model.mechanical());
    let without_states = mechanical == n;
    let Formed { nonconservative, rows, .. } = formed;
    let Quantities { lagrangian, dissipation, .. } = quantities;
    let Solved { inertia: matrix, right, .. } = solved;
    let inertia: Vec<Value> = matrix.iter().flatten().copied().collect();
    let quadratic = independent(g, &inertia, is_velocity);
    let constant_inertia = independent(g, &inertia, is_state);
    let written: Vec<Value> =
        [model.lagrangian].into_iter().chain(model.constraints.iter().map(|c| c.value)).collect();
    let scleronomic = !written.iter().any(|v| written_with_time(g, *v, &model.bindings));
    let is_time = |s| s == Symbol::Time;
    let timeless = independent(g, &[*lagrangian], is_time);
    // λ·g vanishes with g; its part λ A q̇ = −λ b is the power of a constraint that moves.
    let moved = rows.at_rest(g);
    let constraints = [&rows.values, &rows.rates, &rows.drift].into_iter().flatten();
    let equations: Vec<Value> = inertia.iter().chain(right).chain(constraints).copied().collect();
    let autonomous = independent(g, &equations, is_time);
    let quadratic_forces = quadratic
        && without_states
        && nonconservative.iter().all(|q| g.degree(*q, is_velocity).is_some_and(|degree| degree <= 2));
    let workless = without_states && nonconservative.iter().chain(&moved).all(|q| g.vanishes(*q));
    let velocities: Vec<Symbol> = (0..n).map(Symbol::Velocity).collect();
    let at_rest = g.substitute(nonconservative, |s| is_velocity(s).then_some(Value::ZERO));
    let damping: Vec<Value> = nonconservative.iter().flat_map(|q| g.gradient(*q, &velocities)).collect();
    let damped = without_states
        && at_rest.iter().all(|q| g.vanishes(*q))
        && !jumps(g, nonconservative).into_iter().any(is_state)
        && independent(g, &damping, is_state);
    let mut all = nonconservative.clone();
    all.extend([*lagrangian, *dissipation]);
    all.extend(rows.jacobian.iter().flatten().chain(&moved));
    all.retain(|v| !v.is_constant());
    let coordinates: Vec<Symbol> = (0..n).map(Symbol::Coordinate).collect();
    let jumping = jumps(g, &all);
    let slopes: Vec<Vec<Value>> = all.iter().map(|v| g.gradient(*v, &coordinates)).collect();
    let ignorable = (0..mechanical).filter(|&i| {
        !jumping.contains(&coordinates[i])
            && slopes.iter().all(|by| g.vanishes(by[i]))
            && g.vanishes(nonconservative[i])
            && rows.jacobian.iter().all(|row| g.vanishes(row[i]))
    });
    let ignorable = ignorable.collect();
    let free = rows.is_empty();
    let separable =
        free && without_states && quadratic && constant_inertia && independent(g, right, is_velocity);
    let linear = free && constant_inertia && {
        let state: Vec<Symbol> = (0..n).flat_map(|i| [Symbol::Coordinate(i), Symbol::Velocity(i)]).collect();
        let slopes: Vec<Value> = right.iter().flat_map(|r| g.gradient(*r, &state)).collect();
        // The slopes of a force that jumps do not show where.
        !jumps(g, right).iter().any(|s| state.contains(s)) && independent(g, &slopes, is_state)
    };
    Facts {
        scleronomic,
        autonomous,
        conservative: timeless && workless,
        linear_damping: timeless && damped && moved.iter().all(|q| g.vanishes(*q)),
        ignorable,
        separable,
        constant_inertia,
        quadratic,
        quadratic_forces,
        linear,
        blocks: coupled_blocks(g, matrix, right, &rows.jacobian),
    }
}

/// Coordinates that the equations do not couple: neither by M and the constraints, nor by what their entries depend on.
fn coupled_blocks(
    g: &Graph,
    matrix: &Symmetric,
    right: &[Value],
    jacobian: &[Vec<Value>],
) -> Vec<Vec<usize>> {
    let n = right.len();
    let touch = |i: usize, j: usize| {
        !entry(matrix, i, j).is_zero() || jacobian.iter().any(|row| !row[i].is_zero() && !row[j].is_zero())
    };
    // As a rule M alone couples all coordinates. Rows of many have long expressions.
    let by_entries = blocks(n, touch);
    if by_entries.len() == 1 {
        return by_entries;
    }
    let depends = |i: usize| {
        let mut row: Vec<Value> = (0..n).map(|j| entry(matrix, i, j)).collect();
        row.push(right[i]);
        row.extend(jacobian.iter().filter(|a| !a[i].is_zero()).flatten());
        let mut depends = vec![false; n];
        for symbol in g.symbols(&row) {
            if let Symbol::Coordinate(j) | Symbol::Velocity(j) = symbol {
                depends[j] = true;
            }
        }
        depends
    };
    let depends: Vec<Vec<bool>> = (0..n).map(depends).collect();
    blocks(n, |i, j| depends[i][j] || depends[j][i] || touch(i, j))
}
