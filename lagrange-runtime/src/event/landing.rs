//! The way to an event that ends a run: steps from the start of the one that it lies in, by Newton's method.

use super::definition::Bound;
use super::outline::Outline;
use super::within::Within;
use crate::scalar::Real;
use crate::state::{State, Tangent};
use nalgebra::SVector;

/// Parts of a step by which a state is always moved to an event, and no step is made: the error of such a move is
/// smaller by another such factor.
pub(crate) const MOVED: f64 = 1e-7;

/// Parts of a step by which Newton's method may leave the root of the interpolant.
const NEARBY: f64 = 1.0 / 16.0;

/// Errors of the motion beside the end of a step are taken to be so many times as large as they are found to be.
const SAFETY: f64 = 4.0;

/// Steps that Newton's method may take.
const CORRECTIONS: u32 = 4;

/// Moves of a state to an event. (Secants double the digits, so that these are more than it takes: a run that goes on
/// from there takes its start for the event only within rounding.)
const MOVES: u32 = 12;

/// Roundings of time before an end of the step, or after it, at which a root counts as being at the end: steps that
/// end at a switch end at the events of its switching function.
pub(crate) const ROUNDINGS: f64 = 16.0;

/// Events in a step, as far as its ends show them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Outlook {
    /// There is none. The next step aims at one that ends the run: the time a little beyond it, ∞ if none is expected.
    Clear { aim: f64 },
    /// There is one alone, which ends the run.
    Crossing(Landing),
    /// There may be some.
    Unclear,
}

/// The way to an event that ends the run: steps from the start of the one that it lies in, of the part `x` of its
/// size, each of which comes nearer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Landing {
    pub event: usize,
    pub x: f64,
    /// The place at which it began, and dg/dx there.
    root: f64,
    slope: f64,
    /// The place before, and g there.
    last: Option<[f64; 2]>,
    tries: u32,
}

/// The root of g on the interpolant of an outline, and dg/dx there, by three steps of the secant from nearby.
pub(crate) fn refined<S: Real, E: Bound<S, N, K>, const N: usize, const K: usize>(
    events: &E,
    outline: &Outline<S, N>,
    event: usize,
    [mut x, mut slope]: [f64; 2],
) -> [f64; 2] {
    let g = |x: f64| events.value(event, &outline.between(x)).to_f64();
    let mut value = g(x);
    for _ in 0..2 {
        let next = x - value / slope;
        let of_next = g(next);
        // (Not of rounding.)
        if (next - x).abs() > MOVED {
            slope = (of_next - value) / (next - x);
        }
        (x, value) = (next, of_next);
    }
    [x - value / slope, slope]
}

/// The controller and the system, as a landing asks them.
pub trait Judge<S, const N: usize> {
    /// Returns whether the controller tolerates an error of a step, if it has a tolerance.
    fn tolerates(&self, error: &Tangent<S, N>) -> bool;
    /// The accelerations of the system at a state.
    fn accelerations(&self, at: &State<S, N>) -> SVector<S, N>;
}

impl<S, T, A, const N: usize> Judge<S, N> for (T, A)
where
    T: Fn(&Tangent<S, N>) -> bool,
    A: Fn(&State<S, N>) -> SVector<S, N>,
{
    fn tolerates(&self, error: &Tangent<S, N>) -> bool {
        self.0(error)
    }

    fn accelerations(&self, at: &State<S, N>) -> SVector<S, N> {
        self.1(at)
    }
}

/// Outcome of a step on the way to an event.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Progress<S, const N: usize> {
    /// Another step is needed.
    Again,
    /// The state at the event.
    Landed(State<S, N>),
    /// The steps do not come nearer.
    Lost,
}

impl Landing {
    /// The way to the root of an event near the place where the cubic through the ends of the step has one, with the
    /// slope dg/dx: to that of its quintic, unless it is near the end, from which it is better [known](Self::at_end).
    pub(crate) fn near<S: Real, E: Bound<S, N, K>, const N: usize, const K: usize>(
        events: &E,
        outline: &Outline<S, N>,
        event: usize,
        at: [f64; 2],
    ) -> Self {
        let is_near = 1.0 - at[0] <= NEARBY;
        let [x, slope] = if is_near { at } else { refined(events, outline, event, at) };
        Landing::new(event, x, slope)
    }

