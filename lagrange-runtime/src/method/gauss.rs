//! Gauss–Legendre collocation on (q, p): symplectic and time-symmetric for every Lagrangian, separable or not.
//!
//! With `q̇ = velocities(q, p, t)` and `ṗ = force(q, q̇, t)`, i.e. Hamilton's equations without a Hamiltonian, the
//! stages are `Zᵢ = y₀ + h Σⱼ aᵢⱼ kⱼ`, `kᵢ = f(Zᵢ)`, and `y₁ = y₀ + h Σᵢ bᵢ kᵢ` for y = (q, p). In (q, q̇) the same
//! coefficients would be symplectic only for constant inertia. As Hairer, Lubich and Wanner recommend for symplectic
//! methods (*Geometric Numerical Integration*, 2006, VIII.6), the stages are found by fixed-point iteration to
//! rounding, started from the extrapolated stages of the step before, and the sums over steps lose nothing to
//! rounding.

#![allow(clippy::excessive_precision)]

use super::compensated::{Sum, forgetful};
use super::hermite::Hermite;
use super::newton::{Stagnation, diverged, larger, momenta, over};
use super::{Method, Step};
use crate::controller::NoEstimate;
use crate::failure::Failure;
use crate::iteration::{Iteration, Progress, chosen};
use crate::lanes::{Work, lanewise};
use crate::scalar::double_double::digits::exact_row;
use crate::scalar::{Comparison, DoubleDouble, Real, Scalar, SimdScalar};
use crate::state::{State, add_scaled, constant};
use crate::system::{LegendreTransform, System};
use nalgebra::SVector;

/// Iterations after which a step fails. Those that contract at all fast enough to be worth it need 5 to 50.
const MOST_ITERATIONS: u32 = 100;

/// Once changes of increments are below this many ε, they may stop decreasing: the iteration has reached rounding.
const ROUNDING: f64 = 4096.0;

/// Coefficients of a collocation method with `K` stages.
trait Collocation<const K: usize> {
    const A: [[DoubleDouble; K]; K];
    const B: [DoubleDouble; K];
    const C: [DoubleDouble; K];

    /// `aᵢⱼ/bⱼ = ½ + sᵢⱼ`. That the method is symplectic, `bᵢ aᵢⱼ + bⱼ aⱼᵢ = bᵢ bⱼ`, says that s is antisymmetric.
    /// With stages made of these ratios and of `bⱼ kⱼ`, the same products as at the end of the step, it is symplectic
    /// however b is rounded. Coefficients that are only near to that make the energy drift in proportion to time
    /// (Hairer, McLachlan, Razakarivony, *Achieving Brouwer's law with implicit Runge–Kutta methods*, BIT 48, 2008).
    const RATIO: [[DoubleDouble; K]; K] = {
        let mut ratio = [[DoubleDouble { hi: 0.5, lo: 0.0 }; K]; K];
        let mut i = 0;
        while i < K {
            let mut j = i + 1;
            while j < K {
                // −1 < s < 0: the sum with 2 rounds it to a multiple of 2⁻⁵², so that ½ ± s are exact.
                let s = (Self::A[i][j].hi / Self::B[j].hi - 0.5 + 2.0) - 2.0;
                let [half, minus] = [DoubleDouble { hi: -0.5, lo: 0.0 }, DoubleDouble { hi: -s, lo: 0.0 }];
                let rest = Self::A[i][j].over(Self::B[j]).plus(half).plus(minus).hi;
                ratio[i][j] = DoubleDouble { hi: 0.5 + s, lo: rest };
                ratio[j][i] = DoubleDouble { hi: 0.5 - s, lo: -rest };
                j += 1;
            }
            i += 1;
        }
        ratio
    };
}

