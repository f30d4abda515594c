//! Systems without small vibrations, and the errors that say so.

use crate::systems::{DoublePendulum, Follower, Gust, Polar, Pulsed, Shaken};
use lagrange_runtime::analysis::*;
use lagrange_runtime::prelude::*;

lagrangian! {
    /// Nothing holds it.
    pub system Falling {
        param g = 9.81;
        coord y;
        T = 0.5 * dot(y).powi(2);
        V = g * y;
    }
}

lagrangian! {
    /// Kinetic energy of either sign.
    pub system Indefinite {
        param k;
        coord a, b;
        L = 0.5 * dot(a).powi(2) - 0.5 * dot(b).powi(2) - 0.5 * k * (a.powi(2) + b.powi(2));
    }
}

#[test]
fn no_equilibrium_and_the_nearest_one() {
    let pendulum = DoublePendulum::new(0.7, 0.4, 0.8, 0.6, 9.81);
    let error = small_vibrations(&pendulum, &[0.1, 0.2]).unwrap_err();
    let AnalysisError::NotEquilibrium { residual, coordinate, nearest: Some(nearest) } = &error else {
        panic!("{error}")
    };
    assert!((residual - 1.1 * 9.81 * 0.8 * 0.1f64.sin()).abs() < 1e-12 && coordinate.index == 0);
    assert!(nearest.iter().all(|q| q.abs() < 1e-12));
    assert!(error.to_string().contains("the nearest one found is at ["));
    let error = small_vibrations(&Falling::default(), &[0.0]).unwrap_err();
    assert!(matches!(error, AnalysisError::NotEquilibrium { nearest: None, .. }), "{error}");
    assert_eq!(equilibria(&Falling::default(), &[0.0], &[1.0], 5).unwrap(), []);
}

#[test]
fn singular_and_indefinite_inertia() {
    let error = small_vibrations(&Polar::new(1.0), &[0.0, 0.0]).unwrap_err();
    assert!(matches!(error, AnalysisError::Inertia { coordinate, .. } if coordinate.index == 1), "{error}");
    let error = small_vibrations(&Indefinite::new(1.0), &[0.0, 0.0]).unwrap_err();
    assert!(
        matches!(error, AnalysisError::Inertia { coordinate, eigenvalue } if coordinate.index == 1 && eigenvalue < 0.0),
        "{error}"
    );
}

#[test]
fn a_shaken_pivot_has_no_small_vibrations() {
    let error = small_vibrations(&Shaken::new(0.02, 30.0), &[0.0]).unwrap_err();
    assert!(matches!(error, AnalysisError::TimeDependent), "{error}");
    // A pulse that vanishes at most times, and forces that differ from 0 nowhere near the start.
    assert_eq!(small_vibrations(&Pulsed::default(), &[0.0]), Err(AnalysisError::TimeDependent));
    assert_eq!(equilibria(&Gust::default(), &[-1.0], &[1.0], 5), Err(AnalysisError::TimeDependent));
    assert_eq!(equilibrium(&Ramp::default(), &[0.0]), Err(AnalysisError::TimeDependent));
}

/// None found in a box that is none would read as if there were none.
#[test]
fn senseless_boxes_and_frequencies() {
    for [low, high] in [[1.0, -1.0], [f64::NAN, 1.0], [0.0, f64::INFINITY]] {
        let found = equilibria(&Shaken::new(0.0, 30.0), &[low], &[high], 5);
        assert!(found.is_err(), "{found:?}");
        let found = equilibria(&Follower::new(0.0), &[low; 2], &[high; 2], 5);
        assert!(matches!(found, Err(AnalysisError::NotApplicable { .. })), "{found:?}");
    }
    let [m, c, k] = [1.1, 0.5, 7.0].map(|x| DMatrix::from_element(1, 1, x));
    let small = SmallMotion::new(m, c, k).unwrap();
    for omega in [f64::NAN, f64::INFINITY, 1e155] {
        let response = small.frequency_response(omega, &DVector::from_element(1, Complex::new(1.0, 0.0)));
        assert_eq!(response.unwrap_err(), AnalysisError::NotFinite);
    }
}

#[test]
fn follower_forces_have_no_energy_criterion_but_a_spectrum() {
    let at = State::new(0.0, [0.0; 2], [0.0; 2]);
    let small = small_vibrations(&Follower::new(0.3), &[0.0; 2]).unwrap();
    assert_eq!(small.energy_criterion(), Err(AnalysisError::Circulatory { largest: 0.3 }));
    // λ⁴ + 3 λ² + 2 + p² = 0 flutters from p = 1/2 on.
    for (p, stable) in [(0.499, true), (0.501, false)] {
        let small = SmallMotion::steady(&Follower::new(p), &at).unwrap();
        assert_eq!(small.spectrum().unwrap().is_stable(), stable);
        assert!(matches!(small.modes(), Err(AnalysisError::Circulatory { .. })));
    }
}

