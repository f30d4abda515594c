//! The systems whose building `build.py` times: each is compiled into a program of its own.

macro_rules! pendulum {
    () => {
        lagrangian! {
            /// One coordinate.
            pub system Built {
                param m = 1.3, l = 0.7, g = 9.81;
                coord theta: [1];
                T = 0.5 * m * (l * dot(theta[0])).powi(2);
                V = -m * g * l * cos(theta[0]);
            }
        }
        const START: ([f64; 1], [f64; 1]) = ([1.0], [0.2]);
    };
}

/// The pendulum with its equation by hand.
macro_rules! pendulum_by_hand {
    () => {
        by_hand!(1, |q, _, [m1, _, l1, _, g]| [-g / l1 * q[0].sin() * (m1 / m1)]);
        const START: ([f64; 1], [f64; 1]) = ([1.0], [0.2]);
    };
}

/// The double pendulum with its equations by hand.
macro_rules! double_pendulum_by_hand {
    () => {
        by_hand!(2, |q, qd, [m1, m2, l1, l2, g]| {
            let (s, c) = (q[0] - q[1]).sin_cos();
            let f = m2 * l2 * qd[1] * qd[1] * s + (m1 + m2) * g * q[0].sin();
            let h = l1 * qd[0] * qd[0] * s - g * q[1].sin();
            let d = m1 + m2 * s * s;
            [(-f - m2 * c * h) / (l1 * d), ((m1 + m2) * h + c * f) / (l2 * d)]
        });
        const START: ([f64; 2], [f64; 2]) = ([1.0, 0.4], [0.2, -0.3]);
    };
}

/// A system of which only the accelerations are known.
macro_rules! by_hand {
    ($n:literal, |$q:ident, $qd:pat_param, $parameters:pat_param| $accelerations:expr) => {
        #[derive(Clone, Copy)]
        pub struct Built {
            parameters: [f64; 5],
        }
        impl Default for Built {
            fn default() -> Self {
                Built { parameters: [1.3, 0.8, 0.7, 0.9, 9.81] }
            }
        }
        impl System<$n> for Built {
            type Scalar = f64;
            fn accel(&self, $q: &SVector<f64, $n>, $qd: &SVector<f64, $n>, _: f64) -> SVector<f64, $n> {
                let $parameters = self.parameters;
                SVector::from($accelerations)
            }
        }
    };
}

macro_rules! double_pendulum {
    () => {
        lagrangian! {
            /// Two coordinates.
            pub system Built {
                param m: [2] = [1.3, 0.8], l: [2] = [0.7, 0.9], g = 9.81;
                coord a, b;
                let x = l[0] * sin(a) + l[1] * sin(b);
                let y = -l[0] * cos(a) - l[1] * cos(b);
                T = 0.5 * m[0] * (l[0] * dot(a)).powi(2) + 0.5 * m[1] * (dot(x).powi(2) + dot(y).powi(2));
                V = -m[0] * g * l[0] * cos(a) + m[1] * g * y;
            }
        }
        const START: ([f64; 2], [f64; 2]) = ([1.0, 0.4], [0.2, -0.3]);
    };
}

macro_rules! arm {
    () => {
        lagrangian! {
            /// Seven axes, none along an axis of the link before, and bodies with all six moments and products of
            /// inertia.
            pub system Built {
                const N = 7;
                param m: [N] = [4.1, 4.0, 3.0, 2.7, 1.7, 1.8, 0.3], tau: [N] = [0, 0, 0, 0, 0, 0, 0], c = 0.5, g = 9.81;
                coord q: [angle; N];
                let link: [N] = |i| frame(
                    if i == 0 { world } else { link[i - 1] },
                    [0.02 * i, 0.03, 0.2 + 0.01 * i],
                    if i % 2 == 0 { rotation([0.48, 0.6, 0.64], q[i]) } else { rotation([0.36, -0.8, 0.48], q[i]) }
                );
                let centre: [N] = |i| frame(link[i], [0.03, -0.02, 0.1]);
                T = (0..N).map(|i| body(
                    m[i],
                    [[0.03, 0.002, -0.001], [0.002, 0.04, 0.003], [-0.001, 0.003, 0.02]],
                    centre[i],
                )).sum();
                V = g * (0..N).map(|i| m[i] * centre[i].origin()[2]).sum();
                D = 0.5 * c * (0..N).map(|i| dot(q[i]).powi(2)).sum();
                Q[q] = tau;
            }
        }
        const START: ([f64; 7], [f64; 7]) =
            ([0.3, 0.4, 0.1, 1.1, 0.2, 0.6, 0.5], [0.1, -0.2, 0.3, 0.1, 0.4, -0.3, 0.2]);
    };
}

