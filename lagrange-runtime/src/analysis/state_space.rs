//! The linear model (A, B, C, D) of a system with inputs and outputs.

use super::AnalysisError;
use super::constrained::held;
use super::eigen::eigenvalues;
use super::exponential;
use super::kink::{BESIDE, jumps};
use super::switch::{DISPLACEMENTS, Equations, shrinks, smooth};
use super::tangent::{ACTS, TangentSpace, dynamic, units};
use crate::input::{InputJacobian, Inputs};
use crate::lanes::Rescale;
use crate::scalar::Dual;
use crate::state::State;
use crate::system::{Jacobian, Lagrangian, System};
use nalgebra::{Complex, DMatrix};

/// `δẋ = A δx + B δu`, `δy = C δx + D δu`: small deviations from a motion, exactly as they follow from the
/// definition, in the units of the system. Of a sampled model the first equation is `δx⁺ = A δx + B δu`.
///
/// The states are x = (q, q̇), and with [states of first order](crate::traits::States) z, x = (q, q̇, z). With
/// constraints they are minimal: deviations of as many coordinates as constraints on positions leave, then of as many
/// velocities as all constraints leave ([`StateSpace::states`]), and `δ(q, q̇) = basis δx`.
#[derive(Clone, Debug, PartialEq)]
pub struct StateSpace {
    /// `∂ẋ/∂x`, n × n.
    pub a: DMatrix<f64>,
    /// `∂ẋ/∂u`, n × K, with a column for each of the K inputs.
    pub b: DMatrix<f64>,
    /// `∂y/∂x`, P × n, with a row for each of the P outputs.
    pub c: DMatrix<f64>,
    /// `∂y/∂u`, P × K.
    pub d: DMatrix<f64>,
    /// `∂(q, q̇)/∂x`, 2N × n: the unit matrix where coordinates are independent.
    pub basis: DMatrix<f64>,
    /// Index of each state in (q, q̇): below N it is the deviation of a coordinate, from N on that of a velocity.
    pub states: Vec<usize>,
    /// Does time appear in the equations, so that A and B may hold at one instant alone? It is false where
    /// [`Facts::autonomous`](crate::Facts::autonomous) is proved, and without inputs where
    /// [`Facts::linear`](crate::Facts::linear) is. Set it to false if A and B are constant, as beside a load f(t).
    pub time_dependent: bool,
}

impl StateSpace {
    /// The model about a state, with the inputs that the system has. Its output is the state itself: C = 1, D = 0. It
    /// is constant where the state is an equilibrium or a steady motion.
    ///
    /// # Hypotheses
    /// - The state is on the constraints, if there are any, and they are independent there: otherwise
    ///   [`AnalysisError::OffConstraints`], [`AnalysisError::DependentConstraints`].
    /// - No input appears in a constraint: otherwise [`AnalysisError::ConstrainedInput`].
    /// - Accelerations and their derivatives are finite: otherwise [`AnalysisError::NotFinite`].
    /// - The state is on no switch of the forces at which they or their derivatives jump, as Coulomb friction is at
    ///   rest: otherwise [`AnalysisError::Switch`]. It is on no kink of a function with data: otherwise
    ///   [`AnalysisError::Kink`]. No input is, as one at the limit of a `clamp`: otherwise
    ///   [`AnalysisError::SwitchedInput`].
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
    /// let model = StateSpace::about(&motor, &at)?.observed(&motor, &at, |motor, s| [motor.height_at(s)])?;
    /// assert_eq!(model.b[(1, 0)], 0.5);
    /// assert!((model.a[(1, 0)] + 9.81 * 0.5 * 1f64.cos() / 2.0).abs() < 1e-15);
    /// assert!((model.c[(0, 0)] - 0.5 * 1f64.sin()).abs() < 1e-15);
    /// # Ok::<(), lagrange_runtime::analysis::AnalysisError>(())
    /// ```
    pub fn about<Sys, const N: usize, const K: usize>(
        system: &Sys,
        at: &State<f64, N>,
    ) -> Result<Self, AnalysisError>
    where
        Sys: InputJacobian<N, K, Scalar = f64> + Lagrangian<N> + Clone,
    {
        smooth(system, at, 0.0, accelerations)?;
        let inputs = system.input_jacobian(&at.q, &at.qd, at.t);
        let by_inputs = DMatrix::from_fn(N, K, |i, k| inputs[(i, k)]);
        if let Some(constraint) = Sys::FACTS.constraints.iter().find(|constraint| constraint.has_input) {
            return Err(AnalysisError::ConstrainedInput { constraint: constraint.name });
        }
        let free = Self::regular(system, at)?;
        if by_inputs.iter().any(|x| !x.is_finite()) {
            return Err(AnalysisError::NotFinite);
        }
        smooth_in_inputs(system, at)?;
        let rates = |i: usize, k: usize| free.states[i].checked_sub(N).map_or(0.0, |i| by_inputs[(i, k)]);
        let n = free.states.len();
        let (b, d, time_dependent) =
            (DMatrix::from_fn(n, K, rates), DMatrix::zeros(n, K), !Sys::FACTS.autonomous);
        Ok(StateSpace { b, d, time_dependent, ..free })
    }

