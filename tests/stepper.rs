//! Steppers and sampled control: the steps of a run bit for bit, whatever changes in between, and closed forms of
//! held inputs.

use lagrange_runtime::failure::Requirement;
use lagrange_runtime::prelude::*;
use lagrange_runtime::{Advance, Controller, Direction, Statistics, Stepper};
use std::collections::HashMap;
use std::fmt::Debug;

lagrangian! {
    /// A mass on which a force acts, beside a weak spring.
    system Driven {
        param m, k;
        input u;
        coord x;
        T = 0.5 * m * dot(x).powi(2);
        V = 0.5 * k * x.powi(2);
        Q[x] = u;
    }
}

lagrangian! {
    /// A double pendulum with motors in its joints.
    system Motors {
        param m1, m2, l1, l2, g = 9.81;
        input u: [2];
        coord a, b;
        let x1 = l1 * a.sin();
        let y1 = -l1 * a.cos();
        let x2 = x1 + l2 * b.sin();
        let y2 = y1 - l2 * b.cos();
        T = 0.5 * m1 * (dot(x1).powi(2) + dot(y1).powi(2)) + 0.5 * m2 * (dot(x2).powi(2) + dot(y2).powi(2));
        V = m1 * g * y1 + m2 * g * y2;
        Q[a] = u[0] - u[1];
        Q[b] = u[1];
    }
}

lagrangian! {
    /// A pendulum by its Cartesian coordinates.
    system Rod {
        param l, g = 9.81;
        coord x, y;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = g * y;
        constraint rod: x.powi(2) + y.powi(2) == l.powi(2);
    }
}

const MOTORS: Motors = Motors { m1: 1.0, m2: 0.7, l1: 1.0, l2: 0.8, g: 9.81, u: [0.0; 2] };
const SWUNG: State<f64, 2> =
    State { t: 0.0, q: SVector::<f64, 2>::new(1.5, 2.0), qd: SVector::<f64, 2>::new(0.0, 0.3) };
const AT_ONE: State<f64, 1> =
    State { t: 0.0, q: SVector::<f64, 1>::new(1.0), qd: SVector::<f64, 1>::new(0.0) };

fn motors() -> Stepper<Motors, Dop853, PiController, 2> {
    Stepper::new(MOTORS, Dop853, PiController::tolerance(1e-9), SWUNG)
}

fn end_of<M: Method<Motors, 2>, C: Controller<f64, 2, M::Error>>(
    system: &Motors,
    (method, controller): (M, C),
    start: State<f64, 2>,
    end: f64,
) -> State<f64, 2> {
    integrate(system, method, controller, start).until(end).final_state().unwrap()
}

/// Bit for bit: as a run, however often it is interrupted, and after changes of the system.
fn goes_as_a_run<M, C>(method: M, controller: C, fixed: bool)
where
    M: Method<Motors, 2> + Clone + Debug,
    C: Controller<f64, 2, M::Error>,
{
    let how = (method.clone(), controller.clone());
    let at_one = end_of(&MOTORS, how.clone(), SWUNG, 1.0);
    let mut stepper = Stepper::new(MOTORS, method.clone(), controller.clone(), SWUNG);
    let mut interrupted = stepper.clone();
    stepper.advance_to(1.0).unwrap();
    assert_eq!(*stepper.state(), at_one, "{method:?}");
    let mut calls = 0;
    while interrupted.advance_within(1.0, 1).unwrap() == Advance::NotYet {
        calls += 1;
    }
    assert_eq!(*interrupted.state(), at_one, "{method:?}");
    assert!(calls > 5);
    assert_eq!(interrupted.statistics(), stepper.statistics());
    // Other parameters, and then other inputs.
    stepper.system_mut().g = 3.0;
    stepper.advance_to(1.5).unwrap();
    stepper.set_inputs([2.0, -0.5]).unwrap();
    stepper.advance_to(2.0).unwrap();
    let changed = Motors { g: 3.0, ..MOTORS };
    let at_three_halves = end_of(&changed, how.clone(), at_one, 1.5);
    let at_two = end_of(&Motors { u: [2.0, -0.5], ..changed }, how, at_three_halves, 2.0);
    let difference = stepper.state().minus(&at_two);
    let distance = difference.q.amax().max(difference.qd.amax());
    // (An adaptive step goes on with its size, and a run chooses one.)
    assert!(if fixed { distance == 0.0 } else { distance < 1e-5 }, "{method:?}: {distance:e}");
}

#[test]
fn a_stepper_goes_as_a_run() {
    goes_as_a_run(Rk4, FixedStep::new(0.01), true);
    goes_as_a_run(Gauss4, FixedStep::new(0.02), true);
    goes_as_a_run(VariationalMidpoint, FixedStep::new(0.02), true);
    goes_as_a_run(Dop853, FixedStep::new(0.05), true);
    goes_as_a_run(Dop853, PiController::tolerance(1e-9), false);
    goes_as_a_run(DormandPrince5, PiController::tolerance(1e-8), false);
    goes_as_a_run(Taylor::of_order(16), TaylorController::tolerance(1e-9), false);
    goes_as_a_run(Radau5, PiController::tolerance(1e-9), false);
    goes_as_a_run(Rodas5P, PiController::tolerance(1e-8), false);
}

/// The propagator of a linear system knows its parameters and its force.
#[test]
fn an_exponential_follows_the_parameters() {
    let start = Driven { u: 0.5, ..Driven::new(1.0, 4.0) };
    let mut stepper = Stepper::new(start, MatrixExponential, FixedStep::new(0.5), AT_ONE);
    stepper.advance_to(3.0).unwrap();
    stepper.set_inputs([-2.0]).unwrap();
    stepper.advance_to(5.0).unwrap();
    stepper.system_mut().k = 9.0;
    stepper.advance_to(6.0).unwrap();
    // x = u/k + …, in three parts.
    let turned = |[x, v]: [f64; 2], omega: f64, u: f64, t: f64| {
        let (sin, cos) = (omega * t).sin_cos();
        let rest = u / omega.powi(2);
        [rest + (x - rest) * cos + v / omega * sin, (rest - x) * omega * sin + v * cos]
    };
    let exact = turned(turned(turned([1.0, 0.0], 2.0, 0.5, 3.0), 2.0, -2.0, 2.0), 3.0, -2.0, 1.0);
    assert!(
        (stepper.state().q[0] - exact[0]).abs() < 1e-14 && (stepper.state().qd[0] - exact[1]).abs() < 1e-14
    );
}

