//! Elaboration of `restriction`, and of the definitions that are read again for it.

use super::*;
use crate::model::submodel::{Hold, Move, Submodel};
use crate::syntax;

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

    /// The value at which a coordinate of the whole system is held, and that is noted.
    pub(in crate::model) fn held(&mut self, index: usize) -> Option<Value> {
        let variation = self.variation.as_ref()?;
        let hold = variation.holds.iter().find(|hold| hold.index == index)?;
        let (graph, label) = (variation.graph, variation.whole.coordinates[index].label());
        let value = self.graph.import(graph, &[hold.value], |g, symbol| g.symbol(symbol))[0];
        self.found.held.push(crate::model::submodel::Held { index, label, value });
        Some(value)
    }

    pub(super) fn placed(&mut self, place: Place) -> Val {
        Val::Number(match place {
            Place::Free(i) => self.graph.symbol(Symbol::Coordinate(i)),
            Place::Held(value) => value,
        })
    }

    /// `restriction Planar: phi = 0, psi = 0;`
    pub(in crate::model) fn submodel(&mut self, asked: &syntax::Submodel) {
        let mut moves: Vec<Move> = Vec::new();
        let before = self.errors.len();
        for written in &asked.moves {
            let syntax::Move::Hold { coordinate, value } = written;
            let Ok(holds) = self.holds(coordinate, value) else { continue };
            let twice = holds
                .iter()
                .find(|hold| moves.iter().flat_map(|m| &m.holds).any(|other| other.index == hold.index));
            if let Some(twice) = twice {
                let label = self.found.coordinates[twice.index].label();
                let message = format!("`{label}` is held twice\nhelp: remove one of them");
                self.errors.push(coordinate, message);
            }
            moves.push(Move { at: written.tokens(), holds });
        }
        if self.errors.len() > before {
            return;
        }
        let submodel = Submodel { header: asked.header.clone(), moves };
        let states = self.found.states.first().map_or(self.found.coordinates.len(), |state| state.first);
        if submodel.holds().len() == states {
            let message = "all coordinates are held: nothing is left to move\nhelp: leave one of them free";
            self.errors.push(&asked.header.name, message);
            return;
        }
        self.found.submodels.push(submodel);
    }

    /// The coordinates that are named, each with its value.
    fn holds(&mut self, coordinate: &Expr, value: &Expr) -> Result<Vec<Hold>> {
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
            let message = format!(
                "a coordinate is held at a constant, and this depends on {what}\nhelp: write a number, or an expression of parameters; a given motion is `coord {} = f(t);`",
                plain(coordinate)
            );
            return Err(self.errors.push(value, message));
        }
        Ok(indices.into_iter().zip(values).map(|(index, value)| Hold { index, value }).collect())
    }

    /// The coordinates that can be held.
    fn held_targets(&mut self, expression: &Expr) -> Result<Vec<usize>> {
        let (base, index, known) = self.named(expression);
        let text = plain(base);
        let message = match (known, index) {
            (Some(Entry::Rotation { .. }), _) => format!(
                "`{text}` is a rotation, which is not held\nhelp: write a system of its own, with a frame that does not turn"
            ),
            _ if self.length_of_direction(&text).is_some() => format!(
                "`{text}` is a direction, whose components are not held one by one\nhelp: write a system of its own, with an angle"
            ),
            (Some(Entry::State { .. }), _) => {
                format!("`{text}` is a state of first order, and only coordinates are held\nhelp: remove it")
            }
            (Some(Entry::Prescribed(_)), _) => {
                format!(
                    "the motion of `{text}` is given already\nhelp: remove it; only free coordinates are held"
                )
            }
            (Some(Entry::Coordinate { length: None, .. }), Some(_)) => {
                format!("the coordinate `{text}` has no elements\nhelp: write `{text} = 0`")
            }
            _ => return self.targets(expression),
        };
        Err(self.errors.push(expression, message))
    }

    /// `Q[x] = …;` where some of the coordinates are held: their forces do no work. Returns whether there are any.
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
            if let Place::Free(i) = place {
                self.found.applied[i] = Some(force);
            }
        }
        Ok(true)
    }
}
