//! Runs in lanes have the bits of the same runs alone, and studies by them those of studies by one thread.

#![allow(missing_docs)]

use lagrange_runtime::controller::Controller;
use lagrange_runtime::ensemble::rand_distr::{Distribution, Uniform};
use lagrange_runtime::ensemble::{
    Collect, Ensemble, EnsembleError, Extrema, Moments, Outcome, Random, Record, Source, Table,
};
use lagrange_runtime::event::Direction;
use lagrange_runtime::lanes::{
    FinalState, FoldSteps, Fused, InLanes, LaneController, Lanes, Lanewise, Level, Occurrences, Plain,
    Policy, Sampled, SingleLane,
};
use lagrange_runtime::method::rosenbrock::Rodas4;
use lagrange_runtime::prelude::*;
use lagrange_runtime::testing::reference::SimplePendulum;
use lagrange_runtime::traits::ExternFunction;
use std::path::PathBuf;
use std::time::Duration;

lagrangian! {
    /// A ball in air, whose drag is c |v| v.
    system Ball {
        param c, g = 9.81;
        coord x, y;
        let v = [dot(x), dot(y)];
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = g * y;
        force -c * v.norm() * v at [x, y];
    }
}

lagrangian! {
    /// A ball above a spring.
    system Landing {
        param k, g = 9.81;
        coord y;
        T = 0.5 * dot(y).powi(2);
        V = g * y + 0.5 * k * max(-y, 0).powi(2);
    }
}

lagrangian! {
    /// Heavy symmetric top: φ precession, θ inclination, ψ spin. φ and ψ are ignorable.
    system Top {
        param mgl, I1, I3;
        coord phi, theta, psi;
        let spin = dot(psi) + dot(phi) * cos(theta);
        T = 0.5 * I1 * (dot(theta).powi(2) + (dot(phi) * sin(theta)).powi(2)) + 0.5 * I3 * spin.powi(2);
        V = mgl * cos(theta);
    }
}

lagrangian! {
    /// A parallelogram of uniform bars: two cranks, and the coupler between them.
    system Parallelogram {
        param g = 9.81;
        coord a0, a1, b;
        let x = cos(a0) + 0.5 * cos(b);
        let y = sin(a0) + 0.5 * sin(b);
        T = (dot(a0).powi(2) + dot(a1).powi(2)) / 6 + 0.5 * (dot(x).powi(2) + dot(y).powi(2)) + dot(b).powi(2) / 24;
        V = g * (0.5 * sin(a0) + 0.5 * sin(a1) + y);
        constraint horizontal: cos(a0) + cos(b) == cos(a1) + 1;
        constraint vertical: sin(a0) + sin(b) == sin(a1);
    }
}

/// From the upright position the parallelogram turns over, and with it passes the two positions in which all bars lie
/// in one line: there its constraints are dependent, and the other branch of their solutions, a0 = 0, begins.
fn turning(rate: f64) -> (Parallelogram, State<f64, 3>) {
    let up = core::f64::consts::FRAC_PI_2;
    (Parallelogram::new(), State::new(0.0, [up, up, 0.0], [rate, rate, 0.0]))
}

lagrangian! {
    /// A particle that a wall or a centre attracts. It falls into the centre at a finite time, where k is not 0.
    system Particle {
        param k, w, c;
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = 0.5 * (w * x).powi(2) - k / x - c * (x + 0.1 * t).cos();
    }
}

/// Fate of a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Fate {
    /// It runs to the end.
    Well,
    /// Its start is not finite.
    Never,
    /// It begins at the end.
    Short,
    /// It falls into the centre, in a time that depends on the number.
    Falls,
}

const END: f64 = 3.0;

fn particle(number: u64, fate: Fate) -> (Particle, State<f64, 1>) {
    let u = ((number * 37) % 101) as f64 / 101.0;
    let system = Particle::new(if fate == Fate::Falls { 1.0 } else { 0.0 }, 1.0 + u, 1.0);
    let velocity = if fate == Fate::Never { f64::NAN } else { 0.0 };
    let t = if fate == Fate::Short { END } else { 0.1 * u };
    (system, State::new(t, [0.5 + u], [velocity]))
}

fn fates(of: &dyn Fn(u64) -> Fate, n: u64) -> Table<[u64; 2]> {
    Table::new((0..n).map(|number| [number, of(number) as u64]))
}

fn draw([number, fate]: [u64; 2]) -> (Particle, State<f64, 1>) {
    let all = [Fate::Well, Fate::Never, Fate::Short, Fate::Falls];
    particle(number, all[fate as usize])
}

/// System that runs in lanes.
type Over<S> = Precomputed<Particle<S>, 1>;

/// All bits of an outcome.
fn bits<T: Record, const N: usize>(outcome: &Outcome<T, f64, N>) -> Vec<u8> {
    let mut bytes = vec![];
    outcome.statistic.write(&mut bytes);
    outcome.failures.count.write(&mut bytes);
    for failed in &outcome.failures.kept {
        failed.index.write(&mut bytes);
        failed.start.write(&mut bytes);
        failed.last.write(&mut bytes);
        failed.failure.to_string().write(&mut bytes);
    }
    bytes
}

/// A study of `n` samples in lanes, against each of them alone by its ordinary run.
macro_rules! lanes_are_alone {
    ($study:expr, $policy:expr, $n:expr) => {{
        let watch = FinalState(|_: &_, end: &State<f64, _>| (end.t, end.q[0], end.qd[0]));
        let mut first = None;
        for level in Level::compiled() {
            let lanes = $study.in_lanes($policy).level(level);
            let outcome = lanes.observe(&watch, Collect).expect("a sound study");
            let found = bits(&outcome);
            assert_eq!(first.get_or_insert_with(|| found.clone()), &found, "{level:?}");
            let (mut good, mut failed) = (outcome.statistic.rows.iter(), outcome.failures.kept.iter());
            for index in 0..$n {
                let alone = lanes.replay(index).expect("a sample");
                match alone.run().final_state() {
                    Ok(end) => {
                        let end = (end.t.value(), end.q[0].value(), end.qd[0].value());
                        assert_eq!(good.next(), Some(&(index, end)), "{level:?}, sample {index}");
                    }
                    Err(end) => {
                        let found = failed.next().expect("a failure");
                        let last = found.last.expect("known");
                        assert_eq!((found.index, last.t), (index, end.last.t.value()));
                        let failure = end.failure.map(SingleLane::value).to_string();
                        assert_eq!(found.failure.to_string(), failure, "{level:?}, sample {index}");
                        assert_eq!(last.q[0].to_bits(), end.last.q[0].value().to_bits());
                    }
                }
            }
            assert!(good.next().is_none() && failed.next().is_none());
        }
    }};
}

