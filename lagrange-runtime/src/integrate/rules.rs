//! The rules of time: each decision about one step of one run, as a function of numbers alone. The loop of runs and
//! steppers asks them for its run, the loop of lanes for each of its lanes, in loops that the optimiser makes vectors
//! of.

use super::switches::{Approach, Passage, differ, passage};
use crate::controller::Controller;
use crate::event::within::Within;
use crate::failure::{Cause, Failure};
use crate::method::{Method, Step};
use crate::scalar::{Real, Scalar};
use crate::state::{State, Tangent};
use crate::system::System;

/// Attempted steps after which an adaptive run gives up unless told otherwise.
const MAX_STEPS: u64 = 1_000_000;

/// An adaptive run asks whether velocities cancel ([`System::resolved`]) before steps of less than this part of its
/// longest one: at the distance d of a singularity steps are as d or shorter, and velocities have lost a part of
/// their digits that is as 1/d, so that most are left where it begins to ask.
const TINY: f64 = 1e-4;

/// Parts of the time to the end of which a step is at most one while velocities do not change, if time appears in the
/// equations: forces that set in later are not seen from there.
const LOOKOUTS: f64 = 128.0;

/// The number of attempted steps that a run may make, of equal size or not.
#[inline(always)]
pub fn budget(asked: Option<u64>, equal: bool) -> u64 {
    asked.unwrap_or(if equal { u64::MAX } else { MAX_STEPS })
}

/// The number of equal steps to the end, none longer than `h` but for rounding, and their size. Times are rounded as
/// those at `start`, too, from which they are counted.
#[inline(always)]
pub fn divided<S: Real>(start: S, t: S, h: S, end: S) -> Result<(f64, S), Failure<S>> {
    let ratio = ((end - t) / h).to_f64();
    if ratio < 0.0 {
        return Err(Failure::WrongDirection { t, h, end });
    }
    // The ratio's own rounding error must not cost a step.
    let rounding = 4.0 * S::EPSILON * (ratio + (t / h).to_f64().abs().max((start / h).to_f64().abs()));
    let least = ratio - rounding.min(0.5);
    let whole = least as u64 as f64;
    let n = if whole < least { whole + 1.0 } else { whole };
    let total = if end == t { 0.0 } else { n.max(1.0) };
    Ok((total, (end - t) / S::from_f64(total.max(1.0))))
}

/// The time of the next of `total` equal steps, after `count` of them.
#[inline(always)]
pub fn next_time<S: Real>(count: f64, total: f64, h: S, origin: S, end: Option<S>) -> S {
    match end {
        Some(end) if count + 1.0 == total => end,
        _ => S::from_f64(count + 1.0).mul_add(h, origin),
    }
}

/// The longest step that needs no second look: the longest one of the controller, or that of a state that does not
/// accelerate with so much time to the end.
#[inline(always)]
pub fn longest_unseen<S: Real>(max_step: f64, rest: Option<S>) -> f64 {
    rest.map_or(max_step, |rest| max_step.min(rest.to_f64().abs() / LOOKOUTS))
}

/// `h`, or the longest step in its direction: `max_step` of the controller, and `bound` where the state `coasts` for
/// so long.
#[inline(always)]
pub fn limited<S: Real>(h: S, max_step: f64, bound: f64, coasts: impl FnOnce() -> bool) -> S {
    let h = shortened(h, max_step);
    if h.to_f64().abs() > bound && coasts() { shortened(h, bound) } else { h }
}

#[inline(always)]
fn shortened<S: Real>(h: S, longest: f64) -> S {
    let size = h.to_f64();
    if size.abs() > longest { S::from_f64(longest.copysign(size)) } else { h }
}

/// Returns whether the accelerations at a state change its velocities in a time by less than is tolerated: the error
/// estimate of a step knows no forces there. (It takes copies: addresses would keep the run in memory.)
#[cold]
#[inline(never)]
pub fn coasts<Sys, E, C, const N: usize>(
    system: &Sys,
    controller: C,
    at: State<Sys::Scalar, N>,
    time: f64,
) -> bool
where
    Sys: System<N, Scalar: Real>,
    C: Controller<Sys::Scalar, N, E>,
{
    let accelerations = system.accel(&at.q, &at.qd, at.t);
    let change =
        Tangent { q: at.q.map(|_| Sys::Scalar::zero()), qd: accelerations * Sys::Scalar::from_f64(time) };
    controller.norm(&change, &at, &at) <= 1.0
}

/// The step that is tried in place of `h` with so much time to the end, and whether it lands there: a step is longer
/// by up to 1 % for that. One on the way to a switch has its own size.
#[inline(always)]
pub fn towards_end<S: Real>(h: S, to_switch: Option<f64>, rest: Option<S>) -> (S, bool) {
    // (Compared, not divided: all of the step waits for it.)
    let (h, reach) = match to_switch.map(S::from_f64) {
        Some(h) => (h, h),
        None => (h, h * S::from_f64(1.01)),
    };
    match rest {
        Some(rest) if reach.to_f64().abs() >= rest.to_f64().abs() => (rest, true),
        _ => (h, false),
    }
}

