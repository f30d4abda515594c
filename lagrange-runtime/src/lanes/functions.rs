//! The elementary functions of numbers in lanes, one for each row of the compiler's table.

use super::kernels;
use super::pack::Pack;
use super::policy::Policy;
use super::processor::Processor;
use super::vector::Vector;

/// Functions that the table names and the `libm` crate lacks.
mod libm {
    pub use ::libm::*;

    pub fn copysign_one(x: f64) -> f64 {
        if x.is_nan() { x } else { copysign(1.0, x) }
    }
}

/// Numbers to which a function can be applied one by one.
pub(super) trait Elements: Vector {
    /// `f` of each.
    fn each<const K: usize>(arguments: [Self; K], f: impl Fn([f64; K]) -> f64) -> Self;
}

impl Elements for f64 {
    #[inline(always)]
    fn each<const K: usize>(arguments: [f64; K], f: impl Fn([f64; K]) -> f64) -> f64 {
        f(arguments)
    }
}

impl<const L: usize, A: Processor> Elements for Pack<L, A> {
    #[inline(always)]
    fn each<const K: usize>(arguments: [Self; K], f: impl Fn([f64; K]) -> f64) -> Self {
        let mut values = [0.0; L];
        for i in 0..L {
            values[i] = f(core::array::from_fn(|k| arguments[k].x[i]));
        }
        Pack::new(values)
    }
}

/// What a kernel gives where it holds, and elsewhere what the `libm` crate does, number by number: either has the same bits on all
/// processors.
#[inline(always)]
fn whole<V: Elements, const K: usize>(arguments: [V; K], (value, good): (V, V), f: fn([f64; K]) -> f64) -> V {
    if good.all() { value } else { mended(arguments, value, good, f) }
}

#[cold]
#[inline(never)]
fn mended<V: Elements, const K: usize>(arguments: [V; K], value: V, good: V, f: fn([f64; K]) -> f64) -> V {
    good.select(value, V::each(arguments, f))
}

macro_rules! one_by_one {
    ($($name:ident($x:ident $(, $more:ident)*) = $f64:ident, $libm:ident, $doc:literal;
       [$($derivative:expr),*])*) => {
        /// The functions of the table under a policy: number by number from the `libm` crate, unless there is a kernel.
        pub(super) trait VectorFunctions<P: Policy>: Elements {
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

/// Functions with kernels of the same name.
macro_rules! kernels {
    ($($name:ident($($x:ident),*) $libm:ident;)*) => {$(
        #[inline(always)]
        fn $name(self $(, $x: Self)*) -> Self {
            whole([self $(, $x)*], kernels::$name::<P, V>(self $(, $x)*), |[x $(, $x)*]| libm::$libm(x $(, $x)*))
        }
    )*};
}

impl<P: Policy, V: Elements> VectorFunctions<P> for V {
    kernels! {
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
        sin_cos::<P, V>(self).0
    }

    #[inline(always)]
    fn cos(self) -> Self {
        sin_cos::<P, V>(self).1
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Vector::abs(self)
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Vector::sqrt(self)
    }

    #[inline(always)]
    fn signum(self) -> Self {
        kernels::signum(self)
    }
}

/// Sines and cosines.
#[inline(always)]
pub(super) fn sin_cos<P: Policy, V: Elements>(x: V) -> (V, V) {
    let ((sin, cos), good) = kernels::sin_cos::<P, V>(x);
    if good.all() { (sin, cos) } else { large_sin_cos(x, sin, cos, good) }
}

#[cold]
#[inline(never)]
fn large_sin_cos<V: Elements>(x: V, sin: V, cos: V, good: V) -> (V, V) {
    (
        good.select(sin, V::each([x], |[x]| libm::sincos(x).0)),
        good.select(cos, V::each([x], |[x]| libm::sincos(x).1)),
    )
}

#[cfg(test)]
mod tests {
    use crate::lanes::{Baseline, Fused, Lane, Lanes, Level, Plain, Policy, Processor, Work};
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
                let (x, y) = (Lane::<P>::new(x), Lane::<P>::new(y));
                vec![$({
                    $(let $more = y;)*
                    Functions::$name(x $(, $more)*).value().to_bits()
                }),*]
            }

            /// What the standard library has.
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

    fn agree_on<A: Processor>() {
        agree::<1, Plain, A>();
        agree::<3, Fused, A>();
        agree::<8, Fused, A>();
        agree::<8, Plain, A>();
        agree::<16, Fused, A>();
        agree::<21, Plain, A>();
    }

    #[test]
    fn every_function_has_the_same_bits_alone_and_beside_others() {
        agree_on::<Baseline>();
        #[cfg(all(target_arch = "x86_64", feature = "std"))]
        {
            if Level::best() >= Level::Avx2 {
                agree_on::<crate::lanes::Avx2>();
            }
            if Level::best() >= Level::Avx512 {
                agree_on::<crate::lanes::Avx512>();
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
