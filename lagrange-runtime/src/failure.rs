//! Failures of a run, as values: where (t, h), what, and what to try next.

use core::fmt;

/// A coordinate of a system, shown as its name where that is known and as its index otherwise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Coordinate {
    /// Its place in `q`.
    pub index: usize,
    /// Its name, empty where a system that is written by hand gives none.
    pub name: &'static str,
}

impl fmt::Display for Coordinate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.name.is_empty() { write!(f, "{}", self.index) } else { write!(f, "`{}`", self.name) }
    }
}

/// An event that a failure speaks of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct EventName {
    /// Its place in the array or tuple given.
    pub index: usize,
    /// Its name, empty unless given.
    pub name: &'static str,
}

impl fmt::Display for EventName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.name.is_empty() { write!(f, "{}", self.index) } else { write!(f, "`{}`", self.name) }
    }
}

/// Cause of a failed step, without its place. It is what a [`Failure::StepSizeUnderflow`] remembers of its last step.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub enum Cause {
    /// [`Failure::NonFinite`].
    NonFinite,
    /// [`Failure::SingularInertia`].
    SingularInertia(Coordinate),
    /// [`Failure::NotConverged`], after this many iterations.
    NotConverged(u32),
    /// [`Failure::SingularStep`].
    SingularStep(Coordinate),
    /// [`Failure::InvariantLost`].
    InvariantLost,
    /// [`Failure::ConstraintViolated`], of the constraint of this name.
    ConstraintViolated(&'static str),
    /// [`Failure::ConstraintDrift`] from the constraint of this name.
    ConstraintDrift(&'static str),
}

/// Predicate of a sentence that begins with "a step …".
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

/// The part of a given state that is infinite or not a number.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub enum Part {
    /// Its time.
    Time,
    /// A coordinate.
    Coordinate(Coordinate),
    /// The velocity of a coordinate, or a state of first order.
    Velocity(Coordinate),
    /// The equation of a coordinate at the state, which is finite itself.
    Equation(Coordinate),
}

/// Property of a system that a computation needs and that no type shows.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub enum Requirement {
    /// No [switches](crate::System::switches), where derivatives of a motion are carried along by steps that do not
    /// end there.
    Smooth,
    /// A slope without jumps, of a function with data on whose slope a momentum depends.
    ContinuousSlope,
    /// Steps of positive size, where a sampled controller ([`Stepper::every`](crate::Stepper::every)) acts on the way.
    Forward,
}

/// The property and a way out: the end of a sentence that begins with "… needs".
impl fmt::Display for Requirement {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Requirement::ContinuousSlope => {
                "a continuous slope, since a momentum depends on it: where the slope jumps, as at the knots of chords or at \
                 an end that is `Held`, an impulse acts, which the equations of motion do not have; try `Curve::cubic` or \
                 `Curve::monotone`, with `Beyond::Line` or `Beyond::Refused`"
            }
            Requirement::Smooth => {
                "forces without choices (`if`, `abs`, …) where derivatives of a motion are wanted: steps of one size do not end where forces \
                 jump; try `PiController::tolerance(…)`, or `Taylor`"
            }
            Requirement::Forward => {
                "steps that go forward in time, since what a sampled controller did in the past is not known; change the sign of the step"
            }
        })
    }
}

