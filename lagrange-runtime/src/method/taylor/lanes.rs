//! Series in lanes: what a step hands on, lane by lane.

use super::{MethodState, Remainder};
use crate::lanes::{Lanes, Lanewise, Policy, Processor, SingleLane};
use crate::series::{Sides, TaylorSeries};

impl<const L: usize, P: Policy, A: Processor, const N: usize> Lanewise<L> for Remainder<Lanes<L, P, A>, N> {
    type Element = Remainder<SingleLane<P, A>, N>;

    fn splat(one: &Self::Element) -> Self {
        Remainder { error: Lanewise::splat(&one.error), last: Lanewise::splat(&one.last), order: one.order }
    }

    fn lane(&self, lane: usize) -> Self::Element {
        Remainder { error: self.error.lane(lane), last: self.last.lane(lane), order: self.order }
    }

    fn put(&mut self, lane: usize, one: &Self::Element) {
        self.error.put(lane, &one.error);
        self.last.put(lane, &one.last);
    }

    #[inline(always)]
    fn take(&mut self, chosen: &[bool; L], other: &Self) {
        self.error.take(chosen, &other.error);
        self.last.take(chosen, &other.last);
    }
}

impl<const L: usize, P: Policy, A: Processor, const N: usize, const ROOM: usize, W> Lanewise<L>
    for MethodState<Lanes<L, P, A>, N, ROOM, W>
where
    W: Lanewise<L>,
{
    type Element = MethodState<SingleLane<P, A>, N, ROOM, W::Element>;

    fn splat(one: &Self::Element) -> Self {
        MethodState {
            series: TaylorSeries { q: Lanewise::splat(&one.series.q) },
            lost: Lanewise::splat(&one.lost),
            sides: W::splat(&one.sides),
            switching: Lanewise::splat(&one.switching),
            begins_at: W::splat(&one.begins_at),
        }
    }

    fn lane(&self, lane: usize) -> Self::Element {
        MethodState {
            series: TaylorSeries { q: self.series.q.lane(lane) },
            lost: self.lost.lane(lane),
            sides: self.sides.lane(lane),
            switching: self.switching.lane(lane),
            begins_at: self.begins_at.lane(lane),
        }
    }

    #[inline(always)]
    fn put(&mut self, lane: usize, one: &Self::Element) {
        self.series.q.put(lane, &one.series.q);
        self.lost.put(lane, &one.lost);
        self.sides.put(lane, &one.sides);
        self.switching.put(lane, &one.switching);
        self.begins_at.put(lane, &one.begins_at);
    }

    #[inline(always)]
    fn take(&mut self, chosen: &[bool; L], other: &Self) {
        self.series.q.take(chosen, &other.series.q);
        self.lost.take(chosen, &other.lost);
        self.sides.take(chosen, &other.sides);
        self.switching.take(chosen, &other.switching);
        self.begins_at.take(chosen, &other.begins_at);
    }
}

impl<const L: usize, P: Policy, A: Processor, const C: usize> Lanewise<L> for Sides<Lanes<L, P, A>, C> {
    type Element = Sides<SingleLane<P, A>, C>;

    fn splat(one: &Self::Element) -> Self {
        Sides(Lanewise::splat(&one.0))
    }

    #[inline(always)]
    fn lane(&self, lane: usize) -> Self::Element {
        Sides(self.0.lane(lane))
    }

    #[inline(always)]
    fn put(&mut self, lane: usize, one: &Self::Element) {
        self.0.put(lane, &one.0);
    }

    #[inline(always)]
    fn take(&mut self, chosen: &[bool; L], other: &Self) {
        self.0.take(chosen, &other.0);
    }
}
