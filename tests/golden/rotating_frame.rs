//! Forces that keep a particle in uniform motion relative to a turning frame. Problem 11.12; reconstructed as its plane
//! case, since the problem refers to another chapter.
//!
//! Remark on the source: it calls −∂T/∂q a pseudoforce here and +∂T/∂q in (11.44); in ṗ = Q + ∂T/∂q the plus sign is
//! right. ∂T/∂q holds the centrifugal force but only half of the Coriolis force, the other half is in d(∂T/∂q̇)/dt.

use super::harness::{Quantity, Row, State, Subject, list, number, required};
use lagrange_runtime::prelude::lagrangian;

lagrangian! {
    /// x, y in the turning frame.
    pub system RotatingFrame {
        param m, om;
        coord x, y;
        coord theta = om * t;
        let u = x * theta.cos() - y * theta.sin();
        let v = x * theta.sin() + y * theta.cos();
        T = 0.5 * m * (dot(u).powi(2) + dot(v).powi(2));
        V = 0;
        Q[x] = -m * (2 * om * dot(y) + om.powi(2) * x);
        Q[y] = m * (2 * om * dot(x) - om.powi(2) * y);
    }
}

golden!(RotatingFrame<2>, "prob-11.12-uniform-motion-rotating-frame", |p| RotatingFrame {
    m: p("m"),
    om: p("om")
});

lagrangian! {
    /// Without forces.
    pub system FreeInFrame {
        param m, om;
        coord x, y;
        coord theta = om * t;
        let u = x * theta.cos() - y * theta.sin();
        let v = x * theta.sin() + y * theta.cos();
        T = 0.5 * m * (dot(u).powi(2) + dot(v).powi(2));
        V = 0;
    }
}

golden!(FreeInFrame<2>, "prob-11.12-uniform-motion-rotating-frame", |p| FreeInFrame {
    m: p("m"),
    om: p("om")
});

/// Inverse dynamics: what the free particle needs in order not to accelerate in the frame.
pub fn rows() -> Vec<Row> {
    let mut row = Row::of::<RotatingFrame, 2>(
        "separable, constant inertia, quadratic, linear, blocks x | y",
        [-2.0..2.0, -2.0..2.0],
    );
    let free = Subject::of::<FreeInFrame, 2>();
    let [m, om] = ["m", "om"].map(|name| free.reference.parameter(name));
    for case in list(&row.subject().reference.special("cases").clone()) {
        let [x, y, xdot, ydot] = ["x", "y", "xdot", "ydot"].map(|name| number(&case[name]));
        let state = State::new(&[x, y], &[xdot, ydot], 0.0);
        let size = m * om * (xdot.abs() + ydot.abs() + om * (x.abs() + y.abs()));
        for k in 0..2 {
            let [force, pseudoforce] = ["Q", "dTdq"].map(|name| number(&list(&case[name])[k]));
            let found = free.at("", &state).partial(Quantity::Kinetic, k)[0];
            row = row
                .reaction("Q", &free, (&state, &[0.0, 0.0]), k, force)
                .within("∂T/∂q", found, pseudoforce, 1e-13 * size)
                .show("Q_y", required(&free, &state, &[0.0, 0.0])[k].0, force);
        }
    }
    vec![row]
}
