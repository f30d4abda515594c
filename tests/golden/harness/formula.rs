//! The equations and first integrals that a file quotes, as text: infix, with `dot(x)`, `ddot(x)` for derivatives and
//! `f(t)`, `dot(f)` for the given functions of time.

use super::row::{Finding, Kind};
use super::subject::{Point, Quantity};
use super::{BALANCE, INPUT, State, Subject};
use lagrange_runtime::{Dual, Scalar};

/// The value of a formula, where `lookup` gives the derivative of some order of a name.
pub fn evaluate<S: Scalar>(text: &str, lookup: &dyn Fn(&str, usize) -> S) -> S {
    let text: String = text.split_whitespace().collect();
    let mut parser = Parser { rest: &text, lookup };
    let value = parser.sum();
    assert!(parser.rest.is_empty(), "{text}: stopped at {:?}", parser.rest);
    value
}

struct Parser<'a, S> {
    rest: &'a str,
    lookup: &'a dyn Fn(&str, usize) -> S,
}

impl<'a, S: Scalar> Parser<'a, S> {
    fn sum(&mut self) -> S {
        let mut value = if self.take('-') { -self.product() } else { self.product() };
        loop {
            if self.take('+') {
                value += self.product();
            } else if self.take('-') {
                value -= self.product();
            } else {
                return value;
            }
        }
    }

    fn product(&mut self) -> S {
        let mut value = self.factor();
        loop {
            if self.take('*') {
                value *= self.factor();
            } else if self.take('/') {
                value /= self.factor();
            } else {
                return value;
            }
        }
    }

    fn factor(&mut self) -> S {
        if self.take('(') {
            let value = self.sum();
            self.expect(')');
            return value;
        }
        if self.rest.starts_with(|c: char| c.is_ascii_digit()) {
            return S::from_f64(self.word().parse().expect("a number"));
        }
        let name = self.word();
        if !self.take('(') {
            return (self.lookup)(name, 0);
        }
        let value = match name {
            "dot" => (self.lookup)(self.word(), 1),
            "ddot" => (self.lookup)(self.word(), 2),
            "sin" => self.sum().sin(),
            "cos" => self.sum().cos(),
            "exp" => self.sum().exp(),
            "sqrt" => self.sum().sqrt(),
            "powi" => {
                let base = self.sum();
                self.expect(',');
                let exponent: usize = self.word().parse().expect("a whole exponent");
                (0..exponent).fold(S::one(), |power, _| power * base)
            }
            function => {
                assert_eq!(self.word(), "t", "{function} is a function of time");
                (self.lookup)(function, 0)
            }
        };
        self.expect(')');
        value
    }

    /// Letters, digits and points.
    fn word(&mut self) -> &'a str {
        let end = self.rest.find(|c: char| !(c.is_ascii_alphanumeric() || c == '.' || c == '_'));
        let (word, rest) = self.rest.split_at(end.unwrap_or(self.rest.len()));
        assert!(!word.is_empty(), "a name or a number at {:?}", self.rest);
        self.rest = rest;
        word
    }

    fn take(&mut self, symbol: char) -> bool {
        let rest = self.rest.strip_prefix(symbol);
        self.rest = rest.unwrap_or(self.rest);
        rest.is_some()
    }

    fn expect(&mut self, symbol: char) {
        assert!(self.take(symbol), "{symbol} at {:?}", self.rest);
    }
}

/// All that a formula may name, with the order of its derivative: its value, and its rate along the motion.
struct Scope {
    entries: Vec<(String, usize, f64, f64)>,
}

impl Scope {
    fn new(point: &Point<'_>) -> Self {
        let n = point.n();
        let reference = &point.subject.reference;
        let acceleration = point.value(Quantity::Acceleration);
        let time = point.x[2 * n];
        let mut entries = vec![("t".to_owned(), 0, time, 1.0)];
        for (k, name) in reference.coordinates().into_iter().enumerate() {
            let derivatives = [point.x[k], point.x[n + k], acceleration[k], f64::NAN];
            entries.extend(
                (0..3).map(|order| (name.to_owned(), order, derivatives[order], derivatives[order + 1])),
            );
        }
        let multipliers = point.try_value(Quantity::Multipliers).unwrap_or_default();
        for (index, value) in multipliers.into_iter().enumerate() {
            entries.push((format!("lam{}", index + 1), 0, value, f64::NAN));
        }
        let parameters = reference.names.iter().zip(&reference.values);
        entries.extend(parameters.map(|(name, value)| (name.clone(), 0, *value, 0.0)));
        for (name, text) in reference.time_functions() {
            let derivatives = derivatives(text, time, &entries);
            entries.extend((0..3).map(|order| (name.to_owned(), order, derivatives[order], f64::NAN)));
        }
        Scope { entries }
    }

