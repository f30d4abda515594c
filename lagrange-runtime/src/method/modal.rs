//! The exact solution of linear systems with constant coefficients, `M q̈ + C q̇ + K q = f`: one step of any length is
//! exact to rounding.
//!
//! With `y = (q, q̇)` and `ẏ = A y + b` the step is `y₁ = E y₀ + φ`, `E = exp(A h)` and `φ = ∫₀ʰ exp(A s) b ds`, both
//! from the exponential of `(A, b; 0, 0)` by scaling and squaring with the Padé approximant of degree 13
//! (Higham, *The scaling and squaring method for the matrix exponential revisited*, SIAM J. Matrix Anal. Appl. 26,
//! 2005, eq. 2.1 and algorithm 2.3). No normal modes are computed, so damping, gyroscopic terms, equal frequencies
//! and rigid motions are nothing special.

use super::newton::accelerations;
use super::{Interpolant, Method, Step};
use crate::controller::NoEstimate;
use crate::failure::Failure;
use crate::lanes::lanewise;
use crate::linear::{factored, product};
use crate::scalar::{Functions, Real, Scalar, SimdScalar};
use crate::state::{State, Tangent, constant};
use crate::system::{Autonomous, Jacobian, Linear};
use nalgebra::{SMatrix, SVector};

/// Coefficients of the numerator of the [13/13] Padé approximant of exp.
const PADE: [f64; 14] = [
    64764752532480000.0,
    32382376266240000.0,
    7771770303897600.0,
    1187353796428800.0,
    129060195264000.0,
    10559470521600.0,
    670442572800.0,
    33522128640.0,
    1323241920.0,
    40840800.0,
    960960.0,
    16380.0,
    182.0,
    1.0,
];

/// Norms up to these give the approximant an error below the rounding of f64 (Higham 2005, table 2.3), and below that
/// of `DoubleDouble`: `(13!)² θ²⁶/(26! 27!) < 2⁻¹⁰⁷`.
const THETA: f64 = 5.371920351148152;
const SMALL_THETA: f64 = 1.25;

/// Radians and decays in a step from which its rounding is looked at, the part of the largest entry of a column of the
/// propagator that may be rounding, and the size of this below which all has decayed. Rounding damps, too: a decay
/// counts only in a step so short that its radians and decays times ε are no more than that part.
const LONG: f64 = 1e4;
const LOST: f64 = 1e-4;
const DECAYED: f64 = 1e-6;

/// Exact propagation of a [`Linear`] and [`Autonomous`] system, `M q̈ + C q̇ + K q = f` with constant M, C, K and f:
/// any step is exact to rounding (of the order of ε times the number of radians in it), and so is the interpolant. A
/// slow motion beside one that is stiff, or decays fast, in other coordinates than its own, has an error of ε times the
/// square, or the ratio, of their rates. A step in which more than 1e-4 is rounding ends the run in
/// [`Failure::NonFinite`].
/// The exponential is computed anew only when the step size changes, and for each state that is interpolated.
///
/// [Events](crate::Run::events) within a step are searched for at eight points per half period of the fastest
/// oscillation. A step that takes more than 2²⁴ of them, of 10⁶ turns, ends the run in [`Failure::EventsUnresolved`].
///
/// # Hypotheses
/// - Accelerations are linear in q and q̇ with constant coefficients ([`Facts::linear`](crate::Facts::linear)), and
///   time does not appear in them ([`Facts::autonomous`](crate::Facts::autonomous)): rustc rejects other systems.
/// - M is regular.
///
/// rustc rejects a system in which the compiler did not prove both, such as one with a force of time:
///
/// ```compile_fail,E0277
/// # use lagrange_runtime::prelude::*;
/// lagrangian! {
///     system Driven {
///         coord x;
///         T = 0.5 * dot(x).powi(2);
///         V = 0;
///         Q[x] = if t > 5 && t < 10 { 1 } else { 0 };
///     }
/// }
/// let run = integrate(&Driven::new(), MatrixExponential, FixedStep::new(1.0), State::new(0.0, [0.0], [0.0]));
/// ```
///
/// ```
/// use lagrange_runtime::prelude::*;
/// lagrangian! {
///     system Oscillator {
///         param omega;
///         coord x;
///         T = 0.5 * dot(x).powi(2);
///         V = 0.5 * (omega * x).powi(2);
///     }
/// }
/// let start = State::new(0.0, [1.0], [0.0]);
/// let end = integrate(&Oscillator::new(2.0), MatrixExponential, FixedStep::new(50.0), start).until(50.0).final_state()?;
/// assert!((end.q[0] - 100.0f64.cos()).abs() < 1e-13);
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct MatrixExponential;

