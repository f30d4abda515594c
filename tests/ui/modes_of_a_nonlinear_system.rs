// Normal modes of a system that is not linear.
use lagrange_runtime::prelude::*;

lagrangian! {
    pub system Pendulum {
        param m, l, g = 9.81;
        coord theta;
        T = 0.5 * m * (l * dot(theta)).powi(2);
        V = -m * g * l * theta.cos();
    }
}

fn modes(_: &impl Linear<1>) {}

fn main() {
    modes(&Pendulum::new(1.0, 1.0));
}
