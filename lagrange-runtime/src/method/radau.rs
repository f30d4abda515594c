//! Radau IIA of order 5 for stiff systems: implicit, L-stable, stiffly accurate.
//!
//! With three stages at `c = ((4 − √6)/10, (4 + √6)/10, 1)`, the increments `zᵢ = h Σⱼ aᵢⱼ f(y₀ + zⱼ)` of y = (q, q̇)
//! are found by a simplified Newton iteration. In the variables `w = T⁻¹z` that bring `A⁻¹` to the form
//! `diag(γ, (α, −β; β, α))` it falls into one real and one complex system (Hairer, Wanner, *Solving Ordinary
//! Differential Equations II*, 1996, IV.8), each of which has only N unknowns, since half of the equations say
//! `q̇ = v`.
//!
//! The iteration ends when its remaining error, `θ/(1 − θ)` times the last change (θ: rate of convergence), is far
//! below the estimated error of the step, as far as the true error of order 5 is below the estimate of order 3.
//! So no tolerance has to be known here, and at fixed steps the order is kept.

#![allow(clippy::excessive_precision)]

use super::newton::{
    Linearized, ROUNDING, Resolvent, accelerations, diverged, larger, largest, relative, unsolvable,
};
use super::steps_across;
use super::{Interpolant, Method, Step};
use crate::controller::{ErrorEstimate, SquareNorm};
use crate::failure::Failure;
use crate::iteration::{Iteration, Progress, chosen};
use crate::lanes::lanewise;
use crate::linear::Complex;
use crate::scalar::double_double::digits::{exact, exact_row};
use crate::scalar::{Comparison, DoubleDouble, Functions, Real, Scalar, SimdScalar};
use crate::state::{State, Tangent, add_scaled};
use crate::system::{Jacobian, Lagrangian};
use nalgebra::SVector;
use refined::{Place, Refined};

mod refined;

/// Iterations after which a step fails; those worth waiting for need 2 to 8.
const MOST_ITERATIONS: u32 = 15;

const SQRT6: f64 = 2.449489742783178;

/// The nodes.
const C: [DoubleDouble; 3] = exact_row![
    (4.0 - SQRT6) / 10.0 => 0.155051025721682190180271592529410861,
    (4.0 + SQRT6) / 10.0 => 0.644948974278317809819728407470589139,
    1.0,
];

/// `1/γ = (6 + ∛81 − ∛9)/30` and `1/(α ± iβ) = (12 − ∛81 + ∛9)/60 ∓ i(∛81 + ∛9)√3/60` are the eigenvalues of A.
const GAMMA: DoubleDouble = exact!(3.6378342527444957322084185135777758);
const ALPHA: DoubleDouble = exact!(2.681082873627752 => 2.6810828736277521338957907432111121);
const BETA: DoubleDouble = exact!(3.0504301992474105694263776247875679);

/// The matrix T of Hairer and Wanner 1996, IV.8, eq. 8.13 and of their code `RADAU5`, and its inverse.
const T: [[DoubleDouble; 3]; 3] = [
    exact_row![
        0.0912323948708929427915481352494361961,
        -0.141255295020954208427990383807797309,
        -0.0300291941051474244918611170890538667
    ],
    exact_row![
        0.241717932707107018957474779310148233,
        0.204129352293799931995990810298338174,
        0.38294211275726193779543823359987321
    ],
    exact_row![0.966048182615092936190567080794590795, 1.0, 0.0],
];
const T_INVERSE: [[DoubleDouble; 3]; 3] = [
    exact_row![
        4.32557989006315535102435095295614883,
        0.339199251815809869542824974053410988,
        0.541770539935874871186523033492089632
    ],
    exact_row![
        -4.17871859155190472734646265851205623,
        -0.327682820761062387082533272429616234,
        0.476623554500550451960069084091012498
    ],
    exact_row![
        -0.502872634945786875951247343139544293,
        2.57192694985560542918678535360167505,
        -0.596039204828224924968821911099302403
    ],
];

