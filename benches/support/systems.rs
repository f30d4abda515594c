//! The systems that several benchmarks measure, so that all measure the same.

use lagrange_runtime::prelude::*;

lagrangian! {
    pub system Pendulum {
        param m, l, g;
        coord theta;
        T = 0.5 * m * (l * dot(theta)).powi(2);
        V = -m * g * l * cos(theta);
    }
}

lagrangian! {
    pub system Kepler {
        param m, mu;
        coord r, phi;
        T = 0.5 * m * (dot(r).powi(2) + (r * dot(phi)).powi(2));
        V = -mu * m / r;
    }
}

lagrangian! {
    pub system DoublePendulum {
        param m1, m2, l1, l2, g;
        coord a, b;
        let x1 = l1 * a.sin();
        let y1 = -l1 * a.cos();
        let x2 = x1 + l2 * b.sin();
        let y2 = y1 - l2 * b.cos();
        T = 0.5 * m1 * (dot(x1).powi(2) + dot(y1).powi(2)) + 0.5 * m2 * (dot(x2).powi(2) + dot(y2).powi(2));
        V = m1 * g * y1 + m2 * g * y2;
    }
}
