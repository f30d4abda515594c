//! Claims: order, symplecticity where M depends on q, symmetry, energy to rounding, failures.

use super::*;
use crate::controller::FixedStep;
use crate::integrate::integrate;
use crate::scalar::Dual;
use crate::testing::bank::*;
use crate::testing::{dense_order_of, distance, energy_drift, order_of, symplecticity_defect};

#[test]
fn coefficients_are_those_of_collocation() {
    fn check<T: Collocation<K>, const K: usize>() {
        // C(K): Σⱼ aᵢⱼ cⱼ^(m−1) = cᵢ^m/m, and B(2K): Σ bⱼ cⱼ^(m−1) = 1/m, which imply order 2K.
        for m in 1..=2 * K as i32 {
            let power = |j: usize| T::C[j].hi.powi(m - 1);
            let sum: f64 = (0..K).map(|j| T::B[j].hi * power(j)).sum();
            assert!((sum - 1.0 / f64::from(m)).abs() < 1e-15);
            for i in (0..K).filter(|_| m <= K as i32) {
                let sum: f64 = (0..K).map(|j| T::A[i][j].hi * power(j)).sum();
                assert!((sum - T::C[i].hi.powi(m) / f64::from(m)).abs() < 1e-15);
            }
        }
        for i in 0..K {
            for j in 0..K {
                let [over, under] = [T::RATIO[i][j], T::RATIO[j][i]];
                assert_eq!(
                    [(over.hi - 0.5) + (under.hi - 0.5), over.lo + under.lo],
                    [0.0; 2],
                    "symplectic exactly"
                );
                assert!((T::RATIO[i][j] * T::B[j] - T::A[i][j]).value().abs() < 1e-31);
            }
        }
    }
    check::<ImplicitMidpoint, 1>();
    check::<Gauss4, 2>();
    check::<Gauss6, 3>();
}

#[test]
fn orders_are_twice_the_number_of_stages() {
    let (start, exact) = (polar(0.0), polar(4.0));
    let two = order_of(&Polar::default(), &ImplicitMidpoint, &start, &exact, &[400, 800, 1600]).unwrap();
    let four = order_of(&Polar::default(), &Gauss4, &start, &exact, &[100, 200, 400]).unwrap();
    let six = order_of(&Polar::default(), &Gauss6, &start, &exact, &[48, 64, 96]).unwrap();
    assert!(
        (two - 2.0).abs() < 0.1 && (four - 4.0).abs() < 0.1 && (six - 6.0).abs() < 0.1,
        "{two} {four} {six}"
    );
    let dense = dense_order_of(&Polar::default(), &Gauss4, polar, 3.0, &[50, 100, 200]).unwrap();
    assert!((dense - 4.0).abs() < 0.15, "{dense}");
}

#[test]
fn all_are_symplectic_where_the_inertia_depends_on_q() {
    let system = DoublePendulum::<Dual<f64>>::default();
    for h in [0.01, 0.1, 0.3] {
        let defects = [
            symplecticity_defect(&system, &ImplicitMidpoint, &DOUBLE, h).unwrap(),
            symplecticity_defect(&system, &Gauss4, &DOUBLE, h).unwrap(),
            symplecticity_defect(&system, &Gauss6, &DOUBLE, h).unwrap(),
        ];
        assert!(defects.iter().all(|&defect| defect < 1e-13), "{defects:?}");
    }
}

fn returns(method: impl Method<DoublePendulum, 2> + Copy) {
    let system = DoublePendulum::default();
    let there = integrate(&system, method, FixedStep::new(0.05), DOUBLE).until(5.0).final_state().unwrap();
    let back = integrate(&system, method, FixedStep::new(-0.05), there).until(0.0).final_state().unwrap();
    assert!(distance(&DOUBLE, &back) < 1e-12, "{back:?}");
}

#[test]
fn all_are_time_symmetric() {
    returns(ImplicitMidpoint);
    returns(Gauss4);
    returns(Gauss6);
}

#[test]
fn energy_does_not_drift() {
    let system = Polar::default();
    let drift = |turns: f64| {
        let end = turns * core::f64::consts::TAU;
        energy_drift(
            &system,
            integrate(&system, ImplicitMidpoint, FixedStep::new(0.05), polar(0.0)).until(end),
        )
        .unwrap()
    };
    let turns = if crate::long() { 100.0 } else { 10.0 };
    let (short, long) = (drift(1.0), drift(turns));
    assert!(short < 2e-3 && long < 1.05 * short, "{short} {long}");
    let end = turns * core::f64::consts::TAU;
    let six = integrate(&system, Gauss6, FixedStep::new(0.02), polar(0.0)).until(end);
    let drift = energy_drift(&system, six).unwrap();
    assert!(drift < 2e-13, "{drift}");
}

#[test]
fn too_long_a_step_is_a_failure() {
    let system = Chain::<f64, 2> { k: 1e4 };
    let start = State::new(0.5, [1.0, 0.0], [0.0, 0.0]);
    let failed = integrate(&system, ImplicitMidpoint, FixedStep::new(0.5), start)
        .until(1.0)
        .final_state()
        .unwrap_err();
    assert_eq!(failed.last, start);
    match failed.failure {
        Failure::NotConverged { t, h, iterations } => {
            assert_eq!((t, h, iterations), (0.5, 0.5, MOST_ITERATIONS))
        }
        other => panic!("{other}"),
    }
    // Here the diverging iterates overflow first, which is no other failure.
    let system = Chain::<f64, 2> { k: 1e12 };
    let failed = integrate(&system, Gauss4, FixedStep::new(0.5), start).until(1.0).final_state().unwrap_err();
    assert!(
        matches!(failed.failure, Failure::NotConverged { t: 0.5, h: 0.5, iterations } if iterations < MOST_ITERATIONS),
        "{failed}"
    );
}

#[test]
fn a_singular_inertia_is_named() {
    // r = 0 has no inertia in φ, coordinate 1.
    let start = State::new(0.0, [0.0, 0.0], [0.0, 0.0]);
    let failure = ImplicitMidpoint.start(&Polar::<f64>::default(), &start).unwrap_err();
    assert_eq!(failure, Failure::SingularInertia { t: 0.0, coordinate: coordinate(1, ""), with: None });
    let massless = Pendulum { m: 0.0, l: 1.0, g: 1.0 };
    let start = State::new(2.0, [1.0], [0.0]);
    let failure = crate::Verlet.start(&massless, &start).unwrap_err();
    assert_eq!(failure, Failure::SingularInertia { t: 2.0, coordinate: coordinate(0, ""), with: None });
}

/// Iteration counts with the extrapolated guess: what a step costs.
#[test]
fn the_guess_saves_iterations() {
    let system = Polar::default();
    let mut run = integrate(&system, Gauss4, FixedStep::new(0.05), polar(0.0)).until(10.0);
    run.run_to_end().unwrap();
    let per_step = run.statistics().evaluations as f64 / run.statistics().accepted as f64;
    assert!(per_step < 25.0, "{per_step}");
}
