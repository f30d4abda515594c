//! Hard scenes, each with a truth that no method had a part in, and what every method makes of them.

// Tests without optimisation leave them out: compiling them takes longer than all others.
#[cfg(not(all(test, debug_assertions)))]
#[path = "linkages.rs"]
mod linkages;

use crate::systems::{
    Body, Damped, DoublePendulum, Kapitza, Kepler, Parallelogram, ParallelogramByPoints, Runaway, Spherical,
    SpringPendulum, Top, TwoParallelograms, Wheel,
};
use lagrange_runtime::diagnose;
use lagrange_runtime::method::explicit_rk::{Euler, Heun, Tsitouras5};
use lagrange_runtime::method::rosenbrock::Rodas4;
use lagrange_runtime::method::splitting::PositionVerlet;
use lagrange_runtime::method::variational::VariationalTrapezoid;
use lagrange_runtime::prelude::*;
use lagrange_runtime::testing::reference::{KeplerOrbit, SimplePendulum};
use lagrange_runtime::traits::{Analytic, Conservative, LegendreTransform, Separable};
use lagrange_runtime::{
    BlanesMoan6, Controller, KahanLi8, Nystrom12,
    method::nystrom::{Nystrom6, Nystrom8},
};
#[cfg(test)]
use rayon::prelude::*;
#[cfg(test)]
use std::collections::BTreeMap;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// The columns of the map.
pub const METHODS: [&str; 24] = [
    "Euler, h",
    "Heun, h",
    "Rk4, h",
    "ImplicitMidpoint, h",
    "Gauss4, h",
    "Gauss6, h",
    "VariationalMidpoint, h",
    "VariationalTrapezoid, h",
    "Verlet, h",
    "PositionVerlet, h",
    "KahanLi8, h",
    "BlanesMoan6, h",
    "Tsitouras5",
    "DormandPrince5",
    "Dop853",
    "Verner9",
    "Nystrom6",
    "Nystrom8",
    "Nystrom12",
    "Taylor",
    "Projection(Dop853)",
    "Rodas4",
    "Rodas5P",
    "Radau5",
];

/// Outcome of a run.
#[derive(Clone, Debug)]
pub enum Outcome {
    /// Within the bound of the scene.
    Correct(f64),
    /// Beyond it, at fixed steps: those promise nothing about their error.
    StepTooLong(f64),
    /// An error estimate was at hand, and the error is beyond the bound all the same.
    SilentlyWrong(f64),
    /// It ended early and says why; with the error of the time at which it did, where that time is known.
    Failed { failure: Failure, late: Option<f64> },
}

/// One row of the map.
pub struct Row {
    pub name: String,
    pub truth: &'static str,
    /// Error up to which an adaptive run is correct.
    pub bound: f64,
    /// True if there is a time after which there is no solution.
    pub singular: bool,
    /// True for failures that a run may end in.
    pub expected: fn(&Failure) -> bool,
    pub cells: Cells,
}

