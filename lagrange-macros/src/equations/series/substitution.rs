//! Solution of the equations of all orders, as few sums of products by numbers of order 0.
//!
//! An elimination on the graph is linear in what is `Given`, and all else in it is known once a step: factors that
//! follow each other are multiplied then, and sums that are used once are part of the sum that uses them. A pivot's
//! row is left with one product for each thing that it depends on, none of which waits for another.

use crate::graph::{Graph, Node, Symbol, Value, stable_map::IdMap};

/// Factor that is multiplied by a number of order 0.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum Base {
    Given(usize),
    /// A sum found before.
    Row(usize),
}

/// A sum of products; what takes longest to be known comes last.
pub type Terms = Vec<(Value, Base)>;

/// Sums that others are made of, operands first, and the unknowns.
#[derive(Default)]
pub struct Substitution {
    rows: Vec<Terms>,
    unknowns: Vec<Terms>,
}

impl Substitution {
    /// Solves by the inverse: no unknown waits for another. Where the matrix is nearly singular, unknowns may be large
    /// and cancel; an inverse computes each of them by itself and loses the difference.
    pub fn explicit(g: &mut Graph, unknowns: &[Value]) -> Substitution {
        let mut inverse = vec![Terms::new(); unknowns.len()];
        for j in 0..unknowns.len() {
            let column = g.substitute(unknowns, |s| match s {
                Symbol::Given(i) => Some(if i == j { Value::ONE } else { Value::ZERO }),
                _ => None,
            });
            let entries = inverse.iter_mut().zip(column).filter(|(_, entry)| !entry.is_zero());
            entries.for_each(|(terms, entry)| terms.push((entry, Base::Given(j))));
        }
        Substitution { rows: Vec::new(), unknowns: inverse }
    }

    /// Substitution for unknowns that are linear in what is given; none where they are not.
    pub fn new(g: &mut Graph, unknowns: &[Value]) -> Option<Substitution> {
        let moved = g.dependent(unknowns, |s| matches!(s, Symbol::Given(_)));
        let live: Vec<_> = g.live(unknowns).into_iter().filter(|id| moved.get(id).is_some()).collect();
        let mut uses: IdMap<usize> = IdMap::default();
        let operands = |g: &Graph, id| {
            let mut operands = Vec::new();
            g.operands(id, |v| operands.extend(v.node));
            operands
        };
        let used = live.iter().flat_map(|id| operands(g, *id)).chain(unknowns.iter().filter_map(|v| v.node));
        used.for_each(|id| uses.count(id));

        let mut rows: Vec<Terms> = Vec::new();
        let mut sums: IdMap<Terms> = IdMap::default();
        for id in live {
            let mut sum = match *g.node(id) {
                Node::Symbol(Symbol::Given(i)) => vec![(Value::ONE, Base::Given(i))],
                Node::Sum(a, b) => {
                    let mut sum: Terms = Vec::new();
                    for operand in [a, b] {
                        let id = operand.node?;
                        let mut terms = sums.get(&id)?.clone();
                        // The same twice would be added to what may cancel it.
                        if terms.iter().any(|(_, base)| sum.iter().any(|(_, other)| base == other)) {
                            rows.push(std::mem::replace(
                                &mut terms,
                                vec![(Value::ONE, Base::Row(rows.len()))],
                            ));
                            sums.insert(id, terms.clone());
                        }
                        sum.extend(terms.iter().map(|&(number, base)| (number.scaled(operand.k), base)));
                    }
                    sum
                }
                Node::Product(a, b) => {
                    let (terms, number) = match (sums.get(&a), sums.get(&b)) {
                        (Some(terms), None) => (terms.clone(), b),
                        (None, Some(terms)) => (terms.clone(), a),
                        _ => return None,
                    };
                    terms.into_iter().map(|(by, base)| (g.mul(by, number.into()), base)).collect()
                }
                _ => return None,
            };
            sum.sort_by_key(|(_, base)| *base);
            if sum.len() > 1 && uses.get(&id).is_some_and(|uses| *uses > 1) {
                rows.push(std::mem::replace(&mut sum, vec![(Value::ONE, Base::Row(rows.len()))]));
            }
            sums.insert(id, sum);
        }
        let unknowns = unknowns.iter().map(|x| match x.node {
            Some(id) => {
                Some(sums.get(&id)?.iter().map(|&(number, base)| (number.scaled(x.k), base)).collect())
            }
            None => x.is_zero().then(Vec::new),
        });
        let unknowns = unknowns.collect::<Option<_>>()?;
        Some(Substitution { rows, unknowns })
    }

