//! The ends of a step, which say of most steps that no event is in them, without an interpolant.

use super::definition::Bound;
use super::within::Within;
use crate::scalar::{Functions, Real};
use crate::state::{State, add_scaled};
use nalgebra::SVector;

/// Places between the ends of a step at which g is compared with the cubic through its ends. They are no fractions of
/// small denominator, of which waves of whole periods would have the same values.
const PLACES: [f64; 2] = [0.38, 0.73];

/// Distance from an end of the step, as a fraction of it, from which the rate of g there is taken.
const CLOSE: f64 = 1.0 / 1024.0;

/// Weights, at a place θ of a step, of the increment of q, h q̇ at both ends and h² q̈ at both ends in the quintic
/// Hermite interpolant.
const fn weights(x: f64) -> [f64; 5] {
    let (x2, x3) = (x * x, x * x * x);
    let (x4, x5) = (x2 * x2, x2 * x3);
    [
        10.0 * x3 - 15.0 * x4 + 6.0 * x5,
        x - 6.0 * x3 + 8.0 * x4 - 3.0 * x5,
        -4.0 * x3 + 7.0 * x4 - 3.0 * x5,
        0.5 * x2 - 1.5 * x3 + 1.5 * x4 - 0.5 * x5,
        0.5 * x3 - x4 + 0.5 * x5,
    ]
}

/// Their derivatives by θ.
const fn slopes(x: f64) -> [f64; 5] {
    let (x2, x3, x4) = (x * x, x * x * x, x * x * x * x);
    [
        30.0 * x2 - 60.0 * x3 + 30.0 * x4,
        1.0 - 18.0 * x2 + 32.0 * x3 - 15.0 * x4,
        -12.0 * x2 + 28.0 * x3 - 15.0 * x4,
        x - 4.5 * x2 + 6.0 * x3 - 2.5 * x4,
        1.5 * x2 - 4.0 * x3 + 2.5 * x4,
    ]
}

const WEIGHTS: [[f64; 5]; 2] = [weights(PLACES[0]), weights(PLACES[1])];
const SLOPES: [[f64; 5]; 2] = [slopes(PLACES[0]), slopes(PLACES[1])];

/// States and accelerations at both ends of a step of size h.
#[derive(Clone, Copy, Debug)]
pub struct Outline<S, const N: usize> {
    pub ends: [State<S, N>; 2],
    pub accelerations: [SVector<S, N>; 2],
    pub h: S,
}

impl<S: Real, const N: usize> Outline<S, N> {
    /// The state of the quintic Hermite interpolant at a place of which the weights are known.
    #[inline(always)]
    fn weighted(&self, x: f64, value: [f64; 5], slope: [f64; 5]) -> State<S, N> {
        let ([from, to], [a, b], h) = (&self.ends, &self.accelerations, self.h);
        let increment = to.q - from.q;
        let sum = |[_, v0, v1, a0, a1]: [f64; 5]| {
            let velocities = from.qd * S::from_f64(v0) + to.qd * S::from_f64(v1);
            velocities + (a * S::from_f64(a0) + b * S::from_f64(a1)) * h
        };
        State {
            t: from.t + h * S::from_f64(x),
            q: from.q + increment * S::from_f64(value[0]) + sum(value) * h,
            qd: increment * (S::from_f64(slope[0]) / h) + sum(slope),
        }
    }

    /// The state at one of [`PLACES`].
    #[inline(always)]
    fn between(&self, place: usize) -> State<S, N> {
        self.weighted(PLACES[place], WEIGHTS[place], SLOPES[place])
    }

    /// g at one of its ends is `here`: dg/dx there, x from 0 to 1 over the step.
    #[inline(always)]
    fn rate(&self, end: usize, here: f64, g: impl Fn(&State<S, N>) -> f64) -> f64 {
        // Into the step.
        let inward = if end == 0 { CLOSE } else { -CLOSE };
        let (at, dt) = (&self.ends[end], self.h * S::from_f64(inward));
        let moved = State {
            t: at.t + dt,
            q: add_scaled(&at.q, dt, &at.qd),
            qd: add_scaled(&at.qd, dt, &self.accelerations[end]),
        };
        (g(&moved) - here) / inward
    }

