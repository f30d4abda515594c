//! Multifidelity Monte Carlo, and studies that stop by themselves, against closed forms: cost, bias, coverage, bits.

use lagrange_runtime::Occurrence;
use lagrange_runtime::ensemble::rand_distr::{Distribution, Exp1, StandardNormal};
use lagrange_runtime::ensemble::{
    ClosedForm, ConfidenceInterval, Ensemble, EnsembleError, HalfWidth, Model, Moments, Multifidelity,
    MultifidelityEstimate, Probability, Quantiles, Random, Record, Simulation, Source, Table,
};
use lagrange_runtime::lanes::{FinalState, Fused, Occurrences};
use lagrange_runtime::prelude::*;
use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::Duration;

type Generator = <Random as Source>::Draw;

lagrangian! {
    /// A ball that air slows down.
    system Ball {
        param drag;
        coord x, y;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = 9.81 * y;
        let v = hypot(dot(x), dot(y));
        force [-drag * v * dot(x), -drag * v * dot(y)] at [x, y];
    }
}

lagrangian! {
    /// Two equal pendulums in a row.
    pub system DoublePendulum {
        coord a, b;
        let x = sin(a) + sin(b);
        let y = cos(a) + cos(b);
        T = 0.5 * dot(a).powi(2) + 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = -cos(a) - y;
        pub simplified Linear: expand a to 2 about 0, expand b to 2 about 0;
    }
}

lagrangian! {
    /// A pendulum on a stiff spring.
    pub system Spring {
        param k;
        coord r: length, theta: angle;
        T = 0.5 * (dot(r).powi(2) + (r * dot(theta)).powi(2));
        V = 0.5 * k * (r - 1).powi(2) - 9.81 * r * cos(theta);
        pub simplified Rigid: lock r = 1;
    }
}

lagrangian! {
    /// A flywheel drives a piston by a crank and a rod that stretches by s.
    pub system Crank {
        param inertia, radius, piston, k, c;
        coord theta: angle, s: length;
        let rod = 1 + s;
        let x = radius * theta.cos() + (rod.powi(2) - (radius * theta.sin()).powi(2)).sqrt();
        T = 0.5 * inertia * dot(theta).powi(2) + 0.5 * piston * dot(x).powi(2);
        V = 0.5 * k * s.powi(2);
        D = 0.5 * c * dot(s).powi(2);
        observe place = x;
        pub simplified RigidRod: lock s = 0;
    }
}

/// Two normal numbers of correlation ρ, mean 1 and 2, standard deviations 3 and 0.5.
fn pair(rng: &mut Generator, correlation: f64) -> [f64; 2] {
    let [a, b]: [f64; 2] = core::array::from_fn(|_| StandardNormal.sample(rng));
    let other = correlation * a + (1.0 - correlation * correlation).sqrt() * b;
    [1.0 + 3.0 * a, 2.0 + 0.5 * other]
}

/// The cost of a given variance against that of plain Monte Carlo.
fn cost_ratio(correlation: f64, w: f64) -> f64 {
    ((1.0 - correlation.powi(2)).sqrt() + (w * correlation.powi(2)).sqrt()).powi(2)
}

type Form<F> = ClosedForm<F>;

/// A study of that pair by its closed form.
fn linear(
    seed: u64,
    correlation: f64,
    cost: f64,
) -> Multifidelity<'static, Random, Form<impl Fn(Generator) -> f64>, Form<impl Fn(Generator) -> f64>> {
    let full = ClosedForm::new(move |mut rng| pair(&mut rng, correlation)[0]);
    let cheap = ClosedForm::new(move |mut rng| pair(&mut rng, correlation)[1]).cost(cost);
    Multifidelity::new(Random::seed(seed), 100_000_000, full, cheap).threads(1)
}

/// All bits of an estimate.
fn bits(estimate: &MultifidelityEstimate) -> Vec<u8> {
    let mut bytes = vec![];
    let numbers = [
        estimate.mean(),
        estimate.standard_error(),
        estimate.half_width(0.95),
        estimate.cost,
        estimate.pilot.correlation,
    ];
    (numbers, estimate.samples, estimate.failed, estimate.not_finite).write(&mut bytes);
    for failed in &estimate.failures {
        failed.to_string().write(&mut bytes);
    }
    bytes
}

/// The cost of a given variance against that of plain Monte Carlo: (√(1 − ρ²) + √(w ρ²))², 0.0209 at ρ = 0.999 and
/// w = 1/100; and a loose tolerance at a quarter of the cost is no better than a quarter, whatever its correlation.
#[test]
fn the_cost_is_that_of_the_closed_form() {
    let exact = cost_ratio(0.999, 0.01);
    assert!((exact - 0.0209).abs() < 5e-5, "{exact}");
    let estimate = linear(1, 0.999, 0.01).pilot_samples(1024).within_budget(20_000.0).expect("a sound study");
    println!("{}: {:.5} of {exact:.5}", estimate.pilot, estimate.cost_ratio());
    let plain = 9.0 / estimate.standard_error().powi(2);
    assert!((estimate.plain_samples() / plain - 1.0).abs() < 0.2, "{}", estimate.plain_samples());
    // Standard deviations of the pilot's ρ make a hundredth of it, those of the variances of two thousand samples
    // some more.
    assert!((estimate.cost_ratio() / exact - 1.0).abs() < 0.1, "{} {exact}", estimate.cost_ratio());
    assert!(estimate.cost <= 20_000.0 && estimate.cost > 19_500.0, "{}", estimate.cost);

    let loose =
        linear(2, 1.0 - 1e-7, 0.25).pilot_samples(1024).within_budget(20_000.0).expect("a sound study");
    println!("{}: {:.5}", loose.pilot, loose.cost_ratio());
    assert!((0.245..0.265).contains(&loose.cost_ratio()), "{}", loose.cost_ratio());
}

