//! Fewer products of what moves, for recurrences in which these are dear and all else is cheap.
//!
//! The constructors keep the association in which products were first built, and do not multiply sums out nor take
//! factors out of them. Here a factor of several terms is taken out of a sum, `a b + a c = a (b + c)`, the one of
//! most terms first, which is Horner's form of a polynomial in several variables (Ceberio and Kreinovich, *ACM SIGSAM
//! Bull.* 38 (2004) 8); and products are associated so that the pairs of factors that most of them have are computed
//! once (Breuer, *Commun. ACM* 12 (1969) 333).

use super::{Graph, Id, Node, Symbol, Value, stable_map::IdMap};
use std::collections::BTreeMap;

/// A term of a sum, and the moving factors that may be taken out of it.
struct Term {
    value: Value,
    factors: Vec<(Id, i32)>,
}

/// A part of products.
enum Part {
    Factor(Id),
    /// The inverse of a product of powers.
    Under(Vec<(Id, i32)>),
    /// A product of two parts.
    Pair(usize, usize),
}

/// Expressions of more nodes stay as they are: the search for pairs takes the square of their number.
const MAX_GATHERED_NODES: usize = 500;

/// Higher powers stay as they are.
const MAX_GATHERED_POWER: i32 = 4;

impl Graph {
    /// The roots with the fewer products of what moves that are found so.
    pub fn gathered(&mut self, roots: &[Value]) -> Vec<Value> {
        if self.live(roots).len() > MAX_GATHERED_NODES {
            return roots.to_vec();
        }
        let roots = self.nested(roots);
        self.associated(&roots)
    }

    /// The roots with common factors taken out of sums.
    fn nested(&mut self, roots: &[Value]) -> Vec<Value> {
        let (mut uses, mut summed): (IdMap<usize>, IdMap<usize>) = Default::default();
        roots.iter().filter_map(|v| v.node).for_each(|n| uses.count(n));
        for id in self.live(roots) {
            let sum = matches!(self.node(id), Node::Sum(..));
            self.operands(id, |v| {
                if let Some(n) = v.node {
                    uses.count(n);
                    if sum {
                        summed.count(n);
                    }
                }
            });
        }
        let alone = |id: Id| uses.get(&id) == Some(&1);
        self.rewritten(roots, |g, id, node, image| {
            let Node::Sum(a, b) = *node else { return None };
            let inner = |g: &Graph, id: Id| {
                matches!(g.node(id), Node::Sum(..)) && alone(id) && summed.get(&id).is_some()
            };
            if inner(g, id) {
                return None;
            }
            let (mut terms, mut stack) = (Vec::new(), vec![b, a]);
            while let Some(v) = stack.pop() {
                match v.node {
                    Some(n) if inner(g, n) => {
                        let Node::Sum(a, b) = *g.node(n) else { continue };
                        stack.extend([b.scaled(v.k), a.scaled(v.k)]);
                    }
                    // What is used elsewhere is computed anyway, as a whole.
                    _ => terms.push(g.term(image(v), v.node.is_none_or(alone))),
                }
            }
            g.common_factor(&terms).is_some().then(|| g.horner(terms))
        })
    }

    fn term(&self, value: Value, apart: bool) -> Term {
        let factors = match value.node {
            None => Vec::new(),
            Some(id) if apart => self.factors(id).iter().copied().filter(|f| !self.is_fixed(f.0)).collect(),
            Some(id) => vec![(id, 1)],
        };
        Term { value, factors }
    }

    /// The base that most terms have in common, with its sign, if two have one.
    fn common_factor(&self, terms: &[Term]) -> Option<(Id, i32)> {
        let mut counts: BTreeMap<(Id, i32), usize> = BTreeMap::new();
        for term in terms {
            for &(base, e) in &term.factors {
                *counts.entry((base, e.signum())).or_default() += 1;
            }
        }
        let most = counts.values().copied().max().filter(|most| *most > 1)?;
        counts.into_iter().find(|(_, count)| *count == most).map(|(factor, _)| factor)
    }

    fn horner(&mut self, terms: Vec<Term>) -> Value {
        let Some((base, sign)) = self.common_factor(&terms) else {
            return terms.iter().fold(Value::ZERO, |sum, term| self.add(sum, term.value));
        };
        let has = |term: &Term| term.factors.iter().any(|f| f.0 == base && f.1.signum() == sign);
        let (with, without): (Vec<Term>, Vec<Term>) = terms.into_iter().partition(has);
        let divided = |term: &Term| {
            // Of what is not taken apart the base is all there is.
            let whole = term.value.node == Some(base);
            let value = match term.value.node {
                Some(id) if !whole => {
                    let factors = self.factors(id);
                    self.without(&factors, &[(base, sign)]).scaled(term.value.k)
                }
                _ => Value::constant(term.value.k),
            };
            self.term(value, true)
        };
        let with: Vec<Term> = with.iter().map(divided).collect();
        let (inner, rest) = (self.horner(with), self.horner(without));
        let base = if sign > 0 { base.into() } else { self.recip(base.into()) };
        let product = self.mul(base, inner);
        self.add(product, rest)
    }

