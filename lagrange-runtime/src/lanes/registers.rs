//! Two numbers in one register, as every x86-64 processor has them and most others do, or four, where the build has
//! AVX2 and fused operations.
//!
//! The optimiser makes vectors of loops over arrays, and of two statements side by side. Of three angles and more it
//! does so too late for their sines to stay in registers, or not at all (docs/lab/performance.md). So the
//! instructions are named here.

use super::policy::{Native, Policy};
use super::trigonometric::{self, Register};
use crate::scalar::SimdRow;
use core::ops::{Add, Mul, Sub};

/// Numbers in the widest register.
const WIDEST: usize = 4;

/// A register of several numbers.
pub(super) trait Wide: Register {
    const WIDTH: usize;
    /// The numbers at the first `WIDTH` of these places.
    fn gathered<const K: usize>(x: &[f64; K], places: [usize; WIDEST]) -> Self;
    /// Its numbers, put at these places.
    fn scattered<const K: usize>(self, x: &mut [f64; K], places: [usize; WIDEST]);
    fn abs(self) -> Self;
    /// The larger of each two, or `other` where one of them is a NaN.
    fn max(self, other: Self) -> Self;
    /// Is one of them larger than this?
    fn exceeds(self, limit: f64) -> bool;
}

/// A type of registers, of numbers in reverse order and by the names of its instructions.
#[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
macro_rules! register {
    (
        $register:ident($numbers:ident) of $($place:literal)*, set: $set:ident, $all:ident, arithmetic: $add:ident, $sub:ident, $mul:ident,
        $mul_add:ident, $max:ident, comparison: $greater:ident, $mask:ident, bits: $and:ident, $and_not:ident, $xor:ident,
        integers: $integers:ident, $from_integers:ident, $difference:ident, $shift:ident
    ) => {
        #[derive(Clone, Copy, Debug)]
        pub struct $register($numbers);

        // SAFETY of all that follows: there are such instructions, as is said above.
        impl Wide for $register {
            const WIDTH: usize = [$($place),*].len();

            #[inline(always)]
            fn gathered<const K: usize>(x: &[f64; K], places: [usize; WIDEST]) -> Self {
                $register(unsafe { $set($(x[places[$place]]),*) })
            }

            #[inline(always)]
            fn scattered<const K: usize>(self, x: &mut [f64; K], places: [usize; WIDEST]) {
                let numbers = self.numbers();
                $(x[places[$place]] = numbers[$place];)*
            }

            #[inline(always)]
            fn abs(self) -> Self {
                $register(unsafe { $and_not($all(-0.0), self.0) })
            }

            #[inline(always)]
            fn max(self, other: Self) -> Self {
                $register(unsafe { $max(self.0, other.0) })
            }

            #[inline(always)]
            fn exceeds(self, limit: f64) -> bool {
                unsafe { $mask($greater(self.0, $all(limit))) != 0 }
            }
        }

        impl Register for $register {
            #[inline(always)]
            fn all(x: f64) -> Self {
                $register(unsafe { $all(x) })
            }

            #[inline(always)]
            fn mul_add<P: Policy>(a: Self, b: Self, c: Self) -> Self {
                if P::FUSED { $register(unsafe { $mul_add(a.0, b.0, c.0) }) } else { a * b + c }
            }

            #[inline(always)]
            fn turned(sin: Self, cos: Self, quarters: Self) -> (Self, Self) {
                unsafe {
                    let (sin, cos, quarters, sign) = (sin.0, cos.0, quarters.0, $all(-0.0));
                    let last = $and(quarters, $all(f64::from_bits(1)));
                    let odd = $from_integers($difference($integers($all(0.0)), $integers(last)));
                    let half = $from_integers($shift::<62>($integers(quarters)));
                    let change = $xor($and($xor(sin, cos), odd), $and(half, sign));
                    let turned = $xor($xor(cos, change), $and(odd, sign));
                    ($register($xor(sin, change)), $register(turned))
                }
            }
        }

        impl Add for $register {
            type Output = Self;
            #[inline(always)]
            fn add(self, other: Self) -> Self {
                $register(unsafe { $add(self.0, other.0) })
            }
        }

        impl Sub for $register {
            type Output = Self;
            #[inline(always)]
            fn sub(self, other: Self) -> Self {
                $register(unsafe { $sub(self.0, other.0) })
            }
        }

        impl Mul for $register {
            type Output = Self;
            #[inline(always)]
            fn mul(self, other: Self) -> Self {
                $register(unsafe { $mul(self.0, other.0) })
            }
        }
    };
}

#[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
#[allow(unsafe_code)] // Instructions of SSE2, which the compilation has.
mod pair {
    use super::*;
    #[cfg(target_feature = "fma")]
    use core::arch::x86_64::_mm_fmadd_pd as fused;
    use core::arch::x86_64::*;