/// 400 studies of a skewed output, to a half-width and within a budget: the intervals of 95 % cover the mean in 95 %
/// ± 3 % of them, the mean of the means is the exact one, and their scatter what they say.
#[test]
fn intervals_cover_the_mean() {
    let exact = 1.0;
    let study = |seed| {
        // An exponential number, and one that is near it for a quarter of the cost of one in fifty.
        let full = ClosedForm::new(|mut rng: Generator| -> f64 { Exp1.sample(&mut rng) });
        let cheap = ClosedForm::new(|mut rng: Generator| {
            let x: f64 = Exp1.sample(&mut rng);
            let noise: f64 = StandardNormal.sample(&mut rng);
            x.sqrt() + 0.1 * noise
        });
        Multifidelity::new(Random::seed(seed), 10_000_000, full, cheap.cost(0.02)).threads(1)
    };
    let runs: [&dyn Fn(u64) -> Result<MultifidelityEstimate, EnsembleError>; 2] =
        [&|seed| study(seed).to_half_width(0.03), &|seed| study(seed + 1000).within_budget(500.0)];
    for (run, name) in runs.into_iter().zip(["to a half-width", "within a budget"]) {
        let estimates: Vec<_> = (0..400).map(|seed| run(seed).expect("a sound study")).collect();
        let covered = estimates
            .iter()
            .filter(|estimate| {
                let [low, high] = estimate.confidence_interval(0.95);
                (low..=high).contains(&exact)
            })
            .count();
        let mean = |of: &dyn Fn(&MultifidelityEstimate) -> f64| estimates.iter().map(of).sum::<f64>() / 400.0;
        let (middle, claimed) = (mean(&|e| e.mean()), mean(&|e| e.standard_error().powi(2)));
        let scatter = mean(&|e| (e.mean() - exact).powi(2));
        println!(
            "{name}: {covered} of 400, mean {middle:.5}, variance {scatter:.3e} of {claimed:.3e}, ratio {:.3}, {:.0} full samples",
            mean(&|e| e.cost_ratio()),
            mean(&|e| e.samples[0] as f64)
        );
        assert!((368..=392).contains(&covered), "{name}: {covered}");
        assert!((middle - exact).abs() < 4.0 * (claimed / 400.0).sqrt(), "{name}: {middle}");
        // A variance of 400 has a relative standard deviation of √(2/400) = 0.07.
        assert!((scatter / claimed - 1.0).abs() < 0.3, "{name}: {scatter} {claimed}");
        assert!(estimates.iter().all(|e| e.pilot.gain.is_some() && e.reached));
    }
}

/// The full model runs alone where the models do not correlate, or the cheap one is not cheap; a study of it covers the
/// mean all the same.
#[test]
fn no_gain_is_said() {
    for (correlation, cost) in [(0.1, 0.1), (0.9, 0.9), (0.5, 0.25)] {
        let pilot = linear(3, correlation, cost).pilot().expect("a sound pilot");
        assert!(pilot.gain.is_none(), "{pilot}");
        assert!(pilot.to_string().contains("no gain"), "{pilot}");
    }
    let alone = linear(4, 0.1, 0.1).to_half_width(0.2).expect("a sound study");
    assert!(alone.reached && alone.half_width(0.95) <= 0.2 && alone.samples[1] == 0);
    assert!((alone.mean() - 1.0).abs() < 0.4 && (alone.cost_ratio() - 1.0).abs() < 1e-9);
    // Of few samples that agree by chance there is no gain either: ρ = 0.3 and w = 1/100 have a gain of 4 % only.
    let chance =
        (0..40).filter(|&seed| linear(seed, 0.0, 0.1).pilot().is_ok_and(|pilot| pilot.gain.is_some()));
    assert_eq!(chance.count(), 0);
    let gains = linear(5, 0.95, 0.05).pilot().expect("a sound pilot");
    assert!(gains.gain.is_some_and(|gain| gain.ratio > 5.0), "{gains}");
}

/// A model that agrees to all digits leaves the full one with its least number of samples, and the cheap one with no
/// more than it needs.
#[test]
fn models_that_agree_cost_what_the_cheap_one_costs() {
    let estimate = linear(6, 1.0, 0.01).to_half_width(0.05).expect("a sound study");
    let plain = (3.0 * 1.96 / 0.05f64).powi(2);
    assert!((64..=128).contains(&estimate.samples[0]), "{:?}", estimate.samples);
    assert!((estimate.samples[1] as f64 / plain - 1.0).abs() < 0.5, "{:?} {plain}", estimate.samples);
    assert!(estimate.reached && (estimate.mean() - 1.0).abs() < 0.1);
    let estimate = linear(6, 1.0, 0.01).within_budget(500.0).expect("a sound study");
    assert!((450.0..=500.0).contains(&estimate.cost), "{}", estimate.cost);
}

/// A pair of simulations: a ball with drag, and one at a loose tolerance.
macro_rules! balls {
    ($seed:expr $(, $lanes:ident)?) => {{
        let ball = |mut rng: Generator| {
            let [x, y]: [f64; 2] = core::array::from_fn(|_| StandardNormal.sample(&mut rng));
            // Some starts are not finite.
            let speed = if x > 2.5 { f64::NAN } else { 10.0 + x };
            (Ball::new(0.2 + 0.02 * y), State::new(0.0, [0.0, 0.0], [speed, 0.5 * speed]))
        };
        let range = || FinalState(|_: &Ball, end: &State<f64, 2>| end.q[0]);
        let full = Simulation::new(ball, Dop853, PiController::tolerance(1e-9), 1.0, range());
        let cheap = Simulation::new(ball, DormandPrince5, PiController::tolerance(1e-2), 1.0, range());
        $(let (full, cheap) = (full.in_lanes($lanes), cheap.in_lanes($lanes));)?
        Multifidelity::new(Random::seed($seed), 200_000, full, cheap)
    }};
}

