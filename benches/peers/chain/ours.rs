//! Our accelerations of the chain with unit masses and lengths, as functions of C.

use lagrange_runtime::prelude::*;

macro_rules! chains {
    ($($module:ident $function:ident $n:tt),*) => {$(
        mod $module {
            use super::*;

            lagrangian! {
                pub system Links {
                    const N = $n;
                    coord th: [N];
                    let x: [N] = |i| if i == 0 { 0 } else { x[i - 1] } + th[i].sin();
                    let y: [N] = |i| if i == 0 { 0 } else { y[i - 1] } - th[i].cos();
                    T = (0..N).map(|i| 0.5 * (dot(x[i]).powi(2) + dot(y[i]).powi(2))).sum();
                    V = (0..N).map(|i| 9.81 * y[i]).sum();
                }
            }

            #[unsafe(no_mangle)]
            extern "C" fn $function(q: &[f64; $n], w: &[f64; $n], a: &mut [f64; $n]) {
                *a = Links::new().accel(&(*q).into(), &(*w).into(), 0.0).into();
            }
        }
    )*};
}

chains!(
    two accel_2 2, three accel_3 3, four accel_4 4, six accel_6 6, eight accel_8 8, twelve accel_12 12,
    sixteen accel_16 16, twenty_four accel_24 24, thirty_two accel_32 32
);
