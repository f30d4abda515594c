// An integer that is no index is divided with a remainder.
use lagrange_runtime::prelude::*;

lagrangian! {
    pub system Tree {
        const N = 7;
        coord theta: [N];
        let x: [N] = |i| if i == 0 { 0 } else {
            let parent = (i - 1) / 2;
            x[parent] + theta[i].sin()
        };
        T = (0..N).map(|i| 0.5 * dot(theta[i]).powi(2)).sum();
        V = x[N - 1];
    }
}

fn main() {
    println!("{}", Tree::<f64>::FACTS.name);
}