#[test]
fn threads_lanes_and_interruptions_do_not_change_a_bit() {
    let by = |threads| balls!(1).threads(threads).to_half_width(0.02).expect("a sound study");
    let one = by(1);
    println!("{}: {:?}, {:.3}, {} failed", one.pilot, one.samples, one.cost_ratio(), one.failed);
    assert!(one.pilot.gain.is_some() && one.failed > 0 && one.failures[0].failure.cause().is_some());
    for threads in [2, 5] {
        assert_eq!(bits(&by(threads)), bits(&one), "{threads} threads");
    }
    let lanes = |threads| balls!(1, Fused).threads(threads).to_half_width(0.02).expect("a sound study");
    let in_lanes = lanes(1);
    assert_eq!(bits(&lanes(3)), bits(&in_lanes));
    // Another rounding, the same numbers.
    assert!((in_lanes.mean() - one.mean()).abs() < 1e-6 && in_lanes.samples == one.samples);

    let path = std::env::temp_dir().join(format!("lagrange-multifidelity-{}", std::process::id()));
    let mut stops = 0;
    let done = loop {
        let rounds = Cell::new(0);
        let study = balls!(1).threads(1 + stops % 2).checkpoint(&path, Duration::ZERO).progress(|_| {
            rounds.set(rounds.get() + 1);
            assert!(rounds.get() < 2, "stop");
        });
        match catch_unwind(AssertUnwindSafe(|| study.to_half_width(0.02))) {
            Ok(estimate) => break estimate.expect("a sound study"),
            Err(_) => stops += 1,
        }
    };
    assert!(stops > 2, "{stops}");
    assert_eq!(bits(&done), bits(&one));
    // Another goal is another study.
    let other = balls!(1).checkpoint(&path, Duration::ZERO).to_half_width(0.01);
    assert!(matches!(other, Err(EnsembleError::OtherStudy { .. })));
    let _ = std::fs::remove_file(path);
}

/// Evaluations in lanes are those of each draw alone, whatever is beside it: outputs, failures and work.
#[test]
fn a_model_in_lanes_depends_on_the_draw_alone() {
    let draw =
        |k: u64| (Ball::new(0.01 * k as f64), State::new(0.0, [0.0, 0.0], [3.0, 2.0 + 0.1 * k as f64]));
    let landing = || {
        let ground = Event::falling(|at: &State<f64, 2>| at.q[1]).terminal();
        Occurrences::new(ground, |_: &Ball, met: &[Occurrence<f64, 2>], end: &State<f64, 2>| {
            (met.len() as f64, end.t, end.q[0])
        })
    };
    let model = Simulation::new(draw, Dop853, PiController::tolerance(1e-8), 5.0, landing()).in_lanes(Fused);
    let together = model.evaluate((0..50).collect());
    for (k, beside) in together.iter().enumerate() {
        assert_eq!(&model.evaluate(vec![k as u64])[0], beside, "{k}");
    }
    assert!(together.iter().all(|evaluated| evaluated.work > 20 && evaluated.output.is_ok()));
    let implicit =
        Simulation::new(draw, Radau5, PiController::tolerance(1e-6), 1.0, landing()).in_lanes(Fused);
    let refused = Model::<u64>::check(&implicit).expect_err("no cost");
    assert!(refused.contains("give the cost of a step"), "{refused}");
}

#[test]
fn bad_input_is_refused_with_the_reason() {
    let refused = |result: Result<MultifidelityEstimate, EnsembleError>, words: &str| match result {
        Err(error) => assert!(error.to_string().contains(words), "{words}: {error}"),
        Ok(estimate) => panic!("{words}: {estimate:?}"),
    };
    let constant = || ClosedForm::new(|_: f64| 1.0);
    let rows = || Table::new((0..4096).map(|k| f64::from(k % 97)));
    let itself = || ClosedForm::new(|x: f64| x);
    refused(
        Multifidelity::new(rows(), 4096, constant(), itself()).to_half_width(0.1),
        "the same for all 128",
    );
    refused(Multifidelity::new(rows(), 5000, itself(), itself()).to_half_width(0.1), "4096");
    refused(Multifidelity::new(rows(), 0, itself(), itself()).to_half_width(0.1), "at least one sample");
    refused(Multifidelity::new(rows(), 100, itself(), itself()).to_half_width(0.1), "no room for a pilot");
    refused(
        Multifidelity::new(rows(), 4096, itself(), itself()).to_half_width(-1.0),
        "half-width has to be positive",
    );
    refused(
        Multifidelity::new(rows(), 4096, itself(), itself()).confidence(95.0).to_half_width(1.0),
        "between 0 and 1",
    );
    refused(Multifidelity::new(rows(), 4096, itself(), itself()).within_budget(200.0), "does not suffice");
    refused(Multifidelity::new(rows(), 4096, itself(), itself()).within_budget(f64::NAN), "does not suffice");
    refused(
        Multifidelity::new(rows(), 4096, itself(), itself().cost(0.0)).to_half_width(0.1),
        "positive and finite",
    );
    let not_finite = ClosedForm::new(|_: f64| f64::NAN);
    refused(Multifidelity::new(rows(), 4096, not_finite, itself()).to_half_width(0.1), "too few to plan by");
    // A cheap model whose output is constant is no help, and no error.
    let pilot = Multifidelity::new(rows(), 4096, itself(), constant().cost(0.01)).pilot().expect("a pilot");
    assert!(pilot.gain.is_none() && pilot.correlation.is_nan());
    // Samples that do not suffice are said.
    let short = Multifidelity::new(rows(), 4096, itself(), itself()).to_half_width(1e-6).expect("a study");
    assert!(!short.reached && short.half_width(0.95) > 1e-6);
    let [cheap, rich] = [220.0, 1e9].map(|budget| {
        let study = Multifidelity::new(rows(), 4096, itself(), itself().cost(0.01));
        study.within_budget(budget).expect("a study").reached
    });
    assert!(cheap && !rich);
}

