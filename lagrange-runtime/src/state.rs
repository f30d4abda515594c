//! State of a system: `State` (t, q, q̇), and differences and rates of states, `Tangent`.

use crate::attitude;
use crate::facts::{Constraint, CoordinateKind, Similarity};
use crate::scalar::{DoubleDouble, Functions, Real, Scalar};
use nalgebra::{SMatrix, SVector, UnitQuaternion, Vector3};

/// A state `(t, q, q̇)` of a system with `N` coordinates. Momenta are a private matter of the methods that use them.
///
/// ```
/// use lagrange_runtime::State;
/// let start = State::new(0.0, [1.2, 0.5], [0.0, 0.0]);
/// assert_eq!(start.q[1], 0.5);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(bound(
        serialize = "S: crate::Scalar + serde::Serialize",
        deserialize = "S: crate::Scalar + serde::Deserialize<'de>"
    ))
)]
pub struct State<S, const N: usize> {
    /// Time t, in s or the unit that the system is written in.
    #[cfg_attr(feature = "serde", serde(with = "crate::saved::number"))]
    pub t: S,
    /// Generalized coordinates in the order of their declaration, angles in radians; then the time integrals of
    /// [states of first order](crate::traits::States).
    #[cfg_attr(feature = "serde", serde(with = "crate::saved::vector"))]
    pub q: SVector<S, N>,
    /// Generalized velocities in the same order, in m/s of a length and rad/s of an angle; then the states of first
    /// order.
    #[cfg_attr(feature = "serde", serde(with = "crate::saved::vector"))]
    pub qd: SVector<S, N>,
}

impl<S: Scalar, const N: usize> State<S, N> {
    /// The state with coordinates `q` and velocities `qd` at time `t`.
    #[inline]
    pub fn new(t: S, q: [S; N], qd: [S; N]) -> Self {
        State { t, q: SVector::from(q), qd: SVector::from(qd) }
    }

    /// The state with coordinates `q` and velocities `qd`, N of each, at time `t`; `None` if their number is another
    /// one. (Slices of a state are `q.as_slice()` and `qd.as_slice()`.)
    ///
    /// ```
    /// use lagrange_runtime::State;
    /// let recorded = [0.0, 1.2, 0.5, 0.1, -0.1];
    /// let start = State::<f64, 2>::from_slices(recorded[0], &recorded[1..3], &recorded[3..]).expect("two of each");
    /// assert_eq!([start.q.as_slice(), start.qd.as_slice()].concat(), recorded[1..]);
    /// assert_eq!(State::<f64, 3>::from_slices(0.0, &recorded[1..3], &recorded[3..]), None);
    /// ```
    pub fn from_slices(t: S, q: &[S], qd: &[S]) -> Option<Self> {
        let (q, qd): (&[S; N], &[S; N]) = (q.try_into().ok()?, qd.try_into().ok()?);
        Some(State::new(t, *q, *qd))
    }

    /// `(q + h δq, q̇ + h δq̇)` at time `t`.
    #[inline]
    pub fn moved(&self, t: S, h: S, tangent: &Tangent<S, N>) -> Self {
        State { t, q: add_scaled(&self.q, h, &tangent.q), qd: add_scaled(&self.qd, h, &tangent.qd) }
    }

    /// `(q, q̇)` of `self` less that of `other`.
    #[inline]
    pub fn minus(&self, other: &Self) -> Tangent<S, N> {
        Tangent { q: self.q - other.q, qd: self.qd - other.qd }
    }

    /// Returns whether no component of q and q̇ is infinite or not a number (in every lane, where there are lanes).
    #[inline]
    pub fn is_finite(&self) -> bool {
        // 0 · x is 0 for finite x and NaN otherwise.
        let mut finite = true;
        for i in 0..N {
            finite &= self.q[i] * S::zero() == S::zero();
        }
        for i in 0..N {
            finite &= self.qd[i] * S::zero() == S::zero();
        }
        finite
    }
}

impl<S: Scalar, const N: usize> State<S, N> {
    /// The same with components of another type.
    #[inline(always)]
    pub fn map<R: Scalar>(&self, f: impl Fn(S) -> R) -> State<R, N> {
        State {
            t: f(self.t),
            q: SVector::from_fn(|i, _| f(self.q[i])),
            qd: SVector::from_fn(|i, _| f(self.qd[i])),
        }
    }
}

