//! The energy that implicit methods keep over many steps: without drift, and with errors that grow as those of rounding
//! do.

use lagrange_runtime::prelude::*;
use lagrange_runtime::testing::reference::SimplePendulum;

lagrangian! {
    system Pendulum {
        coord theta;
        T = 0.5 * dot(theta).powi(2);
        V = -cos(theta);
    }
}

lagrangian! {
    system Oscillator {
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = 0.5 * x.powi(2);
    }
}

/// The energy of a pendulum (amplitude 2) over `periods`, in steps of a `divisions`-th of one: the largest deviation in
/// the first period, and at the end of a series of stretches each ten times longer than the one before the largest in
/// it and the mean over it, of a period each.
fn pendulum_energy(
    method: impl Method<Pendulum, 1> + Copy,
    divisions: u32,
    periods: u32,
) -> (f64, Vec<(f64, f64)>) {
    let system = Pendulum::new();
    let mut state = State::new(0.0, [2.0], [0.0]);
    let h = SimplePendulum::new(1.0, 1.0, 2.0, 0.0).period() / f64::from(divisions);
    let energy = |at: &State<f64, 1>| system.energy_function(&at.q, &at.qd, at.t);
    let start = energy(&state);
    let mut memory = method.start(&system, &state).unwrap();
    let mut period = || {
        let (mut worst, mut sum) = (0.0f64, 0.0);
        for _ in 0..divisions {
            let (step, next) = method.step(&system, &memory, &state, h).unwrap();
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

/// The points of the motion that steps meet, and so the size of the error at them, change over many periods. But from
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
        // The mean over a period does not depend on the points, and moves by rounding: √(5 · 10⁷)
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
    method: impl Method<Oscillator, 1> + Copy,
    h: f64,
    stops: [u32; D],
) -> [f64; D] {
    const MEMBERS: u32 = 24;
    let system = Oscillator::new();
    let mut squares = [0.0; D];
    for member in 0..MEMBERS {
        let mut state = State::new(0.0, [1.0 + 0.0137 * f64::from(member)], [0.0]);
        let energy = |at: &State<f64, 1>| system.energy_function(&at.q, &at.qd, at.t);
        let start = energy(&state);
        let mut memory = method.start(&system, &state).unwrap();
        for n in 1..=stops[D - 1] {
            let (step, next) = method.step(&system, &memory, &state, h).unwrap();
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
/// cargo test --release -p lagrange-motions --features long --test energies -- --ignored --nocapture rounding_errors
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
    fn drift(method: impl Method<Oscillator, 1> + Copy, h: f64) -> Result<f64, Failure> {
        let (system, mut state) = (Oscillator::new(), State::new(0.0, [1.0], [0.0]));
        let mut memory = method.start(&system, &state)?;
        for _ in 0..10_000 {
            let (step, next) = method.step(&system, &memory, &state, h)?;
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