/// Coefficients of the error estimate, over h (eq. 8.18 and 8.19 with γ₀ = 1/γ).
const E: [DoubleDouble; 3] = exact_row![
    -(13.0 + 7.0 * SQRT6) / 3.0 => -10.0488093998274155624603295076470799,
    (-13.0 + 7.0 * SQRT6) / 3.0 => 1.38214273316074889579366284098041325,
    -1.0 / 3.0,
];

/// Radau IIA of order 5 (Ehle 1969; Hairer and Wanner 1996, IV.8): collocation at three nodes, L-stable, for stiff
/// systems and high accuracy. Samples and events within a step take another step of half the size, once for all of
/// them: the collocation polynomial alone is of order 3 in q̇ and of order 4 in q. [Errors within
/// steps](crate::method#errors-within-steps) are those at their ends.
///
/// # Hypotheses
/// - Accelerations are smooth within a step. Adaptive runs end steps at the switches that the compiler knows; steps
///   of one size go over them, with an error of order h where forces jump and h² where they have a kink.
/// - Forces act for a step at least, see [forces that set in later](crate::method#forces-that-set-in-later).
/// - M is regular along the motion: otherwise [`Failure::SingularInertia`].
/// - Constraints stay independent: otherwise [`Failure::DependentConstraints`].
/// - Forces have derivatives: otherwise [`Failure::NoDerivative`].
///
/// A step whose iteration does not converge fails with [`Failure::NotConverged`], and a controller then tries a shorter
/// one. The Jacobian, evaluated once in a step, counts as one evaluation.
///
/// ```
/// use lagrange_runtime::prelude::*;
/// lagrangian! {
///     /// A very stiff damper beside a spring.
///     system Overdamped {
///         param c, k;
///         coord x;
///         T = 0.5 * dot(x).powi(2);
///         V = 0.5 * k * x.powi(2);
///         D = 0.5 * c * dot(x).powi(2);
///     }
/// }
/// let system = Overdamped::new(1e8, 1e8);
/// let start = State::new(0.0, [1.0], [0.0]);
/// let mut run = integrate(&system, Radau5, PiController::tolerance(1e-8), start).until(2.0);
/// run.run_to_end()?;
/// assert!((run.state().q[0] - (-2.0f64).exp()).abs() < 1e-7 && run.statistics().accepted < 200);
/// # Ok::<(), Failure>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Radau5;

/// The difference to an embedded formula of order 3, filtered by `(γ/h − J)⁻¹` (Hairer and Wanner 1996, IV.8, eq.
/// 8.20). It behaves as h⁴ where the error of the method is h⁶, so its size is the norm's power of 5/4: as h⁵, in
/// line with what a controller expects of order 5, and 1 where the norm is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RadauEstimate<S, const N: usize> {
    /// The filtered difference.
    pub difference: Tangent<S, N>,
}

lanewise! { RadauEstimate<N> { difference } }

impl<S: Scalar, const N: usize> ErrorEstimate<S, N> for RadauEstimate<S, N> {
    #[inline(always)]
    fn square<R: Scalar>(&self, norm: &impl SquareNorm<S, R, N>) -> R {
        // Roots, which are rounded alike everywhere, and not a power, which is not.
        let square = norm.of(&self.difference);
        square * square.sqrt().sqrt()
    }
}

