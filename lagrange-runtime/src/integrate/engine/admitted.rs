//! States with which a motion can begin.

use crate::failure::{Coordinate, Failure, Part};
use crate::scalar::Real;
use crate::state::{Restored, State};
use crate::system::System;
use nalgebra::SVector;

/// The largest violation of a constraint, as in [`Restored::violation`], that is taken for rounding in a given start.
pub(super) const CONSISTENT: f64 = 1e-6;

/// The same after an input has changed, for a state that was on the constraints before: the remainders of many small
/// jumps add up.
pub(super) const STILL_CONSISTENT: f64 = 1e-10;

/// The part of a state that is not finite. (Names of coordinates are found by [`System::explained`].)
#[cfg_attr(not(debug_assertions), inline(always))]
fn not_finite<S: Real, const N: usize>(state: &State<S, N>) -> Option<Part> {
    let worst = |x: &SVector<S, N>| (0..N).find(|&i| x[i] * S::zero() != S::zero());
    let at = |index: usize| Coordinate { index, name: "" };
    match state.t.to_f64().is_finite() {
        true if state.is_finite() => None,
        true => worst(&state.q)
            .map(|i| Part::Coordinate(at(i)))
            .or_else(|| worst(&state.qd).map(|i| Part::Velocity(at(i)))),
        false => Some(Part::Time),
    }
}

/// A state with which a motion can begin, on the constraints of the system to rounding.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn admitted<Sys: System<N>, const N: usize>(
    system: &Sys,
    state: &State<Sys::Scalar, N>,
) -> Result<State<Sys::Scalar, N>, Failure<Sys::Scalar>>
where
    Sys::Scalar: Real,
{
    admitted_within(system, state, CONSISTENT)
}

/// The same of a state that violates constraints by no more than the bound.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn admitted_within<Sys: System<N>, const N: usize>(
    system: &Sys,
    state: &State<Sys::Scalar, N>,
    bound: f64,
) -> Result<State<Sys::Scalar, N>, Failure<Sys::Scalar>>
where
    Sys::Scalar: Real,
{
    let t = state.t;
    if let Some(part) = not_finite(state) {
        return Err(Failure::StateNotFinite { t, part });
    }
    match system.restored(state)? {
        Some(Restored { state, constraint, violation }) if violation > bound => {
            // (Conditions that contradict each other by little are violated wherever the state is.)
            let stays = |left: Restored<_, N>| violation <= CONSISTENT && left.violation > 0.1 * violation;
            if system.restored(&state)?.is_some_and(stays) {
                return Ok(state);
            }
            Err(Failure::ConstraintViolated { t, constraint, violation })
        }
        Some(restored) => Ok(restored.state),
        None => Ok(*state),
    }
}