    /// The model of a system about a state with its inputs, if it has any, left as they are: B and D have no columns.
    ///
    /// # Errors
    /// Those of [`StateSpace::about`], but for its inputs.
    pub fn without_inputs<Sys, const N: usize>(
        system: &Sys,
        at: &State<f64, N>,
    ) -> Result<Self, AnalysisError>
    where
        Sys: Lagrangian<N, Scalar = f64>,
    {
        smooth(system, at, 0.0, accelerations)?;
        Self::regular(system, at)
    }

    /// The model about a state that is on no switch.
    pub(super) fn regular<Sys, const N: usize>(
        system: &Sys,
        at: &State<f64, N>,
    ) -> Result<Self, AnalysisError>
    where
        Sys: Lagrangian<N, Scalar = f64>,
    {
        let Jacobian { q, qd, .. } = system.jacobian(&at.q, &at.qd, at.t);
        let (basis, states) = admissible(system, at)?;
        if !q.iter().chain(&qd).all(|x| x.is_finite()) {
            return Err(AnalysisError::NotFinite);
        }
        let (displaced, moved) = (basis.rows(0, N), basis.rows(N, N));
        let mut rates = DMatrix::zeros(2 * N, basis.ncols());
        rates.rows_mut(0, N).copy_from(&moved);
        rates.rows_mut(N, N).copy_from(&(dynamic(&q) * displaced + dynamic(&qd) * moved));
        let (a, n) = (rates.select_rows(&states), states.len());
        let (b, c, d) = (DMatrix::zeros(n, 0), DMatrix::identity(n, n), DMatrix::zeros(n, 0));
        // (Of a linear system time is in a load alone, but that it may multiply inputs.)
        let time_dependent = !(Sys::FACTS.autonomous || Sys::FACTS.linear);
        Ok(StateSpace { a, b, c, d, basis, states, time_dependent })
    }

    /// Eigenvalues of A, in 1/s and increasing order of real parts: the poles of the system, with all that its states
    /// make of it. (Those of a sampled model are numbers without a unit.)
    /// About an equilibrium small motions decay if all have negative real parts (of a sampled model, if all are less
    /// than 1 in magnitude).
    ///
    /// # Errors
    /// [`AnalysisError::NotConverged`], [`AnalysisError::NotFinite`].
    pub fn poles(&self) -> Result<Vec<Complex<f64>>, AnalysisError> {
        let mut poles = eigenvalues(self.a.clone(), "the poles")?;
        poles.sort_by(|a, b| a.re.total_cmp(&b.re).then(a.im.total_cmp(&b.im)));
        Ok(poles)
    }

