// Masses and moments of inertia below zero, and a tensor that is negative about an oblique axis.
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

fn main() {}
