//! What is usually wanted of a run instead of its steps: states at given times, or the last one.

use crate::controller::Controller;
use crate::failure::Failure;
use crate::integrate::{Run, Statistics};
use crate::method::{Dense, Method, Step};
use crate::scalar::{Real, Scalar};
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
    /// the ends of steps are exact. A run without end goes as far as the times do. Where the run fails, the samples before
    /// are good, and the failure comes in place of the next one.
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
            refused: None,
            failed: false,
        }
    }

    /// The states at `n + 1` times that divide the run, from its start to the end given by [`until`](Self::until), into
    /// `n` equal parts; both ends are exact, and `tₖ = t₀ + k (end − t₀)/n` is computed anew for each k.
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
    /// let run = integrate(&Oscillator, Dop853, Pi::tolerance(1e-9), State::new(0.0, [1.0], [0.0])).until(1.0);
    /// let states: Vec<_> = run.sample_evenly(4).collect::<Result<_, _>>()?;
    /// assert_eq!(states.iter().map(|state| state.t).collect::<Vec<_>>(), [0.0, 0.25, 0.5, 0.75, 1.0]);
    /// # Ok::<(), Failure>(())
    /// ```
    pub fn sample_evenly(self, n: u32) -> Samples<'a, Sys, M, C, Evenly<Sys::Scalar>, N> {
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
            let fraction = S::from_f64(f64::from(k) / f64::from(self.n));
            (self.end - self.start).mul_add(fraction, self.start)
        })
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
    /// Why there can be no samples.
    refused: Option<Failure<Sys::Scalar>>,
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
    use crate::controller::{Fixed, Pi};
    use crate::integrate::integrate;
    use crate::method::explicit_rk::{Dop853, DormandPrince5, Euler, Rk4};
    use crate::method::gauss::{Gauss4, Gauss6, ImplicitMidpoint};
    use crate::method::splitting::{PositionVerlet, Verlet};
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
    fn even_samples_have_both_ends_exact() {
        let system = Plane::default();
        for end in [1.7, -0.3] {
            let states: Vec<_> = run(&system).until(end).sample_evenly(7).map(Result::unwrap).collect();
            assert_eq!((states.len(), states[0]), (8, ELLIPSE));
            assert_eq!(states[7], run(&system).until(end).finish().unwrap());
            assert!((1..8).all(|k| (states[k].t - end * k as f64 / 7.0).abs() < 1e-15));
        }
        assert_eq!(run(&system).until(0.0).sample_evenly(5).count(), 1);
        let none: Vec<_> = run(&system).sample_evenly(5).collect();
        assert_eq!(none, [Err(Failure::BadEnd { end: None })]);
        let none: Vec<_> = run(&system).until(f64::NAN).sample_evenly(5).collect();
        assert!(matches!(none[..], [Err(Failure::BadEnd { .. })]));
    }

    /// Slope of the error of samples over the step size, for each method; their times do not depend on the steps.
    #[test]
    fn samples_are_as_good_as_the_interpolant_of_the_method() {
        fn measured<M: Method<Plane, 2>>(method: impl Fn() -> M, most: u32) -> f64 {
            let system = Plane::default();
            let point = |n: u32| {
                let h = 2.0 / f64::from(n);
                let samples =
                    integrate(&system, method(), Fixed::new(h), ELLIPSE).until(2.0).sample_evenly(37);
                let error =
                    |state: Result<State<f64, 2>, _>| state.map(|state| distance(&state, &ellipse(state.t)));
                (h, samples.map(|state| error(state).unwrap()).fold(0.0, f64::max))
            };
            crate::testing::slope([2, 3, 4, 6, 8].map(|k| point(k * most / 8)), 1e-13)
        }
        // The order of the method, or that of the interpolant if it is lower: of q̇, 5 for Hermite's, 4 for that of
        // DormandPrince5, 7 for that of Dop853.
        let orders = [
            (measured(|| Euler, 512), 1.0),
            (measured(|| Verlet, 128), 2.0),
            (measured(|| PositionVerlet, 128), 2.0),
            (measured(|| ImplicitMidpoint, 128), 2.0),
            (measured(|| Rk4, 128), 4.0),
            (measured(|| Gauss4, 128), 4.0),
            (measured(|| Gauss6, 128), 5.0),
            (measured(|| DormandPrince5, 128), 4.0),
            (measured(|| Dop853, 40), 7.0),
        ];
        assert!(orders.iter().all(|(measured, order)| *measured > order - 0.2), "{orders:.2?}");
    }

    #[test]
    fn samples_before_a_failure_are_kept() {
        let system = Law(|q: f64, _, _| 2.0 * q * q * q);
        let start = State::new(0.0, [1.0], [1.0]);
        let mut samples =
            integrate(&system, Dop853, Pi::tolerance(1e-11), start).until(2.0).sample_evenly(19);
        let good: Vec<_> = samples.by_ref().map_while(Result::ok).collect();
        assert_eq!(good.len(), 10, "q = 1/(1 − t)");
        assert!(good.iter().all(|state| (state.q[0] * (1.0 - state.t) - 1.0).abs() < 1e-7));
        assert!(samples.next().is_none());
    }

    #[test]
    fn a_failed_run_tells_how_far_it_came() {
        let system = Plane::default();
        let failed = run(&system).until(10.0).max_steps(5).finish().unwrap_err();
        assert!(failed.last.t > 0.0 && failed.statistics.accepted == 5);
        assert!(failed.to_string().contains("the last good state is at t = "));
    }
}
