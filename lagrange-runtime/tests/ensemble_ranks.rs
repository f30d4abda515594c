//! A study on three ranks of MPI has the bits of one process. Needs `mpirun`; without it this test says that it was
//! skipped.

use lagrange_runtime::ensemble::rand_distr::{Distribution, StandardNormal};
use lagrange_runtime::ensemble::{Collect, Ensemble, LaneStudy, Moments, Quantiles, Random, Record, Source};
use lagrange_runtime::lanes::{FinalState, Fused};
use lagrange_runtime::prelude::*;
use mpi::Threading;
use mpi::traits::Communicator;
use std::path::PathBuf;
use std::process::Command;

lagrangian! {
    system Pendulum {
        param l;
        coord theta;
        T = 0.5 * (l * dot(theta)).powi(2);
        V = -9.81 * l * cos(theta);
    }
}

/// The variable by which a process knows that it is a rank, and where rank 0 is to write what came of it.
const RESULT: &str = "LAGRANGE_RANKS_RESULT";
const SAMPLES: u64 = 1234;

fn draw(mut rng: <Random as Source>::Draw) -> (Pendulum, State<f64, 1>) {
    let draw: f64 = StandardNormal.sample(&mut rng);
    let theta = if draw > 1.96 { f64::NAN } else { draw };
    (Pendulum::new(0.8), State::new(0.0, [theta], [0.0]))
}

fn study<'p, D>(
    ensemble: Ensemble<Random, D>,
) -> LaneStudy<'p, Random, D, Pendulum, Dop853, PiController, Fused, 1>
where
    D: Fn(<Random as Source>::Draw) -> (Pendulum, State<f64, 1>) + Sync,
{
    ensemble.integrate(Dop853, PiController::tolerance(1e-9), 1.0).threads(2).in_lanes(Fused)
}

const STATISTICS: (Moments, Quantiles, Collect) = (Moments, Quantiles::to(0.01), Collect);

fn angle(_: &Pendulum, end: &State<f64, 1>) -> f64 {
    end.q[0]
}

fn bits<T: Record>(outcome: &lagrange_runtime::ensemble::Outcome<T, f64, 1>) -> Vec<u8> {
    let mut bits = vec![];
    outcome.statistic.write(&mut bits);
    outcome.samples.write(&mut bits);
    outcome.failures.count.write(&mut bits);
    for failed in &outcome.failures.kept {
        failed.index.write(&mut bits);
        failed.start.write(&mut bits);
    }
    bits
}

/// What a rank does. As a test of its own it has nothing to do.
#[test]
fn as_a_rank() {
    let Some(result) = std::env::var_os(RESULT).map(PathBuf::from) else { return };
    let (universe, _) = mpi::initialize_with_threading(Threading::Funneled).expect("MPI");
    let world = universe.world();
    assert_eq!(world.size(), 3);
    let study = study(Ensemble::new(Random::seed(5), SAMPLES, draw));
    let outcome = study.reduce_on_ranks(&world, &FinalState(angle), STATISTICS).expect("a sound study");
    assert_eq!(outcome.is_some(), world.rank() == 0);
    if let Some(outcome) = outcome {
        std::fs::write(result, bits(&outcome)).expect("a file");
    }
}

#[test]
fn three_ranks_have_the_bits_of_one_process() {
    let result = std::env::temp_dir().join(format!("lagrange-ranks-{}", std::process::id()));
    let program = std::env::current_exe().expect("this test");
    let ranks = Command::new("mpirun")
        .args(["--allow-run-as-root", "--oversubscribe", "-n", "3"])
        .arg(program)
        .args(["as_a_rank", "--exact"])
        .env(RESULT, &result)
        .output();
    let output = match ranks {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
            eprintln!("SKIPPED: there is no `mpirun`, so ranks were not tested (Debian: openmpi-bin)");
            return;
        }
        ranks => ranks.expect("mpirun"),
    };
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let found = std::fs::read(&result).expect("the result of rank 0");
    std::fs::remove_file(result).expect("removed");
    let alone = study(Ensemble::new(Random::seed(5), SAMPLES, draw));
    let outcome = alone.observe(&FinalState(angle), STATISTICS).expect("a sound study");
    assert!(outcome.failures.count > 10);
    assert_eq!(found, bits(&outcome));
}
