use super::rand_distr::{Distribution, Uniform};
use super::*;
use crate::method::Step;
use crate::prelude::*;
use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

lagrangian! {
    system Pendulum {
        param l;
        coord theta;
        T = 0.5 * (l * dot(theta)).powi(2);
        V = -9.81 * l * cos(theta);
    }
}

/// Starts from −1 to 1 rad of pendulums of 0.5 to 1 m. Those above 0.9 rad have no finite velocity, and fail.
fn uncertain(
    n: u64,
    seed: u64,
) -> Ensemble<Random, impl Fn(rand_chacha::ChaCha8Rng) -> (Pendulum, State<f64, 1>)> {
    let angle = Uniform::new(-1.0, 1.0).expect("finite ends");
    Ensemble::new(Random::seed(seed), n, move |mut rng| {
        let theta: f64 = angle.sample(&mut rng);
        let l = 0.75 + 0.25 * angle.sample(&mut rng);
        let velocity = if theta > 0.9 { f64::NAN } else { 0.0 };
        (Pendulum::new(l), State::new(0.0, [theta], [velocity]))
    })
}

/// The last angle of a run, of which the statistics below make everything there is.
fn last(_: &Pendulum, run: Run<'_, Pendulum, Rk4, FixedStep, 1>) -> Result<f64, Lost<f64, 1>> {
    Ok(run.final_state()?.q[0])
}

type Everything = (Moments, Extrema, Histogram, Quantiles, Of<fn(&f64) -> [f64; 2], Covariance<2>>, Collect);

fn everything() -> Everything {
    fn pair(x: &f64) -> [f64; 2] {
        [*x, x * x]
    }
    let covariance = of(pair as fn(&f64) -> [f64; 2], Covariance::<2>);
    (Moments, Extrema, Histogram::new(-1.0, 1.0, 20), Quantiles::to(0.01), covariance, Collect)
}

/// All bits of an outcome.
fn bits<T: Record>(outcome: &Outcome<T, f64, 1>) -> Vec<u8> {
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

/// A file of its own for each test, removed at the end.
struct Scratch(PathBuf);

impl Scratch {
    fn new(name: &str) -> Self {
        Scratch(std::env::temp_dir().join(format!("lagrange-ensemble-{name}-{}", std::process::id())))
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.0);
    }
}

const STEP: f64 = 0.05;
const N: u64 = 3000;

#[test]
fn threads_do_not_change_a_bit() {
    let by = |threads| {
        let study = uncertain(N, 1).integrate(Rk4, FixedStep::new(STEP), 1.0).threads(threads);
        bits(&study.reduce(last, everything()).expect("a sound study"))
    };
    let one = by(1);
    for threads in [2, 3, 8] {
        assert_eq!(by(threads), one, "{threads} threads");
    }
}

/// The tree, written down once more: a loop over leaves, and halves that are the largest powers of two.
#[test]
fn the_answer_is_that_of_the_policy() {
    let study = uncertain(N, 1).integrate(Rk4, FixedStep::new(STEP), 1.0);
    let found = study.reduce(last, Moments).expect("a sound study").statistic;
    let leaf = |leaf: u64| {
        let mut state = Moments.empty();
        for index in leaf * LEAF..((leaf + 1) * LEAF).min(N) {
            if let Ok(end) = study.replay(index).expect("a sample").run().final_state() {
                Moments.add(&mut state, index, &end.q[0]);
            }
        }
        state
    };
    fn half(range: core::ops::Range<u64>, leaf: &dyn Fn(u64) -> Moment) -> Moment {
        let length = range.end - range.start;
        if length == 1 {
            return leaf(range.start);
        }
        let middle = range.start + (1 << (length - 1).ilog2());
        let mut earlier = half(range.start..middle, leaf);
        Moments.merge(&mut earlier, half(middle..range.end, leaf));
        earlier
    }
    assert_eq!(half(0..N.div_ceil(LEAF), &leaf), found);
}

