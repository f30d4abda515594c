//! Each hypothesis of `equilibrium`, `equilibria`, `small_vibrations` and of their verdict on stability, violated
//! alone.

use lagrange_runtime::analysis::*;
use lagrange_runtime::prelude::*;

lagrangian! {
    /// All hypotheses hold for the springs alone; every other parameter violates one.
    system Springs {
        param damping, cubic, quadratic, circulatory, gyroscopic, third;
        coord x, y;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2)) + 0.5 * gyroscopic * (x * dot(y) - y * dot(x));
        V = 0.5 * (x.powi(2) + 2 * y.powi(2)) + third * x.powi(3);
        Q[x] = -damping * dot(x) - cubic * dot(x).powi(3) - quadratic * x.powi(2) * dot(x) + circulatory * y;
        Q[y] = -damping * dot(y) - circulatory * x;
    }
}

lagrangian! {
    system VanDerPol {
        param mu;
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = 0.5 * x.powi(2);
        Q[x] = mu * (1 - x.powi(2)) * dot(x);
    }
}

lagrangian! {
    /// Two pendulums coupled by a damper, which leaves their motion in phase undamped; one is damped by `c`.
    system Coupled {
        param k, c;
        coord a, b;
        T = 0.5 * (dot(a).powi(2) + dot(b).powi(2));
        V = 2 - a.cos() - b.cos();
        D = 0.5 * k * (dot(a) - dot(b)).powi(2) + 0.5 * c * dot(a).powi(2);
    }
}

lagrangian! {
    /// The same with a damper that is weaker or stronger aside, and may drive the motion there.
    system CoupledAside {
        param k, c, e;
        coord a, b;
        T = 0.5 * (dot(a).powi(2) + dot(b).powi(2));
        V = 2 - a.cos() - b.cos();
        D = 0.5 * k * (dot(a) - dot(b)).powi(2) + 0.5 * c * dot(a).powi(2) + 0.5 * e * (a * dot(b)).powi(2);
    }
}

lagrangian! {
    /// A maximum of the potential in a frame that turns at the rate w: gyroscopic forces stabilize its small motions.
    system Hilltop {
        param w, c;
        coord x, y;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2)) + w * (x * dot(y) - y * dot(x));
        V = -0.5 * (x.powi(2) + y.powi(2));
        D = 0.5 * c * (dot(x).powi(2) + dot(y).powi(2));
    }
}

lagrangian! {
    /// A spring of another stiffness on either side of x = at.
    system Sided {
        param right, at;
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = if x > at { 0.5 * right * (x - at).powi(2) } else { 0.5 * (x - at).powi(2) };
    }
}

lagrangian! {
    /// Quadratic drag, dry friction, a damper that only resists one way.
    system Dragged {
        param drag, friction, valve, c;
        coord x, y;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = 0.5 * (x.powi(2) + y.powi(2));
        Q[x] = -drag * dot(x).abs() * dot(x) - c * dot(x);
        Q[y] = -drag * dot(y).abs() * dot(y) - friction * dot(y).signum() - valve * dot(y).max(0) - c * dot(y);
    }
}

lagrangian! {
    /// A ball at rest on a spring that it has pressed in by g/k.
    system Ball {
        param k, g = 9.81;
        coord z;
        T = 0.5 * dot(z).powi(2);
        V = g * z + if z < 0 { 0.5 * k * z.powi(2) } else { 0 };
    }
}

lagrangian! {
    system Gust {
        param f;
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = 0.5 * x.powi(2);
        Q[x] = if t > 5 && t < 10 { f } else { 0 };
    }
}

lagrangian! {
    system Rod {
        param g;
        coord x, y;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = g * y;
        constraint rod: x.powi(2) + y.powi(2) == 1;
    }
}

lagrangian! {
    /// A weight that nothing holds, beside a spring.
    system Dropped {
        param k;
        coord x, y;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = 0.5 * k * (x - 0.1).powi(2) + y;
    }
}