    /// The roots with products associated so that they share parts.
    fn associated(&mut self, roots: &[Value]) -> Vec<Value> {
        let live = self.live(roots);
        let is_product =
            |g: &Graph, id: Id| matches!(g.node(id), Node::Product(..)) && g.monomials[id.index()].is_some();
        let mut wanted: IdMap<()> = IdMap::default();
        roots.iter().filter_map(|v| v.node).for_each(|n| wanted.insert(n, ()));
        for &id in &live {
            if !is_product(self, id) {
                self.operands(id, |v| v.node.into_iter().for_each(|n| wanted.insert(n, ())));
            }
        }
        let mut parts: Vec<Part> = Vec::new();
        let mut places: BTreeMap<Vec<(Id, i32)>, usize> = BTreeMap::new();
        let mut place = |key: Vec<(Id, i32)>| {
            *places.entry(key.clone()).or_insert_with(|| {
                parts.push(if let [(base, 1)] = key[..] { Part::Factor(base) } else { Part::Under(key) });
                parts.len() - 1
            })
        };
        let (mut products, mut plans): (Vec<Vec<usize>>, IdMap<usize>) = Default::default();
        for &id in &live {
            if wanted.get(&id).is_none() || self.is_fixed(id) || !is_product(self, id) {
                continue;
            }
            let moving: Vec<(Id, i32)> =
                self.factors(id).iter().copied().filter(|f| !self.is_fixed(f.0)).collect();
            if moving.iter().any(|f| f.1 > MAX_GATHERED_POWER) {
                continue;
            }
            let (over, under): (Vec<_>, Vec<_>) = moving.into_iter().partition(|f| f.1 > 0);
            let mut product: Vec<usize> = Vec::new();
            for (base, e) in over {
                product.extend(std::iter::repeat_n(place(vec![(base, 1)]), e as usize));
            }
            if !under.is_empty() {
                product.push(place(under));
            }
            plans.insert(id, products.len());
            products.push(product);
        }
        // The rate of a function of a coordinate is a product, too.
        for &id in &live {
            let Node::Call(_, Value { node: Some(argument), .. }, _) = *self.node(id) else { continue };
            let Node::Symbol(Symbol::Coordinate(i)) = *self.node(argument) else { continue };
            if let [(_, Value { node: Some(slope), .. })] = self.partials(id)[..]
                && !self.is_fixed(slope)
                && let Some(velocity) = self.symbol(Symbol::Velocity(i)).node
            {
                products.push(vec![place(vec![(velocity, 1)]), place(vec![(slope, 1)])]);
            }
        }
        share(&mut products, &mut parts);

        let mut made: Vec<Option<Value>> = parts.iter().map(|_| None).collect();
        self.rewritten(roots, |g, id, _, image| {
            let product = products.get(*plans.get(&id)?)?;
            let moving = product.iter().fold(Value::ONE, |so_far, &at| {
                let part = g.part(&parts, at, &mut made, image);
                g.joined(so_far, part)
            });
            let fixed: Vec<(Id, i32)> = g.factors(id).iter().copied().filter(|f| g.is_fixed(f.0)).collect();
            let fixed = if fixed.is_empty() { Value::ONE } else { g.assemble(&fixed) };
            Some(g.joined(fixed, moving))
        })
    }

    /// A part, made of what has become of its factors.
    fn part(
        &mut self,
        parts: &[Part],
        at: usize,
        made: &mut Vec<Option<Value>>,
        image: &dyn Fn(Value) -> Value,
    ) -> Value {
        if let Some(value) = made[at] {
            return value;
        }
        let value = match &parts[at] {
            Part::Factor(id) => image((*id).into()),
            Part::Under(factors) => {
                let mut product = Value::ONE;
                for &(base, e) in factors {
                    let power = self.powi(image(base.into()), -e);
                    product = self.mul(product, power);
                }
                // In this association, too: the square of what is inverted may be wanted elsewhere.
                match product.node {
                    Some(id) => Value::from(self.intern(Node::Inverse(id))).scaled(product.k.recip()),
                    None => self.recip(product),
                }
            }
            &Part::Pair(a, b) => {
                let (a, b) = (self.part(parts, a, made, image), self.part(parts, b, made, image));
                self.joined(a, b)
            }
        };
        made[at] = Some(value);
        value
    }

    /// A product in this association.
    fn joined(&mut self, a: Value, b: Value) -> Value {
        if a.node <= b.node { self.times(a, b) } else { self.times(b, a) }
    }
}

