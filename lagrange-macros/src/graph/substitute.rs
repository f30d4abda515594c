//! Replacing nodes by expressions.

use super::{Graph, Id, Node, Symbol, Value, stable_map::IdMap};

/// The image of a value under the substitution.
fn image(images: &IdMap<Value>, v: Value) -> Value {
    match v.node.and_then(|n| images.get(&n)) {
        Some(&new) => new.scaled(v.k),
        None => v,
    }
}

impl Graph {
    /// The roots with every node for which `replacement` has an answer replaced by it, rebuilt through the
    /// constructors. Replacements are taken as they are: nothing is replaced inside them.
    pub fn replace(
        &mut self,
        roots: &[Value],
        replacement: impl Fn(Id, &Node) -> Option<Value>,
    ) -> Vec<Value> {
        self.rewritten(roots, |_, id, node, _| replacement(id, node))
    }

    /// The roots rebuilt from their operands upwards: of each node what `rewrite` makes of it and of what has become
    /// of values below it, or else the same of its new operands.
    pub fn rewritten(
        &mut self,
        roots: &[Value],
        mut rewrite: impl FnMut(&mut Graph, Id, &Node, &dyn Fn(Value) -> Value) -> Option<Value>,
    ) -> Vec<Value> {
        let mut images: IdMap<Value> = IdMap::default();
        for id in self.live(roots) {
            let node = self.node(id).clone();
            let new = if let Some(new) = rewrite(self, id, &node, &|v| image(&images, v)) {
                new
            } else {
                let mut changed = false;
                self.operands(id, |v| changed |= image(&images, v) != v);
                if !changed {
                    continue;
                }
                self.rebuilt_from(node, |v| image(&images, v))
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

    /// Expressions of another graph, rebuilt here with these values for its symbols.
    pub fn import(
        &mut self,
        other: &Graph,
        roots: &[Value],
        mut symbol: impl FnMut(&mut Graph, Symbol) -> Value,
    ) -> Vec<Value> {
        let mut images: IdMap<Value> = IdMap::default();
        for id in other.live(roots) {
            let new = match other.node(id) {
                Node::Symbol(s) => symbol(self, *s),
                node => self.rebuilt_from(node.clone(), |v| image(&images, v)),
            };
            images.insert(id, new);
        }
        roots.iter().map(|v| image(&images, *v)).collect()
    }

    /// A node through the constructors, with these values for its operands.
    fn rebuilt_from(&mut self, node: Node, of: impl Fn(Value) -> Value) -> Value {
        match node {
            Node::Symbol(symbol) => self.symbol(symbol),
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
    }
}
