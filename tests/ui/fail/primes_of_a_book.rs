use lagrange_runtime::prelude::*;

lagrangian! {
    pub system Oscillator {
        param m, k;
        coord x;
        T = 0.5 * m * x' * x';
        V = k·x;
        Q[x] = -k * x'';
        D = 0.5 * k x'k;
    }
}

fn main() {}
