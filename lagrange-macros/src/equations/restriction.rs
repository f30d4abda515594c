//! Proof that a set of states is invariant: coordinates held at constants stay there, whatever the others do.
//!
//! With q_k = c and q̇_k = 0 for the coordinates k that are held, their equations of motion are
//!
//!   Σⱼ M_kj q̈ⱼ − right_k − Σᵢ λᵢ A_ik = 0
//!
//! with j the coordinates that are left. The set is invariant if they hold identically in it, in qⱼ, q̇ⱼ, t and the
//! parameters: for any accelerations and multipliers, or at least for the accelerations that the restricted system
//! has.

use super::Derived;
use super::check::sample;
use super::solve::entry;
use crate::diagnostics::Errors;
use crate::graph::{Graph, Symbol, Value};
use crate::model::submodel::{Change, Hold, Submodel};

/// Admitted difference of the two systems at a state of random numbers, in parts of the larger one.
const TOLERANCE: f64 = 1e-7;

/// Refuses a restriction whose set is not proved to be invariant.
pub fn check(whole: &Derived, restricted: &Derived, asked: &Submodel, errors: &mut Errors) {
    let mut r = Restriction::new(whole, restricted, asked.holds());
    for moved in &asked.moves {
        let Change::Hold(holds) = &moved.change else { continue };
        for hold in holds {
            if let Some(reason) = r.leaves(hold.index) {
                let label = whole.model.coordinates[hold.index].label();
                let message = format!(
                    "a motion does not stay where `{label}` is held: {reason}\nhelp: a restriction is exact, so hold values at which this vanishes, and hold with them what drives `{label}`"
                );
                errors.push(&moved.at, message);
            }
        }
    }
    if errors.is_empty() && !r.agrees() {
        let message = "the whole system, as it is written, has no value where these coordinates are held, or another one than what is left of it\nhelp: write it without a singularity there";
        errors.push(&asked.header.name, message);
    }
}

/// The labels of the coordinates of which {q = 0, q̇ = 0} is proved to be invariant, each alone.
pub fn invariant(d: &Derived) -> Vec<usize> {
    let all = 0..d.model.mechanical();
    all.filter(|&index| {
        let hold = Hold { index, value: Value::ZERO };
        let mut set = Set { d, g: d.graph.clone(), holds: vec![hold] };
        let rest = set.rest(index);
        let values: Vec<Value> =
            rest.accelerations.into_iter().chain(rest.constraints).chain([rest.force]).collect();
        values.into_iter().all(|v| v.k.is_finite() && set.g.vanishes(v))
    })
    .collect()
}

/// The states of a system in which coordinates are held.
struct Set<'d> {
    d: &'d Derived,
    g: Graph,
    holds: Vec<Hold>,
}

/// The equation of a coordinate that is held: factors of the accelerations and multipliers, and the rest.
struct Rest {
    accelerations: Vec<Value>,
    constraints: Vec<Value>,
    force: Value,
}

impl Set<'_> {
    /// Expressions in the set.
    fn at(&mut self, values: &[Value]) -> Vec<Value> {
        let Set { g, holds, .. } = self;
        let held = |i: usize| holds.iter().find(|hold| hold.index == i);
        g.substitute(values, |s| match s {
            Symbol::Coordinate(i) => held(i).map(|hold| hold.value),
            Symbol::Velocity(i) => held(i).map(|_| Value::ZERO),
            _ => None,
        })
    }

    fn rest(&mut self, k: usize) -> Rest {
        let e = &self.d.equations;
        let row: Vec<Value> = (0..self.d.model.coordinates.len())
            .filter(|j| self.holds.iter().all(|hold| hold.index != *j))
            .map(|j| entry(&e.solved.inertia, k, j))
            .collect();
        let constraints: Vec<Value> = e.formed.rows.jacobian.iter().map(|row| row[k]).collect();
        let force = e.solved.right[k];
        Rest { accelerations: self.at(&row), constraints: self.at(&constraints), force: self.at(&[force])[0] }
    }
}

struct Restriction<'d> {
    set: Set<'d>,
    restricted: &'d Derived,
    kept: Vec<usize>,
}

impl<'d> Restriction<'d> {
    fn new(whole: &'d Derived, restricted: &'d Derived, holds: Vec<Hold>) -> Self {
        let left = |i: &usize| holds.iter().all(|hold| hold.index != *i);
        let kept = (0..whole.model.coordinates.len()).filter(left).collect();
        Restriction { set: Set { d: whole, g: whole.graph.clone(), holds }, restricted, kept }
    }

