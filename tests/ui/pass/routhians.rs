// Routhians that are private, documented, of arrays, of bindings, with drives and forces.
#![deny(warnings, missing_docs)]
//! Test.
use lagrange_runtime::prelude::*;

lagrangian! {
    /// Two beads on a wheel that spins freely, one of them pushed.
    pub system Wheel {
        const N = 2;
        param I, m, k: [N], a = 0.1, omega = 2.0, c;
        coord x: [length; N], turn: angle;
        coord lift = a * sin(omega * t);
        let px: [N] = |i| x[i] * cos(turn);
        let py: [N] = |i| x[i] * sin(turn);
        T = 0.5 * I * dot(turn).powi(2)
            + (0..N).map(|i| 0.5 * m * (dot(px[i]).powi(2) + dot(py[i]).powi(2) + dot(lift).powi(2))).sum();
        V = (0..N).map(|i| 0.5 * k[i] * (x[i] - 1).powi(2)).sum();
        D = 0.5 * c * dot(x[0]).powi(2);
        force [-c * dot(turn) * cos(turn), -c * dot(turn) * sin(turn)] at [px[1], py[1]];
        observe first = [px[0], py[0]];
        observe distance = x;
        /// The beads alone.
        #[derive(PartialOrd)]
        routhian Beads;
    }
}

fn main() {
    let wheel = Wheel::new(1.0, 0.5, [2.0, 3.0], 0.1);
    let start = State::new(0.3, [1.1, 0.8, 4.0], [0.2, -0.1, 0.7]);
    let (beads, state) = wheel.reduce(&start);
    let (part, whole) =
        (beads.accel(&state.q, &state.qd, state.t), wheel.accel(&start.q, &start.qd, start.t));
    assert!((part[0] - whole[0]).abs() + (part[1] - whole[1]).abs() < 1e-14);
    let back = beads.expand(&state, &[4.0].into());
    assert!((back.qd[2] - 0.7).abs() < 1e-15 && back.q == start.q);
    assert_eq!(beads.distance(&state.q, &state.qd, 0.0), state.q);
    assert!((beads.power(&state.q, &state.qd, 0.3) - wheel.power(&start.q, &start.qd, 0.3)).abs() < 1e-15);
    let same = beads;
    assert!(beads <= same);
}
