//! Trajectories in lanes: `cargo bench --bench lanes`.
//!
//! 1. In lanes against the same one by one, on one thread, for each kind of processor and policy.
//!    Then the same with methods that iterate.
//! 2. What a study with statistics takes beside the bare loop of lanes.
//! 3. Two threads against two processes of one thread each, which share nothing.
//! 4. Elementary functions in lanes against those of the standard library, one by one.
//!
//! A double pendulum whose parameters and start are drawn at random. Ratios are medians of alternating rounds, with
//! their quartiles. `cargo bench --bench lanes -- speed` (or `implicit`, `statistics`, `threads`, `functions`) does
//! one of them; `-- memory` prints the peak of the memory of 10⁴ to 10⁷ short trajectories, and
//! `-- one dop853 avx512 1000 2` makes 1000 trajectories by one method on one kind of processor on two threads and
//! nothing else, to be counted or profiled; `scalar` stands for the scalar code, and `bare` for the loop without a
//! study (AVX2).

#![allow(missing_docs)]

mod support;

use core::fmt::Debug;
use core::marker::PhantomData;
use lagrange_runtime::Controller;
use lagrange_runtime::Functions;
use lagrange_runtime::ensemble::{
    Covariance, Ensemble, Histogram, Moments, Quantiles, Random, Source, of,
    rand_distr::{Distribution, Uniform},
};
use lagrange_runtime::integrate::{Failed, Statistics};
use lagrange_runtime::lanes::{
    Baseline, Bounds, FinalState, Fused, InLanes, Job, Jobs, Lanes, Level, Plain, Policy, Processor, Work,
};
use lagrange_runtime::method::Method;
use lagrange_runtime::method::rosenbrock::Rodas4;
use lagrange_runtime::prelude::*;
use std::hint::black_box;
use std::process::Command;
use std::time::Instant;
use support::ratio;
use support::systems::DoublePendulum;

const END: f64 = 10.0;

fn draw(mut rng: <Random as Source>::Draw) -> (DoublePendulum, State<f64, 2>) {
    let unit = Uniform::new(0.0, 1.0).expect("finite ends");
    let [a, b, m, n, k, l]: [f64; 6] = core::array::from_fn(|_| unit.sample(&mut rng));
    let system = DoublePendulum::new(0.5 + m, 0.5 + n, 0.5 + k, 0.5 + l, 9.81);
    (system, State::new(0.0, [0.5 + 2.0 * a, 2.0 * b - 1.0], [0.0, 0.0]))
}

fn lanes<M, C, P>(samples: u64, method: M, controller: C, policy: P, (level, threads): (Level, usize)) -> f64
where
    M: Method<DoublePendulum, 2> + InLanes<DoublePendulum, C, P, 2> + Clone + Debug,
    C: Controller<f64, 2, M::Error> + Sync + Debug,
    P: Policy,
{
    let study = Ensemble::new(Random::seed(1), samples, draw).integrate(method, controller, END);
    let study = study.threads(threads).in_lanes(policy).level(level);
    let last = FinalState(|_: &DoublePendulum, end: &State<f64, 2>| end.q[0]);
    study.observe(&last, Moments).expect("a sound study").statistic.mean()
}

fn scalar<M, C>(samples: u64, method: M, controller: C, threads: usize) -> f64
where
    M: Method<DoublePendulum, 2> + Clone + Sync + Debug,
    C: Controller<f64, 2, M::Error> + Sync + Debug,
{
    let study = Ensemble::new(Random::seed(1), samples, draw).integrate(method, controller, END);
    let study = study.threads(threads);
    study.reduce(|_, run| Ok(run.final_state()?.q[0]), Moments).expect("a sound study").statistic.mean()
}

