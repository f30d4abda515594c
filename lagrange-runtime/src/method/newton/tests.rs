//! Claims: the reduced equations are the whole ones; and of all methods here, that no numbers make them panic, and f32.

use super::*;
use crate::integrate::integrate;
use crate::linear::Complex;
use crate::method::rosenbrock::Rodas4;
use crate::method::variational::VariationalTrapezoid;
use crate::prelude::*;
use crate::testing::bank::{DOUBLE, DoublePendulum, polar};
use crate::testing::emitted::*;

fn jacobian() -> Jacobian<f64, 2> {
    Jacobian {
        q: SMatrix::from([[-2.0, 0.3], [0.7, -1e4]]),
        qd: SMatrix::from([[-0.1, 3.0], [-3.0, -0.4]]),
        t: SVector::zeros(),
    }
}

#[test]
fn the_reduced_system_solves_the_whole_one() {
    let j = jacobian();
    let (r, s) = (SVector::from([1.0, -2.0]), SVector::from([0.5, 4.0]));
    let (x, y) = Resolvent::new(7.0, &j).unwrap().solve(&r, &s);
    // The terms are as large as 1e4 x.
    assert!((x * 7.0 - y - r).amax() < 1e-14 && (y * 7.0 - j.q * x - j.qd * y - s).amax() < 1e-11);

    let complex = |re: f64, im: f64| Complex { re, im };
    let lambda = complex(5.0, 3.0);
    let (r, s) = ([complex(1.0, 2.0), complex(-2.0, 0.1)], [complex(0.5, -1.0), complex(4.0, 0.0)]);
    let (x, y) = Resolvent::new(lambda, &j).unwrap().solve(&r.into(), &s.into());
    for i in 0..2 {
        let sum = (0..2).fold(lambda * y[i], |sum, k| {
            sum - complex(j.q[(i, k)], 0.0) * x[k] - complex(j.qd[(i, k)], 0.0) * y[k]
        });
        assert!((sum - s[i]).size() < 1e-11 && (lambda * x[i] - y[i] - r[i]).size() < 1e-14);
    }
}

#[test]
fn velocities_are_found_from_momenta() {
    let system = DoublePendulum::<f64>::default();
    let p = system.momenta(&DOUBLE.q, &DOUBLE.qd, 0.0);
    let found = velocities(&system, &DOUBLE.q, &p, 0.0, &SVector::zeros(), 0.1).unwrap();
    assert!((found - DOUBLE.qd).amax() < 1e-15);
    let zero = velocities(&system, &DOUBLE.q, &SVector::zeros(), 0.0, &DOUBLE.qd, 0.1).unwrap();
    assert!(zero.amax() < 1e-16);
}

/// Every implicit method, started and ended anywhere among extreme numbers, ends in a state or a failure.
#[test]
fn extreme_numbers_end_in_a_state_or_a_failure() {
    let values = [0.0, 1.0, -3.0, 1e-310, 1e-30, 1e16, -1e160, f64::MAX, f64::NAN, f64::INFINITY];
    let pick = |i: usize| values[i % values.len()];
    let (mut good, mut bad) = (0, 0);
    let step = if crate::long() { 1 } else { 3 };
    for i in (0..values.len().pow(3)).step_by(step) {
        let [a, b, c] = [i, i / 10, i / 100].map(pick);
        let start = State::new(0.0, [a, 1.0], [b, 0.5]);
        let (double, kepler, chain) = (TwoPendulums::new(1.0), Kepler::new(1.0), Pair::new(c));
        let pi = PiController::tolerance(1e-6);
        let outcomes = [
            integrate(&double, Radau5, pi, start).until(c).max_steps(20).final_state(),
            integrate(&kepler, Rodas4, pi, start).until(c).max_steps(20).final_state(),
            integrate(&double, Rodas5P, FixedStep::new(b), start).until(c).max_steps(5).final_state(),
            integrate(&double, VariationalMidpoint, FixedStep::new(b), start)
                .until(c)
                .max_steps(5)
                .final_state(),
            integrate(&kepler, VariationalTrapezoid, FixedStep::new(c), start)
                .until(b)
                .max_steps(5)
                .final_state(),
            integrate(&chain, MatrixExponential, FixedStep::new(b), start)
                .until(c)
                .max_steps(5)
                .final_state(),
            integrate(&kepler, Projection(Rk4), FixedStep::new(b), start).until(c).max_steps(5).final_state(),
            integrate(&double, Projection(Dop853), pi, start).until(c).max_steps(10).final_state(),
        ];
        for outcome in outcomes {
            match outcome {
                Ok(end) => good += usize::from(end.is_finite()),
                Err(_) => bad += 1,
            }
        }
    }
    assert_eq!(
        good + bad,
        8 * values.len().pow(3).div_ceil(step),
        "no run ended well in a state that is not finite"
    );
    assert!(good > 100 && bad > 100, "{good} {bad}");
}

lagrangian! {
    /// Two oscillators coupled by a damper.
    system Pair {
        param k;
        coord x, y;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = 0.5 * k * (x.powi(2) + y.powi(2));
        D = 0.5 * (dot(x) - dot(y)).powi(2);
    }
}

#[test]
fn single_precision_reaches_its_own_rounding() {
    let (kepler, pair) = (Kepler { mu: 1.0f32 }, Pair { k: 1.0f32 });
    let to_single = |x: SVector<f64, 2>| x.map(|x| x as f32);
    let (from, exact) = (polar(0.0), polar(3.0));
    let start = State { t: 0.0f32, q: to_single(from.q), qd: to_single(from.qd) };
    let near = |end: State<f32, 2>, bound: f32| {
        let error = (end.q - to_single(exact.q)).amax();
        assert!(error < bound, "{error:e}");
    };
    near(
        integrate(&kepler, Radau5, PiController::tolerance(1e-5), start).until(3.0).final_state().unwrap(),
        1e-4,
    );
    near(
        integrate(&kepler, Rodas5P, PiController::tolerance(1e-5), start).until(3.0).final_state().unwrap(),
        1e-4,
    );
    near(
        integrate(&kepler, Projection(Rk4), FixedStep::new(0.02), start).until(3.0).final_state().unwrap(),
        1e-4,
    );
    near(
        integrate(&kepler, VariationalMidpoint, FixedStep::new(0.01), start)
            .until(3.0)
            .final_state()
            .unwrap(),
        1e-3,
    );
    let alike = State::new(0.0f32, [1.0, 1.0], [0.0, 0.0]);
    let end =
        integrate(&pair, MatrixExponential, FixedStep::new(3.0), alike).until(3.0).final_state().unwrap();
    assert!((end.q[0] - 3f32.cos()).abs() < 1e-6, "{end:?}");
}