/// The step that is tried in place of `h` if it would lead to an event that ends the run: the time `aim`, a little
/// beyond it. A step is longer by up to 1 % for that, as for the [end](towards_end), of which it has to stay short.
#[inline(always)]
pub fn towards_event<S: Real>(h: S, aim: f64, rest: Option<S>) -> Option<S> {
    let size = h.to_f64();
    let is_before = rest.is_none_or(|rest| aim < rest.to_f64().abs());
    (1.01 * size.abs() >= aim && is_before).then(|| S::from_f64(aim.copysign(size)))
}

/// Returns whether steps aim at events. They do not where an event is met by whole steps alone: at switches, and on
/// constraints, to which states are projected at the ends of steps. (Nor for numbers with slopes, whose errors the
/// controller does not see.)
pub const fn aims<Sys: System<N>, const N: usize>() -> bool {
    Sys::SWITCHES == 0 && Sys::CONSTRAINTS == 0
}

/// A tenth of the step does not change the time.
#[inline(always)]
pub fn underflows<S: Real>(t: S, h: S) -> bool {
    t + h * S::from_f64(0.1) == t
}

/// The failure of a run whose next step would not change its time. Where accelerations are not finite at the state
/// itself, as by a parameter that is not a number, the step is not to blame.
#[cold]
pub fn underflowed<Sys: System<N>, const N: usize>(
    system: &Sys,
    at: &State<Sys::Scalar, N>,
    h: Sys::Scalar,
    cause: Option<Cause>,
) -> Failure<Sys::Scalar> {
    let is_given = || !State { qd: system.accel(&at.q, &at.qd, at.t), ..*at }.is_finite();
    match cause {
        None | Some(Cause::NonFinite) if is_given() => Failure::NonFinite { t: at.t, h: Scalar::zero() },
        _ => Failure::StepSizeUnderflow { t: at.t, h, cause },
    }
}

/// Velocities may cancel before so short a step.
#[inline(always)]
pub fn is_tiny<S: Real>(h: S, longest: f64) -> bool {
    h.to_f64().abs() < TINY * longest
}

/// The next step, `factor` times the one that was tried. One that was taken, and cut short by the end of the run or a
/// switch, says little about the one after it, which is not made shorter than the `h` before for that.
#[inline(always)]
pub fn next_step<S: Real>(h: S, tried: S, factor: f64, taken: bool, cut: bool) -> S {
    // (Slopes of the time at which a switch was met would grow with every factor.)
    let size = if taken { tried - tried.infinitesimal() } else { tried };
    let next = size * S::from_f64(factor);
    let longer = next.to_f64().abs() > h.to_f64().abs();
    if taken & cut & !longer { h } else { next }
}

/// Did the method end the step before its time h, where the equations switch?
#[inline(always)]
pub fn ends_early<Sys: System<N>, M: Method<Sys, N>, const N: usize>(
    step: &Step<Sys, M, N>,
    h: Sys::Scalar,
) -> bool {
    step.h != h && step.from.t + step.h != step.from.t + h
}

/// A decision on a step of which the controller has said whether it is `good`, and the factor of the next one, with
/// regard to the switches of the system: as [`passage`], which sees the motion `within`.
///
/// # Errors
/// Those of [`passage`].
#[inline(always)]
pub fn across<Sys, W, const N: usize>(
    approach: &mut Approach,
    system: &Sys,
    ends: [&State<Sys::Scalar, N>; 2],
    (good, factor): (bool, f64),
    within: impl FnOnce() -> W,
    norm: impl Fn(&Tangent<Sys::Scalar, N>, &State<Sys::Scalar, N>, &State<Sys::Scalar, N>) -> f64,
) -> Result<Passage, Failure<Sys::Scalar>>
where
    Sys: System<N, Scalar: Real>,
    W: Within<Sys::Scalar, N>,
{
    if !good && !differ(system, ends[0], ends[1]) {
        return Ok(Passage::Free);
    }
    passage(approach, system, &within(), (!good).then_some(factor), norm)
}

/// The factor of the next step after one of size h from `at` that could not be made, or `None` for another one on the
/// way to a switch, if the run comes up to `switches`; `shorter` is the controller's factor.
///
/// # Errors
/// The failure itself, if no shorter step can help.
#[inline(always)]
pub fn retried<Sys, const N: usize>(
    failure: Failure<Sys::Scalar>,
    switches: Option<&mut Approach>,
    system: &Sys,
    at: &State<Sys::Scalar, N>,
    h: f64,
    shorter: impl FnOnce() -> Option<f64>,
) -> Result<Option<f64>, Failure<Sys::Scalar>>
where
    Sys: System<N, Scalar: Real>,
{
    if matches!(failure, Failure::Sliding { .. } | Failure::NoDerivative { .. }) {
        return Err(failure);
    }
    if let Some(approach) = switches {
        if approach.after_failure(system, at, h)? {
            return Ok(None);
        }
        *approach = Approach::NONE;
    }
    shorter().map(Some).ok_or(failure)
}
