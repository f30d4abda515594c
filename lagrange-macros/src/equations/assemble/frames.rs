//! Terms that frames add to the equations at the bindings.
//!
//! For velocities ω, v of a frame in its own axes, and virtual displacements δθ, δξ in the same axes, variation and
//! time derivative do not commute:
//!
//!   δω = δθ̇ + ω × δθ,   δv = δξ̇ + ω × δξ + v × δθ,
//!
//! so that with the momenta p_ω = ∂L/∂ω and p_v = ∂L/∂v Lagrange's equations become those of Euler and Poincaré
//! (Poincaré 1901; Marsden and Ratiu, *Introduction to Mechanics and Symmetry*, 2nd ed. 1999, 13.5; for SE(3)
//! Kirchhoff's equations, 1870):
//!
//!   e_ω = … − ω × p_ω − v × p_v,   e_v = … − ω × p_v.
//!
//! All else is as for any binding: tangents are the derivatives ∂ψ/∂ẋ of the velocity ψ by earlier rates, which are
//! those of virtual displacements by earlier ones, γ is ψ̇ at rest of the accelerations, and L may depend on places
//! and axes, whose rates ṗ = R v and Ṙ = R [ω]× carry forces to v and ω. For any point of any frame, so for all of
//! them at once.
//!
//! The unknown of a point is not v̇ but its acceleration a = v̇ + ω × v less a uniform field of gravity. That is a
//! change of unknowns ã = ẍ + G, with e + H G for e and A ã + drift − A G = 0 for constraints, and leaves M and the
//! right-hand side what they are. It removes ω × p_v of a mass, the transport of every a from frame to frame, and
//! gravity at each mass, which then accelerates the first points instead (Luh, Walker and Paul 1980;
//! Featherstone, *Rigid Body Dynamics Algorithms*, 2008, 5.3).

use super::Entry;
use crate::graph::{Graph, Symbol, Value};
use crate::model::frames::{Frames, Point, Vector, cross, plus};

/// Momenta ∂L/∂ẋ, forces ∂L/∂x and ∂²L/∂ẋ² at all positions, and constraints by rows.
pub struct Slopes<'a> {
    pub momenta: &'a [Value],
    pub forces: &'a [Value],
    pub hessian: &'a [Vec<Entry>],
    pub rows: &'a [Vec<Entry>],
}

/// Right-hand sides that frames change.
pub struct RightHandSides<'a> {
    pub e: &'a mut [Value],
    pub gamma: &'a mut [Value],
    pub drift: &'a mut [Value],
}

impl RightHandSides<'_> {
    fn exert(&mut self, g: &mut Graph, at: usize, force: Value) {
        self.e[at] = g.add(self.e[at], force);
    }
}

/// Adds the terms of Euler and Poincaré, and changes the unknowns to accelerations as they are felt.
pub fn carried(g: &mut Graph, frames: &Frames, l: &Slopes, mut sides: RightHandSides) {
    for spin in &frames.spins {
        let omega = rates(g, spin);
        let momentum = spin.map(|k| k.map_or(Value::ZERO, |k| l.momenta[k]));
        let turning = cross(g, &omega, &momentum);
        for (k, turning) in spin.iter().zip(turning) {
            if let Some(k) = *k {
                sides.exert(g, k, -turning);
            }
        }
    }
    for point in &frames.points {
        transported(g, frames, point, l, &mut sides);
    }
    if let Some(field) = field(g, frames, l) {
        for point in &frames.points {
            falling(g, point, &field, l, &mut sides);
        }
    }
}

fn rates(g: &mut Graph, of: &[Option<usize>; 3]) -> Vector {
    of.map(|k| k.map_or(Value::ZERO, |k| g.symbol(Symbol::Rate(k))))
}

/// e_v −= ω × p and e_ω −= v × p, and G = ω × v.
fn transported(g: &mut Graph, frames: &Frames, point: &Point, l: &Slopes, sides: &mut RightHandSides) {
    // The rate ṗ = R v has the acceleration R (v̇ + ω × v) without any drift.
    for k in point.place.into_iter().flatten() {
        sides.gamma[k] = Value::ZERO;
    }
    let Some(spin) = point.spin else { return };
    let spin = frames.spins[spin];
    let omega = rates(g, &spin);
    let v = rates(g, &point.velocity.map(Some));
    let mut p = point.velocity.map(|k| l.momenta[k]);
    let torque = cross(g, &v, &p);
    for (k, torque) in spin.iter().zip(torque) {
        if let Some(k) = *k {
            sides.exert(g, k, -torque);
        }
    }
    let transport = cross(g, &omega, &v);
    let mass = mass(point, l);
    if let Some(mass) = mass {
        // ω × p − m ω × v, which vanishes for a mass and nothing else.
        let own = v.map(|v| g.mul(mass, -v));
        p = plus(g, &p, &own);
    }
    let turning = cross(g, &omega, &p);
    for (&k, turning) in point.velocity.iter().zip(turning) {
        sides.exert(g, k, -turning);
    }
    shifted(g, point, l, &transport, mass.is_some(), sides);
}

