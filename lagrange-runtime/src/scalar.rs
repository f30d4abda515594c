//! The numbers that emitted code computes with.

use crate::lanes::Work;
use core::fmt::Debug;
use core::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};

pub(crate) mod double_double;
mod dual;
mod gradient;
mod row;

pub use double_double::DoubleDouble;
pub use dual::Dual;
pub use gradient::Gradient;
pub use row::SimdRow;

/// A comparison of two scalars, the condition of a [`Scalar::select`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Comparison {
    /// `a < b`
    Less,
    /// `a <= b`
    LessEqual,
    /// `a == b`
    Equal,
}

/// A number, or a pack of numbers treated alike, that emitted code can compute with: `f32`, `f64`, [`DoubleDouble`],
/// [`Dual`], [`Gradient`].
///
/// The elementary functions (`sin`, `exp`, `atan2`, …) are generated from the compiler's function table, so the
/// language and its numbers cannot disagree about what exists.
pub trait Scalar:
    Copy
    + Debug
    + PartialEq
    + Send
    + Sync
    + 'static
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
    + MulAssign
    + DivAssign
    + Functions
{
    /// Two of them side by side, as sums of products of series are formed: `[Self; 2]`, or a register that holds two.
    type Pair: SimdRow<Elements = [Self; 2]>;

    /// Is it a vector of numbers, so that operations on it need no others beside them to make use of the processor?
    const WIDE: bool = false;

    /// Does [`mul_add`](Self::mul_add) round once?
    const FUSED: bool = cfg!(all(target_feature = "fma", feature = "std"));

    /// The number nearest to `x`, in every lane.
    fn from_f64(x: f64) -> Self;

    /// The number nearest to `x + rest`, where `x` is the `f64` nearest to this sum: a constant such as 1/3, for
    /// numbers that have more digits than `f64`. The others leave `rest` out.
    ///
    /// ```
    /// use lagrange_runtime::{DoubleDouble, Scalar};
    /// let third = DoubleDouble::from_sum(1.0 / 3.0, 1.850371707708594e-17);
    /// assert!((third * 3.0 - DoubleDouble::ONE).value().abs() < 1e-32);
    /// assert_eq!(f64::from_sum(1.0 / 3.0, 1.850371707708594e-17), 1.0 / 3.0);
    /// ```
    #[inline(always)]
    fn from_sum(x: f64, rest: f64) -> Self {
        let _ = rest;
        Self::from_f64(x)
    }

    /// `self * a + b`: one rounding where the target has a fused instruction, two where it has not. The software
    /// fallback, which is exact and slow, is never used.
    fn mul_add(self, a: Self, b: Self) -> Self;

    /// Sine and cosine of one argument.
    #[inline]
    fn sin_cos(self) -> (Self, Self) {
        (self.sin(), self.cos())
    }

    /// Sines and cosines of several arguments. For `f64` they come of one call of a kernel with vector instructions,
    /// where that is quicker, within 1 ULP.
    ///
    /// ```
    /// use lagrange_runtime::Scalar;
    /// let (sin, cos) = f64::sin_cos_array([0.0, 0.5, 1.0, 1.5]);
    /// assert!((sin[1] - 0.5f64.sin()).abs() <= f64::EPSILON / 2.0);
    /// assert_eq!(cos[0], 1.0);
    /// ```
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn sin_cos_array<const K: usize>(x: [Self; K]) -> ([Self; K], [Self; K]) {
        // No closures, which would not be inlined, and lanes have them compiled for the least processor then.
        let (mut sin, mut cos) = (x, x);
        for k in 0..K {
            (sin[k], cos[k]) = x[k].sin_cos();
        }
        (sin, cos)
    }

    /// Does the work with the vector instructions that the type stands for. Emitted accelerations are computed in
    /// here, so that lanes have theirs compiled for the processor, see [`lanes`](crate::lanes).
    #[inline(always)]
    fn evaluate<W: Work>(work: W) -> W::Output {
        work.run()
    }

    /// Does work that takes so long that a call is nothing beside it, such as a Taylor series: with the best vector
    /// instructions that the processor has, also for `f64`. No bit of the result depends on which these are.
    #[inline(always)]
    fn evaluate_long<W: Work>(work: W) -> W::Output {
        Self::evaluate(work)
    }

    /// K numbers that `f` finds by the values of `x`, such as the coefficients of the piece of a table that holds
    /// there: for each lane, by its index and its values. Derivatives of x do not reach them.
    fn lookup<const A: usize, const K: usize>(
        x: [Self; A],
        f: impl FnMut(usize, [f64; A]) -> [f64; K],
    ) -> [Self; K];

    /// `if a ∘ b { yes } else { no }` for the comparison ∘, decided in each lane. Both branches have been computed.
    fn select(comparison: Comparison, a: Self, b: Self, yes: Self, no: Self) -> Self;

    /// Computes in the way that is there for a [`Real`] if this is one, and is not computed in lanes.
    #[doc(hidden)]
    #[inline]
    fn by_case<C: RealCase<Self>>(case: C) -> C::Output {
        case.any()
    }

    /// 0.
    #[inline]
    fn zero() -> Self {
        Self::from_f64(0.0)
    }

    /// 1.
    #[inline]
    fn one() -> Self {
        Self::from_f64(1.0)
    }
}

