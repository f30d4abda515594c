//! The claims of every composition: conditions, measured order, symplecticity, symmetry.

use super::*;
use crate::controller::FixedStep;
use crate::integrate::integrate;
use crate::method::Interpolant;
use crate::method::gauss::ImplicitMidpoint;
use crate::method::splitting::{PositionVerlet, Verlet};
use crate::scalar::Dual;
use crate::testing::bank::*;
use crate::testing::{dense_order_of, distance, energy_drift, order_of, slope, symplecticity_defect};

#[test]
fn sums_of_odd_powers_vanish() {
    fn check<T: Coefficients>() {
        let sum = |power: i32| T::GAMMA.iter().map(|gamma| gamma.hi.powi(power)).sum::<f64>();
        assert!((sum(1) - 1.0).abs() < 1e-15, "{}: {}", T::NAME, sum(1) - 1.0);
        for power in (3..T::ORDER as i32).step_by(2) {
            assert!(sum(power).abs() < 1e-14, "{}: power {power} gives {}", T::NAME, sum(power));
        }
        assert!(T::GAMMA.iter().eq(T::GAMMA.iter().rev()));
        assert!(sum(T::ORDER as i32 + 1).abs() > 1e-6, "{}", T::NAME);
    }
    macro_rules! each {
        ($row:ident) => {
            check::<$row>()
        };
    }
    for_each_composition!(each);
}

/// Errors over two radians of an ellipse, whose steps are as long as the row likes them.
fn order<Row: Coefficients + Default + Copy>(steps: &[u32]) -> [f64; 2] {
    let (start, exact) = (ellipse(0.0), ellipse(2.0));
    let kick = order_of(&Plane::default(), &Compose(Verlet, Row::default()), &start, &exact, steps);
    let drift = order_of(&Plane::default(), &Compose(PositionVerlet, Row::default()), &start, &exact, steps);
    [kick.unwrap(), drift.unwrap()]
}

#[test]
fn orders_are_those_claimed() {
    fn check<Row: Coefficients + Default + Copy>(steps: &[u32]) {
        for measured in order::<Row>(steps) {
            assert!((measured - f64::from(Row::ORDER)).abs() < 0.1, "{}: {measured}", Row::NAME);
        }
    }
    check::<TripleJump>(&[40, 60, 80]);
    check::<Suzuki4>(&[40, 60, 80]);
    check::<Yoshida6>(&[24, 36, 48]);
    check::<KahanLi6>(&[14, 21, 28]);
    check::<SuzukiUmeno8>(&[10, 15, 20]);
    check::<KahanLi8>(&[8, 12, 16]);
    check::<HairerLubichWanner10>(&[10, 12, 14]);
}

/// The base method is the user's choice: on (q, p), for an inertia that depends on q.
#[test]
fn the_implicit_midpoint_rule_can_be_composed() {
    let (system, start, exact) = (Polar::default(), polar(0.0), polar(2.0));
    let six = order_of(&system, &Compose(ImplicitMidpoint, KahanLi6), &start, &exact, &[20, 30, 40]).unwrap();
    assert!((six - 6.0).abs() < 0.1, "{six}");
    let dual = DoublePendulum::<Dual<f64>>::default();
    assert!(symplecticity_defect(&dual, &Compose(ImplicitMidpoint, Suzuki4), &DOUBLE, 0.2).unwrap() < 1e-14);
}

#[test]
fn compositions_of_symplectic_methods_are_symplectic() {
    let system = HenonHeiles::<Dual<f64>>::default();
    let at = State::new(0.0, [0.3, -0.1], [0.2, 0.4]);
    macro_rules! check {
        ($row:ident) => {
            for h in [0.01, 0.1, 0.4] {
                let defects = [
                    symplecticity_defect(&system, &Compose(Verlet, $row), &at, h).unwrap(),
                    symplecticity_defect(&system, &Compose(PositionVerlet, $row), &at, h).unwrap(),
                ];
                assert!(defects.iter().all(|&defect| defect < 2e-14), "{} {defects:?}", $row::NAME);
            }
        };
    }
    for_each_composition!(check);
}