#[test]
fn resonance_and_wrong_lengths() {
    let [m, c, k] = [1.0, 0.0, 4.0].map(|x| DMatrix::from_element(1, 1, x));
    let small = SmallMotion::new(m.clone(), c, k.clone()).unwrap();
    let force = DVector::from_element(1, Complex::new(1.0, 0.0));
    assert_eq!(small.frequency_response(2.0, &force), Err(AnalysisError::Resonance { omega: 2.0 }));
    let two = DVector::from_element(2, Complex::new(1.0, 0.0));
    let wrong = AnalysisError::Dimension { expected: 1, found: 2 };
    assert_eq!(small.frequency_response(1.0, &two).unwrap_err(), wrong);
    assert_eq!(small.modes().unwrap().normal(&DVector::zeros(2)).unwrap_err(), wrong);
    assert_eq!(SmallMotion::new(m.clone(), DMatrix::zeros(2, 2), k).unwrap_err(), wrong);
    let none = SmallMotion::new(DMatrix::zeros(0, 0), DMatrix::zeros(0, 0), DMatrix::zeros(0, 0));
    assert_eq!(none.unwrap_err(), AnalysisError::Dimension { expected: 1, found: 0 });
    let bad = DMatrix::from_element(1, 1, f64::NAN);
    assert_eq!(SmallMotion::new(m.clone(), m, bad).unwrap_err(), AnalysisError::NotFinite);
}

lagrangian! {
    pub system Ramp {
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = 0.5 * x.powi(2);
        Q[x] = min(max(t - 5, 0), 1);
    }
}

lagrangian! {
    /// `V = a x³ + b x⁵`
    pub system Saddle {
        param a, b;
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = a * x.powi(3) + b * x.powi(5);
    }
}

lagrangian! {
    /// The same beside a spring, with which it is coupled.
    pub system SaddleBeside {
        coord x, y;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = x.powi(3) + 0.5 * y.powi(2) + x.powi(2) * y;
    }
}

lagrangian! {
    /// `V = (x − 1)³`, in whose forces terms cancel.
    pub system Shifted {
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = x.powi(3) - 3 * x.powi(2) + 3 * x;
    }
}

lagrangian! {
    /// `V = x⁴/4 − x²/2`
    pub system TwoWells {
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = x.powi(4) / 4 - x.powi(2) / 2;
    }
}

/// Newton's method ends beside a degenerate equilibrium, where K is small and not 0: its sign says nothing.
#[test]
fn degenerate_equilibria_are_not_stable() {
    let neutral = |found: &Equilibrium<1>| {
        assert!(matches!(found.stability, Stability::Neutral { .. }), "{found:?}");
        assert!(matches!(found.small.energy_criterion(), Ok(Stability::Neutral { .. })), "{found:?}");
    };
    for guess in [0.3, -0.3, 1.7, 1e-10, 1e-150, 0.0] {
        for (a, b) in [(1.0, 0.0), (0.0, 1.0), (1e6, 1.0), (-1e-6, 2.0)] {
            // V = −10⁻⁶ x³ + 2 x⁵ has a second equilibrium, which is stable.
            match equilibrium(&Saddle::new(a, b), &[guess]) {
                Ok(found) if found.q[0].abs() > 1e-5 => {
                    assert_eq!(found.stability.is_stable(), found.q[0] > 0.0, "{found:?}");
                }
                found => neutral(&found.unwrap()),
            }
        }
    }
    for found in equilibria(&Saddle::new(1.0, 0.0), &[-1.0], &[1.0], 20).unwrap() {
        neutral(&found);
    }
    for guess in [0.3, 0.99, 1.2, 2.0] {
        neutral(&equilibrium(&Shifted::default(), &[guess]).unwrap());
    }
    for guess in [[0.3, 0.1], [-0.3, 0.2], [0.4, 0.0]] {
        let found = equilibrium(&SaddleBeside::default(), &guess).unwrap();
        assert!(matches!(found.stability, Stability::Neutral { .. }) || found.q[0].abs() > 1.0, "{found:?}");
    }
    // From 1/2 the first correction leads to the other well exactly: there K has little to do with that at the guess.
    for guess in [0.5, -0.5, 0.9, 1.0] {
        assert!(equilibrium(&TwoWells::default(), &[guess]).unwrap().stability.is_stable());
    }
}