#[test]
fn statistics_are_those_of_the_outputs() {
    let study = uncertain(N, 2).integrate(Rk4, FixedStep::new(STEP), 1.0);
    let outcome = study.reduce(last, (Moments, Extrema, Collect)).expect("a sound study");
    let (moment, extremes, collected) = outcome.statistic;
    let outputs: Vec<f64> = collected.rows.iter().map(|row| row.1).collect();
    let mean = outputs.iter().sum::<f64>() / outputs.len() as f64;
    let variance = outputs.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (outputs.len() - 1) as f64;
    assert!((moment.mean() - mean).abs() < 1e-14);
    assert!((moment.variance() / variance - 1.0).abs() < 1e-13);
    assert_eq!(extremes.least.map(|x| x.value), outputs.iter().copied().reduce(f64::min));
    assert_eq!(outputs.len() as u64 + outcome.failures.count, N);
    assert!(collected.rows.is_sorted_by_key(|row| row.0));
}

#[test]
fn failed_samples_are_counted_kept_and_replayed() {
    let study = uncertain(N, 3).integrate(Rk4, FixedStep::new(STEP), 1.0).keep_failures(5);
    let outcome = study.reduce(last, Moments).expect("a sound study");
    let bad: Vec<u64> =
        (0..N).filter(|&index| study.replay(index).expect("a sample").start.q[0] > 0.9).collect();
    assert!(bad.len() > 100);
    assert_eq!(outcome.failures.count, bad.len() as u64);
    assert_eq!(outcome.failures.kept.iter().map(|failed| failed.index).collect::<Vec<_>>(), bad[..5]);
    for failed in &outcome.failures.kept {
        assert!(matches!(failed.failure, Failure::StateNotFinite { .. }));
        let again = study.replay(failed.index).expect("a sample");
        assert_eq!(again.start.q, failed.start.q);
        assert!(
            matches!(again.run().final_state(), Err(error) if matches!(error.failure, Failure::StateNotFinite { .. }))
        );
    }
    assert!(matches!(study.replay(N), Err(EnsembleError::NoSuchSample { index: N, samples: N })));
}

/// A study that is stopped at some rounds and goes on has the bits of one that is not.
#[test]
fn interrupted_studies_go_on_to_the_same_bits() {
    let scratch = Scratch::new("interrupted");
    let whole = uncertain(N, 4).integrate(Rk4, FixedStep::new(STEP), 1.0).keep_failures(20);
    let whole = bits(&whole.reduce(last, everything()).expect("a sound study"));
    let (mut stops, done) = (0, Cell::new(0));
    loop {
        let (rounds, before) = (Cell::new(0), done.get());
        let study = uncertain(N, 4)
            .integrate(Rk4, FixedStep::new(STEP), 1.0)
            .keep_failures(20)
            .threads(1 + stops % 3)
            .checkpoint(&scratch.0, Duration::ZERO)
            .progress(|progress| {
                assert_eq!(progress.resumed, before);
                done.set(progress.done);
                rounds.set(rounds.get() + 1);
                assert!(rounds.get() < 2 || progress.done == N, "stop");
            });
        match catch_unwind(AssertUnwindSafe(|| study.reduce(last, everything()))) {
            Ok(outcome) => {
                assert_eq!(bits(&outcome.expect("a sound study")), whole);
                break;
            }
            Err(_) => stops += 1,
        }
        // Not stopped by something else: it came further.
        assert!(done.get() > before);
    }
    assert!(stops > 5);
    // What is complete is not computed again.
    let runs = std::sync::atomic::AtomicU64::new(0);
    let again = uncertain(N, 4)
        .integrate(Rk4, FixedStep::new(STEP), 1.0)
        .keep_failures(0)
        .checkpoint(scratch.0.with_extension("other"), Duration::MAX);
    let count = |system: &Pendulum, run: Run<'_, Pendulum, Rk4, FixedStep, 1>| {
        runs.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
        last(system, run)
    };
    let first = again.reduce(count, Moments).expect("a sound study");
    assert_eq!(runs.load(std::sync::atomic::Ordering::Relaxed), N);
    assert_eq!(bits(&again.reduce(count, Moments).expect("a sound study")), bits(&first));
    assert_eq!(runs.load(std::sync::atomic::Ordering::Relaxed), N);
    let _ = std::fs::remove_file(scratch.0.with_extension("other"));
}