lagrangian! {
    system Polar {
        param k;
        coord r, phi;
        T = 0.5 * (dot(r).powi(2) + (r * dot(phi)).powi(2));
        V = 0.5 * k * r.powi(2);
    }
}

fn verdict(springs: [f64; 6]) -> Stability {
    let [damping, cubic, quadratic, circulatory, gyroscopic, third] = springs;
    let system = Springs::new(damping, cubic, quadratic, circulatory, gyroscopic, third);
    let all = equilibria(&system, &[-0.1; 2], &[0.1; 2], 5).unwrap();
    let found = equilibrium(&system, &[0.01, 0.02]).unwrap();
    assert!(all.len() == 1 && all[0].stability == found.stability && found.q.amax() < 1e-9, "{found:?}");
    found.stability
}

/// The origin of van der Pol's equation: eigenvalues (μ ± √(μ² − 4))/2.
#[test]
fn negative_damping_is_unstable_however_weak() {
    for mu in [1e-9, 0.1, 1.0, 1.9] {
        let Stability::Flutter { root, .. } = equilibrium(&VanDerPol::new(mu), &[0.1]).unwrap().stability
        else {
            panic!("{mu}")
        };
        assert!(
            (root.re - 0.5 * mu).abs() < 1e-15 && (root.im - (1.0 - 0.25 * mu * mu).sqrt()).abs() < 1e-14
        );
        let all = equilibria(&VanDerPol::new(mu), &[-1.0], &[1.0], 5).unwrap();
        assert!(all.len() == 1 && all[0].stability.is_unstable());
        let small = small_vibrations(&VanDerPol::new(mu), &[0.0]).unwrap();
        assert_eq!(small.energy_criterion(), Err(AnalysisError::NegativeDamping { eigenvalue: -1.0 }));
        assert!(equilibrium(&VanDerPol::new(-mu), &[0.1]).unwrap().stability.is_stable());
    }
    let fast = equilibrium(&VanDerPol::new(3.0), &[0.1]).unwrap().stability;
    assert!(matches!(fast, Stability::Unstable { .. }), "{fast:?}");
}

/// The linear terms are those of a center, whatever the sign of the others.
#[test]
fn forces_of_higher_order_decide_nothing_here() {
    for strength in [1.0, -1.0] {
        for springs in [[0.0, strength, 0.0, 0.0, 0.0, 0.0], [0.0, 0.0, strength, 0.0, 0.0, 0.0]] {
            assert!(matches!(verdict(springs), Stability::Undecided { .. }), "{springs:?}");
        }
        // Damping of first order outweighs them.
        assert!(verdict([0.1, strength, strength, 0.0, 0.3, 0.2]).is_stable());
        assert!(verdict([-0.1, strength, strength, 0.0, 0.3, 0.2]).is_unstable());
    }
}

/// Circulatory forces ±p of springs 1 and 2, damped by c: the small motions flutter from p² = 1/4 + 3c²/2 on.
#[test]
fn circulatory_forces_flutter() {
    for c in [0.0f64, 0.2] {
        let critical = (0.25 + 1.5 * c * c).sqrt();
        let below = verdict([c, 0.0, 0.0, 0.999 * critical, 0.0, 0.0]);
        assert_eq!(below.is_stable(), c > 0.0, "{below:?}");
        assert!(!below.is_unstable());
        let above = verdict([c, 0.0, 0.0, 1.001 * critical, 0.0, 0.0]);
        assert!(matches!(above, Stability::Flutter { .. }), "{above:?}");
    }
    let small = small_vibrations(&Springs::new(0.0, 0.0, 0.0, 0.3, 0.0, 0.0), &[0.0; 2]).unwrap();
    assert_eq!(small.energy_criterion(), Err(AnalysisError::Circulatory { largest: 0.3 }));
}

