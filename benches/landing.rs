//! Monte Carlo to an event: `cargo bench --bench landing`.
//!
//! Shots with drag and wind, in space and in a plane, whose launch is drawn at random, on one thread:
//!
//! - *fixed*: to the mean time of landing, without an event;
//! - *ground*: to the ground, one by one;
//! - *lanes*, *lanes to the ground*: the same in lanes;
//! - *with the first step of a sample*: to the ground, by `Study::first_step_of`;
//! - *plain*: thirty lines of RK4 as one would write them with rayon, with the longest step whose error is not larger.
//!
//! Errors are root mean squares of the place of landing against `Dop853` at 1e-13. Ratios are medians of alternating
//! rounds. `-- evaluations` counts the evaluations of a thousand shots and prints their errors. `-- one space 1e-6
//! ground 1000` makes 1000 shots one way and nothing else, to be counted by callgrind.

#![allow(missing_docs)]

mod support;

use lagrange_runtime::Run;
use lagrange_runtime::ensemble::rand_distr::{Distribution, StandardNormal};
use lagrange_runtime::ensemble::{Ensemble, Moments, Random, Source};
use lagrange_runtime::event::{Compiled, CompiledEvents};
use lagrange_runtime::lanes::{FinalState, Fused, Level, Occurrences};
use lagrange_runtime::prelude::*;
use rayon::prelude::*;
use std::hint::black_box;
use support::ratio;

lagrangian! {
    /// A shot in space, z upward, with quadratic drag in air of less density above, and a wind that grows with height.
    pub system Space {
        param m, drag, wind, g = 9.81;
        coord x, y, z;
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2));
        V = m * g * z;
        let c = drag * exp(-z / 8000);
        let u = dot(y) - wind * (1 - exp(-z / 50));
        let v = hypot(hypot(dot(x), u), dot(z));
        force [-c * v * dot(x), -c * v * u, -c * v * dot(z)] at [x, y, z];
        event ground: z, falling, terminal;
    }
}

lagrangian! {
    /// A shell in a plane.
    pub system Plane {
        param m, drag, g = 9.81;
        coord x, z;
        T = 0.5 * m * (dot(x).powi(2) + dot(z).powi(2));
        V = m * g * z;
        let v = hypot(dot(x), dot(z));
        force [-drag * v * dot(x), -drag * v * dot(z)] at [x, z];
        event ground: z, falling, terminal;
    }
}

/// A study of one of the two systems.
trait Shot<const N: usize>: CompiledEvents<N, Scalar = f64, Of = Self> + Sized {
    /// The ground, as the definition of the system has it.
    const LANDED: Event<Compiled<Self>>;
    /// Mean time of landing.
    const FLIGHT: f64;
    fn draw(rng: <Random as Source>::Draw) -> (Self, State<f64, N>);
    /// Accelerations as one writes them by hand.
    fn by_hand(&self, q: &[f64; N], v: &[f64; N]) -> [f64; N];
}

fn normal(rng: &mut <Random as Source>::Draw, mean: f64, deviation: f64) -> f64 {
    let z: f64 = StandardNormal.sample(rng);
    mean + deviation * z
}

impl Shot<3> for Space {
    const LANDED: Event<Compiled<Self>> = Space::GROUND;
    const FLIGHT: f64 = 7.6;

    fn draw(mut rng: <Random as Source>::Draw) -> (Self, State<f64, 3>) {
        let system = Space::new(0.5, normal(&mut rng, 1e-3, 2e-5), normal(&mut rng, 5.0, 1.0));
        let (v, up, side) =
            (normal(&mut rng, 60.0, 0.5), normal(&mut rng, 0.8, 0.01), normal(&mut rng, 0.0, 0.01));
        let start = [v * up.cos() * side.cos(), v * up.cos() * side.sin(), v * up.sin()];
        (system, State::new(0.0, [0.0; 3], start))
    }

    fn by_hand(&self, q: &[f64; 3], v: &[f64; 3]) -> [f64; 3] {
        let c = self.drag * (-q[2] / 8000.0).exp();
        let u = v[1] - self.wind * (1.0 - (-q[2] / 50.0).exp());
        let k = c * (v[0] * v[0] + u * u + v[2] * v[2]).sqrt() / self.m;
        [-k * v[0], -k * u, -k * v[2] - self.g]
    }
}

impl Shot<2> for Plane {
    const LANDED: Event<Compiled<Self>> = Plane::GROUND;
    const FLIGHT: f64 = 15.6;