fn checkpointed(path: &Path, n: u64, seed: u64, step: f64) -> Result<Outcome<Moment, f64, 1>, EnsembleError> {
    uncertain(n, seed)
        .integrate(Rk4, FixedStep::new(step), 1.0)
        .checkpoint(path, Duration::ZERO)
        .reduce(last, Moments)
}

#[test]
fn checkpoints_of_other_studies_are_refused_with_the_reason() {
    let scratch = Scratch::new("other");
    checkpointed(&scratch.0, 100, 5, STEP).expect("a sound study");
    let refused = |result: Result<Outcome<Moment, f64, 1>, EnsembleError>, word: &str| match result {
        Err(error @ EnsembleError::OtherStudy { .. }) => assert!(error.to_string().contains(word), "{error}"),
        other => panic!("{other:?}"),
    };
    refused(checkpointed(&scratch.0, 100, 6, STEP), "seed 6");
    refused(checkpointed(&scratch.0, 200, 5, STEP), "samples: 200");
    refused(checkpointed(&scratch.0, 100, 5, 0.5 * STEP), "0.025");
    let study =
        || uncertain(100, 5).integrate(Rk4, FixedStep::new(STEP), 1.0).checkpoint(&scratch.0, Duration::ZERO);
    refused(study().named("second").reduce(last, Moments), "name: second");
    let system = Ensemble::new(Random::seed(5), 100, |rng| {
        let (mut pendulum, start) = (uncertain(1, 5).draw)(rng);
        pendulum.l *= 1.001;
        (pendulum, start)
    });
    let system = system.integrate(Rk4, FixedStep::new(STEP), 1.0).checkpoint(&scratch.0, Duration::ZERO);
    refused(system.reduce(last, Moments), "accelerations");
    assert!(matches!(study().reduce(last, Extrema), Err(EnsembleError::OtherStudy { .. })));
    assert!(study().reduce(last, Moments).is_ok());
}

#[test]
fn a_damaged_checkpoint_is_refused_wherever_the_damage_is() {
    let scratch = Scratch::new("damaged");
    checkpointed(&scratch.0, 100, 5, STEP).expect("a sound study");
    let good = std::fs::read(&scratch.0).expect("a checkpoint");
    let is_corrupt = |bytes: &[u8]| {
        std::fs::write(&scratch.0, bytes).expect("written");
        let corrupt = matches!(checkpointed(&scratch.0, 100, 5, STEP), Err(EnsembleError::Corrupt { .. }));
        corrupt && std::fs::read(&scratch.0).expect("still there") == bytes
    };
    for place in (0..good.len()).step_by(7) {
        let mut bad = good.clone();
        bad[place] ^= 0x10;
        assert!(is_corrupt(&bad), "byte {place}");
        assert!(is_corrupt(&good[..place]), "cut at {place}");
    }
    assert!(is_corrupt(&[good.as_slice(), &[0]].concat()));
    assert!(!is_corrupt(&good));
}

#[test]
fn a_checkpoint_that_cannot_be_written_is_an_error_before_any_sample() {
    let nowhere = std::env::temp_dir().join("lagrange-no-such-folder").join("checkpoint");
    let study = uncertain(100, 5)
        .integrate(Rk4, FixedStep::new(STEP), 1.0)
        .checkpoint(&nowhere, Duration::MAX)
        .progress(|_| panic!("a round was made"));
    let error = study.reduce(last, Moments).expect_err("nowhere to write");
    assert!(matches!(&error, EnsembleError::NotWritten { path, .. } if *path == nowhere));
    assert!(error.to_string().contains("lagrange-no-such-folder"));
}

