// A generalized force of a coordinate whose motion is given.
use lagrange_runtime::prelude::*;
use lagrange_runtime::SVector;

lagrangian! {
    pub system Rotor {
        param m, l, omega, torque;
        coord theta;
        coord phi = omega * t;
        T = 0.5 * m * l.powi(2) * (dot(theta) + dot(phi)).powi(2);
        V = 0;
        Q[phi] = torque;
    }
}

fn main() {
    let system = Rotor::new(1.0, 0.5, 0.1, 0.2);
    let (q, qd) = (SVector::from([0.1]), SVector::from([0.0]));
    println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
}
