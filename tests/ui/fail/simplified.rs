// Systems with simpler energies.

// Each move takes too much, or nothing.
pub mod simplified_too_much {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Two {
            param m1, m2, k, b, c, g = 9.81;
            coord x, y;
            let stiff = 0.5 * k * x.powi(2);
            let twist = 0 * x * y;
            T = 0.5 * m1 * dot(x).powi(2) + 0.5 * m2 * dot(y).powi(2);
            V = stiff + 0.25 * b * y.powi(4) + m1 / m2 * g * x;
            pub simplified NoMass: neglect m1;
            pub simplified Useless: neglect c, neglect g;
            pub simplified NoSpring: neglect stiff;
            pub simplified NoQuartic: expand y to 2 about 0;
            pub simplified Divided: neglect m2;
            pub simplified Stretched: lock x = m1 * g / k, neglect k;
            pub simplified Nothing: neglect twist;
            pub simplified Order: expand x to 2 about 0;
            pub simplified Undamped: neglect dissipation;
            pub simplified Straight: neglect gyroscopic;
            pub simplified Constant: inertia at x = 0;
        }
    }

    pub fn main() {
        let two = Two::new(1.0, 1.0, 1.0, 1.0, 0.0);
        let (small, start) = NoMass::restrict(&two, &State::new(0.0, [0.0; 2], [0.0; 2])).unwrap();
        println!("{}", small.accel(&start.q, &start.qd, 0.0));
        let (small, start) = Divided::restrict(&two, &State::new(0.0, [0.0; 2], [0.0; 2])).unwrap();
        println!("{}", small.accel(&start.q, &start.qd, 0.0));
    }
}

// What is expanded has derivatives, and statics determine what follows.
pub mod simplified_where_it_cannot_be {
    use lagrange_runtime::prelude::*;

    fn wind<S: Scalar>(x: S) -> S {
        x * x
    }

    lagrangian! {
        pub system Rough {
            param m, k;
            input u;
            coord x, y, z, w;
            state i;
            rate(i) = -i;
            extern fn wind(x);
            T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2) + dot(w).powi(2));
            V = k * x.abs() + (y * y + z * z).sqrt() + 0.5 * w * w + if x > y { x } else { y } + (u + i) * w + z.powi(4);
            Q[z] = wind(w);
            pub simplified Kink: expand x to 2 about 0;
            pub simplified Cone: expand [y, z] to 2 about 0;
            pub simplified Choice: expand y to 2 about 1;
            pub simplified Blown: expand w to 3 about 0;
            pub simplified Quartic: quasistatic z;
            pub simplified Jumping: quasistatic w;
            pub simplified Floating: quasistatic y;
        }
    }

    pub fn main() {}
}

// A mean is that of sines and cosines of one phase.
pub mod simplified_by_a_mean {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Shaken {
            param m, l, a, omega, nu, g = 9.81;
            coord x, y, z;
            coord s = a * (omega * t).sin();
            coord r = a * (nu * t).sin();
            T = 0.5 * m * (dot(x).powi(2) + dot(y + s).powi(2)) + 0.5 * (m + s) * dot(z).powi(2);
            V = m * g * y + 0.5 * (x - r).powi(2) + z * z;
            Q[x] = -dot(x).abs() * dot(x);
            simplified Constant: average omega;
            simplified Late: average omega * t + 1;
            simplified Square: average omega * t * t;
            simplified Moving: average x * t;
        }
    }

    pub fn main() {}
}

// One phase, and what has a mean.
pub mod simplified_without_a_mean {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Shaken {
            param m, a, omega, nu, g = 9.81;
            coord x, y, z;
            coord s = a * (omega * t).sin();
            coord r = a * (nu * t).sin();
            T = 0.5 * m * (dot(x).powi(2) + dot(y + s).powi(2)) + 0.5 * (m + s) * dot(z).powi(2);
            V = m * g * y + 0.5 * (x - r).powi(2) + z * z;
            Q[x] = -dot(x).abs() * dot(x);
            Q[y] = s * y;
            simplified Mass: average omega * t;
            simplified TwoPhases: lock z = 0, average omega * t;
            simplified Drag: lock z = 0, lock y = 0, average nu * t;
            simplified Other: lock z = 0, lock y = 0, average m * t;
            simplified Pushed: lock x = 0, lock z = 0, average omega * t;
        }
    }

    pub fn main() {}
}

// Multipliers are of the exact constraint.
pub mod simplified_with_constraints {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Rod {
            param m, l, g = 9.81;
            coord x, y, z;
            T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2));
            V = m * g * y + 0.5 * z * z;
            constraint rod: x * x + y * y == l * l;
            pub simplified Small: expand x to 2 about 0;
            pub simplified Slow: quasistatic y;
        }
    }

    pub fn main() {}
}

// An expansion to a high order in many coordinates is dearer than their sines.
pub mod simplified_at_a_price {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Pair {
            param m, l, g = 9.81;
            coord a, b, c, d;
            T = 0.5 * m * l.powi(2) * (dot(a).powi(2) + dot(b).powi(2) + dot(c).powi(2) + dot(d).powi(2));
            V = -m * g * l * a.cos() * b.cos() * c.cos() * d.cos();
            pub simplified Eighth: expand [a, b, c, d] to 8 about 0;
        }
    }

    pub fn main() {}
}