    /// The unknowns for what is given.
    pub fn solve(&self, g: &mut Graph, given: &[Value]) -> Vec<Value> {
        let rows = self.rows.len();
        let mut sums = vec![Value::ZERO; rows + self.unknowns.len()];
        for (place, (number, base)) in self.in_order() {
            let base = match base {
                Base::Given(i) => given[i],
                Base::Row(i) => sums[i],
            };
            let (number, base) = match base.node {
                Some(node) if !number.is_constant() => (g.whole(number.scaled(base.k)), node.into()),
                _ => (number, base),
            };
            sums[place] = g.plus_product(sums[place], number, base);
        }
        sums.split_off(rows)
    }

    /// All products with the places of their sums: those of the rows, and then those of the unknowns by what they are
    /// multiplied with, so that numbers of many unknowns are found side by side.
    fn in_order(&self) -> Vec<(usize, (Value, Base))> {
        let sums = self.rows.iter().chain(&self.unknowns).enumerate();
        let mut all: Vec<_> =
            sums.flat_map(|(place, terms)| terms.iter().map(move |term| (place, *term))).collect();
        let rows = self.rows.iter().map(Vec::len).sum::<usize>();
        all[rows..].sort_by_key(|(_, (_, base))| *base);
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `x = s/c`, `y = (a s + g₀) c`, where `s = b g₀ + g₁` is used twice.
    #[test]
    fn factors_are_multiplied_and_sums_kept() {
        let g = &mut Graph::default();
        let [a, b, c] = [0, 1, 2].map(|i| g.symbol(Symbol::Parameter(i)));
        let [x, y] = [0, 1].map(|i| g.symbol(Symbol::Given(i)));
        let product = g.mul(b, x);
        let s = g.add(product, y);
        let over = g.div(s, c);
        let scaled = g.mul(a, s);
        let sum = g.add(scaled, x);
        let other = g.mul(sum, c);
        let found = Substitution::new(g, &[over, -other]).unwrap();
        let row = Base::Row(0);
        assert_eq!(found.rows, [[(b, Base::Given(0)), (Value::ONE, Base::Given(1))]]);
        let (one_over, both) = (g.div(Value::ONE, c), g.mul(a, c));
        assert_eq!(found.unknowns, [vec![(one_over, row)], vec![(-c, Base::Given(0)), (-both, row)]]);
        let [p, q] = [2, 3].map(|i| g.symbol(Symbol::Given(i)));
        let solved = found.solve(g, &[p, q]);
        let at = |s| match s {
            Symbol::Parameter(i) => [2.0, 3.0, 0.5][i],
            Symbol::Given(i) => [0.0, 0.0, 5.0, 7.0][i],
            _ => f64::NAN,
        };
        assert_eq!(g.evaluate(&solved, at), [44.0, -24.5]);
    }

    #[test]
    fn what_is_not_linear_has_none() {
        let g = &mut Graph::default();
        let x = g.symbol(Symbol::Given(0));
        let (square, more) = (g.mul(x, x), g.add(x, Value::ONE));
        assert!(Substitution::new(g, &[square]).is_none() && Substitution::new(g, &[more]).is_none());
    }
}
