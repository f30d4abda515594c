//! The events of one step after the other: where each is found next, and which of them comes first.

use super::Direction;
use super::definition::Bound;
use super::landing::{Landing, Outlook, ROUNDINGS, refined};
use super::outline::Outline;
use super::scan::{Found, Grid, Scan};
use super::sides::Side;
use super::within::Within;
use crate::failure::Failure;
use crate::scalar::Real;
use crate::state::{State, add_scaled};

/// Rounding errors of times, coordinates and velocities, in units of the last place.
const ULPS: f64 = 4.0;

/// Parts of the longest step in which events are looked for.
pub(crate) const MOST_PARTS: u32 = 1 << 24;

/// Length of the step that may have led to the start of a run, in units of its first one, which is a cautious guess.
const LAST_STEP: f64 = 16.0;

/// Steps that may be aimed at an event and not meet it: g may tend to zero and never come there.
const AIMS: u8 = 3;

/// Parts of a step by which one that is aimed at an event leads beyond it.
const BEYOND: f64 = 1.0 / 256.0;

/// Parts of a step after which the next event is far enough to be aimed at.
const FAR: f64 = 1.0 / 1024.0;

/// The time after a step to a little beyond the zero of g that is expected `ahead` of it, by the quintic Hermite
/// interpolant; ∞ if that does not lead there. Its error grows as `(x (x − 1))³` with the place.
fn beyond<S: Real, E: Bound<S, N, K>, const N: usize, const K: usize>(
    events: &E,
    outline: &Outline<S, N>,
    event: usize,
    ahead: [f64; 2],
) -> f64 {
    let [x, _] = refined(events, outline, event, ahead);
    let (u, reach) = (x - 1.0, x * (x - 1.0));
    let beyond = u * (1.0 + BEYOND) + BEYOND * reach * reach * reach;
    if u > FAR && u < 2.0 * ahead[0] { beyond * outline.h.to_f64().abs() } else { f64::INFINITY }
}

/// The change of g within the rounding of a state: to the neighbours along the motion, and of its time and of each
/// coordinate and velocity alone. Of the two neighbours on each axis, the sums of the smaller and of the larger
/// changes, which differ where g jumps.
fn rounding<S: Real, const N: usize>(
    at: &State<S, N>,
    along: [State<S, N>; 2],
    g: impl Fn(&State<S, N>) -> f64,
) -> [f64; 2] {
    let here = g(at);
    let mut sums = [0.0; 2];
    let change = |at: &State<S, N>| (g(at) - here).abs();
    let mut add = |a: f64, b: f64| {
        sums[0] += a.min(b);
        sums[1] += a.max(b);
    };
    add(change(&along[0]), change(&along[1]));
    let scaled = |i: usize, sign: f64| {
        let (mut at, factor) = (*at, S::from_f64(1.0 + sign * ULPS * S::EPSILON));
        let component = match i {
            i if i < N => &mut at.q[i],
            i if i < 2 * N => &mut at.qd[i - N],
            // (A floor that moves goes on in steps of the clock, and the body does not.)
            _ => &mut at.t,
        };
        *component *= factor;
        change(&at)
    };
    for i in 0..=2 * N {
        add(scaled(i, -1.0), scaled(i, 1.0));
    }
    sums
}

/// `dg/dx` at the start of a step, and how far rounding may change it: by differences along the line on which positions
/// go on with the velocities there, and velocities with the accelerations. (In the time of a short flight, g may change
/// by less than its rounding.)
fn rate_at_start<S: Real, const N: usize>(
    step: &(impl Within<S, N> + ?Sized),
    g: impl Fn(&State<S, N>) -> f64,
) -> [f64; 2] {
    const D: f64 = 1.0 / 1024.0;
    let from = step.at(0.0);
    let change = step.at(D).qd - from.qd;
    let on_line = |parts: f64| State {
        t: step.time(parts * D),
        q: add_scaled(&from.q, S::from_f64(parts * D) * step.size(), &from.qd),
        qd: add_scaled(&from.qd, S::from_f64(parts), &change),
    };
    let [near, far] = [1.0, 2.0].map(|parts| g(&on_line(parts)) - g(&on_line(-parts)));
    let errors = [-2.0, 0.0, 2.0].map(|parts| rounding(&on_line(parts), [on_line(parts); 2], &g)[1]);
    [(8.0 * near - far) / (12.0 * D), errors.iter().sum::<f64>() / D]
}

