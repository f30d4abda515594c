//! The two scalars that compute under a [`Policy`]: [`SingleLane`], one number, and [`Lanes`], several.

use super::functions::PackFunctions;
use super::pack::Pack;
use super::policy::{Native, Policy};
use super::processor::{Baseline, Processor, Work};
use crate::scalar::{Comparison, Functions, Real, Scalar, SimdScalar};
use core::cmp::Ordering;
use core::marker::PhantomData;
use core::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};

/// `L` numbers side by side, as one [`Scalar`]: a system over lanes is `L` systems, each with its own state, time,
/// step and parameters. `P` says how they are rounded, `A` for which processor they are compiled; the bits depend on
/// `P` alone.
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
    pack: Pack<L>,
    of: PhantomData<fn() -> (P, A)>,
}

/// One number that is computed as each of [`Lanes`] is, with the same bits: an `f64` whose rounding and elementary
/// functions are those of the policy `P`, on every machine.
///
/// ```
/// use lagrange_runtime::lanes::{Fused, SingleLane, Lanes};
/// use lagrange_runtime::{Functions, Scalar};
/// let alone = SingleLane::<Fused>::new(0.7).sin().value();
/// let beside = Lanes::<8, Fused>::splat(0.7).sin().to_array();
/// assert_eq!(beside, [alone; 8]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SingleLane<P = Native, A = Baseline> {
    x: f64,
    of: PhantomData<fn() -> (P, A)>,
}

impl<const L: usize, P, A> Lanes<L, P, A> {
    /// These numbers.
    #[inline(always)]
    pub const fn new(x: [f64; L]) -> Self {
        Lanes { pack: Pack(x), of: PhantomData }
    }

    /// `x` in every lane.
    #[inline(always)]
    pub const fn splat(x: f64) -> Self {
        Lanes::new([x; L])
    }

    /// The numbers.
    #[inline(always)]
    pub const fn to_array(self) -> [f64; L] {
        self.pack.0
    }

    /// The numbers, to be changed.
    #[inline(always)]
    pub const fn as_mut(&mut self) -> &mut [f64; L] {
        &mut self.pack.0
    }

    /// The numbers, in place.
    #[inline(always)]
    pub const fn as_array(&self) -> &[f64; L] {
        &self.pack.0
    }

    #[inline(always)]
    fn of(pack: Pack<L>) -> Self {
        Lanes { pack, of: PhantomData }
    }
}

impl<P, A> SingleLane<P, A> {
    /// This number.
    #[inline(always)]
    pub const fn new(x: f64) -> Self {
        SingleLane { x, of: PhantomData }
    }

    /// The number.
    #[inline(always)]
    pub const fn value(self) -> f64 {
        self.x
    }

    #[inline(always)]
    fn of(Pack([x]): Pack<1>) -> Self {
        SingleLane::new(x)
    }

    #[inline(always)]
    fn pack(self) -> Pack<1> {
        Pack([self.x])
    }
}

macro_rules! operators {
    ($($trait:ident $method:ident $assign:ident $assign_method:ident $op:tt)*) => {$(
        impl<const L: usize, P: Policy, A: Processor> $trait for Lanes<L, P, A> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, o: Self) -> Self {
                let mut x = [0.0; L];
                for i in 0..L {
                    x[i] = self.pack.0[i] $op o.pack.0[i];
                }
                Lanes::new(x)
            }
        }

        impl<const L: usize, P: Policy, A: Processor> $assign for Lanes<L, P, A> {
            #[inline(always)]
            fn $assign_method(&mut self, o: Self) {
                *self = *self $op o;
            }
        }

        impl<P: Policy, A: Processor> $trait for SingleLane<P, A> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, o: Self) -> Self {
                SingleLane::new(self.x $op o.x)
            }
        }

        impl<P: Policy, A: Processor> $assign for SingleLane<P, A> {
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
        let mut x = [0.0; L];
        for i in 0..L {
            x[i] = -self.pack.0[i];
        }
        Lanes::new(x)
    }
}

impl<P: Policy, A: Processor> Neg for SingleLane<P, A> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        SingleLane::new(-self.x)
    }
}

#[inline(always)]
fn holds(comparison: Comparison, a: f64, b: f64) -> bool {
    match comparison {
        Comparison::Less => a < b,
        Comparison::LessEqual => a <= b,
        Comparison::Equal => a == b,
    }
}

impl<const L: usize, P: Policy, A: Processor> Scalar for Lanes<L, P, A> {
    type Pair = [Self; 2];
    const WIDE: bool = true;
    const FUSED: bool = P::FUSED;

    #[inline(always)]
    fn from_f64(x: f64) -> Self {
        Lanes::splat(x)
    }