/// Makes parts of the pairs that most products have, until no two have one and no factor is there twice.
fn share(products: &mut [Vec<usize>], parts: &mut Vec<Part>) {
    loop {
        let mut counts: BTreeMap<[usize; 2], usize> = BTreeMap::new();
        for product in products.iter_mut() {
            product.sort_unstable();
            let mut pairs: Vec<[usize; 2]> = Vec::new();
            for (i, &a) in product.iter().enumerate() {
                pairs.extend(product[i + 1..].iter().map(|&b| [a, b]));
            }
            pairs.sort_unstable();
            pairs.dedup();
            pairs.into_iter().for_each(|pair| *counts.entry(pair).or_default() += 1);
        }
        let most = counts.values().copied().max().unwrap_or(0);
        // A square costs half of what another product does.
        let pays = |&[a, b]: &[usize; 2]| most > 1 || a == b;
        let Some((&[a, b], _)) = counts.iter().find(|(pair, count)| **count == most && pays(pair)) else {
            return;
        };
        let pair = parts.len();
        parts.push(Part::Pair(a, b));
        for product in products.iter_mut() {
            let first = product.iter().position(|&at| at == a);
            let second = product.iter().rposition(|&at| at == b);
            if let (Some(first), Some(second)) = (first, second)
                && first != second
            {
                product.remove(second.max(first));
                product.remove(second.min(first));
                product.push(pair);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Function;
    use super::*;

    /// Number of products of variables in the roots.
    fn products(g: &Graph, roots: &[Value]) -> usize {
        let moves = |id: Id| !g.is_fixed(id);
        let live = g.live(roots).into_iter();
        live.filter(|id| matches!(*g.node(*id), Node::Product(a, b) if moves(a) && moves(b))).count()
    }

    fn product(g: &mut Graph, factors: &[Value]) -> Value {
        factors.iter().fold(Value::ONE, |so_far, factor| g.mul(so_far, *factor))
    }

    fn assert_gathered(g: &mut Graph, roots: &[Value], before: usize, after: usize) {
        let gathered = g.gathered(roots);
        assert_eq!((products(g, roots), products(g, &gathered)), (before, after));
        let at = |s| match s {
            Symbol::Coordinate(i) => [2.0, -3.0, 5.0, 0.5][i],
            Symbol::Velocity(i) => [-7.0, 11.0, 1.5][i],
            _ => 0.25,
        };
        // Small numbers, of which no sum is rounded.
        assert_eq!(g.evaluate(roots, at), g.evaluate(&gathered, at));
    }

    #[test]
    fn common_factors_are_taken_out() {
        let g = &mut Graph::default();
        let [x, y, z, w] = [0, 1, 2, 3].map(|i| g.symbol(Symbol::Coordinate(i)));
        let m = g.symbol(Symbol::Parameter(0));
        // x y z − 3 m x w + x y² = x (y (z + y) − 3 m w)
        let terms =
            [product(g, &[x, y, z]), product(g, &[m, x, w]).scaled((-3).into()), product(g, &[x, y, y])];
        let sum = terms.into_iter().fold(Value::ZERO, |sum, term| g.add(sum, term));
        assert_gathered(g, &[sum], 4, 2);
        // Not out of what is computed anyway: x y + x z stays where x y is wanted, too.
        let [xy, xz] = [y, z].map(|v| g.mul(x, v));
        let sum = g.add(xy, xz);
        assert_gathered(g, &[sum, xy, xz], 2, 2);
    }

    #[test]
    fn products_share_their_parts() {
        let g = &mut Graph::default();
        let [x, y, z, w] = [0, 1, 2, 3].map(|i| g.symbol(Symbol::Coordinate(i)));
        // (x w) / y and z (w / y) of the fraction that both have
        let over = g.recip(y);
        let (a, b) = (product(g, &[x, w, over]), product(g, &[z, w, over]));
        let sine = g.call(Function::sin, b);
        assert_gathered(g, &[a, sine], 4, 3);
    }

    #[test]
    fn squares_come_first() {
        let g = &mut Graph::default();
        let [x, y] = [0, 1].map(|i| g.symbol(Symbol::Coordinate(i)));
        let (all, over) = (product(g, &[y, x, x]), product(g, &[x, x]));
        let over = g.recip(over);
        let gathered = g.gathered(&[all, over]);
        let square = |id: &Id| matches!(*g.node(*id), Node::Product(a, b) if a == b);
        // x² y of the square that 1/x² is the inverse of.
        assert_eq!(
            (products(g, &gathered), g.live(&gathered).iter().filter(|id| square(id)).count()),
            (2, 1)
        );
    }

    #[test]
    fn rates_of_functions_are_products() {
        let g = &mut Graph::default();
        let (x, v, w) =
            (g.symbol(Symbol::Coordinate(0)), g.symbol(Symbol::Velocity(0)), g.symbol(Symbol::Velocity(1)));
        let (sine, cosine) = (g.call(Function::sin, x), g.call(Function::cos, x));
        // Of w v cos x the product v cos x is the rate of sin x.
        let (wv, rest) = (g.mul(w, v), g.mul(sine, w));
        let all = g.mul(wv, cosine);
        let gathered = g.gathered(&[all, rest]);
        let rate = Node::Product(
            v.node.unwrap().min(cosine.node.unwrap()),
            v.node.unwrap().max(cosine.node.unwrap()),
        );
        assert!(g.live(&gathered).into_iter().any(|id| *g.node(id) == rate));
    }
}
