//! Taylor series of a motion: what the compiler emits for them, and the arithmetic of truncated series that it uses.

use crate::linear::ldlt;
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
    #[inline(always)]
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

    /// Adds the accelerations of one order: `q̇_{k+1} = q̈_k/(k + 1)`, `q_{k+2} = q̇_{k+1}/(k + 2)`. Divided, not multiplied by
    /// reciprocals: their rounding would err in one direction at every step, and energies drift.
    #[inline(always)]
    pub fn push(&mut self, k: usize, accelerations: [S; N]) {
        let (below, below_next) = (S::from_f64((k + 1) as f64), S::from_f64((k + 2) as f64));
        for i in 0..N {
            if k + 1 < K {
                self.qd[i][k + 1] = accelerations[i] / below;
            }
            if k + 2 < K {
                self.q[i][k + 2] = self.qd[i][k + 1] / below_next;
            }
        }
    }
}

/// `Σ_{j=0}^{k} a_j b_{k−j}`
#[inline(always)]
pub fn product<S: Scalar, const K: usize>(a: &[S; K], b: &[S; K], k: usize) -> S {
    convolved(a, b, k, 0, k + 1)
}

/// `Σ_{j=1}^{k} b_j c_{k−j}`
#[inline(always)]
pub fn tail<S: Scalar, const K: usize>(b: &[S; K], c: &[S; K], k: usize) -> S {
    convolved(b, c, k, 1, k + 1)
}

/// `Σ_{j=0}^{k} a_j a_{k−j}`
#[inline(always)]
pub fn square<S: Scalar, const K: usize>(a: &[S; K], k: usize) -> S {
    let half = convolved(a, a, k, 0, k.div_ceil(2));
    let twice = half + half;
    if k.is_multiple_of(2) && k < K { a[k / 2].mul_add(a[k / 2], twice) } else { twice }
}

/// The k-th coefficient of `y = x/b`: `(x_k − Σ_{j≥1} b_j y_{k−j})/b_0`.
#[inline(always)]
pub fn quotient<S: Scalar, const K: usize>(x: S, b: &[S; K], y: &[S; K], k: usize) -> S {
    // The same quotient at all orders: one division.
    (x - tail(b, y, k)) * (S::one() / b[0])
}

/// The k-th coefficient of `y = aʳ` for a number r: `Σ_{j<k} (r (k − j) − j) a_{k−j} y_j / (k a_0)`, from `a y' = r a' y`.
#[inline(always)]
pub fn power<S: Scalar, const K: usize>(a: &[S; K], r: S, y: &[S; K], k: usize) -> S {
    let term = |j: usize, sum: S| {
        let weight = r * S::from_f64((k - j) as f64) - S::from_f64(j as f64);
        (weight * a[k - j]).mul_add(y[j], sum)
    };
    middle_out(0, k.min(K), term) * S::from_f64(1.0 / k as f64) * (S::one() / a[0])
}

/// `Σ_{from ≤ j < to} a_j b_{k−j}`
#[inline(always)]
fn convolved<S: Scalar, const K: usize>(a: &[S; K], b: &[S; K], k: usize, from: usize, to: usize) -> S {
    // Says that no index is out of bounds.
    let k = k.min(K - 1);
    middle_out(from, to.min(k + 1), |j, sum| a[j].mul_add(b[k.saturating_sub(j)], sum))
}

/// A sum of the terms `from ≤ j < to` of a product of series: from the middle, whose coefficients have been known longest,
/// to the ends, where those just computed are, and in two halves, so that additions need not wait.
///
/// Written without iterators: where the limits are numbers, the compiler makes a straight line of it.
#[inline(always)]
fn middle_out<S: Scalar>(from: usize, to: usize, add: impl Fn(usize, S) -> S) -> S {
    let (mut low, mut high) = (S::zero(), S::zero());
    let middle = from + (to - from) / 2;
    let (mut i, mut j) = (middle, middle);
    while j < to {
        high = add(j, high);
        j += 1;
        if i > from {
            i -= 1;
            low = add(i, low);
        }
    }
    low + high
}

/// The matrix of order 0 of `M a = right`, inverted once for all orders.
pub struct Solver<S, const M: usize>(SMatrix<S, M, M>);

impl<S: Scalar, const M: usize> Solver<S, M> {
    /// Of the rows of a symmetric matrix, of which the lower triangle is read. Of a singular one the inverse is made of
    /// what is not a number.
    #[inline]
    pub fn new(rows: [[S; M]; M]) -> Self {
        let mut inverse = SMatrix::<S, M, M>::from_fn(|_, _| S::zero() / S::zero());
        if let Ok(factors) = ldlt(&SMatrix::from_fn(|i, j| rows[i][j])) {
            for j in 0..M {
                let mut unit = SVector::from_fn(|_, _| S::zero());
                unit[j] = S::one();
                inverse.set_column(j, &factors.solve(&unit));
            }
        }
        Solver(inverse)
    }

    /// The unknowns of one order, of which the first N are given back.
    #[inline(always)]
    pub fn solve<const N: usize, const K: usize>(
        &self,
        k: usize,
        right: [S; M],
        unknowns: &mut [[S; K]; M],
    ) -> [S; N] {
        let mut first = [S::zero(); N];
        for i in 0..M {
            let mut sum = self.0[(i, 0)] * right[0];
            for j in 1..M {
                sum = self.0[(i, j)].mul_add(right[j], sum);
            }
            unknowns[i][k] = sum;
            if i < N {
                first[i] = sum;
            }
        }
        first
    }
}

/// Does a step for each of the orders `1..end`, which is a number in each of the steps, so that the loops over orders before
/// it are straight lines in the machine's code.
#[doc(hidden)]
#[macro_export]
macro_rules! __orders {
    (1..$end:expr, $level:ident => $step:expr) => {
        $crate::__orders!(
            [1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23] $end, $level => $step
        )
    };
    ([$($order:literal)*] $end:expr, $level:ident => $step:expr) => {{
        let end = $end;
        $(
            if $order < end {
                let $level = $order;
                $step;
            }
        )*
        for $level in 24..end {
            $step;
        }
    }};
}

pub use __orders as orders;

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
