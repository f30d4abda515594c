// Statements in the wrong form or place.

// A misspelt statement.
pub mod unknown_statement {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        pub system Pendulum {
            parm m, l, g = 9.81;
            cord theta;
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

// Parameters without a comma between them.
pub mod missing_comma {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        pub system Pendulum {
            param m l, g = 9.81;
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

// Statements whose `;` was forgotten.
pub mod missing_semicolon {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        pub system Pendulum {
            param m, l, g = 9.81
            coord theta;
            T = 0.5 * m * (l * dot(theta)).powi(2)
            V = -m * g * l * theta.cos()
        }
    }

    pub fn main() {
        let system = Pendulum::new(1.0, 0.5);
        let (q, qd) = (SVector::from([0.1]), SVector::from([0.0]));
        println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
    }
}

// An attribute of a statement that becomes no item.
pub mod attribute_without_effect {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        pub system Oscillator {
            param m, k;
            #[inline]
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

// A system without its braces.
pub mod body_missing {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        pub system Oscillator;
    }

    pub fn main() {
        let system = Oscillator::new();
        let (q, qd) = (SVector::from([0.1]), SVector::from([0.0]));
        println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
    }
}

// Generics on a system.
pub mod generic_system {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        pub system Oscillator<S> {
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

// Two systems in one macro.
pub mod two_systems {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        pub system Oscillator {
            param m, k;
            coord x;
            T = 0.5 * m * dot(x).powi(2);
            V = 0.5 * k * x.powi(2);
        }
        pub system Rotor {
            param j;
            coord phi;
            T = 0.5 * j * dot(phi).powi(2);
            V = 0;
        }
    }

    pub fn main() {
        let system = Oscillator::new(1.0, 0.5);
        let (q, qd) = (SVector::from([0.1]), SVector::from([0.0]));
        println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
    }
}

// A trait that every system derives.
pub mod derived_twice {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        #[derive(Clone, Debug)]
        pub system Oscillator {
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

// A system of nothing.
pub mod empty_system {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        pub system Nothing {}
    }

    pub fn main() {
        let system = Nothing::new();
        let (q, qd) = (SVector::from([0.1]), SVector::from([0.0]));
        println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
    }
}

// Five mistakes, all reported at once.
pub mod several_mistakes {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        pub system Cart {
            param m, k, c, t = 1.0;
            coord x, y;
            let s = x + z;
            T = 0.5 * m * dot(x)^2 + 1 / 2 * m * dot(y).powi(2);
            V = 0.5 * k * s.powi(2) + c * sine(x);
            Q[z] = -c * dot(x);
        }
    }

    pub fn main() {
        let system = Cart::new(1.0, 0.5, 0.1);
        let (q, qd) = (SVector::from([0.1, 0.1]), SVector::from([0.0, 0.0]));
        // (Series of a system that has mistakes are not called missing.)
        let _ = integrate(&system, Taylor, TaylorController::tolerance(1e-9), State::new(0.0, [0.1; 2], [0.0; 2]));
        println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
    }
}

// Outputs whose rows differ, and one with a length.
pub mod outputs_that_are_no_matrices {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Pendulum {
            param m, l, g = 9.81;
            coord theta;
            T = 0.5 * m * (l * dot(theta)).powi(2);
            V = -m * g * l * cos(theta);
            observe ragged = [[1, theta], [theta]];
            observe mixed = [[1, theta], theta];
            observe deep = [[[1], [theta]], [[theta], [1]]];
            observe sized: [2] = [theta, 1];
        }
    }

    pub fn main() {}
}

// One mistake, and every use of the system: none of them is an error.
pub mod uses_of_a_broken_system {
    use lagrange_runtime::SVector;
    use lagrange_runtime::prelude::*;

    lagrangian! {
        #[derive(PartialOrd)]
        pub system Pendulum {
            param m, l: [2], g = 9.81;
            coord theta: [2];
            let tip = [l[0] * theta[0].sin(), -l[0] * theta[0].cos()];
            T = 0.5 * m * (0..2).map(|i| (l[i] * dot(theta[i])).powi(2)).sum();
            V = -m * g * l[0] * tehta[0].cos();
            observe tip;
            observe height = tip[1];
        }
    }

    const PENDULUM: Pendulum = Pendulum::new(1.0, [0.5, 0.25]);

    fn drift<S: Energies<2> + LegendreTransform<2> + Separable<2>>(_: &S) -> usize {
        S::FACTS.coordinates.len()
    }

    pub fn main() {
        let (q, qd) = (SVector::from([0.1, 0.2]), SVector::zeros());
        let heavy = Pendulum { m: 2.0, ..PENDULUM };
        let tip: SVector<f64, 2> = heavy.tip(&q, &qd, 0.0);
        let height: f64 = heavy.height(&q, &qd, 0.0);
        let a = heavy.map(|x| x as f32).accel(&q.map(|x| x as f32), &SVector::zeros(), 0.0);
        println!("{tip} {height} {a} {} {}", drift(&heavy), heavy > PENDULUM);
    }
}

// Fields of a system are public.
pub mod visibility_of_a_parameter {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Point {
            pub param m;
            coord x;
            T = 0.5 * m * dot(x).powi(2);
            V = 0;
        }
    }

    pub fn main() {
        println!("{:?}", Point::new(1.0));
    }
}

// Conditional compilation inside the macro.
pub mod conditional_parts {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        #[cfg(test)]
        pub system Oscillator {
            param m, #[cfg(test)] k;
            coord x;
            T = 0.5 * m * dot(x).powi(2);
            #[cfg(test)]
            V = 0.5 * k * x.powi(2);
        }
    }

    pub fn main() {
        let system = Oscillator::new(1.0, 0.5);
        let (q, qd) = (SVector::from([0.1]), SVector::from([0.0]));
        println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
    }
}

// A binding that is to be changed.
pub mod let_mut {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        pub system Pendulum {
            param m, l, g = 9.81;
            coord theta;
            let mut y = -l * theta.cos();
            T = 0.5 * m * (l * dot(theta)).powi(2);
            V = m * g * y;
        }
    }

    pub fn main() {
        let system = Pendulum::new(1.0, 0.5);
        let (q, qd) = (SVector::from([0.1]), SVector::from([0.0]));
        println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
    }
}

// Outputs in a list, an energy as an output, a function of time as a default.
pub mod outputs_and_inputs_of_other_forms {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Point {
            input u = sin(t);
            coord x;
            T = 0.5 * dot(x).powi(2);
            V = u * x;
            observe total = energy;
            observe place = x, speed = dot(x);
        }
    }

    pub fn main() {}
}

// A kind whose `;` was forgotten, a force without its coordinate, and an energy that is given twice.
pub mod kinds_and_forces {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Pendulum {
            param m, l, g = 9.81;
            coord theta: angle
            T = 0.5 * m * (l * dot(theta)).powi(2);
            V = -m * g * l * cos(theta);
            V = 0.5 * theta.powi(2);
            Q = 3 * cos(t);
        }
    }
}

fn main() {}
