// Names that are unknown, misspelt or taken.

// A parameter and a coordinate of one name.
pub mod duplicate_name {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        pub system Pendulum {
            param m, l, g = 9.81, theta = 0.3;
            coord theta;
            T = 0.5 * m * (l * dot(theta)).powi(2);
            V = -m * g * l * theta.cos();
        }
    }

    pub fn main() {
        let system = Pendulum::new(1.0, 0.5);
        let (q, qd) = (SVector::from([0.1]), SVector::from([0.0]));
        println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
    }
}

// A keyword of Rust as a name.
pub mod raw_identifier {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        pub system Oscillator {
            param m, r#type;
            coord x;
            T = 0.5 * m * dot(x).powi(2);
            V = 0.5 * r#type * x.powi(2);
            observe r#fn = x;
        }
    }

    pub fn main() {
        let system = Oscillator::new(1.0, 0.5);
        let (q, qd) = (SVector::from([0.1]), SVector::from([0.0]));
        println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
    }
}

// Names that mean something already: time, the derivative, a function.
pub mod reserved_name {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        pub system Oscillator {
            param m, k, t = 1.0, dot = 2.0;
            coord x;
            let sin = x.powi(2);
            T = 0.5 * m * dot(x).powi(2);
            V = 0.5 * k * sin;
        }
    }

    pub fn main() {
        let system = Oscillator::new(1.0, 0.5);
        let (q, qd) = (SVector::from([0.1]), SVector::from([0.0]));
        println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
    }
}

// A name that was never declared.
pub mod undeclared_name {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        pub system Pendulum {
            param m, l;
            coord theta;
            T = 0.5 * m * (l * dot(theta)).powi(2);
            V = -m * gravity * l * theta.cos();
        }
    }

    pub fn main() {
        let system = Pendulum::new(1.0, 0.5);
        let (q, qd) = (SVector::from([0.1]), SVector::from([0.0]));
        println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
    }
}

// A misspelt name.
pub mod unknown_name {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        pub system Pendulum {
            param mass, length, g = 9.81;
            coord theta;
            T = 0.5 * mass * (lenght * dot(theta)).powi(2);
            V = -mass * g * length * theta.cos();
        }
    }

    pub fn main() {
        let system = Pendulum::new(1.0, 0.5);
        let (q, qd) = (SVector::from([0.1]), SVector::from([0.0]));
        println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
    }
}

// A function that does not exist, called and as a method.
pub mod unknown_function {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        pub system Pendulum {
            param m, l, g = 9.81;
            coord theta;
            T = 0.5 * m * (l * dot(theta)).powi(2);
            V = -m * g * l * cosine(theta) + theta.sine();
        }
    }

    pub fn main() {
        let system = Pendulum::new(1.0, 0.5);
        let (q, qd) = (SVector::from([0.1]), SVector::from([0.0]));
        println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
    }
}

// Words for kinds, misspelt and misplaced; a type is none.
pub mod kind_misspelt {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Orbit {
            param m: length, mu;
            coord r: lenght, phi: [angel; 1], z: f64;
            T = 0.5 * m * (dot(r).powi(2) + (r * dot(phi[0])).powi(2) + dot(z).powi(2));
            V = -mu / r + z;
        }
    }

    pub fn main() {
        println!("{:?}", Orbit::new(1.0, 1.0));
    }
}

// Another word than `system`.
pub mod system_misspelt {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        pub struct Oscillator {
            param m, k;
            coord x;
            T = 0.5 * m * dot(x).powi(2);
            V = 0.5 * k * x.powi(2);
        }
    }

    pub fn main() {
        let system = Oscillator::new(1.0, 0.5);
        let (q, qd) = (SVector::from([0.1]), SVector::from([0.0]));
        println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
    }
}

// An energy under a name that the language does not know.
pub mod energy_of_another_name {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        pub system Oscillator {
            param m, k;
            coord x;
            T = 0.5 * m * dot(x).powi(2);
            U = 0.5 * k * x.powi(2);
        }
    }

    pub fn main() {
        let system = Oscillator::new(1.0, 0.5);
        let (q, qd) = (SVector::from([0.1]), SVector::from([0.0]));
        println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
    }
}

// An output named like a function that every system has.
pub mod output_of_a_taken_name {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        pub system Oscillator {
            param m, k;
            coord x;
            T = 0.5 * m * dot(x).powi(2);
            V = 0.5 * k * x.powi(2);
            observe energy = 0.5 * k * x.powi(2);
            observe map = x;
        }
    }

    pub fn main() {
        let system = Oscillator::new(1.0, 0.5);
        let (q, qd) = (SVector::from([0.1]), SVector::from([0.0]));
        println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
    }
}

// A `let` used above its definition.
pub mod let_before_its_definition {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        pub system Pendulum {
            param m, l, g = 9.81;
            coord theta;
            T = 0.5 * m * (l * dot(theta)).powi(2);
            V = m * g * height;
            let height = -l * theta.cos();
        }
    }

    pub fn main() {
        let system = Pendulum::new(1.0, 0.5);
        let (q, qd) = (SVector::from([0.1]), SVector::from([0.0]));
        println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
    }
}

// The reaction of nothing.
pub mod reaction_misspelt {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Pendulum {
            param m, l, g = 9.81;
            coord x, y;
            T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
            V = m * g * y;
            constraint rod: x * x + y * y == l * l;
            observe tension = reaction(rood);
        }
    }

    pub fn main() {
        let system = Pendulum::new(1.0, 0.5);
        let start = consistent(&system, &State::new(0.0, [0.1, 0.1], [0.0, 0.0]));
        println!("{:?} {}", start, system.multipliers(&SVector::zeros(), &SVector::zeros(), 0.0));
    }
}

// A system with an error beside types whose names generic parameters have.
pub mod types_with_short_names {
    use lagrange_runtime::prelude::*;

    pub struct K;
    pub struct N;
    pub struct R;
    pub struct S;

    lagrangian! {
        pub system I {
            param m, k;
            coord x;
            T = 0.5 * m * dot(x).powi(2);
            V = 0.5 * K * x.powi(2);
        }
    }
}

// An event of an output.
pub mod output_in_an_event {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Ball {
            coord y;
            T = 0.5 * dot(y).powi(2);
            V = 9.81 * y;
            observe height = y - 0.1;
            event ground: height, falling, terminal;
            event roof: depth - 3, rising;
            observe depth = -y;
        }
    }
}

fn main() {}
