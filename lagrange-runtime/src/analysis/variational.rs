//! Neighbouring motions: the variational equations along a trajectory, as a system of their own.

use super::AnalysisError;
use crate::controller::Pi;
use crate::failure::Failure;
use crate::integrate::integrate;
use crate::method::explicit_rk::Dop853;
use crate::scalar::{Dual, Scalar};
use crate::state::{State, Tangent};
use crate::system::{Lagrangian, System};
use nalgebra::{DMatrix, SVector};

/// A system together with deviations from its motion: `δq̈ = (∂q̈/∂q) δq + (∂q̈/∂q̇) δq̇` with the emitted Jacobian along
/// the trajectory (Hairer, Nørsett and Wanner, *Solving Ordinary Differential Equations I*, 1993, I.14). A system of T
/// coordinates: the N of the system, then N for each deviation. Any method integrates it, and its error control covers the
/// deviations too.
///
/// ```
/// use lagrange_runtime::analysis::Variational;
/// use lagrange_runtime::prelude::*;
///
/// lagrangian! {
///     system Oscillator {
///         param omega;
///         coord x;
///         T = 0.5 * dot(x).powi(2);
///         V = 0.5 * (omega * x).powi(2);
///     }
/// }
/// let oscillator = Oscillator::new(2.0);
/// let all = Variational::<_, 1>::new(&oscillator);
/// // x = 0.3, and two deviations: of x, and of ẋ.
/// let start = State::new(0.0, [0.3, 1.0, 0.0], [0.0, 0.0, 1.0]);
/// let end = integrate(&all, Dop853, Pi::tolerance(1e-12), start).until(1.0).finish()?;
/// assert!((end.q[1] - 2.0f64.cos()).abs() < 1e-11 && (end.q[2] - 2.0f64.sin() / 2.0).abs() < 1e-11);
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Variational<'a, Sys, const N: usize> {
    system: &'a Sys,
}

impl<'a, Sys, const N: usize> Variational<'a, Sys, N> {
    /// The system with deviations.
    pub fn new(system: &'a Sys) -> Self {
        Variational { system }
    }
}

impl<S: Scalar, Sys: Lagrangian<N, Scalar = S>, const N: usize, const T: usize> System<T>
    for Variational<'_, Sys, N>
{
    type Scalar = S;

    fn accel(&self, q: &SVector<S, T>, qd: &SVector<S, T>, t: S) -> SVector<S, T> {
        const { assert!(N > 0 && T >= N && T.is_multiple_of(N), "T is a multiple of the number of coordinates") };
        let [at, speed] = [q, qd].map(|x| SVector::<S, N>::from_fn(|i, _| x[i]));
        let mut all = SVector::from_fn(|_, _| S::zero());
        let acceleration = self.system.accel(&at, &speed, t);
        for i in 0..N {
            all[i] = acceleration[i];
        }
        let jacobian = self.system.jacobian(&at, &speed, t);
        for first in (N..T).step_by(N) {
            for i in 0..N {
                let mut sum = S::zero();
                for j in 0..N {
                    sum = jacobian.q[(i, j)].mul_add(q[first + j], sum);
                    sum = jacobian.qd[(i, j)].mul_add(qd[first + j], sum);
                }
                all[first + i] = sum;
            }
        }
        all
    }
}

/// `start`, with 2N deviations of unit length along each coordinate and each velocity.
pub(super) fn with_all_deviations<const N: usize, const T: usize>(start: &State<f64, N>) -> State<f64, T> {
    const { assert!(T == N * (1 + 2 * N), "T = N (1 + 2N)") };
    let entry = |i: usize, values: &SVector<f64, N>, offset: usize| match i {
        i if i < N => values[i],
        i => f64::from(i % N + offset == (i - N) / N),
    };
    State {
        t: start.t,
        q: SVector::from_fn(|i, _| entry(i, &start.q, 0)),
        qd: SVector::from_fn(|i, _| entry(i, &start.qd, N)),
    }
}

