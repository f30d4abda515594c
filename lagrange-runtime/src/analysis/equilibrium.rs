//! Equilibria of a system, and their stability.

use super::balance::{Balance, CONVERGED, balance, worst};
use super::constrained;
use super::hypotheses::{autonomous, second_order};
use super::switch::{linearized, smooth};
use super::{AnalysisError, SmallMotion, Stability};
use crate::attitude;
use crate::failure::Coordinate;
use crate::state::State;
use crate::system::Linearize;
use nalgebra::{DMatrix, DVector, SVector};

/// A configuration at which a system at rest stays at rest. For a rheonomic system in whose L no time appears (a bead
/// in a tube that spins steadily) it is a relative equilibrium, and K the second derivatives of `V − T₀`.
///
/// # Stability
/// The verdict is on the motion itself, not on small motions alone. The first theorem whose hypotheses hold decides:
///
/// | hypotheses | verdict | theorem |
/// |---|---|---|
/// | K symmetric, damping D ≥ 0; K has negative eigenvalues, and G = 0, or D > 0 and K is regular | unstable | Kelvin; Thomson, Tait and Chetaev |
/// | K symmetric, D ≥ 0, K positive semidefinite and singular | neutral | none: higher orders decide |
/// | K positive definite, and h conserved ([`Facts::conservative`](crate::Facts::conservative)) | stable | Lagrange and Dirichlet |
/// | K positive definite, D ≥ 0, and forces besides those of L are `−C q̇` with a constant C ([`Facts::linear_damping`](crate::Facts::linear_damping)): h never grows | stable | Lagrange and Dirichlet |
/// | K symmetric and positive definite, D ≥ 0, the system is linear ([`Facts::linear`](crate::Facts::linear)) | stable | Thomson and Tait |
/// | K symmetric and positive definite, D > 0, any G | stable, asymptotically | Thomson, Tait and Chetaev; Lyapunov |
/// | all eigenvalues of the small motions have negative real parts | stable, asymptotically | Lyapunov's first approximation |
/// | an eigenvalue has a positive real part | unstable, or flutter | Lyapunov's first approximation |
/// | otherwise | undecided | |
///
/// With constraints M, C, K and G are those of the motions that they admit. Of constraints that follow from relations
/// between positions the table holds as it is, with damping of all motions in the fourth row. If a constraint
/// restricts velocities alone, the third and fourth rows need a K that is positive definite on all displacements that
/// constraints on positions admit, and no force of that constraint: the equilibrium is then a minimum of V. The fifth
/// row is left out, and the last ones are Lyapunov and Malkin's theorem: equilibria form a family, to one of which
/// the motion returns (Neimark and Fufaev 1972, ch. V; Karapetyan and Rumyantsev, *Stability of Conservative and
/// Dissipative Systems*, 1983).
///
/// K counts as singular where its least eigenvalue is smaller than the change of K over the last correction of
/// Newton's method, which converges linearly where the equilibrium is degenerate (`V = x³`).
///
/// So a force `±q̇³`, or damping that vanishes at the equilibrium, leaves an oscillator undecided: its linear terms
/// are those of a center, and terms of higher order make it stable or unstable. Sources: Lagrange 1788; Dirichlet
/// 1846; Lyapunov 1892; Chetaev, *The Stability of Motion*, 1961, ch. 5; Merkin, *Introduction to the Theory of
/// Stability*, 1997, ch. 3–6.
#[derive(Clone, Debug, PartialEq)]
pub struct Equilibrium<const N: usize> {
    /// Coordinates.
    pub q: SVector<f64, N>,
    /// Multipliers λ of the constraints, in the order of [`Facts::constraints`](crate::Facts::constraints); their
    /// generalized forces are `Aᵀ λ`. They are of least norm where constraints follow from others; empty where there
    /// are none.
    pub multipliers: DVector<f64>,
    /// Largest generalized force that is left, by rounding: in N of a length, in N m of an angle.
    pub residual: f64,
    /// Small motions about it.
    pub small: SmallMotion,
    /// Behaviour after a disturbance, as far as it is proved.
    pub stability: Stability,
}

