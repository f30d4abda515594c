//! Landing, direction, failures as values, determinism, and scalars other than f64.

use super::*;
use crate::controller::PidController;
use crate::controller::{FixedStep, PiController};
use crate::method::explicit_rk::{Dop853, DormandPrince5, Rk4};
use crate::method::gauss::ImplicitMidpoint;
use crate::method::splitting::Verlet;
use crate::scalar::Dual;
use crate::state::Tangent;
use crate::testing::bank::*;
use crate::testing::distance;
use crate::{Radau5, Rodas5P, Taylor, TaylorController, goal, lagrangian, method_for};
use nalgebra::SVector;

const START: State<f64, 2> = ELLIPSE;

#[test]
fn fixed_steps_are_equal_and_land_exactly() {
    let system = Plane::default();
    // Steps asked for, end, number of steps made.
    for (h, end, n) in
        [(0.1, 1.0, 10), (0.1, 0.3, 3), (0.3, 1.0, 4), (1.0 / 3.0, 1.0, 3), (5.0, 1.0, 1), (-0.1, -0.7, 7)]
    {
        let steps: Vec<_> =
            integrate(&system, Rk4, FixedStep::new(h), START).until(end).collect::<Result<_, _>>().unwrap();
        assert_eq!(steps.len(), n, "{h} to {end}");
        assert_eq!(steps[n - 1].to.t, end);
        for (k, step) in steps.iter().enumerate() {
            assert_eq!(step.h, end / n as f64);
            assert!((step.to.t - (k + 1) as f64 * step.h).abs() <= f64::EPSILON);
        }
        for pair in steps.windows(2) {
            assert_eq!(pair[0].to, pair[1].from);
        }
    }
}

#[test]
fn time_does_not_accumulate_rounding() {
    let system = Law(&|_, _, _| 0.0);
    let start = State::new(0.0, [0.0], [1.0]);
    let last = integrate(&system, Rk4, FixedStep::new(0.1), start).take(100_000).last().unwrap().unwrap();
    assert_eq!(last.to.t, 100_000.0 * 0.1);
}

#[test]
fn adaptive_runs_land_exactly_in_both_directions() {
    let system = Plane::default();
    for end in [1e-3, 1.0, 17.3, -1e-3, -4.0] {
        let last = integrate(&system, Dop853, PiController::tolerance(1e-10), START)
            .until(end)
            .last()
            .unwrap()
            .unwrap();
        assert_eq!(last.to.t, end);
        assert!(distance(&last.to, &ellipse(end)) < 1e-8);
    }
}

#[test]
fn a_run_to_its_own_start_makes_no_step() {
    let system = Plane::default();
    assert_eq!(integrate(&system, Dop853, PiController::tolerance(1e-10), START).until(0.0).count(), 0);
    assert_eq!(integrate(&system, Rk4, FixedStep::new(0.1), START).until(0.0).final_state(), Ok(START));
}

#[test]
fn a_run_goes_on_to_another_end() {
    let system = Plane::default();
    let mut run = integrate(&system, Dop853, PiController::tolerance(1e-10), START).until(1.0);
    assert!(run.by_ref().all(|step| step.is_ok()));
    let mut run = run.until(2.0);
    assert!(run.by_ref().all(|step| step.is_ok()));
    assert_eq!(run.state().t, 2.0);
    let end = run.until(-1.0).final_state().unwrap();
    assert!(distance(&end, &ellipse(-1.0)) < 1e-8);
    let fixed = integrate(&system, Rk4, FixedStep::new(0.01), START).until(1.0);
    assert!(distance(&fixed.until(2.0).final_state().unwrap(), &ellipse(2.0)) < 1e-7);
}

