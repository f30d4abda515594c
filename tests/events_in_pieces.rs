//! Events of a stepper, whose motion is followed in pieces: each is met once, wherever the pieces end and whatever
//! other events were looked for before, against closed forms.

use lagrange_runtime::prelude::*;
use lagrange_runtime::{Controller, Stepper};

lagrangian! {
    /// A cart that rolls at a constant speed.
    system Cart {
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = 0;
        event near: x - 0.3;
        event far: x - 0.9, terminal;
        event gates: sin(PI * x / 0.25);
    }
}

lagrangian! {
    /// A ball that is thrown.
    system Ball {
        param g = 9.81;
        coord y;
        T = 0.5 * dot(y).powi(2);
        V = g * y;
        event ground: y, falling, terminal;
        event apex: dot(y), falling;
    }
}

lagrangian! {
    /// A cart on rails, and a switch that an input works.
    system Switched {
        input u;
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = 0;
        event on: u - 1 + 1e-3 * x, rising;
    }
}

const START: State<f64, 1> =
    State { t: 0.0, q: SVector::<f64, 1>::new(0.0), qd: SVector::<f64, 1>::new(1.0) };

fn cart() -> Stepper<Cart, Dop853, PiController, 1> {
    Stepper::new(Cart::new(), Dop853, PiController::tolerance(1e-9), START)
}

#[test]
fn another_search_looks_for_its_own_events() {
    let mut cart = cart();
    cart.until(0.4).events(Cart::NEAR).for_each(drop);
    let far = cart.until(2.0).events(Cart::FAR).next().unwrap().unwrap();
    assert!((far.state.t - 0.9).abs() < 1e-12, "{far:?}");
}

#[test]
fn events_in_another_order_keep_their_sides() {
    let mut cart = cart();
    cart.until(0.4).events((Cart::NEAR, Cart::FAR)).for_each(drop);
    let met: Vec<_> = cart.until(2.0).events((Cart::FAR, Cart::NEAR)).map(|met| met.unwrap().name).collect();
    assert_eq!(met, ["far"]);
}

#[test]
fn closures_with_other_thresholds_are_other_events() {
    let threshold = |at: f64| Event::rising(move |s: &State<f64, 1>| s.q[0] - at);
    let mut cart = cart();
    cart.until(0.4).events(threshold(0.1)).for_each(drop);
    let met: Vec<_> = cart.until(2.0).events(threshold(1.5)).map(|met| met.unwrap().state.t).collect();
    assert!(met.len() == 1 && (met[0] - 1.5).abs() < 1e-12, "{met:?}");
}

fn gates_by<M: Method<Cart, 1>, C: Controller<f64, 1, M::Error>>(method: M, controller: C) {
    let mut cart = Stepper::new(Cart::new(), method, controller, START);
    let ends = [0.25, 0.5, 0.6, 1.1, 1.25, 1.25, 2.0, 2.1];
    let times: Vec<f64> = ends
        .into_iter()
        .flat_map(|end| {
            cart.until(end).events(Cart::GATES).map(|met| met.unwrap().state.t).collect::<Vec<_>>()
        })
        .collect();
    assert_eq!(times.len(), 8, "{times:?}");
    for (k, t) in times.iter().enumerate() {
        assert!((t - 0.25 * (k + 1) as f64).abs() < 1e-12, "{times:?}");
    }
}

#[test]
fn pieces_that_end_on_an_event_lose_none() {
    gates_by(Dop853, PiController::tolerance(1e-9));
    gates_by(Verner9, PiController::tolerance(1e-9));
    gates_by(Rk4, FixedStep::new(0.03));
    gates_by(Taylor, TaylorController::tolerance(1e-12));
}

