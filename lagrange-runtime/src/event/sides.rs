//! Events that a motion has yet to meet when it is left: on which side of zero their functions were.

/// Most events that a stepper looks for at once.
pub const KEPT: usize = 16;

/// The sign of g of an event where the motion was left, and the largest |g| at which it still counts; 0 if it was met
/// there, and the largest |g| at which it is not met again.
pub type Side = [f64; 2];

/// Rounding of g at one state.
const SAME: f64 = 1e-12;

/// Roundings of g within which the side of an event beside another one is kept, and beyond which one that was met is
/// on the other side, to which an input took it.
pub const NEAR_ANOTHER: f64 = 64.0;

/// An event by its properties, and its g where the motion was left.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Left {
    /// A hash of name, direction and the like.
    pub event: u64,
    /// Its function there.
    pub g: f64,
}

impl Left {
    fn is(&self, other: &Left) -> bool {
        (self.g - other.g).abs() <= SAME * self.g.abs().max(other.g.abs())
    }
}

/// Sides of the events that were looked for last. Another search from the same time takes those of its own events, so
/// that what is crossed by an input that changes between the two, or within rounding of an impact, is found. Functions
/// are not compared: an event has the properties of the one before and, unless an input has changed, its g.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Sides {
    t: f64,
    count: usize,
    /// The motion was left at an event, from which an impact may lead on.
    landed: bool,
    /// Inputs have changed since, and so has the state, or the system.
    driven: bool,
    changed: bool,
    kept: [(Left, Side); KEPT],
}

impl Sides {
    /// Sides of the events of a motion that was left at `t`.
    pub fn left(t: f64, landed: bool, events: impl ExactSizeIterator<Item = (Left, Side)>) -> Self {
        let mut sides = Sides { t, landed, count: events.len(), ..Sides::default() };
        sides.kept.iter_mut().zip(events).for_each(|(kept, event)| *kept = event);
        sides
    }

    /// The side of each of these events, if it was kept at `t`.
    pub fn of<const K: usize>(&self, t: f64, events: impl Fn(usize) -> Left) -> [Option<Side>; K] {
        let kept = &self.kept[..self.count];
        if kept.is_empty() || self.t != t {
            return [None; K];
        }
        core::array::from_fn(|i| {
            let event = events(i);
            // (At an impact, and by an input, g is another one.)
            let moved = self.landed || self.driven;
            let is = |left: &Left, moved: bool| left.event == event.event && (moved || left.is(&event));
            let at_its_place = kept.get(i).filter(|(left, _)| is(left, moved));
            let kept = at_its_place.or_else(|| kept.iter().find(|(left, _)| is(left, false)));
            kept.map(|&(left, side)| if self.changed { side } else { self.stays(left, side, event.g) })
        })
    }

    /// The side of an event where the state is as it was left: whatever inputs make of g, now or before the next step,
    /// is a crossing from there. An event that passed zero within rounding is still to be met, and not again.
    fn stays(&self, left: Left, [side, reach]: Side, now: f64) -> Side {
        match side {
            0.0 if left.g.abs() > NEAR_ANOTHER * reach => [left.g.signum(), f64::MAX],
            0.0 => [side, reach],
            _ if side * left.g > 0.0 || self.driven && now.abs() > reach => [side, f64::MAX],
            _ => [side, reach],
        }
    }

    /// The inputs are others from now on.
    pub fn driven(&mut self) {
        self.driven = true;
    }

    /// The state, or the system, is another one from now on: what was within rounding of a terminal event is still to
    /// come.
    pub fn changed(&mut self) {
        match self.landed {
            true => self.changed = true,
            false => *self = Sides::default(),
        }
    }
}
