//! Runge–Kutta–Nyström pairs for `q̈ = a(q, t)`: forces that do not depend on the velocities.
//!
//! `kᵢ = a(q₀ + cᵢ h q̇₀ + h² Σⱼ aᵢⱼ kⱼ, t₀ + cᵢ h)`, `q₁ = q₀ + h q̇₀ + h² Σᵢ bᵢ kᵢ`, `q̇₁ = q̇₀ + h Σᵢ b′ᵢ kᵢ`
//! (Hairer, Nørsett, Wanner, *Solving Ordinary Differential Equations I*, 1993, II.14, eq. 14.7). As stages need no
//! velocities, there are fewer conditions, and fewer evaluations for the same order: 5 for order 6, 8 for order 8, 17
//! for order 12. As with [`explicit_rk`](super::explicit_rk), the last row of every tableau is b, so that the last
//! stage is the first one of the next step, and the stages are written out.
//!
//! A new method is a new row. It is tested for the order conditions of all Nyström trees up to its order.

use super::Interpolant;
use crate::scalar::Scalar;
use crate::state::{State, constant};
use nalgebra::SVector;

/// The coefficients of a Runge–Kutta–Nyström pair with `K` stages, the last of which is at the end of the step.
pub trait NystromTableau<const K: usize> {
    /// Name and source.
    const NAME: &'static str;
    /// Order of convergence.
    const ORDER: u32;
    /// `aᵢⱼ`, the last row being b.
    const A: [[f64; K]; K];
    /// `cᵢ`, the last one being 1.
    const C: [f64; K];
    /// `b′ᵢ`.
    const VELOCITY: [f64; K];
    /// `bᵢ` and `b′ᵢ` less those of the embedded formula.
    const ERROR: [[f64; K]; 2];
}

/// A row of coefficients filled up with zeros.
const fn fill<const K: usize>(row: &[f64]) -> [f64; K] {
    let mut full = [0.0; K];
    let mut j = 0;
    while j < row.len() {
        full[j] = row[j];
        j += 1;
    }
    full
}

/// `start + Σⱼ (factor aⱼ) kⱼ` written out, so that zero coefficients vanish and the others become immediate operands.
macro_rules! add {
    ($start:expr, $factor:expr, $k:expr; $($a:expr),*) => {{
        let (mut total, mut j) = ($start, 0);
        $(
            if exact!($a).hi != 0.0 {
                total = add_scaled(&total, $factor * exact!($a).to(), &$k[j]);
            }
            j += 1;
        )*
        let _ = j;
        total
    }};
}