fn compare<M, C>(name: &str, samples: u64, method: M, controller: C)
where
    M: Method<DoublePendulum, 2> + Clone + Copy + Debug,
    M: InLanes<DoublePendulum, C, Fused, 2> + InLanes<DoublePendulum, C, Plain, 2>,
    C: Controller<f64, 2, M::Error> + Copy + Sync + Debug,
{
    // Without the instruction a fused multiply-add is a function.
    let fused = Level::available().filter(|&level| level > Level::Baseline).map(|level| (level, true));
    for (level, fused) in fused.chain(Level::available().map(|level| (level, false))) {
        let found = ratio(
            samples as usize,
            || _ = black_box(scalar(samples, method, controller, 1)),
            || {
                _ = black_box(if fused {
                    lanes(samples, method, controller, Fused, (level, 1))
                } else {
                    lanes(samples, method, controller, Plain, (level, 1))
                })
            },
        );
        let [low, high] = found.quartiles;
        let policy = if fused { "fused" } else { "rounded" };
        println!(
            "{name}, {level:?}, {policy}: {:.2} ({low:.2} – {high:.2}) of the scalar code",
            found.median
        );
    }
}

/// The runs of a study, and the sum of their ends: nothing that could be less.
struct Bare {
    next: u64,
    samples: u64,
    sum: f64,
}

impl Jobs<DoublePendulum, f64, 2> for Bare {
    fn next(&mut self) -> Option<Job<DoublePendulum, 2>> {
        let index = self.next;
        self.next += 1;
        let (system, start) = (index < self.samples).then(|| draw(Random::seed(1).draw(index)))?;
        Some(Job { index, system, start })
    }

    fn done(&mut self, _: u64, _: Statistics, output: Result<f64, Failed<f64, 2>>) {
        self.sum += output.unwrap_or(f64::NAN);
    }
}

fn bare(samples: u64, level: Level, end: f64) -> f64 {
    let mut jobs = Bare { next: 0, samples, sum: 0.0 };
    let last = FinalState(|_: &DoublePendulum, end: &State<f64, 2>| end.q[0]);
    let bounds = Bounds { end, max_steps: None };
    InLanes::<_, _, Fused, 2>::runs(&Dop853, level, &PiController::tolerance(1e-9), bounds, &last, &mut jobs);
    jobs.sum / samples as f64
}

/// With all that is usually asked.
fn full(samples: u64, level: Level, end: f64) -> f64 {
    let study =
        Ensemble::new(Random::seed(1), samples, draw).integrate(Dop853, PiController::tolerance(1e-9), end);
    let study = study.threads(1).in_lanes(Fused).level(level);
    let last = FinalState(|_: &DoublePendulum, end: &State<f64, 2>| [end.q[0], end.q[1]]);
    let first = |ends: &[f64; 2]| ends[0];
    let statistics = (
        of(first, Moments),
        of(first, Histogram::new(-4.0, 4.0, 100)),
        of(first, Quantiles::to(0.01)),
        of(|ends: &[f64; 2]| *ends, Covariance::<2>),
    );
    study.observe(&last, statistics).expect("a sound study").statistic.0.mean()
}

fn statistics() {
    for (end, samples) in [(1.0, 2048), (END, 512)] {
        let found = ratio(
            samples as usize,
            || _ = black_box(full(samples, Level::best(), end)),
            || _ = black_box(bare(samples, Level::best(), end)),
        );
        let [low, high] = found.quartiles;
        println!(
            "moments, histogram, quantiles, covariance; to t = {end}: {:.3} ({low:.3} – {high:.3}) of the bare loop",
            found.median
        );
    }
}

fn itself(arguments: &[&str]) -> Command {
    let mut command = Command::new(std::env::current_exe().expect("a program"));
    command.args(arguments).stdout(std::process::Stdio::null());
    command
}

