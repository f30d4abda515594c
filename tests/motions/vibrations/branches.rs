//! Curves of equilibria, their folds and branch points, against closed forms.

use crate::reference::{Reference, close};
use crate::systems::Bead;
use lagrange_runtime::analysis::*;
use lagrange_runtime::prelude::*;

lagrangian! {
    /// A shallow arch: two springs from (∓1, 0) to a mass at height y, pushed down by p. It snaps through.
    pub system Arch {
        param h, k, p;
        coord y;
        let length = (1 + y.powi(2)).sqrt();
        T = 0.5 * dot(y).powi(2);
        V = k * (length - (1 + h.powi(2)).sqrt()).powi(2) + p * y;
    }
}

lagrangian! {
    /// `F = x² − μ x + y`, and a coordinate beside it.
    pub system Crossing {
        param mu;
        coord x, y;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = x.powi(3) / 3.0 - 0.5 * mu * x.powi(2) + 0.5 * y.powi(2);
    }
}

lagrangian! {
    /// The tube of the bead, turning freely about its vertical diameter with the inertia I.
    pub system FreeTube {
        param m, a, g, I;
        coord theta, phi;
        T = 0.5 * m * a.powi(2) * (dot(theta).powi(2) + (dot(phi) * theta.sin()).powi(2)) + 0.5 * I * dot(phi).powi(2);
        V = -m * g * a * theta.cos();
        pub routhian TubeWithMomentum;
    }
}

/// Steady motions of the Routhian branch at p = I √(g/a), where the tube spins at √(g/a).
#[test]
fn the_pitchfork_of_a_steady_motion() {
    let tube = FreeTube::new(0.4, 0.5, 9.81, 0.07);
    let (reduced, _) = tube.reduce(&State::new(0.0, [0.0; 2], [0.0, 1.0]));
    let family = |p_phi: Dual<f64>| TubeWithMomentum { p_phi, ..reduced.map(Dual::constant) };
    let path = Path { range: (0.1, 1.0), step: 0.02, steps: 500 };
    let bottom = follow(&family, &[0.0], 0.15, &Heading::Up, &path).unwrap();
    assert_eq!(bottom.bifurcations.len(), 1);
    assert_eq!(bottom.bifurcations[0].kind, BifurcationKind::Pitchfork);
    let critical = bottom.bifurcations[0].parameter;
    close(critical, 0.07 * (9.81f64 / 0.5).sqrt(), 1e-13);
    // Aside, the reduced matrices of the whole system are those of the Routhian.
    let aside = Heading::Along(bottom.bifurcations[0].direction.clone());
    for point in &follow(&family, &[0.0], critical, &aside, &path).unwrap().points[1..] {
        let steady =
            Reduced::new(&tube, &[point.parameter]).unwrap().steady(&[point.q[0] + 1e-3, 0.0]).unwrap();
        assert!((steady.at.q[0] - point.q[0]).abs() < 1e-11);
        let routhian = TubeWithMomentum { p_phi: point.parameter, ..reduced };
        let small = small_vibrations(&routhian, &[point.q[0]]).unwrap();
        close(small.modes().unwrap().frequency(0), steady.small.modes().unwrap().frequency(0), 1e-11);
    }
}

/// ω² = g/a, from below and from above, and the branch aside: cos θ = g/(aω²).
#[test]
fn the_pitchfork_of_the_bead_in_the_spinning_tube() {
    let reference = Reference::read("ex-11.5a-bead-in-spinning-tube");
    let p = |name: &str| reference.parameter(name);
    let bead = Bead::new(p("m"), p("a"), p("g"), 0.0);
    let family = |om: Dual<f64>| Bead { om, ..bead.map(Dual::constant) };
    let path = Path { range: (1.0, 8.0), step: 0.1, steps: 500 };
    let critical = reference.special("/critical_speed/value");
    let mut direction = None;
    for (from, heading) in [(1.5, Heading::Up), (7.5, Heading::Down)] {
        let bottom = follow(&family, &[0.0], from, &heading, &path).unwrap();
        assert_eq!(bottom.bifurcations.len(), 1, "{:?}", bottom.bifurcations);
        let found = &bottom.bifurcations[0];
        assert_eq!(found.kind, BifurcationKind::Pitchfork);
        close(found.parameter, critical, 1e-13);
        assert!(found.q[0].abs() < 1e-12);
        assert!(bottom.points.iter().all(|p| p.negative == usize::from(p.parameter > critical)));
        direction = Some(found.direction.clone());
    }
    let direction = direction.unwrap();
    for (sign, half) in [(1.0, &direction), (-1.0, &-&direction)] {
        let aside = follow(&family, &[0.0], critical, &Heading::Along(half.clone()), &path).unwrap();
        assert!(aside.points.len() > 10 && aside.bifurcations.is_empty(), "{:?}", aside.bifurcations);
        for point in &aside.points[1..] {
            let exact = (p("g") / (p("a") * point.parameter * point.parameter)).acos();
            assert!((sign * point.q[0] - exact).abs() < 1e-12 && point.negative == 0, "{point:?} {exact}");
        }
        assert!(aside.points.last().unwrap().parameter > 8.0);
    }
    // Along the branch itself the parameter turns back there, which is no fold.
    let aside = follow(&family, &[1.2], 7.5, &Heading::Down, &path).unwrap();
    assert_eq!(aside.bifurcations.len(), 1, "{:?}", aside.bifurcations);
    assert_eq!(aside.bifurcations[0].kind, BifurcationKind::Pitchfork);
    close(aside.bifurcations[0].parameter, critical, 1e-12);
    assert!(aside.points.last().unwrap().q[0] < -1.0, "and on to the other side");
}