impl<S: Real, const N: usize> State<S, N> {
    /// The state with its angles brought into (−π, π] by whole turns, for the eye: integration needs them continuous.
    /// `kinds` are those of the system, `FACTS.kinds`; coordinates beyond its end stay as they are. Velocities do not
    /// change, but where the parameters of a rotation are replaced by the shorter ones of the same attitude.
    ///
    /// ```
    /// use lagrange_runtime::prelude::*;
    /// lagrangian! {
    ///     pub system Bead {
    ///         param m;
    ///         coord phi: angle, z: length;
    ///         T = 0.5 * m * (dot(phi).powi(2) + dot(z).powi(2));
    ///         V = m * z;
    ///     }
    /// }
    /// let shown = State::new(0.0, [7.0, 7.0], [1.0, 0.0]).wrapped(<Bead as Lagrangian<2>>::FACTS.kinds);
    /// assert!((shown.q[0] - (7.0 - std::f64::consts::TAU)).abs() < 1e-15);
    /// assert_eq!(shown.q[1], 7.0);
    /// ```
    pub fn wrapped(mut self, kinds: &[CoordinateKind]) -> Self {
        for (q, kind) in self.q.iter_mut().zip(kinds) {
            if *kind == CoordinateKind::Angle {
                *q = wrapped_angle(*q);
            }
        }
        let rotations = (0..kinds.len().min(N)).filter(|i| kinds[*i] == CoordinateKind::Rotation).step_by(3);
        let at = self;
        self.turned(rotations.filter(|first| attitude::square(&at.parameters(*first)).to_f64() > 1.0))
    }
}

impl<S: Scalar, const N: usize> State<S, N> {
    /// The state of a similar motion: time as t λ^b, with `by.time` = b, and coordinates as qᵢ λ^aᵢ, with velocities
    /// q̇ᵢ λ^(aᵢ − b).
    ///
    /// # Hypotheses
    /// - λ > 0; else the result is no state of a motion.
    /// - `by` is one of the [`Facts::similarities`](crate::traits::Facts) of the system.
    ///
    /// ```
    /// use lagrange_runtime::prelude::*;
    /// lagrangian! {
    ///     pub system Kepler {
    ///         param mu;
    ///         coord r: length, phi: angle;
    ///         T = 0.5 * (dot(r).powi(2) + (r * dot(phi)).powi(2));
    ///         V = -mu / r;
    ///     }
    /// }
    /// let (kepler, start) = (Kepler::new(1.0), State::new(0.0, [1.0, 0.0], [0.0, 1.2]));
    /// let end = |start, time| {
    ///     integrate(&kepler, Dop853, PiController::tolerance(1e-12), start).until(time).final_state()
    /// };
    /// // Kepler's third law: an orbit four times as large takes eight times as long.
    /// let [third] = <Kepler as Lagrangian<2>>::FACTS.similarities else { panic!() };
    /// assert_eq!((third.time, third.coordinates), (3, &[2, 0][..]));
    /// let (small, large) = (end(start, 3.0)?, end(start.scaled(third, 2.0), 24.0)?);
    /// assert!((large.q - small.scaled(third, 2.0).q).amax() < 1e-9);
    /// # Ok::<(), Failure>(())
    /// ```
    pub fn scaled(mut self, by: &Similarity, lambda: S) -> Self {
        let factor = |k: i32| Functions::powf(lambda, S::from_f64(k.into()));
        self.t *= factor(by.time);
        for (i, k) in by.coordinates.iter().enumerate().take(N) {
            self.q[i] *= factor(*k);
            self.qd[i] *= factor(*k - by.time);
        }
        self
    }

    /// The parameters of the attitude whose first coordinate is this one.
    pub(crate) fn parameters(&self, first: usize) -> Vector3<S> {
        part(&self.q, first)
    }

    /// The three parameters of an attitude and their rates.
    pub(crate) fn attitude_rates(&self, first: usize) -> [Vector3<S>; 2] {
        [self.parameters(first), part(&self.qd, first)]
    }

