//! The top of section 11.12.4, and other steady motions.

use crate::reference::{Reference, close};
use crate::systems::{Top, UprightTop};
use lagrange_runtime::analysis::*;
use lagrange_runtime::prelude::*;

const TOLERANCE: f64 = 1e-12;

fn reference() -> (Reference, Top<f64>) {
    let reference = Reference::read("sec-11.12.4-symmetric-top");
    let p = |name: &str| reference.parameter(name);
    let top = Top::new(p("m"), p("g"), p("l"), p("I1"), p("I3"));
    (reference, top)
}

/// (11.79t), (11.79x): both rates, and the nutation of small disturbances, each above its threshold (11.79u).
#[test]
fn both_steady_precessions_and_their_nutation() {
    let (reference, top) = reference();
    let theta = reference.special("/steady_precession/theta0");
    let q = [0.0, theta, 0.0];
    for case in reference.0["special"]["steady_precession"]["cases"].as_array().unwrap() {
        let number = |name: &str| case[name].as_f64().unwrap();
        let spin = top.I3 * number("omega3");
        let reduced = Reduced::new(&top, &[0.0, spin]).unwrap();
        let both = reduced.steady_rates(&q, 0).unwrap();
        assert_eq!(both.len(), 2);
        let steady = &both[usize::from(case["branch"] == "fast")];
        close(steady.at.qd[0], number("phidot0"), TOLERANCE);
        close(steady.at.qd[2], number("psidot0"), TOLERANCE);
        close(steady.small.stiffness()[(0, 0)], number("d2V_11_79y"), TOLERANCE);
        close(steady.small.modes().unwrap().frequency(0), number("nutation_frequency_11_79x"), TOLERANCE);
        assert!(steady.small.energy_criterion().unwrap().is_stable());
        // The same motion from its momenta.
        let p = top.momenta(&steady.at.q, &steady.at.qd, 0.0);
        close(p[0], number("beta"), TOLERANCE);
        let again = Reduced::new(&top, &[p[0], p[2]]).unwrap().steady(&[0.0, theta + 0.01, 0.0]).unwrap();
        assert!((again.at.q[1] - theta).abs() < 1e-11, "{}", again.at.q[1]);
    }
}

#[test]
fn the_threshold_of_steady_precession() {
    let (reference, top) = reference();
    let theta = reference.special("/steady_precession/theta0");
    let critical = reference.special("/steady_precession/omega3_critical/value");
    let q = [0.0, theta, 0.0];
    let reduced = |omega: f64| Reduced::new(&top, &[0.0, top.I3 * omega]).unwrap();
    let found = reduced(100.0).thresholds(&q, 0, 2).unwrap();
    assert_eq!(found.len(), 2);
    close(found[1] / top.I3, critical, TOLERANCE);
    close(found[0] / top.I3, -critical, TOLERANCE);
    let below = reduced(critical * (1.0 - 1e-9)).steady_rates(&q, 0).unwrap_err();
    assert!(matches!(below, AnalysisError::NoSteadyMotion { discriminant } if discriminant < 0.0));
    let above = reduced(critical * (1.0 + 1e-9)).steady_rates(&q, 0).unwrap();
    let at_threshold = reference.special("/steady_precession/phidot_critical_11_79v/2 mgl~1(I3 w3c)");
    close(above[0].at.qd[0], at_threshold, 1e-4);
    // A gyroscopic pendulum has both rates at every spin.
    let theta = reference.special("/gyroscopic_pendulum_precession/theta0");
    let hanging = reduced(reference.special("/gyroscopic_pendulum_precession/omega3"));
    assert!(hanging.thresholds(&[0.0, theta, 0.0], 0, 2).unwrap().is_empty());
    let both = hanging.steady_rates(&[0.0, theta, 0.0], 0).unwrap();
    close(both[0].at.qd[0], reference.special("/gyroscopic_pendulum_precession/phidot_minus"), TOLERANCE);
    close(both[1].at.qd[0], reference.special("/gyroscopic_pendulum_precession/phidot_plus"), TOLERANCE);
    // With its axis level there is one, exactly m g l/(I₃ ω₃).
    let level = reduced(reference.special("/theta_half_pi/omega3"));
    let rates = level.steady_rates(&[0.0, std::f64::consts::FRAC_PI_2, 0.0], 0).unwrap();
    close(rates[0].at.qd[0], reference.special("/theta_half_pi/phidot0"), TOLERANCE);
}

