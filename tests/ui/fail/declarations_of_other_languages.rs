use lagrange_runtime::prelude::*;

lagrangian! {
    pub system Oscillator {
        param: m [kg], k 3, c: 1, g: m, d > 0;
        coord x[3], z: 2;
        let y := 2 * x[0];
        let w == 3 * x[0];
        u := 4 * x[0];
        T = 0.5 * m * dot(x).norm_squared() + dot(z).norm_squared();
        T += k;
        V = k * x[0] * C * g * d;
        m * a = -k * x;
        end;
    }
}

fn main() {}
