// States of first order that are none.

// Each state has one rate, and rates are of states.
pub mod rates {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Motor {
            param k, r;
            coord theta;
            state i, j, z: [2];
            T = 0.5 * dot(theta).powi(2);
            V = 0;
            Q[theta] = k * i + z[0] + z[1];
            rate(i) = -r * i;
            rate(i) = k * dot(theta);
            rate(theta) = 1;
            rate(curent) = 1;
            rate(z[0]) = 1;
            rate(z[2]) = 1;
            rate(i[0]) = 1;
            Q[j] = 1;
        }
    }
}

// As many rates as states.
pub mod lengths {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Filter {
            coord x;
            state z: [2];
            T = 0.5 * dot(x).powi(2);
            V = 0;
            Q[x] = z[0];
            rate(z) = [x, z[0], z[1]];
        }
    }
}

// Without a rate a state is a parameter.
pub mod missing {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Filter {
            coord x;
            state z: [2], w;
            T = 0.5 * dot(x).powi(2);
            V = 0;
            Q[x] = z[0] + w;
            rate(z[0]) = x - z[0];
        }
    }
}

// Positions and inertia do not depend on states, and the rates of these are no terms.
pub mod positions {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Rocket {
            param k;
            coord x, y;
            coord driven = k * t + fuel;
            state fuel = 1.0;
            let nozzle = x - fuel;
            let arm = frame(world, [x, fuel], y);
            T = 0.5 * (1 + fuel) * (dot(x).powi(2) + dot(y).powi(2));
            V = 0;
            Q[x] = dot(fuel);
            Q[y] = dot(nozzle);
            force [k] at [nozzle];
            constraint rod: x * y == fuel;
            rate(fuel) = -k + driven;
        }
    }
}

// Nor do momenta of a whole L.
pub mod momenta {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Rocket {
            param k;
            coord x;
            state fuel = 1.0;
            L = 0.5 * (1 + fuel) * dot(x).powi(2);
            rate(fuel) = -k;
        }
    }
}

// Names, initial values, and the forms of the statements.
pub mod forms {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Filter {
            param m;
            coord x;
            state x;
            state start;
            state a = m, b: [2] = [1, 2, 3], c(0), d: angle;
            T = 0.5 * m * dot(x).powi(2);
            V = 0;
            rate a = x;
            rate(b) -= x;
            observe d = x;
        }
    }
}

// A state is not ignorable, and is not reduced.
pub mod reduced {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Wheel {
            coord x, phi;
            state i;
            T = 0.5 * (dot(x).powi(2) + dot(phi).powi(2));
            V = 0.5 * x.powi(2);
            Q[x] = i;
            rate(i) = -i;
            routhian Still;
        }
    }
}

// Notation of other languages: a rate is no derivative that is set.
pub mod rate_by_dot {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Lag {
            coord x;
            state z;
            T = 0.5 * dot(x).powi(2);
            V = 0;
            Q[x] = z;
            dot(z) = -z;
        }
    }
}

// A coordinate without inertia beside a state, which has none either.
pub mod without_inertia {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Rod {
            coord a, b;
            state i;
            T = 0.5 * dot(a).powi(2) + dot(a) * dot(b) * 0;
            V = 0;
            Q[a] = i;
            rate(i) = -i;
            constraint rod: sin(a) == 2 * sin(b);
        }
    }
}

fn main() {}
