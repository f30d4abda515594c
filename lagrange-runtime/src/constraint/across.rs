//! Accelerations near states at which constraints are dependent, and the motion is smooth.
//!
//! At a distance δ from such a state, in radians between a gradient and the span of the others, a state that is e
//! beside the constraints has accelerations that are e/δ off, and rounding alone makes them ε/δ³ off. Stages of steps
//! are beside the constraints by much more than the error of a step, which then has no order. So stages are projected
//! first, and the nearest accelerations are interpolated.

use super::{Constrained, products, restore, usual_rank};
use crate::diagnosis::MAX_MATRIX_BYTES;
use crate::scalar::{Functions, Real, Scalar};
use crate::state::{State, constant};
use nalgebra::{SMatrix, SVector};

/// Square of the sine below which accelerations are interpolated: at 0.02 rad they have lost half of their digits,
/// and the nodes on both sides are so near that polynomials of degree 11 have more.
const CLOSE: f64 = 5e-4;

/// Weights at 0 of the polynomial through ±1, …, ±6, for either side.
const WEIGHTS: [f64; 6] = [6.0 / 7.0, -15.0 / 28.0, 5.0 / 21.0, -1.0 / 14.0, 1.0 / 77.0, -1.0 / 924.0];

/// Square of the sine of the smallest angle between the gradient of a constraint and the span of the others, in the
/// metric of the inertia matrix, at `at`; gradients that were longer at `start` count as that long. Of constraints
/// that follow from others everywhere, as many are left out. (1 where matrices are too large to look at.) Emitted as
/// [`System::independence`](crate::System::independence).
#[cold]
#[inline(never)]
pub fn independence<Sys: Constrained<N, M>, const N: usize, const M: usize>(
    system: &Sys,
    start: &State<Sys::Scalar, N>,
    at: &State<Sys::Scalar, N>,
) -> f64
where
    Sys::Scalar: Real,
{
    if size_of::<SMatrix<Sys::Scalar, N, N>>() > MAX_MATRIX_BYTES {
        return 1.0;
    }
    let (Some(before), Some(here)) = (products(system, start), products(system, at)) else { return 1.0 };
    let rank = usual_rank::<Sys, N, M>(&before).min(N);
    let scale: [f64; M] = core::array::from_fn(|j| 1.0 / Functions::sqrt(before[(j, j)].max(here[(j, j)])));
    let mut c = SMatrix::<f64, M, M>::from_fn(|i, j| here[(i, j)] * (scale[i] * scale[j]));
    let mut chosen = [false; M];
    let mut least: f64 = 1.0;
    for _ in 0..rank {
        let rest = (0..M).filter(|&j| !chosen[j]);
        let Some(row) = rest.max_by(|&i, &j| c[(i, i)].total_cmp(&c[(j, j)])) else { break };
        let pivot = c[(row, row)];
        least = least.min(pivot.max(0.0));
        if pivot <= 0.0 {
            break;
        }
        chosen[row] = true;
        for i in (0..M).filter(|&i| !chosen[i]) {
            let factor = c[(i, row)] / pivot;
            for j in 0..M {
                c[(i, j)] -= factor * c[(row, j)];
            }
        }
    }
    least
}

/// Accelerations on the motion that goes through states at which constraints are dependent, of a state near it: those
/// of the nearest admissible state, or, where gradients are nearly dependent, the polynomial of degree 11 through
/// those of states `(q + s q̇, q̇)` on both sides, at s = 0. Nodes are at least |h|/32 apart, where h is the size of
/// a step, and far enough for the nearest ones to be resolved. Not a number where there is no admissible state.
/// Emitted as [`System::accel_across`](crate::System::accel_across).
#[cold]
#[inline(never)]
pub fn accel_across<Sys: Constrained<N, M>, const N: usize, const M: usize>(
    system: &Sys,
    start: &State<Sys::Scalar, N>,
    at: &State<Sys::Scalar, N>,
    h: Sys::Scalar,
) -> SVector<Sys::Scalar, N>
where
    Sys::Scalar: Real,
{
    let none = || constant(Sys::Scalar::from_f64(f64::NAN));
    let number = Sys::Scalar::from_f64;
    let projected = |s: f64| {
        let q = SVector::from_fn(|i, _| at.q[i] + at.qd[i] * number(s));
        restore(system, &State { q, ..*at }).map(|restored| polished::<Sys, N, M>(system, &restored.state))
    };
    let accel = |at: &State<Sys::Scalar, N>| system.accel(&at.q, &at.qd, at.t);
    // (Not of the projected state, which may be anywhere where constraints are dependent.)
    if independence::<Sys, N, M>(system, start, at) >= CLOSE {
        return projected(0.0).map_or_else(|_| none(), |at| accel(&at));
    }
    let mut spacing = h.to_f64().abs() / 32.0;
    for _ in 0..MOST_SPACINGS {
        let resolved =
            |s: f64| projected(s).is_ok_and(|at| independence::<Sys, N, M>(system, start, &at) >= CLOSE);
        if resolved(spacing) && resolved(-spacing) {
            let mut sum: SVector<Sys::Scalar, N> = constant(Scalar::zero());
            for (j, weight) in WEIGHTS.into_iter().enumerate() {
                for side in [-1.0, 1.0] {
                    let Ok(node) = projected(side * spacing * (j + 1) as f64) else { return none() };
                    sum += accel(&node) * number(weight);
                }
            }
            return sum;
        }
        spacing *= 1.5;
    }
    none()
}

/// `at`, on the constraints to rounding, by a correction that is made however small it is: [`restore`] leaves what is
/// no more than rounding of the terms of a constraint, which, divided by δ, is more than that of its value.
fn polished<Sys: Constrained<N, M>, const N: usize, const M: usize>(
    system: &Sys,
    at: &State<Sys::Scalar, N>,
) -> State<Sys::Scalar, N>
where
    Sys::Scalar: Real,
{
    let State { t, mut q, mut qd } = *at;
    let none = constant(Scalar::zero());
    q += system.response(&q, &qd, t, &none, &-system.constraints(&q, t)).0;
    qd += system.response(&q, &qd, t, &none, &-system.constraint_rates(&q, &qd, t)).0;
    State { t, q, qd }
}

/// 1.5⁶⁰ is 4e10.
const MOST_SPACINGS: u32 = 60;
