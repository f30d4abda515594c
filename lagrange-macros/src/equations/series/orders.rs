//! Coefficients of order k of expressions, as expressions in those of order 0 and in what an order is given
//! ([`Coefficient`]).
//!
//! With x_k the k-th Taylor coefficient of x(t), each node of the graph gives its k-th coefficient from those of its
//! operands up to k (Moore 1966; Jorba and Zou 2005; Griewank and Walther 2008, ch. 13):
//!
//! ```text
//! (a b)_k = Σ a_j b_{k−j}                  (a/b)_k = (a_k − Σ_{j≥1} b_j (a/b)_{k−j}) / b_0
//! f(a)_k  = (1/k) Σ j a_j f'(a)_{k−j}      (a^r)_k = Σ_{j≥1} (r j − (k − j)) a_j (a^r)_{k−j} / (k a_0)
//! (√a)_k  = (a_k − Σ_{0<j<k} (√a)_j (√a)_{k−j}) / (2 (√a)_0)
//! ```
//!
//! The rule for functions needs the series of the derivative one order behind, so the formulas of the function table
//! serve for all of them, and sine and cosine are each other's. What depends on parameters alone is a number, and is
//! not convolved. Of a convolution the terms that contain order 0, 1 or k − 1 are written out; the others are an
//! input.

use super::recurrence::{Motion, Recurrence};
use crate::equations::common::is_number;
use crate::graph::{
    Coefficient, Function, Graph, Id, Node, Number, Symbol, Value,
    stable_map::{IdMap, StableMap},
};

/// A series in a convolution.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum Factor {
    Of(Id),
    /// Series of `j x_j`.
    Rate(Id),
    /// Series of an unknown of the system of equations.
    Unknown(usize),
}

/// Coefficients of order k of a set of expressions.
pub struct Orders<'a> {
    pub g: &'a mut Graph,
    /// The nodes whose series are needed, operands first.
    nodes: Vec<Id>,
    /// Moving arguments of functions, with their partial derivatives.
    slopes: IdMap<Vec<(Value, Value)>>,
    /// Products of a velocity and a slope.
    rates: StableMap<[Id; 2], Id>,
    coefficients: IdMap<Value>,
    /// Symbols whose coefficients are found within the order. Other coordinates and velocities are inputs.
    found: IdMap<Value>,
    /// Coefficients 0 and k of the unknowns that are convolved.
    pub unknowns: Vec<[Value; 2]>,
    factors: Vec<Factor>,
    places: StableMap<Factor, usize>,
    convolutions: Vec<[usize; 2]>,
    inner: StableMap<[usize; 2], usize>,
    memory: Vec<Value>,
}