/// Particles of these fates.
fn lanes_are_alone<P, M, C, E>(policy: P, method: M, controller: C, of: &dyn Fn(u64) -> Fate, n: u64)
where
    P: Policy,
    M: Method<Particle, 1> + Clone + Sync + core::fmt::Debug + InLanes<Particle, C, P, 1>,
    M: Method<Over<SingleLane<P>>, 1, Error = E::Element> + Method<Over<Lanes<8, P>>, 1, Error = E>,
    C: lagrange_runtime::Controller<f64, 1, <M as Method<Particle, 1>>::Error> + Sync + core::fmt::Debug,
    C: LaneController<8, P, lagrange_runtime::lanes::Baseline, E, 1>,
    E: Lanewise<8>,
{
    let study =
        || Ensemble::new(fates(of, n), n, draw).integrate(method.clone(), controller.clone(), END).threads(1);
    lanes_are_alone!(study(), policy, n);
}

#[test]
fn every_number_of_samples() {
    for n in 1..=19 {
        lanes_are_alone(Fused, Dop853, PiController::tolerance(1e-8), &|_| Fate::Well, n);
        lanes_are_alone(Plain, Rk4, FixedStep::new(0.02), &|_| Fate::Well, n);
    }
}

/// Every pattern of failures of eleven samples, of three kinds that differ from place to place.
#[test]
fn every_pattern_of_failures() {
    let kinds = [Fate::Falls, Fate::Never, Fate::Short];
    for pattern in 0..1u64 << 11 {
        let of = |number: u64| {
            if pattern >> number & 1 == 1 { kinds[(number + pattern) as usize % 3] } else { Fate::Well }
        };
        lanes_are_alone(Plain, DormandPrince5, PiController::tolerance(1e-3), &of, 11);
        if pattern % 16 == 3 {
            lanes_are_alone(Fused, Rk4, FixedStep::new(0.2), &of, 11);
        }
    }
}

/// (Not every method: each takes long to compile.)
#[test]
fn methods_of_every_family() {
    let of = |number: u64| if number % 7 == 2 { Fate::Falls } else { Fate::Well };
    macro_rules! all {
        ($policy:expr, $controller:expr; $($method:expr),*) => {
            $(lanes_are_alone($policy, $method, $controller, &of, 21);)*
        };
    }
    let pi = PiController::tolerance(1e-7);
    all!(Fused, pi; Dop853, lagrange_runtime::method::nystrom::Nystrom8);
    all!(Fused, PidController::h211b(PiController::tolerance(1e-6).rtol(0.0).first_step(1e-3)); Dop853);
    all!(Fused, TaylorController::tolerance(1e-12); Taylor);
    all!(Fused, FixedStep::new(0.03); Rk4, Verlet, lagrange_runtime::BlanesMoan6);
    all!(Fused, FixedStep::new(0.06); Compose(Verlet, lagrange_runtime::KahanLi8));
    // Those that iterate, each lane until it has converged.
    all!(Fused, FixedStep::new(0.05); Gauss4, VariationalMidpoint);
    all!(Fused, PiController::tolerance(1e-6); Radau5, Rodas4);
    // How b + a c is rounded is the numbers' business and no method's.
    all!(Plain, pi; DormandPrince5);
}

lagrangian! {
    /// A bead on a rod that hangs from a hinge, in Cartesian coordinates. It cannot pass a plate at y = c, where its
    /// speed becomes infinite.
    system Bead {
        param l, c, k;
        coord x, y;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = 9.81 * y + k * ln(c - y);
        constraint rod: x.powi(2) + y.powi(2) == l.powi(2);
    }
}

lagrangian! {
    /// The same by its angles.
    system Pendulum {
        param l;
        coord theta, phi;
        T = 0.5 * l.powi(2) * (dot(theta).powi(2) + (sin(theta) * dot(phi)).powi(2));
        V = -9.81 * l * cos(theta);
    }
}

lagrangian! {
    /// Dry friction and a stop of elastic material.
    system Rubbed {
        param mu, k;
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = 0.5 * x * x + if x < -0.5 { 0.5 * k * (x + 0.5).powi(2) } else { 0 };
        Q[x] = -mu * signum(dot(x));
    }
}

/// Steps end at the switches of each lane as alone, and friction holds some of the bodies before the end.
#[test]
fn switches() {
    let table = || Table::new((0..21).map(|number: u64| [number]));
    let rubbed = |[number]: [u64; 1]| {
        let u = ((number * 37) % 101) as f64 / 101.0;
        (Rubbed::new(0.2 * u, 1e3 * u), State::new(0.1 * u, [1.0 - 0.3 * u], [0.1 * u]))
    };
    let study = || Ensemble::new(table(), 21, rubbed);
    lanes_are_alone!(study().integrate(Dop853, PiController::tolerance(1e-9), 12.0).threads(1), Fused, 21);
    lanes_are_alone!(study().integrate(Rk4, FixedStep::new(0.01), 12.0).threads(1), Fused, 21);
}

lagrangian! {
    /// Two bodies between springs.
    system Springs {
        param m, k, c;
        coord x, y;
        T = 0.5 * m * (dot(x).powi(2) + 2 * dot(y).powi(2));
        V = 0.5 * k * (x.powi(2) + (y - x).powi(2)) - x;
        D = 0.5 * c * dot(x).powi(2);
    }
}

