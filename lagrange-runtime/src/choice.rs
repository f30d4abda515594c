//! A method for those who do not want to choose one: from what the compiler found out about the system, and from what
//! is wanted of the run.
//!
//! The decision is a table, [`ROWS`], of which the first row that fits is taken; the front page of this crate shows it.
//! A new method is a row here and a line in [`any`].

use crate::controller::{Fixed, Pi};
use crate::integrate::{Run, integrate};
use crate::method::taylor::Decay;
use crate::sample::Failed;
use crate::scalar::Real;
use crate::state::State;
use crate::system::{Facts, Lagrangian};
use any::{AnyController, AnyMethod};
use core::fmt;

pub mod any;

/// What is wanted of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Aim<S = f64> {
    /// A trajectory whose local errors stay below this tolerance, absolute and relative.
    Accuracy(f64),
    /// Energy and the other invariants bounded over long times, in equal steps of at most this size.
    LongTime(S),
    /// As `Accuracy`, of a system that may have much faster rates than those of its motion.
    ///
    /// It has to be said: what the compiler proves holds for all parameters, and none makes a system stiff; and the rates
    /// at the start, which a Jacobian would tell, say nothing about later ones. A run by `Accuracy` of a stiff system is
    /// not wrong but long, and ends in [`Failure::BudgetUsedUp`](crate::Failure::BudgetUsedUp), which advises this.
    Stiff(f64),
}

/// A row of the table: when it fits, what it says, and why.
pub struct Row {
    aim: fn(&Aim<f64>) -> bool,
    fits: fn(&Facts) -> bool,
    method: AnyMethod,
    /// The columns of the table in words: what is wanted, of what system, and why this method.
    wanted: &'static str,
    system: &'static str,
    why: &'static str,
}

/// The row as it stands on the front page of this crate.
impl fmt::Display for Row {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "| {} | {} | [`{:?}`] | {} |", self.wanted, self.system, self.method, self.why)
    }
}

/// The table of decisions: the first row that fits is taken.
pub const ROWS: &[Row] = &[
    Row {
        aim: |aim| matches!(aim, Aim::Accuracy(tolerance) if *tolerance >= 1e-5),
        fits: |_| true,
        method: AnyMethod::DormandPrince5,
        wanted: "`Accuracy`, 1e-5 or coarser",
        system: "any",
        why: "at coarse tolerances order 5 has the fewest evaluations",
    },
    Row {
        aim: |aim| matches!(aim, Aim::Accuracy(tolerance) if *tolerance <= 1e-10),
        fits: |facts| facts.analytic && facts.constraints.is_empty(),
        method: AnyMethod::Taylor,
        wanted: "`Accuracy`, 1e-10 or finer",
        system: "analytic, no constraints",
        why: "series of order 20 take 0.3 to 1.4 of the time of orders 9 and 12 there, mostly less, and lose fewer of the last digits",
    },
    Row {
        aim: |aim| matches!(aim, Aim::Accuracy(tolerance) if *tolerance <= 1e-13),
        fits: |facts| facts.analytic,
        method: AnyMethod::Taylor,
        wanted: "`Accuracy`, 1e-13 or finer",
        system: "analytic",
        why: "series lose fewer of the last digits",
    },
    Row {
        aim: |aim| matches!(aim, Aim::Accuracy(_)),
        fits: |facts| facts.separable,
        method: AnyMethod::Nystrom12,
        wanted: "`Accuracy`",
        system: "separable",
        why: "without velocities in the forces order 12 takes two thirds of the evaluations of order 8",
    },
    Row {
        aim: |aim| matches!(aim, Aim::Accuracy(_)),
        fits: |_| true,
        method: AnyMethod::Verner9,
        wanted: "`Accuracy`",
        system: "any other",
        why: "order 9 is as quick as order 8 at 1e-6, takes three quarters of its time for the last digits, and has smaller errors",
    },
    Row {
        aim: |aim| matches!(aim, Aim::LongTime(_)),
        // A conservative system has no force of time, with which the equations could be linear, too.
        fits: |facts| facts.linear && facts.conservative,
        method: AnyMethod::Modal,
        wanted: "`LongTime`",
        system: "linear, conservative",
        why: "it is exact at any step",
    },
    Row {
        aim: |aim| matches!(aim, Aim::LongTime(_)),
        fits: |facts| facts.separable,
        method: AnyMethod::BlanesMoan4,
        wanted: "`LongTime`",
        system: "separable",
        why: "it is symplectic, explicit since T(q̇) + V(q) splits, and far better than Verlet at a sixth of the step",
    },
    Row {
        aim: |aim| matches!(aim, Aim::LongTime(_)),
        fits: |facts| facts.quadratic && facts.constraints.is_empty(),
        method: AnyMethod::Gauss4,
        wanted: "`LongTime`",
        system: "L quadratic in q̇, no constraints",
        why: "it is symplectic for every Lagrangian with momenta",
    },
    Row {
        aim: |aim| matches!(aim, Aim::LongTime(_)),
        fits: |_| true,
        method: AnyMethod::Dop853,
        wanted: "`LongTime`",
        system: "any other",
        why: "without velocities from momenta no method keeps the structure; order 8 drifts least",
    },
    Row {
        aim: |aim| matches!(aim, Aim::Stiff(tolerance) if *tolerance >= 1e-7),
        fits: |_| true,
        method: AnyMethod::Rodas5P,
        wanted: "`Stiff`, 1e-7 or coarser",
        system: "any",
        why: "its steps do not follow the fastest rates, and need no iteration",
    },
    Row {
        aim: |aim| matches!(aim, Aim::Stiff(_)),
        fits: |_| true,
        method: AnyMethod::Radau5,
        wanted: "`Stiff`",
        system: "any",
        why: "its steps do not follow the fastest rates, and its errors are the smaller ones",
    },
];