/// The last flight of a ball and the top of it are in one step.
#[test]
fn a_search_that_is_left_goes_on_at_the_event() {
    let mut ball =
        Stepper::new(Ball::default(), Dop853, PiController::tolerance(1e-9), State::new(0.0, [1.0], [3.0]));
    let mut met = vec![];
    while let Some(event) = ball.until(5.0).events((Ball::APEX, Ball::GROUND)).next() {
        let event = event.unwrap();
        assert_eq!(event.state.t, ball.state().t);
        met.push((event.name, event.state.t));
        if event.terminal {
            break;
        }
    }
    let (g, top) = (9.81, 3.0 / 9.81);
    let ground = top + (2.0 / g * (1.0 + 0.5 * 9.0 / g)).sqrt();
    assert_eq!(met.iter().map(|(name, _)| *name).collect::<Vec<_>>(), ["apex", "ground"]);
    assert!((met[0].1 - top).abs() < 1e-9 && (met[1].1 - ground).abs() < 1e-9, "{met:?}");
    assert!(ball.state().q[0].abs() < 1e-9);
}

/// A search whose work is bounded meets the same events at the same times, whatever the bound.
#[test]
fn pieces_of_a_few_steps_lose_none() {
    let ball = || Stepper::new(Ball::default(), Rk4, FixedStep::new(0.01), State::new(0.0, [1.0], [3.0]));
    let events = (Ball::APEX, Ball::GROUND);
    let at_once: Vec<_> =
        ball().until(5.0).events(events).map(|met| met.unwrap()).map(|met| (met.name, met.state)).collect();
    assert_eq!(at_once.len(), 2);
    for attempts in [1, 2, 3, 7, 1000] {
        let (mut ball, mut met, mut calls) = (ball(), vec![], 0);
        while met.last().is_none_or(|(name, _)| *name != "ground") {
            calls += 1;
            assert!(calls < 1000, "{attempts}");
            met.extend(
                ball.until(5.0)
                    .within(attempts)
                    .events(events)
                    .map(|met| met.unwrap())
                    .map(|met| (met.name, met.state)),
            );
        }
        // (A landing may begin at another estimate: it agrees to rounding.)
        assert_eq!(met.len(), at_once.len(), "{attempts}: {met:?}");
        for ((name, at), (known, expected)) in met.iter().zip(&at_once) {
            assert_eq!(name, known, "{attempts}");
            assert!((at.t - expected.t).abs() < 1e-14, "{attempts}: {at:?}, {expected:?}");
            assert!((at.qd - expected.qd).amax() < 1e-14, "{attempts}: {at:?}, {expected:?}");
        }
    }
    let mut idle = ball();
    assert!(idle.until(1.0).within(0).events(events).next().is_none());
    assert_eq!(idle.state().t, 0.0);
}

/// A loop over `next` meets what one search meets, at the same times.
#[test]
fn events_one_by_one_are_those_of_one_search() {
    let fast = Event::rising(|s: &State<f64, 1>| (20.0 * s.t).sin());
    let slow = Event::either(|s: &State<f64, 1>| (s.q[0] - 0.31) * (s.q[0] - 1.7));
    let all: Vec<_> = cart().until(3.0).events((fast, slow)).map(|met| met.unwrap().state.t).collect();
    assert_eq!(all.len(), 9 + 2);
    let mut one_by_one = cart();
    for t in &all {
        let met = one_by_one.until(3.0).events((fast, slow)).next().unwrap().unwrap();
        assert!((met.state.t - t).abs() < 1e-9, "{met:?}, {t}");
        assert_eq!(one_by_one.state().t, met.state.t);
    }
    assert!(one_by_one.until(3.0).events((fast, slow)).next().is_none());
    assert_eq!(one_by_one.state().t, 3.0);
}

#[test]
fn inputs_cross_events_between_pieces() {
    for copies in 1..=3 {
        let mut cart = Stepper::new(Switched::new(), Dop853, PiController::tolerance(1e-9), START);
        let mut times = vec![];
        for k in 1..=8 {
            if k == 3 {
                cart.set_inputs([2.0]).unwrap();
            }
            let end = 0.25 * f64::from(k);
            times.extend(match copies {
                1 => cart
                    .until(end)
                    .events([Switched::ON; 1])
                    .map(|met| met.unwrap().state.t)
                    .collect::<Vec<_>>(),
                2 => cart.until(end).events([Switched::ON; 9]).map(|met| met.unwrap().state.t).collect(),
                _ => cart.until(end).events([Switched::ON; 16]).map(|met| met.unwrap().state.t).collect(),
            });
        }
        assert_eq!(times, vec![0.5; [1, 9, 16][copies - 1]], "{copies}");
    }
}