    register!(
        Pair(__m128d) of 1 0, set: _mm_set_pd, _mm_set1_pd, arithmetic: _mm_add_pd, _mm_sub_pd, _mm_mul_pd,
        fused, _mm_max_pd, comparison: _mm_cmpgt_pd, _mm_movemask_pd, bits: _mm_and_pd, _mm_andnot_pd, _mm_xor_pd,
        integers: _mm_castpd_si128, _mm_castsi128_pd, _mm_sub_epi64, _mm_slli_epi64
    );

    impl Pair {
        #[inline(always)]
        fn numbers(self) -> [f64; 2] {
            unsafe { [_mm_cvtsd_f64(self.0), _mm_cvtsd_f64(_mm_unpackhi_pd(self.0, self.0))] }
        }
    }

    /// a b + c with one rounding.
    #[cfg(not(target_feature = "fma"))]
    unsafe fn fused(a: __m128d, b: __m128d, c: __m128d) -> __m128d {
        let [a, b, c] = [a, b, c].map(|x| Pair(x).numbers());
        let of = |i: usize| super::super::policy::Fused::mul_add(a[i], b[i], c[i]);
        unsafe { _mm_set_pd(of(1), of(0)) }
    }
}

#[cfg(all(target_arch = "x86_64", any(test, all(target_feature = "avx2", target_feature = "fma"))))]
#[allow(unsafe_code)] // Instructions of AVX2 and FMA, which the compilation has, or tests ask the processor for.
mod quad {
    use super::*;
    use core::arch::x86_64::*;

    register!(
        Quad(__m256d) of 3 2 1 0, set: _mm256_set_pd, _mm256_set1_pd, arithmetic: _mm256_add_pd, _mm256_sub_pd, _mm256_mul_pd,
        _mm256_fmadd_pd, _mm256_max_pd, comparison: greater, _mm256_movemask_pd, bits: _mm256_and_pd, _mm256_andnot_pd, _mm256_xor_pd,
        integers: _mm256_castpd_si256, _mm256_castsi256_pd, _mm256_sub_epi64, _mm256_slli_epi64
    );

    impl Quad {
        #[inline(always)]
        fn numbers(self) -> [f64; 4] {
            unsafe {
                let (low, high) = (_mm256_castpd256_pd128(self.0), _mm256_extractf128_pd::<1>(self.0));
                let (second, last) = (_mm_unpackhi_pd(low, low), _mm_unpackhi_pd(high, high));
                [_mm_cvtsd_f64(low), _mm_cvtsd_f64(second), _mm_cvtsd_f64(high), _mm_cvtsd_f64(last)]
            }
        }
    }

    #[inline(always)]
    unsafe fn greater(a: __m256d, b: __m256d) -> __m256d {
        unsafe { _mm256_cmp_pd::<_CMP_GT_OQ>(a, b) }
    }
}

/// The same for the optimiser to make vectors of.
#[cfg(any(test, not(all(target_arch = "x86_64", target_feature = "sse2"))))]
mod array {
    use super::*;

    #[derive(Clone, Copy, Debug)]
    pub struct Pair(f64, f64);

    impl Wide for Pair {
        const WIDTH: usize = 2;

        #[inline(always)]
        fn gathered<const K: usize>(x: &[f64; K], places: [usize; WIDEST]) -> Self {
            Pair(x[places[0]], x[places[1]])
        }

        #[inline(always)]
        fn scattered<const K: usize>(self, x: &mut [f64; K], places: [usize; WIDEST]) {
            (x[places[1]], x[places[0]]) = (self.1, self.0);
        }

        #[inline(always)]
        fn abs(self) -> Self {
            Pair(self.0.abs(), self.1.abs())
        }

        #[inline(always)]
        fn max(self, other: Self) -> Self {
            let larger = |x: f64, y: f64| if x > y { x } else { y };
            Pair(larger(self.0, other.0), larger(self.1, other.1))
        }

        #[inline(always)]
        fn exceeds(self, limit: f64) -> bool {
            (self.0 > limit) | (self.1 > limit)
        }
    }

    impl Register for Pair {
        #[inline(always)]
        fn all(x: f64) -> Self {
            Pair(x, x)
        }

        #[inline(always)]
        fn mul_add<P: Policy>(a: Self, b: Self, c: Self) -> Self {
            Pair(P::mul_add(a.0, b.0, c.0), P::mul_add(a.1, b.1, c.1))
        }

        #[inline(always)]
        fn turned(sin: Self, cos: Self, quarters: Self) -> (Self, Self) {
            let (s, c) = Register::turned(sin.0, cos.0, quarters.0);
            let (u, v) = Register::turned(sin.1, cos.1, quarters.1);
            (Pair(s, u), Pair(c, v))
        }
    }

