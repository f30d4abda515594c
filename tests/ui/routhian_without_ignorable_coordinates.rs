// Every coordinate appears in L, or a force acts on it.
use lagrange_runtime::prelude::*;

lagrangian! {
    pub system Point {
        param m, k, c;
        coord x, y, z;
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2));
        V = 0.5 * k * x.powi(2);
        D = 0.5 * c * dot(y).powi(2);
        Q[z] = -c * z * dot(z);
        pub routhian Reduced;
    }
}

fn main() {
    let system = Point::new(1.0, 1.0, 0.1);
    let (reduced, state) = system.reduce(&State::new(0.0, [0.0, 0.0, 0.0], [1.0, 1.0, 1.0]));
    println!("{}", reduced.accel(&state.q, &state.qd, 0.0));
}