/// The disk is full, as it were, in the middle of a study: a folder stands where the next checkpoint is to be written.
#[test]
fn a_checkpoint_that_can_no_longer_be_written_ends_the_study_and_stays() {
    let scratch = Scratch::new("full");
    let part = PathBuf::from(format!("{}.part", scratch.0.display()));
    let study = uncertain(N, 6)
        .integrate(Rk4, FixedStep::new(STEP), 1.0)
        .threads(1)
        .checkpoint(&scratch.0, Duration::ZERO)
        .progress(|_| std::fs::create_dir(&part).expect("the first round"));
    assert!(matches!(study.reduce(last, Moments), Err(EnsembleError::NotWritten { .. })));
    std::fs::remove_dir(&part).expect("a folder");
    let resumed = Cell::new(0);
    let study = uncertain(N, 6)
        .integrate(Rk4, FixedStep::new(STEP), 1.0)
        .checkpoint(&scratch.0, Duration::ZERO)
        .progress(|progress| resumed.set(progress.resumed));
    let outcome = study.reduce(last, Moments).expect("room again");
    assert_eq!(resumed.get(), LEAF);
    let whole = uncertain(N, 6).integrate(Rk4, FixedStep::new(STEP), 1.0).reduce(last, Moments);
    assert_eq!(bits(&outcome), bits(&whole.expect("a sound study")));
}

#[test]
fn studies_that_make_no_sense_are_errors() {
    let none = uncertain(0, 1).integrate(Rk4, FixedStep::new(STEP), 1.0);
    assert!(matches!(none.reduce(last, Moments), Err(EnsembleError::NoSamples)));
    assert!(matches!(none.replay(0), Err(EnsembleError::NoSamples)));
    let some = uncertain(10, 1).integrate(Rk4, FixedStep::new(STEP), 1.0);
    let statistic = some.reduce(last, Histogram::new(0.0, f64::NAN, 3));
    assert!(matches!(statistic, Err(EnsembleError::Statistic(_))));
    let table = Ensemble::new(Table::new([0.1, 0.2]), 3, |theta| {
        (Pendulum::new(1.0), State::new(0.0, [theta], [0.0]))
    })
    .integrate(Rk4, FixedStep::new(STEP), 1.0);
    let table = table.reduce(last, Moments);
    assert!(matches!(table, Err(EnsembleError::TooFewRows { rows: 2, samples: 3 })));
    // An end that is not a time makes every sample fail, and is told by each.
    let outcome = uncertain(10, 1).integrate(Rk4, FixedStep::new(STEP), f64::NAN).reduce(last, Moments);
    let failures = outcome.expect("failures are values").failures;
    assert_eq!(failures.count, 10);
    assert!(matches!(failures.kept[0].failure, Failure::BadEnd { .. }));
}

/// The mean angle by a Sobol sequence is far nearer to that of many more points than random samples would be.
#[test]
fn sobol_points_and_tables_are_sources_too() {
    let by_sobol = |n, seed| {
        Ensemble::new(Sobol::<2>::seed(seed), n, |[u, v]| {
            (Pendulum::new(0.5 + 0.5 * v), State::new(0.0, [0.5 * u], [0.0]))
        })
        .integrate(Rk4, FixedStep::new(STEP), 1.0)
        .reduce(last, Moments)
        .expect("a sound study")
        .statistic
    };
    let (coarse, fine) = (by_sobol(256, 1), by_sobol(16384, 2));
    let random = coarse.standard_deviation() / 16.0;
    assert!((coarse.mean() - fine.mean()).abs() < 0.1 * random);

    let rows: Vec<[f64; 2]> = (0..256).map(|index| Sobol::<2>::seed(1).draw(index)).collect();
    let table = Ensemble::new(Table::new(rows), 256, |[u, v]: [f64; 2]| {
        (Pendulum::new(0.5 + 0.5 * v), State::new(0.0, [0.5 * u], [0.0]))
    });
    let table = table.integrate(Rk4, FixedStep::new(STEP), 1.0).reduce(last, Moments);
    assert_eq!(table.expect("a sound study").statistic, coarse);
}

