//! Roots: where a value is finite and its derivatives are not, and where these have limits all the same.
//!
//! The derivative of |v| v by v_j is |v| e_j + v v_j/|v|, in which the second term has the limit 0 at v = 0, though
//! it is 0/0 there. The rule: where a factor f of a product f s vanishes, f ∂s is 0, however steep s is, for f
//! changes by O(h) and s by o(1) with a displacement h. It holds as well for a steep f (√x) and an s that is not
//! (|v|), and for F(s) with F′ = 0; but not if both are steep, as x^(1/3) √x is. The derivative of
//! |v| alone has no limit, and stays 0/0.

use super::{Comparison, Function, Graph, Id, Node, Number, Value, stable_map::IdMap};

/// Behaviour of a value near the zeros of the roots in it.
#[derive(Clone, Default)]
struct Near {
    /// Roots by which the value is divided, and negative powers.
    poles: Vec<Id>,
    /// The slope may be unbounded where the value is finite.
    steep: bool,
}

/// Derivatives of certain values, near the zeros of the roots in these.
pub struct Limits {
    /// There are roots.
    needed: bool,
    /// Bases by which the values themselves are divided: where these vanish, there is nothing to be continued.
    divisors: IdMap<()>,
    near: IdMap<Near>,
}

impl Limits {
    /// Limits of values without roots: derivatives stay as they are.
    pub fn none() -> Self {
        Limits { needed: false, divisors: IdMap::default(), near: IdMap::default() }
    }
}

const HALF: Number = Number::Ratio(1, 2);

impl Graph {
    /// The limits of derivatives of these values.
    pub fn limits(&self, values: &[Value]) -> Limits {
        let live = self.live(values);
        let needed = live.iter().any(|id| self.is_root(*id));
        Limits { needed, divisors: self.divisors(&live), near: IdMap::default() }
    }

    /// Are there states at which the values are finite, and have no derivatives since the argument of a root vanishes?
    pub fn has_roots(&self, values: &[Value]) -> bool {
        let live = self.live(values);
        let divisors = self.divisors(&live);
        live.iter().any(|id| {
            !self.is_fixed(*id) && self.is_root(*id) && !self.is_softened(*id) && divisors.get(id).is_none()
        })
    }

    /// The product of a slope and a partial derivative by `operand`, in a node that has finite values, as `product`:
    /// its limit 0 where that is known.
    pub fn continued(
        &mut self,
        limits: &mut Limits,
        node: Id,
        [operand, partial, slope, product]: [Value; 4],
    ) -> Value {
        if !limits.needed || self.near(limits, product).poles.is_empty() {
            return product;
        }
        let [of_operand, of_partial, of_slope] = [operand, partial, slope].map(|v| self.near(limits, v));
        let (steep_slope, steep_partial) = (!of_slope.poles.is_empty(), !of_partial.poles.is_empty());
        let moves = |v: Value| v.node.is_some_and(|id| !self.is_fixed(id));
        let vanishing = match *self.node(node) {
            Node::Inverse(_) => None,
            _ if steep_slope && !steep_partial && !(of_partial.steep && of_operand.steep) => Some(partial),
            // A power of u = O(h²) that is higher than √u is o(h).
            Node::Call(Function::powf, u, p)
                if !steep_slope && is_between(p, HALF, Number::ONE) && self.is_sum_of_squares(u) =>
            {
                Some(slope)
            }
            _ => None,
        };
        match vanishing.filter(|v| moves(*v)) {
            Some(factor) => self.select(Comparison::Equal, factor, Value::ZERO, Value::ZERO, product),
            None => product,
        }
    }

    /// The bases of all denominators.
    fn divisors(&self, live: &[Id]) -> IdMap<()> {
        let mut divisors = IdMap::default();
        for id in live {
            if let Node::Inverse(_) = self.node(*id) {
                self.factors(*id).iter().filter(|f| f.1 < 0).for_each(|f| {
                    divisors.insert(f.0, ());
                });
            }
        }
        divisors
    }

    /// A function with finite values and infinite or undefined slopes.
    fn is_root(&self, id: Id) -> bool {
        match *self.node(id) {
            Node::Call(
                Function::sqrt
                | Function::cbrt
                | Function::hypot
                | Function::asin
                | Function::acos
                | Function::acosh,
                ..,
            ) => true,
            Node::Call(Function::powf, _, p) => is_between(p, Number::ZERO, Number::from(64)),
            _ => false,
        }
    }