/// A double pendulum that turns over: at first a loose tolerance follows it, later it does not.
#[test]
fn a_chaotic_scene_has_no_gain() {
    let pilot = |end: f64| {
        let draw = |mut rng: Generator| {
            let x: f64 = StandardNormal.sample(&mut rng);
            (DoublePendulum::new(), State::new(0.0, [2.0 + 0.01 * x, 2.5], [0.0, 0.0]))
        };
        let angle = || FinalState(|_: &DoublePendulum, end: &State<f64, 2>| end.q[1].sin());
        let full = Simulation::new(draw, Dop853, PiController::tolerance(1e-9), end, angle());
        let loose = Simulation::new(draw, DormandPrince5, PiController::tolerance(1e-3), end, angle());
        Multifidelity::new(Random::seed(1), 1000, full, loose).pilot().expect("a sound pilot")
    };
    let (short, long) = (pilot(2.0), pilot(60.0));
    println!("{short}\n{long}");
    assert!(short.gain.is_some() && long.gain.is_none(), "{short} {long}");
}

/// A study whose outputs are exponential numbers: runs that begin at their end.
macro_rules! exponential {
    ($seed:expr, $samples:expr) => {
        Ensemble::new(Random::seed($seed), $samples, |mut rng| {
            (Ball::new(0.0), State::new(0.0, [Exp1.sample(&mut rng), 0.0], [0.0, 0.0]))
        })
        .integrate(Rk4, FixedStep::new(0.1), 0.0)
    };
}

/// The number of studies that stop by themselves whose intervals of 95 % cover the mean.
fn covered(rule: HalfWidth, n: u64) -> usize {
    let hits = (0..n).filter(|&seed| {
        let study = exponential!(seed, 1 << 20).threads(1);
        let outcome = study.reduce_until(|_, run| Ok(run.final_state()?.q[0]), Moments, rule);
        let [low, high] = outcome.expect("a sound study").statistic.confidence_interval(0.95);
        (low..=high).contains(&1.0)
    });
    hits.count()
}

/// 400 studies that stop by themselves: their intervals of 95 % cover the mean of a skewed output in 95 % ± 3 % of
/// them.
#[test]
fn studies_that_stop_by_themselves_cover_the_mean() {
    for half_width in [0.1, 0.05] {
        let hits = covered(HalfWidth::of(half_width), 400);
        println!("half-width {half_width}: {hits} of 400");
        assert!((368..=392).contains(&hits), "{half_width}: {hits}");
    }
}

/// The table of docs/lab/reliability.md: half-widths over an octave of needed samples, after first batches of 32
/// to 1024.
#[test]
#[ignore = "a measurement, of a minute"]
fn coverage_of_studies_that_stop() {
    for first in [32u64, 256, 1024] {
        for part in 0..8 {
            let needed = first as f64 * 2f64.powf(0.125 * f64::from(part) + 0.0625);
            let hits = covered(HalfWidth::of(1.96 / needed.sqrt()).first(first), 2000);
            println!("first {first}, {needed:.0} needed: {:.2} %", hits as f64 / 20.0);
        }
    }
}

#[test]
fn a_study_that_stops_is_the_beginning_of_the_whole_one() {
    let range =
        |_: &Ball, run: lagrange_runtime::Run<'_, Ball, Rk4, FixedStep, 2>| Ok(run.final_state()?.q[0]);
    let statistic = || (Moments, Quantiles::to(0.01));
    let study = |threads| exponential!(7, 1 << 20).threads(threads);
    let bits = |of: &dyn Fn(&mut Vec<u8>)| {
        let mut bytes = vec![];
        of(&mut bytes);
        bytes
    };
    let rule = HalfWidth::of(0.03).first(100);
    let stopped = study(1).reduce_until(range, statistic(), rule).expect("a sound study");
    // (1.96/0.03)² = 4268.
    let samples = stopped.samples;
    assert!([4096, 8192].contains(&samples), "{samples}");
    assert!(stopped.statistic.half_width(0.95) <= 0.03);
    let many = study(3).reduce_until(range, statistic(), rule).expect("a sound study");
    let part = exponential!(7, samples).threads(2).reduce(range, statistic()).expect("a sound study");
    let written = bits(&|bytes| stopped.statistic.write(bytes));
    assert_eq!(bits(&|bytes| many.statistic.write(bytes)), written);
    assert_eq!(bits(&|bytes| part.statistic.write(bytes)), written);
    // In lanes, by the same rule.
    let end = FinalState(|_: &Ball, end: &State<f64, 2>| end.q[0]);
    let lanes = study(2).in_lanes(Fused).observe_until(&end, statistic(), rule).expect("a sound study");
    assert_eq!(bits(&|bytes| lanes.statistic.write(bytes)), written);

    // Interrupted wherever it is.
    let path = std::env::temp_dir().join(format!("lagrange-until-{}", std::process::id()));
    let mut stops = 0;
    loop {
        let rounds = Cell::new(0);
        let study = study(1 + stops % 2).checkpoint(&path, Duration::ZERO).progress(|progress| {
            rounds.set(rounds.get() + 1);
            assert!(rounds.get() < 2 || progress.done >= samples, "stop");
        });
        match catch_unwind(AssertUnwindSafe(|| study.reduce_until(range, statistic(), rule))) {
            Ok(outcome) => {
                let outcome = outcome.expect("a sound study");
                assert_eq!(
                    (bits(&|bytes| outcome.statistic.write(bytes)), outcome.samples),
                    (written, samples)
                );
                break;
            }
            Err(_) => stops += 1,
        }
    }
    assert!(stops > 2, "{stops}");
    let _ = std::fs::remove_file(path);
}

