//! Changes of L, D and Q in q, q̇ and t: expansions, the inertia matrix at a point, terms of a kind left out.
//!
//! L, D and Q are changed, and the equations derived afterwards. So M stays symmetric, what was conservative stays
//! so, and momenta are those of the changed L.

use super::assemble::{Form, exert, flatten, flattened};
use super::average::average;
use super::check::{TRIALS, sample};
use super::common::{MAX_EXPANDED_COORDINATES, independent, shortest};
use super::text::Writer;
use crate::graph::{Function, Graph, Id, Node, Number, Symbol, Value};
use crate::model::frames::Frames;
use crate::model::submodel::{Change, Hold, Made};
use crate::model::{Model, NamedEvent, Observed, Struck};

/// Orders beyond the last one in which the first term that is left out is looked for.
const NEXT_ORDERS: u32 = 2;

/// L, D and the forces of a system in q, q̇ and t alone.
pub struct Parts {
    pub lagrangian: Value,
    pub dissipation: Value,
    /// Forces that no potential and no dissipation gives, by coordinates.
    pub forces: Vec<Value>,
}

impl Parts {
    pub fn of(g: &mut Graph, model: &Model) -> Parts {
        let written = Form::of(model);
        let flat = flatten(g, &written.bindings);
        let form = written.expanded(g, &flat);
        let n = model.coordinates.len();
        let mut forces = form.applied;
        exert(g, &form.forces, &(0..n).map(Symbol::Coordinate).collect::<Vec<_>>(), &mut forces);
        exert(g, &form.frame_forces, &(0..n).map(Symbol::Velocity).collect::<Vec<_>>(), &mut forces);
        Parts { lagrangian: form.lagrangian, dissipation: form.dissipation, forces }
    }

    pub fn all(&self) -> Vec<Value> {
        [&[self.lagrangian, self.dissipation][..], &self.forces].concat()
    }

    /// The parts that are not 0, with letters.
    pub fn named(&self) -> Vec<(&'static str, Value)> {
        let letters = ["L", "D"].into_iter().chain(std::iter::repeat("Q"));
        letters.zip(self.all()).filter(|(_, v)| !v.is_zero()).collect()
    }

    pub fn map(&self, f: impl FnOnce(&[Value]) -> Vec<Value>) -> Parts {
        let mut all = f(&self.all());
        let forces = all.split_off(2);
        Parts { lagrangian: all[0], dissipation: all[1], forces }
    }

    /// Differences, in which equal terms are gone if there are not too many; 0 where they are proved to vanish.
    pub fn less(&self, other: &Parts, g: &mut Graph) -> Parts {
        let (other, n) = (other.all(), self.forces.len());
        self.map(|values| {
            let pairs = values.iter().zip(other);
            pairs
                .map(|(a, b)| {
                    let difference = g.sub(*a, b);
                    if g.vanishes(difference) { Value::ZERO } else { shortest(g, n, &[difference])[0] }
                })
                .collect()
        })
    }
}

/// Applies a change to a system; `numbers` are the parameters in which values of `whole` are.
pub fn apply(
    (g, model): &mut (Graph, Model),
    change: &Change,
    whole: &Graph,
    numbers: &[Option<usize>],
) -> Result<(), String> {
    match change {
        Change::Hold(_) | Change::Neglect(..) | Change::Quasistatic(_) => {}
        Change::Dissipation => {
            if model.dissipation.is_zero() {
                return Err(
                    "it has no dissipation function `D`; friction that is a force is neglected by its name"
                        .into(),
                );
            }
            model.dissipation = Value::ZERO;
            model.keywords.dissipation = None;
        }
        Change::Gyroscopic => {
            flat(g, model);
            let [_, linear, _] = degrees(g, model)?;
            subtract(g, model, linear);
        }
        Change::Inertia(holds) => {
            flat(g, model);
            let places = places(g, model, holds, whole, numbers)?;
            let [_, _, square] = degrees(g, model)?;
            finite(g, model, &places, square, "")?;
            let at = g.substitute(&[square], |s| match s {
                Symbol::Coordinate(i) => places.iter().find(|p| p.0 == i).map(|p| p.1),
                _ => None,
            })[0];
            let difference = g.sub(square, at);
            subtract(g, model, difference);
        }
        Change::Expand(holds, order) => {
            if !model.constraints.is_empty() {
                return Err("constraints that are exact do not go with energies that are expanded: multipliers times their terms of second order are missing".into());
            }
            flat(g, model);
            let places = places(g, model, holds, whole, numbers)?;
            expand(g, model, &places, *order)?;
        }
        Change::Average(phase) => {
            if !model.constraints.is_empty() {
                return Err("the mean of constraints that move is none of them".into());
            }
            flat(g, model);
            let phase = g.import(whole, &[*phase], |g, symbol| match symbol {
                Symbol::Parameter(i) => numbers[i].map_or(Value::ZERO, |i| g.symbol(Symbol::Parameter(i))),
                other => g.symbol(other),
            })[0];
            if phase.is_zero() {
                return Err("the rate of this phase is neglected".into());
            }
            average(g, model, phase)?;
        }
    }
    Ok(())
}

