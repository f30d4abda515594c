//! Replacing nodes by expressions.

use super::{Graph, Id, Node, Symbol, Value, stable_map::StableMap};

impl Graph {
    /// The roots with every node for which `replacement` has an answer replaced by it, rebuilt through the
    /// constructors. Replacements are taken as they are: nothing is replaced inside them.
    pub fn replace(
        &mut self,
        roots: &[Value],
        replacement: impl Fn(Id, &Node) -> Option<Value>,
    ) -> Vec<Value> {
        let mut images: StableMap<Id, Value> = StableMap::default();
        let image = |images: &StableMap<Id, Value>, v: Value| match v.node.and_then(|n| images.get(&n)) {
            Some(&new) => new.scaled(v.k),
            None => v,
        };
        for id in self.live(roots) {
            let node = self.node(id);
            let new = if let Some(new) = replacement(id, node) {
                new
            } else {
                let mut changed = false;
                self.operands(id, |v| changed |= image(&images, v) != v);
                if !changed {
                    continue;
                }
                let of = |v: Value| image(&images, v);
                match self.node(id).clone() {
                    Node::Symbol(_) => unreachable!("a symbol has no operands"),
                    Node::Sum(a, b) => self.add(of(a), of(b)),
                    Node::Product(a, b) => self.mul(of(a.into()), of(b.into())),
                    Node::Inverse(a) => self.recip(of(a.into())),
                    Node::Call(f, a, b) if f.row().arguments.len() == 2 => self.call2(f, of(a), of(b)),
                    Node::Call(f, a, _) => self.call(f, of(a)),
                    Node::Extern(f, orders, arguments) => {
                        let arguments = arguments.iter().map(|a| of(*a)).collect();
                        self.external(f, orders, arguments)
                    }
                    Node::Select(comparison, values) => {
                        let [a, b, yes, no] = *values;
                        self.select(comparison, of(a), of(b), of(yes), of(no))
                    }
                }
            };
            images.insert(id, new);
        }
        roots.iter().map(|v| image(&images, *v)).collect()
    }

    /// The roots with symbols replaced.
    pub fn substitute(&mut self, roots: &[Value], value: impl Fn(Symbol) -> Option<Value>) -> Vec<Value> {
        self.replace(roots, |_, node| match node {
            Node::Symbol(symbol) => value(*symbol),
            _ => None,
        })
    }
}
