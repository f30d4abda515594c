//! Routh's reduction: the system of the coordinates that are not ignorable, as a model of its own.
//!
//! Let the momenta `pᵢ = ∂L/∂q̇ᵢ` of the ignorable coordinates be constant. L is quadratic in their velocities u,
//! `L = L₀ + c·u + ½ u·A u`, where L₀ and c are L and ∂L/∂u at u = 0, so `u = A⁻¹ (p − c)`, and the Routhian
//!
//!   R(qᵣ, q̇ᵣ, t; p) = L − p·u = L₀ − ½ (p − c)·A⁻¹ (p − c)
//!
//! gives the equations of the others as any Lagrangian does (Routh, *Stability of a Given State of Motion*, 1877;
//! Landau and Lifshitz, *Mechanics*, §41). u is never put into L itself, which gives wrong equations. No value
//! depends on an ignorable coordinate, which is proved, so each is written as 0; and the bindings stay bindings, at
//! u = 0, where L₀ is formed.

use super::assemble::{flatten, flattened};
use super::common::independent;
use super::quantities::Quantities;
use super::solve::swept;
use super::{Derived, Equations};
use crate::diagnostics::Errors;
use crate::graph::{Graph, Number, Symbol, Value};
use crate::model::frames::{Frames, Motion};
use crate::model::{
    Attitude, Binding, Constraint, Keywords, Model, NamedEvent, Observed, Parameter, Reduction, Removed,
};
use crate::program::count::operations;
use crate::syntax::Header;
use proc_macro2::Ident;

/// The reduced system, where one is asked for.
pub fn routhian(derived: &Derived, errors: &mut Errors) -> Option<(Graph, Model)> {
    let Derived { model: whole, equations: e, .. } = derived;
    let header = whole.routhian.as_ref()?;
    check(derived, header, errors)?;
    let parameters = parameters(derived, header, errors)?;
    let momenta = &parameters[whole.parameters.len()..];
    let mut r = Reducer::new(derived, &parameters);
    let bindings = r.bindings();
    r.faithful(&bindings, header, errors)?;
    let Some((square, u)) = r.eliminated(momenta) else {
        let message = "the velocities of the ignorable coordinates do not follow from their momenta\nhelp: the kinetic energy is not positive definite; check its signs";
        errors.push(&header.name, message);
        return None;
    };
    let energies = r.energies(square);
    let lagrangian = match energies {
        Some([t, v]) => r.g.sub(t, v),
        None => {
            let rest = r.at(Speed::Kept, &[whole.lagrangian])[0];
            r.g.sub(rest, square)
        }
    };
    r.drive(&u);
    let (dissipation, applied, [forces, frame_forces]) = r.nonconservative();
    let observed = r.observed();
    let events = r.events();
    let constraints = r.constraints();
    let moved = r.at(Speed::Rest, &e.impulses.positions);
    let velocities = r.g.share_angles(&u);
    let removed = e.facts.ignorable.iter().zip(momenta).zip(velocities);
    let removed = removed.map(|((&index, momentum), velocity)| Removed {
        index,
        label: whole.coordinates[index].label(),
        momentum: momentum.name.clone(),
        velocity,
    });
    let model = Model {
        runtime: whole.runtime.clone(),
        attributes: header.attributes.clone(),
        visibility: header.visibility.clone(),
        name: header.name.clone(),
        coordinates: r.of_kept(&whole.coordinates),
        // (Systems that have states are not reduced.)
        states: Vec::new(),
        attitudes: r.attitudes(),
        bindings,
        // Reactions need the motion of what is eliminated; those observed of the whole system are carried over.
        prescribed: Vec::new(),
        constraints,
        externals: whole.externals.clone(),
        lagrangian,
        energies,
        dissipation,
        applied,
        forces,
        frame_forces,
        moved,
        frames: Frames::default(),
        written: Vec::new(),
        framed: false,
        observed,
        events,
        // An impulse would change the momenta that are constants here.
        struck: Vec::new(),
        routhian: None,
        submodels: Vec::new(),
        origin: None,
        reduction: Some(Reduction { of: whole.name.clone(), removed: removed.collect(), kept: r.kept }),
        keywords: Keywords {
            kinetic: Some(header.name.clone()),
            potential: None,
            dissipation: whole.keywords.dissipation.clone(),
        },
        parameters,
    };
    Some((r.g, model))
}

