//! Random functions of time, whose events a dense reference knows.

use super::crossings::{CLOCK, either, on_clock};
use crate::systems::emitted::Wave;
use core::f64::consts::PI;
use lagrange_runtime::prelude::*;

/// Roots of g on [0, end] by 200 places in each step and the extrema between them; `None` where one of them is within
/// rounding of a touch.
fn dense_reference(g: impl Fn(f64) -> f64, h: f64, end: f64) -> Option<Vec<f64>> {
    let n = (end / h * 200.0) as usize;
    let x = |i: usize| end * i as f64 / n as f64;
    let bisected = |mut a: f64, mut b: f64| {
        let before = g(a);
        while b - a > 1e-15 * end {
            let middle = 0.5 * (a + b);
            if middle <= a || middle >= b {
                break;
            }
            if g(middle) * before > 0.0 { a = middle } else { b = middle }
        }
        0.5 * (a + b)
    };
    let mut roots = vec![];
    let mut at = 0.0;
    for i in 1..=n {
        let next = x(i);
        // The lowest |g| between the neighbours, where both have one sign and |g| falls from both.
        if g(at) * g(next) > 0.0 {
            let (side, d) = (g(at).signum(), 1e-3 * (next - at));
            if side * (g(at + d) - g(at)) >= 0.0 || side * (g(next - d) - g(next)) >= 0.0 {
                at = next;
                continue;
            }
            let (mut a, mut b) = (at, next);
            for _ in 0..60 {
                let [u, v] = [1.0, 2.0].map(|k| a + (b - a) * k / 3.0);
                if side * g(u) < side * g(v) { b = v } else { a = u }
            }
            let low = 0.5 * (a + b);
            if g(low).abs() < 1e-9 {
                return None;
            }
            if side * g(low) < 0.0 {
                roots.extend([bisected(at, low), bisected(low, next)]);
            }
        } else {
            roots.push(bisected(at, next));
        }
        at = next;
    }
    Some(roots)
}

