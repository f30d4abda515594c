//! Modes and responses in odd units, of coordinates of very different stiffness, and of equilibria that are known to
//! rounding only.

use lagrange_runtime::analysis::*;
use lagrange_runtime::prelude::*;

lagrangian! {
    /// A particle in a trough, `x² + y² = 1`.
    pub system Trough {
        param k, c;
        coord x, y;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = 0.25 * k * (x.powi(2) + y.powi(2) - 1).powi(2);
        D = 0.5 * c * (dot(x).powi(2) + dot(y).powi(2));
    }
}

fn symmetric<const N: usize>(rows: [[f64; N]; N]) -> DMatrix<f64> {
    DMatrix::from_fn(N, N, |i, j| rows[i.min(j)][i.max(j)])
}

fn free<const N: usize>() -> DMatrix<f64> {
    DMatrix::zeros(N, N)
}

/// Digits from 250-digit arithmetic; with r → ∞ the soft coordinates are left with `Kᵢⱼ − K₀ᵢ K₀ⱼ/r`.
#[test]
fn soft_frequencies_beside_stiff_ones() {
    for (r, soft) in [
        (1e8f64, [0.747_848_815_115_820_6, 1.912_151_181_140_179_4]),
        (1e16, [0.747_848_816_886_884_6, 1.912_151_183_113_115_4]),
        (1e24, [0.747_848_816_886_884_6, 1.912_151_183_113_115_4]),
        (1e100, [0.747_848_816_886_884_6, 1.912_151_183_113_115_4]),
    ] {
        let (a, b) = (r.sqrt() * 0.5, r.sqrt() * 0.3);
        let k = symmetric([[r, a, b], [0.0, 1.0, 0.2], [0.0, 0.0, 2.0]]);
        let small = SmallMotion::new(DMatrix::identity(3, 3), free::<3>(), k).unwrap();
        let modes = small.modes().unwrap();
        for (found, exact) in modes.squares().iter().zip(soft) {
            assert!((found / exact - 1.0).abs() < 1e-15, "{r:e}: {found} for {exact}");
        }
        assert!((0..3).all(|k| modes.kind(k) == ModeKind::Vibration), "{r:e}");
        // The spectrum with as good as no damping has the same frequencies.
        let k = small.stiffness().clone();
        let light = SmallMotion::new(DMatrix::identity(3, 3), DMatrix::identity(3, 3) * 1e-30, k).unwrap();
        let spectrum = light.spectrum().unwrap();
        for (frequency, exact) in spectrum.frequencies().iter().zip(soft) {
            assert!((frequency / exact.sqrt() - 1.0).abs() < 1e-15, "{r:e}: {frequency}");
        }
        for (z, error) in spectrum.eigenvalues.iter().zip(&spectrum.errors) {
            assert!((z.re + 5e-31).abs() <= 1e-12 * 5e-31 + error.re, "{r:e}: {z}");
        }
    }
}

/// Coordinates and time in other units: the same modes.
#[test]
fn modes_do_not_depend_on_units() {
    let m = symmetric([[2.0, 0.3, 0.1], [0.0, 1.0, 0.2], [0.0, 0.0, 3.0]]);
    let k = symmetric([[3.0, -1.0, 0.0], [0.0, 3.0, -2.0], [0.0, 0.0, 2.0]]);
    let expected = SmallMotion::new(m.clone(), free::<3>(), k.clone()).unwrap().modes().unwrap();
    for exponents in [[0, 20, -20], [-60, 60, 0], [30, 31, 90]] {
        let units = DMatrix::from_diagonal(&DVector::from_fn(3, |i, _| 10f64.powi(exponents[i])));
        let turned = |a: &DMatrix<f64>| &units * a * &units;
        let modes = SmallMotion::new(turned(&m), free::<3>(), turned(&k)).unwrap().modes().unwrap();
        for i in 0..3 {
            assert!((modes.frequency(i) / expected.frequency(i) - 1.0).abs() < 1e-14, "{exponents:?}");
            let shape = &units * modes.normalized(i);
            let off = (&shape - expected.normalized(i)).amax().min((shape + expected.normalized(i)).amax());
            assert!(off < 1e-13, "{exponents:?}: {off:e}");
        }
    }
}

/// All points of a trough are equilibria, that are known but for rounding; the second derivative along the trough is
/// of that size.
#[test]
fn neutral_equilibria_that_are_known_to_rounding() {
    for i in 0..300 {
        let angle = match i {
            0..150 => f64::from(i) * 0.0628,
            _ => 10f64.powf(-0.15 * f64::from(i - 150)),
        };
        let at = State::new(0.0, [angle.cos(), angle.sin()], [0.0, 0.0]);
        let small = SmallMotion::steady(&Trough::new(7.0, 0.0), &at).unwrap();
        let modes = small.modes().unwrap();
        assert_eq!([modes.kind(0), modes.kind(1)], [ModeKind::Rigid, ModeKind::Vibration], "{angle:e}");
        assert!((modes.squares()[1] / 14.0 - 1.0).abs() < 1e-14);
        assert!(matches!(small.energy_criterion(), Ok(Stability::Neutral { .. })));
        // With friction it stays where it is put: the zero is simple.
        let spectrum = SmallMotion::steady(&Trough::new(7.0, 0.3), &at).unwrap().spectrum().unwrap();
        let zeros = spectrum.eigenvalues.iter().filter(|z| **z == Complex::new(0.0, 0.0)).count();
        assert_eq!(zeros, 1, "{angle:e}: {:?}", spectrum.eigenvalues);
        assert!(spectrum.is_stable());
    }
}

/// `x = (K − ω²M + iωC)⁻¹ f` in units in which the stiffnesses differ by 1e40.
#[test]
fn responses_do_not_depend_on_units() {
    let k = symmetric([[5.0, -2.0], [0.0, 2.0]]);
    let force = DVector::from_vec(vec![Complex::new(1.0, 0.0), Complex::new(0.0, 0.5)]);
    let response = |unit: f64, omega: f64| {
        let units = DMatrix::from_diagonal(&DVector::from_vec(vec![1.0, unit]));
        let turned = |a: &DMatrix<f64>| &units * a * &units;
        let small = SmallMotion::new(turned(&DMatrix::identity(2, 2)), free::<2>(), turned(&k))?;
        let force = DVector::from_vec(vec![force[0], force[1] * unit]);
        small.frequency_response(omega, &force).map(|x| [x[0], x[1] * unit])
    };
    let expected = response(1.0, 1.7).unwrap();
    for unit in [1e-20, 1e-9, 1e9, 1e20] {
        let found = response(unit, 1.7).unwrap();
        assert!((0..2).all(|i| (found[i] - expected[i]).norm() < 1e-14), "{unit:e}");
        // λ² − 7λ + 6 = 0: the frequencies are 1 and √6.
        assert_eq!(response(unit, 1.0), Err(AnalysisError::Resonance { omega: 1.0 }));
    }
}

#[test]
fn inertia_must_be_definite() {
    for rows in [[[1.0, 1.0], [0.0, 1.0]], [[1.0, 0.0], [0.0, 0.0]], [[1.0, 2.0], [0.0, 1.0]]] {
        let error = SmallMotion::new(symmetric(rows), free::<2>(), DMatrix::identity(2, 2)).unwrap_err();
        assert!(matches!(error, AnalysisError::Inertia { .. }), "{error}");
    }
}
