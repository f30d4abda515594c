//! Elementary functions of one number without branches: each gives its value, and whether the value holds. A loop
//! over lanes becomes vector instructions.
//!
//! Methods and coefficients are those of Sun's fdlibm (1993) and of FreeBSD's libm after it, where a source names no
//! other: Cody and Waite's reduction (*Software Manual for the Elementary Functions*, 1980), then a polynomial or a
//! quotient of two. What they decide by branches is decided here by a choice of two numbers that both are computed.
//! Exponential functions have the Taylor polynomial of degree 13, which is short of e^r by 4·10⁻¹⁸ at most for |r| ≤
//! ln 2 / 2.
//!
//! No closures and no functions of `core` that may not be inlined (`f64::clamp`): what is not inlined is compiled for
//! the baseline, at ten times the cost.

#![allow(clippy::excessive_precision)] // Coefficients as they were published.

use super::policy::Policy;
use super::trigonometric;
use core::f64::consts::{FRAC_PI_2, FRAC_PI_4, LN_2, LOG2_E};

/// Added to a number below 2⁵¹, it leaves the nearest integer in the last bits.
const ROUND: f64 = 1.5 * (1u64 << 52) as f64;
/// ln 2 in two parts, the first of which is short enough for exact products with exponents.
const LN2: [f64; 2] = [6.93147180369123816490e-01, 1.90821492927058770002e-10];
/// The upper half of a number.
const UPPER: u64 = 0xffff_ffff_0000_0000;
/// π/2 less [`FRAC_PI_2`].
const FRAC_PI_2_REST: f64 = 6.12323399573676603587e-17;

/// `c₀ + c₁ x + c₂ x² + …`
#[inline(always)]
fn horner<P: Policy, const K: usize>(x: f64, c: [f64; K]) -> f64 {
    let mut sum = c[K - 1];
    let mut k = K - 1;
    while k > 0 {
        k -= 1;
        sum = P::mul_add(sum, x, c[k]);
    }
    sum
}

/// `c₀ + c₁ x`
#[inline(always)]
fn pair<P: Policy>(x: f64, c0: f64, c1: f64) -> f64 {
    P::mul_add(x, c1, c0)
}

/// The upper half of the bits.
#[inline(always)]
fn upper(x: f64) -> f64 {
    f64::from_bits(x.to_bits() & UPPER)
}

/// The larger and the smaller one.
#[inline(always)]
fn sorted(a: f64, b: f64) -> (f64, f64) {
    if a < b { (b, a) } else { (a, b) }
}

/// Returns whether `low ≤ x ≤ high`, without the branch of `&&`.
#[inline(always)]
fn between(low: f64, x: f64, high: f64) -> bool {
    (low <= x) & (x <= high)
}

/// The correctly rounded root.
#[inline(always)]
fn root(x: f64) -> f64 {
    #[cfg(feature = "std")]
    {
        x.sqrt()
    }
    #[cfg(not(feature = "std"))]
    {
        libm::sqrt(x)
    }
}

/// e^r − 1 for |r| ≤ ln 2 / 2.
#[inline(always)]
fn power<P: Policy>(r: f64) -> f64 {
    // 1/2!, 1/3!, …, 1/13!, summed in pairs.
    const C: [f64; 12] = {
        let (mut c, mut factorial, mut k) = ([0.0; 12], 1.0, 0);
        while k < 12 {
            factorial *= (k + 2) as f64;
            c[k] = 1.0 / factorial;
            k += 1;
        }
        c
    };
    let r2 = r * r;
    let r4 = r2 * r2;
    let low = P::mul_add(r2, pair::<P>(r, C[2], C[3]), pair::<P>(r, C[0], C[1]));
    let middle = P::mul_add(r2, pair::<P>(r, C[6], C[7]), pair::<P>(r, C[4], C[5]));
    let high = P::mul_add(r2, pair::<P>(r, C[10], C[11]), pair::<P>(r, C[8], C[9]));
    P::mul_add(r2, P::mul_add(r4, P::mul_add(r4, high, middle), low), r)
}

/// n in the last bits, and x − n ln 2.
#[inline(always)]
fn octaves<P: Policy>(x: f64) -> (f64, f64) {
    let shifted = P::mul_add(x, LOG2_E, ROUND);
    let n = shifted - ROUND;
    let r = P::mul_add(-n, LN2[0], x);
    (shifted, P::mul_add(-n, LN2[1], r))
}

