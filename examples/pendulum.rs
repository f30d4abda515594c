//! A pendulum, in twenty lines: `cargo run --example pendulum`.

use lagrange_runtime::prelude::*;
use lagrange_runtime::reference::SimplePendulum;

lagrangian! {
    pub system Pendulum {
        param m, l, g = 9.81;
        coord theta;
        T = 0.5 * m * (l * dot(theta)).powi(2);
        V = -m * g * l * cos(theta);
    }
}

fn main() -> Result<(), Failure> {
    let pendulum = Pendulum::new(1.3, 0.85);
    let start = State::new(0.0, [2.0], [0.0]);
    let mut run = integrate(&pendulum, Dop853, Pi::tolerance(1e-12), start).until(10.0);

    // Let go at rest, it is at rest again after half a period: Newton's iteration for θ̇ = 0 within that step.
    let swing = run.find_map(|step| step.ok().filter(|step| step.to.qd[0] > 0.0)).expect("it swings back");
    let inside = run.dense(&swing);
    let mut half = inside.at(swing.to.t);
    for _ in 0..5 {
        half = inside.at(half.t - half.qd[0] / pendulum.accel(&half.q, &half.qd, half.t)[0]);
    }
    let exact = SimplePendulum::new(pendulum.g, pendulum.l, start.q[0], 0.0).period();
    println!("period {:.10} s, by elliptic functions {exact:.10} s", 2.0 * half.t);

    let energy = |at: State<f64, 1>| pendulum.energy(&at.q, &at.qd, at.t);
    let drift = energy(run.until(1000.0 * exact).finish()?) - energy(start);
    println!("energy {:.10} J, changed by {drift:.0e} J in 1000 periods", energy(start));
    Ok(())
}
