//! Events against closed forms, and what becomes of functions that are hard to find the roots of.

use crate::systems::bank::*;
use crate::systems::emitted::Landing;
use core::f64::consts::{FRAC_PI_2, PI};
use lagrange_runtime::controller::Controller;
use lagrange_runtime::event::{Direction, EventSet, Occurrence};
use lagrange_runtime::failure::EventName;
use lagrange_runtime::method::explicit_rk::Euler;
use lagrange_runtime::prelude::*;
use lagrange_runtime::testing::distance;
use lagrange_runtime::testing::reference::{SimplePendulum, elliptic_k};

/// A point that moves with q = t, so that any function of time is one of the state.
pub const CLOCK: State<f64, 1> =
    State { t: 0.0, q: nalgebra::Vector1::new(0.0), qd: nalgebra::Vector1::new(1.0) };

/// A pendulum, g = l = 1.
const PENDULUM: Law<'static> = Law(&|q, _, _| -Functions::sin(q));

pub type Seen = (usize, f64, Direction);

/// The events of `q = t` on [0, end] in steps of `h`.
pub fn on_clock<E: EventSet<Law<'static>, 1, K>, const K: usize>(
    h: f64,
    end: f64,
    events: E,
) -> Result<Vec<Seen>, Failure> {
    let system = Law(&|_, _, _| 0.0);
    integrate(&system, Rk4, FixedStep::new(h), CLOCK)
        .until(end)
        .events(events)
        .map(|event| event.map(|event| (event.event, event.state.t, event.direction)))
        .collect()
}

/// Events of a function by its address: what looks for them is compiled once for all of these.
pub type OfState<'a, const N: usize> = Event<&'a dyn Fn(&State<f64, N>) -> f64>;

pub fn either<const N: usize>(g: &dyn Fn(&State<f64, N>) -> f64) -> OfState<'_, N> {
    Event::either(g)
}

fn rising<const N: usize>(g: &dyn Fn(&State<f64, N>) -> f64) -> OfState<'_, N> {
    Event::rising(g)
}

fn falling<const N: usize>(g: &dyn Fn(&State<f64, N>) -> f64) -> OfState<'_, N> {
    Event::falling(g)
}

fn assert_seen(seen: &[Seen], expected: &[Seen]) {
    let same = |(a, b): (&Seen, &Seen)| a.0 == b.0 && (a.1 - b.1).abs() < 1e-14 && a.2 == b.2;
    assert!(seen.len() == expected.len() && seen.iter().zip(expected).all(same), "{seen:?} not {expected:?}");
}

use Direction::{Either, Falling, Rising};

/// An event without a name.
const FIRST: EventName = EventName { index: 0, name: "" };

/// A motion that is followed in pieces has the events of the whole, wherever its pieces end.
#[test]
fn no_event_is_lost_between_pieces() {
    // q = −1/2 + t²/2, by methods that end at t = 1 on either side of the root.
    let pushed = Law(&|_, _, _| 1.0);
    macro_rules! pieces {
        ($method:expr, $controller:expr) => {{
            let (mut at, mut seen) = (State::new(0.0, [-0.5], [0.0]), 0);
            for k in 1..=20 {
                let run = integrate(&pushed, $method, $controller, at).until(f64::from(k) * 0.1);
                let mut events = run.events((rising(&|s| s.q[0]), falling(&|s| s.q[0])));
                for event in events.by_ref() {
                    let event = event.unwrap();
                    assert!(event.event == 0 && (event.state.t - 1.0).abs() < 1e-14, "{event:?}");
                    seen += 1;
                }
                at = *events.state();
            }
            assert_eq!(seen, 1, "{}", stringify!($method));
        }};
    }
    pieces!(Dop853, PiController::tolerance(1e-10));
    pieces!(DormandPrince5, PiController::tolerance(1e-10));
    pieces!(Rk4, FixedStep::new(0.1));
    // Thresholds within rounding of the state at which a piece ends.
    let free = Law(&|_, _, _| 0.0);
    for k in 1..20 {
        for by in [-3e-16, -1e-16, 0.0, 1e-16, 3e-16] {
            let (border, mut at, mut seen) = (0.1 * f64::from(k), CLOCK, 0);
            let threshold = border + by;
            for end in [border, 2.5] {
                let run = integrate(&free, Rk4, FixedStep::new(0.07), at).until(end);
                let beyond = |s: &State<f64, 1>| s.q[0] - threshold;
                let mut events = run.events(rising(&beyond));
                seen += events.by_ref().map(Result::unwrap).count();
                at = *events.state();
            }
            assert_eq!(seen, 1, "{border} {by:e}");
        }
    }
    // A root that is farther away is not met.
    let run = integrate(&free, Rk4, FixedStep::new(0.07), CLOCK).until(1.0);
    assert_eq!(run.events(rising(&|s| s.q[0] - 1.0 - 1e-13)).count(), 0);
}

#[test]
fn quarter_period_of_a_pendulum() {
    let system = PENDULUM;
    for amplitude in [0.1, 1.0, 2.0, 3.0] {
        let exact = elliptic_k(Functions::sin(0.5f64 * amplitude));
        let start = State::new(0.0, [amplitude], [0.0]);
        let run = integrate(&system, Dop853, PiController::tolerance(1e-14), start).until(20.0);
        let end = run.events(falling(&|s| s.q[0]).terminal()).final_state().unwrap();
        assert!((end.t - exact).abs() < 1e-12, "{amplitude}: {:e}", end.t - exact);
        let (_, speed) = SimplePendulum::new(1.0, 1.0, amplitude, 0.0).state(exact);
        assert!((end.qd[0] - speed).abs() < 1e-12 && end.q[0].abs() < 1e-15);
    }
}