    #[inline(always)]
    fn mul_add(self, a: Self, b: Self) -> Self {
        let mut x = [0.0; L];
        for i in 0..L {
            x[i] = P::mul_add(self.pack.0[i], a.pack.0[i], b.pack.0[i]);
        }
        Lanes::new(x)
    }

    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        let (sin, cos) = self.pack.sin_cos::<P>();
        (Lanes::of(sin), Lanes::of(cos))
    }

    #[inline(always)]
    fn evaluate<W: Work>(work: W) -> W::Output {
        A::call(work)
    }

    #[inline(always)]
    fn lookup<const N: usize, const K: usize>(
        x: [Self; N],
        mut f: impl FnMut(usize, [f64; N]) -> [f64; K],
    ) -> [Self; K] {
        let mut found = [[0.0; L]; K];
        for i in 0..L {
            let of_lane = f(i, x.map(|x| x.pack.0[i]));
            for k in 0..K {
                found[k][i] = of_lane[k];
            }
        }
        found.map(Lanes::new)
    }

    #[inline(always)]
    fn select(comparison: Comparison, a: Self, b: Self, yes: Self, no: Self) -> Self {
        let mut x = [0.0; L];
        for i in 0..L {
            x[i] = if holds(comparison, a.pack.0[i], b.pack.0[i]) { yes.pack.0[i] } else { no.pack.0[i] };
        }
        Lanes::new(x)
    }
}

impl<P: Policy, A: Processor> Scalar for SingleLane<P, A> {
    type Pair = [Self; 2];
    /// It computes as a vector does.
    const WIDE: bool = true;
    const FUSED: bool = P::FUSED;

    #[inline(always)]
    fn from_f64(x: f64) -> Self {
        SingleLane::new(x)
    }

    #[inline(always)]
    fn mul_add(self, a: Self, b: Self) -> Self {
        SingleLane::new(P::mul_add(self.x, a.x, b.x))
    }

    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        let (sin, cos) = self.pack().sin_cos::<P>();
        (SingleLane::of(sin), SingleLane::of(cos))
    }

    #[inline(always)]
    fn evaluate<W: Work>(work: W) -> W::Output {
        A::call(work)
    }

    #[inline(always)]
    fn lookup<const N: usize, const K: usize>(
        x: [Self; N],
        mut f: impl FnMut(usize, [f64; N]) -> [f64; K],
    ) -> [Self; K] {
        f(0, x.map(|x| x.x)).map(SingleLane::new)
    }

    #[inline(always)]
    fn select(comparison: Comparison, a: Self, b: Self, yes: Self, no: Self) -> Self {
        if holds(comparison, a.x, b.x) { yes } else { no }
    }
}

impl<P: Policy, A: Processor> PartialOrd for SingleLane<P, A> {
    #[inline(always)]
    fn partial_cmp(&self, o: &Self) -> Option<Ordering> {
        self.x.partial_cmp(&o.x)
    }
}

impl<const L: usize, P: Policy, A: Processor> SimdScalar for Lanes<L, P, A> {
    type Element = SingleLane<P, A>;
    type PerLane<T> = [T; L];
    type Sizes = Self;

    const COUNT: usize = L;

    #[inline(always)]
    fn each<T>(f: impl FnMut(usize) -> T) -> [T; L] {
        core::array::from_fn(f)
    }

    #[inline(always)]
    fn of(mut numbers: impl FnMut(usize) -> SingleLane<P, A>) -> Self {
        Lanes::new(core::array::from_fn(|i| numbers(i).value()))
    }

    #[inline(always)]
    fn number(self, place: usize) -> SingleLane<P, A> {
        SingleLane::new(self.pack.0[place])
    }

    /// The numbers in memory: where the optimiser sees the use of each number, it computes everything before it
    /// number by number, too.
    #[inline(always)]
    fn apart(self) -> [SingleLane<P, A>; L] {
        let mut numbers = self.pack.0;
        core::hint::black_box(&mut numbers);
        let mut lanes = [SingleLane::new(0.0); L];
        for i in 0..L {
            lanes[i] = SingleLane::new(numbers[i]);
        }
        lanes
    }

    #[inline(always)]
    fn magnitudes(self) -> Self {
        self.abs()
    }

    #[inline(always)]
    fn chosen(places: &[bool; L], yes: Self, no: Self) -> Self {
        let mut x = [0.0; L];
        for i in 0..L {
            x[i] = if places[i] { yes.pack.0[i] } else { no.pack.0[i] };
        }
        Lanes::new(x)
    }
}

impl<P: Policy, A: Processor> Real for SingleLane<P, A> {
    const EPSILON: f64 = f64::EPSILON;
    const IN_LANES: bool = true;

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
                    Lanes::of(PackFunctions::<P>::$name(self.pack $(, $more.pack)*))
                }
            )*
        }

        impl<P: Policy, A: Processor> Functions for SingleLane<P, A> {
            $(
                #[inline(always)]
                fn $name(self $(, $more: Self)*) -> Self {
                    SingleLane::of(PackFunctions::<P>::$name(self.pack() $(, $more.pack())*))
                }
            )*
        }
    };
}

lagrange_macros::lagrangian! { @functions functions }
