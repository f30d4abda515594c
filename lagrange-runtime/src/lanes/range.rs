//! The range of coordinates in which a model holds, watched on the way.

use super::{Motion, Observer};
use crate::event::definition::Bound;
use crate::event::landing::{Judge, Landing, Outlook, Progress};
use crate::event::outline::Outline;
use crate::event::search::Search;
use crate::event::{Direction, EventKind};
use crate::failure::{Coordinate, Failure};
use crate::state::State;
use crate::system::Lagrangian;
use core::fmt;
use core::ops::RangeInclusive;
use nalgebra::SVector;

/// Range of each coordinate in which a model holds. A trajectory that leaves it fails by [`Failure::OutsideModel`],
/// which names the coordinate and the bound that it passed, within a step too; the observer `inner` has its output
/// otherwise. Where `inner` ends the trajectory first, as at a terminal event, nothing is left.
///
/// The bounds are found as terminal [events](crate::event) are, and may be missed where these may; whether a step ends
/// beyond a bound is always seen. A trajectory whose end is its start is not checked.
///
/// ```
/// use lagrange_runtime::lanes::{FinalState, InRange};
/// use lagrange_runtime::prelude::*;
/// lagrangian! {
///     /// A pendulum, for small angles.
///     pub system Small {
///         coord theta;
///         T = 0.5 * dot(theta).powi(2);
///         V = 0.5 * theta.powi(2);
///     }
/// }
/// let angle = FinalState(|_: &Small, end: &State<f64, 1>| end.q[0]);
/// let small = InRange::new([-0.3..=0.3], angle);
/// let run = |speed| {
///     let start = State::new(0.0, [0.0], [speed]);
///     integrate(&Small::new(), Dop853, PiController::tolerance(1e-9), start).until(10.0).observe(&small)
/// };
/// assert!(run(0.29).is_ok());
/// let failure = run(0.31).unwrap_err().failure;
/// // 0.31 sin t = 0.3.
/// assert!(matches!(failure, Failure::OutsideModel { t, bound: 0.3, coordinate } if coordinate.name == "theta" && (t - (0.3f64 / 0.31).asin()).abs() < 1e-6));
/// ```
#[derive(Clone)]
pub struct InRange<W, const N: usize> {
    ranges: [RangeInclusive<f64>; N],
    inner: W,
}

impl<W, const N: usize> InRange<W, N> {
    /// A coordinate that is not watched: all numbers.
    pub const ANY: RangeInclusive<f64> = f64::NEG_INFINITY..=f64::INFINITY;

    /// The range of each coordinate, in its unit and the order of q, beside an observer.
    pub fn new(ranges: [RangeInclusive<f64>; N], inner: W) -> Self {
        InRange { ranges, inner }
    }

    /// The first coordinate that is outside its range, and the bound that it has passed. One that is not a number is
    /// inside: runs fail by themselves.
    fn outside(&self, at: &State<f64, N>) -> Option<(usize, f64)> {
        self.ranges.iter().enumerate().find_map(|(i, range)| {
            let x = at.q[i];
            // (Of an empty range every place is outside.)
            let below = x < *range.start() || range.is_empty();
            (below || x > *range.end()).then(|| (i, if below { *range.start() } else { *range.end() }))
        })
    }
}

impl<W: fmt::Debug, const N: usize> fmt::Debug for InRange<W, N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("InRange").field("ranges", &self.ranges).field("inner", &self.inner).finish()
    }
}

/// Distances inside, one event for each coordinate: (x − low) (high − x), without a bound that is infinite.
impl<W, const N: usize> Bound<f64, N, N> for InRange<W, N> {
    #[inline(always)]
    fn value(&self, event: usize, at: &State<f64, N>) -> f64 {
        let (range, x) = (&self.ranges[event], at.q[event]);
        match (range.start().is_finite(), range.end().is_finite()) {
            (true, true) => (x - range.start()) * (range.end() - x),
            (true, false) => x - range.start(),
            (false, true) => range.end() - x,
            (false, false) => 1.0,
        }
    }

    #[inline(always)]
    fn rates(&self, event: usize, at: &State<f64, N>, accelerations: &SVector<f64, N>) -> [Option<f64>; 2] {
        let (range, x, v, a) = (&self.ranges[event], at.q[event], at.qd[event], accelerations[event]);
        let [first, second] = match (range.start().is_finite(), range.end().is_finite()) {
            (true, true) => {
                let slope = range.start() + range.end() - 2.0 * x;
                [slope * v, slope * a - 2.0 * v * v]
            }
            (true, false) => [v, a],
            (false, true) => [-v, -a],
            (false, false) => [0.0, 0.0],
        };
        [Some(first), Some(second)]
    }

