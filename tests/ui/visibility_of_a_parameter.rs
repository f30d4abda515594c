// Fields of a system are public.
use lagrange_runtime::prelude::*;

lagrangian! {
    pub system Point {
        pub param m;
        coord x;
        T = 0.5 * m * dot(x).powi(2);
        V = 0;
    }
}

fn main() {
    println!("{:?}", Point::new(1.0));
}
