//! Proof that an expression is identically zero: it is multiplied out to a polynomial in its irreducible parts, with
//! sums of angles expanded and sin² replaced by 1 − cos². `None` and `false` mean "not proved".
//!
//! Facts rest on it (is this coordinate ignorable?). For small systems it is also one of the forms that are tried:
//! multiplied-out expressions are long as a rule, but where most terms cancel, as in a rotating frame, they are the
//! short ones, and free of the rounding errors of what cancels. There sin² is not replaced, since 1 − cos² would cancel
//! near 0; instead like terms in sin² and cos² are paired.

use super::{Function, Graph, Id, Node, Number, Value, stable_map::IdMap};
use std::collections::BTreeMap;

/// Sums longer than this are not multiplied out.
const MAX_MULTIPLIED_TERMS: usize = 400;

/// Nor are higher powers of a sine written out.
const MAX_POWER: i32 = 24;

/// A way to multiply out.
#[derive(Clone, Copy)]
pub struct Expansion {
    /// Expand sines and cosines of sums of angles.
    pub angles: bool,
    /// Terms that differ in their sines and cosines alone stand together: their sum is often that of an angle which
    /// other terms have too.
    pub grouped: bool,
}

impl Expansion {
    pub fn name(self) -> &'static str {
        match (self.angles, self.grouped) {
            (false, false) => "multiplied out",
            (true, false) => "multiplied out, sums of angles expanded",
            (false, true) => "multiplied out, terms grouped",
            (true, true) => "multiplied out, sums of angles expanded, terms grouped",
        }
    }
}

/// All ways; none is always the shortest.
pub const EXPANSIONS: [Expansion; 4] = [
    Expansion { angles: false, grouped: false },
    Expansion { angles: true, grouped: false },
    Expansion { angles: false, grouped: true },
    Expansion { angles: true, grouped: true },
];

/// Monomials (factors with exponents, sorted) and their coefficients.
#[derive(Clone, Default)]
struct Polynomial(BTreeMap<Vec<(Id, i32)>, Number>);

impl Polynomial {
    fn constant(k: Number) -> Polynomial {
        let mut p = Polynomial::default();
        p.plus(Vec::new(), k);
        p
    }

    fn power(base: Id, exponent: i32) -> Polynomial {
        Polynomial(BTreeMap::from([(vec![(base, exponent)], Number::ONE)]))
    }

    fn plus(&mut self, monomial: Vec<(Id, i32)>, k: Number) {
        let total = self.0.get(&monomial).map_or(k, |before| before.add(k));
        if total.is_zero() {
            self.0.remove(&monomial);
        } else {
            self.0.insert(monomial, total);
        }
    }

    fn scaled(mut self, k: Number) -> Polynomial {
        self.0.values_mut().for_each(|c| *c = c.mul(k));
        self.0.retain(|_, c| !c.is_zero());
        self
    }

    fn add(mut self, other: Polynomial, longest: usize) -> Option<Polynomial> {
        for (monomial, k) in other.0 {
            self.plus(monomial, k);
        }
        (self.0.len() <= longest).then_some(self)
    }
}

impl Graph {
    /// Is the expression proved to be zero, whatever its symbols are?
    pub fn vanishes(&mut self, v: Value) -> bool {
        v.is_zero()
            || v.node.is_some()
                && !self.differs_from_zero(v)
                && (self.vanishes_as_rational(v)
                    || self
                        .multiplied_out(&[v], true, MAX_MULTIPLIED_TERMS, true)
                        .is_some_and(|p| p[0].0.is_empty()))
    }

    /// The terms of a value multiplied out, with sums of angles expanded: factors with exponents, and a number.
    pub fn monomials(&mut self, v: Value) -> Option<Vec<(Vec<(Id, i32)>, Number)>> {
        let polynomial = self.multiplied_out(&[v], true, MAX_MULTIPLIED_TERMS, true)?.pop()?;
        Some(polynomial.0.into_iter().collect())
    }

    /// The values multiplied out, where that gives no more than so many terms for each.
    pub fn expanded(&mut self, values: &[Value], longest: usize, how: Expansion) -> Option<Vec<Value>> {
        let polynomials = self.multiplied_out(values, how.angles, 2 * longest, false)?;
        if polynomials.iter().any(|p| p.0.len() > longest) {
            return None;
        }
        Some(polynomials.into_iter().map(|p| self.rebuilt(p, how.grouped)).collect())
    }

