// Frames and rotations as numbers, and methods that they do not have.
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

fn main() {}