    #[inline(always)]
    fn kind(&self, _: usize) -> EventKind {
        EventKind { name: "range", direction: Direction::Falling, terminal: true, touching: 0.0 }
    }
}

/// Accumulator of an [`InRange`] of a trajectory.
#[derive(Clone, Debug)]
pub struct Inside<A, const N: usize> {
    search: Search<N>,
    inner: A,
}

impl<Sys, W, const N: usize> Observer<Sys, N> for InRange<W, N>
where
    Sys: Lagrangian<N, Scalar = f64>,
    W: Observer<Sys, N>,
{
    type Accumulator = Inside<W::Accumulator, N>;
    type Output = W::Output;
    const STEPS: bool = W::STEPS;
    const WITHIN: bool = true;

    fn start(&self, system: &Sys, start: &State<f64, N>) -> Self::Accumulator {
        Inside { search: Search::NEW, inner: self.inner.start(system, start) }
    }

    fn step(&self, memory: &mut Self::Accumulator, system: &Sys, from: &State<f64, N>, to: &State<f64, N>) {
        self.inner.step(&mut memory.inner, system, from, to);
    }

    fn wanted(&self, memory: &Self::Accumulator) -> Option<f64> {
        self.inner.wanted(&memory.inner)
    }

    fn sample(&self, memory: &mut Self::Accumulator, system: &Sys, at: &State<f64, N>) {
        self.inner.sample(&mut memory.inner, system, at);
    }

    fn within(
        &self,
        Inside { search, inner }: &mut Self::Accumulator,
        system: &Sys,
        step: &dyn Motion<N>,
    ) -> Result<Option<State<f64, N>>, Failure> {
        let outside = |t: f64, (i, bound): (usize, f64)| {
            Err(Failure::OutsideModel { t, coordinate: Coordinate::of::<Sys, N>(i), bound })
        };
        let [from, to] = step.ends();
        if let Some(place) = self.outside(&from) {
            return outside(from.t, place);
        }
        let last = if W::WITHIN { self.inner.within(inner, system, step)? } else { None };
        search.begin(self, &from)?;
        search.enter(self, step)?;
        // The first event of a step ends it, so that the next ones are not looked for.
        if let Some((i, x, _)) = search.next(self, step)? {
            let (t, at) = (step.time(x), step.at(x).q[i]);
            let is_before = |last: State<f64, N>| (t - last.t) * step.size() < 0.0;
            if last.is_none_or(is_before) {
                let range = &self.ranges[i];
                let nearer = if (at - range.start()).abs() < (range.end() - at).abs() {
                    range.start()
                } else {
                    range.end()
                };
                return outside(t, (i, *nearer));
            }
        }
        match self.outside(&last.unwrap_or(to)) {
            Some(place) if last.is_none() => outside(to.t, place),
            _ => Ok(last),
        }
    }

    #[inline(always)]
    fn outlook(
        &self,
        Inside { search, inner }: &mut Self::Accumulator,
        system: &Sys,
        step: &Outline<f64, N>,
        next: f64,
    ) -> Outlook {
        // Both are asked, whatever the other one says: a search has to know of each step.
        let inner = match W::WITHIN {
            true => self.inner.outlook(inner, system, step, next),
            false => Outlook::Clear { aim: f64::INFINITY },
        };
        let range = search.begin(self, &step.ends[0]).is_ok()
            && matches!(search.outlook(self, step, next), Outlook::Clear { .. });
        let is_inside = range && step.ends.iter().all(|end| self.outside(end).is_none());
        if is_inside { inner } else { Outlook::Unclear }
    }

    fn approach(
        &self,
        memory: &mut Self::Accumulator,
        system: &Sys,
        step: &Outline<f64, N>,
        landing: &mut Landing,
        reached: &Outline<f64, N>,
        judge: &dyn Judge<f64, N>,
    ) -> Progress<f64, N> {
        self.inner.approach(&mut memory.inner, system, step, landing, reached, judge)
    }

    fn finish(
        &self,
        Inside { inner, .. }: Self::Accumulator,
        system: &Sys,
        end: &State<f64, N>,
    ) -> W::Output {
        self.inner.finish(inner, system, end)
    }
}
