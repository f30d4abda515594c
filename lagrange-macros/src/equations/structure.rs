//! Facts read off the equations. A fact is stated only if it is proved: by absence from the graph, or by
//! multiplying out (`graph/normal.rs`).

use super::common::{independent, jumps};
use super::constraints::Rows;
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
    pub cascade: Vec<Vec<usize>>,
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
    let (blocks, cascade) = coupling(g, matrix, right, rows);
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
        blocks,
        cascade,
    }
}

/// Blocks of coordinates that the equations do not couple, neither by M and the constraints nor by what their entries
/// depend on; and groups that are coupled in one way at most, drivers first.
fn coupling(
    g: &Graph,
    matrix: &Symmetric,
    right: &[Value],
    rows: &Rows,
) -> (Vec<Vec<usize>>, Vec<Vec<usize>>) {
    let n = right.len();
    let touch = |i: usize, j: usize| {
        !entry(matrix, i, j).is_zero()
            || rows.jacobian.iter().any(|row| !row[i].is_zero() && !row[j].is_zero())
    };
    // As a rule M alone couples all coordinates. Rows of many have long expressions.
    let by_entries = blocks(n, touch);
    if by_entries.len() == 1 {
        return (by_entries.clone(), by_entries);
    }
    let depends = |i: usize| {
        let mut row: Vec<Value> = (0..n).map(|j| entry(matrix, i, j)).collect();
        row.push(right[i]);
        let held = rows.jacobian.iter().zip(&rows.drift).filter(|(a, _)| !a[i].is_zero());
        held.for_each(|(a, drift)| row.extend(a.iter().chain([drift])));
        let mut depends: Vec<bool> = (0..n).map(|j| touch(i, j)).collect();
        for symbol in g.symbols(&row) {
            if let Symbol::Coordinate(j) | Symbol::Velocity(j) = symbol {
                depends[j] = true;
            }
        }
        depends
    };
    let depends: Vec<Vec<bool>> = (0..n).map(depends).collect();
    (blocks(n, |i, j| depends[i][j] || depends[j][i]), driven_last(&depends))
}

/// The strongly connected components of a graph in which `depends[i][j]` says that i depends on j: each after those
/// that it depends on (Kosaraju's two searches; Sharir, *Computers and Mathematics with Applications* 7, 1981).
fn driven_last(depends: &[Vec<bool>]) -> Vec<Vec<usize>> {
    let n = depends.len();
    // Everything that is reached from `first` and was not before, each after what is reached through it.
    let reached = |first: usize, seen: &mut [bool], edge: &dyn Fn(usize, usize) -> bool| {
        let (mut path, mut left) = (vec![(first, 0)], Vec::new());
        seen[first] = true;
        while let Some((at, next)) = path.pop() {
            match (next..n).find(|&j| edge(at, j) && !seen[j]) {
                Some(j) => {
                    seen[j] = true;
                    path.extend([(at, j + 1), (j, 0)]);
                }
                None => left.push(at),
            }
        }
        left
    };
    let (mut seen, mut order) = (vec![false; n], Vec::new());
    for i in 0..n {
        if !seen[i] {
            order.extend(reached(i, &mut seen, &|driver, driven| depends[driven][driver]));
        }
    }
    let (mut seen, mut groups) = (vec![false; n], Vec::new());
    for &i in order.iter().rev() {
        if !seen[i] {
            let mut group = reached(i, &mut seen, &|driven, driver| depends[driven][driver]);
            group.sort_unstable();
            groups.push(group);
        }
    }
    groups
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn drivers_come_first() {
        // 2 and 0 drive each other, and 3; 3 drives 1; 4 is alone.
        let edges = [(2, 0), (0, 2), (3, 0), (1, 3)];
        let depends: Vec<Vec<bool>> =
            (0..5).map(|i| (0..5).map(|j| edges.contains(&(i, j))).collect()).collect();
        let groups = driven_last(&depends);
        let place = |i: usize| groups.iter().position(|group| group.contains(&i)).unwrap();
        assert_eq!((groups.len(), &groups[place(0)]), (4, &vec![0, 2]));
        assert!(place(0) < place(3) && place(3) < place(1));
    }
}