/// Flights of a ball: `2v/g`, each 0.9 of the one before; from height 1 with g = 9.81.
#[test]
fn twenty_bounces_and_the_time_at_which_they_accumulate() {
    let (g, restitution) = (9.81, 0.9f64);
    let system = Law(&|_, _, _| -g);
    let fall = (2.0 / g).sqrt();
    let bounces = |restitution: f64, wanted: i32| {
        let start = State::new(0.0, [1.0], [0.0]);
        let run = integrate(&system, Dop853, PiController::tolerance(1e-12), start).until(100.0);
        let mut events = run.events(falling(&|s| s.q[0]).terminal());
        for n in 0..wanted {
            let bounce = events.next().expect("it bounces on").unwrap();
            let flights: f64 = (1..=n).map(|k| 2.0 * restitution.powi(k)).sum();
            let exact = fall * (1.0 + flights);
            assert!(
                (bounce.state.t - exact).abs() < 1e-13 * exact,
                "bounce {n}: {:e}",
                bounce.state.t - exact
            );
            let speed = -g * fall * restitution.powi(n);
            let error = (bounce.state.qd[0] - speed).abs();
            assert!(error < 1e-12 && bounce.state.q[0].abs() < 1e-13, "{n}: {error:e} {}", bounce.state.q[0]);
            assert!(bounce.terminal && bounce.direction == Falling);
            events.restart(State { qd: bounce.state.qd * -restitution, ..bounce.state });
        }
    };
    bounces(restitution, 20);
    // The flights become a thousand times shorter than the step that is tried.
    bounces(0.2, 8);
}

#[test]
fn a_poincare_section_does_not_depend_on_the_tolerance() {
    let system = HenonHeiles::default();
    let start = State::new(0.0, [0.0, 0.1], [0.49, 0.05]);
    let section = |tolerance: f64| -> Vec<State<f64, 2>> {
        let run = integrate(&system, Dop853, PiController::tolerance(tolerance), start).until(200.0);
        run.events(rising(&|s| s.q[0])).map(|event| event.unwrap().state).collect()
    };
    let (coarse, fine) = (section(1e-10), section(1e-13));
    assert!(coarse.len() > 25 && coarse.len() == fine.len());
    let apart =
        coarse.iter().zip(&fine).map(|(a, b)| distance(a, b).max((a.t - b.t).abs())).fold(0.0, f64::max);
    assert!(apart < 1e-6, "{apart:e}");
    assert!(fine.iter().all(|state| state.q[0].abs() < 1e-13 && state.qd[0] > 0.0));
}

#[test]
fn a_function_that_never_crosses_has_no_events() {
    assert_eq!(on_clock(0.3, 3.0, either(&|s| s.q[0] + 1.0)), Ok(vec![]));
    assert_eq!(on_clock(0.3, 3.0, rising(&|s| -s.q[0] * s.q[0] - 1e-9)), Ok(vec![]));
    assert_eq!(on_clock(0.3, 3.0, either(&|_| 0.0)), Ok(vec![]), "zero from the start on");
}

#[test]
fn directions_are_told_apart() {
    let wave = |s: &State<f64, 1>| (s.t - 0.5).sin();
    let all = [(0, 0.5, Rising), (0, 0.5 + PI, Falling), (0, 0.5 + 2.0 * PI, Rising)];
    assert_seen(&on_clock(0.3, 8.0, either(&wave)).unwrap(), &all);
    assert_seen(&on_clock(0.3, 8.0, rising(&wave)).unwrap(), &[all[0], all[2]]);
    assert_seen(&on_clock(0.3, 8.0, falling(&wave)).unwrap(), &[all[1]]);
    // Backward, rising means: on the way back.
    let back = [(0, 0.5 - PI, Rising), (0, 0.5 - 2.0 * PI, Falling)];
    assert_seen(&on_clock(-0.3, -6.0, either(&wave)).unwrap(), &back);
}

#[test]
fn two_crossings_within_one_step() {
    // Apart by more and by less than the parts of a step, at its border, and in the middle.
    for (middle, half) in [(1.5, 0.4), (1.2, 0.01), (1.26, 1e-5), (1.0, 1e-3), (1.0001, 1e-5), (1.97, 1e-4)] {
        let parabola = |s: &State<f64, 1>| (s.t - middle) * (s.t - middle) - half * half;
        let seen = on_clock(1.0, 3.0, either(&parabola)).unwrap();
        let directions: Vec<_> = seen.iter().map(|seen| seen.2).collect();
        assert_eq!(directions, [Falling, Rising], "{middle} {half} {seen:?}");
        let error = (seen[0].1 - middle + half).abs().max((seen[1].1 - middle - half).abs());
        assert!(error < 1e-15 / half, "{error:e}");
        let wave = on_clock(1.0, 3.0, rising(&parabola)).unwrap();
        assert_eq!(wave.len(), 1);
    }
    let many = on_clock(2.0, 2.0, either(&|s| (6.0 * s.t).cos())).unwrap();
    assert_eq!(many.len(), 4);
    assert!(many.iter().enumerate().all(|(k, seen)| (seen.1 - (k as f64 + 0.5) * PI / 6.0).abs() < 1e-14));
}

