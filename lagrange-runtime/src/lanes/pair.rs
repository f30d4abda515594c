//! Two numbers in one register, as every x86-64 processor has them and most others do.
//!
//! The optimiser makes vectors of loops over arrays, and of two statements side by side. Of three angles and more it does so too late for
//! their sines to stay in registers, or not at all (docs/performance.md). So the instructions are named here.

use super::policy::Policy;
use super::trigonometric::{self, Register};

#[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
#[allow(unsafe_code)] // Instructions of SSE2, which the compilation has.
mod register {
    #[cfg(not(target_feature = "fma"))]
    use super::super::policy::{Fused, Policy};
    use core::arch::x86_64::*;
    use core::ops::{Add, Mul, Sub};

    #[derive(Clone, Copy)]
    pub(crate) struct Pair(__m128d);

    impl Pair {
        #[inline(always)]
        pub fn new(x: f64, y: f64) -> Pair {
            // SAFETY: there is SSE2. The same holds below.
            Pair(unsafe { _mm_set_pd(y, x) })
        }

        #[inline(always)]
        pub fn parts(self) -> (f64, f64) {
            unsafe { (_mm_cvtsd_f64(self.0), _mm_cvtsd_f64(_mm_unpackhi_pd(self.0, self.0))) }
        }

        #[inline(always)]
        pub fn abs(self) -> Pair {
            Pair(unsafe { _mm_andnot_pd(_mm_set1_pd(-0.0), self.0) })
        }

        /// The larger of each two, or `other` where one of them is a NaN.
        #[inline(always)]
        pub fn max(self, other: Pair) -> Pair {
            Pair(unsafe { _mm_max_pd(self.0, other.0) })
        }

        /// Is one of them larger than this?
        #[inline(always)]
        pub fn exceeds(self, limit: f64) -> bool {
            unsafe { _mm_movemask_pd(_mm_cmpgt_pd(self.0, _mm_set1_pd(limit))) != 0 }
        }

        /// `a b + c` with one rounding.
        #[inline(always)]
        pub fn fused(a: Pair, b: Pair, c: Pair) -> Pair {
            #[cfg(target_feature = "fma")]
            {
                Pair(unsafe { _mm_fmadd_pd(a.0, b.0, c.0) })
            }
            #[cfg(not(target_feature = "fma"))]
            {
                let (a, b, c) = (a.parts(), b.parts(), c.parts());
                Pair::new(Fused::mul_add(a.0, b.0, c.0), Fused::mul_add(a.1, b.1, c.1))
            }
        }

        /// See [`Register::turned`](super::Register::turned).
        #[inline(always)]
        pub fn turned(sin: Pair, cos: Pair, quarters: Pair) -> (Pair, Pair) {
            unsafe {
                let (sin, cos) = (_mm_castpd_si128(sin.0), _mm_castpd_si128(cos.0));
                let quarters = _mm_castpd_si128(quarters.0);
                let sign = _mm_castpd_si128(_mm_set1_pd(-0.0));
                let odd = _mm_sub_epi64(_mm_setzero_si128(), _mm_and_si128(quarters, _mm_set1_epi64x(1)));
                let exchange = _mm_and_si128(_mm_xor_si128(sin, cos), odd);
                let change = _mm_xor_si128(exchange, _mm_and_si128(_mm_slli_epi64::<62>(quarters), sign));
                let turned = _mm_xor_si128(_mm_xor_si128(cos, change), _mm_and_si128(odd, sign));
                (Pair(_mm_castsi128_pd(_mm_xor_si128(sin, change))), Pair(_mm_castsi128_pd(turned)))
            }
        }
    }

    impl Add for Pair {
        type Output = Pair;
        #[inline(always)]
        fn add(self, other: Pair) -> Pair {
            Pair(unsafe { _mm_add_pd(self.0, other.0) })
        }
    }

    impl Sub for Pair {
        type Output = Pair;
        #[inline(always)]
        fn sub(self, other: Pair) -> Pair {
            Pair(unsafe { _mm_sub_pd(self.0, other.0) })
        }
    }

    impl Mul for Pair {
        type Output = Pair;
        #[inline(always)]
        fn mul(self, other: Pair) -> Pair {
            Pair(unsafe { _mm_mul_pd(self.0, other.0) })
        }
    }
}

/// The same for the optimiser to make vectors of.
#[cfg(any(test, not(all(target_arch = "x86_64", target_feature = "sse2"))))]
mod array {
    use super::super::policy::{Fused, Policy};
    use super::Register;
    use core::ops::{Add, Mul, Sub};