    /// Is the argument of a root at least a positive number?
    fn is_softened(&self, id: Id) -> bool {
        matches!(*self.node(id), Node::Call(_, u, _) if self.is_positive_sum(u, true))
    }

    /// Is u = O(h²) for displacements h from its zero?
    fn is_sum_of_squares(&self, u: Value) -> bool {
        self.is_positive_sum(u, false)
    }

    /// A sum of squares times numbers; with a constant term or without.
    fn is_positive_sum(&self, u: Value, constant: bool) -> bool {
        let (mut stack, mut found) = (vec![u], false);
        while let Some(term) = stack.pop() {
            if term.k.is_negative() {
                return false;
            }
            let Some(id) = term.node else {
                found = true;
                continue;
            };
            match *self.node(id) {
                Node::Sum(a, b) => stack.extend([a.scaled(term.k), b.scaled(term.k)]),
                _ => {
                    let factors = self.factors(id);
                    if !factors.iter().all(|&(base, e)| e % 2 == 0 || self.is_fixed(base)) {
                        return false;
                    }
                    found |= self.is_fixed(id);
                }
            }
        }
        found == constant
    }

    /// Behaviour of a value, which follows from that of its operands.
    fn near(&self, limits: &mut Limits, v: Value) -> Near {
        let Some(root) = v.node else { return Near::default() };
        let mut stack = vec![root];
        while let Some(&id) = stack.last() {
            let before = stack.len();
            let mut near = self.near_itself(limits, id);
            self.operands(id, |v| {
                let Some(below) = v.node else { return };
                match limits.near.get(&below) {
                    Some(known) => {
                        near.steep |= known.steep;
                        near.poles.extend(&known.poles);
                    }
                    None => stack.push(below),
                }
            });
            if stack.len() == before {
                near.poles.sort_unstable();
                near.poles.dedup();
                // The product has its limit there already.
                if let Node::Select(Comparison::Equal, values) = self.node(id)
                    && values[1].is_zero()
                    && values[2].is_zero()
                {
                    near.poles.retain(|pole| !self.vanishes_with(values[0], *pole));
                }
                limits.near.insert(id, near);
                stack.pop();
            }
        }
        limits.near.get(&root).cloned().unwrap_or_default()
    }

    fn near_itself(&self, limits: &Limits, id: Id) -> Near {
        let is_pole = |base: Id| self.is_root(base) && limits.divisors.get(&base).is_none();
        match *self.node(id) {
            Node::Inverse(_) => {
                let factors = self.factors(id);
                let poles = factors.iter().filter(|f| f.1 < 0 && is_pole(f.0)).map(|f| f.0);
                Near { poles: poles.collect(), steep: false }
            }
            Node::Call(Function::powf, _, p) if p.is_constant() && p.k.is_negative() => {
                Near { poles: vec![id], steep: false }
            }
            Node::Call(Function::sqrt, u, _) => Near { poles: vec![], steep: !self.is_sum_of_squares(u) },
            Node::Call(Function::powf, u, p) => {
                let flat = is_between(p, Number::ONE, Number::from(64))
                    || is_between(p, HALF, Number::ONE) && self.is_sum_of_squares(u);
                Near { poles: vec![], steep: !flat }
            }
            Node::Call(Function::hypot, ..) => Near::default(),
            _ => Near { poles: vec![], steep: self.is_root(id) },
        }
    }

    /// Does a value vanish wherever the argument of a root does?
    fn vanishes_with(&self, v: Value, root: Id) -> bool {
        let Node::Call(f, u, other) = *self.node(root) else { return false };
        if u.node.is_some_and(|u| self.is_root(u) && self.vanishes_with(v, u)) {
            return true;
        }
        let is_zero = |base: Id| {
            let value = Value::from(base);
            match *self.node(base) {
                _ if u.node == Some(base) || base == root => true,
                Node::Sum(a, b) => self.vanishes_with(a, root) && self.vanishes_with(b, root),
                // Another power of the same.
                Node::Call(Function::sqrt, of, _) if of.node == u.node => true,
                Node::Call(Function::powf, of, p) if of.node == u.node => !p.k.is_negative(),
                _ if f == Function::hypot => [u.node, other.node].contains(&value.node),
                _ => self.is_sum_of_squares(u) && self.has_square(u, base),
            }
        };
        v.is_zero() || v.node.is_some_and(|id| self.factors(id).iter().any(|f| f.1 > 0 && is_zero(f.0)))
    }

