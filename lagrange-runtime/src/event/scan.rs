//! One event within one step: its roots one after the other, from the values of g along the step. Places are fractions
//! of the step, from 0 to 1.

use super::outline::Seen;
use super::root::{self, first_zero, sign};
use super::sides::{NEAR_ANOTHER, Side};
use super::{Direction, EventKind};
use crate::scalar::Functions;

/// The largest distance from the ends of a step that is close to them, as a fraction of the step.
const CLOSE: f64 = 1.0 / 1024.0;

/// Places near the start of a run, in powers of 1/4: after a bounce the next one may follow within a fraction of a
/// step.
const GEOMETRIC: usize = 13;

/// Roundings of time within which a flight that begins on the root is not told from its start.
const SHORTEST_FLIGHT: f64 = 2.0;

/// Part of the largest |g| above which it is no rounding.
const NEAR: f64 = 1e-6;

/// Rounding of g in units of ε beside its largest values.
const ROUNDING: f64 = 4.0;

/// Roundings of g beyond which it has left a root.
const LEFT: f64 = 4.0;

/// Places of a step at which g is evaluated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Grid {
    parts: usize,
    /// Places near the start of a run; 0 in a later step.
    near_start: usize,
    /// The distance from 1 to the next number.
    epsilon: f64,
}

impl Grid {
    /// The places of a step with so many parts, the first step of a run or not, in a scalar of the given ε.
    pub fn new(parts: u32, first: bool, epsilon: f64) -> Self {
        Grid { parts: parts.max(1) as usize, near_start: if first { GEOMETRIC } else { 0 }, epsilon }
    }

    /// The places of the first step of a run that begins on the root: down to `least`.
    pub fn down_to(self, least: f64) -> Self {
        let (mut near_start, mut x) = (1, 0.25 * self.before_first_part());
        while 0.25 * x >= least {
            (near_start, x) = (near_start + 1, 0.25 * x);
        }
        Grid { near_start, ..self }
    }

    /// All places after the start, and those at which g may be asked for besides: right after it and beyond the end.
    #[cfg(feature = "std")]
    pub fn places(self) -> impl Iterator<Item = f64> {
        (0..self.len()).map(move |i| self.place(i)).chain([self.right_after_start(), 1.0 + self.close()])
    }

    fn places_near_start(&self) -> usize {
        self.near_start.max(1)
    }

    /// A distance from the ends that is within the first and the last part.
    fn close(self) -> f64 {
        CLOSE.min(0.25 / self.parts as f64)
    }

    /// A place by which the slope at the start is seen.
    fn right_after_start(self) -> f64 {
        CLOSE * self.close()
    }

    /// A power of 1/4 of which the next one lies within the first part.
    fn before_first_part(self) -> f64 {
        let mut x = 0.25;
        while 0.25 * x * self.parts as f64 >= 1.0 {
            x *= 0.25;
        }
        x
    }

    /// The number of places, the start not counted.
    fn len(&self) -> usize {
        self.places_near_start() + self.parts + 1
    }

    /// The places in their order.
    fn place(&self, i: usize) -> f64 {
        let near = self.places_near_start();
        if i < near {
            match self.near_start {
                0 => self.close(),
                near => (i..near).fold(self.before_first_part(), |x, _| 0.25 * x),
            }
        } else if i < near + self.parts - 1 {
            (i - near + 1) as f64 / self.parts as f64
        } else if i == near + self.parts - 1 {
            1.0 - self.close()
        } else {
            1.0
        }
    }
}

/// Distance from the border of a part, in parts, at which g is looked at beside a crossing.
const BESIDE: f64 = 1.0 / 64.0;