impl<Sys: Linear<N> + Autonomous<N>, const N: usize> Method<Sys, N> for MatrixExponential
where
    Sys::Scalar: SimdScalar,
{
    type MethodState = Propagator<Sys::Scalar, N>;
    type InterpolantData = Generator<Sys::Scalar, N>;
    type Error = NoEstimate;
    type Interpolant = Exact<Sys::Scalar, N>;

    /// No error depends on the step; what this number says is "higher than any other".
    fn order(&self) -> u32 {
        u32::MAX
    }

    fn start(
        &self,
        system: &Sys,
        at: &State<Sys::Scalar, N>,
    ) -> Result<Self::MethodState, Failure<Sys::Scalar>> {
        accelerations(system, at)?;
        Ok(Propagator::none(Generator::of(system, at.t)))
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn step_into(
        &self,
        _: &Sys,
        memory: &Self::MethodState,
        from: &State<Sys::Scalar, N>,
        h: Sys::Scalar,
        next: &mut Self::MethodState,
    ) -> Result<Step<Sys, Self, N>, Failure<Sys::Scalar>> {
        *next = memory.of_step(h);
        let to = next.apply(from);
        Ok(Step { from: *from, to, h, error: NoEstimate, stages: next.generator, evaluations: 0 })
    }

    fn interpolant(&self, _: &Sys, step: &Step<Sys, Self, N>) -> Self::Interpolant {
        Exact { from: step.from, generator: step.stages }
    }

    /// Eight for each half turn of the fastest oscillation, as a power of two.
    fn parts(&self, memory: &Self::MethodState, h: Sys::Scalar) -> u32 {
        let angles = (memory.generator.rate * h).apart();
        let half_turns = angles.as_ref().iter().fold(0.0, |most: f64, angle| angle.magnitude().max(most));
        let wanted = (half_turns * (8.0 / core::f64::consts::PI)) as u32;
        wanted.max(16).checked_next_power_of_two().unwrap_or(u32::MAX)
    }

    fn start_evaluations(&self) -> u32 {
        3
    }
}

/// `q̈ = K q + C q̇ + f`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(bound(
        serialize = "S: crate::Scalar + serde::Serialize",
        deserialize = "S: crate::Scalar + serde::Deserialize<'de>"
    ))
)]
pub struct Generator<S, const N: usize> {
    k: SMatrix<S, N, N>,
    c: SMatrix<S, N, N>,
    f: SVector<S, N>,
    /// Upper bound of the angular frequencies.
    rate: S,
}

/// Upper bound of |Im λ| for the roots of `det(λ² M + λ C + K) = 0`, M being positive definite and G the
/// antisymmetric part of C.
///
/// With a root's vector x, `xᴴMx = 1`, and `c = xᴴCx`, `k = xᴴKx` the root is `λ = −c/2 ± s`, `s² = (c/2)² − k`, so
/// that `(s − c/2)(s + c/2) = −k`, one of the factors is not larger than √|k|, and `|Im λ| ≤ |Im c| + √|k|`. Here
/// `Im c = xᴴGx/i`, and `|xᴴKx| ≤ ‖L⁻¹ K L⁻ᵀ‖` with `M = L Lᵀ`, whose Frobenius norm is `tr(M⁻¹ K M⁻¹ Kᵀ)^½`. Damping
/// makes nothing faster, and the unit of no coordinate matters.
fn fastest<S: Scalar, const N: usize>(
    inertia: &SMatrix<S, N, N>,
    k: &SMatrix<S, N, N>,
    c: &SMatrix<S, N, N>,
) -> S {
    let factors = factored(inertia);
    let times = |a: &SMatrix<S, N, N>, b: &SMatrix<S, N, N>| {
        SMatrix::from_fn(|i, j| (0..N).fold(S::zero(), |sum, l| a[(i, l)].mul_add(b[(l, j)], sum)))
    };
    let norm = |a: &SMatrix<S, N, N>| {
        let mut by_inertia = [*a, a.transpose()];
        for a in &mut by_inertia {
            for mut column in a.column_iter_mut() {
                column.copy_from(&factors.solve(&column.clone_owned()));
            }
        }
        let product = times(&by_inertia[0], &by_inertia[1]);
        (0..N).fold(S::zero(), |trace, i| trace + product[(i, i)]).abs().sqrt()
    };
    let (stiffness, damping) = (times(inertia, k), times(inertia, c));
    let gyroscopic = SMatrix::from_fn(|i, j| (damping[(i, j)] - damping[(j, i)]) * S::from_f64(0.5));
    norm(&gyroscopic) + norm(&stiffness).sqrt()
}