/// Each lane has its own exponential.
#[test]
fn exact_solutions() {
    let table = Table::new((0..21).map(|number: u64| [number]));
    let springs = |[number]: [u64; 1]| {
        let u = ((number * 37) % 101) as f64 / 101.0;
        // A mass of 0 has no accelerations.
        let m = if number % 5 == 2 { 0.0 } else { 1.0 + u };
        (Springs::new(m, 10.0 - u, 0.3 * u), State::new(0.1 * u, [u, 1.0], [0.0, 0.0]))
    };
    let springs = Ensemble::new(table, 21, springs);
    lanes_are_alone!(springs.clone().integrate(MatrixExponential, FixedStep::new(0.7), END), Fused, 21);
}

lagrangian! {
    /// A particle in a wind of its own.
    system Blown {
        param c;
        coord x;
        extern wind: Curve(t);
        extern gust: Sine(t);
        T = 0.5 * dot(x).powi(2);
        V = 0.5 * x.powi(2);
        Q[x] = c * (wind(t) + gust(t) - dot(x));
    }
}

/// A function that does not know of lanes.
#[derive(Clone, Debug, PartialEq)]
struct Sine(f64);

impl ExternFunction<1> for Sine {
    fn value<S: lagrange_runtime::Scalar>(&self, [t]: [S; 1]) -> S {
        (t * S::from_f64(self.0)).sin()
    }
}

fn blown([number]: [u64; 1]) -> (Blown, State<f64, 1>) {
    let u = number as f64;
    let knots: Vec<f64> = (0..5 + number % 3).map(|i| i as f64 * (1.0 + 0.1 * u) - 0.1).collect();
    let values: Vec<f64> = knots.iter().map(|t| (u + t).sin()).collect();
    let wind = Curve::monotone(&knots, &values, Beyond::Held).expect("a table");
    (Blown::new(0.5 + 0.01 * u, wind, Sine(1.0 + u)), State::new(0.0, [0.1], [0.2 * u]))
}

/// Each lane reads the table of its own system.
#[test]
fn tables_of_samples_differ_in_lanes() {
    let study = || {
        let samples = Table::new((0..21).map(|number: u64| [number]));
        Ensemble::new(samples, 21, blown).integrate(Dop853, PiController::tolerance(1e-8), END).threads(1)
    };
    lanes_are_alone!(study(), Plain, 21);
    lanes_are_alone!(study(), Fused, 21);
    let rk4 = || {
        let samples = Table::new((0..21).map(|number: u64| [number]));
        Ensemble::new(samples, 21, blown).integrate(Rk4, FixedStep::new(0.05), END).threads(1)
    };
    lanes_are_alone!(rk4(), Fused, 21);
}

/// Parallelograms that turn over.
fn linkages() -> Ensemble<Table<[u64; 1]>, impl Fn([u64; 1]) -> (Parallelogram, State<f64, 3>) + Sync> {
    let linkage = |[number]: [u64; 1]| turning(-1.0 - 0.01 * number as f64);
    Ensemble::new(Table::new((0..21).map(|number: u64| [number])), 21, linkage)
}

/// Samples that meet a position with dependent constraints have the bits of their ordinary runs, all others those of
/// their runs alone by the arithmetic of lanes.
#[test]
fn dependent_constraints_are_passed_alone() {
    let study = || linkages().integrate(Verner9, PiController::tolerance(1e-9), END).threads(1);
    let end = FinalState(|_: &Parallelogram, end: &State<f64, 3>| (end.q[0], end.q[2], end.qd[1]));
    let lanes = study().in_lanes(Fused);
    let outcome = lanes.observe(&end, Collect).expect("a sound study");
    assert_eq!(outcome.failures.count, 0);
    let mut ordinary = 0;
    for &(index, found) in &outcome.statistic.rows {
        let expected = match lanes.replay(index).expect("a sample").run().final_state() {
            Ok(end) => (end.q[0].value(), end.q[2].value(), end.qd[1].value()),
            Err(_) => {
                ordinary += 1;
                let end = study().replay(index).expect("a sample").run().final_state().unwrap();
                (end.q[0], end.q[2], end.qd[1])
            }
        };
        assert_eq!(found, expected, "sample {index}");
        let rate = -1.0 - 0.01 * index as f64;
        let exact = SimplePendulum::new(1.2 * 9.81, 1.0, core::f64::consts::PI, rate).state(END).0;
        assert!((found.0 - exact + core::f64::consts::FRAC_PI_2).abs() < 1e-6, "sample {index}: {}", found.0);
    }
    assert!(ordinary > 0 && ordinary < 21, "{ordinary}");
}

/// Constraints and invariants are restored in each lane as alone, also next to beads that end at the plate.
#[test]
fn constraints_and_projections() {
    let table = || Table::new((0..21).map(|number: u64| [number]));
    let bead = |[number]: [u64; 1]| {
        let u = ((number * 37) % 101) as f64 / 101.0;
        let k = if number % 5 == 2 { 1.0 } else { 0.0 };
        let (l, angle) = (1.0 + u, 1.0 + 0.5 * u);
        (Bead::new(l, 0.3, k), State::new(0.0, [l * angle.sin(), -l * angle.cos()], [0.0, 0.0]))
    };
    let beads = || Ensemble::new(table(), 21, bead);
    lanes_are_alone!(beads().integrate(Dop853, PiController::tolerance(1e-7), END), Fused, 21);
    lanes_are_alone!(beads().integrate(Rk4, FixedStep::new(0.02), END), Plain, 21);
    // Constraints that become dependent on the way: steps are rejected by what the projection does.
    lanes_are_alone!(linkages().integrate(Rk4, FixedStep::new(0.02), END), Plain, 21);
    let pendulum = |[number]: [u64; 1]| {
        let u = ((number * 37) % 101) as f64 / 101.0;
        // Some start straight down, where the inertia of φ vanishes.
        let theta = if number % 5 == 2 { 0.0 } else { 0.5 + u };
        (Pendulum::new(1.0 + u), State::new(0.0, [theta, 0.0], [0.0, 1.0]))
    };
    let pendulums = || Ensemble::new(table(), 21, pendulum);
    let projected = Projection(DormandPrince5);
    lanes_are_alone!(pendulums().integrate(projected, PiController::tolerance(1e-4), END), Fused, 21);
}

