//! The matrices of small motions.

use nalgebra::DMatrix;

/// `M δq̈ + C δq̇ + K δq = f` with constant `n × n` matrices and generalized forces f (Beatty 2006, (11.86) and
/// (11.101); with gyroscopic and circulatory parts Merkin, *Introduction to the Theory of Stability*, 1997, (6.1)): C
/// is the sum of a symmetric part, damping, and an antisymmetric one, gyroscopic; K of a symmetric part, which has a
/// potential, and an antisymmetric one, circulatory.
///
/// ```
/// use lagrange_runtime::analysis::{SmallMotion, small_vibrations};
/// use lagrange_runtime::prelude::*;
///
/// lagrangian! {
///     /// Two masses between three springs.
///     system Chain {
///         param m, k;
///         coord x: [2];
///         T = 0.5 * m * (dot(x[0]).powi(2) + dot(x[1]).powi(2));
///         V = 0.5 * k * (x[0].powi(2) + (x[1] - x[0]).powi(2) + x[1].powi(2));
///     }
/// }
/// let small = small_vibrations(&Chain::new(1.0, 4.0), &[0.0, 0.0])?;
/// let modes = small.modes()?;
/// assert!((modes.frequency(0) - 2.0).abs() < 1e-15, "in phase: the spring between them is idle");
/// assert!((modes.frequency(1) - 12.0f64.sqrt()).abs() < 1e-15, "in opposition");
/// assert_eq!(modes.amplitude_ratio(1, 1, 0), -1.0);
/// # Ok::<(), lagrange_runtime::analysis::AnalysisError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct SmallMotion {
    pub(super) m: DMatrix<f64>,
    pub(super) c: DMatrix<f64>,
    pub(super) k: DMatrix<f64>,
    /// L of `M = L Lᵀ`.
    pub(super) lower: DMatrix<f64>,
    /// Uncertainties of M, C and K: their changes when the state that they belong to is rounded or corrected.
    pub(super) blur: [DMatrix<f64>; 3],
    pub(super) names: Vec<String>,
    /// Velocities of all coordinates by those of these, `δq̇ = B ẇ`.
    pub(super) basis: DMatrix<f64>,
    /// Names of coordinates whose deviations follow, each but for a constant.
    pub(super) constants: Vec<String>,
    /// Indices of coordinates that nothing acts on but inertia and gyroscopic forces, whose momenta are constant.
    pub(super) drifting: Vec<usize>,
}

/// The symmetric part of a matrix.
pub(super) fn symmetric(a: &DMatrix<f64>) -> DMatrix<f64> {
    DMatrix::from_fn(a.nrows(), a.ncols(), |i, j| 0.5 * (a[(i, j)] + a[(j, i)]))
}

/// The antisymmetric part of a matrix.
pub(super) fn antisymmetric(a: &DMatrix<f64>) -> DMatrix<f64> {
    DMatrix::from_fn(a.nrows(), a.ncols(), |i, j| 0.5 * (a[(i, j)] - a[(j, i)]))
}
