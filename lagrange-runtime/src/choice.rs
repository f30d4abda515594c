//! The method for a system and a goal, by what the compiler found out about the system; public as
//! [`method::choice`](crate::method::choice). (It makes runs, which no method knows, so it is no file of methods.)

use crate::controller::{Controller, ErrorEstimate, FixedStep, PiController};
use crate::event::{EventSet, Occurrence};
use crate::failed::Failed;
use crate::failure::Failure;
use crate::integrate::{Run, Statistics, integrate};
use crate::method::Method;
use crate::method::explicit_rk::{Dop853, DormandPrince5, Verner9};
use crate::method::gauss::Gauss4;
use crate::method::modal::MatrixExponential;
use crate::method::nystrom::Nystrom12;
use crate::method::radau::Radau5;
use crate::method::rosenbrock::Rodas5P;
use crate::method::splitting::BlanesMoan4;
use crate::method::taylor::{Taylor, TaylorController};
use crate::scalar::Real;
use crate::state::State;
use crate::system::{Lagrangian, System};
use core::fmt;

/// Goals of a run.
pub mod goal {
    /// A trajectory whose local errors stay below this tolerance, absolute (in the units of each component of q and q̇)
    /// and relative.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct Accuracy(pub f64);

    /// Energy and the other invariants bounded over long times, in equal steps of at most this size, in units of t.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct LongTime<S = f64>(pub S);

    /// Variant of [`Accuracy`] for a system that may have much faster rates than those of its motion.
    ///
    /// Stiffness has to be declared: the compiler's proofs hold for all parameters, whose values make a system stiff,
    /// and a Jacobian at the start would not show later rates. A run by `Accuracy` of a stiff system is not wrong but
    /// long, and ends in [`Failure::BudgetUsedUp`](crate::Failure::BudgetUsedUp), which advises this.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct Stiff(pub f64);
}

/// Row of the table of methods.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Recommendation {
    /// The goal.
    pub wanted: &'static str,
    /// The systems.
    pub system: &'static str,
    /// Name of the method.
    pub method: &'static str,
    /// Constructor of its controller, for a tolerance or a step.
    pub controller: &'static str,
    /// The reason, as a part of a sentence that begins with "because".
    pub why: &'static str,
}

/// The row as it stands on the front page of this crate.
impl fmt::Display for Recommendation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "| {} | {} | [`{}`] | {} |", self.wanted, self.system, self.method, self.why)
    }
}

/// A method of the table.
pub trait Offered: Copy {
    /// The method.
    const METHOD: Self;
    /// Its row.
    const RECOMMENDATION: Recommendation;
}

macro_rules! table {
    ($($method:ident = $value:expr, $controller:literal; $wanted:literal, $system:literal, $why:literal;)*) => {
        $(impl Offered for $method {
            const METHOD: Self = $value;
            const RECOMMENDATION: Recommendation = Recommendation {
                wanted: $wanted, system: $system, method: stringify!($method), controller: $controller, why: $why
            };
        })*

        /// The table of methods.
        pub const RECOMMENDATIONS: &[Recommendation] = &[$(<$method as Offered>::RECOMMENDATION),*];
    };
}

table! {
    DormandPrince5 = DormandPrince5, "PiController::tolerance";
        "`Accuracy`, 1e-5 or coarser", "any", "at coarse tolerances order 5 has the fewest evaluations";
    Taylor = Taylor::LONGEST_USUAL, "TaylorController::tolerance";
        "`Accuracy`, 1e-10 or finer, with constraints 1e-13 or finer", "analytic",
        "series of order 20 take 0.3 to 1.4 of the time of orders 9 and 12 there, mostly less, and lose fewer of the last digits";
    Nystrom12 = Nystrom12, "PiController::tolerance";
        "`Accuracy`", "separable",
        "without velocities in the forces order 12 takes two thirds of the evaluations of order 8";
    Verner9 = Verner9, "PiController::tolerance";
        "`Accuracy`", "any other",
        "order 9 is as quick as order 8 at 1e-6, takes three quarters of its time for the last digits, and has smaller errors";
    MatrixExponential = MatrixExponential, "FixedStep::new";
        "`LongTime`", "linear, conservative", "it is exact at any step";
    BlanesMoan4 = BlanesMoan4, "FixedStep::new";
        "`LongTime`", "separable",
        "it is symplectic, explicit since T(q̇) + V(q) splits, and far better than Verlet at a sixth of the step";
    Gauss4 = Gauss4, "FixedStep::new";
        "`LongTime`", "L quadratic in q̇, no constraints, no rotations",
        "it is symplectic for every Lagrangian with momenta";
    Dop853 = Dop853, "FixedStep::new";
        "`LongTime`", "any other",
        "no method bounds the energy without velocities from momenta; of attitudes order 8 errs least";
    Rodas5P = Rodas5P, "PiController::tolerance";
        "`Stiff`, 1e-7 or coarser", "any", "its steps do not follow the fastest rates, and need no iteration";
    Radau5 = Radau5, "PiController::tolerance";
        "`Stiff`", "any", "its steps do not follow the fastest rates, and its errors are the smaller ones";
}

