use lagrange_runtime::prelude::*;

lagrangian! {
    pub system Oscillator {
        param m, k = 9,81;
        coord x, y;
        let c = x > 0;
        T = .5 * m * dot(x).powi(2);
        V = k * (5%*x) + k * min(x, y, 0) + k * Sin[x];
        D = 0.5 * m * dot{x}.powi(2) + k * (5% + 1);
        Q[x] = if !x > 0 { k } else { 0 };
        Q[y] = if c == true { k } else { 0 };
        observe first = if x > 0 && < 1 { [x, y][0, 1] } else { +y };
        observe second = || [x, y] ||;
    }
}

fn main() {}
