use lagrange_runtime::prelude::*;

lagrangian! {
    pub system Spring {
        param m = 5kg, k, l = 10cm;
        const N = 3x;
        coord x, y: [2m];
        let a = [x, x][1u];
        T = 0.5 * m * dot(x)**2;
        V = 0.5 * k * x**2 + 1e3V;
        D = 0.5 * *k * dot(x).powi(2);
        Q[x] = if true { x } else { 0.5f32 };
        observe pulls = #[inline] x;
        observe length = &x;
    }
}

fn main() {}
