// Constraints.

// One `=` where `==` is meant.
pub mod constraint_as_an_assignment {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Pendulum {
            param m, l, g = 9.81;
            coord x, y;
            T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
            V = m * g * y;
            constraint rod: x * x + y * y = l * l;
        }
    }

    pub fn main() {
        let system = Pendulum::new(1.0, 0.5);
        let start = consistent(&system, &State::new(0.0, [0.1, 0.1], [0.0, 0.0]));
        println!("{:?} {}", start, system.multipliers(&SVector::zeros(), &SVector::zeros(), 0.0));
    }
}

// A stop.
pub mod constraint_as_an_inequality {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Pendulum {
            param m, l, g = 9.81;
            coord x, y;
            T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
            V = m * g * y;
            constraint floor: y >= -l;
        }
    }

    pub fn main() {
        let system = Pendulum::new(1.0, 0.5);
        let start = consistent(&system, &State::new(0.0, [0.1, 0.1], [0.0, 0.0]));
        println!("{:?} {}", start, system.multipliers(&SVector::zeros(), &SVector::zeros(), 0.0));
    }
}

// A square, and a sum of squares, whose gradients vanish where they do.
pub mod constraint_as_a_square {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Pendulum {
            param m, l, g = 9.81;
            coord x, y;
            T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
            V = m * g * y;
            constraint rod: (x * x + y * y - l * l).powi(2) == 0;
            constraint peg: (x - l).powi(2) + y.powi(2) == 0;
        }
    }

    pub fn main() {
        let system = Pendulum::new(1.0, 0.5);
        let start = consistent(&system, &State::new(0.0, [0.1, 0.1], [0.0, 0.0]));
        println!("{:?} {}", start, system.multipliers(&SVector::zeros(), &SVector::zeros(), 0.0));
    }
}

// Two constraints of one name.
pub mod constraint_defined_twice {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Pendulum {
            param m, l, g = 9.81;
            coord x, y, z;
            T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2));
            V = m * g * y;
            constraint rod: x * x + y * y == l * l;
            constraint rod: x == y;
        }
    }

    pub fn main() {
        let system = Pendulum::new(1.0, 0.5);
        let start = consistent(&system, &State::new(0.0, [0.1; 3], [0.0; 3]));
        println!("{:?} {}", start, system.multipliers(&SVector::zeros(), &SVector::zeros(), 0.0));
    }
}

// A constraint that holds the speed.
pub mod constraint_nonlinear_in_velocities {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Pendulum {
            param m, l, g = 9.81;
            coord x, y;
            T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
            V = m * g * y;
            constraint speed: dot(x).powi(2) + dot(y).powi(2) == l;
        }
    }

    pub fn main() {
        let system = Pendulum::new(1.0, 0.5);
        let start = consistent(&system, &State::new(0.0, [0.1, 0.1], [0.0, 0.0]));
        println!("{:?} {}", start, system.multipliers(&SVector::zeros(), &SVector::zeros(), 0.0));
    }
}

// Nothing that it is equal to.
pub mod constraint_of_an_expression {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Pendulum {
            param m, l, g = 9.81;
            coord x, y;
            T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
            V = m * g * y;
            constraint rod: x * x + y * y - l * l;
        }
    }

    pub fn main() {
        let system = Pendulum::new(1.0, 0.5);
        let start = consistent(&system, &State::new(0.0, [0.1, 0.1], [0.0, 0.0]));
        println!("{:?} {}", start, system.multipliers(&SVector::zeros(), &SVector::zeros(), 0.0));
    }
}

// A point that equals a number.
pub mod constraint_of_different_shapes {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Pendulum {
            param m, l, g = 9.81;
            coord x, y;
            T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
            V = m * g * y;
            constraint pin: [x, y] == 0;
        }
    }

    pub fn main() {
        let system = Pendulum::new(1.0, 0.5);
        let start = consistent(&system, &State::new(0.0, [0.1, 0.1], [0.0, 0.0]));
        println!("{:?} {}", start, system.multipliers(&SVector::zeros(), &SVector::zeros(), 0.0));
    }
}

// A constraint that follows from another.
pub mod constraint_redundant {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Pendulum {
            param m, l, g = 9.81;
            coord x, y, z;
            T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2));
            V = m * g * y;
            constraint rod: x * x + y * y == l * l;
            constraint twice: 2 * x * x + 2 * y * y == 2 * l * l;
        }
    }

    pub fn main() {
        let system = Pendulum::new(1.0, 0.5);
        let start = consistent(&system, &State::new(0.0, [0.1; 3], [0.0; 3]));
        println!("{:?} {}", start, system.multipliers(&SVector::zeros(), &SVector::zeros(), 0.0));
    }
}