/// Adaptive controller that needs nothing but a tolerance.
pub trait Adaptive: Clone + fmt::Debug {
    /// Controller for this tolerance, absolute and relative.
    fn with_tolerance(tolerance: f64) -> Self;
}

impl Adaptive for PiController {
    fn with_tolerance(tolerance: f64) -> Self {
        PiController::tolerance(tolerance)
    }
}

impl Adaptive for TaylorController {
    fn with_tolerance(tolerance: f64) -> Self {
        TaylorController::tolerance(tolerance)
    }
}

/// The methods of the table for one system. Emitted for every `lagrangian!` system.
///
/// ```
/// use lagrange_runtime::method::choice::RecommendedMethods;
/// use lagrange_runtime::prelude::*;
///
/// /// The drift of the energy in equal steps.
/// fn drift<Sys: RecommendedMethods<N, Scalar = f64>, const N: usize>(system: &Sys, start: State<f64, N>, end: f64) -> Result<f64, Failure> {
///     let last = method_for(system, goal::LongTime(1e-2)).integrate(start).until(end).final_state()?;
///     Ok(system.energy_function_at(&last) - system.energy_function_at(&start))
/// }
/// # lagrangian! {
/// #     system Oscillator {
/// #         coord x;
/// #         T = 0.5 * dot(x).powi(2);
/// #         V = 0.5 * x.powi(2);
/// #     }
/// # }
/// assert!(drift(&Oscillator::new(), State::new(0.0, [1.0], [0.0]), 10.0)?.abs() < 1e-13);
/// # Ok::<(), Failure>(())
/// ```
#[diagnostic::on_unimplemented(
    message = "no methods are chosen for `{Self}`",
    note = "systems made by `lagrangian! {{ … }}` have them; implement `method::choice::RecommendedMethods` for a type of your own, or name a method"
)]
pub trait RecommendedMethods<const N: usize>: Lagrangian<N, Scalar: Real> + Sized {
    /// The method for [`goal::Accuracy`], but for coarse tolerances and fine ones.
    type Accurate: Offered + Method<Self, N, Error: ErrorEstimate<Self::Scalar, N>>;
    /// The method for the last digits.
    type Fine: Offered + Method<Self, N>;
    /// The step-size controller of [`Fine`](Self::Fine).
    type FineControl: Adaptive + Controller<Self::Scalar, N, <Self::Fine as Method<Self, N>>::Error>;
    /// The method for [`goal::LongTime`].
    type Geometric: Offered + Method<Self, N>;
}

/// A decision between types.
pub trait Decision {
    /// `A` where it holds, else `B`.
    type Then<A, B>;
}

/// A fact that is known at compile time.
#[derive(Debug)]
pub struct Fact<const HOLDS: bool>;

impl Decision for Fact<true> {
    type Then<A, B> = A;
}

impl Decision for Fact<false> {
    type Then<A, B> = B;
}

/// The first of two types if a fact holds.
type If<const HOLDS: bool, A, B> = <Fact<HOLDS> as Decision>::Then<A, B>;

/// [`RecommendedMethods::Accurate`] by facts.
pub type Accurate<const SEPARABLE: bool> = If<SEPARABLE, Nystrom12, Verner9>;

/// [`RecommendedMethods::Fine`] by facts.
pub type Fine<const ANALYTIC: bool, const SEPARABLE: bool> = If<ANALYTIC, Taylor, Accurate<SEPARABLE>>;

