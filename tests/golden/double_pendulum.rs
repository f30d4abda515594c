//! Double pendulum with general masses and lengths, angles from the downward vertical: by its angles, and by the
//! positions of the bobs, an indexed family. Problem 11.35; reconstructed, since the problem refers to another chapter.

use super::harness::{Row, list, number, with_reference};
use lagrange_runtime::Lagrangian;
use lagrange_runtime::prelude::{SVector, lagrangian};

lagrangian! {
    /// The double pendulum by its angles.
    pub system DoublePendulum {
        param m1, m2, l1, l2, g = 9.81;
        coord th1, th2;
        T = 0.5 * (m1 + m2) * (l1 * dot(th1)).powi(2)
            + 0.5 * m2 * (l2 * dot(th2)).powi(2)
            + m2 * l1 * l2 * dot(th1) * dot(th2) * (th1 - th2).cos();
        V = -(m1 + m2) * g * l1 * th1.cos() - m2 * g * l2 * th2.cos();
    }
}

golden!(DoublePendulum<2>, "prob-11.35-double-pendulum", |p| DoublePendulum {
    m1: p("m1"),
    m2: p("m2"),
    l1: p("l1"),
    l2: p("l2"),
    g: p("g")
});

lagrangian! {
    /// The double pendulum by its bobs: bob i hangs from bob i − 1.
    pub system PendulumOfBobs {
        const N = 2;
        param m: [N], l: [N], g = 9.81;
        coord th: [N];
        let x: [N] = |i| (0..i + 1).map(|j| l[j] * th[j].sin()).sum();
        let y: [N] = |i| -(0..i + 1).map(|j| l[j] * th[j].cos()).sum();
        T = (0..N).map(|i| 0.5 * m[i] * (dot(x[i]).powi(2) + dot(y[i]).powi(2))).sum();
        V = (0..N).map(|i| m[i] * g * y[i]).sum();
        observe tip = [x[N - 1], y[N - 1]];
    }
}

golden!(PendulumOfBobs<2>, "prob-11.35-double-pendulum", |p| PendulumOfBobs {
    m: [p("m1"), p("m2")],
    l: [p("l1"), p("l2")],
    g: p("g")
});

lagrangian! {
    /// The double pendulum by frames in the plane: the second is turned in the first by the difference of the angles.
    pub system PendulumOfFrames {
        param m1, m2, l1, l2, g = 9.81;
        coord th1, th2;
        let first = frame(world, [0, 0], th1);
        let second = frame(first, [0, -l1], th2 - th1);
        let tip = frame(second, [0, -l2]);
        T = particle(m1, second) + particle(m2, tip);
        V = m1 * g * second.origin()[1] + m2 * g * tip.origin()[1];
    }
}

golden!(PendulumOfFrames<2>, "prob-11.35-double-pendulum", |p| PendulumOfFrames {
    m1: p("m1"),
    m2: p("m2"),
    l1: p("l1"),
    l2: p("l2"),
    g: p("g")
});

/// Only the hanging one of the four equilibria is stable. Equal masses and lengths: ω² = (g/l)(2 ∓ √2) with
/// θ₂/θ₁ = ±√2.
pub fn rows() -> Vec<Row> {
    let facts = "scleronomic, conservative, quadratic";
    let row = Row::of::<DoublePendulum, 2>(facts, [-3.1..3.1, -3.1..3.1])
        .also::<PendulumOfBobs, 2>(facts)
        .also::<PendulumOfFrames, 2>(facts);
    let squares = row.subject().reference.special("equal_case")["p2_over_g_l"].clone();
    let pendulum =
        DoublePendulum { m2: 0.5, m1: 0.5, l1: 0.8, l2: 0.8, ..with_reference::<DoublePendulum, 2>() };
    let origin = SVector::from([0.0, 0.0]);
    let jacobian = pendulum.jacobian(&origin, &origin, 0.0).q;
    let mut row = row;
    for (square, ratio) in list(&squares).iter().map(number).zip([2.0f64.sqrt(), -(2.0f64.sqrt())]) {
        let square = square * pendulum.g / pendulum.l1;
        let mode = SVector::from([1.0, ratio]);
        for (got, expected) in (-jacobian * mode).iter().zip(&(mode * square)) {
            row = row.within("mode of the equal pendulum", *got, *expected, 1e-13 * jacobian.amax());
        }
    }
    vec![row]
}
