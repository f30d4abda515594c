// An index beyond the end of an array.
use lagrange_runtime::prelude::*;
use lagrange_runtime::SVector;

lagrangian! {
    pub system Chain {
        const N = 3;
        param m, k;
        coord x: [N];
        T = 0.5 * m * (0..N).map(|i| dot(x[i]).powi(2)).sum();
        V = 0.5 * k * (0..N).map(|i| (x[i + 1] - x[i]).powi(2)).sum();
    }
}

fn main() {
    let system = Chain::new(1.0, 0.5);
    let (q, qd) = (SVector::from([0.1, 0.1, 0.1]), SVector::from([0.0, 0.0, 0.0]));
    println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
}
