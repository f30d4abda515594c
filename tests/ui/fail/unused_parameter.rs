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

fn main() {
    let system = Pendulum::new(1.0, 0.5, 0.1);
    let (q, qd) = (SVector::from([0.1]), SVector::from([0.0]));
    println!("{} {}", system.accel(&q, &qd, 0.0), system.energy(&q, &qd, 0.0));
}
