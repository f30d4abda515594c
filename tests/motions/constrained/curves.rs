//! Curves of equilibria of systems with constraints, against closed forms.

use lagrange_runtime::analysis::*;
use lagrange_runtime::prelude::*;

lagrangian! {
    /// A bead on a hoop that spins about its vertical diameter, by its place.
    system Bead {
        param a, omega, push = 0, m = 1.3, g = 9.81;
        coord x, z;
        T = 0.5 * m * (dot(x).powi(2) + dot(z).powi(2) + (omega * x).powi(2));
        V = m * g * z - push * x;
        constraint hoop: x.powi(2) + z.powi(2) == a.powi(2);
    }
}

lagrangian! {
    /// A rod that a load turns against a spring at its tip, with a side force.
    system Arch {
        param load, side, c = 3, m = 0.7;
        coord x, y;
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
        V = 0.5 * c * x.powi(2) - load * y + side * x;
        constraint rod: x.powi(2) + y.powi(2) == 1;
    }
}

lagrangian! {
    /// A knife edge.
    system Skate {
        param slope, k = 1;
        coord x, y, phi;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2) + dot(phi).powi(2));
        V = 0.5 * k * (x.powi(2) + y.powi(2)) + slope * y;
        constraint edge: dot(y) * cos(phi) == dot(x) * sin(phi);
    }
}

/// The pitchfork at ω² = g/a, and aside of it z = −g/ω².
#[test]
fn a_bead_on_a_spinning_hoop() {
    let family = |omega: Dual<f64>| Bead { omega, ..Bead::new(0.5, 0.0).map(Dual::constant) };
    let path = Path { range: (0.0, 9.0), step: 0.1, steps: 2000 };
    let bottom = follow(&family, &[0.0, -0.5], 1.0, &Heading::Up, &path).unwrap();
    assert!(bottom.complete && bottom.bifurcations.len() == 1, "{:?}", bottom.bifurcations);
    let found = &bottom.bifurcations[0];
    let critical = (9.81f64 / 0.5).sqrt();
    assert_eq!((found.kind, found.q.len(), found.direction.len()), (BifurcationKind::Pitchfork, 2, 3));
    assert!((found.parameter - critical).abs() < 1e-12, "{:e}", found.parameter - critical);
    assert!((found.direction[0].abs() - 1.0).abs() < 1e-9, "{}", found.direction);
    for point in &bottom.points {
        assert!(point.q[0].abs() < 1e-12 && (point.q[1] + 0.5).abs() < 1e-12);
        let past = point.parameter > critical;
        assert_eq!((point.negative, point.stability.is_unstable()), (usize::from(past), past));
    }
    let aside = Heading::Along(found.direction.clone());
    let up = follow(&family, &[0.0, -0.5], found.parameter, &aside, &path).unwrap();
    assert!(up.complete && up.bifurcations.is_empty() && up.points.len() > 20, "{:?}", up.bifurcations);
    for point in &up.points[1..] {
        let z = -9.81 / point.parameter.powi(2);
        let x = (0.25 - z * z).sqrt();
        assert!((point.q[1] - z).abs() < 1e-12 && (point.q[0].abs() - x).abs() < 1e-11, "{} {z}", point.q);
        assert!(point.negative == 0 && point.stability.is_stable());
    }
    let down = follow(&family, &[0.0, -0.5], 5.0, &Heading::Down, &path).unwrap();
    assert!((down.bifurcations[0].parameter - critical).abs() < 1e-12);
}

/// With x = cos θ and y = sin θ the load is `−c sin θ − s tan θ`: a fold where cos³ θ = −s/c, at the load
/// c (1 − (s/c)^⅔)^{3/2}.
#[test]
fn a_fold_on_a_rod() {
    let side = 0.1;
    let family = |load: Dual<f64>| Arch { load, ..Arch::new(0.0, side).map(Dual::constant) };
    let path = Path { range: (-5.0, 5.0), step: 0.05, steps: 5000 };
    let c: f64 = 3.0;
    let cos = -(side / c).cbrt();
    let fold = c * (1.0 - cos * cos).powf(1.5);
    let theta = 1.2f64 + std::f64::consts::FRAC_PI_2;
    let load = |theta: f64| -c * theta.sin() - side * theta.tan();
    let start = [theta.cos(), theta.sin()];
    let curve = follow(&family, &start, load(theta), &Heading::Down, &path).unwrap();
    let folds: Vec<_> = curve.bifurcations.iter().filter(|b| b.kind == BifurcationKind::Fold).collect();
    assert!(!folds.is_empty() && folds.len() == curve.bifurcations.len(), "{:?}", curve.bifurcations);
    for found in folds {
        assert!((found.parameter.abs() - fold).abs() < 1e-12, "{} {fold}", found.parameter);
        assert!((found.q[0] - cos).abs() < 1e-7, "{} {cos}", found.q);
    }
    for point in &curve.points {
        let [x, y] = [point.q[0], point.q[1]];
        assert!((x.hypot(y) - 1.0).abs() < 1e-14);
        assert!(
            (point.parameter + c * y + side * y / x).abs() < 1e-10 * (1.0 + (y / x).abs()),
            "{}",
            point.q
        );
        // V by θ: its second derivative.
        let bend = point.parameter * y - c * (x * x - y * y) - side * x;
        assert_eq!(point.negative, usize::from(bend < 0.0), "{} {bend}", point.q);
    }
}

/// Constraints on velocities leave surfaces of equilibria.
#[test]
fn a_skate_has_no_curve() {
    let family = |slope: Dual<f64>| Skate { slope, ..Skate::new(0.0).map(Dual::constant) };
    let path = Path { range: (0.0, 1.0), step: 0.1, steps: 10 };
    let error = follow(&family, &[0.0; 3], 0.0, &Heading::Up, &path).unwrap_err();
    assert!(matches!(error, AnalysisError::DependentCoordinates { constraint: "edge" }), "{error}");
}