lagrangian! {
    /// Three balls over one floor.
    system Balls {
        param g = 9.81;
        coord a, b, c;
        T = 0.5 * (dot(a).powi(2) + dot(b).powi(2) + dot(c).powi(2));
        V = g * (a + b + c);
        event hit: [a, b, c], falling, terminal;
        event pass: [a, b, c], falling;
    }
}

/// Bounces of each ball in four seconds, met one by one, and the heights at the end.
fn bounces<M, C>(method: M, controller: C, apart: f64) -> ([u32; 3], [f64; 3])
where
    M: Method<Balls, 3>,
    C: Controller<f64, 3, M::Error>,
{
    let start = State::new(0.0, [1.0, 1.0 + apart, 1.0 - apart], [0.0; 3]);
    let balls = Balls::new();
    let mut events = integrate(&balls, method, controller, start).until(4.0).events(Balls::HIT);
    let mut met = [0; 3];
    while let Some(event) = events.next() {
        let event = event.unwrap();
        let mut at = event.state;
        at.qd[event.event] *= -0.9;
        met[event.event] += 1;
        events.restart(at);
    }
    (met, events.state().q.into())
}

/// Three events at one time, each followed by a restart: none is lost, however far apart they are within rounding.
/// Heights of 1 m, of which each bounce leaves 0.81.
#[test]
fn events_at_one_time_are_met_one_by_one() {
    for apart in [0.0, 1e-15, 1e-14, 1e-13, 1e-12, 1e-9] {
        for (met, heights) in [
            bounces(Rk4, FixedStep::new(0.01), apart),
            bounces(Dop853, PiController::tolerance(1e-6), apart),
            bounces(Dop853, PiController::tolerance(1e-11), apart),
            bounces(DormandPrince5, PiController::tolerance(1e-9), apart),
            bounces(Taylor, TaylorController::tolerance(1e-12), apart),
        ] {
            assert_eq!(met, [6; 3], "{apart:e}: {heights:?}");
            assert!(heights.iter().all(|h| (h - heights[0]).abs() < 1e-6), "{apart:e}: {heights:?}");
        }
    }
    // Left at each by a stepper.
    for tolerance in [1e-6, 1e-8, 1e-10, 1e-12] {
        let start = State::new(0.0, [1.0; 3], [0.0; 3]);
        let mut balls = Stepper::new(Balls::new(), Dop853, PiController::tolerance(tolerance), start);
        let mut met = [0; 3];
        while let Some(event) = balls.until(1.0).events(Balls::PASS).next() {
            met[event.unwrap().event] += 1;
        }
        assert_eq!(met, [1; 3], "{tolerance:e}");
    }
}

lagrangian! {
    /// A load on a spring, between two stops that an input moves.
    system Load {
        param k = 1.0;
        input u;
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = 0.5 * k * x.powi(2);
        Q[x] = u;
        event low: u - k * x - 0.4, rising;
        event high: u - k * x - 0.6, rising;
    }
}

/// An input that jumps over several events at once: each is met, in any order.
#[test]
fn an_input_crosses_several_events() {
    let rest = State::new(0.0, [0.0], [0.0]);
    let load = || {
        let law = |at: &State<f64, 1>, u: &mut SVector<f64, 1>| u[0] = if at.t > 0.25 { 1.0 } else { 0.0 };
        Stepper::new(Load::default(), Dop853, PiController::tolerance(1e-9), rest).every(0.1, law)
    };
    let (mut forth, mut back) = (load(), load());
    let (mut first, mut second) = (Vec::new(), Vec::new());
    while let Some(event) = forth.until(0.35).events((Load::LOW, Load::HIGH)).next() {
        first.push(event.unwrap().name);
    }
    while let Some(event) = back.until(0.35).events((Load::HIGH, Load::LOW)).next() {
        second.push(event.unwrap().name);
    }
    assert_eq!((first, second), (vec!["low", "high"], vec!["high", "low"]));
}

