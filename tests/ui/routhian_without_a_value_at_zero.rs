// L does not depend on phi, but is 0/0 where phi is 0.
use lagrange_runtime::prelude::*;

lagrangian! {
    pub system Orbit {
        param mu;
        coord r, phi;
        T = 0.5 * (dot(r).powi(2) + (r * dot(phi)).powi(2)) * ((1 + phi.cos()) * (1 - phi.cos()) / phi.sin().powi(2));
        V = -mu / r;
        pub routhian Reduced;
    }
}

fn main() {
    let system = Orbit::new(1.0);
    let (reduced, state) = system.reduce(&State::new(0.0, [1.0, 0.3], [0.0, 1.0]));
    println!("{}", reduced.accel(&state.q, &state.qd, 0.0));
}
