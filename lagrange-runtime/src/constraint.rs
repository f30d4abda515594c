//! Systems whose coordinates are not independent: constraints, multipliers, reactions, and states that satisfy them.

use crate::diagnosis::is_finite;
use crate::failure::Failure;
use crate::iteration::{Iteration, Progress, chosen};
use crate::lanes::Work;
use crate::linear::{dot, ldlt};
use crate::scalar::{Comparison, Real, Scalar, SimdScalar};
use crate::state::{Begun, Restored, State, constant};
use crate::system::{Lagrangian, System, at_states};
use nalgebra::{SMatrix, SVector};

mod across;
mod branches;
mod dependence;
mod least_norm;
mod slopes;

pub(crate) use across::{CLOSE, NEARLY_DEPENDENT, struck};
pub use across::{accel_across, begun_across, motion, restored_across};
pub use branches::{Branches, branches, determined};
pub use dependence::{explained, independence, resolved};
pub use least_norm::least_norm;
pub use slopes::differentiable;

/// A system with `M` constraints on its `N` coordinates. Emitted where a system has `constraint` statements; their
/// order is that of every vector of constraints.
///
/// A constraint on positions is `f(q, t) = 0` (holonomic), one on velocities `g = Σ aᵢ(q, t) q̇ᵢ + b(q, t) = 0`. With
/// `A = ∂f/∂q` or a, the equations of motion are `M q̈ + b = f + Aᵀ λ` together with `d/dt (A q̇ + b) = 0`
/// (Lagrange's method of multipliers, and for velocities the Lagrange–d'Alembert principle; Neimark and
/// Fufaev, *Dynamics of Nonholonomic Systems*, 1972, ch. III). `accel` solves both for q̈, so that every method for
/// (q, q̇) integrates it. That determines the constraints only up to their second derivative: a projection after each
/// step, [`restore`], removes the drift.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a system with {M} constraints",
    note = "constraints are `constraint name: f == 0;` inside `lagrangian! {{ … }}`"
)]
pub trait Constrained<const N: usize, const M: usize>: Lagrangian<N> {
    /// The M values `f(q, t)` of the constraints on positions, each in its own unit and in the order of
    /// [`Facts::constraints`](crate::system::Facts::constraints); 0 for those on velocities.
    fn constraints(&self, q: &SVector<Self::Scalar, N>, t: Self::Scalar) -> SVector<Self::Scalar, M>;

    /// The M rates `A q̇ + b`, which vanish: `df/dt` of constraints on positions, in the unit of f per second, and
    /// those on velocities themselves, in their own unit, in the order of [`constraints`](Self::constraints).
    fn constraint_rates(
        &self,
        q: &SVector<Self::Scalar, N>,
        qd: &SVector<Self::Scalar, N>,
        t: Self::Scalar,
    ) -> SVector<Self::Scalar, M>;

    /// `A`, `M × N`, a row for each constraint: `∂f/∂q`, in the unit of f per unit of the coordinate, or the
    /// coefficients of the velocities.
    fn constraint_jacobian(
        &self,
        q: &SVector<Self::Scalar, N>,
        t: Self::Scalar,
    ) -> SMatrix<Self::Scalar, M, N>;

    /// The M multipliers `λ(q, q̇, t)`, in the order of the constraints: the generalized force of these is `Aᵀ λ`. A
    /// multiplier is in J per unit of `f`: that of an `f` in m is a force in N, of an `f` in rad a moment in N m, and
    /// of an `f` in m² it is in N/m. The multiplier of a constraint on velocities is in W per unit of it.
    fn multipliers(
        &self,
        q: &SVector<Self::Scalar, N>,
        qd: &SVector<Self::Scalar, N>,
        t: Self::Scalar,
    ) -> SVector<Self::Scalar, M>;

