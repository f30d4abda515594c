// Rotations that are coordinates.

// Kinds by other names, and a rotation that is given.
pub mod rotations_of_other_kinds {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Body {
            param m;
            coord R: rotation, A: quaternion, n: directions;
            coord G: rotation = rotation_z(t);
            T = body(m, [1, 2, 3], frame(world, [0, 0, 0], R));
            V = 0;
        }
    }

    pub fn main() {}
}

// Parameters that are rotations are single ones, given to `new`, and no numbers; inputs are none.
pub mod rotations_that_are_parameters {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Body {
            param m, R: rotation, P: [rotation; 2], B: rotation = rotation_x(0.1), u: angle;
            input v: rotation;
            coord phi;
            let a = R[0];
            let b = R + 1;
            T = body(m, [1, 2, 3], frame(world, [0, 0, 0], R * rotation_z(phi)));
            V = 0;
        }
    }

    pub fn main() {}
}

// A rotation is no number, no angle and no array, and has a unit length by itself.
pub mod rotations_where_numbers_are_wanted {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Body {
            param m, k;
            coord R: rotation, P: [rotation; 2];
            let hull = frame(world, [0, 0, 0], R);
            let a = 2 * R;
            let b = R[0];
            let c = rotation_z(R);
            let d = R.euler_angles();
            let e = R.norm();
            let f = frame(world, [0, 0, 0], P);
            let h = dot(R) + 1;
            let i = R.x;
            let j = P[0].0;
            let l = R.quaternion();
            let n = k * dot(R * P[0]).sin();
            Q[P[0]] = dot(R) * dot(R);
            T = body(m, [1, 2, 3], hull) + 0.5 * dot(R).powi(2);
            V = k * R;
            constraint unit: R == P[0];
            observe attitude_R = hull.vector([1, 0, 0]);
        }
    }

    pub fn main() {}
}

// Moments on a rotation: three of them, in the turned axes, and once.
pub mod moments_of_other_shapes {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Body {
            param m;
            coord R: rotation, P: [rotation; 2];
            T = body(m, [1, 2, 3], frame(world, [0, 0, 0], R)) + body(m, [1, 2, 3], frame(world, [0, 0, 0], P[0]))
                + body(m, [1, 2, 3], frame(world, [0, 0, 0], P[1]));
            V = 0;
            Q[R] = 1;
            Q[R[0]] = 1;
            Q[P] = [1, 2, 3];
            Q[P[0]] = [1, 2, 3];
            Q[P[0]] = [1, 2, 3];
        }
    }

    pub fn main() {}
}

// A direction is a vector of length 1 by itself.
pub mod directions_of_other_kinds {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Pendulum {
            param m, l, n0: direction;
            coord n: direction, k: direction = [0, 0, 1], p: [direction; 2];
            T = 0.5 * m * (l * dot(n)).norm_squared() + p[0].x;
            V = m * n;
            Q[n] = 3;
            observe direction_n = l * n;
            restriction Planar: n[1] = 0;
        }
    }

    pub fn main() {}
}

// Its length is 1 already.
pub mod length_on_top {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Pendulum {
            param m, l;
            coord n: direction;
            T = 0.5 * m * (l * dot(n)).norm_squared();
            V = m * n[2];
            constraint unit: n.norm_squared() == 1;
        }
    }

    pub fn main() {}
}

pub mod rates_and_elements_of_a_rotation {
    use lagrange_runtime::prelude::*;
    lagrangian! {
        system Turned {
            coord R: rotation;
            let hub = frame(world, [0, 0, 0], R);
            T = body(1, [1, 1, 1], hub);
            V = R[2];
            rate(R) = 1;
        }
    }
}

// Nothing turns with it: said once for its three parameters.
pub mod without_inertia {
    use lagrange_runtime::prelude::*;
    lagrangian! {
        system Turned {
            coord R: rotation, P: rotation;
            let hub = frame(world, [0, 0, 0], R);
            T = body(1, [1, 1, 1], hub);
            V = 0;
        }
    }
}

// Two vectors of length 1 that agree in two components agree.
pub mod three_components_of_a_direction {
    use lagrange_runtime::prelude::*;
    lagrangian! {
        system Upright {
            coord R: rotation;
            let hub = frame(world, [0, 0, 0], R);
            T = body(1, [1, 1, 1], hub);
            V = 0;
            constraint up: R * [0, 0, 1] == [0, 0, 1];
        }
    }
}

// Along n there is inertia once, by r, and n · dot(n) = 0 is a constraint.
pub mod length_times_direction {
    use lagrange_runtime::prelude::*;
    lagrangian! {
        system Planet {
            coord r: length, n: direction;
            let place = r * n;
            T = 0.5 * dot(place).norm_squared();
            V = -1 / r;
        }
    }
}

pub mod kind_in_the_plural {
    use lagrange_runtime::prelude::*;
    lagrangian! {
        system Pendulum {
            coord n: directions;
            T = 0.5 * dot(n).norm_squared();
            V = n[2];
        }
    }
}

pub mod function_by_another_name {
    use lagrange_runtime::prelude::*;
    lagrangian! {
        system Turned {
            coord R: rotation;
            let body = frame(world, [0, 0, 0], R);
            T = body(1, [1, 1, 1], body);
            V = 0;
        }
    }
}

fn main() {}
