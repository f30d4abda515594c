//! Interpreter: the second semantics of a graph, against which compiled code is tested and by which the compiler
//! looks for singular inertia.

use super::{Comparison, Graph, Id, Node, Symbol, Value, stable_map::StableMap};

impl Graph {
    /// The roots in floating point, for given values of the symbols. A function of the user's, which the compiler
    /// cannot call, is taken to be some arbitrary smooth function.
    pub fn evaluate(&self, roots: &[Value], symbol: impl Fn(Symbol) -> f64) -> Vec<f64> {
        self.evaluate_rounded(roots, symbol, |x| x)
    }

    /// The same, with the result of every operation rounded in some way.
    pub fn evaluate_rounded(
        &self,
        roots: &[Value],
        symbol: impl Fn(Symbol) -> f64,
        rounded: impl Fn(f64) -> f64,
    ) -> Vec<f64> {
        let mut values: StableMap<Id, f64> = StableMap::default();
        let of = |values: &StableMap<Id, f64>, v: Value| match v.node {
            None => v.k.to_f64(),
            Some(n) => v.k.to_f64() * values.get(&n).copied().unwrap_or(f64::NAN),
        };
        for id in self.live(roots) {
            let at = |v: Value| of(&values, v);
            let value = match self.node(id) {
                Node::Symbol(s) => symbol(*s),
                Node::Sum(a, b) => at(*a) + at(*b),
                Node::Product(a, b) => at((*a).into()) * at((*b).into()),
                Node::Inverse(a) => 1.0 / at((*a).into()),
                Node::Call(f, a, b) => (f.row().value)(&[at(*a), at(*b)]),
                Node::Extern(f, orders, arguments) => {
                    let phase: f64 = arguments.iter().enumerate().map(|(i, a)| at(*a) / (i + 2) as f64).sum();
                    let order: usize = orders.iter().map(|o| usize::from(*o)).sum();
                    (phase + *f as f64 + order as f64).sin() + 1.5
                }
                Node::Select(comparison, values) => {
                    let [a, b, yes, no] = values.map(at);
                    let holds = match comparison {
                        Comparison::Less => a < b,
                        Comparison::LessEqual => a <= b,
                        Comparison::Equal => a == b,
                    };
                    if holds { yes } else { no }
                }
            };
            values.insert(id, rounded(value));
        }
        roots.iter().map(|v| of(&values, *v)).collect()
    }
}