    /// A polynomial as a node.
    fn rebuilt(&mut self, polynomial: Polynomial, grouped: bool) -> Value {
        let mut groups: BTreeMap<Vec<(Id, i32)>, Value> = BTreeMap::new();
        for (monomial, k) in polynomial.0 {
            let circular = |f: &(Id, i32)| {
                grouped && matches!(self.node(f.0), Node::Call(Function::sin | Function::cos, ..))
            };
            let (angles, others): (Vec<_>, Vec<_>) = monomial.into_iter().partition(circular);
            let term = self.monomial(&angles).scaled(k);
            let sum = groups.entry(others).or_insert(Value::ZERO);
            *sum = self.add(*sum, term);
        }
        let mut total = Value::ZERO;
        for (others, sum) in groups {
            let others = self.monomial(&others);
            let term = self.mul(others, sum);
            total = self.add(total, term);
        }
        total
    }

    fn monomial(&mut self, factors: &[(Id, i32)]) -> Value {
        if factors.is_empty() { Value::ONE } else { self.assemble(factors) }
    }

    /// The roots as polynomials, given up where one on the way has more terms than `longest`.
    fn multiplied_out(
        &mut self,
        roots: &[Value],
        angles: bool,
        longest: usize,
        reduce: bool,
    ) -> Option<Vec<Polynomial>> {
        let mut done: IdMap<Polynomial> = IdMap::default();
        for id in self.live(roots) {
            let p = match self.node(id).clone() {
                Node::Sum(a, b) => {
                    let sum = self.operand(&done, a)?.add(self.operand(&done, b)?, longest)?;
                    if reduce { sum } else { self.paired(sum) }
                }
                Node::Product(a, b) => {
                    let (a, b) = (self.operand(&done, a.into())?, self.operand(&done, b.into())?);
                    self.multiply(&a, &b, longest, reduce)?
                }
                Node::Inverse(a) => {
                    let p = self.operand(&done, a.into())?;
                    match p.0.first_key_value() {
                        Some((monomial, k)) if p.0.len() == 1 => {
                            let inverted = monomial.iter().map(|&(base, e)| (base, -e)).collect();
                            Polynomial(BTreeMap::from([(inverted, k.recip())]))
                        }
                        _ => Polynomial::power(a, -1),
                    }
                }
                Node::Call(f @ (Function::sin | Function::cos), angle, _) if angles => {
                    let (sine, cosine) = self.circular(angle, longest, reduce, 0)?;
                    if f == Function::sin { sine } else { cosine }
                }
                _ => Polynomial::power(id, 1),
            };
            done.insert(id, p);
        }
        roots.iter().map(|root| self.operand(&done, *root)).collect()
    }

    fn operand(&self, done: &IdMap<Polynomial>, v: Value) -> Option<Polynomial> {
        match v.node {
            None => Some(Polynomial::constant(v.k)),
            Some(n) => Some(done.get(&n)?.clone().scaled(v.k)),
        }
    }

    /// Sine and cosine of an angle, sums of angles and small multiples expanded.
    fn circular(
        &mut self,
        angle: Value,
        longest: usize,
        reduce: bool,
        depth: u32,
    ) -> Option<(Polynomial, Polynomial)> {
        if depth > 12 {
            return None;
        }
        let halves = match (angle.k.integer(), angle.node.map(|n| self.node(n).clone())) {
            (Some(k), _) if k.abs() > 1 && k.abs() <= 6 => {
                let one = Value { k: k.signum().into(), ..angle };
                Some((one, Value { k: (k - k.signum()).into(), ..angle }))
            }
            (_, Some(Node::Sum(a, b))) => Some((a.scaled(angle.k), b.scaled(angle.k))),
            _ => None,
        };
        let Some((a, b)) = halves else {
            let positive = if angle.k.is_negative() { -angle } else { angle };
            let mut atom = |f| {
                let value = self.call(f, positive);
                match value.node {
                    Some(id) => Polynomial::power(id, 1).scaled(value.k),
                    None => Polynomial::constant(value.k),
                }
            };
            let (sine, cosine) = (atom(Function::sin), atom(Function::cos));
            return Some(if angle.k.is_negative() {
                (sine.scaled(Number::MINUS_ONE), cosine)
            } else {
                (sine, cosine)
            });
        };
        let ((sa, ca), (sb, cb)) =
            (self.circular(a, longest, reduce, depth + 1)?, self.circular(b, longest, reduce, depth + 1)?);
        let sine = self
            .multiply(&sa, &cb, longest, reduce)?
            .add(self.multiply(&ca, &sb, longest, reduce)?, longest)?;
        let cosine = self.multiply(&ca, &cb, longest, reduce)?;
        let cosine =
            cosine.add(self.multiply(&sa, &sb, longest, reduce)?.scaled(Number::MINUS_ONE), longest)?;
        Some((sine, cosine))
    }

