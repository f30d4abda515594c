// An index before the beginning of an array.
use lagrange_runtime::prelude::*;
use lagrange_runtime::SVector;

lagrangian! {
    pub system Chain {
        param m, k;
        coord x: [3];
        T = 0.5 * m * x.map(|x| dot(x).powi(2)).sum();
        V = 0.5 * k * x[-1].powi(2);
    }
}

fn main() {
    let system = Chain::new(1.0, 0.5);
    let (q, qd) = (SVector::from([0.1, 0.1, 0.1]), SVector::from([0.0, 0.0, 0.0]));
    println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
}