/// Reason why a run or a step ended before its end. Its text is a sentence that ends in what to try next; `t` is where
/// the failed step began and `h` its size.
///
/// ```
/// use lagrange_runtime::Failure;
/// let failure = Failure::StepSizeUnderflow { t: 1.5, h: 1e-17, cause: None };
/// assert!(failure.to_string().starts_with("at t = 1.5 the step size fell to 1e-17"));
/// ```
#[non_exhaustive]
#[derive(Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub enum Failure<S = f64> {
    /// The step size of the controller is so small that a step does not change the time.
    StepSizeUnderflow {
        /// Time.
        t: S,
        /// Step size.
        h: S,
        /// Cause of the failure of the last step that was tried; `None` if its estimated error was too large.
        cause: Option<Cause>,
    },
    /// A coordinate, velocity or acceleration became infinite or not a number.
    NonFinite {
        /// Time.
        t: S,
        /// Step size; 0 where accelerations are not finite at the state itself.
        h: S,
    },
    /// The state from which a run or a step sets out is infinite or not a number, or an equation of motion is there, as
    /// by a parameter that is not a number.
    StateNotFinite {
        /// Time.
        t: S,
        /// The part that is not finite.
        part: Part,
    },
    /// An integrand of [`Run::integrals`](crate::integrate::Run::integrals) is not finite in a step, or changes so
    /// fast that no quadrature converges.
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
        /// The coordinate that it cannot be told from there, if it has inertia of its own: as precession and spin at
        /// the pole of Euler's angles.
        with: Option<Coordinate>,
    },
    /// The inertia matrix is not positive definite at the start of a run, although that of positive masses is: a
    /// parameter that is a mass or a moment of inertia is negative. The motion would gain energy without bound.
    NegativeInertia {
        /// Time.
        t: S,
        /// The coordinate whose pivot is negative.
        coordinate: Coordinate,
    },
    /// Velocities are so large, and cancel so far, that rounding them changes the kinetic energy in the upper half of
    /// its digits: the coordinates are nearly singular. See [`resolved`](crate::diagnosis::resolved).
    Cancellation {
        /// Time.
        t: S,
        /// The coordinate whose velocity takes part the most.
        coordinate: Coordinate,
        /// Factor by which relative changes of the velocities are larger in the kinetic energy.
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
        /// Violation, as a relative change of a coordinate or velocity.
        violation: f64,
    },
    /// A step ended so far from a constraint that the projection back onto it would move the state by more than the
    /// controller tolerates, see [`Controller::tolerates`](crate::Controller::tolerates).
    ConstraintDrift {
        /// Time.
        t: S,
        /// Step size.
        h: S,
        /// Name of the constraint that is violated most.
        constraint: &'static str,
    },
    /// Constraints have become dependent: to first order one of them follows from others, so that their forces, and
    /// velocities that satisfy them, are not determined.
    DependentConstraints {
        /// Time.
        t: S,
        /// The constraints that depend on each other, and how many are left that do not.
        dependence: Dependence,
    },
    /// The constraints admit two motions from a position in which they are dependent, and neither is preferred: the
    /// motion reaches it with no velocity, or with one along both or neither of its branches.
    /// [`branches`](crate::traits::branches) gives their directions.
    Bifurcation {
        /// Time.
        t: S,
        /// Two coordinates by which the branches differ.
        coordinates: [Coordinate; 2],
    },
    /// A coordinate left the range in which the model holds, see [`InRange`](crate::lanes::InRange).
    OutsideModel {
        /// Time.
        t: S,
        /// The coordinate.
        coordinate: Coordinate,
        /// The bound that it passed.
        bound: f64,
    },
    /// The run made as many attempts as it was allowed.
    BudgetUsedUp {
        /// Time.
        t: S,
        /// Size of the step that was not made.
        h: S,
        /// The allowed number of attempted steps.
        max_steps: u64,
        /// True if the method is implicit, so that it is not stability that makes its steps short.
        implicit: bool,
    },
    /// On both sides of a switch (`if`, `abs`, `signum`, `min`, `max`) the equations lead back to it.
    Sliding {
        /// Time.
        t: S,
    },
    /// The motion crossed a condition (`if`, `max`, `signum`, …) across which a momentum ∂L/∂q̇ jumps, or the potential
    /// energy: an impulse acts there, which the equations of motion do not have.
    UnknownImpulse {
        /// End of the step that crossed it.
        t: S,
    },
    /// A method needs derivatives of the accelerations, which are finite and have none: the argument of a root
    /// vanishes, as that of `v.norm()` does at rest.
    NoDerivative {
        /// Time.
        t: S,
        /// The coordinate whose acceleration has no derivative.
        coordinate: Coordinate,
    },
    /// A motion has no derivative by a parameter: it went through a position at which constraints are dependent, and
    /// the parameter moves one of them.
    NotDifferentiable {
        /// Time.
        t: S,
        /// Name of the constraint that the parameter moves.
        constraint: &'static str,
    },
    /// A controller or method does not fit a computation in a way that no type shows.
    Unsuitable {
        /// Name of the controller, method or function with data.
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
    /// The period of a sampled controller is not positive, not finite, or of less than 64 roundings of the time.
    BadPeriod {
        /// Time.
        t: S,
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
        /// The event.
        event: EventName,
    },
    /// A terminal event happens on the interpolant of a step but not on the trajectory itself.
    EventNotBracketed {
        /// Time at which the step began.
        t: S,
        /// Step size.
        h: S,
        /// The event.
        event: EventName,
    },
    /// Terminal events follow each other faster than time or their function resolves, as the bounces of a ball do that
    /// comes to rest (Zeno behaviour).
    EventsAccumulate {
        /// Time of the last event that can be told.
        t: S,
        /// The event.
        event: EventName,
    },
    /// A step is so long that the search for events would need more than 2²⁴ points in it.
    EventsUnresolved {
        /// Time at which the step began.
        t: S,
        /// Step size.
        h: S,
    },
}

