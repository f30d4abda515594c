//! A disk that has no room left: a clear error, and what was there before is intact. A limit on the size of files
//! stands for the full disk (`ulimit -f`); to the program it is the same, a write that fails in the middle of a file.

#![cfg(unix)]

use lagrange_runtime::ensemble::{Collect, Ensemble, EnsembleError, Outcome, Record, Sobol};
use lagrange_runtime::prelude::*;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::time::Duration;

lagrangian! {
    system Pendulum {
        param l;
        coord theta;
        T = 0.5 * (l * dot(theta)).powi(2);
        V = -9.81 * l * cos(theta);
    }
}

/// The variable by which a process knows that its files are limited, and where they are.
const PATH: &str = "LAGRANGE_FULL_PATH";
const SAMPLES: u64 = 20_000;

/// All outputs are kept, so that checkpoints grow to 16 bytes a sample.
fn study(
    checkpoint: Option<&Path>,
) -> (Result<Outcome<lagrange_runtime::ensemble::Collected<f64>, f64, 1>, EnsembleError>, u64) {
    let resumed = std::cell::Cell::new(0);
    let mut study =
        Ensemble::new(Sobol::<1>::seed(3), SAMPLES, |[u]| (Pendulum::new(0.8), State::new(0.0, [u], [0.0])))
            .integrate(Rk4, FixedStep::new(0.1), 1.0)
            .threads(2)
            .progress(|progress| resumed.set(progress.resumed));
    if let Some(path) = checkpoint {
        study = study.checkpoint(path, Duration::ZERO);
    }
    let outcome = study.reduce(|_, run| Ok(run.final_state()?.q[0]), Collect);
    drop(study);
    (outcome, resumed.get())
}

/// Runs a test of this file by itself, its files limited to `blocks` of 512 bytes.
fn limited(test: &str, path: &Path, blocks: u32) -> Output {
    let program = std::env::current_exe().expect("this test");
    // Beyond the limit a process is killed, unless it ignores the signal; then its writes fail.
    Command::new("sh")
        .args(["-c", &format!("trap '' XFSZ; ulimit -f {blocks}; exec \"$0\" {test} --exact --nocapture")])
        .arg(program)
        .env(PATH, path)
        .output()
        .expect("a shell")
}

fn scratch(name: &str) -> PathBuf {
    std::env::temp_dir().join(format!("lagrange-full-{name}-{}", std::process::id()))
}

/// What the limited process does. As a test of its own it has nothing to do.
#[test]
fn checkpoints_without_room() {
    let Some(path) = std::env::var_os(PATH).map(PathBuf::from) else { return };
    let error = study(Some(&path)).0.expect_err("there is no room for all outputs");
    assert!(matches!(error, EnsembleError::NotWritten { .. }), "{error}");
    eprintln!("{error}");
}

#[test]
fn a_full_disk_leaves_the_last_checkpoint() {
    let path = scratch("checkpoint");
    let output = limited("checkpoints_without_room", &path, 200);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    assert!(
        said.contains("could not be written") && said.contains("what was there before is intact"),
        "{said}"
    );
    assert!(said.contains("File too large") || said.contains("No space left"), "{said}");
    let mut beside = path.clone().into_os_string();
    beside.push(".part");
    assert!(!PathBuf::from(beside).exists(), "half a file was left");
    // With room again, it goes on where it was.
    let (outcome, resumed) = study(Some(&path));
    std::fs::remove_file(path).expect("removed");
    assert!(0 < resumed && resumed < SAMPLES, "{resumed}");
    let (mut found, mut expected) = (vec![], vec![]);
    outcome.expect("room").statistic.write(&mut found);
    study(None).0.expect("a sound study").statistic.write(&mut expected);
    assert_eq!(found, expected);
}

#[cfg(feature = "parquet")]
mod parquet {
    use super::*;
    use lagrange_runtime::ensemble::{Moments, Parquet};

    fn write(path: &Path) -> Result<(), EnsembleError> {
        let mut file = Parquet::create(path, &["theta"])?;
        Ensemble::new(Sobol::<1>::seed(3), 200_000, |[u]| (Pendulum::new(0.8), State::new(0.0, [u], [0.0])))
            .integrate(Rk4, FixedStep::new(0.5), 1.0)
            .stream(|_, run| Ok(run.final_state()?.q[0]), Moments, |index, theta| file.row(index, theta))?;
        file.finish()
    }

    /// What the limited process does. As a test of its own it has nothing to do.
    #[test]
    fn without_room() {
        let Some(path) = std::env::var_os(PATH).map(PathBuf::from) else { return };
        let error = write(&path).expect_err("there is no room");
        eprintln!("{error}");
    }

    #[test]
    fn a_full_disk_leaves_the_last_file() {
        let path = scratch("parquet");
        std::fs::write(&path, b"before").expect("room");
        let output = limited("parquet::without_room", &path, 1000);
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{said}");
        assert!(said.contains("could not be written"), "{said}");
        assert_eq!(std::fs::read(&path).expect("there"), b"before");
        let mut beside = path.clone().into_os_string();
        beside.push(".part");
        assert!(!PathBuf::from(beside).exists(), "half a file was left");
        write(&path).expect("room");
        assert!(std::fs::read(&path).expect("there").starts_with(b"PAR1"));
        std::fs::remove_file(path).expect("removed");
    }

    #[test]
    fn what_cannot_be_written_is_said_at_once() {
        let error = Parquet::create("/no/such/folder/file.parquet", &["x"]).expect_err("no folder");
        assert!(error.to_string().contains("/no/such/folder/file.parquet could not be written"), "{error}");
        let error = Parquet::create(scratch("twice"), &["x", "y", "x"]).expect_err("two columns of one name");
        assert!(error.to_string().contains("two columns are called `x`"), "{error}");
    }
}