/// Progress of the search for `K` events.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Search<const K: usize> {
    scans: [Scan; K],
    /// No step has been looked at since the start or the last restart.
    first: bool,
    /// The aim of the step after the last one, and the steps that have aimed and met nothing.
    aim: f64,
    missed: u8,
}

impl<const K: usize> Search<K> {
    pub const NEW: Search<K> = Search { scans: [Scan::NEW; K], first: true, aim: f64::INFINITY, missed: 0 };

    /// The run goes on from another state than the one reached.
    pub fn restart(&mut self) {
        (self.first, self.aim, self.missed) = (true, f64::INFINITY, 0);
        self.scans.iter_mut().for_each(Scan::restart);
    }

    /// The motion was left, with events on these sides as far as they are known.
    pub fn comes_from(&mut self, sides: [Option<Side>; K]) {
        for (scan, side) in self.scans.iter_mut().zip(sides) {
            side.into_iter().for_each(|side| scan.comes_from(side));
        }
    }

    /// The sides of the events where all of a step was looked at.
    pub fn sides(&self) -> [Side; K] {
        self.scans.each_ref().map(Scan::side_at_end)
    }

    /// The sides of the events at the one that ended the run.
    pub fn sides_landed(&self) -> [Side; K] {
        self.scans.each_ref().map(Scan::side_landed)
    }

    /// Prepares for a step that begins in `start`.
    pub fn begin<S: Real, E: Bound<S, N, K>, const N: usize>(
        &mut self,
        events: &E,
        start: &State<S, N>,
    ) -> Result<(), Failure<S>> {
        if self.first {
            for event in 0..K {
                let g = events.value(event, start).to_f64();
                if !g.is_finite() {
                    return Err(Failure::EventNotFinite { t: start.t, event: events.kind(event).at(event) });
                }
                self.scans[event].begin(g);
            }
        }
        Ok(())
    }

    /// The events in a step, as far as its ends show them, under the
    /// [assumptions](crate::event#what-is-found-and-what-can-be-missed) made there. If there is none, the search is at
    /// its end then. If there is one alone, it is [`landed`](Self::landed) at, or [`enter`](Self::enter) follows, as it
    /// does otherwise. The step after it is to have the size `next`, unless it aims at an event.
    #[inline(always)]
    pub fn outlook<S: Real, E: Bound<S, N, K>, const N: usize>(
        &mut self,
        events: &E,
        outline: &Outline<S, N>,
        next: S,
    ) -> Outlook {
        let (mut crossing, mut unclear, mut aim) = (None, false, f64::INFINITY);
        self.missed += u8::from(outline.h.to_f64().abs() >= self.aim);
        let horizon = if self.missed < AIMS { (next / outline.h).to_f64() } else { 0.0 };
        for (event, scan) in self.scans.iter_mut().enumerate() {
            let seen = outline.seen(events, event, scan.g);
            if !scan.passes(&events.kind(event), &seen) {
                unclear |= self.first || crossing.is_some();
                crossing = scan.crosses(&events.kind(event), &seen).map(|x| (event, x));
                unclear |= crossing.is_none();
            } else if let Some(ahead) = scan.approaches(&events.kind(event), &seen, horizon) {
                aim = aim.min(beyond(events, outline, event, ahead));
            }
        }
        self.aim = if unclear || crossing.is_some() { f64::INFINITY } else { aim };
        match crossing {
            _ if unclear => Outlook::Unclear,
            Some((event, at)) => Outlook::Crossing(Landing::near(events, outline, event, at)),
            None => {
                self.first = false;
                Outlook::Clear { aim }
            }
        }
    }