macro_rules! gauss {
    ($(
        $(#[$doc:meta])*
        $name:ident($stages:literal stages, order $order:literal) {
            a [$([$($a:expr $(=> $a_digits:expr)?),*]),*];
            b [$($b:expr),*];
            c [$($c:expr $(=> $c_digits:expr)?),*];
        }
    )*) => {$(
        $(#[$doc])*
        ///
        /// A step fails with [`Failure::NotConverged`] where `h` times the fastest rate of the motion is of order 1.
        ///
        /// # Hypotheses
        /// - L is quadratic in the velocities, M regular, and coordinates are independent: rustc rejects other systems.
        /// - Steps are of one size: rustc rejects [`PiController`](crate::PiController), since there is no estimate
        ///   of the error.
        /// - Accelerations are smooth within a step. Adaptive runs end steps at the switches that the compiler knows;
        ///   steps of one size go over them, with an error of order h where forces jump and h² where they have a
        ///   kink.
        /// - Forces act for a step at least, see [forces that set in later](crate::method#forces-that-set-in-later).
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
        #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct $name;

        impl Collocation<$stages> for $name {
            const A: [[DoubleDouble; $stages]; $stages] = [$(exact_row![$($a $(=> $a_digits)?),*]),*];
            const B: [DoubleDouble; $stages] = exact_row![$($b),*];
            const C: [DoubleDouble; $stages] = exact_row![$($c $(=> $c_digits)?),*];
        }

        impl<Sys: LegendreTransform<N>, const N: usize> Method<Sys, N> for $name
        where
            Sys::Scalar: SimdScalar,
        {
            type MethodState = MethodState<Sys::Scalar, N, $stages>;
            type InterpolantData = ();
            type Error = NoEstimate;
            type Interpolant = Hermite<Sys::Scalar, N>;

            fn order(&self) -> u32 {
                $order
            }

            fn implicit(&self) -> bool {
                true
            }

            fn start(
                &self,
                system: &Sys,
                at: &State<Sys::Scalar, N>,
            ) -> Result<Self::MethodState, Failure<Sys::Scalar>> {
                MethodState::new(system, at)
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
                let (to, evaluations);
                (to, *next, evaluations) = step::<$name, Sys, $stages, N>(system, memory, from, h)?;
                Ok(Step { from: *from, to, h, error: NoEstimate, stages: (), evaluations })
            }

            #[inline(always)]
            fn interpolant(&self, system: &Sys, step: &Step<Sys, Self, N>) -> Self::Interpolant {
                let [from, to] = [&step.from, &step.to].map(|end| system.accel(&end.q, &end.qd, end.t));
                Hermite::new(&step.from, &step.to, step.h, &from, &to)
            }

            fn interpolant_evaluations(&self, _: &Self::Interpolant) -> u32 {
                2
            }
        }
    )*};
}

const SQRT3: f64 = 1.7320508075688772;
const SQRT15: f64 = 3.872983346207417;

// Hairer, Lubich, Wanner 2006, II.1.3, table 1.1; Kuntzmann 1961, Butcher 1964.
gauss! {
    /// The implicit midpoint rule on (q, p): order 2, symplectic, time-symmetric, stable for every linear oscillation.
    ImplicitMidpoint(1 stages, order 2) {
        a [[0.5]];
        b [1.0];
        c [0.5];
    }

    /// Gauss–Legendre collocation with two stages on (q, p): order 4, symplectic, time-symmetric.
    Gauss4(2 stages, order 4) {
        a [
            [0.25, 0.25 - SQRT3 / 6.0 => -0.0386751345948128822545743902509787278],
            [0.25 + SQRT3 / 6.0 => 0.538675134594812882254574390250978728, 0.25]
        ];
        b [0.5, 0.5];
        c [
            0.5 - SQRT3 / 6.0 => 0.211324865405187117745425609749021272,
            0.5 + SQRT3 / 6.0 => 0.788675134594812882254574390250978728
        ];
    }

    /// Gauss–Legendre collocation with three stages on (q, p): order 6, symplectic, time-symmetric.
    Gauss6(3 stages, order 6) {
        a [
            [
                5.0 / 36.0,
                2.0 / 9.0 - SQRT15 / 15.0 => -0.0359766675249389034563954710966044185,
                5.0 / 36.0 - SQRT15 / 30.0 => 0.00978944401530832604958004222947556853
            ],
            [
                5.0 / 36.0 + SQRT15 / 24.0 => 0.300263194980864592438024947213155539,
                2.0 / 9.0,
                5.0 / 36.0 - SQRT15 / 24.0 => -0.0224854172030868146602471694353777616
            ],
            [
                5.0 / 36.0 + SQRT15 / 30.0 => 0.267988333762469451728197735548302209,
                2.0 / 9.0 + SQRT15 / 15.0 => 0.480421111969383347900839915541048863,
                5.0 / 36.0
            ]
        ];
        b [5.0 / 18.0, 4.0 / 9.0, 5.0 / 18.0];
        c [
            0.5 - SQRT15 / 10.0 => 0.112701665379258311482073460021760039,
            0.5,
            0.5 + SQRT15 / 10.0 => 0.887298334620741688517926539978239961
        ];
    }
}

/// A point of phase space, or a rate of it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(bound(
        serialize = "S: crate::Scalar + serde::Serialize",
        deserialize = "S: crate::Scalar + serde::Deserialize<'de>"
    ))
)]
struct Phase<S, const N: usize> {
    q: SVector<S, N>,
    p: SVector<S, N>,
}

impl<S: Scalar, const N: usize> Phase<S, N> {
    fn zero() -> Self {
        Phase { q: constant(S::zero()), p: constant(S::zero()) }
    }