impl<Sys: Lagrangian<N>, const N: usize> Method<Sys, N> for Radau5
where
    Sys::Scalar: SimdScalar,
{
    /// The collocation polynomial of the step before, from which the next stages are guessed; at the start one of
    /// size 0, or with the accelerations there.
    type MethodState = Collocation<Sys::Scalar, N>;
    /// The collocation polynomial of the step.
    type InterpolantData = Collocation<Sys::Scalar, N>;
    type Error = RadauEstimate<Sys::Scalar, N>;
    type Interpolant = Refined<Sys::Scalar, N>;

    fn order(&self) -> u32 {
        5
    }

    fn implicit(&self) -> bool {
        true
    }

    fn start(
        &self,
        system: &Sys,
        at: &State<Sys::Scalar, N>,
    ) -> Result<Self::MethodState, Failure<Sys::Scalar>> {
        let rate = Tangent { q: at.qd, qd: accelerations(system, at)? };
        // Where the motion may begin on a switch, the guess leads off it.
        let h = Sys::Scalar::from_f64(if Sys::SWITCHES > 0 { 1.0 } else { 0.0 });
        let increments = C.map(|c| Tangent::zero().plus_scaled(c.to::<Sys::Scalar>() * h, &rate));
        Ok(Collocation::new(at, h, &increments))
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn step_into(
        &self,
        system: &Sys,
        memory: &Self::MethodState,
        from: &State<Sys::Scalar, N>,
        h: Sys::Scalar,
        next: &mut Self::MethodState,
    ) -> Result<Step<Sys, Self, N>, Failure<Sys::Scalar>> {
        let jacobian = Sys::Scalar::evaluate(Linearized { system, at: from });
        let equations = Equations::new(system, from, h, &jacobian)?;
        let (z, difference, iterations) = equations.solve(memory.guess(h))?;
        let to = from.moved(from.t + h, Sys::Scalar::one(), &z[2]);
        *next = Collocation::new(from, h, &z);
        let evaluations = 3 + 3 * iterations;
        Ok(Step { from: *from, to, h, error: RadauEstimate { difference }, stages: *next, evaluations })
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn interpolant(&self, system: &Sys, step: &Step<Sys, Self, N>) -> Self::Interpolant {
        let Step { from, h, stages: whole, .. } = step;
        let [middle, end] = [0.5, 1.0].map(|theta| place(whole, theta, 1.0));
        let (half, evaluations) = halfway(system, from, *h, whole);
        let middle = half.map_or(middle, |half| place(&half, 1.0, 0.5).or(&middle));
        Refined::new(from, *h, [&middle, &end], evaluations)
    }

    /// The collocation polynomial itself.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn coarse_interpolant(&self, _: &Sys, step: &Step<Sys, Self, N>) -> Option<Self::Interpolant> {
        let [middle, end] = [0.5, 1.0].map(|theta| place(&step.stages, theta, 1.0));
        Some(Refined::new(&step.from, step.h, [&middle, &end], 0))
    }

    steps_across! {}

    fn interpolant_evaluations(&self, dense: &Self::Interpolant) -> u32 {
        dense.evaluations()
    }
}

/// State at θ by a collocation polynomial over `part` of a step.
#[cfg_attr(not(debug_assertions), inline(always))]
fn place<S: Scalar, const N: usize>(polynomial: &Collocation<S, N>, theta: f64, part: f64) -> Place<S, N> {
    let theta = S::from_f64(theta);
    Place::new(polynomial.increment(theta), &polynomial.v, theta, part)
}

/// A step of half the size, its stages guessed by the polynomial of the whole one, unless its iteration fails, and
/// the evaluations made.
#[cfg_attr(not(debug_assertions), inline(always))]
fn halfway<Sys: Lagrangian<N>, const N: usize>(
    system: &Sys,
    from: &State<Sys::Scalar, N>,
    h: Sys::Scalar,
    whole: &Collocation<Sys::Scalar, N>,
) -> (Option<Collocation<Sys::Scalar, N>>, u32)
where
    Sys::Scalar: SimdScalar,
{
    let half = Sys::Scalar::from_f64(0.5);
    let mut guess = [Tangent::zero(); 3];
    for (guess, c) in guess.iter_mut().zip(C) {
        *guess = whole.increment(half * c.to());
    }
    let h = h * half;
    let jacobian = Sys::Scalar::evaluate(Linearized { system, at: from });
    match Equations::new(system, from, h, &jacobian).and_then(|equations| equations.solve(guess)) {
        Ok((z, _, iterations)) => (Some(Collocation::new(from, h, &z)), 3 + 3 * iterations),
        Err(Failure::NotConverged { iterations, .. }) => (None, 2 + 3 * iterations),
        Err(_) => (None, 2),
    }
}

/// The equations of one step.
struct Equations<'a, Sys: Lagrangian<N>, const N: usize> {
    system: &'a Sys,
    from: &'a State<Sys::Scalar, N>,
    h: Sys::Scalar,
    rate: Tangent<Sys::Scalar, N>,
    real: Resolvent<Sys::Scalar, Sys::Scalar, N>,
    complex: Resolvent<Sys::Scalar, Complex<Sys::Scalar>, N>,
}

