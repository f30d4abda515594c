// Systems with coordinates held.

// Gravity acts across the plane, and so does the spring.
pub mod restriction_of_a_set_that_is_left {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Point {
            param m, k, c, g = 9.81;
            coord x, y, z, w, v;
            T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2) + dot(w).powi(2)) + 0.5 * m * dot(x) * dot(w)
                + 0.5 * m * (1 + v) * dot(v).powi(2) + m * v * dot(x).powi(2);
            V = 0.5 * k * x.powi(2) + m * g * y;
            D = 0.5 * c * (dot(z) - dot(x)).powi(2);
            pub restriction Level: y = 0;
            pub restriction Still: z = 0;
            pub restriction Apart: w = 0;
            pub restriction Slow: v = 0;
        }
    }

    pub fn main() {
        let point = Point::new(1.0, 1.0, 0.1);
        let (level, start) = Level::restrict(&point, &State::new(0.0, [0.0; 5], [0.0; 5])).unwrap();
        println!("{}", level.accel(&start.q, &start.qd, 0.0));
        println!("{}", level.lift(&start).q);
    }
}

// The pendulum rests at 0, and not at 1; who pushes it moves it.
pub mod restriction_to_a_value_where_it_does_not_rest {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Swing {
            param m, l, g = 9.81, F;
            coord theta, phi;
            T = 0.5 * m * l.powi(2) * (dot(theta).powi(2) + dot(phi).powi(2));
            V = -m * g * l * (theta.cos() + phi.cos());
            Q[theta] = F;
            pub restriction Hanging: theta = 0;
            pub restriction Tilted: phi = 1;
        }
    }

    pub fn main() {}
}

// A restriction names coordinates, each once, and leaves some of them free.
pub mod restriction_of_other_things {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Two {
            param m, k;
            input u;
            coord x, y;
            coord s = 0.1 * t.sin();
            coord R: rotation, n: direction;
            state i;
            rate(i) = -i;
            let body_frame = frame(world, [0, 0, 0], R);
            T = 0.5 * m * (dot(x).powi(2) + dot(y + s).powi(2)) + body(m, [1, 1, 1], body_frame) + dot(n).norm_squared();
            V = 0.5 * k * (x.powi(2) + y.powi(2)) + u * x;
            restriction Unknown: z = 0;
            restriction Twice: x = 0, x = 0;
            restriction Parameter: m = 0;
            restriction State: i = 0;
            restriction Turned: R = 0;
            restriction Pointed: n[1] = 0;
            restriction Given: s = 0;
            restriction OfTime: x = t;
            restriction OfOthers: x = y;
            restriction OfRates: x = dot(y);
            restriction OfInputs: x = u;
            restriction Vector: x = [0, 1];
            restriction Element: x[0] = 0;
        }
    }

    pub fn main() {}
}

// Nothing is left to move.
pub mod restriction_of_everything {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Array {
            param m;
            coord x: [3];
            T = 0.5 * m * dot(x).norm_squared();
            V = 0;
            restriction Nothing: x = 0;
            restriction OutOfRange: x[3] = 0;
            restriction TooFew: x = [0, 1];
            restriction Array: x[0] = 0;
            restriction Same: x[0] = 0;
            restriction Same: x[1] = 0;
        }
    }

    pub fn main() {
        let array = Array::new(1.0);
        let (same, start) = Same::restrict(&array, &State::new(0.0, [0.0; 3], [0.0; 3])).unwrap();
        println!("{}", same.accel(&start.q, &start.qd, 0.0));
    }
}

// The words of the statement.
pub mod restriction_that_does_not_parse {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Words {
            param m;
            coord x, y;
            T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
            V = 0;
            restriction Bare;
            restriction Braces { x = 0 };
            restriction NoValue: x;
            restriction Compared: x == 0;
            restriction Empty: ;
        }
    }

    pub fn main() {}
}

// The constraint ties the two, so that one of them moves the other; and a wheel that is held cannot roll.
pub mod restriction_across_constraints {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Tied {
            param m, l;
            coord x, y, z;
            T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2));
            V = m * z;
            constraint rod: x * x + z * z + x * y == l * l;
            restriction Across: y = 0;
            restriction Never: x = 0, z = 0;
        }
    }

    pub fn main() {}
}

// As it is written, L is 0/0 there.
pub mod restriction_to_a_singularity {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Sphere {
            param m;
            coord theta, phi;
            T = 0.5 * m * (dot(phi).powi(2) + (dot(theta) * phi.sin() / phi).powi(2));
            V = 0;
            restriction Equator: phi = 0;
        }
    }

    pub fn main() {}
}

// Moves of simplified systems.
pub mod restrictions_with_moves {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Moves {
            param m, k;
            coord x, y;
            T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
            V = 0.5 * k * (x * x + y * y);
            restriction Locked: lock x = 0;
            restriction Small: expand x to 2 about 0;
            restriction Without: x = 0, neglect k;
        }
    }

    pub fn main() {}
}

fn main() {}
