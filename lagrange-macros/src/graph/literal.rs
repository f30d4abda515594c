//! Sums and products exactly as they are written.
//!
//! The recurrences of Taylor series are written for the sake of rounding and of the critical path: what is known last
//! is added last. The canonical constructors would associate them anew.

use super::{Graph, Node, Value};

impl Graph {
    /// a + b; only zeros are left out.
    pub fn plus(&mut self, a: Value, b: Value) -> Value {
        match (a.node, b.node) {
            _ if a.is_zero() => b,
            _ if b.is_zero() => a,
            (None, None) => Value::constant(a.k.add(b.k)),
            (None, _) => self.intern(Node::Sum(b, a)).into(),
            _ => self.intern(Node::Sum(a, b)).into(),
        }
    }

    /// a − b
    pub fn minus(&mut self, a: Value, b: Value) -> Value {
        self.plus(a, -b)
    }

    /// Returns sum + a b.
    pub fn plus_product(&mut self, sum: Value, a: Value, b: Value) -> Value {
        let product = self.times(a, b);
        self.plus(sum, product)
    }

    /// a b; coefficients are multiplied, nothing else is.
    pub fn times(&mut self, a: Value, b: Value) -> Value {
        match (a.node, b.node) {
            (Some(x), Some(y)) => Value::from(self.intern(Node::Product(x, y))).scaled(a.k.mul(b.k)),
            (node, None) | (None, node) => Value { node, ..Value::ONE }.scaled(a.k.mul(b.k)),
        }
    }

    /// A value whose coefficient belongs to its node, so that a product by it has none.
    pub fn whole(&mut self, v: Value) -> Value {
        if v.is_constant() || v.k.is_one() { v } else { self.intern(Node::Sum(v, Value::ZERO)).into() }
    }
}
