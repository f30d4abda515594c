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
//!
//! The velocities of frames in space are bindings as well, without values (`model/frames.rs`, and
//! `assemble/frames.rs` for what they add to e and γ).

mod frames;

use super::common::frictions;
use super::solve::Symmetric;
use crate::graph::{Graph, Symbol, Value};
use crate::model::Model;
use crate::model::attitude::Parameters;
use crate::model::frames::{Frames, Motion};

/// A system for the pull-back: some bindings, and energies and forces in terms of them.
pub struct Form {
    pub coordinates: usize,
    /// Number of coordinates before those of the states.
    pub mechanical: usize,
    /// φ and φ̇ of each binding, in terms of earlier ones.
    pub bindings: Vec<[Value; 2]>,
    pub motions: Vec<Motion>,
    /// Attitudes by their first coordinates and the bindings that are their angular velocities.
    pub attitudes: Vec<(usize, [usize; 3])>,
    pub frames: Frames,
    pub lagrangian: Value,
    pub dissipation: Value,
    /// A force and the position that it moves.
    pub forces: Vec<(Value, Value)>,
    /// A force and the velocity that it does work with.
    pub frame_forces: Vec<(Value, Value)>,
    pub applied: Vec<Value>,
    /// Expressions that vanish, and whether they are relations between velocities.
    pub constraints: Vec<(Value, bool)>,
}

impl Form {
    /// A model as it was written, without its constraints.
    pub fn of(model: &Model) -> Form {
        Form {
            coordinates: model.coordinates.len(),
            mechanical: model.mechanical(),
            bindings: model.bindings.iter().map(|b| [b.value, b.rate]).collect(),
            motions: model.bindings.iter().map(|b| b.motion).collect(),
            attitudes: model.attitudes.iter().filter_map(|a| Some((a.first, a.spin?))).collect(),
            frames: model.frames.clone(),
            lagrangian: model.lagrangian,
            dissipation: model.dissipation,
            forces: model.forces.clone(),
            frame_forces: model.frame_forces.clone(),
            applied: model.applied.clone(),
            constraints: Vec::new(),
        }
    }

    /// The same in terms of q, q̇ and t alone.
    pub fn expanded(&self, g: &mut Graph, flat: &[[Value; 2]]) -> Form {
        let pairs = |g: &mut Graph, pairs: &[(Value, Value)]| -> Vec<(Value, Value)> {
            let both = pairs.iter().map(|&(force, x)| flattened(g, flat, &[force, x]));
            both.map(|pair| (pair[0], pair[1])).collect()
        };
        Form {
            coordinates: self.coordinates,
            mechanical: self.mechanical,
            bindings: Vec::new(),
            motions: Vec::new(),
            attitudes: Vec::new(),
            frames: Frames::default(),
            lagrangian: flattened(g, flat, &[self.lagrangian])[0],
            dissipation: flattened(g, flat, &[self.dissipation])[0],
            applied: flattened(g, flat, &self.applied),
            forces: pairs(g, &self.forces),
            frame_forces: pairs(g, &self.frame_forces),
            constraints: Vec::new(),
        }
    }
}

