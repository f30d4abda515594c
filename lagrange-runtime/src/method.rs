//! Methods of integration: one pure step with explicit memory, and an interpolant of that step.
//!
//! # Errors within steps
//!
//! Samples, events and integrals are of states within steps, where the error is that of the interpolant. Its order
//! may be lower than that of the step:
//!
//! | method | order | order within steps | evaluations of the interpolant | of a run | of one step |
//! |---|---|---|---|---|---|
//! | [`DormandPrince5`](explicit_rk::DormandPrince5) | 5 | 4 | 0 | 1.0 | 35 |
//! | [`Tsitouras5`](explicit_rk::Tsitouras5) | 5 | 4 | 0 | 1.1 | 27 |
//! | [`Dop853`](explicit_rk::Dop853) | 8 | 7 | 3 | 3.2 | 17 |
//! | [`Verner9`](explicit_rk::Verner9) | 9 | 8 | 4 | 2.0 | 6.9 |
//! | [`Nystrom6`](nystrom::Nystrom6) | 6 | 6 in q, 5 in q̇ | 0 | 2.4 | 150 |
//! | [`Nystrom8`](nystrom::Nystrom8) | 8 | 8 in q, 7 in q̇ | 6 | 1.1 | 8.9 |
//! | [`Nystrom12`](nystrom::Nystrom12) | 12 | 12 in q, 11 in q̇ | 16 | 1.5 | 4.1 |
//! | [`Radau5`](radau::Radau5) | 5 | 5 | as a step | 1.0 | 230 |
//! | [`Rodas4`](rosenbrock::Rodas4) | 4 | 3 | 0 | 1.6 | 150 |
//! | [`Rodas5P`](rosenbrock::Rodas5P) | 5 | 4 | 0 | 7.7 | 27 |
//! | [`Taylor`](const@taylor::Taylor) | 7 − ½ ln ε | the same | 0 | 1.1 | 0.31 |
//!
//! The last two columns are the largest error within steps, divided by the largest error at their ends. *Of a run*, in
//! which errors of all steps add up: the worst of tolerances 1e-6, 1e-8, 1e-10 and 1e-12 on an orbit of Kepler's
//! problem (e = 0.3) and on an oscillator, 10 units of time; closed forms are the references. *Of one step*, begun on
//! the orbit itself: at 1e-10. An interpolant is computed with the first sample of its step.
//!
//! # Forces that set in later
//!
//! A step knows the forces at its stages ([`Taylor`](const@taylor::Taylor): the derivatives at its start), and nothing
//! in between. What follows from that:
//!
//! - Forces that switch in time (`if t > 50 { … }`, `min`, `max`) are always seen: adaptive steps end there.
//! - A body on which no force acts yet takes adaptive steps of at most 1/128 of the time to the end of its run, if
//!   time appears in its equations: `exp(−(t − 50)²)` on a body at rest is seen in a run to t = 100, by every method.
//! - A smooth force that acts for much less than that, or for less than a step of a motion that other forces keep
//!   going, may be stepped over without a word: `10 exp(−((t − 50)/0.1)²)` on a pendulum that swings.
//!   [`PiController::max_step`](crate::PiController::max_step) and
//!   [`TaylorController::max_step`](taylor::TaylorController::max_step) bound the steps.
//!
//! # Digits
//!
//! Coefficients have 32 digits or more, as [`DoubleDouble`](crate::DoubleDouble) has; computations in `f64` use the
//! nearest `f64`.

use crate::failure::Failure;
use crate::scalar::{Real, Scalar};
use crate::state::State;
use crate::system::System;
use core::fmt;
use nalgebra::SVector;

mod across;
mod compensated;
pub mod compose;
pub mod explicit_rk;
pub mod gauss;
pub mod hermite;
pub mod modal;
mod newton;
pub mod nystrom;
pub mod projection;
pub mod radau;
pub mod rosenbrock;
pub mod splitting;
pub mod taylor;
pub mod variational;

/// The method for a system and a goal, chosen by what the compiler found out about the system.
///
/// [`method_for`](choice::method_for) and [`simulate`](choice::simulate) choose. The trait
/// [`RecommendedMethods`](choice::RecommendedMethods), which is emitted for every `lagrangian!` system, states the
/// methods that the facts of a system allow, as types. rustc checks them as it checks methods given by name, and
/// compiles only those that a [`goal`](choice::goal) leaves to choose from. The table
/// [`RECOMMENDATIONS`](choice::RECOMMENDATIONS) says the same in words; the [front page](crate) of this crate shows it.
pub mod choice {
    pub use crate::choice::*;
}