    fn value(&self, text: &str) -> f64 {
        evaluate(text, &|name, order| self.entries[self.position(name, order)].2)
    }

    /// The derivative of a formula by its entries, each of which contributes to `Σ |∂C/∂xᵢ wᵢ|`.
    fn terms(&self, text: &str, weight: impl Fn(&(String, usize, f64, f64)) -> f64) -> Vec<f64> {
        let partial = |i: usize| {
            let entry = |name: &str, order: usize| {
                let j = self.position(name, order);
                let value = self.entries[j].2;
                if i == j { Dual::variable(value) } else { Dual::constant(value) }
            };
            evaluate(text, &entry).slope
        };
        let terms = self.entries.iter().enumerate().map(|(i, entry)| match partial(i) {
            // What does not occur has no rate to be known.
            0.0 => 0.0,
            partial => partial * weight(entry),
        });
        terms.collect()
    }

    fn position(&self, name: &str, order: usize) -> usize {
        let found = self.entries.iter().position(|entry| entry.0 == name && entry.1 == order);
        found.unwrap_or_else(|| panic!("no derivative {order} of {name:?}"))
    }
}

/// A function of time with its first two derivatives.
fn derivatives(text: &str, time: f64, parameters: &[(String, usize, f64, f64)]) -> [f64; 3] {
    let time = Dual::variable(Dual::variable(time));
    let lookup = |name: &str, _| match parameters.iter().find(|entry| entry.0 == name) {
        Some(_) if name == "t" => time,
        Some(entry) => Dual::constant(Dual::constant(entry.2)),
        None => panic!("no parameter {name:?}"),
    };
    let value = evaluate(text, &lookup);
    [value.value.value, value.slope.value, value.slope.slope]
}

/// The printed equations, the equations derived by hand, the momenta and the first integrals of the file, at random
/// states.
pub fn check_formulas(subject: &Subject, states: &[State]) -> Vec<Finding> {
    let mut findings = Vec::new();
    for (index, state) in states.iter().enumerate() {
        let point = subject.at("", state);
        let scope = Scope::new(&point);
        let reference = &subject.reference;
        let place = |kind: &str, name: &str| format!("{kind} {name}, random state {index}");
        for (name, text) in [reference.formulas("printed"), reference.formulas("own")].concat() {
            let size: f64 = scope.terms(text, |entry| entry.2).iter().map(|term| term.abs()).sum();
            // A small acceleration may be the difference of large terms: it is as accurate as these.
            let accelerations = scope.terms(text, |entry| if entry.1 == 2 { point.agility() } else { 0.0 });
            let agility: f64 = accelerations.iter().map(|term| term.abs()).sum();
            let bound = BALANCE * size.max(agility);
            findings.push(Finding::residue(
                Kind::Equation,
                place("equation", name),
                scope.value(text),
                bound / BALANCE,
                bound,
            ));
        }
        for (name, text) in reference.formulas("momentum") {
            let expected = scope.value(text);
            let size: f64 = scope.terms(text, |entry| entry.2).iter().map(|term| term.abs()).sum();
            let momenta = point.value(Quantity::Momenta);
            let nearest = momenta.iter().map(|p| (p - expected).abs()).fold(f64::INFINITY, f64::min);
            findings.push(Finding::residue(
                Kind::Equation,
                place("momentum", name),
                nearest,
                size,
                BALANCE * size,
            ));
        }
        for (name, text) in reference.formulas("first integral") {
            let terms = scope.terms(text, |entry| entry.3);
            let slopes: f64 = scope
                .terms(text, |entry| if entry.1 == 1 { 1.0 } else { 0.0 })
                .iter()
                .map(|slope| slope.abs())
                .sum();
            let size: f64 = terms.iter().map(|term| term.abs()).sum();
            let bound = BALANCE * size + INPUT * slopes * point.condition(Quantity::Acceleration);
            findings.push(Finding::residue(
                Kind::Equation,
                place("first integral", name),
                terms.iter().sum(),
                bound / BALANCE,
                bound,
            ));
        }
    }
    findings
}
