// Methods on (q, p) do not know constraints.
use lagrange_runtime::prelude::*;

lagrangian! {
    pub system Pendulum {
        param m, l, g = 9.81;
        coord x, y;
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
        V = m * g * y;
        constraint rod: x * x + y * y == l * l;
    }
}

fn main() {
    let system = Pendulum::new(1.0, 0.5);
    let start = State::new(0.0, [0.5, 0.0], [0.0, 0.0]);
    let _ = integrate(&system, Gauss4, Fixed::new(0.01), start);
    let _ = integrate(&system, VariationalMidpoint, Fixed::new(0.01), start);
}
