//! A study whose process is killed again and again, at no chosen moments, ends with the bits of one that is left alone.

use lagrange_runtime::ensemble::rand_distr::{Distribution, StandardNormal};
use lagrange_runtime::ensemble::{Ensemble, Histogram, Moments, Quantiles, Random, Record};
use lagrange_runtime::prelude::*;
use std::cell::Cell;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

lagrangian! {
    system Pendulum {
        param l;
        coord theta;
        T = 0.5 * (l * dot(theta)).powi(2);
        V = -9.81 * l * cos(theta);
    }
}

/// The variable by which a process knows that it is the one to be killed, and where its checkpoint is.
const CHECKPOINT: &str = "LAGRANGE_KILLED_CHECKPOINT";
const SAMPLES: u64 = 40_000;

/// The bits of the outcome, and how many samples came from the checkpoint. Each sample takes at least the time `pause`.
fn study(checkpoint: Option<&Path>, pause: Duration) -> (Vec<u8>, u64) {
    let resumed = Cell::new(0);
    let mut study = Ensemble::new(Random::seed(5), SAMPLES, |mut rng| {
        let draw: f64 = StandardNormal.sample(&mut rng);
        // One in forty has no finite start, and fails.
        let theta = if draw > 1.96 { f64::NAN } else { draw };
        (Pendulum::new(0.8), State::new(0.0, [theta], [0.0]))
    })
    .integrate(Rk4, FixedStep::new(0.1), 1.0)
    .threads(2)
    .progress(|progress| resumed.set(progress.resumed));
    if let Some(path) = checkpoint {
        study = study.checkpoint(path, Duration::ZERO);
    }
    let watch = |_: &Pendulum, run: lagrange_runtime::Run<'_, _, _, _, 1>| {
        std::thread::sleep(pause);
        Ok(run.final_state()?.q[0])
    };
    let statistics = (Moments, Histogram::new(-2.0, 2.0, 50), Quantiles::to(0.01));
    let outcome = study.reduce(watch, statistics).expect("a sound study");
    let mut bits = vec![];
    outcome.statistic.write(&mut bits);
    for failed in &outcome.failures.kept {
        failed.index.write(&mut bits);
    }
    outcome.failures.count.write(&mut bits);
    (bits, resumed.get())
}

/// What the killed process does. As a test of its own it has nothing to do.
#[test]
fn to_be_killed() {
    if let Some(checkpoint) = std::env::var_os(CHECKPOINT) {
        study(Some(&PathBuf::from(checkpoint)), Duration::from_millis(1));
    }
}

#[test]
fn a_killed_study_goes_on_to_the_same_bits() {
    let path = std::env::temp_dir().join(format!("lagrange-killed-{}", std::process::id()));
    let program = std::env::current_exe().expect("this test");
    for kill in 1..=8u64 {
        let mut child = Command::new(&program)
            .args(["to_be_killed", "--exact"])
            .env(CHECKPOINT, &path)
            .stdout(Stdio::null())
            .spawn()
            .expect("this test once more");
        std::thread::sleep(Duration::from_millis(29 * kill));
        assert!(child.try_wait().expect("a child").is_none(), "it ended before it was killed");
        child.kill().expect("a child");
        child.wait().expect("a child");
    }
    let (bits, resumed) = study(Some(&path), Duration::ZERO);
    assert!(0 < resumed && resumed < SAMPLES, "{resumed} samples were done before");
    assert_eq!(bits, study(None, Duration::ZERO).0);
    std::fs::remove_file(&path).expect("the checkpoint");
    // What the last one was about to write when it was killed, if anything.
    let _ = std::fs::remove_file(format!("{}.part", path.display()));
}
