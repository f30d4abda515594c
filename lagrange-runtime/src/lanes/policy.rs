//! Rounding of `a b + c`.

use core::fmt::Debug;

/// Rounding of `a b + c`, in [`Scalar::mul_add`](crate::Scalar::mul_add) and within the elementary functions: the one
/// thing in which processors differ. Everything else is IEEE 754 arithmetic, in the order in which it is written (Rust
/// never contracts `a * b + c` by itself), so a policy fixes every bit.
pub trait Policy: Copy + Debug + Default + PartialEq + Send + Sync + 'static {
    /// True for one rounding ([`Fused`]), false for two ([`Plain`]).
    const FUSED: bool;

    /// `a b + c` under this policy.
    fn mul_add(a: f64, b: f64, c: f64) -> f64;
}

/// `a b + c` with two roundings, on any processor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Plain;

impl Policy for Plain {
    const FUSED: bool = false;

    #[inline(always)]
    fn mul_add(a: f64, b: f64, c: f64) -> f64 {
        a * b + c
    }
}

/// `a b + c` with one rounding, on any processor. One that has no instruction for it (x86 before 2013) takes a hundred
/// times as long.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Fused;

impl Policy for Fused {
    const FUSED: bool = true;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn mul_add(a: f64, b: f64, c: f64) -> f64 {
        #[cfg(feature = "std")]
        {
            a.mul_add(b, c)
        }
        #[cfg(not(feature = "std"))]
        {
            libm::fma(a, b, c)
        }
    }
}

/// The policy of `f64` itself: [`Fused`] where the target of the compilation has the instruction, [`Plain`] elsewhere.
#[cfg(all(target_feature = "fma", feature = "std"))]
pub type Native = Fused;
/// The policy of `f64` itself: [`Fused`] where the target of the compilation has the instruction, [`Plain`] elsewhere.
#[cfg(not(all(target_feature = "fma", feature = "std")))]
pub type Native = Plain;
