//! Changes of scale that leave the equations of motion as they are: each coordinate, parameter and time times a power
//! of λ, so that L is multiplied by a number. Parameters enter a motion by their dimensionless groups alone, beside
//! units (Buckingham, Phys. Rev. 4 (1914) 345), and what scales without them takes motions to similar ones (Landau and
//! Lifshitz, *Mechanics*, 3rd ed. 1976, §10).
//!
//! Terms of a sum have one exponent, and arguments of functions have none; these are linear equations for the
//! exponents. Numbers in the text are taken to be without units.

use super::formed::Formed;
use crate::graph::stable_map::IdMap;
use crate::graph::{Function, Graph, Node, Number, Symbol, Value};
use crate::model::Model;
use std::collections::BTreeMap;

/// Exponents of λ that are not determined, with their factors.
type Form = BTreeMap<usize, Number>;

/// A product of powers of parameters, by their numbers.
pub type Monomial = Vec<(usize, Number)>;

/// Changes of scale of a system, with whole exponents but for units.
#[derive(Debug)]
pub struct Scalings {
    /// Groups of parameters that no scaling changes, each with one parameter that is in no other.
    pub groups: Vec<Monomial>,
    /// Time in units that parameters give, and each coordinate.
    pub units: Vec<Option<Monomial>>,
    /// Scalings that leave the parameters as they are: exponents of time and of each coordinate.
    pub similar: Vec<Vec<Number>>,
}

/// Graphs of more nodes are not asked.
const MAX_SCALED_NODES: usize = 20_000;

/// None where they are not known: of systems that are too large, and of exponents that are no small fractions.
pub fn scalings(g: &Graph, model: &Model, formed: &Formed) -> Option<Scalings> {
    Exponents::of(g, model, formed)?.scalings()
}

/// Unknown exponents: of the parameters, inputs last, of time, of the coordinates, and of L.
struct Exponents {
    /// Place of each parameter.
    parameters: Vec<usize>,
    coordinates: usize,
    /// An unknown by those before it.
    solved: BTreeMap<usize, Form>,
}

impl Exponents {
    fn of(g: &Graph, model: &Model, formed: &Formed) -> Option<Exponents> {
        let n = model.coordinates.len();
        let inputs: Vec<usize> = model.inputs().collect();
        let count = model.parameters.iter().map(|p| p.numbers().len()).sum();
        let mut order: Vec<usize> = (0..count).collect();
        order.sort_by_key(|i| (inputs.contains(i), *i));
        let mut parameters = vec![0; count];
        order.iter().enumerate().for_each(|(place, i)| parameters[*i] = place);
        let mut exponents = Exponents { parameters, coordinates: n, solved: BTreeMap::new() };

        let Formed { lagrangian, dissipation, nonconservative, rows, mechanical, .. } = formed;
        let mut roots = vec![*lagrangian, *dissipation];
        roots.extend(nonconservative.iter().chain(&rows.values).chain(&rows.rates));
        let live = g.live(&roots);
        if live.len() > MAX_SCALED_NODES {
            return None;
        }
        let mut known: IdMap<Form> = IdMap::default();
        for id in live {
            let form = exponents.node(g.node(id), &known);
            known.insert(id, form);
        }
        let [time, action] = [exponents.time(), exponents.time() + 1 + n].map(single);
        if let Some(form) = value(&known, *lagrangian) {
            exponents.equate(&form, &action);
        }
        if let Some(form) = value(&known, *dissipation) {
            exponents.equate(&form, &combined(&action, &time, Number::MINUS_ONE));
        }
        for (i, force) in nonconservative.iter().enumerate() {
            let Some(form) = value(&known, *force) else { continue };
            let place = single(exponents.coordinate(i));
            // The rate of a state is that of its velocity.
            let expected = match i < *mechanical {
                true => combined(&action, &place, Number::MINUS_ONE),
                false => combined(&place, &time, Number::from(-2)),
            };
            exponents.equate(&form, &expected);
        }
        Some(exponents)
    }

    fn time(&self) -> usize {
        self.parameters.len()
    }

    fn coordinate(&self, i: usize) -> usize {
        self.time() + 1 + i
    }

    /// The exponent of a node, whose operands have theirs in `known`.
    fn node(&mut self, node: &Node, known: &IdMap<Form>) -> Form {
        let of = |v: Value| value(known, v);
        let form = match node {
            Node::Symbol(Symbol::Time) => single(self.time()),
            Node::Symbol(Symbol::Coordinate(i)) => single(self.coordinate(*i)),
            Node::Symbol(Symbol::Velocity(i)) => {
                combined(&single(self.coordinate(*i)), &single(self.time()), Number::MINUS_ONE)
            }
            Node::Symbol(Symbol::Parameter(i)) => single(self.parameters[*i]),
            Node::Symbol(other) => unreachable!("{other:?} is in no equation of motion"),
            Node::Sum(a, b) => return self.same(of(*a), of(*b)),
            Node::Product(a, b) => combined(
                &power(of((*a).into()), Number::ONE),
                &power(of((*b).into()), Number::ONE),
                Number::ONE,
            ),
            Node::Inverse(a) => power(of((*a).into()), Number::MINUS_ONE),
            Node::Call(f, a, b) => return self.call(*f, of(*a), of(*b), *b),
            Node::Extern(_, _, arguments) => {
                arguments.iter().for_each(|a| self.none(of(*a)));
                Form::new()
            }
            Node::Select(_, parts) => {
                let [a, b, yes, no] = parts.map(of);
                self.same(a, b);
                return self.same(yes, no);
            }
        };
        self.reduced(&form)
    }

