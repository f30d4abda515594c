//! Reasons why an analysis has no result.

use crate::failure::{Coordinate, Failure, variant};
use std::fmt;

/// Reason why there are no modes, no equilibrium, no exponent. Its text is a sentence that ends in what to try next.
#[derive(Clone, PartialEq)]
#[non_exhaustive]
pub enum AnalysisError {
    /// The given configuration is no equilibrium.
    NotEquilibrium {
        /// The largest generalized force that is left, `max |b − f|` at rest, in the unit of that force.
        residual: f64,
        /// Its coordinate.
        coordinate: Coordinate,
        /// The equilibrium that Newton's method reaches from there.
        nearest: Option<Vec<f64>>,
    },
    /// The inertia matrix is singular or indefinite.
    Inertia {
        /// Smallest eigenvalue of the inertia matrix, scaled to a unit diagonal.
        eigenvalue: f64,
        /// The coordinate that moves most along its eigenvector.
        coordinate: Coordinate,
    },
    /// Time appears in the equations of motion ([`Facts::autonomous`](crate::Facts::autonomous) is not proved): there
    /// is no equilibrium, small motions have no constant coefficients, and so has the model from one sampling instant
    /// to the next.
    TimeDependent,
    /// The inertia matrix is not symmetric.
    UnsymmetricInertia {
        /// Largest entry of its antisymmetric part.
        largest: f64,
    },
    /// The state is on a switch of the forces (`if`, `abs`, `max`, …) at which they or their derivatives jump.
    Switch {
        /// Index of the switching function in [`System::switches`](crate::System::switches).
        index: usize,
    },
    /// An input has a value on whose two sides the accelerations or their derivatives differ, as at the limit of a
    /// `clamp`.
    SwitchedInput {
        /// Its name.
        input: &'static str,
    },
    /// Forces or their derivatives jump as a coordinate or its velocity passes its value at the state, and no switch of
    /// the formulas is there: the state is on a kink of a function with data, such as a knot of
    /// [`Curve::linear`](crate::traits::Curve::linear), or of an `extern fn`.
    Kink {
        /// The coordinate.
        coordinate: Coordinate,
        /// Is it its velocity that they jump with?
        velocity: bool,
    },
    /// An output, or one of its derivatives, jumps as a state or an input passes its value, as `x.abs()` does at 0.
    SwitchedOutput {
        /// Its index.
        output: usize,
    },
    /// Damping is negative: the energy grows along some motions.
    NegativeDamping {
        /// Smallest eigenvalue of the damping matrix, scaled to a unit diagonal.
        eigenvalue: f64,
    },
    /// Small motions leave the equilibrium, or gyroscopic forces alone hold them.
    Unstable {
        /// The least ω² of the modes, negative, in 1/s².
        square: f64,
    },
    /// The coordinates are not independent, and this function needs them to be, or the type does not implement
    /// [`System::constraint_terms`](crate::System::constraint_terms).
    DependentCoordinates {
        /// Name of a constraint.
        constraint: &'static str,
    },
    /// The state is not on a constraint.
    OffConstraints {
        /// Name of the constraint.
        constraint: &'static str,
        /// Relative violation, see [`Restored::violation`](crate::traits::Restored::violation).
        violation: f64,
    },
    /// Constraints depend on each other at the state: what they admit there is not determined by their first
    /// derivatives.
    DependentConstraints {
        /// Name of a constraint whose gradient the others contain.
        constraint: &'static str,
        /// Part of its gradient that is independent.
        left: f64,
    },
    /// An input appears in a constraint: the states that it admits change with the input, which is no input of
    /// `ẋ = A x + B u`.
    ConstrainedInput {
        /// Name of the constraint.
        constraint: &'static str,
    },
    /// Forces depend on the configuration and have no potential: there is no energy criterion, and modes are not real.
    Circulatory {
        /// Largest entry of the antisymmetric part of the stiffness matrix.
        largest: f64,
    },
    /// Gyroscopic forces: the modes of M and K alone are not those of the system.
    Gyroscopic {
        /// Largest entry of the antisymmetric part of C.
        largest: f64,
    },
    /// A matrix, state or force is infinite or not a number.
    NotFinite,
    /// The lengths of arguments do not fit.
    Dimension {
        /// The length needed.
        expected: usize,
        /// The length given.
        found: usize,
    },
    /// An iteration did not converge.
    NotConverged {
        /// Quantity that was sought.
        what: &'static str,
        /// The residual that was left: of an equilibrium the largest generalized force, of an operating point the
        /// largest acceleration, of a periodic orbit the largest difference of a coordinate or velocity.
        residual: f64,
    },
    /// A generalized force is left that no displacement changes: the system, or a part of it, is pushed and not held.
    Unbalanced {
        /// The generalized force, or, of an operating point, the acceleration.
        force: f64,
        /// Its coordinate.
        coordinate: Coordinate,
    },
    /// A state of first order has a rate that neither coordinates nor states change, as the integrator of a
    /// controller whose command is not 0.
    Running {
        /// Its name.
        state: &'static str,
        /// Its rate, in its unit per unit of t.
        rate: f64,
    },
    /// The search for a periodic orbit ended at an equilibrium, which has every period and is none.
    AtRest,
    /// A curve of equilibria could not be followed: what it does there is smaller than rounding.
    Unresolved {
        /// The parameter where it was lost.
        parameter: f64,
        /// The shortest step that was tried, as a length in (q, μ).
        step: f64,
    },
    /// There is no such motion with the given momenta or rates: a discriminant is negative.
    NoSteadyMotion {
        /// The discriminant.
        discriminant: f64,
    },
    /// The system is not of the form that the theory needs.
    NotApplicable {
        /// Property that the system lacks.
        needs: &'static str,
    },
    /// Driven at a natural frequency without damping, or singular stiffness at rest: the response is infinite.
    Resonance {
        /// The driving angular frequency, in rad/s.
        omega: f64,
    },
    /// A trajectory failed.
    Run(Failure<f64>),
}