impl<S: SimdScalar, const N: usize> Generator<S, N> {
    /// The constants, which are the same everywhere: at `q = q̇ = 0` nothing has to be taken off the accelerations to
    /// get f.
    fn of<Sys: Linear<N, Scalar = S>>(system: &Sys, t: S) -> Self {
        let zero = constant(S::zero());
        let Jacobian { q: k, qd: c, .. } = system.jacobian(&zero, &zero, t);
        let rate = fastest(&system.inertia(&zero, &zero, t), &k, &c);
        Generator { k, c, f: system.accel(&zero, &zero, t), rate }
    }

    /// The constants of one number.
    fn number(&self, place: usize) -> Generator<S::Element, N> {
        let number = |x: S| x.number(place);
        let rate = number(self.rate);
        Generator { k: self.k.map(number), c: self.c.map(number), f: self.f.map(number), rate }
    }
}

lanewise! { Generator<N> { k, c, f, rate } }

impl<S: Real, const N: usize> Generator<S, N> {
    /// E and φ of a step of size `h`.
    fn propagator(&self, h: S) -> Propagator<S, N> {
        // In the variables (q, q̇/ω), ω² about the size of K, both blocks off the diagonal are of one size: fewer
        // squarings and fewer rounding errors. A power of 2 rounds nothing.
        let stiffness = norm(&self.k);
        let mut omega = 1.0;
        while omega * omega * 4.0 <= stiffness && omega < 1e150 {
            omega *= 2.0;
        }
        while omega * omega > stiffness && stiffness > 0.0 && omega > 1e-150 {
            omega *= 0.5;
        }
        let [up, down] = [S::from_f64(omega), S::from_f64(1.0 / omega)];
        let identity = Blocks::<S, N>::diagonal(S::one());
        let size = h.to_f64().abs() * (omega + norm(&self.k) / omega).max(omega + norm(&self.c));
        let (mut squarings, mut scale) = (0, 1.0);
        let largest = if S::EPSILON < 1e-20 { SMALL_THETA } else { THETA };
        while size * scale > largest && squarings < 1100 {
            squarings += 1;
            scale *= 0.5;
        }
        let two = S::from_f64(2.0);
        // E and φ of a step of size `part` times 2 to the power of the squarings, and which columns of E decay by more
        // than rounding.
        let power = |part: S| {
            let a = Blocks {
                rows: [
                    [identity.rows[0][1], identity.rows[0][0] * (up * part)],
                    [self.k * (down * part), self.c * part],
                ],
            };
            let b = [constant(S::zero()), self.f * (down * part)];
            let (mut less, mut phi) = pade(&a, &b);
            let mut e = less.plus(&identity);
            let (mut decayed, mut settled) = (false, [[false; N]; 2]);
            let mut rounding = S::EPSILON * size * scale;
            for _ in 0..squarings {
                // (E, φ; 0, 1)². As D = E − 1 until all has decayed: beside 1 a slow decay would be rounding.
                if decayed {
                    let moved = e.apply(&phi);
                    phi = [phi[0] + moved[0], phi[1] + moved[1]];
                    e = e.times(&e);
                } else {
                    let moved = less.apply(&phi);
                    phi = [phi[0] * two + moved[0], phi[1] * two + moved[1]];
                    less = less.scaled(two).plus(&less.times(&less));
                    e = less.plus(&identity);
                    decayed = e.largest().into_iter().flatten().all(|column| column < 0.5);
                }
                rounding *= 2.0;
                if size > LONG && rounding < LOST {
                    settled = e.largest().map(|columns| columns.map(|largest| largest < DECAYED));
                }
            }
            (e, phi, settled)
        };
        let part = h * S::from_f64(scale);
        let (mut e, phi, settled) = power(part);
        if size > LONG {
            // The same in three steps has other roundings.
            let third = power(part / S::from_f64(3.0)).0;
            let again = third.times(&third).times(&third);
            let [off, kept, other] = [again.scaled(-S::one()).plus(&e), e, again].map(|e| e.largest());
            // (Column by column: a long way of one coordinate says nothing about others.)
            let is_known = |half: usize, j: usize| {
                let largest = kept[half][j].max(other[half][j]);
                settled[half][j] || (largest >= DECAYED && off[half][j] <= LOST * largest)
            };
            if !(0..2 * N).all(|j| is_known(j / N, j % N)) {
                e = identity.scaled(S::from_f64(f64::NAN));
            }
        }
        let [[qq, qv], [vq, vv]] = e.rows;
        let e = Blocks { rows: [[qq, qv * down], [vq * up, vv]] };
        Propagator { generator: *self, h, e, phi: Tangent { q: phi[0], qd: phi[1] * up } }
    }
}