    fn call(&mut self, f: Function, a: Option<Form>, b: Option<Form>, second: Value) -> Form {
        match f {
            Function::sqrt => power(a, Number::from(2).recip()),
            Function::cbrt => power(a, Number::from(3).recip()),
            Function::powf if matches!(second, Value { k: Number::Ratio(..), node: None }) => {
                power(a, second.k)
            }
            Function::abs => a.unwrap_or_default(),
            Function::signum => Form::new(),
            Function::hypot => self.same(a, b),
            Function::atan2 => {
                self.same(a, b);
                Form::new()
            }
            _ => {
                self.none(a);
                self.none(b);
                Form::new()
            }
        }
    }

    /// One exponent for two values, of which nothing is known where they are 0.
    fn same(&mut self, a: Option<Form>, b: Option<Form>) -> Form {
        match (a, b) {
            (Some(a), Some(b)) => {
                self.equate(&a, &b);
                self.reduced(&a)
            }
            (one, other) => one.or(other).unwrap_or_default(),
        }
    }

    /// Equations for the exponent of a number without units.
    fn none(&mut self, a: Option<Form>) {
        if let Some(a) = a {
            self.equate(&a, &Form::new());
        }
    }

    fn equate(&mut self, a: &Form, b: &Form) {
        if a == b {
            return;
        }
        let mut row = self.reduced(&combined(a, b, Number::MINUS_ONE));
        if let Some((last, k)) = row.pop_last() {
            let form = combined(&Form::new(), &row, k.recip().neg());
            self.solved.insert(last, form);
        }
    }

    /// The form by unknowns that are not solved for.
    fn reduced(&self, form: &Form) -> Form {
        let mut form = form.clone();
        // An unknown is replaced by those before it.
        let last = |form: &Form, below: usize| {
            form.range(..below).rev().find(|(u, _)| self.solved.contains_key(u)).map(|(u, k)| (*u, *k))
        };
        let mut below = usize::MAX;
        while let Some((unknown, k)) = last(&form, below) {
            form.remove(&unknown);
            form = combined(&form, &self.solved[&unknown], k);
            below = unknown;
        }
        form
    }

    fn scalings(&self) -> Option<Scalings> {
        let mut number = vec![0; self.parameters.len()];
        self.parameters.iter().enumerate().for_each(|(i, place)| number[*place] = i);
        let monomial = |form: &Form, sign: Number| -> Monomial {
            form.iter().map(|(u, k)| (number[*u], k.mul(sign))).collect()
        };
        let groups = (0..self.time()).filter(|u| self.solved.contains_key(u)).map(|u| {
            let rest = monomial(&self.reduced(&single(u)), Number::MINUS_ONE);
            whole([vec![(number[u], Number::ONE)], rest].concat())
        });
        let moving = self.time()..=self.time() + self.coordinates;
        let forms: Vec<Form> = moving.clone().map(|u| self.reduced(&single(u))).collect();
        if forms.iter().flat_map(Form::values).any(|k| matches!(k, Number::Float(..))) {
            return None;
        }
        let units = forms.iter().map(|form| {
            let by_parameters = form.keys().all(|u| *u < self.time());
            by_parameters.then(|| monomial(form, Number::ONE))
        });
        let similar = moving.filter(|u| !self.solved.contains_key(u)).map(|free| {
            let exponents = forms.iter().enumerate();
            let exponents = exponents.map(|(i, form)| (i, form.get(&free).copied().unwrap_or(Number::ZERO)));
            Some(whole(exponents.collect())?.into_iter().map(|(_, k)| k).collect())
        });
        let (groups, similar) = (groups.collect::<Option<_>>()?, similar.collect::<Option<_>>()?);
        Some(Scalings { groups, units: units.collect(), similar })
    }
}

fn value(known: &IdMap<Form>, v: Value) -> Option<Form> {
    (!v.is_zero())
        .then(|| v.node.map_or_else(Form::new, |id| known.get(&id).expect("operands come first").clone()))
}

fn single(unknown: usize) -> Form {
    Form::from([(unknown, Number::ONE)])
}

/// a + k b
fn combined(a: &Form, b: &Form, k: Number) -> Form {
    let mut sum = a.clone();
    for (unknown, x) in b {
        let entry = sum.entry(*unknown).or_insert(Number::ZERO);
        *entry = entry.add(x.mul(k));
        if entry.is_zero() {
            sum.remove(unknown);
        }
    }
    sum
}

fn power(form: Option<Form>, k: Number) -> Form {
    combined(&Form::new(), &form.unwrap_or_default(), k)
}

/// A power of it whose exponents are whole numbers, if these are small enough for the runtime.
fn whole(mut monomial: Monomial) -> Option<Monomial> {
    while let Some(part) = monomial.iter().find_map(|(_, k)| match k {
        Number::Ratio(_, d) if *d > 1 => Some(*d),
        _ => None,
    }) {
        monomial.iter_mut().for_each(|(_, k)| *k = k.mul(part.into()));
    }
    let is_small = |k: &Number| k.integer().is_some_and(|k| i32::try_from(k).is_ok());
    monomial.iter().all(|(_, k)| is_small(k)).then_some(monomial)
}
