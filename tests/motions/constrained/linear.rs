//! Linear models against duals of projected states.

use crate::bicycle::{Bicycle, benchmark};
use crate::systems::*;
use lagrange_runtime::analysis::*;
use lagrange_runtime::prelude::*;
use lagrange_runtime::traits::{InputJacobian, System};

/// The rates of deviations that are projected on the constraints by duals, against `A x`; both by the states of the
/// model.
fn agrees<Over: System<N, Scalar = Dual<f64>>, const N: usize>(
    over: &Over,
    at: &State<f64, N>,
    model: &StateSpace,
) {
    let StateSpace { a, basis, states, .. } = model;
    let mut largest = 0.0f64;
    for direction in 0..2 * N {
        let mut moved = at.map(Dual::constant);
        (if direction < N { &mut moved.q[direction] } else { &mut moved.qd[direction - N] }).slope = 1.0;
        let moved = over.toward_constraints(&moved);
        let rates = over.accel(&moved.q, &moved.qd, moved.t);
        let all = |x: &SVector<Dual<f64>, N>, y: &SVector<Dual<f64>, N>| {
            DVector::from_fn(2 * N, |i, _| if i < N { x[i].slope } else { y[i - N].slope })
        };
        let (deviation, change) = (all(&moved.q, &moved.qd), all(&moved.qd, &rates));
        let x = deviation.select_rows(states);
        assert!((basis * &x - &deviation).amax() < 1e-13 * deviation.amax().max(1.0), "{direction}");
        let expected = change.select_rows(states);
        let size = a.abs() * x.abs();
        let off = (a * &x - &expected).amax() / size.amax().max(1.0);
        largest = largest.max(off);
    }
    assert!(largest < 1e-12, "{largest:e}");
}

#[test]
fn a_moving_linkage_with_a_motor() {
    let mut bars = FourBar::new(0.12, 0.32, 0.25, 0.3, 0.4, 0.9, 0.7);
    bars.torque = 0.7;
    let guess = State::new(0.3, [0.9, 0.6, 1.4], [3.0, 0.0, 0.0]);
    let at = consistent(&bars, &guess).unwrap();
    let model = StateSpace::about(&bars, &at).unwrap();
    assert_eq!((model.states.len(), model.b.shape()), (2, (2, 1)));
    agrees(&bars.map(Dual::constant), &at, &model);
    // The input: the same row of ∂q̈/∂u, none of q̇.
    let by_torque = bars.input_jacobian(&at.q, &at.qd, at.t)[(model.states[0], 0)];
    assert_eq!((model.b[(0, 0)], model.b[(1, 0)]), (0.0, by_torque));
    // Outputs along the admitted deviation.
    let model = model.observed(&bars, &at, |bars, s| bars.rocker(&s.q, &s.qd, s.t).into()).unwrap();
    let along = model.basis.column(0);
    let chi = at.q[2];
    assert!((model.c[(0, 0)] + 0.25 * chi.sin() * along[2]).abs() < 1e-15);
    assert!((model.c[(1, 0)] - 0.25 * chi.cos() * along[2]).abs() < 1e-15);
    // The eigenvalues of A are those of the small motions.
    let mut found: Vec<_> = SmallMotion::about(&bars, &at).unwrap().spectrum().unwrap().eigenvalues;
    let a = &model.a;
    let (trace, determinant) = (a.trace(), a.determinant());
    found.iter_mut().for_each(|z| *z = *z * *z - *z * trace + determinant);
    assert!(found.iter().all(|z| z.norm() < 1e-12 * determinant.abs().max(trace * trace)), "{found:?}");
    let sampled = model.sampled(1e-3).unwrap();
    assert!((sampled.b[(1, 0)] / by_torque - 1e-3).abs() < 1e-5);
}

/// A as it is made of small motions: `ż = P u + …` is compared through the spectrum, and J through duals of projected
/// states.
#[test]
fn rolling_bodies() {
    let wheel = Wheel::new(1.3, 0.4, 0.5, 0.25);
    let at = State::new(0.0, [0.1, 0.2, 0.4, 0.3, 0.0], [0.0, 0.0, 0.7, 0.2, 2.0]);
    let at = consistent(&wheel, &at).unwrap();
    let small = SmallMotion::about(&wheel, &at).unwrap();
    let over = wheel.map(Dual::constant);
    let names = Wheel::<f64>::FACTS.coordinates;
    let index = |name: &String| names.iter().position(|n| n == name).unwrap();
    let own: Vec<usize> = small.names().iter().map(index).collect();
    for direction in 0..10 {
        let mut moved = at.map(Dual::constant);
        (if direction < 5 { &mut moved.q[direction] } else { &mut moved.qd[direction - 5] }).slope = 1.0;
        let moved = over.toward_constraints(&moved);
        let rates = over.accel(&moved.q, &moved.qd, moved.t);
        let part = |x: &SVector<Dual<f64>, 5>| DVector::from_fn(3, |i, _| x[own[i]].slope);
        let (x, v, expected) = (part(&moved.q), part(&moved.qd), part(&rates));
        let rest = small.inertia() * expected + small.velocity_terms() * v + small.stiffness() * x;
        assert!(rest.amax() < 1e-12, "{direction} {rest}");
    }
}

#[test]
fn a_bicycle_that_leans_and_turns() {
    let bicycle = benchmark();
    let guess =
        State::new(0.0, [0.0, 0.0, 0.1, 0.2, 0.0, 0.15, 0.0, 0.0], [3.0, 0.0, 0.2, 0.1, 0.0, 0.3, 10.0, 9.0]);
    let at = consistent(&bicycle, &guess).unwrap();
    let small = SmallMotion::about(&bicycle, &at).unwrap();
    assert_eq!((small.dimension(), small.constants().len()), (3, 4));
    let over = bicycle.map(Dual::constant);
    let names = Bicycle::<f64>::FACTS.coordinates;
    let own: Vec<usize> =
        small.names().iter().map(|name| names.iter().position(|n| n == name).unwrap()).collect();
    let scale = small.stiffness().amax();
    for direction in 0..16 {
        let mut moved = at.map(Dual::constant);
        (if direction < 8 { &mut moved.q[direction] } else { &mut moved.qd[direction - 8] }).slope = 1.0;
        let moved = over.toward_constraints(&moved);
        let rates = over.accel(&moved.q, &moved.qd, moved.t);
        let part = |x: &SVector<Dual<f64>, 8>| DVector::from_fn(3, |i, _| x[own[i]].slope);
        let (x, v, expected) = (part(&moved.q), part(&moved.qd), part(&rates));
        // What the led coordinates leave of ẇ = u is nothing: velocities are those of the names.
        let rest = small.inertia() * expected + small.velocity_terms() * v + small.stiffness() * x;
        assert!(rest.amax() < 1e-12 * scale, "{direction} {rest}");
    }
}
