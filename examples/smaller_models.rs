//! Models of one scene against each other: error of an output against operations per simulated second, and the
//! amplitude up to which each model holds. A double pendulum in space, in its plane, and for small angles; a quarter
//! of a car on a stiff tyre, on one in statics, and on a rigid one.
//!
//! `cargo run --release --example smaller_models`

#[path = "support/checks.rs"]
mod checks;
#[path = "support/mod.rs"]
mod support;

use checks::Checks;
use lagrange_runtime::chart::{Axis, Chart, Panels, Series};
use lagrange_runtime::prelude::*;
use lagrange_runtime::{Controller, Facts};
use std::error::Error;

lagrangian! {
    /// Two masses on rods in space, by their angles in the plane of x and z, and across it.
    pub system Spatial {
        param m1, m2, l1, l2, g = 9.81;
        coord theta1: angle, phi1: angle, theta2: angle, phi2: angle;
        let x1 = l1 * theta1.sin() * phi1.cos();
        let y1 = l1 * phi1.sin();
        let z1 = -l1 * theta1.cos() * phi1.cos();
        let x2 = x1 + l2 * theta2.sin() * phi2.cos();
        let y2 = y1 + l2 * phi2.sin();
        let z2 = z1 - l2 * theta2.cos() * phi2.cos();
        T = 0.5 * m1 * (dot(x1).powi(2) + dot(y1).powi(2) + dot(z1).powi(2))
            + 0.5 * m2 * (dot(x2).powi(2) + dot(y2).powi(2) + dot(z2).powi(2));
        V = m1 * g * z1 + m2 * g * z2;
        observe tip = [x2, y2, z2];
        /// Exact: what starts in the plane stays in it.
        pub restriction Planar: [phi1, phi2] = 0;
        /// Energies to order 4.
        pub simplified Quartic: lock [phi1, phi2] = 0, expand [theta1, theta2] to 4 about 0;
        /// Small oscillations.
        pub simplified Linear: lock [phi1, phi2] = 0, expand [theta1, theta2] to 2 about 0;
    }
}

lagrangian! {
    /// A quarter of a car on a road, by the height of its body and the deflection of its tyre.
    pub system Car {
        param body, wheel, k, c, tyre, omega, a = 0.02;
        coord x: length, d: length;
        coord road = 0.5 * a * (1 - (omega * t).cos());
        let w = road + d;
        T = 0.5 * body * dot(x).powi(2) + 0.5 * wheel * dot(w).powi(2);
        V = 0.5 * k * (x - w).powi(2) + 0.5 * tyre * d.powi(2);
        force c * (dot(w) - dot(x)) at x - w;
        observe height = [x, 0, 0];
        /// The tyre is as flat as statics have it.
        pub simplified Slow: quasistatic d;
        pub simplified Rigid: lock d = 0;
    }
}

/// Length of a scene, in s.
const END: f64 = 5.0;
const SAMPLES: u32 = 50;
/// Error of the output at which a model no longer holds, in parts of the length of the pendulum or of the height of
/// the bumps.
const ALLOWED: f64 = 0.01;

/// An output at even times, and the evaluations of the equations that it took.
struct Motion {
    outputs: Vec<SVector<f64, 3>>,
    evaluations: u64,
}

impl Motion {
    /// The largest distance from another one.
    fn error(&self, reference: &Motion) -> f64 {
        self.outputs.iter().zip(&reference.outputs).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
    }

    fn cost(&self, facts: &Facts) -> f64 {
        self.evaluations as f64 * operations(facts) / END
    }
}

/// Operations of an evaluation, weighted by their times as the compiler does: a sine with its cosine counts as forty.
fn operations(facts: &Facts) -> f64 {
    let o = facts.operations;
    (o.additions + o.multiplications + 4 * o.divisions + 40 * o.sin_cos + 30 * o.functions) as f64
}

fn motion_by<Sys, M, C, const N: usize>(
    system: &Sys,
    start: State<f64, N>,
    (method, controller): (M, C),
    output: impl Fn(&State<f64, N>) -> SVector<f64, 3>,
) -> Result<Motion, Failure<f64>>
where
    Sys: System<N, Scalar = f64>,
    M: Method<Sys, N>,
    C: Controller<f64, N, M::Error>,
{
    let mut samples = integrate(system, method, controller, start).until(END).sample_evenly(SAMPLES);
    let mut outputs = Vec::new();
    for state in samples.by_ref() {
        outputs.push(output(&state?));
    }
    Ok(Motion { outputs, evaluations: samples.statistics().evaluations })
}

fn motion<Sys, const N: usize>(
    system: &Sys,
    start: State<f64, N>,
    tolerance: f64,
    output: impl Fn(&State<f64, N>) -> SVector<f64, 3>,
) -> Result<Motion, Failure<f64>>
where
    Sys: System<N, Scalar = f64>,
{
    motion_by(system, start, (Dop853, PiController::tolerance(tolerance)), output)
}