    /// The same state by the other parameters of these attitudes.
    #[inline(always)]
    pub(crate) fn turned(mut self, attitudes: impl Iterator<Item = usize>) -> Self {
        for first in attitudes {
            let [sigma, rate] = self.attitude_rates(first);
            let [sigma, rate] = attitude::other(&sigma, &rate);
            for i in 0..3 {
                (self.q[first + i], self.qd[first + i]) = (sigma[i], rate[i]);
            }
        }
        self
    }

    /// The attitude whose first coordinate is this one. (Systems have it by name: `system.attitude_R(&state)`.)
    ///
    /// # Panics
    /// If there are not three coordinates from there on.
    pub fn attitude(&self, first: usize) -> UnitQuaternion<S> {
        attitude::attitude(&self.parameters(first))
    }

    /// Angular velocity in rad/s, in the turned axes, of the attitude whose first coordinate is this one.
    ///
    /// # Panics
    /// If there are not three coordinates from there on.
    pub fn angular_velocity(&self, first: usize) -> Vector3<S> {
        attitude::angular_velocity(&self.parameters(first), &part(&self.qd, first))
    }

    /// Angular acceleration in rad/s², in the turned axes, of the attitude whose first coordinate is this one, at the
    /// accelerations `accel` of the coordinates. (Systems have it by name: `system.angular_acceleration_R(&state)`.)
    ///
    /// # Panics
    /// If there are not three coordinates from there on.
    pub fn angular_acceleration(&self, first: usize, accel: &SVector<S, N>) -> Vector3<S> {
        let [sigma, rate] = self.attitude_rates(first);
        attitude::angular_acceleration(&sigma, &rate, &part(accel, first))
    }
}

impl<S: Scalar, const N: usize> State<S, N> {
    /// The direction, a unit vector, whose first coordinate is this one. (Systems have it by name:
    /// `system.direction_n(&state)`.)
    ///
    /// # Panics
    /// If there are not three coordinates from there on.
    pub fn direction(&self, first: usize) -> Vector3<S> {
        part(&self.q, first)
    }
}

impl<S: Real, const N: usize> State<S, N> {
    /// The same state with the direction whose first coordinate is `first` along this vector, of any length but 0,
    /// and with what this velocity has across it. From a vector of length 0 the state is not a number, and a run ends
    /// in [`NonFinite`](crate::Failure::NonFinite).
    ///
    /// # Panics
    /// If there are not three coordinates from there on.
    pub fn with_direction(mut self, first: usize, direction: &Vector3<S>, velocity: &Vector3<S>) -> Self {
        // (The square of a very long or short vector overflows or underflows.)
        let longest = direction.iter().fold(0.0, |most: f64, x| most.max(x.to_f64().abs()));
        let scaled = direction.map(|x| x / S::from_f64(longest));
        let length = attitude::square(&scaled).sqrt();
        let n = scaled.map(|x| x / length);
        let along = attitude::dot(&n, velocity);
        for i in 0..3 {
            (self.q[first + i], self.qd[first + i]) = (n[i], velocity[i] - along * n[i]);
        }
        self
    }

    /// The same state with this attitude, whose first coordinate is `first`, and its angular velocity in rad/s, in the
    /// turned axes.
    ///
    /// # Panics
    /// If there are not three coordinates from there on.
    pub fn with_attitude(mut self, first: usize, attitude: &UnitQuaternion<S>, omega: &Vector3<S>) -> Self {
        let sigma = attitude::parameters(attitude);
        let rate = attitude::rates(&sigma, omega);
        for i in 0..3 {
            (self.q[first + i], self.qd[first + i]) = (sigma[i], rate[i]);
        }
        self
    }
}

/// Three components, from `first` on.
fn part<S: Scalar, const N: usize>(of: &SVector<S, N>, first: usize) -> Vector3<S> {
    Vector3::new(of[first], of[first + 1], of[first + 2])
}