#[test]
fn steps_are_those_of_a_run() {
    let mut stepper = motors();
    for step in integrate(&MOTORS, Dop853, PiController::tolerance(1e-9), SWUNG).take(100) {
        let (ours, theirs) = (stepper.step().unwrap(), step.unwrap());
        assert_eq!((ours.to, ours.h), (theirs.to, theirs.h));
        let middle = ours.from.t + 0.5 * ours.h;
        let dense = stepper.interpolant(&ours).unwrap();
        assert_eq!(dense.at(middle), Dop853.interpolant(&MOTORS, &theirs).at(middle));
    }
    assert_eq!(stepper.statistics().accepted, 100);
}

/// Order 4 across a change of a parameter, against a run of another method to each side of it.
#[test]
fn a_change_keeps_the_order() {
    let changed = Motors { g: 2.0, u: [1.0, 0.0], ..MOTORS };
    let fine = (Dop853, PiController::tolerance(1e-13));
    let exact = end_of(&changed, fine, end_of(&MOTORS, fine, SWUNG, 0.5), 1.0);
    let error = |h: f64| {
        let mut stepper = Stepper::new(MOTORS, Rk4, FixedStep::new(h), SWUNG);
        stepper.advance_to(0.5).unwrap();
        stepper.system_mut().g = 2.0;
        stepper.set_inputs([1.0, 0.0]).unwrap();
        stepper.advance_to(1.0).unwrap();
        let difference = stepper.state().minus(&exact);
        difference.q.amax().max(difference.qd.amax())
    };
    let order = (error(0.005) / error(0.0025)).log2();
    assert!((order - 4.0).abs() < 0.2, "{order}");
}

#[test]
fn a_prepared_system_is_changed_by_update() {
    let mut stepper = Stepper::new(MOTORS.precomputed(), Rk4, FixedStep::new(0.01), SWUNG);
    stepper.advance_to(0.5).unwrap();
    stepper.system_mut().update(|motors| motors.m2 = 2.0);
    stepper.advance_to(1.0).unwrap();
    let how = || (Rk4, FixedStep::new(0.01));
    let exact = end_of(&Motors { m2: 2.0, ..MOTORS }, how(), end_of(&MOTORS, how(), SWUNG, 0.5), 1.0);
    assert_eq!(*stepper.state(), exact);
}

#[test]
fn steppers_are_values() {
    fn sent<T: Send + Clone + Debug + 'static>(value: T) -> T {
        value
    }
    let mut fleet: HashMap<u32, Stepper<Motors, Dop853, PiController, 2>> =
        (0..4).map(|i| (i, sent(motors()))).collect();
    for (i, stepper) in &mut fleet {
        stepper.advance_to(0.1 * f64::from(*i)).unwrap();
    }
    let mut snapshot = fleet[&3].clone();
    let original = fleet.get_mut(&3).unwrap();
    original.advance_to(2.0).unwrap();
    snapshot.advance_to(2.0).unwrap();
    assert_eq!((original.state(), original.statistics()), (snapshot.state(), snapshot.statistics()));
}

/// `x⁺ = x + T v + T²/2 u/m`, `v⁺ = v + T u/m` with u held, exactly.
#[test]
fn inputs_are_held_between_instants() {
    const PERIOD: f64 = 0.1;
    let law = |s: &State<f64, 1>| -1.5 * s.q[0] - 2.0 * s.qd[0];
    let mut called = Vec::new();
    let system = Driven::new(2.0, 0.0);
    let mut stepper =
        Stepper::new(system, Dop853, PiController::tolerance(1e-12), AT_ONE).every(PERIOD, |state, u| {
            called.push(state.t);
            u[0] = law(state);
        });
    let [mut x, mut v] = [1.0, 0.0];
    for k in 0..=50 {
        stepper.advance_to(f64::from(k) * PERIOD).unwrap();
        let state = *stepper.state();
        assert_eq!(state.t, f64::from(k) * PERIOD);
        assert!((state.q[0] - x).abs() < 1e-13 && (state.qd[0] - v).abs() < 1e-13, "{k}: {state:?}");
        // Right-continuous: at the instant it is the new one.
        assert_eq!(stepper.inputs()[0], law(&state));
        let u = law(&state) / 2.0;
        (x, v) = (x + PERIOD * v + 0.5 * PERIOD * PERIOD * u, v + PERIOD * u);
    }
    assert!(x.abs() < 0.1, "it comes to rest: {x}");
    assert_eq!(called, (0..=50).map(|k| f64::from(k) * PERIOD).collect::<Vec<_>>());
}

/// Times of the caller that differ from those of the controller by rounding make no steps of their own.
#[test]
fn instants_are_met_up_to_rounding() {
    let mut calls = 0;
    let mut steps = 0;
    let system = Driven::new(1.0, 1.0);
    let start = State { t: 0.3, ..AT_ONE };
    let mut stepper = Stepper::new(system, Rk4, FixedStep::new(0.01), start).every(0.01, |_, u| {
        calls += 1;
        u[0] += 0.1;
    });
    for k in 1..=1000 {
        let t = 0.3 + 0.001 * f64::from(k);
        stepper.advance_to(t).unwrap();
        steps += 1;
        assert!((stepper.state().t - t).abs() < 1e-14);
    }
    assert_eq!(stepper.statistics().accepted, steps);
    assert_eq!(calls, 101);
}

