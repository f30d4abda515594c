// Constants, parameters, families and functions.

// A function of a constant that has no value there.
pub mod constant_without_value {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        pub system Oscillator {
            param m;
            coord x;
            T = 0.5 * m * dot(x).powi(2);
            V = (1.0 - 3.0).sqrt() * x.powi(2);
        }
    }

    pub fn main() {
        let system = Oscillator::new(1.0);
        let (q, qd) = (SVector::from([0.1]), SVector::from([0.0]));
        println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
    }
}

// A default that is no number.
pub mod default_not_finite {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        pub system Oscillator {
            param m, k = (-1.0).sqrt();
            coord x;
            T = 0.5 * m * dot(x).powi(2);
            V = 0.5 * k * x.powi(2);
        }
    }

    pub fn main() {
        let system = Oscillator::new(1.0);
        let (q, qd) = (SVector::from([0.1]), SVector::from([0.0]));
        println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
    }
}

// A default that depends on another parameter.
pub mod default_of_another_parameter {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        pub system Oscillator {
            param m, k = 4.0 * m;
            coord x;
            T = 0.5 * m * dot(x).powi(2);
            V = 0.5 * k * x.powi(2);
        }
    }

    pub fn main() {
        let system = Oscillator::new(1.0);
        let (q, qd) = (SVector::from([0.1]), SVector::from([0.0]));
        println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
    }
}

// An array as long as a parameter says.
pub mod length_not_constant {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        pub system Chain {
            param m, k, n;
            coord x: [n];
            T = 0.5 * m * x.map(|x| dot(x).powi(2)).sum();
            V = 0.5 * k * x.map(|x| x.powi(2)).sum();
        }
    }

    pub fn main() {
        let system = Chain::new(1.0, 0.5, 3.0);
        let (q, qd) = (SVector::from([0.1, 0.1, 0.1]), SVector::from([0.0, 0.0, 0.0]));
        println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
    }
}

// Arrays of no elements and of less than none.
pub mod no_elements {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        pub system Chain {
            const N = 0;
            param m, k: [-1];
            coord x: [N], y;
            T = 0.5 * m * dot(y).powi(2);
            V = 0.5 * k[0] * y.powi(2);
        }
    }

    pub fn main() {
        let system = Chain::new(1.0, [0.5]);
        let (q, qd) = (SVector::from([0.1]), SVector::from([0.0]));
        println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
    }
}

// An element of a family that uses itself.
pub mod family_of_itself {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        pub system Chain {
            const N = 3;
            param m, l, g = 9.81;
            coord theta: [N];
            let y: [N] = |i| y[i] - l * theta[i].cos();
            T = 0.5 * m * (0..N).map(|i| (l * dot(theta[i])).powi(2)).sum();
            V = m * g * y.sum();
        }
    }

    pub fn main() {
        let system = Chain::new(1.0, 0.5);
        let (q, qd) = (SVector::from([0.1, 0.1, 0.1]), SVector::from([0.0, 0.0, 0.0]));
        println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
    }
}

// An element of a family that uses the one after it.
pub mod family_of_later_elements {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        pub system Chain {
            const N = 3;
            param m, l, g = 9.81;
            coord theta: [N];
            let y: [N] = |i| if i + 1 < N { y[i + 1] } else { 0.0 } - l * theta[i].cos();
            T = 0.5 * m * (0..N).map(|i| (l * dot(theta[i])).powi(2)).sum();
            V = m * g * y.sum();
        }
    }

    pub fn main() {
        let system = Chain::new(1.0, 0.5);
        let (q, qd) = (SVector::from([0.1, 0.1, 0.1]), SVector::from([0.0, 0.0, 0.0]));
        println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
    }
}

// A function that calls itself.
pub mod function_calling_itself {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        pub system Oscillator {
            param m, k;
            coord x;
            fn spring(s) = 0.5 * k * s * s + spring(s / 2);
            T = 0.5 * m * dot(x).powi(2);
            V = spring(x);
        }
    }

    pub fn main() {
        let system = Oscillator::new(1.0, 0.5);
        let (q, qd) = (SVector::from([0.1]), SVector::from([0.0]));
        println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
    }
}

// Two functions that call each other.
pub mod functions_calling_each_other {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        pub system Oscillator {
            param m, k;
            coord x;
            fn spring(s) = 0.5 * k * s * s + stop(s);
            fn stop(s) = spring(s - 1);
            T = 0.5 * m * dot(x).powi(2);
            V = spring(x);
        }
    }

    pub fn main() {
        let system = Oscillator::new(1.0, 0.5);
        let (q, qd) = (SVector::from([0.1]), SVector::from([0.0]));
        println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
    }
}

fn main() {}