    fn draw(mut rng: <Random as Source>::Draw) -> (Self, State<f64, 2>) {
        let system = Plane::new(5.0, normal(&mut rng, 2e-3, 4e-5));
        let (v, up) = (normal(&mut rng, 120.0, 0.5), normal(&mut rng, 0.8, 0.01));
        (system, State::new(0.0, [0.0; 2], [v * up.cos(), v * up.sin()]))
    }

    fn by_hand(&self, _: &[f64; 2], v: &[f64; 2]) -> [f64; 2] {
        let k = self.drag * (v[0] * v[0] + v[1] * v[1]).sqrt() / self.m;
        [-k * v[0], -k * v[1] - self.g]
    }
}

/// The plain way: one step of RK4.
fn step<Sys: Shot<N>, const N: usize>(system: &Sys, [q, v]: [[f64; N]; 2], h: f64) -> [[f64; N]; 2] {
    let plus = |a: &[f64; N], b: &[f64; N], h: f64| core::array::from_fn(|i| a[i] + h * b[i]);
    let a1 = system.by_hand(&q, &v);
    let (q2, v2) = (plus(&q, &v, 0.5 * h), plus(&v, &a1, 0.5 * h));
    let a2 = system.by_hand(&q2, &v2);
    let (q3, v3) = (plus(&q, &v2, 0.5 * h), plus(&v, &a2, 0.5 * h));
    let a3 = system.by_hand(&q3, &v3);
    let (q4, v4) = (plus(&q, &v3, h), plus(&v, &a3, h));
    let a4 = system.by_hand(&q4, &v4);
    let mean = |a: &[f64; N], b: &[f64; N], c: &[f64; N], d: &[f64; N]| {
        core::array::from_fn(|i| (a[i] + 2.0 * (b[i] + c[i]) + d[i]) / 6.0)
    };
    [plus(&q, &mean(&v, &v2, &v3, &v4), h), plus(&v, &mean(&a1, &a2, &a3, &a4), h)]
}

/// The plain way: steps until the height is negative, then two corrections of the last one. The place of landing, and
/// the steps.
fn plain<Sys: Shot<N>, const N: usize>(system: &Sys, start: &State<f64, N>, h: f64) -> (f64, u64) {
    let (mut at, mut steps) = ([start.q.into(), start.qd.into()], 0);
    loop {
        let next = step(system, at, h);
        steps += 1;
        if next[0][N - 1] < 0.0 {
            let mut part = h * at[0][N - 1] / (at[0][N - 1] - next[0][N - 1]);
            let mut end = step(system, at, part);
            for _ in 0..2 {
                part -= end[0][N - 1] / end[1][N - 1];
                end = step(system, at, part);
            }
            return (end[0][0], steps + 3);
        }
        at = next;
    }
}

/// The way a study is made.
#[derive(Clone, Copy)]
enum Way {
    ToTime,
    Ground,
    Lanes,
    LanesGround,
    /// To the ground, all samples with the first step of one of them.
    Begun,
    LanesBegun,
    /// Our RK4 with such steps, in lanes to the ground.
    Equal(f64),
    Plain(f64),
}

/// The mean place of landing of so many shots.
fn mean<Sys, const N: usize>(way: Way, samples: u64, tolerance: f64, level: Level) -> f64
where
    Sys: Shot<N> + lagrange_runtime::lanes::Rescale<N> + Send + Sync,
    Dop853: lagrange_runtime::lanes::InLanes<Sys, PiController, Fused, N>,
    Rk4: lagrange_runtime::lanes::InLanes<Sys, FixedStep, Fused, N>,
{
    let end = match way {
        Way::ToTime | Way::Lanes => Sys::FLIGHT,
        _ => 100.0,
    };
    let study = Ensemble::new(Random::seed(1), samples, Sys::draw)
        .integrate(Dop853, PiController::tolerance(tolerance), end)
        .threads(1);
    let study = match way {
        Way::Begun | Way::LanesBegun => study.first_step_of(0).expect("a smooth motion"),
        _ => study,
    };
    let statistic = match way {
        Way::ToTime => study.reduce(|_, run| Ok(run.final_state()?.q[0]), Moments),
        Way::Ground | Way::Begun => {
            study.reduce(|_, run| Ok(run.events(Sys::LANDED).final_state()?.q[0]), Moments)
        }
        Way::Lanes => {
            let last = FinalState(|_: &Sys, end: &State<f64, N>| end.q[0]);
            study.in_lanes(Fused).level(level).observe(&last, Moments)
        }
        Way::LanesGround | Way::LanesBegun => {
            let landed = Occurrences::new(Sys::LANDED, |_: &Sys, _, end: &State<f64, N>| end.q[0]);
            study.in_lanes(Fused).level(level).observe(&landed, Moments)
        }
        Way::Equal(h) => {
            let study =
                Ensemble::new(Random::seed(1), samples, Sys::draw).integrate(Rk4, FixedStep::new(h), end);
            let landed = Occurrences::new(Sys::LANDED, |_: &Sys, _, end: &State<f64, N>| end.q[0]);
            study.threads(1).in_lanes(Fused).level(level).observe(&landed, Moments)
        }
        Way::Plain(h) => {
            let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
            let sum: f64 = one.install(|| {
                (0..samples)
                    .into_par_iter()
                    .map(|index| {
                        let (system, start) = Sys::draw(Random::seed(1).draw(index));
                        plain(&system, &start, h).0
                    })
                    .sum()
            });
            return sum / samples as f64;
        }
    };
    statistic.expect("a sound study").statistic.mean()
}

