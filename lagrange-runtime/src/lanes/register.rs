//! Vector registers, by the instructions of the processor. (With `processor.rs`, all unsafe code.)
//!
//! There are values of these types, and of [`Lanes`](super::Lanes) made of them, only within
//! [`Processor::call`](super::Processor::call), which has asked the processor for its instructions: [`Avx2`](super::processor::Avx2)
//! and [`Avx512`](super::processor::Avx512) have no names outside of this crate.

#![allow(unsafe_code)]

use super::vector::Vector;

/// One register, filled from memory and stored there.
pub trait Register: Vector {
    /// Numbers in it.
    const WIDTH: usize;

    /// The numbers from `x[first]` on.
    ///
    /// # Panics
    /// If there are not as many. (Where both numbers are constants, as in packs, nothing is left of the question.)
    fn load<const L: usize>(x: &[f64; L], first: usize) -> Self;

    /// Stores them from `x[first]` on.
    ///
    /// # Panics
    /// As [`load`](Self::load).
    fn store<const L: usize>(self, x: &mut [f64; L], first: usize);
}

impl Register for f64 {
    const WIDTH: usize = 1;

    #[inline(always)]
    fn load<const L: usize>(x: &[f64; L], first: usize) -> Self {
        x[first]
    }

    #[inline(always)]
    fn store<const L: usize>(self, x: &mut [f64; L], first: usize) {
        x[first] = self;
    }
}

#[cfg(all(target_arch = "x86_64", feature = "std"))]
pub use x86::{Xmm, Ymm, Zmm};

#[cfg(all(target_arch = "x86_64", feature = "std"))]
mod x86 {
    use super::{Register, Vector};
    use core::arch::x86_64::*;
    use core::ops::{Add, Div, Mul, Neg, Sub};

