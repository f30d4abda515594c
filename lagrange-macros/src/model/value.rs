//! What an expression of the language can be while the macro runs: numbers, and the compile-time values (integers,
//! arrays, ranges, closures) that build them.

use super::elaborate::Turn;
use crate::graph::{Comparison, Graph, Value};
use std::rc::Rc;

#[derive(Clone)]
pub enum Val {
    /// A compile-time integer: a literal, a constant, an index.
    Int(i64),
    /// An expression of the system.
    Number(Value),
    Bool(bool),
    Condition(Rc<Condition>),
    /// Arrays, ranges, tuples: all are lists here.
    Array(Vec<Val>),
    Closure(Rc<Closure>),
    /// A product of rotations in space.
    Rotation(Rc<Vec<Turn>>),
    Frame(Frame),
}

/// Axes with an origin.
#[derive(Clone, Copy)]
pub enum Frame {
    World,
    /// In the axes of the world.
    Plane {
        origin: [Value; 2],
        angle: Value,
    },
    /// By indices of the point and of the orientation.
    Space {
        origin: usize,
        axes: usize,
    },
}

pub struct Closure {
    pub expression: Rc<syn::ExprClosure>,
    /// Local names at the place where it was written.
    pub scope: Vec<(String, Val)>,
}

/// A condition that only the state decides.
pub enum Condition {
    Compare(Comparison, Value, Value),
    Not(Rc<Condition>),
    And(Rc<Condition>, Rc<Condition>),
    Or(Rc<Condition>, Rc<Condition>),
}

impl Condition {
    /// `if self { yes } else { no }`
    pub fn select(&self, g: &mut Graph, yes: Value, no: Value) -> Value {
        match self {
            Condition::Compare(comparison, a, b) => g.select(*comparison, *a, *b, yes, no),
            Condition::Not(inner) => inner.select(g, no, yes),
            Condition::And(p, q) => {
                let yes = q.select(g, yes, no);
                p.select(g, yes, no)
            }
            Condition::Or(p, q) => {
                let no = q.select(g, yes, no);
                p.select(g, yes, no)
            }
        }
    }
}

impl Val {
    /// Numbers in it.
    pub fn size(&self) -> usize {
        match self {
            Val::Array(items) => items.iter().map(Val::size).sum::<usize>().max(1),
            _ => 1,
        }
    }

    pub fn has_frames(&self) -> bool {
        match self {
            Val::Frame(_) => true,
            Val::Array(items) => items.iter().any(Val::has_frames),
            _ => false,
        }
    }

    /// What it is, for messages.
    pub fn kind(&self) -> String {
        match self {
            Val::Int(_) => "an integer".into(),
            Val::Number(_) => "a number".into(),
            Val::Bool(_) | Val::Condition(_) => "a condition".into(),
            Val::Array(items) => format!("an array of {}", items.len()),
            Val::Closure(_) => "a closure".into(),
            Val::Rotation(_) => "a rotation".into(),
            Val::Frame(_) => "a frame".into(),
        }
    }
}

impl From<Value> for Val {
    fn from(value: Value) -> Val {
        Val::Number(value)
    }
}