    #[inline(always)]
    fn plus_scaled(&self, a: S, other: &Self) -> Self {
        Phase { q: add_scaled(&self.q, a, &other.q), p: add_scaled(&self.p, a, &other.p) }
    }
}

/// Memory of a Gauss method: the momenta, what rounding took from q and p so far, and the rates at
/// the stages of the last step, from which the next ones are guessed.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(bound(
        serialize = "S: crate::Scalar + serde::Serialize",
        deserialize = "S: crate::Scalar + serde::Deserialize<'de>"
    ))
)]
pub struct MethodState<S, const N: usize, const K: usize> {
    p: SVector<S, N>,
    rest: Phase<S, N>,
    #[cfg_attr(feature = "serde", serde(with = "crate::saved::array"))]
    rates: [Phase<S, N>; K],
    /// Size of the last step; 0 at the start.
    h: S,
}

lanewise! {
    Phase<N> { q, p }
    MethodState<N, K> { p, rest, rates, h }
}

impl<S: SimdScalar, const N: usize, const K: usize> MethodState<S, N, K> {
    fn new<Sys: LegendreTransform<N, Scalar = S>>(
        system: &Sys,
        at: &State<S, N>,
    ) -> Result<Self, Failure<S>> {
        let p = momenta(system, at)?;
        Ok(MethodState { p, rest: Phase::zero(), rates: [Phase::zero(); K], h: S::zero() })
    }

    /// The rates at the stages of the next step of size `h`: the polynomial through the rates of the last step, at its
    /// stages and at its end, continued (Hairer, Lubich, Wanner 2006, VIII.6.1).
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn guess(&self, here: &Phase<S, N>, h: S, c: &[DoubleDouble; K]) -> [Phase<S, N>; K] {
        // Nodes in units of the last step, counted from its end.
        let node = |j: usize| if j == K { 0.0 } else { c[j].hi - 1.0 };
        // At the start there is no last step, and all its rates are 0.
        let ratio = S::select(Comparison::Equal, self.h, S::zero(), S::zero(), h / self.h);
        let mut guess = [Phase::zero(); K];
        for i in 0..K {
            let x = ratio * c[i].to();
            for j in 0..=K {
                let mut weight = S::one();
                for m in 0..=K {
                    if m != j {
                        weight *= (x - S::from_f64(node(m))) / S::from_f64(node(j) - node(m));
                    }
                }
                guess[i] = guess[i].plus_scaled(weight, if j == K { here } else { &self.rates[j] });
            }
        }
        guess
    }
}

/// `(q̇, ṗ)` at a point of phase space.
struct Rate<'a, Sys: System<N>, const N: usize> {
    system: &'a Sys,
    at: Phase<Sys::Scalar, N>,
    t: Sys::Scalar,
}

impl<Sys: LegendreTransform<N>, const N: usize> Work for Rate<'_, Sys, N> {
    type Output = Phase<Sys::Scalar, N>;

    #[inline(always)]
    fn run(self) -> Self::Output {
        let Rate { system, at: Phase { q, p }, t } = self;
        let qd = system.velocities(&q, &p, t);
        Phase { q: qd, p: system.momentum_rate(&q, &qd, t) }
    }
}

/// A step from the sums q and p.
struct Stages<'a, Sys: LegendreTransform<N>, const N: usize> {
    system: &'a Sys,
    t: Sys::Scalar,
    h: Sys::Scalar,
    q: Sum<Sys::Scalar, N>,
    p: Sum<Sys::Scalar, N>,
}

impl<Sys: LegendreTransform<N>, const N: usize> Stages<'_, Sys, N>
where
    Sys::Scalar: SimdScalar,
{
    /// The rates at the stages that these rates lead to. Stages are computed by [`Sum::at`] or, not so exactly, by
    /// [`Sum::near`].
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn sweep<T: Collocation<K>, const EXACT: bool, const K: usize>(
        &self,
        rates: &[Phase<Sys::Scalar, N>; K],
    ) -> [Phase<Sys::Scalar, N>; K] {
        let Stages { system, t, h, q, p } = self;
        let mut new = *rates;
        for i in 0..K {
            let mut slope = Phase::zero();
            for j in 0..K {
                let weighted = Phase::zero().plus_scaled(T::B[j].to(), &rates[j]);
                slope = slope.plus_scaled(T::RATIO[i][j].to(), &weighted);
            }
            let at = if EXACT {
                Phase { q: q.at(*h, &slope.q), p: p.at(*h, &slope.p) }
            } else {
                Phase { q: q.near(*h, &slope.q), p: p.near(*h, &slope.p) }
            };
            let t = *t + *h * T::C[i].to();
            new[i] = Sys::Scalar::evaluate(Rate { system: *system, at, t });
        }
        new
    }
}

