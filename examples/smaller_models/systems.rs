//! Systems, each with the models of it that are compared.

use lagrange_runtime::prelude::*;

lagrangian! {
    /// Two masses on rods in space, by their angles in the plane of x and z, and across it.
    pub system Spatial {
        param m1, m2, l1, l2, g = 9.81;
        coord theta1: angle, phi1: angle, theta2: angle, phi2: angle;
        let x1 = l1 * theta1.sin() * phi1.cos();
        let y1 = l1 * phi1.sin();
        let z1 = -l1 * theta1.cos() * phi1.cos();
        let x2 = x1 + l2 * theta2.sin() * phi2.cos();
        let y2 = y1 + l2 * phi2.sin();
        let z2 = z1 - l2 * theta2.cos() * phi2.cos();
        T = 0.5 * m1 * (dot(x1).powi(2) + dot(y1).powi(2) + dot(z1).powi(2))
            + 0.5 * m2 * (dot(x2).powi(2) + dot(y2).powi(2) + dot(z2).powi(2));
        V = m1 * g * z1 + m2 * g * z2;
        observe tip = [x2, y2, z2];
        /// Exact: what starts in the plane stays in it.
        pub restriction Planar: [phi1, phi2] = 0;
        /// Energies to order 4.
        pub simplified Quartic: lock [phi1, phi2] = 0, expand [theta1, theta2] to 4 about 0;
        /// Small oscillations.
        pub simplified Linear: lock [phi1, phi2] = 0, expand [theta1, theta2] to 2 about 0;
    }
}

lagrangian! {
    /// A quarter of a car on a road, by the height of its body and the deflection of its tyre.
    pub system Car {
        param body, wheel, k, c, tyre, omega, a = 0.02;
        coord x: length, d: length;
        coord road = 0.5 * a * (1 - (omega * t).cos());
        let w = road + d;
        T = 0.5 * body * dot(x).powi(2) + 0.5 * wheel * dot(w).powi(2);
        V = 0.5 * k * (x - w).powi(2) + 0.5 * tyre * d.powi(2);
        force c * (dot(w) - dot(x)) at x - w;
        observe height = [x, 0, 0];
        /// The tyre is as flat as statics have it.
        pub simplified Slow: quasistatic d;
        pub simplified Rigid: lock d = 0;
    }
}

lagrangian! {
    /// A pendulum on a spring.
    pub system Elastic {
        param m, l, k, g = 9.81;
        coord theta: angle, r: length;
        T = 0.5 * m * (dot(r).powi(2) + (r * dot(theta)).powi(2));
        V = 0.5 * k * (r - l).powi(2) - m * g * r * theta.cos();
        observe bob = [r * theta.sin(), 0, -r * theta.cos()];
        /// The spring is a rod.
        pub simplified Rod: lock r = l;
        /// Small oscillations of a rod.
        pub simplified SmallRod: lock r = l, expand theta to 2 about 0;
    }
}

lagrangian! {
    /// A pendulum whose pivot is shaken up and down.
    pub system Kapitza {
        param l, a, omega, g = 9.81;
        coord theta: angle;
        coord pivot = a * (omega * t).cos();
        let y = pivot - l * theta.cos();
        T = 0.5 * (dot(l * theta.sin()).powi(2) + dot(y).powi(2));
        V = g * y;
        observe angle = [theta, 0, 0];
        /// The mean of the motion.
        pub simplified Mean: average omega * t;
        /// The pivot rests.
        pub simplified Still: neglect a;
    }
}

lagrangian! {
    /// The axis of a heavy symmetric top, by u and v, the tangents of half its tilts, and without its spin, whose
    /// momentum is p; w is its weight times the height of its mass centre.
    pub system Top {
        param a, p, w;
        coord u, v;
        let s = 1 + u * u + v * v;
        L = 2 * a * (dot(u).powi(2) + dot(v).powi(2)) / s.powi(2)
            - 2 * p * (u * dot(v) - v * dot(u)) / s - w * (2 / s - 1);
        observe axis = [2 * u / s, 2 * v / s, 2 / s - 1];
        /// Small tilts of an upright top.
        pub simplified Gyroscopic: expand [u, v] to 2 about 0;
    }
}

lagrangian! {
    /// A flywheel drives a piston by a crank and a rod, which stretches by s.
    pub system Crank {
        param inertia, radius, rod, piston, k, c;
        coord theta: angle, s: length;
        let lean = rod + s - ((rod + s).powi(2) - (radius * theta.sin()).powi(2)).sqrt();
        let x = radius * theta.cos() + s - lean;
        T = 0.5 * inertia * dot(theta).powi(2) + 0.5 * piston * dot(x).powi(2);
        V = 0.5 * k * s.powi(2);
        D = 0.5 * c * dot(s).powi(2);
        observe place = [x, 0, 0];
        pub simplified RigidRod: lock s = 0;
        /// A rod so long that it does not lean.
        pub simplified LongRod: lock s = 0, neglect lean;
    }
}

