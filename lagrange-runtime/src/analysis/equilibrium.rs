//! Equilibria of a system, and their stability.

use super::small::{autonomous, unconstrained};
use super::switch::{linearized, smooth};
use super::{AnalysisError, SmallMotion, Stability};
use crate::state::State;
use crate::system::Linearize;
use nalgebra::{DMatrix, DVector, SVD, SVector};

/// A configuration at which a system at rest stays at rest. For a rheonomic system in whose L no time appears (a bead in
/// a tube that spins steadily) it is a relative equilibrium, and K the second derivatives of `V − T₀`.
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
/// K counts as singular where its least eigenvalue is smaller than the change of K over the last correction of Newton's method, which converges linearly
/// where the equilibrium is degenerate (`V = x³`).
///
/// So a force `±q̇³`, or damping that vanishes at the equilibrium, leaves an oscillator undecided: its linear terms are those of
/// a center, and terms of higher order make it stable or unstable. Sources: Lagrange 1788; Dirichlet 1846; Lyapunov 1892;
/// Chetaev, *The Stability of Motion*, 1961, ch. 5; Merkin, *Introduction to the Theory of Stability*, 1997, ch. 3–6.
#[derive(Clone, Debug, PartialEq)]
pub struct Equilibrium<const N: usize> {
    /// Coordinates.
    pub q: SVector<f64, N>,
    /// Largest generalized force that is left, by rounding.
    pub residual: f64,
    /// Small motions about it.
    pub small: SmallMotion,
    /// Behaviour after a disturbance, as far as it is proved.
    pub stability: Stability,
}

/// Corrections of Newton's method below this, relative to `1 + |qᵢ|`, are what is left of rounding errors, also where
/// the equilibrium is degenerate and known to half the digits.
const CONVERGED: f64 = 1e-8;

/// Iterations of Newton's method; at a degenerate equilibrium each one reduces the error by a constant factor only.
const MOST_ITERATIONS: usize = 200;

/// Small vibrations about the equilibrium `q`, which may be given to some digits: it is refined by Newton's method with
/// the emitted derivatives.
///
/// # Hypotheses
/// - Those of [`equilibrium`].
/// - `q` is an equilibrium to half the digits.
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
    let (coordinate, residual) = worst(&rest(system, &SVector::from(*q), 0.0));
    let refused = |nearest| AnalysisError::NotEquilibrium { residual, coordinate, nearest };
    let found = match equilibrium(system, q) {
        Err(AnalysisError::NotConverged { .. } | AnalysisError::Unbalanced { .. }) => {
            return Err(refused(None));
        }
        other => other?,
    };
    let moved = (0..N).map(|i| (found.q[i] - q[i]).abs() / (1.0 + q[i].abs())).fold(0.0, f64::max);
    match moved <= CONVERGED {
        true => Ok(found.small),
        false => Err(refused(Some(found.q.iter().copied().collect()))),
    }
}

/// The equilibrium that Newton's method reaches from `guess`, at `t = 0`. Steps are halved until the residual falls; where
/// the stiffness is singular the smallest correction is taken, so that ignorable coordinates stay where they are.
///
/// Corrections and tolerances are relative to `1 + |qᵢ|`, here and in [`small_vibrations`]: give coordinates in units in which they are of order 1.
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
/// - The coordinates are independent: there are no constraints.
/// - The equations are autonomous, by [`Facts::autonomous`](crate::Facts::autonomous).
/// - Forces are finite, and there is an equilibrium that Newton's method reaches.
/// - M is positive definite there.
/// - It is not on a switch of the forces at which these or their derivatives jump, by
///   [`System::switches`](crate::System::switches). Forces whose sides have the same derivatives, as quadratic drag at rest, have
///   small motions.
///
/// # Errors
/// [`AnalysisError::DependentCoordinates`], [`AnalysisError::TimeDependent`], [`AnalysisError::NotConverged`],
/// [`AnalysisError::Unbalanced`] where a force is left that no displacement changes, however small it is beside the others,
/// [`AnalysisError::NotFinite`], [`AnalysisError::Inertia`], [`AnalysisError::Switch`].
pub fn equilibrium<Sys: Linearize<N, Scalar = f64>, const N: usize>(
    system: &Sys,
    guess: &[f64; N],
) -> Result<Equilibrium<N>, AnalysisError> {
    unconstrained::<Sys, N>()?;
    autonomous::<Sys, N>()?;
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
    Ok(Equilibrium { q, residual, small, stability })
}