type Cells = Vec<(&'static str, Outcome)>;
type Watch<const N: usize> = Box<dyn Fn(&State<f64, N>) -> f64>;
type Judge<const N: usize> = Box<dyn Fn(&State<f64, N>, f64) -> f64>;

/// A motion, and how far off a result is.
struct Scene<Sys, const N: usize> {
    name: String,
    truth: &'static str,
    system: Sys,
    start: State<f64, N>,
    end: f64,
    h: f64,
    tolerance: f64,
    bound: f64,
    /// The largest value of this over all steps is handed to `judge`.
    watch: Watch<N>,
    judge: Judge<N>,
    /// Time at which the solution ends to exist: only a failure is right.
    singular: Option<f64>,
    /// True for failures that a run may end in.
    expected: fn(&Failure) -> bool,
}

/// Every method can do it, at fixed steps perhaps badly.
const NONE: fn(&Failure) -> bool = |_| false;

/// Steps that are too long for a stiff force.
const TOO_LONG: fn(&Failure) -> bool =
    |failure| matches!(failure, Failure::NonFinite { .. } | Failure::NotConverged { .. });

/// No solution beyond.
const ENDS: fn(&Failure) -> bool = |failure| {
    let adaptive = matches!(failure, Failure::StepSizeUnderflow { .. });
    adaptive || TOO_LONG(failure)
};

/// A coordinate singularity, at which azimuth and spin have no inertia of their own.
const POLE: fn(&Failure) -> bool = |failure| match failure {
    Failure::SingularInertia { coordinate, .. } | Failure::Cancellation { coordinate, .. } => {
        ["phi", "psi"].contains(&coordinate.name)
    }
    _ => false,
};

/// Attempted steps; more would take minutes for the whole map.
const BUDGET: u64 = 100_000;

impl<Sys: Lagrangian<N, Scalar = f64>, const N: usize> Scene<Sys, N> {
    fn run<M: Method<Sys, N>>(
        &self,
        method: M,
        controller: impl Controller<f64, N, M::Error>,
        adaptive: bool,
    ) -> Outcome {
        let mut run =
            integrate(&self.system, method, controller, self.start).until(self.end).max_steps(BUDGET);
        let mut peak = (self.watch)(&self.start);
        for step in run.by_ref() {
            match step {
                Ok(step) => peak = peak.max((self.watch)(&step.to)),
                Err(_) => break,
            }
        }
        let last = *run.state();
        if let Err(failed) = run.run_to_end() {
            let late = self.singular.map(|time| (last.t - time).abs());
            return Outcome::Failed { failure: diagnose(&self.system, &failed), late };
        }
        let error = match self.singular {
            Some(_) => f64::INFINITY,
            None => (self.judge)(&last, peak),
        };
        match error <= self.bound {
            true => Outcome::Correct(error),
            false if adaptive => Outcome::SilentlyWrong(error),
            false => Outcome::StepTooLong(error),
        }
    }
}

impl<Sys: Lagrangian<N, Scalar = f64>, const N: usize> Scene<Sys, N> {
    /// Runs by the methods that estimate their error from accelerations.
    fn without_series(&self) -> Cells {
        let tolerance = PiController::tolerance(self.tolerance);
        vec![
            ("Tsitouras5", self.run(Tsitouras5, tolerance, true)),
            ("DormandPrince5", self.run(DormandPrince5, tolerance, true)),
            ("Dop853", self.run(Dop853, tolerance, true)),
            ("Verner9", self.run(Verner9, tolerance, true)),
            ("Rodas4", self.run(Rodas4, tolerance, true)),
            ("Rodas5P", self.run(Rodas5P, tolerance, true)),
            ("Radau5", self.run(Radau5, tolerance, true)),
        ]
    }

    /// Runs by one method of each kind, of systems that take long to compile.
    #[cfg(not(all(test, debug_assertions)))]
    fn few(&self) -> Cells {
        let tolerance = PiController::tolerance(self.tolerance);
        vec![
            ("Rk4, h", self.run(Rk4, FixedStep::new(self.h), false)),
            ("Dop853", self.run(Dop853, tolerance, true)),
            ("Verner9", self.run(Verner9, tolerance, true)),
            ("Radau5", self.run(Radau5, tolerance, true)),
        ]
    }

    /// Runs by the methods that need accelerations alone.
    fn by_accelerations(&self) -> Cells {
        let h = FixedStep::new(self.h);
        let equal = [
            ("Euler, h", self.run(Euler, h, false)),
            ("Heun, h", self.run(Heun, h, false)),
            ("Rk4, h", self.run(Rk4, h, false)),
        ];
        [equal.into(), self.without_series()].concat()
    }

    fn row(&self, cells: Cells) -> Row {
        Row {
            name: self.name.clone(),
            truth: self.truth,
            bound: self.bound,
            singular: self.singular.is_some(),
            expected: self.expected,
            cells,
        }
    }
}

impl<Sys: Lagrangian<N, Scalar = f64> + Analytic<N>, const N: usize> Scene<Sys, N> {
    fn taylor(&self) -> Cells {
        vec![("Taylor", self.run(Taylor, TaylorController::tolerance(self.tolerance), true))]
    }

    /// Runs by the methods that estimate their error.
    #[cfg(test)]
    fn adaptive(&self) -> Cells {
        [self.without_series(), self.taylor()].concat()
    }

    fn explicit(&self) -> Cells {
        [self.by_accelerations(), self.taylor()].concat()
    }
}

impl<Sys: LegendreTransform<N, Scalar = f64> + Analytic<N>, const N: usize> Scene<Sys, N> {
    fn general(&self) -> Cells {
        let h = FixedStep::new(self.h);
        let equal = [
            ("ImplicitMidpoint, h", self.run(ImplicitMidpoint, h, false)),
            ("Gauss4, h", self.run(Gauss4, h, false)),
            ("Gauss6, h", self.run(Gauss6, h, false)),
            ("VariationalMidpoint, h", self.run(VariationalMidpoint, h, false)),
            ("VariationalTrapezoid, h", self.run(VariationalTrapezoid, h, false)),
        ];
        [self.explicit(), equal.into()].concat()
    }
}

impl<Sys: LegendreTransform<N, Scalar = f64> + Separable<N>, const N: usize> Scene<Sys, N> {
    /// Runs by Nyström methods, which estimate their error.
    fn nystrom(&self) -> Cells {
        let tolerance = PiController::tolerance(self.tolerance);
        vec![
            ("Nystrom6", self.run(Nystrom6, tolerance, true)),
            ("Nystrom8", self.run(Nystrom8, tolerance, true)),
            ("Nystrom12", self.run(Nystrom12, tolerance, true)),
        ]
    }

    fn separable(&self) -> Cells {
        let h = FixedStep::new(self.h);
        let equal = [
            ("Verlet, h", self.run(Verlet, h, false)),
            ("PositionVerlet, h", self.run(PositionVerlet, h, false)),
            ("KahanLi8, h", self.run(Compose(Verlet, KahanLi8), h, false)),
            ("BlanesMoan6, h", self.run(BlanesMoan6, h, false)),
        ];
        [equal.into(), self.nystrom()].concat()
    }
}

impl<Sys: LegendreTransform<N, Scalar = f64> + Conservative<N>, const N: usize> Scene<Sys, N> {
    fn projected(&self) -> Cells {
        vec![(
            "Projection(Dop853)",
            self.run(Projection(Dop853), PiController::tolerance(self.tolerance), true),
        )]
    }
}

/// Distance of the energy from that of the start, in units of `scale`.
fn energy<Sys, const N: usize>(system: Sys, start: State<f64, N>, scale: f64) -> Watch<N>
where
    Sys: Energies<N, Scalar = f64> + 'static,
{
    let at_start = system.energy_at(&start);
    Box::new(move |at| ((system.energy_at(at) - at_start) / scale).abs())
}

fn nothing<const N: usize>() -> Watch<N> {
    Box::new(|_| 0.0)
}

/// All scenes by all methods; in the short version without the long runs.
pub fn rows(short: bool) -> Vec<Row> {
    let mut rows = Vec::new();
    for rate in if short { vec![1e8] } else { vec![1e6, 1e8] } {
        let scene = stiff_decay(rate, 0.0);
        rows.push(scene.row(scene.general()));
    }
    let scene = spring_pendulum(0.0);
    rows.push(scene.row([scene.general(), scene.projected()].concat()));
    for e in if short { vec![0.9] } else { vec![0.9, 0.99, 0.999] } {
        let scene = kepler(e, 0.0);
        rows.push(scene.row([scene.general(), scene.separable(), scene.projected()].concat()));
    }
    let scene = fall(0.0);
    rows.push(scene.row([scene.general(), scene.separable(), scene.projected()].concat()));
    for scene in [spherical(0.0, 0.0), spherical(1e-6, 0.0), pole(0.0)] {
        rows.push(scene.row([scene.general(), scene.projected()].concat()));
    }
    for scene in [top_through_pole(0.0), sleeping(1.05, 0.0), sleeping(0.95, 0.0)] {
        rows.push(scene.row([scene.general(), scene.projected()].concat()));
    }
    for scene in [asleep(1.05, 0.0, 0.0), asleep(1.05, 1e-12, 0.0), asleep(0.95, 0.0, 0.0), tumbling()] {
        rows.push(scene.row([scene.general(), scene.projected()].concat()));
    }
    for scene in [kapitza(1.2, 0.0), kapitza(0.8, 0.0)] {
        rows.push(scene.row(scene.general()));
    }
    let end = if short { 10.0 } else { 200.0 };
    for scene in [double_pendulum(1.0, 1.0, end, 0.0), mass_ratio(0.0), inverse_ratio(0.0)] {
        rows.push(scene.row([scene.general(), scene.projected()].concat()));
    }
    let scene = double_pendulum_by_digits();
    rows.push(scene.row([scene.general(), scene.projected()].concat()));
    let scene = spherical_by_digits();
    rows.push(scene.row([scene.general(), scene.projected()].concat()));
    let scene = top_by_digits();
    rows.push(scene.row([scene.general(), scene.projected()].concat()));
    let scene = runaway(0.0);
    rows.push(scene.row([scene.general(), scene.separable(), scene.projected()].concat()));
    let scene = parallelogram(0.0);
    rows.push(scene.row(scene.explicit()));
    let scene = two_parallelograms(0.0);
    rows.push(scene.row(scene.explicit()));
    let scene = parallelogram_by_points(0.0);
    rows.push(scene.row(scene.explicit()));
    let scene = disk(0.0);
    rows.push(scene.row(scene.explicit()));
    let scene = coin(0.0);
    rows.push(scene.row(scene.explicit()));
    #[cfg(not(all(test, debug_assertions)))]
    rows.extend(linkages::rows());
    rows
}

/// Outcomes of many runs of a method in a scene.
#[cfg(test)]
#[derive(Debug, Default)]
pub struct Counts {
    pub right: u32,
    /// Number of failed runs for each kind of failure.
    pub failed: BTreeMap<String, u32>,
    /// Failures of a kind that the scene does not declare, each with its run.
    pub undeclared: Vec<String>,
    /// Errors beyond the bound with success, each with its run.
    pub silent: Vec<String>,
}

/// Starts of a sweep; tolerances are as many as runs.
#[cfg(test)]
const STARTS: u32 = 50;

/// Runs of each scene whose name begins so by each adaptive method, at so many tolerances between 1000 times and a
/// thousandth of its own (1e-12 at least), from 50 starts in turn. The bound of the error grows with the tolerance,
/// up to 0.5.
#[cfg(test)]
pub fn sweep(name: &str, runs: u32) -> BTreeMap<(String, &'static str), Counts> {
    let mut counts = BTreeMap::new();
    macro_rules! scenes {
        ($($scene:expr => $($cells:ident)*;)*) => {$({
            let made = |u: f64| $scene(u);
            let run = |k: u32| {
                let exponent = 3.0 - 6.0 * f64::from(k) / f64::from(runs - 1).max(1.0);
                let mut scene = made(f64::from(k % STARTS) / f64::from(STARTS));
                let coarser = 10f64.powf(exponent).max(1e-12 / scene.tolerance);
                scene.tolerance *= coarser;
                scene.bound = (scene.bound * coarser.max(1.0)).min(scene.bound.max(0.5));
                let told = format!("start {}, tolerance {:e}", k % STARTS, scene.tolerance);
                let cells = [$(scene.$cells()),*].concat();
                (told, scene.bound, scene.expected, cells)
            };
            let wanted = if made(0.0).name.starts_with(name) { runs } else { 0 };
            let all: Vec<_> = (0..wanted).into_par_iter().map(run).collect();
            for (told, bound, expected, cells) in all {
                for (method, outcome) in cells {
                    let of: &mut Counts = counts.entry((made(0.0).name, method)).or_default();
                    match outcome {
                        Outcome::Correct(_) => of.right += 1,
                        Outcome::Failed { failure, .. } => {
                            *of.failed.entry(failure.name().to_owned()).or_default() += 1;
                            if !expected(&failure) {
                                of.undeclared.push(format!("{told}: {failure}"));
                            }
                        }
                        Outcome::StepTooLong(error) | Outcome::SilentlyWrong(error) => {
                            of.silent.push(format!("{told}: {error:e}, bound {bound:e}"));
                        }
                    }
                }
            }
        })*};
    }
    scenes! {
        |u| stiff_decay(1e8, u) => adaptive;
        spring_pendulum => adaptive projected;
        |u| kepler(0.9, u) => adaptive nystrom projected;
        fall => adaptive nystrom projected;
        |u| spherical(0.0, u) => adaptive projected;
        |u| spherical(1e-6, u) => adaptive projected;
        pole => adaptive projected;
        top_through_pole => adaptive projected;
        |u| sleeping(1.05, u) => adaptive projected;
        |u| sleeping(0.95, u) => adaptive projected;
        |u| asleep(1.05, 0.0, u) => adaptive projected;
        |u| asleep(1.05, 1e-12, u) => adaptive projected;
        |u| asleep(0.95, 0.0, u) => adaptive projected;
        |_| tumbling() => adaptive projected;
        |u| kapitza(1.2, u) => adaptive;
        |u| kapitza(0.8, u) => adaptive;
        |u| double_pendulum(1.0, 1.0, 10.0, u) => adaptive projected;
        mass_ratio => adaptive projected;
        inverse_ratio => adaptive projected;
        |_| double_pendulum_by_digits() => adaptive projected;
        |_| spherical_by_digits() => adaptive projected;
        |_| top_by_digits() => adaptive projected;
        runaway => adaptive nystrom projected;
        parallelogram => adaptive;
        two_parallelograms => adaptive;
        parallelogram_by_points => adaptive;
        disk => adaptive;
        coin => adaptive;
    }
    #[cfg(not(debug_assertions))]
    scenes! {
        linkages::three_cranks => without_series;
        linkages::four_cranks => without_series;
        linkages::twelve_loops => few;
        linkages::slider_crank => adaptive;
        linkages::bennett => without_series;
        linkages::sarrus => without_series;
        linkages::scissors => few;
        linkages::guided_scissors => few;
    }
    counts
}

/// The top through the pole by all methods, at this tolerance.
#[cfg(test)]
pub fn through_the_pole(tolerance: f64) -> Cells {
    let scene = Scene { tolerance, ..top_through_pole(0.0) };
    [scene.general(), scene.projected()].concat()
}

/// Rates c and 1: `x = (λ₂ exp λ₁t − λ₁ exp λ₂t)/(λ₂ − λ₁)`, of which the second term is gone at the end.
fn stiff_decay(rate: f64, u: f64) -> Scene<Damped, 1> {
    let root = (rate * rate - 4.0 * rate).sqrt();
    let (slow, fast) = (-2.0 * rate / (rate + root), -0.5 * (rate + root));
    let exact = (1.0 + u) * fast / (fast - slow) * slow.exp();
    Scene {
        name: format!("stiff decay, rates {rate:.0e} and 1"),
        truth: "closed form",
        system: Damped::new(rate, rate),
        start: State::new(0.0, [1.0 + u], [0.0]),
        end: 1.0,
        h: 0.01,
        tolerance: 1e-9,
        bound: 1e-6,
        watch: nothing(),
        judge: Box::new(move |end, _| (end.q[0] - exact).abs() / exact),
        singular: None,
        expected: |failure| {
            TOO_LONG(failure) || matches!(failure, Failure::BudgetUsedUp { implicit: false, .. })
        },
    }
}

/// Starts without tension but that of the weight, so that the spring is hardly excited.
fn spring_pendulum(u: f64) -> Scene<SpringPendulum, 2> {
    let (k, g, angle) = (1e6, 1.0, 1.0 - 0.2 * u);
    let start = State::new(0.0, [1.0 + g * angle.cos() / k, angle], [0.0, 0.0]);
    let rigid = SimplePendulum::new(g, 1.0, angle, 0.0);
    let end = 10.0;
    let system = SpringPendulum::new(k, g);
    Scene {
        name: "spring pendulum, stiffness 1e6".into(),
        truth: "rigid pendulum (elliptic functions) within 2e-5",
        end,
        h: 0.01,
        tolerance: 1e-9,
        bound: 1e-5,
        watch: energy(SpringPendulum::new(k, g), start, g),
        judge: Box::new(move |at, energy| ((at.q[1] - rigid.state(end).0).abs() - 2e-5).max(0.0).max(energy)),
        system,
        start,
        singular: None,
        expected: TOO_LONG,
    }
}

fn kepler(e: f64, u: f64) -> Scene<Kepler, 2> {
    let name = format!("Kepler, e = {e}, 2.3 revolutions");
    let e = e * (1.0 - 0.05 * u);
    let speed = ((1.0 + e) / (1.0 - e)).sqrt();
    let end = 2.3 * TAU;
    let orbit = KeplerOrbit::new(1.0, [1.0 - e, 0.0], [0.0, speed / (1.0 - e)]).expect("an ellipse");
    let ([r, phi], _) = orbit.state(end);
    let exact = [r * phi.cos(), r * phi.sin()];
    Scene {
        name,
        truth: "closed form (Kepler's equation)",
        system: Kepler::new(1.0),
        start: State::new(0.0, [1.0 - e, 0.0], [0.0, speed]),
        end,
        h: TAU / 5000.0,
        tolerance: 1e-11,
        bound: 1e-5,
        watch: nothing(),
        judge: Box::new(move |end, _| (end.q[0] - exact[0]).hypot(end.q[1] - exact[1])),
        singular: None,
        expected: if e > 0.9 { TOO_LONG } else { NONE },
    }
}

/// From rest at distance 1 straight into the centre: there at t = π/√8.
fn fall(u: f64) -> Scene<Kepler, 2> {
    let (distance, time) = (1.0 + u, (1.0 + u).powf(1.5));
    Scene {
        name: "fall into the centre at t = 1.1107".into(),
        truth: "a failure at t = π/√8",
        system: Kepler::new(1.0),
        start: State::new(0.0, [distance, 0.0], [0.0, 0.0]),
        end: 2.0 * time,
        h: 0.001,
        tolerance: 1e-9,
        bound: 0.0,
        watch: nothing(),
        judge: Box::new(|_, _| f64::INFINITY),
        singular: Some(PI / 8f64.sqrt() * time),
        expected: ENDS,
    }
}

/// The plane pendulum as a point in space, but for O(p_φ).
fn spherical(spin: f64, u: f64) -> Scene<Spherical, 2> {
    let (angle, end) = (1.0 + 0.3 * u, 5.0);
    let start = State::new(0.0, [angle, 0.0], [0.0, spin / angle.sin().powi(2)]);
    let plane = SimplePendulum::new(1.0, 1.0, angle, 0.0);
    let exact = plane.state(end).0.abs();
    Scene {
        name: if spin == 0.0 {
            "spherical pendulum through the pole".into()
        } else {
            format!("spherical pendulum, pole at {spin:.0e}")
        },
        truth: "plane pendulum (elliptic functions), energy",
        system: Spherical::new(1.0),
        start,
        end,
        h: 0.01,
        tolerance: 1e-9,
        bound: 1e-5,
        watch: energy(Spherical::new(1.0), start, 1.0),
        judge: Box::new(move |at, energy| (at.q[0].sin().abs() - exact.sin()).abs().max(energy)),
        singular: None,
        expected: if spin == 0.0 { NONE } else { TOO_LONG },
    }
}

/// Starts where the inertia of φ is zero.
fn pole(u: f64) -> Scene<Spherical, 2> {
    Scene {
        name: "spherical pendulum, start on the pole".into(),
        truth: "a failure at t = 0",
        system: Spherical::new(1.0),
        start: State::new(0.0, [0.0, 0.0], [1.0 + u, 0.0]),
        end: 1.0,
        h: 0.01,
        tolerance: 1e-9,
        bound: 0.0,
        watch: nothing(),
        judge: Box::new(|_, _| f64::INFINITY),
        singular: Some(0.0),
        expected: POLE,
    }
}

/// p_φ = p_ψ: the axis goes through the upward vertical. Energy and both momenta are conserved.
fn top_through_pole(u: f64) -> Scene<Top, 3> {
    // A momentum without trailing zeros, which would hide what rounding does to the sum of two large velocities.
    let (theta, p) = (0.5f64, 10f64.sqrt() * (1.0 + 0.1 * u));
    let phid = p / (1.0 + theta.cos());
    let start = State::new(0.0, [0.0, theta, 0.0], [phid, 0.0, p - phid * theta.cos()]);
    let drift = energy(Top::new(1.0, 1.0, 1.0), start, 1.0);
    let momenta = |at: &State<f64, 3>| Top::new(1.0, 1.0, 1.0).momenta_at(at);
    Scene {
        name: "symmetric top through the pole".into(),
        truth: "energy, p_φ and p_ψ",
        system: Top::new(1.0, 1.0, 1.0),
        start,
        end: 5.0,
        h: 0.01,
        tolerance: 1e-9,
        bound: 1e-5,
        watch: Box::new(move |at| {
            let p_now = momenta(at);
            drift(at).max((p_now[0] - p).abs()).max((p_now[2] - p).abs())
        }),
        judge: Box::new(|_, peak| peak),
        singular: None,
        expected: |failure| POLE(failure) || TOO_LONG(failure),
    }
}

/// A top tilted by δ, with `(I₃ω₃)² = factor² 4 m g l I₁`. In axes that turn with p/(2I₁) the tilt is that of a plane
/// oscillator with `σ² = p²/4 − 1` (or an exponential one), started with a transverse rate to keep clear of the pole.
fn sleeping(factor: f64, u: f64) -> Scene<Top, 3> {
    let (tilt, p, end) = (1e-4 * (1.0 + u), 2.0 * factor, 10.0);
    let square = 0.25 * p * p - 1.0;
    let sigma = square.abs().sqrt();
    let phid = 0.5 * p + 0.5 * sigma;
    let at_end = if square > 0.0 {
        (sigma * end).cos().hypot(0.5 * (sigma * end).sin())
    } else {
        (sigma * end).cosh().hypot(0.5 * (sigma * end).sinh())
    };
    Scene {
        name: format!("sleeping top, {factor} of the critical spin"),
        truth: "linear theory of small tilts",
        system: Top::new(1.0, 1.0, 1.0),
        start: State::new(0.0, [0.0, tilt, 0.0], [phid, 0.0, p - phid * tilt.cos()]),
        end,
        h: 0.01,
        tolerance: 1e-12,
        bound: 1e-3,
        watch: nothing(),
        judge: Box::new(move |at, _| (at.q[1].abs() / (tilt * at_end) - 1.0).abs()),
        singular: None,
        // Next to the pole the inertia changes much within a step, for which the trapezoid's iteration has no terms.
        expected: |failure| matches!(failure, Failure::NotConverged { .. }),
    }
}

/// The same top by a rotation, upright, or next to it: an attitude like others. It turns about the vertical, upright
/// also below the critical spin if it is so exactly.
fn asleep(factor: f64, aside: f64, u: f64) -> Scene<Body, 3> {
    let (system, end) = (Body::new(1.0, 1.0, 0.5, 1.0), 10.0);
    let rate = 2.0 * factor * (1.0 + u) / system.C;
    let tilt = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), aside);
    let rest = State::new(0.0, [0.0; 3], [0.0; 3]);
    let turned = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), rate * end);
    Scene {
        name: format!("top asleep, {factor} of the critical spin, {aside:e} from the vertical"),
        truth: "a turn about the vertical",
        system,
        start: system.with_attitude_R(rest, &tilt, &Vector3::new(0.0, 0.0, rate)),
        end,
        h: 0.01,
        tolerance: 1e-13,
        // Errors of the spin are as the number of steps, so that those of the turn are as its square.
        bound: 1e-10 * (1.0 + u) * (1.0 + u),
        watch: nothing(),
        judge: Box::new(move |at, _| {
            2.0 * (system.attitude_R(at).inverse() * turned).imag().norm().min(1.0).asin()
        }),
        singular: None,
        expected: NONE,
    }
}

