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

    // Let go at rest, it falls through θ = 0 after a quarter of its period.
    let run = integrate(&pendulum, Dop853, Pi::tolerance(1e-12), start).until(10.0);
    let bottom = run.events(Event::falling(|s| s.q[0]).terminal()).next().expect("it falls")?.state;
    let exact = SimplePendulum::new(pendulum.g, pendulum.l, start.q[0], 0.0).period();
    println!("period {:.10} s, by elliptic functions {exact:.10} s", 4.0 * bottom.t);

    let end = integrate(&pendulum, Dop853, Pi::tolerance(1e-12), start).until(1000.0 * exact).finish()?;
    let energy = |at: State<f64, 1>| pendulum.energy(&at.q, &at.qd, at.t);
    println!(
        "energy {:.10} J, changed by {:.0e} J in 1000 periods",
        energy(start),
        energy(end) - energy(start)
    );
    Ok(())
}
