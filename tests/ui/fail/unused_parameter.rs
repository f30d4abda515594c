// A parameter that nothing depends on is a warning; one whose name begins with `_` is meant to be so.
#![deny(warnings)]
use lagrange_runtime::prelude::*;
use lagrange_runtime::SVector;

lagrangian! {
    pub system Pendulum {
        param m, l, g = 9.81, damping, _spare = 1.0;
        coord theta;
        T = 0.5 * m * (l * dot(theta)).powi(2);
        V = -m * g * l * theta.cos();
    }
}

fn main() {
    let system = Pendulum::new(1.0, 0.5, 0.1);
    let (q, qd) = (SVector::from([0.1]), SVector::from([0.0]));
    println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
}
