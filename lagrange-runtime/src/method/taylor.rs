//! Taylor series of high order: the method for the last digits.
//!
//! The compiler emits recurrences that give the Taylor coefficients of the motion one order after the other
//! ([`Analytic`]). A step is the sum of the series: of order p it costs about p²/2 operations for each product in the
//! equations, and may be as long as the series converges quickly, whatever the tolerance (Moore 1966; Corliss and Chang
//! 1982; Jorba and Zou, *Exper. Math.* 14 (2005) 99; Biscani and Izzo, *MNRAS* 504 (2021) 2614).
//!
//! The order belongs to the tolerance ([`Taylor::for_tolerance`]). The step follows from the
//! decay of the coefficients. The published rule asks the last two of them, and is fooled by motions whose symmetry makes
//! coefficients vanish in turn, such as a pendulum released from rest at 90°. Here the last [`WINDOW`] have a say,
//! and each step is checked: by the difference between the accelerations of the polynomial at its end and those of the
//! system, which are known anyway, since the next series begins there.

use super::{Dense, Method, Step};
use crate::controller::{Controller, FirstStep, Verdict, exp2, log2};
use crate::failure::Failure;
use crate::scalar::{Functions, Real, Scalar};
use crate::series::{Analytic, Series};
use crate::state::{State, Tangent};
use nalgebra::SVector;

/// Room for the coefficients of [`Taylor`]: orders up to 22.
const USUAL_ROOM: usize = 24;

/// Room for the coefficients of [`LongTaylor`]: orders up to 62.
const LONG_ROOM: usize = 64;

/// Coefficients that are asked how long the next step may be.
pub const WINDOW: usize = 4;

/// Taylor series of a given order, with [`Decay`] for its controller.
///
/// ```
/// use lagrange_runtime::prelude::*;
///
/// lagrangian! {
///     system Pendulum {
///         param l, g = 9.81;
///         coord theta;
///         T = 0.5 * (l * dot(theta)).powi(2);
///         V = -g * l * cos(theta);
///     }
/// }
/// let (pendulum, start) = (Pendulum::new(1.0), State::new(0.0, [2.0], [0.0]));
/// let tolerance = 1e-15;
/// let run = integrate(&pendulum, Taylor::for_tolerance(tolerance), Decay::tolerance(tolerance), start);
/// let end = run.until(100.0).finish()?;
/// let energy = |at: &State<f64, 1>| pendulum.energy(&at.q, &at.qd, at.t);
/// assert!((energy(&end) - energy(&start)).abs() < 1e-13);
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Taylor<const ROOM: usize = USUAL_ROOM> {
    order: usize,
}

/// Taylor series of orders up to 62, for scalars of more digits than `f64` and tolerances down to 1e-31. It is not made for
/// speed in `f64`: all its coefficients have room for 62 orders.
///
/// ```
/// use lagrange_runtime::prelude::*;
/// use lagrange_runtime::{DoubleDouble, LongTaylor};
///
/// lagrangian! {
///     system Oscillator {
///         param k;
///         coord x;
///         T = 0.5 * dot(x).powi(2);
///         V = 0.5 * k * x * x;
///     }
/// }
/// let one = DoubleDouble::from(1.0);
/// let oscillator = Oscillator { k: one };
/// let start = State::new(DoubleDouble::from(0.0), [one], [DoubleDouble::from(0.0)]);
/// let run = integrate(&oscillator, LongTaylor::with_tolerance(1e-30), Decay::tolerance(1e-30), start);
/// let end = run.until(DoubleDouble::from(10.0)).finish()?;
/// let error = end.q[0] - DoubleDouble::from(10.0).cos();
/// assert!(error.to_f64().abs() < 1e-28);
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
pub type LongTaylor = Taylor<LONG_ROOM>;

impl Taylor {
    /// Series to order p, kept within 8 and 22: shorter ones do not show how they decay.
    pub fn of_order(p: usize) -> Self {
        Taylor::within(p)
    }

