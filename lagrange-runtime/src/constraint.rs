//! Systems whose coordinates are not independent: constraints, multipliers, reactions, and states that satisfy them.
//!
//! A constraint on positions is `f(q, t) = 0` (holonomic), one on velocities `g = Σ aᵢ(q, t) q̇ᵢ + b(q, t) = 0`. With
//! `A = ∂f/∂q` or a, the equations of motion are `M q̈ + bias = force + Aᵀ λ` together with `d/dt (A q̇ + b) = 0`
//! (Lagrange's method of multipliers, and for velocities the Lagrange–d'Alembert principle; Neimark and Fufaev,
//! *Dynamics of Nonholonomic Systems*, 1972, ch. III). `accel` of a constrained system solves both for q̈, so that every
//! method for (q, q̇) integrates it. That determines the constraints only up to their second derivative: what would drift is
//! removed after each step by projection, see [`restore`]; nothing is to be tuned.

use crate::failure::Failure;
use crate::scalar::{Real, Scalar};
use crate::state::State;
use crate::system::Lagrangian;
use nalgebra::{SMatrix, SVector};

/// A constraint of a system.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Constraint {
    /// Its name.
    pub name: &'static str,
    /// What it restricts.
    pub kind: ConstraintKind,
}

/// What a constraint restricts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ConstraintKind {
    /// Positions: `f(q, t) = 0`.
    Holonomic,
    /// Velocities, but so that it follows from a relation between positions (Frobenius' theorem), which its start fixes.
    Integrable,
    /// Velocities, and no relation between positions follows.
    Nonholonomic,
}

/// A system with `M` constraints on its `N` coordinates. Emitted where a system has `constraint` statements; their order
/// is that of every vector of constraints.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a system with {M} constraints",
    note = "constraints are `constraint name: f == 0;` inside `lagrangian! {{ … }}`"
)]
pub trait Constrained<const N: usize, const M: usize>: Lagrangian<N> {
    /// `f(q, t)` of the constraints on positions; 0 for those on velocities.
    fn constraints(&self, q: &SVector<Self::Scalar, N>, t: Self::Scalar) -> SVector<Self::Scalar, M>;

    /// `A q̇ + b`, which vanishes: `df/dt` of constraints on positions, and those on velocities themselves.
    fn constraint_rates(
        &self,
        q: &SVector<Self::Scalar, N>,
        qd: &SVector<Self::Scalar, N>,
        t: Self::Scalar,
    ) -> SVector<Self::Scalar, M>;

    /// `A`, `M × N`: `∂f/∂q`, or the coefficients of the velocities.
    fn constraint_jacobian(
        &self,
        q: &SVector<Self::Scalar, N>,
        t: Self::Scalar,
    ) -> SMatrix<Self::Scalar, M, N>;

    /// Multipliers `λ(q, q̇, t)`: the generalized force of the constraints is `Aᵀ λ`.
    fn multipliers(
        &self,
        q: &SVector<Self::Scalar, N>,
        qd: &SVector<Self::Scalar, N>,
        t: Self::Scalar,
    ) -> SVector<Self::Scalar, M>;

    /// The response to an impulse P: `(x, Λ)` with `M x = P + Aᵀ Λ` and `A x = rates`. With no rates, x is the jump of the
    /// velocities and Λ the impulses of the constraints; with no impulse, x is the smallest change, measured by the inertia
    /// matrix, that changes the constraints by `rates`.
    fn response(
        &self,
        q: &SVector<Self::Scalar, N>,
        qd: &SVector<Self::Scalar, N>,
        t: Self::Scalar,
        impulse: &SVector<Self::Scalar, N>,
        rates: &SVector<Self::Scalar, M>,
    ) -> (SVector<Self::Scalar, N>, SVector<Self::Scalar, M>);

    /// Generalized forces `Aᵀ λ` of all constraints, by coordinates.
    fn constraint_forces(
        &self,
        q: &SVector<Self::Scalar, N>,
        qd: &SVector<Self::Scalar, N>,
        t: Self::Scalar,
    ) -> SVector<Self::Scalar, N> {
        transposed(&self.constraint_jacobian(q, t), &self.multipliers(q, qd, t))
    }
}

/// A system with `P` prescribed coordinates. Emitted where a system has `coord name = f(t);`.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a system with {P} prescribed coordinates",
    note = "a prescribed coordinate is `coord name = f(t);` inside `lagrangian! {{ … }}`"
)]
pub trait Prescribed<const N: usize, const P: usize>: Lagrangian<N> {
    /// The generalized forces that make the prescribed coordinates move as they do, in the order of
    /// [`Facts::prescribed`](crate::system::Facts::prescribed): what is left over in the equation of motion of the
    /// coordinate φ when it is let go, `R = d/dt ∂L/∂φ̇ − ∂L/∂φ + ∂D/∂φ̇ − Q` (Beatty 2006, 11.7.2). Its power is R φ̇.
    fn reactions(
        &self,
        q: &SVector<Self::Scalar, N>,
        qd: &SVector<Self::Scalar, N>,
        t: Self::Scalar,
    ) -> SVector<Self::Scalar, P>;
}

/// `Aᵀ λ`
pub(crate) fn transposed<S: Scalar, const M: usize, const N: usize>(
    a: &SMatrix<S, M, N>,
    multipliers: &SVector<S, M>,
) -> SVector<S, N> {
    SVector::from_fn(|i, _| (0..M).fold(S::zero(), |sum, j| sum + a[(j, i)] * multipliers[j]))
}