    /// Is one of the terms a square of this, times numbers?
    fn has_square(&self, u: Value, base: Id) -> bool {
        let mut stack = vec![u];
        while let Some(Value { node: Some(id), .. }) = stack.pop() {
            match *self.node(id) {
                Node::Sum(a, b) => stack.extend([a, b]),
                _ if self.factors(id).iter().all(|f| f.0 == base || self.is_fixed(f.0)) => return true,
                _ => {}
            }
        }
        false
    }
}

/// Is it a constant between two others?
fn is_between(v: Value, low: Number, high: Number) -> bool {
    v.is_constant() && v.k.compare(low).is_gt() && v.k.compare(high).is_lt()
}

#[cfg(test)]
mod tests {
    use super::super::Symbol;
    use super::*;

    const X: [Symbol; 2] = [Symbol::Coordinate(0), Symbol::Coordinate(1)];

    /// The derivatives of a value by x and y, at a point.
    fn slopes(g: &mut Graph, v: Value, at: [f64; 2]) -> [f64; 2] {
        X.map(|by| {
            let slope = g.forward_with_limits(&[v], |s| (s == by).then_some(Value::ONE))[0];
            g.evaluate(&[slope], |s| if s == X[0] { at[0] } else { at[1] })[0]
        })
    }

    /// x, y, x² + y² and √(x² + y²).
    fn plane(g: &mut Graph) -> [Value; 4] {
        let [x, y] = X.map(|s| g.symbol(s));
        let [xx, yy] = [x, y].map(|v| g.powi(v, 2));
        let square = g.add(xx, yy);
        [x, y, square, g.call(Function::sqrt, square)]
    }

    #[test]
    fn derivatives_have_their_limits_where_these_exist() {
        let g = &mut Graph::default();
        let [x, y, square, norm] = plane(g);
        let hypot = g.call2(Function::hypot, x, y);
        let power = |g: &mut Graph, v: Value, p: Number| g.call2(Function::powf, v, Value::constant(p));
        let of_power = [power(g, square, Number::Ratio(3, 4)), power(g, norm, Number::Ratio(17, 10))];
        let roots = [power(g, norm, Number::Ratio(3, 2)), power(g, norm, Number::Ratio(7, 10))];
        let root = g.call(Function::sqrt, norm);
        let sine = g.call(Function::sin, norm);
        let cosine = g.call(Function::cos, norm);
        let mut flat = vec![of_power[0], of_power[1], roots[0], cosine, g.powi(norm, 3)];
        for steep in [norm, hypot, of_power[0], root, roots[1], sine] {
            let product = g.mul(steep, x);
            let sum = g.add(x, y);
            flat.extend([product, g.mul(product, y), g.mul(steep, sum), g.mul(steep, norm)]);
        }
        flat.push(g.mul(root, norm));
        for (which, v) in flat.into_iter().enumerate() {
            assert_eq!(slopes(g, v, [0.0, 0.0]), [0.0, 0.0], "{which}");
            // Elsewhere nothing has changed.
            for at in [[0.3, 0.0], [0.0, -0.7], [0.4, 0.9]] {
                for (i, slope) in slopes(g, v, at).into_iter().enumerate() {
                    let value = |g: &Graph, d: f64| {
                        g.evaluate(&[v], |s| at[usize::from(s == X[1])] + if s == X[i] { d } else { 0.0 })[0]
                    };
                    let quotient = (value(g, 1e-6) - value(g, -1e-6)) / 2e-6;
                    assert!((slope - quotient).abs() < 1e-8, "{slope} {quotient} {at:?}");
                }
            }
        }
    }

    #[test]
    fn derivatives_without_a_limit_have_no_value() {
        let g = &mut Graph::default();
        let [x, y, square, norm] = plane(g);
        let direction = g.div(x, norm);
        let [cubic, root] = [Function::cbrt, Function::sqrt].map(|f| g.call(f, x));
        let both = g.mul(cubic, root);
        let one = g.add(norm, Value::ONE);
        let shifted = g.mul(norm, one);
        for v in [norm, direction, both, one, shifted, g.call2(Function::hypot, x, y)] {
            assert!(!slopes(g, v, [0.0, 0.0])[0].is_finite(), "{:?}", v.node.map(|id| g.node(id).clone()));
        }
        assert!(g.has_roots(&[norm]) && g.has_roots(&[both]) && !g.has_roots(&[direction]));
        let soft = g.add(square, Value::ONE);
        let soft = g.call(Function::sqrt, soft);
        assert!(!g.has_roots(&[soft, square]));
    }
}
