//! Mechanisms whose conditions depend on each other: everywhere, as those of a parallelogram with more cranks than it
//! needs do, or in single positions. Each is held against a twin of independent coordinates, a closed form, or an
//! orthogonal decomposition.
#![allow(clippy::excessive_precision)]

mod branches;
mod forces;
mod loads;
mod positions;
mod regular;
mod stiffness;
mod stops;
mod systems;
mod units;

use lagrange_runtime::prelude::*;
use nalgebra::{DMatrix, DVector, SVector};
use systems::*;

/// The accelerations of a state by the singular values of `B⁻¹ Aᵀ` with `M = B Bᵀ`, given `γ = (Ȧ) q̇`.
fn by_singular_values<Sys: Constrained<N, M, Scalar = f64>, const N: usize, const M: usize>(
    system: &Sys,
    at: &State<f64, N>,
    drift: SVector<f64, M>,
    rank: usize,
) -> DVector<f64> {
    let inertia = system.inertia(&at.q, &at.qd, at.t);
    let force =
        system.momentum_rate(&at.q, &at.qd, at.t) - system.convective_momentum_rate(&at.q, &at.qd, at.t);
    let a = system.constraint_jacobian(&at.q, at.t);
    let b = DMatrix::from_fn(N, N, |i, j| inertia[(i, j)]).cholesky().expect("positive definite").l();
    let half = |x: DVector<f64>| b.solve_lower_triangular(&x).expect("regular");
    let columns: Vec<DVector<f64>> = (0..M).map(|j| half(DVector::from_fn(N, |i, _| a[(j, i)]))).collect();
    let free = half(DVector::from_column_slice(force.as_slice()));
    let (mut w, mut v) = (DMatrix::from_columns(&columns), DMatrix::<f64>::identity(M, M));
    let lack = -DVector::from_column_slice(drift.as_slice()) - w.transpose() * &free;
    // One-sided rotations until the columns of W = Ã V are orthogonal (Hestenes 1958).
    for _ in 0..60 {
        for i in 0..M {
            for j in i + 1..M {
                let product = w.column(i).dot(&w.column(j));
                let [a, b] = [i, j].map(|k| w.column(k).norm_squared());
                if product.abs() <= 1e-300 {
                    continue;
                }
                let zeta = (b - a) / (2.0 * product);
                let t = 1f64.copysign(zeta) / (zeta.abs() + zeta.hypot(1.0));
                let cos = 1.0 / t.hypot(1.0);
                for m in [&mut w, &mut v] {
                    let (x, y) = (m.column(i).into_owned(), m.column(j).into_owned());
                    m.set_column(i, &((&x - &y * t) * cos));
                    m.set_column(j, &((&x * t + &y) * cos));
                }
            }
        }
    }
    let mut order: Vec<usize> = (0..M).collect();
    order.sort_by(|i, j| w.column(*j).norm().total_cmp(&w.column(*i).norm()));
    let mut x = free;
    for &k in &order[..rank] {
        x += w.column(k) * (v.column(k).dot(&lack) / w.column(k).norm_squared());
    }
    assert!(order[rank..].iter().all(|k| w.column(*k).norm() < 1e-9), "the rank is more than {rank}");
    b.transpose().solve_upper_triangular(&x).expect("regular")
}