    /// The direction of an event that a step has alone.
    pub fn direction(&self, event: usize) -> Direction {
        self.scans[event].leaves()
    }

    /// The event that a step has alone was met at `x`, in `state`.
    pub fn landed<S: Real, E: Bound<S, N, K>, const N: usize>(
        &mut self,
        events: &E,
        step: &(impl Within<S, N> + ?Sized),
        (event, x): (usize, f64),
        state: &State<S, N>,
    ) {
        self.scans[event].find(x);
        self.first = false;
        self.met(events, step, event, x, state);
    }

    /// Begins to look at a step, at those events of which its ends have not shown that they are not in it.
    ///
    /// # Errors
    /// [`Failure::EventsUnresolved`] of a step in more parts than can be looked at, [`Failure::EventsAccumulate`] of a
    /// flight from a terminal event that is too short.
    pub fn enter<S: Real, E: Bound<S, N, K>, const N: usize>(
        &mut self,
        events: &E,
        step: &(impl Within<S, N> + ?Sized),
    ) -> Result<(), Failure<S>> {
        if step.parts() > MOST_PARTS {
            return Err(Failure::EventsUnresolved { t: step.ends()[0].t, h: step.size() });
        }
        let grid = Grid::new(step.parts(), self.first, S::EPSILON);
        let first = core::mem::take(&mut self.first);
        // The state was rounded in a step, whose size is the scale of times where the clock has been set back.
        let x = ULPS * step.resolution().max(LAST_STEP * S::EPSILON);
        for event in 0..K {
            if core::mem::take(&mut self.scans[event].passed) {
                continue;
            }
            if first {
                let g = |at: &State<S, N>| events.value(event, at).to_f64();
                self.scans[event].begin_within(rounding(&step.at(0.0), [step.at(-x), step.at(x)], g));
            }
            let on_root = first && self.scans[event].starts_on_root();
            let resolution = step.resolution().max(S::EPSILON);
            self.scans[event].enter(if on_root { grid.down_to(ROUNDINGS * resolution) } else { grid });
            self.look_ahead(events, step, event);
            let rate = || rate_at_start(step, |at| events.value(event, at).to_f64());
            if on_root && self.scans[event].misses_flight(&events.kind(event), resolution, rate) {
                let event = events.kind(event).at(event);
                return Err(Failure::EventsAccumulate { t: step.ends()[0].t, event });
            }
        }
        Ok(())
    }

    /// Finds the next root of an event in the step.
    fn look_ahead<S: Real, E: Bound<S, N, K>, const N: usize>(
        &mut self,
        events: &E,
        step: &(impl Within<S, N> + ?Sized),
        event: usize,
    ) {
        let (kind, at) = (events.kind(event), |at: &State<S, N>| events.value(event, at).to_f64());
        loop {
            self.scans[event].look_ahead(&kind, step.resolution(), |x| at(&step.at(x)));
            let Some((x, least)) = self.scans[event].touches() else { return };
            let here = step.at(x);
            // (The largest |g| of the motion, by which it was found, may be more than 1e15 times that nearby.)
            let rounded = || ULPS * rounding(&here, [here; 2], at)[1];
            let g = at(&here).abs();
            if g <= kind.touching.max(least) || g <= rounded() {
                return;
            }
        }
    }

    /// The event of the lowest index among those found up to `x`, but for rounding.
    fn earliest(&self, x: f64, resolution: f64) -> Option<(usize, Found)> {
        let limit = x + ULPS * resolution;
        let found = |event: usize| self.scans[event].found.filter(|found| found.place() <= limit);
        (0..K).find_map(|event| Some((event, found(event)?)))
    }

