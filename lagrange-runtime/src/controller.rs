//! Who decides about a step: accept or reject, and how long the next one shall be. Tolerances and norms live only here.
//!
//! Among the published step-size laws [`PiController`] is the PI one with the constants of Hairer's codes: it removes
//! the step-size oscillations that the elementary law shows where stability limits the step, and needs no tuning per
//! problem. The others (Söderlind's PI, PID and digital filters) are constructors of [`PidController`].

use crate::failure::Failure;
use crate::scalar::{Comparison, Functions, Real, Scalar};
use crate::state::{State, Tangent};
use core::fmt;
use nalgebra::SVector;

mod pid;

pub use pid::PidController;

/// Verdict of a controller on a trial step. The next step is `factor · h`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Verdict {
    /// The step is good.
    Accept {
        /// Next step over this one.
        factor: f64,
    },
    /// The step is to be tried again.
    Reject {
        /// Next trial over this one; below 1.
        factor: f64,
    },
}

/// Verdicts on steps side by side. (Fields of their own, so that the optimiser sees vectors in them.)
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Verdicts<const L: usize> {
    /// True for each step that is good.
    pub accepted: [bool; L],
    /// The next step or trial over this one.
    pub factor: [f64; L],
}

impl Verdicts<1> {
    /// The verdict on the only step.
    #[inline(always)]
    fn only(self) -> Verdict {
        let Verdicts { accepted: [accepted], factor: [factor] } = self;
        if accepted { Verdict::Accept { factor } } else { Verdict::Reject { factor } }
    }
}

/// Source of the size of the first step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FirstStep<S> {
    /// Given, in units of t, and the same for all steps.
    Fixed(S),
    /// Given, in units of t, and changed by the controller from then on.
    Given(S),
    /// Chosen from the equations (Hairer, Nørsett, Wanner 1993, II.4, "Starting step size").
    Automatic,
}

/// Judges the steps of a method whose error estimates are of type `E`.
#[diagnostic::on_unimplemented(
    message = "`{Self}` does not control the step size of methods with the error estimate `{E}`",
    note = "adaptive controllers such as `PiController` need a method with an error estimate, such as `Dop853`; all others take `FixedStep`"
)]
pub trait Controller<S: Real, const N: usize, E>: Clone {
    /// True if all steps are equal to [`first_step`](Self::first_step), false if they are not, `None` if the type alone
    /// does not tell. A run compiles both kinds of time loop only for `None`.
    const EQUAL_STEPS: Option<bool> = None;

    /// Source of the size of the first step.
    fn first_step(&self) -> FirstStep<S>;

    /// The controller with a given first step, of size `h` in units of t and the sign of the run; `None` if its steps
    /// are equal, or do not follow from the one before.
    fn with_first_step(&self, h: f64) -> Option<Self> {
        let _ = h;
        None
    }

    /// Returns whether what the user gave makes sense.
    fn check(&self) -> Result<(), Failure<S>>;

    /// The dimensionless norm of a difference of states near `a` and `b`; 1 is the tolerance.
    fn norm(&self, difference: &Tangent<S, N>, a: &State<S, N>, b: &State<S, N>) -> f64;

    /// Returns whether the projection onto the constraints of a system may move the end of a step from `from` by
    /// `correction`, to `to`. A local error within the tolerance leaves the constraints by as little. Where the way
    /// back is longer, the constraints are nearly dependent, and the error estimate of the step does not include the
    /// correction.
    fn tolerates(&self, correction: &Tangent<S, N>, from: &State<S, N>, to: &State<S, N>) -> bool {
        self.norm(correction, from, to) <= 1.0
    }

    /// Judges a step from `from` to `to`, with the given error estimate, of a method of the given order.
    fn judge(&mut self, from: &State<S, N>, to: &State<S, N>, error: &E, order: u32) -> Verdict;

    /// Factor by which to shorten a step that failed, dimensionless and below 1, or `None` to give up.
    fn after_failure(&mut self) -> Option<f64>;

    /// The relative tolerance, dimensionless, if there is one above 0, for methods that adapt to it.
    #[inline(always)]
    fn relative_tolerance(&self) -> Option<f64> {
        None
    }