/// Makes forces of a D that is no quadratic form any more: the end of a damper follows a given motion.
pub fn carried((g, model): &mut (Graph, Model)) {
    let d = Parts::of(g, model).dissipation;
    let velocities: Vec<Symbol> = (0..model.mechanical()).map(Symbol::Velocity).collect();
    let friction = g.gradient(d, &velocities);
    let at_rest = g.substitute(&friction, |s| velocities.contains(&s).then_some(Value::ZERO));
    if at_rest.iter().all(|v| g.vanishes(*v)) {
        return;
    }
    for (force, friction) in model.applied.iter_mut().zip(friction) {
        *force = g.sub(*force, friction);
    }
    model.dissipation = Value::ZERO;
    model.keywords.dissipation = None;
}

/// Writes out bindings and frames.
fn flat(g: &mut Graph, model: &mut Model) {
    let parts = Parts::of(g, model);
    let flat = flatten(g, &Form::of(model).bindings);
    let energies = model.energies.map(|pair| flattened(g, &flat, &pair)).map(|pair| [pair[0], pair[1]]);
    // Reactions are those at bindings.
    let reacts = |g: &Graph, values: &[Value]| g.depends(values, |s| matches!(s, Symbol::Reaction(_)));
    let observed = std::mem::take(&mut model.observed).into_iter();
    let observed = observed.filter(|o| !reacts(g, &o.values)).collect::<Vec<_>>();
    let events = std::mem::take(&mut model.events).into_iter();
    let events = events.filter(|e| !reacts(g, &e.values)).collect::<Vec<_>>();
    model.observed =
        observed.into_iter().map(|o| Observed { values: flattened(g, &flat, &o.values), ..o }).collect();
    model.events =
        events.into_iter().map(|e| NamedEvent { values: flattened(g, &flat, &e.values), ..e }).collect();
    let struck = std::mem::take(&mut model.struck).into_iter();
    model.struck = struck.map(|s| Struck { position: flattened(g, &flat, &s.position), ..s }).collect();
    for constraint in &mut model.constraints {
        constraint.value = flattened(g, &flat, &[constraint.value])[0];
    }
    for held in model.origin.iter_mut().flat_map(|origin| &mut origin.held) {
        held.value = flattened(g, &flat, &[held.value])[0];
    }
    for attitude in &mut model.attitudes {
        attitude.spin = None;
    }
    (model.lagrangian, model.energies) = (parts.lagrangian, energies);
    (model.dissipation, model.applied) = (parts.dissipation, parts.forces);
    (model.forces, model.frame_forces) = Default::default();
    (model.bindings, model.prescribed) = Default::default();
    (model.frames, model.written, model.framed) = (Frames::default(), Vec::new(), false);
}

/// Coordinates of a derived system, with the values for them.
fn places(
    g: &mut Graph,
    model: &Model,
    holds: &[Hold],
    whole: &Graph,
    numbers: &[Option<usize>],
) -> Result<Vec<(usize, Value)>, String> {
    let kept = &model.origin.as_ref().expect("a derived system").kept;
    let place = |hold: &Hold| kept.iter().position(|k| *k == hold.index).expect("it is not held");
    holds
        .iter()
        .map(|hold| {
            let value = g.import(whole, &[hold.value], |g, symbol| match symbol {
                Symbol::Parameter(i) => numbers[i].map_or(Value::ZERO, |i| g.symbol(Symbol::Parameter(i))),
                other => g.symbol(other),
            });
            // (Some values of the parameters are outside of its domain.)
            match (0..TRIALS).any(|trial| g.evaluate(&value, |s| sample(s, trial, 0))[0].is_finite()) {
                true => Ok((place(hold), value[0])),
                false => Err("a value at this place is not finite".into()),
            }
        })
        .collect()
}

