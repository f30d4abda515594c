//! Claims: coefficients, order, interpolant, stiff systems in few steps, L-stability, failures.

use super::*;
use crate::controller::{Controller, FixedStep, PiController};
use crate::integrate::{Statistics, integrate};
use crate::prelude::*;
use crate::testing::bank::{coordinate, polar};
use crate::testing::emitted::*;
use crate::testing::{dense_order_of, distance, order_of};
use nalgebra::SMatrix;

const A: [[f64; 3]; 3] = [
    [(88.0 - 7.0 * SQRT6) / 360.0, (296.0 - 169.0 * SQRT6) / 1800.0, (-2.0 + 3.0 * SQRT6) / 225.0],
    [(296.0 + 169.0 * SQRT6) / 1800.0, (88.0 + 7.0 * SQRT6) / 360.0, (-2.0 - 3.0 * SQRT6) / 225.0],
    [(16.0 - SQRT6) / 36.0, (16.0 + SQRT6) / 36.0, 1.0 / 9.0],
];

#[test]
fn the_transformation_splits_the_method() {
    let square = |m: [[f64; 3]; 3]| SMatrix::<f64, 3, 3>::from_fn(|i, j| m[i][j]);
    let [t, inverse] = [T, T_INVERSE].map(|m| square(m.map(|row| row.map(|x| x.hi))));
    let ([gamma, alpha, beta], nodes) = ([GAMMA, ALPHA, BETA].map(|x| x.hi), C.map(|c| c.hi));
    let a = square(A);
    let lambda = square([[gamma, 0.0, 0.0], [0.0, alpha, -beta], [0.0, beta, alpha]]);
    assert!((t * inverse - SMatrix::<f64, 3, 3>::identity()).amax() < 1e-15);
    // T⁻¹ A⁻¹ T = Λ, written without A⁻¹.
    assert!((a * t * lambda * inverse - SMatrix::<f64, 3, 3>::identity()).amax() < 1e-14);
    // C(3): the method is collocation at its nodes, and with these of order 5.
    for (row, c) in A.iter().zip(nodes) {
        for m in 1..=3 {
            let sum: f64 = row.iter().zip(nodes).map(|(a, c)| a * c.powi(m - 1)).sum();
            assert!((sum - c.powi(m) / f64::from(m)).abs() < 1e-15);
        }
    }
    for m in 1..=5 {
        let sum: f64 = A[2].iter().zip(nodes).map(|(b, c)| b * c.powi(m - 1)).sum();
        assert!((sum - 1.0 / f64::from(m)).abs() < 1e-15);
    }
}

#[test]
fn the_order_is_five() {
    let (system, start) = (Kepler::new(1.0), polar(0.0));
    let order = order_of(&system, &Radau5, &start, &polar(3.0), &[60, 120, 240]).unwrap();
    assert!((order - 5.0).abs() < 0.1, "{order}");
    let dense = dense_order_of(&system, &Radau5, polar, 3.0, &[60, 120, 240]).unwrap();
    assert!((dense - 5.0).abs() < 0.1, "{dense}");
    // What switches are looked for in is locally of order 3 in q̇: O(h⁴).
    let errors = [0.02, 0.04].map(|h| {
        let memory = Radau5.start(&system, &start).unwrap();
        let (step, _) = Radau5.step(&system, &memory, &start, h).unwrap();
        let coarse = Radau5.coarse_interpolant(&system, &step).unwrap();
        coarse.at(0.5 * h).minus(&polar(0.5 * h)).qd.amax()
    });
    assert!(((errors[1] / errors[0]).log2() - 4.0).abs() < 0.2, "{errors:?}");
    let driven = Driven::new(2.0, 0.5);
    let order = order_of(&driven, &Radau5, &cosine(0.0), &cosine(4.0), &[20, 40, 80]).unwrap();
    assert!((order - 5.0).abs() < 0.1, "{order}");
}

#[test]
fn the_interpolant_meets_the_ends_and_its_velocity_is_its_derivative() {
    let system = Kepler::new(1.0);
    let memory = Radau5.start(&system, &polar(0.0)).unwrap();
    let (step, _) = Radau5.step(&system, &memory, &polar(0.0), 0.3).unwrap();
    let dense = Radau5.interpolant(&system, &step);
    assert!(distance(&dense.at(0.0), &step.from) < 1e-15 && distance(&dense.at(0.3), &step.to) < 1e-14);
    let (a, b) = (dense.at(0.1 - 1e-5), dense.at(0.1 + 1e-5));
    assert!(((b.q - a.q) / 2e-5 - dense.at(0.1).qd).amax() < 1e-9);
    let error = dense.at(0.15).minus(&polar(0.15));
    let at_end = step.to.minus(&polar(0.3));
    assert!(error.q.amax() < 2.0 * at_end.q.amax() && error.qd.amax() < 2.0 * at_end.qd.amax());
}