/// Spun about the middle axis, it turns over three times, through attitudes of all kinds: ω and the quaternion by
/// Jacobi's functions in 40 digits (`benches/references/bodies.py`).
fn tumbling() -> Scene<Body, 3> {
    let system = Body::new(1.0, 2.0, 3.0, 0.0);
    let quaternion =
        |[w, x, y, z]: [f64; 4]| UnitQuaternion::new_normalize(nalgebra::Quaternion::new(w, x, y, z));
    let first = quaternion([0.733_072_284_376_388_8, 0.680_150_737_615_701_5, 0.0, 0.0]);
    let last = quaternion([
        0.680_112_241_913_455_2,
        -0.632_034_693_446_331_2,
        0.25064621488352274,
        -0.274_145_872_929_392_8,
    ]);
    let omega = Vector3::new(0.011240054409042026, -0.999_936_828_593_127_6, 0.050_419_370_692_615_84);
    Scene {
        name: "free body about its middle axis, to t = 40".into(),
        truth: "Jacobi's functions",
        system,
        start: system.with_attitude_R(
            State::new(0.0, [0.0; 3], [0.0; 3]),
            &first,
            &Vector3::new(0.0, 1.0, 0.05),
        ),
        end: 40.0,
        h: 0.01,
        tolerance: 1e-11,
        bound: 1e-6,
        watch: nothing(),
        judge: Box::new(move |at, _| {
            let apart: f64 = 2.0 * (system.attitude_R(at).inverse() * last).imag().norm().min(1.0).asin();
            apart.max((system.angular_velocity_R(at) - omega).norm())
        }),
        singular: None,
        expected: NONE,
    }
}

