//! Systems of many coordinates: what is emitted in another way for them gives the same numbers.

use approx::assert_relative_eq;
use lagrange_runtime::prelude::*;
use lagrange_runtime::traits::LegendreTransform;

/// The positions of a chain that is not written with `let`, so that nothing is left to eliminate but M.
macro_rules! without_names {
    ($name:ident, $n:literal) => {
        lagrangian! {
            system $name {
                const N = $n;
                coord theta: [N];
                T = (0..N).map(|i| 0.5 * ((0..i + 1).map(|j| theta[j].cos() * dot(theta[j])).sum().powi(2)
                    + (0..i + 1).map(|j| theta[j].sin() * dot(theta[j])).sum().powi(2))).sum();
                V = (0..N).map(|i| (0..i + 1).map(|j| -9.81 * theta[j].cos()).sum()).sum();
            }
        }
    };
}

without_names!(Twelve, 12);
without_names!(TwentyFour, 24);

lagrangian! {
    system Links {
        const N = 24;
        coord theta: [N];
        let x: [N] = |i| if i == 0 { 0 } else { x[i - 1] } + theta[i].sin();
        let y: [N] = |i| if i == 0 { 0 } else { y[i - 1] } - theta[i].cos();
        T = (0..N).map(|i| 0.5 * (dot(x[i]).powi(2) + dot(y[i]).powi(2))).sum();
        V = (0..N).map(|i| 9.81 * y[i]).sum();
    }
}

/// M of point masses on a chain: M_ij = (n − max(i, j)) cos(θᵢ − θⱼ).
fn inertia<const N: usize>(q: &SVector<f64, N>) -> SMatrix<f64, N, N> {
    SMatrix::from_fn(|i, j| (N - i.max(j)) as f64 * (q[i] - q[j]).cos())
}

/// f − b: −Σ M'_ij θ̇ⱼ² − (n − i) g sin θᵢ.
fn right<const N: usize>(q: &SVector<f64, N>, qd: &SVector<f64, N>) -> SVector<f64, N> {
    SVector::from_fn(|i, _| {
        let sum: f64 = (0..N).map(|j| (N - i.max(j)) as f64 * (q[i] - q[j]).sin() * qd[j] * qd[j]).sum();
        -sum - (N - i) as f64 * 9.81 * q[i].sin()
    })
}

fn state<const N: usize>() -> (SVector<f64, N>, SVector<f64, N>) {
    (SVector::from_fn(|i, _| (1.7 * i as f64).sin() * 2.0), SVector::from_fn(|i, _| (0.6 * i as f64).cos()))
}

fn agrees<const N: usize>(system: &(impl LegendreTransform<N> + System<N, Scalar = f64>)) {
    let (q, qd) = state::<N>();
    let m = inertia(&q);
    assert_relative_eq!(system.inertia(&q, &qd, 0.0), m, max_relative = 1e-14, epsilon = 1e-13);
    let residual = m * system.accel(&q, &qd, 0.0) - right(&q, &qd);
    assert!(residual.norm() < 1e-12 * right(&q, &qd).norm(), "{residual}");
    let velocities = system.velocities(&q, &(m * qd), 0.0);
    assert!((velocities - qd).norm() < 1e-11 * qd.norm(), "{velocities}");
}

#[test]
fn straight_lines_loops_and_links_agree() {
    agrees(&Twelve::<f64>::new());
    agrees(&TwentyFour::<f64>::new());
    agrees(&Links::<f64>::new());
    const { assert!(<TwentyFour as Lagrangian<24>>::FACTS.operations.arithmetic() > 5000) };
    const { assert!(<Links as Lagrangian<24>>::FACTS.operations.arithmetic() < 500) };
}

lagrangian! {
    system Weighted {
        const N = 4;
        param m: [N];
        coord theta: [N];
        let x: [N] = |i| if i == 0 { 0 } else { x[i - 1] } + theta[i].sin();
        let y: [N] = |i| if i == 0 { 0 } else { y[i - 1] } - theta[i].cos();
        T = (0..N).map(|i| 0.5 * m[i] * (dot(x[i]).powi(2) + dot(y[i]).powi(2))).sum();
        V = (0..N).map(|i| 9.81 * m[i] * y[i]).sum();
    }
}

/// The links are eliminated by way of the reciprocals of their masses, which are taken to be positive.
#[test]
fn a_link_without_mass_is_a_failure() {
    let start = State::new(0.0, [0.3, 0.2, 0.1, 0.4], [0.0; 4]);
    let of = |m| {
        let system = Weighted::new(m);
        let run = integrate(&system, Dop853, PiController::tolerance(1e-9), start).until(1.0).final_state();
        run.map_err(|failed| failed.failure)
    };
    assert!(of([1.0; 4]).is_ok());
    assert!(of([1.0, 1e-3, 1.0, 1.0]).is_ok());
    let failure = of([1.0, 0.0, 1.0, 1.0]).unwrap_err();
    assert!(matches!(failure, Failure::NonFinite { t: 0.0, h: 0.0 }), "{failure}");
}