#[test]
fn a_zero_that_is_touched_is_an_event_of_either_direction() {
    // Within a step, at its ends, at a place where g is looked at.
    for touch in [0.37, 1.0, 1.25, 1.2345678, 3.0] {
        for sign in [1.0, -1.0] {
            let parabola = |s: &State<f64, 1>| sign * (s.t - touch) * (s.t - touch);
            let seen = on_clock(1.0, 3.0, either(&parabola)).unwrap();
            assert!(seen.len() == 1 && seen[0].2 == Either, "{touch} {seen:?}");
            assert!((seen[0].1 - touch).abs() < 1e-7, "{touch} {seen:?}");
            assert_eq!(on_clock(1.0, 3.0, rising(&parabola)), Ok(vec![]));
            assert_eq!(on_clock(1.0, 3.0, falling(&parabola)), Ok(vec![]));
        }
    }
    let near = |s: &State<f64, 1>| (s.t - 1.3) * (s.t - 1.3) + 1e-6;
    assert_eq!(on_clock(1.0, 3.0, either(&near)), Ok(vec![]));
    assert_eq!(on_clock(1.0, 3.0, either(&near).touching(1e-5)).unwrap().len(), 1);
}

#[test]
fn a_zero_at_the_start_is_no_event() {
    assert_seen(&on_clock(0.3, 5.0, either(&|s| s.t.sin())).unwrap(), &[(0, PI, Falling)]);
    assert_seen(&on_clock(1.0, 5.0, either(&|s| s.t * (s.t - 1e-6))).unwrap(), &[(0, 1e-6, Rising)]);
    assert_seen(&on_clock(1.0, 1.0, either(&|s| s.t - 1.0)).unwrap(), &[(0, 1.0, Rising)]);
    // A stretch of zeros is one event, at its start.
    let stretch = |s: &State<f64, 1>| (1.3 - s.t).max(0.0) + (2.6 - s.t).min(0.0);
    assert_seen(&on_clock(1.0, 4.0, either(&stretch)).unwrap(), &[(0, 1.3, Falling)]);
}

#[test]
fn functions_that_are_no_numbers_are_failures_where_they_matter() {
    let root = |s: &State<f64, 1>| (2.0 - s.t).sqrt() - 1.0;
    let failure = on_clock(0.5, 4.0, either(&root)).unwrap_err();
    assert!(
        matches!(failure, Failure::EventNotFinite { event, t } if t > 1.9 && t <= 2.0 && event.index == 0),
        "{failure}"
    );
    // The run ends before.
    assert_seen(&on_clock(0.5, 4.0, either(&root).terminal()).unwrap(), &[(0, 1.0, Falling)]);
    assert_seen(&on_clock(4.0, 4.0, either(&root).terminal()).unwrap(), &[(0, 1.0, Falling)]);
    let failure = on_clock(0.5, 4.0, either(&|_| f64::NAN)).unwrap_err();
    assert_eq!(failure, Failure::EventNotFinite { t: 0.0, event: FIRST });
    let hole = either(&|s: &State<f64, 1>| if (s.t - 1.1).abs() < 0.01 { f64::NAN } else { s.t - 1.1 });
    assert!(matches!(on_clock(1.0, 2.0, hole), Err(Failure::EventNotFinite { .. })));
}

#[test]
fn several_events_come_in_the_order_of_time_and_then_of_index() {
    let seen = on_clock(
        1.0,
        4.0,
        (
            either(&|s| s.t - 2.5),
            either(&|s| s.t - 1.25).named("first"),
            rising(&|s| s.t.sin()),
            falling(&|s| 2.5 - s.q[0]),
        ),
    );
    assert_seen(&seen.unwrap(), &[(1, 1.25, Rising), (0, 2.5, Rising), (3, 2.5, Falling)]);
    let levels = [0.7, 0.2, 0.9].map(|level| Event::rising(move |s: &State<f64, 1>| s.t - level));
    assert_seen(
        &on_clock(1.0, 4.0, levels).unwrap(),
        &[(1, 0.2, Rising), (0, 0.7, Rising), (2, 0.9, Rising)],
    );
    assert_eq!(on_clock::<[Event<fn(&State<f64, 1>) -> f64>; 0], 0>(1.0, 4.0, []), Ok(vec![]));
}

#[test]
fn events_at_the_time_of_a_terminal_one_are_told_before_the_run_ends() {
    let events = (
        either(&|s: &State<f64, 1>| s.t - 1.5).terminal().named("stop"),
        either(&|s: &State<f64, 1>| 3.0 - 2.0 * s.q[0]),
        either(&|s: &State<f64, 1>| s.t - 1.6),
    );
    let system = Law(&|_, _, _| 0.0);
    let mut run = integrate(&system, Rk4, FixedStep::new(1.0), CLOCK).until(4.0).events(events);
    let told: Vec<_> = run.by_ref().map(|event| event.map(|event| (event.event, event.name))).collect();
    assert_eq!(told, [Ok((0, "stop")), Ok((1, ""))]);
    assert_eq!(run.state().t, 1.5);
    assert!(run.next().is_none());
    // Both are left behind when the run goes on from there as if nothing had happened.
    let state = *run.state();
    run.restart(state);
    assert_seen(
        &[run.next().unwrap().map(|event| (event.event, event.state.t, event.direction)).unwrap()],
        &[(2, 1.6, Rising)],
    );
    assert_eq!(run.next(), None);
    assert_eq!(run.state().t, 4.0);
}

