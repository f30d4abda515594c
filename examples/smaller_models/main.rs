//! Models of one scene against each other: error of an output against operations per simulated second, for models,
//! methods and tolerances together, and breakdown maps, which show the smallest model that holds.
//!
//! ```text
//! cargo run --release --example smaller_models
//! ```
//!
//! | file | concern |
//! |---|---|
//! | `systems.rs` | the systems and their models |
//! | `motion.rs` | motions of models, as what is seen of them and what they cost |
//! | `maps.rs` | breakdown maps, and closed forms for the models |

#[path = "../support/checks.rs"]
mod checks;
mod maps;
mod motion;
#[path = "../support/mod.rs"]
mod support;
mod systems;

use checks::Checks;
use lagrange_runtime::Facts;
use lagrange_runtime::chart::{Axis, Breakdown, Chart, Panels, Series};
use lagrange_runtime::method::explicit_rk::Tsitouras5;
use lagrange_runtime::prelude::*;
use motion::{Motion, Scene};
use std::error::Error;
use systems::{Car, Linear, Planar, Quartic, Rigid, Slow, Spatial};

/// A body of 300 kg on a wheel of 40 kg, whose tyre is so much stiffer than the spring, over bumps at a rate.
fn car(stiffness: f64, omega: f64) -> Car {
    Car::new(300.0, 40.0, 2e4, 200.0, 2e4 * stiffness, omega)
}

/// Curves of error against operations per simulated second, one for each model and method.
struct Curves {
    chart: Chart,
    reference: Motion,
}

impl Curves {
    fn new(title: &str, reference: Motion) -> Self {
        let cost = Axis::log("operations per simulated second", "");
        Curves { chart: Chart::new(title, cost, Axis::log("error of the place", "m")), reference }
    }

    /// Adds the runs of a model by a method, over tolerances or steps.
    fn add<T>(
        &mut self,
        name: &str,
        facts: &Facts,
        settings: impl IntoIterator<Item = T>,
        run: impl Fn(T) -> Result<Motion, Failure<f64>>,
    ) -> Result<(), Failure<f64>> {
        let mut points = Vec::new();
        for setting in settings {
            let motion = run(setting)?;
            points.push((motion.cost(facts), motion.error(&self.reference)));
        }
        self.chart.series.push(Series::new(name, points));
        Ok(())
    }

    /// The last point of a curve: operations and error.
    fn last(&self, name: &str) -> (f64, f64) {
        let series = self.chart.series.iter().find(|series| series.name == name);
        series.and_then(|series| series.points.last()).copied().unwrap_or((f64::NAN, f64::NAN))
    }
}

/// Ten tolerances, from so many digits on.
fn tolerances(digits: i32) -> impl Iterator<Item = f64> {
    (digits..digits + 10).map(|digits| 10f64.powi(-digits))
}

fn pi(tolerance: f64) -> PiController<f64> {
    PiController::tolerance(tolerance)
}

/// Taylor's method at the tolerance of the reference.
fn finest() -> (Taylor, TaylorController<f64>) {
    (Taylor, TaylorController::tolerance(1e-14))
}

fn double_pendulum(checks: &mut Checks) -> Result<Chart, Box<dyn Error>> {
    let system = Spatial::new(1.0, 1.0, 0.5, 0.5);
    let start = State::new(0.0, [0.15, 0.0, 0.3, 0.0], [0.0; 4]);
    let scene = Scene { whole: &system, start, end: 5.0, output: |system, s| system.tip_at(s) };
    let (method, controller) = finest();
    // The reference is another method, at a far smaller error.
    let mut curves = Curves::new("A double pendulum from 0.15 and 0.3 rad", scene.by(method, controller)?);
    let [space, plane, quartic, linear] =
        [&Spatial::<f64>::FACTS, &Planar::<f64>::FACTS, &Quartic::<f64>::FACTS, &Linear::<f64>::FACTS];
    curves.add("in space, DOP853", space, tolerances(2), |tol| scene.by(Dop853, pi(tol)))?;
    curves.add("in its plane, DOP853", plane, tolerances(2), |tol| {
        scene.model::<Planar, 2, 2, _, _>(Dop853, pi(tol))
    })?;
    curves.add("in its plane, Tsitouras 5", plane, tolerances(2), |tol| {
        scene.model::<Planar, 2, 2, _, _>(Tsitouras5, pi(tol))
    })?;
    curves.add("energies to order 4, DOP853", quartic, tolerances(2), |tol| {
        scene.model::<Quartic, 2, 2, _, _>(Dop853, pi(tol))
    })?;
    curves.add("energies to order 4, Tsitouras 5", quartic, tolerances(2), |tol| {
        scene.model::<Quartic, 2, 2, _, _>(Tsitouras5, pi(tol))
    })?;
    curves.add("small oscillations, DOP853", linear, tolerances(2), |tol| {
        scene.model::<Linear, 2, 2, _, _>(Dop853, pi(tol))
    })?;
    let last = |name| curves.last(name);
    let (whole, planar) = (last("in space, DOP853"), last("in its plane, DOP853"));
    checks.at_most("error of the whole system", whole.1, 1e-9);
    checks.at_most("of the plane, which is exact", planar.1, 1e-9);
    checks.at_most("its operations, in parts of those of the whole", planar.0 / whole.0, 0.5);
    let floors = [last("energies to order 4, DOP853").1, last("small oscillations, DOP853").1];
    checks.holds("models have errors of their own", floors[0] > 1e-5 && floors[1] > 10.0 * floors[0]);
    Ok(curves.chart)
}

