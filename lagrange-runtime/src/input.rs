//! Inputs: values of a system that are held during a step, and set between steps.

use crate::scalar::{Dual, Scalar};
use crate::state::State;
use crate::system::{System, at_states};
use nalgebra::{SMatrix, SVector};

/// A system with `K` inputs: forces, torques, commands to drives. They are constant within a step. Emitted for every
/// system with `input`.
///
/// ```
/// use lagrange_runtime::prelude::*;
/// use lagrange_runtime::{Inputs, traits::InputJacobian};
/// lagrangian! {
///     pub system Cart {
///         param m;
///         input force;
///         coord x: length;
///         T = 0.5 * m * dot(x).powi(2);
///         V = 0;
///         Q[x] = force;
///     }
/// }
/// let mut cart = Cart::new(2.0);
/// cart.force = 3.0;
/// assert_eq!(cart.inputs()[0], 3.0);
/// assert_eq!(<Cart as Lagrangian<1>>::FACTS.inputs, ["force"]);
/// let rest = SVector::from([0.0]);
/// assert_eq!(cart.input_jacobian(&rest, &rest, 0.0)[(0, 0)], 0.5);
/// ```
#[diagnostic::on_unimplemented(
    message = "`{Self}` does not have these inputs",
    note = "inputs are declared by `input u;` in `lagrangian! {{ … }}`, or by implementing `Inputs<N, K>`"
)]
pub trait Inputs<const N: usize, const K: usize>: System<N> {
    /// Names of the inputs, in the order of every vector of them.
    const INPUTS: [&'static str; K];

    /// The K inputs, each in its own unit.
    fn inputs(&self) -> SVector<Self::Scalar, K>;

    /// Sets the K inputs, each in its own unit.
    fn set_inputs(&mut self, inputs: &SVector<Self::Scalar, K>);
}

/// Derivatives of the accelerations by the inputs.
#[diagnostic::on_unimplemented(
    message = "the derivatives of the accelerations of `{Self}` by {K} inputs are not known",
    note = "systems with `input` in `lagrangian! {{ … }}` have them; of a system without inputs `StateSpace::without_inputs` is the linear model"
)]
pub trait InputJacobian<const N: usize, const K: usize>: Inputs<N, K> {
    /// `∂q̈/∂u`, `N × K`, each column belonging to one input, in the order of [`INPUTS`](Inputs::INPUTS). The unit of
    /// an element is that of the acceleration of its row per unit of its input.
    fn input_jacobian(
        &self,
        q: &SVector<Self::Scalar, N>,
        qd: &SVector<Self::Scalar, N>,
        t: Self::Scalar,
    ) -> SMatrix<Self::Scalar, N, K>;

    at_states! {
        input_jacobian_at: input_jacobian -> SMatrix<Self::Scalar, N, K>;
    }
}

/// `∂q̈/∂u` by dual numbers, one evaluation for each input. `system` is the system over duals, with constant
/// parameters. Emitted for systems whose symbolic Jacobian would be longer than this is slow.
#[doc(hidden)]
pub fn dual_input_jacobian<S: Scalar, Sys, const N: usize, const K: usize>(
    system: &Sys,
    q: &SVector<S, N>,
    qd: &SVector<S, N>,
    t: S,
) -> SMatrix<S, N, K>
where
    Sys: Inputs<N, K, Scalar = Dual<S>> + Clone,
{
    let mut system = system.clone();
    let (q, qd, t) = (q.map(Dual::constant), qd.map(Dual::constant), Dual::constant(t));
    let inputs = system.inputs();
    let mut columns = [[S::zero(); N]; K];
    for (k, column) in columns.iter_mut().enumerate() {
        let mut varied = inputs;
        varied[k].slope = S::one();
        system.set_inputs(&varied);
        *column = system.accel(&q, &qd, t).map(|a| a.slope).into();
    }
    SMatrix::from(columns)
}