/// Forces, each with what it moves.
type Pairs = Vec<(Value, Value)>;

fn is_velocity(s: Symbol) -> bool {
    matches!(s, Symbol::Velocity(_))
}

/// With which velocities an expression of the whole system is carried over.
#[derive(Clone, Copy)]
enum Speed {
    /// All are 0.
    Rest,
    /// Velocities of the ignorable coordinates are 0.
    Kept,
    /// Velocities of the ignorable coordinates are u.
    Driven,
}

/// Map from the symbols of the whole system to the reduced one, at each speed.
struct Reducer<'e> {
    graph: &'e Graph,
    model: &'e Model,
    e: &'e Equations,
    g: Graph,
    /// Indices of the coordinates that are kept.
    kept: Vec<usize>,
    positions: Vec<Value>,
    velocities: [Vec<Value>; 3],
    bindings: Vec<Value>,
    rates: [Vec<Value>; 3],
}

impl<'e> Reducer<'e> {
    fn new(whole: &'e Derived, parameters: &[Parameter]) -> Self {
        let Derived { graph, model, equations: e } = whole;
        let all = 0..model.coordinates.len();
        let kept: Vec<usize> = all.clone().filter(|i| !e.facts.ignorable.contains(i)).collect();
        // Symbols in the order in which a definition declares them.
        let mut g = Graph::default();
        g.inputs = graph.inputs.clone();
        for i in 0..parameters.last().map_or(0, |p| p.numbers().end) {
            g.symbol(Symbol::Parameter(i));
        }
        let mut symbols = |symbol: fn(usize) -> Symbol| -> Vec<Value> {
            let of = |i| kept.iter().position(|k| *k == i).map_or(Value::ZERO, |k| g.symbol(symbol(k)));
            all.clone().map(of).collect()
        };
        let (positions, velocities) = (symbols(Symbol::Coordinate), symbols(Symbol::Velocity));
        let rest = vec![Value::ZERO; velocities.len()];
        let velocities = [rest, velocities.clone(), velocities];
        Reducer {
            graph,
            model,
            e,
            g,
            kept,
            positions,
            velocities,
            bindings: Vec::new(),
            rates: Default::default(),
        }
    }

    /// Expressions of the whole system in the reduced one.
    fn at(&mut self, speed: Speed, values: &[Value]) -> Vec<Value> {
        let Reducer { graph, g, positions, bindings, .. } = self;
        let (velocities, rates) = (&self.velocities[speed as usize], &self.rates[speed as usize]);
        g.import(graph, values, |g, symbol| match symbol {
            Symbol::Coordinate(i) => positions[i],
            Symbol::Velocity(i) => velocities[i],
            Symbol::Binding(k) => bindings[k],
            Symbol::Rate(k) => rates[k],
            other => g.symbol(other),
        })
    }

    /// The constraints, which do not depend on what is ignorable.
    fn constraints(&mut self) -> Vec<Constraint> {
        let all = &self.model.constraints;
        all.iter().map(|c| Constraint { value: self.at(Speed::Kept, &[c.value])[0], ..c.clone() }).collect()
    }

    fn of_kept<T: Clone>(&self, values: &[T]) -> Vec<T> {
        self.kept.iter().map(|&i| values[i].clone()).collect()
    }

