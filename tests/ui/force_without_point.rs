// A force that is applied nowhere.
use lagrange_runtime::prelude::*;
use lagrange_runtime::SVector;

lagrangian! {
    pub system Pendulum {
        param m, l, f;
        coord theta;
        T = 0.5 * m * (l * dot(theta)).powi(2);
        V = 0;
        force [f, 0.0];
    }
}

fn main() {
    let system = Pendulum::new(1.0, 0.5, 0.1);
    let (q, qd) = (SVector::from([0.1]), SVector::from([0.0]));
    println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
}
