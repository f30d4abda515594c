//! M q̈ = right, formed where the system was written and pulled back to the coordinates.
//!
//! Let u = φ(q, t) be the bindings, x = (u, q) all positions, and L(x, ẋ, t). The Euler–Lagrange operator commutes with
//! point transformations (Arnold, *Mathematical Methods of Classical Mechanics*, 2nd ed. 1989, §12.D), so with
//! J = ∂x/∂q:  Jᵀ [ ∂L/∂x − d/dt ∂L/∂ẋ − ∂D/∂ẋ + F ] + Q = 0. With H = ∂²L/∂ẋ² and ẍ = J q̈ + γ this is
//!
//!   M = Jᵀ H J,   right = Jᵀ (e − H γ) + Q,   e = ∂L/∂x − (d/dt ∂L/∂ẋ)|_{ẍ=0} − ∂D/∂ẋ + F.
//!
//! J is never formed: a forward sweep over the bindings applies it, a reverse sweep its transpose, so the cost grows
//! with what was written.

use super::solve::Symmetric;
use crate::graph::{Graph, Symbol, Value};

/// A system for the pull-back: some bindings, and energies and forces in terms of them.
pub struct Form {
    pub coordinates: usize,
    /// φ and φ̇ of each binding, in terms of earlier ones.
    pub bindings: Vec<[Value; 2]>,
    pub lagrangian: Value,
    pub dissipation: Value,
    /// A force and the position that it moves.
    pub forces: Vec<(Value, Value)>,
    pub applied: Vec<Value>,
}

/// Values of the bindings and their rates in terms of q, q̇ and t.
pub fn flatten(g: &mut Graph, bindings: &[[Value; 2]]) -> Vec<[Value; 2]> {
    let mut flat: Vec<[Value; 2]> = Vec::new();
    for pair in bindings {
        let values = flattened(g, &flat, pair);
        flat.push([values[0], values[1]]);
    }
    flat
}

/// Expressions with their bindings replaced by these.
pub fn flattened(g: &mut Graph, flat: &[[Value; 2]], values: &[Value]) -> Vec<Value> {
    g.substitute(values, |symbol| match symbol {
        Symbol::Binding(k) => flat.get(k).map(|b| b[0]),
        Symbol::Rate(k) => flat.get(k).map(|b| b[1]),
        _ => None,
    })
}

