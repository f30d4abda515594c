// Greek letters that look like Latin ones, and no others, without a warning.
#![deny(warnings)]
use lagrange_runtime::SVector;
use lagrange_runtime::prelude::*;

lagrangian! {
    pub system Pendulum {
        param ρ, Ω;
        coord θ: angle, φ: angle;
        T = 0.5 * Ω * (dot(θ).powi(2) + (dot(φ) * θ.sin()).powi(2));
        V = -ρ * θ.cos();
    }
}

fn main() {
    let pendulum = Pendulum::new(1.0, 2.0);
    assert_eq!(
        pendulum.accel(&SVector::from([0.5, 0.0]), &SVector::from([0.0, 0.0]), 0.0)[0],
        -0.5 * 0.5f64.sin()
    );
}
