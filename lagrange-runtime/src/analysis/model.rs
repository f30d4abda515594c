//! Small motions as a system of their own, for methods, samples and events.

use super::{AnalysisError, DVector, SmallMotion};
use crate::choice::{self, RecommendedMethods};
use crate::linear::factored;
use crate::system::{
    Autonomous, ConstantInertia, Facts, Independent, Jacobian, Lagrangian, LegendreTransform, Linear,
    Linearization, Linearize, System,
};
use nalgebra::{DMatrix, SMatrix, SVector};

/// The equations of small motions as a [`Lagrangian`] system: `L = ½ q̇ᵀMq̇ + ½ q̇ᵀGq − ½ qᵀKq`, `D = ½ q̇ᵀCq̇`, and
/// as forces the circulatory ones. Being [`Linear`], it is propagated exactly by
/// [`MatrixExponential`](crate::MatrixExponential). Its coordinates are deviations from the equilibrium.
///
/// ```
/// use lagrange_runtime::analysis::{LinearModel, small_vibrations};
/// use lagrange_runtime::prelude::*;
///
/// lagrangian! {
///     system Pendulum {
///         param l, g = 9.81;
///         coord theta;
///         T = 0.5 * (l * dot(theta)).powi(2);
///         V = -g * l * cos(theta);
///     }
/// }
/// let small = small_vibrations(&Pendulum::new(0.5), &[0.0])?;
/// let start = State::new(0.0, [0.01], [0.0]);
/// let model = LinearModel::<1>::new(&small)?;
/// let end = integrate(&model, MatrixExponential, FixedStep::new(3.0), start).until(3.0).final_state().map_err(|f| f.failure)?;
/// assert!((end.q[0] - 0.01 * ((9.81f64 / 0.5).sqrt() * 3.0).cos()).abs() < 1e-16);
/// # Ok::<(), lagrange_runtime::analysis::AnalysisError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinearModel<const N: usize> {
    m: SMatrix<f64, N, N>,
    c: SMatrix<f64, N, N>,
    k: SMatrix<f64, N, N>,
    /// Derivatives of the accelerations by q and q̇, `−M⁻¹ K` and `−M⁻¹ C`.
    jacobian: [SMatrix<f64, N, N>; 2],
    /// A constant force, as one of −fᵀ q in the potential, and its accelerations.
    force: [V<N>; 2],
}

impl<const N: usize> LinearModel<N> {
    /// The system of these equations, in the n = N coordinates of [`SmallMotion::names`].
    ///
    /// # Errors
    /// [`AnalysisError::Dimension`] unless there are N coordinates.
    pub fn new(small: &SmallMotion) -> Result<Self, AnalysisError> {
        if small.dimension() != N {
            return Err(AnalysisError::Dimension { expected: N, found: small.dimension() });
        }
        let (zero, axis) = (DVector::zeros(N), |i| DVector::from_fn(N, |j, _| f64::from(i == j)));
        let columns = |accelerations: &dyn Fn(usize) -> DVector<f64>| {
            SMatrix::from_columns(&std::array::from_fn::<_, N, _>(|i| V::from_fn(|j, _| accelerations(i)[j])))
        };
        let by_q = columns(&|i| small.acceleration(&axis(i), &zero));
        let by_qd = columns(&|i| small.acceleration(&zero, &axis(i)));
        let [m, c, k] = [small.inertia(), small.velocity_terms(), small.stiffness()].map(square);
        Ok(LinearModel { m, c, k, jacobian: [by_q, by_qd], force: [V::zeros(); 2] })
    }

    /// The same under a constant force.
    pub(super) fn push(&mut self, force: V<N>) {
        self.force = [force, factored(&self.m).solve(&force)];
    }

    fn gyroscopic(&self) -> SMatrix<f64, N, N> {
        (self.c - self.c.transpose()) * 0.5
    }
}

fn square<const N: usize>(a: &DMatrix<f64>) -> SMatrix<f64, N, N> {
    SMatrix::from_fn(|i, j| a[(i, j)])
}