    /// The model with these outputs: functions of the system and its state, over dual numbers.
    ///
    /// # Errors
    /// - [`AnalysisError::SwitchedOutput`] where an output or its derivatives jump along a state or an input, as
    ///   `x.abs()` does at 0;
    /// - [`AnalysisError::NotApplicable`] where one depends on the time integral of a state of first order, as on a
    ///   charge: the model has no state for it.
    pub fn observed<Sys, const N: usize, const K: usize, const P: usize>(
        self,
        system: &Sys,
        at: &State<f64, N>,
        outputs: impl Fn(&Sys::Over<Dual<f64>>, &State<Dual<f64>, N>) -> [Dual<f64>; P],
    ) -> Result<Self, AnalysisError>
    where
        Sys: Rescale<N, Scalar = f64>,
        Sys::Over<Dual<f64>>: Inputs<N, K>,
    {
        let (n, here) = (self.states.len(), system.over(Dual::constant).inputs());
        // Outputs and their derivatives along a state or an input, at a distance along it.
        let along = |j: usize, far: f64| {
            let moved = Dual { value: far, slope: 1.0 };
            let (mut at, mut over) = (at.map(Dual::constant), system.over(Dual::constant));
            if j < n {
                for i in 0..N {
                    at.q[i] += Dual::constant(self.basis[(i, j)]) * moved;
                    at.qd[i] += Dual::constant(self.basis[(N + i, j)]) * moved;
                }
            } else {
                let mut inputs = here;
                inputs[j - n] += moved;
                over.set_inputs(&inputs);
            }
            outputs(&over, &at)
        };
        let size = |j: usize| match self.states.get(j) {
            Some(&i) if i < N => at.q[i],
            Some(&i) => at.qd[i - N],
            None => here[j - n].value,
        };
        for j in 0..n + K {
            let h = BESIDE * (1.0 + size(j).abs());
            for output in 0..P {
                let beside = |far: f64| {
                    let y = along(j, far * h)[output];
                    [y.value, y.slope].map(|y| DMatrix::from_element(1, 1, y))
                };
                if jumps(beside) {
                    return Err(AnalysisError::SwitchedOutput { output });
                }
            }
        }
        for i in N - Sys::FIRST_ORDER..N {
            let (mut at, over) = (at.map(Dual::constant), system.over(Dual::constant));
            at.q[i].slope = 1.0;
            if outputs(&over, &at).iter().any(|y| y.slope != 0.0) {
                let needs = "outputs without the time integral of a state: a state of its own has it, `state charge; rate(charge) = i;`";
                return Err(AnalysisError::NotApplicable { needs });
            }
        }
        let slopes: Vec<[f64; P]> = (0..n + K).map(|j| along(j, 0.0).map(|y| y.slope)).collect();
        let c = DMatrix::from_fn(P, n, |i, j| slopes[j][i]);
        let d = DMatrix::from_fn(P, K, |i, k| slopes[n + k][i]);
        Ok(StateSpace { c, d, ..self })
    }

    /// The model from one sampling instant of a digital controller to the next, T = `period` later in units of t, with
    /// a zero-order hold of the inputs: `A = exp(A T)`, `B = ∫₀ᵀ exp(A s) ds B`, in double-double arithmetic. Poles
    /// that are so fast that they have long decayed cost slow ones no digits.
    ///
    /// # Hypotheses
    /// - A and B are constant, see [`StateSpace::time_dependent`].
    /// - 32 digits resolve the motion over the period, by a bound of the rounding errors: oscillations that decay
    ///   slowly may turn by 1e11 rad.
    ///
    /// # Errors
    /// [`AnalysisError::TimeDependent`]; [`AnalysisError::NotApplicable`] unless the period is positive and finite, and
    /// where the last hypothesis does not hold; [`AnalysisError::NotFinite`] where an entry overflows, as of an
    /// unstable system over a long period.
    ///
    /// ```
    /// use lagrange_runtime::analysis::StateSpace;
    /// use lagrange_runtime::prelude::*;
    /// lagrangian! {
    ///     /// A weight in honey: the velocity decays within 1e-15 s, the displacement within a quarter of a second.
    ///     pub system Honey {
    ///         param m = 1, k = 4e15, c = 1e15;
    ///         input u;
    ///         coord x;
    ///         T = 0.5 * m * dot(x).powi(2);
    ///         V = 0.5 * k * x.powi(2);
    ///         D = 0.5 * c * dot(x).powi(2);
    ///         Q[x] = u;
    ///     }
    /// }
    /// let model = StateSpace::about(&Honey::default(), &State::new(0.0, [0.0], [0.0]))?.sampled(0.1)?;
    /// assert!((model.a[(0, 0)] - (-0.4f64).exp()).abs() < 1e-14);
    /// # Ok::<(), lagrange_runtime::analysis::AnalysisError>(())
    /// ```
    pub fn sampled(self, period: f64) -> Result<Self, AnalysisError> {
        if !(period > 0.0 && period.is_finite()) {
            return Err(AnalysisError::NotApplicable { needs: "a positive and finite period" });
        }
        if self.time_dependent {
            return Err(AnalysisError::TimeDependent);
        }
        let [a, b] = exponential::held(&self.a, &self.b, period)?;
        Ok(StateSpace { a, b, ..self })
    }
}

