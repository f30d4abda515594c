// A velocity in the potential energy.
use lagrange_runtime::prelude::*;
use lagrange_runtime::SVector;

lagrangian! {
    pub system Charge {
        param m, b;
        coord x, y;
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
        V = -0.5 * b * (x * dot(y) - y * dot(x));
    }
}

fn main() {
    let system = Charge::new(1.0, 0.5);
    let (q, qd) = (SVector::from([0.1, 0.1]), SVector::from([0.0, 0.0]));
    println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
}
