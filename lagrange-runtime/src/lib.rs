//! Mechanics from energies: write T, V, D and Q of a system inside [`lagrangian!`], and get its accelerations, momenta,
//! inertia, Jacobian and integrators as compiled code.
//!
//! ```
//! use lagrange_runtime::prelude::*;
//!
//! lagrangian! {
//!     /// A pendulum whose pivot is shaken vertically.
//!     pub system Kapitza {
//!         param m, l, a, omega, g = 9.81;
//!         coord theta;
//!         coord pivot = a * cos(omega * t);
//!         let x = l * sin(theta);
//!         let y = pivot - l * cos(theta);
//!         T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
//!         V = m * g * y;
//!     }
//! }
//!
//! let system = Kapitza::new(1.0, 0.3, 0.02, 400.0);
//! let start = State::new(0.0, [3.0], [0.0]);
//! let end = integrate(&system, Dop853, PiController::tolerance(1e-10), start).until(2.0).final_state()?;
//! assert!((end.q[0] - std::f64::consts::PI).abs() < 0.3, "upside down, and stable");
//! # Ok::<(), Box<dyn core::error::Error>>(())
//! ```
//!
//! [`integrate`](integrate()) returns a [`Run`], an iterator of accepted steps. [`Run::final_state`] gives the last
//! state, [`Run::sample`] states at given times, [`Run::events`] the zeros of functions of the state, and a `for`
//! loop every step. An error is a [`Failure`]: a value that says where, what, and what to try next.
//!
//! # Who drives time?
//!
//! One time loop, and four ways to drive it:
//!
//! | You have | Use | It |
//! |---|---|---|
//! | a motion from a start to an end | [`integrate`](integrate()), a [`Run`] | borrows the system; an iterator of steps, with samples, events and integrals |
//! | a program that says when to go on: a simulator, a game, a test rig | [`Stepper`] | owns the system, which may change between steps; lives in a struct, is cloned as a snapshot, takes a bound on the work of a call |
//! | a digital controller | [`Stepper::every`], in a struct [`SampledStepper`](integrate::SampledStepper) with a boxed [`ControlLaw`](integrate::ControlLaw) | lands on the sampling instants, and holds the inputs in between |
//! | many motions | module `ensemble` | threads, and lanes in vector registers |
//!
//! # Which method?
//!
//! | You want | Method | Controller |
//! |---|---|---|
//! | an accurate trajectory, and know nothing else | [`Dop853`], or [`Verner9`] from 1e-8 on | [`PiController`] with 1e-6 to 1e-13 |
//! | a quick one, to plot it | [`DormandPrince5`] | [`PiController`] with 1e-3 to 1e-6 |
//! | the last digits of a smooth motion | [`Taylor`], with [`TaylorController`] to 1e-15, where no `extern fn` is in the way (at an `if` or `abs` steps end, and go on beyond); [`Verner9`]; [`Nystrom12`] where forces do not depend on q̇ | [`PiController`] with 1e-9 to 1e-14 |
//! | equal steps, simple and well known | [`Rk4`] | [`FixedStep`] |
//! | long runs that keep energy bounded; T(q̇) + V(q), no velocity-dependent force | [`Verlet`] | [`FixedStep`] |
//! | the same to more digits | [`BlanesMoan4`], [`BlanesMoan6`], [`Compose`]`(Verlet, KahanLi8)` | [`FixedStep`] |
//! | the same for any Lagrangian, such as a double pendulum | [`ImplicitMidpoint`], [`Gauss4`], [`Gauss6`] | [`FixedStep`] |
//! | the same where some oscillations are faster than the steps | [`VariationalMidpoint`] | [`FixedStep`] |
//! | long runs with constraints on positions, directions among them | [`ConstrainedMidpoint`](method::variational::ConstrainedMidpoint), [`Compose`]`(ConstrainedMidpoint, KahanLi8)` | [`FixedStep`] |
//! | stiff systems: strong damping, stiff springs | [`Rodas5P`], [`Radau5`] | [`PiController`] with 1e-3 to 1e-9 |
//! | linear systems with constant coefficients, exactly | [`MatrixExponential`] | [`FixedStep`] |
//! | energy and momenta of ignorable coordinates to rounding, with adaptive steps | [`Projection`]`(Dop853)` | [`PiController`] |
//!
//! Symplectic methods keep the energy bounded only with equal steps, so they take [`FixedStep`] and nothing else: a
//! method without an error estimate under an adaptive controller is a compile error, and so is [`Verlet`] on a system
//! that is not [`Separable`](traits::Separable).
//!
//! If you do not want to choose a method, call [`simulate`], which returns the final state, or [`method_for`], which
//! chooses a method and its controller for a [`goal`] and gives the reason. It takes the first row of this table that
//! fits ([`method::choice::RECOMMENDATIONS`]):
//!
//! | Goal | System | Method | because |
//! |---|---|---|---|
//! | `Accuracy`, 1e-5 or coarser | any | [`DormandPrince5`] | at coarse tolerances order 5 has the fewest evaluations |
//! | `Accuracy`, 1e-10 or finer, with constraints 1e-13 or finer | analytic | [`Taylor`] | series of order 20 take 0.3 to 1.4 of the time of orders 9 and 12 there, mostly less, and lose fewer of the last digits |
//! | `Accuracy` | separable | [`Nystrom12`] | without velocities in the forces order 12 takes two thirds of the evaluations of order 8 |
//! | `Accuracy` | any other | [`Verner9`] | order 9 is as quick as order 8 at 1e-6, takes three quarters of its time for the last digits, and has smaller errors |
//! | `LongTime` | linear, conservative | [`MatrixExponential`] | it is exact at any step |
//! | `LongTime` | separable | [`BlanesMoan4`] | it is symplectic, explicit since T(q̇) + V(q) splits, and far better than Verlet at a sixth of the step |
//! | `LongTime` | L quadratic in q̇, no constraints, no rotations | [`Gauss4`] | it is symplectic for every Lagrangian with momenta |
//! | `LongTime` | any other | [`Dop853`] | no method bounds the energy without velocities from momenta; of attitudes order 8 errs least |
//! | `Stiff`, 1e-7 or coarser | any | [`Rodas5P`] | its steps do not follow the fastest rates, and need no iteration |
//! | `Stiff` | any | [`Radau5`] | its steps do not follow the fastest rates, and its errors are the smaller ones |
//!
//! # Traits
//!
//! The prelude has the traits whose functions programs call, and those that bound generic functions:
//!
//! | Trait | For |
//! |---|---|
//! | [`System`] | `accel`; the bound of a function of any system |
//! | [`Lagrangian`] | L, `momenta`, `inertia`, `jacobian`, the terms of the equations of motion, and `FACTS` |
//! | [`Energies`] | `kinetic`, `potential` and `energy`, where T and V were given |
//! | [`Constrained`] | residuals, `multipliers` and `reactions` of constraints |
//! | [`Impulsive`] | `jump` of the velocities under an impulse |
//! | [`Inputs`] | `inputs` and `set_inputs` as a vector |
//! | [`States`](traits::States) | `start` and `states` of a system with states of first order |
//! | [`Routhian`] | `ignorable_velocities` of a reduced system |
//! | [`Restricted`](traits::Restricted) | `restrict` and `lift` of a restriction or a simplified model |
//! | [`Precompute`](traits::Precompute) | `precomputed` |
//! | [`Method`] | the bound of a function of any method |
//! | [`Interpolant`] | the state `at` a time within a step |
//! | [`Scalar`], [`Real`] | bounds of functions of any number, and of those with comparisons |
//! | [`Functions`] | `sin`, `sqrt` … of numbers other than `f64` |
//!
//! The module [`traits`] has the others: facts that the compiler proves and that methods require, derivatives
//! ([`Linearize`](traits::Linearize), [`InputJacobian`](traits::InputJacobian)), Taylor series
//! ([`Analytic`](traits::Analytic)), velocities from momenta ([`LegendreTransform`](traits::LegendreTransform)), and
//! the interface of a function of the program ([`ExternFunction`](traits::ExternFunction)).
//!
//! # Units and order of components
//!
//! Quantities have the units that the system is written in, any that fit together: steps have the unit of t, absolute
//! tolerances the units of q and q̇. Where documentation names a unit it is that of SI. Angles are in radians. A vector
//! has an element for each coordinate, in the order of their declaration, and then one for each [state of first
//! order](traits::States); a matrix of (q, q̇) has q above q̇.
//!
//! # Equilibria, vibrations, stability
//!
//! The module `analysis` (feature `analysis`) finds equilibria, modes, steady motions, their stability and their
//! bifurcations, periodic orbits and Lyapunov exponents, with the exact derivatives that the compiler emits.
//!
//! # Many trajectories
//!
//! The module `ensemble` (feature `ensemble`) draws starts and parameters from distributions, Sobol sequences or
//! tables, runs them on all threads, eight side by side in vector registers if asked to (module [`lanes`]), and keeps
//! statistics of their outputs. A cheap model beside the full one, Sobol' indices, rare events, and certificates of
//! simplified models are studies of it.
//!
//! # Other numbers
//!
//! All computations use the system's [`Scalar`]: `f32`, `f64`, [`DoubleDouble`] of 31 digits, [`Dual`] and
//! [`Gradient`], whose slopes carry the derivatives of a trajectory by parameters or by its start, or
//! [`lanes::Lanes`], several numbers side by side. Time and step are of that type too. Adaptive steps need a
//! [`Real`].
//!
//! # Without the standard library
//!
//! `default-features = false, features = ["libm"]`. Nothing here allocates.
//!
//! [`Taylor`]: const@Taylor
#![cfg_attr(not(feature = "std"), no_std)]
#![deny(missing_docs)]
#![deny(unsafe_code)]
#![cfg_attr(docsrs, feature(doc_cfg))]
extern crate self as lagrange_runtime;