/// A stiff coordinate with 1e12 does not hide forces between soft ones.
#[test]
fn stiffness_hides_neither_circulatory_forces_nor_negative_damping() {
    let stiff = |a: f64, [b, c]: [f64; 2], [d, e]: [f64; 2]| {
        DMatrix::from_row_slice(3, 3, &[a, 0.0, 0.0, 0.0, b, c, 0.0, d, e])
    };
    let (m, none) = (DMatrix::identity(3, 3), DMatrix::zeros(3, 3));
    let small = SmallMotion::new(m.clone(), none, stiff(1e12, [1.0, 0.7], [-0.7, 2.0])).unwrap();
    assert_eq!(small.energy_criterion(), Err(AnalysisError::Circulatory { largest: 0.7 }));
    let c = stiff(1e12, [1.0, 0.0], [0.0, -1e-6]);
    let small = SmallMotion::new(m, c, stiff(1.0, [1.0, 0.0], [0.0, 2.0])).unwrap();
    assert_eq!(small.energy_criterion(), Err(AnalysisError::NegativeDamping { eigenvalue: -1.0 }));
}

/// In phase nothing is damped: the linear equations cannot tell. Constant dampers do not drive the motion, whether or
/// not there is one; others may. Damping of one pendulum reaches both.
#[test]
fn damping_of_some_motions_only() {
    for (k, c) in [(0.0, 0.0), (0.4, 0.0), (0.4, 0.1), (1e-12, 0.0)] {
        assert!(equilibrium(&Coupled::new(k, c), &[0.1, -0.1]).unwrap().stability.is_stable(), "{k} {c}");
    }
    for (k, c) in [(-0.4, 0.0), (0.4, -1e-12)] {
        assert!(!equilibrium(&Coupled::new(k, c), &[0.1, -0.1]).unwrap().stability.is_stable(), "{k} {c}");
    }
    for e in [0.0, 0.3, -0.3] {
        let aside = equilibrium(&CoupledAside::new(0.4, 0.0, e), &[0.1, -0.1]).unwrap();
        assert!(matches!(aside.stability, Stability::Undecided { .. }), "{e}");
        assert_eq!(aside.small.energy_criterion(), Ok(Stability::Stable), "of the small motions");
        assert!(equilibrium(&CoupledAside::new(0.4, 0.1, e), &[0.1, -0.1]).unwrap().stability.is_stable());
    }
    let upright = equilibrium(&Coupled::new(0.4, 0.1), &[3.1, 0.1]).unwrap();
    assert!(matches!(upright.stability, Stability::Unstable { .. }));
}

/// λ⁴ + (4w² − 2) λ² + 1 has its roots on the axis from w = 1 on, and damping destroys that (Thomson, Tait and
/// Chetaev).
#[test]
fn gyroscopic_stabilization_is_not_decided_by_the_energy() {
    let stability = |w: f64, c: f64| equilibrium(&Hilltop::new(w, c), &[0.0; 2]).unwrap().stability;
    assert!(matches!(stability(0.0, 0.0), Stability::Unstable { .. }));
    assert!(stability(0.9, 0.0).is_unstable());
    assert!(matches!(stability(1.1, 0.0), Stability::Undecided { .. }));
    for c in [1e-9, 0.1] {
        assert!(stability(1.1, c).is_unstable());
    }
    let around = Springs::new(0.0, 0.0, 0.0, 0.0, 5.0, 0.0);
    assert_eq!(small_vibrations(&around, &[0.0; 2]).unwrap().energy_criterion(), Ok(Stability::Stable));
}