/// A probability of a hundredth: where nothing has happened yet the interval of Wilson is not empty, and the study
/// goes on.
#[test]
fn probabilities_stop_by_the_score_interval() {
    let rare =
        |_: &Ball, run: lagrange_runtime::Run<'_, Ball, Rk4, FixedStep, 2>| Ok(run.final_state()?.q[0] > 4.6);
    let exact = (-4.6f64).exp();
    let covered = (0..400).filter(|&seed| {
        let study = exponential!(seed, 1 << 20).threads(1);
        let outcome = study.reduce_until(rare, Probability, HalfWidth::of(0.005)).expect("a sound study");
        let [low, high] = outcome.statistic.confidence_interval(0.95);
        assert!(outcome.samples >= 512 && 0.5 * (high - low) <= 0.005);
        (low..=high).contains(&exact)
    });
    let covered = covered.count();
    println!("{covered} of 400");
    assert!((368..=392).contains(&covered), "{covered}");
    let shard = exponential!(1, 1000).shard(0, 2).reduce_until(rare, Probability, HalfWidth::of(0.1));
    assert!(matches!(shard, Err(EnsembleError::SequentialShard)));
    let nothing = exponential!(1, 1000).reduce_until(rare, Probability, HalfWidth::of(0.0));
    assert!(matches!(nothing, Err(EnsembleError::Refused(_))));
    // An output that is constant does not stop a study of means.
    let constant =
        exponential!(1, 5000).reduce_until(|_, run| Ok(run.final_state()?.q[1]), Moments, HalfWidth::of(1.0));
    assert_eq!(constant.expect("a sound study").samples, 5000);
}

fn drawn(rng: &mut Generator) -> [f64; 2] {
    core::array::from_fn(|_| StandardNormal.sample(rng))
}

/// The dispersion of a double pendulum over a short time, and its linear model.
macro_rules! pendulum_and_linear {
    ($seed:expr) => {{
        let start = |mut rng: Generator| {
            let [a, b] = drawn(&mut rng);
            State::new(0.0, [0.15 + 0.05 * a, 0.2 + 0.05 * b], [0.0, 0.0])
        };
        let full = Simulation::new(
            move |rng| (DoublePendulum::new(), start(rng)),
            Dop853,
            PiController::tolerance(1e-10),
            3.0,
            FinalState(|_: &DoublePendulum, end: &State<f64, 2>| end.q[1]),
        );
        let linear = Simulation::new(
            move |rng| (Linear::new(), start(rng)),
            Rk4,
            FixedStep::new(0.5),
            3.0,
            FinalState(|_: &Linear, end: &State<f64, 2>| end.q[1]),
        );
        Multifidelity::new(Random::seed($seed), 10_000_000, full.in_lanes(Fused), linear.in_lanes(Fused))
    }};
}

/// A pendulum on a stiff spring, and on a rod.
macro_rules! spring_and_rod {
    ($seed:expr) => {{
        let full = Simulation::new(
            |mut rng: Generator| {
                let [theta, speed] = drawn(&mut rng);
                let start = State::new(0.0, [1.0 + 9.81 / 1e4, 0.5 + 0.1 * theta], [0.0, 0.1 * speed]);
                (Spring::new(1e4), start)
            },
            Dop853,
            PiController::tolerance(1e-9),
            2.0,
            FinalState(|_: &Spring, end: &State<f64, 2>| end.q[1]),
        );
        let rigid = Simulation::new(
            |mut rng: Generator| {
                let [theta, speed] = drawn(&mut rng);
                (Rigid::new(1e4), State::new(0.0, [0.5 + 0.1 * theta], [0.1 * speed]))
            },
            Dop853,
            PiController::tolerance(1e-5),
            2.0,
            FinalState(|_: &Rigid, end: &State<f64, 1>| end.q[0]),
        );
        Multifidelity::new(Random::seed($seed), 10_000_000, full.in_lanes(Fused), rigid.in_lanes(Fused))
    }};
}

/// The place of a piston on an elastic rod, and on a rigid one.
macro_rules! elastic_and_rigid_rod {
    ($seed:expr) => {{
        const PARAMETERS: [f64; 5] = [0.5, 0.3, 1.0, 400.0, 2.0];
        let full = Simulation::new(
            |mut rng: Generator| {
                let ([phase, rate], [inertia, radius, piston, k, c]) = (drawn(&mut rng), PARAMETERS);
                let start = State::new(0.0, [0.5 + 0.1 * phase, 0.0], [2.0 + 0.1 * rate, 0.0]);
                (Crank::new(inertia, radius, piston, k, c), start)
            },
            Dop853,
            PiController::tolerance(1e-9),
            2.0,
            FinalState(|system: &Crank, end: &State<f64, 2>| system.place_at(end)),
        );
        let rigid = Simulation::new(
            |mut rng: Generator| {
                let ([phase, rate], [inertia, radius, piston, k, c]) = (drawn(&mut rng), PARAMETERS);
                let start = State::new(0.0, [0.5 + 0.1 * phase], [2.0 + 0.1 * rate]);
                (RigidRod::new(inertia, radius, piston, k, c), start)
            },
            Dop853,
            PiController::tolerance(1e-5),
            2.0,
            FinalState(|system: &RigidRod, end: &State<f64, 1>| system.place_at(end)),
        );
        Multifidelity::new(Random::seed($seed), 10_000_000, full.in_lanes(Fused), rigid.in_lanes(Fused))
    }};
}