/// The load p(y) = 2 k y (√(1 + h²)/√(1 + y²) − 1) is greatest where 1 + y² = (1 + h²)^{1/3}.
#[test]
fn the_folds_of_an_arch_that_snaps_through() {
    let (h, k) = (0.8f64, 3.0);
    let family = |p: Dual<f64>| Arch { p, ..Arch::new(h, k, 0.0).map(Dual::constant) };
    let path = Path { range: (-2.0, 2.0), step: 0.05, steps: 1000 };
    let branch = follow(&family, &[h], 0.0, &Heading::Up, &path).unwrap();
    let long = (1.0 + h * h).sqrt();
    let y = (long.powf(2.0 / 3.0) - 1.0).sqrt();
    let load = 2.0 * k * y * (long / (1.0 + y * y).sqrt() - 1.0);
    let folds = &branch.bifurcations;
    assert_eq!(folds.iter().map(|f| f.kind).collect::<Vec<_>>(), [BifurcationKind::Fold; 2]);
    close(folds[0].parameter, load, 1e-13);
    close(folds[1].parameter, -load, 1e-13);
    assert!((folds[0].q[0] - y).abs() < 1e-7 && (folds[1].q[0] + y).abs() < 1e-7);
    assert!(branch.points.iter().all(|p| p.negative == usize::from(p.q[0].abs() < y)));
}

#[test]
fn a_transcritical_crossing() {
    let family = |mu: Dual<f64>| Crossing { mu };
    let path = Path { range: (-1.0, 1.0), step: 0.07, steps: 500 };
    let branch = follow(&family, &[0.0; 2], -0.9, &Heading::Up, &path).unwrap();
    assert_eq!(branch.bifurcations.len(), 1);
    assert_eq!(branch.bifurcations[0].kind, BifurcationKind::Transcritical);
    assert!(branch.bifurcations[0].parameter.abs() < 1e-13);
}

#[test]
fn no_curve_to_follow() {
    let family = |p: Dual<f64>| Arch { p, ..Arch::new(0.8, 3.0, 0.0).map(Dual::constant) };
    let path = Path { range: (-2.0, 2.0), step: 0.0, steps: 10 };
    let error = follow(&family, &[0.8], 0.0, &Heading::Up, &path).unwrap_err();
    assert!(matches!(error, AnalysisError::NotApplicable { .. }));
    let path = Path { step: 0.1, ..path };
    let short = Heading::Along(DVector::zeros(1));
    let error = follow(&family, &[0.8], 0.0, &short, &path).unwrap_err();
    assert_eq!(error, AnalysisError::Dimension { expected: 2, found: 1 });
    let lost = |p: Dual<f64>| Arch { p, ..Arch::new(0.8, f64::NAN, 0.0).map(Dual::constant) };
    for heading in [Heading::Up, Heading::Along(DVector::from_vec(vec![1.0, 0.0]))] {
        assert_eq!(follow(&lost, &[0.8], 0.0, &heading, &path).unwrap_err(), AnalysisError::NotFinite);
    }
}

lagrangian! {
    /// A rod on a spring of stiffness k that carries the load p.
    pub system Rod {
        param k, p;
        coord q;
        T = 0.5 * dot(q).powi(2);
        V = 0.5 * k * q.powi(2) - p * (1 - q.cos());
    }
}

/// Nothing but a bifurcation at the start itself is left out because it is near to the start.
#[test]
fn a_pitchfork_much_nearer_than_the_step() {
    for k in [2e-7, 1e-7, 3e-8] {
        let family = |p: Dual<f64>| Rod { p, ..Rod::new(k, 0.0).map(Dual::constant) };
        let path = Path { range: (0.0, 3.0), step: 1.0, steps: 100 };
        let branch = follow(&family, &[0.0], 0.0, &Heading::Up, &path).unwrap();
        assert_eq!((branch.points[0].negative, branch.points.last().unwrap().negative), (0, 1));
        assert_eq!(branch.bifurcations.len(), 1, "{k} {branch:?}");
        assert!((branch.bifurcations[0].parameter - k).abs() < 1e-13);
    }
}
