//! What frames add to the equations at the bindings.
//!
//! For velocities ω, v of a frame in its own axes, and virtual displacements δθ, δξ in the same axes, variation and time
//! derivative do not commute:
//!
//!   δω = δθ̇ + ω × δθ,   δv = δξ̇ + ω × δξ + v × δθ,
//!
//! so that with the momenta p_ω = ∂L/∂ω and p_v = ∂L/∂v Lagrange's equations become those of Euler and Poincaré (Poincaré
//! 1901; Marsden and Ratiu, *Introduction to Mechanics and Symmetry*, 2nd ed. 1999, 13.5; for SE(3) Kirchhoff's
//! equations, 1870):
//!
//!   e_ω = … − ω × p_ω − v × p_v,   e_v = … − ω × p_v.
//!
//! All else is as for any binding: tangents are the derivatives ∂ψ/∂ẋ of the velocity ψ by earlier rates, which are those
//! of virtual displacements by earlier ones, γ is ψ̇ at rest of the accelerations, and L may depend on places and axes,
//! whose rates ṗ = R v and Ṙ = R [ω]× carry forces to v and ω. For any point of any frame, so for all of them at once.
//!
//! The unknown of a point is not v̇ but its acceleration a = v̇ + ω × v less a uniform field of gravity. That is a change
//! of unknowns ã = ẍ + G, with e + H G for e, and leaves M and the right-hand side what they are. It removes ω × p_v of
//! a mass, the transport of every a from frame to frame, and gravity at each mass, which then accelerates the first
//! points instead (Luh, Walker and Paul 1980; Featherstone, *Rigid Body Dynamics Algorithms*, 2008, 5.3).

use crate::graph::{Graph, Symbol, Value};
use crate::model::frames::{Frames, Point, Vector, cross, plus};

type Row = Vec<(usize, Value)>;

/// Momenta ∂L/∂ẋ, forces ∂L/∂x and ∂²L/∂ẋ² at all positions.
pub struct Slopes<'a> {
    pub momenta: &'a [Value],
    pub forces: &'a [Value],
    pub hessian: &'a [Row],
}

/// Adds what belongs to frames to e, and the uniform field to γ.
pub fn carried(g: &mut Graph, frames: &Frames, l: &Slopes, e: &mut [Value], gamma: &mut [Value]) {
    for spin in &frames.spins {
        let omega = spin.map(|k| k.map_or(Value::ZERO, |k| g.symbol(Symbol::Rate(k))));
        let momentum = spin.map(|k| k.map_or(Value::ZERO, |k| l.momenta[k]));
        let turning = cross(g, &omega, &momentum);
        for (k, turning) in spin.iter().zip(turning) {
            if let Some(k) = *k {
                e[k] = g.sub(e[k], turning);
            }
        }
    }
    for point in &frames.points {
        transported(g, frames, point, l, e);
    }
    if let Some(field) = field(g, frames, l) {
        for point in &frames.points {
            falling(g, point, &field, l, e, gamma);
        }
    }
}

/// e_v −= ω × p, e_ω −= v × p, and e += H (ω × v).
fn transported(g: &mut Graph, frames: &Frames, point: &Point, l: &Slopes, e: &mut [Value]) {
    let Some(spin) = point.spin else { return };
    let spin = frames.spins[spin];
    let omega = spin.map(|k| k.map_or(Value::ZERO, |k| g.symbol(Symbol::Rate(k))));
    let v = point.velocity.map(|k| g.symbol(Symbol::Rate(k)));
    let mut p = point.velocity.map(|k| l.momenta[k]);
    let torque = cross(g, &v, &p);
    for (k, torque) in spin.iter().zip(torque) {
        if let Some(k) = *k {
            e[k] = g.sub(e[k], torque);
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
        e[k] = g.sub(e[k], turning);
    }
    shifted(g, point, l, &transport, mass.is_some(), e);
}

/// e += H G for the G of this point; but for its own components, if `apart`.
fn shifted(g: &mut Graph, point: &Point, l: &Slopes, shift: &Vector, apart: bool, e: &mut [Value]) {
    for (&k, shift) in point.velocity.iter().zip(shift) {
        for &(j, h) in &l.hessian[k] {
            if !(apart && point.velocity.contains(&j)) {
                let term = g.mul(h, *shift);
                e[j] = g.add(e[j], term);
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

/// Does T depend on the velocity of this point beside those of others?
fn coupled(point: &Point, l: &Slopes) -> bool {
    point.velocity.iter().any(|&k| l.hessian[k].iter().any(|h| !point.velocity.contains(&h.0)))
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
        let massless = point.velocity.iter().all(|&k| l.hessian[k].is_empty());
        let apart = mass(point, l).is_some() && !coupled(point, l);
        let placed = apart && used.iter().all(|&i| point.place[i].is_some());
        !point.first && (massless || placed) || used.iter().all(|&i| point.axes[i].is_some())
    });
    known.then_some(field)
}

fn constant(g: &Graph, v: Value) -> bool {
    v.node.is_none_or(|n| g.is_fixed(n))
}

/// Counts the accelerations of a point from those of free fall.
fn falling(g: &mut Graph, point: &Point, field: &Vector, l: &Slopes, e: &mut [Value], gamma: &mut [Value]) {
    let mut own = [Value::ZERO; 3];
    for i in 0..3 {
        if let Some(axes) = point.axes[i] {
            let part = axes.map(|r| g.mul(r, -field[i]));
            own = plus(g, &own, &part);
        }
    }
    if point.first {
        for (&k, own) in point.velocity.iter().zip(own) {
            gamma[k] = g.add(gamma[k], own);
        }
    }
    let mass = mass(point, l);
    for i in 0..3 {
        let Some(mass) = mass.filter(|_| !field[i].is_zero()) else { continue };
        let weight = g.mul(mass, field[i]);
        match (point.place[i], point.axes[i]) {
            // Where the weight itself stands.
            (Some(k), _) => e[k] = g.sub(e[k], weight),
            (None, Some(axes)) => {
                for (&k, r) in point.velocity.iter().zip(axes) {
                    let part = g.mul(weight, r);
                    e[k] = g.sub(e[k], part);
                }
            }
            (None, None) => {}
        }
    }
    shifted(g, point, l, &own, mass.is_some(), e);
}
