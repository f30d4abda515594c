// Ownership: a system that lives too short, and a run that is used twice.

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

// A run borrows its system.
pub fn a_system_without_a_name() {
    let run = integrate(&Pendulum::new(1.0), Dop853, PiController::tolerance(1e-9), START()).until(10.0);
    let _ = run.final_state();
}

// A run is made once.
pub fn a_run_that_is_used_twice() {
    let pendulum = Pendulum::new(1.0);
    let run = integrate(&pendulum, Dop853, PiController::tolerance(1e-9), START()).until(10.0);
    let _ = run.final_state();
    let _ = run.sample_evenly(10).count();
}

fn main() {}
