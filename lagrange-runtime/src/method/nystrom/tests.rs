//! The claims of every pair: the conditions of all Nyström trees up to the order, measured orders, estimates,
//! interpolants.

use super::*;
use crate::controller::{FixedStep, PiController};
use crate::integrate::integrate;
use crate::method::Method;
use crate::method::explicit_rk::Dop853;
use crate::scalar::{DoubleDouble, Real as _};
use crate::testing::bank::*;
use crate::testing::{distance, order_of, slope};
use nalgebra::SVector;

/// A tree of `q̈ = a(q)`: an acceleration differentiated along branches, each of which is q̇ₒ (`None`) or a tree
/// again. On the exact solution, `Φ(θ) = coefficient · θ^degree`, from `c` for each q̇₀ and `∬` for each tree
/// (Hairer, Nørsett, Wanner 1993, II.14).
struct Tree {
    branches: Vec<Option<usize>>,
    degree: u32,
    coefficient: f64,
}

/// All trees up to the given degree.
fn trees(most: u32) -> Vec<Tree> {
    fn grow(trees: &mut Vec<Tree>, branches: &mut Vec<Option<usize>>, limit: usize, left: u32, degree: u32) {
        let twice = |tree: &Tree| tree.coefficient / f64::from((tree.degree + 1) * (tree.degree + 2));
        // The rest may be leaves.
        let mut all = branches.clone();
        all.extend((0..left).map(|_| None));
        let coefficient = all.iter().flatten().map(|&b| twice(&trees[b])).product();
        trees.push(Tree { branches: all, degree, coefficient });
        for b in (0..limit).filter(|&b| trees[b].degree + 2 <= left).collect::<Vec<_>>() {
            branches.push(Some(b));
            grow(trees, branches, b + 1, left - trees[b].degree - 2, degree);
            branches.pop();
        }
    }
    let mut trees = Vec::new();
    for degree in 0..=most {
        let smaller = trees.len();
        grow(&mut trees, &mut Vec::new(), smaller, degree, degree);
    }
    trees
}

/// Φᵢ of each tree.
fn weights<T: NystromTableau<K>, const K: usize>(trees: &[Tree]) -> Vec<[f64; K]> {
    let (mut all, mut twice) = (Vec::new(), Vec::<[f64; K]>::new());
    for tree in trees {
        let phi: [f64; K] = core::array::from_fn(|i| {
            tree.branches.iter().map(|branch| branch.map_or(T::C[i], |b| twice[b][i])).product()
        });
        twice.push(core::array::from_fn(|i| (0..K).map(|j| T::A[i][j] * phi[j]).sum()));
        all.push(phi);
    }
    all
}

/// Returns whether the conditions of q and of q̇ hold up to their orders, and not beyond.
fn order_conditions_hold<T: NystromTableau<K>, const K: usize>() {
    let trees = trees(T::ORDER);
    let [mut met_q, mut met_qd] = [true; 2];
    for (tree, phi) in trees.iter().zip(weights::<T, K>(&trees)) {
        let sum = |b: &[f64; K]| (0..K).map(|i| b[i] * phi[i]).sum::<f64>();
        let once = tree.coefficient / f64::from(tree.degree + 1);
        let error_qd = sum(&T::VELOCITY) - once;
        let error_q = sum(&T::A[K - 1]) - once / f64::from(tree.degree + 2);
        for (error, order, met) in
            [(error_q, tree.degree + 2, &mut met_q), (error_qd, tree.degree + 1, &mut met_qd)]
        {
            if order <= T::ORDER {
                // Coefficients of size 49 cancel.
                assert!(error.abs() < 1e-14, "{} order {order}, {:?}: {error}", T::NAME, tree.branches);
            } else if order == T::ORDER + 1 {
                *met &= error.abs() < 1e-12;
            }
        }
    }
    assert!(!met_q && !met_qd, "{} claims less than its order", T::NAME);
}

fn nodes_are_consistent<T: NystromTableau<K>, const K: usize>() {
    for i in 0..K {
        let sum: f64 = T::A[i].iter().sum();
        assert!((sum - 0.5 * T::C[i] * T::C[i]).abs() < 1e-14, "{}: row {i}", T::NAME);
    }
    assert_eq!(T::C[K - 1], 1.0);
    assert!(T::ERROR.iter().all(|e| e.iter().sum::<f64>().abs() < 1e-15));
}

#[test]
fn every_row_is_consistent() {
    let counts: [usize; 9] =
        core::array::from_fn(|d| trees(8).iter().filter(|t| t.degree as usize == d).count());
    assert_eq!(counts, [1, 1, 2, 3, 6, 10, 20, 36, 72]);
    for_each_nystrom!(nodes_are_consistent);
    for_each_nystrom!(order_conditions_hold);
}

