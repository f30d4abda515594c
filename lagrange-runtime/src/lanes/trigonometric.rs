//! Sine and cosine without branches, for one number; a loop over lanes becomes vector instructions.
//!
//! The argument is reduced by quarter turns, `x = n π/2 + r` with |r| ≤ π/4 (W. J. Cody and W. Waite, *Software
//! Manual for the Elementary Functions*, 1980, ch. 8). Where x is next to a multiple of π/2, r may be as small as
//! 1e-16, and still has all its digits. The polynomials are those of Sun's fdlibm (`k_sin.c`, `k_cos.c`, 1993),
//! summed in pairs (Estrin) instead of one after the other, since here it is the time from argument to result that
//! counts.

use super::policy::Policy;
use core::ops::{Add, Mul, Sub};

/// Beyond this the quarter turns are too many for the products with the parts of π/2 to be exact: 2²⁰ of them where
/// products are rounded, and 2³⁰ where they are fused.
pub(super) const fn limit<P: Policy>() -> f64 {
    if P::FUSED { 1e9 } else { 1e6 }
}

/// Added to a number below 2⁵¹, it leaves the nearest integer in the last bits.
const ROUND: f64 = 1.5 * (1u64 << 52) as f64;

/// π/2 in three parts of 53 bits, all positive, so that −0 stays −0. The first difference is exact, since x and n π/2
/// agree in their leading bits; of the others only one is rounded, since where the second is not exact, the third is
/// too small to count.
const FUSED: [f64; 3] = [core::f64::consts::FRAC_PI_2, 6.123233995736765e-17, 1.082856673921914e-32];

/// π/2 in four parts, whose products with n of 20 bits are exact but for the last, which is too small to count unless
/// r is tiny. The first two differences are exact, too, since the first two parts are multiples of 2⁻⁵³, and so is
/// the third where r is small: one is rounded.
const ROUNDED: [f64; 4] =
    [1.5707963267341256, 6.077094383272197e-11, 6.12323399538461e-17, 3.5215598651832e-27];

/// Coefficients of the sine, as published.
#[allow(clippy::excessive_precision)]
const SIN: [f64; 6] = [
    -1.66666666666666324348e-01,
    8.33333333332248946124e-03,
    -1.98412698298579493134e-04,
    2.75573137070700676789e-06,
    -2.50507602534068634195e-08,
    1.58969099521155010221e-10,
];

/// Coefficients of the cosine.
#[allow(clippy::excessive_precision)]
const COS: [f64; 6] = [
    4.16666666666666019037e-02,
    -1.38888888888741095749e-03,
    2.48015872894767294178e-05,
    -2.75573143513906633035e-07,
    2.08757232129817482790e-09,
    -1.13596475577881948265e-11,
];

/// Operand of the kernel: a number, or several in one register.
pub(super) trait Register:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self>
{
    /// This number everywhere.
    fn all(x: f64) -> Self;
    /// `a b + c`
    fn mul_add<P: Policy>(a: Self, b: Self, c: Self) -> Self;
    /// Sine and cosine of an angle further by some quarter turns, whose number modulo 4 is in the last two bits of
    /// `quarters`.
    fn turned(sin: Self, cos: Self, quarters: Self) -> (Self, Self);
}

impl Register for f64 {
    #[inline(always)]
    fn all(x: f64) -> f64 {
        x
    }

    #[inline(always)]
    fn mul_add<P: Policy>(a: f64, b: f64, c: f64) -> f64 {
        P::mul_add(a, b, c)
    }

    #[inline(always)]
    fn turned(sin: f64, cos: f64, quarters: f64) -> (f64, f64) {
        const SIGN: u64 = 1 << 63;
        let (sin, cos, quarters) = (sin.to_bits(), cos.to_bits(), quarters.to_bits());
        // An odd number of quarter turns changes one for the other, with another sign of what becomes the cosine; two
        // of them change both signs.
        let odd = (quarters & 1).wrapping_neg();
        let change = ((sin ^ cos) & odd) ^ ((quarters << 62) & SIGN);
        (f64::from_bits(sin ^ change), f64::from_bits(cos ^ change ^ (odd & SIGN)))
    }
}

