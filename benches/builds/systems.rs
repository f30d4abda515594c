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

/// Motions of bodies and their balance, for systems by hand.
macro_rules! bodies_by_hand {
    () => {
        /// Motion of the axes of a body, in those of the world.
        #[derive(Clone, Copy)]
        pub struct Axes {
            turn: UnitQuaternion<f64>,
            origin: Vector3<f64>,
            omega: Vector3<f64>,
            velocity: Vector3<f64>,
            alpha: Vector3<f64>,
            acceleration: Vector3<f64>,
        }

        impl Axes {
            fn world() -> Self {
                let zero = Vector3::zeros();
                Axes { turn: UnitQuaternion::identity(), origin: zero, omega: zero, velocity: zero, alpha: zero, acceleration: zero }
            }

            /// Axes that stay parallel, at a point that is given in these.
            fn at(&self, point: [f64; 3]) -> Self {
                let arm = self.turn * Vector3::from(point);
                let swept = self.omega.cross(&arm);
                Axes {
                    origin: self.origin + arm,
                    velocity: self.velocity + swept,
                    acceleration: self.acceleration + self.alpha.cross(&arm) + self.omega.cross(&swept),
                    ..*self
                }
            }

            /// Axes that are turned about an axis by an angle, which has a rate and an acceleration.
            fn turned(&self, axis: [f64; 3], [angle, rate, acceleration]: [f64; 3]) -> Self {
                let axis = Vector3::from(axis);
                let about = self.turn * axis;
                let omega = self.omega + about * rate;
                Axes {
                    turn: self.turn * UnitQuaternion::new(axis * angle),
                    omega,
                    alpha: self.alpha + about * acceleration + self.omega.cross(&about) * rate,
                    ..*self
                }
            }
        }

        /// A body by its mass, its moments and products of inertia about its mass centre, and the motion of this.
        pub struct Body(f64, [[f64; 3]; 3], Axes);

        /// Inertia matrix and the generalized forces that keep the accelerations at 0, from the partial velocities of
        /// the bodies (Kane): `bodies(q̇, q̈)`.
        fn balance<const N: usize, const B: usize>(
            g: f64,
            qd: &SVector<f64, N>,
            bodies: impl Fn(&SVector<f64, N>, &SVector<f64, N>) -> [Body; B],
        ) -> (SMatrix<f64, N, N>, SVector<f64, N>) {
            let (zero, up) = (SVector::<f64, N>::zeros(), Vector3::new(0.0, 0.0, 1.0));
            let partial: [[Body; B]; N] = core::array::from_fn(|j| bodies(&SVector::from_fn(|i, _| f64::from(i == j)), &zero));
            let (mut inertia, mut forces) = (SMatrix::zeros(), SVector::zeros());
            for (k, Body(mass, moments, at)) in bodies(qd, &zero).into_iter().enumerate() {
                let to_world = at.turn.to_rotation_matrix().into_inner();
                let moments = to_world * SMatrix::<f64, 3, 3>::from(moments) * to_world.transpose();
                let force = (at.acceleration + up * g) * mass;
                let moment = moments * at.alpha + at.omega.cross(&(moments * at.omega));
                for i in 0..N {
                    let by_i = &partial[i][k].2;
                    forces[i] += by_i.velocity.dot(&force) + by_i.omega.dot(&moment);
                    for j in 0..N {
                        let by_j = &partial[j][k].2;
                        inertia[(i, j)] += mass * by_i.velocity.dot(&by_j.velocity) + by_i.omega.dot(&(moments * by_j.omega));
                    }
                }
            }
            (inertia, forces)
        }
    };
}

/// The arm with its equations by hand.
macro_rules! arm_by_hand {
    () => {
        bodies_by_hand!();
        #[derive(Clone, Copy)]
        pub struct Built {
            m: [f64; 7],
            tau: [f64; 7],
            c: f64,
            g: f64,
        }
        impl Default for Built {
            fn default() -> Self {
                Built { m: [4.1, 4.0, 3.0, 2.7, 1.7, 1.8, 0.3], tau: [0.0; 7], c: 0.5, g: 9.81 }
            }
        }
        impl System<7> for Built {
            type Scalar = f64;
            fn accel(&self, q: &SVector<f64, 7>, qd: &SVector<f64, 7>, _: f64) -> SVector<f64, 7> {
                let moments = [[0.03, 0.002, -0.001], [0.002, 0.04, 0.003], [-0.001, 0.003, 0.02]];
                let (inertia, forces) = balance(self.g, qd, |qd, qdd| {
                    let mut link = Axes::world();
                    core::array::from_fn::<_, 7, _>(|i| {
                        let axis = if i % 2 == 0 { [0.48, 0.6, 0.64] } else { [0.36, -0.8, 0.48] };
                        link = link.at([0.02 * i as f64, 0.03, 0.2 + 0.01 * i as f64]).turned(axis, [q[i], qd[i], qdd[i]]);
                        Body(self.m[i], moments, link.at([0.03, -0.02, 0.1]))
                    })
                });
                let applied = SVector::from(self.tau) - qd * self.c - forces;
                inertia.cholesky().map_or(SVector::repeat(f64::NAN), |inertia| inertia.solve(&applied))
            }
        }
        const START: ([f64; 7], [f64; 7]) =
            ([0.3, 0.4, 0.1, 1.1, 0.2, 0.6, 0.5], [0.1, -0.2, 0.3, 0.1, 0.4, -0.3, 0.2]);
    };
}