pub use across::Across;
pub(crate) use across::steps_across;

/// A one-step method `Φ_h` for systems of the kind `Sys` with `N` coordinates.
///
/// A step changes nothing that it began with: the data that a method needs at its next step (accelerations already
/// computed, momenta, a starting guess) are returned in another [`MethodState`](Self::MethodState). A rejected step is
/// therefore discarded without undoing anything. (To integrate, use [`integrate`](crate::integrate()), which calls
/// these functions.)
///
/// ```
/// use lagrange_runtime::prelude::*;
/// # struct Oscillator;
/// # impl System<1> for Oscillator {
/// #     type Scalar = f64;
/// #     fn accel(&self, q: &SVector<f64, 1>, _: &SVector<f64, 1>, _: f64) -> SVector<f64, 1> {
/// #         -q
/// #     }
/// # }
/// let start = State::new(0.0, [1.0], [0.0]);
/// let memory = Dop853.start(&Oscillator, &start)?;
/// let (step, next) = Dop853.step(&Oscillator, &memory, &start, 0.1)?;
/// let middle = Dop853.interpolant(&Oscillator, &step).at(0.05);
/// assert!((middle.q[0] - 0.05f64.cos()).abs() < 1e-14);
/// let (second, _) = Dop853.step(&Oscillator, &next, &step.to, 0.1)?;
/// assert!((second.to.q[0] - 0.2f64.cos()).abs() < 1e-14);
/// # Ok::<(), Failure>(())
/// ```
///
/// A step by hand is that of the method alone. It keeps no constraints, checks neither its start nor that its end is
/// finite, lands on no switch, and goes on with the parameters of rotations (`coord R: rotation;`) that it began with,
/// which have no values after a whole turn. A [`Stepper`](crate::Stepper) does all of that; where it does not serve,
/// the next step of a rotation begins from its shorter parameters, which are the same attitude:
///
/// ```
/// # use lagrange_runtime::prelude::*;
/// # lagrangian! {
/// #     system Body {
/// #         coord R: rotation;
/// #         T = body(1, [1.0, 1.2, 0.8], frame(world, [0, 0, 0], R));
/// #         V = 0;
/// #     }
/// # }
/// # let body = Body::default();
/// # let rest = State::new(0.0, [0.0; 3], [0.0; 3]);
/// let mut at = body.with_attitude_R(rest, &UnitQuaternion::identity(), &Vector3::new(0.1, 3.0, 0.2));
/// let mut memory = Dop853.start(&body, &at)?;
/// for _ in 0..2000 {
///     if let Some(shorter) = body.shortened(&at, None) {
///         memory = Dop853.turned(&body, &memory, &at, &shorter)?;
///         at = shorter;
///     }
///     let (step, next) = Dop853.step(&body, &memory, &at, 0.01)?;
///     (at, memory) = (step.to, next);
/// }
/// # let start = body.with_attitude_R(rest, &UnitQuaternion::identity(), &Vector3::new(0.1, 3.0, 0.2));
/// # let run = integrate(&body, Dop853, FixedStep::new(0.01), start).until(20.0).final_state()?;
/// # let apart = (body.attitude_R(&at).inverse() * body.attitude_R(&run)).imag().norm();
/// # assert!(apart < 1e-10, "{apart:e}");
/// # Ok::<(), Failure>(())
/// ```
///
/// A method that does not fit a system, or a controller, does not compile: [`Verlet`](splitting::Verlet) needs a
/// separable system, and adaptive steps an estimate of the error.
///
/// ```compile_fail,E0277
/// # use lagrange_runtime::prelude::*;
/// # struct Oscillator;
/// # impl System<1> for Oscillator {
/// #     type Scalar = f64;
/// #     fn accel(&self, q: &SVector<f64, 1>, _: &SVector<f64, 1>, _: f64) -> SVector<f64, 1> {
/// #         -q
/// #     }
/// # }
/// # let start = State::new(0.0, [1.0], [0.0]);
/// let run = integrate(&Oscillator, Rk4, PiController::tolerance(1e-6), start);
/// ```
///
/// ```compile_fail,E0277
/// # use lagrange_runtime::prelude::*;
/// # struct Oscillator;
/// # impl System<1> for Oscillator {
/// #     type Scalar = f64;
/// #     fn accel(&self, q: &SVector<f64, 1>, _: &SVector<f64, 1>, _: f64) -> SVector<f64, 1> {
/// #         -q
/// #     }
/// # }
/// # let start = State::new(0.0, [1.0], [0.0]);
/// let run = integrate(&Oscillator, Verlet, FixedStep::new(0.1), start);
/// ```
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a method for `{Sys}`",
    note = "coefficients such as `KahanLi8` make a method of a symmetric one: `Compose(Verlet, KahanLi8)`"
)]
pub trait Method<Sys: System<N>, const N: usize>: Sized {
    /// Memory that one step hands to the next.
    type MethodState: Clone + fmt::Debug;
    /// Values that a step computed on its way and of which its interpolant is made.
    type InterpolantData: Clone + fmt::Debug;
    /// The estimate of the local error: an [`ErrorEstimate`](crate::controller::ErrorEstimate), or
    /// [`NoEstimate`](crate::controller::NoEstimate).
    type Error: Clone + fmt::Debug;
    /// The interpolant of one step.
    type Interpolant: Interpolant<Sys::Scalar, N>;