/// `a²ω² = factor 2 g l`, upside down. What is compared is the verdict: at the end of a stable run the deviation has
/// stayed near 0.01, of an unstable one it has grown.
fn kapitza(factor: f64, u: f64) -> Scene<Kapitza, 1> {
    let omega = 200.0;
    let a = (2.0 * factor).sqrt() / omega;
    let stable = factor > 1.0;
    Scene {
        name: format!(
            "Kapitza pendulum, a²ω² = {factor} · 2gl ({})",
            if stable { "stands" } else { "falls" }
        ),
        truth: "stable above a²ω² = 2gl (error: 0 if the verdict is right, else 1)",
        system: Kapitza::new(a, omega, 1.0),
        start: State::new(0.0, [PI - 0.01 * (1.0 + 0.2 * u)], [0.0]),
        end: 12.0,
        h: 0.002,
        tolerance: 1e-9,
        bound: 0.5,
        watch: Box::new(|at| (at.q[0] - PI).abs()),
        judge: Box::new(move |_, peak| if (peak < 0.05) == stable { 0.0 } else { 1.0 }),
        singular: None,
        // Implicit methods make more steps than the budget for 400 turns of the pivot at the finest tolerances of a
        // sweep.
        expected: |failure| matches!(failure, Failure::BudgetUsedUp { implicit: true, .. }),
    }
}

