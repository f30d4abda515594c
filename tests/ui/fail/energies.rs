// Kinetic energy, potential energy and dissipation.

// A system without energies.
pub mod energies_missing {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        pub system Oscillator {
            param m, k;
            coord x;
            Q[x] = -k * x / m;
        }
    }

    pub fn main() {
        let system = Oscillator::new(1.0, 0.5);
        let (q, qd) = (SVector::from([0.1]), SVector::from([0.0]));
        println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
    }
}

// Two kinetic energies.
pub mod energy_given_twice {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        pub system Masses {
            param m, k;
            coord x, y;
            T = 0.5 * m * dot(x).powi(2);
            T = 0.5 * m * dot(y).powi(2);
            V = 0.5 * k * (x - y).powi(2);
        }
    }

    pub fn main() {
        let system = Masses::new(1.0, 0.5);
        let (q, qd) = (SVector::from([0.1, 0.1]), SVector::from([0.0, 0.0]));
        println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
    }
}

// A system without its kinetic energy.
pub mod kinetic_energy_missing {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        pub system Oscillator {
            param k;
            coord x;
            V = 0.5 * k * x.powi(2);
        }
    }

    pub fn main() {
        let system = Oscillator::new(1.0);
        let (q, qd) = (SVector::from([0.1]), SVector::from([0.0]));
        println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
    }
}

// A kinetic energy of the position.
pub mod kinetic_energy_without_velocity {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        pub system Oscillator {
            param m, k;
            coord x;
            T = 0.5 * m * x.powi(2);
            V = 0.5 * k * x.powi(2);
        }
    }

    pub fn main() {
        let system = Oscillator::new(1.0, 0.5);
        let (q, qd) = (SVector::from([0.1]), SVector::from([0.0]));
        println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
    }
}

// A whole Lagrangian beside a kinetic energy.
pub mod lagrangian_and_kinetic_energy {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        pub system Oscillator {
            param m, k;
            coord x;
            T = 0.5 * m * dot(x).powi(2);
            L = 0.5 * m * dot(x).powi(2) - 0.5 * k * x.powi(2);
        }
    }

    pub fn main() {
        let system = Oscillator::new(1.0, 0.5);
        let (q, qd) = (SVector::from([0.1]), SVector::from([0.0]));
        println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
    }
}

// A system without its potential energy.
pub mod potential_energy_missing {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        pub system Oscillator {
            param m;
            coord x;
            T = 0.5 * m * dot(x).powi(2);
        }
    }

    pub fn main() {
        let system = Oscillator::new(1.0);
        let (q, qd) = (SVector::from([0.1]), SVector::from([0.0]));
        println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
    }
}

// A velocity in the potential energy.
pub mod velocity_in_potential {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        pub system Charge {
            param m, b;
            coord x, y;
            T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
            V = -0.5 * b * (x * dot(y) - y * dot(x));
        }
    }

    pub fn main() {
        let system = Charge::new(1.0, 0.5);
        let (q, qd) = (SVector::from([0.1, 0.1]), SVector::from([0.0, 0.0]));
        println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
    }
}

// A velocity in the potential energy, through a `let`.
pub mod velocity_in_potential_through_let {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        pub system Charge {
            param m, b;
            coord x, y;
            let swept = x * dot(y) - y * dot(x);
            T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
            V = -0.5 * b * swept;
        }
    }

    pub fn main() {
        let system = Charge::new(1.0, 0.5);
        let (q, qd) = (SVector::from([0.1, 0.1]), SVector::from([0.0, 0.0]));
        println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
    }
}

// A damper whose other end moves in a prescribed way.
pub mod dissipation_against_a_moving_wall {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        pub system Oscillator {
            param m, k, c, u;
            coord x;
            coord wall = u * t;
            T = 0.5 * m * dot(x).powi(2);
            V = 0.5 * k * (x - wall).powi(2);
            D = 0.5 * c * (dot(x) - dot(wall)).powi(2);
        }
    }

    pub fn main() {
        let system = Oscillator::new(1.0, 0.5, 0.1, 0.2);
        let (q, qd) = (SVector::from([0.1]), SVector::from([0.0]));
        println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
    }
}

// A dissipation function of the position.
pub mod dissipation_without_velocity {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        pub system Oscillator {
            param m, k, c;
            coord x;
            T = 0.5 * m * dot(x).powi(2);
            V = 0.5 * k * x.powi(2);
            D = 0.5 * c * x.powi(2);
        }
    }

    pub fn main() {
        let system = Oscillator::new(1.0, 0.5, 0.1);
        let (q, qd) = (SVector::from([0.1]), SVector::from([0.0]));
        println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
    }
}

// A dissipation function of third degree.
pub mod cubic_dissipation {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        pub system Oscillator {
            param m, k, c;
            coord x;
            T = 0.5 * m * dot(x).powi(2);
            V = 0.5 * k * x.powi(2);
            D = c * dot(x).powi(3);
        }
    }

    pub fn main() {
        let system = Oscillator::new(1.0, 0.5, 0.1);
        let (q, qd) = (SVector::from([0.1]), SVector::from([0.0]));
        println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
    }
}

// A dissipation function of first degree.
pub mod linear_dissipation {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        pub system Oscillator {
            param m, k, c;
            coord x;
            T = 0.5 * m * dot(x).powi(2);
            V = 0.5 * k * x.powi(2);
            D = c * dot(x);
        }
    }

    pub fn main() {
        let system = Oscillator::new(1.0, 0.5, 0.1);
        let (q, qd) = (SVector::from([0.1]), SVector::from([0.0]));
        println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
    }
}

fn main() {}
