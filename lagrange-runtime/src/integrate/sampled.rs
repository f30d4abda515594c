//! Sampled control: who sets the inputs of a stepper, and when.

use crate::failure::Failure;
use crate::input::Inputs;
use crate::scalar::{Real, Scalar};
use crate::state::State;
use crate::system::System;
use nalgebra::SVector;

/// Times that differ by so many units of the last place are one.
const ROUNDINGS: f64 = 4.0;

/// The shortest period, in units of the last place of the time: instants are further apart than times that are one,
/// and equally far.
const SHORTEST_PERIOD: f64 = 64.0;

/// The largest number of instants: further ones have no number of their own.
const MOST_INSTANTS: f64 = 9_007_199_254_740_992.0;

/// A number of ulps of the time t, or of an origin of times as far from 0 as `scale`.
#[inline(always)]
fn roundings<S: Real>(count: f64, t: S, scale: f64) -> f64 {
    count * S::EPSILON * t.to_f64().abs().max(scale)
}

/// Is `instant` not after the time t, up to rounding?
#[inline(always)]
pub(super) fn reached<S: Real>(instant: S, t: S, scale: f64) -> bool {
    instant <= t || (instant - t).to_f64() <= roundings(ROUNDINGS, t, scale)
}

/// Are these times one, up to rounding?
#[inline(always)]
pub(super) fn coincide<S: Real>(a: S, b: S, scale: f64) -> bool {
    a == b || (reached(a, b, scale) && reached(b, a, scale))
}

/// Sets inputs if they are others than before. Returns whether they are.
pub(super) fn set<Sys: Inputs<N, K>, const N: usize, const K: usize>(
    system: &mut Sys,
    inputs: &SVector<Sys::Scalar, K>,
    t: Sys::Scalar,
) -> Result<bool, Failure<Sys::Scalar>>
where
    Sys::Scalar: Real,
{
    if let Some(k) = (0..K).find(|&k| !inputs[k].to_f64().is_finite()) {
        return Err(Failure::InputNotFinite { t, input: Sys::INPUTS[k] });
    }
    let changed = system.inputs() != *inputs;
    if changed {
        system.set_inputs(inputs);
    }
    Ok(changed)
}

/// Control that sets the inputs of a stepper at its sampling instants: none, `()`, or [`Every`].
pub trait Control<Sys: System<N, Scalar: Real>, const N: usize> {
    /// The next sampling instant.
    fn instant(&self) -> Option<Sys::Scalar>;

    /// The largest distance of an origin of sampling instants from the time 0, by which their rounding is measured.
    fn scale(&self) -> f64;

    /// Sets the inputs at a sampling instant, by the [`scale`](Self::scale) of all controllers. Returns whether they
    /// have changed.
    fn act(
        &mut self,
        state: &State<Sys::Scalar, N>,
        scale: f64,
        system: &mut Sys,
    ) -> Result<bool, Failure<Sys::Scalar>>;

    /// Makes the first sampling instant that is not before t the next one.
    fn seek(&mut self, t: Sys::Scalar);

    /// Fails unless sampling instants from the time t on differ by more than rounding.
    fn check(&self, t: Sys::Scalar) -> Result<(), Failure<Sys::Scalar>>;

    /// Fails if there are more sampling instants up to the time t than can be counted.
    fn counts(&self, t: Sys::Scalar) -> Result<(), Failure<Sys::Scalar>>;
}

impl<Sys: System<N, Scalar: Real>, const N: usize> Control<Sys, N> for () {
    #[inline(always)]
    fn instant(&self) -> Option<Sys::Scalar> {
        None
    }

    #[inline(always)]
    fn scale(&self) -> f64 {
        0.0
    }

    fn act(&mut self, _: &State<Sys::Scalar, N>, _: f64, _: &mut Sys) -> Result<bool, Failure<Sys::Scalar>> {
        Ok(false)
    }

    fn seek(&mut self, _: Sys::Scalar) {}

    fn check(&self, _: Sys::Scalar) -> Result<(), Failure<Sys::Scalar>> {
        Ok(())
    }

    fn counts(&self, _: Sys::Scalar) -> Result<(), Failure<Sys::Scalar>> {
        Ok(())
    }
}