/// The increments at the stages, the estimated error, and the number of iterations.
type Solution<S, const N: usize> = ([Tangent<S, N>; 3], Tangent<S, N>, u32);

impl<'a, Sys: Lagrangian<N>, const N: usize> Equations<'a, Sys, N>
where
    Sys::Scalar: SimdScalar,
{
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn new(
        system: &'a Sys,
        from: &'a State<Sys::Scalar, N>,
        h: Sys::Scalar,
        jacobian: &Jacobian<Sys::Scalar, N>,
    ) -> Result<Self, Failure<Sys::Scalar>> {
        let over_h = |x: DoubleDouble| x.to::<Sys::Scalar>() / h;
        let lambda = Complex { re: over_h(ALPHA), im: over_h(BETA) };
        let unsolvable = |singular| unsolvable(system, from, h, jacobian, singular);
        Ok(Equations {
            system,
            from,
            h,
            rate: rate(system, from),
            real: Resolvent::new(over_h(GAMMA), jacobian).map_err(unsolvable)?,
            complex: Resolvent::new(lambda, jacobian).map_err(unsolvable)?,
        })
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn solve(
        &self,
        mut z: [Tangent<Sys::Scalar, N>; 3],
    ) -> Result<Solution<Sys::Scalar, N>, Failure<Sys::Scalar>> {
        let Equations { system, from, h, .. } = *self;
        let epsilon = <Sys::Scalar as SimdScalar>::Element::EPSILON;
        let mut last = Sys::Scalar::each(|_| f64::INFINITY);
        let mut iteration = Iteration::<Sys::Scalar>::new();
        let (mut error, mut sum) = (Tangent::zero(), Tangent::zero());
        let (mut iterations, mut finite) = (0, true);
        while iteration.goes_on() {
            let change = self.improve(&mut z, &iteration);
            iterations += 1;
            (error, sum) = self.error(&z);
            let scale = self.scale(&z);
            let [a, b, c] = &change;
            let size = relative(a, scale) + relative(b, scale) + relative(c, scale);
            let [sizes, estimates] = [size.apart(), relative(&error, scale).apart()];
            iteration.decide(|i| {
                let [size, estimate] = [&sizes, &estimates].map(|x| x.as_ref()[i].to_f64());
                if !size.is_finite() {
                    finite = false;
                    return Progress::Failed;
                }
                // The first change says nothing about the rate of convergence.
                let theta = if iterations == 1 { 0.5 } else { size / last.as_ref()[i] };
                let rounded =
                    size <= 8.0 * epsilon || (theta >= 0.5 && size < ROUNDING * epsilon && iterations > 1);
                if theta >= 0.99 && !rounded {
                    return Progress::Failed;
                }
                last.as_mut()[i] = size;
                let enough = 0.03 * estimate * Functions::sqrt(estimate).min(1.0);
                let converged = iterations > 1 && size * theta / (1.0 - theta) <= enough;
                if rounded || converged { Progress::Done } else { Progress::On }
            });
            if iterations == MOST_ITERATIONS {
                iteration.give_up();
            }
            if iteration.failed() {
                return Err(match finite {
                    true => Failure::NotConverged { t: from.t, h, iterations },
                    false => diverged(system, from, h, iterations),
                });
            }
        }
        z[2].qd = iteration.result(&z[2].qd);
        Ok((z, self.refined(&error, &sum), iterations))
    }

    /// One iteration, which changes the places that it goes on for: `(h⁻¹Λ − J) Δw = T⁻¹F(z) − h⁻¹Λ w`. Gives the
    /// change of z.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn improve(
        &self,
        z: &mut [Tangent<Sys::Scalar, N>; 3],
        iteration: &Iteration<Sys::Scalar>,
    ) -> [Tangent<Sys::Scalar, N>; 3] {
        let mut stages = *z;
        for i in 0..3 {
            let t = self.from.t + self.h * C[i].to();
            stages[i] = rate(self.system, &self.from.moved(t, Sys::Scalar::one(), &z[i]));
        }
        let [f, w] = [transform(&T_INVERSE, &stages), transform(&T_INVERSE, z)];
        let [gamma, alpha, beta] = [GAMMA, ALPHA, BETA].map(|x| x.to::<Sys::Scalar>() / self.h);
        let first = self.real.apply(&f[0].plus_scaled(-gamma, &w[0]));
        let re = f[1].plus_scaled(-alpha, &w[1]).plus_scaled(beta, &w[2]);
        let im = f[2].plus_scaled(-beta, &w[1]).plus_scaled(-alpha, &w[2]);
        let zero = Complex { re: Sys::Scalar::zero(), im: Sys::Scalar::zero() };
        let (mut q, mut qd) = (SVector::from([zero; N]), SVector::from([zero; N]));
        for i in 0..N {
            q[i] = Complex { re: re.q[i], im: im.q[i] };
            qd[i] = Complex { re: re.qd[i], im: im.qd[i] };
        }
        let (q, qd) = self.complex.solve(&q, &qd);
        let [mut second, mut third] = [re, im];
        for i in 0..N {
            (second.q[i], second.qd[i]) = (q[i].re, qd[i].re);
            (third.q[i], third.qd[i]) = (q[i].im, qd[i].im);
        }
        let change = transform(&T, &[first, second, third]);
        for (z, change) in z.iter_mut().zip(&change) {
            let next = z.plus_scaled(Sys::Scalar::one(), change);
            z.q = chosen(iteration.on(), &next.q, &z.q);
            z.qd = chosen(iteration.on(), &next.qd, &z.qd);
        }
        change
    }

    /// The sizes of the variables during the step, of q and of q̇.
    #[inline(always)]
    fn scale(&self, [a, b, c]: &[Tangent<Sys::Scalar, N>; 3]) -> [<Sys::Scalar as SimdScalar>::Sizes; 2] {
        [
            largest(&self.from.q) + larger(largest(&a.q), larger(largest(&b.q), largest(&c.q))),
            largest(&self.from.qd) + larger(largest(&a.qd), larger(largest(&b.qd), largest(&c.qd))),
        ]
    }

    /// `(γ/h − J)⁻¹ (f(y₀) + Σ eᵢ zᵢ/h)`, and the sum in it.
    #[inline(always)]
    fn error(&self, z: &[Tangent<Sys::Scalar, N>; 3]) -> (Tangent<Sys::Scalar, N>, Tangent<Sys::Scalar, N>) {
        let mut sum = Tangent::zero();
        for (z, e) in z.iter().zip(E) {
            sum = sum.plus_scaled(e.to::<Sys::Scalar>() / self.h, z);
        }
        (self.real.apply(&self.rate.plus_scaled(Sys::Scalar::one(), &sum)), sum)
    }

    /// The same with `f(y₀ + error)` for `f(y₀)`: right also where what is stiff is far from its slow solution, and
    /// worth one evaluation.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn refined(
        &self,
        error: &Tangent<Sys::Scalar, N>,
        sum: &Tangent<Sys::Scalar, N>,
    ) -> Tangent<Sys::Scalar, N> {
        let moved = self.from.moved(self.from.t, Sys::Scalar::one(), error);
        self.real.apply(&rate(self.system, &moved).plus_scaled(Sys::Scalar::one(), sum))
    }
}