fn threads() {
    const SAMPLES: u64 = 40_000;
    let (half, all) = ((SAMPLES / 2).to_string(), SAMPLES.to_string());
    let processes = || {
        let start = Instant::now();
        let both = [(); 2].map(|()| itself(&["one", "dop853", "best", &half, "1"]).spawn().expect("started"));
        both.into_iter().for_each(|mut one| assert!(one.wait().expect("an end").success()));
        start.elapsed().as_secs_f64()
    };
    let threads = || {
        let start = Instant::now();
        assert!(itself(&["one", "dop853", "best", &all, "2"]).status().expect("an end").success());
        start.elapsed().as_secs_f64()
    };
    let mut ratios: Vec<f64> = (0..15).map(|_| processes() / threads()).collect();
    ratios.sort_by(f64::total_cmp);
    println!(
        "two threads reach {:.3} ({:.3} – {:.3}) of what two processes do",
        ratios[7], ratios[3], ratios[11]
    );
}

fn memory() {
    for samples in ["10000", "100000", "1000000", "10000000"] {
        let output = Command::new(std::env::current_exe().expect("a program"))
            .args(["short", samples])
            .output()
            .expect("an end");
        print!("{samples} samples: {}", String::from_utf8_lossy(&output.stdout));
    }
}

/// A function at many numbers, in lanes of a processor.
struct Each<'a, F, A> {
    x: &'a mut [[f64; 8]],
    of: PhantomData<(F, A)>,
}

macro_rules! functions {
    ($($name:ident from $low:literal to $high:literal)*) => {
        $(
            #[allow(non_camel_case_types)]
            struct $name;

            impl<A: Processor> Work for Each<'_, $name, A> {
                type Output = ();

                #[inline(always)]
                fn run(self) {
                    for x in self.x.iter_mut() {
                        *x = Functions::$name(Lanes::<8, Fused, A>::new(*x)).to_array();
                    }
                }
            }
        )*

        fn functions() {
            $({
                let numbers: Vec<[f64; 8]> = (0..512)
                    .map(|k| core::array::from_fn(|i| {
                        let u = f64::from(8 * k + i as i32) * 0.618_033_988_749_894_9 % 1.0;
                        $low + ($high - $low) * u
                    }))
                    .collect();
                let (mut one, mut many) = (numbers.clone(), numbers.clone());
                let found = ratio(
                    4096,
                    || {
                        one.copy_from_slice(&numbers);
                        one.iter_mut().flatten().for_each(|x| *x = x.$name());
                        black_box(&one);
                    },
                    || {
                        many.copy_from_slice(&numbers);
                        fn all<A: Processor>(x: &mut [[f64; 8]]) {
                            A::call(Each { x, of: PhantomData::<($name, A)> });
                        }
                        match Level::best() {
                            #[cfg(target_arch = "x86_64")]
                            Level::Avx512 => all::<lagrange_runtime::lanes::Avx512>(&mut many),
                            #[cfg(target_arch = "x86_64")]
                            Level::Avx2 => all::<lagrange_runtime::lanes::Avx2>(&mut many),
                            _ => all::<Baseline>(&mut many),
                        }
                        black_box(&many);
                    },
                );
                let [alone, beside] = found.nanoseconds;
                println!(
                    "{}: {:.1} of the standard library ({:.2} against {:.2} in units of its sine)",
                    stringify!($name), found.median, alone / sine(), beside / sine()
                );
            })*
        }
    };
}

/// Nanoseconds of a sine of the standard library: a unit for times.
fn sine() -> f64 {
    static SINE: std::sync::OnceLock<f64> = std::sync::OnceLock::new();
    *SINE.get_or_init(|| {
        let numbers: Vec<f64> = (0..4096).map(|k| f64::from(k) * 0.0017 - 3.0).collect();
        let all = || numbers.iter().map(|x| x.sin()).sum::<f64>();
        ratio(4096, || _ = black_box(all()), || _ = black_box(all())).nanoseconds[1]
    })
}

functions! {
    sin from -10.0 to 10.0
    cos from -10.0 to 10.0
    tan from -10.0 to 10.0
    asin from -1.0 to 1.0
    acos from -1.0 to 1.0
    atan from -10.0 to 10.0
    sinh from -5.0 to 5.0
    cosh from -5.0 to 5.0
    tanh from -5.0 to 5.0
    asinh from -10.0 to 10.0
    acosh from 1.0 to 10.0
    atanh from -1.0 to 1.0
    exp from -20.0 to 20.0
    exp_m1 from -2.0 to 2.0
    exp2 from -20.0 to 20.0
    ln from 0.01 to 100.0
    ln_1p from -0.9 to 10.0
    log2 from 0.01 to 100.0
    log10 from 0.01 to 100.0
    cbrt from -10.0 to 10.0
}

