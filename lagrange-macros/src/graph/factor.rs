//! Fewer multiplications by numbers of the parameters: k X + k Y = k (X + Y), where nothing else uses either product.
//!
//! Constructors cannot know what else will use a product, and one that is shared would be computed twice. Nor is it
//! always a gain: a product with k (X + Y) collects its numbers, k (Z (X + Y)), so that each of several such products
//! is multiplied by k.

use super::{Graph, Id, Node, Value, stable_map::IdMap};

impl Graph {
    /// The roots with what both terms of a sum have of parameters taken out of it, in sums that are factors of at
    /// most so many products; none if there is no such sum.
    pub fn factored(&mut self, roots: &[Value], products: usize) -> Option<Vec<Value>> {
        let (mut uses, mut multiplied): (IdMap<usize>, IdMap<usize>) = Default::default();
        roots.iter().filter_map(|v| v.node).for_each(|n| uses.count(n));
        for id in self.live(roots) {
            let multiplies = matches!(self.node(id), Node::Product(..) | Node::Inverse(_));
            self.operands(id, |v| {
                if let Some(n) = v.node {
                    uses.count(n);
                    if multiplies {
                        multiplied.count(n);
                    }
                }
            });
        }
        let alone = |v: Value| v.node.is_some_and(|n| uses.get(&n) == Some(&1));
        let mut any = false;
        let roots = self.rewritten(roots, |g, id, node, image| {
            let Node::Sum(a, b) = *node else { return None };
            if !(alone(a) && alone(b)) || multiplied.get(&id).is_some_and(|n| *n > products) {
                return None;
            }
            let (a, b) = (image(a), image(b));
            let ((k, x), (l, y)) = (g.scaled_by_parameters(a)?, g.scaled_by_parameters(b)?);
            if k != l {
                return None;
            }
            any = true;
            let sum = g.add(x, y);
            Some(g.mul(k.into(), sum))
        });
        any.then_some(roots)
    }

    /// A product as what parameters alone decide and the rest.
    fn scaled_by_parameters(&self, v: Value) -> Option<(Id, Value)> {
        let Node::Product(a, b) = *self.node(v.node?) else { return None };
        let (k, x) = match (self.is_fixed(a), self.is_fixed(b)) {
            (true, false) => (a, b),
            (false, true) => (b, a),
            _ => return None,
        };
        Some((k, Value { node: Some(x), ..v }))
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Symbol, Value};
    use super::*;

    /// m x, m y, and a sum of them.
    fn terms(g: &mut Graph) -> [Value; 3] {
        let symbols = [Symbol::Parameter(0), Symbol::Coordinate(0), Symbol::Coordinate(1)];
        let [m, x, y] = symbols.map(|s| g.symbol(s));
        let (a, b) = (g.mul(m, x), g.mul(m, y).scaled(3.into()));
        [a, b, g.sub(a, b)]
    }

    #[test]
    fn a_common_factor_is_multiplied_by_once() {
        let g = &mut Graph::default();
        let [_, _, sum] = terms(g);
        let factored = g.factored(&[sum], 0).unwrap()[0];
        let product = g.node(factored.node.unwrap());
        assert!(matches!(product, Node::Product(m, _) if g.is_fixed(*m)), "{product:?}");
        let at = |s| {
            if s == Symbol::Parameter(0) {
                0.5
            } else if s == Symbol::Coordinate(0) {
                2.0
            } else {
                7.0
            }
        };
        assert_eq!(g.evaluate(&[sum, factored], at), [-9.5, -9.5]);
    }

    #[test]
    fn factors_of_many_products_stay() {
        let g = &mut Graph::default();
        let [_, _, sum] = terms(g);
        let others = [2, 3].map(|i| g.symbol(Symbol::Coordinate(i)));
        let products = others.map(|z| g.mul(z, sum));
        assert_eq!(g.factored(&products, 1), None);
        assert!(g.factored(&products, 2).is_some());
    }

    #[test]
    fn what_is_used_elsewhere_stays() {
        let g = &mut Graph::default();
        let [a, _, sum] = terms(g);
        assert_eq!(g.factored(&[a, sum], 0), None);
    }
}
