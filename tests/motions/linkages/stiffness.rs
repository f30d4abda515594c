//! Load that redundant joints of different stiffness share.

use crate::systems::*;
use lagrange_runtime::prelude::*;
use nalgebra::{SMatrix, SVector};

/// Four legs in a row under a load and a moment: forces √k λ against those of springs, of which a rigid slab sinks by a
/// and turns by b, `k (a + s b)` with `Σ k (a + s b) = F` and `Σ k s (a + s b) = M`.
#[test]
fn legs_share_a_load_by_their_stiffness() {
    let s = [-1.0, -0.2, 0.3, 0.9];
    for k in [[1.0; 4], [1.0, 2.0, 3.0, 4.0], [100.0, 1.0, 0.01, 30.0]] {
        for (load, moment) in [(9.0, 0.0), (0.0, 2.0), (5.0, -3.0)] {
            let slab = Slab::new(s, k, load, moment);
            let (q, qd) = (SVector::zeros(), SVector::from([0.7, 0.0, 0.0]));
            let found = slab.force(&q, &qd, 0.0);
            let moments = |p: i32| (0..4).map(|i| k[i] * s[i].powi(p)).sum::<f64>();
            let stiffness = SMatrix::<f64, 2, 2>::new(moments(0), moments(1), moments(1), moments(2));
            let sunk = stiffness.try_inverse().unwrap() * SVector::from([load, moment]);
            for i in 0..4 {
                let exact = k[i] * (sunk[0] + s[i] * sunk[1]);
                let force = k[i].sqrt() * found[i];
                assert!((force - exact).abs() < 1e-12 * (load + moment.abs()), "{k:?} {i}: {force} {exact}");
            }
            assert!(slab.accel(&q, &qd, 0.0).amax() < 1e-13);
        }
    }
}
