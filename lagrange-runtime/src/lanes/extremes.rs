//! Extremes of functions of the state on the way of a trajectory.

use super::{Motion, Observer};
use crate::failure::Failure;
use crate::state::State;
use crate::system::System;
use core::fmt;

/// Least and greatest values of functions of the state on the way, within steps too: the greatest height, the speed
/// range. The observer `inner` has its output beside them, and where it ends the trajectory, as at a terminal event,
/// the way ends.
///
/// Functions are evaluated on the interpolant of each step, at as many places as events are; an extremum between them
/// is found by golden sections, to half the digits of its place. An excursion between two such places that neither of
/// them shows is missed. If the observer is in a pair with another, `inner` is the one that looks within steps.
///
/// ```
/// use lagrange_runtime::lanes::{Extremes, FinalState};
/// use lagrange_runtime::prelude::*;
/// # struct Falling;
/// # impl System<1> for Falling {
/// #     type Scalar = f64;
/// #     fn accel(&self, _: &SVector<f64, 1>, _: &SVector<f64, 1>, _: f64) -> SVector<f64, 1> {
/// #         [-9.81].into()
/// #     }
/// # }
/// let run = integrate(&Falling, Dop853, PiController::tolerance(1e-9), State::new(0.0, [0.0], [9.81])).until(3.0);
/// let end = FinalState(|_: &Falling, end: &State<f64, 1>| end.q[0]);
/// let (_, [height]) = run.observe(&Extremes::new(|_: &Falling, at: &State<f64, 1>| [at.q[0]], end))?;
/// assert!((height.greatest - 0.5 * 9.81).abs() < 1e-9 && (height.greatest_at - 1.0).abs() < 1e-6);
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[derive(Clone, Copy)]
pub struct Extremes<F, W> {
    functions: F,
    inner: W,
}

impl<F, W> Extremes<F, W> {
    /// The extremes of functions of the system and the state, beside an observer's output.
    pub fn new<Sys, const K: usize, const N: usize>(functions: F, inner: W) -> Self
    where
        Sys: System<N, Scalar = f64>,
        F: Fn(&Sys, &State<f64, N>) -> [f64; K],
        W: Observer<Sys, N>,
    {
        Extremes { functions, inner }
    }
}

impl<F, W: fmt::Debug> fmt::Debug for Extremes<F, W> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Extremes").field("inner", &self.inner).finish_non_exhaustive()
    }
}

/// Least and greatest value of a function on the way, and their times. A value that is not a number is passed over.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// The least value.
    pub least: f64,
    /// The time of the least value.
    pub least_at: f64,
    /// The greatest value.
    pub greatest: f64,
    /// The time of the greatest value.
    pub greatest_at: f64,
}

impl Range {
    const NONE: Range =
        Range { least: f64::NAN, least_at: f64::NAN, greatest: f64::NAN, greatest_at: f64::NAN };

    fn include(&mut self, t: f64, value: f64) {
        if value < self.least || self.least.is_nan() {
            (self.least, self.least_at) = (value, t);
        }
        if value > self.greatest || self.greatest.is_nan() {
            (self.greatest, self.greatest_at) = (value, t);
        }
    }
}

/// Fewest parts of a step.
const PARTS: u32 = 8;

/// Distance of a place from either end of the step, in parts of it.
const CLOSE: f64 = 1e-5;

/// Sections by which an extremum is enclosed: 1e-8 of two parts.
const SECTIONS: u32 = 38;

/// The place in an interval where a function has its greatest value, if it has one maximum there.
fn summit(mut a: f64, mut b: f64, f: impl Fn(f64) -> f64) -> (f64, f64) {
    const GOLDEN: f64 = 0.381966011250105;
    let inside = |a: f64, b: f64, part: f64| a + part * (b - a);
    let mut low = (inside(a, b, GOLDEN), 0.0);
    let mut high = (inside(a, b, 1.0 - GOLDEN), 0.0);
    (low.1, high.1) = (f(low.0), f(high.0));
    for _ in 0..SECTIONS {
        if low.1 > high.1 {
            (b, high) = (high.0, low);
            low.0 = inside(a, b, GOLDEN);
            low.1 = f(low.0);
        } else {
            (a, low) = (low.0, high);
            high.0 = inside(a, b, 1.0 - GOLDEN);
            high.1 = f(high.0);
        }
    }
    if low.1 > high.1 { low } else { high }
}

