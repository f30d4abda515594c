//! Zeros and minima of a function of one variable. They are compiled once: functions are evaluated through an address.

/// The first zero of `f` that a bracket leads to: `a < b`, where `f(a) = fa` is not zero and `f(b) = fb` has the other
/// sign or is zero. Of the two ends of the last bracket, `resolution` apart, that with the smaller |f|; NaN where `f`
/// is. A zero value counts as the other sign, so that of a stretch of zeros the beginning is found.
///
/// The method is ITP (Oliveira and Takahashi 2020, *ACM Trans. Math. Software* 47, 5): regula falsi, truncated and
/// projected onto the interval in which bisection's bound on the number of evaluations (here: one more) can still be
/// kept. It converges superlinearly for smooth functions, and as bisection does for any other.
pub(crate) fn first_zero(
    f: &mut dyn FnMut(f64) -> f64,
    (mut a, mut fa): (f64, f64),
    (mut b, mut fb): (f64, f64),
    resolution: f64,
) -> f64 {
    let truncation = 0.2 / (b - a);
    // What is left of the width that bisection with one evaluation more would have.
    let mut allowed = resolution;
    while allowed < b - a {
        allowed *= 2.0;
    }
    while b - a > resolution {
        let middle = 0.5 * (a + b);
        if middle <= a || middle >= b {
            break;
        }
        let falsi = (fb * a - fa * b) / (fb - fa);
        let towards_middle = if falsi < middle { 1.0 } else { -1.0 };
        // At least half the resolution, so that the last guesses enclose the zero instead of closing in on one side.
        let truncated = (truncation * (b - a) * (b - a)).max(0.5 * resolution);
        let guess =
            if truncated <= (middle - falsi).abs() { falsi + towards_middle * truncated } else { middle };
        let radius = (allowed - 0.5 * (b - a)).max(0.0);
        let projected =
            if (guess - middle).abs() <= radius { guess } else { middle - towards_middle * radius };
        allowed *= 0.5;
        // Infinite values make the secant useless.
        let x = if projected > a && projected < b { projected } else { middle };
        let y = f(x);
        if y.is_nan() {
            return y;
        }
        if (y > 0.0 && fa > 0.0) || (y < 0.0 && fa < 0.0) {
            (a, fa) = (x, y);
        } else {
            (b, fb) = (x, y);
        }
    }
    if fa.abs() < fb.abs() { a } else { b }
}

/// Searches `f`, which is positive at `a < m < b` and not larger at `m` than at the two others, for a place where it is
/// negative, or else for its minimum: the place and the value. Gives up, with the best so far, once a convex function
/// through the points could not come down half of the way to `floor`, but not before two trials: it is not convex where
/// it falls again to a zero beyond the three, or beside a kink.
pub(super) fn dip(
    f: &mut dyn FnMut(f64) -> f64,
    [mut a, mut m, mut b]: [(f64, f64); 3],
    floor: f64,
) -> (f64, f64) {
    const GOLDEN: f64 = 0.381966011250105;
    const TRIALS: u32 = 2;
    // A minimum is known to half the digits only.
    let width = 1e-9;
    for k in 0..80 {
        let (left, right) = ((a.1 - m.1) / (m.0 - a.0), (b.1 - m.1) / (b.0 - m.0));
        let lowest = m.1 - (left * (b.0 - m.0)).max(right * (m.0 - a.0));
        if lowest.is_nan() || (k >= TRIALS && lowest - floor > 0.5 * (m.1 - floor)) || b.0 - a.0 < width {
            break;
        }
        // The vertex of the parabola through the three, and the golden section in turns, so that neither end stays.
        let curvature = (left + right) / (b.0 - a.0);
        let vertex = m.0 - 0.5 * (right / curvature - (b.0 - m.0));
        let golden =
            if b.0 - m.0 > m.0 - a.0 { m.0 + GOLDEN * (b.0 - m.0) } else { m.0 - GOLDEN * (m.0 - a.0) };
        let usable = k % 3 != 2 && vertex > a.0 && vertex < b.0 && (vertex - m.0).abs() > 0.1 * width;
        let x = if usable { vertex } else { golden };
        let trial = (x, f(x));
        if trial.1 < 0.0 {
            return trial;
        }
        if trial.1 <= m.1 {
            (a, m, b) = if x < m.0 { (a, trial, m) } else { (m, trial, b) };
        } else if x < m.0 {
            a = trial;
        } else {
            b = trial;
        }
    }
    m
}

/// 1, −1, or 0.
pub(crate) fn sign(g: f64) -> f64 {
    if g > 0.0 {
        1.0
    } else if g < 0.0 {
        -1.0
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The zero of `f` between `a` and `b`, and the evaluations that it took.
    fn zero(f: impl Fn(f64) -> f64, a: f64, b: f64) -> (f64, u32) {
        let mut count = 0;
        let mut counted = |x| {
            count += 1;
            f(x)
        };
        let x = first_zero(&mut counted, (a, f(a)), (b, f(b)), f64::EPSILON);
        (x, count)
    }

    #[test]
    fn zeros_are_found_to_rounding() {
        let cases: [(&dyn Fn(f64) -> f64, f64); 5] = [
            (&|x| x.exp() - 2.0, core::f64::consts::LN_2),
            (&|x| x * x - 0.5, 0.5f64.sqrt()),
            (&|x: f64| (x - 0.3).powi(3), 0.3),
            (&|x: f64| 0.625 - x, 0.625),
            (&|x: f64| (x - 0.1).tanh() * 1e-200, 0.1),
        ];
        for (f, exact) in cases {
            let (x, count) = zero(f, 0.0, 1.0);
            assert!((x - exact).abs() <= 1e-15 || f(x) == 0.0, "{x} {exact}");
            assert!(count <= 54, "{count}");
        }
        assert!(zero(|x| x.exp() - 2.0, 0.0, 1.0).1 <= 12);
    }

    #[test]
    fn jumps_poles_and_stretches_of_zeros_end_too() {
        let (x, count) = zero(|x| if x < 0.7 { -1.0 } else { 3.0 }, 0.0, 1.0);
        assert!((x - 0.7).abs() < 1e-15 && count <= 54);
        let (x, _) = zero(|x| 1.0 / (x - 0.7), 0.0, 1.0);
        assert!((x - 0.7).abs() < 1e-15);
        let (x, _) = zero(|x| (0.4 - x).max(0.0), 0.0, 1.0);
        assert!((x - 0.4).abs() < 1e-15);
        assert!(zero(|x| if x > 0.1 && x < 0.9 { f64::NAN } else { x - 0.5 }, 0.0, 1.0).0.is_nan());
    }

    #[test]
    fn dips_below_zero_are_found_and_high_ones_left() {
        let search = |f: &dyn Fn(f64) -> f64| dip(&mut |x| f(x), [0.0, 0.4, 1.0].map(|x| (x, f(x))), 0.0);
        let (x, y) = search(&|x| (x - 0.55).powi(2) - 1e-13);
        assert!(y < 0.0 && (x - 0.55).abs() < 1e-6);
        let (x, y) = search(&|x| (x - 0.55).powi(2));
        assert!((0.0..1e-15).contains(&y) && (x - 0.55).abs() < 1e-7);
        assert!(search(&|x| (x - 0.55).powi(2) + 0.5).1 > 0.4);
        assert!(search(&|x| 1e-3 * (x - 0.55).abs() - 1e-7).1 < 0.0);
    }
}
