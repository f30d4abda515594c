//! Particle in cylindrical coordinates of a frame that moves along its axis as ζ(t). Section 11.3; gravity and the
//! history of ζ are a choice.

use super::harness::{Row, State, Subject};
use lagrange_runtime::prelude::lagrangian;

lagrangian! {
    /// zh is the height in the moving frame.
    pub system MovingFrame {
        param m, a, om, g = 9.81;
        coord r, phi, zh;
        coord zeta = a * sin(om * t);
        let x = r * phi.cos();
        let y = r * phi.sin();
        let z = zh + zeta;
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2));
        V = m * g * z;
        observe particle = [x, y, z];
    }
}

golden!(MovingFrame<3>, "sec-11.3-moving-cylindrical-frame", |p| MovingFrame {
    m: p("m"),
    a: p("A"),
    om: p("Om"),
    g: p("g")
});

/// In the plane the motion is along a straight line: ẍ = 0.
pub fn rows() -> Vec<Row> {
    let row = Row::of::<MovingFrame, 3>(
        "quadratic, ignorable phi, blocks r phi | zh",
        [0.4..2.0, -3.0..3.0, -2.0..2.0],
    );
    let subject = Subject::of::<MovingFrame, 3>();
    let row = row.balances("ẍ = 0", |at: &State| {
        let a = subject.accelerations(at);
        let ((sin, cos), r, rd, phid) = (at.q[1].sin_cos(), at.q[0], at.qd[0], at.qd[1]);
        vec![a[0] * cos, -2.0 * rd * phid * sin, -r * a[1] * sin, -r * phid * phid * cos]
    });
    vec![row]
}