/// The period about a kink with the stiffnesses 1 and 4 is π + π/2, the square of its frequency 16/9: neither side's.
#[test]
fn a_kink_has_no_small_vibrations() {
    for at in [0.0, 0.3, -7e3] {
        let kink = Sided::new(4.0, at);
        assert_eq!(small_vibrations(&kink, &[at]), Err(AnalysisError::Switch { index: 0 }));
        assert_eq!(equilibrium(&kink, &[at + 0.1]), Err(AnalysisError::Switch { index: 0 }));
        assert_eq!(equilibria(&kink, &[at - 1.0], &[at + 1.5], 7), Err(AnalysisError::Switch { index: 0 }));
        let state = State::new(0.0, [at], [0.0]);
        assert_eq!(SmallMotion::steady(&kink, &state), Err(AnalysisError::Switch { index: 0 }));
        assert_eq!(SmallMotion::about(&kink, &state), Err(AnalysisError::Switch { index: 0 }));
        // Both sides the same: no kink.
        let smooth = small_vibrations(&Sided::new(1.0, at), &[at]).unwrap();
        assert_eq!(smooth.stiffness()[0], 1.0);
        assert_eq!(SmallMotion::about(&Sided::new(1.0, at), &state).unwrap().stiffness()[0], 1.0);
    }
}

/// A jump or kink in the velocity is one, and quadratic drag is smooth enough.
#[test]
fn friction_is_a_switch_and_quadratic_drag_is_none() {
    let drag = equilibrium(&Dragged::new(0.7, 0.0, 0.0, 0.0), &[0.1, 0.2]).unwrap();
    assert!(drag.small.damping().amax() == 0.0 && matches!(drag.stability, Stability::Undecided { .. }));
    assert!(equilibrium(&Dragged::new(0.7, 0.0, 0.0, 0.1), &[0.1, 0.2]).unwrap().stability.is_stable());
    for (friction, valve) in [(0.1, 0.0), (0.0, 0.1), (1e-6, 0.0)] {
        let error = equilibrium(&Dragged::new(0.7, friction, valve, 0.0), &[0.0; 2]).unwrap_err();
        assert!(matches!(error, AnalysisError::Switch { .. }), "{friction} {valve}: {error}");
    }
}

#[test]
fn an_equilibrium_beside_a_switch_is_none_on_it() {
    for k in [10.0, 1e6, 1e12] {
        let found = equilibrium(&Ball::new(k), &[-1.0]).unwrap();
        assert!((found.q[0] * k / -9.81 - 1.0).abs() < 1e-12 && found.stability.is_stable());
    }
}

#[test]
fn time_is_refused_and_a_constraint_is_not() {
    let gust = Gust::new(0.0);
    assert_eq!(small_vibrations(&gust, &[0.0]), Err(AnalysisError::TimeDependent));
    assert_eq!(equilibrium(&gust, &[0.0]), Err(AnalysisError::TimeDependent));
    assert_eq!(equilibria(&gust, &[-1.0], &[1.0], 3), Err(AnalysisError::TimeDependent));
    // A pendulum by its place: x'' = −g x/l below, and + above.
    let rod = Rod::new(9.81);
    let below = equilibrium(&rod, &[0.0, -1.0]).unwrap();
    assert!(below.stability.is_stable() && (below.small.stiffness()[0] - 9.81).abs() < 1e-13);
    assert!(matches!(equilibrium(&rod, &[0.0, 1.0]).unwrap().stability, Stability::Unstable { .. }));
    assert_eq!(equilibria(&rod, &[-1.0; 2], &[1.0; 2], 20).unwrap().len(), 2);
    let off = AnalysisError::OffConstraints { constraint: "rod", violation: 0.0 };
    let found = small_vibrations(&rod, &[0.0, -1.1]).unwrap_err();
    assert_eq!(core::mem::discriminant(&found), core::mem::discriminant(&off), "{found}");
}

/// A correction of rounding of the spring is no sign that the weight is held.
#[test]
fn a_force_that_no_displacement_changes_is_no_equilibrium() {
    for k in [3.0, 7.0, 1e12] {
        for x in [0.0, 0.1, 0.3, 0.7, -11.3] {
            let error = equilibrium(&Dropped::new(k), &[x, 0.0]).unwrap_err();
            assert!(
                matches!(error, AnalysisError::Unbalanced { coordinate, .. } if coordinate.index == 1),
                "{k} {x}: {error}"
            );
            let error = small_vibrations(&Dropped::new(k), &[x, 0.0]).unwrap_err();
            assert!(matches!(error, AnalysisError::NotEquilibrium { nearest: None, .. }), "{k} {x}: {error}");
        }
        assert_eq!(equilibria(&Dropped::new(k), &[-1.0; 2], &[1.0; 2], 20), Ok(Vec::new()));
    }
}

