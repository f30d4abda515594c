//! Placeholder.
#![allow(missing_docs)]
use lagrange_runtime::SVector;
use lagrange_runtime::prelude::*;
lagrangian! {
    /// A pendulum.
    pub system Pendulum {
        param m, l, g = 9.81;
        coord theta;
        T = 0.5 * m * (l * dot(theta)).powi(2);
        V = -m * g * l * cos(theta);
    }
}
lagrangian! { pub system Kepler { param m, mu; coord r, phi;
T = 0.5 * m * (dot(r).powi(2) + (r * dot(phi)).powi(2)); V = -mu * m / r; } }
lagrangian! { pub system Top { param m, g = 9.81, l, I1, I3; coord phi, theta, psi;
T = 0.5 * I1 * (dot(theta).powi(2) + (dot(phi) * theta.sin()).powi(2)) + 0.5 * I3 * (dot(psi) + dot(phi) * theta.cos()).powi(2);
V = m * g * l * theta.cos(); } }
lagrangian! { pub system Double { param m1, m2, l1, l2, g = 9.81; coord a, b;
T = 0.5 * (m1 + m2) * (l1 * dot(a)).powi(2) + 0.5 * m2 * (l2 * dot(b)).powi(2) + m2 * l1 * l2 * dot(a) * dot(b) * cos(a - b);
V = -(m1 + m2) * g * l1 * a.cos() - m2 * g * l2 * b.cos(); } }
lagrangian! { pub system DoubleXy { param m1, m2, l1, l2, g = 9.81; coord a, b;
let x1 = l1 * a.sin(); let y1 = -l1 * a.cos();
let x2 = x1 + l2 * b.sin(); let y2 = y1 - l2 * b.cos();
T = 0.5 * m1 * (dot(x1).powi(2) + dot(y1).powi(2)) + 0.5 * m2 * (dot(x2).powi(2) + dot(y2).powi(2));
V = m1 * g * y1 + m2 * g * y2; } }

lagrangian! {
    pub system Chain1 {
        const N = 1;
        coord th: [N];
        let x: [N] = |i| if i == 0 { th[0].sin() } else { x[i - 1] + th[i].sin() };
        let y: [N] = |i| if i == 0 { -th[0].cos() } else { y[i - 1] - th[i].cos() };
        T = (0..N).map(|i| 0.5 * (dot(x[i]).powi(2) + dot(y[i]).powi(2))).sum();
        V = (0..N).map(|i| 9.81 * y[i]).sum();
    }
}

lagrangian! {
    pub system Chain2 {
        const N = 2;
        coord th: [N];
        let x: [N] = |i| if i == 0 { th[0].sin() } else { x[i - 1] + th[i].sin() };
        let y: [N] = |i| if i == 0 { -th[0].cos() } else { y[i - 1] - th[i].cos() };
        T = (0..N).map(|i| 0.5 * (dot(x[i]).powi(2) + dot(y[i]).powi(2))).sum();
        V = (0..N).map(|i| 9.81 * y[i]).sum();
    }
}

lagrangian! {
    pub system Chain3 {
        const N = 3;
        coord th: [N];
        let x: [N] = |i| if i == 0 { th[0].sin() } else { x[i - 1] + th[i].sin() };
        let y: [N] = |i| if i == 0 { -th[0].cos() } else { y[i - 1] - th[i].cos() };
        T = (0..N).map(|i| 0.5 * (dot(x[i]).powi(2) + dot(y[i]).powi(2))).sum();
        V = (0..N).map(|i| 9.81 * y[i]).sum();
    }
}

lagrangian! {
    pub system Chain4 {
        const N = 4;
        coord th: [N];
        let x: [N] = |i| if i == 0 { th[0].sin() } else { x[i - 1] + th[i].sin() };
        let y: [N] = |i| if i == 0 { -th[0].cos() } else { y[i - 1] - th[i].cos() };
        T = (0..N).map(|i| 0.5 * (dot(x[i]).powi(2) + dot(y[i]).powi(2))).sum();
        V = (0..N).map(|i| 9.81 * y[i]).sum();
    }
}

lagrangian! {
    pub system Chain6 {
        const N = 6;
        coord th: [N];
        let x: [N] = |i| if i == 0 { th[0].sin() } else { x[i - 1] + th[i].sin() };
        let y: [N] = |i| if i == 0 { -th[0].cos() } else { y[i - 1] - th[i].cos() };
        T = (0..N).map(|i| 0.5 * (dot(x[i]).powi(2) + dot(y[i]).powi(2))).sum();
        V = (0..N).map(|i| 9.81 * y[i]).sum();
    }
}

lagrangian! {
    pub system Chain8 {
        const N = 8;
        coord th: [N];
        let x: [N] = |i| if i == 0 { th[0].sin() } else { x[i - 1] + th[i].sin() };
        let y: [N] = |i| if i == 0 { -th[0].cos() } else { y[i - 1] - th[i].cos() };
        T = (0..N).map(|i| 0.5 * (dot(x[i]).powi(2) + dot(y[i]).powi(2))).sum();
        V = (0..N).map(|i| 9.81 * y[i]).sum();
    }
}
fn main() {
    println!(
        "Pendulum {:?} {:?}",
        <Pendulum as Lagrangian<1>>::FACTS.operations,
        <Pendulum as Lagrangian<1>>::FACTS.operations.arithmetic()
    );
    println!(
        "Kepler {:?} {:?}",
        <Kepler as Lagrangian<2>>::FACTS.operations,
        <Kepler as Lagrangian<2>>::FACTS.operations.arithmetic()
    );
    println!(
        "Top {:?} {:?}",
        <Top as Lagrangian<3>>::FACTS.operations,
        <Top as Lagrangian<3>>::FACTS.operations.arithmetic()
    );
    println!(
        "Double {:?} {:?}",
        <Double as Lagrangian<2>>::FACTS.operations,
        <Double as Lagrangian<2>>::FACTS.operations.arithmetic()
    );
    println!(
        "DoubleXy {:?} {:?}",
        <DoubleXy as Lagrangian<2>>::FACTS.operations,
        <DoubleXy as Lagrangian<2>>::FACTS.operations.arithmetic()
    );
    println!(
        "1 {:?} {}",
        <Chain1 as Lagrangian<1>>::FACTS.operations,
        <Chain1 as Lagrangian<1>>::FACTS.operations.arithmetic()
    );
    println!(
        "2 {:?} {}",
        <Chain2 as Lagrangian<2>>::FACTS.operations,
        <Chain2 as Lagrangian<2>>::FACTS.operations.arithmetic()
    );
    println!(
        "3 {:?} {}",
        <Chain3 as Lagrangian<3>>::FACTS.operations,
        <Chain3 as Lagrangian<3>>::FACTS.operations.arithmetic()
    );
    println!(
        "4 {:?} {}",
        <Chain4 as Lagrangian<4>>::FACTS.operations,
        <Chain4 as Lagrangian<4>>::FACTS.operations.arithmetic()
    );
    println!(
        "6 {:?} {}",
        <Chain6 as Lagrangian<6>>::FACTS.operations,
        <Chain6 as Lagrangian<6>>::FACTS.operations.arithmetic()
    );
    println!(
        "8 {:?} {}",
        <Chain8 as Lagrangian<8>>::FACTS.operations,
        <Chain8 as Lagrangian<8>>::FACTS.operations.arithmetic()
    );
    let a = Chain8::new().accel(
        &SVector::from([0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8]),
        &SVector::from([1.0; 8]),
        0.0,
    );
    println!("{a:?}");
}
