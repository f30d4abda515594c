//! Systems that are derived from another one by what is held: what is asked for, and what has become of it.
//!
//! A derived system is the definition read again, with some coordinates that are values and no unknowns: its bindings, frames and
//! constraints are those that a person would have written for it (docs/decisions/0020).

use crate::graph::{Graph, Value};
use crate::model::Model;
use crate::syntax::Header;
use proc_macro2::{Ident, TokenStream};

/// A second type that is asked for, in terms of the system that asks.
pub struct Submodel {
    pub header: Header,
    pub moves: Vec<Move>,
}

/// One of its moves, with the tokens to point at.
pub struct Move {
    pub at: TokenStream,
    pub holds: Vec<Hold>,
}

/// A coordinate of the whole system, and the value that it is held at.
#[derive(Clone, Copy)]
pub struct Hold {
    pub index: usize,
    pub value: Value,
}

impl Submodel {
    pub fn holds(&self) -> Vec<Hold> {
        self.moves.iter().flat_map(|m| m.holds.iter().copied()).collect()
    }
}

/// A definition is read again with these coordinates held.
pub(super) struct Variation<'w> {
    pub graph: &'w Graph,
    pub whole: &'w Model,
    pub holds: Vec<Hold>,
}

/// How a system came from another one.
pub struct Origin {
    /// Name of the other.
    pub of: Ident,
    /// Indices of the coordinates that were kept, in the other.
    pub kept: Vec<usize>,
    pub held: Vec<Held>,
}

/// A coordinate that was removed.
pub struct Held {
    /// Its index in the system that has it.
    pub index: usize,
    pub label: String,
    pub value: Value,
}
