// An attribute of a statement that becomes no item.
use lagrange_runtime::prelude::*;
use lagrange_runtime::SVector;

lagrangian! {
    pub system Oscillator {
        param m, k;
        #[inline]
        coord x;
        T = 0.5 * m * dot(x).powi(2);
        V = 0.5 * k * x.powi(2);
    }
}

fn main() {
    let system = Oscillator::new(1.0, 0.5);
    let (q, qd) = (SVector::from([0.1]), SVector::from([0.0]));
    println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
}
