//! What can go wrong in a run, as values: where (t, h), what, and what to try next.

use crate::linear::{Singular, ldlt};
use crate::sample::Failed;
use crate::scalar::{Real, Scalar};
use crate::state::State;
use crate::system::Lagrangian;
use core::fmt;
use nalgebra::SVector;

/// Why a run or a step ended before its end. Its text is a sentence that ends in what to try next; `t` is where the
/// failed step began and `h` its size.
///
/// ```
/// use lagrange_runtime::Failure;
/// let failure = Failure::StepSizeUnderflow { t: 1.5, h: 1e-17 };
/// assert!(failure.to_string().starts_with("at t = 1.5 the step size fell to 1e-17"));
/// ```
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Failure<S = f64> {
    /// The controller asked for a step that no longer changes the time.
    StepSizeUnderflow {
        /// Time.
        t: S,
        /// Step size.
        h: S,
    },
    /// A coordinate, velocity or acceleration became infinite or not a number.
    NonFinite {
        /// Time.
        t: S,
        /// Step size; 0 where it is the start that is not finite.
        h: S,
    },
    /// The inertia matrix cannot be inverted.
    SingularInertia {
        /// Time.
        t: S,
        /// Index of the coordinate whose pivot vanished.
        coordinate: usize,
    },
    /// The fixed-point iteration of an implicit step did not converge.
    NotConverged {
        /// Time.
        t: S,
        /// Step size.
        h: S,
        /// Iterations made.
        iterations: u32,
    },
    /// The linear system of an implicit step cannot be solved.
    SingularStep {
        /// Time.
        t: S,
        /// Step size.
        h: S,
        /// Index of the coordinate whose pivot vanished.
        coordinate: usize,
    },
    /// A method for linear systems with constant coefficients and forces was given one whose forces depend on time, or
    /// whose equations are not linear.
    NotConstant {
        /// Time at which a constant was seen to change.
        t: S,
    },
    /// An invariant cannot be restored: its gradient vanishes, or the state is too far from where it has its value.
    InvariantLost {
        /// Time.
        t: S,
        /// Step size.
        h: S,
    },
    /// A state violates a constraint, and there is none near it that does not; or a run was given such a start.
    ConstraintViolated {
        /// Time.
        t: S,
        /// Index of the constraint.
        constraint: usize,
        /// By how much, as a relative change of a coordinate or velocity.
        violation: f64,
    },
    /// The run made as many attempts as it was allowed.
    BudgetUsedUp {
        /// Time.
        t: S,
        /// Size of the step that was not made.
        h: S,
        /// The allowed number of attempted steps.
        max_steps: u64,
    },
    /// A tolerance is negative or not a number, or both are zero.
    BadTolerance {
        /// Absolute tolerance.
        absolute: f64,
        /// Relative tolerance.
        relative: f64,
    },
    /// A given step size is zero, infinite or not a number.
    BadStepSize {
        /// Step size.
        h: S,
    },
    /// The given step leads away from the end.
    WrongDirection {
        /// Time of the start.
        t: S,
        /// Step size.
        h: S,
        /// Time of the end.
        end: S,
    },
    /// The end of the run is infinite or not a number, or a run that needs an end was given none.
    BadEnd {
        /// Time of the end, if one was given.
        end: Option<S>,
    },
    /// A sample time does not lie beyond the one before it, in the direction of the run.
    SampleOrder {
        /// The sample time.
        t: S,
        /// The sample time before it, or the start of the run.
        previous: S,
    },
    /// A sample time lies beyond the end of the run.
    SampleBeyondEnd {
        /// The sample time.
        t: S,
        /// Time of the end.
        end: S,
    },
    /// The function of an event is infinite or not a number.
    EventNotFinite {
        /// Time up to which it was finite.
        t: S,
        /// Index of the event.
        event: usize,
    },
    /// A terminal event happens on the interpolant of a step but not on the trajectory itself.
    EventNotBracketed {
        /// Time at which the step began.
        t: S,
        /// Step size.
        h: S,
        /// Index of the event.
        event: usize,
    },
}