/// The passage of a pendulum through the vertical, met again and again by a run that is restarted there unchanged.
#[test]
fn a_restart_at_the_event_does_not_meet_it_again() {
    let system = PENDULUM;
    let start = State::new(0.0, [1.0], [0.0]);
    let quarter = elliptic_k(Functions::sin(0.5f64));
    let run = integrate(&system, Dop853, PiController::tolerance(1e-13), start).until(100.0);
    let mut events = run.events(either(&|s| s.q[0]).terminal());
    for n in 0..14 {
        let passage = events.next().unwrap().unwrap().state;
        let exact = quarter * f64::from(2 * n + 1);
        assert!((passage.t - exact).abs() < 1e-11 * exact, "{n}: {:e}", passage.t - exact);
        events.restart(passage);
    }
}

/// The same by a function that jumps, which is as far from zero at the event as anywhere else.
#[test]
fn a_jump_is_met_again_after_a_restart() {
    let system = PENDULUM;
    let quarter = elliptic_k(Functions::sin(0.5f64));
    let jump = |s: &State<f64, 1>| if s.q[0] > 0.0 { 1.0 } else { -1.0 };
    let start = State::new(0.0, [1.0], [0.0]);
    let run = integrate(&system, Dop853, PiController::tolerance(1e-13), start).until(100.0);
    let mut events = run.events(either(&jump).terminal());
    for n in 0..14 {
        let passage = events.next().expect("a passage").unwrap();
        let exact = quarter * f64::from(2 * n + 1);
        assert!((passage.state.t - exact).abs() < 1e-11 * exact, "{n}: {:e}", passage.state.t - exact);
        assert_eq!(passage.direction, if n % 2 == 0 { Falling } else { Rising });
        events.restart(passage.state);
    }
    // A ball that is thrown up again with the velocity of its impact, in another run.
    let law = Law(&|_, _, _| -1.0);
    let mut state = State::new(0.0, [0.5], [0.0]);
    for n in 0..20 {
        let run = integrate(&law, Dop853, PiController::tolerance(1e-12), state).until(100.0);
        let mut events = run.events(falling(&jump).terminal());
        for bounce in [2 * n, 2 * n + 1] {
            state = events.next().expect("a bounce").unwrap().state;
            assert!((state.t - f64::from(1 + 2 * bounce)).abs() < 1e-11, "{bounce}: {}", state.t);
            state.qd = -state.qd;
            events.restart(state);
        }
    }
}

/// The error of the state on which a run lands is that of the method, whatever its interpolant is.
#[test]
fn landing_is_as_accurate_as_the_method() {
    fn errors<M: Method<Pendulum, 1>>(method: impl Fn() -> M, most: u32) -> Vec<(f64, f64)> {
        let system = Pendulum::default();
        let motion = SimplePendulum::new(1.0, 1.0, 1.0, 0.0);
        let exact = elliptic_k(Functions::sin(0.5f64));
        let error = |n: u32| {
            let h = 3.0 / f64::from(n);
            let run =
                integrate(&system, method(), FixedStep::new(h), State::new(0.0, [1.0], [0.0])).until(3.0);
            let end = run.events(falling(&|s| s.q[0]).terminal()).final_state().unwrap();
            let (theta, speed) = motion.state(end.t);
            assert!(end.q[0].abs() < 1e-15);
            (h, (end.t - exact).abs() + (end.q[0] - theta).abs() + (end.qd[0] - speed).abs())
        };
        [4, 6, 8, 12, 16].map(|n| error(n * most / 16)).into()
    }
    let order = |errors: Vec<(f64, f64)>| lagrange_runtime::testing::slope(errors, 1e-13);
    let measured = [
        order(errors(|| Euler, 64)),
        order(errors(|| Verlet, 64)),
        order(errors(|| ImplicitMidpoint, 64)),
        order(errors(|| Rk4, 64)),
        order(errors(|| Gauss6, 64)),
        order(errors(|| Dop853, 20)),
    ];
    for (measured, order) in measured.into_iter().zip([1.0, 2.0, 2.0, 4.0, 6.0, 8.0]) {
        assert!(measured > order - 0.4, "{measured} instead of {order}");
    }
}

#[test]
fn what_happens_on_the_interpolant_alone_is_a_failure() {
    // Euler's steps of any length lie on the tangent, which the interpolant leaves to meet the end.
    let system = Law(&|_, _, _| -1.0);
    let above = rising(&|s| s.q[0] - s.t - 0.05);
    let mut run = integrate(&system, Euler, FixedStep::new(1.0), CLOCK).until(4.0).events(above.terminal());
    assert_eq!(run.next(), Some(Err(Failure::EventNotBracketed { t: 0.0, h: 1.0, event: FIRST })));
    assert_eq!(run.next(), None);
}

#[test]
fn failures_of_the_run_are_passed_on() {
    let system = Law(&|_, _, t| if t > 1.0 { f64::NAN } else { 0.0 });
    let run = integrate(&system, DormandPrince5, PiController::tolerance(1e-9), CLOCK).until(4.0);
    let failed = run.events(rising(&|s| s.q[0] - 2.0).terminal()).final_state().unwrap_err();
    assert!(matches!(failed.failure, Failure::StepSizeUnderflow { .. }) && failed.last.t <= 1.0);
    let run = integrate(&system, Rk4, FixedStep::new(f64::NAN), CLOCK);
    assert!(matches!(run.events(rising(&|s| s.q[0])).next(), Some(Err(Failure::BadStepSize { .. }))));
}