/// The angle in (−π, π], in radians, that differs from `angle` by whole turns, with π to the digits of the scalar. The
/// error is the rounding of `angle`.
///
/// # Hypotheses
/// - `angle` is finite; else the result is NaN.
pub fn wrapped_angle<S: Real>(angle: S) -> S {
    let half: S = DoubleDouble::PI.to();
    let turn = half + half;
    let turns = angle.to_f64() / core::f64::consts::TAU;
    // Turns that cannot be counted.
    if turns.abs() >= 1.0 / f64::EPSILON {
        return angle.sin().atan2(angle.cos());
    }
    let turns = turns as i64;
    // Between −2π and 2π, but for rounding.
    let rest = S::from_f64(-turns as f64).mul_add(turn, angle);
    if rest > half {
        rest - turn
    } else if rest <= -half {
        rest + turn
    } else {
        rest
    }
}

/// A rate or a difference of states: `(δq, δq̇)`. As a rate, `δq` is the velocity and `δq̇` the acceleration.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(bound(
        serialize = "S: crate::Scalar + serde::Serialize",
        deserialize = "S: crate::Scalar + serde::Deserialize<'de>"
    ))
)]
pub struct Tangent<S, const N: usize> {
    /// The part that belongs to q.
    #[cfg_attr(feature = "serde", serde(with = "crate::saved::vector"))]
    pub q: SVector<S, N>,
    /// The part that belongs to q̇.
    #[cfg_attr(feature = "serde", serde(with = "crate::saved::vector"))]
    pub qd: SVector<S, N>,
}

impl<S: Scalar, const N: usize> Tangent<S, N> {
    /// 0.
    #[inline(always)]
    pub fn zero() -> Self {
        Tangent { q: constant(S::zero()), qd: constant(S::zero()) }
    }

    /// `a · self`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn scaled(&self, a: S) -> Self {
        let mut scaled = *self;
        if N > MAX_UNROLLED && !S::WIDE {
            scale(scaled.q.as_mut_slice(), a);
            scale(scaled.qd.as_mut_slice(), a);
            return scaled;
        }
        for i in 0..N {
            scaled.q[i] *= a;
            scaled.qd[i] *= a;
        }
        scaled
    }

    /// `self + a · other`.
    #[inline(always)]
    pub fn plus_scaled(&self, a: S, other: &Self) -> Self {
        Tangent { q: add_scaled(&self.q, a, &other.q), qd: add_scaled(&self.qd, a, &other.qd) }
    }
}

/// A state on the constraints, and how far from them the given one was.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Restored<S, const N: usize> {
    /// On the constraints, to rounding.
    pub state: State<S, N>,
    /// Name of the constraint that was violated most.
    pub constraint: &'static str,
    /// Violation without a unit, as a relative change of q or q̇: `|f| / (Σ |Aᵢ| (1 + |qᵢ|))` of positions, and
    /// `|A q̇ + b| / (Σ |Aᵢ| (1 + |q̇ᵢ|))` of velocities.
    pub violation: f64,
}

/// A start near a position at which constraints are dependent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Begun<S, const N: usize> {
    /// The start, on the branch that its velocity is along, where accelerations need states on both sides.
    pub state: Option<State<S, N>>,
    /// A state beside it, whose gradients show how long they are elsewhere.
    pub reference: State<S, N>,
}

/// Terms of one constraint at a state, `f(q, t) = 0` with `A = ∂f/∂q` or `A q̇ + b = 0`, from which linear equations
/// about the state are made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConstraintTerms<S, const N: usize> {
    /// The constraint.
    pub of: Constraint,
    /// Number of constraints of the system that may follow from others; 0 where none does.
    pub spare: usize,
    /// `f` of a constraint on positions, 0 of one on velocities.
    pub value: S,
    /// `A q̇ + b`.
    pub rate: S,
    /// Multiplier λ.
    pub multiplier: S,
    /// Its row of A.
    pub row: SVector<S, N>,
    /// `∂A/∂q`: the element (i, k) is that of the coefficient Aᵢ by the coordinate k.
    pub row_by_coordinates: SMatrix<S, N, N>,
    /// `∂(A q̇ + b)/∂q`.
    pub rate_by_coordinates: SVector<S, N>,
}