fn one(method: &str, level: &str, samples: u64, threads: usize) {
    let (rk4, dop853) = (FixedStep::new(1e-3), PiController::tolerance(1e-9));
    let level = match level {
        "scalar" | "bare" => None,
        "baseline" => Some(Level::Baseline),
        "avx2" => Some(Level::Avx2),
        "avx512" => Some(Level::Avx512),
        "best" => Some(Level::best()),
        other => panic!("{other}: scalar, baseline, avx2, avx512 or best"),
    }
    .map(|level| (level, threads));
    let mean = match (method, level) {
        ("bare", _) => bare(samples, Level::Avx2, END),
        ("full", _) => full(samples, Level::Avx2, END),
        ("rk4", None) => scalar(samples, Rk4, rk4, threads),
        ("dop853", None) => scalar(samples, Dop853, dop853, threads),
        ("rk4", Some((Level::Baseline, _))) => lanes(samples, Rk4, rk4, Plain, (Level::Baseline, threads)),
        ("dop853", Some((Level::Baseline, _))) => {
            lanes(samples, Dop853, dop853, Plain, (Level::Baseline, threads))
        }
        ("rk4", Some(level)) => lanes(samples, Rk4, rk4, Fused, level),
        ("dop853", Some(level)) => lanes(samples, Dop853, dop853, Fused, level),
        ("gauss4", Some(level)) => lanes(samples, Gauss4, FixedStep::new(0.01), Fused, level),
        ("gauss4", None) => scalar(samples, Gauss4, FixedStep::new(0.01), threads),
        ("midpoint", None) => scalar(samples, VariationalMidpoint, FixedStep::new(0.01), threads),
        ("radau5", None) => scalar(samples, Radau5, PiController::tolerance(1e-6), threads),
        ("midpoint", Some(level)) => lanes(samples, VariationalMidpoint, FixedStep::new(0.01), Fused, level),
        ("radau5", Some(level)) => lanes(samples, Radau5, PiController::tolerance(1e-6), Fused, level),
        (other, _) => panic!("{other}: rk4, dop853, gauss4, midpoint, radau5, bare or full"),
    };
    println!("{mean}");
}

fn main() {
    let arguments: Vec<String> =
        std::env::args().skip(1).filter(|argument| !argument.starts_with('-')).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let number = |text: &str| text.parse::<u64>().expect("a number");
    match arguments[..] {
        ["one", method, level, samples, threads] => {
            one(method, level, number(samples), number(threads) as usize);
        }
        ["memory"] => memory(),
        ["short", samples] => {
            black_box(full(number(samples), Level::best(), 0.01));
            let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
            println!("{}", status.lines().find(|line| line.starts_with("VmHWM")).unwrap_or("unknown"));
        }
        _ => {
            let asked = |name: &str| arguments.is_empty() || arguments.contains(&name);
            if asked("speed") {
                compare("RK4, h = 1e-3", 32, Rk4, FixedStep::new(1e-3));
                compare("DOP853 at 1e-9", 256, Dop853, PiController::tolerance(1e-9));
            }
            if asked("implicit") {
                compare("Gauss4, h = 0.01", 64, Gauss4, FixedStep::new(0.01));
                compare("VariationalMidpoint, h = 0.01", 64, VariationalMidpoint, FixedStep::new(0.01));
                compare("Radau5 at 1e-6", 64, Radau5, PiController::tolerance(1e-6));
                compare("Rodas4 at 1e-6", 64, Rodas4, PiController::tolerance(1e-6));
            }
            if asked("statistics") {
                statistics();
            }
            if asked("threads") {
                threads();
            }
            if asked("functions") {
                functions();
            }
        }
    }
}
