//! Causes of failures, as far as the inertia matrix of a system tells them.

use crate::failed::Failed;
use crate::failure::{Coordinate, Failure, Part};
use crate::linear::{Ldlt, Singular, factored, ldlt, lu_solve};
use crate::scalar::{Functions, Real, Scalar, SimdScalar};
use crate::state::State;
use crate::system::Lagrangian;
use nalgebra::{SMatrix, SVector};

impl Coordinate {
    /// The coordinate of `Sys` at `index`.
    pub fn of<Sys: Lagrangian<N>, const N: usize>(index: usize) -> Self {
        Coordinate { index, name: Sys::FACTS.coordinates.get(index).copied().unwrap_or_default() }
    }

    /// The coordinate at `index` of a system that is given by its matrices alone.
    #[cfg(feature = "analysis")]
    pub(crate) fn unnamed(index: usize) -> Self {
        Coordinate { index, name: "" }
    }
}

/// The reason why a Lagrangian system has no finite accelerations at `at`: its inertia matrix is singular, or else
/// a state or force that is not finite, met by the step of size `h`.
pub fn why_not_finite<Sys: Lagrangian<N>, const N: usize>(
    system: &Sys,
    at: &State<Sys::Scalar, N>,
    h: Sys::Scalar,
) -> Failure<Sys::Scalar>
where
    Sys::Scalar: SimdScalar,
{
    let inertia = system.inertia(&at.q, &at.qd, at.t);
    match factored(&inertia).singular() {
        // A matrix that is not finite, for the state is not or is so large, says nothing about the coordinates.
        Some(Singular { pivot }) if at.is_finite() && is_finite(&inertia) => {
            singular::<Sys, N>(at.t, pivot, &inertia)
        }
        _ => Failure::NonFinite { t: at.t, h },
    }
}

/// [`Failure::SingularInertia`] of coordinate k.
fn singular<Sys: Lagrangian<N>, const N: usize>(
    t: Sys::Scalar,
    k: usize,
    inertia: &SMatrix<Sys::Scalar, N, N>,
) -> Failure<Sys::Scalar>
where
    Sys::Scalar: SimdScalar,
{
    // The column of the inverse is along the motion without inertia, once the matrix is made regular.
    let raised = Sys::Scalar::from_f64(1.0 + 1e-8);
    let regular =
        SMatrix::<_, N, N>::from_fn(|i, j| if i == j { inertia[(i, j)] * raised } else { inertia[(i, j)] });
    let unit = SVector::<_, N>::from_fn(|i, _| if i == k { Sys::Scalar::one() } else { Sys::Scalar::zero() });
    let motion = factored(&regular).solve(&unit);
    let part = |i: usize| (motion[i] * motion[i] * inertia[(i, i)]).number(0).to_f64();
    let with =
        (0..N).filter(|&i| i != k && part(i) > 0.01 * part(k)).max_by(|&i, &j| part(i).total_cmp(&part(j)));
    let of = Coordinate::of::<Sys, N>;
    Failure::SingularInertia { t, coordinate: of(k), with: with.map(of) }
}

pub(crate) fn is_finite<S: Scalar, const N: usize>(matrix: &SMatrix<S, N, N>) -> bool {
    matrix.iter().all(|&x| x * S::zero() == S::zero())
}