fn quarter_car(checks: &mut Checks) -> Result<Chart, Box<dyn Error>> {
    let system = car(300.0, 2.0);
    let start = State::new(0.0, [0.0; 2], [0.0; 2]);
    let scene = Scene { whole: &system, start, end: 5.0, output: |system, s| system.height_at(s) };
    let (method, controller) = finest();
    let title = "A quarter of a car, its tyre 300 times as stiff as its spring";
    let mut curves = Curves::new(title, scene.by(method, controller)?);
    let [stiff, slow, rigid] = [&Car::<f64>::FACTS, &Slow::<f64>::FACTS, &Rigid::<f64>::FACTS];
    curves.add("elastic tyre, DOP853", stiff, tolerances(5), |tol| scene.by(Dop853, pi(tol)))?;
    curves.add("elastic tyre, Radau IIA 5", stiff, tolerances(3), |tol| scene.by(Radau5, pi(tol)))?;
    curves.add("tyre in statics, DOP853", slow, tolerances(5), |tol| {
        scene.model::<Slow, 1, 1, _, _>(Dop853, pi(tol))
    })?;
    curves.add("tyre in statics, Tsitouras 5", slow, tolerances(3), |tol| {
        scene.model::<Slow, 1, 1, _, _>(Tsitouras5, pi(tol))
    })?;
    curves.add("rigid tyre, DOP853", rigid, tolerances(5), |tol| {
        scene.model::<Rigid, 1, 1, _, _>(Dop853, pi(tol))
    })?;
    curves.add("rigid tyre, Tsitouras 5", rigid, tolerances(3), |tol| {
        scene.model::<Rigid, 1, 1, _, _>(Tsitouras5, pi(tol))
    })?;
    let [whole, slow, rigid] = ["elastic tyre, DOP853", "tyre in statics, DOP853", "rigid tyre, DOP853"]
        .map(|name| curves.last(name));
    checks.at_most("a tyre in statics, in parts of the error of a rigid one", slow.1 / rigid.1, 0.2);
    checks.at_most("its operations, in parts of those of the whole", slow.0 / whole.0, 0.5);
    Ok(curves.chart)
}

/// Draws the charts, with so many places along each axis of the maps.
pub fn draw(count: u32) -> Result<(), Box<dyn Error>> {
    let mut checks = Checks::default();
    let charts = [double_pendulum(&mut checks)?, quarter_car(&mut checks)?];
    let maps = maps::maps(count, &mut checks)?;
    let chain = maps::chain(count, &mut checks)?;
    let folder = support::charts()?;
    Panels::new("Which model and method is cheapest?", charts.map(Chart::with_frontier))
        .subtitle(
            "Grey: runs of all models, methods and tolerances. In colour: those that no other one beats. A model that \
             is not exact has an error that no tolerance lowers.",
        )
        .write(&folder, "smaller-models")?;
    Panels::new("Which model is enough?", maps.iter().map(Breakdown::chart))
        .subtitle("The smallest model whose outputs keep the error allowed over the whole scene.")
        .write(&folder, "breakdown-maps")?;
    chain.write(&folder, "modes-of-a-chain")?;
    for name in ["smaller-models", "breakdown-maps", "modes-of-a-chain"] {
        println!("{}", folder.join(name).with_extension("png").display());
    }
    Ok(checks.report()?)
}

#[allow(dead_code)] // Tests draw coarser maps.
fn main() -> Result<(), Box<dyn Error>> {
    draw(20)
}
