//! Claims: order, symplecticity where M depends on q, symmetry, energy to rounding, failures.

use super::*;
use crate::controller::FixedStep;
use crate::integrate::integrate;
use crate::method::variational::VariationalMidpoint;
use crate::scalar::Dual;
use crate::system::Lagrangian;
use crate::testing::bank::*;
use crate::testing::emitted::Repelled;
use crate::testing::{dense_order_of, distance, energy_drift, order_of, symplecticity_defect};

#[test]
fn coefficients_are_those_of_collocation() {
    fn check<T: Collocation<K>, const K: usize>() {
        // C(K): Σⱼ aᵢⱼ cⱼ^(m−1) = cᵢ^m/m, and B(2K): Σ bⱼ cⱼ^(m−1) = 1/m, which imply order 2K.
        for m in 1..=2 * K as i32 {
            let power = |j: usize| T::C[j].hi.powi(m - 1);
            let sum: f64 = (0..K).map(|j| T::B[j].hi * power(j)).sum();
            assert!((sum - 1.0 / f64::from(m)).abs() < 1e-15);
            for i in (0..K).filter(|_| m <= K as i32) {
                let sum: f64 = (0..K).map(|j| T::A[i][j].hi * power(j)).sum();
                assert!((sum - T::C[i].hi.powi(m) / f64::from(m)).abs() < 1e-15);
            }
        }
        for i in 0..K {
            for j in 0..K {
                let [over, under] = [T::RATIO[i][j], T::RATIO[j][i]];
                assert_eq!(
                    [(over.hi - 0.5) + (under.hi - 0.5), over.lo + under.lo],
                    [0.0; 2],
                    "symplectic exactly"
                );
                assert!((T::RATIO[i][j] * T::B[j] - T::A[i][j]).value().abs() < 1e-31);
            }
        }
    }
    check::<ImplicitMidpoint, 1>();
    check::<Gauss4, 2>();
    check::<Gauss6, 3>();
}

#[test]
fn orders_are_twice_the_number_of_stages() {
    let (start, exact) = (polar(0.0), polar(4.0));
    let two = order_of(&Polar::default(), &ImplicitMidpoint, &start, &exact, &[400, 800, 1600]).unwrap();
    let four = order_of(&Polar::default(), &Gauss4, &start, &exact, &[100, 200, 400]).unwrap();
    let six = order_of(&Polar::default(), &Gauss6, &start, &exact, &[48, 64, 96]).unwrap();
    assert!(
        (two - 2.0).abs() < 0.1 && (four - 4.0).abs() < 0.1 && (six - 6.0).abs() < 0.1,
        "{two} {four} {six}"
    );
    let dense = dense_order_of(&Polar::default(), &Gauss4, polar, 3.0, &[50, 100, 200]).unwrap();
    assert!((dense - 4.0).abs() < 0.15, "{dense}");
}

#[test]
fn all_are_symplectic_where_the_inertia_depends_on_q() {
    let system = DoublePendulum::<Dual<f64>>::default();
    for h in [0.01, 0.1, 0.3] {
        let defects = [
            symplecticity_defect(&system, &ImplicitMidpoint, &DOUBLE, h).unwrap(),
            symplecticity_defect(&system, &Gauss4, &DOUBLE, h).unwrap(),
            symplecticity_defect(&system, &Gauss6, &DOUBLE, h).unwrap(),
        ];
        assert!(defects.iter().all(|&defect| defect < 1e-13), "{defects:?}");
    }
}

fn returns(method: impl Method<DoublePendulum, 2> + Copy) {
    let system = DoublePendulum::default();
    let there = integrate(&system, method, FixedStep::new(0.05), DOUBLE).until(5.0).final_state().unwrap();
    let back = integrate(&system, method, FixedStep::new(-0.05), there).until(0.0).final_state().unwrap();
    assert!(distance(&DOUBLE, &back) < 1e-12, "{back:?}");
}

#[test]
fn all_are_time_symmetric() {
    returns(ImplicitMidpoint);
    returns(Gauss4);
    returns(Gauss6);
}

#[test]
fn energy_does_not_drift() {
    let system = Polar::default();
    let drift = |turns: f64| {
        let end = turns * core::f64::consts::TAU;
        energy_drift(
            &system,
            integrate(&system, ImplicitMidpoint, FixedStep::new(0.05), polar(0.0)).until(end),
        )
        .unwrap()
    };
    let (short, long) = (drift(1.0), drift(100.0));
    assert!(short < 2e-3 && long < 1.05 * short, "{short} {long}");
    let end = 100.0 * core::f64::consts::TAU;
    let six = integrate(&system, Gauss6, FixedStep::new(0.02), polar(0.0)).until(end);
    let drift = energy_drift(&system, six).unwrap();
    assert!(drift < 2e-13, "{drift}");
}

