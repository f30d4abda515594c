// Forces, impulses and reactions.

// A force in space at a point of the plane.
pub mod force_and_point_of_different_length {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        pub system Pendulum {
            param m, l, f;
            coord theta;
            let bob = [l * theta.sin(), -l * theta.cos()];
            T = 0.5 * m * (l * dot(theta)).powi(2);
            V = 0;
            force [f, 0.0, 0.0] at bob;
        }
    }

    pub fn main() {
        let system = Pendulum::new(1.0, 0.5, 0.1);
        let (q, qd) = (SVector::from([0.1]), SVector::from([0.0]));
        println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
    }
}

// A force at a point that does not move.
pub mod force_at_a_fixed_point {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        pub system Pendulum {
            param m, l, f;
            coord theta;
            T = 0.5 * m * (l * dot(theta)).powi(2);
            V = 0;
            force [f, 0.0] at [0.0, -l];
        }
    }

    pub fn main() {
        let system = Pendulum::new(1.0, 0.5, 0.1);
        let (q, qd) = (SVector::from([0.1]), SVector::from([0.0]));
        println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
    }
}

// A generalized force of a parameter, and of a misspelt coordinate.
pub mod force_on_a_parameter {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        pub system Pendulum {
            param m, l, torque;
            coord theta;
            T = 0.5 * m * (l * dot(theta)).powi(2);
            V = 0;
            Q[m] = torque;
            Q[tehta] = torque;
        }
    }

    pub fn main() {
        let system = Pendulum::new(1.0, 0.5, 0.1);
        let (q, qd) = (SVector::from([0.1]), SVector::from([0.0]));
        println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
    }
}

// A generalized force of a coordinate whose motion is given.
pub mod force_on_a_prescribed_coordinate {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        pub system Rotor {
            param m, l, omega, torque;
            coord theta;
            coord phi = omega * t;
            T = 0.5 * m * l.powi(2) * (dot(theta) + dot(phi)).powi(2);
            V = 0;
            Q[phi] = torque;
        }
    }

    pub fn main() {
        let system = Rotor::new(1.0, 0.5, 0.1, 0.2);
        let (q, qd) = (SVector::from([0.1]), SVector::from([0.0]));
        println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
    }
}

// A generalized force of an element of a coordinate that has none.
pub mod force_on_an_element_of_a_scalar {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        pub system Pendulum {
            param m, l, torque;
            coord theta;
            T = 0.5 * m * (l * dot(theta)).powi(2);
            V = 0;
            Q[theta[0]] = torque;
        }
    }

    pub fn main() {
        let system = Pendulum::new(1.0, 0.5, 0.1);
        let (q, qd) = (SVector::from([0.1]), SVector::from([0.0]));
        println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
    }
}

// A force that is applied nowhere.
pub mod force_without_point {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        pub system Pendulum {
            param m, l, f;
            coord theta;
            T = 0.5 * m * (l * dot(theta)).powi(2);
            V = 0;
            force [f, 0.0];
        }
    }

    pub fn main() {
        let system = Pendulum::new(1.0, 0.5, 0.1);
        let (q, qd) = (SVector::from([0.1]), SVector::from([0.0]));
        println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
    }
}

// Forces and couples of wrong components, and at frames that do not move.
pub mod forces_on_wrong_frames {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Top {
            param m, l, I;
            coord psi, theta, phi, x;
            let top = frame(world, [0, 0, 0], rotation_z(psi) * rotation_x(theta) * rotation_z(phi));
            let disk = frame(world, [x, 0], theta);
            let slide = frame(world, [x, 0, 0], rotation_x(l));
            T = body(m, [I, I, I], frame(top, [0, 0, l])) + particle(m, slide);
            V = 0;
            force [m, 0, 0] at top;
            force [m, 0] at frame(top, [0, 0, l]);
            force [m, 0, 0] at disk;
            force [m, 0, 0] at world;
            couple m on top;
            couple [m, 0, 0] on disk;
            couple [m, 0, 0] on slide;
            couple [m, 0, 0] on world;
            couple [m, 0, 0] on [x, 0, 0];
            couple [m, 0, 0] at top;
            couple [m, 0, 0];
            force top at [x, 0, 0];
        }
    }

    pub fn main() {}
}

