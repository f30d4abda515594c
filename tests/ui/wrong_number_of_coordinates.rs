// A state of two coordinates for a system of one.
use lagrange_runtime::prelude::*;
use lagrange_runtime::SVector;

lagrangian! {
    pub system Oscillator {
        param m, k;
        coord x;
        T = 0.5 * m * dot(x).powi(2);
        V = 0.5 * k * x.powi(2);
    }
}

fn integrate<const N: usize>(_: &impl System<N, Scalar = f64>, _: SVector<f64, N>) {}

fn main() {
    integrate(&Oscillator::new(1.0, 1.0), SVector::from([1.0, 0.0]));
}