lagrangian! {
    /// A pendulum on a table that turns, by its place on the table.
    pub system Foucault {
        param l, turn, g = 9.81;
        coord x: length, y: length;
        let z = -(l * l - x * x - y * y).sqrt();
        T = 0.5 * ((dot(x) - turn * y).powi(2) + (dot(y) + turn * x).powi(2) + dot(z).powi(2));
        V = g * z;
        observe place = [x, y, 0];
        /// Small oscillations.
        pub simplified SmallFoucault: expand [x, y] to 2 about 0;
        /// The table rests.
        pub simplified Resting: neglect turn;
        pub simplified SmallResting: neglect turn, expand [x, y] to 2 about 0;
    }
}

lagrangian! {
    /// A damped pendulum under a torque that oscillates; its own frequency is 1.
    pub system Driven {
        param damping, gamma, omega;
        coord theta: angle;
        T = 0.5 * dot(theta).powi(2);
        V = -theta.cos();
        D = damping * dot(theta).powi(2);
        Q[theta] = gamma * (omega * t).cos();
        observe angle = [theta, 0, 0];
        pub simplified Duffing: expand theta to 4 about 0;
        pub simplified Oscillator: expand theta to 2 about 0;
    }
}

lagrangian! {
    /// An arm with seven axes, along the links and across them in turn, whose drives are springs to where they should
    /// be: the axes of its shoulder and its elbow swing, the others are to rest.
    pub system Arm {
        const N = 7;
        param stiffness, amplitude, rate = 3, g = 9.81;
        coord q: [angle; N];
        let up = [0.16, 0.2, 0.2, 0.22, 0.18, 0.22, 0.08, 0.12];
        let m = [4.1, 4.0, 3.0, 2.7, 1.7, 1.8, 2.3];
        let link: [N] = |i| frame(
            if i == 0 { world } else { link[i - 1] },
            [0, 0, up[i]],
            if i % 2 == 0 { rotation_z(q[i]) } else { rotation_y(q[i]) }
        );
        // Slender links: mass centres half way up, a little off the axes.
        let centre: [N] = |i| frame(link[i], [0, if i % 2 == 0 { -0.03 } else { 0.03 }, 0.5 * up[i + 1]]);
        let across: [N] = |i| m[i] * (up[i + 1] * up[i + 1] + 3 * 0.06 * 0.06) / 12;
        let hand = frame(link[6], [0, 0, up[7]]);
        let swing = amplitude * (1 - (rate * t).cos());
        let wanted: [N] = |i| if i == 1 || i == 3 { swing } else { 0 };
        let drive: [N] = |i| stiffness / (1 + i * i).powi(2);
        T = (0..N).map(|i| body(m[i], [across[i], across[i], 0.5 * m[i] * 0.06 * 0.06], centre[i])).sum();
        V = 0.5 * (0..N).map(|i| drive[i] * (q[i] - wanted[i]).powi(2)).sum()
            + g * (0..N).map(|i| m[i] * centre[i].origin()[2]).sum();
        D = 0.5 * (0..N).map(|i| 0.004 * drive[i] * dot(q[i]).powi(2)).sum();
        observe tip = hand.origin();
        /// The axes across the links.
        pub simplified Bending: lock q[0] = 0, lock q[2] = 0, lock q[4] = 0, lock q[6] = 0;
        /// Shoulder and elbow, the axes that are to move.
        pub simplified Moving: lock q[0] = 0, lock q[2] = 0, lock q[4] = 0, lock q[5] = 0, lock q[6] = 0;
    }
}

lagrangian! {
    /// A chain of 32 links, one metre long, that hangs with a bead at the end of each.
    pub system HangingChain {
        const N = 32;
        param l = 0.03125, g = 9.81;
        coord theta: [angle; N];
        let x: [N] = |i| (if i == 0 { 0 } else { x[i - 1] }) + l * theta[i].sin();
        let z: [N] = |i| (if i == 0 { 0 } else { z[i - 1] }) - l * theta[i].cos();
        T = (0..N).map(|i| 0.5 * (dot(x[i]).powi(2) + dot(z[i]).powi(2))).sum();
        V = (0..N).map(|i| g * z[i]).sum();
        observe tip = [x[N - 1], 0, z[N - 1]];
    }
}