    #[derive(Clone, Copy)]
    pub(crate) struct Pair(f64, f64);

    impl Pair {
        #[inline(always)]
        pub fn new(x: f64, y: f64) -> Pair {
            Pair(x, y)
        }

        #[inline(always)]
        pub fn parts(self) -> (f64, f64) {
            (self.0, self.1)
        }

        #[inline(always)]
        pub fn abs(self) -> Pair {
            Pair(self.0.abs(), self.1.abs())
        }

        /// The larger of each two, or `other` where one of them is a NaN.
        #[inline(always)]
        pub fn max(self, other: Pair) -> Pair {
            let larger = |x: f64, y: f64| if x > y { x } else { y };
            Pair(larger(self.0, other.0), larger(self.1, other.1))
        }

        /// Is one of them larger than this?
        #[inline(always)]
        pub fn exceeds(self, limit: f64) -> bool {
            (self.0 > limit) | (self.1 > limit)
        }

        /// `a b + c` with one rounding.
        #[inline(always)]
        pub fn fused(a: Pair, b: Pair, c: Pair) -> Pair {
            Pair(Fused::mul_add(a.0, b.0, c.0), Fused::mul_add(a.1, b.1, c.1))
        }

        #[inline(always)]
        pub fn turned(sin: Pair, cos: Pair, quarters: Pair) -> (Pair, Pair) {
            let (s, c) = Register::turned(sin.0, cos.0, quarters.0);
            let (u, v) = Register::turned(sin.1, cos.1, quarters.1);
            (Pair(s, u), Pair(c, v))
        }
    }

    impl Add for Pair {
        type Output = Pair;
        #[inline(always)]
        fn add(self, other: Pair) -> Pair {
            Pair(self.0 + other.0, self.1 + other.1)
        }
    }

    impl Sub for Pair {
        type Output = Pair;
        #[inline(always)]
        fn sub(self, other: Pair) -> Pair {
            Pair(self.0 - other.0, self.1 - other.1)
        }
    }

    impl Mul for Pair {
        type Output = Pair;
        #[inline(always)]
        fn mul(self, other: Pair) -> Pair {
            Pair(self.0 * other.0, self.1 * other.1)
        }
    }
}

#[cfg(not(all(target_arch = "x86_64", target_feature = "sse2")))]
pub(super) use array::Pair;
#[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
pub(super) use register::Pair;

macro_rules! register {
    ($pair:ty) => {
        impl Register for $pair {
            #[inline(always)]
            fn all(x: f64) -> Self {
                <$pair>::new(x, x)
            }

            #[inline(always)]
            fn mul_add<P: Policy>(a: Self, b: Self, c: Self) -> Self {
                if !P::FUSED {
                    return a * b + c;
                }
                <$pair>::fused(a, b, c)
            }

            #[inline(always)]
            fn turned(sin: Self, cos: Self, quarters: Self) -> (Self, Self) {
                <$pair>::turned(sin, cos, quarters)
            }
        }
    };
}

register!(Pair);

/// How many numbers [`sin_cos`] may be given.
pub(super) const MOST: usize = 32;

/// Sines and cosines of up to [`MOST`] numbers, two to a register, and those of numbers beyond the kernel's limit by `beyond`. There are no
/// loops, which would be taken apart too late.
#[inline(always)]
pub(super) fn sin_cos<P: Policy, const K: usize>(
    x: [f64; K],
    beyond: impl Fn([f64; K]) -> ([f64; K], [f64; K]),
) -> ([f64; K], [f64; K]) {
    let zero = Pair::all(0.0);
    let (mut sines, mut cosines, mut largest) = ([zero; MOST / 2], [zero; MOST / 2], zero);
    let (mut sin, mut cos) = ([0.0; K], [0.0; K]);
    macro_rules! all {
        ($($step:literal)*) => {
            $(if $step < const { K.div_ceil(2) } {
                let [i, first, second] = const { pair::<K>($step) };
                let x = Pair::new(x[first], x[second]);
                // Of a NaN come NaNs.
                largest = x.abs().max(largest);
                (sines[i], cosines[i]) = trigonometric::sin_cos::<P, Pair>(x);
            })*
            if largest.exceeds(trigonometric::limit::<P>()) {
                // From a copy, so that nothing but what is called only here has to be in memory.
                let mut copy = [0.0; K];
                for i in 0..K {
                    copy[i] = x[i];
                }
                let (s, c) = beyond(copy);
                $(if $step < const { K.div_ceil(2) } {
                    let [i, first, second] = const { pair::<K>($step) };
                    (sines[i], cosines[i]) = (Pair::new(s[first], s[second]), Pair::new(c[first], c[second]));
                })*
            }
            $(if $step < const { K.div_ceil(2) } {
                let [i, first, second] = const { pair::<K>($step) };
                let (s, c) = (sines[i].parts(), cosines[i].parts());
                (sin[second], cos[second]) = (s.1, c.1);
                (sin[first], cos[first]) = (s.0, c.0);
            })*
        };
    }
    all!(0 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15);
    (sin, cos)
}

