//! Systems with coordinates held: `restriction Name: phi = 0;` in [`lagrangian!`](crate::lagrangian).
//!
//! The set {q = c, q̇ = 0} of some coordinates is *invariant* if a motion that starts in it stays in it: if their
//! equations of motion hold there for whatever the others do. The system that is left is then no approximation, and a
//! [`restriction`](Restricted) of the whole one.

use crate::failure::debug_is_text;
use crate::scalar::{Real, Scalar};
use crate::state::State;
use crate::system::Lagrangian;
use core::fmt;
use nalgebra::SVector;

/// A system of `N` coordinates that came from one of `WHOLE` by holding `HELD` of them. Emitted for
/// `restriction Name: …;`.
///
/// ```
/// use lagrange_runtime::prelude::*;
///
/// lagrangian! {
///     /// A pendulum on a sphere; x and y are the tangents of its angles to the vertical.
///     pub system Spherical {
///         param m, l, g = 9.81;
///         coord theta: angle, phi: angle;
///         let x = l * theta.sin() * phi.cos();
///         let y = l * phi.sin();
///         let z = -l * theta.cos() * phi.cos();
///         T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2));
///         V = m * g * z;
///         /// What starts in a plane stays in it.
///         pub restriction Planar: phi = 0;
///     }
/// }
///
/// let spherical = Spherical::new(1.0, 0.5);
/// let start = State::new(0.0, [1.0, 0.0], [0.0, 0.0]);
/// let (planar, in_plane) = Planar::restrict(&spherical, &start)?;
/// let end = integrate(&planar, Dop853, PiController::tolerance(1e-11), in_plane).until(2.0).final_state()?;
/// let whole = integrate(&spherical, Dop853, PiController::tolerance(1e-11), start).until(2.0).final_state()?;
/// assert!((planar.lift(&end).q - whole.q).amax() < 1e-9);
/// // A start elsewhere is refused.
/// let tilted = State::new(0.0, [1.0, 0.1], [0.0, 0.0]);
/// assert_eq!(Planar::restrict(&spherical, &tilted).unwrap_err().coordinate, "phi");
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a system with coordinates held",
    note = "write `restriction Planar: phi = 0;` in the definition of the system"
)]
pub trait Restricted<const N: usize, const HELD: usize, const WHOLE: usize>: Lagrangian<N> + Sized {
    /// The system with all coordinates.
    type Whole: Lagrangian<WHOLE, Scalar = Self::Scalar>;
    /// Indices, in the whole system, of the coordinates that are left.
    const KEPT: [usize; N];
    /// Indices, in the whole system, of the removed coordinates: the held ones, and the ones that follow the others.
    const REMOVED: [usize; HELD];
    /// Flags of the removed coordinates, in the order of [`REMOVED`](Self::REMOVED): true of one that follows the
    /// others (`quasistatic`), whose value and velocity in a state of the whole system [`restrict`](Self::restrict)
    /// does not read.
    const FOLLOWS: [bool; HELD];

    /// The system with the parameters of the whole one.
    fn of(whole: &Self::Whole) -> Self;

    /// Values and velocities of the removed coordinates, in the order of [`REMOVED`](Self::REMOVED): each value in the
    /// unit of its coordinate, and each velocity in this unit per second.
    fn held(
        &self,
        q: &SVector<Self::Scalar, N>,
        qd: &SVector<Self::Scalar, N>,
        t: Self::Scalar,
    ) -> (SVector<Self::Scalar, HELD>, SVector<Self::Scalar, HELD>);

    /// Velocities of a fast motion, whose mean the system follows (`average`), beside those of the mean: −M⁻¹ b̃ of
    /// the N coordinates that are left, each in the unit of its coordinate per second; 0 where nothing was averaged.
    fn fast_velocities(&self, q: &SVector<Self::Scalar, N>, t: Self::Scalar) -> SVector<Self::Scalar, N> {
        let _ = (q, t);
        SVector::from_fn(|_, _| Self::Scalar::from_f64(0.0))
    }

    /// The state of the whole system.
    fn lift(&self, state: &State<Self::Scalar, N>) -> State<Self::Scalar, WHOLE> {
        let (q, qd) = self.held(&state.q, &state.qd, state.t);
        let fast = self.fast_velocities(&state.q, state.t);
        let zero = Self::Scalar::from_f64(0.0);
        let mut whole = State::new(state.t, [zero; WHOLE], [zero; WHOLE]);
        for (k, &i) in Self::KEPT.iter().enumerate() {
            (whole.q[i], whole.qd[i]) = (state.q[k], state.qd[k] + fast[k]);
        }
        for (k, &i) in Self::REMOVED.iter().enumerate() {
            (whole.q[i], whole.qd[i]) = (q[k], qd[k]);
        }
        whole
    }

    /// The system with the parameters of the whole one, and the part of its state that is left.
    ///
    /// # Errors
    ///
    /// [`NotHeld`], if a coordinate that is held is elsewhere or moves, by more than the rounding of its value.
    fn restrict(
        whole: &Self::Whole,
        state: &State<Self::Scalar, WHOLE>,
    ) -> Result<(Self, State<Self::Scalar, N>), NotHeld<Self::Scalar>>
    where
        Self::Scalar: Real,
    {
        let system = Self::of(whole);
        let mut kept = State::new(state.t, Self::KEPT.map(|i| state.q[i]), Self::KEPT.map(|i| state.qd[i]));
        let fast = system.fast_velocities(&kept.q, kept.t);
        for k in 0..N {
            kept.qd[k] -= fast[k];
        }
        let (q, qd) = system.held(&kept.q, &kept.qd, kept.t);
        for (k, &i) in Self::REMOVED.iter().enumerate().filter(|(k, _)| !Self::FOLLOWS[*k]) {
            for (moves, found, held) in [(false, state.q[i], q[k]), (true, state.qd[i], qd[k])] {
                let rounding = 4.0 * Self::Scalar::EPSILON * held.magnitude();
                let away = (found - held).magnitude();
                if away > rounding || away.is_nan() {
                    let coordinate = Self::Whole::FACTS.coordinates[i];
                    return Err(NotHeld { coordinate, moves, found, held });
                }
            }
        }
        Ok((system, kept))
    }
}

/// A state of the whole system that a restricted one cannot have.
#[derive(Clone, Copy, PartialEq)]
pub struct NotHeld<S> {
    /// The coordinate that is not where it is held.
    pub coordinate: &'static str,
    /// Is it the velocity of the coordinate that differs?
    pub moves: bool,
    /// Value of the coordinate, or of its velocity, in the state.
    pub found: S,
    /// Value that it has in the restricted system.
    pub held: S,
}

impl<S: fmt::Debug> fmt::Display for NotHeld<S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let NotHeld { coordinate, moves, found, held } = self;
        let what = if *moves { "the velocity of " } else { "" };
        write!(
            f,
            "{what}`{coordinate}` is {found:?}, and the restricted system holds it at {held:?}; start there, or integrate the whole system"
        )
    }
}

debug_is_text! { [S: fmt::Debug] NotHeld<S> }

impl<S: fmt::Debug> core::error::Error for NotHeld<S> {}
