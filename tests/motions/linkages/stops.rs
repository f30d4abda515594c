//! Stops in, and beside, the line of a parallelogram: the state at which a run ends there is on the branch of its
//! motion, whatever stands between it and the line, and so is what goes on from it. The reference is the same motion
//! in one coordinate.

use super::*;
use lagrange_runtime::analysis::{AnalysisError, Equilibrium, StateSpace, equilibria};
use lagrange_runtime::{Controller, Method};

lagrangian! {
    /// A parallelogram of bars of three masses, with a spring at one crank, and a stop for the other one.
    system Stopped {
        param l = 0.7, base = 1.9, m1 = 1.3, m2 = 0.8, m3 = 2.1, k = 5, relaxed = 0.4, g = 9.81, stop = 0;
        coord a: angle, b: angle, c: angle;
        let x = l * cos(a) + 0.5 * base * cos(b);
        let y = l * sin(a) + 0.5 * base * sin(b);
        T = m1 * l.powi(2) / 6 * dot(a).powi(2) + m3 * l.powi(2) / 6 * dot(c).powi(2)
            + 0.5 * m2 * (dot(x).powi(2) + dot(y).powi(2)) + m2 * base.powi(2) / 24 * dot(b).powi(2);
        V = 0.5 * g * l * (m1 * sin(a) + m3 * sin(c)) + m2 * g * y + 0.5 * k * (c - relaxed).powi(2);
        constraint closed: [l * cos(a) + base * cos(b), l * sin(a) + base * sin(b)] == [base + l * cos(c), l * sin(c)];
        impulse tip at [l * cos(a), l * sin(a)];
        event stopped: a - stop, falling, terminal;
    }
}

lagrangian! {
    /// The same by one angle.
    system Crank {
        param l = 0.7, m1 = 1.3, m2 = 0.8, m3 = 2.1, k = 5, g = 9.81, stop = 0;
        coord a: angle;
        T = (m1 + m3) * l.powi(2) / 6 * dot(a).powi(2) + 0.5 * m2 * (l * dot(a)).powi(2);
        V = 0.5 * g * l * (m1 + m3) * sin(a) + m2 * g * l * sin(a) + 0.5 * k * (a - 0.4).powi(2);
        event stopped: a - stop, falling, terminal;
    }
}

/// The largest error of states at eight bounces on the stop, relative to `1 + |q̇|`.
fn bounces<M, C>(method: M, controller: C, stop: f64) -> f64
where
    M: Method<Stopped, 3>,
    C: Controller<f64, 3, M::Error>,
{
    let (linkage, crank) = (Stopped { stop, ..Stopped::new() }, Crank { stop, ..Crank::new() });
    let start = State::new(0.0, [0.5, 0.0, 0.5], [-1.0, 0.0, -1.0]);
    let mut run = integrate(&linkage, method, controller, start).until(6.0).events(Stopped::STOPPED);
    let by_angle = State::new(0.0, [0.5], [-1.0]);
    let mut twin =
        integrate(&crank, Dop853, PiController::tolerance(1e-13), by_angle).until(6.0).events(Crank::STOPPED);
    let mut worst = 0f64;
    for _ in 0..8 {
        let mut exact = twin.next().unwrap().unwrap().state;
        let met = run.next().unwrap().unwrap_or_else(|failure| panic!("{stop:e}: {failure}")).state;
        let off = [met.t - exact.t, met.q[0] - stop, met.q[1], met.q[2] - stop];
        let speed = 1.0 + exact.qd[0].abs();
        let rates = [met.qd[0] - exact.qd[0], met.qd[1], met.qd[2] - exact.qd[0]].map(|rate| rate / speed);
        worst = off.into_iter().chain(rates).fold(worst, |worst, x| worst.max(x.abs()));
        exact.qd[0] *= -0.9;
        twin.restart(exact);
        let normal = linkage.tip(&met.q, met.t, &[0.3, 1.0].into());
        run.restart(linkage.rebound(&met, &normal, 0.9).after);
    }
    worst
}

#[test]
fn runs_end_on_their_branch_beside_the_line() {
    for stop in [0.0, 1e-10, -1e-10, 1e-8, 1e-6, -1e-6, -1e-4, 1e-3, -2e-2] {
        for tolerance in [1e-7, 1e-10] {
            let error = bounces(Dop853, PiController::tolerance(tolerance), stop);
            assert!(error < 5.0 * tolerance, "Dop853 {stop:e} {tolerance:e}: {error:e}");
        }
        // (Accelerations near the line are known to some 1e-12.)
        for (tolerance, bound) in [(1e-7, 2e-7), (1e-9, 2e-9), (1e-11, 5e-10)] {
            let error = bounces(Taylor, TaylorController::tolerance(tolerance), stop);
            assert!(error < bound, "Taylor {stop:e} {tolerance:e}: {error:e}");
        }
        let error = bounces(Radau5, PiController::tolerance(1e-9), stop);
        assert!(error < 5e-9, "Radau5 {stop:e}: {error:e}");
        let error = bounces(Rk4, FixedStep::new(1e-3), stop);
        assert!(error < 1e-8, "Rk4 {stop:e}: {error:e}");
    }
}