/// The bicycle with its equations by hand.
macro_rules! bicycle_by_hand {
    () => {
        bodies_by_hand!();
        #[derive(Clone, Copy)]
        pub struct Built {
            g: f64,
        }
        impl Default for Built {
            fn default() -> Self {
                Built { g: 9.81 }
            }
        }
        impl Built {
            /// The rider, the handlebar, both wheels, and the fork at the axle of the front wheel.
            fn bodies(q: &SVector<f64, 8>, qd: &SVector<f64, 8>, qdd: &SVector<f64, 8>) -> ([Body; 4], Axes) {
                let joint = |i: usize| [q[i], qd[i], qdd[i]];
                let mut base = Axes::world().at([q[0], q[1], 0.0]);
                base.velocity = Vector3::new(qd[0], qd[1], 0.0);
                base.acceleration = Vector3::new(qdd[0], qdd[1], 0.0);
                let leaning = base.turned([0.0, 0.0, 1.0], joint(2)).turned([1.0, 0.0, 0.0], joint(3));
                let hub = leaning.at([0.0, 0.0, 0.3]);
                let frame = hub.turned([0.0, 1.0, 0.0], joint(4));
                let head = frame.at([0.75, 0.0, 0.5]).turned([0.0, 1.0, 0.0], [-0.314159, 0.0, 0.0]);
                let fork = head.turned([0.0, 0.0, 1.0], joint(5));
                let axle = fork.at([0.06, 0.0, -0.55]);
                let wheel = |i: f64| [[i, 0.0, 0.0], [0.0, 2.0 * i, 0.0], [0.0, 0.0, i]];
                let bodies = [
                    Body(85.0, [[9.2, 0.0, 2.4], [0.0, 11.0, 0.0], [2.4, 0.0, 2.8]], frame.at([0.3, 0.0, 0.6])),
                    Body(4.0, [[0.06, 0.0, -0.008], [0.0, 0.06, 0.0], [-0.008, 0.0, 0.008]], fork.at([0.02, 0.0, -0.05])),
                    Body(2.0, wheel(0.06), hub.turned([0.0, 1.0, 0.0], joint(6))),
                    Body(3.0, wheel(0.14), axle.turned([0.0, 1.0, 0.0], joint(7))),
                ];
                (bodies, axle)
            }

            /// Second derivative of the contact of the front wheel, and the first ones of the four velocities of slip.
            fn slips(q: &SVector<f64, 8>, qd: &SVector<f64, 8>, qdd: &SVector<f64, 8>) -> SVector<f64, 5> {
                let (bodies, axle) = Self::bodies(q, qd, qdd);
                let wheel = &bodies[3].2;
                let normal = axle.turn * Vector3::new(0.0, 1.0, 0.0);
                let rate = axle.omega.cross(&normal);
                let second = axle.alpha.cross(&normal) + axle.omega.cross(&rate);
                let slope = (1.0 - normal.z * normal.z).sqrt();
                let steepening = -normal.z * rate.z / slope;
                let steepening_rate =
                    -(rate.z * rate.z + normal.z * second.z) / slope + normal.z * rate.z * steepening / (slope * slope);
                let up = Vector3::new(0.0, 0.0, 1.0);
                let down = (normal * normal.z - up) / slope;
                let turning = (rate * normal.z + normal * rate.z - down * steepening) / slope;
                let slip = axle.acceleration + (wheel.alpha.cross(&down) + wheel.omega.cross(&turning)) * 0.35;
                let (s, c) = q[2].sin_cos();
                SVector::from([
                    axle.acceleration.z - 0.35 * steepening_rate,
                    qdd[0] * c + qdd[1] * s + qd[2] * (qd[1] * c - qd[0] * s) - 0.3 * qdd[6],
                    qdd[1] * c - qdd[0] * s - qd[2] * (qd[0] * c + qd[1] * s),
                    slip.x,
                    slip.y,
                ])
            }
        }
        impl System<8> for Built {
            type Scalar = f64;
            fn accel(&self, q: &SVector<f64, 8>, qd: &SVector<f64, 8>, _: f64) -> SVector<f64, 8> {
                let (inertia, forces) = balance(self.g, qd, |qd, qdd| Self::bodies(q, qd, qdd).0);
                let rest = Self::slips(q, qd, &SVector::zeros());
                let mut matrix = SMatrix::<f64, 13, 13>::zeros();
                matrix.fixed_view_mut::<8, 8>(0, 0).copy_from(&inertia);
                for j in 0..8 {
                    let column = Self::slips(q, qd, &SVector::ith(j, 1.0)) - rest;
                    matrix.fixed_view_mut::<5, 1>(8, j).copy_from(&column);
                    matrix.fixed_view_mut::<1, 5>(j, 8).copy_from(&column.transpose());
                }
                let mut right = SVector::<f64, 13>::zeros();
                right.fixed_rows_mut::<8>(0).copy_from(&-forces);
                right.fixed_rows_mut::<5>(8).copy_from(&-rest);
                matrix.lu().solve(&right).map_or(SVector::repeat(f64::NAN), |solved| solved.fixed_rows::<8>(0).into())
            }
        }
        const START: ([f64; 8], [f64; 8]) =
            ([0.0, 0.0, 0.1, 0.05, 0.0, 0.02, 0.0, 0.0], [4.0, 0.4, 0.0, 0.1, 0.0, 0.05, 13.0, 11.0]);
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