/// [`RecommendedMethods::FineControl`] by facts.
pub type FineControl<const ANALYTIC: bool> = If<ANALYTIC, TaylorController, PiController>;

/// [`RecommendedMethods::Geometric`] by facts: linear and conservative, separable, momenta of independent coordinates
/// that are no attitudes.
pub type Geometric<const EXACT: bool, const SEPARABLE: bool, const MOMENTA: bool> =
    If<EXACT, MatrixExponential, If<SEPARABLE, BlanesMoan4, If<MOMENTA, Gauss4, Dop853>>>;

/// Goal of a run of a system: [`goal::Accuracy`], [`goal::LongTime`] or [`goal::Stiff`].
pub trait Goal<Sys: RecommendedMethods<N>, const N: usize>: Copy {
    /// The run.
    type Run<'a>
    where
        Sys: 'a;

    /// The row of the table.
    fn row(self) -> Recommendation;

    /// The tolerance, or the step.
    fn given(&self) -> &dyn fmt::Debug;

    /// Integrates `system` from `start`.
    fn integrate(self, system: &Sys, start: State<Sys::Scalar, N>) -> Self::Run<'_>;
}

/// Variant of [`RecommendedRun`].
enum Grade {
    Coarse,
    Usual,
    Fine,
}

impl goal::Accuracy {
    fn grade<Sys: RecommendedMethods<N>, const N: usize>(self) -> Grade {
        let fine = if Sys::FACTS.constraints.is_empty() { 1e-10 } else { 1e-13 };
        // (A tolerance that is not a number is refused by the run.)
        match self.0 {
            tolerance if tolerance >= 1e-5 => Grade::Coarse,
            tolerance if Sys::FACTS.analytic && tolerance <= fine => Grade::Fine,
            _ => Grade::Usual,
        }
    }
}

impl<Sys: RecommendedMethods<N>, const N: usize> Goal<Sys, N> for goal::Accuracy {
    type Run<'a>
        = RecommendedRun<'a, Sys, DormandPrince5, Sys::Accurate, Sys::Fine, Sys::FineControl, N>
    where
        Sys: 'a;

    fn row(self) -> Recommendation {
        match self.grade::<Sys, N>() {
            Grade::Coarse => DormandPrince5::RECOMMENDATION,
            Grade::Usual => Sys::Accurate::RECOMMENDATION,
            Grade::Fine => Sys::Fine::RECOMMENDATION,
        }
    }

    fn given(&self) -> &dyn fmt::Debug {
        &self.0
    }

    fn integrate(self, system: &Sys, start: State<Sys::Scalar, N>) -> Self::Run<'_> {
        let pi = PiController::tolerance(self.0);
        match self.grade::<Sys, N>() {
            Grade::Coarse => RecommendedRun::Coarse(integrate(system, DormandPrince5, pi, start)),
            Grade::Usual => RecommendedRun::Usual(integrate(system, Sys::Accurate::METHOD, pi, start)),
            Grade::Fine => {
                let control = Sys::FineControl::with_tolerance(self.0);
                RecommendedRun::Fine(integrate(system, Sys::Fine::METHOD, control, start))
            }
        }
    }
}

impl<S, Sys: RecommendedMethods<N, Scalar = S>, const N: usize> Goal<Sys, N> for goal::LongTime<S>
where
    S: Real,
{
    type Run<'a>
        = Run<'a, Sys, Sys::Geometric, FixedStep<S>, N>
    where
        Sys: 'a;

    fn row(self) -> Recommendation {
        Sys::Geometric::RECOMMENDATION
    }

    fn given(&self) -> &dyn fmt::Debug {
        &self.0
    }

    fn integrate(self, system: &Sys, start: State<S, N>) -> Self::Run<'_> {
        integrate(system, Sys::Geometric::METHOD, FixedStep::new(self.0), start)
    }
}

impl goal::Stiff {
    fn is_coarse(self) -> bool {
        self.0 >= 1e-7
    }
}

impl<Sys: RecommendedMethods<N>, const N: usize> Goal<Sys, N> for goal::Stiff {
    type Run<'a>
        = RecommendedRun<'a, Sys, Rodas5P, Radau5, Radau5, PiController, N>
    where
        Sys: 'a;

