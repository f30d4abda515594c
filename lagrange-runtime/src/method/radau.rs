//! Radau IIA of order 5 for stiff systems: implicit, L-stable, stiffly accurate.
//!
//! With three stages at `c = ((4 − √6)/10, (4 + √6)/10, 1)`, the increments `zᵢ = h Σⱼ aᵢⱼ f(y₀ + zⱼ)` of y = (q, q̇) are
//! found by a simplified Newton iteration. In the variables `w = T⁻¹z` that bring `A⁻¹` to the form
//! `diag(γ, (α, −β; β, α))` it falls into one real and one complex system (Hairer, Wanner, *Solving Ordinary
//! Differential Equations II*, 1996, IV.8), each of which has only N unknowns, since half of the equations say `q̇ = v`.
//!
//! The iteration ends where what is left of its error, `θ/(1 − θ)` times the last change (θ: rate of convergence), is
//! far below the estimated error of the step, as far as the true error of order 5 is below the estimate of order 3.
//! So no tolerance has to be known here, and at fixed steps the order is kept.

use super::newton::{ROUNDING, Resolvent, diverged, largest, regular, relative, unsolvable};
use super::{Dense, Method, Step};
use crate::controller::{ErrorEstimate, SquareNorm};
use crate::failure::Failure;
use crate::linear::Complex;
use crate::scalar::{Functions, Real, Scalar};
use crate::state::{State, Tangent, add_scaled};
use crate::system::{Jacobian, Lagrangian};
use nalgebra::SVector;

/// Iterations after which a step fails; those worth waiting for need 2 to 8.
const MOST_ITERATIONS: u32 = 15;

const SQRT6: f64 = 2.449489742783178;

/// The nodes.
const C: [f64; 3] = [(4.0 - SQRT6) / 10.0, (4.0 + SQRT6) / 10.0, 1.0];

/// `1/γ = (6 + ∛81 − ∛9)/30` and `1/(α ± iβ) = (12 − ∛81 + ∛9)/60 ∓ i(∛81 + ∛9)√3/60` are the eigenvalues of A.
const GAMMA: f64 = 3.637834252744496;
const ALPHA: f64 = 2.681082873627752;
const BETA: f64 = 3.0504301992474105;

/// The matrix T of Hairer and Wanner 1996, IV.8, eq. 8.13 and of their code `RADAU5`, and its inverse.
const T: [[f64; 3]; 3] = [
    [0.09123239487089295, -0.1412552950209542, -0.030029194105147424],
    [0.241717932707107, 0.20412935229379994, 0.3829421127572619],
    [0.966048182615093, 1.0, 0.0],
];
const T_INVERSE: [[f64; 3]; 3] = [
    [4.325579890063155, 0.33919925181580984, 0.5417705399358749],
    [-4.178718591551905, -0.32768282076106237, 0.47662355450055044],
    [-0.5028726349457868, 2.571926949855605, -0.5960392048282249],
];

/// Of the error estimate, over h (eq. 8.18 and 8.19 with γ₀ = 1/γ).
const E: [f64; 3] = [-(13.0 + 7.0 * SQRT6) / 3.0, (-13.0 + 7.0 * SQRT6) / 3.0, -1.0 / 3.0];

/// Radau IIA of order 5 (Ehle 1969; Hairer and Wanner 1996, IV.8): collocation at three nodes, L-stable, for stiff
/// systems and high accuracy. Its interpolant is the collocation polynomial, of order 3 in q̇ and, as the integral of
/// that, of order 4 in q.
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
/// let mut run = integrate(&system, Radau5, Pi::tolerance(1e-8), start).until(2.0);
/// run.run_out()?;
/// assert!((run.state().q[0] - (-2.0f64).exp()).abs() < 1e-7 && run.statistics().accepted < 200);
/// # Ok::<(), Failure>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Radau5;

/// The difference to an embedded formula of order 3, filtered by `(γ/h − J)⁻¹` (Hairer and Wanner 1996, IV.8, eq. 8.20).
/// It behaves as h⁴ where the error of the method is h⁶, so its size is the norm's power of 5/4: as h⁵, in line with what a
/// controller expects of order 5, and 1 where the norm is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RadauEstimate<S, const N: usize>(pub Tangent<S, N>);

impl<S: Real, const N: usize> ErrorEstimate<S, N> for RadauEstimate<S, N> {
    fn square<R: Scalar>(&self, norm: &impl SquareNorm<S, R, N>) -> R {
        norm.of(&self.0).powf(R::from_f64(1.25))
    }
}

