// A system whose motion is given.
use lagrange_runtime::prelude::*;
use lagrange_runtime::SVector;

lagrangian! {
    pub system Rotor {
        param j, omega;
        coord phi = omega * t;
        T = 0.5 * j * dot(phi).powi(2);
        V = 0;
    }
}

fn main() {
    let system = Rotor::new(1.0, 0.5);
    let (q, qd) = (SVector::from([0.1]), SVector::from([0.0]));
    println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
}