/// Control law in a box: it sets the `K` inputs of a system of `N` coordinates from the state at a sampling instant.
/// It has one type whatever the closure captures, so that a struct can name the type of its stepper, see
/// [`SampledStepper`](super::SampledStepper).
#[cfg(feature = "std")]
pub type ControlLaw<const N: usize, const K: usize, S = f64> =
    Box<dyn FnMut(&State<S, N>, &mut SVector<S, K>) + Send>;

/// Sampled controller, made by [`Stepper::every`](super::Stepper::every), beside `others`.
/// [`SampledStepper`](super::SampledStepper) is the type of a stepper with one of them.
#[derive(Clone, Copy, Debug)]
pub struct Every<S, F, const K: usize, U = ()> {
    origin: S,
    period: S,
    /// The number of the next instant.
    next: f64,
    law: F,
    others: U,
}

impl<S: Scalar, F, const K: usize, U> Every<S, F, K, U> {
    pub(super) fn new(origin: S, period: S, law: F, others: U) -> Self {
        Every { origin, period, next: 0.0, law, others }
    }

    fn own(&self) -> S {
        S::from_f64(self.next).mul_add(self.period, self.origin)
    }

    /// Makes the first instant of its own that is not before t the next one.
    fn seek_own(&mut self, t: S)
    where
        S: Real,
    {
        let ratio = ((t - self.origin) / self.period).to_f64();
        self.next = libm::floor(ratio).max(0.0);
        for _ in 0..2 {
            if !reached(t, self.own(), self.origin.to_f64().abs()) {
                self.next += 1.0;
            }
        }
    }

    /// The same controller after the time t: what was due up to there was done, unless its instants begin at t.
    pub(super) fn after(mut self, t: S) -> Self
    where
        S: Real,
    {
        self.seek_own(t);
        if self.next > 0.0 && reached(self.own(), t, self.origin.to_f64().abs()) {
            self.next += 1.0;
        }
        self
    }

    fn resolved(&self, t: S) -> Result<(), Failure<S>>
    where
        S: Real,
    {
        let period = self.period.to_f64();
        let least = roundings(SHORTEST_PERIOD, t, self.origin.to_f64().abs());
        let resolved =
            period > 0.0 && period.is_finite() && period >= least && self.origin.to_f64().is_finite();
        if resolved { Ok(()) } else { Err(Failure::BadPeriod { t, period: self.period }) }
    }
}

impl<Sys, F, const N: usize, const K: usize, U> Control<Sys, N> for Every<Sys::Scalar, F, K, U>
where
    Sys: Inputs<N, K, Scalar: Real>,
    F: FnMut(&State<Sys::Scalar, N>, &mut SVector<Sys::Scalar, K>),
    U: Control<Sys, N>,
{
    fn instant(&self) -> Option<Sys::Scalar> {
        let own = self.own();
        Some(self.others.instant().filter(|other| *other < own).unwrap_or(own))
    }

    #[inline(always)]
    fn scale(&self) -> f64 {
        self.origin.to_f64().abs().max(self.others.scale())
    }

    fn act(
        &mut self,
        state: &State<Sys::Scalar, N>,
        scale: f64,
        system: &mut Sys,
    ) -> Result<bool, Failure<Sys::Scalar>> {
        let mut changed = false;
        if self.others.instant().is_some_and(|other| reached(other, state.t, scale)) {
            changed |= self.others.act(state, scale, system)?;
        }
        if reached(self.own(), state.t, scale) {
            self.resolved(state.t)?;
            let mut inputs = system.inputs();
            (self.law)(state, &mut inputs);
            changed |= set(system, &inputs, state.t)?;
            self.next += 1.0;
        }
        Ok(changed)
    }

    fn seek(&mut self, t: Sys::Scalar) {
        self.others.seek(t);
        self.seek_own(t);
    }

    fn check(&self, t: Sys::Scalar) -> Result<(), Failure<Sys::Scalar>> {
        self.resolved(t)?;
        self.others.check(t)
    }

    fn counts(&self, t: Sys::Scalar) -> Result<(), Failure<Sys::Scalar>> {
        if ((t - self.origin) / self.period).to_f64() > MOST_INSTANTS {
            return Err(Failure::BadPeriod { t, period: self.period });
        }
        self.others.counts(t)
    }
}
