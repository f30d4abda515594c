//! Numbers times numbers, and multiples of one series, as one number times the series.
//!
//! A graph that is made for one evaluation shares `m l` and `m l x` where it can. In recurrences each such product is one more thing to wait for
//! in every order, while numbers are multiplied with each other once a step.

use super::{Rule, is_number};
use crate::graph::{Graph, Id, Value, stable_map::IdMap};

/// The rules with multiples of multiples of a series as multiples of it, alone and where they are like terms of a sum; of the others
/// what is `needed`.
pub fn combined(g: &mut Graph, rules: Vec<(Id, Rule)>, needed: Vec<Value>) -> Vec<(Id, Rule)> {
    let mut multiples: IdMap<(Value, Id)> = IdMap::default();
    let rules = rules.into_iter().map(|(id, rule)| {
        let Rule::Linear(terms) = rule else { return (id, rule) };
        let moving: Vec<(Value, Value)> = terms.iter().copied().filter(|(_, x)| !is_number(g, *x)).collect();
        let mut sum: Vec<(Value, Id)> = Vec::new();
        for &(factor, x) in &moving {
            let Some(of) = x.node else { continue };
            let (by, of) = multiples.get(&of).copied().unwrap_or((Value::ONE, of));
            let by = g.mul(by, factor.scaled(x.k));
            match sum.iter_mut().find(|(_, other)| *other == of) {
                Some((all, _)) => *all = g.add(*all, by),
                None => sum.push((by, of)),
            }
        }
        if let [multiple] = sum[..] {
            multiples.insert(id, multiple);
        } else if sum.len() == moving.len() {
            return (id, Rule::Linear(moving));
        }
        let term = |(by, of): (Value, Id)| match by.node {
            Some(_) => (by, Value::from(of)),
            None => (Value::ONE, Value::from(of).scaled(by.k)),
        };
        (id, Rule::Linear(sum.into_iter().filter(|(by, _)| !by.is_zero()).map(term).collect()))
    });
    let rules: Vec<(Id, Rule)> = rules.collect();
    live(rules, needed)
}

/// Those that are needed, and those that these need.
fn live(rules: Vec<(Id, Rule)>, needed: Vec<Value>) -> Vec<(Id, Rule)> {
    let mut rows: IdMap<usize> = IdMap::default();
    rules.iter().enumerate().for_each(|(row, (id, _))| rows.insert(*id, row));
    let mut is_live = vec![false; rules.len()];
    let mut stack: Vec<Id> = needed.into_iter().filter_map(|v| v.node).collect();
    while let Some(id) = stack.pop() {
        let Some(&row) = rows.get(&id) else { continue };
        if !std::mem::replace(&mut is_live[row], true) {
            rules[row].1.operands(|v| stack.extend(v.node));
        }
    }
    rules.into_iter().zip(is_live).filter(|(_, is_live)| *is_live).map(|(rule, _)| rule).collect()
}
