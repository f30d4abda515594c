//! Expressions as formulas of one line, in the names of a model: for messages and for the stages of a system.

use crate::graph::{Comparison, Graph, Id, Node, Symbol, Value};
use crate::model::Model;
use std::cell::Cell;

/// Formulas of more nodes are cut off.
const MAX_TEXT_NODES: usize = 40;

/// Values in the names of a model, as formulas of one line.
pub struct Writer<'a> {
    g: &'a Graph,
    model: &'a Model,
    /// Nodes that the current formula may still have.
    left: Cell<usize>,
}

impl<'a> Writer<'a> {
    pub fn new(g: &'a Graph, model: &'a Model) -> Self {
        Writer { g, model, left: Cell::new(0) }
    }

    pub fn text(&self, v: Value) -> String {
        self.left.set(MAX_TEXT_NODES);
        let text = self.value(v);
        if text.contains("...") { format!("{text} ({} nodes)", self.g.live(&[v]).len()) } else { text }
    }

    fn value(&self, v: Value) -> String {
        let Some(id) = v.node else { return format!("{}", v.k.to_f64()) };
        match v.k.to_f64() {
            1.0 => self.node(id),
            -1.0 => format!("-{}", self.node(id)),
            k => format!("{k} {}", self.node(id)),
        }
    }

    fn node(&self, id: Id) -> String {
        // A shared node would be written once for each of its users.
        if self.left.get() == 0 {
            return "...".into();
        }
        self.left.set(self.left.get() - 1);
        let list = |values: &[Value]| values.iter().map(|v| self.value(*v)).collect::<Vec<_>>().join(", ");
        match self.g.node(id) {
            Node::Symbol(symbol) => self.symbol(*symbol),
            Node::Sum(a, b) => format!("({} + {})", self.value(*a), self.value(*b)).replace("+ -", "- "),
            Node::Product(a, b) => format!("{} {}", self.node(*a), self.node(*b)),
            Node::Inverse(a) => format!("1/{}", self.node(*a)),
            Node::Call(f, a, b) => {
                format!("{}({})", f.row().name, list(&[*a, *b][..f.row().arguments.len()]))
            }
            Node::Extern(f, _, arguments) => {
                format!("{}({})", self.model.externals[*f].name, list(arguments))
            }
            Node::Select(comparison, values) => {
                let [a, b, yes, no] = values.map(|v| self.value(v));
                let sign = match comparison {
                    Comparison::Less => "<",
                    Comparison::LessEqual => "<=",
                    Comparison::Equal => "==",
                };
                format!("(if {a} {sign} {b} {{ {yes} }} else {{ {no} }})")
            }
        }
    }

    fn symbol(&self, symbol: Symbol) -> String {
        let coordinate = |i: usize| self.model.coordinates[i].label();
        match symbol {
            Symbol::Time => "t".into(),
            Symbol::Parameter(i) => self.model.parameter_labels()[i].clone(),
            Symbol::Coordinate(i) => coordinate(i),
            Symbol::Velocity(i) if i >= self.model.mechanical() => coordinate(i),
            Symbol::Acceleration(i) if i >= self.model.mechanical() => format!("{}'", coordinate(i)),
            Symbol::Velocity(i) => format!("{}'", coordinate(i)),
            Symbol::Acceleration(i) => format!("{}''", coordinate(i)),
            Symbol::Binding(k) => self.model.bindings[k].name.clone(),
            Symbol::Rate(k) => format!("{}'", self.model.bindings[k].name),
            other => format!("{other:?}"),
        }
    }
}