/// A failure goes the way of each step, in the same place: with 96 bytes RK4 took 1.2 to 1.3 of its time.
const _: () = assert!(size_of::<Failure>() <= 64);

/// The name of the variant of an error.
macro_rules! variant {
    ($error:expr => $of:ident: $($variant:ident),* $(,)?) => {
        match $error {
            $($of::$variant { .. } => stringify!($variant),)*
        }
    };
}
#[cfg(feature = "analysis")]
pub(crate) use variant;

/// The debug form of an error is its text: Rust prints that form of an error that `main` returns.
macro_rules! debug_is_text {
    ([$($generics:tt)*] $error:ty) => {
        impl<$($generics)*> core::fmt::Debug for $error {
            fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                core::fmt::Display::fmt(self, f)
            }
        }
    };
}
pub(crate) use debug_is_text;

impl<S> Failure<S> {
    /// Its name, by which the guide's chapter on failures explains it: `"StepSizeUnderflow"`.
    pub fn name(&self) -> &'static str {
        variant! { self => Failure:
            StepSizeUnderflow, NonFinite, StateNotFinite, Quadrature, SingularInertia, NegativeInertia, Cancellation, NotConverged, SingularStep, InvariantLost, ConstraintViolated, ConstraintDrift, DependentConstraints, Bifurcation, OutsideModel, BudgetUsedUp, Sliding, UnknownImpulse, NoDerivative, NotDifferentiable, Unsuitable, BadTolerance, BadStepSize, WrongDirection, TimeGoesBack, BadPeriod, InputNotFinite, BadEnd, SampleOrder, SampleBeyondEnd, EventNotFinite, EventNotBracketed, EventsAccumulate, EventsUnresolved,
        }
    }
}

