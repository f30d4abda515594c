//! Canonical constructors: all simplification that happens without being asked for.
//!
//! - equal terms merge, constants fold, `k X sin² + k X cos² → k X`, also with a term two levels down in a sum;
//! - terms that differ in factors of the parameters alone merge, `m₁ X + m₂ X → (m₁ + m₂) X`;
//! - one node per product however it is associated, powers merge and cancel, `√x √x → x`, `|x| |x| → x²`;
//! - odd and even functions shed signs; exact values (sin 0, √4, …) fold.
//!
//! Each rule keeps or lowers the number of operations even when its operands are shared.

use super::{Comparison, Function, Graph, Id, Monomial, Node, Number, Value, stable_map::StableMap};
use std::rc::Rc;

/// Depth in a sum to which like terms are searched.
const MAX_SEARCHED_LEVELS: usize = 2;
/// Products of more distinct factors are not canonicalised.
const MAX_FACTORS: usize = 24;
/// Nor are larger exponents.
const MAX_EXPONENT: i32 = 1 << 20;

/// Nodes divided by monomials, while one quotient is made.
type Quotients = StableMap<(Id, Monomial), Value>;

impl Graph {
    pub fn add(&mut self, a: Value, b: Value) -> Value {
        if a.is_zero() {
            return b;
        }
        if b.is_zero() {
            return a;
        }
        if a.node == b.node {
            return Value { k: a.k.add(b.k), node: a.node }.scaled(Number::ONE);
        }
        if let Some(sum) = self.pythagoras(a, b).or_else(|| self.collect(a, b)) {
            return sum;
        }
        if let Some(sum) =
            self.absorb(a, b, MAX_SEARCHED_LEVELS).or_else(|| self.absorb(b, a, MAX_SEARCHED_LEVELS))
        {
            return sum;
        }
        // The constant, or the younger node, last.
        let (a, b) = match (a.node, b.node) {
            (None, _) => (b, a),
            (Some(x), Some(y)) if y < x => (b, a),
            _ => (a, b),
        };
        if !b.is_constant() && a.k.abs() == b.k.abs() || b.is_constant() && a.k.is_unit() {
            let inner = Node::Sum(Value { k: Number::ONE, ..a }, b.scaled(a.k.recip()));
            return Value { k: a.k, node: Some(self.intern(inner)) };
        }
        if a.k.is_negative() {
            -Value::from(self.intern(Node::Sum(-a, -b)))
        } else {
            self.intern(Node::Sum(a, b)).into()
        }
    }

    pub fn sub(&mut self, a: Value, b: Value) -> Value {
        self.add(a, -b)
    }

    /// `a + t` where a is a sum that has a like term of t within reach.
    fn absorb(&mut self, a: Value, t: Value, reach: usize) -> Option<Value> {
        let Node::Sum(u, v) = *self.node(a.node?) else { return None };
        let (u, v) = (u.scaled(a.k), v.scaled(a.k));
        // Either way round; an iterator over the two takes several times as long without optimisation.
        let (mut like, mut rest) = (u, v);
        for _ in 0..2 {
            if like.node == t.node {
                let merged = like.k.add(t.k);
                // Not where a free ±1 would become a multiplication.
                let gains = merged.is_zero()
                    || merged.is_unit()
                    || t.is_constant()
                    || !(like.k.is_unit() || t.k.is_unit());
                if gains {
                    return Some(self.add(Value { k: merged, node: t.node }.scaled(Number::ONE), rest));
                }
            }
            if let Some(merged) = self.pythagoras(like, t).or_else(|| self.collect(like, t)) {
                return Some(self.add(merged, rest));
            }
            (like, rest) = (rest, like);
        }
        if reach > 1 && !t.is_constant() {
            for _ in 0..2 {
                if let Some(sum) = self.absorb(like, t, reach - 1) {
                    return Some(self.add(sum, rest));
                }
                (like, rest) = (rest, like);
            }
        }
        None
    }