/// Sums of periods are not their multiples: the time is that of the caller, whoever sets it, to the bit.
#[test]
fn a_time_is_reached_exactly() {
    let mut stepper = Stepper::new(Driven::new(1.0, 1.0), Dop853, PiController::tolerance(1e-9), AT_ONE)
        .every(0.1, |state, u| u[0] = -state.qd[0]);
    let mut t = 0.0;
    for _ in 0..300 {
        t += 0.1;
        stepper.advance_to(t).unwrap();
        assert_eq!(stepper.state().t, t);
    }
    // The instant 3·0.1 is not 0.3, and may be asked for after a step has landed on it.
    let mut stepper = Stepper::new(Driven::new(1.0, 1.0), Rk4, FixedStep::new(0.1), AT_ONE)
        .every(0.1, |state, u| u[0] = -state.qd[0]);
    for _ in 0..3 {
        stepper.step().unwrap();
    }
    assert_eq!(stepper.state().t, 3.0 * 0.1);
    for t in [0.3, 3.0 * 0.1, 0.3] {
        stepper.advance_to(t).unwrap();
        assert_eq!(stepper.state().t, t);
    }
    let sampled: Vec<_> = stepper.until(0.4).sample([0.3, 0.4]).map(|state| state.unwrap().t).collect();
    assert_eq!(sampled, [0.3, 0.4]);
    for t in [0.6, 0.7] {
        assert_eq!(stepper.until(t).last().unwrap().unwrap().to.t, t);
    }
    assert_eq!(stepper.statistics().accepted, 7);
}

/// Once per instant, whatever happens there.
#[test]
fn a_law_is_called_once_at_an_instant() {
    use std::cell::RefCell;
    let called = RefCell::new(Vec::new());
    let mut stepper = Stepper::new(Driven::new(1.0, 1.0), Rk4, FixedStep::new(0.05), AT_ONE)
        .every(0.25, |state, _| called.borrow_mut().push((state.t, state.q[0])));
    let calls = || called.borrow().len();
    let state = |t: f64, x: f64| State::new(t, [x], [0.0]);
    // Before the first call, the state may still be set.
    stepper.set_state(state(0.0, 2.0)).unwrap();
    assert_eq!(calls(), 0);
    stepper.advance_to(0.25).unwrap();
    stepper.set_state(state(0.25, 3.0)).unwrap();
    stepper.advance_to(0.25).unwrap();
    assert_eq!(calls(), 2);
    // A way ends before the call, which the next step makes.
    stepper.until(0.5).last().unwrap().unwrap();
    assert_eq!(calls(), 2);
    stepper.set_state(state(0.5, 4.0)).unwrap();
    stepper.until(0.6).last().unwrap().unwrap();
    assert_eq!((calls(), called.borrow()[2]), (3, (0.5, 4.0)));
    // At another time, also at one of before.
    stepper.set_state(state(0.5, 5.0)).unwrap();
    stepper.advance_to(0.5).unwrap();
    let expected = [(0.0, 2.0), (0.5, 4.0), (0.5, 5.0)];
    assert_eq!([called.borrow()[0], called.borrow()[2], called.borrow()[3]], expected);
    assert_eq!(calls(), 4);
}

/// At the end of a stretch of events, as of any other one, the law acts with the next step: on the state that is set
/// there.
#[test]
fn a_law_does_not_act_at_the_end_of_a_stretch() {
    let ends = [false, true].map(|events| {
        let mut stepper =
            Stepper::new(Driven::new(1.0, 0.0), Rk4, FixedStep::new(0.01), State::new(0.0, [0.0], [0.0]))
                .every(0.1, |at, u| u[0] = 1.0 - at.q[0]);
        if events {
            assert!(
                stepper.until(0.1).events(Event::either(|at: &State<f64, 1>| at.q[0] - 1.0)).next().is_none()
            );
        } else {
            stepper.until(0.1).last().unwrap().unwrap();
        }
        assert_eq!(stepper.state().t, 0.1);
        stepper.set_state(State::new(0.1, [1.0], [0.0])).unwrap();
        stepper.advance_to(0.2).unwrap();
        stepper.state().q[0]
    });
    assert_eq!(ends, [1.0; 2]);
}

#[test]
fn controllers_have_periods_of_their_own() {
    use std::cell::RefCell;
    let log = RefCell::new(Vec::new());
    let mut stepper = Stepper::new(MOTORS, Dop853, PiController::tolerance(1e-9), SWUNG)
        .every(0.02, |state, u| {
            log.borrow_mut().push(("slow", state.t));
            u[0] = 0.1 * state.t;
        })
        .every(0.01, |state, u| {
            log.borrow_mut().push(("fast", state.t));
            u[1] = u[0] - 0.5;
        });
    stepper.advance_to(0.03).unwrap();
    assert_eq!(stepper.inputs(), SVector::from([0.1 * 0.02, 0.1 * 0.02 - 0.5]));
    let expected =
        [("slow", 0.0), ("fast", 0.0), ("fast", 0.01), ("slow", 0.02), ("fast", 0.02), ("fast", 0.03)];
    assert_eq!(log.into_inner(), expected);
}

#[test]
fn after_another_state_instants_stay_on_their_grid() {
    let mut called = Vec::new();
    let system = Driven::new(1.0, 1.0);
    let mut stepper =
        Stepper::new(system, Rk4, FixedStep::new(0.01), AT_ONE).every(0.25, |state, _| called.push(state.t));
    stepper.advance_to(0.6).unwrap();
    stepper.set_state(State { t: 0.1, ..AT_ONE }).unwrap();
    stepper.advance_to(0.3).unwrap();
    stepper.set_state(State { t: 0.75, ..AT_ONE }).unwrap();
    stepper.advance_to(0.9).unwrap();
    stepper.set_state(State { t: 10.1, ..AT_ONE }).unwrap();
    stepper.advance_to(10.25).unwrap();
    assert_eq!(called, [0.0, 0.25, 0.5, 0.25, 0.75, 10.25]);
}

