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

/// `P A Q = L U` with complete pivoting (Golub and Van Loan, *Matrix Computations*, 2013, 3.4.8), so that what makes a
/// matrix singular is left for the last pivots; one that vanishes is replaced by [`SMALLEST_PIVOT`].
pub(super) struct Lu {
    factors: DMatrix<Wide>,
    rows: Vec<usize>,
    columns: Vec<usize>,
}

impl Lu {
    pub fn of(mut a: DMatrix<Wide>) -> Self {
        let n = a.nrows();
        let (mut rows, mut columns): (Vec<usize>, Vec<usize>) = ((0..n).collect(), (0..n).collect());
        let zero = wide(Complex::new(0.0, 0.0));
        for j in 0..n {
            let places = (j..n).flat_map(|k| (j..n).map(move |i| (i, k)));
            let (row, column) =
                places.fold((j, j), |best, place| if norm(a[place]) > norm(a[best]) { place } else { best });
            a.swap_rows(j, row);
            rows.swap(j, row);
            a.swap_columns(j, column);
            columns.swap(j, column);
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
        Lu { factors: a, rows, columns }
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
        placed(&self.columns, &x)
    }

    /// The y and x with `yᵀ A = 0` and `A x = 0` of a matrix that is singular but for its last pivot, their largest
    /// entries 1.
    pub fn null_vectors(&self) -> [DVector<Wide>; 2] {
        let (a, n) = (&self.factors, self.rows.len());
        let mut last = DVector::from_element(n, wide(Complex::new(0.0, 0.0)));
        last[n - 1] = Wide::real(Double::ONE);
        let (mut left, mut right) = (last.clone(), last);
        for i in (0..n - 1).rev() {
            for k in i + 1..n {
                left[i] = left[i] - a[(k, i)] * left[k];
                right[i] = right[i] - a[(i, k)] * right[k];
            }
            right[i] = right[i] / a[(i, i)];
        }
        [(&self.rows, left), (&self.columns, right)].map(|(places, x)| {
            let largest = (0..n).fold(0, |most, i| if norm(x[i]) > norm(x[most]) { i } else { most });
            placed(places, &x.map(|entry| entry / x[largest]))
        })
    }
}

/// Entries at these places.
fn placed(places: &[usize], x: &DVector<Wide>) -> DVector<Wide> {
    let mut all = x.clone();
    places.iter().zip(x).for_each(|(&place, entry)| all[place] = *entry);
    all
}