#[test]
fn an_end_that_is_replaced_leaves_nothing_behind() {
    let system = Plane::default();
    let run = || integrate(&system, Dop853, PiController::tolerance(1e-10), START);
    // Neither a failure, nor a first step that was chosen for a shorter way, nor a direction.
    assert_eq!(run().until(f64::NAN).until(2.0).final_state(), run().until(2.0).final_state());
    assert_eq!(run().until(-1e-6).until(2.0).final_state(), run().until(2.0).final_state());
    let fixed = |h: f64| integrate(&system, Rk4, FixedStep::new(h), START);
    assert_eq!(fixed(0.1).until(-1.0).until(1.0).final_state(), fixed(0.1).until(1.0).final_state());
    // A failure is yielded once, and not before the first step is asked for.
    let mut refused = fixed(0.1).until(-1.0);
    assert_eq!(refused.failure(), None);
    let failure = Failure::WrongDirection { t: 0.0, h: 0.1, end: -1.0 };
    assert_eq!(refused.next().unwrap().unwrap_err(), failure);
    assert_eq!((refused.next().is_none(), refused.failure()), (true, Some(failure)));
    assert_eq!(refused.until(1.0).final_state().unwrap_err().failure, failure);
}

#[test]
fn the_first_step_is_of_a_sensible_size() {
    let system = Plane::default();
    for tolerance in [1e-4, 1e-8, 1e-12] {
        let mut run = integrate(&system, Dop853, PiController::tolerance(tolerance), START).until(20.0);
        let first = run.next().unwrap().unwrap().h;
        let rest: Vec<f64> = run.map(|step| step.unwrap().h).collect();
        let mean = rest.iter().sum::<f64>() / rest.len() as f64;
        assert!(first > 0.02 * mean && first < 2.0 * mean, "{first} of {mean}");
    }
}

#[test]
fn failures_are_values() {
    let plane = Plane::default();
    let t = 0.0;
    let fails = |controller: PiController, end: f64| {
        integrate(&plane, Dop853, controller, START).until(end).final_state().unwrap_err().failure
    };
    let fixed = |h: f64, end: f64| {
        integrate(&plane, Rk4, FixedStep::new(h), START).until(end).final_state().map_err(|f| f.failure)
    };
    assert_eq!(
        fails(PiController::tolerance(0.0), 1.0),
        Failure::BadTolerance { absolute: 0.0, relative: 0.0 }
    );
    assert_eq!(
        fails(PiController::tolerance(1e-3).atol(-1.0), 1.0),
        Failure::BadTolerance { absolute: -1.0, relative: 1e-3 }
    );
    assert!(matches!(fails(PiController::tolerance(f64::NAN), 1.0), Failure::BadTolerance { .. }));
    assert_eq!(fails(PiController::tolerance(1e-9).first_step(0.0), 1.0), Failure::BadStepSize { h: 0.0 });
    assert_eq!(
        fails(PiController::tolerance(1e-9), f64::INFINITY),
        Failure::BadEnd { end: Some(f64::INFINITY) }
    );
    assert_eq!(fixed(0.0, 1.0), Err(Failure::BadStepSize { h: 0.0 }));
    assert!(matches!(fixed(f64::NAN, 1.0), Err(Failure::BadStepSize { .. })));
    assert_eq!(fixed(-0.1, 1.0), Err(Failure::WrongDirection { t, h: -0.1, end: 1.0 }));
    assert_eq!(fixed(0.1, -1.0), Err(Failure::WrongDirection { t, h: 0.1, end: -1.0 }));
    let endless = integrate(&plane, Rk4, FixedStep::new(0.1), START).final_state().unwrap_err();
    assert_eq!((endless.failure, endless.last), (Failure::BadEnd { end: None }, START));
    let tired = integrate(&plane, Rk4, FixedStep::new(0.25), START)
        .until(1.0)
        .max_steps(3)
        .final_state()
        .unwrap_err();
    assert_eq!(tired.failure, Failure::BudgetUsedUp { t: 0.75, h: 0.25, max_steps: 3, implicit: false });
    assert_eq!(tired.statistics.accepted, 3);
    let late = State { t: 1e17, ..START };
    let stuck =
        integrate(&plane, Rk4, FixedStep::new(0.25), late).until(1e17 + 1e3).final_state().unwrap_err();
    assert!(matches!(stuck.failure, Failure::StepSizeUnderflow { .. }), "{stuck}");
}

