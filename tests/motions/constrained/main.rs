//! Analysis of systems with constraints: equilibria, small motions and linear models against independent coordinates,
//! closed forms, published digits, and duals of projected states.

// The example brings what it shares with others itself.
#[path = "../../../examples/bicycle.rs"]
mod bicycle;
mod curves;
mod disk;
mod linear;
mod motions;
mod parallel;
mod redundant;
mod refused;
mod rolling;
mod systems;

use lagrange_runtime::analysis::*;
use lagrange_runtime::prelude::*;
use std::f64::consts::PI;
use systems::*;

#[test]
#[cfg_attr(not(feature = "long"), ignore = "long")]
fn a_bicycle() {
    bicycle::main().unwrap();
}

/// Equilibria, multipliers, frequencies and verdicts of a double pendulum.
#[test]
fn bobs_by_places_and_by_angles() {
    let (places, angles) = (Bobs::new(0.7, 0.4, 0.8, 0.6, 0.0), Angles::new(0.7, 0.4, 0.8, 0.6, 0.0));
    for up in [[-1.0, -1.0], [-1.0, 1.0], [1.0, -1.0], [1.0, 1.0f64]] {
        let guess = [0.02, 0.8 * up[0], 0.01, 0.8 * up[0] + 0.6 * up[1]];
        let found = equilibrium(&places, &guess).unwrap();
        let other = equilibrium(&angles, &up.map(|up| if up > 0.0 { PI } else { 0.0 })).unwrap();
        assert!((found.q[3] - guess[3]).abs() < 1e-15 && found.q[0].abs() < 1e-15, "{:?}", found.q);
        assert!(found.residual < 1e-14, "{}", found.residual);
        assert_eq!(found.stability.is_stable(), other.stability.is_stable());
        assert_eq!(found.stability.is_unstable(), other.stability.is_unstable());
        // The force along the lower rod, 2 λ l, carries m₂ g.
        assert!((2.0 * 0.6 * found.multipliers[1] * up[1] - 0.4 * 9.81).abs() < 1e-14);
        let (a, b) = (found.small.modes().unwrap(), other.small.modes().unwrap());
        for (x, y) in a.squares().iter().zip(b.squares()) {
            assert!((x / y - 1.0).abs() < 2e-15, "{x} {y}");
        }
    }
    let all = equilibria(&places, &[-0.9, -0.9, -1.5, -1.5], &[0.9, 0.9, 1.5, 1.5], 200).unwrap();
    assert_eq!(all.len(), 4);
    assert_eq!(all.iter().filter(|found| found.stability.is_stable()).count(), 1);
}

/// With damping: the spectrum, within its own bounds.
#[test]
fn damped_bobs_have_the_same_spectrum() {
    let places = small_vibrations(&Bobs::new(0.7, 0.4, 0.8, 0.6, 0.3), &[0.0, -0.8, 0.0, -1.4]).unwrap();
    let angles = small_vibrations(&Angles::new(0.7, 0.4, 0.8, 0.6, 0.3), &[0.0, 0.0]).unwrap();
    let (places, angles) = (places.spectrum().unwrap(), angles.spectrum().unwrap());
    for k in 0..4 {
        let (x, y) = (places.eigenvalues[k], angles.eigenvalues[k]);
        assert!((x - y).norm() < 4e-15 * y.norm(), "{x} {y}");
        let [own, other] = [&places, &angles].map(|s| s.errors[k].norm());
        assert!((x - y).norm() <= own + other && own < 1e-13, "{x} {y} {own:e}");
    }
    let found = equilibrium(&Bobs::new(0.7, 0.4, 0.8, 0.6, 0.3), &[0.1, -0.8, 0.1, -1.4]).unwrap();
    assert!(found.stability.is_stable());
}

/// Potential energy and inertia of a four-bar linkage by the angle of the rocker: angles of coupler and crank by the
/// triangle of the bars.
fn by_one_angle<S: Real>(bars: &FourBar, chi: S) -> (S, [S; 3]) {
    let number = S::from_f64;
    let (x, y) = (number(bars.d) + number(bars.c) * chi.cos(), number(bars.c) * chi.sin());
    let f = (x * x + y * y).sqrt();
    // The crank lies below the line from its pivot to the pin.
    let phi = y.atan2(x)
        - ((number(bars.a * bars.a - bars.b * bars.b) + f * f) / (number(2.0 * bars.a) * f)).acos();
    let psi = (y - number(bars.a) * phi.sin()).atan2(x - number(bars.a) * phi.cos());
    let height = number(bars.mb) * (number(bars.a) * phi.sin() + number(0.5 * bars.b) * psi.sin());
    let others = number(0.5 * bars.ma * bars.a) * phi.sin() + number(0.5 * bars.mc * bars.c) * chi.sin();
    (number(bars.g) * (height + others), [phi, psi, chi])
}

/// ω² = V''/M of the one minimal coordinate, both by duals of the triangle.
#[test]
fn small_vibrations_of_a_four_bar_linkage() {
    let bars = FourBar::new(0.12, 0.32, 0.25, 0.3, 0.4, 0.9, 0.7);
    let slopes = |chi: f64| {
        let inner = Dual { value: Dual::variable(chi), slope: Dual::constant(1.0) };
        let (v, angles) = by_one_angle(&bars, inner);
        (v.value.slope, v.slope.slope, angles.map(|x| [x.value.value, x.slope.value]))
    };
    let (mut low, mut high) = (-1.7, -1.4);
    assert!(slopes(low).0 < 0.0 && slopes(high).0 > 0.0);
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        *if slopes(middle).0 < 0.0 { &mut low } else { &mut high } = middle;
    }
    let (_, curvature, angles) = slopes(low);
    let rates = SVector::from(angles.map(|x| x[1]));
    let q = SVector::from(angles.map(|x| x[0]));
    let inertia = rates.dot(&(bars.inertia(&q, &rates, 0.0) * rates));
    let exact = curvature / inertia;
    let found = equilibrium(&bars, &(q.map(|x| x + 1e-3)).into()).unwrap();
    assert!((found.q - q).amax() < 1e-14, "{} {}", found.q, q);
    let modes = found.small.modes().unwrap();
    assert_eq!(modes.len(), 1);
    assert!((modes.squares()[0] / exact - 1.0).abs() < 1e-13, "{} {exact}", modes.squares()[0]);
    assert!(found.small.energy_criterion().unwrap().is_stable());
    // The multipliers hold the bars: accelerations vanish with them.
    assert!(bars.accel(&found.q, &SVector::zeros(), 0.0).amax() < 1e-13);
}
