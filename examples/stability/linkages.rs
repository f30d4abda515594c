//! Linkages with more conditions than they need, and some that pass positions in which theirs are dependent. All have
//! one freedom, a: energy gives the time at which it has a value.

// (Others are of the tests alone.)
#[allow(dead_code)]
#[path = "../../tests/motions/linkages/systems.rs"]
mod systems;

use super::{ROLLS, Row, Scene, energy, through_the_line};
use lagrange_runtime::prelude::*;
use nalgebra::SVector;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use systems::{Bennett, FourCranks, GuidedScissors, Sarrus, Scissors, SliderCrank, ThreeCranks, TwelveLoops};

pub fn rows() -> Vec<Row> {
    let mut rows = vec![];
    macro_rules! scenes {
        ($($scene:ident $cells:ident;)*) => {$({
            let scene = $scene(0.0);
            rows.push(scene.row(scene.$cells()));
        })*};
    }
    // (Redundant constraints have no series.)
    scenes! {
        three_cranks by_accelerations;
        four_cranks by_accelerations;
        twelve_loops few;
        slider_crank explicit;
        bennett by_accelerations;
        sarrus by_accelerations;
        scissors few;
        guided_scissors few;
    }
    rows
}

/// A parallelogram with a crank more than it needs.
pub fn three_cranks(u: f64) -> Scene<ThreeCranks, 4> {
    let start = upright(3, u);
    through_the_line("linkage of three cranks through the line", ThreeCranks::new(), start, 1.25, |a| {
        SVector::from([a, a, a, 0.0])
    })
}

pub fn four_cranks(u: f64) -> Scene<FourCranks, 5> {
    let start = upright(4, u);
    through_the_line("linkage of four cranks through the line", FourCranks::new(), start, 9.0 / 7.0, |a| {
        SVector::from([a, a, a, a, 0.0])
    })
}

/// Twelve parallelograms side by side, whose 24 constraints become dependent together.
pub fn twelve_loops(u: f64) -> Scene<TwelveLoops, 25> {
    let (start, share) = (upright(13, u), 111.0 / 98.0);
    through_the_line("twelve parallelograms through the line", TwelveLoops::new(), start, share, |a| {
        SVector::from_fn(|i, _| if i < 13 { a } else { 0.0 })
    })
}

/// The first `cranks` coordinates stand upright and turn.
fn upright<const N: usize>(cranks: usize, u: f64) -> State<f64, N> {
    let first = |value: f64| SVector::from_fn(|i, _| if i < cranks { value } else { 0.0 });
    State { t: 0.0, q: first(FRAC_PI_2), qd: first(-1.0 - 0.1 * u) }
}

/// Over its dead centres five times.
pub fn slider_crank(u: f64) -> Scene<SliderCrank, 2> {
    let along = |phi: f64| {
        let psi = (0.3 * phi.sin() / 0.8f64).asin();
        ([phi, psi], [1.0, 0.3 * phi.cos() / (0.8 * psi.cos())])
    };
    one_freedom("slider-crank over its dead centres", SliderCrank::new(), along, [0.5, 14.5], 7.0 + u)
}

/// With `tan t₁/2 tan t₂/2 = sin (α + β)/2 / sin (β − α)/2` (Bennett 1914).
pub fn bennett(u: f64) -> Scene<Bennett, 3> {
    let along = |t: f64| {
        let (alpha, beta) = (0.6f64, 1.1f64);
        let ratio = (0.5 * (alpha + beta)).sin() / (0.5 * (beta - alpha)).sin();
        let other = 2.0 * (ratio / (0.5 * t).tan()).atan() - TAU * (t / TAU).floor();
        let rate = -other.sin() / t.sin();
        ([t, other, -other], [1.0, rate, -rate])
    };
    one_freedom("Bennett's linkage", Bennett::new(), along, [0.7, 9.0], 6.0 + u)
}

pub fn sarrus(u: f64) -> Scene<Sarrus, 6> {
    let along = |a: f64| ([a, PI - a, 0.0, a, PI - a, 0.0], [1.0, -1.0, 0.0, 1.0, -1.0, 0.0]);
    one_freedom("Sarrus' linkage", Sarrus::new(), along, [1.2, 0.3], -0.5 - 0.1 * u)
}

/// All bars at the angle a, the slider at cos a.
fn lifted(a: f64) -> ([f64; 13], [f64; 13]) {
    let (mut q, mut slope) = ([a; 13], [1.0; 13]);
    (q[0], slope[0]) = (a.cos(), -a.sin());
    (q, slope)
}

pub fn scissors(u: f64) -> Scene<Scissors, 13> {
    one_freedom("scissors lift of six stages", Scissors::new(), lifted, [0.4, 1.0], 3.0 + 0.1 * u)
}

pub fn guided_scissors(u: f64) -> Scene<GuidedScissors, 13> {
    let name = "scissors lift with 7 conditions too many";
    one_freedom(name, GuidedScissors::new(), lifted, [0.4, 1.0], 3.0 + 0.1 * u)
}

/// From one angle to another, as `½ m(a) ȧ² + V(a)` stays what it is at the start, m and V being those of the system
/// along its positions and their slopes by the angle.
fn one_freedom<Sys: Energies<N, Scalar = f64> + Copy + 'static, const N: usize>(
    name: &str,
    system: Sys,
    along: fn(f64) -> ([f64; N], [f64; N]),
    [from, to]: [f64; 2],
    rate: f64,
) -> Scene<Sys, N> {
    let energies = |a: f64| {
        let (q, slope) = along(a);
        let potential = system.energy_at(&State::new(0.0, q, [0.0; N]));
        (system.energy_at(&State::new(0.0, q, slope)) - potential, potential)
    };
    let (inertia, potential) = energies(from);
    let sum = inertia * rate * rate + potential;
    let slowness = |a: f64| {
        let (inertia, potential) = energies(a);
        (inertia / (sum - potential)).sqrt()
    };
    let (q, slope) = along(from);
    let start = State::new(0.0, q, slope.map(|slope| rate * slope));
    let exact = SVector::from(along(to).0);
    let end = quadrature(slowness, from, to).abs();
    let kinetic = sum - energies(to).1;
    Scene {
        name: name.into(),
        truth: "quadrature of the energy",
        system,
        start,
        end,
        h: 0.002 * end,
        tolerance: 1e-9,
        bound: 1e-6,
        watch: energy(system, start, kinetic),
        judge: Box::new(move |at, energy| (at.q - exact).amax().max(energy)),
        singular: None,
        expected: ROLLS,
    }
}

/// An integral by Gauss and Legendre's rule of five points on each of 400 parts.
fn quadrature(f: impl Fn(f64) -> f64, from: f64, to: f64) -> f64 {
    let node = |sign: f64| (5.0 + sign * 2.0 * (10f64 / 7.0).sqrt()).sqrt() / 3.0;
    let weight = |sign: f64| (322.0 + sign * 13.0 * 70f64.sqrt()) / 900.0;
    let rule = [(0.0, 128.0 / 225.0), (node(-1.0), weight(1.0)), (node(1.0), weight(-1.0))];
    let half = 0.5 * (to - from) / 400.0;
    let part = |k: i32| {
        let middle = from + f64::from(2 * k + 1) * half;
        let pair = |(x, weight): (f64, f64)| match x == 0.0 {
            true => weight * f(middle),
            false => weight * (f(middle - half * x) + f(middle + half * x)),
        };
        half * rule.map(pair).iter().sum::<f64>()
    };
    (0..400).map(part).sum()
}