impl<S: fmt::Debug> fmt::Display for Failure<S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Failure::StepSizeUnderflow { t, h } => write!(
                f,
                "at t = {t:?} the step size fell to {h:?}: the solution is singular or discontinuous there, or the \
                 tolerance is below rounding; try to end the run before it, or a larger tolerance"
            ),
            Failure::NonFinite { t, h } => write!(
                f,
                "the step of size {h:?} from t = {t:?} met a state or acceleration that is not finite; try a smaller \
                 step or an adaptive controller, and look for a singularity of the equations"
            ),
            Failure::SingularInertia { t, coordinate } => write!(
                f,
                "at t = {t:?} the inertia matrix is singular in coordinate {coordinate}; give that coordinate mass, \
                 or choose coordinates without a singularity there"
            ),
            Failure::NotConverged { t, h, iterations } => write!(
                f,
                "the implicit step of size {h:?} from t = {t:?} did not converge in {iterations} iterations; try a \
                 smaller step"
            ),
            Failure::SingularStep { t, h, coordinate } => write!(
                f,
                "the linear equations of the implicit step of size {h:?} from t = {t:?} are singular in coordinate \
                 {coordinate}; try a slightly shorter step"
            ),
            Failure::NotConstant { t } => write!(
                f,
                "the equations of motion are not linear with constant coefficients and constant forces: they differ \
                 at t = {t:?} from what they are at the start; try `Dop853`, or `Rodas5P` if they are stiff"
            ),
            Failure::InvariantLost { t, h } => write!(
                f,
                "the invariants could not be restored after the step of size {h:?} from t = {t:?}, which is too \
                 inaccurate or ends in a state where their gradients vanish; try a smaller step"
            ),
            Failure::ConstraintViolated { t, constraint, violation } => write!(
                f,
                "at t = {t:?} constraint {constraint} is violated by {violation:.1e} of the coordinates or velocities; \
                 start from a state of `consistent`, or from one nearer to the constraints if it finds none, and look for \
                 positions in which constraints depend on each other"
            ),
            Failure::BudgetUsedUp { t, h, max_steps } => write!(
                f,
                "the budget of {max_steps} attempted steps was used up at t = {t:?}, where the step size was {h:?}; \
                 raise `max_steps`, or use a method for stiff systems if the steps are far shorter than the motion"
            ),
            Failure::BadTolerance { absolute, relative } => write!(
                f,
                "tolerances must be finite, not negative and not both zero, but the absolute one is {absolute:?} and \
                 the relative one {relative:?}; try 1e-9 for both"
            ),
            Failure::BadStepSize { h } => {
                write!(
                    f,
                    "a step size must be finite and not zero, but it is {h:?}; give its size in units of t"
                )
            }
            Failure::WrongDirection { t, h, end } => write!(
                f,
                "steps of {h:?} from t = {t:?} lead away from the end at t = {end:?}; change the sign of the step"
            ),
            Failure::BadEnd { end: Some(end) } => {
                write!(f, "the end of a run must be finite, but it is {end:?}; give a time to `until`")
            }
            Failure::BadEnd { end: None } => write!(f, "this run has no end; give a time to `until`"),
            Failure::SampleOrder { t, previous } => write!(
                f,
                "the sample time {t:?} does not lie after {previous:?} in the direction of the run; sort the times"
            ),
            Failure::SampleBeyondEnd { t, end } => write!(
                f,
                "the sample time {t:?} lies beyond the end of the run at t = {end:?}; give a later time to `until`"
            ),
            Failure::EventNotFinite { t, event } => write!(
                f,
                "the function of event {event} is infinite or not a number at or soon after t = {t:?}; give one that \
                 is defined on both sides of its root"
            ),
            Failure::EventNotBracketed { t, h, event } => write!(
                f,
                "event {event} happens on the interpolant of the step of size {h:?} from t = {t:?}, but not on the \
                 trajectory, which misses it by less than the error of the step; try a smaller tolerance or step"
            ),
        }
    }
}