fn uncertain(n: u64) -> Ensemble<Random, impl Fn(<Random as Source>::Draw) -> (Particle, State<f64, 1>)> {
    let unit = Uniform::new(0.0, 1.0).expect("finite ends");
    Ensemble::new(Random::seed(5), n, move |mut rng| {
        let [u, v, w]: [f64; 3] = core::array::from_fn(|_| unit.sample(&mut rng));
        let k = if u < 0.05 { 1.0 } else { 0.0 };
        (Particle::new(k, 1.0 + v, 0.5), State::new(0.0, [0.5 + w], [0.0]))
    })
}

const N: u64 = 3000;

fn everything<P: Policy>(policy: P, threads: usize) -> Vec<u8> {
    let study =
        uncertain(N).integrate(Dop853, PiController::tolerance(1e-6), END).threads(threads).in_lanes(policy);
    let outcome = study
        .observe(&FinalState(|_: &Particle, end: &State<f64, 1>| end.q[0]), (Moments, Extrema, Collect))
        .expect("a sound study");
    assert_eq!(outcome.samples, N);
    assert!(outcome.failures.count > 100);
    bits(&outcome)
}

#[test]
fn threads_do_not_change_a_bit_of_lanes() {
    let one = everything(Fused, 1);
    for threads in [2, 3, 5] {
        assert_eq!(everything(Fused, threads), one, "{threads} threads");
    }
    let plain = everything(Plain, 1);
    assert_ne!(plain, one);
    assert_eq!(everything(Plain, 3), plain);
}

/// Checkpoints of a test, removed at the end.
struct Files(Vec<PathBuf>);

impl Files {
    fn new(name: &str, n: u64) -> Self {
        let path = |k| format!("lagrange-lanes-{name}-{}-{k}", std::process::id());
        Files((0..n).map(|k| std::env::temp_dir().join(path(k))).collect())
    }
}

impl Drop for Files {
    fn drop(&mut self) {
        for path in &self.0 {
            let _ = std::fs::remove_file(path);
        }
    }
}

#[test]
fn shards_make_the_whole() {
    let last = FinalState(|_: &Particle, end: &State<f64, 1>| end.q[0]);
    let whole = everything(Plain, 2);
    for of in [1, 2, 3, 7, 90] {
        let files = Files::new("shards", of);
        let study = || uncertain(N).integrate(Dop853, PiController::tolerance(1e-6), END);
        let mut samples = 0;
        for (shard, path) in files.0.iter().enumerate() {
            let shard = study().threads(1).shard(shard as u64, of).checkpoint(path, Duration::from_secs(60));
            let outcome = shard.in_lanes(Plain).observe(&last, (Moments, Extrema, Collect)).expect("a shard");
            samples += outcome.samples;
        }
        assert_eq!(samples, N);
        let merged =
            study().in_lanes(Plain).merge(&files.0, &last, (Moments, Extrema, Collect)).expect("all shards");
        assert_eq!(bits(&merged), whole, "{of} shards");
        // In any order; but not without one, not twice, and not another study.
        let backward: Vec<_> = files.0.iter().rev().collect();
        let again =
            study().in_lanes(Plain).merge(backward, &last, (Moments, Extrema, Collect)).expect("all shards");
        assert_eq!(bits(&again), whole);
        let fewer = &files.0[..files.0.len() - 1];
        let error = study()
            .in_lanes(Plain)
            .merge(fewer, &last, (Moments, Extrema, Collect))
            .expect_err("one is missing");
        assert!(matches!(error, EnsembleError::Shards(_)), "{error}");
        let twice = files.0.iter().chain(&files.0[..1]);
        let error = study()
            .in_lanes(Plain)
            .merge(twice, &last, (Moments, Extrema, Collect))
            .expect_err("one too many");
        assert!(error.to_string().contains("begins with samples that another has"), "{error}");
        let error = study()
            .in_lanes(Fused)
            .merge(&files.0, &last, (Moments, Extrema, Collect))
            .expect_err("other bits");
        assert!(matches!(error, EnsembleError::OtherStudy { .. }), "{error}");
    }
    let error = uncertain(N)
        .integrate(Rk4, FixedStep::new(0.1), END)
        .shard(3, 3)
        .in_lanes(Plain)
        .observe(&last, Moments);
    assert!(matches!(error, Err(EnsembleError::NoSuchShard { shard: 3, of: 3 })));
}

lagrangian! {
    /// A block on a spring, with dry friction, and a force of constant size towards the middle of its way.
    system Block {
        param k, mu, g;
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = 0.5 * k * x * x + g * (x - 0.1).abs();
        Q[x] = -mu * signum(dot(x));
    }
}

fn block([number]: [u64; 1]) -> (Block, State<f64, 1>) {
    let u = ((number * 37) % 101) as f64 / 101.0;
    // Strong friction holds, which series do not follow.
    let mu = if number % 5 == 2 { 6.0 } else { 0.05 * u };
    (Block::new(10.0 + 10.0 * u, mu, 0.5), State::new(0.1 * u, [1.0 + u], [0.0]))
}

/// A step that is cut short by a switch, and rejected, is followed by a part of what it was, in lanes and alone.
#[test]
fn steps_that_end_at_switches_are_rejected_as_alone() {
    let draw = |[number]: [u64; 1]| {
        (Landing::new(1e3 * (1.0 + number as f64)), State::new(0.0, [0.1 * (number + 1) as f64], [0.0]))
    };
    let balls = || Ensemble::new(Table::new((0..30).map(|number: u64| [number])), 30, draw);
    for (series, tolerance) in [(Taylor, 1e-15), (Taylor::of_order(12), 1e-7)] {
        lanes_are_alone!(balls().integrate(series, TaylorController::tolerance(tolerance), 1.5), Fused, 30);
    }
}