/// `2ⁿ x`, n in the last bits.
#[inline(always)]
fn scaled(x: f64, n: f64) -> f64 {
    f64::from_bits(x.to_bits().wrapping_add(n.to_bits() << 52))
}

#[inline(always)]
pub(super) fn exp<P: Policy>(x: f64) -> (f64, bool) {
    let (n, r) = octaves::<P>(x);
    (scaled(1.0 + power::<P>(r), n), x.abs() <= 708.0)
}

#[inline(always)]
pub(super) fn exp2<P: Policy>(x: f64) -> (f64, bool) {
    let n = x + ROUND;
    let r = (x - (n - ROUND)) * LN_2;
    (scaled(1.0 + power::<P>(r), n), x.abs() <= 1021.0)
}

#[inline(always)]
pub(super) fn exp_m1<P: Policy>(x: f64) -> (f64, bool) {
    let (n, r) = octaves::<P>(x);
    let one = 1.0;
    let scale = scaled(one, n);
    // The sign of x, for −0.
    let value = P::mul_add(scale, power::<P>(r), scale - one).copysign(x);
    (value, x.abs() <= 708.0)
}

/// A positive number as `2ᵏ m`, m from √½ or another `lowest` (of which the upper half counts) to twice that.
#[inline(always)]
fn normalized(x: f64, lowest: f64) -> (f64, f64) {
    const MANTISSA: u64 = (1 << 52) - 1;
    const INTEGER: f64 = (1u64 << 52) as f64;
    let lowest = lowest.to_bits() & UPPER;
    let raised = x.to_bits().wrapping_add(1f64.to_bits() - lowest);
    // An exponent in the last bits of an integer of 53 bits.
    let k = f64::from_bits((raised >> 52) | INTEGER.to_bits()) - (INTEGER + 1023.0);
    (k, f64::from_bits((raised & MANTISSA) + lowest))
}

/// `ln(1 + f) − f + f²/2` for √½ ≤ 1 + f ≤ √2, and f²/2.
#[inline(always)]
fn logarithm<P: Policy>(f: f64) -> (f64, f64) {
    let s = f / (2.0 + f);
    let z = s * s;
    let w = z * z;
    let even =
        w * horner::<P, 3>(w, [3.999999999940941908e-01, 2.222219843214978396e-01, 1.531383769920937332e-01]);
    let odd = z * horner::<P, 4>(
        w,
        [
            6.666666666666735130e-01,
            2.857142874366239149e-01,
            1.818357216161805012e-01,
            1.479819860511658591e-01,
        ],
    );
    let half = 0.5 * (f * f);
    (s * (half + (even + odd)), half)
}

const SQRT_HALF: f64 = core::f64::consts::FRAC_1_SQRT_2;

#[inline(always)]
pub(super) fn ln<P: Policy>(x: f64) -> (f64, bool) {
    let (k, m) = normalized(x, SQRT_HALF);
    let f = m - 1.0;
    let (rest, half) = logarithm::<P>(f);
    let rest = P::mul_add(k, LN2[1], rest);
    let value = P::mul_add(k, LN2[0], f - (half - rest));
    (value, between(f64::MIN_POSITIVE, x, f64::MAX))
}

#[inline(always)]
pub(super) fn ln_1p<P: Policy>(x: f64) -> (f64, bool) {
    let one = 1.0;
    let u = one + x;
    // What 1 + x is rounded by.
    let lost = (if one < x { one - (u - x) } else { x - (u - one) }) / u;
    let (k, m) = normalized(u, SQRT_HALF);
    let f = m - one;
    let (rest, half) = logarithm::<P>(f);
    let rest = rest + P::mul_add(k, LN2[1], lost);
    let value = P::mul_add(k, LN2[0], f - (half - rest)).copysign(x);
    (value, (-1.0 < x) & (x <= 1e300))
}

/// The logarithm whose base has 1/ln = `[ivln_hi, ivln_lo]` and log 2 = `[two_hi, two_lo]`, in double precision and a
/// half.
#[inline(always)]
fn logarithm_to<P: Policy>(x: f64, ivln: [f64; 2], two: [f64; 2]) -> (f64, bool) {
    let (k, m) = normalized(x, SQRT_HALF);
    let f = m - 1.0;
    let (rest, half) = logarithm::<P>(f);
    let high = upper(f - half);
    let low = (f - high) - half + rest;
    let whole = k * two[0];
    let product = high * ivln[0];
    let rest = k * two[1] + (low + high) * ivln[1] + low * ivln[0];
    let sum = whole + product;
    (rest + ((whole - sum) + product) + sum, between(f64::MIN_POSITIVE, x, f64::MAX))
}