/// The largest difference of accelerations from those by singular values, at states along a run of this many seconds.
/// (γ by dual numbers.)
macro_rules! worst {
    ($system:expr, $start:expr, $end:expr, $states:expr, $rank:expr) => {{
        let (system, start, end) = ($system, $start, $end);
        let times = (0..$states).map(|k| end * f64::from(k) / f64::from($states));
        let run = integrate(&system, Dop853, PiController::tolerance(1e-11), start).until(end);
        let mut worst = 0.0f64;
        for at in run.sample(times) {
            // Samples are as near to the constraints as the interpolant is.
            let at = consistent(&system, &at.unwrap()).unwrap();
            let moved = at.q.zip_map(&at.qd, |value, slope| Dual { value, slope });
            let rates = system.map(Dual::constant).constraint_rates(
                &moved,
                &at.qd.map(Dual::constant),
                Dual::constant(at.t),
            );
            let expected = by_singular_values(&system, &at, rates.map(|x| x.slope), $rank);
            let found = system.accel(&at.q, &at.qd, at.t);
            let off = found.iter().zip(&expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(off.is_finite(), "{at:?}");
            worst = worst.max(off / (1.0 + expected.amax()));
        }
        worst
    }};
}

/// Distance of the coordinates from those that they have at the end, by the methods for every system, at this
/// tolerance.
macro_rules! errors {
    ($system:expr, $start:expr, $end:expr, $exact:expr, $tolerance:expr) => {{
        let (system, start, exact) = ($system, $start, SVector::from($exact));
        let pi = PiController::tolerance($tolerance);
        let off = |name: &str, end: State<f64, _>| {
            let off = (end.q - exact).amax();
            println!("{name}: {off:e}");
            off
        };
        [
            off("Dop853", integrate(&system, Dop853, pi, start).until($end).final_state().unwrap()),
            off("Verner9", integrate(&system, Verner9, pi, start).until($end).final_state().unwrap()),
        ]
    }};
}

/// 10⁴ states in all.
#[test]
fn accelerations_are_those_by_singular_values() {
    let states = 2000;
    let worst = [
        worst!(
            ThreeCranks::new(),
            State::new(0.0, [1.5, 1.5, 1.5, 0.0], [0.3, 0.3, 0.3, 0.0]),
            0.55,
            states,
            3
        ),
        worst!(
            FourCranks::new(),
            State::new(0.0, [1.5, 1.5, 1.5, 1.5, 0.0], [0.3, 0.3, 0.3, 0.3, 0.0]),
            0.55,
            states,
            4
        ),
        worst!(Bennett::new(), bennett(), 2.0, states, 2),
        worst!(Sarrus::new(), sarrus(), 0.3, states, 5),
        worst!(GuidedScissors::new(), scissors(), 0.15, states, 12),
    ];
    println!("{worst:?}");
    assert!(worst.iter().all(|worst| *worst < 1e-12), "{worst:?}");
}

fn bennett() -> State<f64, 3> {
    let (angle, rate) = (2.902_325_819_385_264_1, -2.207_239_094_987_162_3);
    State::new(0.0, [0.7, angle, -angle], [6.0, rate, -rate])
}

fn sarrus() -> State<f64, 6> {
    let half = std::f64::consts::PI - 1.2;
    State::new(0.0, [1.2, half, 0.0, 1.2, half, 0.0], [-0.5, 0.5, 0.0, -0.5, 0.5, 0.0])
}

fn scissors() -> State<f64, 13> {
    let mut start = State::new(0.0, [0.4; 13], [3.0; 13]);
    (start.q[0], start.qd[0]) = (0.4f64.cos(), -3.0 * 0.4f64.sin());
    start
}

/// Facts of the compiler: numbers of constraints, their rank, and freedoms.
#[test]
fn ranks_are_found_where_the_mechanism_can_be() {
    let facts = [
        ThreeCranks::<f64>::FACTS,
        FourCranks::<f64>::FACTS,
        Bennett::<f64>::FACTS,
        Sarrus::<f64>::FACTS,
        GuidedScissors::<f64>::FACTS,
    ];
    let ranks = facts.map(|f| (f.constraints.len(), f.redundancy.unwrap().rank, f.degrees_of_freedom()));
    assert_eq!(
        ranks,
        [(4, Some(3), 1), (6, Some(4), 1), (6, Some(2), 1), (6, Some(5), 1), (19, Some(12), 1)]
    );
    assert_eq!([Scissors::<f64>::FACTS, SliderCrank::<f64>::FACTS].map(|f| f.redundancy), [None; 2]);
    // In Sarrus's linkage the turn about the line follows from the turns across.
    assert_eq!(facts[3].redundancy.unwrap().superfluous, [["attitude[2]"]]);
}

/// Times at which a coordinate is somewhere: quadratures of the energy of the one freedom, by mpmath with 30 digits.
#[test]
fn motions_meet_the_digits_of_a_quadrature() {
    let end = 5.123_661_826_092_932_6;
    let off = errors!(Bennett::new(), bennett(), 2.036_186_310_558_944_1, [9.0, -end, end], 1e-11);
    assert!(off.iter().all(|off| *off < 1e-8), "{off:?}");
    let half = std::f64::consts::PI - 0.3;
    let off =
        errors!(Sarrus::new(), sarrus(), 0.317_671_145_981_777_57, [0.3, half, 0.0, 0.3, half, 0.0], 1e-11);
    assert!(off.iter().all(|off| *off < 1e-9), "{off:?}");
    let mut exact = [1.0; 13];
    exact[0] = 1f64.cos();
    let end = 0.166_690_640_324_017_93;
    let off = [
        errors!(Scissors::new(), scissors(), end, exact, 1e-11),
        errors!(GuidedScissors::new(), scissors(), end, exact, 1e-11),
    ]
    .concat();
    assert!(off.iter().all(|off| *off < 1e-9), "{off:?}");
    let rod = |phi: f64| (0.3 * phi.sin() / 0.8f64).asin();
    let start = State::new(0.0, [0.5, rod(0.5)], [7.0, 7.0 * 0.3 * 0.5f64.cos() / (0.8 * rod(0.5).cos())]);
    let off = errors!(SliderCrank::new(), start, 2.114_849_077_276_057_0, [14.5, rod(14.5)], 1e-11);
    assert!(off.iter().all(|off| *off < 1e-8), "{off:?}");
}

/// `M q̈ = f + Aᵀ λ`, and no part of λ does nothing: it is of the form A y (of least norm). The observed reaction is
/// λ. Bars in one line, where all constraints are dependent, are passed eight times; samples within those steps are
/// on the motion, which is that of a pendulum, ȧ² + (5/2) g sin a. Slopes are those by the rate at the start.
#[test]
fn redundant_cranks_turn_over() {
    use lagrange_runtime::testing::reference::SimplePendulum;
    use std::f64::consts::{FRAC_PI_2, PI};
    let angle = |t: f64, rate: f64| SimplePendulum::new(1.25 * 9.81, 1.0, PI, rate).state(t).0 - FRAC_PI_2;
    let start = State::new(0.0, [FRAC_PI_2, FRAC_PI_2, FRAC_PI_2, 0.0], [-1.0, -1.0, -1.0, 0.0]);
    let system = ThreeCranks::default();
    for tolerance in [1e-7, 1e-9, 1e-11] {
        let run = integrate(&system, Dop853, PiController::tolerance(tolerance), start);
        for at in run.until(6.0).sample((0..600).map(|k| 0.01 * f64::from(k))) {
            let at = at.unwrap();
            let exact = angle(at.t, -1.0);
            let off = (at.q - SVector::from([exact, exact, exact, 0.0])).amax();
            assert!(off < 1e4 * tolerance, "{tolerance}, {off:e} at {}", at.t);
        }
    }
    let slope = 1e-5;
    let exact = (angle(3.0, -1.0 + slope) - angle(3.0, -1.0 - slope)) / (2.0 * slope);
    let one = |value: f64| Dual { value, slope: 1.0 };
    let moving = State {
        t: Dual::constant(0.0),
        q: start.q.map(Dual::constant),
        qd: SVector::from([one(-1.0), one(-1.0), one(-1.0), Dual::constant(0.0)]),
    };
    let system = system.map(Dual::constant);
    let end = integrate(&system, Verner9, PiController::tolerance(1e-9), moving)
        .until(Dual::constant(3.0))
        .final_state()
        .unwrap();
    assert!((end.q[0].slope - exact).abs() < 1e-5 * exact.abs(), "{} {exact}", end.q[0].slope);
}

/// Chains of 2 and of 12 loops turn over for a minute, through the line some eighty times:
/// `(n/2 + (n + 1)/6) ȧ² + (n + (n + 1)/2) g sin a` is their energy with equal angles, those of a pendulum.
#[test]
fn chains_of_loops_turn_over_for_a_minute() {
    use lagrange_runtime::testing::reference::SimplePendulum;
    use std::f64::consts::{FRAC_PI_2, PI};
    macro_rules! run {
        ($system:ident, $loops:literal, $coordinates:literal) => {{
            let system = $system::default();
            let (cranks, rate, tolerance) = (f64::from($loops + 1), -1.0, 1e-9);
            let loops = cranks - 1.0;
            let share = (loops + cranks / 2.0) / (loops + cranks / 3.0);
            let mut start = State::new(0.0, [0.0; $coordinates], [0.0; $coordinates]);
            for i in 0..$loops + 1 {
                (start.q[i], start.qd[i]) = (FRAC_PI_2, rate);
            }
            let end = integrate(&system, Dop853, PiController::tolerance(tolerance), start)
                .until(60.0)
                .final_state()
                .unwrap();
            let energy = (system.energy_at(&end) - system.energy_at(&start)).abs() / system.energy_at(&start);
            let exact = SimplePendulum::new(share * 9.81, 1.0, PI, rate).state(60.0).0 - FRAC_PI_2;
            let angle = (end.q[0] - exact).abs();
            println!("{} loops: energy {energy:e}, angle {angle:e}", $loops);
            assert!(energy < 1e3 * tolerance && angle < 1e5 * tolerance, "{energy:e} {angle:e}");
        }};
    }
    run!(TwoLoops, 2, 5);
    run!(TwelveLoops, 12, 25);
}

#[test]
fn multipliers_balance_and_are_of_least_norm() {
    let (system, at) = (Bennett::new(), bennett());
    let (a, lambda) = (system.constraint_jacobian(&at.q, at.t), system.multipliers(&at.q, &at.qd, at.t));
    let accelerations = system.accel(&at.q, &at.qd, at.t);
    let force =
        system.momentum_rate(&at.q, &at.qd, at.t) - system.convective_momentum_rate(&at.q, &at.qd, at.t);
    let left = system.inertia(&at.q, &at.qd, at.t) * accelerations - force - a.transpose() * lambda;
    assert!(left.amax() < 1e-12 * (1.0 + force.amax()), "{left}");
    let whole = DMatrix::from_fn(6, 3, |j, i| a[(j, i)]);
    let squares = (whole.transpose() * &whole).symmetric_eigen();
    // λ − A (AᵀA)⁺ Aᵀ λ
    let lambda = DVector::from_column_slice(lambda.as_slice());
    let mut rest = lambda.clone();
    for (k, square) in squares.eigenvalues.iter().enumerate().filter(|(_, square)| **square > 1e-9) {
        let along = &whole * squares.eigenvectors.column(k) / square.sqrt();
        rest -= &along * along.dot(&lambda);
    }
    assert!(rest.norm() < 1e-12 * lambda.norm(), "{rest} {lambda}");
    assert_eq!(system.axis_moments(&at.q, &at.qd, at.t).as_slice(), &lambda.as_slice()[3..]);
}

/// An impulse: velocities stay on the constraints, and change by what its work says.
#[test]
fn an_impulse_on_a_redundant_linkage() {
    let (system, at) = (Bennett::new(), bennett());
    let jump = system.jump(&at, &SVector::from([0.3, -0.2, 0.5]));
    assert!(system.constraint_rates(&at.q, &jump.after.qd, at.t).amax() < 1e-13);
    let gained = system.energy_at(&jump.after) - system.energy_at(&at);
    assert!((gained - jump.energy).abs() < 1e-12, "{gained} {}", jump.energy);
}

/// Numbers side by side choose their pivots each for itself; dual numbers and those of 32 digits pass through.
#[test]
fn other_numbers_pass_through() {
    use lagrange_runtime::lanes::{Fused, Lanes};
    use lagrange_runtime::scalar::DoubleDouble;
    let system = ThreeCranks::new();
    let angles = [0.4, 1.9, 2.8, 4.0];
    let alone = angles.map(|a| system.accel(&[a, a, a, 0.0].into(), &[0.7, 0.7, 0.7, 0.0].into(), 0.0));
    type Four = Lanes<4, Fused>;
    let (a, rate) = (Four::new(angles), Four::splat(0.7));
    let [zero, q, qd] =
        [[Four::splat(0.0); 4], [a, a, a, Four::splat(0.0)], [rate, rate, rate, Four::splat(0.0)]];
    let found = system.map(Four::splat).accel(&q.into(), &qd.into(), zero[0]);
    for (lane, alone) in alone.iter().enumerate() {
        let off = (0..4).map(|i| (found[i].to_array()[lane] - alone[i]).abs()).fold(0.0, f64::max);
        assert!(off < 1e-12, "{lane}: {off:e}");
    }
    // Along the motion, d/da of −g (5/4) cos a.
    let along = |x: f64| [Dual { value: x, slope: 1.0 }; 3];
    let [a, b, c] = along(0.8);
    let q = [a, b, c, Dual::constant(0.0)];
    let slopes = system.map(Dual::constant).accel(
        &q.into(),
        &[0.0; 4].map(Dual::constant).into(),
        Dual::constant(0.0),
    );
    assert!((slopes[0].slope - 9.81 * 1.25 * 0.8f64.sin()).abs() < 1e-12, "{slopes:?}");
    let wide = |x: f64| DoubleDouble::from_f64(x);
    let (half, zero) = (wide(0.5), wide(0.0));
    let found = system.map(wide).accel(&[half, half, half, zero].into(), &[zero; 4].into(), zero);
    let expected = wide(-9.81) * wide(1.25) * half.cos();
    assert!((found[0] - expected).to_f64().abs() < 1e-29, "{:e}", (found[0] - expected).to_f64());
}