#[test]
fn too_long_a_step_is_a_failure() {
    let system = Chain::<f64, 2> { k: 1e4 };
    let start = State::new(0.5, [1.0, 0.0], [0.0, 0.0]);
    let failed = integrate(&system, ImplicitMidpoint, FixedStep::new(0.5), start)
        .until(1.0)
        .final_state()
        .unwrap_err();
    assert_eq!(failed.last, start);
    match failed.failure {
        Failure::NotConverged { t, h, iterations } => {
            assert_eq!((t, h, iterations), (0.5, 0.5, MOST_ITERATIONS))
        }
        other => panic!("{other}"),
    }
    // Here the diverging iterates overflow first, which is no other failure.
    let system = Chain::<f64, 2> { k: 1e12 };
    let failed = integrate(&system, Gauss4, FixedStep::new(0.5), start).until(1.0).final_state().unwrap_err();
    assert!(
        matches!(failed.failure, Failure::NotConverged { t: 0.5, h: 0.5, iterations } if iterations < MOST_ITERATIONS),
        "{failed}"
    );
}

#[test]
fn a_singular_inertia_is_named() {
    // r = 0 has no inertia in φ, coordinate 1.
    let start = State::new(0.0, [0.0, 0.0], [0.0, 0.0]);
    let failure = ImplicitMidpoint.start(&Polar::<f64>::default(), &start).unwrap_err();
    assert_eq!(failure, Failure::SingularInertia { t: 0.0, coordinate: coordinate(1, ""), with: None });
    let massless = Pendulum { m: 0.0, l: 1.0, g: 1.0 };
    let start = State::new(2.0, [1.0], [0.0]);
    let failure = crate::Verlet.start(&massless, &start).unwrap_err();
    assert_eq!(failure, Failure::SingularInertia { t: 2.0, coordinate: coordinate(0, ""), with: None });
}

/// Iteration counts with the extrapolated guess: what a step costs.
#[test]
fn the_guess_saves_iterations() {
    let system = Polar::default();
    let mut run = integrate(&system, Gauss4, FixedStep::new(0.05), polar(0.0)).until(10.0);
    run.run_to_end().unwrap();
    let per_step = run.statistics().evaluations as f64 / run.statistics().accepted as f64;
    assert!(per_step < 25.0, "{per_step}");
}

/// The energy of a pendulum (amplitude 2) over `periods`, in steps of a `divisions`-th of one: the largest deviation in
/// the first period, and at the end of a series of stretches each ten times longer than the one before the largest in
/// it and the mean over it, of a period each.
fn pendulum_energy(
    method: impl Method<Pendulum, 1> + Copy,
    divisions: u32,
    periods: u32,
) -> (f64, Vec<(f64, f64)>) {
    let system = Pendulum::default();
    let mut state = State::new(0.0, [2.0], [0.0]);
    let h = pendulum_period(2.0) / f64::from(divisions);
    let energy = |at: &State<f64, 1>| system.energy_function(&at.q, &at.qd, at.t);
    let start = energy(&state);
    let mut memory = method.start(&system, &state).unwrap();
    let mut period = || {
        let (mut worst, mut sum) = (0.0f64, 0.0);
        for _ in 0..divisions {
            let mut next = memory.clone();
            let step = method.step(&system, &memory, &state, h, &mut next).unwrap();
            (state, memory) = (step.to, next);
            let deviation = energy(&state) - start;
            worst = worst.max(deviation.abs());
            sum += deviation;
        }
        (worst, sum / f64::from(divisions))
    };
    let first = period().0;
    let mut stretches = Vec::new();
    let (mut done, mut next, mut worst) = (1, 10, 0.0f64);
    while done < periods {
        let (largest, mean) = period();
        done += 1;
        worst = worst.max(largest);
        if done == next {
            stretches.push((worst, mean));
            (next, worst) = (next * 10, 0.0);
        }
    }
    (first, stretches)
}

/// Which points of the motion steps meet, and so how large the error at them is, changes over many periods. But from
/// the first thousand on it is the same: bounded, without drift.
#[test]
fn the_energy_of_a_pendulum_is_kept_over_a_hundred_thousand_periods() {
    for (name, (first, stretches)) in
        [("Gauss4", pendulum_energy(Gauss4, 12, 100_000)), ("Gauss6", pendulum_energy(Gauss6, 12, 100_000))]
    {
        println!("{name}: first period {first:e}, then {stretches:?}");
        let short = stretches[..3].iter().fold(first, |most, (worst, _)| most.max(*worst));
        assert!(stretches[3..].iter().all(|(worst, _)| *worst < 1.001 * short), "{name}: {stretches:?}");
    }
}

#[test]
#[ignore = "takes minutes; its output is what it is for"]
fn the_energy_of_a_pendulum_is_kept_over_a_million_periods() {
    for (name, (first, stretches)) in [
        ("Gauss4, 12 steps per period", pendulum_energy(Gauss4, 12, 1_000_000)),
        ("Gauss6, 12 steps per period", pendulum_energy(Gauss6, 12, 1_000_000)),
        ("Gauss6, 50 steps per period", pendulum_energy(Gauss6, 50, 1_000_000)),
    ] {
        println!("{name}: first period {first:e}, then {stretches:?}");
        let short = stretches[..3].iter().fold(first, |most, (worst, _)| most.max(*worst));
        // With 50 steps a period the numerical period is so close to the given one that the points which steps meet
        // wander over a twentieth of a step in 10⁶ periods, and the largest of their errors with them.
        assert!(stretches[3..].iter().all(|(worst, _)| *worst < 1.01 * short), "{name}: {stretches:?}");
        // What does not depend on the points is the mean over a period, and that moves by rounding: √(5 · 10⁷)
        // roundings of an energy of 10 are 8e-12.
        if name.contains("50") {
            let means = stretches.iter().map(|(_, mean)| *mean);
            let (least, most) = means.fold((f64::MAX, f64::MIN), |(a, b), x| (a.min(x), b.max(x)));
            assert!(most - least < 1e-12, "{name}: {stretches:?}");
        }
    }
}

