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
    /// A planet of unit mass, in polar coordinates. The inertia r² of φ depends on r, so it is not separable.
    pub system Kepler {
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