type Outcome<S, const N: usize, const K: usize> =
    Result<(State<S, N>, MethodState<S, N, K>, u32), Failure<S>>;

#[cfg_attr(not(debug_assertions), inline(always))]
fn step<T: Collocation<K>, Sys: LegendreTransform<N>, const K: usize, const N: usize>(
    system: &Sys,
    memory: &MethodState<Sys::Scalar, N, K>,
    from: &State<Sys::Scalar, N>,
    h: Sys::Scalar,
) -> Outcome<Sys::Scalar, N, K>
where
    Sys::Scalar: SimdScalar,
{
    let start = Phase { q: from.q, p: memory.p };
    let here = Phase { q: from.qd, p: system.momentum_rate(&from.q, &from.qd, from.t) };
    let [q, p] = [Sum { value: start.q, rest: memory.rest.q }, Sum { value: start.p, rest: memory.rest.p }];
    let mut stages = Stages { system, t: from.t, h, q, p };
    let mut rates = memory.guess(&here, h, &T::C);
    let mut stagnation = Sys::Scalar::each(|_| Stagnation::new());
    let mut iteration = Iteration::<Sys::Scalar>::new();
    let mut iterations = 0;
    while iteration.goes_on() {
        let (old, new) = (rates, stages.sweep::<T, false, K>(&rates));
        iterations += 1;
        for i in 0..K {
            rates[i] = Phase {
                q: chosen(iteration.on(), &new[i].q, &old[i].q),
                p: chosen(iteration.on(), &new[i].p, &old[i].p),
            };
        }
        let changes = relative_change(&start, h, &old, &new).apart();
        iteration.decide(|i| {
            let change = changes.as_ref()[i].to_f64();
            if change.is_nan() {
                Progress::Failed
            } else if stagnation.as_mut()[i].reached(change, ROUNDING * Number::<Sys, N>::EPSILON) {
                Progress::Done
            } else {
                Progress::On
            }
        });
        if iteration.failed() {
            return Err(diverged(system, from, h, iterations));
        }
        if iterations == MOST_ITERATIONS {
            iteration.give_up();
            if iteration.failed() {
                return Err(Failure::NotConverged { t: from.t, h, iterations });
            }
        }
    }

    // From somewhere near, twice more.
    for rate in &mut rates {
        *rate = Phase { q: forgetful(&rate.q), p: forgetful(&rate.p) };
    }
    for _ in 0..2 {
        rates = stages.sweep::<T, true, K>(&rates);
        iterations += 1;
    }
    for i in 0..K {
        let weighted = Phase::zero().plus_scaled(T::B[i].to(), &rates[i]);
        stages.q.add_product(h, &weighted.q);
        stages.p.add_product(h, &weighted.p);
    }
    let Stages { q, p, .. } = stages;
    let t = from.t + h;
    let qd = iteration.result(&system.velocities(&q.value, &p.value, t));
    let rest = Phase { q: q.rest, p: p.rest };
    let memory = MethodState { p: p.value, rest, rates, h };
    Ok((State { t, q: q.value, qd }, memory, iterations * K as u32 + 1))
}

/// One of the numbers of a system.
type Number<Sys, const N: usize> = <<Sys as System<N>>::Scalar as SimdScalar>::Element;

/// Change of the increments by an iteration, over the size of the variables; NaN where something is not finite.
#[cfg_attr(not(debug_assertions), inline(always))]
fn relative_change<S: SimdScalar, const N: usize, const K: usize>(
    start: &Phase<S, N>,
    h: S,
    old: &[Phase<S, N>; K],
    new: &[Phase<S, N>; K],
) -> S::Sizes {
    let [mut q, mut p] = [[S::Sizes::zero(); 2]; 2];
    for n in 0..N {
        for i in 0..K {
            q = widest(q, start.q[n], h, old[i].q[n], new[i].q[n]);
            p = widest(p, start.p[n], h, old[i].p[n], new[i].p[n]);
        }
    }
    let (q, p) = (over(q[0], q[1]), over(p[0], p[1]));
    larger(q, p) + (q + p) * S::Sizes::zero()
}

/// The sum of changes and the largest size, with those of one more variable.
#[inline(always)]
fn widest<S: SimdScalar>([change, size]: [S::Sizes; 2], start: S, h: S, old: S, new: S) -> [S::Sizes; 2] {
    let along = start.magnitudes() + (h * new).magnitudes();
    [change + (h * (new - old)).magnitudes(), larger(size, along)]
}

#[cfg(test)]
mod tests;
