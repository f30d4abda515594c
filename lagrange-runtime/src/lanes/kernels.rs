//! Elementary functions without branches, over any [`Vector`]: each gives its value, and where the value holds.
//!
//! Methods and coefficients are those of Sun's fdlibm (1993) and of FreeBSD's libm after it, where a source names no other: Cody
//! and Waite's reduction (*Software Manual for the Elementary Functions*, 1980), then a polynomial or a quotient of two. What they
//! decide by branches is decided here by masks. Exponential functions have the Taylor polynomial of degree 13, which is short of e^r
//! by 4·10⁻¹⁸ at most for |r| ≤ ln 2 / 2.
//!
//! No closures: one that is not inlined is compiled for the baseline, at ten times the cost.

#![allow(clippy::excessive_precision)] // Coefficients as they were published.

use super::policy::Policy;
use super::trigonometric;
use super::vector::{SIGN, Vector};
use core::f64::consts::{FRAC_PI_2, LN_2, LOG2_E};

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
fn horner<P: Policy, V: Vector, const K: usize>(x: V, c: [f64; K]) -> V {
    let mut sum = V::splat(c[K - 1]);
    let mut k = K - 1;
    while k > 0 {
        k -= 1;
        sum = P::mul_add(sum, x, V::splat(c[k]));
    }
    sum
}

/// `c₀ + c₁ x`
#[inline(always)]
pub(super) fn pair<P: Policy, V: Vector>(x: V, c0: f64, c1: f64) -> V {
    P::mul_add(x, V::splat(c1), V::splat(c0))
}

/// The upper half of the bits.
#[inline(always)]
fn upper<V: Vector>(x: V) -> V {
    x.and(V::bits(UPPER))
}

/// low ≤ x ≤ high
#[inline(always)]
fn between<V: Vector>(low: f64, x: V, high: f64) -> V {
    V::splat(low).less_equal(x).and(x.less_equal(V::splat(high)))
}

/// The larger and the smaller one.
#[inline(always)]
fn sorted<V: Vector>(a: V, b: V) -> (V, V) {
    let less = a.less(b);
    (less.select(b, a), less.select(a, b))
}

/// e^r − 1 for |r| ≤ ln 2 / 2.
#[inline(always)]
fn power<P: Policy, V: Vector>(r: V) -> V {
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
    let low = P::mul_add(r2, pair::<P, V>(r, C[2], C[3]), pair::<P, V>(r, C[0], C[1]));
    let middle = P::mul_add(r2, pair::<P, V>(r, C[6], C[7]), pair::<P, V>(r, C[4], C[5]));
    let high = P::mul_add(r2, pair::<P, V>(r, C[10], C[11]), pair::<P, V>(r, C[8], C[9]));
    P::mul_add(r2, P::mul_add(r4, P::mul_add(r4, high, middle), low), r)
}

/// n in the last bits, and x − n ln 2.
#[inline(always)]
fn octaves<P: Policy, V: Vector>(x: V) -> (V, V) {
    let shifted = P::mul_add(x, V::splat(LOG2_E), V::splat(ROUND));
    let n = shifted - V::splat(ROUND);
    let r = P::mul_add(-n, V::splat(LN2[0]), x);
    (shifted, P::mul_add(-n, V::splat(LN2[1]), r))
}

/// `2ⁿ x`, n in the last bits.
#[inline(always)]
fn scaled<V: Vector>(x: V, n: V) -> V {
    x.add_bits(n.left::<52>())
}

#[inline(always)]
pub(super) fn exp<P: Policy, V: Vector>(x: V) -> (V, V) {
    let (n, r) = octaves::<P, V>(x);
    (scaled(V::splat(1.0) + power::<P, V>(r), n), x.abs().less_equal(V::splat(708.0)))
}

#[inline(always)]
pub(super) fn exp2<P: Policy, V: Vector>(x: V) -> (V, V) {
    let n = x + V::splat(ROUND);
    let r = (x - (n - V::splat(ROUND))) * V::splat(LN_2);
    (scaled(V::splat(1.0) + power::<P, V>(r), n), x.abs().less_equal(V::splat(1021.0)))
}

