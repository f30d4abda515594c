// All ignorable coordinates leave at once.
use lagrange_runtime::prelude::*;

lagrangian! {
    pub system Orbit {
        param mu;
        coord r, phi;
        T = 0.5 * (dot(r).powi(2) + (r * dot(phi)).powi(2));
        V = -mu / r;
        pub routhian Reduced;
        pub routhian Again;
    }
}

fn main() {
    let system = Orbit::new(1.0);
    let (reduced, state) = system.reduce(&State::new(0.0, [1.0, 0.0], [0.0, 1.0]));
    println!("{}", reduced.accel(&state.q, &state.qd, 0.0));
}
