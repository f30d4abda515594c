//! Euler's angles in any order of axes.

use super::cross;
use crate::scalar::{Dual, Real, Scalar};
use crate::state::wrapped_angle;
use nalgebra::{Quaternion, Unit, UnitQuaternion, Vector3};

/// Euler's angles by the order of their axes, each of which the turns before have turned: `Zxz` about z, then about the
/// new x, then about the new z, as in `rotation_z(psi) * rotation_x(theta) * rotation_z(phi)`.
///
/// Angles about the axes of the parent are those of the opposite order, read from the end: roll, pitch and yaw about
/// fixed x, y and z are yaw, pitch and roll of `Zyx`.
///
/// ```
/// use lagrange_runtime::prelude::*;
/// use lagrange_runtime::traits::rotation::EulerAngles;
///
/// lagrangian! {
///     /// A heavy top.
///     system Top {
///         param A = 1.0, C = 0.5, mgl = 2.0;
///         coord R: rotation;
///         let axes = frame(world, [0, 0, 0], R);
///         T = body(1.0, [A, A, C], axes);
///         V = mgl * axes.point([0, 0, 1])[2];
///     }
/// }
/// let top = Top::default();
/// // A steady precession: C ω₃ Ω = mgl + A Ω² cos θ, with ω₃ = spin + Ω cos θ.
/// let along = 0.5 * 0.8f64.cos();
/// let spin = (2.0 / 0.5 + along) / 0.5 - along;
/// let (angles, rates) = ([0.3, 0.8, 0.0], [0.5, 0.0, spin]);
/// let (attitude, omega) = (EulerAngles::Zxz.rotation(angles), EulerAngles::Zxz.angular_velocity(angles, rates));
/// let start = top.with_attitude_R(State::new(0.0, [0.0; 3], [0.0; 3]), &attitude, &omega);
/// let end = integrate(&top, Dop853, PiController::tolerance(1e-10), start).until(1.0).final_state()?;
/// let [precession, nutation, _] = EulerAngles::Zxz.angles(&top.attitude_R(&end));
/// assert!((precession - 0.8).abs() < 1e-8 && (nutation - 0.8).abs() < 1e-8);
/// # Ok::<(), Failure>(())
/// ```
///
/// # References
/// Bernardes and Viollet, *PLoS ONE* 17(11), e0276302, 2022.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[expect(missing_docs, reason = "the names say it")]
pub enum EulerAngles {
    Xyx,
    Xzx,
    Yxy,
    Yzy,
    Zxz,
    Zyz,
    Xyz,
    Xzy,
    Yxz,
    Yzx,
    Zxy,
    Zyx,
}

impl EulerAngles {
    /// All orders of axes.
    pub const ALL: [EulerAngles; 12] = {
        use EulerAngles::*;
        [Xyx, Xzx, Yxy, Yzy, Zxz, Zyz, Xyz, Xzy, Yxz, Yzx, Zxy, Zyx]
    };

    /// The numbers of the axes.
    fn axes(self) -> [usize; 3] {
        use EulerAngles::*;
        match self {
            Xyx => [0, 1, 0],
            Xzx => [0, 2, 0],
            Yxy => [1, 0, 1],
            Yzy => [1, 2, 1],
            Zxz => [2, 0, 2],
            Zyz => [2, 1, 2],
            Xyz => [0, 1, 2],
            Xzy => [0, 2, 1],
            Yxz => [1, 0, 2],
            Yzx => [1, 2, 0],
            Zxy => [2, 0, 1],
            Zyx => [2, 1, 0],
        }
    }

    /// The rotation by these angles in rad.
    pub fn rotation<S: Scalar>(self, angles: [S; 3]) -> UnitQuaternion<S> {
        let half = S::from_f64(0.5);
        let mut rotation: Option<Parts<S>> = None;
        for (axis, angle) in self.axes().into_iter().zip(angles) {
            let (sine, cosine) = (angle * half).sin_cos();
            let mut along = Vector3::from([S::zero(); 3]);
            along[axis] = sine;
            let turn = (cosine, along);
            rotation = Some(rotation.map_or(turn, |before| product(&before, &turn)));
        }
        let (w, v) = rotation.unwrap_or((S::one(), Vector3::from([S::zero(); 3])));
        Unit::new_unchecked(Quaternion::new(w, v[0], v[1], v[2]))
    }

    /// Angular velocity in rad/s, in the turned axes, at these angles in rad and rates in rad/s.
    pub fn angular_velocity<S: Scalar>(self, angles: [S; 3], rates: [S; 3]) -> Vector3<S> {
        let moving = [0, 1, 2].map(|i| Dual { value: angles[i], slope: rates[i] });
        let q = self.rotation(moving);
        let [x, y, z, w] = [0, 1, 2, 3].map(|i| q.as_ref().coords[i]);
        let (v, rate) = (Vector3::from([x.value, y.value, z.value]), [x.slope, y.slope, z.slope]);
        // 2 q* q̇
        let across = cross(&v, &Vector3::from(rate));
        Vector3::from([0, 1, 2].map(|i| (w.value * rate[i] - w.slope * v[i] - across[i]) * S::from_f64(2.0)))
    }