/// The name and the text, since that is how an error that `main` returns is printed.
impl<S: fmt::Debug> fmt::Debug for Failure<S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {self}", self.name())
    }
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
            Failure::StepSizeUnderflow { t, h, cause: Some(cause @ Cause::NonFinite) } => write!(
                f,
                "at t = {t:?} the step size fell to {h:?}, and a step still {cause}: the solution is singular there, a root or a logarithm \
                 leaves its domain, an argument leaves its table with `Beyond::Refused`, or the tolerance is so coarse that the run left the \
                 solution; try to end the run before it, or a smaller tolerance if it is coarse"
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
                 or the equations are singular there (of size 0: the state has no finite acceleration, as a parameter is not \
                 finite, or 0 where it divides); try a smaller step or an adaptive controller"
            ),
            Failure::StateNotFinite { part: Part::Time, .. } => {
                f.write_str("the time of a state is infinite or not a number; give a finite one")
            }
            Failure::StateNotFinite { t, part: Part::Coordinate(coordinate) } => write!(
                f,
                "at t = {t:?} coordinate {coordinate} of the state is infinite or not a number; give a finite one"
            ),
            Failure::StateNotFinite { t, part: Part::Velocity(coordinate) } => write!(
                f,
                "at t = {t:?} the velocity of coordinate {coordinate} (of a state of first order: its value) is infinite or not a number; \
                 give a finite one"
            ),
            Failure::StateNotFinite { t, part: Part::Equation(coordinate) } => write!(
                f,
                "at t = {t:?} the equation of coordinate {coordinate} is infinite or not a number, though the state is finite: a \
                 parameter is not finite, or 0 where it divides, or an argument is outside the domain of its function or table; \
                 give other parameters (the `{{:?}}` of the system shows them), or another state"
            ),
            Failure::Quadrature { t, h } => write!(
                f,
                "an integrand is not finite within the step of size {h:?} from t = {t:?}, or changes too fast there to be integrated; try \
                 an end before the pole, or an integrand without noise"
            ),
            // Of one attitude they have one name.
            Failure::SingularInertia { t, coordinate, with: Some(with) }
                if with.name == coordinate.name && !with.name.is_empty() =>
            {
                write!(
                    f,
                    "at t = {t:?} the inertia matrix is singular among the parameters of {coordinate}; give what it turns a moment of \
                     inertia about every axis"
                )
            }
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
            Failure::NegativeInertia { t, coordinate } => write!(
                f,
                "at t = {t:?} the kinetic energy is negative for a velocity of coordinate {coordinate}: a mass or a moment of inertia is \
                 negative; give that parameter the other sign (the `{{:?}}` of the system shows it), or draw it from a distribution \
                 without values below 0"
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
                 give a start of `consistent`, or one nearer to the constraints if it finds none; within a run, try a smaller step or an \
                 adaptive controller, and look for positions in which constraints depend on each other"
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
            Failure::Bifurcation { t, coordinates: [a, b] } => write!(
                f,
                "at t = {t:?} the constraints admit two motions, in which coordinates {a} and {b} move in different proportions, \
                 and the velocity there tells neither; try a start beside that position, on the branch that is meant (`traits::branches` has \
                 both directions), or end the run before it"
            ),
            Failure::OutsideModel { t, coordinate, bound } => write!(
                f,
                "at t = {t:?} coordinate {coordinate} passes {bound:?}, the end of the range in which the model holds; try the model that was \
                 simplified, or a wider range if the error there is known (`Certification`)"
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
                     {h:?} (a run without `until` has no end before that); raise `max_steps`, {otherwise}"
                )
            }
            Failure::Sliding { t } => write!(
                f,
                "at t = {t:?} the motion stays where a choice in the equations switches (`if`, `abs`, `signum`, `min`, `max`), since on both sides \
                 they lead back to there, as dry friction does that holds; end the run there and go on with a system that is held, \
                 or smooth the choice, for instance by `tanh`"
            ),
            Failure::UnknownImpulse { t } => write!(
                f,
                "by t = {t:?} the motion crossed a condition across which a momentum, a position or the potential energy jumps: an impulse \
                 acts there, which the energies do not say; give the velocities after it at an event that ends the run \
                 there (`jump` helps), or smooth the jump"
            ),
            Failure::NoDerivative { t, coordinate } => write!(
                f,
                "at t = {t:?} the acceleration of coordinate {coordinate} is finite but has no derivative, which the method needs: the argument of a \
                 root in its equation (`sqrt`, `norm`, `hypot`, `cbrt`, `powf`) vanishes there; try `Dop853` or `Verner9`, which need none"
            ),
            Failure::NotDifferentiable { t, constraint } => write!(
                f,
                "before t = {t:?} the motion has gone through a position in which constraints are dependent, and the constraint `{constraint}` \
                 depends on a parameter by which derivatives are asked for: with another value of it the motion stops there, or leaves on \
                 another branch, so that it has no derivative; end the run before the position, or leave that parameter out"
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
                "a motion at t = {t:?} cannot go on to t = {end:?}, which lies behind it (of steps of a negative size, later times do); begin at \
                 an earlier time (`set_state` of a stepper), give a later end, or change the sign of the step"
            ),
            Failure::BadPeriod { t, period } => write!(
                f,
                "the period of a controller must be positive and finite, and must not be shorter than the rounding of time, and the origin of its \
                 sampling instants must be finite, but at t = {t:?} the period is {period:?}; try a longer one, or count time from a nearer origin"
            ),
            Failure::InputNotFinite { t, input } => write!(
                f,
                "at t = {t:?} the input `{input}` was set to a number that is not finite; look for a division by zero in the control law or the program that sets it"
            ),
            Failure::BadEnd { end: Some(end) } => {
                write!(f, "the time to go to must be finite, but it is {end:?}; give a finite one")
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
            Failure::EventsAccumulate { t, event } => write!(
                f,
                "event {event} follows so soon upon the one at t = {t:?} that the way between them is lost in rounding: events accumulate \
                 there; change the impact to hold the body at rest below some speed"
            ),
            Failure::EventsUnresolved { t, h } => write!(
                f,
                "the step of size {h:?} from t = {t:?} contains more than two million half turns of the fastest oscillation, in each of \
                 which events have to be looked for; try a smaller step"
            ),
        }
    }
}

impl<S: fmt::Debug> core::error::Error for Failure<S> {}

impl<S> Failure<S> {
    /// The same with times and steps of another type.
    pub fn map<R>(self, f: impl Fn(S) -> R) -> Failure<R> {
        self.mapped(&f)
    }