impl<'a> Orders<'a> {
    /// None where an expression has no series: functions of the user's, powers whose exponents move.
    pub fn new(g: &'a mut Graph, roots: &[Value]) -> Option<Orders<'a>> {
        let mut slopes = IdMap::default();
        let mut met: IdMap<()> = IdMap::default();
        // Derivatives of functions are new roots, and are made of the function itself or of nodes that end soon.
        let mut stack: Vec<Id> = roots.iter().filter_map(|v| v.node).collect();
        while let Some(id) = stack.pop() {
            if g.is_fixed(id) || matches!(g.node(id), Node::Symbol(_)) || met.get(&id).is_some() {
                continue;
            }
            met.insert(id, ());
            let mut push = |v: Value| stack.extend(v.node);
            match *g.node(id) {
                Node::Sum(a, b) => [a, b].into_iter().for_each(push),
                Node::Product(a, b) => parts(g, a, b).into_iter().for_each(|id| push(id.into())),
                Node::Inverse(under) => push(under.into()),
                Node::Call(Function::sqrt, a, _) => push(a),
                Node::Call(Function::powf, a, r) if is_number(g, r) => push(a),
                // Its derivatives have ever more powers; and the others are not smooth.
                Node::Call(Function::powf | Function::abs | Function::signum, ..) | Node::Extern(..) => {
                    return None;
                }
                Node::Call(..) => {
                    let mut partials = g.partials(id);
                    partials.retain(|(argument, _)| !is_number(g, *argument));
                    partials.iter().for_each(|(argument, slope)| {
                        stack.extend([argument.node, slope.node].into_iter().flatten())
                    });
                    slopes.insert(id, partials);
                }
                Node::Select(_, ref values) if values[..2].iter().all(|v| is_number(g, *v)) => {
                    values[2..].iter().copied().for_each(push);
                }
                Node::Symbol(_) | Node::Select(..) => return None,
            }
        }
        let nodes: Vec<Id> = met.in_order().into_iter().map(|(id, ())| id).collect();
        let mut rates = StableMap::default();
        for &id in &nodes {
            if let Node::Product(a, b) = *g.node(id) {
                rates.insert([a, b], id);
                rates.insert([b, a], id);
            }
        }
        Some(Orders {
            g,
            nodes,
            slopes,
            rates,
            coefficients: IdMap::default(),
            found: IdMap::default(),
            unknowns: Vec::new(),
            factors: Vec::new(),
            places: StableMap::default(),
            convolutions: Vec::new(),
            inner: StableMap::default(),
            memory: Vec::new(),
        })
    }

    pub fn input(&mut self, input: Coefficient) -> Value {
        self.g.symbol(Symbol::Order(input))
    }

    /// x/k
    pub fn over(&mut self, x: Value) -> Value {
        let over = self.input(Coefficient::Over);
        self.g.times(x, over)
    }

    /// The coefficient k − 1 of an expression.
    pub fn before(&mut self, v: Value) -> Value {
        // A number has a coefficient 0 alone, which comes before that of order 1.
        if is_number(self.g, v) {
            let clock = self.input(Coefficient::Clock);
            return self.g.times(v, clock);
        }
        let place = self.memory.iter().position(|known| *known == v).unwrap_or_else(|| {
            self.memory.push(v);
            self.memory.len() - 1
        });
        self.input(Coefficient::Before(place))
    }

    /// Coefficients of order k.
    pub fn of(&mut self, values: &[Value]) -> Vec<Value> {
        for id in self.g.live(values) {
            self.follow(id);
        }
        values.iter().map(|v| self.at(*v)).collect()
    }

    /// The coefficient of a symbol that is over/under, where `under` moves by factors without numbers or is a number.
    pub fn fraction(&mut self, symbol: Symbol, over: Value, under: Value) -> Value {
        self.of(&[over, under]);
        let over = over.scaled(under.k.recip());
        match (under.node, self.g.symbol(symbol).node) {
            (Some(under), Some(own)) => self.quotient(own, over, under),
            _ => self.at(over),
        }
    }

    /// Says what the coefficient of a symbol is in this order.
    pub fn set(&mut self, symbol: Symbol, coefficient: Value) {
        if let Some(id) = self.g.symbol(symbol).node {
            self.found.insert(id, coefficient);
        }
    }

    /// Forgets all coefficients: they were those of other velocities.
    pub fn forget(&mut self) {
        self.coefficients = IdMap::default();
    }

    /// The recurrences of the motion that these coefficients are found for.
    pub fn finish(mut self, motion: Motion, switches: &[Value]) -> Recurrence {
        for at in 0..self.nodes.len() {
            self.follow(self.nodes[at]);
        }
        let switching = switches.iter().map(|v| [*v, self.at(*v)]).collect();
        let memory = std::mem::take(&mut self.memory).into_iter().map(|v| [v, self.at(v)]).collect();
        let factors = std::mem::take(&mut self.factors);
        let factors = factors.into_iter().map(|factor| self.factor_values(factor)).collect();
        let Motion { accelerations, velocities, coordinates } = motion;
        let convolutions = self.convolutions;
        Recurrence { factors, convolutions, memory, switching, accelerations, velocities, coordinates }
    }

    /// Computes the coefficient of a node whose operands' are known.
    fn follow(&mut self, id: Id) {
        let needed = self.coefficients.get(&id).is_none() && self.nodes.binary_search(&id).is_ok();
        if needed {
            let coefficient = self.coefficient(id);
            self.coefficients.insert(id, coefficient);
        }
    }

    fn at(&mut self, v: Value) -> Value {
        let Some(id) = v.node.filter(|_| !is_number(self.g, v)) else { return Value::ZERO };
        let coefficient = match *self.g.node(id) {
            Node::Symbol(symbol) => match (self.found.get(&id).copied(), symbol) {
                (Some(found), _) => found,
                (None, Symbol::Coordinate(i)) => self.input(Coefficient::Coordinate(i)),
                (None, Symbol::Velocity(i)) => self.input(Coefficient::Velocity(i)),
                (None, Symbol::Time) => self.input(Coefficient::Clock),
                (None, other) => unreachable!("the coefficients of {other:?} are set"),
            },
            _ => *self.coefficients.get(&id).expect("operands have coefficients"),
        };
        coefficient.scaled(v.k)
    }

    /// Coefficients 0 and k of a factor.
    fn factor_values(&mut self, factor: Factor) -> [Value; 2] {
        match factor {
            Factor::Of(id) => [id.into(), self.at(id.into())],
            Factor::Rate(id) => {
                let rate = if let Node::Symbol(Symbol::Coordinate(i)) = *self.g.node(id) {
                    self.input(Coefficient::Rate(i))
                } else {
                    let (level, x) = (self.input(Coefficient::Level), self.at(id.into()));
                    self.g.times(level, x)
                };
                [Value::ZERO, rate]
            }
            Factor::Unknown(i) => self.unknowns[i],
        }
    }

    fn factor(&mut self, factor: Factor) -> usize {
        if let Some(place) = self.places.get(&factor) {
            return *place;
        }
        self.places.insert(factor, self.factors.len());
        self.factors.push(factor);
        self.factors.len() - 1
    }

    /// The inner sum of a convolution, and the places of its factors.
    fn inner(&mut self, pair: [Factor; 2]) -> (Value, [usize; 2]) {
        let places = pair.map(|factor| self.factor(factor));
        let key = [places[0].min(places[1]), places[0].max(places[1])];
        let known = self.inner.get(&key).copied();
        let place = known.unwrap_or_else(|| {
            self.inner.insert(key, self.convolutions.len());
            self.convolutions.push(places);
            self.convolutions.len() - 1
        });
        (self.input(Coefficient::Inner(place)), places)
    }

    /// `Σ_{0<j<k}` of a convolution.
    pub fn middle(&mut self, pair: [Factor; 2]) -> Value {
        let (inner, places) = self.inner(pair);
        // In one order, whoever needs it.
        let (a, b) = (places[0].min(places[1]), places[0].max(places[1]));
        let (first_a, last_a) = (self.input(Coefficient::First(a)), self.input(Coefficient::Last(a)));
        if a == b {
            let twice = self.g.plus(first_a, first_a);
            return self.g.plus_product(inner, twice, last_a);
        }
        let (first_b, last_b) = (self.input(Coefficient::First(b)), self.input(Coefficient::Last(b)));
        let sum = self.g.plus_product(inner, first_a, last_b);
        self.g.plus_product(sum, first_b, last_a)
    }

    /// `(1/k) Σ_{0<j≤k} j a_j s_{k−j}` of a rate of a and a slope s. What order 1 of the rate contributes is divided
    /// on its own, and in advance, so that sines need not wait for a division of the cosines of the order before.
    fn by_rate(&mut self, a: Id, slope: Id) -> Value {
        let newest = self.at(a.into());
        let is_coordinate = matches!(self.g.node(a), Node::Symbol(Symbol::Coordinate(_)));
        let (inner, [a, s]) = self.inner([Factor::Rate(a), Factor::Of(slope)]);
        let [first_a, last_a] = [Coefficient::First(a), Coefficient::Last(a)].map(|input| self.input(input));
        let [first_s, last_s] = [Coefficient::First(s), Coefficient::Last(s)].map(|input| self.input(input));
        let early = self.g.plus_product(inner, first_s, last_a);
        let (early, first_a) = (self.over(early), self.over(first_a));
        // What is known last is added last: a coordinate is known before the order begins.
        let [first, last] = if is_coordinate {
            [[newest, slope.into()], [last_s, first_a]]
        } else {
            [[last_s, first_a], [newest, slope.into()]]
        };
        let sum = self.g.plus_product(early, first[0], first[1]);
        self.g.plus_product(sum, last[0], last[1])
    }

    /// The coefficient of a node that moves, operands first.
    fn coefficient(&mut self, id: Id) -> Value {
        use Factor::{Of, Rate};
        match self.g.node(id).clone() {
            Node::Sum(a, b) => {
                let (a, b) = (self.at(a), self.at(b));
                self.g.plus(a, b)
            }
            Node::Product(a, b) => match (self.g.node(a), self.g.node(b)) {
                _ if self.g.is_fixed(a) => self.multiple(a, b),
                _ if self.g.is_fixed(b) => self.multiple(b, a),
                _ if a == b => {
                    let (sum, x) = (self.middle([Of(a), Of(a)]), self.at(a.into()));
                    let twice = self.g.plus(a.into(), a.into());
                    self.g.plus_product(sum, x, twice)
                }
                (_, &Node::Inverse(under)) => self.quotient(id, a.into(), under),
                (&Node::Inverse(under), _) => self.quotient(id, b.into(), under),
                _ => {
                    let sum = self.middle([Of(a), Of(b)]);
                    // The operand that is known last is added last.
                    let [early, late] = [a.min(b), a.max(b)];
                    let (x, y) = (self.at(early.into()), self.at(late.into()));
                    let sum = self.g.plus_product(sum, x, late.into());
                    self.g.plus_product(sum, y, early.into())
                }
            },
            Node::Inverse(under) => self.quotient(id, Value::ONE, under),
            Node::Call(Function::sqrt, a, _) => {
                let (sum, a) = (self.middle([Of(id), Of(id)]), self.at(a));
                let (rest, over) = (self.g.minus(a, sum), self.g.recip(id.into()));
                let over = self.g.whole(over.scaled(Number::from(2).recip()));
                self.g.times(rest, over)
            }
            // A constant factor of the base is one of all its coefficients.
            Node::Call(Function::powf, Value { node: Some(a), .. }, r) => {
                let (rates, sum) = (self.middle([Rate(a), Of(id)]), self.middle([Of(a), Of(id)]));
                let (more, slope) = (self.g.add(r, Value::ONE), self.g.mul(r, id.into()));
                let slope = self.g.whole(slope);
                let rates = self.g.times(more, rates);
                let rates = self.over(rates);
                let (rest, x) = (self.g.minus(rates, sum), self.at(a.into()));
                let (sum, over) = (self.g.plus_product(rest, x, slope), self.g.recip(a.into()));
                self.g.times(sum, over)
            }
            Node::Call(..) => {
                let slopes = self.slopes.get(&id).cloned().unwrap_or_default();
                slopes.into_iter().fold(Value::ZERO, |sum, (argument, slope)| {
                    let term = self.slope(argument, slope);
                    self.g.plus(sum, term)
                })
            }
            Node::Select(comparison, values) => {
                let [a, b, yes, no] = *values;
                let (yes, no) = (self.at(yes), self.at(no));
                self.g.select(comparison, a, b, yes, no)
            }
            Node::Symbol(_) | Node::Extern(..) => unreachable!("has no rule"),
        }
    }

    fn multiple(&mut self, number: Id, of: Id) -> Value {
        let x = self.at(of.into());
        self.g.times(number.into(), x)
    }

    fn quotient(&mut self, own: Id, over: Value, under: Id) -> Value {
        let sum = self.middle([Factor::Of(under), Factor::Of(own)]);
        let (over, x) = (self.at(over), self.at(under.into()));
        let sum = self.g.plus_product(sum, x, own.into());
        let (rest, reciprocal) = (self.g.minus(over, sum), self.g.recip(under.into()));
        self.g.times(rest, reciprocal)
    }

    /// Contribution of an argument of a function, by the partial derivative.
    fn slope(&mut self, argument: Value, slope: Value) -> Value {
        let (Some(a), Some(s)) = (argument.node, slope.node.filter(|_| !is_number(self.g, slope))) else {
            let x = self.at(argument);
            return self.g.times(slope, x);
        };
        let k = argument.k.mul(slope.k);
        // The product of a coordinate's velocity and the slope, where the equations have it anyway.
        if let Node::Symbol(Symbol::Coordinate(i)) = *self.g.node(a)
            && let Some(velocity) = self.g.symbol(Symbol::Velocity(i)).node
            && let Some(&product) = self.rates.get(&[velocity, s])
        {
            let before = self.before(product.into());
            return self.over(before).scaled(k);
        }
        self.by_rate(a, s).scaled(k)
    }
}

/// The series that a product is made of: numbers have none, and of an inverse it is what is inverted.
fn parts(g: &Graph, a: Id, b: Id) -> Vec<Id> {
    match (g.node(a), g.node(b)) {
        _ if g.is_fixed(a) => vec![b],
        _ if g.is_fixed(b) => vec![a],
        (_, &Node::Inverse(under)) => vec![a, under],
        (&Node::Inverse(under), _) => vec![b, under],
        _ => vec![a, b],
    }
}