    /// Reasons why motions drive a coordinate away from the value that it is held at.
    fn leaves(&mut self, k: usize) -> Option<String> {
        let Rest { accelerations, constraints, force } = self.set.rest(k);
        let (model, label) = (&self.set.d.model, self.set.d.model.coordinates[k].label());
        let mut reasons = Vec::new();
        for (constraint, slope) in model.constraints.iter().zip(constraints) {
            if !self.set.g.vanishes(slope) {
                reasons.push(format!("the constraint `{}` moves `{label}` there", constraint.label()));
            }
        }
        let coupled: Vec<usize> =
            (0..self.kept.len()).filter(|&j| !self.set.g.vanishes(accelerations[j])).collect();
        if coupled.is_empty() && self.set.g.vanishes(force) {
            return (!reasons.is_empty()).then(|| reasons.join(", "));
        }
        // On the accelerations that the rest has.
        if reasons.is_empty() && !self.restricted.is_redundant() {
            let kept = &self.kept;
            let accel = &self.restricted.equations.solved.accel;
            let accel = self.set.g.import(&self.restricted.graph, accel, |g, symbol| {
                g.symbol(match symbol {
                    Symbol::Coordinate(i) => Symbol::Coordinate(kept[i]),
                    Symbol::Velocity(i) => Symbol::Velocity(kept[i]),
                    other => other,
                })
            });
            let g = &mut self.set.g;
            let mut residual = -force;
            for (factor, accel) in accelerations.iter().zip(accel) {
                let term = g.mul(*factor, accel);
                residual = g.add(residual, term);
            }
            if g.vanishes(residual) {
                return None;
            }
        }
        let others = coupled.iter().map(|&j| {
            let other = model.coordinates[self.kept[j]].label();
            format!("the acceleration of `{other}` acts on it, as the inertia matrix couples the two")
        });
        reasons.extend(others);
        reasons.extend(self.forces(k));
        Some(reasons.join(", "))
    }

    /// The forces that act on a coordinate in the set.
    fn forces(&mut self, k: usize) -> Vec<String> {
        let Derived { model, equations: e, .. } = self.set.d;
        let label = model.coordinates[k].label();
        let (position, velocity) = (Symbol::Coordinate(k), Symbol::Velocity(k));
        let g = &mut self.set.g;
        let dissipation = g.gradient(e.formed.dissipation, &[velocity])[0];
        let applied = g.add(e.formed.nonconservative[k], dissipation);
        let potential = e.formed.energies.map(|[_, v]| g.gradient(v, &[position])[0]);
        // right = −∂V/∂q + Q − ∂D/∂q̇ + what the kinetic energy gives
        let known = g.sub(e.formed.nonconservative[k], potential.unwrap_or(Value::ZERO));
        let inertial = g.sub(e.solved.right[k], known);
        let inertial_text = match potential {
            Some(_) => {
                "the inertial forces of the other velocities, or of a given motion, do not vanish there"
                    .to_string()
            }
            None => format!("d/dt ∂L/∂q̇ − ∂L/∂q of `{label}` does not vanish there"),
        };
        let parts = [
            (
                potential.unwrap_or(Value::ZERO),
                format!("the potential energy acts on it (∂V/∂{label} does not vanish there)"),
            ),
            (inertial, inertial_text),
            (dissipation, format!("the dissipation acts on it (∂D/∂q̇ of `{label}` does not vanish there)")),
            (applied, "an applied force acts on it there".to_string()),
        ];
        let values: Vec<Value> = parts.iter().map(|part| part.0).collect();
        let values = self.set.at(&values);
        let g = &mut self.set.g;
        parts.into_iter().zip(values).filter(|(_, v)| !g.vanishes(*v)).map(|(part, _)| part.1).collect()
    }

    /// Have L and the accelerations of the two systems the same values in the set? At a state of random numbers: what
    /// is identical by proof may have no value as it is written.
    fn agrees(&self) -> bool {
        let (whole, small) = (self.set.d, self.restricted);
        let place = |i: usize| self.kept.iter().position(|k| *k == i);
        let held = |i: usize| self.set.holds.iter().find(|hold| hold.index == i);
        let number = |v: Value| whole.graph.evaluate(&[v], |s| sample(s, 0, 0))[0];
        let at = |s: Symbol| match s {
            Symbol::Coordinate(i) => match (place(i), held(i)) {
                (Some(k), _) => sample(Symbol::Coordinate(k), 0, 0),
                (None, hold) => hold.map_or(0.0, |hold| number(hold.value)),
            },
            Symbol::Velocity(i) => place(i).map_or(0.0, |k| sample(Symbol::Velocity(k), 0, 0)),
            other => sample(other, 0, 0),
        };
        let both = |large: &[Value], little: &[Value]| {
            let large = whole.graph.evaluate(large, at);
            let little = small.graph.evaluate(little, |s| sample(s, 0, 0));
            let size = large.iter().chain(&little).fold(1.0, |size: f64, x| size.max(x.abs()));
            large.iter().zip(&little).all(|(a, b)| (a - b).abs() <= TOLERANCE * size)
        };
        let (e, l) = (&whole.equations, &small.equations);
        let accel: Vec<Value> = self.kept.iter().map(|&i| e.solved.accel[i]).collect();
        both(&[e.formed.lagrangian], &[l.formed.lagrangian])
            && (whole.is_redundant() || small.is_redundant() || both(&accel, &l.solved.accel))
    }
}
