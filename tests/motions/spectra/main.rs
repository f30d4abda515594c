//! Eigenvalues of random linear systems against 600 digits.

mod exact;
mod systems;

use lagrange_runtime::analysis::*;
use nalgebra::{DMatrix, DVector};
use systems::{FAMILIES, Random, System};

/// Errors of the eigenvalues of one system.
#[derive(Default)]
struct Found {
    roots: usize,
    /// Largest relative error of a root whose bound is below 1e-10 of it.
    worst: f64,
    /// Roots whose bound is larger, and the largest part of its bound that such a root is off by.
    lost: usize,
    part: f64,
    /// The part of its bound by which a root moves when the matrices are rounded.
    moved: f64,
    unlike: Vec<String>,
}

/// The rest of `(λ²M + λC + K) x`, in parts of its terms and of what the bound of the error makes of them.
fn residual(System { m, c, k }: &System, spectrum: &Spectrum, i: usize) -> f64 {
    let (root, error, x) = (spectrum.eigenvalues[i], spectrum.errors[i].norm(), &spectrum.shapes[i]);
    let unit = |j: usize| m[(j, j)].sqrt();
    let largest = (0..x.len()).map(|j| x[j].norm() * unit(j)).fold(0.0, f64::max);
    let part = |row: usize| {
        let (mut sum, mut size) = (root * 0.0, 0.0);
        for (j, x) in x.iter().enumerate() {
            let [m, c, k] = [m, c, k].map(|a| a[(row, j)]);
            sum += (root * root * m + root * c + k) * x;
            let terms = (root.norm_sqr() * m).abs() + (root.norm() * c).abs() + k.abs();
            let slope = (2.0 * root.norm() + error) * m.abs() + c.abs();
            size += (16.0 * f64::EPSILON * terms + error * slope) * largest / unit(j);
        }
        if sum.norm() == 0.0 { 0.0 } else { sum.norm() / size }
    };
    (0..x.len()).map(part).fold(0.0, f64::max)
}

/// Each root beside the exact one that it stands for.
fn compare(name: &str, seed: u64, system: &System, found: &mut Found) {
    let System { m, c, k } = system;
    let spectrum = match SmallMotion::new(m.clone(), c.clone(), k.clone()).and_then(|small| small.spectrum())
    {
        Ok(spectrum) => spectrum,
        Err(error) => return found.unlike.push(format!("{name} {seed}: {error}")),
    };
    // The digits of a root 0 are those near 0 at which an iteration ends.
    let largest = spectrum.eigenvalues.iter().map(|root| root.norm()).fold(0.0, f64::max);
    let zero =
        |value: Complex<f64>, exact: &exact::Digits| value.norm() == 0.0 && exact.norm() <= 1e-25 * largest;
    for (i, exact) in pairs(&spectrum, system) {
        let (value, bound) = (spectrum.eigenvalues[i], spectrum.errors[i]);
        let off = exact.off(value);
        let relative = off.norm() / exact.norm();
        let left = residual(system, &spectrum, i);
        if left > 1.0 || !left.is_finite() {
            found.unlike.push(format!("{name} {seed}: the shape of {value} leaves {left:e}"));
        }
        if zero(value, &exact) {
            continue;
        }
        found.roots += 1;
        if bound.norm() <= 1e-10 * exact.norm() {
            found.worst = found.worst.max(relative);
        } else {
            found.lost += 1;
            found.part = found.part.max(off.norm() / bound.norm());
        }
        // What is not rounding of the result is within the bound, part by part.
        let rounding = 2.0 * f64::EPSILON * exact.norm();
        if !(off.re.abs() <= rounding + bound.re && off.im.abs() <= rounding + bound.im) {
            found.unlike.push(format!(
                "{name} {seed}: {value} for {}, off by {off:e}, bound {bound:e}",
                exact.value()
            ));
        }
    }
    // Matrices whose entries differ by 8 roundings have their roots within the bounds.
    let other = system.rounded(&mut Random::new(seed), 8.0 * f64::EPSILON);
    for (i, exact) in pairs(&spectrum, &other) {
        let (value, bound) = (spectrum.eigenvalues[i], spectrum.errors[i]);
        let off = exact.off(value);
        if zero(value, &exact) {
            continue;
        }
        let rounding = 2.0 * f64::EPSILON * exact.norm();
        let part = ((off.re.abs() - rounding) / bound.re).max((off.im.abs() - rounding) / bound.im);
        found.moved = found.moved.max(part);
        if off.norm() > rounding + bound.norm() {
            found.unlike.push(format!(
                "{name} {seed}: {value} moves to {}, by {off:e}, bound {bound:e}",
                exact.value()
            ));
        }
    }
}

