//! Splitting methods for separable systems `q̈ = a(q, t)`: drifts `q += h q̇` and kicks `q̇ += h a(q, t)` in turn.
//!
//! Each drift and each kick is the exact flow of one part of `H = T(p) + V(q, t)`, hence symplectic, and so is every
//! composition; a symmetric one is of even order (Hairer, Lubich, Wanner, *Geometric Numerical Integration*, 2006,
//! I.1.4, II.5, VI.3). Time drifts with q.

use super::hermite::Hermite;
use super::newton::accelerations;
use super::{Method, Step};
use crate::controller::NoEstimate;
use crate::failure::Failure;
use crate::scalar::{Scalar, SimdScalar};
use crate::state::{State, add_scaled};
use crate::system::Separable;
use nalgebra::SVector;

mod blanes_moan;

pub use blanes_moan::{BlanesMoan4, BlanesMoan6};

/// Störmer–Verlet in its kick–drift–kick form ("velocity Verlet"): order 2, symplectic, time-symmetric, one evaluation
/// per step (Verlet 1967, Swope et al. 1982):
///
/// `q̇ₕ = q̇₀ + h/2 a(q₀, t₀)`, `q₁ = q₀ + h q̇ₕ`, `q̇₁ = q̇ₕ + h/2 a(q₁, t₁)`.
///
/// # Hypotheses
/// - T(q̇) + V(q, t) splits ([`Facts::separable`](crate::Facts::separable)): rustc rejects other systems.
/// - Steps are of one size: rustc rejects [`PiController`](crate::PiController), since there is no estimate of the
///   error.
/// - Accelerations are smooth within a step. Adaptive runs end steps at the switches that the compiler knows; steps
///   of one size go over them, with an error of order h where forces jump and h² where they have a kink.
/// - h times the highest frequency is below 2: beyond it motions grow without a word.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Verlet;

/// Störmer–Verlet in its drift–kick–drift form ("position Verlet", the leapfrog of Tuckerman et al. 1992): order 2,
/// symplectic, time-symmetric, one evaluation per step:
///
/// `qₕ = q₀ + h/2 q̇₀`, `q̇₁ = q̇₀ + h a(qₕ, t₀ + h/2)`, `q₁ = qₕ + h/2 q̇₁`.
///
/// # Hypotheses
/// - T(q̇) + V(q, t) splits ([`Facts::separable`](crate::Facts::separable)): rustc rejects other systems.
/// - Steps are of one size: rustc rejects [`PiController`](crate::PiController), since there is no estimate of the
///   error.
/// - Accelerations are smooth within a step. Adaptive runs end steps at the switches that the compiler knows; steps
///   of one size go over them, with an error of order h where forces jump and h² where they have a kink.
/// - h times the highest frequency is below 2: beyond it motions grow without a word.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PositionVerlet;

impl<Sys: Separable<N>, const N: usize> Method<Sys, N> for Verlet
where
    Sys::Scalar: SimdScalar,
{
    /// The accelerations where the step begins.
    type MethodState = SVector<Sys::Scalar, N>;
    /// The accelerations at both ends.
    type InterpolantData = [SVector<Sys::Scalar, N>; 2];
    type Error = NoEstimate;
    type Interpolant = Hermite<Sys::Scalar, N>;

    fn order(&self) -> u32 {
        2
    }

    fn start(
        &self,
        system: &Sys,
        at: &State<Sys::Scalar, N>,
    ) -> Result<Self::MethodState, Failure<Sys::Scalar>> {
        accelerations(system, at)
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
        let half = h * Sys::Scalar::from_f64(0.5);
        let t = from.t + h;
        let halfway = add_scaled(&from.qd, half, memory);
        let q = add_scaled(&from.q, h, &halfway);
        *next = system.accel(&q, &halfway, t);
        let to = State { t, q, qd: add_scaled(&halfway, half, next) };
        Ok(Step { from: *from, to, h, error: NoEstimate, stages: [*memory, *next], evaluations: 1 })
    }

    #[inline(always)]
    fn interpolant(&self, _: &Sys, step: &Step<Sys, Self, N>) -> Self::Interpolant {
        Hermite::new(&step.from, &step.to, step.h, &step.stages[0], &step.stages[1])
    }
}

