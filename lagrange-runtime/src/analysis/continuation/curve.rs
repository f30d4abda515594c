//! Points of a curve of equilibria: correction onto it, tangents, and the signs that change where it branches.

use crate::analysis::balance::{balanced, smallest_solution};
use crate::analysis::{AnalysisError, SmallMotion, Stability};
use nalgebra::{DMatrix, DVector, SVD};

/// The equations `F(z) = 0` of a curve, z = (q, μ), as `dyn`, so that all of this is compiled once.
pub(super) trait Equations {
    /// `F` and `J = (∂F/∂q, ∂F/∂μ)` in units of the components of F.
    fn look(&self, z: &DVector<f64>) -> (DVector<f64>, DMatrix<f64>);
    /// `∂(Jᵀψ)/∂z`, symmetric.
    fn curvature(&self, z: &DVector<f64>, psi: &DVector<f64>) -> DMatrix<f64>;
    /// Small motions about the equilibrium.
    fn small(&self, z: &DVector<f64>) -> Result<SmallMotion, AnalysisError>;
    /// Number of eigenvalues of K with a negative real part, of which J is at hand.
    fn negative(&self, z: &DVector<f64>, jacobian: &DMatrix<f64>) -> Result<usize, AnalysisError>;
    /// Stability of the equilibrium with these small motions.
    fn stability(&self, z: &DVector<f64>, small: &SmallMotion) -> Result<Stability, AnalysisError>;
    /// Are the gradients of constraints oriented alike at two points of a curve? Between those that are not,
    /// constraints are dependent.
    fn oriented_alike(&self, _: &DVector<f64>, _: &DVector<f64>) -> bool {
        true
    }
    /// The error of a place near a position in which constraints are dependent: curves are lost there, since any
    /// multiplier of the forces that vanish belongs to an equilibrium.
    fn nearly_dependent(&self, _: &DVector<f64>) -> Option<AnalysisError> {
        None
    }
    /// Values of the switching functions.
    fn switching(&self, z: &DVector<f64>) -> Vec<f64>;
    /// Point and direction by the parameters with which a step begins, where those of an attitude are too long.
    fn turned(&self, z: &DVector<f64>, direction: &DVector<f64>) -> Option<[DVector<f64>; 2]>;
    /// Refuses a point on a switch.
    fn smooth(&self, z: &DVector<f64>) -> Result<(), AnalysisError>;
}

/// Corrections below this, relative to `1 + |z|`, are small enough to end Newton's method where they shrink no more.
const CONVERGED: f64 = 1e-9;

/// Rounding error of the singular values of a matrix with n rows, relative to the largest.
pub(super) fn flat(n: usize) -> f64 {
    64.0 * n as f64 * f64::EPSILON
}

/// A point of the curve.
#[derive(Clone)]
pub(super) struct Place {
    pub z: DVector<f64>,
    /// Unit tangent.
    pub tangent: DVector<f64>,
    /// Singular values of the Jacobian with the tangent below, in decreasing order, and their vectors.
    svd: SVD<f64, nalgebra::Dyn, nalgebra::Dyn>,
    /// Eigenvalues of K with a negative real part.
    pub negative: usize,
}

impl Place {
    /// Parameter's part of the tangent, which changes sign at a fold.
    pub fn turn(&self) -> f64 {
        self.tangent[self.tangent.len() - 1]
    }

    /// Number of vanishing singular values: dimensions of the set of equilibria here besides the curve's own.
    pub fn nullity(&self) -> usize {
        let rounding = flat(self.z.len()) * self.svd.singular_values[0];
        self.svd.singular_values.iter().filter(|x| **x <= rounding).count()
    }

    /// Least singular value but for the `idle` ones that vanish all along the curve, with the sign of the
    /// determinant: it changes sign at a branch point of odd multiplicity.
    pub fn volume(&self, idle: usize) -> f64 {
        let n = self.z.len();
        let (Some(u), Some(v)) = (&self.svd.u, &self.svd.v_t) else { return f64::NAN };
        // Left and right vectors of idle values are oriented by each other.
        let pairing = v.rows(n - idle, idle) * u.columns(n - idle, idle);
        let idle_sign = if idle == 0 { 1.0 } else { pairing.determinant() };
        (u.determinant() * v.determinant() * idle_sign).signum() * self.svd.singular_values[n - 1 - idle]
    }

    /// Largest singular value.
    pub fn size(&self) -> f64 {
        self.svd.singular_values[0]
    }

    /// Directions in (q, μ) in which equilibria lie beside the curve.
    pub fn idle(&self) -> DMatrix<f64> {
        let (n, idle) = (self.z.len(), self.nullity());
        self.svd.v_t.as_ref().map_or_else(|| DMatrix::zeros(n, 0), |v| v.rows(n - idle, idle).transpose())
    }

    /// Generalized forces that no displacement changes, to first order.
    pub fn unmoved(&self) -> DMatrix<f64> {
        let (n, idle) = (self.z.len(), self.nullity());
        let none = || DMatrix::zeros(n - 1, 0);
        self.svd.u.as_ref().map_or_else(none, |u| u.view((0, n - idle), (n - 1, idle)).into_owned())
    }
}

/// A curve of equilibria.
pub(super) struct Curve<'a> {
    pub equations: &'a dyn Equations,
}