/// A method and a controller that have been chosen, and why. It is shown as a sentence.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Choice<S = f64> {
    /// The method.
    pub method: AnyMethod,
    /// The controller.
    pub controller: AnyController<S>,
    /// What was wanted.
    pub aim: Aim<S>,
    /// Why, as a part of a sentence that begins with "because".
    pub why: &'static str,
}

/// The method and controller for a system and an aim. It takes no time: the facts are constants.
///
/// ```
/// use lagrange_runtime::prelude::*;
/// use lagrange_runtime::{Aim, method_for};
///
/// lagrangian! {
///     system Pendulum {
///         param m, l, g = 9.81;
///         coord theta;
///         T = 0.5 * m * (l * dot(theta)).powi(2);
///         V = -m * g * l * cos(theta);
///     }
/// }
/// let (pendulum, start) = (Pendulum::new(1.0, 0.85), State::new(0.0, [1.0], [0.0]));
/// let choice = method_for(&pendulum, Aim::LongTime(1e-3));
/// assert_eq!(
///     choice.to_string(),
///     "BlanesMoan4 with Fixed::new(0.001), because it is symplectic, explicit since T(q̇) + V(q) splits, \
///      and far better than Verlet at a sixth of the step"
/// );
/// let end = choice.integrate(&pendulum, start).until(100.0).finish()?;
/// # let _ = end;
/// # Ok::<(), Failure>(())
/// ```
pub fn method_for<Sys: Lagrangian<N>, const N: usize>(
    _system: &Sys,
    aim: Aim<Sys::Scalar>,
) -> Choice<Sys::Scalar>
where
    Sys::Scalar: Real,
{
    choose(&Sys::FACTS, aim)
}

fn choose<S: Real>(facts: &Facts, aim: Aim<S>) -> Choice<S> {
    let plain = match aim {
        Aim::Accuracy(tolerance) => Aim::Accuracy(tolerance),
        Aim::LongTime(h) => Aim::LongTime(h.to_f64()),
        Aim::Stiff(tolerance) => Aim::Stiff(tolerance),
    };
    // Every aim ends in a row that fits any system.
    let row = ROWS.iter().find(|row| (row.aim)(&plain) && (row.fits)(facts));
    let (method, why) = row.map_or((AnyMethod::Dop853, "it fits every system"), |row| (row.method, row.why));
    let controller = match aim {
        Aim::LongTime(h) => AnyController::Fixed(Fixed::new(h)),
        Aim::Accuracy(tolerance) if method == AnyMethod::Taylor => {
            AnyController::Decay(Decay::tolerance(tolerance))
        }
        Aim::Accuracy(tolerance) | Aim::Stiff(tolerance) => AnyController::Pi(Pi::tolerance(tolerance)),
    };
    Choice { method, controller, aim, why }
}

impl<S: Real> Choice<S> {
    /// Integrates `system` from `start`, as [`integrate`](crate::integrate()) does.
    pub fn integrate<Sys, const N: usize>(
        self,
        system: &Sys,
        start: State<S, N>,
    ) -> Run<'_, Sys, AnyMethod, AnyController<S>, N>
    where
        Sys: Lagrangian<N, Scalar = S>,
    {
        integrate(system, self.method, self.controller, start)
    }
}

impl<S: fmt::Debug> fmt::Display for Choice<S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Choice { method, controller, aim, why } = self;
        let constructor = match controller {
            AnyController::Fixed(_) => "Fixed::new",
            AnyController::Pi(_) => "Pi::tolerance",
            AnyController::Decay(_) => "Decay::tolerance",
        };
        let given: &dyn fmt::Debug = match aim {
            Aim::LongTime(h) => h,
            Aim::Accuracy(tolerance) | Aim::Stiff(tolerance) => tolerance,
        };
        write!(f, "{method:?} with {constructor}({given:?}), because {why}")
    }
}

/// The state at `until` of a system that is at `start`, to a tolerance of 1e-9 per step: [`method_for`] with
/// [`Aim::Accuracy`], run to the end.
///
/// ```
/// use lagrange_runtime::prelude::*;
/// use lagrange_runtime::simulate;
///
/// lagrangian! {
///     system Oscillator {
///         param m, k;
///         coord x;
///         T = 0.5 * m * dot(x).powi(2);
///         V = 0.5 * k * x.powi(2);
///     }
/// }
/// let end = simulate(&Oscillator::new(1.0, 4.0), State::new(0.0, [1.0], [0.0]), 10.0)?;
/// assert!((end.q[0] - 20f64.cos()).abs() < 1e-7);
/// # Ok::<(), Failure>(())
/// ```
pub fn simulate<Sys: Lagrangian<N>, const N: usize>(
    system: &Sys,
    start: State<Sys::Scalar, N>,
    until: Sys::Scalar,
) -> Result<State<Sys::Scalar, N>, Failed<Sys::Scalar, N>>
where
    Sys::Scalar: Real,
{
    method_for(system, Aim::Accuracy(1e-9)).integrate(system, start).until(until).finish()
}

#[cfg(test)]
mod tests;