    /// The order of convergence p: the global error is `O(hᵖ)`.
    fn order(&self) -> u32;

    /// The method as it serves a relative tolerance best, where it leaves that open, as
    /// [`Taylor`](const@taylor::Taylor) does its order. A run takes the tolerance from its controller.
    fn for_tolerance(self, relative: Option<f64>) -> Self {
        let _ = relative;
        self
    }

    /// Returns whether a step solves equations for its end. Stability then does not make steps short, as it does
    /// those of explicit methods on stiff systems, and a failure has other advice to give.
    fn implicit(&self) -> bool {
        false
    }

    /// The memory with which a run begins at `at`, also after any jump of the state.
    fn start(
        &self,
        system: &Sys,
        at: &State<Sys::Scalar, N>,
    ) -> Result<Self::MethodState, Failure<Sys::Scalar>>;

    /// The memory with which a run continues at `at`: the state `from`, whose memory is `memory`, by other parameters
    /// of its attitudes.
    fn turned(
        &self,
        system: &Sys,
        memory: &Self::MethodState,
        from: &State<Sys::Scalar, N>,
        at: &State<Sys::Scalar, N>,
    ) -> Result<Self::MethodState, Failure<Sys::Scalar>>
    where
        Sys::Scalar: Real,
    {
        let _ = (memory, from);
        self.start(system, at)
    }

    /// One step of size `h` (negative: backward in time) from `from`, whose memory is `memory`, and the memory of the
    /// step after it. A step may end earlier, where the equations switch. `h` is finite and not 0.
    fn step(
        &self,
        system: &Sys,
        memory: &Self::MethodState,
        from: &State<Sys::Scalar, N>,
        h: Sys::Scalar,
    ) -> Result<(Step<Sys, Self, N>, Self::MethodState), Failure<Sys::Scalar>> {
        let mut next = memory.clone();
        let step = self.step_into(system, memory, from, h, &mut next)?;
        Ok((step, next))
    }

    /// [`step`](Self::step) that writes the memory of the step after it to `next`, where it stays: it may be large. A
    /// step that fails leaves a memory that is not valid.
    fn step_into(
        &self,
        system: &Sys,
        memory: &Self::MethodState,
        from: &State<Sys::Scalar, N>,
        h: Sys::Scalar,
        next: &mut Self::MethodState,
    ) -> Result<Step<Sys, Self, N>, Failure<Sys::Scalar>>;

    /// Returns whether [`last_step`](Self::last_step) takes fewer evaluations than [`step`](Self::step).
    #[doc(hidden)]
    const HAS_LAST_STEP: bool = false;

    /// [`step`](Self::step) after which a motion goes on from [`start`](Self::start): it hands nothing on, and has no
    /// interpolant.
    #[doc(hidden)]
    fn last_step(
        &self,
        system: &Sys,
        memory: &Self::MethodState,
        from: &State<Sys::Scalar, N>,
        h: Sys::Scalar,
    ) -> Result<Step<Sys, Self, N>, Failure<Sys::Scalar>> {
        Ok(self.step(system, memory, from, h)?.0)
    }

    /// The interpolant of a step. It is computed on demand, since it may cost evaluations of its own, see
    /// [`interpolant_evaluations`](Self::interpolant_evaluations).
    fn interpolant(&self, system: &Sys, step: &Step<Sys, Self, N>) -> Self::Interpolant;