#[test]
fn files_hold_the_same_numbers() {
    let folder = std::env::temp_dir().join(format!("lagrange-ensemble-files-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    let study = uncertain(100, 7).integrate(Rk4, FixedStep::new(STEP), 1.0);
    let watch = |_: &Pendulum, run: Run<'_, Pendulum, Rk4, FixedStep, 1>| {
        let end = run.final_state()?;
        Ok((end, (end.q[0] > 0.0).then_some(end.q[0])))
    };
    let collected = study.reduce(watch, Collect).expect("a sound study").statistic;
    let (csv, npy) = (folder.join("outputs.csv"), folder.join("outputs.npy"));
    collected.write_csv(&csv, &["t", "theta", "theta_dot", "right, if so"]).expect("written");
    let text = std::fs::read_to_string(&csv).expect("there");
    assert_eq!(text.lines().next(), Some("index,t,theta,theta_dot,\"right, if so\""));
    for (line, (index, (end, right))) in text.lines().skip(1).zip(&collected.rows) {
        let fields: Vec<&str> = line.split(',').collect();
        let numbers: Vec<Option<f64>> = fields.iter().map(|field| field.parse().ok()).collect();
        assert_eq!(numbers, [Some(*index as f64), Some(end.t), Some(end.q[0]), Some(end.qd[0]), *right]);
    }
    assert_eq!(text.lines().count(), 1 + collected.rows.len());
    let wrong = collected.write_csv(&csv, &["t"]);
    assert!(matches!(wrong, Err(EnsembleError::Columns { found: 4, columns: 1 })));

    collected.write_npy(&npy).expect("written");
    let bytes = std::fs::read(&npy).expect("there");
    assert!(bytes.starts_with(b"\x93NUMPY\x01\x00"));
    let data = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    let rows = collected.rows.len();
    let header = std::str::from_utf8(&bytes[10..data]).expect("text");
    assert!(data % 64 == 0 && header.ends_with('\n'));
    assert!(header.contains(&format!("'shape': ({rows}, 5)")));
    assert_eq!(bytes.len(), data + 8 * 5 * rows);
    let second = &bytes[data + 8 * (2 * rows + 1)..];
    assert_eq!(f64::read(&mut &second[..]), Some(collected.rows[1].1.0.q[0]));
    std::fs::remove_dir_all(folder).expect("removed");
}

lagrangian! {
    system Falling {
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = -1 / x;
    }
}

/// Half of the particles fall into the centre before the end. What watches them may not hide it.
#[test]
fn failures_that_are_swallowed_count() {
    let fall = |[x]: [f64; 1]| (Falling::new(), State::new(0.0, [x], [0.0]));
    let table = Table::new((1..=10).map(|k| [f64::from(k)]));
    let study = Ensemble::new(table, 10, fall).integrate(Dop853, PiController::tolerance(1e-9), 10.0);
    // A fall from x takes π √(x³/8).
    let lost = (1..=10).filter(|k| core::f64::consts::PI * (f64::from(k * k * k) / 8.0).sqrt() < 10.0).count()
        as u64;
    let last = |step: Step<Falling, Dop853, 1>| step.to.q[0];
    let flattened = study.reduce(|_, run| Ok(run.flatten().last().map_or(0.0, last)), Moments).unwrap();
    assert_eq!([flattened.statistic.count(), flattened.failures.count], [10 - lost, lost]);
    let honest = study.reduce(|_, run| Ok(run.final_state()?.q[0]), Moments).unwrap();
    assert_eq!([honest.statistic.count(), honest.failures.count], [10 - lost, lost]);
    assert_eq!(honest.failures.kept.len(), flattened.failures.kept.len());
    for (one, other) in honest.failures.kept.iter().zip(&flattened.failures.kept) {
        assert_eq!((one.index, one.failure, one.last), (other.index, other.failure, other.last));
    }
    // Failures of a search for events count too.
    let event = |_: &Falling, run: Run<'_, Falling, Dop853, PiController, 1>| {
        Ok(run.events(Event::falling(|_| f64::NAN)).filter_map(Result::ok).count() as f64)
    };
    let events = study.reduce(event, Moments).unwrap();
    assert_eq!([events.statistic.count(), events.failures.count], [0, 10]);
    let outcome = |_: &Falling, run: Run<'_, Falling, Dop853, PiController, 1>| {
        Ok(run.failure_as_outcome().final_state().map_or_else(|failed| failed.last.t, |end| end.t))
    };
    let outcomes = study.reduce(outcome, Moments).unwrap();
    assert_eq!([outcomes.statistic.count(), outcomes.failures.count], [10, 0]);
}