/// A state on the constraints, and how far from them the given one was.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Restored<S, const N: usize> {
    /// On the constraints, to rounding.
    pub state: State<S, N>,
    /// Name of the constraint that was violated most.
    pub constraint: &'static str,
    /// By how much, as a relative change of q or q̇: `|f| / (Σ |Aᵢ| (1 + |qᵢ|))`.
    pub violation: f64,
}

/// Iterations of the projection; three are usual.
const MOST_ITERATIONS: u32 = 50;

/// A violation, as in [`Restored::violation`], that is no rounding error.
const LEFT: f64 = 1e-10;

/// The state near `at` that satisfies the constraints of the system, positions and velocities: by Newton's method, each
/// correction the smallest one in the norm of the inertia matrix, `δq = M⁻¹ Aᵀ (A M⁻¹ Aᵀ)⁻¹ (−f)` (Hairer, Lubich and Wanner,
/// *Geometric Numerical Integration*, 2006, IV.4; for velocities that is the effect of impulses of the constraints).
/// [`Failure::ConstraintViolated`] where there is none.
pub fn restore<Sys: Constrained<N, M>, const N: usize, const M: usize>(
    system: &Sys,
    at: &State<Sys::Scalar, N>,
) -> Result<Restored<Sys::Scalar, N>, Failure<Sys::Scalar>>
where
    Sys::Scalar: Real,
{
    let (t, mut state) = (at.t, *at);
    let none = SVector::from_fn(|_, _| Sys::Scalar::zero());
    let name = |j: usize| Sys::FACTS.constraints.get(j).map_or("", |constraint| constraint.name);
    let mut first: Option<(usize, f64)> = None;
    let mut approach = |state: &mut State<Sys::Scalar, N>, on_velocities: bool| {
        let mut best: Option<(State<Sys::Scalar, N>, f64)> = None;
        for _ in 0..MOST_ITERATIONS {
            let a = system.constraint_jacobian(&state.q, t);
            let (rest, x) = match on_velocities {
                false => (system.constraints(&state.q, t), &state.q),
                true => (system.constraint_rates(&state.q, &state.qd, t), &state.qd),
            };
            let (mut worst, mut violation, mut rounded) = (0, 0.0, true);
            for j in 0..M {
                let (mut units, mut terms) = (0.0, 0.0);
                for i in 0..N {
                    units += a[(j, i)].to_f64().abs() * (1.0 + x[i].to_f64().abs());
                    terms += (a[(j, i)] * x[i]).to_f64().abs();
                }
                let size = rest[j].magnitude();
                let relative = if size == 0.0 { 0.0 } else { size / units };
                // Not a number is worse than any number.
                if relative > violation || relative.is_nan() {
                    (worst, violation) = (j, relative);
                }
                // An overflow is no rounding, although infinity is not larger than itself.
                rounded &= size <= 2.0 * Sys::Scalar::EPSILON * terms && size.is_finite();
            }
            if first.is_none_or(|(_, before)| violation > before && best.is_none()) {
                first = Some((worst, violation));
            }
            if rounded {
                return Ok(());
            }
            match best {
                // No nearer: that is rounding, or there is nothing to approach.
                Some((nearest, before)) if violation >= before || violation.is_nan() => {
                    *state = nearest;
                    let failure =
                        Failure::ConstraintViolated { t, constraint: name(worst), violation: before };
                    return if before <= LEFT { Ok(()) } else { Err(failure) };
                }
                _ => best = Some((*state, violation)),
            }
            let change = system.response(&state.q, &state.qd, t, &none, &-rest).0;
            match on_velocities {
                false => state.q += change,
                true => state.qd += change,
            }
        }
        let (constraint, violation) = first.unwrap_or((0, f64::NAN));
        Err(Failure::ConstraintViolated { t, constraint: name(constraint), violation })
    };
    approach(&mut state, false)?;
    approach(&mut state, true)?;
    let (constraint, violation) = first.unwrap_or((0, 0.0));
    Ok(Restored { state, constraint: name(constraint), violation })
}

/// The state near `guess` with which a constrained system can start: its positions and velocities satisfy the
/// constraints, and differ from the guess by the smallest change in the norm of the inertia matrix.
///
/// ```
/// use lagrange_runtime::prelude::*;
///
/// lagrangian! {
///     /// A pendulum in Cartesian coordinates.
///     system Pendulum {
///         param m, l, g = 9.81;
///         coord x, y;
///         T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
///         V = m * g * y;
///         constraint rod: x.powi(2) + y.powi(2) == l.powi(2);
///         observe tension = -2 * l * reaction(rod);
///     }
/// }
/// let pendulum = Pendulum::new(1.0, 0.5);
/// let start = consistent(&pendulum, &State::new(0.0, [0.4, -0.4], [0.3, 0.0]))?;
/// assert!((start.q.norm() - 0.5).abs() < 1e-15, "on the circle");
/// assert!(start.q.dot(&start.qd).abs() < 1e-15, "along the circle");
/// let end = integrate(&pendulum, Dop853, Pi::tolerance(1e-9), start).until(10.0).finish()?;
/// assert!((end.q.norm() - 0.5).abs() < 1e-15, "still on the circle");
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
pub fn consistent<Sys: Constrained<N, M>, const N: usize, const M: usize>(
    system: &Sys,
    guess: &State<Sys::Scalar, N>,
) -> Result<State<Sys::Scalar, N>, Failure<Sys::Scalar>>
where
    Sys::Scalar: Real,
{
    restore(system, guess).map(|restored| restored.state)
}

#[cfg(test)]
mod tests;