    /// The order with the least work for a tolerance, 8 − 0.55 ln ε, rounded up, and at most 20: on processors without long vectors
    /// the last two orders of larger systems take as long as the ten before.
    ///
    /// Where an order costs what all orders before it do, that is `1 − ½ ln ε` (Jorba and Zou, 3.2). A step has costs of its own,
    /// and higher orders cost little more than lower ones.
    pub fn for_tolerance(tolerance: f64) -> Self {
        Taylor::within(order_for(tolerance).min(20))
    }
}

impl LongTaylor {
    /// Series to order p, kept within 8 and 62.
    pub fn with_order(p: usize) -> Self {
        Taylor::within(p)
    }

    /// As that of [`Taylor::for_tolerance`], at most 62.
    pub fn with_tolerance(tolerance: f64) -> Self {
        Taylor::within(order_for(tolerance))
    }
}

impl<const ROOM: usize> Taylor<ROOM> {
    fn within(p: usize) -> Self {
        Taylor { order: p.clamp(8, ROOM - 2) }
    }
}

fn order_for(tolerance: f64) -> usize {
    let p = 8.0 - 0.55 * Functions::ln(tolerance);
    let below = p as usize;
    if p > below as f64 { below + 1 } else { below }
}

/// What a step of [`Taylor`] knows of its error and of the next step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Remainder<S, const N: usize> {
    /// The estimated error of the step.
    error: Tangent<S, N>,
    /// The last coefficients of the series at its end, by orders up to `order`.
    last: [Tangent<S, N>; WINDOW],
    order: usize,
}

/// The coordinates' series at the state reached, and what was lost in rounding it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Memory<S, const N: usize, const ROOM: usize> {
    series: Series<S, N, ROOM>,
    lost: Tangent<S, N>,
}

impl<Sys: Analytic<N>, const N: usize, const ROOM: usize> Method<Sys, N> for Taylor<ROOM>
where
    Sys::Scalar: Real,
{
    type Memory = Memory<Sys::Scalar, N, ROOM>;
    /// The polynomials of the step.
    type Stages = Series<Sys::Scalar, N, ROOM>;
    type Error = Remainder<Sys::Scalar, N>;
    type Dense = Polynomial<Sys::Scalar, N, ROOM>;

    fn order(&self) -> u32 {
        self.order as u32
    }

    fn start(&self, system: &Sys, at: &State<Sys::Scalar, N>) -> Result<Self::Memory, Failure<Sys::Scalar>> {
        Ok(Memory { series: system.series(at, self.order), lost: Tangent::zero() })
    }

    #[inline(always)]
    fn step(
        &self,
        system: &Sys,
        memory: &Self::Memory,
        from: &State<Sys::Scalar, N>,
        h: Sys::Scalar,
    ) -> Result<Step<Sys, Self, N>, Failure<Sys::Scalar>> {
        // The step that the rounded time makes.
        let t = from.t + h;
        let h = t - from.t;
        let p = self.order;
        let Memory { series, lost } = memory;
        let mut to = State { t, ..*from };
        let mut carried = Tangent::zero();
        let changes = changes(series, p, h);
        for i in 0..N {
            (to.q[i], carried.q[i]) = added(from.q[i], changes.q[i] + lost.q[i]);
            (to.qd[i], carried.qd[i]) = added(from.qd[i], changes.qd[i] + lost.qd[i]);
        }
        let next: Series<_, N, ROOM> = system.series(&to, p);
        let mut error = Remainder { error: Tangent::zero(), last: [Tangent::zero(); WINDOW], order: p };
        let accelerations = next.velocities(1);
        let [weight, weight_next] = [p + 1, p + 2].map(|k| h / Sys::Scalar::from_f64(k as f64));
        for i in 0..N {
            error.error.qd[i] = (changes.slopes[i] - accelerations[i]) * weight;
            error.error.q[i] = error.error.qd[i] * weight_next;
        }
        for w in 0..WINDOW {
            let k = p + 1 + w - WINDOW;
            error.last[w] = Tangent { q: next.q[k].into(), qd: next.velocities(k).into() };
        }
        let memory = Memory { series: next, lost: carried };
        Ok(Step { from: *from, to, h, error, memory, stages: *series, evaluations: p as u32 })
    }

    fn dense(&self, _: &Sys, step: &Step<Sys, Self, N>) -> Self::Dense {
        Polynomial { series: step.stages, order: self.order, from: step.from }
    }

    /// Steps are long, and looking at their polynomials is cheap.
    fn parts(&self) -> u32 {
        2 * self.order as u32
    }

    fn start_evaluations(&self) -> u32 {
        self.order as u32
    }
}

