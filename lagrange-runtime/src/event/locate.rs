//! From the place of a root within a step to the state there: on the interpolant, or on the trajectory itself.

use super::Direction;
use super::landing::{Judge, Landing, MOVED, Progress, ROUNDINGS};
use super::outline::Outline;
use super::root::first_zero;
use super::within::{Within, apart, slope};
use crate::controller::{Controller, FirstStep};
use crate::failure::{EventName, Failure};
use crate::integrate::{Drive, Engine, Number, crossed};
use crate::method::{Interpolant, Method, Step};
use crate::scalar::{Real, Scalar};
use crate::state::{State, Tangent, add_scaled};
use crate::system::System;
use core::cell::OnceCell;

/// A step with its interpolant, and the memory with which it began.
pub(super) struct Stepped<Sys: System<N>, M: Method<Sys, N>, const N: usize> {
    pub step: Step<Sys, M, N>,
    pub dense: M::Interpolant,
    pub memory: M::MethodState,
    /// Equal parts of the step at whose ends events are looked at.
    pub parts: u32,
    /// A step across a switch is a short one, see [`Engine::crosses_shortly`].
    pub crosses_shortly: bool,
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

/// Corrections of the derivatives of a root: the slope of g is a difference quotient.
const CORRECTIONS: u32 = 4;

/// Roundings of time over which the motion across a switch is differentiated.
const MANY_ROUNDINGS: f64 = 1_048_576.0;

/// Moves a place, at which g vanishes as a number, to where it vanishes with its derivatives too, which duals carry:
/// `δx = −δg / (dg/dx)`. None for other numbers, whose `δg = 0`.
fn with_slopes<S: Real, const N: usize>(
    x: f64,
    slope: f64,
    state: impl Fn(S) -> State<S, N>,
    g: impl Fn(&State<S, N>) -> S,
) -> Option<S> {
    let mut place = S::from_f64(x);
    for _ in 0..CORRECTIONS {
        let rest = g(&state(place)).infinitesimal();
        if !(rest.magnitude() > 0.0 && slope != 0.0) {
            break;
        }
        place -= rest / S::from_f64(slope);
    }
    (place.infinitesimal().magnitude() > 0.0).then_some(place)
}

/// The motion within a step that crosses a switch, on the side of it on which the place x is: from one of its ends,
/// with the acceleration there. The step is so short that this is as good as the step, whose slopes belong to neither
/// side. None for other steps, and for numbers without slopes.
fn on_one_side<'a, Sys, M, const N: usize>(
    system: &Sys,
    stepped: &'a Stepped<Sys, M, N>,
    x: f64,
) -> Option<impl Fn(Sys::Scalar) -> State<Sys::Scalar, N> + use<'a, Sys, M, N>>
where
    Sys: System<N>,
    Sys::Scalar: Real,
    M: Method<Sys, N>,
{
    let Step { from, to, h, .. } = &stepped.step;
    if Sys::SWITCHES == 0
        || Sys::Scalar::SLOPES == 0
        || !stepped.crosses_shortly
        || !crossed(system, from, to)
    {
        return None;
    }
    let (end, place) = if crossed(system, from, &stepped.at(x)) { (to, 1.0) } else { (from, 0.0) };
    let rates = Tangent { q: end.qd, qd: system.accel(&end.q, &end.qd, end.t) };
    Some(move |x: Sys::Scalar| {
        let dt = (x - Scalar::from_f64(place)) * *h;
        let half = dt * dt * Scalar::from_f64(0.5);
        let moved = end.moved(end.t + dt, dt, &rates);
        State { q: add_scaled(&moved.q, half, &rates.qd), ..moved }
    })
}

/// The place with slopes, and the state there, of a root x of g within a step across a switch.
fn across_switch<Sys, M, const N: usize>(
    system: &Sys,
    stepped: &Stepped<Sys, M, N>,
    x: f64,
    g: impl Fn(&State<Sys::Scalar, N>) -> Sys::Scalar,
) -> Option<State<Sys::Scalar, N>>
where
    Sys: System<N>,
    Sys::Scalar: Real,
    M: Method<Sys, N>,
{
    let motion = on_one_side(system, stepped, x)?;
    let d = MANY_ROUNDINGS * stepped.resolution();
    let [before, after] = [x - d, x + d].map(|x| g(&motion(Scalar::from_f64(x))).to_f64());
    with_slopes(x, (after - before) / (2.0 * d), &motion, g).map(motion)
}

