//! `A x = b` for the small N × N systems of mechanics: LDLᵀ for symmetric matrices over any scalar, LU with partial
//! pivoting over ordered ones. (nalgebra's own decompositions need bounds on N that would infect every signature.)

use crate::scalar::{Real, Scalar};
use core::fmt;
use nalgebra::{SMatrix, SVector};

/// The matrix has no usable pivot in one of its columns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Singular {
    /// Index of the column, for an inertia matrix that of the coordinate, whose pivot is zero or not finite.
    pub pivot: usize,
}

impl fmt::Display for Singular {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the matrix is singular: pivot {} vanishes", self.pivot)
    }
}

impl core::error::Error for Singular {}

/// The factors of `A = L D Lᵀ` with unit lower triangular L (Golub and Van Loan, *Matrix Computations*, 2013, 4.1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ldlt<S, const N: usize> {
    lower: SMatrix<S, N, N>,
    diagonal: SVector<S, N>,
}

/// Factors a symmetric matrix without pivoting, which is stable where it is definite, as an inertia matrix is. Only
/// the lower triangle is read. Fails where a pivot is exactly zero or not finite.
pub fn ldlt<S: Scalar, const N: usize>(a: &SMatrix<S, N, N>) -> Result<Ldlt<S, N>, Singular> {
    let mut lower = *a;
    let mut diagonal = SVector::from_fn(|_, _| S::zero());
    for j in 0..N {
        let mut d = a[(j, j)];
        for k in 0..j {
            d -= lower[(j, k)] * lower[(j, k)] * diagonal[k];
        }
        if d == S::zero() || d * S::zero() != S::zero() {
            return Err(Singular { pivot: j });
        }
        diagonal[j] = d;
        for i in j + 1..N {
            let mut sum = a[(i, j)];
            for k in 0..j {
                sum -= lower[(i, k)] * lower[(j, k)] * diagonal[k];
            }
            lower[(i, j)] = sum / d;
        }
    }
    Ok(Ldlt { lower, diagonal })
}

impl<S: Scalar, const N: usize> Ldlt<S, N> {
    /// The `x` with `A x = b`.
    pub fn solve(&self, b: &SVector<S, N>) -> SVector<S, N> {
        let mut x = *b;
        for i in 0..N {
            for k in 0..i {
                x[i] = x[i] - self.lower[(i, k)] * x[k];
            }
        }
        for i in (0..N).rev() {
            x[i] /= self.diagonal[i];
            for k in i + 1..N {
                x[i] = x[i] - self.lower[(k, i)] * x[k];
            }
        }
        x
    }
}

/// The `x` with `A x = b` of a general matrix: Gaussian elimination with partial pivoting (Golub and Van Loan, 2013,
/// 3.4). Fails where a column has no pivot above `N ε` times the largest element of the matrix.
pub fn lu_solve<S: Real, const N: usize>(
    a: &SMatrix<S, N, N>,
    b: &SVector<S, N>,
) -> Result<SVector<S, N>, Singular> {
    let (mut a, mut x) = (*a, *b);
    let size = |x: S| x.to_f64().abs();
    let largest = a.iter().fold(0.0, |m: f64, &x| m.max(size(x)));
    let smallest = largest * S::EPSILON * N as f64;
    for j in 0..N {
        let mut pivot = j;
        for i in j + 1..N {
            if size(a[(i, j)]) > size(a[(pivot, j)]) {
                pivot = i;
            }
        }
        let value = size(a[(pivot, j)]);
        if !value.is_finite() || value <= smallest {
            return Err(Singular { pivot: j });
        }
        a.swap_rows(j, pivot);
        x.swap_rows(j, pivot);
        for i in j + 1..N {
            let factor = a[(i, j)] / a[(j, j)];
            for k in j + 1..N {
                a[(i, k)] = a[(i, k)] - factor * a[(j, k)];
            }
            x[i] = x[i] - factor * x[j];
        }
    }
    for i in (0..N).rev() {
        for k in i + 1..N {
            x[i] = x[i] - a[(i, k)] * x[k];
        }
        x[i] /= a[(i, i)];
    }
    Ok(x)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scalar::Dual;

    /// The Hilbert matrix plus 1: symmetric, definite, full.
    fn matrix<S: Scalar, const N: usize>() -> SMatrix<S, N, N> {
        SMatrix::from_fn(|i, j| S::from_f64(1.0 / (1 + i + j) as f64 + f64::from(i == j)))
    }

    fn solves<const N: usize>() {
        let (a, b) = (matrix::<f64, N>(), SVector::<f64, N>::from_fn(|i, _| (i as f64 - 1.5).exp()));
        assert!((a * ldlt(&a).unwrap().solve(&b) - b).amax() < 1e-14);
        assert!((a * lu_solve(&a, &b).unwrap() - b).amax() < 1e-14);
        let permuted = SMatrix::<f64, N, N>::from_fn(|i, j| a[((i + 1) % N, j)]);
        assert!((permuted * lu_solve(&permuted, &b).unwrap() - b).amax() < 1e-14);
    }

    #[test]
    fn both_solve_from_one_to_six_unknowns() {
        solves::<1>();
        solves::<2>();
        solves::<3>();
        solves::<4>();
        solves::<6>();
    }

    #[test]
    fn derivatives_pass_through() {
        // A(s) x = b has dx/ds = −A⁻¹ (dA/ds) x.
        let mut a = matrix::<Dual<f64>, 3>();
        a[(0, 0)].slope = 1.0;
        let b = SVector::from([Dual::constant(1.0), Dual::constant(2.0), Dual::constant(3.0)]);
        let (x, y) = (ldlt(&a).unwrap().solve(&b), lu_solve(&a, &b).unwrap());
        let plain = matrix::<f64, 3>();
        let slope = lu_solve(&plain, &SVector::from([-x[0].value, 0.0, 0.0])).unwrap();
        for i in 0..3 {
            assert!((x[i].slope - slope[i]).abs() < 1e-14 && (y[i].slope - slope[i]).abs() < 1e-14);
        }
    }

    #[test]
    fn the_vanishing_pivot_is_named() {
        let a = SMatrix::<f64, 3, 3>::new(1.0, 2.0, 0.0, 2.0, 4.0, 0.0, 0.0, 0.0, 1.0);
        let b = SVector::from([1.0, 1.0, 1.0]);
        assert_eq!(ldlt(&a), Err(Singular { pivot: 1 }));
        assert_eq!(lu_solve(&a, &b), Err(Singular { pivot: 1 }));
        assert_eq!(ldlt(&(a * f64::NAN)), Err(Singular { pivot: 0 }));
        assert_eq!(lu_solve(&(a * f64::NAN), &b), Err(Singular { pivot: 0 }));
    }
}
