// Forces and couples of wrong components, and at frames that do not move.
use lagrange_runtime::prelude::*;

lagrangian! {
    pub system Top {
        param m, l, I;
        coord psi, theta, phi, x;
        let top = frame(world, [0, 0, 0], rotation_z(psi) * rotation_x(theta) * rotation_z(phi));
        let disk = frame(world, [x, 0], theta);
        let slide = frame(world, [x, 0, 0], rotation_x(l));
        T = body(m, [I, I, I], frame(top, [0, 0, l])) + particle(m, slide);
        V = 0;
        force [m, 0, 0] at top;
        force [m, 0] at frame(top, [0, 0, l]);
        force [m, 0, 0] at disk;
        force [m, 0, 0] at world;
        couple m on top;
        couple [m, 0, 0] on disk;
        couple [m, 0, 0] on slide;
        couple [m, 0, 0] on world;
        couple [m, 0, 0] on [x, 0, 0];
        couple [m, 0, 0] at top;
        couple [m, 0, 0];
        force top at [x, 0, 0];
    }
}

fn main() {}
