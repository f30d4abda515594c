//! Step sizes of Taylor series, from the decay of their coefficients.

use super::{LONG_ROOM, Remainder, first_asked};
use crate::controller::{AbsoluteTolerance, Controller, FirstStep, Verdict, bounded, sensible};
use crate::failure::Failure;
use crate::scalar::{Real, Scalar};
use crate::series::WINDOW;
use crate::state::{State, Tangent};
use nalgebra::SVector;

/// The controller of [`Taylor`](const@super::Taylor). In the norm `max |xᵢ|/scᵢ` with `scᵢ = atolᵢ + rtol |xᵢ|` let the
/// coefficients decay from A = ‖x_0‖ like `A/ρᵏ`; then the first term left out is below the tolerance for
///
/// `h = s ρ A^(−1/(p+1))`, `ρ = min_k (A/‖x_k‖)^(1/k)` over the last coefficients of the series.
///
/// With the order `1 − ½ ln ε` this is Jorba and Zou's `ρ/e²` (their formula 11) but for their margin. A step is
/// rejected if the estimate of its error is above the tolerance.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct TaylorController<A = f64> {
    absolute: A,
    relative: f64,
    #[cfg_attr(feature = "serde", serde(with = "crate::saved::number"))]
    longest: f64,
    /// No step has been accepted yet.
    first: bool,
}

/// The usual error of a step, as a share of the tolerance; that of the first step, whose size is a guess, and of
/// repeated ones shall not be much larger.
const USUAL: f64 = 0.05;

/// Share of the longest step that the coefficients allow, as its binary logarithm: 0.85. (With orders as high as
/// these are, a tenth of it is a factor of 7 in the error.)
const LOG_SAFETY: f64 = -0.23446525363702297;

/// Place of x > 0 among all numbers: 2⁵² + 2⁴⁰ (1023 + log₂ x), as if logarithms were linear between powers of two,
/// which is true to 0.09 · 2⁴⁰ (Mitchell, *IRE Trans. Electron. Comput.* EC-11 (1962) 512). Sizes of steps are a
/// quarter (order 8) to a sixteenth of what is found by it, and all of the next step waits for them.
#[inline(always)]
const fn place(x: f64) -> f64 {
    f64::from_bits((x.to_bits() >> 12) | ((1u64 << 52) as f64).to_bits())
}

/// Place of 1.
const ONE: f64 = place(1.0);

/// 2⁻⁴⁰/k, which make parts of logarithms of differences of places.
const SHARES: [f64; LONG_ROOM] = {
    let mut all = [0.0; LONG_ROOM];
    let mut k = 1;
    while k < LONG_ROOM {
        all[k] = 1.0 / ((1u64 << 40) * k as u64) as f64;
        k += 1;
    }
    all
};

/// Sizes of steps that a factor of two is divided into.
const SIZES: usize = 64;

/// 2ⁱᐟ⁶⁴ to seven binary digits.
const MANTISSAS: [f64; SIZES] = {
    let mut all = [1.0; SIZES];
    let mut i = 0;
    while i < SIZES {
        // The series of the exponential function, from its end.
        let (x, mut sum, mut k) = (core::f64::consts::LN_2 * i as f64 / SIZES as f64, 1.0, 20);
        while k > 0 {
            sum = 1.0 + sum * x / k as f64;
            k -= 1;
        }
        all[i] = (sum * SIZES as f64 + 0.5) as u64 as f64 / SIZES as f64;
        i += 1;
    }
    all
};

/// A size of few digits near 2ˣ, for |x| ≤ 1000. Steps whose sizes follow a periodic motion smoothly fall into step
/// with it: each turn then meets the same states, whose rounding errors are the same and add up in proportion to
/// time. Sizes that are the same for a range of states move all of these alike, and turns differ.
#[inline(always)]
fn short(x: f64) -> f64 {
    // Added to a number, it leaves the nearest multiple of 1/64 in the last bits.
    const ROUND: f64 = 1.5 * (1u64 << 52) as f64 / SIZES as f64;
    let bits = (x + ROUND).to_bits();
    let mantissa = MANTISSAS[bits as usize % SIZES];
    f64::from_bits(mantissa.to_bits().wrapping_add((bits / SIZES as u64) << 52))
}

