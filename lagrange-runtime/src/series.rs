//! Taylor series of a motion: what the compiler emits for them, and the arithmetic of truncated series that it uses.

use crate::linear::{Ldlt, ldlt};
use crate::scalar::Scalar;
use crate::state::State;
use crate::system::System;
use nalgebra::{SMatrix, SVector};

/// A system whose motion has Taylor series, found order by order by recurrences that the compiler emits. Implemented for
/// every `lagrangian!` system without choices (`if`, `min`, `max`, `abs`) and `extern fn`s.
#[diagnostic::on_unimplemented(
    message = "no Taylor series are emitted for `{Self}`",
    note = "a system with `if`, `abs`, `min`, `max`, or an `extern fn`, has none; use `Dop853` or `Verner9`"
)]
pub trait Analytic<const N: usize>: System<N> {
    /// The series of the motion through `at`, with `order` coefficients of the accelerations, at most K.
    fn series<const K: usize>(&self, at: &State<Self::Scalar, N>, order: usize)
    -> Series<Self::Scalar, N, K>;
}

/// Taylor coefficients of a motion about the time of its state: `q(t₀ + h) = Σ q_k hᵏ`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Series<S, const N: usize, const K: usize> {
    /// Of the coordinates, by coordinates and orders.
    pub q: [[S; K]; N],
    /// Of the velocities.
    pub qd: [[S; K]; N],
    /// Of time: t₀ and 1.
    pub t: [S; K],
}

impl<S: Scalar, const N: usize, const K: usize> Series<S, N, K> {
    /// What is known without any equations.
    pub fn new(at: &State<S, N>) -> Self {
        let mut series = Series { q: [[S::zero(); K]; N], qd: [[S::zero(); K]; N], t: [S::zero(); K] };
        for i in 0..N {
            series.qd[i][0] = at.qd[i];
            series.q[i][0] = at.q[i];
            if K > 1 {
                series.q[i][1] = at.qd[i];
            }
        }
        series.t[0] = at.t;
        if K > 1 {
            series.t[1] = S::one();
        }
        series
    }

    /// Adds the accelerations of one order: `q̇_{k+1} = q̈_k/(k + 1)`, `q_{k+2} = q̇_{k+1}/(k + 2)`.
    #[inline(always)]
    pub fn push(&mut self, k: usize, accelerations: [S; N]) {
        let (over, over_next) = (S::from_f64((k + 1) as f64), S::from_f64((k + 2) as f64));
        for (i, a) in accelerations.into_iter().enumerate() {
            if k + 1 < K {
                self.qd[i][k + 1] = a / over;
            }
            if k + 2 < K {
                self.q[i][k + 2] = self.qd[i][k + 1] / over_next;
            }
        }
    }
}

/// `Σ_{j=0}^{k} a_j b_{k−j}`, with two sums so that additions need not wait for each other.
#[inline(always)]
pub fn product<S: Scalar, const K: usize>(a: &[S; K], b: &[S; K], k: usize) -> S {
    convolved(&a[..=k], &b[..=k])
}

/// `Σ_{j=1}^{k} b_j c_{k−j}`
#[inline(always)]
pub fn tail<S: Scalar, const K: usize>(b: &[S; K], c: &[S; K], k: usize) -> S {
    convolved(&b[1..=k], &c[..k])
}

#[inline(always)]
fn convolved<S: Scalar>(a: &[S], b: &[S]) -> S {
    let (mut even, mut odd) = (S::zero(), S::zero());
    let mut pairs = a.chunks_exact(2).zip(b.rchunks_exact(2));
    for (a, b) in &mut pairs {
        even = a[0].mul_add(b[1], even);
        odd = a[1].mul_add(b[0], odd);
    }
    if a.len() % 2 == 1 {
        even = a[a.len() - 1].mul_add(b[0], even);
    }
    even + odd
}

