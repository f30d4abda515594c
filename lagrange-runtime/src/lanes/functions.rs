//! The elementary functions of packs, one for each row of the compiler's table.

use super::kernels;
use super::pack::Pack;
use super::policy::Policy;

/// Functions that the table names and the `libm` crate lacks.
mod libm {
    pub use ::libm::*;

    #[inline(always)]
    pub fn copysign_one(x: f64) -> f64 {
        if x.is_nan() { x } else { 1f64.copysign(x) }
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

/// A function whose kernel does not hold for all numbers: each by the kernel or by the `libm` crate.
#[cold]
#[inline(never)]
fn each_by_itself<const L: usize, const K: usize>(
    arguments: [Pack<L>; K],
    kernel: fn([f64; K]) -> (f64, bool),
    libm: fn([f64; K]) -> f64,
) -> Pack<L> {
    Pack::each(arguments, |x| {
        let (value, holds) = kernel(x);
        if holds { value } else { libm(x) }
    })
}

/// Functions with kernels of the same name. A loop stands in each, since what is called through a function value
/// would be compiled for the baseline.
macro_rules! by_kernels {
    ($($name:ident($($more:ident),*) $libm:ident;)*) => {$(
        #[inline(always)]
        fn $name(self $(, $more: Self)*) -> Self {
            let (mut values, mut all) = (Pack([0.0; L]), true);
            for i in 0..L {
                let (value, holds) = kernels::$name::<P>(self.0[i] $(, $more.0[i])*);
                values.0[i] = value;
                all &= holds;
            }
            if all {
                return values;
            }
            each_by_itself(
                [self $(, $more)*],
                |[x $(, $more)*]| kernels::$name::<P>(x $(, $more)*),
                |[x $(, $more)*]| libm::$libm(x $(, $more)*),
            )
        }
    )*};
}

macro_rules! one_by_one {
    ($($name:ident($x:ident $(, $more:ident)*) = $f64:ident, $libm:ident, $doc:literal;
       [$($derivative:expr),*])*) => {
        /// The functions of the table under a policy: number by number from the `libm` crate, unless there is a
        /// kernel. Either has the same bits on all processors.
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
    by_kernels! {
        tan() tan;
        asin() asin;
        acos() acos;
        atan() atan;
        atan2(y) atan2;
        sinh() sinh;
        cosh() cosh;
        tanh() tanh;
        asinh() asinh;
        acosh() acosh;
        atanh() atanh;
        exp() exp;
        exp_m1() expm1;
        exp2() exp2;
        ln() log;
        ln_1p() log1p;
        log2() log2;
        log10() log10;
        cbrt() cbrt;
        hypot(y) hypot;
        powf(y) pow;
    }

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

#[cfg(test)]
mod tests {
    use crate::lanes::{Baseline, Fused, Lanes, Level, Plain, Policy, Processor, SingleLane, Work};
    use crate::scalar::Functions;

    /// Every function at `L` numbers, as bits.
    struct Table<const L: usize, P, A> {
        x: [f64; L],
        y: [f64; L],
        of: core::marker::PhantomData<(P, A)>,
    }

    macro_rules! table {
        ($($name:ident($x:ident $(, $more:ident)*) = $f64:ident, $libm:ident, $doc:literal;
           [$($derivative:expr),*])*) => {
            const NAMES: &[&str] = &[$(stringify!($name)),*];

            impl<const L: usize, P: Policy, A: Processor> Work for Table<L, P, A> {
                type Output = Vec<[u64; L]>;

                #[inline(always)]
                fn run(self) -> Self::Output {
                    let (x, y) = (Lanes::<L, P, A>::new(self.x), Lanes::<L, P, A>::new(self.y));
                    let bits = |values: Lanes<L, P, A>| values.to_array().map(f64::to_bits);
                    vec![$(bits({
                        $(let $more = y;)*
                        Functions::$name(x $(, $more)*)
                    })),*]
                }
            }

            fn alone<P: Policy>(x: f64, y: f64) -> Vec<u64> {
                let (x, y) = (SingleLane::<P>::new(x), SingleLane::<P>::new(y));
                vec![$({
                    $(let $more = y;)*
                    Functions::$name(x $(, $more)*).value().to_bits()
                }),*]
            }

            /// Value of the standard library.
            fn standard(x: f64, y: f64) -> Vec<f64> {
                vec![$({
                    $(let $more = y;)*
                    Functions::$name(x $(, $more)*)
                }),*]
            }
        };
    }

    lagrange_macros::lagrangian! { @functions table }

    const SPECIAL: [f64; 24] = [
        0.0,
        -0.0,
        1.0,
        -1.0,
        0.5,
        -0.5,
        2.0,
        1e-310,
        -1e-310,
        1e-200,
        -1e-200,
        1e-20,
        1e200,
        -1e200,
        700.0,
        -700.0,
        709.5,
        -745.0,
        f64::MAX,
        f64::MIN_POSITIVE,
        f64::INFINITY,
        f64::NEG_INFINITY,
        f64::NAN,
        1e9,
    ];

    fn agree<const L: usize, P: Policy, A: Processor>() {
        let all = SPECIAL.iter().flat_map(|&x| SPECIAL.iter().map(move |&y| (x, y)));
        let ordinary = (0..400).map(|k| {
            let u = f64::from(k) * 0.618_033_988_749_894_9 % 1.0;
            ((u - 0.4) * 10f64.powi(k % 7 - 3), (u * 7.0 % 1.0 - 0.5) * 4.0)
        });
        let arguments: Vec<_> = all.chain(ordinary).collect();
        for chunk in arguments.chunks(L) {
            let at = |i: usize| chunk.get(i).copied().unwrap_or((0.3, 0.7));
            let (x, y) = (core::array::from_fn(|i| at(i).0), core::array::from_fn(|i| at(i).1));
            let beside = A::call(Table::<L, P, A> { x, y, of: core::marker::PhantomData });
            for i in 0..L {
                for (k, one) in alone::<P>(x[i], y[i]).into_iter().enumerate() {
                    let (found, one) = (f64::from_bits(beside[k][i]), f64::from_bits(one));
                    let same = found.to_bits() == one.to_bits() || found.is_nan() && one.is_nan();
                    assert!(
                        same,
                        "{}({:e}, {:e}): {found:e} beside others, {one:e} alone",
                        NAMES[k], x[i], y[i]
                    );
                }
            }
        }
    }

    #[test]
    fn every_function_has_the_same_bits_alone_and_beside_others() {
        agree::<8, Plain, Baseline>();
        #[cfg(all(target_arch = "x86_64", feature = "std"))]
        {
            // Each policy and processor once: all functions are compiled for each of these.
            if Level::best() >= Level::Avx2 {
                agree::<8, Plain, crate::lanes::Avx2>();
                agree::<3, Fused, crate::lanes::Avx2>();
            }
            if Level::best() >= Level::Avx512 {
                agree::<8, Fused, crate::lanes::Avx512>();
            }
        }
    }

    /// Infinities, NaN, zeros with their signs, and what overflows: as the standard library has it.
    #[test]
    fn special_arguments() {
        for &x in &SPECIAL {
            for &y in &SPECIAL {
                let standard = standard(x, y);
                for (k, (one, other)) in alone::<Fused>(x, y).into_iter().zip(standard).enumerate() {
                    let one = f64::from_bits(one);
                    let near = (one - other).abs() <= 4e-15 * other.abs();
                    let same = one == other && one.is_sign_negative() == other.is_sign_negative();
                    assert!(
                        same || one.is_nan() && other.is_nan() || near && other != 0.0,
                        "{}({x:e}, {y:e}): {one:e}, and {other:e} of the standard library",
                        NAMES[k]
                    );
                }
            }
        }
    }
}
