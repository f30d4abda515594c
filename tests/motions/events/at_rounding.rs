//! Events where rounding decides: flights that are shorter than time can tell, so that no ball falls through its
//! ground, and touches beside large values.

use lagrange_runtime::prelude::*;

lagrangian! {
    /// A ball above a level ground.
    pub system Ball {
        param m = 1, g = 9.81, floor = 0.0;
        coord x, y;
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
        V = m * g * y;
        event ground: y - floor, falling, terminal;
    }
}

/// A ball on a level ground at `floor`, and one on the parabola y = x² / 2.
fn ball(floor: f64) -> Ball {
    Ball { floor, ..Ball::default() }
}

/// A flight upward from the ground takes 2 v / g, whatever step the method would take.
#[test]
fn short_flights_end_on_the_ground() {
    fn flights<M, C>(method: impl Fn() -> M, controller: C, t: f64, sideways: f64)
    where
        M: Method<Ball, 2>,
        C: lagrange_runtime::Controller<f64, 2, M::Error> + Copy,
    {
        let ball = ball(0.0);
        for k in 8..=30 {
            let speed = 10f64.powf(-0.5 * f64::from(k));
            let exact = 2.0 * speed / ball.g;
            // Places in a step are told to its rounding; here the first step is not longer than a second.
            let rounding = f64::EPSILON * t.max(1.0);
            if exact < 40.0 * rounding {
                continue;
            }
            for until in [t + 1e-3, t + 1.0, t + 1e3] {
                let start = State::new(t, [0.5, 0.0], [sideways, speed]);
                let run = integrate(&ball, method(), controller, start).until(until);
                let landed = run.events(Ball::GROUND).next();
                let Some(Ok(landed)) = landed else { panic!("{t} {speed:e} until {until}: {landed:?}") };
                let error = (landed.state.t - t - exact).abs();
                assert!(error <= 1e-9 * exact + 2.0 * rounding, "{t} {speed:e} until {until}: {error:e}");
                let back = landed.state.qd[1] + speed;
                assert!(back.abs() <= 1e-9 * speed + ball.g * 2.0 * rounding, "{t} {speed:e}: {back:e}");
            }
        }
    }
    for t in [0.0, 0.8, 100.0] {
        for sideways in [0.0, 3.0] {
            flights(|| Dop853, PiController::tolerance(1e-9), t, sideways);
            flights(|| DormandPrince5, PiController::tolerance(1e-9), t, sideways);
            flights(|| Rodas5P, PiController::tolerance(1e-9), t, sideways);
            flights(|| Taylor, TaylorController::tolerance(1e-12), t, sideways);
        }
    }
}

/// Way in which a ball is followed from one impact to the next.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Followed {
    Restarted,
    InRunsOfItsOwn,
    ByStepper,
}

/// The failure in which the bounces of a ball end, the number of them, and the largest depth at one.
fn bounced<M, C>(
    ball: &Ball,
    (method, controller): (impl Fn() -> M, C),
    start: State<f64, 2>,
    restitution: f64,
    followed: Followed,
) -> (Option<Failure>, usize, f64)
where
    M: Method<Ball, 2>,
    C: lagrange_runtime::Controller<f64, 2, M::Error> + Copy,
{
    let end = start.t + 1e3;
    let (mut bounces, mut deepest) = (0, 0.0f64);
    let mut hit = |at: State<f64, 2>| {
        bounces += 1;
        deepest = deepest.max((at.q[1] - ball.floor).abs());
        State { qd: [at.qd[0], -restitution * at.qd[1]].into(), ..at }
    };
    let failure = match followed {
        Followed::Restarted => {
            let mut events = integrate(ball, method(), controller, start).until(end).events(Ball::GROUND);
            loop {
                match events.next() {
                    Some(Ok(impact)) => events.restart(hit(impact.state)),
                    other => break other.and_then(Result::err),
                }
            }
        }
        Followed::InRunsOfItsOwn => {
            let mut at = start;
            loop {
                match integrate(ball, method(), controller, at).until(end).events(Ball::GROUND).next() {
                    Some(Ok(impact)) => at = hit(impact.state),
                    other => break other.and_then(Result::err),
                }
            }
        }
        Followed::ByStepper => {
            let mut stepper = Stepper::new(*ball, method(), controller, start);
            loop {
                let next = stepper.until(end).events(Ball::GROUND).next();
                match next {
                    Some(Ok(impact)) => stepper.set_state(hit(impact.state)).unwrap(),
                    other => break other.and_then(Result::err),
                }
            }
        }
    };
    (failure, bounces, deepest)
}