mod admissible;
#[cfg(feature = "analysis")]
pub mod analysis;
mod attitude;
#[cfg(feature = "chart")]
pub mod chart;
mod choice;
mod constraint;
pub mod controller;
mod diagnosis;
#[cfg(feature = "ensemble")]
pub mod ensemble;
pub mod event;
mod external;
mod facts;
mod failed;
pub mod failure;
mod impulse;
mod input;
pub mod integrate;
mod iteration;
pub mod lanes;
mod language;
mod linear;
mod locked;
pub mod method;
#[cfg(feature = "std")]
mod observe;
mod prepared;
mod quadrature;
mod restricted;
mod rotation;
mod routhian;
mod sample;
#[cfg(feature = "serde")]
mod saved;
pub mod scalar;
mod series;
mod state;
mod states;
mod system;
#[cfg(feature = "std")]
mod table;
#[cfg(any(test, feature = "testing"))]
pub mod testing;

/// Traits that [`lagrangian!`] implements for a system, and the values that their functions return.
///
/// [`System`] is what every method needs, [`Lagrangian`] what every system has; the others exist where the
/// definition gives cause for them, or the compiler has proved what they mark.
pub mod traits {
    pub use crate::constraint::{Branches, Constrained, Prescribed, branches, consistent, restore};
    pub use crate::event::CompiledEvents;
    pub use crate::external::ExternFunction;
    pub use crate::facts::{
        CommonSymmetry, Constraint, ConstraintKind, CoordinateKind, Facts, Operations, Redundancy,
        Similarity, Symmetry,
    };
    pub use crate::impulse::{Impulsive, Jump};
    pub use crate::input::{InputJacobian, Inputs};
    pub use crate::locked::{Locked, Locks, NotLockable};
    pub use crate::prepared::{Precompute, Precomputed};
    pub use crate::restricted::{NotHeld, Restricted};
    pub use crate::routhian::Routhian;
    pub use crate::series::{Analytic, TaylorSeries};
    /// Rotations by matrices, quaternions and Euler's angles.
    pub mod rotation {
        pub use crate::attitude::euler::EulerAngles;
        pub use crate::rotation::{NotARotation, by_matrix, by_quaternion};
    }
    #[doc(hidden)]
    pub use crate::state::Begun;
    pub use crate::state::{ConstraintTerms, Restored};
    pub use crate::states::States;
    pub use crate::system::{
        Autonomous, Conservative, ConstantInertia, Energies, Independent, Jacobian, Lagrangian,
        LegendreTransform, Linear, Linearization, Linearize, Separable, System, dual_inertia, dual_jacobian,
        dual_linearization,
    };
    #[cfg(feature = "std")]
    pub use crate::table::{Beyond, Curve, InvalidTable, Surface};
    pub use nalgebra::{UnitQuaternion, Vector3};
}

