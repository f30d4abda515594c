// An acceleration in the kinetic energy.
use lagrange_runtime::prelude::*;
use lagrange_runtime::SVector;

lagrangian! {
    pub system Oscillator {
        param m, k;
        coord x;
        let v = dot(x);
        T = 0.5 * m * dot(x) * dot(v);
        V = 0.5 * k * x.powi(2);
    }
}

fn main() {
    let system = Oscillator::new(1.0, 0.5);
    let (q, qd) = (SVector::from([0.1]), SVector::from([0.0]));
    println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
}