/// q̈ = 2q³ with q = 1/(1 − t): a pole at t = 1 (given the first integral q̇ = q²).
#[test]
fn a_pole_is_a_step_size_underflow_at_the_pole() {
    let system = Law(&|q: f64, _, _| 2.0 * q * q * q);
    let start = State::new(0.0, [1.0], [1.0]);
    let failed = integrate(&system, DormandPrince5, PiController::tolerance(1e-10), start)
        .until(2.0)
        .final_state()
        .unwrap_err();
    assert!(
        matches!(failed.failure, Failure::StepSizeUnderflow { t, .. } if (t - 1.0).abs() < 1e-6),
        "{failed}"
    );
    assert!(failed.last.is_finite() && (failed.last.t - 1.0).abs() < 1e-6);
    let failed = integrate(&system, Rk4, FixedStep::new(0.01), start).until(2.0).final_state().unwrap_err();
    assert!(matches!(failed.failure, Failure::NonFinite { .. }) && failed.last.is_finite());
}

#[test]
fn nothing_panics_on_numbers_that_are_none() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for start in
            [State::new(bad, [1.0], [0.0]), State::new(0.0, [bad], [0.0]), State::new(0.0, [1.0], [bad])]
        {
            let system = Law(&|q: f64, _, _| -q);
            let failed = integrate(&system, Dop853, PiController::tolerance(1e-9), start)
                .until(1.0)
                .final_state()
                .unwrap_err();
            assert!(matches!(failed.failure, Failure::StateNotFinite { .. }));
            let failed =
                integrate(&system, Rk4, FixedStep::new(0.1), start).until(1.0).final_state().unwrap_err();
            assert!(matches!(failed.failure, Failure::StateNotFinite { .. }));
            let pendulum = Pendulum::default();
            let implicit = integrate(&pendulum, ImplicitMidpoint, FixedStep::new(0.1), start).until(1.0);
            assert!(matches!(implicit.final_state().unwrap_err().failure, Failure::StateNotFinite { .. }));
            let split = integrate(&pendulum, Verlet, FixedStep::new(0.1), start).until(1.0);
            assert!(matches!(split.final_state().unwrap_err().failure, Failure::StateNotFinite { .. }));
        }
        // Accelerations that go bad on the way, from the start, and a right-hand side that is always bad.
        let start = State::new(0.0, [1.0], [0.0]);
        let later = Law(&move |_, _, t| if t > 0.5 { bad } else { 1.0 });
        let failed = integrate(&later, Dop853, PiController::tolerance(1e-9), start)
            .until(1.0)
            .final_state()
            .unwrap_err();
        assert!(
            matches!(failed.failure, Failure::StepSizeUnderflow { t, .. } if t <= 0.5 && t > 0.499),
            "{failed}"
        );
        let never = Law(&move |_, _, _| bad);
        let failed = integrate(&never, Dop853, PiController::tolerance(1e-9), start)
            .until(1.0)
            .final_state()
            .unwrap_err();
        assert_eq!(failed.last, start);
        let failed = integrate(&never, Rk4, FixedStep::new(0.1), start).until(1.0).final_state().unwrap_err();
        assert_eq!((failed.failure, failed.last), (Failure::NonFinite { t: 0.0, h: 0.1 }, start));
    }
}

#[test]
fn a_failed_run_ends() {
    let system = Law(&|_, _, _| f64::NAN);
    let mut run = integrate(&system, Rk4, FixedStep::new(0.1), State::new(0.0, [1.0], [0.0])).until(1.0);
    assert!(run.next().unwrap().is_err());
    assert!(run.next().is_none() && run.next().is_none());
    let mut run = run.until(3.0);
    assert!(run.next().is_none(), "another end does not revive it");
}

#[test]
fn equal_runs_are_equal_to_the_last_bit() {
    let system = DoublePendulum::default();
    let run = || integrate(&system, Dop853, PiController::tolerance(1e-9), DOUBLE).until(30.0);
    let bits = |step: Result<Step<_, _, 2>, Failure>| {
        let to: State<f64, 2> = step.unwrap().to;
        [to.t, to.q[0], to.q[1], to.qd[0], to.qd[1]].map(f64::to_bits)
    };
    assert!(run().map(bits).eq(run().map(bits)));
}

