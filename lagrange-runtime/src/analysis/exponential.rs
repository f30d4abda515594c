//! Exponentials of matrices in double-double arithmetic, with a bound of their round-off errors.

use super::AnalysisError;
use crate::scalar::DoubleDouble as Double;
use nalgebra::DMatrix;

/// Norm of `2⁻ˢ A T` from which the terms of the series fall to [`ROUNDING`] within [`TERMS`].
const SMALL: f64 = 0.125;
const TERMS: u32 = 20;

/// Bound of the relative error of a sum of two products.
const ROUNDING: f64 = f64::EPSILON * f64::EPSILON * 16.0;

/// Rounding errors in units of the largest element up to which an exponential counts as known.
const KNOWN: f64 = 1e-12;

/// Sweeps of balancing; some are usual.
const MOST_SWEEPS: usize = 200;

/// `exp(A T)` and `∫₀ᵀ exp(A s) ds B`, both from one exponential (Van Loan, *IEEE Trans. Automat. Contr.* 23, 1978).
///
/// With `Φ = exp(X) − 1` doubling is `Φ ← 2 Φ + Φ²`, in which what is slow keeps its digits beside what is fast:
/// `exp` would have them as differences from 1 (Moler and Van Loan, *SIAM Rev.* 45, 2003, method 3, has the loss). X
/// is balanced before (Parlett and Reinsch, *Numer. Math.* 13, 1969), columns of B by units of the inputs.
///
/// # Errors
/// [`AnalysisError::NotFinite`] where entries are or become infinite; [`AnalysisError::NotApplicable`] where
/// rounding, by a bound for each entry that is doubled with them, leaves fewer than 12 digits of the largest ones.
pub(super) fn held(
    a: &DMatrix<f64>,
    b: &DMatrix<f64>,
    period: f64,
) -> Result<[DMatrix<f64>; 2], AnalysisError> {
    let (n, k) = b.shape();
    let product = |x: f64| Double::from(x) * period;
    let units = balanced(a);
    let exponent = |i: usize, j: usize| units[j] - units[i];
    let mut whole = DMatrix::from_element(n + k, n + k, Double::ZERO);
    for i in 0..n {
        (0..n).for_each(|j| whole[(i, j)] = scaled(product(a[(i, j)]), exponent(i, j)));
        (0..k).for_each(|j| whole[(i, n + j)] = scaled(product(b[(i, j)]), -units[i]));
    }
    let inputs: Vec<i32> = (n..n + k)
        .map(|j| binary(whole.column(j).iter().fold(0.0, |x, y| f64::max(x, y.hi.abs()))))
        .collect();
    for (j, unit) in inputs.iter().enumerate() {
        whole.column_mut(n + j).iter_mut().for_each(|x| *x = scaled(*x, -unit));
    }
    let (phi, errors) = doubled(whole)?;
    let largest = |columns: std::ops::Range<usize>, least: f64| {
        columns.clone().flat_map(|j| (0..n).map(move |i| (i, j))).fold(
            [least, 0.0],
            |[size, error], (i, j)| {
                [
                    size.max(phi[(i, j)].value().abs()),
                    if errors[(i, j)] <= error { error } else { errors[(i, j)] },
                ]
            },
        )
    };
    // (What is not a number is not known.)
    let known = |[size, error]: [f64; 2]| error <= KNOWN * size;
    if !(known(largest(0..n, 1.0)) && (n..n + k).all(|j| known(largest(j..j + 1, 0.0)))) {
        let needs = "a product of the period and the fastest pole that 32 digits resolve beside the slowest one: take a shorter period, or leave what is so fast out of the model";
        return Err(AnalysisError::NotApplicable { needs });
    }
    let one = |i: usize, j: usize| Double::from(f64::from(u8::from(i == j)));
    let of = [
        DMatrix::from_fn(n, n, |i, j| scaled(phi[(i, j)] + one(i, j), -exponent(i, j)).value()),
        DMatrix::from_fn(n, k, |i, j| scaled(scaled(phi[(i, n + j)], units[i]), inputs[j]).value()),
    ];
    match of.iter().all(|a| a.iter().all(|x| x.is_finite())) {
        true => Ok(of),
        false => Err(AnalysisError::NotFinite),
    }
}