// A constraint that says nothing.
pub mod constraint_that_always_holds {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Pendulum {
            param m, l, g = 9.81;
            coord x, y;
            T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
            V = m * g * y;
            constraint rod: x + l == l + x;
        }
    }

    pub fn main() {
        let system = Pendulum::new(1.0, 0.5);
        let start = consistent(&system, &State::new(0.0, [0.1, 0.1], [0.0, 0.0]));
        println!("{:?} {}", start, system.multipliers(&SVector::zeros(), &SVector::zeros(), 0.0));
    }
}

// A constraint with a sign that no state satisfies.
pub mod constraint_that_holds_nowhere {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Pendulum {
            param m, g = 9.81;
            coord x, y;
            T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
            V = m * g * y;
            constraint rod: x * x + y * y == -1;
        }
    }

    pub fn main() {
        let system = Pendulum::new(1.0);
        let start = consistent(&system, &State::new(0.0, [0.1, 0.1], [0.0, 0.0]));
        println!("{:?} {}", start, system.multipliers(&SVector::zeros(), &SVector::zeros(), 0.0));
    }
}

// Two equations under one name.
pub mod two_equations_in_a_constraint {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Pendulum {
            param m, g = 9.81;
            coord x, y;
            T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
            V = m * g * y;
            constraint rod: x == 1 && y == 0;
        }
    }

    pub fn main() {
        let system = Pendulum::new(1.0);
        let start = consistent(&system, &State::new(0.0, [0.1, 0.1], [0.0, 0.0]));
        println!("{:?} {}", start, system.multipliers(&SVector::zeros(), &SVector::zeros(), 0.0));
    }
}

// The name of a constraint in an output.
pub mod constraint_used_as_a_number {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Pendulum {
            param m, l, g = 9.81;
            coord x, y;
            T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
            V = m * g * y;
            constraint rod: x * x + y * y == l * l;
            observe tension = 2 * l * rod;
        }
    }

    pub fn main() {
        let system = Pendulum::new(1.0, 0.5);
        let start = consistent(&system, &State::new(0.0, [0.1, 0.1], [0.0, 0.0]));
        println!("{:?} {}", start, system.multipliers(&SVector::zeros(), &SVector::zeros(), 0.0));
    }
}

// A constraint between time and parameters.
pub mod constraint_without_coordinates {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Pendulum {
            param m, l, g = 9.81;
            coord x, y;
            T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
            V = m * g * y;
            constraint rod: l * t == g;
        }
    }

    pub fn main() {
        let system = Pendulum::new(1.0, 0.5);
        let start = consistent(&system, &State::new(0.0, [0.1, 0.1], [0.0, 0.0]));
        println!("{:?} {}", start, system.multipliers(&SVector::zeros(), &SVector::zeros(), 0.0));
    }
}

// A constraint without a name.
pub mod constraint_without_name {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Pendulum {
            param m, l, g = 9.81;
            coord x, y;
            T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
            V = m * g * y;
            constraint circle (x * x + y * y == l * l);
        }
    }

    pub fn main() {
        let system = Pendulum::new(1.0, 0.5);
        let start = consistent(&system, &State::new(0.0, [0.1, 0.1], [0.0, 0.0]));
        println!("{:?} {}", start, system.multipliers(&SVector::zeros(), &SVector::zeros(), 0.0));
    }
}

// As many constraints as coordinates.
pub mod constraints_too_many {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Pendulum {
            param m, l, g = 9.81;
            coord x, y;
            T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
            V = m * g * y;
            constraint rod: x * x + y * y == l * l;
            constraint wall: x == 0.1 * l;
        }
    }

    pub fn main() {
        let system = Pendulum::new(1.0, 0.5);
        let start = consistent(&system, &State::new(0.0, [0.1, 0.1], [0.0, 0.0]));
        println!("{:?} {}", start, system.multipliers(&SVector::zeros(), &SVector::zeros(), 0.0));
    }
}

// A family without its index.
pub mod constraints_of_a_family {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Chain {
            const N = 3;
            param m, l, g = 9.81;
            coord x: [N], y: [N];
            T = 0.5 * m * (0..N).map(|i| dot(x[i]).powi(2) + dot(y[i]).powi(2)).sum();
            V = m * g * (0..N).map(|i| y[i]).sum();
            constraint rods: [N] = x[0] == l;
            constraint bars: [N] = |i| x[i].powi(2) + y[i].powi(2) = l;
            constraint links: [N] = |i| x[i + 1] == x[i];
        }
    }

    pub fn main() {
        let system = Chain::new(1.0, 0.5);
        println!("{}", system.g);
    }
}

pub mod redundant_behind {
    use lagrange_runtime::prelude::*;
    lagrangian! {
        system Behind {
            coord x, y;
            T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
            V = 0;
            constraint rod: x == y, redundant;
        }
    }
}

fn main() {}