/// Under a held force a mass moves on parabolas: samples and events within steps see the force of their step.
#[test]
fn samples_and_events_see_the_held_input() {
    let drive = || {
        let start = State::new(0.0, [0.0], [0.0]);
        Stepper::new(Driven::new(1.0, 0.0), Dop853, PiController::tolerance(1e-12), start)
            .every(1.0, |state, u| u[0] = if state.t.rem_euclid(2.0) < 1.0 { 1.0 } else { -1.0 })
    };
    // To and fro with the period 2: v is a triangle wave.
    let exact = |t: f64| {
        let (whole, part) = (t.div_euclid(2.0), t.rem_euclid(2.0));
        if part < 1.0 {
            [whole + 0.5 * part * part, part]
        } else {
            [whole + 1.0 - 0.5 * (2.0 - part).powi(2), 2.0 - part]
        }
    };
    let mut stepper = drive();
    let times = (0..=97).map(|k| 0.0713 * f64::from(k));
    for state in stepper.until(8.0).sample(times) {
        let state = state.unwrap();
        let [x, v] = exact(state.t);
        assert!((state.q[0] - x).abs() < 1e-12 && (state.qd[0] - v).abs() < 1e-12, "{state:?}");
    }
    let mut stepper = drive();
    let events = Event::rising(|s: &State<f64, 1>| s.q[0] - 1.625);
    let met: Vec<_> = stepper.until(8.0).events(events).collect::<Result<_, _>>().unwrap();
    // 1 + (1 − (2 − t')²/2 …): 0.625 = 1 − (2 − t')²/2.
    let t = 2.0 + 2.0 - 0.75f64.sqrt();
    assert!(met.len() == 1 && (met[0].state.t - t).abs() < 1e-12, "{met:?} {t}");
    assert_eq!(stepper.state().t, 8.0);
    // A terminal one leaves the stepper there, and it goes on.
    let mut stepper = drive();
    let landed = stepper.until(8.0).events(events.terminal()).next().unwrap().unwrap();
    assert_eq!(*stepper.state(), landed.state);
    assert!((landed.state.t - t).abs() < 1e-13);
    stepper.advance_to(8.0).unwrap();
    assert!((stepper.state().q[0] - exact(8.0)[0]).abs() < 1e-12);
    // The work of the force, ∫ u v dt, is the kinetic energy.
    let mut stepper = drive();
    let work = stepper.until(0.75).integrals([0.0], |s| [s.qd[0]]).total().unwrap();
    assert!((work.integrals[0] - 0.5 * 0.75 * 0.75).abs() < 1e-14);
}

#[test]
fn an_interpolant_is_that_of_the_last_step() {
    let mut stepper = motors();
    let first = stepper.step().unwrap();
    assert!(stepper.interpolant(&first).is_some());
    let second = stepper.step().unwrap();
    assert!(stepper.interpolant(&first).is_none() && stepper.interpolant(&second).is_some());
    stepper.set_inputs([0.0, 0.0]).unwrap();
    assert!(stepper.interpolant(&second).is_some(), "nothing has changed");
    stepper.set_inputs([0.0, 1.0]).unwrap();
    assert!(stepper.interpolant(&second).is_none());
    let third = stepper.step().unwrap();
    stepper.system_mut();
    assert!(stepper.interpolant(&third).is_none());
}

/// One evaluation more for each input that has changed, and none where none has.
#[test]
fn evaluations_of_a_sampled_controller() {
    let cost = |gain: f64| -> Statistics {
        let mut stepper = motors().every(0.01, move |state, u| u[0] = -gain * state.qd[0]);
        stepper.advance_to(5.0).unwrap();
        stepper.statistics()
    };
    let (held, driven) = (cost(0.0), cost(0.5));
    let ratio = driven.evaluations as f64 / held.evaluations as f64;
    println!("{held:?} {driven:?}: {ratio:.3}");
    assert!(ratio < 1.15, "{ratio}");
    assert!(
        driven.evaluations - held.evaluations
            <= 500 + 12 * (driven.accepted + driven.rejected - held.accepted)
    );
}

/// The last stage of a step whose end nobody asks for is that of the next step, whose inputs are others.
#[test]
fn evaluations_of_rk4_under_control() {
    let law = |state: &State<f64, 2>, u: &mut SVector<f64, 2>| u[0] = -0.5 * state.qd[0];
    let rk4 = |h: f64| Stepper::new(MOTORS, Rk4, FixedStep::new(h), SWUNG);
    let mut controlled = rk4(0.01).every(0.01, law);
    controlled.advance_to(1.0).unwrap();
    let Statistics { accepted, evaluations, .. } = controlled.statistics();
    assert_eq!((accepted, evaluations), (100, 400));
    // Set by hand, and by a loop over steps, which has their interpolants and so all stages.
    let (mut by_hand, mut seen) = (rk4(0.01), rk4(0.01).every(0.01, law));
    for k in 1..=100 {
        by_hand.set_inputs([-0.5 * by_hand.state().qd[0], 0.0]).unwrap();
        by_hand.advance_to(0.01 * f64::from(k)).unwrap();
        let step = seen.step().unwrap();
        let middle = seen.interpolant(&step).unwrap().at(step.from.t + 0.5 * step.h);
        assert!((middle.qd - (step.from.qd + step.to.qd) * 0.5).amax() < 1e-2);
    }
    assert_eq!(by_hand.statistics().evaluations, 400);
    assert_eq!(seen.statistics().evaluations, 500);
    assert_eq!(seen.state(), by_hand.state());
    assert_eq!(controlled.state().q, seen.state().q);
    // Four steps an instant, and inputs that stay: no evaluation more than those of a run.
    let mut held = rk4(0.01).every(0.04, |_, _| ());
    held.advance_to(1.0).unwrap();
    let mut run = integrate(&MOTORS, Rk4, FixedStep::new(0.01), SWUNG).until(1.0);
    run.run_to_end().unwrap();
    assert!(held.statistics().evaluations <= run.statistics().evaluations);
    assert!((held.state().q - run.state().q).amax() < 1e-13);
}

/// On constraints the projection moves the end, so that a step whose end nobody asks for costs two evaluations less.
#[test]
fn evaluations_of_rk4_on_constraints() {
    let rod = Rod { l: 1.0, g: 9.81 };
    let start = State::new(0.0, [0.6, -0.8], [0.8, 0.6]);
    let rk4 = || Stepper::new(rod, Rk4, FixedStep::new(0.01), start);
    let (mut by_times, mut by_steps) = (rk4(), rk4());
    for k in 1..=100 {
        by_times.system_mut();
        by_times.advance_to(0.01 * f64::from(k)).unwrap();
        by_steps.system_mut();
        by_steps.step().unwrap();
    }
    let evaluations = [by_times, by_steps.clone()].map(|stepper| stepper.statistics().evaluations);
    assert_eq!(evaluations, [400, 600]);
    assert!((by_steps.state().q.norm() - 1.0).abs() < 1e-14);
}

