//! Velocities of ignorable coordinates by their momenta, which are numbers for as long as a motion lasts.
//!
//! For `p = A u + c` of the ignorable velocities u, `A = L D Lᵀ` and `L y = p − c` give
//! `u_i = (y_i − Σ_{j>i} d_i l_ji u_j)/d_i`, one after the other, where Routh's reduction would put each into the
//! next (Routh, *Stability of a Given State of Motion*, 1877). Their series follow from those of y and d without
//! their accelerations ever being formed. And what the accelerations of the others wait for is shorter: those of a
//! top by Euler's angles depend on its inclination and on no velocity but these, so every order waits for the last
//! but one.
//!
//! Order 0 is what the state says. Near a pole of angles p − c is a small difference of large numbers there, but not
//! so in the orders after it, in which p has no part.
//!
//! Velocities whose pivots do not move are put into the accelerations of the others: a momentum is the same number
//! for both then, and rounded once. (Otherwise a top's precession turns by one p and its nutation by another, and its
//! energy drifts.)

use super::form::{Form, Known};
use super::{orders::Orders, recurrence::Motion};
use crate::equations::common::MAX_EXPANDED_TERMS;
use crate::equations::solve::{Symmetric, swept};
use crate::graph::normal::EXPANSIONS;
use crate::graph::{Graph, Node, Symbol, Value};

/// The velocity of an ignorable coordinate, `over/under`.
#[derive(Clone)]
struct Ignorable {
    index: usize,
    over: Value,
    /// Without factors that do not move.
    under: Value,
}

/// Velocities of ignorable coordinates, each made of those before it, and accelerations of the others.
pub struct Conserved {
    velocities: Vec<Ignorable>,
    accelerations: Vec<(usize, Value)>,
}

/// The motion by its momenta, eliminated from the last ignorable coordinate to the first, and the other way; none
/// where there are none or they do not determine the velocities.
pub fn forms(g: &mut Graph, known: &Known) -> Vec<Conserved> {
    let (ignorable, accel) = (&known.facts.ignorable, &known.solved.accel);
    let usable = known.facts.quadratic && known.formed.rows.is_empty();
    if !usable || ignorable.is_empty() || ignorable.len() == accel.len() {
        return Vec::new();
    }
    let backward = ignorable.iter().rev().copied().collect();
    let orders: [Vec<usize>; 2] = [ignorable.clone(), backward];
    let different = if ignorable.len() > 1 { &orders[..] } else { &orders[..1] };
    let kept: Vec<usize> = (0..accel.len()).filter(|i| !ignorable.contains(i)).collect();
    let of_kept: Vec<Value> = kept.iter().map(|i| accel[*i]).collect();
    let mut forms = Vec::new();
    for order in different {
        let Some(velocities) = eliminated(g, known, order) else { continue };
        let alone = |i| velocities.iter().find(|v| v.index == i && v.under == Value::ONE).map(|v| v.over);
        let with = g.substitute(&of_kept, |s| if let Symbol::Velocity(i) = s { alone(i) } else { None });
        let expanded = EXPANSIONS.iter().filter_map(|how| g.expanded(&with, MAX_EXPANDED_TERMS, *how));
        for accelerations in [vec![of_kept.clone(), with.clone()], expanded.collect()].concat() {
            let accelerations = kept.iter().copied().zip(accelerations).collect();
            forms.push(Conserved { velocities: velocities.clone(), accelerations });
        }
    }
    forms
}

impl Form for Conserved {
    fn name(&self) -> &'static str {
        "conserved momenta"
    }

    fn values(&self) -> Vec<Value> {
        let velocities = self.velocities.iter().flat_map(|v| [v.over, v.under]);
        velocities.chain(self.accelerations.iter().map(|a| a.1)).collect()
    }

    fn advance(&self, values: &[Value], orders: &mut Orders) -> Motion {
        let (fractions, firsts) = values.split_at(2 * self.velocities.len());
        let mut velocities = Vec::new();
        for (v, fraction) in self.velocities.iter().zip(fractions.chunks(2)) {
            let symbol = Symbol::Velocity(v.index);
            let velocity = orders.fraction(symbol, fraction[0], fraction[1]);
            orders.set(symbol, velocity);
            velocities.push((v.index, velocity));
        }
        let next = orders.of(firsts);
        let kept = self.accelerations.iter().map(|(i, _)| *i);
        let accelerations = kept.zip(firsts.iter().zip(next).map(|(first, next)| [*first, next])).collect();
        Motion { accelerations, velocities, ..Motion::default() }
    }
}

fn eliminated(g: &mut Graph, known: &Known, order: &[usize]) -> Option<Vec<Ignorable>> {
    let (all, inertia) = (&known.quantities.momenta, &known.solved.inertia);
    let at_rest = |s| match s {
        Symbol::Velocity(i) if order.contains(&i) => Some(Value::ZERO),
        _ => None,
    };
    let momenta: Vec<Value> = order.iter().map(|i| all[*i]).collect();
    let c = g.substitute(&momenta, at_rest);
    let y = order.iter().zip(c).map(|(i, c)| {
        let p = g.symbol(Symbol::Conserved(*i));
        g.sub(p, c)
    });
    let mut y: Vec<Value> = y.collect();
    let lower = (0..order.len()).map(|i| {
        let entries = (0..=i).map(|j| inertia[order[i].max(order[j])][order[i].min(order[j])]);
        // Entries may name velocities that are proved to drop out.
        g.substitute(&entries.collect::<Vec<_>>(), |s| {
            matches!(s, Symbol::Velocity(_)).then_some(Value::ZERO)
        })
    });
    let mut a: Symmetric = lower.collect();
    swept(g, &mut a, &mut y)?;
    let mut found = Vec::new();
    for (k, &index) in order.iter().enumerate().rev() {
        let mut rest = y[k];
        for i in k + 1..order.len() {
            let later = g.symbol(Symbol::Velocity(order[i]));
            let product = g.mul(a[i][k], later);
            rest = g.sub(rest, product);
        }
        let velocity = g.quotient(rest, a[k][k]);
        found.push(fraction(g, index, velocity));
    }
    Some(found)
}

fn fraction(g: &mut Graph, index: usize, v: Value) -> Ignorable {
    let factors = v.node.map_or_else(Vec::new, |id| g.factors(id).to_vec());
    let under: Vec<_> = factors.iter().filter(|f| f.1 < 0 && !g.is_fixed(f.0)).map(|f| (f.0, -f.1)).collect();
    let under = if under.is_empty() { Value::ONE } else { g.assemble(&under) };
    let over = g.mul(v, under);
    Ignorable { index, over: distributed(g, over), under }
}

/// A sum times what does not move, term by term: numbers meet there, and one is left for each series.
fn distributed(g: &mut Graph, v: Value) -> Value {
    let Some(id) = v.node else { return v };
    let factors = g.factors(id).to_vec();
    let (moving, fixed): (Vec<_>, Vec<_>) = factors.into_iter().partition(|f| !g.is_fixed(f.0));
    let [(sum, 1)] = moving[..] else { return v };
    let Node::Sum(a, b) = *g.node(sum) else { return v };
    let by = if fixed.is_empty() { Value::ONE } else { g.assemble(&fixed) };
    let [a, b] = [a, b].map(|term| {
        let term = g.mul(term, by.scaled(v.k));
        distributed(g, term)
    });
    g.add(a, b)
}