/// A pendulum of length l, g = 1, has the quarter period √l K: its derivative by l is K/2 at l = 1.
#[test]
fn times_of_events_have_derivatives() {
    let system = Pendulum { m: Dual::constant(1.0), l: Dual::variable(1.0), g: Dual::constant(1.0) };
    let start = State::new(Dual::constant(0.0), [Dual::constant(1.0)], [Dual::constant(0.0)]);
    let exact = elliptic_k(Functions::sin(0.5f64));
    let run = || integrate(&system, Dop853, PiController::tolerance(1e-13), start).until(Dual::constant(3.0));
    let down = Event::new(Falling, |s: &State<Dual<f64>, 1>| s.q[0]);
    for event in [down, down.terminal()] {
        let there = run().events(event).next().unwrap().unwrap().state;
        assert!(
            (there.t.value - exact).abs() < 1e-10 && (there.t.slope - 0.5 * exact).abs() < 1e-9,
            "{there:?}"
        );
        assert!(there.q[0].slope.abs() < 1e-9);
    }
}

#[test]
fn events_may_be_far_from_the_origin_of_time() {
    let system = Law(&|q: f64, _, _| -q);
    let start = State::new(1e6, [1.0], [0.0]);
    let run = integrate(&system, Dop853, PiController::tolerance(1e-12), start).until(1e6 + 10.0);
    let end = run.events(falling(&|s| s.q[0]).terminal()).final_state().unwrap();
    assert!((end.t - 1e6 - FRAC_PI_2).abs() < 3e-10 && end.q[0].abs() < 1e-15);
}

/// Three pairs of roots, close or not, anywhere in steps of any length: all are found.
#[test]
fn all_pairs_of_roots_are_found() {
    let mut seed = 1u64;
    let mut random = || {
        seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (seed >> 11) as f64 / (1u64 << 53) as f64
    };
    let mut close = 0;
    let trials = if cfg!(feature = "long") { 3000 } else { 300 };
    for trial in 0..trials {
        let pair =
            [0.7, 2.0, 3.3].map(|middle| (middle + 0.4 * random() - 0.2, 10f64.powf(-1.0 - 4.0 * random())));
        let roots = pair.map(|(middle, half)| [middle - half, middle + half]).concat();
        close += pair.iter().filter(|pair| pair.1 < 1e-3).count();
        let h = 0.05 + 0.6 * random();
        let polynomial = |s: &State<f64, 1>| roots.iter().map(|root| s.t - root).product::<f64>();
        let seen = on_clock(h, 4.5, either(&polynomial)).unwrap();
        assert_eq!(seen.len(), 6, "{trial}: {seen:?} of {roots:?} in steps of {h}");
        for (n, (seen, root)) in seen.iter().zip(&roots).enumerate() {
            assert!((seen.1 - root).abs() < 1e-14, "{trial}: {seen:?} {root}");
            assert_eq!(seen.2, if n % 2 == 0 { Falling } else { Rising });
        }
    }
    assert!(close > trials);
}

/// Steps of series end where the contact begins, which is where the event is.
#[test]
fn terminal_events_on_a_switch_end_the_run_there() {
    let landing = Landing::new(1000.0);
    let seen = |start, direction, tolerance: f64| {
        let event = Event::new(direction, |s: &State<f64, 1>| s.q[0]);
        let run = integrate(&landing, Taylor, TaylorController::tolerance(tolerance), start);
        run.until(10.0)
            .events(event.terminal())
            .final_state()
            .unwrap_or_else(|lost| panic!("{start:?}: {lost}"))
    };
    for height in (1..=60).map(|n| 0.1 * f64::from(n)) {
        for tolerance in [1e-3, 1e-9, 1e-15f64] {
            let fall = (2.0 * height / 9.81).sqrt();
            let down = seen(State::new(0.0, [height], [0.0]), Falling, tolerance);
            assert!((down.t - fall).abs() < 1e-14 && down.q[0].abs() < 1e-14, "{height}: {down:?}");
            // From the lowest point, at which g y + k y²/2 = g h.
            let low = -(9.81 + (9.81f64.powi(2) + 2.0 * 9810.0 * height).sqrt()) / 1000.0;
            let up = seen(State::new(0.0, [low], [0.0]), Rising, tolerance);
            assert!((up.qd[0] - 9.81 * fall).abs() < 100.0 * tolerance.max(1e-14), "{height}: {up:?}");
        }
    }
}

/// In steps of rounding beside a switch a crossing is not a touch as well.
#[test]
fn a_crossing_is_one_event() {
    for height in (1..=30).map(|n| 0.3 * f64::from(n)) {
        let start = State::new(0.0, [height], [0.0]);
        let (landing, fall) = (Landing::new(1e4), (2.0 * height / 9.81f64).sqrt());
        let run =
            integrate(&landing, DormandPrince5, PiController::tolerance(1e-12), start).until(fall + 0.1);
        let seen: Result<Vec<_>, _> =
            run.events(either(&|s| s.q[0])).map(|event| event.map(|event| event.direction)).collect();
        assert_eq!(seen.expect("a bounce"), [Falling, Rising], "{height}");
    }
}