/// A stepper takes the state at which its run has ended in the line, also with the velocity of a bounce.
#[test]
fn steppers_go_on_from_the_line() {
    let (linkage, crank) = (Stopped::new(), Crank::new());
    let start = State::new(0.0, [0.5, 0.0, 0.5], [-1.0, 0.0, -1.0]);
    for back in [1.0, -1.0] {
        let mut stepper = Stepper::new(linkage, Dop853, PiController::tolerance(1e-10), start);
        let met = stepper.until(6.0).events(Stopped::STOPPED).next().unwrap().unwrap().state;
        stepper.set_state(State { qd: met.qd * back, ..met }).unwrap();
        stepper.advance_to(met.t + 0.2).unwrap();
        let by_angle = State::new(met.t, [met.q[0]], [met.qd[0] * back]);
        let run = integrate(&crank, Dop853, PiController::tolerance(1e-12), by_angle);
        let exact = run.until(met.t + 0.2).final_state().unwrap();
        let found = stepper.state();
        let off = [found.q[0] - exact.q[0], found.q[1], found.q[2] - exact.q[0], found.qd[0] - exact.qd[0]];
        assert!(off.iter().all(|off| off.abs() < 1e-8), "{back}: {off:?}");
    }
    // (Not one that is off the constraints.)
    let mut stepper = Stepper::new(linkage, Dop853, PiController::tolerance(1e-10), start);
    let off = State::new(0.0, [0.0, 0.1, 0.0], [-1.0, 0.0, -1.0]);
    assert!(matches!(stepper.set_state(off), Err(Failure::ConstraintViolated { .. })));
}

/// Samples in steps that jump over the line, whatever stages of an interpolant come to lie near it.
#[test]
fn samples_stay_on_their_branch() {
    let linkage = Stopped { k: 0.0, stop: -9.0, ..Stopped::new() };
    for tolerance in [1e-6, 1e-9, 1e-11] {
        for i in 0..40 {
            let (a, v) = (0.3 + 0.015 * f64::from(i), -0.3 - 0.05 * f64::from(7 * i % 40));
            let start = State::new(0.0, [a, 0.0, a], [v, 0.0, v]);
            let run = integrate(&linkage, Dop853, PiController::tolerance(tolerance), start).until(1.7);
            for at in run.sample_evenly(1700) {
                let at = at.unwrap();
                let off = at.q[1].abs().max((at.q[2] - at.q[0]).abs());
                assert!(off < 50.0 * tolerance, "{tolerance:e} {a} {v}: {off:e} at {at:?}");
            }
        }
    }
}

/// Steps of one size end in the line, within rounding, or 1e-12 beside it.
#[test]
fn equal_steps_that_end_in_the_line_go_on() {
    let free = Stopped { k: 0.0, g: 0.0, stop: -9.0, ..Stopped::new() };
    for beside in [0.0, 1e-12, 1e-11, 1e-9, 1e-7] {
        for h in [1e-3, 1e-2] {
            let a = 0.5 + beside;
            let start = State::new(0.0, [a, 0.0, a], [-1.0, 0.0, -1.0]);
            let end = integrate(&free, Rk4, FixedStep::new(h), start).until(1.0).final_state().unwrap();
            let exact = [a - 1.0, 0.0, a - 1.0, -1.0, 0.0, -1.0];
            let error = (0..3).fold(0f64, |error, i| {
                error.max((end.q[i] - exact[i]).abs()).max((end.qd[i] - exact[3 + i]).abs())
            });
            assert!(error < 1e-13, "{beside:e} {h}: {error:e}");
        }
    }
}