/// `(q̇, q̈)`.
#[inline(always)]
fn rate<Sys: Lagrangian<N>, const N: usize>(
    system: &Sys,
    at: &State<Sys::Scalar, N>,
) -> Tangent<Sys::Scalar, N> {
    Tangent { q: at.qd, qd: system.accel(&at.q, &at.qd, at.t) }
}

#[cfg_attr(not(debug_assertions), inline(always))]
fn transform<S: Scalar, const N: usize>(
    m: &[[DoubleDouble; 3]; 3],
    x: &[Tangent<S, N>; 3],
) -> [Tangent<S, N>; 3] {
    let mut sums = [Tangent::zero(); 3];
    for (sum, row) in sums.iter_mut().zip(m) {
        for (m, x) in row.iter().zip(x) {
            *sum = sum.plus_scaled(m.to(), x);
        }
    }
    sums
}

/// Sizes of a step beyond its end to which its polynomial is extrapolated; more than controllers let the next one be
/// longer.
const FARTHEST: f64 = 16.0;

/// The collocation polynomial: of degree 3 in θ for q̇, through the start and the three stages, and its integral for q,
/// which meets the end exactly, since the quadrature of the method is exact for degree 4.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(bound(
        serialize = "S: crate::Scalar + serde::Serialize",
        deserialize = "S: crate::Scalar + serde::Deserialize<'de>"
    ))
)]
pub struct Collocation<S, const N: usize> {
    from: State<S, N>,
    h: S,
    /// `q̇ = q̇₀ + θ(v₁ + θ(v₂ + θ v₃))`.
    v: [SVector<S, N>; 3],
}