fn double_pendulum(m1: f64, m2: f64, end: f64, u: f64) -> Scene<DoublePendulum, 2> {
    let start = State::new(0.0, [2.0 - 0.1 * u, 2.5 + 0.1 * u], [0.0, 0.0]);
    Scene {
        name: format!("double pendulum, energy over t = {end}"),
        truth: "energy",
        system: DoublePendulum::new(m1, m2),
        start,
        end,
        h: 0.01,
        tolerance: 1e-10,
        bound: 1e-5,
        watch: energy(DoublePendulum::new(m1, m2), start, m1 + m2),
        judge: Box::new(|_, peak| peak),
        singular: None,
        expected: NONE,
    }
}

/// The upper bob does not feel the lower one.
fn mass_ratio(u: f64) -> Scene<DoublePendulum, 2> {
    let end = 10.0;
    let exact = SimplePendulum::new(1.0, 1.0, 2.0 - 0.1 * u, 0.0).state(end).0;
    Scene {
        name: "double pendulum, lower mass 1e-8".into(),
        truth: "simple pendulum (elliptic functions), energy",
        judge: Box::new(move |at, peak| (at.q[0] - exact).abs().max(peak)),
        ..double_pendulum(1.0, 1e-8, end, u)
    }
}

/// A single pendulum of length 2 (within the square root of the mass ratio) with a taut, very fast upper bob.
fn inverse_ratio(u: f64) -> Scene<DoublePendulum, 2> {
    let angle = 1.0 + 0.1 * u;
    let start = State::new(0.0, [angle; 2], [0.0, 0.0]);
    let exact = SimplePendulum::new(1.0, 2.0, angle, 0.0).state(2.0).0;
    Scene {
        name: "double pendulum, upper mass 1e-8".into(),
        truth: "pendulum of length 2 (elliptic functions), energy",
        judge: Box::new(move |at, peak| (at.q[1] - exact).abs().max(peak)),
        // Error estimates see the fast motion at the finest tolerances of a sweep, too: it is followed in 1e5 steps
        // and more.
        expected: |failure| TOO_LONG(failure) || matches!(failure, Failure::BudgetUsedUp { .. }),
        start,
        watch: energy(DoublePendulum::new(1e-8, 1.0), start, 1.0),
        ..double_pendulum(1e-8, 1.0, 2.0, u)
    }
}

