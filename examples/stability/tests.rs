//! The steps at which methods blow up, theory from their coefficients against the steps that they make; and what every
//! method makes of hard scenes.

use crate::limits;
use crate::scenes::{self, METHODS, Outcome};
use lagrange_runtime::Failure;

#[test]
fn limits_of_theory_are_met_within_one_per_cent() {
    for limit in limits::limits() {
        assert!(
            limit.agrees(),
            "{} on the {} oscillator: {:?}, should be {:?}",
            limit.method,
            limit.axis,
            limit.measured,
            limit.theory
        );
    }
}

/// Steps of one size promise nothing where they are too long. All others are right, or say what stopped them.
#[test]
fn every_method_is_right_or_says_what_stopped_it_in_every_scene() {
    let rows = scenes::rows(true);
    assert!(rows.len() >= 23);
    for row in &rows {
        let mut right = 0;
        for (method, outcome) in &row.cells {
            let told = format!("{method} in \"{}\", {outcome:?}", row.name);
            assert!(METHODS.contains(method), "{told}");
            let adaptive = !method.ends_with(", h");
            match outcome {
                Outcome::Correct(error) => {
                    right += 1;
                    assert!(*error <= row.bound, "{told}");
                }
                Outcome::StepTooLong(_) => assert!(!adaptive, "{told}"),
                Outcome::SilentlyWrong(_) => panic!("{told}"),
                Outcome::Failed { failure, late } => {
                    assert!((row.expected)(failure), "{told}");
                    // An adaptive run that meets an obstacle has shortened its step before it gives up.
                    let blunt = matches!(failure, Failure::NonFinite { .. } | Failure::NotConverged { .. });
                    assert!(!(adaptive && blunt), "{told}");
                    // The end of the solution is met to the digit, or to some steps.
                    let most = if adaptive { 1e-8 } else { 0.02 };
                    assert!(late.is_none_or(|late| late < most), "{told}");
                    assert!(failure.to_string().contains("; "), "{told}");
                }
            }
        }
        assert_eq!(right > 0, !row.singular, "{}", row.name);
    }
}

/// Conserved quantities alone would not show that a trajectory is right.
#[test]
fn scenes_with_independent_digits_are_met_by_every_adaptive_method() {
    let rows = scenes::rows(true);
    let digits: Vec<_> = rows.iter().filter(|row| row.truth == scenes::DIGITS).collect();
    assert_eq!(digits.len(), 3);
    for row in digits {
        for (method, outcome) in row.cells.iter().filter(|(method, _)| !method.ends_with(", h")) {
            assert!(matches!(outcome, Outcome::Correct(error) if *error < 1e-6), "{method} {outcome:?}");
        }
    }
}

/// At the pole φ̇ and ψ̇ grow to 1e12, and their sum, which is the spin, is rounded to 1e-4: methods that go there
/// instead of stepping over it keep what tolerances ask of φ̇ and ψ̇, and would lose the spin. One tolerance may show
/// by chance what another does not, and so may a spin that is a sum of few powers of 2. (Counts by method:
/// `cargo test --release --example stability pole -- --nocapture`.)
#[test]
fn no_adaptive_method_is_silently_wrong_at_the_pole() {
    // Unoptimised each of them takes half a second.
    let most = if cfg!(debug_assertions) { 20 } else { 200 };
    let tolerances = (0..most).map(|k| 1e-9 * (1.0 + f64::from(k) / f64::from(most)));
    let all: Vec<_> = tolerances.map(scenes::through_the_pole).collect();
    let mut cancelled = 0;
    for (i, (method, _)) in all[0].iter().enumerate().filter(|(_, (method, _))| !method.ends_with(", h")) {
        let count = |is: fn(&Outcome) -> bool| all.iter().filter(|cells| is(&cells[i].1)).count();
        let right = count(|o| matches!(o, Outcome::Correct(_)));
        let failed = count(|o| matches!(o, Outcome::Failed { .. }));
        let wrong = count(|o| matches!(o, Outcome::SilentlyWrong(_)));
        println!("{method}: right {right}, failed {failed}, wrong {wrong}");
        assert_eq!((wrong, right + failed), (0, all.len()), "{method}");
        let cancels =
            |o: &Outcome| matches!(o, Outcome::Failed { failure: Failure::Cancellation { .. }, .. });
        cancelled += count(cancels);
    }
    assert!(cancelled > all.len());
}

/// The scenes whose names begin so, swept: what every run came to is counted, and none was wrong with success, or
/// failed in a way that its scene does not declare.
fn nothing_is_silent(scene: &str, runs: u32) {
    let (mut silent, mut undeclared) = (vec![], vec![]);
    let sweep = scenes::sweep(scene, runs);
    assert!(!sweep.is_empty());
    for ((scene, method), counts) in sweep {
        let failed: u32 = counts.failed.values().sum();
        let all = counts.right + failed + counts.silent.len() as u32;
        assert_eq!(all, runs, "{scene}, {method}");
        println!(
            "{scene}, {method}: right {}, failed {:?}, silent {}",
            counts.right,
            counts.failed,
            counts.silent.len()
        );
        let told = |run: String| format!("{scene}, {method}, {run}");
        silent.extend(counts.silent.into_iter().map(told));
        undeclared.extend(counts.undeclared.into_iter().map(told));
    }
    let complaints = [silent, undeclared].concat();
    assert!(complaints.is_empty(), "{}\n{} in all", complaints.join("\n"), complaints.len());
}

/// The constraints are dependent where the bars lie in one line.
#[test]
fn the_parallelogram_is_right_or_names_its_constraints() {
    nothing_is_silent("parallelogram", if cfg!(debug_assertions) { 8 } else { 200 });
}

/// Redundant constraints and dead centres. Three and four cranks are in one line at times.
#[cfg(not(debug_assertions))]
#[test]
fn linkages_are_right_or_name_their_constraints() {
    for scene in ["linkage", "slider-crank", "Bennett", "Sarrus", "scissors"] {
        nothing_is_silent(scene, 20);
    }
}

/// Constraints on velocities, on motions that keep their lean.
#[test]
fn rolling_is_right() {
    let runs = if cfg!(debug_assertions) { 8 } else { 200 };
    nothing_is_silent("disk", runs);
    nothing_is_silent("coin", runs);
}

/// 200 tolerances and 50 starts of each scene, or of those whose names begin with `LAGRANGE_SCENE`.
#[test]
#[ignore = "takes an hour: cargo test --release --example stability -- --ignored --nocapture sweep"]
fn sweep_of_all_scenes() {
    nothing_is_silent(&std::env::var("LAGRANGE_SCENE").unwrap_or_default(), 200);
}