/// The sum of two numbers and what it lacks (Knuth, *The Art of Computer Programming* 2, 4.2.2, theorem B).
#[inline(always)]
fn added<S: Scalar>(a: S, b: S) -> (S, S) {
    let sum = a + b;
    let part = sum - a;
    (sum, (a - (sum - part)) + (b - part))
}

/// What h changes.
struct Changes<S, const N: usize> {
    q: [S; N],
    qd: [S; N],
    /// Of the velocities, at the end.
    slopes: [S; N],
}

/// What x_k hᵏ⁻² is multiplied by in the change of x, of ẋ and in ẍ: 1, k and k (k − 1).
const WEIGHTS: [[f64; 3]; LONG_ROOM] = {
    let mut weights = [[0.0; 3]; LONG_ROOM];
    let mut k = 0;
    while k < LONG_ROOM {
        weights[k] = [1.0, k as f64, (k * k) as f64 - k as f64];
        k += 1;
    }
    weights
};

/// The changes of q and q̇ after h, and q̈ there, for `q = Σ q_k hᵏ` with k up to p + 1. Every fourth order is summed beside the
/// others (Knuth 4.6.4, "second-order Horner" twice): a sum waits for a quarter as many others.
#[inline(always)]
fn changes<S: Scalar, const N: usize, const ROOM: usize>(
    series: &Series<S, N, ROOM>,
    p: usize,
    h: S,
) -> Changes<S, N> {
    let square = h * h;
    let fourth = square * square;
    let mut sums = [[[S::zero(); N]; 3]; 4];
    let mut m = p.div_ceil(4).min((ROOM - 2).div_ceil(4));
    while m > 0 {
        m -= 1;
        for rest in 0..4 {
            let k = 4 * m + rest + 2;
            if k < ROOM && k < LONG_ROOM {
                for of in 0..3 {
                    let weight = S::from_f64(WEIGHTS[k][of]);
                    for i in 0..N {
                        sums[rest][of][i] = sums[rest][of][i].mul_add(fourth, weight * series.q[k][i]);
                    }
                }
            }
        }
    }
    let [a, b, c, d] = sums;
    let mut changes = Changes { q: [S::zero(); N], qd: [S::zero(); N], slopes: [S::zero(); N] };
    for i in 0..N {
        let sum = |of: usize| {
            let (low, high) = (b[of][i].mul_add(h, a[of][i]), d[of][i].mul_add(h, c[of][i]));
            high.mul_add(square, low)
        };
        changes.q[i] = sum(0).mul_add(h, series.q[1][i]) * h;
        (changes.qd[i], changes.slopes[i]) = (sum(1) * h, sum(2));
    }
    changes
}

/// The polynomials of a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Polynomial<S, const N: usize, const ROOM: usize> {
    series: Series<S, N, ROOM>,
    order: usize,
    from: State<S, N>,
}

impl<S: Scalar, const N: usize, const ROOM: usize> Dense<S, N> for Polynomial<S, N, ROOM> {
    fn at(&self, t: S) -> State<S, N> {
        let h = t - self.from.t;
        let mut state = State { t, ..self.from };
        let changes = changes(&self.series, self.order, h);
        for i in 0..N {
            state.q[i] += changes.q[i];
            state.qd[i] += changes.qd[i];
        }
        state
    }
}

/// The controller of [`Taylor`]. In the norm `max |xᵢ|/scᵢ` with `scᵢ = absolute + relative |xᵢ|` let the coefficients decay
/// from A = ‖x_0‖ like `A/ρᵏ`; then the first term left out is below the tolerance for
///
/// `h = s ρ A^(−1/(p+1))`, `ρ = min_k (A/‖x_k‖)^(1/k)` over the last coefficients of the series.
///
/// With the order `1 − ½ ln ε` this is Jorba and Zou's `ρ/e²` (their formula 11) but for their margin. A step is
/// rejected if the estimate of its error is above the tolerance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decay {
    absolute: f64,
    relative: f64,
    /// No step has been accepted yet.
    first: bool,
}