/// The exact root of a system for each of a spectrum. The surest ones choose first: what is close by chance is left
/// for the others.
fn pairs(spectrum: &Spectrum, System { m, c, k }: &System) -> Vec<(usize, exact::Digits)> {
    let mut exact = exact::roots(m, c, k, &spectrum.eigenvalues);
    let mut order: Vec<usize> = (0..exact.len()).collect();
    order.sort_by(|&a, &b| spectrum.errors[a].norm().total_cmp(&spectrum.errors[b].norm()));
    let nearest = |i: usize| {
        let off = |j: &usize| exact[*j].off(spectrum.eigenvalues[i]).norm();
        let place = (0..exact.len()).min_by(|a, b| off(a).total_cmp(&off(b)));
        (i, exact.swap_remove(place.expect("as many")))
    };
    order.into_iter().map(nearest).collect()
}

fn random_systems(count: u64) {
    println!("{:14} {:>7} {:>9} {:>7} {:>9} {:>9}", "", "roots", "error", "lost", "of bound", "moved");
    let mut unlike = Vec::new();
    for (family, make) in FAMILIES {
        let mut found = Found::default();
        for seed in 0..count {
            compare(family, seed, &make(&mut Random::new(seed)), &mut found);
        }
        let Found { roots, worst, lost, part, moved, .. } = found;
        println!("{family:14} {roots:7} {worst:9.1e} {lost:7} {part:9.1e} {moved:9.1e}");
        assert!(worst <= 1e-10, "{family}");
        unlike.append(&mut found.unlike);
    }
    assert!(unlike.is_empty(), "{}", unlike.join("\n"));
}

#[test]
fn eigenvalues_of_random_systems() {
    random_systems(12);
}

/// `LAGRANGE_SYSTEMS` of each family.
#[test]
#[ignore = "minutes"]
fn eigenvalues_of_many_random_systems() {
    random_systems(std::env::var("LAGRANGE_SYSTEMS").map_or(200, |count| count.parse().expect("a number")));
}

/// At a root, `P` has a null vector on the left at right angles to that on the right, or a column of zeros; or two
/// roots meet on the real axis to a rounding of which half is imaginary. Roots by hand.
#[test]
fn matrices_of_integers_whose_elimination_meets_zeros() {
    let of = |rows: [&[f64]; 3]| {
        let n = (rows[0].len() as f64).sqrt() as usize;
        let [m, c, k] = rows.map(|row| DMatrix::from_row_slice(n, n, row));
        System { m, c, k }
    };
    let (third, two) = (8f64.sqrt() / 3.0, 2f64.sqrt());
    let cases: [(System, &[f64]); 3] = [
        (of([&[3.0, 0.0, 0.0, 3.0], &[0.0, -1.0, 1.0, 0.0], &[-3.0, 1.0, 1.0, -3.0]]), &[1.0, third]),
        (
            of([
                &[2.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 2.0],
                &[0.0, 0.0, 2.0, 0.0, 0.0, 0.0, -2.0, 0.0, 0.0],
                &[0.0, 0.0, 0.0, 0.0, -3.0, 0.0, 0.0, 0.0, -6.0],
            ]),
            &[3f64.sqrt(), two, 0.0],
        ),
        (
            of([&[2.0, 0.0, 0.0, 3.0], &[0.0, -1.0, 1.0, 0.0], &[-3.0, -1.93e-22, -1.93e-22, -8.0]]),
            &[two, two],
        ),
    ];
    for (system, rates) in &cases {
        let System { m, c, k } = system;
        let spectrum = SmallMotion::new(m.clone(), c.clone(), k.clone()).unwrap().spectrum().unwrap();
        let mut expected: Vec<f64> = rates.iter().flat_map(|x| [-x, *x]).collect();
        let mut found: Vec<f64> = spectrum.eigenvalues.iter().map(|root| root.re).collect();
        [&mut expected, &mut found].into_iter().for_each(|all| all.sort_by(f64::total_cmp));
        assert!(spectrum.eigenvalues.iter().all(|root| root.im == 0.0), "{spectrum}");
        assert!(expected.iter().zip(&found).all(|(a, b)| (a - b).abs() < 1e-15), "{found:?}");
        assert!((0..found.len()).all(|i| residual(system, &spectrum, i) <= 1.0), "{:?}", spectrum.shapes);
    }
}

/// A pair without damping, and two real eigenvalues: −1 and −4.
#[test]
fn spectra_print_as_tables() {
    let diagonal = |a: f64, b: f64| DMatrix::from_diagonal(&DVector::from_vec(vec![a, b]));
    let small = SmallMotion::new(diagonal(1.0, 1.0), diagonal(0.0, 5.0), diagonal(9.0, 4.0)).unwrap();
    let text = small.spectrum().unwrap().to_string();
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines.len(), 3, "{text}");
    let has = |parts: &[&str]| lines.iter().any(|line| parts.iter().all(|part| line.contains(part)));
    assert!(has(&["± 3.000000e0 i", "ζ = +0.000000"]), "{text}");
    assert!(has(&["λ = -1.000000e0", "error ≤"]) && has(&["λ = -4.000000e0"]), "{text}");
}