/// Small vibrations about the equilibrium `q`, which may be given to some digits: it is refined by Newton's method with
/// the emitted derivatives.
///
/// # Hypotheses
/// - Those of [`equilibrium`].
/// - `q` is an equilibrium to half the digits, and on the constraints.
///
/// Damping, gyroscopic and circulatory forces are part of the result; what needs their absence says so, as
/// [`SmallMotion::modes`] does.
///
/// # Errors
/// [`AnalysisError::NotEquilibrium`] with the nearest one; those of [`equilibrium`].
pub fn small_vibrations<Sys: Linearize<N, Scalar = f64>, const N: usize>(
    system: &Sys,
    q: &[f64; N],
) -> Result<SmallMotion, AnalysisError> {
    resting(system, q).map(|found| found.small)
}

/// The equilibrium `q`, refined; refused unless it is one.
pub(super) fn resting<Sys: Linearize<N, Scalar = f64>, const N: usize>(
    system: &Sys,
    q: &[f64; N],
) -> Result<Equilibrium<N>, AnalysisError> {
    let here = SVector::from(*q);
    second_order::<Sys, N>()?;
    autonomous::<Sys, N>()?;
    if q.iter().any(|q| !q.is_finite()) {
        return Err(AnalysisError::NotFinite);
    }
    let (coordinate, residual) = match Sys::FACTS.constraints {
        [] => worst(&rest(system, &here, 0.0)),
        _ => constrained::left(system, &here)?,
    };
    let coordinate = Coordinate::of::<Sys, N>(coordinate);
    let refused = |nearest| AnalysisError::NotEquilibrium { residual, coordinate, nearest };
    let found = match equilibrium(system, q) {
        Err(AnalysisError::NotConverged { .. } | AnalysisError::Unbalanced { .. }) if residual != 0.0 => {
            return Err(refused(None));
        }
        other => other?,
    };
    let moved = (0..N).map(|i| (found.q[i] - q[i]).abs() / (1.0 + q[i].abs())).fold(0.0, f64::max);
    match moved <= CONVERGED {
        true => Ok(found),
        false => Err(refused(Some(found.q.iter().copied().collect()))),
    }
}