pub use constraint::consistent;
pub use controller::{Controller, FixedStep, PiController, PidController};
pub use diagnosis::diagnose;
pub use event::{Direction, Event, Occurrence};
pub use failure::Failure;
pub use integrate::{Advance, Run, Statistics, Stepper, integrate};
#[doc(no_inline)]
pub use method::choice::goal;
pub use method::choice::{method_for, simulate};
pub use method::compose::{Compose, KahanLi8};
pub use method::explicit_rk::{Dop853, DormandPrince5, Rk4, Verner9};
pub use method::gauss::{Gauss4, Gauss6, ImplicitMidpoint};
pub use method::modal::MatrixExponential;
pub use method::nystrom::Nystrom12;
pub use method::projection::Projection;
pub use method::radau::Radau5;
pub use method::rosenbrock::Rodas5P;
pub use method::splitting::{BlanesMoan4, BlanesMoan6, Verlet};
pub use method::taylor::{Taylor, TaylorController};
pub use method::variational::VariationalMidpoint;
pub use method::{Interpolant, Method};
pub use nalgebra::{SMatrix, SVector};
pub use scalar::{DoubleDouble, Dual, Functions, Gradient, Real, Scalar};
pub use state::{State, Tangent, wrapped_angle};
pub use traits::{Constrained, Energies, Facts, Impulsive, Inputs, Lagrangian, Routhian, System};

