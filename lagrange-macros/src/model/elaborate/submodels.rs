//! Elaboration of `restriction` and `simplified`, and of the definitions that are read again for them.

use super::*;
use crate::model::submodel::{Change, Hold, Move, Submodel, Zero};
use crate::syntax;

/// Orders to which energies are expanded.
const ORDERS: std::ops::RangeInclusive<i64> = 2..=8;

/// The rule for the values of coordinates that are held.
const HELD: &str = "a coordinate is held at a constant";

/// An element of an array of coordinates some of which are held.
#[derive(Clone, Copy)]
pub(in crate::model) enum Place {
    Free(usize),
    Held(Value),
}

impl Elaborator<'_> {
    /// Is this the definition of a derived system? What has become of it is no mistake of who wrote the whole one.
    pub(in crate::model) fn is_derived(&self) -> bool {
        self.variation.is_some()
    }

    /// Is a coordinate of the whole system held?
    pub(in crate::model) fn is_held(&self, index: usize) -> bool {
        self.variation.as_ref().is_some_and(|v| v.holds.iter().any(|hold| hold.index == index))
    }

    /// Zeros, where a name is neglected.
    pub(in crate::model) fn neglected(&self, name: &Ident) -> Option<Val> {
        self.variation.as_ref()?.zero(name).cloned()
    }

    /// Gives the coordinates that are held their values, once all others are declared.
    pub(in crate::model) fn hold(&mut self) {
        let Some(variation) = &self.variation else { return };
        let (graph, whole, holds) = (variation.graph, variation.whole, variation.holds.clone());
        let kept: Vec<usize> = (0..whole.coordinates.len()).filter(|i| !self.is_held(*i)).collect();
        let numbers = self.numbers.clone();
        for (name, places) in std::mem::take(&mut self.mixed) {
            let mut found = Vec::new();
            for index in places {
                let Some(hold) = holds.iter().find(|hold| hold.index == index) else {
                    let place = kept.iter().position(|k| *k == index);
                    found.push(Place::Free(place.expect("what is not held is kept")));
                    continue;
                };
                let place = |i: usize| kept.iter().position(|k| *k == i).expect("values follow what is kept");
                let value = self.graph.import(graph, &[hold.value], |g, symbol| match symbol {
                    Symbol::Coordinate(i) => g.symbol(Symbol::Coordinate(place(i))),
                    Symbol::Parameter(i) => numbers[i],
                    other => g.symbol(other),
                })[0];
                let label = whole.coordinates[index].label();
                // A parameter that is neglected may be what a value is divided by.
                if !self.graph.evaluate(&[value], |_| 0.7)[0].is_finite() {
                    let message = format!("the value of `{label}` is not finite");
                    self.errors.record(syn::Error::new(proc_macro2::Span::call_site(), message));
                }
                let follows = self.graph.depends(&[value], |s| !matches!(s, Symbol::Parameter(_)));
                let value = self.bound_number(&label, value);
                self.found.held.push(Held { index, label, value, follows });
                found.push(Place::Held(value));
            }
            if let Some((_, Entry::Mixed { places, .. })) = self.scope.names.get_mut(&name) {
                *places = found;
            }
        }
        self.found.held.sort_by_key(|held| held.index);
    }

    pub(super) fn placed(&mut self, place: Place) -> Val {
        Val::Number(match place {
            Place::Free(i) => self.graph.symbol(Symbol::Coordinate(i)),
            Place::Held(value) => value,
        })
    }

    /// `restriction Planar: phi = 0, psi = 0;`, `simplified Small: lock x = 0, neglect m2;`
    pub(in crate::model) fn submodel(&mut self, asked: &syntax::Submodel) {
        let mut moves: Vec<Move> = Vec::new();
        let mut removed: Vec<usize> = Vec::new();
        let before = self.errors.len();
        for syntax::Move { tokens, change } in &asked.moves {
            let Ok(resolved) = self.change(change) else { continue };
            let leaving: Vec<usize> = match &resolved {
                Change::Hold(holds) => holds.iter().map(|hold| hold.index).collect(),
                Change::Quasistatic(all) => all.clone(),
                _ => Vec::new(),
            };
            if let Some(twice) = leaving.iter().find(|i| removed.contains(i)) {
                let label = self.found.coordinates[*twice].label();
                let message = format!("`{label}` is held twice\nhelp: remove one of them");
                self.errors.push(tokens, message);
            }
            removed.extend(leaving);
            moves.push(Move { at: tokens.clone(), change: resolved });
        }
        for m in &moves {
            let (Change::Expand(holds, _) | Change::Inertia(holds)) = &m.change else { continue };
            if let Some(hold) = holds.iter().find(|hold| removed.contains(&hold.index)) {
                let label = self.found.coordinates[hold.index].label();
                let message = format!(
                    "`{label}` is no coordinate of this system any more\nhelp: leave it out here, or do not hold it"
                );
                self.errors.push(&m.at, message);
            }
        }
        if self.errors.len() > before {
            return;
        }
        let states = self.found.states.first().map_or(self.found.coordinates.len(), |state| state.first);
        if removed.len() == states {
            let message = "all coordinates are held: nothing is left to move\nhelp: leave one of them free";
            self.errors.push(&asked.header.name, message);
            return;
        }
        self.found.submodels.push(Submodel { header: asked.header.clone(), exact: asked.exact, moves });
    }

    fn change(&mut self, change: &syntax::Change) -> Result<Change> {
        Ok(match change {
            syntax::Change::Hold { coordinate, value } => Change::Hold(self.holds(coordinate, value, HELD)?),
            syntax::Change::Inertia { coordinates, values } => Change::Inertia(self.holds(
                coordinates,
                values,
                "the place of the inertia matrix is constant",
            )?),
            syntax::Change::Quasistatic(coordinates) => Change::Quasistatic(self.held_targets(coordinates)?),
            syntax::Change::Neglect(name) => self.neglect(name)?,
            syntax::Change::Average(phase) => Change::Average(self.phase(phase)?),
            syntax::Change::Expand(expansion) => {
                let syntax::Expansion { coordinates, order, about } = &**expansion;
                let holds = self.holds(coordinates, about, "the place of an expansion is constant");
                let n = self.whole(order)?;
                if !ORDERS.contains(&n) {
                    let message = format!(
                        "energies are expanded to order 2 to {}, and this is {n}\nhelp: to order 2 the equations are linear, as those of small oscillations are",
                        ORDERS.end()
                    );
                    return Err(self.errors.push(order, message));
                }
                Change::Expand(holds?, n as u32)
            }
        })
    }

    /// `average omega * t`: a phase that grows at a constant rate.
    fn phase(&mut self, phase: &Expr) -> Result<Value> {
        let value = self.scalar(phase)?;
        let rate = self.graph.forward(&[value], |s| (s == Symbol::Time).then_some(Value::ONE))[0];
        let of_parameters = |g: &Graph, v: Value| !g.depends(&[v], |s| !matches!(s, Symbol::Parameter(_)));
        let at_start = self.graph.substitute(&[value], |s| (s == Symbol::Time).then_some(Value::ZERO))[0];
        if rate.is_zero() || !of_parameters(&self.graph, rate) || !at_start.is_zero() {
            let message = "the phase of a fast motion is a constant rate times `t`\nhelp: write `average omega * t`, with the rate of the sines and cosines of the motion";
            return Err(self.errors.push(phase, message));
        }
        Ok(value)
    }

    /// `neglect name`: a parameter, a `let`, or a kind of terms.
    fn neglect(&mut self, name: &Ident) -> Result<Change> {
        let text = name.to_string();
        let entry = self.scope.names.get(&text).map(|(_, entry)| entry.clone());
        let zeros = |length: Option<usize>| match length {
            None => Val::Number(Value::ZERO),
            Some(n) => Val::Array(vec![Val::Number(Value::ZERO); n]),
        };
        let message = match entry {
            Some(Entry::Parameter(i)) => {
                let zero = match self.found.parameters[i].rotation {
                    true => Zero(frames::fixed(&mut self.graph, [Value::ZERO; 3])),
                    false => Zero(zeros(self.found.parameters[i].length)),
                };
                return Ok(Change::Neglect(name.clone(), zero));
            }
            Some(Entry::Let(val)) => match zeroed(&val) {
                Some(zero) => return Ok(Change::Neglect(name.clone(), Zero(zero))),
                None => format!(
                    "`{text}` is {}, which is not 0 when it is neglected\nhelp: name a number of the energy, `let small = …;`, and write `neglect small`",
                    val.kind()
                ),
            },
            Some(Entry::Broken) => return Err(Reported),
            Some(Entry::Coordinate { .. }) => {
                format!(
                    "`{text}` is a coordinate, which is not neglected but held\nhelp: write `lock {text} = 0`"
                )
            }
            Some(Entry::Prescribed(_)) => {
                format!("`{text}` is a given motion\nhelp: neglect its amplitude, a parameter")
            }
            Some(_) => format!("`{text}` is no term\nhelp: a term is a parameter or a `let` with a number"),
            None if text == "dissipation" => return Ok(Change::Dissipation),
            None if text == "gyroscopic" => return Ok(Change::Gyroscopic),
            None if self.scope.unread.contains_key(&text) => return Err(Reported),
            None if ["D", "friction", "damping"].contains(&text.as_str()) => {
                format!(
                    "there is no term `{text}`\nhelp: the dissipation function `D` is left out by `neglect dissipation`"
                )
            }
            None if ["T", "V", "L"].contains(&text.as_str()) => {
                format!(
                    "`{text}` is an energy, of which terms are neglected by their names\nhelp: name a term, `let small = …;`, write `small` in `{text}`, and `neglect small`"
                )
            }
            None => {
                let known = self.scope.names.keys().map(String::as_str).chain(["dissipation", "gyroscopic"]);
                let hint = did_you_mean(&text, known);
                format!(
                    "there is no term `{text}`{hint}\nhelp: a term is a parameter, a `let`, `dissipation` or `gyroscopic`; name it, `let {text} = …;`, and write its name in the energy"
                )
            }
        };
        Err(self.errors.push(name, message))
    }

    /// The coordinates that are named, each with its value, which is constant, as `rule` says.
    fn holds(&mut self, coordinate: &Expr, value: &Expr, rule: &str) -> Result<Vec<Hold>> {
        let indices = self.held_targets(coordinate);
        let val = self.evaluate(value);
        let (indices, val) = (indices?, val?);
        let values = match val.dereferenced() {
            Val::Array(items) if items.len() == indices.len() => {
                items.into_iter().map(|item| self.number(item, value)).collect::<Result<Vec<_>>>()?
            }
            Val::Array(items) => {
                let message = format!(
                    "{} for {}\nhelp: one value for each coordinate, or one for all",
                    counted(items.len(), "value"),
                    counted(indices.len(), "coordinate")
                );
                return Err(self.errors.push(value, message));
            }
            scalar => vec![self.number(scalar, value)?; indices.len()],
        };
        let inputs = self.graph.inputs.clone();
        let of_inputs = |symbol: &Symbol| matches!(symbol, Symbol::Parameter(i) if inputs.contains(i));
        let symbols = self.graph.symbols(&values);
        let moves = match symbols.iter().find(|s| !matches!(s, Symbol::Parameter(_)) || of_inputs(s)) {
            None => None,
            Some(Symbol::Time) => Some("time"),
            Some(Symbol::Parameter(_)) => Some("an input, which may change between steps"),
            Some(Symbol::Velocity(_)) => Some("a state of first order, or a velocity"),
            Some(_) => Some("coordinates or time"),
        };
        if let Some(what) = moves {
            let motion = match rule == HELD {
                true => format!("; a given motion is `coord {} = f(t);`", plain(coordinate)),
                false => String::new(),
            };
            let message = format!(
                "{rule}, and this depends on {what}\nhelp: write a number, or an expression of parameters{motion}"
            );
            return Err(self.errors.push(value, message));
        }
        Ok(indices.into_iter().zip(values).map(|(index, value)| Hold { index, value }).collect())
    }

    /// The coordinates that can be held: of one name, or of a list of names.
    fn held_targets(&mut self, expression: &Expr) -> Result<Vec<usize>> {
        if let Expr::Array(list) = expression {
            let mut all: Vec<usize> = Vec::new();
            for one in &list.elems {
                let found = self.held_targets(one)?;
                if found.iter().any(|i| all.contains(i)) {
                    let message =
                        format!("`{}` stands in this list twice\nhelp: remove one of them", plain(one));
                    return Err(self.errors.push(one, message));
                }
                all.extend(found);
            }
            return Ok(all);
        }
        let (base, index, known) = self.named(expression);
        let text = plain(base);
        let message = match (known, index) {
            (Some(Entry::Rotation { .. }), _) => format!(
                "`{text}` is a rotation, and only coordinates that are numbers are held or expanded\nhelp: write a system of its own, with a frame that does not turn"
            ),
            _ if self.length_of_direction(&text).is_some() => format!(
                "`{text}` is a direction, whose components are not held one by one\nhelp: write a system of its own, with an angle"
            ),
            (Some(Entry::State { .. }), _) => {
                format!(
                    "`{text}` is a state of first order, and only coordinates are held or expanded\nhelp: remove it"
                )
            }
            (Some(Entry::Prescribed(_)), _) => {
                format!(
                    "the motion of `{text}` is given already\nhelp: remove it; only free coordinates are held or expanded"
                )
            }
            (Some(Entry::Coordinate { length: None, .. }), Some(_)) => {
                format!("the coordinate `{text}` has no elements\nhelp: write `{text} = 0`")
            }
            _ => return self.targets(expression),
        };
        Err(self.errors.push(expression, message))
    }

    /// `Q[x] = …;` where some of the coordinates are held. What follows others hands its force on to them; other
    /// forces on what is held do no work. Returns whether there are any.
    pub(super) fn applied_where_held(&mut self, coordinate: &Expr, value: &Expr) -> Result<bool> {
        let (_, index, known) = self.named(coordinate);
        let Some(Entry::Mixed { places, length }) = known else { return Ok(false) };
        let places = match index {
            Some(index) => vec![places[self.index(index, length.unwrap_or(0))?]],
            None => places,
        };
        let values = match self.evaluate(value)? {
            Val::Array(items) => items,
            scalar => vec![scalar],
        };
        for (place, val) in places.into_iter().zip(values) {
            let force = self.number(val, value)?;
            match place {
                Place::Free(i) => self.found.applied[i] = Some(force),
                Place::Held(at) => self.found.forces.push((force, at)),
            }
        }
        Ok(true)
    }
}

/// The same with zeros for numbers; none of what is no number.
fn zeroed(val: &Val) -> Option<Val> {
    match val {
        Val::Int(_) | Val::Typed(..) | Val::Number(_) => Some(Val::Number(Value::ZERO)),
        Val::Array(items) => items.iter().map(zeroed).collect::<Option<_>>().map(Val::Array),
        _ => None,
    }
}
