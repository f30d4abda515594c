//! Series in lanes: what a step hands on, lane by lane.

use super::{Memory, Remainder};
use crate::lanes::{Lane, Lanes, Lanewise, Policy, Processor};
use crate::series::{Series, Smooth};

impl<const L: usize, P: Policy, A: Processor, const N: usize> Lanewise<L> for Remainder<Lanes<L, P, A>, N> {
    type One = Remainder<Lane<P, A>, N>;

    fn splat(one: &Self::One) -> Self {
        Remainder { error: Lanewise::splat(&one.error), last: Lanewise::splat(&one.last), order: one.order }
    }

    fn lane(&self, lane: usize) -> Self::One {
        Remainder { error: self.error.lane(lane), last: self.last.lane(lane), order: self.order }
    }

    fn put(&mut self, lane: usize, one: &Self::One) {
        self.error.put(lane, &one.error);
        self.last.put(lane, &one.last);
    }

    #[inline(always)]
    fn take(&mut self, chosen: &[bool; L], other: &Self) {
        self.error.take(chosen, &other.error);
        self.last.take(chosen, &other.last);
    }
}

/// A lane begins at no switch: systems with switches have no series over lanes.
impl<const L: usize, P: Policy, A: Processor, const N: usize, const ROOM: usize> Lanewise<L>
    for Memory<Lanes<L, P, A>, N, ROOM>
{
    type One = Memory<Lane<P, A>, N, ROOM>;

    fn splat(one: &Self::One) -> Self {
        Memory {
            series: Series { q: Lanewise::splat(&one.series.q) },
            lost: Lanewise::splat(&one.lost),
            sides: Smooth,
            switching: [Smooth; ROOM],
            begins_at: 0,
        }
    }

    fn lane(&self, lane: usize) -> Self::One {
        Memory {
            series: Series { q: self.series.q.lane(lane) },
            lost: self.lost.lane(lane),
            sides: Smooth,
            switching: [Smooth; ROOM],
            begins_at: 0,
        }
    }

    #[inline(always)]
    fn put(&mut self, lane: usize, one: &Self::One) {
        self.series.q.put(lane, &one.series.q);
        self.lost.put(lane, &one.lost);
    }

    #[inline(always)]
    fn take(&mut self, chosen: &[bool; L], other: &Self) {
        self.series.q.take(chosen, &other.series.q);
        self.lost.take(chosen, &other.lost);
    }
}
