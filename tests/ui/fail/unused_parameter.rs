// A parameter that nothing depends on is a warning; one whose name begins with `_` is meant to be so. Terms of L that
// are a total time derivative are in no equation.
#![deny(warnings)]
use lagrange_runtime::prelude::*;
use lagrange_runtime::SVector;

lagrangian! {
    pub system Pendulum {
        param m, l, g = 9.81, damping, _spare = 1.0;
        coord theta;
        T = 0.5 * m * (l * dot(theta)).powi(2);
        V = -m * g * l * theta.cos();
    }
}

lagrangian! {
    pub system Damped {
        param m, k, c, b, s, a, _d, e;
        coord x, y;
        L = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2)) - (0.5 * k * x.powi(2) - c * dot(x))
            + b * (y * dot(x) + x * dot(y))
            + s * dot(sin(x * y))
            + a * (x * dot(y) - y * dot(x))
            + _d * dot(x)
            + e * dot(x);
        observe scaled = e * x;
    }
}

lagrangian! {
    pub system Level {
        param m, v, height;
        coord x;
        coord belt = v * t;
        T = 0.5 * m * (dot(x) + dot(belt)).powi(2);
        V = m * (x + height);
    }
}

// Momenta that jump: of a mass that is picked up, of one on a base that starts to move, of an inertia that changes. That
// of a slope has a kink. A potential with a step, and one that changes with time.
lagrangian! {
    pub system PickUp {
        param m1, m2, gap;
        coord x;
        let y = max(x - gap, 0);
        T = 0.5 * m1 * dot(x).powi(2) + 0.5 * m2 * dot(y).powi(2);
        V = 0;
    }
}

lagrangian! {
    pub system Base {
        param m, k;
        coord x;
        coord p = 0.5 * max(t - 1, 0);
        T = 0.5 * m * (dot(x) + dot(p)).powi(2);
        V = 0.5 * k * x * x;
    }
}

lagrangian! {
    pub system Gear {
        param m;
        coord x;
        T = 0.5 * m * if x > 0 { 3 } else { 1 } * dot(x).powi(2);
        V = x;
    }
}

lagrangian! {
    pub system Slope {
        param m;
        coord x;
        T = 0.5 * m * (1 + abs(x - 0.3)) * dot(x).powi(2);
        V = x;
    }
}

lagrangian! {
    pub system Step {
        param m, h;
        coord x, y;
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
        V = if x + y > 20 { h } else { if t > 1 { x } else { 0 } };
    }
}

lagrangian! {
    pub system Whole {
        param h;
        coord x;
        L = 0.5 * dot(x).powi(2) - h * signum(x - 100);
    }
}

// Energies and forces with `let` are none.
lagrangian! {
    pub system Bound {
        param m, c;
        coord x;
        let twice = 2 * x;
        let _spare = 3 * x;
        T = 0.5 * m * dot(x).powi(2);
        V = 0.5 * x.powi(2);
        let D = 0.5 * c * dot(x).powi(2);
        let Q = -c * dot(x);
    }
}

// Moments of inertia that no body has.
lagrangian! {
    pub system Spinning {
        coord a;
        T = body(1, [1, 1, 2.5], frame(world, [0, 0, 0], rotation_x(a))) + body(1, [1, 1, 2], frame(world, [0, 0, 1], rotation_x(a)));
        V = 0;
    }
}

// Kinetic energies that are negative for some velocities.
lagrangian! {
    pub system Lighter {
        param m = -1;
        coord x;
        T = 0.5 * m * dot(x).powi(2);
        V = x.powi(2);
    }
}

lagrangian! {
    pub system Coupled {
        param m;
        coord x, y;
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2)) + 2 * m * dot(x) * dot(y);
        V = x.powi(2);
    }
}

fn main() {
    let system = Pendulum::new(1.0, 0.5, 0.1);
    let (q, qd) = (SVector::from([0.1]), SVector::from([0.0]));
    println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
}