fn swings<const N: usize>() {
    let system = Chain::<f64, N> { k: 1.0 };
    let end = 7.5;
    let near = |state: State<f64, N>, tolerance: f64| assert!(distance(&state, &mode(end)) < tolerance);
    near(
        integrate(&system, Dop853, PiController::tolerance(1e-12), mode(0.0))
            .until(end)
            .final_state()
            .unwrap(),
        1e-10,
    );
    near(
        integrate(&system, DormandPrince5, PiController::tolerance(1e-12), mode(0.0))
            .until(end)
            .final_state()
            .unwrap(),
        1e-9,
    );
    near(integrate(&system, Rk4, FixedStep::new(0.01), mode(0.0)).until(end).final_state().unwrap(), 1e-8);
    near(integrate(&system, Verlet, FixedStep::new(0.01), mode(0.0)).until(end).final_state().unwrap(), 1e-3);
    near(
        integrate(&system, ImplicitMidpoint, FixedStep::new(0.01), mode(0.0))
            .until(end)
            .final_state()
            .unwrap(),
        1e-3,
    );
}

#[test]
fn any_number_of_coordinates() {
    swings::<1>();
    swings::<2>();
    swings::<3>();
    swings::<4>();
    swings::<9>();
}

#[test]
fn single_precision() {
    let system = Plane { mu: 1.0f32 };
    let start = State::new(0.0f32, [0.7, 0.0], [0.0, 1.362_770_3]);
    let exact = ellipse(5.0);
    let near = |end: State<f32, 2>, tolerance: f64| {
        assert_eq!(end.t, 5.0);
        assert!((0..2).all(|i| (f64::from(end.q[i]) - exact.q[i]).abs() < tolerance), "{end:?}");
    };
    near(
        integrate(&system, Dop853, PiController::tolerance(1e-6), start).until(5.0).final_state().unwrap(),
        5e-5,
    );
    near(integrate(&system, Rk4, FixedStep::new(0.01), start).until(5.0).final_state().unwrap(), 5e-5);
    near(
        integrate(&system, ImplicitMidpoint, FixedStep::new(0.01), start).until(5.0).final_state().unwrap(),
        5e-3,
    );
    assert_eq!(integrate(&system, Rk4, FixedStep::new(0.1f32), start).until(10.0).count(), 100);
}

/// dθ(t)/dθ₀ by dual numbers and by a difference quotient of two runs.
#[test]
fn sensitivities_flow_through() {
    fn end<S: Real>(angle: S) -> [S; 2] {
        let system = Pendulum::<S>::default();
        let start = State::new(S::zero(), [angle], [S::zero()]);
        let fixed = FixedStep::new(S::from_f64(0.02));
        let end = S::from_f64(10.0);
        let explicit = integrate(&system, Dop853, PiController::tolerance(1e-12), start)
            .until(end)
            .final_state()
            .unwrap();
        let implicit = integrate(&system, ImplicitMidpoint, fixed, start).until(end).final_state().unwrap();
        [explicit.q[0], implicit.q[0]]
    }
    let d = 1e-4;
    let dual = end(Dual::variable(1.2));
    let [above, below] = [end(1.2 + d), end(1.2 - d)];
    for i in 0..2 {
        let quotient = (above[i] - below[i]) / (2.0 * d);
        assert!(f64::abs(dual[i].slope - quotient) < 1e-6, "{} {quotient}", dual[i].slope);
    }
}

