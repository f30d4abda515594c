//! An interpolant of Radau IIA's steps that is as good as their ends.

use crate::method::Interpolant;
use crate::scalar::{Comparison, Scalar};
use crate::state::{State, Tangent};
use nalgebra::SVector;

/// Places of the conditions, each as often as conditions are there.
const PLACES: [f64; 8] = [0.0, 0.0, 0.5, 0.5, 0.5, 1.0, 1.0, 1.0];

/// The polynomial of degree 7 through q and q̇ at the start of a step, and q, q̇ and q̈ in its middle, where a step
/// of half the size leads, and at its end, with the errors `O(h⁸)` in q and `O(h⁷)` in q̇ beside those of both steps.
///
/// Accelerations are those of the collocation polynomials: at a state that is off by a rounding error a stiff system
/// has others, of any size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Refined<S, const N: usize> {
    from: State<S, N>,
    h: S,
    /// Newton's form of `q − q₀` over `PLACES`.
    d: [SVector<S, N>; 8],
    /// Evaluations of the equations of motion that the middle took.
    evaluations: u32,
}

/// Values of a collocation polynomial at its end, or in its middle: the increments, and `h q̈` with the size `h` of
/// the whole step.
#[derive(Clone, Copy)]
pub(super) struct Place<S, const N: usize> {
    increment: Tangent<S, N>,
    slope: SVector<S, N>,
}

impl<S: Scalar, const N: usize> Place<S, N> {
    /// At θ of a polynomial over `part` of the step, where the increments are these and
    /// `q̇ = q̇₀ + θ(v₁ + θ(v₂ + θ v₃))`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn new(increment: Tangent<S, N>, [v1, v2, v3]: &[SVector<S, N>; 3], theta: S, part: f64) -> Self {
        let slope = (v3 * (S::from_f64(3.0) * theta) + v2 * S::from_f64(2.0)) * theta + v1;
        Place { increment, slope: slope * S::from_f64(1.0 / part) }
    }

    /// `self`, but for scalars side by side that it does not know, because an iteration has failed there.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn or(&self, other: &Self) -> Self {
        let mut total = S::zero();
        for i in 0..N {
            total += self.increment.q[i] + self.increment.qd[i] + self.slope[i];
        }
        let mut chosen = *other;
        let choose = |a: &SVector<S, N>, b: &mut SVector<S, N>| {
            for i in 0..N {
                b[i] = S::select(Comparison::Less, (total * S::zero()).abs(), S::one(), a[i], b[i]);
            }
        };
        choose(&self.increment.q, &mut chosen.increment.q);
        choose(&self.increment.qd, &mut chosen.increment.qd);
        choose(&self.slope, &mut chosen.slope);
        chosen
    }
}

impl<S: Scalar, const N: usize> Refined<S, N> {
    /// The interpolant of a step of size `h`, from states and derivatives at its middle and its end.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn new(from: &State<S, N>, h: S, [middle, end]: [&Place<S, N>; 2], evaluations: u32) -> Self {
        let velocity = |place: &Place<S, N>| (from.qd + place.increment.qd) * h;
        let start = [from.q * S::zero(), from.qd * h];
        let [middle, end] = [middle, end]
            .map(|place| [place.increment.q, velocity(place), place.slope * (h * S::from_f64(0.5))]);
        // Divided differences; over equal places, derivatives over factorials.
        let known = |i: usize, level: usize| match PLACES[i] {
            0.0 => start[level],
            0.5 => middle[level],
            _ => end[level],
        };
        let mut column = [start[0]; 8];
        for i in 0..8 {
            column[i] = known(i, 0);
        }
        let mut d = column;
        for level in 1..8 {
            for i in 0..8 - level {
                let width = PLACES[i + level] - PLACES[i];
                column[i] = match width {
                    0.0 => known(i, level),
                    _ => (column[i + 1] - column[i]) * S::from_f64(1.0 / width),
                };
            }
            d[level] = column[0];
        }
        Refined { from: *from, h, d, evaluations }
    }

    /// Evaluations of the equations of motion that it took.
    pub(super) fn evaluations(&self) -> u32 {
        self.evaluations
    }
}

impl<S: Scalar, const N: usize> Interpolant<S, N> for Refined<S, N> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn at(&self, t: S) -> State<S, N> {
        let theta = (t - self.from.t) / self.h;
        let (mut value, mut slope) = (self.d[7], self.d[7] * S::zero());
        for k in (0..7).rev() {
            let x = theta - S::from_f64(PLACES[k]);
            slope = slope * x + value;
            value = value * x + self.d[k];
        }
        State { t, q: self.from.q + value, qd: slope / self.h }
    }
}
