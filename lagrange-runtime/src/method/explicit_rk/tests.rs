//! The claims of every row: consistency, the order conditions of all rooted trees up to order 5, and measured orders.

use super::*;
use crate::controller::FixedStep;
use crate::integrate::integrate;
use crate::method::{Method, Step};
use crate::testing::bank::*;
use crate::testing::{dense_order_of, distance, order_of};

/// A rooted tree: its branches, by their indices in the list of all trees, its order ρ and its density γ (Hairer,
/// Nørsett, Wanner 1993, definition II.2.9).
struct Tree {
    branches: Vec<usize>,
    order: u32,
    gamma: f64,
}

/// All rooted trees up to the given order, smaller ones first.
fn trees(most: u32) -> Vec<Tree> {
    /// Appends the trees whose branches are `branches` and more of the first `limit` trees, `left` vertices in total.
    fn grow(trees: &mut Vec<Tree>, branches: &mut Vec<usize>, limit: usize, left: u32, order: u32) {
        if left == 0 {
            let gamma = branches.iter().map(|&b| trees[b].gamma).product::<f64>() * f64::from(order);
            trees.push(Tree { branches: branches.clone(), order, gamma });
            return;
        }
        for b in (0..limit).filter(|&b| trees[b].order <= left).collect::<Vec<_>>() {
            branches.push(b);
            grow(trees, branches, b + 1, left - trees[b].order, order);
            branches.pop();
        }
    }
    let mut trees = Vec::new();
    for order in 1..=most {
        let smaller = trees.len();
        grow(&mut trees, &mut Vec::new(), smaller, order - 1, order);
    }
    trees
}

/// `Φᵢ` of each tree: the product over the branches of `Σⱼ aᵢⱼ Φⱼ(branch)`.
fn weights<const K: usize>(a: &[[f64; K]; K], trees: &[Tree]) -> Vec<[f64; K]> {
    let mut slopes: Vec<[f64; K]> = Vec::new();
    let mut all = Vec::new();
    for tree in trees {
        let phi: [f64; K] =
            core::array::from_fn(|i| tree.branches.iter().map(|&b| slopes[b][i]).product::<f64>());
        slopes.push(core::array::from_fn(|i| (0..K).map(|j| a[i][j] * phi[j]).sum()));
        all.push(phi);
    }
    all
}

/// `Σᵢ bᵢ Φᵢ γ`, which is 1 for all trees up to the order of the weights b.
fn elementary<const K: usize>(b: &[f64; K], phi: &[f64; K], tree: &Tree) -> f64 {
    (0..K).map(|i| b[i] * phi[i]).sum::<f64>() * tree.gamma
}

#[test]
fn there_are_as_many_trees_as_cayley_counted() {
    let trees = trees(10);
    let counts: [usize; 10] =
        core::array::from_fn(|i| trees.iter().filter(|tree| tree.order as usize == i + 1).count());
    assert_eq!(counts, [1, 1, 2, 4, 9, 20, 48, 115, 286, 719]);
}

fn rows_sum_to_the_nodes<T: ButcherTableau<K>, const K: usize>() {
    for i in 0..K {
        let sum: f64 = T::A[i].iter().sum();
        assert!((sum - T::C[i]).abs() < 2e-14, "{}: row {i} sums to {sum}, not {}", T::NAME, T::C[i]);
    }
    assert_eq!(T::C[K - 1], 1.0);
}

/// Coefficients are doubles of size up to 36 that cancel in the conditions, whence the tolerance.
fn order_conditions_hold<T: ButcherTableau<K>, const K: usize>() {
    let trees = trees(T::ORDER + 1);
    let mut met = true;
    for (tree, phi) in trees.iter().zip(weights(&T::A, &trees)) {
        let value = elementary(&T::A[K - 1], &phi, tree);
        if tree.order <= T::ORDER {
            let error = (value - 1.0).abs() / tree.gamma;
            assert!(error < 2e-14, "{}: {:?} of order {} gives {value}", T::NAME, tree.branches, tree.order);
        } else {
            met &= (value - 1.0).abs() < 1e-6;
        }
    }
    assert!(!met, "{} claims less than its order", T::NAME);
}

/// One step by loops over the table.
fn by_the_table<T: ButcherTableau<K>, const K: usize>(h: f64) -> State<f64, 2> {
    let mut k = [Tangent::zero(); K];
    let mut to = DOUBLE;
    for i in 0..K {
        let increment = (0..K).fold(Tangent::zero(), |sum, j| sum.plus_scaled(T::A[i][j], &k[j]));
        to = DOUBLE.moved(DOUBLE.t + T::C[i] * h, h, &increment);
        k[i] = Tangent { q: to.qd, qd: DoublePendulum::default().accel(&to.q, &to.qd, to.t) };
    }
    to
}

fn steps_are_those_of_the_table<T, const K: usize>()
where
    T: ButcherTableau<K> + Method<DoublePendulum, 2> + Default,
{
    let (system, method) = (DoublePendulum::default(), T::default());
    let memory = method.start(&system, &DOUBLE).unwrap();
    let to = method.step(&system, &memory, &DOUBLE, 0.3).unwrap().0.to;
    assert!(distance(&to, &by_the_table::<T, K>(0.3)) < 2e-15, "{}", T::NAME);
}

