//! What can go wrong in a run, as values: where (t, h), what, and what to try next.

use crate::constraint::Dependence;
use crate::linear::{Ldlt, Singular, factored, ldlt, lu_solve};
use crate::sample::Failed;
use crate::scalar::{Functions, Numbers, Real, Scalar};
use crate::state::State;
use crate::system::Lagrangian;
use core::fmt;
use nalgebra::{SMatrix, SVector};

/// A coordinate of a system, shown as its name where that is known and as its index otherwise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Coordinate {
    /// Its place in `q`.
    pub index: usize,
    /// Its name, empty where a system that is written by hand gives none.
    pub name: &'static str,
}

impl Coordinate {
    /// The coordinate of `Sys` at `index`.
    pub fn of<Sys: Lagrangian<N>, const N: usize>(index: usize) -> Self {
        Coordinate { index, name: Sys::FACTS.coordinates.get(index).copied().unwrap_or_default() }
    }
}

impl fmt::Display for Coordinate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.name.is_empty() { write!(f, "{}", self.index) } else { write!(f, "`{}`", self.name) }
    }
}

/// Why a step could not be made, without where. It is what a [`Failure::StepSizeUnderflow`] remembers of its last step.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub enum Cause {
    /// As [`Failure::NonFinite`].
    NonFinite,
    /// As [`Failure::SingularInertia`].
    SingularInertia(Coordinate),
    /// As [`Failure::NotConverged`], after this many iterations.
    NotConverged(u32),
    /// As [`Failure::SingularStep`].
    SingularStep(Coordinate),
    /// As [`Failure::InvariantLost`].
    InvariantLost,
    /// As [`Failure::ConstraintViolated`], of the constraint of this name.
    ConstraintViolated(&'static str),
    /// [`Failure::ConstraintDrift`] from the constraint of this name.
    ConstraintDrift(&'static str),
}

/// What such a step meets: the end of a sentence that begins with "a step …".
impl fmt::Display for Cause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Cause::NonFinite => f.write_str("meets a state or acceleration that is not finite"),
            Cause::SingularInertia(coordinate) => {
                write!(f, "meets an inertia matrix that is singular in coordinate {coordinate}")
            }
            Cause::NotConverged(iterations) => write!(f, "does not converge in {iterations} iterations"),
            Cause::SingularStep(coordinate) => {
                write!(f, "has linear equations that are singular in coordinate {coordinate}")
            }
            Cause::InvariantLost => f.write_str("leads to where the invariants cannot be restored"),
            Cause::ConstraintViolated(constraint) => {
                write!(f, "leads to where the constraint `{constraint}` cannot be satisfied")
            }
            Cause::ConstraintDrift(constraint) => {
                write!(
                    f,
                    "leaves the constraint `{constraint}` so far that the way back is longer than the tolerance"
                )
            }
        }
    }
}

/// Property of a system that a computation needs and that no type shows.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub enum Requirement {
    /// No [switches](crate::System::switches), where derivatives of a motion are carried along by steps that do not end there.
    Smooth,
}

/// The property and a way out: the end of a sentence that begins with "… needs".
impl fmt::Display for Requirement {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Requirement::Smooth => {
                "forces without choices (`if`, `abs`, …) where derivatives of a motion are wanted: steps of one size do not end where forces \
                 jump; try `Pi::tolerance(…)`, or `Taylor`"
            }
        })
    }
}

