//! The systems of the tests, by what they are called in Beatty, *Principles of Engineering Mechanics 2* (2006), ch. 11.

use lagrange_runtime::prelude::*;

lagrangian! {
    /// Example 11.6(i).
    pub system TwoMasses {
        param m1, m2, k1, k2;
        coord x1, x2;
        T = 0.5 * m1 * dot(x1).powi(2) + 0.5 * m2 * dot(x2).powi(2);
        V = 0.5 * k1 * x1.powi(2) + 0.5 * k2 * (x2 - x1).powi(2) + 0.5 * k1 * x2.powi(2);
    }
}

lagrangian! {
    /// Example 11.9.
    pub system WheelAndBlock {
        param m, I, a, k1, k2;
        coord x, phi;
        T = 0.5 * m * dot(x).powi(2) + 0.5 * I * dot(phi).powi(2);
        V = 0.5 * k1 * (a * phi).powi(2) + 0.5 * k2 * (x - a * phi).powi(2);
    }
}

lagrangian! {
    /// Example 11.11.
    pub system Generic {
        param M11, M12, M22, K11, K12, K22;
        coord q1, q2;
        T = 0.5 * (M11 * dot(q1).powi(2) + 2 * M12 * dot(q1) * dot(q2) + M22 * dot(q2).powi(2));
        V = 0.5 * (K11 * q1.powi(2) + 2 * K12 * q1 * q2 + K22 * q2.powi(2));
    }
}

lagrangian! {
    /// Example 11.12: a rigid body on a wire, (11.92a) and (11.92b).
    pub system WireBody {
        param M, a, l, IG, g;
        coord phi, theta;
        T = 0.5 * M * ((a * dot(theta) * (phi - theta).sin()).powi(2)
            + (a * dot(theta) * (phi - theta).cos() + l * dot(phi)).powi(2)) + 0.5 * IG * dot(phi).powi(2);
        V = M * g * (a * (1 - theta.cos()) + l * (1 - phi.cos()));
    }
}

lagrangian! {
    /// Example 11.12, (11.92c).
    pub system WireBodySmall {
        param M, a, l, IH, g;
        coord phi, theta;
        T = 0.5 * IH * dot(phi).powi(2) + 0.5 * M * (2 * l * a * dot(phi) * dot(theta) + (a * dot(theta)).powi(2));
        V = 0.5 * M * g * (l * phi.powi(2) + a * theta.powi(2));
    }
}

lagrangian! {
    /// Example 11.14.
    pub system Damped {
        param m1, m2, k1, k2, c1, c12, c2;
        coord x, y;
        T = 0.5 * m1 * dot(x).powi(2) + 0.5 * m2 * dot(y).powi(2);
        V = 0.5 * k1 * x.powi(2) + 0.5 * k2 * y.powi(2);
        D = 0.5 * (c1 * dot(x).powi(2) + 2 * c12 * dot(x) * dot(y) + c2 * dot(y).powi(2));
    }
}

lagrangian! {
    /// Problem 11.27.
    pub system Dumbbell {
        param m, l, b, k;
        coord y, theta;
        T = m * dot(y).powi(2) + m * (l * dot(theta)).powi(2);
        V = 0.5 * k * (y + b * theta.sin()).powi(2) + 0.5 * k * (y - b * theta.sin()).powi(2);
    }
}

lagrangian! {
    /// Problem 11.32.
    pub system BouncePitch {
        param m, IC, k1, k2, l1, l2;
        coord y, theta;
        T = 0.5 * m * dot(y).powi(2) + 0.5 * IC * dot(theta).powi(2);
        V = 0.5 * k1 * (y - l1 * theta).powi(2) + 0.5 * k2 * (y + l2 * theta).powi(2);
    }
}

lagrangian! {
    /// Problem 11.33.
    pub system SliderRod {
        param M, m, l, k, g;
        coord x, theta;
        T = 0.5 * (M + m) * dot(x).powi(2) + 0.5 * m * l * dot(x) * dot(theta) * theta.cos()
            + m * (l * dot(theta)).powi(2) / 6.0;
        V = 0.5 * k * x.powi(2) + 0.5 * m * g * l * (1 - theta.cos());
    }
}

