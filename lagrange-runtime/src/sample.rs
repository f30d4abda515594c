//! What is usually wanted of a run instead of its steps: states at given times, or the last one.

use crate::controller::Controller;
use crate::failure::Failure;
use crate::integrate::{Run, Statistics};
use crate::method::{Dense, Method, Step};
use crate::scalar::Real;
use crate::state::State;
use crate::system::System;
use core::fmt;

/// A run that did not reach its end: why, and how far it came.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Failed<S, const N: usize> {
    /// What went wrong.
    pub failure: Failure<S>,
    /// The last good state.
    pub last: State<S, N>,
    /// The cost so far.
    pub statistics: Statistics,
}

impl<S: fmt::Debug, const N: usize> fmt::Display for Failed<S, N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} (the last good state is at t = {:?})", self.failure, self.last.t)
    }
}

impl<S: fmt::Debug, const N: usize> core::error::Error for Failed<S, N> {}

impl<S, const N: usize> From<Failed<S, N>> for Failure<S> {
    fn from(failed: Failed<S, N>) -> Self {
        failed.failure
    }
}

impl<'a, Sys, M, C, const N: usize> Run<'a, Sys, M, C, N>
where
    Sys: System<N>,
    Sys::Scalar: Real,
    M: Method<Sys, N>,
    C: Controller<Sys::Scalar, N, M::Error>,
{
    /// Runs to the end and gives the state there, which [`until`](Self::until) must have set.
    pub fn finish(mut self) -> Result<State<Sys::Scalar, N>, Failed<Sys::Scalar, N>> {
        self.run_out()?;
        Ok(*self.state())
    }

    /// Runs to the end, where [`state`](Self::state) and [`statistics`](Self::statistics) can be read.
    pub fn run_out(&mut self) -> Result<(), Failed<Sys::Scalar, N>> {
        let failure = match self.end() {
            None => Some(Failure::BadEnd { end: None }),
            Some(_) => {
                self.by_ref().for_each(drop);
                self.failure()
            }
        };
        match failure {
            Some(failure) => Err(Failed { failure, last: *self.state(), statistics: self.statistics() }),
            None => Ok(()),
        }
    }

    /// The states at the given times, which lie in the direction of the run from the start (which may be the first) to
    /// the end (which may be the last). They are interpolated and do not influence the steps; the start, the end and
    /// the ends of steps are exact. A run without end goes as far as the times do.
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
    /// let run = integrate(&Oscillator, Dop853, Pi::tolerance(1e-12), State::new(0.0, [1.0], [0.0]));
    /// for state in run.sample((0..100).map(|k| 0.1 * f64::from(k))) {
    ///     let state = state?;
    ///     assert!((state.q[0] - state.t.cos()).abs() < 1e-9);
    /// }
    /// # Ok::<(), Failure>(())
    /// ```
    pub fn sample<T>(self, times: T) -> Samples<'a, Sys, M, C, T::IntoIter, N>
    where
        T: IntoIterator<Item = Sys::Scalar>,
    {
        let previous = self.state().t;
        Samples {
            run: self,
            times: times.into_iter(),
            step: None,
            dense: None,
            previous,
            first: true,
            failed: false,
        }
    }
}

/// The states of a run at given times, made by [`Run::sample`]. After a failure it yields the failure once and ends.
pub struct Samples<'a, Sys: System<N>, M: Method<Sys, N>, C, T, const N: usize> {
    run: Run<'a, Sys, M, C, N>,
    times: T,
    step: Option<Step<Sys, M, N>>,
    /// The interpolant of `step`, once a sample has asked for it.
    dense: Option<M::Dense>,
    previous: Sys::Scalar,
    first: bool,
    failed: bool,
}

impl<Sys, M, C, T, const N: usize> Samples<'_, Sys, M, C, T, N>
where
    Sys: System<N>,
    Sys::Scalar: Real,
    M: Method<Sys, N>,
    C: Controller<Sys::Scalar, N, M::Error>,
{
    /// The cost so far.
    pub fn statistics(&self) -> Statistics {
        self.run.statistics()
    }

    fn state_at(&mut self, t: Sys::Scalar) -> Result<State<Sys::Scalar, N>, Failure<Sys::Scalar>> {
        let forward = self.run.forward()?;
        let after = |a: Sys::Scalar, b: Sys::Scalar| if forward { a > b } else { a < b };
        if !(after(t, self.previous) || (self.first && t == self.previous)) {
            return Err(Failure::SampleOrder { t, previous: self.previous });
        }
        (self.previous, self.first) = (t, false);
        while after(t, self.run.state().t) {
            let end = self.run.state().t;
            self.step = Some(self.run.next().ok_or(Failure::SampleBeyondEnd { t, end })??);
            self.dense = None;
        }
        match &self.step {
            Some(step) if t != step.to.t => {
                let run = &mut self.run;
                Ok(self.dense.get_or_insert_with(|| run.dense(step)).at(t))
            }
            _ => Ok(*self.run.state()),
        }
    }
}