    fn multiply(
        &mut self,
        a: &Polynomial,
        b: &Polynomial,
        longest: usize,
        reduce: bool,
    ) -> Option<Polynomial> {
        if a.0.len() * b.0.len() > 4 * longest {
            return None;
        }
        let mut product = Polynomial::default();
        for (x, j) in &a.0 {
            for (y, k) in &b.0 {
                let mut factors: BTreeMap<Id, i32> = x.iter().copied().collect();
                for &(base, e) in y {
                    *factors.entry(base).or_default() += e;
                }
                factors.retain(|_, e| *e != 0);
                let k = j.mul(*k);
                let term = if reduce {
                    self.reduced(factors, k)?
                } else {
                    Polynomial(BTreeMap::from([(factors.into_iter().collect(), k)]))
                };
                product = product.add(term, longest)?;
            }
        }
        Some(if reduce { product } else { self.paired(product) })
    }

    /// Like terms in sin² and cos² joined without a difference that could cancel: of `j X sin² + k X cos²` with equal
    /// signs the smaller coefficient goes to X; `k X − k X sin²` is `k X cos²`, and the other way round.
    fn paired(&mut self, mut p: Polynomial) -> Polynomial {
        'again: loop {
            for (monomial, &k) in &p.0 {
                let squares = monomial.iter().filter(|f| f.1 >= 2).map(|f| f.0);
                for base in squares {
                    let Node::Call(f @ (Function::sin | Function::cos), angle, _) = *self.node(base) else {
                        continue;
                    };
                    let other = if f == Function::sin { Function::cos } else { Function::sin };
                    let Some(partner) = self.call(other, angle).node else { continue };
                    let without = changed(monomial, base, -2);
                    let with_partner = changed(&without, partner, 2);
                    if let Some(&j) = p.0.get(&with_partner).filter(|j| j.is_negative() == k.is_negative()) {
                        let least = if j.abs().compare(k.abs()).is_lt() { j } else { k };
                        let monomial = monomial.clone();
                        p.plus(monomial, least.neg());
                        p.plus(with_partner, least.neg());
                        p.plus(without, least);
                        continue 'again;
                    }
                    if p.0.get(&without) == Some(&k.neg()) {
                        let monomial = monomial.clone();
                        p.plus(monomial, k.neg());
                        p.plus(without, k);
                        p.plus(with_partner, k.neg());
                        continue 'again;
                    }
                }
            }
            return p;
        }
    }

    /// A monomial with even powers of sines written out: `sin²ᵖ = Σⱼ (p over j) (−cos²)ʲ`.
    fn reduced(&mut self, mut factors: BTreeMap<Id, i32>, k: Number) -> Option<Polynomial> {
        let high = factors.iter().find_map(|(&base, &e)| match *self.node(base) {
            Node::Call(Function::sin, angle, _) if e >= 2 => Some((base, angle, e)),
            _ => None,
        });
        let Some((base, angle, e)) = high else {
            return Some(Polynomial(BTreeMap::from([(factors.into_iter().collect(), k)])));
        };
        if e > MAX_POWER {
            return None;
        }
        factors.remove(&base);
        if e % 2 == 1 {
            factors.insert(base, 1);
        }
        let cosine = self.call(Function::cos, angle).node?;
        let mut sum = Polynomial::default();
        let mut binomial = k;
        for j in 0..=e / 2 {
            let mut term = factors.clone();
            *term.entry(cosine).or_default() += 2 * j;
            term.retain(|_, e| *e != 0);
            sum = sum.add(self.reduced(term, binomial)?, MAX_MULTIPLIED_TERMS)?;
            // (p over j+1) = (p over j) (p − j)/(j + 1), with the sign of the next power
            binomial =
                binomial.mul(Number::from(i64::from(j - e / 2))).mul(Number::from(i64::from(j + 1)).recip());
        }
        Some(sum)
    }
}