/// A ball comes to rest after √(2 h/g) (1 + e)/(1 − e). Whatever the tolerance, its bounces accumulate, and what made
/// them is left on the ground.
#[test]
fn bounces_that_accumulate_end_on_the_ground() {
    let (start, restitution) = (State::new(0.0, [1.0], [0.0]), 0.8);
    let rest = (2.0 / 9.81f64).sqrt() * (1.0 + restitution) / (1.0 - restitution);
    for exponent in 6..15 {
        let controller = PiController::tolerance(10f64.powi(-exponent));
        let hit = |mut at: State<f64, 1>| {
            at.qd *= -restitution;
            at
        };
        let ball = Ball::new();
        let mut events = integrate(&ball, Dop853, controller, start).until(20.0).events(Ball::GROUND);
        let failure = loop {
            match events.next().expect("a bounce, or a failure") {
                Ok(bounce) => events.restart(hit(bounce.state)),
                Err(failure) => break failure,
            }
        };
        let run = (failure, *events.state());
        let mut stepper = Stepper::new(Ball::new(), Dop853, controller, start);
        let failure = loop {
            let next = stepper.until(20.0).events(Ball::GROUND).next();
            match next.expect("a bounce, or a failure") {
                Ok(bounce) => stepper.set_state(hit(bounce.state)).unwrap(),
                Err(failure) => break failure,
            }
        };
        for (failure, at) in [run, (failure, *stepper.state())] {
            let what = format!("1e-{exponent}: {failure:?} {at:?}");
            assert!(matches!(failure, Failure::EventsAccumulate { .. }), "{what}");
            assert!((at.t - rest).abs() < 1e-11 && at.q[0].abs() < 1e-20 && at.qd[0] < 1e-12, "{what}");
        }
        // It is held there.
        stepper.set_state(State::new(stepper.state().t, [0.0], [0.0])).unwrap();
        stepper.system_mut().g = 0.0;
        stepper.advance_to(20.0).unwrap();
        assert_eq!(stepper.state().q[0], 0.0);
    }
}

/// A restart from where no motion begins is told, and the stepper stays where it was.
#[test]
fn a_restart_that_is_none_is_told() {
    let start = State::new(0.0, [0.0], [1.0]);
    let mut cart = Stepper::new(Cart::new(), Dop853, PiController::tolerance(1e-12), start);
    let mut events = cart.until(4.0).events(Cart::NEAR);
    let gate = events.next().unwrap().unwrap().state;
    for bad in [State::new(gate.t, [f64::NAN], [1.0]), State { t: f64::INFINITY, ..gate }] {
        events.restart(bad);
        assert_eq!(*events.state(), gate);
        assert!(matches!(events.next(), Some(Err(Failure::StateNotFinite { .. }))));
        assert!(events.next().is_none());
    }
    events.restart(State { qd: [2.0].into(), ..gate });
    assert!(events.next().is_none());
    assert_eq!(cart.state().t, 4.0);
    let end = gate.q[0] + 2.0 * (4.0 - gate.t);
    assert!((cart.state().q[0] - end).abs() < 1e-12, "{} for {end}", cart.state().q[0]);
}

/// Nor does time go back to the end of a run that is restarted beyond it.
#[test]
fn a_restart_beyond_the_end_is_told() {
    let (system, start) = (Cart::new(), State::new(0.0, [0.0], [1.0]));
    let beyond = State::new(5.0, [2.0], [1.0]);
    let run = || integrate(&system, Dop853, PiController::tolerance(1e-12), start).until(4.0);
    let mut events = run().events(Cart::NEAR);
    events.next().unwrap().unwrap();
    events.restart(beyond);
    assert!(matches!(events.next(), Some(Err(Failure::TimeGoesBack { .. }))));
    let mut ended = run();
    ended.run_to_end().unwrap();
    ended.restart(beyond);
    let back = ended.clone().final_state().unwrap_err().failure;
    assert_eq!(back, Failure::TimeGoesBack { t: 5.0, end: 4.0 });
    assert!((ended.until(6.0).final_state().unwrap().q[0] - 3.0).abs() < 1e-14);
}