#[inline(always)]
pub(super) fn exp_m1<P: Policy, V: Vector>(x: V) -> (V, V) {
    let (n, r) = octaves::<P, V>(x);
    let one = V::splat(1.0);
    let scale = scaled(one, n);
    // The sign of x, for −0.
    let value = P::mul_add(scale, power::<P, V>(r), scale - one).or(x.sign());
    (value, x.abs().less_equal(V::splat(708.0)))
}

/// A positive number as `2ᵏ m`, m from √½ or another `lowest` (of which the upper half counts) to twice that.
#[inline(always)]
fn normalized<V: Vector>(x: V, lowest: f64) -> (V, V) {
    const MANTISSA: u64 = (1 << 52) - 1;
    const INTEGER: f64 = (1u64 << 52) as f64;
    let lowest = lowest.to_bits() & UPPER;
    let raised = x.add_bits(V::bits(1f64.to_bits() - lowest));
    let k = raised.right::<52>().or(V::splat(INTEGER)) - V::splat(INTEGER + 1023.0);
    (k, raised.and(V::bits(MANTISSA)).add_bits(V::bits(lowest)))
}

/// `ln(1 + f) − f + f²/2` for √½ ≤ 1 + f ≤ √2, and f²/2.
#[inline(always)]
fn logarithm<P: Policy, V: Vector>(f: V) -> (V, V) {
    let s = f / (V::splat(2.0) + f);
    let z = s * s;
    let w = z * z;
    let even = w * horner::<P, V, 3>(
        w,
        [3.999999999940941908e-01, 2.222219843214978396e-01, 1.531383769920937332e-01],
    );
    let odd = z * horner::<P, V, 4>(
        w,
        [
            6.666666666666735130e-01,
            2.857142874366239149e-01,
            1.818357216161805012e-01,
            1.479819860511658591e-01,
        ],
    );
    let half = V::splat(0.5) * (f * f);
    (s * (half + (even + odd)), half)
}

const SQRT_HALF: f64 = core::f64::consts::FRAC_1_SQRT_2;

#[inline(always)]
pub(super) fn ln<P: Policy, V: Vector>(x: V) -> (V, V) {
    let (k, m) = normalized(x, SQRT_HALF);
    let f = m - V::splat(1.0);
    let (rest, half) = logarithm::<P, V>(f);
    let rest = P::mul_add(k, V::splat(LN2[1]), rest);
    let value = P::mul_add(k, V::splat(LN2[0]), f - (half - rest));
    (value, between(f64::MIN_POSITIVE, x, f64::MAX))
}

#[inline(always)]
pub(super) fn ln_1p<P: Policy, V: Vector>(x: V) -> (V, V) {
    let one = V::splat(1.0);
    let u = one + x;
    // What 1 + x is rounded by.
    let lost = one.less(x).select(one - (u - x), x - (u - one)) / u;
    let (k, m) = normalized(u, SQRT_HALF);
    let f = m - one;
    let (rest, half) = logarithm::<P, V>(f);
    let rest = rest + P::mul_add(k, V::splat(LN2[1]), lost);
    let value = P::mul_add(k, V::splat(LN2[0]), f - (half - rest)).or(x.sign());
    (value, V::splat(-1.0).less(x).and(x.less_equal(V::splat(1e300))))
}

/// The logarithm whose base has 1/ln = `[ivln_hi, ivln_lo]` and log 2 = `[two_hi, two_lo]`, in double precision and a half.
#[inline(always)]
fn logarithm_to<V: Vector, P: Policy>(x: V, ivln: [f64; 2], two: [f64; 2]) -> (V, V) {
    let (k, m) = normalized(x, SQRT_HALF);
    let f = m - V::splat(1.0);
    let (rest, half) = logarithm::<P, V>(f);
    let high = upper(f - half);
    let low = (f - high) - half + rest;
    let whole = k * V::splat(two[0]);
    let product = high * V::splat(ivln[0]);
    let rest = k * V::splat(two[1]) + (low + high) * V::splat(ivln[1]) + low * V::splat(ivln[0]);
    let sum = whole + product;
    (rest + ((whole - sum) + product) + sum, between(f64::MIN_POSITIVE, x, f64::MAX))
}