/// A step of half the size may fail in one of two lanes: it has the collocation polynomial, and the other its own bits.
#[test]
fn a_middle_that_is_not_known_is_that_of_the_collocation_polynomial() {
    let system = Kepler::new(1.0);
    let memory = Radau5.start(&system, &polar(0.0)).unwrap();
    let (step, _) = Radau5.step(&system, &memory, &polar(0.0), 0.3).unwrap();
    let [middle, end] = [0.5, 1.0].map(|theta| place(&step.stages, theta, 1.0));
    let mut half = step.stages;
    half.v[1][0] = f64::NAN;
    let unknown = place(&half, 1.0, 0.5).or(&middle);
    let found = Refined::new(&step.from, step.h, [&unknown, &end], 0);
    assert_eq!(found, Radau5.coarse_interpolant(&system, &step).unwrap());
    assert!(distance(&found.at(0.2), &step.stages.at(0.2)) < 1e-15);
}

fn adaptive(system: &Driven, start: State<f64, 1>, end: f64, tolerance: f64) -> (State<f64, 1>, Statistics) {
    let mut run = integrate(system, Radau5, PiController::tolerance(tolerance), start).until(end);
    run.run_to_end().unwrap();
    (*run.state(), run.statistics())
}

/// A rate of 1e8, and a start off the slow solution: explicit steps would be 1e-8 long.
#[test]
fn stiff_decay_takes_few_steps() {
    let system = Driven::new(1e4, 0.5e8);
    let start = State::new(0.0, [1.0], [3.0]);
    for (tolerance, steps) in [(1e-4, 100), (1e-6, 200), (1e-9, 1000)] {
        let (end, Statistics { accepted, rejected, evaluations }) = adaptive(&system, start, 10.0, tolerance);
        let error = distance(&end, &cosine(10.0));
        assert!(error < 30.0 * tolerance && accepted + rejected < steps, "{error:e} {accepted} {rejected}");
        assert!(evaluations < 20 * (accepted + rejected), "{evaluations} in {accepted} {rejected}");
    }
}

/// A pair of rates (−0.01, −1e8): on the slow one the steps grow without bound.
#[test]
fn steps_grow_as_the_slow_motion_decays() {
    let system = Driven { omega: 1e3, ..Driven::new(0.0, 0.5e8) };
    let free = Overdamped { c: 2.0 * system.delta, k: 1e6 };
    let mut run = integrate(&free, Radau5, PiController::tolerance(1e-8), State::new(0.0, [1.0], [-0.01]))
        .until(1000.0);
    run.run_to_end().unwrap();
    let error = (run.state().q[0] - (-10.0f64).exp()).abs();
    assert!(error < 1e-7 && run.statistics().accepted < 150, "{error:e} {:?}", run.statistics());
}

lagrangian! {
    system Overdamped {
        param c, k;
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = 0.5 * k * x.powi(2);
        D = 0.5 * c * dot(x).powi(2);
    }
}

/// One step over 1e6 periods of a stiff oscillator takes all of its motion away.
#[test]
fn one_long_step_damps_what_is_stiff() {
    let system = Driven::new(1e8, 1e7);
    let start = State::new(0.0, [1.0 + 1e-3], [0.0]);
    let memory = Radau5.start(&system, &start).unwrap();
    let to = Radau5.step(&system, &memory, &start, 0.01).unwrap().0.to;
    assert!((to.q[0] - 0.01f64.cos()).abs() < 1e-8, "{to:?}");
}

#[test]
fn van_der_pol_is_as_in_the_book() {
    // Hairer and Wanner 1996, IV.10: q̈ = ((1 − q²) q̇ − q)/ε with ε = 1e-6, the solution at t = 1 and 2.
    let system = VanDerPol::new(1e-6);
    let start = State::new(0.0, [2.0], [-0.66]);
    let first = State::new(1.0, [-1.86364625480813], [0.753543086543546]);
    let second = State::new(2.0, [1.706167732170456], [-0.8928097010248257]);
    let mut run = integrate(&system, Radau5, PiController::tolerance(1e-8), start).until(1.0);
    run.run_to_end().unwrap();
    assert!(distance(run.state(), &first) < 1e-6, "{:?}", run.state());
    let mut run = run.until(2.0);
    run.run_to_end().unwrap();
    assert!(distance(run.state(), &second) < 1e-6, "{:?}", run.state());
    // As many steps as a method of this order needs for the two jumps; the rejections are the controller's.
    let mut run = integrate(&system, Radau5, PiController::tolerance(1e-4), start).until(2.0);
    run.run_to_end().unwrap();
    let Statistics { accepted, rejected, evaluations } = run.statistics();
    assert!(
        accepted < 350 && rejected * 2 < accepted && evaluations < 6000,
        "{accepted} {rejected} {evaluations}"
    );
}