/// `Σ_{j=0}^{k} a_j a_{k−j}`
#[inline(always)]
pub fn square<S: Scalar, const K: usize>(a: &[S; K], k: usize) -> S {
    let half = k.div_ceil(2);
    let twice = convolved(&a[..half], &a[k + 1 - half..=k]);
    let twice = twice + twice;
    if k.is_multiple_of(2) { a[k / 2].mul_add(a[k / 2], twice) } else { twice }
}

/// `Σ_{j=1}^{k} j a_j d_{k−j}`: k times the coefficient of a function of a whose derivative has the series d.
#[inline(always)]
pub fn chain<S: Scalar, const K: usize>(a: &[S; K], d: &[S; K], k: usize) -> S {
    let mut sum = S::zero();
    for j in 1..=k {
        sum = (S::from_f64(j as f64) * a[j]).mul_add(d[k - j], sum);
    }
    sum
}

/// The k-th coefficient of `y = aʳ` for a number r: `Σ_{j<k} (r (k − j) − j) a_{k−j} y_j / (k a_0)`, from `a y' = r a' y`.
#[inline(always)]
pub fn power<S: Scalar, const K: usize>(a: &[S; K], r: S, y: &[S; K], k: usize) -> S {
    let mut sum = S::zero();
    for j in 0..k {
        let weight = r * S::from_f64((k - j) as f64) - S::from_f64(j as f64);
        sum = (weight * a[k - j]).mul_add(y[j], sum);
    }
    sum / (S::from_f64(k as f64) * a[0])
}

/// The matrix of order 0 of `M a = right`, factored once for all orders.
pub struct Solver<S, const M: usize>(Option<Ldlt<S, M>>);

impl<S: Scalar, const M: usize> Solver<S, M> {
    /// Of the rows of a symmetric matrix, of which the lower triangle is read.
    pub fn new(rows: [[S; M]; M]) -> Self {
        Solver(ldlt(&SMatrix::from_fn(|i, j| rows[i][j])).ok())
    }

    /// The unknowns of one order, of which the first N are given back; not numbers where the matrix is singular.
    #[inline(always)]
    pub fn solve<const N: usize, const K: usize>(
        &self,
        k: usize,
        right: [S; M],
        unknowns: &mut [[S; K]; M],
    ) -> [S; N] {
        let right = SVector::from(right);
        let x = match &self.0 {
            Some(factors) => factors.solve(&right),
            None => right.map(|_| S::zero() / S::zero()),
        };
        for (unknown, x) in unknowns.iter_mut().zip(&x) {
            unknown[k] = *x;
        }
        core::array::from_fn(|i| x[i])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 1/(1 − t), of which all is known.
    const GEOMETRIC: [f64; 8] = [1.0; 8];

    #[test]
    fn products_of_geometric_series() {
        for k in 0..8 {
            assert_eq!(product(&GEOMETRIC, &GEOMETRIC, k), (k + 1) as f64);
            assert_eq!(square(&GEOMETRIC, k), (k + 1) as f64);
            assert_eq!(tail(&GEOMETRIC, &GEOMETRIC, k), k as f64);
            assert_eq!(chain(&GEOMETRIC, &GEOMETRIC, k), (k * (k + 1) / 2) as f64);
        }
        let a = [3.0, -1.0, 2.0, 0.5, 7.0, -2.0, 1.0, 4.0];
        for k in 0..8 {
            let by_hand: f64 = (0..=k).map(|j| a[j] * a[k - j]).sum();
            assert!((square(&a, k) - by_hand).abs() < 1e-13);
        }
    }

    /// (1 − t)^r by the binomial series.
    #[test]
    fn powers() {
        let a = [1.0, -1.0, 0.0, 0.0, 0.0, 0.0];
        for r in [0.5, -1.5, 3.0] {
            let mut y = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0];
            let mut binomial = 1.0;
            for k in 1..6 {
                y[k] = power(&a, r, &y, k);
                binomial *= -(r - (k - 1) as f64) / k as f64;
                assert!((y[k] - binomial).abs() < 1e-15, "{r}: {y:?}");
            }
        }
    }
}
