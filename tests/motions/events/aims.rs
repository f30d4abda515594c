//! Adaptive steps that aim a little beyond the event that ends their run.

use lagrange_runtime::event::Direction;
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
    for trial in 0..if cfg!(feature = "long") { 3000 } else { 300 } {
        let pendulum = Pendulum::new(9.81 * (0.2 + random()), if trial % 3 == 0 { random() } else { 0.0 });
        let start = State::new(0.0, [3.0 * (2.0 * random() - 1.0)], [8.0 * (2.0 * random() - 1.0)]);
        // Of every fourth, a level just within the amplitude.
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
            let found = run(tolerance).events(event.terminal()).next().map(Result::unwrap);
            // What the integration has missed by, there or where it ends.
            let what = format!(
                "{trial} at {tolerance:e}: {found:?} not {exact:?}, level {level} {pendulum:?} {start:?}"
            );
            // (A level that is grazed within the tolerance may be missed by it.)
            if exact.is_some_and(|exact| exact.state.qd[0].powi(2) < 1e3 * tolerance) {
                continue;
            }
            let (Some(found), Some(exact)) = (found, exact) else {
                assert_eq!(found.is_some(), exact.is_some(), "{what}");
                continue;
            };
            // (Near a turn the time is as the root of the error.)
            let speed = exact.state.qd[0].abs();
            let error = (found.state.t - exact.state.t).abs() * speed.min(1.0) + g(&found.state).abs();
            let energy = |s: &State<f64, 1>| 0.5 * s.qd[0].powi(2);
            let change = (energy(&found.state) - energy(&exact.state)).abs();
            *worst = worst.max(error.max(change) / tolerance);
            assert!(g(&found.state).abs() < 1e-13, "{what}");
        }
    }
    println!("{worst:?}");
    assert!(worst.iter().all(|error| *error < 300.0), "{worst:?}");
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
