//! Routh's reduction: the system of the coordinates that are not ignorable, as a model of its own.
//!
//! Let the momenta `pᵢ = ∂L/∂q̇ᵢ` of the ignorable coordinates be constant. L is quadratic in their velocities u,
//! `L = L₀ + c·u + ½ u·A u`, where L₀ and c are L and ∂L/∂u at u = 0, so `u = A⁻¹ (p − c)`, and the Routhian
//!
//!   R(qᵣ, q̇ᵣ, t; p) = L − p·u = L₀ − ½ (p − c)·A⁻¹ (p − c)
//!
//! gives the equations of the others as any Lagrangian does (Routh, *Stability of a Given State of Motion*, 1877; Landau
//! and Lifshitz, *Mechanics*, §41). u is never put into L itself, which gives wrong equations. No value depends on an
//! ignorable coordinate, which is proved, so each is written as 0; and the bindings stay bindings, at u = 0, where L₀ is
//! formed.

use super::Equations;
use super::structure::independent;
use crate::diagnostics::Errors;
use crate::graph::{Graph, Number, Symbol, Value};
use crate::model::{Binding, Coordinate, Model, Observed, Parameter, Places, Reduction, Removed};
use crate::schedule::count::operations;
use crate::syntax::Header;
use proc_macro2::Ident;