/// Equilibria of springs that relax beside the line are told apart from it down to 1e-5; nearer ones are left out.
#[test]
fn searches_for_equilibria_pass_the_line() {
    for relaxed in [1e-2, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 0.0] {
        let linkage = Stopped { g: 0.0, relaxed, ..Stopped::new() };
        let found = equilibria(&linkage, &[-0.5; 3], &[0.5; 3], 40).unwrap();
        let parallel = |e: &&Equilibrium<3>| e.q[1].abs() < 1e-3 * relaxed;
        let found: Vec<_> = found.iter().filter(parallel).map(|e| e.q).collect();
        assert_eq!(found.len(), usize::from(relaxed > 1e-6), "{relaxed:e}: {found:?}");
        for q in found {
            assert!((q[0] - relaxed).abs().max((q[2] - relaxed).abs()) < 1e-15 / relaxed, "{relaxed:e}: {q}");
        }
        let at = State::new(0.0, [relaxed, 0.0, relaxed], [0.0; 3]);
        match StateSpace::without_inputs(&linkage, &at) {
            Ok(model) => {
                assert!(relaxed > 1e-6 && (model.a[(1, 0)] + 5.0 / MASS).abs() < 1e-8, "{relaxed:e}")
            }
            Err(AnalysisError::DependentConstraints { .. }) => assert!(relaxed <= 1e-6, "{relaxed:e}"),
            Err(error) => panic!("{relaxed:e}: {error}"),
        }
    }
}

/// (m₁ + m₃) l²/3 + m₂ l².
const MASS: f64 = 3.4 * 0.49 / 3.0 + 0.8 * 0.49;

/// A run reports a crank that is so light that its inertia is lost in rounding, and none that costs no digits: which
/// of them it is depends on the order in which accelerations are found.
#[test]
fn light_cranks_are_right_or_told() {
    let mut told = 0;
    for k in 0..20 {
        for first in [true, false] {
            let light = 10f64.powi(-k);
            let [m1, m3] = if first { [light, 1.0] } else { [1.0, light] };
            let linkage = Stopped { m1, m3, stop: -9.0, ..Stopped::new() };
            let crank = Crank { m1, m3, stop: -9.0, ..Crank::new() };
            let start = State::new(0.0, [1.1, 0.0, 1.1], [-1.0, 0.0, -1.0]);
            let by_angle = State::new(0.0, [1.1], [-1.0]);
            let exact =
                integrate(&crank, Rk4, FixedStep::new(1e-3), by_angle).until(0.3).final_state().unwrap();
            match integrate(&linkage, Rk4, FixedStep::new(1e-3), start).until(0.3).final_state() {
                Ok(end) => {
                    let error = (end.q[0] - exact.q[0]).abs().max((end.qd[0] - exact.qd[0]).abs());
                    assert!(error < 1e-6, "{first} {light:e}: {error:e}");
                }
                Err(failed) => {
                    let Failure::SingularInertia { coordinate, .. } = failed.failure else {
                        panic!("{failed}")
                    };
                    assert!(
                        light < 1e-9 && coordinate.name == if first { "a" } else { "c" },
                        "{light:e} {failed}"
                    );
                    told += 1;
                }
            }
        }
    }
    assert!((5..20).contains(&told), "{told}");
}

lagrangian! {
    /// A parallelogram with a load at a fifth of its coupler: the force in its pin grows without bound in the line.
    system Pinned {
        param breaks, m = 1, inertia = 0.1, torque = 4, g = 9.81;
        coord a: angle, b: angle, c: angle;
        let x = cos(a) + 0.2 * cos(b);
        let y = sin(a) + 0.2 * sin(b);
        T = (dot(a).powi(2) + dot(c).powi(2)) / 6 + 0.5 * m * (dot(x).powi(2) + dot(y).powi(2)) + 0.5 * inertia * dot(b).powi(2);
        V = g * (0.5 * (sin(a) + sin(c)) + m * y);
        Q[a] = torque;
        constraint pin: [cos(a) + cos(b), sin(a) + sin(b)] == [1 + cos(c), sin(c)];
        event broken: reaction(pin[0]) - breaks, rising, terminal;
    }
}

/// An event on a force that grows without bound within a step, and is finite at its ends, is told. The pin
/// passes 5 N at 0.457 s, the line 0.549 s after the start, and 300 N 1.6 ms before it.
#[test]
fn reactions_that_grow_in_the_line_are_told() {
    let start = State::new(0.0, [0.9, 0.0, 0.9], [0.0; 3]);
    let met = |breaks: f64, tolerance: f64| {
        let pinned = Pinned::new(breaks);
        let run = integrate(&pinned, Dop853, PiController::tolerance(tolerance), start).until(0.9);
        run.events(Pinned::BROKEN).next()
    };
    for tolerance in [1e-4, 1e-6, 1e-8, 1e-10] {
        let found = met(300.0, tolerance);
        assert!(matches!(found, Some(Err(Failure::EventNotFinite { .. }))), "{tolerance:e}: {found:?}");
    }
    assert!((met(5.0, 1e-6).unwrap().unwrap().state.t - 0.4570).abs() < 1e-3);
}
