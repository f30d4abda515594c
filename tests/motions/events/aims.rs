//! Adaptive steps that aim a little beyond the event that ends their run.

use lagrange_runtime::Stepper;
use lagrange_runtime::ensemble::rand_distr::{Distribution, Uniform};
use lagrange_runtime::ensemble::{Collect, Ensemble, Random};
use lagrange_runtime::event::Direction;
use lagrange_runtime::lanes::{FoldSteps, Fused, Occurrences};
use lagrange_runtime::prelude::*;

lagrangian! {
    system Pendulum {
        param g, c;
        coord theta: angle;
        T = 0.5 * dot(theta).powi(2);
        V = -g * cos(theta);
        D = 0.5 * c * dot(theta).powi(2);
    }
}

lagrangian! {
    /// A shot with quadratic drag.
    system Shot {
        param drag, g = 9.81;
        coord x, z;
        T = 0.5 * (dot(x).powi(2) + dot(z).powi(2));
        V = g * z;
        let v = hypot(dot(x), dot(z));
        force [-drag * v * dot(x), -drag * v * dot(z)] at [x, z];
        event ground: z, falling, terminal;
    }
}

fn random(seed: u64) -> impl FnMut() -> f64 {
    let mut seed = seed;
    move || {
        seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (seed >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// A run that ends at a level of a pendulum, grazed or crossed at speed, against the first occurrence of the same
/// event that does not end the run, whose steps do not aim, at 1e-13.
#[test]
fn runs_end_where_events_are_first_met() {
    let mut random = random(5);
    let mut worst = [0.0f64; 3];
    for trial in 0..if cfg!(feature = "long") { 3000 } else { 120 } {
        let pendulum = Pendulum::new(9.81 * (0.2 + random()), if trial % 3 == 0 { random() } else { 0.0 });
        let start = State::new(0.0, [3.0 * (2.0 * random() - 1.0)], [8.0 * (2.0 * random() - 1.0)]);
        // Every fourth has a level just within its amplitude.
        let run = integrate(&pendulum, Dop853, PiController::tolerance(1e-13), start).until(4.0);
        let turn = run.events(Event::either(|s: &State<f64, 1>| s.qd[0])).next();
        let level = match turn {
            Some(turn) if trial % 4 == 0 => {
                let turn = turn.unwrap().state.q[0];
                turn - turn.signum() * 10f64.powf(-1.0 - 6.0 * random())
            }
            _ => 4.0 * (2.0 * random() - 1.0),
        };
        let g = |s: &State<f64, 1>| s.q[0] - level;
        let direction = [Direction::Either, Direction::Falling, Direction::Rising][trial % 3];
        let event = Event::new(direction, g);
        let run = |tolerance: f64| {
            integrate(&pendulum, Dop853, PiController::tolerance(tolerance), start).until(6.0)
        };
        let exact = run(1e-13).events(event).next().map(Result::unwrap);
        for (tolerance, worst) in [1e-5, 1e-8, 1e-11].into_iter().zip(&mut worst) {
            // (A level that is grazed within the tolerance may be missed by it.)
            if exact.is_some_and(|exact| exact.state.qd[0].powi(2) < 1e3 * tolerance) {
                continue;
            }
            let [soft, found] = [event, event.terminal()]
                .map(|event| run(tolerance).events(event).next().map(|met| met.unwrap().state));
            let what = format!(
                "{trial} at {tolerance:e}: {found:?} not {exact:?}, level {level} {pendulum:?} {start:?}"
            );
            let (Some(soft), Some(found), Some(exact)) = (soft, found, exact) else {
                assert_eq!(found.is_some(), exact.is_some(), "{what}");
                continue;
            };
            let error = |at: &State<f64, 1>| {
                let late = (at.t - exact.state.t).abs() * exact.state.qd[0].abs().min(1.0);
                let square = exact.state.qd[0].powi(2);
                late + (at.qd[0].powi(2) - square).abs() / (1.0 + square)
            };
            // The integration misses both by about as much. (Squares of velocities, since velocities themselves are as
            // the root of the error near a turn.)
            *worst = worst.max(error(&found) / (error(&soft) + tolerance));
            assert!(g(&found).abs() < 1e-13, "{what}");
        }
    }
    println!("{worst:?}");
    assert!(worst.iter().all(|ratio| *ratio < 10.0), "{worst:?}");
}

/// A shot to the ground takes no more evaluations than one to the time at which it lands.
#[test]
fn landing_costs_no_step() {
    let mut random = random(3);
    for tolerance in [1e-4, 1e-6, 1e-9] {
        let (mut ground, mut time, mut error) = (0, 0, 0.0f64);
        for _ in 0..200 {
            let (shot, speed, up) = (Shot::new(2e-3 * random()), 50.0 + 100.0 * random(), 0.3 + random());
            let start = State::new(0.0, [0.0; 2], [speed * up.cos(), speed * up.sin()]);
            let run = |tolerance| integrate(&shot, Dop853, PiController::tolerance(tolerance), start);
            let mut events = run(tolerance).until(100.0).events(Shot::GROUND);
            let landed = events.next().unwrap().unwrap().state;
            ground += events.statistics().evaluations;
            let mut fixed = run(tolerance).until(landed.t);
            fixed.run_to_end().unwrap();
            let end = *fixed.state();
            time += fixed.statistics().evaluations;
            error = error.max((end.q - landed.q).norm() / (tolerance * end.q.norm()));
        }
        println!(
            "{tolerance:e}: {ground} evaluations to the ground, {time} to its time, {error} tolerances apart"
        );
        assert!(ground as f64 <= 1.05 * time as f64, "{tolerance:e}: {ground} and {time}");
        assert!(error < 10.0, "{error}");
    }
}

lagrangian! {
    /// A cart that moves on evenly, so that x = t exactly, beside an oscillation that holds its steps.
    system Cart {
        param wall;
        input u = 0;
        coord x, z;
        T = 0.5 * (dot(x).powi(2) + dot(z).powi(2));
        V = 200 * z.powi(2);
        Q[x] = u;
        event hit: x - wall, rising, terminal;
    }
}

const ON_ITS_WAY: [[f64; 2]; 2] = [[0.0, 1.0], [1.0, 0.0]];

fn start([q, qd]: [[f64; 2]; 2]) -> State<f64, 2> {
    State::new(0.0, q, qd)
}

/// A step that aims does not lead beyond the end of the run, nor over an instant of a control law, where a step is
/// longer by up to 1 % to land on it.
#[test]
fn no_step_aims_beyond_an_end() {
    for k in (1..=12).step_by(if cfg!(feature = "long") { 1 } else { 4 }) {
        let wall = 1.0 + 1e-4 * f64::from(k);
        for tolerance in (6..40).map(|i| 10f64.powf(-0.25 * f64::from(i))) {
            let (cart, controller) = (Cart::new(wall), PiController::tolerance(tolerance));
            let mut run =
                integrate(&cart, Dop853, controller, start(ON_ITS_WAY)).until(1.0).events(Cart::HIT);
            assert_eq!((run.next(), run.state().t), (None, 1.0), "{wall} {tolerance:e}");
            let mut stepper = Stepper::new(cart, Dop853, controller, start(ON_ITS_WAY));
            assert_eq!(stepper.until(1.0).events(Cart::HIT).next(), None, "{wall} {tolerance:e}");
            assert_eq!(stepper.state().t, 1.0, "{wall} {tolerance:e}");
            // An event that is approached there and never met takes the run no further, and nothing is met twice.
            let never = Event::falling(move |s: &State<f64, 2>| (s.q[0] - wall).abs() + 1e-6).terminal();
            let passed = Event::rising(|s: &State<f64, 2>| s.q[0] - 1.00005);
            let run = integrate(&cart, Dop853, controller, start(ON_ITS_WAY)).until(1.0);
            assert_eq!(run.events((never, passed)).count(), 0, "{wall} {tolerance:e}");
            // It brakes at t = 1, and turns at x = 1 + 5e-8.
            let mut braked = Stepper::new(cart, Dop853, controller, start(ON_ITS_WAY))
                .every(1.0, |at: &State<f64, 2>, u| u[0] = if at.t > 0.5 { -1e7 } else { 0.0 });
            assert_eq!(braked.until(1.5).events(Cart::HIT).next(), None, "{wall} {tolerance:e}");
        }
    }
}

lagrangian! {
    system OnARod {
        param level;
        coord x: length, y: length;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = 9.81 * y;
        constraint rod: x.powi(2) + y.powi(2) == 1;
        event passed: x - level, falling, terminal;
    }
}

/// The state at an event is on the constraints, so that a run goes on from there.
#[test]
fn runs_go_on_from_events_on_constraints() {
    for tolerance in [1e-2, 1e-4, 1e-6, 1e-8] {
        for k in (0..200).step_by(if cfg!(feature = "long") { 1 } else { 4 }) {
            let (level, up) = (0.9 - 0.009 * f64::from(k), 1.2f64);
            let start = State::new(0.0, [up.sin(), -up.cos()], [0.0, 0.0]);
            let mut stepper =
                Stepper::new(OnARod::new(level), Dop853, PiController::tolerance(tolerance), start);
            let at = stepper.until(3.0).events(OnARod::PASSED).next().unwrap().unwrap().state;
            let violation = at.q.dot(&at.qd).abs();
            assert!(violation < 1e-3 * tolerance, "{level} {tolerance:e}: {violation:e}");
            stepper.advance_to(3.0).unwrap();
        }
    }
}

/// A level that a pendulum grazes, just short of which a step has ended: both crossings lie within a thousandth of the
/// next one. The times are those of elliptic integrals, K(k) + F(φ, k).
#[test]
fn no_step_ends_just_short_of_a_graze() {
    for (tolerance, amplitude, below, time) in [
        (1e-13, 0.33560434453524524, 4.6383950960420676e-10, 3.1637982478),
        (1e-11, 0.8364237670809147, 3.289154037032452e-9, 3.2846377146),
    ] {
        let pendulum = Pendulum::new(1.0, 0.0);
        let run = integrate(
            &pendulum,
            Dop853,
            PiController::tolerance(tolerance),
            State::new(0.0, [-amplitude], [0.0]),
        );
        let level = Event::rising(|s: &State<f64, 1>| s.q[0] - (amplitude - below)).terminal();
        let met = run.until(20.0).events(level).next().unwrap().unwrap().state;
        // (The turn is flat: an error of 1e-13 in θ moves the time by 1e-8.)
        assert!((met.t - time).abs() < 1e-6, "{met:?} {time}");
    }
    // Steps that end there anyway.
    for k in 1..200 {
        let short = 10f64.powf(-13.0 + 0.05 * f64::from(k));
        let g = |t: f64| short - (t - 1.0 - 3.0 * short.sqrt()).powi(2);
        let clock = integrate(&Still, Rk4, FixedStep::new(0.5), State::new(0.0, [0.0], [0.0])).until(4.0);
        let met: Vec<f64> =
            clock.events(Event::either(|s: &State<f64, 1>| g(s.t))).map(|e| e.unwrap().state.t).collect();
        let [from, to] = [2.0, 4.0].map(|k| 1.0 + k * short.sqrt());
        let right = met.len() == 2 && (met[0] - from).abs() < 1e-9 && (met[1] - to).abs() < 1e-9;
        assert!(right || short < 1e-12, "{short:e}: {met:?} {from} {to}");
    }
}

/// Nothing moves but time.
struct Still;

impl System<1> for Still {
    type Scalar = f64;

    fn accel(&self, _: &SVector<f64, 1>, _: &SVector<f64, 1>, _: f64) -> SVector<f64, 1> {
        SVector::zeros()
    }
}

lagrangian! {
    system Double {
        param level;
        coord a, b;
        T = 0.5 * (2 * dot(a).powi(2) + dot(b).powi(2) + 2 * dot(a) * dot(b) * cos(a - b));
        V = -9.81 * (2 * cos(a) + cos(b));
        event height: sin(a) - level, falling, terminal;
    }
}

/// The error of a landing from the start of its step is no larger than a tolerance, or those of other steps.
#[test]
fn landings_are_as_good_as_steps() {
    let mut random = random(3);
    macro_rules! landings {
        ($method:expr, $tolerance:expr) => {{
            let (mut landed, mut steps) = (0.0f64, 0.0f64);
            for _ in 0..if cfg!(feature = "long") { 500 } else { 25 } {
                let double = Double::new(2.0 * random() - 1.0);
                let start = State::new(0.0, [6.0 * random() - 3.0, 6.0 * random() - 3.0], [0.0, 0.0]);
                let controller = PiController::tolerance($tolerance);
                let way = FoldSteps {
                    start: |_: &Double, start: &State<f64, 2>| vec![*start],
                    step: |way: &mut Vec<_>, _: &Double, _: &_, to: &State<f64, 2>| way.push(*to),
                    finish: |way: Vec<State<f64, 2>>, _: &Double, _: &State<f64, 2>| way,
                };
                let met = Occurrences::new(Double::HEIGHT, |_: &Double, met, _: &State<f64, 2>| met.len());
                let run = integrate(&double, $method, controller, start).until(8.0);
                let (way, met) = run.observe(&(way, met)).unwrap();
                if met == 0 || way.len() < 3 {
                    continue;
                }
                let error = |i: usize| {
                    let (from, at) = (way[i - 1], way[i]);
                    let run = integrate(&double, Dop853, PiController::tolerance(1e-13), from).until(at.t);
                    let exact = run.final_state().unwrap();
                    let part = |x: f64, exact: f64| ((x - exact) / (1.0 + exact.abs())).powi(2);
                    let sum: f64 =
                        (0..2).map(|k| part(at.q[k], exact.q[k]) + part(at.qd[k], exact.qd[k])).sum();
                    (sum / 4.0).sqrt() / $tolerance
                };
                landed = landed.max(error(way.len() - 1));
                steps = (1..way.len() - 1).map(error).fold(steps, f64::max);
            }
            println!("{:e}: {landed:.2} and {steps:.2} tolerances", $tolerance);
            assert!(landed <= steps.max(1.0), "{:e}: {landed} {steps}", $tolerance);
        }};
    }
    landings!(Dop853, 1e-5);
    landings!(Dop853, 1e-10);
    landings!(Verner9, 1e-5);
    landings!(Verner9, 1e-7);
    landings!(Verner9, 1e-10);
    landings!(DormandPrince5, 1e-5);
}

lagrangian! {
    system Marked {
        param level;
        coord theta;
        T = 0.5 * dot(theta).powi(2);
        V = -cos(theta);
        event level: theta - level, falling, terminal;
        event mark: dot(theta) + 0.7;
    }
}

/// Lanes aim where the same runs alone do, also where an event that does not end the run is in the step before.
#[test]
fn lanes_aim_as_runs_alone() {
    let levels = Uniform::new(-1.9, 1.9).unwrap();
    for tolerance in [1e-2, 1e-7] {
        let lanes = Ensemble::new(Random::seed(1), 300, |mut rng| {
            (Marked::new(levels.sample(&mut rng)), State::new(0.0, [2.0], [0.0]))
        })
        .integrate(Dop853, PiController::tolerance(tolerance), 5.0)
        .in_lanes(Fused);
        let events = (Marked::LEVEL, Marked::MARK);
        let ends = Occurrences::new(events, |_: &Marked, _, end: &State<f64, 1>| end.t);
        for (index, t) in lanes.observe(&ends, Collect).unwrap().statistic.rows {
            let alone = lanes.replay(index).unwrap();
            let alone =
                alone.run().events(events).final_state().unwrap_or_else(|failed| panic!("{failed:?}"));
            assert_eq!(alone.t.value(), t, "{index}");
        }
    }
}

/// An event that is approached again and again and never met costs a run three steps.
#[test]
fn events_that_are_never_met_cost_three_steps() {
    let (pendulum, start) = (Pendulum::new(1.0, 0.0), State::new(0.0, [1.0], [0.0]));
    for tolerance in [1e-4, 1e-7, 1e-10] {
        let run = || integrate(&pendulum, Dop853, PiController::tolerance(tolerance), start).until(200.0);
        let mut plain = run();
        plain.run_to_end().unwrap();
        let event = Event::falling(|s: &State<f64, 1>| s.q[0].max(0.01)).terminal();
        let mut watched = run().events(event);
        assert_eq!(watched.next(), None);
        let [plain, watched] = [plain.statistics(), watched.statistics()].map(|s| s.accepted + s.rejected);
        println!("{tolerance:e}: {plain} and {watched} steps");
        assert!(watched <= plain + 6, "{tolerance:e}: {plain} and {watched}");
    }
}