lagrangian! {
    /// Problems 11.34 and 11.37.
    pub system CoupledPendula {
        param m, l, a, k, g, c;
        coord th1, th2;
        T = 0.5 * m * l.powi(2) * (dot(th1).powi(2) + dot(th2).powi(2));
        V = m * g * l * (2 - th1.cos() - th2.cos()) + 0.5 * k * a.powi(2) * (th1.sin() - th2.sin()).powi(2);
        D = 0.5 * c * l.powi(2) * (dot(th1).powi(2) + dot(th2).powi(2));
    }
}

lagrangian! {
    /// Problem 11.35.
    pub system DoublePendulum {
        param m1, m2, l1, l2, g;
        coord th1, th2;
        let x1 = l1 * th1.sin();
        let y1 = -l1 * th1.cos();
        let x2 = x1 + l2 * th2.sin();
        let y2 = y1 - l2 * th2.cos();
        T = 0.5 * m1 * (dot(x1).powi(2) + dot(y1).powi(2)) + 0.5 * m2 * (dot(x2).powi(2) + dot(y2).powi(2));
        V = m1 * g * y1 + m2 * g * y2;
    }
}

lagrangian! {
    /// Problem 11.36.
    pub system Metronome {
        param m1, m2, l1, l2, k, g;
        coord theta;
        T = 0.5 * (m1 * l1.powi(2) + m2 * l2.powi(2)) * dot(theta).powi(2);
        V = -(m1 * l1 - m2 * l2) * g * theta.cos() + 0.5 * k * (l1 * theta.sin()).powi(2);
    }
}

lagrangian! {
    /// Example 11.5: a bead in a tube bent to a circle that spins about its vertical diameter.
    pub system Bead {
        param m, a, g, om;
        coord theta;
        coord phi = om * t;
        let x = a * theta.sin() * phi.cos();
        let y = a * theta.sin() * phi.sin();
        let z = a * (1 - theta.cos());
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2));
        V = m * g * z;
    }
}

lagrangian! {
    /// Section 11.12.1: the inertia table, and section 11.12.3: the gyrocompass, as oscillators.
    pub system Oscillator {
        param i, c, k;
        coord x;
        T = 0.5 * i * dot(x).powi(2);
        V = 0.5 * k * x.powi(2);
        D = 0.5 * c * dot(x).powi(2);
    }
}

lagrangian! {
    /// Section 11.12.4: a symmetric top by Euler's angles.
    pub system Top {
        param m, g, l, I1, I3;
        coord phi, theta, psi;
        T = 0.5 * I1 * (dot(theta).powi(2) + (dot(phi) * theta.sin()).powi(2))
            + 0.5 * I3 * (dot(psi) + dot(phi) * theta.cos()).powi(2);
        V = m * g * l * theta.cos();
    }
}

lagrangian! {
    /// The same top by angles that are regular where it stands upright: turned by a about x, then by b about the new y.
    pub system UprightTop {
        param m, g, l, I1, I3;
        coord a, b, psi;
        T = 0.5 * I1 * (dot(b).powi(2) + (dot(a) * b.cos()).powi(2)) + 0.5 * I3 * (dot(psi) + dot(a) * b.sin()).powi(2);
        V = m * g * l * a.cos() * b.cos();
    }
}

lagrangian! {
    /// Linear, with forces of every kind.
    pub system Plain {
        param k, l, c, g, p;
        coord x, y;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = 0.5 * k * x.powi(2) + 0.5 * l * y.powi(2);
        D = 0.5 * c * (dot(x).powi(2) + dot(y).powi(2));
        Q[x] = p * y - g * dot(y);
        Q[y] = -p * x + g * dot(x);
    }
}

lagrangian! {
    /// Drag by the third power of the velocity.
    pub system Dragged {
        param k, c;
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = 0.5 * k * x.powi(2);
        Q[x] = -c * dot(x).powi(3);
    }
}

lagrangian! {
    /// A round potential.
    pub system Round {
        param mu;
        coord x, y;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = 0.25 * (x.powi(2) + y.powi(2)).powi(2) - 0.5 * mu * (x.powi(2) + y.powi(2));
    }
}

