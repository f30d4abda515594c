//! Motions against reference digits, and what a motion conserves.
//!
//! What is allowed is computed, not chosen. Each step of [`Dop853`] may err by the tolerance, which its controller keeps
//! in the root mean square over all coordinates and velocities, so that a single one may err by `√2N` times that. An
//! error δ made in step k has become `Φ(t, tₖ) δ` at time t, where Φ is the derivative of the flow, here by dual numbers.
//! The errors of different steps are taken for independent, so their squares add up (Henrici, *Discrete Variable Methods
//! in Ordinary Differential Equations*, 1962). What is conserved, `C(x)`, needs no Φ: the error δ changes it by
//! `∇C·δ` for good.

use super::{Golden, Point, Quantity, Reference, State, facts};
use lagrange_runtime::{Dop853, Dual, Pi, Real, integrate};
use nalgebra::{DMatrix, DVector};

/// Absolute and relative, of every step.
const TOLERANCE: f64 = 1e-13;

/// The motion in the file, at quarters of its time and at its end, and its conserved quantities at every step.
pub fn check_trajectory<G: Golden<N>, const N: usize>() {
    let reference = Reference::read(G::REFERENCE);
    let expected = reference.trajectory::<N>();
    let motion = motion::<G, N, f64>(&reference, &expected, |_, value| value);
    check_ends::<G, N>(&reference, &expected, &motion);
    check_conserved::<G, N>(&reference, &expected[0], &motion);
}

/// A state at the end of a step, q and q̇ in one vector.
struct At<S> {
    t: S,
    x: Vec<S>,
}

/// Every step from the first of the given states through the times of the others, where `entry` makes the numbers of the
/// start.
fn motion<G: Golden<N>, const N: usize, S: Real>(
    reference: &Reference,
    through: &[State<N>],
    entry: impl Fn(usize, f64) -> S,
) -> Vec<At<S>> {
    let system = G::with(|name| S::from_f64(reference.parameter(name)));
    let start = &through[0];
    let q = std::array::from_fn(|k| entry(k, start.q[k]));
    let qd = std::array::from_fn(|k| entry(N + k, start.qd[k]));
    let start = lagrange_runtime::State::new(S::from_f64(start.t), q, qd);
    let mut run = integrate(&system, Dop853, Pi::tolerance(TOLERANCE), start);
    let mut steps = Vec::new();
    for end in &through[1..] {
        run = run.until(S::from_f64(end.t));
        for step in run.by_ref() {
            let to = step.unwrap_or_else(|failure| panic!("{}: {failure}", G::REFERENCE)).to;
            steps.push(At { t: to.t, x: to.q.iter().chain(&to.qd).copied().collect() });
        }
    }
    steps
}

/// The derivative of the flow from the start to the end of each step.
fn propagators<G: Golden<N>, const N: usize>(
    reference: &Reference,
    through: &[State<N>],
) -> Vec<DMatrix<f64>> {
    let columns: Vec<_> = (0..2 * N)
        .map(|j| {
            motion::<G, N, Dual<f64>>(reference, through, |i, value| {
                if i == j { Dual::variable(value) } else { Dual::constant(value) }
            })
        })
        .collect();
    (0..columns[0].len()).map(|k| DMatrix::from_fn(2 * N, 2 * N, |i, j| columns[j][k].x[i].slope)).collect()
}

/// How far a single step that ends here may be off in each coordinate and velocity.
fn tolerated(at: &At<f64>) -> DVector<f64> {
    let single = TOLERANCE * (at.x.len() as f64).sqrt();
    DVector::from_iterator(at.x.len(), at.x.iter().map(|x| single * (1.0 + x.abs())))
}

fn check_ends<G: Golden<N>, const N: usize>(
    reference: &Reference,
    expected: &[State<N>],
    motion: &[At<f64>],
) {
    let propagators = propagators::<G, N>(reference, expected);
    assert_eq!(propagators.len(), motion.len(), "{}: duals change no step", G::REFERENCE);
    for expected in &expected[1..] {
        let last = motion.iter().position(|at| at.t == expected.t);
        let last = last.unwrap_or_else(|| panic!("{}: no step to t = {}", G::REFERENCE, expected.t));
        let mut allowed = DVector::zeros(2 * N);
        for (at, propagator) in motion.iter().zip(&propagators).take(last + 1) {
            let back = propagator.clone().try_inverse().expect("the flow can be reversed");
            let error = (&propagators[last] * back).abs() * tolerated(at);
            allowed += error.component_mul(&error);
        }
        let allowed = allowed.map(f64::sqrt);
        for (k, expected_x) in expected.q.iter().chain(&expected.qd).enumerate() {
            let error = (motion[last].x[k] - expected_x).abs();
            assert!(
                error <= allowed[k],
                "{}: x[{k}] at t = {} is off by {error:.1e}, allowed {:.1e}",
                G::REFERENCE,
                expected.t,
                allowed[k]
            );
        }
    }
}

/// The energy function and the momenta of ignorable coordinates.
fn check_conserved<G: Golden<N>, const N: usize>(
    reference: &Reference,
    start: &State<N>,
    motion: &[At<f64>],
) {
    let facts = facts::<G, N>();
    let energy = facts.conservative.then_some((Quantity::Jacobi, 0));
    let momenta = facts.ignorable.iter().map(|&k| (Quantity::Momenta, k));
    for (quantity, k) in energy.into_iter().chain(momenta) {
        let place = |t: f64| format!("{} at t = {t}", G::REFERENCE);
        let start = Point::<G, N>::new(place(start.t), reference, start);
        let conserved = start.value(quantity)[k];
        let mut allowed = 0.0;
        for at in motion {
            let state = State {
                q: nalgebra::SVector::from_column_slice(&at.x[..N]),
                qd: nalgebra::SVector::from_column_slice(&at.x[N..]),
                t: at.t,
            };
            let point = Point::<G, N>::new(place(at.t), reference, &state);
            let errors = tolerated(at);
            let change: f64 = (0..2 * N).map(|i| (point.partial(quantity, i)[k] * errors[i]).abs()).sum();
            allowed = f64::hypot(allowed, change);
            let error = (point.value(quantity)[k] - conserved).abs();
            let bound = allowed + point.bound(quantity, conserved.abs());
            assert!(
                error <= bound,
                "{}: {quantity:?}[{k}] has drifted by {error:.1e}, allowed {bound:.1e}",
                point.place
            );
        }
    }
}