impl<Sys, F, W, const K: usize, const N: usize> Observer<Sys, N> for Extremes<F, W>
where
    Sys: System<N, Scalar = f64>,
    F: Fn(&Sys, &State<f64, N>) -> [f64; K],
    W: Observer<Sys, N>,
{
    type Accumulator = ([Range; K], W::Accumulator);
    type Output = (W::Output, [Range; K]);
    const STEPS: bool = W::STEPS;
    const WITHIN: bool = true;

    fn start(&self, system: &Sys, start: &State<f64, N>) -> Self::Accumulator {
        let mut ranges = [Range::NONE; K];
        let values = (self.functions)(system, start);
        ranges.iter_mut().zip(values).for_each(|(range, value)| range.include(start.t, value));
        (ranges, self.inner.start(system, start))
    }

    fn step(&self, memory: &mut Self::Accumulator, system: &Sys, from: &State<f64, N>, to: &State<f64, N>) {
        self.inner.step(&mut memory.1, system, from, to);
    }

    fn wanted(&self, memory: &Self::Accumulator) -> Option<f64> {
        self.inner.wanted(&memory.1)
    }

    fn sample(&self, memory: &mut Self::Accumulator, system: &Sys, at: &State<f64, N>) {
        self.inner.sample(&mut memory.1, system, at);
    }

    fn within(
        &self,
        (ranges, inner): &mut Self::Accumulator,
        system: &Sys,
        step: &dyn Motion<N>,
    ) -> Result<Option<State<f64, N>>, Failure> {
        let last = if W::WITHIN { self.inner.within(inner, system, step)? } else { None };
        let h = step.size();
        let end = last.map_or(1.0, |last| (last.t - step.ends()[0].t) / h);
        let count = step.parts().clamp(PARTS, 1 << 20);
        let place = |i: u32| end * f64::from(i) / f64::from(count);
        let at = |x: f64| match last {
            Some(last) if x == end => last,
            _ => step.at(x),
        };
        let value = |x: f64| (self.functions)(system, &at(x));
        let mut include = |x: f64, k: usize, value: f64| ranges[k].include(step.time(x), value);
        let look = |a: f64, b: f64, k: usize, sign: f64| {
            let (x, found) = summit(a, b, |x| sign * value(x)[k]);
            (x, k, sign * found)
        };
        // Three neighbours, of which the first two are the start and a place close to it: an extremum may be in the
        // first part, or in the last.
        let close = CLOSE * end / f64::from(count);
        let inner = (1..count).map(place);
        let places = [0.0, close].into_iter().chain(inner).chain([end - close, end]);
        let mut seen: [(f64, [f64; K]); 3] = [(0.0, value(0.0)); 3];
        for (i, x) in places.enumerate().skip(1) {
            (seen[0], seen[1], seen[2]) = (seen[1], seen[2], (x, value(x)));
            for k in 0..K {
                include(x, k, seen[2].1[k]);
                let [before, here, after] = seen.map(|(_, values)| values[k]);
                for sign in [-1.0, 1.0] {
                    if i > 1 && sign * here >= sign * before && sign * here > sign * after {
                        let (x, k, found) = look(seen[0].0, seen[2].0, k, sign);
                        include(x, k, found);
                    }
                }
            }
        }
        Ok(last)
    }

    fn finish(&self, (ranges, inner): Self::Accumulator, system: &Sys, end: &State<f64, N>) -> Self::Output {
        (self.inner.finish(inner, system, end), ranges)
    }
}