    /// `A X + B X = (A + B) X`, where A and B are made of parameters: so the sum is computed once per system.
    /// Parameters alone share their common factors, `m l + M l = (m + M) l`.
    fn collect(&mut self, a: Value, b: Value) -> Option<Value> {
        let (x, y) = (a.node?, b.node?);
        // Most differ in other factors, which is seen without a list of them.
        if x != y && !self.has_fixed_factor(x) && !self.has_fixed_factor(y) {
            return None;
        }
        let (x, y) = (self.factors(x), self.factors(y));
        let moving = |factors: &Monomial| -> Vec<_> {
            factors.iter().copied().filter(|f| !self.is_fixed(f.0)).collect()
        };
        let (moving_x, moving_y) = (moving(&x), moving(&y));
        if moving_x != moving_y {
            return None;
        }
        let common = if moving_x.is_empty() { common(&x, &y) } else { moving_x };
        if common.is_empty() {
            return None;
        }
        let (rest_a, rest_b) = (self.without(&x, &common).scaled(a.k), self.without(&y, &common).scaled(b.k));
        let rest = self.add(rest_a, rest_b);
        let common = self.assemble(&common);
        Some(self.mul(common, rest))
    }

    fn has_fixed_factor(&self, id: Id) -> bool {
        match &self.monomials[id.index()] {
            Some(factors) => factors.iter().any(|f| self.is_fixed(f.0)),
            None => self.is_fixed(id),
        }
    }

    /// A monomial divided by one of its parts.
    pub(super) fn without(&mut self, factors: &[(Id, i32)], part: &[(Id, i32)]) -> Value {
        let exponent = |base| part.iter().find(|f| f.0 == base).map_or(0, |f| f.1);
        let rest: Vec<_> =
            factors.iter().map(|&(base, e)| (base, e - exponent(base))).filter(|f| f.1 != 0).collect();
        if rest.is_empty() { Value::ONE } else { self.assemble(&rest) }
    }

    /// The factors that all terms of a sum, or the value itself, have in common.
    pub fn content(&mut self, v: Value) -> Monomial {
        let Some(root) = v.node else { return Rc::from([]) };
        // Operands first; each node once, since sums share their parts.
        let mut stack = vec![root];
        while let Some(&id) = stack.last() {
            if self.contents.get(&id).is_some() {
                stack.pop();
                continue;
            }
            let below: Vec<Id> = match *self.node(id) {
                Node::Sum(_, b) if b.is_constant() => Vec::new(),
                Node::Sum(a, b) => [a.node, b.node].into_iter().flatten().collect(),
                _ => self.factors(id).iter().map(|f| f.0).filter(|f| *f != id && self.is_sum(*f)).collect(),
            };
            let before = stack.len();
            stack.extend(below.into_iter().filter(|below| self.contents.get(below).is_none()));
            if stack.len() == before {
                let content = self.content_of(id);
                self.contents.insert(id, content);
                stack.pop();
            }
        }
        self.contents.get(&root).cloned().expect("the loop ends with the root")
    }

    /// The content of a node whose operands' contents are known.
    fn content_of(&self, id: Id) -> Monomial {
        let known = |id: Id| self.contents.get(&id).cloned().expect("operands come first");
        if let Node::Sum(a, b) = *self.node(id) {
            return match (a.node, b.node) {
                (Some(a), Some(b)) => common(&known(a), &known(b)).into(),
                _ => Rc::from([]),
            };
        }
        let mut content: Vec<(Id, i32)> = Vec::new();
        for &(base, e) in self.factors(id).iter() {
            let inner = if base != id && self.is_sum(base) { known(base) } else { Rc::from([]) };
            for (base, e) in inner.iter().map(|&(b, f)| (b, e * f)).chain([(base, e)]) {
                match content.iter_mut().find(|f| f.0 == base) {
                    Some(f) => f.1 += e,
                    None => content.push((base, e)),
                }
            }
        }
        content.retain(|f| f.1 != 0);
        content.into()
    }

    fn is_sum(&self, id: Id) -> bool {
        matches!(self.node(id), Node::Sum(..))
    }