    fn row(self) -> Recommendation {
        if self.is_coarse() { Rodas5P::RECOMMENDATION } else { Radau5::RECOMMENDATION }
    }

    fn given(&self) -> &dyn fmt::Debug {
        &self.0
    }

    fn integrate(self, system: &Sys, start: State<Sys::Scalar, N>) -> Self::Run<'_> {
        let pi = PiController::tolerance(self.0);
        match self.is_coarse() {
            true => RecommendedRun::Coarse(integrate(system, Rodas5P, pi, start)),
            false => RecommendedRun::Usual(integrate(system, Radau5, pi, start)),
        }
    }
}

/// The method and controller for a system and a goal, and why. It is shown as a sentence.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Recommended<'a, Sys, A, const N: usize> {
    system: &'a Sys,
    goal: A,
    /// Row of the table.
    pub row: Recommendation,
}

/// The method and controller for a system and a goal. It takes no time: the facts are constants.
///
/// ```
/// use lagrange_runtime::prelude::*;
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
/// let choice = method_for(&pendulum, goal::LongTime(1e-3));
/// assert_eq!(
///     choice.to_string(),
///     "BlanesMoan4 with FixedStep::new(0.001), because it is symplectic, explicit since T(q̇) + V(q) splits, \
///      and far better than Verlet at a sixth of the step"
/// );
/// let end = choice.integrate(start).until(100.0).final_state()?;
/// # let _ = end;
/// # Ok::<(), Failure>(())
/// ```
pub fn method_for<Sys: RecommendedMethods<N>, A: Goal<Sys, N>, const N: usize>(
    system: &Sys,
    goal: A,
) -> Recommended<'_, Sys, A, N> {
    Recommended { system, goal, row: goal.row() }
}

impl<'a, Sys: RecommendedMethods<N>, A: Goal<Sys, N>, const N: usize> Recommended<'a, Sys, A, N> {
    /// Integrates the system from `start`, as [`integrate`](crate::integrate()) does.
    pub fn integrate(self, start: State<Sys::Scalar, N>) -> A::Run<'a> {
        self.goal.integrate(self.system, start)
    }
}

impl<Sys: RecommendedMethods<N>, A: Goal<Sys, N>, const N: usize> fmt::Display
    for Recommended<'_, Sys, A, N>
{
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Recommendation { method, controller, why, .. } = self.row;
        write!(f, "{method} with {controller}({:?}), because {why}", self.goal.given())
    }
}

