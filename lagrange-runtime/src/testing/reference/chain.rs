//! Equal masses in a row, joined by equal springs.

use crate::scalar::double_double::{DoubleDouble as Double, PI};

/// The motion of N equal masses m in a row between two walls, with N + 1 equal springs k:
/// `m q̈ᵢ = k (qᵢ₋₁ − 2qᵢ + qᵢ₊₁)`, `q₀ = qₙ₊₁ = 0`, by its normal modes (Rayleigh, *The Theory of Sound*, 2nd ed.
/// 1894, §120; Goldstein, *Classical Mechanics*, ch. 6):
///
/// ```text
/// qᵢ(t) = Σⱼ sᵢⱼ (aⱼ cos ωⱼt + bⱼ/ωⱼ sin ωⱼt),    sᵢⱼ = sin(ijπ/(N + 1)),    ωⱼ = 2√(k/m) sin(jπ/(2(N + 1)))
/// aⱼ = 2/(N + 1) Σᵢ sᵢⱼ qᵢ(0),                     bⱼ = 2/(N + 1) Σᵢ sᵢⱼ q̇ᵢ(0)
/// ```
///
/// ```
/// # use lagrange_runtime::testing::reference::LinearChain;
/// let one = LinearChain::new(1.0, 2.0, [1.0], [0.0]); // ω² = 2k/m
/// assert_eq!(one.state(0.25), ([0.5f64.cos()], [-2.0 * 0.5f64.sin()]));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinearChain<const N: usize> {
    /// √(k/m).
    rate: Double,
    q: [f64; N],
    qd: [f64; N],
}

impl<const N: usize> LinearChain<N> {
    /// The chain of masses `m` and springs `k` that starts at displacements `q` with velocities `qd`. Unless `k/m > 0`,
    /// every result is NaN.
    pub fn new(m: f64, k: f64, q: [f64; N], qd: [f64; N]) -> Self {
        let square = Double::from(k) / m;
        let rate = if square.hi > 0.0 { square.sqrt() } else { Double::from(f64::NAN) };
        Self { rate, q, qd }
    }

    /// `(q, q̇)` at time `t` after the start.
    pub fn state(&self, t: f64) -> ([f64; N], [f64; N]) {
        let angle = PI / (N as f64 + 1.0);
        let shape = |i: usize, j: usize| (angle * (((i + 1) * (j + 1)) as f64)).sin_cos().0;
        let (mut q, mut qd) = ([Double::ZERO; N], [Double::ZERO; N]);
        for j in 0..N {
            let omega = self.rate * (angle * 0.5 * (j as f64 + 1.0)).sin_cos().0 * 2.0;
            let part = |start: &[f64; N]| {
                let sum = (0..N).fold(Double::ZERO, |sum, i| sum + shape(i, j) * start[i]);
                sum * 2.0 / (N as f64 + 1.0)
            };
            let (a, b) = (part(&self.q), part(&self.qd));
            let (sin, cos) = (omega * t).sin_cos();
            let (displacement, velocity) = (a * cos + b / omega * sin, b * cos - a * omega * sin);
            for i in 0..N {
                q[i] += shape(i, j) * displacement;
                qd[i] += shape(i, j) * velocity;
            }
        }
        (q.map(Double::value), qd.map(Double::value))
    }
}

#[cfg(test)]
#[allow(clippy::excessive_precision)] // the digits as computed, to be compared with their source
mod tests {
    use super::*;

    #[test]
    fn against_the_exponential_of_the_matrix() {
        // mpmath's expm, 50 digits, at these exact doubles.
        let chain = LinearChain::new(0.7, 3.1, [1.0, -0.2, 0.0], [0.0, 0.5, 0.3]);
        let (q, qd) = chain.state(12.34);
        for (value, expected) in q.into_iter().chain(qd).zip(EXPM) {
            assert!(((value - expected) / expected).abs() < 2.3e-16, "{value} for {expected}");
        }
    }

    const EXPM: [f64; 6] = [
        0.35976632364116445305,
        0.588470911615799443509,
        -0.285533111495844931307,
        2.04140667032479444813,
        -1.59477023900630431126,
        -0.251828587020946706537,
    ];

    #[test]
    fn the_start_is_kept() {
        let start = ([0.3, 0.0, -0.7, 0.1], [0.0, 1.0, 0.2, -0.4]);
        let (q, qd) = LinearChain::new(1.0, 1.0, start.0, start.1).state(0.0);
        for (value, expected) in q.into_iter().chain(qd).zip(start.0.into_iter().chain(start.1)) {
            assert!((value - expected).abs() < 1e-16, "{value} for {expected}");
        }
        assert!(LinearChain::new(1.0, -1.0, [1.0], [0.0]).state(1.0).0[0].is_nan());
    }
}