    /// The longest step, in units of t.
    #[inline(always)]
    fn max_step(&self) -> f64 {
        f64::INFINITY
    }
}

/// Fails unless `longest` can be the longest step.
pub(crate) fn bounded<S: Real>(longest: f64) -> Result<(), Failure<S>> {
    if longest > 0.0 { Ok(()) } else { Err(Failure::BadStepSize { h: S::from_f64(longest) }) }
}

/// The mark of methods without an error estimate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NoEstimate;

/// An estimate of the local error of a step.
#[diagnostic::on_unimplemented(
    message = "an adaptive step size needs an error estimate, which this method does not give",
    note = "use `FixedStep::new(h)`, or a method with an error estimate, such as `Dop853` or `DormandPrince5`; `Taylor` has a controller of its own, `TaylorController::tolerance(…)`"
)]
pub trait ErrorEstimate<S: Scalar, const N: usize> {
    /// The square of the dimensionless norm of the error. (Step-size control needs no roots.) `R` is `f64` or lanes.
    fn square<R: Scalar>(&self, norm: &impl SquareNorm<S, R, N>) -> R;
}

/// The square of a norm. (No closure: one that is not inlined is compiled for the least processor, and lanes with it.)
pub trait SquareNorm<S: Scalar, R: Scalar, const N: usize> {
    /// The square of the norm of an error, dimensionless.
    fn of(&self, error: &Tangent<S, N>) -> R;

    /// Lower bound of the dimensionless ratio of the square of the error of a step of order 8 to the square of an
    /// estimate of order 3.
    fn eighth_by_third(&self) -> f64;
}

impl<S: Scalar, const N: usize> ErrorEstimate<S, N> for Tangent<S, N> {
    #[inline(always)]
    fn square<R: Scalar>(&self, norm: &impl SquareNorm<S, R, N>) -> R {
        norm.of(self)
    }
}

/// Two estimates of different order, combined to `e₅² / √(e₅² + 0.01 e₃²)`, which behaves like `h⁸` for small steps and
/// is robust for large ones (Hairer, Nørsett, Wanner 1993, II.10, eq. 10.17), but at least `e₃ rtol^(5/9) / 30`.
///
/// As a function of the step size, e₅ changes its sign in some motions. The combination has a double zero there, and
/// a long step whose error is a hundred times the tolerance passes for exact. A step of order 8 whose error is the
/// tolerance has an e₃ of about `rtol^(4/9)` of the values: the lower bound rejects a step whose e₃ is thirty times
/// as large.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TwoEstimates<S, const N: usize> {
    /// The difference to the embedded formula of order 5.
    pub fifth: Tangent<S, N>,
    /// The difference to the embedded formula of order 3.
    pub third: Tangent<S, N>,
}

impl<S: Scalar, const N: usize> ErrorEstimate<S, N> for TwoEstimates<S, N> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn square<R: Scalar>(&self, norm: &impl SquareNorm<S, R, N>) -> R {
        let (fifth, third) = (norm.of(&self.fifth), norm.of(&self.third));
        // Two zeros combine to 0.
        let denominator = fifth + (R::from_f64(0.01) * third + R::from_f64(f64::MIN_POSITIVE));
        let both = fifth * (fifth / denominator);
        let least = third * R::from_f64(norm.eighth_by_third());
        // (NaN is kept.)
        R::select(Comparison::Less, both, least, least, both)
    }
}

/// Steps of one size. Where a run has an end, its steps are equal and at most this long, see
/// [`Run::until`](crate::integrate::Run::until).
///
/// Fixed steps do not end where the equations switch (`if`, `abs`, …), but for those of
/// [`Taylor`](const@crate::Taylor): a kink of the forces changes the velocity after the step by an error of order h², a
/// jump by one of order h, whatever the order of the method. Adaptive steps end there.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(bound(
        serialize = "S: crate::Scalar + serde::Serialize",
        deserialize = "S: crate::Scalar + serde::Deserialize<'de>"
    ))
)]
pub struct FixedStep<S = f64> {
    h: S,
}

