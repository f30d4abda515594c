//! `A x = b` for the small N × N systems of mechanics: LDLᵀ for symmetric matrices, LU with partial pivoting over
//! real numbers, numbers side by side, and complex numbers made of these. (nalgebra's own decompositions need bounds
//! on N that would infect every signature.)

use crate::iteration::nan;
use crate::scalar::{Comparison, Real, Scalar, SimdScalar};
use crate::state::constant;
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
    pub(crate) diagonal: SVector<S, N>,
}

/// Factors a symmetric matrix without pivoting, which is stable where it is definite, as an inertia matrix is. Only
/// the lower triangle is read. Fails where a pivot is exactly zero or not finite: of lanes, where that is so in all
/// of them, and otherwise those in which it is have factors that are not numbers.
#[inline(always)]
pub fn ldlt<S: SimdScalar, const N: usize>(a: &SMatrix<S, N, N>) -> Result<Ldlt<S, N>, Singular> {
    let factors = factored(a);
    usable(factors.diagonal.iter().copied()).map(|()| factors)
}

/// Factorizes as [`ldlt`]; the factors are NaN where a pivot is exactly zero.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(crate) fn factored<S: Scalar, const N: usize>(a: &SMatrix<S, N, N>) -> Ldlt<S, N> {
    let (mut lower, mut diagonal) = (*a, constant(S::zero()));
    for j in 0..N {
        let mut d = a[(j, j)];
        for k in 0..j {
            d -= lower[(j, k)] * lower[(j, k)] * diagonal[k];
        }
        let d = S::select(Comparison::Equal, d, S::zero(), nan(), d);
        diagonal[j] = d;
        for i in j + 1..N {
            let mut sum = a[(i, j)];
            for k in 0..j {
                sum -= lower[(i, k)] * lower[(j, k)] * diagonal[k];
            }
            lower[(i, j)] = sum / d;
        }
    }
    Ldlt { lower, diagonal }
}

/// Returns whether all pivots are finite for one of the numbers side by side at least.
#[cfg_attr(not(debug_assertions), inline(always))]
fn usable<S: SimdScalar>(pivots: impl Iterator<Item = S>) -> Result<(), Singular> {
    let mut usable = S::each(|_| true);
    for (pivot, d) in pivots.enumerate() {
        let (usable, mut any) = (usable.as_mut(), false);
        for i in 0..usable.len() {
            usable[i] &= d.number(i) * S::Element::zero() == S::Element::zero();
            any |= usable[i];
        }
        if !any {
            return Err(Singular { pivot });
        }
    }
    Ok(())
}

impl<S: Scalar, const N: usize> Ldlt<S, N> {
    /// The first pivot that is not finite: of lanes, in any of them.
    pub(crate) fn singular(&self) -> Option<Singular> {
        let pivot = self.diagonal.iter().position(|&d| d * S::zero() != S::zero())?;
        Some(Singular { pivot })
    }

    /// `B⁻¹ b` with `A = B Bᵀ` of a positive definite matrix.
    pub(crate) fn half(&self, b: &SVector<S, N>) -> SVector<S, N> {
        let mut x = *b;
        for i in 0..N {
            for k in 0..i {
                x[i] = x[i] - self.lower[(i, k)] * x[k];
            }
        }
        SVector::from_fn(|i, _| x[i] / self.diagonal[i].sqrt())
    }

    /// `B⁻ᵀ y`, see [`half`](Self::half).
    pub(crate) fn back(&self, y: &SVector<S, N>) -> SVector<S, N> {
        let mut x = SVector::<S, N>::from_fn(|i, _| y[i] / self.diagonal[i].sqrt());
        for i in (0..N).rev() {
            for k in i + 1..N {
                x[i] = x[i] - self.lower[(k, i)] * x[k];
            }
        }
        x
    }

    /// The `x` with `A x = b`.
    #[cfg_attr(not(debug_assertions), inline(always))]
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

/// A number that elimination can work with: a real one, or a complex one made of these; or several side by side.
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
    fn size(self) -> S;
    /// Selects as [`Scalar::select`].
    fn pick(comparison: Comparison, a: S, b: S, yes: Self, no: Self) -> Self;
}

impl<S: Scalar> Entry<S> for S {
    #[inline(always)]
    fn real(x: S) -> S {
        x
    }