    /// v / Π baseᵉ, carried into sums. Long sums are deep, so their terms wait on a stack of their own.
    fn divided(&mut self, v: Value, by: &[(Id, i32)], done: &mut Quotients) -> Value {
        let Some(root) = v.node.filter(|_| !by.is_empty()) else { return v };
        let by = Monomial::from(by);
        let of = |done: &Quotients, v: Value| match v.node {
            None => Some(v),
            Some(id) => done.get(&(id, by.clone())).map(|quotient| quotient.scaled(v.k)),
        };
        let mut stack = vec![root];
        while let Some(&id) = stack.last() {
            if of(done, id.into()).is_some() {
                stack.pop();
                continue;
            }
            let quotient = match *self.node(id) {
                Node::Sum(a, b) => match (of(done, a), of(done, b)) {
                    (Some(a), Some(b)) => self.add(a, b),
                    (x, y) => {
                        // The first term on top.
                        stack.extend(y.is_none().then_some(b.node).flatten());
                        stack.extend(x.is_none().then_some(a.node).flatten());
                        continue;
                    }
                },
                _ => self.divided_product(id, &by, done),
            };
            done.insert((id, by.clone()), quotient);
            stack.pop();
        }
        of(done, v).expect("the loop ends with the root")
    }

    /// Cancels against the factors themselves first, then inside a factor that is a sum.
    fn divided_product(&mut self, id: Id, by: &[(Id, i32)], done: &mut Quotients) -> Value {
        let mut left = by.to_vec();
        let mut factors = self.factors(id).to_vec();
        for f in &mut factors {
            if let Some(by) = left.iter_mut().find(|by| by.0 == f.0 && by.1.signum() == f.1.signum()) {
                let e = if by.1 > 0 { by.1.min(f.1) } else { by.1.max(f.1) };
                (f.1, by.1) = (f.1 - e, by.1 - e);
            }
        }
        left.retain(|f| f.1 != 0);
        factors.retain(|f| f.1 != 0);
        let mut result = Value::ONE;
        for (base, e) in factors {
            let mut factor = Value::from(base);
            if e == 1 && self.is_sum(base) {
                let part = common(&left, &self.content(factor));
                factor = self.divided(factor, &part, done);
                for (b, e) in part {
                    left.iter_mut().filter(|f| f.0 == b).for_each(|f| f.1 -= e);
                }
                left.retain(|f| f.1 != 0);
            }
            let power = self.powi(factor, e);
            result = self.mul(result, power);
        }
        if left.is_empty() {
            return result;
        }
        let rest = self.assemble(&left);
        self.div(result, rest)
    }

    /// v / Π baseᵉ with the factors cancelled that all terms of v have in common with it.
    pub fn over(&mut self, v: Value, by: &[(Id, i32)]) -> Value {
        if by.is_empty() {
            return v;
        }
        let part = common(&self.content(v), by);
        let rest = self.without(by, &part);
        let v = self.divided(v, &part, &mut Quotients::default());
        self.div(v, rest)
    }

    /// a / b with the factors cancelled that all terms of both have in common.
    pub fn quotient(&mut self, a: Value, b: Value) -> Value {
        let common: Vec<_> =
            common(&self.content(a), &self.content(b)).into_iter().filter(|f| f.1 > 0).collect();
        let done = &mut Quotients::default();
        let (a, b) = (self.divided(a, &common, done), self.divided(b, &common, done));
        self.div(a, b)
    }

