//! Attitudes: rotations that are coordinates, `coord R: rotation;`, between three numbers in a
//! [`State`](crate::State) and what people know them by.
//!
//! The conventions are those of the table in the documentation of [`lagrangian!`](crate::lagrangian).
//!
//! # No attitude is special
//!
//! The quaternion of σ is `(1 − |σ|², 2 σ)/(1 + |σ|²)`, which is a unit to rounding whatever σ is: nothing drifts. σ
//! and −σ/|σ|² give q and −q, so that one formula holds for all attitudes, and every attitude has a σ of length 1 at
//! most. A run begins its next step from the shorter of the two where a step has led beyond |σ|² = [`BOUND`], and of
//! equal steps where the middle of the next one will be beyond 1: an exact point transformation between steps, by which
//! what a method remembers starts anew. Steps and interpolants are in the parameters of the beginning of the step.
//!
//! # References
//! Wiener, *Theoretical analysis of gimballess inertial reference equipment*, 1962; Marandi and Modi, *Acta
//! Astronautica* 15, 1987; Schaub and Junkins, *J. Astronaut. Sci.* 44, 1996.

use crate::scalar::{Dual, Real, Scalar};
use nalgebra::{Quaternion, Unit, UnitQuaternion, Vector3};

/// |σ|² beyond which the next step begins with the other parameters of the same attitude, a turn of 203°: far from the
/// turn of 360° at which they have no values, and so far from the 180° at which both are equally long that a motion
/// along these does not change them at every step.
pub(crate) const BOUND: f64 = 1.5;

/// The attitude that these parameters are of.
pub(crate) fn attitude<S: Scalar>(sigma: &Vector3<S>) -> UnitQuaternion<S> {
    let inverse = inverse(sigma);
    let [x, y, z] = [0, 1, 2].map(|i| sigma[i] * inverse);
    Unit::new_unchecked(Quaternion::new(inverse - S::one(), x, y, z))
}

/// Angular velocity in the turned axes.
pub(crate) fn angular_velocity<S: Scalar>(sigma: &Vector3<S>, rate: &Vector3<S>) -> Vector3<S> {
    let two = S::from_f64(2.0);
    let inverse = inverse(sigma);
    let (c, v, a) = (inverse - S::one(), sigma.map(|x| x * inverse), rate.map(|x| x * inverse));
    let (along, across) = (dot(&v, &a), cross(&v, &a));
    Vector3::from([0, 1, 2].map(|i| (c * a[i] - across[i] + along * sigma[i]) * two))
}

/// The parameters of length 1 at most of an attitude.
pub(crate) fn parameters<S: Real>(attitude: &UnitQuaternion<S>) -> Vector3<S> {
    let [x, y, z, w] = [0, 1, 2, 3].map(|i| attitude.as_ref().coords[i]);
    // What rounding has left of the length of 1 drops out.
    let length = (x * x + y * y + z * z + w * w).sqrt();
    let under = if w < S::zero() { w - length } else { w + length };
    Vector3::new(x / under, y / under, z / under)
}

/// Angular acceleration in the turned axes, where the parameters have these second derivatives.
pub(crate) fn angular_acceleration<S: Scalar>(
    sigma: &Vector3<S>,
    rate: &Vector3<S>,
    second: &Vector3<S>,
) -> Vector3<S> {
    let moving =
        |of: &Vector3<S>, slope: &Vector3<S>| of.zip_map(slope, |value, slope| Dual { value, slope });
    angular_velocity(&moving(sigma, rate), &moving(rate, second)).map(|component| component.slope)
}

/// σ̇ for an angular velocity in the turned axes.
pub(crate) fn rates<S: Scalar>(sigma: &Vector3<S>, omega: &Vector3<S>) -> Vector3<S> {
    let quarter = S::from_f64(0.25);
    let square = square(sigma);
    let (along, across) = (dot(sigma, omega), cross(sigma, omega));
    let [one, two] = [S::one(), S::from_f64(2.0)];
    Vector3::from(
        [0, 1, 2].map(|i| ((one - square) * omega[i] + (across[i] + along * sigma[i]) * two) * quarter),
    )
}

/// 2/(1 + |σ|²)
fn inverse<S: Scalar>(sigma: &Vector3<S>) -> S {
    S::from_f64(2.0) / (S::one() + square(sigma))
}

/// The other parameters of the same attitude, with their rates: −σ/|σ|².
pub(crate) fn other<S: Scalar>(sigma: &Vector3<S>, rate: &Vector3<S>) -> [Vector3<S>; 2] {
    let inverse = S::one() / square(sigma);
    let turned = sigma.map(|x| -x * inverse);
    let radial = dot(sigma, rate) * inverse * S::from_f64(-2.0);
    let moved = [0, 1, 2].map(|i| radial * turned[i] - rate[i] * inverse);
    [turned, Vector3::from(moved)]
}

pub(crate) fn dot<S: Scalar>(a: &Vector3<S>, b: &Vector3<S>) -> S {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// |a|²
pub(crate) fn square<S: Scalar>(a: &Vector3<S>) -> S {
    dot(a, a)
}

fn cross<S: Scalar>(a: &Vector3<S>, b: &Vector3<S>) -> Vector3<S> {
    Vector3::from([0, 1, 2].map(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        a[j] * b[k] - a[k] * b[j]
    }))
}

pub(crate) mod euler;
pub(crate) mod steps;
