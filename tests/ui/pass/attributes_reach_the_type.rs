// Documentation and attributes of the system, its parameters and its outputs.
#![deny(missing_docs)]
//! A crate that documents everything.
use lagrange_runtime::SVector;
use lagrange_runtime::prelude::*;

lagrangian! {
    /// A mass on a spring.
    #[derive(PartialOrd)]
    #[repr(C)]
    pub system Oscillator {
        /// Mass in kg.
        param m;
        param k, /** Natural length. */ l = 1.0;
        /// Position of the mass.
        coord x;
        T = 0.5 * m * dot(x).powi(2);
        V = 0.5 * k * (x - l).powi(2);
        /// Force of the spring.
        #[must_use]
        observe tension = k * (x - l);
    }
}

fn main() {
    const SYSTEM: Oscillator = Oscillator::new(2.0, 3.0);
    let x = SVector::from([2.0]);
    assert_eq!(SYSTEM.tension(&x, &x, 0.0), 3.0);
    assert!(SYSTEM < Oscillator { m: 3.0, ..SYSTEM });
}