    /// `k X sin²u + k X cos²u = k X`.
    fn pythagoras(&mut self, a: Value, b: Value) -> Option<Value> {
        if a.k != b.k {
            return None;
        }
        let (x, y) = (a.node?, b.node?);
        // One of them has a square, so it is a product.
        if self.monomials[x.index()].is_none() && self.monomials[y.index()].is_none() {
            return None;
        }
        let (x, y) = (self.factors(x), self.factors(y));
        let (mut up, mut down, mut common) = (None, None, Vec::new());
        let (mut i, mut j) = (0, 0);
        while i < x.len() || j < y.len() {
            let next = x.get(i).into_iter().chain(y.get(j)).map(|f| f.0).min()?;
            let exponent = |factors: &[(Id, i32)], at: &mut usize| match factors.get(*at) {
                Some(&(base, e)) if base == next => {
                    *at += 1;
                    e
                }
                _ => 0,
            };
            let (p, q) = (exponent(&x, &mut i), exponent(&y, &mut j));
            match p - q {
                0 => {}
                2 if up.is_none() => up = Some(next),
                -2 if down.is_none() => down = Some(next),
                _ => return None,
            }
            if p.min(q) != 0 {
                common.push((next, p.min(q)));
            }
        }
        let argument = |f: Function, id: Id| match self.node(id) {
            Node::Call(g, u, _) if *g == f => Some(*u),
            _ => None,
        };
        let (up, down) = (up?, down?);
        let pair = |s, c| argument(Function::sin, s).is_some_and(|u| argument(Function::cos, c) == Some(u));
        if !pair(up, down) && !pair(down, up) {
            return None;
        }
        Some(self.assemble(&common).scaled(a.k))
    }

    pub fn mul(&mut self, a: Value, b: Value) -> Value {
        let k = a.k.mul(b.k);
        if k.is_zero() {
            return Value::ZERO;
        }
        match (a.node, b.node) {
            (None, node) | (node, None) => Value { k, node },
            (Some(x), Some(y)) => self.product(x, y).scaled(k),
        }
    }

    pub fn div(&mut self, a: Value, b: Value) -> Value {
        let inverse = self.recip(b);
        self.mul(a, inverse)
    }

    /// 1/a. Of a constant 0 it is infinite; the language refuses such a division before it comes here.
    pub fn recip(&mut self, a: Value) -> Value {
        if a.is_zero() {
            return Value::constant(Number::float(f64::INFINITY));
        }
        let Some(id) = a.node else { return Value::constant(a.k.recip()) };
        let inverted: Vec<_> = self.factors(id).iter().map(|&(base, e)| (base, -e)).collect();
        self.assemble(&inverted).scaled(a.k.recip())
    }

    pub fn powi(&mut self, a: Value, exponent: i32) -> Value {
        let mut result = Value::ONE;
        let n = exponent.unsigned_abs();
        for bit in (0..u32::BITS - n.leading_zeros()).rev() {
            result = self.mul(result, result);
            if n >> bit & 1 == 1 {
                result = self.mul(result, a);
            }
        }
        if exponent < 0 { self.recip(result) } else { result }
    }

    /// A node as a product of factors.
    pub fn factors(&self, id: Id) -> Monomial {
        self.monomials[id.index()].clone().unwrap_or_else(|| Rc::from([(id, 1)]))
    }

    fn product(&mut self, a: Id, b: Id) -> Value {
        let (x, y) = (self.factors(a), self.factors(b));
        let (mut key, mut cancelled, mut rooted) = (Vec::with_capacity(x.len() + y.len()), false, false);
        let (mut i, mut j) = (0, 0);
        while i < x.len() || j < y.len() {
            match (x.get(i), y.get(j)) {
                (Some(&(p, e)), Some(&(q, f))) if p == q => {
                    cancelled |= (e < 0) != (f < 0);
                    rooted |= matches!(self.node(p), Node::Call(Function::sqrt | Function::abs, ..));
                    key.extend((e + f != 0).then_some((p, e + f)));
                    (i, j) = (i + 1, j + 1);
                }
                (Some(&p), Some(&q)) if p.0 < q.0 => {
                    key.push(p);
                    i += 1;
                }
                (Some(&p), None) => {
                    key.push(p);
                    i += 1;
                }
                (_, Some(&q)) => {
                    key.push(q);
                    j += 1;
                }
                (None, None) => unreachable!("the loop ends when both are used up"),
            }
        }
        if key.len() > MAX_FACTORS || key.iter().any(|f| f.1.abs() > MAX_EXPONENT) {
            return self.intern(Node::Product(a.min(b), a.max(b))).into();
        }
        if rooted {
            return self.unrooted(&key);
        }
        if let Some((key, k)) = self.root_reduced(&key) {
            return self.assemble(&key).scaled(k);
        }
        if cancelled {
            return self.assemble(&key);
        }
        if let Some(signed) = self.signed(&key) {
            return signed;
        }
        if let Some(&id) = self.products.get(key.as_slice()) {
            return id.into();
        }
        let (a, b) = self.apart(&key).unwrap_or((a, b));
        self.named_product(key.into(), Node::Product(a.min(b), a.max(b)))
    }