/// The cause of a failed run of a Lagrangian system: [`Failure::SingularInertia`] where the run ended at a state, or
/// at the brink of one, at which a coordinate has no inertia; otherwise the failure itself. Explicit methods, which
/// see accelerations only, report such an end as [`Failure::NonFinite`] or [`Failure::StepSizeUnderflow`]. Runs of
/// systems made by `lagrangian!` call this themselves; it is of use for systems that are written by hand.
///
/// The inertia of coordinate k, with all others left free, is `1/(M⁻¹)ₖₖ`. "At the brink" means that it has fallen to
/// `1e-10` of what it was at the start of the run, or less; for a run that failed at its start, of what it is beside
/// it. That compares each coordinate with itself, so units do not matter, nor does it matter if another coordinate
/// has run away.
///
/// ```
/// use lagrange_runtime::prelude::*;
///
/// lagrangian! {
///     /// A free particle in polar coordinates.
///     system Polar {
///         param m;
///         coord r, phi;
///         T = 0.5 * m * (dot(r).powi(2) + (r * dot(phi)).powi(2));
///         V = 0;
///     }
/// }
/// let polar = Polar::new(1.0);
/// let origin = State::new(0.0, [0.0, 0.0], [1.0, 0.5]);
/// let failed = integrate(&polar, Rk4, FixedStep::new(0.1), origin).until(1.0).final_state().unwrap_err();
/// assert!(matches!(failed.failure, Failure::SingularInertia { coordinate, .. } if coordinate.name == "phi"));
/// ```
pub fn diagnose<Sys: Lagrangian<N>, const N: usize>(
    system: &Sys,
    failed: &Failed<Sys::Scalar, N>,
) -> Failure<Sys::Scalar>
where
    Sys::Scalar: Real,
{
    explained(system, &failed.start, &failed.last, failed.failure)
}

/// [`diagnose`] for a run from `start` that ended at `last`. Emitted as
/// [`System::explained`](crate::System::explained).
#[doc(hidden)]
#[cold]
#[inline(never)]
pub fn explained<Sys: Lagrangian<N>, const N: usize>(
    system: &Sys,
    start: &State<Sys::Scalar, N>,
    last: &State<Sys::Scalar, N>,
    failure: Failure<Sys::Scalar>,
) -> Failure<Sys::Scalar>
where
    Sys::Scalar: Real,
{
    if let Failure::StateNotFinite { t, part } = failure {
        return Failure::StateNotFinite { t, part: named::<Sys, N>(part) };
    }
    let at_start = last.t == start.t;
    let unexplained = match failure {
        Failure::NonFinite { .. } | Failure::StepSizeUnderflow { .. } => true,
        // Implicit methods report a start without accelerations so.
        Failure::NotConverged { .. } | Failure::SingularStep { .. } => at_start,
        _ => false,
    };
    if !unexplained || !last.is_finite() || size_of::<SMatrix<Sys::Scalar, N, N>>() > MAX_MATRIX_BYTES {
        return failure;
    }
    if let cause @ Failure::SingularInertia { .. } = why_not_finite(system, last, Sys::Scalar::zero()) {
        return cause;
    }
    let compared = if at_start { beside(last, 1.0) } else { *start };
    if let Some(cause) = vanished(system, last, &compared, BRINK, false) {
        return cause;
    }
    // (Of a motion that has grown beyond all numbers it is not the equations that are to blame.)
    let is_given = matches!(failure, Failure::NonFinite { h, .. } if at_start || h == Scalar::zero());
    match is_given.then(|| without_equation(system, last)).flatten() {
        Some(coordinate) => Failure::StateNotFinite { t: last.t, part: Part::Equation(coordinate) },
        None => failure,
    }
}

/// The same with the name of its coordinate.
fn named<Sys: Lagrangian<N>, const N: usize>(part: Part) -> Part {
    let of = |coordinate: Coordinate| Coordinate::of::<Sys, N>(coordinate.index);
    match part {
        Part::Time => Part::Time,
        Part::Coordinate(coordinate) => Part::Coordinate(of(coordinate)),
        Part::Velocity(coordinate) => Part::Velocity(of(coordinate)),
        Part::Equation(coordinate) => Part::Equation(of(coordinate)),
    }
}