/// The energy of an oscillator is quadratic, and kept by the method itself: all that is left is rounding. Over an
/// ensemble its root mean square grows as the root of the number of steps (Brouwer's law), not in proportion to it.
fn rounding_growth<const D: usize>(
    method: impl Method<Repelled, 1> + Copy,
    h: f64,
    stops: [u32; D],
) -> [f64; D] {
    const MEMBERS: u32 = 24;
    let system = Repelled::new(-1.0);
    let mut squares = [0.0; D];
    for member in 0..MEMBERS {
        let mut state = State::new(0.0, [1.0 + 0.0137 * f64::from(member)], [0.0]);
        let energy = |at: &State<f64, 1>| system.energy_function(&at.q, &at.qd, at.t);
        let start = energy(&state);
        let mut memory = method.start(&system, &state).unwrap();
        for n in 1..=stops[D - 1] {
            let mut next = memory.clone();
            let step = method.step(&system, &memory, &state, h, &mut next).unwrap();
            (state, memory) = (step.to, next);
            if let Some(i) = stops.iter().position(|&stop| stop == n) {
                squares[i] += (energy(&state) / start - 1.0).powi(2) / f64::from(MEMBERS);
            }
        }
    }
    squares.map(f64::sqrt)
}

/// A step of 0.1 is nearly a tenth of a turn, and roundings of increments are anything but random.
#[test]
fn rounding_errors_grow_as_the_root_of_the_number_of_steps() {
    let stops = [1000, 100_000];
    for (name, growth) in [
        ("ImplicitMidpoint", rounding_growth(ImplicitMidpoint, 0.1, stops)),
        ("Gauss4", rounding_growth(Gauss4, 0.1, stops)),
        ("Gauss6", rounding_growth(Gauss6, 0.1, stops)),
        ("VariationalMidpoint", rounding_growth(VariationalMidpoint, 0.1, stops)),
    ] {
        println!("{name}: {growth:?}");
        // As the root it grows by 10, of which the rounding of the energy itself hides some; in proportion by 100.
        assert!(growth[1] < 15.0 * growth[0] && growth[1] < 2.5e-15, "{name}: {growth:?}");
    }
}

/// ```text
/// cargo test --release -p lagrange-runtime --lib -- --ignored --nocapture rounding_errors
/// ```
#[test]
#[ignore = "a million steps of 24 members at three step sizes take minutes"]
fn rounding_errors_grow_as_the_root_of_a_million_steps() {
    let stops = [10_000, 100_000, 1_000_000];
    for h in [0.05, 0.1, 0.13] {
        for (name, growth) in [
            ("ImplicitMidpoint", rounding_growth(ImplicitMidpoint, h, stops)),
            ("Gauss4", rounding_growth(Gauss4, h, stops)),
            ("Gauss6", rounding_growth(Gauss6, h, stops)),
            ("VariationalMidpoint", rounding_growth(VariationalMidpoint, h, stops)),
        ] {
            println!("{name}, h = {h}: {growth:?}");
            assert!(growth[2] < 20.0 * growth[0] && growth[2] < 1e-14, "{name}, h = {h}: {growth:?}");
        }
    }
}

/// An iteration that converges slowly is waited for, or the step fails: nothing between.
#[test]
fn slow_iterations_end_at_rounding_or_fail() {
    fn drift(method: impl Method<Repelled, 1> + Copy, h: f64) -> Result<f64, Failure> {
        let (system, mut state) = (Repelled::new(-1.0), State::new(0.0, [1.0], [0.0]));
        let mut memory = method.start(&system, &state)?;
        for _ in 0..10_000 {
            let mut next = memory.clone();
            let step = method.step(&system, &memory, &state, h, &mut next)?;
            (state, memory) = (step.to, next);
        }
        Ok((system.energy_function(&state.q, &state.qd, 0.0) / 0.5 - 1.0).abs())
    }
    let (mut good, mut failed) = (0, 0);
    for k in 0..60 {
        let h = 0.05 * f64::from(k + 10);
        for result in [drift(ImplicitMidpoint, h), drift(Gauss4, h), drift(Gauss6, h)] {
            match result {
                Ok(drift) => {
                    good += 1;
                    assert!(drift < 3e-12, "{drift:e} at h = {h}");
                }
                Err(failure) => {
                    failed += 1;
                    assert!(matches!(failure, Failure::NotConverged { .. }), "{failure} at h = {h}");
                }
            }
        }
    }
    assert!(good > 60 && failed > 20, "{good} {failed}");
}