/// Instants are rounded by the distance of their origin from 0, wherever they are: a countdown.
#[test]
fn instants_before_zero_are_met_up_to_rounding() {
    let start = |t: f64| State::new(t, [0.0], [0.0]);
    let plant =
        |t: f64, h: f64| Stepper::new(Driven { m: 2.0, k: 0.0, u: 0.0 }, Rk4, FixedStep::new(h), start(t));
    // A slow law and a limiter, which is to act after it wherever both do.
    let mut limited = plant(-60.0, 0.01)
        .every(0.1, |_, u: &mut SVector<f64, 1>| u[0] = 5.0)
        .every(0.01, |_, u: &mut SVector<f64, 1>| u[0] = u[0].min(1.0));
    limited.advance_to(10.0).unwrap();
    assert!((limited.state().qd[0] - 35.0).abs() < 1e-9, "{}", limited.state().qd[0]);
    assert_eq!(limited.statistics().accepted, 7000);
    // Each call ends with that of the law.
    for (origin, period, count) in [(-0.3, 0.1, 6), (-60.0, 0.01, 6100), (-3600.0, 0.05, 72_100)] {
        let mut seen = plant(origin, period).every(period, |at, u| u[0] = at.t);
        for k in 0..count {
            let t = origin + period * f64::from(k);
            seen.advance_to(t).unwrap();
            assert_eq!(seen.inputs()[0], t);
        }
    }
}

lagrangian! {
    /// A pendulum on a rope that an input winds up.
    system Wound {
        param g = 9.81;
        input r = 3;
        coord x, y;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = g * y;
        constraint rope: x.powi(2) + y.powi(2) == r.powi(2);
    }
}

/// Many small jumps of a constraint are not taken for rounding: each is a failure, by equal steps too.
#[test]
fn small_jumps_of_constraints_are_refused() {
    let start = State::new(0.0, [0.5, -(9.0f64 - 0.25).sqrt()], [0.0, 0.0]);
    for jump in [1e-6, 1e-8] {
        let mut wound = Stepper::new(Wound::new(), Rk4, FixedStep::new(1e-3), start);
        wound.advance_to(0.1).unwrap();
        wound.set_inputs([3.0 - jump]).unwrap();
        let failure = wound.advance_to(0.2).unwrap_err();
        assert!(
            matches!(failure, Failure::ConstraintViolated { constraint: "rope", .. }),
            "{jump:e}: {failure}"
        );
    }
    // An input that stays is none, however often it is set.
    let mut wound = Stepper::new(Wound::new(), Rk4, FixedStep::new(1e-3), start);
    for k in 1..2000 {
        wound.set_inputs([3.0]).unwrap();
        wound.advance_to(1e-3 * f64::from(k)).unwrap();
    }
}

/// A system that is changed to one without finite equations is told as at a start.
#[test]
fn a_system_that_becomes_not_finite_is_named() {
    let mut driven = Stepper::new(Driven { m: 2.0, k: 0.0, u: 0.0 }, Rk4, FixedStep::new(0.1), AT_ONE);
    driven.advance_to(0.2).unwrap();
    driven.system_mut().u = f64::NAN;
    let failure = driven.advance_to(1.0).unwrap_err();
    assert!(matches!(failure, Failure::StateNotFinite { t: 0.2, .. }), "{failure}");
}

#[test]
fn no_time_goes_back() {
    let mut stepper = motors();
    stepper.advance_to(1.0).unwrap();
    let at = *stepper.state();
    assert_eq!(stepper.advance_to(0.5), Err(Failure::TimeGoesBack { t: 1.0, end: 0.5 }));
    assert_eq!(stepper.advance_within(0.5, 7), Err(Failure::TimeGoesBack { t: 1.0, end: 0.5 }));
    assert!(matches!(stepper.until(0.5).next(), Some(Err(Failure::TimeGoesBack { .. }))));
    assert!(matches!(stepper.advance_to(f64::NAN), Err(Failure::BadEnd { end: Some(_) })));
    assert_eq!(stepper.advance_to(1.0), Ok(()));
    assert_eq!(*stepper.state(), at);
    stepper.advance_to(1.5).unwrap();
    let run = end_of(&MOTORS, (Dop853, PiController::tolerance(1e-9)), SWUNG, 1.5);
    assert!((stepper.state().q - run.q).amax() < 1e-7, "nothing was lost");
    // Steps of a negative size lead backward, but not through the past of a controller.
    let mut backward = Stepper::new(MOTORS, Rk4, FixedStep::new(-0.01), SWUNG);
    backward.advance_to(-1.0).unwrap();
    assert_eq!(*backward.state(), end_of(&MOTORS, (Rk4, FixedStep::new(-0.01)), SWUNG, -1.0));
    assert!(matches!(backward.advance_to(0.0), Err(Failure::TimeGoesBack { .. })));
    let mut controlled = Stepper::new(MOTORS, Rk4, FixedStep::new(-0.01), SWUNG).every(0.1, |_, _| {});
    let refusal = Failure::Unsuitable { chosen: "every", requirement: Requirement::Forward };
    for end in [-1.0, 1.0] {
        assert_eq!(controlled.advance_to(end), Err(refusal));
        assert_eq!(controlled.until(end).find_map(Result::err), Some(refusal));
    }
    assert_eq!(controlled.step().err(), Some(refusal));
    assert!(refusal.to_string().contains("`every` needs steps that go forward in time"), "{refusal}");
    assert_eq!(*controlled.state(), SWUNG);
}

