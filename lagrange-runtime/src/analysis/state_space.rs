//! The linear model (A, B, C, D) of a system with inputs and outputs.

use super::AnalysisError;
use super::eigen::eigenvalues;
use crate::input::{InputJacobian, Inputs};
use crate::lanes::Rescale;
use crate::scalar::Dual;
use crate::state::State;
use crate::system::{Jacobian, Lagrangian, System};
use nalgebra::{Complex, DMatrix, SVector};

/// `δẋ = A δx + B δu`, `δy = C δx + D δu` with x = (q, q̇): small deviations from a motion, exactly as they follow from the definition, in
/// the units of the system. With [states of first order](crate::traits::States) z, x = (q, q̇, z). Of a sampled model the first equation is `δx⁺ = A δx + B δu`.
#[derive(Clone, Debug, PartialEq)]
pub struct StateSpace {
    /// `∂ẋ/∂x`, square, of 2N rows, less one for each state of first order.
    pub a: DMatrix<f64>,
    /// `∂ẋ/∂u`, with a column for each of the K inputs.
    pub b: DMatrix<f64>,
    /// `∂y/∂x`, with a row for each of the P outputs.
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
        let inputs = system.input_jacobian(&at.q, &at.qd, at.t);
        let (kept, free) = (kept::<Sys, N>(), Self::without_inputs(system, at));
        let b =
            DMatrix::from_fn(kept.len(), K, |i, k| kept[i].checked_sub(N).map_or(0.0, |i| inputs[(i, k)]));
        StateSpace { d: DMatrix::zeros(kept.len(), K), b, ..free }
    }

    /// The model of a system about a state with its inputs, if it has any, left as they are: B and D have no columns.
    pub fn without_inputs<Sys, const N: usize>(system: &Sys, at: &State<f64, N>) -> Self
    where
        Sys: Lagrangian<N, Scalar = f64>,
    {
        let Jacobian { q, qd, .. } = system.jacobian(&at.q, &at.qd, at.t);
        let kept = kept::<Sys, N>();
        let n = kept.len();
        let a = DMatrix::from_fn(n, n, |i, j| match (kept[i].checked_sub(N), kept[j].checked_sub(N)) {
            (None, j) => f64::from(j == Some(kept[i])),
            (Some(i), None) => q[(i, kept[j])],
            (Some(i), Some(j)) => qd[(i, j)],
        });
        StateSpace { a, b: DMatrix::zeros(n, 0), c: DMatrix::identity(n, n), d: DMatrix::zeros(n, 0) }
    }

    /// Eigenvalues of A, the slowest growth first: the poles of the system, with all that its states make of it. About an equilibrium small
    /// motions decay if all have negative real parts (of a sampled model, if all are less than 1 in magnitude).
    ///
    /// # Errors
    /// [`AnalysisError::NotConverged`], [`AnalysisError::NotFinite`].
    pub fn poles(&self) -> Result<Vec<Complex<f64>>, AnalysisError> {
        let mut poles = eigenvalues(self.a.clone(), "the poles")?;
        poles.sort_by(|a, b| a.re.total_cmp(&b.re).then(a.im.total_cmp(&b.im)));
        Ok(poles)
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
        let kept = kept::<Sys, N>();
        let columns: Vec<SVector<f64, P>> = kept
            .iter()
            .copied()
            .chain(2 * N..2 * N + K)
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
        let c = DMatrix::from_fn(P, kept.len(), |i, j| columns[j][i]);
        let d = DMatrix::from_fn(P, K, |i, k| columns[kept.len() + k][i]);
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

/// The components of (q, q̇) that are part of x: all but the time integrals of states.
pub(super) fn kept<Sys: System<N>, const N: usize>() -> Vec<usize> {
    (0..N - Sys::FIRST_ORDER).chain(N..2 * N).collect()
}
