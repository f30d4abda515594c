//! Jacobi's elliptic functions and the complete elliptic integral, of modulus k (not parameter m = k²).

use crate::scalar::Functions;
use crate::scalar::double_double::{DoubleDouble as Double, PI};

/// Complete elliptic integral of the first kind `K(k) = ∫₀^{π/2} dφ/√(1 − k² sin²φ)`, for |k| < 1; infinite at |k| = 1,
/// NaN beyond.
///
/// `K = π/(2 agm(1, k′))` with `k′ = √(1 − k²)` (Abramowitz and Stegun 1964, 17.6.3; DLMF 19.8.5).
///
/// ```
/// # use lagrange_runtime::testing::reference::elliptic_k;
/// assert!((elliptic_k(0.5) - 1.685750354812596).abs() < 1e-15);
/// ```
pub fn elliptic_k(k: f64) -> f64 {
    complete(complementary(k)).value()
}

/// Jacobi's elliptic functions `(sn, cn, dn)(u, k)` of modulus |k| ≤ 1; NaN beyond.
///
/// Whole periods `4K` are taken off `u`; then descending Landen transformations lower k until the functions are
/// circular (DLMF 22.7.1–22.7.4; Abramowitz and Stegun 1964, 16.12).
///
/// ```
/// # use lagrange_runtime::testing::reference::jacobi_elliptic;
/// let (sn, cn, dn) = jacobi_elliptic(0.7, 0.6);
/// assert!((sn * sn + cn * cn - 1.0).abs() < 1e-15 && (dn * dn + 0.36 * sn * sn - 1.0).abs() < 1e-15);
/// ```
pub fn jacobi_elliptic(u: f64, k: f64) -> (f64, f64, f64) {
    let kp = complementary(k);
    let (_, u) = whole_periods(Double::from(u), complete(kp), 4.0);
    let (sn, cn, dn) = functions(u, Double::from(Functions::abs(k)), kp);
    (sn.value(), cn.value(), dn.value())
}

/// `k′ = √((1 − k)(1 + k))`.
fn complementary(k: f64) -> Double {
    let k = Double::from(k);
    ((Double::ONE - k) * (Double::ONE + k)).sqrt()
}

/// `K`, given k′.
pub(super) fn complete(kp: Double) -> Double {
    if kp.hi == 0.0 {
        return Double::from(f64::INFINITY);
    }
    let (mut a, mut b) = (Double::ONE, kp);
    // The difference is squared at each step, after about log₂ ln(1/k′) steps that bring a and b together.
    for _ in 0..24 {
        (a, b) = ((a + b) * 0.5, (a * b).sqrt());
    }
    PI * 0.5 / a
}

/// The number of whole periods of so many quarters in `u`, and what remains, in half a period on each side of 0.
pub(super) fn whole_periods(u: Double, quarter: Double, quarters: f64) -> (f64, Double) {
    if quarter.hi == f64::INFINITY {
        return (0.0, u);
    }
    let period = quarter * quarters;
    let n = crate::scalar::double_double::round(u.hi / period.hi);
    (n, u - period * n)
}

/// `(sn, cn, dn)(u, k)`, given k and k′ separately since either determines the other badly when small.
///
/// With `k₁ = (1 − k′)/(1 + k′)`, `u₁ = u/(1 + k₁)` and s₁, c₁, d₁ of `(u₁, k₁)`:
/// `sn = (1 + k₁)s₁/(1 + k₁s₁²)`, `cn = c₁d₁/(1 + k₁s₁²)`, `dn = (1 − k₁s₁²)/(1 + k₁s₁²)`.
/// The differences are written as sums of positive terms: `1 − k₁s₁² = (1 − k₁) + k₁c₁²`.
pub(super) fn functions(u: Double, k: Double, kp: Double) -> (Double, Double, Double) {
    if kp.hi == 0.0 {
        let sech = Double::from(1.0 / Functions::cosh(u.hi));
        return (Double::from(Functions::tanh(u.hi)), sech, sech);
    }
    if k.hi <= 1e-17 || k.hi.is_nan() {
        // sn = sin u + O(k²); the square only hands on a NaN.
        let (sin, cos) = u.sin_cos();
        return (sin, cos, Double::ONE + k.square());
    }
    let denominator = Double::ONE + kp;
    let k1 = (k / denominator).square();
    let (s1, c1, d1) = functions(u / (Double::ONE + k1), k1, kp.sqrt() * 2.0 / denominator);
    let below = Double::ONE + k1 * s1.square();
    let difference = kp * 2.0 / denominator + k1 * c1.square();
    ((Double::ONE + k1) * s1 / below, c1 * d1 / below, difference / below)
}

