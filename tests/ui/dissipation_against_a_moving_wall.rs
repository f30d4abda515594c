// A damper whose other end moves in a prescribed way.
use lagrange_runtime::prelude::*;
use lagrange_runtime::SVector;

lagrangian! {
    pub system Oscillator {
        param m, k, c, u;
        coord x;
        coord wall = u * t;
        T = 0.5 * m * dot(x).powi(2);
        V = 0.5 * k * (x - wall).powi(2);
        D = 0.5 * c * (dot(x) - dot(wall)).powi(2);
    }
}

fn main() {
    let system = Oscillator::new(1.0, 0.5, 0.1, 0.2);
    let (q, qd) = (SVector::from([0.1]), SVector::from([0.0]));
    println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
}