/// The place between 0 and 1 at which the cubic through these values and slopes at 0 and 1 has a minimum, if it has
/// one there.
fn lowest_of_cubic([from, to]: [f64; 2], [rise, fall]: [f64; 2]) -> Option<f64> {
    // C' = rise + 2 b x + 3 a x², C'' = 2 b + 6 a x > 0 at the root x = (−b + √(b² − 3 a rise)) / 3 a = −rise / (b +
    // √…).
    let (a, b) = (2.0 * (from - to) + rise + fall, 3.0 * (to - from) - 2.0 * rise - fall);
    let x = -rise / (b + Functions::sqrt(b * b - 3.0 * a * rise));
    let other = (-b + Functions::sqrt(b * b - 3.0 * a * rise)) / (3.0 * a);
    [x, other].into_iter().find(|x| *x > 0.0 && *x < 1.0)
}

/// The next root in a step, or a failure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Found {
    /// A root; of direction `Either`: a touch.
    Root { x: f64, direction: Direction },
    /// g is infinite or not a number somewhere after `x`.
    NotFinite { x: f64 },
}

impl Found {
    pub fn place(&self) -> f64 {
        let (Found::Root { x, .. } | Found::NotFinite { x }) = self;
        *x
    }
}

/// Progress of the search for roots of one event.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Scan {
    pub found: Option<Found>,
    /// Largest |g| that counts as zero at the start of a run.
    pub band: f64,
    /// The event has been reported at the place at which the run may be restarted.
    reported: bool,
    /// The sign of g before a restart, of an event that was not reported there, and the largest |g| after it that is
    /// still to be crossed.
    pending: Option<Side>,
    /// |g| at a start that has passed zero by little, so that a restart from there shall not meet it again.
    beyond: f64,
    grid: Grid,
    /// The place that was reached, the value and the sign there; the sign 0 is that of a start on the root, or of a
    /// zero already reported, and whatever follows it is no crossing.
    x: f64,
    pub g: f64,
    sign: f64,
    /// Index of the next place, and the value there if it is known.
    next: usize,
    ahead: Option<f64>,
    /// Two crossings may follow right after the end of the step before, which is then looked at again.
    dip_after: bool,
    /// g has crossed zero in the part before.
    crossed: bool,
    /// The root taken last.
    last: f64,
    /// The largest |g| so far, to judge what rounding is.
    scale: f64,
    /// g has been larger than its rounding since the last root: only then a small |g| is a touch, and not the root
    /// again.
    left: bool,
    /// The rounding of g by its values on both sides of the minimum found last.
    nearby: f64,
    /// The ends of the step have shown that there is no event in it.
    pub passed: bool,
    /// The sign of g before the root at which the run was ended; 0 if that is not known, or g touched zero.
    came_from: f64,
    /// The sign with which the step was entered.
    entered: f64,
    /// The place at which g is first seen to have left the root that the run began on, and g there.
    departed: Option<(f64, f64)>,
}

/// The direction of a crossing from the side with the given sign.
fn leaving(sign: f64) -> Direction {
    if sign < 0.0 { Direction::Rising } else { Direction::Falling }
}

impl Scan {
    pub const NEW: Scan = Scan {
        found: None,
        band: 0.0,
        reported: false,
        pending: None,
        beyond: 0.0,
        grid: Grid { parts: 1, near_start: GEOMETRIC, epsilon: 0.0 },
        x: 0.0,
        g: 0.0,
        sign: 0.0,
        next: 0,
        ahead: None,
        dip_after: false,
        crossed: false,
        last: f64::NAN,
        scale: 0.0,
        left: false,
        nearby: 0.0,
        passed: false,
        came_from: 0.0,
        entered: 0.0,
        departed: None,
    };

    /// A run begins where g is `g`.
    pub fn begin(&mut self, g: f64) {
        let pending = self.pending.filter(|[_, reach]| g.abs() <= *reach);
        let (g, sign, beyond) = match pending {
            // (From its side, if it has passed zero.)
            Some([side, reach]) if side * g <= 0.0 => {
                (side * f64::MIN_POSITIVE, side, if reach < f64::MAX { g.abs() } else { 0.0 })
            }
            Some([side, _]) => (g, side, 0.0),
            None => (g, if g.abs() <= self.band { 0.0 } else { sign(g) }, 0.0),
        };
        *self = Scan { g, sign, band: self.band, pending, beyond, came_from: self.came_from, ..Scan::NEW };
    }