#[test]
fn every_row_is_consistent() {
    for_each_tableau!(rows_sum_to_the_nodes);
    for_each_tableau!(order_conditions_hold);
    for_each_tableau!(steps_are_those_of_the_table);
}

/// Interpolants of unit stages are the weights `bᵢ(θ)`; these satisfy `Σ bᵢ(θ) Φᵢ γ = θ^ρ` up to their order.
#[test]
fn interpolants_of_pairs_of_order_five_are_of_order_four() {
    macro_rules! check {
        ($method:ident) => {
            let trees = trees(4);
            for theta in [0.1, 0.35, 0.5, 0.8, 1.0] {
                let at: [f64; 7] = core::array::from_fn(|i| {
                    let mut stages = [Tangent::<f64, 1>::zero(); 7];
                    stages[i].q[0] = 1.0;
                    let from = State::new(0.0, [0.0], [0.0]);
                    let to = State::new(1.0, [$method::A[6][i]], [0.0]);
                    let error = Tangent::zero();
                    let step = Step { from, to, h: 1.0, error, stages, evaluations: 6 };
                    Method::<Chain<f64, 1>, 1>::interpolant(&$method, &Chain { k: 1.0 }, &step).at(theta).q[0]
                });
                for (tree, phi) in trees.iter().zip(weights(&$method::A, &trees)) {
                    let value = elementary(&at, &phi, tree);
                    let expected = theta.powi(tree.order as i32);
                    assert!((value - expected).abs() < 1e-13, "{:?} at {theta}", tree.branches);
                }
            }
        };
    }
    check!(DormandPrince5);
    check!(Tsitouras5);
}

/// The embedded formula is of the lower order, and of no higher one: what the estimate behaves like.
#[test]
fn error_estimates_are_of_their_orders() {
    macro_rules! measured {
        ($method:ident, $h:expr) => {{
            let system = Plane::default();
            let memory = $method.start(&system, &ELLIPSE).unwrap();
            crate::testing::slope(
                $h.map(|h| {
                    let (step, _) = $method.step(&system, &memory, &ELLIPSE, h).unwrap();
                    (h, step.error.q.norm() + step.error.qd.norm())
                }),
                1e-15,
            )
        }};
    }
    let (five, tsitouras) =
        (measured!(DormandPrince5, [0.04, 0.02, 0.01]), measured!(Tsitouras5, [0.04, 0.02, 0.01]));
    let nine = measured!(Verner9, [0.3, 0.25, 0.2]);
    assert!((five - 5.0).abs() < 0.2 && (tsitouras - 5.0).abs() < 0.2, "{five} {tsitouras}");
    assert!((nine - 9.0).abs() < 0.5, "{nine}");
}

/// Each on a motion with a closed form on which its asymptotic regime lies well above rounding.
#[test]
fn orders_on_nonlinear_motions() {
    let turn = core::f64::consts::TAU;
    let euler =
        order_of(&Polar::default(), &Euler, &polar(0.0), &polar(turn), &[40000, 80000, 160000]).unwrap();
    assert!((euler - 1.0).abs() < 0.1, "Euler {euler}");
    let rk4 = order_of(&Polar::default(), &Rk4, &polar(0.0), &polar(turn), &[800, 1600, 3200]).unwrap();
    assert!((rk4 - 4.0).abs() < 0.1, "Rk4 {rk4}");
    let swing = |t: f64| State::new(t, [1.5], [0.0]);
    let (start, exact) = (swing(0.0), swing(pendulum_period(1.5)));
    let five = order_of(&Pendulum::default(), &DormandPrince5, &start, &exact, &[100, 200, 400]).unwrap();
    assert!((five - 5.0).abs() < 0.1, "DormandPrince5 {five}");
    let circle = |t: f64| State::new(t, [t.cos(), t.sin()], [-t.sin(), t.cos()]);
    let eight = order_of(&Plane::default(), &Dop853, &circle(0.0), &circle(5.0), &[10, 16, 25, 40]).unwrap();
    assert!((eight - 8.0).abs() < 0.1, "Dop853 {eight}");
    let two = order_of(&Polar::default(), &Heun, &polar(0.0), &polar(turn), &[4000, 8000, 16000]).unwrap();
    assert!((two - 2.0).abs() < 0.1, "Heun {two}");
    let five =
        order_of(&Plane::default(), &Tsitouras5, &ellipse(0.0), &ellipse(9.5), &[300, 600, 1200]).unwrap();
    assert!((five - 5.0).abs() < 0.1, "Tsitouras5 {five}");
    // Its terms of order 9 are so small that those of order 10 rule all but the largest steps above rounding.
    let nine = order_of(&Plane::default(), &Verner9, &ellipse(0.0), &ellipse(9.5), &[38, 49, 60]).unwrap();
    assert!((nine - 9.0).abs() < 0.1, "Verner9 {nine}");
}

