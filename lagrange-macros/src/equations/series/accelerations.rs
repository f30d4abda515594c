//! The motion by the expressions of its accelerations.

use super::{form::Form, orders::Orders, recurrence::Motion};
use crate::graph::Value;

/// q̈, with the places of the coordinates.
pub struct Accelerations(pub Vec<Value>);

impl Form for Accelerations {
    fn name(&self) -> &'static str {
        "accelerations"
    }

    fn values(&self) -> Vec<Value> {
        self.0.clone()
    }

    fn advance(&self, values: &[Value], orders: &mut Orders) -> Motion {
        let next = orders.of(values);
        let accelerations = values.iter().zip(next).map(|(first, next)| [*first, next]).enumerate().collect();
        Motion { accelerations, ..Motion::default() }
    }
}