    /// The response to an impulse P: `(x, Λ)` with `M x = P + Aᵀ Λ` and `A x = rates`. With no rates, x is the jump
    /// of the N velocities and Λ the M impulses of the constraints; with no impulse, x is the smallest change, measured
    /// by the inertia matrix, that changes the constraints by `rates`. P is in N s of a length and N m s of an angle,
    /// `rates` in the units of [`constraint_rates`](Self::constraint_rates), and Λ in those of the multipliers times s.
    fn response(
        &self,
        q: &SVector<Self::Scalar, N>,
        qd: &SVector<Self::Scalar, N>,
        t: Self::Scalar,
        impulse: &SVector<Self::Scalar, N>,
        rates: &SVector<Self::Scalar, M>,
    ) -> (SVector<Self::Scalar, N>, SVector<Self::Scalar, M>);

    /// The N generalized forces `Aᵀ λ` of all constraints, by coordinates: in N of a length, in N m of an angle.
    fn constraint_forces(
        &self,
        q: &SVector<Self::Scalar, N>,
        qd: &SVector<Self::Scalar, N>,
        t: Self::Scalar,
    ) -> SVector<Self::Scalar, N> {
        transposed(&self.constraint_jacobian(q, t), &self.multipliers(q, qd, t))
    }

    /// [`constraints`](Self::constraints) at a state.
    #[inline]
    fn constraints_at(&self, at: &State<Self::Scalar, N>) -> SVector<Self::Scalar, M> {
        self.constraints(&at.q, at.t)
    }

    at_states! {
        constraint_rates_at: constraint_rates -> SVector<Self::Scalar, M>;
    }

    /// [`multipliers`](Self::multipliers) at a state. Near one at which the constraints are dependent they are those on
    /// the branch that it is on, to some eight digits, and not a number where they grow without bound, or where the
    /// force changes within less than the polynomials see.
    #[inline]
    fn multipliers_at(&self, at: &State<Self::Scalar, N>) -> SVector<Self::Scalar, M>
    where
        Self: Sized,
    {
        motion::<_, false, true, N, M, M>(self, at, |_, _, multipliers| *multipliers)
    }

    /// [`constraint_forces`](Self::constraint_forces) at a state, by [`multipliers_at`](Self::multipliers_at).
    #[inline]
    fn constraint_forces_at(&self, at: &State<Self::Scalar, N>) -> SVector<Self::Scalar, N>
    where
        Self: Sized,
    {
        transposed(&self.constraint_jacobian(&at.q, at.t), &self.multipliers_at(at))
    }
}

/// A system with `P` prescribed coordinates. Emitted where a system has `coord name = f(t);`.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a system with {P} prescribed coordinates",
    note = "a prescribed coordinate is `coord name = f(t);` inside `lagrangian! {{ … }}`"
)]
pub trait Prescribed<const N: usize, const P: usize>: Lagrangian<N> {
    /// The P generalized forces that make the prescribed coordinates move as they do, in the order of
    /// [`Facts::prescribed`](crate::system::Facts::prescribed): what is left over in the equation of motion of the
    /// coordinate φ when it is let go, `R = d/dt ∂L/∂φ̇ − ∂L/∂φ + ∂D/∂φ̇ − Q` (Beatty 2006, 11.7.2). It is in N where φ
    /// is a length and in N m where it is an angle, and its power is R φ̇.
    fn reactions(
        &self,
        q: &SVector<Self::Scalar, N>,
        qd: &SVector<Self::Scalar, N>,
        t: Self::Scalar,
    ) -> SVector<Self::Scalar, P>;

    at_states! {
        reactions_at: reactions -> SVector<Self::Scalar, P>;
    }
}

/// `Aᵀ λ`
pub(crate) fn transposed<S: Scalar, const M: usize, const N: usize>(
    a: &SMatrix<S, M, N>,
    multipliers: &SVector<S, M>,
) -> SVector<S, N> {
    SVector::from_fn(|i, _| (0..M).fold(S::zero(), |sum, j| sum + a[(j, i)] * multipliers[j]))
}

/// Iterations of the projection; three are usual.
const MOST_ITERATIONS: u32 = 50;

/// A violation, as in [`Restored::violation`], that is no rounding error.
const LEFT: f64 = 1e-10;

