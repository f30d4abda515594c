// The kinetic energy of a system that was given as a whole Lagrangian.
use lagrange_runtime::prelude::*;

lagrangian! {
    pub system Charge {
        param m, b;
        coord x, y;
        L = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2)) + 0.5 * b * (x * dot(y) - y * dot(x));
    }
}

fn energy_drift(_: &impl Energies<2>) {}

fn main() {
    energy_drift(&Charge::new(1.0, 1.0));
}
