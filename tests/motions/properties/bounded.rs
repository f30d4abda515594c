//! A number that knows how wrong it may be.

use lagrange_runtime::{Functions, Scalar, scalar::Comparison};
use std::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};

/// A number and a bound of its absolute error, to first order: every operation passes on the errors of its operands
/// and adds its own rounding (running error analysis: Higham, *Accuracy and Stability of Numerical Algorithms*, 2002,
/// §3.3).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounded {
    pub value: f64,
    pub error: f64,
}

/// Elementary functions are accurate to a few units in the last place.
const UNIT: f64 = 4.0 * f64::EPSILON;

/// A bound larger than this says nothing, relative to numbers above 1.
const KNOWN: f64 = 1e-6;

impl Bounded {
    pub fn exact(value: f64) -> Bounded {
        Bounded { value, error: 0.0 }
    }

    fn rounded(value: f64, error: f64) -> Bounded {
        Bounded { value, error: error + UNIT * value.abs() }
    }

    /// Asserts that both may be roundings of the same number.
    #[track_caller]
    pub fn assert_agrees(self, other: Bounded, what: impl Fn() -> String) {
        let (difference, allowed) = ((self.value - other.value).abs(), self.error + other.error);
        let known = allowed <= KNOWN * self.value.abs().max(1.0);
        assert!(known, "{}: {self:?} and {other:?} are too uncertain to be compared", what());
        assert!(difference <= allowed, "{}: {self:?} is not {other:?}, off by {difference:.1e}", what());
    }
}

impl Add for Bounded {
    type Output = Bounded;
    fn add(self, o: Bounded) -> Bounded {
        Bounded::rounded(self.value + o.value, self.error + o.error)
    }
}

impl Sub for Bounded {
    type Output = Bounded;
    fn sub(self, o: Bounded) -> Bounded {
        Bounded::rounded(self.value - o.value, self.error + o.error)
    }
}

impl Mul for Bounded {
    type Output = Bounded;
    fn mul(self, o: Bounded) -> Bounded {
        let error = self.value.abs() * o.error + o.value.abs() * self.error;
        Bounded::rounded(self.value * o.value, error)
    }
}

impl Div for Bounded {
    type Output = Bounded;
    fn div(self, o: Bounded) -> Bounded {
        let value = self.value / o.value;
        Bounded::rounded(value, (self.error + value.abs() * o.error) / o.value.abs())
    }
}

impl Neg for Bounded {
    type Output = Bounded;
    fn neg(self) -> Bounded {
        Bounded { value: -self.value, error: self.error }
    }
}

macro_rules! assign {
    ($($trait:ident $method:ident $op:tt)*) => {$(
        impl $trait for Bounded {
            fn $method(&mut self, o: Bounded) {
                *self = *self $op o;
            }
        }
    )*};
}

assign! { AddAssign add_assign +  SubAssign sub_assign -  MulAssign mul_assign *  DivAssign div_assign / }

impl Scalar for Bounded {
    type Pair = [Self; 2];

    fn from_f64(x: f64) -> Bounded {
        // 0.1 may have been 1/10 or 0.2 / 2 before; binary fractions are what they are.
        if (1024.0 * x).fract() == 0.0 { Bounded::exact(x) } else { Bounded::rounded(x, 0.0) }
    }

    fn mul_add(self, a: Bounded, b: Bounded) -> Bounded {
        self * a + b
    }

    fn lookup<const A: usize, const K: usize>(
        x: [Bounded; A],
        mut f: impl FnMut(usize, [f64; A]) -> [f64; K],
    ) -> [Bounded; K] {
        f(0, x.map(|x| x.value)).map(Bounded::exact)
    }

    fn select(comparison: Comparison, a: Bounded, b: Bounded, yes: Bounded, no: Bounded) -> Bounded {
        let holds = match comparison {
            Comparison::Less => a.value < b.value,
            Comparison::LessEqual => a.value <= b.value,
            Comparison::Equal => a.value == b.value,
        };
        if holds { yes } else { no }
    }
}

/// |∂f| times the error of the argument; nothing where the argument is exact, however steep f is.
fn passed_on(slope: f64, error: f64) -> f64 {
    if error == 0.0 { 0.0 } else { slope.abs() * error }
}

// Constants stand in the function table as digits.
#[allow(clippy::approx_constant)]
mod functions {
    use super::*;
    macro_rules! bounded_functions {
    ($($name:ident($x:ident $(, $more:ident)*) = $std:ident, $libm:ident, $doc:literal;
       [$($derivative:expr),*])*) => {
        impl Functions for Bounded {
            $(
                #[allow(non_camel_case_types, dead_code, unused_variables)]
                fn $name(self $(, $more: Bounded)*) -> Bounded {
                    type S = f64;
                    let errors = [self.error $(, $more.error)*];
                    let $x = self.value;
                    $(let $more = $more.value;)*
                    let slopes = [$($derivative),*];
                    let error = errors.into_iter().zip(slopes).map(|(error, slope)| passed_on(slope, error)).sum();
                    Bounded::rounded(<f64 as Functions>::$name($x $(, $more)*), error)
                }
            )*
        }
    };
}

    lagrange_runtime::__private::lagrangian! { @functions bounded_functions }
}