/// Run by one of the methods that a goal leaves to choose from by its tolerance: each variant is a [`Run`] of its own
/// type.
///
/// `match` gives the run itself, for what needs more than the functions here: every step with its interpolant,
/// restarts at events.
#[derive(Clone, Debug)]
pub enum RecommendedRun<'a, Sys, A, B, C, D, const N: usize>
where
    Sys: System<N>,
    A: Method<Sys, N>,
    B: Method<Sys, N>,
    C: Method<Sys, N>,
{
    /// At coarse tolerances.
    Coarse(Run<'a, Sys, A, PiController, N>),
    /// At most tolerances.
    Usual(Run<'a, Sys, B, PiController, N>),
    /// At fine tolerances, if another method is the better one there.
    Fine(Run<'a, Sys, C, D, N>),
}

/// The same for each variant, with the result in the variant of that name, or without one.
macro_rules! each {
    ($self:expr, $run:ident => $then:ident($what:expr)) => {
        match $self {
            RecommendedRun::Coarse($run) => $then::Coarse($what),
            RecommendedRun::Usual($run) => $then::Usual($what),
            RecommendedRun::Fine($run) => $then::Fine($what),
        }
    };
    ($self:expr, $run:ident => $what:expr) => {
        match $self {
            RecommendedRun::Coarse($run) => $what,
            RecommendedRun::Usual($run) => $what,
            RecommendedRun::Fine($run) => $what,
        }
    };
}

impl<S, Sys, A, B, C, D, const N: usize> RecommendedRun<'_, Sys, A, B, C, D, N>
where
    S: Real,
    Sys: System<N, Scalar = S>,
    A: Method<Sys, N, Error: ErrorEstimate<S, N>>,
    B: Method<Sys, N, Error: ErrorEstimate<S, N>>,
    C: Method<Sys, N>,
    D: Controller<S, N, C::Error>,
{
    /// Sets the end, as [`Run::until`] does.
    #[must_use]
    pub fn until(self, end: S) -> Self {
        each!(self, run => RecommendedRun(run.until(end)))
    }

    /// Limits the number of steps, as [`Run::max_steps`] does.
    #[must_use]
    pub fn max_steps(self, max_steps: u64) -> Self {
        each!(self, run => RecommendedRun(run.max_steps(max_steps)))
    }

    /// The state reached so far.
    pub fn state(&self) -> &State<S, N> {
        each!(self, run => run.state())
    }

    /// The cost so far.
    pub fn statistics(&self) -> Statistics {
        each!(self, run => run.statistics())
    }

    /// Runs to the end and gives the state there, as [`Run::final_state`] does.
    ///
    /// # Errors
    /// The failure that ended the run, or [`Failure::BadEnd`] without an end.
    pub fn final_state(self) -> Result<State<S, N>, Failed<S, N>> {
        each!(self, run => run.final_state())
    }

    /// Runs to the end, as [`Run::run_to_end`] does.
    ///
    /// # Errors
    /// As [`final_state`](Self::final_state).
    pub fn run_to_end(&mut self) -> Result<(), Failed<S, N>> {
        each!(self, run => run.run_to_end())
    }

    /// The ends of accepted steps.
    pub fn states(self) -> impl Iterator<Item = Result<State<S, N>, Failure<S>>> {
        each!(self, run => Each(run.map(|step| step.map(|step| step.to))))
    }

    /// The states at given times, by [`Run::sample`].
    pub fn sample<T: IntoIterator<Item = S>>(
        self,
        times: T,
    ) -> impl Iterator<Item = Result<State<S, N>, Failure<S>>> {
        each!(self, run => Each(run.sample(times)))
    }

    /// The states at equally spaced times, by [`Run::sample_evenly`].
    pub fn sample_evenly(self, n: u32) -> impl Iterator<Item = Result<State<S, N>, Failure<S>>> {
        each!(self, run => Each(run.sample_evenly(n)))
    }

    /// The events up to the first terminal one, by [`Run::events`].
    pub fn events<E: EventSet<Sys, N, K>, const K: usize>(
        self,
        events: E,
    ) -> impl Iterator<Item = Result<Occurrence<S, N>, Failure<S>>> {
        each!(self, run => Each(run.events(events)))
    }
}

/// Iterator of one of the variants.
enum Each<A, B, C> {
    Coarse(A),
    Usual(B),
    Fine(C),
}

impl<A, B, C> Iterator for Each<A, B, C>
where
    A: Iterator,
    B: Iterator<Item = A::Item>,
    C: Iterator<Item = A::Item>,
{
    type Item = A::Item;

    fn next(&mut self) -> Option<A::Item> {
        match self {
            Each::Coarse(of) => of.next(),
            Each::Usual(of) => of.next(),
            Each::Fine(of) => of.next(),
        }
    }
}

/// The state at the time `end` of a system that is at `start`, to a tolerance per step, absolute (in the units of each
/// component of q and q̇) and relative: [`method_for`]
/// with [`goal::Accuracy`], run to the end.
///
/// # Errors
/// The failure that ended the run, with the last good state.
///
/// ```
/// use lagrange_runtime::prelude::*;
///
/// lagrangian! {
///     system Oscillator {
///         param m, k;
///         coord x;
///         T = 0.5 * m * dot(x).powi(2);
///         V = 0.5 * k * x.powi(2);
///     }
/// }
/// let end = simulate(&Oscillator::new(1.0, 4.0), State::new(0.0, [1.0], [0.0]), 10.0, 1e-9)?;
/// assert!((end.q[0] - 20f64.cos()).abs() < 1e-7);
/// # Ok::<(), Failure>(())
/// ```
pub fn simulate<Sys: RecommendedMethods<N>, const N: usize>(
    system: &Sys,
    start: State<Sys::Scalar, N>,
    end: Sys::Scalar,
    tolerance: f64,
) -> Result<State<Sys::Scalar, N>, Failed<Sys::Scalar, N>> {
    method_for(system, goal::Accuracy(tolerance)).integrate(start).until(end).final_state()
}
