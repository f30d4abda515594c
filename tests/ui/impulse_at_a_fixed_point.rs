// An impulse at a point that does not move.
use lagrange_runtime::prelude::*;

lagrangian! {
    pub system Pendulum {
        param m, l, g = 9.81;
        coord x, y;
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
        V = m * g * y;
        impulse blow at [l, 0];
    }
}

fn main() {
    let system = Pendulum::new(1.0, 0.5);
    println!("{}", system.accel(&SVector::zeros(), &SVector::zeros(), 0.0));
}