impl<Sys: Lagrangian<N>, const N: usize> Method<Sys, N> for Radau5
where
    Sys::Scalar: Real,
{
    /// The collocation polynomial of the step before, from which the next stages are guessed.
    type Memory = Option<Collocation<Sys::Scalar, N>>;
    type Stages = ();
    type Error = RadauEstimate<Sys::Scalar, N>;
    type Dense = Collocation<Sys::Scalar, N>;

    fn order(&self) -> u32 {
        5
    }

    fn implicit(&self) -> bool {
        true
    }

    fn start(&self, system: &Sys, at: &State<Sys::Scalar, N>) -> Result<Self::Memory, Failure<Sys::Scalar>> {
        regular(system, at).map(|()| None)
    }

    fn step(
        &self,
        system: &Sys,
        memory: &Self::Memory,
        from: &State<Sys::Scalar, N>,
        h: Sys::Scalar,
    ) -> Result<Step<Sys, Self, N>, Failure<Sys::Scalar>> {
        let jacobian = system.jacobian(&from.q, &from.qd, from.t);
        let equations = Equations::new(system, from, h, &jacobian)?;
        let guess = memory.as_ref().map_or([Tangent::zero(); 3], |before| before.guess(h));
        let (z, error, iterations) = equations.solve(guess)?;
        let to = from.moved(from.t + h, Sys::Scalar::one(), &z[2]);
        let memory = Some(Collocation::new(from, h, &z));
        let evaluations = 3 + 3 * iterations;
        Ok(Step { from: *from, to, h, error: RadauEstimate(error), memory, stages: (), evaluations })
    }

    fn dense(&self, _: &Sys, step: &Step<Sys, Self, N>) -> Self::Dense {
        step.memory.unwrap_or_else(|| Collocation::new(&step.from, step.h, &[Tangent::zero(); 3]))
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
    Sys::Scalar: Real,
{
    fn new(
        system: &'a Sys,
        from: &'a State<Sys::Scalar, N>,
        h: Sys::Scalar,
        jacobian: &Jacobian<Sys::Scalar, N>,
    ) -> Result<Self, Failure<Sys::Scalar>> {
        let over_h = |x: f64| Sys::Scalar::from_f64(x) / h;
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

    fn solve(
        &self,
        mut z: [Tangent<Sys::Scalar, N>; 3],
    ) -> Result<Solution<Sys::Scalar, N>, Failure<Sys::Scalar>> {
        let epsilon = Sys::Scalar::EPSILON;
        let mut last = f64::INFINITY;
        for iterations in 1..=MOST_ITERATIONS {
            let change = self.improve(&mut z);
            let scale = self.scale(&z);
            let size = change.iter().map(|dz| relative(dz, scale)).fold(0.0, |a: f64, b| a + b);
            if !size.is_finite() {
                return Err(diverged(self.system, self.from, self.h, iterations));
            }
            // The first change says nothing about the rate of convergence.
            let theta = if iterations == 1 { 0.5 } else { size / last };
            let rounded =
                size <= 8.0 * epsilon || (theta >= 0.5 && size < ROUNDING * epsilon && iterations > 1);
            if theta >= 0.99 && !rounded {
                return Err(Failure::NotConverged { t: self.from.t, h: self.h, iterations });
            }
            let (error, sum) = self.error(&z);
            let estimate = relative(&error, scale);
            let enough = 0.03 * estimate * Functions::sqrt(estimate).min(1.0);
            if rounded || (iterations > 1 && size * theta / (1.0 - theta) <= enough) {
                return Ok((z, self.refined(&error, &sum), iterations));
            }
            last = size;
        }
        Err(Failure::NotConverged { t: self.from.t, h: self.h, iterations: MOST_ITERATIONS })
    }

    /// One iteration: `(h⁻¹Λ − J) Δw = T⁻¹F(z) − h⁻¹Λ w`. Gives the change of z.
    fn improve(&self, z: &mut [Tangent<Sys::Scalar, N>; 3]) -> [Tangent<Sys::Scalar, N>; 3] {
        let stages: [_; 3] = core::array::from_fn(|i| {
            let t = self.from.t + self.h * Sys::Scalar::from_f64(C[i]);
            rate(self.system, &self.from.moved(t, Sys::Scalar::one(), &z[i]))
        });
        let [f, w] = [transform(&T_INVERSE, &stages), transform(&T_INVERSE, z)];
        let [gamma, alpha, beta] = [GAMMA, ALPHA, BETA].map(|x| Sys::Scalar::from_f64(x) / self.h);
        let first = self.real.apply(&f[0].plus_scaled(-gamma, &w[0]));
        let re = f[1].plus_scaled(-alpha, &w[1]).plus_scaled(beta, &w[2]);
        let im = f[2].plus_scaled(-beta, &w[1]).plus_scaled(-alpha, &w[2]);
        let pair = |re: &SVector<Sys::Scalar, N>, im: &SVector<Sys::Scalar, N>| {
            SVector::from_fn(|i, _| Complex { re: re[i], im: im[i] })
        };
        let (q, qd) = self.complex.solve(&pair(&re.q, &im.q), &pair(&re.qd, &im.qd));
        let second = Tangent { q: q.map(|x| x.re), qd: qd.map(|x| x.re) };
        let third = Tangent { q: q.map(|x| x.im), qd: qd.map(|x| x.im) };
        let change = transform(&T, &[first, second, third]);
        for (z, change) in z.iter_mut().zip(&change) {
            *z = z.plus_scaled(Sys::Scalar::one(), change);
        }
        change
    }

    /// The sizes of the variables during the step, of q and of q̇.
    fn scale(&self, z: &[Tangent<Sys::Scalar, N>; 3]) -> [f64; 2] {
        let most = |sizes: [f64; 3]| sizes.into_iter().fold(0.0, f64::max);
        [
            largest(&self.from.q) + most([0, 1, 2].map(|i| largest(&z[i].q))),
            largest(&self.from.qd) + most([0, 1, 2].map(|i| largest(&z[i].qd))),
        ]
    }

    /// `(γ/h − J)⁻¹ (f(y₀) + Σ eᵢ zᵢ/h)`, and the sum in it.
    fn error(&self, z: &[Tangent<Sys::Scalar, N>; 3]) -> (Tangent<Sys::Scalar, N>, Tangent<Sys::Scalar, N>) {
        let mut sum = Tangent::zero();
        for (z, e) in z.iter().zip(E) {
            sum = sum.plus_scaled(Sys::Scalar::from_f64(e) / self.h, z);
        }
        (self.real.apply(&self.rate.plus_scaled(Sys::Scalar::one(), &sum)), sum)
    }

    /// The same with `f(y₀ + error)` for `f(y₀)`: right also where what is stiff is far from its slow solution, and
    /// worth one evaluation.
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
fn rate<Sys: Lagrangian<N>, const N: usize>(
    system: &Sys,
    at: &State<Sys::Scalar, N>,
) -> Tangent<Sys::Scalar, N> {
    Tangent { q: at.qd, qd: system.accel(&at.q, &at.qd, at.t) }
}

fn transform<S: Scalar, const N: usize>(m: &[[f64; 3]; 3], x: &[Tangent<S, N>; 3]) -> [Tangent<S, N>; 3] {
    m.map(|row| {
        let mut sum = Tangent::zero();
        for (m, x) in row.iter().zip(x) {
            sum = sum.plus_scaled(S::from_f64(*m), x);
        }
        sum
    })
}

/// The collocation polynomial: of degree 3 in θ for q̇, through the start and the three stages, and its integral for q,
/// which meets the end exactly, since the quadrature of the method is exact for degree 4.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Collocation<S, const N: usize> {
    from: State<S, N>,
    h: S,
    /// `q̇ = q̇₀ + θ(v₁ + θ(v₂ + θ v₃))`.
    v: [SVector<S, N>; 3],
}

impl<S: Scalar, const N: usize> Collocation<S, N> {
    fn new(from: &State<S, N>, h: S, z: &[Tangent<S, N>; 3]) -> Self {
        let number = S::from_f64;
        // Newton's divided differences over 0, c₁, c₂, 1, then expanded in powers of θ.
        let d1 = z[0].qd * number(1.0 / C[0]);
        let d12 = (z[1].qd - z[0].qd) * number(1.0 / (C[1] - C[0]));
        let d23 = (z[2].qd - z[1].qd) * number(1.0 / (C[2] - C[1]));
        let d2 = (d12 - d1) * number(1.0 / C[1]);
        let d3 = ((d23 - d12) * number(1.0 / (C[2] - C[0])) - d2) * number(1.0 / C[2]);
        let v2 = d2 - d3 * number(C[0] + C[1]);
        let v1 = d1 - d2 * number(C[0]) + d3 * number(C[0] * C[1]);
        Collocation { from: *from, h, v: [v1, v2, d3] }
    }

    /// The increments of q and q̇ from the start to θ.
    fn increment(&self, theta: S) -> Tangent<S, N> {
        let [v1, v2, v3] = &self.v;
        let sum = |a: f64, b: f64, c: f64| {
            let tail = add_scaled(&(v2 * S::from_f64(b)), theta, &(v3 * S::from_f64(c)));
            add_scaled(&(v1 * S::from_f64(a)), theta, &tail) * theta
        };
        let q = (self.from.qd + sum(1.0 / 2.0, 1.0 / 3.0, 1.0 / 4.0)) * (self.h * theta);
        Tangent { q, qd: sum(1.0, 1.0, 1.0) }
    }

    /// The increments at the stages of the next step of size `h`, by extrapolation.
    fn guess(&self, h: S) -> [Tangent<S, N>; 3] {
        let end = self.increment(S::one());
        C.map(|c| {
            let there = self.increment(S::one() + S::from_f64(c) * h / self.h);
            there.plus_scaled(-S::one(), &end)
        })
    }
}

impl<S: Scalar, const N: usize> Dense<S, N> for Collocation<S, N> {
    fn at(&self, t: S) -> State<S, N> {
        self.from.moved(t, S::one(), &self.increment((t - self.from.t) / self.h))
    }
}

#[cfg(test)]
mod tests;