impl<S: Real> FixedStep<S> {
    /// Steps of size `h`, in units of t; negative: backward in time.
    pub const fn new(h: S) -> Self {
        FixedStep { h }
    }

    /// The given step size, in units of t.
    pub const fn size(&self) -> S {
        self.h
    }
}

impl<S: Real, const N: usize, E> Controller<S, N, E> for FixedStep<S> {
    const EQUAL_STEPS: Option<bool> = Some(true);

    #[inline]
    fn first_step(&self) -> FirstStep<S> {
        FirstStep::Fixed(self.h)
    }

    fn check(&self) -> Result<(), Failure<S>> {
        let h = self.h.to_f64();
        if h.is_finite() && h != 0.0 { Ok(()) } else { Err(Failure::BadStepSize { h: self.h }) }
    }

    #[inline]
    fn norm(&self, _: &Tangent<S, N>, _: &State<S, N>, _: &State<S, N>) -> f64 {
        0.0
    }

    /// Returns whether the correction is at most a tenth of the step: steps of one size have no tolerance.
    fn tolerates(&self, correction: &Tangent<S, N>, from: &State<S, N>, to: &State<S, N>) -> bool {
        let size = |x: &SVector<S, N>| x.iter().fold(0.0, |sum, x| sum + x.to_f64().abs());
        let step = to.minus(from);
        size(&correction.q) <= 0.1 * size(&step.q) && size(&correction.qd) <= 0.1 * size(&step.qd)
    }

    #[inline]
    fn judge(&mut self, _: &State<S, N>, _: &State<S, N>, _: &E, _: u32) -> Verdict {
        Verdict::Accept { factor: 1.0 }
    }

    #[inline]
    fn after_failure(&mut self) -> Option<f64> {
        None
    }
}

/// Absolute tolerances of the components of a state: one number for all of them, or a [`Tangent`] with one for each,
/// in the units of that component. [`PiController::atol`] and
/// [`TaylorController::atol`](crate::TaylorController::atol) take them.
pub trait AbsoluteTolerance<const N: usize>: Copy + fmt::Debug {
    /// Absolute tolerance of the coordinate `i`, in its unit.
    fn q(&self, i: usize) -> f64;

    /// Absolute tolerance of the velocity `i`, in its unit.
    fn qd(&self, i: usize) -> f64;

    /// The smallest of them, in its unit.
    fn least(&self) -> f64 {
        (0..N).fold(f64::INFINITY, |least, i| least.min(self.q(i)).min(self.qd(i)))
    }
}

impl<const N: usize> AbsoluteTolerance<N> for f64 {
    #[inline(always)]
    fn q(&self, _: usize) -> f64 {
        *self
    }

    #[inline(always)]
    fn qd(&self, _: usize) -> f64 {
        *self
    }

    #[inline(always)]
    fn least(&self) -> f64 {
        *self
    }
}

impl<const N: usize> AbsoluteTolerance<N> for Tangent<f64, N> {
    #[inline(always)]
    fn q(&self, i: usize) -> f64 {
        self.q[i]
    }

    #[inline(always)]
    fn qd(&self, i: usize) -> f64 {
        self.qd[i]
    }
}

/// Fails unless tolerances are finite and not negative, and no component has both of 0.
pub(crate) fn sensible<S: Real, A: AbsoluteTolerance<N>, const N: usize>(
    absolute: &A,
    relative: f64,
) -> Result<(), Failure<S>> {
    let good = |x: f64| x.is_finite() && x >= 0.0;
    let all = (0..N).flat_map(|i| [absolute.q(i), absolute.qd(i)]);
    match all.into_iter().find(|&x| !(good(x) && good(relative) && x + relative > 0.0)) {
        Some(absolute) => Err(Failure::BadTolerance { absolute, relative }),
        None => Ok(()),
    }
}