/// Scenes in which a simplified model leaves a tenth of the full runs and a quarter of the cost, pilot included.
#[test]
fn simplified_models_save_nine_of_ten_runs() {
    fn check(name: &str, estimate: &MultifidelityEstimate) {
        let full = (estimate.samples[0] + estimate.pilot.samples) as f64;
        let (runs, cost) = (
            full / estimate.plain_samples(),
            estimate.cost / (estimate.plain_samples() * estimate.pilot.cost[0]),
        );
        println!(
            "{name}: {}; {:?} samples, {runs:.3} of the runs, {cost:.3} of the cost",
            estimate.pilot, estimate.samples
        );
        assert!(estimate.reached && runs <= 0.1 && cost <= 0.25, "{name}: {runs} {cost}");
    }
    check("double pendulum", &pendulum_and_linear!(1).to_half_width(3e-4).expect("a sound study"));
    check("spring pendulum", &spring_and_rod!(2).to_half_width(5e-4).expect("a sound study"));
    check("slider-crank", &elastic_and_rigid_rod!(3).to_half_width(2e-4).expect("a sound study"));
}

/// The same in time: the shares of a plain study of the same interval.
#[test]
#[ignore = "a measurement of time"]
fn simplified_models_save_time() {
    use std::time::Instant;
    macro_rules! shares {
        ($($scene:ident, $half_width:expr;)*) => {$({
            let begun = Instant::now();
            let estimate = $scene!(1).threads(1).to_half_width($half_width).expect("a sound study");
            let taken = begun.elapsed().as_secs_f64();
            let begun = Instant::now();
            let pilot = $scene!(1).threads(1).pilot_samples(4096).pilot().expect("a pilot");
            // A run of the full model, by its share of the work.
            let share = pilot.cost[0] / (pilot.cost[0] + pilot.cost[1]);
            let each = begun.elapsed().as_secs_f64() * share / 4096.0;
            println!(
                "{}: {:.3} of the time of a plain study",
                stringify!($scene),
                taken / (estimate.plain_samples() * each)
            );
        })*};
    }
    shares! {
        pendulum_and_linear, 3e-4;
        spring_and_rod, 5e-4;
        elastic_and_rigid_rod, 2e-4;
    }
}

/// Intervals of 95 % of 400 studies of each scene cover the mean in 95 % ± 3 % of them.
#[test]
#[ignore = "minutes with optimisation: `.ci/full`"]
fn intervals_of_simplified_models_cover_the_mean() {
    macro_rules! coverage {
        ($($scene:ident, $half_width:expr;)*) => {$({
            let exact = $scene!(1 << 40).to_half_width(0.05 * $half_width).expect("a sound study");
            let covered = (0..400).filter(|&seed| {
                let [low, high] =
                    $scene!(seed).to_half_width($half_width).expect("a sound study").confidence_interval(0.95);
                (low..=high).contains(&exact.mean())
            });
            let covered = covered.count();
            println!("{}: {covered} of 400", stringify!($scene));
            assert!((368..=392).contains(&covered), "{covered}");
        })*};
    }
    coverage! {
        pendulum_and_linear, 1e-3;
        spring_and_rod, 2e-3;
        elastic_and_rigid_rod, 1e-3;
    }
}

/// Probabilities, whose models differ in rare samples: a study that took what it has met for all that there is would
/// stop the sooner, the less it has met.
#[test]
fn rare_differences_are_waited_for() {
    for (full, cheap, half_width, exact) in
        [(2.0, 1.9, 0.002, 0.022_750_131_948_179_2), (1.5, 1.45, 0.005, 0.066_807_201_268_858)]
    {
        let indicator = |above: f64| {
            move |mut rng: Generator| {
                let x: f64 = StandardNormal.sample(&mut rng);
                f64::from(u8::from(x > above))
            }
        };
        let (mut covered, mut sum) = (0, 0.0);
        for seed in 0..200 {
            let models = (ClosedForm::new(indicator(full)), ClosedForm::new(indicator(cheap)).cost(0.001));
            let study =
                Multifidelity::new(Random::seed(seed), 1_000_000, models.0, models.1).pilot_samples(512);
            let found = study.to_half_width(half_width).unwrap();
            let [low, high] = found.confidence_interval(0.95);
            covered += u32::from((low..=high).contains(&exact));
            sum += found.mean();
            assert!(found.plain_samples() > 0.0 && found.cost_ratio().is_finite());
        }
        println!("{covered} of 200, mean {}", sum / 200.0);
        assert!(covered >= 180, "{covered}");
        assert!((sum / 200.0 - exact).abs() < 0.2 * half_width, "{}", sum / 200.0);
    }
}

/// A normal number with noise, of variance 1.09, and the number itself at a hundredth of the cost.
macro_rules! noisy {
    ($seed:expr, $noise:expr, $pilot:expr) => {{
        let noise = $noise;
        let full = ClosedForm::new(move |mut rng: Generator| -> f64 {
            let [x, e]: [f64; 2] = core::array::from_fn(|_| StandardNormal.sample(&mut rng));
            x + noise * e
        });
        let cheap =
            ClosedForm::new(|mut rng: Generator| -> f64 { StandardNormal.sample(&mut rng) }).cost(0.01);
        Multifidelity::new(Random::seed($seed), 100_000_000, full, cheap).pilot_samples($pilot)
    }};
}

/// Quantiles of the normal distribution of variance 1 at 0.5, 0.9 and 0.05, and samples of a pilot that sees the models
/// differ.
const NORMAL: [(f64, f64, u64); 3] =
    [(0.5, 0.0, 512), (0.9, 1.2815515655446004, 1024), (0.05, -1.6448536269514729, 2048)];

