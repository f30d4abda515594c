//! Systems that are derived from another one: what is asked for, and what has become of it.
//!
//! A derived system is the definition read again, with names that mean values: coordinates that are held, terms that
//! are neglected. Its bindings, frames and constraints are those that a person would have written for it
//! (docs/decisions/0020).

use super::value::Val;
use crate::graph::{Graph, Value};
use crate::model::Model;
use crate::syntax::Header;
use proc_macro2::{Ident, TokenStream};

/// A second type that is asked for, in terms of the system that asks.
pub struct Submodel {
    pub header: Header,
    /// Is it proved to be exact?
    pub exact: bool,
    pub moves: Vec<Move>,
}

/// One of its moves, with the tokens to point at.
#[derive(Clone)]
pub struct Move {
    pub at: TokenStream,
    pub change: Change,
}

#[derive(Clone)]
pub enum Change {
    Hold(Vec<Hold>),
    /// A parameter, or a `let` with zeros in the place of its value.
    Neglect(Ident, Zero),
    Dissipation,
    /// Terms of the Lagrangian that are linear in the velocities.
    Gyroscopic,
    /// Expansion about these values to an order of the energies.
    Expand(Vec<Hold>, u32),
    /// The inertia matrix at these values.
    Inertia(Vec<Hold>),
    /// Coordinates that follow the others as in statics.
    Quasistatic(Vec<usize>),
    /// The mean over this phase of a fast motion.
    Average(Value),
}

/// The meaning of a name that is neglected.
#[derive(Clone)]
pub struct Zero(pub(super) Val);

/// A coordinate of the whole system, and a value for it.
#[derive(Clone, Copy)]
pub struct Hold {
    pub index: usize,
    pub value: Value,
}

impl Submodel {
    pub fn holds(&self) -> Vec<Hold> {
        self.moves
            .iter()
            .flat_map(|m| if let Change::Hold(holds) = &m.change { &holds[..] } else { &[] })
            .copied()
            .collect()
    }
}

/// Differences of a reading of a definition from the one of the whole system.
pub struct Variation<'w> {
    pub whole: &'w Model,
    /// The graph of the values, in the symbols of the whole system.
    pub graph: &'w Graph,
    pub holds: Vec<Hold>,
    pub zeros: Vec<(&'w Ident, &'w Zero)>,
}

impl Variation<'_> {
    pub(super) fn zero(&self, name: &Ident) -> Option<&Val> {
        self.zeros.iter().find(|(zero, _)| *zero == name).map(|(_, zero)| &zero.0)
    }
}

/// Derivation of a system from another one.
pub struct Origin {
    /// Name of the other.
    pub of: Ident,
    pub exact: bool,
    /// Indices of the coordinates that were kept, in the other.
    pub kept: Vec<usize>,
    pub held: Vec<Held>,
    /// Velocities that an average has taken away, by coordinates, if there is one.
    pub fast: Vec<Value>,
    pub moves: Vec<Made>,
    /// Names of numbers of parameters that are gone, by symbol index after those that are left.
    pub gone: Vec<String>,
}

/// A coordinate that was removed.
pub struct Held {
    /// Its index in the system that has it.
    pub index: usize,
    pub label: String,
    pub value: Value,
    /// Does it follow the others?
    pub follows: bool,
}

/// A move that was made: its words, and terms that were left out, each under its letter.
pub struct Made {
    pub words: String,
    pub remainders: Vec<(&'static str, Value)>,
}
