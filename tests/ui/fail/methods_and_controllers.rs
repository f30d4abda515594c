// Pairs that do not fit: a controller and its method, coefficients and a method, a linear model and a system; and
// numbers and fields that do not.

use lagrange_runtime::analysis::StateSpace;
use lagrange_runtime::prelude::*;

lagrangian! {
    pub system Pendulum {
        param l, g = 9.81;
        coord theta: angle;
        T = 0.5 * (l * dot(theta)).powi(2);
        V = -g * l * cos(theta);
    }
}

const START: fn() -> State<f64, 1> = || State::new(0.0, [0.1], [0.0]);

// Steps of a series are controlled by its coefficients.
pub fn a_series_and_a_controller_of_estimates() {
    let _ = integrate(&Pendulum::new(1.0), Taylor, PiController::tolerance(1e-9), START());
}

// No estimate of the error, no controller.
pub fn equal_steps_and_a_tolerance() {
    let _ = integrate(&Pendulum::new(1.0), Gauss4, PiController::tolerance(1e-9), START());
}

// Coefficients alone.
pub fn coefficients_for_a_method() {
    let _ = integrate(&Pendulum::new(1.0), KahanLi8, FixedStep::new(0.01), START());
}

// A system without inputs has no B.
pub fn a_linear_model_without_inputs() {
    let _ = StateSpace::about(&Pendulum::new(1.0), &START());
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
