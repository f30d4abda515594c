//! Rotations that are parameters, `param R: rotation;`: their three numbers by a matrix or a quaternion.

use crate::attitude::parameters;
use crate::scalar::Real;
use core::fmt;
use nalgebra::{Quaternion, Unit, UnitQuaternion};

/// Reason why a matrix is no rotation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NotARotation {
    /// Its rows are not of unit length and perpendicular to each other: the largest element of `R Rᵀ − 1`.
    NotOrthonormal {
        /// That element.
        off: f64,
    },
    /// Its determinant is −1.
    Reflection,
}

impl fmt::Display for NotARotation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            NotARotation::NotOrthonormal { off } => write!(
                f,
                "this matrix is no rotation: its rows are not of unit length and perpendicular to each other, by {off:.1e}; give 16 digits, or a quaternion"
            ),
            NotARotation::Reflection => {
                f.write_str("this matrix is a reflection, not a rotation: its determinant is -1; change the sign of one row")
            }
        }
    }
}

impl core::error::Error for NotARotation {}

/// Largest element of `R Rᵀ − 1` of a rotation: that of the matrices of numbers in a definition.
const ROUNDED: f64 = 1e-12;

/// The parameters of the rotation that a matrix is, by its rows: `x_parent = R x`.
///
/// ```
/// use lagrange_runtime::prelude::*;
/// use lagrange_runtime::traits::rotation;
///
/// lagrangian! {
///     /// A plate that turns about an axis which is set up by measurement.
///     system Plate {
///         param m, g = 9.81, mount: rotation;
///         coord phi: angle;
///         let axes = frame(world, [0, 0, 0], mount * rotation_z(phi));
///         let centre = frame(axes, [0.2, 0, 0]);
///         T = body(m, [0.01, 0.02, 0.03], centre);
///         V = m * g * centre.origin()[2];
///     }
/// }
/// // The axis is level: the plate is a pendulum, with J = 0.03 + m 0.2².
/// let mount = rotation::by_matrix(&[[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])?;
/// let plate = Plate::new(1.5, mount);
/// let acceleration = plate.accel(&[0.0].into(), &[3.0].into(), 0.0)[0];
/// assert!((acceleration + 1.5 * 9.81 * 0.2 / 0.09).abs() < 1e-13);
///
/// assert!(rotation::by_matrix(&[[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]]).is_err(), "a reflection");
/// # Ok::<(), rotation::NotARotation>(())
/// ```
///
/// # Errors
/// [`NotARotation`] if the rows are not orthonormal to 1e-12, or make a reflection.
pub fn by_matrix<S: Real>(rows: &[[S; 3]; 3]) -> Result<[S; 3], NotARotation> {
    let number = rows.map(|row| row.map(|x| x.to_f64()));
    let product = |i: usize, j: usize| (0..3).map(|k| number[i][k] * number[j][k]).sum::<f64>();
    let off = |i: usize, j: usize| (product(i, j) - f64::from(u8::from(i == j))).abs();
    let pairs = (0..3).flat_map(|i| (i..3).map(move |j| (i, j)));
    // (Not a number is the largest.)
    let larger = |most: f64, off: f64| if most.is_nan() || off <= most { most } else { off };
    let off = pairs.fold(0.0, |most, (i, j)| larger(most, off(i, j)));
    let rounded = off <= ROUNDED;
    if !rounded {
        return Err(NotARotation::NotOrthonormal { off });
    }
    let minor = |i: usize, j: usize| number[1][i] * number[2][j] - number[1][j] * number[2][i];
    let determinant = number[0][0] * minor(1, 2) + number[0][1] * minor(2, 0) + number[0][2] * minor(0, 1);
    if determinant < 0.0 {
        return Err(NotARotation::Reflection);
    }
    // Four times the product of the quaternion's component k and its others, from the row with the largest diagonal
    // (Shepperd, *J. Guidance and Control* 1, 1978).
    let r = |i: usize, j: usize| rows[i][j];
    let trace = r(0, 0) + r(1, 1) + r(2, 2);
    let one = S::one();
    let (skew, even) = (|i: usize, j: usize| r(j, i) - r(i, j), |i: usize, j: usize| r(j, i) + r(i, j));
    let square = |i: usize| one - trace + r(i, i) + r(i, i);
    let squares = [square(0), square(1), square(2), one + trace];
    let largest = (0..4).max_by(|&a, &b| squares[a].to_f64().total_cmp(&squares[b].to_f64())).unwrap_or(3);
    let of = [
        [squares[0], even(0, 1), even(0, 2), skew(1, 2)],
        [even(0, 1), squares[1], even(1, 2), skew(2, 0)],
        [even(0, 2), even(1, 2), squares[2], skew(0, 1)],
        [skew(1, 2), skew(2, 0), skew(0, 1), squares[3]],
    ];
    let [x, y, z, w] = of[largest];
    Ok(by_quaternion(&Unit::new_unchecked(Quaternion::new(w, x, y, z))))
}

/// The parameters of the rotation that a quaternion is. Its length drops out.
pub fn by_quaternion<S: Real>(rotation: &UnitQuaternion<S>) -> [S; 3] {
    parameters(rotation).into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::attitude::attitude;
    use nalgebra::{Matrix3, Vector3};

    /// Turns by all angles about many axes, half turns among them, come back to rounding.
    #[test]
    fn matrices_come_back() {
        for k in 0..400 {
            let u = f64::from(k);
            let axis = Unit::new_normalize(Vector3::new((0.7 * u).sin(), (1.3 * u).cos(), (2.9 * u).sin()));
            for angle in [0.0, 1e-9, 0.3 + 0.01 * u, core::f64::consts::PI, 3.0, 6.2] {
                let matrix = UnitQuaternion::from_axis_angle(&axis, angle).to_rotation_matrix().into_inner();
                let rows = [0, 1, 2].map(|i| [0, 1, 2].map(|j| matrix[(i, j)]));
                let sigma = by_matrix(&rows).unwrap();
                let back: Matrix3<f64> = attitude(&Vector3::from(sigma)).to_rotation_matrix().into_inner();
                assert!((back - matrix).amax() < 2e-15, "{axis:?} {angle}");
            }
        }
    }

    #[test]
    fn other_matrices_are_refused() {
        let identity = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let changed = |i: usize, j: usize, x: f64| {
            let mut rows = identity;
            rows[i][j] = x;
            by_matrix(&rows).unwrap_err()
        };
        assert_eq!(changed(1, 1, -1.0), NotARotation::Reflection);
        for (i, j, x) in
            [(0, 1, 1e-6), (2, 2, 1.0 + 1e-9), (0, 0, f64::NAN), (2, 0, f64::INFINITY), (0, 0, 0.0)]
        {
            assert!(matches!(changed(i, j, x), NotARotation::NotOrthonormal { .. }), "{i} {j} {x}");
        }
    }
}