/// Digits of the motions that follow: Taylor series of order 40 in numbers of 170 bits to a tolerance of 1e-36.
pub const DIGITS: &str = "digits of a Taylor run with 170 bits";

/// Distance of an end from the digits that it should have.
fn digits<const N: usize>(q: [f64; N], qd: [f64; N]) -> Judge<N> {
    Box::new(move |at, _| {
        let difference = |a: f64, b: f64| (a - b).abs();
        let pairs = at.q.iter().zip(&q).chain(at.qd.iter().zip(&qd));
        pairs.fold(0.0, |most: f64, (a, b)| most.max(difference(*a, *b)))
    })
}

/// Unequal masses and lengths; b turns over several times.
fn double_pendulum_by_digits() -> Scene<DoublePendulum, 2> {
    Scene {
        name: "double pendulum, trajectory to t = 10".into(),
        truth: DIGITS,
        system: DoublePendulum { l1: 0.8, l2: 0.6, g: 9.81, ..DoublePendulum::new(0.7, 0.4) },
        start: State::new(0.0, [1.2, -0.4], [0.0, 0.5]),
        end: 10.0,
        h: 0.002,
        tolerance: 1e-10,
        bound: 1e-4,
        watch: nothing(),
        judge: digits(
            [-0.587_880_162_621_626_9, 4.715_404_282_190_083],
            [-1.912_335_268_581_204_7, 4.690_540_252_355_698],
        ),
        singular: None,
        expected: NONE,
    }
}