/// The usual error of a step, as a share of the tolerance; that of the first step, whose size is a guess, and of repeated
/// ones shall not be much larger.
const USUAL: f64 = 0.05;

/// Share of the longest step that the coefficients allow. (With orders as high as these are, a tenth of it is a factor of 7 in the
/// error.)
const SAFETY: f64 = 0.85;

impl Decay {
    /// A controller with the given absolute tolerance (in units of q and q̇) and relative one.
    pub const fn new(absolute: f64, relative: f64) -> Self {
        Decay { absolute, relative, first: true }
    }

    /// Both tolerances equal to `tolerance`.
    pub const fn tolerance(tolerance: f64) -> Self {
        Decay::new(tolerance, tolerance)
    }

    /// 1/scᵢ of q and of q̇.
    #[inline(always)]
    fn weights<S: Real, const N: usize>(&self, at: &State<S, N>) -> [[f64; N]; 2] {
        let mut weights = [[0.0; N]; 2];
        for i in 0..N {
            weights[0][i] = 1.0 / (self.absolute + self.relative * at.q[i].magnitude());
            weights[1][i] = 1.0 / (self.absolute + self.relative * at.qd[i].magnitude());
        }
        weights
    }
}

/// The largest of all components, each times its weight; not a number is larger than any number.
#[inline(always)]
fn largest<S: Real, const N: usize>(q: &SVector<S, N>, qd: &SVector<S, N>, weights: &[[f64; N]; 2]) -> f64 {
    let larger = |a: f64, b: f64| if b <= a { a } else { b };
    let mut most = 0.0;
    for i in 0..N {
        most = larger(most, q[i].magnitude() * weights[0][i]);
        most = larger(most, qd[i].magnitude() * weights[1][i]);
    }
    most
}

impl<S: Real, const N: usize> Controller<S, N, Remainder<S, N>> for Decay {
    fn first_step(&self) -> FirstStep<S> {
        FirstStep::Automatic
    }

    fn check(&self) -> Result<(), Failure<S>> {
        let Decay { absolute, relative, .. } = *self;
        let good = |x: f64| x.is_finite() && x >= 0.0;
        if good(absolute) && good(relative) && absolute + relative > 0.0 {
            Ok(())
        } else {
            Err(Failure::BadTolerance { absolute, relative })
        }
    }

    fn norm(&self, difference: &Tangent<S, N>, a: &State<S, N>, _: &State<S, N>) -> f64 {
        largest(&difference.q, &difference.qd, &self.weights(a))
    }

    #[inline(always)]
    fn judge(
        &mut self,
        from: &State<S, N>,
        to: &State<S, N>,
        remainder: &Remainder<S, N>,
        order: u32,
    ) -> Verdict {
        // Early, since the next step waits for its size and not for this division.
        let share = SAFETY / (to.t - from.t).to_f64().abs();
        let weights = self.weights(to);
        let error = largest(&remainder.error.q, &remainder.error.qd, &weights);
        let most = if self.first { 4.0 * USUAL } else { 1.0 };
        if error > most || error.is_nan() {
            let shorter = Functions::powf(USUAL / error, 1.0 / (f64::from(order) + 1.0));
            return Verdict::Reject { factor: if shorter >= 0.1 { shorter.min(0.8) } else { 0.1 } };
        }
        self.first = false;
        // A state as small as the tolerance says nothing of the decay.
        let log_size = log2(largest(&to.q, &to.qd, &weights).max(1.0));
        let mut log_radius = f64::INFINITY;
        for (w, x) in remainder.last.iter().enumerate() {
            let k = (remainder.order + 1 + w - WINDOW) as f64;
            let log_k = (log_size - log2(largest(&x.q, &x.qd, &weights))) / k;
            if log_k < log_radius {
                log_radius = log_k;
            }
        }
        let longest = exp2((log_radius - log_size / (f64::from(order) + 1.0)).min(1000.0));
        // Coefficients that all vanish, as at rest, allow any step.
        Verdict::Accept { factor: (longest * share).min(1e3) }
    }

    fn after_failure(&mut self) -> Option<f64> {
        Some(0.5)
    }
}

#[cfg(test)]
mod tests;