/// Gustafsson's PI controller (1991) in the form and with the constants of `dopri5` (Hairer, Nørsett, Wanner 1993,
/// II.4, IV.2 of the second volume and the code's defaults): `h_new = h · s · err^(−α) · err_old^β` with
/// `α = 1/p − 0.75 β`, `β = 0.2/p` (0.04 at p = 5), `s = 0.9`, the factor kept within [0.2, 10], and no growth right
/// after a rejection. The error norm is `√(Σ (eᵢ/scᵢ)² / 2N)` over q and q̇ with
/// `scᵢ = atolᵢ + rtol · max(|y₀ᵢ|, |y₁ᵢ|)`.
///
/// ```
/// use lagrange_runtime::{PiController, Tangent};
/// let pi = PiController::tolerance(1e-9).first_step(1e-3).factors(0.33, 6.0);
/// // A distance in metres and an angle, each with its own absolute tolerance.
/// let each = PiController::tolerance(1e-9).atol(Tangent { q: [1e-3, 1e-9].into(), qd: [1e-3, 1e-8].into() });
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PiController<A = f64> {
    absolute: A,
    relative: f64,
    first: Option<f64>,
    safety: f64,
    beta: f64,
    smallest: f64,
    largest: f64,
    /// The longest step.
    #[cfg_attr(feature = "serde", serde(with = "crate::saved::number"))]
    longest: f64,
    /// Logarithm, as [`log2`] has it, of the squared error of the last accepted step.
    before: f64,
    /// The largest factor of the next step: 1 right after a rejection.
    most: f64,
    /// See [`SquareNorm::eighth_by_third`].
    eighth_by_third: f64,
}

/// Errors are taken for at least this when the next step is chosen by them (`facold` of `dopri5`).
const LEAST: f64 = 1e-4;

/// Logarithm of its square.
const LEAST_LOG: f64 = log2(LEAST * LEAST);

impl PiController {
    /// Relative and absolute tolerance `tolerance`, the latter in the units of each component of q and q̇.
    pub const fn tolerance(tolerance: f64) -> Self {
        PiController {
            absolute: tolerance,
            relative: tolerance,
            first: None,
            safety: 0.9,
            beta: 0.2,
            smallest: 0.2,
            largest: 10.0,
            longest: f64::INFINITY,
            before: LEAST_LOG,
            most: 10.0,
            eighth_by_third: eighth_by_third(tolerance),
        }
    }
}

/// See [`SquareNorm::eighth_by_third`]. (Without a relative tolerance, next to nothing: values may be any number of
/// tolerances.)
const fn eighth_by_third(relative: f64) -> f64 {
    exp2(log2(relative.max(1e-30)) * 10.0 / 9.0) / 900.0
}

impl<A: Copy> PiController<A> {
    /// The relative tolerance `rtol`, a number without a unit.
    pub const fn rtol(self, rtol: f64) -> Self {
        PiController { relative: rtol, eighth_by_third: eighth_by_third(rtol), ..self }
    }

    /// The absolute tolerance `atol`: one number, or a [`Tangent`] with one for each component of q and q̇, in its
    /// units.
    ///
    /// An absolute tolerance of 0 leaves none to a component that is 0, such as the velocity of a body at rest: the
    /// step size falls to 0 there.
    pub const fn atol<B: Copy>(self, atol: B) -> PiController<B> {
        let PiController { relative, first, safety, beta, smallest, largest, longest, before, most, .. } =
            self;
        let eighth_by_third = self.eighth_by_third;
        PiController {
            absolute: atol,
            relative,
            first,
            safety,
            beta,
            smallest,
            largest,
            longest,
            before,
            most,
            eighth_by_third,
        }
    }

    /// Begins with a step of size `h`, in units of t, whose sign is made that of the run, instead of an automatic
    /// choice.
    pub const fn first_step(self, h: f64) -> Self {
        PiController { first: Some(h), ..self }
    }

