use super::{Remainder, TaylorController, WINDOW, changes};
use crate::controller::Verdict;
use crate::scalar::{DoubleDouble, Real};
use crate::series::TaylorSeries;
use crate::state::{State, Tangent};

/// Numbers between 0 and 1, always the same ones.
fn random() -> impl FnMut() -> f64 {
    let mut seed = 1u64;
    move || {
        seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (seed >> 11) as f64 / (1u64 << 53) as f64
    }
}

#[test]
fn what_is_not_a_number_is_no_small_error() {
    let to = State::new(1.0, [1.0; 2], [1.0; 2]);
    for place in 0..2 {
        let mut remainder = Remainder::<f64, 2> {
            error: Tangent::zero(),
            last: [Tangent::zero(); WINDOW],
            order: 2 * WINDOW,
        };
        let decide = |remainder: &Remainder<f64, 2>| {
            let mut decay = TaylorController::tolerance(1e-9);
            let [measure] = decay.measured([0.1], &to, remainder, |x: f64, _| x.abs());
            decay.decide::<1>(measure, 8, f64::EPSILON)
        };
        assert!(matches!(decide(&remainder), Verdict::Accept { .. }));
        (remainder.error.q[place], remainder.error.qd[place]) = (f64::NAN, f64::NAN);
        assert!(matches!(decide(&remainder), Verdict::Reject { .. }), "{place}");
    }
}

/// Terms below half a unit in the last place of a sum are left out of it, every time with the sign that they have in
/// that part of a motion: the errors of a step then have a mean, and energies drift where steps fall at the same
/// places in each turn.
#[test]
fn sums_of_a_step_err_to_both_sides() {
    // Of few digits, as steps are: its powers are exact.
    let (mut random, h, p) = (random(), 11.0 / 64.0, 20);
    let (mut sums, count) = ([0.0; 2], 40_000);
    for _ in 0..count {
        let mut series = TaylorSeries::<f64, 1, 24>::zero();
        // Those of lower orders are rounded more coarsely, and would only hide the others.
        for k in 4..p + 2 {
            series.q[k][0] = 0.6f64.powi(k as i32) * (1.0 + 0.01 * random());
        }
        let exact = changes(&TaylorSeries { q: series.q.map(|x| x.map(DoubleDouble::from)) }, p, h.into());
        let changes = changes(&series, p, h);
        let units =
            |x: f64, exact: DoubleDouble| (DoubleDouble::from(x) - exact).to_f64() / (x * f64::EPSILON);
        sums[0] += units(changes.q[0], exact.q[0]);
        sums[1] += units(changes.qd[0], exact.qd[0]);
    }
    for sum in sums {
        assert!((sum / f64::from(count)).abs() < 0.01, "{sums:?} of {count}");
    }
}