#[test]
fn inputs_that_are_not_finite() {
    let mut stepper = motors();
    stepper.advance_to(0.5).unwrap();
    for bad in [f64::NAN, f64::INFINITY] {
        let failure = stepper.set_inputs([1.0, bad]).unwrap_err();
        assert_eq!(failure, Failure::InputNotFinite { t: 0.5, input: "u[1]" });
        assert!(failure.to_string().contains("`u[1]`"), "{failure}");
    }
    assert_eq!(stepper.inputs(), SVector::from([0.0, 0.0]));
    let mut controlled = stepper.every(0.25, |state, u| u[0] = if state.t == 0.75 { f64::NAN } else { 1.0 });
    assert_eq!(controlled.advance_to(2.0), Err(Failure::InputNotFinite { t: 0.75, input: "u[0]" }));
    assert_eq!((controlled.state().t, controlled.inputs()[0]), (0.75, 1.0));
    // A parameter that is none is seen by the step, and once it is mended the motion goes on.
    let mut stepper = motors();
    stepper.advance_to(0.5).unwrap();
    let at = *stepper.state();
    stepper.system_mut().g = f64::NAN;
    assert!(stepper.advance_to(1.0).is_err());
    assert_eq!(*stepper.state(), at);
    stepper.system_mut().g = 9.81;
    stepper.advance_to(1.0).unwrap();
    let run = end_of(&MOTORS, (Dop853, PiController::tolerance(1e-9)), SWUNG, 1.0);
    assert!((stepper.state().q - run.q).amax() < 1e-7);
}

#[test]
fn periods_and_controllers_that_are_none() {
    for period in [0.0, -0.1, f64::NAN, f64::INFINITY] {
        let mut stepper = motors().every(period, |_, _| {});
        assert!(matches!(stepper.advance_to(1.0), Err(Failure::BadPeriod { .. })));
        assert!(matches!(stepper.step(), Err(Failure::BadPeriod { .. })));
        assert_eq!(*stepper.state(), SWUNG);
    }
    // Nor are those whose instants cannot be told apart.
    for (t, period) in [(1.7e9, 1e-6), (1.7e9, 5e-7), (1.0, 1e-17), (-1.0, 1e-17), (1e15, 0.01)] {
        let start = State { t, ..SWUNG };
        let mut calls = 0;
        let mut stepper = Stepper::new(MOTORS, Dop853, PiController::tolerance(1e-9), start)
            .every(period, |_, _| calls += 1);
        let refusal = Failure::BadPeriod { t, period };
        assert_eq!(stepper.advance_to(t + 1.0), Err(refusal));
        assert_eq!(stepper.step().err(), Some(refusal));
        assert!(refusal.to_string().contains("shorter than the rounding of time"), "{refusal}");
        assert_eq!(*stepper.state(), start);
        assert_eq!(calls, 0);
    }
    // From t = 0 on there are more of them than can be counted.
    let mut stepper = motors().every(1e-20, |_, _| {});
    assert_eq!(stepper.advance_to(0.01), Err(Failure::BadPeriod { t: 0.01, period: 1e-20 }));
    let start = State { t: 1.7e9, ..SWUNG };
    let mut calls = 0;
    let mut stepper =
        Stepper::new(MOTORS, Dop853, PiController::tolerance(1e-9), start).every(1e-4, |_, _| calls += 1);
    stepper.advance_to(1.7e9 + 1e-2).unwrap();
    assert_eq!(calls, 101);
    // One becomes too short as time grows, here beyond 2⁻¹⁰/(64 · 2⁻²³) = 128.
    let start = State::new(127.9f32, [1.0], [0.0]);
    let period = 2f32.powi(-10);
    let mut stepper =
        Stepper::new(Driven::new(1.0, 1.0).map(|x| x as f32), Rk4, FixedStep::new(period), start)
            .every(period, |_, _| {});
    let refused = stepper.advance_to(129.0).unwrap_err();
    let t = stepper.state().t;
    assert_eq!(refused, Failure::BadPeriod { t, period });
    assert!(t > 128.0 && t < 128.0 + 2.0 * period, "{t}");
    let mut stepper = Stepper::new(MOTORS, Dop853, PiController::tolerance(f64::NAN), SWUNG);
    assert!(matches!(stepper.advance_to(1.0), Err(Failure::BadTolerance { .. })));
    let mut stepper = Stepper::new(MOTORS, Rk4, FixedStep::new(f64::INFINITY), SWUNG);
    assert!(matches!(stepper.advance_to(1.0), Err(Failure::BadStepSize { .. })));
    assert!(matches!(stepper.step(), Err(Failure::BadStepSize { .. })));
    let start = State { t: f64::NAN, ..SWUNG };
    assert!(matches!(
        Stepper::new(MOTORS, Rk4, FixedStep::new(0.1), start).step(),
        Err(Failure::StateNotFinite { .. })
    ));
}

#[test]
fn states_off_the_constraints_are_refused() {
    let start = State::new(0.0, [0.6, -0.8], [0.0, 0.0]);
    let mut stepper = Stepper::new(Rod::new(1.0), Dop853, PiController::tolerance(1e-9), start);
    stepper.advance_to(1.0).unwrap();
    let at = *stepper.state();
    let off = State { q: SVector::from([0.6, -0.9]), ..at };
    assert!(matches!(stepper.set_state(off), Err(Failure::ConstraintViolated { constraint: "rod", .. })));
    assert!(matches!(stepper.set_state(State { t: f64::NAN, ..at }), Err(Failure::StateNotFinite { .. })));
    assert_eq!(*stepper.state(), at);
    stepper.advance_to(2.0).unwrap();
    let run = integrate(&Rod::new(1.0), Dop853, PiController::tolerance(1e-9), start)
        .until(2.0)
        .final_state()
        .unwrap();
    assert!((stepper.state().q - run.q).amax() < 1e-7, "nothing was lost");
    assert!((stepper.state().q.norm() - 1.0).abs() < 1e-14, "on the circle");
    // Nor does a rod change its length under the mass.
    let at = *stepper.state();
    stepper.system_mut().l = 1.1;
    assert!(matches!(stepper.advance_to(3.0), Err(Failure::ConstraintViolated { .. })));
    assert_eq!(*stepper.state(), at);
    let on = consistent(stepper.system(), &at).unwrap();
    stepper.set_state(on).unwrap();
    stepper.advance_to(3.0).unwrap();
}

