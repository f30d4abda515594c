//! The two scalars that compute under a [`Policy`]: [`Lane`], one number, and [`Lanes`], several.

use super::functions::{self, VectorFunctions};
use super::pack::Pack;
use super::policy::{Native, Policy};
use super::processor::{Baseline, Processor, Work};
use super::vector::Vector;
use crate::scalar::{Comparison, Functions, Real, Scalar};
use core::cmp::Ordering;
use core::marker::PhantomData;
use core::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};

/// `L` numbers side by side, as one [`Scalar`]: a system over lanes is `L` systems, each with its own state, time, step and
/// parameters. `P` says how they are rounded, `A` for which processor they are compiled; the bits depend on `P` alone.
///
/// ```
/// use lagrange_runtime::lanes::Lanes;
/// use lagrange_runtime::prelude::*;
/// lagrangian! {
///     pub system Pendulum {
///         param m, l, g = 9.81;
///         coord theta;
///         T = 0.5 * m * (l * dot(theta)).powi(2);
///         V = -m * g * l * cos(theta);
///     }
/// }
/// // Four pendulums of different lengths, and one evaluation.
/// let mut length = [0.5, 1.0, 2.0, 4.0].into_iter();
/// let one = Pendulum::new(1.0, 0.0);
/// let four = Pendulum { l: Lanes::new([0.5, 1.0, 2.0, 4.0]), ..one.map(<Lanes<4>>::splat) };
/// let qdd = four.accel(&[Lanes::splat(0.3)].into(), &[Lanes::splat(0.0)].into(), Lanes::splat(0.0));
/// assert!((qdd[0].to_array()[1] + 9.81 * 0.3f64.sin()).abs() < 1e-15);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lanes<const L: usize, P = Native, A = Baseline> {
    pack: Pack<L, A>,
    of: PhantomData<fn() -> P>,
}

/// One number that is computed as each of [`Lanes`] is, with the same bits: an `f64` whose rounding and elementary functions
/// are those of the policy `P`, on every machine.
///
/// ```
/// use lagrange_runtime::lanes::{Fused, Lane, Lanes};
/// use lagrange_runtime::{Functions, Scalar};
/// let alone = Lane::<Fused>::new(0.7).sin().value();
/// let beside = Lanes::<8, Fused>::splat(0.7).sin().to_array();
/// assert_eq!(beside, [alone; 8]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lane<P = Native, A = Baseline> {
    x: f64,
    of: PhantomData<fn() -> (P, A)>,
}

impl<const L: usize, P, A> Lanes<L, P, A> {
    /// These numbers.
    #[inline(always)]
    pub const fn new(x: [f64; L]) -> Self {
        Lanes { pack: Pack::new(x), of: PhantomData }
    }

    /// `x` in every lane.
    #[inline(always)]
    pub const fn splat(x: f64) -> Self {
        Lanes::new([x; L])
    }

    /// The numbers.
    #[inline(always)]
    pub const fn to_array(self) -> [f64; L] {
        self.pack.x
    }

    /// The numbers, to be changed.
    #[inline(always)]
    pub const fn as_mut(&mut self) -> &mut [f64; L] {
        &mut self.pack.x
    }

    /// The numbers, in place.
    #[inline(always)]
    pub const fn as_array(&self) -> &[f64; L] {
        &self.pack.x
    }

    #[inline(always)]
    fn of(pack: Pack<L, A>) -> Self {
        Lanes { pack, of: PhantomData }
    }
}

impl<P, A> Lane<P, A> {
    /// This number.
    #[inline(always)]
    pub const fn new(x: f64) -> Self {
        Lane { x, of: PhantomData }
    }

    /// The number.
    #[inline(always)]
    pub const fn value(self) -> f64 {
        self.x
    }
}

impl<const L: usize, P: Policy, A: Processor> Lanes<L, P, A> {
    /// Whether no number is infinite or NaN.
    #[inline(always)]
    pub(crate) fn all_finite(self) -> bool {
        let zero = Pack::splat(0.0);
        (self.pack * zero).equal(zero).all()
    }

    /// Whether none is ≥ 0. (A NaN is not.)
    #[inline(always)]
    pub(crate) fn nowhere_positive_or_zero(self) -> bool {
        Pack::splat(0.0).less_equal(self.pack).xor(Pack::bits(u64::MAX)).all()
    }
}

