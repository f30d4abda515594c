// A function of a constant that has no value there.
use lagrange_runtime::prelude::*;
use lagrange_runtime::SVector;

lagrangian! {
    pub system Oscillator {
        param m;
        coord x;
        T = 0.5 * m * dot(x).powi(2);
        V = (1.0 - 3.0).sqrt() * x.powi(2);
    }
}

fn main() {
    let system = Oscillator::new(1.0);
    let (q, qd) = (SVector::from([0.1]), SVector::from([0.0]));
    println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
}