#[inline(always)]
pub(super) fn log2<P: Policy>(x: f64) -> (f64, bool) {
    logarithm_to::<P>(x, [1.44269504072144627571e+00, 1.67517131648865118353e-10], [1.0, 0.0])
}

#[inline(always)]
pub(super) fn log10<P: Policy>(x: f64) -> (f64, bool) {
    logarithm_to::<P>(
        x,
        [4.34294481878168880939e-01, 2.50829467116452752298e-11],
        [3.01029995663611771306e-01, 3.69423907715893078616e-13],
    )
}

#[inline(always)]
pub(super) fn cbrt<P: Policy>(x: f64) -> (f64, bool) {
    const INTEGER: f64 = (1u64 << 52) as f64;
    let a = x.abs();
    // A third of the upper half of the bits, and so of the exponent, has the root to 5 bits.
    let upper = f64::from_bits((a.to_bits() >> 32) | INTEGER.to_bits()) - INTEGER;
    let t = upper * (1.0 / 3.0) + (INTEGER + 715_094_163.0);
    let t = f64::from_bits(t.to_bits() << 32);
    // A polynomial brings 23 bits, and no more are kept, so that t² is exact.
    let r = (t * t) * (t / a);
    let t = t * horner::<P, 5>(
        r,
        [
            1.87595182427177009643,
            -1.88497980543377169875,
            1.621429720105354466140,
            -0.758397934778766047437,
            0.145996192886612446982,
        ],
    );
    let t = f64::from_bits((t.to_bits().wrapping_add(0x8000_0000)) & 0xffff_ffff_c000_0000);
    // Newton's step.
    let r = a / (t * t);
    let r = (r - t) / (t + t + r);
    let value = P::mul_add(t, r, t);
    (value.copysign(x), between(f64::MIN_POSITIVE, a, f64::MAX))
}

#[inline(always)]
pub(super) fn hypot<P: Policy>(x: f64, y: f64) -> (f64, bool) {
    let (large, small) = sorted(x.abs(), y.abs());
    (root(P::mul_add(large, large, small * small)), between(1e-140, large, 1e150) & (small <= large))
}

#[inline(always)]
pub(super) fn sin_cos<P: Policy>(x: f64) -> ((f64, f64), bool) {
    (trigonometric::sin_cos_of_lane::<P>(x), x.abs() <= trigonometric::limit::<P>())
}

#[inline(always)]
pub(super) fn tan<P: Policy>(x: f64) -> (f64, bool) {
    let ((sin, cos), good) = sin_cos::<P>(x);
    (sin / cos, good)
}

/// `(asin √z) / √z − 1` for 0 ≤ z ≤ 1/4.
#[inline(always)]
fn arc<P: Policy>(z: f64) -> f64 {
    let p = z * horner::<P, 6>(
        z,
        [
            1.66666666666666657415e-01,
            -3.25565818622400915405e-01,
            2.01212532134862925881e-01,
            -4.00555345006794114027e-02,
            7.91534994289814532176e-04,
            3.47933107596021167570e-05,
        ],
    );
    let q = horner::<P, 5>(
        z,
        [
            1.0,
            -2.40339491173441421878e+00,
            2.02094576023350569471e+00,
            -6.88283971605453293030e-01,
            7.70381505559019352791e-02,
        ],
    );
    p / q
}

/// Reduction of a = |x|: whether a is below 1/2; s, which is a or √((1 − a)/2); the rounding error of s; and asin s −
/// s.
#[inline(always)]
fn half_arc<P: Policy>(a: f64) -> (bool, f64, f64, f64) {
    let (one, half) = (1.0, 0.5);
    let small = a < half;
    let z = if small { a * a } else { (one - a) * half };
    let root = root(z);
    let s = if small { a } else { root };
    // √z less its upper half, from z less the square of that.
    let high = upper(root);
    let lost = (z - high * high) / (root + high) - (root - high);
    let lost = if small | (z == 0.0) { 0.0 } else { lost };
    (small, s, lost, s * arc::<P>(z))
}

#[inline(always)]
pub(super) fn asin<P: Policy>(x: f64) -> (f64, bool) {
    let a = x.abs();
    let (small, s, lost, rest) = half_arc::<P>(a);
    let (quarter, quarter_rest) = (FRAC_PI_2, FRAC_PI_2_REST);
    // π/2 − 2 asin √((1 − a)/2)
    let large = (quarter - (s + s)) - ((rest + rest) - (quarter_rest - (lost + lost)));
    let value = if small { s + rest } else { large };
    (value.copysign(x), a <= 1.0)
}

