//! The systems, as a user writes them.

use lagrange_runtime::prelude::*;

lagrangian! {
    /// An undamped oscillator.
    pub system Oscillator {
        param omega;
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = 0.5 * (omega * x).powi(2);
    }
}

lagrangian! {
    /// A spring beside a damper.
    pub system Damped {
        param c, k;
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = 0.5 * k * x.powi(2);
        D = 0.5 * c * dot(x).powi(2);
    }
}

lagrangian! {
    /// A unit mass on a stiff spring of length 1, in polar coordinates.
    pub system SpringPendulum {
        param k, g;
        coord r, theta;
        T = 0.5 * (dot(r).powi(2) + (r * dot(theta)).powi(2));
        V = 0.5 * k * (r - 1).powi(2) - g * r * cos(theta);
    }
}

lagrangian! {
    /// A planet, in Cartesian coordinates.
    pub system Kepler {
        param mu;
        coord x, y;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = -mu / sqrt(x.powi(2) + y.powi(2));
    }
}

lagrangian! {
    /// A spherical pendulum of unit mass and length; θ is the angle from the downward vertical, and a pole.
    pub system Spherical {
        param g;
        coord theta, phi;
        T = 0.5 * (dot(theta).powi(2) + (sin(theta) * dot(phi)).powi(2));
        V = -g * cos(theta);
    }
}

lagrangian! {
    /// A heavy symmetric top on its tip: precession, inclination, spin.
    pub system Top {
        param mgl, I1, I3;
        coord phi, theta, psi;
        let spin = dot(psi) + dot(phi) * cos(theta);
        T = 0.5 * I1 * (dot(theta).powi(2) + (dot(phi) * sin(theta)).powi(2)) + 0.5 * I3 * spin.powi(2);
        V = mgl * cos(theta);
    }
}

lagrangian! {
    /// A pendulum of unit length whose pivot is shaken vertically; θ from the downward vertical.
    pub system Kapitza {
        param a, omega, g;
        coord theta;
        let x = sin(theta);
        let y = a * cos(omega * t) - cos(theta);
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = g * y;
    }
}

lagrangian! {
    /// A double pendulum.
    pub system DoublePendulum {
        param m1, m2, l1 = 1, l2 = 1, g = 1;
        coord a, b;
        let x1 = l1 * sin(a);
        let y1 = -l1 * cos(a);
        let x2 = x1 + l2 * sin(b);
        let y2 = y1 - l2 * cos(b);
        T = 0.5 * m1 * (dot(x1).powi(2) + dot(y1).powi(2)) + 0.5 * m2 * (dot(x2).powi(2) + dot(y2).powi(2));
        V = m1 * g * y1 + m2 * g * y2;
    }
}

lagrangian! {
    /// A force that runs away.
    pub system Runaway {
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = -x.powi(4);
    }
}

lagrangian! {
    /// A body on its point, whose mass centre is on its third axis.
    pub system Body {
        param A, B, C, w;
        coord R: rotation;
        T = body(0, [A, B, C], frame(world, [0, 0, 0], R));
        V = w * (R * [0, 0, 1])[2];
    }
}

lagrangian! {
    /// A parallelogram of uniform bars of unit mass and length: two cranks at (0, 0) and (1, 0), and the coupler
    /// between them.
    pub system Parallelogram {
        param g;
        coord a0, a1, b;
        let x = cos(a0) + 0.5 * cos(b);
        let y = sin(a0) + 0.5 * sin(b);
        T = (dot(a0).powi(2) + dot(a1).powi(2)) / 6 + 0.5 * (dot(x).powi(2) + dot(y).powi(2)) + dot(b).powi(2) / 24;
        V = g * (0.5 * sin(a0) + 0.5 * sin(a1) + y);
        constraint horizontal: cos(a0) + cos(b) == cos(a1) + 1;
        constraint vertical: sin(a0) + sin(b) == sin(a1);
    }
}

lagrangian! {
    /// Two such parallelograms side by side: cranks at (0, 0), (1, 0) and (2, 0).
    pub system TwoParallelograms {
        param g;
        coord a: [3], b: [2];
        let x: [2] = |i| i + cos(a[i]) + 0.5 * cos(b[i]);
        let y: [2] = |i| sin(a[i]) + 0.5 * sin(b[i]);
        T = (0..3).map(|i| dot(a[i]).powi(2)).sum() / 6
            + (0..2).map(|i| 0.5 * (dot(x[i]).powi(2) + dot(y[i]).powi(2)) + dot(b[i]).powi(2) / 24).sum();
        V = g * (0.5 * (0..3).map(|i| sin(a[i])).sum() + (0..2).map(|i| y[i]).sum());
        constraint horizontal: [2] = |i| cos(a[i]) + cos(b[i]) == cos(a[i + 1]) + 1;
        constraint vertical: [2] = |i| sin(a[i]) + sin(b[i]) == sin(a[i + 1]);
    }
}

lagrangian! {
    /// A wheel that rolls on a plane, with moments of inertia k m r² about its axle and h m r² across. ψ, heading; φ,
    /// lean; θ, turn.
    pub system Wheel {
        param m, r, k, h, g = 9.81;
        coord x, y, psi: angle, phi: angle, theta: angle;
        let lean = frame(world, [x, y, 0], rotation_z(psi) * rotation_x(phi));
        let hub = frame(lean, [0, 0, r]);
        let w = angular_velocity(hub);
        T = 0.5 * m * r.powi(2) * (h * (w[0] * w[0] + w[2] * w[2]) + k * (w[1] + dot(theta)).powi(2)) + particle(m, hub);
        V = m * g * r * cos(phi);
        constraint rolling: [dot(x), dot(y)] == [r * dot(theta) * cos(psi), r * dot(theta) * sin(psi)];
    }
}

lagrangian! {
    /// The parallelogram by the ends of its coupler.
    pub system ParallelogramByPoints {
        param g;
        coord x: [2], y: [2];
        T = (0..2).map(|i| dot(x[i]).powi(2) + dot(y[i]).powi(2)).sum() / 3
            + (dot(x[0]) * dot(x[1]) + dot(y[0]) * dot(y[1])) / 6;
        V = g * (y[0] + y[1]);
        constraint crank: [2] = |i| (x[i] - i).powi(2) + y[i].powi(2) == 1;
        constraint coupler: (x[1] - x[0]).powi(2) + (y[1] - y[0]).powi(2) == 1;
    }
}
