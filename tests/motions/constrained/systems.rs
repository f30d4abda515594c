//! Systems with constraints, and the same in independent coordinates where there are any.

use lagrange_runtime::prelude::*;

lagrangian! {
    /// Two bobs on rods, by their places.
    pub system Bobs {
        param m1, m2, l1, l2, c, g = 9.81;
        coord p: [2], q: [2];
        T = 0.5 * m1 * (dot(p[0]).powi(2) + dot(p[1]).powi(2)) + 0.5 * m2 * (dot(q[0]).powi(2) + dot(q[1]).powi(2));
        V = g * (m1 * p[1] + m2 * q[1]);
        D = 0.5 * c * (dot(p[0]).powi(2) + dot(p[1]).powi(2));
        constraint upper: p[0].powi(2) + p[1].powi(2) == l1.powi(2);
        constraint lower: (q[0] - p[0]).powi(2) + (q[1] - p[1]).powi(2) == l2.powi(2);
    }
}

lagrangian! {
    /// The same by angles.
    pub system Angles {
        param m1, m2, l1, l2, c, g = 9.81;
        coord a: angle, b: angle;
        let x1 = l1 * sin(a);
        let y1 = -l1 * cos(a);
        let x2 = x1 + l2 * sin(b);
        let y2 = y1 - l2 * cos(b);
        T = 0.5 * m1 * (dot(x1).powi(2) + dot(y1).powi(2)) + 0.5 * m2 * (dot(x2).powi(2) + dot(y2).powi(2));
        V = g * (m1 * y1 + m2 * y2);
        D = 0.5 * c * (dot(x1).powi(2) + dot(y1).powi(2));
    }
}

lagrangian! {
    /// Three uniform bars, a crank, a coupler and a rocker, whose pivots are d apart.
    pub system FourBar {
        param a, b, c, d, ma, mb, mc, g = 9.81;
        input torque;
        coord phi: angle, psi: angle, chi: angle;
        let x = a * phi.cos() + 0.5 * b * psi.cos();
        let y = a * phi.sin() + 0.5 * b * psi.sin();
        T = 0.5 * (ma * a.powi(2) / 3) * dot(phi).powi(2)
            + 0.5 * mb * (dot(x).powi(2) + dot(y).powi(2) + b.powi(2) / 12 * dot(psi).powi(2))
            + 0.5 * (mc * c.powi(2) / 3) * dot(chi).powi(2);
        V = g * (0.5 * ma * a * phi.sin() + mb * y + 0.5 * mc * c * chi.sin());
        Q[phi] = torque;
        constraint pin: [a * phi.cos() + b * psi.cos(), a * phi.sin() + b * psi.sin()]
            == [d + c * chi.cos(), c * chi.sin()];
        observe rocker = [d + c * chi.cos(), c * chi.sin()];
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
    /// A blade on an inclined plane, held by springs: equilibria form a surface.
    pub system Blade {
        param m, i, kx, ky, kpsi, slope;
        coord x, y, psi;
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2)) + 0.5 * i * dot(psi).powi(2);
        V = 0.5 * kx * x.powi(2) + 0.5 * ky * y.powi(2) + slope * y + 0.5 * kpsi * psi.powi(2);
        constraint blade: dot(y) * cos(psi) == dot(x) * sin(psi);
    }
}

lagrangian! {
    /// A bead on a wire that a drive raises.
    pub system Lift {
        param m, g = 9.81;
        input height;
        coord x, y;
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
        V = m * g * y;
        constraint wire: y == height + x.powi(2);
    }
}

lagrangian! {
    /// The same wire, raised by time.
    pub system Raised {
        param m, g = 9.81;
        coord x, y;
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
        V = m * g * y;
        constraint wire: y == t + x.powi(2);
    }
}

lagrangian! {
    /// A point on the track x y = 0, which crosses itself at the origin.
    pub system Cross {
        coord x, y;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = 0.5 * (x.powi(2) + y.powi(2));
        constraint track: x * y == 0;
    }
}