/// `2ᵏ x`, in steps that are powers of 2 themselves.
fn scaled(mut x: Double, mut k: i32) -> Double {
    while k != 0 {
        let step = k.clamp(-500, 500);
        x = x * f64::from(step).exp2();
        k -= step;
    }
    x
}

/// The power of 2 at or below x, as its exponent; 0 of what is none.
fn binary(x: f64) -> i32 {
    if x > 0.0 && x.is_finite() { x.log2().floor() as i32 } else { 0 }
}

/// Exponents of units `2ᵉ` in which rows and columns of a matrix have similar norms.
fn balanced(a: &DMatrix<f64>) -> Vec<i32> {
    let n = a.nrows();
    let mut units = vec![0; n];
    for _ in 0..MOST_SWEEPS {
        let mut changed = false;
        for i in 0..n {
            // Logarithms, since squares of these entries may overflow.
            let size = |x: f64, exponent: i32| {
                if x == 0.0 { f64::NEG_INFINITY } else { x.abs().log2() + f64::from(exponent) }
            };
            let others = || (0..n).filter(|&j| j != i);
            let column =
                others().map(|j| size(a[(j, i)], units[i] - units[j])).fold(f64::NEG_INFINITY, f64::max);
            let row =
                others().map(|j| size(a[(i, j)], units[j] - units[i])).fold(f64::NEG_INFINITY, f64::max);
            let shift = (0.5 * (row - column)).trunc();
            if shift.is_finite() && shift != 0.0 {
                units[i] += shift as i32;
                changed = true;
            }
        }
        if !changed {
            break;
        }
    }
    units
}

/// `exp(X) − 1`, and bounds of the errors of its entries.
fn doubled(mut x: DMatrix<Double>) -> Result<(DMatrix<Double>, DMatrix<f64>), AnalysisError> {
    let n = x.nrows();
    let finite = |x: &DMatrix<Double>| match x.iter().all(|x| x.value().is_finite()) {
        true => Ok(()),
        false => Err(AnalysisError::NotFinite),
    };
    finite(&x)?;
    let norm = x.row_iter().map(|row| row.iter().map(|x| x.hi.abs()).sum::<f64>()).fold(0.0, f64::max);
    if !norm.is_finite() {
        return Err(AnalysisError::NotFinite);
    }
    let doublings = if norm > SMALL { (norm / SMALL).log2().ceil() as i32 } else { 0 };
    x.iter_mut().for_each(|x| *x = scaled(*x, -doublings));
    // Φ = X (1 + X/2 (1 + X/3 (…))), without the first 1.
    let mut phi = x.map(|x| x / f64::from(TERMS));
    for term in (1..TERMS).rev() {
        let above = product(&x, &phi);
        phi = x.zip_map(&above, |x, above| (x + above) / f64::from(term));
    }
    let unit = ROUNDING * n as f64;
    let mut errors = size(&phi) * (unit * f64::from(TERMS));
    for _ in 0..doublings {
        let square = product(&phi, &phi);
        // The error of 2 Φ + Φ² is (1 + Φ) E + E (1 + Φ) + E²: small where exp(X) is, although Φ is −1 there.
        let whole =
            size(&DMatrix::from_fn(
                n,
                n,
                |i, j| {
                    if i == j { phi[(i, j)] + Double::ONE } else { phi[(i, j)] }
                },
            ));
        let own = size(&phi);
        errors = &whole * &errors + &errors * &whole + &errors * &errors + (&own * 2.0 + &own * &own) * unit;
        phi = phi.zip_map(&square, |x, square| x + x + square);
        finite(&phi)?;
    }
    Ok((phi, errors))
}

fn size(a: &DMatrix<Double>) -> DMatrix<f64> {
    a.map(|x| x.value().abs())
}

fn product(a: &DMatrix<Double>, b: &DMatrix<Double>) -> DMatrix<Double> {
    DMatrix::from_fn(a.nrows(), b.ncols(), |i, j| {
        (0..a.ncols()).fold(Double::ZERO, |sum, k| sum + a[(i, k)] * b[(k, j)])
    })
}

#[cfg(test)]
mod tests;