/// `exp(A) − 1` and `∫₀¹ exp(A s) b ds` for small A. With `U = A W` and V the odd and even parts of the numerator, the
/// exponential of `(A, b; 0, 0)`, less 1, is `(2 (V − U)⁻¹ U, 2 (V − U)⁻¹ W b; 0, 0)`.
fn pade<S: Real, const N: usize>(
    a: &Blocks<S, N>,
    b: &[SVector<S, N>; 2],
) -> (Blocks<S, N>, [SVector<S, N>; 2]) {
    let a2 = a.times(a);
    let a4 = a2.times(&a2);
    let a6 = a4.times(&a2);
    // Σ of the powers with coefficients `PADE[first], PADE[first + 2], …`.
    let even = |first: usize| {
        let c = |i: usize| S::from_f64(PADE[first + 2 * i]);
        let high = a2.scaled(c(4)).plus(&a4.scaled(c(5))).plus(&a6.scaled(c(6)));
        let low = Blocks::diagonal(c(0)).plus(&a2.scaled(c(1))).plus(&a4.scaled(c(2))).plus(&a6.scaled(c(3)));
        a6.times(&high).plus(&low)
    };
    let (w, v) = (even(1), even(0));
    let u = a.times(&w);
    let wb = w.apply(b).map(|x| x * S::from_f64(2.0));
    solve(v.plus(&u.scaled(-S::one())), u.scaled(S::from_f64(2.0)), wb)
}

/// `Q⁻¹ P` and `Q⁻¹ x` by elimination with partial pivoting.
fn solve<S: Real, const N: usize>(
    mut q: Blocks<S, N>,
    mut p: Blocks<S, N>,
    mut x: [SVector<S, N>; 2],
) -> (Blocks<S, N>, [SVector<S, N>; 2]) {
    let subtract =
        |q: &mut Blocks<S, N>, p: &mut Blocks<S, N>, x: &mut [SVector<S, N>; 2], i, j, factor: S| {
            for k in 0..2 * N {
                let (qj, pj) = (q.at(j, k), p.at(j, k));
                *q.at_mut(i, k) -= factor * qj;
                *p.at_mut(i, k) -= factor * pj;
            }
            let xj = x[j / N][j % N];
            x[i / N][i % N] -= factor * xj;
        };
    for j in 0..2 * N {
        let size = |i: usize| q.at(i, j).to_f64().abs();
        let pivot = (j + 1..2 * N).fold(j, |best, i| if size(i) > size(best) { i } else { best });
        if pivot != j {
            for k in 0..2 * N {
                for m in [&mut q, &mut p] {
                    let (upper, lower) = (m.at(j, k), m.at(pivot, k));
                    (*m.at_mut(j, k), *m.at_mut(pivot, k)) = (lower, upper);
                }
            }
            let (upper, lower) = (x[j / N][j % N], x[pivot / N][pivot % N]);
            (x[j / N][j % N], x[pivot / N][pivot % N]) = (lower, upper);
        }
        for i in (0..2 * N).filter(|&i| i != j) {
            let factor = q.at(i, j) / q.at(j, j);
            subtract(&mut q, &mut p, &mut x, i, j, factor);
        }
    }
    for i in 0..2 * N {
        let pivot = q.at(i, i);
        for k in 0..2 * N {
            *p.at_mut(i, k) /= pivot;
        }
        x[i / N][i % N] /= pivot;
    }
    (p, x)
}

/// The exact map of one step, `y₁ = E y₀ + φ`, and what it was made from.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(bound(
        serialize = "S: crate::Scalar + serde::Serialize",
        deserialize = "S: crate::Scalar + serde::Deserialize<'de>"
    ))
)]
pub struct Propagator<S, const N: usize> {
    generator: Generator<S, N>,
    h: S,
    e: Blocks<S, N>,
    phi: Tangent<S, N>,
}

lanewise! {
    Blocks<N> { rows }
    Propagator<N> { generator, h, e, phi }
}

impl<S: SimdScalar, const N: usize> Propagator<S, N> {
    /// Propagator of a step of size 0.
    fn none(generator: Generator<S, N>) -> Self {
        Propagator { generator, h: S::zero(), e: Blocks::diagonal(S::one()), phi: Tangent::zero() }
    }

