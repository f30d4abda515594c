//! Bodies that roll: critical speeds in closed form, and Whipple's bicycle against its published eigenvalues.

use crate::bicycle::{PUBLISHED, benchmark, rides};
use crate::systems::*;
use lagrange_runtime::analysis::*;
use lagrange_runtime::prelude::*;
use std::f64::consts::PI;

/// A wheel that rolls straight is stable from Ω² = (g/r) h/(k (k + 1)) on: g/(3r) of a disk, g/(4r) of a hoop
/// (Neimark and Fufaev 1972, ch. V; O'Reilly, *Nonlinear Dynamics* 10, 1996).
#[test]
fn critical_speeds_of_disks_and_hoops() {
    for (k, h, part) in [(0.5, 0.25, 3.0), (1.0, 0.5, 4.0)] {
        let wheel = Wheel::new(1.3, 0.4, k, h);
        let small = |rate: f64| {
            SmallMotion::steady(&wheel, &State::new(0.0, [0.0; 5], [0.4 * rate, 0.0, 0.0, 0.0, rate]))
        };
        let critical = (9.81 / 0.4 / part).sqrt();
        for rate in [0.3, 0.9, 0.999, 1.001, 1.5, 3.0, 20.0].map(|x: f64| x * critical) {
            let small = small(rate).unwrap();
            assert_eq!(small.constants(), ["y", "theta"]);
            let spectrum = small.spectrum().unwrap();
            // λ² = (g/r)/(h + 1) − Ω² k (k + 1)/(h (h + 1)), and zeros of place, heading and speed.
            let square = 9.81 / 0.4 / (h + 1.0) - rate * rate * k * (k + 1.0) / (h * (h + 1.0));
            let zeros = spectrum.eigenvalues.iter().filter(|z| z.norm() == 0.0).count();
            assert_eq!(zeros, 4, "{spectrum:?}");
            for (z, e) in spectrum.eigenvalues.iter().zip(&spectrum.errors).filter(|(z, _)| z.norm() > 0.0) {
                let exact = Complex::new(square, 0.0).sqrt();
                let off = [exact, -exact]
                    .map(|exact| z - exact)
                    .into_iter()
                    .min_by(|a, b| a.norm().total_cmp(&b.norm()));
                let off = off.unwrap();
                let cancelled = 1e-14 * 9.81 / 0.4 / exact.norm();
                assert!(off.norm() < cancelled + 4e-16 * exact.norm(), "{rate}: {z} {exact} {e}");
            }
            assert_eq!(spectrum.is_stable(), square < 0.0, "{rate} {spectrum:?}");
        }
        let found = stability_threshold(small, 0.5 * critical, 2.0 * critical).unwrap();
        assert!((found / critical - 1.0).abs() < 5e-14, "{found} {critical}");
    }
}

/// Steady rolling on a circle with the lean φ, the heading rate ω and the turn rate Ω. In n = ω cos φ and s = ω sin
/// φ + Ω, and with g for g/r, the equations of Newton and Euler are
/// `(h + 1) φ̈ = −h n² tan φ + (k + 1) n s + g sin φ`, `h ṅ = (h n tan φ − k s) φ̇`, `(k + 1) ṡ = −n φ̇`
/// (Routh, *Advanced Dynamics of Rigid Bodies*, 1905, §244). The place accelerates, which does not matter.
#[test]
fn a_hoop_on_a_circle() {
    let (k, h, r, g) = (1.0, 0.5, 0.4, 9.81);
    let hoop = Wheel::new(1.3, r, k, h);
    let (phi, heading): (f64, f64) = (0.3, 1.7);
    let n = heading * phi.cos();
    let s = (h * n * n * phi.tan() - g / r * phi.sin()) / ((k + 1.0) * n);
    let rate = s - heading * phi.sin();
    let (sin, cos) = 0.2f64.sin_cos();
    let at = State::new(0.0, [0.0, 0.0, 0.2, phi, 0.0], [r * rate * cos, r * rate * sin, heading, 0.0, rate]);
    let accelerations = hoop.accel(&at.q, &at.qd, 0.0);
    assert!(accelerations.rows(2, 3).amax() < 1e-13 && accelerations.norm() > 1.0, "{accelerations}");
    let small = SmallMotion::steady(&hoop, &at).unwrap();
    let by_lean = -h * n * n / phi.cos().powi(2) + g / r * phi.cos();
    let by_n = (-2.0 * h * n * phi.tan() + (k + 1.0) * s) * (n * phi.tan() - k / h * s);
    let square = -(by_lean + by_n - n * n) / (h + 1.0);
    let spectrum = small.spectrum().unwrap();
    let frequencies = spectrum.frequencies();
    assert_eq!((spectrum.eigenvalues.len(), frequencies.len()), (6, 1), "{spectrum:?}");
    assert!((frequencies[0] / square.sqrt() - 1.0).abs() < 1e-14, "{} {square}", frequencies[0]);
    assert_eq!(SmallMotion::about(&hoop, &at).unwrap(), small);
    // Another lean than that of the rates is no steady motion.
    let mut off = at;
    off.q[3] += 0.01;
    let error = SmallMotion::steady(&hoop, &off).unwrap_err();
    assert!(
        matches!(error, AnalysisError::NotEquilibrium { coordinate, .. } if coordinate.index == 3),
        "{error}"
    );
    // It leans over at a rate: the lean acts on the small motions, and has no constant value.
    let mut falls = at;
    falls.qd[3] = 0.1;
    assert!(SmallMotion::steady(&hoop, &falls).is_err() && SmallMotion::about(&hoop, &falls).is_ok());
}