/// Every method, started and ended anywhere among extreme numbers, ends in a state or a failure, and lands exactly
/// where it does not fail.
#[test]
fn extreme_numbers_end_in_a_state_or_a_failure() {
    let values = [
        0.0,
        -0.0,
        1.0,
        -3.0,
        1e-310,
        1e-30,
        1e16,
        -1e160,
        f64::MAX,
        f64::MIN_POSITIVE,
        f64::NAN,
        f64::INFINITY,
    ];
    let pick = |i: usize| values[i % values.len()];
    let (mut good, mut bad) = (0, 0);
    // Steps of 5 meet all pairs of values.
    for i in (0..values.len().pow(4)).step_by(if crate::long() { 1 } else { 5 }) {
        let [a, b, c, d] = [i, i / 12, i / 144, i / 1728].map(pick);
        let (start, end) = (State::new(a, [b, 1.0], [c, 0.5]), d);
        let (plane, double) = (Plane::default(), DoublePendulum::default());
        let outcomes = [
            integrate(&double, Dop853, PiController::tolerance(1e-6), start)
                .until(end)
                .max_steps(30)
                .final_state(),
            integrate(&plane, DormandPrince5, PiController::tolerance(c).atol(0.0), start)
                .until(end)
                .max_steps(30)
                .final_state(),
            integrate(&plane, Rk4, FixedStep::new(c), start).until(end).max_steps(10).final_state(),
            integrate(&plane, Verlet, FixedStep::new(b), start).until(end).max_steps(10).final_state(),
            integrate(&double, ImplicitMidpoint, FixedStep::new(c), start)
                .until(end)
                .max_steps(3)
                .final_state(),
        ];
        for outcome in outcomes {
            match outcome {
                Ok(state) => {
                    assert!(state.t == end && state.is_finite());
                    good += 1;
                }
                Err(failed) => {
                    assert!(!failed.to_string().is_empty());
                    bad += 1;
                }
            }
        }
    }
    assert!(good > 1000 && bad > 1000, "{good} {bad}");
}

lagrangian! {
    /// An oscillator at rest, until a gust comes.
    system Gust {
        param at, width;
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = 0.5 * x.powi(2);
        Q[x] = exp(-((t - at) / width).powi(2));
    }
}

/// After the gust `x = w √π exp(−w²/4) sin(t − at)`, by the Fourier transform of the force.
#[test]
fn gusts_that_set_in_late() {
    fn check(bound: f64, end_of: impl Fn(&Gust, State<f64, 1>, f64) -> State<f64, 1>) {
        for (at, width, end) in
            [(50.0, 1.0, 60.0), (50.0, 1.0, 100.0), (20.0, 0.3, 100.0), (-40.0, 2.0, -90.0)]
        {
            let start = State::new(0.0, [0.0], [0.0]);
            let last = end_of(&Gust::new(at, width), start, end);
            let amplitude = width * core::f64::consts::PI.sqrt() * (-0.25 * width * width).exp();
            let error = (last.q[0] - amplitude * (end - at).abs().sin()).abs();
            assert!(error < bound, "{error:e} at {at}, {width}, {end}, bound {bound:e}");
        }
    }
    fn by<M, C>(method: M, controller: C, bound: f64)
    where
        M: Method<Gust, 1> + Clone,
        C: Controller<f64, 1, M::Error>,
    {
        check(bound, |gust, start, end| {
            integrate(gust, method.clone(), controller.clone(), start).until(end).final_state().unwrap()
        });
    }
    by(DormandPrince5, PiController::tolerance(1e-6), 1e-4);
    by(Dop853, PiController::tolerance(1e-9), 1e-7);
    by(Dop853, PidController::h312b(PiController::tolerance(1e-9)), 1e-7);
    by(Taylor::of_order(12), TaylorController::tolerance(1e-6), 1e-5);
    by(Taylor::of_order(20), TaylorController::tolerance(1e-10), 1e-8);
    by(Rodas5P, PiController::tolerance(1e-6), 1e-4);
    by(Radau5, PiController::tolerance(1e-9), 1e-6);
    for tolerance in [1e-4, 1e-7, 1e-10] {
        let goal = goal::Accuracy(tolerance);
        check(1e-2, |gust, start, end| {
            method_for(gust, goal).integrate(start).until(end).final_state().unwrap()
        });
    }
    for tolerance in [1e-6, 1e-9] {
        let goal = goal::Stiff(tolerance);
        check(1e-2, |gust, start, end| {
            method_for(gust, goal).integrate(start).until(end).final_state().unwrap()
        });
    }
}