    /// Rotations, none of whose parameters is ignorable, at their new places.
    fn attitudes(&self) -> Vec<Attitude> {
        let place = |attitude: &Attitude| self.kept.iter().position(|k| *k == attitude.first);
        let of = |a: &Attitude| Some(Attitude { first: place(a)?, spin: None, ..a.clone() });
        self.model.attitudes.iter().filter_map(of).collect()
    }

    /// The bindings that still move. Of frames, whose equations are formed as those of other bindings cannot be, none
    /// are kept: their positions and velocities are written out.
    fn bindings(&mut self) -> Vec<Binding> {
        let mut bindings: Vec<Binding> = Vec::new();
        let frames = self.model.bindings.iter().any(|b| !matches!(b.motion, Motion::Position));
        for b in &self.model.bindings {
            let value = self.at(Speed::Kept, &[b.value])[0];
            let [rest, rate] = [Speed::Rest, Speed::Kept].map(|speed| self.at(speed, &[b.rate])[0]);
            let moves = |s| matches!(s, Symbol::Coordinate(_) | Symbol::Time | Symbol::Binding(_));
            let [symbol, rate] = if !frames && self.g.depends(&[value], moves) {
                let k = bindings.len();
                bindings.push(Binding { name: b.name.clone(), value, rate, motion: Motion::Position });
                [Symbol::Binding(k), Symbol::Rate(k)].map(|symbol| self.g.symbol(symbol))
            } else {
                [value, rate]
            };
            self.bindings.push(symbol);
            self.rates[Speed::Rest as usize].push(rest);
            self.rates[Speed::Kept as usize].push(rate);
        }
        bindings
    }

    /// L does not depend on the ignorable coordinates, but as it is written it may have no value where they are 0,
    /// such as `(1 + phi.cos()) * (1 - phi.cos()) / phi.sin().powi(2)`: L₀ and its momenta are tried elsewhere, too.
    fn faithful(&mut self, bindings: &[Binding], header: &Header, errors: &mut Errors) -> Option<()> {
        let Quantities { lagrangian, momenta, .. } = &self.e.quantities;
        let originals = [&[*lagrangian][..], momenta].concat();
        let carried = [&[self.model.lagrangian][..], momenta].concat();
        let carried = self.at(Speed::Kept, &carried);
        let pairs: Vec<[Value; 2]> = bindings.iter().map(|b| [b.value, b.rate]).collect();
        let flat = flatten(&mut self.g, &pairs);
        let carried = flattened(&mut self.g, &flat, &carried);
        let sample = |s| super::check::sample(s, 0, 0);
        let place = |i| self.kept.iter().position(|k| *k == i);
        let carried = self.g.evaluate(&carried, sample);
        let originals = self.graph.evaluate(&originals, |s| match s {
            Symbol::Coordinate(i) => sample(Symbol::Coordinate(place(i).unwrap_or(self.kept.len() + i))),
            Symbol::Velocity(i) => place(i).map_or(0.0, |k| sample(Symbol::Velocity(k))),
            other => sample(other),
        });
        let agrees = |(a, b): (&f64, &f64)| (a - b).abs() <= 1e-9 * b.abs().max(1.0) || !b.is_finite();
        if carried.iter().zip(&originals).all(agrees) {
            return Some(());
        }
        let message = "L as it is written has no value where the ignorable coordinates are 0\nhelp: write it without them";
        errors.push(&header.name, message);
        None
    }

    /// `½ (p − c)·A⁻¹ (p − c)` and `u = A⁻¹ (p − c)`.
    fn eliminated(&mut self, momenta: &[Parameter]) -> Option<(Value, Vec<Value>)> {
        let Equations { facts, quantities, solved, .. } = self.e;
        let c: Vec<Value> = facts.ignorable.iter().map(|&i| quantities.momenta[i]).collect();
        let c = self.at(Speed::Kept, &c);
        let mut difference = Vec::new();
        for (p, c) in momenta.iter().zip(c) {
            let p = self.g.symbol(Symbol::Parameter(p.first));
            difference.push(self.g.sub(p, c));
        }
        let mut a = Vec::new();
        for (k, &i) in facts.ignorable.iter().enumerate() {
            let row: Vec<Value> = facts.ignorable[..=k].iter().map(|&j| solved.inertia[i][j]).collect();
            a.push(self.at(Speed::Rest, &row));
        }
        cheapest(&mut self.g, &a, &difference)
    }

