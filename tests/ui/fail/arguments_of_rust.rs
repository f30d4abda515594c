// Numbers and fields of Rust.

use lagrange_runtime::prelude::*;

lagrangian! {
    pub system Pendulum {
        param l, g = 9.81;
        coord theta: angle;
        T = 0.5 * (l * dot(theta)).powi(2);
        V = -g * l * cos(theta);
    }
}

// A parameter with a default is no argument of `new`.
pub fn a_default_as_an_argument() {
    let _ = Pendulum::new(1.0, 9.81);
}

// A structure has all parameters.
pub fn a_parameter_is_missing() {
    let _ = Pendulum { l: 1.0 };
}

// Rust does not take an integer for a number.
pub fn integers() {
    let _ = Pendulum::new(1);
}

fn main() {}