impl AnalysisError {
    /// Its name: `"TimeDependent"`.
    pub fn name(&self) -> &'static str {
        variant! { self => AnalysisError:
            NotEquilibrium, Inertia, TimeDependent, UnsymmetricInertia, Switch, SwitchedInput, Kink, SwitchedOutput, NegativeDamping, Unstable, DependentCoordinates, OffConstraints, DependentConstraints, ConstrainedInput, Circulatory, Gyroscopic, NotFinite, Dimension, NotConverged, Unbalanced, Running, AtRest, Unresolved, NoSteadyMotion, NotApplicable, Resonance, Run,
        }
    }
}

/// The name and the text, since that is how an error that `main` returns is printed.
impl fmt::Debug for AnalysisError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {self}", self.name())
    }
}

impl fmt::Display for AnalysisError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        use AnalysisError::*;
        match self {
            NotEquilibrium { residual, coordinate, nearest } => {
                write!(
                    f,
                    "this is no equilibrium: a generalized force of {residual:e} is left at coordinate {coordinate}; "
                )?;
                match nearest {
                    Some(q) => write!(f, "the nearest one found is at {q:?}"),
                    None => write!(f, "none was found near it, try `equilibria` over a box"),
                }
            }
            Inertia { eigenvalue, coordinate } => write!(
                f,
                "the inertia matrix is not positive definite (smallest eigenvalue {eigenvalue:e} of the largest) along \
                 coordinate {coordinate}; choose coordinates that are regular there"
            ),
            UnsymmetricInertia { largest } => write!(
                f,
                "the inertia matrix is not symmetric (by {largest:e}); it is the second derivative of the kinetic energy, \
                 so give both halves of each mixed term"
            ),
            Switch { index } => write!(
                f,
                "the state is on a switch of the forces (number {index} of `System::switches`), whose two sides have \
                 different derivatives: no linear equations hold about it; integrate it, or analyse each side as a system of \
                 its own"
            ),
            SwitchedInput { input } => write!(
                f,
                "the input `{input}` is where the forces switch (`clamp`, `abs`, `if`, …), and their derivatives on its two sides \
                 differ: there is no B; take the model with the input on the side that is meant, or hold it (`without_inputs`)"
            ),
            Kink { coordinate, velocity } => write!(
                f,
                "the forces or their derivatives jump as {}coordinate {coordinate} passes its value: an argument of an `extern` function is at \
                 a kink there (a knot of `Curve::linear` or `Surface::linear`, an end with `Beyond::Held`, an `abs` of a Rust \
                 function), and no linear equations hold about it; join the points by `cubic` or `monotone`, or take a state on the \
                 side that is meant",
                if *velocity { "the velocity of " } else { "" }
            ),
            SwitchedOutput { output } => write!(
                f,
                "output {output} or its derivatives jump at this state (`abs`, `clamp`, `if`, the knot of a table, …): there are no \
                 C and D; take the model about a state on the side that is meant"
            ),
            NegativeDamping { eigenvalue } => write!(
                f,
                "damping is negative along some motion (smallest eigenvalue {eigenvalue:e} of the damping matrix scaled to \
                 a unit diagonal), and the energy does not decide; use `first_approximation` or `spectrum`"
            ),
            Unstable { square } => write!(
                f,
                "motions leave this equilibrium, or gyroscopic forces alone hold them (the least ω² of its modes is {square:e}): no set of \
                 vibrations stands for them; take a stable equilibrium, or integrate the whole system"
            ),
            TimeDependent => write!(
                f,
                "time appears in the equations of motion: equilibria, small vibrations and sampled models need an autonomous system, such \
                 as one in a steadily moving frame in which time drops out; integrate it, or derive a system without its force of \
                 time: where a parameter multiplies that force, `pub simplified Free: neglect parameter;` in the definition"
            ),
            DependentCoordinates { constraint } => write!(
                f,
                "the coordinates are not independent (constraint `{constraint}`); write the system in independent \
                 coordinates"
            ),
            OffConstraints { constraint, violation } => write!(
                f,
                "the state is not on the constraint `{constraint}` (relative violation {violation:e}); start from \
                 `consistent(&system, &state)?`"
            ),
            DependentConstraints { constraint, left } => write!(
                f,
                "the constraint `{constraint}` depends on the others at this state (an independent part of {left:e} of its \
                 gradient): the mechanism is in a singular position, whose motions are not those of linear equations; \
                 leave the constraint out if it follows from the others everywhere, or take another state"
            ),
            ConstrainedInput { constraint } => write!(
                f,
                "an input appears in the constraint `{constraint}`: it moves the states that are admitted, and is no input of \
                 a linear model; let a force act instead, or make the moved quantity a coordinate of its own"
            ),
            Circulatory { largest } => write!(
                f,
                "the stiffness matrix is not symmetric (by {largest:e}): forces have no potential; use `spectrum`"
            ),
            Gyroscopic { largest } => write!(
                f,
                "there are gyroscopic forces (up to {largest:e}), and the modes are complex; use `spectrum`"
            ),
            NotFinite => write!(
                f,
                "a matrix, state or force is infinite or not a number; look at the state and the parameters"
            ),
            Dimension { expected, found } => {
                write!(f, "{expected} components are needed and {found} were given")
            }
            NotConverged { what, residual } => {
                write!(f, "{what} was not found, the residual stays at {residual:e}; start closer to it")
            }
            Unbalanced { force, coordinate } => write!(
                f,
                "a generalized force of {force:e} is left at coordinate {coordinate} that no displacement changes, so there is no \
                 equilibrium near the guess: hold the system there, take the force away, or start where a force that saturates (`clamp`, `max`) is within its limits"
            ),
            Running { state, rate } => write!(
                f,
                "the state `{state}` has the rate {rate:e} wherever coordinates and states rest, so there is no operating point: set the input or \
                 parameter that drives it so that it can vanish, or leave the state out"
            ),
            AtRest => write!(
                f,
                "the search for a periodic orbit ended at an equilibrium, which has every period: start farther from it, at an \
                 amplitude that the orbit has"
            ),
            Unresolved { parameter, step } => write!(
                f,
                "the curve of equilibria was lost at the parameter {parameter}: no step from there, down to {step:e}, can be told from \
                 one onto another curve. Curves that are nearer to each other than rounding, as those of a pitchfork with an \
                 imperfection below some 1e-13 of its forces, or scales of q that differ by 1e6 and more, cannot be told apart; \
                 take the imperfection away or make it larger, and measure q in other units"
            ),
            NoSteadyMotion { discriminant } => write!(
                f,
                "there is no steady motion with these momenta (discriminant {discriminant:e}); spin faster than the \
                 threshold"
            ),
            NotApplicable { needs } => write!(f, "this needs {needs}"),
            Resonance { omega } => write!(
                f,
                "the response at the angular frequency {omega} is infinite; add damping or leave the resonance"
            ),
            Run(failure) => write!(f, "{failure}"),
        }
    }
}

impl std::error::Error for AnalysisError {}

impl From<Failure<f64>> for AnalysisError {
    fn from(failure: Failure<f64>) -> Self {
        AnalysisError::Run(failure)
    }
}
