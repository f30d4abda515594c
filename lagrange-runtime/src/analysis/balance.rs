//! Newton's method for places at which forces vanish.

use super::AnalysisError;
use crate::attitude::steps::shortened_place;
use crate::failure::Coordinate;
use nalgebra::{DMatrix, DVector, SVD, SVector};

/// Corrections of Newton's method below this, relative to `1 + |qᵢ|`, are rounding errors, even where the equilibrium
/// is degenerate and known to half the digits.
pub(super) const CONVERGED: f64 = 1e-8;

/// Iterations of Newton's method; at a degenerate equilibrium each one reduces the error by a constant factor only.
const MOST_ITERATIONS: usize = 200;

/// Index and absolute value of the largest element.
pub(super) fn worst<const N: usize>(rest: &SVector<f64, N>) -> (usize, f64) {
    let larger = |a: (usize, f64), (i, x): (usize, &f64)| if x.abs() > a.1 { (i, x.abs()) } else { a };
    rest.iter().enumerate().fold((0, 0.0), larger)
}

/// A place at which forces vanish.
pub(super) struct Balance {
    pub q: DVector<f64>,
    /// Last correction of Newton's method, relative to `1 + |q|`.
    pub last: f64,
    /// Stiffness at a multiple of the last correction from q. Where the equilibrium is degenerate, Newton's method
    /// converges linearly, and this stiffness differs from that at q by more than the latter; elsewhere the
    /// correction is rounding.
    pub stiffness_aside: DMatrix<f64>,
}

/// Corrections of Newton's method that shrink less than by this factor converge linearly.
const LINEAR: f64 = 0.1;

/// Corrections below this, relative to `1 + |qᵢ|`, leave the parameters of attitudes as they were given.
const TURNED: f64 = 1e-3;

/// The q near a guess at which forces vanish, by Newton's method with their derivatives. On the way attitudes, by
/// their first coordinates, are brought to their shorter parameters: generalized forces by the parameters vanish at
/// infinity, which is an attitude like others.
///
/// With `V ∝ xᵖ` along the degenerate direction a correction is `−x/(p − 1)`, so that the stiffness at x minus four
/// further corrections, or minus twice the one that led to x, differs from `K ∝ x^{p−2}` by 2 K at least.
pub(super) fn balance(
    what: &'static str,
    guess: DVector<f64>,
    forces: &dyn Fn(&DVector<f64>) -> Result<DVector<f64>, AnalysisError>,
    stiffness: &dyn Fn(&DVector<f64>) -> Result<DMatrix<f64>, AnalysisError>,
    attitudes: &[usize],
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
            let far = relative(&correction, &q) > TURNED;
            if let Some(shorter) = far.then(|| shortened_place(attitudes, &q)).flatten() {
                (residual, q) = (forces(&shorter)?, shorter);
                (moved, linear) = (DVector::zeros(q.len()), false);
                continue;
            }
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

/// Refuses a place at which these forces are left, which its small displacements do not change, unless they are
/// rounding: they are if they are that small by the derivatives of each, and are others at a distance along
/// displacements that change nothing, or are roundings of forces that balance others.
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
    let unbalanced = Err(AnalysisError::Unbalanced {
        force: left[coordinate].abs(),
        coordinate: Coordinate::unnamed(coordinate),
    });
    if (0..left.len()).any(|i| left[i].abs() > rounding * change(i)) {
        return unbalanced;
    }
    // Loads that balance in decimal numbers do not in binary ones.
    if left.amax() <= 4.0 * f64::EPSILON * (derivatives * at).amax() {
        return Ok(());
    }
    let size = left.norm();
    // A displacement that would take them away is rounding.
    let taken = derivatives * smallest_solution(derivatives.clone(), left, 0.0)?;
    if (left - taken).norm() <= 1e-3 * size {
        return Ok(());
    }
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

/// The smallest x that makes `|A x − b|` least, singular values up to `cut` taken as zero, and those that are
/// rounding errors of the matrix.
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