    macro_rules! register {
        ($(#[$doc:meta])* $name:ident($register:ident, $integers:ident, $width:literal)
            splat $splat:ident, operators $add:ident $sub:ident $mul:ident $div:ident, sqrt $sqrt:ident,
            logic $and:ident $or:ident $xor:ident, shifts $left:ident $right:ident, sum $sum:ident,
            casts $to_integers:ident $from_integers:ident,
            fused($a:ident, $b:ident, $c:ident) $fused:expr,
            select($mask:ident, $yes:ident, $no:ident) $select:expr,
            all($bits:ident) $all:expr,
            compare($x:ident, $y:ident) $less:expr, $less_equal:expr, $equal:expr;
        ) => {
            $(#[$doc])*
            #[derive(Clone, Copy, Debug)]
            #[repr(transparent)]
            pub struct $name($register);

            register!(@operators $name Add add $add, Sub sub $sub, Mul mul $mul, Div div $div);

            impl Neg for $name {
                type Output = Self;
                #[inline(always)]
                fn neg(self) -> Self {
                    self.xor(Self::splat(-0.0))
                }
            }

            // SAFETY, of all calls below: the processor has the instructions, since there is a value of this type or one is
            // being made, which happens within `Processor::call` alone.
            impl Vector for $name {
                #[inline(always)]
                fn splat(x: f64) -> Self {
                    unsafe { $name($splat(x)) }
                }
                #[inline(always)]
                fn fused(self, $b: Self, $c: Self) -> Self {
                    let $a = self;
                    unsafe { $fused }
                }
                #[inline(always)]
                fn sqrt(self) -> Self {
                    unsafe { $name($sqrt(self.0)) }
                }
                #[inline(always)]
                fn and(self, o: Self) -> Self {
                    unsafe { $name($and(self.0, o.0)) }
                }
                #[inline(always)]
                fn or(self, o: Self) -> Self {
                    unsafe { $name($or(self.0, o.0)) }
                }
                #[inline(always)]
                fn xor(self, o: Self) -> Self {
                    unsafe { $name($xor(self.0, o.0)) }
                }
                #[inline(always)]
                fn left<const N: u32>(self) -> Self {
                    unsafe { $name($from_integers($left($to_integers(self.0), register!(@count $width N)))) }
                }
                #[inline(always)]
                fn right<const N: u32>(self) -> Self {
                    unsafe { $name($from_integers($right($to_integers(self.0), register!(@count $width N)))) }
                }
                #[inline(always)]
                fn add_bits(self, o: Self) -> Self {
                    unsafe { $name($from_integers($sum($to_integers(self.0), $to_integers(o.0)))) }
                }
                #[inline(always)]
                fn less(self, $y: Self) -> Self {
                    let $x = self;
                    unsafe { $less }
                }
                #[inline(always)]
                fn less_equal(self, $y: Self) -> Self {
                    let $x = self;
                    unsafe { $less_equal }
                }
                #[inline(always)]
                fn equal(self, $y: Self) -> Self {
                    let $x = self;
                    unsafe { $equal }
                }
                #[inline(always)]
                fn select(self, $yes: Self, $no: Self) -> Self {
                    let $mask = self;
                    unsafe { $select }
                }
                #[inline(always)]
                fn all(self) -> bool {
                    let $bits = self;
                    unsafe { $all }
                }
            }

            impl Register for $name {
                const WIDTH: usize = $width;

                #[inline(always)]
                fn load<const L: usize>(x: &[f64; L], first: usize) -> Self {
                    assert!(first <= L && $width <= L - first);
                    // SAFETY: the numbers are there, and any of them may be read without alignment.
                    unsafe { x.as_ptr().add(first).cast::<$name>().read_unaligned() }
                }

                #[inline(always)]
                fn store<const L: usize>(self, x: &mut [f64; L], first: usize) {
                    assert!(first <= L && $width <= L - first);
                    // SAFETY: there is room, and all bits are numbers.
                    unsafe { x.as_mut_ptr().add(first).cast::<$name>().write_unaligned(self) }
                }
            }
        };
        (@operators $name:ident $($trait:ident $method:ident $intrinsic:ident),*) => {$(
            impl $trait for $name {
                type Output = Self;
                #[inline(always)]
                fn $method(self, o: Self) -> Self {
                    // SAFETY: as of the others.
                    unsafe { $name($intrinsic(self.0, o.0)) }
                }
            }
        )*};
        // How many bits to shift by: a register of 128 bits with the number, as it is for all widths.
        (@count $width:literal $n:ident) => { _mm_cvtsi32_si128($n as i32) };
    }

    register! {
        /// Two numbers, with the instructions of every x86 of 64 bits.
        Xmm(__m128d, __m128i, 2)
            splat _mm_set1_pd, operators _mm_add_pd _mm_sub_pd _mm_mul_pd _mm_div_pd, sqrt _mm_sqrt_pd,
            logic _mm_and_pd _mm_or_pd _mm_xor_pd, shifts _mm_sll_epi64 _mm_srl_epi64, sum _mm_add_epi64,
            casts _mm_castpd_si128 _mm_castsi128_pd,
            fused(a, b, c) {
                #[cfg(target_feature = "fma")]
                {
                    Xmm(_mm_fmadd_pd(a.0, b.0, c.0))
                }
                #[cfg(not(target_feature = "fma"))]
                {
                    let ([a, d], [b, e], [c, f]): ([f64; 2], [f64; 2], [f64; 2]) =
                        (core::mem::transmute(a), core::mem::transmute(b), core::mem::transmute(c));
                    core::mem::transmute::<[f64; 2], Xmm>([a.mul_add(b, c), d.mul_add(e, f)])
                }
            },
            select(mask, yes, no) {
                // All bits as the highest one: there is no shift of 64 bits for it, but one of the upper halves.
                let mask = _mm_castsi128_pd(_mm_srai_epi32::<31>(_mm_shuffle_epi32::<0b11_11_01_01>(_mm_castpd_si128(mask.0))));
                Xmm(_mm_or_pd(_mm_and_pd(mask, yes.0), _mm_andnot_pd(mask, no.0)))
            },
            all(bits) _mm_movemask_pd(bits.0) == 0b11,
            compare(x, y) Xmm(_mm_cmplt_pd(x.0, y.0)), Xmm(_mm_cmple_pd(x.0, y.0)), Xmm(_mm_cmpeq_pd(x.0, y.0));
    }

    register! {
        /// Four numbers, with the instructions of AVX2 and fused multiply-adds.
        Ymm(__m256d, __m256i, 4)
            splat _mm256_set1_pd, operators _mm256_add_pd _mm256_sub_pd _mm256_mul_pd _mm256_div_pd, sqrt _mm256_sqrt_pd,
            logic _mm256_and_pd _mm256_or_pd _mm256_xor_pd, shifts _mm256_sll_epi64 _mm256_srl_epi64, sum _mm256_add_epi64,
            casts _mm256_castpd_si256 _mm256_castsi256_pd,
            fused(a, b, c) Ymm(_mm256_fmadd_pd(a.0, b.0, c.0)),
            select(mask, yes, no) Ymm(_mm256_blendv_pd(no.0, yes.0, mask.0)),
            all(bits) _mm256_movemask_pd(bits.0) == 0b1111,
            compare(x, y) Ymm(_mm256_cmp_pd::<_CMP_LT_OQ>(x.0, y.0)), Ymm(_mm256_cmp_pd::<_CMP_LE_OQ>(x.0, y.0)),
                Ymm(_mm256_cmp_pd::<_CMP_EQ_OQ>(x.0, y.0));
    }

    register! {
        /// Eight numbers, with the instructions of AVX-512.
        Zmm(__m512d, __m512i, 8)
            splat _mm512_set1_pd, operators _mm512_add_pd _mm512_sub_pd _mm512_mul_pd _mm512_div_pd, sqrt _mm512_sqrt_pd,
            logic _mm512_and_pd _mm512_or_pd _mm512_xor_pd, shifts _mm512_sll_epi64 _mm512_srl_epi64, sum _mm512_add_epi64,
            casts _mm512_castpd_si512 _mm512_castsi512_pd,
            fused(a, b, c) Zmm(_mm512_fmadd_pd(a.0, b.0, c.0)),
            select(mask, yes, no) {
                Zmm(_mm512_mask_blend_pd(_mm512_movepi64_mask(_mm512_castpd_si512(mask.0)), no.0, yes.0))
            },
            all(bits) _mm512_movepi64_mask(_mm512_castpd_si512(bits.0)) == u8::MAX,
            compare(x, y) mask(_mm512_cmp_pd_mask::<_CMP_LT_OQ>(x.0, y.0)), mask(_mm512_cmp_pd_mask::<_CMP_LE_OQ>(x.0, y.0)),
                mask(_mm512_cmp_pd_mask::<_CMP_EQ_OQ>(x.0, y.0));
    }

    /// All bits of the numbers whose bit is set.
    #[inline(always)]
    fn mask(bits: __mmask8) -> Zmm {
        // SAFETY: called for a comparison of two registers.
        unsafe { Zmm(_mm512_castsi512_pd(_mm512_movm_epi64(bits))) }
    }
}