/// Root mean square of the errors of so many landings, and evaluations of the equations per shot.
fn errors<Sys: Shot<N>, const N: usize>(
    shots: u64,
    shot: impl Fn(&Sys, &State<f64, N>) -> (f64, u64),
) -> (f64, f64) {
    let (mut square, mut evaluations) = (0.0, 0);
    for index in 0..shots {
        let (system, start) = Sys::draw(Random::seed(1).draw(index));
        let (exact, _) = landing(&system, &start, 1e-13);
        let (found, cost) = shot(&system, &start);
        square += (found - exact).powi(2);
        evaluations += cost;
    }
    ((square / shots as f64).sqrt(), evaluations as f64 / shots as f64)
}

fn landing<Sys: Shot<N>, const N: usize>(system: &Sys, start: &State<f64, N>, tolerance: f64) -> (f64, u64) {
    landed(integrate(system, Dop853, PiController::tolerance(tolerance), *start).until(100.0))
}

fn landed<Sys: Shot<N>, const N: usize>(run: Run<'_, Sys, Dop853, PiController, N>) -> (f64, u64) {
    let mut events = run.events(Sys::LANDED);
    let end = events.next().expect("it comes down").expect("a smooth motion").state;
    (end.q[0], events.statistics().evaluations)
}

fn fixed<Sys: Shot<N>, const N: usize>(system: &Sys, start: &State<f64, N>, tolerance: f64) -> u64 {
    let mut run = integrate(system, Dop853, PiController::tolerance(tolerance), *start).until(Sys::FLIGHT);
    run.run_to_end().expect("a smooth motion");
    run.statistics().evaluations
}

fn compare<Sys, const N: usize>(name: &str, tolerance: f64)
where
    Sys: Shot<N> + lagrange_runtime::lanes::Rescale<N> + Send + Sync,
    Dop853: lagrange_runtime::lanes::InLanes<Sys, PiController, Fused, N>,
    Rk4: lagrange_runtime::lanes::InLanes<Sys, FixedStep, Fused, N>,
{
    const SAMPLES: u64 = 500;
    const SHOTS: u64 = 200;
    let (error, evaluations) = errors::<Sys, N>(SHOTS, |system, start| landing(system, start, tolerance));
    let (_, to_time) = errors::<Sys, N>(SHOTS, |system, start| (0.0, fixed(system, start, tolerance)));
    let steps = (0..400).map(|k| 4.0 * 0.95f64.powi(k));
    let longest = steps.map(|h| (h, errors::<Sys, N>(SHOTS, |system, start| plain(system, start, h))));
    let chosen = longest.into_iter().find(|(_, found)| found.0 <= error);
    let (h, (plain_error, plain_steps)) = chosen.expect("RK4 converges");
    println!(
        "{name}, tolerance {tolerance:.0e}: error {error:.1e} m, plain RK4 {plain_error:.1e} m with h = {h:.4} s"
    );
    println!(
        "  evaluations per shot: fixed {to_time:.0}, ground {evaluations:.0}, plain {:.0}",
        4.0 * plain_steps
    );
    let best = Level::best();
    let against = |what: &str, ours: Way, theirs: Way, level: Level| {
        let found = ratio(
            SAMPLES as usize,
            || _ = black_box(mean::<Sys, N>(ours, SAMPLES, tolerance, level)),
            || _ = black_box(mean::<Sys, N>(theirs, SAMPLES, tolerance, level)),
        );
        let [a, b] = found.nanoseconds.map(|t| 1e-3 * t);
        println!("  {what}: {:.2} ({a:.2} µs, {b:.2} µs per shot)", found.median);
    };
    against("ground / fixed", Way::Ground, Way::ToTime, best);
    against("lanes to the ground / lanes, fixed", Way::LanesGround, Way::Lanes, best);
    for level in Level::available() {
        let name = format!("ground one by one / in lanes, {level:?}");
        against(&name, Way::Ground, Way::LanesGround, level);
    }
    against("plain / ground", Way::Plain(h), Way::Ground, best);
    against("plain / lanes to the ground", Way::Plain(h), Way::LanesGround, best);
    against("plain / our RK4 with such steps, in lanes to the ground", Way::Plain(h), Way::Equal(h), best);
    against("ground / ground with the first step of a sample", Way::Ground, Way::Begun, best);
    against("lanes to the ground / with the first step of a sample", Way::LanesGround, Way::LanesBegun, best);
    against("plain / ground with the first step of a sample", Way::Plain(h), Way::Begun, best);
    against(
        "plain / lanes to the ground with the first step of a sample",
        Way::Plain(h),
        Way::LanesBegun,
        best,
    );
}

