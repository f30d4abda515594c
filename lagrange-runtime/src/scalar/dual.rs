//! Dual numbers: a value and its derivative along one direction (Clifford 1873; Griewank and Walther, *Evaluating
//! Derivatives*, 2008, ch. 3). `f(x + ε) = f(x) + f′(x) ε` with `ε² = 0`.

use super::{Comparison, Functions, Real, Scalar, real_case_of_parts};
use core::cmp::Ordering;
use core::fmt;
use core::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};

/// `value + slope·ε` with `ε² = 0`. Put `Dual::variable(x)` into a parameter or a coordinate and read the derivative
/// of whatever comes out in its `slope`. Duals nest: `Dual<Dual<f64>>` carries second derivatives.
///
/// ```
/// use lagrange_runtime::{Dual, Functions};
/// let y = Dual::variable(0.5).sin();
/// assert_eq!((y.value, y.slope), (0.5f64.sin(), 0.5f64.cos()));
/// ```
#[derive(Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(bound(
        serialize = "S: crate::Scalar + serde::Serialize",
        deserialize = "S: crate::Scalar + serde::Deserialize<'de>"
    ))
)]
pub struct Dual<S> {
    /// The value.
    pub value: S,
    /// The derivative.
    pub slope: S,
}

/// Prints `0.5 + 1.0 ε`.
impl<S: fmt::Debug> fmt::Debug for Dual<S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?} + {:?} ε", self.value, self.slope)
    }
}

impl<S: Scalar> Dual<S> {
    /// The independent variable at `value`: slope 1.
    #[inline]
    pub fn variable(value: S) -> Self {
        Dual { value, slope: S::one() }
    }

    /// A number that does not change: slope 0.
    #[inline]
    pub fn constant(value: S) -> Self {
        Dual { value, slope: S::zero() }
    }
}

impl<S: Scalar> Add for Dual<S> {
    type Output = Self;
    #[inline]
    fn add(self, o: Self) -> Self {
        Dual { value: self.value + o.value, slope: self.slope + o.slope }
    }
}

impl<S: Scalar> Sub for Dual<S> {
    type Output = Self;
    #[inline]
    fn sub(self, o: Self) -> Self {
        Dual { value: self.value - o.value, slope: self.slope - o.slope }
    }
}

impl<S: Scalar> Mul for Dual<S> {
    type Output = Self;
    #[inline]
    fn mul(self, o: Self) -> Self {
        Dual { value: self.value * o.value, slope: self.slope * o.value + self.value * o.slope }
    }
}

impl<S: Scalar> Div for Dual<S> {
    type Output = Self;
    #[inline]
    fn div(self, o: Self) -> Self {
        let value = self.value / o.value;
        Dual { value, slope: (self.slope - value * o.slope) / o.value }
    }
}

impl<S: Scalar> Neg for Dual<S> {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        Dual { value: -self.value, slope: -self.slope }
    }
}

macro_rules! assign {
    ($($trait:ident $method:ident $op:tt)*) => {$(
        impl<S: Scalar> $trait for Dual<S> {
            #[inline]
            fn $method(&mut self, o: Self) {
                *self = *self $op o;
            }
        }
    )*};
}

assign! { AddAssign add_assign +  SubAssign sub_assign -  MulAssign mul_assign *  DivAssign div_assign / }

/// Ordered by value: a decision is made for the trajectory, not for its derivative.
impl<S: Scalar + PartialOrd> PartialOrd for Dual<S> {
    #[inline]
    fn partial_cmp(&self, o: &Self) -> Option<Ordering> {
        self.value.partial_cmp(&o.value)
    }
}

impl<S: Scalar> Scalar for Dual<S> {
    type Pair = [Self; 2];

    real_case_of_parts! { Dual<S> }

    #[inline]
    fn from_f64(x: f64) -> Self {
        Dual::constant(S::from_f64(x))
    }

    #[inline]
    fn from_sum(x: f64, rest: f64) -> Self {
        Dual::constant(S::from_sum(x, rest))
    }

    #[inline]
    fn mul_add(self, a: Self, b: Self) -> Self {
        Dual {
            value: self.value.mul_add(a.value, b.value),
            slope: self.slope.mul_add(a.value, self.value.mul_add(a.slope, b.slope)),
        }
    }

    #[inline]
    fn sin_cos(self) -> (Self, Self) {
        let (s, c) = self.value.sin_cos();
        (Dual { value: s, slope: self.slope * c }, Dual { value: c, slope: -self.slope * s })
    }

    #[inline]
    fn sin_cos_array<const K: usize>(x: [Self; K]) -> ([Self; K], [Self; K]) {
        let (s, c) = S::sin_cos_array(x.map(|x| x.value));
        (
            core::array::from_fn(|i| Dual { value: s[i], slope: x[i].slope * c[i] }),
            core::array::from_fn(|i| Dual { value: c[i], slope: -x[i].slope * s[i] }),
        )
    }

    #[inline]
    fn lookup<const A: usize, const K: usize>(
        x: [Self; A],
        f: impl FnMut(usize, [f64; A]) -> [f64; K],
    ) -> [Self; K] {
        S::lookup(x.map(|x| x.value), f).map(Dual::constant)
    }

    #[inline]
    fn select(comparison: Comparison, a: Self, b: Self, yes: Self, no: Self) -> Self {
        Dual {
            value: S::select(comparison, a.value, b.value, yes.value, no.value),
            slope: S::select(comparison, a.value, b.value, yes.slope, no.slope),
        }
    }
}

impl<S: Real> Real for Dual<S> {
    const SLOPES: usize = 1;
    const EPSILON: f64 = S::EPSILON;

    #[inline]
    fn to_f64(self) -> f64 {
        self.value.to_f64()
    }

    #[inline]
    fn magnitude(self) -> f64 {
        self.value.magnitude().max(self.slope.magnitude())
    }

    #[inline]
    fn slope(self, _: usize) -> f64 {
        self.slope.to_f64()
    }

    #[inline]
    fn infinitesimal(self) -> Self {
        Dual { value: self.value.infinitesimal(), slope: self.slope }
    }
}

/// `Σ ∂f/∂xᵢ · slopeᵢ`. An argument that does not change, in any of its nested parts, contributes nothing, even where
/// its partial derivative is infinite: `√0` of a constant 0, or `0.powf(2)`, whose partial by the exponent has `ln 0`.
#[inline]
pub(super) fn chain<S: Scalar, const K: usize>(slopes: [S; K], partials: [S; K]) -> S {
    let mut total = S::zero();
    for (slope, partial) in slopes.into_iter().zip(partials) {
        if slope != S::zero() {
            total += slope * partial;
        }
    }
    total
}

macro_rules! dual_functions {
    ($($name:ident($x:ident $(, $more:ident)*) = $f64:ident, $libm:ident, $doc:literal;
       [$($derivative:expr),*])*) => {
        // The derivatives are the table's own tokens, where constants are decimal numbers.
        #[allow(clippy::approx_constant)]
        impl<S: Scalar> Functions for Dual<S> {
            $(
                #[inline]
                fn $name(self $(, $more: Self)*) -> Self {
                    let slopes = [self.slope $(, $more.slope)*];
                    let $x = self.value;
                    $(let $more = $more.value;)*
                    Dual { value: $x.$name($($more),*), slope: chain(slopes, [$($derivative),*]) }
                }
            )*
        }
    };
}

lagrange_macros::lagrangian! { @functions dual_functions }
