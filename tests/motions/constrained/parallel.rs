//! Planes that hold a mass, at small angles to each other.

use lagrange_runtime::analysis::*;
use lagrange_runtime::prelude::*;
use nalgebra::SVector;

macro_rules! wedges {
    ($($name:ident: $($constraint:ident)+;)+) => {$(
        lagrangian! {
            /// A mass on a spring along the edge of a floor and a ramp.
            system $name {
                param slope, g = 9.81;
                coord x, y, z;
                T = 0.5 * (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2));
                V = g * z + 0.5 * x.powi(2);
                $($constraint)+ floor: y == 0;
                $($constraint)+ ramp: y == slope * z;
                observe forces = [reaction(floor), reaction(ramp)];
            }
        }
    )+};
}

wedges! {
    Wedge: constraint;
    Redundant: redundant constraint;
}

/// Numbers alone decide whether one follows from the other: below 1e-3 they take it for so. A system in which that is
/// wrong has no results.
#[test]
fn planes_that_count_as_one_and_are_two_are_refused() {
    let at = State::new(0.0, [0.0; 3], [0.3, 0.0, 0.0]);
    let blow = SVector::from([0.5, 0.0, 1.0]);
    for slope in [1e-5, 1e-4, 9e-4, 9.9e-4] {
        let wedge = Redundant::new(slope);
        let error = equilibrium(&wedge, &[0.1, 0.0, 0.0]).unwrap_err();
        assert!(matches!(error, AnalysisError::Unbalanced { .. }), "{error}");
        let none = [wedge.jump(&at, &blow).after.qd, wedge.accel_at(&at)];
        assert!(none.iter().all(|x| x[2].is_nan()), "{none:?}");
        assert!(wedge.forces_at(&at).iter().all(|x| x.is_nan()));
    }
    for slope in [1.1e-3, 1e-2, 1.0] {
        let wedge = Redundant::new(slope);
        let found = equilibrium(&wedge, &[0.1, 0.0, 0.0]).unwrap();
        let force = 9.81 / slope;
        assert!((found.multipliers[0] - force).abs() < 1e-9 * force, "{slope}: {}", found.multipliers);
        assert!(found.residual < 1e-9 && wedge.jump(&at, &blow).after.qd[2].abs() < 1e-9);
    }
    // The impulse along planes that are the same indeed acts.
    assert_eq!(Redundant::new(0.0).jump(&at, &blow).after.qd.as_slice(), [0.8, 0.0, 1.0]);
}

/// `M q̈ = 0` across, and λ = ±g/slope, at rest, where nothing tells of a motion to either side, and along the edge.
#[test]
fn planes_that_are_nearly_parallel_have_no_branches() {
    for slope in [5e-4, 9e-4, 3e-3, 0.02, 0.3] {
        let (wedge, force) = (Wedge::new(slope), 9.81 / slope);
        for speed in [0.0, 0.3] {
            let at = State::new(0.0, [0.0; 3], [speed, 0.0, 0.0]);
            let (forces, accel) = (wedge.forces_at(&at), wedge.accel_at(&at));
            assert!(accel.amax() < 1e-8, "{slope}: {accel}");
            assert!((forces[0] - force).abs() < 1e-8 * force, "{slope}: {forces}");
            assert!((forces[1] + force).abs() < 1e-8 * force, "{slope}: {forces}");
            let after = wedge.jump(&at, &SVector::from([0.5, 0.2, 1.0])).after.qd;
            assert!((after - SVector::from([speed + 0.5, 0.0, 0.0])).amax() < 1e-9, "{slope}: {after}");
        }
    }
}
