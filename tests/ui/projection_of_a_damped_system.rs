// A method that keeps the energy, for a system that loses it.
use lagrange_runtime::prelude::*;

lagrangian! {
    pub system Oscillator {
        param m, k, c;
        coord x;
        T = 0.5 * m * dot(x).powi(2);
        V = 0.5 * k * x.powi(2);
        D = 0.5 * c * dot(x).powi(2);
    }
}

fn projected(_: &impl Conservative<1>) {}

fn main() {
    projected(&Oscillator::new(1.0, 1.0, 0.1));
}
