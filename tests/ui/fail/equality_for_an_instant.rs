// Equality of what moves decides a choice for an instant, which is a warning; that of parameters, and a value at a pole, are meant.
#![deny(warnings)]
use lagrange_runtime::SVector;
use lagrange_runtime::prelude::*;

lagrangian! {
    pub system Oscillator {
        param m, k, a, b;
        coord x;
        let at_rest = dot(x) == 0;
        T = 0.5 * m * dot(x).powi(2);
        V = 0.5 * k * x.powi(2);
        Q[x] = (if x == 0 { k } else { 0 })
            + (if t != 1 && a == b { 0 } else { k })
            + (if at_rest { k } else { 0 })
            + (if x == 0 { 1 } else { sin(x) / x });
    }
}

fn main() {
    let system = Oscillator::new(1.0, 0.5, 0.1, 0.2);
    let (q, qd) = (SVector::from([0.1]), SVector::from([0.0]));
    println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
}