/// A ball that is let bounce for ever stops the run with a failure, where its flights are too short to be told from
/// rest.
#[test]
fn accumulating_bounces_end_in_a_failure() {
    let system = Law(&|_, _, _| -9.81);
    for restitution in [0.3, 0.5, 0.9] {
        let start = State::new(0.0, [1.0], [0.0]);
        let run = integrate(&system, Dop853, PiController::tolerance(1e-10), start).until(60.0);
        let mut events = run.events(falling(&|s| s.q[0]).terminal());
        let end = (2.0f64 / 9.81).sqrt() * (1.0 + restitution) / (1.0 - restitution);
        let failure = loop {
            match events.next() {
                Some(Ok(bounce)) => {
                    events.restart(State { qd: bounce.state.qd * -restitution, ..bounce.state });
                }
                Some(Err(failure)) => break failure,
                None => panic!("it fell through the ground from {:?}", events.state()),
            }
        };
        assert!(
            matches!(failure, Failure::EventsAccumulate { t, .. } if (t - end).abs() < 1e-11),
            "{restitution} {failure}"
        );
    }
}

#[test]
fn events_in_single_precision() {
    let system = Plane { mu: 1.0f32 };
    let start = State::new(0.0f32, [0.7, 0.0], [0.0, 1.362_770_3]);
    let run = integrate(&system, Dop853, PiController::tolerance(1e-6), start).until(7.0);
    let end = run.events(Event::new(Rising, |s: &State<f32, 2>| s.q[1]).terminal()).final_state().unwrap();
    // One turn of the ellipse.
    assert!((f64::from(end.t) - 2.0 * PI).abs() < 1e-4 && end.q[1].abs() < 1e-6, "{end:?}");
}

/// A block on a spring with dry friction, μ = 0.01: a half swing takes π and ends 2μ nearer to the middle. Each half
/// swing is a run of its own, from the state at which the one before was ended by v = 0 in either direction, with
/// another force.
#[test]
fn an_automaton_of_modes_goes_on_from_the_event_that_ended_the_last_one() {
    const FRICTION: f64 = 0.01;
    type Spring = Law<'static>;
    const PUSHED: [Spring; 2] = [Law(&|q, _, _| -q - FRICTION), Law(&|q, _, _| FRICTION - q)];
    fn turns<M: Method<Spring, 1>>(
        method: impl Fn() -> M,
        tolerance: f64,
        amplitude: f64,
        clock: impl Fn(f64) -> f64,
    ) where
        PiController: Controller<f64, 1, M::Error>,
    {
        let mut state = State::new(0.0, [amplitude], [0.0]);
        let mut time = 0.0;
        for n in 1..=40 {
            let system = &PUSHED[usize::from(state.q[0] > 0.0)];
            let start = State { t: clock(state.t), ..state };
            let run =
                integrate(system, method(), PiController::tolerance(tolerance), start).until(start.t + 10.0);
            state = run.events(either(&|s| s.qd[0]).terminal()).final_state().unwrap();
            time += state.t - start.t;
            let exact = (amplitude - 2.0 * FRICTION * f64::from(n)) * if n % 2 == 0 { 1.0 } else { -1.0 };
            let error = (state.q[0] - exact).abs().max((time - PI * f64::from(n)).abs());
            assert!(
                error < 1e3 * tolerance,
                "{n} {amplitude} {tolerance:e}: {state:?} at {time}, not {exact}"
            );
        }
    }
    for tolerance in [1e-6, 1e-9, 1e-12] {
        for &amplitude in if cfg!(feature = "long") { &[1.0, 1.234, 3.7, 17.0][..] } else { &[1.234] } {
            for clock in [|t| t, |_| 0.0, |t| t + 100.0] {
                turns(|| Dop853, tolerance, amplitude, clock);
                turns(|| DormandPrince5, tolerance, amplitude, clock);
            }
        }
    }
}

/// A start is told from the root when time or the state can tell them apart.
#[test]
fn a_root_soon_after_the_start_is_found() {
    let system = Law(&|_, _, _| -1.0);
    for t in [0.0, 1.0] {
        for after in [1e-9, 1e-12, 1e-14] {
            for h in [1e-3, 0.1] {
                let seen = |event: OfState<'_, 1>, start: State<f64, 1>| {
                    let run = integrate(&system, Rk4, FixedStep::new(h), start).until(t + 10.0);
                    run.events(event)
                        .next()
                        .transpose()
                        .unwrap()
                        .map(|seen| (seen.state.t - t, seen.direction))
                };
                let turning = seen(either(&|s| s.qd[0]), State::new(t, [1.0], [after]));
                let impact = seen(either(&|s| s.q[0]), State::new(t, [after], [-1.0]));
                for seen in [turning, impact] {
                    let (at, direction) = seen.expect("a root after the start");
                    assert!(
                        (at - after).abs() < 3e-16 * (1.0 + t) && direction == Falling,
                        "{at:e} not {after:e}"
                    );
                }
            }
        }
    }
}

/// Functions that are zero but for rounding of the state: a length that cancels, a tangent, a jump.
#[test]
fn a_start_within_rounding_of_a_root_is_on_it() {
    let length = either(&|s: &State<f64, 2>| s.q.norm() - 0.3);
    let system = Plane { mu: 0.0 };
    for angle in 0..100 {
        let (sin, cos) = f64::from(angle).sin_cos();
        // Along a chord, half a radian from the diameter.
        let (towards, beside) = (-0.5f64.cos(), 0.5f64.sin());
        let velocity = [towards * cos - beside * sin, towards * sin + beside * cos];
        let start = State::new(0.0, [0.3 * cos, 0.3 * sin], velocity);
        let run = integrate(&system, Rk4, FixedStep::new(0.1), start).until(1.0);
        let times: Vec<_> = run.events(length).map(|seen| seen.unwrap().state.t).collect();
        assert!(times.len() == 1 && (times[0] + 0.6 * towards).abs() < 1e-12, "{angle}: {times:?}");
    }
    // At rest at the root, to which it does not come back.
    for off in [-1e-16, 1e-16] {
        let rest = move |s: &State<f64, 1>| s.t.mul_add(s.t, off) + s.q[0];
        let system = Law(&|_, _, _| 0.0);
        let start = State::new(0.0, [1e-16], [0.0]);
        let run = integrate(&system, Rk4, FixedStep::new(0.1), start).until(1.0);
        assert_eq!(run.events(either(&rest)).count(), 0, "{off:e}");
    }
    let jump = |s: &State<f64, 1>| if s.q[0] < 0.3 { -1.0 } else { 1.0 };
    for q in [0.3, 0.3 - 1e-16] {
        for speed in [-1.0, 1.0] {
            let run =
                integrate(&Law(&|_, _, _| 0.0), Rk4, FixedStep::new(0.1), State::new(0.0, [q], [speed]))
                    .until(1.0);
            assert_eq!(run.events(either(&jump)).count(), 0, "{q} {speed}");
        }
    }
}