// Two generalized forces of one coordinate.
pub mod two_forces_on_one_coordinate {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        pub system Oscillator {
            param m, k, c, f;
            coord x;
            T = 0.5 * m * dot(x).powi(2);
            V = 0.5 * k * x.powi(2);
            Q[x] = -c * dot(x).powi(3);
            Q[x] = f * t.sin();
        }
    }

    pub fn main() {
        let system = Oscillator::new(1.0, 0.5, 0.1, 0.2);
        let (q, qd) = (SVector::from([0.1]), SVector::from([0.0]));
        println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
    }
}

// An impulse at a point that does not move.
pub mod impulse_at_a_fixed_point {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Pendulum {
            param m, l, g = 9.81;
            coord x, y;
            T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
            V = m * g * y;
            impulse blow at [l, 0];
        }
    }

    pub fn main() {
        let system = Pendulum::new(1.0, 0.5);
        println!("{}", system.accel(&SVector::zeros(), &SVector::zeros(), 0.0));
    }
}

// An impulse that acts nowhere.
pub mod impulse_without_point {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Pendulum {
            param m, l, g = 9.81;
            coord x, y;
            T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
            V = m * g * y;
            impulse blow;
        }
    }

    pub fn main() {
        let system = Pendulum::new(1.0, 0.5);
        println!("{}", system.accel(&SVector::zeros(), &SVector::zeros(), 0.0));
    }
}

// Friction in proportion to a reaction.
pub mod reaction_in_a_force {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Pendulum {
            param m, l, g = 9.81;
            coord x, y;
            T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
            V = m * g * y;
            constraint rod: x * x + y * y == l * l;
            Q[x] = -0.1 * reaction(rod);
        }
    }

    pub fn main() {
        let system = Pendulum::new(1.0, 0.5);
        let start = consistent(&system, &State::new(0.0, [0.1, 0.1], [0.0, 0.0]));
        println!("{:?} {}", start, system.multipliers(&SVector::zeros(), &SVector::zeros(), 0.0));
    }
}

// The reaction of a free coordinate.
pub mod reaction_of_a_coordinate {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Pendulum {
            param m, l, g = 9.81;
            coord x, y;
            T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
            V = m * g * y;
            constraint rod: x * x + y * y == l * l;
            observe tension = reaction(x);
        }
    }

    pub fn main() {
        let system = Pendulum::new(1.0, 0.5);
        let start = consistent(&system, &State::new(0.0, [0.1, 0.1], [0.0, 0.0]));
        println!("{:?} {}", start, system.multipliers(&SVector::zeros(), &SVector::zeros(), 0.0));
    }
}

// Two impulses of one name, and the rate of a reaction.
pub mod impulse_twice_and_rate_of_a_reaction {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Bob {
            param l;
            coord x, y;
            T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
            V = 9.81 * y;
            constraint rod: x.powi(2) + y.powi(2) == l.powi(2);
            impulse blow at [x, y];
            impulse blow at [x];
            event jerk: dot(reaction(rod));
        }
    }
}

// A force on several coordinates, and a product with a matrix.
pub mod forces_in_matrix_form {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Plate {
            coord x: [2];
            let K = [[2, -1], [-1, 2]];
            T = 0.5 * x.map(|x| dot(x).powi(2)).sum();
            V = 0.5 * x.dot(K * x);
            D = dot(x[0]).powi(2) * sin(30 deg);
            Q[x, x] = [1, 2];
        }
    }

    pub fn main() {}
}

fn main() {}
