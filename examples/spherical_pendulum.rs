//! Path of a spherical pendulum, seen from above: an ellipse that turns, between two circles. Its rod is a direction,
//! which has no poles: the same pendulum goes over the top, through both points at which angles end.
//!
//! `cargo run --release --example spherical_pendulum`

#[path = "support/checks.rs"]
mod checks;
#[path = "support/mod.rs"]
mod support;

use checks::Checks;
use lagrange_runtime::chart::{Axis, Chart, Series};
use lagrange_runtime::prelude::*;
use lagrange_runtime::testing::reference::SimplePendulum;
use std::error::Error;
use std::f64::consts::TAU;

lagrangian! {
    /// n is the direction of the rod.
    pub system SphericalPendulum {
        param m, l, g = 9.81;
        coord n: direction;
        let place = l * n;
        T = 0.5 * m * dot(place).norm_squared();
        V = m * g * place[2];
        observe bob = [place[0], place[1]];
        event turning: dot(n)[2], rising, terminal;
    }
}

pub(crate) fn main() -> Result<(), Box<dyn Error>> {
    let pendulum = SphericalPendulum::new(0.9, 1.1);
    let rest = State::new(0.0, [0.0; 3], [0.0; 3]);
    let (outside, aside) = (Vector3::new(1f64.sin(), 0.0, -1f64.cos()), Vector3::y() * 1.2 * 1f64.sin());
    let start = pendulum.with_direction_n(rest, &outside, &aside);
    let run = || integrate(&pendulum, Dop853, PiController::tolerance(1e-12), start);
    let angle = |n: &Vector3<f64>| (-n.z).acos();

    // The bob comes in, and goes out again where it begins to rise.
    let inner = run().until(10.0).events(SphericalPendulum::TURNING).next();
    let inner = pendulum.direction_n(&inner.ok_or("it does not turn back")??.state);
    let advance = 4.0 * inner.y.atan2(inner.x) - TAU;
    println!(
        "θ between {:.6} and 1 rad; the ellipse turns by {advance:.6} rad each time round",
        angle(&inner)
    );
    let mut checks = Checks::default();
    // Energy and the vertical angular momentum at both turning points, where the speed is sin θ φ̇.
    let vertical =
        |theta: f64, turn: f64| 0.5 * (turn / theta.sin()).powi(2) - pendulum.g / pendulum.l * theta.cos();
    let turn = 1.2 * 1f64.sin().powi(2);
    checks.at_most(
        "energy at the inner circle",
        (vertical(angle(&inner), turn) - vertical(1.0, turn)).abs(),
        1e-10,
    );

    // Over the top, through the lowest and the highest point: a plane pendulum, in closed form.
    let over = pendulum.with_direction_n(rest, &-Vector3::z(), &Vector3::new(6.0, 4.5, 0.0));
    let known = SimplePendulum::new(pendulum.g, pendulum.l, 0.0, 7.5);
    let mut missed = 0f64;
    for sample in integrate(&pendulum, Dop853, PiController::tolerance(1e-12), over)
        .until(20.0)
        .sample((1..200).map(|k| 0.1 * f64::from(k)))
    {
        let sample = sample?;
        let (theta, _) = known.state(sample.t);
        let exact = Vector3::new(0.8, 0.6, 0.0) * theta.sin() - Vector3::z() * theta.cos();
        missed = missed.max((pendulum.direction_n(&sample) - exact).norm());
    }
    checks.holds("it goes over the top", known.state(20.0).0 > TAU);
    checks.at_most("through both poles, against Jacobi's functions", missed, 1e-9);

    let end = 16.0;
    let frames = run()
        .until(end)
        .sample((0..=3000).map(|k| end * f64::from(k) / 3000.0))
        .collect::<Result<Vec<_>, _>>()?;
    let circle = |theta: f64| {
        let rho = pendulum.l * theta.sin();
        (0..=180).map(move |k| TAU * f64::from(k) / 180.0).map(move |phi| (rho * phi.cos(), rho * phi.sin()))
    };
    let gap = [(f64::NAN, f64::NAN)];
    let folder = support::charts()?;
    Chart::new("Spherical pendulum from above", Axis::linear("x", "m"), Axis::linear("y", "m"))
        .subtitle(format!("length {} m, let go at θ = 1 rad with φ̇ = 1.2 rad/s, {end} s", pendulum.l))
        .equal_aspect()
        .with(Series::line("bob", frames.iter().map(|at| pendulum.bob_at(at)).map(|bob| (bob[0], bob[1]))))
        .with(Series::line("turning circles", circle(1.0).chain(gap).chain(circle(angle(&inner)))))
        .write(&folder, "spherical-pendulum")?;
    println!("{}", folder.join("spherical-pendulum.svg").display());
    checks.report()?;
    Ok(())
}
