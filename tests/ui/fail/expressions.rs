// Expressions that are none, or have no value.

// An array where a number is expected.
pub mod array_for_a_scalar {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        pub system Chain {
            param m, k;
            coord x: [3];
            T = 0.5 * m * x.map(|x| dot(x).powi(2)).sum();
            V = 0.5 * k + x;
        }
    }

    pub fn main() {
        let system = Chain::new(1.0, 0.5);
        let (q, qd) = (SVector::from([0.1, 0.1, 0.1]), SVector::from([0.0, 0.0, 0.0]));
        println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
    }
}

// A comparison written with one `=`.
pub mod assignment_in_expression {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        pub system Oscillator {
            param m, k;
            coord x;
            T = 0.5 * m * dot(x).powi(2);
            V = if (x = 0.0) { 0.0 } else { 0.5 * k * x.powi(2) };
        }
    }

    pub fn main() {
        let system = Oscillator::new(1.0, 0.5);
        let (q, qd) = (SVector::from([0.1]), SVector::from([0.0]));
        println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
    }
}

// An expression that stops in the middle.
pub mod incomplete_expression {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        pub system Oscillator {
            param m, k;
            coord x;
            T = 0.5 * m * dot(x).powi(2);
            V = 0.5 * k *;
        }
    }

    pub fn main() {
        let system = Oscillator::new(1.0, 0.5);
        let (q, qd) = (SVector::from([0.1]), SVector::from([0.0]));
        println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
    }
}

// An index that depends on the state.
pub mod index_not_constant {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        pub system Chain {
            param m, k: [3];
            coord x: [3];
            T = 0.5 * m * x.map(|x| dot(x).powi(2)).sum();
            V = 0.5 * k[x[0]] * x[0].powi(2);
        }
    }

    pub fn main() {
        let system = Chain::new(1.0, [0.5; 3]);
        let (q, qd) = (SVector::from([0.1, 0.1, 0.1]), SVector::from([0.0, 0.0, 0.0]));
        println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
    }
}

// An index beyond the end of an array.
pub mod index_out_of_range {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        pub system Chain {
            const N = 3;
            param m, k;
            coord x: [N];
            T = 0.5 * m * (0..N).map(|i| dot(x[i]).powi(2)).sum();
            V = 0.5 * k * (0..N).map(|i| (x[i + 1] - x[i]).powi(2)).sum();
        }
    }

    pub fn main() {
        let system = Chain::new(1.0, 0.5);
        let (q, qd) = (SVector::from([0.1, 0.1, 0.1]), SVector::from([0.0, 0.0, 0.0]));
        println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
    }
}

// An index before the beginning of an array.
pub mod negative_index {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        pub system Chain {
            param m, k;
            coord x: [3];
            T = 0.5 * m * x.map(|x| dot(x).powi(2)).sum();
            V = 0.5 * k * x[-1].powi(2);
        }
    }

    pub fn main() {
        let system = Chain::new(1.0, 0.5);
        let (q, qd) = (SVector::from([0.1, 0.1, 0.1]), SVector::from([0.0, 0.0, 0.0]));
        println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
    }
}

// A length that is no integer.
pub mod float_as_length {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        pub system Chain {
            param m, k;
            coord x: [3.0];
            T = 0.5 * m * x.map(|x| dot(x).powi(2)).sum();
            V = 0.5 * k * x.map(|x| x.powi(2)).sum();
        }
    }

    pub fn main() {
        let system = Chain::new(1.0, 0.5);
        let (q, qd) = (SVector::from([0.1, 0.1, 0.1]), SVector::from([0.0, 0.0, 0.0]));
        println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
    }
}

// A quotient of integers, which is 0 in Rust.
pub mod integer_division {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        pub system Oscillator {
            param m, k;
            coord x;
            T = 1 / 2 * m * dot(x).powi(2);
            V = 0.5 * k * x.powi(2);
        }
    }

    pub fn main() {
        let system = Oscillator::new(1.0, 0.5);
        let (q, qd) = (SVector::from([0.1]), SVector::from([0.0]));
        println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
    }
}

// An integer that is no index is divided with a remainder.
pub mod integer_division_with_remainder {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Tree {
            const N = 7;
            coord theta: [N];
            let x: [N] = |i| if i == 0 { 0 } else {
                let parent = (i - 1) / 2;
                x[parent] + theta[i].sin()
            };
            T = (0..N).map(|i| 0.5 * dot(theta[i]).powi(2)).sum();
            V = x[N - 1];
        }
    }

    pub fn main() {
        println!("{}", Tree::<f64>::FACTS.name);
    }
}

// A condition without its other half.
pub mod if_without_else {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        pub system Oscillator {
            param m, k;
            coord x;
            T = 0.5 * m * dot(x).powi(2);
            V = if x > 0.0 { 0.5 * k * x.powi(2) };
        }
    }

    pub fn main() {
        let system = Oscillator::new(1.0, 0.5);
        let (q, qd) = (SVector::from([0.1]), SVector::from([0.0]));
        println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
    }
}

// A literal beyond the numbers of the machine.
pub mod literal_overflow {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        pub system Oscillator {
            param m;
            coord x;
            T = 0.5 * m * dot(x).powi(2);
            V = 1e400 * x.powi(2);
        }
    }

    pub fn main() {
        let system = Oscillator::new(1.0);
        let (q, qd) = (SVector::from([0.1]), SVector::from([0.0]));
        println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
    }
}

