// Frames, rotations and bodies.

// Frames of wrong parts: parents, places and rotations that are none.
pub mod frames_of_wrong_parts {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Arm {
            param m, l;
            coord theta;
            let a = frame(l, [0, 0, 0], rotation_z(theta));
            let b = frame(world, l, rotation_z(theta));
            let c = frame(world, [0, 0, 0, l]);
            let d = frame(world, [0, 0, 0], theta);
            let e = frame(world, [0, 0], rotation_z(theta));
            let f = frame(world, [dot(theta), 0, 0], rotation_z(theta));
            let g = frame(world);
            let h = frame(world, [l, 0], theta);
            let i = frame(h, [l, 0, 0]);
            let j = frame(world, [0, 0, l], rotation_z(theta));
            let k = frame(j, [l, 0]);
            T = particle(m, frame(j, [l, 0, 0]));
            V = 0;
        }
    }

    pub fn main() {}
}

// Frames and rotations as numbers, and methods that they do not have.
pub mod frames_where_numbers_are_wanted {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Top {
            param m, l, g;
            coord psi, theta;
            let turn = rotation_z(psi) * rotation_x(theta);
            let top = frame(world, [0, 0, 0], turn);
            let a = top.point([0, l]);
            let b = top.velocty();
            let c = top.point(l);
            let d = angular_velocity(turn);
            let e = top.point([0, 0, dot(psi)]);
            let f = 2 * top;
            let h = 2 * turn;
            let i = dot(top);
            let j = top[0];
            let k = if psi > 0 { top } else { world };
            let n = frames(world, [0, 0, 0]);
            T = particle(m, frame(top, [0, 0, l]));
            V = m * g * top;
            observe axes = top;
            constraint fixed: top.origin() == top;
            impulse blow at top;
        }
    }

    pub fn main() {}
}

// Rotations about no axis, an unknown one or one that moves, and matrices that do not rotate.
pub mod rotations_that_are_none {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Arm {
            param m, l;
            coord theta, phi;
            let a = frame(world, [0, 0, 0], rotation_w(theta));
            let b = frame(world, [0, 0, 0], rotation([0, 0, 0], theta));
            let c = frame(world, [0, 0, 0], rotation([sin(phi), cos(phi), 0], theta));
            let d = frame(world, [0, 0, 0], rotation([0, 1], theta));
            let e = frame(world, [0, 0, 0], rotation([[1, 0, 0], [0, 0.8, 0.7], [0, -0.7, 0.8]]));
            let f = frame(world, [0, 0, 0], rotation([[1, 0, 0], [0, 1, 0], [0, 0, -1]]));
            let g = frame(world, [0, 0, 0], rotation([[cos(theta), 0, 0], [0, 1, 0], [0, 0, 1]]));
            let h = frame(world, [0, 0, 0], rotation(theta));
            let i = frame(world, [0, 0, 0], rotation_x(dot(theta)));
            let j = frame(world, [0, 0, 0], rotation_x());
            let k = rotation_x(theta).transpose();
            let n = rotation_x(theta) * l;
            T = 0.5 * m * (dot(theta).powi(2) + dot(phi).powi(2));
            V = 0;
        }
    }

    pub fn main() {}
}

// Masses and moments of inertia below zero, and a tensor that is negative about an oblique axis.
pub mod bodies_of_negative_inertia {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Top {
            param m, I;
            coord psi, theta, phi, x, alpha;
            let top = frame(world, [x, 0, 0], rotation_z(psi) * rotation_x(theta) * rotation_z(phi));
            let disk = frame(world, [x, 0], alpha);
            let a = body(m, [I, 1 - 2, I], top);
            T = body(-m, [I, I, I], top)
                + body(-2, [I, I, I], top)
                + particle(-0.5, top)
                + body(m, [[2, 3, 0], [3, 2, 0], [0, 0, 1]], top)
                + body(m, [[2, -1, -1], [-1, 1, -1], [-1, -1, 2]], top)
                + body(m, -1, disk);
            V = 0;
        }
    }

    pub fn main() {}
}

// Bodies outside of T, of wrong inertia, and fixed in the world.
pub mod bodies_of_wrong_parts {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Top {
            param m, l, I;
            coord psi, theta, phi;
            let top = frame(world, [0, 0, 0], rotation_z(psi) * rotation_x(theta) * rotation_z(phi));
            let disk = frame(world, [psi, 0], theta);
            let a = body(m, I, top);
            let b = body(m, [I, I], top);
            let c = body(m, [[I, 0.1, 0], [0, I, 0], [0, 0, I]], top);
            let d = body(m, [I, I, I], world);
            let e = body(m, top);
            let f = body(m, [I, I, I], disk);
            let g = particle(m, [0, 0, l]);
            let h = particle(top, m);
            T = body(m, [I, I, I], top);
            V = body(m, [I, I, I], top);
            D = 0.5 * particle(m, frame(top, [0, 0, l]));
        }
    }

    pub fn main() {}
}

// Rotations by the names of other tools.
pub mod rotations_of_other_tools {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Disk {
            param I;
            coord phi;
            T = body(1, [I, I, I], frame(world, [0, 0, 0], rotz(phi)));
            V = 0;
        }
    }

    pub fn main() {}
}

fn main() {}