    /// Makes no step longer than `h`, in units of t. (The last step of a run may be longer by a hundredth.)
    ///
    /// An error estimate knows the forces at the stages of a step alone. Where a body rests until a gust comes, steps
    /// grow until one of them is longer than the gust: the longest step has to be shorter than what is to be seen.
    /// (Switches of the equations, as those of `if t > 50 { … }`, are always seen.)
    ///
    /// ```
    /// use lagrange_runtime::prelude::*;
    /// lagrangian! {
    ///     system Gust {
    ///         coord x;
    ///         T = 0.5 * dot(x).powi(2);
    ///         V = 0.5 * x.powi(2);
    ///         Q[x] = exp(-(100 * (t - 50)).powi(2));
    ///     }
    /// }
    /// let (gust, start) = (Gust::new(), State::new(0.0, [0.0], [0.0]));
    /// let end = integrate(&gust, Dop853, PiController::tolerance(1e-9).max_step(0.01), start).until(51.0).final_state()?;
    /// // An impulse of √π/100, half a second before.
    /// let impulse = core::f64::consts::PI.sqrt() / 100.0;
    /// assert!((end.q[0] - impulse * 1f64.sin()).abs() < 1e-6);
    /// # Ok::<(), Box<dyn core::error::Error>>(())
    /// ```
    pub const fn max_step(self, h: f64) -> Self {
        PiController { longest: h, ..self }
    }

    /// Keeps the ratio of successive steps between `smallest`, itself kept within [0.01, 0.9], and `largest`, at
    /// least 1.
    pub const fn factors(self, smallest: f64, largest: f64) -> Self {
        let largest = largest.max(1.0);
        PiController { smallest: smallest.max(0.01).min(0.9), largest, most: largest, ..self }
    }

    /// Sets the exponent `β = beta/p` of the error before, `beta` itself kept within [0, 1]; 0 gives the elementary
    /// controller, as in `dop853`.
    pub const fn beta(self, beta: f64) -> Self {
        PiController { beta: beta.max(0.0).min(1.0), ..self }
    }
}

/// Norms, of one trajectory (`R` is `f64`) or of lanes. `value` makes an `R` of a component.
impl<A> PiController<A> {
    /// The norm for a step from `a` to `b`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn weighted<S: Scalar, R: Scalar, V: Fn(S) -> R, const N: usize>(
        &self,
        value: V,
        a: &State<S, N>,
        b: &State<S, N>,
    ) -> Weighted<R, V, N>
    where
        A: AbsoluteTolerance<N>,
    {
        let mut weights = [[R::one(); N]; 2];
        for i in 0..N {
            weights[0][i] = self.weight(self.absolute.q(i), value(a.q[i]), value(b.q[i]));
            weights[1][i] = self.weight(self.absolute.qd(i), value(a.qd[i]), value(b.qd[i]));
        }
        Weighted { weights, value, eighth_by_third: self.eighth_by_third }
    }

    /// 1/scᵢ.
    #[inline(always)]
    fn weight<R: Scalar>(&self, absolute: f64, a: R, b: R) -> R {
        let (a, b) = (a.abs(), b.abs());
        // `f64::max` would take three instructions more to look for NaN.
        let larger = R::select(Comparison::Less, b, a, a, b);
        R::one() / (R::from_f64(absolute) + R::from_f64(self.relative) * larger)
    }

    /// Its tolerances and norm: itself, where a [`PidController`] has one.
    #[inline(always)]
    pub(crate) fn tolerances(&self) -> &Self {
        self
    }

    /// The square of an error in the norm.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn square<S: Scalar, R: Scalar, E: ErrorEstimate<S, N>, const N: usize>(
        &self,
        value: impl Fn(S) -> R,
        from: &State<S, N>,
        to: &State<S, N>,
        error: &E,
    ) -> R
    where
        A: AbsoluteTolerance<N>,
    {
        error.square(&self.weighted(value, from, to))
    }

    /// Verdicts from the squares of errors of steps side by side, each of which has a controller made from the same.
    /// Those that are not `judged` leave no trace. Without branches: lanes are decided about all at once.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn decide<const L: usize>(
        lanes: &mut [Self; L],
        squares: &[f64; L],
        judged: &[bool; L],
        order: u32,
    ) -> Verdicts<L> {
        let PiController { safety, beta, smallest, largest, .. } = lanes[0];
        // Halved, since they stand above squares.
        let beta = 0.5 * beta / f64::from(order);
        let alpha = 0.5 / f64::from(order) - 0.75 * beta;
        let (mut before, mut most) = ([0.0; L], [0.0; L]);
        for l in 0..L {
            (before[l], most[l]) = (lanes[l].before, lanes[l].most);
        }
        let (mut accepted, mut factor) = ([false; L], [0.0; L]);
        // One loop over numbers: the optimiser takes shorter ones apart.
        for l in 0..L {
            let square = squares[l];
            let log = log2(square);
            let good = square <= 1.0;
            let past = if good { before[l] } else { 0.0 };
            let longer = safety * exp2(beta * past - alpha * log);
            let kept = within(smallest, if good { most[l] } else { safety }, longer);
            // What is not finite has no logarithm.
            factor[l] = if square < f64::INFINITY { kept } else { smallest };
            accepted[l] = good;
            let log = if log > LEAST_LOG { log } else { LEAST_LOG };
            before[l] = if good & judged[l] { log } else { before[l] };
            let next = if good { largest } else { 1.0 };
            most[l] = if judged[l] { next } else { most[l] };
        }
        for l in 0..L {
            (lanes[l].before, lanes[l].most) = (before[l], most[l]);
        }
        Verdicts { accepted, factor }
    }
}

