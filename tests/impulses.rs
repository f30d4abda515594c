//! Conditions on which an impulse acts: momenta and potentials that jump. Runs across them fail, whatever the method,
//! and go on where the impulse was given at an event.
#![allow(deprecated)]

use lagrange_runtime::analysis::{AnalysisError, ByVariationalEquations, fundamental_matrix};
use lagrange_runtime::ensemble::{Collect, Ensemble, Table};
use lagrange_runtime::failure::Requirement;
use lagrange_runtime::integrate::Failed;
use lagrange_runtime::lanes::{FinalState, Fused};
use lagrange_runtime::prelude::*;
use lagrange_runtime::traits::InvalidTable;

lagrangian! {
    /// A mass on its way that picks up another one.
    system PickUp {
        param m1 = 1.0, m2 = 3.0, gap = 1.0;
        coord x;
        let y = max(x - gap, 0);
        T = 0.5 * m1 * dot(x).powi(2) + 0.5 * m2 * dot(y).powi(2);
        V = 0;
        event met: x - gap;
    }
}

lagrangian! {
    /// A step of the potential in the plane.
    system Edge {
        param m = 1.0, high = -1.0, place = 1.0, width = 1e9;
        coord x, y;
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
        let beyond = x - place;
        V = if beyond * (width - beyond) > 0 { high } else { 0 };
        event met: x - place;
    }
}

lagrangian! {
    /// A base that starts to move at once.
    system Base {
        param m = 1.0, k = 4.0;
        coord x;
        coord p = 0.5 * max(t - 1, 0);
        T = 0.5 * m * (dot(x) + dot(p)).powi(2);
        V = 0.5 * k * x.powi(2);
    }
}

lagrangian! {
    /// A spring that sets in with time: no impulse acts.
    system SetsIn {
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = if t > 1 { 0.5 * x.powi(2) } else { 0 };
    }
}

lagrangian! {
    /// Springs at a floor and beyond a gap, and dry friction: forces jump or have kinks, momenta do not.
    system Touches {
        param k = 100.0, c = 0.1;
        coord x;
        let depth = max(-x, 0);
        T = 0.5 * dot(x).powi(2);
        V = 9.81 * x + 0.5 * k * depth.powi(2) + if x > 2 { k * (x - 2) } else { 0 };
        Q[x] = -c * signum(dot(x));
    }
}

lagrangian! {
    /// A base that is somewhere else at once.
    system Displaced {
        param m = 1.0, k = 4.0;
        coord x;
        coord p = if t < 1 { 0 } else { 0.1 };
        T = 0.5 * m * (dot(x) + dot(p)).powi(2);
        V = 0.5 * k * x.powi(2);
    }
}

lagrangian! {
    /// A mass that is elsewhere beyond a place, by a binding.
    system Shifted {
        coord x;
        let y = x + if x > 1 { 0.1 } else { 0 };
        T = 0.5 * dot(y).powi(2);
        V = 0;
    }
}

lagrangian! {
    /// The same on a frame.
    system OnAFrame {
        coord x, a;
        let f = frame(world, [x, signum(x - 1), 0], rotation_x(a));
        T = body(1, [1, 1, 1], f);
        V = 0;
        observe jumps = dot(if t < 2 { x } else { 2 * x });
    }
}

lagrangian! {
    /// The base acts by a spring alone, and an output jumps.
    system Sprung {
        coord x;
        coord p = if t < 1 { 0 } else { 0.1 };
        T = 0.5 * dot(x).powi(2);
        V = 0.5 * (x - p).powi(2);
        observe speed = dot(p);
    }
}

lagrangian! {
    /// A position in two parts that meet.
    system Parts {
        coord x;
        let y = if x > 1 { x * x } else { 2 * x - 1 };
        T = 0.5 * dot(y).powi(2);
        V = 0;
    }
}

lagrangian! {
    /// A mass on a ring of springs, and a torsional spring that acts on the angle to it.
    system Torsion {
        param k = 0.5, off = 1.0;
        coord x, y;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = 50 * (hypot(x, y) - 1).powi(2) + 0.5 * k * (atan2(y, x) - off).powi(2);
    }
}

lagrangian! {
    /// A base that moves as a saw.
    system Saw {
        param a = 0.5;
        coord x;
        coord p = a * atan2(sin(3 * t), cos(3 * t));
        T = 0.5 * (dot(x) + dot(p)).powi(2);
        V = 0.5 * x.powi(2);
    }
}