/// The reduced system, where one is asked for.
pub fn routhian(e: &Equations, errors: &mut Errors) -> Option<Model> {
    let header = e.model.routhian.as_ref()?;
    check(e, header, errors)?;
    let parameters = parameters(e, header, errors)?;
    let whole = &e.model;
    let ignorable = &e.facts.ignorable;
    let kept: Vec<usize> = (0..whole.coordinates.len()).filter(|i| !ignorable.contains(i)).collect();
    let coordinates: Vec<Coordinate> = kept.iter().map(|&i| whole.coordinates[i].clone()).collect();
    let momenta = &parameters[whole.parameters.len()..];

    // Symbols in the order in which a definition declares them.
    let mut g = Graph::default();
    for i in 0..parameters.last().map_or(0, |p| p.numbers().end) {
        g.symbol(Symbol::Parameter(i));
    }
    let mut at = |symbol: fn(usize) -> Symbol| -> Vec<Value> {
        let of = |i| kept.iter().position(|k| *k == i).map_or(Value::ZERO, |k| g.symbol(symbol(k)));
        (0..whole.coordinates.len()).map(of).collect()
    };
    let positions = at(Symbol::Coordinate);
    let mut moving = Motion { velocities: at(Symbol::Velocity), positions, bindings: Vec::new() };
    let mut rest = Motion {
        velocities: vec![Value::ZERO; moving.velocities.len()],
        positions: moving.positions.clone(),
        bindings: Vec::new(),
    };

    // L₀, by its bindings at u = 0.
    let mut bindings: Vec<Binding> = Vec::new();
    for b in &whole.bindings {
        let [value, rate] = moving.of(&mut g, &whole.graph, &[b.value, b.rate])[..] else { return None };
        let in_time = |s| matches!(s, Symbol::Coordinate(_) | Symbol::Time | Symbol::Binding(_));
        let pair = if g.depends(&[value], in_time) {
            let k = bindings.len();
            bindings.push(Binding { name: b.name.clone(), value, rate });
            [g.symbol(Symbol::Binding(k)), g.symbol(Symbol::Rate(k))]
        } else {
            [value, rate]
        };
        moving.bindings.push(pair);
        let rate = rest.of(&mut g, &whole.graph, &[b.rate])[0];
        rest.bindings.push([pair[0], rate]);
    }
    let lagrangian = moving.of(&mut g, &whole.graph, &[whole.lagrangian])[0];
    let flat = moving.of(&mut g, &whole.graph, &[e.lagrangian])[0];
    finite(e, &g, flat, header, errors)?;

    // ½ (p − c)·A⁻¹ (p − c) and u.
    let c: Vec<Value> = ignorable.iter().map(|&i| e.momenta[i]).collect();
    let c = moving.of(&mut g, &whole.graph, &c);
    let difference = momenta.iter().zip(c).map(|(p, c)| {
        let p = g.symbol(Symbol::Parameter(p.first));
        g.sub(p, c)
    });
    let difference: Vec<Value> = difference.collect();
    let inertia: Vec<Vec<Value>> = (0..ignorable.len())
        .map(|i| {
            let row: Vec<Value> = (0..=i).map(|j| e.inertia[ignorable[i]][ignorable[j]]).collect();
            rest.of(&mut g, &whole.graph, &row)
        })
        .collect();
    let Some((square, u)) = cheapest(&mut g, &inertia, &difference) else {
        let message = "the velocities of the ignorable coordinates do not follow from their momenta\nhelp: the kinetic energy is not positive definite; check its signs";
        errors.push(&header.name, message);
        return None;
    };

    let energies = whole.energies.and_then(|[t, v]| {
        let [t, v] = moving.of(&mut g, &whole.graph, &[t, v])[..] else { return None };
        let at_rest = rest.of(&mut g, &whole.graph, &whole.energies?)[0];
        let linear = momenta_at_rest(&mut g, &moving, e);
        let natural = !g.depends(&[square], is_velocity) && linear.iter().all(|p| g.vanishes(*p));
        let apparent = g.sub(v, at_rest);
        natural.then(|| [g.sub(t, at_rest), g.add(apparent, square)])
    });
    let lagrangian = match energies {
        Some([t, v]) => g.sub(t, v),
        None => g.sub(lagrangian, square),
    };

    // What is left may depend on u.
    let mut driven = Motion {
        velocities: moving.velocities.clone(),
        positions: moving.positions.clone(),
        bindings: Vec::new(),
    };
    for (&i, &u) in ignorable.iter().zip(&u) {
        driven.velocities[i] = u;
    }
    for (b, pair) in whole.bindings.iter().zip(&moving.bindings) {
        let rate = driven.of(&mut g, &whole.graph, &[b.rate])[0];
        driven.bindings.push([pair[0], rate]);
    }
    let is_removed = |s| matches!(s, Symbol::Coordinate(i) | Symbol::Velocity(i) if ignorable.contains(&i));
    let of_kept = |values: &[Value]| -> Vec<Value> { kept.iter().map(|&i| values[i]).collect() };
    let (dissipation, applied, forces) = if whole.graph.depends(&[e.dissipation], is_removed) {
        let applied = driven.of(&mut g, &whole.graph, &of_kept(&e.nonconservative));
        (Value::ZERO, applied, Vec::new())
    } else {
        let forces: Vec<Value> = whole.forces.iter().map(|f| f.0).collect();
        let places: Vec<Value> = whole.forces.iter().map(|f| f.1).collect();
        let forces = driven.of(&mut g, &whole.graph, &forces);
        let places = moving.of(&mut g, &whole.graph, &places);
        (
            moving.of(&mut g, &whole.graph, &[whole.dissipation])[0],
            driven.of(&mut g, &whole.graph, &of_kept(&whole.applied)),
            forces.into_iter().zip(places).collect(),
        )
    };
    let mut observed = Vec::new();
    for (o, flat) in whole.observed.iter().zip(&e.observed) {
        // To be asked for, the ignorable coordinates come after those that are kept.
        let flat = g.import(&whole.graph, flat, |g, s| match s {
            Symbol::Coordinate(i) if ignorable.contains(&i) => g.symbol(Symbol::Coordinate(kept.len() + i)),
            Symbol::Coordinate(i) => moving.positions[i],
            other => g.symbol(other),
        });
        if independent(&mut g, &flat, |s| matches!(s, Symbol::Coordinate(i) if i >= kept.len())) {
            observed.push(Observed {
                attributes: o.attributes.clone(),
                name: o.name.clone(),
                values: driven.of(&mut g, &whole.graph, &o.values),
                scalar: o.scalar,
            });
        }
    }

    let u = g.share_angles(&u);
    let removed = ignorable.iter().zip(momenta).zip(u).map(|((&index, momentum), velocity)| Removed {
        index,
        label: whole.coordinates[index].label(),
        momentum: momentum.name.clone(),
        velocity,
    });
    let reduction = Reduction { of: whole.name.clone(), kept, removed: removed.collect() };
    Some(Model {
        graph: g,
        runtime: whole.runtime.clone(),
        attributes: header.attributes.clone(),
        visibility: header.visibility.clone(),
        name: header.name.clone(),
        parameters,
        coordinates,
        bindings,
        externals: whole.externals.clone(),
        lagrangian,
        energies,
        dissipation,
        applied,
        forces,
        observed,
        routhian: None,
        reduction: Some(reduction),
        places: Places { kinetic: Some(header.name.clone()), dissipation: whole.places.dissipation.clone() },
    })
}

