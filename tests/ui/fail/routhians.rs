// Systems without their ignorable coordinates.

// Velocities follow from momenta by a formula only where L is quadratic in them.
pub mod routhian_of_a_relativistic_particle {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Particle {
            param m;
            coord x, y;
            L = -m * (1 - dot(x).powi(2) - dot(y).powi(2)).sqrt() - x;
            pub routhian Reduced;
        }
    }

    pub fn main() {
        let system = Particle::new(1.0);
        let (reduced, state) = system.reduce(&State::new(0.0, [0.0, 0.0], [0.1, 0.1]));
        println!("{}", reduced.accel(&state.q, &state.qd, 0.0));
    }
}

// Nothing is left when all coordinates are removed.
pub mod routhian_of_ignorable_coordinates_alone {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Point {
            param m;
            coord x, y;
            T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
            V = 0;
            pub routhian Reduced;
        }
    }

    pub fn main() {
        let system = Point::new(1.0);
        let (reduced, state) = system.reduce(&State::new(0.0, [0.0, 0.0], [1.0, 1.0]));
        println!("{}", reduced.accel(&state.q, &state.qd, 0.0));
    }
}

// Two types cannot have one name.
pub mod routhian_of_the_same_name {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Orbit {
            param mu;
            coord r, phi;
            T = 0.5 * (dot(r).powi(2) + (r * dot(phi)).powi(2));
            V = -mu / r;
            pub routhian Orbit;
        }
    }

    pub fn main() {}
}

// All ignorable coordinates leave at once.
pub mod routhian_twice {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Orbit {
            param mu;
            coord r, phi;
            T = 0.5 * (dot(r).powi(2) + (r * dot(phi)).powi(2));
            V = -mu / r;
            pub routhian Reduced;
            pub routhian Again;
        }
    }

    pub fn main() {
        let system = Orbit::new(1.0);
        let (reduced, state) = system.reduce(&State::new(0.0, [1.0, 0.0], [0.0, 1.0]));
        println!("{}", reduced.accel(&state.q, &state.qd, 0.0));
    }
}

// The momentum of phi becomes a parameter, p_phi.
pub mod routhian_with_a_taken_momentum {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Orbit {
            param mu, p_phi;
            coord r, phi;
            T = 0.5 * (dot(r).powi(2) + (r * dot(phi)).powi(2));
            V = -mu / r + p_phi * r;
            pub routhian Reduced;
        }
    }

    pub fn main() {
        let system = Orbit::new(1.0, 0.1);
        let (reduced, state) = system.reduce(&State::new(0.0, [1.0, 0.0], [0.0, 1.0]));
        println!("{}", reduced.accel(&state.q, &state.qd, 0.0));
    }
}

// L does not depend on phi, but is 0/0 where phi is 0.
pub mod routhian_without_a_value_at_zero {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Orbit {
            param mu;
            coord r, phi;
            T = 0.5 * (dot(r).powi(2) + (r * dot(phi)).powi(2)) * ((1 + phi.cos()) * (1 - phi.cos()) / phi.sin().powi(2));
            V = -mu / r;
            pub routhian Reduced;
        }
    }

    pub fn main() {
        let system = Orbit::new(1.0);
        let (reduced, state) = system.reduce(&State::new(0.0, [1.0, 0.3], [0.0, 1.0]));
        println!("{}", reduced.accel(&state.q, &state.qd, 0.0));
    }
}

// Every coordinate appears in L, or a force acts on it.
pub mod routhian_without_ignorable_coordinates {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Point {
            param m, k, c;
            coord x, y, z;
            T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2));
            V = 0.5 * k * x.powi(2);
            D = 0.5 * c * dot(y).powi(2);
            Q[z] = -c * z * dot(z);
            pub routhian Reduced;
        }
    }

    pub fn main() {
        let system = Point::new(1.0, 1.0, 0.1);
        let (reduced, state) = system.reduce(&State::new(0.0, [0.0, 0.0, 0.0], [1.0, 1.0, 1.0]));
        println!("{}", reduced.accel(&state.q, &state.qd, 0.0));
    }
}

// A Routhian has no list of coordinates.
pub mod routhian_with_a_list {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Point {
            param m;
            coord x, y;
            T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
            V = y;
            pub routhian Reduced: x;
        }
    }

    pub fn main() {}
}

fn main() {}