/// A computation that differs between a [`Real`] and lanes: see [`Scalar::by_case`].
pub trait RealCase<S: Scalar> {
    /// The result of both.
    type Output;

    /// The computation for a scalar that can be compared.
    fn real(self) -> Self::Output
    where
        S: Real;

    /// The computation for any scalar.
    fn any(self) -> Self::Output;
}

/// [`Scalar::by_case`] of a [`Real`] that is not computed in lanes.
macro_rules! real_case {
    () => {
        #[inline]
        fn by_case<C: $crate::scalar::RealCase<Self>>(case: C) -> C::Output {
            case.real()
        }
    };
}
pub(crate) use real_case;

/// [`Scalar::by_case`] of a number that is made of others: it is a [`Real`] where they are.
macro_rules! real_case_of_parts {
    ($number:ident<$S:ident $(, $D:ident)?>) => {
        #[inline]
        fn by_case<C: $crate::scalar::RealCase<Self>>(case: C) -> C::Output {
            struct OfParts<C $(, const $D: usize)?>(C);

            impl<$S: Scalar, C: $crate::scalar::RealCase<$number<$S $(, $D)?>> $(, const $D: usize)?>
                $crate::scalar::RealCase<$S> for OfParts<C $(, $D)?>
            {
                type Output = C::Output;

                fn real(self) -> C::Output
                where
                    $S: Real,
                {
                    self.0.real()
                }

                fn any(self) -> C::Output {
                    self.0.any()
                }
            }

            $S::by_case(OfParts::<C $(, $D)?>(case))
        }
    };
}
pub(crate) use real_case_of_parts;

/// A scalar that is one ordered number: the time of an adaptive run and whatever has to be compared.
pub trait Real: Scalar + PartialOrd {
    /// The value, as used for decisions (of a [`Dual`]: its value, not its slope).
    fn to_f64(self) -> f64;
    /// The largest absolute value of the parts of a scalar: of a [`Dual`], of value and slope. An iteration that has to
    /// converge in its derivatives, too, tests this value.
    #[inline]
    fn magnitude(self) -> f64 {
        self.to_f64().abs()
    }
    /// The slopes of a [`Dual`] or [`Gradient`], with the value 0; 0 for numbers without slopes.
    #[inline]
    fn infinitesimal(self) -> Self {
        Self::zero()
    }
    /// Number of slopes that it carries.
    const SLOPES: usize = 0;
    /// The slope with this index.
    #[inline]
    fn slope(self, _: usize) -> f64 {
        0.0
    }
    /// The distance from 1 to the next larger number.
    const EPSILON: f64;
    /// Is it one of several numbers side by side, whose runs do what they do together alone?
    #[doc(hidden)]
    const IN_LANES: bool = false;
}

/// A scalar whose lanes can be compared: a [`Real`], which has one, or [`Lanes`](crate::lanes::Lanes). Iterations
/// compute with such scalars: each lane converges on its own, and stays unchanged until all lanes have.
pub trait SimdScalar: Scalar {
    /// The scalar of one lane.
    type Element: Real;
    /// A value for each lane.
    type PerLane<T>: AsRef<[T]> + AsMut<[T]>;
    /// Magnitudes, an `f64` for each lane.
    type Sizes: SimdScalar;

    /// Number of lanes.
    const COUNT: usize;

    /// Values of `f` by the index of each lane.
    fn each<T>(f: impl FnMut(usize) -> T) -> Self::PerLane<T>;

    /// Packs the values of `numbers`, one for each lane.
    fn of(numbers: impl FnMut(usize) -> Self::Element) -> Self;

    /// The value of one lane.
    fn number(self, place: usize) -> Self::Element;

    /// The values of all lanes.
    fn apart(self) -> Self::PerLane<Self::Element>;

    /// Magnitude of each lane, see [`Real::magnitude`].
    fn magnitudes(self) -> Self::Sizes;

    /// Selects the lanes of `yes` where the mask is true, and those of `no` elsewhere.
    fn chosen(places: &Self::PerLane<bool>, yes: Self, no: Self) -> Self;
}