#[test]
fn orders_are_those_claimed() {
    let system = Plane::default();
    let measured = |six: &[u32], eight: &[u32]| {
        [
            order_of(&system, &Nystrom6, &ellipse(0.0), &ellipse(2.0), six).unwrap(),
            order_of(&system, &Nystrom8, &ellipse(0.0), &ellipse(5.0), eight).unwrap(),
        ]
    };
    let [six, eight] = measured(&[60, 75, 90], &[24, 30, 36]);
    assert!((six - 6.0).abs() < 0.1 && (eight - 8.0).abs() < 0.1, "{six} {eight}");
    // On nonlinear motions, errors of order 12 are at rounding before their order shows.
    let chain = Chain::<f64, 3> { k: 1.0 };
    let twelve = order_of(&chain, &Nystrom12, &mode(0.0), &mode(30.0), &[12, 16, 20]).unwrap();
    assert!((twelve - 12.0).abs() < 0.1, "{twelve}");
}

/// A difference of order p to the exact state is one of `O(hᵖ⁺¹)` in one step. In double-double: errors of order 12
/// are rounding in `f64`.
#[test]
fn estimates_and_interpolants_are_of_their_orders() {
    macro_rules! local {
        ($method:ident, $steps:expr) => {{
            let start = DoubleDouble::one();
            let (system, from) = (Plane::<DoubleDouble>::default(), ellipse(start));
            let memory = $method.start(&system, &from).unwrap();
            let size =
                |x: &SVector<DoubleDouble, 2>| x.iter().fold(0.0, |most: f64, x| most.max(x.to_f64().abs()));
            let parts = |h: f64| {
                let (step, _) = $method.step(&system, &memory, &from, h.into()).unwrap();
                let t = start + DoubleDouble::from(0.3 * h);
                let error = $method.interpolant(&system, &step).at(t).minus(&ellipse(t));
                [&error.q, &error.qd, &step.error.q, &step.error.qd].map(size)
            };
            [0, 1, 2, 3].map(|i| slope($steps.map(|h| (h, parts(h)[i])), 0.0))
        }};
    }
    let close = |measured: [f64; 4], expected: [f64; 4]| {
        assert!(measured.iter().zip(expected).all(|(m, e)| (m - e).abs() < 0.3), "{measured:?} {expected:?}");
    };
    close(local!(Nystrom6, [0.05, 0.07, 0.1]), [7.0, 6.0, 5.0, 5.0]);
    close(local!(Nystrom8, [0.05, 0.07, 0.1]), [9.0, 8.0, 7.0, 7.0]);
    close(local!(Nystrom12, [0.05, 0.07, 0.1]), [13.0, 12.0, 11.0, 11.0]);
}

#[test]
fn interpolants_meet_both_ends() {
    let system = Plane::default();
    macro_rules! check {
        ($($method:ident)*) => {$(
            for step in integrate(&system, $method, FixedStep::new(0.3), ELLIPSE).until(3.0) {
                let step = step.unwrap();
                let dense = $method.interpolant(&system, &step);
                assert!(distance(&dense.at(step.from.t), &step.from) < 1e-15);
                assert!(distance(&dense.at(step.to.t), &step.to) < 2e-14);
            }
        )*};
    }
    check! { Nystrom6 Nystrom8 Nystrom12 }
}

/// Forces of time alone are integrated by the weights b′ at the nodes.
#[test]
fn forces_of_time_are_met_at_the_nodes() {
    fn node<T: NystromTableau<K>, const K: usize>() {
        for power in 0..T::ORDER as i32 {
            let sum = |b: &[f64; K]| (0..K).map(|i| b[i] * T::C[i].powi(power)).sum::<f64>();
            let exact = 1.0 / f64::from(power + 1);
            assert!((sum(&T::VELOCITY) - exact).abs() < 1e-14, "{} t^{power}", T::NAME);
        }
    }
    for_each_nystrom!(node);
}

#[test]
fn tolerances_are_met_with_fewer_evaluations_than_dop853() {
    let system = Plane::default();
    macro_rules! cost {
        ($method:ident) => {{
            let mut run = integrate(&system, $method, PiController::tolerance(1e-12), ELLIPSE).until(20.0);
            run.run_to_end().unwrap();
            let error = distance(run.state(), &ellipse(20.0));
            assert!(error < 1e-9, "{} {error}", stringify!($method));
            run.statistics().evaluations
        }};
    }
    let (twelve, general) = (cost!(Nystrom12), cost!(Dop853));
    assert!(3 * twelve < 2 * general, "{twelve} {general}");
}

#[test]
fn evaluations_are_counted_as_they_are_made() {
    let system = Plane::default();
    macro_rules! counted {
        ($($method:ident $per_step:literal)*) => {$(
            let mut run = integrate(&system, $method, FixedStep::new(0.1), ELLIPSE).until(1.0);
            run.run_to_end().unwrap();
            assert_eq!(run.statistics().evaluations, 1 + 10 * $per_step);
        )*};
    }
    counted! { Nystrom6 5 Nystrom8 8 Nystrom12 17 }
}