/// Calls a macro with methods of all families.
macro_rules! with_methods {
    ($case:ident) => {
        $case!(Dop853, PiController::tolerance(1e-9));
        $case!(DormandPrince5, PiController::tolerance(1e-6));
        $case!(Radau5, PiController::tolerance(1e-6));
        $case!(Rodas5P, PiController::tolerance(1e-6));
        $case!(Taylor, TaylorController::tolerance(1e-12));
        $case!(Rk4, FixedStep::new(0.07));
        $case!(Gauss4, FixedStep::new(0.07));
        $case!(Rk4, FixedStep::new(0.125));
    };
}

/// The time at which the run ended for an impulse that it does not know.
fn impulse<const N: usize>(end: Result<State<f64, N>, Failed<f64, N>>) -> f64 {
    match end {
        Err(Failed { failure: Failure::UnknownImpulse { t }, .. }) => t,
        other => panic!("{other:?}"),
    }
}

#[test]
fn switches_with_impulses_are_known() {
    let counts = [
        <PickUp as System<1>>::IMPULSES,
        <Edge as System<2>>::IMPULSES,
        <Base as System<1>>::IMPULSES,
        <SetsIn as System<1>>::IMPULSES,
        <Touches as System<1>>::IMPULSES,
        <Displaced as System<1>>::IMPULSES,
        <Shifted as System<1>>::IMPULSES,
        <OnAFrame as System<2>>::IMPULSES,
        <Sprung as System<1>>::IMPULSES,
        <Parts as System<1>>::IMPULSES,
    ];
    assert_eq!(counts, [1, 1, 1, 0, 0, 1, 1, 1, 0, 0]);
}

#[test]
fn runs_across_an_impulse_fail() {
    macro_rules! fails {
        ($method:expr, $control:expr) => {
            let (start, edge) = (State::new(0.0, [0.0], [1.0]), State::new(0.0, [0.0, 0.0], [1.0, 0.5]));
            let ends = [
                impulse(integrate(&PickUp::default(), $method, $control, start).until(3.0).final_state()),
                impulse(integrate(&Edge::default(), $method, $control, edge).until(3.0).final_state()),
                impulse(integrate(&Base::default(), $method, $control, start).until(3.0).final_state()),
                impulse(integrate(&Displaced::default(), $method, $control, start).until(3.0).final_state()),
                impulse(integrate(&Shifted::default(), $method, $control, start).until(3.0).final_state()),
                impulse(integrate(&OnAFrame::default(), $method, $control, edge).until(3.0).final_state()),
                // Within the last step.
                impulse(integrate(&Edge::default(), $method, $control, edge).until(1.01).final_state()),
            ];
            for t in ends {
                assert!((t - 1.0).abs() <= 0.13, "{}: {t}", stringify!($method));
            }
            let before = integrate(&PickUp::default(), $method, $control, start).until(0.99).final_state();
            assert!((before.unwrap().q[0] - 0.99).abs() < 1e-12);
        };
    }
    with_methods!(fails);
}

/// The principal value of an angle jumps on one side of the origin, and on the other side nothing does.
#[test]
fn angles_have_a_cut() {
    let torsion = Torsion::default();
    macro_rules! cuts {
        ($method:expr, $control:expr) => {
            let name = stringify!($method);
            let left = State::new(0.0, [0.0, 1.0], [-1.5, 0.0]);
            let t = impulse(integrate(&torsion, $method, $control, left).until(3.0).final_state());
            assert!((t - 1.6238).abs() < 0.13, "{name}: {t}");
            let saw = State::new(0.1, [0.3], [0.0]);
            let t = impulse(integrate(&Saw::default(), $method, $control, saw).until(3.0).final_state());
            assert!((t - core::f64::consts::PI / 3.0).abs() < 0.13, "{name}: {t}");
        };
    }
    with_methods!(cuts);
    macro_rules! goes_on {
        ($method:expr, $control:expr, $within:expr) => {
            let right = State::new(0.0, [1.0, 0.5], [0.0, -1.0]);
            let end = integrate(&torsion, $method, $control, right).until(3.0).final_state().unwrap();
            // DOP853 of SciPy, rtol = 3e-14.
            let expected = [1.07755417, 0.10587988, 0.82551944, 0.87410309];
            let found = [end.q[0], end.q[1], end.qd[0], end.qd[1]];
            for (found, expected) in found.into_iter().zip(expected) {
                assert!((found - expected).abs() < $within, "{}: {found} {expected}", stringify!($method));
            }
        };
    }
    goes_on!(Dop853, PiController::tolerance(1e-11), 1e-8);
    goes_on!(Taylor, TaylorController::tolerance(1e-14), 1e-8);
    goes_on!(Radau5, PiController::tolerance(1e-10), 1e-6);
    goes_on!(Rk4, FixedStep::new(0.01), 1e-4);
}

