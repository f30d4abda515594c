//! Events that are written in a system, against closures and closed forms.

use lagrange_runtime::prelude::*;
use lagrange_runtime::traits::CompiledEvents;

lagrangian! {
    /// A shot.
    pub system Shot {
        param m, floor = 0.0, g = 9.81;
        coord x: length, y: length;
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
        V = m * g * y;
        /// It lands.
        event ground: y - floor, falling, terminal;
        event apex: dot(y), falling;
        event marks: [x - 1, x - 2];
    }
}

#[test]
fn a_shot_has_its_events() {
    let shot = Shot { floor: -1.0, ..Shot::new(0.5) };
    let start = State::new(0.0, [0.0, 0.0], [1.0, 9.81]);
    let run = integrate(&shot, Dop853, PiController::tolerance(1e-10), start).until(10.0);
    let events = run.events((Shot::GROUND, Shot::APEX, Shot::MARKS[1], Event::rising(|at| at.q[0] - 0.5)));
    let events: Vec<_> = events.map(Result::unwrap).collect();
    let seen: Vec<_> = events.iter().map(|e| (e.name, e.state.t)).collect();
    let end = 1.0 + (1.0f64 + 2.0 / 9.81).sqrt();
    assert_eq!(seen.iter().map(|s| s.0).collect::<Vec<_>>(), ["", "apex", "marks[1]", "ground"]);
    let times = [0.5, 1.0, 2.0, end];
    assert!(seen.iter().zip(times).all(|(s, t)| (s.1 - t).abs() < 1e-12), "{seen:?}");
}

lagrangian! {
    /// A particle on a rod, pushed by an input, which may lift off.
    pub system Rod {
        param m, l, g = 9.81;
        input push;
        coord x, y;
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
        V = m * g * y;
        Q[x] = push;
        constraint rod: x * x + y * y == l * l;
        event slack: reaction(rod);
        event pushed: x + push - 2, rising, terminal;
        event moved: dot(x) * y;
        event kept: x * y + (t * x).sin();
    }
}

/// ġ and g̈ against differences of g along a motion with given accelerations.
#[test]
fn rates_are_those_along_the_motion() {
    let mut rod = Rod::new(0.7, 2.0);
    rod.push = 0.3;
    let (at, a) = (State::new(0.4, [0.8, -1.1], [0.6, 1.3]), SVector::from([-0.9, 2.1]));
    let moved = |s: f64| State { t: at.t + s, q: at.q + at.qd * s + a * (0.5 * s * s), qd: at.qd + a * s };
    for (index, known) in [(0, 1), (1, 2), (2, 1), (3, 2)] {
        let g = |s: f64| rod.event_value(index, &moved(s));
        let rates = rod.event_rates(index, &at, &a);
        assert_eq!(rates.iter().flatten().count(), known, "{index}");
        let s = 1e-4;
        let differences = [(g(s) - g(-s)) / (2.0 * s), (g(s) - 2.0 * g(0.0) + g(-s)) / (s * s)];
        for (rate, difference) in rates.iter().zip(differences) {
            assert!(
                rate.is_none_or(|rate| (rate - difference).abs() < 1e-5),
                "{index}: {rates:?} {differences:?}"
            );
        }
    }
}

/// A particle that slides down from the top of a disc leaves it at cos = 2/3.
#[test]
fn a_reaction_that_vanishes_is_an_event() {
    let rod = Rod::new(0.7, 2.0);
    let start = State::new(0.0, [2.0 * 0.01f64.sin(), 2.0 * 0.01f64.cos()], [0.0, 0.0]);
    let run = integrate(&rod, Dop853, PiController::tolerance(1e-10), start).until(10.0);
    let left = run.events(Rod::SLACK).next().expect("it leaves").unwrap();
    assert!((left.state.q[1] / 2.0 - 0.01f64.cos() * 2.0 / 3.0).abs() < 1e-8, "{left:?}");
}

/// One constant serves a stepper, whose inputs change, a system with constants computed beforehand, and the type over
/// other numbers.
#[test]
fn steppers_and_prepared_systems_have_the_same_events() {
    let shot = Shot::new(0.5);
    let start = State::new(0.0, [0.0, 0.0], [1.0, 9.81]);
    let control = || PiController::tolerance(1e-10);
    let alone =
        integrate(&shot, Dop853, control(), start).until(10.0).events(Shot::GROUND).final_state().unwrap();
    let prepared = shot.precomputed();
    let again = integrate(&prepared, Dop853, control(), start)
        .until(10.0)
        .events(Shot::GROUND)
        .final_state()
        .unwrap();
    let mut stepper = lagrange_runtime::Stepper::new(shot, Dop853, control(), start);
    let stepped = stepper.until(10.0).events([Shot::APEX, Shot::GROUND]).last().unwrap().unwrap();
    assert_eq!(stepped.name, "ground");
    for end in [alone, again, stepped.state] {
        assert!((end.t - 2.0).abs() < 1e-12 && end.q[1].abs() < 1e-14, "{end:?}");
    }
    let closure = Event::falling(|at: &State<f64, 2>| at.q[1]).terminal();
    let end = integrate(&shot, Dop853, control(), start).until(10.0).events(closure).final_state().unwrap();
    assert!((end.t - alone.t).abs() < 1e-14);
}

lagrangian! {
    /// A particle on a sphere.
    pub system Spherical {
        param l, g = 9.81;
        coord theta: angle, phi: angle;
        T = 0.5 * l.powi(2) * (dot(theta).powi(2) + (dot(phi) * theta.sin()).powi(2));
        V = -g * l * theta.cos();
        event highest: dot(theta), falling;
        event round: phi - 6.0;
        pub routhian Swing;
    }
}

/// A reduced system has the events that do not depend on what is removed.
#[test]
fn a_reduced_system_has_its_events() {
    let whole = Spherical::new(0.5);
    let start = State::new(0.0, [1.0, 0.0], [0.5, 3.0]);
    let (swing, state): (Swing, State<f64, 1>) = whole.reduce(&start);
    let of_whole = integrate(&whole, Dop853, PiController::tolerance(1e-11), start)
        .until(3.0)
        .events(Spherical::HIGHEST);
    let of_swing =
        integrate(&swing, Dop853, PiController::tolerance(1e-11), state).until(3.0).events(Swing::HIGHEST);
    let of_whole = of_whole.map(|event| event.unwrap().state.t).collect::<Vec<f64>>();
    let of_swing = of_swing.map(|event| event.unwrap().state.t).collect::<Vec<f64>>();
    assert!(of_whole.len() > 1 && of_whole.len() == of_swing.len());
    assert!(of_whole.iter().zip(&of_swing).all(|(a, b)| (a - b).abs() < 1e-9), "{of_whole:?} {of_swing:?}");
}
