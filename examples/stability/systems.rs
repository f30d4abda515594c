//! The systems, as a user writes them.

use lagrange_runtime::prelude::*;

lagrangian! {
    /// An undamped oscillator.
    pub system Oscillator {
        param omega;
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = 0.5 * (omega * x).powi(2);
    }
}

lagrangian! {
    /// A spring beside a damper.
    pub system Damped {
        param c, k;
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = 0.5 * k * x.powi(2);
        D = 0.5 * c * dot(x).powi(2);
    }
}