    /// These angles of a rotation, in rad: the middle one in \[0, π\] for orders that end with their first axis, in
    /// \[−π/2, π/2\] for others, and those beside it in (−π, π\].
    ///
    /// At the ends of its range (gimbal lock) the sum or the difference of the other two alone has a meaning. Which
    /// part of it is whose is rounding there; together they turn the body right. Of a quaternion of length 0 they are
    /// NaN.
    pub fn angles<S: Real>(self, rotation: &UnitQuaternion<S>) -> [S; 3] {
        let [i, j, k] = self.axes();
        let (q, is_symmetric) = (&rotation.as_ref().coords, i == k);
        let is_right_handed = (i + 1) % 3 == j;
        let third = q[3 - i - j];
        let across = if is_right_handed { third } else { -third };
        // These are cos ½β and sin ½β times cosine and sine of ½(α ± γ), for angles α, β, γ about axes i, j, i. A
        // quarter turn about j more makes ± i of the third axis.
        let [a, b, c, d] = match is_symmetric {
            true => [q[3], q[i], q[j], across],
            false => [q[3] - q[j], q[i] - across, q[j] + q[3], q[i] + across],
        };
        if [a, b, c, d].iter().all(|part| part.to_f64() == 0.0) {
            return [S::from_f64(f64::NAN); 3];
        }
        let (sum, difference) = (b.atan2(a), d.atan2(c));
        let half = (c * c + d * d).sqrt().atan2((a * a + b * b).sqrt());
        let quarter = S::one().atan2(S::zero());
        let middle = if is_symmetric { half + half } else { half + half - quarter };
        let [first, last] = [sum + difference, sum - difference];
        let last = if !is_symmetric && is_right_handed { -last } else { last };
        [wrapped_angle(first), middle, wrapped_angle(last)]
    }
}

/// A quaternion by its scalar and its vector.
type Parts<S> = (S, Vector3<S>);

fn product<S: Scalar>((w, v): &Parts<S>, (u, b): &Parts<S>) -> Parts<S> {
    let across = cross(v, b);
    let vector = [0, 1, 2].map(|i| *w * b[i] + *u * v[i] + across[i]);
    (*w * *u - super::dot(v, b), Vector3::from(vector))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn turns(order: EulerAngles, angles: [f64; 3]) -> UnitQuaternion<f64> {
        let axes = [Vector3::x_axis(), Vector3::y_axis(), Vector3::z_axis()];
        let [one, two, three] =
            [0, 1, 2].map(|i| UnitQuaternion::from_axis_angle(&axes[order.axes()[i]], angles[i]));
        one * two * three
    }

    /// Angles, half turns and gimbal lock among them, are read as they were given, or as others of the same rotation.
    #[test]
    fn angles_of_all_orders_come_back() {
        for order in EulerAngles::ALL {
            let symmetric = order.axes()[0] == order.axes()[2];
            for n in 0..400 {
                let u = f64::from(n);
                let middle = match n % 4 {
                    0 => [0.0, 1e-9, std::f64::consts::FRAC_PI_2, std::f64::consts::PI][n as usize / 4 % 4],
                    _ => 0.0078 * u,
                };
                let middle = if symmetric { middle } else { middle - std::f64::consts::FRAC_PI_2 };
                let angles = [3.1 * (0.7 * u).sin(), middle, 3.1 * (1.9 * u).cos()];
                let rotation = turns(order, angles);
                assert!(order.rotation(angles).angle_to(&rotation) < 1e-15, "{order:?} {angles:?}");
                let found = order.angles(&rotation);
                assert!(turns(order, found).angle_to(&rotation) < 2e-15, "{order:?} {angles:?} {found:?}");
                let low = if symmetric { 0.0 } else { -std::f64::consts::FRAC_PI_2 };
                assert!(found[1] >= low && found[1] <= low + std::f64::consts::PI, "{order:?} {found:?}");
                assert!((found[1] - middle).abs() < 1e-15, "{order:?} {angles:?} {found:?}");
                if n % 4 != 0 && n < 399 {
                    let off = (0..3).map(|i| (found[i] - angles[i]).abs()).fold(0.0, f64::max);
                    assert!(off < 1e-12, "{order:?} {angles:?} {found:?}");
                }
            }
        }
    }

    /// Roll, pitch and yaw of nalgebra are about fixed axes.
    #[test]
    fn angles_about_fixed_axes_are_those_of_the_opposite_order() {
        let [roll, pitch, yaw] = [0.3, -1.2, 2.9];
        let rotation = UnitQuaternion::from_euler_angles(roll, pitch, yaw);
        assert!(EulerAngles::Zyx.rotation([yaw, pitch, roll]).angle_to(&rotation) < 1e-15);
    }

    #[test]
    fn a_quaternion_of_length_0_has_no_angles() {
        let nothing = Unit::new_unchecked(Quaternion::new(0.0, 0.0, 0.0, 0.0));
        for order in EulerAngles::ALL {
            assert!(order.angles(&nothing).iter().all(|x: &f64| x.is_nan()), "{order:?}");
        }
    }

    /// Angular velocities against difference quotients of matrices.
    #[test]
    fn rates_give_angular_velocities() {
        for order in EulerAngles::ALL {
            let (angles, rates, h) = ([0.7, 0.4, -1.3], [0.5, -2.0, 3.0], 1e-5);
            let at = |t: f64| turns(order, [0, 1, 2].map(|i| angles[i] + t * rates[i])).to_rotation_matrix();
            let (before, now, after) = (at(-h), at(0.0), at(h));
            let skew = now.matrix().transpose() * (after.matrix() - before.matrix()) / (2.0 * h);
            let omega = Vector3::new(skew[(2, 1)], skew[(0, 2)], skew[(1, 0)]);
            assert!((order.angular_velocity(angles, rates) - omega).norm() < 1e-8, "{order:?}");
        }
    }
}