/// A violation below roundings of `1 + |q|`, and the ratio to the one before from which it is not worth another
/// correction: conditions that follow from others share what is left between them, and it falls by a part each time.
const ROUNDED: f64 = 1e-18;
const SLOW: f64 = 0.01;

/// The state near `at` that satisfies the constraints of the system, positions and velocities: by Newton's method,
/// each correction the smallest one in the norm of the inertia matrix, `δq = M⁻¹ Aᵀ (A M⁻¹ Aᵀ)⁻¹ (−f)` (Hairer,
/// Lubich and Wanner, *Geometric Numerical Integration*, 2006, IV.4; for velocities that is the effect of impulses of
/// the constraints). [`Failure::ConstraintViolated`] where there is none.
///
/// Of lanes it fails where there is none in any of them, and gives what is not a number in those in which there is
/// none.
// Never inlined: LLVM 22.1, of rustc 1.95, vectorizes the time loop of `Verner9` wrongly with the projection in it. A
// coordinate of a parallelogram at the end of a step became 0, and does not without the SLP vectorizer
// (`-C no-vectorize-slp`). `.ci/run` has its test in release.
#[inline(never)]
pub fn restore<Sys: Constrained<N, M>, const N: usize, const M: usize>(
    system: &Sys,
    at: &State<Sys::Scalar, N>,
) -> Result<Restored<Sys::Scalar, N>, Failure<Sys::Scalar>>
where
    Sys::Scalar: SimdScalar,
{
    let blamed = |failure| blamed::<Sys, N, M>(system, at, failure);
    let positions = Sys::Scalar::evaluate(Approach::<_, false, N, M> { system, at: *at }).map_err(blamed)?;
    let velocities =
        Sys::Scalar::evaluate(Approach::<_, true, N, M> { system, at: positions.state }).map_err(blamed)?;
    // Not a number is worse than any number.
    let Restored { constraint, violation, .. } =
        if positions.violation >= velocities.violation || positions.violation.is_nan() {
            positions
        } else {
            velocities
        };
    Ok(Restored { state: velocities.state, constraint, violation })
}

/// The cause of a failed approach to the constraints: [`Failure::NonFinite`] if it was an inertia matrix that is not
/// finite, of a parameter, which measures no corrections.
#[cold]
#[inline(never)]
fn blamed<Sys: Constrained<N, M>, const N: usize, const M: usize>(
    system: &Sys,
    at: &State<Sys::Scalar, N>,
    failure: Failure<Sys::Scalar>,
) -> Failure<Sys::Scalar> {
    match is_finite(&system.inertia(&at.q, &at.qd, at.t)) {
        true => failure,
        false => Failure::NonFinite { t: at.t, h: Sys::Scalar::zero() },
    }
}

/// The approach to the constraints, by the positions or by the velocities.
struct Approach<'a, Sys: System<N>, const VELOCITIES: bool, const N: usize, const M: usize> {
    system: &'a Sys,
    at: State<Sys::Scalar, N>,
}

