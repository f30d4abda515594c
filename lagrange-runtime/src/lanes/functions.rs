//! The elementary functions of packs, one for each row of the compiler's table.

use super::pack::Pack;
use super::policy::Policy;

/// Functions that the table names and the `libm` crate lacks.
mod libm {
    pub use ::libm::*;

    pub fn copysign_one(x: f64) -> f64 {
        if x.is_nan() { x } else { copysign(1.0, x) }
    }
}

/// Numbers to which a function can be applied one by one.
pub(super) trait Elements: Copy {
    /// `f` of each.
    fn each<const K: usize>(arguments: [Self; K], f: impl Fn([f64; K]) -> f64) -> Self;
}

impl<const L: usize> Elements for Pack<L> {
    #[inline(always)]
    fn each<const K: usize>(arguments: [Self; K], f: impl Fn([f64; K]) -> f64) -> Self {
        let mut values = Pack([0.0; L]);
        for i in 0..L {
            values.0[i] = f(core::array::from_fn(|k| arguments[k].0[i]));
        }
        values
    }
}

macro_rules! one_by_one {
    ($($name:ident($x:ident $(, $more:ident)*) = $f64:ident, $libm:ident, $doc:literal;
       [$($derivative:expr),*])*) => {
        /// The functions of the table under a policy: number by number from the `libm` crate, unless there is a kernel. Either
        /// has the same bits on all processors.
        pub(super) trait PackFunctions<P: Policy>: Elements {
            $(
                #[inline(always)]
                fn $name(self $(, $more: Self)*) -> Self {
                    Self::each([self $(, $more)*], |[$x $(, $more)*]| libm::$libm($x $(, $more)*))
                }
            )*
        }
    };
}

lagrange_macros::lagrangian! { @functions one_by_one }

impl<P: Policy, const L: usize> PackFunctions<P> for Pack<L> {
    #[inline(always)]
    fn sin(self) -> Self {
        self.sin_cos::<P>().0
    }

    #[inline(always)]
    fn cos(self) -> Self {
        self.sin_cos::<P>().1
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Self::each([self], |[x]| x.abs())
    }

    #[cfg(feature = "std")]
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self::each([self], |[x]| x.sqrt())
    }
}
