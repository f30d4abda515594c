//! A value and its derivatives along several directions (Griewank and Walther, *Evaluating Derivatives*, 2008, ch.
//! 3): what [`Dual`](super::Dual) is for one, at the price of one value for all of them.

use super::{Comparison, Functions, Real, Scalar, real_case_of_parts};
use crate::lanes::Work;
use core::cmp::Ordering;
use core::fmt;
use core::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};

/// `value + Σ slopes·ε` with `ε² = 0`, along D directions: by the start of a motion, or by parameters.
///
/// Taylor series of such numbers are those of the variational equations, and steps are as long as these allow.
///
/// ```
/// use lagrange_runtime::prelude::*;
/// use lagrange_runtime::Gradient;
///
/// lagrangian! {
///     system Oscillator {
///         param k;
///         coord x;
///         T = 0.5 * dot(x).powi(2);
///         V = 0.5 * k * x * x;
///     }
/// }
/// // By x, by ẋ and by k at the start.
/// let [x, xd, k] = Gradient::variables([0.3, 0.0, 4.0]);
/// let start = State::new(Gradient::constant(0.0), [x], [xd]);
/// let system = Oscillator { k };
/// let run = integrate(&system, Taylor, TaylorController::tolerance(1e-15), start);
/// let end = run.until(Gradient::constant(1.0)).final_state()?;
/// let [by_x, by_xd, by_k] = end.q[0].slopes;
/// assert!((by_x - 2f64.cos()).abs() < 1e-14 && (by_xd - 2f64.sin() / 2.0).abs() < 1e-14);
/// assert!((by_k + 0.3 * 2f64.sin() / 4.0).abs() < 1e-14);
/// # Ok::<(), Box<dyn core::error::Error>>(())
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
pub struct Gradient<S, const D: usize> {
    /// The value.
    pub value: S,
    /// The derivatives.
    #[cfg_attr(feature = "serde", serde(with = "crate::saved::array"))]
    pub slopes: [S; D],
}

/// Prints `0.5 + [1.0, 0.0] ε`.
impl<S: fmt::Debug, const D: usize> fmt::Debug for Gradient<S, D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?} + {:?} ε", self.value, self.slopes)
    }
}

impl<S: Scalar, const D: usize> Gradient<S, D> {
    /// Independent variables with these values, each of which is a direction.
    #[inline]
    pub fn variables(values: [S; D]) -> [Self; D] {
        core::array::from_fn(|i| {
            let mut variable = Gradient::constant(values[i]);
            variable.slopes[i] = S::one();
            variable
        })
    }

    /// A number that does not change.
    #[inline]
    pub fn constant(value: S) -> Self {
        Gradient { value, slopes: [S::zero(); D] }
    }

    /// `value`, with slopes from those of one or two numbers.
    #[inline(always)]
    fn with(value: S, slope: impl Fn(usize) -> S) -> Self {
        let mut slopes = [S::zero(); D];
        for d in 0..D {
            slopes[d] = slope(d);
        }
        Gradient { value, slopes }
    }
}

impl<S: Scalar, const D: usize> Add for Gradient<S, D> {
    type Output = Self;
    #[inline]
    fn add(self, o: Self) -> Self {
        Gradient::with(self.value + o.value, |d| self.slopes[d] + o.slopes[d])
    }
}

impl<S: Scalar, const D: usize> Sub for Gradient<S, D> {
    type Output = Self;
    #[inline]
    fn sub(self, o: Self) -> Self {
        Gradient::with(self.value - o.value, |d| self.slopes[d] - o.slopes[d])
    }
}

impl<S: Scalar, const D: usize> Mul for Gradient<S, D> {
    type Output = Self;
    #[inline]
    fn mul(self, o: Self) -> Self {
        Gradient::with(self.value * o.value, |d| self.slopes[d].mul_add(o.value, self.value * o.slopes[d]))
    }
}

impl<S: Scalar, const D: usize> Div for Gradient<S, D> {
    type Output = Self;
    #[inline]
    #[allow(clippy::suspicious_arithmetic_impl, reason = "the rule of quotients: (a/b)' = (a' − (a/b) b')/b")]
    fn div(self, o: Self) -> Self {
        let value = self.value / o.value;
        Gradient::with(value, |d| (self.slopes[d] - value * o.slopes[d]) / o.value)
    }
}

impl<S: Scalar, const D: usize> Neg for Gradient<S, D> {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        Gradient::with(-self.value, |d| -self.slopes[d])
    }
}

macro_rules! assign {
    ($($trait:ident $method:ident $op:tt)*) => {$(
        impl<S: Scalar, const D: usize> $trait for Gradient<S, D> {
            #[inline]
            fn $method(&mut self, o: Self) {
                *self = *self $op o;
            }
        }
    )*};
}

assign! { AddAssign add_assign +  SubAssign sub_assign -  MulAssign mul_assign *  DivAssign div_assign / }

