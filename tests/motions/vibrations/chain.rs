//! Chains of many masses: every frequency to twelve digits, repeated and zero ones, and exact propagation.

use crate::reference::off;
use lagrange_runtime::analysis::*;
use lagrange_runtime::prelude::*;
use std::f64::consts::PI;

lagrangian! {
    /// 200 equal masses between springs, the ends held.
    pub system Chain {
        const N = 200;
        param m, k;
        coord x: [N];
        T = (0..N).map(|i| 0.5 * m * dot(x[i]).powi(2)).sum();
        V = 0.5 * k * x[0].powi(2) + (1..N).map(|i| 0.5 * k * (x[i] - x[i - 1]).powi(2)).sum()
            + 0.5 * k * x[N - 1].powi(2);
    }
}

lagrangian! {
    /// A ring of six masses, free to turn.
    pub system Ring {
        const N = 6;
        param m, k;
        coord x: [N];
        T = (0..N).map(|i| 0.5 * m * dot(x[i]).powi(2)).sum();
        V = 0.5 * k * (x[0] - x[N - 1]).powi(2) + (1..N).map(|i| 0.5 * k * (x[i] - x[i - 1]).powi(2)).sum();
    }
}

/// Matrices of 200 × 200 on the stack want more of it than a test has.
pub fn with_stack(f: impl FnOnce() + Send + 'static) {
    std::thread::Builder::new().stack_size(1 << 28).spawn(f).unwrap().join().unwrap();
}

#[test]
#[cfg_attr(not(feature = "long"), ignore = "long")]
fn all_frequencies_of_two_hundred_masses() {
    with_stack(|| {
        let (m, k) = (0.7, 3.1);
        let small = small_vibrations(&Chain::new(m, k), &[0.0; 200]).unwrap();
        let modes = small.modes().unwrap();
        let exact = |j: usize| 2.0 * (k / m).sqrt() * (j as f64 * PI / 402.0).sin();
        let worst = (0..200).map(|j| off(modes.frequency(j), exact(j + 1))).fold(0.0, f64::max);
        assert!(worst < 1e-12, "{worst:e}");
        println!("200 frequencies: off by {worst:.1e} at most");

        let q = DVector::from_fn(200, |i, _| ((i * i) as f64).sin());
        let back = modes.deviation(&modes.normal(&q).unwrap()).unwrap();
        let off = (back - &q).amax();
        assert!(off < 2e-14, "{off:e}");
        println!("to normal coordinates and back: off by {off:.1e}");
    });
}

#[test]
fn repeated_and_zero_frequencies_of_a_ring() {
    let small = small_vibrations(&Ring::new(0.5, 2.0), &[0.3; 6]).unwrap();
    let modes = small.modes().unwrap();
    for (k, j) in [0, 1, 1, 2, 2, 3].into_iter().enumerate() {
        let exact = 2.0 * 2.0 * (f64::from(j) * PI / 6.0).sin();
        assert!((modes.frequency(k) - exact).abs() <= 1e-14 * exact, "{k}: {}", modes.frequency(k));
    }
    assert_eq!(modes.kind(0), ModeKind::Rigid);
    assert!((modes.shape(0) - DVector::from_element(6, 1.0)).amax() < 1e-14);
    let shapes = DMatrix::from_fn(6, 6, |i, k| modes.normalized(k)[i]);
    let identity = shapes.tr_mul(&(small.inertia() * &shapes));
    assert!((identity - DMatrix::identity(6, 6)).amax() < 1e-14, "orthonormal, the repeated ones too");
    // Of a pair, the first is as near to the axis of a coordinate as it can be, and the other has no part there.
    assert_eq!(modes.shape(1)[0], 1.0);
    assert!(modes.shape(2)[0].abs() < 1e-14);
    let Stability::Neutral { direction } = small.energy_criterion().unwrap() else {
        panic!("it is free to turn")
    };
    assert!((direction - DVector::from_element(6, 1.0)).amax() < 1e-14);
    assert!(modes.to_string().starts_with("rigid"));
}

/// Motions by normal modes in closed form, and by the exponential of the matrix.
#[test]
fn modal_superposition_is_exact() {
    let small = small_vibrations(&Ring::new(0.5, 2.0), &[0.0; 6]).unwrap();
    let modes = small.modes().unwrap();
    let (q, qd) = ([0.1, -0.2, 0.3, 0.0, 0.05, 0.4], [1.0, 0.0, 0.0, -0.3, 0.0, 0.2]);
    let model = LinearModel::<6>::new(&small).unwrap();
    let end = integrate(&model, MatrixExponential, FixedStep::new(7.0), State::new(0.0, q, qd))
        .until(7.0)
        .final_state()
        .unwrap();
    let [q, qd] = [q, qd].map(|x| DVector::from_column_slice(&x));
    let closed = modes.free_motion(&q, &qd, 7.0).unwrap();
    assert!((0..6).all(|i| (closed[i] - end.q[i]).abs() < 1e-13), "{closed} {}", end.q);
}

/// A system beyond the budget of symbolic derivatives is differentiated by duals.
#[test]
fn symbolic_and_dual_derivatives_agree() {
    let ring = Ring::new(0.5, 2.0);
    let (q, qd) = (SVector::from([0.1, -0.2, 0.3, 0.0, 0.05, 0.4]), SVector::from([1.0; 6]));
    let emitted = lagrange_runtime::traits::Linearize::linearize(&ring, &q, &qd, 0.0);
    let dual = lagrange_runtime::traits::dual_linearization(&ring.map(Dual::constant), &q, &qd, 0.0);
    assert_eq!(emitted, dual);
}
