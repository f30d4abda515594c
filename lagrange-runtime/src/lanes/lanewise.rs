//! Structure-of-arrays access: get, set and masked update of one lane.

use super::number::{Lanes, SingleLane};
use super::policy::Policy;
use super::processor::Processor;
use crate::controller::{NoEstimate, TwoEstimates};
use crate::series::Smooth;
use crate::state::{State, Tangent};
use nalgebra::SMatrix;

/// A value of `L` lanes, each of which is a value [`One`](Self::Element). Whatever a method hands from one step to
/// the next has to be, for the method to run in lanes.
pub trait Lanewise<const L: usize>: Clone {
    /// The state of a single lane.
    type Element;

    /// The same in all lanes.
    fn splat(one: &Self::Element) -> Self;

    /// The value of a lane.
    fn lane(&self, lane: usize) -> Self::Element;

    /// Gives a lane another value.
    fn put(&mut self, lane: usize, one: &Self::Element);

    /// Takes those lanes of `other` that are `chosen`.
    fn take(&mut self, chosen: &[bool; L], other: &Self);
}

impl<const L: usize, P: Policy, A: Processor> Lanewise<L> for Lanes<L, P, A> {
    type Element = SingleLane<P, A>;

    fn splat(one: &SingleLane<P, A>) -> Self {
        Lanes::splat(one.value())
    }

    #[inline(always)]
    fn lane(&self, lane: usize) -> SingleLane<P, A> {
        SingleLane::new(self.as_array()[lane])
    }

    #[inline(always)]
    fn put(&mut self, lane: usize, one: &SingleLane<P, A>) {
        self.as_mut()[lane] = one.value();
    }

    #[inline(always)]
    fn take(&mut self, chosen: &[bool; L], other: &Self) {
        let (own, other) = (self.as_mut(), other.as_array());
        for i in 0..L {
            own[i] = if chosen[i] { other[i] } else { own[i] };
        }
    }
}

impl<const L: usize, P: Policy, A: Processor, const N: usize, const M: usize> Lanewise<L>
    for SMatrix<Lanes<L, P, A>, N, M>
{
    type Element = SMatrix<SingleLane<P, A>, N, M>;

    fn splat(one: &Self::Element) -> Self {
        SMatrix::from_fn(|i, j| Lanes::splat(one[(i, j)].value()))
    }

    #[inline(always)]
    fn lane(&self, lane: usize) -> Self::Element {
        SMatrix::from_fn(|i, j| self[(i, j)].lane(lane))
    }

    #[inline(always)]
    fn put(&mut self, lane: usize, one: &Self::Element) {
        for i in 0..N * M {
            self[i].put(lane, &one[i]);
        }
    }

    #[inline(always)]
    fn take(&mut self, chosen: &[bool; L], other: &Self) {
        for i in 0..N * M {
            self[i].take(chosen, &other[i]);
        }
    }
}

/// Makes structs of scalars and vectors lanewise, each by its fields.
macro_rules! lanewise {
    ($($type:ident<N $(, $size:ident)*> { $($field:ident),* })*) => {$(
        impl<const L: usize, P, A, const N: usize $(, const $size: usize)*> $crate::lanes::Lanewise<L>
            for $type<$crate::lanes::Lanes<L, P, A>, N $(, $size)*>
        where
            P: $crate::lanes::Policy,
            A: $crate::lanes::Processor,
        {
            type Element = $type<$crate::lanes::SingleLane<P, A>, N $(, $size)*>;

            fn splat(one: &Self::Element) -> Self {
                $type { $($field: $crate::lanes::Lanewise::splat(&one.$field)),* }
            }

            #[inline(always)]
            fn lane(&self, lane: usize) -> Self::Element {
                $type { $($field: self.$field.lane(lane)),* }
            }

            #[inline(always)]
            fn put(&mut self, lane: usize, one: &Self::Element) {
                $(self.$field.put(lane, &one.$field);)*
            }

            #[inline(always)]
            fn take(&mut self, chosen: &[bool; L], other: &Self) {
                $(self.$field.take(chosen, &other.$field);)*
            }
        }
    )*};
}

pub(crate) use lanewise;

lanewise! {
    State<N> { t, q, qd }
    Tangent<N> { q, qd }
    TwoEstimates<N> { fifth, third }
}

impl<T: Lanewise<L>, const L: usize, const M: usize> Lanewise<L> for [T; M] {
    type Element = [T::Element; M];

    fn splat(one: &Self::Element) -> Self {
        core::array::from_fn(|i| T::splat(&one[i]))
    }

    #[inline(always)]
    fn lane(&self, lane: usize) -> Self::Element {
        core::array::from_fn(|i| self[i].lane(lane))
    }

    #[inline(always)]
    fn put(&mut self, lane: usize, one: &Self::Element) {
        for i in 0..M {
            self[i].put(lane, &one[i]);
        }
    }

    #[inline(always)]
    fn take(&mut self, chosen: &[bool; L], other: &Self) {
        for i in 0..M {
            self[i].take(chosen, &other[i]);
        }
    }
}

impl<A: Lanewise<L>, B: Lanewise<L>, const L: usize> Lanewise<L> for (A, B) {
    type Element = (A::Element, B::Element);

    fn splat(one: &Self::Element) -> Self {
        (A::splat(&one.0), B::splat(&one.1))
    }

    #[inline(always)]
    fn lane(&self, lane: usize) -> Self::Element {
        (self.0.lane(lane), self.1.lane(lane))
    }

    #[inline(always)]
    fn put(&mut self, lane: usize, one: &Self::Element) {
        self.0.put(lane, &one.0);
        self.1.put(lane, &one.1);
    }

    #[inline(always)]
    fn take(&mut self, chosen: &[bool; L], other: &Self) {
        self.0.take(chosen, &other.0);
        self.1.take(chosen, &other.1);
    }
}

/// Implements the traits for types without content.
macro_rules! empty {
    ($($type:ty, $value:expr;)*) => {$(
        impl<const L: usize> Lanewise<L> for $type {
            type Element = $type;

            fn splat(_: &$type) -> $type {
                $value
            }

            fn lane(&self, _: usize) -> $type {
                $value
            }

            fn put(&mut self, _: usize, _: &$type) {}

            fn take(&mut self, _: &[bool; L], _: &$type) {}
        }
    )*};
}

empty! {
    (), ();
    NoEstimate, NoEstimate;
    Smooth, Smooth;
}
