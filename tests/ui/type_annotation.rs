// Types where the language has none.
use lagrange_runtime::prelude::*;
use lagrange_runtime::SVector;

lagrangian! {
    pub system Pendulum {
        param m: f64, l: f64 = 1.0, g = 9.81;
        coord theta;
        fn height(angle: f64) -> f64 = -l * angle.cos();
        T = 0.5 * m * (l * dot(theta)).powi(2);
        V = m * g * height(theta);
    }
}

fn main() {
    let system = Pendulum::new(1.0);
    let (q, qd) = (SVector::from([0.1]), SVector::from([0.0]));
    println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
}
