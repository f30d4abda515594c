//! What kernels compute with: one `f64`, a vector register, or several of them.
//!
//! A kernel is written once, without branches, over [`Vector`]. IEEE 754 says what each operation gives, so that a number has
//! the same bits alone and in any register.

use core::ops::{Add, Div, Mul, Neg, Sub};

/// Numbers side by side, and the operations that a processor has for all of them at once.
///
/// Comparisons give masks: all bits of a number set where it holds, none where it does not.
pub trait Vector:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self>
{
    /// `x` everywhere.
    fn splat(x: f64) -> Self;
    /// These bits everywhere.
    #[inline(always)]
    fn bits(bits: u64) -> Self {
        Self::splat(f64::from_bits(bits))
    }
    /// `self a + b`, rounded once.
    fn fused(self, a: Self, b: Self) -> Self;
    /// √x, correctly rounded.
    fn sqrt(self) -> Self;
    /// Bitwise and.
    fn and(self, o: Self) -> Self;
    /// Bitwise or.
    fn or(self, o: Self) -> Self;
    /// Bitwise exclusive or.
    fn xor(self, o: Self) -> Self;
    /// The bits, shifted left.
    fn left<const N: u32>(self) -> Self;
    /// The bits, shifted right, zeros coming in.
    fn right<const N: u32>(self) -> Self;
    /// The sum of the bits as integers of 64 bits.
    fn add_bits(self, o: Self) -> Self;
    /// `self < o`.
    fn less(self, o: Self) -> Self;
    /// `self <= o`.
    fn less_equal(self, o: Self) -> Self;
    /// `self == o`.
    fn equal(self, o: Self) -> Self;
    /// `yes` where the highest bit is set, as it is in masks that hold; `no` elsewhere.
    fn select(self, yes: Self, no: Self) -> Self;
    /// Whether the highest bit is set everywhere.
    fn all(self) -> bool;

    /// `a` and `b`, exchanged where the highest bit is set.
    #[inline(always)]
    fn exchange(self, a: Self, b: Self) -> (Self, Self) {
        (self.select(b, a), self.select(a, b))
    }

    /// |x|.
    #[inline(always)]
    fn abs(self) -> Self {
        self.and(Self::bits(!SIGN))
    }

    /// The sign bit alone.
    #[inline(always)]
    fn sign(self) -> Self {
        self.and(Self::bits(SIGN))
    }
}

/// The bit of the sign.
pub(super) const SIGN: u64 = 1 << 63;

#[inline(always)]
fn mask(holds: bool) -> f64 {
    f64::from_bits(if holds { u64::MAX } else { 0 })
}

impl Vector for f64 {
    #[inline(always)]
    fn splat(x: f64) -> Self {
        x
    }
    #[inline(always)]
    fn fused(self, a: Self, b: Self) -> Self {
        #[cfg(feature = "std")]
        {
            self.mul_add(a, b)
        }
        #[cfg(not(feature = "std"))]
        {
            libm::fma(self, a, b)
        }
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        #[cfg(feature = "std")]
        {
            self.sqrt()
        }
        #[cfg(not(feature = "std"))]
        {
            libm::sqrt(self)
        }
    }
    #[inline(always)]
    fn and(self, o: Self) -> Self {
        f64::from_bits(self.to_bits() & o.to_bits())
    }
    #[inline(always)]
    fn or(self, o: Self) -> Self {
        f64::from_bits(self.to_bits() | o.to_bits())
    }
    #[inline(always)]
    fn xor(self, o: Self) -> Self {
        f64::from_bits(self.to_bits() ^ o.to_bits())
    }
    #[inline(always)]
    fn left<const N: u32>(self) -> Self {
        f64::from_bits(self.to_bits() << N)
    }
    #[inline(always)]
    fn right<const N: u32>(self) -> Self {
        f64::from_bits(self.to_bits() >> N)
    }
    #[inline(always)]
    fn add_bits(self, o: Self) -> Self {
        f64::from_bits(self.to_bits().wrapping_add(o.to_bits()))
    }
    #[inline(always)]
    fn less(self, o: Self) -> Self {
        mask(self < o)
    }
    #[inline(always)]
    fn less_equal(self, o: Self) -> Self {
        mask(self <= o)
    }
    #[inline(always)]
    fn equal(self, o: Self) -> Self {
        mask(self == o)
    }
    #[inline(always)]
    fn select(self, yes: Self, no: Self) -> Self {
        if self.to_bits() & SIGN != 0 { yes } else { no }
    }
    #[inline(always)]
    fn all(self) -> bool {
        self.to_bits() & SIGN != 0
    }
    // In a loop without instructions for a choice this is a third of the time.
    #[inline(always)]
    fn exchange(self, a: Self, b: Self) -> (Self, Self) {
        let (a, b) = (a.to_bits(), b.to_bits());
        let change = (a ^ b) & (self.to_bits() >> 63).wrapping_neg();
        (f64::from_bits(a ^ change), f64::from_bits(b ^ change))
    }
}