impl TaylorController {
    /// Relative and absolute tolerance `tolerance`, the latter in the units of each component of q and q̇.
    pub const fn tolerance(tolerance: f64) -> Self {
        TaylorController { absolute: tolerance, relative: tolerance, longest: f64::INFINITY, first: true }
    }
}

impl<A: Copy> TaylorController<A> {
    /// The relative tolerance `rtol`, a number without a unit.
    pub const fn rtol(self, rtol: f64) -> Self {
        TaylorController { relative: rtol, ..self }
    }

    /// The absolute tolerance `atol`: one number, or a [`Tangent`] with one for each component of q and q̇, see
    /// [`PiController::atol`](crate::PiController::atol).
    pub const fn atol<B: Copy>(self, atol: B) -> TaylorController<B> {
        TaylorController { absolute: atol, relative: self.relative, longest: self.longest, first: self.first }
    }

    /// Makes no step longer than `h`, in units of t, see [`PiController::max_step`](crate::PiController::max_step). The
    /// terms of a series decay as they do at the start of the step: it represents a force by the derivatives there.
    pub const fn max_step(self, h: f64) -> Self {
        TaylorController { longest: h, ..self }
    }
}

impl<A> TaylorController<A> {
    /// Errors over what is tolerated of L steps of sizes h side by side, and by how much the next steps may be
    /// longer. `magnitude` is that of a number of the i-th of them.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn measured<S: Scalar, const L: usize, const N: usize>(
        &self,
        h: [f64; L],
        to: &State<S, N>,
        remainder: &Remainder<S, N>,
        magnitude: impl Fn(S, usize) -> f64 + Copy,
    ) -> [[f64; 2]; L]
    where
        A: AbsoluteTolerance<N>,
    {
        let Remainder { error, last, order } = remainder;
        let (p, mut share) = (*order, [0.0; L]);
        let (mut weights, mut weights_d) = ([[0.0; L]; N], [[0.0; L]; N]);
        for l in 0..L {
            // Early, since the next step waits for its size and not for this division.
            share[l] = 1.0 / h[l];
        }
        for i in 0..N {
            for l in 0..L {
                weights[i][l] = 1.0 / (self.absolute.q(i) + self.relative * magnitude(to.q[i], l));
            }
            for l in 0..L {
                weights_d[i][l] = 1.0 / (self.absolute.qd(i) + self.relative * magnitude(to.qd[i], l));
            }
        }
        let mut errors = largest(&error.q, &error.qd, &weights, &weights_d, magnitude);
        // That of q is a part of that of q̇: if that is a number, so is this.
        let mut sum = S::zero();
        for i in 0..N {
            sum += error.qd[i];
        }
        for l in 0..L {
            errors[l] += magnitude(sum, l) * 0.0;
        }
        let size = largest(&to.q, &to.qd, &weights, &weights_d, magnitude);
        // A state as small as the tolerance says nothing of the decay.
        let (mut place_of_size, mut log_radius) = ([0.0; L], [f64::INFINITY; L]);
        for l in 0..L {
            place_of_size[l] = place(if size[l] > 1.0 { size[l] } else { 1.0 });
        }
        for w in 0..WINDOW {
            let over = SHARES[first_asked(p) + w];
            let coefficient = largest(&last[w].q, &last[w].qd, &weights, &weights_d, magnitude);
            for l in 0..L {
                let log_k = (place_of_size[l] - place(coefficient[l])) * over;
                log_radius[l] = if log_k < log_radius[l] { log_k } else { log_radius[l] };
            }
        }
        let mut measured = [[0.0; 2]; L];
        for l in 0..L {
            let log_longest = log_radius[l] - ((place_of_size[l] - ONE) * SHARES[p + 1] - LOG_SAFETY);
            let factor = short(if log_longest < 1000.0 { log_longest } else { 1000.0 }) * share[l];
            // Coefficients that all vanish, as at rest, allow any step.
            measured[l] = [errors[l], if factor < 1e3 { factor } else { 1e3 }];
        }
        measured
    }

    /// Verdict of a measure on a step in a scalar of this [`EPSILON`](Real::EPSILON).
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn decide<const N: usize>(
        &mut self,
        [error, factor]: [f64; 2],
        order: u32,
        epsilon: f64,
    ) -> Verdict
    where
        A: AbsoluteTolerance<N>,
    {
        // Below rounding the estimate is rounding.
        let (most, seen) =
            (if self.first { 4.0 * USUAL } else { 1.0 }, epsilon / (self.absolute.least() + self.relative));
        let most = if most > seen { most } else { seen };
        if error > most || error.is_nan() {
            let shorter = libm::pow(USUAL / error, 1.0 / (f64::from(order) + 1.0));
            return Verdict::Reject { factor: if shorter >= 0.1 { shorter.min(0.8) } else { 0.1 } };
        }
        self.first = false;
        Verdict::Accept { factor }
    }
}