macro_rules! tableaux {
    ($(
        $(#[$doc:meta])*
        $name:ident($stages:literal stages, order $order:literal, $source:literal) {
            $($i:literal, $c:expr => [$($a:expr),*];)*
            velocity [$($v:expr),*];
            error q [$($eq:expr),*];
            error qd [$($eqd:expr),*];
            dense $dense:ident $($coefficients:tt)*
        }
    )*) => {$(
        $(#[$doc])*
        ///
        /// # Hypotheses
        /// - T(q̇) + V(q, t) splits ([`Facts::separable`](crate::Facts::separable)): rustc rejects other systems.
        /// - Accelerations are smooth within a step. Adaptive runs end steps at the switches that the compiler knows;
        ///   steps of one size go over them, with an error of order h where forces jump and h² where they have a
        ///   kink.
        /// - Forces act for a step at least, see [forces that set in later](crate::method#forces-that-set-in-later).
        /// - Steps are as short as stability makes them: a stiff system uses up the budget,
        ///   [`Failure::BudgetUsedUp`](crate::Failure::BudgetUsedUp).
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
        #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct $name;

        impl NystromTableau<$stages> for $name {
            const NAME: &'static str = concat!(stringify!($name), ", ", $source);
            const ORDER: u32 = $order;
            const A: [[f64; $stages]; $stages] = [fill(&[]), $(fill(&[$($a),*])),*];
            const C: [f64; $stages] = [0.0, $($c),*];
            const VELOCITY: [f64; $stages] = fill(&[$($v),*]);
            const ERROR: [[f64; $stages]; 2] = [fill(&[$($eq),*]), fill(&[$($eqd),*])];
        }

        impl $name {
            /// `aᵢⱼ` with all digits, for interpolants that need b.
            #[allow(dead_code)]
            const DIGITS: [&[DoubleDouble]; $stages] = [&[], $(&exact_row![$($a),*]),*];
        }

        impl<Sys: Separable<N>, const N: usize> Method<Sys, N> for $name
        where
            Sys::Scalar: SimdScalar,
        {
            /// The accelerations where the step begins.
            type MethodState = SVector<Sys::Scalar, N>;
            /// The accelerations at the stages.
            type InterpolantData = [SVector<Sys::Scalar, N>; $stages];
            type Error = Tangent<Sys::Scalar, N>;
            type Interpolant = tableaux!(@dense_type $dense $($coefficients)*);

            fn order(&self) -> u32 {
                $order
            }

            fn start(
                &self,
                system: &Sys,
                at: &State<Sys::Scalar, N>,
            ) -> Result<Self::MethodState, Failure<Sys::Scalar>> {
                accelerations(system, at)
            }

            #[cfg_attr(not(debug_assertions), inline(always))]
            #[allow(unused_assignments)]
            fn step_into(
                &self,
                system: &Sys,
                memory: &Self::MethodState,
                from: &State<Sys::Scalar, N>,
                h: Sys::Scalar,
                next: &mut Self::MethodState,
            ) -> Result<Step<Sys, Self, N>, Failure<Sys::Scalar>> {
                let (mut k, mut q) = ([*memory; $stages], from.q);
                let h2 = h * h;
                $(
                    let time = h * exact!($c).to();
                    q = add!(add_scaled(&from.q, time, &from.qd), h2, k; $($a),*);
                    // The velocity plays no part in the accelerations of a separable system.
                    k[$i] = system.accel(&q, &from.qd, from.t + time);
                )*
                let to = State { t: from.t + h, q, qd: add!(from.qd, h, k; $($v),*) };
                let zero = constant(Sys::Scalar::zero());
                let error = Tangent { q: add!(zero, h2, k; $($eq),*), qd: add!(zero, h, k; $($eqd),*) };
                *next = k[$stages - 1];
                Ok(Step { from: *from, to, h, error, stages: k, evaluations: $stages - 1 })
            }

            #[inline(always)]
            fn interpolant(&self, system: &Sys, step: &Step<Sys, Self, N>) -> Self::Interpolant {
                tableaux!(@dense $dense system, step; $($coefficients)*)
            }

            #[inline(always)]
            fn coarse_interpolant(&self, system: &Sys, step: &Step<Sys, Self, N>) -> Option<Self::Interpolant> {
                let _ = (system, step);
                tableaux!(@coarse $dense system, step; $($coefficients)*)
            }

            #[inline(always)]
            fn end_accelerations(&self, step: &Step<Sys, Self, N>) -> Option<[SVector<Sys::Scalar, N>; 2]> {
                Some([step.stages[0], step.stages[$stages - 1]])
            }

            fn interpolant_evaluations(&self, dense: &Self::Interpolant) -> u32 {
                dense.evaluations()
            }
        }
    )*

        /// `check!(method)` for every tableau.
        #[cfg(test)]
        macro_rules! for_each_nystrom {
            ($check:ident) => { $( $check::<$name, $stages>(); )* };
        }
    };

    (@dense_type birkhoff $passes:literal $coarse:literal) => { Birkhoff<Sys::Scalar, N> };
    (@dense_type stages $terms:tt) => { Birkhoff<Sys::Scalar, N, 8> };
    (@dense_type power { $([$($d:expr),*];)* }) => { Power<Sys::Scalar, N> };

    (@dense birkhoff $system:ident, $step:ident; $passes:literal $coarse:literal) => {
        Birkhoff::new($system, tableaux!(@quintic $step), $passes)
    };
    (@coarse birkhoff $system:ident, $step:ident; $passes:literal $coarse:literal) => {
        Some(Birkhoff::new($system, tableaux!(@quintic $step), $coarse))
    };
    (@dense stages $system:ident, $step:ident; $terms:tt) => {{
        let mut dense = tableaux!(@by_stages $step; $terms);
        dense.improve($system);
        dense.improve($system);
        dense
    }};
    (@coarse stages $system:ident, $step:ident; $terms:tt) => { Some(tableaux!(@by_stages $step; $terms)) };
    (@by_stages $step:ident; { $($i:literal, $c:expr => [$($weight:expr),*];)* }) => {{
        let mut dense = Birkhoff::of(tableaux!(@quintic $step));
        $(dense.add(exact!($c), &$step.stages[$i], &exact_row![$($weight),*]);)*
        dense
    }};
    (@dense power $system:ident, $step:ident; { $([$($d:expr),*];)* }) => {{
        let _ = $system;
        let zero = constant(Sys::Scalar::zero());
        let h2 = $step.h * $step.h;
        Power { from: $step.from, h: $step.h, p: [$(add!(zero, h2, $step.stages; $($d),*)),*] }
    }};
    (@coarse power $system:ident, $step:ident; $coefficients:tt) => { None };

    (@quintic $step:ident) => {{
        let (Step { from, to, h, stages, .. }, [.., b]) = ($step, Self::DIGITS);
        let [first, .., last] = stages;
        let increment = stages.iter().zip(b).fold(from.qd * *h, |sum, (k, b)| {
            add_scaled(&sum, *h * *h * b.to(), k)
        });
        Hermite::by_increment(from, increment, &to.qd, *h, first, last)
    }};
}

/// `q(θ) = q₀ + θ h q̇₀ + θ² (p₀ + p₁ θ + … + p₄ θ⁴)` with `θ = (t − t₀)/h`, and its derivative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Power<S, const N: usize> {
    from: State<S, N>,
    h: S,
    p: [SVector<S, N>; 5],
}

impl<S, const N: usize> Power<S, N> {
    /// It takes no evaluations.
    fn evaluations(&self) -> u32 {
        0
    }
}

impl<S: Scalar, const N: usize> Interpolant<S, N> for Power<S, N> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn at(&self, t: S) -> State<S, N> {
        let theta = (t - self.from.t) / self.h;
        let (mut value, mut slope) = (constant(S::zero()), constant(S::zero()));
        for (k, p) in self.p.iter().enumerate().rev() {
            value = value * theta + p;
            slope = slope * theta + p * S::from_f64((k + 2) as f64);
        }
        State {
            t,
            q: self.from.q + (self.from.qd * self.h + value * theta) * theta,
            qd: self.from.qd + slope * (theta / self.h),
        }
    }
}

#[macro_use]
mod rows;

pub use rows::{Nystrom6, Nystrom8, Nystrom12};

#[cfg(test)]
mod tests;
