//! Against 400 digits and more (mpmath, by the series after scaling, and by the roots of the oscillator).
#![allow(clippy::excessive_precision)]

use super::*;

fn matrix(rows: usize, all: &[f64]) -> DMatrix<f64> {
    DMatrix::from_row_slice(rows, all.len() / rows, all)
}

/// A and B of `ẍ + c ẋ + k x = u`.
fn oscillator(k: f64, c: f64, period: f64) -> Result<[DMatrix<f64>; 2], AnalysisError> {
    held(&matrix(2, &[0.0, 1.0, -k, -c]), &matrix(2, &[0.0, 1.0]), period)
}

#[track_caller]
fn close(found: &DMatrix<f64>, exact: &[f64], relative: f64) {
    for (found, exact) in found.transpose().iter().zip(exact) {
        assert!((found - exact).abs() <= relative * exact.abs(), "{found:e} {exact:e}");
    }
}

#[test]
fn entries_of_stiff_systems_keep_their_digits_each_for_itself() {
    let table: [(f64, f64, [f64; 6]); 9] = [
        (
            4.0,
            1e40,
            [
                1.0,
                9.9999999999999997e-41,
                -3.9999999999999999e-40,
                -3.9999999999999998e-80,
                1e-41,
                9.9999999999999997e-41,
            ],
        ),
        (
            4.0,
            1e100,
            [
                1.0,
                9.9999999999999998e-101,
                -3.9999999999999999e-100,
                -3.9999999999999999e-200,
                1e-101,
                9.9999999999999998e-101,
            ],
        ),
        (
            4e8,
            1e8,
            [
                0.67032006212332241,
                6.7032008893612704e-9,
                -2.6812803557445081,
                -2.681280462995731e-8,
                8.2419984469169398e-10,
                6.7032008893612704e-9,
            ],
        ),
        (
            4e12,
            1e12,
            [
                0.67032004603724805,
                6.7032004603992933e-13,
                -2.6812801841597173,
                -2.6812801841704425e-12,
                8.2419988490687987e-14,
                6.7032004603992933e-13,
            ],
        ),
        (
            4e15,
            1e15,
            [
                0.67032004603564089,
                6.7032004603564358e-16,
                -2.6812801841425743,
                -2.681280184142585e-15,
                8.2419988491089776e-17,
                6.7032004603564358e-16,
            ],
        ),
        (
            4e16,
            1e16,
            [
                0.67032004603563945,
                6.7032004603563971e-17,
                -2.6812801841425589,
                -2.6812801841425599e-16,
                8.2419988491090138e-18,
                6.7032004603563971e-17,
            ],
        ),
        (
            4e18,
            1e18,
            [
                0.67032004603563929,
                6.7032004603563929e-19,
                -2.6812801841425572,
                -2.6812801841425572e-18,
                8.2419988491090178e-20,
                6.7032004603563929e-19,
            ],
        ),
        (
            4e20,
            1e20,
            [
                0.67032004603563929,
                6.7032004603563929e-21,
                -2.6812801841425571,
                -2.6812801841425571e-20,
                8.2419988491090179e-22,
                6.7032004603563929e-21,
            ],
        ),
        (
            1e6,
            0.1,
            [
                0.85799278397759492,
                -0.00050384023982065965,
                503.84023982065965,
                0.85804316800157698,
                1.4200721602240508e-7,
                -0.00050384023982065965,
            ],
        ),
    ];
    for (k, c, exact) in table {
        let [a, b] = oscillator(k, c, 0.1).unwrap();
        close(&a, &exact[..4], 2e-15);
        close(&b, &exact[4..], 2e-15);
    }
}

#[test]
fn a_motor_with_a_fast_armature_has_the_response_of_its_slow_part() {
    let table: [(f64, [f64; 6]); 2] = [
        (
            1e-14,
            [
                0.39346934028736961,
                3.9346934028736354e-14,
                0.60653065971263646,
                6.0653065971264252e-14,
                1.0653065971263039,
                3.9346934028736354,
            ],
        ),
        (
            1e-20,
            [
                0.39346934028736656,
                3.9346934028736656e-20,
                0.60653065971263336,
                6.0653065971263336e-20,
                1.0653065971263342,
                3.9346934028736656,
            ],
        ),
    ];
    for (l, [position, by_current, velocity, of_current, displaced, moved]) in table {
        let motor = matrix(3, &[0.0, 1.0, 0.0, 0.0, 0.0, 0.1 / 0.01, 0.0, -0.1 / l, -1.0 / l]);
        let [a, b] = held(&motor, &matrix(3, &[0.0, 0.0, 1.0 / l]), 0.5).unwrap();
        close(&a.rows(0, 2).into_owned(), &[1.0, position, by_current, 0.0, velocity, of_current], 2e-15);
        close(&b.rows(0, 2).into_owned(), &[displaced, moved], 2e-15);
    }
}