/// The largest of all components, each times its weight. (What is not a number may be passed over.)
#[cfg_attr(not(debug_assertions), inline(always))]
fn largest<S: Scalar, const L: usize, const N: usize>(
    q: &SVector<S, N>,
    qd: &SVector<S, N>,
    weights: &[[f64; L]; N],
    weights_d: &[[f64; L]; N],
    magnitude: impl Fn(S, usize) -> f64 + Copy,
) -> [f64; L] {
    let mut most = [0.0; L];
    for i in 0..N {
        for l in 0..L {
            let x = magnitude(q[i], l) * weights[i][l];
            most[l] = if most[l] > x { most[l] } else { x };
        }
        for l in 0..L {
            let x = magnitude(qd[i], l) * weights_d[i][l];
            most[l] = if most[l] > x { most[l] } else { x };
        }
    }
    most
}

impl<S: Real, A: AbsoluteTolerance<N>, const N: usize> Controller<S, N, Remainder<S, N>>
    for TaylorController<A>
{
    const EQUAL_STEPS: Option<bool> = Some(false);

    fn first_step(&self) -> FirstStep<S> {
        FirstStep::Automatic
    }

    fn check(&self) -> Result<(), Failure<S>> {
        sensible(&self.absolute, self.relative)?;
        bounded(self.longest)
    }

    #[inline(always)]
    fn relative_tolerance(&self) -> Option<f64> {
        Some(self.relative).filter(|relative| *relative > 0.0)
    }

    #[inline(always)]
    fn max_step(&self) -> f64 {
        self.longest
    }

    fn norm(&self, difference: &Tangent<S, N>, a: &State<S, N>, _: &State<S, N>) -> f64 {
        let weight = |absolute: f64, x: &S| [1.0 / (absolute + self.relative * x.magnitude())];
        let weights = core::array::from_fn(|i| weight(self.absolute.q(i), &a.q[i]));
        let weights_d = core::array::from_fn(|i| weight(self.absolute.qd(i), &a.qd[i]));
        let [norm] = largest(&difference.q, &difference.qd, &weights, &weights_d, |x: S, _| x.magnitude());
        norm
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn judge(
        &mut self,
        from: &State<S, N>,
        to: &State<S, N>,
        remainder: &Remainder<S, N>,
        order: u32,
    ) -> Verdict {
        let h = [(to.t - from.t).to_f64().abs()];
        let [measure] = self.measured(h, to, remainder, |x, _| x.magnitude());
        self.decide::<N>(measure, order, S::EPSILON)
    }

    fn after_failure(&mut self) -> Option<f64> {
        Some(0.5)
    }
}