/// Which pair of K numbers is computed in this step, and which numbers stand in it; a last one without a neighbour stands in it twice.
/// From both ends inwards, since chains of bodies are eliminated from both: a processor begins with the ends while it computes the
/// sines of the middle. Where registers may be wider, from eight numbers on neighbours one after the other, which then fill them.
const fn pair<const K: usize>(step: usize) -> [usize; 3] {
    let pairs = K.div_ceil(2);
    let i = match step {
        _ if step >= pairs || (K >= 8 && cfg!(target_feature = "fma")) => step,
        _ if step.is_multiple_of(2) => step / 2,
        _ => pairs - 1 - step / 2,
    };
    [i, 2 * i, if 2 * i + 1 < K { 2 * i + 1 } else { 2 * i }]
}

#[cfg(test)]
mod tests {
    use super::super::policy::{Fused, Plain};
    use super::*;

    register!(array::Pair);

    fn bits<V>((s, c): (V, V), parts: impl Fn(V) -> (f64, f64)) -> [u64; 4] {
        let (s, c) = (parts(s), parts(c));
        [s.0, s.1, c.0, c.1].map(f64::to_bits)
    }

    fn are_the_same<P: Policy>() {
        let mut x = -trigonometric::limit::<P>();
        while x < trigonometric::limit::<P>() {
            let y = -0.7 * x;
            let alone = [x, y].map(trigonometric::sin_cos_of_lane::<P>);
            assert_eq!(alone, [x, y].map(trigonometric::sin_cos::<P, f64>), "{x}");
            let alone = [alone[0].0, alone[1].0, alone[0].1, alone[1].1].map(f64::to_bits);
            assert_eq!(bits(trigonometric::sin_cos::<P, Pair>(Pair::new(x, y)), Pair::parts), alone, "{x}");
            let of_arrays = trigonometric::sin_cos::<P, array::Pair>(array::Pair::new(x, y));
            assert_eq!(bits(of_arrays, array::Pair::parts), alone, "{x}");
            x = 0.9973 * x + 1e-3 + x.abs() * 1e-2;
        }
    }

    #[test]
    fn each_has_the_bits_of_one_alone() {
        are_the_same::<Plain>();
        are_the_same::<Fused>();
    }

    #[test]
    fn the_largest_is_found_beside_nan() {
        let all = [0.5, -3.0, f64::NAN, f64::INFINITY, -1e300];
        for (x, y) in all.iter().flat_map(|x| all.map(|y| (*x, y))) {
            let expected = if x.abs() > y { x.abs() } else { y };
            let of_registers = Pair::new(x, 1.0).abs().max(Pair::new(y, 0.0));
            let of_arrays = array::Pair::new(x, 1.0).abs().max(array::Pair::new(y, 0.0));
            for found in [of_registers.parts(), of_arrays.parts()] {
                assert_eq!((found.0.to_bits(), found.1), (expected.to_bits(), 1.0), "{x} {y}");
            }
            for limit in [0.9, 2.0, 1e200] {
                let larger = expected > limit || 1.0 > limit;
                assert_eq!(
                    (of_registers.exceeds(limit), of_arrays.exceeds(limit)),
                    (larger, larger),
                    "{x} {y}"
                );
            }
        }
    }

    /// One that is too large in the same half of a register as a NaN, before or after it.
    #[test]
    fn large_numbers_are_not_lost_beside_nan() {
        let of_large = |x: [f64; 8]| x.map(|_| 2.0);
        for (large, nan) in [(0, 2), (2, 0), (1, 7), (7, 1)] {
            let mut x = [0.5; 8];
            (x[large], x[nan]) = (1e300, f64::NAN);
            let (sin, cos) = sin_cos::<Plain, 8>(x, |x| (of_large(x), of_large(x)));
            assert_eq!((sin, cos), ([2.0; 8], [2.0; 8]), "{large} {nan}");
        }
    }
}