fn spherical_by_digits() -> Scene<Spherical, 2> {
    Scene {
        name: "spherical pendulum, trajectory to t = 15".into(),
        truth: DIGITS,
        system: Spherical::new(9.81 / 1.1),
        start: State::new(0.0, [0.9, 0.0], [0.3, 2.4]),
        end: 15.0,
        h: 0.005,
        tolerance: 1e-10,
        bound: 1e-5,
        watch: nothing(),
        judge: digits(
            [0.659_132_810_190_996, 51.025_079_673_548_596],
            [-0.924_731_210_306_248_9, 3.926_288_653_266_423_6],
        ),
        singular: None,
        expected: NONE,
    }
}

/// A fast top: its spin turns 56 times in 1.5 turns of its axis.
fn top_by_digits() -> Scene<Top, 3> {
    Scene {
        name: "fast top, trajectory to t = 2".into(),
        truth: DIGITS,
        system: Top::new(0.5 * 9.81 * 0.12, 0.008, 0.0011),
        start: State::new(0.0, [0.0, 0.6, 0.0], [0.0, 0.0, 180.0]),
        end: 2.0,
        h: 0.001,
        tolerance: 1e-10,
        bound: 1e-5,
        watch: nothing(),
        judge: digits(
            [6.441_303_837_452_885, 0.746_763_952_083_847_3, 355.238_779_996_571_1],
            [4.905_152_227_015_146, 1.534_429_041_666_607, 176.400_153_664_742_33],
        ),
        singular: None,
        expected: NONE,
    }
}

/// A force that runs away, at energy 0: `ẋ = √2 x²`, so 1/x = 1/x₀ − √2 t.
fn runaway(u: f64) -> Scene<Runaway, 1> {
    let x = 1.0 + u;
    Scene {
        name: "runaway force, blow-up at t = 0.7071".into(),
        truth: "a failure at t = 1/√2",
        system: Runaway::new(),
        start: State::new(0.0, [x], [2f64.sqrt() * x * x]),
        end: 1.0,
        h: 0.001,
        tolerance: 1e-9,
        bound: 0.0,
        watch: nothing(),
        judge: Box::new(|_, _| f64::INFINITY),
        singular: Some(0.5f64.sqrt() / x),
        expected: ENDS,
    }
}

/// A parallelogram of equal bars that turns over, through the positions in which they lie in one line and its
/// constraints are dependent. With a0 = a1 and b = 0 it is a pendulum, `(5/6) ȧ² + 2 g sin a`; there the other branch
/// of the constraints, a0 = 0, begins.
fn parallelogram(u: f64) -> Scene<Parallelogram, 3> {
    let rate = -1.0 - 0.1 * u;
    let start = State::new(0.0, [FRAC_PI_2, FRAC_PI_2, 0.0], [rate, rate, 0.0]);
    let positions = |a: f64| SVector::from([a, a, 0.0]);
    through_the_line("parallelogram through the line", Parallelogram::new(G), start, 1.2, positions)
}

