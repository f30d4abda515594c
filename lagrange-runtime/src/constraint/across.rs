//! Accelerations near states at which constraints are dependent, and the motion is smooth.
//!
//! At a distance δ from such a state, in radians between a gradient and the span of the others, a state that is e
//! beside the constraints has accelerations that are e/δ off, and rounding alone makes them ε/δ³ off. Stages of steps
//! are beside the constraints by much more than the error of a step, which then has no order. So stages are projected
//! first, and the nearest accelerations are interpolated.

use super::{Constrained, independence, restore};
use crate::scalar::{Real, Scalar};
use crate::state::{State, constant};
use nalgebra::SVector;

/// Square of the sine below which accelerations are interpolated: at 0.02 rad they have lost half of their digits,
/// and the nodes on both sides are so near that polynomials of degree 11 have more.
const CLOSE: f64 = 5e-4;

/// Weights at 0 of the polynomial through ±1, …, ±6, for either side.
const WEIGHTS: [f64; 6] = [6.0 / 7.0, -15.0 / 28.0, 5.0 / 21.0, -1.0 / 14.0, 1.0 / 77.0, -1.0 / 924.0];

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
    let apart = |at: &State<Sys::Scalar, N>| independence::<Sys, N, M>(system, start, at) >= CLOSE;
    // (Not of the projected state, which may be anywhere where constraints are dependent.)
    if apart(at) {
        return projected(0.0).map_or_else(|_| none(), |at| accel(&at));
    }
    let mut spacing = h.to_f64().abs() / 32.0;
    for _ in 0..MOST_SPACINGS {
        let both = |s: f64| Some([projected(-s).ok()?, projected(s).ok()?]);
        if let Some(nearest) = both(spacing).filter(|nodes| nodes.iter().all(apart)) {
            let mut sum: SVector<Sys::Scalar, N> = constant(Scalar::zero());
            for (j, weight) in WEIGHTS.into_iter().enumerate() {
                let nodes = if j == 0 { Some(nearest) } else { both(spacing * (j + 1) as f64) };
                let Some(nodes) = nodes else { return none() };
                for node in &nodes {
                    sum += accel(node) * number(weight);
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
