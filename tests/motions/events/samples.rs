//! Times, order of accuracy, and failures of samples.

use crate::systems::bank::*;
use lagrange_runtime::Run;
use lagrange_runtime::method::explicit_rk::Euler;
use lagrange_runtime::method::splitting::PositionVerlet;
use lagrange_runtime::prelude::*;
use lagrange_runtime::testing::distance;

fn run(system: &Plane) -> Run<'_, Plane, Dop853, PiController, 2> {
    integrate(system, Dop853, PiController::tolerance(1e-11), ELLIPSE)
}

#[test]
fn samples_lie_on_the_orbit_and_at_their_times() {
    let system = Plane::default();
    for direction in [1.0, -1.0] {
        let times = (0..=100).map(|k| direction * 0.2 * f64::from(k));
        let end = direction * 20.0;
        let states: Vec<_> = run(&system).until(end).sample(times.clone()).collect::<Result<_, _>>().unwrap();
        assert!(states.iter().map(|state| state.t).eq(times));
        assert!(states.iter().all(|state| distance(state, &ellipse(state.t)) < 1e-8));
        assert_eq!(states[0], ELLIPSE);
        assert_eq!(states[100], run(&system).until(end).final_state().unwrap());
    }
}

#[test]
fn sampling_does_not_influence_the_steps_and_is_paid_where_used() {
    let system = Plane::default();
    let mut plain = run(&system).until(20.0);
    plain.run_to_end().unwrap();
    let mut samples = run(&system).until(20.0).sample([1.0, 20.0]);
    assert_eq!(samples.by_ref().last().unwrap().unwrap(), *plain.state());
    assert_eq!(samples.statistics().accepted, plain.statistics().accepted);
    assert_eq!(samples.statistics().evaluations, plain.statistics().evaluations + 3);
}

#[test]
fn ends_of_fixed_steps_are_exact_samples() {
    let system = Plane::default();
    let steps =
        integrate(&system, Rk4, FixedStep::new(0.25), ELLIPSE).until(1.0).map(|step| step.unwrap().to);
    let samples =
        integrate(&system, Rk4, FixedStep::new(0.25), ELLIPSE).until(1.0).sample([0.25, 0.5, 0.75, 1.0]);
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
        assert_eq!(states[7], run(&system).until(end).final_state().unwrap());
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
                integrate(&system, method(), FixedStep::new(h), ELLIPSE).until(2.0).sample_evenly(37);
            let error =
                |state: Result<State<f64, 2>, _>| state.map(|state| distance(&state, &ellipse(state.t)));
            (h, samples.map(|state| error(state).unwrap()).fold(0.0, f64::max))
        };
        lagrange_runtime::testing::slope([2, 3, 4, 6, 8].map(|k| point(k * most / 8)), 1e-13)
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
    let system = Law(&|q: f64, _, _| 2.0 * q * q * q);
    let start = State::new(0.0, [1.0], [1.0]);
    let mut samples =
        integrate(&system, Dop853, PiController::tolerance(1e-11), start).until(2.0).sample_evenly(19);
    let good: Vec<_> = samples.by_ref().map_while(Result::ok).collect();
    assert_eq!(good.len(), 10, "q = 1/(1 − t)");
    assert!(good.iter().all(|state| (state.q[0] * (1.0 - state.t) - 1.0).abs() < 1e-7));
    assert!(samples.next().is_none());
}

#[test]
fn a_failed_run_tells_how_far_it_came() {
    let system = Plane::default();
    let failed = run(&system).until(10.0).max_steps(5).final_state().unwrap_err();
    assert!(failed.last.t > 0.0 && failed.statistics.accepted == 5);
    assert!(failed.to_string().contains("the last good state is at t = "));
}