impl<S: Real> SimdScalar for S {
    type Element = S;
    type PerLane<T> = [T; 1];
    type Sizes = f64;

    const COUNT: usize = 1;

    #[inline(always)]
    fn each<T>(mut f: impl FnMut(usize) -> T) -> [T; 1] {
        [f(0)]
    }

    #[inline(always)]
    fn of(mut numbers: impl FnMut(usize) -> S) -> S {
        numbers(0)
    }

    #[inline(always)]
    fn number(self, _: usize) -> S {
        self
    }

    #[inline(always)]
    fn apart(self) -> [S; 1] {
        [self]
    }

    #[inline(always)]
    fn magnitudes(self) -> f64 {
        self.magnitude()
    }

    #[inline(always)]
    fn chosen(places: &[bool; 1], yes: S, no: S) -> S {
        if places[0] { yes } else { no }
    }
}

/// Functions that the table names and the `libm` crate lacks.
#[cfg(not(feature = "std"))]
mod libm {
    pub use ::libm::*;

    pub fn copysign_one(x: f64) -> f64 {
        if x.is_nan() { x } else { copysign(1.0, x) }
    }
}

macro_rules! functions_trait {
    ($($name:ident($x:ident $(, $more:ident)*) = $f64:ident, $libm:ident, $doc:literal;
       [$($derivative:expr),*])*) => {
        /// The elementary functions of the language, one per row of the compiler's function table.
        pub trait Functions: Sized {
            $(
                #[doc = $doc]
                fn $name(self $(, $more: Self)*) -> Self;
            )*
        }

        impl Functions for f64 {
            $(
                #[inline]
                fn $name(self $(, $more: f64)*) -> f64 {
                    #[cfg(feature = "std")]
                    { f64::$f64(self $(, $more)*) }
                    #[cfg(not(feature = "std"))]
                    { libm::$libm(self $(, $more)*) }
                }
            )*
        }

        impl Functions for f32 {
            $(
                #[inline]
                fn $name(self $(, $more: f32)*) -> f32 {
                    #[cfg(feature = "std")]
                    { f32::$f64(self $(, $more)*) }
                    #[cfg(not(feature = "std"))]
                    { libm::$libm(f64::from(self) $(, f64::from($more))*) as f32 }
                }
            )*
        }
    };
}

lagrange_macros::lagrangian! { @functions functions_trait }

macro_rules! float {
    ($float:ident $($own:item)*) => {
        impl Scalar for $float {
            $($own)*

            real_case! {}

            #[inline]
            fn from_f64(x: f64) -> Self {
                x as $float
            }

            #[inline]
            fn mul_add(self, a: Self, b: Self) -> Self {
                #[cfg(all(target_feature = "fma", feature = "std"))]
                {
                    $float::mul_add(self, a, b)
                }
                #[cfg(not(all(target_feature = "fma", feature = "std")))]
                {
                    self * a + b
                }
            }

            #[inline]
            fn sin_cos(self) -> (Self, Self) {
                #[cfg(feature = "std")]
                {
                    $float::sin_cos(self)
                }
                #[cfg(not(feature = "std"))]
                {
                    (self.sin(), self.cos())
                }
            }

            #[inline]
            fn lookup<const A: usize, const K: usize>(
                x: [Self; A],
                mut f: impl FnMut(usize, [f64; A]) -> [f64; K],
            ) -> [Self; K] {
                f(0, x.map(f64::from)).map(Self::from_f64)
            }

            #[inline]
            fn select(comparison: Comparison, a: Self, b: Self, yes: Self, no: Self) -> Self {
                let holds = match comparison {
                    Comparison::Less => a < b,
                    Comparison::LessEqual => a <= b,
                    Comparison::Equal => a == b,
                };
                if holds { yes } else { no }
            }
        }

        impl Real for $float {
            const EPSILON: f64 = $float::EPSILON as f64;

            #[inline]
            fn to_f64(self) -> f64 {
                f64::from(self)
            }
        }
    };
}

float! {
    f32
    type Pair = [f32; 2];
}
float! {
    f64
    type Pair = crate::lanes::Pair;

    // The values are to stay in registers; where there are many it is a call within.
    #[inline(always)]
    fn sin_cos_array<const K: usize>(x: [Self; K]) -> ([Self; K], [Self; K]) {
        crate::lanes::sin_cos_array(x)
    }

    #[inline(always)]
    fn evaluate_long<W: Work>(work: W) -> W::Output {
        // Not those of AVX-512: measured, they gain nothing here, and it would all be compiled once more.
        crate::lanes::Level::call_up_to_avx2(work)
    }
}
