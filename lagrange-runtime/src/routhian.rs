//! Systems without their ignorable coordinates: `routhian Name;` in [`lagrangian!`](crate::lagrangian).
//!
//! A coordinate that appears in neither L, D nor Q, and on which no force acts, has a constant momentum
//! `pᵢ = ∂L/∂q̇ᵢ`. The Routhian `R(qᵣ, q̇ᵣ, t; p) = L − Σ pᵢ q̇ᵢ`, with q̇ᵢ eliminated by these, is a Lagrangian of
//! the other coordinates (Routh, *Stability of a Given State of Motion*, 1877; Landau and Lifshitz, *Mechanics*,
//! §41). The ignorable coordinates follow afterwards, by quadrature: `qᵢ(t) = qᵢ(0) + ∫ q̇ᵢ(qᵣ, q̇ᵣ, t; p) dt`.

use crate::controller::Controller;
use crate::failure::Failure;
use crate::integrate::Run;
use crate::method::Method;
use crate::scalar::Real;
use crate::state::State;
use crate::system::{Lagrangian, at_states};
use nalgebra::SVector;

/// A system of `N` coordinates that came from one of `WHOLE` by removing `I` ignorable ones. Its
/// [`lagrangian`](Lagrangian::lagrangian) is the Routhian R. Emitted for `routhian Name;`.
///
/// Where R has no terms linear in the velocities, and T and V were given, it also implements
/// [`Energies`](crate::Energies): its kinetic energy is that of the `N` coordinates alone, its potential energy the
/// apparent (effective) potential, `−R` at `q̇ = 0`, and their sum the energy function of the whole system.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a system reduced by its ignorable coordinates",
    note = "write `routhian Reduced;` in the definition of the system, and reduce it by `system.reduce(&state)`"
)]
pub trait Routhian<const N: usize, const I: usize, const WHOLE: usize>: Lagrangian<N> {
    /// The velocities of the I ignorable coordinates, in the order of the whole system, from `∂L/∂q̇ᵢ = pᵢ`: each in
    /// the unit of its coordinate per second.
    fn ignorable_velocities(
        &self,
        q: &SVector<Self::Scalar, N>,
        qd: &SVector<Self::Scalar, N>,
        t: Self::Scalar,
    ) -> SVector<Self::Scalar, I>;

    at_states! {
        ignorable_velocities_at: ignorable_velocities -> SVector<Self::Scalar, I>;
    }

    /// The state of the whole system, with these values of its I ignorable coordinates, in the order of the whole
    /// system and each in its own unit.
    fn expand(
        &self,
        state: &State<Self::Scalar, N>,
        ignorable: &SVector<Self::Scalar, I>,
    ) -> State<Self::Scalar, WHOLE>;
}

impl<'a, Sys, M, C, const N: usize> Run<'a, Sys, M, C, N>
where
    Sys: Lagrangian<N>,
    Sys::Scalar: Real,
    M: Method<Sys, N>,
    C: Controller<Sys::Scalar, N, M::Error>,
{
    /// The states of the whole system at the ends of accepted steps of a reduced one, where `ignorable` are the
    /// values of the ignorable coordinates at the start. Their quadrature is that of [`Run::integrals`], to the order
    /// given there.
    ///
    /// ```
    /// use lagrange_runtime::prelude::*;
    /// lagrangian! {
    ///     pub system Orbit {
    ///         param mu;
    ///         coord r: length, phi: angle;
    ///         T = 0.5 * (dot(r).powi(2) + (r * dot(phi)).powi(2));
    ///         V = -mu / r;
    ///         pub routhian Radial;
    ///     }
    /// }
    /// // A circle: the angle grows at the rate p/r² = 1.
    /// let start = State::new(0.0, [1.0, 0.5], [0.0, 1.0]);
    /// let (radial, state) = Orbit::new(1.0).reduce(&start);
    /// assert_eq!((radial.p_phi, radial.potential(&state.q, 0.0)), (1.0, -0.5));
    /// for state in integrate(&radial, Dop853, PiController::tolerance(1e-10), state).until(6.0).recover([0.5]) {
    ///     let state = state?;
    ///     assert!((state.q[1] - 0.5 - state.t).abs() < 1e-9);
    /// }
    /// # Ok::<(), Failure>(())
    /// ```
    pub fn recover<const I: usize, const WHOLE: usize>(
        self,
        ignorable: [Sys::Scalar; I],
    ) -> impl Iterator<Item = Result<State<Sys::Scalar, WHOLE>, Failure<Sys::Scalar>>>
    where
        Sys: Routhian<N, I, WHOLE>,
    {
        let system = self.system();
        let velocities =
            move |s: &State<Sys::Scalar, N>| system.ignorable_velocities(&s.q, &s.qd, s.t).into();
        self.integrals(ignorable, velocities)
            .map(move |total| total.map(|at| system.expand(&at.state, &at.integrals.into())))
    }
}
