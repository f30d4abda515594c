//! The claims of every row: consistency, the order conditions of all rooted trees up to order 5, and measured orders.

use super::*;
use crate::controller::Fixed;
use crate::integrate::integrate;
use crate::testing::bank::*;
use crate::testing::{dense_order_of, distance, order_of};

/// A rooted tree, by the indices of its branches in the list of all trees.
struct Tree {
    branches: &'static [usize],
    order: u32,
    gamma: f64,
}

/// All rooted trees up to order 5, with order ρ and density γ (Hairer, Nørsett, Wanner 1993, table II.2.1).
const TREES: [Tree; 17] = {
    const fn tree(branches: &'static [usize], order: u32, gamma: f64) -> Tree {
        Tree { branches, order, gamma }
    }
    [
        tree(&[], 1, 1.0),
        tree(&[0], 2, 2.0),
        tree(&[0, 0], 3, 3.0),
        tree(&[1], 3, 6.0),
        tree(&[0, 0, 0], 4, 4.0),
        tree(&[0, 1], 4, 8.0),
        tree(&[2], 4, 12.0),
        tree(&[3], 4, 24.0),
        tree(&[0, 0, 0, 0], 5, 5.0),
        tree(&[0, 0, 1], 5, 10.0),
        tree(&[0, 2], 5, 15.0),
        tree(&[0, 3], 5, 30.0),
        tree(&[1, 1], 5, 20.0),
        tree(&[4], 5, 20.0),
        tree(&[5], 5, 40.0),
        tree(&[6], 5, 60.0),
        tree(&[7], 5, 120.0),
    ]
};

/// `Φᵢ(tree)`: the product over the branches of `Σⱼ aᵢⱼ Φⱼ(branch)`.
fn weight<const K: usize>(a: &[[f64; K]; K], tree: &Tree, i: usize) -> f64 {
    tree.branches.iter().map(|&b| (0..K).map(|j| a[i][j] * weight(a, &TREES[b], j)).sum::<f64>()).product()
}

/// `Σᵢ bᵢ Φᵢ(tree) γ(tree)`, which is 1 for all trees up to the order of the weights b.
fn elementary<const K: usize>(a: &[[f64; K]; K], b: &[f64; K], tree: &Tree) -> f64 {
    (0..K).map(|i| b[i] * weight(a, tree, i)).sum::<f64>() * tree.gamma
}

fn rows_sum_to_the_nodes<T: Tableau<K>, const K: usize>() {
    for i in 0..K {
        let sum: f64 = T::A[i].iter().sum();
        assert!((sum - T::C[i]).abs() < 2e-14, "{}: row {i} sums to {sum}, not {}", T::NAME, T::C[i]);
    }
    assert_eq!(T::C[K - 1], 1.0);
}

fn order_conditions_hold<T: Tableau<K>, const K: usize>() {
    let mut met = [true; 6];
    for tree in &TREES {
        let value = elementary(&T::A, &T::A[K - 1], tree);
        if tree.order <= T::ORDER {
            assert!((value - 1.0).abs() < 2e-13, "{}: {:?} gives {value}", T::NAME, tree.branches);
        }
        met[tree.order as usize] &= (value - 1.0).abs() < 1e-10;
    }
    assert!(T::ORDER >= 5 || !met[T::ORDER as usize + 1], "{} claims less than its order", T::NAME);
}

/// One step by loops over the table.
fn by_the_table<T: Tableau<K>, const K: usize>(h: f64) -> State<f64, 2> {
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
    T: Tableau<K> + Method<DoublePendulum, 2> + Default,
{
    let (system, method) = (DoublePendulum::default(), T::default());
    let memory = method.start(&system, &DOUBLE).unwrap();
    let to = method.step(&system, &memory, &DOUBLE, 0.3).unwrap().to;
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
fn the_interpolant_of_dormand_and_prince_is_of_order_four() {
    type T = DormandPrince5;
    for theta in [0.1, 0.35, 0.5, 0.8, 1.0] {
        let weights: [f64; 7] = core::array::from_fn(|i| {
            let mut stages = [Tangent::<f64, 1>::zero(); 7];
            stages[i].q[0] = 1.0;
            let from = State::new(0.0, [0.0], [0.0]);
            let to = State::new(1.0, [T::A[6][i]], [0.0]);
            let [memory, error] = [Tangent::zero(); 2];
            let step = Step { from, to, h: 1.0, error, memory: memory.q, stages, evaluations: 6 };
            Method::<Chain<f64, 1>, 1>::dense(&T {}, &Chain { k: 1.0 }, &step).at(theta).q[0]
        });
        for tree in TREES.iter().filter(|tree| tree.order <= 4) {
            let value = elementary(&T::A, &weights, tree);
            assert!((value - theta.powi(tree.order as i32)).abs() < 1e-13, "{:?} at {theta}", tree.branches);
        }
    }
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
    let four = dense_order_of(&Plane::default(), &Rk4, ellipse, end, &[100, 200, 400]).unwrap();
    assert!((four - 4.0).abs() < 0.15, "Rk4 {four}");
}

#[test]
fn interpolants_meet_both_ends() {
    let system = Plane::default();
    for step in integrate(&system, Dop853, Fixed::new(0.3), ELLIPSE).until(3.0) {
        let step = step.unwrap();
        let dense = Dop853.dense(&system, &step);
        assert!(distance(&dense.at(step.from.t), &step.from) == 0.0);
        assert!(distance(&dense.at(step.to.t), &step.to) < 1e-14);
    }
}

#[test]
fn evaluations_are_counted_as_they_are_made() {
    let cost = |evaluations: u64, steps: u64, per_step: u64| assert_eq!(evaluations, 1 + steps * per_step);
    let system = Plane::default();
    macro_rules! counted {
        ($($method:ident $per_step:literal)*) => {$(
            let mut run = integrate(&system, $method, Fixed::new(0.1), ELLIPSE).until(1.0);
            run.run_out().unwrap();
            cost(run.statistics().evaluations, 10, $per_step);
        )*};
    }
    counted! { Euler 1 Rk4 4 DormandPrince5 6 Dop853 12 }
}

/// The interpolation error in the middle of one step on q̈ = −q, as scipy 1.17's `DOP853` has it: a check of digits that
/// a measured order would not notice.
#[test]
fn the_interpolant_of_dop853_errs_as_scipys() {
    let (system, start) = (Chain::<f64, 1> { k: 0.5 }, State::new(0.0, [1.0], [0.0]));
    for (h, error) in [(0.2, 1.974753693900766e-12), (0.4, 5.083062859512211e-10)] {
        let memory = Dop853.start(&system, &start).unwrap();
        let step = Dop853.step(&system, &memory, &start, h).unwrap();
        let middle = Dop853.dense(&system, &step).at(0.5 * h);
        assert!((middle.q[0] - (0.5 * h).cos() - error).abs() < 1e-15);
    }
}