/// The distinct equilibria in the box `low ≤ q ≤ high` that Newton's method finds from `starts` points spread evenly in
/// it (Halton, *Numer. Math.* 2, 1960: no two runs differ), sorted by their coordinates. Nothing proves that there are no
/// others; twice as many starts that find no more say so.
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
/// Two that differ by less than 1e-6 of the box are taken as one.
///
/// # Hypotheses
/// - Those of [`equilibrium`] that belong to the system: independent coordinates, autonomous equations.
/// - No equilibrium that is found is on a switch of the forces.
///
/// A start from which none is reached is left out, and so is a configuration with singular inertia.
///
/// # Errors
/// [`AnalysisError::DependentCoordinates`], [`AnalysisError::TimeDependent`], [`AnalysisError::Switch`];
/// [`AnalysisError::NotApplicable`] unless the box is finite and `low ≤ high`.
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
    for k in 1..=starts {
        let start = std::array::from_fn(|i| low[i] + span[i] * radical_inverse(k, prime(i)));
        let next = match equilibrium(system, &start) {
            Ok(next) => next,
            Err(
                AnalysisError::NotConverged { .. }
                | AnalysisError::Unbalanced { .. }
                | AnalysisError::NotFinite
                | AnalysisError::Inertia { .. },
            ) => continue,
            Err(error) => return Err(error),
        };
        let slack = |i: usize| 1e-6 * span[i].abs();
        let inside = (0..N).all(|i| next.q[i] >= low[i] - slack(i) && next.q[i] <= high[i] + slack(i));
        let known = found.iter().any(|e| (0..N).all(|i| (e.q[i] - next.q[i]).abs() <= slack(i)));
        if inside && !known {
            found.push(next);
        }
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

fn worst<const N: usize>(rest: &SVector<f64, N>) -> (usize, f64) {
    let larger = |a: (usize, f64), (i, x): (usize, &f64)| if x.abs() > a.1 { (i, x.abs()) } else { a };
    rest.iter().enumerate().fold((0, 0.0), larger)
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
    balance("an equilibrium", guess, &forces, &stiffness)
}

/// A place at which forces vanish.
pub(super) struct Balance {
    pub q: DVector<f64>,
    /// Last correction of Newton's method, relative to `1 + |q|`.
    pub last: f64,
    /// Stiffness at a multiple of the last correction from q. Where the equilibrium is degenerate, Newton's method converges linearly, and this stiffness
    /// differs from that at q by more than the latter; elsewhere the correction is rounding.
    pub stiffness_aside: DMatrix<f64>,
}

/// Corrections of Newton's method that shrink less than by this factor converge linearly.
const LINEAR: f64 = 0.1;

/// The q near a guess at which forces vanish, by Newton's method with their derivatives.
///
/// With `V ∝ xᵖ` along the degenerate direction a correction is `−x/(p − 1)`, so that the stiffness at x minus four further corrections, or minus twice the one
/// that led to x, differs from `K ∝ x^{p−2}` by 2 K at least.
pub(super) fn balance(
    what: &'static str,
    guess: DVector<f64>,
    forces: &dyn Fn(&DVector<f64>) -> Result<DVector<f64>, AnalysisError>,
    stiffness: &dyn Fn(&DVector<f64>) -> Result<DMatrix<f64>, AnalysisError>,
) -> Result<Balance, AnalysisError> {
    let relative = |step: &DVector<f64>, q: &DVector<f64>| {
        (0..q.len()).map(|i| step[i].abs() / (1.0 + q[i].abs())).fold(0.0, f64::max)
    };
    let mut q = guess;
    let (mut moved, mut linear) = (DVector::zeros(q.len()), false);
    let mut residual = forces(&q)?;
    for iteration in 0..MOST_ITERATIONS {
        if residual.iter().any(|x| !x.is_finite()) {
            return Err(AnalysisError::NotFinite);
        }
        if residual.amax() == 0.0 {
            let doubt = if linear && relative(&moved, &q) <= CONVERGED { 2.0 } else { 0.0 };
            return Ok(Balance { stiffness_aside: stiffness(&(&q - moved * doubt))?, q, last: 0.0 });
        }
        let here = stiffness(&q)?;
        let cut = q.len() as f64 * f64::EPSILON * here.amax();
        let step = smallest_solution(-&here, &residual, cut)?;
        let last = relative(&step, &q);
        let left = &residual + &here * &step;
        let mut part = 1.0;
        let better = loop {
            match forces(&(&q + &step * part)) {
                Ok(there) if there.norm() < residual.norm() => break Some((&step * part, there)),
                _ if part < 1e-4 => break None,
                _ => part *= 0.5,
            }
        };
        let ended = better.is_none() || iteration + 1 == MOST_ITERATIONS;
        if let Some((correction, there)) = better {
            q += &correction;
            residual = there;
            // Along a direction that has become singular to rounding there are no further corrections.
            if (&here * &moved).norm() >= 8.0 * cut * moved.norm() {
                linear = correction.norm() > LINEAR * moved.norm();
                moved = correction;
            }
        }
        if ended && last <= CONVERGED {
            balanced(&left, &here, &q, forces)?;
            let doubt = if linear { moved * 2.0 } else { step * 4.0 };
            return Ok(Balance { stiffness_aside: stiffness(&(&q - doubt))?, q, last });
        }
        if ended {
            break;
        }
    }
    Err(AnalysisError::NotConverged { what, residual: residual.amax() })
}

/// Distances at which forces within rounding are looked at again.
const APART: [f64; 6] = [0.37, -0.61, 1.7, -2.9, 7.3, -11.9];

/// Refuses a place at which these forces are left, which its small displacements do not change, unless they are rounding: they are if they are
/// that small by the derivatives of each, and are others at a distance along displacements that change nothing.
pub(super) fn balanced(
    left: &DVector<f64>,
    derivatives: &DMatrix<f64>,
    at: &DVector<f64>,
    forces: &dyn Fn(&DVector<f64>) -> Result<DVector<f64>, AnalysisError>,
) -> Result<(), AnalysisError> {
    let rounding = 64.0 * left.len() as f64 * f64::EPSILON;
    let change = |i: usize| {
        derivatives.row(i).iter().zip(at.iter()).map(|(d, x)| d.abs() * (1.0 + x.abs())).sum::<f64>()
    };
    let coordinate = left.iamax();
    let unbalanced = Err(AnalysisError::Unbalanced { force: left[coordinate].abs(), coordinate });
    if (0..left.len()).any(|i| left[i].abs() > rounding * change(i)) {
        return unbalanced;
    }
    let size = left.norm();
    let (n, columns) = derivatives.shape();
    let mut square = DMatrix::zeros(columns, columns);
    square.view_mut((0, 0), (n, columns)).copy_from(derivatives);
    let svd = SVD::try_new(square, false, true, f64::EPSILON, 10_000).ok_or(AnalysisError::NotFinite)?;
    let cut = rounding * svd.singular_values.amax();
    let idle: Vec<DVector<f64>> = (0..columns)
        .filter(|&k| svd.singular_values[k] <= cut)
        .filter_map(|k| Some(svd.v_t.as_ref()?.row(k).transpose()))
        .collect();
    let stays = |along: &DVector<f64>| {
        APART.iter().all(|s| {
            let there = forces(&(at + along * *s)).map_or(f64::NAN, |there| there.dot(left) / size);
            (there - size).abs() <= 1e-3 * size
        })
    };
    match size > 0.0 && !idle.is_empty() && idle.iter().all(stays) {
        true => unbalanced,
        false => Ok(()),
    }
}

/// The smallest x that makes `|A x − b|` least, singular values up to `cut` taken as zero, and those that are rounding errors
/// of the matrix.
pub(super) fn smallest_solution(
    a: DMatrix<f64>,
    b: &DVector<f64>,
    cut: f64,
) -> Result<DVector<f64>, AnalysisError> {
    if a.iter().chain(b.iter()).any(|x| !x.is_finite()) {
        return Err(AnalysisError::NotFinite);
    }
    let svd = SVD::try_new(a, true, true, f64::EPSILON, 10_000).ok_or(AnalysisError::NotFinite)?;
    let rounding = f64::EPSILON * svd.singular_values.amax();
    svd.solve(b, cut.max(rounding)).map_err(|_| AnalysisError::NotFinite)
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

#[cfg(test)]
mod tests;
