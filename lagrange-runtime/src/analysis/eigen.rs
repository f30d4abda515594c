//! Eigenvalues of general real matrices.

use super::AnalysisError;
use nalgebra::{Complex, DMatrix, DVector, Schur};

/// All eigenvalues of a square matrix, by nalgebra's Schur decomposition.
///
/// Its QR iteration has no exceptional shifts and stays where it is for some matrices, those of gyroscopic systems
/// with two equal coordinates among them. An orthogonal similarity, which changes no eigenvalue, sets it going again.
pub(super) fn eigenvalues(
    matrix: DMatrix<f64>,
    what: &'static str,
) -> Result<Vec<Complex<f64>>, AnalysisError> {
    let n = matrix.nrows();
    if matrix.iter().any(|x| !x.is_finite()) {
        return Err(AnalysisError::NotFinite);
    }
    let residual = matrix.amax();
    let mut similar = matrix;
    for attempt in 0..6 {
        if attempt > 0 {
            similar = reflected(&similar, attempt);
        }
        if let Some(schur) = Schur::try_new(similar.clone(), f64::EPSILON, 100 * n) {
            return Ok(schur.complex_eigenvalues().iter().copied().collect());
        }
    }
    Err(AnalysisError::NotConverged { what, residual })
}

/// `H A H` with a Householder reflection H along no special direction.
fn reflected(a: &DMatrix<f64>, attempt: u32) -> DMatrix<f64> {
    let direction =
        DVector::from_fn(a.nrows(), |i, _| 1.0 + (f64::from(attempt) * 1.618 * (i as f64 + 1.0)).sin());
    let direction = direction.normalize();
    let left = a - (&direction * 2.0) * (direction.transpose() * a);
    &left - (&left * &direction) * (direction.transpose() * 2.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Eigenvalues ±i, twice: nalgebra's iteration alone does not end.
    #[test]
    fn a_matrix_on_which_the_iteration_stays() {
        let mut stuck = 0;
        for spin in 0..400 {
            let g = 0.05 * f64::from(spin);
            // λ² + λ G − 1 with G = g (0, 1; −1, 0).
            let a = DMatrix::from_row_slice(
                4,
                4,
                &[0., 0., 1., 0., 0., 0., 0., 1., 1., 0., 0., -g, 0., 1., g, 0.],
            );
            stuck += usize::from(Schur::try_new(a.clone(), f64::EPSILON, 400).is_none());
            let found = eigenvalues(a, "these").unwrap();
            for e in found {
                let value = (e * e - 1.0).powi(2) + g * g * e * e;
                // Where two meet, they are known to half the digits.
                assert!(value.norm() < 1e-12 * (1.0 + e.norm().powi(4)), "{g}: {e} {value}");
            }
        }
        assert!(stuck > 0, "the similarity is needed no more: remove it");
    }
}