    /// A product as what depends on parameters alone, computed once per system, times the rest.
    fn apart(&mut self, key: &[(Id, i32)]) -> Option<(Id, Id)> {
        let (fixed, moving): (Vec<_>, Vec<_>) = key.iter().partition(|f| self.is_fixed(f.0));
        if fixed.is_empty() || moving.is_empty() {
            return None;
        }
        let (fixed, moving) = (self.assemble(&fixed), self.assemble(&moving));
        fixed.node.zip(moving.node)
    }

    /// The one node of a monomial, made as `node` if it is new.
    fn named_product(&mut self, key: Monomial, node: Node) -> Value {
        if let Some(&id) = self.products.get(&key) {
            return id.into();
        }
        let id = self.intern(node);
        self.monomials[id.index()] = Some(key.clone());
        self.products.insert(key, id);
        id.into()
    }

    /// The product of powers: numerator times the inverse of the denominator.
    pub fn assemble(&mut self, key: &[(Id, i32)]) -> Value {
        if let [(base, 1)] = key {
            return (*base).into();
        }
        if let Some(&id) = self.products.get(key) {
            return id.into();
        }
        let mut halves = [Value::ONE, Value::ONE];
        for &(base, e) in key {
            let power = self.powi(base.into(), e.abs());
            let half = &mut halves[usize::from(e < 0)];
            *half = self.mul(*half, power);
        }
        let [numerator, denominator] = halves;
        // A denominator may turn out to be a number: that of squares of roots of numbers.
        let Some(id) = denominator.node else { return numerator.scaled(denominator.k.recip()) };
        let key: Monomial = self.factors(id).iter().map(|&(base, e)| (base, -e)).collect();
        let inverse = self.named_product(key, Node::Inverse(id));
        self.mul(numerator, inverse.scaled(denominator.k.recip()))
    }

    /// `u / |u|` is the sign of u, whose switch is known.
    fn signed(&mut self, key: &[(Id, i32)]) -> Option<Value> {
        let exponent = |base| key.iter().find(|f: &&(Id, i32)| f.0 == base).map_or(0, |f| f.1);
        let (size, under, factors) = key.iter().find_map(|&(size, e)| {
            let Node::Call(Function::abs, under, _) = *self.node(size) else { return None };
            let factors = self.factors(under.node.filter(|_| e < 0 && under.k.is_one())?);
            let is_whole = factors.iter().all(|&(base, f)| f > 0 && exponent(base) >= f);
            is_whole.then_some((size, under, factors))
        })?;
        let change = |base| match factors.iter().find(|f| f.0 == base) {
            _ if base == size => 1,
            Some(f) => -f.1,
            None => 0,
        };
        let rest = key.iter().map(|&(base, e)| (base, e + change(base))).filter(|f| f.1 != 0);
        let rest: Vec<(Id, i32)> = rest.collect();
        let (rest, sign) = (self.assemble(&rest), self.call(Function::signum, under));
        Some(self.mul(rest, sign))
    }

