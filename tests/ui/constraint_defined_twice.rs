// Two constraints of one name.
use lagrange_runtime::prelude::*;

lagrangian! {
    pub system Pendulum {
        param m, l, g = 9.81;
        coord x, y, z;
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2));
        V = m * g * y;
        constraint rod: x * x + y * y == l * l;
        constraint rod: x == y;
    }
}

fn main() {
    let system = Pendulum::new(1.0, 0.5);
    let start = consistent(&system, &State::new(0.0, [0.1; 3], [0.0; 3]));
    println!("{:?} {}", start, system.multipliers(&SVector::zeros(), &SVector::zeros(), 0.0));
}
