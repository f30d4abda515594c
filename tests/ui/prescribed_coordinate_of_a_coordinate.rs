// A prescribed coordinate that depends on a free one.
use lagrange_runtime::prelude::*;
use lagrange_runtime::SVector;

lagrangian! {
    pub system Wedge {
        param m, slope;
        coord x;
        coord y = slope * x;
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
        V = 9.81 * m * y;
    }
}

fn main() {
    let system = Wedge::new(1.0, 0.5);
    let (q, qd) = (SVector::from([0.1]), SVector::from([0.0]));
    println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
}