/// A potential step narrower than the steps of the motion.
#[test]
fn a_narrow_step_is_met() {
    macro_rules! fails {
        ($method:expr, $control:expr) => {
            let narrow = Edge { width: 0.02, ..Edge::default() };
            let start = State::new(0.0, [0.0, 0.0], [1.0, 0.5]);
            let t = impulse(integrate(&narrow, $method, $control, start).until(3.0).final_state());
            assert!((t - 1.0).abs() < 1e-6, "{}: {t}", stringify!($method));
        };
    }
    fails!(Dop853, PiController::tolerance(1e-9));
    fails!(Radau5, PiController::tolerance(1e-6));
    fails!(Taylor, TaylorController::tolerance(1e-12));
}

#[test]
fn motions_go_on_after_the_impulse_at_an_event() {
    // A plastic impact, and the corner of a stationary action.
    let masses = |at: &State<f64, 1>| State { qd: at.qd * 0.25, ..*at };
    let edge = |at: &State<f64, 2>| {
        let normal = (at.qd[0].powi(2) + 2.0).sqrt();
        State { qd: [normal, at.qd[1]].into(), ..*at }
    };
    macro_rules! goes_on {
        ($method:expr, $control:expr) => {
            let name = stringify!($method);
            let system = PickUp::default();
            let start = State::new(0.0, [0.0], [1.0]);
            let end = integrate(&system, $method, $control, start).until(5.0).events(PickUp::MET.terminal());
            let met = end.last().unwrap().unwrap().state;
            let after = integrate(&system, $method, $control, masses(&met)).until(5.0).final_state().unwrap();
            assert!((after.q[0] - 2.0).abs() < 1e-9, "{name}: {after:?}");

            let start = State::new(0.0, [0.0, 0.0], [1.0, 0.5]);
            let mut stepper = Stepper::new(Edge::default(), $method, $control, start);
            while let Some(event) = stepper.until(3.0).events(Edge::MET).next() {
                stepper.set_state(edge(&event.unwrap().state)).unwrap();
            }
            let [x, y] = stepper.state().q.into();
            let right = [1.0 + 2.0 * 3.0_f64.sqrt(), 1.5];
            assert!((x - right[0]).abs() < 1e-9 && (y - right[1]).abs() < 1e-9, "{name}: {x} {y}");
        };
    }
    with_methods!(goes_on);
}

/// Energy from an instant on that acts on nothing before it.
#[test]
fn potentials_that_set_in_with_time_have_none() {
    macro_rules! right {
        ($method:expr, $control:expr, $within:expr) => {
            let start = State::new(0.0, [0.5], [1.0]);
            let end =
                integrate(&SetsIn::default(), $method, $control, start).until(3.0).final_state().unwrap();
            let right = 1.5 * 2.0_f64.cos() + 2.0_f64.sin();
            assert!((end.q[0] - right).abs() < $within, "{}: {end:?}", stringify!($method));
        };
    }
    right!(Dop853, PiController::tolerance(1e-11), 1e-9);
    right!(Taylor, TaylorController::tolerance(1e-14), 1e-12);
}

#[test]
fn a_stepper_fails_in_the_call_that_crosses() {
    let start = State::new(0.0, [0.0], [1.0]);
    let mut pick_up = Stepper::new(PickUp::default(), Rk4, FixedStep::new(0.3), start);
    pick_up.advance_to(0.9).unwrap();
    assert!(matches!(pick_up.advance_to(1.1), Err(Failure::UnknownImpulse { .. })));
    let start = State::new(0.0, [0.0], [1.0]);
    let mut pick_up = Stepper::new(PickUp::default(), Dop853, PiController::tolerance(1e-9), start);
    let failed = pick_up.until(2.0).last().unwrap().err().unwrap();
    let text = failed.to_string();
    assert!(text.contains("an impulse acts"), "{text}");
}

