//! Values of expressions while the macro runs: numbers, and the compile-time values (integers,
//! arrays, ranges, closures) that build them.

use super::frames::{Matrix, Vector};
use crate::graph::{Comparison, Graph, Value};
use crate::syntax::spelling::INTEGERS;
use std::rc::Rc;

#[derive(Clone)]
pub enum Val {
    /// A compile-time integer: a literal, a constant, an index.
    Int(i64),
    /// An expression of the system.
    Number(Value),
    Bool(bool),
    Condition(Rc<Condition>),
    /// Arrays, ranges and iterators: all are lists here.
    Array(Vec<Val>),
    Tuple(Vec<Val>),
    Closure(Rc<Closure>),
    /// A product of rotations in space.
    Rotation(Rc<Vec<Turn>>),
    Frame(Frame),
    /// `&x`, or an element of `.iter()`.
    Reference(Rc<Val>),
    /// An integer of a type that was written, as in `3u8`.
    Typed(i64, IntegerType),
}

/// The name of one of Rust's types of integers.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct IntegerType(&'static str);

impl IntegerType {
    pub const I32: IntegerType = IntegerType("i32");
    pub const USIZE: IntegerType = IntegerType("usize");

    pub fn named(name: &str) -> Option<IntegerType> {
        INTEGERS.into_iter().find(|known| *known == name).map(IntegerType)
    }

    pub fn name(self) -> &'static str {
        self.0
    }

    /// Does the type hold this value? `usize` has 64 bits.
    pub fn holds(self, n: i64) -> bool {
        let (sign, width) = self.0.split_at(1);
        let bits = width.parse().unwrap_or(64).min(64);
        match sign {
            "u" => n >= 0 && (bits == 64 || n >> bits == 0),
            _ => matches!(n >> (bits - 1), 0 | -1),
        }
    }
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
    /// Frame by the indices of its point and of its orientation.
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
            Val::Array(items) | Val::Tuple(items) => items.iter().map(Val::size).sum::<usize>().max(1),
            Val::Reference(val) => val.size(),
            _ => 1,
        }
    }

    pub fn has_frames(&self) -> bool {
        match self {
            Val::Frame(_) => true,
            Val::Array(items) | Val::Tuple(items) => items.iter().any(Val::has_frames),
            Val::Reference(val) => val.has_frames(),
            _ => false,
        }
    }

    /// Kind of the value, for messages.
    pub fn kind(&self) -> String {
        match self {
            Val::Int(_) => "an integer".into(),
            Val::Number(_) => "a number".into(),
            Val::Bool(_) | Val::Condition(_) => "a condition".into(),
            Val::Array(items) => format!("an array of {}", items.len()),
            Val::Tuple(items) => format!("a tuple of {}", items.len()),
            Val::Closure(_) => "a closure".into(),
            Val::Rotation(_) => "a rotation".into(),
            Val::Frame(_) => "a frame".into(),
            Val::Reference(val) => format!("a reference to {}", val.kind()),
            Val::Typed(_, ty) => format!("an integer of type `{}`", ty.name()),
        }
    }

    /// Can both be elements of one array?
    pub fn is_like(&self, other: &Val) -> bool {
        match (self, other) {
            (Val::Int(_) | Val::Number(_), Val::Int(_) | Val::Number(_))
            | (Val::Bool(_) | Val::Condition(_), Val::Bool(_) | Val::Condition(_))
            | (Val::Closure(_), Val::Closure(_))
            | (Val::Rotation(_), Val::Rotation(_))
            | (Val::Frame(_), Val::Frame(_))
            | (Val::Int(_), Val::Typed(..))
            | (Val::Typed(..), Val::Int(_)) => true,
            (Val::Typed(_, a), Val::Typed(_, b)) => a == b,
            (Val::Reference(a), Val::Reference(b)) => a.is_like(b),
            (Val::Array(a), Val::Array(b)) | (Val::Tuple(a), Val::Tuple(b)) => {
                a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.is_like(b))
            }
            _ => false,
        }
    }

    /// The integer, with its type where that was written.
    pub fn integer(&self) -> Option<(i64, Option<IntegerType>)> {
        match self {
            Val::Int(n) => Some((*n, None)),
            Val::Typed(n, ty) => Some((*n, Some(*ty))),
            _ => None,
        }
    }

    /// The integer, if it can be of this type.
    pub fn integer_of(&self, ty: IntegerType) -> Option<i64> {
        self.integer().filter(|(_, written)| written.is_none_or(|written| written == ty)).map(|(n, _)| n)
    }

    /// The integer, or the one that this refers to.
    pub fn referred_integer(&self) -> Option<(i64, Option<IntegerType>)> {
        match self {
            Val::Reference(val) => val.integer(),
            val => val.integer(),
        }
    }

    /// The value behind all references, as the receiver of a method finds it.
    pub fn dereferenced(self) -> Val {
        match self {
            Val::Reference(val) => Rc::unwrap_or_clone(val).dereferenced(),
            val => val,
        }
    }

    /// The value behind a reference or none, as operators of numbers find it.
    pub fn referred(self) -> Val {
        match self {
            Val::Reference(val) => Rc::unwrap_or_clone(val),
            val => val,
        }
    }
}

impl From<Value> for Val {
    fn from(value: Value) -> Val {
        Val::Number(value)
    }
}

/// A rotation x_parent = R x, and how it turns, if it does.
#[derive(Clone)]
pub struct Turn {
    pub matrix: Matrix,
    pub spin: Option<Spin>,
}

/// A relative angular velocity, in the turned axes.
#[derive(Clone, Copy)]
pub enum Spin {
    /// About an axis that is fixed in both frames, by the rate of an angle.
    About(Vector, Value),
    /// Quasi-velocities, linear in the rates of these.
    Free(Vector),
}