    #[inline(always)]
    fn size(self) -> S {
        self.abs()
    }

    #[inline(always)]
    fn pick(comparison: Comparison, a: S, b: S, yes: S, no: S) -> S {
        S::select(comparison, a, b, yes, no)
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

impl<S: Scalar> Div for Complex<S> {
    type Output = Self;
    /// Smith 1962: no square of a component, which could overflow. What is larger of the divisor is divided by.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn div(self, o: Self) -> Self {
        let by = |yes: S, no: S| S::select(Comparison::LessEqual, o.im.abs(), o.re.abs(), yes, no);
        let (larger, smaller) = (by(o.re, o.im), by(o.im, o.re));
        let ratio = smaller / larger;
        let norm = larger + smaller * ratio;
        let (a, b) = (by(self.re, self.im), by(self.im, self.re));
        let im = (b - a * ratio) / norm;
        Complex { re: (a + b * ratio) / norm, im: by(im, -im) }
    }
}

impl<S: Scalar> Entry<S> for Complex<S> {
    #[inline(always)]
    fn real(x: S) -> Self {
        Complex { re: x, im: S::zero() }
    }

    #[inline(always)]
    fn size(self) -> S {
        (self.re * self.re + self.im * self.im).sqrt()
    }

    #[inline(always)]
    fn pick(comparison: Comparison, a: S, b: S, yes: Self, no: Self) -> Self {
        let part = |yes: S, no: S| S::select(comparison, a, b, yes, no);
        Complex { re: part(yes.re, no.re), im: part(yes.im, no.im) }
    }
}

/// The factors of `P A = L U`, kept for many right-hand sides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Lu<S, T, const N: usize> {
    factors: SMatrix<T, N, N>,
    /// Index of the row that was swapped to place j in step j.
    rows: SVector<S, N>,
}

/// Factors a general matrix with partial pivoting (Golub and Van Loan, 2013, 3.4). Fails only where a pivot is
/// exactly zero or not finite, as [`ldlt`]: rows of stiff and of soft coordinates differ by more than 1/ε without
/// being singular.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(crate) fn lu<S: SimdScalar, T: Entry<S>, const N: usize>(
    a: &SMatrix<T, N, N>,
) -> Result<Lu<S, T, N>, Singular> {
    let (mut a, mut rows, mut pivots) = (*a, constant(S::zero()), [S::zero(); N]);
    for j in 0..N {
        let (mut pivot, mut most) = (S::from_f64(j as f64), a[(j, j)].size());
        for i in j + 1..N {
            let size = a[(i, j)].size();
            pivot = S::select(Comparison::Less, most, size, S::from_f64(i as f64), pivot);
            most = S::select(Comparison::Less, most, size, size, most);
        }
        (rows[j], pivots[j]) = (pivot, S::select(Comparison::Equal, most, S::zero(), nan(), most));
        swap(&mut a, j, pivot);
        for i in j + 1..N {
            let factor = a[(i, j)] / a[(j, j)];
            a[(i, j)] = factor;
            for k in j + 1..N {
                a[(i, k)] = a[(i, k)] - factor * a[(j, k)];
            }
        }
    }
    usable(pivots.into_iter()).map(|()| Lu { factors: a, rows })
}

/// Swaps row j with row `other`, which numbers side by side may disagree on.
#[cfg_attr(not(debug_assertions), inline(always))]
fn swap<S: SimdScalar, T: Entry<S>, const N: usize, const M: usize>(
    a: &mut SMatrix<T, N, M>,
    j: usize,
    other: S,
) {
    let row = other.number(0).to_f64();
    if S::each(|i| other.number(i).to_f64() == row).as_ref().contains(&false) {
        for i in j + 1..N {
            let here = S::from_f64(i as f64);
            for k in 0..M {
                let (upper, lower) = (a[(j, k)], a[(i, k)]);
                a[(j, k)] = T::pick(Comparison::Equal, other, here, lower, upper);
                a[(i, k)] = T::pick(Comparison::Equal, other, here, upper, lower);
            }
        }
    } else {
        a.swap_rows(j, row as usize);
    }
}