#[test]
fn intervals_cover_quantiles_and_cost_less() {
    for (p, z, pilot) in NORMAL {
        let (exact, mut covered, mut part) = (z * 1.09f64.sqrt(), [0; 2], 0.0);
        for seed in 0..400 {
            let study = noisy!(seed, 0.3, pilot).threads(1);
            let budget = 1.01 * pilot as f64 + 1000.0;
            let found = [study.quantile_to_half_width(p, 0.08), study.quantile_within_budget(p, budget)];
            for (found, covered) in found.into_iter().zip(&mut covered) {
                let found = found.expect("a sound study");
                let [low, high] = found.confidence_interval(0.95);
                *covered += i32::from((low..=high).contains(&exact));
                assert!(found.reached && low <= found.quantile() && found.quantile() <= high, "{found:?}");
                part += found.samples[0] as f64 / found.plain_samples() / 800.0;
            }
        }
        println!("{p}: {covered:?} of 400, {part:.3} of the full samples");
        assert!(covered.iter().all(|hits| (368..=392).contains(hits)), "{p}: {covered:?}");
        assert!(part < 0.7, "{p}: {part}");
    }
}

/// A cheap model that knows nothing gains nothing, and the quantile is that of the full model alone, by ranks.
#[test]
fn quantiles_without_a_gain_are_those_of_the_full_model() {
    let full = |mut rng: Generator| -> f64 { Exp1.sample(&mut rng) };
    let cheap = |mut rng: Generator| -> f64 {
        let [_, y]: [f64; 2] = core::array::from_fn(|_| Exp1.sample(&mut rng));
        y
    };
    let mut covered = 0;
    for seed in 0..400 {
        let study = Multifidelity::new(
            Random::seed(seed),
            1 << 20,
            ClosedForm::new(full),
            ClosedForm::new(cheap).cost(0.1),
        );
        let found = study.threads(1).quantile_to_half_width(0.75, 0.1).expect("a sound study");
        assert!(found.pilot.gain.is_none() && found.samples[1] == 0);
        let [low, high] = found.confidence_interval(0.95);
        covered += i32::from((low..=high).contains(&4f64.ln()));
    }
    println!("{covered} of 400");
    assert!((368..=392).contains(&covered), "{covered}");
}

#[test]
fn quantiles_are_the_same_by_threads_and_by_models_that_agree() {
    let by = |threads| {
        noisy!(3, 0.3, 512).threads(threads).quantile_to_half_width(0.9, 0.02).expect("a sound study")
    };
    let one = by(1);
    for threads in [2, 5] {
        assert_eq!(by(threads), one, "{threads} threads");
    }
    // Interrupted, too.
    let path = std::env::temp_dir().join(format!("lagrange-quantile-{}", std::process::id()));
    let mut stops = 0;
    let done = loop {
        let rounds = Cell::new(0);
        let study =
            noisy!(3, 0.3, 512).threads(1 + stops % 2).checkpoint(&path, Duration::ZERO).progress(|_| {
                rounds.set(rounds.get() + 1);
                assert!(rounds.get() < 2, "stop");
            });
        match catch_unwind(AssertUnwindSafe(|| study.quantile_to_half_width(0.9, 0.02))) {
            Ok(estimate) => break estimate.expect("a sound study"),
            Err(_) => stops += 1,
        }
    };
    assert!(stops > 1 && done == one, "{stops}");
    // The quantile of 0.8 is another study.
    assert!(noisy!(3, 0.3, 512).checkpoint(&path, Duration::ZERO).quantile_to_half_width(0.8, 0.02).is_err());
    let _ = std::fs::remove_file(&path);
    // Of models that always agree the difference is not known, and there is no gain to be had from it.
    let same = noisy!(4, 0.0, 512).threads(1).quantile_within_budget(0.5, 5000.0).expect("a sound study");
    let [low, high] = same.confidence_interval(0.95);
    assert!(low < 0.0 && 0.0 < high && high - low < 0.2, "{low} {high}");
}

#[test]
fn quantiles_that_make_no_sense_are_refused() {
    let refused = |p: f64, half_width: f64| {
        let error = noisy!(1, 0.3, 512).quantile_to_half_width(p, half_width).expect_err("no study");
        error.to_string()
    };
    for p in [0.0, 1.0, -0.1, 1.5, f64::NAN] {
        assert!(refused(p, 0.1).contains("between 0 and 1"), "{p}: {}", refused(p, 0.1));
    }
    for half_width in [0.0, -1.0, f64::NAN] {
        refused(0.5, half_width);
    }
    assert!(refused(0.999, 0.1).contains(".pilot_samples(8000)"), "{}", refused(0.999, 0.1));
    let few = noisy!(1, 0.3, 512).quantile_within_budget(0.5, 10.0).expect_err("no budget").to_string();
    assert!(few.contains("does not suffice"), "{few}");
    // An end that samples do not bound is infinite, and the half-width not reached.
    let short = Multifidelity::new(
        Random::seed(1),
        1024,
        ClosedForm::new(|mut rng: Generator| -> f64 { Exp1.sample(&mut rng) }),
        ClosedForm::new(|mut rng: Generator| -> f64 { Exp1.sample(&mut rng) }),
    );
    let found = short.pilot_samples(896).quantile_to_half_width(0.99, 0.01).expect("a sound study");
    assert!(!found.reached && found.confidence_interval(0.999)[1] == f64::INFINITY, "{found:?}");
}

/// x, and x with an error, of one draw.
fn two_normals(mut rng: Generator) -> [f64; 2] {
    let [x, e]: [f64; 2] = core::array::from_fn(|_| StandardNormal.sample(&mut rng));
    [x, x + 0.1 * e]
}