#[test]
fn no_step_is_longer_than_the_longest() {
    fn check<M: Method<Gust, 1>>(method: M, controller: impl Controller<f64, 1, M::Error>) {
        let gust = Gust::new(1e3, 1.0);
        let start = State::new(0.0, [0.0], [1e-3]);
        for step in integrate(&gust, method, controller, start).until(10.0) {
            assert!(step.unwrap().h <= 0.0625 * 1.01);
        }
    }
    check(Dop853, PiController::tolerance(1e-3).max_step(0.0625));
    check(Dop853, PidController::h312b(PiController::tolerance(1e-3).max_step(0.0625)));
    check(Taylor::of_order(20), TaylorController::tolerance(1e-3).max_step(0.0625));
    for longest in [0.0, -1.0, f64::NAN] {
        let gust = Gust::new(1e3, 1.0);
        let start = State::new(0.0, [0.0], [1e-3]);
        let run = integrate(&gust, Dop853, PiController::tolerance(1e-3).max_step(longest), start)
            .until(1.0)
            .final_state();
        assert!(matches!(run.unwrap_err().failure, Failure::BadStepSize { .. }));
        let run =
            integrate(&gust, Taylor::of_order(8), TaylorController::tolerance(1e-3).max_step(longest), start)
                .until(1.0)
                .final_state();
        assert!(matches!(run.unwrap_err().failure, Failure::BadStepSize { .. }));
    }
}

/// With an absolute tolerance for each component, a unit of length that is 1024 times as short changes no bit of a
/// motion but its unit.
#[test]
fn absolute_tolerances_have_the_units_of_components() {
    lagrangian! {
        system Scaled {
            param s;
            coord x, y;
            let u = y / s;
            T = 0.5 * dot(x).powi(2) + 0.5 * dot(u).powi(2);
            V = 0.5 * x.powi(2) + 0.25 * u.powi(4) + x * u;
        }
    }
    fn end<M, C>(method: M, controller: impl Fn(Tangent<f64, 2>) -> C, s: f64) -> [f64; 4]
    where
        M: Method<Scaled, 2>,
        C: Controller<f64, 2, M::Error>,
    {
        let each = SVector::from([1e-6, s * 1e-6]);
        let run = integrate(
            &Scaled::new(s),
            method,
            controller(Tangent { q: each, qd: each }),
            State::new(0.0, [1.0, 0.3 * s], [0.0, 0.0]),
        )
        .until(10.0)
        .final_state()
        .unwrap();
        [run.q[0], run.q[1] / s, run.qd[0], run.qd[1] / s]
    }
    let pi = |each| PiController::tolerance(1e-8).atol(each);
    let pid = |each| PidController::h211b(PiController::tolerance(1e-8).atol(each));
    let taylor = |each| TaylorController::tolerance(1e-8).atol(each);
    assert_eq!(end(Dop853, pi, 1.0), end(Dop853, pi, 1024.0));
    assert_eq!(end(DormandPrince5, pid, 1.0), end(DormandPrince5, pid, 1024.0));
    assert_eq!(end(Taylor, taylor, 1.0), end(Taylor, taylor, 1024.0));
    // One number for all is one for each.
    let all = |_| PiController::tolerance(1e-8).atol(1e-6);
    assert_eq!(end(Dop853, all, 1.0), end(Dop853, pi, 1.0));
    assert_ne!(end(Dop853, all, 1024.0), end(Dop853, pi, 1024.0));
    let bad =
        PiController::tolerance(1e-8).atol(Tangent { q: [1e-6, f64::NAN].into(), qd: [1e-6, 1e-6].into() });
    let failed = integrate(&Scaled::new(1.0), Dop853, bad, State::new(0.0, [1.0, 0.0], [0.0, 0.0]))
        .until(1.0)
        .final_state();
    assert!(
        matches!(failed.unwrap_err().failure, Failure::BadTolerance { absolute, .. } if absolute.is_nan())
    );
}
