//! The motion by ṗ = f with p = ∂L/∂q̇(q, q̇, t) and f = ∂L/∂q − ∂D/∂q̇ + Q, which are as long as what was written:
//! k p_k = f_{k−1}, and p_k is what it is without q̇_k, and M_0 q̇_k more.

use super::{form::Form, orders::Orders, recurrence::Motion, substitution::Substitution};
use crate::equations::common::momenta_of_states;
use crate::equations::formed::Formed;
use crate::graph::{Graph, Symbol, Value};
use std::rc::Rc;

pub struct Momenta {
    name: &'static str,
    momenta: Vec<Value>,
    force: Vec<Value>,
    /// M⁻¹
    solution: Rc<Substitution>,
}

/// ṗ = f as it follows from what was written, and with angles' sines and cosines from each other's.
pub fn forms(g: &mut Graph, formed: &Formed, solution: &Rc<Substitution>) -> Vec<Momenta> {
    let n = formed.momenta.len();
    let all: Vec<Symbol> = (0..n).map(Symbol::Velocity).chain((0..n).map(Symbol::Coordinate)).collect();
    let mut gradient = g.gradient(formed.lagrangian, &all);
    momenta_of_states(g, formed.mechanical, &mut gradient[..n]);
    for (slope, rest) in gradient[n..].iter_mut().zip(&formed.nonconservative) {
        *slope = g.add(*slope, *rest);
    }
    let shared = g.share_angles(&gradient);
    let shared = Some(("momenta, angles shared", shared)).filter(|(_, shared)| *shared != gradient);
    let form = |(name, mut momenta): (_, Vec<Value>)| {
        let force = momenta.split_off(n);
        Momenta { name, momenta, force, solution: Rc::clone(solution) }
    };
    [("momenta", gradient)].into_iter().chain(shared).map(form).collect()
}

impl Form for Momenta {
    fn name(&self) -> &'static str {
        self.name
    }

    fn values(&self) -> Vec<Value> {
        [&self.momenta[..], &self.force].concat()
    }

    fn advance(&self, values: &[Value], orders: &mut Orders) -> Motion {
        let (momenta, force) = values.split_at(self.momenta.len());
        (0..momenta.len()).for_each(|i| orders.set(Symbol::Velocity(i), Value::ZERO));
        let without = orders.of(momenta);
        let rights = without.iter().zip(force).map(|(p, f)| {
            let f = orders.before(*f);
            let f = orders.over(f);
            orders.g.minus(f, *p)
        });
        let rights: Vec<Value> = rights.collect();
        let velocities = self.solution.solve(orders.g, &rights);
        orders.forget();
        velocities.iter().enumerate().for_each(|(i, v)| orders.set(Symbol::Velocity(i), *v));
        Motion { velocities: velocities.into_iter().enumerate().collect(), ..Motion::default() }
    }
}