#[inline(always)]
pub(super) fn log2<P: Policy, V: Vector>(x: V) -> (V, V) {
    logarithm_to::<V, P>(x, [1.44269504072144627571e+00, 1.67517131648865118353e-10], [1.0, 0.0])
}

#[inline(always)]
pub(super) fn log10<P: Policy, V: Vector>(x: V) -> (V, V) {
    logarithm_to::<V, P>(
        x,
        [4.34294481878168880939e-01, 2.50829467116452752298e-11],
        [3.01029995663611771306e-01, 3.69423907715893078616e-13],
    )
}

#[inline(always)]
pub(super) fn cbrt<P: Policy, V: Vector>(x: V) -> (V, V) {
    const INTEGER: f64 = (1u64 << 52) as f64;
    let a = x.abs();
    // A third of the upper half of the bits, and so of the exponent, has the root to 5 bits.
    let upper = a.right::<32>().or(V::splat(INTEGER)) - V::splat(INTEGER);
    let t = (upper * V::splat(1.0 / 3.0) + V::splat(INTEGER + 715_094_163.0)).left::<32>();
    // A polynomial brings 23 bits, and no more are kept, so that t² is exact.
    let r = (t * t) * (t / a);
    let t = t * horner::<P, V, 5>(
        r,
        [
            1.87595182427177009643,
            -1.88497980543377169875,
            1.621429720105354466140,
            -0.758397934778766047437,
            0.145996192886612446982,
        ],
    );
    let t = t.add_bits(V::bits(0x8000_0000)).and(V::bits(0xffff_ffff_c000_0000));
    // Newton's step.
    let r = a / (t * t);
    let r = (r - t) / (t + t + r);
    let value = P::mul_add(t, r, t);
    (value.or(x.sign()), between(f64::MIN_POSITIVE, a, f64::MAX))
}

#[inline(always)]
pub(super) fn hypot<P: Policy, V: Vector>(x: V, y: V) -> (V, V) {
    let (large, small) = sorted(x.abs(), y.abs());
    (
        P::mul_add(large, large, small * small).sqrt(),
        between(1e-140, large, 1e150).and(small.less_equal(large)),
    )
}

#[inline(always)]
pub(super) fn sin_cos<P: Policy, V: Vector>(x: V) -> ((V, V), V) {
    (trigonometric::sin_cos::<P, V>(x), x.abs().less_equal(V::splat(trigonometric::limit::<P>())))
}

#[inline(always)]
pub(super) fn tan<P: Policy, V: Vector>(x: V) -> (V, V) {
    let ((sin, cos), good) = sin_cos::<P, V>(x);
    (sin / cos, good)
}