#[test]
fn a_budget_is_a_value_or_a_failure() {
    let mut stepper = motors().max_steps(5);
    assert!(matches!(stepper.advance_to(5.0), Err(Failure::BudgetUsedUp { max_steps: 5, .. })));
    assert_eq!(stepper.statistics().accepted + stepper.statistics().rejected, 5);
    assert_eq!(stepper.advance_within(5.0, 3), Ok(Advance::NotYet));
    assert_eq!(stepper.advance_within(5.0, 0), Ok(Advance::NotYet));
    assert_eq!(stepper.statistics().accepted + stepper.statistics().rejected, 8);
    assert_eq!(stepper.advance_within(5.0, 100_000), Ok(Advance::Arrived));
    assert_eq!(*stepper.state(), end_of(&MOTORS, (Dop853, PiController::tolerance(1e-9)), SWUNG, 5.0));
}

/// Steps end where forces switch, as those of a run do.
#[test]
fn switches_of_the_forces_are_met() {
    lagrangian! {
        system Wall {
            param k;
            coord x;
            T = 0.5 * dot(x).powi(2);
            V = 0;
            Q[x] = if x < 0 { -k * x } else { 0 };
        }
    }
    let start = State::new(0.0, [1.0], [-1.0]);
    let mut stepper = Stepper::new(Wall::new(1e4), Dop853, PiController::tolerance(1e-9), start);
    let how = || integrate(&Wall { k: 1e4 }, Dop853, PiController::tolerance(1e-9), start);
    stepper.advance_to(2.0).unwrap();
    assert_eq!(*stepper.state(), how().until(2.0).final_state().unwrap());
    // Half a swing of the spring, and back.
    let back = 2.0 - 1.0 - core::f64::consts::PI / 100.0;
    assert!((stepper.state().q[0] - back).abs() < 1e-8, "{:?}", stepper.state());
}

/// Interruptions change nothing, whether a controller acts or not.
#[test]
fn a_controlled_stepper_is_interrupted() {
    let drive = || {
        let mut pending = 0.0;
        motors().every(0.01, move |state, u| {
            u[0] = pending;
            pending = -0.5 * state.qd[0];
        })
    };
    let (mut whole, mut interrupted) = (drive(), drive());
    for k in 1..=100 {
        let t = 0.005 * f64::from(k);
        whole.advance_to(t).unwrap();
        while interrupted.advance_within(t, 1).unwrap() == Advance::NotYet {}
    }
    assert_eq!((whole.state(), whole.inputs()), (interrupted.state(), interrupted.inputs()));
    assert_eq!(whole.statistics(), interrupted.statistics());
}

lagrangian! {
    /// A body on a jet, whose attitude is a coordinate.
    system Satellite {
        param a = 1.0, b = 2.0, c = 3.0;
        input jet;
        coord R: rotation;
        let craft = frame(world, [0, 0, 0], R);
        T = body(1, [a, b, c], craft);
        V = 0;
        couple [jet, 0, 0] on craft;
    }
}

/// The parameters of an attitude are chosen once a step, which takes an evaluation if steps are equal, however often a
/// stepper is interrupted at a sampling instant.
#[test]
fn an_interrupted_attitude_costs_what_it_costs() {
    fn goes_on<M, C>(method: M, controller: C)
    where
        M: Method<Satellite, 3> + Clone + Debug,
        C: Controller<f64, 3, M::Error>,
    {
        let (satellite, spin) = (Satellite::new(), Vector3::new(0.1, 3.0, 0.2));
        let at_rest = State::new(0.0, [0.0; 3], [0.0; 3]);
        let start = satellite.with_attitude_R(at_rest, &UnitQuaternion::identity(), &spin);
        let stepper = || {
            let stepper = Stepper::new(satellite, method.clone(), controller.clone(), start);
            stepper.every(0.05, |at: &State<f64, 3>, jet: &mut SVector<f64, 1>| jet[0] = -at.qd[0])
        };
        for attempts in [1, 2, 3, 10] {
            let (mut whole, mut interrupted) = (stepper(), stepper());
            for t in [3.0, 3.02, 6.0] {
                whole.advance_to(t).unwrap();
                while interrupted.advance_within(t, attempts).unwrap() == Advance::NotYet {}
            }
            assert_eq!(whole.state(), interrupted.state(), "{method:?}");
            assert_eq!(
                whole.statistics(),
                interrupted.statistics(),
                "{method:?}, {attempts} attempts a call"
            );
        }
    }
    goes_on(Dop853, PiController::tolerance(1e-9));
    goes_on(Rk4, FixedStep::new(0.01));
    goes_on(Rk4, FixedStep::new(0.05));
    goes_on(Gauss4, FixedStep::new(0.02));
}

lagrangian! {
    /// An oscillator that is pushed, and two events that jump with the push.
    pub system Pushed {
        input u;
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = 0.5 * x.powi(2);
        Q[x] = u;
        event w: x + u - 0.4;
        event b: dot(x) + 0.5 * u - 0.2;
        event two: t - 0.5;
    }
}