    /// `u / √u = √u` and `√u / u = 1 / √u`, which have values where u = 0 makes the left sides 0/0.
    fn root_reduced(&self, key: &[(Id, i32)]) -> Option<(Vec<(Id, i32)>, Number)> {
        key.iter().find_map(|&(root, e)| {
            let Node::Call(Function::sqrt, under, _) = *self.node(root) else { return None };
            let (sign, radicand) = (-e.signum(), self.factors(under.node?));
            let exponent = |base| key.iter().find(|f: &&(Id, i32)| f.0 == base).map_or(0, |f| f.1);
            if !radicand.iter().all(|&(base, f)| f > 0 && sign * exponent(base) >= f) {
                return None;
            }
            let change = |base| match radicand.iter().find(|f| f.0 == base) {
                _ if base == root => 2 * sign,
                Some(f) => -sign * f.1,
                None => 0,
            };
            let reduced = key.iter().map(|&(base, e)| (base, e + change(base))).filter(|f| f.1 != 0);
            Some((reduced.collect(), if sign > 0 { under.k.recip() } else { under.k }))
        })
    }

    /// Squares of roots and of absolute values become powers of what is under them.
    fn unrooted(&mut self, key: &[(Id, i32)]) -> Value {
        let mut rest = Vec::new();
        let mut result = Value::ONE;
        for &(base, e) in key {
            let (under, e_under, left) = match *self.node(base) {
                Node::Call(Function::sqrt, under, _) => (under, e / 2, e % 2),
                Node::Call(Function::abs, under, _) => (under, e / 2 * 2, e % 2),
                _ => (Value::ONE, 0, e),
            };
            if e_under != 0 {
                let power = self.powi(under, e_under);
                result = self.mul(result, power);
            }
            rest.extend((left != 0).then_some((base, left)));
        }
        let rest = self.assemble(&rest);
        self.mul(result, rest)
    }

    /// An elementary function of one argument.
    pub fn call(&mut self, f: Function, x: Value) -> Value {
        if let Some(k) = x.is_constant().then(|| exact(f, x.k)).flatten() {
            return Value::constant(k);
        }
        // Odd and even functions of a negative value.
        if x.k.is_negative() {
            const ODD: [Function; 9] = [
                Function::sin,
                Function::tan,
                Function::asin,
                Function::atan,
                Function::sinh,
                Function::tanh,
                Function::asinh,
                Function::atanh,
                Function::cbrt,
            ];
            const EVEN: [Function; 3] = [Function::cos, Function::cosh, Function::abs];
            if ODD.contains(&f) {
                return -self.call(f, -x);
            }
            if EVEN.contains(&f) {
                return self.call(f, -x);
            }
        }
        if f == Function::abs && !x.k.is_one() {
            return self.call(f, Value { k: Number::ONE, ..x }).scaled(x.k);
        }
        if let (Function::sqrt, Some(root)) = (f, x.k.sqrt())
            && !root.is_one()
        {
            return self.call(f, Value { k: Number::ONE, ..x }).scaled(root);
        }
        if let Some(value) = self.kinked(f, x) {
            return value;
        }
        self.intern(Node::Call(f, x, Value::ZERO)).into()
    }

    /// An elementary function of two arguments.
    pub fn call2(&mut self, f: Function, x: Value, y: Value) -> Value {
        if f == Function::hypot && (x.is_zero() || y.is_zero()) {
            return self.call(Function::abs, if x.is_zero() { y } else { x });
        }
        // A quarter turn to either side, and none of nothing.
        if f == Function::atan2
            && y.is_zero()
            && let Some(quarter_turn) = Number::named("FRAC_PI_2")
        {
            return if x.is_zero() { x } else { self.call(Function::signum, x).scaled(quarter_turn) };
        }
        if f == Function::powf && y.is_constant() {
            if let Some(n) =
                y.k.integer().and_then(|n| i32::try_from(n).ok()).filter(|n| n.abs() <= MAX_EXPONENT)
            {
                return self.powi(x, n);
            }
            // x^(n/2) for odd n: a root times a whole power.
            if let Some(n) = y.k.mul(2.into()).integer().filter(|n| n.abs() < 64) {
                let root = self.call(Function::sqrt, x);
                return self.powi(root, n as i32);
            }
            if let Some((outside, inside)) = self.magnitude(x, y.k) {
                let inside = if inside == Value::ONE { inside } else { self.call2(f, inside, y) };
                return self.mul(outside, inside);
            }
        }
        self.intern(Node::Call(f, x, y)).into()
    }

