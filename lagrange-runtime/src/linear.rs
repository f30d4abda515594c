//! `A x = b` for the small N × N systems of mechanics: LDLᵀ for symmetric matrices over any scalar, LU with partial
//! pivoting over ordered ones and complex numbers made of these. (nalgebra's own decompositions need bounds on N that would infect every signature.)

use crate::scalar::{Functions, Real, Scalar};
use core::fmt;
use core::ops::{Add, Div, Mul, Sub};
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

/// `M x`. (nalgebra's own product needs bounds on the scalar.)
pub(crate) fn product<S: Scalar, const N: usize>(m: &SMatrix<S, N, N>, x: &SVector<S, N>) -> SVector<S, N> {
    SVector::from_fn(|i, _| (0..N).fold(S::zero(), |sum, j| m[(i, j)].mul_add(x[j], sum)))
}

/// `x·y`.
pub(crate) fn dot<S: Scalar, const N: usize>(x: &SVector<S, N>, y: &SVector<S, N>) -> S {
    (0..N).fold(S::zero(), |sum, i| x[i].mul_add(y[i], sum))
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

/// A number that elimination can work with: a real one, or a complex one made of these.
pub(crate) trait Entry<S>:
    Copy
    + fmt::Debug
    + PartialEq
    + 'static
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
{
    /// The real number `x`.
    fn real(x: S) -> Self;
    /// Its absolute value, of which pivots should have much.
    fn size(self) -> f64;
}

impl<S: Real> Entry<S> for S {
    #[inline]
    fn real(x: S) -> S {
        x
    }

    #[inline]
    fn size(self) -> f64 {
        self.to_f64().abs()
    }
}

/// `re + i im`: what the pair of conjugate eigenvalues of a method's matrix needs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Complex<S> {
    pub re: S,
    pub im: S,
}

impl<S: Scalar> Add for Complex<S> {
    type Output = Self;
    #[inline]
    fn add(self, o: Self) -> Self {
        Complex { re: self.re + o.re, im: self.im + o.im }
    }
}

impl<S: Scalar> Sub for Complex<S> {
    type Output = Self;
    #[inline]
    fn sub(self, o: Self) -> Self {
        Complex { re: self.re - o.re, im: self.im - o.im }
    }
}

impl<S: Scalar> Mul for Complex<S> {
    type Output = Self;
    #[inline]
    fn mul(self, o: Self) -> Self {
        Complex { re: self.re * o.re - self.im * o.im, im: self.re * o.im + self.im * o.re }
    }
}

impl<S: Real> Div for Complex<S> {
    type Output = Self;
    /// Smith 1962: no square of a component, which could overflow.
    #[inline]
    fn div(self, o: Self) -> Self {
        if o.re.to_f64().abs() >= o.im.to_f64().abs() {
            let ratio = o.im / o.re;
            let norm = o.re + o.im * ratio;
            Complex { re: (self.re + self.im * ratio) / norm, im: (self.im - self.re * ratio) / norm }
        } else {
            let ratio = o.re / o.im;
            let norm = o.re * ratio + o.im;
            Complex { re: (self.re * ratio + self.im) / norm, im: (self.im * ratio - self.re) / norm }
        }
    }
}

impl<S: Real> Entry<S> for Complex<S> {
    #[inline]
    fn real(x: S) -> Self {
        Complex { re: x, im: S::zero() }
    }

    #[inline]
    fn size(self) -> f64 {
        let (re, im) = (self.re.to_f64(), self.im.to_f64());
        Functions::sqrt(re * re + im * im)
    }
}

/// The factors of `P A = L U`, kept for many right-hand sides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Lu<T, const N: usize> {
    factors: SMatrix<T, N, N>,
    /// Which row was swapped to place j in step j.
    rows: [usize; N],
}