lagrangian! {
    /// Two oscillators of very different frequencies and units, the first one damped beyond all oscillation if c is
    /// large.
    system Pair {
        param slow, fast, c, scale;
        coord x, y;
        T = 0.5 * scale * scale * dot(x).powi(2) + 0.5 * dot(y).powi(2);
        V = 0.5 * (slow * scale * x).powi(2) + 0.5 * (fast * y).powi(2);
        D = 0.5 * c * (scale * dot(x)).powi(2);
    }
}

/// cos ωt has its zeros at (k + ½)π/ω, however long the step is.
#[test]
#[cfg_attr(not(feature = "long"), ignore = "long")]
fn all_zeros_within_one_long_exact_step() {
    for [slow, fast, c, scale] in
        [[1.0, 1.0, 0.0, 1.0], [1.0, 20.0, 0.0, 1e-6], [0.1, 5.0, 1e8, 1e6], [30.0, 2.0, 0.0, 1e9]]
    {
        let system = Pair::new(slow, fast, c, scale);
        let start = State::new(0.0, [1.0, 1.0], [0.0, 0.0]);
        let run = integrate(&system, MatrixExponential, FixedStep::new(101.0), start).until(101.0);
        let times: Vec<f64> = run.events(either(&|s| s.q[1])).map(|e| e.unwrap().state.t).collect();
        let zeros: Vec<f64> =
            (0..).map(|k| (f64::from(k) + 0.5) * PI / fast).take_while(|t| *t < 101.0).collect();
        assert_eq!(times.len(), zeros.len(), "{slow} {fast} {c} {scale}");
        for (time, zero) in times.iter().zip(&zeros) {
            // Rounding of the exponential, of a matrix of norm c where that is large.
            let bound = 1e-11 + 1e-2 * f64::EPSILON * c * 101.0;
            assert!((time - zero).abs() < bound, "{time} for {zero}");
        }
    }
}

/// More places than can be looked at are refused, alone and in lanes.
#[test]
fn a_step_with_too_many_zeros_is_refused() {
    let (system, start) = (Pair::new(1.0, 1.0, 0.0, 1.0), State::new(0.0, [1.0, 1.0], [0.0, 0.0]));
    let mut found = integrate(&system, MatrixExponential, FixedStep::new(1e7), start)
        .until(1e7)
        .events(either(&|s: &State<f64, 2>| s.q[1]));
    assert_eq!(found.next(), Some(Err(Failure::EventsUnresolved { t: 0.0, h: 1e7 })));
    assert_eq!(found.next(), None);
    // Without events it is a step as any other.
    let end =
        integrate(&system, MatrixExponential, FixedStep::new(1e7), start).until(1e7).final_state().unwrap();
    assert!((end.q[1] - 1e7f64.cos()).abs() < 1e-7);
}

/// A zero anywhere in the first long step by series is found once.
#[test]
fn zeros_early_in_the_first_step_by_series() {
    let system = Pair::new(1.0, 1.0, 0.0, 1.0);
    for k in 1..200 {
        let zero = 0.01 * f64::from(k);
        let start = State::new(0.0, [0.0, zero.sin()], [0.0, -zero.cos()]);
        let run =
            integrate(&system, Taylor::of_order(20), TaylorController::tolerance(1e-12), start).until(3.0);
        let times: Vec<f64> = run.events(either(&|s| s.q[1])).map(|e| e.unwrap().state.t).collect();
        assert!(times.len() == 1 && (times[0] - zero).abs() < 1e-11, "{times:?} for {zero}");
    }
}

/// A body that falls: x, y.
struct Fall;

impl System<2> for Fall {
    type Scalar = f64;

    fn accel(&self, _: &SVector<f64, 2>, _: &SVector<f64, 2>, _: f64) -> SVector<f64, 2> {
        SVector::from([0.0, -9.81])
    }
}

