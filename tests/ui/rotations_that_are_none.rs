// Rotations about no axis, an unknown one or one that moves, and matrices that do not rotate.
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

fn main() {}
