// A system whose expansion has no end worth waiting for.
use lagrange_runtime::prelude::*;

lagrangian! {
    pub system Lattice {
        const N = 1000;
        param m, k;
        coord x: [N];
        T = 0.5 * m * (0..N).map(|i| dot(x[i]).powi(2)).sum();
        V = k * (0..N).map(|i| (0..N).map(|j| (x[i] - x[j]).powi(2).sqrt()).sum()).sum();
    }
}

fn main() {
    let lattice = Lattice::new(1.0, 0.5);
    let rest = lagrange_runtime::SVector::from([0.0; 1000]);
    println!("{}", lattice.accel(&rest, &rest, 0.0)[0]);
}
