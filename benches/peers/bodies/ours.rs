//! Our accelerations of bodies that tumble, as functions of C, and the operations of each.

use lagrange_runtime::prelude::*;

macro_rules! functions {
    ($module:ident, $accel:ident, $operations:ident, $n:tt) => {
        #[unsafe(no_mangle)]
        extern "C" fn $accel(q: &[f64; $n], w: &[f64; $n], a: &mut [f64; $n]) {
            *a = $module::Built::default().accel(&(*q).into(), &(*w).into(), 0.0).into();
        }

        #[unsafe(no_mangle)]
        extern "C" fn $operations() -> usize {
            $module::Built::<f64>::FACTS.operations.arithmetic()
        }
    };
}

mod body {
    use super::*;

    lagrangian! {
        /// A body that is thrown.
        pub system Built {
            param m = 2.0, J: [3] = [1, 2, 2.5], g = 9.81;
            coord x: [3], R: rotation;
            T = body(m, J, frame(world, x, R));
            V = m * g * x[2];
        }
    }
}

#[macro_use]
#[path = "../../builds/systems.rs"]
#[allow(unused_macros)]
mod systems;

mod chain {
    use super::*;

    ball_chain!();
}

mod arm {
    use super::*;

    floating_arm!();
}

functions!(body, accel_body, operations_body, 6);
functions!(chain, accel_chain, operations_chain, 24);
functions!(arm, accel_arm, operations_arm, 13);