    /// Propagator of a step of size `h`: this one where it has that size, and else one that is computed, number by
    /// number.
    fn of_step(&self, h: S) -> Self {
        let stale = S::each(|i| self.h.number(i) != h.number(i));
        if !stale.as_ref().contains(&true) {
            return *self;
        }
        let new = S::each(|i| stale.as_ref()[i].then(|| self.generator.number(i).propagator(h.number(i))));
        let put = |old: S, part: &dyn Fn(&Propagator<S::Element, N>) -> S::Element| {
            S::of(|i| new.as_ref()[i].as_ref().map_or(old.number(i), part))
        };
        let mut all = Propagator { h, ..*self };
        for i in 0..N {
            all.phi.q[i] = put(self.phi.q[i], &|one| one.phi.q[i]);
            all.phi.qd[i] = put(self.phi.qd[i], &|one| one.phi.qd[i]);
        }
        for i in 0..2 * N {
            for j in 0..2 * N {
                *all.e.at_mut(i, j) = put(self.e.at(i, j), &|one| one.e.at(i, j));
            }
        }
        all
    }

    #[inline(always)]
    fn apply(&self, from: &State<S, N>) -> State<S, N> {
        let [q, qd] = self.e.apply(&[from.q, from.qd]);
        State { t: from.t + self.h, q: q + self.phi.q, qd: qd + self.phi.qd }
    }
}

/// The exact solution through the start of a step. Each state costs a matrix exponential.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exact<S, const N: usize> {
    from: State<S, N>,
    generator: Generator<S, N>,
}

impl<S: SimdScalar, const N: usize> Interpolant<S, N> for Exact<S, N> {
    fn at(&self, t: S) -> State<S, N> {
        let there = Propagator::none(self.generator).of_step(t - self.from.t).apply(&self.from);
        State { t, ..there }
    }
}

/// A 2N × 2N matrix of four blocks.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(bound(
        serialize = "S: crate::Scalar + serde::Serialize",
        deserialize = "S: crate::Scalar + serde::Deserialize<'de>"
    ))
)]
struct Blocks<S, const N: usize> {
    rows: [[SMatrix<S, N, N>; 2]; 2],
}

impl<S: Scalar, const N: usize> Blocks<S, N> {
    fn diagonal(x: S) -> Self {
        let block = |x: S| SMatrix::from_fn(|i, j| if i == j { x } else { S::zero() });
        Blocks { rows: [[block(x), block(S::zero())], [block(S::zero()), block(x)]] }
    }

    fn at(&self, i: usize, j: usize) -> S {
        self.rows[i / N][j / N][(i % N, j % N)]
    }

    fn at_mut(&mut self, i: usize, j: usize) -> &mut S {
        &mut self.rows[i / N][j / N][(i % N, j % N)]
    }

    fn scaled(&self, a: S) -> Self {
        Blocks { rows: self.rows.map(|row| row.map(|block| block * a)) }
    }

    fn plus(&self, other: &Self) -> Self {
        let sum = |i: usize, j: usize| self.rows[i][j] + other.rows[i][j];
        Blocks { rows: [[sum(0, 0), sum(0, 1)], [sum(1, 0), sum(1, 1)]] }
    }

    fn times(&self, other: &Self) -> Self {
        let block = |i: usize, j: usize| {
            let entry = |m: usize, n: usize| {
                let part = |k: usize| {
                    (0..N).fold(S::zero(), |sum, l| {
                        self.rows[i][k][(m, l)].mul_add(other.rows[k][j][(l, n)], sum)
                    })
                };
                part(0) + part(1)
            };
            SMatrix::from_fn(entry)
        };
        Blocks { rows: [[block(0, 0), block(0, 1)], [block(1, 0), block(1, 1)]] }
    }

    #[inline(always)]
    fn apply(&self, x: &[SVector<S, N>; 2]) -> [SVector<S, N>; 2] {
        self.rows.map(|[a, b]| product(&a, &x[0]) + product(&b, &x[1]))
    }
}

impl<S: Real, const N: usize> Blocks<S, N> {
    /// Size of the largest entry of each column.
    fn largest(&self) -> [[f64; N]; 2] {
        let column = |j: usize| (0..2 * N).map(move |i| Functions::abs(self.at(i, j).to_f64()));
        [0, N].map(|first| core::array::from_fn(|j| column(first + j).fold(0.0, f64::max)))
    }
}

/// The largest sum of absolute values of a column.
fn norm<S: Real, const N: usize>(m: &SMatrix<S, N, N>) -> f64 {
    (0..N).map(|j| (0..N).map(|i| Functions::abs(m[(i, j)].to_f64())).sum()).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests;