/// The same of disks, in each heading: θ̇ is free, and the place follows, whichever of its components accelerates at
/// the moment.
#[test]
fn a_disk_on_a_circle_in_every_heading() {
    let (k, h, phi, heading, g) = (0.5, 0.25, 0.3f64, 1.0, 9.81);
    for (r, given) in [(0.4, -45.3832), (0.9, -5.5351), (1.1, -2.8960), (3.0, 0.22683)] {
        let disk = Wheel::new(1.3, r, k, h);
        let n = heading * phi.cos();
        let s = (h * n * n * phi.tan() - g / r * phi.sin()) / ((k + 1.0) * n);
        let rate = s - heading * phi.sin();
        let by_lean = -h * n * n / phi.cos().powi(2) + g / r * phi.cos();
        let by_n = (-2.0 * h * n * phi.tan() + (k + 1.0) * s) * (n * phi.tan() - k / h * s);
        let square: f64 = (by_lean + by_n - n * n) / (h + 1.0);
        assert!((square / given - 1.0).abs() < 1e-4, "{square} {given}");
        for psi in [0.0, 0.4, 1.2, PI / 2.0, 3.0f64] {
            let at = State::new(
                0.0,
                [0.3, 0.1, psi, phi, 0.7],
                [r * rate * psi.cos(), r * rate * psi.sin(), heading, 0.0, rate],
            );
            let small = SmallMotion::steady(&disk, &at).unwrap_or_else(|error| panic!("{r} {psi}: {error}"));
            assert_eq!(
                (small.names().len(), small.constants()),
                (3, &["x".to_string(), "y".to_string()][..])
            );
            let spectrum = small.spectrum().unwrap();
            let zeros = spectrum.eigenvalues.iter().filter(|z| z.norm() < 1e-6).count();
            let largest = spectrum.eigenvalues.iter().copied().max_by(|a, b| a.norm().total_cmp(&b.norm()));
            let found = largest.unwrap().powi(2);
            assert!(
                zeros == 4 && (found - square).norm() < 1e-12 * square.abs(),
                "{r} {psi}: {spectrum:?} {square}"
            );
        }
    }
}

#[test]
fn the_bicycle_has_its_published_eigenvalues() {
    let bicycle = benchmark();
    let spectrum = |v: f64| SmallMotion::steady(&bicycle, &rides(v)).unwrap().spectrum().unwrap();
    for (v, [growth, frequency], capsize, castering) in PUBLISHED {
        let found = spectrum(v);
        let weave = Complex::new(growth, frequency);
        for exact in [weave, weave.conj(), Complex::new(capsize, 0.0), Complex::new(castering, 0.0)] {
            let all = found.eigenvalues.iter().zip(&found.errors);
            let (z, error) =
                all.min_by(|a, b| (a.0 - exact).norm().total_cmp(&(b.0 - exact).norm())).unwrap();
            // Fourteen decimals are printed.
            let off = (z - exact).norm();
            assert!(off < 1e-14 + error.norm() && error.norm() < 2e-12, "{v}: {z} {exact} {off:e} {error}");
        }
        assert_eq!(
            found.eigenvalues.iter().filter(|z| z.norm() == 0.0).count(),
            2,
            "speed and place: {found:?}"
        );
    }
    let still = spectrum(0.0);
    for exact in [3.131_643_247_906_56, 5.530_943_717_653_93] {
        for exact in [exact, -exact] {
            let off = still.eigenvalues.iter().map(|z| (z - exact).norm()).fold(f64::INFINITY, f64::min);
            assert!(off < 2e-14, "{exact} {off:e}");
        }
    }
}

/// Weave and capsize speeds, between which the bicycle is stable by itself.
#[test]
fn the_bicycle_is_stable_between_its_published_speeds() {
    let bicycle = benchmark();
    let small = |v: f64| SmallMotion::steady(&bicycle, &rides(v));
    for (low, high, exact) in [(4.0, 5.0, 4.292_382_536_341_11), (5.0, 7.0, 6.024_262_015_388_37)] {
        let found = stability_threshold(small, low, high).unwrap();
        assert!((found - exact).abs() < 1e-12, "{found}");
    }
}
