// A constraint that says nothing.
use lagrange_runtime::prelude::*;

lagrangian! {
    pub system Pendulum {
        param m, l, g = 9.81;
        coord x, y;
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
        V = m * g * y;
        constraint rod: x + l == l + x;
    }
}

fn main() {
    let system = Pendulum::new(1.0, 0.5);
    let start = consistent(&system, &State::new(0.0, [0.1, 0.1], [0.0, 0.0]));
    println!("{:?} {}", start, system.multipliers(&SVector::zeros(), &SVector::zeros(), 0.0));
}
