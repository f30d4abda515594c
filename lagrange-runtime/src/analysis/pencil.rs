//! The symmetric eigenproblem `K x = ω² M x` in double-double arithmetic, from approximate eigenvectors.

use super::AnalysisError;
use crate::scalar::DoubleDouble as Double;
use nalgebra::DMatrix;

/// Sweeps over all pairs; they converge quadratically.
const MOST_SWEEPS: usize = 60;

/// The eigenvalues, unsorted, and their vectors with `xᵀ M x = 1`, from vectors that are near them, by Jacobi
/// rotations of K and M together (Falk and Langemeyer 1960; Bathe, *Finite Element Procedures*, 1996, 11.3.2). Pairs
/// whose eigenvalues they would change by less than a rounding are left as they are.
pub(super) fn diagonalized(
    k: &DMatrix<f64>,
    m: &DMatrix<f64>,
    near: &DMatrix<f64>,
) -> Result<(Vec<f64>, DMatrix<f64>), AnalysisError> {
    let n = near.ncols();
    let mut x = near.map(Double::from);
    let mut pair = Pair { k: congruent(k, &x), m: congruent(m, &x) };
    let absolute = k.abs();
    let mut left = f64::INFINITY;
    for _ in 0..MOST_SWEEPS {
        // What rounding of the entries of K makes of the diagonal of Xᵀ K X.
        let rounding: Vec<f64> = x
            .map(|x| x.value().abs())
            .column_iter()
            .enumerate()
            .map(|(p, x)| f64::EPSILON * x.dot(&(&absolute * x)) / pair.m[(p, p)].value())
            .collect();
        left = 0.0;
        for q in 1..n {
            for p in 0..q {
                let coupling = pair.coupling(p, q, &rounding);
                if coupling > 1.0 {
                    left = f64::max(left, coupling);
                    let rotation = pair.rotation(p, q);
                    combine_columns(&mut x, p, q, rotation);
                    for a in [&mut pair.k, &mut pair.m] {
                        combine_columns(a, p, q, rotation);
                        combine_rows(a, p, q, rotation);
                    }
                }
            }
        }
        if left == 0.0 {
            break;
        }
    }
    if left > 0.0 {
        return Err(AnalysisError::NotConverged { what: "the eigenvalues of K against M", residual: left });
    }
    let Pair { k, m } = pair;
    let shapes = DMatrix::from_fn(n, n, |i, j| (x[(i, j)] / m[(j, j)].sqrt()).value());
    let squares: Vec<f64> = (0..n).map(|i| (k[(i, i)] / m[(i, i)]).value()).collect();
    match squares.iter().chain(&shapes).all(|x| x.is_finite()) {
        true => Ok((squares, shapes)),
        false => Err(AnalysisError::NotFinite),
    }
}

/// `Xᵀ K X` and `Xᵀ M X`.
struct Pair {
    k: DMatrix<Double>,
    m: DMatrix<Double>,
}

impl Pair {
    /// Change of one of the eigenvalues by the off-diagonal entries, in second order and relative to a rounding of
    /// it; or of the angle between the vectors.
    fn coupling(&self, p: usize, q: usize, rounding: &[f64]) -> f64 {
        let Pair { k, m } = self;
        let value = |i: usize| (k[(i, i)] / m[(i, i)]).value();
        let norm = (m[(p, p)].value() * m[(q, q)].value()).sqrt();
        let distance = (k[(p, p)] / m[(p, p)] - k[(q, q)] / m[(q, q)]).value().abs();
        let change = |i: usize| {
            let rest = (k[(p, q)] - k[(i, i)] / m[(i, i)] * m[(p, q)]).value() / norm;
            let allowed = f64::EPSILON * (0.25 * value(i).abs()).max(rounding[i]);
            if rest == 0.0 { 0.0 } else { (rest / allowed) * (rest / distance) }
        };
        let angle = m[(p, q)].value().abs() / norm;
        change(p).max(change(q)).max(angle / (64.0 * f64::EPSILON))
    }

    /// The factors γ and α of `xₚ + γ x_q` and `x_q + α xₚ`, whose off-diagonal entries vanish.
    fn rotation(&self, p: usize, q: usize) -> [Double; 2] {
        let Pair { k, m } = self;
        let first = k[(p, p)] * m[(p, q)] - m[(p, p)] * k[(p, q)];
        let second = k[(q, q)] * m[(p, q)] - m[(q, q)] * k[(p, q)];
        let half = (k[(p, p)] * m[(q, q)] - k[(q, q)] * m[(p, p)]) * 0.5;
        let square = half * half + first * second;
        let root = if square.value() > 0.0 { square.sqrt() } else { Double::ZERO };
        let sum = if half.value() < 0.0 { half - root } else { half + root };
        match sum == Double::ZERO {
            // K is a multiple of M here.
            true => [Double::ZERO, -m[(p, q)] / m[(p, p)]],
            false => [-first / sum, second / sum],
        }
    }
}

/// `Xᵀ A X`, symmetric.
fn congruent(a: &DMatrix<f64>, x: &DMatrix<Double>) -> DMatrix<Double> {
    let n = x.ncols();
    let mut half = DMatrix::from_element(n, n, Double::ZERO);
    for j in 0..n {
        for l in 0..n {
            for i in 0..n {
                if a[(i, l)] != 0.0 {
                    half[(i, j)] += x[(l, j)] * a[(i, l)];
                }
            }
        }
    }
    let mut all = DMatrix::from_element(n, n, Double::ZERO);
    for j in 0..n {
        for i in 0..=j {
            let sum = (0..n).fold(Double::ZERO, |sum, l| sum + x[(l, i)] * half[(l, j)]);
            (all[(i, j)], all[(j, i)]) = (sum, sum);
        }
    }
    all
}

fn combine_columns(a: &mut DMatrix<Double>, p: usize, q: usize, [gamma, alpha]: [Double; 2]) {
    for i in 0..a.nrows() {
        let (left, right) = (a[(i, p)], a[(i, q)]);
        (a[(i, p)], a[(i, q)]) = (left + gamma * right, right + alpha * left);
    }
}

fn combine_rows(a: &mut DMatrix<Double>, p: usize, q: usize, [gamma, alpha]: [Double; 2]) {
    for j in 0..a.ncols() {
        let (upper, lower) = (a[(p, j)], a[(q, j)]);
        (a[(p, j)], a[(q, j)]) = (upper + gamma * lower, lower + alpha * upper);
    }
}
