//! Steps from states at which the series does not exist: where the argument of a root vanishes, as that of |q̇| does
//! at rest.
//!
//! The motion is smooth on either side of such a time: from rest under gravity |q̇| is g (t − t₀) after it. The
//! polynomial of the step is then found by collocation: its second derivative agrees with the accelerations at the
//! Chebyshev points of the step. Fixed-point iteration finds it, and its error is estimated as that of a series
//! is.

use super::changes;
use crate::failure::Failure;
use crate::method::Interpolant;
use crate::method::taylor::Polynomial;
use crate::scalar::{Real, Scalar, SimdScalar};
use crate::series::TaylorSeries;
use crate::state::State;
use crate::system::System;

/// Number of collocation points: as many coefficients as the shortest series has.
const POINTS: usize = 8;

/// Largest number of iterations. Each one gains an order of h, or the step is too long.
const MAX_ITERATIONS: u32 = 24;

/// Half of 1 − cos((2j + 1) π/16): the Chebyshev points of the interval from 0 to 1.
const CHEBYSHEV: [f64; POINTS] = [
    0.009607359798384785,
    0.08426519384872738,
    0.22221488349019886,
    0.40245483899193585,
    0.5975451610080641,
    0.777785116509801,
    0.9157348061512727,
    0.9903926402016152,
];

/// Do all coefficients of a series to order p have finite values?
pub(super) fn exists<S: Scalar, const N: usize, const ROOM: usize>(
    series: &TaylorSeries<S, N, ROOM>,
    p: usize,
) -> bool {
    let vanishes = |x: &S| *x * S::zero() == S::zero();
    series.q[..(p + 2).min(ROOM)].iter().flatten().all(vanishes)
}

/// The states of a step at its collocation points.
pub(super) fn states<S: Scalar, const N: usize, const ROOM: usize>(
    polynomial: &Polynomial<S, N, ROOM>,
    h: S,
) -> [State<S, N>; POINTS] {
    CHEBYSHEV.map(|x| polynomial.at(polynomial.from.t + h * S::from_f64(x)))
}

/// The polynomial of the step of size `h`, by accelerations that are known to this multiple of rounding.
pub(super) fn collocated<Sys: System<N>, const N: usize, const ROOM: usize>(
    system: &Sys,
    from: &State<Sys::Scalar, N>,
    h: Sys::Scalar,
    order: usize,
    noise: f64,
) -> Result<Polynomial<Sys::Scalar, N, ROOM>, Failure<Sys::Scalar>>
where
    Sys::Scalar: SimdScalar,
{
    let mut polynomial = Polynomial { series: TaylorSeries::zero(), order, from: *from };
    polynomial.series.begin(from);
    let mut before = f64::INFINITY;
    for _ in 0..MAX_ITERATIONS {
        let accelerations = states(&polynomial, h).map(|at| system.accel(&at.q, &at.qd, at.t));
        let last = changes(&polynomial.series, order, h);
        for i in 0..N {
            let coefficients = interpolated(accelerations.map(|a| a[i]));
            let mut power = Sys::Scalar::one();
            for k in 0..POINTS {
                let both = Sys::Scalar::from_f64(((k + 1) * (k + 2)) as f64);
                polynomial.series.q[k + 2][i] = coefficients[k] / (power * both);
                power *= h;
            }
        }
        // Until rounding is all that still moves the end.
        let now = changes(&polynomial.series, order, h);
        let (mut moved, mut rounding) = (0.0f64, 0.0f64);
        for i in 0..N {
            let size = |x: Sys::Scalar| x.number(0).magnitude();
            moved = moved.max(size(now.qd[i] - last.qd[i]));
            rounding = rounding
                .max(<Sys::Scalar as SimdScalar>::Element::EPSILON * (size(from.qd[i]) + size(now.qd[i])));
            if !(now.qd[i] * Sys::Scalar::zero() == Sys::Scalar::zero()) {
                return Err(Failure::NonFinite { t: from.t, h });
            }
        }
        if moved <= rounding || (moved >= before && moved <= noise * rounding) {
            return Ok(polynomial);
        }
        before = moved;
    }
    Err(Failure::NotConverged { t: from.t, h, iterations: MAX_ITERATIONS })
}

/// The coefficients in x of the polynomial with these values at the collocation points, by Newton's divided
/// differences.
fn interpolated<S: Scalar>(mut values: [S; POINTS]) -> [S; POINTS] {
    let x = CHEBYSHEV.map(S::from_f64);
    for k in 1..POINTS {
        for j in (k..POINTS).rev() {
            values[j] = (values[j] - values[j - 1]) / (x[j] - x[j - k]);
        }
    }
    let mut coefficients = [S::zero(); POINTS];
    for j in (0..POINTS).rev() {
        // Times x − x_j, plus the next difference.
        for k in (1..POINTS).rev() {
            coefficients[k] = coefficients[k - 1] - x[j] * coefficients[k];
        }
        coefficients[0] = values[j] - x[j] * coefficients[0];
    }
    coefficients
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polynomials_are_interpolated_to_rounding() {
        let exact: [f64; POINTS] = core::array::from_fn(|k| [1.0, -0.5, 2.0, 0.25, -1.5, 0.75, 1.0, -2.0][k]);
        let value = |x: f64| exact.iter().rev().fold(0.0, |sum, a| sum * x + a);
        for (found, exact) in interpolated(CHEBYSHEV.map(value)).iter().zip(exact) {
            assert!((found - exact).abs() < 1e-10, "{found} {exact}");
        }
    }
}