/// e += H G and drift −= A G for the G of this point; but for H of its own components, if `apart`.
fn shifted(
    g: &mut Graph,
    point: &Point,
    l: &Slopes,
    shift: &Vector,
    apart: bool,
    sides: &mut RightHandSides,
) {
    for (&k, shift) in point.velocity.iter().zip(shift) {
        for &(j, h) in &l.hessian[k] {
            if !(apart && point.velocity.contains(&j)) {
                let term = g.mul(h, *shift);
                sides.exert(g, j, term);
            }
        }
        for (drift, row) in sides.drift.iter_mut().zip(l.rows) {
            for &(_, a) in row.iter().filter(|entry| entry.0 == k) {
                let term = g.mul(a, *shift);
                *drift = g.sub(*drift, term);
            }
        }
    }
}

/// m, if T is ½ m v² in the velocity of this point, but for couplings with others.
fn mass(point: &Point, l: &Slopes) -> Option<Value> {
    let entry = |i: usize, j: usize| {
        let found = l.hessian[point.velocity[i]].iter().find(|h| h.0 == point.velocity[j]);
        found.map_or(Value::ZERO, |h| h.1)
    };
    let mass = entry(0, 0);
    let scalar = (0..3).all(|i| (0..3).all(|j| entry(i, j) == if i == j { mass } else { Value::ZERO }));
    scalar.then_some(mass)
}

/// Is the velocity of this point coupled to others, by T or by a constraint?
fn coupled(point: &Point, l: &Slopes) -> bool {
    let restricted = l.rows.iter().flatten().any(|entry| point.velocity.contains(&entry.0));
    let beside = |k: &usize| l.hessian[*k].iter().any(|h| !point.velocity.contains(&h.0));
    restricted || point.velocity.iter().any(beside)
}

/// The acceleration that gravity gives to most masses, if it is uniform and known in the axes of all that need it.
fn field(g: &mut Graph, frames: &Frames, l: &Slopes) -> Option<Vector> {
    let mut found: Vec<(Vector, usize)> = Vec::new();
    for point in &frames.points {
        let Some(mass) = mass(point, l).filter(|m| !m.is_zero() && constant(g, *m)) else { continue };
        let force = point.place.map(|k| k.map_or(Value::ZERO, |k| l.forces[k]));
        if force.iter().all(|f| f.is_zero()) || !force.iter().all(|f| constant(g, *f)) {
            continue;
        }
        let field = force.map(|f| g.quotient(f, mass));
        match found.iter_mut().find(|(other, _)| *other == field) {
            Some((_, count)) => *count += 1,
            None => found.push((field, 1)),
        }
    }
    let field = found.iter().rev().max_by_key(|(_, count)| *count)?.0;
    let used: Vec<usize> = (0..3).filter(|&i| !field[i].is_zero()).collect();
    let known = frames.points.iter().all(|point| {
        let mass = mass(point, l).filter(|_| !coupled(point, l));
        let placed = used.iter().all(|&i| point.place[i].is_some());
        let without = mass.is_some_and(|mass| mass.is_zero() || placed) && !point.first;
        without || used.iter().all(|&i| point.axes[i].is_some())
    });
    known.then_some(field)
}

fn constant(g: &Graph, v: Value) -> bool {
    v.node.is_none_or(|n| g.is_fixed(n))
}

/// G = −Rᵀ field, so that the accelerations of a point are counted from those of free fall.
fn falling(g: &mut Graph, point: &Point, field: &Vector, l: &Slopes, sides: &mut RightHandSides) {
    let mut own = [Value::ZERO; 3];
    for i in 0..3 {
        if let Some(axes) = point.axes[i] {
            let part = axes.map(|r| g.mul(r, -field[i]));
            own = plus(g, &own, &part);
        }
    }
    if point.first {
        for (&k, own) in point.velocity.iter().zip(own) {
            sides.gamma[k] = g.add(sides.gamma[k], own);
        }
    }
    let mass = mass(point, l);
    for i in 0..3 {
        if let Some(k) = point.place[i] {
            // The acceleration R (ã + Rᵀ field) of its place is what it was.
            sides.gamma[k] = g.add(sides.gamma[k], field[i]);
        }
        let Some(mass) = mass.filter(|_| !field[i].is_zero()) else { continue };
        let weight = g.mul(mass, field[i]);
        match (point.place[i], point.axes[i]) {
            // Where the weight itself stands.
            (Some(k), _) => sides.exert(g, k, -weight),
            (None, Some(axes)) => {
                for (&k, r) in point.velocity.iter().zip(axes) {
                    let part = g.mul(weight, r);
                    sides.exert(g, k, -part);
                }
            }
            (None, None) => {}
        }
    }
    shifted(g, point, l, &own, mass.is_some(), sides);
}
