// Greek letters, and a system without parameters.
use lagrange_runtime::SVector;
use lagrange_runtime::prelude::*;

lagrangian! {
    pub system Осциллятор {
        coord φ, ψ;
        T = 0.5 * (dot(φ).powi(2) + dot(ψ).powi(2));
        V = 1 - (φ - ψ).cos();
    }
}

fn main() {
    let system = Осциллятор::new();
    let (q, qd) = (SVector::from([0.1, 0.1]), SVector::from([0.0, 0.0]));
    assert_eq!(system.accel(&q, &qd, 0.0), SVector::from([0.0, 0.0]));
    assert_eq!(system, Осциллятор::default());
}
