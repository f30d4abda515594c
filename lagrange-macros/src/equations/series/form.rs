//! A form of the equations of motion, of which recurrences are made.

use super::orders::Orders;
use super::recurrence::Motion;
use crate::equations::formed::Formed;
use crate::equations::quantities::Quantities;
use crate::equations::solved::Solved;
use crate::equations::structure::Facts;
use crate::graph::Value;
use crate::model::Model;

/// Results of the stages before.
pub struct Known<'a> {
    pub model: &'a Model,
    pub formed: &'a Formed,
    pub solved: &'a Solved,
    pub quantities: &'a Quantities,
    pub facts: &'a Facts,
    /// Switching functions at which impulses act.
    pub impulses: &'a [Value],
}

/// A form of the equations of motion.
pub trait Form {
    /// The form in words.
    fn name(&self) -> &'static str;

    /// Expressions whose series it needs.
    fn values(&self) -> Vec<Value>;

    /// The motion of an order, by these expressions in place of its own.
    fn advance(&self, values: &[Value], orders: &mut Orders) -> Motion;
}