impl<S: fmt::Debug> core::error::Error for Failure<S> {}

/// The reason why a Lagrangian system has no finite accelerations at `at`: its inertia matrix is singular, or else
/// a state or force that is not finite, met by the step of size `h`.
pub fn why_not_finite<Sys: Lagrangian<N>, const N: usize>(
    system: &Sys,
    at: &State<Sys::Scalar, N>,
    h: Sys::Scalar,
) -> Failure<Sys::Scalar> {
    let inertia = system.inertia(&at.q, &at.qd, at.t);
    match ldlt(&inertia) {
        // A matrix that is not finite because the state is not says nothing about the coordinates.
        Err(Singular { pivot }) if at.is_finite() => Failure::SingularInertia { t: at.t, coordinate: pivot },
        _ => Failure::NonFinite { t: at.t, h },
    }
}

/// What is behind a failed run of a Lagrangian system: [`Failure::SingularInertia`] where the run ended at a state, or
/// at the brink of one, at which a coordinate has no inertia; otherwise the failure itself. Explicit methods, which see
/// accelerations only, report such an end as [`Failure::NonFinite`] or [`Failure::StepSizeUnderflow`].
///
/// The inertia of coordinate k, with all others left free, is `1/(M⁻¹)ₖₖ`. "At the brink" means that it is `1e-10` of the
/// largest one or less, for which units have to be sensible ones.
///
/// ```
/// use lagrange_runtime::prelude::*;
/// use lagrange_runtime::failure::diagnose;
///
/// lagrangian! {
///     /// A free particle in polar coordinates.
///     system Polar {
///         param m;
///         coord r, phi;
///         T = 0.5 * m * (dot(r).powi(2) + (r * dot(phi)).powi(2));
///         V = 0;
///     }
/// }
/// let polar = Polar::new(1.0);
/// let origin = State::new(0.0, [0.0, 0.0], [1.0, 0.5]);
/// let failed = integrate(&polar, Rk4, Fixed::new(0.1), origin).until(1.0).finish().unwrap_err();
/// assert!(matches!(failed.failure, Failure::NonFinite { .. }));
/// assert_eq!(diagnose(&polar, &failed), Failure::SingularInertia { t: 0.0, coordinate: 1 });
/// ```
pub fn diagnose<Sys: Lagrangian<N>, const N: usize>(
    system: &Sys,
    failed: &Failed<Sys::Scalar, N>,
) -> Failure<Sys::Scalar>
where
    Sys::Scalar: Real,
{
    let at = &failed.last;
    let by_accelerations =
        matches!(failed.failure, Failure::NonFinite { .. } | Failure::StepSizeUnderflow { .. });
    if !by_accelerations || !at.is_finite() {
        return failed.failure;
    }
    let Ok(inertia) = ldlt(&system.inertia(&at.q, &at.qd, at.t)) else {
        return why_not_finite(system, at, Sys::Scalar::zero());
    };
    let unit = |k: usize| SVector::from_fn(|i, _| Sys::Scalar::from_f64(if i == k { 1.0 } else { 0.0 }));
    let mobility = |k: usize| inertia.solve(&unit(k))[k].to_f64().abs();
    let (mut lightest, mut least) = (0, f64::INFINITY);
    for k in 0..N {
        if mobility(k) > mobility(lightest) {
            lightest = k;
        }
        least = least.min(mobility(k));
    }
    if N > 0 && least <= 1e-10 * mobility(lightest) {
        Failure::SingularInertia { t: at.t, coordinate: lightest }
    } else {
        failed.failure
    }
}

#[cfg(test)]
mod tests;