/// The state of the interpolant at its root `x`.
pub(super) fn on_interpolant<Sys, M, const N: usize>(
    system: &Sys,
    stepped: &Stepped<Sys, M, N>,
    x: f64,
    g: impl Fn(&State<Sys::Scalar, N>) -> Sys::Scalar + Copy,
) -> State<Sys::Scalar, N>
where
    Sys: System<N>,
    Sys::Scalar: Real,
    M: Method<Sys, N>,
{
    if let Some(state) = across_switch(system, stepped, x, g) {
        return state;
    }
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
    event: EventName,
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
    if let Some(state) = across_switch(system, stepped, x, g) {
        engine.land(system, state);
        return Ok(state);
    }
    if g(&landed).infinitesimal().magnitude() > 0.0 {
        let state = |x: Number<D, N>| {
            let step = engine.method.step(system, &stepped.memory, &from, x * h);
            step.map_or(from, |(step, _)| step.to)
        };
        if let Some(place) = with_slopes(x, slope, state, g) {
            let (step, _) = engine.attempt_from(system, &stepped.memory, &from, place * h)?;
            engine.land(system, step.to);
            return Ok(step.to);
        }
    }
    engine.land(system, landed);
    Ok(landed)
}

/// The place and the state where g vanishes on the trajectory, near the root `root` of the interpolant, along which
/// states are moved: `attempt` makes steps. None if Newton's method does not converge.
fn corrected<S: Real, const N: usize>(
    step: &(impl Within<S, N> + ?Sized),
    root: f64,
    slope: f64,
    g: impl Fn(&State<S, N>) -> S + Copy,
    mut attempt: impl FnMut(f64) -> Result<State<S, N>, Failure<S>>,
) -> Option<(f64, State<S, N>)> {
    if !(root > 0.0 && root <= 1.0) {
        return None;
    }
    let mut landing = Landing::new(0, root, slope);
    loop {
        let (x, at) = (landing.x, attempt(landing.x).ok()?);
        let d = apart(x);
        // By the first and second difference there.
        let differences = OnceCell::new();
        let moved = |parts: f64| {
            let [before, after] = differences.get_or_init(|| {
                let middle = step.between(x);
                [-d, d].map(|d| step.between(x + d).minus(&middle))
            });
            let u = parts / d;
            let [back, forth] = [0.5 * u * (u - 1.0), 0.5 * u * (u + 1.0)].map(S::from_f64);
            let t = at.t + step.size() * S::from_f64(parts);
            at.moved(t, back, before).moved(t, forth, after)
        };
        match landing.next(&at, step.resolution(), g, |rest| rest.abs() <= MOVED, moved) {
            Progress::Again => {}
            Progress::Landed(state) => return Some((landing.x, state)),
            Progress::Lost => return None,
        }
    }
}

/// The ends of a step, if the method knows the accelerations there.
pub(crate) fn outline<Sys, M, const N: usize>(
    method: &M,
    step: &Step<Sys, M, N>,
) -> Option<Outline<Sys::Scalar, N>>
where
    Sys: System<N, Scalar: Real>,
    M: Method<Sys, N>,
{
    let accelerations = method.end_accelerations(step)?;
    Some(Outline { ends: [step.from, step.to], accelerations, h: step.h })
}

/// The state at the event that a step has alone: `approach` is shown the step itself if it ends nearby, and steps from
/// its start, and a judge of its errors. None if they do not lead there.
pub(crate) fn approached<Sys, M, C, const N: usize>(
    engine: &mut Engine<Sys, M, C, N>,
    system: &Sys,
    memory: &M::MethodState,
    (step, outline): (&Step<Sys, M, N>, &Outline<Sys::Scalar, N>),
    mut landing: Landing,
    mut approach: impl FnMut(
        &mut Landing,
        &Outline<Sys::Scalar, N>,
        &dyn Judge<Sys::Scalar, N>,
    ) -> Progress<Sys::Scalar, N>,
) -> Option<State<Sys::Scalar, N>>
where
    Sys: System<N, Scalar: Real>,
    M: Method<Sys, N>,
    C: Controller<Sys::Scalar, N, M::Error>,
{
    let adaptive = !matches!(engine.controller.first_step(), FirstStep::Fixed(_));
    let accelerations = |at: &State<_, N>| system.accel(&at.q, &at.qd, at.t);
    if let Some(mut landing) = landing.at_end().filter(|_| adaptive && Engine::<Sys, M, C, N>::AIMS) {
        let tolerates =
            |error: &Tangent<_, N>| adaptive && engine.controller.norm(error, &step.from, &step.to) <= 1.0;
        let progress = approach(&mut landing, outline, &(tolerates, accelerations));
        engine.statistics.evaluations += 1;
        if let Progress::Landed(state) = progress {
            return Some(state);
        }
    }
    loop {
        let h = step.h * Sys::Scalar::from_f64(landing.x);
        let (one, _) = engine.attempt_from(system, memory, &step.from, h).ok()?;
        let reached = self::outline(&engine.method, &one)?;
        let tolerates =
            |error: &Tangent<_, N>| adaptive && engine.controller.norm(error, &one.from, &one.to) <= 1.0;
        match approach(&mut landing, &reached, &(tolerates, accelerations)) {
            Progress::Again => {}
            Progress::Landed(state) => return Some(state),
            Progress::Lost => return None,
        }
    }
}

/// The part of the step from its start to where g vanishes on the trajectory, near the root `x` of the interpolant,
/// and the state there. `attempt` makes steps from the start.
pub(crate) fn landing<S: Real, const N: usize>(
    step: &(impl Within<S, N> + ?Sized),
    event: EventName,
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