/// `Σ (wᵢ eᵢ)² / 2N`.
struct Weighted<R, V, const N: usize> {
    weights: [[R; N]; 2],
    value: V,
    eighth_by_third: f64,
}

impl<S: Scalar, R: Scalar, V: Fn(S) -> R, const N: usize> SquareNorm<S, R, N> for Weighted<R, V, N> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn of(&self, e: &Tangent<S, N>) -> R {
        // Two sums, so that fewer additions wait for each other.
        let mut sums = [R::zero(); 2];
        for i in 0..N {
            let q = (self.value)(e.q[i]) * self.weights[0][i];
            let qd = (self.value)(e.qd[i]) * self.weights[1][i];
            sums[i % 2] += q * q + qd * qd;
        }
        (sums[0] + sums[1]) * R::from_f64(0.5 / N as f64)
    }

    #[inline(always)]
    fn eighth_by_third(&self) -> f64 {
        self.eighth_by_third
    }
}

impl<S, A, E, const N: usize> Controller<S, N, E> for PiController<A>
where
    S: Real,
    A: AbsoluteTolerance<N>,
    E: ErrorEstimate<S, N>,
{
    const EQUAL_STEPS: Option<bool> = Some(false);

    fn first_step(&self) -> FirstStep<S> {
        self.first.map_or(FirstStep::Automatic, |h| FirstStep::Given(S::from_f64(h)))
    }

    fn with_first_step(&self, h: f64) -> Option<Self> {
        Some(PiController::first_step(*self, h))
    }

    fn check(&self) -> Result<(), Failure<S>> {
        sensible(&self.absolute, self.relative)?;
        match self.first {
            Some(h) if !h.is_finite() || h == 0.0 => Err(Failure::BadStepSize { h: S::from_f64(h) }),
            _ => bounded(self.longest),
        }
    }

    #[inline(always)]
    fn max_step(&self) -> f64 {
        self.longest
    }

    fn norm(&self, difference: &Tangent<S, N>, a: &State<S, N>, b: &State<S, N>) -> f64 {
        Functions::sqrt(self.weighted(S::to_f64, a, b).of(difference))
    }

    #[inline(always)]
    fn judge(&mut self, from: &State<S, N>, to: &State<S, N>, error: &E, order: u32) -> Verdict {
        let square = self.square(S::to_f64, from, to, error);
        PiController::decide(core::array::from_mut(self), &[square], &[true], order).only()
    }

    fn after_failure(&mut self) -> Option<f64> {
        self.most = 1.0;
        Some(self.smallest)
    }
}

/// `x`, or the limit that it is beyond.
#[inline]
fn within(low: f64, high: f64, x: f64) -> f64 {
    if x < low {
        low
    } else if x > high {
        high
    } else {
        x
    }
}

/// log₂ x of a positive number, to 0.01; far below 0 for 0.
///
/// All evaluations of the next step wait for its size, so the way from the error to it is short: the powers of errors
/// need few digits, and this pair of functions gives the size of the step to 0.1 % in half the time of `ln` and `exp`.
#[inline]
pub(crate) const fn log2(x: f64) -> f64 {
    // The exponent, as the last digits of a number whose own is 52: no conversion of integers, which not all vectors
    // have.
    const INTEGER: f64 = (1u64 << 52) as f64;
    let exponent = f64::from_bits(x.to_bits() >> 52 | INTEGER.to_bits()) - (INTEGER + 1023.0);
    let mantissa = f64::from_bits(x.to_bits() & (INTEGER as u64 - 1) | 1.0f64.to_bits());
    let beyond = mantissa - 1.0;
    (exponent + beyond) + beyond * (1.0 / 3.0) * (2.0 - mantissa)
}

