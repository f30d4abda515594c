//! Derivatives of motions whose forces jump, against closed forms: neighbours cross the jump at other times.

use crate::systems::{Rubbing, Vee};
use lagrange_runtime::Gradient;
use lagrange_runtime::analysis::*;
use lagrange_runtime::failure::Requirement;
use lagrange_runtime::prelude::*;

lagrangian! {
    /// Forces that jump where functions of all coordinates, velocities and time vanish.
    pub system Belts {
        param mu, w;
        coord x, y;
        T = 0.5 * dot(x).powi(2) + 0.5 * dot(y).powi(2) + 0.2 * cos(y) * dot(x) * dot(y);
        V = 0.5 * x.powi(2) + 0.5 * (y - x).powi(2);
        Q[x] = if dot(x) - dot(y) * x > 0.1 * sin(w * t) { -mu } else { mu };
        Q[y] = if x + 0.3 * y * dot(y) > 0.2 { 0.5 } else { -0.3 };
    }
}

/// The fundamental matrix of a system of one coordinate by each way.
macro_rules! all_ways {
    ($system:expr, $start:expr, $end:expr) => {{
        let over = $system.map(Gradient::<_, 2>::constant);
        let matrix = |found: Result<(State<f64, 1>, DMatrix<f64>), AnalysisError>| found.unwrap().1;
        [
            matrix(fundamental_matrix(&ByVariationalEquations::<_, 3>::new($system, 1e-12), $start, $end)),
            matrix(fundamental_matrix(&ByGradients::new(over, 1e-12), $start, $end)),
            matrix(fundamental_matrix(
                &ByGradients::with(over, Dop853, PiController::tolerance(1e-12)),
                $start,
                $end,
            )),
            matrix(fundamental_matrix(
                &ByGradients::with(over, Verner9, PiController::tolerance(1e-12)),
                $start,
                $end,
            )),
            matrix(fundamental_matrix(
                &ByGradients::with(over, Radau5, PiController::tolerance(1e-12)),
                $start,
                $end,
            )),
        ]
    }};
}

/// From rest at ½ the body is at 0 at t = 1 with the velocity −1. By ½ + δ it is there later by δ. A whole swing of 4
/// √(2 x₀) is later by 4 δ.
#[test]
fn a_potential_with_an_edge() {
    let start = State::new(0.0, [0.5], [0.0]);
    for (end, exact) in
        [(0.9, [1.0, 0.9, 0.0, 1.0]), (1.6, [-0.2, 0.4, -2.0, -1.0]), (4.0, [1.0, 0.0, 4.0, 1.0])]
    {
        for found in all_ways!(&Vee::new(), &start, end) {
            let exact = DMatrix::from_row_slice(2, 2, &exact);
            assert!((&found - exact).amax() < 1e-11, "{end}: {found}");
        }
    }
}

/// `x = μ + A cos(t − φ)` until t = π + φ, and `x = −μ + (A − 2μ) cos(t − φ)` for half a period more.
#[test]
fn dry_friction() {
    let (mu, x0, v0, end) = (0.3, 2.0, -0.3, 5.0);
    let [x, v] = [x0 - mu, v0];
    let (amplitude, phase) = (f64::hypot(x, v), f64::atan2(v, x));
    let (sin, cos) = (end - phase).sin_cos();
    let slopes = [[x / amplitude, -v / amplitude.powi(2)], [v / amplitude, x / amplitude.powi(2)]];
    let exact = DMatrix::from_fn(2, 2, |row, column| {
        let [by_amplitude, by_phase] = slopes[column];
        match row {
            0 => by_amplitude * cos + (amplitude - 2.0 * mu) * sin * by_phase,
            _ => -by_amplitude * sin + (amplitude - 2.0 * mu) * cos * by_phase,
        }
    });
    for found in all_ways!(&Rubbing::new(mu), &State::new(0.0, [x0], [v0]), end) {
        assert!((&found - &exact).amax() < 1e-10, "{found}{exact}");
    }
}