/// An interpolant of order p* has a local error of O(h^(p*+1)), which is what one sees as long as the method itself is
/// of that order.
#[test]
fn orders_of_interpolants() {
    let end = 4.0;
    let five = dense_order_of(&Plane::default(), &DormandPrince5, ellipse, end, &[100, 200, 400]).unwrap();
    assert!((five - 5.0).abs() < 0.15, "DormandPrince5 {five}");
    let eight = dense_order_of(&Plane::default(), &Dop853, ellipse, end, &[32, 40, 50]).unwrap();
    assert!((eight - 8.0).abs() < 0.15, "Dop853 {eight}");
    let five = dense_order_of(&Plane::default(), &Tsitouras5, ellipse, end, &[100, 200, 400]).unwrap();
    assert!((five - 5.0).abs() < 0.15, "Tsitouras5 {five}");
    // Over many steps, Verner's terms of order 9 are too small to be seen; in one step they are not.
    let from = ellipse(1.0);
    let memory = Verner9.start(&Plane::default(), &from).unwrap();
    let worst = |h: f64| {
        let (step, _) = Verner9.step(&Plane::default(), &memory, &from, h).unwrap();
        let dense = Verner9.interpolant(&Plane::default(), &step);
        [0.25, 0.5, 0.75]
            .map(|x| distance(&dense.at(1.0 + x * h), &ellipse(1.0 + x * h)))
            .into_iter()
            .fold(0.0, f64::max)
    };
    let nine = crate::testing::slope([0.15, 0.2, 0.3, 0.4, 0.5].map(|h| (h, worst(h))), 0.0);
    assert!((8.9..9.4).contains(&nine), "Verner9 {nine}");
    let four = dense_order_of(&Plane::default(), &Rk4, ellipse, end, &[100, 200, 400]).unwrap();
    assert!((four - 4.0).abs() < 0.15, "Rk4 {four}");
}

#[test]
fn interpolants_meet_both_ends() {
    let system = Plane::default();
    macro_rules! check {
        ($($method:ident)*) => {$(
            for step in integrate(&system, $method, FixedStep::new(0.3), ELLIPSE).until(3.0) {
                let step = step.unwrap();
                let dense = $method.interpolant(&system, &step);
                assert!(distance(&dense.at(step.from.t), &step.from) == 0.0);
                assert!(distance(&dense.at(step.to.t), &step.to) < 1e-14);
            }
        )*};
    }
    check! { Dop853 Verner9 Tsitouras5 }
}

#[test]
fn evaluations_are_counted_as_they_are_made() {
    let cost = |evaluations: u64, steps: u64, per_step: u64| assert_eq!(evaluations, 1 + steps * per_step);
    let system = Plane::default();
    macro_rules! counted {
        ($($method:ident $per_step:literal)*) => {$(
            let mut run = integrate(&system, $method, FixedStep::new(0.1), ELLIPSE).until(1.0);
            run.run_to_end().unwrap();
            cost(run.statistics().evaluations, 10, $per_step);
        )*};
    }
    counted! { Euler 1 Heun 2 Rk4 4 DormandPrince5 6 Tsitouras5 6 Dop853 12 Verner9 16 }
}

/// The interpolation error in the middle of one step on q̈ = −q, as scipy 1.17's `DOP853` has it: a check of digits
/// that a measured order would not notice.
#[test]
fn the_interpolant_of_dop853_errs_as_scipys() {
    let (system, start) = (Chain::<f64, 1> { k: 0.5 }, State::new(0.0, [1.0], [0.0]));
    for (h, error) in [(0.2, 1.974753693900766e-12), (0.4, 5.083062859512211e-10)] {
        let memory = Dop853.start(&system, &start).unwrap();
        let (step, _) = Dop853.step(&system, &memory, &start, h).unwrap();
        let middle = Dop853.interpolant(&system, &step).at(0.5 * h);
        assert!((middle.q[0] - (0.5 * h).cos() - error).abs() < 1e-15);
    }
}
/// The interpolation error of Verner's method, against that by its coefficients in arithmetic of 60 digits. The
/// coefficients of this interpolant are as large as 1500, and so is their rounding.
#[test]
fn the_interpolant_of_verner_errs_as_in_exact_arithmetic() {
    let (system, start) = (Chain::<f64, 1> { k: 0.5 }, State::new(0.0, [1.0], [0.0]));
    for (h, error) in [
        (0.4, [-8.784013321230591e-12, -7.999827523271851e-12]),
        (0.8, [-9.556869525705954e-9, -2.888903591905232e-9]),
    ] {
        let memory = Verner9.start(&system, &start).unwrap();
        let (step, _) = Verner9.step(&system, &memory, &start, h).unwrap();
        let middle = Verner9.interpolant(&system, &step).at(0.5 * h);
        assert!((middle.q[0] - (0.5 * h).cos() - error[0]).abs() < 5e-15);
        assert!((middle.qd[0] + (0.5 * h).sin() - error[1]).abs() < 5e-15);
    }
}