    /// The same way from the end of the step itself, to an event near it.
    pub(crate) fn at_end(self) -> Option<Self> {
        (1.0 - self.x <= NEARBY).then_some(Landing { x: 1.0, ..self })
    }

    /// The way to the root `x` of an interpolant, on which dg/dx there is `slope`.
    pub fn new(event: usize, x: f64, slope: f64) -> Self {
        Landing { event, x, root: x, slope, last: None, tries: 0 }
    }

    /// Goes on after a step of the part `x` that has led to `at`. `moved` gives the state so many parts of the step
    /// after it, which is as good as a step where it `suffices`.
    pub fn next<S: Real, const N: usize>(
        &mut self,
        at: &State<S, N>,
        resolution: f64,
        g: impl Fn(&State<S, N>) -> S,
        suffices: impl Fn(f64) -> bool,
        moved: impl Fn(f64) -> State<S, N>,
    ) -> Progress<S, N> {
        let value = g(at).to_f64();
        // (The slope of an outline is that of its cubic.)
        if let Some([before, of]) = self.last {
            self.slope = (value - of) / (self.x - before);
        }
        let rest = value / self.slope;
        if rest.abs() <= 0.5 * S::EPSILON {
            return Progress::Landed(*at);
        }
        if suffices(rest) {
            return self.moved(at, rest, resolution, g, moved);
        }
        self.last = Some([self.x, value]);
        self.x -= rest;
        self.tries += 1;
        let is_near = self.x > 0.0 && self.x <= 1.0 && (self.x - self.root).abs() <= NEARBY;
        if is_near && self.tries < CORRECTIONS { Progress::Again } else { Progress::Lost }
    }

    /// The same of a step that was `reached` from the start of one of size h, by the motion beside its end. From the
    /// end of the step [itself](Self::at_end) it leads as far as its accelerations are those of the system.
    pub(crate) fn step<S: Real, const N: usize>(
        &mut self,
        reached: &Outline<S, N>,
        (h, resolution): (S, f64),
        g: impl Fn(&State<S, N>) -> S,
        judge: &dyn Judge<S, N>,
    ) -> Progress<S, N> {
        let (beside, whole) = (Beside::new(reached), self.x == 1.0);
        let time = |parts: f64| h * S::from_f64(parts);
        let suffices = |rest: f64| whole || rest.abs() <= MOVED || judge.tolerates(&beside.third(time(rest)));
        let moved = |parts: f64| beside.at(time(parts));
        match self.next(&reached.ends[1], resolution, g, suffices, moved) {
            Progress::Landed(state) if whole => {
                let accelerations = judge.accelerations(&state);
                let error = beside.error(state.t - reached.ends[1].t, &accelerations);
                if judge.tolerates(&error) { Progress::Landed(state) } else { Progress::Lost }
            }
            progress => progress,
        }
    }

    /// Moves a state by what is left to where g vanishes, since it is a function of time, which is rounded.
    fn moved<S: Real, const N: usize>(
        &mut self,
        at: &State<S, N>,
        mut rest: f64,
        resolution: f64,
        g: impl Fn(&State<S, N>) -> S,
        moved: impl Fn(f64) -> State<S, N>,
    ) -> Progress<S, N> {
        let (start, mut state) = (self.x, *at);
        for _ in 0..MOVES {
            let next = self.x - rest;
            if !(next > 0.0 && next <= 1.0) {
                return Progress::Lost;
            }
            let other = moved(next - start);
            let left = g(&other).to_f64() / self.slope;
            // (What is not a number has not come nearer.)
            if left.abs() >= rest.abs() || left.is_nan() {
                break;
            }
            // By the secant, unless it is one of rounding.
            let secant = if left.abs() < 0.25 * rest.abs() { 1.0 - left / rest } else { 1.0 };
            self.slope *= secant;
            (self.x, state, rest) = (next, other, left / secant);
        }
        let landed = rest.abs() <= ROUNDINGS * resolution.max(S::EPSILON);
        if landed { Progress::Landed(state) } else { Progress::Lost }
    }
}