    /// [`map`](Self::map), compiled once for all functions.
    #[cold]
    fn mapped<R>(self, f: &dyn Fn(S) -> R) -> Failure<R> {
        match self {
            Failure::StepSizeUnderflow { t, h, cause } => {
                Failure::StepSizeUnderflow { t: f(t), h: f(h), cause }
            }
            Failure::NonFinite { t, h } => Failure::NonFinite { t: f(t), h: f(h) },
            Failure::StateNotFinite { t, part } => Failure::StateNotFinite { t: f(t), part },
            Failure::Quadrature { t, h } => Failure::Quadrature { t: f(t), h: f(h) },
            Failure::SingularInertia { t, coordinate, with } => {
                Failure::SingularInertia { t: f(t), coordinate, with }
            }
            Failure::NegativeInertia { t, coordinate } => Failure::NegativeInertia { t: f(t), coordinate },
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
            Failure::Bifurcation { t, coordinates } => Failure::Bifurcation { t: f(t), coordinates },
            Failure::OutsideModel { t, coordinate, bound } => {
                Failure::OutsideModel { t: f(t), coordinate, bound }
            }
            Failure::BudgetUsedUp { t, h, max_steps, implicit } => {
                Failure::BudgetUsedUp { t: f(t), h: f(h), max_steps, implicit }
            }
            Failure::NotDifferentiable { t, constraint } => {
                Failure::NotDifferentiable { t: f(t), constraint }
            }
            Failure::Sliding { t } => Failure::Sliding { t: f(t) },
            Failure::UnknownImpulse { t } => Failure::UnknownImpulse { t: f(t) },
            Failure::NoDerivative { t, coordinate } => Failure::NoDerivative { t: f(t), coordinate },
            Failure::Unsuitable { chosen, requirement } => Failure::Unsuitable { chosen, requirement },
            Failure::BadTolerance { absolute, relative } => Failure::BadTolerance { absolute, relative },
            Failure::BadStepSize { h } => Failure::BadStepSize { h: f(h) },
            Failure::WrongDirection { t, h, end } => {
                Failure::WrongDirection { t: f(t), h: f(h), end: f(end) }
            }
            Failure::TimeGoesBack { t, end } => Failure::TimeGoesBack { t: f(t), end: f(end) },
            Failure::BadPeriod { t, period } => Failure::BadPeriod { t: f(t), period: f(period) },
            Failure::InputNotFinite { t, input } => Failure::InputNotFinite { t: f(t), input },
            Failure::BadEnd { end } => Failure::BadEnd { end: end.map(f) },
            Failure::SampleOrder { t, previous } => Failure::SampleOrder { t: f(t), previous: f(previous) },
            Failure::SampleBeyondEnd { t, end } => Failure::SampleBeyondEnd { t: f(t), end: f(end) },
            Failure::EventNotFinite { t, event } => Failure::EventNotFinite { t: f(t), event },
            Failure::EventNotBracketed { t, h, event } => {
                Failure::EventNotBracketed { t: f(t), h: f(h), event }
            }
            Failure::EventsAccumulate { t, event } => Failure::EventsAccumulate { t: f(t), event },
            Failure::EventsUnresolved { t, h } => Failure::EventsUnresolved { t: f(t), h: f(h) },
        }
    }

    /// Cause of a step that could not be made, of those failures that a shorter step may mend.
    pub fn cause(&self) -> Option<Cause> {
        Some(match self {
            Failure::StepSizeUnderflow { cause, .. } => return *cause,
            Failure::NonFinite { .. } | Failure::StateNotFinite { .. } => Cause::NonFinite,
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

/// A linear dependence between the gradients of constraints at a state.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Dependence {
    /// The constraint that follows from others, or whose own gradient vanishes.
    pub constraint: &'static str,
    /// The one of the others that it follows from the most; `None` if its own gradient vanishes.
    pub on: Option<&'static str>,
    /// The number of further constraints that it follows from.
    pub others: u16,
    /// The square of the sine of the angle between its gradient and those of the others; if its gradient vanishes,
    /// the remaining part of the gradient's square.
    pub left: f64,
    /// The number of constraints that are independent.
    pub rank: u16,
    /// The number of constraints.
    pub of: u16,
}

impl fmt::Display for Dependence {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Dependence { constraint, on, others, left, rank, of } = self;
        match (on, others) {
            (None, _) => write!(f, "the gradient of the constraint `{constraint}` vanishes"),
            (Some(on), 0) => write!(f, "the constraint `{constraint}` depends on `{on}`"),
            (Some(on), others) => {
                write!(f, "the constraint `{constraint}` depends on `{on}` and {others} more")
            }
        }?;
        write!(f, " (rank {rank} of {of}, to one part in {:.0e})", 1.0 / left.max(1e-32))
    }
}

#[cfg(test)]
mod tests;