lagrangian! {
    /// A symmetric potential but for e, and a coordinate beside it.
    pub system Nearly {
        param mu, e, k;
        coord x, y;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = 0.25 * x.powi(4) - 0.5 * mu * x.powi(2) + e * x + 0.5 * k * y.powi(2);
    }
}

lagrangian! {
    /// Two bodies and a spring between them, one of which is pushed.
    pub system Pair {
        param k, f;
        coord x, y;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = 0.5 * k * (x - y).powi(2) - f * y;
    }
}

lagrangian! {
    /// A bead on a hoop that turns freely, with a kink at θ = 1.
    pub system Notched {
        param g, I;
        coord theta, phi;
        T = 0.5 * (dot(theta).powi(2) + (dot(phi) * theta.sin()).powi(2) + I * dot(phi).powi(2));
        V = -g * theta.cos() + 0.5 * max(theta - 1, 0).powi(2);
    }
}

lagrangian! {
    /// A body on a string of unit length in space, about the vertical.
    pub system Tied {
        param g;
        coord r, z, phi;
        T = 0.5 * (dot(r).powi(2) + dot(z).powi(2) + (r * dot(phi)).powi(2));
        V = g * z;
        constraint string: r.powi(2) + z.powi(2) == 1;
    }
}

lagrangian! {
    /// Damped, or driven if c is negative.
    pub system Swing {
        param k, c;
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = 0.5 * k * x.powi(2);
        D = 0.5 * c * dot(x).powi(2);
    }
}

lagrangian! {
    pub system Orbit {
        coord r, phi;
        T = 0.5 * (dot(r).powi(2) + (r * dot(phi)).powi(2));
        V = -1 / r;
        pub routhian Radial;
    }
}

lagrangian! {
    /// Mathieu's equation.
    pub system Mathieu {
        param delta, epsilon;
        coord x;
        T = 0.5 * dot(x).powi(2);
        Q[x] = -(delta + epsilon * cos(t)) * x;
        V = 0;
    }
}

lagrangian! {
    pub system Pendulum {
        param l, g;
        coord theta;
        T = 0.5 * (l * dot(theta)).powi(2);
        V = -g * l * cos(theta);
    }
}

lagrangian! {
    /// Van der Pol's oscillator.
    pub system VanDerPol {
        param mu;
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = 0.5 * x.powi(2);
        Q[x] = mu * (1 - x.powi(2)) * dot(x);
    }
}

lagrangian! {
    /// Driven at its natural frequency.
    pub system Resonant {
        param f;
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = 0.5 * x.powi(2);
        Q[x] = f * cos(t);
    }
}

lagrangian! {
    /// A pendulum whose pivot is shaken.
    pub system Shaken {
        param a, omega, g = 9.81;
        coord theta;
        coord pivot = a * cos(omega * t);
        let x = theta.sin();
        let y = pivot - theta.cos();
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = g * y;
    }
}

lagrangian! {
    /// A particle in polar coordinates, bound to the origin.
    pub system Polar {
        param k;
        coord r, phi;
        T = 0.5 * (dot(r).powi(2) + (r * dot(phi)).powi(2));
        V = 0.5 * k * r.powi(2);
    }
}

lagrangian! {
    /// A pendulum in Cartesian coordinates.
    pub system Cartesian {
        param g = 9.81;
        coord x, y;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = g * y;
        constraint rod: x.powi(2) + y.powi(2) == 1;
    }
}

lagrangian! {
    /// A follower force: K is not symmetric.
    pub system Follower {
        param p;
        coord a, b;
        T = 0.5 * (dot(a).powi(2) + dot(b).powi(2));
        V = 0.5 * (a.powi(2) + 2 * b.powi(2));
        Q[a] = p * b;
        Q[b] = -p * a;
    }
}

lagrangian! {
    pub system Pulsed {
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = 0.5 * x.powi(2);
        Q[x] = if t > 5 && t < 10 { 1 } else { 0 };
    }
}

lagrangian! {
    pub system Gust {
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = 0.5 * x.powi(2);
        Q[x] = exp(-(t - 50).powi(2));
    }
}

lagrangian! {
    pub system Vee {
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = x.abs();
    }
}

lagrangian! {
    /// Dry friction.
    pub system Rubbing {
        param mu;
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = 0.5 * x.powi(2);
        Q[x] = -mu * signum(dot(x));
    }
}
