// Nothing is left when all coordinates are removed.
use lagrange_runtime::prelude::*;

lagrangian! {
    pub system Point {
        param m;
        coord x, y;
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
        V = 0;
        pub routhian Reduced;
    }
}

fn main() {
    let system = Point::new(1.0);
    let (reduced, state) = system.reduce(&State::new(0.0, [0.0, 0.0], [1.0, 1.0]));
    println!("{}", reduced.accel(&state.q, &state.qd, 0.0));
}