    /// [`start`](Self::start) near a state at which constraints are dependent.
    #[doc(hidden)]
    fn start_across(
        &self,
        across: &Across<'_, Sys, N>,
        at: &State<Sys::Scalar, N>,
    ) -> Result<Self::MethodState, Failure<Sys::Scalar>>
    where
        Sys::Scalar: Real,
    {
        self.start(across.system, at)
    }

    /// [`step`](Self::step) near a state at which constraints are dependent, and through it.
    #[doc(hidden)]
    fn step_across(
        &self,
        across: &Across<'_, Sys, N>,
        memory: &Self::MethodState,
        from: &State<Sys::Scalar, N>,
        h: Sys::Scalar,
        next: &mut Self::MethodState,
    ) -> Result<Step<Sys, Self, N>, Failure<Sys::Scalar>>
    where
        Sys::Scalar: Real,
    {
        self.step_into(across.system, memory, from, h, next)
    }

    /// [`interpolant`](Self::interpolant) of a [`step_across`](Self::step_across).
    #[doc(hidden)]
    fn interpolant_across(&self, across: &Across<'_, Sys, N>, step: &Step<Sys, Self, N>) -> Self::Interpolant
    where
        Sys::Scalar: Real,
    {
        self.interpolant(across.system, step)
    }

    /// The accelerations at both ends of a step, where the method has computed them: [events](crate::Run::events) then
    /// search its interpolant only in steps that may have a root.
    #[inline(always)]
    fn end_accelerations(&self, step: &Step<Sys, Self, N>) -> Option<[SVector<Sys::Scalar, N>; 2]> {
        let _ = step;
        None
    }

    /// A cheaper interpolant, if there is one, in which adaptive runs search for [switches](System::switches) after
    /// each step. Steps then land on the crossing, and no state of this interpolant is returned.
    #[inline(always)]
    fn coarse_interpolant(&self, system: &Sys, step: &Step<Sys, Self, N>) -> Option<Self::Interpolant> {
        let _ = (system, step);
        None
    }

    /// The evaluations of the equations of motion that this interpolant, by [`interpolant`](Self::interpolant) or
    /// [`coarse_interpolant`](Self::coarse_interpolant), took.
    fn interpolant_evaluations(&self, dense: &Self::Interpolant) -> u32 {
        let _ = dense;
        0
    }

    /// Number of equal parts into which [events](crate::Run::events) divide a step to search for roots, so that each
    /// part of the interpolant is smooth enough. `memory` is that of the start of the step, `h` its size.
    #[inline(always)]
    fn parts(&self, memory: &Self::MethodState, h: Sys::Scalar) -> u32 {
        let _ = (memory, h);
        self.order().clamp(8, 15)
    }

    /// Returns whether the method itself ends its steps at the [switches](System::switches) of the system. Adaptive
    /// runs do it for other methods.
    fn ends_at_switches(&self) -> bool {
        false
    }

    /// The evaluations of the equations of motion that [`start`](Self::start) makes.
    fn start_evaluations(&self) -> u32 {
        1
    }
}

/// One step of a method.
pub struct Step<Sys: System<N>, M: Method<Sys, N>, const N: usize> {
    /// State at which it began.
    pub from: State<Sys::Scalar, N>,
    /// State to which it led.
    pub to: State<Sys::Scalar, N>,
    /// Its size in time.
    pub h: Sys::Scalar,
    /// Its estimated local error.
    pub error: M::Error,
    /// Values of which its interpolant is made.
    pub stages: M::InterpolantData,
    /// Number of evaluations of the equations of motion.
    pub evaluations: u32,
}

impl<Sys: System<N>, M: Method<Sys, N>, const N: usize> Clone for Step<Sys, M, N> {
    fn clone(&self) -> Self {
        Step {
            from: self.from,
            to: self.to,
            h: self.h,
            error: self.error.clone(),
            stages: self.stages.clone(),
            evaluations: self.evaluations,
        }
    }
}

impl<Sys: System<N>, M: Method<Sys, N>, const N: usize> fmt::Debug for Step<Sys, M, N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Step")
            .field("from", &self.from)
            .field("to", &self.to)
            .field("h", &self.h)
            .field("error", &self.error)
            .field("stages", &self.stages)
            .field("evaluations", &self.evaluations)
            .finish()
    }
}

/// An interpolant of one step.
pub trait Interpolant<S: Scalar, const N: usize> {
    /// The state at time `t` between the ends of the step; outside of them an extrapolation.
    fn at(&self, t: S) -> State<S, N>;
}