    /// Takes a start of a run, at which g is not larger than it changes within rounding, for one on the root. Of the
    /// two changes the smaller one has to be exceeded for g to have left it.
    pub fn begin_within(&mut self, [smaller, larger]: [f64; 2]) {
        if self.pending.is_none() && larger.is_finite() && self.g.abs() <= larger {
            (self.sign, self.band) = (0.0, self.band.max(smaller));
        }
    }

    /// Returns whether the run begins on the root.
    pub fn starts_on_root(&self) -> bool {
        self.sign == 0.0
    }

    /// Returns whether g is seen on one side of the root that the run began on, and has been on the other side before
    /// for less than can be told: a flight after an impact that is too short. There g began to change at `rate`, known
    /// to `accuracy`.
    ///
    /// Without an impact, g that came from one side goes on to the other. A run of its own may begin with the rounding
    /// of a motion that does not leave the root, so that the time of its flight, `−2 g'/g''`, has to be seen.
    pub fn misses_flight(&self, kind: &EventKind, resolution: f64, rate: impl FnOnce() -> [f64; 2]) -> bool {
        let Some((x, g)) = self.departed.filter(|_| kind.terminal) else { return false };
        let side = sign(g);
        let has_returned = self.came_from == -side;
        if !(has_returned || kind.direction == leaving(-side)) {
            return false;
        }
        let [rate, accuracy] = rate();
        let flight = -rate * x * x / (g - rate * x);
        rate * side < -accuracy && (has_returned || flight > SHORTEST_FLIGHT * resolution)
    }

    /// Returns whether g may be rounding at the end of the step, which was reached without a root there.
    pub fn is_near_end(&self) -> bool {
        self.sign != 0.0 && self.x == 1.0 && self.g.abs() <= NEAR * self.scale
    }

    /// Takes the end of a run for a root, if g is no larger there than it `changes` within rounding, and would vanish
    /// within another step: a run that goes on from there takes its start for one, see
    /// [`begin_within`](Self::begin_within).
    pub fn end_within(
        &mut self,
        kind: &EventKind,
        changes: f64,
        mut g: impl FnMut(f64) -> f64,
    ) -> Option<Direction> {
        let (direction, close) = (leaving(self.sign), self.grid.close());
        let wanted = kind.direction == Direction::Either || kind.direction == direction;
        let is_root = wanted
            && changes.is_finite()
            && self.g.abs() <= changes
            && self.sign * g(1.0 - close) >= (1.0 + close) * self.g.abs();
        is_root.then(|| {
            (self.sign, self.band) = (0.0, changes);
            direction
        })
    }

    /// Returns whether the step has no event for what is [seen](Outline::seen) of it from its ends, and goes to its
    /// end then.
    #[inline(always)]
    pub fn passes<F: Fn() -> [f64; 2]>(&mut self, kind: &EventKind, seen: &Seen<F>) -> bool {
        let end = seen.ends[1];
        let (side, scale) = (sign(end), self.scale.max(end.abs()));
        let same = self.sign == side || (self.sign == 0.0 && self.g * side >= 0.0);
        self.passed = same && !self.dip_after && seen.keeps_sign(side, 4.0 * NEAR * scale, kind.touching);
        if self.passed {
            (self.x, self.g, self.sign, self.scale) = (1.0, end, side, scale);
            (self.found, self.ahead, self.last) = (None, None, f64::NAN);
            (self.band, self.left, self.entered) = (0.0, true, side);
            (self.reported, self.pending, self.beyond) = (false, None, 0.0);
        }
        self.passed
    }

