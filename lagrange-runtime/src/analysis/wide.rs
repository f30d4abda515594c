//! Complex numbers of about 32 digits, and elimination with them on dynamic matrices.

use crate::linear::{Complex as Pair, Entry};
use crate::scalar::DoubleDouble as Double;
use nalgebra::{Complex, DMatrix, DVector};

/// A complex number of about 32 digits.
pub(super) type Wide = Pair<Double>;

/// Reciprocals of double-double numbers smaller than that overflow.
const SMALLEST_PIVOT: f64 = 1e-280;

pub(super) fn wide(z: Complex<f64>) -> Wide {
    Wide { re: z.re.into(), im: z.im.into() }
}

pub(super) fn narrow(z: Wide) -> Complex<f64> {
    Complex::new(z.re.value(), z.im.value())
}

pub(super) fn norm(z: Wide) -> f64 {
    z.re.value().hypot(z.im.value())
}

/// An imaginary part below half a unit in the last place is rounding.
pub(super) fn is_real(z: Wide) -> bool {
    z.im.value().abs() <= 0.25 * f64::EPSILON * norm(z)
}

/// `xᵀ A y`
pub(super) fn form(x: &DVector<Wide>, a: &DMatrix<Wide>, y: &DVector<Wide>) -> Wide {
    let mut sum = wide(Complex::new(0.0, 0.0));
    for j in 0..y.len() {
        let column = (0..x.len()).fold(wide(Complex::new(0.0, 0.0)), |sum, i| sum + x[i] * a[(i, j)]);
        sum = sum + column * y[j];
    }
    sum
}

/// The vector that a matrix, singular but for rounding, takes to zero: two steps of inverse iteration (Golub and Van
/// Loan, *Matrix Computations*, 2013, 7.6.1).
pub(super) fn null_vector(a: DMatrix<Wide>) -> DVector<Wide> {
    let factors = Lu::of(a);
    let mut x = DVector::from_fn(factors.rows.len(), |i, _| {
        wide(Complex::new(1.0 + (0.618 * i as f64).fract(), 0.0))
    });
    for _ in 0..2 {
        x = factors.solve(x);
        let largest = x.iter().copied().fold((0.0, wide(Complex::new(1.0, 0.0))), |most, x| {
            if norm(x) > most.0 { (norm(x), x) } else { most }
        });
        x = x.map(|x| x / largest.1);
    }
    x
}

/// `P A = L U` with partial pivoting; a pivot that vanishes is replaced by [`SMALLEST_PIVOT`].
pub(super) struct Lu {
    factors: DMatrix<Wide>,
    rows: Vec<usize>,
}

impl Lu {
    pub fn of(mut a: DMatrix<Wide>) -> Self {
        let n = a.nrows();
        let (mut rows, zero): (Vec<usize>, _) = ((0..n).collect(), wide(Complex::new(0.0, 0.0)));
        for j in 0..n {
            let pivot = (j..n).fold(j, |best, i| if norm(a[(i, j)]) > norm(a[(best, j)]) { i } else { best });
            a.swap_rows(j, pivot);
            rows.swap(j, pivot);
            if norm(a[(j, j)]) < SMALLEST_PIVOT {
                a[(j, j)] = Wide::real(SMALLEST_PIVOT.into());
            }
            for i in j + 1..n {
                a[(i, j)] = a[(i, j)] / a[(j, j)];
            }
            for k in j + 1..n {
                let above = a[(j, k)];
                if above != zero {
                    (j + 1..n).for_each(|i| a[(i, k)] = a[(i, k)] - a[(i, j)] * above);
                }
            }
        }
        Lu { factors: a, rows }
    }

    /// The x with `A x = b`.
    pub fn solve(&self, b: DVector<Wide>) -> DVector<Wide> {
        let (a, n, zero) = (&self.factors, self.rows.len(), wide(Complex::new(0.0, 0.0)));
        let mut x = DVector::from_fn(n, |i, _| b[self.rows[i]]);
        for j in 0..n {
            if x[j] != zero {
                (j + 1..n).for_each(|i| x[i] = x[i] - a[(i, j)] * x[j]);
            }
        }
        for j in (0..n).rev() {
            x[j] = x[j] / a[(j, j)];
            for i in 0..j {
                x[i] = x[i] - a[(i, j)] * x[j];
            }
        }
        x
    }
}