    impl Add for Pair {
        type Output = Self;
        #[inline(always)]
        fn add(self, other: Self) -> Self {
            Pair(self.0 + other.0, self.1 + other.1)
        }
    }

    impl Sub for Pair {
        type Output = Self;
        #[inline(always)]
        fn sub(self, other: Self) -> Self {
            Pair(self.0 - other.0, self.1 - other.1)
        }
    }

    impl Mul for Pair {
        type Output = Self;
        #[inline(always)]
        fn mul(self, other: Self) -> Self {
            Pair(self.0 * other.0, self.1 * other.1)
        }
    }
}

#[cfg(not(all(target_arch = "x86_64", target_feature = "avx2", target_feature = "fma")))]
use Pair as Widest;
#[cfg(not(all(target_arch = "x86_64", target_feature = "sse2")))]
pub use array::Pair;
#[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
pub use pair::Pair;
#[cfg(all(target_arch = "x86_64", target_feature = "avx2", target_feature = "fma"))]
use quad::Quad as Widest;

/// A row of two numbers is written as one, so that it can be read as one: a processor waits until a vector that was
/// written number by number has left its buffers.
impl SimdRow for Pair {
    type Elements = [f64; 2];

    #[inline(always)]
    fn together(_: usize) -> bool {
        false
    }

    #[inline(always)]
    fn of(numbers: [f64; 2]) -> Self {
        Pair::gathered(&numbers, [0, 1, 0, 1])
    }

    #[inline(always)]
    fn numbers(self) -> [f64; 2] {
        let mut numbers = [0.0; 2];
        self.scattered(&mut numbers, [0, 1, 0, 1]);
        numbers
    }

    #[inline(always)]
    fn zero() -> Self {
        Pair::all(0.0)
    }

    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        self + other
    }

    #[inline(always)]
    fn plus_product(self, a: Self, b: Self) -> Self {
        Pair::mul_add::<Native>(a, b, self)
    }
}

/// Largest number of arguments of [`sin_cos`].
pub(super) const MOST: usize = 32;

/// Sines and cosines of up to [`MOST`] numbers, and those of numbers beyond the kernel's limit by `beyond`.
#[inline(always)]
pub(super) fn sin_cos<P: Policy, const K: usize>(
    x: [f64; K],
    beyond: impl Fn([f64; K]) -> ([f64; K], [f64; K]),
) -> ([f64; K], [f64; K]) {
    if K <= Pair::WIDTH { by::<P, Pair, K>(x, beyond) } else { by::<P, Widest, K>(x, beyond) }
}

/// The same in such registers. There are no loops, which would be taken apart too late.
#[inline(always)]
fn by<P: Policy, V: Wide, const K: usize>(
    x: [f64; K],
    beyond: impl Fn([f64; K]) -> ([f64; K], [f64; K]),
) -> ([f64; K], [f64; K]) {
    let zero = V::all(0.0);
    let (mut sines, mut cosines, mut largest) = ([zero; MOST / 2], [zero; MOST / 2], zero);
    let (mut sin, mut cos) = ([0.0; K], [0.0; K]);
    macro_rules! all {
        ($($step:literal)*) => {
            $(if $step < const { K.div_ceil(V::WIDTH) } {
                let x = V::gathered(&x, const { places::<V, K>($step) });
                // Of a NaN come NaNs.
                largest = x.abs().max(largest);
                (sines[$step], cosines[$step]) = trigonometric::sin_cos::<P, V>(x);
            })*
            if largest.exceeds(trigonometric::limit::<P>()) {
                // From a copy, so that nothing but what is called only here has to be in memory.
                let mut copy = [0.0; K];
                for i in 0..K {
                    copy[i] = x[i];
                }
                let (s, c) = beyond(copy);
                $(if $step < const { K.div_ceil(V::WIDTH) } {
                    let places = const { places::<V, K>($step) };
                    (sines[$step], cosines[$step]) = (V::gathered(&s, places), V::gathered(&c, places));
                })*
            }
            $(if $step < const { K.div_ceil(V::WIDTH) } {
                let places = const { places::<V, K>($step) };
                sines[$step].scattered(&mut sin, places);
                cosines[$step].scattered(&mut cos, places);
            })*
        };
    }
    all!(0 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15);
    (sin, cos)
}

/// The numbers in the register of this step; where there are no more, the last one. From both ends inwards, since
/// chains of bodies are eliminated from both: a processor begins with the ends while it computes the sines of the
/// middle.
const fn places<V: Wide, const K: usize>(step: usize) -> [usize; WIDEST] {
    let registers = K.div_ceil(V::WIDTH);
    let register = match step {
        _ if step >= registers => step,
        _ if step.is_multiple_of(2) => step / 2,
        _ => registers - 1 - step / 2,
    };
    let (mut places, mut i) = ([0; WIDEST], 0);
    while i < WIDEST {
        let place = V::WIDTH * register + i;
        places[i] = if place < K { place } else { K.saturating_sub(1) };
        i += 1;
    }
    places
}