/// Factors a general matrix with partial pivoting (Golub and Van Loan, 2013, 3.4). Fails only where a pivot is exactly
/// zero or not finite: rows of stiff and of soft coordinates differ by more than 1/ε without being singular.
pub(crate) fn lu<S, T: Entry<S>, const N: usize>(a: &SMatrix<T, N, N>) -> Result<Lu<T, N>, Singular> {
    let (mut a, mut rows) = (*a, [0; N]);
    for j in 0..N {
        let mut pivot = j;
        for i in j + 1..N {
            if a[(i, j)].size() > a[(pivot, j)].size() {
                pivot = i;
            }
        }
        let value = a[(pivot, j)].size();
        if !value.is_finite() || value == 0.0 {
            return Err(Singular { pivot: j });
        }
        rows[j] = pivot;
        a.swap_rows(j, pivot);
        for i in j + 1..N {
            let factor = a[(i, j)] / a[(j, j)];
            a[(i, j)] = factor;
            for k in j + 1..N {
                a[(i, k)] = a[(i, k)] - factor * a[(j, k)];
            }
        }
    }
    Ok(Lu { factors: a, rows })
}

impl<T, const N: usize> Lu<T, N> {
    /// The `x` with `A x = b`.
    pub fn solve<S>(&self, b: &SVector<T, N>) -> SVector<T, N>
    where
        T: Entry<S>,
    {
        let (a, mut x) = (&self.factors, *b);
        for j in 0..N {
            x.swap_rows(j, self.rows[j]);
        }
        for i in 0..N {
            for k in 0..i {
                x[i] = x[i] - a[(i, k)] * x[k];
            }
        }
        for i in (0..N).rev() {
            for k in i + 1..N {
                x[i] = x[i] - a[(i, k)] * x[k];
            }
            x[i] = x[i] / a[(i, i)];
        }
        x
    }
}

/// The solution of `A x = b` for a positive definite matrix, given by its lower triangle, row after row. What is not a number
/// if a pivot vanishes, as it would be in straight lines.
pub fn solved<S: Scalar, const N: usize>(lower: &[S], b: [S; N]) -> SVector<S, N> {
    let entry = |i: usize, j: usize| lower[i * (i + 1) / 2 + j];
    let a = SMatrix::from_fn(|i, j| if j <= i { entry(i, j) } else { entry(j, i) });
    match ldlt(&a) {
        Ok(factors) => factors.solve(&SVector::from(b)),
        Err(Singular { .. }) => SVector::from_fn(|_, _| S::zero() / S::zero()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kept_factors_solve_real_and_complex_systems() {
        let a = SMatrix::<f64, 4, 4>::from_fn(|i, j| matrix::<f64, 4>()[((i + 1) % 4, j)]);
        let b = SVector::<f64, 4>::new(1.0, -2.0, 0.5, 3.0);
        assert!((a * lu(&a).unwrap().solve(&b) - b).amax() < 1e-14);
        // Rows that differ by 1e20 are not singular.
        let scaled = SMatrix::<f64, 2, 2>::new(1e20, 1.0, 1.0, 2.0);
        let x = lu(&scaled).unwrap().solve(&SVector::from([1e20, 5.0]));
        assert!((x - SVector::from([1.0, 2.0])).amax() < 1e-15);
        assert_eq!(lu(&SMatrix::<f64, 2, 2>::new(1.0, 2.0, 2.0, 4.0)), Err(Singular { pivot: 1 }));

        let complex = |re: f64, im: f64| Complex { re, im };
        let a =
            SMatrix::<Complex<f64>, 3, 3>::from_fn(|i, j| complex((i * j) as f64, (i + 2 * j) as f64 - 1.0));
        let b = SVector::from([complex(1.0, 2.0), complex(0.0, -1.0), complex(3.0, 0.5)]);
        let a = SMatrix::from_fn(|i, j| if i == j { a[(i, j)] + complex(0.3, 2.0) } else { a[(i, j)] });
        let x = lu(&a).unwrap().solve(&b);
        for i in 0..3 {
            let sum = (0..3).fold(complex(0.0, 0.0), |sum, j| sum + a[(i, j)] * x[j]);
            assert!((sum - b[i]).size() < 1e-14);
        }
        let quotient = complex(1.0, 2.0) / complex(1e-200, 1e200) * complex(1e-200, 1e200);
        assert!((quotient - complex(1.0, 2.0)).size() < 1e-15);
    }
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