impl Curve<'_> {
    /// The Jacobian with a row across it.
    fn bordered(jacobian: &DMatrix<f64>, across: &DVector<f64>) -> DMatrix<f64> {
        let n = jacobian.nrows();
        DMatrix::from_fn(n + 1, n + 1, |i, j| if i < n { jacobian[(i, j)] } else { across[j] })
    }

    /// The point of the curve in the plane through `z` across `direction`, and across the directions `idle`, in which
    /// equilibria lie beside it.
    pub fn corrected(
        &self,
        z: DVector<f64>,
        direction: &DVector<f64>,
        idle: &DMatrix<f64>,
    ) -> Result<DVector<f64>, AnalysisError> {
        let (n, mut at, mut last) = (z.len() - 1, z, f64::INFINITY);
        for _ in 0..30 {
            let (rest, jacobian) = self.equations.look(&at);
            let mut right = DVector::zeros(n + 1 + idle.ncols());
            right.rows_mut(0, n).copy_from(&-rest);
            let mut bordered = DMatrix::zeros(right.len(), n + 1);
            bordered.rows_mut(0, n + 1).copy_from(&Self::bordered(&jacobian, direction));
            bordered.rows_mut(n + 1, idle.ncols()).copy_from(&idle.transpose());
            let cut = flat(n + 1) * bordered.norm();
            let step = smallest_solution(bordered, &right, cut)?;
            let size = step.amax() / (1.0 + at.amax());
            if size >= last && last < CONVERGED {
                break;
            }
            last = size;
            if size == 0.0 {
                break;
            }
            at += step;
        }
        match last < CONVERGED {
            true => Ok(at),
            false => {
                let residual = self.equations.look(&at).0.amax();
                Err(AnalysisError::NotConverged { what: "the curve of equilibria", residual })
            }
        }
    }

    /// Refuses a place at which there are forces that no displacement changes.
    pub fn balanced(&self, at: &DVector<f64>) -> Result<(), AnalysisError> {
        let (rest, jacobian) = self.equations.look(at);
        let cut = flat(jacobian.nrows()) * jacobian.norm();
        let step = smallest_solution(-&jacobian, &rest, cut)?;
        balanced(&(rest + &jacobian * step), &jacobian, at, &|z| Ok(self.equations.look(z).0))
    }

    /// The place at a point of the curve, its tangent on the side of `before`.
    pub fn place(&self, z: DVector<f64>, before: &DVector<f64>) -> Result<Place, AnalysisError> {
        let n = z.len() - 1;
        let jacobian = self.equations.look(&z).1;
        let right = DVector::from_fn(n + 1, |i, _| f64::from(i == n));
        let bordered = Self::bordered(&jacobian, before);
        let cut = flat(n + 1) * bordered.norm();
        let tangent = smallest_solution(bordered, &right, cut)?.normalize();
        let tangent = if tangent.dot(before) < 0.0 { -tangent } else { tangent };
        if tangent.iter().any(|x| !x.is_finite()) {
            return Err(AnalysisError::NotFinite);
        }
        let svd = SVD::try_new(Self::bordered(&jacobian, &tangent), true, true, f64::EPSILON, 10_000)
            .ok_or(AnalysisError::NotFinite)?;
        let negative = self.equations.negative(&z, &jacobian)?;
        Ok(Place { z, tangent, svd, negative })
    }

    /// The place between two others at the part x of the way, from the cubic through both with their tangents.
    pub fn between(&self, a: &Place, b: &Place, x: f64) -> Result<Place, AnalysisError> {
        let (guess, direction) = cubic(a, b, x);
        let at = self.corrected(guess, &direction, &generic(a, b).idle())?;
        self.place(at, &direction)
    }

    /// Singular values of J at z in decreasing order, its left vectors, and a square of right vectors, whose last row
    /// is the direction of a curve.
    pub fn singular(&self, z: &DVector<f64>) -> Option<(DVector<f64>, DMatrix<f64>, DMatrix<f64>)> {
        let (n, jacobian) = (z.len() - 1, self.equations.look(z).1);
        let square = Self::bordered(&jacobian, &DVector::zeros(n + 1));
        let right = SVD::try_new(square, false, true, f64::EPSILON, 10_000)?.v_t?;
        let left = SVD::try_new(jacobian, true, false, f64::EPSILON, 10_000)?;
        Some((left.singular_values, left.u?, right))
    }
}

/// The place of two with less idle directions: the other may be a branch point.
pub(super) fn generic<'a>(a: &'a Place, b: &'a Place) -> &'a Place {
    if a.nullity() <= b.nullity() { a } else { b }
}

/// The cubic through two places with their tangents at the part x of the way, and its unit tangent.
pub(super) fn cubic(a: &Place, b: &Place, x: f64) -> (DVector<f64>, DVector<f64>) {
    let (h, y) = ((&b.z - &a.z).norm(), 1.0 - x);
    let guess =
        &a.z * (y * y * (1.0 + 2.0 * x)) + &b.z * (x * x * (1.0 + 2.0 * y)) + &a.tangent * (h * x * y * y)
            - &b.tangent * (h * x * x * y);
    let direction = (&b.z - &a.z) * (6.0 * x * y / h)
        + &a.tangent * (y * (y - 2.0 * x))
        + &b.tangent * (x * (x - 2.0 * y));
    (guess, direction.normalize())
}

/// Number of eigenvalues with a negative real part.
pub(super) fn negative(stiffness: &DMatrix<f64>) -> Result<usize, AnalysisError> {
    let n = stiffness.nrows();
    if stiffness.iter().any(|x| !x.is_finite()) {
        return Err(AnalysisError::NotFinite);
    }
    let rounding = flat(n) * stiffness.amax();
    let odd = (stiffness - stiffness.transpose()).amax();
    if odd <= rounding {
        let even = 0.5 * (stiffness + stiffness.transpose());
        return Ok(even.symmetric_eigenvalues().iter().filter(|x| **x < -rounding).count());
    }
    let all = crate::analysis::eigen::eigenvalues(stiffness.clone(), "the eigenvalues of K")?;
    Ok(all.iter().filter(|e| e.re < -rounding).count())
}