    /// Kinetic energy and apparent potential, `−R` at rest, if R has no terms linear in the velocities.
    fn energies(&mut self, square: Value) -> Option<[Value; 2]> {
        let [flat, _] = self.e.formed.energies?;
        let [kinetic, potential] = self.model.energies?;
        let flat = self.at(Speed::Kept, &[flat])[0];
        let velocities: Vec<Symbol> = (0..self.kept.len()).map(Symbol::Velocity).collect();
        let slopes = self.g.gradient(flat, &velocities);
        let linear = self.g.substitute(&slopes, |s| is_velocity(s).then_some(Value::ZERO));
        if self.g.depends(&[square], is_velocity) || !linear.iter().all(|p| self.g.vanishes(*p)) {
            return None;
        }
        let rest = self.at(Speed::Rest, &[kinetic])[0];
        let [t, v] = [kinetic, potential].map(|energy| self.at(Speed::Kept, &[energy])[0]);
        let apparent = self.g.sub(v, rest);
        Some([self.g.sub(t, rest), self.g.add(apparent, square)])
    }

    /// From here on u is known.
    fn drive(&mut self, u: &[Value]) {
        for (&i, &u) in self.e.facts.ignorable.iter().zip(u) {
            self.velocities[Speed::Driven as usize][i] = u;
        }
        for b in &self.model.bindings {
            let rate = self.at(Speed::Driven, &[b.rate])[0];
            self.rates[Speed::Driven as usize].push(rate);
        }
    }

    /// D, the forces Q, and forces at places. A D that depends on u is no quadratic form any more: its forces are part
    /// of Q then.
    fn nonconservative(&mut self) -> (Value, Vec<Value>, [Pairs; 2]) {
        let (e, whole) = (self.e, self.model);
        let removed = |s| matches!(s, Symbol::Velocity(i) if e.facts.ignorable.contains(&i));
        if self.graph.depends(&[e.quantities.dissipation], removed) {
            let applied = self.at(Speed::Driven, &self.of_kept(&e.formed.nonconservative));
            return (Value::ZERO, applied, Default::default());
        }
        let dissipation = self.at(Speed::Kept, &[whole.dissipation])[0];
        let applied = self.at(Speed::Driven, &self.of_kept(&whole.applied));
        // A force is as in the motion that happens, what it moves as in one that is possible.
        let pairs = [&whole.forces, &whole.frame_forces].map(|pairs| {
            let [forces, moved] = [|f: &(Value, Value)| f.0, |f: &(Value, Value)| f.1]
                .map(|part| pairs.iter().map(part).collect::<Vec<_>>());
            let forces = self.at(Speed::Driven, &forces);
            forces.into_iter().zip(self.at(Speed::Kept, &moved)).collect()
        });
        (dissipation, applied, pairs)
    }

    /// The outputs that are proved not to depend on the ignorable coordinates.
    fn observed(&mut self) -> Vec<Observed> {
        let (model, e) = (self.model, self.e);
        let all = model.observed.iter().zip(&e.quantities.observed);
        let kept = all.filter_map(|(o, solved)| {
            let values = self.without_ignorable(&o.values, solved)?;
            Some(Observed {
                attributes: o.attributes.clone(),
                name: o.name.clone(),
                values,
                layout: o.layout,
            })
        });
        kept.collect()
    }