/// The functions of a sum `u + v` (DLMF 22.8.1–22.8.3), so that a phase need never be found from where it starts.
pub(super) fn add(
    k: Double,
    (su, cu, du): (Double, Double, Double),
    (sv, cv, dv): (Double, Double, Double),
) -> (Double, Double, Double) {
    let k2 = k.square();
    let below = Double::ONE - k2 * su.square() * sv.square();
    (
        (su * cv * dv + sv * cu * du) / below,
        (cu * cv - su * du * sv * dv) / below,
        (du * dv - k2 * su * cu * sv * cv) / below,
    )
}

#[cfg(test)]
#[allow(clippy::excessive_precision)] // the digits as computed, to be compared with their source
mod tests {
    use super::*;

    #[test]
    fn digits_of_k() {
        // mpmath, 30 digits
        for (k, expected) in [
            (0.5, 1.68575035481259604287120365780),
            (0.99, 3.35660052336119194248038083399),
            (0.9999999, 9.09876902652071163112209673830),
        ] {
            let error = (elliptic_k(k) - expected) / expected;
            assert!(error.abs() < 3e-16, "k = {k}: {error:e}");
        }
        assert_eq!(elliptic_k(1.0), f64::INFINITY);
        assert!(elliptic_k(1.5).is_nan());
    }

    #[test]
    fn digits_of_jacobi_functions() {
        // mpmath, 25 digits, at these exact doubles
        for (u, k, expected) in [
            (0.7, 0.6, [0.6299171153234867795649727, 0.776662364108456756013979, 0.925825898328683259085945]),
            (
                100.3,
                0.999,
                [-0.8849654543422330697715825, -0.4656566810654014399829419, 0.467334665061075827954659],
            ),
            (
                5.0,
                0.99999,
                [0.9999141304823462319164036, 0.01310464275489698637073735, 0.01384659261758363313164799],
            ),
        ] {
            let (sn, cn, dn) = jacobi_elliptic(u, k);
            for (value, expected) in [sn, cn, dn].into_iter().zip(expected) {
                assert!(((value - expected) / expected).abs() < 2.3e-16, "{u} {k}: {value} {expected}");
            }
        }
    }

    #[test]
    fn limits_are_circular_and_hyperbolic() {
        let (sn, cn, dn) = jacobi_elliptic(0.8, 0.0);
        assert_eq!((sn, cn, dn), (0.8_f64.sin(), 0.8_f64.cos(), 1.0));
        let (sn, cn, dn) = jacobi_elliptic(0.8, 1.0);
        assert!((sn - 0.8_f64.tanh()).abs() < 1e-16 && cn == dn && (cn - 1.0 / 0.8_f64.cosh()).abs() < 2e-16);
    }

    #[test]
    fn nothing_hangs_or_panics_on_numbers_out_of_range() {
        for (u, k) in [(f64::NAN, 0.5), (1.0, f64::NAN), (1.0, 2.0), (1e300, 0.5), (f64::INFINITY, 0.5)] {
            assert!(jacobi_elliptic(u, k).0.is_nan(), "{u} {k}");
        }
    }
}