/// The motion beside the end of a step that was made towards an event: the quintic Hermite interpolant, by its
/// derivatives there. With s = dt/h from the end, v = h q̇ and a = h² q̈,
///
///   q = q₁ + v₁ s + ½ a₁ s² + c₃ s³ + c₄ s⁴ + c₅ s⁵,
///   c₃ = 10 P − 4 Q − ½ R,   c₄ = 15 P − 7 Q − R,   c₅ = 6 P − 3 Q − ½ R,
///   P = q₁ − q₀ − v₁ + ½ a₁,   Q = v₀ − v₁ + a₁,   R = a₀ − a₁.
pub(crate) struct Beside<'a, S, const N: usize> {
    reached: &'a Outline<S, N>,
    coefficients: [SVector<S, N>; 3],
}

impl<'a, S: Real, const N: usize> Beside<'a, S, N> {
    pub fn new(reached: &'a Outline<S, N>) -> Self {
        let (Outline { ends: [from, to], accelerations, h }, number) = (reached, S::from_f64);
        let part = |p: f64, q: f64, r: f64| {
            SVector::from_fn(|i, _| {
                let [a0, a1] = [0, 1].map(|end| accelerations[end][i] * *h * *h);
                let [v0, v1] = [from, to].map(|end| end.qd[i] * *h);
                let [one, two] = [to.q[i] - from.q[i] - v1 + a1 * number(0.5), v0 - v1 + a1];
                one * number(p) - two * number(q) - (a0 - a1) * number(r)
            })
        };
        let coefficients = [part(10.0, 4.0, 0.5), part(15.0, 7.0, 1.0), part(6.0, 3.0, 0.5)];
        Beside { reached, coefficients }
    }

    /// The part of third order in the motion over the time `dt`. It is known to some per cent, so that the state is as
    /// good as a step where this part is tolerated.
    pub fn third(&self, dt: S) -> Tangent<S, N> {
        let s = dt / self.reached.h;
        let square = s * s;
        Tangent {
            q: self.coefficients[0] * (square * s),
            qd: self.coefficients[0] * (S::from_f64(3.0) * square / self.reached.h),
        }
    }

    /// The error of the state at the time `dt` after the end, where the accelerations are these: the interpolant misses
    /// K s³, and its second derivative 6 K s. (For safety, four times as much.)
    pub fn error(&self, dt: S, accelerations: &SVector<S, N>) -> Tangent<S, N> {
        let ([third, fourth, fifth], number, s) = (&self.coefficients, S::from_f64, dt / self.reached.h);
        let rest = third * number(6.0) + (fourth * number(12.0) + fifth * (number(20.0) * s)) * s;
        let of_interpolant = self.reached.accelerations[1] + rest * (s / (self.reached.h * self.reached.h));
        let missed = (accelerations - of_interpolant) * (number(SAFETY) * dt);
        Tangent { q: missed * (dt / number(6.0)), qd: missed * number(0.5) }
    }

    /// The state at the time `dt` after the end.
    pub fn at(&self, dt: S) -> State<S, N> {
        let (at, acceleration) = (&self.reached.ends[1], &self.reached.accelerations[1]);
        let ([third, fourth, fifth], number, s) = (&self.coefficients, S::from_f64, dt / self.reached.h);
        let (half, square) = (number(0.5) * dt, s * s);
        State {
            t: at.t + dt,
            q: SVector::from_fn(|i, _| {
                let rest = third[i] + (fourth[i] + fifth[i] * s) * s;
                at.q[i] + (rest * (square * s) + (at.qd[i] + acceleration[i] * half) * dt)
            }),
            qd: SVector::from_fn(|i, _| {
                let rest =
                    third[i] * number(3.0) + (fourth[i] * number(4.0) + fifth[i] * (number(5.0) * s)) * s;
                at.qd[i] + (rest * (square / self.reached.h) + acceleration[i] * dt)
            }),
        }
    }
}
