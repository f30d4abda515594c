// Words for kinds, misspelt and misplaced; a type is none.
use lagrange_runtime::prelude::*;

lagrangian! {
    pub system Orbit {
        param m: length, mu;
        coord r: lenght, phi: [angel; 1], z: f64;
        T = 0.5 * m * (dot(r).powi(2) + (r * dot(phi[0])).powi(2) + dot(z).powi(2));
        V = -mu / r + z;
    }
}

fn main() {
    println!("{:?}", Orbit::new(1.0, 1.0));
}