/// Many jumps, against differences of neighbouring motions, and the ways against each other.
#[test]
fn jumps_by_functions_of_the_whole_state() {
    let system = Belts::new(0.3, 1.3);
    let over = system.map(Gradient::<_, 4>::constant);
    let (start, end) = (State::new(0.0, [1.0, 0.5], [0.1, -0.2]), 8.0);
    let ends = |start| {
        let run = integrate(&system, Taylor::of_order(20), TaylorController::tolerance(1e-15), start);
        let State { q, qd, .. } = run.until(end).final_state().unwrap();
        SVector::<f64, 4>::from([q[0], q[1], qd[0], qd[1]])
    };
    let differences = DMatrix::from_columns(&std::array::from_fn::<_, 4, _>(|k| {
        let moved = |h: f64| {
            let mut start = start;
            if k < 2 {
                start.q[k] += h
            } else {
                start.qd[k - 2] += h
            }
            ends(start)
        };
        let h = 1e-4;
        let [wide, narrow] = [h, 0.5 * h].map(|h| (moved(h) - moved(-h)) / (2.0 * h));
        let column = (narrow * 4.0 - wide) / 3.0;
        DVector::from_column_slice(column.as_slice())
    }));
    for tolerance in [1e-10, 1e-13] {
        let ways = [
            fundamental_matrix(&ByVariationalEquations::<_, 10>::new(&system, tolerance), &start, end),
            fundamental_matrix(&ByGradients::new(over, tolerance), &start, end),
            fundamental_matrix(
                &ByGradients::with(over, Dop853, PiController::tolerance(tolerance)),
                &start,
                end,
            ),
            fundamental_matrix(
                &ByGradients::with(over, Verner9, PiController::tolerance(tolerance)),
                &start,
                end,
            ),
        ];
        let ways = ways.map(|way| way.unwrap().1);
        for way in &ways {
            assert!(
                (way - &differences).amax() < 1e3 * tolerance + 1e-9,
                "{tolerance}: {:e}",
                (way - &differences).amax()
            );
            assert!((way - &ways[1]).amax() < 1e3 * tolerance, "{tolerance}: {:e}", (way - &ways[1]).amax());
        }
    }
}

/// Steps of one size do not end where forces jump.
#[test]
fn fixed_steps_over_jumps_are_refused() {
    let system = Rubbing::new(0.3);
    let start = State::new(0.0, [2.0], [-0.3]);
    let refused =
        AnalysisError::Run(Failure::Unsuitable { chosen: "FixedStep", requirement: Requirement::Smooth });
    let variational = ByVariationalEquations::<_, 3, _, _>::with(&system, Rk4, FixedStep::new(0.01));
    assert_eq!(fundamental_matrix(&variational, &start, 5.0).unwrap_err(), refused);
    let over = system.map(Gradient::<_, 2>::constant);
    let gradients = ByGradients::with(over, Rk4, FixedStep::new(Gradient::constant(0.01)));
    assert_eq!(fundamental_matrix(&gradients, &start, 5.0).unwrap_err(), refused);
    let family = |[mu]: [Gradient<f64, 1>; 1]| Rubbing { mu };
    let found = sensitivity(family, [0.3], Rk4, FixedStep::new(Gradient::constant(0.01)), &start, 5.0);
    assert_eq!(
        found.unwrap_err(),
        Failure::Unsuitable { chosen: "FixedStep", requirement: Requirement::Smooth }
    );
    // By series they do, and by adaptive steps: ∂x/∂μ with ∂A/∂μ = −(x₀ − μ)/A and ∂φ/∂μ = v₀/A².
    let [x, v] = [2.0 - 0.3, -0.3];
    let (amplitude, phase) = (f64::hypot(x, v), f64::atan2(v, x));
    let (sin, cos) = (5.0 - phase).sin_cos();
    let exact = -1.0 + (-x / amplitude - 2.0) * cos + (amplitude - 0.6) * sin * v / amplitude.powi(2);
    let found = sensitivity(family, [0.3], Dop853, PiController::tolerance(1e-12), &start, 5.0).unwrap();
    assert!((found.slopes[0].q[0] - exact).abs() < 1e-10);
    let found =
        sensitivity(family, [0.3], Taylor::of_order(20), TaylorController::tolerance(1e-12), &start, 5.0)
            .unwrap();
    assert!((found.slopes[0].q[0] - exact).abs() < 1e-10);
}