    /// An event as seen from the ends of the step, where g is `start` at its beginning.
    #[inline(always)]
    pub(crate) fn seen<E: Bound<S, N, K>, const K: usize>(
        &self,
        events: &E,
        event: usize,
        start: f64,
    ) -> Seen<impl Fn() -> [f64; 2]> {
        let g = move |at: &State<S, N>| events.value(event, at).to_f64();
        let end = g(&self.ends[1]);
        let h = self.h.to_f64();
        let [from, to] = [0, 1].map(|i| events.rates(event, &self.ends[i], &self.accelerations[i]));
        let rate = |i: usize, known: Option<S>, here: f64| match known {
            Some(rate) => h * rate.to_f64(),
            None => self.rate(i, here, g),
        };
        Seen {
            ends: [start, end],
            rates: [rate(0, from[0], start), rate(1, to[0], end)],
            bends: from[1].zip(to[1]).map(|(from, to)| [from, to].map(|bend| h * h * bend.to_f64())),
            between: move || [g(&self.between(0)), g(&self.between(1))],
        }
    }
}

/// The quintic Hermite interpolant.
impl<S: Real, const N: usize> Within<S, N> for Outline<S, N> {
    fn parts(&self) -> u32 {
        1
    }

    fn ends(&self) -> [State<S, N>; 2] {
        self.ends
    }

    fn size(&self) -> S {
        self.h
    }

    fn between(&self, x: f64) -> State<S, N> {
        self.weighted(x, weights(x), slopes(x))
    }
}

/// g at the ends of a step, its rates dg/dx there, d²g/dx² where the compiler knows it, and g at [`PLACES`].
pub(crate) struct Seen<F> {
    pub ends: [f64; 2],
    pub rates: [f64; 2],
    pub bends: Option<[f64; 2]>,
    between: F,
}

/// The deviation of g from its cubic is taken to be so many times as large as it is at [`PLACES`].
const MARGIN: f64 = 8.0;

/// The part of the change of g over the step that the cubic through its ends is taken to miss at least.
const MISSED: f64 = 1.0 / 16.0;

/// The part of the change of g over a step by which g is farther from zero at its end: the next one may be longer,
/// and is looked at beyond its start from there.
const AHEAD: f64 = 1.0 / 64.0;

/// The slope with which g is taken to graze zero, in changes of g over a step.
const GRAZES: f64 = -1.0 / 16.0;

/// Places of the cubic through the ends of a step that Newton's method takes to its root, which it has alone.
const TO_ROOT: usize = 3;

impl<F: Fn() -> [f64; 2]> Seen<F> {
    /// Bernstein coefficients of the cubic C through g and its rates at both ends, times `sign`.
    #[inline(always)]
    fn cubic(&self, sign: f64) -> [f64; 4] {
        let ([b0, b3], [from, to]) = (self.ends.map(|g| sign * g), self.rates.map(|rate| sign * rate));
        [b0, b0 + from / 3.0, b3 - to / 3.0, b3]
    }

    /// The largest change that g has over the step by its ends.
    #[inline(always)]
    fn change(&self) -> f64 {
        let [from, to] = self.rates.map(f64::abs);
        from.max(to).max((self.ends[1] - self.ends[0]).abs())
    }

    /// Returns whether `clear` holds for the deviations D of g from the cubic that are known, so that
    /// `|g − C| ≤ 16 D x² (1 − x)²`: those at [`PLACES`], and of a compiled g what its second derivatives at both ends
    /// show, where `(g − C) / x² (1 − x)²` tends to half the difference of the second derivatives.
    #[inline(always)]
    fn deviates(&self, sign: f64, [b0, b1, b2, b3]: [f64; 4], clear: impl Fn(f64) -> bool) -> bool {
        if let Some(bends) = self.bends {
            let cubic = [6.0 * (b0 - 2.0 * b1 + b2), 6.0 * (b1 - 2.0 * b2 + b3)];
            if !(0..2).all(|i| clear((sign * bends[i] - cubic[i]).abs() / 32.0)) {
                return false;
            }
        }
        let found = (self.between)();
        (0..2).all(|i| {
            let (x, y) = (PLACES[i], 1.0 - PLACES[i]);
            let cubic = b0 * (y * y * y) + 3.0 * x * y * (b1 * y + b2 * x) + b3 * (x * x * x);
            clear((sign * found[i] - cubic).abs() / (16.0 * x * x * y * y))
        })
    }