#[test]
fn compositions_of_symmetric_methods_are_symmetric() {
    let (system, start) = (HenonHeiles::default(), State::new(0.0, [0.3, -0.1], [0.2, 0.4]));
    macro_rules! check {
        ($row:ident) => {
            let method = Compose(Verlet, $row);
            let there =
                integrate(&system, method, FixedStep::new(0.2), start).until(10.0).final_state().unwrap();
            let back =
                integrate(&system, method, FixedStep::new(-0.2), there).until(0.0).final_state().unwrap();
            assert!(distance(&start, &back) < 1e-13, "{} {back:?}", $row::NAME);
        };
    }
    for_each_composition!(check);
}

#[test]
fn energy_is_kept_for_long() {
    let system = Plane::default();
    let drift = |turns: f64| {
        let method = Compose(Verlet, KahanLi8);
        let run =
            integrate(&system, method, FixedStep::new(0.3), ELLIPSE).until(turns * core::f64::consts::TAU);
        energy_drift(&system, run).unwrap()
    };
    let (short, long) = (drift(2.0), drift(500.0));
    assert!(short < 1e-6 && long < 1.2 * short, "{short} {long}");
}

/// A composition pays: the better rows beat the first ones of their order at equal cost.
#[test]
fn rows_said_to_be_better_are_better() {
    fn error<Row: Coefficients + Default>(evaluations: usize) -> f64 {
        let h = 4.0 * Row::GAMMA.len() as f64 / evaluations as f64;
        let method = Compose(Verlet, Row::default());
        let end = integrate(&Plane::default(), method, FixedStep::new(h), ELLIPSE)
            .until(4.0)
            .final_state()
            .unwrap();
        distance(&end, &ellipse(4.0))
    }
    assert!(error::<Suzuki4>(480) < 0.2 * error::<TripleJump>(480));
    assert!(error::<KahanLi6>(630) < 0.7 * error::<Yoshida6>(630));
    assert!(error::<KahanLi8>(510) < 0.5 * error::<SuzukiUmeno8>(510));
}

#[test]
fn interpolants_are_of_the_order_documented() {
    // q and q̇ at 0.3 of one step.
    fn local<Sys: System<2, Scalar = f64>, B: Method<Sys, 2, Error = NoEstimate> + Symmetric>(
        system: &Sys,
        base: B,
        exact: impl Fn(f64) -> State<f64, 2>,
        steps: [f64; 3],
    ) -> [f64; 2] {
        let (method, from) = (Compose(base, HairerLubichWanner10), exact(1.0));
        let memory = method.start(system, &from).unwrap();
        let errors = |h: f64| {
            let (step, _) = method.step(system, &memory, &from, h).unwrap();
            let error = method.interpolant(system, &step).at(1.0 + 0.3 * h).minus(&exact(1.0 + 0.3 * h));
            [error.q.norm(), error.qd.norm()]
        };
        [0, 1].map(|i| slope(steps.map(|h| (h, errors(h)[i])), 0.0))
    }
    let [q, qd] = local(&Plane::default(), Verlet, ellipse, [0.15, 0.2, 0.25]);
    assert!((q - 10.0).abs() < 0.5 && (qd - 9.0).abs() < 0.5, "{q} {qd}");
    let [q, qd] = local(&Polar::default(), ImplicitMidpoint, polar, [0.06, 0.08, 0.1]);
    assert!((q - 8.0).abs() < 0.4 && (qd - 7.0).abs() < 0.4, "{q} {qd}");
    let method = Compose(Verlet, Suzuki4);
    let four = dense_order_of(&Plane::default(), &method, ellipse, 4.0, &[60, 80, 100]).unwrap();
    assert!((four - 4.0).abs() < 0.1, "{four}");
}

#[test]
fn evaluations_are_counted() {
    let system = Plane::default();
    let mut run = integrate(&system, Compose(Verlet, KahanLi8), FixedStep::new(0.1), ELLIPSE).until(1.0);
    run.run_to_end().unwrap();
    assert_eq!(run.statistics().evaluations, 1 + 10 * 17);
}