/// M and right, in terms of q, q̇ and t.
pub fn pulled_back(g: &mut Graph, form: &Form) -> (Symmetric, Vec<Value>) {
    let (bound, n) = (form.bindings.len(), form.coordinates);
    let positions: Vec<Symbol> =
        (0..bound).map(Symbol::Binding).chain((0..n).map(Symbol::Coordinate)).collect();
    let velocities: Vec<Symbol> = (0..bound).map(Symbol::Rate).chain((0..n).map(Symbol::Velocity)).collect();
    let size = positions.len();
    let rates: Vec<Value> = velocities.iter().map(|v| g.symbol(*v)).collect();
    let in_time = |symbol: Symbol| match symbol {
        Symbol::Binding(k) => Some(rates[k]),
        Symbol::Coordinate(i) => Some(rates[bound + i]),
        Symbol::Time => Some(Value::ONE),
        _ => None,
    };

    // ∂L/∂ẋ and ∂L/∂x in one sweep.
    let all: Vec<Symbol> = velocities.iter().chain(&positions).copied().collect();
    let gradient = g.gradient(form.lagrangian, &all);
    let (momenta, slopes) = gradient.split_at(size);
    let drift = g.forward(momenta, in_time);
    let friction = g.gradient(form.dissipation, &velocities);
    let mut e: Vec<Value> = (0..size)
        .map(|i| {
            let rest = g.sub(slopes[i], drift[i]);
            g.sub(rest, friction[i])
        })
        .collect();
    for (force, position) in &form.forces {
        let moved = g.gradient(*position, &positions);
        for (e, moved) in e.iter_mut().zip(moved) {
            let work = g.mul(*force, moved);
            *e = g.add(*e, work);
        }
    }
    // H by rows, ∂φ/∂x by rows, γ.
    let hessian: Vec<Vec<(usize, Value)>> =
        momenta.iter().map(|p| sparse(&g.gradient(*p, &velocities))).collect();
    let tangents: Vec<Vec<(usize, Value)>> =
        form.bindings.iter().map(|[phi, _]| sparse(&g.gradient(*phi, &positions))).collect();
    let rates_of: Vec<Value> = form.bindings.iter().map(|b| b[1]).collect();
    let gamma = g.forward(&rates_of, in_time);

    // From here on in terms of q and q̇ alone.
    let flat = flatten(g, &form.bindings);
    let e = flattened(g, &flat, &e);
    let gamma = flattened(g, &flat, &gamma);
    let mut sweep = Sweep {
        hessian: hessian.iter().map(|row| flat_row(g, &flat, row)).collect(),
        tangents: tangents.iter().map(|row| flat_row(g, &flat, row)).collect(),
        bound,
        g,
    };

    let gamma = sweep.forward(&vec![Value::ZERO; n], Some(&gamma));
    let inertial = sweep.weighted(&gamma);
    let unbalanced = e.iter().zip(inertial).map(|(e, i)| sweep.g.sub(*e, i)).collect();
    let mut right = sweep.reverse(unbalanced);
    for (right, applied) in right.iter_mut().zip(&form.applied) {
        let applied = flattened(sweep.g, &flat, &[*applied])[0];
        *right = sweep.g.add(*right, applied);
    }
    let mut inertia: Symmetric = (0..n).map(|i| vec![Value::ZERO; i + 1]).collect();
    for j in 0..n {
        let unit: Vec<Value> = (0..n).map(|i| if i == j { Value::ONE } else { Value::ZERO }).collect();
        let moved = sweep.forward(&unit, None);
        let weighted = sweep.weighted(&moved);
        for (i, value) in sweep.reverse(weighted).into_iter().enumerate().skip(j) {
            inertia[i][j] = value;
        }
    }
    (inertia, right)
}

fn sparse(row: &[Value]) -> Vec<(usize, Value)> {
    row.iter().copied().enumerate().filter(|(_, v)| !v.is_zero()).collect()
}

fn flat_row(g: &mut Graph, flat: &[[Value; 2]], row: &[(usize, Value)]) -> Vec<(usize, Value)> {
    let values: Vec<Value> = row.iter().map(|r| r.1).collect();
    let values = flattened(g, flat, &values);
    row.iter().map(|r| r.0).zip(values).filter(|(_, v)| !v.is_zero()).collect()
}

struct Sweep<'g> {
    g: &'g mut Graph,
    hessian: Vec<Vec<(usize, Value)>>,
    tangents: Vec<Vec<(usize, Value)>>,
    bound: usize,
}

impl Sweep<'_> {
    /// J q̈ + γ: accelerations of the bindings, then of the coordinates.
    fn forward(&mut self, qdd: &[Value], gamma: Option<&[Value]>) -> Vec<Value> {
        let mut a: Vec<Value> = vec![Value::ZERO; self.bound];
        a.extend(qdd);
        for k in 0..self.bound {
            let mut sum = Value::ZERO;
            for &(i, partial) in &self.tangents[k] {
                let term = self.g.mul(partial, a[i]);
                sum = self.g.add(sum, term);
            }
            a[k] = self.g.add(sum, gamma.map_or(Value::ZERO, |gamma| gamma[k]));
        }
        a
    }

    /// Jᵀ f.
    fn reverse(&mut self, mut f: Vec<Value>) -> Vec<Value> {
        for k in (0..self.bound).rev() {
            for &(i, partial) in &self.tangents[k] {
                let term = self.g.mul(partial, f[k]);
                f[i] = self.g.add(f[i], term);
            }
        }
        f.split_off(self.bound)
    }

    /// H a.
    fn weighted(&mut self, a: &[Value]) -> Vec<Value> {
        let rows = self.hessian.iter().map(|row| {
            row.iter().fold(Value::ZERO, |sum, &(j, h)| {
                let term = self.g.mul(h, a[j]);
                self.g.add(sum, term)
            })
        });
        rows.collect()
    }
}
