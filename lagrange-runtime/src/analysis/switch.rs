//! States at which the equations of motion have no linearization: switches of the forces.

use super::AnalysisError;
use crate::scalar::{Real, Scalar};
use crate::state::State;
use crate::system::Linearize;
use nalgebra::{DMatrix, DVector, SVector};

/// Most switches at one state whose sides are compared, 2ᵏ of them.
const MAX_SWITCHES: usize = 10;

/// Displacements from a switch, relative to `1 + |x|`, at which its sides are compared.
const DISPLACEMENTS: [f64; 2] = [1e-7, 1e-10];

/// Values of the switching functions at rest at `q`.
pub(super) fn switching<Sys: Linearize<N>, const N: usize>(
    system: &Sys,
    q: &SVector<Sys::Scalar, N>,
) -> Vec<f64>
where
    Sys::Scalar: Real,
{
    let still = q.map(|_| Sys::Scalar::from_f64(0.0));
    rates(system, q, &still, &still).iter().map(|[value, _]| *value).collect()
}

/// Refuses an equilibrium on a switch, unless forces and their derivatives have the same limits from all of its sides, as
/// quadratic drag `−c |v| v` has at rest. The limits are compared by how differences of the sides shrink with the distance
/// from the state. `uncertainty` is that of the coordinates, relative to `1 + |q|`.
pub(super) fn smooth<Sys: Linearize<N>, const N: usize>(
    system: &Sys,
    q: &SVector<Sys::Scalar, N>,
    uncertainty: f64,
) -> Result<(), AnalysisError>
where
    Sys::Scalar: Real,
{
    if Sys::SWITCHES == 0 {
        return Ok(());
    }
    let still = q.map(|_| Sys::Scalar::from_f64(0.0));
    let gradients = gradients(system, q);
    let size = |i: usize| if i < N { 1.0 + q[i].to_f64().abs() } else { 1.0 };
    let rounding = 64.0 * f64::EPSILON + uncertainty;
    let met: Vec<usize> = rates(system, q, &still, &still)
        .iter()
        .enumerate()
        .filter(|(k, [value, _])| {
            let change: f64 = (0..2 * N).map(|i| gradients[(*k, i)].abs() * size(i)).sum();
            // A gradient that is not a number says nothing against the value.
            !(value.abs() > rounding * change) && !(change.is_nan() && value.abs() > 0.0)
        })
        .map(|(k, _)| k)
        .collect();
    let Some(&index) = met.first() else { return Ok(()) };
    let refused = Err(AnalysisError::Switch { index });
    // Displacements along which each of the functions changes by itself.
    let scaled = DMatrix::from_fn(met.len(), 2 * N, |k, i| gradients[(met[k], i)] * size(i));
    let norms: Vec<f64> = scaled.row_iter().map(|row| row.norm()).collect();
    if met.len() > MAX_SWITCHES || norms.iter().any(|x| !(*x > 0.0 && x.is_finite())) {
        return refused;
    }
    let unit = DMatrix::from_fn(met.len(), 2 * N, |k, i| scaled[(k, i)] / norms[k]);
    let Ok(inverse) = unit.pseudo_inverse(1e-6) else { return refused };
    let mut spread = [[0.0f64; 4]; 2];
    let mut sizes = [0.0f64; 4];
    for (far, spread) in DISPLACEMENTS.iter().zip(&mut spread) {
        let mut first: Option<[DMatrix<f64>; 4]> = None;
        for side in 0..1usize << met.len() {
            let sign = |k: usize| if side >> k & 1 == 0 { 1.0 } else { -1.0 };
            let towards = &inverse * DVector::from_fn(met.len(), |k, _| sign(k));
            let moved = |i: usize| Sys::Scalar::from_f64(far * towards[i] * size(i));
            let there = SVector::from_fn(|i, _| q[i] + moved(i));
            let driven = SVector::from_fn(|i, _| moved(N + i));
            let values = rates(system, &there, &driven, &still);
            if (0..met.len()).any(|k| !(values[met[k]][0] * sign(k) > 0.0)) {
                return refused;
            }
            let found = equations(system, &there, &driven);
            let reference = first.get_or_insert_with(|| found.clone());
            for (which, (a, b)) in reference.iter().zip(&found).enumerate() {
                spread[which] = spread[which].max((a - b).amax());
                sizes[which] = sizes[which].max(b.amax());
            }
        }
    }
    // Forces that cancel are as uncertain as a displacement by rounding makes them.
    sizes[0] += sizes[3] * (1.0 + q.iter().map(|x| x.to_f64().abs()).fold(0.0, f64::max));
    let shrinks = |which: usize| {
        let floor = 256.0 * f64::EPSILON * sizes[which];
        spread[1][which] <= (0.01 * spread[0][which]).max(floor)
    };
    match (0..4).all(shrinks) {
        true => Ok(()),
        false => refused,
    }
}

/// `bias − force`, M, C and K at a state.
fn equations<Sys: Linearize<N>, const N: usize>(
    system: &Sys,
    q: &SVector<Sys::Scalar, N>,
    qd: &SVector<Sys::Scalar, N>,
) -> [DMatrix<f64>; 4]
where
    Sys::Scalar: Real,
{
    let t = Sys::Scalar::from_f64(0.0);
    let rest = system.bias(q, qd, t) - system.force(q, qd, t);
    let linear = system.linearize(q, qd, t);
    let [m, c, k] = [system.inertia(q, qd, t), linear.damping, linear.stiffness]
        .map(|a| DMatrix::from_fn(N, N, |i, j| a[(i, j)].to_f64()));
    [DMatrix::from_fn(N, 1, |i, _| rest[i].to_f64()), m, c, k]
}

/// Values and rates of the switching functions.
fn rates<Sys: Linearize<N>, const N: usize>(
    system: &Sys,
    q: &SVector<Sys::Scalar, N>,
    qd: &SVector<Sys::Scalar, N>,
    accelerations: &SVector<Sys::Scalar, N>,
) -> Vec<[f64; 2]>
where
    Sys::Scalar: Real,
{
    let mut found = vec![[0.0; 2]; Sys::SWITCHES];
    let at = State { t: Sys::Scalar::from_f64(0.0), q: *q, qd: *qd };
    system.switches(&at, accelerations, |k, both| found[k] = both.map(Real::to_f64));
    found
}

/// Gradients of the switching functions by (q, q̇) at rest, each a row. Their rates are linear in accelerations, and in
/// velocities as these vanish.
fn gradients<Sys: Linearize<N>, const N: usize>(system: &Sys, q: &SVector<Sys::Scalar, N>) -> DMatrix<f64>
where
    Sys::Scalar: Real,
{
    const SLOW: f64 = 1e-100;
    let still = q.map(|_| Sys::Scalar::from_f64(0.0));
    let along =
        |i: usize, x: f64| SVector::from_fn(|j, _| Sys::Scalar::from_f64(if i == j { x } else { 0.0 }));
    let mut gradients = DMatrix::zeros(Sys::SWITCHES, 2 * N);
    for i in 0..N {
        for (k, [_, rate]) in rates(system, q, &along(i, SLOW), &still).into_iter().enumerate() {
            gradients[(k, i)] = rate / SLOW;
        }
        for (k, [_, rate]) in rates(system, q, &still, &along(i, 1.0)).into_iter().enumerate() {
            gradients[(k, N + i)] = rate;
        }
    }
    gradients
}