/// The equilibrium that Newton's method reaches from `guess`, at `t = 0`. Steps are halved until the residual falls;
/// where the stiffness is singular the smallest correction is taken, so that ignorable coordinates stay where they
/// are.
///
/// Corrections and tolerances are relative to `1 + |qᵢ|`, here and in [`small_vibrations`]: give coordinates in units
/// in which they are of order 1.
///
/// ```
/// use lagrange_runtime::analysis::equilibrium;
/// use lagrange_runtime::prelude::*;
///
/// lagrangian! {
///     /// A bead in a tube bent to a circle that spins about its vertical diameter.
///     system Bead {
///         param m, a, omega, g = 9.81;
///         coord theta;
///         T = 0.5 * m * a.powi(2) * (dot(theta).powi(2) + (omega * sin(theta)).powi(2));
///         V = -m * g * a * cos(theta);
///     }
/// }
/// let found = equilibrium(&Bead::new(0.4, 0.5, 5.3), &[1.0])?;
/// assert!((found.q[0].cos() - 9.81 / (0.5 * 5.3 * 5.3)).abs() < 1e-15);
/// assert!(found.stability.is_stable());
/// # Ok::<(), lagrange_runtime::analysis::AnalysisError>(())
/// ```
///
/// # Hypotheses
/// - The equations are autonomous, by [`Facts::autonomous`](crate::Facts::autonomous).
/// - Forces are finite, and there is an equilibrium that Newton's method reaches.
/// - M is positive definite there.
/// - It is not on a switch of the forces at which these or their derivatives jump, by
///   [`System::switches`](crate::System::switches). Forces whose sides have the same derivatives, as quadratic drag
///   at rest, have small motions.
/// - It is on no kink of a function with data, such as a knot of [`Curve::linear`](crate::traits::Curve::linear).
/// - Constraints, if there are any, admit rest, and are independent at the guess and at the equilibrium, but for
///   those that follow from others everywhere. The guess may be beside them.
///
/// With constraints the multipliers are found with the coordinates, and small motions are in minimal coordinates of
/// what the constraints admit. Where constraints restrict velocities alone, equilibria come in families: the nearest
/// one is taken.
///
/// # Errors
/// [`AnalysisError::OffConstraints`], [`AnalysisError::DependentConstraints`], [`AnalysisError::TimeDependent`],
/// [`AnalysisError::NotConverged`], [`AnalysisError::Unbalanced`] where a force is left that no displacement changes,
/// however small it is beside the others, [`AnalysisError::NotFinite`], [`AnalysisError::Inertia`],
/// [`AnalysisError::Switch`], [`AnalysisError::Kink`].
pub fn equilibrium<Sys: Linearize<N, Scalar = f64>, const N: usize>(
    system: &Sys,
    guess: &[f64; N],
) -> Result<Equilibrium<N>, AnalysisError> {
    second_order::<Sys, N>()?;
    autonomous::<Sys, N>()?;
    if guess.iter().any(|q| !q.is_finite()) {
        return Err(AnalysisError::NotFinite);
    }
    if !Sys::FACTS.constraints.is_empty() {
        let (q, multipliers, small) = constrained::equilibrium(system, guess)?;
        let stability = constrained::stability(system, &q, &small)?;
        let residual = constrained::balances(system, &q, &multipliers)?;
        return Ok(Equilibrium { q, multipliers, residual, small, stability });
    }
    let at_rest = |q| State { t: 0.0, q, qd: SVector::zeros() };
    let found = newton(system, SVector::from(*guess)).or_else(|error| {
        smooth(system, &at_rest(SVector::from(*guess)), 0.0, linearized)?;
        Err(error)
    })?;
    let q = SVector::from_column_slice(found.q.as_slice());
    let at = at_rest(q);
    smooth(system, &at, found.last, linearized)?;
    let small = SmallMotion::at(system, &at)?.doubted(&found.stiffness_aside);
    let residual = worst(&rest(system, &q, 0.0)).1;
    let stability = small.stability(&Sys::FACTS)?;
    Ok(Equilibrium { q, multipliers: DVector::zeros(0), residual, small, stability })
}

