//! Claims: invariants to rounding, the order of the inner method, the interpolant, adaptive steps, failures.

use super::*;
use crate::controller::FixedStep;
use crate::integrate::integrate;
use crate::prelude::*;
use crate::testing::bank::{DOUBLE, polar};
use crate::testing::emitted::*;
use crate::testing::{dense_order_of, distance, energy_drift, order_of};

#[test]
fn the_order_is_that_of_the_method_inside() {
    let (system, start, exact) = (Kepler::new(1.0), polar(0.0), polar(4.0));
    let order = |order: Result<f64, _>| order.unwrap();
    let four = order(order_of(&system, &Projection(Rk4), &start, &exact, &[800, 1600, 3200]));
    let five = order(order_of(&system, &Projection(DormandPrince5), &start, &exact, &[200, 300, 400]));
    // Restoring the energy takes away the part of the error that falls slowest at these steps, so order 5 is
    // approached from above (5.11); finer ones would be at rounding.
    assert!((four - 4.0).abs() < 0.1 && five > 4.9 && five < 5.15, "{four} {five}");
    let dense = dense_order_of(&system, &Projection(Rk4), polar, 4.0, &[200, 400, 800]).unwrap();
    assert!((dense - 4.0).abs() < 0.1, "{dense}");
}

/// From rest, where the gradient of the energy in p vanishes at first, and through many turning points.
#[test]
fn a_pendulum_from_rest_converges_with_its_order() {
    let (system, start) = (Swing { g: 1.0 }, State::new(0.0, [2.0], [0.0]));
    let exact =
        integrate(&system, Dop853, PiController::tolerance(1e-14), start).until(20.0).final_state().unwrap();
    let order = order_of(&system, &Projection(Rk4), &start, &exact, &[800, 1600, 3200]).unwrap();
    assert!((order - 4.0).abs() < 0.1, "{order}");
}

fn invariants<Sys: Conservative<N, Scalar = f64>, const N: usize>(
    system: &Sys,
    at: &State<f64, N>,
) -> Vec<f64> {
    let p = system.momenta(&at.q, &at.qd, at.t);
    let ignorable = Sys::FACTS.ignorable.iter().map(|&i| p[i]);
    core::iter::once(system.energy_function(&at.q, &at.qd, at.t)).chain(ignorable).collect()
}

/// The largest relative deviation of an invariant.
fn drift<Sys: Conservative<N, Scalar = f64>, M, C, const N: usize>(
    system: &Sys,
    method: M,
    controller: C,
    start: State<f64, N>,
    end: f64,
) -> f64
where
    M: Method<Sys, N>,
    C: crate::Controller<f64, N, M::Error>,
{
    let before = invariants(system, &start);
    let mut worst = 0.0f64;
    for step in integrate(system, method, controller, start).until(end) {
        for (a, b) in invariants(system, &step.unwrap().to).iter().zip(&before) {
            worst = worst.max((a - b).abs() / b.abs());
        }
    }
    worst
}

#[test]
fn invariants_are_kept_to_rounding() {
    let times = if crate::long() { 1.0 } else { 0.25 };
    let kepler = Kepler::new(1.0);
    let drifts = [
        drift(&kepler, Projection(Rk4), FixedStep::new(0.1), polar(0.0), times * 3000.0),
        drift(&kepler, Projection(DormandPrince5), PiController::tolerance(1e-4), polar(0.0), times * 3000.0),
        drift(&TwoPendulums::new(1.0), Projection(Rk4), FixedStep::new(0.05), DOUBLE, times * 1000.0),
    ];
    assert!(drifts.iter().all(|&drift| drift < 1e-14), "{drifts:?}");
    // Without projection.
    let drifting = drift(&kepler, Rk4, FixedStep::new(0.1), polar(0.0), times * 3000.0);
    assert!(drifting > 1e-4, "{drifting}");
    // Momenta of a top are velocities times an inertia matrix of condition 20 or so.
    let top = drift(
        &Top::new(1.0, 0.5, 0.3),
        Projection(Dop853),
        PiController::tolerance(1e-6),
        TOP,
        times * 500.0,
    );
    assert!(top < 1e-13, "{top}");
    let implicit = drift(
        &TwoPendulums::new(1.0),
        Projection(Radau5),
        PiController::tolerance(1e-6),
        DOUBLE,
        times * 200.0,
    );
    assert!(implicit < 1e-14, "{implicit}");
}

/// The oscillation in units of time of 1e-9: what is scaled by the motion does not care.
#[test]
fn units_do_not_matter() {
    let slow = Swing { g: 1.0 };
    let fast = Swing { g: 1e18 };
    let state = |h: f64| State::new(0.0, [2.0], [0.5 / h]);
    let a =
        integrate(&slow, Projection(Rk4), FixedStep::new(0.2), state(1.0)).until(20.0).final_state().unwrap();
    let b = integrate(&fast, Projection(Rk4), FixedStep::new(0.2e-9), state(1e-9))
        .until(20.0e-9)
        .final_state()
        .unwrap();
    assert!((a.q - b.q).amax() < 1e-12 && (a.qd - b.qd * 1e-9).amax() < 1e-12, "{a:?} {b:?}");
}

