// rustc reads tokens before any macro does, and goes no further here.
use lagrange_runtime::prelude::*;

lagrangian! {
    pub system Oscillator {
        param m, k;
        coord x;
        T = 0.5 * m * x'.powi(2);
        V = 0.5 * k * x.powi(2);
    }
}

fn main() {}
