// Bodies outside of T, of wrong inertia, and fixed in the world.
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

fn main() {}
