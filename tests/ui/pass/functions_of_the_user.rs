// External functions, generic over the scalar.
use lagrange_runtime::SVector;
use lagrange_runtime::prelude::*;

fn gust<S: Scalar>(t: S) -> S {
    t.sin()
}

lagrangian! {
    pub system Driven {
        param m, k;
        coord x;
        extern fn gust(t);
        T = 0.5 * m * dot(x).powi(2);
        V = 0.5 * k * x.powi(2);
        Q[x] = gust(2 * t);
    }
}

fn main() {
    let driven = Driven::new(1.0, 1.0);
    let rest = SVector::from([0.0]);
    assert_eq!(driven.accel(&rest, &rest, 0.5)[0], 1.0f64.sin());
}