    pub fn external(&mut self, function: usize, orders: Box<[u8]>, arguments: Box<[Value]>) -> Value {
        self.intern(Node::Extern(function, orders, arguments)).into()
    }

    pub fn select(&mut self, comparison: Comparison, a: Value, b: Value, yes: Value, no: Value) -> Value {
        if yes == no {
            return yes;
        }
        if a.is_constant() && b.is_constant() {
            let order = a.k.compare(b.k);
            let holds = match comparison {
                Comparison::Less => order.is_lt(),
                Comparison::LessEqual => order.is_le(),
                Comparison::Equal => order.is_eq(),
            };
            return if holds { yes } else { no };
        }
        // No sign inside that could be outside.
        let negative = |v: Value| v.is_zero() || v.k.is_negative();
        if negative(yes) && negative(no) {
            return -self.select(comparison, a, b, -yes, -no);
        }
        self.intern(Node::Select(comparison, Box::new([a, b, yes, no]))).into()
    }
}

/// The greatest common divisor of two monomials.
pub fn common(x: &[(Id, i32)], y: &[(Id, i32)]) -> Vec<(Id, i32)> {
    let shared = |&(base, e): &(Id, i32)| {
        let f = y.iter().find(|f| f.0 == base)?.1;
        (e.signum() == f.signum()).then(|| (base, if e > 0 { e.min(f) } else { e.max(f) }))
    };
    x.iter().filter_map(shared).collect()
}

