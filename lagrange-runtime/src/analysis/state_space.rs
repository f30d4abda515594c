//! The linear model (A, B, C, D) of a system with inputs and outputs.

use super::AnalysisError;
use crate::input::{InputJacobian, Inputs};
use crate::lanes::Rescale;
use crate::scalar::Dual;
use crate::state::State;
use crate::system::{Jacobian, Lagrangian};
use nalgebra::{DMatrix, SVector};

/// `δẋ = A δx + B δu`, `δy = C δx + D δu` with x = (q, q̇): small deviations from a motion, exactly as they follow from the definition, in
/// the units of the system. Of a sampled model the first equation is `δx⁺ = A δx + B δu`.
#[derive(Clone, Debug, PartialEq)]
pub struct StateSpace {
    /// `∂ẋ/∂x`, 2N × 2N.
    pub a: DMatrix<f64>,
    /// `∂ẋ/∂u`, 2N × K.
    pub b: DMatrix<f64>,
    /// `∂y/∂x`, P × 2N.
    pub c: DMatrix<f64>,
    /// `∂y/∂u`, P × K.
    pub d: DMatrix<f64>,
}

impl StateSpace {
    /// The model about a state, with the inputs that the system has. Its output is the state itself: C = 1, D = 0. It is constant where the
    /// state is an equilibrium.
    ///
    /// ```
    /// use lagrange_runtime::analysis::StateSpace;
    /// use lagrange_runtime::prelude::*;
    /// lagrangian! {
    ///     pub system Motor {
    ///         param inertia, l, g = 9.81;
    ///         input torque;
    ///         coord theta: angle;
    ///         T = 0.5 * inertia * dot(theta).powi(2);
    ///         V = -g * l * cos(theta);
    ///         Q[theta] = torque;
    ///         observe height = -l * cos(theta);
    ///     }
    /// }
    /// let (motor, at) = (Motor::new(2.0, 0.5), State::new(0.0, [1.0], [0.0]));
    /// let model = StateSpace::about(&motor, &at).observed(&motor, &at, |motor, s| [motor.height(&s.q, &s.qd, s.t)]);
    /// assert_eq!(model.b[(1, 0)], 0.5);
    /// assert!((model.a[(1, 0)] + 9.81 * 0.5 * 1f64.cos() / 2.0).abs() < 1e-15);
    /// assert!((model.c[(0, 0)] - 0.5 * 1f64.sin()).abs() < 1e-15);
    /// ```
    pub fn about<Sys, const N: usize, const K: usize>(system: &Sys, at: &State<f64, N>) -> Self
    where
        Sys: InputJacobian<N, K, Scalar = f64> + Lagrangian<N>,
    {
        let Jacobian { q, qd, .. } = system.jacobian(&at.q, &at.qd, at.t);
        let inputs = system.input_jacobian(&at.q, &at.qd, at.t);
        let a = DMatrix::from_fn(2 * N, 2 * N, |i, j| match (i.checked_sub(N), j.checked_sub(N)) {
            (None, j) => f64::from(j == Some(i)),
            (Some(i), None) => q[(i, j)],
            (Some(i), Some(j)) => qd[(i, j)],
        });
        let b = DMatrix::from_fn(2 * N, K, |i, k| i.checked_sub(N).map_or(0.0, |i| inputs[(i, k)]));
        StateSpace { a, b, c: DMatrix::identity(2 * N, 2 * N), d: DMatrix::zeros(2 * N, K) }
    }

    /// The model with these outputs: functions of the system and its state, over dual numbers.
    pub fn observed<Sys, const N: usize, const K: usize, const P: usize>(
        self,
        system: &Sys,
        at: &State<f64, N>,
        outputs: impl Fn(&Sys::Over<Dual<f64>>, &State<Dual<f64>, N>) -> [Dual<f64>; P],
    ) -> Self
    where
        Sys: Rescale<N, Scalar = f64>,
        Sys::Over<Dual<f64>>: Inputs<N, K>,
    {
        let mut over = system.over(Dual::constant);
        let fixed = at.map(Dual::constant);
        let columns: Vec<SVector<f64, P>> = (0..2 * N + K)
            .map(|j| {
                let (mut at, mut inputs) = (fixed, over.inputs());
                let varied = if j < N {
                    &mut at.q[j]
                } else if j < 2 * N {
                    &mut at.qd[j - N]
                } else {
                    &mut inputs[j - 2 * N]
                };
                varied.slope = 1.0;
                over.set_inputs(&inputs);
                let slopes = outputs(&over, &at).map(|y| y.slope).into();
                over.set_inputs(&inputs.map(|u| Dual::constant(u.value)));
                slopes
            })
            .collect();
        let c = DMatrix::from_fn(P, 2 * N, |i, j| columns[j][i]);
        let d = DMatrix::from_fn(P, K, |i, k| columns[2 * N + k][i]);
        StateSpace { c, d, ..self }
    }

    /// The model from one instant of a sampled controller to the next, with the inputs held in between:
    /// `A = exp(A T)`, `B = ∫₀ᵀ exp(A s) ds B`, both from one exponential (Van Loan, *IEEE Trans. Automat. Contr.* 23, 1978).
    ///
    /// # Errors
    /// [`AnalysisError::NotApplicable`] unless the period is positive and finite.
    pub fn sampled(self, period: f64) -> Result<Self, AnalysisError> {
        if !(period > 0.0 && period.is_finite()) {
            return Err(AnalysisError::NotApplicable { needs: "a positive and finite period" });
        }
        let (n, k) = self.b.shape();
        let mut whole = DMatrix::zeros(n + k, n + k);
        whole.view_mut((0, 0), (n, n)).copy_from(&(&self.a * period));
        whole.view_mut((0, n), (n, k)).copy_from(&(&self.b * period));
        let whole = whole.exp();
        let [a, b] = [(0, n), (n, k)].map(|(from, count)| whole.view((0, from), (n, count)).into_owned());
        Ok(StateSpace { a, b, ..self })
    }
}
