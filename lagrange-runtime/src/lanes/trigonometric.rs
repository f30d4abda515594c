//! Sine and cosine without branches, over any [`Vector`].
//!
//! The argument is reduced by quarter turns, `x = n π/2 + r` with |r| ≤ π/4 (W. J. Cody and W. Waite, *Software Manual for
//! the Elementary Functions*, 1980, ch. 8). Where x is next to a multiple of π/2, r may be as small as 1e-16, and still has all
//! its digits. The polynomials are those of Sun's fdlibm (`k_sin.c`, `k_cos.c`, 1993), summed
//! in pairs (Estrin) instead of one after the other, since here it is the time from argument to result that counts.

use super::kernels::pair;
use super::policy::Policy;
use super::vector::Vector;

/// Beyond this the quarter turns are too many for the products with the parts of π/2 to be exact: 2²⁰ of them where
/// products are rounded, and 2³⁰ where they are fused.
pub(super) const fn limit<P: Policy>() -> f64 {
    if P::FUSED { 1e9 } else { 1e6 }
}

/// Added to a number below 2⁵¹, it leaves the nearest integer in the last bits.
const ROUND: f64 = 1.5 * (1u64 << 52) as f64;

/// r, what it rounds away where that is more than half a unit of its last place, and n modulo 4 in the last two bits, of x ≥ 0.
#[inline(always)]
pub(super) fn reduced<P: Policy, V: Vector>(x: V) -> (V, V, V) {
    let splat = V::splat;
    let shifted = P::mul_add(x, splat(core::f64::consts::FRAC_2_PI), splat(ROUND));
    let n = shifted - splat(ROUND);
    let (r, rest) = if P::FUSED {
        // π/2 in three parts of 53 bits. The first difference is exact, since x and n π/2 agree in their leading bits; of the
        // others only one is rounded, since where the second is not exact, the third is too small to count.
        const PARTS: [f64; 3] =
            [core::f64::consts::FRAC_PI_2, 6.123233995736766e-17, -1.4973849048591698e-33];
        let first = P::mul_add(-n, splat(PARTS[0]), x);
        let second = P::mul_add(-n, splat(PARTS[1]), first);
        (P::mul_add(-n, splat(PARTS[2]), second), splat(0.0))
    } else {
        // π/2 in three parts of 33 bits, whose products with n of 20 bits are exact, and a fourth one.
        const PARTS: [f64; 4] =
            [1.5707963267341256, 6.077100506303966e-11, 2.0222662487111665e-21, 8.478427660348229e-32];
        let first = x - n * splat(PARTS[0]);
        let part = n * splat(PARTS[1]);
        let second = first - part;
        let rest = (first - second) - part;
        let part = n * splat(PARTS[2]);
        let r = second - part;
        (r, (((second - r) - part) + rest) - n * splat(PARTS[3]))
    };
    (r, rest, shifted)
}

/// Sine and cosine of `r + rest`, |r| ≤ π/4.
#[inline(always)]
#[allow(clippy::excessive_precision)] // Coefficients as they were published.
fn polynomials<P: Policy, V: Vector>(r: V, rest: V) -> (V, V) {
    const SIN: [f64; 6] = [
        -1.66666666666666324348e-01,
        8.33333333332248946124e-03,
        -1.98412698298579493134e-04,
        2.75573137070700676789e-06,
        -2.50507602534068634195e-08,
        1.58969099521155010221e-10,
    ];
    const COS: [f64; 6] = [
        4.16666666666666019037e-02,
        -1.38888888888741095749e-03,
        2.48015872894767294178e-05,
        -2.75573143513906633035e-07,
        2.08757232129817482790e-09,
        -1.13596475577881948265e-11,
    ];
    let r2 = r * r;
    let r4 = r2 * r2;
    let (sin, cos) = (series::<P, V>(r2, r4, &SIN), series::<P, V>(r2, r4, &COS));
    if P::FUSED {
        (P::mul_add(r2 * r, sin, r), P::mul_add(r4, cos, pair::<P, V>(r2, 1.0, -0.5)))
    } else {
        (
            r + P::mul_add(r2 * r, sin, rest),
            (V::splat(1.0) - V::splat(0.5) * r2) + P::mul_add(r4, cos, -(r * rest)),
        )
    }
}

/// `c₀ + c₁ x + … + c₅ x⁵`, of which x² is given as well. (No closure: one that is not inlined is compiled for the baseline.)
#[inline(always)]
fn series<P: Policy, V: Vector>(x: V, x2: V, c: &[f64; 6]) -> V {
    let high = P::mul_add(x2, pair::<P, V>(x, c[4], c[5]), pair::<P, V>(x, c[2], c[3]));
    P::mul_add(x2, high, pair::<P, V>(x, c[0], c[1]))
}

/// `(sin x, cos x)` for |x| ≤ [`limit`].
#[inline(always)]
pub(super) fn sin_cos<P: Policy, V: Vector>(x: V) -> (V, V) {
    let (r, rest, quarters) = reduced::<P, V>(x.abs());
    let (sin, cos) = polynomials::<P, V>(r, rest);
    // An odd number of quarter turns changes one for the other, two of them the sign. (The sine of −0 is −0, which rounded
    // arithmetic would forget: its sign is that of x.)
    let (half, odd) = (quarters.left::<62>(), quarters.left::<63>());
    let (sin, cos) = odd.exchange(sin, cos);
    (sin.xor(half.xor(x).sign()), cos.xor(half.xor(odd).sign()))
}