// The words of the statement.
pub mod simplified_that_does_not_parse {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Words {
            param m, k;
            coord x, y;
            coord s = t.sin();
            let sides = [x, y];
            let link = frame(world, [x, y]);
            T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
            V = 0.5 * k * (x * x + y * y) + k * x * s + sides[0];
            simplified Bare;
            simplified Unknown: neglekt k;
            simplified Held: x = 0;
            simplified Number: 3;
            simplified NoName: neglect 3;
            simplified Missing: neglect kk;
            simplified Coordinate: neglect x;
            simplified Motion: neglect s;
            simplified Frame: neglect link;
            simplified NoOrder: expand x about 0;
            simplified NoPlace: expand x to 2;
            simplified First: expand x to 1 about 0;
            simplified Half: expand x to 2.5 about 0;
            simplified Other: expand z to 2 about 0;
            simplified Twice: expand [x, x] to 2 about 0;
            simplified Gone: lock x = 0, expand x to 2 about 0;
            simplified All: lock x = 0, quasistatic y;
            simplified NoAt: inertia x = 0;
            simplified Words: neglect k;
        }
    }

    pub fn main() {}
}

// Friction has no statics.
pub mod simplified_by_statics_with_friction {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Rubbed {
            param m, k, c;
            coord x, y, z;
            T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2));
            V = 0.5 * k * (x * x + y * y + z * z);
            Q[x] = -c * dot(x).signum();
            pub simplified Held: quasistatic x;
        }
    }

    pub fn main() {}
}

// What is left of a kinetic energy is one.
pub mod simplified_to_a_negative_energy {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Coupled {
            param m;
            coord x, y;
            let small = 0.5 * m * dot(y).powi(2);
            T = 0.5 * m * dot(x).powi(2) + 0.9 * m * dot(x) * dot(y) + small;
            V = 0.5 * (x * x + y * y);
            pub simplified Light: neglect small;
        }
    }

    pub fn main() {}
}

// Coordinates that are held where the constraints do not let them be.
pub mod simplified_against_constraints {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Bead {
            param m, g;
            coord x, y, z;
            T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2));
            V = m * g * z;
            constraint wall: x == 1;
            constraint ramp: y + z == 2;
            simplified Inside: lock x = 0;
            simplified Below: lock y = 0, lock z = 0;
        }
    }

    pub fn main() {}
}

// Derived systems name the whole one.
pub mod simplified_of_a_private_system {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        system Private {
            param m, k;
            coord x, y;
            T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
            V = 0.5 * k * (x * x + y * y * x);
            pub simplified Held: lock y = 0;
        }
    }

    pub fn main() {}
}

// What follows a rotation.
pub mod statics_of_a_rotation {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Sprung {
            param k = 50;
            coord R: rotation, s;
            let hub = frame(world, [0, 0, 0], R);
            T = body(1, [0.3, 0.4, 0.5], hub) + 0.5 * dot(s).powi(2);
            V = 0.5 * k * s.powi(2) + 3 * s * hub.vector([0, 0, 1])[2];
            pub simplified Slow: quasistatic s;
        }
    }

    pub fn main() {}
}

// A mean over a phase that nothing moves with, and a second one over the same.
pub mod means_of_nothing {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Pendulum {
            param m, l, a, omega, g = 9.81;
            coord theta: angle;
            T = 0.5 * m * (l * dot(theta)).powi(2) - m * l * a * omega.powi(2) * cos(omega * t) * cos(theta);
            V = -m * g * l * cos(theta);
            pub simplified Slow: average omega * t, average omega * t;
        }
    }

    lagrangian! {
        pub system Still {
            param m, l, omega, g = 9.81;
            coord theta: angle;
            T = 0.5 * m * (l * dot(theta)).powi(2);
            V = -m * g * l * cos(theta);
            pub simplified Same: average omega * t;
        }
    }
}

// Places where an energy has a pole or leaves its domain.
pub mod expansions_at_poles {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Poles {
            param m, k, b;
            coord x, y, z;
            T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2));
            V = k / x + k * (y - b).ln() + k * sqrt(z) + k * (x * x + y * y + z * z);
            pub simplified Pole: expand x to 2 about 0;
            pub simplified Logarithm: expand y to 2 about b;
            pub simplified Root: expand z to 2 about 0;
            pub simplified Domain: expand z to 2 about -1;
        }
    }
}

// Words of books for these moves, and moves that are not separated.
pub mod other_words {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Others {
            param m, k;
            coord x, y;
            T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
            V = 0.5 * k * (x * x + y * y);
            D = 0.1 * dot(x).powi(2);
            simplified Held: hold x = 0;
            simplified Linear: linearize x about 0;
            simplified Dropped: drop k;
            simplified Listed: neglect [k, m];
            simplified Energy: neglect V;
            simplified Friction: neglect damping;
            simplified Both: lock x = 0 neglect k;
            simplified Value: quasistatic x = 0;
            simplified Place: inertia at x = 0, y = 1;
        }
    }
}

fn main() {}