/// Shots into a corner, which meet the ground and the wall at one time but for rounding. Each has to be thrown back
/// from both, whichever is met first, and whether events of one time are taken one by one or the run is restarted at
/// once.
#[test]
fn shots_into_a_corner_meet_both_sides() {
    for (drained, nudge) in
        [(false, 0.0), (true, 0.0), (false, 1e-9), (false, -1e-9), (true, 1e-12), (false, -1e-13)]
    {
        for k in 0..200 {
            let height = 0.3 + 0.01 * f64::from(k);
            let fall = (2.0 * height / 9.81).sqrt();
            let start = State::new(0.0, [0.0, height], [(1.0 + nudge) / fall, 0.0]);
            let sides = (
                falling(&|s: &State<f64, 2>| s.q[1]).terminal(),
                either(&|s: &State<f64, 2>| s.q[0] - 1.0).terminal(),
            );
            let mut events = integrate(&Fall, Dop853, PiController::tolerance(1e-10), start)
                .until(1.5 * fall)
                .events(sides);
            let mut met = [0; 2];
            while let Some(event) = events.next() {
                let Occurrence { event, mut state, .. } = event.unwrap();
                let mut back = |event: usize, state: &mut State<f64, 2>| {
                    met[event] += 1;
                    state.qd[1 - event] *= -0.8;
                };
                back(event, &mut state);
                while drained && let Some(other) = events.next() {
                    back(other.unwrap().event, &mut state);
                }
                events.restart(state);
            }
            let end = *events.state();
            assert_eq!(met, [1, 1], "{drained} {nudge} {k}");
            let speed = (1.0 + nudge) / fall;
            assert!((end.q[0] - (1.0 - 0.8 * speed * 0.5 * fall)).abs() < 1e-8 && end.q[1] > 0.0, "{end:?}");
        }
    }
}

/// A surface that is passed at the time of an impact is passed once, whatever the impact does to the other velocities.
#[test]
fn what_is_passed_at_an_impact_is_told_once() {
    for k in 0..200 {
        let height = 0.3 + 0.01 * f64::from(k);
        let fall = (2.0 * height / 9.81).sqrt();
        let start = State::new(0.0, [0.0, height], [1.0 / fall, 0.0]);
        let events = (
            falling(&|s: &State<f64, 2>| s.q[1]).terminal(),
            rising(&|s: &State<f64, 2>| s.q[0] - 1.0),
            falling(&|s: &State<f64, 2>| s.q[0] - 1.0),
        );
        let mut events =
            integrate(&Fall, Dop853, PiController::tolerance(1e-10), start).until(1.5 * fall).events(events);
        let mut met = [0; 3];
        while let Some(event) = events.next() {
            let Occurrence { event, mut state, .. } = event.unwrap();
            met[event] += 1;
            if event == 0 {
                state.qd[1] *= -0.8;
                events.restart(state);
            }
        }
        assert_eq!(met, [1, 1, 0], "{k}");
    }
}

/// A mass under a constant force passes the place and the speed of a stop at one time, within some roundings: both are
/// met by a stepper that goes on, and by a run that is restarted.
#[test]
#[cfg_attr(not(feature = "long"), ignore = "long")]
fn a_place_and_a_speed_at_one_time_are_both_met() {
    struct Push(f64);
    impl System<1> for Push {
        type Scalar = f64;
        fn accel(&self, _: &SVector<f64, 1>, _: &SVector<f64, 1>, _: f64) -> SVector<f64, 1> {
            SVector::from([self.0])
        }
    }
    for k in 0..600 {
        let (force, end) = (0.3 + 0.037 * f64::from(k % 60), 0.5 + 0.11 * f64::from(k / 7));
        let (place, speed) = (0.5 * force * end * end, force * end);
        let (at_place, at_speed) = (|s: &State<f64, 1>| s.q[0] - place, |s: &State<f64, 1>| s.qd[0] - speed);
        let stops = (Event::rising(at_place).terminal(), Event::rising(at_speed).terminal());
        let (push, start) = (Push(force), State::new(0.0, [0.0], [0.0]));
        for tolerance in [1e-6, 1e-8, 1e-10, 1e-12] {
            let pi = PiController::tolerance(tolerance);
            let mut stepper = Stepper::new(Push(force), Dop853, pi, start);
            let mut met = [0; 2];
            while let Some(event) = stepper.until(1.5 * end).events(stops).next() {
                met[event.unwrap().event] += 1;
            }
            assert_eq!(met, [1, 1], "stepper {k} {tolerance:e}");
            let mut events = integrate(&push, Dop853, pi, start).until(1.5 * end).events(stops);
            let mut met = [0; 2];
            while let Some(event) = events.next() {
                let event = event.unwrap();
                met[event.event] += 1;
                events.restart(event.state);
            }
            assert_eq!(met, [1, 1], "run {k} {tolerance:e}");
        }
    }
}

/// The same by a stepper, whose events are looked for anew after each of them.
#[test]
fn a_stepper_meets_both_sides_of_a_corner() {
    for (k, other_order) in (0..200).flat_map(|k| [(k, false), (k, true)]) {
        let height = 0.3 + 0.01 * f64::from(k);
        let fall = (2.0 * height / 9.81).sqrt();
        let start = State::new(0.0, [0.0, height], [1.0 / fall, 0.0]);
        let ground = falling(&|s: &State<f64, 2>| s.q[1]).terminal().named("ground");
        let wall = either(&|s: &State<f64, 2>| s.q[0] - 1.0).terminal().named("wall");
        let mut body = Stepper::new(Fall, Dop853, PiController::tolerance(1e-10), start);
        let mut met = [0; 2];
        loop {
            let event = match other_order {
                false => body.until(1.5 * fall).events((ground, wall)).next(),
                true => body.until(1.5 * fall).events((wall, ground)).next(),
            };
            let Some(event) = event else { break };
            let Occurrence { name, mut state, .. } = event.unwrap();
            let index = usize::from(name == "wall");
            met[index] += 1;
            state.qd[1 - index] *= -0.8;
            body.set_state(state).unwrap();
        }
        assert_eq!(met, [1, 1], "{k} {other_order}");
    }
}
