//! Explicit Runge–Kutta methods: rows of coefficients, and the one step that all of them share.
//!
//! With y = (q, q̇) and f = (q̇, q̈): `kᵢ = f(y₀ + h Σⱼ aᵢⱼ kⱼ, t₀ + cᵢ h)`. The last row of every tableau is b, so
//! that the last "stage" is the derivative at the end of the step: it is the first stage of the next step, whether or
//! not the method's error estimate has a use for it ("first same as last"), and lets every method be interpolated.
//!
//! Coefficients stand there with all their digits, or as quotients, so that scalars of more digits than `f64` have
//! them (`exact!`). A new method is a new row of `explicit_rk/rows.rs`. It is tested for the order conditions of all
//! rooted trees up to its order without further ado.

use super::Interpolant;
use crate::scalar::{DoubleDouble, Scalar};
use crate::state::{State, Tangent};
use crate::system::System;
use nalgebra::SVector;

/// The coefficients of an explicit Runge–Kutta method with `K` stages, the last of which is at the end of the step.
pub trait ButcherTableau<const K: usize> {
    /// Name and source.
    const NAME: &'static str;
    /// Order of convergence.
    const ORDER: u32;
    /// `aᵢⱼ`, the last row being b.
    const A: [[f64; K]; K];
    /// `cᵢ`, the last one being 1.
    const C: [f64; K];
}

/// `Σⱼ aⱼ kⱼ` written out, so that zero coefficients vanish and the others become immediate operands. It begins with
/// −0, to which anything may be added without an addition (0 + −0 is 0).
macro_rules! sum {
    ($k:expr; $($a:expr),*) => {{
        let (mut total, mut j) = (Tangent::zero().scaled(Scalar::from_f64(-1.0)), 0);
        $(
            if exact!($a).hi != 0.0 {
                total = total.plus_scaled(exact!($a).to(), &$k[j]);
            }
            j += 1;
        )*
        let _ = j;
        total
    }};
}

