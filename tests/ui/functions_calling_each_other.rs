// Two functions that call each other.
use lagrange_runtime::prelude::*;
use lagrange_runtime::SVector;

lagrangian! {
    pub system Oscillator {
        param m, k;
        coord x;
        fn spring(s) = 0.5 * k * s * s + stop(s);
        fn stop(s) = spring(s - 1);
        T = 0.5 * m * dot(x).powi(2);
        V = spring(x);
    }
}

fn main() {
    let system = Oscillator::new(1.0, 0.5);
    let (q, qd) = (SVector::from([0.1]), SVector::from([0.0]));
    println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
}
