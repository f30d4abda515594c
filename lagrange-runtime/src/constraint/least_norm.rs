//! Accelerations under constraints of which some follow from others, by pivots that numbers choose.

use crate::linear::{dot, factored};
use crate::scalar::{Comparison, Scalar};
use crate::state::constant;
use nalgebra::{SMatrix, SVector};

/// Square of the sine of the angle between a gradient and the span of others at which it is taken for one of this
/// span: of as many as are known to be independent, rounding; of others, the distance from the constraints of a stage
/// of a step.
const ROUNDED: f64 = 1e-26;
const NEAR: f64 = 1e-6;

/// Solution `(x, λ)` of `M x − Aᵀ λ = right` with `A x = rates`, where M is positive definite and the rows of A may
/// depend on each other: the x that satisfies the second equation best, by least squares over the constraints, and
/// the λ of least norm. M is given by its lower triangle, row after row, A by its rows.
///
/// With `M = B Bᵀ` that is the complete orthogonal decomposition of `B⁻¹ Aᵀ` (Golub and Van Loan, *Matrix
/// Computations*, 2013, 5.4.7): by Gram–Schmidt orthogonalization with column pivoting, made twice
/// (Björck, *Numerical Methods for Least Squares Problems*, 1996, 2.4.5), it is `Q R` with as many rows of R as the
/// rank, and `Rᵀ = U T`. The rank is the one that is given, or more in another assembly of a mechanism
/// than the compiler found; without it, pivots decide. There are no branches: numbers side by side choose their pivots
/// each for itself, and derivatives pass through.
pub fn least_norm<S: Scalar, const N: usize, const M: usize>(
    lower: &[S],
    rows: &[[S; N]; M],
    right: &SVector<S, N>,
    rates: &SVector<S, M>,
    rank: Option<usize>,
) -> (SVector<S, N>, SVector<S, M>) {
    let entry = |i: usize, j: usize| lower[i.max(j) * (i.max(j) + 1) / 2 + i.min(j)];
    let inertia = factored(&SMatrix::<S, N, N>::from_fn(entry));
    let mut columns: [SVector<S, N>; M] = core::array::from_fn(|j| inertia.half(&SVector::from(rows[j])));
    let free = inertia.half(right);
    let lack = SVector::<S, M>::from_fn(|j, _| rates[j] - dot(&columns[j], &free));
    let most = N.min(M);
    let brink = |k: usize| {
        S::from_f64(match rank {
            Some(rank) if k < rank => ROUNDED,
            _ => NEAR,
        })
    };
    // Gradients count by the part of them that is left, whatever their units.
    let per_size = columns.map(|column| {
        let size = dot(&column, &column);
        S::one() / S::select(Comparison::Equal, size, S::zero(), S::one(), size)
    });
    let mut q = [constant::<S, N>(S::zero()); M];
    let mut r = [constant::<S, M>(S::zero()); M];
    for k in 0..most {
        // The part of a gradient that does not follow from others.
        let left = |j: usize| {
            let size = dot(&columns[j], &columns[j]);
            S::select(Comparison::LessEqual, size * per_size[j], brink(k), S::zero(), size)
        };
        let (mut pivot, mut size) = (columns[0], left(0));
        for j in 1..M {
            let other = left(j);
            for i in 0..N {
                pivot[i] = S::select(Comparison::Less, size, other, columns[j][i], pivot[i]);
            }
            size = S::select(Comparison::Less, size, other, other, size);
        }
        pivot = direction(&pivot, size, S::zero());
        for before in &q[..k] {
            let part = dot(before, &pivot);
            pivot = SVector::from_fn(|i, _| pivot[i] - before[i] * part);
        }
        let rest = dot(&pivot, &pivot);
        q[k] = direction(&pivot, rest, S::zero());
        for j in 0..M {
            r[k][j] = dot(&q[k], &columns[j]);
            columns[j] = SVector::from_fn(|i, _| columns[j][i] - q[k][i] * r[k][j]);
        }
    }
    // Rᵀ = U T, where a direction that is none has a 1 on the diagonal of T.
    let mut u = r;
    let mut t = SMatrix::<S, M, M>::from_fn(|_, _| S::zero());
    for k in 0..most {
        let whole = dot(&u[k], &u[k]);
        for i in (0..k).chain(0..k) {
            let part = dot(&u[i], &u[k]);
            t[(i, k)] += part;
            u[k] = SVector::from_fn(|j, _| u[k][j] - u[i][j] * part);
        }
        let size = dot(&u[k], &u[k]);
        let none = whole * S::from_f64(ROUNDED * ROUNDED);
        let root = S::select(Comparison::LessEqual, size, none, S::one(), size).sqrt();
        t[(k, k)] = root;
        u[k] = direction(&u[k], size, none);
    }
    let mut z: SVector<S, M> = constant(S::zero());
    for k in (0..most).rev() {
        let mut sum = dot(&u[k], &lack);
        for j in k + 1..most {
            sum -= t[(k, j)] * z[j];
        }
        z[k] = sum / t[(k, k)];
    }
    let mut x = free;
    let (mut w, mut multipliers): ([S; M], SVector<S, M>) = ([S::zero(); M], constant(S::zero()));
    for k in 0..most {
        x = SVector::from_fn(|i, _| x[i] + q[k][i] * z[k]);
        let mut sum = z[k];
        for i in 0..k {
            sum -= t[(i, k)] * w[i];
        }
        w[k] = sum / t[(k, k)];
        multipliers = SVector::from_fn(|j, _| multipliers[j] + u[k][j] * w[k]);
    }
    (inertia.back(&x), multipliers)
}

/// The unit vector along `x`, whose square is `size`; none, which is 0, if that is within the limit.
fn direction<S: Scalar, const N: usize>(x: &SVector<S, N>, size: S, limit: S) -> SVector<S, N> {
    let root = S::select(Comparison::LessEqual, size, limit, S::one(), size).sqrt();
    SVector::from_fn(|i, _| S::select(Comparison::LessEqual, size, limit, S::zero(), x[i] / root))
}