/// Parts of L without velocities, linear and quadratic in them.
fn degrees(g: &mut Graph, model: &Model) -> Result<[Value; 3], String> {
    let n = model.mechanical();
    let of = model.energies.map_or(model.lagrangian, |[t, _]| t);
    let velocities: Vec<Symbol> = (0..n).map(Symbol::Velocity).collect();
    let at_rest = |s: Symbol| velocities.contains(&s).then_some(Value::ZERO);
    let rest = g.substitute(&[of], at_rest)[0];
    let momenta = g.gradient(of, &velocities);
    let drift = g.substitute(&momenta, at_rest);
    let (mut linear, mut square) = (Value::ZERO, Value::ZERO);
    for i in 0..n {
        let row = g.gradient(momenta[i], &velocities);
        if !independent(g, &row, |s| velocities.contains(&s)) {
            return Err("L is not quadratic in the velocities".into());
        }
        let qd = g.symbol(Symbol::Velocity(i));
        let term = g.mul(drift[i], qd);
        linear = g.add(linear, term);
        for (j, m) in row.into_iter().enumerate() {
            let other = g.symbol(Symbol::Velocity(j));
            let product = g.mul(qd, other);
            let term = g.mul(m, product).scaled(Number::Ratio(1, 2));
            square = g.add(square, term);
        }
    }
    Ok([rest, linear, square])
}

/// Leaves terms of the kinetic energy out.
fn subtract(g: &mut Graph, model: &mut Model, terms: Value) {
    let n = model.coordinates.len();
    let mut less = |v: Value| {
        let difference = g.sub(v, terms);
        shortest(g, n, &[difference])[0]
    };
    match &mut model.energies {
        Some([t, v]) => {
            *t = less(*t);
            model.lagrangian = g.sub(*t, *v);
        }
        None => model.lagrangian = less(model.lagrangian),
    }
}

/// T, V and D to an order in the deviations of these coordinates and in their velocities, and forces to the order of
/// their work.
fn expand(g: &mut Graph, model: &mut Model, places: &[(usize, Value)], order: u32) -> Result<(), String> {
    let n = model.coordinates.len();
    let series = Series { model, places };
    let mut leading = Vec::new();
    let energies = match model.energies {
        Some([t, v]) => {
            let ([t, next_t], [v, next_v]) = (series.expanded(g, t, order)?, series.expanded(g, v, order)?);
            leading.push(("T", next_t));
            leading.push(("V", next_v));
            Some([t, v])
        }
        None => None,
    };
    let lagrangian = match energies {
        Some([t, v]) => g.sub(t, v),
        None => {
            let [l, next] = series.expanded(g, model.lagrangian, order)?;
            leading.push(("L", next));
            l
        }
    };
    let [dissipation, next] = series.expanded(g, model.dissipation, order)?;
    leading.push(("D", next));
    let mut forces = Vec::new();
    for (i, force) in model.applied.iter().enumerate() {
        let of_these = places.iter().any(|p| p.0 == i);
        let [force, next] = series.expanded(g, *force, if of_these { order - 1 } else { order })?;
        leading.push(("Q", next));
        forces.push(force);
    }
    leading.retain(|(_, v)| !v.is_zero());
    let leading: Vec<_> = leading.into_iter().map(|(letter, v)| (letter, shortest(g, n, &[v])[0])).collect();
    if dissipation.is_zero() {
        model.keywords.dissipation = None;
    }
    (model.lagrangian, model.energies) = (lagrangian, energies);
    (model.dissipation, model.applied) = (dissipation, forces);
    let origin = model.origin.as_mut().expect("a derived system");
    origin.moves.push(Made { words: String::new(), remainders: leading });
    Ok(())
}

/// Taylor series about places, in the deviations of coordinates and their velocities.
struct Series<'m> {
    model: &'m Model,
    places: &'m [(usize, Value)],
}

