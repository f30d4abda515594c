// Methods and functions that need a fact which the system does not have. The compiler of the program refuses them.

// A start on the constraints of a system that has none.
pub mod consistent_without_constraints {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Pendulum {
            param m, g = 9.81;
            coord x, y;
            T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
            V = m * g * y;

        }
    }

    pub fn main() {
        let system = Pendulum::new(1.0);
        let _ = consistent(&system, &State::new(0.0, [0.5, 0.0], [0.0, 0.0]));
    }
}

// Methods on (q, p) do not know constraints.
pub mod constraints_and_a_symplectic_method {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Pendulum {
            param m, l, g = 9.81;
            coord x, y;
            T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
            V = m * g * y;
            constraint rod: x * x + y * y == l * l;
        }
    }

    pub fn main() {
        let system = Pendulum::new(1.0, 0.5);
        let start = State::new(0.0, [0.5, 0.0], [0.0, 0.0]);
        let _ = integrate(&system, Gauss4, FixedStep::new(0.01), start);
        let _ = integrate(&system, VariationalMidpoint, FixedStep::new(0.01), start);
    }
}

// The kinetic energy of a system that was given as a whole Lagrangian.
pub mod energy_of_a_whole_lagrangian {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Charge {
            param m, b;
            coord x, y;
            L = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2)) + 0.5 * b * (x * dot(y) - y * dot(x));
        }
    }

    fn energy_drift(_: &impl Energies<2>) {}

    pub fn main() {
        energy_drift(&Charge::new(1.0, 1.0));
    }
}

// Normal modes of a system that is not linear.
pub mod modes_of_a_nonlinear_system {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Pendulum {
            param m, l, g = 9.81;
            coord theta;
            T = 0.5 * m * (l * dot(theta)).powi(2);
            V = -m * g * l * theta.cos();
        }
    }

    fn modes(_: &impl lagrange_runtime::traits::Linear<1>) {}

    pub fn main() {
        modes(&Pendulum::new(1.0, 1.0));
    }
}

// A method that keeps the energy, for a system that loses it.
pub mod projection_of_a_damped_system {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Oscillator {
            param m, k, c;
            coord x;
            T = 0.5 * m * dot(x).powi(2);
            V = 0.5 * k * x.powi(2);
            D = 0.5 * c * dot(x).powi(2);
        }
    }

    fn projected(_: &impl lagrange_runtime::traits::Conservative<1>) {}

    pub fn main() {
        projected(&Oscillator::new(1.0, 1.0, 0.1));
    }
}

// A splitting method for a system whose inertia depends on the configuration.
pub mod splitting_of_a_system_that_is_not_separable {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Orbit {
            param m, mu;
            coord r, phi;
            T = 0.5 * m * (dot(r).powi(2) + (r * dot(phi)).powi(2));
            V = -mu * m / r;
        }
    }

    fn leapfrog(_: &impl lagrange_runtime::traits::Separable<2>) {}

    pub fn main() {
        leapfrog(&Orbit::new(1.0, 1.0));
    }
}

// Methods on (q, p), variational ones and splittings know coordinates alone.
pub mod states_of_first_order {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Filter {
            param tau;
            coord x;
            state z;
            T = 0.5 * dot(x).powi(2);
            V = 0.5 * x.powi(2);
            Q[x] = -z;
            rate(z) = (x - z) / tau;
        }
    }

    pub fn main() {
        let (filter, step) = (Filter::new(0.1), FixedStep::new(0.1));
        let start = filter.start(0.0, [1.0], [0.0]);
        let _ = integrate(&filter, Gauss4, step, start);
        let _ = integrate(&filter, VariationalMidpoint, step, start);
        let _ = integrate(&filter, Verlet, step, start);
    }
}

// A curve is a function of one argument, and a number is none.
pub mod functions_of_other_arguments {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Drifter {
            param m;
            coord x;
            extern wind: Curve(t, height);
            extern gust: f64(t);
            T = 0.5 * m * dot(x).powi(2);
            V = 0;
            Q[x] = wind(t, x) + gust(t);
        }
    }
}

fn main() {}