lagrangian! {
    /// Two bodies and a spring, one of which is pushed.
    system Pair {
        param k, f;
        coord x, y;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = 0.5 * k * (x - y).powi(2) - f * y;
    }
}

lagrangian! {
    /// Three bodies and two springs, under loads.
    system Afloat {
        param f: [3];
        coord x: [3];
        T = 0.5 * (dot(x[0]).powi(2) + dot(x[1]).powi(2) + dot(x[2]).powi(2));
        V = 5 * (x[1] - x[0]).powi(2) + 3.5 * (x[2] - x[1]).powi(2) - f[0] * x[0] - f[1] * x[1] - f[2] * x[2];
    }
}

/// Loads that balance in decimal numbers, and not in binary ones: 0.1 + 0.2 is not 0.3. A load that does not balance is
/// told.
#[test]
fn loads_balance_but_for_rounding() {
    for [f, g, h] in
        [[0.1, 0.2, -0.3], [0.3, -0.4, 0.1], [100.1, 200.2, -300.3], [0.5, 0.25, -0.75], [0.1, 0.0, -0.1]]
    {
        let system = Afloat::new([f, g, h]);
        let rest = [0.0, -f / 10.0, -f / 10.0 + h / 7.0];
        let found = equilibrium(&system, &[0.3, 0.1, -0.2]).unwrap();
        assert!((found.q[1] - found.q[0] - rest[1]).abs() < 1e-14 * (1.0 + f), "{found:?}");
        let squares = small_vibrations(&system, &rest).unwrap().modes().unwrap().squares().to_vec();
        for (found, exact) in squares.iter().zip([0.0, 17.0 - 79f64.sqrt(), 17.0 + 79f64.sqrt()]) {
            assert!((found - exact).abs() < 1e-13, "{squares:?}");
        }
        for share in [1e-6, 1e-12] {
            let system = Afloat::new([f, g, h + share * f]);
            assert!(
                matches!(equilibrium(&system, &rest), Err(AnalysisError::Unbalanced { .. })),
                "{f} {share}"
            );
        }
    }
}

lagrangian! {
    /// The pair in other coordinates, in which forces within it cancel but for rounding.
    system Turned {
        param k, f;
        coord u, v;
        let x = 0.3 * u + 0.7 * v;
        let y = 0.9 * u - 0.1 * v;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = 0.5 * k * (x - y).powi(2) - f * y;
    }
}

/// However small a push is beside the spring, nothing balances it; without it the pair rests anywhere.
#[test]
fn a_pushed_pair_does_not_rest() {
    for k in [1e-12, 1.0, 1e12] {
        for at in [[0.0, 0.0], [1.3, 1.3], [0.3, 1e3], [-7.1, 0.2]] {
            for share in [1e-2, 1e-7, 1e-9, 1e-12, 1e-15, 1e-18] {
                let found = equilibrium(&Pair::new(k, share * k), &at);
                let refused = matches!(found, Err(AnalysisError::Unbalanced { .. }));
                assert!(refused, "{k:e} {share:e} {at:?}: {found:?}");
                // In other coordinates forces that cancel have rounding errors, in proportion to the coordinates.
                let found = equilibrium(&Turned::new(k, share * k), &at);
                let refused = matches!(found, Err(AnalysisError::Unbalanced { .. }));
                let largest = at.iter().fold(1.0, |most: f64, x| most.max(x.abs()));
                assert!(refused || share < 1e-13 * largest, "{k:e} {share:e} {at:?}: {found:?}");
            }
            let rests = equilibrium(&Pair::new(k, 0.0), &at).unwrap();
            assert!((rests.q[0] - rests.q[1]).abs() < 1e-12 * (1.0 + at[1].abs()), "{k:e} {at:?}");
            assert!(matches!(rests.stability, Stability::Neutral { .. }));
            assert!(equilibrium(&Turned::new(k, 0.0), &at).is_ok(), "{k:e} {at:?}");
        }
    }
}