/// Each lane ends a step where it meets a switch of its own.
#[test]
fn switches_are_met_as_alone() {
    let blocks = || Ensemble::new(Table::new((0..21).map(|number: u64| [number])), 21, block);
    let series = Taylor::of_order(18);
    lanes_are_alone!(blocks().integrate(series, TaylorController::tolerance(1e-9), END), Fused, 21);
    lanes_are_alone!(blocks().integrate(series, FixedStep::new(0.07), END), Plain, 21);
    // Within the steps, too.
    let times: Vec<f64> = (10..=300).map(|k| 0.01 * f64::from(k)).collect();
    let sampled = Sampled::new(times.clone(), |_: &Block, states: &[State<f64, 1>]| {
        states.iter().map(|s| (s.t, s.q[0], s.qd[0])).collect::<Vec<_>>()
    });
    let turns = Occurrences::new(
        Event::new(Direction::Either, |s: &State<f64, 1>| s.qd[0] + 0.5),
        |_: &Block, met: &[lagrange_runtime::Occurrence<f64, 1>], _: &State<f64, 1>| -> Vec<f64> {
            met.iter().map(|o| o.state.t).collect()
        },
    );
    let study = blocks().integrate(series, TaylorController::tolerance(1e-9), END).in_lanes(Fused);
    let rows = study.observe(&(sampled, turns), Collect).expect("a sound study").statistic.rows;
    assert_eq!(rows.len(), 17);
    for (index, (states, met)) in rows {
        let alone = study.replay(index).expect("a sample");
        let expected: Vec<_> = alone
            .run()
            .sample(times.iter().map(|&t| SingleLane::new(t)))
            .map(|s| s.map(|s| (s.t.value(), s.q[0].value(), s.qd[0].value())))
            .collect::<Result<_, _>>()
            .expect("a run to its end");
        assert_eq!(states, expected);
        let half = SingleLane::<Fused>::new(0.5);
        let passes = Event::new(Direction::Either, |s: &State<SingleLane<Fused>, 1>| s.qd[0] + half);
        let expected: Vec<_> =
            alone.run().events(passes).map(|o| o.expect("an event").state.t.value()).collect();
        assert!(met.len() > 2 && met == expected, "{met:?} {expected:?}");
    }
}

#[test]
fn samples_and_steps_are_those_of_the_run() {
    let times: Vec<f64> = (0..=12).map(|k| 0.25 * f64::from(k)).collect();
    let study = uncertain(60).integrate(Dop853, PiController::tolerance(1e-9), END).in_lanes(Fused);
    let sampled = Sampled::new(times.clone(), |_: &Particle, states: &[State<f64, 1>]| {
        states.iter().map(|s| (s.t, s.q[0], s.qd[0])).collect::<Vec<_>>()
    });
    let largest = FoldSteps {
        start: |_: &Particle, start: &State<f64, 1>| (start.q[0].abs(), 0u64),
        step: |value: &mut (f64, u64), _: &Particle, _: &State<f64, 1>, to: &State<f64, 1>| {
            *value = (value.0.max(to.q[0].abs()), value.1 + 1);
        },
        finish: |value: (f64, u64), _: &Particle, _: &State<f64, 1>| value,
    };
    let states = study.observe(&sampled, Collect).expect("a sound study").statistic.rows;
    let folded = study.observe(&largest, Collect).expect("a sound study").statistic.rows;
    assert!(states.len() > 50 && states.len() == folded.len());
    for ((index, states), (_, folded)) in states.iter().zip(&folded) {
        let alone = study.replay(*index).expect("a sample");
        let expected: Vec<_> = alone
            .run()
            .sample(times.iter().map(|&t| SingleLane::new(t)))
            .map(|s| s.map(|s| (s.t.value(), s.q[0].value(), s.qd[0].value())))
            .collect::<Result<_, _>>()
            .expect("a run to its end");
        assert_eq!(states, &expected);
        let (mut value, mut steps) = (alone.start.q[0].value().abs(), 0);
        for step in alone.run() {
            (value, steps) = (value.max(step.expect("a step").to.q[0].value().abs()), steps + 1);
        }
        assert_eq!(folded, &(value, steps));
    }
}

/// Events of a sample in its lane: index, time and state of each, and the last state.
type Met = (Vec<(u64, [f64; 3])>, [f64; 3]);

fn numbers<S: Copy>(at: &State<S, 1>, value: impl Fn(S) -> f64) -> [f64; 3] {
    [at.t, at.q[0], at.qd[0]].map(value)
}

/// Events of a particle, over numbers of a type: it passes 1/5, it turns, and it passes the height.
macro_rules! events {
    ($scalar:ty, $height:expr) => {
        (
            Event::new(Direction::Either, |s: &State<$scalar, 1>| s.q[0] - <$scalar>::from_f64(0.2)),
            Event::new(Direction::Rising, |s: &State<$scalar, 1>| s.qd[0]),
            Event::new(Direction::Rising, |s: &State<$scalar, 1>| s.q[0] - <$scalar>::from_f64($height))
                .terminal(),
        )
    };
}

/// A study of particles, against the events of each alone.
macro_rules! events_are_alone {
    ($method:expr, $control:expr) => {{
        let study = || uncertain(60).integrate($method, $control, 3.0 * END).in_lanes(Fused);
        let watch = Occurrences::new(
            events!(f64, 0.1),
            |_: &Particle, met: &[lagrange_runtime::Occurrence<f64, 1>], end: &State<f64, 1>| -> Met {
                (
                    met.iter().map(|o| (o.event as u64, numbers(&o.state, |x| x))).collect(),
                    numbers(end, |x| x),
                )
            },
        );
        let mut counts = [0, 0, 0];
        for level in Level::compiled() {
            let found = study().level(level).observe(&watch, Collect).expect("a sound study");
            let mut rows = found.statistic.rows.iter();
            assert!(found.failures.count > 0);
            for index in 0..60 {
                let alone = study().replay(index).expect("a sample");
                let mut events = alone.run().events(events!(SingleLane<Fused>, 0.1));
                let met: Result<Vec<_>, _> = events.by_ref().collect();
                let Ok(met) = met else { continue };
                let expected: Vec<_> =
                    met.iter().map(|o| (o.event as u64, numbers(&o.state, SingleLane::value))).collect();
                let (number, row) = rows.next().expect("a sample");
                assert_eq!(
                    (*number, row),
                    (index, &(expected, numbers(events.state(), SingleLane::value))),
                    "{level:?}"
                );
                row.0.iter().for_each(|(event, _)| counts[*event as usize] += 1);
            }
            assert!(rows.next().is_none());
        }
        assert!(counts.iter().all(|&count| count > 50), "{counts:?}");
    }};
}

