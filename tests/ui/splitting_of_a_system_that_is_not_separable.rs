// A splitting method for a system whose inertia depends on the configuration.
use lagrange_runtime::prelude::*;

lagrangian! {
    pub system Orbit {
        param m, mu;
        coord r, phi;
        T = 0.5 * m * (dot(r).powi(2) + (r * dot(phi)).powi(2));
        V = -mu * m / r;
    }
}

fn leapfrog(_: &impl Separable<2>) {}

fn main() {
    leapfrog(&Orbit::new(1.0, 1.0));
}
