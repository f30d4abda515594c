//! Distribution functions of Student's t and of the binomial, by the incomplete beta function.

use super::normal_quantile;

/// The regularized incomplete beta function I_x(a, b), by its continued fraction (DLMF 8.17.22) in the form of Lentz
/// (1976).
pub fn incomplete_beta(x: f64, a: f64, b: f64) -> f64 {
    if x <= 0.0 || x >= 1.0 {
        return if x <= 0.0 { 0.0 } else { 1.0 };
    }
    // The fraction converges fast below the mean; above it that of the complement does.
    if x > (a + 1.0) / (a + b + 2.0) {
        return 1.0 - incomplete_beta(1.0 - x, b, a);
    }
    let front = a * x.ln() + b * (-x).ln_1p() + libm::lgamma(a + b) - libm::lgamma(a) - libm::lgamma(b);
    const TINY: f64 = 1e-300;
    let (mut c, mut d) = (1.0, 1.0 / (1.0 - (a + b) * x / (a + 1.0)));
    let mut fraction = d;
    for m in 1..10_000 {
        let m = f64::from(m);
        let even = m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m));
        let odd = -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0));
        let mut change = 1.0;
        for term in [even, odd] {
            let near = |value: f64| if value.abs() < TINY { TINY } else { value };
            d = 1.0 / near(1.0 + term * d);
            c = near(1.0 + term / c);
            change = c * d;
            fraction *= change;
        }
        if (change - 1.0).abs() < 1e-16 {
            break;
        }
    }
    front.exp() * fraction / a
}

/// The p-quantile of Student's t distribution, for 0 < p < 1 and a positive, not necessarily whole number of degrees
/// of freedom.
pub fn student_quantile(p: f64, freedom: f64) -> f64 {
    // The difference is below 1e-7 of the quantile.
    if freedom > 1e8 {
        return normal_quantile(p);
    }
    if p.is_nan() || freedom.is_nan() || p <= 0.0 || p >= 1.0 || freedom <= 0.0 {
        return f64::NAN;
    }
    let tail = |t: f64| 0.5 * incomplete_beta(freedom / (freedom + t * t), 0.5 * freedom, 0.5);
    let wanted = p.min(1.0 - p);
    let (mut low, mut high) = (0.0, 1.0);
    while tail(high) > wanted && high < 1e150 {
        (low, high) = (high, 2.0 * high);
    }
    // Until the interval is a rounding wide.
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if tail(middle) > wanted {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high) * (p - 0.5).signum() * f64::from(u8::from(p != 0.5))
}

/// The probability that a binomial number of n trials of probability p is k or more.
pub fn binomial_tail(k: u64, n: u64, p: f64) -> f64 {
    match k {
        0 => 1.0,
        k if k > n => 0.0,
        k => incomplete_beta(p, k as f64, (n - k + 1) as f64),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Digits by mpmath 1.3 at 40 digits, `betainc(a, b, 0, x, regularized=True)`.
    #[test]
    fn incomplete_beta_has_its_digits() {
        for (x, a, b, exact) in INCOMPLETE_BETA {
            let found = incomplete_beta(x, a, b);
            // Logarithms of gamma functions of large numbers cancel.
            let error = 1e-14 * (1.0 + a + b);
            assert!((found / exact - 1.0).abs() < error, "{x} {a} {b}: {found} {exact}");
        }
        assert_eq!((incomplete_beta(0.0, 1.0, 2.0), incomplete_beta(1.0, 1.0, 2.0)), (0.0, 1.0));
    }

    const INCOMPLETE_BETA: [(f64, f64, f64, f64); 10] = [
        (0.3, 2.0, 5.0, 0.579825),
        (0.9, 2.0, 5.0, 0.999945),
        (0.01, 50.0, 0.5, 7.998227417904821e-102),
        (0.975, 50.0, 0.5, 0.11246902627758335),
        (0.999, 1000.0, 3.0, 0.9194224096397954),
        (0.999, 999.0, 1.0, 0.3680634882592229),
        (0.5, 3.5, 2.25, 0.28641490417033946),
        (0.2, 0.5, 0.5, 0.2951672353008666),
        (0.05, 4.0, 300.0, 0.9998553487625314),
        (0.999, 5000.0, 8.0, 0.8660006327598018),
    ];
    const STUDENT: [(f64, f64, f64); 9] = [
        (0.975, 1.0, 12.706204736174693),
        (0.975, 2.5, 3.574654842003682),
        (0.975, 5.0, 2.570581835636315),
        (0.995, 15.0, 2.9467128834752385),
        (0.95, 31.7, 1.6943666408657017),
        (0.975, 126.0, 1.9789706019906283),
        (0.975, 1e5, 1.9599877075346093),
        (0.025, 10.0, -2.228138851986275),
        (0.6, 3.0, 0.27667066233268985),
    ];

    /// Digits by mpmath 1.3: the root of the distribution function.
    #[test]
    fn quantiles_of_student_have_their_digits() {
        for (p, freedom, exact) in STUDENT {
            let found = student_quantile(p, freedom);
            assert!((found / exact - 1.0).abs() < 1e-10, "{p} {freedom}: {found} {exact}");
        }
        assert_eq!(student_quantile(0.5, 3.0), 0.0);
        assert!(student_quantile(1.0, 3.0).is_nan() && student_quantile(0.9, 0.0).is_nan());
    }

    /// Against the sum over all numbers of successes.
    #[test]
    fn binomial_tails_are_sums() {
        let (n, p) = (20, 0.3f64);
        for k in 0..=n + 1 {
            let choose = |j: u64| (0..j).fold(1.0, |c, i| c * (n - i) as f64 / (i + 1) as f64);
            let sum: f64 =
                (k..=n).map(|j| choose(j) * p.powi(j as i32) * (1.0 - p).powi((n - j) as i32)).sum();
            assert!((binomial_tail(k, n, p) - sum).abs() < 1e-14, "{k}");
        }
    }
}