    /// The place on the cubic through the ends of a step at which the event, which is the only one there, ends the run,
    /// and its slope there.
    #[inline(always)]
    pub fn crosses<F: Fn() -> [f64; 2]>(&self, kind: &EventKind, seen: &Seen<F>) -> Option<[f64; 2]> {
        if !(self.ends_run(kind) && self.sign != 0.0 && self.pending.is_none() && !self.dip_after) {
            return None;
        }
        seen.crosses(self.sign, 4.0 * NEAR * self.scale)
    }

    /// The place at which the event is expected to end the run after a step without it, at most `horizon` steps later,
    /// and the slope of g there.
    #[inline(always)]
    pub fn approaches<F: Fn() -> [f64; 2]>(
        &self,
        kind: &EventKind,
        seen: &Seen<F>,
        horizon: f64,
    ) -> Option<[f64; 2]> {
        if self.ends_run(kind) { seen.approaches(self.sign, horizon) } else { None }
    }

    /// Returns whether a crossing from here ends the run.
    #[inline(always)]
    fn ends_run(&self, kind: &EventKind) -> bool {
        kind.terminal && (kind.direction == Direction::Either || kind.direction == self.leaves())
    }

    /// The direction in which g leaves its side of zero.
    pub fn leaves(&self) -> Direction {
        leaving(self.sign)
    }

    /// A root at `x`, alone in its step.
    pub fn find(&mut self, x: f64) {
        self.found = Some(Found::Root { x, direction: self.leaves() });
    }

    /// A step begins.
    pub fn enter(&mut self, grid: Grid) {
        (self.grid, self.x, self.next, self.ahead, self.pending) = (grid, 0.0, 0, None, None);
        // A start on the root is as good as reported.
        (self.reported, self.entered) = (self.sign == 0.0, self.sign);
        self.last = if self.reported { 0.0 } else { f64::NAN };
    }

    /// Takes what was found, if it is a root.
    pub fn take(&mut self) -> Option<Direction> {
        let Some(Found::Root { x, direction }) = self.found else { return None };
        (self.found, self.last, self.reported) = (None, x, true);
        self.came_from = match direction {
            Direction::Rising => -1.0,
            Direction::Falling => 1.0,
            Direction::Either => 0.0,
        };
        Some(direction)
    }

    /// Another event ends the run at `x`, where this one is `g`, and `changes` within rounding; `at` is this one on
    /// the interpolant. If it has passed zero on the trajectory, which the interpolant may show later, it is met as
    /// well.
    pub fn beside_another(
        &mut self,
        kind: &EventKind,
        (x, rounding): (f64, f64),
        (g, changes): (f64, f64),
        at: impl Fn(f64) -> f64,
    ) {
        self.reported &= (self.last - x).abs() <= rounding;
        if self.reported {
            self.band = self.band.max(changes);
            return;
        }
        // An input has taken g across zero before the step: however large it is, that is still to be met.
        if x <= rounding && self.entered * g < 0.0 && g.abs() > NEAR_ANOTHER * changes {
            self.pending = Some([self.entered, f64::MAX]);
            return;
        }
        let before = (x - CLOSE).max(0.0);
        // (At the start of a run g may have passed zero by little, or be 0: its side is known by the crossing.)
        let crossed = self.found.filter(|found| (found.place() - x).abs() <= rounding);
        let side = match crossed {
            Some(Found::Root { direction: Direction::Rising, .. }) => -1.0,
            Some(Found::Root { direction: Direction::Falling, .. }) => 1.0,
            _ => sign(at(if self.last < x { before.max(0.5 * (self.last + x)) } else { before })),
        };
        let passed = side * g < 0.0;
        if side == 0.0 {
            self.band = self.band.max(changes);
        }
        // (A start within a few roundings counts as one on the root, unless its side is known.)
        let reach =
            if passed || g.abs() <= NEAR_ANOTHER * changes { changes.max(2.0 * g.abs()) } else { changes };
        self.pending = (side != 0.0).then_some([side, reach]);
        self.band = if passed { self.band.max(2.0 * g.abs()) } else { self.band };
        let direction = leaving(side);
        if passed && (kind.direction == Direction::Either || kind.direction == direction) {
            self.found = Some(Found::Root { x, direction });
        }
    }

