// A function that does not exist, called and as a method.
use lagrange_runtime::prelude::*;
use lagrange_runtime::SVector;

lagrangian! {
    pub system Pendulum {
        param m, l, g = 9.81;
        coord theta;
        T = 0.5 * m * (l * dot(theta)).powi(2);
        V = -m * g * l * cosine(theta) + theta.sine();
    }
}

fn main() {
    let system = Pendulum::new(1.0, 0.5);
    let (q, qd) = (SVector::from([0.1]), SVector::from([0.0]));
    println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
}