/// Taylor's method at the tolerance of the reference.
fn finest() -> (Taylor, TaylorController<f64>) {
    (Taylor, TaylorController::tolerance(1e-14))
}

/// A model of a whole system: a start of that leads to a motion with an output of that.
fn simplified<Small, const N: usize, const HELD: usize, const WHOLE: usize>(
    whole: &Small::Whole,
    start: &State<f64, WHOLE>,
    tolerance: f64,
    output: impl Fn(&Small::Whole, &State<f64, WHOLE>) -> SVector<f64, 3>,
) -> Result<Motion, Box<dyn Error>>
where
    Small: Restricted<N, HELD, WHOLE, Scalar = f64>,
{
    let (small, left) = Small::restrict(whole, start)?;
    Ok(motion(&small, left, tolerance, |s| output(whole, &small.lift(s)))?)
}

fn tip(system: &Spatial, s: &State<f64, 4>) -> SVector<f64, 3> {
    system.tip_at(s)
}

fn height(system: &Car, s: &State<f64, 2>) -> SVector<f64, 3> {
    system.height_at(s)
}

/// A double pendulum of length 1, whose lower mass is so many times the upper one.
fn spatial(ratio: f64) -> Spatial {
    Spatial::new(1.0, ratio, 0.5, 0.5)
}

/// A start at rest, the lower rod twice as far out as the upper one.
fn at(amplitude: f64) -> State<f64, 4> {
    State::new(0.0, [amplitude / 2.0, 0.0, amplitude, 0.0], [0.0; 4])
}

/// A body of 300 kg on a wheel of 40 kg, whose tyre is so much stiffer than the spring, over bumps at a rate.
fn car(stiffness: f64, omega: f64) -> Car {
    Car::new(300.0, 40.0, 2e4, 200.0, 2e4 * stiffness, omega)
}

fn at_rest() -> State<f64, 2> {
    State::new(0.0, [0.0; 2], [0.0; 2])
}

/// Ten tolerances, from so many digits on.
fn tolerances(digits: i32) -> impl Iterator<Item = f64> {
    (digits..digits + 10).map(|digits| 10f64.powi(-digits))
}

/// The largest size below which the error is allowed, of those that are tried: amplitudes, in rad, or rates, in rad/s.
fn holds_up_to(
    sizes: [f64; 2],
    error: impl Fn(f64) -> Result<f64, Box<dyn Error>>,
) -> Result<f64, Box<dyn Error>> {
    let [least, most] = sizes;
    let mut last = 0.0;
    for i in 0..=30 {
        let size = least * (most / least).powf(f64::from(i) / 30.0);
        if error(size)? > ALLOWED {
            break;
        }
        last = size;
    }
    Ok(last)
}