fn is_velocity(s: Symbol) -> bool {
    matches!(s, Symbol::Velocity(_))
}

/// What the symbols of the whole system are in the reduced one.
struct Motion {
    positions: Vec<Value>,
    velocities: Vec<Value>,
    /// Values and rates.
    bindings: Vec<[Value; 2]>,
}

impl Motion {
    fn of(&self, g: &mut Graph, whole: &Graph, values: &[Value]) -> Vec<Value> {
        g.import(whole, values, |g, symbol| match symbol {
            Symbol::Coordinate(i) => self.positions[i],
            Symbol::Velocity(i) => self.velocities[i],
            Symbol::Binding(k) => self.bindings[k][0],
            Symbol::Rate(k) => self.bindings[k][1],
            other => g.symbol(other),
        })
    }
}

/// ∂T/∂q̇ᵣ at q̇ = 0: the part of T that is linear in the velocities.
fn momenta_at_rest(g: &mut Graph, moving: &Motion, e: &Equations) -> Vec<Value> {
    let kinetic: Vec<Value> = e.energies.iter().map(|[t, _]| *t).collect();
    let velocities: Vec<Symbol> =
        (0..e.momenta.len() - e.facts.ignorable.len()).map(Symbol::Velocity).collect();
    let kinetic = moving.of(g, &e.model.graph, &kinetic);
    let gradient: Vec<Value> = kinetic.iter().flat_map(|t| g.gradient(*t, &velocities)).collect();
    g.substitute(&gradient, |s| is_velocity(s).then_some(Value::ZERO))
}

/// `½ b·A⁻¹ b` and `A⁻¹ b` by completing squares, in the order of the unknowns that costs less.
fn cheapest(g: &mut Graph, a: &[Vec<Value>], b: &[Value]) -> Option<(Value, Vec<Value>)> {
    let forward: Vec<usize> = (0..b.len()).collect();
    let backward: Vec<usize> = forward.iter().rev().copied().collect();
    let solved: Vec<_> = [forward, backward].iter().filter_map(|order| squares(g, a, b, order)).collect();
    let cost = |(square, x): &(Value, Vec<Value>)| {
        let all = [&[*square][..], x].concat();
        operations(g, &all).cost()
    };
    solved.into_iter().min_by_key(cost)
}

/// `b·A⁻¹ b = Σ yₖ²/dₖ` with `A = L D Lᵀ`, `L y = b`: as sums of squares these are the formulas of the textbooks.
fn squares(g: &mut Graph, a: &[Vec<Value>], b: &[Value], order: &[usize]) -> Option<(Value, Vec<Value>)> {
    let n = b.len();
    let at = |i: usize, j: usize| a[order[i].max(order[j])][order[i].min(order[j])];
    let mut a: Vec<Vec<Value>> = (0..n).map(|i| (0..=i).map(|j| at(i, j)).collect()).collect();
    let mut y: Vec<Value> = order.iter().map(|&i| b[i]).collect();
    let mut square = Value::ZERO;
    for k in 0..n {
        if g.vanishes(a[k][k]) {
            return None;
        }
        for i in k + 1..n {
            let l = g.quotient(a[i][k], a[k][k]);
            for j in k + 1..=i {
                let product = g.mul(l, a[j][k]);
                a[i][j] = g.sub(a[i][j], product);
            }
            let product = g.mul(l, y[k]);
            y[i] = g.sub(y[i], product);
        }
        let squared = g.mul(y[k], y[k]);
        let term = g.quotient(squared, a[k][k]).scaled(Number::Ratio(1, 2));
        square = g.add(square, term);
    }
    let mut x = vec![Value::ZERO; n];
    for k in (0..n).rev() {
        let mut rest = y[k];
        for i in k + 1..n {
            let product = g.mul(a[i][k], x[order[i]]);
            rest = g.sub(rest, product);
        }
        x[order[k]] = g.quotient(rest, a[k][k]);
    }
    Some((square, x))
}