impl<Sys, M, C, T, const N: usize> Iterator for Samples<'_, Sys, M, C, T, N>
where
    Sys: System<N>,
    Sys::Scalar: Real,
    M: Method<Sys, N>,
    C: Controller<Sys::Scalar, N, M::Error>,
    T: Iterator<Item = Sys::Scalar>,
{
    type Item = Result<State<Sys::Scalar, N>, Failure<Sys::Scalar>>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.failed {
            return None;
        }
        let state = self.times.next().map(|t| self.state_at(t));
        self.failed = matches!(state, Some(Err(_)));
        state
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::controller::{Fixed, Pi};
    use crate::integrate::integrate;
    use crate::method::explicit_rk::{Dop853, Rk4};
    use crate::testing::bank::*;
    use crate::testing::distance;

    fn run(system: &Plane) -> Run<'_, Plane, Dop853, Pi, 2> {
        integrate(system, Dop853, Pi::tolerance(1e-11), ELLIPSE)
    }

    #[test]
    fn samples_lie_on_the_orbit_and_at_their_times() {
        let system = Plane::default();
        for direction in [1.0, -1.0] {
            let times = (0..=100).map(|k| direction * 0.2 * f64::from(k));
            let end = direction * 20.0;
            let states: Vec<_> =
                run(&system).until(end).sample(times.clone()).collect::<Result<_, _>>().unwrap();
            assert!(states.iter().map(|state| state.t).eq(times));
            assert!(states.iter().all(|state| distance(state, &ellipse(state.t)) < 1e-8));
            assert_eq!(states[0], ELLIPSE);
            assert_eq!(states[100], run(&system).until(end).finish().unwrap());
        }
    }

    #[test]
    fn sampling_does_not_influence_the_steps_and_is_paid_where_used() {
        let system = Plane::default();
        let mut plain = run(&system).until(20.0);
        plain.run_out().unwrap();
        let mut samples = run(&system).until(20.0).sample([1.0, 20.0]);
        assert_eq!(samples.by_ref().last().unwrap().unwrap(), *plain.state());
        assert_eq!(samples.statistics().accepted, plain.statistics().accepted);
        assert_eq!(samples.statistics().evaluations, plain.statistics().evaluations + 3);
    }

    #[test]
    fn ends_of_fixed_steps_are_exact_samples() {
        let system = Plane::default();
        let steps =
            integrate(&system, Rk4, Fixed::new(0.25), ELLIPSE).until(1.0).map(|step| step.unwrap().to);
        let samples =
            integrate(&system, Rk4, Fixed::new(0.25), ELLIPSE).until(1.0).sample([0.25, 0.5, 0.75, 1.0]);
        assert!(steps.eq(samples.map(Result::unwrap)));
    }

    #[test]
    fn times_have_to_be_in_order_and_within_the_run() {
        let system = Plane::default();
        let last = |times: &[f64]| run(&system).until(1.0).sample(times.iter().copied()).last();
        assert_eq!(last(&[0.5, 0.5]), Some(Err(Failure::SampleOrder { t: 0.5, previous: 0.5 })));
        assert_eq!(last(&[0.5, 0.4, 0.6]), Some(Err(Failure::SampleOrder { t: 0.4, previous: 0.5 })));
        assert_eq!(last(&[-0.1]), Some(Err(Failure::SampleOrder { t: -0.1, previous: 0.0 })));
        assert!(matches!(last(&[f64::NAN]), Some(Err(Failure::SampleOrder { .. }))));
        assert_eq!(last(&[0.5, 1.5]), Some(Err(Failure::SampleBeyondEnd { t: 1.5, end: 1.0 })));
        assert_eq!(last(&[]), None);
        let broken = run(&system).until(f64::NAN).sample([0.5]).last();
        assert!(matches!(broken, Some(Err(Failure::BadEnd { .. }))));
    }

    #[test]
    fn a_failed_run_tells_how_far_it_came() {
        let system = Plane::default();
        let failed = run(&system).until(10.0).max_steps(5).finish().unwrap_err();
        assert!(failed.last.t > 0.0 && failed.statistics.accepted == 5);
        assert!(failed.to_string().contains("the last good state is at t = "));
    }
}