#[test]
fn turning_points_of_the_nutation() {
    let (reference, top) = reference();
    for case in reference.0["special"]["nutation"].as_array().unwrap() {
        let number = |name: &str| case[name].as_f64().unwrap();
        let start = State::new(
            0.0,
            [0.0, number("theta0"), 0.0],
            [number("phidot0"), number("thetadot0"), number("psidot0")],
        );
        let p = top.momenta(&start.q, &start.qd, 0.0);
        let reduced = Reduced::new(&top, &[p[0], p[2]]).unwrap();
        let energy = top.energy(&start.q, &start.qd, 0.0);
        let found = reduced.turning_points(energy, 0.1, 3.0).unwrap();
        let expected: Vec<f64> =
            case["turning_points"].as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect();
        assert_eq!(found.len(), 2, "{found:?}");
        for (found, expected) in found.iter().zip(expected) {
            close(*found, expected, TOLERANCE);
        }
    }
}

/// (11.79z) in coordinates that are regular upright. The potential energy is at its maximum: gyroscopic forces hold it.
#[test]
fn the_sleeping_top() {
    let (reference, top) = reference();
    let upright = UprightTop::new(top.m, top.g, top.l, top.I1, top.I3);
    let small = |omega: f64| {
        let reduced = Reduced::new(&upright, &[upright.I3 * omega])?;
        Ok::<_, AnalysisError>(reduced.steady(&[0.0; 3])?.small)
    };
    let limit = reference.special("/sleeping_top_11_79z/omega3_sleeping_limit/value");
    close(stability_threshold(small, 50.0, 200.0).unwrap(), limit, TOLERANCE);
    assert!(matches!(stability_threshold(small, 150.0, 200.0), Err(AnalysisError::NotApplicable { .. })));
    for case in reference.0["special"]["sleeping_top_11_79z"]["cases"].as_array().unwrap() {
        let small = small(case["omega3"].as_f64().unwrap()).unwrap();
        let spectrum = small.spectrum().unwrap();
        assert!(!small.energy_criterion().unwrap().is_stable());
        assert!(matches!(small.modes(), Err(AnalysisError::Gyroscopic { .. })));
        assert_eq!(spectrum.is_stable(), case["stable"].as_bool().unwrap());
        match case["eigenfrequencies_in_ground_frame"].as_array() {
            Some(digits) => {
                let [fast, slow] = [0, 1].map(|k| digits[k].as_f64().unwrap());
                close(spectrum.frequencies()[0], slow, TOLERANCE);
                close(spectrum.frequencies()[1], fast, TOLERANCE);
            }
            None => close(spectrum.growth(), case["growth_rate"].as_f64().unwrap(), TOLERANCE),
        }
    }
    // Exercise 11.10: hanging, it is stable at every spin.
    for omega in [0.0, 1.0, 60.0] {
        let hanging = Reduced::new(&upright, &[upright.I3 * omega]).unwrap();
        let small = hanging.steady(&[std::f64::consts::PI, 0.0, 0.0]).unwrap().small;
        assert!(small.energy_criterion().unwrap().is_stable() && small.spectrum().unwrap().is_stable());
    }
}

#[test]
fn what_has_no_steady_motion_is_refused() {
    let (_, top) = reference();
    let few = Reduced::new(&top, &[1.0]).unwrap_err();
    assert_eq!(few, AnalysisError::Dimension { expected: 2, found: 1 });
    let none = crate::systems::Metronome::new(1.0, 1.0, 1.0, 1.0, 1.0, 1.0);
    assert!(matches!(Reduced::new(&none, &[]).unwrap_err(), AnalysisError::NotApplicable { .. }));
    let pole = Reduced::new(&top, &[0.1, 0.2]).unwrap().state(&[0.0; 3]).unwrap_err();
    assert!(matches!(pole, AnalysisError::Inertia { .. }), "{pole}");
    let reduced = Reduced::new(&top, &[0.1, 0.2]).unwrap();
    assert!(matches!(reduced.steady_rates(&[0.0, 1.0, 0.0], 1), Err(AnalysisError::NotApplicable { .. })));
    assert!(matches!(reduced.thresholds(&[0.0, 1.0, 0.0], 0, 0), Err(AnalysisError::NotApplicable { .. })));
}
