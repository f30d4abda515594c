//! t
#![allow(missing_docs)]
use lagrange_runtime::prelude::*;
lagrangian! { pub system Stiff { param c, k; coord x; T = 0.5 * dot(x).powi(2); V = 0.5 * k * x.powi(2); D = 0.5 * c * dot(x).powi(2); } }
fn main() {
    let stiff = Stiff::new(1e8, 1e8);
    for tol in [1e-8,1e-9] { let mut run = integrate(&stiff, Radau5, Pi::tolerance(tol), State::new(0.0, [1.0], [0.0])).until(2.0);
    run.run_out().unwrap();
    println!("{:?} {:e} {:?}", run.state(), run.state().q[0] - (-2.0f64).exp(), run.statistics()); 
     let mut run = integrate(&stiff, Rodas5P, Pi::tolerance(tol), State::new(0.0, [1.0], [0.0])).until(2.0);
    run.run_out().unwrap();
    println!("{:?} {:e} {:?}", run.state(), run.state().q[0] - (-2.0f64).exp(), run.statistics());
    }
}