/// Why a run or a step ended before its end. Its text is a sentence that ends in what to try next; `t` is where the
/// failed step began and `h` its size.
///
/// ```
/// use lagrange_runtime::Failure;
/// let failure = Failure::StepSizeUnderflow { t: 1.5, h: 1e-17, cause: None };
/// assert!(failure.to_string().starts_with("at t = 1.5 the step size fell to 1e-17"));
/// ```
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub enum Failure<S = f64> {
    /// The controller asked for a step that no longer changes the time.
    StepSizeUnderflow {
        /// Time.
        t: S,
        /// Step size.
        h: S,
        /// Why the last step that was tried could not be made; `None` if its estimated error was too large.
        cause: Option<Cause>,
    },
    /// A coordinate, velocity or acceleration became infinite or not a number.
    NonFinite {
        /// Time.
        t: S,
        /// Step size; 0 where it is the start that is not finite.
        h: S,
    },
    /// An integrand of [`Run::integrals`](crate::integrate::Run::integrals) is not finite in a step, or changes so fast that no quadrature converges.
    Quadrature {
        /// Time at the start of the step.
        t: S,
        /// Step size.
        h: S,
    },
    /// The inertia matrix cannot be inverted.
    SingularInertia {
        /// Time.
        t: S,
        /// The coordinate whose pivot vanished.
        coordinate: Coordinate,
        /// The coordinate that it cannot be told from there, if it has inertia of its own: as precession and spin at the pole of Euler's angles.
        with: Option<Coordinate>,
    },
    /// Velocities are so large, and cancel so far, that rounding them changes the kinetic energy in the upper half of its digits: the
    /// coordinates are nearly singular. See [`resolved`](crate::system::resolved).
    Cancellation {
        /// Time.
        t: S,
        /// The coordinate whose velocity takes part the most.
        coordinate: Coordinate,
        /// By how much relative changes of the velocities are larger in the kinetic energy.
        condition: f64,
    },
    /// The iteration of an implicit step did not converge, or grew beyond all numbers.
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
        /// The coordinate whose pivot vanished.
        coordinate: Coordinate,
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
        /// Name of the constraint.
        constraint: &'static str,
        /// By how much, as a relative change of a coordinate or velocity.
        violation: f64,
    },
    /// A step ended so far from a constraint that the projection back onto it would move the state by more than the controller
    /// tolerates, see [`Controller::tolerates`](crate::Controller::tolerates).
    ConstraintDrift {
        /// Time.
        t: S,
        /// Step size.
        h: S,
        /// Name of the constraint that is violated most.
        constraint: &'static str,
    },
    /// Constraints have become dependent: to first order one of them follows from others, so that their forces, and velocities that
    /// satisfy them, are not determined.
    DependentConstraints {
        /// Time.
        t: S,
        /// The constraints that depend on each other, and how many are left that do not.
        dependence: Dependence,
    },
    /// The run made as many attempts as it was allowed.
    BudgetUsedUp {
        /// Time.
        t: S,
        /// Size of the step that was not made.
        h: S,
        /// The allowed number of attempted steps.
        max_steps: u64,
        /// Whether the method is implicit, so that it is not stability that makes its steps short.
        implicit: bool,
    },
    /// On both sides of a switch (`if`, `abs`, `signum`, `min`, `max`) the equations lead back to it.
    Sliding {
        /// Time.
        t: S,
    },
    /// A method needs derivatives of the accelerations, which are finite and have none: the argument of a root vanishes, as that of `v.norm()` does at
    /// rest.
    NoDerivative {
        /// Time.
        t: S,
        /// The coordinate whose acceleration has no derivative.
        coordinate: Coordinate,
    },
    /// A controller or method does not fit a computation in a way that no type shows.
    Unsuitable {
        /// Name of the controller or method.
        chosen: &'static str,
        /// The property that is missing.
        requirement: Requirement,
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
    /// A stepper was to go to a time that lies behind it.
    TimeGoesBack {
        /// Time of the stepper.
        t: S,
        /// The time that was asked for.
        end: S,
    },
    /// The period of a sampled controller is not positive, or not finite.
    BadPeriod {
        /// The period.
        period: S,
    },
    /// An input was set to what is infinite or not a number.
    InputNotFinite {
        /// Time.
        t: S,
        /// Name of the input.
        input: &'static str,
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
            Failure::StepSizeUnderflow { t, h, cause: None } => write!(
                f,
                "at t = {t:?} the step size fell to {h:?}, and the estimated error is still too large: the solution is \
                 singular or discontinuous there, or the tolerance is below rounding (where the absolute one is 0, a coordinate or \
                 velocity that is 0 has none), or so coarse that the run left the solution; try to end the run before it, a larger tolerance, or a smaller one if it is coarse"
            ),
            Failure::StepSizeUnderflow { t, h, cause: Some(cause) } => write!(
                f,
                "at t = {t:?} the step size fell to {h:?}, and a step still {cause}: the solution is singular or \
                 discontinuous there, or the tolerance so coarse that the run left the solution; try to end the run \
                 before it, or a smaller tolerance if it is coarse"
            ),
            Failure::NonFinite { t, h } => write!(
                f,
                "the step of size {h:?} from t = {t:?} met a state or acceleration that is not finite: it is too long, \
                 or the equations are singular there; try a smaller step or an adaptive controller"
            ),
            Failure::Quadrature { t, h } => write!(
                f,
                "an integrand is not finite within the step of size {h:?} from t = {t:?}, or changes too fast there to be integrated; try \
                 an end before the pole, or an integrand without noise"
            ),
            Failure::SingularInertia { t, coordinate, with: Some(with) } => write!(
                f,
                "at t = {t:?} the inertia matrix is singular: the coordinates {with} and {coordinate} move alike there, and cannot be told \
                 apart; give coordinates that are singular elsewhere, or start beside that position"
            ),
            Failure::SingularInertia { t, coordinate, with: None } => write!(
                f,
                "at t = {t:?} the inertia matrix is singular in coordinate {coordinate}; give that coordinate mass, \
                 or choose coordinates without a singularity there"
            ),
            Failure::Cancellation { t, coordinate, condition } => write!(
                f,
                "at t = {t:?} velocities cancel to one part in {condition:.0e} of what coordinate {coordinate} adds to the kinetic energy, and \
                 rounding them would change the motion: the coordinates are nearly singular there; give coordinates that are \
                 singular elsewhere, or end the run before it"
            ),
            Failure::NotConverged { t, h, iterations } => write!(
                f,
                "the implicit step of size {h:?} from t = {t:?} did not converge in {iterations} iterations; try a \
                 smaller step, or `VariationalMidpoint`, `Rodas5P` or `Radau5` if fast motion is what makes it too long"
            ),
            Failure::SingularStep { t, h, coordinate } => write!(
                f,
                "the linear equations of the implicit step of size {h:?} from t = {t:?} are singular in coordinate \
                 {coordinate}; try a slightly shorter step"
            ),
            Failure::InvariantLost { t, h } => write!(
                f,
                "the invariants could not be restored after the step of size {h:?} from t = {t:?}, which is too \
                 inaccurate or ends in a state where their gradients vanish; try a smaller step"
            ),
            Failure::ConstraintViolated { t, constraint, violation } => write!(
                f,
                "at t = {t:?} the constraint `{constraint}` is violated by {violation:.1e} of the coordinates or velocities; \
                 start from a state of `consistent`, or from one nearer to the constraints if it finds none, and look for \
                 positions in which constraints depend on each other"
            ),
            Failure::ConstraintDrift { t, h, constraint } => write!(
                f,
                "the step of size {h:?} from t = {t:?} left the constraint `{constraint}` so far that the projection back onto it would move \
                 the state by more than a tenth of what the step did: the step is too long, or constraints depend on each other near there; try a \
                 smaller step, or an adaptive controller, which finds out which"
            ),
            Failure::DependentConstraints { t, dependence } => write!(
                f,
                "at t = {t:?} {dependence}, and the motion beyond is not determined by them to the tolerance; try coordinates that need fewer constraints, or \
                 end the run before such positions"
            ),
            Failure::BudgetUsedUp { t, h, max_steps, implicit } => {
                let otherwise = if *implicit {
                    "or a tolerance or step as large as the motion admits: the method is implicit, so it is not \
                     stability that makes its steps short"
                } else {
                    "or, if the steps are far shorter than the motion, use a method of higher order where the tolerance makes \
                     them so, and a method for stiff systems where stability does"
                };
                write!(
                    f,
                    "the budget of {max_steps} attempted steps was used up at t = {t:?}, where the step size was \
                     {h:?}; raise `max_steps`, {otherwise}"
                )
            }
            Failure::Sliding { t } => write!(
                f,
                "at t = {t:?} the motion stays where a choice in the equations switches (`if`, `abs`, `signum`, `min`, `max`), since on both sides \
                 they lead back to there, as dry friction does that holds; end the run there and go on with a system that is held, \
                 or smooth the choice, for instance by `tanh`"
            ),
            Failure::NoDerivative { t, coordinate } => write!(
                f,
                "at t = {t:?} the acceleration of coordinate {coordinate} is finite but has no derivative, which the method needs: the argument of a \
                 root in its equation (`sqrt`, `norm`, `hypot`, `cbrt`, `powf`) vanishes there; try `Dop853` or `Verner9`, which need none"
            ),
            Failure::Unsuitable { chosen, requirement } => write!(f, "`{chosen}` needs {requirement}"),
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
            Failure::TimeGoesBack { t, end } => write!(
                f,
                "a stepper at t = {t:?} cannot advance to t = {end:?}, which lies behind it; set an earlier state by `set_state`"
            ),
            Failure::BadPeriod { period } => {
                write!(f, "the period of a controller must be positive and finite, but it is {period:?}")
            }
            Failure::InputNotFinite { t, input } => write!(
                f,
                "at t = {t:?} the input `{input}` was set to a number that is not finite; look for a division by zero in its controller"
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

impl<S> Failure<S> {
    /// The same with times and steps of another type.
    pub fn map<R>(self, f: impl Fn(S) -> R) -> Failure<R> {
        match self {
            Failure::StepSizeUnderflow { t, h, cause } => {
                Failure::StepSizeUnderflow { t: f(t), h: f(h), cause }
            }
            Failure::NonFinite { t, h } => Failure::NonFinite { t: f(t), h: f(h) },
            Failure::Quadrature { t, h } => Failure::Quadrature { t: f(t), h: f(h) },
            Failure::SingularInertia { t, coordinate, with } => {
                Failure::SingularInertia { t: f(t), coordinate, with }
            }
            Failure::Cancellation { t, coordinate, condition } => {
                Failure::Cancellation { t: f(t), coordinate, condition }
            }
            Failure::NotConverged { t, h, iterations } => {
                Failure::NotConverged { t: f(t), h: f(h), iterations }
            }
            Failure::SingularStep { t, h, coordinate } => {
                Failure::SingularStep { t: f(t), h: f(h), coordinate }
            }
            Failure::InvariantLost { t, h } => Failure::InvariantLost { t: f(t), h: f(h) },
            Failure::ConstraintViolated { t, constraint, violation } => {
                Failure::ConstraintViolated { t: f(t), constraint, violation }
            }
            Failure::ConstraintDrift { t, h, constraint } => {
                Failure::ConstraintDrift { t: f(t), h: f(h), constraint }
            }
            Failure::DependentConstraints { t, dependence } => {
                Failure::DependentConstraints { t: f(t), dependence }
            }
            Failure::BudgetUsedUp { t, h, max_steps, implicit } => {
                Failure::BudgetUsedUp { t: f(t), h: f(h), max_steps, implicit }
            }
            Failure::Sliding { t } => Failure::Sliding { t: f(t) },
            Failure::NoDerivative { t, coordinate } => Failure::NoDerivative { t: f(t), coordinate },
            Failure::Unsuitable { chosen, requirement } => Failure::Unsuitable { chosen, requirement },
            Failure::BadTolerance { absolute, relative } => Failure::BadTolerance { absolute, relative },
            Failure::BadStepSize { h } => Failure::BadStepSize { h: f(h) },
            Failure::WrongDirection { t, h, end } => {
                Failure::WrongDirection { t: f(t), h: f(h), end: f(end) }
            }
            Failure::TimeGoesBack { t, end } => Failure::TimeGoesBack { t: f(t), end: f(end) },
            Failure::BadPeriod { period } => Failure::BadPeriod { period: f(period) },
            Failure::InputNotFinite { t, input } => Failure::InputNotFinite { t: f(t), input },
            Failure::BadEnd { end } => Failure::BadEnd { end: end.map(f) },
            Failure::SampleOrder { t, previous } => Failure::SampleOrder { t: f(t), previous: f(previous) },
            Failure::SampleBeyondEnd { t, end } => Failure::SampleBeyondEnd { t: f(t), end: f(end) },
            Failure::EventNotFinite { t, event } => Failure::EventNotFinite { t: f(t), event },
            Failure::EventNotBracketed { t, h, event } => {
                Failure::EventNotBracketed { t: f(t), h: f(h), event }
            }
        }
    }

    /// Why a step could not be made, of those failures that a shorter step may mend.
    pub fn cause(&self) -> Option<Cause> {
        Some(match self {
            Failure::StepSizeUnderflow { cause, .. } => return *cause,
            Failure::NonFinite { .. } => Cause::NonFinite,
            Failure::SingularInertia { coordinate, .. } => Cause::SingularInertia(*coordinate),
            Failure::NotConverged { iterations, .. } => Cause::NotConverged(*iterations),
            Failure::SingularStep { coordinate, .. } => Cause::SingularStep(*coordinate),
            Failure::InvariantLost { .. } => Cause::InvariantLost,
            Failure::ConstraintViolated { constraint, .. } => Cause::ConstraintViolated(constraint),
            Failure::ConstraintDrift { constraint, .. } => Cause::ConstraintDrift(constraint),
            _ => return None,
        })
    }
}

/// The reason why a Lagrangian system has no finite accelerations at `at`: its inertia matrix is singular, or else
/// a state or force that is not finite, met by the step of size `h`.
pub fn why_not_finite<Sys: Lagrangian<N>, const N: usize>(
    system: &Sys,
    at: &State<Sys::Scalar, N>,
    h: Sys::Scalar,
) -> Failure<Sys::Scalar>
where
    Sys::Scalar: Numbers,
{
    let inertia = system.inertia(&at.q, &at.qd, at.t);
    match factored(&inertia).singular() {
        // A matrix that is not finite, for the state is not or is so large, says nothing about the coordinates.
        Some(Singular { pivot }) if at.is_finite() && is_finite(&inertia) => {
            singular::<Sys, N>(at.t, pivot, &inertia)
        }
        _ => Failure::NonFinite { t: at.t, h },
    }
}

/// [`Failure::SingularInertia`] of coordinate k.
fn singular<Sys: Lagrangian<N>, const N: usize>(
    t: Sys::Scalar,
    k: usize,
    inertia: &SMatrix<Sys::Scalar, N, N>,
) -> Failure<Sys::Scalar>
where
    Sys::Scalar: Numbers,
{
    // The column of the inverse is along the motion without inertia, once the matrix is made regular.
    let raised = Sys::Scalar::from_f64(1.0 + 1e-8);
    let regular =
        SMatrix::<_, N, N>::from_fn(|i, j| if i == j { inertia[(i, j)] * raised } else { inertia[(i, j)] });
    let unit = SVector::<_, N>::from_fn(|i, _| if i == k { Sys::Scalar::one() } else { Sys::Scalar::zero() });
    let motion = factored(&regular).solve(&unit);
    let part = |i: usize| (motion[i] * motion[i] * inertia[(i, i)]).number(0).to_f64();
    let with =
        (0..N).filter(|&i| i != k && part(i) > 0.01 * part(k)).max_by(|&i, &j| part(i).total_cmp(&part(j)));
    let of = Coordinate::of::<Sys, N>;
    Failure::SingularInertia { t, coordinate: of(k), with: with.map(of) }
}

fn is_finite<S: Scalar, const N: usize>(matrix: &SMatrix<S, N, N>) -> bool {
    matrix.iter().all(|&x| x * S::zero() == S::zero())
}

/// The cause of a failed run of a Lagrangian system: [`Failure::SingularInertia`] where the run ended at a state, or
/// at the brink of one, at which a coordinate has no inertia; otherwise the failure itself. Explicit methods, which see
/// accelerations only, report such an end as [`Failure::NonFinite`] or [`Failure::StepSizeUnderflow`]. Runs of systems made by
/// `lagrangian!` call this themselves; it is of use for systems that are written by hand.
///
/// The inertia of coordinate k, with all others left free, is `1/(M⁻¹)ₖₖ`. "At the brink" means that it has fallen to
/// `1e-10` of what it was at the start of the run, or less; for a run that failed at its start, of what it is beside it. That compares each
/// coordinate with itself, so units do not matter, nor does it matter if another coordinate has run away.
///
/// ```
/// use lagrange_runtime::prelude::*;
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
/// assert!(matches!(failed.failure, Failure::SingularInertia { coordinate, .. } if coordinate.name == "phi"));
/// ```
pub fn diagnose<Sys: Lagrangian<N>, const N: usize>(
    system: &Sys,
    failed: &Failed<Sys::Scalar, N>,
) -> Failure<Sys::Scalar>
where
    Sys::Scalar: Real,
{
    explained(system, &failed.start, &failed.last, failed.failure)
}

/// [`diagnose`] for a run from `start` that ended at `last`. Emitted as [`System::explained`](crate::System::explained).
#[doc(hidden)]
#[cold]
#[inline(never)]
pub fn explained<Sys: Lagrangian<N>, const N: usize>(
    system: &Sys,
    start: &State<Sys::Scalar, N>,
    last: &State<Sys::Scalar, N>,
    failure: Failure<Sys::Scalar>,
) -> Failure<Sys::Scalar>
where
    Sys::Scalar: Real,
{
    let at_start = last.t == start.t;
    let unexplained = match failure {
        Failure::NonFinite { .. } | Failure::StepSizeUnderflow { .. } => true,
        // Implicit methods report a start without accelerations so.
        Failure::NotConverged { .. } | Failure::SingularStep { .. } => at_start,
        _ => false,
    };
    if !unexplained || !last.is_finite() || size_of::<SMatrix<Sys::Scalar, N, N>>() > MAX_MATRIX_BYTES {
        return failure;
    }
    if let cause @ Failure::SingularInertia { .. } = why_not_finite(system, last, Sys::Scalar::zero()) {
        return cause;
    }
    let compared = if at_start { beside(last, 1.0) } else { *start };
    vanished(system, last, &compared, BRINK).unwrap_or(failure)
}

/// The part of the inertia of a coordinate, or of the square of a constraint's gradient, at which it counts as vanished.
pub(crate) const BRINK: f64 = 1e-10;

/// The largest matrix for which the cause of a failure is looked for: several have to fit the stack of a thread.
pub(crate) const MAX_MATRIX_BYTES: usize = 1 << 16;

/// A state beside `at` that has no reason to be singular, too: every coordinate is moved by about a thousandth of its size, and of `unit`, and
/// every velocity.
pub(crate) fn beside<S: Scalar, const N: usize>(at: &State<S, N>, unit: f64) -> State<S, N> {
    // The parts differ, so that no difference of coordinates stays as it is.
    let part = |i: usize| {
        let turns = 0.618 * i as f64;
        S::from_f64(1e-3 + 1e-3 * (turns - (turns as usize) as f64))
    };
    let moved = |x: S, i: usize| x + part(i) * (S::from_f64(unit) + x.abs());
    State {
        q: SVector::from_fn(|i, _| moved(at.q[i], i)),
        qd: SVector::from_fn(|i, _| moved(at.qd[i], i)),
        ..*at
    }
}

/// Fails if `at` is within rounding of a state at which a coordinate has no inertia, such as θ = π of Euler's angles, whose sine is not 0 in
/// floating-point numbers: accelerations are finite there, and mean nothing.
///
/// # Errors
/// [`Failure::SingularInertia`].
pub(crate) fn regular<Sys: Lagrangian<N>, const N: usize>(
    system: &Sys,
    at: &State<Sys::Scalar, N>,
) -> Result<(), Failure<Sys::Scalar>>
where
    Sys::Scalar: Real,
{
    if size_of::<SMatrix<Sys::Scalar, N, N>>() > MAX_MATRIX_BYTES {
        return Ok(());
    }
    match vanished(system, at, &beside(at, 0.0), Sys::Scalar::EPSILON) {
        Some(failure) => Err(failure),
        None => Ok(()),
    }
}

/// [`Failure::SingularInertia`] of the coordinate whose inertia at `at` is the least part of that at `compared`, if it is no more than `brink`.
fn vanished<Sys: Lagrangian<N>, const N: usize>(
    system: &Sys,
    at: &State<Sys::Scalar, N>,
    compared: &State<Sys::Scalar, N>,
    brink: f64,
) -> Option<Failure<Sys::Scalar>>
where
    Sys::Scalar: Real,
{
    let inertia = |at: &State<Sys::Scalar, N>| system.inertia(&at.q, &at.qd, at.t);
    let matrix = inertia(at);
    let here = match ldlt(&matrix) {
        Ok(here) => here,
        // An indefinite matrix may have no such factors and be regular: it is scaled to a unit diagonal, and factored with pivots.
        Err(Singular { pivot }) => {
            let scale = SVector::<_, N>::from_fn(|i, _| Sys::Scalar::one() / matrix[(i, i)].sqrt());
            let scaled = SMatrix::<_, N, N>::from_fn(|i, j| scale[i] * matrix[(i, j)] * scale[j]);
            let rank_is_lost = is_finite(&scaled) && lu_solve(&scaled, &scale).is_err();
            return rank_is_lost.then(|| singular::<Sys, N>(at.t, pivot, &matrix));
        }
    };
    let compared = ldlt(&inertia(compared)).ok()?;
    let left = |k: usize| mobility(&compared, k) / mobility(&here, k);
    let k = (0..N).min_by(|&a, &b| left(a).total_cmp(&left(b)))?;
    (left(k) <= brink).then(|| singular::<Sys, N>(at.t, k, &matrix))
}

/// `(M⁻¹)ₖₖ`, as a size.
fn mobility<S: Real, const N: usize>(inertia: &Ldlt<S, N>, k: usize) -> f64 {
    let unit = SVector::from_fn(|i, _| if i == k { S::one() } else { S::zero() });
    inertia.solve(&unit)[k].to_f64().abs()
}

#[cfg(test)]
mod tests;
