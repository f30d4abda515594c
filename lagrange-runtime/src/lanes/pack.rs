//! Several registers of numbers, treated as one.

use super::processor::Processor;
use super::register::Register;
use super::vector::Vector;
use core::fmt;
use core::marker::PhantomData;
use core::ops::{Add, Div, Mul, Neg, Sub};

/// `L` numbers in registers of the processor `A`, aligned as the longest of them are. Each operation is one of each register, and
/// of one number each for those that are left over. Registers do not wait for each other: while one result is on its way, the
/// processor works at the next.
#[repr(align(64))]
pub struct Pack<const L: usize, A> {
    pub(super) x: [f64; L],
    of: PhantomData<fn() -> A>,
}

impl<const L: usize, A> Pack<L, A> {
    #[inline(always)]
    pub(super) const fn new(x: [f64; L]) -> Self {
        Pack { x, of: PhantomData }
    }
}

impl<const L: usize, A> Clone for Pack<L, A> {
    #[inline(always)]
    fn clone(&self) -> Self {
        *self
    }
}

impl<const L: usize, A> Copy for Pack<L, A> {}

impl<const L: usize, A> PartialEq for Pack<L, A> {
    fn eq(&self, o: &Self) -> bool {
        self.x == o.x
    }
}

impl<const L: usize, A> fmt::Debug for Pack<L, A> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.x.fmt(f)
    }
}

/// A place in packs, at which there is a register `R`.
struct At<R> {
    first: usize,
    of: PhantomData<R>,
}

impl<R: Register> At<R> {
    #[inline(always)]
    fn new(first: usize) -> Self {
        At { first, of: PhantomData }
    }

    /// What is there.
    #[inline(always)]
    fn of<const L: usize, A>(&self, pack: &Pack<L, A>) -> R {
        R::load(&pack.x, self.first)
    }
}

/// A value for each register, and for each number that is left over. Two registers, which is what there are in the time loop, are
/// written out: loops take the compiler long to unroll. No closure: one that is not inlined is compiled for the baseline.
macro_rules! each {
    ($at:ident => $value:expr) => {{
        let width = <A::Register as Register>::WIDTH;
        let mut all = Pack::new([0.0; L]);
        if width <= L {
            let $at = At::<A::Register>::new(0);
            $value.store(&mut all.x, 0);
        }
        if 2 * width <= L {
            let $at = At::<A::Register>::new(width);
            $value.store(&mut all.x, width);
        }
        let mut first = 2 * width;
        while first + width <= L {
            let $at = At::<A::Register>::new(first);
            $value.store(&mut all.x, first);
            first += width;
        }
        let mut first = L - L % width;
        while first < L {
            let $at = At::<f64>::new(first);
            $value.store(&mut all.x, first);
            first += 1;
        }
        all
    }};
}

macro_rules! operators {
    ($($trait:ident $method:ident)*) => {$(
        impl<const L: usize, A: Processor> $trait for Pack<L, A> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, o: Self) -> Self {
                each!(at => at.of(&self).$method(at.of(&o)))
            }
        }
    )*};
}

operators! { Add add Sub sub Mul mul Div div }

impl<const L: usize, A: Processor> Neg for Pack<L, A> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        each!(at => -at.of(&self))
    }
}

impl<const L: usize, A: Processor> Vector for Pack<L, A> {
    #[inline(always)]
    fn splat(x: f64) -> Self {
        Pack::new([x; L])
    }
    #[inline(always)]
    fn fused(self, a: Self, b: Self) -> Self {
        each!(at => at.of(&self).fused(at.of(&a), at.of(&b)))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        each!(at => at.of(&self).sqrt())
    }
    #[inline(always)]
    fn and(self, o: Self) -> Self {
        each!(at => at.of(&self).and(at.of(&o)))
    }
    #[inline(always)]
    fn or(self, o: Self) -> Self {
        each!(at => at.of(&self).or(at.of(&o)))
    }
    #[inline(always)]
    fn xor(self, o: Self) -> Self {
        each!(at => at.of(&self).xor(at.of(&o)))
    }
    #[inline(always)]
    fn left<const N: u32>(self) -> Self {
        each!(at => at.of(&self).left::<N>())
    }
    #[inline(always)]
    fn right<const N: u32>(self) -> Self {
        each!(at => at.of(&self).right::<N>())
    }
    #[inline(always)]
    fn add_bits(self, o: Self) -> Self {
        each!(at => at.of(&self).add_bits(at.of(&o)))
    }
    #[inline(always)]
    fn less(self, o: Self) -> Self {
        each!(at => at.of(&self).less(at.of(&o)))
    }
    #[inline(always)]
    fn less_equal(self, o: Self) -> Self {
        each!(at => at.of(&self).less_equal(at.of(&o)))
    }
    #[inline(always)]
    fn equal(self, o: Self) -> Self {
        each!(at => at.of(&self).equal(at.of(&o)))
    }
    #[inline(always)]
    fn select(self, yes: Self, no: Self) -> Self {
        each!(at => at.of(&self).select(at.of(&yes), at.of(&no)))
    }
    #[inline(always)]
    fn all(self) -> bool {
        let (mut all, mut first) = (true, 0);
        while first + <A::Register as Register>::WIDTH <= L {
            all &= At::<A::Register>::new(first).of(&self).all();
            first += <A::Register as Register>::WIDTH;
        }
        while first < L {
            all &= self.x[first].all();
            first += 1;
        }
        all
    }
    #[inline(always)]
    fn exchange(self, a: Self, b: Self) -> (Self, Self) {
        let (mut c, mut d, mut first) = (a, b, 0);
        while first + <A::Register as Register>::WIDTH <= L {
            let at = At::<A::Register>::new(first);
            let (e, f) = at.of(&self).exchange(at.of(&a), at.of(&b));
            e.store(&mut c.x, first);
            f.store(&mut d.x, first);
            first += <A::Register as Register>::WIDTH;
        }
        while first < L {
            (c.x[first], d.x[first]) = self.x[first].exchange(a.x[first], b.x[first]);
            first += 1;
        }
        (c, d)
    }
}