    /// Returns whether g has the given sign throughout the step, with |g| > `least` at its end and |g| > `touching`
    /// everywhere.
    ///
    /// g has no zero where `b₀ ≥ 0`, `b₃ > 0` and `b₁, b₂ > 4/3 D`, since `C ≥ 3 x (1 − x) min(b₁, b₂)`. D is taken to
    /// be eight times the deviations that are known; a sixteenth of the change of g over the step is added.
    #[inline(always)]
    pub fn keeps_sign(&self, sign: f64, least: f64, touching: f64) -> bool {
        let (cubic, change) = (self.cubic(sign), self.change());
        let [b0, b1, b2, b3] = cubic;
        let spare = b1.min(b2) - MISSED * change - touching;
        // (Written so that a value which is not a number is not clear.)
        b0 >= touching
            && b3 > least.max(touching).max(AHEAD * change)
            && spare > 0.0
            && self.deviates(sign, cubic, |deviation| 4.0 / 3.0 * MARGIN * deviation < spare)
    }

    /// The place of the next zero of g, at most `horizon` steps after this one, and its slope there, by the parabola
    /// through g, its rate and its second derivative at the end, where g approaches zero from the given sign and does
    /// not only graze it.
    #[inline(always)]
    pub fn approaches(&self, sign: f64, horizon: f64) -> Option<[f64; 2]> {
        let [_, b1, b2, b3] = self.cubic(sign);
        let rate = sign * self.rates[1];
        let bend = self.bends.map_or(6.0 * (b1 - 2.0 * b2 + b3), |[_, bend]| sign * bend);
        // (Most steps lead to none: without a root.)
        if !(rate < 0.0 && b3 + (rate + 0.5 * bend.min(0.0) * horizon) * horizon < 0.0) {
            return None;
        }
        let slope = -Functions::sqrt(rate * rate - 2.0 * b3 * bend);
        let u = -2.0 * b3 / (rate + slope);
        (u <= horizon && slope < GRAZES * self.change()).then_some([1.0 + u, sign * slope])
    }

    /// The root of the cubic and its slope there, if g goes from the given sign to the other one and nowhere back, with
    /// |g| > `least` at both ends. At the start it is farther, as [`keeps_sign`](Self::keeps_sign) has left it; the run
    /// ends before the other end, of which nothing is to be said.
    ///
    /// That is so where `b₀ > b₁ > b₂ > b₃`, each by more than 16/15 D: `C' ≤ −3 min(bᵢ − bᵢ₊₁)`, and the derivative of
    /// `16 x² (1 − x)²` is no larger than 3.08. D is taken as in [`keeps_sign`](Self::keeps_sign).
    #[inline(always)]
    pub fn crosses(&self, sign: f64, least: f64) -> Option<[f64; 2]> {
        let (cubic, change) = (self.cubic(sign), self.change());
        let [b0, b1, b2, b3] = cubic;
        let falls = [b0 - b1, b1 - b2, b2 - b3];
        let spare = falls[0].min(falls[1]).min(falls[2]) - MISSED * change;
        let crosses = b0 > least.max(AHEAD * change)
            && b3 < -least
            && spare > 0.0
            && self.deviates(sign, cubic, |deviation| 16.0 / 15.0 * MARGIN * deviation < spare);
        crosses.then(|| {
            let (mut x, mut fall) = (b0 / (b0 - b3), 0.0);
            for _ in 0..TO_ROOT {
                let y = 1.0 - x;
                let value = b0 * (y * y * y) + 3.0 * x * y * (b1 * y + b2 * x) + b3 * (x * x * x);
                fall = 3.0 * (falls[0] * y * y + 2.0 * falls[1] * x * y + falls[2] * x * x);
                x = (x + value / fall).clamp(0.0, 1.0);
            }
            [x, -sign * fall]
        })
    }
}