    /// The events that are proved not to depend on them.
    fn events(&mut self) -> Vec<NamedEvent> {
        let (model, e) = (self.model, self.e);
        let all = model.events.iter().zip(&e.events);
        let kept = all.filter_map(|(event, functions)| {
            let solved: Vec<Value> = functions.iter().map(|f| f.value).collect();
            let values = self.without_ignorable(&event.values, &solved)?;
            Some(NamedEvent { values, ..event.clone() })
        });
        kept.collect()
    }

    /// Values that are proved not to depend on the ignorable coordinates, in those that are kept; `solved` are the
    /// same with reactions replaced.
    fn without_ignorable(&mut self, values: &[Value], solved: &[Value]) -> Option<Vec<Value>> {
        let (graph, e, n) = (self.graph, self.e, self.kept.len());
        // For the question, the ignorable coordinates come after those that are kept.
        let Reducer { g, positions, .. } = self;
        let flat = g.import(graph, solved, |g, symbol| match symbol {
            Symbol::Coordinate(i) if e.facts.ignorable.contains(&i) => g.symbol(Symbol::Coordinate(n + i)),
            Symbol::Coordinate(i) => positions[i],
            other => g.symbol(other),
        });
        if !independent(g, &flat, |s| matches!(s, Symbol::Coordinate(i) if i >= n)) {
            return None;
        }
        // Reactions are known by the equations of the whole system.
        let reacts = |s| matches!(s, Symbol::Reaction(_) | Symbol::Multiplier(_));
        let values = if graph.depends(values, reacts) { solved } else { values };
        Some(self.at(Speed::Driven, values))
    }
}

/// `½ b·A⁻¹ b` and `A⁻¹ b` by completing squares, in the order of the unknowns that costs less.
pub fn cheapest(g: &mut Graph, a: &[Vec<Value>], b: &[Value]) -> Option<(Value, Vec<Value>)> {
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
    swept(g, &mut a, &mut y)?;
    let mut square = Value::ZERO;
    for k in 0..n {
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
fn check(whole: &Derived, header: &Header, errors: &mut Errors) -> Option<()> {
    let facts = &whole.equations.facts;
    let (n, found) = (whole.model.coordinates.len(), facts.ignorable.len());
    let message = if found == 0 {
        let reasons: Vec<String> = (0..n).map(|i| reason(whole, i)).collect();
        format!(
            "no coordinate of this system is ignorable\nhelp: remove this statement: {}",
            reasons.join(", ")
        )
    } else if found == n {
        "all coordinates of this system are ignorable: nothing is left to integrate\nhelp: remove this statement: all momenta are constant".into()
    } else if !facts.quadratic {
        "L is not quadratic in the velocities, so those of the ignorable coordinates have no formula in terms of their momenta\nhelp: remove this statement".into()
    } else {
        return Some(());
    };
    errors.push(&header.name, message);
    None
}

/// Reason why a coordinate is not ignorable.
fn reason(whole: &Derived, i: usize) -> String {
    let label = whole.model.coordinates[i].label();
    let formed = &whole.equations.formed;
    let named = |values: &[Value]| whole.graph.depends(values, |s| s == Symbol::Coordinate(i));
    if named(&[formed.lagrangian]) {
        format!("`{label}` appears in L")
    } else if named(&[formed.dissipation]) {
        format!("`{label}` appears in D")
    } else if named(&formed.nonconservative) {
        format!("a force depends on `{label}`")
    } else {
        format!("a force acts on `{label}`")
    }
}

/// The parameters of the whole system, and a momentum for each ignorable coordinate.
fn parameters(whole: &Derived, header: &Header, errors: &mut Errors) -> Option<Vec<Parameter>> {
    let mut parameters = whole.model.parameters.clone();
    for parameter in &mut parameters {
        parameter.attributes.retain(|a| a.path().is_ident("doc"));
    }
    let sound = errors.is_empty();
    for &i in &whole.equations.facts.ignorable {
        let coordinate = &whole.model.coordinates[i];
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
            rotation: false,
            input: false,
        });
    }
    (sound == errors.is_empty()).then_some(parameters)
}