#[inline(always)]
pub(super) fn acos<P: Policy>(x: f64) -> (f64, bool) {
    let (small, s, lost, rest) = half_arc::<P>(x.abs());
    let (quarter, quarter_rest) = (FRAC_PI_2, FRAC_PI_2_REST);
    let sign = 1f64.copysign(x);
    // π/2 − asin x, or 2 asin √((1 − a)/2), or π less that.
    let middle = quarter - (sign * s - (quarter_rest - sign * rest));
    let twice = s + s + (rest + rest + (lost + lost));
    let behind = (quarter - s) - (rest + lost - quarter_rest);
    let outer = if sign < 0.0 { behind + behind } else { twice };
    (if small { middle } else { outer }, x.abs() <= 1.0)
}

/// The number at the first condition that holds, or the last one.
#[inline(always)]
fn chosen(holds: [bool; 4], c: [f64; 5]) -> f64 {
    let upper = if holds[2] { c[2] } else { if holds[3] { c[3] } else { c[4] } };
    let lower = if holds[0] { c[0] } else { c[1] };
    if holds[1] { lower } else { upper }
}

/// The angle of (x, y) for x, y ≥ 0: by the tangent of its difference to the nearest of five angles.
#[inline(always)]
fn angle<P: Policy>(y: f64, x: f64) -> f64 {
    let first = y < 0.4375 * x;
    let second = y < 0.6875 * x;
    let third = y < 1.1875 * x;
    let fourth = y < 2.4375 * x;
    let holds = [first, second, third, fourth];
    let b = chosen(holds, [0.0, 0.5, 1.0, 1.5, 0.0]);
    // Beyond the last one the difference to π/2 has the tangent −x/y.
    let numerator = if fourth { P::mul_add(-b, x, y) } else { -x };
    let denominator = if fourth { P::mul_add(b, y, x) } else { y };
    let high =
        chosen(holds, [0.0, 4.63647609000806093515e-01, FRAC_PI_4, 9.82793723247329054082e-01, FRAC_PI_2]);
    let low = chosen(
        holds,
        [
            0.0,
            2.26987774529616870924e-17,
            3.06161699786838301793e-17,
            1.39033110312309984516e-17,
            FRAC_PI_2_REST,
        ],
    );
    let t = numerator / denominator;
    let z = t * t;
    let w = z * z;
    let odd = z * horner::<P, 6>(
        w,
        [
            3.33333333333329318027e-01,
            1.42857142725034663711e-01,
            9.09088713343650656196e-02,
            6.66107313738753120669e-02,
            4.97687799461593236017e-02,
            1.62858201153657823623e-02,
        ],
    );
    let even = w * horner::<P, 5>(
        w,
        [
            -1.99999999998764832476e-01,
            -1.11111104054623557880e-01,
            -7.69187620504482999495e-02,
            -5.83357013379057348645e-02,
            -3.65315727442169155270e-02,
        ],
    );
    high - ((t * (odd + even) - low) - t)
}

#[inline(always)]
pub(super) fn atan<P: Policy>(x: f64) -> (f64, bool) {
    let a = x.abs();
    (angle::<P>(a, 1.0).copysign(x), a <= 1e300)
}

#[inline(always)]
pub(super) fn atan2<P: Policy>(y: f64, x: f64) -> (f64, bool) {
    let (a, b) = (y.abs(), x.abs());
    let (large, small) = sorted(a, b);
    let angle = angle::<P>(a, b);
    let behind = core::f64::consts::PI - (angle - (2.0 * FRAC_PI_2_REST));
    let value = (if x.is_sign_negative() { behind } else { angle }).copysign(y);
    let good = between(1e-150, large, 1e150) & ((small == 0.0) | (1e-150 <= small));
    (value, good)
}

#[inline(always)]
pub(super) fn sinh<P: Policy>(x: f64) -> (f64, bool) {
    let (t, good) = exp_m1::<P>(x.abs());
    ((0.5 * (t + t / (t + 1.0))).copysign(x), good)
}

#[inline(always)]
pub(super) fn cosh<P: Policy>(x: f64) -> (f64, bool) {
    let (e, good) = exp::<P>(x.abs());
    (0.5 * (e + 1.0 / e), good)
}

