// A start on the constraints of a system that has none.
use lagrange_runtime::prelude::*;

lagrangian! {
    pub system Pendulum {
        param m, g = 9.81;
        coord x, y;
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
        V = m * g * y;

    }
}

fn main() {
    let system = Pendulum::new(1.0);
    let _ = consistent(&system, &State::new(0.0, [0.5, 0.0], [0.0, 0.0]));
}
