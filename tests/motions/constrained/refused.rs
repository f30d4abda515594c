//! Each hypothesis of analyses with constraints, violated alone: the error names it.

use crate::systems::*;
use lagrange_runtime::analysis::*;
use lagrange_runtime::prelude::*;

#[test]
fn a_state_beside_the_constraints() {
    let bobs = Bobs::new(0.7, 0.4, 0.8, 0.6, 0.0);
    let (q, off) = ([0.0, -0.8, 0.0, -1.4], [0.0, -0.8, 0.0, -1.4 - 1e-6]);
    let still = [0.0; 4];
    let named = |error: AnalysisError, name: &str| {
        let AnalysisError::OffConstraints { constraint, violation } = &error else { panic!("{error}") };
        assert!(*constraint == name && *violation > 0.0, "{error}");
        assert!(error.to_string().contains("consistent"), "{error}");
    };
    named(small_vibrations(&bobs, &off).unwrap_err(), "lower");
    named(SmallMotion::steady(&bobs, &State::new(0.0, off, still)).unwrap_err(), "lower");
    named(SmallMotion::about(&bobs, &State::new(0.0, off, still)).unwrap_err(), "lower");
    // Its velocities, too.
    named(SmallMotion::steady(&bobs, &State::new(0.0, q, [0.0, 1.0, 0.0, 1.0])).unwrap_err(), "upper");
    let bars = FourBar::new(0.12, 0.32, 0.25, 0.3, 0.4, 0.9, 0.7);
    named(StateSpace::about(&bars, &State::new(0.0, [0.0; 3], [0.0; 3])).unwrap_err(), "pin[0]");
    // A guess may be beside them.
    assert!(equilibrium(&bobs, &off).is_ok());
}

#[test]
fn a_state_that_is_no_equilibrium() {
    let bobs = Bobs::new(0.7, 0.4, 0.8, 0.6, 0.0);
    let (x, y) = (0.8 * 0.1f64.sin(), -0.8 * 0.1f64.cos());
    let error = small_vibrations(&bobs, &[x, y, x, y - 0.6]).unwrap_err();
    let AnalysisError::NotEquilibrium { nearest: Some(nearest), .. } = &error else { panic!("{error}") };
    assert!(nearest[0].abs() < 1e-14 && (nearest[3] + 1.4).abs() < 1e-14, "{error}");
    let at = State::new(0.0, [x, y, x, y - 0.6], [0.0; 4]);
    let error = SmallMotion::steady(&bobs, &at).unwrap_err();
    assert!(matches!(error, AnalysisError::NotEquilibrium { .. }), "{error}");
}

#[test]
fn constraints_that_are_dependent_at_the_point() {
    let cross = Cross::new();
    let at = State::new(0.0, [0.0; 2], [0.0; 2]);
    for error in [
        equilibrium(&cross, &[0.0, 0.0]).unwrap_err(),
        small_vibrations(&cross, &[0.0, 0.0]).unwrap_err(),
        SmallMotion::steady(&cross, &at).unwrap_err(),
        SmallMotion::about(&cross, &at).unwrap_err(),
    ] {
        let dependent = matches!(error, AnalysisError::DependentConstraints { constraint: "track", .. });
        assert!(dependent && error.to_string().contains("singular position"), "{error}");
    }
}

#[test]
fn time_and_inputs_in_constraints() {
    let raised = Raised::new(1.0);
    assert_eq!(equilibrium(&raised, &[0.0; 2]).unwrap_err(), AnalysisError::TimeDependent);
    assert_eq!(small_vibrations(&raised, &[0.0; 2]).unwrap_err(), AnalysisError::TimeDependent);
    let at = State::new(0.0, [0.0; 2], [0.0, 1.0]);
    assert_eq!(SmallMotion::steady(&raised, &at).unwrap_err(), AnalysisError::TimeDependent);
    // Deviations from a given motion at one moment are the same with another time: ẍ = −(g + 2 ẋ²) 2x/(1 + 4x²).
    let small = SmallMotion::about(&raised, &at).unwrap();
    assert!((small.stiffness()[(0, 0)] / small.inertia()[(0, 0)] - 2.0 * 9.81).abs() < 1e-14);
    let lift = Lift::new(1.0);
    assert!(Lift::<f64>::FACTS.constraints[0].has_input && !FourBar::<f64>::FACTS.constraints[0].has_input);
    let at = State::new(0.0, [0.0; 2], [0.0; 2]);
    let error = StateSpace::about(&lift, &at).unwrap_err();
    assert_eq!(error, AnalysisError::ConstrainedInput { constraint: "wire" });
    assert!(error.to_string().contains("`wire`"));
    // Held, it is a number like another.
    let modes = small_vibrations(&lift, &[0.0; 2]).unwrap().modes().unwrap();
    assert!((modes.squares()[0] - 2.0 * 9.81).abs() < 1e-14);
}

/// A constraint on velocities leaves a family of equilibria, of which the nearest is found. Where it exerts no force
/// the energy decides.
#[test]
fn a_blade_at_rest() {
    let blade = Blade::new(1.3, 0.2, 2.0, 0.0, 0.7, 0.5);
    let held = equilibrium(&blade, &[0.1, 3.0, 0.1]).unwrap();
    assert_eq!((held.small.dimension(), held.small.constants()), (2, &["y".to_owned()][..]));
    assert!(
        (held.q - SVector::from([0.0, 3.0, 0.0])).amax() < 1e-15 && (held.multipliers[0] - 0.5).abs() < 1e-15
    );
    // ẍ = −kx x/m; I ψ̈ = −kψ ψ − λ x' …: the blade turns to the force, which has no potential on admitted
    // displacements.
    assert!(held.small.circulatory().amax() > 0.1);
    let rates = [(2.0f64 / 1.3).sqrt(), (0.7f64 / 0.2).sqrt()];
    for (found, exact) in held.small.spectrum().unwrap().frequencies().iter().zip(rates) {
        assert!((found / exact - 1.0).abs() < 1e-14);
    }
    assert!(matches!(held.stability, Stability::Undecided { .. }), "{:?}", held.stability);
    // A minimum of V among all positions, in which the blade is idle.
    let idle = equilibrium(&Blade::new(1.3, 0.2, 2.0, 1.0, 0.7, 0.0), &[0.0; 3]).unwrap();
    assert!(idle.multipliers[0].abs() < 1e-15 && idle.stability.is_stable(), "{:?}", idle.stability);
    // One that is not: ψ falls.
    let falls = equilibrium(&Blade::new(1.3, 0.2, 2.0, 1.0, -0.7, 0.0), &[0.0, 0.0, 0.1]).unwrap();
    assert!(falls.stability.is_unstable(), "{:?}", falls.stability);
}
