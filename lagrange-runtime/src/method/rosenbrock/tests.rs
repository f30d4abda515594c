//! Claims: order conditions, measured orders with and without forces of time, L-stability, interpolants, failures.

use super::*;
use crate::controller::{ErrorEstimate, FixedStep, PiController};
use crate::integrate::integrate;
use crate::linear::lu;
use crate::prelude::*;
use crate::testing::bank::{coordinate, polar};
use crate::testing::emitted::*;
use crate::testing::{dense_order_of, distance, order_of};
use nalgebra::SMatrix;

/// The conditions for order 4 (Hairer and Wanner 1996, IV.7, table 7.1) and, of those for order 5, the ones of the tall
/// and of the bushy tree, in the α, β, b that the coefficients stand for.
fn conditions<T: RosenbrockTableau<K, D>, const K: usize, const D: usize>(order: u32) {
    let square = |m: [[DoubleDouble; K]; K]| SMatrix::<f64, K, K>::from_fn(|i, j| m[i][j].hi);
    let (a, c) = (square(T::A), square(T::C));
    // Γ = (1/γ − C)⁻¹, α = A Γ, b = m Γ.
    let factors =
        lu(&SMatrix::<f64, K, K>::from_fn(|i, j| f64::from(i == j) / T::GAMMA.hi - c[(i, j)])).unwrap();
    let mut gamma = SMatrix::<f64, K, K>::zeros();
    for j in 0..K {
        gamma.set_column(j, &factors.solve(&SVector::<f64, K>::from_fn(|i, _| f64::from(i == j))));
    }
    let alphas = a * gamma;
    let betas = alphas + gamma;
    let m = SVector::<f64, K>::from_fn(|j, _| if j == K - 1 { 1.0 } else { T::A[K - 1][j].hi });
    let b = gamma.transpose() * m;
    let one = SVector::<f64, K>::repeat(1.0);
    let (alpha, beta, sum_gamma) = (alphas * one, betas * one, gamma * one);
    let power = |n: i32| alpha.map(|x| x.powi(n));
    for i in 0..K {
        assert!(
            (alpha[i] - T::ALPHA[i].hi).abs() < 1e-13 && (sum_gamma[i] - T::D[i].hi).abs() < 1e-13,
            "row {i}"
        );
    }
    let mut conditions = vec![
        (b.dot(&one), 1.0),
        (b.dot(&beta), 0.5),
        (b.dot(&power(2)), 1.0 / 3.0),
        (b.dot(&(betas * beta)), 1.0 / 6.0),
        (b.dot(&power(3)), 0.25),
        (b.dot(&alpha.component_mul(&(alphas * beta))), 0.125),
        (b.dot(&(betas * power(2))), 1.0 / 12.0),
        (b.dot(&(betas * betas * beta)), 1.0 / 24.0),
    ];
    if order == 5 {
        conditions.push((b.dot(&power(4)), 0.2));
        conditions.push((b.dot(&(betas * betas * betas * beta)), 1.0 / 120.0));
    }
    for (i, (found, expected)) in conditions.into_iter().enumerate() {
        assert!((found - expected).abs() < 1e-13, "condition {i}: {found} instead of {expected}");
    }
    // R(∞) = 1 − bᵀβ⁻¹1 = 0: with A-stability, L-stability.
    let at_infinity = 1.0 - b.dot(&lu(&betas).unwrap().solve(&one));
    assert!(at_infinity.abs() < 1e-11, "{at_infinity}");
}

#[test]
fn order_conditions_hold() {
    conditions::<Rodas4, 6, 2>(4);
    conditions::<Rodas5P, 8, 3>(5);
}

#[test]
fn orders_are_four_and_five() {
    let (system, start, exact) = (Kepler::new(1.0), polar(0.0), polar(3.0));
    let four = order_of(&system, &Rodas4, &start, &exact, &[200, 400, 800]).unwrap();
    let five = order_of(&system, &Rodas5P, &start, &exact, &[100, 200, 400]).unwrap();
    assert!((four - 4.0).abs() < 0.1 && (five - 5.0).abs() < 0.1, "{four} {five}");
    // The interpolants are of orders 3 and 4: their local errors are O(h⁴) and O(h⁵).
    let four = dense_order_of(&system, &Rodas4, polar, 3.0, &[200, 400, 800]).unwrap();
    let five = dense_order_of(&system, &Rodas5P, polar, 3.0, &[200, 400, 800]).unwrap();
    assert!((four - 4.0).abs() < 0.1 && (five - 5.0).abs() < 0.15, "{four} {five}");
}