#[cfg(test)]
mod tests {
    use super::super::policy::{Fused, Plain};
    use super::super::processor::Level;
    use super::*;

    const PLACES: [usize; WIDEST] = [0, 1, 2, 3];

    /// The first numbers of `x` that a function of registers gives, all others being those of `x`.
    fn of_registers<V: Wide>(x: [f64; WIDEST], f: impl Fn(V) -> V) -> [f64; WIDEST] {
        let mut found = x;
        f(V::gathered(&x, PLACES)).scattered(&mut found, PLACES);
        found
    }

    fn are_those_of_one_alone<P: Policy, V: Wide>() {
        let mut x = -trigonometric::limit::<P>();
        while x < trigonometric::limit::<P>() {
            let all = [x, -0.7 * x, 0.3 * x, 1.0 - x];
            let (sin, cos) = (
                of_registers::<V>(all, |x| trigonometric::sin_cos::<P, V>(x).0),
                of_registers::<V>(all, |x| trigonometric::sin_cos::<P, V>(x).1),
            );
            for i in 0..V::WIDTH {
                let alone = trigonometric::sin_cos_of_lane::<P>(all[i]);
                let bits = |(s, c): (f64, f64)| (s.to_bits(), c.to_bits());
                assert_eq!(bits((sin[i], cos[i])), bits(alone), "{}", all[i]);
                assert_eq!(bits(trigonometric::sin_cos::<P, f64>(all[i])), bits(alone), "{}", all[i]);
            }
            x = 0.9973 * x + 1e-3 + x.abs() * 1e-2;
        }
    }

    fn largest_is_found_beside_nan<V: Wide>() {
        let all = [0.5, -3.0, f64::NAN, f64::INFINITY, -1e300];
        for (x, y) in all.iter().flat_map(|x| all.map(|y| (*x, y))) {
            let expected = if x.abs() > y { x.abs() } else { y };
            let larger = |x: V| x.abs().max(V::all(y));
            for place in 0..V::WIDTH {
                let mut numbers = [y; WIDEST];
                numbers[place] = x;
                assert_eq!(of_registers(numbers, larger)[place].to_bits(), expected.to_bits(), "{x} {y}");
                let mut numbers = [1.0; WIDEST];
                numbers[place] = expected;
                for limit in [0.9, 2.0, 1e200] {
                    let found = V::gathered(&numbers, PLACES).exceeds(limit);
                    assert_eq!(found, expected > limit || 1.0 > limit, "{x} {y}");
                }
            }
        }
    }

    /// One that is too large in the same place of a register as a NaN, before or after it.
    fn large_numbers_are_not_lost_beside_nan<V: Wide>() {
        const PAIRS: [[usize; 2]; 4] = [[0, 4], [4, 0], [1, 7], [7, 1]];
        for [large, nan] in PAIRS {
            let mut x = [0.5; 8];
            (x[large], x[nan]) = (1e300, f64::NAN);
            let (sin, cos) = by::<Plain, V, 8>(x, |x| (x.map(|_| 2.0), x.map(|_| 2.0)));
            assert_eq!((sin, cos), ([2.0; 8], [2.0; 8]), "{large} {nan}");
        }
    }

    fn all<V: Wide, const K: usize>() {
        let x = core::array::from_fn(|i| 0.3 * i as f64 - 1.0);
        let (sin, cos) = by::<Plain, V, K>(x, |_| unreachable!("these are small"));
        for i in 0..K {
            assert_eq!((sin[i], cos[i]), trigonometric::sin_cos_of_lane::<Plain>(x[i]), "{i} of {K}");
        }
    }

    fn registers<V: Wide>() {
        are_those_of_one_alone::<Plain, V>();
        are_those_of_one_alone::<Fused, V>();
        largest_is_found_beside_nan::<V>();
        large_numbers_are_not_lost_beside_nan::<V>();
        all::<V, 0>();
        all::<V, 1>();
        all::<V, 5>();
        all::<V, 14>();
        all::<V, 32>();
    }

    #[test]
    fn two_numbers_in_a_register_are_those_of_one_alone() {
        registers::<Pair>();
        registers::<array::Pair>();
    }

    #[cfg(target_arch = "x86_64")]
    #[test]
    fn four_numbers_in_a_register_are_those_of_one_alone() {
        if Level::best() >= Level::Avx2 {
            registers::<quad::Quad>();
        }
    }
}