/// The motion and the matrix of its deviations.
pub(super) fn taken_apart<const N: usize, const T: usize>(
    all: &State<f64, T>,
) -> (State<f64, N>, DMatrix<f64>) {
    let at = State { t: all.t, q: SVector::from_fn(|i, _| all.q[i]), qd: SVector::from_fn(|i, _| all.qd[i]) };
    let deviations = (T - N) / N;
    let matrix = DMatrix::from_fn(2 * N, deviations, |i, k| {
        let first = N * (1 + k);
        if i < N { all.q[first + i] } else { all.qd[first + i - N] }
    });
    (at, matrix)
}

/// The end of a motion and its derivative by the start: the matrix `∂(q, q̇)(end)/∂(q, q̇)(start)`, `2N × 2N`. `T = N (1 +
/// 2N)`. By DOP853 at the given tolerance.
///
/// # Errors
/// [`AnalysisError::Run`].
pub fn fundamental_matrix<const T: usize, Sys: Lagrangian<N, Scalar = f64>, const N: usize>(
    system: &Sys,
    start: &State<f64, N>,
    duration: f64,
    tolerance: f64,
) -> Result<(State<f64, N>, DMatrix<f64>), AnalysisError> {
    let all = Variational::<_, N>::new(system);
    let from = with_all_deviations::<N, T>(start);
    let run = integrate(&all, Dop853, Pi::tolerance(tolerance), from).until(start.t + duration);
    let end = run.finish().map_err(|failed| failed.failure)?;
    Ok(taken_apart(&end))
}

/// What a parameter does to a motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sensitivity<const N: usize> {
    /// The end of the motion.
    pub end: State<f64, N>,
    /// Its derivative by the parameter.
    pub slope: Tangent<f64, N>,
}

/// The end of a motion and its derivative by a parameter, by dual numbers through every step: `family` makes the system
/// with the parameter's value.
///
/// ```
/// use lagrange_runtime::analysis::{Sensitivity, sensitivity};
/// use lagrange_runtime::prelude::*;
///
/// lagrangian! {
///     system Oscillator {
///         param omega;
///         coord x;
///         T = 0.5 * dot(x).powi(2);
///         V = 0.5 * (omega * x).powi(2);
///     }
/// }
/// let start = State::new(0.0, [1.0], [0.0]);
/// let Sensitivity { end, slope } = sensitivity(|omega| Oscillator { omega }, 2.0, &start, 3.0, 1e-12)?;
/// assert!((end.q[0] - 6.0f64.cos()).abs() < 1e-10 && (slope.q[0] + 3.0 * 6.0f64.sin()).abs() < 1e-9);
/// # Ok::<(), Failure<Dual<f64>>>(())
/// ```
///
/// # Errors
/// That of the run.
pub fn sensitivity<Sys: System<N, Scalar = Dual<f64>>, const N: usize>(
    family: impl Fn(Dual<f64>) -> Sys,
    parameter: f64,
    start: &State<f64, N>,
    duration: f64,
    tolerance: f64,
) -> Result<Sensitivity<N>, Failure<Dual<f64>>> {
    let system = family(Dual::variable(parameter));
    let from = State {
        t: Dual::constant(start.t),
        q: start.q.map(Dual::constant),
        qd: start.qd.map(Dual::constant),
    };
    let run = integrate(&system, Dop853, Pi::tolerance(tolerance), from);
    let end = run.until(Dual::constant(start.t + duration)).finish();
    let end = end.map_err(|failed| failed.failure)?;
    let slope = Tangent { q: end.q.map(|x| x.slope), qd: end.qd.map(|x| x.slope) };
    let end = State { t: end.t.value, q: end.q.map(|x| x.value), qd: end.qd.map(|x| x.value) };
    Ok(Sensitivity { end, slope })
}