/// Refuses inputs on whose two sides accelerations or their derivatives differ.
fn smooth_in_inputs<Sys, const N: usize, const K: usize>(
    system: &Sys,
    at: &State<f64, N>,
) -> Result<(), AnalysisError>
where
    Sys: InputJacobian<N, K, Scalar = f64> + Lagrangian<N> + Clone,
{
    let inputs = system.inputs();
    let beside = |k: usize, h: f64| {
        let (mut system, mut inputs) = (system.clone(), inputs);
        inputs[k] += h * (1.0 + inputs[k].abs());
        system.set_inputs(&inputs);
        let by = system.input_jacobian(&at.q, &at.qd, at.t);
        let [accel, _, qd, q] = accelerations(&system, at);
        [accel, DMatrix::from_fn(N, K, |i, k| by[(i, k)]), qd, q]
    };
    for k in 0..K {
        let sides = DISPLACEMENTS.map(|h| [-h, h].map(|h| beside(k, h)));
        for which in 0..4 {
            let spread = sides.each_ref().map(|[below, above]| (&above[which] - &below[which]).amax());
            let size = sides[1].iter().map(|side| side[which].amax()).fold(0.0, f64::max);
            // (Beyond the last place of a table nothing is known: the other side alone counts.)
            let known = spread.iter().all(|x| x.is_finite());
            if known && !shrinks(spread, size) {
                return Err(AnalysisError::SwitchedInput { input: Sys::INPUTS[k] });
            }
        }
    }
    Ok(())
}

/// q̈, 1, ∂q̈/∂q̇ and ∂q̈/∂q at a state.
pub(super) fn accelerations<Sys: Lagrangian<N, Scalar = f64>, const N: usize>(
    system: &Sys,
    at: &State<f64, N>,
) -> Equations {
    let by = system.jacobian(&at.q, &at.qd, at.t);
    let accel = system.accel(&at.q, &at.qd, at.t);
    let [q, qd] = [by.q, by.qd].map(|a| DMatrix::from_fn(N, N, |i, j| a[(i, j)]));
    [DMatrix::from_column_slice(N, 1, accel.as_slice()), DMatrix::identity(N, N), qd, q]
}

/// The components of (q, q̇) that are part of x: all but the time integrals of states.
fn kept<Sys: System<N>, const N: usize>() -> Vec<usize> {
    (0..N - Sys::FIRST_ORDER).chain(N..2 * N).collect()
}

/// `∂(q, q̇)/∂x` and the indices of the states x.
fn admissible<Sys: Lagrangian<N, Scalar = f64>, const N: usize>(
    system: &Sys,
    at: &State<f64, N>,
) -> Result<(DMatrix<f64>, Vec<usize>), AnalysisError> {
    if Sys::FACTS.constraints.is_empty() {
        let kept = kept::<Sys, N>();
        return Ok((DMatrix::identity(2 * N, 2 * N).select_columns(&kept), kept));
    }
    let all = held(system, at)?;
    let units = units(&dynamic(&system.inertia(&at.q, &at.qd, at.t)));
    let space = TangentSpace::new(&all, &units, &[ACTS; N])?;
    Ok(space.states(N - Sys::FIRST_ORDER))
}