/// Adds to each generalized force the part Σ force · ∂x/∂by of forces and what they move.
pub fn exert(g: &mut Graph, forces: &[(Value, Value)], by: &[Symbol], on: &mut [Value]) {
    for (force, x) in forces {
        for (on, moved) in on.iter_mut().zip(g.gradient(*x, by)) {
            let work = g.mul(*force, moved);
            *on = g.add(*on, work);
        }
    }
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
pub fn pulled_back(g: &mut Graph, at: &Unreduced) -> (Symmetric, Vec<Value>) {
    let n = at.coordinates;
    let gamma = at.forward(g, &vec![Value::ZERO; n], true);
    let rest = at.rest(g, &at.e, &gamma);
    let right = at.reverse(g, rest, &[]).split_off(at.bound);
    let mut inertia: Symmetric = (0..n).map(|i| vec![Value::ZERO; i + 1]).collect();
    for j in 0..n {
        let unit: Vec<Value> = (0..n).map(|i| if i == j { Value::ONE } else { Value::ZERO }).collect();
        let moved = at.forward(g, &unit, false);
        let weighted = at.weighted(g, &moved);
        for (i, value) in at.reverse(g, weighted, &[]).split_off(at.bound).into_iter().enumerate().skip(j) {
            inertia[i][j] = value;
        }
    }
    (inertia, right)
}

/// The generalized forces that make bindings move as they do although they are taken for coordinates: by the equation
/// of each relaxed coordinate, R = d/dt ∂L/∂u̇ − ∂L/∂u + ∂D/∂u̇ − F − Aᵀλ (Beatty 2006, 11.7.2). `multipliers` and
/// `qdd` are λ and q̈ in terms of q, q̇ and t.
pub fn reactions(
    g: &mut Graph,
    at: &Unreduced,
    relaxed: &[usize],
    multipliers: &[Value],
    qdd: &[Value],
) -> Vec<Value> {
    let mut e = at.e.clone();
    for (row, multiplier) in at.rows.iter().zip(multipliers) {
        for &(k, slope) in row {
            let force = g.mul(*multiplier, slope);
            e[k] = g.add(e[k], force);
        }
    }
    let moved = at.forward(g, qdd, true);
    let rest = at.rest(g, &e, &moved);
    let all = at.reverse(g, rest, relaxed);
    relaxed.iter().map(|&k| -all[k]).collect()
}

/// An entry of a sparse row: its column and its value.
pub type Entry = (usize, Value);

/// The equations at the positions x = (u, q) before they are pulled back, in terms of q, q̇ and t:
/// the forces at x less what inertia takes, e − H ẍ, with ü = S ẍ + γ.
pub struct Unreduced {
    pub bound: usize,
    pub coordinates: usize,
    pub e: Vec<Value>,
    pub gamma: Vec<Value>,
    /// H by rows.
    pub hessian: Vec<Vec<Entry>>,
    /// S by rows: of a binding ∂φ/∂x, of the velocity of a frame its derivatives by earlier rates.
    pub tangents: Vec<Vec<Entry>>,
    /// A by rows, of constraints A ẍ + drift = 0.
    pub rows: Vec<Vec<Entry>>,
    pub drift: Vec<Value>,
    pub attitudes: Vec<Attitude>,
}

/// An attitude, where nothing but ω depends on σ̇ (`model/attitude.rs`).
#[derive(Clone)]
pub struct Attitude {
    /// The first of its coordinates.
    pub first: usize,
    /// The bindings that are its angular velocity.
    pub spin: [usize; 3],
    pub at: Parameters,
}

/// The equations with values and rates of the bindings as they are given.
pub fn unreduced(g: &mut Graph, form: &Form, flat: &[[Value; 2]]) -> Unreduced {
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
    let mut gradient = g.gradient(form.lagrangian, &all);
    for (i, p) in gradient[..size].iter_mut().enumerate().skip(bound + form.mechanical) {
        *p = rates[i];
    }
    let (momenta, slopes) = gradient.split_at(size);
    let drift = g.forward(momenta, in_time);
    let friction = frictions(g, form.dissipation, &velocities, bound + form.mechanical);
    let mut e: Vec<Value> = (0..size)
        .map(|i| {
            let rest = g.sub(slopes[i], drift[i]);
            g.sub(rest, friction[i])
        })
        .collect();
    exert(g, &form.forces, &positions, &mut e);
    exert(g, &form.frame_forces, &velocities, &mut e);
    for (e, applied) in e[bound..].iter_mut().zip(&form.applied) {
        *e = g.add(*e, *applied);
    }
    let hessian: Vec<Vec<Entry>> = momenta.iter().map(|p| sparse(&g.gradient(*p, &velocities))).collect();
    let mut tangents: Vec<Vec<Entry>> = Vec::new();
    for ([phi, rate], motion) in form.bindings.iter().zip(&form.motions) {
        tangents.push(sparse(&match motion {
            Motion::Position => g.gradient(*phi, &positions),
            Motion::Carried | Motion::Turning(_) | Motion::Quasi(_) => g.gradient(*rate, &velocities),
        }));
    }
    let rates_of: Vec<Value> = form.bindings.iter().map(|b| b[1]).collect();
    let mut gamma = g.forward(&rates_of, in_time);
    for (gamma, motion) in gamma.iter_mut().zip(&form.motions) {
        if let Motion::Quasi(known) | Motion::Turning(known) = motion {
            *gamma = *known;
        }
    }
    let (mut rows, mut restricted) = (Vec::new(), Vec::new());
    for &(value, on_velocities) in &form.constraints {
        let by = if on_velocities { &velocities } else { &positions };
        rows.push(sparse(&g.gradient(value, by)));
        restricted.push(if on_velocities { value } else { g.forward(&[value], in_time)[0] });
    }
    let mut drift = g.forward(&restricted, in_time);
    let l = frames::Slopes { momenta, forces: slopes, hessian: &hessian, rows: &rows };
    frames::carried(
        g,
        &form.frames,
        &l,
        frames::RightHandSides { e: &mut e, gamma: &mut gamma, drift: &mut drift },
    );

    let attitudes = form.attitudes.iter().map(|&(first, spin)| {
        let sigma = [0, 1, 2].map(|k| g.symbol(Symbol::Coordinate(first + k)));
        Attitude { first, spin, at: Parameters::new(g, sigma) }
    });
    let attitudes = attitudes.collect();

    // From here on without bindings.
    Unreduced {
        bound,
        coordinates: n,
        e: flattened(g, flat, &e),
        gamma: flattened(g, flat, &gamma),
        hessian: hessian.iter().map(|row| flat_row(g, flat, row)).collect(),
        tangents: tangents.iter().map(|row| flat_row(g, flat, row)).collect(),
        rows: rows.iter().map(|row| flat_row(g, flat, row)).collect(),
        drift: flattened(g, flat, &drift),
        attitudes,
    }
}

fn sparse(row: &[Value]) -> Vec<Entry> {
    row.iter().copied().enumerate().filter(|(_, v)| !v.is_zero()).collect()
}

fn flat_row(g: &mut Graph, flat: &[[Value; 2]], row: &[Entry]) -> Vec<Entry> {
    let values: Vec<Value> = row.iter().map(|r| r.1).collect();
    let values = flattened(g, flat, &values);
    row.iter().map(|r| r.0).zip(values).filter(|(_, v)| !v.is_zero()).collect()
}

/// Σ entry · x.
fn applied(g: &mut Graph, row: &[Entry], x: &[Value]) -> Value {
    row.iter().fold(Value::ZERO, |sum, &(j, entry)| {
        let term = g.mul(entry, x[j]);
        g.add(sum, term)
    })
}

impl Unreduced {
    /// J q̈, or J q̈ + γ: accelerations of the bindings, then of the coordinates.
    fn forward(&self, g: &mut Graph, qdd: &[Value], with_gamma: bool) -> Vec<Value> {
        let mut a: Vec<Value> = vec![Value::ZERO; self.bound];
        a.extend(qdd);
        for k in 0..self.bound {
            let sum = applied(g, &self.tangents[k], &a);
            a[k] = if with_gamma { g.add(sum, self.gamma[k]) } else { sum };
        }
        a
    }

    /// Jᵀ f, below what acts at the bindings on the way. Bindings in `relaxed` keep what acts at them.
    fn reverse(&self, g: &mut Graph, mut f: Vec<Value>, relaxed: &[usize]) -> Vec<Value> {
        for k in (0..self.bound).rev().filter(|k| !relaxed.contains(k)) {
            for &(i, partial) in &self.tangents[k] {
                let term = g.mul(partial, f[k]);
                f[i] = g.add(f[i], term);
            }
        }
        f
    }

    /// e − H a.
    fn rest(&self, g: &mut Graph, e: &[Value], a: &[Value]) -> Vec<Value> {
        let inertial = self.weighted(g, a);
        e.iter().zip(inertial).map(|(e, i)| g.sub(*e, i)).collect()
    }

    /// H a.
    fn weighted(&self, g: &mut Graph, a: &[Value]) -> Vec<Value> {
        self.hessian.iter().map(|row| applied(g, row, a)).collect()
    }
}