#[test]
#[cfg_attr(not(feature = "long"), ignore = "long")]
fn no_ball_falls_through_its_ground() {
    let mut least = usize::MAX;
    for floor in [0.0, 1.0, -0.3] {
        let ball = ball(floor);
        for restitution in [0.02, 0.3, 0.5, 0.7, 0.9] {
            for (sideways, t) in [(0.0, 0.0), (2.0, 0.0), (0.5, 50.0)] {
                let start = State::new(t, [0.2, floor + 1.0], [sideways, 0.0]);
                let end = t + (2.0 / ball.g).sqrt() * (1.0 + restitution) / (1.0 - restitution);
                for followed in [Followed::Restarted, Followed::InRunsOfItsOwn, Followed::ByStepper] {
                    macro_rules! check {
                        ($method:expr, $controller:expr) => {{
                            let (failure, bounces, depth) =
                                bounced(&ball, ($method, $controller), start, restitution, followed);
                            let what = format!(
                                "floor {floor} e {restitution} v {sideways} t {t} {followed:?}: {bounces} bounces, {depth:e}, {failure:?}"
                            );
                            let Some(Failure::EventsAccumulate { t: last, .. }) = failure else { panic!("{what}") };
                            // Flights are lost in the rounding of heights.
                            let height = 16.0 * f64::EPSILON * floor.abs();
                            let shortest = (8.0 * height / ball.g).sqrt() / (1.0 - restitution) + 1e-11;
                            assert!((last - end).abs() <= shortest, "{:e} {shortest:e}; {what}", last - end);
                            least = least.min(bounces);
                        }};
                    }
                    check!(|| Dop853, PiController::tolerance(1e-10));
                    check!(|| DormandPrince5, PiController::tolerance(1e-10));
                    check!(|| Rodas5P, PiController::tolerance(1e-10));
                    check!(|| Rk4, FixedStep::new(1e-3));
                }
            }
        }
    }
    assert!(least >= 4, "{least}");
}

lagrangian! {
    /// A ball above a floor that is moved up and down.
    system Shaken {
        param floor, amplitude, omega, g = 9.81;
        coord y;
        T = 0.5 * dot(y).powi(2);
        V = g * y;
        event ground: y - floor - amplitude * sin(omega * t), falling, terminal;
    }
}

/// A floor goes on in steps of the clock where a ball that has left it does not: the rounding of time is no impact.
/// Each impact is met with a velocity towards the floor, none is lost, and flights that can be told do not accumulate.
#[test]
fn no_ball_falls_through_a_shaken_floor() {
    let mut impacts = 0;
    for (omega, amplitude) in [(3.0, 0.001), (5.0, 0.05), (5.0, 0.02), (7.0, 0.05), (20.0, 0.1)] {
        for restitution in [0.3, 0.5, 0.8] {
            for (tolerance, floor) in [(1e-8, 0.0), (1e-11, 0.0), (1e-11, 1.0)] {
                let ball = Shaken::new(floor, amplitude, omega);
                let controller = PiController::tolerance(tolerance);
                let start = State::new(0.0, [floor + 0.5], [0.0]);
                let moves = |t: f64| amplitude * omega * f64::cos(omega * t);
                let (mut at, mut relative) = (start, 0.0);
                let mut stepper = Stepper::new(ball, Dop853, controller, start);
                let mut events =
                    integrate(&ball, Dop853, controller, start).until(3.0).events(Shaken::GROUND);
                let failure = loop {
                    let next = events.next();
                    assert_eq!(stepper.until(3.0).events(Shaken::GROUND).next(), next);
                    let what =
                        format!("{omega} {amplitude} {restitution} {tolerance} {floor}: {next:?}, {at:?}");
                    match next {
                        Some(Ok(impact)) => {
                            at = impact.state;
                            relative = at.qd[0] - moves(at.t);
                            assert!(relative < 0.0, "{what}");
                            at.qd[0] = moves(at.t) - restitution * relative;
                            events.restart(at);
                            stepper.set_state(at).unwrap();
                            impacts += 1;
                        }
                        other => break other.and_then(Result::err),
                    }
                };
                let what =
                    format!("{omega} {amplitude} {restitution} {tolerance} {floor}: {failure:?}, {at:?}");
                match failure {
                    None => assert!(Shaken::GROUND.value(&ball, stepper.state()) > -1e-9, "{what}"),
                    Some(Failure::EventsAccumulate { .. }) => {
                        let height =
                            0.5 * (restitution * relative).powi(2) / (9.81 + amplitude * omega * omega);
                        assert!(height < 1e-11, "{height:e}; {what}");
                    }
                    Some(_) => panic!("{what}"),
                }
            }
        }
    }
    assert!(impacts > 500, "{impacts}");
}

