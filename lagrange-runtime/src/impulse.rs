//! Impulses: the jump of the velocities, and the energy that it adds (Beatty 2006, 11.9, (11.58): Δp = P).

use crate::constraint::{Constrained, struck};
use crate::linear::factored;
use crate::scalar::Scalar;
use crate::state::State;
use crate::system::{Lagrangian, LegendreTransform};
use nalgebra::SVector;

/// Effect of an impulse.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jump<S, const N: usize> {
    /// The state after it: the same positions, other velocities.
    pub after: State<S, N>,
    /// Generalized impulses of the constraints, by coordinates, in N s of a length and N m s of an angle; 0 where the
    /// coordinates are independent.
    pub reaction: SVector<S, N>,
    /// The energy in J that it adds, `(P + reaction)·(q̇⁻ + q̇⁺)/2`: the change of the energy function `h`, which is
    /// that of the kinetic energy where the system is scleronomic.
    pub energy: S,
}

/// A system that can be struck: whose L is quadratic in the velocities.
#[diagnostic::on_unimplemented(
    message = "impulses need a Lagrangian that is quadratic in the velocities, which that of `{Self}` is not"
)]
pub trait Impulsive<const N: usize>: Lagrangian<N> {
    /// The jump at an impact of a point on a body that does not move, without friction: the rate `n·q̇` at which the
    /// point moves along the normal becomes `−e n·q̇` with the coefficient of restitution e (Newton), by an impulse
    /// along the normal.
    ///
    /// `normal` is n, the N generalized impulses of a unit impulse at the point along the normal, from the function of
    /// an `impulse name at [x, y];` statement. (Velocities do no virtual work, so that the same n takes q̇ to the
    /// velocity of the point.) The impulse is `−(1 + e) n·q̇ / (n·M⁻¹ n)`, under constraints with the response that
    /// they admit.
    ///
    /// # Hypotheses
    /// - The point is one of the system, and it can move along the normal: otherwise velocities are not finite.
    /// - The point's position does not depend on time, as that on a prescribed coordinate does: otherwise only its
    ///   velocity relative to what moves it is reversed.
    fn rebound(
        &self,
        at: &State<Self::Scalar, N>,
        normal: &SVector<Self::Scalar, N>,
        restitution: Self::Scalar,
    ) -> Jump<Self::Scalar, N> {
        let inner = |a: &SVector<Self::Scalar, N>, b: &SVector<Self::Scalar, N>| {
            (0..N).fold(Self::Scalar::zero(), |sum, i| sum + a[i] * b[i])
        };
        let along = |qd: &SVector<Self::Scalar, N>| inner(normal, qd);
        let speed = along(&at.qd);
        // An impulse of the size of the motion, 2T over its speed: what one of 1 N s adds to a heavy body is rounding.
        let inertia = self.inertia(&at.q, &at.qd, at.t);
        let momenta = SVector::from_fn(|i, _| inner(&inertia.column(i).into_owned(), &at.qd));
        let size = inner(&momenta, &at.qd) / speed;
        let is_size = size * Scalar::zero() == Scalar::zero() && size != Scalar::zero();
        let size = if is_size { size } else { Scalar::one() };
        let gained = along(&(self.jump(at, &(normal * size)).after.qd - at.qd));
        let impulse = -(Self::Scalar::one() + restitution) * speed / gained;
        self.jump(at, &(normal * (size * impulse)))
    }

    /// The jump `q̇⁺ = q̇⁻ + M⁻¹ (P + Aᵀ Λ)` by a generalized impulse P, an entry for each coordinate, in N s of a
    /// length and N m s of an angle: the time integral of the generalized forces over a blow so short that nothing
    /// moves. Λ are the impulses of the constraints. A force impulse at a point becomes a generalized one by the
    /// function of an `impulse name at [x, y];` statement. Near a position in which constraints are dependent the jump
    /// is that of the branch that q̇ is along, and not a number where q̇ is along none.
    ///
    /// ```
    /// use lagrange_runtime::prelude::*;
    ///
    /// lagrangian! {
    ///     /// A bar on a smooth table.
    ///     system Bar {
    ///         param m, l;
    ///         coord x, y, theta;
    ///         T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2)) + m * l.powi(2) / 24.0 * dot(theta).powi(2);
    ///         V = 0;
    ///         impulse blow at [x + 0.5 * l * cos(theta), y + 0.5 * l * sin(theta)];
    ///     }
    /// }
    /// let bar = Bar::new(2.0, 0.6);
    /// let rest = State::new(0.0, [0.0; 3], [0.0; 3]);
    /// let jump = bar.jump(&rest, &bar.blow(&rest.q, 0.0, &SVector::from([0.0, 1.0])));
    /// assert!((jump.after.qd[1] - 1.0 / 2.0).abs() < 1e-15, "P/m");
    /// assert!((jump.after.qd[2] - 6.0 / (2.0 * 0.6)).abs() < 1e-14, "6P/(ml)");
    /// assert!((jump.energy - 4.0 / (2.0 * 2.0)).abs() < 1e-14, "4P²/(2m)");
    /// ```
    fn jump(&self, at: &State<Self::Scalar, N>, impulse: &SVector<Self::Scalar, N>) -> Jump<Self::Scalar, N>;
}

impl<Sys: LegendreTransform<N>, const N: usize> Impulsive<N> for Sys {
    fn jump(&self, at: &State<Self::Scalar, N>, impulse: &SVector<Self::Scalar, N>) -> Jump<Self::Scalar, N> {
        let p = self.momenta(&at.q, &at.qd, at.t) + impulse;
        let qd = self.velocities(&at.q, &p, at.t);
        jump(at, qd, impulse, SVector::from_fn(|_, _| Sys::Scalar::zero()))
    }
}

/// [`Impulsive::jump`] of a system with constraints.
pub fn constrained_jump<Sys: Constrained<N, M>, const N: usize, const M: usize>(
    system: &Sys,
    at: &State<Sys::Scalar, N>,
    impulse: &SVector<Sys::Scalar, N>,
) -> Jump<Sys::Scalar, N> {
    let [change, reaction] = struck(system, at, impulse);
    jump(at, at.qd + change, impulse, reaction)
}

/// [`Impulsive::jump`] of a system with states of first order, which no impulse changes.
pub fn jump_beside_states<Sys: Lagrangian<N>, const N: usize>(
    system: &Sys,
    at: &State<Sys::Scalar, N>,
    impulse: &SVector<Sys::Scalar, N>,
) -> Jump<Sys::Scalar, N> {
    let zero = Sys::Scalar::zero();
    let impulse = SVector::from_fn(|i, _| if i < N - Sys::FIRST_ORDER { impulse[i] } else { zero });
    let change = factored(&system.inertia(&at.q, &at.qd, at.t)).solve(&impulse);
    jump(at, at.qd + change, &impulse, SVector::from_fn(|_, _| zero))
}

fn jump<S: Scalar, const N: usize>(
    at: &State<S, N>,
    qd: SVector<S, N>,
    impulse: &SVector<S, N>,
    reaction: SVector<S, N>,
) -> Jump<S, N> {
    let half = S::from_f64(0.5);
    let energy =
        (0..N).fold(S::zero(), |sum, i| sum + (impulse[i] + reaction[i]) * (at.qd[i] + qd[i]) * half);
    Jump { after: State { qd, ..*at }, reaction, energy }
}
