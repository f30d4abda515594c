// An element of a family that uses the one after it.
use lagrange_runtime::prelude::*;
use lagrange_runtime::SVector;

lagrangian! {
    pub system Chain {
        const N = 3;
        param m, l, g = 9.81;
        coord theta: [N];
        let y: [N] = |i| if i + 1 < N { y[i + 1] } else { 0.0 } - l * theta[i].cos();
        T = 0.5 * m * (0..N).map(|i| (l * dot(theta[i])).powi(2)).sum();
        V = m * g * y.sum();
    }
}

fn main() {
    let system = Chain::new(1.0, 0.5);
    let (q, qd) = (SVector::from([0.1, 0.1, 0.1]), SVector::from([0.0, 0.0, 0.0]));
    println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
}
