//! Eigenvalues of random linear systems against 600 digits.

#[path = "spectra/exact.rs"]
mod exact;
#[path = "spectra/systems.rs"]
mod systems;

use lagrange_runtime::analysis::*;
use systems::{FAMILIES, Random, System};

/// How far the eigenvalues of one system are off.
#[derive(Default)]
struct Found {
    roots: usize,
    /// Largest relative error of a root whose bound is below 1e-10 of it.
    worst: f64,
    /// Roots whose bound is larger, and the largest part of its bound that such a root is off by.
    lost: usize,
    part: f64,
    unlike: Vec<String>,
}

/// Each root beside the exact one that it stands for.
fn compare(name: &str, seed: u64, system: &System, found: &mut Found) {
    let System { m, c, k } = system;
    let spectrum = match SmallMotion::new(m.clone(), c.clone(), k.clone()).and_then(|small| small.spectrum())
    {
        Ok(spectrum) => spectrum,
        Err(error) => return found.unlike.push(format!("{name} {seed}: {error}")),
    };
    let mut exact = exact::roots(m, c, k, &spectrum.eigenvalues);
    let mut pairs = Vec::new();
    // The surest ones first: what is close by chance is left for the others.
    let mut order: Vec<usize> = (0..exact.len()).collect();
    order.sort_by(|&a, &b| spectrum.errors[a].norm().total_cmp(&spectrum.errors[b].norm()));
    for i in order {
        let value = spectrum.eigenvalues[i];
        let place = (0..exact.len())
            .min_by(|&a, &b| exact[a].off(value).norm().total_cmp(&exact[b].off(value).norm()));
        pairs.push((i, exact.swap_remove(place.expect("as many"))));
    }
    for (i, exact) in pairs {
        let (value, bound) = (spectrum.eigenvalues[i], spectrum.errors[i]);
        let off = exact.off(value);
        let relative = off.norm() / exact.norm();
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
}

fn random_systems(count: u64) {
    println!("{:14} {:>7} {:>9} {:>7} {:>9}", "", "roots", "error", "lost", "of bound");
    let mut unlike = Vec::new();
    for (family, make) in FAMILIES {
        let mut found = Found::default();
        for seed in 0..count {
            compare(family, seed, &make(&mut Random::new(seed)), &mut found);
        }
        let Found { roots, worst, lost, part, .. } = found;
        println!("{family:14} {roots:7} {worst:9.1e} {lost:7} {part:9.1e}");
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