/// E[x | x ≤ 1] = −φ(1)/Φ(1) = −0.28760, of samples in which the full model alone has no output; the mean of all is 0
/// where the cheap one alone has none.
#[test]
fn samples_of_one_model_alone_are_no_control_variate() {
    let lost = |is_lost: bool, x: f64, output: f64| if is_lost && x > 1.0 { f64::NAN } else { output };
    for (of_full, of_cheap, exact, median) in
        [(true, false, -0.28760, -0.2027), (false, true, 0.0, 0.0), (true, true, -0.28760, -0.2027)]
    {
        let full = move |rng: Generator| {
            let [x, y] = two_normals(rng);
            lost(of_full, x, y)
        };
        let cheap = move |rng: Generator| {
            let [x, _] = two_normals(rng);
            lost(of_cheap, x, x)
        };
        let cheap = ClosedForm::new(cheap).cost(0.001);
        let study = Multifidelity::new(Random::seed(1), 10_000_000, ClosedForm::new(full), cheap);
        let study = study.threads(1).pilot_samples(1024);
        let found = study.to_half_width(0.01).expect("a study");
        assert!((found.mean() - exact).abs() < 0.02, "{of_full} {of_cheap}: {}", found.mean());
        assert_eq!(found.pilot.gain.is_some(), of_full == of_cheap);
        let found = study.quantile_to_half_width(0.5, 0.02).expect("a study");
        assert!((found.quantile() - median).abs() < 0.04, "{of_full} {of_cheap}: {}", found.quantile());
    }
    // One that comes after the pilot, in a few samples of a thousand.
    let rare = |rng: Generator| {
        let [x, y] = two_normals(rng);
        if x > 2.6 { f64::NAN } else { y }
    };
    let cheap = ClosedForm::new(|rng| two_normals(rng)[0]).cost(0.001);
    let study = Multifidelity::new(Random::seed(3), 10_000_000, ClosedForm::new(rare), cheap).threads(1);
    let found = study.to_half_width(0.01).expect("a study");
    let exact = -0.013583 / 0.995339;
    assert!((found.mean() - exact).abs() < 0.02, "{}", found.mean());
    assert!(found.not_finite > 0);
}

/// Outputs that many samples share, and a gap in which there are none, are no reason to take all samples.
#[test]
fn quantiles_in_atoms_and_beside_gaps_take_few_samples() {
    let of = |output: fn(f64) -> f64, p: f64, half_width: f64| {
        let full = ClosedForm::new(move |rng| output(two_normals(rng)[1]));
        let cheap = ClosedForm::new(move |rng| output(two_normals(rng)[0])).cost(0.01);
        let study = Multifidelity::new(Random::seed(1), 4_000_000, full, cheap).threads(1);
        study.quantile_to_half_width(p, half_width).expect("a study")
    };
    for (output, p, exact) in [
        ((|x| x.clamp(-1.0, 1.0)) as fn(f64) -> f64, 0.95, 1.0),
        (|x| x.round(), 0.5, 0.0),
        (|x| x.round(), 0.95, 2.0),
        (|x| f64::from(u8::from(x > 1.0)), 0.95, 1.0),
    ] {
        let found = of(output, p, 0.05);
        assert!(found.reached && found.quantile().abs() == exact && found.samples[0] < 5000, "{found:?}");
    }
    let modes = |x: f64| x + if x < 0.12566 { -10.0 } else { 10.0 };
    let found = of(modes, 0.5, 0.2);
    assert!(
        found.reached && found.samples[0] < 100_000 && (found.quantile() + 10.0).abs() < 0.5,
        "{found:?}"
    );
}

#[test]
fn the_number_of_samples_bounds_the_ratio() {
    let full = |rng: Generator| {
        let [x, y] = two_normals(rng);
        0.9 * x + 0.19f64.sqrt() * (y - x) * 10.0
    };
    let cheap = ClosedForm::new(|rng| two_normals(rng)[0]).cost(1e-6);
    let study = Multifidelity::new(Random::seed(1), 300_000, ClosedForm::new(full), cheap).threads(1);
    let found = study.to_half_width(0.03).expect("a study");
    assert!(found.reached && found.samples[0] < 3000, "{found:?}");
    let found = study.pilot_samples(1024).quantile_to_half_width(0.5, 0.03).expect("a study");
    assert!(found.reached, "{found:?}");
}

#[test]
fn units_and_bounds_of_a_study() {
    let of = |unit: f64, samples: u64| {
        let full = ClosedForm::new(move |rng| unit * two_normals(rng)[1]);
        let cheap = ClosedForm::new(|rng| two_normals(rng)[0]).cost(0.01);
        Multifidelity::new(Random::seed(1), samples, full, cheap).threads(1)
    };
    let usual = of(1.0, 1_000_000).to_half_width(0.02).expect("a study");
    for unit in [2f64.powi(-460), 2f64.powi(500)] {
        let found = of(unit, 1_000_000).to_half_width(0.02 * unit).expect("a study");
        assert_eq!((found.mean() / unit, found.samples), (usual.mean(), usual.samples));
        assert!(found.reached && (found.cost_ratio() - usual.cost_ratio()).abs() < 1e-12);
    }
    let error = of(1e-200, 1_000_000).to_half_width(1e-202).expect_err("squares of 0");
    assert!(error.to_string().contains("smaller units"), "{error}");
    // One cheap sample beyond the pairs has no variance.
    assert!(of(1.0, 193).to_half_width(1e-3).expect("a study").half_width(0.95).is_finite());
    // (One less than 1e17 is 1e17.)
    for budget in [1e17, 1e18, f64::INFINITY] {
        assert!(!of(1.0, 10_000).within_budget(budget).expect("a study").reached);
    }
    let error = of(1.0, 10_000).pilot_samples(u64::MAX).pilot().expect_err("no room");
    assert!(error.to_string().contains("no room"), "{error}");
    let found = of(1.0, 100_000).quantile_to_half_width(0.5, 0.05).expect("a study");
    assert!(found.confidence_interval(f64::NAN).iter().all(|end| end.is_nan()));
}