/// Two of them side by side, whose constraints become dependent together, twice: a pendulum,
/// `(3/2) ȧ² + (7/2) g sin a`.
fn two_parallelograms(u: f64) -> Scene<TwoParallelograms, 5> {
    let rate = -1.0 - 0.1 * u;
    let a = FRAC_PI_2;
    let start = State::new(0.0, [a, a, a, 0.0, 0.0], [rate, rate, rate, 0.0, 0.0]);
    let positions = |a: f64| SVector::from([a, a, a, 0.0, 0.0]);
    let system = TwoParallelograms::new(G);
    through_the_line("parallelograms, two, through the line", system, start, 7.0 / 6.0, positions)
}

/// The same by the ends of its coupler, whose stages of steps do not lie on the constraints.
fn parallelogram_by_points(u: f64) -> Scene<ParallelogramByPoints, 4> {
    let rate = -1.0 - 0.1 * u;
    let start = State::new(0.0, [0.0, 1.0, 1.0, 1.0], [-rate, -rate, 0.0, 0.0]);
    let positions = |a: f64| SVector::from([a.cos(), a.cos() + 1.0, a.sin(), a.sin()]);
    let system = ParallelogramByPoints::new(G);
    through_the_line("parallelogram by points through the line", system, start, 1.2, positions)
}

/// A disk that rolls on a circle, leaning by φ: `h n² tan φ = (k + 1) n s + (g/r) sin φ` with n = ψ̇ cos φ and
/// s = ψ̇ sin φ + θ̇ (Routh, *Advanced Dynamics of Rigid Bodies*, 1905, §244).
fn disk(u: f64) -> Scene<Wheel, 5> {
    let wheel = Wheel::new(1.3, 0.4, 0.5, 0.25);
    let (phi, n) = (0.3 + 0.1 * u, 1.7);
    let s = (wheel.h * n * n * phi.tan() - G / wheel.r * phi.sin()) / ((wheel.k + 1.0) * n);
    let (heading, turn) = (n / phi.cos(), s - n * phi.tan());
    let (end, radius) = (8.0, wheel.r * turn / heading);
    let psi = heading * end;
    let exact = SVector::from([radius * psi.sin(), radius * (1.0 - psi.cos()), psi, phi, turn * end]);
    Scene {
        name: "disk that rolls on a circle".into(),
        truth: "steady motion (Routh), energy",
        system: wheel,
        start: State::new(0.0, [0.0, 0.0, 0.0, phi, 0.0], [wheel.r * turn, 0.0, heading, 0.0, turn]),
        end,
        h: 0.005,
        tolerance: 1e-9,
        bound: 1e-5,
        watch: nothing(),
        judge: Box::new(move |at, _| (at.q - exact).amax()),
        singular: None,
        expected: ROLLS,
    }
}

/// A coin that is nearly flat and rolls about its centre, which rests: `ψ̇² = g/(h r cos φ)` (Euler's disk).
fn coin(u: f64) -> Scene<Wheel, 5> {
    let coin = Wheel::new(0.4, 0.0375, 0.5, 0.25);
    let phi = 1.2 + 0.1 * u;
    let heading = (G / (coin.h * coin.r * phi.cos())).sqrt();
    let turn = -heading * phi.sin();
    let end = 100.0 / heading;
    let centre = move |at: &State<f64, 5>| {
        let aside = coin.r * at.q[3].sin();
        [at.q[0] + aside * at.q[2].sin(), at.q[1] - aside * at.q[2].cos()]
    };
    let start = State::new(0.0, [0.0, 0.0, 0.0, phi, 0.0], [coin.r * turn, 0.0, heading, 0.0, turn]);
    let first = centre(&start);
    Scene {
        name: "coin that rolls about its centre".into(),
        truth: "steady motion (Euler's disk)",
        system: coin,
        start,
        end,
        h: 1e-4,
        tolerance: 1e-10,
        bound: 1e-5,
        watch: nothing(),
        judge: Box::new(move |at, _| {
            let [x, y] = centre(at);
            let moved = (x - first[0]).hypot(y - first[1]) / coin.r;
            moved.max((at.q[2] / 100.0 - 1.0).abs()).max((at.q[3] - phi).abs())
        }),
        singular: None,
        expected: ROLLS,
    }
}

/// Steps of one size may be too long for the constraints.
const ROLLS: fn(&Failure) -> bool = |failure| matches!(failure, Failure::ConstraintDrift { .. });

const G: f64 = 9.81;

/// A linkage that is a pendulum, ä = −`share` g cos a, with these coordinates at the angle a.
fn through_the_line<Sys: Energies<N, Scalar = f64> + Copy + 'static, const N: usize>(
    name: &str,
    system: Sys,
    start: State<f64, N>,
    share: f64,
    positions: impl Fn(f64) -> SVector<f64, N>,
) -> Scene<Sys, N> {
    let (rate, end) = (-start.qd.amax(), 10.0);
    let exact = positions(SimplePendulum::new(share * G, 1.0, PI, rate).state(end).0 - FRAC_PI_2);
    Scene {
        name: name.into(),
        truth: "pendulum (elliptic functions), energy",
        system,
        start,
        end,
        h: 0.002,
        tolerance: 1e-9,
        bound: 2e-4,
        watch: energy(system, start, G),
        judge: Box::new(move |at, energy| (at.q - exact).amax().max(energy)),
        singular: None,
        // Radau5 needs a tenth of the budget at the finest tolerances, and steps become short where the constraints
        // are nearly dependent.
        expected: |failure| match failure {
            Failure::DependentConstraints { .. } | Failure::ConstraintDrift { .. } => true,
            Failure::BudgetUsedUp { implicit, .. } => *implicit,
            _ => false,
        },
    }
}
