//! Events that a motion has yet to meet when it is left: on which side of zero their functions were.

/// Events of which that is kept.
const KEPT: usize = 8;

/// The sign of g of an event where the motion was left, and the largest |g| at which it still counts; 0 if it was met
/// there, and the largest |g| at which it is not met again.
pub type Side = [f64; 2];

/// Sides of the events that were looked for last. Another search for as many events from the same time takes them for
/// its own, so that what is crossed by an input that changes between the two, or within rounding of an impact, is
/// found.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Sides {
    t: f64,
    count: usize,
    /// The motion was left at a terminal event.
    landed: bool,
    sides: [Side; KEPT],
}

impl Sides {
    /// Keeps these, of a motion that was left at `t`; none, if there are too many.
    pub fn keep(&mut self, t: f64, landed: bool, sides: impl ExactSizeIterator<Item = Side>) {
        *self = Sides::default();
        if sides.len() <= KEPT {
            (self.t, self.landed, self.count) = (t, landed, sides.len());
            self.sides.iter_mut().zip(sides).for_each(|(kept, side)| *kept = side);
        }
    }

    /// Those of `count` events, if they were kept at `t`.
    pub fn of(&self, t: f64, count: usize) -> Option<&[Side]> {
        (self.t == t && self.count == count).then(|| &self.sides[..count])
    }

    /// The state, or the system, is another one from now on: what was within rounding of a terminal event is still to
    /// come.
    pub fn changed(&mut self) {
        if !self.landed {
            *self = Sides::default();
        }
    }
}