/// The distinct equilibria in the box `low ≤ q ≤ high` that Newton's method finds from `starts` points spread evenly
/// in it (Halton, *Numer. Math.* 2, 1960: no two runs differ), sorted by their coordinates. Nothing proves that there
/// are no others; twice as many starts that find no more say so.
///
/// ```
/// use lagrange_runtime::analysis::equilibria;
/// use lagrange_runtime::prelude::*;
///
/// lagrangian! {
///     system Pendulum {
///         param l, g = 9.81;
///         coord theta;
///         T = 0.5 * (l * dot(theta)).powi(2);
///         V = -g * l * cos(theta);
///     }
/// }
/// let all = equilibria(&Pendulum::new(0.5), &[-1.0], &[4.0], 20)?;
/// assert_eq!(all.iter().map(|e| e.stability.is_stable()).collect::<Vec<_>>(), [true, false]);
/// # Ok::<(), lagrange_runtime::analysis::AnalysisError>(())
/// ```
///
/// Two that differ by less than 1e-6 of the box are taken as one, and so are the two parameters of an attitude
/// (`coord R: rotation;`): all attitudes are in the box from −1 to 1.
///
/// # Hypotheses
/// - Those of [`equilibrium`] that belong to the system: autonomous equations, constraints that admit rest.
/// - No equilibrium that is found is on a switch of the forces, or on a kink of a function with data.
///
/// A start from which none is reached is left out, whatever the reason, and so is a configuration with singular
/// inertia, or one in which constraints are dependent.
///
/// # Errors
/// [`AnalysisError::TimeDependent`], [`AnalysisError::Switch`], [`AnalysisError::Kink`];
/// [`AnalysisError::NotApplicable`] unless the box is finite and `low ≤ high`; [`AnalysisError::OffConstraints`] and
/// others by which every start failed that is not merely too far from an equilibrium.
pub fn equilibria<Sys: Linearize<N, Scalar = f64>, const N: usize>(
    system: &Sys,
    low: &[f64; N],
    high: &[f64; N],
    starts: u32,
) -> Result<Vec<Equilibrium<N>>, AnalysisError> {
    let mut found: Vec<Equilibrium<N>> = Vec::new();
    let span: [f64; N] = std::array::from_fn(|i| high[i] - low[i]);
    if !span.iter().all(|span| *span >= 0.0 && span.is_finite()) {
        return Err(AnalysisError::NotApplicable { needs: "a finite box with low ≤ high" });
    }
    let (mut reached, mut reason) = (false, None);
    for k in 1..=starts {
        let start = std::array::from_fn(|i| low[i] + span[i] * radical_inverse(k, prime(i)));
        let next = match equilibrium(system, &start) {
            Ok(next) => next,
            Err(
                AnalysisError::NotConverged { .. }
                | AnalysisError::Unbalanced { .. }
                | AnalysisError::NotFinite
                | AnalysisError::DependentConstraints { .. }
                | AnalysisError::Inertia { .. },
            ) => continue,
            Err(
                error @ (AnalysisError::Switch { .. }
                | AnalysisError::Kink { .. }
                | AnalysisError::TimeDependent),
            ) => return Err(error),
            Err(error) => {
                reason = reason.or(Some(error));
                continue;
            }
        };
        reached = true;
        let slack = |i: usize| 1e-6 * span[i].abs();
        let inside = (0..N).all(|i| next.q[i] >= low[i] - slack(i) && next.q[i] <= high[i] + slack(i));
        // Each by the parameters of its attitudes that are nearer to those of the other.
        let known = found.iter().any(|e| {
            let [old, new] = [e.q, next.q].map(|q| State { t: 0.0, q, qd: SVector::zeros() });
            let new = new.turned(attitude::steps::astray(Sys::ATTITUDES, &new, &old));
            (0..N).all(|i| (old.q[i] - new.q[i]).abs() <= slack(i))
        });
        if inside && !known {
            found.push(next);
        }
    }
    if let (false, Some(reason)) = (reached, reason) {
        return Err(reason);
    }
    let order = |a: &Equilibrium<N>, b: &Equilibrium<N>| {
        let pairs = a.q.iter().zip(b.q.iter());
        pairs.map(|(a, b)| a.total_cmp(b)).find(|o| o.is_ne()).unwrap_or(std::cmp::Ordering::Equal)
    };
    found.sort_by(order);
    Ok(found)
}

/// `b − f` at rest.
fn rest<Sys: Linearize<N, Scalar = f64>, const N: usize>(
    system: &Sys,
    q: &SVector<f64, N>,
    t: f64,
) -> SVector<f64, N> {
    let still = SVector::zeros();
    system.convective_momentum_rate(q, &still, t) - system.momentum_rate(q, &still, t)
}

fn newton<Sys: Linearize<N, Scalar = f64>, const N: usize>(
    system: &Sys,
    guess: SVector<f64, N>,
) -> Result<Balance, AnalysisError> {
    let forces = |q: &DVector<f64>| {
        let rest = rest(system, &SVector::from_column_slice(q.as_slice()), 0.0);
        Ok(DVector::from_column_slice(rest.as_slice()))
    };
    let stiffness = |q: &DVector<f64>| {
        let q = SVector::from_column_slice(q.as_slice());
        let stiffness = system.linearize(&q, &SVector::zeros(), 0.0).stiffness;
        Ok(DMatrix::from_fn(N, N, |i, j| stiffness[(i, j)]))
    };
    let guess = DVector::from_column_slice(guess.as_slice());
    balance("an equilibrium", guess, &forces, &stiffness, Sys::ATTITUDES)
}

/// The digits of k in this base, mirrored at the point.
fn radical_inverse(mut k: u32, base: u32) -> f64 {
    let (mut value, mut digit) = (0.0, 1.0 / f64::from(base));
    while k > 0 {
        value += f64::from(k % base) * digit;
        digit /= f64::from(base);
        k /= base;
    }
    value
}

/// The prime number of this index.
fn prime(index: usize) -> u32 {
    (2..).filter(|n| (2..*n).take_while(|d| d * d <= *n).all(|d| n % d != 0)).nth(index).unwrap_or(2)
}
