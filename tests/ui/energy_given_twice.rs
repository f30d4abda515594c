// Two kinetic energies.
use lagrange_runtime::prelude::*;
use lagrange_runtime::SVector;

lagrangian! {
    pub system Masses {
        param m, k;
        coord x, y;
        T = 0.5 * m * dot(x).powi(2);
        T = 0.5 * m * dot(y).powi(2);
        V = 0.5 * k * (x - y).powi(2);
    }
}

fn main() {
    let system = Masses::new(1.0, 0.5);
    let (q, qd) = (SVector::from([0.1, 0.1]), SVector::from([0.0, 0.0]));
    println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
}
