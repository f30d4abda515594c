// A length that is no integer.
use lagrange_runtime::prelude::*;
use lagrange_runtime::SVector;

lagrangian! {
    pub system Chain {
        param m, k;
        coord x: [3.0];
        T = 0.5 * m * x.map(|x| dot(x).powi(2)).sum();
        V = 0.5 * k * x.map(|x| x.powi(2)).sum();
    }
}

fn main() {
    let system = Chain::new(1.0, 0.5);
    let (q, qd) = (SVector::from([0.1, 0.1, 0.1]), SVector::from([0.0, 0.0, 0.0]));
    println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
}