impl<Sys, const VELOCITIES: bool, const N: usize, const M: usize> Work for Approach<'_, Sys, VELOCITIES, N, M>
where
    Sys: Constrained<N, M>,
    Sys::Scalar: SimdScalar,
{
    /// The state, and what was violated most by the one that was given.
    type Output = Result<Restored<Sys::Scalar, N>, Failure<Sys::Scalar>>;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn run(self) -> Self::Output {
        let Approach { system, at: mut state } = self;
        let t = state.t;
        let name = |j: usize| Sys::FACTS.constraints.get(j).map_or("", |constraint| constraint.name);
        // The constraint that is violated most, and by how much: at first, and where it came nearest.
        let mut first = (0, 0.0);
        let mut least = Sys::Scalar::each(|_| (0, f64::INFINITY));
        let mut nearest = if VELOCITIES { state.qd } else { state.q };
        let mut iteration = Iteration::<Sys::Scalar>::new();
        let mut iterations = 0;
        while iteration.goes_on() {
            iterations += 1;
            let x = if VELOCITIES { state.qd } else { state.q };
            let a = system.constraint_jacobian(&state.q, t);
            let rest = if VELOCITIES {
                system.constraint_rates(&state.q, &state.qd, t)
            } else {
                system.constraints(&state.q, t)
            };
            let violations = violations(&a, &x, &rest).map(|sizes| sizes.map(SimdScalar::apart));
            let mut back = Sys::Scalar::each(|_| false);
            iteration.decide(|i| {
                let (mut worst, mut rounded) = ((0, 0.0), true);
                for (j, [relative, beyond]) in violations.iter().enumerate() {
                    let relative = relative.as_ref()[i].to_f64();
                    // Not a number is worse than any number.
                    if relative > worst.1 || relative.is_nan() {
                        worst = (j, relative);
                    }
                    rounded &= beyond.as_ref()[i].to_f64() == 0.0;
                }
                if iterations == 1 && (worst.1 > first.1 || worst.1.is_nan()) {
                    first = worst;
                }
                let least = &mut least.as_mut()[i];
                if rounded {
                    Progress::Done
                } else if iterations > 1 && (worst.1 >= least.1 || worst.1.is_nan()) {
                    // No nearer: that is rounding, or there is nothing to approach.
                    back.as_mut()[i] = true;
                    least.0 = worst.0;
                    if least.1 <= LEFT { Progress::Done } else { Progress::Failed }
                } else if iterations > 1 && worst.1 <= ROUNDED && worst.1 >= SLOW * least.1 {
                    Progress::Done
                } else {
                    *least = worst;
                    Progress::On
                }
            });
            let mut next = chosen(&back, &nearest, &x);
            nearest = chosen(iteration.on(), &x, &nearest);
            if iteration.goes_on() {
                let mut rates = rest;
                for j in 0..M {
                    rates[j] = -rest[j];
                }
                let change = system.response(&state.q, &state.qd, t, &constant(Scalar::zero()), &rates).0;
                next = chosen(iteration.on(), &(x + change), &next);
            }
            if iterations == MOST_ITERATIONS {
                iteration.give_up();
            }
            *(if VELOCITIES { &mut state.qd } else { &mut state.q }) = iteration.result(&next);
            if iteration.failed() {
                let (worst, violation) =
                    if iterations == MOST_ITERATIONS { first } else { least.as_ref()[0] };
                return Err(Failure::ConstraintViolated { t, constraint: name(worst), violation });
            }
        }
        Ok(Restored { state, constraint: name(first.0), violation: first.1 })
    }
}

/// Violation of each constraint, see [`Restored::violation`]: 0 where it is no more than rounding.
#[cfg_attr(not(debug_assertions), inline(always))]
fn violations<S: SimdScalar, const N: usize, const M: usize>(
    a: &SMatrix<S, M, N>,
    x: &SVector<S, N>,
    rest: &SVector<S, M>,
) -> [[S::Sizes; 2]; M] {
    let [zero, one] = [S::Sizes::zero(), S::Sizes::one()];
    let mut violations = [[zero; 2]; M];
    for j in 0..M {
        let (mut units, mut terms) = (zero, zero);
        for i in 0..N {
            units += a[(j, i)].magnitudes() * (one + x[i].magnitudes());
            terms += (a[(j, i)] * x[i]).magnitudes();
        }
        let size = rest[j].magnitudes();
        let rounding = S::Sizes::from_f64(2.0 * S::Element::EPSILON) * terms;
        // An overflow is no rounding, although infinity is not larger than itself.
        let beyond = S::Sizes::select(Comparison::LessEqual, size, rounding, size * zero, one);
        let relative = S::Sizes::select(Comparison::Equal, size, zero, zero, size / units);
        violations[j] = [relative, beyond];
    }
    violations
}