/// Impacts on the parabola y = x² / 2, with the remaining parts of the velocities along and across it.
#[test]
#[cfg_attr(not(feature = "long"), ignore = "long")]
fn no_ball_falls_through_a_hollow() {
    let ball = ball(0.0);
    for restitution in [0.1, 0.5, 0.8] {
        for along in [0.0, 0.6, 1.0] {
            for k in 0..20 {
                let x = 0.1 * f64::from(k) - 0.95;
                let start = State::new(0.1, [x, 0.5 * x * x + 0.3], [0.4 * f64::from(k % 3), 0.0]);
                let hollow =
                    Event::falling(|at: &State<f64, 2>| at.q[1] - 0.5 * at.q[0] * at.q[0]).terminal();
                let run = integrate(&ball, Dop853, PiController::tolerance(1e-11), start).until(1e3);
                let mut events = run.events(hollow);
                let mut bounces = 0;
                let failure = loop {
                    match events.next() {
                        Some(Ok(impact)) => {
                            let mut at = impact.state;
                            let steep = at.q[0];
                            let across = (at.qd[1] - steep * at.qd[0]) / (1.0 + steep * steep);
                            let tangent = at.qd[0] + steep * across;
                            at.qd[0] = along * tangent + restitution * steep * across;
                            at.qd[1] = along * tangent * steep - restitution * across;
                            bounces += 1;
                            events.restart(at);
                        }
                        other => break other.and_then(Result::err),
                    }
                };
                assert!(
                    matches!(failure, Some(Failure::EventsAccumulate { .. })) && bounces > 4,
                    "e {restitution} along {along} x {x}: {bounces} bounces, {failure:?} at {:?}",
                    events.state()
                );
            }
        }
    }
}

/// Motions that are ended on a root, and go on through it, or touch it, are no flights.
#[test]
fn roots_that_are_left_as_they_were_met_are_no_flights() {
    let ball = ball(0.0);
    for (k, t) in (0..40).flat_map(|k| [(k, 0.0), (k, 7.0)]) {
        let u = f64::from(k);
        let start = State::new(t, [0.3 + 0.01 * u, 1.0 + 0.1 * u], [1.0 - 0.04 * u, 2.0 - 0.1 * u]);
        let times: [f64; 4] = [0.11, 0.23, 0.35, 0.41];
        let at = |s: f64| start.q[1] + start.qd[1] * s - 0.5 * ball.g * s * s;
        let heights = times.map(at);
        // g crosses zero at three times: once as a cubic, once for good, and is touched from above and below.
        let cubic = Event::falling(|at: &State<f64, 2>| (at.q[1] - heights[0]).powi(3)).terminal();
        let falls = Event::falling(|at: &State<f64, 2>| at.q[1] - heights[1]).terminal();
        let touch = Event::either(|at: &State<f64, 2>| (at.t - t - times[2]).powi(2)).terminal();
        let below = Event::either(|at: &State<f64, 2>| -(at.q[1] - heights[3]).powi(2)).terminal();
        let run = integrate(&ball, Dop853, PiController::tolerance(1e-10), start).until(t + 0.5);
        let mut events = run.events((cubic, falls, touch, below));
        let mut count = 0;
        while let Some(event) = events.next() {
            let event = event.unwrap_or_else(|failure| panic!("{k} {t}: {failure}"));
            count += 1;
            assert!(count < 20, "{k} {event:?}");
            let state = *events.state();
            events.restart(state);
        }
        assert!((events.state().t - t - 0.5).abs() < 1e-12 && count >= 1, "{k} {count}");
    }
}

lagrangian! {
    /// A point attracted by a centre.
    pub system Orbit {
        coord x, y;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = -1 / sqrt(x * x + y * y);
    }
}

/// A g of one sign that varies by many powers of ten touches nothing, although it is small beside its largest value;
/// one that does touch zero there does.
#[test]
fn touches_beside_large_values() {
    let eccentricity: f64 = 0.9;
    let start = State::new(
        0.0,
        [1.0 - eccentricity, 0.0],
        [0.0, ((1.0 + eccentricity) / (1.0 - eccentricity)).sqrt()],
    );
    let (orbit, end) = (Orbit::default(), 20.0);
    let count = |g: &dyn Fn(&State<f64, 2>) -> f64| {
        let run = integrate(&orbit, Dop853, PiController::tolerance(1e-10), start).until(end);
        run.events(Event::either(|at: &State<f64, 2>| g(at))).map(Result::unwrap).count()
    };
    let r = |at: &State<f64, 2>| at.q.norm();
    assert_eq!(count(&|at| r(at).powi(-16)), 0);
    assert_eq!(count(&|at| (-40.0 * r(at)).exp()), 0);
    assert_eq!(count(&|at| (60.0 * at.q[0]).exp()), 0);
    assert_eq!(count(&|at| (-60.0 * at.q[1]).exp()), 0);
    // Three passages through the apocentre, from one at π on.
    let apart = 1.0 + eccentricity;
    assert_eq!(count(&|at| (at.q[0] * at.qd[0] + at.q[1] * at.qd[1]).powi(2) * r(at).powi(-16)), 6);
    assert_eq!(count(&|at| (at.q[1] / apart).powi(2)), 6);
}
