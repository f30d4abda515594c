// The momentum of phi becomes a parameter, p_phi.
use lagrange_runtime::prelude::*;

lagrangian! {
    pub system Orbit {
        param mu, p_phi;
        coord r, phi;
        T = 0.5 * (dot(r).powi(2) + (r * dot(phi)).powi(2));
        V = -mu / r + p_phi * r;
        pub routhian Reduced;
    }
}

fn main() {
    let system = Orbit::new(1.0, 0.1);
    let (reduced, state) = system.reduce(&State::new(0.0, [1.0, 0.0], [0.0, 1.0]));
    println!("{}", reduced.accel(&state.q, &state.qd, 0.0));
}
