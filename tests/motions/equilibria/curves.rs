//! Curves of equilibria against closed forms, and each hypothesis violated alone.

use lagrange_runtime::analysis::*;
use lagrange_runtime::prelude::*;

lagrangian! {
    /// A pitchfork of x at μ = 0 with the imperfection e; y follows.
    system Imperfect {
        param mu, e;
        coord x, y;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = 0.25 * x.powi(4) - 0.5 * mu * x.powi(2) + e * x + 0.5 * (y - x.powi(2)).powi(2);
    }
}

lagrangian! {
    /// The same beside stiff springs k.
    system Stiff {
        param mu, e, k;
        coord x, y, z;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2)) + 0.3 * dot(x) * dot(z);
        V = 0.25 * x.powi(4) - 0.5 * mu * x.powi(2) + e * x + 0.5 * (y - x.powi(2)).powi(2) + 0.5 * k * (z - 0.1).powi(2) * (1 + y.powi(2));
    }
}

lagrangian! {
    /// Symmetric under turns for b = 1, and of a square otherwise.
    system Round {
        param mu, b;
        coord x, y;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = 0.25 * (x.powi(4) + y.powi(4)) + 0.5 * b * (x * y).powi(2) - 0.5 * mu * (x.powi(2) + y.powi(2));
    }
}

lagrangian! {
    /// A bead in a spinning tube on a cart that is free.
    system Carried {
        param mu;
        coord x, theta;
        T = dot(x).powi(2) + dot(x) * dot(theta) * theta.cos() + 0.5 * dot(theta).powi(2);
        V = (1 - mu) * (1 - theta.cos()) + 0.25 * (1 - theta.cos()).powi(2);
    }
}

lagrangian! {
    /// A follower force p, damped.
    system Follower {
        param p, c;
        coord a, b;
        T = 0.5 * (dot(a).powi(2) + dot(b).powi(2));
        V = 0.5 * (a.powi(2) + 2 * b.powi(2));
        D = 0.5 * c * (dot(a).powi(2) + dot(b).powi(2));
        Q[a] = p * b;
        Q[b] = -p * a;
    }
}