/// Exact values of functions at exact constants.
fn exact(f: Function, x: Number) -> Option<Number> {
    let at_zero = [
        Function::sin,
        Function::tan,
        Function::asin,
        Function::atan,
        Function::sinh,
        Function::tanh,
        Function::asinh,
        Function::atanh,
        Function::cbrt,
        Function::exp_m1,
        Function::ln_1p,
    ];
    match f {
        _ if x.is_zero() && at_zero.contains(&f) => Some(Number::ZERO),
        Function::cos | Function::cosh | Function::exp if x.is_zero() => Some(Number::ONE),
        Function::sin => x.right_angles().map(|n| [0, 1, 0, -1][n.rem_euclid(4) as usize].into()),
        Function::cos => x.right_angles().map(|n| [1, 0, -1, 0][n.rem_euclid(4) as usize].into()),
        Function::ln if x.is_one() => Some(Number::ZERO),
        Function::sqrt => x.sqrt(),
        Function::abs => Some(x.abs()),
        Function::signum if !x.is_zero() => {
            Some(if x.is_negative() { Number::MINUS_ONE } else { Number::ONE })
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::super::Symbol;
    use super::*;

    fn symbols(g: &mut Graph) -> (Value, Value, Value) {
        (g.symbol(Symbol::Coordinate(0)), g.symbol(Symbol::Coordinate(1)), g.symbol(Symbol::Parameter(0)))
    }

    #[test]
    fn roots_of_numbers_in_denominators() {
        let g = &mut Graph::default();
        let (x, _, _) = symbols(g);
        let root = g.call(Function::sqrt, Value::constant(Number::Ratio(7, 2)));
        let quotient = g.quotient(x, root);
        let square = g.powi(quotient, 2);
        // x² / (7/2), however it comes about.
        let expected = g.powi(x, 2).scaled(Number::Ratio(2, 7));
        assert_eq!(square, expected);
        let root = root.node.expect("no square");
        let at_once = g.assemble(&[(x.node.expect("a symbol"), 2), (root, -2)]);
        assert_eq!(at_once, expected);
        // ((x/r − x)² + x²), multiplied out.
        let difference = g.sub(quotient, x);
        let (a, b) = (g.powi(difference, 2), g.powi(x, 2));
        let sum = g.add(a, b);
        let how = crate::graph::normal::EXPANSIONS[0];
        let expanded = g.expanded(&[sum], 24, how).expect("a few terms");
        let [before, after] = [sum, expanded[0]].map(|v| g.evaluate(&[v], |_| 1.0)[0]);
        assert!((before - after).abs() < 1e-15, "{before} {after}");
    }

    #[test]
    fn like_terms_merge() {
        let g = &mut Graph::default();
        let (x, y, _) = symbols(g);
        let s = g.add(x, y);
        assert_eq!(g.sub(s, y), x);
        let t = g.add(s, Value::ONE);
        let t = g.sub(t, x);
        let expected = g.add(y, Value::ONE);
        assert_eq!(t, expected);
        let (a, b) = (g.sub(x, y), g.sub(y, x));
        assert_eq!(a, -b);
    }

    #[test]
    fn products_are_canonical() {
        let g = &mut Graph::default();
        let (x, y, m) = symbols(g);
        let (xy, ym) = (g.mul(x, y), g.mul(y, m));
        let (a, b) = (g.mul(xy, m), g.mul(x, ym));
        assert_eq!(a, b);
        assert_eq!(g.div(a, xy), m);
        let i = g.recip(ym);
        let q = g.mul(xy, i);
        let expected = g.div(x, m);
        assert_eq!(q, expected);
        let r = g.call(Function::sqrt, x);
        assert_eq!(g.mul(r, r), x);
        let cube = g.call2(Function::powf, x, Value::constant(Number::Ratio(3, 2)));
        let expected = g.mul(x, r);
        assert_eq!(cube, expected);
    }

    #[test]
    fn roots_cancel() {
        let g = &mut Graph::default();
        let (x, y, _) = symbols(g);
        let r = g.call(Function::sqrt, x);
        assert_eq!(g.div(x, r), r);
        let (i, inverse) = (g.recip(r), g.div(r, x));
        assert_eq!(inverse, i);
        // x² / √(−2 x) = −x √(−2 x) / 2
        let (under, square) = (x.scaled((-2).into()), g.mul(x, x));
        let r = g.call(Function::sqrt, under);
        let (quotient, product) = (g.div(square, r), g.mul(x, r));
        assert_eq!(quotient, product.scaled(Number::Ratio(-1, 2)));
        // x y² / √(x y) = y √(x y)
        let xy = g.mul(x, y);
        let r = g.call(Function::sqrt, xy);
        let xyy = g.mul(xy, y);
        let (quotient, product) = (g.div(xyy, r), g.mul(y, r));
        assert_eq!(quotient, product);
    }

    #[test]
    fn pythagoras_with_common_factor() {
        let g = &mut Graph::default();
        let (x, y, m) = symbols(g);
        let (s, c) = (g.call(Function::sin, x), g.call(Function::cos, x));
        let (ms, mc) = (g.mul(m, s), g.mul(c, m));
        let (a, b) = (g.mul(ms, s), g.mul(mc, c));
        assert_eq!(g.add(a, b), m);
        let ay = g.add(a, y);
        let expected = g.add(y, m);
        assert_eq!(g.add(ay, b), expected);
        assert_eq!(g.add(s, c).k, Number::ONE);
    }

    /// Each sum contains the one before twice: 2⁶⁴ paths, 64 sums.
    #[test]
    fn quotients_of_shared_sums_take_no_longer_than_they_are() {
        let g = &mut Graph::default();
        let (x, y, m) = symbols(g);
        let mut total = g.add(x, y);
        for i in 0..64 {
            let z = g.symbol(Symbol::Velocity(i));
            let (a, b) = (g.mul(total, z), g.add(total, z));
            total = g.add(a, b);
        }
        let heavy = g.mul(m, total);
        assert_eq!(g.quotient(heavy, m), total);
        let like = g.mul(m, x);
        let (sum, expected) = (g.add(heavy, like), g.add(total, x));
        assert_eq!(g.quotient(sum, m), expected);
    }

    #[test]
    fn functions_shed_signs() {
        let g = &mut Graph::default();
        let (x, y, _) = symbols(g);
        let (d, e) = (g.sub(x, y), g.sub(y, x));
        let (a, b) = (g.call(Function::sin, d), g.call(Function::sin, e));
        assert_eq!(a, -b);
        let (a, b) = (g.call(Function::cos, d), g.call(Function::cos, e));
        assert_eq!(a, b);
    }
}