lagrangian! {
    /// A double pendulum whose upper mass is next to nothing: while it hangs straight the inertia is nearly singular.
    system Light {
        param m;
        coord a, b;
        T = 0.5 * (m + 1) * dot(a).powi(2) + dot(a) * dot(b) * cos(a - b) + 0.5 * dot(b).powi(2);
        V = -(m + 1) * cos(a) - cos(b);
    }
}

/// Momenta of a light coordinate say little about its velocity, and it must be enough.
#[test]
fn a_nearly_singular_inertia_is_no_obstacle() {
    let (system, start) = (Light::new(1e-8), State::new(0.0, [1.0, 1.0], [0.0, 0.0]));
    let energy = |at: &State<f64, 2>| system.energy_function(&at.q, &at.qd, at.t);
    let tolerance = PiController::tolerance(1e-10);
    let mut run = integrate(&system, Projection(Dop853), tolerance, start).until(0.1);
    run.run_to_end().unwrap();
    let mut plain = integrate(&system, Dop853, tolerance, start).until(0.1);
    plain.run_to_end().unwrap();
    assert!((energy(run.state()) - energy(&start)).abs() < 1e-15);
    let [projected, alone] = [run.statistics(), plain.statistics()].map(|s| s.accepted + s.rejected);
    assert!(10 * projected < 11 * alone, "{projected} steps, without projection {alone}");
    assert!((run.state().q - plain.state().q).amax() < 1e-8);
}

/// A Lagrangian that is not quadratic in the velocity.
#[test]
fn a_relativistic_oscillator_keeps_its_energy() {
    let system = Relativistic::new(1.0, 1.0);
    let start = State::new(0.0, [0.0], [0.9]);
    let run = integrate(&system, Projection(Rk4), FixedStep::new(0.05), start).until(200.0);
    assert!(energy_drift(&system, run).unwrap() < 1e-14);
}

#[test]
fn the_interpolant_meets_both_ends() {
    let system = Kepler::new(1.0);
    let method = Projection(DormandPrince5);
    let memory = method.start(&system, &polar(0.0)).unwrap();
    let (step, _) = method.step(&system, &memory, &polar(0.0), 0.5).unwrap();
    assert!(distance(&step.to, &step.stages.to) > 1e-9, "something was corrected");
    let dense = method.interpolant(&system, &step);
    assert!(distance(&dense.at(0.0), &step.from) < 1e-15 && distance(&dense.at(0.5), &step.to) < 1e-15);
}

#[test]
fn an_equilibrium_stays_and_a_wild_step_fails() {
    let system = Swing { g: 1.0 };
    let rest = State::new(0.0, [0.0], [0.0]);
    let end =
        integrate(&system, Projection(Rk4), FixedStep::new(0.1), rest).until(1.0).final_state().unwrap();
    assert_eq!((end.q, end.qd), (rest.q, rest.qd));
    // Far above any angle that has this little energy.
    let start = State::new(0.0, [1e-3], [0.0]);
    let mut invariants = Invariants::new(&system, &start);
    let away = State::new(0.5, [core::f64::consts::PI], [0.0]);
    let failure = invariants.project(&system, &away, 0.5).unwrap_err();
    assert!(matches!(failure, Failure::InvariantLost { .. }), "{failure}");
}

lagrangian! {
    /// A free body, slender about its third axis.
    system Slender {
        param c;
        coord R: rotation;
        let hub = frame(world, [0, 0, 0], R);
        T = body(1, [1, 1, c], hub);
        V = 0;
    }
}

/// A body that is light in one direction turns as by the method inside alone, but for its energy, which is kept: its
/// spin is constant, and that of a body of inertia 1e-6 had become 8 for 3.
#[test]
fn light_directions_are_not_what_pays() {
    for c in [1.0, 1e-2, 1e-4, 1e-6, 1e-8] {
        let body = Slender::new(c);
        let start = State::new(0.0, [0.0; 3], [0.7 / 4.0, -0.4 / 4.0, 0.75]);
        for tolerance in [1e-6, 1e-9] {
            let pi = PiController::tolerance(tolerance);
            let plain = integrate(&body, Dop853, pi, start).until(20.0).final_state().unwrap();
            let kept = integrate(&body, Projection(Dop853), pi, start).until(20.0).final_state().unwrap();
            let exact = integrate(&body, Dop853, PiController::tolerance(1e-13), start).until(20.0);
            let exact = exact.final_state().unwrap();
            let energy = |at: &State<f64, 3>| body.energy_function(&at.q, &at.qd, at.t);
            let drift = (energy(&kept) - energy(&start)).abs() / energy(&start);
            assert!(drift < 1e-13, "{c:e} {tolerance:e}: {drift:e}");
            let [plain, kept] = [plain, kept].map(|end| distance(&end, &exact));
            println!("{c:e}, {tolerance:e}: energy {drift:.1e}, distance {kept:.1e}, without {plain:.1e}");
            assert!(kept < 10.0 * plain + 1e-9, "{c:e} {tolerance:e}: {kept:e}, and {plain:e} without");
        }
    }
}