/// Random functions that vary within a step by up to a whole wave, with kinks, pairs of roots, near misses, and roots
/// near both ends of the run and at kinks, against a dense reference: closures, and the same compiled.
fn random_events(seed: u64, trials: u32) {
    let mut seed = seed;
    let mut random = || {
        seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (seed >> 11) as f64 / (1u64 << 53) as f64
    };
    let (mut compared, mut found, mut hidden) = (0, 0, 0);
    for trial in 0..trials {
        let (h, end) = (0.2 + random(), 4.0);
        let omega = 2.0 * PI / h * random();
        let (phase, tilt) = (2.0 * PI * random(), random() - 0.5);
        let (vertex, bend) = (end * random(), 2.0 * random() - 1.0);
        let kink = if trial % 4 == 0 { (end * random(), 2.0 * random() - 1.0) } else { (0.0, 0.0) };
        let plain = |t: f64| {
            (omega * t + phase).sin() + tilt * t + bend * (t - vertex).powi(2) + kink.1 * (t - kink.0).abs()
        };
        // Zero is shifted to just above or below a value on the way, or to anywhere.
        let level = match trial % 6 {
            0 => plain(end * random()),
            1 => plain(10f64.powf(-8.0 * random())),
            2 => plain(end - 10f64.powf(-8.0 * random())),
            4 if trial % 4 == 0 => plain(kink.0),
            _ => {
                let middle = end * random();
                let places = (0..400).map(|k| plain(middle + h * (f64::from(k) / 400.0 - 0.5)));
                let low = places.fold(f64::INFINITY, f64::min);
                low + 10f64.powf(-7.0 * random()) * if random() < 0.5 { 1.0 } else { -1.0 }
            }
        };
        let g = |t: f64| plain(t) - level;
        let steps = (end / h).ceil();
        let Some(roots) = dense_reference(g, end / steps, end) else { continue };
        let closure = on_clock(end / steps, end, either(&|s: &State<f64, 1>| g(s.t))).unwrap();
        let system = Wave::new(omega, phase, tilt, vertex, bend, kink.0, kink.1, level);
        let run = integrate(&system, Rk4, FixedStep::new(end / steps), CLOCK).until(end);
        let compiled = run.events(Wave::WAVE).map(|event| event.map(|event| event.state.t));
        let compiled = compiled.collect::<Result<Vec<f64>, _>>().unwrap();
        let closure: Vec<f64> = closure.into_iter().map(|seen| seen.1).collect();
        // The first one ends a run.
        let run = integrate(&system, Dop853, FixedStep::new(end / steps), CLOCK).until(end);
        let of_state = |s: &State<f64, 1>| g(s.t);
        let mut terminal = run.events(either(&of_state).terminal());
        let first = terminal.next().map(|event| event.unwrap().state.t);
        compared += 1;
        found += closure.len();
        let same = |seen: &[f64]| {
            seen.len() == roots.len() && seen.iter().zip(&roots).all(|(a, b)| (a - b).abs() < 1e-6)
        };
        // The assumption of the search: no part has a pair of roots without a minimum of |g| at one of its borders, nor
        // two pairs.
        let part = end / steps / 8.0;
        let lowest = |k: f64| {
            // The search does not look beyond the run.
            if k < 0.5 || k > 8.0 * steps - 0.5 {
                return false;
            }
            let [before, here, after] = [k - 1.0, k, k + 1.0].map(|k| g(k * part));
            before * here > 0.0 && here * after > 0.0 && here.abs() < before.abs().min(after.abs())
        };
        let borders = roots.windows(2).map(|pair| (pair[0] / part).floor()..=(pair[1] / part).floor());
        let covered = !borders
            .into_iter()
            .any(|b| b.start() == b.end() && !lowest(*b.start()) && !lowest(b.end() + 1.0));
        let covered =
            covered && roots.windows(4).all(|four| (four[0] / part).floor() < (four[3] / part).floor());
        if !covered && closure.len().max(compiled.len()) < roots.len() {
            hidden += 1;
            continue;
        }
        assert!(
            same(&closure)
                && same(&compiled)
                && first.map_or(roots.is_empty(), |t| (t - roots[0]).abs() < 1e-6),
            "{trial}: {closure:?}, {compiled:?} and {first:?} not {roots:?}: omega {omega} phase {phase} tilt {tilt} vertex {vertex} bend {bend} kink {kink:?} level {level} steps {steps}"
        );
    }
    println!("{compared} of {trials} compared, {found} roots; {hidden} with pairs in one part");
    assert!(compared > trials / 2 && hidden <= 1 + trials / 1000);
}

/// A pair of roots in one part of a step beside a minimum of |g| at its border, from which g rises less than it falls
/// to the crossing after it, or beside a kink: no convex function through the borders would come down to zero.
#[test]
fn a_pair_beside_a_crossing_that_bends_g() {
    let roots_of = |system: &Wave, steps: f64| -> Vec<f64> {
        let run = integrate(system, Rk4, FixedStep::new(4.0 / steps), CLOCK).until(4.0);
        run.events(Wave::WAVE).map(|event| event.unwrap().state.t).collect()
    };
    let same = |found: &[f64], roots: &[f64]| {
        assert!(
            found.len() == roots.len() && found.iter().zip(roots).all(|(a, b)| (a - b).abs() < 1e-12),
            "{found:?} not {roots:?}"
        );
    };
    let system = Wave::new(
        5.014937999227226,
        2.4361675198032446,
        0.25512834771094006,
        3.832464966700323,
        0.8495432741920284,
        0.0,
        0.0,
        8.17763721903388,
    );
    same(&roots_of(&system, 9.0), &[0.744056792423121, 0.7490136798902454, 0.8491102142355458]);
    let system = Wave::new(
        1.0139773186510146,
        2.906925530699855,
        -0.03991445288614237,
        2.742898940475728,
        -0.08390371231959493,
        2.4500102189031048,
        -0.7153337757016323,
        -0.8833430533080071,
    );
    same(&roots_of(&system, 6.0), &[2.4499936815882197, 2.450334725314662, 2.6908753502809883]);
}

#[test]
fn random_events_against_a_dense_reference() {
    random_events(1, if cfg!(feature = "long") { 2000 } else { 200 });
}

#[test]
#[ignore = "minutes"]
fn a_million_random_events() {
    random_events(
        std::env::var("LAGRANGE_SEED").map_or(7, |seed| seed.parse().expect("a number")),
        1_000_000,
    );
}