/// Ordered by value: a decision is made for the trajectory, not for its derivatives.
impl<S: Scalar + PartialOrd, const D: usize> PartialOrd for Gradient<S, D> {
    #[inline]
    fn partial_cmp(&self, o: &Self) -> Option<Ordering> {
        self.value.partial_cmp(&o.value)
    }
}

impl<S: Scalar, const D: usize> Scalar for Gradient<S, D> {
    type Pair = [Self; 2];
    const WIDE: bool = true;
    const FUSED: bool = S::FUSED;

    real_case_of_parts! { Gradient<S, D> }

    #[inline]
    fn from_f64(x: f64) -> Self {
        Gradient::constant(S::from_f64(x))
    }

    #[inline]
    fn from_sum(x: f64, rest: f64) -> Self {
        Gradient::constant(S::from_sum(x, rest))
    }

    #[inline]
    fn mul_add(self, a: Self, b: Self) -> Self {
        Gradient::with(self.value.mul_add(a.value, b.value), |d| {
            self.slopes[d].mul_add(a.value, self.value.mul_add(a.slopes[d], b.slopes[d]))
        })
    }

    #[inline]
    fn sin_cos(self) -> (Self, Self) {
        let (s, c) = self.value.sin_cos();
        (Gradient::with(s, |d| self.slopes[d] * c), Gradient::with(c, |d| -self.slopes[d] * s))
    }

    #[inline]
    fn sin_cos_array<const K: usize>(x: [Self; K]) -> ([Self; K], [Self; K]) {
        let (s, c) = S::sin_cos_array(x.map(|x| x.value));
        (
            core::array::from_fn(|i| Gradient::with(s[i], |d| x[i].slopes[d] * c[i])),
            core::array::from_fn(|i| Gradient::with(c[i], |d| -x[i].slopes[d] * s[i])),
        )
    }

    #[inline(always)]
    fn evaluate_long<W: Work>(work: W) -> W::Output {
        S::evaluate_long(work)
    }

    #[inline]
    fn lookup<const A: usize, const K: usize>(
        x: [Self; A],
        f: impl FnMut(usize, [f64; A]) -> [f64; K],
    ) -> [Self; K] {
        S::lookup(x.map(|x| x.value), f).map(Gradient::constant)
    }

    #[inline]
    fn select(comparison: Comparison, a: Self, b: Self, yes: Self, no: Self) -> Self {
        let select = |yes, no| S::select(comparison, a.value, b.value, yes, no);
        Gradient::with(select(yes.value, no.value), |d| select(yes.slopes[d], no.slopes[d]))
    }
}

impl<S: Real, const D: usize> Real for Gradient<S, D> {
    const SLOPES: usize = D;
    const EPSILON: f64 = S::EPSILON;

    #[inline]
    fn to_f64(self) -> f64 {
        self.value.to_f64()
    }

    #[inline]
    fn magnitude(self) -> f64 {
        self.slopes.iter().fold(self.value.magnitude(), |most, slope| most.max(slope.magnitude()))
    }

    #[inline]
    fn slope(self, direction: usize) -> f64 {
        self.slopes[direction].to_f64()
    }

    #[inline]
    fn infinitesimal(self) -> Self {
        Gradient { value: self.value.infinitesimal(), slopes: self.slopes }
    }
}

macro_rules! gradient_functions {
    ($($name:ident($x:ident $(, $more:ident)*) = $f64:ident, $libm:ident, $doc:literal;
       [$($derivative:expr),*])*) => {
        // The derivatives are the table's own tokens, where constants are decimal numbers.
        #[allow(clippy::approx_constant)]
        impl<S: Scalar, const D: usize> Functions for Gradient<S, D> {
            $(
                #[inline]
                fn $name(self $(, $more: Self)*) -> Self {
                    let slopes = [self.slopes $(, $more.slopes)*];
                    let $x = self.value;
                    $(let $more = $more.value;)*
                    let partials = [$($derivative),*];
                    Gradient::with($x.$name($($more),*), |d| super::dual::chain(slopes.map(|s| s[d]), partials))
                }
            )*
        }
    };
}

lagrange_macros::lagrangian! { @functions gradient_functions }

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scalar::Dual;

    /// Many sines at once may be other bits than one by one: values have to be those of plain numbers.
    #[test]
    fn values_of_many_sines_are_those_of_numbers() {
        let x: [f64; 5] = core::array::from_fn(|i| 0.7 * i as f64 - 1.3);
        let (sin, cos) = f64::sin_cos_array(x);
        let (s, c) = Gradient::sin_cos_array(x.map(|x| Gradient { value: x, slopes: [1.0, -2.0] }));
        let (ds, dc) = Dual::sin_cos_array(x.map(Dual::variable));
        for i in 0..5 {
            assert_eq!((s[i].value, c[i].value), (sin[i], cos[i]));
            assert_eq!((ds[i].value, dc[i].value), (sin[i], cos[i]));
            assert_eq!((s[i].slopes, c[i].slopes), ([cos[i], -2.0 * cos[i]], [-sin[i], 2.0 * sin[i]]));
            assert_eq!((ds[i].slope, dc[i].slope), (cos[i], -sin[i]));
        }
    }
}