/// The state near `guess` with which a constrained system can start: its positions and velocities satisfy the
/// constraints, and differ from the guess by the smallest change in the norm of the inertia matrix, to first order in
/// that change. Near a position with dependent constraints it is on the branch that the velocity is along, if it is
/// along one.
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
/// let end = integrate(&pendulum, Dop853, PiController::tolerance(1e-9), start).until(10.0).final_state()?;
/// assert!((end.q.norm() - 0.5).abs() < 1e-15, "still on the circle");
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
///
/// # Errors
/// [`Failure::NonFinite`] of a guess, or an inertia matrix there, with a number that is not finite;
/// [`Failure::ConstraintViolated`] where no such state is found.
pub fn consistent<Sys: Constrained<N, M>, const N: usize, const M: usize>(
    system: &Sys,
    guess: &State<Sys::Scalar, N>,
) -> Result<State<Sys::Scalar, N>, Failure<Sys::Scalar>>
where
    Sys::Scalar: Real,
{
    if !(guess.is_finite() && guess.t.to_f64().is_finite()) {
        return Err(Failure::NonFinite { t: guess.t, h: Sys::Scalar::zero() });
    }
    if let Some(Begun { state: Some(state), .. }) = begun_across(system, guess) {
        return Ok(state);
    }
    let found = restore(system, guess).map(|restored| restored.state);
    let distance = |state: &State<Sys::Scalar, N>| {
        let parts =
            (0..N).map(|i| (state.q[i] - guess.q[i]).to_f64().abs() / (1.0 + guess.q[i].to_f64().abs()));
        parts.fold(0.0, f64::max)
    };
    match &found {
        Ok(state) if distance(state) <= NEAR => found,
        _ => match restore(system, &approached(system, guess)) {
            Ok(Restored { state, .. })
                if found.as_ref().map_or(true, |far| distance(&state) < distance(far)) =>
            {
                Ok(state)
            }
            _ => found,
        },
    }
}

/// Distance, relative to `1 + |q|`, beyond which a consistent state is looked for by damped corrections: from beside a
/// position with dependent constraints Newton's method goes far away.
const NEAR: f64 = 0.5;

/// Damping of these corrections, relative to the largest square of a gradient, and their number.
const DAMPING: f64 = 1e-3;
const MOST_DAMPED: u32 = 200;

/// A state nearer to the constraints on positions, by damped corrections, `δq = M⁻¹ Aᵀ (A M⁻¹ Aᵀ + μ)⁻¹ (−f)`
/// (Levenberg 1944; Marquardt 1963).
fn approached<Sys: Constrained<N, M>, const N: usize, const M: usize>(
    system: &Sys,
    guess: &State<Sys::Scalar, N>,
) -> State<Sys::Scalar, N>
where
    Sys::Scalar: Real,
{
    let mut state = *guess;
    for _ in 0..MOST_DAMPED {
        let inertia = system.inertia(&state.q, &state.qd, state.t);
        let gradients = system.constraint_jacobian(&state.q, state.t);
        let Some((responses, mut products)) = responses(&inertia, &gradients) else { break };
        let largest = (0..M).map(|j| products[(j, j)].to_f64()).fold(0.0, f64::max);
        (0..M).for_each(|j| products[(j, j)] += Sys::Scalar::from_f64(DAMPING * largest));
        let Ok(products) = ldlt(&products) else { break };
        let forces = products.solve(&-system.constraints(&state.q, state.t));
        state.q += (0..M).fold(constant(Scalar::zero()), |sum, j| sum + responses[j] * forces[j]);
    }
    state
}

/// `M⁻¹ aⱼ` and `aᵢ M⁻¹ aⱼ` of the gradients, if the inertia matrix is regular.
fn responses<S: Real, const N: usize, const M: usize>(
    inertia: &SMatrix<S, N, N>,
    gradients: &SMatrix<S, M, N>,
) -> Option<([SVector<S, N>; M], SMatrix<S, M, M>)> {
    let inertia = ldlt(inertia).ok()?;
    let row = |j: usize| SVector::<_, N>::from_fn(|i, _| gradients[(j, i)]);
    let responses: [_; M] = core::array::from_fn(|j| inertia.solve(&row(j)));
    let products = SMatrix::from_fn(|i, j| dot(&row(i), &responses[j]));
    Some((responses, products))
}