/// `x + a y`, fused where the target can.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(crate) fn add_scaled<S: Scalar, const N: usize>(
    x: &SVector<S, N>,
    a: S,
    y: &SVector<S, N>,
) -> SVector<S, N> {
    let mut sum = *x;
    if N > MAX_UNROLLED && !S::WIDE {
        add_scaled_to(sum.as_mut_slice(), a, y.as_slice());
        return sum;
    }
    // A loop and no closure: in lanes all has to be compiled into one function, and closures of `from_fn` are left
    // out of long ones.
    for i in 0..N {
        sum[i] = a.mul_add(y[i], x[i]);
    }
    sum
}

/// Sums of more coordinates are a function that is called: written out, those of one step of `Dop853` for 82
/// coordinates were 250 kB of machine code, for each method once more.
const MAX_UNROLLED: usize = 32;

/// `a x` in the place of x.
#[inline(never)]
fn scale<S: Scalar>(x: &mut [S], a: S) {
    for x in x {
        *x *= a;
    }
}

/// `x + a y` in the place of x.
#[inline(never)]
fn add_scaled_to<S: Scalar>(x: &mut [S], a: S, y: &[S]) {
    for (x, y) in x.iter_mut().zip(y) {
        *x = a.mul_add(*y, *x);
    }
}

/// The vector with `x` everywhere.
#[inline(always)]
pub(crate) fn constant<S: Scalar, const N: usize>(x: S) -> SVector<S, N> {
    SVector::from([x; N])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arithmetic_of_states_is_componentwise() {
        let a = State::new(0.0, [1.0, 2.0], [3.0, 4.0]);
        let rate = Tangent { q: a.qd, qd: a.q };
        let b = a.moved(0.5, 0.5, &rate);
        assert_eq!(b, State::new(0.5, [2.5, 4.0], [3.5, 5.0]));
        assert_eq!(b.minus(&a), rate.scaled(0.5));
        assert_eq!(Tangent::zero().plus_scaled(2.0, &rate), rate.scaled(2.0));
    }

    #[test]
    fn angles_are_wrapped_into_a_half_open_turn() {
        use core::f64::consts::{PI, TAU};
        for k in -5..=5 {
            for angle in [-3.0, -1e-9, 0.0, 0.5, 3.1] {
                let shown = wrapped_angle(angle + TAU * f64::from(k));
                assert!((shown - angle).abs() < 1e-14, "{angle} after {k} turns is {shown}");
            }
        }
        assert_eq!(wrapped_angle(-PI), PI);
        assert_eq!(wrapped_angle(PI), PI);
        assert!(wrapped_angle(f64::NAN).is_nan());
        // Turns beyond those that a number counts.
        for angle in [1e17f64, -1e22, 1e300] {
            let shown = wrapped_angle(angle);
            assert!(shown.abs() <= PI && (shown.sin() - angle.sin()).abs() < 1e-15, "{angle} is {shown}");
        }
        assert!(wrapped_angle(f64::INFINITY).is_nan());
        // π is that of the scalar.
        let pi = DoubleDouble::PI;
        let tenth = DoubleDouble::ONE / 10.0;
        for turns in [-1e6, -1.0, 0.0, 1.0, 1e6] {
            for angle in [pi - tenth * 1e-20, tenth - pi, tenth * 1e-20] {
                let missed = wrapped_angle(pi * 2.0 * turns + angle) - angle;
                assert!(missed.value().abs() < 1e-25, "{angle:?} after {turns} turns: {missed:?}");
            }
        }
        assert_eq!(wrapped_angle(-pi), pi);
        assert_eq!(wrapped_angle(pi), pi);
        let state = State::new(0.0, [4.0, 4.0, 4.0], [9.0, 9.0, 9.0]);
        let shown = state.wrapped(&[CoordinateKind::Plain, CoordinateKind::Angle]);
        assert_eq!(shown, State::new(0.0, [4.0, 4.0 - TAU, 4.0], [9.0, 9.0, 9.0]));
    }

    #[test]
    fn a_state_with_one_bad_component_is_not_finite() {
        assert!(State::new(0.0, [f64::MAX, f64::MAX], [-f64::MAX, f64::MAX]).is_finite());
        assert!(State::new(0.0, [1.0, 2.0], [3.0, 4.0]).is_finite());
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert!(!State::new(0.0, [1.0, bad], [3.0, 4.0]).is_finite());
            assert!(!State::new(0.0, [1.0, f64::INFINITY], [bad, 4.0]).is_finite());
        }
    }
}