#[test]
fn events_are_those_of_the_run() {
    events_are_alone!(Dop853, PiController::tolerance(1e-9));
    events_are_alone!(Taylor, TaylorController::tolerance(1e-9));
}

/// Times at which states are wanted, and what ends the run before some of them.
#[test]
fn samples_end_where_an_event_ends_the_run() {
    let study = uncertain(60).integrate(Dop853, PiController::tolerance(1e-9), END).in_lanes(Plain);
    let times = (0..=300).map(|k| 0.01 * f64::from(k));
    let sampled = Sampled::new(times, |_: &Particle, states: &[State<f64, 1>]| {
        (states.len() as u64, states.last().map_or(f64::NAN, |s| s.t))
    });
    let below = Event::falling(|s: &State<f64, 1>| s.q[0] + 1.0).terminal();
    let met = Occurrences::new(
        below,
        |_: &Particle, met: &[lagrange_runtime::Occurrence<f64, 1>], end: &State<f64, 1>| {
            (met.first().map(|o| o.state.t), end.t)
        },
    );
    let rows = study.observe(&(sampled, met), Collect).expect("a sound study").statistic.rows;
    for (_, ((count, last), (met, end))) in &rows {
        assert_eq!(met.unwrap_or(END), *end);
        assert_eq!(*count, (end / 0.01).floor() as u64 + 1);
        assert!(*last <= *end && *end < last + 0.01);
    }
    let ended = rows.iter().filter(|(_, (_, (met, _)))| met.is_some()).count();
    assert!(ended > 10 && ended < rows.len(), "{ended}");
}

/// Tops that go through their pole, or nearly: velocities cancel there.
#[test]
fn velocities_that_cancel_fail_their_samples() {
    let draw = |[number]: [u64; 1]| {
        let (theta, p) = (0.5f64, 3.0 + 0.01 * number as f64);
        let off = if number % 3 == 0 { 0.1 } else { 0.0 };
        let phid = p / (1.0 + theta.cos()) + off;
        (Top::new(1.0, 1.0, 1.0), State::new(0.0, [0.0, theta, 0.0], [phid, 0.0, p - phid * theta.cos()]))
    };
    let study = || {
        let table = Table::new((0..20).map(|number: u64| [number]));
        Ensemble::new(table, 20, draw).integrate(Rodas4, PiController::tolerance(1e-6), 5.0).threads(1)
    };
    lanes_are_alone!(study(), Fused, 20);
    let end = FinalState(|_: &Top, end: &State<f64, 3>| end.t);
    let failures = study().in_lanes(Fused).observe(&end, Moments).expect("a sound study").failures;
    let cancels = |f: &Failure| matches!(f, Failure::Cancellation { .. });
    assert!(failures.kept.iter().all(|f| cancels(&f.failure) && f.index % 3 != 0));
    assert_eq!(failures.count, 12);
}

#[test]
fn times_out_of_order_fail_their_samples() {
    for times in [vec![-0.1], vec![1.0, 0.5], vec![1.0, 1.0], vec![f64::NAN], vec![0.5, f64::NAN]] {
        let last = *times.last().expect("one");
        let sampled = Sampled::new(times, |_: &Particle, states: &[State<f64, 1>]| states.len() as u64);
        let outcome = Ensemble::new(fates(&|_| Fate::Well, 20), 20, draw)
            .integrate(Dop853, PiController::tolerance(1e-9), END)
            .in_lanes(Fused)
            .observe(&sampled, Collect)
            .expect("a sound study");
        assert!(outcome.statistic.rows.is_empty() && outcome.failures.count == 20);
        for failed in outcome.failures.kept {
            assert!(
                matches!(failed.failure, Failure::SampleOrder { t, .. } if t.to_bits() == last.to_bits())
            );
        }
    }
}

#[test]
fn an_event_that_is_not_a_number_fails_its_sample() {
    let study = uncertain(20).integrate(Dop853, PiController::tolerance(1e-6), END).in_lanes(Plain);
    let root = Event::rising(|s: &State<f64, 1>| s.q[0].sqrt() - 9.0);
    let watch = Occurrences::new(
        root,
        |_: &Particle, met: &[lagrange_runtime::Occurrence<f64, 1>], _: &State<f64, 1>| met.len() as f64,
    );
    let outcome = study.observe(&watch, Moments).expect("a sound study");
    let failures = outcome.failures.kept;
    let not_finite = failures
        .iter()
        .filter(|f| matches!(f.failure, Failure::EventNotFinite { event, .. } if event.index == 0))
        .count();
    assert!(not_finite > 5, "{failures:?}");
}