impl<Sys: Separable<N>, const N: usize> Method<Sys, N> for PositionVerlet
where
    Sys::Scalar: SimdScalar,
{
    type MethodState = ();
    type InterpolantData = ();
    type Error = NoEstimate;
    type Interpolant = Hermite<Sys::Scalar, N>;

    fn order(&self) -> u32 {
        2
    }

    fn start(&self, system: &Sys, at: &State<Sys::Scalar, N>) -> Result<(), Failure<Sys::Scalar>> {
        accelerations(system, at).map(|_| ())
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn step_into(
        &self,
        system: &Sys,
        _: &(),
        from: &State<Sys::Scalar, N>,
        h: Sys::Scalar,
        _: &mut (),
    ) -> Result<Step<Sys, Self, N>, Failure<Sys::Scalar>> {
        let half = h * Sys::Scalar::from_f64(0.5);
        let halfway = add_scaled(&from.q, half, &from.qd);
        let qd = add_scaled(&from.qd, h, &system.accel(&halfway, &from.qd, from.t + half));
        let to = State { t: from.t + h, q: add_scaled(&halfway, half, &qd), qd };
        Ok(Step { from: *from, to, h, error: NoEstimate, stages: (), evaluations: 1 })
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::controller::FixedStep;
    use crate::integrate::integrate;
    use crate::method::Interpolant;
    use crate::scalar::Dual;
    use crate::testing::bank::*;
    use crate::testing::{dense_order_of, distance, energy_drift, order_of, symplecticity_defect};

    #[test]
    fn both_forms_are_of_order_two() {
        let (start, exact) = (ellipse(0.0), ellipse(5.0));
        let steps = [1000, 2000, 4000];
        let kick = order_of(&Plane::default(), &Verlet, &start, &exact, &steps).unwrap();
        let drift = order_of(&Plane::default(), &PositionVerlet, &start, &exact, &steps).unwrap();
        assert!((kick - 2.0).abs() < 0.1 && (drift - 2.0).abs() < 0.1, "{kick} {drift}");
        let kick = dense_order_of(&Plane::default(), &Verlet, ellipse, 5.0, &steps).unwrap();
        let drift = dense_order_of(&Plane::default(), &PositionVerlet, ellipse, 5.0, &steps).unwrap();
        assert!((kick - 2.0).abs() < 0.1 && (drift - 2.0).abs() < 0.1, "{kick} {drift}");
    }

    #[test]
    fn both_forms_are_symplectic() {
        let system = HenonHeiles::<Dual<f64>>::default();
        let at = State::new(0.0, [0.3, -0.1], [0.2, 0.4]);
        for h in [0.01, 0.1, 0.7] {
            assert!(symplecticity_defect(&system, &Verlet, &at, h).unwrap() < 1e-14);
            assert!(symplecticity_defect(&system, &PositionVerlet, &at, h).unwrap() < 1e-14);
        }
    }

    fn returns(method: impl Method<HenonHeiles, 2> + Copy) {
        let (system, start) = (HenonHeiles::default(), State::new(0.0, [0.3, -0.1], [0.2, 0.4]));
        let there = integrate(&system, method, FixedStep::new(0.1), start).until(10.0).final_state().unwrap();
        let back = integrate(&system, method, FixedStep::new(-0.1), there).until(0.0).final_state().unwrap();
        assert!(distance(&start, &back) < 1e-13, "{back:?}");
    }

    #[test]
    fn both_forms_are_time_symmetric() {
        returns(Verlet);
        returns(PositionVerlet);
    }

    /// The energy error stays bounded by O(h²) over a thousand periods: no drift.
    #[test]
    fn energy_is_kept_for_long() {
        let system = Plane::default();
        let drift = |turns: f64| {
            let run = integrate(&system, Verlet, FixedStep::new(0.05), ELLIPSE)
                .until(turns * core::f64::consts::TAU);
            energy_drift(&system, run).unwrap()
        };
        let (short, long) = (drift(1.0), drift(1000.0));
        assert!(short < 1e-3 && long < 1.05 * short, "{short} {long}");
    }

    #[test]
    fn a_step_is_interpolated_through_its_ends() {
        let system = Plane::default();
        let (step, _) = PositionVerlet.step(&system, &(), &ELLIPSE, 0.1).unwrap();
        let dense = PositionVerlet.interpolant(&system, &step);
        assert!(distance(&dense.at(0.0), &step.from) < 1e-15 && distance(&dense.at(0.1), &step.to) < 1e-14);
    }

    /// Stable for hω < 2 (Hairer, Lubich, Wanner 2006, I.5.2): bounded just below, and blowing up just above.
    #[test]
    fn both_forms_are_stable_up_to_two() {
        fn largest(method: impl Method<Chain<f64, 1>, 1> + Copy, h: f64) -> f64 {
            // ω² = 2k = 1.
            let system = Chain { k: 0.5 };
            let run = integrate(&system, method, FixedStep::new(h), State::new(0.0, [1.0], [0.0]));
            run.take(2000).map(|step| step.unwrap().to.q[0].abs()).fold(0.0, f64::max)
        }
        let below = [largest(Verlet, 1.98), largest(PositionVerlet, 1.98)];
        let above = [largest(Verlet, 2.02), largest(PositionVerlet, 2.02)];
        assert!(below.iter().all(|&q| q < 20.0) && above.iter().all(|&q| q > 1e6), "{below:?} {above:?}");
    }
}
