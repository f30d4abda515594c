// Coordinates, their velocities and their inertia.

// A system without coordinates.
pub mod coordinates_missing {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        pub system Oscillator {
            param k;
            T = 0;
            V = 0.5 * k;
        }
    }

    pub fn main() {
        let system = Oscillator::new(1.0);
        let (q, qd) = (SVector::from([0.1]), SVector::from([0.0]));
        println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
    }
}

// A system whose motion is given.
pub mod all_coordinates_prescribed {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        pub system Rotor {
            param j, omega;
            coord phi = omega * t;
            T = 0.5 * j * dot(phi).powi(2);
            V = 0;
        }
    }

    pub fn main() {
        let system = Rotor::new(1.0, 0.5);
        let (q, qd) = (SVector::from([0.1]), SVector::from([0.0]));
        println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
    }
}

// A coordinate that does not appear in the kinetic energy.
pub mod coordinate_without_kinetic_energy {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        pub system Masses {
            param m, k;
            coord x, y;
            T = 0.5 * m * dot(x).powi(2);
            V = 0.5 * k * ((x - y).powi(2) + y.powi(2));
        }
    }

    pub fn main() {
        let system = Masses::new(1.0, 0.5);
        let (q, qd) = (SVector::from([0.1, 0.1]), SVector::from([0.0, 0.0]));
        println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
    }
}

// A prescribed coordinate that depends on a free one.
pub mod prescribed_coordinate_of_a_coordinate {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        pub system Wedge {
            param m, slope;
            coord x;
            coord y = slope * x;
            T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
            V = 9.81 * m * y;
        }
    }

    pub fn main() {
        let system = Wedge::new(1.0, 0.5);
        let (q, qd) = (SVector::from([0.1]), SVector::from([0.0]));
        println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
    }
}

// The rate of something that does not change.
pub mod rate_of_a_constant {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        pub system Pendulum {
            param m, l, g = 9.81;
            coord theta;
            T = 0.5 * m * ((l * dot(theta)).powi(2) + dot(l).powi(2));
            V = -m * g * l * theta.cos();
        }
    }

    pub fn main() {
        let system = Pendulum::new(1.0, 0.5);
        let (q, qd) = (SVector::from([0.1]), SVector::from([0.0]));
        println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
    }
}

// An acceleration in the kinetic energy.
pub mod second_derivative {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        pub system Oscillator {
            param m, k;
            coord x;
            let v = dot(x);
            T = 0.5 * m * dot(x) * dot(v);
            V = 0.5 * k * x.powi(2);
        }
    }

    pub fn main() {
        let system = Oscillator::new(1.0, 0.5);
        let (q, qd) = (SVector::from([0.1]), SVector::from([0.0]));
        println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
    }
}

// A kinetic energy of the sum of two velocities alone.
pub mod singular_inertia {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        pub system Masses {
            param m, k;
            coord x, y;
            T = 0.5 * m * (dot(x) + dot(y)).powi(2);
            V = 0.5 * k * (x.powi(2) + y.powi(2));
        }
    }

    pub fn main() {
        let system = Masses::new(1.0, 0.5);
        let (q, qd) = (SVector::from([0.1, 0.1]), SVector::from([0.0, 0.0]));
        println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
    }
}

// A whole L of the sum of two velocities alone.
pub mod degenerate_lagrangian {
    use lagrange_runtime::SVector;
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Masses {
            param m, k;
            coord x, y;
            L = 0.5 * m * (dot(x) + dot(y)).powi(2) - 0.5 * k * (x.powi(2) + y.powi(2));
        }
    }

    pub fn main() {
        println!("{}", Masses::new(1.0, 0.5).accel(&SVector::from([0.1, 0.1]), &SVector::from([0.0, 0.0]), 0.0));
    }
}

// A whole L of first degree in one of the velocities.
pub mod lagrangian_of_first_degree {
    use lagrange_runtime::SVector;
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Vortex {
            param m, k;
            coord x, y;
            L = 0.5 * m * dot(x).powi(2) + k * x * dot(y) - 0.5 * k * (x.powi(2) + y.powi(2));
        }
    }

    pub fn main() {
        println!("{}", Vortex::new(1.0, 0.5).accel(&SVector::from([0.1, 0.1]), &SVector::from([0.0, 0.0]), 0.0));
    }
}

// A comma in place of `;`.
pub mod energy_in_a_list_of_coordinates {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Oscillator {
            coord x, T = 0.5 * dot(x).powi(2);
            V = 0.5 * x.powi(2);
        }
    }

    pub fn main() {}
}

fn main() {}