#[test]
fn orders_hold_with_forces_of_time() {
    let system = Driven::new(2.0, 0.5);
    let (start, exact) = (cosine(0.0), cosine(4.0));
    let four = order_of(&system, &Rodas4, &start, &exact, &[40, 80, 160]).unwrap();
    let five = order_of(&system, &Rodas5P, &start, &exact, &[100, 150, 225]).unwrap();
    assert!((four - 4.0).abs() < 0.1 && (five - 5.0).abs() < 0.1, "{four} {five}");
}

fn adaptive<M: Method<Driven, 1, Error: ErrorEstimate<f64, 1>>>(
    method: M,
    system: &Driven,
    start: State<f64, 1>,
    end: f64,
) -> (State<f64, 1>, u64) {
    let mut run = integrate(system, method, PiController::tolerance(1e-6), start).until(end);
    run.run_to_end().unwrap();
    (*run.state(), run.statistics().accepted + run.statistics().rejected)
}

/// A rate of 1e8, and a start off the slow solution: explicit steps would be 1e-8 long.
#[test]
fn stiff_decay_takes_few_steps() {
    let system = Driven::new(1e4, 0.5e8);
    let start = State::new(0.0, [1.0], [3.0]);
    let (four, few) = adaptive(Rodas4, &system, start, 10.0);
    let (five, fewer) = adaptive(Rodas5P, &system, start, 10.0);
    // q itself follows cos t only as fast as ω²/2δ = 1 lets it.
    assert!(distance(&four, &cosine(10.0)) < 1e-4 && few < 250, "{few} {four:?}");
    assert!(distance(&five, &cosine(10.0)) < 1e-4 && fewer < 150, "{fewer} {five:?}");
}

/// One step of a stiff oscillator as long as 1e6 of its periods takes all of its motion away.
#[test]
fn one_long_step_damps_what_is_stiff() {
    let system = Driven::new(1e8, 1e7);
    let start = State::new(0.0, [1.0 + 1e-3], [0.0]);
    for to in [
        Rodas4.step(&system, &(), &start, 0.01).unwrap().0.to,
        Rodas5P.step(&system, &(), &start, 0.01).unwrap().0.to,
    ] {
        assert!((to.q[0] - 0.01f64.cos()).abs() < 1e-7, "{to:?}");
    }
}

#[test]
fn derivatives_pass_through() {
    let system = Kepler { mu: Dual::variable(1.0) };
    let start = State {
        t: Dual::constant(0.0),
        q: polar(0.0).q.map(Dual::constant),
        qd: polar(0.0).qd.map(Dual::constant),
    };
    let end = |mu: f64, t: f64| {
        integrate(&Kepler::new(mu), Rodas5P, FixedStep::new(0.01), polar(0.0))
            .until(t)
            .final_state()
            .unwrap()
            .q[0]
    };
    let slope = integrate(&system, Rodas5P, FixedStep::new(Dual::constant(0.01)), start)
        .until(Dual::constant(1.0))
        .final_state()
        .unwrap()
        .q[0]
        .slope;
    let quotient = (end(1.0 + 1e-5, 1.0) - end(1.0 - 1e-5, 1.0)) / 2e-5;
    assert!((slope - quotient).abs() < 1e-8, "{slope} {quotient}");
}

#[test]
fn singular_equations_are_a_failure() {
    // 1/(γh) = −ω with C = 0: λ − K/λ = 0 for K = λ².
    let system = Repelled::new(16.0);
    let start = State::new(0.5, [1.0], [0.0]);
    let failure = Rodas4.step(&system, &(), &start, 1.0).unwrap_err();
    assert_eq!(failure, Failure::SingularStep { t: 0.5, h: 1.0, coordinate: coordinate(0, "q") });
}
