//! The chain whose steps `series -- chain` times, and whose compilation build.py does.

/// The n-link chain of unit masses and links, absolute angles.
macro_rules! chain {
    ($name:ident, $n:literal) => {
        lagrangian! {
            pub system $name {
                const N = $n;
                param g = 9.81;
                coord th: [N];
                let x: [N] = |i| (if i == 0 { 0 } else { x[i - 1] }) + th[i].sin();
                let y: [N] = |i| (if i == 0 { 0 } else { y[i - 1] }) - th[i].cos();
                T = (0..N).map(|i| 0.5 * (dot(x[i]).powi(2) + dot(y[i]).powi(2))).sum();
                V = (0..N).map(|i| g * y[i]).sum();
            }
        }
    };
}
