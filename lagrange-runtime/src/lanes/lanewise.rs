//! What consists of lanes: taken apart, put together, and changed where a lane's step was accepted.

use super::number::{Lane, Lanes};
use super::policy::Policy;
use super::processor::Processor;
use crate::controller::{NoEstimate, TwoEstimates};
use crate::series::Smooth;
use crate::state::{State, Tangent};
use nalgebra::SMatrix;

/// A value of `L` lanes, each of which is a value [`One`](Self::One). Whatever a method hands from one step to the next has to be,
/// for the method to run in lanes.
pub trait Lanewise<const L: usize>: Clone {
    /// The state of a single lane.
    type One;

    /// The same in all lanes.
    fn splat(one: &Self::One) -> Self;

    /// The value of a lane.
    fn lane(&self, lane: usize) -> Self::One;

    /// Gives a lane another value.
    fn put(&mut self, lane: usize, one: &Self::One);

    /// Takes those lanes of `other` that are `chosen`.
    fn take(&mut self, chosen: &[bool; L], other: &Self);
}

impl<const L: usize, P: Policy, A: Processor> Lanewise<L> for Lanes<L, P, A> {
    type One = Lane<P, A>;

    fn splat(one: &Lane<P, A>) -> Self {
        Lanes::splat(one.value())
    }

    #[inline(always)]
    fn lane(&self, lane: usize) -> Lane<P, A> {
        Lane::new(self.as_array()[lane])
    }

    #[inline(always)]
    fn put(&mut self, lane: usize, one: &Lane<P, A>) {
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
    type One = SMatrix<Lane<P, A>, N, M>;

    fn splat(one: &Self::One) -> Self {
        SMatrix::from_fn(|i, j| Lanes::splat(one[(i, j)].value()))
    }

    #[inline(always)]
    fn lane(&self, lane: usize) -> Self::One {
        SMatrix::from_fn(|i, j| self[(i, j)].lane(lane))
    }

    #[inline(always)]
    fn put(&mut self, lane: usize, one: &Self::One) {
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
            type One = $type<$crate::lanes::Lane<P, A>, N $(, $size)*>;

            fn splat(one: &Self::One) -> Self {
                $type { $($field: $crate::lanes::Lanewise::splat(&one.$field)),* }
            }

            #[inline(always)]
            fn lane(&self, lane: usize) -> Self::One {
                $type { $($field: self.$field.lane(lane)),* }
            }

            #[inline(always)]
            fn put(&mut self, lane: usize, one: &Self::One) {
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
    type One = [T::One; M];

    fn splat(one: &Self::One) -> Self {
        core::array::from_fn(|i| T::splat(&one[i]))
    }

    #[inline(always)]
    fn lane(&self, lane: usize) -> Self::One {
        core::array::from_fn(|i| self[i].lane(lane))
    }

    #[inline(always)]
    fn put(&mut self, lane: usize, one: &Self::One) {
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
    type One = (A::One, B::One);

    fn splat(one: &Self::One) -> Self {
        (A::splat(&one.0), B::splat(&one.1))
    }

    #[inline(always)]
    fn lane(&self, lane: usize) -> Self::One {
        (self.0.lane(lane), self.1.lane(lane))
    }

    #[inline(always)]
    fn put(&mut self, lane: usize, one: &Self::One) {
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
            type One = $type;

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
