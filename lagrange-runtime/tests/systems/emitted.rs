//! Systems written in the language, for the tests of methods that need what only the compiler emits: Jacobians.

use lagrange_runtime::prelude::*;

lagrangian! {
    /// Kepler's problem in polar coordinates.
    pub system Kepler {
        param mu;
        coord r, phi;
        T = 0.5 * (dot(r).powi(2) + (r * dot(phi)).powi(2));
        V = -mu / r;
    }
}

lagrangian! {
    /// `q̈ = −ω² (q − cos t) − 2 δ (q̇ + sin t) − cos t`, solved by q = cos t however stiff it is (after Prothero and
    /// Robinson 1974).
    pub system Driven {
        param omega, delta;
        coord q;
        T = 0.5 * dot(q).powi(2);
        V = 0.5 * omega.powi(2) * (q - cos(t)).powi(2);
        Q[q] = -2 * delta * (dot(q) + sin(t)) - cos(t);
    }
}

/// The slow solution of [`Driven`].
pub fn cosine(t: f64) -> State<f64, 1> {
    State::new(t, [t.cos()], [-t.sin()])
}

lagrangian! {
    /// `q̈ = k q`.
    pub system Repelled {
        param k;
        coord q;
        T = 0.5 * dot(q).powi(2);
        V = -0.5 * k * q.powi(2);
    }
}

lagrangian! {
    /// A point that moves freely, with a wave of its place that has a kink.
    pub system Wave {
        param omega, phase, tilt, vertex, bend, kink, strength, level;
        coord q;
        T = 0.5 * dot(q).powi(2);
        V = 0;
        event wave: sin(omega * q + phase) + tilt * q + bend * (q - vertex).powi(2) + strength * abs(q - kink) - level;
    }
}

lagrangian! {
    /// Under a force of constant size towards 0.
    pub system Wedge {
        param g;
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = g * x.abs();
    }
}

lagrangian! {
    /// A body on a spring, with dry friction.
    pub system Block {
        param k, mu;
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = 0.5 * k * x * x;
        Q[x] = -mu * signum(dot(x));
    }
}

lagrangian! {
    /// A ball above a spring.
    pub system Landing {
        param k, g = 9.81;
        coord y;
        T = 0.5 * dot(y).powi(2);
        V = g * y + 0.5 * k * max(-y, 0).powi(2);
    }
}

lagrangian! {
    /// A ball in air, whose drag is c |v| v.
    pub system Ball {
        param c, g = 9.81;
        coord x, y;
        let v = [dot(x), dot(y)];
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = g * y;
        force -c * v.norm() * v at [x, y];
    }
}

lagrangian! {
    /// A pendulum in Cartesian coordinates.
    pub system Bob {
        param l = 1, g = 9.81;
        coord x, y;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = g * y;
        constraint rod: x * x + y * y == l * l;
    }
}

lagrangian! {
    /// A pendulum, m = l = 1.
    pub system Swing {
        param g = 1.0;
        coord theta;
        T = 0.5 * dot(theta).powi(2);
        V = -g * cos(theta);
    }
}

lagrangian! {
    /// Two equal pendulums of length 1 in a row.
    pub system TwoPendulums {
        param g;
        coord a, b;
        T = dot(a).powi(2) + dot(a) * dot(b) * cos(a - b) + 0.5 * dot(b).powi(2);
        V = -g * (2 * cos(a) + cos(b));
    }
}

lagrangian! {
    /// Heavy symmetric top: φ precession, θ inclination, ψ spin. φ and ψ are ignorable.
    pub system Top {
        param mgl, I1, I3;
        coord phi, theta, psi;
        let spin = dot(psi) + dot(phi) * cos(theta);
        T = 0.5 * I1 * (dot(theta).powi(2) + (dot(phi) * sin(theta)).powi(2)) + 0.5 * I3 * spin.powi(2);
        V = mgl * cos(theta);
    }
}

/// A nutating top.
pub const TOP: State<f64, 3> =
    State { t: 0.0, q: SVector::<f64, 3>::new(0.0, 0.6, 0.0), qd: SVector::<f64, 3>::new(0.3, 0.1, 8.0) };

lagrangian! {
    /// A particle near the speed of light c in a potential: L is not quadratic in the velocity.
    pub system Relativistic {
        param c, k;
        coord x;
        L = -c.powi(2) * sqrt(1 - (dot(x) / c).powi(2)) - 0.5 * k * x.powi(2);
    }
}

lagrangian! {
    /// An oscillator with linear damping and a force of time: `q̈ = −q − 2 δ q̇ + f cos t`.
    pub system Forced {
        param delta, f;
        coord q;
        T = 0.5 * dot(q).powi(2);
        V = 0.5 * q.powi(2);
        D = delta * dot(q).powi(2);
        Q[q] = f * cos(t);
    }
}

/// The forced oscillator at time t from rest at the origin, by its closed form for δ < 1.
pub fn forced(delta: f64, f: f64, t: f64) -> State<f64, 1> {
    // q = (f/2δ) sin t solves it; what is left decays as e^(−δt) with ν = √(1 − δ²).
    let nu = (1.0 - delta * delta).sqrt();
    let amplitude = f / (2.0 * delta);
    let (s, c) = (nu * t).sin_cos();
    let decay = (-delta * t).exp() * amplitude / nu;
    let q = amplitude * t.sin() - decay * s;
    let qd = amplitude * t.cos() - decay * (nu * c - delta * s);
    State::new(t, [q], [qd])
}