/// The same observers serve runs alone, with the bits of `Run::sample`, `Run::events` and the steps, and in lanes.
#[test]
fn observers_serve_runs_and_lanes() {
    type Seen = (Vec<[f64; 3]>, Vec<f64>, (f64, u64));
    let times: Vec<f64> = (4..=12).map(|k| 0.25 * f64::from(k)).collect();
    let sampled = Sampled::new(times.clone(), |_: &Particle, states: &[State<f64, 1>]| {
        states.iter().map(|s| [s.t, s.q[0], s.qd[0]]).collect::<Vec<_>>()
    });
    let event = || Event::new(Direction::Either, |s: &State<f64, 1>| s.qd[0] + 0.5).terminal();
    let met = Occurrences::new(
        Event::new(Direction::Either, |s: &State<f64, 1>| s.qd[0] + 0.5),
        |_: &Particle, met: &[lagrange_runtime::Occurrence<f64, 1>], _: &State<f64, 1>| -> Vec<f64> {
            met.iter().map(|o| o.state.t).collect()
        },
    );
    let steps = FoldSteps {
        start: |_: &Particle, start: &State<f64, 1>| (start.q[0].abs(), 0u64),
        step: |value: &mut (f64, u64), _: &Particle, _: &State<f64, 1>, to: &State<f64, 1>| {
            *value = (value.0.max(to.q[0].abs()), value.1 + 1);
        },
        finish: |value: (f64, u64), _: &Particle, _: &State<f64, 1>| value,
    };
    let observer = ((sampled, met), steps);
    let landed = Occurrences::new(
        event(),
        |_: &Particle, _: &[lagrange_runtime::Occurrence<f64, 1>], end: &State<f64, 1>| *end,
    );
    let study = || uncertain(60).integrate(Dop853, PiController::tolerance(1e-9), END);
    let alone = study().observe(&observer, Collect).expect("a sound study");
    let beside = study().in_lanes(Fused).observe(&observer, Collect).expect("a sound study");
    let ends = study().observe(&landed, Collect).expect("a sound study").statistic.rows;
    assert_eq!(alone.failures.count, beside.failures.count);
    assert!(alone.statistic.rows.len() > 50 && alone.statistic.rows.len() == beside.statistic.rows.len());
    let parts = |((states, met), steps): &((Vec<[f64; 3]>, Vec<f64>), (f64, u64))| -> Seen {
        (states.clone(), met.clone(), *steps)
    };
    for ((index, seen), (_, lane)) in alone.statistic.rows.iter().zip(&beside.statistic.rows) {
        // (Samples that fail later are among these.)
        let (_, end) = ends.iter().find(|(sample, _)| sample == index).expect("an end");
        let ((states, met, steps), (of_lane, met_in_lane, _)) = (parts(seen), parts(lane));
        let replay = study().replay(*index).expect("a sample");
        let expected: Vec<_> = replay
            .run()
            .sample(times.iter().copied())
            .map(|s| s.map(|s| [s.t, s.q[0], s.qd[0]]))
            .collect::<Result<_, _>>()
            .expect("a run to its end");
        assert_eq!(states, expected);
        let passes = Event::new(Direction::Either, |s: &State<f64, 1>| s.qd[0] + 0.5);
        let expected: Vec<_> = replay.run().events(passes).map(|o| o.expect("an event").state.t).collect();
        assert_eq!(met, expected);
        assert_eq!(steps.1, replay.run().count() as u64);
        assert_eq!(end, &replay.run().events(event()).final_state().expect("an end"));
        for (a, b) in states.iter().flatten().zip(of_lane.iter().flatten()) {
            assert!((a - b).abs() < 1e-8, "{index}: {a} {b}");
        }
        assert!(
            met.iter().zip(&met_in_lane).all(|(a, b)| (a - b).abs() < 1e-8) && met.len() == met_in_lane.len()
        );
    }
    let disordered = Sampled::new([2.0, 1.0], |_: &Particle, states: &[State<f64, 1>]| states.len() as f64);
    let run = study().replay(3).expect("a sample");
    let failed = run.run().observe(&disordered).unwrap_err();
    assert_eq!(failed.failure, Failure::SampleOrder { t: 1.0, previous: 2.0 });
}

/// Lanes have the budget of their runs alone, of adaptive and of equal steps.
#[test]
fn budgets_are_those_of_runs() {
    fn check<C>(controller: C, budget: u64)
    where
        Dop853: Method<Particle, 1> + InLanes<Particle, C, Plain, 1>,
        C: Controller<f64, 1, <Dop853 as Method<Particle, 1>>::Error> + Sync + core::fmt::Debug,
    {
        let end = FinalState(|_: &Particle, end: &State<f64, 1>| end.t);
        let study = || uncertain(40).integrate(Dop853, controller.clone(), END).max_steps(budget);
        let alone = study().observe(&end, Moments).expect("a sound study");
        let beside = study().in_lanes(Plain).observe(&end, Moments).expect("a sound study");
        let used_up = |of: &[lagrange_runtime::ensemble::FailedSample<f64, 1>]| -> Vec<_> {
            of.iter()
                .filter(
                    |f| matches!(f.failure, Failure::BudgetUsedUp { max_steps, .. } if max_steps == budget),
                )
                .map(|f| {
                    let cost = f.statistics.expect("the cost of a run");
                    assert_eq!(cost.accepted + cost.rejected, budget);
                    (f.index, cost.evaluations)
                })
                .collect()
        };
        let (alone, beside) = (used_up(&alone.failures.kept), used_up(&beside.failures.kept));
        assert!(!alone.is_empty() && alone == beside, "{alone:?} {beside:?}");
    }
    check(PiController::tolerance(1e-9), 8);
    check(FixedStep::new(0.1), 25);
}

/// From rest the series of a lane does not exist, and its step is made alone.
#[test]
fn starts_at_rest_are_left_as_alone() {
    let ball = |[number]: [u64; 1]| {
        let speed = if number.is_multiple_of(3) { 0.0 } else { 0.1 * number as f64 };
        (Ball::new(0.25), State::new(0.0, [0.0, 0.0], [speed, 0.0]))
    };
    let balls = || Ensemble::new(Table::new((0..13).map(|number: u64| [number])), 13, ball);
    lanes_are_alone!(balls().integrate(Taylor, TaylorController::tolerance(1e-12), 2.0), Fused, 13);
    lanes_are_alone!(balls().integrate(Radau5, PiController::tolerance(1e-9), 2.0), Fused, 13);
}