/// 2ˣ to 0.02 %, for |x| < 1000.
#[inline]
pub(crate) const fn exp2(x: f64) -> f64 {
    // Added to a number, it leaves the nearest integer in the last bits.
    const ROUND: f64 = 1.5 * (1u64 << 52) as f64;
    let shifted = x + ROUND;
    let rest = x - (shifted - ROUND);
    let fraction = (1.0 + rest * 0.6933) + rest * rest * (0.2423 + rest * 0.055);
    f64::from_bits(fraction.to_bits().wrapping_add(shifted.to_bits() << 52))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrate::{Statistics, integrate};
    use crate::method::Method;
    use crate::method::explicit_rk::{Dop853, DormandPrince5};
    use crate::testing::bank::*;
    use crate::testing::distance;

    type Judge = fn(&mut PiController, f64) -> Verdict;

    /// The verdict on a step of a method of order 5 whose error is `size` times the tolerance.
    const JUDGE: Judge = |pi, size| {
        let at = State::new(0.0, [0.0], [0.0]);
        let error = Tangent { q: [size * 1e-6].into(), qd: [size * 1e-6].into() };
        Controller::<f64, 1, _>::judge(pi, &at, &at, &error, 5)
    };

    #[test]
    fn small_errors_lengthen_and_large_ones_shorten() {
        let mut pi = PiController::tolerance(1e-6).rtol(0.0);
        assert_eq!(JUDGE(&mut pi, 0.0), Verdict::Accept { factor: 10.0 });
        assert!(matches!(JUDGE(&mut pi, 0.9), Verdict::Accept { factor } if factor < 1.0));
        assert!(matches!(JUDGE(&mut pi, 1.1), Verdict::Reject { factor } if factor > 0.8 && factor < 0.9));
        // No growth right after a rejection, but again after that.
        assert_eq!(JUDGE(&mut pi, 1e-9), Verdict::Accept { factor: 1.0 });
        assert!(matches!(JUDGE(&mut pi, 1e-9), Verdict::Accept { factor } if factor > 5.0));
        for bad in [f64::NAN, f64::INFINITY, 1e300] {
            assert_eq!(JUDGE(&mut pi, bad), Verdict::Reject { factor: 0.2 });
        }
    }

    #[test]
    fn short_powers_are_good_to_a_thousandth() {
        let mut x = 1e-300;
        while x < 1e300 {
            assert!((log2(x) - Functions::ln(x) / core::f64::consts::LN_2).abs() < 0.01, "{x}");
            // The exponents of order 5 and 8.
            for p in [-0.085, -0.053] {
                assert!((exp2(p * log2(x)) / Functions::powf(x, p) - 1.0).abs() < 1e-3, "{x} {p}");
            }
            x *= 1.01;
        }
        let mut x = -990.0;
        while x < 990.0 {
            assert!((exp2(x) / Functions::powf(2.0, x) - 1.0).abs() < 2e-4, "{x}");
            x += 0.01;
        }
        assert!(log2(0.0) < -1000.0);
    }

    #[test]
    fn the_norm_is_the_root_mean_square_over_tolerances() {
        let pi = PiController::tolerance(1e-2).atol(1e-3);
        let (a, b) = (State::new(0.0, [1.0], [0.0]), State::new(0.0, [-2.0], [0.0]));
        let e = Tangent { q: [0.021].into(), qd: [0.003].into() };
        let norm = Controller::<f64, 1, Tangent<f64, 1>>::norm(&pi, &e, &a, &b);
        assert!((norm - 5f64.sqrt()).abs() < 1e-14);
    }

    #[test]
    fn two_estimates_are_combined() {
        let unit = |x: f64| Tangent { q: [x].into(), qd: [0.0].into() };
        let both = TwoEstimates { fifth: unit(0.3), third: unit(4.0) };
        struct Position;
        impl SquareNorm<f64, f64, 1> for Position {
            fn of(&self, e: &Tangent<f64, 1>) -> f64 {
                e.q[0] * e.q[0]
            }

            fn eighth_by_third(&self) -> f64 {
                1e-6
            }
        }
        assert!((both.square(&Position) - 0.09 * 0.09 / (0.09 + 0.16)).abs() < 1e-15);
        let square = |fifth, third| TwoEstimates { fifth: unit(fifth), third: unit(third) }.square(&Position);
        assert_eq!(square(0.0, 0.0), 0.0);
        assert!((square(0.0, 1e3) - 1.0).abs() < 1e-15);
        assert!(square(f64::NAN, 1.0).is_nan() && square(f64::INFINITY, 1.0).is_nan());
    }

    /// In steps that begin slowly near the top, the estimate of order 5 changes its sign where the error is a hundred
    /// times the tolerance and more.
    #[test]
    fn a_zero_of_an_estimate_is_no_small_error() {
        let system = Pendulum { g: 11.772, ..Pendulum::default() };
        let start = State::new(0.0, [core::f64::consts::PI], [-1.0]);
        let energy = |at: &State<f64, 1>| 0.5 * at.qd[0] * at.qd[0] - system.g * at.q[0].cos();
        for k in 0..200 {
            let tolerance = Functions::powf(10.0, -6.0 - 0.01 * f64::from(k));
            for step in integrate(&system, Dop853, PiController::tolerance(tolerance), start).until(10.0) {
                let step = step.unwrap();
                let lost = (energy(&step.to) - energy(&step.from)).abs();
                assert!(
                    lost < 500.0 * tolerance,
                    "{tolerance:e}: {lost:e} in {} s from {}",
                    step.h,
                    step.from.t
                );
            }
        }
    }

    fn error(method: impl Method<Plane, 2, Error: ErrorEstimate<f64, 2>>, tolerance: f64, end: f64) -> f64 {
        let system = Plane::default();
        distance(
            &integrate(&system, method, PiController::tolerance(tolerance), ELLIPSE)
                .until(end)
                .final_state()
                .unwrap(),
            &ellipse(end),
        )
    }

    /// Over a few steps the global error is about the tolerance; over ten turns it follows the tolerance.
    #[test]
    fn the_tolerance_is_achieved() {
        for tolerance in [1e-6, 1e-8, 1e-10, 1e-12] {
            let errors = [error(DormandPrince5, tolerance, 1.0), error(Dop853, tolerance, 1.0)];
            assert!(
                errors.iter().all(|e| (0.01..10.0).contains(&(e / tolerance))),
                "{tolerance:e} {errors:?}"
            );
            let long = 20.0 * core::f64::consts::PI;
            let five = error(DormandPrince5, tolerance, long) / error(DormandPrince5, 0.01 * tolerance, long);
            let eight = error(Dop853, tolerance, long) / error(Dop853, 0.01 * tolerance, long);
            // A hundredth of the tolerance takes at least a twentieth of the error.
            assert!(tolerance < 1e-9 || (five > 20.0 && eight > 20.0), "{five} {eight}");
        }
    }

    /// In line with scipy 1.17, whose `DOP853` makes 419 steps and 134 rejections here.
    #[test]
    fn steps_and_rejections_are_those_of_other_codes() {
        let system = DoublePendulum::default();
        let mut run = integrate(&system, Dop853, PiController::tolerance(1e-9).beta(0.0), DOUBLE).until(50.0);
        run.run_to_end().unwrap();
        let Statistics { accepted, rejected, evaluations } = run.statistics();
        assert!(accepted.abs_diff(419) < 5 && rejected < 134, "{accepted} {rejected}");
        assert_eq!(evaluations, 3 + 12 * (accepted + rejected));
        let mut run = integrate(&system, DormandPrince5, PiController::tolerance(1e-9), DOUBLE).until(50.0);
        run.run_to_end().unwrap();
        assert!(run.statistics().rejected * 100 < run.statistics().accepted);
    }
}