    /// The next event in the step: its index, place, and how g passes through zero there.
    pub fn next<S: Real, E: Bound<S, N, K>, const N: usize>(
        &self,
        events: &E,
        step: &(impl Within<S, N> + ?Sized),
    ) -> Result<Option<(usize, f64, Direction)>, Failure<S>> {
        let places = self.scans.iter().filter_map(|scan| scan.found.map(|found| found.place()));
        match self.earliest(places.fold(f64::INFINITY, f64::min), step.resolution()) {
            None => Ok(None),
            Some((event, Found::Root { x, direction })) => Ok(Some((event, x, direction))),
            Some((event, Found::NotFinite { x })) => {
                Err(Failure::EventNotFinite { t: step.time(x), event: events.kind(event).at(event) })
            }
        }
    }

    /// The search of a motion that is left where the next event was met, at `x` in `state`: its sides are those
    /// [landed](Self::sides_landed).
    pub fn left_at<S: Real, E: Bound<S, N, K>, const N: usize>(
        mut self,
        events: &E,
        step: &(impl Within<S, N> + ?Sized),
        (event, x): (usize, f64),
        state: &State<S, N>,
    ) -> Self {
        self.ended_at(events, step, event, x, state, true);
        self
    }

    /// The event that is next was met at `x`, in `state`. One that ends the run is not looked for in the rest of the
    /// step.
    pub fn met<S: Real, E: Bound<S, N, K>, const N: usize>(
        &mut self,
        events: &E,
        step: &(impl Within<S, N> + ?Sized),
        event: usize,
        x: f64,
        state: &State<S, N>,
    ) {
        let terminal = events.kind(event).terminal;
        self.ended_at(events, step, event, x, state, terminal);
        if !terminal {
            self.look_ahead(events, step, event);
        }
    }

    fn ended_at<S: Real, E: Bound<S, N, K>, const N: usize>(
        &mut self,
        events: &E,
        step: &(impl Within<S, N> + ?Sized),
        event: usize,
        x: f64,
        state: &State<S, N>,
        ends: bool,
    ) {
        // A restart from here shall not meet the same event again: the rest of g is rounding, unless g jumps.
        let rounded = ULPS * step.resolution();
        let moved = |by: f64| {
            let t = step.size().mul_add(S::from_f64(by), state.t);
            state.moved(t, S::one(), &step.at(x + by).minus(&step.at(x)))
        };
        for (other, scan) in self.scans.iter_mut().enumerate() {
            let g = |at: &State<S, N>| events.value(other, at).to_f64();
            let changes = || rounding(state, [moved(-rounded), moved(rounded)], g);
            scan.band = 0.0;
            if scan.meets(x, rounded) {
                scan.band = 4.0 * g(state).abs().min(changes()[0]);
            }
            if ends && other != event {
                scan.beside_another(&events.kind(other), (x, rounded), (g(state), changes()[1]), |x| {
                    g(&step.at(x))
                });
            }
        }
        self.scans[event].take();
        self.scans[event].met_at(x, rounded);
    }

    /// The next event that the end of a run within rounding of a root counts as, after a step in which there are no
    /// more.
    pub fn at_end<S: Real, E: Bound<S, N, K>, const N: usize>(
        &mut self,
        events: &E,
        step: &(impl Within<S, N> + ?Sized),
    ) -> Option<(usize, Direction)> {
        let x = ULPS * step.resolution().max(LAST_STEP * S::EPSILON);
        for (event, scan) in self.scans.iter_mut().enumerate().filter(|(_, scan)| scan.is_near_end()) {
            let g = |at: &State<S, N>| events.value(event, at).to_f64();
            let [_, changes] = rounding(&step.at(1.0), [-x, x].map(|x| step.at(1.0 + x)), g);
            if let Some(direction) = scan.end_within(&events.kind(event), changes, |x| g(&step.at(x))) {
                return Some((event, direction));
            }
        }
        None
    }

    /// Takes another event at the same place as one that has ended the run.
    pub fn together(&mut self, x: f64, resolution: f64) -> Option<(usize, Direction)> {
        let (event, _) =
            self.earliest(x, resolution).filter(|&(_, found)| matches!(found, Found::Root { .. }))?;
        Some((event, self.scans[event].take()?))
    }
}
