// Names that mean something already: time, the derivative, a function.
use lagrange_runtime::prelude::*;
use lagrange_runtime::SVector;

lagrangian! {
    pub system Oscillator {
        param m, k, t = 1.0, dot = 2.0;
        coord x;
        let sin = x.powi(2);
        T = 0.5 * m * dot(x).powi(2);
        V = 0.5 * k * sin;
    }
}

fn main() {
    let system = Oscillator::new(1.0, 0.5);
    let (q, qd) = (SVector::from([0.1]), SVector::from([0.0]));
    println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
}