lagrangian! {
    /// Van der Pol's oscillator on the slow scale of time.
    system VanDerPol {
        param epsilon;
        coord q;
        T = 0.5 * dot(q).powi(2);
        V = 0.5 * q.powi(2) / epsilon;
        Q[q] = (1 - q.powi(2)) * dot(q) / epsilon;
    }
}

#[test]
fn derivatives_pass_through() {
    let system = Kepler { mu: Dual::variable(1.0) };
    let start = polar(0.0);
    let dual =
        State { t: Dual::constant(0.0), q: start.q.map(Dual::constant), qd: start.qd.map(Dual::constant) };
    let run =
        integrate(&system, Radau5, FixedStep::new(Dual::constant(0.01)), dual).until(Dual::constant(1.0));
    let slope = run.final_state().unwrap().q[0].slope;
    let end = |mu: f64| {
        integrate(&Kepler::new(mu), Radau5, FixedStep::new(0.01), start).until(1.0).final_state().unwrap().q
            [0]
    };
    let quotient = (end(1.0 + 1e-5) - end(1.0 - 1e-5)) / 2e-5;
    assert!((slope - quotient).abs() < 1e-8, "{slope} {quotient}");
}

#[test]
fn failures_say_what_happened() {
    // A collision: the inertia of φ vanishes at the start.
    let start = State::new(0.0, [0.0, 0.0], [0.0, 0.0]);
    assert_eq!(
        Radau5.start(&Kepler::new(1.0), &start),
        Err(Failure::SingularInertia { t: 0.0, coordinate: coordinate(1, "phi"), with: None })
    );
    // A step over many turns of a pendulum that falls: no convergence, or not to anything finite.
    let start = State::new(0.5, [1.0, -0.4], [3.0, -8.0]);
    let system = TwoPendulums::new(10.0);
    let memory = Radau5.start(&system, &start).unwrap();
    let failure = Radau5.step(&system, &memory, &start, 30.0).unwrap_err();
    assert!(matches!(failure, Failure::NotConverged { t: 0.5, h: 30.0, iterations: 2.. }), "{failure:?}");
    // A controller makes of it a shorter step.
    let mut pi = PiController::tolerance(1e-6).first_step(30.0);
    assert!(Controller::<f64, 2, RadauEstimate<f64, 2>>::after_failure(&mut pi).is_some());
    let mut run = integrate(&system, Radau5, pi, start).until(31.0);
    run.next().unwrap().unwrap();
    assert!(run.statistics().rejected > 0);
}

lagrangian! {
    /// A block on a rough plane, pulled by a force.
    system Pulled {
        param mu, pull;
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = -pull * x;
        Q[x] = -mu * signum(dot(x));
    }
}

/// The start is on the switch of the friction, and `signum(0)` is that of one of its sides only.
#[test]
fn a_block_slips_from_rest_or_is_held() {
    let run = |pull: f64| {
        let system = Pulled::new(0.5, pull);
        let start = State::new(0.0, [0.0], [0.0]);
        integrate(&system, Radau5, PiController::tolerance(1e-8), start).until(2.0).final_state()
    };
    for pull in [1.0, -1.0, 0.6, -0.6] {
        // x = (|F| − μ) t²/2 along the force.
        let end = run(pull).expect("slips");
        let x = (pull.abs() - 0.5) * 2.0 * pull.signum();
        assert!((end.q[0] - x).abs() < 1e-12 && (end.qd[0] - x).abs() < 1e-12, "{pull}: {end:?}");
    }
    for pull in [0.4, -0.4, 0.0] {
        assert_eq!(run(pull).unwrap_err().failure, Failure::Sliding { t: 0.0 });
    }
}

lagrangian! {
    /// A ball above a spring.
    system Bouncing {
        param k, g = 9.81;
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = g * x + 0.5 * k * max(-x, 0).powi(2);
    }
}

/// The step across the switch is as short as 1e-6, the next one as long as 0.1.
#[test]
fn the_step_after_a_very_short_one_is_not_guessed_by_it() {
    for tolerance in [1e-2, 1e-3, 1e-4, 1e-6] {
        for place in (0..60).step_by(if crate::long() { 1 } else { 4 }) {
            let system = Bouncing::new(Functions::powf(10.0, 2.0 + 0.15 * f64::from(place)));
            let start = State::new(0.0, [1.0], [0.0]);
            let end = integrate(&system, Radau5, PiController::tolerance(tolerance), start)
                .until(4.0)
                .final_state()
                .unwrap();
            let energy = system.energy(&end.q, &end.qd, 4.0);
            assert!((energy / 9.81 - 1.0).abs() < 50.0 * tolerance, "{tolerance} {place}: {energy}");
        }
    }
}
