//! Systems of which what does not change was computed before.

use lagrange_runtime::Facts;
use lagrange_runtime::prelude::*;
use lagrange_runtime::traits::Prescribed;

lagrangian! {
    system Spring {
        param m, k;
        coord x;
        T = 0.5 * m * dot(x).powi(2);
        V = 0.5 * k * x.powi(2);
    }
}

lagrangian! {
    /// The bob of a pendulum in Cartesian coordinates, on a driven pivot.
    system Bob {
        param m, l, g = 9.81, c = 0.1;
        coord x, y;
        coord u = 0.1 * sin(3 * t);
        constraint rod: (x - u).powi(2) + y.powi(2) - l.powi(2) == 0;
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
        V = m * g * y;
        D = 0.5 * c * (dot(x).powi(2) + dot(y).powi(2));
    }
}

lagrangian! {
    system Double {
        param m1, m2, l1, l2, g = 9.81;
        coord a: angle, b: angle;
        let x = l1 * sin(a) + l2 * sin(b);
        let y = -l1 * cos(a) - l2 * cos(b);
        T = 0.5 * m1 * (l1 * dot(a)).powi(2) + 0.5 * m2 * (dot(x).powi(2) + dot(y).powi(2));
        V = -m1 * g * l1 * cos(a) + m2 * g * y;
    }
}

lagrangian! {
    system Free {
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = 0;
    }
}

/// The end of a run, and of the same run of the prepared system: every bit of each.
fn both<Sys, M, C, const N: usize>(system: Sys, method: M, controller: C, start: State<f64, N>)
where
    Sys: Precompute<N, Scalar = f64> + Copy,
    M: Method<Sys, N> + Clone,
    M: Method<Precomputed<Sys, N>, N, Error = <M as Method<Sys, N>>::Error>,
    C: lagrange_runtime::Controller<f64, N, <M as Method<Sys, N>>::Error>,
{
    let prepared = system.precomputed();
    let plain = integrate(&system, method.clone(), controller.clone(), start).until(2.0).final_state();
    let once = integrate(&prepared, method, controller, start).until(2.0).final_state();
    let bits = |end: Result<State<f64, N>, lagrange_runtime::integrate::Failed<f64, N>>| {
        let end = end.expect("a sound run");
        (end.q.map(f64::to_bits), end.qd.map(f64::to_bits), end.t.to_bits())
    };
    assert_eq!(bits(once), bits(plain));
}

#[test]
fn every_family_gives_the_same_bits() {
    let spring = Spring::new(2.0, 3.0);
    let start = State::new(0.0, [1.0], [0.3]);
    let fixed = FixedStep::new(0.01);
    both(spring, Rk4, fixed, start);
    both(spring, Verlet, fixed, start);
    both(spring, lagrange_runtime::Nystrom12, PiController::tolerance(1e-9), start);
    both(spring, MatrixExponential, fixed, start);
    let double = Double::new(1.0, 2.0, 0.7, 0.4);
    let start = State::new(0.0, [1.0, -0.5], [0.1, 0.3]);
    both(double, Dop853, PiController::tolerance(1e-9), start);
    both(double, Gauss4, fixed, start);
    both(double, Radau5, PiController::tolerance(1e-7), start);
    both(double, Rodas5P, PiController::tolerance(1e-7), start);
    both(double, Taylor, TaylorController::tolerance(1e-9), start);
    both(double, VariationalMidpoint, fixed, start);
}

#[test]
fn constraints_are_kept_and_multipliers_known() {
    let bob = Bob::new(1.5, 0.8);
    let start = State::new(0.0, [0.8, 0.0], [0.3, 0.0]);
    both(bob, Dop853, PiController::tolerance(1e-9), start);
    let prepared = bob.precomputed();
    let (q, qd) = (start.q, start.qd);
    assert_eq!(Constrained::multipliers(&prepared, &q, &qd, 0.0), bob.multipliers(&q, &qd, 0.0));
    assert_eq!(Prescribed::reactions(&prepared, &q, &qd, 0.0), bob.reactions(&q, &qd, 0.0));
    assert_eq!(prepared.facts_of_type(), Bob::<f64>::FACTS);
    assert_eq!(prepared.jump(&start, &qd), bob.jump(&start, &qd));
}

trait FactsOf<const N: usize> {
    fn facts_of_type(&self) -> Facts;
}

impl<Sys: Lagrangian<N>, const N: usize> FactsOf<N> for Sys {
    fn facts_of_type(&self) -> Facts {
        Sys::FACTS
    }
}

#[test]
fn what_follows_from_parameters_follows_from_these() {
    let mut double = Double::new(1.0, 2.0, 0.7, 0.4);
    let prepared = double.precomputed();
    assert!(!prepared.constants().is_empty());
    double.l2 = 4.0;
    assert_eq!(prepared.l2, 0.4);
    let (q, qd) = (SVector::from([1.0, -0.5]), SVector::from([0.1, 0.3]));
    assert_ne!(prepared.accel(&q, &qd, 0.0), double.accel(&q, &qd, 0.0));
    assert_eq!(double.precomputed().accel(&q, &qd, 0.0), double.accel(&q, &qd, 0.0));
    assert_eq!(prepared.into_inner(), Double::new(1.0, 2.0, 0.7, 0.4));
    assert!(Free::new().precomputed().constants().is_empty());
}