/// Draws the four charts.
pub fn main() -> Result<(), Box<dyn Error>> {
    let mut checks = Checks::default();
    let precision = |title: &str| {
        Chart::new(
            title,
            Axis::log("operations per simulated second", ""),
            Axis::log("error of the place", "m"),
        )
    };
    let breakdown =
        |title: &str, x: &str, y: &str, unit: &str| Chart::new(title, Axis::log(x, ""), Axis::log(y, unit));

    // The reference is another method, at a far smaller error.
    let (system, start) = (spatial(1.0), at(0.3));
    let reference = motion_by(&system, start, finest(), |s| tip(&system, s))?;
    let mut curves: [Vec<(f64, f64)>; 4] = Default::default();
    for tolerance in tolerances(2) {
        let motions = [
            (motion(&system, start, tolerance, |s| tip(&system, s))?, &Spatial::<f64>::FACTS),
            (simplified::<Planar, 2, 2, 4>(&system, &start, tolerance, tip)?, &Planar::<f64>::FACTS),
            (simplified::<Quartic, 2, 2, 4>(&system, &start, tolerance, tip)?, &Quartic::<f64>::FACTS),
            (simplified::<Linear, 2, 2, 4>(&system, &start, tolerance, tip)?, &Linear::<f64>::FACTS),
        ];
        for (curve, (motion, facts)) in curves.iter_mut().zip(&motions) {
            curve.push((motion.cost(facts), motion.error(&reference)));
        }
    }
    let last = |curve: &[(f64, f64)]| curve[curve.len() - 1];
    checks.at_most("error of the whole system", last(&curves[0]).1, 1e-9);
    checks.at_most("of the plane, which is exact", last(&curves[1]).1, 1e-9);
    checks.at_most(
        "its operations, in parts of those of the whole",
        last(&curves[1]).0 / last(&curves[0]).0,
        0.5,
    );
    let floors = [last(&curves[2]).1, last(&curves[3]).1];
    checks.holds("models have errors of their own", floors[0] > 1e-5 && floors[1] > 10.0 * floors[0]);
    let [whole, planar, quartic, linear] = curves;
    let first = precision("A double pendulum from 0.15 and 0.3 rad")
        .with(Series::new("in space", whole))
        .with(Series::new("in its plane, exact", planar))
        .with(Series::new("energies to order 4", quartic))
        .with(Series::new("small oscillations", linear));

    let system = car(300.0, 2.0);
    let reference = motion_by(&system, at_rest(), finest(), |s| height(&system, s))?;
    let mut curves: [Vec<(f64, f64)>; 3] = Default::default();
    for tolerance in tolerances(5) {
        let motions = [
            (motion(&system, at_rest(), tolerance, |s| height(&system, s))?, &Car::<f64>::FACTS),
            (simplified::<Slow, 1, 1, 2>(&system, &at_rest(), tolerance, height)?, &Slow::<f64>::FACTS),
            (simplified::<Rigid, 1, 1, 2>(&system, &at_rest(), tolerance, height)?, &Rigid::<f64>::FACTS),
        ];
        for (curve, (motion, facts)) in curves.iter_mut().zip(&motions) {
            curve.push((motion.cost(facts), motion.error(&reference)));
        }
    }
    checks.at_most(
        "a tyre in statics, in parts of the error of a rigid one",
        last(&curves[1]).1 / last(&curves[2]).1,
        0.2,
    );
    checks.at_most(
        "its operations at 1e-7, in parts of those of the whole",
        curves[1][2].0 / curves[0][2].0,
        0.2,
    );
    let [stiff, slow, rigid] = curves;
    let second = precision("A quarter of a car, its tyre 300 times as stiff as its spring")
        .with(Series::new("elastic tyre", stiff))
        .with(Series::new("tyre in statics", slow))
        .with(Series::new("rigid tyre", rigid));

    let mut limits: [Vec<(f64, f64)>; 2] = Default::default();
    for ratio in (-4..=4).map(|i| 10f64.powf(f64::from(i) / 4.0)) {
        let system = spatial(ratio);
        let whole = |amplitude| simplified::<Planar, 2, 2, 4>(&system, &at(amplitude), 1e-9, tip);
        let linear = holds_up_to([0.01, 1.0], |a| {
            Ok(simplified::<Linear, 2, 2, 4>(&system, &at(a), 1e-9, tip)?.error(&whole(a)?))
        })?;
        let quartic = holds_up_to([0.01, 1.0], |a| {
            Ok(simplified::<Quartic, 2, 2, 4>(&system, &at(a), 1e-9, tip)?.error(&whole(a)?))
        })?;
        checks.holds(
            format!("order 4 holds further, m2/m1 = {ratio:.2}"),
            quartic > 1.5 * linear && linear > 0.0,
        );
        limits[0].push((ratio, quartic));
        limits[1].push((ratio, linear));
    }
    let [quartic, linear] = limits;
    let third = breakdown(
        "Double pendulum, to 1 % of its length in 5 s",
        "lower mass by upper mass",
        "largest amplitude",
        "rad",
    )
    .with(Series::new("energies to order 4", quartic))
    .with(Series::new("small oscillations", linear));

    let mut limits: [Vec<(f64, f64)>; 2] = Default::default();
    for stiffness in (4..=12).map(|i| 10f64.powf(f64::from(i) / 4.0)) {
        let error = |omega: f64, small: &dyn Fn(&Car) -> Result<Motion, Box<dyn Error>>| {
            let system = car(stiffness, omega);
            let whole = motion(&system, at_rest(), 1e-8, |s| height(&system, s))?;
            Ok(small(&system)?.error(&whole) / system.a)
        };
        let rates = [0.5, 200.0];
        let slow = |s: &Car| simplified::<Slow, 1, 1, 2>(s, &at_rest(), 1e-8, height);
        let rigid = |s: &Car| simplified::<Rigid, 1, 1, 2>(s, &at_rest(), 1e-8, height);
        let slow = holds_up_to(rates, |omega| error(omega, &slow))?;
        let rigid = holds_up_to(rates, |omega| error(omega, &rigid))?;
        checks.holds(
            format!("statics hold further, tyre / spring = {stiffness:.0}"),
            slow > rigid && rigid > 0.0,
        );
        limits[0].push((stiffness, slow));
        limits[1].push((stiffness, rigid));
    }
    let [slow, rigid] = limits;
    let fourth = breakdown(
        "Quarter of a car, to 1 % of the bumps in 5 s",
        "stiffness of the tyre by that of the spring",
        "largest rate of bumps",
        "rad/s",
    )
    .with(Series::new("tyre in statics", slow))
    .with(Series::new("rigid tyre", rigid));

    checks.report()?;
    let folder = support::charts()?;
    Panels::new("Which model is enough?", [first, second, third, fourth])
        .subtitle("Above: what each model costs, and how far it is from the whole system. Below: up to where it holds, of amplitudes to 1 rad and rates to 200 rad/s.")
        .write(&folder, "smaller-models")?;
    println!("{}", folder.join("smaller-models.png").display());
    Ok(())
}
