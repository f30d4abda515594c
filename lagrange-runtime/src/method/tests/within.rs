//! The errors of interpolants beside those of the steps: the table of the module `method`.

use super::digits::Kepler;
use crate::controller::{Controller, Pi};
use crate::integrate::integrate;
use crate::method::{Dense, Method};
use crate::reference::KeplerOrbit;
use crate::*;

const ECCENTRICITY: f64 = 0.3;

/// The largest error within steps over that at their ends, on an orbit of Kepler's problem: of a run of 10 units of time, and of its steps,
/// each begun on the orbit.
fn ratios<M, C>(method: M, controller: C) -> [f64; 2]
where
    M: Method<Kepler, 2> + Copy,
    C: Controller<f64, 2, M::Error>,
{
    let system = Kepler::new();
    let speed = ((1.0 + ECCENTRICITY) / (1.0 - ECCENTRICITY)).sqrt();
    let orbit = KeplerOrbit::from_cartesian(1.0, [1.0 - ECCENTRICITY, 0.0], [0.0, speed]).unwrap();
    let exact = |t: f64| {
        let (q, qd) = orbit.cartesian(t);
        State::new(t, q, qd)
    };
    let missed = |state: &State<f64, 2>| {
        let difference = state.minus(&exact(state.t));
        difference.q.norm().max(difference.qd.norm())
    };
    let run = integrate(&system, method, controller, exact(0.0)).until(10.0);
    // Of the run and of its steps alone: errors within steps, and at their ends.
    let mut errors = [[0.0f64; 2]; 2];
    let mut see = |which: usize, step: &Step<Kepler, M, 2>| {
        let dense = method.dense(&system, step);
        let within = (1..16).map(|k| missed(&dense.at(step.from.t + step.h * f64::from(k) / 16.0)));
        let [inside, end] = &mut errors[which];
        (*inside, *end) = (within.fold(*inside, f64::max), end.max(missed(&step.to)));
    };
    for step in run {
        let step = step.unwrap();
        see(0, &step);
        let from = exact(step.from.t);
        let memory = method.start(&system, &from).unwrap();
        see(1, &method.step(&system, &memory, &from, step.h, &mut memory.clone()).unwrap());
    }
    errors.map(|[inside, end]| inside / end)
}

#[test]
fn errors_within_steps_are_those_of_the_table() {
    const TOLERANCE: f64 = 1e-10;
    let mut wrong = Vec::new();
    let mut check = |name: &str, found: [f64; 2], table: [f64; 2]| {
        println!("| `{name}` | {:.2} | {:.2} |", found[0], found[1]);
        if (0..2).any(|i| !(0.8..1.25).contains(&(found[i] / table[i]))) {
            wrong.push(format!("{name}: {found:?} for {table:?}"));
        }
    };
    let pi = || Pi::tolerance(TOLERANCE);
    check("DormandPrince5", ratios(DormandPrince5, pi()), [1.0, 35.0]);
    check("Tsitouras5", ratios(Tsitouras5, pi()), [1.0, 27.0]);
    check("Dop853", ratios(Dop853, pi()), [2.3, 17.0]);
    check("Verner9", ratios(Verner9, pi()), [1.0, 6.9]);
    check("Nystrom6", ratios(Nystrom6, pi()), [1.2, 150.0]);
    check("Nystrom8", ratios(Nystrom8, pi()), [8.2, 510.0]);
    check("Nystrom12", ratios(Nystrom12, pi()), [7900.0, 65000.0]);
    check("Radau5", ratios(Radau5, pi()), [7.7, 15000.0]);
    check("Rodas4", ratios(Rodas4, pi()), [1.3, 150.0]);
    check("Rodas5P", ratios(Rodas5P, pi()), [1.0, 27.0]);
    let taylor = Taylor::with_tolerance(TOLERANCE);
    check("Taylor", ratios(taylor, Decay::tolerance(TOLERANCE)), [1.0, 0.31]);
    assert!(wrong.is_empty(), "{wrong:#?}");
}