    /// A run begins that comes from this side of zero.
    pub fn comes_from(&mut self, [side, reach]: Side) {
        self.pending = (side != 0.0).then_some([side, reach]);
        self.band = if side == 0.0 { reach } else { 0.0 };
    }

    /// The event was met at the place `x`, and ends the run.
    pub fn met_at(&mut self, x: f64, rounding: f64) {
        if x <= rounding {
            self.band = self.band.max(2.0 * self.beyond);
        }
    }

    /// The side at the end of a step that was looked at: whatever g is after it, it has come from there. A root that
    /// was met at the end is left once g exceeds its rounding.
    pub fn side_at_end(&self) -> Side {
        [self.sign, if self.sign == 0.0 { self.band } else { f64::MAX }]
    }

    /// The side at an event that ended the run.
    pub fn side_landed(&self) -> Side {
        let met = [0.0, self.band];
        self.pending.filter(|_| !self.reported).unwrap_or(met)
    }

    /// The run is restarted.
    pub fn restart(&mut self) {
        match self.reported {
            true => self.pending = None,
            false => (self.band, self.came_from) = (0.0, 0.0),
        }
    }

    /// Returns whether a root, just found or just taken, lies at `x` but for `rounding`.
    pub fn meets(&self, x: f64, rounding: f64) -> bool {
        let near = |place: f64| (place - x).abs() <= rounding;
        near(self.last) || matches!(self.found, Some(Found::Root { x, .. }) if near(x))
    }

    /// The place found, if g touches zero there, and the rounding of g nearby.
    pub fn touches(&self) -> Option<(f64, f64)> {
        match self.found {
            Some(Found::Root { x, direction: Direction::Either }) => Some((x, self.nearby)),
            _ => None,
        }
    }

    /// Searches on to the next root that matters, or to the end of the step.
    pub fn look_ahead(&mut self, kind: &EventKind, resolution: f64, mut g: impl FnMut(f64) -> f64) {
        self.found = None;
        while self.next < self.grid.len() {
            match self.part(kind, resolution, &mut g) {
                Some(Found::Root { x, .. }) if x.is_nan() => {
                    self.found = Some(Found::NotFinite { x: self.x });
                    return;
                }
                Some(Found::Root { direction, .. })
                    if kind.direction != Direction::Either && kind.direction != direction => {}
                None => {}
                found => {
                    self.left = false;
                    self.found = found;
                    return;
                }
            }
        }
    }

    /// Goes to the next place, or to a root before it.
    fn part(&mut self, kind: &EventKind, resolution: f64, g: &mut impl FnMut(f64) -> f64) -> Option<Found> {
        let here = (self.x, self.g);
        self.left |= here.1.abs() > LEFT * self.rounding();
        let x = self.grid.place(self.next);
        let there = (x, self.ahead.take().unwrap_or_else(|| g(x)));
        if !there.1.is_finite() {
            return Some(Found::NotFinite { x: self.x });
        }
        self.scale = self.scale.max(there.1.abs());
        let before = self.sign;
        if before == 0.0 {
            let left = there.1.abs() > self.band;
            self.go(there, if left { sign(there.1) } else { 0.0 });
            if left {
                self.band = 0.0;
                self.departed.get_or_insert(there);
            }
            return None;
        }
        // Beyond the end of the step the interpolant is continued a little.
        let beyond = if self.next + 1 < self.grid.len() {
            self.grid.place(self.next + 1)
        } else {
            1.0 + self.grid.close()
        };
        if before * there.1 > 0.0
            && let Some((bottom, low)) = self.dip_at_start(here, there, g)
        {
            self.ahead = Some(there.1);
            (self.x, self.g, self.sign) = (bottom, before * low, -before);
            let root = first_zero(g, here, (bottom, before * low), resolution);
            return Some(Found::Root { x: root, direction: leaving(before) });
        }
        let crossed = core::mem::take(&mut self.crossed);
        if before * there.1 > 0.0 {
            let after = (beyond, g(beyond));
            if let Some((bottom, low)) = self.beside(crossed, [here, there, after], g) {
                self.ahead = Some(there.1);
                (self.x, self.g, self.sign) = (bottom, before * low, -before);
                let root = first_zero(g, here, (bottom, before * low), resolution);
                return Some(Found::Root { x: root, direction: leaving(before) });
            }
            self.dip(kind, resolution, [here, there, after], g)
        } else {
            let root = first_zero(g, here, there, resolution);
            let touches = there.1 == 0.0 && before * g(beyond) > 0.0;
            self.go(there, sign(there.1));
            self.crossed = true;
            Some(Found::Root {
                x: root,
                direction: if touches { Direction::Either } else { leaving(before) },
            })
        }
    }

