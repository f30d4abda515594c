//! From the place of a root within a step to the state there: on the interpolant, or on the trajectory itself.

use super::Direction;
use super::root::first_zero;
use super::search::Within;
use crate::failure::Failure;
use crate::integrate::{Drive, Number};
use crate::method::{Interpolant, Method, Step};
use crate::scalar::{Real, Scalar};
use crate::state::State;
use crate::system::System;

/// A step with its interpolant, and the memory with which it began.
pub(super) struct Stepped<Sys: System<N>, M: Method<Sys, N>, const N: usize> {
    pub step: Step<Sys, M, N>,
    pub dense: M::Interpolant,
    pub memory: M::MethodState,
    /// Equal parts of the step at whose ends events are looked at.
    pub parts: u32,
}

impl<Sys, M, const N: usize> Within<Sys::Scalar, N> for Stepped<Sys, M, N>
where
    Sys: System<N>,
    Sys::Scalar: Real,
    M: Method<Sys, N>,
{
    fn parts(&self) -> u32 {
        self.parts
    }

    fn ends(&self) -> [State<Sys::Scalar, N>; 2] {
        [self.step.from, self.step.to]
    }

    fn size(&self) -> Sys::Scalar {
        self.step.h
    }

    fn between(&self, x: f64) -> State<Sys::Scalar, N> {
        self.dense.at(self.time(x))
    }
}

/// Parts of a step over which the interpolant is differentiated.
const D: f64 = 1.0 / 4096.0;

/// `dg/dx` along the interpolant.
fn slope<S: Real, const N: usize>(
    step: &(impl Within<S, N> + ?Sized),
    x: f64,
    g: impl Fn(&State<S, N>) -> S,
) -> f64 {
    let value = |x: f64| g(&step.at(x)).to_f64();
    (value(x + D) - value(x - D)) / (2.0 * D)
}

/// Moves a place, at which g vanishes as a number, to where it vanishes with its derivatives too, which duals carry:
/// `δx = −δg / (dg/dx)`. None for other numbers, whose `δg = 0`. Twice, since the slope is a difference quotient.
fn with_slopes<S: Real, const N: usize>(
    x: f64,
    slope: f64,
    state: impl Fn(S) -> State<S, N>,
    g: impl Fn(&State<S, N>) -> S,
) -> Option<S> {
    let mut place = S::from_f64(x);
    for _ in 0..2 {
        let value = g(&state(place));
        let rest = value - S::from_f64(value.to_f64());
        if !(rest.magnitude() > 0.0 && slope != 0.0) {
            return None;
        }
        place -= rest / S::from_f64(slope);
    }
    Some(place)
}

/// The state of the interpolant at its root `x`.
pub(super) fn on_interpolant<Sys, M, const N: usize>(
    stepped: &Stepped<Sys, M, N>,
    x: f64,
    g: impl Fn(&State<Sys::Scalar, N>) -> Sys::Scalar + Copy,
) -> State<Sys::Scalar, N>
where
    Sys: System<N>,
    Sys::Scalar: Real,
    M: Method<Sys, N>,
{
    let at = |x: Sys::Scalar| stepped.dense.at(x * stepped.step.h + stepped.step.from.t);
    match with_slopes(x, slope(stepped, x, g), at, g) {
        Some(x) => at(x),
        None => stepped.at(x),
    }
}

/// Steps from the start of the step to where g vanishes, near the root `x` of the interpolant, and leaves the run
/// there.
pub(super) fn land<D: Drive<N>, const N: usize>(
    run: &mut D,
    stepped: &Stepped<D::System, D::Method, N>,
    event: usize,
    x: f64,
    direction: Direction,
    g: impl Fn(&D::System, &State<Number<D, N>, N>) -> Number<D, N> + Copy,
) -> Result<State<Number<D, N>, N>, Failure<Number<D, N>>> {
    let (system, engine) = run.parts();
    let g = |at: &State<Number<D, N>, N>| g(system, at);
    let Step { from, h, .. } = stepped.step;
    let slope = slope(stepped, x, g);
    let attempt = |x: f64| {
        Ok(engine.attempt_from(system, &stepped.memory, &from, h * Number::<D, N>::from_f64(x))?.0.to)
    };
    let (x, landed) = landing(stepped, event, x, direction, g, attempt)?;
    let value = g(&landed);
    if (value - Number::<D, N>::from_f64(value.to_f64())).magnitude() > 0.0 {
        let state = |x: Number<D, N>| {
            let mut next = stepped.memory.clone();
            let step = engine.method.step(system, &stepped.memory, &from, x * h, &mut next);
            step.map_or(from, |step| step.to)
        };
        if let Some(place) = with_slopes(x, slope, state, g) {
            let (step, _) = engine.attempt_from(system, &stepped.memory, &from, place * h)?;
            engine.land(step.to);
            return Ok(step.to);
        }
    }
    engine.land(landed);
    Ok(landed)
}

/// Parts of a step by which a state is moved along the interpolant to an event: the error of its slope, which is
/// about as large, is a factor of that of the move.
const MOVED: f64 = 1e-7;

/// Parts of a step by which Newton's method may leave the root of the interpolant.
const NEARBY: f64 = 1.0 / 16.0;

/// Steps that Newton's method may take.
const CORRECTIONS: usize = 4;