#[test]
fn three_time_scales_and_a_fast_direction_that_is_no_coordinate() {
    let chain = matrix(3, &[-1.0, 1.0, 0.0, 1e6, -2e6, 1e6, 0.0, 1e12, -3e12]);
    let [a, b] = held(&chain, &matrix(3, &[0.0, 1.0, 1e12]), 0.7).unwrap();
    let exact = [
        [0.75578354555649256, 4.5347023616672513e-7, 1.5115674538892853e-13],
        [0.45347023616672513, 2.720822069997485e-7, 9.069406899992826e-14],
        [0.15115674538892853, 9.069406899992826e-8, 3.0231356333313451e-14],
    ];
    close(&a, exact.as_flattened(), 4e-15);
    close(&b, &[0.12210836681056152, 0.27326556566972622, 0.424421855223232], 4e-15);
    // −1e15 along (3, 4)/5, and rest along (4, −3)/5.
    let [a, _] = held(&(matrix(2, &[0.36, 0.48, 0.48, 0.64]) * -1e15), &DMatrix::zeros(2, 0), 0.1).unwrap();
    close(&a, &[0.64, -0.48, -0.48, 0.36], 1e-12);
}

#[test]
fn what_is_not_finite_or_not_resolved_is_refused_and_every_norm_comes_to_an_end() {
    // An unstable plant over a long period, entries that overflow, numbers that are none.
    for (k, c, period) in
        [(4.0, -0.1, 1e5), (4.0, 1e300, 1e10), (4.0, f64::NAN, 0.1), (f64::INFINITY, 1.0, 0.1)]
    {
        assert_eq!(oscillator(k, c, period), Err(AnalysisError::NotFinite), "{k} {c} {period}");
    }
    // 1e31 turns: each digit of them is rounding.
    for k in [1e65, 1e70] {
        let refused = oscillator(k, 0.1, 0.1).unwrap_err();
        assert!(matches!(refused, AnalysisError::NotApplicable { .. }), "{refused}");
    }
    for c in [1e100, 1e150, 1e300] {
        let [a, _] = oscillator(4.0, c, 0.1).unwrap();
        assert_eq!((a[(0, 0)], a[(0, 1)], a[(1, 1)].abs() < 1e-199), (1.0, 1.0 / c, true), "{c:e}");
    }
    // Stable, and as long that nothing is left; unstable, and known.
    let [a, b] = oscillator(4.0, 0.1, 1e10).unwrap();
    assert!(a.amax() < 1e-30 && (b[0] - 0.25).abs() < 1e-16 && b[1].abs() < 1e-30);
    let [a, b] = oscillator(4.0, -0.1, 100.0).unwrap();
    close(&a, &[67.415160315456431, -66.957178189949583, 267.82871275979833, 60.719442496461472], 1e-14);
    close(&b, &[-16.603790078864108, -66.957178189949583], 1e-14);
}

#[test]
fn units_of_states_and_inputs_do_not_matter() {
    let [a, b] = held(&matrix(2, &[0.0, 1e30, 0.0, 0.0]), &matrix(2, &[0.0, 1e-20]), 2.0).unwrap();
    assert_eq!((a, b), (matrix(2, &[1.0, 2e30, 0.0, 1.0]), matrix(2, &[2e10, 2e-20])));
    let a = matrix(2, &[-0.3, 1.7, -2.9, -0.1]);
    let b = matrix(2, &[0.4, 0.9]);
    let unit = 2f64.powi(200);
    let there = matrix(2, &[-0.3, 1.7 * unit, -2.9 / unit, -0.1]);
    let [first, second] = held(&a, &b, 0.8).unwrap();
    let [other, driven] = held(&there, &matrix(2, &[0.4 * unit, 0.9]), 0.8).unwrap();
    close(&other, &[first[(0, 0)], first[(0, 1)] * unit, first[(1, 0)] / unit, first[(1, 1)]], 1e-15);
    close(&driven, &[second[0] * unit, second[1]], 1e-15);
}

#[test]
fn oscillations_keep_their_phase_to_a_bound_and_are_refused_beyond() {
    for (k, exact) in [
        (1e16, [-0.90274535627533335, 4.1845030182177602e-9, -41845030.182177602, -0.90274535669378365]),
        (1e22, [0.86876518966158375, -4.8507409638221154e-12, 48507409638.221154, 0.86876518966206883]),
    ] {
        close(&oscillator(k, 0.1, 0.1).unwrap()[0], &exact, 2e-15);
    }
    assert!(matches!(oscillator(1e26, 0.1, 0.1), Err(AnalysisError::NotApplicable { .. })));
}
