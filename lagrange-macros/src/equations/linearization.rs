//! Derivatives of `bias − force`, from which the equations of small motions are made.

use super::{Equations, JACOBIAN_BUDGET};
use crate::graph::{Symbol, Value};
use crate::schedule::count::operations;

/// `∂(bias − force)/∂q` and `∂(bias − force)/∂q̇`, by columns.
pub struct Linearization {
    pub stiffness: Vec<Vec<Value>>,
    pub damping: Vec<Vec<Value>>,
}

/// None where duals do it at run time for less than the expressions would cost to compile.
pub fn linearization(e: &mut Equations) -> Option<Linearization> {
    let (n, g) = (e.bias.len(), &mut e.model.graph);
    let residual: Vec<Value> = e.bias.iter().zip(&e.force).map(|(b, f)| g.sub(*b, *f)).collect();
    if 2 * n * operations(g, &residual).arithmetic() > JACOBIAN_BUDGET {
        return None;
    }
    let by = (0..n).map(Symbol::Coordinate).chain((0..n).map(Symbol::Velocity));
    let all: Vec<Value> =
        by.flat_map(|x| g.forward_with_limits(&residual, |s| (s == x).then_some(Value::ONE))).collect();
    let mut stiffness: Vec<Vec<Value>> = g.share_angles(&all).chunks(n).map(<[Value]>::to_vec).collect();
    let damping = stiffness.split_off(n);
    Some(Linearization { stiffness, damping })
}
