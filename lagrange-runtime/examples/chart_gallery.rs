//! Every kind of chart, written to the folder given (by default the one for temporary files).
//!
//!     cargo run -p lagrange-runtime --features chart --example chart_gallery -- target

use lagrange_runtime::chart::{Axis, Chart, ChartError, Series};
use lagrange_runtime::testing::reference::{KeplerOrbit, SimplePendulum};

fn main() -> Result<(), ChartError> {
    let folder = std::env::args().nth(1).map_or_else(std::env::temp_dir, Into::into);
    work_precision().write(&folder, "gallery-work-precision")?;
    time_series().write(&folder, "gallery-time-series")?;
    phase_portrait().write(&folder, "gallery-phase-portrait")?;
    orbits().write(&folder, "gallery-orbits")?;
    section().write(&folder, "gallery-section")?;
    println!("written to {}", folder.display());
    Ok(())
}

/// Made-up methods of given order, cost and rounding plateau, to see many curves at once.
fn work_precision() -> Chart {
    let methods = [
        ("Explicit Euler", 1.0, 1.2e-6, 5e-15),
        ("Störmer–Verlet", 2.0, 1.0e-6, 4e-15),
        ("RK4", 4.0, 1.6e-6, 3e-15),
        ("Dormand–Prince 5(4)", 5.0, 2.6e-6, 2e-15),
        ("Gauss–Legendre 6", 6.0, 6.0e-6, 1.2e-15),
        ("DOP853", 8.0, 5.0e-6, 2.2e-15),
        ("Radau IIA 5", 5.0, 1.5e-5, 6e-15),
        ("Taylor, order 20", 18.0, 8.0e-6, 9e-16),
    ];
    let axes = (Axis::log("time", "s"), Axis::log("error in θ at the end", "rad"));
    methods.iter().fold(
        Chart::new("Work and precision: simple pendulum, 10 periods", axes.0, axes.1).subtitle(
            "from θ = 1 rad at rest; reference: Jacobi’s elliptic functions; below and left is better",
        ),
        |chart, (name, order, cost, plateau)| {
            let point = |i: i32| {
                let steps = 2.4_f64.powi(i + 1) * if *order > 10.0 { 0.7 } else { 1.0 };
                let wiggle = 1.0 + 0.4 * f64::sin(f64::from(i) * 2.0 + order);
                (
                    cost * steps,
                    (0.15 * (0.9 * steps).powf(-order) * wiggle).max(0.0)
                        + plateau * wiggle * steps.sqrt().min(9.0),
                )
            };
            chart.with(Series::new(*name, (1..=12).map(point)))
        },
    )
}

fn time_series() -> Chart {
    let chart = Chart::new("Simple pendulum", Axis::linear("t", "s"), Axis::linear("θ", "rad"))
        .subtitle("released at rest; l = 0.85 m, g = 9.81 m/s²");
    [0.5, 1.5, 2.5, 3.1].into_iter().fold(chart, |chart, start| {
        let motion = SimplePendulum::new(9.81, 0.85, start, 0.0);
        let points = (0..=800).map(|i| f64::from(i) * 0.01).map(|t| (t, motion.state(t).0));
        chart.with(Series::line(format!("θ₀ = {start} rad"), points))
    })
}

fn phase_portrait() -> Chart {
    let chart =
        Chart::new("Phase portrait of the pendulum", Axis::linear("θ", "rad"), Axis::linear("θ̇", "rad/s"))
            .subtitle("ω₀ = 1 s⁻¹");
    [(0.5, 0.0), (1.2, 0.0), (2.0, 0.0), (2.8, 0.0), (-3.0, 0.7), (3.0, -0.7)].into_iter().fold(
        chart.equal_aspect(),
        |chart, (theta, thetad)| {
            let motion = SimplePendulum::new(1.0, 1.0, theta, thetad);
            let turns = if motion.rotates() { 0.96 } else { 1.0 };
            let points = (0..=400).map(|i| motion.state(motion.period() * turns * f64::from(i) / 400.0));
            let kind = if motion.rotates() { "rotation" } else { "libration" };
            chart.with(Series::line(format!("{kind}, θ₀ = {theta}, θ̇₀ = {thetad}"), points))
        },
    )
}

fn orbits() -> Chart {
    let chart = Chart::new("Kepler orbits", Axis::linear("x", "m"), Axis::linear("y", "m")).equal_aspect();
    [1.0, 1.15, 1.25].into_iter().fold(chart, |chart, speed| {
        let orbit = KeplerOrbit::new(1.0, [1.0, 0.0], [0.0, speed]).expect("slower than escape");
        let point = |i: i32| {
            let ([r, phi], _) = orbit.state(orbit.period() * f64::from(i) / 300.0);
            (r * phi.cos(), r * phi.sin())
        };
        chart.with(Series::new(format!("e = {:.3}", orbit.eccentricity()), (0..=300).map(point)))
    })
}

/// The standard map stands in for a Poincaré section.
fn section() -> Chart {
    let chart = Chart::new("Standard map, K = 0.9", Axis::linear("θ", "rad"), Axis::linear("p", ""));
    (1..=6).fold(chart, |chart, start| {
        let (mut theta, mut p) = (std::f64::consts::PI, f64::from(start) * 0.5);
        let points: Vec<_> = (0..1500)
            .map(|_| {
                p = (p + 0.9 * theta.sin()).rem_euclid(std::f64::consts::TAU);
                theta = (theta + p).rem_euclid(std::f64::consts::TAU);
                (theta, p)
            })
            .collect();
        chart.with(Series::markers(format!("p₀ = {:.1}", f64::from(start) * 0.5), points))
    })
}