impl<const N: usize> Lu<f64, f64, N> {
    /// Is the determinant negative? Its size, a product that may overflow, is not formed.
    pub fn has_negative_determinant(&self) -> bool {
        let changes = |j: usize| (self.rows[j] != j as f64) ^ (self.factors[(j, j)] < 0.0);
        (0..N).fold(false, |negative, j| negative ^ changes(j))
    }
}

impl<S: SimdScalar, T: Entry<S>, const N: usize> Lu<S, T, N> {
    /// The `x` with `A x = b`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn solve(&self, b: &SVector<T, N>) -> SVector<T, N> {
        let (a, mut x) = (&self.factors, *b);
        for j in 0..N {
            swap(&mut x, j, self.rows[j]);
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

/// The solution of `A x = b` for a positive definite matrix, given by its lower triangle, row after row. What is not
/// a number if a pivot vanishes, as it would be in straight lines.
pub fn solved<S: Scalar, const N: usize>(lower: &[S], b: [S; N]) -> SVector<S, N> {
    let entry = |i: usize, j: usize| lower[i * (i + 1) / 2 + j];
    let a = SMatrix::from_fn(|i, j| if j <= i { entry(i, j) } else { entry(j, i) });
    factored(&a).solve(&SVector::from(b))
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

    /// Lanes with other pivots each, and one whose matrix is singular, against each of them alone.
    #[test]
    fn a_singular_matrix_in_one_lane_leaves_the_others() {
        use crate::lanes::{Lanes, Plain};
        type Four = Lanes<4, Plain>;
        let element = |lane: usize, i: usize, j: usize| match lane {
            2 => (i * j) as f64,
            _ => 1.0 / (1 + (i + lane) % 3 + j) as f64 + f64::from(u8::from((i + lane) % 3 == j)),
        };
        let symmetric = |lane: usize, i: usize, j: usize| {
            element(lane, i.min(j), i.max(j)) + 2.0 * f64::from(u8::from(i == j && lane != 2))
        };
        let right = SVector::<f64, 3>::from([1.0, -2.0, 3.0]);
        let all = right.map(Four::splat);
        let side_by_side = |of: &dyn Fn(usize, usize, usize) -> f64| {
            SMatrix::<Four, 3, 3>::from_fn(|i, j| Lanes::new(core::array::from_fn(|lane| of(lane, i, j))))
        };
        let by_lu = lu(&side_by_side(&element)).unwrap().solve(&all);
        let by_ldlt = ldlt(&side_by_side(&symmetric)).unwrap().solve(&all);
        let complex = side_by_side(&element).map(|re| Complex { re, im: Four::splat(0.25) });
        let by_complex = lu(&complex).unwrap().solve(&all.map(Complex::real));
        let mut pivots = vec![];
        for lane in [0, 1, 3] {
            let one = |of: &dyn Fn(usize, usize, usize) -> f64| {
                SMatrix::<f64, 3, 3>::from_fn(|i, j| of(lane, i, j))
            };
            let alone = lu(&one(&element)).unwrap();
            pivots.push(alone.rows);
            let complex = one(&element).map(|re| Complex { re, im: 0.25 });
            let complex = lu(&complex).unwrap().solve(&right.map(Complex::real));
            for i in 0..3 {
                assert_eq!(by_lu[i].to_array()[lane], alone.solve(&right)[i]);
                assert_eq!(by_ldlt[i].to_array()[lane], ldlt(&one(&symmetric)).unwrap().solve(&right)[i]);
                assert_eq!(by_complex[i].re.to_array()[lane], complex[i].re);
                assert_eq!(by_complex[i].im.to_array()[lane], complex[i].im);
            }
        }
        assert!(pivots[0] != pivots[1], "rows are swapped in each lane as it wants: {pivots:?}");
        assert!((0..3).all(|i| !by_lu[i].to_array()[2].is_finite() && by_ldlt[i].to_array()[2].is_nan()));
        let lower =
            [(0, 0), (1, 0), (1, 1), (2, 0), (2, 1), (2, 2)].map(|(i, j)| side_by_side(&symmetric)[(i, j)]);
        assert_eq!(solved(&lower, *all.as_ref())[1].to_array()[0], by_ldlt[1].to_array()[0]);
        assert!(ldlt(&SMatrix::<Four, 3, 3>::from_fn(|_, _| Four::splat(1.0))).is_err(), "in all lanes");
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
