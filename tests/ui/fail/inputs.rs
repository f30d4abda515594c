// Inputs that are none.

// A name that is not known is compared with inputs, too.
pub mod unknown {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Cart {
            param m;
            input force;
            coord x;
            T = 0.5 * m * dot(x).powi(2);
            V = 0;
            Q[x] = forse;
        }
    }
}

// Names belong to one thing.
pub mod duplicate {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Cart {
            param m, force;
            input force;
            coord x;
            T = 0.5 * m * dot(x).powi(2);
            V = 0;
            Q[x] = force;
        }
    }
}

// An input that follows from time is a function, and one with a value a default.
pub mod values {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Cart {
            param m;
            input u = m;
            input v(t);
            input w: [2] = [1, 2, 3];
            input: z;
            coord x;
            T = 0.5 * m * dot(x).powi(2);
            V = 0;
            Q[x] = u + v + w[2] + z;
        }
    }
}

// An input is held: it has no rate, prescribes no motion, and is no constant.
pub mod held {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Cart {
            param m;
            input u;
            const N = u;
            coord x;
            coord y = u;
            T = 0.5 * m * (dot(x) + N * dot(y)).powi(2);
            V = 0;
            Q[x] = dot(u);
        }
    }
}

// Outputs have other names than what systems with inputs have.
pub mod outputs {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Cart {
            param m;
            control u;
            coord x;
            T = 0.5 * m * dot(x).powi(2);
            V = 0;
            Q[x] = u;
            observe inputs = u;
        }
    }
}

// What needs inputs says so.
pub mod none {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::Stepper;

    lagrangian! {
        pub system Cart {
            param m;
            coord x;
            T = 0.5 * m * dot(x).powi(2);
            V = 0;
        }
    }

    pub fn main() {
        let start = State::new(0.0, [0.0], [0.0]);
        let mut stepper = Stepper::new(Cart::new(1.0), Rk4, FixedStep::new(0.1), start);
        let _ = stepper.set_inputs([1.0]);
    }
}

fn main() {}