/// A start that is on an event but for rounding does not meet it, and one soon before it does.
#[test]
fn starts_on_events_are_left_as_alone() {
    let particle = |[number]: [u64; 1]| {
        let u = number as f64 / 21.0;
        let speed = [-8.7e-17, 8.7e-17, 1e-9, -1e-9][number as usize % 4];
        (Particle::new(0.0, 1.0 + u, 0.0), State::new(u, [1.0], [speed]))
    };
    let study = Ensemble::new(Table::new((0..21).map(|number: u64| [number])), 21, particle)
        .integrate(Dop853, PiController::tolerance(1e-9), END)
        .in_lanes(Fused);
    let turns = Occurrences::new(
        Event::new(Direction::Either, |s: &State<f64, 1>| s.qd[0]),
        |_: &Particle, met: &[lagrange_runtime::Occurrence<f64, 1>], _: &State<f64, 1>| -> Vec<f64> {
            met.iter().map(|o| o.state.t).collect()
        },
    );
    for (index, met) in study.observe(&turns, Collect).expect("a sound study").statistic.rows {
        let alone = study.replay(index).expect("a sample");
        let turns = Event::new(Direction::Either, |s: &State<SingleLane<Fused>, 1>| s.qd[0]);
        let expected: Vec<_> =
            alone.run().events(turns).map(|o| o.expect("an event").state.t.value()).collect();
        assert_eq!(met, expected, "{index}");
        // x = cos ωt from its turning point, or 1e-9 before it where the velocity falls.
        let soon = met.first().is_some_and(|t| t - alone.start.t.value() < 1e-6);
        assert_eq!(soon, index % 4 == 2, "{index}: {met:?}");
    }
}

lagrangian! {
    /// An oscillator at rest, until a gust comes.
    system Gust {
        param at;
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = 0.5 * x.powi(2);
        Q[x] = exp(-(t - at).powi(2));
    }
}

/// Steps of bodies at rest are kept short in lanes as alone, and so are those that a controller limits.
#[test]
fn late_gusts_and_longest_steps() {
    let draw = |[k]: [u64; 1]| (Gust::new(8.0 + 3.0 * k as f64), State::new(0.0, [0.0], [0.0]));
    let table = || Table::new((0..20).map(|k| [k]));
    let study =
        || Ensemble::new(table(), 20, draw).integrate(Dop853, PiController::tolerance(1e-8), 90.0).threads(1);
    lanes_are_alone!(study(), Plain, 20);
    let controller = PiController::tolerance(1e-8).max_step(0.375);
    let study = || Ensemble::new(table(), 20, draw).integrate(Verner9, controller, 90.0).threads(1);
    lanes_are_alone!(study(), Plain, 20);
    let series = (Taylor::of_order(12), TaylorController::tolerance(1e-8).max_step(2.0));
    let study = || Ensemble::new(table(), 20, draw).integrate(series.0, series.1, 90.0).threads(1);
    lanes_are_alone!(study(), Plain, 20);
}

/// All samples begin with the step that one of them has reached: the same for any threads and lanes, and for fewer
/// evaluations.
#[test]
fn samples_begin_with_the_step_of_one() {
    let draw = |mut rng: <Random as Source>::Draw| {
        let speed: f64 = Uniform::new(40.0, 60.0).unwrap().sample(&mut rng);
        (Ball::new(1e-3), State::new(0.0, [0.0, 0.0], [speed, speed]))
    };
    let study = |controller| Ensemble::new(Random::seed(3), 60, draw).integrate(Dop853, controller, 5.0);
    let pi = PiController::tolerance(1e-8);
    let (plain, begun) = (study(pi), study(pi).first_step_of(7).expect("a sample"));
    // It is the size of a step of that sample.
    let sizes: Vec<f64> = plain.replay(7).unwrap().run().map(|step| step.unwrap().h).collect();
    let first = begun.replay(0).unwrap().run().next().unwrap().unwrap().h;
    assert!(sizes.contains(&first) && first > 3.0 * sizes[0], "{first} of {sizes:?}");
    let evaluations =
        |study: &lagrange_runtime::ensemble::Study<'_, Random, _, Ball, Dop853, PiController, 2>| {
            let all = (0..60).map(|index| {
                let replay = study.replay(index).unwrap();
                let mut run = replay.run();
                run.run_to_end().unwrap();
                (run.statistics().evaluations, run.state().q[0])
            });
            all.collect::<Vec<_>>()
        };
    let (slow, quick) = (evaluations(&plain), evaluations(&begun));
    let sum = |all: &[(u64, f64)]| all.iter().map(|one| one.0).sum::<u64>() as f64;
    assert!(sum(&quick) < 0.85 * sum(&slow), "{} {}", sum(&quick), sum(&slow));
    let error = quick.iter().zip(&slow).map(|(a, b)| (a.1 - b.1).abs()).fold(0.0, f64::max);
    assert!(error < 1e-6, "{error}");
    // Side by side and by any number of threads.
    let last = FinalState(|_: &Ball, end: &State<f64, 2>| end.q[0]);
    let of = |threads| {
        let study = study(pi).first_step_of(7).expect("a sample").threads(threads);
        study.in_lanes(Fused).observe(&last, Collect).expect("a sound study").statistic
    };
    assert_eq!(of(1), of(3));
    let refused = |result: Result<_, EnsembleError>| {
        result
            .map(|_: lagrange_runtime::ensemble::Study<'_, Random, _, Ball, Dop853, PiController, 2>| ())
            .expect_err("no first step")
            .to_string()
    };
    assert!(
        refused(study(pi).first_step_of(60)).contains("no sample 60"),
        "{}",
        refused(study(pi).first_step_of(60))
    );
    let lost = refused(study(pi).max_steps(1).first_step_of(0));
    assert!(lost.contains("sample 0 has no step for others to begin with"), "{lost}");
    let none = Ensemble::new(Random::seed(3), 60, draw).integrate(Dop853, pi, 0.0).first_step_of(7);
    let none = refused(none);
    assert!(none.contains("sample 7 makes no step: it begins at its end"), "{none}");
    let equal =
        Ensemble::new(Random::seed(3), 60, draw).integrate(Rk4, FixedStep::new(0.1), 5.0).first_step_of(0);
    let equal = equal.map(|_| ()).expect_err("equal steps").to_string();
    assert!(equal.contains("no first step"), "{equal}");
}