/// The place and the state where g vanishes on the trajectory, by Newton's method from the root `x` of the
/// interpolant: `attempt` steps to where the last correction led. From there the rest of the way, if it is short, is
/// that of the interpolant. None if it does not converge.
fn corrected<S: Real, const N: usize>(
    step: &(impl Within<S, N> + ?Sized),
    root: f64,
    slope: f64,
    g: impl Fn(&State<S, N>) -> S + Copy,
    mut attempt: impl FnMut(f64) -> Result<State<S, N>, Failure<S>>,
) -> Option<(f64, State<S, N>)> {
    let mut x = root;
    for _ in 0..CORRECTIONS {
        if !(x > 0.0 && x <= 1.0 && (x - root).abs() <= NEARBY) {
            return None;
        }
        let at = attempt(x).ok()?;
        let rest = g(&at).to_f64() / slope;
        if rest.abs() <= 0.5 * S::EPSILON {
            return Some((x, at));
        }
        if rest.abs() <= MOVED {
            return moved_along(step, x, at, rest, slope, g);
        }
        x -= rest;
    }
    None
}

/// Moves a state at the place `x` along the interpolant to where g, which is `rest` parts of the step away by its
/// slope, vanishes: by its first and second difference there, since it is a function of time, which is rounded.
fn moved_along<S: Real, const N: usize>(
    step: &(impl Within<S, N> + ?Sized),
    x: f64,
    at: State<S, N>,
    mut rest: f64,
    slope: f64,
    g: impl Fn(&State<S, N>) -> S + Copy,
) -> Option<(f64, State<S, N>)> {
    let middle = step.between(x);
    let [before, after] = [-D, D].map(|d| step.between(x + d).minus(&middle));
    let (mut place, mut state) = (x, at);
    for _ in 0..CORRECTIONS {
        let next = place - rest;
        if !(next > 0.0 && next <= 1.0) {
            return None;
        }
        // Weights of the two differences in the parabola through them.
        let u = (next - x) / D;
        let [back, forth] = [0.5 * u * (u - 1.0), 0.5 * u * (u + 1.0)].map(S::from_f64);
        let t = at.t + step.size() * S::from_f64(next - x);
        let moved = at.moved(t, back, &before).moved(t, forth, &after);
        let left = g(&moved).to_f64() / slope;
        // (What is not a number has not come nearer.)
        if left.abs() >= rest.abs() || left.is_nan() {
            break;
        }
        (place, state, rest) = (next, moved, left);
    }
    (rest.abs() <= ROUNDINGS * step.resolution().max(S::EPSILON)).then_some((place, state))
}

/// The part of the step from its start to where g vanishes on the trajectory, near the root `x` of the interpolant,
/// and the state there. `attempt` makes steps from the start.
pub(crate) fn landing<S: Real, const N: usize>(
    step: &(impl Within<S, N> + ?Sized),
    event: usize,
    x: f64,
    direction: Direction,
    g: impl Fn(&State<S, N>) -> S + Copy,
    mut attempt: impl FnMut(f64) -> Result<State<S, N>, Failure<S>>,
) -> Result<(f64, State<S, N>), Failure<S>> {
    let mut attempt = |x: f64| if x == 0.0 { Ok(step.at(0.0)) } else { attempt(x) };
    // A touch has no bracket; the extremum of the interpolant is as near as there is.
    if direction == Direction::Either {
        return Ok((x, attempt(x)?));
    }
    let before = if direction == Direction::Rising { -1.0 } else { 1.0 };
    // A jump from the step before, as an input that changes makes it, or a root that was passed there by rounding.
    if x <= ROUNDINGS * step.resolution().max(S::EPSILON) && g(&step.at(0.0)).to_f64() * before <= 0.0 {
        return Ok((0.0, step.at(0.0)));
    }
    let slope = slope(step, x, g);
    if slope * before < 0.0
        && let Some(landed) = corrected(step, x, slope, g, &mut attempt)
    {
        return Ok(landed);
    }
    let mut failure = None;
    let mut value = |x: f64| match attempt(x) {
        Ok(state) => g(&state).to_f64(),
        Err(reason) => {
            failure = Some(reason);
            f64::NAN
        }
    };
    let widths = [8.0 * S::EPSILON, ROUNDINGS * step.resolution()];
    let bracket = bracket(&mut value, x, before, slope, widths);
    let found =
        bracket.map(|[a, b]| if a == b { a.0 } else { first_zero(&mut value, a, b, 0.5 * S::EPSILON) });
    let (t, h) = (step.ends()[0].t, step.size());
    match (failure, found) {
        (Some(failure), _) => Err(failure),
        (None, None) => Err(Failure::EventNotBracketed { t, h, event }),
        (None, Some(x)) if x.is_nan() => Err(Failure::EventNotFinite { t, event }),
        (None, Some(x)) => Ok((x, attempt(x)?)),
    }
}

/// Roundings of time before an end of the step, or after it, at which a root counts as being at the end: steps that
/// end at a switch end at the events of its switching function.
const ROUNDINGS: f64 = 16.0;

/// Two places around `x`, `least` apart or more, between which the value changes from the sign `before`, if there are
/// any in the step; twice an end of the step that is apart from such a change by `rounding` at most.
fn bracket(
    mut value: impl FnMut(f64) -> f64,
    x: f64,
    before: f64,
    slope: f64,
    [least, rounding]: [f64; 2],
) -> Option<[(f64, f64); 2]> {
    let middle = (x, value(x));
    let forward = middle.1 * before > 0.0;
    let newton = (2.0 * middle.1 / slope).abs();
    let mut width = if newton.is_finite() { newton.max(least) } else { 1.0 };
    let mut near = middle;
    loop {
        let x = if forward { (x + width).min(1.0) } else { (x - width).max(0.0) };
        let far = (x, value(x));
        if far.1.is_nan() {
            return None;
        }
        match (far.1 * before > 0.0, forward) {
            (false, true) => return Some([near, far]),
            (true, false) => return Some([far, near]),
            _ if x == 0.0 || x == 1.0 => return (far.1.abs() <= rounding * slope.abs()).then_some([far; 2]),
            _ => (near, width) = (far, 8.0 * width),
        }
    }
}
