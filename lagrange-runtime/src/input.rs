//! Inputs: values of a system that are held while its motion goes on, and set between steps.

use crate::system::System;
use nalgebra::SVector;

/// A system with `K` inputs: forces, torques, commands to drives. They are constant within a step.
#[diagnostic::on_unimplemented(
    message = "`{Self}` does not have {K} inputs",
    note = "inputs are declared by `input u = 0.0;` in `lagrangian! {{ … }}`, or by implementing `Inputs<N, K>`"
)]
pub trait Inputs<const N: usize, const K: usize>: System<N> {
    /// Names of the inputs, in the order of every vector of them.
    const INPUTS: [&'static str; K];

    /// The inputs, in their own units.
    fn inputs(&self) -> SVector<Self::Scalar, K>;

    /// Sets the inputs.
    fn set_inputs(&mut self, inputs: &SVector<Self::Scalar, K>);
}
