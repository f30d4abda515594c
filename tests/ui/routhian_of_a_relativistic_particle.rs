// Velocities follow from momenta by a formula only where L is quadratic in them.
use lagrange_runtime::prelude::*;

lagrangian! {
    pub system Particle {
        param m;
        coord x, y;
        L = -m * (1 - dot(x).powi(2) - dot(y).powi(2)).sqrt() - x;
        pub routhian Reduced;
    }
}

fn main() {
    let system = Particle::new(1.0);
    let (reduced, state) = system.reduce(&State::new(0.0, [0.0, 0.0], [0.1, 0.1]));
    println!("{}", reduced.accel(&state.q, &state.qd, 0.0));
}
