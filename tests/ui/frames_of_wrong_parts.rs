// Frames of wrong parts: parents, places and rotations that are none.
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

fn main() {}