#[test]
fn inertia_that_is_not_positive_definite() {
    let error = equilibrium(&Polar::new(1.0), &[0.0; 2]).unwrap_err();
    assert!(matches!(error, AnalysisError::Inertia { coordinate, .. } if coordinate.index == 1), "{error}");
    assert_eq!(equilibria(&Polar::new(1.0), &[-1.0; 2], &[1.0; 2], 5), Ok(Vec::new()));
    assert_eq!(equilibrium(&Polar::new(f64::NAN), &[1.0; 2]), Err(AnalysisError::NotFinite));
}

/// M with one half of a mixed term alone, with both, and far apart in size.
#[test]
fn the_inertia_matrix_is_symmetric() {
    let (none, k) = (DMatrix::zeros(2, 2), DMatrix::identity(2, 2));
    let with = |a: f64, b: f64, c: f64| {
        SmallMotion::new(DMatrix::from_row_slice(2, 2, &[a, b, c, 1.0]), none.clone(), k.clone())
    };
    assert_eq!(with(1.0, 0.5, 0.0), Err(AnalysisError::UnsymmetricInertia { largest: 0.25 }));
    assert_eq!(with(1e12, 1e-3, 0.0), Err(AnalysisError::UnsymmetricInertia { largest: 5e-4 }));
    assert!(with(1.0, 0.5, 0.5).is_ok() && with(1.0, 0.5, 0.5 + f64::EPSILON).is_ok());
    assert!(matches!(with(1.0, 2.0, 2.0), Err(AnalysisError::Inertia { .. })));
    let text = with(1.0, 0.5, 0.0).unwrap_err().to_string();
    assert!(text.contains("not symmetric"), "{text}");
}

/// A state that is not at rest, or under forces of time, has no steady motion.
#[test]
fn steady_motions_are_checked() {
    let system = Hanging::new(2.0);
    let about = |q: f64, qd: f64| SmallMotion::steady(&system, &State::new(0.0, [q], [qd]));
    assert!(about(0.0, 0.0).is_ok());
    assert!(
        matches!(about(0.1, 0.0), Err(AnalysisError::NotEquilibrium { coordinate, .. }) if coordinate.index == 0)
    );
    assert!(matches!(about(1e-3, 0.0), Err(AnalysisError::NotEquilibrium { .. })));
    // Through the lowest point, and of a body that turns, accelerations vanish for an instant.
    assert!(matches!(about(0.0, 1.0), Err(AnalysisError::NotApplicable { .. })));
    let top = Top::new();
    let turning = State::new(0.0, [0.0; 3], [0.0, 0.0, 0.75]);
    assert!(matches!(SmallMotion::steady(&top, &turning), Err(AnalysisError::NotApplicable { .. })));
    let pulsed = SmallMotion::steady(&PulsedHanging::new(2.0), &State::new(0.0, [0.0], [0.0]));
    assert_eq!(pulsed, Err(AnalysisError::TimeDependent));
}

lagrangian! {
    /// A free body.
    system Top {
        coord R: rotation;
        let hub = frame(world, [0, 0, 0], R);
        T = body(1, [1, 2, 3], hub);
        V = 0;
    }
}

lagrangian! {
    system Hanging {
        param w;
        coord theta;
        T = 0.5 * dot(theta).powi(2);
        V = -w * w * cos(theta);
    }
}

lagrangian! {
    system PulsedHanging {
        param w;
        coord theta;
        T = 0.5 * dot(theta).powi(2);
        V = -w * w * cos(theta);
        Q[theta] = if t > 5 && t < 6 { 1 } else { 0 };
    }
}

