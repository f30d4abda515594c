//! Small motions as a system of their own, for methods, samples and events.

use super::{AnalysisError, DVector, SmallMotion};
use crate::choice::{self, RecommendedMethods};
use crate::system::{
    Autonomous, ConstantInertia, Facts, Independent, Jacobian, Lagrangian, Linear, Linearization, Linearize,
    System,
};
use nalgebra::{DMatrix, SMatrix, SVector};

/// The equations of small motions as a [`Lagrangian`] system: `L = ½ q̇ᵀMq̇ + ½ q̇ᵀGq − ½ qᵀKq`, `D = ½ q̇ᵀCq̇`, and
/// as forces the circulatory ones. Being [`Linear`], it is propagated exactly by
/// [`MatrixExponential`](crate::MatrixExponential).
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
#[derive(Clone, Debug, PartialEq)]
pub struct LinearModel<const N: usize> {
    small: SmallMotion,
}

impl<const N: usize> LinearModel<N> {
    /// The system of these equations.
    ///
    /// # Errors
    /// [`AnalysisError::Dimension`] unless there are N coordinates.
    pub fn new(small: &SmallMotion) -> Result<Self, AnalysisError> {
        match small.dimension() {
            n if n == N => Ok(LinearModel { small: small.clone() }),
            found => Err(AnalysisError::Dimension { expected: N, found }),
        }
    }

    fn product(&self, a: &DMatrix<f64>, x: &SVector<f64, N>) -> SVector<f64, N> {
        fixed(&(a * dynamic(x)))
    }

    /// `xᵀ A y`
    fn form(&self, x: &SVector<f64, N>, a: &DMatrix<f64>, y: &SVector<f64, N>) -> f64 {
        x.dot(&self.product(a, y))
    }
}

fn dynamic<const N: usize>(x: &SVector<f64, N>) -> DVector<f64> {
    DVector::from_column_slice(x.as_slice())
}

fn fixed<const N: usize>(x: &DVector<f64>) -> SVector<f64, N> {
    SVector::from_fn(|i, _| x[i])
}

fn square<const N: usize>(a: &DMatrix<f64>) -> SMatrix<f64, N, N> {
    SMatrix::from_fn(|i, j| a[(i, j)])
}

type V<const N: usize> = SVector<f64, N>;

impl<const N: usize> System<N> for LinearModel<N> {
    type Scalar = f64;
    const AUTONOMOUS: bool = true;

    fn accel(&self, q: &V<N>, qd: &V<N>, _: f64) -> V<N> {
        fixed(&self.small.acceleration(&dynamic(q), &dynamic(qd)))
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
        let s = &self.small;
        0.5 * (self.form(qd, s.inertia(), qd) + self.form(qd, &s.gyroscopic(), q)
            - self.form(q, s.stiffness(), q))
    }

    fn momenta(&self, q: &V<N>, qd: &V<N>, _: f64) -> V<N> {
        self.product(self.small.inertia(), qd) + self.product(&self.small.gyroscopic(), q) * 0.5
    }

    fn energy_function(&self, q: &V<N>, qd: &V<N>, _: f64) -> f64 {
        0.5 * (self.form(qd, self.small.inertia(), qd) + self.form(q, self.small.stiffness(), q))
    }

    fn inertia(&self, _: &V<N>, _: &V<N>, _: f64) -> SMatrix<f64, N, N> {
        square(self.small.inertia())
    }

    fn convective_momentum_rate(&self, _: &V<N>, qd: &V<N>, _: f64) -> V<N> {
        self.product(&self.small.gyroscopic(), qd) * 0.5
    }

    fn momentum_rate(&self, q: &V<N>, qd: &V<N>, _: f64) -> V<N> {
        let s = &self.small;
        let rest = self.product(s.velocity_terms(), qd) + self.product(s.stiffness(), q);
        self.product(&s.gyroscopic(), qd) * 0.5 - rest
    }

    fn dissipation(&self, _: &V<N>, qd: &V<N>, _: f64) -> f64 {
        0.5 * self.form(qd, self.small.velocity_terms(), qd)
    }

    fn power(&self, q: &V<N>, qd: &V<N>, _: f64) -> f64 {
        -self.form(qd, self.small.velocity_terms(), qd) - self.form(qd, &self.small.circulatory(), q)
    }

    fn jacobian(&self, _: &V<N>, _: &V<N>, _: f64) -> Jacobian<f64, N> {
        let zero = DVector::zeros(N);
        let (mut q, mut qd) = (SMatrix::<f64, N, N>::zeros(), SMatrix::<f64, N, N>::zeros());
        for i in 0..N {
            let axis = DVector::from_fn(N, |j, _| f64::from(i == j));
            q.set_column(i, &fixed::<N>(&self.small.acceleration(&axis, &zero)));
            qd.set_column(i, &fixed::<N>(&self.small.acceleration(&zero, &axis)));
        }
        Jacobian { q, qd, t: SVector::zeros() }
    }
}

impl<const N: usize> Linearize<N> for LinearModel<N> {
    fn linearize(&self, _: &V<N>, _: &V<N>, _: f64) -> Linearization<f64, N> {
        Linearization {
            stiffness: square(self.small.stiffness()),
            damping: square(self.small.velocity_terms()),
        }
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
