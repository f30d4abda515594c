// Five mistakes, all reported at once.
use lagrange_runtime::prelude::*;
use lagrange_runtime::SVector;

lagrangian! {
    pub system Cart {
        param m, k, c, t = 1.0;
        coord x, y;
        let s = x + z;
        T = 0.5 * m * dot(x)^2 + 1 / 2 * m * dot(y).powi(2);
        V = 0.5 * k * s.powi(2) + c * sine(x);
        Q[z] = -c * dot(x);
    }
}

fn main() {
    let system = Cart::new(1.0, 0.5, 0.1);
    let (q, qd) = (SVector::from([0.1, 0.1]), SVector::from([0.0, 0.0]));
    // (Series of a system that has mistakes are not called missing.)
    let _ = integrate(&system, Taylor::for_tolerance(1e-9), Decay::tolerance(1e-9), State::new(0.0, [0.1; 2], [0.0; 2]));
    println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
}