/// `(asin √z) / √z − 1` for 0 ≤ z ≤ 1/4.
#[inline(always)]
fn arc<P: Policy, V: Vector>(z: V) -> V {
    let p = z * horner::<P, V, 6>(
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
    let q = horner::<P, V, 5>(
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

/// Of a = |x|: whether it is below 1/2; s, which is a or √((1 − a)/2); what s lacks; and asin s − s.
#[inline(always)]
fn half_arc<P: Policy, V: Vector>(a: V) -> (V, V, V, V) {
    let (one, half) = (V::splat(1.0), V::splat(0.5));
    let small = a.less(half);
    let z = small.select(a * a, (one - a) * half);
    let root = z.sqrt();
    let s = small.select(a, root);
    // √z less its upper half, from z less the square of that.
    let high = upper(root);
    let lost = (z - high * high) / (root + high) - (root - high);
    let lost = small.or(z.equal(V::splat(0.0))).select(V::splat(0.0), lost);
    (small, s, lost, s * arc::<P, V>(z))
}

#[inline(always)]
pub(super) fn asin<P: Policy, V: Vector>(x: V) -> (V, V) {
    let a = x.abs();
    let (small, s, lost, rest) = half_arc::<P, V>(a);
    let (quarter, quarter_rest) = (V::splat(FRAC_PI_2), V::splat(FRAC_PI_2_REST));
    // π/2 − 2 asin √((1 − a)/2)
    let large = (quarter - (s + s)) - ((rest + rest) - (quarter_rest - (lost + lost)));
    let value = small.select(s + rest, large);
    (value.or(x.sign()), a.less_equal(V::splat(1.0)))
}

#[inline(always)]
pub(super) fn acos<P: Policy, V: Vector>(x: V) -> (V, V) {
    let (small, s, lost, rest) = half_arc::<P, V>(x.abs());
    let (quarter, quarter_rest) = (V::splat(FRAC_PI_2), V::splat(FRAC_PI_2_REST));
    let sign = x.sign();
    // π/2 − asin x, or 2 asin √((1 − a)/2), or π less that.
    let middle = quarter - (s.xor(sign) - (quarter_rest - rest.xor(sign)));
    let twice = s + s + (rest + rest + (lost + lost));
    let behind = (quarter - s) - (rest + lost - quarter_rest);
    let outer = sign.select(behind + behind, twice);
    (small.select(middle, outer), x.abs().less_equal(V::splat(1.0)))
}

/// The number whose mask is the first that holds, or the last one.
#[inline(always)]
fn chosen<V: Vector>(masks: [V; 4], c: [f64; 5]) -> V {
    let upper = masks[2].select(V::splat(c[2]), masks[3].select(V::splat(c[3]), V::splat(c[4])));
    masks[0].select(V::splat(c[0]), masks[1].select(V::splat(c[1]), upper))
}

/// The angle of (x, y) for x, y ≥ 0: by the tangent of its difference to the nearest of five angles.
#[inline(always)]
fn angle<P: Policy, V: Vector>(y: V, x: V) -> V {
    let first = y.less(V::splat(0.4375) * x);
    let second = y.less(V::splat(0.6875) * x);
    let third = y.less(V::splat(1.1875) * x);
    let fourth = y.less(V::splat(2.4375) * x);
    let masks = [first, second, third, fourth];
    let b = chosen(masks, [0.0, 0.5, 1.0, 1.5, 0.0]);
    // Beyond the last one the difference to π/2 has the tangent −x/y.
    let numerator = fourth.select(P::mul_add(-b, x, y), -x);
    let denominator = fourth.select(P::mul_add(b, y, x), y);
    let high = chosen(
        masks,
        [0.0, 4.63647609000806093515e-01, 7.85398163397448278999e-01, 9.82793723247329054082e-01, FRAC_PI_2],
    );
    let low = chosen(
        masks,
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
    let odd = z * horner::<P, V, 6>(
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
    let even = w * horner::<P, V, 5>(
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
pub(super) fn atan<P: Policy, V: Vector>(x: V) -> (V, V) {
    let a = x.abs();
    (angle::<P, V>(a, V::splat(1.0)).or(x.sign()), a.less_equal(V::splat(1e300)))
}

#[inline(always)]
pub(super) fn atan2<P: Policy, V: Vector>(y: V, x: V) -> (V, V) {
    let (a, b) = (y.abs(), x.abs());
    let (large, small) = sorted(a, b);
    let angle = angle::<P, V>(a, b);
    let behind = V::splat(core::f64::consts::PI) - (angle - V::splat(2.0 * FRAC_PI_2_REST));
    let value = x.sign().select(behind, angle).or(y.sign());
    let zero = small.equal(V::splat(0.0));
    let good = between(1e-150, large, 1e150).and(zero.or(V::splat(1e-150).less_equal(small)));
    (value, good)
}

#[inline(always)]
pub(super) fn sinh<P: Policy, V: Vector>(x: V) -> (V, V) {
    let (t, good) = exp_m1::<P, V>(x.abs());
    ((V::splat(0.5) * (t + t / (t + V::splat(1.0)))).or(x.sign()), good)
}

#[inline(always)]
pub(super) fn cosh<P: Policy, V: Vector>(x: V) -> (V, V) {
    let (e, good) = exp::<P, V>(x.abs());
    (V::splat(0.5) * (e + V::splat(1.0) / e), good)
}

#[inline(always)]
pub(super) fn tanh<P: Policy, V: Vector>(x: V) -> (V, V) {
    let a = x.abs();
    // 1 from there on.
    let limit = V::splat(20.0);
    let near = a.less(limit).select(a, limit);
    let (t, _) = exp_m1::<P, V>(near + near);
    ((t / (t + V::splat(2.0))).or(x.sign()), a.less_equal(V::splat(f64::MAX)))
}

#[inline(always)]
pub(super) fn asinh<P: Policy, V: Vector>(x: V) -> (V, V) {
    let (a, one) = (x.abs(), V::splat(1.0));
    let square = a * a;
    // x + √(1 + x²) − 1
    let (value, _) = ln_1p::<P, V>(a + square / (one + (one + square).sqrt()));
    (value.or(x.sign()), a.less_equal(V::splat(1e150)))
}

#[inline(always)]
pub(super) fn acosh<P: Policy, V: Vector>(x: V) -> (V, V) {
    let t = x - V::splat(1.0);
    let (value, _) = ln_1p::<P, V>(t + P::mul_add(t, t, t + t).sqrt());
    (value, between(1.0, x, 1e150))
}

#[inline(always)]
pub(super) fn atanh<P: Policy, V: Vector>(x: V) -> (V, V) {
    let (a, one) = (x.abs(), V::splat(1.0));
    let (value, _) = ln_1p::<P, V>((a + a) / (one - a));
    ((V::splat(0.5) * value).or(x.sign()), a.less(one))
}

/// xʸ = 2^(y log₂ x), with log₂ x and its product in two numbers each, whose upper halves multiply exactly.
#[inline(always)]
pub(super) fn powf<P: Policy, V: Vector>(x: V, y: V) -> (V, V) {
    const SQRT_3: f64 = 1.732_050_807_568_877_2;
    let splat = V::splat;
    // ln m = ln b + 2 artanh s, with b = 1 or 3/2 and s = (m − b)/(m + b).
    let (k, m) = normalized(x, 0.5 * SQRT_3);
    let upper_half = splat(1.224_744_871_391_589).less(m);
    let b = upper_half.select(splat(1.5), splat(1.0));
    let (difference, inverse) = (m - b, splat(1.0) / (m + b));
    let s = difference * inverse;
    let s_high = upper(s);
    let sum_high = upper(m + b);
    let sum_low = m - (sum_high - b);
    let s_low = inverse * ((difference - s_high * sum_high) - s_high * sum_low);
    let z = s * s;
    let series = (z * z)
        * horner::<P, V, 6>(
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
    let t_high = upper(splat(3.0) + square + series);
    let t_low = series - ((t_high - splat(3.0)) - square);
    let (u, v) = (s_high * t_high, s_low * t_high + t_low * s);
    let p_high = upper(u + v);
    let p_low = v - (p_high - u);
    // 2/(3 ln 2), and log₂ b.
    let z_high = splat(9.61796700954437255859e-01) * p_high;
    let z_low = splat(-7.02846165095275826516e-09) * p_high
        + p_low * splat(9.61796693925975554329e-01)
        + upper_half.and(splat(1.35003920212974897128e-08));
    let b_high = upper_half.and(splat(5.84962487220764160156e-01));
    let log_high = upper(((z_high + z_low) + b_high) + k);
    let log_low = z_low - (((log_high - k) - b_high) - z_high);

    let y_high = upper(y);
    let low = (y - y_high) * log_high + y * log_low;
    let high = y_high * log_high;
    let exponent = low + high;

    let shifted = exponent + splat(ROUND);
    let high = high - (shifted - splat(ROUND));
    let t = upper(low + high);
    let u = t * splat(6.93147182464599609375e-01);
    let v = (low - (t - high)) * splat(LN_2) + t * splat(-1.90465429995776804525e-09);
    let z = u + v;
    let w = v - (z - u);
    let t = z * z;
    let t = z - t * horner::<P, V, 5>(
        t,
        [
            1.66666666666666019037e-01,
            -2.77777777770155933842e-03,
            6.61375632143793436117e-05,
            -1.65339022054652515390e-06,
            4.13813679705723846039e-08,
        ],
    );
    let r = (z * t) / (t - splat(2.0)) - (w + z * w);
    let value = scaled(splat(1.0) - (r - z), shifted);
    let good = between(f64::MIN_POSITIVE, x, f64::MAX)
        .and(exponent.abs().less_equal(splat(1020.0)))
        .and(y.abs().less_equal(splat(1e18)));
    (value, good)
}

#[inline(always)]
pub(super) fn signum<V: Vector>(x: V) -> V {
    // A NaN keeps what it is.
    x.equal(x).select(V::splat(1.0).or(x.and(V::bits(SIGN))), x)
}