lagrangian! {
    /// The same twice, loaded as well: two equal planes, in which K is not symmetric.
    system Planes {
        param mu, p;
        coord a, b, c, d;
        T = 0.5 * (dot(a).powi(2) + dot(b).powi(2) + dot(c).powi(2) + dot(d).powi(2));
        V = 0.5 * (1 - mu) * (a.powi(2) + c.powi(2)) + b.powi(2) + d.powi(2) + 0.25 * (a.powi(2) + c.powi(2)).powi(2);
        D = 0.5 * (dot(a).powi(2) + dot(b).powi(2) + dot(c).powi(2) + dot(d).powi(2));
        Q[a] = p * b;
        Q[c] = p * d;
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
    /// Buckling in first order: F = (1 − μ) x.
    system Straight {
        param mu;
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = 0.5 * (1 - mu) * x.powi(2);
    }
}

lagrangian! {
    /// Pushed off by μ, and beyond x = 1/2 by a second spring; `hard` = 0: one that sets in smoothly.
    system Stop {
        param mu, hard;
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = 0.5 * x.powi(2) - mu * x + if x > 0.5 { 0.5 * hard * (x - 0.5).powi(2) + 0.5 * (x - 0.5).powi(3) } else { 0 };
    }
}

lagrangian! {
    system Timed {
        param mu;
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = 0.5 * x.powi(2) - mu * x;
        Q[x] = if t > 5 && t < 10 { 1 } else { 0 };
    }
}

lagrangian! {
    system Wire {
        param mu;
        coord x, y;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = mu * y;
        constraint wire: y == x.powi(2);
    }
}

lagrangian! {
    system Falling {
        param mu;
        coord x, y;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = 0.5e12 * x.powi(2) - mu * x + y;
    }
}

lagrangian! {
    /// Polar coordinates, whose inertia vanishes at r = μ = 0.
    system Polar {
        param mu;
        coord r, phi;
        T = 0.5 * (dot(r).powi(2) + (r * dot(phi)).powi(2));
        V = 0.5 * (r - mu).powi(2) + 0.5 * phi.powi(2);
    }
}

fn path(step: f64) -> Path {
    Path { range: (-1.0, 1.0), step, steps: 10_000 }
}

fn kinds(branch: &Branch) -> Vec<BifurcationKind> {
    branch.bifurcations.iter().map(|b| b.kind).collect()
}

const STEPS: [f64; 4] = [0.01, 0.07, 0.2, 0.5];

/// An imperfection e moves the pitchfork off the curve from x(−1) on, which has no bifurcation at all, however small
/// e is.
#[test]
#[cfg_attr(not(feature = "long"), ignore = "long")]
fn imperfect_pitchforks_are_none() {
    for e in [1e-1, 1e-3, 1e-6, 1e-9, -1e-12] {
        for step in STEPS {
            let family = |mu| Imperfect { mu, e: Dual::constant(e) };
            let branch = follow(&family, &[0.0; 2], -1.0, &Heading::Up, &path(step)).unwrap();
            assert_eq!(kinds(&branch), [], "{e} {step}");
            let last = branch.points.last().unwrap();
            assert!(last.q[0] * e < 0.0 && last.stability.is_stable(), "{e} {step}: {last:?}");
        }
    }
}

/// At the step sizes of all tests a pitchfork is a pitchfork, from the straight curve and from the bent one.
#[test]
#[cfg_attr(not(feature = "long"), ignore = "long")]
fn a_pitchfork_at_every_step_size() {
    let family = |mu| Imperfect { mu, e: Dual::constant(0.0) };
    for k in 0..60 {
        let step = 0.005 * 1.08f64.powi(k);
        for (q, from, heading) in [
            ([0.0; 2], -1.0, Heading::Up),
            ([0.0; 2], 0.9, Heading::Down),
            ([0.9f64.sqrt(), 0.9], 0.9, Heading::Down),
        ] {
            let branch = follow(&family, &q, from, &heading, &path(step)).unwrap();
            assert_eq!(kinds(&branch), [BifurcationKind::Pitchfork], "{step} {from}");
            let found = &branch.bifurcations[0];
            assert!(found.parameter.abs() < 1e-14 && found.q.amax() < 1e-10, "{step} {from}: {found:?}");
            assert_eq!(found.kernel.len(), 1);
        }
    }
}

/// The curve aside begins at the branch point along its direction, in both halves, and does not find that point again.
#[test]
fn the_curves_aside_of_branch_points() {
    for step in STEPS {
        let family = |mu| Imperfect { mu, e: Dual::constant(0.0) };
        let straight = follow(&family, &[0.0; 2], -0.9, &Heading::Up, &path(step)).unwrap();
        let direction = straight.bifurcations[0].direction.clone();
        for half in [direction.clone(), -direction] {
            let aside = follow(&family, &[0.0; 2], 0.0, &Heading::Along(half.clone()), &path(step)).unwrap();
            assert!(aside.complete && kinds(&aside).is_empty(), "{step}: {:?}", aside.bifurcations);
            for point in &aside.points[1..] {
                assert!(
                    (point.q[0].powi(2) - point.parameter).abs() < 1e-12 && point.q[0] * half[0] > 0.0,
                    "{step}: {point:?}"
                );
                assert!(point.stability.is_stable());
            }
        }
        let family = |mu| Round { mu, b: Dual::constant(0.4) };
        for half in [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [1.0, 1.0, 0.0]] {
            let along = Heading::Along(DVector::from_row_slice(&half));
            let aside = follow(&family, &[0.0; 2], 0.0, &along, &path(step)).unwrap();
            assert!(aside.complete && kinds(&aside).is_empty(), "{step}: {:?}", aside.bifurcations);
            let last = aside.points.last().unwrap();
            assert!((last.q[0] * half[1] - last.q[1] * half[0]).abs() < 1e-9, "{step}: {last:?}");
        }
    }
}

/// Stiffnesses of 1e12 and 1e-12 beside it change nothing.
#[test]
#[cfg_attr(not(feature = "long"), ignore = "long")]
fn a_pitchfork_beside_stiff_springs() {
    for k in [1e-6, 1.0, 1e6, 1e12] {
        for step in STEPS {
            let family = |e: f64| move |mu| Stiff { mu, e: Dual::constant(e), k: Dual::constant(k) };
            let branch = follow(&family(0.0), &[0.0, 0.0, 0.1], -0.93, &Heading::Up, &path(step)).unwrap();
            assert_eq!(kinds(&branch), [BifurcationKind::Pitchfork], "{k} {step}");
            let found = &branch.bifurcations[0];
            assert!(
                found.parameter.abs() < 1e-12 && found.q.rows(0, 2).amax() < 1e-9,
                "{k} {step}: {found:?}"
            );
            let imperfect =
                follow(&family(1e-3), &[0.0, 0.0, 0.1], -0.93, &Heading::Up, &path(step)).unwrap();
            assert_eq!(kinds(&imperfect), [], "{k} {step}");
        }
    }
}

/// Both eigenvalues of K vanish at μ = 0: of the round potential, along all directions.
#[test]
#[cfg_attr(not(feature = "long"), ignore = "long")]
fn double_branch_points() {
    for b in [1.0, 0.4, 0.0, -0.3, 2.5] {
        for step in STEPS {
            let family = |mu| Round { mu, b: Dual::constant(b) };
            let branch = follow(&family, &[0.0; 2], -0.9, &Heading::Up, &path(step)).unwrap();
            assert_eq!(kinds(&branch), [BifurcationKind::Multiple], "{b} {step}");
            assert_eq!(branch.bifurcations[0].kernel.len(), 2);
            assert!(branch.bifurcations[0].parameter.abs() < 1e-14);
            let aside = follow(&family, &[0.9f64.sqrt(), 0.0], 0.9, &Heading::Down, &path(step)).unwrap();
            assert_eq!(aside.bifurcations.len(), 1, "{b} {step}: {:?}", aside.bifurcations);
            assert!(aside.bifurcations[0].parameter.abs() < 1e-12, "{b} {step}: {:?}", aside.bifurcations);
        }
    }
}

/// Equilibria aside of the round potential form a surface, at whose apex the curve meets the straight one.
#[test]
#[cfg_attr(not(feature = "long"), ignore = "long")]
fn a_surface_of_equilibria() {
    for k in 0..40 {
        let step = 0.01 * 1.1f64.powi(k);
        let (sin, cos) = (0.37 * f64::from(k)).sin_cos();
        let start = [0.9f64.sqrt() * cos, 0.9f64.sqrt() * sin];
        let family = |mu| Round { mu, b: Dual::constant(1.0) };
        let branch = follow(&family, &start, 0.9, &Heading::Down, &path(step)).unwrap();
        assert_eq!(kinds(&branch), [BifurcationKind::Pitchfork], "{step}");
        let found = &branch.bifurcations[0];
        assert!(found.parameter.abs() < 1e-14 && found.q.amax() < 1e-12, "{step}: {found:?}");
        // The surface's own directions are those of a neighbour.
        assert!(found.direction.rows(0, 2).amax() < 1e-5, "{step}: {found:?}");
        for point in &branch.points {
            let along = (point.q[0] * cos + point.q[1] * sin).abs();
            assert!((along.powi(2) - point.parameter).abs() < 1e-9, "{step}: it slides around: {point:?}");
            assert!(matches!(point.stability, Stability::Neutral { .. }));
        }
    }
}

/// The branch point of an unsymmetric K, whose double eigenvalue 1 − μ vanishes.
#[test]
fn a_double_branch_point_without_a_potential() {
    let family = |mu| Planes { mu, p: Dual::constant(0.3) };
    let path = Path { range: (0.0, 2.0), ..path(0.13) };
    let branch = follow(&family, &[0.0; 4], 0.1, &Heading::Up, &path).unwrap();
    assert_eq!(kinds(&branch), [BifurcationKind::Multiple]);
    assert!((branch.bifurcations[0].parameter - 1.0).abs() < 1e-13);
    for point in &branch.points {
        assert_eq!(point.stability.is_stable(), point.parameter < 1.0);
        assert_eq!(point.stability.is_unstable(), point.parameter > 1.0);
    }
}

/// A coordinate that is ignorable makes K singular everywhere, and hides no branch point.
#[test]
fn a_pitchfork_beside_an_ignorable_coordinate() {
    let branch = follow(
        &|mu| Carried { mu },
        &[0.3, 0.0],
        0.2,
        &Heading::Up,
        &Path { range: (0.0, 2.0), ..path(0.07) },
    )
    .unwrap();
    assert_eq!(kinds(&branch), [BifurcationKind::Pitchfork]);
    let found = &branch.bifurcations[0];
    assert!((found.parameter - 1.0).abs() < 1e-14 && (found.q[0] - 0.3).abs() < 1e-14);
    assert!((found.direction[1] - 1.0).abs() < 1e-9, "{found:?}");
    assert!(branch.points.iter().all(|p| p.q[0] == 0.3 && p.stability.is_unstable() == (p.parameter > 1.0)));
}

/// Two roots of λ⁴ + 3λ² + 2 + p² meet at p = 1/2. With damping, u = λ² + cλ = −3/2 ± i √(p² − 1/4) has roots on the
/// axis where p² = 1/4 + 3c²/2 (Routh and Hurwitz).
#[test]
fn flutter_under_a_follower_force() {
    for (c, step) in [(0.0, 0.03), (0.0, 0.3), (0.1, 0.03), (0.1, 0.3), (0.4, 0.1)] {
        let branch =
            follow(&|p| Follower { p, c: Dual::constant(c) }, &[0.0; 2], 0.0, &Heading::Up, &path(step))
                .unwrap();
        assert_eq!(kinds(&branch), [BifurcationKind::Flutter], "{c} {step}");
        let exact = (0.25f64 + 1.5 * c * c).sqrt();
        let off = branch.bifurcations[0].parameter - exact;
        assert!(off.abs() < 1e-12, "{c} {step}: {off:e}");
        for point in branch.points.iter().filter(|point| (point.parameter - exact).abs() > 1e-9) {
            let flutters = matches!(point.stability, Stability::Flutter { .. });
            assert_eq!(flutters, point.parameter > exact, "{c} {point:?}");
            // Without damping higher orders decide, but without circulatory forces.
            let decided = c > 0.0 && point.parameter < exact || point.parameter == 0.0;
            assert_eq!(point.stability.is_stable(), decided, "{c} {point:?}");
        }
    }
}

#[test]
fn damping_that_becomes_negative() {
    for step in [0.07, 0.3] {
        let branch = follow(&|mu| VanDerPol { mu }, &[0.0], -0.95, &Heading::Up, &path(step)).unwrap();
        assert_eq!(kinds(&branch), [BifurcationKind::Flutter]);
        assert!(branch.bifurcations[0].parameter.abs() < 1e-14);
        assert!(branch.points.iter().all(|p| p.stability.is_stable() == (p.parameter < 0.0)));
    }
}

#[test]
fn buckling_of_a_linear_system_is_degenerate() {
    let path = Path { range: (0.0, 2.0), ..path(0.13) };
    let branch = follow(&|mu| Straight { mu }, &[0.0], 0.3, &Heading::Up, &path).unwrap();
    assert_eq!(kinds(&branch), [BifurcationKind::Degenerate]);
    assert!((branch.bifurcations[0].parameter - 1.0).abs() < 1e-14);
}

#[test]
fn a_branch_that_steps_end_is_not_complete() {
    let family = |mu| Imperfect { mu, e: Dual::constant(0.1) };
    let short = Path { steps: 3, ..path(0.01) };
    assert!(!follow(&family, &[0.0; 2], -0.9, &Heading::Up, &short).unwrap().complete);
    assert!(follow(&family, &[0.0; 2], -0.9, &Heading::Up, &path(0.1)).unwrap().complete);
}

#[test]
fn equilibria_of_a_time_dependent_system_are_refused() {
    let error = follow(&|mu| Timed { mu }, &[0.0], 0.0, &Heading::Up, &path(0.1)).unwrap_err();
    assert_eq!(error, AnalysisError::TimeDependent);
}

/// A bead on a parabola rests at its lowest point, whatever its weight.
#[test]
fn equilibria_on_a_constraint_are_followed() {
    let branch = follow(&|mu| Wire { mu }, &[0.0; 2], 0.5, &Heading::Up, &path(0.1)).unwrap();
    assert!(branch.complete && branch.points.len() > 3 && kinds(&branch).is_empty());
    for point in &branch.points {
        assert!(point.q.amax() < 1e-15 && point.stability == Stability::Stable, "{point:?}");
    }
}

/// A kink of the force is refused where the curve meets it; one that only its third derivative has is not.
#[test]
fn a_switch_on_the_curve_is_refused() {
    for step in STEPS {
        let hard = |mu| Stop { mu, hard: Dual::constant(2.0) };
        let error = follow(&hard, &[0.0], 0.0, &Heading::Up, &path(step)).unwrap_err();
        assert_eq!(error, AnalysisError::Switch { index: 0 });
        let before = Path { range: (-1.0, 0.4), ..path(step.min(0.07)) };
        assert_eq!(kinds(&follow(&hard, &[0.0], 0.0, &Heading::Up, &before).unwrap()), []);
        let soft = |mu| Stop { mu, hard: Dual::constant(0.0) };
        assert_eq!(kinds(&follow(&soft, &[0.0], 0.0, &Heading::Up, &path(step)).unwrap()), []);
    }
}

/// No displacement balances the weight beside a stiff spring, along neither heading.
#[test]
fn no_equilibrium_at_the_start() {
    let along = Heading::Along(DVector::from_vec(vec![0.0, 0.0, 1.0]));
    for heading in [Heading::Up, Heading::Down, along] {
        let error = follow(&|mu| Falling { mu }, &[0.0; 2], 0.0, &heading, &path(0.1)).unwrap_err();
        assert!(
            matches!(error, AnalysisError::Unbalanced { coordinate, .. } if coordinate.index == 1),
            "{heading:?}: {error}"
        );
    }
}

#[test]
fn inertia_that_vanishes_is_refused() {
    let error = follow(&|mu| Polar { mu }, &[0.0, 0.0], 0.0, &Heading::Up, &path(0.1)).unwrap_err();
    assert!(matches!(error, AnalysisError::Inertia { coordinate, .. } if coordinate.index == 1), "{error}");
}

lagrangian! {
    /// Damping whose sign depends on the load, beside a stiff coordinate.
    system Squealing {
        param load, weak, stiff;
        coord x, y;
        T = 0.5 * dot(x).powi(2) + 0.5 * dot(y).powi(2);
        V = 0.5 * x.powi(2) + 0.5 * stiff * y.powi(2);
        Q[x] = weak * (load - 1) * dot(x);
        Q[y] = -0.1 * dot(y);
    }
}

/// Oscillations grow from the load 1 on, however weakly, and however stiff the other coordinate is.
#[test]
fn weak_negative_damping_beside_stiffness() {
    for weak in [1e-8, 1e-6, 1e-3, 1.0] {
        for stiff in [2.0, 1e6, 1e12, 1e18] {
            let family = |load: Dual<f64>| Squealing {
                load,
                weak: Dual::constant(weak),
                stiff: Dual::constant(stiff),
            };
            let path = Path { range: (0.0, 2.0), step: 0.13, steps: 1000 };
            let branch = follow(&family, &[0.0; 2], 0.0, &Heading::Up, &path).unwrap();
            let onsets: Vec<f64> = branch.bifurcations.iter().map(|b| b.parameter).collect();
            assert!(onsets.len() == 1 && (onsets[0] - 1.0).abs() < 1e-6, "{weak:e} {stiff:e} {onsets:?}");
        }
    }
}

#[test]
fn senseless_paths_are_refused() {
    let family = |load: Dual<f64>| Squealing { load, weak: Dual::constant(1.0), stiff: Dual::constant(2.0) };
    let path = |range, step| Path { range, step, steps: 100 };
    let from = |start: f64, heading: &Heading, path: &Path| follow(&family, &[0.0; 2], start, heading, path);
    for refused in [
        from(-0.5, &Heading::Up, &path((0.0, 1.0), 0.1)),
        from(f64::NAN, &Heading::Up, &path((0.0, 1.0), 0.1)),
        from(0.5, &Heading::Up, &path((0.0, 1.0), f64::INFINITY)),
        from(0.5, &Heading::Up, &path((1.0, 0.0), 0.1)),
        from(0.5, &Heading::Along(DVector::zeros(3)), &path((0.0, 1.0), 0.1)),
    ] {
        assert!(matches!(refused, Err(AnalysisError::NotApplicable { .. })), "{refused:?}");
    }
}

lagrangian! {
    /// `F = μ x + a x² + b x³`.
    system Crossed {
        param mu, a, b;
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = 0.5 * mu * x.powi(2) + a / 3 * x.powi(3) + 0.25 * b * x.powi(4);
    }
}

/// However small the quadratic term is beside the cubic one, the curves cross from one side to the other, with a fold
/// at x = −a/2b.
#[test]
#[cfg_attr(not(feature = "long"), ignore = "long")]
fn a_small_quadratic_term_is_no_pitchfork() {
    for step in [0.013, 0.1] {
        for (a, b) in
            [(1.0, 1.0), (1e-3, -1.0), (1e-6, 1.0), (1e-6, -1.0), (1e-9, 1.0), (-1e-11, 1.0), (1e9, 1.0)]
        {
            let family = |mu| Crossed { mu, a: Dual::constant(a), b: Dual::constant(b) };
            let straight = follow(&family, &[0.0], -0.93, &Heading::Up, &path(step)).unwrap();
            assert_eq!(kinds(&straight), [BifurcationKind::Transcritical], "{a:e} {b} {step}");
            let direction = &straight.bifurcations[0].direction;
            let slope = direction[1] / direction[0];
            assert!((slope + a).abs() < 1e-12 * (1.0 + a.abs()), "{a:e}: {slope:e}");
            // From μ = −0.9 b on the bent curve, which is refused where its fold cannot be told from the crossing.
            let from = -0.9 * b;
            let x = (-a - (a * a - 4.0 * b * from).sqrt() * b) / (2.0 * b);
            let heading = if b > 0.0 { Heading::Up } else { Heading::Down };
            match (a.abs() < 1.1, follow(&family, &[x], from, &heading, &path(step))) {
                (true, Ok(bent)) => {
                    let (fold, crossing) = (BifurcationKind::Fold, BifurcationKind::Transcritical);
                    let found = kinds(&bent);
                    assert!(
                        found == [fold, crossing] || found == [crossing, fold],
                        "{a:e} {b} {step}: {found:?}"
                    );
                    let fold = bent.bifurcations.iter().find(|b| b.kind == fold).unwrap();
                    assert!((fold.parameter - 0.25 * a * a / b).abs() < 1e-14, "{a:e}: {fold:?}");
                }
                (true, Err(error)) => {
                    assert!(
                        a.abs() < 1e-7 && matches!(error, AnalysisError::Unresolved { .. }),
                        "{a:e}: {error}"
                    );
                }
                (false, _) => {}
            }
        }
        let family = |mu| Crossed { mu, a: Dual::constant(0.0), b: Dual::constant(1.0) };
        for (from, x, heading) in [(-0.93, 0.0, Heading::Up), (-0.9, 0.9f64.sqrt(), Heading::Up)] {
            let branch = follow(&family, &[x], from, &heading, &path(step)).unwrap();
            assert_eq!(kinds(&branch), [BifurcationKind::Pitchfork], "{step}");
        }
    }
}

/// An imperfection below what rounding leaves of the forces is none, or the curve is lost by that name.
#[test]
fn imperfections_below_rounding_are_named() {
    for e in [1e-14, 1e-16] {
        let family = |mu| Imperfect { mu, e: Dual::constant(e) };
        match follow(&family, &[0.0; 2], -1.0, &Heading::Up, &path(0.1)) {
            // A pitchfork within 1e-13 of the forces.
            Ok(branch) => {
                for found in &branch.bifurcations {
                    assert!(
                        found.kind == BifurcationKind::Pitchfork && found.parameter.abs() < 1e-8,
                        "{found:?}"
                    );
                }
            }
            Err(AnalysisError::Unresolved { parameter, step }) => {
                assert!(parameter.abs() < 1e-4 && step < 1e-6, "{e:e}: {parameter:e} {step:e}");
            }
            Err(error) => panic!("{e:e}: {error}"),
        }
    }
}

lagrangian! {
    /// Two bodies and a spring, one of which is pushed.
    system Pushed {
        param k, f;
        coord x, y;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = 0.5 * k * (x - y).powi(2) - f * y;
    }
}

/// Nothing balances the push, however small it is beside the spring.
#[test]
fn a_pushed_pair_has_no_curve() {
    for share in [1e-3, 1e-9, 1e-15, 1e-18] {
        let family = |k: Dual<f64>| Pushed { k: k + Dual::constant(2.0), f: Dual::constant(share) };
        let error = follow(&family, &[0.3, 0.3], 0.0, &Heading::Up, &path(0.1)).unwrap_err();
        assert!(matches!(error, AnalysisError::Unbalanced { .. }), "{share:e}: {error}");
    }
    let family = |k: Dual<f64>| Pushed { k: k + Dual::constant(2.0), f: Dual::constant(0.0) };
    assert!(follow(&family, &[0.3, 0.3], 0.0, &Heading::Up, &path(0.1)).unwrap().complete);
}