/// The impulse is to be given, whatever call comes next, and no sample lies beyond it.
#[test]
fn a_stepper_goes_on_once_the_impulse_is_given() {
    macro_rules! waits {
        ($method:expr, $control:expr) => {
            let name = stringify!($method);
            let start = State::new(0.0, [0.0, 0.0], [1.0, 0.5]);
            let mut stepper = Stepper::new(Edge::default(), $method, $control, start);
            let met = stepper.until(2.0).events(Edge::MET).next().unwrap().unwrap();
            assert!((met.state.q[0] - 1.0).abs() < 1e-9, "{name}");
            let next = stepper.until(2.0).events(Edge::MET).next();
            assert!(matches!(next, Some(Err(Failure::UnknownImpulse { .. }))), "{name}: {next:?}");
            for _ in 0..2 {
                assert!(matches!(stepper.advance_to(2.0), Err(Failure::UnknownImpulse { .. })), "{name}");
                assert!(matches!(stepper.step(), Err(Failure::UnknownImpulse { .. })), "{name}");
            }
            let given = State { qd: [3.0f64.sqrt(), 0.5].into(), ..met.state };
            stepper.set_state(given).unwrap();
            stepper.advance_to(2.0).unwrap();
            assert!((stepper.state().q[0] - 1.0 - 3.0f64.sqrt()).abs() < 1e-9, "{name}");
            let edge = Edge::default();
            let samples = integrate(&edge, $method, $control, start).until(2.0).sample([0.9, 0.95, 1.1, 1.2]);
            let seen: Vec<_> = samples.map(|at| at.map(|at| at.q[0])).collect();
            assert!(
                matches!(seen[..], [Ok(_), Ok(_), Err(Failure::UnknownImpulse { .. })]),
                "{name}: {seen:?}"
            );
        };
    }
    with_methods!(waits);
    waits!(Rk4, FixedStep::new(0.3));
}

#[test]
fn lanes_fail_as_alone() {
    let draw = |[number]: [u64; 1]| (PickUp::default(), State::new(0.0, [0.0], [0.1 + 0.2 * number as f64]));
    let samples = Table::new((0..11).map(|number: u64| [number]));
    macro_rules! same {
        ($method:expr, $control:expr) => {
            let lanes =
                || Ensemble::new(samples.clone(), 11, draw).integrate($method, $control, 1.0).in_lanes(Fused);
            let end = FinalState(|_: &PickUp, end: &State<f64, 1>| end.q[0].to_bits());
            let outcome = lanes().observe(&end, Collect).unwrap();
            let (mut good, mut failed) = (outcome.statistic.rows.iter(), outcome.failures.kept.iter());
            for index in 0..11 {
                match lanes().replay(index).unwrap().run().final_state() {
                    Ok(end) => assert_eq!(good.next(), Some(&(index, end.q[0].value().to_bits()))),
                    Err(end) => {
                        let found = failed.next().unwrap();
                        assert!(matches!(end.failure, Failure::UnknownImpulse { .. }), "{end:?}");
                        let last = [found.last.unwrap().t, found.last.unwrap().q[0]];
                        assert_eq!(last, [end.last.t.value(), end.last.q[0].value()], "{index}");
                    }
                }
            }
            assert_eq!((outcome.failures.count, good.next()), (6, None));
        };
    }
    same!(Dop853, PiController::tolerance(1e-9));
    same!(Rk4, FixedStep::new(0.07));
    same!(Taylor, TaylorController::tolerance(1e-12));
}

lagrangian! {
    /// A plateau in a corner of the plane, and what is beyond two lines.
    system Plateau {
        param high = 0.3;
        coord x, y;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = if x > 1 && y > 1 { high } else { 0 } + if x < -1 || y < -1 { 0.2 * x } else { 0 };
    }
}

/// Conditions that stand together end a run where the energy jumps, and not where one of them changes alone.
#[test]
fn conditions_stand_together() {
    let plateau = Plateau::default();
    assert_eq!(<Plateau as System<2>>::IMPULSES, 4);
    macro_rules! stands {
        ($method:expr, $control:expr) => {
            let name = stringify!($method);
            let end = |[x, y]: [f64; 2], qd: [f64; 2], t: f64| {
                integrate(&plateau, $method, $control, State::new(0.0, [x, y], qd)).until(t).final_state()
            };
            // Past x = 1 below the plateau, past y = 1 beside it, and onto it.
            for (from, qd) in [([0.0, 0.5], [1.0, 0.1]), ([0.5, 0.0], [0.1, 1.0])] {
                let right = [from[0] + 2.0 * qd[0], from[1] + 2.0 * qd[1]];
                let to = end(from, qd, 2.0).unwrap();
                assert!((to.q - SVector::from(right)).amax() < 1e-12, "{name}: {to:?}");
            }
            for (from, qd) in [([0.0, 0.5], [1.0, 1.0]), ([1.5, 0.0], [0.0, 1.0]), ([0.0, 1.5], [1.0, 0.0])] {
                let t = impulse(end(from, qd, 3.0));
                assert!((t - 1.0).abs() <= 0.13, "{name}: {t}");
            }
            // From one of the lines over the other one, where the force is there already, and out from it.
            let to = end([-2.0, -0.5], [0.0, -1.0], 1.0).unwrap();
            assert!((to.q - SVector::from([-2.1, -1.5])).amax() < 1e-9, "{name}: {to:?}");
            let t = impulse(end([-0.5, 0.0], [-0.5, 0.0], 3.0));
            assert!((t - 1.0).abs() <= 0.13, "{name}: {t}");
        };
    }
    with_methods!(stands);
}

