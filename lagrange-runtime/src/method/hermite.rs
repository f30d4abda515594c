//! The interpolant of every method that has none of its own: Hermite's, through what both ends know.
//!
//! With θ = (t − t₀)/h, the polynomial of degree 5 with the given q, q̇, q̈ at both ends has the error `O(h⁶)` in q and,
//! as its derivative, `O(h⁵)` in q̇ (Hairer, Nørsett, Wanner, *Solving Ordinary Differential Equations I*, 1993, II.6).

use super::Dense;
use crate::scalar::Scalar;
use crate::state::State;
use nalgebra::SVector;

/// Quintic Hermite interpolant:
/// `q(θ) = q₀ + θ(r₁ + θ̄(r₂ + θ(r₃ + θ̄(r₄ + θ r₅))))` with `θ̄ = 1 − θ`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hermite<S, const N: usize> {
    t: S,
    h: S,
    r: [SVector<S, N>; 6],
}

impl<S: Scalar, const N: usize> Hermite<S, N> {
    /// The interpolant from `from` to `to`, where the accelerations are `qdd_from` and `qdd_to`, a step `h` apart.
    pub fn new(
        from: &State<S, N>,
        to: &State<S, N>,
        h: S,
        qdd_from: &SVector<S, N>,
        qdd_to: &SVector<S, N>,
    ) -> Self {
        let half_h2 = h * h * S::from_f64(0.5);
        let two = S::from_f64(2.0);
        // Each coefficient is what the condition named beside it leaves over of the terms before it.
        let r1 = to.q - from.q; //                                     q at the end
        let r2 = from.qd * h - r1; //                                  q̇ at the start: r₁ + r₂
        let r3 = r1 - to.qd * h - r2; //                               q̇ at the end: r₁ − r₂ − r₃
        let r4 = qdd_from * half_h2 + r2 - r3; //                      q̈/2 at the start: −r₂ + r₃ + r₄
        let r5 = qdd_to * half_h2 + r2 + r3 * two - r4; //             q̈/2 at the end: −r₂ − 2r₃ + r₄ + r₅
        Hermite { t: from.t, h, r: [from.q, r1, r2, r3, r4, r5] }
    }
}

impl<S: Scalar, const N: usize> Dense<S, N> for Hermite<S, N> {
    fn at(&self, t: S) -> State<S, N> {
        let theta = (t - self.t) / self.h;
        let factors = [theta, S::one() - theta];
        let slopes = [S::one(), -S::one()];
        // Horner's scheme for the value and the derivative by θ together.
        let (mut value, mut slope) = (self.r[5], self.r[5] * S::zero());
        for j in (0..5).rev() {
            let (x, dx) = (factors[j % 2], slopes[j % 2]);
            slope = slope * x + value * dx;
            value = value * x + self.r[j];
        }
        State { t, q: value, qd: slope / self.h }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polynomials_of_degree_five_are_reproduced() {
        let q = |t: f64| 1.0 - t + 2.0 * t.powi(3) - 0.5 * t.powi(5);
        let qd = |t: f64| -1.0 + 6.0 * t.powi(2) - 2.5 * t.powi(4);
        let qdd = |t: f64| SVector::from([12.0 * t - 10.0 * t.powi(3)]);
        let state = |t: f64| State::new(t, [q(t)], [qd(t)]);
        let (a, b) = (0.3, 1.7);
        let dense = Hermite::new(&state(a), &state(b), b - a, &qdd(a), &qdd(b));
        for t in [a, 0.5, 1.1, b] {
            let difference = dense.at(t).minus(&state(t));
            assert!(difference.q[0].abs() < 1e-14 && difference.qd[0].abs() < 1e-13, "{difference:?}");
        }
    }
}