/// A monomial with the exponent of one factor changed.
fn changed(monomial: &[(Id, i32)], base: Id, by: i32) -> Vec<(Id, i32)> {
    let mut factors: BTreeMap<Id, i32> = monomial.iter().copied().collect();
    *factors.entry(base).or_default() += by;
    factors.retain(|_, e| *e != 0);
    factors.into_iter().collect()
}

#[cfg(test)]
mod tests {
    use super::super::Symbol;
    use super::*;

    #[test]
    fn identities_are_proved() {
        let g = &mut Graph::default();
        let (a, b) = (g.symbol(Symbol::Coordinate(0)), g.symbol(Symbol::Coordinate(1)));
        let d = g.sub(a, b);
        let [ca, cb, cd] = [a, b, d].map(|x| g.call(Function::cos, x));
        let [sa, sb] = [a, b].map(|x| g.call(Function::sin, x));
        let (cc, ss) = (g.mul(ca, cb), g.mul(sa, sb));
        let expanded = g.add(cc, ss);
        let difference = g.sub(cd, expanded);
        assert!(g.vanishes(difference));
        let wrong = g.sub(cd, cc);
        assert!(!g.vanishes(wrong));
        // sin⁴ − cos⁴ − sin² + cos² = 0
        let terms = [(sa, 4, 1), (ca, 4, -1), (sa, 2, -1), (ca, 2, 1)];
        let mut sum = Value::ZERO;
        for (x, n, k) in terms {
            let power = g.powi(x, n).scaled(k.into());
            sum = g.add(sum, power);
        }
        assert!(g.vanishes(sum));
    }

    /// Identities of multiples, parts and sums of angles are proved by values in a finite field, where sines and
    /// cosines are points of a circle, however long the terms are; and nothing else is.
    #[test]
    fn identities_of_angles_are_proved_by_values() {
        let g = &mut Graph::default();
        let [a, b] = [0, 1].map(|i| g.symbol(Symbol::Coordinate(i)));
        let both = |g: &mut Graph, x: Value| (g.call(Function::cos, x), g.call(Function::sin, x));
        // cos(3a) = 4 cos³ a − 3 cos a, sin(a/2) cos(a/2) = ½ sin a
        let (c, s) = both(g, a);
        let (cubed, half) = (g.powi(c, 3).scaled(4.into()), a.scaled(Number::Ratio(1, 2)));
        let (c3, _) = both(g, a.scaled(3.into()));
        let cubed = g.sub(cubed, c.scaled(3.into()));
        let difference = g.sub(c3, cubed);
        assert!(g.vanishes_as_rational(difference));
        let (ch, sh) = both(g, half);
        let product = g.mul(ch, sh);
        let difference = g.sub(product, s.scaled(Number::Ratio(1, 2)));
        assert!(g.vanishes_as_rational(difference));
        // (cos a + sin b)² − cos² a − 2 cos a sin b + cos² b = 1
        let (cb, sb) = both(g, b);
        let sum = g.add(c, sb);
        let mut rest = g.powi(sum, 2);
        let cross = g.mul(c, sb).scaled(2.into());
        let squares = [g.powi(c, 2), cross];
        for term in squares {
            rest = g.sub(rest, term);
        }
        let square = g.powi(cb, 2);
        rest = g.add(rest, square);
        let one = g.sub(rest, Value::ONE);
        assert!(g.vanishes_as_rational(one));
        let other = g.sub(rest, cb);
        assert!(!g.vanishes_as_rational(other));
        // A multiple that is no ratio has an angle of its own.
        let (near, _) = both(g, a.scaled(Number::Float((1.0f64 + 1e-15).to_bits(), 0)));
        let difference = g.sub(near, c);
        assert!(!g.vanishes_as_rational(difference));
    }
}
