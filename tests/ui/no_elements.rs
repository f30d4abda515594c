// Arrays of no elements and of less than none.
use lagrange_runtime::prelude::*;
use lagrange_runtime::SVector;

lagrangian! {
    pub system Chain {
        const N = 0;
        param m, k: [-1];
        coord x: [N], y;
        T = 0.5 * m * dot(y).powi(2);
        V = 0.5 * k[0] * y.powi(2);
    }
}

fn main() {
    let system = Chain::new(1.0, [0.5]);
    let (q, qd) = (SVector::from([0.1]), SVector::from([0.0]));
    println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
}