macro_rules! floating_arm {
    () => {
        lagrangian! {
            /// Seven axes, along the links and across them in turn, on a body that nothing holds.
            pub system Built {
                const N = 7;
                param m: [N] = [4.1, 4.0, 3.0, 2.7, 1.7, 1.8, 0.3], tau: [N] = [0, 0, 0, 0, 0, 0, 0];
                param M = 30.0, J: [3] = [1.2, 1.5, 1.8], g = 9.81;
                coord x: [3], R: rotation, q: [angle; N];
                let base = frame(world, x, R);
                let up = [0.16, 0.2, 0.2, 0.22, 0.18, 0.22, 0.08, 0.12];
                let link: [N] = |i| frame(
                    if i == 0 { base } else { link[i - 1] },
                    if i == 0 { [0.1, 0.05, 0.3] } else { [0, 0, up[i]] },
                    if i % 2 == 0 { rotation_z(q[i]) } else { rotation_y(q[i]) }
                );
                let centre: [N] = |i| frame(link[i], [0, if i % 2 == 0 { -0.03 } else { 0.03 }, 0.5 * up[i + 1]]);
                let across: [N] = |i| m[i] * (up[i + 1] * up[i + 1] + 3 * 0.06 * 0.06) / 12;
                T = body(M, J, base)
                    + (0..N).map(|i| body(m[i], [across[i], across[i], 0.5 * m[i] * 0.06 * 0.06], centre[i])).sum();
                V = g * (M * x[2] + (0..N).map(|i| m[i] * centre[i].origin()[2]).sum());
                Q[q] = tau;
            }
        }
        #[allow(dead_code)]
        const START: ([f64; 13], [f64; 13]) = (
            [0.0, 0.0, 0.0, 0.1, 0.2, -0.1, 0.3, 0.4, 0.1, 1.1, 0.2, 0.6, 0.5],
            [0.1, 0.2, 0.0, 0.3, -0.4, 0.2, 0.1, -0.2, 0.3, 0.1, 0.4, -0.3, 0.2],
        );
    };
}

macro_rules! ball_chain {
    () => {
        lagrangian! {
            /// Eight bodies on ball joints.
            pub system Built {
                const N = 8;
                param g = 9.81;
                coord R: [rotation; N];
                let link: [N] = |i| frame(
                    if i == 0 { world } else { link[i - 1] },
                    if i == 0 { [0, 0, 0] } else { [0, 0, -1] },
                    R[i]
                );
                let bob: [N] = |i| frame(link[i], [0.01, 0.02, -0.5]);
                T = (0..N).map(|i| body(1, [0.1, 0.11, 0.01], bob[i])).sum();
                V = (0..N).map(|i| g * bob[i].origin()[2]).sum();
            }
        }
        #[allow(dead_code)]
        const START: ([f64; 24], [f64; 24]) = ([0.1; 24], [0.2; 24]);
    };
}