/// The first coordinate whose row of `M q̈ = f − b` is not finite at a state that is.
fn without_equation<Sys: Lagrangian<N>, const N: usize>(
    system: &Sys,
    at: &State<Sys::Scalar, N>,
) -> Option<Coordinate> {
    let (q, qd, t) = (&at.q, &at.qd, at.t);
    let right = system.momentum_rate(q, qd, t) - system.convective_momentum_rate(q, qd, t);
    let inertia = system.inertia(q, qd, t);
    let zero = Sys::Scalar::zero();
    let is_finite = |i: usize| right[i] * zero == zero && (0..N).all(|j| inertia[(i, j)] * zero == zero);
    (0..N).find(|&i| !is_finite(i)).map(Coordinate::of::<Sys, N>)
}

/// The part of the inertia of a coordinate, or of the square of a constraint's gradient, at which it counts as
/// vanished.
pub(crate) const BRINK: f64 = 1e-10;

/// The part of an inertia up to which a negative pivot is rounding.
const ROUNDED: f64 = 1e-5;

/// The largest matrix for which the cause of a failure is looked for: several have to fit the stack of a thread.
pub(crate) const MAX_MATRIX_BYTES: usize = 1 << 16;

/// A state beside `at` that has no reason to be singular, too: every coordinate is moved by about a thousandth of its
/// size, and of `unit`, and every velocity.
pub(crate) fn beside<S: Scalar, const N: usize>(at: &State<S, N>, unit: f64) -> State<S, N> {
    away(at, 1e-3, unit)
}

/// [`beside`] by one to two times this part.
pub(crate) fn away<S: Scalar, const N: usize>(at: &State<S, N>, part: f64, unit: f64) -> State<S, N> {
    // The parts differ, so that no difference of coordinates stays as it is.
    let part = |i: usize| {
        let turns = 0.618 * i as f64;
        S::from_f64(part * (1.0 + (turns - (turns as usize) as f64)))
    };
    let moved = |x: S, i: usize| x + part(i) * (S::from_f64(unit) + x.abs());
    State {
        q: SVector::from_fn(|i, _| moved(at.q[i], i)),
        qd: SVector::from_fn(|i, _| moved(at.qd[i], i)),
        ..*at
    }
}

/// Fails if `at` is within rounding of a state at which a coordinate has no inertia, such as θ = π of Euler's angles,
/// whose sine is not 0 in floating-point numbers: accelerations are finite there, and mean nothing. Fails, too, if M is
/// not positive definite there, of a system in which it `is_definite` for positive parameters.
///
/// # Errors
/// [`Failure::SingularInertia`], [`Failure::NegativeInertia`].
fn regular<Sys: Lagrangian<N>, const N: usize>(
    system: &Sys,
    at: &State<Sys::Scalar, N>,
    is_definite: bool,
) -> Result<(), Failure<Sys::Scalar>>
where
    Sys::Scalar: Real,
{
    if size_of::<SMatrix<Sys::Scalar, N, N>>() > MAX_MATRIX_BYTES {
        return Ok(());
    }
    match vanished(system, at, &beside(at, 0.0), Sys::Scalar::EPSILON, is_definite) {
        Some(failure) => Err(failure),
        None => Ok(()),
    }
}

