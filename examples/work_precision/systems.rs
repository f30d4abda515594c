//! The systems, as a user writes them.

use lagrange_runtime::prelude::*;

lagrangian! {
    /// A mass on a light rod. Separable: constant inertia, and a force of position alone.
    pub system Pendulum {
        param m, l, g = 9.81;
        coord theta;
        T = 0.5 * m * (l * dot(theta)).powi(2);
        V = -m * g * l * cos(theta);
    }
}

lagrangian! {
    /// A planet of unit mass.
    pub system Kepler {
        param mu;
        coord x, y;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = -mu / (x.powi(2) + y.powi(2)).sqrt();
    }
}

lagrangian! {
    /// The same in polar coordinates. The inertia r² of φ depends on r, so it is not separable, but φ is ignorable.
    pub system PolarKepler {
        param mu;
        coord r, phi;
        T = 0.5 * (dot(r).powi(2) + (r * dot(phi)).powi(2));
        V = -mu / r;
    }
}

lagrangian! {
    /// A double pendulum, by the positions of its bobs.
    pub system DoublePendulum {
        param m1, m2, l1, l2, g = 9.81;
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
    /// A heavy symmetric top on its tip, by Euler's angles: precession, inclination, spin.
    pub system Top {
        param m, l, I1, I3, g = 9.81;
        coord phi, theta, psi;
        let spin = dot(psi) + dot(phi) * cos(theta);
        T = 0.5 * I1 * (dot(theta).powi(2) + (dot(phi) * sin(theta)).powi(2)) + 0.5 * I3 * spin.powi(2);
        V = m * g * l * cos(theta);
    }
}

lagrangian! {
    /// A star in a galaxy's meridian plane (Hénon and Heiles, Astronomical Journal 69, 1964, 73).
    pub system HenonHeiles {
        param lambda;
        coord x, y;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = 0.5 * (x.powi(2) + y.powi(2)) + lambda * (x.powi(2) * y - y.powi(3) / 3);
    }
}

lagrangian! {
    /// A bob on a spring.
    pub system SpringPendulum {
        param m, k, l, g;
        coord x, y;
        let r = (x.powi(2) + y.powi(2)).sqrt();
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
        V = 0.5 * k * (r - l).powi(2) + m * g * y;
    }
}

lagrangian! {
    /// A pendulum with friction in its pivot, and a torque on it.
    pub system DrivenPendulum {
        param m, l, g, c, a, omega;
        coord theta;
        T = 0.5 * m * (l * dot(theta)).powi(2);
        V = -m * g * l * cos(theta);
        D = 0.5 * c * dot(theta).powi(2);
        Q[theta] = a * cos(omega * t);
    }
}

/// Masses of the chain.
pub const LINKS: usize = 8;

lagrangian! {
    /// Equal masses in a row between two walls, joined by equal springs.
    pub system Chain {
        const N = 8;
        param m, k;
        coord x: [N];
        T = (0..N).map(|i| 0.5 * m * dot(x[i]).powi(2)).sum();
        V = 0.5 * k * (x[0].powi(2) + x[N - 1].powi(2) + (1..N).map(|i| (x[i] - x[i - 1]).powi(2)).sum());
    }
}
