// Words and habits of control engineers.

// A velocity in the potential energy is meant as friction; events end the run.
pub mod friction {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Cart {
            param m, k, c;
            coord x, y;
            T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
            V = 0.5 * k * x.powi(2) - c * dot(y);
            event stop: abs(x) > 2, terminal;
            event back: x < 1, rising, terminal;
            event low: dot(x) >= k + 1;
        }
    }
}

// Blocks of Simulink and functions of Matlab.
pub mod blocks {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Cart {
            param m;
            input u;
            coord x;
            T = 0.5 * m * dot(x).powi(2);
            V = 0;
            let a = sat(u, -1, 1);
            let b = saturate(u, 1);
            let c = deadzone(u, 0.1);
            let d = interp1(x);
            let e = lookup(x, t);
            let f = delay(u, 0.1);
            let g = integral(u);
            Q[x] = a + b + c + d + e + f + g + u.saturate(-1, 1);
        }
    }
}

// Declarations with the colon of a scope, and with units.
pub mod declarations {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Cart {
            param m;
            coord x: meter, phi: deg, z: m, R: quaternion, w: knot;
            let both: x + phi;
            T = 0.5 * m * (dot(x).powi(2) + dot(phi).powi(2) + dot(z).powi(2) + dot(w).powi(2));
            V = 0;
            observe y: x;
            observe tip: [x, both];
            observe p: f64 = x;
        }
    }
}

// Inputs are values, and prescribe no motion.
pub mod inputs {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Drive {
            param m, k;
            input u, v;
            coord x;
            coord p = u;
            coord r = 2 * v + k;
            coord s = k;
            T = 0.5 * m * dot(x).powi(2);
            V = 0.5 * k(t) * (x - p).powi(2);
            Q[x] = u(t) + v(0);
        }
    }
}

// An accelerometer.
pub mod accelerometer {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Cart {
            param m, k;
            coord x;
            let v = dot(x);
            T = 0.5 * m * v.powi(2);
            V = 0.5 * k * x.powi(2);
            observe a = dot(dot(x));
            observe b = dot(v);
            event jolt: dot(v) - 1;
            Q[x] = -m * dot(v);
        }
    }
}

// A name that no system may have does not hide the other mistakes.
pub mod names {
    lagrange_runtime::lagrangian! {
        pub system S {
            param m;
            coord x;
            T = 0.5 * m * dot(x).powi(2);
            V = 0.5 * k * x.powi(2);
            routhian f64;
            Q[y] = 1;
        }
    }
}

// A control law in a system.
pub mod laws {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Cart {
            input u;
            coord x;
            T = 0.5 * dot(x).powi(2);
            V = 0;
            Q[x] = u;
            every 0.01: u = -x;
        }
    }
}

fn main() {}