/// Can the system be reduced?
fn check(e: &Equations, header: &Header, errors: &mut Errors) -> Option<()> {
    let (n, found) = (e.momenta.len(), e.facts.ignorable.len());
    let message = if found == 0 {
        let reasons: Vec<String> = (0..n).map(|i| reason(e, i)).collect();
        format!(
            "no coordinate of this system is ignorable\nhelp: remove this statement: {}",
            reasons.join(", ")
        )
    } else if found == n {
        "all coordinates of this system are ignorable: nothing is left to integrate\nhelp: remove this statement: all momenta are constant".into()
    } else if !e.facts.quadratic {
        "L is not quadratic in the velocities, so those of the ignorable coordinates have no formula in terms of their momenta\nhelp: remove this statement".into()
    } else {
        return Some(());
    };
    errors.push(&header.name, message);
    None
}

/// Why a coordinate is not ignorable.
fn reason(e: &Equations, i: usize) -> String {
    let label = e.model.coordinates[i].label();
    let named = |values: &[Value]| e.model.graph.depends(values, |s| s == Symbol::Coordinate(i));
    if named(&[e.lagrangian]) {
        format!("`{label}` appears in L")
    } else if named(&[e.dissipation]) {
        format!("`{label}` appears in D")
    } else if named(&e.nonconservative) {
        format!("a force depends on `{label}`")
    } else {
        format!("a force acts on `{label}`")
    }
}

/// The parameters of the whole system, and a momentum for each ignorable coordinate.
fn parameters(e: &Equations, header: &Header, errors: &mut Errors) -> Option<Vec<Parameter>> {
    let mut parameters = e.model.parameters.clone();
    for parameter in &mut parameters {
        parameter.attributes.retain(|a| a.path().is_ident("doc"));
    }
    let sound = errors.is_empty();
    for &i in &e.facts.ignorable {
        let coordinate = &e.model.coordinates[i];
        let index = coordinate.index.map_or(String::new(), |i| format!("_{i}"));
        let name = Ident::new(&format!("p_{}{index}", coordinate.name), header.name.span());
        if let Some(other) = parameters.iter().find(|p| p.name == name) {
            let message = format!(
                "`{name}` is the momentum of `{}` in `{}`\nhelp: give this another name",
                coordinate.label(),
                header.name
            );
            let place = if other.momentum_of.is_some() { &coordinate.name } else { &other.name };
            errors.push(place, message);
        }
        parameters.push(Parameter {
            attributes: Vec::new(),
            name,
            length: None,
            default: None,
            first: parameters.last().map_or(0, |p| p.numbers().end),
            momentum_of: Some(coordinate.label()),
        });
    }
    (sound == errors.is_empty()).then_some(parameters)
}

/// L does not depend on the ignorable coordinates, but as it is written it may have no value where they are 0.
fn finite(e: &Equations, g: &Graph, flat: Value, header: &Header, errors: &mut Errors) -> Option<()> {
    let sample = |s| super::check::sample(s, 0, 0);
    let value = |g: &Graph, v: Value| g.evaluate(&[v], sample)[0];
    if value(g, flat).is_finite() || !value(&e.model.graph, e.lagrangian).is_finite() {
        return Some(());
    }
    let message =
        "L as it is written has no value where the ignorable coordinates are 0\nhelp: write it without them";
    errors.push(&header.name, message);
    None
}