lagrangian! {
    /// A mass between two springs in a frame that turns at the rate w, in skew coordinates: inertia and gyroscopic
    /// matrix are full, and rounding of their entries is not that of their formulas.
    system SkewPlate {
        param w, a, b, k, c;
        coord u, v;
        let x = u + a * v;
        let y = b * u + v;
        T = 0.5 * ((dot(x) - w * y).powi(2) + (dot(y) + w * x).powi(2));
        V = 0.5 * k * (x * x + 2 * y * y);
        D = 0.5 * c * dot(u).powi(2);
    }
}

lagrangian! {
    /// A satellite on a circular orbit, by its attitude in the frame that turns with the orbit: x is radial, z normal.
    system Orbiting {
        param A, B, C, n = 1.0;
        coord R: rotation;
        let hull = frame(world, [0, 0, 0], rotation_z(n * t) * R);
        let up = R.inverse() * [1, 0, 0];
        T = body(1, [A, B, C], hull);
        V = 1.5 * n * n * (A * up[0] * up[0] + B * up[1] * up[1] + C * up[2] * up[2]);
    }
}

/// With `k₁ = k − w²` and `k₂ = 2k − w²` both negative, roots of `λ⁴ + (k₁ + k₂ + 4w²) λ² + k₁ k₂` are imaginary where
/// `k₁ + k₂ + 4w² > 2 √(k₁ k₂)`: stable in first approximation, which decides nothing. Damping of one coordinate drives
/// the other then.
#[test]
fn rounding_of_a_gyroscopic_system_is_no_damping() {
    for step in 0..60 {
        let s = f64::from(step);
        let [a, b] = [(0.37 * s).sin() * 0.5, (1.3 * s).cos() * 0.5];
        let hill = SkewPlate { w: 1.0, a, b, k: 0.1, c: 0.0 };
        let found = equilibrium(&hill, &[1e-3, -2e-3]).unwrap();
        assert!(matches!(found.stability, Stability::Undecided { .. }), "{a} {b}: {:?}", found.stability);
        assert_eq!(found.small.damping().amax(), 0.0);
        let valley = equilibrium(&SkewPlate { k: 1.5, ..hill }, &[1e-3, -2e-3]).unwrap();
        assert!(valley.stability.is_stable(), "{a} {b}: {:?}", valley.stability);
        let damped = equilibrium(&SkewPlate { c: 0.3, ..hill }, &[1e-3, -2e-3]).unwrap();
        assert!(damped.stability.is_unstable(), "{a} {b}: {:?}", damped.stability);
    }
}

/// A satellite whose smallest inertia is about the radius, and whose largest about the normal of the orbit, is at a
/// minimum of V − T₀ in four attitudes, which turns by half a circle take to each other (Lagrange; Beletskii, *Motion
/// of an Artificial Satellite about its Center of Mass*, 1966). Newton's method ends at parameters of 1e-170 beside
/// some.
#[test]
fn attitudes_of_a_satellite_in_orbit() {
    use std::f64::consts::PI;
    let satellite = Orbiting::new(2.0, 3.0, 4.0);
    let [x, y, z] = [Vector3::x(), Vector3::y(), Vector3::z()].map(|axis| axis * PI);
    for turn in [Vector3::zeros(), x, y, z] {
        for step in 0..40 {
            let s = 1e-3 * f64::from(step);
            let aside = UnitQuaternion::new(Vector3::new((7.0 * s).sin(), -s, 0.5 * s) * 0.1);
            let rest = State::new(0.0, [0.0; 3], [0.0; 3]);
            let at = satellite.with_attitude_R(rest, &(UnitQuaternion::new(turn) * aside), &Vector3::zeros());
            let found = equilibrium(&satellite, &at.q.into()).unwrap();
            assert!(found.stability.is_stable(), "{turn:?} {s}: {:?} at {:?}", found.stability, found.q);
        }
    }
    // Once in its spectrum.
    let satellite = Orbiting::new(0.9078958501485379, 0.759916021016827, 0.2114296920898424);
    assert!(equilibrium(&satellite, &[1e-150, -1.0, 1e-160]).unwrap().stability.is_unstable());
}