/// Support code of what [`lagrangian!`] emits: no interface.
#[doc(hidden)]
pub mod __private {
    pub use crate::__saved;
    pub use crate::event::{Compiled, Direction, Event};
    pub use crate::external::DataInLanes;
    pub use crate::impulse::{constrained_jump, jump_beside_states};
    pub use crate::input::dual_input_jacobian;
    pub use crate::linear::solved;
    pub use crate::method::choice;
    pub use crate::scalar::{Comparison, SimdScalar};
    pub use crate::traits::*;
    pub use crate::{Dual, Failure, Functions, Real, SMatrix, SVector, Scalar, State, lanes};
    pub use lagrange_macros::lagrangian;
    #[cfg(feature = "serde")]
    pub use serde;
    pub mod admissible {
        pub use crate::admissible::{terms, toward};
    }
    pub mod constraint {
        pub use crate::constraint::{
            accel_across, begun_across, determined, differentiable, explained, independence, least_norm,
            motion, resolved, restored_across,
        };
    }
    pub mod diagnosis {
        pub use crate::diagnosis::{explained, resolved};
    }
    pub mod series {
        pub use crate::series::*;
    }
    #[cfg(feature = "serde")]
    pub mod saved {
        pub use crate::saved::{Kept, Saved, restore, save};
    }
}

/// The implementations of serde's traits for a system, where the feature `serde` is on.
#[cfg(feature = "serde")]
#[doc(hidden)]
#[macro_export]
macro_rules! __saved {
    ($name:ident { $($items:tt)* }) => {
        impl<S: $crate::Scalar> $crate::__private::saved::Saved for $name<S> {
            type Number = S;
            $($items)*
        }
        impl<S: $crate::Scalar + $crate::__private::serde::Serialize> $crate::__private::serde::Serialize for $name<S>
        where
            <Self as $crate::__private::saved::Saved>::Data: $crate::__private::serde::Serialize,
        {
            fn serialize<Z: $crate::__private::serde::Serializer>(
                &self,
                to: Z,
            ) -> ::core::result::Result<Z::Ok, Z::Error> {
                $crate::__private::saved::save(self, to)
            }
        }
        impl<'de, S: $crate::Scalar + $crate::__private::serde::Deserialize<'de>>
            $crate::__private::serde::Deserialize<'de> for $name<S>
        where
            <Self as $crate::__private::saved::Saved>::Data: $crate::__private::serde::Deserialize<'de>,
        {
            fn deserialize<Z: $crate::__private::serde::Deserializer<'de>>(
                from: Z,
            ) -> ::core::result::Result<Self, Z::Error> {
                $crate::__private::saved::restore(from)
            }
        }
    };
}

/// Nothing, where the feature `serde` is off.
#[cfg(not(feature = "serde"))]
#[doc(hidden)]
#[macro_export]
macro_rules! __saved {
    ($($system:tt)*) => {};
}

/// Names that most programs need: `use lagrange_runtime::prelude::*;`.
///
/// It holds the methods and controllers that the tables of the [front page](crate) recommend,
/// [`integrate`](crate::integrate()) and its kin, and the traits of the [table there](crate#traits).
pub mod prelude {
    #[cfg(feature = "std")]
    pub use crate::integrate::{ControlLaw, SampledStepper};
    #[cfg(feature = "std")]
    pub use crate::traits::{Beyond, Curve, Surface};
    pub use crate::traits::{
        Constrained, ConstraintKind, CoordinateKind, Energies, Impulsive, Inputs, Lagrangian, Precompute,
        Precomputed, Restricted, Routhian, States, System, UnitQuaternion, Vector3,
    };
    pub use crate::{
        BlanesMoan4, BlanesMoan6, Compose, Dop853, DormandPrince5, DoubleDouble, Dual, Event, Failure,
        FixedStep, Functions, Gauss4, Gauss6, Gradient, ImplicitMidpoint, Interpolant, KahanLi8,
        MatrixExponential, Method, Nystrom12, PiController, PidController, Projection, Radau5, Real, Rk4,
        Rodas5P, SMatrix, SVector, Scalar, State, Stepper, Tangent, Taylor, TaylorController,
        VariationalMidpoint, Verlet, Verner9, consistent, goal, integrate, lagrangian, method_for, simulate,
    };
}

/// The guide has one listing that must not compile; the others are tests of their own, in `tests/guide`.
#[cfg(doctest)]
#[doc = include_str!("../../docs/guide/src/methods.md")]
struct Methods;

/// The environment variable `LAGRANGE_LONG` is set, as `.ci/run` does for optimised builds: tests take more samples.
#[cfg(test)]
pub(crate) fn long() -> bool {
    std::env::var_os("LAGRANGE_LONG").is_some()
}