/// Events that an input takes across zero are met, and those that follow them, one by one as in one sweep: beside
/// another jump, and beside an event of time at a sampling instant.
#[test]
fn events_that_jump_together_are_met_one_by_one() {
    fn check<M, C>(
        method: M,
        controller: C,
        x: f64,
        law: fn(&State<f64, 1>, &mut SVector<f64, 1>),
        tolerance: f64,
    ) where
        M: Method<Pushed, 1> + Clone,
        C: Controller<f64, 1, M::Error> + Clone,
    {
        let start = State::new(0.0, [x], [0.0]);
        let stepper =
            || Stepper::new(Pushed::default(), method.clone(), controller.clone(), start).every(0.25, law);
        let mut sweep: Vec<_> = stepper()
            .until(0.7)
            .events((Pushed::W, Pushed::B, Pushed::TWO))
            .map(|event| event.map(|event| (event.name, event.direction, event.state.t)).unwrap())
            .collect();
        let mut one_by_one = Vec::new();
        let mut single = stepper();
        while let Some(event) = single.until(0.7).events((Pushed::W, Pushed::B, Pushed::TWO)).next() {
            let event = event.unwrap();
            one_by_one.push((event.name, event.direction, event.state.t));
        }
        let sorted = |events: &mut Vec<(&'static str, Direction, f64)>| {
            events.sort_by_key(|event| ((event.2 * 1e6).round() as i64, event.0));
        };
        sorted(&mut sweep);
        sorted(&mut one_by_one);
        let jumps = one_by_one
            .iter()
            .filter(|event| event.0 != "two" && (4.0 * event.2 - (4.0 * event.2).round()).abs() < 1e-9);
        assert_eq!(jumps.count(), 4, "{one_by_one:?}");
        assert_eq!(sweep.len(), one_by_one.len(), "{sweep:?} {one_by_one:?}");
        for (a, b) in sweep.iter().zip(&one_by_one) {
            assert!(a.0 == b.0 && a.1 == b.1 && (a.2 - b.2).abs() < tolerance, "{sweep:?} {one_by_one:?}");
        }
    }
    let pulse = |at: &State<f64, 1>, u: &mut SVector<f64, 1>| u[0] = if at.t == 0.25 { 0.6 } else { 0.0 };
    let gap = |at: &State<f64, 1>, u: &mut SVector<f64, 1>| u[0] = if at.t == 0.25 { 0.0 } else { 0.6 };
    for (x, law) in [(-0.1, pulse as fn(&State<f64, 1>, &mut SVector<f64, 1>)), (0.1, gap)] {
        check(Dop853, PiController::tolerance(1e-11), x, law, 1e-9);
        check(Taylor, TaylorController::tolerance(1e-13), x, law, 1e-9);
        check(Radau5, PiController::tolerance(1e-9), x, law, 1e-7);
        check(Rk4, FixedStep::new(0.05), x, law, 1e-4);
    }
    // An input that is set at an event takes another one across zero.
    let mut pushed = Stepper::new(
        Pushed::default(),
        Dop853,
        PiController::tolerance(1e-11),
        State::new(0.0, [0.1], [0.0]),
    );
    let mut met = Vec::new();
    while let Some(event) = pushed.until(0.6).events((Pushed::TWO, Pushed::W)).next() {
        let event = event.unwrap();
        met.push(event.name);
        if event.name == "two" {
            pushed.set_inputs([2.0]).unwrap();
        }
    }
    assert_eq!(met, ["two", "w"]);
}

/// A restart at another time keeps to the sampling instants: sums of parabolas by hand.
#[test]
fn a_restart_at_another_time_keeps_the_instants() {
    for (t, right) in [(0.5, 5.7890625), (1.3, 4.3571875), (2.6, 2.1225)] {
        let law = |at: &State<f64, 1>, u: &mut SVector<f64, 1>| u[0] = at.t;
        let start = State::new(0.0, [0.0], [1.0]);
        let mut cart =
            Stepper::new(Free::default(), Dop853, PiController::tolerance(1e-12), start).every(0.25, law);
        let mut events = cart.until(4.0).events(Free::GATE);
        events.next().unwrap().unwrap();
        events.restart(State::new(t, [2.0], [0.0]));
        cart.advance_to(3.0).unwrap();
        assert!((cart.state().q[0] - right).abs() < 1e-12, "{t}: {} for {right}", cart.state().q[0]);
    }
}

/// A restart beside the constraints is told, and the stepper stays where it was.
#[test]
fn a_restart_beside_the_constraints_is_told() {
    let start = State::new(0.0, [0.6, -0.8], [0.0, 0.0]);
    let mut rod = Stepper::new(Rod::new(1.0), Dop853, PiController::tolerance(1e-9), start);
    let mut events = rod.until(4.0).events(Event::either(|at: &State<f64, 2>| at.q[0]).terminal());
    let lowest = events.next().unwrap().unwrap().state;
    events.restart(State { q: [0.6, -0.9].into(), ..lowest });
    assert!(matches!(events.next(), Some(Err(Failure::ConstraintViolated { constraint: "rod", .. }))));
    assert_eq!(*rod.state(), lowest);
}

/// Calls for times within rounding of each other add up to a motion.
#[test]
fn increments_within_rounding_add_up() {
    for ulps in 1..=8 {
        let start = State::new(1000.0, [0.0], [1.0]);
        let mut cart = Stepper::new(Free::default(), Dop853, PiController::tolerance(1e-9), start);
        let mut t = 1000.0_f64;
        for _ in 0..1000 {
            (0..ulps).for_each(|_| t = t.next_up());
            cart.advance_to(t).unwrap();
            assert_eq!(cart.state().t, t);
        }
        assert!((cart.state().q[0] / (t - 1000.0) - 1.0).abs() < 5e-3, "{ulps}: {}", cart.state().q[0]);
    }
}

lagrangian! {
    pub system Free {
        input u;
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = 0;
        Q[x] = u;
        event gate: x - 1.0, terminal;
    }
}

lagrangian! {
    /// A cart whose command is watched.
    system Commanded {
        input u: [2];
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = 0;
        Q[x] = u[0];
        event high: u[0] - 0.5, rising;
        event either: u[0] - u[1];
    }
}

/// Events of inputs alone happen where a control law takes them across zero.
#[test]
fn events_of_inputs_alone_are_at_the_instants() {
    let law = |at: &State<f64, 1>, u: &mut SVector<f64, 2>| *u = [0.3 * at.t, 2.0 - at.t].into();
    macro_rules! met {
        ($method:expr, $control:expr) => {
            let start = State::new(0.0, [0.0], [0.0]);
            let mut cart = Stepper::new(Commanded::default(), $method, $control, start).every(0.25, law);
            let events = cart.until(4.0).events((Commanded::HIGH, Commanded::EITHER));
            let mut met: Vec<_> = events.map(Result::unwrap).collect();
            met.sort_by_key(|event| event.name);
            let name = stringify!($method);
            assert_eq!(met.iter().map(|event| event.name).collect::<Vec<_>>(), ["either", "high"], "{name}");
            assert!(met.iter().all(|event| (event.state.t - 1.75).abs() < 1e-14), "{name}");
        };
    }
    met!(Dop853, PiController::tolerance(1e-9));
    met!(Rk4, FixedStep::new(0.1));
    met!(Radau5, PiController::tolerance(1e-6));
    met!(Taylor, TaylorController::tolerance(1e-12));
}