// A macro inside an expression.
pub mod macro_in_expression {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        pub system Oscillator {
            param m, k;
            coord x;
            T = 0.5 * m * square!(dot(x));
            V = 0.5 * k * x.powi(2);
        }
    }

    pub fn main() {
        let system = Oscillator::new(1.0, 0.5);
        let (q, qd) = (SVector::from([0.1]), SVector::from([0.0]));
        println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
    }
}

// A power written with `^`.
pub mod power_by_caret {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        pub system Oscillator {
            param m, k;
            coord x;
            T = 0.5 * m * dot(x)^2;
            V = 0.5 * k * x.powi(2);
        }
    }

    pub fn main() {
        let system = Oscillator::new(1.0, 0.5);
        let (q, qd) = (SVector::from([0.1]), SVector::from([0.0]));
        println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
    }
}


pub mod powers_and_suffixes {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Spring {
            param m = 5kg, k, l = 10cm;
            const N = 3x;
            coord x, y: [2m];
            let a = [x, x][1u];
            T = 0.5 * m * dot(x)**2;
            V = 0.5 * k * x**2 + 1e3V;
            D = 0.5 * *k * dot(x).powi(2);
            Q[x] = if true { x } else { 0.5f32 };
            observe pulls = #[inline] x;
            observe length = &x;
        }
    }

    pub fn main() {}
}

// Types where the language has none.
pub mod type_annotation {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        pub system Pendulum {
            param m: f64, l: f64 = 1.0, g = 9.81;
            coord theta;
            fn height(angle: f64) -> f64 = -l * angle.cos();
            T = 0.5 * m * (l * dot(theta)).powi(2);
            V = m * g * height(theta);
        }
    }

    pub fn main() {
        let system = Pendulum::new(1.0);
        let (q, qd) = (SVector::from([0.1]), SVector::from([0.0]));
        println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
    }
}

// Functions with too few or too many arguments.
pub mod wrong_number_of_arguments {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        pub system Oscillator {
            param m, k;
            coord x;
            fn spring(s, stiffness) = 0.5 * stiffness * s * s;
            T = 0.5 * m * dot(x).powi();
            V = spring(x) + sin(x, k);
        }
    }

    pub fn main() {
        let system = Oscillator::new(1.0, 0.5);
        let (q, qd) = (SVector::from([0.1]), SVector::from([0.0]));
        println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
    }
}

// Bounds in the wrong order, and before the number.
pub mod bounds_of_clamp {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        pub system Oscillator {
            param m, k;
            coord x;
            T = 0.5 * m * dot(x).powi(2);
            V = 0;
            Q[x] = (k * x).clamp(1, -1) + clamp(-1, 1, k * x);
        }
    }

    pub fn main() {
        let system = Oscillator::new(1.0, 0.5);
        let (q, qd) = (SVector::from([0.1]), SVector::from([0.0]));
        println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
    }
}

// An integer power with an exponent that is no integer.
pub mod variable_exponent {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        pub system Oscillator {
            param m, k, n;
            coord x;
            T = 0.5 * m * dot(x).powi(2);
            V = k * x.powi(n);
        }
    }

    pub fn main() {
        let system = Oscillator::new(1.0, 0.5, 4.0);
        let (q, qd) = (SVector::from([0.1]), SVector::from([0.0]));
        println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
    }
}

// Parentheses in parentheses, and so on.
pub mod nested_too_deeply {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::SVector;

    lagrangian! {
        pub system Oscillator {
            param m, k;
            coord x;
            T = 0.5 * m * dot(x).powi(2);
            V = k * ((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((x))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))));
        }
    }

    pub fn main() {
        let system = Oscillator::new(1.0, 0.5);
        let (q, qd) = (SVector::from([0.1]), SVector::from([0.0]));
        println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
    }
}

// A system whose expansion has no end worth waiting for.
pub mod too_many_nodes {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Lattice {
            const N = 1000;
            param m, k;
            coord x: [N];
            T = 0.5 * m * (0..N).map(|i| dot(x[i]).powi(2)).sum();
            V = k * (0..N).map(|i| (0..N).map(|j| (x[i] - x[j]).powi(2).sqrt()).sum()).sum();
        }
    }

    pub fn main() {
        let lattice = Lattice::new(1.0, 0.5);
        let rest = lagrange_runtime::SVector::from([0.0; 1000]);
        println!("{}", lattice.accel(&rest, &rest, 0.0)[0]);
    }
}

// Derivatives, constants and products as they are written elsewhere.
pub mod of_other_languages {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Pendulum {
            param m, l;
            const g = 9.81;
            coord theta: angle, x;
            T = 0.5 * m * (l * theta.dot()).powi(2);
            V = -m g * l * cos(theta);
            Q[theta] = ddot(theta);
            Q[x] = 2 (x + 1);
        }
    }
}

// Names that a `let` in a block cannot have.
pub mod names_in_blocks {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Pendulum {
            const N = 2;
            param m;
            coord x;
            T = 0.5 * m * dot(x).powi(2);
            V = { let N = 3.0 * x; N * x };
            Q[x] = { let self = x; x };
        }
    }
}

fn main() {}