#[inline(always)]
pub(super) fn tanh<P: Policy>(x: f64) -> (f64, bool) {
    let a = x.abs();
    // 1 from there on.
    let limit = 20.0;
    let near = if a < limit { a } else { limit };
    let (t, _) = exp_m1::<P>(near + near);
    ((t / (t + 2.0)).copysign(x), a <= f64::MAX)
}

#[inline(always)]
pub(super) fn asinh<P: Policy>(x: f64) -> (f64, bool) {
    let (a, one) = (x.abs(), 1.0);
    let square = a * a;
    // x + √(1 + x²) − 1
    let (value, _) = ln_1p::<P>(a + square / (one + root(one + square)));
    (value.copysign(x), a <= 1e150)
}

#[inline(always)]
pub(super) fn acosh<P: Policy>(x: f64) -> (f64, bool) {
    let t = x - 1.0;
    let (value, _) = ln_1p::<P>(t + root(P::mul_add(t, t, t + t)));
    (value, between(1.0, x, 1e150))
}

#[inline(always)]
pub(super) fn atanh<P: Policy>(x: f64) -> (f64, bool) {
    let (a, one) = (x.abs(), 1.0);
    let (value, _) = ln_1p::<P>((a + a) / (one - a));
    ((0.5 * value).copysign(x), a < one)
}

/// xʸ = 2^(y log₂ x), with log₂ x and its product in two numbers each, whose upper halves multiply exactly.
#[inline(always)]
pub(super) fn powf<P: Policy>(x: f64, y: f64) -> (f64, bool) {
    const SQRT_3: f64 = 1.732_050_807_568_877_2;
    // ln m = ln b + 2 artanh s, with b = 1 or 3/2 and s = (m − b)/(m + b).
    let (k, m) = normalized(x, 0.5 * SQRT_3);
    let upper_half = 1.224_744_871_391_589 < m;
    let b = if upper_half { 1.5 } else { 1.0 };
    let (difference, inverse) = (m - b, 1.0 / (m + b));
    let s = difference * inverse;
    let s_high = upper(s);
    let sum_high = upper(m + b);
    let sum_low = m - (sum_high - b);
    let s_low = inverse * ((difference - s_high * sum_high) - s_high * sum_low);
    let z = s * s;
    let series = (z * z)
        * horner::<P, 6>(
            z,
            [
                5.99999999999994648725e-01,
                4.28571428578550184252e-01,
                3.33333329818377432918e-01,
                2.72728123808534006489e-01,
                2.30660745775561754067e-01,
                2.06975017800338417784e-01,
            ],
        )
        + s_low * (s_high + s);
    let square = s_high * s_high;
    let t_high = upper(3.0 + square + series);
    let t_low = series - ((t_high - 3.0) - square);
    let (u, v) = (s_high * t_high, s_low * t_high + t_low * s);
    let p_high = upper(u + v);
    let p_low = v - (p_high - u);
    // 2/(3 ln 2), and log₂ b.
    let z_high = 9.61796700954437255859e-01 * p_high;
    let z_low = -7.02846165095275826516e-09 * p_high
        + p_low * 9.61796693925975554329e-01
        + if upper_half { 1.35003920212974897128e-08 } else { 0.0 };
    let b_high = if upper_half { 5.84962487220764160156e-01 } else { 0.0 };
    let log_high = upper(((z_high + z_low) + b_high) + k);
    let log_low = z_low - (((log_high - k) - b_high) - z_high);

    let y_high = upper(y);
    let low = (y - y_high) * log_high + y * log_low;
    let high = y_high * log_high;
    let exponent = low + high;

    let shifted = exponent + ROUND;
    let high = high - (shifted - ROUND);
    let t = upper(low + high);
    let u = t * 6.93147182464599609375e-01;
    let v = (low - (t - high)) * LN_2 + t * -1.90465429995776804525e-09;
    let z = u + v;
    let w = v - (z - u);
    let t = z * z;
    let t = z - t * horner::<P, 5>(
        t,
        [
            1.66666666666666019037e-01,
            -2.77777777770155933842e-03,
            6.61375632143793436117e-05,
            -1.65339022054652515390e-06,
            4.13813679705723846039e-08,
        ],
    );
    let r = (z * t) / (t - 2.0) - (w + z * w);
    let value = scaled(1.0 - (r - z), shifted);
    let good = between(f64::MIN_POSITIVE, x, f64::MAX) & (exponent.abs() <= 1020.0) & (y.abs() <= 1e18);
    (value, good)
}
