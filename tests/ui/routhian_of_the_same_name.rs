// Two types cannot have one name.
use lagrange_runtime::prelude::*;

lagrangian! {
    pub system Orbit {
        param mu;
        coord r, phi;
        T = 0.5 * (dot(r).powi(2) + (r * dot(phi)).powi(2));
        V = -mu / r;
        pub routhian Orbit;
    }
}

fn main() {}