/// `y₀ + Σⱼ (h aⱼ) kⱼ`, the newest stage last: all the rest of the sum is made while that stage is still computed.
macro_rules! add {
    ($from:expr, $h:expr, $k:expr; $($a:expr),*) => {{
        let (mut total, mut j) = (Tangent { q: $from.q, qd: $from.qd }, 0);
        $(
            if exact!($a).hi != 0.0 {
                total = total.plus_scaled($h * exact!($a).to(), &$k[j]);
            }
            j += 1;
        )*
        let _ = j;
        total
    }};
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

macro_rules! tableaux {
    ($(
        $(#[$doc:meta])*
        $name:ident($stages:literal stages, order $order:literal, $source:literal) {
            $($i:literal, $c:expr => [$($a:expr),*];)*
            error $error:ident $([$($e:expr),* $(,)?])*;
            dense $dense:ident $($coefficients:tt)*
        }
    )*) => {$(
        $(#[$doc])*
        ///
        /// # Hypotheses
        /// - Accelerations are smooth within a step. Adaptive runs end steps at the switches that the compiler knows;
        ///   steps of one size go over them, with an error of order h where forces jump and h² where they have a
        ///   kink.
        /// - Forces act for a step at least, see [forces that set in later](crate::method#forces-that-set-in-later).
        /// - M is regular along the motion: otherwise [`Failure::SingularInertia`](crate::Failure::SingularInertia).
        /// - Constraints stay independent: otherwise
        ///   [`Failure::DependentConstraints`](crate::Failure::DependentConstraints).
        /// - Steps are as short as stability makes them: a stiff system uses up the budget,
        ///   [`Failure::BudgetUsedUp`](crate::Failure::BudgetUsedUp).
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
        #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct $name;

        impl $name {
            /// Its stability function R(z), which bounds the size of a stable step.
            pub fn stability() -> StabilityPolynomial<$stages> {
                StabilityPolynomial::of::<$name>()
            }
        }

        impl ButcherTableau<$stages> for $name {
            const NAME: &'static str = concat!(stringify!($name), ", ", $source);
            const ORDER: u32 = $order;
            const A: [[f64; $stages]; $stages] = [fill(&[]), $(fill(&[$($a),*])),*];
            const C: [f64; $stages] = [0.0, $($c),*];
        }

        impl<Sys: System<N>, const N: usize> Method<Sys, N> for $name {
            type MethodState = SVector<Sys::Scalar, N>;
            type InterpolantData = tableaux!(@stages_type $dense $stages);
            type Error = tableaux!(@error_type $error);
            type Interpolant = tableaux!(@dense_type $dense $($coefficients)*);

            fn order(&self) -> u32 {
                $order
            }

            #[inline]
            fn start(
                &self,
                system: &Sys,
                at: &State<Sys::Scalar, N>,
            ) -> Result<Self::MethodState, Failure<Sys::Scalar>> {
                Ok(system.accel(&at.q, &at.qd, at.t))
            }

            // Forced into the time loop: as a call it would write all its stages to memory, where mostly nobody reads
            // them, at up to twice the cost of the whole step.
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
                let (mut k, mut to) = first_stage::<_, N, $stages>(from, memory);
                $((to, k[$i]) = stage(system, from.t, h, exact!($c), add!(from, h, k; $($a),*));)*
                let error = tableaux!(@error $error k, h; $([$($e),*])*);
                *next = k[$stages - 1].qd;
                let stages = tableaux!(@stages $dense $stages k);
                Ok(Step { from: *from, to, h, error, stages, evaluations: $stages - 1 })
            }

            tableaux! {@last_step $error $stages; $($i, $c => [$($a),*];)*}

            #[inline(always)]
            #[allow(unused_assignments, unused_variables, unused_mut)]
            fn interpolant(&self, system: &Sys, step: &Step<Sys, Self, N>) -> Self::Interpolant {
                tableaux!(@dense $dense $stages system, step; $($coefficients)*)
            }

            $crate::method::steps_across! {}

            #[inline(always)]
            fn end_accelerations(&self, step: &Step<Sys, Self, N>) -> Option<[SVector<Sys::Scalar, N>; 2]> {
                Some(tableaux!(@ends $dense $stages step))
            }

            fn interpolant_evaluations(&self, _: &Self::Interpolant) -> u32 {
                tableaux!(@interpolant_evaluations $dense $stages $($coefficients)*)
            }
        }
    )*

        /// `check!(method)` for every tableau.
        #[cfg(test)]
        macro_rules! for_each_tableau {
            ($check:ident) => { $( $check::<$name, $stages>(); )* };
        }
    };

    // The last stage serves the next step and the interpolant alone, where no error is estimated.
    (@last_step none $stages:literal; $($i:literal, $c:expr => [$($a:expr),*];)*) => {
        const HAS_LAST_STEP: bool = true;

        #[cfg_attr(not(debug_assertions), inline(always))]
        #[allow(unused_assignments)]
        fn last_step(
            &self,
            system: &Sys,
            memory: &Self::MethodState,
            from: &State<Sys::Scalar, N>,
            h: Sys::Scalar,
        ) -> Result<Step<Sys, Self, N>, Failure<Sys::Scalar>> {
            let (mut k, mut to) = first_stage::<_, N, $stages>(from, memory);
            $({
                let at = add!(from, h, k; $($a),*);
                if $i < $stages - 1 {
                    (to, k[$i]) = stage(system, from.t, h, exact!($c), at);
                } else {
                    to = State { t: from.t + h, q: at.q, qd: at.qd };
                }
            })*
            let stages = [k[0].qd; 2];
            Ok(Step { from: *from, to, h, error: NoEstimate, stages, evaluations: $stages - 2 })
        }
    };
    (@last_step $error:ident $($rest:tt)*) => {};

    (@error_type none) => { NoEstimate };
    (@error_type embedded) => { Tangent<Sys::Scalar, N> };
    (@error_type two) => { TwoEstimates<Sys::Scalar, N> };

    (@error none $k:ident, $h:ident;) => { NoEstimate };
    (@error embedded $k:ident, $h:ident; [$($e:expr),*]) => { sum!($k; $($e),*).scaled($h) };
    (@error two $k:ident, $h:ident; [$($fifth:expr),*] [$($third:expr),*]) => {
        TwoEstimates { fifth: sum!($k; $($fifth),*).scaled($h), third: sum!($k; $($third),*).scaled($h) }
    };

    // What an interpolant needs of the stages and no more: a step is large enough to copy.
    (@stages_type hermite $stages:literal) => { [SVector<Sys::Scalar, N>; 2] };
    (@stages_type nested $stages:literal) => { [Tangent<Sys::Scalar, N>; $stages] };

    (@stages hermite $stages:literal $k:ident) => { [$k[0].qd, $k[$stages - 1].qd] };
    (@stages nested $stages:literal $k:ident) => { $k };

    (@ends hermite $stages:literal $step:ident) => { $step.stages };
    (@ends nested $stages:literal $step:ident) => { [$step.stages[0].qd, $step.stages[$stages - 1].qd] };

    (@dense_type hermite) => { Hermite<Sys::Scalar, N> };
    (@dense_type nested $terms:literal $($rest:tt)*) => { Nested<Sys::Scalar, N, $terms> };

    (@dense hermite $stages:literal $system:ident, $step:ident;) => {
        Hermite::new(&$step.from, &$step.to, $step.h, &$step.stages[0], &$step.stages[1])
    };
    (@dense nested $stages:literal $system:ident, $step:ident; $terms:literal terms
        { $($c:expr => [$($a:expr),* $(,)?];)* } { $([$($d:expr),* $(,)?];)* }
    ) => {{
        const EXTRA: usize = tableaux!(@count $($c),*);
        let mut k = [$step.stages[0]; $stages + EXTRA];
        k[..$stages].copy_from_slice(&$step.stages);
        let mut i = $stages;
        $(
            k[i] = stage($system, $step.from.t, $step.h, exact!($c), add!(&$step.from, $step.h, k; $($a),*)).1;
            i += 1;
        )*
        let _ = i;
        Nested::new($step.from, &$step.to, $step.h, &k[0], &k[$stages - 1], &[$(sum!(k; $($d),*).scaled($step.h)),*])
    }};

    (@interpolant_evaluations hermite $stages:literal) => { 0 };
    (@interpolant_evaluations nested $stages:literal $terms:literal terms
        { $($c:expr => [$($a:expr),* $(,)?];)* } { $($rows:tt)* }
    ) => { tableaux!(@count $($c),*) };

    (@count) => { 0 };
    (@count $head:expr $(, $tail:expr)*) => { 1 + tableaux!(@count $($tail),*) };
}

/// Room for the stages of a step, with the first one, whose accelerations are the memory, and the state there.
#[cfg_attr(not(debug_assertions), inline(always))]
fn first_stage<S: Scalar, const N: usize, const STAGES: usize>(
    from: &State<S, N>,
    memory: &SVector<S, N>,
) -> ([Tangent<S, N>; STAGES], State<S, N>) {
    ([Tangent { q: from.qd, qd: *memory }; STAGES], *from)
}

/// The state (q, q̇) at `t₀ + c h`, and its derivative.
///
/// The stages of a step are written out and not looped over: measured, this takes 2 to 3 ns off every evaluation of
/// short accelerations (benches/iterator.rs), since the sums then need no table and the stages no memory; and it costs
/// nothing where accelerations are long, since the compiler then calls them instead of copying them into every stage.
#[cfg_attr(not(debug_assertions), inline(always))]
fn stage<Sys: System<N>, const N: usize>(
    system: &Sys,
    t: Sys::Scalar,
    h: Sys::Scalar,
    c: DoubleDouble,
    at: Tangent<Sys::Scalar, N>,
) -> (State<Sys::Scalar, N>, Tangent<Sys::Scalar, N>) {
    let Tangent { q, qd } = at;
    let t = h.mul_add(c.to(), t);
    (State { t, q, qd }, Tangent { q: qd, qd: system.accel(&q, &qd, t) })
}

/// The interpolant of Hairer's codes: `y(θ) = r₀ + θ(r₁ + θ̄(r₂ + θ(r₃ + θ̄(r₄ + …))))`, `θ = (t − t₀)/h`,
/// `θ̄ = 1 − θ`, whose first four terms are the cubic Hermite polynomial and whose others come from the stages.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nested<S, const N: usize, const TERMS: usize> {
    t: S,
    h: S,
    r: [Tangent<S, N>; TERMS],
}

impl<S: Scalar, const N: usize, const TERMS: usize> Nested<S, N, TERMS> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn new(
        from: State<S, N>,
        to: &State<S, N>,
        h: S,
        first: &Tangent<S, N>,
        last: &Tangent<S, N>,
        rest: &[Tangent<S, N>],
    ) -> Self {
        let minus = -S::one();
        let r1 = to.minus(&from);
        let r2 = first.scaled(h).plus_scaled(minus, &r1);
        let r3 = r1.plus_scaled(-h, last).plus_scaled(minus, &r2);
        let mut r = [Tangent { q: from.q, qd: from.qd }; TERMS];
        for (slot, term) in r[1..].iter_mut().zip([r1, r2, r3].iter().chain(rest)) {
            *slot = *term;
        }
        Nested { t: from.t, h, r }
    }
}

impl<S: Scalar, const N: usize, const TERMS: usize> Interpolant<S, N> for Nested<S, N, TERMS> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn at(&self, t: S) -> State<S, N> {
        let theta = (t - self.t) / self.h;
        let factors = [theta, S::one() - theta];
        let mut y = self.r[TERMS - 1];
        for j in (0..TERMS - 1).rev() {
            y = self.r[j].plus_scaled(factors[j % 2], &y);
        }
        State { t, q: y.q, qd: y.qd }
    }
}

#[macro_use]
mod rows;
mod stability;

pub use rows::{Dop853, DormandPrince5, Euler, Heun, Rk4, Tsitouras5, Verner9};
pub use stability::StabilityPolynomial;

#[cfg(test)]
mod tests;
