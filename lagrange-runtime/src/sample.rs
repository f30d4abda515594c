//! Samples of a run: states at given times, or the last one.

use crate::controller::Controller;
use crate::failed::Failed;
use crate::failure::Failure;
use crate::integrate::{Drive, Number, Run, Statistics};
use crate::method::{Interpolant, Method, Step};
use crate::scalar::{DoubleDouble, Real, Scalar};
use crate::state::State;
use crate::system::System;

impl<Sys, M, C, const N: usize> Run<'_, Sys, M, C, N>
where
    Sys: System<N>,
    Sys::Scalar: Real,
    M: Method<Sys, N>,
    C: Controller<Sys::Scalar, N, M::Error>,
{
    /// Runs to the end, which [`until`](Self::until) must have set, and gives the state there. The cost can be read
    /// after [`run_to_end`](Self::run_to_end).
    ///
    /// It searches for no events, not even the terminal ones of the system: the motion continues through them to the
    /// end. `run.events(Ball::GROUND).final_state()` ends at the event `ground` of the system.
    pub fn final_state(mut self) -> Result<State<Sys::Scalar, N>, Failed<Sys::Scalar, N>> {
        self.exhaust()?;
        Ok(*self.state())
    }

    /// Runs to the end, where [`state`](Self::state) and [`statistics`](Self::statistics) can be read.
    pub fn run_to_end(&mut self) -> Result<(), Failed<Sys::Scalar, N>> {
        self.exhaust()
    }

    /// Inlined, so that the run that [`final_state`](Self::final_state) owns can live in registers.
    #[inline(always)]
    fn exhaust(&mut self) -> Result<(), Failed<Sys::Scalar, N>> {
        if self.end().is_some() {
            while let Some(Ok(_)) = self.step(None) {}
        }
        self.outcome()
    }

    /// The states at the given times t, which lie in the direction of the run from the start (which may be the first)
    /// to the end (which may be the last). They are interpolated and do not influence the steps; the start, the end
    /// and the ends of steps are exact. A run without end goes as far as the times do. Where the run fails, the
    /// samples before are good, and the failure comes in place of the next one.
    ///
    /// ```
    /// use lagrange_runtime::prelude::*;
    /// # struct Oscillator;
    /// # impl System<1> for Oscillator {
    /// #     type Scalar = f64;
    /// #     fn accel(&self, q: &SVector<f64, 1>, _: &SVector<f64, 1>, _: f64) -> SVector<f64, 1> {
    /// #         -q
    /// #     }
    /// # }
    /// let run = integrate(&Oscillator, Dop853, PiController::tolerance(1e-12), State::new(0.0, [1.0], [0.0]));
    /// for state in run.sample((0..100).map(|k| 0.1 * f64::from(k))) {
    ///     let state = state?;
    ///     assert!((state.q[0] - state.t.cos()).abs() < 1e-9);
    /// }
    /// # Ok::<(), Failure>(())
    /// ```
    pub fn sample<T>(self, times: T) -> Samples<Self, T::IntoIter, N>
    where
        T: IntoIterator<Item = Sys::Scalar>,
    {
        Samples::new(self, times)
    }

    /// The states at `n + 1` times that divide the run, from its start to the end given by [`until`](Self::until),
    /// into `n` equal parts; both ends are exact, and `tₖ = t₀ + k (end − t₀)/n` is computed anew for each k, with
    /// the digits of the scalar.
    ///
    /// # Hypotheses
    /// - The run has an end; else there is one sample, [`Failure::BadEnd`].
    ///
    /// ```
    /// use lagrange_runtime::prelude::*;
    /// # struct Oscillator;
    /// # impl System<1> for Oscillator {
    /// #     type Scalar = f64;
    /// #     fn accel(&self, q: &SVector<f64, 1>, _: &SVector<f64, 1>, _: f64) -> SVector<f64, 1> {
    /// #         -q
    /// #     }
    /// # }
    /// let run = integrate(&Oscillator, Dop853, PiController::tolerance(1e-9), State::new(0.0, [1.0], [0.0])).until(1.0);
    /// let states: Vec<_> = run.sample_evenly(4).collect::<Result<_, _>>()?;
    /// assert_eq!(states.iter().map(|state| state.t).collect::<Vec<_>>(), [0.0, 0.25, 0.5, 0.75, 1.0]);
    /// # Ok::<(), Failure>(())
    /// ```
    pub fn sample_evenly(self, n: u32) -> Samples<Self, Evenly<Sys::Scalar>, N> {
        let (start, end) = (self.state().t, self.end());
        let refused = if end.is_none() { Some(Failure::BadEnd { end: None }) } else { None };
        // A run that ends where it begins has one state.
        let n = if end == Some(start) { 0 } else { n };
        Samples { refused, ..self.sample(Evenly { start, end: end.unwrap_or(start), n, next: Some(0) }) }
    }
}