impl Series<'_> {
    fn is_expanded(&self, s: Symbol) -> bool {
        matches!(s, Symbol::Coordinate(i) | Symbol::Velocity(i) if self.places.iter().any(|p| p.0 == i))
    }

    /// The sum to an order, and the first term after it that does not vanish, if it is one of the next few.
    fn expanded(&self, g: &mut Graph, v: Value, order: u32) -> Result<[Value; 2], String> {
        let n = self.model.coordinates.len();
        self.smooth(g, v)?;
        let at = |i: usize| self.places.iter().find(|p| p.0 == i).map(|p| p.1);
        // The direction of the derivatives, which are taken along it again and again, has symbols of its own.
        let mut deviations: Vec<Option<[Value; 2]>> = vec![None; n];
        for &(i, value) in self.places {
            let (q, qd) = (g.symbol(Symbol::Coordinate(i)), g.symbol(Symbol::Velocity(i)));
            deviations[i] = Some([g.sub(q, value), qd]);
        }
        let directions: Vec<[Value; 2]> =
            (0..n).map(|i| [g.symbol(Symbol::Given(i)), g.symbol(Symbol::Given(n + i))]).collect();
        let (mut sum, mut next) = (Value::ZERO, Value::ZERO);
        let (mut derivative, mut factor) = (v, Number::ONE);
        for k in 0..=order + NEXT_ORDERS {
            if k > 0 {
                factor = factor.mul(Number::Ratio(1, i64::from(k)));
                derivative = g.forward(&[derivative], |s| match s {
                    Symbol::Coordinate(i) => at(i).map(|_| directions[i][0]),
                    Symbol::Velocity(i) => at(i).map(|_| directions[i][1]),
                    _ => None,
                })[0];
            }
            let of = if k == 0 { String::new() } else { format!(" in a derivative of order {k}") };
            finite(g, self.model, self.places, derivative, &of)?;
            let term = g.substitute(&[derivative], |s| match s {
                Symbol::Coordinate(i) => at(i),
                Symbol::Velocity(i) => at(i).map(|_| Value::ZERO),
                Symbol::Given(i) => deviations[i % n].map(|both| both[i / n]),
                _ => None,
            })[0];
            let term = term.scaled(factor);
            let term = if g.vanishes(term) { Value::ZERO } else { term };
            if k <= order {
                sum = g.add(sum, term);
            } else if next.is_zero() {
                next = term;
            }
        }
        Ok([if n <= MAX_EXPANDED_COORDINATES { shortest(g, n, &[sum])[0] } else { sum }, next])
    }

    /// Refuses choices, kinks and functions of the user's of what is expanded.
    fn smooth(&self, g: &Graph, v: Value) -> Result<(), String> {
        for id in g.live(&[v]) {
            let (what, of): (&str, Vec<Value>) = match g.node(id) {
                Node::Select(_, parts) => {
                    ("a choice between formulas (`if`, `min`, `max`)", parts[..2].to_vec())
                }
                Node::Call(f, x, _) if [Function::abs, Function::signum].contains(f) => {
                    (f.row().name, vec![*x])
                }
                Node::Extern(f, _, arguments) => {
                    let name = self.model.externals[*f].name.to_string();
                    if g.depends(arguments, |s| self.is_expanded(s)) {
                        return Err(format!("`{name}` is a function of yours, whose series is not known"));
                    }
                    continue;
                }
                _ => continue,
            };
            if g.depends(&of, |s| self.is_expanded(s)) {
                return Err(format!("{what} has no Taylor series"));
            }
        }
        Ok(())
    }
}

/// Refuses expressions that have no value at these places.
fn finite(g: &Graph, model: &Model, places: &[(usize, Value)], v: Value, of: &str) -> Result<(), String> {
    let random = |s: Symbol| sample(s, 0, 0);
    let place = |i: usize| places.iter().find(|p| p.0 == i).map(|p| p.1);
    let at = |s: Symbol| match s {
        Symbol::Coordinate(i) => place(i).map_or(random(s), |value| g.evaluate(&[value], random)[0]),
        Symbol::Velocity(i) if place(i).is_some() => 0.0,
        other => random(other),
    };
    // A state of random numbers may be outside of the domain for reasons of its own.
    let is_open = |s: Symbol| match s {
        Symbol::Coordinate(i) | Symbol::Velocity(i) => place(i).is_none_or(|value| !value.is_constant()),
        _ => true,
    };
    let is_ignored = |id: Id, x: f64| x.is_nan() && g.depends(&[id.into()], is_open);
    let Some(singular) = g.singular(v, at, is_ignored) else { return Ok(()) };
    let writer = Writer::new(g, model);
    let labels = places.iter().filter(|p| g.depends(&[singular.into()], |s| s == Symbol::Coordinate(p.0)));
    let labels =
        labels.map(|(i, value)| format!("`{} = {}`", model.coordinates[*i].label(), writer.text(*value)));
    let (term, labels) = (writer.text(singular.into()), labels.collect::<Vec<_>>());
    let at = if labels.is_empty() { "this place".into() } else { labels.join(", ") };
    Err(format!(
        "the term `{term}`{of} has no value at {at}\nhelp: name another place, or leave this move out"
    ))
}