lanewise! { Collocation<N> { from, h, v } }

impl<S: Scalar, const N: usize> Collocation<S, N> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn new(from: &State<S, N>, h: S, z: &[Tangent<S, N>; 3]) -> Self {
        // Newton's divided differences over 0, c₁, c₂, 1, then expanded in powers of θ.
        let d1 = z[0].qd * exact!(1.0 / C[0].hi => 6.44948974278317809819728407470589139).to();
        let d12 = (z[1].qd - z[0].qd)
            * exact!(1.0 / (C[1].hi - C[0].hi) => 2.04124145231931508183107006225490949).to();
        let d23 = (z[2].qd - z[1].qd)
            * exact!(1.0 / (C[2].hi - C[1].hi) => 2.8164965809277260327324280249019638).to();
        let d2 = (d12 - d1) * exact!(1.0 / C[1].hi => 1.55051025721682190180271592529410861).to();
        let d3 =
            (d23 - d12) * exact!(1.0 / (C[2].hi - C[0].hi) => 1.1835034190722739672675719750980362).to() - d2;
        let v2 = d2 - d3 * exact!(C[0].hi + C[1].hi => 0.8).to();
        let v1 = d1 - d2 * C[0].to() + d3 * exact!(C[0].hi * C[1].hi => 0.1).to();
        Collocation { from: *from, h, v: [v1, v2, d3] }
    }

    /// The increments of q and q̇ from the start to θ.
    #[inline(always)]
    fn increment(&self, theta: S) -> Tangent<S, N> {
        let q = (self.from.qd + self.sum(theta, exact_row![0.5, 1.0 / 3.0, 0.25])) * (self.h * theta);
        Tangent { q, qd: self.sum(theta, [DoubleDouble::ONE; 3]) }
    }

    /// `θ(a v₁ + θ(b v₂ + θ c v₃))`.
    #[inline(always)]
    fn sum(&self, theta: S, [a, b, c]: [DoubleDouble; 3]) -> SVector<S, N> {
        let [v1, v2, v3] = &self.v;
        let tail = add_scaled(&(v2 * b.to()), theta, &(v3 * c.to()));
        add_scaled(&(v1 * a.to()), theta, &tail) * theta
    }

    /// The increments at the stages of the next step of size `h`, by extrapolation; none after a step of size 0, or
    /// one much shorter, such as that across a switch: a polynomial of degree 4 means nothing that far beyond it.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn guess(&self, h: S) -> [Tangent<S, N>; 3] {
        let end = self.increment(S::one());
        let ratio = h / self.h;
        let ratio = S::select(Comparison::Less, ratio.abs(), S::from_f64(FARTHEST), ratio, S::zero());
        let mut guess = [end; 3];
        for (guess, c) in guess.iter_mut().zip(C) {
            let there = self.increment(S::one() + c.to::<S>() * ratio);
            *guess = there.plus_scaled(-S::one(), &end);
        }
        guess
    }
}

impl<S: Scalar, const N: usize> Interpolant<S, N> for Collocation<S, N> {
    #[inline(always)]
    fn at(&self, t: S) -> State<S, N> {
        self.from.moved(t, S::one(), &self.increment((t - self.from.t) / self.h))
    }
}

#[cfg(test)]
mod tests;