lagrangian! {
    /// A step of the potential, and an inertia, by the quotient of a place and its size.
    system Quotients {
        param dm = 0.5, k = 1.0;
        coord x, y;
        T = 0.5 * (1 + dm * x / abs(x)) * dot(x).powi(2) + 0.5 * dot(y).powi(2);
        V = k * y / sqrt(y * y);
    }
}

/// x/|x| is a sign.
#[test]
fn quotients_of_a_place_and_its_size_are_signs() {
    assert_eq!(<Quotients as System<2>>::IMPULSES, 2);
    macro_rules! fails {
        ($method:expr, $control:expr) => {
            for (q, qd) in [([-1.0, 1.0], [1.0, 0.0]), ([1.0, -1.0], [0.0, 1.0])] {
                let quotients = Quotients::default();
                let t = impulse(
                    integrate(&quotients, $method, $control, State::new(0.0, q, qd)).until(3.0).final_state(),
                );
                assert!((t - 1.0).abs() <= 0.13, "{}: {t}", stringify!($method));
            }
        };
    }
    with_methods!(fails);
}

/// Some lanes cross the ray on the side of the cut, and some on the other one.
#[test]
fn lanes_know_the_side_of_a_cut() {
    let draw = |[number]: [u64; 1]| {
        let side = if number % 3 == 0 { -1.0 } else { 1.0 };
        (Torsion::default(), State::new(0.0, [side, 0.5], [0.0, -1.0 - 0.01 * number as f64]))
    };
    let samples = Table::new((0..12).map(|number: u64| [number]));
    macro_rules! same {
        ($method:expr, $control:expr) => {
            let lanes =
                || Ensemble::new(samples.clone(), 12, draw).integrate($method, $control, 1.0).in_lanes(Fused);
            let end = FinalState(|_: &Torsion, end: &State<f64, 2>| end.q[0].to_bits());
            let outcome = lanes().observe(&end, Collect).unwrap();
            let failed: Vec<u64> = outcome.failures.kept.iter().map(|failed| failed.index).collect();
            assert_eq!(failed, [0, 3, 6, 9]);
            for (index, bits) in &outcome.statistic.rows {
                let alone = lanes().replay(*index).unwrap().run().final_state().unwrap();
                assert_eq!(alone.q[0].value().to_bits(), *bits, "{index}");
            }
        };
    }
    same!(Dop853, PiController::tolerance(1e-9));
    same!(Rk4, FixedStep::new(0.07));
    same!(Taylor, TaylorController::tolerance(1e-12));
}

/// Deviations at an edge of the potential depend on the impulse, too.
#[test]
fn derivatives_across_an_impulse_are_refused() {
    let (edge, start) = (Edge::default(), State::new(0.0, [0.0, 0.0], [1.0, 0.5]));
    let flow = ByVariationalEquations::<_, 10>::new(&edge, 1e-9);
    assert!(fundamental_matrix(&flow, &start, 0.9).is_ok());
    let refused = fundamental_matrix(&flow, &start, 2.0);
    assert!(matches!(refused, Err(AnalysisError::Run(Failure::UnknownImpulse { .. }))), "{refused:?}");
}

lagrangian! {
    /// A bead on a curve that was measured.
    system Follower {
        coord x;
        extern profile: Curve(x);
        T = 0.5 * (dot(x).powi(2) + dot(profile(x)).powi(2));
        V = 9.81 * profile(x);
    }
}

lagrangian! {
    /// A mass on a base that moves as was measured.
    system Shaken {
        coord x;
        extern path: Curve(t);
        coord p = path(t);
        T = 0.5 * (dot(x) + dot(p)).powi(2);
        V = 0.5 * x.powi(2);
    }
}