type V<const N: usize> = SVector<f64, N>;

impl<const N: usize> System<N> for LinearModel<N> {
    type Scalar = f64;
    const AUTONOMOUS: bool = true;

    fn accel(&self, q: &V<N>, qd: &V<N>, _: f64) -> V<N> {
        let [by_q, by_qd] = &self.jacobian;
        by_q * q + by_qd * qd + self.force[1]
    }
}

impl<const N: usize> Lagrangian<N> for LinearModel<N> {
    const FACTS: Facts = Facts {
        name: "small motions",
        scleronomic: true,
        autonomous: true,
        constant_inertia: true,
        quadratic: true,
        quadratic_forces: true,
        linear: true,
        ..Facts::UNKNOWN
    };

    fn lagrangian(&self, q: &V<N>, qd: &V<N>, _: f64) -> f64 {
        let kinetic = 0.5 * (qd.dot(&(self.m * qd)) + qd.dot(&(self.gyroscopic() * q)));
        kinetic - 0.5 * q.dot(&(self.k * q)) + self.force[0].dot(q)
    }

    fn momenta(&self, q: &V<N>, qd: &V<N>, _: f64) -> V<N> {
        self.m * qd + self.gyroscopic() * q * 0.5
    }

    fn energy_function(&self, q: &V<N>, qd: &V<N>, _: f64) -> f64 {
        0.5 * (qd.dot(&(self.m * qd)) + q.dot(&(self.k * q))) - self.force[0].dot(q)
    }

    fn inertia(&self, _: &V<N>, _: &V<N>, _: f64) -> SMatrix<f64, N, N> {
        self.m
    }

    fn convective_momentum_rate(&self, _: &V<N>, qd: &V<N>, _: f64) -> V<N> {
        self.gyroscopic() * qd * 0.5
    }

    fn momentum_rate(&self, q: &V<N>, qd: &V<N>, _: f64) -> V<N> {
        self.force[0] + self.gyroscopic() * qd * 0.5 - self.c * qd - self.k * q
    }

    fn dissipation(&self, _: &V<N>, qd: &V<N>, _: f64) -> f64 {
        0.5 * qd.dot(&(self.c * qd))
    }

    fn power(&self, q: &V<N>, qd: &V<N>, _: f64) -> f64 {
        let circulatory = (self.k - self.k.transpose()) * 0.5;
        -qd.dot(&(self.c * qd)) - qd.dot(&(circulatory * q))
    }

    fn jacobian(&self, _: &V<N>, _: &V<N>, _: f64) -> Jacobian<f64, N> {
        let [q, qd] = self.jacobian;
        Jacobian { q, qd, t: V::zeros() }
    }
}

impl<const N: usize> Linearize<N> for LinearModel<N> {
    fn linearize(&self, _: &V<N>, _: &V<N>, _: f64) -> Linearization<f64, N> {
        Linearization { stiffness: self.k, damping: self.c }
    }
}

impl<const N: usize> LegendreTransform<N> for LinearModel<N> {
    fn velocities(&self, q: &V<N>, p: &V<N>, _: f64) -> V<N> {
        factored(&self.m).solve(&(p - self.gyroscopic() * q * 0.5))
    }
}

#[diagnostic::do_not_recommend]
impl<const N: usize> Independent<N> for LinearModel<N> {}
#[diagnostic::do_not_recommend]
impl<const N: usize> ConstantInertia<N> for LinearModel<N> {}
impl<const N: usize> Autonomous<N> for LinearModel<N> {}
#[diagnostic::do_not_recommend]
impl<const N: usize> Linear<N> for LinearModel<N> {}
#[diagnostic::do_not_recommend]
impl<const N: usize> RecommendedMethods<N> for LinearModel<N> {
    type Accurate = choice::Accurate<false>;
    type Fine = choice::Fine<false, false>;
    type FineControl = choice::FineControl<false>;
    type Geometric = choice::Geometric<false, false, false>;
}