    /// A place right after the start of a step at which g has the other sign: between two crossings that the step
    /// before has seen beyond its end, or at a level that g grazes, just short of which that step ended.
    fn dip_at_start(
        &mut self,
        here: (f64, f64),
        there: (f64, f64),
        g: &mut impl FnMut(f64) -> f64,
    ) -> Option<(f64, f64)> {
        let before = self.sign;
        let mut high = |x: f64| (x, before * g(x));
        let [from, to] = [here, there].map(|(x, g)| (x, before * g));
        let three = if core::mem::take(&mut self.dip_after) {
            [high(-self.grid.close()), high(here.0), to]
        } else if self.next == 0 && self.grid.near_start == 0 {
            let near = high(self.grid.right_after_start());
            if !(near.1 < from.1 && near.1 <= to.1) {
                return None;
            }
            [from, near, to]
        } else {
            return None;
        };
        let (bottom, low) = match three[1] {
            at if at.1 < 0.0 => at,
            _ => root::dip(&mut |x| before * g(x), three, 0.0),
        };
        (low < 0.0 && bottom > 0.0).then_some((bottom, low))
    }

    /// A place between the first two of three at which g has the other sign, beside a crossing in the part before or
    /// after. Two crossings of this part are not seen there by a minimum of |g| at the border, but by the minimum of
    /// the cubic through |g| and its slopes at both ends, or by |g| that grows towards the crossing.
    fn beside(
        &self,
        crossed: bool,
        [here, there, after]: [(f64, f64); 3],
        g: &mut impl FnMut(f64) -> f64,
    ) -> Option<(f64, f64)> {
        let before = self.sign;
        if !(crossed || before * after.1 < 0.0) {
            return None;
        }
        let [from, to] = [here, there].map(|(x, g)| (x, before * g));
        let mut high = |part: f64| {
            let x = from.0 + part * (to.0 - from.0);
            (x, before * g(x))
        };
        let [near, far] = [high(BESIDE), high(1.0 - BESIDE)];
        let slopes = [(near.1 - from.1) / BESIDE, (to.1 - far.1) / BESIDE];
        let bottom = lowest_of_cubic([from.1, to.1], slopes).map(&mut high);
        let lowest =
            [Some(near), Some(far), bottom].into_iter().flatten().min_by(|a, b| a.1.total_cmp(&b.1))?;
        if lowest.1 < 0.0 {
            return Some(lowest);
        }
        if lowest.1.is_nan() || lowest.1 > from.1.min(to.1) {
            return None;
        }
        let (bottom, low) = root::dip(&mut |x| before * g(x), [from, lowest, to], 0.0);
        (low < 0.0).then_some((bottom, low))
    }