/// r, and a number with n modulo 4 in the last two bits.
#[inline(always)]
pub(super) fn reduced<P: Policy, V: Register>(x: V) -> (V, V) {
    let shifted = V::mul_add::<P>(x, V::all(core::f64::consts::FRAC_2_PI), V::all(ROUND));
    let n = shifted - V::all(ROUND);
    let r = if P::FUSED {
        let first = V::mul_add::<P>(n, V::all(-FUSED[0]), x);
        let second = V::mul_add::<P>(n, V::all(-FUSED[1]), first);
        V::mul_add::<P>(n, V::all(-FUSED[2]), second)
    } else {
        let part = |i: usize| V::all(ROUNDED[i]);
        (((x - n * part(0)) - n * part(1)) - n * part(2)) - n * part(3)
    };
    (r, shifted)
}

/// Sine and cosine of r, |r| ≤ π/4. The sine of −0 is −0.
#[inline(always)]
fn polynomials<P: Policy, V: Register>(r: V) -> (V, V) {
    let (f, all) = (V::mul_add::<P>, V::all);
    let r2 = r * r;
    let r4 = r2 * r2;
    // sin r / r − 1, which is +0 at r = ±0 since its last sum is that of 0 and −0.
    let rest = f(r4, f(r4, all(SIN[5]), f(r2, all(SIN[4]), all(SIN[3]))), f(r2, all(SIN[2]), all(SIN[1])));
    let sin = f(r4, rest, all(SIN[0]) * r2);
    let high = f(r4, f(r2, all(COS[5]), all(COS[4])), f(r2, all(COS[3]), all(COS[2])));
    let cos = f(r4, high, f(r2, all(COS[1]), all(COS[0])));
    let (half, one) = (all(0.5), all(1.0));
    let cos = if P::FUSED { f(r4, cos, f(r2, all(-0.5), one)) } else { one - (half * r2 - r4 * cos) };
    (f(r, sin, r), cos)
}

/// `(sin x, cos x)` for |x| ≤ [`limit`].
#[inline(always)]
pub(super) fn sin_cos<P: Policy, V: Register>(x: V) -> (V, V) {
    let (r, quarters) = reduced::<P, V>(x);
    let (sin, cos) = polynomials::<P, V>(r);
    V::turned(sin, cos, quarters)
}

/// The same of one number in a loop over lanes: number by number as above, but written out. What the optimiser finds
/// in a loop over the general one it takes apart into single numbers (docs/lab/performance.md).
#[inline(always)]
pub(super) fn sin_cos_of_lane<P: Policy>(x: f64) -> (f64, f64) {
    let shifted = P::mul_add(x, core::f64::consts::FRAC_2_PI, ROUND);
    let n = shifted - ROUND;
    let r = if P::FUSED {
        let first = P::mul_add(-n, FUSED[0], x);
        let second = P::mul_add(-n, FUSED[1], first);
        P::mul_add(-n, FUSED[2], second)
    } else {
        (((x - n * ROUNDED[0]) - n * ROUNDED[1]) - n * ROUNDED[2]) - n * ROUNDED[3]
    };
    let f = P::mul_add;
    let r2 = r * r;
    let r4 = r2 * r2;
    let rest = f(r4, f(r4, SIN[5], f(r2, SIN[4], SIN[3])), f(r2, SIN[2], SIN[1]));
    let sin = f(r, f(r4, rest, SIN[0] * r2), r);
    let cos = f(r4, f(r4, f(r2, COS[5], COS[4]), f(r2, COS[3], COS[2])), f(r2, COS[1], COS[0]));
    let cos = if P::FUSED { f(r4, cos, f(r2, -0.5, 1.0)) } else { 1.0 - (0.5 * r2 - r4 * cos) };
    <f64 as Register>::turned(sin, cos, shifted)
}