/// Evaluations and errors of a thousand shots, to the mean time of landing, to the ground, and to it with a first step.
fn evaluations<Sys: Shot<N> + Send + Sync, const N: usize>(name: &str, tolerance: f64) {
    const SHOTS: u64 = 1000;
    let (_, time) = errors::<Sys, N>(SHOTS, |system, start| (0.0, fixed(system, start, tolerance)));
    let (error, ground) = errors::<Sys, N>(SHOTS, |system, start| landing(system, start, tolerance));
    let study = Ensemble::new(Random::seed(1), SHOTS, Sys::draw)
        .integrate(Dop853, PiController::tolerance(tolerance), 100.0)
        .first_step_of(0)
        .expect("a smooth motion");
    let index = std::cell::Cell::new(0);
    let (begun_error, begun) = errors::<Sys, N>(SHOTS, |_, _| {
        let replay = study.replay(index.replace(index.get() + 1)).expect("a sample");
        landed(replay.run())
    });
    println!(
        "{name}, {tolerance:.0e}: fixed {time:.1}, ground {ground:.1} (error {error:.2e} m), with a first step {begun:.1} ({begun_error:.2e} m)"
    );
}

/// One study and nothing else.
fn one(arguments: &[String]) -> Option<()> {
    let [_, shot, tolerance, way, samples, rest @ ..] = arguments else { return None };
    let way = match way.as_str() {
        "fixed" => Way::ToTime,
        "ground" => Way::Ground,
        "lanes" => Way::Lanes,
        "lanes-ground" => Way::LanesGround,
        "begun" => Way::Begun,
        "lanes-begun" => Way::LanesBegun,
        h => match h.strip_prefix("rk4=") {
            Some(h) => Way::Equal(h.parse().ok()?),
            None => Way::Plain(h.parse().ok()?),
        },
    };
    let (tolerance, samples) = (tolerance.parse().ok()?, samples.parse().ok()?);
    let level =
        Level::available().find(|level| rest.first() == Some(&format!("{level:?}"))).unwrap_or(Level::best());
    let mean = match shot.as_str() {
        "space" => mean::<Space, 3>(way, samples, tolerance, level),
        "plane" => mean::<Plane, 2>(way, samples, tolerance, level),
        _ => return None,
    };
    println!("{mean}");
    Some(())
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|a| a != "--bench").collect();
    if arguments.first().is_some_and(|a| a == "one") {
        one(&arguments).expect(
            "one (space | plane) TOLERANCE (fixed | ground | lanes | lanes-ground | begun | lanes-begun | rk4=H | H) SAMPLES [LEVEL]",
        );
        return;
    }
    if arguments.first().is_some_and(|a| a == "evaluations") {
        for tolerance in [1e-3, 1e-4, 1e-6, 1e-8, 1e-9, 1e-10, 1e-12] {
            evaluations::<Space, 3>("in space", tolerance);
            evaluations::<Plane, 2>("in a plane", tolerance);
        }
        return;
    }
    for tolerance in [1e-3, 1e-6, 1e-8, 1e-9] {
        compare::<Space, 3>("in space", tolerance);
        compare::<Plane, 2>("in a plane", tolerance);
    }
}