/// [`Failure::SingularInertia`] of the coordinate whose inertia at `at` is the least part of that at `compared`, if
/// it is no more than `brink`. [`Failure::NegativeInertia`] of one with a negative pivot, where none should be.
fn vanished<Sys: Lagrangian<N>, const N: usize>(
    system: &Sys,
    at: &State<Sys::Scalar, N>,
    compared: &State<Sys::Scalar, N>,
    brink: f64,
    is_definite: bool,
) -> Option<Failure<Sys::Scalar>>
where
    Sys::Scalar: Real,
{
    let inertia = |at: &State<Sys::Scalar, N>| system.inertia(&at.q, &at.qd, at.t);
    let matrix = inertia(at);
    let here = match ldlt(&matrix) {
        Ok(here) => here,
        // An indefinite matrix may have no such factors and be regular: it is scaled to a unit diagonal, and factored
        // with pivots.
        Err(Singular { pivot }) => {
            let scale = SVector::<_, N>::from_fn(|i, _| Sys::Scalar::one() / matrix[(i, i)].sqrt());
            let scaled = SMatrix::<_, N, N>::from_fn(|i, j| scale[i] * matrix[(i, j)] * scale[j]);
            let rank_is_lost = is_finite(&scaled) && lu_solve(&scaled, &scale).is_err();
            return rank_is_lost.then(|| singular::<Sys, N>(at.t, pivot, &matrix));
        }
    };
    let is_negative = |k: usize| {
        let [pivot, entry]: [f64; 2] = [here.diagonal[k], matrix[(k, k)]].map(Real::to_f64);
        pivot < -ROUNDED * entry.abs()
    };
    if let Some(k) = (0..N).find(|k| is_definite && is_negative(*k)) {
        return Some(Failure::NegativeInertia { t: at.t, coordinate: Coordinate::of::<Sys, N>(k) });
    }
    let compared = ldlt(&inertia(compared)).ok()?;
    let left = |k: usize| mobility(&compared, k) / mobility(&here, k);
    let k = (0..N).min_by(|&a, &b| left(a).total_cmp(&left(b)))?;
    (left(k) <= brink).then(|| singular::<Sys, N>(at.t, k, &matrix))
}

/// `(M⁻¹)ₖₖ`, as a size.
fn mobility<S: Real, const N: usize>(inertia: &Ldlt<S, N>, k: usize) -> f64 {
    let unit = SVector::from_fn(|i, _| if i == k { S::one() } else { S::zero() });
    inertia.solve(&unit)[k].to_f64().abs()
}

/// Near a singularity of the coordinates velocities grow without bound, and cancel. Twice the kinetic energy is
/// `Σ pᵢ q̇ᵢ` with `p = M q̇`, and a rounding of each velocity, by up to ε of it, changes it by up to ε times
///
/// `κ = Σ |pᵢ q̇ᵢ| / |Σ pᵢ q̇ᵢ|`,
///
/// relative (Higham, *Accuracy and Stability of Numerical Algorithms*, 2002, 1.6), and momenta accordingly. No method
/// can mend that, and no estimate of a step's error sees it.
///
/// # Errors
/// [`Failure::Cancellation`] where κ is beyond 1/√ε, that is, where fewer than half of the digits are left; it names
/// the coordinate with the largest of the terms. [`Failure::SingularInertia`] at a start within rounding of a state
/// without inertia of some coordinate. [`Failure::NegativeInertia`] at a start with a negative kinetic energy, of a
/// system whose M `is_definite` for positive parameters.
#[cold]
#[inline(never)]
pub fn resolved<Sys: Lagrangian<N>, const N: usize>(
    system: &Sys,
    start: &State<Sys::Scalar, N>,
    at: &State<Sys::Scalar, N>,
    is_definite: bool,
) -> Result<(), Failure<Sys::Scalar>>
where
    Sys::Scalar: Real,
{
    if start == at {
        regular(system, at, is_definite)?;
    }
    // Less what is no momentum of the motion, such as that of a magnetic field.
    let rest = at.qd.map(|_| Sys::Scalar::zero());
    let momenta = system.momenta(&at.q, &at.qd, at.t) - system.momenta(&at.q, &rest, at.t);
    let terms = momenta.component_mul(&at.qd);
    let size = |k: usize| terms[k].to_f64().abs();
    let whole = (0..N).fold(Sys::Scalar::zero(), |sum, k| sum + terms[k]).to_f64().abs();
    let condition = (0..N).map(size).sum::<f64>() / whole;
    match (0..N).max_by(|&a, &b| size(a).total_cmp(&size(b))) {
        Some(k) if condition * libm::sqrt(Sys::Scalar::EPSILON) > 1.0 => {
            Err(Failure::Cancellation { t: at.t, coordinate: Coordinate::of::<Sys, N>(k), condition })
        }
        _ => Ok(()),
    }
}