/// Times that divide an interval into equal parts, made by [`Run::sample_evenly`].
#[derive(Clone, Debug)]
pub struct Evenly<S> {
    start: S,
    end: S,
    n: u32,
    next: Option<u32>,
}

impl<S: Scalar> Iterator for Evenly<S> {
    type Item = S;

    fn next(&mut self) -> Option<S> {
        let k = self.next?;
        self.next = if k < self.n { Some(k + 1) } else { None };
        Some(if k == 0 {
            self.start
        } else if k == self.n {
            self.end
        } else {
            let fraction = DoubleDouble::from(f64::from(k)) / f64::from(self.n);
            (self.end - self.start).mul_add(fraction.to(), self.start)
        })
    }
}

/// The states of a run, or of a stepper, at given times, made by [`Run::sample`]. After a failure it yields the
/// failure once and ends.
#[must_use = "it makes no step unless it is iterated over, or run to its end"]
pub struct Samples<D: Drive<N>, T, const N: usize> {
    run: D,
    times: T,
    step: Option<Step<D::System, D::Method, N>>,
    /// The interpolant of `step`, once a sample has asked for it.
    dense: Option<<D::Method as Method<D::System, N>>::Interpolant>,
    previous: Number<D, N>,
    first: bool,
    /// The failure for which there can be no samples.
    refused: Option<Failure<Number<D, N>>>,
    failed: bool,
}

impl<D: Drive<N>, T: Iterator<Item = Number<D, N>>, const N: usize> Samples<D, T, N> {
    pub(crate) fn new(run: D, times: impl IntoIterator<IntoIter = T>) -> Self {
        let previous = run.state().t;
        let times = times.into_iter();
        Samples { run, times, step: None, dense: None, previous, first: true, refused: None, failed: false }
    }

    /// The cost so far.
    pub fn statistics(&self) -> Statistics {
        self.run.statistics()
    }

    fn state_at(&mut self, t: Number<D, N>) -> Result<State<Number<D, N>, N>, Failure<Number<D, N>>> {
        let forward = self.run.forward()?;
        let after = |a: Number<D, N>, b: Number<D, N>| if forward { a > b } else { a < b };
        if !(after(t, self.previous) || (self.first && t == self.previous)) {
            return Err(Failure::SampleOrder { t, previous: self.previous });
        }
        (self.previous, self.first) = (t, false);
        while after(t, self.run.state().t) {
            let end = self.run.state().t;
            self.step = Some(self.run.advance().ok_or(Failure::SampleBeyondEnd { t, end })??);
            self.dense = None;
        }
        let state = match &self.step {
            Some(step) if t != step.to.t => {
                let run = &mut self.run;
                let state = self.dense.get_or_insert_with(|| run.interpolant(step)).at(t);
                run.on_constraints(state)?
            }
            _ => *self.run.state(),
        };
        if let Some(step) = &self.step {
            self.run.engine().known(self.run.system(), &step.from, &state)?;
        }
        Ok(state)
    }
}

impl<D: Drive<N>, T: Iterator<Item = Number<D, N>>, const N: usize> Iterator for Samples<D, T, N> {
    type Item = Result<State<Number<D, N>, N>, Failure<Number<D, N>>>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.failed {
            return None;
        }
        let state = match self.refused {
            Some(failure) => Some(Err(failure)),
            None => self.times.next().map(|t| self.state_at(t)),
        };
        self.failed = matches!(state, Some(Err(_)));
        state
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `tₖ = t₀ + k (end − t₀)/n` has the digits of the scalar.
    #[test]
    fn times_between_have_all_digits() {
        let of = DoubleDouble::from;
        let times = Evenly { start: of(1.0), end: of(8.0), n: 7 * 3, next: Some(0) };
        for (k, time) in times.enumerate() {
            let missed = (time - of(1.0)) * 3.0 - of(k as f64);
            assert!(missed.value().abs() < 1e-30, "{k}: {missed:?}");
        }
    }
}
