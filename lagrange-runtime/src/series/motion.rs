//! The truncated series of a motion.

use crate::scalar::Scalar;
use crate::state::State;

/// Taylor coefficients of a motion about the time of its state: `q(t₀ + h) = Σ q_k hᵏ`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(bound(
        serialize = "S: crate::Scalar + serde::Serialize",
        deserialize = "S: crate::Scalar + serde::Deserialize<'de>"
    ))
)]
pub struct TaylorSeries<S, const N: usize, const K: usize> {
    /// Coefficients of the coordinates, by orders.
    #[cfg_attr(feature = "serde", serde(with = "crate::saved::series"))]
    pub q: [[S; N]; K],
}

impl<S: Scalar, const N: usize, const K: usize> TaylorSeries<S, N, K> {
    /// Without any coefficients.
    #[inline(always)]
    pub fn zero() -> Self {
        TaylorSeries { q: [[S::zero(); N]; K] }
    }

    /// Adds what is known without any equations.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn begin(&mut self, at: &State<S, N>) {
        for i in 0..N {
            self.q[0][i] = at.q[i];
            if K > 1 {
                self.q[1][i] = at.qd[i];
            }
        }
    }

    /// The coefficients of order k of the velocities, `(k + 1) q_{k+1}`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn velocities(&self, k: usize) -> [S; N] {
        let mut qd = [S::zero(); N];
        if k + 1 < K {
            let weight = S::from_f64((k + 1) as f64);
            for i in 0..N {
                qd[i] = weight * self.q[k + 1][i];
            }
        }
        qd
    }

    /// Adds the velocities of order k, `q_{k+1} = q̇_k/(k + 1)`.
    #[inline(always)]
    pub fn push_velocities(&mut self, k: usize, velocities: [S; N]) {
        self.push_velocities_of(k, &all(), velocities);
    }

    /// The same of some coordinates.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn push_velocities_of<const M: usize>(&mut self, k: usize, which: &[usize; M], velocities: [S; M]) {
        if k + 1 < K {
            let of = divided(velocities, k + 1);
            for i in 0..M {
                self.q[k + 1][which[i]] = of[i];
            }
        }
    }

    /// Adds the coefficients of order k of some coordinates. (That of order 1 is the velocity of the state.)
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn push_coordinates_of<const M: usize>(&mut self, k: usize, which: &[usize; M], coordinates: [S; M]) {
        if k > 1 && k < K {
            for i in 0..M {
                self.q[k][which[i]] = coordinates[i];
            }
        }
    }

    /// Adds the accelerations of order k, and gives back the velocities that they make, `q̇_{k+1} = q̈_k/(k + 1)`.
    /// Coordinates need not wait for these where a division takes long: `q_{k+2} = q̈_k/((k + 1)(k + 2))`.
    #[inline(always)]
    pub fn push(&mut self, k: usize, accelerations: [S; N]) -> [S; N] {
        self.push_of(k, &all(), accelerations)
    }

    /// The same of some coordinates.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn push_of<const M: usize>(&mut self, k: usize, which: &[usize; M], accelerations: [S; M]) -> [S; M] {
        let velocities = divided(accelerations, k + 1);
        if S::FUSED {
            self.push_velocities_of(k + 1, which, velocities);
        } else if k + 2 < K {
            let both = S::from_f64(((k + 1) * (k + 2)) as f64);
            for i in 0..M {
                self.q[k + 2][which[i]] = accelerations[i] / both;
            }
        }
        velocities
    }
}

/// Coefficients of all coordinates.
#[cfg_attr(not(debug_assertions), inline(always))]
const fn all<const N: usize>() -> [usize; N] {
    let mut all = [0; N];
    let mut i = 0;
    while i < N {
        all[i] = i;
        i += 1;
    }
    all
}

/// Division by an order, without a bias: `x · (1/k)` with a rounded reciprocal errs in one direction at every step,
/// and energies drift. Two fused products wait for less than a division; without fused ones the second is lost in the
/// rounding of the first.
#[derive(Clone, Copy, Debug)]
pub struct Over<S> {
    order: S,
    near: S,
    rest: S,
}

impl<S: Scalar> Over<S> {
    /// Coefficients divided by k.
    #[inline(always)]
    pub fn new(k: usize) -> Self {
        let [near, rest] = RECIPROCALS[k.min(ORDERS - 1)];
        Over { order: S::from_f64(k as f64), near: S::from_f64(near), rest: S::from_f64(rest) }
    }

    /// `x/k`
    #[inline(always)]
    pub fn of(self, x: S) -> S {
        if S::FUSED { x.mul_add(self.near, x * self.rest) } else { x / self.order }
    }

    /// `x/k + y`
    #[inline(always)]
    pub fn add(self, x: S, y: S) -> S {
        if S::FUSED { x.mul_add(self.near, x.mul_add(self.rest, y)) } else { x / self.order + y }
    }
}

/// `x/k` of each.
#[inline(always)]
pub fn divided<S: Scalar, const N: usize>(mut x: [S; N], k: usize) -> [S; N] {
    let over = Over::new(k);
    for i in 0..N {
        x[i] = over.of(x[i]);
    }
    x
}

/// Orders whose reciprocals are kept.
const ORDERS: usize = 66;

/// 1/k and what its rounding lost.
pub(super) const RECIPROCALS: [[f64; 2]; ORDERS] = {
    let mut all = [[0.0; 2]; ORDERS];
    let mut k = 1;
    while k < ORDERS {
        let near = 1.0 / k as f64;
        // The first 26 digits of 1/k times k have no rounding error, and neither has the rest of 1/k.
        let high = f64::from_bits(near.to_bits() & !0x7ff_ffff);
        let missing = (1.0 - high * k as f64) - (near - high) * k as f64;
        all[k] = [near, missing / k as f64];
        k += 1;
    }
    all
};
