//! States at which the equations of motion have no linearization: switches of the forces.

use super::{AnalysisError, kink};
use crate::scalar::{Real, Scalar};
use crate::state::State;
use crate::system::{Lagrangian, Linearize, System};
use nalgebra::{DMatrix, DVector, SVector};

/// Most switches at one state whose sides are compared, 2ᵏ of them.
const MAX_SWITCHES: usize = 10;

/// Displacements from a switch, relative to `1 + |x|`, at which its sides are compared.
pub(super) const DISPLACEMENTS: [f64; 2] = [1e-7, 1e-10];

/// Values of the switching functions at rest at `q`.
pub(super) fn switching<Sys: System<N>, const N: usize>(system: &Sys, q: &SVector<Sys::Scalar, N>) -> Vec<f64>
where
    Sys::Scalar: Real,
{
    let still = q.map(|_| Sys::Scalar::from_f64(0.0));
    let at = State { t: Sys::Scalar::from_f64(0.0), q: *q, qd: still };
    rates(system, &at, &still).iter().map(|[value, _]| *value).collect()
}

/// Forces, M, C and K at a state.
pub(super) type Equations = [DMatrix<f64>; 4];

/// `b − f` with M and its derivatives.
pub(super) fn linearized<Sys: Linearize<N>, const N: usize>(
    system: &Sys,
    at: &State<Sys::Scalar, N>,
) -> Equations
where
    Sys::Scalar: Real,
{
    let State { t, q, qd } = at;
    let rest = system.convective_momentum_rate(q, qd, *t) - system.momentum_rate(q, qd, *t);
    let linear = system.linearize(q, qd, *t);
    let [m, c, k] = [system.inertia(q, qd, *t), linear.damping, linear.stiffness]
        .map(|a| DMatrix::from_fn(N, N, |i, j| a[(i, j)].to_f64()));
    [DMatrix::from_fn(N, 1, |i, _| rest[i].to_f64()), m, c, k]
}

/// Refuses a state on a switch or a kink of the forces. `uncertainty` is that of the coordinates, relative to
/// `1 + |q|`.
pub(super) fn smooth<Sys: Lagrangian<N>, const N: usize>(
    system: &Sys,
    at: &State<Sys::Scalar, N>,
    uncertainty: f64,
    equations: impl Fn(&Sys, &State<Sys::Scalar, N>) -> Equations,
) -> Result<(), AnalysisError>
where
    Sys::Scalar: Real,
{
    off_switches(system, at, uncertainty, &equations)?;
    kink::smooth(system, at, uncertainty, equations)
}

/// Refuses a state on a switch, unless forces and their derivatives have the same limits from all of its sides, as
/// quadratic drag `−c |v| v` has at rest. The limits are compared by how differences of the sides shrink with the
/// distance from the state.
fn off_switches<Sys: System<N>, const N: usize>(
    system: &Sys,
    at: &State<Sys::Scalar, N>,
    uncertainty: f64,
    equations: impl Fn(&Sys, &State<Sys::Scalar, N>) -> Equations,
) -> Result<(), AnalysisError>
where
    Sys::Scalar: Real,
{
    if const { Sys::SWITCHES == 0 } {
        return Ok(());
    }
    let still = at.q.map(|_| Sys::Scalar::from_f64(0.0));
    let gradients = gradients(system, at);
    let size = |i: usize| 1.0 + if i < N { at.q[i] } else { at.qd[i - N] }.to_f64().abs();
    let rounding = kink::BESIDE + uncertainty;
    let met: Vec<usize> = rates(system, at, &still)
        .iter()
        .enumerate()
        .filter(|(k, [value, _])| {
            let change: f64 = (0..2 * N).map(|i| gradients[(*k, i)].abs() * size(i)).sum();
            // A gradient that is not a number says nothing against the value.
            !(value.abs() > rounding * change || change.is_nan() && value.abs() > 0.0)
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
            let q = SVector::from_fn(|i, _| at.q[i] + moved(i));
            let qd = SVector::from_fn(|i, _| at.qd[i] + moved(N + i));
            let there = State { t: at.t, q, qd };
            let values = rates(system, &there, &still);
            if !(0..met.len()).all(|k| values[met[k]][0] * sign(k) > 0.0) {
                return refused;
            }
            let found = equations(system, &there);
            let reference = first.get_or_insert_with(|| found.clone());
            for (which, (a, b)) in reference.iter().zip(&found).enumerate() {
                spread[which] = spread[which].max((a - b).amax());
                sizes[which] = sizes[which].max(b.amax());
            }
        }
    }
    // Forces that cancel are as uncertain as a displacement by rounding makes them.
    sizes[0] += sizes[3] * (1.0 + at.q.iter().map(|x| x.to_f64().abs()).fold(0.0, f64::max));
    match (0..4).all(|which| shrinks(spread.map(|spread| spread[which]), sizes[which])) {
        true => Ok(()),
        false => refused,
    }
}

/// Returns whether the differences of two sides at the [`DISPLACEMENTS`], of values of this size, vanish at the switch.
pub(super) fn shrinks([far, near]: [f64; 2], size: f64) -> bool {
    near <= (0.01 * far).max(256.0 * f64::EPSILON * size)
}

/// Values and rates of the switching functions.
fn rates<Sys: System<N>, const N: usize>(
    system: &Sys,
    at: &State<Sys::Scalar, N>,
    accelerations: &SVector<Sys::Scalar, N>,
) -> Vec<[f64; 2]>
where
    Sys::Scalar: Real,
{
    let mut found = vec![[0.0; 2]; Sys::SWITCHES];
    system.switches(at, accelerations, |k, both| found[k] = both.map(Real::to_f64));
    found
}

/// Gradients of the switching functions by (q, q̇), each a row: their rates are linear in accelerations, and in
/// velocities as these vanish. Where velocities and coordinates switch together, those by q are of a slow motion.
fn gradients<Sys: System<N>, const N: usize>(system: &Sys, at: &State<Sys::Scalar, N>) -> DMatrix<f64>
where
    Sys::Scalar: Real,
{
    const SLOW: f64 = 1e-100;
    let zero = Sys::Scalar::from_f64(0.0);
    let still = at.q.map(|_| zero);
    let along =
        |i: usize, x: f64| SVector::from_fn(|j, _| if i == j { Sys::Scalar::from_f64(x) } else { zero });
    let at_rest = rates(system, at, &still);
    let mut gradients = DMatrix::zeros(Sys::SWITCHES, 2 * N);
    for i in 0..N {
        let moving = |speed: f64| rates(system, &State { t: at.t, q: at.q, qd: along(i, speed) }, &still);
        for (k, ([_, slow], [_, fast])) in moving(SLOW).into_iter().zip(moving(1.0)).enumerate() {
            // Beside a rate by time alone that of a slow motion is rounding.
            let rate = at_rest[k][1];
            gradients[(k, i)] = if rate == 0.0 { slow / SLOW } else { fast - rate };
        }
        for (k, [_, rate]) in rates(system, at, &along(i, 1.0)).into_iter().enumerate() {
            gradients[(k, N + i)] = rate - at_rest[k][1];
        }
    }
    gradients
}