    /// Goes to the second of three places with one sign, or to the lowest |g| between them where that is a root.
    fn dip(
        &mut self,
        kind: &EventKind,
        resolution: f64,
        [here, there, after]: [(f64, f64); 3],
        g: &mut impl FnMut(f64) -> f64,
    ) -> Option<Found> {
        let before = self.sign;
        let last = self.next + 1 == self.grid.len();
        let high = |(x, g): (f64, f64)| (x, before * g);
        let three = [high(here), high(there), high(after)];
        let touching = kind.touching.max(self.rounding());
        if three[1].1 <= three[0].1 && three[1].1 <= three[2].1 {
            let (x, low) = root::dip(&mut |x| before * g(x), three, touching);
            // What lies beyond the step belongs to the next one.
            self.dip_after = low < 0.0 && x >= 1.0;
            if low < 0.0 && x < 1.0 {
                let root = first_zero(g, here, (x, before * low), resolution);
                self.jump((x, before * low), -before, there, after, last);
                return Some(Found::Root { x: root, direction: leaving(before) });
            }
            if self.left && (0.0..=touching).contains(&low) {
                self.nearby = ROUNDING * self.grid.epsilon * three[0].1.max(three[2].1);
                let x = x.min(1.0);
                self.jump((x, before * low), before, there, after, last);
                return Some(Found::Root { x, direction: Direction::Either });
            }
        }
        self.go(there, before);
        self.ahead = (!last && after.1.is_finite()).then_some(after.1);
        None
    }

    /// The rounding of g, by its largest value so far.
    fn rounding(&self) -> f64 {
        ROUNDING * self.grid.epsilon * self.scale
    }

    /// Goes to the next place of the grid.
    fn go(&mut self, (x, g): (f64, f64), sign: f64) {
        (self.x, self.g, self.sign, self.ahead) = (x, g, sign, None);
        self.next += 1;
    }

    /// Goes to a place of its own between `here` and `after`.
    fn jump(&mut self, to: (f64, f64), sign: f64, there: (f64, f64), after: (f64, f64), last: bool) {
        (self.x, self.g, self.sign) = (to.0, to.1, sign);
        if to.0 < there.0 {
            self.ahead = Some(there.1);
        } else {
            self.ahead = (!last).then_some(after.1);
            self.next += 1;
            if last {
                // The end itself has been passed over; its sign is that from which the next step begins.
                (self.x, self.g) = (1.0, there.1);
            }
        }
    }
}

/// Places in a step where g changes its sign, one after the other. A g that is not a number ends them.
pub(crate) struct Crossings<G> {
    scan: Scan,
    resolution: f64,
    g: G,
}

impl<G: FnMut(f64) -> f64> Crossings<G> {
    pub fn new(grid: Grid, resolution: f64, mut g: G) -> Self {
        let mut scan = Scan::NEW;
        scan.begin(g(0.0));
        scan.enter(grid);
        Crossings { scan, resolution, g }
    }
}

impl<G: FnMut(f64) -> f64> Iterator for Crossings<G> {
    type Item = f64;

    fn next(&mut self) -> Option<f64> {
        const ALL: EventKind =
            EventKind { name: "", direction: Direction::Either, terminal: false, touching: 0.0 };
        loop {
            self.scan.look_ahead(&ALL, self.resolution, &mut self.g);
            match self.scan.found {
                // A touch.
                Some(Found::Root { direction: Direction::Either, .. }) => {}
                Some(Found::Root { x, .. }) => return Some(x),
                Some(Found::NotFinite { .. }) | None => return None,
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Grid;

    #[test]
    fn places_increase() {
        for parts in 1..1000 {
            let grids = [false, true].map(|first| Grid::new(parts, first, f64::EPSILON));
            for grid in [grids[0], grids[1], grids[1].down_to(1e-14), grids[1].down_to(0.1)] {
                let places: Vec<f64> = (0..grid.len()).map(|i| grid.place(i)).collect();
                assert!(places[0] > 0.0 && places.last() == Some(&1.0), "{grid:?} {places:?}");
                assert!(places.windows(2).all(|pair| pair[0] < pair[1]), "{grid:?} {places:?}");
            }
        }
    }
}