macro_rules! operators {
    ($($trait:ident $method:ident $assign:ident $assign_method:ident $op:tt)*) => {$(
        impl<const L: usize, P: Policy, A: Processor> $trait for Lanes<L, P, A> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, o: Self) -> Self {
                Lanes::of(self.pack $op o.pack)
            }
        }

        impl<const L: usize, P: Policy, A: Processor> $assign for Lanes<L, P, A> {
            #[inline(always)]
            fn $assign_method(&mut self, o: Self) {
                *self = *self $op o;
            }
        }

        impl<P: Policy, A: Processor> $trait for Lane<P, A> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, o: Self) -> Self {
                Lane::new(self.x $op o.x)
            }
        }

        impl<P: Policy, A: Processor> $assign for Lane<P, A> {
            #[inline(always)]
            fn $assign_method(&mut self, o: Self) {
                *self = *self $op o;
            }
        }
    )*};
}

operators! {
    Add add AddAssign add_assign +
    Sub sub SubAssign sub_assign -
    Mul mul MulAssign mul_assign *
    Div div DivAssign div_assign /
}

impl<const L: usize, P: Policy, A: Processor> Neg for Lanes<L, P, A> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Lanes::of(-self.pack)
    }
}

impl<P: Policy, A: Processor> Neg for Lane<P, A> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Lane::new(-self.x)
    }
}

/// Where a comparison holds.
#[inline(always)]
fn holds<V: Vector>(comparison: Comparison, a: V, b: V) -> V {
    match comparison {
        Comparison::Less => a.less(b),
        Comparison::LessEqual => a.less_equal(b),
        Comparison::Equal => a.equal(b),
    }
}

impl<const L: usize, P: Policy, A: Processor> Scalar for Lanes<L, P, A> {
    #[inline(always)]
    fn from_f64(x: f64) -> Self {
        Lanes::splat(x)
    }

    #[inline(always)]
    fn mul_add(self, a: Self, b: Self) -> Self {
        Lanes::of(P::mul_add(self.pack, a.pack, b.pack))
    }

    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        let (sin, cos) = functions::sin_cos::<P, _>(self.pack);
        (Lanes::of(sin), Lanes::of(cos))
    }

    // No closures: in lanes one that is not inlined is compiled for the baseline.
    #[inline(always)]
    fn sin_cos_array<const K: usize>(x: [Self; K]) -> ([Self; K], [Self; K]) {
        let (mut sin, mut cos) = (x, x);
        for k in 0..K {
            (sin[k], cos[k]) = x[k].sin_cos();
        }
        (sin, cos)
    }

    #[inline(always)]
    fn evaluate<W: Work>(work: W) -> W::Output {
        A::call(work)
    }

    #[inline(always)]
    fn select(comparison: Comparison, a: Self, b: Self, yes: Self, no: Self) -> Self {
        Lanes::of(holds(comparison, a.pack, b.pack).select(yes.pack, no.pack))
    }
}

impl<P: Policy, A: Processor> Scalar for Lane<P, A> {
    #[inline(always)]
    fn from_f64(x: f64) -> Self {
        Lane::new(x)
    }

    #[inline(always)]
    fn mul_add(self, a: Self, b: Self) -> Self {
        Lane::new(P::mul_add(self.x, a.x, b.x))
    }

    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        let (sin, cos) = functions::sin_cos::<P, _>(self.x);
        (Lane::new(sin), Lane::new(cos))
    }

    #[inline(always)]
    fn evaluate<W: Work>(work: W) -> W::Output {
        A::call(work)
    }

    #[inline(always)]
    fn select(comparison: Comparison, a: Self, b: Self, yes: Self, no: Self) -> Self {
        Lane::new(holds(comparison, a.x, b.x).select(yes.x, no.x))
    }
}

impl<P: Policy, A: Processor> PartialOrd for Lane<P, A> {
    #[inline(always)]
    fn partial_cmp(&self, o: &Self) -> Option<Ordering> {
        self.x.partial_cmp(&o.x)
    }
}

impl<P: Policy, A: Processor> Real for Lane<P, A> {
    const EPSILON: f64 = f64::EPSILON;

    #[inline(always)]
    fn to_f64(self) -> f64 {
        self.x
    }
}

macro_rules! functions {
    ($($name:ident($x:ident $(, $more:ident)*) = $f64:ident, $libm:ident, $doc:literal;
       [$($derivative:expr),*])*) => {
        impl<const L: usize, P: Policy, A: Processor> Functions for Lanes<L, P, A> {
            $(
                #[inline(always)]
                fn $name(self $(, $more: Self)*) -> Self {
                    Lanes::of(VectorFunctions::<P>::$name(self.pack $(, $more.pack)*))
                }
            )*
        }

        impl<P: Policy, A: Processor> Functions for Lane<P, A> {
            $(
                #[inline(always)]
                fn $name(self $(, $more: Self)*) -> Self {
                    Lane::new(VectorFunctions::<P>::$name(self.x $(, $more.x)*))
                }
            )*
        }
    };
}

lagrange_macros::lagrangian! { @functions functions }