/// A momentum that depends on the slope of a table of chords jumps at its knots.
#[test]
fn tables_of_chords_in_momenta_are_refused() {
    let (knots, heights) = ([-1.0, 0.0, 1.0, 2.0], [1.0, 0.0, 0.3, 0.3]);
    let table = |make: fn(&[f64], &[f64], Beyond) -> Result<Curve, InvalidTable>, beyond| {
        make(&knots, &heights, beyond).unwrap()
    };
    let start = State::new(0.0, [0.5], [0.2]);
    let failure = |curve: Curve| {
        let (follower, shaken) = (Follower::new(curve.clone()), Shaken::new(curve));
        macro_rules! failure {
            ($method:expr, $control:expr) => {{
                let first = integrate(&follower, $method, $control, start).until(0.01).final_state().err();
                let second = integrate(&shaken, $method, $control, start).until(0.01).final_state().err();
                [first.map(|end| end.failure), second.map(|end| end.failure)]
            }};
        }
        let ends = failure!(Dop853, PiController::tolerance(1e-9));
        assert_eq!(ends, failure!(Rk4, FixedStep::new(1e-3)));
        ends
    };
    let refused = |chosen| Some(Failure::Unsuitable { chosen, requirement: Requirement::ContinuousSlope });
    let both = [refused("profile"), refused("path")];
    assert_eq!(failure(table(Curve::linear, Beyond::Line)), both);
    assert_eq!(failure(table(Curve::cubic, Beyond::Held)), both);
    // The last slope is 0, the first one not.
    assert_eq!(failure(table(Curve::monotone, Beyond::Held)), both);
    for smooth in [Curve::cubic, Curve::monotone] {
        for beyond in [Beyond::Line, Beyond::Refused] {
            assert_eq!(failure(table(smooth, beyond)), [None, None]);
        }
    }
    // A straight line, and a rise between two dwells.
    let line = Curve::linear(&[-1.0, 0.0, 3.0], &[-0.1, 0.0, 0.3], Beyond::Line).unwrap();
    let rise = Curve::monotone(&[-1.0, 0.0, 1.0, 2.0], &[0.0, 0.0, 1.0, 1.0], Beyond::Held).unwrap();
    assert_eq!([failure(line), failure(rise)], [[None, None]; 2]);
}

lagrangian! {
    /// A disc in a bowl, on which the potential is lower.
    system Disc {
        param r = 1.0, high = 0.3;
        coord x, y;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = 0.05 * (x * x + y * y) + if x * x + y * y < r * r { -high } else { 0 };
        event rim: x * x + y * y - r * r;
    }
}

/// Dozens of refractions and total reflections at the rim keep the energy and the angular momentum.
#[test]
fn refractions_keep_energy_and_angular_momentum() {
    let disc = Disc::default();
    let energy = |at: &State<f64, 2>, inside: bool| {
        let lower = if inside { disc.high } else { 0.0 };
        0.5 * at.qd.norm_squared() + 0.05 * at.q.norm_squared() - lower
    };
    let spin = |at: &State<f64, 2>| at.q[0] * at.qd[1] - at.q[1] * at.qd[0];
    macro_rules! keeps {
        ($method:expr, $control:expr) => {
            for k in 0..2 {
                let push = 5.0 * f64::from(k);
                let start = State::new(0.0, [2.0, 0.0], [-1.0 - 0.05 * push, 0.04 * push]);
                let mut events = integrate(&disc, $method, $control, start).until(50.0).events(Disc::RIM);
                let (mut met, mut inside) = (0, false);
                while let Some(event) = events.next() {
                    let mut at = event.unwrap().state;
                    let normal = at.q.normalize();
                    let across = at.qd.dot(&normal);
                    let gained = if across < 0.0 { 2.0 * disc.high } else { -2.0 * disc.high };
                    let square = across * across + gained;
                    let after = if square > 0.0 { square.sqrt().copysign(across) } else { -across };
                    at.qd += normal * (after - across);
                    (met, inside) = (met + 1, after < 0.0);
                    events.restart(at);
                }
                let end = events.state();
                let errors = [energy(end, inside) - energy(&start, false), spin(end) - spin(&start)];
                assert!(met > 10 && errors.iter().all(|e| e.abs() < 1e-6), "{k}: {met}, {errors:?}");
            }
        };
    }
    keeps!(Dop853, PiController::tolerance(1e-11));
    keeps!(Taylor, TaylorController::tolerance(1e-14));
    keeps!(Gauss4, FixedStep::new(0.01));
}