macro_rules! bicycle {
    () => {
        lagrangian! {
            /// Rear frame, front frame about a tilted axis of steering, and two wheels that roll on a plane: two
            /// contacts on it and no slip there in three directions. (The sixth constraint, the slip along the track
            /// of the rear wheel, is left to a brake.)
            pub system Built {
                param g = 9.81;
                coord x, y, yaw, lean, pitch, steer, rear, front;
                let upright = frame(world, [x, y, 0], rotation_z(yaw));
                let leaning = frame(upright, [0, 0, 0], rotation_x(lean));
                // The rear contact is the origin; its wheel stands in the leaning frame.
                let hub = frame(leaning, [0, 0, 0.3]);
                let rear_wheel = frame(hub, [0, 0, 0], rotation_y(rear));
                let frame_ = frame(hub, [0, 0, 0], rotation_y(pitch));
                let rider = frame(frame_, [0.3, 0, 0.6]);
                // Tilted by 18 degrees.
                let head = frame(frame_, [0.75, 0, 0.5], rotation_y(-0.314159));
                let fork = frame(head, [0, 0, 0], rotation_z(steer));
                let handlebar = frame(fork, [0.02, 0, -0.05]);
                let axle = frame(fork, [0.06, 0, -0.55]);
                let front_wheel = frame(axle, [0, 0, 0], rotation_y(front));
                T = body(85, [[9.2, 0, 2.4], [0, 11, 0], [2.4, 0, 2.8]], rider)
                    + body(4, [[0.06, 0, -0.008], [0, 0.06, 0], [-0.008, 0, 0.008]], handlebar)
                    + body(2, [0.06, 0.12, 0.06], rear_wheel)
                    + body(3, [0.14, 0.28, 0.14], front_wheel);
                V = g * (85 * rider.origin()[2] + 4 * handlebar.origin()[2] + 2 * hub.origin()[2] + 3 * axle.origin()[2]);
                // The lowest point of the front wheel: the radius, along the steepest direction in its plane.
                let normal = axle.vector([0, 1, 0]);
                let slope = (1 - normal[2] * normal[2]).sqrt();
                let down = [
                    normal[0] * normal[2] / slope,
                    normal[1] * normal[2] / slope,
                    -(1 - normal[2] * normal[2]) / slope,
                ];
                let centre = axle.origin();
                let spin = front_wheel.vector(angular_velocity(front_wheel));
                let ahead = dot(rear) * 0.3;
                constraint contact: centre[2] == 0.35 * slope;
                constraint no_slip: [
                    dot(x) * cos(yaw) + dot(y) * sin(yaw),
                    dot(y) * cos(yaw) - dot(x) * sin(yaw),
                    dot(centre[0]) + 0.35 * (spin[1] * down[2] - spin[2] * down[1]),
                    dot(centre[1]) + 0.35 * (spin[2] * down[0] - spin[0] * down[2]),
                ] == [ahead, 0, 0, 0];
            }
        }
        const START: ([f64; 8], [f64; 8]) =
            ([0.0, 0.0, 0.1, 0.05, 0.0, 0.02, 0.0, 0.0], [4.0, 0.4, 0.0, 0.1, 0.0, 0.05, 13.0, 11.0]);
    };
}

macro_rules! truss {
    () => {
        lagrangian! {
            /// A truss of 41 joints in the plane that hangs from a hinge, by the positions of the joints: 82
            /// coordinates, 81 rods.
            pub system Built {
                const N = 41;
                param m = 0.1, g = 9.81;
                coord x: [N], y: [N];
                T = 0.5 * m * (0..N).map(|i| dot(x[i]).powi(2) + dot(y[i]).powi(2)).sum();
                V = m * g * (0..N).map(|i| y[i]).sum();
                let rod: [N] = |i| (if i == 0 { x[i] } else { x[i] - x[i - 1] }).powi(2)
                    + (if i == 0 { y[i] } else { y[i] - y[i - 1] }).powi(2);
                let brace: [N - 1] = |i| (if i == 0 { x[i + 1] } else { x[i + 1] - x[i - 1] }).powi(2)
                    + (if i == 0 { y[i + 1] } else { y[i + 1] - y[i - 1] }).powi(2);
                constraint rods: rod == (0..N).map(|i| 0.01);
                constraint braces: brace == (0..N - 1).map(|i| 0.01);
            }
        }
        const START: ([f64; 82], [f64; 82]) = {
            let mut q = [0.0; 82];
            let mut i = 0;
            while i < 41 {
                q[i] = if i % 2 == 0 { 0.0866 } else { 0.0 };
                q[41 + i] = -0.05 * (i + 1) as f64;
                i += 1;
            }
            (q, [0.0; 82])
        };
    };
}
